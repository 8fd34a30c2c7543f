/* How rays meet boxes and triangles, in lanes: for the kernels of single rays, whatever tree they go through, where lanes are
 * triangles, and of packets, where lanes are rays.
 *
 * Boxes: slab test. A zero component's inverse is infinite: planes then lie at plus or minus infinity, and the NaN of a ray
 * within a plane loses every comparison, so that plane says nothing, which is right. The far distance is widened (Ize,
 * "Robust BVH Ray Traversal", 2013), so rounding never misses a box: with u = 2^-24, a difference, an inverse and a product
 * move each distance by 3u, and the product that widens the far inverse by u: 7u to first order, and 8u is taken.
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
 * Most triangles are missed by far. A filter turns them away first, by half the work: with a corner s relative to the
 * origin and two edges e, f from it, the sides are triple products of s, d and an edge (Möller and Trumbore, "Fast, Minimum
 * Storage Ray/Triangle Intersection", 1997), the third what is left of their sum, d·(e × f). It only says "missed" where its
 * own error bound allows no other answer, so who passes it and who does not leaves no trace in the result. s, e and f round
 * once, each product in a triple product twice, then one difference and two sums: a side is off by 7u of the sum of the six
 * products' magnitudes, 14u·|s|·|e|·D, with |.| the largest component of s or e and D the sum of those of d; the sum of the
 * sides by 14u·|e|·|f|·D, the third side by all three and 2u of them. Together less than 22u·D·(|s|·(|e| + |f|) + |e|·|f|).
 * Where it is sure, s·(e × f), off by 8u·|s|·6·|e|·|f|, says whether the
 * triangle is behind, or further than a hit.
 *
 * Distances: the mean of the corners' along the ray, weighted by the sides, so they stay among them however flat the
 * triangle is seen. The corners' are off by 4u of Σ |p|·|d|, taking their mean by as much again; where that, or the sides'
 * errors, or what underflows (TINY), could move the mean by 2^-18 of itself, it is taken in double.
 *
 * Order: a box is only passed by when it lies 2^-17 behind the nearest hit or before tmin, so more than distances are off.
 * The hit is thus the nearest of all triangles touched, by distance, instance and number, however and with whomever the ray
 * travelled: bit for bit the same from every kernel. */
#ifndef DAFT_RAY_TEST_H
#define DAFT_RAY_TEST_H

#include "accel/bvh.h"
#include "math/exact.h"
#include "math/isa.h"
#include "math/simd.h"

#define DAFT_ULP 0x1p-24f /* u: half a unit in the last place of 1 */
#define DAFT_TINY 1e-36f  /* over the sum of a few underflowing products */
#define DAFT_SHORT 1e-30f /* squares of shorter directions underflow */

/* The limits of boxes: further out than the ray's own by more than distances are off. */
DAFT_INLINE float daft_past(float t) { return t > 0 ? t * (1 + 0x1p-17f) : t * (1 - 0x1p-17f); }
DAFT_INLINE float daft_before(float t) { return -daft_past(-t); }

DAFT_INLINE daft_vec3 daft_block_corner(const daft_block *b, int corner, uint32_t i)
{
    return daft_v3(b->corner[corner][0][i], b->corner[corner][1][i], b->corner[corner][2][i]);
}

/* ---- triangles ---- */

DAFT_INLINE vf3 vf3_set(daft_vec3 a) { return (vf3){vf_set(a.x), vf_set(a.y), vf_set(a.z)}; }
DAFT_INLINE vf3 vf3_sub(vf3 a, vf3 b) { return (vf3){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE vf3 vf3_add(vf3 a, vf3 b) { return (vf3){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE vf3 vf3_cross(vf3 a, vf3 b)
{
    return (vf3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DAFT_INLINE vf vf3_magnitude(vf3 a) { return vf_abs(a.x) + vf_abs(a.y) + vf_abs(a.z); }
DAFT_INLINE vf vf_min3(vf a, vf b, vf c) { return vf_min(vf_min(a, b), c); }
DAFT_INLINE vf vf_max3(vf a, vf b, vf c) { return vf_max(vf_max(a, b), c); }

/* The filter's error terms for a direction: per size of the triangle and its way from the ray, and how far behind a triangle
 * must be; -inf where negative distances count, too. Between directions of 2^±26 and for products of sizes below FILTER_MOST
 * nothing overflows; what is beyond passes. */
typedef struct daft_filter {
    float scale, floor;
} daft_filter;

#define DAFT_FILTER_MOST 1e24f
#define DAFT_FILTER_SIZE 1e-18f /* added to sizes, so that errors are over what underflows in them */

DAFT_INLINE daft_filter daft_filter_of(daft_vec3 d, float tmin)
{
    float size = fabsf(d.x) + fabsf(d.y) + fabsf(d.z), scale = size > 0x1p-26f && size < 0x1p26f ? 22 * DAFT_ULP * size : INFINITY;
    return (daft_filter){scale, tmin >= 0 ? -DAFT_TINY : -INFINITY};
}

/* A triangle's edges from corner 0, one of them the other way round, and their cross product; the sum and the product of
 * the edges' sizes. */
typedef struct daft_facet {
    vf3 corner, a, b, normal;
    vf sizes, area;
} daft_facet;

DAFT_INLINE vf vf3_largest(vf3 a) { return vf_most_of(vf_most_of(a.x, a.y), a.z); }

DAFT_INLINE daft_facet daft_facet_of(const vf3 c[3])
{
    vf3 a = vf3_sub(c[0], c[1]), b = vf3_sub(c[2], c[0]);
    vf along = vf3_largest(a) + vf_set(DAFT_FILTER_SIZE), across = vf3_largest(b) + vf_set(DAFT_FILTER_SIZE);
    return (daft_facet){c[0], a, b, vf3_cross(b, a), along + across, along * across};
}

/* The lanes that may be hit before `past`, daft_past of a distance that is 0 or more. NaN passes. A ray that leaves a surface
 * has its triangle right behind it, so looking there turns away one in every ray. */
DAFT_INLINE vbits daft_filter_pass(const daft_facet *f, vf3 o, vf3 d, vf scale, vf floor, vf past)
{
    vf3 s = vf3_sub(f->corner, o), r = vf3_cross(s, d);
    vf u = vf3_dot(f->b, r), v = vf3_dot(f->a, r), sum = vf3_dot(f->normal, d), w = sum - u - v;
    vf reach = vf3_largest(s), size = reach * f->sizes + f->area, bound = size * scale + vf_set(DAFT_TINY);
    vm outside = vm_and(vf_lt(vf_min3(u, v, w), -bound), vf_lt(bound, vf_max3(u, v, w)));
    vf along = vf_xor_sign(vf3_dot(s, f->normal), (vi)sum & vi_set(INT32_MIN)), off = reach * f->area * vf_set(49 * DAFT_ULP);
    vm before = vf_lt(along, floor - off), beyond = vf_lt(past * (vf_abs(sum) + bound) + off, along);
    vm apart = vm_and(vm_or(before, beyond), vf_lt(bound, vf_abs(sum)));
    return ~vm_bits(vm_and(vf_lt(size, vf_set(DAFT_FILTER_MOST)), vm_or(outside, apart))) & DAFT_ALL_LANES;
}

typedef struct daft_touch {
    vf t, v, w; /* distances; weights of corners 1 and 2 */
} daft_touch;

typedef struct daft_mean {
    vf inverse, along; /* one over the sides' sum; the corners' mean of p·d */
} daft_mean;

/* Distances and weights from the sides. */
DAFT_INLINE daft_mean daft_touch_measure(const vf side[3], const vf q[3], vf dd, daft_touch *out)
{
    vf inverse = vf_set(1) / (side[0] + side[1] + side[2]);
    out->v = side[1] * inverse;
    out->w = side[2] * inverse;
    vf along = side[0] * inverse * q[0] + out->v * q[1] + out->w * q[2];
    out->t = along / dd;
    return (daft_mean){inverse, along};
}

DAFT_INLINE vm daft_touch_within(const daft_touch *touch, vf tmin, vf tmax)
{
    return vm_and(vf_le(tmin, touch->t), vf_le(touch->t, tmax));
}

/* The floats' word alone; `fast` takes the edges' planes as the corners come. */
DAFT_INLINE vbits daft_touch_floats(const vf3 c[3], vf3 o, vf3 d, vf tmin, vf tmax, bool fast, daft_touch *out)
{
    vf3 p[3] = {vf3_sub(c[0], o), vf3_sub(c[1], o), vf3_sub(c[2], o)};
    vf side[3], q[3], zero = vf_set(0);
    for (int k = 0; k < 3; k++) {
        vf3 x = p[(k + 1) % 3], y = p[(k + 2) % 3];
        side[k] = vf3_dot(fast ? vf3_cross(x, y) : vf3_cross(vf3_sub(x, y), vf3_add(x, y)), d);
        q[k] = vf3_dot(p[k], d);
    }
    vm in = vm_or(vf_le(zero, vf_min3(side[0], side[1], side[2])), vf_le(vf_max3(side[0], side[1], side[2]), zero));
    daft_touch_measure(side, q, vf3_dot(d, d), out);
    return vm_bits(vm_and(in, daft_touch_within(out, tmin, tmax)));
}

/* Bits of the lanes that are surely touched in tmin..tmax; in *unsure those that floats cannot decide or measure; in *sided
 * those whose lines touch for sure. */
DAFT_INLINE vbits daft_touch_lanes(const vf3 c[3], vf3 o, vf3 d, vf tmin, vf tmax, daft_touch *out, vbits *unsure,
                                   vbits *sided)
{
    vf3 p[3] = {vf3_sub(c[0], o), vf3_sub(c[1], o), vf3_sub(c[2], o)};
    vf side[3], size[3], reach[3] = {vf3_magnitude(p[0]), vf3_magnitude(p[1]), vf3_magnitude(p[2])};
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        vf3 e = vf3_sub(c[i], c[j]);
        side[k] = vf3_dot(vf3_cross(e, vf3_add(p[i], p[j])), d);
        size[k] = vf3_magnitude(e) * (reach[i] + reach[j]);
    }
    vf least = vf_min3(side[0], side[1], side[2]), most = vf_max3(side[0], side[1], side[2]), speed = vf3_magnitude(d);
    vf bound = vf_max3(size[0], size[1], size[2]) * (speed * vf_set(9 * DAFT_ULP)) + vf_set(DAFT_TINY);
    /* a side that overflowed may be of the wrong sign; written so that a NaN is neither outside nor sure */
    vm outside = vm_and(vm_and(vf_lt(least, -bound), vf_lt(bound, most)), vf_lt(bound, vf_set(9 * DAFT_ULP * 1e38f)));
    vf q[3] = {vf3_dot(p[0], d), vf3_dot(p[1], d), vf3_dot(p[2], d)};
    vf range = vf_max3(q[0], q[1], q[2]) - vf_min3(q[0], q[1], q[2]), dd = vf3_dot(d, d);
    daft_mean mean = daft_touch_measure(side, q, dd, out);
    vf doubt = vf_set(3) * bound * range * vf_abs(mean.inverse) + vf_set(DAFT_TINY) +
               vf_max3(reach[0], reach[1], reach[2]) * (speed * vf_set(8 * DAFT_ULP));
    vm in = vm_or(vf_lt(bound, least), vf_lt(most, -bound));
    vm sure = vm_and(in, vm_and(vf_lt(doubt, vf_abs(mean.along) * vf_set(0x1p-18f)), vf_lt(vf_set(DAFT_SHORT), dd)));
    *sided = vm_bits(vm_and(in, vf_lt(bound, vf_set(9 * DAFT_ULP * 1e38f))));
    /* sides twice as sure, so that the mean is off by no more than twice the doubt: then what lies before tmin or behind
     * tmax needs no second look. A ray that leaves a surface has its triangle right behind it. */
    vf slack = doubt + doubt + dd * vf_set(DAFT_TINY), two = bound + bound; /* denormal distances round by more than u */
    vf low = tmin * dd, high = tmax * dd, u8 = vf_set(8 * DAFT_ULP);
    vm before = vf_lt(mean.along + slack, low - u8 * vf_abs(low)), after = vf_lt(high + u8 * vf_abs(high), mean.along - slack);
    vm apart = vm_and(vm_and(vm_or(vf_lt(two, least), vf_lt(most, -two)), vf_lt(vf_set(DAFT_SHORT), dd)), vm_or(before, after));
    vbits certain = vm_bits(sure);
    *unsure = ~vm_bits(vm_or(outside, apart)) & ~certain & DAFT_ALL_LANES;
    vm backwards = vm_and(vf_lt(mean.along, vf_set(0)), vf_le(vf_set(0), tmin)); /* at -0 */
    return certain & vm_bits(daft_touch_within(out, tmin, tmax)) & ~vm_bits(backwards);
}

typedef struct daft_exact_touch {
    float t, v, w;
} daft_exact_touch;

/* A pair of ray and triangle that floats could not decide, or measure: whether they touch; distance and weights in double.
 * `sided`: the floats' sides are all of one sign for sure. Then only an origin in the triangle's plane, which is at
 * distance 0, speaks against it, and doubles, here off by less than 2^-30 of the corners' distances, tell. */
static __attribute__((noinline, unused)) bool daft_touch_exact(const daft_block *b, uint32_t i, bool sided, daft_vec3 o,
                                                               daft_vec3 d, float tmin, float tmax, daft_exact_touch *out)
{
    daft_dvec3 ray = daft_to_double(d), origin = daft_to_double(o), p[3];
    daft_vec3 c[3] = {daft_block_corner(b, 0, i), daft_block_corner(b, 1, i), daft_block_corner(b, 2, i)};
    if (b->triangle[i] == DAFT_NO_TRIANGLE || (!sided && !daft_line_touches(o, c[0], c[1], c[2], d))) return false;
    double w[3], along = 0, most = 0;
    for (int k = 0; k < 3; k++) p[k] = daft_dsub(daft_to_double(c[k]), origin);
    daft_pencil_weights(p[0], p[1], p[2], d, w);
    for (int k = 0; k < 3; k++) {
        double q = daft_ddot(p[k], ray);
        along += w[k] * q;
        most = fabs(q) > most ? fabs(q) : most;
    }
    if (sided && !(fabs(along) > 0x1p-20 * most) && !daft_line_touches(o, c[0], c[1], c[2], d)) return false;
    if (along < 0 && tmin >= 0) return false; /* distances may round to -0 */
    *out = (daft_exact_touch){(float)(along / daft_ddot(ray, ray)), (float)w[1], (float)w[2]};
    return out->t >= tmin && out->t <= tmax;
}

/* ---- hits ---- */

/* The nearest hit so far: t limits the search, instance and triangle break ties. */
typedef struct daft_nearest {
    float t, u, v;
    uint32_t instance, triangle;
    const daft_block *block; /* where the triangle's corners stand; NULL: in the mesh alone */
    uint32_t place;
} daft_nearest;

DAFT_INLINE float daft_unit_clamped(float s) { return s > 0 ? (s < 1 ? s : 1) : 0; }

DAFT_INLINE void daft_nearest_take(daft_nearest *hit, const daft_block *b, uint32_t i, float t, float u, float v)
{
    if (!(t < hit->t || (t == hit->t && b->triangle[i] < hit->triangle))) return;
    hit->t = t, hit->u = daft_unit_clamped(u), hit->v = daft_unit_clamped(v);
    hit->triangle = b->triangle[i], hit->block = b, hit->place = i;
}

/* The triangles of one block, those in `which`. True: some touch within tmin..hit->t, and *hit is the nearest. */
static __attribute__((noinline, unused)) bool daft_block_touch(const daft_block *b, uint32_t which, daft_vec3 origin,
                                                               daft_vec3 direction, float low, daft_intersection how,
                                                               daft_nearest *hit)
{
    vf3 c[3], o = vf3_set(origin), d = vf3_set(direction);
    for (int k = 0; k < 3; k++)
        c[k] = (vf3){vf_load_spread(b->corner[k][0], NULL, 1), vf_load_spread(b->corner[k][1], NULL, 1),
                     vf_load_spread(b->corner[k][2], NULL, 1)};
    daft_touch touch;
    vbits unsure = 0, sided = 0, bits;
    float limit = hit->t;
    vf tmin = vf_set(low), tmax = vf_set(limit);
    if (how == DAFT_INTERSECT_EXACT) bits = daft_touch_lanes(c, o, d, tmin, tmax, &touch, &unsure, &sided) & which;
    else bits = daft_touch_floats(c, o, d, tmin, tmax, how == DAFT_INTERSECT_FAST, &touch) & which;
    bool any = bits != 0;
    for (; bits; bits &= bits - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(bits);
        daft_nearest_take(hit, b, i, touch.t[i], touch.v[i], touch.w[i]);
    }
    for (unsure &= which; unsure; unsure &= unsure - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(unsure);
        daft_exact_touch e;
        if (!daft_touch_exact(b, i, sided >> i & 1, origin, direction, low, limit, &e)) continue;
        daft_nearest_take(hit, b, i, e.t, e.v, e.w);
        any = true;
    }
    return any;
}

/* Without branches: x - x is 0 for finite x and NaN for others. */
DAFT_INLINE bool daft_finite_lines(daft_vec3 o, daft_vec3 d)
{
    return (o.x - o.x) + (o.y - o.y) + (o.z - o.z) + (d.x - d.x) + (d.y - d.y) + (d.z - d.z) == 0;
}

/* A ray that is not finite, goes nowhere or ends before it begins hits nothing. */
DAFT_INLINE bool daft_ray_usable(const daft_ray *ray)
{
    v4 o = v4_load((const float *)ray), d = v4_load((const float *)ray + 4); /* lanes 3: tmin and tmax */
    uint32_t finite = v4_bits((o - o) + (d - d) == v4_set(0)), moves = v4_bits(d != v4_set(0));
    return ((finite & 7) == 7) & ((moves & 7) != 0) & (ray->tmin <= ray->tmax);
}

#endif
