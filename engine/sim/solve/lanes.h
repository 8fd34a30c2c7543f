/* Vectors and bodies in lanes, for the solver's kernels. */
#ifndef DAFT_SIM_LANES_H
#define DAFT_SIM_LANES_H

#include "math/simd/ops.h"
#include "sim/solve/solver.h"

typedef struct body {
    vf3 v, w;
    vf rest[2]; /* of its row */
} body;

DAFT_INLINE vf3 vf3_add(vf3 a, vf3 b) { return (vf3){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE vf3 vf3_sub(vf3 a, vf3 b) { return (vf3){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE vf3 vf3_scale(vf3 a, vf s) { return (vf3){a.x * s, a.y * s, a.z * s}; }
DAFT_INLINE vf3 vf3_cross(vf3 a, vf3 b)
{
    return (vf3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DAFT_INLINE vf3 vf3_select(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_if_then_else(m, a.x, b.x), vf_if_then_else(m, a.y, b.y), vf_if_then_else(m, a.z, b.z)};
}
DAFT_INLINE vf3 load3(const daft_sim_lanes *p, int lane)
{
    return (vf3){vf_load(p[0] + lane), vf_load(p[1] + lane), vf_load(p[2] + lane)};
}
DAFT_INLINE void store3(daft_sim_lanes *p, int lane, vf3 v)
{
    vf_store(p[0] + lane, v.x);
    vf_store(p[1] + lane, v.y);
    vf_store(p[2] + lane, v.z);
}
/* 1 / x, and 0 for what has no inverse. */
DAFT_INLINE vf inverse(vf x)
{
    vm good = vf_lt(vf_set(0), x);
    return vf_if_then_else(good, vf_set(1) / vf_if_then_else(good, x, vf_set(1)), vf_set(0));
}
/* The factor that makes a vector of this squared length no longer than `limit`. */
DAFT_INLINE vf shorten(vf square, vf limit)
{
    vm longer = vf_lt(limit * limit, square);
    vf length = vf_sqrt(vf_if_then_else(longer, square, vf_set(1)));
    return vf_if_then_else(longer, limit / length, vf_set(1));
}
/* A symmetric matrix: xx, xy, xz, yy, yz, zz. */
DAFT_INLINE vf3 symmetric(const vf m[6], vf3 v)
{
    return (vf3){m[0] * v.x + m[1] * v.y + m[2] * v.z, m[1] * v.x + m[3] * v.y + m[4] * v.z,
                 m[2] * v.x + m[4] * v.y + m[5] * v.z};
}

typedef struct quat {
    vf x, y, z, w;
} quat;

DAFT_INLINE quat quat_mul(quat a, quat b)
{
    return (quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                  a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

DAFT_INLINE body load_body(const float *rows, const int32_t *index)
{
    vf row[8];
    vf_gather_rows8(rows, index, row);
    return (body){{row[0], row[1], row[2]}, {row[3], row[4], row[5]}, {row[6], row[7]}};
}
DAFT_INLINE void store_body(float *rows, const int32_t *index, const body *b, vbits lanes)
{
    if (!lanes) return;
    const vf row[8] = {b->v.x, b->v.y, b->v.z, b->w.x, b->w.y, b->w.z, b->rest[0], b->rest[1]};
    vf_scatter_rows8(rows, index, row, lanes);
}

#endif
