/* The one parallel loop. OpenMP by default; plain threads in the ThreadSanitizer build, because that tool does not
 * see the barriers of libgomp and would report every one of them as a race. */
#include "base/base.h"

#include <sched.h>
#include <stdatomic.h>
#include <unistd.h>

typedef struct crew {
    void (*work)(void *context, uint32_t worker);
    void *context;
} crew;

#ifdef DAFT_PLAIN_THREADS
#include <pthread.h>

enum { MAX_WORKERS = 64 };

typedef struct plain_worker {
    const crew *all;
    uint32_t worker;
} plain_worker;

static void *plain_main(void *argument)
{
    plain_worker *self = argument;
    self->all->work(self->all->context, self->worker);
    return NULL;
}

static void run(const crew *all, int workers)
{
    pthread_t threads[MAX_WORKERS];
    plain_worker arguments[MAX_WORKERS];
    int started = 0;
    if (workers > MAX_WORKERS) workers = MAX_WORKERS;
    for (int i = 1; i < workers; i++) {
        arguments[started] = (plain_worker){all, (uint32_t)i};
        if (pthread_create(&threads[started], NULL, plain_main, &arguments[started]) != 0) break;
        started++;
    }
    all->work(all->context, 0);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
}
#else
#include <omp.h>

static void run(const crew *all, int workers)
{
#pragma omp parallel num_threads(workers)
    all->work(all->context, (uint32_t)omp_get_thread_num());
}
#endif

/* ---- one loop ---- */

typedef struct loop {
    atomic_uint next;
    uint32_t count;
    daft_task *task;
    void *context;
} loop;

static void work(void *context, uint32_t worker)
{
    loop *shared = context;
    for (;;) {
        uint32_t index = atomic_fetch_add_explicit(&shared->next, 1, memory_order_relaxed);
        if (index >= shared->count) return;
        shared->task(shared->context, index, worker);
    }
}

void daft_parallel_for(int workers, uint32_t count, daft_task *task, void *context)
{
    loop shared = {0, count, task, context};
    if ((uint32_t)daft_max_i(workers, 1) > count) workers = (int)count;
    if (workers <= 1)
        work(&shared, 0);
    else
        run(&(crew){work, &shared}, workers);
}

/* ---- a script ---- */

enum { SPINS = 2000, SHARES = 64 };

/* What is left of a part of a loop's indices: end << 32 | next. */
typedef struct share {
    _Alignas(64) atomic_ullong left;
    char apart[64]; /* processors fetch lines of memory in pairs */
} share;

/* Each worker has a share of a loop, the same part of it each time, so that what it works on stays in its caches; who is done
 * with its own takes from the others'. A task belongs to whoever raises a share's `next`; its loop is not over before `unfinished`
 * is zero, so what the loop is can be read after that without a race. */
struct daft_team {
    share shares[SHARES];
    _Alignas(64) atomic_uint unfinished;
    atomic_bool over;
    int workers;
    uint32_t share_count;
    daft_task *task;
    void *context;
    daft_script *script;
    void *script_context;
};

static bool take_from(daft_team *team, share *from, uint32_t worker)
{
    unsigned long long left = atomic_load_explicit(&from->left, memory_order_relaxed);
    do
        if ((uint32_t)left >= left >> 32) return false;
    while (!atomic_compare_exchange_weak_explicit(&from->left, &left, left + 1, memory_order_acquire, memory_order_relaxed));
    team->task(team->context, (uint32_t)left, worker);
    return true;
}

/* All that there is to do. It is told at once, as a line of memory that all write goes to and fro between them. */
static bool take_all(daft_team *team, uint32_t worker)
{
    unsigned taken = 0;
    for (uint32_t i = 0; i < team->share_count; i++)
        while (take_from(team, &team->shares[(worker + i) % team->share_count], worker)) taken++;
    if (taken) atomic_fetch_sub_explicit(&team->unfinished, taken, memory_order_release);
    return taken > 0;
}

void daft_pause(int *spins)
{
    if (++*spins > SPINS) sched_yield();
#if defined(__x86_64__) || defined(__i386__)
    else
        __builtin_ia32_pause();
#endif
}

static void no_part(void *context) { (void)context; }

void daft_team_for(daft_team *team, uint32_t count, daft_task *task, void *context)
{
    daft_team_beside(team, no_part, count, task, context);
}

void daft_team_beside(daft_team *team, daft_own_part *own, uint32_t count, daft_task *task, void *context)
{
    int spins = 0;
    team->task = task, team->context = context;
    atomic_store_explicit(&team->unfinished, count, memory_order_relaxed);
    for (uint64_t i = team->share_count, end = count; i-- > 0;) { /* the first's own at last: others would find it before theirs */
        uint64_t begin = count * i / team->share_count;
        atomic_store_explicit(&team->shares[i].left, end << 32 | begin, memory_order_release);
        end = begin;
    }
    own(context);
    take_all(team, 0);
    while (atomic_load_explicit(&team->unfinished, memory_order_acquire)) daft_pause(&spins);
}

int daft_team_size(const daft_team *team) { return team->workers; }

static void join_in(void *context, uint32_t worker)
{
    daft_team *team = context;
    int spins = 0;
    if (worker == 0) {
        team->script(team->script_context, team);
        atomic_store_explicit(&team->over, true, memory_order_release);
        return;
    }
    while (!atomic_load_explicit(&team->over, memory_order_acquire)) {
        if (take_all(team, worker))
            spins = 0;
        else
            daft_pause(&spins);
    }
}

void daft_parallel_script(int workers, daft_script *script, void *context)
{
    daft_team team = {.workers = workers, .script = script, .script_context = context};
    team.share_count = (uint32_t)daft_max_i(1, workers < SHARES ? workers : SHARES);
    if (workers <= 1)
        join_in(&team, 0);
    else
        run(&(crew){join_in, &team}, workers);
}

int daft_processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > 64 ? 64 : (int)count;
}
