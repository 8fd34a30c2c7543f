/* Degenerate views and lights: pictures, cameras, lights and suns at the ends of their ranges, and numbers that are
 * none. */
#include "degenerate.h"

/* ---- cameras and pictures ---- */

static void sizes_and_angles_at_their_ends(void **unused)
{
    (void)unused;
    const struct {
        int width, height;
        float fov;
    } cases[] = {{1, 1, 1.5f},      {1, 5000, 1.5f},   {5000, 1, 1.5f},    {1, 5000, 3.14f}, {5000, 1, 3.14f},
                 {64, 64, 1e-6f},   {64, 64, 3.1415f}, {1, 1, 1e-6f},      {1, 1, 3.1415f},  {3, 2, 1e-3f},
                 {16384, 2, 1e-6f}, {2, 16384, 1e-6f}, {2, 16384, 3.1415f}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        stage *s = stage_make();
        size_t count = (size_t)cases[i].width * (size_t)cases[i].height;
        float *depth = calloc(count, sizeof *depth);
        daft_vec3 *normal = calloc(count, sizeof *normal);
        daft_entity *entity = calloc(count, sizeof *entity);
        daft_error error;
        daft_image *image = daft_image_create(s->engine, cases[i].width, cases[i].height, &error);
        daft_view view = daft_default_view();
        view.camera = daft_camera_look_at(daft_dv3(0, 0, 0), daft_dv3(5, 0, 1.5), cases[i].fov);
        view.aov = (daft_aov){.depth = depth, .normal = normal, .entity = entity};
        for (int q = 0; q < QUALITY_COUNT; q++) {
            view.quality = daft_preset_quality(QUALITIES[q]);
            if (!daft_render(s->scene, &view, image, &error)) fail_msg("%s", error.message);
            char name[64];
            snprintf(name, sizeof name, "%d x %d, %g radians", cases[i].width, cases[i].height, (double)cases[i].fov);
            assert_sound(name, depth, normal, entity, count);
            size_t middle = (size_t)(cases[i].height / 2) * (size_t)cases[i].width + (size_t)(cases[i].width / 2);
            if (cases[i].fov < 0.01f && entity[middle].id != s->ball.id) fail_msg("%s: the ball is not there", name);
        }
        daft_image_destroy(image);
        free(depth);
        free(normal);
        free(entity);
        stage_drop(s);
    }
}

static void cameras_in_odd_places(void **unused)
{
    (void)unused;
    const daft_dvec3 places[] = {{5, 0, 1.5},   /* the centre of a ball */
                                 {4, 0, 1.5},   /* on its surface */
                                 {8, 0, 0.5},   /* in a block */
                                 {7.5, 0, 0.5}, /* on its side */
                                 {7.5, 1, 0},   /* on its corner */
                                 {5, -1.5, 0},  /* on the floor */
                                 {1e15, 0, 0},  {-1e300, 1e300, 0}, {1e-300, 0, 0}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        stage *s = stage_make();
        daft_camera camera = daft_default_camera();
        camera.position = places[i];
        for (int turn = 0; turn < 4; turn++) {
            camera.yaw = (float)turn * 1.5707963f;
            camera.pitch = turn == 3 ? 1.5707963f : 0;
            for (int q = 1; q < QUALITY_COUNT; q += 2) {
                char name[64];
                snprintf(name, sizeof name, "camera %zu, turn %d, quality %d", i, turn, q);
                picture *p = draw_from(s, QUALITIES[q], camera);
                assert_picture_sound(name, p);
                free(p);
            }
        }
        stage_drop(s);
    }
}

/* ---- lights ---- */

static void lights_in_odd_places(void **unused)
{
    (void)unused;
    edge_samples = 0;                       /* what a light adds may hide an edge that was there without it */
    const daft_dvec3 places[] = {{0, 0, 0}, /* the camera */
                                 {5, 0, 1.5},  {4, 0, 1.5},  {8, 0, 0.5},  {7.5, 0, 0.5}, {7.5, 1, 0},
                                 {5, -1.5, 0}, {1e30, 0, 0}, {0, 1e38, 0}, {1e-40, 0, 0}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        stage *s = stage_make();
        light(s, DAFT_LIGHT_POINT, places[i], daft_v3(0, 0, 0), 0.5f);
        stage *without = stage_make();
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *p = draw(s, QUALITIES[q]), *dark = draw(without, QUALITIES[q]);
            assert_picture_sound("light", p);
            for (size_t k = 0; k < PIXELS; k++) /* light adds: what is not a number would be black */
                for (size_t c = 0; c < 3; c++)
                    if (p->pixels[4 * k + c] < dark->pixels[4 * k + c])
                        fail_msg("light %zu, quality %d: pixel %zu is darker than without", i, q, k);
            free(p);
            free(dark);
        }
        stage_drop(s);
        stage_drop(without);
    }
    edge_samples = -1;
}

/* A sun along a wall gives it nothing; one of any length that a float has gives the same. */
static void suns_at_their_ends(void **unused)
{
    (void)unused;
    const struct {
        daft_vec3 direction;
        bool lit;
    } suns[] = {{{0, -1, 0}, false},     {{0, 0, 1}, false},      {{0, -1e-30f, 0}, false}, {{-1, 0, 0}, false},
                {{1, 0, 0}, true},       {{1e30f, 0, 0}, true},   {{1e-40f, 0, 0}, true},   {{FLT_MAX, 0, 0}, true},
                {{1e-7f, -1, 0}, false}, {{-1e-7f, -1, 0}, false}};
    for (size_t i = 0; i < sizeof suns / sizeof suns[0]; i++) {
        stage *s = stage_bare(NULL);
        add(s, box(daft_dv3(5, 0, 0), daft_v3(1, 100, 100)));
        light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), suns[i].direction, 1);
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *p = draw(s, QUALITIES[q]);
            assert_picture_sound("sun", p);
            for (size_t k = 0; k < PIXELS; k++) {
                int value = p->pixels[4 * k]; /* ambient: 0.8 times 0.2, sRGB 111 */
                if (suns[i].lit ? value < 200 : abs(value - 111) > 1)
                    fail_msg("sun %zu, quality %d: pixel %zu is %d", i, q, k, value);
            }
            free(p);
        }
        stage_drop(s);
    }
}

static void colors_beyond_all_bounds_are_white(void **unused)
{
    (void)unused;
    const float colors[] = {1e10f, 1e30f, FLT_MAX};
    for (size_t i = 0; i < sizeof colors / sizeof colors[0]; i++) {
        float c = colors[i];
        daft_material_def bright = daft_default_material_def();
        bright.diffuse = bright.specular = bright.emission = bright.ambient = bright.mirror_tint = daft_v3(c, c, c);
        bright.mirror = 0.5f;
        stage *s = stage_make();
        daft_material material = daft_material_create(s->scene, &bright, NULL);
        assert_true(material.id);
        assert_true(daft_entity_set_material(s->scene, s->ball, material, NULL));
        daft_scene_set_ambient(s->scene, daft_v3(c, c, c));
        light(s, DAFT_LIGHT_POINT, daft_dv3(0, 3, 0), daft_v3(0, 0, 0), c);
        light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), daft_v3(1, -1, 0), c);
        daft_scene_set_sky_color(s->scene, daft_v3(c, c, c));
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *p = draw(s, QUALITIES[q]);
            assert_picture_sound("color", p);
            for (size_t k = 0; k < PIXELS; k++)
                if (p->pixels[4 * k] != 255 || p->pixels[4 * k + 1] != 255 || p->pixels[4 * k + 2] != 255)
                    fail_msg("color %g, quality %d: pixel %zu of entity 0x%x is %d %d %d", (double)c, q, k,
                             p->entity[k].id, p->pixels[4 * k], p->pixels[4 * k + 1], p->pixels[4 * k + 2]);
            free(p);
        }
        stage_drop(s);
    }
}

/* ---- bad numbers in the definitions themselves ---- */

static void a_light_without_numbers_is_refused(void **unused)
{
    (void)unused;
    stage *s = stage_make();
    daft_error error;
    daft_light_def def = daft_default_light_def();
    def.color.y = NAN;
    assert_int_equal(daft_light_create(s->scene, &def, &error).id, 0);
    assert_non_null(strstr(error.message, "color.y"));
    def = daft_default_light_def();
    def.kind = DAFT_LIGHT_SUN, def.direction = daft_v3(0, 0, 0);
    assert_int_equal(daft_light_create(s->scene, &def, &error).id, 0);
    assert_non_null(strstr(error.message, "direction"));
    daft_view view = daft_default_view();
    view.camera.position.x = NAN;
    assert_false(daft_render(s->scene, &view, s->image, &error));
    assert_non_null(strstr(error.message, "position"));
    view = daft_default_view();
    view.camera.fov = 0;
    assert_false(daft_render(s->scene, &view, s->image, &error));
    view.camera.fov = 3.1416f;
    assert_false(daft_render(s->scene, &view, s->image, &error));
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_and_angles_at_their_ends),
        cmocka_unit_test(cameras_in_odd_places),
        cmocka_unit_test(lights_in_odd_places),
        cmocka_unit_test(suns_at_their_ends),
        cmocka_unit_test(colors_beyond_all_bounds_are_white),
        cmocka_unit_test(a_light_without_numbers_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
