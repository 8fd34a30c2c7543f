/* scene: handles, hierarchy, interpolation, materials, lights, the state hash, ray queries against closed forms, and
 * that no value which is not a number gets in. */
#include "math/real.h"
#include "scene/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

typedef struct fixture {
    daft_engine *engine;
    daft_scene *scene;
    int warnings;
    daft_error last_warning;
} fixture;

static void on_warning(void *user, const daft_error *warning)
{
    fixture *f = user;
    f->warnings++;
    f->last_warning = *warning;
}

static int set_up(void **state)
{
    static fixture f;
    f = (fixture){0};
    daft_engine_def def = daft_default_engine_def();
    def.threads = 2;
    def.warn = on_warning;
    def.warn_user = &f;
    f.engine = daft_engine_create(&def, NULL);
    f.scene = daft_scene_create(f.engine, NULL);
    *state = &f;
    return f.scene ? 0 : -1;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    daft_scene_destroy(f->scene);
    daft_engine_destroy(f->engine);
    return 0;
}

static uint64_t random_state;
static double uniform(double low, double high)
{
    random_state ^= random_state << 13, random_state ^= random_state >> 7, random_state ^= random_state << 17;
    return low + (high - low) * (double)(random_state >> 11) * 0x1p-53;
}
static float uniform_f(double low, double high) { return (float)uniform(low, high); }

static daft_entity make_sphere(daft_scene *scene, double x, double y, double z, float radius, daft_entity parent)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE;
    def.radius = radius;
    def.position = daft_dv3(x, y, z);
    def.parent = parent;
    daft_entity entity = daft_entity_create(scene, &def, NULL);
    assert_true(entity.id != 0);
    return entity;
}

static daft_transform transform_of(daft_scene *scene, daft_entity entity)
{
    daft_transform transform;
    assert_true(daft_entity_get_transform(scene, entity, &transform, NULL));
    return transform;
}

static void move_to(daft_scene *scene, daft_entity entity, double x, bool teleport)
{
    daft_transform transform = transform_of(scene, entity);
    transform.position.x = x;
    assert_true(daft_entity_set_transform(scene, entity, &transform, teleport, NULL));
}

/* ---- handles ---- */

static void stale_handles_are_errors(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_transform transform;
    daft_entity none = {0}, ball = make_sphere(f->scene, 0, 0, 0, 1, none);
    assert_true(daft_entity_is_valid(f->scene, ball));
    assert_false(daft_entity_is_valid(f->scene, none));
    assert_true(daft_entity_destroy(f->scene, ball, &error));
    assert_false(daft_entity_is_valid(f->scene, ball));
    assert_false(daft_entity_destroy(f->scene, ball, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    assert_non_null(strstr(error.message, "stale"));
    assert_false(daft_entity_get_transform(f->scene, ball, &transform, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    daft_entity again = make_sphere(f->scene, 0, 0, 0, 1, none);
    assert_true(again.id != ball.id);
    assert_false(daft_entity_is_valid(f->scene, ball));
    assert_false(daft_entity_set_visible(f->scene, none, true, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    assert_false(daft_entity_set_material(f->scene, again, (daft_material){1000}, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    daft_entity_def def = daft_default_entity_def();
    def.parent = ball;
    assert_int_equal(daft_entity_create(f->scene, &def, &error).id, 0);
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH;
    assert_int_equal(daft_entity_create(f->scene, &def, &error).id, 0);
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
}

/* A slot gives 4,095 handles and is then never used again: no handle comes twice. */
static void handles_never_come_back(void **state)
{
    fixture *f = *state;
    daft_entity_def def = daft_default_entity_def();
    daft_entity first = daft_entity_create(f->scene, &def, NULL), entity = first;
    for (int i = 0; i < 3 * DAFT_MAX_GENERATION; i++) {
        assert_true(daft_entity_destroy(f->scene, entity, NULL));
        entity = daft_entity_create(f->scene, &def, NULL);
        assert_true(entity.id != 0 && entity.id != first.id);
        assert_false(daft_entity_is_valid(f->scene, first));
    }
    assert_int_equal(daft_entity_count(f->scene), 1);
}

static void map_finds_what_it_holds(void **state)
{
    (void)state;
    daft_allocator allocator = daft_malloc_allocator();
    daft_map map = {0};
    for (uint32_t i = 0; i < 1000; i++) {
        assert_true(daft_map_reserve(&map, &allocator, 1));
        daft_map_add(&map, i % 100, i); /* ten values share each hash */
    }
    for (uint32_t i = 0; i < 1000; i += 2) daft_map_remove(&map, i % 100, i);
    for (uint32_t hash = 0; hash < 100; hash++) {
        uint32_t found = 0;
        for (uint32_t cursor = 0, value; (value = daft_map_next(&map, hash, &cursor)) != DAFT_NONE; found++)
            assert_true(value % 100 == hash && value % 2 == 1);
        assert_int_equal(found, hash % 2 ? 10 : 0);
    }
    daft_map_free(&map, &allocator);
}

/* ---- hierarchy ---- */

static float drop(fixture *f, double x, double z)
{
    daft_ray_hit hit;
    daft_error error;
    bool found =
        daft_scene_cast_ray(f->scene, daft_dv3(x, 50, z), daft_v3(0, -1, 0), 100, (daft_entity){0}, &hit, &error);
    assert_int_equal(error.code, DAFT_OK);
    return found ? hit.distance : -1;
}

static void children_follow_their_parent(void **state)
{
    fixture *f = *state;
    daft_entity_def def = daft_default_entity_def(); /* no shape: a mere joint */
    def.position = daft_dv3(10, 0, 0);
    def.rotation = (daft_quat){0, sqrtf(0.5f), 0, sqrtf(0.5f)}; /* a quarter turn about Y: +X goes to -Z */
    def.scale = daft_v3(2, 2, 2);
    daft_entity parent = daft_entity_create(f->scene, &def, NULL);
    daft_entity child = make_sphere(f->scene, 1, 0, 0, 0.5f, parent);
    make_sphere(f->scene, 0, 3, 0, 0.25f, child);
    assert_true(fabsf(drop(f, 10, -2) - 43.5f) < 1e-5f); /* the grandchild's top: y = 6 + 0.5 */
    assert_true(fabsf(drop(f, 10.6, -2) - 49.2f) < 1e-4f); /* beside it the child, radius 1: y = 0.8 */
    assert_true(drop(f, 11, 0) < 0);
    daft_transform local = transform_of(f->scene, child);
    assert_true(local.position.x == 1 && local.position.z == 0);
    assert_true(daft_entity_set_visible(f->scene, parent, false, NULL));
    assert_true(drop(f, 10, -2) < 0); /* a hidden parent hides its children */
    assert_true(daft_entity_set_visible(f->scene, parent, true, NULL));
    assert_true(daft_entity_destroy(f->scene, parent, NULL));
    assert_int_equal(daft_entity_count(f->scene), 0);
    assert_false(daft_entity_is_valid(f->scene, child));
}

/* A chain of 20,000 links is walked without recursion and in linear time; destroying its root takes it all. */
static void deep_chains_are_harmless(void **state)
{
    fixture *f = *state;
    daft_entity root = make_sphere(f->scene, 1, 0, 0, 0.25f, (daft_entity){0}), link = root;
    for (int i = 1; i < 20000; i++) link = make_sphere(f->scene, 1, 0, 0, 0.25f, link);
    assert_true(fabsf(drop(f, 20000, 0) - 49.75f) < 1e-4f);
    assert_true(daft_entity_destroy(f->scene, root, NULL));
    assert_int_equal(daft_entity_count(f->scene), 0);
}

static void siblings_die_alone(void **state)
{
    fixture *f = *state;
    daft_entity parent = make_sphere(f->scene, 0, 0, 0, 1, (daft_entity){0}), child[3];
    for (int i = 0; i < 3; i++) child[i] = make_sphere(f->scene, 10.0 * (i + 1), 0, 0, 1, parent);
    assert_true(daft_entity_destroy(f->scene, child[1], NULL));
    assert_true(daft_entity_is_valid(f->scene, child[0]) && daft_entity_is_valid(f->scene, child[2]));
    assert_true(drop(f, 10, 0) > 0 && drop(f, 20, 0) < 0 && drop(f, 30, 0) > 0);
    assert_true(daft_entity_destroy(f->scene, child[2], NULL));
    assert_true(daft_entity_destroy(f->scene, parent, NULL));
    assert_int_equal(daft_entity_count(f->scene), 0);
}

static void spheres_keep_equal_scales(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_entity_def def = daft_default_entity_def();
    daft_entity parent = daft_entity_create(f->scene, &def, NULL);
    daft_entity joint = (def.parent = parent, daft_entity_create(f->scene, &def, NULL));
    daft_entity ball = make_sphere(f->scene, 0, 0, 0, 1, joint);
    daft_transform squashed = {.rotation = {0, 0, 0, 1}, .scale = {1, 2, 1}};
    uint64_t before = daft_scene_hash(f->scene);
    assert_false(daft_entity_set_transform(f->scene, ball, &squashed, false, &error));
    assert_non_null(strstr(error.message, "1, 2, 1"));
    assert_false(daft_entity_set_transform(f->scene, parent, &squashed, false, &error));
    assert_non_null(strstr(error.message, "sphere"));
    assert_true(daft_scene_hash(f->scene) == before);
    assert_true(daft_entity_destroy(f->scene, ball, NULL));
    assert_true(daft_entity_set_transform(f->scene, parent, &squashed, false, &error));
    def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE;
    def.parent = joint;
    assert_int_equal(daft_entity_create(f->scene, &def, &error).id, 0);
    assert_non_null(strstr(error.message, "ancestor"));
}

static void singular_transforms_are_skipped(void **state)
{
    fixture *f = *state;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX;
    def.scale = daft_v3(1, 0, 1);
    daft_entity flat = daft_entity_create(f->scene, &def, NULL);
    assert_true(flat.id != 0);
    make_sphere(f->scene, 0, -5, 0, 1, (daft_entity){0});
    assert_true(fabsf(drop(f, 0, 0) - 54) < 1e-5f);
    make_sphere(f->scene, 0, 9, 0, 1, (daft_entity){0});
    assert_true(fabsf(drop(f, 0, 0) - 40) < 1e-5f);
    assert_int_equal(f->warnings, 1);
    assert_non_null(strstr(f->last_warning.message, "singular"));
}

static uint32_t flags_from(fixture *f, double x)
{
    daft_arena arena;
    daft_instance *instances;
    uint32_t count;
    daft_arena_init(&arena, f->scene->allocator);
    assert_true(daft_snapshot_instances(f->scene, daft_dv3(x, 0, 0), 1, &arena, &instances, &count, NULL));
    assert_int_equal(count, 1);
    uint32_t flags = instances[0].flags;
    daft_arena_free(&arena);
    return flags;
}

/* Only what is seen from outside is told to cast no shadow on itself. */
static void walls_shadow_rooms(void **state)
{
    fixture *f = *state;
    const daft_shape shapes[] = {DAFT_SHAPE_BOX, DAFT_SHAPE_SPHERE};
    for (int i = 0; i < 2; i++) {
        daft_entity_def def = daft_default_entity_def();
        def.shape = shapes[i];
        def.rotation = (daft_quat){0, 0, sqrtf(0.5f), sqrtf(0.5f)};
        def.size = daft_v3(1, 4, 1);
        def.radius = 2;
        daft_entity entity = daft_entity_create(f->scene, &def, NULL);
        assert_int_equal(flags_from(f, 1.99), DAFT_INSTANCE_CASTS_SHADOW);
        assert_int_equal(flags_from(f, 2), DAFT_INSTANCE_CASTS_SHADOW);
        assert_int_equal(flags_from(f, 2.01), DAFT_INSTANCE_CASTS_SHADOW | DAFT_INSTANCE_CONVEX);
        assert_true(daft_entity_destroy(f->scene, entity, NULL));
    }
}

/* ---- interpolation ---- */

static float drawn_x(fixture *f, float alpha)
{
    daft_arena arena;
    daft_instance *instances;
    uint32_t count;
    daft_arena_init(&arena, f->scene->allocator);
    assert_true(daft_snapshot_instances(f->scene, daft_dv3(0, 0, 0), alpha, &arena, &instances, &count, NULL));
    assert_int_equal(count, 1);
    float x = instances[0].to_frame.t[0];
    daft_arena_free(&arena);
    return x;
}

static void drawing_interpolates(void **state)
{
    fixture *f = *state;
    daft_entity ball = make_sphere(f->scene, 1, 0, 0, 1, (daft_entity){0});
    assert_true(drawn_x(f, 0) == 1 && drawn_x(f, 0.5f) == 1 && drawn_x(f, 1) == 1);
    daft_scene_begin_tick(f->scene);
    move_to(f->scene, ball, 2, false);
    move_to(f->scene, ball, 3, false); /* twice in a tick: still from the last tick's pose */
    assert_true(drawn_x(f, 0) == 1 && drawn_x(f, 0.5f) == 2 && drawn_x(f, 1) == 3);
    float last = 1;
    for (int i = 1; i <= 1000; i++) {
        float x = drawn_x(f, (float)i / 1000);
        assert_true(x >= last && x <= 3);
        last = x;
    }
    daft_scene_begin_tick(f->scene);
    assert_true(drawn_x(f, 0) == 3 && drawn_x(f, 1) == 3); /* it rests in this tick */
    move_to(f->scene, ball, 50, true);
    assert_true(drawn_x(f, 0) == 50 && drawn_x(f, 0.5f) == 50);
    move_to(f->scene, ball, 60, false); /* a move after a teleport starts where that ended */
    assert_true(drawn_x(f, 0) == 50 && drawn_x(f, 1) == 60);
}

static void camera_interpolates(void **state)
{
    fixture *f = *state;
    daft_camera camera = daft_default_camera();
    camera.yaw = 3.1f;
    assert_true(daft_scene_set_camera(f->scene, &camera, true, NULL));
    daft_scene_begin_tick(f->scene);
    camera.yaw = -3.1f; /* 0.083 rad further, across the back */
    camera.position.x = 2;
    assert_true(daft_scene_set_camera(f->scene, &camera, false, NULL));
    daft_camera half = daft_scene_camera(f->scene, 0.5f);
    assert_true(half.position.x == 1);
    assert_true(fabs((double)half.yaw - DAFT_PI) < 1e-6);
    assert_true(daft_scene_camera(f->scene, 0).yaw == 3.1f);
    assert_true(daft_scene_camera(f->scene, 1).yaw == -3.1f);
    assert_true(daft_scene_set_camera(f->scene, &camera, true, NULL));
    assert_true(daft_scene_camera(f->scene, 0).position.x == 2);
}

static void axes_follow_the_convention(void **state)
{
    (void)state;
    daft_vec3 right, up, forward;
    daft_camera camera = daft_default_camera();
    daft_camera_axes(&camera, &right, &up, &forward);
    assert_true(forward.x == 1 && up.y == 1 && right.z == 1);
    camera.yaw = (float)(DAFT_PI / 2);
    daft_camera_axes(&camera, &right, &up, &forward);
    assert_true(fabsf(forward.z - 1) < 1e-6f && fabsf(right.x + 1) < 1e-6f);
    camera = (daft_camera){.pitch = 0.5f, .fov = 1};
    daft_camera_axes(&camera, &right, &up, &forward);
    assert_true(forward.y < -0.4f && up.x > 0.4f);
    camera = (daft_camera){.roll = 0.5f, .fov = 1};
    daft_camera_axes(&camera, &right, &up, &forward);
    assert_true(up.z > 0.4f && right.y < -0.4f); /* the head leans to the right */
    camera = daft_camera_look_at(daft_dv3(1, 2, 3), daft_dv3(4, -2, 7), 1);
    daft_camera_axes(&camera, &right, &up, &forward);
    daft_vec3 want = daft_normalize(daft_v3(3, -4, 4));
    assert_true(daft_length(daft_sub(forward, want)) < 1e-6f);
    assert_true(daft_camera_look_at(daft_dv3(1, 2, 3), daft_dv3(1, 2, 3), 1).yaw == 0);
}

/* ---- ray queries against closed forms ---- */

typedef struct pose {
    daft_dvec3 position;
    daft_quat rotation;
    double scale[3];
} pose;

static daft_quat random_quat(void)
{
    return daft_quat_normalize((daft_quat){uniform_f(-1, 1), uniform_f(-1, 1), uniform_f(-1, 1), uniform_f(-1, 1)});
}

/* v turned by q, or back, in double. */
static daft_dvec3 turn(daft_quat q, daft_dvec3 v, bool back)
{
    double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = back ? -(double)q.w : (double)q.w;
    double n = x * x + y * y + z * z + w * w;
    daft_dvec3 u = daft_dv3(x, y, z), t = daft_dscale(daft_dcross(u, v), 2 / n);
    return daft_dadd(v, daft_dadd(daft_dscale(t, w), daft_dcross(u, t)));
}

static daft_dvec3 to_local(const pose *p, daft_dvec3 v, bool point)
{
    daft_dvec3 r = turn(p->rotation, point ? daft_dsub(v, p->position) : v, true);
    return daft_dv3(r.x / p->scale[0], r.y / p->scale[1], r.z / p->scale[2]);
}

/* Distance to an axis-aligned box around the origin; negative: a miss. */
static double slab(daft_dvec3 origin, daft_dvec3 direction, daft_vec3 size)
{
    double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    double half[3] = {(double)size.x / 2, (double)size.y / 2, (double)size.z / 2}, near = -INFINITY, far = INFINITY;
    for (int i = 0; i < 3; i++) {
        double a = (-half[i] - o[i]) / d[i], b = (half[i] - o[i]) / d[i];
        near = fmax(near, fmin(a, b)), far = fmin(far, fmax(a, b));
    }
    if (near > far || far < 0) return -1;
    return near >= 0 ? near : far;
}

static daft_dvec3 near_by(daft_dvec3 center, double distance)
{
    daft_dvec3 off = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    return daft_dadd(center, daft_dscale(off, distance));
}

/* A turned and stretched box under a turned parent, rays at it and past it: `offset` moves everything along. */
static void check_boxes(fixture *f, double offset, double scale)
{
    daft_entity_def def = daft_default_entity_def();
    pose outer = {daft_dv3(offset + scale * uniform(-2, 2), scale * uniform(-2, 2), offset), random_quat(), {2, 2, 2}};
    pose inner = {daft_dv3(scale * uniform(-1, 1), scale, 0), random_quat(), {uniform(0.5, 2), uniform(0.5, 2), -1}};
    def.position = outer.position, def.rotation = outer.rotation, def.scale = daft_v3(2, 2, 2);
    daft_entity parent = daft_entity_create(f->scene, &def, NULL);
    for (int i = 0; i < 3; i++) inner.scale[i] = (double)(float)inner.scale[i];
    def.parent = parent, def.position = inner.position, def.rotation = inner.rotation;
    def.scale = daft_v3((float)inner.scale[0], (float)inner.scale[1], (float)inner.scale[2]);
    def.shape = DAFT_SHAPE_BOX;
    def.size = daft_v3(uniform_f(0.5, 2) * (float)scale, uniform_f(0.5, 2) * (float)scale, (float)scale);
    daft_entity box = daft_entity_create(f->scene, &def, NULL);
    assert_true(box.id != 0);
    daft_dvec3 center = daft_dadd(outer.position, daft_dscale(turn(outer.rotation, inner.position, false), 2));
    int hits = 0, grazes = 0; /* rays along an edge, which floats may see otherwise */
    for (int i = 0; i < 300; i++) {
        daft_dvec3 from = near_by(center, 9 * scale), to = near_by(center, 2 * scale);
        daft_vec3 direction = daft_to_float(daft_dsub(to, from));
        daft_dvec3 unit = daft_to_double(direction);
        unit = daft_dscale(unit, 1 / sqrt(daft_ddot(unit, unit)));
        daft_dvec3 o = to_local(&outer, from, true), d = to_local(&outer, unit, false);
        double want = slab(to_local(&inner, o, true), to_local(&inner, d, false), def.size);
        daft_ray_hit hit;
        daft_error error;
        if (!daft_scene_cast_ray(f->scene, from, direction, INFINITY, (daft_entity){0}, &hit, &error)) {
            assert_int_equal(error.code, DAFT_OK);
            grazes += want >= 0;
            continue;
        }
        grazes += want < 0;
        if (want < 0) continue;
        hits++;
        assert_int_equal(hit.entity.id, box.id);
        assert_true(fabs((double)hit.distance - want) <= 1e-5 * (want + scale));
        assert_true(daft_ddot(daft_to_double(hit.normal), unit) < 0);
        daft_dvec3 at = daft_dadd(from, daft_dscale(unit, want));
        daft_dvec3 off = daft_dsub(hit.position, at);
        assert_true(sqrt(daft_ddot(off, off)) <= 1e-5 * (want + scale));
    }
    if (hits <= 40 || grazes > 1) fail_msg("%d hits, %d grazes at offset %g, scale %g", hits, grazes, offset, scale);
    assert_true(daft_entity_destroy(f->scene, parent, NULL));
}

static void rays_meet_boxes(void **state)
{
    random_state = 20240611;
    print_message("seed %llu\n", (unsigned long long)random_state);
    for (int i = 0; i < 20; i++) check_boxes(*state, 0, 1);
    for (int i = 0; i < 5; i++) check_boxes(*state, 1e7, 1);
    for (int i = 0; i < 5; i++) check_boxes(*state, 0, 1e-4);
    for (int i = 0; i < 5; i++) check_boxes(*state, 0, 1e4);
}

/* Exactly the same distances 10,000 km away: the tree is rebased, the last word is in double. */
static void far_is_as_good_as_near(void **state)
{
    fixture *f = *state;
    daft_error error;
    const double far = 16777216; /* positions below are exact there and at 0 */
    for (int i = 0; i < 3; i++) {
        double x = i * far;
        make_sphere(f->scene, x + 3, 0.25, -x, 0.5f, (daft_entity){0});
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_BOX;
        def.position = daft_dv3(x, 0, -x + 3);
        assert_true(daft_entity_create(f->scene, &def, NULL).id != 0);
    }
    daft_vec3 directions[] = {{1, 0, 0}, {1, 0.125f, 0.0625f}, {0, 0, 1}, {0.0625f, 0.03125f, 1}};
    for (size_t d = 0; d < DAFT_COUNT_OF(directions); d++) {
        daft_ray_hit near;
        assert_true(
            daft_scene_cast_ray(f->scene, daft_dv3(0, 0, 0), directions[d], 10, (daft_entity){0}, &near, &error));
        for (int i = 1; i < 3; i++) {
            daft_ray_hit hit;
            daft_dvec3 from = daft_dv3(i * far, 0, -i * far);
            assert_true(daft_scene_cast_ray(f->scene, from, directions[d], 10, (daft_entity){0}, &hit, &error));
            assert_true(hit.distance == near.distance && hit.triangle == near.triangle);
            assert_true(hit.normal.x == near.normal.x && hit.normal.y == near.normal.y);
        }
    }
}

static void rays_meet_spheres(void **state)
{
    fixture *f = *state;
    daft_ray_hit hit;
    daft_error error;
    daft_entity none = {0}, small = make_sphere(f->scene, 5, 0, 0, 1, none),
                big = make_sphere(f->scene, 0, 0, 0, 100, none);
    daft_dvec3 origin = daft_dv3(0, 0, 0);
    assert_true(daft_scene_cast_ray(f->scene, origin, daft_v3(3, 0, 0), 100, none, &hit, &error));
    assert_true(hit.entity.id == small.id && fabsf(hit.distance - 4) < 1e-6f && hit.normal.x == -1);
    assert_true(fabs(hit.position.x - 4) < 1e-12);
    assert_true(daft_scene_cast_ray(f->scene, origin, daft_v3(3, 0, 0), 101, small, &hit, &error));
    assert_true(hit.entity.id == big.id && fabsf(hit.distance - 100) < 1e-5f && hit.normal.x == -1); /* from inside */
    assert_true(fabsf(hit.uv.x - 0.5f) < 1e-6f && fabsf(hit.uv.y - 0.5f) < 1e-6f);
    assert_false(daft_scene_cast_ray(f->scene, origin, daft_v3(1, 0, 0), 3.999f, none, &hit, &error));
    assert_int_equal(error.code, DAFT_OK);
    assert_true(daft_scene_cast_ray(f->scene, origin, daft_v3(1, 0, 0), 4.0f, none, &hit, &error));
    assert_true(daft_entity_set_visible(f->scene, small, false, NULL));
    assert_true(daft_scene_cast_ray(f->scene, origin, daft_v3(1, 0, 0), INFINITY, none, &hit, &error));
    assert_true(hit.entity.id == big.id);
    assert_int_equal(daft_scene_counters(f->scene)->query_rays, 5);
    assert_true(daft_entity_destroy(f->scene, small, NULL));
    assert_false(daft_scene_cast_ray(f->scene, origin, daft_v3(1, 0, 0), 1, small, &hit, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
}

static void rays_meet_meshes(void **state)
{
    fixture *f = *state;
    const daft_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
    const daft_vec2 uvs[] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const uint32_t indices[] = {0, 1, 2, 0, 3, 1};
    daft_mesh_def mesh_def = daft_default_mesh_def();
    mesh_def.positions = positions, mesh_def.uvs = uvs, mesh_def.vertex_count = 4;
    mesh_def.indices = indices, mesh_def.triangle_count = 2;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH;
    def.mesh = daft_mesh_create(f->scene, &mesh_def, NULL);
    def.scale = daft_v3(4, 4, 4);
    daft_entity entity = daft_entity_create(f->scene, &def, NULL);
    assert_true(entity.id != 0);
    daft_ray_hit hit;
    assert_true(daft_scene_cast_ray(f->scene, daft_dv3(1, 3, 2), daft_v3(0, -2, 0), 10, (daft_entity){0}, &hit, NULL));
    assert_true(hit.entity.id == entity.id && hit.triangle == 0 && hit.distance == 3 && hit.normal.y == 1);
    assert_true(fabsf(hit.uv.x - 0.25f) < 1e-6f && fabsf(hit.uv.y - 0.5f) < 1e-6f);
    assert_true(daft_scene_cast_ray(f->scene, daft_dv3(1, 1, -7), daft_v3(0, 0, 1), 10, (daft_entity){0}, &hit, NULL));
    assert_true(hit.triangle == 1 && hit.distance == 7 && hit.normal.z == -1);
    daft_mesh_info info;
    assert_true(daft_mesh_get_info(f->scene, def.mesh, &info, NULL));
    assert_true(info.triangle_count == 2 && info.vertex_count == 4 && info.material_count == 1 && info.bytes > 0);
    assert_true(info.high.x == 1 && info.low.x == 0);
}

static void moved_vertices_are_seen(void **state)
{
    fixture *f = *state;
    daft_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
    const uint32_t indices[] = {0, 1, 2};
    daft_mesh_def mesh_def = daft_default_mesh_def();
    mesh_def.positions = positions, mesh_def.vertex_count = 3;
    mesh_def.indices = indices, mesh_def.triangle_count = 1;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH;
    def.mesh = daft_mesh_create(f->scene, &mesh_def, NULL);
    assert_true(daft_entity_create(f->scene, &def, NULL).id != 0);
    const daft_vec3 normals[] = {{0, 2, 0}, {0, 2, 0}, {0, 2, 0}};
    daft_ray_hit hit;
    for (int i = 1; i <= 4; i++) {
        for (int k = 0; k < 3; k++) positions[k].y = (float)i;
        assert_true(daft_mesh_set_positions(f->scene, def.mesh, positions, i % 2 ? normals : NULL, 3, NULL));
        assert_true(daft_scene_cast_ray(f->scene, daft_dv3(0.2, 10, 0.2), daft_v3(0, -1, 0), 20, (daft_entity){0}, &hit, NULL));
        assert_true(hit.position.y == i);
        assert_true(daft_scene_counters(f->scene)->mesh_refits == (uint64_t)i);
    }
    assert_int_equal(daft_scene_counters(f->scene)->mesh_builds, 1);
    daft_error error;
    assert_false(daft_mesh_set_positions(f->scene, def.mesh, positions, NULL, 2, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    positions[1].x = NAN;
    assert_false(daft_mesh_set_positions(f->scene, def.mesh, positions, NULL, 3, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_false(daft_mesh_set_positions(f->scene, (daft_mesh){0}, positions, NULL, 3, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    assert_true(daft_scene_cast_ray(f->scene, daft_dv3(0.2, 10, 0.2), daft_v3(0, -1, 0), 20, (daft_entity){0}, &hit, NULL));
    assert_true(hit.position.y == 4); /* what failed has changed nothing */
}

/* The answer depends on the scene and the ray, not on the rays before it. */
static void queries_have_no_memory(void **state)
{
    fixture *f = *state;
    random_state = 77;
    for (int i = 0; i < 50; i++)
        make_sphere(f->scene, uniform(-5, 5), uniform(-5, 5), uniform(-5, 5), 0.4f, (daft_entity){0});
    daft_ray_hit first[64], again;
    bool found[64];
    for (int round = 0; round < 2; round++)
        for (int n = 0; n < 64; n++) {
            int i = round ? 63 - n : n;
            daft_dvec3 origin = daft_dv3(i * 37.0 - 1000, 20, i * 11.0);
            daft_vec3 direction = daft_to_float(daft_dsub(daft_dv3(i % 7 - 3, i % 5 - 2, i % 3 - 1), origin));
            memset(&again, 0, sizeof again);
            bool hit = daft_scene_cast_ray(f->scene, origin, direction, INFINITY, (daft_entity){0}, &again, NULL);
            if (round == 0) first[i] = again, found[i] = hit;
            assert_true(hit == found[i] && again.distance == first[i].distance &&
                        again.entity.id == first[i].entity.id);
        }
}

/* ---- materials, textures, lights ---- */

static void materials_are_kept(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_material_def def = daft_default_material_def(), back;
    def.mirror = 0.5f;
    def.mirror_tint = daft_v3(1, 0.5f, 0);
    daft_material material = daft_material_create(f->scene, &def, &error);
    assert_true(daft_material_get(f->scene, material, &back, &error));
    assert_memory_equal(&back, &def, sizeof def);
    assert_true(f->scene->assets.surfaces[material.id - 1].mirror.y == 0.25f);
    def.mirror = 1.5f;
    assert_false(daft_material_set(f->scene, material, &def, &error));
    assert_string_equal(error.message, "mirror is 1.5; it must be between 0 and 1");
    def.mirror = 1;
    def.diffuse_map = (daft_texture){7};
    assert_false(daft_material_set(f->scene, material, &def, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    assert_true(daft_material_get(f->scene, material, &back, &error) && back.mirror == 0.5f);
    assert_false(daft_material_get(f->scene, (daft_material){99}, &back, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
}

static void lights_come_and_go(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_light_def def = daft_default_light_def(), back;
    daft_light light = daft_light_create(f->scene, &def, &error);
    def.kind = DAFT_LIGHT_SUN;
    def.direction = daft_v3(0, 0, 0);
    assert_false(daft_light_set(f->scene, light, &def, &error));
    assert_non_null(strstr(error.message, "direction"));
    def.direction = daft_v3(0, -3, 0);
    assert_true(daft_light_set(f->scene, light, &def, &error));
    assert_true(daft_light_get(f->scene, light, &back, &error) && back.kind == DAFT_LIGHT_SUN);
    assert_true(daft_light_destroy(f->scene, light, &error));
    assert_false(daft_light_get(f->scene, light, &back, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    daft_scene_set_ambient(f->scene, daft_v3(NAN, 0, 0));
    daft_scene_set_sky_color(f->scene, daft_v3(0, -1, 0));
    daft_scene_set_sky_gradient(f->scene, daft_v3(0, 0, 0), daft_v3(0, 0, INFINITY));
    daft_scene_set_gravity(f->scene, daft_v3(0, NAN, 0));
    assert_int_equal(f->warnings, 4);
    assert_true(f->scene->ambient.x == 0.2f && f->scene->gravity.y == -9.81f);
}

/* Boxes of one size share a mesh, which goes with the last of them. */
static void boxes_share_their_mesh(void **state)
{
    fixture *f = *state;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX;
    daft_entity boxes[10];
    for (int i = 0; i < 10; i++) boxes[i] = daft_entity_create(f->scene, &def, NULL);
    assert_int_equal(daft_scene_counters(f->scene)->mesh_builds, 1);
    def.size.x = 2;
    assert_true(daft_entity_create(f->scene, &def, NULL).id != 0);
    assert_int_equal(daft_scene_counters(f->scene)->mesh_builds, 2);
    for (int i = 0; i < 10; i++) assert_true(daft_entity_destroy(f->scene, boxes[i], NULL));
    assert_int_equal(f->scene->assets.box_slots.live, 1);
}

/* ---- hash ---- */

static void hash_sees_every_change(void **state)
{
    fixture *f = *state;
    uint64_t seen[16];
    int count = 0;
    daft_light_def light = daft_default_light_def();
    daft_camera camera = daft_default_camera();
    seen[count++] = daft_scene_hash(f->scene);
    daft_entity ball = make_sphere(f->scene, 0, 0, 0, 1, (daft_entity){0});
    seen[count++] = daft_scene_hash(f->scene);
    assert_true(daft_scene_hash(f->scene) == seen[count - 1]);
    move_to(f->scene, ball, 1e-300, false);
    seen[count++] = daft_scene_hash(f->scene);
    assert_true(daft_entity_set_visible(f->scene, ball, false, NULL));
    seen[count++] = daft_scene_hash(f->scene);
    assert_true(daft_entity_set_material(f->scene, ball, (daft_material){1}, NULL));
    seen[count++] = daft_scene_hash(f->scene);
    daft_light lamp = daft_light_create(f->scene, &light, NULL);
    seen[count++] = daft_scene_hash(f->scene);
    light.color.y = 0.5f;
    assert_true(daft_light_set(f->scene, lamp, &light, NULL));
    seen[count++] = daft_scene_hash(f->scene);
    camera.roll = 0.1f;
    assert_true(daft_scene_set_camera(f->scene, &camera, true, NULL));
    seen[count++] = daft_scene_hash(f->scene);
    daft_scene_set_gravity(f->scene, daft_v3(0, -1, 0));
    seen[count++] = daft_scene_hash(f->scene);
    for (int i = 0; i < count; i++)
        for (int j = 0; j < i; j++) assert_true(seen[i] != seen[j]);
    uint64_t now = seen[count - 1];
    daft_scene_begin_tick(f->scene);
    drop(f, 0, 0);
    assert_true(daft_scene_hash(f->scene) == now); /* looking changes nothing */
}

/* ---- bodies ---- */

static daft_entity_def body_def(daft_shape shape, daft_body_kind kind)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = shape;
    def.body = kind;
    return def;
}

static void bodies_say_what_they_may_be(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_entity other = make_sphere(f->scene, 0, 0, 0, 1, (daft_entity){0});
    daft_entity_def bad[] = {body_def(DAFT_SHAPE_BOX, DAFT_BODY_DYNAMIC), body_def(DAFT_SHAPE_NONE, DAFT_BODY_STATIC),
                             body_def(DAFT_SHAPE_SPHERE, DAFT_BODY_DYNAMIC), body_def(DAFT_SHAPE_BOX, DAFT_BODY_STATIC),
                             body_def(DAFT_SHAPE_BOX, (daft_body_kind)9)};
    const char *says[] = {"dynamic body must be a sphere", "the shape is none", "has a parent", "2, 1, 1", "body is 9"};
    bad[2].parent = other;
    bad[3].scale.x = 2;
    uint64_t before = daft_scene_hash(f->scene);
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++) {
        assert_int_equal(daft_entity_create(f->scene, &bad[i], &error).id, 0);
        assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
        assert_non_null(strstr(error.message, says[i]));
    }
    assert_true(daft_scene_hash(f->scene) == before);
    assert_null(f->scene->world); /* no body, no simulation */
    assert_true(daft_scene_step(f->scene, 1.0f / 60, &error));
    assert_null(f->scene->world);
    assert_false(daft_entity_apply_force(f->scene, other, daft_v3(1, 0, 0), &error));
    assert_string_equal(error.message, "the entity has no body");
    assert_false(daft_scene_step(f->scene, 0, &error));
    assert_false(daft_scene_step(f->scene, NAN, &error));
}

static void a_ball_falls_and_rests(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_entity_def def = body_def(DAFT_SHAPE_BOX, DAFT_BODY_STATIC);
    def.size = daft_v3(10, 1, 10);
    def.position.y = -0.5;
    daft_entity floor = daft_entity_create(f->scene, &def, &error);
    def = body_def(DAFT_SHAPE_SPHERE, DAFT_BODY_DYNAMIC);
    def.position.y = 2;
    daft_entity ball = daft_entity_create(f->scene, &def, &error);
    assert_true(floor.id && ball.id);
    daft_vec3 linear;
    for (int i = 0; i < 240; i++) {
        daft_scene_begin_tick(f->scene);
        assert_true(daft_scene_step(f->scene, 1.0f / 60, &error));
    }
    assert_true(fabs(transform_of(f->scene, ball).position.y - 0.5) < 0.01);
    assert_true(daft_entity_get_velocity(f->scene, ball, &linear, NULL, &error) && fabsf(linear.y) < 0.01f);
    daft_contact contact[4];
    assert_int_equal(daft_scene_contacts(f->scene, contact, 4), 1);
    bool ball_first = contact[0].a.id == ball.id;
    assert_int_equal((ball_first ? contact[0].b : contact[0].a).id, floor.id);
    assert_true(fabsf(contact[0].normal.y - (ball_first ? -1.0f : 1.0f)) < 1e-3f);
    assert_true(daft_entity_apply_impulse(f->scene, ball, daft_v3(1000, 0, 0), &error));
    assert_false(daft_entity_apply_impulse(f->scene, floor, daft_v3(1, 0, 0), &error));
    assert_non_null(strstr(error.message, "static"));
    assert_false(daft_entity_apply_force(f->scene, ball, daft_v3(NAN, 0, 0), &error));
    daft_scene_begin_tick(f->scene);
    double before = transform_of(f->scene, ball).position.x;
    assert_true(daft_scene_step(f->scene, 1.0f / 60, &error));
    assert_true(transform_of(f->scene, ball).position.x > before);
    assert_true(daft_entity_destroy(f->scene, floor, &error));
    assert_int_equal(daft_scene_contacts(f->scene, contact, 4), 0);
    daft_transform scaled = transform_of(f->scene, ball);
    scaled.scale = daft_v3(2, 2, 2);
    assert_false(daft_entity_set_transform(f->scene, ball, &scaled, false, &error));
    assert_non_null(strstr(error.message, "body"));
}

/* A kinematic body goes where it is put, or on at the velocity it was given; a static one has none. */
static void kinematic_bodies_move(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_vec3 none = {0, 0, 0}, linear;
    daft_entity_def def = body_def(DAFT_SHAPE_BOX, DAFT_BODY_KINEMATIC);
    daft_entity lift = daft_entity_create(f->scene, &def, &error);
    def.body = DAFT_BODY_STATIC;
    daft_entity wall = (def.position.x = 50, daft_entity_create(f->scene, &def, &error));
    daft_scene_begin_tick(f->scene);
    move_to(f->scene, lift, 0.5, false);
    assert_true(daft_scene_step(f->scene, 1.0f / 60, &error));
    assert_true(transform_of(f->scene, lift).position.x == 0.5);
    assert_true(daft_entity_set_velocity(f->scene, lift, daft_v3(0, 6, 0), none, &error));
    for (int i = 0; i < 60; i++) {
        daft_scene_begin_tick(f->scene);
        assert_true(daft_scene_step(f->scene, 1.0f / 60, &error));
    }
    assert_true(fabs(transform_of(f->scene, lift).position.y - 6) < 1e-4);
    assert_true(daft_entity_get_velocity(f->scene, lift, &linear, NULL, &error) && linear.y == 6);
    assert_false(daft_entity_set_velocity(f->scene, wall, linear, none, &error));
    assert_string_equal(error.message, "the entity's body is static; it must be dynamic or kinematic");
    assert_false(daft_entity_apply_impulse(f->scene, lift, linear, &error));
    daft_transform far = transform_of(f->scene, wall);
    far.position.z = 1e13;
    assert_false(daft_entity_set_transform(f->scene, wall, &far, true, &error));
    assert_non_null(strstr(error.message, "position.z is 1e+13"));
}

static void bodies_die_with_their_entities(void **state)
{
    fixture *f = *state;
    daft_entity balls[20];
    daft_entity_def def = body_def(DAFT_SHAPE_SPHERE, DAFT_BODY_DYNAMIC);
    for (int i = 0; i < 20; i++) {
        def.position = daft_dv3(3 * i, 0, 0);
        balls[i] = daft_entity_create(f->scene, &def, NULL);
    }
    for (int i = 0; i < 20; i += 3) assert_true(daft_entity_destroy(f->scene, balls[i], NULL));
    daft_scene_begin_tick(f->scene);
    assert_true(daft_scene_step(f->scene, 1.0f / 60, NULL));
    for (int i = 0; i < 20; i++) {
        if (i % 3 == 0) continue;
        daft_transform transform = transform_of(f->scene, balls[i]);
        assert_true(transform.position.y < 0 && transform.position.x == 3 * i);
    }
}

/* ---- no value that is not a number gets in ---- */

static const double BAD[] = {NAN, INFINITY, -INFINITY};

#define FLOATS(count) (count), sizeof(float)
#define DOUBLES(count) (count), sizeof(double)
typedef struct field {
    const char *name;
    size_t offset, count, size;
} field;

static void put(void *def, const field *at, size_t i, double value)
{
    char *target = (char *)def + at->offset + i * at->size;
    float narrow = (float)value;
    memcpy(target, at->size == sizeof(float) ? (void *)&narrow : (void *)&value, at->size);
}

typedef bool try_def(fixture *f, const void *def, daft_error *error);

/* Puts each bad value into each number of the definition in turn. */
static void check_fields(fixture *f, const void *good, size_t size, const field *fields, size_t count, try_def *try)
{
    daft_error error;
    char def[512];
    assert_true(size <= sizeof def);
    uint64_t before = daft_scene_hash(f->scene);
    uint32_t entities = daft_entity_count(f->scene);
    for (size_t n = 0; n < count; n++)
        for (size_t i = 0; i < fields[n].count; i++)
            for (size_t b = 0; b < DAFT_COUNT_OF(BAD); b++) {
                memcpy(def, good, size);
                put(def, &fields[n], i, BAD[b]);
                if (try(f, def, &error)) fail_msg("%s[%zu] = %g was accepted", fields[n].name, i, BAD[b]);
                assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
                if (!strstr(error.message, fields[n].name)) fail_msg("%s: %s", fields[n].name, error.message);
            }
    assert_true(daft_scene_hash(f->scene) == before && daft_entity_count(f->scene) == entities);
}

static bool try_entity(fixture *f, const void *def, daft_error *error)
{
    return daft_entity_create(f->scene, def, error).id != 0;
}
static bool try_material(fixture *f, const void *def, daft_error *error)
{
    return daft_material_create(f->scene, def, error).id != 0;
}
static bool try_light(fixture *f, const void *def, daft_error *error)
{
    return daft_light_create(f->scene, def, error).id != 0;
}
static bool try_camera(fixture *f, const void *def, daft_error *error)
{
    return daft_scene_set_camera(f->scene, def, false, error);
}
static daft_entity tried;
static bool try_transform(fixture *f, const void *def, daft_error *error)
{
    return daft_entity_set_transform(f->scene, tried, def, false, error);
}

static void only_numbers_get_in(void **state)
{
    fixture *f = *state;
    tried = make_sphere(f->scene, 0, 0, 0, 1, (daft_entity){0});
    const field entity_fields[] = {{"radius", offsetof(daft_entity_def, radius), FLOATS(1)},
                                   {"size", offsetof(daft_entity_def, size), FLOATS(3)},
                                   {"position", offsetof(daft_entity_def, position), DOUBLES(3)},
                                   {"rotation", offsetof(daft_entity_def, rotation), FLOATS(4)},
                                   {"scale", offsetof(daft_entity_def, scale), FLOATS(3)},
                                   {"density", offsetof(daft_entity_def, density), FLOATS(1)},
                                   {"friction", offsetof(daft_entity_def, friction), FLOATS(1)},
                                   {"restitution", offsetof(daft_entity_def, restitution), FLOATS(1)},
                                   {"rolling_resistance", offsetof(daft_entity_def, rolling_resistance), FLOATS(1)}};
    for (daft_shape shape = DAFT_SHAPE_NONE; shape <= DAFT_SHAPE_BOX; shape++) {
        if (shape == DAFT_SHAPE_MESH) continue;
        daft_entity_def def = daft_default_entity_def();
        def.shape = shape;
        check_fields(f, &def, sizeof def, entity_fields, DAFT_COUNT_OF(entity_fields), try_entity);
    }
    const field material_fields[] = {{"ambient", offsetof(daft_material_def, ambient), FLOATS(3)},
                                     {"diffuse", offsetof(daft_material_def, diffuse), FLOATS(3)},
                                     {"specular", offsetof(daft_material_def, specular), FLOATS(3)},
                                     {"shininess", offsetof(daft_material_def, shininess), FLOATS(1)},
                                     {"mirror", offsetof(daft_material_def, mirror), FLOATS(1)},
                                     {"mirror_tint", offsetof(daft_material_def, mirror_tint), FLOATS(3)},
                                     {"emission", offsetof(daft_material_def, emission), FLOATS(3)},
                                     {"map_scale", offsetof(daft_material_def, map_scale), FLOATS(2)}};
    daft_material_def material = daft_default_material_def();
    check_fields(f, &material, sizeof material, material_fields, DAFT_COUNT_OF(material_fields), try_material);
    const field light_fields[] = {{"position", offsetof(daft_light_def, position), DOUBLES(3)},
                                  {"direction", offsetof(daft_light_def, direction), FLOATS(3)},
                                  {"color", offsetof(daft_light_def, color), FLOATS(3)}};
    daft_light_def light = daft_default_light_def();
    check_fields(f, &light, sizeof light, light_fields, DAFT_COUNT_OF(light_fields), try_light);
    const field camera_fields[] = {{"position", offsetof(daft_camera, position), DOUBLES(3)},
                                   {"yaw", offsetof(daft_camera, yaw), FLOATS(1)},
                                   {"pitch", offsetof(daft_camera, pitch), FLOATS(1)},
                                   {"roll", offsetof(daft_camera, roll), FLOATS(1)},
                                   {"fov", offsetof(daft_camera, fov), FLOATS(1)}};
    daft_camera camera = daft_default_camera();
    check_fields(f, &camera, sizeof camera, camera_fields, DAFT_COUNT_OF(camera_fields), try_camera);
    const field transform_fields[] = {{"position", offsetof(daft_transform, position), DOUBLES(3)},
                                      {"rotation", offsetof(daft_transform, rotation), FLOATS(4)},
                                      {"scale", offsetof(daft_transform, scale), FLOATS(3)}};
    daft_transform transform = transform_of(f->scene, tried);
    check_fields(f, &transform, sizeof transform, transform_fields, DAFT_COUNT_OF(transform_fields), try_transform);
}

static void rays_are_checked(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_entity none = {0};
    daft_ray_hit hit;
    for (size_t b = 0; b < DAFT_COUNT_OF(BAD); b++) {
        float bad = (float)BAD[b];
        assert_false(daft_scene_cast_ray(f->scene, daft_dv3(0, BAD[b], 0), daft_v3(1, 0, 0), 1, none, &hit, &error));
        assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
        assert_false(daft_scene_cast_ray(f->scene, daft_dv3(0, 0, 0), daft_v3(1, bad, 0), 1, none, &hit, &error));
        assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    }
    assert_false(daft_scene_cast_ray(f->scene, daft_dv3(0, 0, 0), daft_v3(0, 0, 0), 1, none, &hit, &error));
    assert_non_null(strstr(error.message, "direction"));
    assert_false(daft_scene_cast_ray(f->scene, daft_dv3(0, 0, 0), daft_v3(1, 0, 0), NAN, none, &hit, &error));
    assert_non_null(strstr(error.message, "max_distance"));
    assert_false(daft_scene_cast_ray(f->scene, daft_dv3(0, 0, 0), daft_v3(1, 0, 0), -1, none, &hit, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_false(daft_scene_cast_ray(f->scene, daft_dv3(0, 0, 0), daft_v3(1, 0, 0), 1, none, &hit, &error));
    assert_int_equal(error.code, DAFT_OK); /* an empty scene: a miss */
}

static void sizes_are_checked(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE;
    def.radius = 0;
    assert_int_equal(daft_entity_create(f->scene, &def, &error).id, 0);
    assert_string_equal(error.message, "radius is 0; it must be finite and above 0");
    def.shape = DAFT_SHAPE_BOX;
    def.size.y = -1;
    assert_int_equal(daft_entity_create(f->scene, &def, &error).id, 0);
    assert_string_equal(error.message, "size.y is -1; it must be finite and above 0");
    def = daft_default_entity_def();
    def.rotation = (daft_quat){0, 0, 0, 0};
    assert_int_equal(daft_entity_create(f->scene, &def, &error).id, 0);
    assert_non_null(strstr(error.message, "rotation"));
    def = daft_default_entity_def();
    def.shape = (daft_shape)12;
    assert_int_equal(daft_entity_create(f->scene, &def, &error).id, 0);
    assert_non_null(strstr(error.message, "shape is 12"));
    daft_entity_def zero = {.shape = DAFT_SHAPE_SPHERE, .radius = 1};
    assert_int_equal(daft_entity_create(f->scene, &zero, &error).id, 0);
    assert_non_null(strstr(error.message, "daft_default_entity_def()"));
    daft_mesh_def mesh = {0};
    assert_int_equal(daft_mesh_create(f->scene, &mesh, &error).id, 0);
    assert_non_null(strstr(error.message, "daft_default_mesh_def()"));
    assert_int_equal(daft_entity_create(NULL, &def, &error).id, 0);
    assert_string_equal(error.message, "scene is NULL");
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(stale_handles_are_errors),
        TEST(handles_never_come_back),
        TEST(map_finds_what_it_holds),
        TEST(children_follow_their_parent),
        TEST(deep_chains_are_harmless),
        TEST(siblings_die_alone),
        TEST(spheres_keep_equal_scales),
        TEST(singular_transforms_are_skipped),
        TEST(walls_shadow_rooms),
        TEST(drawing_interpolates),
        TEST(camera_interpolates),
        TEST(axes_follow_the_convention),
        TEST(rays_meet_boxes),
        TEST(far_is_as_good_as_near),
        TEST(rays_meet_spheres),
        TEST(rays_meet_meshes),
        TEST(moved_vertices_are_seen),
        TEST(queries_have_no_memory),
        TEST(materials_are_kept),
        TEST(lights_come_and_go),
        TEST(boxes_share_their_mesh),
        TEST(hash_sees_every_change),
        TEST(bodies_say_what_they_may_be),
        TEST(a_ball_falls_and_rests),
        TEST(kinematic_bodies_move),
        TEST(bodies_die_with_their_entities),
        TEST(only_numbers_get_in),
        TEST(rays_are_checked),
        TEST(sizes_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
