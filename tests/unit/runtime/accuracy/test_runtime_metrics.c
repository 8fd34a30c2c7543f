/* runtime: error metrics against other implementations of them, and against values that follow from their definitions.
 */
#include "daft.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>

#include "accuracy/metrics.h"

static daft_error error;

/* The test pairs are pictures by formula, so that any program can make them. "waves": three sines. "steps": eight flat
 * squares a side. Each has a mate: shifted by a pixel ("shift"), darkened ("dark"), or with noise ("noise"). */
enum { WIDTH = 96, HEIGHT = 64, BYTES = 4 * WIDTH * HEIGHT };

static uint8_t byte_of(double value) { return (uint8_t)(fmin(fmax(value, 0), 1) * 255 + 0.5); }

static void fill_waves(uint8_t *out, double shift, double gain)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double x = i % WIDTH + shift, y = i / WIDTH;
        out[4 * i] = byte_of(gain * (0.5 + 0.4 * sin(x / 5)));
        out[4 * i + 1] = byte_of(gain * (0.5 + 0.4 * sin((x + 2 * y) / 9)));
        out[4 * i + 2] = byte_of(gain * (0.5 + 0.4 * sin(y / 4)));
        out[4 * i + 3] = 255;
    }
}

static void fill_steps(uint8_t *out, int shift)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int x = (i % WIDTH + shift) / 12, y = i / WIDTH / 8;
        out[4 * i] = (uint8_t)(x * 53 + y * 91);
        out[4 * i + 1] = (uint8_t)(x * 29 + y * 17);
        out[4 * i + 2] = (uint8_t)(x * 11 + y * 131);
        out[4 * i + 3] = 255;
    }
}

static void add_noise(uint8_t *picture)
{
    uint32_t state = 1;
    for (int i = 0; i < BYTES; i++) {
        state = state * 1664525u + 1013904223u;
        if (i % 4 < 3) picture[i] = byte_of((picture[i] + (int)(state >> 24) / 8 - 16) / 255.0);
    }
}

typedef struct test_pair {
    uint8_t picture[BYTES], reference[BYTES];
} test_pair;

/* tests/data/accuracy/metrics_oracle.py prints this table: NumPy, scikit-image 0.19.3, and the paper's formulas. */
static const struct expected {
    const char *name;
    double rmse, psnr, ssim, flip, worst;
} EXPECTED[] = {
    {"waves-shift", 0.0400319, 27.95187, 0.984994, 0.231716, 0.234681},
    {"waves-dark", 0.1670471, 15.54322, 0.955565, 0.565358, 0.582099},
    {"steps-shift", 0.0851121, 21.40018, 0.832329, 0.129346, 0.182065},
    {"steps-noise", 0.0414900, 27.64114, 0.902490, 0.087693, 0.108880},
};

enum { PAIRS = sizeof EXPECTED / sizeof *EXPECTED };

static void make_pair(int which, test_pair *out)
{
    if (which < 2) fill_waves(out->reference, 0, 1);
    if (which == 0) fill_waves(out->picture, 1, 1);
    if (which == 1) fill_waves(out->picture, 0, 0.8);
    if (which >= 2) fill_steps(out->reference, 0);
    if (which == 2) fill_steps(out->picture, 1);
    if (which == 3) fill_steps(out->picture, 0), add_noise(out->picture);
}

static void test_write_pairs(void **unused)
{
    (void)unused;
    const char *folder = getenv("DAFT_WRITE_PAIRS");
    if (!folder) skip();
    static test_pair pair;
    for (int i = 0; i < PAIRS; i++) {
        make_pair(i, &pair);
        for (int k = 0; k < 2; k++) {
            char path[512];
            snprintf(path, sizeof path, "%s/%s-%s.rgba", folder, EXPECTED[i].name, k ? "reference" : "picture");
            assert_true(daft_write_file(path, k ? pair.reference : pair.picture, BYTES, &error));
        }
    }
}

static void compare(const uint8_t *picture, const uint8_t *reference, int width, int height, picture_errors *out)
{
    if (!metrics_compare(picture, reference, width, height, NULL, out, &error)) fail_msg("%s", error.message);
}

/* FLIP is computed in floats: 2e-6 of the whole range. */
static void test_agrees_with_other_implementations(void **unused)
{
    (void)unused;
    static test_pair pair;
    for (int i = 0; i < PAIRS; i++) {
        make_pair(i, &pair);
        picture_errors e;
        compare(pair.picture, pair.reference, WIDTH, HEIGHT, &e);
        const struct expected *x = &EXPECTED[i];
        print_message("%s: rmse %.7f psnr %.5f ssim %.6f flip %.6f worst %.6f\n", x->name, e.rmse, e.psnr, e.ssim,
                      e.flip, e.worst);
        assert_true(fabs(e.rmse - x->rmse) < 1e-7 && fabs(e.psnr - x->psnr) < 1e-5);
        assert_true(fabs(e.ssim - x->ssim) < 1e-6);
        assert_true(fabs(e.flip - x->flip) < 2e-6 && fabs(e.worst - x->worst) < 2e-6);
    }
}

static void fill_flat(uint8_t *out, int red, int green, int blue)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        out[4 * i] = (uint8_t)red, out[4 * i + 1] = (uint8_t)green, out[4 * i + 2] = (uint8_t)blue;
        out[4 * i + 3] = 255;
    }
}

static void test_equal_pictures(void **unused)
{
    (void)unused;
    static test_pair pair;
    make_pair(0, &pair);
    picture_errors e;
    compare(pair.reference, pair.reference, WIDTH, HEIGHT, &e);
    assert_true(e.rmse == 0 && e.psnr > 0 && isinf(e.psnr) && e.flip == 0 && e.worst == 0);
    assert_true(fabs(e.ssim - 1) < 1e-12);
}

/* By definition green and blue are the furthest apart for FLIP; black and white are 1 apart in linear light. */
static void test_ends_of_the_scales(void **unused)
{
    (void)unused;
    static test_pair pair;
    picture_errors e;
    fill_flat(pair.picture, 0, 255, 0), fill_flat(pair.reference, 0, 0, 255);
    compare(pair.picture, pair.reference, WIDTH, HEIGHT, &e);
    assert_true(fabs(e.flip - 1) < 1e-5 && fabs(e.worst - 1) < 1e-5);
    fill_flat(pair.picture, 0, 0, 0), fill_flat(pair.reference, 255, 255, 255);
    compare(pair.picture, pair.reference, WIDTH, HEIGHT, &e);
    assert_true(fabs(e.rmse - 1) < 1e-12 && fabs(e.psnr) < 1e-9);
}

static void test_pictures_smaller_than_a_window(void **unused)
{
    (void)unused;
    const uint8_t dark[4] = {10, 10, 10, 255}, bright[4] = {200, 180, 160, 255};
    picture_errors e;
    compare(dark, dark, 1, 1, &e);
    assert_true(e.ssim == 1 && e.flip == 0);
    compare(dark, bright, 1, 1, &e);
    assert_true(isnan(e.ssim) && e.flip > 0.3 && e.flip <= 1 && e.rmse > 0);
}

/* A byte survives the way to linear light and back. */
static void test_bytes_survive(void **unused)
{
    (void)unused;
    for (int i = 0; i < 256; i++) assert_int_equal(metrics_to_srgb(metrics_to_linear((uint8_t)i)), i);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_write_pairs),
                                       cmocka_unit_test(test_agrees_with_other_implementations),
                                       cmocka_unit_test(test_equal_pictures),
                                       cmocka_unit_test(test_ends_of_the_scales),
                                       cmocka_unit_test(test_pictures_smaller_than_a_window),
                                       cmocka_unit_test(test_bytes_survive)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
