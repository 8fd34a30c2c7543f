/* Queries of bodies and characters through daft.h: entities in, entities out, errors as values. */
#include "scene_fixture.h"

static daft_entity put(daft_scene *scene, daft_body_kind kind, daft_vec3 size, double x, double y, double z)
{
    daft_entity_def def = daft_default_entity_def();
    daft_error error = {0};
    def.shape = DAFT_SHAPE_BOX;
    def.size = size;
    def.body = kind;
    def.position = daft_dv3(x, y, z);
    daft_entity e = daft_entity_create(scene, &def, &error);
    if (!e.id) fail_msg("%s", error.message);
    return e;
}

static void step(daft_scene *scene, int ticks)
{
    daft_error error = {0};
    for (int i = 0; i < ticks; i++) {
        daft_scene_begin_tick(scene);
        if (!daft_scene_step(scene, 1.0f / 60, &error)) fail_msg("%s", error.message);
    }
}

static void queries_give_entities(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_query_hit hit, hits[8];
    assert_false(daft_query_ray(f->scene, daft_dv3(0, 5, 0), daft_v3(0, -1, 0), 10, NULL, &hit, &error));
    assert_int_equal(error.code, DAFT_OK); /* no body yet */
    daft_entity floor = put(f->scene, DAFT_BODY_STATIC, daft_v3(20, 1, 20), 0, -0.5, 0);
    daft_entity crate = put(f->scene, DAFT_BODY_DYNAMIC, daft_v3(1, 1, 1), 0, 0.5, 0);
    assert_true(daft_entity_set_visible(f->scene, crate, false, NULL)); /* bodies are met unseen */
    assert_true(daft_query_ray(f->scene, daft_dv3(0, 5, 0), daft_v3(0, -3, 0), INFINITY, NULL, &hit, &error));
    assert_int_equal(hit.entity.id, crate.id);
    assert_float_equal(hit.distance, 4, 1e-5);
    assert_float_equal(hit.normal.y, 1, 1e-6);
    assert_false(daft_query_ray(f->scene, daft_dv3(0, 5, 0), daft_v3(0, -3, 0), 3.9f, NULL, &hit, &error));
    assert_int_equal(daft_query_ray_all(f->scene, daft_dv3(0, 5, 0), daft_v3(0, -1, 0), 10, NULL, hits, 8, &error), 2);
    assert_int_equal(hits[0].entity.id, crate.id);
    assert_int_equal(hits[1].entity.id, floor.id);
    daft_query_filter filter = daft_default_query_filter();
    filter.ignore = crate;
    assert_true(daft_query_ray(f->scene, daft_dv3(0, 5, 0), daft_v3(0, -1, 0), 10, &filter, &hit, &error));
    assert_int_equal(hit.entity.id, floor.id);
    filter = daft_default_query_filter();
    filter.statics = false;
    daft_volume ball = daft_default_volume();
    ball.radius = 0.25f;
    assert_true(daft_query_cast(f->scene, &ball, daft_dv3(3, 0.5, 0), daft_v3(-1, 0, 0), 10, &filter, &hit, &error));
    assert_int_equal(hit.entity.id, crate.id);
    assert_float_equal(hit.distance, 2.25, 1e-4);
    ball.height = 2; /* a capsule that stands in the floor */
    assert_int_equal(daft_query_overlap(f->scene, &ball, daft_dv3(5, 0.9, 0), NULL, hits, 8, &error), 1);
    assert_int_equal(hits[0].entity.id, floor.id);
    assert_true(daft_query_closest(f->scene, daft_dv3(2, 0.5, 0), 5, &filter, &hit, &error));
    assert_float_equal(hit.distance, 1.5, 1e-5);
}

static void bad_queries_are_refused(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_query_filter filter = daft_default_query_filter();
    daft_volume volume = daft_default_volume();
    put(f->scene, DAFT_BODY_STATIC, daft_v3(20, 1, 20), 0, -0.5, 0);
    const daft_dvec3 o = {0, 5, 0}, bad = {NAN, 0, 0};
    const daft_vec3 down = {0, -1, 0}, none = {0, 0, 0};
    assert_false(daft_query_ray(f->scene, bad, down, 1, NULL, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_false(daft_query_ray(f->scene, o, none, 1, NULL, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_false(daft_query_ray(f->scene, o, down, NAN, NULL, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    filter.cookie = 0;
    assert_false(daft_query_ray(f->scene, o, down, 1, &filter, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    filter = daft_default_query_filter();
    filter.ignore.id = 0x7654321;
    assert_false(daft_query_ray(f->scene, o, down, 1, &filter, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    volume.size.x = -1;
    assert_false(daft_query_cast(f->scene, &volume, o, down, 1, NULL, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_int_equal(daft_query_overlap(f->scene, &volume, o, NULL, NULL, 0, &error), 0);
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_false(daft_query_closest(f->scene, o, -1, NULL, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
}

static void a_character_walks_and_its_entity_follows(void **state)
{
    fixture *f = *state;
    daft_error error = {0};
    daft_entity floor = put(f->scene, DAFT_BODY_STATIC, daft_v3(40, 1, 40), 0, -0.5, 0);
    put(f->scene, DAFT_BODY_STATIC, daft_v3(4, 0.3f, 4), 6, 0.15, 0); /* a step */
    daft_entity figure = put(f->scene, DAFT_BODY_KINEMATIC, daft_v3(0.5f, 1.8f, 0.5f), 0, 0.95, 0);
    daft_character_def def = daft_default_character_def();
    def.position = daft_dv3(0, 0.95, 0);
    def.entity = figure;
    uint64_t before = daft_scene_hash(f->scene);
    daft_character c = daft_character_create(f->scene, &def, &error);
    if (!c.id) fail_msg("%s", error.message);
    assert_true(daft_scene_hash(f->scene) != before);
    assert_true(daft_character_walk(f->scene, c, daft_v3(3, 0, 0), &error));
    step(f->scene, 60);
    daft_character_state s;
    assert_true(daft_character_get(f->scene, c, &s, &error));
    assert_true(s.grounded && s.ground.id == floor.id);
    assert_true(s.position.x > 2.5 && s.position.x < 3.1);
    step(f->scene, 60);
    assert_true(daft_character_get(f->scene, c, &s, &error));
    assert_true(s.position.x > 5 && s.position.y > 1.19);
    daft_transform t;
    step(f->scene, 1); /* a kinematic body arrives with the next step */
    assert_true(daft_entity_get_transform(f->scene, figure, &t, &error));
    assert_float_equal(t.position.x, s.position.x, 0.06);
    assert_true(daft_character_walk(f->scene, c, daft_v3(0, 0, 0), &error));
    assert_true(daft_character_jump(f->scene, c, 5, &error));
    step(f->scene, 10);
    assert_true(daft_character_get(f->scene, c, &s, &error));
    assert_true(!s.grounded && s.ground.id == 0 && s.velocity.y > 2);
    assert_true(daft_character_teleport(f->scene, c, daft_dv3(-5, 0.91, 0), &error));
    assert_true(daft_character_set_height(f->scene, c, 1.2f, &error));
    step(f->scene, 60);
    assert_true(daft_character_get(f->scene, c, &s, &error));
    assert_float_equal(s.position.y, 0.6, 0.02);
    assert_float_equal(s.height, 1.2, 1e-6);
    assert_true(daft_entity_destroy(f->scene, figure, &error)); /* it goes on without */
    step(f->scene, 5);
    assert_true(daft_character_destroy(f->scene, c, &error));
    assert_false(daft_character_is_valid(f->scene, c));
    assert_false(daft_character_walk(f->scene, c, daft_v3(0, 0, 0), &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
}

static void bad_characters_are_refused(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_character_def def = daft_default_character_def();
    daft_entity crate = put(f->scene, DAFT_BODY_DYNAMIC, daft_v3(1, 1, 1), 0, 5, 0);
    def.radius = NAN;
    assert_int_equal(daft_character_create(f->scene, &def, &error).id, 0);
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    def = daft_default_character_def();
    def.entity = crate;
    assert_int_equal(daft_character_create(f->scene, &def, &error).id, 0);
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    def = daft_default_character_def();
    def.cookie = 1;
    assert_int_equal(daft_character_create(f->scene, &def, &error).id, 0);
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    def = daft_default_character_def();
    daft_character c = daft_character_create(f->scene, &def, &error);
    assert_true(c.id != 0);
    assert_false(daft_character_walk(f->scene, c, daft_v3(NAN, 0, 0), &error));
    assert_false(daft_character_jump(f->scene, c, NAN, &error));
    assert_false(daft_character_teleport(f->scene, c, daft_dv3(0, INFINITY, 0), &error));
    assert_false(daft_character_set_height(f->scene, c, 0.1f, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    step(f->scene, 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(queries_give_entities, set_up, tear_down),
        cmocka_unit_test_setup_teardown(bad_queries_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_character_walks_and_its_entity_follows, set_up, tear_down),
        cmocka_unit_test_setup_teardown(bad_characters_are_refused, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
