/* Each row of the target is a mix of the source's rows, and each of its pixels a mix of that row's: two pixels at a
 * time, a channel to a lane. */
#include "image/resize.h"
#include "math/simd/ops.h"

enum { TAPS = DAFT_RESIZE_TAPS, PAD = DAFT_RESIZE_PAD };

/* Of the four about a place, between the two in the middle: nothing rings. */
DAFT_INLINE v8 mix_wide(const v8 p[TAPS], const v8 weight[TAPS])
{
    const v8 sum = p[1] * weight[1] + p[2] * weight[2] + (p[0] * weight[0] + p[3] * weight[3]);
    return v8_min(v8_max(sum, v8_min(p[1], p[2])), v8_max(p[1], p[2]));
}

DAFT_INLINE v8 mix(const v8 p[TAPS], const v8 weight[TAPS], bool wide)
{
    return wide ? mix_wide(p, weight) : p[1] * weight[1] + p[2] * weight[2];
}

/* out: a row of pixels as floats, the first and the last repeated beyond the ends. */
DAFT_INLINE void mix_rows(const daft_image *from, const daft_resize_row *row, bool wide, float *out)
{
    const int count = 4 * from->width;
    float *middle = out + 4 * PAD;
    const uint8_t *source[TAPS];
    v8 weight[TAPS];
    for (int k = 0; k < TAPS; k++) {
        source[k] = from->pixels + (size_t)row->at[k] * (size_t)count;
        weight[k] = row->weight[k] - (v8){0};
    }
    for (int i = 0; i < count; i += 8) {
        const int at = i + 8 <= count || count < 8 ? i : count - 8; /* the last, of an odd width, once more */
        v8 p[TAPS];
        for (int k = 0; k < TAPS; k++) {
            if (!wide && (k == 0 || k == 3)) continue;
            p[k] = count < 8 ? v8_combine(v4_promote(source[k]), v4_promote(source[k])) : v8_promote(source[k] + at);
        }
        v8_store(middle + at, mix(p, weight, wide));
    }
    for (int i = 0; i < PAD; i++) {
        v4_store(out + 4 * i, v4_load(middle));
        v4_store(middle + count + 4 * i, v4_load(middle + count - 4));
    }
}

DAFT_INLINE void mix_pair(const daft_resize_pair *pair, bool wide, const float *row, uint8_t out[8])
{
    v8 p[TAPS], weight[TAPS];
    for (int k = wide ? 0 : 1; k < (wide ? 4 : 3); k++) {
        p[k] = v8_combine(v4_load(row + 4 * (pair->at[1] + k)), v4_load(row + 4 * (pair->at[0] + k)));
        weight[k] = v8_load(pair->weight[k]);
    }
    v8_demote(mix(p, weight, wide) + 0.5f, out);
}

DAFT_INLINE void enlarge(const daft_resize *r, int first, int end, bool wide, float *row)
{
    const int width = r->to->width;
    for (int y = first; y < end; y++) {
        uint8_t *out = r->to->pixels + (size_t)y * (size_t)width * 4, last[8];
        mix_rows(r->from, &r->rows[y], wide, row);
        for (int i = 0; i < width / 2; i++) mix_pair(&r->pairs[i], wide, row, out + 8 * i);
        if (width % 2 == 0) continue;
        mix_pair(&r->pairs[width / 2], wide, row, last);
        memcpy(out + 8 * (width / 2), last, 4);
    }
}

static void enlarge_rows(const daft_resize *r, int first, int end, float *row)
{
    if (r->wide)
        enlarge(r, first, end, true, row);
    else
        enlarge(r, first, end, false, row);
}

const daft_resize_kernels DAFT_KERNEL(daft_resize) = {.enlarge = enlarge_rows};
