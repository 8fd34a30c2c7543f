/* Bodies of entities, and that no value which is not a number gets into a scene. */
#include "scene_fixture.h"

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
    daft_entity_def bad[] = {body_def(DAFT_SHAPE_NONE, DAFT_BODY_DYNAMIC), body_def(DAFT_SHAPE_NONE, DAFT_BODY_STATIC),
                             body_def(DAFT_SHAPE_SPHERE, DAFT_BODY_DYNAMIC), body_def(DAFT_SHAPE_BOX, DAFT_BODY_STATIC),
                             body_def(DAFT_SHAPE_BOX, (daft_body_kind)9)};
    const char *says[] = {"the shape is none", "the shape is none", "has a parent", "2, 1, 1", "body is 9"};
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

#define FLOATS(count)  (count), sizeof(float)
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
                                     {"transmission", offsetof(daft_material_def, transmission), FLOATS(1)},
                                     {"transmission_tint", offsetof(daft_material_def, transmission_tint), FLOATS(3)},
                                     {"refractive_index", offsetof(daft_material_def, refractive_index), FLOATS(1)},
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

/* Setting the position alone is setting the transform with another position: by the hash of the whole scene, and by
 * what drawing sees between two ticks. */
static void positions_are_set_as_transforms_are(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_scene *other = daft_scene_create(f->engine, &error), *scenes[2] = {f->scene, other};
    daft_entity entity[2][3], far, gone;
    for (int i = 0; i < 2; i++) {
        daft_entity_def box = body_def(DAFT_SHAPE_BOX, DAFT_BODY_KINEMATIC), child = daft_default_entity_def();
        box.rotation = (daft_quat){0.1f, 0.2f, 0.3f, 0.9f};
        entity[i][0] = daft_entity_create(scenes[i], &box, &error);
        box.body = DAFT_BODY_DYNAMIC, box.position.x = 30;
        entity[i][1] = daft_entity_create(scenes[i], &box, &error);
        child.parent = entity[i][0], child.shape = DAFT_SHAPE_SPHERE;
        entity[i][2] = daft_entity_create(scenes[i], &child, &error);
        assert_true(entity[i][0].id && entity[i][1].id && entity[i][2].id);
    }
    random_state = 77;
    for (int step = 0; step < 200; step++) {
        const int which = (int)uniform(0, 3);
        const bool teleport = uniform(0, 1) < 0.3;
        const daft_dvec3 to = daft_dv3(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9));
        daft_transform moved = transform_of(other, entity[1][which]), seen[2];
        moved.position = to;
        assert_true(daft_entity_set_position(f->scene, entity[0][which], to, teleport, &error));
        assert_true(daft_entity_set_transform(other, entity[1][which], &moved, teleport, &error));
        for (int i = 0; i < 2; i++) seen[i] = transform_of(scenes[i], entity[i][which]);
        assert_memory_equal(&seen[0].position, &seen[1].position, sizeof to);
        assert_true(daft_scene_hash(f->scene) == daft_scene_hash(other));
        const daft_entity_item *a = f->scene->entities, *b = other->entities;
        for (int i = 0; i < 3; i++) assert_memory_equal(&a[i].before.position, &b[i].before.position, sizeof to);
        if (step % 3 != 0) continue;
        for (int i = 0; i < 2; i++) {
            daft_scene_begin_tick(scenes[i]);
            assert_true(daft_scene_step(scenes[i], 1.0f / 60, &error));
        }
    }
    far = entity[0][0], gone = entity[0][2];
    assert_false(daft_entity_set_position(f->scene, far, daft_dv3(0, 1e13, 0), false, &error));
    assert_non_null(strstr(error.message, "position.y is 1e+13"));
    assert_false(daft_entity_set_position(f->scene, far, daft_dv3(0, NAN, 0), false, &error));
    assert_string_equal(error.message, "position.y is nan; it must be finite");
    assert_true(daft_entity_destroy(f->scene, gone, &error));
    assert_false(daft_entity_set_position(f->scene, gone, daft_dv3(0, 0, 0), false, &error));
    assert_non_null(strstr(error.message, "stale"));
    daft_scene_destroy(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(bodies_say_what_they_may_be), TEST(a_ball_falls_and_rests),
        TEST(kinematic_bodies_move),       TEST(bodies_die_with_their_entities),
        TEST(only_numbers_get_in),         TEST(rays_are_checked),
        TEST(sizes_are_checked),           TEST(positions_are_set_as_transforms_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
