/* Any bytes as a TrueType file: what opens draws every character that is asked of it, and measures the same twice. */
#include "fuzz.h"

#include "hud/canvas.h"

#include <math.h>
#include <string.h>

enum { SIZE = 64 };

static void draw(font *face)
{
    static const char text[] =
        "ABC abc fi \xc3\xa4\xce\xb1\xd0\xb6 \xf0\x9f\x98\x80\xf0\x9f\x98\x81 \xff\n\xe2\x86\x91.";
    static const float sizes[] = {1, 30, 400};
    static uint8_t pixels[4 * SIZE * SIZE];
    canvas target = {.pixels = pixels, .width = SIZE, .height = SIZE, .unit = 1};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        const text_style style = {sizes[i], {255, 255, 255, 255}, TEXT_CENTER, true};
        text_draw(&target, face, text, SIZE / 2, 0, &style);
        text_draw_wrapped(&target, face, text, SIZE / 2, 0, 40, &style);
        const float width = text_width(face, text, sizes[i]);
        FUZZ_CHECK(isfinite(width) && width == text_width(face, text, sizes[i]));
    }
}

int font_input(const uint8_t *data, size_t size)
{
    daft_error error = {0};
    const char *path = fuzz_write("input.ttf", data, size);
    font *face = font_open(NULL, NULL, path, path, &error);
    fuzz_check_error(face != NULL, &error);
    if (face) draw(face);
    font_close(face);
    return 0;
}
