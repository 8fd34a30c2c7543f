/* accel: single rays through both levels find what brute force finds, the same on every instruction set, alone, in
 * packets and in streams; closed meshes leak no ray; degenerate inputs build in bounded depth and do no harm. */
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
            if (daft_pencil_sphere(daft_sub(c, ray->origin), instance->radius, ray->direction, &t))
                nearest = fmin(nearest, t);
            continue;
        }
        for (uint32_t k = 0; k < instance->mesh->triangle_count; k++)
            nearest = fmin(nearest, hit_triangle(instance, k, ray));
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
                                  : instance_make(i % 3 == 1 ? &soup : &ball,
                                                  affine_make(random_rotation(), scale, random_vec3(-8, 8)));
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
        bool same =
            isinf(expected) ? hit.instance == UINT32_MAX : fabs((double)hit.t - expected) < 1e-4 * (1 + expected);
        disagreements += !same; /* rays that graze an edge may fall either way in floats */
        hits += hit.instance != UINT32_MAX;
    }
    print_message("%d hits, %d grazing rays decided differently\n", hits, disagreements);
    assert_true(hits > 500 && disagreements <= 3);
    daft_arena_free(&s.arena);
    mesh_drop(&soup);
    mesh_drop(&ball);
}

/* A top level of one node. Two instances stand in one place: the lower number is hit. */
static void few_instances(void **unused)
{
    (void)unused;
    fixture_seed(77);
    fixture_mesh ball = mesh_ball(12, 1, 0.2f);
    daft_instance instances[DAFT_WIDTH];
    int hits = 0, disagreements = 0;
    for (uint32_t count = 1; count <= DAFT_WIDTH; count++) {
        for (uint32_t i = 0; i < count; i++) {
            daft_affine turned = affine_make(random_rotation(), daft_v3(1, 1, 1), random_vec3(-2, 2));
            instances[i] = i % 3 == 2 ? sphere_make(random_vec3(-2, 2), 0.7f) : instance_make(&ball, turned);
        }
        if (count > 2) instances[1] = instances[0];
        scene s, rest;
        scene_build(&s, instances, count);
        for (int i = 0; i < 200; i++) {
            daft_vec3 origin = random_vec3(-5, 5);
            daft_ray ray = ray_make(origin, daft_sub(random_vec3(-2, 2), origin));
            daft_hit hit, second;
            daft_accel_kernels_for(0)->closest(s.tlas, &ray, UINT32_MAX, &hit);
            same_on_every_isa(&s, &ray, &hit);
            assert_true(count <= 2 || hit.instance != 1);
            double expected = brute(&s, &ray);
            disagreements += isinf(expected) ? hit.instance != UINT32_MAX
                                             : !(fabs((double)hit.t - expected) < 1e-4 * (1 + expected));
            if (hit.instance == UINT32_MAX) continue;
            hits++;
            daft_accel_kernels_for(daft_isa_best())->closest(s.tlas, &ray, hit.instance, &second);
            rest = s, rest.count = hit.instance; /* those before it, then those after it */
            double beside = brute(&rest, &ray);
            rest.instances = instances + hit.instance + 1, rest.count = count - hit.instance - 1;
            beside = fmin(beside, brute(&rest, &ray));
            disagreements += isinf(beside) ? second.instance != UINT32_MAX
                                           : !(fabs((double)second.t - beside) < 1e-4 * (1 + beside));
        }
        daft_arena_free(&s.arena);
    }
    print_message("%d hits, %d grazing rays decided differently\n", hits, disagreements);
    assert_true(hits > 300 && disagreements <= 3);
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
        daft_instance instance =
            instance_make(&ball, affine_make(random_rotation(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)));
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

/* ---- rays together: packets and streams find, to the bit, what single rays find ---- */

enum { COMPANY = 1024 };

typedef struct company {
    daft_ray rays[COMPANY];
    uint32_t count;
} company;

static void join_company(company *c, daft_ray ray)
{
    if (c->count < COMPANY) c->rays[c->count++] = ray;
}

/* Bits of random rays, seldom none and seldom all. */
static uint32_t random_active(void)
{
    uint32_t kind = random_bits() % 8, bits = random_bits() & 0xffff;
    return kind == 0 ? 0 : kind == 1 ? 1u << bits % 16 : kind < 5 ? 0xffff : bits;
}

static void check_packet(const daft_accel_kernels *k, const daft_tlas *tlas, const daft_ray *rays,
                         const daft_hit *expected, const bool *stopped)
{
    daft_ray_packet packet;
    daft_hit hits[DAFT_PACKET], untouched;
    uint32_t active = random_active(), found = 0, dark = 0;
    memset(&untouched, 0xa5, sizeof untouched);
    for (uint32_t i = 0; i < DAFT_PACKET; i++) {
        daft_ray_packet_set(&packet, i, &rays[i]);
        hits[i] = untouched;
        if (!(active >> i & 1)) continue;
        found |= (uint32_t)(expected[i].instance != UINT32_MAX) << i;
        dark |= (uint32_t)stopped[i] << i;
    }
    assert_int_equal(k->closest_packet(tlas, &packet, active, UINT32_MAX, hits), found);
    assert_int_equal(k->occluded_packet(tlas, &packet, active), dark);
    for (uint32_t i = 0; i < DAFT_PACKET; i++)
        assert_memory_equal(&hits[i], active >> i & 1 ? &expected[i] : &untouched, sizeof untouched);
}

/* Rays in arrays, all of them and some, from their origins on. */
static void same_in_arrays(const daft_tlas *tlas, const company *c)
{
    static float number[6][COMPANY];
    static daft_hit expected[COMPANY], hits[COMPANY], untouched;
    uint32_t place[COMPANY], some = 0;
    uint16_t numbers[COMPANY];
    memset(&untouched, 0xa5, sizeof untouched);
    for (uint32_t i = 0; i < c->count; i++) {
        const daft_vec3 o = c->rays[i].origin, d = c->rays[i].direction;
        const daft_ray ray = {.origin = o, .direction = d, .tmax = INFINITY};
        number[0][i] = o.x, number[1][i] = o.y, number[2][i] = o.z;
        number[3][i] = d.x, number[4][i] = d.y, number[5][i] = d.z;
        place[i] = random_bits() % 1024;
        daft_accel_kernels_for(0)->closest(tlas, &ray, UINT32_MAX, &expected[i]);
        if (random_bits() % 2) numbers[some++] = (uint16_t)i;
    }
    daft_ray_arrays rays = {
        .origin = {number[0], number[1], number[2]}, .direction = {number[3], number[4], number[5]}, .place = place};
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        rays.numbers = NULL;
        daft_accel_kernels_for(isa)->closest_arrays(tlas, &rays, c->count, hits);
        assert_memory_equal(hits, expected, c->count * sizeof *hits);
        rays.numbers = numbers;
        for (uint32_t i = 0; i < c->count; i++) hits[i] = untouched;
        daft_accel_kernels_for(isa)->closest_arrays(tlas, &rays, some, hits);
        for (uint32_t i = 0, k = 0; i < c->count; i++) {
            const bool asked = k < some && numbers[k] == i;
            assert_memory_equal(&hits[i], asked ? &expected[i] : &untouched, sizeof *hits);
            k += asked;
        }
    }
}

/* On every instruction set; the single rays of the first are what all are compared with. */
static void same_together(const daft_tlas *tlas, const company *c)
{
    static daft_hit expected[COMPANY], hits[COMPANY];
    static bool stopped[COMPANY];
    uint32_t dark[COMPANY / 32 + 1];
    for (uint32_t i = 0; i < c->count; i++) {
        daft_accel_kernels_for(0)->closest(tlas, &c->rays[i], UINT32_MAX, &expected[i]);
        stopped[i] = daft_accel_kernels_for(0)->occluded(tlas, &c->rays[i]);
    }
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        const daft_accel_kernels *k = daft_accel_kernels_for(isa);
        for (uint32_t i = 0; i + DAFT_PACKET <= c->count; i += DAFT_PACKET)
            check_packet(k, tlas, c->rays + i, expected + i, stopped + i);
        uint32_t count = isa == 0 ? c->count : random_bits() % (c->count + 1); /* streams of any length */
        k->closest_stream(tlas, c->rays, count, UINT32_MAX, hits);
        k->occluded_stream(tlas, c->rays, count, dark);
        for (uint32_t i = 0; i < count; i++) {
            daft_hit single;
            k->closest(tlas, &c->rays[i], UINT32_MAX, &single);
            assert_memory_equal(&single, &expected[i], sizeof single);
            assert_memory_equal(&hits[i], &expected[i], sizeof hits[i]);
            assert_int_equal(dark[i / 32] >> i % 32 & 1, stopped[i]);
        }
    }
    same_in_arrays(tlas, c);
}

static float odd_number(void)
{
    static const float ODD[] = {0, -0.0f, INFINITY, -INFINITY, NAN, 1e-40f, 1e30f, -1e-30f, 1, -1};
    return ODD[random_bits() % DAFT_COUNT_OF(ODD)];
}

/* Sixteen rays of a kind. */
static void add_rays(company *c, const scene *s, int kind)
{
    daft_vec3 origin = random_vec3(-10, 10), middle = random_vec3(-4, 4);
    for (int i = 0; i < DAFT_PACKET; i++) {
        daft_ray ray = ray_make(origin, daft_sub(daft_add(middle, random_vec3(-0.2f, 0.2f)), origin)); /* 0: a pencil */
        const daft_instance *instance = &s->instances[random_bits() % s->count];
        if (kind == 1) ray = ray_make(random_vec3(-10, 10), random_vec3(-1, 1));
        if (kind == 2) ray.origin = daft_add(origin, random_vec3(-0.5f, 0.5f)); /* nearly parallel */
        if (kind == 3) {                                                        /* grid directions and places */
            ray.origin =
                daft_v3((float)(random_bits() % 9) - 4, (float)(random_bits() % 9) - 4, (float)(random_bits() % 9) - 4);
            ray.direction =
                daft_v3((float)(random_bits() % 3) - 1, (float)(random_bits() % 3) - 1, (float)(random_bits() % 3) - 1);
        }
        if (kind == 4 && instance->mesh) { /* at a vertex or at a point of an edge */
            const daft_trimesh *m = instance->mesh;
            uint32_t t = random_bits() % m->triangle_count, v = m->indices[3 * t], w = m->indices[3 * t + 1];
            daft_vec3 a = {m->x[v], m->y[v], m->z[v]}, b = {m->x[w], m->y[w], m->z[w]};
            daft_vec3 at = daft_add(a, daft_scale(daft_sub(b, a), i % 2 ? 0 : random_float(0, 1)));
            ray.direction = daft_sub(daft_affine_point(&instance->to_frame, at), ray.origin);
        }
        if (kind == 5) { /* numbers that rays should not hold */
            float *number = i % 2 ? &ray.origin.x : &ray.direction.x;
            number[random_bits() % 3] = odd_number();
            if (i % 4 == 3) ray.tmin = odd_number();
            if (i % 4 == 2) ray.tmax = odd_number();
        }
        daft_hit hit;
        if (kind == 6 && daft_accel_kernels_for(0)->closest(s->tlas, &ray, UINT32_MAX, &hit)) {
            /* limits right before, at and behind what is hit */
            float t = i % 3 == 0 ? nextafterf(hit.t, 0) : i % 3 == 1 ? hit.t : nextafterf(hit.t, INFINITY);
            if (i % 2)
                ray.tmin = t;
            else
                ray.tmax = t;
        }
        if (kind == 7) ray.tmin = random_float(-5, 5), ray.tmax = ray.tmin + random_float(-0.1f, 5);
        join_company(c, ray);
    }
}

static void packets_and_streams(void **unused)
{
    (void)unused;
    fixture_seed(1618);
    fixture_mesh soup = mesh_soup(700, 2, 0.4f), ball = mesh_ball(12, 1, 0.2f), grid = mesh_ball(4, 2, 0);
    const fixture_mesh *meshes[3] = {&soup, &ball, &grid};
    for (int round = 0; round < 6; round++) {
        daft_instance instances[24];
        int count = round % 3 == 0 ? 1 : round % 3 == 1 ? 6 : 24;
        for (int i = 0; i < count; i++) {
            daft_vec3 scale = daft_v3(random_float(0.3f, 2), random_float(0.3f, 2), i % 5 == 0 ? -0.7f : 1);
            daft_affine map = affine_make(random_rotation(), scale, random_vec3(-5, 5));
            if (i % 3 == 1)
                for (int k = 0; k < 9; k++) map.m[k] += random_float(-0.2f, 0.2f); /* any affine map */
            if (i == 2 || count == 1) map = affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0));
            instances[i] = i % 4 == 3 ? sphere_make(random_vec3(-5, 5), random_float(0.1f, 1.5f))
                                      : instance_make(meshes[i % 3], map);
            if (i % 7 == 6) instances[i].flags = 0;
        }
        if (count > 8) instances[8] = instances[4]; /* ties between instances */
        scene s;
        scene_build(&s, instances, (uint32_t)count);
        for (daft_intersection how = DAFT_INTERSECT_EXACT; how <= DAFT_INTERSECT_FAST; how++) {
            const daft_tlas_def def = {.intersection = how, .threads = 1};
            const daft_tlas *tlas = daft_tlas_build_for(&s.arena, instances, (uint32_t)count, &def, NULL);
            company c = {.count = 0};
            for (int i = 0; i < COMPANY / DAFT_PACKET; i++) {
                bool odd = i % 8 == 5; /* floats alone do not know distances along rays that overflow: any order may win
                                        */
                if (how == DAFT_INTERSECT_EXACT || !odd) add_rays(&c, &s, i % 8);
            }
            same_together(tlas, &c);
        }
        daft_arena_free(&s.arena);
    }
    scene empty;
    company c = {.count = 0};
    scene_build(&empty, NULL, 0);
    for (int i = 0; i < 64; i++) join_company(&c, ray_make(random_vec3(-1, 1), random_vec3(-1, 1)));
    same_together(empty.tlas, &c);
    daft_arena_free(&empty.arena);
    mesh_drop(&soup);
    mesh_drop(&ball);
    mesh_drop(&grid);
}

/* ---- spheres: whoever stands about them, they are hit where they are hit alone ---- */

enum { SPHERES = 60 };

/* From around a sphere past its edge, by a few roundings inside or outside; or, one in four, off its surface. */
static daft_ray grazing_ray(const daft_instance *sphere, int i, float stretch)
{
    const float *t = sphere->to_frame.t;
    daft_dvec3 centre = daft_dv3((double)t[0], (double)t[1], (double)t[2]);
    daft_dvec3 out = daft_to_double(daft_normalize(random_vec3(-1, 1))),
               aside = daft_dcross(out, daft_to_double(random_vec3(-1, 1)));
    double off = i % 4 == 1 ? (double)random_float(-1, 1) * 1e-3 : (double)((int)(random_bits() % 17) - 8) * 0x1p-24,
           r = (double)sphere->radius * (1 + off);
    double away = i % 4 == 0 ? 0 : (double)(random_float(1, 20) * sphere->radius) * (i % 4 == 3 ? 1000 : 1);
    daft_dvec3 edge = daft_dadd(centre, daft_dscale(out, r)),
               way = daft_dscale(aside, 1 / sqrt(daft_ddot(aside, aside)));
    if (i % 8 == 4) way = daft_dadd(way, daft_dscale(out, (double)random_float(-1, 1)));
    return ray_make(daft_to_float(daft_dadd(edge, daft_dscale(way, -away))),
                    daft_to_float(daft_dscale(way, (double)stretch)));
}

/* By a tree of each: the nearest, of those at one distance the first. */
static daft_hit nearest_of_each(const daft_tlas *const each[SPHERES], const daft_ray *ray)
{
    daft_hit best = {.t = ray->tmax, .instance = UINT32_MAX};
    for (uint32_t i = 0; i < SPHERES; i++) {
        daft_hit hit;
        if (!daft_accel_kernels_for(0)->closest(each[i], ray, UINT32_MAX, &hit)) continue;
        hit.instance = i;
        if (best.instance == UINT32_MAX || hit.t < best.t) best = hit;
    }
    return best;
}

/* A ray that ends about where it meets something, as one that does is sure to be stopped or not. */
static bool stops_as_each(const daft_tlas *all, const daft_tlas *const each[SPHERES], daft_ray ray, float t)
{
    ray.tmax = t * (1 + (float)((int)(random_bits() % 9) - 4) * (random_bits() % 2 ? 0x1p-22f : 0.1f));
    bool expected = false;
    for (uint32_t i = 0; i < SPHERES; i++) expected |= daft_accel_kernels_for(0)->occluded(each[i], &ray);
    for (int isa = 0; isa <= daft_isa_best(); isa++)
        assert_int_equal(daft_accel_kernels_for(isa)->occluded(all, &ray), expected);
    return expected;
}

static void crowded_spheres(void **unused)
{
    (void)unused;
    fixture_seed(577);
    static const struct {
        float size, far, stretch;
    } SCALES[] = {{1, 0, 1},     {1, 1000, 1},     {1e-3f, 10, 1e-3f}, {1e5f, 1e6f, 1e4f}, {1, 0, 1e-10f},
                  {1, 1, 1e10f}, {1e9f, 1e10f, 1}, {1e-20f, 0, 1},     {1e18f, 0, 1}};
    int hits = 0, misses = 0, stopped = 0, passed = 0;
    for (size_t round = 0; round < DAFT_COUNT_OF(SCALES); round++) {
        float size = SCALES[round].size, far = SCALES[round].far;
        daft_instance spheres[SPHERES];
        const daft_tlas *each[SPHERES];
        daft_vec3 place = daft_scale(random_vec3(-1, 1), far);
        for (int i = 0; i < SPHERES; i++) {
            spheres[i] =
                sphere_make(daft_add(place, daft_scale(random_vec3(-4, 4), size)), size * random_float(0.05f, 0.8f));
            if (i % 7 == 6) spheres[i].low.x -= size; /* larger bounds than are needed */
            if (i % 5 == 4) spheres[i].flags = 0;
        }
        scene s;
        scene_build(&s, spheres, SPHERES);
        for (uint32_t i = 0; i < SPHERES; i++) each[i] = daft_tlas_build(&s.arena, &spheres[i], 1, NULL);
        company c = {.count = 0};
        for (int i = 0; i < COMPANY; i++) {
            static const daft_instance *one;
            if (i % 16 == 0) one = &spheres[random_bits() % SPHERES];
            daft_ray ray = grazing_ray(one, i / 16 % 2 ? i : i / 16, SCALES[round].stretch);
            if (i / 16 % 4 == 2)
                ray = ray_make(c.rays[i / 16 * 16].origin,
                               i % 16 ? daft_sub(ray.origin, c.rays[i / 16 * 16].origin) : ray.direction);
            if (i % 32 == 31) ray.tmin = random_float(-30, 1) * size;
            join_company(&c, ray);
            daft_hit hit, expected = nearest_of_each(each, &ray);
            daft_accel_kernels_for(0)->closest(s.tlas, &ray, UINT32_MAX, &hit);
            assert_memory_equal(&hit, &expected, sizeof hit);
            hits += hit.instance != UINT32_MAX, misses += hit.instance == UINT32_MAX;
            bool stops = stops_as_each(s.tlas, each, ray, hit.instance == UINT32_MAX ? INFINITY : hit.t);
            stopped += stops, passed += !stops;
        }
        same_together(s.tlas, &c);
        daft_arena_free(&s.arena);
    }
    print_message("%d hits, %d misses; %d stopped, %d not\n", hits, misses, stopped, passed);
    assert_true(hits > COMPANY && misses > COMPANY && stopped > COMPANY && passed > COMPANY);
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

/* Every instruction set finds the same hits, bit for bit, among instances that are only shifted: several in one place,
 * flat ones, from far away, and for rays with odd numbers. */
static void shifted_things(void **unused)
{
    (void)unused;
    fixture_seed(5150);
    fixture_mesh ball = mesh_ball(12, 1, 0.2f), soup = mesh_soup(8, 1, 0.6f);
    const daft_vec3 corners[4] = {{-9, 0, -9}, {9, 0, -9}, {9, 0, 9}, {-9, 0, 9}};
    const uint32_t quad[6] = {0, 2, 1, 0, 3, 2};
    fixture_mesh ground = mesh_make(corners, 4, quad, 2);
    const fixture_mesh *const meshes[3] = {&ball, &ground, &soup};
    daft_instance instances[DAFT_WIDTH];
    int hits = 0, stopped = 0;
    for (uint32_t round = 0; round < 4 * DAFT_WIDTH; round++) {
        uint32_t count = 1 + round % DAFT_WIDTH;
        float far = round < 2 * DAFT_WIDTH ? 2 : round < 3 * DAFT_WIDTH ? 1e5f : 1e-3f;
        for (uint32_t i = 0; i < count; i++) {
            daft_affine shift = affine_make(daft_quat_identity(), daft_v3(1, 1, 1), random_vec3(-far, far));
            instances[i] = instance_make(meshes[random_bits() % 3], shift);
            instances[i].flags = random_bits() % 4 ? DAFT_INSTANCE_CASTS_SHADOW : 0;
        }
        if (count > 2) instances[count - 1] = instances[0];
        scene s;
        scene_build(&s, instances, count);
        for (int kind = 0; kind < 8 * 8; kind++) {
            company c = {.count = 0};
            add_rays(&c, &s, kind % 8);
            for (uint32_t i = 0; i < c.count; i++) {
                uint32_t ignore = random_bits() % 2 ? UINT32_MAX : random_bits() % count;
                if (i % 16 == 5) c.rays[i].tmin = -0.0f; /* not below 0, but before it as bits */
                const daft_accel_kernels *first = daft_accel_kernels_for(0);
                daft_hit hit, expected;
                bool expect_hit = first->closest(s.tlas, &c.rays[i], ignore, &expected);
                bool expect_stop = first->occluded(s.tlas, &c.rays[i]);
                for (int isa = 1; isa <= daft_isa_best(); isa++) {
                    const daft_accel_kernels *k = daft_accel_kernels_for(isa);
                    bool found = k->closest(s.tlas, &c.rays[i], ignore, &hit);
                    assert_int_equal(found, expect_hit);
                    assert_memory_equal(&hit, &expected, sizeof hit);
                    bool stops = k->occluded(s.tlas, &c.rays[i]);
                    assert_int_equal(stops, expect_stop);
                }
                hits += expect_hit, stopped += expect_stop;
            }
        }
        daft_arena_free(&s.arena);
    }
    print_message("%d hits, %d stopped\n", hits, stopped);
    assert_true(hits > 1700 && stopped > 1000);
    mesh_drop(&ball);
    mesh_drop(&ground);
    mesh_drop(&soup);
}

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
            if (kind == 1) spread.y = 0;                                 /* all in one plane */
            if (kind == 4 && i == 0) spread = daft_v3(1e6f, 1e6f, 1e6f); /* one huge among tiny ones */
            if (kind == 4) at = random_float(0, 1);
            p[3 * i] = daft_v3(at, 0, 0), p[3 * i + 1] = daft_add(daft_v3(at + 1, 0, 1), spread);
            p[3 * i + 2] = kind == 5 ? daft_v3(at + 2, 0, 2) : daft_add(daft_v3(at, 1, 1), spread); /* 5: no area */
        }
        for (uint32_t count = 0; count <= COUNT; count = count < 2 ? count + 1 : count == 2 ? COUNT : COUNT + 1) {
            fixture_mesh m = mesh_make(p, 3 * COUNT, index, count);
            check_tree(&m);
            daft_instance instance =
                instance_make(&m, affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)));
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
    const struct CMUnitTest tests[] = {cmocka_unit_test(against_brute_force),
                                       cmocka_unit_test(few_instances),
                                       cmocka_unit_test(closed_meshes_leak_nothing),
                                       cmocka_unit_test(limits_and_ignore),
                                       cmocka_unit_test(packets_and_streams),
                                       cmocka_unit_test(crowded_spheres),
                                       cmocka_unit_test(shifted_things),
                                       cmocka_unit_test(degenerate_inputs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
