/* The way out: linear light to sRGB bytes (IEC 61966-2-1). The byte is the curve's, by powers that are good to some 2^-21,
 * plus a half and rounded down. Where that sum is not close to a whole number, a polynomial that is off by less than UNSURE
 * says the same; the few other lanes take the powers themselves. */
#include "shade/parts.h"

#define UNSURE 0x1p-12f /* over what the two sums differ by at most, 1.7e-4, as found for each float up to 1 */

/* NaN becomes 0. */
static __attribute__((noinline)) vi encode_exactly(vf x)
{
    x = vf_clamp01(x);
    vf curve = vf_set(1.055f) * vf_pow(x, vf_set(1 / 2.4f)) - vf_set(0.055f);
    vf encoded = vf_select(vf_le(x, vf_set(0.0031308f)), x * vf_set(12.92f), curve);
    return vi_truncate(encoded * vf_set(255) + vf_set(0.5f));
}

/* 255 · 1.055 · 2^(e · 5/12) by the last four bits of e + 127: e from -15 to 0, and those below are not on the curve. */
static const float OCTAVE[16] = {3.53472122f, 4.71828676f, 6.29815721f, 8.40703125f, 11.2220404f, 14.9796267f,
                                 19.9954028f, 26.6906605f, 35.6277574f, 47.5573505f, 63.4814467f, 84.7375651f,
                                 113.111079f, 150.985176f, 201.541031f, 269.025f};

/* m^(5/12) on 1..2, interpolated at Chebyshev's places. */
DAFT_INLINE vf mantissa_power(vf m)
{
    vf s = vf_set(-0.00269152573f);
    s = s * m + vf_set(0.029459171f);
    s = s * m + vf_set(-0.139750138f);
    s = s * m + vf_set(0.37977156f);
    s = s * m + vf_set(-0.676159263f);
    s = s * m + vf_set(1.05750036f);
    return s * m + vf_set(0.351870149f);
}

DAFT_INLINE vi encode_lanes(vf light)
{
    vf x = vf_clamp01(light), half = vf_set(0.5f);
    vf m = (vf)(((vi)x & vi_set(0x007fffff)) | vi_set(0x3f800000));
    vf curve = mantissa_power(m) * vf_lookup16(OCTAVE, (vi)x >> 23) - vf_set(255 * 0.055f - 0.5f);
    vf line = x * vf_set(12.92f) * vf_set(255) + half;
    vf value = vf_select(vf_le(x, vf_set(0.0031308f)), line, curve);
    vi byte = vi_truncate(value);
    vf off = vf_abs(value - vf_from_int(byte) - half);
    if (__builtin_expect(vm_bits(vf_lt(vf_set(0.5f - UNSURE), off)) != 0, 0)) return encode_exactly(light);
    return byte;
}

void DAFT_KERNEL(daft_encode)(const float *r, const float *g, const float *b, uint32_t count, uint8_t *rgba)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vi bytes = encode_lanes(vf_load(&r[i])) | encode_lanes(vf_load(&g[i])) << 8 | encode_lanes(vf_load(&b[i])) << 16 |
                   vi_set((int32_t)0xff000000);
        if (count - i >= DAFT_VL) {
            vi_store(rgba + 4 * (size_t)i, bytes);
            continue;
        }
        int32_t packed[DAFT_VL];
        vi_store(packed, bytes);
        memcpy(rgba + 4 * (size_t)i, packed, 4 * (size_t)(count - i));
    }
}
