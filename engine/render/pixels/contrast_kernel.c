/* Where a tile's picture changes from one pixel to the next: the pixels that are worth more samples. Two neighbours
 * disagree if one of their colours' bytes differs by more than a limit; bytes are steps that look even, dark or bright.
 * Whatever makes a pixel jagged shows in its bytes, be it an outline, a shadow, a crease or a mirror image, and what
 * does not show is worth no sample. Nor is what a texture explains, which is filtered already: within a triangle, bytes
 * are compared as if both pixels had one own colour, where these are known. (Contrast as the reason for more samples:
 * Mitchell, "Generating Antialiased Images at Low Sampling Densities", SIGGRAPH 1987.) */
#include "math/simd/ops.h"
#include "render/kernels.h"

#include <string.h>

/* Two bytes in a word's halves, a limit in each. */
#define HALVES(x) ((int32_t)((uint32_t)(x)*0x00010001u))

/* Bits 12 or 13 of the halves in which a byte of a and one of b differ by more than the limit there. Bit 31 stays 0, so
 * that no sum overflows. */
DAFT_INLINE vi beyond(vi a, vi b, vi limit)
{
    vi gap = a - b + limit + vi_set(HALVES(0x1000)); /* 0x1000 to 0x1000 + 2 * limit: no more than the limit */
    vi above = gap + vi_set(HALVES(0x0fff)) - limit - limit;
    return (~gap & vi_set(HALVES(0x1000))) | (above & vi_set(HALVES(0x2000)));
}

/* DAFT_VL pixels of a row. */
typedef struct colors {
    vi red_blue, green;
} colors;
typedef struct pixels {
    colors color;
    vi id, own;
} pixels;

DAFT_INLINE pixels pixels_at(const daft_neighbours *n, int x, int y)
{
    const vi rgba = vi_load(n->pixel + 4 * (y * n->stride + x));
    return (pixels){{rgba & vi_set(HALVES(255)), rgba >> 8 & vi_set(255)},
                    vi_load(n->id + y * n->id_stride + x),
                    n->own ? vi_load(n->own + y * n->id_stride + x) : vi_set(-1)};
}

typedef struct bits {
    uint32_t outline, inner, strong, stark;
} bits;

DAFT_INLINE vbits apart(const colors *a, const colors *b, vi most)
{
    const vi far = beyond(a->red_blue, b->red_blue, most) | beyond(a->green, b->green, most);
    return ~vbits_from_mask(vi_eq(far, vi_set(0))) & DAFT_ALL_LANES;
}

/* Whether the light differs that two pixels of one surface get: what is left once both have the brighter one's own
 * colour. Bytes of sRGB are nearly powers of light, so that their ratios are those of powers. */
DAFT_INLINE vbits lit_apart(const pixels *a, const pixels *b, vi most)
{
    const vi byte = vi_set(255), zero = vi_set(0);
    const vi color[3][2] = {{a->color.red_blue & byte, b->color.red_blue & byte},
                            {a->color.green, b->color.green},
                            {a->color.red_blue >> 16, b->color.red_blue >> 16}};
    vbits far = 0;
    for (int k = 0; k < 3; k++) {
        const vi own = (a->own >> (8 * k)) & byte, other = (b->own >> (8 * k)) & byte;
        const vi gap = color[k][0] * other - color[k][1] * own,
                 limit = vi_if_then_else(vi_lt(own, other), other, own) * most;
        far |= vbits_from_mask(vm_or(vi_lt(limit, gap), vi_lt(limit, zero - gap)));
    }
    return far;
}

/* What both are; matte where they differ, or nothing is known, as of the sky. */
DAFT_INLINE vi kind_of(const pixels *a, const pixels *b)
{
    const vi byte = vi_set(255), sky = vi_set((int32_t)DAFT_ID_SKY), kind = a->own >> 24 & byte;
    const vm none = vm_or(vi_eq(a->id, sky), vi_eq(b->id, sky));
    const vm known = vm_and(vi_lt(kind, vi_set(DAFT_OWN_KINDS)), vi_eq(kind, b->own >> 24 & byte));
    return vi_if_then_else(vm_and(known, vm_not(none)), kind, vi_set(DAFT_OWN_MATTE));
}

/* By how much they may differ. */
DAFT_INLINE vi most_of(const pixels *a, const pixels *b, const daft_contrast *limit)
{
    const vm same = vi_eq(a->id, b->id), instance = vi_eq(a->id >> DAFT_ID_INSTANCE, b->id >> DAFT_ID_INSTANCE);
    const vi which = vi_if_then_else(same, vi_set(2), vi_if_then_else(instance, vi_set(1), vi_set(0)));
    return vi_gather_index(&limit->of[0].outline, kind_of(a, b) * vi_set(3) + which);
}

/* Out of line: few registers get here, and the search of the others is faster without it. */
static __attribute__((noinline)) bits disagree(const pixels *a, const pixels *b, const daft_contrast *limit)
{
    const vm same = vi_eq(a->id, b->id);
    const vi most = most_of(a, b, limit);
    const vbits differ = apart(&a->color, &b->color, most * vi_set(HALVES(1)));
    if (!differ) return (bits){0, 0, 0, 0};
    const vbits sky = vbits_from_mask(vi_eq(a->id, vi_set((int32_t)DAFT_ID_SKY))), alike = vbits_from_mask(same);
    vbits inner = differ & alike & ~sky;
    if (inner) inner &= lit_apart(a, b, most);
    bits out = {.outline = differ & ~alike, .inner = inner};
    if (inner) out.strong = inner & lit_apart(a, b, vi_set(limit->strong));
    if (out.strong) out.stark = inner & lit_apart(a, b, vi_set(limit->stark));
    if (out.outline) {
        out.strong |= out.outline & apart(&a->color, &b->color, vi_set(HALVES(limit->strong)));
        out.stark |= out.outline & apart(&a->color, &b->color, vi_set(HALVES(limit->stark)));
    }
    return out;
}

enum { AHEAD = 8 }; /* rows that are fetched before they are looked at: each lies pages from the one above */
typedef uint8_t bytes __attribute__((vector_size(DAFT_VL * 4), aligned(1), may_alias));

/* A search; `least`: of all limits. */
typedef struct search {
    const daft_neighbours *n;
    const daft_contrast *limit;
    uint8_t least;
} search;

DAFT_INLINE search begin(const daft_neighbours *n, const daft_contrast *limit)
{
    int least = limit->of[0].outline;
    for (int k = 0; k < DAFT_OWN_KINDS; k++) {
        const daft_contrast_limits *of = &limit->of[k];
        const int low = of->outline < of->crease ? of->outline : of->crease, own = of->inner < low ? of->inner : low;
        least = own < least ? own : least;
    }
    return (search){n, limit, (uint8_t)(least < 255 ? least : 255)};
}

/* Whether no byte of DAFT_VL pixels differs by more than the least limit: so it is with most. */
DAFT_INLINE bool all_near(const search *s, ptrdiff_t a, ptrdiff_t b)
{
    const bytes x = *(const bytes *)(s->n->pixel + 4 * a), y = *(const bytes *)(s->n->pixel + 4 * b);
    const bytes above = (bytes)(x > y), gap = ((x - y) & above) | ((y - x) & ~above);
    return !vbits_from_mask(vm_not(vi_eq((vi)(gap > s->least), vi_set(0))));
}

/* Of pixels (x, y) on, those that disagree with the ones `right` and `down` of them. */
DAFT_INLINE bits look(const search *s, int x, int y, int right, int down)
{
    const ptrdiff_t at = y * s->n->stride + x;
    if (all_near(s, at, at + down * s->n->stride + right)) return (bits){0, 0, 0, 0};
    const pixels here = pixels_at(s->n, x, y), there = pixels_at(s->n, x + right, y + down);
    return disagree(&here, &there, s->limit);
}

DAFT_INLINE void add(bits *to, bits b, int x)
{
    to->outline |= b.outline << x, to->inner |= b.inner << x;
    to->strong |= b.strong << x, to->stark |= b.stark << x;
}

void DAFT_KERNEL(daft_find_contrast)(const daft_neighbours *n, const daft_contrast *limit, daft_edges *out)
{
    const search s = begin(n, limit);
    bits above = {0, 0, 0, 0}; /* of the row's pixels, those that disagree with the one above them */
    for (int x = 0; x < DAFT_TILE; x += DAFT_VL) add(&above, look(&s, x, -1, 0, 1), x);
    for (int y = 0; y < DAFT_TILE; y++) {
        bits down = {0, 0, 0, 0}, right = {0, 0, 0, 0};
        if (y + AHEAD < DAFT_TILE) {
            const uint8_t *p = n->pixel + 4 * (y + AHEAD) * n->stride;
            __builtin_prefetch(p);
            __builtin_prefetch(p + 64);
            __builtin_prefetch(p + 128);
        }
        for (int x = 0; x < DAFT_TILE; x += DAFT_VL) {
            add(&down, look(&s, x, y, 0, 1), x);
            add(&right, look(&s, x, y, 1, 0), x);
        }
        const bits left = look(&s, -1, y, 1, 0);
        out->outline[y] = above.outline | down.outline | right.outline | right.outline << 1 | (left.outline & 1);
        out->inner[y] = above.inner | down.inner | right.inner | right.inner << 1 | (left.inner & 1);
        out->stark[y] = above.stark | down.stark | right.stark | right.stark << 1 | (left.stark & 1);
        out->strong[y] = above.strong | down.strong | right.strong | right.strong << 1 | (left.strong & 1);
        above = down;
    }
}

/* ---- corners of pixels ---- */

/* Pixels that disagree and see different things, which few do. */
DAFT_INLINE uint32_t differ(const daft_neighbours *n, const daft_contrast *limit, int x, int y, int right, int down)
{
    const uint32_t *id = n->id + y * n->id_stride + x;
    const vm same = vi_eq(vi_load(id), vi_load(id + down * n->id_stride + right));
    if (vbits_from_mask(same) == DAFT_ALL_LANES) return 0;
    const pixels here = pixels_at(n, x, y), there = pixels_at(n, x + right, y + down);
    return apart(&here.color, &there.color, most_of(&here, &there, limit) * vi_set(HALVES(1))) & ~vbits_from_mask(same);
}

void DAFT_KERNEL(daft_find_corners)(const daft_neighbours *n, const daft_contrast *limit, uint32_t out[DAFT_TILE])
{
    uint32_t across_above = 0;
    for (int y = -1; y < DAFT_TILE; y++) {
        uint32_t across = 0, down = 0;
        for (int x = 0; x < DAFT_TILE; x += DAFT_VL) {
            across |= differ(n, limit, x - 1, y, 1, 0) << x;
            if (y >= 0) down |= differ(n, limit, x, y - 1, 0, 1) << x;
        }
        if (y >= 0) out[y] = across_above | across | down | down << 1 | (differ(n, limit, -1, y - 1, 0, 1) & 1);
        across_above = across;
    }
}

/* Of DAFT_VL corners from (x, y) on, what the pixels around see, and their words. */
typedef struct four {
    vi id[4], word[4];
} four;

DAFT_INLINE four four_at(const daft_neighbours *n, int x, int y)
{
    four f;
    for (int k = 0; k < 4; k++) {
        const int row = y - 1 + (k >> 1), column = x - 1 + (k & 1);
        f.id[k] = vi_load(n->id + row * n->id_stride + column);
        f.word[k] = vi_load(n->pixel + 4 * (row * n->stride + column));
    }
    return f;
}

DAFT_INLINE vi ids_at(const daft_tile *tile, int at)
{
    const vi triangle = vi_load(&tile->triangle[at]) & vi_set((1 << DAFT_ID_INSTANCE) - 1);
    return vi_load(&tile->instance[at]) << DAFT_ID_INSTANCE | triangle;
}

/* A corner has the colour of a pixel that sees the same triangle or else the same instance. Gives the lanes without. */
DAFT_INLINE vbits match(const four *f, vi id, vi *word)
{
    vm exact[4], alike[4], any_exact = vi_eq(f->id[0], id), any = any_exact;
    for (int k = 0; k < 4; k++) {
        exact[k] = vi_eq(f->id[k], id), alike[k] = vi_eq(f->id[k] >> DAFT_ID_INSTANCE, id >> DAFT_ID_INSTANCE);
        any_exact = vm_or(any_exact, exact[k]), any = vm_or(any, alike[k]);
    }
    vi color = vi_set(0), same = vi_set(0);
    for (int k = 3; k >= 0; k--) {
        const vm sees = vm_or(exact[k], vm_and(alike[k], vm_not(any_exact)));
        color = vi_if_then_else(sees, f->word[k], color);
        same |= vi_if_then_else(sees, vi_set(1 << (DAFT_CORNER_SAME + k)), vi_set(0));
    }
    *word = (color & vi_set(0xffffff)) | same;
    return ~vbits_from_mask(any) & DAFT_ALL_LANES;
}

void DAFT_KERNEL(daft_match_corners)(const daft_neighbours *n, const daft_tile *tile, const uint32_t asked[DAFT_TILE],
                                     uint32_t *words, size_t stride, uint32_t fresh[DAFT_TILE])
{
    for (int y = 0; y < DAFT_TILE; y++) {
        fresh[y] = 0;
        for (int x = 0; x < DAFT_TILE; x += DAFT_VL) {
            const vbits lanes = (vbits)(asked[y] >> x) & DAFT_ALL_LANES;
            if (!lanes) continue;
            const four f = four_at(n, x, y);
            vi word;
            fresh[y] |= (uint32_t)(match(&f, ids_at(tile, y * DAFT_TILE_STRIDE + x), &word) & lanes) << x;
            vi_store(&words[(size_t)y * stride + (size_t)x], word);
        }
    }
}

void DAFT_KERNEL(daft_mix_corners)(const daft_tile *tile, const daft_corners *corners, const uint32_t *words,
                                   size_t stride, const uint8_t *rgba, size_t pixel_stride, daft_mixed *out)
{
    uint32_t count = 0;
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x += DAFT_VL) {
            const uint64_t upper = corners->asked[y] >> x, lower = corners->asked[y + 1] >> x;
            const uint64_t asked[4] = {lower >> 1, lower, upper >> 1, upper}; /* pixel i of a corner's four has it */
            const vbits inside = vbits_first_n(tile->width - x);
            vbits some = 0;
            if (!(((upper | lower) | (upper | lower) >> 1) & inside)) continue;
            int32_t own_words[DAFT_VL] = {0};
            const uint8_t *own_at = rgba + 4 * ((size_t)y * pixel_stride + (size_t)x);
            if (inside != DAFT_ALL_LANES) memcpy(own_words, own_at, 4 * (size_t)(tile->width - x));
            const vi own = vi_load(inside == DAFT_ALL_LANES ? (const void *)own_at : own_words);
            vi word[4];
            for (int k = 0; k < 4; k++) {
                const vi at = vi_load(&words[(size_t)(y + 1 - (k >> 1)) * stride + (size_t)(x + 1 - (k & 1))]);
                const vbits same = ~vbits_from_mask(vi_eq(at & vi_set(1 << (DAFT_CORNER_SAME + k)), vi_set(0)));
                const vbits other = (vbits)asked[k] & inside & ~same;
                word[k] = vi_if_then_else(vm_from_bits(other), at, own);
                some |= other;
            }
            if (!some) continue;
            vi_compress_store(&out->place[count], some, vi_iota() + vi_set(y * DAFT_TILE + x));
            vi_compress_store(&out->word[0][count], some, own);
            for (int k = 0; k < 4; k++) vi_compress_store(&out->word[k + 1][count], some, word[k]);
            count += (uint32_t)__builtin_popcount(some);
        }
    out->count = count;
}

void DAFT_KERNEL(daft_tile_ids)(const daft_tile *tile, uint32_t *ids, size_t stride)
{
    for (int y = 0; y < tile->height; y++, ids += stride)
        for (int x = 0; x < tile->width; x += DAFT_VL) {
            const int at = y * DAFT_TILE_STRIDE + x;
            const vi id = ids_at(tile, at);
            if (tile->width - x >= DAFT_VL)
                vi_store(&ids[x], id);
            else
                for (int i = 0; x + i < tile->width; i++) ids[x + i] = (uint32_t)id[i];
        }
}
