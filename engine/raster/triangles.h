/* Blocks of triangles in lanes, set up: moved to view space, their extent in the picture, and the planes that the apex
 * makes with their edges. For both sample sets; what grids add is in grid/setup_kernel.c, what lights add in
 * samples/setup.h.
 *
 * Edge functions. The plane of the apex and an edge a, b has the normal n = (a - b) × (a + b) = 2·a × b; exchanging a
 * and b negates each bit, so neighbours see the same number. With u = 2^-24: a - b and a + b round once, each product
 * once, their difference once, so a component of n is off by at most 4u·M with M = |x|·|y'| + |y|·|x'| of its two
 * products; the three products with a ray d and two sums add 3u·|n|·|d|. Together |error(n·d)| <= 7u·(Mx·|dx| + My·|dy|
 * + Mz·|dz|) to first order. (a × b as it stands takes six operations less, cancels in far triangles, and loses their
 * hits.) */
#ifndef DAFT_TRIANGLES_H
#define DAFT_TRIANGLES_H

#include "accel/bvh.h"
#include "math/simd/ops.h"
#include "raster/view.h"

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

/* Corners in view space. p.z is the z of the ray test, counted from the apex, and 1 in a parallel pencil; depth counts
 * from the view's origin, which is a grid's apex. */
typedef struct view_corners {
    vf3 p[3];
    vf depth[3];
} view_corners;

/* grid: the pencil's origin is its apex. */
DAFT_INLINE view_corners blocks_move(const daft_pencil *p, bool grid, const daft_affine *map,
                                     const daft_block *const *blocks)
{
    view_corners c;
    for (int k = 0; k < 3; k++) {
        const vf3 at = blocks_corner(map, blocks, k);
        c.depth[k] = at.z;
        c.p[k] = (vf3){at.x, at.y, grid ? at.z : p->parallel ? vf_set(1) : at.z + vf_set(p->away)};
    }
    return c;
}

/* The least and the largest coordinates in the picture. */
typedef struct view_extent {
    vf low_x, high_x, low_y, high_y;
} view_extent;

DAFT_INLINE view_extent extent_empty(void)
{
    const vf inf = vf_set(INFINITY);
    return (view_extent){inf, -inf, inf, -inf};
}

/* scale: by which the corner's x and y become those of the picture. */
DAFT_INLINE void extent_add(view_extent *e, const vf3 *p, vf scale)
{
    const vf x = p->x * scale, y = p->y * scale;
    e->low_x = vf_min(x, e->low_x), e->high_x = vf_max(x, e->high_x);
    e->low_y = vf_min(y, e->low_y), e->high_y = vf_max(y, e->high_y);
}

/* The least and the largest depth. */
DAFT_INLINE vf nearest_depth(const view_corners *c) { return vf_min(c->depth[0], vf_min(c->depth[1], c->depth[2])); }
DAFT_INLINE vf farthest_depth(const view_corners *c) { return vf_max(c->depth[0], vf_max(c->depth[1], c->depth[2])); }

/* A plane's normal, the product of two vectors in it, and the M of its bound. */
typedef struct plane {
    vf3 n, m;
} plane;

DAFT_INLINE plane plane_of(vf3 a, vf3 b)
{
    vf yz = a.y * b.z, zy = a.z * b.y, zx = a.z * b.x, xz = a.x * b.z, xy = a.x * b.y, yx = a.y * b.x;
    return (plane){{yz - zy, zx - xz, xy - yx},
                   {vf_abs(yz) + vf_abs(zy), vf_abs(zx) + vf_abs(xz), vf_abs(xy) + vf_abs(yx)}};
}

/* Of the apex and the edge opposite corner k. The difference of depths is more precise than that of z where the apex is
 * far. */
DAFT_INLINE plane edge_plane(const view_corners *c, int k, bool parallel)
{
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const vf3 a = c->p[i], b = c->p[j];
    const vf z = parallel ? vf_set(0) : c->depth[i] - c->depth[j];
    return plane_of((vf3){a.x - b.x, a.y - b.y, z}, (vf3){a.x + b.x, a.y + b.y, a.z + b.z});
}

/* The M's sum over a ray's components, or over bounds of them. */
DAFT_INLINE vf plane_size(const plane *e, vf dx, vf dy, vf dz) { return e->m.x * dx + e->m.y * dy + e->m.z * dz; }

#endif
