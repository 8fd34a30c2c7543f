/* scene: pictures without a part of the shading, and the box around a scene. */
#include "scene_fixture.h"

enum { WIDTH = 64, HEIGHT = 64 };

/* A ball on a wide box under a light above it, seen from the side; its material shows everything. */
static void build(fixture *f)
{
    daft_material_def look = daft_default_material_def();
    look.ambient = look.diffuse = (daft_vec3){0.5f, 0.25f, 0.1f};
    look.specular = (daft_vec3){1, 1, 1};
    look.mirror = 0.3f;
    look.diffuse_map = daft_texture_load(f->scene, DAFT_ROOT "/assets/textures/checker.png", NULL);
    daft_entity_def def = daft_default_entity_def();
    def.material = daft_material_create(f->scene, &look, NULL);
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 1, def.position = daft_dv3(5, 1, 0);
    assert_true(look.diffuse_map.id && daft_entity_create(f->scene, &def, NULL).id);
    def.shape = DAFT_SHAPE_BOX, def.size = (daft_vec3){20, 1, 20}, def.position = daft_dv3(5, -0.5, 0);
    assert_true(daft_entity_create(f->scene, &def, NULL).id);
    daft_light_def light = daft_default_light_def();
    light.position = daft_dv3(3, 6, -1);
    assert_true(daft_light_create(f->scene, &light, NULL).id);
}

static void draw(fixture *f, uint32_t without, uint8_t out[4 * WIDTH * HEIGHT])
{
    daft_image *image = daft_image_create(f->engine, WIDTH, HEIGHT, NULL);
    daft_view view = daft_default_view();
    view.camera = daft_camera_look_at(daft_dv3(0, 2, 0), daft_dv3(5, 0.5, 0), 1);
    view.without = without;
    assert_true(daft_render(f->scene, &view, image, NULL));
    memcpy(out, daft_image_pixels(image), 4 * WIDTH * HEIGHT);
    daft_image_destroy(image);
}

static void every_part_can_be_left_out(void **state)
{
    fixture *f = *state;
    static uint8_t whole[4 * WIDTH * HEIGHT], part[4 * WIDTH * HEIGHT], again[4 * WIDTH * HEIGHT];
    build(f);
    draw(f, 0, whole);
    for (uint32_t bit = 1; bit <= DAFT_WITHOUT_ALL; bit <<= 1) {
        draw(f, bit, part);
        if (memcmp(whole, part, sizeof whole) == 0) fail_msg("without %u: nothing has changed", bit);
    }
    draw(f, 0, again);
    assert_memory_equal(whole, again, sizeof whole);
}

static void what_is_left_out_is_not_paid_for(void **state)
{
    fixture *f = *state;
    static uint8_t pixels[4 * WIDTH * HEIGHT];
    build(f);
    draw(f, DAFT_WITHOUT_TEXTURES, pixels);
    const daft_counters *c = daft_scene_counters(f->scene);
    assert_true(c->effects[DAFT_EFFECT_LIGHTING].ran && !c->effects[DAFT_EFFECT_TEXTURE].ran);
    draw(f, DAFT_WITHOUT_SHADING, pixels);
    assert_true(c->effects[DAFT_EFFECT_TEXTURE].ran && !c->effects[DAFT_EFFECT_LIGHTING].ran);
    assert_true(c->shadow_rays == 0 && c->reflection_rays == 0);
}

static void unlit_surfaces_have_their_own_colour(void **state)
{
    fixture *f = *state;
    static uint8_t pixels[4 * WIDTH * HEIGHT];
    daft_material_def look = daft_default_material_def();
    look.ambient = (daft_vec3){0, 0, 0}, look.diffuse = (daft_vec3){1, 0, 1};
    daft_entity_def def = daft_default_entity_def();
    def.material = daft_material_create(f->scene, &look, NULL);
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 1, def.position = daft_dv3(5, 0.5, 0);
    assert_true(daft_entity_create(f->scene, &def, NULL).id);
    draw(f, DAFT_WITHOUT_SHADING, pixels);
    const uint8_t *middle = pixels + 4 * (HEIGHT / 2 * WIDTH + WIDTH / 2);
    assert_true(middle[0] == 255 && middle[1] == 0 && middle[2] == 255);
}

static void a_bit_that_means_nothing_is_refused(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_image *image = daft_image_create(f->engine, WIDTH, HEIGHT, NULL);
    daft_view view = daft_default_view();
    view.without = DAFT_WITHOUT_ALL + 1;
    assert_false(daft_render(f->scene, &view, image, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "without"));
    daft_image_destroy(image);
}

static void the_box_holds_what_is_visible(void **state)
{
    fixture *f = *state;
    daft_dvec3 low, high;
    daft_error error = {.code = DAFT_ERROR_IO};
    assert_false(daft_scene_get_bounds(f->scene, &low, &high, &error));
    assert_int_equal(error.code, DAFT_OK);
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 2, def.position = daft_dv3(1e7, 3, -5);
    daft_entity ball = daft_entity_create(f->scene, &def, NULL);
    assert_true(daft_scene_get_bounds(f->scene, &low, &high, &error));
    assert_true(low.x == 1e7 - 2 && low.y == 1 && low.z == -7 && high.x == 1e7 + 2 && high.y == 5 && high.z == -3);
    def.shape = DAFT_SHAPE_BOX, def.size = (daft_vec3){2, 2, 2}, def.position = daft_dv3(0, 0, 0);
    def.scale = (daft_vec3){1, 10, 1};
    assert_true(daft_entity_create(f->scene, &def, NULL).id);
    assert_true(daft_entity_set_visible(f->scene, ball, false, NULL));
    assert_true(daft_scene_get_bounds(f->scene, &low, &high, &error));
    assert_true(low.x == -1 && low.y == -10 && high.y == 10 && high.z == 1);
    assert_false(daft_scene_get_bounds(f->scene, NULL, &high, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_part_can_be_left_out, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_is_left_out_is_not_paid_for, set_up, tear_down),
        cmocka_unit_test_setup_teardown(unlit_surfaces_have_their_own_colour, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_bit_that_means_nothing_is_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_box_holds_what_is_visible, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
