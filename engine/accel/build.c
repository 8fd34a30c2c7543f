/* The builder: top-down binned SAH (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007), straight
 * into eight-wide nodes: a range is split in two until it has eight parts, always the part with the largest area next
 * (Wald, Benthin, Boulos, "Getting Rid of Packets", 2008). Below MEDIAN_DEPTH, and where all centroids are equal, ranges
 * are halved by count, so the depth is bounded for any input and the time is O(n log n). */
#include "accel/bvh.h"

#include <float.h>
#include <string.h>

enum { BINS = 16, MEDIAN_DEPTH = 40 };

typedef struct range {
    uint32_t first, count;
    float box[6];       /* low x y z, high x y z */
    float centroids[6]; /* bounds of low + high */
    bool leaf;
} range;

typedef struct bin {
    float box[6];
    uint32_t count;
} bin;

static void box_clear(float box[6])
{
    for (int k = 0; k < 3; k++) box[k] = FLT_MAX, box[k + 3] = -FLT_MAX;
}

static void box_add(float box[6], const float low[3], const float high[3])
{
    for (int k = 0; k < 3; k++) {
        if (low[k] < box[k]) box[k] = low[k];
        if (high[k] > box[k + 3]) box[k + 3] = high[k];
    }
}

/* Half the surface, in double: coordinates of 1e20 must not overflow. */
static double box_area(const float box[6])
{
    double x = (double)box[3] - (double)box[0], y = (double)box[4] - (double)box[1], z = (double)box[5] - (double)box[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
}

static void centroid(const daft_build_prim *prim, float out[3])
{
    for (int k = 0; k < 3; k++) out[k] = prim->low[k] * 0.5f + prim->high[k] * 0.5f;
}

static void range_measure(const daft_build_prim *prims, range *r)
{
    box_clear(r->box);
    box_clear(r->centroids);
    for (uint32_t i = r->first; i < r->first + r->count; i++) {
        float c[3];
        centroid(&prims[i], c);
        box_add(r->box, prims[i].low, prims[i].high);
        box_add(r->centroids, c, c);
    }
}

/* The bin of a centroid: the one formula that counting and partitioning share. */
static uint32_t bin_of(float c, float low, float scale)
{
    float place = (c - low) * scale;
    return place < 0 ? 0 : place >= BINS ? BINS - 1 : (uint32_t)place;
}

static float bin_scale(const range *r, int axis)
{
    float extent = r->centroids[axis + 3] - r->centroids[axis];
    if (!(extent > 0 && extent <= FLT_MAX)) return 0;
    float scale = (float)BINS * 0.999f / extent;
    return scale <= FLT_MAX ? scale : 0; /* among denormals it overflows */
}

typedef struct split {
    double cost;
    int axis;
    uint32_t at; /* bins below it go left */
} split;

static double block_count(const daft_builder *builder, uint32_t count)
{
    return (double)((count + builder->block_size - 1) / builder->block_size);
}

static void sweep(const daft_builder *builder, const bin bins[BINS], int axis, split *best)
{
    double right_cost[BINS];
    float box[6];
    uint32_t count = 0;
    box_clear(box);
    for (int i = BINS - 1; i > 0; i--) {
        count += bins[i].count;
        if (bins[i].count) box_add(box, bins[i].box, bins[i].box + 3);
        right_cost[i] = count ? box_area(box) * block_count(builder, count) : -1;
    }
    box_clear(box);
    count = 0;
    for (uint32_t i = 1; i < BINS; i++) {
        count += bins[i - 1].count;
        if (bins[i - 1].count) box_add(box, bins[i - 1].box, bins[i - 1].box + 3);
        if (count == 0 || right_cost[i] < 0) continue;
        double cost = box_area(box) * block_count(builder, count) + right_cost[i];
        if (cost < best->cost) *best = (split){cost, axis, i};
    }
}

static split find_split(const daft_builder *builder, const range *r)
{
    bin bins[3][BINS];
    float scale[3];
    memset(bins, 0, sizeof bins);
    for (int k = 0; k < 3; k++) {
        scale[k] = bin_scale(r, k);
        for (int i = 0; i < BINS; i++) box_clear(bins[k][i].box);
    }
    for (uint32_t i = r->first; i < r->first + r->count; i++) {
        const daft_build_prim *prim = &builder->prims[i];
        float c[3];
        centroid(prim, c);
        for (int k = 0; k < 3; k++) {
            bin *target = &bins[k][bin_of(c[k], r->centroids[k], scale[k])];
            target->count++;
            box_add(target->box, prim->low, prim->high);
        }
    }
    split best = {DBL_MAX, -1, 0};
    for (int k = 0; k < 3; k++)
        if (scale[k] > 0) sweep(builder, bins[k], k, &best);
    return best;
}

/* Moves the prims of the left side to the front and measures both sides on the way. */
static uint32_t partition(const daft_builder *builder, const range *r, split s)
{
    daft_build_prim *prims = builder->prims;
    float scale = bin_scale(r, s.axis), low = r->centroids[s.axis];
    uint32_t i = r->first, j = r->first + r->count;
    while (i < j) {
        float c[3];
        centroid(&prims[i], c);
        if (bin_of(c[s.axis], low, scale) < s.at) {
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
        split s = find_split(builder, r);
        double leaf_cost = box_area(r->box) * block_count(builder, r->count);
        bool may_stay = r->count <= builder->leaf_size;
        if (may_stay && (s.axis < 0 || s.cost + box_area(r->box) >= leaf_cost)) return false;
        if (s.axis >= 0) left = partition(builder, r, s);
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
        double a = box_area(parts[i].box);
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
    if (builder->enter && !builder->enter(builder->context, whole->count, whole->box)) return DAFT_CHILD_NONE;
    int count = split_eight(builder, whole, depth, parts);
    for (int i = 0; i < count; i++) {
        bool small = parts[i].count <= builder->block_size && parts[i].count <= builder->leaf_size;
        parts[i].leaf = parts[i].leaf || small;
        uint32_t child = build_child(builder, &parts[i], depth + 3);
        if (child == DAFT_CHILD_NONE) return child;
        daft_node *node = &builder->nodes->items[self]; /* the array may have moved */
        node->child[i] = child;
        for (int k = 0; k < 6; k++) node->bounds[k][i] = parts[i].box[k];
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
