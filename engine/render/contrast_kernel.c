/* Where a tile's picture changes from one pixel to the next: the pixels that are worth more samples. Two neighbours
 * disagree if one of their colours' bytes differs by more than a limit; bytes are steps that look even, dark or bright.
 * Whatever makes a pixel jagged shows in its bytes, be it an outline, a shadow, a crease or a mirror image, and what
 * does not show is worth no sample. (Contrast as the reason for more samples: Mitchell, "Generating Antialiased Images
 * at Low Sampling Densities", SIGGRAPH 1987.) */
#include "math/simd/ops.h"
#include "render/kernels.h"

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

/* DAFT_VL pixels of a row from (x, y) on. */
typedef struct pixels {
    vi red_blue, green, id;
} pixels;

DAFT_INLINE pixels pixels_at(const daft_neighbours *n, int x, int y)
{
    const vi bytes = vi_set(HALVES(255)), rgba = vi_load(n->pixel + 4 * (y * n->stride + x));
    return (pixels){rgba & bytes, rgba >> 8 & vi_set(255), vi_load(n->id + y * n->id_stride + x)};
}

typedef struct bits {
    uint32_t outline, inner;
} bits;

DAFT_INLINE bits disagree(const pixels *a, const pixels *b, const daft_contrast *limit)
{
    const vm same = vi_eq(a->id, b->id), instance = vi_eq(a->id >> DAFT_ID_INSTANCE, b->id >> DAFT_ID_INSTANCE);
    const vi most =
        vi_if_then_else(same, vi_set(HALVES(limit->inner)),
                        vi_if_then_else(instance, vi_set(HALVES(limit->crease)), vi_set(HALVES(limit->outline))));
    const vi far = beyond(a->red_blue, b->red_blue, most) | beyond(a->green, b->green, most);
    const vbits differ = ~vbits_from_mask(vi_eq(far, vi_set(0))) & DAFT_ALL_LANES;
    if (!differ) return (bits){0, 0};
    const vbits sky = vbits_from_mask(vi_eq(a->id, vi_set((int32_t)DAFT_ID_SKY))), inner = vbits_from_mask(same);
    return (bits){differ & ~inner, differ & inner & ~sky};
}

void DAFT_KERNEL(daft_find_contrast)(const daft_neighbours *n, const daft_contrast *limit, daft_edges *out)
{
    bits above = {0, 0}; /* of the row's pixels, those that disagree with the one above them */
    for (int y = -1; y < DAFT_TILE; y++) {
        bits down = {0, 0}, right = {0, 0}, left = {0, 0};
        for (int x = 0; x < DAFT_TILE; x += DAFT_VL) {
            const pixels here = pixels_at(n, x, y), below = pixels_at(n, x, y + 1);
            bits b = disagree(&here, &below, limit);
            down.outline |= b.outline << x, down.inner |= b.inner << x;
            if (y < 0) continue;
            const pixels beside = pixels_at(n, x + 1, y);
            b = disagree(&here, &beside, limit);
            right.outline |= b.outline << x, right.inner |= b.inner << x;
        }
        if (y >= 0) {
            const pixels before = pixels_at(n, -1, y), first = pixels_at(n, 0, y);
            left = disagree(&before, &first, limit);
            out->outline[y] = above.outline | down.outline | right.outline | right.outline << 1 | (left.outline & 1);
            out->inner[y] = above.inner | down.inner | right.inner | right.inner << 1 | (left.inner & 1);
        }
        above = down;
    }
}

void DAFT_KERNEL(daft_tile_ids)(const daft_tile *tile, uint32_t *ids, size_t stride)
{
    for (int y = 0; y < tile->height; y++, ids += stride)
        for (int x = 0; x < tile->width; x += DAFT_VL) {
            const int at = y * DAFT_TILE_STRIDE + x;
            const vi triangle = vi_load(&tile->triangle[at]) & vi_set((1 << DAFT_ID_INSTANCE) - 1);
            const vi id = vi_load(&tile->instance[at]) << DAFT_ID_INSTANCE | triangle;
            if (tile->width - x >= DAFT_VL)
                vi_store(&ids[x], id);
            else
                for (int i = 0; x + i < tile->width; i++) ids[x + i] = (uint32_t)id[i];
        }
}
