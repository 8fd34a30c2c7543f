/* runtime: shapes and images over a picture: how much they cover, where they end, and nothing outside, ever. */
#include "hud/canvas.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>

enum { WIDTH = 160, HEIGHT = 90, GUARD = 4096 };

/* A picture between two zones that nobody may write to. */
static uint8_t memory[GUARD + 4 * WIDTH * HEIGHT + GUARD];
static const canvas_color WHITE = {255, 255, 255, 255};
static daft_engine *engine;

/* Black; a unit is a pixel. */
static canvas fresh(void)
{
    memset(memory, 0, sizeof memory);
    return (canvas){.pixels = memory + GUARD, .width = WIDTH, .height = HEIGHT, .unit = 1};
}

static uint8_t red(const canvas *target, int x, int y) { return target->pixels[4 * (y * WIDTH + x)]; }

/* Pixels, whole and in part. */
static double area(const canvas *target)
{
    double sum = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) sum += target->pixels[4 * i] / 255.0;
    return sum;
}

static void assert_area(const canvas *target, double wanted)
{
    const double got = area(target);
    if (fabs(got - wanted) > 0.005 * wanted + 0.5) fail_msg("%g pixels covered, not %g", got, wanted);
}

static void assert_guards(void)
{
    for (size_t i = 0; i < GUARD; i++) {
        assert_int_equal(memory[i], 0);
        assert_int_equal(memory[sizeof memory - 1 - i], 0);
    }
}

static void polygons_cover_their_area(void **unused)
{
    (void)unused;
    uint64_t state = 0x853c49e6748fea9bu;
    for (int i = 0; i < 200; i++) {
        canvas target = fresh();
        canvas_point p[3];
        for (int k = 0; k < 3; k++) {
            state ^= state << 13, state ^= state >> 7, state ^= state << 17;
            p[k] = (canvas_point){(float)(state % 1600) / 10, (float)(state / 1600 % 900) / 10};
        }
        const double twice = (double)((p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y));
        canvas_polygon(&target, p, 3, WHITE);
        assert_area(&target, fabs(twice) / 2);
    }
    assert_guards();
}

static void what_reaches_beyond_the_picture_is_cut_off(void **unused)
{
    (void)unused;
    canvas target = fresh();
    const canvas_point wide[] = {{-1000, 30}, {1000, 30}, {1000, 60}, {-1000, 60}};
    canvas_polygon(&target, wide, 4, WHITE);
    assert_area(&target, WIDTH * 30);
    target = fresh();
    /* A diagonal through the corners of the picture, drawn from far away. */
    const canvas_point half[] = {{-1600, -900}, {1760, 990}, {-1600, 990}};
    canvas_polygon(&target, half, 3, WHITE);
    assert_area(&target, WIDTH * HEIGHT / 2);
    target = fresh();
    canvas_clip(&target, 20, 10, 30, 40);
    canvas_polygon(&target, wide, 4, WHITE);
    canvas_rect(&target, 0, 0, 1000, 20, WHITE);
    assert_area(&target, 30 * 20 + 30 * 10);
    assert_int_equal(red(&target, 19, 40), 0);
    assert_int_equal(red(&target, 20, 40), 255);
    canvas_clip(&target, 20, 10, 0, 0);
    canvas_circle(&target, 20, 10, 500, 0, WHITE);
    assert_area(&target, 30 * 20 + 30 * 10);
    canvas_unclip(&target);
    canvas_rect(&target, 0, 0, 1000, 1000, WHITE);
    assert_area(&target, WIDTH * HEIGHT);
    assert_guards();
}

static void circles_rings_and_lines_cover_their_area(void **unused)
{
    (void)unused;
    const double pi = 3.14159265358979;
    canvas target = fresh();
    canvas_circle(&target, 80, 45, 40, 0, WHITE);
    assert_area(&target, pi * 1600);
    target = fresh();
    canvas_circle(&target, 80, 45, 30, 8, WHITE);
    assert_area(&target, 2 * pi * 30 * 8);
    assert_int_equal(red(&target, 80, 45), 0);
    target = fresh();
    const canvas_point slope[] = {{20, 20}, {120, 70}};
    canvas_line(&target, slope, 2, false, 6, WHITE);
    assert_area(&target, 6 * sqrt(100.0 * 100 + 50 * 50));
    /* Where it crosses itself a half transparent line is no brighter. */
    target = fresh();
    const canvas_point cross[] = {{20, 20}, {120, 70}, {120, 20}, {20, 70}};
    canvas_line(&target, cross, 4, false, 6, (canvas_color){255, 255, 255, 128});
    for (int i = 0; i < WIDTH * HEIGHT; i++) assert_in_range(target.pixels[4 * i], 0, 129);
    assert_guards();
}

static void nothing_is_drawn_outside(void **unused)
{
    (void)unused;
    const float far[] = {-1e30f, -1e6f, -2000, -1, 0, 1e-30f, 89, 160, 1e5f, 9e5f, 1e30f, 0.0f / 0.0f, 1 / 0.0f};
    const size_t count = sizeof far / sizeof far[0];
    daft_error error;
    daft_image *image = daft_image_create(engine, 8, 8, &error);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < count; k++) {
            canvas target = fresh();
            const canvas_point p[] = {{far[i], far[k]}, {far[k], far[(i + 3) % count]}, {far[(k + 5) % count], 20}};
            canvas_polygon(&target, p, 3, WHITE);
            canvas_line(&target, p, 3, true, far[(i + k) % count], WHITE);
            canvas_circle(&target, far[i], far[k], far[(i + 7) % count], far[(k + 2) % count], WHITE);
            canvas_sprite s = canvas_default_sprite(image);
            s.width = far[(i + 1) % count], s.height = far[(k + 1) % count], s.rotation = 0.3f, s.border = 3;
            canvas_draw_sprite(&target, image, far[i], far[k], &s);
            canvas_clip(&target, far[i], far[k], far[(i + 5) % count], far[(k + 7) % count]);
            canvas_rect(&target, far[k], far[i], 1e9f, 1e9f, WHITE);
        }
    daft_image_destroy(image);
    assert_guards();
}

/* Four by four: red 10, 20, … from the top left, opaque. */
static daft_image *make_image(void)
{
    daft_error error;
    daft_image *image = daft_image_create(engine, 4, 4, &error);
    assert_non_null(image);
    for (int i = 0; i < 16; i++)
        memcpy(daft_image_pixels(image) + (size_t)(4 * i), (uint8_t[]){(uint8_t)(10 * i + 10), 0, 200, 255}, 4);
    return image;
}

static void images_are_drawn_as_they_are_scaled_and_turned(void **unused)
{
    (void)unused;
    daft_image *image = make_image();
    canvas target = fresh();
    canvas_sprite s = canvas_default_sprite(image);
    canvas_draw_sprite(&target, image, 10, 5, &s);
    for (int i = 0; i < 16; i++) assert_int_equal(red(&target, 10 + i % 4, 5 + i / 4), 10 * i + 10);
    assert_int_equal(red(&target, 9, 5) + red(&target, 14, 5) + red(&target, 10, 9), 0);
    s.width = s.height = 8, s.smooth = false;
    canvas_draw_sprite(&target, image, 40, 40, &s);
    for (int i = 0; i < 64; i++)
        assert_int_equal(red(&target, 40 + i % 8, 40 + i / 8), 10 * (i / 16 * 4 + i % 8 / 2) + 10);
    /* A quarter to the right about its middle: what was left is on top. */
    s = canvas_default_sprite(image);
    s.rotation = 1.5707963f, s.origin_x = s.origin_y = 0.5f;
    canvas_draw_sprite(&target, image, 80, 60, &s);
    assert_int_equal(red(&target, 78, 58), 130);
    assert_int_equal(red(&target, 81, 58), 10);
    assert_int_equal(red(&target, 81, 61), 40);
    for (int i = 0; i < 100; i++) { /* at no whole pixel */
        s.rotation = (float)i, s.width = 3.7f + (float)i / 3, s.border = (float)(i % 3);
        canvas_draw_sprite(&target, image, 40.3f, 30.7f, &s);
    }
    s = canvas_default_sprite(image);
    s.tint = (canvas_color){128, 255, 255, 255};
    s.source_x = 1, s.source_y = 2, s.source_width = s.width = 2, s.source_height = s.height = 1;
    canvas_draw_sprite(&target, image, 100, 10, &s);
    assert_in_range(red(&target, 100, 10), 49, 51); /* half of 100 */
    assert_in_range(red(&target, 101, 10), 54, 56);
    assert_int_equal(red(&target, 102, 10), 0);
    /* Far smaller than it is, it is the mean. */
    target = fresh();
    s = canvas_default_sprite(image);
    s.width = s.height = 1;
    canvas_draw_sprite(&target, image, 3, 3, &s);
    assert_in_range(red(&target, 3, 3), 83, 87);
    daft_image_destroy(image);
    assert_guards();
}

static void nine_patches_keep_their_corners(void **unused)
{
    (void)unused;
    daft_image *image = make_image();
    canvas target = fresh();
    canvas_sprite s = canvas_default_sprite(image);
    s.width = 40, s.height = 20, s.border = 1, s.smooth = false;
    canvas_draw_sprite(&target, image, 0, 0, &s);
    assert_int_equal(red(&target, 0, 0), 10);
    assert_int_equal(red(&target, 1, 0), 20);
    assert_int_equal(red(&target, 18, 0), 20);
    assert_int_equal(red(&target, 38, 0), 30);
    assert_int_equal(red(&target, 39, 0), 40);
    assert_int_equal(red(&target, 39, 19), 160);
    assert_int_equal(red(&target, 0, 10), 90);
    daft_image_destroy(image);
}

static void a_canvas_of_its_own_size_fits_in_the_middle(void **unused)
{
    (void)unused;
    canvas target = fresh();
    canvas_fit(&target, 100, 100);
    canvas_rect(&target, 0, 0, 100, 100, WHITE);
    assert_area(&target, 90 * 90);
    assert_int_equal(red(&target, 34, 45), 0);
    assert_int_equal(red(&target, 35, 45), 255);
    assert_int_equal(red(&target, 125, 45), 0);
    canvas_reset(&target);
    canvas_rect(&target, 0, 0, 10000, 720, WHITE);
    assert_area(&target, WIDTH * HEIGHT);
}

static int make_engine(void **unused)
{
    (void)unused;
    daft_engine_def def = daft_default_engine_def();
    daft_error error;
    engine = daft_engine_create(&def, &error);
    return engine ? 0 : -1;
}

static int close_engine(void **unused)
{
    (void)unused;
    daft_engine_destroy(engine);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(polygons_cover_their_area),
                                       cmocka_unit_test(what_reaches_beyond_the_picture_is_cut_off),
                                       cmocka_unit_test(circles_rings_and_lines_cover_their_area),
                                       cmocka_unit_test(nothing_is_drawn_outside),
                                       cmocka_unit_test(images_are_drawn_as_they_are_scaled_and_turned),
                                       cmocka_unit_test(nine_patches_keep_their_corners),
                                       cmocka_unit_test(a_canvas_of_its_own_size_fits_in_the_middle)};
    return cmocka_run_group_tests(tests, make_engine, close_engine);
}
