/* Blocks of triangles in lanes, moved to view space, and the planes that the apex makes with their edges. For both
 * sample sets.
 *
 * Edge functions. The plane of the apex and an edge a, b has the normal n = (a - b) × (a + b) = 2·a × b; exchanging a
 * and b negates each bit, so neighbours see the same number. With u = 2^-24: a - b and a + b round once, each product
 * once, their difference once, so a component of n is off by at most 4u·M with M = |x|·|y'| + |y|·|x'| of its two
 * products; the three products with a ray d and two sums add 3u·|n|·|d|. Together |error(n·d)| <= 7u·(Mx·|dx| + My·|dy|
 * + Mz·|dz|) to first order. */
#ifndef DAFT_TRIANGLES_H
#define DAFT_TRIANGLES_H

#include "accel/bvh.h"
#include "math/simd/ops.h"

#define UNIT 0x1p-24f
#define TINY 1e-36f

enum { DAFT_BATCH_BLOCKS = DAFT_VL / DAFT_BLOCK };

/* One axis of one corner of the blocks, side by side. */
DAFT_INLINE vf blocks_load(const daft_block *const *blocks, int corner, int axis)
{
    const float *four[DAFT_BATCH_BLOCKS];
    for (uint32_t i = 0; i < DAFT_BATCH_BLOCKS; i++) four[i] = blocks[i]->corner[corner][axis];
    return vf_gather_blocks(four);
}

DAFT_INLINE vi blocks_triangles(const daft_block *const *blocks)
{
    const float *four[DAFT_BATCH_BLOCKS];
    for (uint32_t i = 0; i < DAFT_BATCH_BLOCKS; i++) four[i] = (const float *)(const void *)blocks[i]->triangle;
    return (vi)vf_gather_blocks(four);
}

/* The same operations in the same order as daft_affine_point. */
DAFT_INLINE vf3 move(const daft_affine *a, vf3 p)
{
    const float *m = a->m, *t = a->t;
    return (vf3){((vf_set(m[0]) * p.x + vf_set(m[1]) * p.y) + vf_set(m[2]) * p.z) + vf_set(t[0]),
                 ((vf_set(m[3]) * p.x + vf_set(m[4]) * p.y) + vf_set(m[5]) * p.z) + vf_set(t[1]),
                 ((vf_set(m[6]) * p.x + vf_set(m[7]) * p.y) + vf_set(m[8]) * p.z) + vf_set(t[2])};
}

DAFT_INLINE vf3 blocks_corner(const daft_affine *map, const daft_block *const *blocks, int corner)
{
    return move(map,
                (vf3){blocks_load(blocks, corner, 0), blocks_load(blocks, corner, 1), blocks_load(blocks, corner, 2)});
}

/* The plane of an edge, and the M of the bound. */
typedef struct edge {
    vf3 n;
    vf mx, my, mz;
} edge;

/* a and b relative to the apex; ez: a.z - b.z, which is known more precisely where the apex is far. */
DAFT_INLINE edge edge_setup(vf3 a, vf3 b, vf ez)
{
    vf3 e = {a.x - b.x, a.y - b.y, ez}, s = {a.x + b.x, a.y + b.y, a.z + b.z};
    vf yz = e.y * s.z, zy = e.z * s.y, zx = e.z * s.x, xz = e.x * s.z, xy = e.x * s.y, yx = e.y * s.x;
    return (edge){
        {yz - zy, zx - xz, xy - yx}, vf_abs(yz) + vf_abs(zy), vf_abs(zx) + vf_abs(xz), vf_abs(xy) + vf_abs(yx)};
}

/* The M's sum over a ray's components, or over bounds of them. */
DAFT_INLINE vf edge_size(const edge *e, vf dx, vf dy, vf dz) { return e->mx * dx + e->my * dy + e->mz * dz; }

#endif
