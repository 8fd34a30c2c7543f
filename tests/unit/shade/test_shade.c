/* shade and the functions over lanes: errors measured against libm, tables against their formula, textures and skies
 * against what their texels say. */
#include "daft.h"

#include "image/image.h"
#include "math/simd/dispatch.h"
#include "math/simd/elementary.h"
#include "shade/shade.h"
#include "shade/srgb_table.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static float lane(vf v) { return v[0]; }

static void lane_functions(void **unused)
{
    (void)unused;
    double log2_error = 0, exp2_error = 0, atan_error = 0, asin_error = 0, pow_error = 0;
    for (int i = 0; i < 300000; i++) {
        float a = (float)i / 300000, x = ldexpf(0.5f + a, i % 200 - 100), y = (a - 0.5f) * 250;
        log2_error =
            fmax(log2_error, fabs((double)lane(vf_log2(vf_set(x))) - log2((double)x)) / fmax(1, fabs(log2((double)x))));
        exp2_error = fmax(exp2_error, fabs((double)lane(vf_exp2(vf_set(y))) / exp2((double)y) - 1));
        float c = cosf(7 * a), s = sinf(7 * a) * (i % 3 ? 1 : 1e-4f);
        atan_error = fmax(atan_error, fabs((double)lane(vf_atan2(vf_set(s), vf_set(c))) - atan2((double)s, (double)c)));
        asin_error = fmax(asin_error, fabs((double)lane(vf_asin(vf_set(2 * a - 1))) - asin((double)(2 * a - 1))));
        pow_error = fmax(pow_error, fabs((double)lane(vf_pow(vf_set(a), vf_set(50))) - pow((double)a, 50)));
    }
    print_message("log2 %.2g exp2 %.2g atan2 %.2g asin %.2g pow %.2g\n", log2_error, exp2_error, atan_error, asin_error,
                  pow_error);
    assert_true(log2_error < 3e-7 && exp2_error < 3e-7 && atan_error < 5e-7 && asin_error < 1e-6 && pow_error < 1e-5);
    assert_true(lane(vf_atan2(vf_set(0), vf_set(0))) == 0 && lane(vf_pow(vf_set(0), vf_set(0))) == 1);
    assert_true(lane(vf_floor(vf_set(-1.5f))) == -2 && lane(vf_floor(vf_set(2))) == 2);
}

static void srgb_table(void **unused)
{
    (void)unused;
    for (int i = 0; i < 256; i++) assert_true(SRGB_TO_LINEAR[i] == daft_srgb_to_linear((float)i / 255));
    for (int i = 0; i < 256; i++) assert_true(SRGB_TO_LINEAR_16[i] == lrintf(SRGB_TO_LINEAR[i] * 65535));
}

/* Bytes that go in as light come out again. */
static void encode_round_trip(void **unused)
{
    (void)unused;
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        float light[256 + 16] = {0};
        uint8_t bytes[4 * 256];
        for (int i = 0; i < 256; i++) light[i] = SRGB_TO_LINEAR[i];
        daft_shade_kernels_for(isa)->encode(light, light, light, 256, bytes);
        for (int i = 0; i < 256; i++)
            assert_true(bytes[4 * i] == i && bytes[4 * i + 2] == i && bytes[4 * i + 3] == 255);
        const float odd[16] = {NAN, INFINITY, -INFINITY, -1, 2};
        daft_shade_kernels_for(isa)->encode(odd, odd, odd, 5, bytes);
        const int expected[5] = {0, 255, 0, 0, 255};
        for (int i = 0; i < 5; i++) assert_int_equal(bytes[4 * i], expected[i]);
    }
}

/* The byte of one light by the powers alone. */
static int byte_by_powers(float light)
{
    vf x = vf_clamp01(vf_set(light)), curve = vf_set(1.055f) * vf_pow(x, vf_set(1 / 2.4f)) - vf_set(0.055f);
    float encoded = lane(x) <= 0.0031308f ? lane(x) * 12.92f : lane(curve);
    return (int)(encoded * 255 + 0.5f);
}

/* Light around each place where the byte changes, and light in between, from 0 to beyond 1. */
static void encode_near_thresholds(void **unused)
{
    (void)unused;
    enum { AROUND = 2000, COUNT = 2 * AROUND };
    static float light[COUNT + 16];
    static uint8_t bytes[4 * COUNT];
    for (int step = 0; step < 256 + 64; step++) {
        float middle = step < 256 ? daft_srgb_to_linear(((float)step + 0.5f) / 255) : (float)(step - 255) * 0.0159f;
        int32_t bits;
        memcpy(&bits, &middle, sizeof bits);
        for (int i = 0; i < COUNT; i++) {
            int32_t near = bits + (step % 2 ? 1 : 37) * (i - AROUND);
            memcpy(&light[i], &near, sizeof near);
        }
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            daft_shade_kernels_for(isa)->encode(light, light, light, COUNT, bytes);
            for (int i = 0; i < COUNT; i++) assert_int_equal(bytes[4 * i + 1], byte_by_powers(light[i]));
        }
    }
}

static daft_batch *batch_make(uint32_t count)
{
    daft_batch *b = calloc(1, sizeof *b);
    b->count = count;
    return b;
}

/* Texel centres give the texel; a large patch gives the mean of the image; the texture repeats. */
static void texture_sampling(void **unused)
{
    (void)unused;
    daft_allocator allocator = daft_malloc_allocator();
    uint8_t rgba[4 * 4 * 2];
    for (int i = 0; i < 8; i++)
        rgba[4 * i] = (uint8_t)(30 * i), rgba[4 * i + 1] = 10, rgba[4 * i + 2] = 0, rgba[4 * i + 3] = 255;
    daft_texture_data texture;
    assert_true(daft_texture_build(&allocator, rgba, 4, 2, &texture, NULL));
    daft_surface material = {.texture = 0, .map_scale = {1, 1}};
    daft_batch *b = batch_make(20);
    for (int i = 0; i < 8; i++) { /* row 0 is the top: v = 0.75 */
        b->u[i] = ((float)(i % 4) + 0.5f) / 4 + (float)(i % 3 - 1), b->v[i] = (i < 4 ? 0.75f : 0.25f) - 2;
        b->footprint[i] = 0.01f;
    }
    for (int i = 8; i < 20; i++) b->footprint[i] = 100;
    double mean = 0;
    for (int i = 0; i < 8; i++) mean += (double)SRGB_TO_LINEAR[30 * i] / 8;
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        assert_true(daft_shade_kernels_for(isa)->albedo(b, &material, &texture, DAFT_TEXTURE_TRILINEAR));
        for (int i = 0; i < 8; i++) assert_true(fabsf(b->albedo.x[i] - SRGB_TO_LINEAR[30 * i]) < 1e-5f);
        for (int i = 8; i < 20; i++) assert_true(fabs((double)b->albedo.x[i] - mean) < 0.01);
    }
    material.texture = DAFT_NO_TEXTURE;
    assert_false(daft_shade_kernels_for(0)->albedo(b, &material, &texture, DAFT_TEXTURE_TRILINEAR));
    assert_true(b->albedo.x[3] == 1);
    b->u[0] = NAN, b->v[1] = INFINITY, b->u[2] = 1e30f, b->footprint[3] = NAN, material.texture = 0;
    daft_shade_kernels_for(daft_isa_best())->albedo(b, &material, &texture, DAFT_TEXTURE_TRILINEAR); /* reads nothing
                                                                                                      * outside: asan
                                                                                                      * would tell
                                                                                                      */
    daft_texture_free(&allocator, &texture);
    free(b);
}

/* ---- slow twins ---- */

static double between(double a, double b, double t) { return a + (b - a) * t; }

static double texel_at(const daft_texture_data *t, int level, int x, int y, int channel)
{
    const int w = t->width[level], h = t->height[level];
    const size_t at = (size_t)((y + h) % h) * (size_t)w + (size_t)((x + w) % w);
    return (double)daft_srgb_to_linear((float)t->texels[level][4 * at + (size_t)channel] / 255);
}

static double bilinear(const daft_texture_data *t, int level, double u, double v, int channel)
{
    const double x = u * t->width[level] - 0.5, y = (1 - v) * t->height[level] - 0.5;
    const int x0 = (int)floor(x), y0 = (int)floor(y);
    const double above = between(texel_at(t, level, x0, y0, channel), texel_at(t, level, x0 + 1, y0, channel), x - x0),
                 below = between(texel_at(t, level, x0, y0 + 1, channel), texel_at(t, level, x0 + 1, y0 + 1, channel),
                                 x - x0);
    return between(above, below, y - y0);
}

/* Two levels blend in the middle half of the interval between them. side: of the footprint, in texels. */
static double trilinear(const daft_texture_data *t, double u, double v, double side, int channel)
{
    const double level = fmin(fmax(log2(side), 0), t->levels - 1);
    const int fine = (int)level, coarse = fine + 1 < t->levels ? fine + 1 : fine;
    const double blend = fmin(fmax((level - fine) * 2 - 0.5, 0), 1);
    return between(bilinear(t, fine, u, v, channel), bilinear(t, coarse, u, v, channel), blend);
}

/* Anywhere, across all seams, in all levels, neighbours in one row or far apart; the same bits on all targets. */
static void compare_with_twin(int w, int h)
{
    const daft_allocator allocator = daft_malloc_allocator();
    uint32_t state = 7;
    uint8_t rgba[4 * 37 * 20];
    for (int i = 0; i < 4 * w * h; i++) rgba[i] = (uint8_t)((state = state * 1664525u + 1013904223u) >> 24);
    daft_texture_data texture;
    assert_true(daft_texture_build(&allocator, rgba, w, h, &texture, NULL));
    const daft_surface material = {.texture = 0, .map_scale = {1, 1}};
    daft_batch *b = calloc(1, sizeof *b);
    daft_lanes3 *plain = calloc(1, sizeof *plain);
    b->count = DAFT_BATCH, b->one_material = true;
    for (int i = 0; i < DAFT_BATCH; i++) {
        const float far = (float)((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f;
        b->u[i] = i < 512 ? (float)(i % 32) / 31 * 0.999f : far;
        b->v[i] = (float)i / DAFT_BATCH, b->footprint[i] = exp2f((float)(i % 100) / 12) / 40;
    }
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        assert_true(daft_shade_kernels_for(isa)->albedo(b, &material, &texture, DAFT_TEXTURE_TRILINEAR));
        if (isa == 0) *plain = b->albedo;
        const float *const got[3] = {b->albedo.x, b->albedo.y, b->albedo.z}, *const first[3] = {plain->x, plain->y,
                                                                                                plain->z};
        for (int i = 0; i < DAFT_BATCH; i++)
            for (int k = 0; k < 3; k++) {
                const double want =
                    trilinear(&texture, (double)b->u[i], (double)b->v[i], (double)b->footprint[i] * sqrt(w * h), k);
                assert_true(fabs((double)got[k][i] - want) < 2e-5);
                assert_true(got[k][i] == first[k][i]);
            }
    }
    free(plain), free(b);
    daft_texture_free(&allocator, &texture);
}

/* Also rows of a single texel, which have none beside it, and textures of a single level. */
static void texture_twin(void **unused)
{
    (void)unused;
    static const int SIZES[][2] = {{37, 20}, {1, 1}, {2, 1}, {1, 2}, {2, 2}, {1, 20}, {37, 1}, {3, 3}};
    for (size_t i = 0; i < DAFT_COUNT_OF(SIZES); i++) compare_with_twin(SIZES[i][0], SIZES[i][1]);
}

/* Points of a batch that have several textures, of several materials, or none: each has what it would have alone. White
 * texels are white. */
/* Points that are skipped have nothing of the light; black ones that are kept have some of it. */
static void dark_points(void **unused)
{
    (void)unused;
    enum { MATERIALS = 4 };
    const daft_surface materials[MATERIALS] = {
        {.texture = DAFT_NO_TEXTURE, .specular = {0.5f, 0.25f, 0}, .shininess = 900},
        {.texture = DAFT_NO_TEXTURE, .diffuse = {0, 0.01f, 0}},
        {.texture = DAFT_NO_TEXTURE},
        {.texture = DAFT_NO_TEXTURE, .specular = {0, 0, 1}, .shininess = 4}};
    const daft_light_source light = {.position = {1, 5, 0}, .color = {1, 1, 1}};
    const daft_vec3 up = {0, 1, 0};
    daft_batch *b = batch_make(DAFT_BATCH - 3);
    b->traits = DAFT_TRAIT_SPECULAR | DAFT_TRAIT_SENDS;
    for (uint32_t i = 0; i < b->count; i++) {
        const daft_vec3 view = daft_normalize(daft_v3((float)(i % 23) - 11, 8, (float)(i % 31) - 15));
        b->material[i] = i % 7 % MATERIALS;
        b->point.x[i] = (float)(i % 41) - 20, b->point.z[i] = (float)(i % 37) - 18;
        b->normal.x[i] = up.x, b->normal.y[i] = up.y, b->normal.z[i] = up.z;
        b->view.x[i] = view.x, b->view.y[i] = view.y, b->view.z[i] = view.z;
        b->albedo.x[i] = b->albedo.y[i] = b->albedo.z[i] = 1;
    }
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        const daft_shade_kernels *kernels = daft_shade_kernels_for(isa);
        uint32_t all[DAFT_BATCH_WORDS], some[DAFT_BATCH_WORDS], skipped[MATERIALS] = {0}, kept[MATERIALS] = {0};
        assert_int_equal(kernels->facing(b, &light, all), b->count);
        memcpy(some, all, sizeof some);
        const uint32_t left = kernels->skip_dark(b, materials, &light, some);
        memset(&b->light, 0, sizeof b->light);
        kernels->direct_light(b, materials, &light, all, NULL, NULL);
        for (uint32_t i = 0; i < b->count; i++) {
            const bool lit = some[i / 32] >> (i % 32) & 1;
            assert_true(lit == (b->light.x[i] > 0 || b->light.y[i] > 0 || b->light.z[i] > 0));
            (lit ? kept : skipped)[b->material[i]]++;
        }
        assert_int_equal(left, kept[0] + kept[1] + kept[2] + kept[3]);
        assert_true(kept[0] > 0 && skipped[0] > kept[0] && skipped[1] == 0 && kept[2] == 0 && kept[3] > 0);
    }
    free(b);
}

static void textures_in_one_batch(void **unused)
{
    (void)unused;
    enum { TEXTURES = 3, MATERIALS = 5, SIDE = 8 };
    const daft_allocator allocator = daft_malloc_allocator();
    daft_texture_data textures[TEXTURES];
    uint32_t state = 5;
    for (int t = 0; t < TEXTURES; t++) {
        uint8_t rgba[4 * SIDE * SIDE];
        for (size_t i = 0; i < sizeof rgba; i++)
            rgba[i] = t == 0 ? 255 : (uint8_t)((state = state * 1664525u + 1013904223u) >> 24);
        assert_true(daft_texture_build(&allocator, rgba, SIDE, SIDE, &textures[t], NULL));
    }
    const daft_surface materials[MATERIALS] = {{.texture = 0, .map_scale = {1, 1}},
                                               {.texture = 1, .map_scale = {1, 1}, .wrap = DAFT_WRAP_MIRROR},
                                               {.texture = DAFT_NO_TEXTURE},
                                               {.texture = 1, .map_scale = {3, 2}, .map_offset = {0.3f, 0.1f}},
                                               {.texture = 2, .map_scale = {1, 1}, .wrap = DAFT_WRAP_CLAMP}};
    daft_batch *b = batch_make(DAFT_BATCH - 3), *one = batch_make(1);
    for (uint32_t i = 0; i < b->count; i++) {
        b->material[i] = (state = state * 1664525u + 1013904223u) >> 16 & 4 ? i / 50 % MATERIALS : state >> 20 & 3;
        b->u[i] = (float)(i * 37 % 101) / 40, b->v[i] = (float)(i * 11 % 97) / 30 - 1,
        b->footprint[i] = exp2f((float)(i % 40) / 5) / 40;
    }
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        const daft_shade_kernels *kernels = daft_shade_kernels_for(isa);
        assert_true(kernels->albedo(b, materials, textures, DAFT_TEXTURE_TRILINEAR));
        for (uint32_t i = 0; i < b->count; i++) {
            one->u[0] = b->u[i], one->v[0] = b->v[i], one->footprint[0] = b->footprint[i];
            one->material[0] = b->material[i];
            kernels->albedo(one, materials, textures, DAFT_TEXTURE_TRILINEAR);
            assert_true(b->albedo.x[i] == one->albedo.x[0] && b->albedo.y[i] == one->albedo.y[0]);
            if (b->material[i] == 0 || b->material[i] == 2) assert_true(b->albedo.z[i] == 1);
        }
    }
    for (int t = 0; t < TEXTURES; t++) daft_texture_free(&allocator, &textures[t]);
    free(one), free(b);
}

/* Samples along the major axis of an ellipse with these conjugate diameters: their combination by an angle's cosine and
 * sine is longest and shortest at angles a quarter turn apart. count: how many there are; or, close up, four samples
 * by a rotated grid. */
static double along_axis(const daft_texture_data *t, const float d[4], int most, bool spread, double u, double v,
                         int channel, double *count, bool *close)
{
    const double w = t->width[0], h = t->height[0], ax = (double)d[0] * w, ay = (double)d[1] * h, bx = (double)d[2] * w,
                 by = (double)d[3] * h;
    double angle = atan2(2 * (ax * bx + ay * by), ax * ax + ay * ay - bx * bx - by * by) / 2, sum = 0;
    const double x = ax * cos(angle) + bx * sin(angle), y = ay * cos(angle) + by * sin(angle), major = hypot(x, y),
                 minor = hypot(bx * cos(angle) - ax * sin(angle), by * cos(angle) - ay * sin(angle));
    *count = fmin(fmax(major / fmax(minor, 1), 1), most) + 0.875;
    const int along = (int)*count;
    const double side = fmax(minor, major / along);
    *close = spread && along == 1 && side > 0.25 && side < 1.5;
    const int taps = *close ? 4 : along;
    for (int k = 0; k < taps; k++) {
        static const double grid[4][2] = {{-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}};
        const double part = (k + 0.5) / taps - 0.5;
        const double tu = u + (*close ? (double)d[0] * grid[k][0] + (double)d[2] * grid[k][1] : part * x / w),
                     tv = v + (*close ? (double)d[1] * grid[k][0] + (double)d[3] * grid[k][1] : part * y / h);
        sum += trilinear(t, tu - floor(tu), tv - floor(tv), 0.77 * side * (*close ? 0.5 : 1), channel) / taps;
    }
    return sum;
}

/* Ellipses of all shapes, from far below a texel to many of them; as many samples as there may be, and no more. */
static void anisotropic_twin(void **unused)
{
    (void)unused;
    enum { W = 64, H = 40 };
    const daft_allocator allocator = daft_malloc_allocator();
    uint32_t state = 3;
    uint8_t rgba[4 * W * H];
    for (size_t i = 0; i < sizeof rgba; i++) rgba[i] = (uint8_t)((state = state * 1664525u + 1013904223u) >> 24);
    daft_texture_data texture;
    assert_true(daft_texture_build(&allocator, rgba, W, H, &texture, NULL));
    const daft_surface material = {.texture = 0, .map_scale = {1, 1}};
    daft_batch *b = calloc(1, sizeof *b);
    daft_footprints *f = b->footprints = calloc(1, sizeof *f);
    float *const diameters[4] = {f->first_u, f->first_v, f->second_u, f->second_v};
    b->count = DAFT_BATCH, b->one_material = true;
    for (int i = 0; i < DAFT_BATCH; i++) {
        for (int k = 0; k < 4; k++) {
            const float random = (float)((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-23f - 1;
            diameters[k][i] = random * exp2f((float)(i % 9) - 8) * (k < 2 && i % 2 ? 0.1f : 1);
        }
        b->u[i] = (float)(i * 37 % DAFT_BATCH) / DAFT_BATCH, b->v[i] = (float)i / DAFT_BATCH;
    }
    for (int isa = 0; isa <= daft_isa_best(); isa++)
        for (int turn = 0; turn < 4; turn++) {
            const int most = turn & 1 ? 16 : 4;
            f->spread = turn & 2;
            int full = 0, compared = 0, near = 0;
            assert_true(daft_shade_kernels_for(isa)->albedo(
                b, &material, &texture, most == 4 ? DAFT_TEXTURE_ANISOTROPIC4 : DAFT_TEXTURE_ANISOTROPIC16));
            for (int i = 0; i < DAFT_BATCH; i++) {
                const float d[4] = {f->first_u[i], f->first_v[i], f->second_u[i], f->second_v[i]};
                double count;
                bool close;
                const double want =
                    along_axis(&texture, d, most, f->spread, (double)b->u[i], (double)b->v[i], 1, &count, &close);
                if (fabs(count - round(count)) < 1e-3) continue; /* one more or less by rounding */
                assert_true(fabs((double)b->albedo.y[i] - want) < 1e-4);
                compared++, full += (int)count == most, near += close;
            }
            assert_true(compared > DAFT_BATCH * 9 / 10 && full > 50 && (f->spread ? near > 50 : !near));
        }
    free(f), free(b);
    daft_texture_free(&allocator, &texture);
}

static double sky_texel(const daft_sky_image *s, int x, int y, int channel)
{
    const int row = y < 0 ? 0 : y >= s->height ? s->height - 1 : y, column = (x + s->width) % s->width;
    return (double)s->texels[3 * (row * s->width + column) + channel];
}

static double sky_twin_at(const daft_sky_image *s, daft_vec3 d, int channel)
{
    const double x = (0.5 + atan2((double)d.z, (double)d.x) / (2 * DAFT_PI)) * s->width - 0.5,
                 y = (0.5 - atan2((double)d.y, hypot((double)d.x, (double)d.z)) / DAFT_PI) * s->height - 0.5;
    const int x0 = (int)floor(x), y0 = (int)floor(y);
    return between(between(sky_texel(s, x0, y0, channel), sky_texel(s, x0 + 1, y0, channel), x - x0),
                   between(sky_texel(s, x0, y0 + 1, channel), sky_texel(s, x0 + 1, y0 + 1, channel), x - x0), y - y0);
}

/* Rows of a picture in every direction, over the seam and both poles, close up (one table serves) and wide. The texels
 * end where their memory does. */
static void sky_twin(void **unused)
{
    (void)unused;
    enum { W = 48, H = 24 };
    float *texels = malloc(3 * W * H * sizeof *texels);
    uint32_t state = 11;
    for (int i = 0; i < 3 * W * H; i++) texels[i] = (float)((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f;
    const daft_sky_image image = {.width = W, .height = H, .texels = texels};
    const daft_sky sky = {.kind = DAFT_SKY_IMAGE, .image = &image};
    daft_lanes3 *d = calloc(1, sizeof *d), *color = calloc(1, sizeof *color);
    const float *const got[3] = {color->x, color->y, color->z};
    for (int view = 0; view < 60; view++) {
        const float turn = (float)view * 0.21f, rise = (float)(view % 13 - 6) * 0.26f, step = view % 2 ? 0.01f : 0.2f;
        for (int i = 0; i < DAFT_BATCH; i++) {
            const float across = (float)(i % 32 - 16) * step, up = (float)(i / 32 - 16) * step,
                        ahead = cosf(rise) - up * sinf(rise);
            d->x[i] = ahead * cosf(turn) - across * sinf(turn), d->z[i] = ahead * sinf(turn) + across * cosf(turn);
            d->y[i] = sinf(rise) + up * cosf(rise);
        }
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            daft_shade_kernels_for(isa)->sky(&sky, d, DAFT_BATCH, color);
            for (int i = 0; i < DAFT_BATCH; i++)
                for (int k = 0; k < 3; k++) {
                    const double want = sky_twin_at(&image, (daft_vec3){d->x[i], d->y[i], d->z[i]}, k);
                    assert_true(fabs((double)got[k][i] - want) < 5e-5);
                }
        }
    }
    free(texels), free(d), free(color);
}

/* u = 0.5 + atan2(dz, dx)/2pi, v = 0.5 + asin(dy)/pi, top row first. */
static void sky_image(void **unused)
{
    (void)unused;
    enum { W = 8, H = 4 };
    float texels[3 * W * H];
    for (int i = 0; i < W * H; i++)
        texels[3 * i] = (float)(i % W), texels[3 * i + 1] = (float)(i / W), texels[3 * i + 2] = 1;
    daft_sky_image image = {.width = W, .height = H, .texels = texels};
    daft_sky sky = {.kind = DAFT_SKY_IMAGE, .image = &image};
    daft_lanes3 *d = calloc(1, sizeof *d), *color = calloc(1, sizeof *color);
    uint32_t count = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++, count++) {
            double longitude = ((x + 0.5) / W - 0.5) * 2 * DAFT_PI, latitude = (0.5 - (y + 0.5) / H) * DAFT_PI;
            d->x[count] = (float)(3 * cos(latitude) * cos(longitude)), d->y[count] = (float)(3 * sin(latitude));
            d->z[count] = (float)(3 * cos(latitude) * sin(longitude));
        }
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        daft_shade_kernels_for(isa)->sky(&sky, d, count, color);
        for (uint32_t i = 0; i < count; i++) {
            assert_true(fabsf(color->x[i] - (float)(i % W)) < 1e-3f && fabsf(color->y[i] - (float)(i / W)) < 1e-3f);
            assert_true(color->z[i] == 1);
        }
    }
    d->x[0] = d->y[0] = d->z[0] = 0, d->x[1] = NAN, d->y[2] = INFINITY;
    daft_shade_kernels_for(daft_isa_best())->sky(&sky, d, 3, color);
    free(d);
    free(color);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lane_functions),
                                       cmocka_unit_test(srgb_table),
                                       cmocka_unit_test(encode_round_trip),
                                       cmocka_unit_test(encode_near_thresholds),
                                       cmocka_unit_test(texture_sampling),
                                       cmocka_unit_test(texture_twin),
                                       cmocka_unit_test(textures_in_one_batch),
                                       cmocka_unit_test(dark_points),
                                       cmocka_unit_test(anisotropic_twin),
                                       cmocka_unit_test(sky_image),
                                       cmocka_unit_test(sky_twin)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
