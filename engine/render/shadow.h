/* What the two kernel sources of the shadow pencil share. See shadow_kernel.c for the method. */
#ifndef DAFT_SHADOW_H
#define DAFT_SHADOW_H

#include "accel/bvh.h"
#include "math/simd.h"
#include "render/kernels.h"

enum {
    SHADOW_BLOCK = 16,                              /* points in a block, whatever the instruction set */
    SHADOW_TILE_BLOCKS = DAFT_BATCH / SHADOW_BLOCK, /* patches of 4 by 4 pixels in a tile */
    SHADOW_BLOCKS = 2 * SHADOW_TILE_BLOCKS + 16,    /* each patch begins a block, and so does what is left of them */
    SHADOW_LANES = SHADOW_BLOCKS * SHADOW_BLOCK,
    SHADOW_GROUPS = SHADOW_BLOCKS / DAFT_VL /* of DAFT_VL blocks, which stand side by side */
};

/* A lamp's view of some points. Light space has its origin in their middle, so its coordinates are as precise as the
 * points are however far the lamp is; x and y are across the light, the depth d along it. A point lamp is at (0, 0,
 * -away): a point's ray is (x, y, d + away). A sun's is (x, y, 1). u = x/z and v = y/z are the picture's coordinates.
 */
typedef struct light {
    bool sun;
    daft_vec3 origin;                   /* of light space, in frame space */
    daft_affine map;                    /* frame space to light space */
    float low_u, low_v, high_u, high_v; /* of the points */
    float slack_u, slack_v;             /* over the rounding of projected coordinates */
    float away;                         /* of the lamp from the origin; sun: 0 */
    float near, far;                    /* depths of the points */
    float max_x, max_y, max_z;          /* magnitudes of the rays' components */
    float size;                         /* largest |x|, |y| and |d|, added up */
    float reach;                        /* largest |x| + |y| + |z| of a point, in frame space */
} light;

/* A box in a lamp's picture, from a depth on. */
typedef struct picture_box {
    float low_u, high_u, low_v, high_v, near;
} picture_box;

/* Points in blocks of neighbours, which a triangle is tested against together; each block's box in the picture, and
 * each group's. */
typedef struct shadow_points {
    uint32_t count, live; /* blocks, and those with a lit point; the boxes of the others are empty */
    uint32_t groups;
    float group_low_u[SHADOW_GROUPS], group_high_u[SHADOW_GROUPS], group_low_v[SHADOW_GROUPS],
        group_high_v[SHADOW_GROUPS];
    float group_far[SHADOW_GROUPS];
    _Alignas(64) float low_u[SHADOW_BLOCKS], high_u[SHADOW_BLOCKS], low_v[SHADOW_BLOCKS], high_v[SHADOW_BLOCKS];
    _Alignas(64) float far[SHADOW_BLOCKS];
    _Alignas(64) float u[SHADOW_LANES], v[SHADOW_LANES];
    _Alignas(64) float x[SHADOW_LANES], y[SHADOW_LANES], z[SHADOW_LANES];
    _Alignas(64) float depth[SHADOW_LANES]; /* -inf: in shadow, or no point */
    _Alignas(64) uint32_t source[SHADOW_LANES], instance[SHADOW_LANES];
    _Alignas(64) uint32_t own[SHADOW_LANES]; /* the triangle that the point lies on and that cannot shadow it, or
                                              * DAFT_NO_TRIANGLE */
} shadow_points;

/* Boxes of a node's children. */
typedef struct node_boxes {
    float low_u[DAFT_WIDTH], high_u[DAFT_WIDTH], low_v[DAFT_WIDTH], high_v[DAFT_WIDTH], near[DAFT_WIDTH];
} node_boxes;

DAFT_INLINE picture_box node_child(const node_boxes *b, int i)
{
    return (picture_box){b->low_u[i], b->high_u[i], b->low_v[i], b->high_v[i], b->near[i]};
}

/* Which of a group's blocks lie, in part, behind the box. */
DAFT_INLINE vbits blocks_behind(const picture_box *box, const shadow_points *p, uint32_t group)
{
    uint32_t b = group * DAFT_VL;
    vm u = vm_and(vf_le(vf_set(box->low_u), vf_load(&p->high_u[b])), vf_le(vf_load(&p->low_u[b]), vf_set(box->high_u)));
    vm v = vm_and(vf_le(vf_set(box->low_v), vf_load(&p->high_v[b])), vf_le(vf_load(&p->low_v[b]), vf_set(box->high_v)));
    return vm_bits(vm_and(vm_and(u, v), vf_le(vf_set(box->near), vf_load(&p->far[b]))));
}

DAFT_INLINE bool group_behind(const picture_box *box, const shadow_points *p, uint32_t group)
{
    return box->low_u <= p->group_high_u[group] && p->group_low_u[group] <= box->high_u &&
           box->low_v <= p->group_high_v[group] && p->group_low_v[group] <= box->high_v &&
           box->near <= p->group_far[group];
}

/* Whether a lit point of the block lies behind the box. */
DAFT_INLINE bool points_behind(const picture_box *box, const shadow_points *p, uint32_t b)
{
    vbits any = 0;
    for (uint32_t k = b * SHADOW_BLOCK; k < (b + 1) * SHADOW_BLOCK; k += DAFT_VL) {
        vf u = vf_load(&p->u[k]), v = vf_load(&p->v[k]);
        vm in = vm_and(vm_and(vf_le(vf_set(box->low_u), u), vf_le(u, vf_set(box->high_u))),
                       vm_and(vf_le(vf_set(box->low_v), v), vf_le(v, vf_set(box->high_v))));
        any |= vm_bits(vm_and(in, vf_le(vf_set(box->near), vf_load(&p->depth[k]))));
    }
    return any != 0;
}

/* Whether a lit point lies behind the box, or many blocks do. */
DAFT_INLINE bool box_has_points(const picture_box *box, const shadow_points *p)
{
    for (uint32_t g = 0; g < p->groups; g++) {
        if (!group_behind(box, p, g)) continue;
        vbits blocks = blocks_behind(box, p, g);
        if (__builtin_popcount(blocks) > 4) return true;
        for (; blocks; blocks &= blocks - 1)
            if (points_behind(box, p, g * DAFT_VL + (uint32_t)__builtin_ctz(blocks))) return true;
    }
    return false;
}

/* A mesh of no thickness: none of its triangles hides those of its points from a lamp that face it. */
DAFT_INLINE bool is_flat(const daft_instance *s)
{
    if (!s->mesh) return false;
    daft_vec3 size = daft_sub(s->mesh->high, s->mesh->low);
    return size.x == 0 || size.y == 0 || size.z == 0;
}

/* The map b, then a, from whose origin `origin` is taken first. */
daft_affine DAFT_KERNEL(daft_light_compose)(const daft_affine *a, const daft_affine *b, daft_vec3 origin);

/* Projects the children through `map`, which leads to light space; gives the bits of those that meet the points'
 * extent. */
uint32_t DAFT_KERNEL(daft_node_project)(const light *l, const daft_affine *map, const daft_node *node, node_boxes *out);

/* Puts the points that the instance, whose bounds have this box, hides from the lamp to depth -inf. */
void DAFT_KERNEL(daft_cast_shadow)(const light *l, const daft_lamp *lamp, const daft_batch *batch,
                                   const daft_instance *instance, uint32_t number, const picture_box *box,
                                   shadow_points *points);

#endif
