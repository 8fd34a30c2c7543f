/* Bodies of every shape through daft.h: colliders, joints, events, layers, saved states, and what is refused. */
#include "fixtures.h"

#include "daft.h"

#include <string.h>

typedef struct place {
    daft_engine *engine;
    daft_scene *scene;
} place;

static place place_make(void)
{
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    place p = {.engine = daft_engine_create(&def, &error)};
    p.scene = daft_scene_create(p.engine, &error);
    assert_non_null(p.scene);
    return p;
}

static void place_drop(place *p)
{
    daft_scene_destroy(p->scene);
    daft_engine_destroy(p->engine);
}

static void assert_near(double value, double wanted, double tolerance)
{
    if (!(fabs(value - wanted) <= tolerance)) fail_msg("%.9g is not %.9g within %g", value, wanted, tolerance);
}

static daft_entity ground(daft_scene *scene)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = daft_v3(40, 1, 40);
    def.position = daft_dv3(0, -0.5, 0);
    def.body = DAFT_BODY_STATIC;
    daft_entity entity = daft_entity_create(scene, &def, NULL);
    assert_int_not_equal(entity.id, 0);
    return entity;
}

static daft_entity_def thing(daft_shape shape, double x, double y, double z)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = shape, def.body = DAFT_BODY_DYNAMIC;
    def.position = daft_dv3(x, y, z);
    return def;
}

static daft_entity add(daft_scene *scene, const daft_entity_def *def)
{
    daft_error error;
    char text[1200];
    daft_entity entity = daft_entity_create(scene, def, &error);
    if (!entity.id) fail_msg("%s", daft_error_text(&error, text, sizeof text));
    return entity;
}

static daft_dvec3 where(daft_scene *scene, daft_entity entity)
{
    daft_transform t;
    assert_true(daft_entity_get_transform(scene, entity, &t, NULL));
    return t.position;
}

static void run(daft_scene *scene, int ticks)
{
    for (int i = 0; i < ticks; i++) {
        daft_scene_begin_tick(scene);
        assert_true(daft_scene_step(scene, 1.0f / 60, NULL));
    }
}

/* A wedge: its hull rests on its lower face, whose height is 0. */
static daft_mesh wedge(daft_scene *scene)
{
    static const daft_vec3 p[6] = {{-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {-1, 1, -1}, {-1, 1, 1}};
    static const uint32_t index[24] = {0, 1, 3, 0, 3, 2, 0, 4, 1, 2, 3, 5, 1, 4, 5, 1, 5, 3, 0, 2, 5, 0, 5, 4};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.vertex_count = 6;
    def.indices = index, def.triangle_count = 8;
    daft_mesh mesh = daft_mesh_create(scene, &def, NULL);
    assert_int_not_equal(mesh.id, 0);
    return mesh;
}

static void every_collider_rests(void **unused)
{
    (void)unused;
    place p = place_make();
    ground(p.scene);
    daft_collider parts[2] = {daft_default_collider(), daft_default_collider()};
    parts[0].kind = parts[1].kind = DAFT_COLLIDER_BOX;
    parts[0].size = daft_v3(1, 0.2f, 1), parts[1].size = daft_v3(0.2f, 1, 0.2f);
    parts[1].position = daft_v3(0, 0.6f, 0);
    daft_collider capsule = daft_default_collider();
    capsule.kind = DAFT_COLLIDER_CAPSULE, capsule.radius = 0.3f, capsule.height = 1.6f;
    daft_collider drum = capsule;
    drum.kind = DAFT_COLLIDER_CYLINDER, drum.height = 0.4f;
    daft_entity_def defs[6] = {thing(DAFT_SHAPE_BOX, -6, 0.7, 0), thing(DAFT_SHAPE_SPHERE, -3, 0.7, 0),
                               thing(DAFT_SHAPE_MESH, 0, 0.2, 0), thing(DAFT_SHAPE_NONE, 3, 0.3, 0),
                               thing(DAFT_SHAPE_NONE, 6, 1.0, 0), thing(DAFT_SHAPE_NONE, 9, 0.3, 0)};
    defs[2].mesh = wedge(p.scene), defs[2].scale = daft_v3(0.5f, 0.5f, 0.5f);
    defs[3].colliders = parts, defs[3].collider_count = 2;
    defs[4].colliders = &capsule, defs[4].collider_count = 1, defs[4].locks = DAFT_LOCK_ROTATION;
    defs[5].colliders = &drum, defs[5].collider_count = 1;
    const double rest[6] = {0.5, 0.5, 0, 0.1, 0.8, 0.2};
    daft_entity entities[6];
    for (int i = 0; i < 6; i++) entities[i] = add(p.scene, &defs[i]);
    run(p.scene, 240);
    for (int i = 0; i < 6; i++) {
        bool awake;
        assert_near(where(p.scene, entities[i]).y, rest[i], 0.005);
        assert_true(daft_entity_get_awake(p.scene, entities[i], &awake, NULL));
        assert_false(awake);
    }
    assert_int_equal(daft_scene_sim_counters(p.scene).awake, 0);
    place_drop(&p);
}

/* A bead on a rail along x, and a block that turns about the upright axis in its place. */
static void locks_hold(void **unused)
{
    (void)unused;
    place p = place_make();
    daft_entity_def bead = thing(DAFT_SHAPE_SPHERE, 0, 3, 1), block = thing(DAFT_SHAPE_BOX, 5, 1, 0);
    bead.locks = DAFT_LOCK_POSITION_Y | DAFT_LOCK_POSITION_Z;
    block.locks = DAFT_LOCK_POSITION | DAFT_LOCK_X | DAFT_LOCK_Z;
    daft_entity on_rail = add(p.scene, &bead), fixed = add(p.scene, &block);
    daft_vec3 linear, angular;
    assert_true(daft_entity_set_velocity(p.scene, on_rail, daft_v3(1, 4, 4), daft_v3(0, 0, 0), NULL));
    assert_true(daft_entity_set_velocity(p.scene, fixed, daft_v3(1, 1, 1), daft_v3(2, 3, 4), NULL));
    assert_true(daft_entity_apply_impulse(p.scene, fixed, daft_v3(500, 500, 500), NULL));
    run(p.scene, 120);
    daft_dvec3 at = where(p.scene, on_rail), stands = where(p.scene, fixed);
    assert_near(at.x, 2, 1e-4);
    assert_true(at.y == 3 && at.z == 1 && stands.x == 5 && stands.y == 1 && stands.z == 0);
    assert_true(daft_entity_get_velocity(p.scene, fixed, &linear, &angular, NULL));
    assert_true(angular.x == 0 && angular.z == 0 && fabsf(angular.y - 3) < 1e-4f);
    place_drop(&p);
}

/* A ball rolls down triangles, scaled ones, and comes to rest in a field's hollow. */
static void ground_of_triangles_and_heights(void **unused)
{
    (void)unused;
    place p = place_make();
    daft_entity_def ramp = thing(DAFT_SHAPE_MESH, 0, 0, 0);
    ramp.mesh = wedge(p.scene), ramp.body = DAFT_BODY_STATIC, ramp.scale = daft_v3(3, 2, 3);
    add(p.scene, &ramp);
    float heights[25];
    for (int i = 0; i < 25; i++) heights[i] = (float)((i % 5 - 2) * (i % 5 - 2) + (i / 5 - 2) * (i / 5 - 2)) * 0.25f;
    daft_collider field = daft_default_collider();
    field.kind = DAFT_COLLIDER_FIELD;
    field.heights = heights, field.columns = field.rows = 5;
    daft_entity_def hollow = thing(DAFT_SHAPE_NONE, 20, 0, 0);
    hollow.colliders = &field, hollow.collider_count = 1, hollow.body = DAFT_BODY_STATIC;
    add(p.scene, &hollow);
    daft_entity_def ball = thing(DAFT_SHAPE_SPHERE, -2, 2.3, 0);
    ball.radius = 0.25f;
    daft_entity rolling = add(p.scene, &ball);
    ball.position = daft_dv3(22.9, 2, 2.4), ball.rolling_resistance = 0.05f;
    daft_entity resting = add(p.scene, &ball);
    run(p.scene, 60);
    daft_dvec3 at = where(p.scene, rolling);
    assert_true(at.x > -1.2 && at.y > 0.2);
    run(p.scene, 540);
    at = where(p.scene, resting);
    assert_near(at.x, 22, 0.3);
    assert_near(at.z, 2, 0.3);
    assert_near(at.y, 0.25, 0.15);
    place_drop(&p);
}

static void layers_and_sensors(void **unused)
{
    (void)unused;
    place p = place_make();
    ground(p.scene);
    daft_entity_def ghost = thing(DAFT_SHAPE_SPHERE, 0, 1, 0), gate = thing(DAFT_SHAPE_BOX, 5, 1, 0),
                    ball = thing(DAFT_SHAPE_SPHERE, 5, 3, 0);
    ghost.layers = 2, ghost.mask = 2;
    gate.body = DAFT_BODY_STATIC, gate.sensor = true;
    daft_entity through = add(p.scene, &ghost), door = add(p.scene, &gate), visitor = add(p.scene, &ball);
    int entered = 0, left = 0, begun = 0;
    for (int tick = 0; tick < 240; tick++) {
        run(p.scene, 1);
        daft_event events[16];
        uint32_t count = daft_scene_events(p.scene, events, 16);
        for (uint32_t i = 0; i < count && i < 16; i++) {
            entered +=
                events[i].kind == DAFT_EVENT_TRIGGER_ENTER && events[i].a.id == door.id && events[i].b.id == visitor.id;
            left += events[i].kind == DAFT_EVENT_TRIGGER_LEAVE;
            begun += events[i].kind == DAFT_EVENT_CONTACT_BEGIN && events[i].speed > 1;
        }
    }
    assert_true(where(p.scene, through).y < -10);
    assert_int_equal(entered, 1);
    assert_int_equal(left, 0); /* it lies within */
    assert_true(begun >= 1);
    place_drop(&p);
}

static void joints_hold_and_break(void **unused)
{
    (void)unused;
    place p = place_make();
    daft_entity_def bob = thing(DAFT_SHAPE_SPHERE, 1, 5, 0);
    bob.radius = 0.1f;
    daft_entity swinging = add(p.scene, &bob);
    daft_joint_def def = daft_default_joint_def();
    def.b = swinging, def.anchor = daft_dv3(0, 5, 0);
    daft_error error;
    daft_joint joint = daft_joint_create(p.scene, &def, &error);
    assert_true(daft_joint_is_valid(p.scene, joint));
    for (int i = 0; i < 120; i++) {
        run(p.scene, 1);
        daft_dvec3 at = daft_dsub(where(p.scene, swinging), daft_dv3(0, 5, 0));
        assert_near(sqrt(daft_ddot(at, at)), 1, 0.01);
    }
    daft_joint_state state;
    assert_true(daft_joint_get(p.scene, joint, &state, NULL));
    assert_int_equal(state.b.id, swinging.id);
    assert_true(state.force > 0);
    assert_true(daft_entity_destroy(p.scene, swinging, NULL));
    assert_false(daft_joint_is_valid(p.scene, joint));
    assert_false(daft_joint_get(p.scene, joint, &state, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);

    bob.position = daft_dv3(0, 4, 0), bob.mass = 100;
    daft_entity heavy = add(p.scene, &bob);
    def.b = heavy, def.kind = DAFT_JOINT_FIXED, def.break_force = 500;
    joint = daft_joint_create(p.scene, &def, NULL);
    bool broke = false;
    for (int i = 0; i < 30; i++) {
        run(p.scene, 1);
        daft_event events[8];
        uint32_t count = daft_scene_events(p.scene, events, 8);
        for (uint32_t k = 0; k < count && k < 8; k++)
            broke |= events[k].kind == DAFT_EVENT_JOINT_BREAK && events[k].joint.id == joint.id;
    }
    assert_true(broke);
    assert_false(daft_joint_is_valid(p.scene, joint));
    place_drop(&p);
}

static void states_go_on_with_the_same_bits(void **unused)
{
    (void)unused;
    place p = place_make();
    ground(p.scene);
    daft_entity entities[12];
    for (int i = 0; i < 12; i++) {
        daft_entity_def def =
            thing(i % 3 ? DAFT_SHAPE_BOX : DAFT_SHAPE_SPHERE, 0.3 * (i % 2), 1 + 1.1 * i, 0.1 * (i % 3));
        entities[i] = add(p.scene, &def);
    }
    daft_character_def walker = daft_default_character_def();
    walker.position = daft_dv3(-5, 0.1, 0);
    daft_character walking = daft_character_create(p.scene, &walker, NULL);
    assert_true(daft_character_walk(p.scene, walking, daft_v3(2, 0, 0.5f), NULL));
    daft_joint_def def = daft_default_joint_def();
    def.a = entities[3], def.b = entities[4], def.anchor = where(p.scene, entities[4]), def.break_force = 1;
    daft_joint joint = daft_joint_create(p.scene, &def, NULL);
    daft_surfaces ice = {0, 0, 0, 0};
    assert_true(daft_scene_set_surfaces(p.scene, 1, 2, &ice, NULL));
    size_t size = daft_scene_save_bodies(p.scene, NULL, 0, NULL);
    assert_true(size > 0);
    char *bytes = malloc(size);
    assert_int_equal(daft_scene_save_bodies(p.scene, bytes, size, NULL), size);
    run(p.scene, 200);
    assert_false(daft_joint_is_valid(p.scene, joint));
    uint64_t once = daft_scene_hash(p.scene);
    assert_true(daft_scene_load_bodies(p.scene, bytes, size, NULL));
    assert_true(daft_joint_is_valid(p.scene, joint)); /* it has not broken yet */
    assert_near(where(p.scene, entities[11]).y, 1 + 1.1 * 11, 0);
    run(p.scene, 200);
    assert_true(daft_scene_hash(p.scene) == once);

    daft_error error;
    assert_false(daft_scene_load_bodies(p.scene, bytes, size - 1, &error));
    assert_int_equal(error.code, DAFT_ERROR_SYNTAX);
    fixture_seed(4242);
    char *hurt = malloc(size);
    for (int i = 0; i < 300; i++) { /* damage is refused or harmless, and never half loaded */
        memcpy(hurt, bytes, size);
        for (int k = 0; k < 3; k++) hurt[(size_t)(random_float(0, 1) * (float)(size - 1))] ^= (char)(1 << (i % 8));
        if (!daft_scene_load_bodies(p.scene, hurt, size, &error)) assert_int_not_equal(error.code, DAFT_OK);
        assert_true(daft_scene_step(p.scene, 1.0f / 60, NULL));
        for (int k = 0; k < 12; k++) assert_true(isfinite(where(p.scene, entities[k]).y));
    }
    assert_true(daft_scene_load_bodies(p.scene, bytes, size, NULL));
    assert_true(daft_entity_destroy(p.scene, entities[0], NULL));
    assert_false(daft_scene_load_bodies(p.scene, bytes, size, &error));
    free(hurt);
    free(bytes);
    place_drop(&p);
}

static void surfaces(void **unused)
{
    (void)unused;
    place p = place_make();
    daft_entity_def floor = daft_default_entity_def();
    floor.shape = DAFT_SHAPE_BOX, floor.size = daft_v3(40, 1, 40), floor.position = daft_dv3(0, -0.5, 0),
    floor.body = DAFT_BODY_STATIC;
    floor.surface = 1;
    add(p.scene, &floor);
    daft_entity_def box = thing(DAFT_SHAPE_BOX, 0, 0.5, 0);
    box.surface = 2;
    daft_entity sliding = add(p.scene, &box);
    daft_surfaces ice = {0, 0, 0, 0};
    assert_true(daft_scene_set_surfaces(p.scene, 1, 2, &ice, NULL));
    assert_false(daft_scene_set_surfaces(p.scene, 1, 64, &ice, NULL));
    assert_true(daft_entity_set_velocity(p.scene, sliding, daft_v3(2, 0, 0), daft_v3(0, 0, 0), NULL));
    run(p.scene, 120);
    assert_near(where(p.scene, sliding).x, 4, 0.05);
    assert_true(daft_scene_set_surfaces(p.scene, 1, 2, NULL, NULL));
    run(p.scene, 120);
    daft_vec3 v;
    assert_true(daft_entity_get_velocity(p.scene, sliding, &v, NULL, NULL));
    assert_float_equal(v.x, 0, 1e-3f);
    place_drop(&p);
}

static void refused(daft_scene *scene, const daft_entity_def *def, const char *part)
{
    daft_error error;
    uint32_t before = daft_entity_count(scene);
    assert_int_equal(daft_entity_create(scene, def, &error).id, 0);
    if (!strstr(error.message, part)) fail_msg("\"%s\" does not say \"%s\"", error.message, part);
    assert_int_equal(daft_entity_count(scene), before);
}

static void bad_bodies(void **unused)
{
    (void)unused;
    place p = place_make();
    daft_entity_def def = thing(DAFT_SHAPE_NONE, 0, 0, 0);
    refused(p.scene, &def, "needs a shape or a collider");
    daft_collider collider = daft_default_collider();
    def.colliders = &collider, def.collider_count = 1;
    collider.kind = DAFT_COLLIDER_MESH, collider.mesh = wedge(p.scene);
    refused(p.scene, &def, "no mass");
    collider.kind = DAFT_COLLIDER_HULL, collider.mesh.id = 0;
    refused(p.scene, &def, "mesh");
    collider.kind = DAFT_COLLIDER_SPHERE, collider.radius = -1;
    refused(p.scene, &def, "radius");
    collider.radius = NAN;
    refused(p.scene, &def, "radius");
    collider.kind = (daft_collider_kind)99;
    refused(p.scene, &def, "kind is 99");
    collider = daft_default_collider();
    def.mass = -1;
    refused(p.scene, &def, "mass");
    def.mass = 0, def.surface = 64;
    refused(p.scene, &def, "surface");
    def.surface = 0, def.surface_velocity.x = INFINITY;
    refused(p.scene, &def, "surface_velocity");

    static const daft_vec3 flat[3] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
    static const uint32_t index[3] = {0, 1, 2};
    daft_mesh_def mesh = daft_default_mesh_def();
    mesh.positions = flat, mesh.vertex_count = 3, mesh.indices = index, mesh.triangle_count = 1;
    daft_entity_def sheet = thing(DAFT_SHAPE_MESH, 0, 0, 0);
    sheet.mesh = daft_mesh_create(p.scene, &mesh, NULL);
    refused(p.scene, &sheet, "hull");
    sheet.body = DAFT_BODY_STATIC;
    add(p.scene, &sheet);
    daft_error error;
    assert_false(daft_mesh_set_positions(p.scene, sheet.mesh, flat, NULL, 3, &error));
    assert_non_null(strstr(error.message, "what a body is made of"));
    daft_joint_def joint = daft_default_joint_def();
    assert_int_equal(daft_joint_create(p.scene, &joint, &error).id, 0);
    assert_false(daft_scene_set_substeps(p.scene, 17, &error));
    place_drop(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_collider_rests),
        cmocka_unit_test(locks_hold),
        cmocka_unit_test(ground_of_triangles_and_heights),
        cmocka_unit_test(layers_and_sensors),
        cmocka_unit_test(joints_hold_and_break),
        cmocka_unit_test(states_go_on_with_the_same_bits),
        cmocka_unit_test(surfaces),
        cmocka_unit_test(bad_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
