/* Holes of triangles with alpha in a window of pixels: daft_in_hole (raster/holes.c) in lanes, bit for bit. */
#include "math/simd/elementary.h"
#include "raster/grid/grid.h"

DAFT_INLINE vf value_at(const float f[3], vf column, vf row)
{
    return vf_set(f[0]) + (vf_set(f[1]) * column + vf_set(f[2]) * row);
}

/* daft_pencil_turned */
DAFT_INLINE vf turned(vf place) { return vf_convert_to(vi_convert_to(place) & vi_set(3)) - vf_set(1.5f); }

/* ---- the texture ---- */

/* Two texels of an axis, and the weight of the second. */
typedef struct taps {
    vi first, second;
    vf weight;
} taps;

DAFT_INLINE taps taps_at(vf place, int size, bool edges)
{
    const vf one = vf_set(1), half = vf_set(0.5f), last = vf_set((float)size - (edges ? 1.0f : 0.5f));
    const vf x = vf_min(vf_max(place * vf_set((float)size) - half, edges ? vf_set(0) : -half), last);
    const vi below = vi_convert_to(x + one) - vi_set(1), above = below + vi_set(1), end = vi_set(size);
    return (taps){vi_if_then_else(vi_lt(below, vi_set(0)), end - vi_set(1), below),
                  vi_if_then_else(vi_lt(above, end), above, vi_set(0)), x - vf_convert_to(below)};
}

DAFT_INLINE vf byte_at(const daft_holes *h, int level, vi row, vi column)
{
    const vi texel = vi_gather_index(h->texture->texels[level], row * vi_set(h->texture->width[level]) + column);
    return vf_convert_to((texel >> (int)(8 * h->on.mask->channel)) & vi_set(255)) * vf_set(1.0f / 255);
}

/* u, v: as mask_wrapped puts them into the texture. */
DAFT_INLINE vf level_alpha(const daft_holes *h, int level, vf u, vf v)
{
    const bool edges = h->on.mask->wrap != DAFT_WRAP_REPEAT;
    const taps x = taps_at(u, h->texture->width[level], edges), y = taps_at(v, h->texture->height[level], edges);
    const vf a = byte_at(h, level, y.first, x.first), b = byte_at(h, level, y.first, x.second),
             c = byte_at(h, level, y.second, x.first), d = byte_at(h, level, y.second, x.second);
    const vf top = a + (b - a) * x.weight, bottom = c + (d - c) * x.weight;
    return top + (bottom - top) * y.weight;
}

/* Of the lanes in `left`, by the area of their pixels in texels. */
static vf filtered_alpha(const daft_holes *h, vf u, vf v, vf area, vbits left)
{
    const vf zero = vf_set(0), one = vf_set(1), last = vf_set((float)(h->texture->levels - 1));
    const vf level = vf_min(vf_max(vf_log2(vf_max(area, vf_set(1e-30f))) * vf_set(0.5f), zero), last);
    const vi floor = vi_convert_to(level);
    const vf between = (level - vf_convert_to(floor)) * vf_set(2) - vf_set(0.5f);
    const vm next = vf_le(one, between);
    const vi fine = vi_if_then_else(next, floor + vi_set(1), floor);
    const vf blend = vf_if_then_else(next, zero, vf_max(between, zero));
    const vbits both = vbits_from_mask(vf_lt(zero, blend));
    vf alpha = zero;
    u = mask_wrapped(u, h->on.mask->wrap), v = mask_wrapped(v, h->on.mask->wrap);
    while (left) {
        const int k = fine[__builtin_ctz(left)];
        const vm same = vi_eq(fine, vi_set(k));
        vf found = level_alpha(h, k, u, v);
        if (both & left & vbits_from_mask(same)) {
            const vf coarse = level_alpha(h, daft_min_i(k + 1, h->texture->levels - 1), u, v);
            found = vf_if_then_else(vm_from_bits(both), found * (one - blend) + coarse * blend, found);
        }
        alpha = vf_if_then_else(same, found, alpha);
        left &= ~vbits_from_mask(same);
    }
    return alpha;
}

/* Where the window's pixels meet the triangle. */
typedef struct meeting {
    vf column, row; /* as the rays are turned */
    vf size;        /* |s| */
    vf u, v, off_u, off_v;
} meeting;

/* Of those in `left`, the lanes that filter less than what is there. */
static __attribute__((noinline)) vbits read_holes(const daft_holes *h, const meeting *m, vi cell, vbits left)
{
    const vf dx = vf_set(h->left) + m->column, dy = vf_set(h->top) - m->row;
    const vf length2 = dx * dx + dy * dy + vf_set(h->focal2);
    const vf steep = vf_max(m->size / vf_sqrt(length2), vf_set(h->grazing));
    const vf area = vf_set(h->area) * length2 / (m->size * m->size * steep);
    const vm solid = vm_and(vi_eq(cell, vi_set(DAFT_OPACITY_OPAQUE)), vf_le(area, vf_set(DAFT_HOLE_FINEST)));
    left &= ~vbits_from_mask(solid);
    if (!left) return 0;
    const vf off = m->off_u * vf_set(h->on.mask->width) + m->off_v * vf_set(h->on.mask->height);
    const vf most = filtered_alpha(h, m->u, m->v, area, left) + (off + vf_set(DAFT_HOLE_MARGIN));
    return left & vbits_from_mask(vf_lt(most, vf_set(h->on.mask->cutoff)));
}

vbits DAFT_KERNEL(daft_holes_pass)(const daft_holes *h, int x, int y, vbits hits)
{
    const vf turn = vf_set(h->turn), across = vf_set((float)x) + vf_column(), down = vf_set((float)y) + vf_row();
    meeting m = {.column = across + turn * turned(down), .row = down - turn * turned(across)};
    const vf s = value_at(h->s, m.column, m.row), inverse = vf_set(1) / s;
    m.size = vf_abs(s);
    m.u = value_at(h->u, m.column, m.row) * inverse, m.v = value_at(h->v, m.column, m.row) * inverse;
    const vf off_u = vf_set(h->off_u) + vf_abs(m.u) * vf_set(h->off_s),
             off_v = vf_set(h->off_v) + vf_abs(m.v) * vf_set(h->off_s);
    const vm close = vm_and(vf_le(off_u, vf_set(h->on.left_u) * m.size), vf_le(off_v, vf_set(h->on.left_v) * m.size));
    hits &= vbits_from_mask(close);
    if (!hits) return 0;
    const vi cell = mask_cells(h->on.mask, m.u, m.v);
    const vbits known = hits & vbits_from_mask(vf_le(vf_gather_index(h->least_s, cell), m.size));
    if (!h->texture || known == hits) return known;
    m.off_u = off_u / m.size + vf_set(h->on.mask->slack_u - h->on.left_u);
    m.off_v = off_v / m.size + vf_set(h->on.mask->slack_v - h->on.left_v);
    return known | read_holes(h, &m, cell, hits & ~known);
}
