/* hud: drawing over a finished picture: rectangles and text, and the program's own screens.
 * Public headers: canvas.h screens.h truetype.h
 * Coordinates are in HUD units: every picture is 720 units high, so that a HUD keeps its proportions. Colours are sRGB
 * with alpha and blend in sRGB.
 * Promises: no write outside the picture for any coordinates, NaN included. The same calls give the same bytes
 * everywhere. */
#ifndef RUNTIME_HUD_CANVAS_H
#define RUNTIME_HUD_CANVAS_H

#include "daft.h"

enum { CANVAS_HEIGHT = 720 };

typedef struct canvas {
    uint8_t *pixels; /* RGBA, top row first */
    int width, height;
    float unit; /* pixels a HUD unit */
    /* Whether to leave out what is still to be drawn; asked now and then. NULL: never. */
    bool (*stops)(void *user);
    void *user;
} canvas;

typedef struct canvas_color {
    uint8_t r, g, b, a;
} canvas_color;

canvas canvas_over(daft_image *image);
bool canvas_stops(const canvas *target);
float canvas_hud_width(const canvas *target);
void canvas_rect(const canvas *target, float x, float y, float width, float height, canvas_color color);

/* ---- text (text.c) ---- */

typedef struct font font;

/* A TrueType file, read from `files` (NULL: from anywhere) and called `name` in messages. `engine` counts what it
 * holds, the file and CACHE_BYTES of glyphs, towards its limit; it may be NULL. The file is checked before it is used.
 */
font *font_open(daft_engine *engine, const daft_files *files, const char *path, const char *name, daft_error *error);
void font_close(font *face); /* NULL is fine */

typedef enum text_align { TEXT_LEFT, TEXT_CENTER, TEXT_RIGHT } text_align;

typedef struct text_style {
    float size; /* ascent to descent, HUD units */
    canvas_color color;
    text_align align;
    bool shadow;
} text_style;

/* Draws UTF-8; invalid bytes show as the replacement character. x is the left end, centre or right end of each line by
 * style->align, y the top of the first. */
void text_draw(const canvas *target, font *face, const char *text, float x, float y, const text_style *style);
/* The width of the widest line, in HUD units. */
float text_width(const font *face, const char *text, float size);
float text_line_height(float size);
/* Breaks lines at blanks so that none exceeds `width`. Returns the height; draws when target is not NULL. */
float text_draw_wrapped(const canvas *target, font *face, const char *text, float x, float y, float width,
                        const text_style *style);

#endif
