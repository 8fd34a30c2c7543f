/* render: the knobs of a view replace single values of its quality, and nothing else. */
#include "daft.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 96, HEIGHT = 64, BYTES = 4 * WIDTH * HEIGHT };

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
} stage;

/* A mirror ball and a glass ball over a lit floor: every knob changes the picture. */
static void stage_make(stage *s)
{
    daft_engine_def def = daft_default_engine_def();
    daft_error error;
    def.threads = 2;
    s->engine = daft_engine_create(&def, &error);
    if (!s->engine) fail_msg("%s", error.message);
    s->scene = daft_scene_create(s->engine, &error);
    s->image = daft_image_create(s->engine, WIDTH, HEIGHT, &error);
    assert_true(s->scene && s->image);
    daft_material_def mirror = daft_default_material_def(), glass = daft_default_material_def();
    mirror.mirror = 0.8f;
    glass.transmission = 0.9f;
    daft_entity_def ball = daft_default_entity_def(), floor = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE, ball.radius = 1;
    floor.shape = DAFT_SHAPE_BOX, floor.size = (daft_vec3){40, 1, 40}, floor.position.y = -1.5;
    assert_true(daft_entity_create(s->scene, &floor, NULL).id);
    ball.position = (daft_dvec3){5, 0, -1.2}, ball.material = daft_material_create(s->scene, &mirror, NULL);
    assert_true(daft_entity_create(s->scene, &ball, NULL).id);
    ball.position.z = 1.2, ball.material = daft_material_create(s->scene, &glass, NULL);
    assert_true(daft_entity_create(s->scene, &ball, NULL).id);
    daft_light_def light = daft_default_light_def();
    light.position = (daft_dvec3){2, 6, 3};
    assert_true(daft_light_create(s->scene, &light, NULL).id);
}

static void stage_drop(stage *s)
{
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
}

static uint64_t draw(stage *s, const daft_view *view)
{
    daft_error error;
    if (!daft_render(s->scene, view, s->image, &error)) fail_msg("%s", error.message);
    return daft_hash(daft_image_pixels(s->image), BYTES, 0);
}

static daft_view view_of(daft_quality quality)
{
    daft_view view = daft_default_view();
    view.quality = quality;
    return view;
}

/* The values of `high`, as engine/render/presets.c has them. */
static void test_knobs_make_one_quality_another(void **unused)
{
    (void)unused;
    stage s;
    stage_make(&s);
    daft_view high = view_of(DAFT_QUALITY_HIGH), made = view_of(DAFT_QUALITY_DRAFT), draft = made;
    made.samples = 4, made.mirror_depth = 6, made.refraction_depth = 16, made.min_weight = 1.0f / 2048,
    made.shadows = 1;
    assert_true(draw(&s, &made) == draw(&s, &high));
    assert_true(draw(&s, &draft) != draw(&s, &high));
    stage_drop(&s);
}

static void test_each_knob_turns_its_work_off(void **unused)
{
    (void)unused;
    stage s;
    stage_make(&s);
    daft_view view = view_of(DAFT_QUALITY_GAME);
    uint64_t all = draw(&s, &view);
    const daft_counters *c = daft_scene_counters(s.scene);
    assert_true(c->effects[DAFT_EFFECT_SHADOW].ran && c->effects[DAFT_EFFECT_REFLECTION].ran);
    assert_true(c->effects[DAFT_EFFECT_REFRACTION].ran);
    view.shadows = 0;
    assert_true(draw(&s, &view) != all);
    assert_false(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_SHADOW].ran);
    view = view_of(DAFT_QUALITY_GAME), view.mirror_depth = 0;
    assert_true(draw(&s, &view) != all);
    assert_false(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_REFLECTION].ran);
    view = view_of(DAFT_QUALITY_GAME), view.refraction_depth = 0;
    assert_true(draw(&s, &view) != all);
    assert_false(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_REFRACTION].ran);
    view = view_of(DAFT_QUALITY_GAME), view.min_weight = 1;
    assert_true(draw(&s, &view) != all);
    stage_drop(&s);
}

static void test_deepest_and_out_of_range(void **unused)
{
    (void)unused;
    stage s;
    stage_make(&s);
    daft_error error;
    daft_view view = view_of(DAFT_QUALITY_GAME);
    view.mirror_depth = view.refraction_depth = 32, view.min_weight = 0;
    draw(&s, &view);
    view.mirror_depth = 32, view.refraction_depth = 1; /* mirrors deeper than refraction */
    draw(&s, &view);
    view.mirror_depth = 33;
    assert_false(daft_render(s.scene, &view, s.image, &error));
    assert_non_null(strstr(error.message, "mirror_depth"));
    stage_drop(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_knobs_make_one_quality_another),
                                       cmocka_unit_test(test_each_knob_turns_its_work_off),
                                       cmocka_unit_test(test_deepest_and_out_of_range)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
