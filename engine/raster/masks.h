/* Lanes of places on one triangle with alpha, looked up in its material's mask (accel.h): what is known of them without
 * reading a texture. */
#ifndef DAFT_RASTER_MASKS_H
#define DAFT_RASTER_MASKS_H

#include "raster/holes.h"
#include "raster/triangles.h"

DAFT_INLINE vf mask_wrapped(vf a, uint32_t wrap)
{
    const vf half = vf_set(0.5f), two = vf_set(2);
    if (wrap == DAFT_WRAP_REPEAT) return a - vf_floor(a);
    if (wrap == DAFT_WRAP_CLAMP) return vf_clamp01(a);
    const vf twice = (a * half - vf_floor(a * half)) * two;
    return vf_min(twice, two - twice);
}

/* The cells at these places of the texture. */
DAFT_INLINE vi mask_cells(const daft_mask *m, vf u, vf v)
{
    const vf zero = vf_set(0);
    const vf column =
                 vf_min(vf_max(mask_wrapped(u, m->wrap) * vf_set(m->across), zero), vf_set((float)(m->columns - 1))),
             row = vf_min(vf_max(mask_wrapped(v, m->wrap) * vf_set(m->down), zero), vf_set((float)(m->rows - 1)));
    const vi cell = vi_convert_to(row) * vi_set(m->columns) + vi_convert_to(column);
    const vi word = vi_gather_index(m->cells, cell >> __builtin_ctz(DAFT_MASK_CELLS));
    return (word >> ((cell & vi_set(DAFT_MASK_CELLS - 1)) * vi_set(DAFT_MASK_BITS))) &
           vi_set((1 << DAFT_MASK_BITS) - 1);
}

/* The DAFT_OPACITY_… of the places with these weights of the second and third corner, which are off by `error`. */
DAFT_INLINE vi mask_states(const daft_mask_triangle *t, vf second, vf third, vf error)
{
    const vf u = vf_set(t->u) + vf_set(t->u1) * second + vf_set(t->u2) * third,
             v = vf_set(t->v) + vf_set(t->v1) * second + vf_set(t->v2) * third;
    const vi cell = mask_cells(t->mask, u, v), clear = vi_set(DAFT_OPACITY_CLEAR);
    const vi state = vi_if_then_else(vi_lt(clear, cell), clear, cell);
    return (vi)vf_if_then_else(vf_le(error, vf_set(t->most)), (vf)state, vf_set(0));
}

#endif
