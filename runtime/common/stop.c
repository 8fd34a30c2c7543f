/* The end of the program before its time. See stop.h. */
#include "common/stop.h"

#include "common/util.h"

#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum {
    SECOND_SIGNAL_NS = 1000000000, /* service managers send two signals at once, which is not impatience */
    LOCK_TRIES_MS = 500,
    LONGEST_END_S = 10, /* a disk or a display server may hang; then the process ends as it is */
    WRITABLE_MS = 100   /* nobody may read the pipe that standard output is */
};

static const int SIGNALS[] = {SIGINT, SIGTERM, SIGHUP};

static struct {
    atomic_int signal;
    _Atomic uint64_t first_ns; /* of the first signal */
    atomic_bool ending;
    atomic_int status;    /* of an end that hangs */
    pthread_mutex_t lock; /* of the act */
    stop_act *act;
    void *user;
} stop = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* ---- what is done before the end ---- */

static bool lock_act(void)
{
    for (int i = 0; i < LOCK_TRIES_MS; i++) {
        if (pthread_mutex_trylock(&stop.lock) == 0) return true;
        poll(NULL, 0, 1);
    }
    return false;
}

static bool can_write(int descriptor)
{
    struct pollfd wait = {.fd = descriptor, .events = POLLOUT};
    return poll(&wait, 1, WRITABLE_MS) == 1 && (wait.revents & POLLOUT);
}

/* Without stderr's lock, which another thread may hold for ever. */
static void print(const char *message)
{
    char text[1400];
    int length = snprintf(text, sizeof text, "daft: %s\n", message);
    size_t size = length < 0 ? 0 : (size_t)length < sizeof text ? (size_t)length : sizeof text - 1;
    if (can_write(STDERR_FILENO) && write(STDERR_FILENO, text, size) < 0) return;
}

static void flush_output(void)
{
    if (ftrylockfile(stdout) != 0) return;
    if (can_write(STDOUT_FILENO)) fflush(stdout);
    funlockfile(stdout);
}

static void on_alarm(int unused)
{
    (void)unused;
    _exit(atomic_load(&stop.status));
}

/* Only the first thread that comes here goes on. */
static void end_well(int status, const char *message)
{
    if (atomic_exchange(&stop.ending, true))
        for (;;) pause();
    atomic_store(&stop.status, status);
    signal(SIGALRM, on_alarm);
    alarm(LONGEST_END_S);
    if (message) print(message);
    if (lock_act() && stop.act) stop.act(stop.user);
    daft_remove_temporaries();
    flush_output();
}

_Noreturn void stop_program(int status, const char *message)
{
    end_well(status, message);
    _exit(status);
}

void stop_set_act(stop_act *act, void *user)
{
    pthread_mutex_lock(&stop.lock);
    stop.act = act, stop.user = user;
    pthread_mutex_unlock(&stop.lock);
}

/* ---- signals ---- */

static void on_signal(int number)
{
    int none = 0;
    uint64_t now = clock_now_ns();
    if (atomic_compare_exchange_strong(&stop.signal, &none, number))
        atomic_store(&stop.first_ns, now);
    else if (now - atomic_load(&stop.first_ns) > SECOND_SIGNAL_NS)
        _exit(128 + number);
}

/* Returns the thread's mask as it was. The signals come to one thread alone: no other is interrupted, and none has to
 * do something before it notices. */
static sigset_t change_mask(int how)
{
    sigset_t set, old;
    sigemptyset(&set);
    for (size_t i = 0; i < COUNT_OF(SIGNALS); i++) sigaddset(&set, SIGNALS[i]);
    pthread_sigmask(how, &set, &old);
    return old;
}

static void *wait_for_signal(void *unused)
{
    (void)unused;
    int number;
    sigset_t open;
    change_mask(SIG_UNBLOCK);
    open = change_mask(SIG_BLOCK);
    while ((number = atomic_load(&stop.signal)) == 0) {
        sigsuspend(&open);
        change_mask(SIG_BLOCK); /* ThreadSanitizer runs the handler only now */
    }
    change_mask(SIG_UNBLOCK);
    end_well(128 + number, NULL);
    signal(number, SIG_DFL);
    kill(getpid(), number);
    poll(NULL, 0, 1000);
    _exit(128 + number);
}

void stop_open(void)
{
    struct sigaction action = {.sa_handler = on_signal}, old;
    pthread_t thread;
    sigemptyset(&action.sa_mask);
    change_mask(SIG_BLOCK); /* threads that are made from now on inherit it */
    if (pthread_create(&thread, NULL, wait_for_signal, NULL) != 0) {
        change_mask(SIG_UNBLOCK);
        return;
    }
    pthread_detach(thread);
    for (size_t i = 0; i < COUNT_OF(SIGNALS); i++)
        if (sigaction(SIGNALS[i], NULL, &old) == 0 && old.sa_handler == SIG_DFL) sigaction(SIGNALS[i], &action, NULL);
}

void stop_before_exec(void) { change_mask(SIG_UNBLOCK); }
