/* accel: single rays through both levels find what brute force finds, the same on every instruction set; closed meshes leak
 * no ray; degenerate inputs build in bounded depth and do no harm. */
#include "fixtures.h"

#include "math/exact.h"

typedef struct scene {
    daft_instance *instances;
    uint32_t count;
    daft_arena arena;
    daft_allocator allocator;
    const daft_tlas *tlas;
} scene;

static void scene_build(scene *s, daft_instance *instances, uint32_t count)
{
    *s = (scene){.instances = instances, .count = count, .allocator = daft_malloc_allocator()};
    daft_arena_init(&s->arena, &s->allocator);
    daft_error error;
    s->tlas = daft_tlas_build(&s->arena, instances, count, &error);
    assert_non_null(s->tlas);
}

static daft_ray ray_make(daft_vec3 origin, daft_vec3 direction)
{
    return (daft_ray){.origin = origin, .direction = direction, .tmax = INFINITY};
}

/* Möller and Trumbore in double: the obvious test. Gives t, or infinity. */
static double hit_triangle(const daft_instance *instance, uint32_t triangle, const daft_ray *ray)
{
    const daft_trimesh *mesh = instance->mesh;
    daft_dvec3 p[3];
    for (int k = 0; k < 3; k++) {
        uint32_t v = mesh->indices[3 * triangle + (uint32_t)k];
        const float *m = instance->to_frame.m, *t = instance->to_frame.t;
        double x = (double)mesh->x[v], y = (double)mesh->y[v], z = (double)mesh->z[v];
        p[k] = daft_dv3((double)m[0] * x + (double)m[1] * y + (double)m[2] * z + (double)t[0],
                        (double)m[3] * x + (double)m[4] * y + (double)m[5] * z + (double)t[1],
                        (double)m[6] * x + (double)m[7] * y + (double)m[8] * z + (double)t[2]);
    }
    daft_dvec3 o = daft_to_double(ray->origin), d = daft_to_double(ray->direction);
    daft_dvec3 e1 = daft_dsub(p[1], p[0]), e2 = daft_dsub(p[2], p[0]), h = daft_dcross(d, e2), s = daft_dsub(o, p[0]);
    double det = daft_ddot(e1, h);
    if (det == 0) return INFINITY;
    double u = daft_ddot(s, h) / det;
    daft_dvec3 q = daft_dcross(s, e1);
    double v = daft_ddot(d, q) / det, t = daft_ddot(e2, q) / det;
    return u < 0 || v < 0 || u + v > 1 || t < 0 ? INFINITY : t;
}

static double brute(const scene *s, const daft_ray *ray)
{
    double nearest = INFINITY;
    for (uint32_t i = 0; i < s->count; i++) {
        const daft_instance *instance = &s->instances[i];
        if (!instance->mesh) {
            double t;
            daft_vec3 c = {instance->to_frame.t[0], instance->to_frame.t[1], instance->to_frame.t[2]};
            if (daft_pencil_sphere(daft_sub(c, ray->origin), instance->radius, ray->direction, &t)) nearest = fmin(nearest, t);
            continue;
        }
        for (uint32_t k = 0; k < instance->mesh->triangle_count; k++) nearest = fmin(nearest, hit_triangle(instance, k, ray));
    }
    return nearest;
}

static void same_on_every_isa(const scene *s, const daft_ray *ray, const daft_hit *expected)
{
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        daft_hit hit;
        bool found = daft_accel_kernels_for(isa)->closest(s->tlas, ray, UINT32_MAX, &hit);
        assert_int_equal(found, expected->instance != UINT32_MAX);
        assert_memory_equal(&hit, expected, sizeof hit);
        assert_int_equal(daft_accel_kernels_for(isa)->occluded(s->tlas, ray), found);
    }
}

static void against_brute_force(void **unused)
{
    (void)unused;
    fixture_seed(4242);
    fixture_mesh soup = mesh_soup(500, 2, 0.4f), ball = mesh_ball(12, 1, 0.2f);
    daft_instance instances[24];
    for (int i = 0; i < 24; i++) {
        daft_vec3 scale = daft_v3(random_float(0.3f, 2), random_float(0.3f, 2), i % 5 == 0 ? -0.7f : 1);
        instances[i] = i % 3 == 0 ? sphere_make(random_vec3(-8, 8), random_float(0.1f, 1.5f))
                                  : instance_make(i % 3 == 1 ? &soup : &ball, affine_make(random_rotation(), scale, random_vec3(-8, 8)));
    }
    scene s;
    scene_build(&s, instances, 24);
    int hits = 0, disagreements = 0;
    for (int i = 0; i < 1500; i++) {
        daft_vec3 origin = random_vec3(-12, 12), way = daft_sub(random_vec3(-6, 6), origin);
        if (i % 10 == 0) way = daft_v3(0, i % 20 ? 1 : -1, 0); /* zero components */
        daft_ray ray = ray_make(origin, way);
        daft_hit hit;
        daft_accel_kernels_for(0)->closest(s.tlas, &ray, UINT32_MAX, &hit);
        same_on_every_isa(&s, &ray, &hit);
        double expected = brute(&s, &ray);
        bool same = isinf(expected) ? hit.instance == UINT32_MAX : fabs((double)hit.t - expected) < 1e-4 * (1 + expected);
        disagreements += !same; /* rays that graze an edge may fall either way in floats */
        hits += hit.instance != UINT32_MAX;
    }
    print_message("%d hits, %d grazing rays decided differently\n", hits, disagreements);
    assert_true(hits > 500 && disagreements <= 3);
    daft_arena_free(&s.arena);
    mesh_drop(&soup);
    mesh_drop(&ball);
}

static daft_vec3 vertex(const daft_trimesh *mesh, uint32_t v) { return daft_v3(mesh->x[v], mesh->y[v], mesh->z[v]); }

/* From inside a closed mesh every ray must hit, also those aimed at vertices and at points of edges. */
static void closed_meshes_leak_nothing(void **unused)
{
    (void)unused;
    fixture_seed(31337);
    const daft_accel_kernels *kernels = daft_accel_kernels_for(daft_isa_best());
    for (int round = 0; round < 4; round++) {
        float k = round % 2 ? 1e5f : 1e-5f;
        fixture_mesh ball = mesh_ball(round < 2 ? 5 : 40, k, 0.15f);
        daft_instance instance = instance_make(&ball, affine_make(random_rotation(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)));
        scene s;
        scene_build(&s, &instance, 1);
        for (int i = 0; i < 100000; i++) {
            uint32_t t = random_bits() % ball.mesh.triangle_count, c = random_bits() % 3;
            daft_vec3 a = vertex(&ball.mesh, ball.mesh.indices[3 * t + c]);
            daft_vec3 b = vertex(&ball.mesh, ball.mesh.indices[3 * t + (c + 1) % 3]);
            float along = i % 2 ? 0 : random_float(0, 1);
            daft_vec3 target = daft_affine_point(&instance.to_frame, daft_add(a, daft_scale(daft_sub(b, a), along)));
            daft_vec3 origin = random_vec3(-0.3f * k, 0.3f * k);
            daft_ray ray = ray_make(origin, daft_sub(target, origin));
            daft_hit hit;
            if (!kernels->closest(s.tlas, &ray, UINT32_MAX, &hit)) fail_msg("round %d: ray %d leaks", round, i);
        }
        daft_arena_free(&s.arena);
        mesh_drop(&ball);
    }
}

static void limits_and_ignore(void **unused)
{
    (void)unused;
    daft_instance instances[2] = {sphere_make(daft_v3(5, 0, 0), 1), sphere_make(daft_v3(10, 0, 0), 1)};
    instances[0].flags = 0;
    scene s;
    scene_build(&s, instances, 2);
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        const daft_accel_kernels *k = daft_accel_kernels_for(isa);
        daft_ray ray = ray_make(daft_v3(0, 0, 0), daft_v3(2, 0, 0));
        daft_hit hit;
        assert_true(k->closest(s.tlas, &ray, UINT32_MAX, &hit) && hit.t == 2 && hit.instance == 0);
        assert_true(k->closest(s.tlas, &ray, 0, &hit) && hit.t == 4.5f && hit.instance == 1);
        ray.tmin = 2.5f;
        assert_true(k->closest(s.tlas, &ray, UINT32_MAX, &hit) && hit.t == 3); /* the far side */
        ray.tmin = 0, ray.tmax = 1.9f;
        assert_false(k->closest(s.tlas, &ray, UINT32_MAX, &hit));
        ray.tmax = 3;
        assert_false(k->occluded(s.tlas, &ray)); /* the first sphere casts no shadow */
        ray.tmax = 5;
        assert_true(k->occluded(s.tlas, &ray));
        ray.direction = daft_v3(NAN, 0, 0);
        assert_false(k->closest(s.tlas, &ray, UINT32_MAX, &hit));
    }
    daft_arena_free(&s.arena);
}

static int depth_of(const daft_bvh *bvh, uint32_t child)
{
    if (child & DAFT_CHILD_LEAF) return 0;
    int most = 0;
    for (int i = 0; i < DAFT_WIDTH; i++) {
        uint32_t c = bvh->nodes.items[child].child[i];
        if (c == DAFT_CHILD_NONE) continue;
        int below = depth_of(bvh, c);
        most = below > most ? below : most;
    }
    return most + 1;
}

/* Every triangle is in exactly one block, and the stack holds any path. */
static void check_tree(const fixture_mesh *m)
{
    uint32_t *seen = calloc(m->mesh.triangle_count + 1, sizeof *seen), total = 0;
    for (size_t b = 0; b < m->bvh->block_count; b++)
        for (int i = 0; i < DAFT_BLOCK; i++) {
            uint32_t t = m->bvh->blocks[b].triangle[i];
            if (t == DAFT_NO_TRIANGLE) continue;
            assert_true(t < m->mesh.triangle_count && seen[t]++ == 0);
            total++;
        }
    assert_int_equal(total, m->mesh.triangle_count);
    if (m->bvh->nodes.count) assert_true(depth_of(m->bvh, 0) * (DAFT_WIDTH - 1) + DAFT_WIDTH < DAFT_STACK);
    free(seen);
}

static void degenerate_inputs(void **unused)
{
    (void)unused;
    enum { COUNT = 20000 };
    fixture_seed(8);
    daft_vec3 *p = malloc(3 * COUNT * sizeof *p);
    uint32_t *index = malloc(3 * COUNT * sizeof *index);
    for (uint32_t i = 0; i < 3 * COUNT; i++) index[i] = i;
    for (int kind = 0; kind < 6; kind++) {
        for (uint32_t i = 0; i < COUNT; i++) {
            float at = kind == 2 ? powf(1.001f, (float)i) : kind == 3 ? (float)(i % 2) * 1e30f : 0;
            daft_vec3 spread = kind == 1 ? random_vec3(-1, 1) : daft_v3(0, 0, 0);
            if (kind == 1) spread.y = 0; /* all in one plane */
            if (kind == 4 && i == 0) spread = daft_v3(1e6f, 1e6f, 1e6f); /* one huge among tiny ones */
            if (kind == 4) at = random_float(0, 1);
            p[3 * i] = daft_v3(at, 0, 0), p[3 * i + 1] = daft_add(daft_v3(at + 1, 0, 1), spread);
            p[3 * i + 2] = kind == 5 ? daft_v3(at + 2, 0, 2) : daft_add(daft_v3(at, 1, 1), spread); /* 5: no area */
        }
        for (uint32_t count = 0; count <= COUNT; count = count < 2 ? count + 1 : count == 2 ? COUNT : COUNT + 1) {
            fixture_mesh m = mesh_make(p, 3 * COUNT, index, count);
            check_tree(&m);
            daft_instance instance = instance_make(&m, affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)));
            scene s;
            scene_build(&s, &instance, 1);
            daft_ray ray = ray_make(daft_v3(0.2f, 0.1f, -5), daft_v3(0, 0, 1));
            daft_hit hit;
            daft_accel_kernels_for(daft_isa_best())->closest(s.tlas, &ray, UINT32_MAX, &hit);
            same_on_every_isa(&s, &ray, &hit);
            daft_arena_free(&s.arena);
            mesh_drop(&m);
        }
    }
    free(p);
    free(index);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(against_brute_force), cmocka_unit_test(closed_meshes_leak_nothing),
                                       cmocka_unit_test(limits_and_ignore), cmocka_unit_test(degenerate_inputs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
