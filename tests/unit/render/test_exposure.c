/* render: exposure and tone curves, against their formulas in double; that they are off by default, the same bytes on
 * every instruction set, before antialiasing; metering, for a picture by itself and in series. */
#include "daft.h"

#include "math/simd/dispatch.h"
#include "shade/shade.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "stage.h"

/* ---- curves ---- */

static double aces(double x)
{
    x *= 0.72317;
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

/* As Wrensch (2023) has it: columns of the matrices, powers spelled out. */
static void agx(const double light[3], double out[3])
{
    static const double IN[9] = {0.842479062253094,  0.0423282422610123, 0.0423756549057051,
                                 0.0784335999999992, 0.878468636469772,  0.0784336,
                                 0.0792237451477643, 0.0791661274605434, 0.879142973793104};
    static const double OUT[9] = {1.19687900512017,    -0.0528968517574562, -0.0529716355144438,
                                  -0.0980208811401368, 1.15190312990417,    -0.0980434501171241,
                                  -0.0990297440797205, -0.0989611768448433, 1.15107367264116};
    double v[3];
    for (int k = 0; k < 3; k++) {
        const double in = IN[k] * light[0] + IN[3 + k] * light[1] + IN[6 + k] * light[2];
        const double x = fmax(0, fmin(1, (log2(fmax(in, 1e-10)) + 12.47393) / (4.026069 + 12.47393)));
        v[k] = 15.5 * pow(x, 6) - 40.14 * pow(x, 5) + 31.96 * pow(x, 4) - 6.868 * pow(x, 3) + 0.4298 * x * x +
               0.1191 * x - 0.00232;
    }
    for (int k = 0; k < 3; k++) {
        const double shown = OUT[k] * v[0] + OUT[3 + k] * v[1] + OUT[6 + k] * v[2];
        out[k] = pow(fmax(0, fmin(1, shown)), 2.2);
    }
}

static void curves_are_their_formulas(void **unused)
{
    (void)unused;
    enum { COUNT = 4096 };
    static float light[3][COUNT + 16], first[3][COUNT + 16], out[3][COUNT + 16];
    for (int i = 0; i < COUNT; i++) {
        light[0][i] = exp2f((float)i / COUNT * 24 - 14);
        light[1][i] = light[0][i] * (0.2f + 0.8f * (float)(i % 7) / 6), light[2][i] = light[0][i] * (float)(i % 5) / 4;
    }
    light[0][0] = -1, light[1][0] = NAN, light[2][0] = INFINITY;
    const float *const from[3] = {light[0], light[1], light[2]};
    for (int curve = 0; curve <= DAFT_TONE_AGX; curve++)
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            const daft_tone tone = {0.5f, (daft_tone_curve)curve};
            double worst = 0;
            daft_shade_kernels_for(isa)->tone(&tone, from, COUNT, (float *const[3]){out[0], out[1], out[2]});
            if (isa == 0) memcpy(first, out, sizeof first);
            for (int k = 0; k < 3; k++) assert_memory_equal(first[k], out[k], COUNT * sizeof(float));
            for (int k = 0; k < 3; k++) assert_true(out[k][0] >= 0 && out[k][0] <= 2e9f);
            for (int i = 1; i < COUNT; i++) {
                double scaled[3], wanted[3];
                for (int k = 0; k < 3; k++) wanted[k] = scaled[k] = (double)light[k][i] * exp2(0.5);
                for (int k = 0; k < 3 && curve == DAFT_TONE_ACES; k++) wanted[k] = aces(scaled[k]);
                if (curve == DAFT_TONE_AGX) agx(scaled, wanted);
                for (int k = 0; k < 3; k++)
                    worst = fmax(worst, fabs((double)out[k][i] - wanted[k]) / fmax(1, wanted[k]));
            }
            if (isa == 0) print_message("curve %d: off by %.2g\n", curve, worst);
            assert_true(worst < 1e-5);
        }
    assert_true(fabs(aces(0.18) - 0.18) < 1e-5);           /* grey stays */
    for (int curve = 0; curve <= DAFT_TONE_AGX; curve++) { /* white begins where it is said to */
        const daft_tone tone = {-2, (daft_tone_curve)curve};
        const float white = daft_tone_white(&tone);
        for (int k = 0; k < 3; k++) light[k][0] = white, light[k][1] = 0.8f * white;
        daft_shade_kernels_for(0)->tone(&tone, from, 2, (float *const[3]){out[0], out[1], out[2]});
        assert_true(out[1][0] > 0.995f && out[1][0] < 1.003f && out[1][1] < 0.993f);
    }
}

/* ---- pictures ---- */

static void set_exposure(stage *s, float ev, bool automatic, daft_tone_curve curve)
{
    daft_error error = {0};
    const daft_exposure exposure = {ev, automatic, curve};
    if (!daft_scene_set_exposure(s->scene, &exposure, &error)) fail_msg("%s", error.message);
}

static void add_sphere(stage *s, daft_dvec3 at, float radius, float white, float mirror)
{
    daft_error error = {0};
    daft_material_def m = daft_default_material_def();
    m.ambient = m.diffuse = (daft_vec3){white, white / 2, white}, m.specular = (daft_vec3){0, 0, 0};
    m.mirror = mirror;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = radius, def.position = at;
    def.material = daft_material_create(s->scene, &m, &error);
    if (!daft_entity_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
}

/* Spheres, one of them a mirror, under a sun of some size and a sky; all light is times `light`. */
static stage *lit_stage(float light, const char *isa, int threads)
{
    stage *s = stage_make(threads, isa);
    daft_error error = {0};
    s->view.aov = (daft_aov){0};
    daft_scene_set_ambient(s->scene, daft_v3(0.2f * light, 0.2f * light, 0.3f * light));
    daft_scene_set_ambient_occlusion(s->scene, 2);
    daft_scene_set_sky_gradient(s->scene, daft_v3(0.2f * light, 0.4f * light, light),
                                daft_v3(1.5f * light, 1.25f * light, light));
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = (daft_vec3){1, -2, 0.5f}, sun.color = daft_v3(light, light, light);
    sun.disc = 0.05f;
    assert_true(daft_light_create(s->scene, &sun, &error).id);
    add_sphere(s, (daft_dvec3){6, -101, 0}, 100, 0.5f, 0);
    add_sphere(s, (daft_dvec3){5, 0, -1.5}, 1, 0.9f, 0);
    add_sphere(s, (daft_dvec3){6, 0.2, 1.5}, 1.2f, 0.1f, 0.6f);
    return s;
}

static bool same_bytes(stage *a, stage *b)
{
    return memcmp(daft_image_pixels(a->image), daft_image_pixels(b->image), 4 * PIXELS) == 0;
}

/* Light that is eight times brighter, and three stops less: the same bytes of every preset, so tone comes before all
 * that clamps and averages, and before the choice of edges. */
static void stops_are_powers_of_two(void **unused)
{
    (void)unused;
    for (int preset = DAFT_PRESET_DRAFT; preset <= DAFT_PRESET_REFERENCE; preset++)
        for (int grid = 0; grid < 2; grid++) {
            stage *a = lit_stage(1, NULL, 2), *b = lit_stage(8, NULL, 2);
            a->view.quality = daft_preset_quality((daft_preset)preset);
            if (grid) a->view.quality.edge_samples = 16, a->view.quality.denoise = false;
            b->view.quality = a->view.quality;
            set_exposure(b, -3, false, DAFT_TONE_NONE);
            draw(a), draw(b);
            if (!same_bytes(a, b)) fail_msg("%s differs, grid %d", daft_preset_name((daft_preset)preset), grid);
            assert_true(daft_scene_counters(b->scene)->ev == -3);
            set_exposure(b, 0, false, DAFT_TONE_NONE);
            draw(b);
            assert_false(same_bytes(a, b));
            stage_drop(a), stage_drop(b);
        }
}

static void the_same_bytes_everywhere(void **unused)
{
    (void)unused;
    for (int k = 0; k < 4; k++) {
        stage *a = lit_stage(2, NULL, 2), *b = lit_stage(2, DAFT_NARROWEST_ISA, 1);
        set_exposure(a, 0.3f, k & 1, k & 2 ? DAFT_TONE_AGX : DAFT_TONE_ACES);
        set_exposure(b, 0.3f, k & 1, k & 2 ? DAFT_TONE_AGX : DAFT_TONE_ACES);
        draw(a);
        for (b->view.first_row = 0; b->view.first_row < HEIGHT; b->view.first_row += 64) {
            b->view.row_count = b->view.first_row + 64 < HEIGHT ? 64 : 0;
            draw(b);
        }
        assert_true(same_bytes(a, b));
        stage_drop(a), stage_drop(b);
    }
}

/* ---- metering ---- */

/* Nothing but a sky of one light: that becomes middle grey, and what is asked for on top. A picture of the metered
 * stops is the same. */
static void metered_light_becomes_grey(void **unused)
{
    (void)unused;
    stage *s = stage_make(2, NULL);
    daft_scene_set_sky_color(s->scene, daft_v3(3, 3, 3));
    set_exposure(s, 1, true, DAFT_TONE_NONE);
    const double ev = draw(s)->ev;
    assert_true(fabs(ev - (1 + log2(0.18 / 3))) < 1e-5);
    const uint8_t *pixel = daft_image_pixels(s->image);
    assert_true(pixel[0] == 162);    /* sRGB of 0.36 */
    assert_true(s->color[0].x == 3); /* channels have light as it is */
    daft_scene_set_sky_color(s->scene, daft_v3(0, 0, 0));
    assert_true(draw(s)->ev == 9); /* the dark is not made day */
    stage_drop(s);
    stage *a = lit_stage(20, NULL, 2), *b = lit_stage(20, NULL, 2);
    set_exposure(a, 0, true, DAFT_TONE_AGX);
    const float found = (float)draw(a)->ev;
    set_exposure(b, found, false, DAFT_TONE_AGX);
    draw(b);
    assert_true(same_bytes(a, b));
    print_message("metered: %g stops\n", (double)found);
    assert_true(found < -3.5f && found > -7);
    stage_drop(a), stage_drop(b);
}

/* In a series it starts right, stays where light hardly changes, follows with a time constant of half a second where it
 * does, and ends. A cut starts again. */
static void exposure_follows_the_light(void **unused)
{
    (void)unused;
    stage *s = stage_make(2, NULL);
    daft_error error = {0};
    s->view.aov = (daft_aov){0};
    assert_non_null(s->view.history = daft_history_create(s->engine, &error));
    set_exposure(s, 0, true, DAFT_TONE_NONE);
    daft_scene_set_sky_color(s->scene, daft_v3(0.18f, 0.18f, 0.18f));
    assert_true(fabs(draw(s)->ev) < 1e-5);
    draw(s), draw(s);
    assert_int_equal(draw(s)->tiles_drawn, 0);
    daft_scene_set_sky_color(s->scene, daft_v3(0.19f, 0.19f, 0.19f));
    assert_true(fabs(draw(s)->ev) < 1e-5);
    daft_scene_set_sky_color(s->scene, daft_v3(0.72f, 0.72f, 0.72f)); /* two stops more */
    double left = 2;
    for (int i = 0; i < 30; i++) {
        daft_scene_begin_tick(s->scene);
        assert_true(daft_scene_step(s->scene, 1.0f / 60, &error));
        left *= 1 - (1.0 / 60) / (1.0 / 60 + 0.5);
        assert_true(fabs(draw(s)->ev - (left - 2)) < 1e-4);
    }
    assert_true(fabs(left - 2 * exp(-1)) < 0.02); /* after half a second */
    for (int i = 0; i < 200; i++) draw(s);
    assert_true(fabs(draw(s)->ev + 2) < 1.0 / 64 + 1e-5);
    assert_int_equal(draw(s)->tiles_drawn, 0);
    daft_scene_set_sky_color(s->scene, daft_v3(0.18f, 0.18f, 0.18f));
    daft_history_forget(s->view.history);
    assert_true(fabs(draw(s)->ev) < 1e-5);
    stage_drop(s);
}

static void kept_pictures_know_of_exposure(void **unused)
{
    (void)unused;
    stage *s = lit_stage(1, NULL, 2);
    daft_error error = {0};
    daft_scene_set_ambient_occlusion(s->scene, 0);
    s->view.quality = daft_preset_quality(DAFT_PRESET_GAME), s->view.quality.shadow_samples = 0;
    assert_non_null(s->view.history = daft_history_create(s->engine, &error));
    for (int i = 0; i < 3; i++) draw(s);
    assert_int_equal(draw(s)->tiles_drawn, 0);
    set_exposure(s, 0, false, DAFT_TONE_AGX);
    assert_true(draw(s)->tiles_drawn > 0);
    draw(s);
    assert_int_equal(draw(s)->tiles_drawn, 0);
    set_exposure(s, 0.5f, false, DAFT_TONE_AGX);
    assert_true(draw(s)->tiles_drawn > 0);
    stage_drop(s);
}

static void scene_files_name_exposure(void **unused)
{
    (void)unused;
    static const struct {
        const char *text, *error;
        daft_exposure wanted;
    } CASES[] = {{"exposure -1.5 aces\n", NULL, {-1.5f, false, DAFT_TONE_ACES}},
                 {"exposure 2\n", NULL, {2, false, DAFT_TONE_NONE}},
                 {"exposure auto", NULL, {0, true, DAFT_TONE_NONE}},
                 {"exposure auto agx ev=0.5\n", NULL, {0.5f, true, DAFT_TONE_AGX}},
                 {"exposure auto ev=-1 curve=aces\n", NULL, {-1, true, DAFT_TONE_ACES}},
                 {"camera 0 0 0\n", NULL, {0, false, DAFT_TONE_NONE}},
                 {"exposure\n", "auto", {0, false, DAFT_TONE_NONE}},
                 {"exposure 30\n", "is 30", {0, false, DAFT_TONE_NONE}},
                 {"exposure 1 film\n", "none, aces or agx", {0, false, DAFT_TONE_NONE}}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        char path[] = "/tmp/daft_exposure_XXXXXX.scene";
        const int file = mkstemps(path, 6);
        const ssize_t length = (ssize_t)strlen(CASES[i].text);
        assert_true(file >= 0 && write(file, CASES[i].text, (size_t)length) == length);
        close(file);
        stage *s = stage_make(1, NULL);
        daft_error error = {0};
        const bool done = daft_scene_load(s->scene, path, &error);
        unlink(path);
        if (done == !!CASES[i].error) fail_msg("%s: %s", CASES[i].text, error.message);
        if (!done && !strstr(error.message, CASES[i].error)) fail_msg("%s", error.message);
        const daft_exposure found = daft_scene_exposure(s->scene);
        assert_true(found.ev == CASES[i].wanted.ev && found.automatic == CASES[i].wanted.automatic &&
                    found.curve == CASES[i].wanted.curve);
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_are_their_formulas),  cmocka_unit_test(stops_are_powers_of_two),
        cmocka_unit_test(the_same_bytes_everywhere),  cmocka_unit_test(metered_light_becomes_grey),
        cmocka_unit_test(exposure_follows_the_light), cmocka_unit_test(kept_pictures_know_of_exposure),
        cmocka_unit_test(scene_files_name_exposure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
