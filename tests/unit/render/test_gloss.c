/* render: rough surfaces, what they mirror and let through, and denoising of it. Against the truth in closed form, by
 * integration in double, or by many samples. */
#include "stage.h"

#include "math/vec.h"

#include <stdio.h>

static const double PI = 3.14159265358979;

static daft_material_def metal(float roughness)
{
    daft_material_def m = daft_default_material_def();
    m.ambient = m.diffuse = m.specular = daft_v3(0, 0, 0);
    m.mirror = 1, m.roughness = roughness;
    return m;
}

static daft_entity add(stage *s, const daft_material_def *m, daft_entity_def def)
{
    daft_error error = {0};
    def.material = daft_material_create(s->scene, m, &error);
    const daft_entity e = daft_entity_create(s->scene, &def, &error);
    if (!e.id) fail_msg("%s", error.message);
    return e;
}

static void add_ball(stage *s, const daft_material_def *m, daft_dvec3 at, float radius)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = radius, def.position = at;
    add(s, m, def);
}

static void add_floor(stage *s, const daft_material_def *m, float side)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = daft_v3(side, 1, side), def.position = daft_dv3(0, -0.5, 0);
    add(s, m, def);
}

static void white_sky(stage *s)
{
    daft_scene_set_sky_color(s->scene, daft_v3(1, 1, 1));
    daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
    s->view.quality.edge_samples = 0;
}

/* The furnace: what loses no light is not to be seen before a white sky, however rough. */
static void nothing_is_lost_under_a_white_sky(void **unused)
{
    (void)unused;
    const float roughness[] = {0, 0.1f, 0.4f, 0.7f, 1};
    for (int k = 0; k < 10; k++) {
        stage *s = stage_make(2, NULL);
        white_sky(s);
        daft_material_def m = metal(roughness[k % 5]);
        add_ball(s, &m, daft_dv3(3, 0, -0.6), 0.8f);
        if (k >= 5) { /* some of it mirrored, the rest let through */
            m.mirror = 0, m.transmission = 1;
        }
        s->view.quality.mirror_depth = s->view.quality.refraction_depth = 32, s->view.quality.min_weight = 0;
        add_ball(s, &m, daft_dv3(3, 0, 1.2), 0.8f);
        for (int denoise = 0; denoise < 2; denoise++) {
            s->view.quality.denoise = denoise, s->view.quality.samples = denoise ? 4 : 1,
            s->view.quality.glossy_samples = 1 + 2 * denoise;
            draw(s);
            double worst = 0, sum = 0;
            for (int i = 0; i < PIXELS; i++)
                worst = fmax(worst, fabs((double)s->color[i].y - 1)), sum += (double)s->color[i].y;
            print_message("%s, roughness %.1f, %s: off by %.5f, %.5f in the mean\n", k < 5 ? "metal" : "glass",
                          (double)m.roughness, denoise ? "denoised" : "raw", worst, fabs(sum / PIXELS - 1));
            /* Paths that rough glass keeps inside are cut off after 32 surfaces. */
            assert_true(k <= 5 ? worst < 1e-3 : fabs(sum / PIXELS - 1) < 0.01);
        }
        stage_drop(s);
    }
}

enum { HEIGHTS = 64 };

/* The sky that the engine draws, by the sine of the height. */
static void read_sky(double sky[HEIGHTS + 1])
{
    stage *s = stage_make(1, NULL);
    daft_scene_set_sky_gradient(s->scene, daft_v3(0.9f, 0.9f, 0.9f), daft_v3(0.1f, 0.1f, 0.1f));
    s->view.camera.fov = 0.001f, s->view.quality.edge_samples = 0;
    for (int i = 0; i <= HEIGHTS; i++) {
        s->view.camera.pitch = (float)-asin((double)i / HEIGHTS);
        draw(s);
        sky[i] = (double)s->color[HEIGHT / 2 * WIDTH + WIDTH / 2].x;
    }
    stage_drop(s);
}

static double sky_at(const double sky[HEIGHTS + 1], double up)
{
    const double at = fmin(fabs(up), 1) * HEIGHTS;
    const int i = (int)fmin(at, HEIGHTS - 1);
    return sky[i] + (sky[i + 1] - sky[i]) * (at - i);
}

/* What a plane with GGX facets mirrors of a sky: over the normals of facets that are seen (Walter and others, 2007,
 * equations 33 and 34; Heitz, "Understanding the Masking-Shadowing Function", JCGT 3(2), 2014, equation 16), each once
 * for its area across the viewer's direction; below the plane the light comes from the facets' neighbours, mirrored.
 * `view`: unit, y up. */
static double mirrored_sky(double alpha, daft_dvec3 view, const double sky[HEIGHTS + 1])
{
    double sum = 0, weights = 0;
    enum { ACROSS = 600, ROUND = 400 };
    for (int i = 0; i < ACROSS; i++)
        for (int k = 0; k < ROUND; k++) {
            const double theta = (i + 0.5) / ACROSS * PI / 2, phi = (k + 0.5) / ROUND * 2 * PI;
            const daft_dvec3 n = daft_dv3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi));
            const double seen = daft_ddot(n, view), slope = tan(theta) / alpha;
            const double d = 1 / (PI * alpha * alpha * pow(cos(theta), 4) * (1 + slope * slope) * (1 + slope * slope));
            if (seen <= 0) continue;
            const double up = 2 * seen * n.y - view.y, weight = d * seen * sin(theta);
            sum += weight * sky_at(sky, up), weights += weight;
        }
    return sum / weights;
}

static void rough_mirrors_follow_ggx(void **unused)
{
    (void)unused;
    const double roughness[] = {0.3, 0.5, 0.8, 1};
    double sky[HEIGHTS + 1];
    read_sky(sky);
    for (int k = 0; k < 8; k++) {
        stage *s = stage_make(2, NULL);
        const daft_material_def m = metal((float)roughness[k % 4]);
        add_floor(s, &m, 4000);
        daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
        daft_scene_set_sky_gradient(s->scene, daft_v3(0.9f, 0.9f, 0.9f), daft_v3(0.1f, 0.1f, 0.1f));
        const double pitch = k < 4 ? 1.1 : 0.25;
        s->view.camera.position = daft_dv3(0, 5, 0), s->view.camera.pitch = (float)pitch;
        s->view.camera.fov = 0.02f, s->view.quality.denoise = 0, s->view.quality.glossy_samples = 64,
        s->view.quality.edge_samples = 0;
        draw(s);
        double mean = 0;
        for (int i = 0; i < PIXELS; i++) mean += (double)s->color[i].x / PIXELS;
        const double truth =
            mirrored_sky(roughness[k % 4] * roughness[k % 4], daft_dv3(-cos(pitch), sin(pitch), 0), sky);
        print_message("roughness %.1f, %.2f down: %.4f, truth %.4f\n", roughness[k % 4], pitch, mean, truth);
        assert_true(fabs(mean - truth) < 0.004);
        stage_drop(s);
    }
}

static void furnish(stage *s)
{
    daft_error error = {0};
    if (!daft_scene_load(s->scene, DAFT_ROOT "/assets/scenes/studio.scene", &error)) fail_msg("%s", error.message);
    assert_true(daft_scene_get_camera(s->scene, 0, &s->view.camera, &error));
    s->view.quality.edge_samples = 0, s->view.quality.mirror_depth = 3, s->view.quality.refraction_depth = 4;
}

/* Without rays for roughness all is smooth, to the byte; and what is smooth casts none of them. */
static void only_rough_surfaces_are_sampled(void **unused)
{
    (void)unused;
    stage *smooth = stage_make(2, NULL), *rough = stage_make(2, NULL), *both[2] = {smooth, rough};
    for (int k = 0; k < 2; k++) {
        const daft_material_def m = metal(k ? 0.5f : 0);
        white_sky(both[k]);
        daft_scene_set_sky_gradient(both[k]->scene, daft_v3(0, 0.2f, 0.8f), daft_v3(1, 1, 1));
        add_ball(both[k], &m, daft_dv3(3, 0, 0), 1);
        add_floor(both[k], &m, 1), add_ball(both[k], &m, daft_dv3(5, 0, 2), 1);
    }
    rough->view.quality.glossy_samples = 0;
    for (int k = 0; k < 2; k++) assert_false(draw(both[k])->effects[DAFT_EFFECT_DENOISE].ran);
    assert_memory_equal(daft_image_pixels(smooth->image), daft_image_pixels(rough->image), 4 * PIXELS);
    const uint64_t rays = draw(smooth)->reflection_rays, bytes = draw(smooth)->effects[DAFT_EFFECT_REFLECTION].bytes;
    smooth->view.quality.glossy_samples = 16;
    assert_int_equal(draw(smooth)->reflection_rays, rays);
    assert_int_equal(draw(smooth)->effects[DAFT_EFFECT_REFLECTION].bytes, bytes);
    rough->view.quality.glossy_samples = 4, rough->view.quality.mirror_depth = 1, rough->view.quality.denoise = 0;
    smooth->view.quality.mirror_depth = 1;
    assert_int_equal(draw(rough)->reflection_rays, 4 * draw(smooth)->reflection_rays);
    assert_true(draw(rough)->effects[DAFT_EFFECT_REFLECTION].bytes > bytes);
    stage_drop(smooth), stage_drop(rough);
}

static void find_truth(stage *s, daft_vec3 *truth)
{
    const daft_view kept = s->view;
    s->view.history = NULL;
    s->view.quality.denoise = 0, s->view.quality.samples = 16, s->view.quality.glossy_samples = 16;
    draw(s);
    memcpy(truth, s->color, PIXELS * sizeof *truth);
    s->view = kept;
}

/* Far closer by one sample of a pixel, and closer by four. */
static void denoised_is_closer(void **unused)
{
    (void)unused;
    static daft_vec3 truth[PIXELS];
    stage *s = stage_make(2, NULL);
    furnish(s);
    find_truth(s, truth);
    double raw[2], filtered[2];
    for (int k = 0; k < 2; k++) {
        s->view.quality.samples = k ? 4 : 1, s->view.quality.glossy_samples = 1;
        s->view.quality.denoise = 0, draw(s), raw[k] = distance(s->color, truth);
        s->view.quality.denoise = 1;
        assert_true(draw(s)->effects[DAFT_EFFECT_DENOISE].ran);
        filtered[k] = distance(s->color, truth);
        print_message("%d samples: error %.4f, denoised %.4f\n", s->view.quality.samples, raw[k], filtered[k]);
    }
    assert_true(filtered[0] < 0.75 * raw[0] && filtered[1] < 0.85 * raw[1]);
    stage_drop(s);
}

/* A rough floor mirrors the foot of a white wall sharply: the filter does not reach across. The wall stands at x = 4,
 * the sky is black, so that the floor shows the wall alone. */
static void reflections_are_sharp_where_things_touch(void **unused)
{
    (void)unused;
    static daft_vec3 truth[PIXELS];
    stage *s = stage_make(2, NULL);
    daft_material_def m = metal(0.35f), white = daft_default_material_def();
    white.emission = daft_v3(1, 1, 1), white.mirror = 0;
    daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
    daft_scene_set_sky_color(s->scene, daft_v3(0, 0, 0));
    add_floor(s, &m, 20);
    daft_entity_def wall = daft_default_entity_def();
    wall.shape = DAFT_SHAPE_BOX, wall.size = daft_v3(0.1f, 0.25f, 1), wall.position = daft_dv3(4, 0.125, 0);
    add(s, &white, wall);
    s->view.camera.position = daft_dv3(0, 1, 0), s->view.camera.pitch = 0.3f, s->view.camera.fov = 0.6f;
    s->view.quality.edge_samples = 0, s->view.quality.glossy_samples = 64, s->view.quality.denoise = 0;
    draw(s);
    memcpy(truth, s->color, sizeof truth);
    s->view.quality.glossy_samples = 1, s->view.quality.denoise = 1;
    draw(s);
    double sum = 0;
    int count = 0;
    for (int i = WIDTH; i < PIXELS; i++) /* the row of the floor below the wall's foot */
        if (s->normal[i].y > 0.9f && s->normal[i - WIDTH].y < 0.1f && s->depth[i - WIDTH] < 10)
            sum += (double)(s->color[i].x - truth[i].x), count++;
    print_message("beside the wall %.3f darker\n", -sum / count);
    assert_true(count > 20 && fabs(sum / count) < 0.08);
    stage_drop(s);
}

/* What was found before is carried along with a camera that moves. */
static void pictures_that_follow_each_other_help(void **unused)
{
    (void)unused;
    static daft_vec3 truth[PIXELS];
    daft_error error = {0};
    stage *s = stage_make(2, NULL);
    furnish(s);
    const daft_camera from = s->view.camera;
    double with = 0, alone = 0;
    s->view.quality.glossy_samples = 1;
    assert_non_null(s->view.history = daft_history_create(s->engine, &error));
    for (int k = 0; k < 10; k++) {
        s->view.camera = from;
        s->view.camera.yaw += 0.003f * (float)k, s->view.camera.position.x += 0.01 * k;
        draw(s);
    }
    static daft_vec3 last[PIXELS];
    memcpy(last, s->color, sizeof last);
    daft_history_forget(s->view.history);
    draw(s);
    find_truth(s, truth);
    with = distance(last, truth), draw(s), daft_history_forget(s->view.history), draw(s);
    alone = distance(s->color, truth);
    print_message("error %.4f after ten pictures, %.4f alone\n", with, alone);
    assert_true(with < 0.95 * alone);
    stage_drop(s);
}

/* A waxed floor in the shadows of boxes. */
static void furnish_with_shadows(stage *s)
{
    daft_material_def wax = metal(0.8f), chalk = daft_default_material_def();
    wax.diffuse = daft_v3(0.3f, 0.3f, 0.3f), wax.mirror = 0.6f;
    add_floor(s, &wax, 40);
    daft_entity_def box = daft_default_entity_def();
    box.shape = DAFT_SHAPE_BOX, box.size = daft_v3(0.8f, 1, 0.3f);
    for (int i = 0; i < 4; i++) {
        box.position = daft_dv3(4 + i, 0.5, 1.2 * i - 2);
        add(s, &chalk, box);
    }
    daft_light_def light = daft_default_light_def();
    light.position = daft_dv3(3, 9, -14);
    assert_true(daft_light_create(s->scene, &light, NULL).id);
    daft_scene_set_sky_gradient(s->scene, daft_v3(1, 0.9f, 0.7f), daft_v3(0.1f, 0.2f, 0.5f));
    s->view.camera.position = daft_dv3(0, 2, 0), s->view.camera.pitch = 0.4f;
}

/* How far the pixels that differ from those of another picture are from the truth, in steps of a byte. */
static double steps_off(const uint8_t *rgba, const uint8_t *other, const uint8_t *truth)
{
    double sum = 0;
    int count = 0;
    for (int i = 0; i < 4 * PIXELS; i += 4) {
        if (memcmp(&rgba[i], &other[i], 4) == 0) continue;
        for (int c = i; c < i + 3; c++) sum += (rgba[c] - truth[c]) * (rgba[c] - truth[c]);
        count++;
    }
    assert_true(count > 200);
    return sqrt(sum / (3 * count));
}

/* More samples of pixels at edges have what the filter found, in place of rays of their own, which would be noise. */
static void edges_have_what_was_filtered(void **unused)
{
    (void)unused;
    static uint8_t truth[4 * PIXELS], plain[4 * PIXELS];
    stage *s = stage_make(2, NULL);
    furnish_with_shadows(s);
    const daft_quality kept = s->view.quality;
    s->view.quality.samples = 16, s->view.quality.edge_samples = 0, s->view.quality.glossy_samples = 64;
    s->view.quality.denoise = false;
    draw(s), memcpy(truth, daft_image_pixels(s->image), sizeof truth);
    s->view.quality = kept, s->view.quality.glossy_samples = 1;
    uint64_t more[2]; /* rays, without the filter and with it */
    double off[2];
    for (int denoise = 0; denoise < 2; denoise++) {
        s->view.quality.denoise = denoise;
        s->view.quality.edge_samples = 0;
        const uint64_t few = draw(s)->reflection_rays;
        memcpy(plain, daft_image_pixels(s->image), sizeof plain);
        s->view.quality.edge_samples = 16;
        more[denoise] = draw(s)->reflection_rays - few;
        off[denoise] = steps_off(daft_image_pixels(s->image), plain, truth);
    }
    print_message("off by %.1f steps at edges, by rays of their own %.1f\n", off[1], off[0]);
    assert_true(more[0] > 1000 && more[1] == 0 && off[1] < 0.7 * off[0]);
    stage_drop(s);
}

static void pictures_are_the_same_everywhere(void **unused)
{
    (void)unused;
    static uint8_t first[4 * PIXELS];
    static const char *const NAMES[] = {NULL, "plain", "sse2", "avx2", "avx512"};
    for (int many = 0; many < 3; many++)
        for (int isa = 0; isa < 5; isa++) {
            daft_engine_def def = daft_default_engine_def();
            def.isa = NAMES[isa];
            daft_engine *probe = daft_engine_create(&def, NULL);
            if (!probe) continue; /* this machine or build lacks it */
            daft_engine_destroy(probe);
            stage *s = stage_make(isa + 1, def.isa);
            furnish(s);
            s->view.quality.edge_samples = many == 0 ? 4 : many == 1 ? 0 : 16;
            if (many == 1) s->view.quality.samples = 4, s->view.quality.glossy_samples = 2, s->view.quality.denoise = 1;
            draw(s);
            if (isa == 0) memcpy(first, daft_image_pixels(s->image), sizeof first);
            assert_memory_equal(first, daft_image_pixels(s->image), sizeof first);
            memset(daft_image_pixels(s->image), 7, 4 * PIXELS);
            for (int row = 0; row < HEIGHT; row += 32) {
                s->view.first_row = row, s->view.row_count = row + 32 < HEIGHT ? 32 : 0;
                draw(s);
            }
            assert_memory_equal(first, daft_image_pixels(s->image), sizeof first);
            stage_drop(s);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_lost_under_a_white_sky),
        cmocka_unit_test(rough_mirrors_follow_ggx),
        cmocka_unit_test(only_rough_surfaces_are_sampled),
        cmocka_unit_test(denoised_is_closer),
        cmocka_unit_test(reflections_are_sharp_where_things_touch),
        cmocka_unit_test(pictures_that_follow_each_other_help),
        cmocka_unit_test(edges_have_what_was_filtered),
        cmocka_unit_test(pictures_are_the_same_everywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
