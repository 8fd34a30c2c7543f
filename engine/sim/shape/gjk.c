/* The algorithm of Gilbert, Johnson and Keerthi (1988), after van den Bergen, "Collision Detection in Interactive 3D
 * Environments" (2003), and Catto, "Computing Distance", GDC 2010; simplices are solved by the regions of Ericson,
 * "Real-Time Collision Detection" (2005), 5.1. Everything in double on float input, so rounding is far below what any
 * caller can see.
 *
 * It ends when the support in the direction of the nearest point is no nearer than that point (by rounding), when it is
 * one the simplex has already, or when the distance does not fall: each of these happens after finitely many steps. */
#include "sim/shape/gjk.h"

#include <string.h>

/* The nearest point is exact to this fraction of the square distance. */
#define EXACT 1e-13
/* A square distance that is no more than this fraction of the squares of what it comes from is none. */
#define NOTHING 1e-28

enum { MAX_STEPS = 128 };

daft_proxy daft_proxy_of(const daft_sim_shape *convex)
{
    daft_proxy out = {.count = 1, .radius = (double)convex->radius};
    switch (convex->type) {
    case DAFT_GEOMETRY_BOX:
        out.is_box = true;
        out.half = convex->half;
        out.count = 8;
        out.radius = 0;
        break;
    case DAFT_GEOMETRY_HULL:
        out.points = convex->hull->vertices;
        out.count = convex->hull->vertex_count;
        out.radius = 0;
        break;
    case DAFT_GEOMETRY_CAPSULE:
        out.own[0] = daft_v3(0, -convex->half_height, 0), out.own[1] = daft_v3(0, convex->half_height, 0);
        out.count = 2;
        break;
    default: break;
    }
    return out;
}

daft_proxy daft_proxy_triangle(const daft_vec3 corners[3])
{
    return (daft_proxy){.count = 3, .own = {corners[0], corners[1], corners[2]}};
}

static uint32_t support(const daft_proxy *p, daft_dvec3 d, daft_dvec3 *point)
{
    if (p->is_box) {
        daft_dvec3 h = daft_to_double(p->half);
        *point = daft_dv3(d.x < 0 ? -h.x : h.x, d.y < 0 ? -h.y : h.y, d.z < 0 ? -h.z : h.z);
        return (uint32_t)(d.x < 0) | (uint32_t)(d.y < 0) << 1 | (uint32_t)(d.z < 0) << 2;
    }
    const daft_vec3 *points = p->points ? p->points : p->own;
    uint32_t best = 0;
    double most = -INFINITY;
    for (uint32_t i = 0; i < p->count; i++) {
        double along = ((double)points[i].x * d.x + (double)points[i].y * d.y) + (double)points[i].z * d.z;
        if (along > most) most = along, best = i;
    }
    *point = daft_to_double(points[best]);
    return best;
}

/* ---- simplices ---- */

typedef struct corner {
    daft_dvec3 w, a, b; /* b - a, and both, in a's frame */
    uint32_t ia, ib;
} corner;

/* Corners in use and their weights at the point nearest to the origin. */
typedef struct simplex {
    corner corners[4];
    double weights[4];
    uint32_t count;
} simplex;

static void keep_one(simplex *s, uint32_t i)
{
    s->corners[0] = s->corners[i];
    s->weights[0] = 1;
    s->count = 1;
}

static void keep_two(simplex *s, uint32_t i, uint32_t j, double t)
{
    corner p = s->corners[i], q = s->corners[j];
    s->corners[0] = p, s->corners[1] = q;
    s->weights[0] = 1 - t, s->weights[1] = t;
    s->count = 2;
}

static void solve_segment(simplex *s)
{
    daft_dvec3 p = s->corners[0].w, d = daft_dsub(s->corners[1].w, p);
    double along = -daft_ddot(p, d), square = daft_ddot(d, d);
    if (along <= 0)
        keep_one(s, 0);
    else if (along >= square)
        keep_one(s, 1);
    else
        keep_two(s, 0, 1, along / square);
}

/* Ericson 5.1.5, for the origin. */
static void solve_triangle(simplex *s)
{
    daft_dvec3 a = s->corners[0].w, b = s->corners[1].w, c = s->corners[2].w, ab = daft_dsub(b, a),
               ac = daft_dsub(c, a);
    double d1 = -daft_ddot(ab, a), d2 = -daft_ddot(ac, a), d3 = -daft_ddot(ab, b), d4 = -daft_ddot(ac, b);
    double d5 = -daft_ddot(ab, c), d6 = -daft_ddot(ac, c);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2, all = (va + vb) + vc;
    if (d1 <= 0 && d2 <= 0) {
        keep_one(s, 0);
    } else if (d3 >= 0 && d4 <= d3) {
        keep_one(s, 1);
    } else if (d6 >= 0 && d5 <= d6) {
        keep_one(s, 2);
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        keep_two(s, 0, 1, d1 / (d1 - d3));
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        keep_two(s, 0, 2, d2 / (d2 - d6));
    } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        keep_two(s, 1, 2, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
    } else if (!(all > 0)) {
        keep_two(s, 0, 1, 0.5); /* a triangle without area, by rounding */
        solve_segment(s);
    } else {
        s->weights[0] = va / all, s->weights[1] = vb / all, s->weights[2] = vc / all;
    }
}

static daft_dvec3 nearest(const simplex *s)
{
    daft_dvec3 v = {0, 0, 0};
    for (uint32_t i = 0; i < s->count; i++) v = daft_dadd(v, daft_dscale(s->corners[i].w, s->weights[i]));
    return v;
}

/* The nearest of the four faces that the origin is in front of; inside: all four stay. */
static void solve_tetrahedron(simplex *s)
{
    static const uint8_t faces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}}; /* the last: opposite
                                                                                                  */
    simplex best = *s;
    double least = INFINITY;
    for (int f = 0; f < 4; f++) {
        daft_dvec3 p = s->corners[faces[f][0]].w;
        daft_dvec3 n = daft_dcross(daft_dsub(s->corners[faces[f][1]].w, p), daft_dsub(s->corners[faces[f][2]].w, p));
        daft_dvec3 up = daft_dsub(s->corners[faces[f][3]].w, p);
        double inner = daft_ddot(n, up), outer = -daft_ddot(n, p);
        double flat = 1e-12 * sqrt(daft_ddot(n, n) * daft_ddot(up, up));
        if (fabs(inner) > flat && inner * outer >= 0) continue; /* the origin is on the inner side */
        simplex one = {.count = 3};
        for (int k = 0; k < 3; k++) one.corners[k] = s->corners[faces[f][k]];
        solve_triangle(&one);
        daft_dvec3 v = nearest(&one);
        double square = daft_ddot(v, v);
        if (square < least) least = square, best = one;
    }
    *s = best;
}

static bool has_corner(const simplex *s, const corner *c)
{
    for (uint32_t i = 0; i < s->count; i++)
        if (s->corners[i].ia == c->ia && s->corners[i].ib == c->ib) return true;
    return false;
}

static corner corner_towards(const daft_proxy *a, const daft_proxy *b, const daft_rigid *b_in_a, daft_dvec3 d)
{
    corner c;
    daft_dvec3 local;
    c.ia = support(a, d, &c.a);
    c.ib = support(b, daft_rigid_to_local_vector(b_in_a, daft_dscale(d, -1)), &local);
    c.b = daft_rigid_point(b_in_a, local);
    c.w = daft_dsub(c.b, c.a);
    return c;
}

static void finish(const simplex *s, daft_dvec3 v, daft_gjk *out)
{
    out->on_a = out->on_b = daft_dv3(0, 0, 0);
    for (uint32_t i = 0; i < s->count; i++) {
        out->on_a = daft_dadd(out->on_a, daft_dscale(s->corners[i].a, s->weights[i]));
        out->on_b = daft_dadd(out->on_b, daft_dscale(s->corners[i].b, s->weights[i]));
    }
    out->distance = sqrt(daft_ddot(v, v));
    out->normal = out->distance > 0 ? daft_dscale(v, 1 / out->distance) : daft_dv3(0, 1, 0);
}

/* ---- a point or a segment, and a box ---- */

/* Along each axis of the box: the middle of the segment, and half of it. */
typedef struct core {
    double c[3], d[3], h[3];
} core;

/* How far its place at t, -1 to 1, is beyond the box along an axis. */
static double beyond(const core *s, int k, double t)
{
    double x = s->c[k] + t * s->d[k];
    return x > s->h[k] ? x - s->h[k] : x < -s->h[k] ? x + s->h[k] : 0;
}

/* Half the slope of the squared distance: it rises with t, in straight pieces. */
static double slope_at(const core *s, double t)
{
    return (s->d[0] * beyond(s, 0, t) + s->d[1] * beyond(s, 1, t)) + s->d[2] * beyond(s, 2, t);
}

/* Where the segment is closest to the box: the slope's zero, between the places where it bends. */
static double closest_at(const core *s)
{
    double a = -1, b = 1, slope_a = slope_at(s, a), slope_b = slope_at(s, b);
    if (slope_a >= 0) return a;
    if (slope_b <= 0) return b;
    for (int i = 0; i < 6; i++) {
        int k = i / 2;
        if (s->d[k] == 0) continue;
        double t = ((i & 1 ? -s->h[k] : s->h[k]) - s->c[k]) / s->d[k];
        if (!(t > a && t < b)) continue;
        double slope = slope_at(s, t);
        if (slope < 0)
            a = t, slope_a = slope;
        else
            b = t, slope_b = slope;
    }
    return a - slope_a * (b - a) / (slope_b - slope_a);
}

static bool is_core(const daft_proxy *p) { return !p->is_box && !p->points && p->count <= 2; }

/* At once, and exact: most of what is asked for is a ball or a capsule over a floor. */
static bool core_distance(const daft_proxy *a, const daft_proxy *b, const daft_rigid *b_in_a, double limit,
                          daft_gjk *out)
{
    daft_dvec3 p = daft_to_double(a->own[0]), q = daft_to_double(a->own[a->count - 1]);
    daft_dvec3 middle = daft_rigid_to_local(b_in_a, daft_dscale(daft_dadd(p, q), 0.5));
    daft_dvec3 half = daft_rigid_to_local_vector(b_in_a, daft_dscale(daft_dsub(q, p), 0.5)),
               h = daft_to_double(b->half);
    core s = {{middle.x, middle.y, middle.z}, {half.x, half.y, half.z}, {h.x, h.y, h.z}};
    double t = a->count > 1 ? closest_at(&s) : 0;
    daft_dvec3 gap = {beyond(&s, 0, t), beyond(&s, 1, t), beyond(&s, 2, t)};
    double square = daft_ddot(gap, gap), largest = daft_ddot(middle, middle) + daft_ddot(h, h);
    if (!(square > NOTHING * largest)) square = 0;
    out->distance = sqrt(square);
    out->on_a = daft_dadd(daft_dscale(p, 0.5 - 0.5 * t), daft_dscale(q, 0.5 + 0.5 * t));
    out->on_b = daft_dsub(out->on_a, daft_rigid_vector(b_in_a, gap));
    out->normal = square > 0 ? daft_rigid_vector(b_in_a, daft_dscale(gap, -1 / out->distance)) : daft_dv3(0, 1, 0);
    return out->distance <= limit;
}

/* ---- all ---- */

bool daft_gjk_distance(const daft_proxy *a, const daft_proxy *b, const daft_rigid *b_in_a, double limit, daft_gjk *out)
{
    if (is_core(a) && b->is_box) return core_distance(a, b, b_in_a, limit, out);
    simplex s = {.count = 1, .weights = {1}};
    s.corners[0] = corner_towards(a, b, b_in_a, daft_dv3(1, 0, 0));
    daft_dvec3 v = s.corners[0].w;
    double square = daft_ddot(v, v), largest = square;
    for (int step = 0; step < MAX_STEPS && square > NOTHING * largest; step++) {
        corner c = corner_towards(a, b, b_in_a, v);
        double along = daft_ddot(v, c.w);
        if (along > 0 && along * along > limit * limit * square) return false;
        if (square - along <= EXACT * square || has_corner(&s, &c)) break;
        simplex before = s;
        s.corners[s.count++] = c;
        largest = fmax(largest, daft_ddot(c.w, c.w));
        if (s.count == 2)
            solve_segment(&s);
        else if (s.count == 3)
            solve_triangle(&s);
        else
            solve_tetrahedron(&s);
        if (s.count == 4) {
            v = daft_dv3(0, 0, 0);
            square = 0;
            break;
        }
        daft_dvec3 nearer = nearest(&s);
        double less = daft_ddot(nearer, nearer);
        if (!(less < square)) {
            s = before;
            break;
        }
        v = nearer, square = less;
    }
    if (square <= NOTHING * largest) v = daft_dv3(0, 0, 0);
    if (s.count == 4) s.count = 1; /* inside: the points mean nothing */
    finish(&s, v, out);
    return out->distance <= limit;
}
