/* math: vectors, matrices, quaternions (vec.h); SIMD lanes (simd/ops.h) and functions over them (simd/elementary.h);
 * which instruction set runs (simd/dispatch.h); exact predicates (exact.h); functions whose bits do not depend on the
 * system's libm (trig.h); eigenvectors (jacobi.h). Promises: every result is the same on every machine, compiler,
 * instruction set and build type. Public headers: vec.h exact.h trig.h jacobi.h simd/ops.h simd/elementary.h
 * simd/dispatch.h */
#ifndef DAFT_VEC_H
#define DAFT_VEC_H

#include "daft.h"

#include <math.h>

#define DAFT_PI 3.14159265358979323846

/* ---- vectors of floats ---- */

static inline daft_vec3 daft_v3(float x, float y, float z) { return (daft_vec3){x, y, z}; }
static inline daft_vec3 daft_add(daft_vec3 a, daft_vec3 b) { return daft_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline daft_vec3 daft_sub(daft_vec3 a, daft_vec3 b) { return daft_v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline daft_vec3 daft_mul(daft_vec3 a, daft_vec3 b) { return daft_v3(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline daft_vec3 daft_scale(daft_vec3 a, float s) { return daft_v3(a.x * s, a.y * s, a.z * s); }
static inline daft_vec3 daft_neg(daft_vec3 a) { return daft_v3(-a.x, -a.y, -a.z); }
static inline float daft_dot(daft_vec3 a, daft_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline daft_vec3 daft_cross(daft_vec3 a, daft_vec3 b)
{
    return daft_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
/* Component k of a vector: 0 is x, 1 y, 2 z. */
static inline float daft_v3_at(daft_vec3 v, int k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }
static inline void daft_v3_put(daft_vec3 *v, int k, float s) { *(k == 0 ? &v->x : k == 1 ? &v->y : &v->z) = s; }
static inline float daft_length(daft_vec3 a) { return sqrtf(daft_dot(a, a)); }
/* Zero stays zero. */
static inline daft_vec3 daft_normalize(daft_vec3 a)
{
    float length = daft_length(a);
    return length > 0 ? daft_scale(a, 1 / length) : a;
}
static inline daft_vec3 daft_min3(daft_vec3 a, daft_vec3 b)
{
    return daft_v3(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}
static inline daft_vec3 daft_max3(daft_vec3 a, daft_vec3 b)
{
    return daft_v3(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}
static inline bool daft_finite3(daft_vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }

/* ---- vectors of doubles ---- */

static inline daft_dvec3 daft_dv3(double x, double y, double z) { return (daft_dvec3){x, y, z}; }
static inline daft_dvec3 daft_dadd(daft_dvec3 a, daft_dvec3 b) { return daft_dv3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline daft_dvec3 daft_dsub(daft_dvec3 a, daft_dvec3 b) { return daft_dv3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline daft_dvec3 daft_dscale(daft_dvec3 a, double s) { return daft_dv3(a.x * s, a.y * s, a.z * s); }
static inline double daft_ddot(daft_dvec3 a, daft_dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline daft_dvec3 daft_dcross(daft_dvec3 a, daft_dvec3 b)
{
    return daft_dv3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline daft_dvec3 daft_to_double(daft_vec3 a) { return daft_dv3((double)a.x, (double)a.y, (double)a.z); }
static inline double daft_dv3_at(daft_dvec3 v, int k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }
static inline daft_vec3 daft_to_float(daft_dvec3 a) { return daft_v3((float)a.x, (float)a.y, (float)a.z); }
static inline bool daft_dfinite3(daft_dvec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }

/* An affine map: row-major 3×3 part m, then the translation t. */
typedef struct daft_affine {
    float m[9];
    float t[3];
} daft_affine;

/* The one order of operations in which vertices are moved: every kernel and the reference path get the same bits. */
static inline daft_vec3 daft_affine_point(const daft_affine *a, daft_vec3 p)
{
    return daft_v3(((a->m[0] * p.x + a->m[1] * p.y) + a->m[2] * p.z) + a->t[0],
                   ((a->m[3] * p.x + a->m[4] * p.y) + a->m[5] * p.z) + a->t[1],
                   ((a->m[6] * p.x + a->m[7] * p.y) + a->m[8] * p.z) + a->t[2]);
}
static inline daft_vec3 daft_affine_vector(const daft_affine *a, daft_vec3 v)
{
    return daft_v3((a->m[0] * v.x + a->m[1] * v.y) + a->m[2] * v.z, (a->m[3] * v.x + a->m[4] * v.y) + a->m[5] * v.z,
                   (a->m[6] * v.x + a->m[7] * v.y) + a->m[8] * v.z);
}
/* The transpose of the linear part: with the inverse of a map it carries normals. */
static inline daft_vec3 daft_affine_transposed(const daft_affine *a, daft_vec3 v)
{
    return daft_v3((a->m[0] * v.x + a->m[3] * v.y) + a->m[6] * v.z, (a->m[1] * v.x + a->m[4] * v.y) + a->m[7] * v.z,
                   (a->m[2] * v.x + a->m[5] * v.y) + a->m[8] * v.z);
}

/* A box that stands askew: products of the axes and the way from the middle are -1 to 1 within. */
typedef struct daft_slanted_box {
    daft_vec3 middle, axes[3];
} daft_slanted_box;

/* ---- rotations: unit quaternions, w real ---- */

static inline daft_quat daft_quat_identity(void) { return (daft_quat){0, 0, 0, 1}; }
static inline daft_quat daft_quat_mul(daft_quat a, daft_quat b)
{
    return (daft_quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                       a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
static inline daft_quat daft_quat_normalize(daft_quat q)
{
    float length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    if (!(length > 0)) return daft_quat_identity();
    float s = 1 / length;
    return (daft_quat){q.x * s, q.y * s, q.z * s, q.w * s};
}
static inline daft_vec3 daft_quat_rotate(daft_quat q, daft_vec3 v)
{
    daft_vec3 u = daft_v3(q.x, q.y, q.z);
    daft_vec3 t = daft_scale(daft_cross(u, v), 2);
    return daft_add(v, daft_add(daft_scale(t, q.w), daft_cross(u, t)));
}
/* Row-major rotation matrix of a unit quaternion, in double so that composed maps are rounded once. */
static inline void daft_quat_matrix(daft_quat q, double m[9])
{
    double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = (double)q.w;
    m[0] = 1 - 2 * (y * y + z * z), m[1] = 2 * (x * y - z * w), m[2] = 2 * (x * z + y * w);
    m[3] = 2 * (x * y + z * w), m[4] = 1 - 2 * (x * x + z * z), m[5] = 2 * (y * z - x * w);
    m[6] = 2 * (x * z - y * w), m[7] = 2 * (y * z + x * w), m[8] = 1 - 2 * (x * x + y * y);
}
/* Normalised linear interpolation along the shorter arc. */
static inline daft_quat daft_quat_nlerp(daft_quat a, daft_quat b, float t)
{
    float sign = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w < 0 ? -1.0f : 1.0f;
    float u = 1 - t, v = t * sign;
    return daft_quat_normalize((daft_quat){a.x * u + b.x * v, a.y * u + b.y * v, a.z * u + b.z * v, a.w * u + b.w * v});
}

#endif
