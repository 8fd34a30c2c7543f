/* A ray against the four triangles of a block: the one test that decides for single rays, whatever tree led to the block.
 * For kernels, which compile it once for each instruction set.
 *
 * Triangles: with the corners a, b relative to the ray's origin, an edge's plane is (a - b) × (a + b) = 2·a × b, a - b being
 * taken from the corners as given. Exchanging a and b negates every bit of it, so the two triangles at an edge see opposite
 * values of one number (Davidovič et al., "3D rasterization", 2012; Woop et al., "Watertight Ray/Triangle Intersection",
 * 2013). That alone still loses rays at vertices, where rounding can put a ray on the same side of every spoke of a fan; so
 * lanes within the error bound are decided by the exact predicates: triangles are closed, and where a ray touches several
 * at one distance the lowest number is the hit. With S = |a| + |b| by component: a - b
 * rounds once; a + b is off by at most 2u·S; the products, their difference and the dot product with d round five times.
 * Together 8u·Σ |a - b|·S·|d| over the six products; the bound takes 9u of the product of the three sums of magnitudes,
 * which is larger and cheaper.
 *
 * Distances: the mean of the corners' along the ray, weighted by the sides, so they stay among them however flat the
 * triangle is seen. The corners' are off by 4u of Σ |p|·|d|, taking their mean by as much again; where that, or the sides'
 * errors, or what underflows (TINY), could move the mean by 2^-18 of itself, it is taken in double. */
#ifndef DAFT_BLOCK_TEST_H
#define DAFT_BLOCK_TEST_H

#include "accel/bvh.h"
#include "math/exact.h"
#include "math/simd.h"

#define TINY 1e-36f  /* over the sum of a few underflowing products */
#define SHORT 1e-30f /* squares of shorter directions underflow */

typedef struct v43 {
    v4 x, y, z;
} v43;

DAFT_INLINE v43 v43_sub(v43 a, v43 b) { return (v43){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE v43 v43_add(v43 a, v43 b) { return (v43){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE v43 v43_cross(v43 a, v43 b)
{
    return (v43){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DAFT_INLINE v4 v43_dot(v43 a, v43 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
DAFT_INLINE v43 v43_set(daft_vec3 a) { return (v43){v4_set(a.x), v4_set(a.y), v4_set(a.z)}; }
typedef struct block_hits {
    v4 t, v, w; /* distances; weights of corners 1 and 2 */
} block_hits;

DAFT_INLINE v43 v43_abs(v43 a) { return (v43){v4_abs(a.x), v4_abs(a.y), v4_abs(a.z)}; }
DAFT_INLINE v4 v43_sum(v43 a) { return a.x + a.y + a.z; }

DAFT_INLINE daft_vec3 block_lane(const daft_block *b, int k, int i)
{
    return daft_v3(b->corner[k][0][i], b->corner[k][1][i], b->corner[k][2][i]);
}

/* Lanes that floats could not decide, or measure: their bits if they hit, with distances and weights in double. */
static __attribute__((noinline, unused)) uint32_t block_exact(uint32_t unsure, const daft_block *b, daft_vec3 o, daft_vec3 d,
                                                      float tmin, float tmax, block_hits *out)
{
    uint32_t hits = 0;
    daft_dvec3 ray = daft_to_double(d), origin = daft_to_double(o);
    for (; unsure; unsure &= unsure - 1) {
        int i = __builtin_ctz(unsure);
        daft_vec3 c[3] = {block_lane(b, 0, i), block_lane(b, 1, i), block_lane(b, 2, i)};
        if (b->triangle[i] == DAFT_NO_TRIANGLE || !daft_line_touches(o, c[0], c[1], c[2], d)) continue;
        daft_dvec3 p[3];
        double w[3], along = 0;
        for (int k = 0; k < 3; k++) p[k] = daft_dsub(daft_to_double(c[k]), origin);
        daft_pencil_weights(p[0], p[1], p[2], d, w);
        for (int k = 0; k < 3; k++) along += w[k] * daft_ddot(p[k], ray);
        out->t[i] = (float)(along / daft_ddot(ray, ray)), out->v[i] = (float)w[1], out->w[i] = (float)w[2];
        hits |= (uint32_t)(out->t[i] >= tmin && out->t[i] <= tmax) << i;
    }
    return hits;
}

typedef struct block_mean {
    v4 inverse, along; /* one over the sides' sum; the corners' mean of p·d */
} block_mean;

/* Distances and weights from the sides. */
DAFT_INLINE block_mean block_measure(const v4 side[3], const v4 q[3], v4 dd, block_hits *out)
{
    v4 inverse = v4_set(1) / (side[0] + side[1] + side[2]);
    out->v = side[1] * inverse;
    out->w = side[2] * inverse;
    v4 along = side[0] * inverse * q[0] + out->v * q[1] + out->w * q[2];
    out->t = along / dd;
    return (block_mean){inverse, along};
}

/* The floats' word alone; `fast` takes the edges' planes as the corners come. */
DAFT_INLINE uint32_t block_test_floats(const daft_block *b, daft_vec3 o, daft_vec3 direction, float tmin, float tmax, bool fast,
                                       block_hits *out)
{
    v43 p[3], origin = v43_set(o), d = v43_set(direction);
    v4 side[3], q[3], zero = v4_set(0);
    for (int k = 0; k < 3; k++)
        p[k] = v43_sub((v43){v4_load(b->corner[k][0]), v4_load(b->corner[k][1]), v4_load(b->corner[k][2])}, origin);
    for (int k = 0; k < 3; k++) {
        v43 x = p[(k + 1) % 3], y = p[(k + 2) % 3];
        side[k] = v43_dot(fast ? v43_cross(x, y) : v43_cross(v43_sub(x, y), v43_add(x, y)), d);
    }
    v4 least = v4_min(v4_min(side[0], side[1]), side[2]), most = v4_max(v4_max(side[0], side[1]), side[2]);
    v4i in = (v4i)(least >= zero) | (v4i)(most <= zero);
    if (!v4_bits(in)) return 0;
    for (int k = 0; k < 3; k++) q[k] = v43_dot(p[k], d);
    block_measure(side, q, v43_dot(d, d), out);
    return v4_bits(in & (v4i)(out->t >= v4_set(tmin)) & (v4i)(out->t <= v4_set(tmax)));
}

/* Bits of the triangles hit in tmin..tmax. */
DAFT_INLINE uint32_t block_test(const daft_block *b, daft_vec3 o, daft_vec3 direction, float tmin, float tmax,
                                daft_intersection how, block_hits *out)
{
    if (how != DAFT_INTERSECT_EXACT)
        return block_test_floats(b, o, direction, tmin, tmax, how == DAFT_INTERSECT_FAST, out);
    v43 c[3], p[3], e[3], s[3], origin = v43_set(o), d = v43_set(direction);
    for (int k = 0; k < 3; k++) {
        c[k] = (v43){v4_load(b->corner[k][0]), v4_load(b->corner[k][1]), v4_load(b->corner[k][2])};
        p[k] = v43_sub(c[k], origin);
    }
    v4 side[3], size[3], reach[3] = {v43_sum(v43_abs(p[0])), v43_sum(v43_abs(p[1])), v43_sum(v43_abs(p[2]))};
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        e[k] = v43_sub(c[i], c[j]);
        s[k] = v43_add(p[i], p[j]);
        side[k] = v43_dot(v43_cross(e[k], s[k]), d);
        size[k] = v43_sum(v43_abs(e[k])) * (reach[i] + reach[j]);
    }
    v4 least = v4_min(v4_min(side[0], side[1]), side[2]), most = v4_max(v4_max(side[0], side[1]), side[2]);
    v4 speed = v43_sum(v43_abs(d)), bound = v4_max(v4_max(size[0], size[1]), size[2]) * (speed * v4_set(9 * 0x1p-24f)) + v4_set(TINY);
    /* a side that overflowed may be of the wrong sign; written so that a NaN is neither outside nor sure */
    v4i outside = (v4i)(least < -bound) & (v4i)(most > bound) & (v4i)(bound < v4_set(9 * 0x1p-24f * 1e38f));
    uint32_t maybe = v4_bits(~outside);
    if (!maybe) return 0;
    v4 q[3] = {v43_dot(p[0], d), v43_dot(p[1], d), v43_dot(p[2], d)};
    v4 range = v4_max(v4_max(q[0], q[1]), q[2]) - v4_min(v4_min(q[0], q[1]), q[2]), dd = v43_dot(d, d);
    block_mean mean = block_measure(side, q, dd, out);
    v4 doubt = v4_set(3) * bound * range * v4_abs(mean.inverse) + v4_set(TINY) +
               v4_max(v4_max(reach[0], reach[1]), reach[2]) * (speed * v4_set(8 * 0x1p-24f));
    v4i sure = ((v4i)(least > bound) | (v4i)(most < -bound)) & (v4i)(doubt < v4_abs(mean.along) * v4_set(0x1p-18f)) & (v4i)(dd > v4_set(SHORT));
    uint32_t hits = v4_bits(sure & (v4i)(out->t >= v4_set(tmin)) & (v4i)(out->t <= v4_set(tmax)));
    uint32_t unsure = maybe & ~v4_bits(sure);
    if (unsure) hits |= block_exact(unsure, b, o, direction, tmin, tmax, out);
    return hits;
}

DAFT_INLINE float unit(float s) { return s > 0 ? (s < 1 ? s : 1) : 0; }

DAFT_INLINE void take_hits(const daft_block *b, uint32_t bits, const block_hits *h, daft_hit *hit)
{
    while (bits) {
        int i = __builtin_ctz(bits);
        bits &= bits - 1;
        bool nearer = h->t[i] < hit->t || (h->t[i] == hit->t && b->triangle[i] < hit->triangle);
        if (!nearer) continue;
        hit->t = h->t[i], hit->u = unit(h->v[i]), hit->v = unit(h->w[i]), hit->triangle = b->triangle[i];
    }
}

#endif
