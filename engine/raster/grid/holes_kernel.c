/* Holes of triangles with alpha in a window of pixels: daft_in_hole (raster/holes.c) in lanes, bit for bit. */
#include "raster/grid/grid.h"

DAFT_INLINE vf value_at(const float f[3], vf column, vf row)
{
    return vf_set(f[0]) + (vf_set(f[1]) * column + vf_set(f[2]) * row);
}

/* daft_pencil_turned */
DAFT_INLINE vf turned(vf place) { return vf_convert_to(vi_convert_to(place) & vi_set(3)) - vf_set(1.5f); }

vbits DAFT_KERNEL(daft_holes_pass)(const daft_holes *h, int x, int y, vbits hits)
{
    const vf turn = vf_set(h->turn), across = vf_set((float)x) + vf_column(), down = vf_set((float)y) + vf_row();
    const vf column = across + turn * turned(down), row = down - turn * turned(across);
    const vf s = value_at(h->s, column, row), size = vf_abs(s), inverse = vf_set(1) / s;
    const vf u = value_at(h->u, column, row) * inverse, v = value_at(h->v, column, row) * inverse;
    const vm close = vm_and(vf_le(vf_set(h->off_u) + vf_abs(u) * vf_set(h->off_s), vf_set(h->on.left_u) * size),
                            vf_le(vf_set(h->off_v) + vf_abs(v) * vf_set(h->off_s), vf_set(h->on.left_v) * size));
    hits &= vbits_from_mask(close);
    if (!hits) return 0;
    const vf least = vf_gather_index(h->least_s, mask_cells(h->on.mask, u, v));
    return hits & vbits_from_mask(vf_le(least, size));
}
