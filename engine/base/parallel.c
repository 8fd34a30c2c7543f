/* The scheduler: see parallel.h. */
#include "base/base.h"
#include "base/cpu.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <unistd.h>

/* ---- workers: run `work` on each of them and join ---- */

typedef void worker_main(daft_region *region, uint32_t worker);

enum { HALVINGS = 6 /* until a span of DAFT_MAX_WORKERS is one worker */ };

/* Workers first to end - 1. The thread that has a span starts threads for its upper halves, which do the same, until
 * it is left with its first worker: with 64 workers the caller starts six threads, not 63. */
typedef struct span {
    worker_main *work;
    daft_region *region;
    uint32_t first, end;
} span;

static void run_span(span all);

static void *span_main(void *argument)
{
    run_span(*(span *)argument);
    return NULL;
}

/* Where the system gives no thread, the span's workers are not there, and the others do its tasks. */
static bool start_thread(pthread_t *thread, span *part)
{
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes) != 0) return false;
    bool good = pthread_attr_setstacksize(&attributes, DAFT_WORKER_STACK) == 0 &&
                pthread_create(thread, &attributes, span_main, part) == 0;
    pthread_attr_destroy(&attributes);
    return good;
}

static void run_span(span all)
{
    pthread_t threads[HALVINGS];
    span parts[HALVINGS];
    int started = 0;
    while (all.end - all.first > 1) {
        uint32_t middle = all.first + (all.end - all.first + 1) / 2;
        parts[started] = (span){all.work, all.region, middle, all.end};
        if (start_thread(&threads[started], &parts[started])) started++;
        all.end = middle;
    }
    all.work(all.region, all.first);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
}

/* ---- loops ---- */

/* A thread that waits first spins, for some tens of microseconds, then lets others run, and then sleeps: where other
 * programs want its processor, which it sees by a yield that takes long, or after a while. Who sleeps is run again soon
 * after it is woken, where who yields stands in line behind them. */
enum { SPINS = 2000, YIELDS = 1000 };
static const double LONG_YIELD_MS = 0.1;

typedef struct waiting {
    int spins;
} waiting;

/* False: it has waited long enough, and is to sleep. */
static bool wait_a_little(waiting *w)
{
    if (++w->spins <= SPINS) {
        daft_cpu_pause();
        return true;
    }
    const double before = daft_clock_ms();
    sched_yield();
    return w->spins < SPINS + YIELDS && daft_clock_ms() - before < LONG_YIELD_MS;
}

/* What is left of a worker's range: end << 32 | next. */
typedef struct range {
    _Alignas(64) atomic_ullong left;
    char apart[64]; /* processors fetch cache lines in pairs */
} range;

/* A task belongs to whoever raises a range's `next`. The loop is not over before `unfinished` is zero, so its task and
 * context can be read after that without a race. */
struct daft_region {
    range ranges[DAFT_MAX_WORKERS];
    _Alignas(64) atomic_uint unfinished;
    atomic_uint loops; /* that have begun */
    atomic_bool over;
    /* Who sleeps says so before looking once more whether to; who wakes looks for sleepers after what they wait for. */
    atomic_uint asleep;       /* workers */
    atomic_bool caller_waits; /* asleep, for `unfinished` */
    pthread_mutex_t lock;
    pthread_cond_t begun, done;
    uint32_t workers;
    daft_task *task;
    void *context;
    daft_region_body *body;
    void *body_context;
};

static bool take_from(daft_region *region, range *from, uint32_t worker)
{
    unsigned long long left = atomic_load_explicit(&from->left, memory_order_relaxed);
    do
        if ((uint32_t)left >= left >> 32) return false;
    while (!atomic_compare_exchange_weak_explicit(&from->left, &left, left + 1, memory_order_acquire,
                                                  memory_order_relaxed));
    region->task(region->context, (uint32_t)left, worker);
    return true;
}

static void wake(daft_region *region, pthread_cond_t *sleepers)
{
    pthread_mutex_lock(&region->lock);
    pthread_cond_broadcast(sleepers);
    pthread_mutex_unlock(&region->lock);
}

/* The worker's own range, then the others'. */
static bool take_all(daft_region *region, uint32_t worker)
{
    unsigned taken = 0;
    for (uint32_t i = 0; i < region->workers; i++)
        while (take_from(region, &region->ranges[(worker + i) % region->workers], worker)) taken++;
    if (taken && atomic_fetch_sub(&region->unfinished, taken) == taken && atomic_load(&region->caller_waits))
        wake(region, &region->done);
    return taken > 0;
}

static void wake_workers(daft_region *region)
{
    if (atomic_load(&region->asleep) > 0) wake(region, &region->begun);
}

/* Until a loop begins that is not `seen`, or all is over. */
static void sleep_for_loop(daft_region *region, uint32_t seen)
{
    pthread_mutex_lock(&region->lock);
    atomic_fetch_add(&region->asleep, 1);
    while (atomic_load(&region->loops) == seen && !atomic_load(&region->over))
        pthread_cond_wait(&region->begun, &region->lock);
    atomic_fetch_sub(&region->asleep, 1);
    pthread_mutex_unlock(&region->lock);
}

static void sleep_for_tasks(daft_region *region)
{
    pthread_mutex_lock(&region->lock);
    atomic_store(&region->caller_waits, true);
    while (atomic_load(&region->unfinished)) pthread_cond_wait(&region->done, &region->lock);
    atomic_store(&region->caller_waits, false);
    pthread_mutex_unlock(&region->lock);
}

void daft_region_for(daft_region *region, uint32_t count, daft_task *task, void *context)
{
    waiting wait = {0};
    if (!region || count <= 1) {
        for (uint32_t i = 0; i < count; i++) task(context, i, 0);
        return;
    }
    region->task = task, region->context = context;
    atomic_store_explicit(&region->unfinished, count, memory_order_relaxed);
    for (uint64_t i = region->workers, end = count; i-- > 0;) { /* the caller's range last: the others begin meanwhile
                                                                 */
        uint64_t begin = count * i / region->workers;
        atomic_store_explicit(&region->ranges[i].left, end << 32 | begin, memory_order_release);
        end = begin;
    }
    atomic_fetch_add(&region->loops, 1);
    wake_workers(region);
    take_all(region, 0);
    while (atomic_load_explicit(&region->unfinished, memory_order_acquire))
        if (!wait_a_little(&wait)) sleep_for_tasks(region);
}

/* ---- regions ---- */

int daft_region_workers(const daft_region *region) { return region ? (int)region->workers : 1; }

static void work(daft_region *region, uint32_t worker)
{
    waiting wait = {0};
    if (worker == 0) {
        region->body(region->body_context, region);
        atomic_store(&region->over, true);
        wake_workers(region);
        return;
    }
    while (!atomic_load_explicit(&region->over, memory_order_acquire)) {
        const uint32_t seen = atomic_load_explicit(&region->loops, memory_order_acquire);
        const bool took = take_all(region, worker);
        if (!took && wait_a_little(&wait)) continue;
        if (!took) sleep_for_loop(region, seen);
        wait.spins = 0;
    }
}

void daft_parallel_region(int workers, daft_region_body *body, void *context)
{
    if (workers <= 1) {
        body(context, NULL);
        return;
    }
    workers = daft_min_i(workers, DAFT_MAX_WORKERS);
    daft_region region = {.workers = (uint32_t)workers,
                          .body = body,
                          .body_context = context,
                          .lock = PTHREAD_MUTEX_INITIALIZER,
                          .begun = PTHREAD_COND_INITIALIZER,
                          .done = PTHREAD_COND_INITIALIZER};
    run_span((span){work, &region, 0, (uint32_t)workers});
    pthread_cond_destroy(&region.begun);
    pthread_cond_destroy(&region.done);
    pthread_mutex_destroy(&region.lock);
}

/* ---- one loop ---- */

typedef struct loop {
    uint32_t count;
    daft_task *task;
    void *context;
} loop;

static void run_loop(void *context, daft_region *region)
{
    const loop *l = context;
    daft_region_for(region, l->count, l->task, l->context);
}

void daft_parallel_for(int workers, uint32_t count, daft_task *task, void *context)
{
    if ((uint32_t)daft_max_i(workers, 1) > count) workers = (int)count;
    if (workers <= 1)
        daft_region_for(NULL, count, task, context);
    else
        daft_parallel_region(workers, run_loop, &(loop){count, task, context});
}

/* ---- stages ---- */

typedef struct stage_job {
    const daft_stage *stage;
    void *context;
} stage_job;

static void run_grain(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const stage_job *j = context;
    const daft_stage *s = j->stage;
    uint32_t first = index * s->grain;
    s->run(j->context, s->argument, s->first + first, daft_min_u(s->grain, s->count - first));
}

void daft_region_stages(daft_region *region, const daft_stage *stages, size_t count, void *context)
{
    bool alone = daft_region_workers(region) == 1;
    for (const daft_stage *s = stages; s < stages + count; s++) {
        if (alone || s->count <= s->grain)
            s->run(context, s->argument, s->first, s->count);
        else
            daft_region_for(region, (s->count + s->grain - 1) / s->grain, run_grain, &(stage_job){s, context});
    }
}

int daft_processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > DAFT_MAX_WORKERS ? DAFT_MAX_WORKERS : (int)count;
}
