/* The builder: top-down binned SAH (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007), straight
 * into eight-wide nodes: a range is split in two until it has eight parts, always the part with the largest area next
 * (Wald, Benthin, Boulos, "Getting Rid of Packets", 2008). Below MEDIAN_DEPTH, and where all centroids are equal, ranges
 * are halved by count, so the depth is bounded for any input and the time is O(n log n). */
#include "accel/bvh.h"
#include "math/simd.h"

#include <float.h>
#include <string.h>

enum { MAX_BINS = 16, FEW_BINS = 8, FEW_PRIMS = 48, MEDIAN_DEPTH = 40 };

/* Lows and highs in lanes 0 to 2; lane 3 holds a prim's number and padding, and means nothing. */
typedef struct box {
    v4 low, high;
} box;

typedef struct range {
    uint32_t first, count;
    box box;
    box centroids; /* bounds of the middles */
    bool leaf;
} range;

typedef struct bin {
    box box;
    uint32_t count;
} bin;

static box box_empty(void) { return (box){v4_set(FLT_MAX), v4_set(-FLT_MAX)}; }

DAFT_INLINE void box_add(box *b, box other)
{
    b->low = v4_min(other.low, b->low);
    b->high = v4_max(other.high, b->high);
}

/* Half the surface, in double: coordinates of 1e20 must not overflow. */
static double box_area(const box *b)
{
    double x = (double)b->high[0] - (double)b->low[0], y = (double)b->high[1] - (double)b->low[1];
    double z = (double)b->high[2] - (double)b->low[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
}

DAFT_INLINE box prim_box(const daft_build_prim *prim) { return (box){v4_load(prim->low), v4_load(prim->high)}; }
DAFT_INLINE v4 middle(box b) { return b.low * v4_set(0.5f) + b.high * v4_set(0.5f); }

static void range_measure(const daft_build_prim *prims, range *r)
{
    r->box = r->centroids = box_empty();
    for (uint32_t i = r->first; i < r->first + r->count; i++) {
        box b = prim_box(&prims[i]);
        v4 c = middle(b);
        box_add(&r->box, b);
        box_add(&r->centroids, (box){c, c});
    }
}

/* From middles to bins: the one formula that counting and partitioning share. */
typedef struct binning {
    v4 low, scale;
    int count;
} binning;

static binning binning_of(const range *r)
{
    binning b = {.low = r->centroids.low, .count = r->count < FEW_PRIMS ? FEW_BINS : MAX_BINS};
    for (int k = 0; k < 3; k++) {
        float extent = r->centroids.high[k] - r->centroids.low[k];
        float scale = extent > 0 && extent <= FLT_MAX ? (float)b.count * 0.999f / extent : 0;
        b.scale[k] = scale <= FLT_MAX ? scale : 0; /* among denormals it overflows */
    }
    b.scale[3] = 0;
    return b;
}

DAFT_INLINE v4i bins_of(const binning *b, box prim)
{
    v4 place = (middle(prim) - b->low) * b->scale;
    place = v4_min(v4_max(place, v4_set(0)), v4_set((float)(b->count - 1)));
    return __builtin_convertvector(place, v4i);
}

typedef struct split {
    double cost;
    int axis;
    int at; /* bins below it go left */
} split;

static double block_count(const daft_builder *builder, uint32_t count)
{
    return (double)((count + builder->block_size - 1) / builder->block_size);
}

static void sweep(const daft_builder *builder, const bin *bins, int bin_count, int axis, split *best)
{
    double right_cost[MAX_BINS];
    box sum = box_empty();
    uint32_t count = 0;
    for (int i = bin_count - 1; i > 0; i--) {
        count += bins[i].count;
        box_add(&sum, bins[i].box);
        right_cost[i] = count ? box_area(&sum) * block_count(builder, count) : -1;
    }
    sum = box_empty();
    count = 0;
    for (int i = 1; i < bin_count; i++) {
        count += bins[i - 1].count;
        box_add(&sum, bins[i - 1].box);
        if (count == 0 || right_cost[i] < 0) continue;
        double cost = box_area(&sum) * block_count(builder, count) + right_cost[i];
        if (cost < best->cost) *best = (split){cost, axis, i};
    }
}

static split find_split(const daft_builder *builder, const range *r, const binning *how)
{
    bin bins[3][MAX_BINS];
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < how->count; i++) bins[k][i] = (bin){box_empty(), 0};
    for (uint32_t i = r->first; i < r->first + r->count; i++) {
        box prim = prim_box(&builder->prims[i]);
        v4i at = bins_of(how, prim);
        for (int k = 0; k < 3; k++) {
            bin *target = &bins[k][at[k]];
            target->count++;
            box_add(&target->box, prim);
        }
    }
    split best = {DBL_MAX, -1, 0};
    for (int k = 0; k < 3; k++)
        if (how->scale[k] > 0) sweep(builder, bins[k], how->count, k, &best);
    return best;
}

/* Moves the prims of the left side to the front; gives their number. */
static uint32_t partition(const daft_builder *builder, const range *r, const binning *how, split s)
{
    daft_build_prim *prims = builder->prims;
    uint32_t i = r->first, j = r->first + r->count;
    while (i < j) {
        if (bins_of(how, prim_box(&prims[i]))[s.axis] < s.at) {
            i++;
        } else {
            daft_build_prim moved = prims[--j];
            prims[j] = prims[i];
            prims[i] = moved;
        }
    }
    return i - r->first;
}

/* False: the range is to stay a leaf. */
static bool split_range(const daft_builder *builder, range *r, int depth, range *right)
{
    if (r->leaf || r->count <= 1) return false;
    uint32_t left = 0;
    if (depth < MEDIAN_DEPTH) {
        binning how = binning_of(r);
        split s = find_split(builder, r, &how);
        double leaf_cost = box_area(&r->box) * block_count(builder, r->count);
        bool may_stay = r->count <= builder->leaf_size;
        if (may_stay && (s.axis < 0 || s.cost + box_area(&r->box) >= leaf_cost)) return false;
        if (s.axis >= 0) left = partition(builder, r, &how, s);
    }
    if (left == 0 || left == r->count) {
        if (r->count <= builder->block_size && r->count <= builder->leaf_size) return false;
        left = r->count / 2;
    }
    *right = (range){.first = r->first + left, .count = r->count - left};
    r->count = left;
    range_measure(builder->prims, r);
    range_measure(builder->prims, right);
    return true;
}

static int largest_open(const range *parts, int count)
{
    int best = -1;
    double area = -1;
    for (int i = 0; i < count; i++) {
        if (parts[i].leaf) continue;
        double a = box_area(&parts[i].box);
        if (a > area) area = a, best = i;
    }
    return best;
}

static int split_eight(const daft_builder *builder, const range *whole, int depth, range parts[DAFT_WIDTH])
{
    int count = 1;
    parts[0] = *whole;
    while (count < DAFT_WIDTH) {
        int i = largest_open(parts, count);
        if (i < 0) break;
        if (split_range(builder, &parts[i], depth, &parts[count]))
            count++;
        else
            parts[i].leaf = true;
    }
    return count;
}

static uint32_t node_add(const daft_builder *builder)
{
    daft_node_list *nodes = builder->nodes;
    if (!daft_grow(builder->allocator, &nodes->items, &nodes->capacity, nodes->count + 1, nodes->count, sizeof(daft_node)))
        return DAFT_CHILD_NONE;
    daft_node *node = &nodes->items[nodes->count];
    for (int i = 0; i < DAFT_WIDTH; i++) {
        node->child[i] = DAFT_CHILD_NONE;
        for (int k = 0; k < 3; k++) node->bounds[k][i] = INFINITY, node->bounds[k + 3][i] = -INFINITY;
    }
    return (uint32_t)nodes->count++;
}

static uint32_t build_node(daft_builder *builder, const range *whole, int depth);

static uint32_t build_child(daft_builder *builder, const range *part, int depth)
{
    if (part->leaf || part->count <= 1) return builder->leaf(builder->context, builder->prims + part->first, part->count);
    return build_node(builder, part, depth);
}

static uint32_t build_node(daft_builder *builder, const range *whole, int depth)
{
    range parts[DAFT_WIDTH];
    uint32_t self = node_add(builder);
    if (self == DAFT_CHILD_NONE) return self;
    const float bounds[6] = {whole->box.low[0],  whole->box.low[1],  whole->box.low[2],
                             whole->box.high[0], whole->box.high[1], whole->box.high[2]};
    if (builder->enter && !builder->enter(builder->context, whole->count, bounds)) return DAFT_CHILD_NONE;
    int count = split_eight(builder, whole, depth, parts);
    for (int i = 0; i < count; i++) {
        bool small = parts[i].count <= builder->block_size && parts[i].count <= builder->leaf_size;
        parts[i].leaf = parts[i].leaf || small;
        uint32_t child = build_child(builder, &parts[i], depth + 3);
        if (child == DAFT_CHILD_NONE) return child;
        daft_node *node = &builder->nodes->items[self]; /* the array may have moved */
        node->child[i] = child;
        for (int k = 0; k < 3; k++) node->bounds[k][i] = parts[i].box.low[k], node->bounds[k + 3][i] = parts[i].box.high[k];
    }
    if (builder->leave) builder->leave(builder->context, whole->count);
    return self;
}

bool daft_build_tree(daft_builder *builder, uint32_t count)
{
    if (count == 0) return true;
    range whole = {.first = 0, .count = count};
    range_measure(builder->prims, &whole);
    return build_node(builder, &whole, 0) != DAFT_CHILD_NONE;
}
