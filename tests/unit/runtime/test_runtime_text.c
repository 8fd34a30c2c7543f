/* runtime: text and rectangles over a picture: widths, line breaks, UTF-8, and nothing outside the picture, ever. */
#include "hud/canvas.h"
#include "cli/commands.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static font *face;

static int open_face(void **unused)
{
    (void)unused;
    home where;
    daft_error error;
    if (!home_find(&where, &error)) return -1;
    face = open_font(&where, &error);
    return face ? 0 : -1;
}

static int close_face(void **unused)
{
    (void)unused;
    font_close(face);
    return 0;
}

enum { WIDTH = 160, HEIGHT = 90, GUARD = 4096 };

/* A picture between two zones that nobody may write to. */
static uint8_t memory[GUARD + 4 * WIDTH * HEIGHT + GUARD];

static canvas fresh(void)
{
    memset(memory, 0x55, sizeof memory);
    return (canvas){memory + GUARD, WIDTH, HEIGHT, (float)HEIGHT / CANVAS_HEIGHT};
}

static size_t changed(const canvas *target)
{
    size_t count = 0;
    for (size_t i = 0; i < 4 * WIDTH * HEIGHT; i++) count += target->pixels[i] != 0x55;
    return count;
}

static void assert_guards(void)
{
    for (size_t i = 0; i < GUARD; i++) {
        assert_int_equal(memory[i], 0x55);
        assert_int_equal(memory[sizeof memory - 1 - i], 0x55);
    }
}

static const canvas_color WHITE = {255, 255, 255, 255};

static void widths_follow_the_letters_and_the_size(void **unused)
{
    (void)unused;
    assert_true(text_width(face, "", 20) == 0);
    assert_true(text_width(face, "iii", 20) < text_width(face, "MMM", 20));
    float once = text_width(face, "score 12", 20), twice = text_width(face, "score 12", 40);
    assert_true(twice > once * 1.999f && twice < once * 2.001f);
    assert_true(text_width(face, "a\nlonger line\nb", 20) == text_width(face, "longer line", 20));
    assert_true(text_width(face, "x\xc3\xa4x", 20) > text_width(face, "xx", 20));
}

static void a_half_covered_pixel_is_half_white(void **unused)
{
    (void)unused;
    canvas target = fresh();
    /* One pixel is eight units: from 0.5 to 2.5 pixels across, 1 to 2 down. */
    canvas_rect(&target, 4, 8, 16, 8, WHITE);
    const uint8_t *row = target.pixels + 4 * WIDTH;
    assert_in_range(row[0], 0x55 + 83, 0x55 + 87);
    assert_int_equal(row[4], 255);
    assert_in_range(row[8], 0x55 + 83, 0x55 + 87);
    assert_int_equal(row[12], 0x55);
    assert_int_equal(row[3], 0x55); /* the picture's own alpha stays */
    assert_int_equal(target.pixels[4], 0x55);
    assert_guards();
}

static void alignment_puts_text_left_of_in_the_middle_of_and_right_of_x(void **unused)
{
    (void)unused;
    static const text_align aligns[] = {TEXT_LEFT, TEXT_CENTER, TEXT_RIGHT};
    int left_ends[3];
    for (int i = 0; i < 3; i++) {
        canvas target = fresh();
        text_style style = {160, WHITE, aligns[i], false};
        text_draw(&target, face, "HH", 640, 100, &style);
        left_ends[i] = WIDTH;
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < left_ends[i]; x++)
                if (target.pixels[4 * (y * WIDTH + x)] != 0x55) left_ends[i] = x;
    }
    int half = (int)(text_width(face, "HH", 160) / 16);
    assert_in_range(left_ends[0], 80, 84);
    assert_in_range(left_ends[1], 80 - half - 1, 84 - half);
    assert_in_range(left_ends[2], 80 - 2 * half - 2, 84 - 2 * half);
}

static void nothing_is_drawn_outside(void **unused)
{
    (void)unused;
    const float far[] = {-1e30f, -1e9f, -2000, -640, -30,  -1,    0,           1e-30f,
                         700,    719,   1279,  1e5f, 1e9f, 1e30f, 0.0f / 0.0f, 1 / 0.0f};
    const size_t count = sizeof far / sizeof far[0];
    canvas target = fresh();
    text_style style = {300, WHITE, TEXT_LEFT, true};
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < count; k++) {
            style.align = (text_align)((i + k) % 3);
            text_draw(&target, face, "Wide words\nand lines", far[i], far[k], &style);
            canvas_rect(&target, far[i], far[k], far[(i + 5) % count], far[(k + 7) % count], WHITE);
        }
    }
    assert_true(changed(&target) > 0);
    assert_guards();
}

static void any_bytes_are_drawn_somehow(void **unused)
{
    (void)unused;
    canvas target = fresh();
    uint64_t state = 0x853c49e6748fea9bu;
    print_message("seed %#llx\n", (unsigned long long)state);
    for (int i = 0; i < 3000; i++) {
        char bytes[48];
        size_t length = 0;
        for (; length < sizeof bytes - 1; length++) {
            state ^= state << 13, state ^= state >> 7, state ^= state << 17;
            bytes[length] = (char)(state >> 30);
            if (bytes[length] == 0) break;
        }
        bytes[length] = 0;
        text_style style = {(float)(20 + i % 60), WHITE, TEXT_LEFT, i % 2 == 0};
        text_draw(&target, face, bytes, (float)(i % 1280), (float)(i % 720), &style);
        text_draw_wrapped(&target, face, bytes, 10, 10, (float)(i % 300), &style);
        assert_true(text_width(face, bytes, 20) >= 0);
    }
    assert_guards();
}

static void lines_break_at_blanks_and_never_exceed_the_width(void **unused)
{
    (void)unused;
    text_style style = {20, WHITE, TEXT_LEFT, false};
    const float line = text_line_height(20);
    assert_true(text_draw_wrapped(NULL, face, "", 0, 0, 500, &style) == 0);
    assert_true(text_draw_wrapped(NULL, face, "short", 0, 0, 500, &style) == line);
    assert_true(text_draw_wrapped(NULL, face, "one\n\ntwo", 0, 0, 500, &style) == 3 * line);
    float two = text_width(face, "two words", 20);
    assert_true(text_draw_wrapped(NULL, face, "two words", 0, 0, two + 1, &style) == line);
    assert_true(text_draw_wrapped(NULL, face, "two words", 0, 0, two - 1, &style) == 2 * line);
    /* A word wider than the room is cut, not lost, and even no room at all comes to an end. */
    assert_true(text_draw_wrapped(NULL, face, "MMMMMMMMMMMMMMMMMMMM", 0, 0, text_width(face, "MMMMM", 20) + 1,
                                  &style) == 4 * line);
    assert_true(text_draw_wrapped(NULL, face, "\xc3\xa4\xc3\xb6\xc3\xbc", 0, 0, 0, &style) == 3 * line);
}

static void a_file_that_is_no_font_is_an_error(void **unused)
{
    (void)unused;
    daft_error error;
    assert_null(font_open(DAFT_ROOT "/CMakeLists.txt", &error));
    assert_non_null(strstr(error.message, "not a TrueType font"));
    assert_null(font_open(DAFT_ROOT "/no.ttf", &error));
    assert_null(font_open(DAFT_ROOT, &error));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(widths_follow_the_letters_and_the_size),
                                       cmocka_unit_test(a_half_covered_pixel_is_half_white),
                                       cmocka_unit_test(alignment_puts_text_left_of_in_the_middle_of_and_right_of_x),
                                       cmocka_unit_test(nothing_is_drawn_outside),
                                       cmocka_unit_test(any_bytes_are_drawn_somehow),
                                       cmocka_unit_test(lines_break_at_blanks_and_never_exceed_the_width),
                                       cmocka_unit_test(a_file_that_is_no_font_is_an_error)};
    return cmocka_run_group_tests(tests, open_face, close_face);
}
