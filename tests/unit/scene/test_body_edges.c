/* Edges of bodies, the list of entities, and what the stages of a step took. */
#include "fixtures.h"

#include "daft.h"

typedef struct place {
    daft_engine *engine;
    daft_scene *scene;
} place;

static place place_make(void)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    place p = {.engine = daft_engine_create(&def, NULL)};
    p.scene = daft_scene_create(p.engine, NULL);
    assert_non_null(p.scene);
    return p;
}

static void place_drop(place *p)
{
    daft_scene_destroy(p->scene);
    daft_engine_destroy(p->engine);
}

static daft_entity body(place *p, daft_collider collider, daft_dvec3 at, daft_body_kind kind)
{
    daft_entity_def def = daft_default_entity_def();
    def.body = kind, def.position = at, def.colliders = &collider, def.collider_count = 1;
    daft_entity made = daft_entity_create(p->scene, &def, NULL);
    assert_int_not_equal(made.id, 0);
    return made;
}

enum { MOST = 4096 };
static daft_body_edge edges[MOST];
static const daft_dvec3 ORIGIN = {0, 0, 0};

static double length(daft_dvec3 a, daft_dvec3 b)
{
    return sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z));
}

static void boxes_and_balls_have_their_edges(void **unused)
{
    (void)unused;
    place p = place_make();
    daft_collider box = daft_default_collider(), ball = box;
    box.kind = DAFT_COLLIDER_BOX, box.size = daft_v3(2, 4, 6);
    ball.radius = 1.5f;
    const daft_entity one = body(&p, box, daft_dv3(3, 0, 0), DAFT_BODY_STATIC);
    assert_int_equal(daft_scene_body_edges(p.scene, ORIGIN, 100, edges, MOST), 12);
    double sum = 0;
    for (int i = 0; i < 12; i++) {
        sum += length(edges[i].from, edges[i].to);
        assert_true(fabs(edges[i].from.x - 3) == 1 && fabs(edges[i].from.y) == 2 && fabs(edges[i].from.z) == 3);
        assert_true(edges[i].entity.id == one.id && edges[i].kind == DAFT_BODY_STATIC && !edges[i].awake);
    }
    assert_true(sum == 4 * (2 + 4 + 6));
    const daft_entity two = body(&p, ball, daft_dv3(-50, 0, 0), DAFT_BODY_DYNAMIC);
    assert_int_equal(daft_scene_body_edges(p.scene, ORIGIN, 10, edges, MOST), 12);          /* the ball is far off */
    assert_int_equal(daft_scene_body_edges(p.scene, daft_dv3(-50, 0, 0), 5, edges, 7), 72); /* three circles */
    for (int i = 0; i < 7; i++) {
        assert_true(fabs(length(edges[i].from, daft_dv3(-50, 0, 0)) - 1.5) < 1e-12);
        assert_true(edges[i].entity.id == two.id && edges[i].awake);
    }
    assert_true(daft_entity_set_awake(p.scene, two, false, NULL));
    daft_scene_body_edges(p.scene, daft_dv3(-50, 0, 0), 5, edges, MOST);
    assert_false(edges[0].awake);
    assert_int_equal(daft_scene_body_edges(p.scene, ORIGIN, 0, edges, MOST), 0);
    assert_int_equal(daft_scene_body_edges(NULL, ORIGIN, 1, edges, MOST), 0);
    place_drop(&p);
}

/* A flat field of 3 by 4 samples: 2·4 edges along rows, 3·3 along columns. */
static void fields_are_grids(void **unused)
{
    (void)unused;
    place p = place_make();
    float heights[12] = {0};
    daft_collider field = daft_default_collider();
    field.kind = DAFT_COLLIDER_FIELD, field.heights = heights, field.columns = 3, field.rows = 4;
    field.spacing = (daft_vec2){1, 1};
    body(&p, field, ORIGIN, DAFT_BODY_STATIC);
    assert_int_equal(daft_scene_body_edges(p.scene, ORIGIN, 100, edges, MOST), 2 * 4 + 3 * 3);
    for (int i = 0; i < 17; i++) assert_true(length(edges[i].from, edges[i].to) == 1);
    assert_int_equal(daft_scene_body_edges(p.scene, ORIGIN, 0.5f, edges, MOST), 2); /* those at the corner */
    place_drop(&p);
}

static void entities_are_listed_and_told(void **unused)
{
    (void)unused;
    place p = place_make();
    daft_entity made[3], listed[3];
    daft_entity_def def = daft_default_entity_def(), told;
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 2;
    for (int i = 0; i < 3; i++) made[i] = daft_entity_create(p.scene, &def, NULL);
    daft_transform moved = {daft_dv3(1, 2, 3), {0, 0, 0, 1}, daft_v3(1, 1, 1)};
    assert_true(daft_entity_set_transform(p.scene, made[2], &moved, true, NULL));
    assert_true(daft_entity_destroy(p.scene, made[0], NULL));
    assert_int_equal(daft_scene_entities(p.scene, listed, 3), 2);
    assert_true(listed[0].id == made[1].id && listed[1].id == made[2].id);
    assert_int_equal(daft_scene_entities(p.scene, NULL, 0), 2);
    assert_true(daft_entity_get(p.scene, made[2], &told, NULL));
    assert_true(told.shape == DAFT_SHAPE_SPHERE && told.radius == 2 && told.position.y == 2);
    daft_error error;
    assert_false(daft_entity_get(p.scene, made[0], &told, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    place_drop(&p);
}

static void steps_tell_what_they_took(void **unused)
{
    (void)unused;
    place p = place_make();
    assert_true(daft_scene_sim_times(p.scene).solve == 0);
    body(&p, daft_default_collider(), ORIGIN, DAFT_BODY_DYNAMIC);
    assert_true(daft_scene_step(p.scene, 1 / 60.0f, NULL));
    daft_sim_times t = daft_scene_sim_times(p.scene);
    assert_true(t.broad > 0 && t.contacts >= 0 && t.solve > 0 && t.sweep >= 0 && t.events >= 0);
    place_drop(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_and_balls_have_their_edges), cmocka_unit_test(fields_are_grids),
        cmocka_unit_test(entities_are_listed_and_told), cmocka_unit_test(steps_tell_what_they_took)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
