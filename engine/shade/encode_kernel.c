/* Encoding: linear light to sRGB bytes (IEC 61966-2-1), and back by table. A byte is floor(255·curve + 1/2), the curve
 * by vf_pow, which is good to 2^-21. A polynomial gives the same byte where its sum is not close to a whole number:
 * over all floats up to 1 the two sums differ by at most 1.7e-4. The few lanes that are closer than 2^-FINE, which is
 * more, are computed by vf_pow. */
#include "shade/batch_lanes.h"
#include "shade/srgb_table.h"

enum { FINE = 12, ONE = 1 << FINE }; /* fraction bits of a byte */

/* NaN becomes 0. */
static __attribute__((noinline)) vi encode_exactly(vf x)
{
    x = vf_clamp01(x);
    vf curve = vf_set(1.055f) * vf_pow(x, vf_set(1 / 2.4f)) - vf_set(0.055f);
    vf encoded = vf_if_then_else(vf_le(x, vf_set(0.0031308f)), x * vf_set(12.92f), curve);
    return vi_convert_to(encoded * vf_set(255) + vf_set(0.5f));
}

/* 255 · 1.055 · 2^(e · 5/12) by the last four bits of e + 127: e from -15 to 0, and those below are not on the curve.
 */
#define OCTAVE(x) ((x) * (float)ONE)
static const float OCTAVES[16] = {OCTAVE(3.53472122f), OCTAVE(4.71828676f), OCTAVE(6.29815721f), OCTAVE(8.40703125f),
                                  OCTAVE(11.2220404f), OCTAVE(14.9796267f), OCTAVE(19.9954028f), OCTAVE(26.6906605f),
                                  OCTAVE(35.6277574f), OCTAVE(47.5573505f), OCTAVE(63.4814467f), OCTAVE(84.7375651f),
                                  OCTAVE(113.111079f), OCTAVE(150.985176f), OCTAVE(201.541031f), OCTAVE(269.025f)};

/* m^(5/12) on 1..2, interpolated at Chebyshev nodes. */
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

/* Bytes with FINE fraction bits; `unsure`: the lanes whose byte is not certain. */
DAFT_INLINE vi encode_lanes(vf light, vbits *unsure)
{
    vf x = vf_clamp01(light);
    vf m = (vf)(((vi)x & vi_set(0x007fffff)) | vi_set(0x3f800000));
    vf curve = mantissa_power(m) * vf_table_lookup16(OCTAVES, (vi)x >> 23) - vf_set((255 * 0.055f - 0.5f) * (float)ONE);
    vf line = x * vf_set(12.92f) * vf_set(255 * (float)ONE) + vf_set(0.5f * (float)ONE);
    vi fine = vi_convert_to(vf_if_then_else(vf_le(x, vf_set(0.0031308f)), line, curve));
    *unsure = vbits_from_mask(vi_eq((fine + vi_set(1)) & vi_set(ONE - 2), vi_set(0)));
    return fine;
}

void DAFT_KERNEL(daft_encode)(const float *r, const float *g, const float *b, uint32_t count, uint8_t *rgba)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        const vf light[3] = {vf_load(&r[i]), vf_load(&g[i]), vf_load(&b[i])};
        vbits unsure[3];
        vi fine[3];
        for (int k = 0; k < 3; k++) fine[k] = encode_lanes(light[k], &unsure[k]);
        if (__builtin_expect((unsure[0] | unsure[1] | unsure[2]) != 0, 0)) {
            for (int k = 0; k < 3; k++)
                if (unsure[k]) fine[k] = encode_exactly(light[k]) << FINE;
        }
        vi bytes = fine[0] >> FINE | (fine[1] >> FINE) << 8 | (fine[2] >> FINE) << 16 | vi_set((int32_t)0xff000000);
        if (count - i >= DAFT_VL) {
            vi_store(rgba + 4 * (size_t)i, bytes);
            continue;
        }
        int32_t packed[DAFT_VL];
        vi_store(packed, bytes);
        memcpy(rgba + 4 * (size_t)i, packed, 4 * (size_t)(count - i));
    }
}

void DAFT_KERNEL(daft_decode)(const uint8_t *rgba, uint32_t count, float *r, float *g, float *b)
{
    for (uint32_t i = 0; i < count; i++, rgba += 4)
        r[i] = SRGB_TO_LINEAR[rgba[0]], g[i] = SRGB_TO_LINEAR[rgba[1]], b[i] = SRGB_TO_LINEAR[rgba[2]];
}
