/* The bounds of DAFT_VL instances of meshes: what daft_instance_bound does for one, operation for operation, so that
 * the bits are the same. For kernels. */
#ifndef DAFT_BOUND_LANES_H
#define DAFT_BOUND_LANES_H

#include "accel/bvh.h"
#include "accel/reach.h"
#include "math/simd/ops.h"

DAFT_INLINE vd vd_larger(vd a, vd b) { return vd_if_then_else((vl)(a > b), a, b); }

/* What is read of the meshes, by lane. */
typedef struct daft_bounded {
    const float *support[DAFT_VL];
    float low[3][DAFT_VL], high[3][DAFT_VL];
} daft_bounded;

/* Instances one after the other, all of meshes with a bvh. */
DAFT_INLINE void daft_bounded_read(const daft_instance *instances, daft_bounded *out)
{
    for (int i = 0; i < DAFT_VL; i++) {
        const daft_trimesh *mesh = instances[i].mesh;
        out->support[i] = instances[i].bvh->support;
        for (int k = 0; k < 3; k++)
            out->low[k][i] = daft_v3_at(mesh->low, k), out->high[k][i] = daft_v3_at(mesh->high, k);
    }
}

/* What is reached along a row of the map, and against it (reach.h); and the row's components by size, without their
 * signs. */
typedef struct daft_reaches {
    vf axis[2], face[2], octant[2], most, middle, least;
} daft_reaches;

static inline void daft_reaches_find(const daft_bounded *of, float (*row)[DAFT_VL], daft_reaches *out)
{
    const vf x = vf_load(row[0]), y = vf_load(row[1]), z = vf_load(row[2]), zero = vf_set(0);
    const vf a = vf_abs(x), b = vf_abs(y), c = vf_abs(z);
    vbits xy = vbits_from_mask(vf_le(b, a)), yz = vbits_from_mask(vf_le(c, b)), xz = vbits_from_mask(vf_le(c, a));
    vbits nx = vbits_from_mask(vf_lt(x, zero)), ny = vbits_from_mask(vf_lt(y, zero)),
          nz = vbits_from_mask(vf_lt(z, zero));
    float found[6][DAFT_VL];
    for (int i = 0; i < DAFT_VL; i++) {
        const uint8_t *order = DAFT_REACH_ORDER[(xy >> i & 1) | (yz >> i & 1) << 1 | (xz >> i & 1) << 2];
        uint32_t sign = (nx >> i & 1) | (ny >> i & 1) << 1 | (nz >> i & 1) << 2;
        const float *support = of->support[i];
        for (int end = 0; end < 2; end++, sign ^= 7) {
            found[end][i] = support[daft_reach_axis(order, sign)],
            found[2 + end][i] = support[daft_reach_face(order, sign)];
            found[4 + end][i] = support[daft_reach_octant(sign)];
        }
    }
    for (int end = 0; end < 2; end++) {
        out->axis[end] = vf_load(found[end]), out->face[end] = vf_load(found[2 + end]);
        out->octant[end] = vf_load(found[4 + end]);
    }
    out->most = vf_max(a, vf_max(b, c)), out->least = vf_min(a, vf_min(b, c));
    out->middle = vf_max(vf_min(a, b), vf_min(vf_max(a, b), c));
}

/* Half of the lanes along axis k, without slack; size: grows by the magnitudes. */
DAFT_INLINE void daft_bound_axis(const daft_bounded *of, float (*map)[DAFT_VL], int k, const daft_reaches *r, int h,
                                 vd *size, vd *low, vd *high)
{
    vd t = vd_promote_half(vf_load(map[9 + k]), h), centre = t, half = {0}, along[2];
    *size += vd_abs(t);
    for (int j = 0; j < 3; j++) {
        vd m = vd_promote_half(vf_load(map[3 * k + j]), h), l = vd_promote_half(vf_load(of->low[j]), h),
           u = vd_promote_half(vf_load(of->high[j]), h);
        centre += m * (l + u) * 0.5;
        half += vd_abs(m) * (u - l) * 0.5;
        *size += vd_abs(m) * vd_larger(vd_abs(l), vd_abs(u));
    }
    vd a = vd_promote_half(r->most, h), b = vd_promote_half(r->middle, h), c = vd_promote_half(r->least, h);
    for (int end = 0; end < 2; end++)
        along[end] = (a - b) * vd_promote_half(r->axis[end], h) + (b - c) * vd_promote_half(r->face[end], h) +
                     c * vd_promote_half(r->octant[end], h);
    vd ahead = t + along[0], behind = t - along[1];
    *high = vd_if_then_else((vl)(ahead < centre + half), ahead, centre + half);
    *low = vd_if_then_else((vl)(behind > centre - half), behind, centre - half);
}

/* map: m, then t of the maps that meshes are moved by. */
static inline void daft_bound_lanes(const daft_bounded *of, float (*map)[DAFT_VL], float (*low)[DAFT_VL],
                                    float (*high)[DAFT_VL])
{
    vd least[3][2], most[3][2], size[2] = {{0}, {0}};
    for (int k = 0; k < 3; k++) {
        daft_reaches r;
        daft_reaches_find(of, &map[3 * k], &r);
        for (int h = 0; h < 2; h++) daft_bound_axis(of, map, k, &r, h, &size[h], &least[k][h], &most[k][h]);
    }
    for (int h = 0; h < 2; h++) size[h] *= 0x1p-20 + 0x1p-23;
    for (int k = 0; k < 3; k++) {
        vf_store(low[k], vf_demote2(least[k][0] - size[0], least[k][1] - size[1]));
        vf_store(high[k], vf_demote2(most[k][0] + size[0], most[k][1] + size[1]));
    }
}

#endif
