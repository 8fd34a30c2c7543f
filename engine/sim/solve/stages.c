/* Workers that go through one list of stages together: a stage begins when all items of the one before it are done.
 * Each worker has a share of every stage, the same part of it each time, so that what it works on stays in its caches;
 * who is done with its own takes from the others'. A worker that comes late, or never, leaves its share to the others,
 * so one worker alone finishes the list. Items of one stage must not depend on each other; then the results do not
 * depend on who took what.
 *
 * A share's state is one number: the stage it is at and the next of its batches there. It only grows, so no state comes
 * back, and a worker that comes late finds that the stage it looks for is over. */
#include "sim/solve/stages.h"

#include <stdatomic.h>

enum { MAX_WORKERS = 64 };

typedef struct share {
    _Alignas(64) atomic_ullong at; /* stage << 32 | batch */
    char apart[64]; /* processors fetch lines of memory in pairs */
} share;

struct daft_sim_stages {
    share shares[MAX_WORKERS];
    _Alignas(64) atomic_ullong done; /* batches, since the list began */
    _Alignas(64) daft_allocator allocator;
    daft_sim_stage *items;
    size_t count, capacity;
    uint32_t workers;
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
    daft_release(&allocator, stages);
}

bool daft_sim_stages_reserve(daft_sim_stages *stages, size_t count)
{
    return daft_grow(&stages->allocator, &stages->items, &stages->capacity, count, 0, sizeof *stages->items);
}

void daft_sim_stages_clear(daft_sim_stages *stages) { stages->count = 0; }

void daft_sim_stages_add(daft_sim_stages *stages, daft_sim_stage stage)
{
    if (stage.count > 0) stages->items[stages->count++] = stage;
}

static uint32_t batches_of(const daft_sim_stage *stage) { return (stage->count + stage->grain - 1) / stage->grain; }

/* The first batch of a worker's share. */
static uint32_t share_begin(uint32_t batches, uint32_t workers, uint32_t worker)
{
    return (uint32_t)((uint64_t)batches * worker / workers);
}

/* Takes half of the batches that are left of a share in a stage: few times, and in the end little at once. Gives how many, and the
 * first of them, counted from the share's. */
static uint32_t take_batches(share *from, size_t stage, uint32_t count, uint32_t *first)
{
    unsigned long long begin = (unsigned long long)stage << 32, at = atomic_load_explicit(&from->at, memory_order_relaxed);
    for (;;) {
        unsigned long long next = at < begin ? begin : at;
        if (next >= begin + count) return 0;
        uint32_t half = ((uint32_t)(begin + count - next) + 1) / 2;
        *first = (uint32_t)(next - begin);
        if (atomic_compare_exchange_weak_explicit(&from->at, &at, next + half, memory_order_relaxed, memory_order_relaxed))
            return half;
    }
}

static void run_batches(const daft_sim_stage *stage, void *context, uint32_t batch, uint32_t batches)
{
    uint32_t first = batch * stage->grain, left = stage->count - first, most = batches * stage->grain;
    stage->run(context, stage->argument, stage->first + first, left < most ? left : most);
}

/* Gives how many batches this worker did. */
static uint32_t run_share(daft_sim_stages *stages, size_t at, uint32_t owner)
{
    const daft_sim_stage *stage = &stages->items[at];
    uint32_t batches = batches_of(stage), begin = share_begin(batches, stages->workers, owner), ran = 0, first = 0, taken;
    uint32_t count = share_begin(batches, stages->workers, owner + 1) - begin;
    while ((taken = take_batches(&stages->shares[owner], at, count, &first)) > 0) {
        run_batches(stage, stages->context, begin + first, taken);
        ran += taken;
    }
    return ran;
}

static void work(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    daft_sim_stages *stages = context;
    uint64_t before = 0;
    for (size_t s = 0; s < stages->count; s++) {
        uint32_t ran = 0;
        before += batches_of(&stages->items[s]);
        for (uint32_t i = 0; i < stages->workers; i++) ran += run_share(stages, s, (index + i) % stages->workers);
        if (ran) atomic_fetch_add_explicit(&stages->done, ran, memory_order_release);
        for (int spins = 0; atomic_load_explicit(&stages->done, memory_order_acquire) < before;) daft_pause(&spins);
    }
}

void daft_sim_stages_run(daft_sim_stages *stages, daft_team *team, void *context)
{
    uint32_t workers = team ? (uint32_t)daft_team_size(team) : 1;
    stages->context = context;
    stages->workers = workers < MAX_WORKERS ? workers : MAX_WORKERS;
    if (workers > 1) {
        for (uint32_t i = 0; i < stages->workers; i++) atomic_store_explicit(&stages->shares[i].at, 0, memory_order_relaxed);
        atomic_store_explicit(&stages->done, 0, memory_order_relaxed);
        daft_team_for(team, stages->workers, work, stages);
        return;
    }
    for (size_t s = 0; s < stages->count; s++) {
        const daft_sim_stage *stage = &stages->items[s];
        stage->run(context, stage->argument, stage->first, stage->count);
    }
}
