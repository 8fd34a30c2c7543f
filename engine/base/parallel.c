/* The one parallel loop. OpenMP by default; plain threads in the ThreadSanitizer build, because that tool does not
 * see the barriers of libgomp and would report every one of them as a race. */
#include "base/base.h"

#include <stdatomic.h>
#include <unistd.h>

typedef struct loop {
    atomic_uint next;
    uint32_t count;
    daft_task *task;
    void *context;
} loop;

static void work(loop *shared, uint32_t worker)
{
    for (;;) {
        uint32_t index = atomic_fetch_add_explicit(&shared->next, 1, memory_order_relaxed);
        if (index >= shared->count) return;
        shared->task(shared->context, index, worker);
    }
}

#ifdef DAFT_PLAIN_THREADS
#include <pthread.h>

enum { MAX_WORKERS = 64 };

typedef struct plain_worker {
    loop *shared;
    uint32_t worker;
} plain_worker;

static void *plain_main(void *argument)
{
    plain_worker *self = argument;
    work(self->shared, self->worker);
    return NULL;
}

static void run(loop *shared, int workers)
{
    pthread_t threads[MAX_WORKERS];
    plain_worker arguments[MAX_WORKERS];
    int started = 0;
    if (workers > MAX_WORKERS) workers = MAX_WORKERS;
    for (int i = 1; i < workers; i++) {
        arguments[started] = (plain_worker){shared, (uint32_t)i};
        if (pthread_create(&threads[started], NULL, plain_main, &arguments[started]) != 0) break;
        started++;
    }
    work(shared, 0);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
}
#else
#include <omp.h>

static void run(loop *shared, int workers)
{
#pragma omp parallel num_threads(workers)
    work(shared, (uint32_t)omp_get_thread_num());
}
#endif

void daft_parallel_for(int workers, uint32_t count, daft_task *task, void *context)
{
    loop shared = {0, count, task, context};
    if (workers > (int)count) workers = (int)count;
    if (workers <= 1)
        work(&shared, 0);
    else
        run(&shared, workers);
}

int daft_processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > 64 ? 64 : (int)count;
}
