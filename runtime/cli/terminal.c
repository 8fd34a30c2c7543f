/* Pictures in terminals. */
#include "cli/terminal.h"

#include "common/util.h"

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

enum { ANSWER_MS = 200, COLUMNS = 80, LINES = 24, CELL_W = 8, CELL_H = 16 };

/* ---- what it can ---- */

static bool variable_has(const char *name, const char *part)
{
    const char *value = getenv(name);
    return value && strstr(value, part);
}

/* The answer to "primary device attributes" lists 4 where the terminal draws sixels (DEC, VT340 manual). */
static bool answers_sixel(int file)
{
    char answer[128];
    size_t size = 0;
    if (write(file, "\033[c", 3) != 3) return false;
    struct pollfd wait = {.fd = file, .events = POLLIN};
    while (size + 1 < sizeof answer && poll(&wait, 1, ANSWER_MS) == 1) {
        if (read(file, answer + size, 1) != 1) break;
        if (answer[size++] == 'c') break;
    }
    answer[size] = 0;
    return strstr(answer, ";4;") || strstr(answer, ";4c") || strstr(answer, "?4;");
}

static bool draws_sixels(void)
{
    struct termios old, raw;
    if (!isatty(STDOUT_FILENO) || !isatty(STDIN_FILENO) || tcgetattr(STDIN_FILENO, &old) != 0) return false;
    raw = old;
    raw.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    if (tcsetattr(STDIN_FILENO, TCSANOW, &raw) != 0) return false;
    bool good = answers_sixel(STDIN_FILENO);
    tcsetattr(STDIN_FILENO, TCSANOW, &old);
    return good;
}

terminal_kind terminal_find(void)
{
    static const char *const NAMES[] = {"kitty", "sixel", "blocks", "blocks256"};
    const char *wanted = getenv("DAFT_TERM");
    for (size_t i = 0; wanted && i < COUNT_OF(NAMES); i++)
        if (strcmp(wanted, NAMES[i]) == 0) return (terminal_kind)i;
    bool kitty = getenv("KITTY_WINDOW_ID") || variable_has("TERM", "kitty") || variable_has("TERM", "ghostty") ||
                 variable_has("TERM_PROGRAM", "WezTerm");
    if (kitty) return TERMINAL_KITTY;
    if (draws_sixels()) return TERMINAL_SIXEL;
    bool true_colour = variable_has("COLORTERM", "truecolor") || variable_has("COLORTERM", "24bit");
    return true_colour ? TERMINAL_BLOCKS : TERMINAL_BLOCKS_256;
}

/* ---- its size ---- */

static int number_of(const char *name, int otherwise)
{
    const char *text = getenv(name);
    long value = text ? strtol(text, NULL, 10) : 0;
    return value > 0 && value < 10000 ? (int)value : otherwise;
}

cli_size terminal_size(terminal_kind kind)
{
    struct winsize window = {0};
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) != 0) window = (struct winsize){0};
    int columns = window.ws_col > 0 ? window.ws_col : number_of("COLUMNS", COLUMNS);
    int lines = (window.ws_row > 0 ? window.ws_row : number_of("LINES", LINES)) - 1; /* one for the prompt */
    int cell_w = window.ws_xpixel >= columns ? window.ws_xpixel / columns : CELL_W;
    int cell_h = window.ws_ypixel > lines ? window.ws_ypixel / (lines + 1) : CELL_H;
    bool text = kind == TERMINAL_BLOCKS || kind == TERMINAL_BLOCKS_256;
    if (text) cell_w = 1, cell_h = 2;
    int width = columns * cell_w, height = (lines > 1 ? lines : 1) * cell_h;
    if (width * 9 > height * 16)
        width = height * 16 / 9;
    else
        height = width * 9 / 16;
    if (text) height &= ~1;
    return (cli_size){width < 16 ? 16 : width, height < 10 ? 10 : height};
}

/* ---- kitty: https://sw.kovidgoyal.net/kitty/graphics-protocol/ ---- */

static void put_base64(const uint8_t *bytes, size_t size)
{
    static const char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t three = (uint32_t)bytes[i] << 16;
        if (i + 1 < size) three |= (uint32_t)bytes[i + 1] << 8;
        if (i + 2 < size) three |= bytes[i + 2];
        putchar(DIGITS[three >> 18]), putchar(DIGITS[three >> 12 & 63]);
        putchar(i + 1 < size ? DIGITS[three >> 6 & 63] : '='), putchar(i + 2 < size ? DIGITS[three & 63] : '=');
    }
}

static void show_kitty(const uint8_t *pixels, int width, int height)
{
    enum { CHUNK = 3072 }; /* 4096 characters, the most a message may have */
    size_t size = 4 * (size_t)width * (size_t)height;
    for (size_t at = 0; at < size; at += CHUNK) {
        size_t part = size - at < CHUNK ? size - at : CHUNK;
        if (at == 0)
            printf("\033_Ga=T,f=32,s=%d,v=%d,m=%d;", width, height, at + part < size);
        else
            printf("\033_Gm=%d;", at + part < size);
        put_base64(pixels + at, part);
        fputs("\033\\", stdout);
    }
    putchar('\n');
}

/* ---- sixels: six rows at a time, for each colour the columns it is in ---- */

enum { LEVELS = 6, PALETTE = LEVELS * LEVELS * LEVELS };

/* The colour of the palette, with the ordered dither of Bayer (1973), so that few colours make smooth slopes. */
static int nearest_colour(const uint8_t *pixel, int x, int y)
{
    static const uint8_t BAYER[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    int colour = 0;
    for (int k = 0; k < 3; k++) {
        int level = (pixel[k] * (LEVELS - 1) * 16 + 255 * BAYER[y % 4][x % 4]) / (255 * 16);
        colour = colour * LEVELS + (level < LEVELS ? level : LEVELS - 1);
    }
    return colour;
}

static void put_run(int bits, int count)
{
    if (count > 3)
        printf("!%d%c", count, 63 + bits);
    else
        for (int i = 0; i < count; i++) putchar(63 + bits);
}

static void put_band(const uint8_t *colours, int width, int rows)
{
    bool used[PALETTE] = {false};
    for (int i = 0; i < width * rows; i++) used[colours[i]] = true;
    for (int colour = 0; colour < PALETTE; colour++) {
        if (!used[colour]) continue;
        printf("#%d", colour);
        int last = 0, count = 0;
        for (int x = 0; x < width; x++) {
            int bits = 0;
            for (int y = 0; y < rows; y++) bits |= (colours[y * width + x] == colour) << y;
            if (bits != last) put_run(last, count), last = bits, count = 0;
            count++;
        }
        if (last) put_run(last, count);
        putchar('$');
    }
    putchar('-');
}

static void show_sixels(const uint8_t *pixels, int width, int height)
{
    uint8_t *colours = malloc(6 * (size_t)width);
    if (!colours) return;
    printf("\033Pq\"1;1;%d;%d", width, height);
    for (int i = 0; i < PALETTE; i++)
        printf("#%d;2;%d;%d;%d", i, i / 36 * 100 / 5, i / 6 % 6 * 100 / 5, i % 6 * 100 / 5); /* percent */
    for (int top = 0; top < height; top += 6) {
        int rows = height - top < 6 ? height - top : 6;
        for (int i = 0; i < rows * width; i++)
            colours[i] = (uint8_t)nearest_colour(pixels + 4 * ((size_t)top * (size_t)width + (size_t)i), i % width,
                                                 top + i / width);
        put_band(colours, width, rows);
    }
    fputs("\033\\\n", stdout);
    free(colours);
}

/* ---- half blocks: two pixels a character, the upper one its foreground ---- */

static void put_colour(bool true_colour, int ground, const uint8_t *p)
{
    if (true_colour)
        printf("\033[%d;2;%d;%d;%dm", ground, p[0], p[1], p[2]);
    else
        printf("\033[%d;5;%dm", ground, 16 + 36 * ((p[0] + 25) / 51) + 6 * ((p[1] + 25) / 51) + (p[2] + 25) / 51);
}

static void show_blocks(bool true_colour, const uint8_t *pixels, int width, int height)
{
    for (int y = 0; y < height; y += 2) {
        const uint8_t *upper = pixels + 4 * (size_t)y * (size_t)width;
        const uint8_t *lower = y + 1 < height ? upper + 4 * (size_t)width : upper;
        for (int x = 0; x < width; x++) {
            bool same = x > 0 && memcmp(upper + 4 * x, upper + 4 * x - 4, 3) == 0 &&
                        memcmp(lower + 4 * x, lower + 4 * x - 4, 3) == 0;
            if (!same) put_colour(true_colour, 38, upper + 4 * x), put_colour(true_colour, 48, lower + 4 * x);
            fputs("\xe2\x96\x80", stdout); /* U+2580, upper half block */
        }
        fputs("\033[0m\n", stdout);
    }
}

void terminal_show(terminal_kind kind, const uint8_t *pixels, int width, int height)
{
    if (kind == TERMINAL_KITTY) show_kitty(pixels, width, height);
    if (kind == TERMINAL_SIXEL) show_sixels(pixels, width, height);
    if (kind == TERMINAL_BLOCKS || kind == TERMINAL_BLOCKS_256)
        show_blocks(kind == TERMINAL_BLOCKS, pixels, width, height);
}
