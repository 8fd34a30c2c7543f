/* TrueType files: characters to glyphs, their widths, kerning and outlines. Every read is bounded by the file, so any
 * bytes are safe: what lies outside reads as zero, and an outline that is not whole is an error when the file is
 * opened. Outlines are 'glyf' ones, simple and composite; pairs are kerned by the table 'kern'. */
#ifndef RUNTIME_HUD_TRUETYPE_H
#define RUNTIME_HUD_TRUETYPE_H

#include "daft.h"

typedef struct truetype_table {
    const uint8_t *at;
    size_t size;
} truetype_table;

typedef struct truetype {
    truetype_table file, cmap, glyf, loca, hmtx, pairs; /* cmap: the subtable that is used; pairs: 6 bytes each */
    uint32_t cmap_format, glyphs, widths;
    bool long_loca;
    int units, ascent, descent; /* units: to the em; descent is below zero */
} truetype;

typedef enum truetype_step { TRUETYPE_MOVE, TRUETYPE_LINE, TRUETYPE_CURVE } truetype_step;

/* Font units, y up. A curve is quadratic. */
typedef struct truetype_point {
    truetype_step step;
    float x, y, control_x, control_y;
} truetype_point;

enum { TRUETYPE_POINTS = 8192, TRUETYPE_PARTS = 64, TRUETYPE_DEPTH = 6 };

/* A point as the file has it: on the outline, or a curve's control point. */
typedef struct truetype_raw {
    float x, y;
    bool on;
} truetype_raw;

/* A glyph's outline. */
typedef struct truetype_outline {
    truetype_point points[TRUETYPE_POINTS];
    size_t count;
    int parts; /* glyphs that were read for it */
    /* Scratch of reading: too large for a stack that cannot grow once memory is short. */
    truetype_raw raw[TRUETYPE_POINTS];
    uint8_t flags[TRUETYPE_POINTS];
    int16_t raw_x[TRUETYPE_POINTS], raw_y[TRUETYPE_POINTS];
} truetype_outline;

/* Checks the file and every glyph in it. `bytes` must outlive `out`; `name` is the file's in messages. */
bool truetype_open(truetype *out, const void *bytes, size_t size, const char *name, daft_error *error);
/* 0, the box for what is missing, where the font has no such character. */
uint32_t truetype_find(const truetype *face, uint32_t code);
/* Font units. */
int truetype_advance(const truetype *face, uint32_t glyph);
int truetype_kerning(const truetype *face, uint32_t left, uint32_t right);
/* False where the file is damaged there. Glyph 0 is never empty. */
bool truetype_read(const truetype *face, uint32_t glyph, truetype_outline *out);
/* The box around the outline's points: left, bottom, right, top. */
void truetype_bounds(const truetype_outline *outline, float box[4]);

/* Draws the outline's coverage, 0 to 255, into a picture whose top left is `x`, `y` pixels right of and below the pen
 * (by stb_truetype). `scale`: pixels a font unit, above zero. */
void truetype_draw(const truetype_outline *outline, float scale, int x, int y, int width, int height,
                   unsigned char *coverage);

#endif
