/* Workers that go through one list of stages together: a stage begins when all items of the one before it are done.
 * Items are taken from a counter by whoever is free; a worker that comes late, or never, leaves its share to the
 * others, so one worker alone finishes the list. Items of one stage must not depend on each other; then the results do
 * not depend on who took what. */
#include "sim/stages.h"

#include <sched.h>
#include <stdatomic.h>

typedef struct progress {
    atomic_uint next, done;
} progress;

struct daft_sim_stages {
    daft_allocator allocator;
    daft_sim_stage *items;
    progress *progress;
    size_t count, capacity, progress_capacity;
    void *context;
};

daft_sim_stages *daft_sim_stages_create(const daft_allocator *allocator)
{
    daft_sim_stages *stages = daft_alloc_zero(allocator, 1, sizeof *stages);
    if (stages) stages->allocator = *allocator;
    return stages;
}

void daft_sim_stages_free(daft_sim_stages *stages)
{
    if (!stages) return;
    daft_allocator allocator = stages->allocator;
    daft_release(&allocator, stages->items);
    daft_release(&allocator, stages->progress);
    daft_release(&allocator, stages);
}

bool daft_sim_stages_reserve(daft_sim_stages *stages, size_t count)
{
    return daft_grow(&stages->allocator, &stages->items, &stages->capacity, count, 0, sizeof *stages->items) &&
           daft_grow(&stages->allocator, &stages->progress, &stages->progress_capacity, count, 0,
                     sizeof *stages->progress);
}

void daft_sim_stages_clear(daft_sim_stages *stages) { stages->count = 0; }

void daft_sim_stages_add(daft_sim_stages *stages, daft_sim_stage stage)
{
    if (stage.count == 0) return;
    atomic_init(&stages->progress[stages->count].next, 0);
    atomic_init(&stages->progress[stages->count].done, 0);
    stages->items[stages->count++] = stage;
}

static uint32_t batches_of(const daft_sim_stage *stage) { return (stage->count + stage->grain - 1) / stage->grain; }

static void run_batch(const daft_sim_stage *stage, void *context, uint32_t batch)
{
    uint32_t first = batch * stage->grain, left = stage->count - first;
    stage->run(context, stage->argument, stage->first + first, left < stage->grain ? left : stage->grain);
}

static void wait_for(progress *p, uint32_t batches)
{
    for (int spins = 0; atomic_load_explicit(&p->done, memory_order_acquire) < batches; spins++) {
        if (spins > 300) sched_yield();
#ifdef DAFT_HAVE_X86
        __builtin_ia32_pause();
#endif
    }
}

static void work(void *context, uint32_t index, uint32_t worker)
{
    (void)index, (void)worker;
    daft_sim_stages *stages = context;
    for (size_t s = 0; s < stages->count; s++) {
        const daft_sim_stage *stage = &stages->items[s];
        progress *p = &stages->progress[s];
        uint32_t batches = batches_of(stage), batch;
        while ((batch = atomic_fetch_add_explicit(&p->next, 1, memory_order_relaxed)) < batches) {
            run_batch(stage, stages->context, batch);
            atomic_fetch_add_explicit(&p->done, 1, memory_order_release);
        }
        wait_for(p, batches);
    }
}

void daft_sim_stages_run(daft_sim_stages *stages, int workers, void *context)
{
    stages->context = context;
    if (workers > 1) {
        daft_parallel_for(workers, (uint32_t)workers, work, stages);
        return;
    }
    for (size_t s = 0; s < stages->count; s++) {
        const daft_sim_stage *stage = &stages->items[s];
        stage->run(context, stage->argument, stage->first, stage->count);
    }
}
