/* How rays meet boxes and triangles, in lanes: for the kernels of single rays, whatever tree they go through, where
 * lanes are triangles, and of packets, where lanes are rays.
 *
 * Boxes: slab test. A zero component's inverse is infinite: planes then lie at plus or minus infinity, and the NaN of a
 * ray within a plane loses every comparison, so that plane says nothing, which is right. The far distance is widened
 * (Ize, "Robust BVH Ray Traversal", 2013), so rounding never misses a box: with u = 2^-24, a difference, an inverse and
 * a product move each distance by 3u, and the product that widens the far inverse by u: 7u to first order, and 8u is
 * taken.
 *
 * Triangles: a filter decides nearly all. With a corner s relative to the origin and two edges e, f from it, the sides
 * are triple products of s, d and an edge (Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection",
 * 1997), the third what is left of their sum, d·(e × f). It says "missed" only where its own error bound allows no
 * other answer. s, e and f round once, each product in a triple product twice, then one difference and two sums: a side
 * is off by 7u of the sum of the six products' magnitudes, 14u·|s|·|e|·D, with |.| the largest component of s or e and
 * D the sum of those of d; the sum of the sides by 14u·|e|·|f|·D, the third side by all three and 2u of them. Together
 * less than 22u·D·(|s|·(|e| + |f|) + |e|·|f|). Where it is sure, s·(e × f), off by 8u·|s|·6·|e|·|f|, says whether the
 * triangle is behind, or further than a hit.
 *
 * Where the three sides are of one sign by more than the bound, the filter is sure of a hit as well: then their sum is
 * twice the bound or more. If s·(e × f) is more than twice what it may be off, too, the line is *plain*: either number
 * is over 40·2^-24 of the magnitudes that went into it, so the same formula in double gives distance and weights to
 * 2^-28 of the distance. Of grazed and of flat triangles, a few in a thousand, the exact predicates say whether they
 * are hit: triangles are closed, and where a ray touches several at one distance the lowest number is the hit. Their
 * distance is the mean of the corners' along the ray in double, weighted by the sides, so it stays among them however
 * flat the triangle is seen. Which of both ways is taken depends on the ray and the triangle alone.
 *
 * The floats' word alone, which `fast` and `watertight` take, is by another test: with the corners a, b relative to the
 * ray's origin, an edge's plane is (a - b) × (a + b) = 2·a × b, a - b being taken from the corners as given. Exchanging
 * a and b negates every bit of it, so the two triangles at an edge see opposite values of one number (Davidovič et al.,
 * "3D rasterization", 2012; Woop et al., "Watertight Ray/Triangle Intersection", 2013). That alone still loses rays at
 * vertices, where rounding can put a ray on the same side of every spoke of a fan.
 *
 * Order: a box is only passed by when it lies 2^-17 behind the nearest hit or before tmin, so more than distances are
 * off. The hit is thus the nearest of all triangles touched, by distance, instance and number, however and with
 * whomever the ray travelled: bit for bit the same from every kernel. */
#ifndef DAFT_RAY_TEST_H
#define DAFT_RAY_TEST_H

#include "accel/bvh.h"
#include "math/exact.h"
#include "math/simd/dispatch.h"
#include "math/simd/ops.h"

#define DAFT_ULP  0x1p-24f /* u: half a unit in the last place of 1 */
#define DAFT_TINY 1e-36f   /* over the sum of a few underflowing products */

/* The limits of boxes: further out than the ray's own by more than distances are off. */
DAFT_INLINE float daft_past(float t) { return t > 0 ? t * (1 + 0x1p-17f) : t * (1 - 0x1p-17f); }
DAFT_INLINE float daft_before(float t) { return -daft_past(-t); }
DAFT_INLINE float daft_forward(float t) { return t > 0 ? t : 0; }

DAFT_INLINE daft_vec3 daft_block_corner(const daft_block *b, int corner, uint32_t i)
{
    return daft_v3(b->corner[corner][0][i], b->corner[corner][1][i], b->corner[corner][2][i]);
}

DAFT_INLINE bool daft_is_translation(const daft_affine *map)
{
    static const float UNTURNED[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    return v8_eq_bits(v8_load(map->m), v8_load(UNTURNED)) == 0xff && map->m[8] == 1;
}

/* A sphere whose centre lies behind a ray that begins outside is not met. That is known before any division where the
 * squared distance of the centre is over so many squared radii: far from what doubles round. */
#define DAFT_SPHERE_OUTSIDE (1 + 1e-6)

/* What spheres, taken twice as large, are off by for boxes' sums and differences in floats, as a share of the sum of
 * all axes' ways to the origin of the frame and from the ray's to their centre, and of their size. With u = 2^-24, o
 * the origin and c the way from it to the centre, the centre is off by 4u·(|o| + |c| + 3r), the product c × d by 6u of
 * |c|·|d|, and squares by 5u of themselves: together by less than 20u of |o| + |c| + r. */
#define DAFT_SPHERE_OFF 0x1p-19f

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

/* The filter's error terms for a direction: per size of the triangle and its way from the ray, and how far behind a
 * triangle must be; -inf where negative distances count, too. Between directions of 2^±26 and for products of sizes
 * below FILTER_MOST nothing overflows; what is beyond passes. */
typedef struct daft_filter {
    float scale, floor;
} daft_filter;

#define DAFT_FILTER_MOST 1e24f
#define DAFT_FILTER_SIZE 1e-18f /* added to sizes, so that errors are over what underflows in them */

DAFT_INLINE daft_filter daft_filter_of(daft_vec3 d, float tmin)
{
    float size = fabsf(d.x) + fabsf(d.y) + fabsf(d.z),
          scale = size > 0x1p-26f && size < 0x1p26f ? 22 * DAFT_ULP * size : INFINITY;
    return (daft_filter){scale, tmin >= 0 ? -DAFT_TINY : -INFINITY};
}

/* A triangle's edges from corner 0, one of them the other way round, and their cross product; the sum and the product
 * of the edges' sizes. */
typedef struct daft_facet {
    vf3 corner, a, b, normal;
    vf sizes, area;
} daft_facet;

DAFT_INLINE vf vf3_largest(vf3 a) { return vf_max_abs(vf_max_abs(a.x, a.y), a.z); }

DAFT_INLINE daft_facet daft_facet_of(const vf3 c[3])
{
    vf3 a = vf3_sub(c[0], c[1]), b = vf3_sub(c[2], c[0]);
    vf along = vf3_largest(a) + vf_set(DAFT_FILTER_SIZE), across = vf3_largest(b) + vf_set(DAFT_FILTER_SIZE);
    return (daft_facet){c[0], a, b, vf3_cross(b, a), along + across, along * across};
}

/* What the filter found of lanes: least and largest of the sides, and their sum, off by no more than `bound`; distances
 * times the sum's magnitude, off by no more than `off`; whether all of it is far from overflow. */
typedef struct daft_edge_tests {
    vf least, most, sum, bound, along, off;
    vm usable;
} daft_edge_tests;

/* The lanes that may be hit before `past`, daft_past of a distance that is 0 or more. NaN passes. A ray that leaves a
 * surface has its triangle right behind it, so looking there turns away one in every ray. */
DAFT_INLINE vbits daft_filter_pass(const daft_facet *f, vf3 o, vf3 d, vf scale, vf floor, vf past, daft_edge_tests *out)
{
    vf3 s = vf3_sub(f->corner, o), r = vf3_cross(s, d);
    vf u = vf3_dot(f->b, r), v = vf3_dot(f->a, r), sum = vf3_dot(f->normal, d), w = sum - u - v;
    vf reach = vf3_largest(s), size = reach * f->sizes + f->area, bound = size * scale + vf_set(DAFT_TINY);
    vf least = vf_min3(u, v, w), most = vf_max3(u, v, w), steep = vf_abs(sum);
    vm outside = vm_and(vf_lt(least, -bound), vf_lt(bound, most)), usable = vf_lt(size, vf_set(DAFT_FILTER_MOST));
    vf along = vf_xor(vf3_dot(s, f->normal), (vi)sum & vi_set(INT32_MIN)),
       off = reach * f->area * vf_set(49 * DAFT_ULP);
    vm before = vf_lt(along, floor - off), beyond = vf_lt(past * (steep + bound) + off, along);
    vm apart = vm_and(vm_or(before, beyond), vf_lt(bound, steep));
    *out = (daft_edge_tests){least, most, steep, bound, along, off, usable};
    return vbits_from_mask(vm_and(usable, vm_or(outside, apart))) ^ DAFT_ALL_LANES;
}

/* The lanes whose lines are plain. */
DAFT_INLINE vbits daft_filter_plain(const daft_edge_tests *s)
{
    vm inside = vm_or(vf_lt(s->bound, s->least), vf_lt(s->most, -s->bound));
    return vbits_from_mask(
        vm_and(vm_and(inside, s->usable), vf_lt(s->off + s->off + vf_set(DAFT_TINY), vf_abs(s->along))));
}

/* Of the plain lanes, those that are hit for sure between two distances; see daft_inner_of. */
DAFT_INLINE vbits daft_filter_within(const daft_edge_tests *s, vf low, vf high)
{
    vf off = s->off + vf_set(DAFT_TINY);
    vm after = vf_lt(low * (s->sum + s->bound) + off, s->along),
       before = vf_lt(s->along + off, high * (s->sum - s->bound));
    return vbits_from_mask(vm_and(after, before));
}

/* What is surely within an interval, rounding and all: nothing, where negative distances count, too. */
typedef struct daft_inner {
    float low, high;
} daft_inner;

DAFT_INLINE daft_inner daft_inner_of(float tmin, float tmax)
{
    return (daft_inner){tmin >= 0 ? tmin * (1 + 0x1p-17f) : INFINITY, tmax * (1 - 0x1p-17f)};
}

typedef struct daft_lane_hits {
    vf t, v, w; /* distances; weights of corners 1 and 2 */
} daft_lane_hits;

DAFT_INLINE vm daft_hits_within(const daft_lane_hits *touch, vf tmin, vf tmax)
{
    return vm_and(vf_le(tmin, touch->t), vf_le(touch->t, tmax));
}

/* The floats' word alone; `fast` takes the edges' planes as the corners come. */
DAFT_INLINE vbits daft_intersect_floats(const vf3 c[3], vf3 o, vf3 d, vf tmin, vf tmax, bool fast, daft_lane_hits *out)
{
    vf3 p[3] = {vf3_sub(c[0], o), vf3_sub(c[1], o), vf3_sub(c[2], o)};
    vf side[3], q[3], zero = vf_set(0);
    for (int k = 0; k < 3; k++) {
        vf3 x = p[(k + 1) % 3], y = p[(k + 2) % 3];
        side[k] = vf3_dot(fast ? vf3_cross(x, y) : vf3_cross(vf3_sub(x, y), vf3_add(x, y)), d);
        q[k] = vf3_dot(p[k], d);
    }
    vm in = vm_or(vf_le(zero, vf_min3(side[0], side[1], side[2])), vf_le(vf_max3(side[0], side[1], side[2]), zero));
    vf inverse = vf_set(1) / (side[0] + side[1] + side[2]);
    out->v = side[1] * inverse, out->w = side[2] * inverse;
    out->t = (side[0] * inverse * q[0] + out->v * q[1] + out->w * q[2]) / vf3_dot(d, d); /* the corners' mean along the
                                                                                            ray */
    return vbits_from_mask(vm_and(in, daft_hits_within(out, tmin, tmax)));
}

typedef struct daft_exact_hit {
    float t, v, w;
} daft_exact_hit;

DAFT_INLINE bool daft_hit_accept(double t, double v, double w, float tmin, float tmax, daft_exact_hit *out)
{
    if (t < 0 && tmin >= 0) return false; /* distances may round to -0 */
    *out = (daft_exact_hit){(float)t, (float)v, (float)w};
    return out->t >= tmin && out->t <= tmax;
}

/* A plain line's distance and weights: whether they are in tmin..tmax. */
DAFT_INLINE bool daft_intersect_plain(const daft_block *b, uint32_t i, daft_vec3 o, daft_vec3 d, float tmin, float tmax,
                                      daft_exact_hit *out)
{
    daft_dvec3 c = daft_to_double(daft_block_corner(b, 0, i)), s = daft_dsub(c, daft_to_double(o)),
               ray = daft_to_double(d);
    daft_dvec3 e = daft_dsub(c, daft_to_double(daft_block_corner(b, 1, i)));
    daft_dvec3 f = daft_dsub(daft_to_double(daft_block_corner(b, 2, i)), c), normal = daft_dcross(f, e),
               r = daft_dcross(s, ray);
    double inverse = 1 / daft_ddot(normal, ray);
    return daft_hit_accept(daft_ddot(s, normal) * inverse, daft_ddot(f, r) * inverse, daft_ddot(e, r) * inverse, tmin,
                           tmax, out);
}

/* How far a triangle's plane may seem off in double, as a share of the sizes that went into s·(e × f): 2^9 times what
 * the formula and the exact way round by, so that both agree. */
#define DAFT_BEHIND_OFF 0x1p-42

/* Whether a triangle's plane is surely behind a ray. Of the triangle that a ray leaves at a flat angle the filter in
 * floats often cannot tell; there is one for nearly every shadow ray. */
DAFT_INLINE bool daft_is_behind(const daft_block *b, uint32_t i, daft_vec3 o, daft_vec3 d)
{
    const daft_dvec3 c = daft_to_double(daft_block_corner(b, 0, i)), s = daft_dsub(c, daft_to_double(o));
    const daft_dvec3 e = daft_dsub(c, daft_to_double(daft_block_corner(b, 1, i))),
                     f = daft_dsub(daft_to_double(daft_block_corner(b, 2, i)), c), normal = daft_dcross(f, e);
    const double along = daft_ddot(s, normal), sum = daft_ddot(normal, daft_to_double(d));
    const double area = (fabs(e.x) + fabs(e.y) + fabs(e.z)) * (fabs(f.x) + fabs(f.y) + fabs(f.z)) * DAFT_BEHIND_OFF;
    const double off = area * (fabs(s.x) + fabs(s.y) + fabs(s.z)),
                 steep = area * (double)(fabsf(d.x) + fabsf(d.y) + fabsf(d.z));
    return (sum > steep && along < -off) || (sum < -steep && along > off);
}

/* Of any other line: whether it touches, and where. */
static __attribute__((noinline, unused)) bool daft_intersect_exact(const daft_block *b, uint32_t i, daft_vec3 o,
                                                                   daft_vec3 d, float tmin, float tmax,
                                                                   daft_exact_hit *out)
{
    if (tmin >= 0 && daft_is_behind(b, i, o, d)) return false;
    daft_dvec3 ray = daft_to_double(d), origin = daft_to_double(o), p[3];
    daft_vec3 c[3] = {daft_block_corner(b, 0, i), daft_block_corner(b, 1, i), daft_block_corner(b, 2, i)};
    if (!daft_line_touches(o, c[0], c[1], c[2], d)) return false;
    double w[3], along = 0;
    for (int k = 0; k < 3; k++) p[k] = daft_dsub(daft_to_double(c[k]), origin);
    daft_pencil_weights(p[0], p[1], p[2], d, w);
    for (int k = 0; k < 3; k++) along += w[k] * daft_ddot(p[k], ray);
    return daft_hit_accept(along / daft_ddot(ray, ray), w[1], w[2], tmin, tmax, out);
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

DAFT_INLINE void daft_nearest_update(daft_nearest *hit, const daft_block *b, uint32_t i, float t, float u, float v)
{
    if (!(t < hit->t || (t == hit->t && b->triangle[i] < hit->triangle))) return;
    hit->t = t, hit->u = daft_unit_clamped(u), hit->v = daft_unit_clamped(v);
    hit->triangle = b->triangle[i], hit->block = b, hit->place = i;
}

/* ---- leaves: lanes are triangles ---- */

/* A ray in the space of a mesh. */
typedef struct daft_mesh_ray {
    daft_vec3 origin;
    float tmin;
    daft_vec3 direction;
    daft_intersection how;
    daft_filter filter;
    daft_inner inner; /* of what stops it, where no more is asked */
} daft_mesh_ray;

DAFT_INLINE daft_mesh_ray daft_mesh_ray_of(daft_vec3 o, daft_vec3 d, float tmin, float tmax, daft_intersection how)
{
    return (daft_mesh_ray){o, tmin, d, how, daft_filter_of(d, tmin), daft_inner_of(tmin, tmax)};
}

/* How many blocks the lanes take. */
enum { DAFT_FOURS = DAFT_VL / DAFT_BLOCK, DAFT_BLOCK_FLOATS = sizeof(daft_block) / sizeof(float) };

/* `count` blocks, at most DAFT_FOURS. Where there are fewer, the last is loaded again: a branch would cost more. */
DAFT_INLINE void daft_blocks_load(const daft_block *b, int count, vf3 c[3])
{
    static const size_t AT[4][3] = {{0, 0, 0},
                                    {DAFT_BLOCK_FLOATS, DAFT_BLOCK_FLOATS, DAFT_BLOCK_FLOATS},
                                    {DAFT_BLOCK_FLOATS, 2 * DAFT_BLOCK_FLOATS, 2 * DAFT_BLOCK_FLOATS},
                                    {DAFT_BLOCK_FLOATS, 2 * DAFT_BLOCK_FLOATS, 3 * DAFT_BLOCK_FLOATS}};
    const size_t *at = AT[count - 1];
    vf_load_block_pairs_at(b->corner[0][0], at, &c[0].x, &c[0].y);
    vf_load_block_pairs_at(b->corner[0][2], at, &c[0].z, &c[1].x);
    vf_load_block_pairs_at(b->corner[1][1], at, &c[1].y, &c[1].z);
    vf_load_block_pairs_at(b->corner[2][0], at, &c[2].x, &c[2].y);
    c[2].z = vf_load_blocks_at(b->corner[2][2], at);
}

/* By the floats' word alone. */
static __attribute__((noinline, unused)) bool daft_blocks_touch_floats(const daft_block *b, int count,
                                                                       const daft_mesh_ray *r, daft_nearest *hit)
{
    vf3 c[3];
    daft_lane_hits touch;
    bool any = false;
    daft_blocks_load(b, count, c);
    vbits bits = daft_intersect_floats(c, vf3_set(r->origin), vf3_set(r->direction), vf_set(r->tmin), vf_set(hit->t),
                                       r->how == DAFT_INTERSECT_FAST, &touch) &
                 ((1u << count * DAFT_BLOCK) - 1);
    for (; bits; bits &= bits - 1, any = true) {
        uint32_t i = (uint32_t)__builtin_ctz(bits);
        daft_nearest_update(hit, b + i / DAFT_BLOCK, i % DAFT_BLOCK, touch.t[i], touch.v[i], touch.w[i]);
    }
    return any;
}

/* Of the triangles `maybe` of the blocks from b on, those that touch within tmin..hit->t; *hit becomes the nearest.
 * False: none. */
static __attribute__((noinline, unused)) bool daft_blocks_take(const daft_block *b, uint32_t maybe, uint32_t plain,
                                                               const daft_mesh_ray *r, daft_nearest *hit)
{
    bool found = false;
    for (; maybe; maybe &= maybe - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(maybe), i = lane % DAFT_BLOCK;
        const daft_block *block = b + lane / DAFT_BLOCK;
        daft_exact_hit e;
        if (block->triangle[i] == DAFT_NO_TRIANGLE) continue;
        if (plain >> lane & 1 ? !daft_intersect_plain(block, i, r->origin, r->direction, r->tmin, hit->t, &e)
                              : !daft_intersect_exact(block, i, r->origin, r->direction, r->tmin, hit->t, &e))
            continue;
        daft_nearest_update(hit, block, i, e.t, e.v, e.w);
        found = true;
    }
    return found;
}

/* The blocks b[0..count), count at most DAFT_FOURS. True: some touch within tmin..hit->t, and *hit is the nearest;
 * where `any` is asked, it may be left as it was. past: daft_past(hit->t), 0 or more. Most are sure to miss; that is
 * found without a frame on the stack. */
DAFT_INLINE bool daft_blocks_intersect(const daft_block *b, int count, const daft_mesh_ray *r, float past,
                                       daft_nearest *hit, bool any)
{
    if (r->how != DAFT_INTERSECT_EXACT) return daft_blocks_touch_floats(b, count, r, hit);
    vf3 c[3];
    daft_edge_tests sides;
    daft_blocks_load(b, count, c);
    daft_facet facet = daft_facet_of(c);
    vbits maybe = daft_filter_pass(&facet, vf3_set(r->origin), vf3_set(r->direction), vf_set(r->filter.scale),
                                   vf_set(r->filter.floor), vf_set(past), &sides);
    if (!maybe) return false;
    maybe &= (1u << count * DAFT_BLOCK) - 1; /* what is loaded again answers again */
    vbits plain = daft_filter_plain(&sides) & maybe;
    if (any && plain & daft_filter_within(&sides, vf_set(r->inner.low), vf_set(r->inner.high))) return true;
    return daft_blocks_take(b, maybe, plain, r, hit);
}

/* A ray that is not finite, goes nowhere or ends before it begins hits nothing. */
DAFT_INLINE bool daft_ray_usable(const daft_ray *ray)
{
    v4 o = v4_load((const float *)ray), d = v4_load((const float *)ray + 4); /* lanes 3: tmin and tmax */
    uint32_t finite = v4_bits_from_mask((o - o) + (d - d) == v4_set(0)), moves = v4_bits_from_mask(d != v4_set(0));
    return ((finite & 7) == 7) & ((moves & 7) != 0) & (ray->tmin <= ray->tmax);
}

#endif
