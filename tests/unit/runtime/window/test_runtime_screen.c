/* Pictures in a window without a graphics card: SDL's dummy driver keeps the window's pixels, which are read back. */
#include "platform/screen.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static daft_engine *engine;

typedef struct shown {
    SDL_Window *window;
    screen screen;
} shown;

static shown open_window(int width, int height)
{
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    assert_int_equal(SDL_Init(SDL_INIT_VIDEO), 0);
    shown s = {.window = SDL_CreateWindow("test", 0, 0, width, height, SDL_WINDOW_RESIZABLE)};
    assert_non_null(s.window);
    assert_true(screen_open(&s.screen, s.window));
    assert_null(s.screen.renderer); /* an emulated card is not taken */
    return s;
}

static void close_window(shown *s)
{
    screen_close(&s->screen);
    SDL_DestroyWindow(s->window);
    SDL_Quit();
}

static daft_image *make_picture(int width, int height)
{
    daft_error error;
    daft_image *image = daft_image_create(engine, width, height, &error);
    assert_non_null(image);
    uint8_t *p = daft_image_pixels(image);
    for (int i = 0; i < width * height; i++, p += 4)
        p[0] = (uint8_t)(i % width), p[1] = (uint8_t)(i / width), p[2] = 200, p[3] = (uint8_t)(i % 256);
    return image;
}

static void read_pixel(const shown *s, int x, int y, uint8_t rgb[3])
{
    const SDL_Surface *surface = SDL_GetWindowSurface(s->window);
    uint32_t word;
    memcpy(&word, (const char *)surface->pixels + (ptrdiff_t)y * surface->pitch + 4 * x, 4);
    SDL_GetRGB(word, surface->format, &rgb[0], &rgb[1], &rgb[2]);
}

static void pictures_of_the_windows_size_are_shown_as_they_are(void **unused)
{
    (void)unused;
    daft_error error;
    shown s = open_window(67, 41);
    int width, height;
    assert_true(screen_size(&s.screen, &width, &height));
    assert_true(width == 67 && height == 41);
    daft_image *picture = make_picture(width, height);
    assert_true(screen_show(&s.screen, picture, &error));
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            uint8_t rgb[3];
            read_pixel(&s, x, y, rgb);
            assert_true(rgb[0] == x && rgb[1] == y && rgb[2] == 200);
        }
    daft_image_destroy(picture);
    close_window(&s);
}

/* The border pixels are the picture's, and in between nothing decreases. */
static void others_fill_the_window_smoothly(void **unused)
{
    (void)unused;
    daft_error error;
    shown s = open_window(120, 90);
    daft_image *small = make_picture(40, 30), *large = make_picture(200, 200);
    const daft_image *const pictures[] = {small, large, small};
    for (int i = 0; i < 3; i++) {
        assert_true(screen_show(&s.screen, pictures[i], &error));
        uint8_t first[3], last[3], before[3], now[3];
        read_pixel(&s, 0, 0, first), read_pixel(&s, 119, 89, last);
        assert_true(first[0] <= 1 && first[1] <= 1 && first[2] == 200);
        assert_true(abs(last[0] - (daft_image_width(pictures[i]) - 1)) <= 1);
        assert_true(abs(last[1] - (daft_image_height(pictures[i]) - 1)) <= 2);
        for (int x = 1; x < 120; x++) {
            read_pixel(&s, x - 1, 45, before), read_pixel(&s, x, 45, now);
            assert_true(now[0] >= before[0] && now[0] - before[0] <= 3 && now[2] == 200);
        }
    }
    daft_image_destroy(small), daft_image_destroy(large);
    close_window(&s);
}

static void a_window_of_another_size_is_filled_again(void **unused)
{
    (void)unused;
    daft_error error;
    shown s = open_window(64, 64);
    daft_image *picture = make_picture(64, 64), *wide = make_picture(100, 50);
    assert_true(screen_show(&s.screen, picture, &error));
    SDL_SetWindowSize(s.window, 100, 50);
    SDL_PumpEvents();
    int width, height;
    assert_true(screen_size(&s.screen, &width, &height));
    assert_true(width == 100 && height == 50);
    assert_true(screen_show(&s.screen, picture, &error) && screen_show(&s.screen, wide, &error));
    uint8_t rgb[3];
    read_pixel(&s, 99, 49, rgb);
    assert_true(rgb[0] == 99 && rgb[1] == 49);
    daft_image_destroy(picture), daft_image_destroy(wide);
    close_window(&s);
}

static void words_have_their_colours_where_the_window_wants_them(void **unused)
{
    (void)unused;
    const uint8_t rgba[8] = {1, 2, 3, 4, 250, 251, 252, 253};
    uint32_t out[2];
    screen_pack(rgba, 2, 16, 8, 0, out);
    assert_true(out[0] == 0x010203 && out[1] == 0xfafbfc);
    screen_pack(rgba, 2, 8, 16, 24, out);
    assert_true(out[0] == 0x03020100 && out[1] == 0xfcfbfa00);
}

int main(void)
{
    daft_error error;
    const daft_engine_def def = daft_default_engine_def();
    engine = daft_engine_create(&def, &error);
    const struct CMUnitTest tests[] = {cmocka_unit_test(pictures_of_the_windows_size_are_shown_as_they_are),
                                       cmocka_unit_test(others_fill_the_window_smoothly),
                                       cmocka_unit_test(a_window_of_another_size_is_filled_again),
                                       cmocka_unit_test(words_have_their_colours_where_the_window_wants_them)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    daft_engine_destroy(engine);
    return failed;
}
