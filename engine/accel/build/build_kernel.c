/* The builder's loops: top-down binned SAH (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
 * 2007), recursively in two; collapse.c then chooses which ranges become nodes. Below MEDIAN_DEPTH, and where no plane
 * separates the box centres, ranges are halved by count, so the depth is bounded for any input and the time is O(n log
 * n).
 *
 * Prims are moved between two buffers, the left side from the front and the right side from the back, without a branch.
 * Areas are those of sides longer by a little, so that boxes without area are still told apart by their length and
 * their number. */
#include "accel/build/build.h"

#include <float.h>

/* Below MEDIAN_DEPTH there are at most the 29 halvings of 2^31 prims into blocks, so nodes stand at most 70 deep, and
 * what waits of each level fits in DAFT_STACK. */
enum { FEW_PRIMS = 16, FEW_BINS = 8, MORE_PRIMS = 64, MORE_BINS = 16, MAX_BINS = 32 };
enum { MEDIAN_DEPTH = 40, TASK_CELLS = 64, TASK_WEIGHT = 512 };
#define WORTH      0.9f   /* what two leaves may cost where one would do: there is seldom room for both in a node */
#define LITTLE     1e-6f  /* of the longest side */
#define LEAST_SIDE 1e-12f /* between these, areas neither underflow nor overflow; ranges beyond are halved */
#define MOST_SIDE  1e15f

typedef daft_build_range range;
typedef daft_build_prim prim;

static const union {
    int32_t bits[4];
    v4i lanes;
} XYZ = {{-1, -1, -1, 0}};

DAFT_INLINE v8 box_empty(void) { return v8_set(FLT_MAX); }
DAFT_INLINE v8 prim_box(const prim *p) { return v8_load(p->low); }
DAFT_INLINE v4 prim_middle(const prim *p) { return (v4)((v4i)(v4_load(p->low) - v4_load(p->high)) & XYZ.lanes); }

static void measure(const prim *prims, range *r)
{
    v8 box = box_empty(), middles = box_empty();
    uint32_t weight = 0;
    for (uint32_t i = r->first; i < r->first + r->count; i++) {
        v4 c = prim_middle(&prims[i]);
        box = v8_min(box, prim_box(&prims[i]));
        middles = v8_min(middles, v8_combine(-c, c));
        weight += prims[i].weight;
    }
    r->box = box, r->middles = middles, r->weight = weight;
}

/* ---- where to split ---- */

/* From middles to bins: the one formula that counting and partitioning share. */
typedef struct binning {
    v4 low, scale;
    int count;
    float little; /* added to sides; 0: areas tell nothing apart */
} binning;

typedef struct bins {
    v8 box[3][MAX_BINS];
    int32_t weight[MAX_BINS][4]; /* by axis */
} bins;

typedef struct split {
    float cost;
    int axis;
    int at; /* bins below it go left */
} split;

static binning binning_of(const range *r)
{
    binning b = {.low = v8_lower_half(r->middles),
                 .count = r->count <= FEW_PRIMS    ? FEW_BINS
                          : r->count <= MORE_PRIMS ? MORE_BINS
                                                   : MAX_BINS};
    v4 extent = -(b.low + v8_upper_half(r->middles)), side = -(v8_lower_half(r->box) + v8_upper_half(r->box));
    float longest = 0;
    b.low[3] = 0, b.scale = v4_set(0);
    for (int k = 0; k < 3; k++) {
        if (!(extent[k] <= FLT_MAX && side[k] <= FLT_MAX)) return b; /* overflows: in the middle, then */
        float scale = extent[k] > 0 ? (float)b.count * 0.999f / extent[k] : 0;
        b.scale[k] = scale <= FLT_MAX ? scale : 0; /* among denormals it overflows */
        longest = side[k] > longest ? side[k] : longest;
    }
    b.little = longest >= LEAST_SIDE && longest <= MOST_SIDE ? longest * LITTLE : 0;
    return b;
}

DAFT_INLINE v4 place_of(const binning *b, const prim *p) { return (prim_middle(p) - b->low) * b->scale; }

static void fill_bins(const range *r, const prim *prims, const binning *how, bins *out)
{
    for (int i = 0; i < how->count; i++) {
        for (int k = 0; k < 3; k++) out->box[k][i] = box_empty();
        for (int k = 0; k < 4; k++) out->weight[i][k] = 0;
    }
    for (uint32_t i = r->first; i < r->first + r->count; i++) {
        v8 box = prim_box(&prims[i]);
        v4i at = v4i_convert_to(place_of(how, &prims[i]));
        for (int k = 0; k < 3; k++) {
            out->box[k][at[k]] = v8_min(out->box[k][at[k]], box);
            out->weight[at[k]][k] += (int32_t)prims[i].weight;
        }
    }
}

DAFT_INLINE v4 box_sides(v8 box, float little) { return v4_set(little) - (v8_lower_half(box) + v8_upper_half(box)); }

/* Half the surface. */
DAFT_INLINE float box_area(v8 box, float little)
{
    v4 e = box_sides(box, little);
    return e[0] * (e[1] + e[2]) + e[1] * e[2];
}

/* Lane k: of box k. */
DAFT_INLINE v4 box_areas(const v8 box[3], float little)
{
    v4 x, y, z;
    v4_transpose3(box_sides(box[0], little), box_sides(box[1], little), box_sides(box[2], little), &x, &y, &z);
    return x * (y + z) + y * z;
}

typedef struct cost_rule {
    v4i round;
    int shift;
} cost_rule;

/* Only the block sizes 1 and 4 occur. */
DAFT_INLINE cost_rule cost_rule_of(const daft_build_rule *rule)
{
    int32_t round = (int32_t)rule->block_size - 1;
    return (cost_rule){{round, round, round, round}, rule->block_size == 1 ? 0 : 2};
}

DAFT_INLINE v4 costs(const v8 box[3], float little, v4i weight, cost_rule rule)
{
    v4 cost = box_areas(box, little) * __builtin_convertvector((weight + rule.round) >> rule.shift, v4);
    return v4_if_then_else((v4i)(weight == (v4i){0, 0, 0, 0}), v4_set(INFINITY), cost);
}

static split find_split(const daft_build_rule *build_rule, const bins *in, const binning *how)
{
    v4 right[MAX_BINS], best = v4_set(INFINITY);
    v4i weight = {0, 0, 0, 0}, best_at = {0, 0, 0, 0};
    v8 sum[3] = {box_empty(), box_empty(), box_empty()};
    cost_rule rule = cost_rule_of(build_rule);
    for (int i = how->count - 1; i > 0; i--) {
        weight += *(const v4i *)in->weight[i];
        for (int k = 0; k < 3; k++) sum[k] = v8_min(sum[k], in->box[k][i]);
        right[i] = costs(sum, how->little, weight, rule);
    }
    weight = (v4i){0, 0, 0, 0};
    for (int k = 0; k < 3; k++) sum[k] = box_empty();
    for (int i = 1; i < how->count; i++) {
        weight += *(const v4i *)in->weight[i - 1];
        for (int k = 0; k < 3; k++) sum[k] = v8_min(sum[k], in->box[k][i - 1]);
        v4 cost = costs(sum, how->little, weight, rule) + right[i];
        v4i better = (v4i)(cost < best);
        best = v4_if_then_else(better, cost, best);
        best_at = (better & (v4i){i, i, i, i}) | (~better & best_at);
    }
    split s = {INFINITY, -1, 0};
    for (int k = 0; k < 3; k++)
        if (best[k] < s.cost) s = (split){best[k], k, best_at[k]};
    return s;
}

/* ---- splitting ---- */

static const union {
    float push[2][8];
    v8 lanes[2];
} SIDE = {{{-INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY},
           {INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY}}};

/* Into the other buffer; where both sides are, and their middles. */
static void partition(daft_build_prim *const prims[2], const range *r, const binning *how, split s, range *left,
                      range *right)
{
    const prim *in = prims[r->side] + r->first;
    prim *out = prims[1 - r->side] + r->first, *front = out, *back = out + r->count - 1;
    v8 middles[2] = {box_empty(), box_empty()};
    v4 limit = v4_set(INFINITY);
    limit[s.axis] = (float)s.at;
    for (uint32_t i = 0; i < r->count; i++) {
        v8 box = prim_box(&in[i]);
        v4 c = prim_middle(&in[i]);
        v8 both = v8_combine(-c, c);
        uint32_t goes_right = v4_bits_from_mask((v4i)((c - how->low) * how->scale >= limit)) != 0;
        memcpy(front, &box, sizeof box);
        memcpy(back, &box, sizeof box);
        middles[0] = v8_min(middles[0], v8_max(both, SIDE.lanes[goes_right]));
        middles[1] = v8_min(middles[1], v8_max(both, SIDE.lanes[1 - goes_right]));
        front += 1 - goes_right, back -= goes_right;
    }
    left->side = right->side = (uint8_t)(1 - r->side);
    left->first = r->first, left->count = (uint32_t)(front - out), left->middles = middles[0];
    right->first = r->first + left->count, right->count = r->count - left->count, right->middles = middles[1];
}

/* Boxes and weights of both sides. */
static void share_bins(const bins *in, const binning *how, split s, uint32_t weight, range *left, range *right)
{
    left->box = right->box = box_empty();
    left->weight = 0;
    for (int i = 0; i < how->count; i++) {
        range *to = i < s.at ? left : right;
        to->box = v8_min(to->box, in->box[s.axis][i]);
        if (i < s.at) left->weight += (uint32_t)in->weight[i][s.axis];
    }
    right->weight = weight - left->weight;
}

static void halve(daft_build_prim *const prims[2], const range *r, range *left, range *right)
{
    uint32_t half = r->count / 2;
    *left = (range){.first = r->first, .count = half, .side = r->side};
    *right = (range){.first = r->first + half, .count = r->count - half, .side = r->side};
    measure(prims[r->side], left);
    measure(prims[r->side], right);
}

DAFT_INLINE float leaf_cost(const daft_build_rule *rule, const range *r, float little)
{
    uint32_t blocks = (r->weight + rule->block_size - 1) / rule->block_size;
    return box_area(r->box, little) * (DAFT_LEAF_COST + DAFT_BLOCK_COST * (float)blocks);
}

/* False: the range is to stay as it is. */
static __attribute__((noinline)) bool split_range(const daft_build_branch *branch, const range *r, range *left,
                                                  range *right)
{
    const daft_build_rule *rule = branch->rule;
    if (r->count <= 1 || r->weight <= rule->block_size) return false;
    split s = {INFINITY, -1, 0};
    if (r->depth < MEDIAN_DEPTH) {
        binning how = binning_of(r);
        bins sorted;
        if (how.little > 0) {
            fill_bins(r, branch->prims[r->side], &how, &sorted);
            s = find_split(rule, &sorted, &how);
        }
        if (s.axis >= 0) share_bins(&sorted, &how, s, r->weight, left, right);
        if (r->weight <= rule->leaf_size) {
            float l = how.little;
            if (s.axis < 0 || leaf_cost(rule, left, l) + leaf_cost(rule, right, l) >= WORTH * leaf_cost(rule, r, l))
                return false;
        }
        if (s.axis >= 0) partition(branch->prims, r, &how, s, left, right);
    }
    if (s.axis < 0) halve(branch->prims, r, left, right);
    left->depth = right->depth = (uint8_t)(r->depth + 1);
    return true;
}

/* ---- the tree of forks ---- */

static bool defer(daft_build_branch *branch, const range *r, daft_build_fork *fork)
{
    if (!daft_grow(branch->allocator, &branch->tasks, &branch->task_capacity, branch->task_count + 1,
                   branch->task_count, sizeof *branch->tasks))
        return false;
    fork->first = (uint32_t)branch->task_count;
    branch->tasks[branch->task_count++] = (daft_build_task){.range = *r};
    return true;
}

/* Prims that are leaves each, eight or fewer: one by one behind their fork. */
static void bundle(const daft_build_branch *branch, const range *r, daft_build_fork *fork)
{
    const prim *prims = branch->prims[r->side] + r->first;
    fork->first = prims[0].id, fork->bundle = r->count > 1;
    for (uint32_t i = 0; i < r->count && r->count > 1; i++) {
        daft_build_fork *leaf = &branch->sink->forks[branch->sink->count++];
        memcpy(leaf->low, prims[i].low, 2 * sizeof(v4));
        leaf->right = 0, leaf->first = prims[i].id, leaf->count = 1, leaf->bundle = 0;
    }
}

static void leave(const daft_build_branch *branch, const range *r)
{
    const prim *prims = branch->prims[r->side];
    for (uint32_t i = r->first; i < r->first + r->count; i++) branch->numbers[i] = prims[i].id;
}

static bool grow(daft_build_branch *branch, const range *r)
{
    daft_build_sink *sink = branch->sink;
    daft_build_fork *fork = &sink->forks[sink->count++];
    memcpy(fork->low, &r->box, 2 * sizeof(v4));
    fork->right = 0, fork->first = r->first, fork->count = daft_build_few(r->weight), fork->bundle = 0;
    bool task = r->count < TASK_CELLS || r->weight <= TASK_WEIGHT || r->depth >= MEDIAN_DEPTH;
    if (branch->defer && task) return defer(branch, r, fork);
    range left, right;
    if (branch->rule->block_size == 1 && !branch->defer && r->count <= DAFT_WIDTH) {
        bundle(branch, r, fork);
    } else if (!split_range(branch, r, &left, &right)) {
        leave(branch, r);
    } else {
        if (!grow(branch, &left)) return false;
        fork->right = (uint32_t)(&sink->forks[sink->count] - fork);
        return grow(branch, &right);
    }
    return true;
}

/* ---- cells ---- */

DAFT_INLINE uint32_t cell_of(const daft_build_grid *grid, const prim *p)
{
    v4i at = v4i_convert_to((prim_middle(p) - grid->low) * grid->scale);
    return (uint32_t)at[0] + grid->side * ((uint32_t)at[1] + grid->side * (uint32_t)at[2]);
}

static void count_cells(const daft_build_grid *grid, const prim *prims, uint32_t count, uint32_t *counts)
{
    for (uint32_t i = 0; i < count; i++) counts[cell_of(grid, &prims[i])]++;
}

static void scatter(const daft_build_grid *grid, const prim *prims, uint32_t count, uint32_t *next, prim *out)
{
    for (uint32_t i = 0; i < count; i++) out[next[cell_of(grid, &prims[i])]++] = prims[i];
}

const daft_build_kernels DAFT_KERNEL(daft_build) = {measure, grow, count_cells, scatter};
