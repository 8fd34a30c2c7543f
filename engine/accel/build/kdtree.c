/* Building the kd-tree: top-down by the surface-area heuristic, triangles clipped to the cells they straddle ("perfect
 * splits"), O(n log n) (Wald and Havran, "On building fast kd-Trees for Ray Tracing, and on doing that in O(N log N)",
 * 2006). Above FEW triangles planes are looked for among BINS of each axis (Shevtsov, Soupikov, Kapustin, "Highly
 * Parallel Fast KD-tree Construction", 2007); below, at every side of every triangle's box.
 *
 * Depth is bounded by the logarithm of the number of triangles, and how often triangles are repeated by REPEATS in the
 * mean; each subtree has its part of that, so the tree is the same for any number of threads. */
#include "accel/bvh.h"
#include "accel/build/clip.h"
#include "accel/kdtree.h"

#include <float.h>
#include <math.h>

enum { FEW = 20, BINS = 32, REPEATS = 3, TASK_COUNT = 4096 };
#define STEP_COST   1.0f /* of a plane's test, where a block of four triangles costs 1: measured */
#define EMPTY_BONUS 0.8f /* a cell with nothing in it is passed quickly */
#define LITTLE      1e-6 /* of the longest side: cells without area are still told apart */

typedef daft_part ref; /* within a cell */

typedef struct cell {
    float low[3], high[3];
} cell;

typedef struct task {
    cell cell;
    ref *refs;
    uint32_t count, depth;
    size_t repeats;
    size_t slot; /* the node among those of the top */
} task;

/* A part of the tree under construction. refs is a stack: the path's on top of each other. */
typedef struct part {
    const daft_allocator *allocator;
    const daft_trimesh *mesh;
    ref *refs;
    size_t ref_capacity;
    daft_kd_node *nodes;
    size_t node_count, node_capacity;
    uint32_t *items;
    size_t item_count, item_capacity;
    task *tasks; /* where cells with few triangles are left to others */
    size_t task_count, task_capacity;
    bool defer, failed;
} part;

typedef struct plane {
    double cost;
    int axis;
    float at;
} plane;

static uint32_t blocks_of(size_t count) { return (uint32_t)((count + DAFT_BLOCK - 1) / DAFT_BLOCK); }

/* ---- where to cut ---- */

typedef struct price {
    double side[3], area, little;
} price;

static double half_area(double x, double y, double z) { return x * (y + z) + y * z; }

static price price_of(const cell *c)
{
    price p;
    double longest = 0;
    for (int k = 0; k < 3; k++) {
        p.side[k] = (double)c->high[k] - (double)c->low[k];
        longest = fmax(longest, p.side[k]);
    }
    p.little = longest * LITTLE;
    p.area = half_area(p.side[0] + p.little, p.side[1] + p.little, p.side[2] + p.little);
    return p;
}

/* Takes the plane if it is better than the best so far. */
static void offer(const price *p, const cell *c, int axis, float at, size_t below, size_t above, plane *best)
{
    double a = p->side[(axis + 1) % 3] + p->little, b = p->side[(axis + 2) % 3] + p->little;
    double near = (double)at - (double)c->low[axis] + p->little, far = (double)c->high[axis] - (double)at + p->little;
    double sum = half_area(near, a, b) * blocks_of(below) + half_area(far, a, b) * blocks_of(above);
    double cost = (double)STEP_COST + sum / p->area * (below == 0 || above == 0 ? (double)EMPTY_BONUS : 1);
    if (cost < best->cost && at > c->low[axis] && at < c->high[axis]) *best = (plane){cost, axis, at};
}

static void offer_bins(const price *p, const cell *c, const ref *refs, size_t count, int axis, plane *best)
{
    uint32_t begin[BINS] = {0}, end[BINS] = {0};
    double scale = BINS / p->side[axis];
    if (!(p->side[axis] > 0) || !(scale <= DBL_MAX)) return;
    for (size_t i = 0; i < count; i++) {
        double low = ((double)refs[i].low[axis] - (double)c->low[axis]) * scale;
        double high = ((double)refs[i].high[axis] - (double)c->low[axis]) * scale;
        begin[low > 0 ? low < BINS - 1 ? (int)low : BINS - 1 : 0]++;
        end[high > 0 ? high < BINS - 1 ? (int)high : BINS - 1 : 0]++;
    }
    size_t below = 0, above = count;
    for (int i = 1; i < BINS; i++) {
        below += begin[i - 1], above -= end[i - 1];
        offer(p, c, axis, (float)((double)c->low[axis] + i / scale), below, above, best);
    }
}

static void sort(float *values, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        float value = values[i];
        size_t k = i;
        for (; k > 0 && values[k - 1] > value; k--) values[k] = values[k - 1];
        values[k] = value;
    }
}

/* Every side of every box; what lies in the plane itself counts on both sides. */
static void offer_sides(const price *p, const cell *c, const ref *refs, size_t count, int axis, plane *best)
{
    float low[FEW], high[FEW];
    for (size_t i = 0; i < count; i++) low[i] = refs[i].low[axis], high[i] = refs[i].high[axis];
    sort(low, count);
    sort(high, count);
    for (size_t i = 0, below = 0, passed = 0; i < 2 * count; i++) {
        float at = i < count ? low[i] : high[i - count];
        if (i == count) below = passed = 0;
        while (below < count && low[below] < at) below++;
        while (passed < count && high[passed] <= at) passed++;
        offer(p, c, axis, at, below, count - passed, best);
    }
}

static plane find_plane(const cell *c, const ref *refs, size_t count)
{
    price p = price_of(c);
    plane best = {blocks_of(count), -1, 0};
    if (!(p.area > 0) || !(p.area <= DBL_MAX)) return best;
    for (int axis = 0; axis < 3; axis++) {
        if (count > FEW)
            offer_bins(&p, c, refs, count, axis, &best);
        else
            offer_sides(&p, c, refs, count, axis, &best);
    }
    return best;
}

/* ---- cutting ---- */

static bool reaches(const ref *r, plane cut, bool below)
{
    if (r->low[cut.axis] == cut.at && r->high[cut.axis] == cut.at) return true;
    return below ? r->low[cut.axis] < cut.at : r->high[cut.axis] > cut.at;
}

/* Copies what reaches one side to `out`. */
static void take_side(const daft_trimesh *mesh, const ref *refs, size_t count, plane cut, bool below, ref *out)
{
    for (size_t i = 0; i < count; i++) {
        if (!reaches(&refs[i], cut, below)) continue;
        *out = refs[i];
        if (refs[i].low[cut.axis] < cut.at && refs[i].high[cut.axis] > cut.at)
            daft_part_clip(mesh, out, cut.axis, cut.at, below);
        out++;
    }
}

static size_t count_side(const ref *refs, size_t count, plane cut, bool below)
{
    size_t reached = 0;
    for (size_t i = 0; i < count; i++) reached += reaches(&refs[i], cut, below);
    return reached;
}

/* ---- the tree ---- */

static bool leaf(part *p, size_t slot, const ref *refs, size_t count)
{
    if (!daft_grow(p->allocator, &p->items, &p->item_capacity, p->item_count + count, p->item_count, sizeof *p->items))
        return false;
    p->nodes[slot] = (daft_kd_node){.count = (uint32_t)count, .code = (uint32_t)p->item_count << 2 | DAFT_KD_LEAF};
    for (size_t i = 0; i < count; i++) p->items[p->item_count++] = refs[i].triangle;
    return true;
}

/* Leaves a cell to a task of its own. */
static bool defer(part *p, const task *t, size_t first)
{
    if (!daft_grow(p->allocator, &p->tasks, &p->task_capacity, p->task_count + 1, p->task_count, sizeof *p->tasks))
        return false;
    ref *refs = daft_alloc(p->allocator, t->count, sizeof *refs);
    if (!refs) return false;
    memcpy(refs, p->refs + first, t->count * sizeof *refs);
    p->tasks[p->task_count] = *t;
    p->tasks[p->task_count++].refs = refs;
    return true;
}

static bool grow_node(part *p, const task *t, size_t first);

/* Both sides of the cut: the upper side's triangles lie below the lower side's on the stack, which is built first. */
static bool grow_sides(part *p, const task *t, size_t first, plane cut, size_t below, size_t above)
{
    size_t top = first + t->count, pair = p->node_count, spare = t->repeats - (below + above - t->count);
    if (!daft_grow(p->allocator, &p->refs, &p->ref_capacity, top + below + above, top, sizeof *p->refs) ||
        !daft_grow(p->allocator, &p->nodes, &p->node_capacity, pair + 2, pair, sizeof *p->nodes))
        return false;
    p->node_count += 2;
    p->nodes[t->slot] = (daft_kd_node){.split = cut.at, .code = (uint32_t)pair << 2 | (uint32_t)cut.axis};
    take_side(p->mesh, p->refs + first, t->count, cut, false, p->refs + top);
    take_side(p->mesh, p->refs + first, t->count, cut, true, p->refs + top + above);
    size_t lower_spare = spare * below / (below + above);
    task lower = {t->cell, NULL, (uint32_t)below, t->depth + 1, lower_spare, pair};
    task upper = {t->cell, NULL, (uint32_t)above, t->depth + 1, spare - lower_spare, pair + 1};
    lower.cell.high[cut.axis] = upper.cell.low[cut.axis] = cut.at;
    return grow_node(p, &lower, top + above) && grow_node(p, &upper, top);
}

static bool grow_node(part *p, const task *t, size_t first)
{
    if (p->defer && t->count > 0 && t->count <= TASK_COUNT) return defer(p, t, first);
    plane cut = {0, -1, 0};
    if (t->count > 1 && t->depth < DAFT_KD_DEPTH) cut = find_plane(&t->cell, p->refs + first, t->count);
    if (cut.axis >= 0) {
        size_t below = count_side(p->refs + first, t->count, cut, true);
        size_t above = count_side(p->refs + first, t->count, cut, false);
        bool parts = below + above <= t->count + t->repeats && (below < t->count || above < t->count);
        if (parts) return grow_sides(p, t, first, cut, below, above);
    }
    return leaf(p, t->slot, p->refs + first, t->count);
}

static bool plant(part *p, task *t)
{
    t->slot = 0;
    p->nodes = daft_alloc(p->allocator, 64, sizeof *p->nodes);
    p->node_capacity = 64;
    p->node_count = 1;
    return p->nodes && grow_node(p, t, 0);
}

/* ---- threads ---- */

typedef struct kd_job {
    const daft_allocator *allocator;
    const daft_trimesh *mesh;
    part top;
    part *parts; /* of the tasks */
    size_t *node_base, *item_base;
    daft_kdtree *tree;
} kd_job;

static void run_task(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    kd_job *job = context;
    task *t = &job->top.tasks[index];
    part *p = &job->parts[index];
    task root = *t;
    *p = (part){.allocator = job->allocator, .mesh = job->mesh, .refs = t->refs, .ref_capacity = t->count};
    t->refs = NULL; /* the part's now */
    p->failed = !plant(p, &root);
    daft_release(job->allocator, p->refs);
    p->refs = NULL;
}

static daft_kd_node moved(daft_kd_node node, size_t node_base, size_t item_base)
{
    node.code += (uint32_t)(((node.code & 3) == DAFT_KD_LEAF ? item_base : node_base) << 2);
    return node;
}

/* A task's nodes follow each other; its root stands in the top, too, where its parent looks for it. */
static void write_task(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    kd_job *job = context;
    const part *p = &job->parts[index];
    size_t node_base = job->node_base[index], item_base = job->item_base[index];
    for (size_t i = 0; i < p->node_count; i++)
        job->tree->nodes[node_base + i] = moved(p->nodes[i], node_base, item_base);
    if (p->item_count) memcpy(job->tree->items + item_base, p->items, p->item_count * sizeof *p->items);
    job->tree->nodes[job->top.tasks[index].slot] = moved(p->nodes[0], node_base, item_base);
}

static bool write_tree(kd_job *job, int threads)
{
    daft_kdtree *tree = job->tree;
    size_t count = job->top.task_count, nodes = job->top.node_count, items = job->top.item_count;
    job->node_base = daft_alloc(job->allocator, count, sizeof *job->node_base);
    job->item_base = daft_alloc(job->allocator, count, sizeof *job->item_base);
    if (!job->node_base || !job->item_base) return false;
    for (size_t i = 0; i < count; i++) {
        job->node_base[i] = nodes, job->item_base[i] = items;
        nodes += job->parts[i].node_count, items += job->parts[i].item_count;
    }
    tree->nodes = daft_alloc(job->allocator, nodes, sizeof *tree->nodes);
    tree->items = daft_alloc(job->allocator, items, sizeof *tree->items);
    if (!tree->nodes || !tree->items) return false;
    tree->node_count = nodes, tree->item_count = items;
    memcpy(tree->nodes, job->top.nodes, job->top.node_count * sizeof *tree->nodes);
    if (job->top.item_count) memcpy(tree->items, job->top.items, job->top.item_count * sizeof *tree->items);
    daft_parallel_for(threads, (uint32_t)count, write_task, job);
    return true;
}

static void part_free(part *p)
{
    daft_release(p->allocator, p->refs);
    daft_release(p->allocator, p->nodes);
    daft_release(p->allocator, p->items);
    for (size_t i = 0; i < p->task_count; i++) daft_release(p->allocator, p->tasks[i].refs);
    daft_release(p->allocator, p->tasks);
}

static bool make_refs(const daft_trimesh *mesh, part *top)
{
    top->refs = daft_alloc(top->allocator, mesh->triangle_count, sizeof *top->refs);
    if (!top->refs) return false;
    top->ref_capacity = mesh->triangle_count;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) top->refs[i] = daft_part_of(mesh, i);
    return true;
}

static bool make_corners(const daft_trimesh *mesh, daft_kdtree *tree)
{
    tree->corners = daft_alloc(&tree->allocator, 3 * (size_t)mesh->triangle_count, sizeof *tree->corners);
    if (!tree->corners) return false;
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        uint32_t v = mesh->indices[i];
        tree->corners[i] = (v4){mesh->x[v], mesh->y[v], mesh->z[v], 0};
    }
    return true;
}

static bool build_tree(kd_job *job, int threads)
{
    const daft_trimesh *mesh = job->mesh;
    task whole = {.count = mesh->triangle_count, .repeats = REPEATS * (size_t)mesh->triangle_count + 64};
    for (int k = 0; k < 3; k++)
        whole.cell.low[k] = daft_v3_at(mesh->low, k), whole.cell.high[k] = daft_v3_at(mesh->high, k);
    for (uint32_t n = mesh->triangle_count; n > 0; n /= 2)
        whole.depth += 2; /* counts down from the deepest there may be */
    whole.depth = DAFT_KD_DEPTH - daft_min_u(whole.depth + 8, DAFT_KD_DEPTH);
    job->top = (part){.allocator = job->allocator, .mesh = mesh, .defer = mesh->triangle_count > TASK_COUNT};
    if (!make_refs(mesh, &job->top) || !plant(&job->top, &whole)) return false;
    job->parts = daft_alloc_zero(job->allocator, job->top.task_count, sizeof *job->parts);
    if (!job->parts) return false;
    daft_parallel_for(threads, (uint32_t)job->top.task_count, run_task, job);
    bool failed = false;
    for (size_t i = 0; i < job->top.task_count; i++) failed |= job->parts[i].failed;
    return !failed && write_tree(job, threads) && make_corners(mesh, job->tree);
}

daft_kdtree *daft_kdtree_build(const daft_allocator *allocator, const daft_trimesh *mesh, int threads,
                               daft_error *error)
{
    daft_kdtree *tree = daft_alloc_zero(allocator, 1, sizeof *tree);
    bool built = false;
    if (tree) {
        tree->allocator = *allocator;
        tree->triangle_count = mesh->triangle_count;
        tree->low = mesh->low, tree->high = mesh->high;
        kd_job job = {.allocator = allocator, .mesh = mesh, .tree = tree, .top.allocator = allocator};
        built = mesh->triangle_count == 0 || build_tree(&job, threads);
        for (size_t i = 0; job.parts && i < job.top.task_count; i++)
            if (job.parts[i].allocator) part_free(&job.parts[i]);
        part_free(&job.top);
        daft_release(allocator, job.parts);
        daft_release(allocator, job.node_base);
        daft_release(allocator, job.item_base);
    }
    if (built) return tree;
    daft_kdtree_free(tree);
    daft_fail_memory(error, "the kd-tree of a mesh");
    return NULL;
}

void daft_kdtree_free(daft_kdtree *tree)
{
    if (!tree) return;
    daft_allocator allocator = tree->allocator;
    daft_release(&allocator, tree->nodes);
    daft_release(&allocator, tree->items);
    daft_release(&allocator, tree->corners);
    daft_release(&allocator, tree);
}

size_t daft_kdtree_bytes(const daft_kdtree *tree)
{
    return sizeof *tree + tree->node_count * sizeof *tree->nodes + tree->item_count * sizeof *tree->items +
           3 * (size_t)tree->triangle_count * sizeof *tree->corners;
}
