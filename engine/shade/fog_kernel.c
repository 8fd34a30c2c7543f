/* What light loses on its way, by Bouguer's law. Fog along rays: exp(-optical depth), of an air whose density falls
 * exponentially with height (Wenzel, "Real-time atmospheric effects in games", SIGGRAPH 2006 course). From the height
 * y, rising by k scale heights a metre, the optical depth of s metres is density(y) * (1 - exp(-k s)) / k. */
#include "shade/batch_lanes.h"

#define LOG2_E 1.44269504f
/* Optical depth beyond which nothing comes through: exp(-80) is far below any picture's step. */
#define MOST_DEPTH 80.0f
/* The same as a power of 1/2. */
#define MOST_LOSS 96.0f

DAFT_INLINE vf fog_exp(vf x)
{
    return vf_exp2(vf_min(vf_max(x, vf_set(-MOST_DEPTH)), vf_set(MOST_DEPTH)) * vf_set(LOG2_E));
}

/* (1 - exp(-x)) / x; by its series where the difference cancels, to 2e-6. */
DAFT_INLINE vf mean_along(vf x)
{
    const vf one = vf_set(1), small = one - x * vf_set(0.5f) + x * x * vf_set(1.0f / 6) - x * x * x * vf_set(1.0f / 24);
    return vf_if_then_else(vf_lt(vf_abs(x), vf_set(0.05f)), small, (one - fog_exp(vf_set(0) - x)) / x);
}

/* `rise`: of a unit direction. */
DAFT_INLINE vf optical_depth(const daft_air *air, vf height, vf rise, const float *length)
{
    const vf most = vf_set(MOST_DEPTH), zero = vf_set(0);
    const vf density = vf_set(air->density) * fog_exp((vf_set(air->base) - height) * vf_set(air->thinning));
    const vf k = rise * vf_set(air->thinning);
    if (!length) return vf_if_then_else(vf_lt(zero, k), vf_min(density / vf_max(k, vf_set(1e-30f)), most), most);
    const vf s = vf_min(vf_load(length), vf_set(1e30f)), depth = density * s * mean_along(k * s);
    return vf_min(vf_max(depth, zero), most);
}

void DAFT_KERNEL(daft_fog_way)(const daft_air *air, const daft_lanes3 *origin, const daft_lanes3 *direction,
                               const float *length, uint32_t first, uint32_t count, float *through, daft_lanes3 *own)
{
    const vf zero = vf_set(0), one = vf_set(1);
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        const vf3 d = lanes_load(direction, first + i);
        const vf length2 = vf3_dot(d, d), scale = vf_if_then_else(vf_lt(zero, length2), one / vf_sqrt(length2), zero);
        const vf height = origin ? vf_load(&origin->y[first + i]) : zero;
        const vf left = fog_exp(zero - optical_depth(air, height, d.y * scale, length ? &length[i] : NULL));
        vf3 color = {vf_set(air->color.x), vf_set(air->color.y), vf_set(air->color.z)};
        if (air->glow > 0) {
            const vf cosine =
                         vf3_dot(d, (vf3){vf_set(air->to_sun.x), vf_set(air->to_sun.y), vf_set(air->to_sun.z)}) * scale,
                     near = vf_clamp01(cosine), near2 = near * near, near4 = near2 * near2,
                     glow = near4 * near4 * vf_set(air->glow);
            color =
                (vf3){color.x + (vf_set(air->sun.x) - color.x) * glow, color.y + (vf_set(air->sun.y) - color.y) * glow,
                      color.z + (vf_set(air->sun.z) - color.z) * glow};
        }
        const vf lost = one - left;
        vf_store(&through[i], left);
        lanes_store(own, i, (vf3){color.x * lost, color.y * lost, color.z * lost});
    }
}

void DAFT_KERNEL(daft_fade)(daft_lanes3 *light, uint32_t first, uint32_t count, const daft_lanes3 *loss)
{
    float *const of[3] = {light->x + first, light->y + first, light->z + first};
    const float *const by[3] = {loss->x, loss->y, loss->z};
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        const vm some = vm_from_bits(vbits_first_n((int)(count - i)));
        for (int k = 0; k < 3; k++) {
            const vf all = vf_load(&of[k][i]), lost = vf_if_then_else(some, vf_load(&by[k][i]), vf_set(0));
            vf_store(&of[k][i], vf_if_then_else(vf_lt(lost, vf_set(MOST_LOSS)), all * vf_exp2(-lost), vf_set(0)));
        }
    }
}
