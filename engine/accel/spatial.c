/* The BVH with spatial splits, on request: a range of triangles is parted either by their middles, as in build_kernel.c, or
 * by a plane that cuts those which straddle it, whichever costs less (Stich, Friedrich, Dietrich, "Spatial Splits in Bounding
 * Volume Hierarchies", 2009). Long thin triangles that lie across the axes then do not fill the boxes of all their
 * neighbours; the price is a slow build, and triangles that stand in several leaves.
 *
 * Planes are looked for only where the two sides of the best split by middles overlap by OVERLAP of the mesh's box, and
 * triangles are repeated by no more than REPEATS in the mean. The boxes of parts are wider by PAD of the largest coordinate:
 * kernels that move vertices into another space allow for roundings by the size of what they test, and a part's corners lie
 * outside its box, at most as far out as the mesh reaches. */
#include "accel/build.h"
#include "accel/clip.h"

#include <float.h>

enum { BINS = 16, HALVE_BELOW = 40, TASK_COUNT = 4096 };
#define OVERLAP 1e-5
#define REPEATS 1.0
#define PAD 0x1p-18f

typedef struct bounds {
    float low[3], high[3];
} bounds;

/* Owns its parts. */
typedef struct span {
    daft_part *parts;
    size_t count, repeats;
    bounds box;
    int depth;
} span;

typedef struct grower {
    const daft_allocator *allocator;
    const daft_trimesh *mesh;
    daft_build_sink *sink;
    float pad;
    double whole; /* half the surface of the mesh's box */
    span *tasks;  /* where `defer` */
    size_t task_count, task_capacity;
    bool defer, failed;
} grower;

typedef struct split {
    double cost, overlap;
    int axis;
    float at;
    bool cuts;
} split;

static bounds bounds_empty(void) { return (bounds){{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}}; }

static void bounds_add(bounds *b, const float low[3], const float high[3])
{
    for (int k = 0; k < 3; k++) b->low[k] = fminf(b->low[k], low[k]), b->high[k] = fmaxf(b->high[k], high[k]);
}

static double half_area(const bounds *b)
{
    double x = (double)b->high[0] - (double)b->low[0], y = (double)b->high[1] - (double)b->low[1];
    double z = (double)b->high[2] - (double)b->low[2];
    return x < 0 || y < 0 || z < 0 ? 0 : x * (y + z) + y * z;
}

/* leaf: what one costs besides its blocks, in blocks; 0 for what will have many leaves. */
static double cost_of(const bounds *b, size_t count, double leaf)
{
    return half_area(b) * (leaf + (double)((count + DAFT_BLOCK - 1) / DAFT_BLOCK));
}

static double leaf_cost(size_t count)
{
    return count <= DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK ? (double)DAFT_LEAF_COST / (double)DAFT_BLOCK_COST : 0;
}

static float middle(const daft_part *p, int axis) { return 0.5f * p->low[axis] + 0.5f * p->high[axis]; }

/* ---- where to split ---- */

typedef struct bin {
    bounds box;
    size_t begins, ends;
} bin;

static void clear_bins(bin bins[BINS])
{
    for (int i = 0; i < BINS; i++) bins[i] = (bin){.box = bounds_empty()};
}

/* The best of the planes between bins; at(i) is low + i·width. */
static void sweep(const bin bins[BINS], int axis, double low, double width, bool cuts, double leaf, split *best)
{
    bounds right[BINS], left = bounds_empty(), sum = bounds_empty();
    size_t above[BINS], begun = 0, ended = 0;
    for (int i = BINS - 1; i > 0; i--) {
        bounds_add(&sum, bins[i].box.low, bins[i].box.high);
        right[i] = sum;
        above[i] = ended += bins[i].ends;
    }
    for (int i = 1; i < BINS; i++) {
        bounds_add(&left, bins[i - 1].box.low, bins[i - 1].box.high);
        begun += bins[i - 1].begins;
        if (begun == 0 || above[i] == 0) continue;
        double cost = cost_of(&left, begun, leaf) + cost_of(&right[i], above[i], leaf);
        if (!(cost < best->cost)) continue;
        bounds both;
        for (int k = 0; k < 3; k++)
            both.low[k] = fmaxf(left.low[k], right[i].low[k]), both.high[k] = fminf(left.high[k], right[i].high[k]);
        *best = (split){cost, half_area(&both), axis, (float)(low + i * width), cuts};
    }
}

static int bin_of(double x, double low, double width)
{
    double at = (x - low) / width;
    return at > 0 ? at < BINS - 1 ? (int)at : BINS - 1 : 0;
}

static void split_by_middles(const span *s, split *best)
{
    bin bins[BINS];
    for (int axis = 0; axis < 3; axis++) {
        float low = FLT_MAX, high = -FLT_MAX;
        for (size_t i = 0; i < s->count; i++) {
            float m = middle(&s->parts[i], axis);
            low = fminf(low, m), high = fmaxf(high, m);
        }
        double width = ((double)high - (double)low) / BINS;
        if (!(width > 0)) continue;
        clear_bins(bins);
        for (size_t i = 0; i < s->count; i++) {
            bin *b = &bins[bin_of((double)middle(&s->parts[i], axis), (double)low, width)];
            bounds_add(&b->box, s->parts[i].low, s->parts[i].high);
            b->begins++, b->ends++;
        }
        sweep(bins, axis, (double)low, width, false, leaf_cost(s->count), best);
    }
}

/* The part on one side of a plane, with wider bounds, but none wider than they were. */
static daft_part cut(const grower *g, const daft_part *whole, int axis, float at, bool below)
{
    daft_part out = *whole;
    daft_part_clip(g->mesh, &out, axis, at, below);
    for (int k = 0; k < 3; k++) {
        out.low[k] = fmaxf(whole->low[k], out.low[k] - g->pad);
        out.high[k] = fminf(whole->high[k], out.high[k] + g->pad);
    }
    return out;
}

static void split_by_cutting(const grower *g, const span *s, split *best)
{
    bin bins[BINS];
    for (int axis = 0; axis < 3; axis++) {
        double low = (double)s->box.low[axis], width = ((double)s->box.high[axis] - low) / BINS;
        if (!(width > 0) || !(width > 4 * (double)g->pad)) continue;
        clear_bins(bins);
        for (size_t i = 0; i < s->count; i++) {
            daft_part rest = s->parts[i];
            int first = bin_of((double)rest.low[axis], low, width), last = bin_of((double)rest.high[axis], low, width);
            bins[first].begins++, bins[last].ends++;
            for (int b = first; b < last; b++) {
                float at = (float)(low + (b + 1) * width);
                daft_part here = cut(g, &rest, axis, at, true);
                bounds_add(&bins[b].box, here.low, here.high);
                rest = cut(g, &rest, axis, at, false);
            }
            bounds_add(&bins[last].box, rest.low, rest.high);
        }
        sweep(bins, axis, low, width, true, leaf_cost(s->count), best);
    }
}

/* ---- splitting ---- */

static bool span_add(span *s, const daft_part *part)
{
    s->parts[s->count++] = *part;
    bounds_add(&s->box, part->low, part->high);
    return true;
}

/* Gives every part to a side, or to both. False: too many to both, or all to one. */
static bool share(const grower *g, const span *s, split how, span *left, span *right)
{
    left->count = right->count = 0;
    left->box = right->box = bounds_empty();
    for (size_t i = 0; i < s->count; i++) {
        const daft_part *p = &s->parts[i];
        if (!how.cuts) {
            span_add(middle(p, how.axis) < how.at ? left : right, p);
        } else if (p->high[how.axis] <= how.at || p->low[how.axis] >= how.at) {
            span_add(p->high[how.axis] <= how.at ? left : right, p);
        } else {
            daft_part below = cut(g, p, how.axis, how.at, true), above = cut(g, p, how.axis, how.at, false);
            span_add(left, &below);
            span_add(right, &above);
        }
    }
    size_t more = left->count + right->count - s->count;
    if (more > s->repeats || left->count == 0 || right->count == 0) return false;
    left->repeats = (s->repeats - more) * left->count / (left->count + right->count);
    right->repeats = s->repeats - more - left->repeats;
    return true;
}

static void halve(const span *s, span *left, span *right)
{
    left->count = right->count = 0;
    left->box = right->box = bounds_empty();
    for (size_t i = 0; i < s->count; i++) span_add(i < s->count / 2 ? left : right, &s->parts[i]);
    left->repeats = right->repeats = s->repeats / 2;
}

static split find_split(const grower *g, const span *s, split *by_middles)
{
    *by_middles = (split){DBL_MAX, 0, -1, 0, false};
    split_by_middles(s, by_middles);
    split best = *by_middles;
    if (s->repeats > 0 && (best.axis < 0 || best.overlap > OVERLAP * g->whole)) split_by_cutting(g, s, &best);
    return best;
}

/* False: it stays as it is, or memory is out. */
static bool split_span(grower *g, span *s, span *right)
{
    bool may_stay = s->count <= DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK;
    if (s->count <= DAFT_BLOCK) return false;
    split how = {.axis = -1}, by_middles = how;
    if (s->depth < HALVE_BELOW) how = find_split(g, s, &by_middles);
    if (may_stay && (how.axis < 0 || how.cost >= cost_of(&s->box, s->count, leaf_cost(s->count)))) return false;
    span left = {.parts = daft_alloc(g->allocator, s->count, sizeof(daft_part)), .depth = s->depth + 1};
    *right = (span){.parts = daft_alloc(g->allocator, s->count, sizeof(daft_part)), .depth = s->depth + 1};
    if (!left.parts || !right->parts) {
        daft_release(g->allocator, left.parts);
        daft_release(g->allocator, right->parts);
        g->failed = true;
        return false;
    }
    bool shared = (how.axis >= 0 && share(g, s, how, &left, right)) ||
                  (by_middles.axis >= 0 && share(g, s, by_middles, &left, right));
    if (!shared) halve(s, &left, right);
    daft_release(g->allocator, s->parts);
    *s = left;
    return true;
}

/* ---- the tree ---- */

static bool leave(const grower *g, const span *s)
{
    daft_build_sink *sink = g->sink;
    size_t count = sink->number_count;
    if (!daft_grow(g->allocator, &sink->numbers, &sink->number_capacity, count + s->count, count, sizeof *sink->numbers)) return false;
    for (size_t i = 0; i < s->count; i++) sink->numbers[count + i] = s->parts[i].triangle;
    sink->number_count = count + s->count;
    return true;
}

/* A task takes the span's parts. */
static bool defer(grower *g, span *s)
{
    if (!daft_grow(g->allocator, &g->tasks, &g->task_capacity, g->task_count + 1, g->task_count, sizeof *g->tasks)) return false;
    g->tasks[g->task_count++] = *s;
    s->parts = NULL;
    return true;
}

static bool grow(grower *g, span *s);

/* The two sides, or what is not parted; right's parts are used up. */
static bool grow_parts(grower *g, span *s, daft_build_fork *fork)
{
    span right = {.parts = NULL};
    if (g->defer && s->count <= TASK_COUNT) {
        fork->first = (uint32_t)g->task_count;
        return defer(g, s);
    }
    if (!split_span(g, s, &right)) return !g->failed && leave(g, s);
    bool done = grow(g, s);
    fork->right = (uint32_t)(&g->sink->forks[g->sink->count] - fork);
    done = done && grow(g, &right);
    daft_release(g->allocator, right.parts);
    return done;
}

/* Uses up the span's parts. False: memory is out. */
static bool grow(grower *g, span *s)
{
    daft_build_sink *sink = g->sink;
    daft_build_fork *fork = &sink->forks[sink->count++];
    size_t first = sink->number_count;
    for (int k = 0; k < 3; k++) fork->low[k] = s->box.low[k], fork->high[k] = -s->box.high[k];
    fork->right = 0, fork->first = (uint32_t)first, fork->count = daft_build_few(s->count), fork->bundle = 0;
    bool done = grow_parts(g, s, fork);
    if (!g->defer) fork->count = daft_build_few(sink->number_count - first);
    daft_release(g->allocator, s->parts);
    s->parts = NULL;
    return done;
}

/* Its parts may be repeated, and no fork is without one. */
static bool reserve(grower *g, const span *s) { return daft_build_reserve(g->allocator, g->sink, 2 * (s->count + s->repeats), 0); }

/* ---- threads ---- */

typedef struct spatial_job {
    daft_build *build;
    grower top;
} spatial_job;

static void run_task(void *context, uint32_t index, uint32_t worker)
{
    spatial_job *job = context;
    daft_build_task *task = &job->build->tasks[index];
    daft_build_sink *sink = &job->build->sinks[index];
    (void)worker;
    grower g = job->top;
    g.sink = sink, g.defer = false;
    if (!reserve(&g, &job->top.tasks[index])) return;
    daft_build_fork *forks = sink->forks + sink->count;
    if (!grow(&g, &job->top.tasks[index])) return;
    daft_build_weigh(&job->build->rule, forks, (size_t)(sink->forks + sink->count - forks));
    task->forks = forks, task->numbers = sink->numbers;
}

static bool first_span(const grower *g, span *whole)
{
    uint32_t count = g->mesh->triangle_count;
    *whole = (span){.parts = daft_alloc(g->allocator, count, sizeof(daft_part)), .repeats = (size_t)(REPEATS * count), .box = bounds_empty()};
    for (uint32_t i = 0; whole->parts && i < count; i++) {
        daft_part part = daft_part_of(g->mesh, i);
        span_add(whole, &part);
    }
    return whole->parts != NULL;
}

static bool run_all(daft_build *build, spatial_job *job)
{
    grower *top = &job->top;
    span whole;
    if (!first_span(top, &whole)) return false;
    for (int k = 0; k < 3; k++) top->pad = fmaxf(top->pad, PAD * fmaxf(fabsf(whole.box.low[k]), fabsf(whole.box.high[k])));
    top->whole = half_area(&whole.box);
    top->sink = &build->top;
    top->defer = true;
    bool small = whole.count <= TASK_COUNT; /* one task, and nothing above it */
    if (!reserve(top, &whole) || !(small ? defer(top, &whole) : grow(top, &whole))) {
        daft_release(build->allocator, whole.parts);
        return false;
    }
    build->tasks = daft_alloc_zero(build->allocator, top->task_count, sizeof *build->tasks);
    build->sinks = daft_alloc_zero(build->allocator, top->task_count, sizeof *build->sinks);
    if (!build->tasks || !build->sinks) return false;
    build->task_count = build->sink_count = top->task_count;
    daft_team_for(build->team, (uint32_t)build->task_count, run_task, job);
    return daft_build_collapse(build);
}

bool daft_build_spatial(daft_build *build, const daft_trimesh *mesh)
{
    spatial_job job = {.build = build, .top = {.allocator = build->allocator, .mesh = mesh}};
    bool done = run_all(build, &job);
    for (size_t i = 0; i < job.top.task_count; i++) daft_release(build->allocator, job.top.tasks[i].parts);
    daft_release(build->allocator, job.top.tasks);
    return done;
}
