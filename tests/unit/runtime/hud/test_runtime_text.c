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
    return (canvas){.pixels = memory + GUARD, .width = WIDTH, .height = HEIGHT, .unit = (float)HEIGHT / CANVAS_HEIGHT};
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
    assert_null(font_open(NULL, NULL, DAFT_ROOT "/CMakeLists.txt", "x.ttf", &error));
    assert_non_null(strstr(error.message, "not a TrueType font"));
    assert_null(font_open(NULL, NULL, DAFT_ROOT "/no.ttf", "x.ttf", &error));
    assert_null(font_open(NULL, NULL, DAFT_ROOT, "x.ttf", &error));
}

/* How many pixels the text covers. */
static size_t ink(font *with, const char *text)
{
    canvas target = fresh();
    const text_style style = {200, WHITE, TEXT_LEFT, false};
    text_draw(&target, with, text, 8, 8, &style);
    return changed(&target);
}

static bool looks_alike(const char *a, const char *b)
{
    static uint8_t first[4 * WIDTH * HEIGHT];
    ink(face, a);
    memcpy(first, memory + GUARD, sizeof first);
    ink(face, b);
    return memcmp(first, memory + GUARD, sizeof first) == 0;
}

static void our_font_has_latin_greek_and_cyrillic_and_a_box_for_the_rest(void **unused)
{
    (void)unused;
    static const struct {
        unsigned first, last;
    } ranges[] = {{0x21, 0x7e}, {0xc0, 0xff}, {0x391, 0x3a1}, {0x3a3, 0x3a9}, {0x3b1, 0x3c9}, {0x410, 0x44f}};
    const char *box = "\xe6\xbc\xa2"; /* a Chinese letter */
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        for (unsigned code = ranges[i].first; code <= ranges[i].last; code++) {
            char text[3] = {(char)code, 0, 0};
            if (code == 0xd0 || code == 0xf7) continue; /* Eth is there, too; the sign for division is not */
            if (code > 127) text[0] = (char)(0xc0 | code >> 6), text[1] = (char)(0x80 | (code & 63));
            if (ink(face, text) == 0 || looks_alike(text, box)) fail_msg("U+%04X is missing", code);
        }
    }
    assert_true(ink(face, box) > 0 && looks_alike(box, "\xff") && looks_alike(box, "\xf0\x9f\x98\x80"));
    assert_true(looks_alike("\xd0\x90", "A") && !looks_alike("\xd0\x91", "B"));
}

static font *open_seed(const char *name)
{
    char path[300];
    daft_error error;
    snprintf(path, sizeof path, "%s/tests/fuzz/seeds/font/%s", DAFT_ROOT, name);
    font *opened = font_open(NULL, NULL, path, name, &error);
    if (!opened) fail_msg("%s", error.message);
    return opened;
}

/* The seed's A is a square of 0.4 em, B a round dot of 0.2, C both, the dot at half its size; A before A is kerned. */
static void parts_kerning_and_every_kind_of_character_table_are_read(void **unused)
{
    (void)unused;
    font *parts = open_seed("parts.ttf");
    const size_t a = ink(parts, "A"), b = ink(parts, "B"), c = ink(parts, "C");
    assert_true(a > 2 * b && b > 0 && c > a && c < a + b);
    const float one = text_width(parts, "A", 100), two = text_width(parts, "AA", 100);
    assert_true(one == 45 && two == 80); /* 450 and 2 · 450 - 100 of 1000 units */
    assert_true(text_width(parts, "?", 100) == 60);
    font *others[] = {open_seed("bytes.ttf"), open_seed("trimmed.ttf")};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ink(others[i], "A"), a);
        font_close(others[i]);
    }
    font *groups = open_seed("groups.ttf");
    assert_int_equal(ink(groups, "\xf0\x9f\x98\x80"), b); /* U+1F600 */
    assert_int_equal(ink(groups, " "), 0);
    font_close(groups);
    font_close(parts);
}

static bool opens(const uint8_t *bytes, size_t size, daft_error *error)
{
    const char *path = "damaged.ttf";
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
    font *opened = font_open(NULL, NULL, path, path, error);
    if (opened) ink(opened, "Ag\xc3\xa4\xce\xb1");
    font_close(opened);
    remove(path);
    return opened != NULL;
}

static void damaged_fonts_are_errors_or_harmless(void **unused)
{
    (void)unused;
    daft_error error;
    size_t size;
    uint8_t *bytes = daft_read_file(NULL, DAFT_ROOT "/assets/fonts/daft.ttf", &size, &error);
    assert_non_null(bytes);
    for (size_t length = 0; length < size - 100; length += length < 200 ? 7 : size / 40) {
        error.message[0] = 0;
        assert_false(opens(bytes, length, &error)); /* its last tables are needed: what is cut off is missed */
        assert_true(error.message[0] != 0);
    }
    uint64_t state = 0x9e3779b97f4a7c15u;
    for (int i = 0; i < 150; i++) {
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
        const size_t at = i < 100 ? state % 400 : state % size;
        const uint8_t before = bytes[at];
        bytes[at] = (uint8_t)(state >> 40);
        opens(bytes, size, &error);
        bytes[at] = before;
    }
    free(bytes);
    assert_guards();
}

static void a_font_counts_towards_the_memory_limit(void **unused)
{
    (void)unused;
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    const char *path = DAFT_ROOT "/assets/fonts/daft.ttf";
    const uint64_t before = daft_engine_memory(engine).used;
    font *opened = font_open(engine, NULL, path, path, &error);
    assert_true(opened && daft_engine_memory(engine).used > before + 4000000);
    font_close(opened);
    assert_true(daft_engine_memory(engine).used == before);
    daft_engine_destroy(engine);
    def.memory_limit = 4000000;
    engine = daft_engine_create(&def, &error);
    assert_non_null(engine);
    assert_null(font_open(engine, NULL, path, path, &error));
    assert_non_null(strstr(error.message, "memory"));
    daft_engine_destroy(engine);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(widths_follow_the_letters_and_the_size),
                                       cmocka_unit_test(a_half_covered_pixel_is_half_white),
                                       cmocka_unit_test(alignment_puts_text_left_of_in_the_middle_of_and_right_of_x),
                                       cmocka_unit_test(nothing_is_drawn_outside),
                                       cmocka_unit_test(any_bytes_are_drawn_somehow),
                                       cmocka_unit_test(lines_break_at_blanks_and_never_exceed_the_width),
                                       cmocka_unit_test(a_file_that_is_no_font_is_an_error),
                                       cmocka_unit_test(our_font_has_latin_greek_and_cyrillic_and_a_box_for_the_rest),
                                       cmocka_unit_test(parts_kerning_and_every_kind_of_character_table_are_read),
                                       cmocka_unit_test(damaged_fonts_are_errors_or_harmless),
                                       cmocka_unit_test(a_font_counts_towards_the_memory_limit)};
    return cmocka_run_group_tests(tests, open_face, close_face);
}
