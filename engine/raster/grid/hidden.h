/* Whether boxes of a tile's pixels lie behind what these see already, for the kernels. */
#ifndef DAFT_HIDDEN_H
#define DAFT_HIDDEN_H

#include "raster/grid/grid.h"

/* pixels: x0 | x1 << 8 | y0 << 16 | y1 << 24, of the tile; least: no w in the box is larger. By cells. */
bool DAFT_KERNEL(daft_cells_hidden)(daft_tile_job *j, uint32_t pixels, float min);

/* Where rows 1 to 7 begin, of a box whose last row is given: beyond it that row again. */
#define ROW(last, r) (uint8_t)(DAFT_TILE_STRIDE * ((r) < (last) ? (r) : (last)))
#define ROWS_TO(last)                                                                                                  \
    {                                                                                                                  \
        ROW(last, 1), ROW(last, 2), ROW(last, 3), ROW(last, 4), ROW(last, 5), ROW(last, 6), ROW(last, 7)               \
    }
_Static_assert(7 * DAFT_TILE_STRIDE <= UINT8_MAX, "rows of a small box are counted in bytes");
static const uint8_t ROWS[8][7] = {ROWS_TO(0), ROWS_TO(1), ROWS_TO(2), ROWS_TO(3),
                                   ROWS_TO(4), ROWS_TO(5), ROWS_TO(6), ROWS_TO(7)};

/* The pixels of a box of rays. */
#define BOX_BYTES ((DAFT_TILE - 1) * 0x01010101)
DAFT_INLINE uint32_t pixels_of(const daft_tile_job *j, uint32_t rays) { return rays >> j->scale_bits & BOX_BYTES; }

/* Whether all pixels of a box of rays see something nearer: by the pixels themselves where they are few. */
DAFT_INLINE bool hidden(daft_tile_job *j, uint32_t rays, float nearest)
{
    const uint32_t pixels = pixels_of(j, rays);
    uint32_t x0 = pixels & 255, width = (pixels >> 8 & 255) - x0, y0 = pixels >> 16 & 255, height = (pixels >> 24) - y0;
    if (width >= 8 || height >= 8) return DAFT_KERNEL(daft_cells_hidden)(j, pixels, nearest);
    const float *w = &j->w_low[y0 * DAFT_TILE_STRIDE + x0];
    const uint8_t *row = ROWS[height];
    v8 min = v8_load(w);
    for (int r = 0; r < 7; r++)
        min = v8_min(min, v8_load(w + row[r])); /* without a branch on the height, which cannot be guessed */
    return !(v8_le_bits(min, v8_set(nearest)) & ((2u << width) - 1));
}

/* The lanes whose boxes are hidden; `rays` is 0 in the others. Two corners of all boxes are looked at side by side,
 * then the other two: they show most of those that are not hidden, and little boxes have no other pixels. */
DAFT_INLINE vbits hidden_lanes(daft_tile_job *j, vi rays, vf nearest, vbits lanes)
{
    const vi pixels = rays >> j->scale_bits & vi_set(BOX_BYTES);
    vi byte = vi_set(255), x0 = pixels & byte, x1 = pixels >> 8 & byte;
    vi y0 = (pixels >> 16 & byte) * DAFT_TILE_STRIDE, y1 = (pixels >> 24 & byte) * DAFT_TILE_STRIDE;
    vf w = vf_min(vf_gather_index(j->w_low, y0 + x0), vf_gather_index(j->w_low, y1 + x1));
    vbits gone = lanes & ~vbits_from_mask(vf_le(w, nearest));
    if (!(gone & vbits_from_mask(vi_lt(vi_set(1), (x1 - x0) + (y1 - y0))))) return gone;
    w = vf_min(vf_gather_index(j->w_low, y0 + x1), vf_gather_index(j->w_low, y1 + x0));
    gone &= ~vbits_from_mask(vf_le(w, nearest));
    vbits large =
        gone & ~vbits_from_mask(vm_and(vi_lt(x1 - x0, vi_set(2)), vi_lt(y1 - y0, vi_set(2 * DAFT_TILE_STRIDE))));
    if (!large) return gone;
    uint32_t box[DAFT_VL];
    float min[DAFT_VL];
    vi_store(box, rays), vf_store(min, nearest);
    for (; large; large &= large - 1) {
        int i = __builtin_ctz(large);
        gone &= ~((vbits)!hidden(j, box[i], min[i]) << i);
    }
    return gone;
}

#endif
