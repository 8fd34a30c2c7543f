/* render: skies of light that is brighter than white. */
#include "daft.h"

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

/* Four bytes of Radiance's RGBE: three mantissas of 8 bits and the exponent of the largest (Ward, "Real Pixels", in
 * Graphics Gems II, 1991). */
static void put_rgbe(FILE *to, const float *light)
{
    int exponent;
    const float most = fmaxf(light[0], fmaxf(light[1], light[2]));
    uint8_t bytes[4] = {0};
    if (most > 1e-30f) {
        const float scale = frexpf(most, &exponent) * 256 / most;
        for (int k = 0; k < 3; k++) bytes[k] = (uint8_t)(light[k] * scale);
        bytes[3] = (uint8_t)(exponent + 128);
    }
    fwrite(bytes, 1, 4, to);
}

static void write_hdr(char *path, const float *texels, int width, int height)
{
    strcpy(path, "/tmp/daft_sky_XXXXXX.hdr");
    FILE *to = fdopen(mkstemps(path, 4), "wb");
    assert_non_null(to);
    fprintf(to, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", height, width);
    for (int i = 0; i < width * height; i++) put_rgbe(to, texels + 3 * i);
    assert_int_equal(fclose(to), 0);
}

/* A dark sky with a sun of light 64 around +x, 22.5 degrees wide. */
static void set_sunny_sky(stage *s)
{
    enum { W = 16, H = 8 };
    float texels[3 * W * H];
    char path[64];
    for (int i = 0; i < 3 * W * H; i++) texels[i] = 0.125f;
    for (int y = 3; y < 5; y++)
        for (int x = 7; x < 9; x++)
            for (int k = 0; k < 3; k++) texels[3 * (y * W + x) + k] = k == 2 ? 32 : 64;
    write_hdr(path, texels, W, H);
    daft_error error = {0};
    if (!daft_scene_set_sky_image(s->scene, path, &error)) fail_msg("%s", error.message);
    unlink(path);
}

static void add_sphere(stage *s, daft_dvec3 at, float radius, float white, float mirror)
{
    daft_error error = {0};
    daft_material_def m = daft_default_material_def();
    m.ambient = m.diffuse = (daft_vec3){white, white, white}, m.specular = (daft_vec3){0, 0, 0};
    m.mirror = mirror;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = radius, def.position = at;
    def.material = daft_material_create(s->scene, &m, &error);
    if (!daft_entity_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
}

static float brightest(const stage *s)
{
    float most = 0;
    for (int i = 0; i < PIXELS; i++) most = fmaxf(most, s->color[i].x);
    return most;
}

/* Seen itself the sun has its light; a mirror of 5 % still shows it brighter than white. */
static void a_sun_is_brighter_than_white(void **unused)
{
    (void)unused;
    stage *s = stage_make(2, NULL);
    daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
    set_sunny_sky(s);
    draw(s);
    assert_true(brightest(s) == 64);
    s->view.camera.yaw = (float)M_PI;
    add_sphere(s, (daft_dvec3){-5, 0, 0}, 2, 0, 0.05f);
    draw(s);
    print_message("in a mirror of 5 %%: %g\n", (double)brightest(s));
    assert_true(fabsf(brightest(s) - 0.05f * 64) < 1e-3f);
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_sun_is_brighter_than_white)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
