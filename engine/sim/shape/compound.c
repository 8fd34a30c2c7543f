/* Compounds: children with poses, and a tree of their bounds, split at the middle of the longest side. */
#include "sim/shape/shape.h"

#include <string.h>

enum { MAX_CHILDREN = 65535 };

static daft_aabb float_bounds(const daft_daabb *b)
{
    /* Rounded outwards: a float is off by less than 2^-23 of itself. */
    daft_aabb out = {daft_to_float(b->low), daft_to_float(b->high)};
    for (int k = 0; k < 3; k++) {
        float low = daft_v3_at(out.low, k), high = daft_v3_at(out.high, k);
        daft_v3_put(&out.low, k, low - fabsf(low) * 0x1p-22f);
        daft_v3_put(&out.high, k, high + fabsf(high) * 0x1p-22f);
    }
    return out;
}

typedef struct tree_builder {
    const daft_aabb *bounds; /* of children */
    uint32_t *order;
    daft_compound_node *nodes;
    uint32_t used;
} tree_builder;

static float middle(const daft_aabb *b, int axis) { return daft_v3_at(b->low, axis) + daft_v3_at(b->high, axis); }

/* Insertion into order by the middle along an axis, then by number: quick enough for what a person puts together, and a
 * heap of shells where a program does (Shell 1959, gaps of Ciura 2001). */
static void sort_range(const tree_builder *t, uint32_t first, uint32_t count, int axis)
{
    static const uint32_t gaps[] = {30000, 12000, 4000, 1750, 701, 301, 132, 57, 23, 10, 4, 1};
    uint32_t *order = t->order + first;
    for (size_t g = 0; g < DAFT_COUNT_OF(gaps); g++)
        for (uint32_t i = gaps[g]; i < count; i++) {
            uint32_t moved = order[i], k = i;
            float at = middle(&t->bounds[moved], axis);
            for (; k >= gaps[g]; k -= gaps[g]) {
                uint32_t other = order[k - gaps[g]];
                float there = middle(&t->bounds[other], axis);
                if (there < at || (there <= at && other < moved)) break;
                order[k] = other;
            }
            order[k] = moved;
        }
}

static void build(tree_builder *t, uint32_t first, uint32_t count)
{
    daft_compound_node *node = &t->nodes[t->used++];
    *node = (daft_compound_node){.bounds = t->bounds[t->order[first]], .child = t->order[first]};
    for (uint32_t i = 1; i < count; i++) {
        node->bounds.low = daft_min3(node->bounds.low, t->bounds[t->order[first + i]].low);
        node->bounds.high = daft_max3(node->bounds.high, t->bounds[t->order[first + i]].high);
    }
    if (count > 1) {
        daft_vec3 size = daft_sub(node->bounds.high, node->bounds.low);
        int axis = size.y > size.x ? 1 : 0;
        if (size.z > daft_v3_at(size, axis)) axis = 2;
        sort_range(t, first, count, axis);
        build(t, first, count / 2);
        node->second = t->used;
        build(t, first + count / 2, count - count / 2);
    }
    node->skip = t->used;
}

static bool check_children(const daft_child *children, uint32_t count, daft_error *error)
{
    if (count == 0 || count > MAX_CHILDREN)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a compound of %u children; it takes 1 to %d", count,
                         MAX_CHILDREN);
    for (uint32_t i = 0; i < count; i++) {
        const daft_child *c = &children[i];
        if (c->shape.type == DAFT_GEOMETRY_NONE || c->shape.type >= DAFT_GEOMETRY_COMPOUND)
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "child %u of a compound is %s", i,
                             c->shape.type == DAFT_GEOMETRY_NONE ? "no shape" : "a compound itself");
        bool finite = daft_dfinite3(c->pose.p);
        for (int k = 0; k < 9; k++) finite = finite && fabs(c->pose.m[k]) <= 1.001;
        if (!finite || daft_ddot(c->pose.p, c->pose.p) > (double)DAFT_SHAPE_MAX_SIZE * (double)DAFT_SHAPE_MAX_SIZE)
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "the pose of child %u of a compound is out of range", i);
    }
    return true;
}

daft_compound *daft_compound_create(const daft_allocator *allocator, const daft_child *children, uint32_t count,
                                    daft_error *error)
{
    if (!check_children(children, count, error)) return NULL;
    daft_compound *c = daft_alloc_zero(allocator, 1, sizeof *c);
    daft_aabb *bounds = daft_alloc(allocator, count, sizeof *bounds);
    uint32_t *order = daft_alloc(allocator, count, sizeof *order);
    if (c) {
        c->allocator = *allocator;
        c->count = count;
        c->children = daft_alloc(allocator, count, sizeof *c->children);
        c->nodes = daft_alloc(allocator, 2 * (size_t)count - 1, sizeof *c->nodes);
    }
    bool done = c && bounds && order && c->children && c->nodes;
    if (done) {
        memcpy(c->children, children, count * sizeof *children);
        for (uint32_t i = 0; i < count; i++) {
            daft_daabb b = daft_shape_bounds(&children[i].shape, &children[i].pose);
            bounds[i] = float_bounds(&b);
            order[i] = i;
        }
        tree_builder t = {bounds, order, c->nodes, 0};
        build(&t, 0, count);
    } else {
        daft_fail_memory(error, "a compound shape");
        daft_compound_free(c);
        c = NULL;
    }
    daft_release(allocator, order);
    daft_release(allocator, bounds);
    return c;
}

void daft_compound_free(daft_compound *compound)
{
    if (!compound) return;
    daft_allocator allocator = compound->allocator;
    daft_release(&allocator, compound->children);
    daft_release(&allocator, compound->nodes);
    daft_release(&allocator, compound);
}
