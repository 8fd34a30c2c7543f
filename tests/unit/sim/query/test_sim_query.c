/* Queries: each against all bodies asked one by one, meshes against the renderer's rays, far from the origin as at it.
 */
#include "fixtures.h"
#include "sim/query/query.h"
#include "sim_scene.h"

#include "math/simd/dispatch.h"

enum { BODIES = 120, RAYS = 250 };

/* What the tests know of a body without asking the world's trees. */
typedef struct known {
    uint32_t body;
    daft_sim_shape_def shapes[2];
    uint32_t shape_count;
    daft_body_kind kind;
} known;

typedef struct zoo {
    daft_world *world;
    daft_dvec3 centre;
    known known[BODIES];
    fixture_mesh ball;
    daft_mesh_shape *mesh;
    daft_hull *hull;
    daft_height_field *field;
    daft_compound *compound;
} zoo;

static daft_sim_shape random_convex(const zoo *z, int which)
{
    daft_sim_shape s = {0};
    daft_error error;
    float a = (float)uniform(0.1, 0.8);
    daft_vec3 half = daft_v3(a, (float)uniform(0.1, 0.8), (float)uniform(0.1, 0.8));
    if (which == 0) assert_true(daft_shape_sphere(a, &s, &error));
    if (which == 1) assert_true(daft_shape_capsule(a, half.y, &s, &error));
    if (which == 2) assert_true(daft_shape_box(half, &s, &error));
    if (which == 3) s = daft_shape_hull(z->hull);
    return s;
}

static daft_quat random_turn(void)
{
    daft_dvec3 axis = random_in(-1, 1);
    return turned(axis.x, axis.y, axis.z, uniform(-3, 3));
}

static void make_shapes(zoo *z)
{
    daft_error error = {0};
    daft_vec3 points[12];
    float heights[12 * 12];
    for (int i = 0; i < 12; i++) points[i] = daft_to_float(random_in(-0.7, 0.7));
    for (int i = 0; i < 144; i++) heights[i] = (float)uniform(-0.4, 0.4);
    fixture_seed(11);
    z->ball = mesh_ball(12, 1, 0.2f);
    z->mesh = daft_mesh_shape_create(&heap, &z->ball.mesh, z->ball.bvh, true, &error);
    z->hull = daft_hull_create(&heap, points, 12, 0, &error);
    z->field = daft_height_field_create(&heap, heights, 12, 12, 0.3f, 0.2f, &error);
    daft_child children[3];
    for (int i = 0; i < 3; i++)
        children[i] = (daft_child){random_convex(z, i), daft_rigid_make(random_in(-1, 1), random_turn())};
    z->compound = daft_compound_create(&heap, children, 3, &error);
    assert_true(z->mesh && z->hull && z->field && z->compound);
}

static daft_sim_shape random_shape(const zoo *z, int which)
{
    if (which == 4) return daft_shape_mesh(z->mesh);
    if (which == 5) return daft_shape_field(z->field);
    if (which == 6) return daft_shape_compound(z->compound);
    return random_convex(z, which);
}

/* Bodies of every shape and kind around `centre`; the moving ones have moved for some steps, so that what the trees
 * hold is what a game's would. */
static void make_zoo(zoo *z, daft_dvec3 centre, double spread)
{
    *z = (zoo){.world = new_world(), .centre = centre};
    daft_error error = {0};
    seed_random(7);
    make_shapes(z);
    daft_world_set_gravity(z->world, daft_v3(0, 0, 0));
    for (int i = 0; i < BODIES; i++) {
        known *k = &z->known[i];
        bool surface = i % 7 == 4 || i % 7 == 5;
        k->kind = surface ? DAFT_BODY_STATIC : (daft_body_kind)(DAFT_BODY_STATIC + i % 3);
        k->shape_count = i % 5 == 0 ? 2 : 1;
        for (uint32_t s = 0; s < k->shape_count; s++) {
            k->shapes[s] = daft_default_sim_shape_def();
            k->shapes[s].shape = random_shape(z, s == 0 ? i % 7 : 2);
            k->shapes[s].position = s ? daft_v3(0.9f, 0, 0) : daft_v3(0, 0, 0);
            k->shapes[s].layers = 1u << i % 4;
            k->shapes[s].mask = i % 11 == 0 ? 2 : UINT32_MAX;
            k->shapes[s].sensor = i % 13 == 0;
            k->shapes[s].density = 100;
            k->shapes[s].user = (uint32_t)(10 * i) + s;
        }
        daft_sim_body_def def = daft_default_sim_body_def();
        def.kind = k->kind;
        def.position = daft_dadd(centre, random_in(-spread, spread));
        def.rotation = random_turn();
        def.shapes = k->shapes;
        def.shape_count = k->shape_count;
        def.user = (uint32_t)i;
        if (def.kind != DAFT_BODY_STATIC) def.linear = daft_to_float(random_in(-9, 9));
        /* Sensors alone give no mass. */
        if (k->shapes[0].sensor && k->kind == DAFT_BODY_DYNAMIC) def.kind = k->kind = DAFT_BODY_KINEMATIC;
        k->body = daft_world_add(z->world, &def, &error);
        if (!k->body) fail_msg("%s", error.message);
    }
    steps(z->world, 20);
}

static void drop_zoo(zoo *z)
{
    daft_world_destroy(z->world);
    daft_compound_free(z->compound);
    daft_height_field_free(z->field);
    daft_hull_free(z->hull);
    daft_mesh_shape_free(z->mesh);
    mesh_drop(&z->ball);
}

static daft_sim_filter random_filter(int i)
{
    daft_sim_filter f = daft_default_sim_filter();
    if (i % 3 == 0) f.mask = 5;
    if (i % 4 == 0) f.layers = 4;
    if (i % 5 == 0) f.kinds = 1u << DAFT_BODY_STATIC | 1u << DAFT_BODY_DYNAMIC;
    if (i % 6 == 0) f.ignore = 1 + (uint32_t)i % BODIES;
    f.sensors = i % 2 == 0;
    return f;
}

static bool passes(const known *k, uint32_t shape, const daft_sim_filter *f)
{
    const daft_sim_shape_def *s = &k->shapes[shape];
    return (!s->sensor || f->sensors) && k->body != f->ignore && (f->kinds >> k->kind & 1) && (s->layers & f->mask) &&
           (f->layers & s->mask);
}

static daft_rigid frame_now(const zoo *z, const known *k, uint32_t shape)
{
    daft_sim_state state = state_of(z->world, k->body);
    daft_rigid body = daft_rigid_make(state.position, state.rotation);
    daft_rigid part = daft_rigid_make(daft_to_double(k->shapes[shape].position), k->shapes[shape].rotation);
    return daft_rigid_mul(&body, &part);
}

/* From anywhere about the bodies to and past some point among them. */
static void random_way(const zoo *z, daft_dvec3 *from, daft_dvec3 *motion)
{
    *from = daft_dadd(z->centre, random_in(-10, 10));
    *motion = daft_dscale(daft_dsub(daft_dadd(z->centre, random_in(-5, 5)), *from), 1.5);
}

/* ---- rays ---- */

typedef struct slow_hit {
    uint32_t body, shape;
    double t;
} slow_hit;

static uint32_t slow_rays(const zoo *z, daft_dvec3 o, daft_dvec3 d, const daft_sim_filter *f, slow_hit *out)
{
    uint32_t count = 0;
    for (int i = 0; i < BODIES; i++)
        for (uint32_t s = 0; s < z->known[i].shape_count; s++) {
            const known *k = &z->known[i];
            daft_rigid frame = frame_now(z, k, s);
            daft_ray_result r;
            if (!passes(k, s, f) || !daft_shape_raycast(&k->shapes[s].shape, daft_rigid_to_local(&frame, o),
                                                        daft_rigid_to_local_vector(&frame, d), 1, &r))
                continue;
            uint32_t at = count++;
            for (; at > 0 && r.t < out[at - 1].t; at--) out[at] = out[at - 1];
            out[at] = (slow_hit){k->body, s, r.t};
        }
    return count;
}

static void check_rays(daft_dvec3 centre, double tolerance)
{
    zoo z;
    make_zoo(&z, centre, 6);
    uint32_t met = 0;
    for (int i = 0; i < RAYS; i++) {
        daft_dvec3 o, d;
        random_way(&z, &o, &d);
        if (i % 8 == 0) d = daft_dscale(d, 0.2);
        if (i % 9 == 0) d.x = 0;
        if (i % 10 == 0) d = daft_dv3(0, -30, 0);
        daft_sim_filter f = random_filter(i);
        slow_hit slow[2 * BODIES];
        daft_sim_hit hits[2 * BODIES], few[3], nearest;
        uint32_t count = slow_rays(&z, o, d, &f, slow);
        assert_int_equal(daft_world_cast_ray_all(z.world, o, d, &f, hits, 2 * BODIES), count);
        for (uint32_t k = 0; k < count; k++) {
            assert_near(hits[k].fraction, slow[k].t, tolerance);
            assert_near(fabs((double)daft_length(hits[k].normal)), 1, 1e-5);
            assert_true(daft_ddot(daft_to_double(hits[k].normal), d) <= 1e-6 * sqrt(daft_ddot(d, d)));
            if (k > 0) assert_true(hits[k].distance >= hits[k - 1].distance);
            daft_dvec3 off = daft_dsub(hits[k].point, daft_dadd(o, daft_dscale(d, hits[k].fraction)));
            assert_true(daft_ddot(off, off) < 1e-12);
        }
        /* A list that is too short holds the first ones of the whole list. */
        assert_int_equal(daft_world_cast_ray_all(z.world, o, d, &f, few, 3), count);
        for (uint32_t k = 0; k < count && k < 3; k++) assert_memory_equal(&few[k].body, &hits[k].body, 16);
        assert_int_equal(daft_world_cast_ray(z.world, o, d, &f, &nearest), count > 0);
        assert_int_equal(daft_world_is_blocked(z.world, o, d, &f), count > 0);
        if (count == 0) continue;
        met++;
        assert_int_equal(nearest.body, hits[0].body);
        assert_int_equal(nearest.shape, hits[0].shape);
        assert_true(nearest.fraction == hits[0].fraction);
        assert_int_equal(nearest.user, nearest.body - 1);
        assert_int_equal(nearest.shape_user, 10 * nearest.user + nearest.shape);
    }
    assert_true(met > RAYS / 3);
    drop_zoo(&z);
}

static void rays_meet_what_all_bodies_say(void **state)
{
    (void)state;
    check_rays(daft_dv3(0, 0, 0), 1e-12);
}

static void rays_are_as_good_far_away(void **state)
{
    (void)state;
    check_rays(daft_dv3(1e7, -1e7, 1e7), 1e-8);
}

/* The same mesh for the renderer: an exact two-level tree in floats. */
static void rays_agree_with_the_renderer(void **state)
{
    (void)state;
    daft_world *world = new_world();
    daft_error error = {0};
    fixture_seed(3);
    fixture_mesh ball = mesh_ball(40, 1, 0.1f);
    daft_mesh_shape *mesh = daft_mesh_shape_create(&heap, &ball.mesh, ball.bvh, true, &error);
    one_shape def = body_def(DAFT_BODY_STATIC, daft_dv3(0, 0, 0));
    def.part.shape = daft_shape_mesh(mesh);
    add(world, def);
    daft_instance instance = {.mesh = &ball.mesh, .bvh = ball.bvh, .materials = FIXTURE_MATERIAL};
    for (int i = 0; i < 3; i++) instance.to_frame.m[4 * i] = instance.to_object.m[4 * i] = 1;
    daft_instance_bound(&instance);
    daft_arena arena;
    daft_arena_init(&arena, &heap);
    const daft_tlas *tlas = daft_tlas_build(&arena, &instance, 1, &error);
    const daft_accel_kernels *kernels = daft_accel_kernels_for(daft_isa_best());
    daft_sim_filter filter = daft_default_sim_filter();
    uint32_t met = 0, same = 0;
    for (int i = 0; i < 4000; i++) {
        daft_vec3 from = random_vec3(-2, 2), to = random_vec3(-1, 1);
        daft_ray ray = {from, 0, daft_scale(daft_sub(to, from), 2), 1};
        daft_hit drawn;
        daft_sim_hit hit;
        bool seen = kernels->closest(tlas, &ray, UINT32_MAX, &drawn);
        assert_int_equal(daft_world_cast_ray(world, daft_to_double(from), daft_to_double(ray.direction), &filter, &hit),
                         seen);
        if (!seen) continue;
        met++;
        same += hit.triangle == drawn.triangle; /* through an edge it may be either */
        assert_near(hit.fraction, (double)drawn.t, 1e-6);
        daft_vec3 n = daft_normalize(drawn.normal);
        if (hit.triangle == drawn.triangle) assert_near(fabs((double)daft_dot(n, hit.normal)), 1, 1e-5);
    }
    assert_true(met > 2000 && same + met / 500 >= met);
    daft_arena_free(&arena);
    daft_world_destroy(world);
    daft_mesh_shape_free(mesh);
    mesh_drop(&ball);
}

/* ---- shapes ---- */

static void check_casts(daft_dvec3 centre, double tolerance)
{
    zoo z;
    make_zoo(&z, centre, 6);
    uint32_t met = 0, inside = 0;
    for (int i = 0; i < 200; i++) {
        daft_sim_shape shape = i % 5 == 4 ? daft_shape_compound(z.compound) : random_convex(&z, i % 5);
        daft_dvec3 o, d;
        random_way(&z, &o, &d);
        if (i % 3 == 0) o = daft_dadd(z.centre, random_in(-4, 4));
        daft_quat turn = random_turn();
        daft_sim_filter f = random_filter(i);
        daft_rigid at = daft_rigid_make(o, turn);
        double least = INFINITY;
        for (int b = 0; b < BODIES; b++)
            for (uint32_t s = 0; s < z.known[b].shape_count; s++) {
                daft_rigid frame = frame_now(&z, &z.known[b], s), relative = daft_rigid_relative(&frame, &at);
                daft_impact impact;
                if (!passes(&z.known[b], s, &f)) continue;
                daft_impact_kind kind = daft_shape_cast(&shape, &relative, daft_rigid_to_local_vector(&frame, d),
                                                        &z.known[b].shapes[s].shape, &impact);
                if (kind == DAFT_IMPACT_OVERLAP) least = 0;
                if (kind == DAFT_IMPACT_HIT && impact.t < least) least = impact.t;
            }
        daft_sim_hit hit;
        bool any = daft_world_cast_shape(z.world, &shape, o, turn, d, &f, &hit);
        assert_int_equal(any, least <= 1);
        if (!any) continue;
        met++;
        inside += hit.inside;
        assert_near(hit.fraction, least, tolerance);
        if (!hit.inside) assert_true(daft_ddot(daft_to_double(hit.normal), d) < 0);
        /* A body that was met is not overlapped shortly before. */
        daft_sim_hit over[BODIES];
        daft_dvec3 before = daft_dadd(o, daft_dscale(d, hit.fraction - 1e-4));
        uint32_t count = daft_world_overlap(z.world, &shape, before, turn, &f, over, BODIES);
        if (!hit.inside && hit.fraction > 1e-4) assert_int_equal(count, 0);
    }
    assert_true(met > 60 && inside > 10);
    drop_zoo(&z);
}

static void casts_meet_what_all_bodies_say(void **state)
{
    (void)state;
    check_casts(daft_dv3(0, 0, 0), 1e-9);
}

static void casts_are_as_good_far_away(void **state)
{
    (void)state;
    check_casts(daft_dv3(-1e7, 1e7, 1e7), 1e-6);
}

static void overlaps_are_those_of_all_bodies(void **state)
{
    (void)state;
    zoo z;
    make_zoo(&z, daft_dv3(50, 0, 0), 6);
    uint32_t total = 0;
    for (int i = 0; i < 200; i++) {
        daft_sim_shape shape = random_convex(&z, i % 4);
        daft_dvec3 o = daft_dadd(z.centre, random_in(-5, 5)), zero = {0, 0, 0};
        daft_quat turn = random_turn();
        daft_sim_filter f = random_filter(i);
        daft_sim_hit hits[2 * BODIES];
        uint32_t count = daft_world_overlap(z.world, &shape, o, turn, &f, hits, 2 * BODIES), found = 0;
        daft_rigid at = daft_rigid_make(o, turn);
        for (int b = 0; b < BODIES; b++)
            for (uint32_t s = 0; s < z.known[b].shape_count; s++) {
                daft_rigid frame = frame_now(&z, &z.known[b], s), relative = daft_rigid_relative(&at, &frame);
                if (!passes(&z.known[b], s, &f) ||
                    !daft_shape_overlap(&shape, &z.known[b].shapes[s].shape, &relative, 0))
                    continue;
                assert_true(found < count); /* bodies are in the order of their numbers here */
                assert_int_equal(hits[found].body, z.known[b].body);
                assert_int_equal(hits[found].shape, s);
                found++;
            }
        assert_int_equal(found, count);
        assert_int_equal(daft_world_cast_shape(z.world, &shape, o, turn, zero, &f, NULL), count > 0);
        total += count;
    }
    assert_true(total > 100);
    drop_zoo(&z);
}

static void the_closest_point_is_that_of_all_bodies(void **state)
{
    (void)state;
    zoo z;
    make_zoo(&z, daft_dv3(0, 1e6, 0), 6);
    uint32_t met = 0;
    for (int i = 0; i < 300; i++) {
        daft_dvec3 p = daft_dadd(z.centre, random_in(-10, 10));
        daft_sim_filter f = random_filter(i);
        double limit = i % 3 == 0 ? 1 : i % 3 == 1 ? 5 : INFINITY, least = INFINITY;
        for (int b = 0; b < BODIES; b++)
            for (uint32_t s = 0; s < z.known[b].shape_count; s++) {
                daft_rigid frame = frame_now(&z, &z.known[b], s);
                daft_dvec3 on;
                double distance;
                daft_shape_part part;
                if (passes(&z.known[b], s, &f) &&
                    daft_shape_closest(&z.known[b].shapes[s].shape, daft_rigid_to_local(&frame, p), 100, &on, &distance,
                                       &part) &&
                    distance < least)
                    least = distance;
            }
        daft_sim_hit hit;
        bool any = daft_world_closest(z.world, p, limit, &f, &hit);
        assert_int_equal(any, least <= limit);
        if (!any) continue;
        met++;
        assert_near(hit.distance, least, 1e-9);
        daft_dvec3 off = daft_dsub(p, hit.point);
        assert_near(sqrt(daft_ddot(off, off)), hit.distance, 1e-6);
        if (hit.distance > 1e-3) assert_near(daft_ddot(off, daft_to_double(hit.normal)), hit.distance, 1e-6);
    }
    assert_true(met > 150);
    drop_zoo(&z);
}

/* ---- bad input, no effect ---- */

static void bad_numbers_meet_nothing(void **state)
{
    (void)state;
    zoo z;
    make_zoo(&z, daft_dv3(0, 0, 0), 3);
    daft_sim_filter f = daft_default_sim_filter();
    daft_dvec3 zero = {0, 0, 0}, down = {0, -100, 0};
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e300};
    daft_sim_shape ball = random_convex(&z, 0), none = {0}, mesh = daft_shape_mesh(z.mesh);
    daft_quat still = {0, 0, 0, 1}, broken = {NAN, 0, 0, 1};
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++) {
        daft_dvec3 v = {0, bad[i], 0};
        assert_false(daft_world_cast_ray(z.world, v, down, &f, NULL));
        assert_false(daft_world_cast_ray(z.world, daft_dv3(0, 50, 0), v, &f, NULL));
        assert_false(daft_world_cast_shape(z.world, &ball, zero, still, v, &f, NULL));
        assert_int_equal(daft_world_cast_ray_all(z.world, v, down, &f, NULL, 0), 0);
        assert_false(daft_world_is_blocked(z.world, v, down, &f));
        assert_false(daft_world_cast_shape(z.world, &ball, v, still, down, &f, NULL));
        assert_false(daft_world_closest(z.world, v, 10, &f, NULL));
        assert_int_equal(daft_world_overlap(z.world, &ball, v, still, &f, NULL, 0), 0);
    }
    assert_false(daft_world_cast_ray(z.world, zero, zero, &f, NULL));
    assert_false(daft_world_cast_shape(z.world, &ball, zero, broken, down, &f, NULL));
    assert_false(daft_world_cast_shape(z.world, &none, zero, still, down, &f, NULL));
    assert_false(daft_world_cast_shape(z.world, &mesh, zero, still, down, &f, NULL));
    assert_false(daft_world_closest(z.world, zero, NAN, &f, NULL));
    assert_false(daft_world_closest(z.world, zero, -1, &f, NULL));
    drop_zoo(&z);
}

static void an_empty_world_meets_nothing(void **state)
{
    (void)state;
    daft_world *world = new_world();
    daft_sim_filter f = daft_default_sim_filter();
    assert_false(daft_world_cast_ray(world, daft_dv3(0, 0, 0), daft_dv3(0, -1, 0), &f, NULL));
    assert_false(daft_world_closest(world, daft_dv3(0, 0, 0), INFINITY, &f, NULL));
    daft_world_destroy(world);
}

static void asking_changes_nothing(void **state)
{
    (void)state;
    uint64_t hash[2];
    for (int asks = 0; asks < 2; asks++) {
        zoo z;
        make_zoo(&z, daft_dv3(0, 0, 0), 3);
        daft_sim_filter f = daft_default_sim_filter();
        for (int i = 0; i < 60; i++) {
            daft_sim_hit hit;
            if (asks) daft_world_cast_ray(z.world, daft_dv3(0, 9, 0), daft_dv3(0.1 * i - 3, -20, 1), &f, &hit);
            if (asks) daft_world_closest(z.world, daft_dv3(0, 0.1 * i, 0), 5, &f, &hit);
            steps(z.world, 1);
        }
        hash[asks] = daft_world_hash(z.world, 1);
        drop_zoo(&z);
    }
    assert_true(hash[0] == hash[1]);
}

/* Bodies that a hit threw out of the bounds the trees have for them are found where they are. */
static void what_was_thrown_is_found(void **state)
{
    (void)state;
    daft_world *world = new_world();
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    uint32_t rests = add(world, sphere(0.1, 0, 0, 0));
    one_shape heavy = sphere(0.5, -2, 0, 0);
    heavy.density = 10000;
    heavy.bullet = true;
    uint32_t hammer = add(world, heavy);
    daft_world_set_velocity(world, hammer, daft_v3(60, 0, 0), daft_v3(0, 0, 0));
    daft_sim_filter f = daft_default_sim_filter();
    f.ignore = hammer;
    for (int i = 0; i < 20; i++) {
        steps(world, 1);
        daft_dvec3 p = state_of(world, rests).position;
        daft_sim_hit hit;
        assert_true(daft_world_cast_ray(world, daft_dv3(p.x, 5, p.z), daft_dv3(0, -10, 0), &f, &hit));
        assert_int_equal(hit.body, rests);
        assert_near(hit.point.y, p.y + 0.1, 1e-6);
        assert_int_equal(daft_world_cast_ray_all(world, daft_dv3(p.x, 5, p.z), daft_dv3(0, -10, 0), &f, &hit, 1), 1);
    }
    assert_true(state_of(world, rests).position.x > 10);
    daft_world_destroy(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_meet_what_all_bodies_say),
        cmocka_unit_test(rays_are_as_good_far_away),
        cmocka_unit_test(rays_agree_with_the_renderer),
        cmocka_unit_test(casts_meet_what_all_bodies_say),
        cmocka_unit_test(casts_are_as_good_far_away),
        cmocka_unit_test(overlaps_are_those_of_all_bodies),
        cmocka_unit_test(the_closest_point_is_that_of_all_bodies),
        cmocka_unit_test(bad_numbers_meet_nothing),
        cmocka_unit_test(an_empty_world_meets_nothing),
        cmocka_unit_test(asking_changes_nothing),
        cmocka_unit_test(what_was_thrown_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
