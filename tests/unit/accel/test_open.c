/* Free ways off a mesh's own triangles, whatever the mesh: by brute force and exact predicates, no ray in a triangle's cone meets another
 * triangle, wherever on it it starts and however it is lifted; most triangles of what is smooth have one. */
#include "fixtures.h"
#include "mesh_points.h"
#include "meter.h"

#include "accel/open.h"
#include "geometry/trimesh.h"
#include "math/exact.h"

static bool is_stopped(const daft_trimesh *mesh, uint32_t but, daft_vec3 from, daft_vec3 way)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        daft_vec3 c[3];
        corners_of(mesh, i, c);
        if (i == but || !daft_line_hits(from, c[0], c[1], c[2], way)) continue;
        daft_dvec3 a = daft_to_double(c[0]), n = daft_dcross(daft_dsub(daft_to_double(c[1]), a), daft_dsub(daft_to_double(c[2]), a));
        if (daft_ddot(n, daft_dsub(a, daft_to_double(from))) / daft_ddot(n, daft_to_double(way)) > 0) return true;
    }
    return false;
}

/* The cone's axis, and the least cosine times its length. */
static daft_vec3 cone_axis(uint32_t cone, float *least)
{
    *least = (float)(cone >> 24);
    return daft_v3((float)(int8_t)(cone & 255), (float)(int8_t)(cone >> 8 & 255), (float)(int8_t)(cone >> 16 & 255));
}

/* A place on the triangle, often at its edges, lifted as render/surface_kernel.c does: to the corners' tangent planes, and a little off. */
static daft_vec3 lifted_place(const daft_trimesh *mesh, uint32_t triangle, daft_vec3 front)
{
    daft_vec3 c[3], p = {0, 0, 0}, out;
    float w[3] = {random_float(0, 1), random_float(0, 1), random_bits() & 1 ? random_float(0, 1) : 0}, sum = w[0] + w[1] + w[2];
    const uint32_t *at = mesh->normal_indices ? &mesh->normal_indices[3 * triangle] : &mesh->indices[3 * triangle];
    corners_of(mesh, triangle, c);
    for (int k = 0; k < 3; k++) p = daft_add(p, daft_scale(c[k], w[k] / sum));
    out = daft_add(p, daft_scale(front, random_float(1e-6f, 1e-5f)));
    for (int k = 0; mesh->normals && k < 3; k++) {
        daft_vec3 n = mesh->normals[at[k]];
        out = daft_sub(out, daft_scale(n, fminf(daft_dot(daft_sub(p, c[k]), n), 0) * w[k] / sum));
    }
    return out;
}

static daft_vec3 front_of(const daft_trimesh *mesh, uint32_t triangle, daft_vec3 axis)
{
    daft_vec3 c[3];
    corners_of(mesh, triangle, c);
    daft_vec3 n = daft_normalize(daft_cross(daft_sub(c[1], c[0]), daft_sub(c[2], c[0])));
    return daft_dot(n, axis) < 0 ? daft_neg(n) : n;
}

/* Gives the share of triangles that have a cone. */
static float check_cones(const fixture_mesh *m, int rays)
{
    const daft_open *open = m->bvh->open;
    uint32_t cones = 0;
    assert_int_equal(open->count, m->mesh.triangle_count);
    for (uint32_t i = 0; i < open->count; i++) {
        float least;
        const daft_vec3 axis = cone_axis(open->cone[i], &least);
        assert_true((least > 0) == (open->cone[i] != 0) && least < 127);
        if (least == 0) continue;
        cones++;
        const daft_vec3 front = front_of(&m->mesh, i, axis);
        for (int k = 0; k < rays; k++) {
            daft_vec3 way = daft_normalize(daft_add(daft_scale(random_unit(), random_float(0, 2)), daft_normalize(axis)));
            if (daft_dot(way, axis) < least) continue;
            assert_true(daft_dot(way, front) > 0);
            assert_false(is_stopped(&m->mesh, i, lifted_place(&m->mesh, i, front), way));
        }
    }
    return (float)cones / (float)open->count;
}

static void cones_are_free(void **unused)
{
    (void)unused;
    static const float bumps[4] = {0, 0.02f, 0.1f, 0.25f}, least[4] = {0.98f, 0.9f, 0.5f, 0.1f};
    fixture_seed(231);
    for (int i = 0; i < 4; i++) {
        fixture_mesh ball = mesh_ball(14, 1, bumps[i]);
        assert_int_equal(daft_bvh_find_open(ball.bvh, &ball.mesh, UINT32_MAX, 1), 0);
        float share = check_cones(&ball, 60);
        print_message("bumps of %g: %.0f%% of the triangles\n", (double)bumps[i], (double)share * 100);
        assert_true(share > least[i]);
        mesh_drop(&ball);
    }
    for (int i = 0; i < 6; i++) {
        fixture_mesh soup = mesh_soup(i < 3 ? 3 : 300, 1, i % 3 == 0 ? 0.1f : 2);
        daft_bvh_find_open(soup.bvh, &soup.mesh, UINT32_MAX, 1);
        if (soup.bvh->open) check_cones(&soup, 30);
        mesh_drop(&soup);
    }
}

/* A box's inside, seen from its normals' side: each wall is before all others. */
static void corners_and_walls(void **unused)
{
    (void)unused;
    fixture_seed(232);
    static const daft_vec3 p[6] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}, {0, 1, 0}, {1, 1, 0}};
    static const uint32_t corner[12] = {0, 2, 1, 0, 3, 2, 0, 1, 5, 0, 5, 4}; /* a floor and a wall */
    fixture_mesh m = mesh_make(p, 6, corner, 4);
    assert_int_equal(daft_bvh_find_open(m.bvh, &m.mesh, UINT32_MAX, 1), 0);
    check_cones(&m, 2000);
    mesh_drop(&m);
    fixture_mesh none = mesh_make(p, 0, corner, 0);
    assert_int_equal(daft_bvh_find_open(none.bvh, &none.mesh, UINT32_MAX, 1), 0);
    assert_null(none.bvh->open);
    mesh_drop(&none);
}

static void same_for_any_number_of_threads(void **unused)
{
    (void)unused;
    fixture_seed(233);
    fixture_mesh one = mesh_ball(20, 1, 0.1f);
    assert_int_equal(daft_bvh_find_open(one.bvh, &one.mesh, UINT32_MAX, 1), 0);
    size_t size = one.bvh->open->count * sizeof(uint32_t), with = daft_bvh_bytes(one.bvh);
    uint32_t *first = malloc(size);
    memcpy(first, one.bvh->open->cone, size);
    daft_open_drop(one.bvh);
    assert_true(daft_bvh_bytes(one.bvh) + size <= with);
    for (uint32_t left = one.mesh.triangle_count, now; left > 0; left = now) { /* bit by bit, too */
        now = daft_bvh_find_open(one.bvh, &one.mesh, 101, 3);
        assert_int_equal(now, left > 101 ? left - 101 : 0);
        assert_int_equal(one.bvh->open->found, one.mesh.triangle_count - now);
        if (now) assert_int_equal(one.bvh->open->cone[one.mesh.triangle_count - 1], 0);
    }
    assert_memory_equal(first, one.bvh->open->cone, size);
    free(first);
    mesh_drop(&one);
}

static void without_memory(void **unused)
{
    (void)unused;
    fixture_seed(234);
    fixture_mesh m = mesh_ball(8, 1, 0.1f);
    int fail_at = 0;
    for (;; fail_at++) {
        meter memory = {fail_at, 0};
        m.bvh->allocator = (daft_allocator){&memory, meter_allocate, meter_release};
        assert_int_equal(daft_bvh_find_open(m.bvh, &m.mesh, UINT32_MAX, 1), 0);
        bool found = m.bvh->open != NULL;
        assert_int_equal(memory.held, found ? 2 : 0);
        if (found) {
            daft_open_drop(m.bvh);
            assert_int_equal(memory.held, 0);
        }
        m.bvh->allocator = daft_malloc_allocator();
        if (found) break;
    }
    assert_int_equal(fail_at, 2);
    mesh_drop(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cones_are_free), cmocka_unit_test(corners_and_walls),
        cmocka_unit_test(same_for_any_number_of_threads), cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
