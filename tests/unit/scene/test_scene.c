/* scene: handles, hierarchy, interpolation, materials, lights and the state hash. */
#include "scene_fixture.h"

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
    assert_true(fabsf(drop(f, 10, -2) - 43.5f) < 1e-5f);   /* the grandchild's top: y = 6 + 0.5 */
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

static bool list_instances(daft_scene *scene, daft_dvec3 origin, float alpha, daft_arena *arena,
                           daft_instance **instances, uint32_t *count)
{
    daft_listing listing = {.origin = origin, .alpha = alpha, .arena = arena};
    const bool done = daft_snapshot_instances(scene, &listing, NULL);
    *instances = listing.instances, *count = listing.count;
    return done;
}

static uint32_t flags_from(fixture *f, double x)
{
    daft_arena arena;
    daft_instance *instances;
    uint32_t count;
    daft_arena_init(&arena, f->scene->allocator);
    assert_true(list_instances(f->scene, daft_dv3(x, 0, 0), 1, &arena, &instances, &count));
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

/* ---- snapshots ---- */

enum { MANY = 6000 }; /* so many that all threads take part */

static daft_mesh make_triangle(daft_scene *scene)
{
    static const daft_vec3 corners[] = {{0, 0, 0}, {1, 0, 0.5f}, {0, 1, 0}};
    static const uint32_t indices[] = {0, 1, 2};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = corners, def.vertex_count = 3, def.indices = indices, def.triangle_count = 1;
    daft_mesh mesh = daft_mesh_create(scene, &def, NULL);
    assert_true(mesh.id != 0);
    return mesh;
}

/* Entities of all shapes, some of them on others, hidden, with a material of their own, or flat. Gives how many are
 * shown. */
static uint32_t make_many(daft_scene *scene, daft_material own, bool shown[MANY])
{
    daft_entity made[MANY];
    uint32_t count = 0;
    random_state = 77;
    daft_mesh meshes[] = {make_triangle(scene), make_triangle(scene)};
    scene->assets.meshes[meshes[1].id - 1]->mesh.slot_count = 3; /* as of a file; only entities with a material of their
                                                                    own show it */
    for (uint32_t i = 0; i < MANY; i++) {
        daft_entity_def def = daft_default_entity_def();
        uint32_t kind = (uint32_t)uniform(0, 5), on = (uint32_t)uniform(0, i);
        bool hangs = i && uniform(0, 1) < 0.2, flat = uniform(0, 1) < 0.005;
        def.shape = kind == 0   ? DAFT_SHAPE_NONE
                    : kind == 1 ? DAFT_SHAPE_SPHERE
                    : kind == 2 ? DAFT_SHAPE_BOX
                                : DAFT_SHAPE_MESH;
        if (def.shape == DAFT_SHAPE_MESH) def.mesh = meshes[kind - 3];
        if (kind == 4) def.material = own;
        def.position = daft_dv3(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9));
        def.visible = uniform(0, 1) < 0.9;
        if (hangs) def.parent = made[on];
        if (flat && kind >= 2) def.scale = daft_v3(1, 0, 1);
        made[i] = daft_entity_create(scene, &def, NULL);
        assert_true(made[i].id != 0);
        bool fits = true, visible = true;
        for (uint32_t at = daft_handle_index(made[i].id); at != DAFT_NONE; at = scene->entities[at].parent)
            fits = fits && scene->entities[at].now.scale.y != 0, visible = visible && scene->entities[at].def.visible;
        shown[i] = def.shape != DAFT_SHAPE_NONE && fits && visible;
        count += shown[i];
    }
    return count;
}

/* What all threads make of them is each where it stands, in order, and what does not fit is told of once. */
static void many_things_in_a_frame(void **state)
{
    fixture *f = *state;
    static bool shown[MANY];
    daft_material_def material = daft_default_material_def();
    daft_material own = daft_material_create(f->scene, &material, NULL);
    uint32_t expected = make_many(f->scene, own, shown), count, last = 0;
    assert_in_range(expected, 3 * MANY / 5 / 2, MANY);
    daft_arena arena;
    daft_instance *instances;
    daft_arena_init(&arena, f->scene->allocator);
    for (int repeat = 0; repeat < 2; repeat++) {
        assert_true(list_instances(f->scene, daft_dv3(0.1, 2, 3), 1, &arena, &instances, &count));
        assert_int_equal(count, expected);
    }
    int warnings = f->warnings;
    assert_true(warnings > 5);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t index = daft_handle_index(instances[i].entity);
        const daft_entity_item *item = daft_entity_world(f->scene, index, 1);
        assert_true(i == 0 || index > last);
        last = index;
        daft_instance alone = instances[i];
        daft_instance_bound(&alone);
        assert_memory_equal(&alone.low, &instances[i].low, 2 * sizeof alone.low);
        for (int k = 0; k < 9; k++) assert_true(alone.to_frame.m[k] == (float)item->world.m[k]);
        assert_true(alone.to_frame.t[0] == (float)(item->world.t[0] - 0.1) &&
                    alone.to_frame.t[1] == (float)(item->world.t[1] - 2));
        daft_vec3 back = daft_affine_point(&alone.to_object, daft_affine_point(&alone.to_frame, daft_v3(1, 2, 3)));
        assert_true(fabsf(back.x - 1) < 1e-4f && fabsf(back.y - 2) < 1e-4f && fabsf(back.z - 3) < 1e-4f);
        uint32_t slots = alone.mesh && alone.mesh->slot_count ? alone.mesh->slot_count : 1;
        for (uint32_t k = 0; k < slots; k++)
            assert_int_equal(alone.materials[k], item->def.material.id ? own.id - 1 : 0);
        assert_true((alone.flags & DAFT_INSTANCE_CASTS_SHADOW) != 0);
    }
    daft_arena_free(&arena);
}

/* ---- interpolation ---- */

static float drawn_x(fixture *f, float alpha)
{
    daft_arena arena;
    daft_instance *instances;
    uint32_t count;
    daft_arena_init(&arena, f->scene->allocator);
    assert_true(list_instances(f->scene, daft_dv3(0, 0, 0), alpha, &arena, &instances, &count));
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
    def.kind = DAFT_LIGHT_SPOT;
    const float cones[6][2] = {{0.5f, 0.4f}, {-0.1f, 1}, {NAN, 1}, {0, 0}, {1, 4}, {0, NAN}};
    for (int i = 0; i < 6; i++) {
        def.inner_angle = cones[i][0], def.outer_angle = cones[i][1];
        assert_false(daft_light_set(f->scene, light, &def, &error));
        assert_non_null(strstr(error.message, i < 3 ? "inner_angle" : "outer_angle"));
    }
    def.inner_angle = def.outer_angle = 1;
    assert_true(daft_light_set(f->scene, light, &def, &error));
    uint64_t hash = daft_scene_hash(f->scene);
    def.inner_angle = 0.5f;
    assert_true(daft_light_set(f->scene, light, &def, &error) && daft_scene_hash(f->scene) != hash);
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
    daft_light source = daft_light_create(f->scene, &light, NULL);
    seen[count++] = daft_scene_hash(f->scene);
    light.color.y = 0.5f;
    assert_true(daft_light_set(f->scene, source, &light, NULL));
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(stale_handles_are_errors),   TEST(handles_never_come_back),
        TEST(map_finds_what_it_holds),    TEST(children_follow_their_parent),
        TEST(deep_chains_are_harmless),   TEST(siblings_die_alone),
        TEST(spheres_keep_equal_scales),  TEST(singular_transforms_are_skipped),
        TEST(walls_shadow_rooms),         TEST(many_things_in_a_frame),
        TEST(drawing_interpolates),       TEST(camera_interpolates),
        TEST(axes_follow_the_convention), TEST(materials_are_kept),
        TEST(lights_come_and_go),         TEST(boxes_share_their_mesh),
        TEST(hash_sees_every_change),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
