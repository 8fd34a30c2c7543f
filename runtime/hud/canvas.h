/* hud: drawing over a finished picture: rectangles and text, and the program's own screens.
 * Public headers: canvas.h letters.h screens.h graph.h truetype.h
 * Coordinates are in HUD units: every picture is 720 units high, so that a HUD keeps its proportions. Colours are sRGB
 * with alpha and blend in sRGB.
 * Promises: no write outside the picture for any coordinates, NaN included. The same calls give the same bytes
 * everywhere. */
#ifndef RUNTIME_HUD_CANVAS_H
#define RUNTIME_HUD_CANVAS_H

#include "daft.h"

enum { CANVAS_HEIGHT = 720 };

/* Pixels; right and bottom are outside. */
typedef struct canvas_box {
    int left, top, right, bottom;
} canvas_box;

/* Squares of MARK_UNITS in which something is, over the first 3,200 units across. */
enum { MARK_UNITS = 20, MARK_ROWS = CANVAS_HEIGHT / MARK_UNITS, MARK_COLUMNS = 160 };

typedef struct canvas_marks {
    bool at[MARK_ROWS][MARK_COLUMNS];
} canvas_marks;

typedef struct canvas {
    uint8_t *pixels; /* RGBA, top row first */
    int width, height;
    float unit;               /* pixels a HUD unit */
    float origin_x, origin_y; /* pixels: where 0, 0 is */
    bool clipped;             /* to `clip` */
    canvas_box clip;
    canvas_marks *marks; /* where text has been drawn; or NULL */
    /* Whether to leave out what is still to be drawn; asked now and then. NULL: never. */
    bool (*stops)(void *user);
    void *user;
} canvas;

typedef struct canvas_color {
    uint8_t r, g, b, a;
} canvas_color;

canvas canvas_over(daft_image *image);
bool canvas_stops(const canvas *target);
/* What may be drawn to: the picture, or what canvas_clip has left of it. */
canvas_box canvas_bounds(const canvas *target);
/* From here on nothing is drawn outside. */
void canvas_clip(canvas *target, float x, float y, float width, float height);
void canvas_unclip(canvas *target);
/* From here on coordinates go from 0, 0 to width, height, as large as fits, in the middle; canvas_reset takes it back.
 */
void canvas_fit(canvas *target, float width, float height);
void canvas_reset(canvas *target);
/* Marks the squares that the box covers, in pixels. */
void canvas_mark(const canvas *target, float left, float top, float right, float bottom);
/* How many squares of the box, in HUD units of the whole picture, are marked. */
int canvas_count_marks(const canvas_marks *marks, float x, float y, float width, float height);
float canvas_hud_width(const canvas *target);
void canvas_rect(const canvas *target, float x, float y, float width, float height, canvas_color color);

/* One pixel within the bounds, so far covered, 0 to 1. */
void canvas_blend(const canvas *target, int x, int y, canvas_color color, float covered);

/* ---- shapes (shapes.c): antialiased; more than 16,384 edges draw nothing ---- */

typedef struct canvas_point {
    float x, y;
} canvas_point;

/* What the points enclose; where it overlaps itself the same way round, once. */
void canvas_polygon(const canvas *target, const canvas_point *points, size_t count, canvas_color color);
/* A disc; with a width, a ring of it, its middle at the radius. */
void canvas_circle(const canvas *target, float x, float y, float radius, float width, canvas_color color);
/* Through the points, with round corners. */
void canvas_line(const canvas *target, const canvas_point *points, size_t count, bool closed, float width,
                 canvas_color color);

/* ---- pictures (sprite.c) ---- */

typedef struct canvas_sprite {
    float source_x, source_y, source_width, source_height; /* pixels of the image */
    float width, height;                                   /* HUD units, as drawn */
    float scale;                                           /* units a pixel of the border */
    float rotation;                                        /* radians, clockwise */
    float origin_x, origin_y; /* what is put at x, y and turned about: 0 left or top, 1 right or bottom */
    float border;             /* pixels at each edge that are not stretched */
    canvas_color tint;        /* multiplies */
    bool smooth;              /* else its pixels are squares */
} canvas_sprite;

/* The whole image, a unit for a pixel. */
canvas_sprite canvas_default_sprite(const daft_image *image);
/* The source must lie within the image. */
void canvas_draw_sprite(const canvas *target, const daft_image *image, float x, float y, const canvas_sprite *sprite);

/* ---- text (text.c) ---- */

typedef struct font font;

/* A TrueType file, read from `files` (NULL: from anywhere) and called `name` in messages. `engine` counts what it
 * holds, the file and CACHE_BYTES of glyphs, towards its limit; it may be NULL. The file is checked before it is used.
 */
font *font_open(daft_engine *engine, const daft_files *files, const char *path, const char *name, daft_error *error);
void font_close(font *face); /* NULL is fine */
/* It counts towards no memory limit any more, and may outlive its engine. NULL is fine. */
void font_uncount(font *face);

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
