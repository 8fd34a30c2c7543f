/* Blocks of triangles in lanes, and those of them that wait: for the kernels. */
#ifndef DAFT_BLOCKS_H
#define DAFT_BLOCKS_H

#include "raster/kernels.h"

#define UNIT 0x1p-24f
#define TINY 1e-36f

/* Blocks by number; nothing is computed from what is not there. */
DAFT_INLINE void blocks_at(const daft_seen *seen, const uint32_t *blocks, uint32_t count, const daft_block *out[DAFT_BATCH_BLOCKS])
{
    for (uint32_t i = 0; i < DAFT_BATCH_BLOCKS; i++) out[i] = &seen->bvh->blocks[blocks[i < count ? i : 0]];
}

/* One axis of one corner of the blocks, side by side. */
DAFT_INLINE vf blocks_load(const daft_block **blocks, int corner, int axis)
{
    const float *four[DAFT_BATCH_BLOCKS];
    for (uint32_t i = 0; i < DAFT_BATCH_BLOCKS; i++) four[i] = blocks[i]->corner[corner][axis];
    return vf_gather_blocks(four);
}

DAFT_INLINE vi blocks_triangles(const daft_block **blocks)
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

/* Adds those of `some`. */
DAFT_INLINE void waiting_add(daft_waiting *out, const vf3 corner[3], vi pixels, vf nearest, uint32_t instance, vi triangle, vbits some)
{
    uint32_t at = out->count;
    for (int k = 0; k < 3; k++) {
        vf_compress_store(&out->corner[3 * k][at], some, corner[k].x);
        vf_compress_store(&out->corner[3 * k + 1][at], some, corner[k].y);
        vf_compress_store(&out->corner[3 * k + 2][at], some, corner[k].z);
    }
    vi_compress_store(&out->pixels[at], some, pixels);
    vf_compress_store(&out->nearest[at], some, nearest);
    vi_compress_store(&out->triangle[at], some, triangle);
    vi_store(&out->instance[at], vi_set((int32_t)instance));
    out->count += (uint32_t)__builtin_popcount(some);
}

#endif
