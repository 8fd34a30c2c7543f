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
#define NODE_COST 1.25 /* as in build_kernel.c */
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
    bool leaf;
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

static double cost_of(const bounds *b, size_t count) { return half_area(b) * (double)((count + DAFT_BLOCK - 1) / DAFT_BLOCK); }

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
static void sweep(const bin bins[BINS], int axis, double low, double width, bool cuts, split *best)
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
        double cost = cost_of(&left, begun) + cost_of(&right[i], above[i]);
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
        sweep(bins, axis, (double)low, width, false, best);
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
        sweep(bins, axis, low, width, true, best);
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
    if (s->leaf || s->count <= DAFT_BLOCK) return false;
    split how = {.axis = -1}, by_middles = how;
    if (s->depth < HALVE_BELOW) how = find_split(g, s, &by_middles);
    if (may_stay && (how.axis < 0 || how.cost + NODE_COST * half_area(&s->box) >= cost_of(&s->box, s->count))) return false;
    span left = {.parts = daft_alloc(g->allocator, s->count, sizeof(daft_part)), .depth = s->depth};
    *right = (span){.parts = daft_alloc(g->allocator, s->count, sizeof(daft_part)), .depth = s->depth};
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

static int widest_open(const span *spans, int count)
{
    int best = -1;
    double most = -1;
    for (int i = 0; i < count; i++) {
        double size = spans[i].depth < HALVE_BELOW ? half_area(&spans[i].box) : (double)spans[i].count;
        if (!spans[i].leaf && size > most) most = size, best = i;
    }
    return best;
}

/* ---- the tree ---- */

static uint32_t leaf_add(const grower *g, const span *s)
{
    daft_build_sink *sink = g->sink;
    uint32_t blocks = (uint32_t)((s->count + DAFT_BLOCK - 1) / DAFT_BLOCK), first = (uint32_t)sink->block_count;
    if (!daft_grow(g->allocator, &sink->blocks, &sink->block_capacity, first + blocks, first, sizeof *sink->blocks))
        return DAFT_CHILD_NONE;
    for (size_t i = 0; i < (size_t)blocks * DAFT_BLOCK; i++)
        sink->blocks[first + i / DAFT_BLOCK][i % DAFT_BLOCK] = i < s->count ? s->parts[i].triangle : DAFT_NO_TRIANGLE;
    sink->block_count += blocks;
    return DAFT_CHILD_LEAF | first << 2 | (blocks - 1);
}

static void node_fill(daft_node *node, const bounds *boxes, const uint32_t *codes, int count)
{
    for (int i = 0; i < DAFT_WIDTH; i++) {
        node->child[i] = i < count ? codes[i] : DAFT_CHILD_NONE, node->none[i] = 0;
        for (int k = 0; k < 3; k++) {
            node->bounds[k][i] = i < count ? boxes[i].low[k] : INFINITY;
            node->bounds[k + 3][i] = i < count ? boxes[i].high[k] : -INFINITY;
        }
    }
}

/* A task takes the span's parts. */
static uint32_t defer(grower *g, span *s)
{
    if (!daft_grow(g->allocator, &g->tasks, &g->task_capacity, g->task_count + 1, g->task_count, sizeof *g->tasks)) return DAFT_CHILD_NONE;
    g->tasks[g->task_count] = *s;
    s->parts = NULL;
    return DAFT_CHILD_LEAF | (uint32_t)g->task_count++;
}

static uint32_t grow(grower *g, span *whole, bool root);

static uint32_t grow_child(grower *g, span *s)
{
    if (g->defer && s->count <= TASK_COUNT) return defer(g, s);
    return s->leaf || s->count <= DAFT_BLOCK ? leaf_add(g, s) : grow(g, s, false);
}

/* Uses up the span's parts. */
static uint32_t grow(grower *g, span *whole, bool root)
{
    span spans[DAFT_WIDTH] = {*whole};
    bounds boxes[DAFT_WIDTH];
    uint32_t codes[DAFT_WIDTH], self = DAFT_CHILD_NONE;
    int count = 1, open = 0;
    whole->parts = NULL;
    for (; count < DAFT_WIDTH && open >= 0; open = widest_open(spans, count)) {
        if (split_span(g, &spans[open], &spans[count]))
            count++;
        else
            spans[open].leaf = true;
    }
    daft_node_list *nodes = &g->sink->nodes;
    bool single = count == 1 && !root && !g->defer;
    bool good = !g->failed && (single || daft_grow(g->allocator, &nodes->items, &nodes->capacity, nodes->count + 1, nodes->count, sizeof(daft_node)));
    if (good && single) self = leaf_add(g, &spans[0]);
    if (good && !single) self = (uint32_t)nodes->count++;
    for (int i = 0; i < count; i++) {
        boxes[i] = spans[i].box;
        spans[i].depth += 3;
        if (good && !single) codes[i] = grow_child(g, &spans[i]), good = codes[i] != DAFT_CHILD_NONE;
        daft_release(g->allocator, spans[i].parts);
    }
    if (good && !single) node_fill(&nodes->items[self], boxes, codes, count);
    return good ? self : DAFT_CHILD_NONE;
}

/* ---- threads ---- */

typedef struct spatial_job {
    daft_build *build;
    grower top;
} spatial_job;

static void run_task(void *context, uint32_t index, uint32_t worker)
{
    spatial_job *job = context;
    daft_build_task *task = &job->build->tasks[index];
    daft_build_sink *sink = &job->build->sinks[worker];
    grower g = job->top;
    g.sink = task->sink = sink, g.defer = false;
    task->node_first = sink->nodes.count, task->block_first = sink->block_count;
    span *s = &job->top.tasks[index];
    task->code = job->build->top.nodes.count == 0 ? grow(&g, s, true) : grow_child(&g, s);
    daft_release(g.allocator, s->parts);
    s->parts = NULL;
    task->node_count = sink->nodes.count - task->node_first;
    task->block_count = sink->block_count - task->block_first;
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
    build->sink_count = (size_t)daft_max_i(build->threads, 1);
    build->sinks = daft_alloc_zero(build->allocator, build->sink_count, sizeof *build->sinks);
    bool small = whole.count <= TASK_COUNT; /* one task, which has the root */
    if (!build->sinks || (small ? defer(top, &whole) : grow(top, &whole, true)) == DAFT_CHILD_NONE) {
        daft_release(build->allocator, whole.parts);
        return false;
    }
    build->tasks = daft_alloc_zero(build->allocator, top->task_count, sizeof *build->tasks);
    if (!build->tasks) return false;
    build->task_count = top->task_count;
    daft_team_for(build->team, (uint32_t)build->task_count, run_task, job);
    return daft_build_place(build);
}

bool daft_build_spatial(daft_build *build, const daft_trimesh *mesh)
{
    build->top.allocator = build->allocator;
    spatial_job job = {.build = build, .top = {.allocator = build->allocator, .mesh = mesh}};
    bool done = run_all(build, &job);
    for (size_t i = 0; i < job.top.task_count; i++) daft_release(build->allocator, job.top.tasks[i].parts);
    daft_release(build->allocator, job.top.tasks);
    return done;
}
