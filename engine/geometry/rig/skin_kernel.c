/* Linear blend skinning in lanes: each point is moved by the weighted sum of its joints' matrices (Magnenat-Thalmann,
 * Laperriere, Thalmann, "Joint-Dependent Local Deformations", 1988), normals by that sum's cofactors. A block of points
 * takes as many matrices as the one of them that has most, so that what hangs on one joint costs one. */
#include "geometry/rig/skin.h"
#include "math/simd/ops.h"

/* Of DAFT_VL points from `at` on: three rows of four. */
DAFT_INLINE void blend(const daft_rig_points *points, const float *matrices, size_t at, vf m[12])
{
    const int used = points->most[at / DAFT_RIG_BLOCK];
    for (int i = 0; i < 12; i++) m[i] = vf_set(0);
    for (int k = 0; k < used; k++) {
        const vf weight = vf_load(&points->weights[k][at]);
        const float *row[DAFT_VL];
        for (int i = 0; i < DAFT_VL; i++) row[i] = matrices + 12 * (size_t)points->joints[k][at + (size_t)i];
        for (int part = 0; part < 3; part++) {
            vf four[4];
            vf_gather_rows4(row, 4 * part, four);
            for (int i = 0; i < 4; i++) m[4 * part + i] = m[4 * part + i] + weight * four[i];
        }
    }
}

DAFT_INLINE vf finite_or_zero(vf a) { return vf_if_then_else(vf_le(vf_abs(a), vf_set(3e38f)), a, vf_set(0)); }

static void move_vertices(const daft_rig_points *points, const float *matrices, float *x, float *y, float *z)
{
    for (size_t at = 0; at < points->count; at += DAFT_VL) {
        vf m[12];
        blend(points, matrices, at, m);
        const vf px = vf_load(&points->x[at]), py = vf_load(&points->y[at]), pz = vf_load(&points->z[at]);
        float *const out[3] = {&x[at], &y[at], &z[at]};
        for (int row = 0; row < 3; row++) {
            const vf *r = &m[4 * row];
            vf_store(out[row], finite_or_zero(((r[0] * px + r[1] * py) + r[2] * pz) + r[3]));
        }
    }
}

/* The cofactors of the linear part, with the determinant's sign taken out: a mirrored part's normals look outwards. */
DAFT_INLINE void cofactors(const vf m[12], vf c[9])
{
    c[0] = m[5] * m[10] - m[6] * m[9], c[1] = m[6] * m[8] - m[4] * m[10], c[2] = m[4] * m[9] - m[5] * m[8];
    c[3] = m[2] * m[9] - m[1] * m[10], c[4] = m[0] * m[10] - m[2] * m[8], c[5] = m[1] * m[8] - m[0] * m[9];
    c[6] = m[1] * m[6] - m[2] * m[5], c[7] = m[2] * m[4] - m[0] * m[6], c[8] = m[0] * m[5] - m[1] * m[4];
    const vf determinant = (m[0] * c[0] + m[1] * c[1]) + m[2] * c[2];
    const vi sign = (vi)determinant & vi_set((int32_t)0x80000000);
    for (int i = 0; i < 9; i++) c[i] = vf_xor(c[i], sign);
}

/* Scaled to a largest component of 1 first, so that no square is too small or too large. */
DAFT_INLINE void unit(vf *x, vf *y, vf *z)
{
    const vf largest = vf_max(vf_max_abs(*x, *y), vf_abs(*z));
    const vm good = vm_and(vf_lt(vf_set(0), largest), vf_le(largest, vf_set(3e38f)));
    const vf scale = vf_if_then_else(good, largest, vf_set(1));
    const vf a = *x / scale, b = *y / scale, c = *z / scale, length = vf_sqrt((a * a + b * b) + c * c);
    *x = vf_if_then_else(good, a / length, vf_set(0));
    *y = vf_if_then_else(good, b / length, vf_set(1));
    *z = vf_if_then_else(good, c / length, vf_set(0));
}

static void move_normals(const daft_rig_points *points, const float *matrices, daft_vec3 *out)
{
    for (size_t at = 0; at < points->count; at += DAFT_VL) {
        vf m[12], c[9];
        float lanes[3][DAFT_VL];
        blend(points, matrices, at, m);
        cofactors(m, c);
        const vf nx = vf_load(&points->x[at]), ny = vf_load(&points->y[at]), nz = vf_load(&points->z[at]);
        vf x = (c[0] * nx + c[1] * ny) + c[2] * nz, y = (c[3] * nx + c[4] * ny) + c[5] * nz,
           z = (c[6] * nx + c[7] * ny) + c[8] * nz;
        unit(&x, &y, &z);
        vf_store(lanes[0], x), vf_store(lanes[1], y), vf_store(lanes[2], z);
        for (size_t i = 0; i < DAFT_VL && at + i < points->count; i++)
            out[at + i] = (daft_vec3){lanes[0][i], lanes[1][i], lanes[2][i]};
    }
}

const daft_rig_kernels DAFT_KERNEL(daft_rig) = {move_vertices, move_normals};
