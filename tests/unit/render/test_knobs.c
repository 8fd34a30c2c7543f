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

static daft_view view_of(daft_preset quality)
{
    daft_view view = daft_default_view();
    view.quality = daft_preset_quality(quality);
    return view;
}

/* The values of `high`, as engine/render/presets.c has them. */
static void test_knobs_make_one_quality_another(void **unused)
{
    (void)unused;
    stage s;
    stage_make(&s);
    daft_view high = view_of(DAFT_PRESET_HIGH), made = view_of(DAFT_PRESET_DRAFT), draft = made;
    made.quality.edge_samples = 16, made.quality.edge_contrast = 0.5f, made.quality.mirror_depth = 6,
    made.quality.refraction_depth = 16;
    made.quality.min_weight = 1.0f / 2048, made.quality.shadows = true;
    made.quality.texture_filter = DAFT_TEXTURE_ANISOTROPIC4;
    assert_true(draw(&s, &made) == draw(&s, &high));
    assert_true(draw(&s, &draft) != draw(&s, &high));
    stage_drop(&s);
}

static void test_each_knob_turns_its_work_off(void **unused)
{
    (void)unused;
    stage s;
    stage_make(&s);
    daft_view view = view_of(DAFT_PRESET_GAME);
    uint64_t all = draw(&s, &view);
    const daft_counters *c = daft_scene_counters(s.scene);
    assert_true(c->effects[DAFT_EFFECT_SHADOW].ran && c->effects[DAFT_EFFECT_REFLECTION].ran);
    assert_true(c->effects[DAFT_EFFECT_REFRACTION].ran);
    view.quality.shadows = 0;
    assert_true(draw(&s, &view) != all);
    assert_false(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_SHADOW].ran);
    view = view_of(DAFT_PRESET_GAME), view.quality.mirror_depth = 0;
    assert_true(draw(&s, &view) != all);
    assert_false(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_REFLECTION].ran);
    view = view_of(DAFT_PRESET_GAME), view.quality.refraction_depth = 0;
    assert_true(draw(&s, &view) != all);
    assert_false(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_REFRACTION].ran);
    view = view_of(DAFT_PRESET_GAME), view.quality.min_weight = 1;
    assert_true(draw(&s, &view) != all);
    stage_drop(&s);
}

/* Where no rays are followed, a mirror and a sheet show the sky: what rays see, too, where nothing else stands. */
static void test_depth_0_shows_the_sky(void **unused)
{
    (void)unused;
    stage s;
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    s.engine = daft_engine_create(&def, &error), s.scene = daft_scene_create(s.engine, &error);
    s.image = daft_image_create(s.engine, WIDTH, HEIGHT, &error);
    daft_scene_set_sky_gradient(s.scene, (daft_vec3){0.1f, 0.3f, 0.8f}, (daft_vec3){0.9f, 0.8f, 0.6f});
    daft_material_def mirror = daft_default_material_def(), sheet = daft_default_material_def();
    mirror.mirror = 0.8f, sheet.transmission = 0.9f, sheet.refractive_index = 1;
    const daft_vec3 places[3] = {{4, -1, 0}, {4, 1, 0}, {4, -1, 2}};
    daft_mesh_def shape = daft_default_mesh_def();
    shape.positions = places, shape.vertex_count = 3;
    shape.indices = (const uint32_t[3]){0, 1, 2}, shape.triangle_count = 1;
    daft_mesh mesh = daft_mesh_create(s.scene, &shape, NULL);
    daft_entity_def ball = daft_default_entity_def(), pane = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE, ball.radius = 1, ball.position = (daft_dvec3){5, 0, -1.5};
    ball.material = daft_material_create(s.scene, &mirror, NULL);
    pane.shape = DAFT_SHAPE_MESH, pane.mesh = mesh, pane.material = daft_material_create(s.scene, &sheet, NULL);
    for (int k = 0; k < 2; k++) {
        const daft_entity only = daft_entity_create(s.scene, k ? &pane : &ball, NULL);
        daft_view none = view_of(DAFT_PRESET_GAME);
        none.quality.edge_samples = 0;
        const uint64_t rays = draw(&s, &none);
        none.quality.mirror_depth = none.quality.refraction_depth = 0;
        assert_true(draw(&s, &none) == rays);
        none.quality.mirror_depth = 1;
        assert_true(draw(&s, &none) == rays);
        assert_true(daft_entity_destroy(s.scene, only, NULL));
        assert_true(draw(&s, &none) != rays);
    }
    stage_drop(&s);
}

static void test_deepest_and_out_of_range(void **unused)
{
    (void)unused;
    stage s;
    stage_make(&s);
    daft_error error;
    daft_view view = view_of(DAFT_PRESET_GAME);
    view.quality.mirror_depth = view.quality.refraction_depth = 32, view.quality.min_weight = 0;
    draw(&s, &view);
    view.quality.mirror_depth = 32, view.quality.refraction_depth = 1; /* mirrors deeper than refraction */
    draw(&s, &view);
    view.quality.mirror_depth = 33;
    assert_false(daft_render(s.scene, &view, s.image, &error));
    assert_string_equal(error.message, "quality.mirror_depth is 33; it must be between 0 and 32");
    stage_drop(&s);
}

/* ---- presets ---------------------------------------------------------------------------------------------------- */

/* The defaults of the rows are those of the preset `game`; every preset is one that daft_render takes. */
static void test_presets_are_whole(void **unused)
{
    (void)unused;
    daft_error error;
    char bytes[2][256];
    const daft_quality game = daft_preset_quality(DAFT_PRESET_GAME);
    daft_quality rows;
    daft_struct_default(DAFT_STRUCT_QUALITY, &rows);
    const size_t size = daft_struct_pack(DAFT_STRUCT_QUALITY, &rows, bytes[0], sizeof bytes[0]);
    assert_true(size > 40 && size <= sizeof bytes[0]);
    daft_struct_pack(DAFT_STRUCT_QUALITY, &game, bytes[1], sizeof bytes[1]);
    assert_memory_equal(bytes[0], bytes[1], size);
    for (daft_preset preset = DAFT_PRESET_DRAFT; preset <= DAFT_PRESET_REFERENCE; preset++) {
        daft_preset same;
        const daft_quality quality = daft_preset_quality(preset);
        assert_true(daft_struct_check(DAFT_STRUCT_QUALITY, &quality, &error));
        assert_true(daft_preset_parse(daft_preset_name(preset), &same) && same == preset);
    }
    assert_int_equal(daft_preset_quality((daft_preset)77).edge_samples, game.edge_samples);
    assert_string_equal(daft_preset_name((daft_preset)77), "unknown");
}

static void test_a_scene_keeps_what_it_asks_for(void **unused)
{
    (void)unused;
    stage s;
    daft_error error;
    stage_make(&s);
    assert_int_equal(daft_scene_quality(s.scene).edge_samples, 4);
    const uint64_t state = daft_scene_hash(s.scene);
    daft_quality wish = daft_preset_quality(DAFT_PRESET_HIGH);
    assert_true(daft_scene_set_quality(s.scene, &wish, &error));
    assert_int_equal(daft_scene_quality(s.scene).edge_samples, 16);
    assert_true(daft_scene_hash(s.scene) == state);
    wish.samples = 3;
    assert_false(daft_scene_set_quality(s.scene, &wish, &error));
    assert_string_equal(error.message, "samples is 3; it must be 1, 4, 8 or 16");
    assert_int_equal(daft_scene_quality(s.scene).edge_samples, 16);
    stage_drop(&s);
}

/* ---- single knobs ------------------------------------------------------------------------------------------------ */

static void test_trees_draw_one_picture(void **unused)
{
    (void)unused;
    stage s;
    stage_make(&s);
    daft_view view = view_of(DAFT_PRESET_GAME);
    const uint64_t raster = draw(&s, &view);
    view.quality.tree = DAFT_TREE_BVH;
    assert_true(draw(&s, &view) == raster);
    view.quality.tree = DAFT_TREE_KDTREE;
    assert_true(draw(&s, &view) == raster);
    view.quality.tree = DAFT_TREE_RASTER; /* the trees that were built are no longer used */
    assert_true(draw(&s, &view) == raster);
    stage_drop(&s);
}

/* A picture drawn at half the size: each filter gives another, nearest is made of the small picture's pixels, and equal
 * pixels stay as they are. */
static void test_scales(void **unused)
{
    (void)unused;
    stage s;
    daft_error error;
    stage_make(&s);
    daft_view view = view_of(DAFT_PRESET_GAME);
    uint64_t all[3];
    view.quality.scale = 0.5f;
    for (int i = 0; i < 3; i++) view.quality.upscale = (daft_upscale)i, all[i] = draw(&s, &view);
    assert_true(all[0] != all[1] && all[1] != all[2] && all[0] != all[2]);
    assert_int_equal(daft_scene_counters(s.scene)->width, daft_image_width(s.image) / 2);
    static uint8_t enlarged[BYTES];
    memcpy(enlarged, daft_image_pixels(s.image), BYTES);
    const int width = daft_image_width(s.image), height = daft_image_height(s.image);
    daft_image *small = daft_image_create(s.engine, width / 2, height / 2, &error);
    view.quality.scale = 1;
    assert_true(daft_render(s.scene, &view, small, &error));
    for (int i = 0; i < width * height; i++)
        assert_memory_equal(enlarged + 4 * i,
                            daft_image_pixels(small) + 4 * (i / width / 2 * (width / 2) + i % width / 2), 4);
    daft_image_destroy(small);
    view.quality.scale = 0.5f, view.first_row = 32;
    assert_false(daft_render(s.scene, &view, s.image, &error));
    assert_string_equal(error.message,
                        "quality.scale is 0.5; it must be 1 where a view has channels or is a band of the "
                        "picture");
    stage_drop(&s);
}

/* The ground of the scene has a texture, seen from afar and from near. */
static void test_texture_filters_differ(void **unused)
{
    (void)unused;
    stage s;
    daft_error error;
    stage_make(&s);
    if (!daft_scene_load(s.scene, DAFT_ROOT "/assets/scenes/hello.scene", &error)) fail_msg("%s", error.message);
    daft_view view = view_of(DAFT_PRESET_GAME);
    assert_true(daft_scene_get_camera(s.scene, 0, &view.camera, &error));
    enum { FILTERS = DAFT_TEXTURE_ANISOTROPIC16 + 1 };
    uint64_t all[FILTERS];
    for (int i = 0; i < FILTERS; i++) view.quality.texture_filter = (daft_texture_filter)i, all[i] = draw(&s, &view);
    for (int i = 0; i < FILTERS; i++)
        for (int k = 0; k < i; k++) assert_true(all[i] != all[k]);
    stage_drop(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_knobs_make_one_quality_another),
                                       cmocka_unit_test(test_each_knob_turns_its_work_off),
                                       cmocka_unit_test(test_presets_are_whole),
                                       cmocka_unit_test(test_a_scene_keeps_what_it_asks_for),
                                       cmocka_unit_test(test_trees_draw_one_picture),
                                       cmocka_unit_test(test_scales),
                                       cmocka_unit_test(test_texture_filters_differ),
                                       cmocka_unit_test(test_depth_0_shows_the_sky),
                                       cmocka_unit_test(test_deepest_and_out_of_range)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
