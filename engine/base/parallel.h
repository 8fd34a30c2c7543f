/* base/parallel: the one scheduler.
 *
 *   region   workers that stay together while one function runs, the region's body. The body runs on worker 0, the
 *            calling thread; what it does outside of loops is serial. The others wait for loops.
 *   loop     task(context, index, worker) for every index below a count. Each worker has a range of the indices and
 *            takes them one at a time; who is done with its own takes from the others' ranges. A loop ends when all
 *            its tasks are done, whether or not every worker came for one, so a worker that the system does not run
 *            delays nobody.
 *   stages   a list of loops with a barrier after each.
 *
 * Promise: results do not depend on the number of workers or on who took what, as long as a task writes only to what
 * its index owns, or to the scratch of its worker.
 *
 * Workers but the caller are threads that live as long as their region, with stacks of DAFT_WORKER_STACK bytes: nothing
 * of the library runs, spins or holds memory between its calls, and a program may fork. Starting one takes some ten
 * microseconds. Where the system refuses a thread, the others do its work. */
#ifndef DAFT_BASE_PARALLEL_H
#define DAFT_BASE_PARALLEL_H

#include <stddef.h>
#include <stdint.h>

enum { DAFT_WORKER_STACK = 2 << 20 /* bytes */, DAFT_MAX_WORKERS = 64 };

/* worker: 0 to workers - 1, the same for the length of one task; use it to pick scratch memory. */
typedef void daft_task(void *context, uint32_t index, uint32_t worker);

/* A region with one loop. */
void daft_parallel_for(int workers, uint32_t count, daft_task *task, void *context);

typedef struct daft_region daft_region;
typedef void daft_region_body(void *context, daft_region *region);

/* Runs body(context, region). With fewer than two workers the region is NULL: one worker, the caller. */
void daft_parallel_region(int workers, daft_region_body *body, void *context);
int daft_region_workers(const daft_region *region); /* that were asked for */
/* A loop; only the body calls it, one at a time. */
void daft_region_for(daft_region *region, uint32_t count, daft_task *task, void *context);

typedef struct daft_stage {
    /* Items first to first + count - 1 of the stage, which must not depend on each other. */
    void (*run)(void *context, int argument, uint32_t first, uint32_t count);
    int argument;
    uint32_t first, count, grain; /* grain: items that one task takes together */
} daft_stage;

void daft_region_stages(daft_region *region, const daft_stage *stages, size_t count, void *context);

int daft_processor_count(void); /* 1 to DAFT_MAX_WORKERS */

#endif
