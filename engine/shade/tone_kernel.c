/* Tone: exposure, and the curves by which light that is brighter than white is shown.
 *
 * ACES: Narkowicz, "ACES Filmic Tone Mapping Curve" (2015), a rational fit, here scaled so that middle grey stays 0.18.
 * AgX: Sobotka's view transform (2022) as Wrensch fits it ("Minimal AgX Implementation", 2023): primaries are drawn in,
 * log2 of light over 16.5 stops goes through a sigmoid of sixth degree, and primaries are drawn out again. */
#include "shade/batch_lanes.h"

#define ACES_SCALE 0.72317f   /* the fit of so much of 0.18 is 0.18 */
#define AGX_LEAST  -12.47393f /* stops from 1 */
#define AGX_MOST   4.026069f

DAFT_INLINE vf aces(vf x)
{
    x = x * vf_set(ACES_SCALE);
    return x * (vf_set(2.51f) * x + vf_set(0.03f)) / (x * (vf_set(2.43f) * x + vf_set(0.59f)) + vf_set(0.14f));
}

DAFT_INLINE vf3 times_matrix(const float m[9], vf3 v)
{
    return (vf3){vf_set(m[0]) * v.x + vf_set(m[1]) * v.y + vf_set(m[2]) * v.z,
                 vf_set(m[3]) * v.x + vf_set(m[4]) * v.y + vf_set(m[5]) * v.z,
                 vf_set(m[6]) * v.x + vf_set(m[7]) * v.y + vf_set(m[8]) * v.z};
}

/* 1..2 */
DAFT_INLINE vf mantissa_of(vf x) { return (vf)(((vi)x & vi_set(0x007fffff)) | vi_set(0x3f800000)); }

/* Good to 2.5e-6 of a stop, without a division; the polynomial is interpolated at Chebyshev nodes. */
DAFT_INLINE vf stops_of(vf x)
{
    const vf m = mantissa_of(x);
    vf s = vf_set(-0.0245685347f);
    s = s * m + vf_set(0.265024293f);
    s = s * m + vf_set(-1.22929101f);
    s = s * m + vf_set(3.21280029f);
    s = s * m + vf_set(-5.26168251f);
    s = s * m + vf_set(6.06687145f);
    return s * m + (vf_convert_to((vi)x >> 23) - vf_set(127 + 3.02915154f));
}

/* 2^(e · 2.2) by the last four bits of e + 127: e from -15 to 0. */
static const float OCTAVES[16] = {1.16415322e-10f, 5.34904355e-10f, 2.45777501e-09f, 1.12929684e-08f,
                                  5.18888571e-08f, 2.38418579e-07f, 1.09548412e-06f, 5.03352322e-06f,
                                  2.31279994e-05f, 0.000106268379f, 0.00048828125f,  0.00224355147f,
                                  0.0103086556f,   0.0473661427f,   0.217637641f,    1};

/* Shown values, up to 1, to linear light: to the power of 2.2, good to 5e-7 of it; none below 2^-15. m^2.2 on 1..2 is
 * interpolated at Chebyshev nodes. */
DAFT_INLINE vf linear_of(vf x)
{
    x = vf_clamp01(x);
    const vf m = mantissa_of(x);
    vf s = vf_set(0.00212627187f);
    s = s * m + vf_set(-0.0246777206f);
    s = s * m + vf_set(0.16383896f);
    s = s * m + vf_set(0.95563847f);
    s = s * m + vf_set(-0.114743453f);
    s = s * m + vf_set(0.0178178742f);
    return vf_if_then_else(vf_lt(x, vf_set(0x1p-15f)), vf_set(0), s * vf_table_lookup16(OCTAVES, (vi)x >> 23));
}

DAFT_INLINE vf agx_contrast(vf light)
{
    const vf stops = stops_of(vf_max(light, vf_set(1e-10f)));
    const vf x = vf_clamp01((stops - vf_set(AGX_LEAST)) * vf_set(1 / (AGX_MOST - AGX_LEAST)));
    vf s = vf_set(15.5f);
    s = s * x - vf_set(40.14f);
    s = s * x + vf_set(31.96f);
    s = s * x - vf_set(6.868f);
    s = s * x + vf_set(0.4298f);
    s = s * x + vf_set(0.1191f);
    return s * x - vf_set(0.00232f);
}

static vf3 agx(vf3 light)
{
    static const float IN[9] = {0.842479062f,  0.0784336f,   0.0792237451f, 0.0423282423f, 0.878468636f,
                                0.0791661275f, 0.042375655f, 0.0784336f,    0.879142974f};
    static const float OUT[9] = {1.19687901f,    -0.0980208811f, -0.0990297441f, -0.0528968518f, 1.15190313f,
                                 -0.0989611768f, -0.0529716355f, -0.0980434501f, 1.15107367f};
    vf3 v = times_matrix(IN, light);
    v = times_matrix(OUT, (vf3){agx_contrast(v.x), agx_contrast(v.y), agx_contrast(v.z)});
    return (vf3){linear_of(v.x), linear_of(v.y), linear_of(v.z)};
}

void DAFT_KERNEL(daft_tone_light)(const daft_tone *tone, const float *const light[3], uint32_t count,
                                  float *const out[3])
{
    const vf scale = vf_exp2(vf_set(tone->ev)), zero = vf_set(0), most = vf_set(1e9f);
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vf v[3];
        for (int k = 0; k < 3; k++) v[k] = vf_min(vf_max(vf_load(&light[k][i]) * scale, zero), most);
        if (tone->curve == DAFT_TONE_ACES)
            for (int k = 0; k < 3; k++) v[k] = aces(v[k]);
        if (tone->curve == DAFT_TONE_AGX) {
            const vf3 shown = agx((vf3){v[0], v[1], v[2]});
            v[0] = shown.x, v[1] = shown.y, v[2] = shown.z;
        }
        for (int k = 0; k < 3; k++) vf_store(&out[k][i], v[k]);
    }
}
