/* daft render --term: what the three kinds of terminals are sent is the picture. */
#include "fixtures.h"

#include <unistd.h>

enum { WIDTH = 32, HEIGHT = 18, MOST = 1 << 20 };

static char said[MOST];
static uint8_t picture[3 * WIDTH * HEIGHT], shown[3 * WIDTH * HEIGHT];

static size_t run(const char *variables, const char *arguments)
{
    char command[1024];
    snprintf(command, sizeof command, "%s '%s' render '%s/assets/scenes/temple.scene' --size 32x18 %s 2>/dev/null",
             variables, DAFT_PROGRAM, DAFT_ROOT, arguments);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    size_t size = fread(said, 1, sizeof said - 1, pipe);
    assert_int_equal(pclose(pipe), 0);
    said[size] = 0;
    return size;
}

static int begin(void **unused)
{
    (void)unused;
    char path[] = "/tmp/daft-term-XXXXXX.ppm";
    int file = mkstemps(path, 4);
    if (file < 0) return -1;
    close(file);
    char arguments[64];
    snprintf(arguments, sizeof arguments, "-o %s", path);
    run("", arguments);
    FILE *ppm = fopen(path, "rb");
    int matched = ppm ? fscanf(ppm, "P6 %*d %*d %*d") : EOF;
    bool good = matched != EOF && fgetc(ppm) == '\n' && fread(picture, 1, sizeof picture, ppm) == sizeof picture;
    if (ppm) fclose(ppm);
    unlink(path);
    return good ? 0 : -1;
}

static int digit(char c)
{
    static const char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c ? strchr(DIGITS, c) : NULL;
    return at ? (int)(at - DIGITS) : -1;
}

/* All messages' characters are one text in base 64, of RGBA. */
static void kitty_gets_the_pixels(void **unused)
{
    (void)unused;
    run("DAFT_TERM=kitty", "--term");
    assert_non_null(strstr(said, "a=T,f=32,s=32,v=18,m=0;"));
    uint32_t bits = 0;
    size_t count = 0, bytes = 0;
    for (const char *at = strchr(said, ';') + 1; digit(*at) >= 0; at++) {
        bits = bits << 6 | (uint32_t)digit(*at);
        if ((count += 6) < 8) continue;
        count -= 8;
        uint8_t byte = (uint8_t)(bits >> count);
        if (bytes % 4 < 3) shown[bytes / 4 * 3 + bytes % 4] = byte;
        bytes++;
    }
    assert_int_equal(bytes, 4 * WIDTH * HEIGHT);
    assert_memory_equal(shown, picture, sizeof picture);
}

static void read_colour(const char **at, int ground, uint8_t *out)
{
    int red, green, blue, length, number;
    if (sscanf(*at, "\033[%d;2;%d;%d;%dm%n", &number, &red, &green, &blue, &length) != 4 || number != ground) return;
    out[0] = (uint8_t)red, out[1] = (uint8_t)green, out[2] = (uint8_t)blue;
    *at += length;
}

static void half_blocks_have_the_colours(void **unused)
{
    (void)unused;
    run("DAFT_TERM=blocks", "--term");
    const char *at = said;
    for (int line = 0; line < HEIGHT / 2; line++) {
        uint8_t upper[3], lower[3];
        for (int x = 0; x < WIDTH; x++) {
            read_colour(&at, 38, upper), read_colour(&at, 48, lower);
            assert_memory_equal(at, "\xe2\x96\x80", 3);
            at += 3;
            memcpy(shown + 3 * (2 * line * WIDTH + x), upper, 3);
            memcpy(shown + 3 * ((2 * line + 1) * WIDTH + x), lower, 3);
        }
        assert_memory_equal(at, "\033[0m\n", 5);
        at += 5;
    }
    assert_int_equal(*at, 0);
    assert_memory_equal(shown, picture, sizeof picture);
}

/* A small reader of sixels: each pixel gets one colour, at most a level of the palette (and a rounded percent) away. */
static void sixels_are_near_the_colours(void **unused)
{
    (void)unused;
    run("DAFT_TERM=sixel", "--term");
    int palette[256][3] = {{0}}, colour = 0, x = 0, top = 0, wide, high, length;
    static int written[WIDTH * HEIGHT];
    memset(written, 0, sizeof written);
    const char *at = said;
    assert_int_equal(sscanf(at, "\033Pq\"1;1;%d;%d%n", &wide, &high, &length), 2);
    assert_true(wide == WIDTH && high == HEIGHT);
    for (at += length; *at != '\033'; at++) {
        int run_length = 1, rgb[3];
        if (*at == '#') {
            assert_int_equal(sscanf(at, "#%d%n", &colour, &length), 1);
            at += length - 1;
            if (sscanf(at + 1, ";2;%d;%d;%d%n", &rgb[0], &rgb[1], &rgb[2], &length) == 3)
                memcpy(palette[colour], rgb, sizeof rgb), at += length;
            continue;
        }
        if (*at == '$' || *at == '-') {
            top += *at == '-' ? 6 : 0, x = 0;
            continue;
        }
        if (*at == '!') assert_int_equal(sscanf(at, "!%d%n", &run_length, &length), 1), at += length;
        for (; run_length > 0; run_length--, x++)
            for (int bit = 0; bit < 6; bit++) {
                if (!((*at - 63) >> bit & 1)) continue;
                assert_true(x < WIDTH && top + bit < HEIGHT);
                int pixel = (top + bit) * WIDTH + x;
                written[pixel]++;
                for (int k = 0; k < 3; k++)
                    assert_in_range(abs(palette[colour][k] * 255 / 100 - picture[3 * pixel + k]), 0, 51 + 3);
            }
    }
    for (int i = 0; i < WIDTH * HEIGHT; i++) assert_int_equal(written[i], 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kitty_gets_the_pixels),
        cmocka_unit_test(half_blocks_have_the_colours),
        cmocka_unit_test(sixels_are_near_the_colours),
    };
    return cmocka_run_group_tests(tests, begin, NULL);
}
