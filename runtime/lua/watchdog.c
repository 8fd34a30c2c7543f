/* The watchdog's thread and its signal. See watchdog.h. */
#include "lua/watchdog.h"

#include "common/stop.h"
#include "common/util.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

enum {
    ASK_MS = 20,    /* between two questions: Esc is to work within 100 ms */
    SIGNAL_MS = 5,  /* between two signals: a coroutine may have ended since the last */
    STATE_BITS = 2, /* of `section`: a watchdog_state below the section's number */
    STATE_MASK = 3
};

struct watchdog {
    watchdog_def def;
    pthread_t thread, watched;
    int wake[2]; /* a pipe: one byte ends the thread */
    _Atomic uint64_t section, began_ns, limit_ns;
    const char *_Atomic name;
    uint64_t stopped_ns, patience_ns; /* of the watchdog's thread: since when the section is to stop, and how long */
};

/* The watchdog of the section that runs on this thread, for the signal handler. */
static _Thread_local watchdog *_Atomic active;

static watchdog_state state_of(uint64_t section) { return (watchdog_state)(section & STATE_MASK); }

watchdog_state watchdog_look(const watchdog *dog) { return state_of(atomic_load(&dog->section)); }

double watchdog_limit(const watchdog *dog) { return (double)atomic_load(&dog->limit_ns) / 1e9; }

static void on_signal(int unused)
{
    (void)unused;
    const watchdog *dog = atomic_load(&active);
    if (dog && watchdog_look(dog) > WATCHDOG_RUNNING) dog->def.interrupt(dog->def.user);
}

/* ---- sections ---- */

void watchdog_begin(watchdog *dog, const char *name, double factor)
{
    uint64_t number = (atomic_load(&dog->section) >> STATE_BITS) + 1;
    atomic_store_explicit(&dog->name, name, memory_order_relaxed);
    atomic_store_explicit(&dog->limit_ns, (uint64_t)(dog->def.seconds * factor * 1e9), memory_order_relaxed);
    atomic_store_explicit(&dog->began_ns, clock_now_ns(), memory_order_relaxed);
    atomic_store_explicit(&active, dog, memory_order_relaxed);
    atomic_store_explicit(&dog->section, number << STATE_BITS | WATCHDOG_RUNNING, memory_order_release);
}

watchdog_state watchdog_end(watchdog *dog)
{
    uint64_t section = atomic_load(&dog->section) & ~(uint64_t)STATE_MASK;
    watchdog_state state = state_of(atomic_exchange(&dog->section, section));
    atomic_store_explicit(&active, NULL, memory_order_relaxed);
    return state;
}

/* ---- the thread ---- */

static void stop_section(watchdog *dog, uint64_t section, watchdog_state why, uint64_t now, uint64_t patience_ns)
{
    uint64_t stopped = (section & ~(uint64_t)STATE_MASK) | why;
    if (!atomic_compare_exchange_strong(&dog->section, &section, stopped)) return; /* it has just ended */
    dog->stopped_ns = now;
    dog->patience_ns = patience_ns;
}

static void end_program(const watchdog *dog, watchdog_state why, uint64_t now)
{
    char message[300];
    if (why == WATCHDOG_ASKED) stop_program(STATUS_DONE, NULL);
    snprintf(message, sizeof message, "%s ran for %.1f s and could not be stopped: the game ends here",
             atomic_load(&dog->name), (double)(now - atomic_load(&dog->began_ns)) / 1e9);
    stop_program(STATUS_BAD_INPUT, message);
}

static uint64_t less(uint64_t a, uint64_t b) { return a < b ? a : b; }

/* Stops the section that runs if it is time. Returns for how many nanoseconds nothing can happen. */
static uint64_t watch_section(watchdog *dog, uint64_t section, uint64_t now)
{
    uint64_t began = atomic_load(&dog->began_ns), limit = atomic_load(&dog->limit_ns);
    uint64_t ran = now > began ? now - began : 0;
    if (ran >= limit) {
        stop_section(dog, section, WATCHDOG_LATE, now, less(limit, (uint64_t)(WATCHDOG_PATIENCE * 1e9)));
        return 0;
    }
    int patience_ms = dog->def.asked ? dog->def.asked(dog->def.asker) : 0;
    if (patience_ms > 0) {
        stop_section(dog, section, WATCHDOG_ASKED, now, (uint64_t)patience_ms * 1000000u);
        return 0;
    }
    return dog->def.asked ? less(limit - ran, ASK_MS * 1000000u) : limit - ran;
}

static uint64_t watch(watchdog *dog)
{
    uint64_t section = atomic_load_explicit(&dog->section, memory_order_acquire), now = clock_now_ns();
    watchdog_state state = state_of(section);
    if (state == WATCHDOG_RUNNING) return watch_section(dog, section, now);
    if (state == WATCHDOG_IDLE) /* a section that begins from now on cannot be late before that */
        return dog->def.asked ? ASK_MS * 1000000u : (uint64_t)(dog->def.seconds * 1e9);
    if (now - dog->stopped_ns >= dog->patience_ns) end_program(dog, state, now);
    pthread_kill(dog->watched, SIGURG);
    return SIGNAL_MS * 1000000u;
}

static void *run(void *user)
{
    watchdog *dog = user;
    for (;;) {
        int wait_ms = (int)((watch(dog) + 999999u) / 1000000u);
        struct pollfd wake = {.fd = dog->wake[0], .events = POLLIN};
        if (poll(&wake, 1, wait_ms) > 0) return NULL;
    }
}

static bool start(watchdog *dog)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    if (sigaction(SIGURG, &action, NULL) != 0 || pipe(dog->wake) != 0) return false;
    for (int i = 0; i < 2; i++) fcntl(dog->wake[i], F_SETFD, FD_CLOEXEC);
    if (pthread_create(&dog->thread, NULL, run, dog) == 0) return true;
    for (int i = 0; i < 2; i++) close(dog->wake[i]);
    return false;
}

watchdog *watchdog_open(const watchdog_def *def, daft_error *error)
{
    watchdog *dog = calloc(1, sizeof *dog);
    if (dog) dog->def = *def, dog->watched = pthread_self();
    if (dog && !(def->seconds > 0)) dog->def.seconds = WATCHDOG_SECONDS;
    if (dog && start(dog)) return dog;
    free(dog);
    fail(error, DAFT_ERROR_MEMORY, "no thread can be made to watch over the game");
    return NULL;
}

void watchdog_close(watchdog *dog)
{
    if (!dog) return;
    if (write(dog->wake[1], "", 1) != 1) return; /* cannot fail: the pipe is empty */
    pthread_join(dog->thread, NULL);
    for (int i = 0; i < 2; i++) close(dog->wake[i]);
    free(dog);
}
