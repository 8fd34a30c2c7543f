/* How a single ray traverses a mesh's tree; single_kernel.c traverses the upper level. ray_test.h has the arithmetic of
 * boxes and triangles, this header the order of visits.
 *
 * At most nodes a ray meets one child or two. The nearest continues in a register; the others are sorted into the
 * stack, distance and number in one word (Wald et al., "Embree: A Kernel Framework for Efficient CPU Ray Tracing",
 * 2014). The bottom of the stack is a sentinel, child NONE, so that no count is kept. The blocks of a leaf go through
 * the filter together, as many as there are lanes for: the filter is most of a leaf's cost, and a leaf costs about as
 * much as two nodes. */
#ifndef DAFT_MESH_TRAVERSAL_H
#define DAFT_MESH_TRAVERSAL_H

#include "accel/ray_test.h"
#include "accel/traverse/traverse.h"

#define DAFT_WIDEN         (1 + 8 * DAFT_ULP)
#define DAFT_INFINITY_BITS 0x7f800000
enum { ROW = sizeof(((daft_node *)0)->bounds[0]) };

/* A direction for the slab test: its negated inverse, and the same widened; and the offsets in bytes, from a node's
 * bounds, of the planes by which it enters and leaves. */
typedef struct slab_direction {
    v8 ix, iy, iz, wx, wy, wz;
    const size_t *rows;
    bool plain; /* no inverse overflows */
} slab_direction;

/* An origin, in each lane. */
typedef struct slab_origin {
    v8 x, y, z;
} slab_origin;

/* Children to visit, the nearest on top: the bits of the entry distance, then the child's code. The bottom is a
 * sentinel: child NONE at distance -infinity. */
typedef struct ray_stack {
    uint64_t items[1 + DAFT_STACK + DAFT_WIDTH];
} ray_stack;

/* Children to visit in any order; the bottom is NONE. Up to eight are pushed at a time. */
typedef struct code_stack {
    uint32_t items[1 + DAFT_STACK + 2 * DAFT_WIDTH];
} code_stack;

/* Entry distances as bits, which compare as the distances do; negative ones compare otherwise, which costs time alone.
 * The last is infinity, for two_lowest where there is one box only. */
typedef struct slab_near {
    int32_t at[DAFT_WIDTH + 1];
} __attribute__((aligned(32))) slab_near;

static const uint64_t STACK_END = (uint64_t)0xff800000u << 32 | DAFT_CHILD_NONE;

/* Minus one over a direction whose lane 3 is 0. */
DAFT_INLINE v4 minus_inverse(v4 d) { return v4_set(-1) / (v4)((v4i)d | (v4i)(v4){0, 0, 0, 1}); }

DAFT_INLINE slab_origin slab_origin_of(v4 o) { return (slab_origin){v8_set(o[0]), v8_set(o[1]), v8_set(o[2])}; }

/* No branches: the directions' signs cannot be predicted. */
DAFT_INLINE slab_direction slab_direction_of(v4 d, v4 inverse)
{
#define SIDES(x, y, z)                                                                                                 \
    {                                                                                                                  \
        (x) * ROW, (y)*ROW, (z)*ROW, (3 - (x)) * ROW, (5 - (y)) * ROW, (7 - (z)) * ROW                                 \
    }
    /* by the signs of x, y and z */
    static const size_t ROWS[8][6] = {SIDES(0, 1, 2), SIDES(3, 1, 2), SIDES(0, 4, 2), SIDES(3, 4, 2),
                                      SIDES(0, 1, 5), SIDES(3, 1, 5), SIDES(0, 4, 5), SIDES(3, 4, 5)};
#undef SIDES
    v4 i = inverse, w = i * v4_set(DAFT_WIDEN);
    return (slab_direction){v8_set(i[0]),
                            v8_set(i[1]),
                            v8_set(i[2]),
                            v8_set(w[0]),
                            v8_set(w[1]),
                            v8_set(w[2]),
                            ROWS[v4_bits_from_mask((v4i)d) & 7],
                            v4_bits_from_mask(w - w == v4_set(0)) == 15};
}

/* The origin as near and as far planes see it on the upper level, where boxes are grown on each side: an instance's own
 * ray, moved into its space and seen from outside again, is off by 5u of the magnitudes of the origin and of the
 * instance's place, |R|·|R^-1| being at most 1 by entry for a rotation and a scale; and by 8u of the way, which is no
 * longer than both. The instance's bounds are wide enough for its place; this is for the rest. */
DAFT_INLINE void slab_upper_origins(v4 o, v4 d, slab_origin *near, slab_origin *far)
{
    float pad = (fabsf(o[0]) + fabsf(o[1]) + fabsf(o[2])) * 0x1p-20f;
    v4 outwards = (v4)((v4i)v4_set(pad) | ((v4i)d & (v4i)v4_set(-0.0f)));
    *near = slab_origin_of(o + outwards), *far = slab_origin_of(o - outwards);
}

DAFT_INLINE v8 planes(const char *node, size_t row) { return v8_load((const float *)(node + row)); }

/* Bits of the children the ray meets in tmin..tmax; their entry distances in near. `plain`: the direction is, and tmin
 * not negative. */
DAFT_INLINE uint32_t slab_test(const char *node, const slab_direction *r, const slab_origin *from,
                               const slab_origin *until, bool plain, v8 tmin, v8 tmax, v8 *near)
{
    v8 x0 = (from->x - planes(node, r->rows[0])) * r->ix, x1 = (until->x - planes(node, r->rows[3])) * r->wx;
    v8 y0 = (from->y - planes(node, r->rows[1])) * r->iy, y1 = (until->y - planes(node, r->rows[4])) * r->wy;
    v8 z0 = (from->z - planes(node, r->rows[2])) * r->iz, z1 = (until->z - planes(node, r->rows[5])) * r->wz;
    if (plain) {
        *near = v8_max(v8_max(x0, y0), v8_max(z0, tmin));
        return v8_le_bits(*near, v8_min(v8_min(x1, y1), v8_min(z1, tmax)));
    }
    /* v8_max and v8_min give their second argument when the first is NaN */
    *near = v8_max(x0, v8_max(y0, v8_max(z0, tmin)));
    v8 far = v8_min(x1, v8_min(y1, v8_min(z1, tmax)));
    far = v8_max(far, far * v8_set(1 - 24 * DAFT_ULP)); /* where it is negative, widening goes the other way */
    return v8_le_bits(*near, far);
}

/* Where the children of a tree's nodes stand: leaf number i, shifted so far, begins so many bytes from `leaves`. */
typedef struct tree_place {
    const daft_node *nodes;
    const void *leaves;
    size_t leaf_size;
    int leaf_shift;
} tree_place;

/* Prefetches a child that is pushed. */
DAFT_INLINE void fetch(const tree_place *tree, uint32_t child)
{
    const char *leaf =
        (const char *)tree->leaves + (size_t)((child & ~DAFT_CHILD_LEAF) >> tree->leaf_shift) * tree->leaf_size;
    const char *at = child & DAFT_CHILD_LEAF ? leaf : (const char *)tree->nodes + child * sizeof *tree->nodes;
    for (size_t i = 0; i < sizeof *tree->nodes; i += 64) __builtin_prefetch(at + i);
}

/* Child i of a node, by a jump, not a look-up. The processor predicts jumps, so it starts on the child before its box
 * is tested: rays that begin near the last one's origin descend to the same leaf. */
DAFT_INLINE uint32_t child_at(const daft_node *node, uint32_t i)
{
    uint32_t child;
    switch (i) {
        /* clang-format off */
#define CHILD(k) case k: child = node->child[k]; __asm__("" : "+r"(child)); return child; /* or it becomes a look-up again */
        CHILD(0) CHILD(1) CHILD(2) CHILD(3) CHILD(4) CHILD(5) CHILD(6) CHILD(7)
#undef CHILD
            /* clang-format on */
            default : __builtin_unreachable();
    }
}

/* Of the children in bits, 1 or more: the nearest is the answer, the others are pushed, nearest last. */
DAFT_INLINE uint32_t push_sorted(const tree_place *tree, const daft_node *node, uint32_t bits, v8 near, uint64_t **top)
{
    uint32_t i = (uint32_t)__builtin_ctz(bits), at[DAFT_WIDTH] __attribute__((aligned(32)));
    bits &= bits - 1;
    if (!bits) return node->child[i];
    v8_store((float *)at, near); /* in one piece: a copy would wait for its halves */
    uint64_t nearest = (uint64_t)at[i] << 32 | node->child[i], *base = *top, *end = base;
    do {
        i = (uint32_t)__builtin_ctz(bits);
        bits &= bits - 1;
        uint64_t child = (uint64_t)at[i] << 32 | node->child[i], further = child < nearest ? nearest : child,
                 *place = end++;
        nearest = child < nearest ? child : nearest;
        for (; place > base && place[-1] < further; place--) place[0] = place[-1];
        *place = further;
        fetch(tree, (uint32_t)further);
    } while (bits);
    *top = end;
    return (uint32_t)nearest;
}

/* The lowest of the bits of children, 1 or more, and the next one, or DAFT_WIDTH where there is no other. */
typedef struct two_bits {
    uint32_t first, second, left; /* left: bits without the lowest */
} two_bits;

DAFT_INLINE two_bits two_lowest(uint32_t bits)
{
    uint32_t left = bits & (bits - 1);
    return (two_bits){(uint32_t)__builtin_ctz(bits), (uint32_t)__builtin_ctz(left | 1u << DAFT_WIDTH), left};
}

/* push_sorted on the way down to the first leaf. Without a branch on whether there are one or two children and which is
 * nearer: it would be mispredicted for every second ray. */
DAFT_INLINE uint32_t push_predicted(const tree_place *tree, const daft_node *node, uint32_t bits, v8 near,
                                    slab_near *begins, uint64_t **top)
{
    two_bits two = two_lowest(bits);
    const int32_t *at = begins->at;
    v8_store((float *)begins->at, near);
    uint32_t best = at[two.second] < at[two.first] ? two.second : two.first, other = best ^ two.first ^ two.second;
    uint64_t *base = *top, *end = base + (two.left != 0);
    base[0] = (uint64_t)(uint32_t)at[other] << 32 | node->child[other % DAFT_WIDTH];
    for (uint32_t left = two.left & (two.left - 1); __builtin_expect(left != 0, 0); left &= left - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(left), further = at[i] < at[best] ? best : i;
        best = best ^ i ^ further;
        uint64_t item = (uint64_t)(uint32_t)at[further] << 32 | node->child[further], *place = end++;
        for (; place > base && place[-1] < item; place--) place[0] = place[-1];
        *place = item;
        fetch(tree, (uint32_t)item);
    }
    *top = end;
    return child_at(node, best);
}

/* Of the children in bits, 1 or more, in any order: one is the answer, the others are pushed. */
DAFT_INLINE uint32_t push_unsorted(const daft_node *node, uint32_t bits, bool guess, uint32_t **top)
{
    two_bits two = two_lowest(bits);
    (*top)[0] = node->child[two.second % DAFT_WIDTH];
    *top += two.left != 0;
    for (uint32_t left = two.left & (two.left - 1); __builtin_expect(left != 0, 0); left &= left - 1)
        *(*top)++ = node->child[__builtin_ctz(left)];
    return guess ? child_at(node, two.first) : node->child[two.first];
}

/* The next child that begins before `limit`. */
DAFT_INLINE uint32_t pop(uint64_t **top, float limit)
{
    union {
        uint32_t bits;
        float t;
    } near;
    uint64_t item;
    do item = *--*top, near.bits = (uint32_t)(item >> 32);
    while (near.t > limit);
    return (uint32_t)item;
}

/* daft_past and daft_before; `plain`: of no negative number. */
DAFT_INLINE float limit_of(float t, bool plain) { return plain ? t * (1 + 0x1p-17f) : daft_past(t); }
DAFT_INLINE float begin_of(float t, bool plain) { return plain ? t * (1 - 0x1p-17f) : daft_before(t); }

DAFT_INLINE const char *node_at(const daft_node *nodes, uint32_t code)
{
    return (const char *)nodes + code * sizeof *nodes;
}

/* A leaf; `child` is its code. Where the lanes take it whole there are registers for it, too; else it is called, so
 * that nodes keep theirs. */
DAFT_INLINE bool leaf_closest(const daft_block *blocks, uint32_t child, const daft_mesh_ray *r, float past,
                              daft_nearest *hit)
{
    const daft_block *b = &blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    if ((int)DAFT_FOURS < (int)DAFT_MAX_LEAF_BLOCKS) return DAFT_KERNEL(daft_leaf_closest)(blocks, child, r, past, hit);
    return daft_blocks_intersect(b, (int)(child & 3) + 1, r, past, hit, false);
}

DAFT_INLINE bool leaf_stops(const daft_block *blocks, uint32_t child, const daft_mesh_ray *r, float past,
                            daft_nearest *hit)
{
    const daft_block *b = &blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    if ((int)DAFT_FOURS < (int)DAFT_MAX_LEAF_BLOCKS) return DAFT_KERNEL(daft_leaf_stops)(blocks, child, r, past, hit);
    return daft_blocks_intersect(b, (int)(child & 3) + 1, r, past, hit, true);
}

/* The nearest hit below `child`, a code of the tree. Down to the first leaf children are predicted (child_at); later
 * ones would be mispredicted too often. hit->t limits the search and hit->triangle breaks ties, so the order of visits
 * does not matter. */
DAFT_INLINE void mesh_traverse(const daft_bvh *bvh, uint32_t child, const slab_direction *slabs, const daft_mesh_ray *r,
                               const slab_origin *at, bool plain, daft_nearest *hit)
{
    ray_stack stack;
    uint64_t *top = stack.items;
    *top++ = STACK_END;
    const daft_node *nodes = bvh->nodes.items;
    const tree_place tree = {nodes, bvh->blocks, sizeof *bvh->blocks, 2};
    float limit = limit_of(hit->t, plain);
    v8 low = v8_set(begin_of(r->tmin, plain)), high = v8_set(limit), near;
    slab_near begins;
    begins.at[DAFT_WIDTH] = DAFT_INFINITY_BITS;
    for (bool guess = true; guess && !(child & DAFT_CHILD_LEAF);) {
        const char *node = node_at(nodes, child);
        uint32_t bits = slab_test(node, slabs, at, at, plain, low, high, &near);
        guess = bits != 0;
        child = bits ? push_predicted(&tree, (const daft_node *)node, bits, near, &begins, &top) : pop(&top, limit);
    }
    for (;;) {
        while (!(child & DAFT_CHILD_LEAF)) {
            const char *node = node_at(nodes, child);
            uint32_t bits = slab_test(node, slabs, at, at, plain, low, high, &near);
            child = bits ? push_sorted(&tree, (const daft_node *)node, bits, near, &top) : pop(&top, limit);
        }
        if (child == DAFT_CHILD_NONE) return;
        if (leaf_closest(bvh->blocks, child, r, plain ? limit : daft_forward(limit), hit))
            limit = limit_of(hit->t, plain), high = v8_set(limit);
        child = pop(&top, limit);
    }
}

/* Whether anything below `child` is hit before hit->t. */
DAFT_INLINE bool mesh_any_hit(const daft_bvh *bvh, uint32_t child, const slab_direction *slabs, const daft_mesh_ray *r,
                              const slab_origin *at, bool plain, daft_nearest *hit)
{
    code_stack stack;
    uint32_t *top = stack.items;
    *top++ = DAFT_CHILD_NONE;
    const daft_node *nodes = bvh->nodes.items;
    float limit = limit_of(hit->t, plain);
    v8 low = v8_set(begin_of(r->tmin, plain)), high = v8_set(limit), near;
    for (bool guess = true; guess && !(child & DAFT_CHILD_LEAF);) {
        const char *node = node_at(nodes, child);
        uint32_t bits = slab_test(node, slabs, at, at, plain, low, high, &near);
        guess = bits != 0;
        child = bits ? push_unsorted((const daft_node *)node, bits, true, &top) : *--top;
    }
    for (;;) {
        while (!(child & DAFT_CHILD_LEAF)) {
            const char *node = node_at(nodes, child);
            uint32_t bits = slab_test(node, slabs, at, at, plain, low, high, &near);
            child = bits ? push_unsorted((const daft_node *)node, bits, false, &top) : *--top;
        }
        if (child == DAFT_CHILD_NONE) return false;
        if (leaf_stops(bvh->blocks, child, r, plain ? limit : daft_forward(limit), hit)) return true;
        child = *--top;
    }
}

#endif
