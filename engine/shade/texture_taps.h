/* Taps: bilinear samples of one level of a texture, four texels each. Those of many points are collected side by side
 * before texels are read, so that all lanes are busy whatever the number of a point's taps and whichever their levels.
 *
 * A list goes through three stages, each of which takes the place of the one before: where a tap is (u, v, level);
 * where its texels are and the weights between them; its colour. Beyond the last tap is room for one whole SIMD store.
 */
#ifndef DAFT_TEXTURE_TAPS_H
#define DAFT_TEXTURE_TAPS_H

#include "math/simd/ops.h"
#include "shade/shade.h"
#include "shade/srgb_table.h"

/* What of the texels is asked for: sRGB colours as linear light or all bytes as they are, 0..1; constants where this is
 * inlined. */
typedef struct texture_use {
    bool linear, nearest, edges; /* edges: of some taps, edges do not meet the opposite ones */
} texture_use;

enum {
    TAP_BLOCK = 32 * DAFT_VL, /* at most of DAFT_VL points: sixteen of each of two levels */
    TAPS = 128 + TAP_BLOCK,
    TAP_U = 0, /* 0..1 */
    TAP_V,
    TAP_LEVEL,
    TAP_INSIDE, /* 1: edges do not meet the opposite ones; where some do not */
    TAP_ACROSS = 0,
    TAP_DOWN,
    TAP_ABOVE, /* the left one of two texels of a row, in words of their allocation; the other one is beside it */
    TAP_BELOW,
    TAP_WORDS
};

typedef struct tap_list {
    uint32_t count;
    float word[TAP_WORDS][TAPS + DAFT_VL];
    /* Of each DAFT_VL taps, bits: in level 0; where a row's end meets its beginning, or a row is a single texel. The
     * latter have their row's first texel as the left one. */
    vbits full[TAPS / DAFT_VL + 1], split[TAPS / DAFT_VL + 1];
    bool narrow[TAPS / DAFT_VL + 1]; /* there are rows of a single texel, beside which nothing may lie */
    int32_t width[TAPS + DAFT_VL];
} tap_list;

/* A texture's levels as lanes look them up. */
typedef struct texture_levels {
    const uint8_t *full, *smaller; /* level 0; all others, one after the other */
    float width[16], height[16];
    int32_t first[16]; /* words of `smaller` */
} texture_levels;

DAFT_INLINE void list_levels(const daft_texture_data *t, texture_levels *out)
{
    int32_t first = 0;
    out->full = t->texels[0], out->smaller = t->levels > 1 ? t->texels[1] : t->texels[0];
    for (int k = 0; k < t->levels; k++) {
        out->width[k] = (float)t->width[k], out->height[k] = (float)t->height[k], out->first[k] = first;
        if (k > 0) first += t->width[k] * t->height[k];
    }
}

/* Adds a tap of each of the lanes. */
DAFT_INLINE void add_taps(tap_list *list, vf u, vf v, vi level, vm inside, bool edges, vbits lanes)
{
    const uint32_t at = list->count;
    vf_compress_store(&list->word[TAP_U][at], lanes, u), vf_compress_store(&list->word[TAP_V][at], lanes, v);
    vi_compress_store(&list->word[TAP_LEVEL][at], lanes, level);
    if (edges) vi_compress_store(&list->word[TAP_INSIDE][at], lanes, vi_if_then_else(inside, vi_set(1), vi_set(0)));
    list->count += (uint32_t)__builtin_popcount(lanes);
}

/* ---- places ---- */

/* The nearest of two texels has all the weight. */
DAFT_INLINE vf step_at_half(vf a) { return vf_if_then_else(vf_lt(a, vf_set(0.5f)), vf_set(0), vf_set(1)); }

/* The top row has v = 1. */
DAFT_INLINE void place_taps(tap_list *list, uint32_t i, const texture_levels *levels, texture_use use)
{
    const vf half = vf_set(0.5f), one = vf_set(1), zero = vf_set(0);
    const vi level = vi_load(&list->word[TAP_LEVEL][i]), unit = vi_set(1), none = vi_set(0);
    const vf width = vf_table_lookup16(levels->width, level), height = vf_table_lookup16(levels->height, level);
    vf x = vf_load(&list->word[TAP_U][i]) * width - half, y = (one - vf_load(&list->word[TAP_V][i])) * height - half;
    if (use.edges) {
        const vm inside = vi_eq(vi_load(&list->word[TAP_INSIDE][i]), unit);
        x = vf_if_then_else(inside, vf_min(vf_max(x, zero), width - one), x);
        y = vf_if_then_else(inside, vf_min(vf_max(y, zero), height - one), y);
    }
    const vi x0 = vi_convert_to(x + one) - unit, y0 = vi_convert_to(y + one) - unit; /* floors: both are > -1 */
    const vi columns = vi_convert_to(width), rows = vi_convert_to(height);
    const vi above = vi_if_then_else(vi_lt(y0, none), rows - unit, y0),
             below = vi_if_then_else(vi_lt(y0 + unit, rows), y0 + unit, none);
    const vm paired = vm_and(vm_not(vi_lt(x0, none)), vi_lt(x0 + unit, columns));
    const vi first =
        (vi)vf_table_lookup16((const float *)(const void *)levels->first, level) + vi_if_then_else(paired, x0, none);
    vf across = x - vf_convert_to(x0), down = y - vf_convert_to(y0);
    if (use.nearest) across = step_at_half(across), down = step_at_half(down);
    vf_store(&list->word[TAP_ACROSS][i], across), vf_store(&list->word[TAP_DOWN][i], down);
    vi_store(&list->word[TAP_ABOVE][i], first + above * columns);
    vi_store(&list->word[TAP_BELOW][i], first + below * columns);
    vi_store(&list->width[i], columns);
    list->full[i / DAFT_VL] = vbits_from_mask(vi_eq(level, none));
    list->split[i / DAFT_VL] = vbits_from_mask(vm_not(paired));
    list->narrow[i / DAFT_VL] = vbits_from_mask(vi_eq(columns, unit)) != 0;
}

/* ---- texels ---- */

/* The texels of a row that each tap lies between. */
typedef struct tap_row {
    vi left, right;
} tap_row;

/* Lanes whose texels are of the other allocation read its first ones. */
static __attribute__((noinline)) tap_row read_both(const texture_levels *levels, const int32_t *at, vbits full)
{
    tap_row a, b;
    int32_t of_full[DAFT_VL], of_smaller[DAFT_VL];
    const vm mask = vm_from_bits(full);
    vi_store(of_full, vi_if_then_else(mask, vi_load(at), vi_set(0)));
    vi_store(of_smaller, vi_if_then_else(mask, vi_set(0), vi_load(at)));
    vi_gather_pairs(levels->full, of_full, &a.left, &a.right);
    vi_gather_pairs(levels->smaller, of_smaller, &b.left, &b.right);
    return (tap_row){vi_if_then_else(mask, a.left, b.left), vi_if_then_else(mask, a.right, b.right)};
}

/* Taps one by one. */
static __attribute__((noinline)) void read_apart(const texture_levels *levels, const tap_list *list, const int32_t *at,
                                                 uint32_t i, vbits lanes, tap_row *row)
{
    for (; lanes; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const bool full = list->full[i / DAFT_VL] >> lane & 1, split = list->split[i / DAFT_VL] >> lane & 1;
        const uint8_t *texel = (full ? levels->full : levels->smaller) + 4 * (size_t)at[lane];
        const size_t beside = split ? (size_t)list->width[i + (uint32_t)lane] - 1 : 1;
        int32_t first, second;
        memcpy(&first, texel, 4), memcpy(&second, texel + 4 * beside, 4);
        row->left[lane] = split ? second : first, row->right[lane] = split ? first : second;
    }
}

DAFT_INLINE tap_row read_row(const texture_levels *levels, const tap_list *list, int word, uint32_t i)
{
    const int32_t *at = (const int32_t *)(const void *)&list->word[word][i];
    const bool narrow = list->narrow[i / DAFT_VL];
    const vbits full = list->full[i / DAFT_VL], apart = narrow ? DAFT_ALL_LANES : list->split[i / DAFT_VL];
    tap_row row = {vi_set(0), vi_set(0)};
    if (!narrow) {
        if (full == 0 || full == DAFT_ALL_LANES)
            vi_gather_pairs(full ? levels->full : levels->smaller, at, &row.left, &row.right);
        else
            row = read_both(levels, at, full);
    }
    if (apart) read_apart(levels, list, at, i, apart, &row);
    return row;
}

DAFT_INLINE vf byte(vi texel, int channel)
{
    return vf_convert_to((texel >> (8 * channel)) & vi_set(255)) * vf_set(1.0f / 255);
}

DAFT_INLINE vf mix_four(vf a, vf b, vf c, vf d, vf across, vf down)
{
    vf top = a + (b - a) * across, bottom = c + (d - c) * across;
    return top + (bottom - top) * down;
}

/* Colours are in units of 1/65535. */
DAFT_INLINE void read_texels(tap_list *list, uint32_t i, const texture_levels *levels, bool linear)
{
    const tap_row above = read_row(levels, list, TAP_ABOVE, i), below = read_row(levels, list, TAP_BELOW, i);
    const vf across = vf_load(&list->word[TAP_ACROSS][i]), down = vf_load(&list->word[TAP_DOWN][i]);
    if (linear) {
        for (int k = 0; k < 4; k++)
            vf_store(&list->word[k][i], mix_four(byte(above.left, k), byte(above.right, k), byte(below.left, k),
                                                 byte(below.right, k), across, down));
    } else {
        vf a[3], b[3], c[3], d[3];
        vf_table_lookup_bytes(SRGB_TO_LINEAR_16, (const vi[2]){above.left, above.right}, a, b);
        vf_table_lookup_bytes(SRGB_TO_LINEAR_16, (const vi[2]){below.left, below.right}, c, d);
        for (int k = 0; k < 3; k++) vf_store(&list->word[k][i], mix_four(a[k], b[k], c[k], d[k], across, down));
    }
}

DAFT_INLINE void read_taps_as(tap_list *list, const texture_levels *levels, texture_use use)
{
    const uint32_t end = list->count; /* lanes past the end read what the last one reads, or beside it */
    vf_store(&list->word[TAP_U][end], vf_set(0.5f)), vf_store(&list->word[TAP_V][end], vf_set(0.5f));
    vf_store(&list->word[TAP_LEVEL][end], vf_set(list->word[TAP_LEVEL][end - 1]));
    if (use.edges) vi_store(&list->word[TAP_INSIDE][end], vi_set(0));
    for (uint32_t i = 0; i < end; i += DAFT_VL) place_taps(list, i, levels, use);
    for (uint32_t i = 0; i < end; i += DAFT_VL) read_texels(list, i, levels, use.linear);
}

static __attribute__((noinline)) void read_colors(tap_list *list, const texture_levels *levels, texture_use use)
{
    use.linear = false;
    read_taps_as(list, levels, use);
}

static __attribute__((noinline)) void read_bytes(tap_list *list, const texture_levels *levels, texture_use use)
{
    use.linear = true;
    read_taps_as(list, levels, use);
}

/* What all taps of the list find: red, green and blue as linear light in units of 1/65535; or all four bytes. */
DAFT_INLINE void read_taps(tap_list *list, const texture_levels *levels, texture_use use)
{
    if (list->count) (use.linear ? read_bytes : read_colors)(list, levels, use);
}

#endif
