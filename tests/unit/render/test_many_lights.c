/* render: many lights with a size, of which each point asks some. Against all of them, one by one, over many pictures.
 */
#include "stage.h"

#include <stdio.h>

enum { LIGHTS = 24, PICTURES = 64, ASKED = 6, BOUND = 9 };

/* A floor among pillars, in the light of rectangles, lamps and spots in all colors; of light `only`, unless it is less
 * than 0. */
static void furnish(stage *s, int count, int only, bool pillars, bool shadows)
{
    daft_error error = {0};
    daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
    for (int i = 0; i < (pillars ? 6 : 1); i++) {
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_BOX, def.size = i ? (daft_vec3){0.3f, 1.2f, 0.5f} : (daft_vec3){14, 0.1f, 14};
        def.position = i ? (daft_dvec3){i % 3 - 1.2, 0.6, 1.1 * i - 3.2} : (daft_dvec3){0, -0.05, 0};
        assert_true(daft_entity_create(s->scene, &def, &error).id);
    }
    for (int i = 0; i < count; i++) {
        static const daft_light_kind KINDS[] = {DAFT_LIGHT_RECTANGLE, DAFT_LIGHT_POINT, DAFT_LIGHT_SPOT};
        const float power = (float)(i % 7 + 1) * 0.6f / (float)count, hue = (float)(i % 5) / 4;
        daft_light_def def = daft_default_light_def();
        if (only >= 0 && i != only) continue;
        def.kind = KINDS[i % 3], def.casts_shadow = shadows;
        def.position = (daft_dvec3){3.4 * sin(2.4 * i), 2.6 + 0.05 * i, 3.4 * cos(2.4 * i)};
        def.direction = (daft_vec3){(float)(-0.3 * def.position.x), -1, (float)(-0.3 * def.position.z)};
        def.color = (daft_vec3){power * hue, power * (i % 2 ? 0.1f : 0.5f), power * (1 - hue)};
        if (i % 3 == 0) def.size = (daft_vec2){1.2f, 0.4f}, def.color.x *= 12, def.color.y *= 12, def.color.z *= 12;
        if (i % 3) def.radius = 0.25f;
        if (i % 3 == 2) def.outer_angle = 1.2f;
        if (!daft_light_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
    }
    s->view.camera.position = (daft_dvec3){-4, 3.6, 0}, s->view.camera.pitch = 0.75f;
    s->view.quality.edge_samples = 0, s->view.quality.denoise = 0, s->view.quality.half_light = 0;
    s->view.full = true;
    assert_non_null(s->view.history = daft_history_create(s->engine, &error));
}

/* Adds the mean of so many pictures. */
static void add_mean(stage *s, int pictures, double (*sum)[3])
{
    for (int k = 0; k < pictures; k++) {
        draw(s);
        for (int i = 0; i < PIXELS; i++) {
            sum[i][0] += (double)s->color[i].x / pictures, sum[i][1] += (double)s->color[i].y / pictures;
            sum[i][2] += (double)s->color[i].z / pictures;
        }
    }
}

/* The root of the mean square of what is between two pictures, and by color the mean. */
static double gap(double (*a)[3], double (*b)[3], double mean[3])
{
    double sum = 0;
    for (int c = 0; c < 3; c++) mean[c] = 0;
    for (int i = 0; i < PIXELS; i++)
        for (int c = 0; c < 3; c++) {
            const double off = a[i][c] - b[i][c];
            sum += off * off / (3 * PIXELS), mean[c] += off / PIXELS;
        }
    return sqrt(sum);
}

static double most_of(const double v[3]) { return fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2]))); }

/* The mean of pictures that ask few lights goes to the sum of pictures that ask one light each, as noise does. */
static void draws_are_right_in_the_mean(void **unused)
{
    (void)unused;
    static double truth[PIXELS][3], found[PIXELS][3], mean[3], off[3];
    static const int STEPS[] = {1, 4, 16, 64};
    for (int l = 0; l < LIGHTS; l++) {
        stage *s = stage_make(2, NULL);
        furnish(s, LIGHTS, l, true, true);
        add_mean(s, PICTURES, truth);
        stage_drop(s);
    }
    double light = 0, first = 0;
    for (int i = 0; i < PIXELS; i++) light += (truth[i][0] + truth[i][1] + truth[i][2]) / (3 * PIXELS);
    for (int k = 0; k < 4; k++) {
        stage *s = stage_make(2, NULL);
        furnish(s, LIGHTS, -1, true, true);
        memset(found, 0, sizeof found);
        add_mean(s, STEPS[k], found);
        const double error = gap(found, truth, mean);
        for (int c = 0; c < 3; c++) off[c] = mean[c] / light;
        if (k == 0) first = error;
        print_message("%d pictures: off by %.5f, in the mean by %.5f of the light\n", STEPS[k], error, most_of(off));
        assert_true(error < 1.3 * first / sqrt(STEPS[k]) + 0.002);
        assert_true(most_of(off) < 0.002);
        stage_drop(s);
    }
    assert_true(light > 0.1 && first > 0.005);
}

/* The more rays, the nearer: by the knob alone. */
static void more_rays_are_nearer(void **unused)
{
    (void)unused;
    static double truth[PIXELS][3], found[PIXELS][3], mean[3];
    double error[2];
    stage *s = stage_make(2, NULL);
    furnish(s, LIGHTS, -1, true, true);
    s->view.quality.shadow_samples = 64;
    add_mean(s, 2, truth);
    for (int k = 0; k < 2; k++) {
        s->view.quality.shadow_samples = k ? 16 : 1;
        memset(found, 0, sizeof found);
        add_mean(s, 1, found);
        error[k] = gap(found, truth, mean);
    }
    print_message("1 sample: error %.5f, 16: %.5f\n", error[0], error[1]);
    assert_true(error[1] < error[0] / 5);
    stage_drop(s);
}

/* Where nothing is in the way there is no noise, whichever lights are asked; in the dark neither. */
static void open_light_has_no_noise(void **unused)
{
    (void)unused;
    static daft_vec3 open[PIXELS];
    for (int k = 0; k < 2; k++) {
        stage *s = stage_make(2, NULL);
        furnish(s, LIGHTS, -1, false, k == 0);
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_BOX, def.size = (daft_vec3){1, 1, 1}, def.position = (daft_dvec3){0, -9, 0};
        assert_true(daft_entity_create(s->scene, &def, NULL).id);
        const uint64_t rays = draw(s)->effects[DAFT_EFFECT_SHADOW].rays;
        assert_true(k == 0 ? rays > PIXELS : rays == 0);
        if (k == 0) memcpy(open, s->color, sizeof open);
        double worst = 0;
        for (int i = 0; i < PIXELS; i++) worst = fmax(worst, fabs((double)open[i].x - (double)s->color[i].x));
        if (k) print_message("off by %.1e at most\n", worst);
        assert_true(worst < 1e-6);
        stage_drop(s);
    }
}

/* Up to six lights are asked each; of more, so many for each color and sample, however many there are. */
static void rays_are_bounded(void **unused)
{
    (void)unused;
    static const int COUNTS[] = {ASKED, ASKED + 1, 64, 300};
    for (int samples = 1; samples <= 4; samples *= 4)
        for (int k = 0; k < 4; k++) {
            stage *s = stage_make(2, NULL);
            furnish(s, COUNTS[k], -1, true, true);
            s->view.quality.shadow_samples = samples;
            const uint64_t rays = draw(s)->effects[DAFT_EFFECT_SHADOW].rays;
            const int rounds = (COUNTS[k] + 63) / 64; /* lights are drawn among so many at a time */
            const double of_each = (double)rays / PIXELS;
            print_message("%d lights, %d samples: %.2f rays of a pixel\n", COUNTS[k], samples, of_each);
            assert_true(of_each <= (k ? BOUND : ASKED) * samples * rounds && of_each > samples);
            stage_drop(s);
        }
}

/* What is drawn anew after a change is what a full picture shows; for any number of threads and any instruction set. */
static void kept_pictures_are_full_ones(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {"plain", "sse2", "avx2", "avx512"};
    static uint8_t first[3][4 * PIXELS];
    for (int k = -1; k < 4; k++) {
        daft_engine_def def = daft_default_engine_def();
        def.isa = k < 0 ? NULL : NAMES[k];
        daft_engine *probe = daft_engine_create(&def, NULL);
        if (!probe) continue; /* this machine or build lacks it */
        daft_engine_destroy(probe);
        stage *s = stage_make(k < 0 ? 2 : k + 1, def.isa);
        furnish(s, LIGHTS, -1, true, true);
        s->view.quality = daft_preset_quality(DAFT_PRESET_GAME);
        s->view.full = k < 0;
        daft_entity_def ball = daft_default_entity_def();
        ball.shape = DAFT_SHAPE_SPHERE, ball.radius = 0.1f;
        const daft_entity it = daft_entity_create(s->scene, &ball, NULL);
        for (int i = 0; i < 3; i++) {
            const daft_transform at = {.position = {0.2 * i, 0.3, 0.1}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
            assert_true(daft_entity_set_transform(s->scene, it, &at, true, NULL));
            draw(s);
            if (k < 0) memcpy(first[i], daft_image_pixels(s->image), sizeof first[i]);
            assert_memory_equal(first[i], daft_image_pixels(s->image), sizeof first[i]);
        }
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(draws_are_right_in_the_mean),
                                       cmocka_unit_test(more_rays_are_nearer),
                                       cmocka_unit_test(open_light_has_no_noise), cmocka_unit_test(rays_are_bounded),
                                       cmocka_unit_test(kept_pictures_are_full_ones)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
