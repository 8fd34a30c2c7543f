/* render: skies that are brighter than white, skies of six images, and skies as light: against closed forms, numbers of
 * their own, and white things that a white sky hides. */
#include "daft.h"

#include "base/files.h"
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

/* ---- cubes ---- */

/* As daft_scene_set_sky_cube says: right, left, top, bottom, front, back; looking, to the right, down. */
static const double LOOK[6][3][3] = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}},  {{-1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                                     {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}},  {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
                                     {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}}, {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}};

/* The direction of a place on a face, -1 to 1 from its left and its upper edge. */
static daft_vec3 on_face(int face, double x, double y)
{
    double d[3];
    for (int k = 0; k < 3; k++) d[k] = LOOK[face][0][k] + x * LOOK[face][1][k] + y * LOOK[face][2][k];
    return daft_v3((float)d[0], (float)d[1], (float)d[2]);
}

typedef double light_function(daft_vec3 unit);

static double smooth(daft_vec3 d) { return 1 + 0.5 * (double)d.x - 0.25 * (double)d.y + 0.2 * (double)(d.z * d.x); }

static double noise(daft_vec3 d)
{
    const double x = sin(1000 * (double)d.x + 700 * (double)d.y + 333 * (double)d.z) * 4321;
    return x - floor(x);
}

/* max(0, a·d) for a direction a */
static const daft_vec3 A = {0.6f, 0.64f, 0.48f};
static double lobe(daft_vec3 d) { return fmax(0, (double)daft_dot(A, d)); }

static daft_vec3 unit_of(daft_vec3 d) { return daft_scale(d, 1 / sqrtf(daft_dot(d, d))); }

static void write_cube(char paths[6][64], int side, light_function *f)
{
    float *texels = calloc(3 * (size_t)(side * side), sizeof *texels);
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < side * side; i++) {
            const daft_vec3 d = on_face(face, (i % side + 0.5) / side * 2 - 1, (i / side + 0.5) / side * 2 - 1);
            for (int k = 0; k < 3; k++) texels[3 * i + k] = (float)f(unit_of(d));
        }
        write_hdr(paths[face], texels, side, side);
    }
    free(texels);
}

static void remove_cube(char paths[6][64])
{
    for (int i = 0; i < 6; i++) unlink(paths[i]);
}

static daft_sky_image read_cube(int side, light_function *f)
{
    char paths[6][64];
    const daft_allocator allocator = daft_malloc_allocator();
    daft_image_file files[6];
    daft_sky_image image;
    daft_error error = {0};
    write_cube(paths, side, f);
    for (int i = 0; i < 6; i++) {
        files[i].path = paths[i];
        files[i].bytes = daft_file_read(&allocator, NULL, paths[i], &files[i].size, &error);
    }
    if (!daft_sky_decode_cube(&allocator, files, &image, &error)) fail_msg("%s", error.message);
    for (int i = 0; i < 6; i++) daft_release(&allocator, (void *)(uintptr_t)files[i].bytes);
    remove_cube(paths);
    return image;
}

static float cube_at(const daft_sky_image *image, daft_vec3 d, int isa)
{
    static daft_lanes3 direction, color;
    const daft_sky sky = {.kind = DAFT_SKY_CUBE, .image = image};
    direction.x[0] = d.x, direction.y[0] = d.y, direction.z[0] = d.z;
    daft_shade_kernels_for(isa)->sky(&sky, &direction, 1, &color);
    return color.x[0];
}

/* In all directions a cube shows the function of which its images were made: RGBE has steps of 1/128, a texel of 64
 * spans 1.8 degrees. */
static void cubes_show_what_they_are_made_of(void **unused)
{
    (void)unused;
    const daft_allocator allocator = daft_malloc_allocator();
    daft_sky_image image = read_cube(64, smooth);
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        const double y = 1 - 2 * (i + 0.5) / 20000, turn = i * 2.399963229728653, across = sqrt(1 - y * y);
        const daft_vec3 d = daft_v3((float)(across * cos(turn)), (float)y, (float)(across * sin(turn)));
        worst = fmax(worst, fabs((double)cube_at(&image, daft_scale(d, 3), daft_isa_best()) - smooth(d)));
    }
    print_message("off by %.2g at most\n", worst);
    assert_true(worst < 0.012);
    const daft_vec3 odd[3] = {{0, 0, 0}, {NAN, 1, 1}, {INFINITY, 1, -INFINITY}};
    for (int isa = 0; isa <= daft_isa_best(); isa++)
        for (int i = 0; i < 3; i++) cube_at(&image, odd[i], isa);
    daft_sky_free(&allocator, &image);
}

/* Of noise, which differs from texel to texel: along all edges of all faces, up to the corners, both sides agree. */
static void cubes_have_no_seams(void **unused)
{
    (void)unused;
    const daft_allocator allocator = daft_malloc_allocator();
    daft_sky_image image = read_cube(16, noise);
    double worst = 0, spread = 0;
    for (int face = 0; face < 6; face++)
        for (int edge = 0; edge < 4; edge++)
            for (int i = 0; i <= 1000; i++) {
                const double along = i / 500.0 - 1, out = edge & 1 ? 1 : -1, step = 1e-5;
                float seen[2];
                for (int side = 0; side < 2; side++) {
                    const double at = out * (1 + (side ? step : -step));
                    seen[side] = cube_at(&image, edge & 2 ? on_face(face, along, at) : on_face(face, at, along), 0);
                }
                worst = fmax(worst, fabs((double)(seen[0] - seen[1])));
                spread = fmax(spread, fabs((double)seen[0] - 0.5));
            }
    print_message("across edges: %.2g at most, of light %.2g apart\n", worst, 2 * spread);
    assert_true(worst < 1e-3 && spread > 0.3);
    daft_sky_free(&allocator, &image);
}

static void cubes_in_pictures_and_files(void **unused)
{
    (void)unused;
    char paths[6][64], scene[] = "/tmp/daft_cube_XXXXXX.scene", text[1024];
    write_cube(paths, 32, smooth);
    const int length = snprintf(text, sizeof text, "camera 0 0 0 0 -90 90\nskybox %s %s %s %s %s %s\n", paths[0],
                                paths[1], paths[2], paths[3], paths[4], paths[5]);
    const int file = mkstemps(scene, 6);
    assert_true(file >= 0 && write(file, text, (size_t)length) == length);
    close(file);
    stage *s = stage_make(2, NULL);
    daft_error error = {0};
    if (!daft_scene_load(s->scene, scene, &error)) fail_msg("%s", error.message);
    s->view.camera = daft_scene_camera(s->scene, 1);
    draw(s);
    /* yaw -90 degrees looks along -Z, where +X is right */
    for (int i = 0; i < PIXELS; i += 7) {
        const double x = i % WIDTH + 0.5 - WIDTH / 2.0, y = HEIGHT / 2.0 - i / WIDTH - 0.5;
        const daft_vec3 d = unit_of(daft_v3((float)x, (float)y, -WIDTH / 2.0f));
        assert_true(fabs((double)s->color[i].x - smooth(d)) < 0.02);
    }
    const char *bad[6] = {paths[0], paths[1], paths[2], paths[3], paths[4], paths[5]};
    float texel[3 * 4] = {0};
    char small[64];
    write_hdr(small, texel, 2, 2);
    bad[3] = small;
    assert_false(daft_scene_set_sky_cube(s->scene, bad, &error));
    assert_non_null(strstr(error.message, "2 pixels a side"));
    unlink(small);
    write_hdr(small, texel, 2, 1);
    bad[3] = small;
    assert_false(daft_scene_set_sky_cube(s->scene, bad, &error));
    assert_non_null(strstr(error.message, "square"));
    unlink(small), unlink(scene);
    remove_cube(paths);
    stage_drop(s);
}

/* ---- light of the sky ---- */

static double irradiance(const daft_vec3 h[DAFT_HARMONICS], daft_vec3 n)
{
    const double x = (double)n.x, y = (double)n.y, z = (double)n.z;
    const double basis[DAFT_HARMONICS] = {1, x, y, z, x * y, y * z, x * z, 3 * z * z - 1, x * x - y * y};
    double sum = 0;
    for (int k = 0; k < DAFT_HARMONICS; k++) sum += basis[k] * (double)h[k].x;
    return M_PI * sum;
}

static daft_vec3 some_direction(int i, int count)
{
    const double y = 1 - 2 * (i + 0.5) / count, turn = i * 2.399963229728653, across = sqrt(1 - y * y);
    return daft_v3((float)(across * cos(turn)), (float)y, (float)(across * sin(turn)));
}

static void a_constant_sky_is_pi_times_its_light(void **unused)
{
    (void)unused;
    daft_vec3 h[DAFT_HARMONICS];
    float texels[3 * 16 * 8];
    for (int i = 0; i < 3 * 16 * 8; i++) texels[i] = 0.7f;
    const daft_sky_image image = {.width = 16, .height = 8, .texels = texels};
    const daft_vec3 grey = {0.7f, 0.7f, 0.7f};
    const daft_sky skies[] = {{.kind = DAFT_SKY_COLOR, .zenith = grey}, {.kind = DAFT_SKY_IMAGE, .image = &image}};
    for (int k = 0; k < 2; k++) {
        daft_sky_irradiance(&skies[k], h);
        for (int i = 0; i < 500; i++)
            assert_true(fabs(irradiance(h, some_direction(i, 500)) / (0.7 * M_PI) - 1) < (k ? 0.01 : 1e-6));
    }
}

/* Of a sky of max(0, a·d): 2/3·(sin g + (pi - g)·cos g), where g is the angle between a and the normal. Up to the
 * second order that is the sum over l of (2l + 1)/4pi·A_l²·P_l, 0.02 away at most. */
static void a_cosine_sky_has_its_closed_form(void **unused)
{
    (void)unused;
    enum { W = 256, H = 128 };
    const daft_allocator allocator = daft_malloc_allocator();
    float *texels = calloc(3 * W * H, sizeof *texels);
    for (int i = 0; i < W * H; i++) {
        const double turn = 2 * M_PI * ((i % W + 0.5) / W - 0.5), rise = M_PI * (0.5 - (i / W + 0.5) / H);
        texels[3 * i] =
            (float)lobe(daft_v3((float)(cos(rise) * cos(turn)), (float)sin(rise), (float)(cos(rise) * sin(turn))));
    }
    daft_sky_image cube = read_cube(128, lobe);
    const daft_sky_image image = {.width = W, .height = H, .texels = texels};
    const daft_sky skies[] = {{.kind = DAFT_SKY_IMAGE, .image = &image}, {.kind = DAFT_SKY_CUBE, .image = &cube}};
    for (int k = 0; k < 2; k++) {
        daft_vec3 h[DAFT_HARMONICS];
        double from_form = 0, from_sum = 0;
        daft_sky_irradiance(&skies[k], h);
        for (int i = 0; i < 1000; i++) {
            const daft_vec3 n = some_direction(i, 1000);
            const double c = fmax(-1, fmin(1, (double)daft_dot(A, n))), g = acos(c);
            const double form = 2.0 / 3 * (sin(g) + (M_PI - g) * c),
                         sum = M_PI / 4 + M_PI / 3 * c + 5 * M_PI / 64 * (3 * c * c - 1) / 2, found = irradiance(h, n);
            from_form = fmax(from_form, fabs(found - form)), from_sum = fmax(from_sum, fabs(found - sum));
        }
        print_message("%s: %.2g from the closed form, %.2g from its harmonics\n", k ? "cube" : "image", from_form,
                      from_sum);
        assert_true(from_form < 0.03 && from_sum < 0.008);
    }
    daft_sky_free(&allocator, &cube);
    free(texels);
}

/* Against sums over the sphere, in double. */
static void a_gradients_light(void **unused)
{
    (void)unused;
    const daft_sky sky = {.kind = DAFT_SKY_GRADIENT, .zenith = {0.2f, 0, 0}, .horizon = {1.5f, 0, 0}};
    daft_vec3 h[DAFT_HARMONICS];
    daft_sky_irradiance(&sky, h);
    assert_true(fabs((double)h[0].x - (0.2 * 3 / 5 + 1.5 * 19 / 60)) < 1e-6);
    enum { STEPS = 200000 };
    for (int k = -1; k <= 1; k++) {
        const daft_vec3 n = daft_v3(k ? 0 : 1, (float)k, 0);
        double sum[3] = {0};
        for (int i = 0; i < STEPS; i++) {
            const double y = 2 * (i + 0.5) / STEPS - 1, light = (1.5 - 1.3 * sqrt(fabs(y))) * (y < 0 ? 1 + y / 3 : 1);
            sum[0] += light, sum[1] += light * y, sum[2] += light * (3 * y * y - 1) / 2;
        }
        const double ny = (double)n.y, p2 = (3 * ny * ny - 1) / 2, each = 2.0 / STEPS;
        const double wanted = M_PI * each * (0.5 * sum[0] + 2.0 / 3 * 1.5 * sum[1] * ny + 0.25 * 2.5 * sum[2] * p2);
        assert_true(fabs(irradiance(h, n) - wanted) < 1e-5);
    }
}

/* White spheres, Lambert's and physical, vanish before a white sky that lights them. */
static void white_spheres_vanish(void **unused)
{
    (void)unused;
    const daft_vec3 grey = {0.7f, 0.7f, 0.7f};
    stage *s = stage_make(2, NULL);
    daft_error error = {0};
    daft_scene_set_sky_color(s->scene, grey);
    daft_scene_set_ambient_sky(s->scene, 1);
    add_sphere(s, (daft_dvec3){5, 0, -2}, 1.5f, 1, 0);
    daft_material_def m = daft_default_material_def();
    m.shading = DAFT_SHADING_PHYSICAL, m.diffuse = daft_v3(1, 1, 1), m.roughness = 1;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 1.5f, def.position = (daft_dvec3){5, 0, 2};
    def.material = daft_material_create(s->scene, &m, &error);
    if (!daft_entity_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
    draw(s);
    int seen = 0;
    for (int i = 0; i < PIXELS; i++) {
        seen += isfinite(s->depth[i]);
        assert_true(fabsf(s->color[i].x - 0.7f) < 2e-5f);
    }
    assert_true(seen > 2000);
    daft_scene_set_ambient(s->scene, grey);
    daft_scene_set_sky_color(s->scene, daft_v3(0, 0, 0)); /* the colour is back */
    draw(s);
    assert_true(fabsf(s->color[PIXELS / 2 + WIDTH / 4].x - 0.7f) < 2e-5f);
    stage_drop(s);
}

/* A white sphere under a sky has the irradiance of each normal over pi; a picture before knows of it; bytes are the
 * same on all instruction sets. */
static void spheres_show_the_skys_light(void **unused)
{
    (void)unused;
    static uint8_t first[4 * PIXELS];
    const char *const isas[] = {DAFT_NARROWEST_ISA, NULL};
    const daft_sky sky = {.kind = DAFT_SKY_GRADIENT, .zenith = {0.1f, 0.3f, 1}, .horizon = {0.9f, 0.5f, 0.2f}};
    daft_vec3 h[DAFT_HARMONICS];
    daft_sky_irradiance(&sky, h);
    for (int k = 0; k < 2; k++) {
        stage *s = stage_make(2, isas[k]);
        daft_error error = {0};
        daft_scene_set_sky_gradient(s->scene, sky.zenith, sky.horizon);
        daft_scene_set_ambient_sky(s->scene, 0.5f);
        add_sphere(s, (daft_dvec3){5, 0, 0}, 2, 1, 0);
        draw(s);
        for (int i = 0; i < PIXELS; i++)
            if (isfinite(s->depth[i]))
                assert_true(fabs((double)s->color[i].x - 0.5 / M_PI * irradiance(h, s->normal[i])) < 1e-5);
        if (k == 0) memcpy(first, daft_image_pixels(s->image), sizeof first);
        if (k == 1) assert_memory_equal(first, daft_image_pixels(s->image), sizeof first);
        s->view.aov = (daft_aov){0};
        assert_non_null(s->view.history = daft_history_create(s->engine, &error));
        for (int i = 0; i < 3; i++) draw(s);
        assert_int_equal(draw(s)->tiles_drawn, 0);
        daft_scene_set_ambient_sky(s->scene, 0.6f);
        assert_true(draw(s)->tiles_drawn > 0);
        stage_drop(s);
    }
}

/* Under a lid, what is kept from the sky's light is sampled. */
static void occlusion_keeps_the_skys_light_away(void **unused)
{
    (void)unused;
    stage *s = stage_make(2, NULL);
    daft_scene_set_sky_color(s->scene, daft_v3(1, 1, 1));
    daft_scene_set_ambient_sky(s->scene, 1);
    daft_scene_set_ambient_occlusion(s->scene, 3);
    s->view.quality.occlusion_samples = 16;
    add_sphere(s, (daft_dvec3){6, -10, 0}, 9, 1, 0);
    add_sphere(s, (daft_dvec3){6, 0.5, 0}, 1, 1, 0);
    assert_true(draw(s)->effects[DAFT_EFFECT_OCCLUSION].ran);
    float least = 1;
    for (int i = 0; i < PIXELS; i++) least = fminf(least, s->color[i].x);
    assert_true(least < 0.6f);
    stage_drop(s);
}

static void scene_files_name_the_skys_light(void **unused)
{
    (void)unused;
    static const struct {
        const char *text, *error;
        float at_top;
    } CASES[] = {{"sky 1 1 1 1 1 1\nambient sky\n", NULL, 1}, {"ambient sky 2 1.5\nsky 1 1 1 1 1 1", NULL, 2},
                 {"sky 1 1 1 1 1 1\nambient sky", NULL, 1},   {"ambient sky 1\nambient 0.5 0.5 0.5\n", NULL, 0.5f},
                 {"ambient sky -1\n", "strength is -1", 0},   {"ambient skies\n", "'skies'", 0}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        char path[] = "/tmp/daft_ambient_XXXXXX.scene";
        const int file = mkstemps(path, 6);
        const ssize_t length = (ssize_t)strlen(CASES[i].text);
        assert_true(file >= 0 && write(file, CASES[i].text, (size_t)length) == length);
        close(file);
        stage *s = stage_make(1, NULL);
        daft_error error = {0};
        const bool done = daft_scene_load(s->scene, path, &error);
        unlink(path);
        assert_true(done == !CASES[i].error);
        if (!done && !strstr(error.message, CASES[i].error)) fail_msg("%s", error.message);
        if (done) {
            s->view.quality.occlusion_samples = 0;
            add_sphere(s, (daft_dvec3){0, -5, 0}, 2, 1, 0);
            s->view.camera.pitch = (float)M_PI / 2;
            draw(s);
            const float found = s->color[PIXELS / 2 + WIDTH / 2].x;
            print_message("%s: %g\n", CASES[i].text, (double)found);
            /* the lower half of a white gradient is darker, and seen of it upwards is what the harmonics leave */
            assert_true(fabsf(found - CASES[i].at_top) < 0.01f * CASES[i].at_top);
        }
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sun_is_brighter_than_white),
        cmocka_unit_test(cubes_show_what_they_are_made_of),
        cmocka_unit_test(cubes_have_no_seams),
        cmocka_unit_test(cubes_in_pictures_and_files),
        cmocka_unit_test(a_constant_sky_is_pi_times_its_light),
        cmocka_unit_test(a_cosine_sky_has_its_closed_form),
        cmocka_unit_test(a_gradients_light),
        cmocka_unit_test(white_spheres_vanish),
        cmocka_unit_test(spheres_show_the_skys_light),
        cmocka_unit_test(occlusion_keeps_the_skys_light_away),
        cmocka_unit_test(scene_files_name_the_skys_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
