/* Bounds of instances: they hold every vertex however the thing is turned, are no wider than those of its turned box,
 * and tight for what lies across the axes. */
#include "fixtures.h"

#include "accel/accel.h"
#include "math/simd/dispatch.h"

static daft_affine random_map(void)
{
    daft_affine map;
    daft_quat turn = daft_quat_normalize(
        (daft_quat){random_float(-1, 1), random_float(-1, 1), random_float(-1, 1), random_float(-1, 1)});
    double m[9];
    daft_quat_matrix(turn, m);
    bool straight = random_bits() % 8 == 0; /* along the axes, where sums are not sorted strictly */
    float scale = ldexpf(random_bits() % 2 ? 1 : -1, (int)(random_bits() % 20) - 10);
    for (int i = 0; i < 9; i++) map.m[i] = straight ? (i % 4 == 0 ? scale : 0) : (float)m[i] * scale;
    if (random_bits() % 4 == 0) /* sheared */
        for (int i = 0; i < 9; i++) map.m[i] *= random_float(0.1f, 2);
    float far = random_bits() % 4 == 0 ? 1e5f : 3;
    for (int i = 0; i < 3; i++) map.t[i] = random_float(-far, far);
    return map;
}

static void check_bound(const fixture_mesh *thing, const daft_affine *map)
{
    daft_instance tight = {.mesh = &thing->mesh, .bvh = thing->bvh, .to_frame = *map}, loose = tight;
    loose.bvh = NULL;
    daft_instance_bound(&tight);
    daft_instance_bound(&loose);
    for (uint32_t i = 0; i < 3 * thing->mesh.triangle_count; i++) {
        uint32_t v = thing->mesh.indices[i];
        daft_vec3 p = daft_affine_point(map, daft_v3(thing->mesh.x[v], thing->mesh.y[v], thing->mesh.z[v]));
        for (int k = 0; k < 3; k++)
            if (!(daft_v3_at(p, k) >= daft_v3_at(tight.low, k) && daft_v3_at(p, k) <= daft_v3_at(tight.high, k)))
                fail_msg("vertex %u at %a is outside of %a to %a on axis %d", v, (double)daft_v3_at(p, k),
                         (double)daft_v3_at(tight.low, k), (double)daft_v3_at(tight.high, k), k);
    }
    for (int k = 0; k < 3; k++) {
        assert_true(daft_v3_at(tight.low, k) >= daft_v3_at(loose.low, k));
        assert_true(daft_v3_at(tight.high, k) <= daft_v3_at(loose.high, k));
    }
}

static void bounds_hold_every_vertex(void **unused)
{
    (void)unused;
    fixture_seed(71);
    for (int repeat = 0; repeat < 300; repeat++) {
        daft_vec3 positions[30];
        uint32_t indices[60], vertices = 3 + random_bits() % 28;
        float far = random_bits() % 3 ? 0 : 50;
        daft_vec3 at = random_vec3(-far, far), size = random_vec3(0, 2);
        for (uint32_t i = 0; i < vertices; i++) {
            daft_vec3 p = random_vec3(-1, 1);
            positions[i] = daft_v3(at.x + p.x * size.x, at.y + p.y * size.y, at.z + (repeat % 2 ? p.z : p.x) * size.z);
        }
        for (uint32_t i = 0; i < 60; i++) indices[i] = (i % 3 + random_bits() % (vertices / 3) * 3) % vertices;
        fixture_mesh thing = mesh_make(positions, vertices, indices, 20);
        for (int k = 0; k < 20; k++) {
            daft_affine map = random_map();
            check_bound(&thing, &map);
        }
        mesh_drop(&thing);
    }
}

/* A beam across its own space, stood up along y: the cube that it goes through in its own space is not what is bounded.
 * Between the directions that were measured bounds are looser. */
static void a_diagonal_beam_is_bounded_tightly(void **unused)
{
    (void)unused;
    static const daft_vec3 positions[] = {{0, 0, 0}, {0.1f, 0, 0}, {4, 4, 4}, {4, 4.1f, 4}};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fixture_mesh thing = mesh_make(positions, 4, indices, 2);
    daft_instance instance = {.mesh = &thing.mesh, .bvh = thing.bvh};
    const float s = sqrtf(1.0f / 3), r = sqrtf(0.5f), q = sqrtf(1.0f / 6);
    const float m[9] = {r, -r, 0, s, s, s, -q, -q, 2 * q};
    memcpy(instance.to_frame.m, m, sizeof m);
    daft_instance_bound(&instance);
    assert_true(instance.high.y - instance.low.y < 7.1f);
    assert_true(instance.high.x - instance.low.x < 0.3f);
    mesh_drop(&thing);
}

/* By registers as one by one, whatever stands beside what. */
static void many_as_each(void **unused)
{
    (void)unused;
    enum { INSTANCES = 300 };
    fixture_seed(300);
    fixture_mesh mesh[] = {mesh_ball(5, 1, 0.5f), mesh_ball(3, 2, 0)};
    for (int isa = 0; isa <= daft_isa_best(); isa++)
        for (int repeat = 0; repeat < 20; repeat++) {
            daft_instance many[INSTANCES], each;
            for (int i = 0; i < INSTANCES; i++) {
                const fixture_mesh *thing = &mesh[random_bits() % 2];
                many[i] = (daft_instance){.mesh = &thing->mesh, .bvh = thing->bvh, .to_frame = random_map()};
                if (random_bits() % 64 == 0) many[i].mesh = NULL, many[i].bvh = NULL, many[i].radius = 2;
                if (random_bits() % 64 == 0) many[i].bvh = NULL;
            }
            uint32_t count = INSTANCES - random_bits() % 40;
            daft_accel_kernels_for(isa)->bound(many, count);
            for (uint32_t i = 0; i < count; i++) {
                each = many[i];
                daft_instance_bound(&each);
                assert_memory_equal(&many[i].low, &each.low, sizeof each.low);
                assert_memory_equal(&many[i].high, &each.high, sizeof each.high);
            }
        }
    mesh_drop(&mesh[0]), mesh_drop(&mesh[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_hold_every_vertex),
        cmocka_unit_test(a_diagonal_beam_is_bounded_tightly),
        cmocka_unit_test(many_as_each),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
