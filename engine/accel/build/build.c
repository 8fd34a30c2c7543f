/* The builder's threads: prims into cells, the top of the tree over cells, and the tasks below it. */
#include "accel/build/build.h"

#include <float.h>

/* Passes over prims go by slices, whose number depends on nothing; each counts its own cells, so that prims keep their
 * order within a cell. */
enum { GRID_MIN = 16384, SLICES = 8 };
enum { CHUNK = 65536 }; /* forks */

static const daft_build_kernels *kernels_for(int isa)
{
    static const daft_build_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_build);
    return TABLE[isa];
}

static uint32_t slice_first(uint32_t count, uint32_t slice) { return (uint32_t)((uint64_t)count * slice / SLICES); }

/* ---- the whole ---- */

typedef struct measure_job {
    const daft_build *build;
    daft_build_range slices[SLICES];
} measure_job;

static void measure_slice(void *context, uint32_t slice, uint32_t worker)
{
    (void)worker;
    measure_job *job = context;
    uint32_t first = slice_first(job->build->count, slice), end = slice_first(job->build->count, slice + 1);
    job->slices[slice] = (daft_build_range){.first = first, .count = end - first};
    job->build->kernels->measure(job->build->prims, &job->slices[slice]);
}

static daft_build_range measure_whole(const daft_build *build)
{
    measure_job job = {.build = build};
    daft_region_for(build->region, SLICES, measure_slice, &job);
    daft_build_range whole = job.slices[0];
    whole.count = whole.weight = build->count;
    for (int i = 1; i < SLICES; i++) {
        whole.box = v8_min(whole.box, job.slices[i].box);
        whole.middles = v8_min(whole.middles, job.slices[i].middles);
    }
    return whole;
}

/* ---- the grid ---- */

typedef struct grid_job {
    daft_build *build;
    daft_build_grid grid;
    uint32_t total;   /* cells, empty ones too */
    uint32_t *counts; /* of each slice; then where its prims of a cell go */
} grid_job;

/* Fewer prims than GRID_MIN are one task: they take no longer than by a grid, and the top of the tree is better. Above,
 * about ten prims to a cell of a surface: enough for the top, and few enough to count. False: no grid parts the
 * middles. */
static bool grid_of(const daft_build_range *whole, daft_build_grid *grid)
{
    uint32_t side = whole->count < 524288 ? 32 : whole->count < 4194304 ? 64 : 128;
    *grid = (daft_build_grid){.low = v8_lower_half(whole->middles), .side = side};
    v4 extent = -(grid->low + v8_upper_half(whole->middles));
    bool parts = false;
    grid->low[3] = 0, grid->scale = v4_set(0);
    for (int k = 0; k < 3; k++) {
        if (!(extent[k] <= FLT_MAX)) return false;
        float scale = extent[k] > 0 ? (float)grid->side * 0.999f / extent[k] : 0;
        grid->scale[k] = scale <= FLT_MAX ? scale : 0;
        parts |= grid->scale[k] > 0;
    }
    return parts;
}

static void count_slice(void *context, uint32_t slice, uint32_t worker)
{
    (void)worker;
    grid_job *job = context;
    uint32_t first = slice_first(job->build->count, slice), end = slice_first(job->build->count, slice + 1);
    uint32_t *counts = job->counts + (size_t)slice * job->total;
    memset(counts, 0, job->total * sizeof *counts);
    job->build->kernels->count(&job->grid, job->build->prims + first, end - first, counts);
}

static void scatter_slice(void *context, uint32_t slice, uint32_t worker)
{
    (void)worker;
    grid_job *job = context;
    uint32_t first = slice_first(job->build->count, slice), end = slice_first(job->build->count, slice + 1);
    job->build->kernels->scatter(&job->grid, job->build->prims + first, end - first,
                                 job->counts + (size_t)slice * job->total, job->build->other);
}

/* From counts to places; notes where each cell that holds something begins. */
static void place_cells(grid_job *job)
{
    daft_build *build = job->build;
    uint32_t next = 0, number = 0;
    for (uint32_t cell = 0; cell < job->total; cell++) {
        uint32_t first = next;
        for (uint32_t slice = 0; slice < SLICES; slice++) {
            uint32_t *count = &job->counts[(size_t)slice * job->total + cell], here = *count;
            *count = next;
            next += here;
        }
        if (next > first) build->cell_first[number++] = first;
    }
    build->cell_first[number] = next;
    build->cell_count = number;
}

static void make_cells(void *context, uint32_t slice, uint32_t worker)
{
    (void)worker;
    daft_build *build = ((grid_job *)context)->build;
    for (uint32_t i = slice_first(build->cell_count, slice); i < slice_first(build->cell_count, slice + 1); i++) {
        daft_build_range cell = {.first = build->cell_first[i],
                                 .count = build->cell_first[i + 1] - build->cell_first[i]};
        build->kernels->measure(build->other, &cell);
        daft_build_prim *out = &build->cells[i];
        memcpy(out->low, &cell.box, sizeof cell.box);
        out->id = i, out->weight = cell.weight;
    }
}

static bool sort_into_cells(daft_build *build, const daft_build_grid *grid)
{
    grid_job job = {.build = build, .grid = *grid, .total = grid->side * grid->side * grid->side};
    job.counts = daft_alloc(build->allocator, (size_t)SLICES * job.total, sizeof *job.counts);
    uint32_t most = daft_min_u(job.total, build->count); /* cells that hold something */
    build->cell_first = daft_alloc(build->allocator, (size_t)most + 1, sizeof *build->cell_first);
    bool done = job.counts && build->cell_first;
    if (done) {
        daft_region_for(build->region, SLICES, count_slice, &job);
        place_cells(&job);
        daft_region_for(build->region, SLICES, scatter_slice, &job);
        build->cells = daft_alloc(build->allocator, 2 * (size_t)build->cell_count, sizeof *build->cells);
        done = build->cells != NULL;
        if (done) daft_region_for(build->region, SLICES, make_cells, &job);
    }
    daft_release(build->allocator, job.counts);
    return done;
}

/* ---- the top, and its tasks ---- */

/* Room for so many forks in a row; a new chunk, where there is none, has `chunk` of them or more. Prims become at most
 * two forks each. False: memory is out. */
static bool reserve_forks(const daft_allocator *allocator, daft_build_sink *sink, size_t most, size_t chunk)
{
    if (sink->capacity - sink->count >= most) return true;
    if (!daft_grow(allocator, &sink->chunks, &sink->chunk_capacity, sink->chunk_count + 1, sink->chunk_count,
                   sizeof *sink->chunks))
        return false;
    sink->capacity = chunk > most ? chunk : most;
    sink->count = 0;
    sink->forks = daft_alloc(allocator, sink->capacity, sizeof *sink->forks);
    sink->chunks[sink->chunk_count++] = sink->forks;
    if (!sink->forks) sink->capacity = 0;
    return sink->forks != NULL;
}

static bool split_cells(daft_build *build)
{
    daft_build_branch branch = {.rule = &build->rule,
                                .prims = {build->cells, build->cells + build->cell_count},
                                .sink = &build->top,
                                .allocator = build->allocator,
                                .defer = true};
    daft_build_range whole = {.count = build->cell_count};
    build->kernels->measure(build->cells, &whole);
    bool done = reserve_forks(build->allocator, &build->top, 2 * (size_t)build->cell_count, 0) &&
                build->kernels->branch(&branch, &whole);
    build->tasks = branch.tasks, build->task_count = branch.task_count;
    uint32_t first = 0; /* tasks are in depth-first order; from cells to their prims */
    for (size_t i = 0; i < build->task_count; i++)
        build->tasks[i].node_base = first, first += build->tasks[i].range.weight;
    return done;
}

/* A task's prims, cell by cell, to where the task works on them. */
static void gather_task(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    daft_build *build = context;
    daft_build_task *task = &build->tasks[index];
    const daft_build_prim *cells = build->cells + (task->range.side ? build->cell_count : 0) + task->range.first;
    uint32_t first = (uint32_t)task->node_base, next = first;
    for (uint32_t i = 0; i < task->range.count; i++) {
        uint32_t from = build->cell_first[cells[i].id];
        memcpy(build->prims + next, build->other + from, cells[i].weight * sizeof *build->prims);
        next += cells[i].weight;
    }
    task->range = (daft_build_range){.first = first, .count = next - first, .depth = task->range.depth};
    build->kernels->measure(build->prims, &task->range);
}

static void free_sink(const daft_allocator *allocator, daft_build_sink *sink)
{
    for (size_t i = 0; i < sink->chunk_count; i++) daft_release(allocator, sink->chunks[i]);
    daft_release(allocator, sink->chunks);
}

static void run_task(void *context, uint32_t index, uint32_t worker)
{
    daft_build *build = context;
    daft_build_task *task = &build->tasks[index];
    daft_build_sink *sink = &build->sinks[build->fixed ? index : worker];
    daft_build_branch branch = {
        .rule = &build->rule, .prims = {build->prims, build->other}, .sink = sink, .numbers = build->numbers};
    size_t chunk = daft_min_u(CHUNK, build->count / 2 / (uint32_t)daft_max_i(build->threads, 1));
    if (!build->fixed && !reserve_forks(build->allocator, sink, 2 * (size_t)task->range.count, chunk)) return;
    daft_build_fork *forks = sink->forks + sink->count;
    build->kernels->branch(&branch, &task->range);
    daft_build_weigh(&build->rule, forks, (size_t)(sink->forks + sink->count - forks));
    task->forks = forks;
}

static bool make_sinks(daft_build *build)
{
    build->sink_count = build->fixed ? build->task_count : (size_t)daft_max_i(build->threads, 1);
    build->sinks = daft_alloc_zero(build->allocator, build->sink_count, sizeof *build->sinks);
    if (!build->sinks) return false;
    for (size_t i = 0; i < build->task_count && build->fixed; i++)
        if (!reserve_forks(build->allocator, &build->sinks[i], 2 * (size_t)build->tasks[i].range.count, 0))
            return false;
    return true;
}

static bool single_task(daft_build *build, const daft_build_range *whole)
{
    build->tasks = daft_alloc_zero(build->allocator, 1, sizeof *build->tasks);
    if (!build->tasks) return false;
    build->tasks[0].range = *whole;
    build->task_count = 1;
    return true;
}

bool daft_build_run(daft_build *build)
{
    build->kernels = kernels_for(build->isa);
    build->other = daft_alloc(build->allocator, build->count, sizeof *build->other);
    if (!build->other) return false;
    if (build->rule.block_size > 1) {
        build->numbers = daft_alloc(build->allocator, build->count, sizeof *build->numbers);
        if (!build->numbers) return false;
    }
    daft_build_range whole = measure_whole(build);
    daft_build_grid grid;
    if (build->count >= GRID_MIN && grid_of(&whole, &grid)) {
        if (!sort_into_cells(build, &grid) || !split_cells(build)) return false;
        daft_region_for(build->region, (uint32_t)build->task_count, gather_task, build);
    } else if (!single_task(build, &whole)) {
        return false;
    }
    if (!make_sinks(build)) return false;
    daft_region_for(build->region, (uint32_t)build->task_count, run_task, build);
    return daft_build_collapse(build);
}

void daft_build_free(daft_build *build)
{
    const daft_allocator *allocator = build->allocator;
    for (size_t i = 0; build->sinks && i < build->sink_count; i++) free_sink(allocator, &build->sinks[i]);
    free_sink(allocator, &build->top);
    daft_release(allocator, build->top_nodes.items);
    daft_release(allocator, build->sinks);
    daft_release(allocator, build->tasks);
    daft_release(allocator, build->other);
    daft_release(allocator, build->numbers);
    daft_release(allocator, build->cells);
    daft_release(allocator, build->cell_first);
}
