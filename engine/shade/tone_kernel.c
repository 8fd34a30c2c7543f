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

DAFT_INLINE vf agx_contrast(vf light)
{
    const vf stops = vf_log2(vf_max(light, vf_set(1e-10f)));
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
    const vf gamma = vf_set(2.2f); /* to linear light */
    return (vf3){vf_pow(vf_clamp01(v.x), gamma), vf_pow(vf_clamp01(v.y), gamma), vf_pow(vf_clamp01(v.z), gamma)};
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
