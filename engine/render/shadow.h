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
    SHADOW_SET_WORDS = (SHADOW_BLOCKS + 63) / 64
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

/* A set of blocks, by bits. */
typedef struct block_set {
    uint64_t bits[SHADOW_SET_WORDS];
} block_set;

/* The blocks of `from` that have a lit point behind the box, as far as that is quickly known; false where there is none. As a
 * walk goes down a tree fewer blocks are left, and only these are looked at. */
DAFT_INLINE bool blocks_narrow(const picture_box *box, const shadow_points *p, const block_set *from, block_set *to)
{
    uint64_t any = 0;
    for (uint32_t word = 0; word < SHADOW_SET_WORDS; word++) {
        to->bits[word] = 0;
        for (uint64_t left = from->bits[word]; left;) {
            uint32_t shift = (uint32_t)__builtin_ctzll(left) / DAFT_VL * DAFT_VL, first = word * 64 + shift;
            vbits in = (vbits)(left >> shift) & DAFT_ALL_LANES;
            left &= ~((uint64_t)DAFT_ALL_LANES << shift);
            if (__builtin_popcount(in) > 2) in &= blocks_behind(box, p, first / DAFT_VL);
            if (__builtin_popcount(in) <= 4)
                for (vbits each = in; each; each &= each - 1)
                    if (!points_behind(box, p, first + (uint32_t)__builtin_ctz(each))) in &= ~(each & -each);
            to->bits[word] |= (uint64_t)in << shift;
        }
        any |= to->bits[word];
    }
    return any != 0;
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

/* Puts the points that the instance hides from the lamp to depth -inf; only those of the blocks behind its bounds. */
void DAFT_KERNEL(daft_cast_shadow)(const light *l, const daft_lamp *lamp, const daft_batch *batch,
                                   const daft_instance *instance, uint32_t number, const block_set *behind,
                                   shadow_points *points);

#endif
