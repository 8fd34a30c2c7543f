/* What the tests of collision geometry share: random shapes, their points in double, and slow, obvious answers. */
#ifndef DAFT_SHAPE_CASES_H
#define DAFT_SHAPE_CASES_H

#include "fixtures.h"
#include "sim/manifold.h"
#include "sim/shape.h"

#define MAYBE __attribute__((unused)) static

MAYBE daft_dvec3 random_unit(void)
{
    for (;;) {
        daft_dvec3 v = daft_to_double(random_vec3(-1, 1));
        double square = daft_ddot(v, v);
        if (square > 1e-4 && square <= 1) return daft_dscale(v, 1 / sqrt(square));
    }
}

MAYBE daft_rigid random_rigid(float spread)
{
    daft_quat q = random_rotation();
    return daft_rigid_make(daft_to_double(random_vec3(-spread, spread)), q);
}

MAYBE daft_hull *random_hull(uint32_t count, daft_vec3 size)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_vec3 points[256];
    daft_error error = {0};
    for (uint32_t i = 0; i < count; i++) points[i] = daft_mul(random_vec3(-1, 1), size);
    daft_hull *hull = daft_hull_create(&allocator, points, count, 0, &error);
    if (!hull) fail_msg("%s", error.message);
    return hull;
}

MAYBE daft_sim_shape must_box(float x, float y, float z)
{
    daft_sim_shape s;
    assert_true(daft_shape_box(daft_v3(x, y, z), &s, NULL));
    return s;
}
MAYBE daft_sim_shape must_sphere(float r)
{
    daft_sim_shape s;
    assert_true(daft_shape_sphere(r, &s, NULL));
    return s;
}
MAYBE daft_sim_shape must_capsule(float half, float r)
{
    daft_sim_shape s;
    assert_true(daft_shape_capsule(half, r, &s, NULL));
    return s;
}

/* ---- a convex shape as points with a rounding, in any frame, in double ---- */

typedef struct cloud {
    daft_dvec3 points[DAFT_HULL_MAX_VERTICES];
    uint32_t count;
    double radius;
    daft_dvec3 axes[DAFT_HULL_MAX_FACES], edges[DAFT_HULL_MAX_HALF_EDGES];
    uint32_t axis_count, edge_count;
} cloud;

MAYBE void cloud_turn(cloud *c, const daft_rigid *pose)
{
    for (uint32_t i = 0; i < c->count; i++) c->points[i] = daft_rigid_point(pose, c->points[i]);
    for (uint32_t i = 0; i < c->axis_count; i++) c->axes[i] = daft_rigid_vector(pose, c->axes[i]);
    for (uint32_t i = 0; i < c->edge_count; i++) c->edges[i] = daft_rigid_vector(pose, c->edges[i]);
}

MAYBE cloud cloud_of(const daft_sim_shape *s, const daft_rigid *pose)
{
    cloud c = {.radius = (double)s->radius};
    switch (s->type) {
    case DAFT_GEOMETRY_BOX:
        for (int i = 0; i < 8; i++)
            c.points[c.count++] =
                daft_dv3((double)(i & 1 ? s->half.x : -s->half.x), (double)(i & 2 ? s->half.y : -s->half.y),
                         (double)(i & 4 ? s->half.z : -s->half.z));
        for (int k = 0; k < 3; k++) c.axes[c.axis_count++] = c.edges[c.edge_count++] = daft_dv3(k == 0, k == 1, k == 2);
        break;
    case DAFT_GEOMETRY_HULL: {
        const daft_hull *h = s->hull;
        for (uint32_t i = 0; i < h->vertex_count; i++) c.points[c.count++] = daft_to_double(h->vertices[i]);
        for (uint32_t i = 0; i < h->face_count; i++) c.axes[c.axis_count++] = daft_to_double(h->planes[i].normal);
        for (uint32_t i = 0; i < h->half_edge_count; i += 2)
            c.edges[c.edge_count++] = daft_dsub(daft_to_double(h->vertices[h->half_edges[i ^ 1].origin]),
                                                daft_to_double(h->vertices[h->half_edges[i].origin]));
        break;
    }
    case DAFT_GEOMETRY_CAPSULE:
        c.points[c.count++] = daft_dv3(0, -(double)s->half_height, 0);
        c.points[c.count++] = daft_dv3(0, (double)s->half_height, 0);
        c.edges[c.edge_count++] = daft_dv3(0, 1, 0);
        break;
    default: c.points[c.count++] = daft_dv3(0, 0, 0); break;
    }
    cloud_turn(&c, pose);
    return c;
}

/* How far b is from a along n (unit, from a to b): negative for overlap. */
MAYBE double apart_along(const cloud *a, const cloud *b, daft_dvec3 n)
{
    double most = -INFINITY, least = INFINITY;
    for (uint32_t i = 0; i < a->count; i++) most = fmax(most, daft_ddot(n, a->points[i]));
    for (uint32_t i = 0; i < b->count; i++) least = fmin(least, daft_ddot(n, b->points[i]));
    return least - most - a->radius - b->radius;
}

MAYBE void try_axis(const cloud *a, const cloud *b, daft_dvec3 n, double *best)
{
    double length = sqrt(daft_ddot(n, n));
    if (length < 1e-9) return;
    n = daft_dscale(n, 1 / length);
    *best = fmax(*best, fmax(apart_along(a, b, n), apart_along(a, b, daft_dscale(n, -1))));
}

/* The greatest separation over all axes that faces and pairs of edges give: for overlapping solids minus the least
 * distance that takes them apart. */
MAYBE double oracle_sat(const cloud *a, const cloud *b)
{
    double best = -INFINITY;
    for (uint32_t i = 0; i < a->axis_count; i++) try_axis(a, b, a->axes[i], &best);
    for (uint32_t i = 0; i < b->axis_count; i++) try_axis(a, b, b->axes[i], &best);
    for (uint32_t i = 0; i < a->edge_count; i++)
        for (uint32_t j = 0; j < b->edge_count; j++) {
            daft_dvec3 u = a->edges[i], v = b->edges[j], n = daft_dcross(u, v);
            if (daft_ddot(n, n) > 1e-10 * daft_ddot(u, u) * daft_ddot(v, v)) try_axis(a, b, n, &best);
        }
    return best;
}

/* Distance of two clouds without their rounding, by Frank and Wolfe's method with exact line search and many steps:
 * slow, short, never more than the answer by the gap it stops at. Gives 0 where they overlap. */
MAYBE double oracle_distance(const cloud *a, const cloud *b)
{
    daft_dvec3 v = daft_dsub(b->points[0], a->points[0]);
    double lower = 0;
    for (int step = 0; step < 4000; step++) {
        double length = sqrt(daft_ddot(v, v));
        if (length < 1e-7) return 0;
        daft_dvec3 n = daft_dscale(v, 1 / length), pa = a->points[0], pb = b->points[0];
        for (uint32_t i = 0; i < a->count; i++)
            if (daft_ddot(n, a->points[i]) > daft_ddot(n, pa)) pa = a->points[i];
        for (uint32_t i = 0; i < b->count; i++)
            if (daft_ddot(n, b->points[i]) < daft_ddot(n, pb)) pb = b->points[i];
        daft_dvec3 w = daft_dsub(pb, pa), d = daft_dsub(w, v);
        lower = fmax(lower, daft_ddot(n, w));
        if (length - lower < 1e-5 * (1 + length)) return length;
        double t = -daft_ddot(v, d) / daft_ddot(d, d);
        v = daft_dadd(v, daft_dscale(d, t < 1 ? t : 1));
    }
    return sqrt(daft_ddot(v, v));
}

#endif
