/* What the tests of collision geometry share: random shapes, their points in double, and slow, obvious answers. */
#ifndef DAFT_SHAPE_CASES_H
#define DAFT_SHAPE_CASES_H

#include "fixtures.h"
#include "sim/collide/manifold.h"
#include "sim/shape/shape.h"

#define MAYBE __attribute__((unused)) static

/* cmocka's compares floats. */
#define assert_near(is, should, tolerance)                                                                             \
    do {                                                                                                               \
        double near_is = (double)(is), near_should = (double)(should);                                                 \
        if (!(fabs(near_is - near_should) <= (double)(tolerance)))                                                     \
            fail_msg(#is " is %.12g, not %.12g within %g", near_is, near_should, (double)(tolerance));                 \
    } while (0)

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
    double max = -INFINITY, min = INFINITY;
    for (uint32_t i = 0; i < a->count; i++) max = fmax(max, daft_ddot(n, a->points[i]));
    for (uint32_t i = 0; i < b->count; i++) min = fmin(min, daft_ddot(n, b->points[i]));
    return min - max - a->radius - b->radius;
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

/* Distance of two clouds without their rounding: the least of all sums of weights over differences of points, by moving
 * weight from the worst difference in use to the best there is (pairwise Frank and Wolfe), which converges linearly.
 * Gives 0 where they overlap. */
MAYBE double oracle_distance(const cloud *a, const cloud *b)
{
    static double weight[DAFT_HULL_MAX_VERTICES][DAFT_HULL_MAX_VERTICES];
    memset(weight, 0, sizeof weight);
    weight[0][0] = 1;
    daft_dvec3 v = daft_dsub(b->points[0], a->points[0]);
    for (int step = 0; step < 100000; step++) {
        double min = INFINITY, max = -INFINITY, square = daft_ddot(v, v);
        uint32_t best[2] = {0, 0}, worst[2] = {0, 0};
        for (uint32_t i = 0; i < a->count; i++)
            for (uint32_t j = 0; j < b->count; j++) {
                double d = daft_ddot(v, daft_dsub(b->points[j], a->points[i]));
                if (d < min) min = d, best[0] = i, best[1] = j;
                if (weight[i][j] > 0 && d > max) max = d, worst[0] = i, worst[1] = j;
            }
        if (square - min < 1e-9 * square || square < 1e-16) break;
        daft_dvec3 d = daft_dsub(daft_dsub(b->points[best[1]], a->points[best[0]]),
                                 daft_dsub(b->points[worst[1]], a->points[worst[0]]));
        if (!(daft_ddot(d, d) > 0)) break; /* nothing is better than what has weight */
        double t = -daft_ddot(v, d) / daft_ddot(d, d), all = weight[worst[0]][worst[1]];
        bool drop = t >= all;
        t = drop ? all : t;
        weight[worst[0]][worst[1]] = drop ? 0 : all - t;
        weight[best[0]][best[1]] += t;
        v = daft_dadd(v, daft_dscale(d, t));
    }
    double length = sqrt(daft_ddot(v, v));
    return length < 1e-7 ? 0 : length;
}

/* A triangle mesh as a shape. */
typedef struct surface {
    fixture_mesh *mesh;
    daft_mesh_shape *shape;
    daft_sim_shape s;
} surface;

MAYBE surface surface_of(fixture_mesh mesh)
{
    daft_allocator allocator = daft_malloc_allocator();
    surface out = {.mesh = malloc(sizeof mesh)};
    *out.mesh = mesh;
    out.shape = daft_mesh_shape_create(&allocator, &out.mesh->mesh, out.mesh->bvh, false, NULL);
    assert_non_null(out.shape);
    out.s = daft_shape_mesh(out.shape);
    return out;
}

MAYBE void surface_drop(surface *s)
{
    daft_mesh_shape_free(s->shape);
    mesh_drop(s->mesh);
    free(s->mesh);
}

#endif
