/* Single rays through a kd-tree, front to back, by the intervals of the ray within cells (Havran, "Heuristic Ray
 * Shooting Algorithms", 2000, appendix C).
 *
 * A plane's distance is a difference, an inverse and a product: off by 3u of itself, u = 2^-24. Intervals are wider by
 * 2^-20 of it, so the cell of every point that the ray truly meets is visited. What a triangle's test tells as its
 * distance may be off (ray_test.h), so a cell is passed over only where it begins 2^-15 beyond the nearest hit: the hit
 * is the least over all triangles that could be it, and so the one that any other tree finds. */
#include "accel/kdtree.h"
#include "accel/ray_test.h"

#include <float.h>

#define PLANE 0x1p-20f
#define HIT   0x1p-15f

typedef struct kd_ray {
    float o[3], d[3], inverse[3];
} kd_ray;

typedef struct kd_entry {
    uint32_t node;
    float near, far;
} kd_entry;

typedef struct kd_stack {
    kd_entry items[DAFT_KD_DEPTH + 4];
    int top;
} kd_stack;

static kd_ray ray_setup(daft_vec3 o, daft_vec3 d)
{
    return (kd_ray){{o.x, o.y, o.z}, {d.x, d.y, d.z}, {1 / d.x, 1 / d.y, 1 / d.z}};
}

DAFT_INLINE float wider(float t, float fraction) { return t + fabsf(t) * fraction; }
DAFT_INLINE float sooner(float t, float fraction) { return t - fabsf(t) * fraction; }

/* The ray's interval within the tree's bounds. False: it misses them. */
static bool enter(const daft_kdtree *tree, const kd_ray *r, float tmin, float tmax, kd_entry *out)
{
    const float low[3] = {tree->low.x, tree->low.y, tree->low.z}, high[3] = {tree->high.x, tree->high.y, tree->high.z};
    *out = (kd_entry){0, sooner(tmin, HIT), wider(tmax, HIT)};
    for (int k = 0; k < 3; k++) {
        if (r->d[k] == 0) {
            if (r->o[k] < low[k] || r->o[k] > high[k]) return false;
            continue;
        }
        float a = (low[k] - r->o[k]) * r->inverse[k], b = (high[k] - r->o[k]) * r->inverse[k];
        float near = sooner(a < b ? a : b, PLANE), far = wider(a < b ? b : a, PLANE);
        if (near > out->near) out->near = near; /* a NaN, where the inverse overflowed, says nothing */
        if (far < out->far) out->far = far;
    }
    return out->near <= out->far;
}

/* Goes down to a leaf, leaving the other sides on the stack. */
DAFT_INLINE const daft_kd_node *descend(const daft_kdtree *tree, const kd_ray *r, kd_entry at, kd_stack *stack)
{
    const daft_kd_node *node = &tree->nodes[at.node];
    for (;; node = &tree->nodes[at.node]) {
        uint32_t axis = node->code & 3, pair = node->code >> 2;
        if (axis == DAFT_KD_LEAF) return node;
        float o = r->o[axis], d = r->d[axis], t = (node->split - o) * r->inverse[axis];
        uint32_t first = pair + (d < 0), second = pair + (d >= 0);
        if (d == 0 && o != node->split) {
            at.node = pair + (o > node->split);
            continue;
        }
        if (!(fabsf(t) <= FLT_MAX)) { /* within the plane, or too slow for it */
            stack->items[stack->top++] = (kd_entry){second, at.near, at.far};
            at.node = first;
            continue;
        }
        float until = wider(t, PLANE), from = sooner(t, PLANE);
        bool here = at.near <= until, there = at.far >= from;
        if (here && there) stack->items[stack->top++] = (kd_entry){second, from > at.near ? from : at.near, at.far};
        if (here && until < at.far) at.far = until;
        if (!here && from > at.near) at.near = from;
        at.node = here ? first : second;
    }
}

/* Up to four of a leaf's triangles as a block. */
DAFT_INLINE void gather(const daft_kdtree *tree, const uint32_t *items, uint32_t count, daft_block *block)
{
    uint32_t last = (count < DAFT_BLOCK ? count : DAFT_BLOCK) - 1;
    const v4 *c[DAFT_BLOCK];
    for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
        c[i] = &tree->corners[3 * (size_t)items[i < last ? i : last]];
        block->triangle[i] = i <= last ? items[i] : DAFT_NO_TRIANGLE;
    }
    for (int k = 0; k < 3; k++)
        for (int axis = 0; axis < 3; axis++) {
            v4 lane = {c[0][k][axis], c[1][k][axis], c[2][k][axis], c[3][k][axis]};
            memcpy(block->corner[k][axis], &lane, sizeof lane);
        }
}

void DAFT_KERNEL(daft_kd_closest)(const daft_kdtree *tree, daft_vec3 o, daft_vec3 d, float tmin, daft_intersection how,
                                  daft_nearest *hit)
{
    kd_ray r = ray_setup(o, d);
    daft_mesh_ray m = daft_mesh_ray_of(o, d, tmin, hit->t, how);
    kd_stack stack;
    stack.top = 0;
    if (!enter(tree, &r, tmin, hit->t, &stack.items[stack.top++])) return;
    while (stack.top > 0) {
        kd_entry at = stack.items[--stack.top];
        if (at.near > wider(hit->t, HIT)) continue;
        const daft_kd_node *leaf = descend(tree, &r, at, &stack);
        const uint32_t *items = &tree->items[leaf->code >> 2];
        for (uint32_t i = 0; i < leaf->count; i += DAFT_BLOCK) {
            daft_block block;
            gather(tree, items + i, leaf->count - i, &block);
            float past = daft_forward(daft_past(hit->t));
            if (daft_blocks_intersect(&block, 1, &m, past, hit, false)) hit->block = NULL; /* this one goes */
        }
    }
}

bool DAFT_KERNEL(daft_kd_occluded)(const daft_kdtree *tree, daft_vec3 o, daft_vec3 d, float tmin, float tmax,
                                   daft_intersection how)
{
    kd_ray r = ray_setup(o, d);
    kd_stack stack;
    daft_nearest hit = {.t = tmax, .triangle = DAFT_NO_TRIANGLE};
    daft_mesh_ray m = daft_mesh_ray_of(o, d, tmin, tmax, how);
    stack.top = 0;
    if (!enter(tree, &r, tmin, tmax, &stack.items[stack.top++])) return false;
    while (stack.top > 0) {
        const daft_kd_node *leaf = descend(tree, &r, stack.items[--stack.top], &stack);
        const uint32_t *items = &tree->items[leaf->code >> 2];
        for (uint32_t i = 0; i < leaf->count; i += DAFT_BLOCK) {
            daft_block block;
            gather(tree, items + i, leaf->count - i, &block);
            if (daft_blocks_intersect(&block, 1, &m, daft_forward(daft_past(tmax)), &hit, true)) return true;
        }
    }
    return false;
}
