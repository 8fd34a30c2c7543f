/* Text from a TrueType font. Each glyph is rasterized once for each pixel size and cached in a hash table with linear
 * probing, which is emptied at three quarters full, or when its pictures take CACHE_BYTES. */
#include "hud/canvas.h"

#include "common/util.h"
#include "hud/letters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CACHE_SIZE = 2048, CACHE_BYTES = 4 << 20, LARGEST_PIXELS = 512, LARGEST_GLYPH = 1 << 20 };

typedef struct glyph {
    uint32_t key; /* code point · 1024 + pixel size; 0: empty */
    int x, y;     /* of the bitmap's top left, from the pen on the base line */
    int width, height;
    unsigned char *coverage; /* NULL for blanks */
} glyph;

struct font {
    truetype file;
    void *bytes;
    daft_engine *engine; /* whose memory limit counts it; or NULL */
    uint64_t reserved;   /* there, bytes */
    glyph cache[CACHE_SIZE];
    size_t cached, cached_bytes;
    truetype_outline outline; /* of the glyph at work */
};

static font *failed(font *face)
{
    font_close(face);
    return NULL;
}

font *font_open(daft_engine *engine, const daft_files *files, const char *path, const char *name, daft_error *error)
{
    font *face = calloc(1, sizeof *face);
    if (!face) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a font");
        return NULL;
    }
    size_t size = 0;
    face->bytes = daft_read_file(files, path, &size, error);
    if (!face->bytes) return failed(face);
    const uint64_t needed = sizeof *face + size + CACHE_BYTES;
    if (engine && !daft_engine_reserve(engine, needed)) {
        fail_at(error, name, 0, 0, "the font takes more memory than is left");
        return failed(face);
    }
    if (engine) face->engine = engine, face->reserved = needed;
    return truetype_open(&face->file, face->bytes, size, name, error) ? face : failed(face);
}

static void forget_glyphs(font *face)
{
    for (size_t i = 0; i < CACHE_SIZE; i++) free(face->cache[i].coverage);
    memset(face->cache, 0, sizeof face->cache);
    face->cached = face->cached_bytes = 0;
}

void font_uncount(font *face)
{
    if (face && face->engine) daft_engine_unreserve(face->engine, face->reserved);
    if (face) face->engine = NULL;
}

void font_close(font *face)
{
    if (!face) return;
    forget_glyphs(face);
    font_uncount(face);
    free(face->bytes);
    free(face);
}

static float units_scale(const font *face, float size) { return size / (float)font_height(face); }

/* Glyphs that are far too large stay blank. */
static void rasterize(font *face, uint32_t code, int pixels, glyph *out)
{
    float box[4];
    const float scale = units_scale(face, (float)pixels);
    if (!font_outline(face, code)) return;
    truetype_bounds(&face->outline, box);
    for (int i = 0; i < 4; i++)
        if (fabsf(box[i] * scale) > LARGEST_GLYPH) return;
    out->x = (int)floorf(box[0] * scale), out->y = (int)floorf(-box[3] * scale);
    out->width = (int)ceilf(box[2] * scale) - out->x, out->height = (int)ceilf(-box[1] * scale) - out->y;
    if (out->width <= 0 || out->height <= 0 || out->width > LARGEST_GLYPH / out->height) return;
    const size_t size = (size_t)out->width * (size_t)out->height;
    out->coverage = calloc(size, 1);
    if (!out->coverage) return;
    face->cached_bytes += size;
    truetype_draw(&face->outline, scale, out->x, out->y, out->width, out->height, out->coverage);
}

static size_t first_slot(uint32_t key) { return (key * 2654435761u) >> 21; /* 11 bits: CACHE_SIZE slots */ }

static const glyph *find_glyph(font *face, uint32_t code, int pixels)
{
    uint32_t key = code * 1024 + (uint32_t)pixels;
    size_t slot = first_slot(key);
    for (; face->cache[slot].key; slot = (slot + 1) % CACHE_SIZE)
        if (face->cache[slot].key == key) return &face->cache[slot];
    if (face->cached >= CACHE_SIZE * 3 / 4 || face->cached_bytes > CACHE_BYTES - LARGEST_GLYPH) {
        forget_glyphs(face);
        slot = first_slot(key);
    }
    glyph *found = &face->cache[slot];
    found->key = key;
    face->cached++;
    rasterize(face, code, pixels, found);
    return found;
}

int font_advance(const font *face, uint32_t code, uint32_t next)
{
    const uint32_t left = truetype_find(&face->file, code);
    const int width = truetype_advance(&face->file, left);
    if (!next || next == '\n') return width;
    return width + truetype_kerning(&face->file, left, truetype_find(&face->file, next));
}

/* The advance of the line from `text` to `end` or a newline, in font units. */
static int line_advance(const font *face, const char *text, const char *end)
{
    int width = 0;
    uint32_t code = utf8_next(&text);
    while (code && code != '\n' && text <= end) {
        uint32_t next = utf8_next(&text);
        width += font_advance(face, code, next);
        code = next;
    }
    return width;
}

int font_line_advance(const font *face, const char *line)
{
    const char *end = strchr(line, '\n');
    return line_advance(face, line, end ? end : line + strlen(line));
}

int font_height(const font *face) { return face->file.ascent - face->file.descent; }

const truetype_outline *font_outline(font *face, uint32_t code)
{
    return truetype_read(&face->file, truetype_find(&face->file, code), &face->outline) ? &face->outline : NULL;
}

float text_line_height(float size) { return size * 1.2f; }

float text_width(const font *face, const char *text, float size)
{
    int widest = 0;
    for (const char *line = text; line;) {
        const char *end = strchr(line, '\n');
        const int width = font_line_advance(face, line);
        if (width > widest) widest = width;
        line = end ? end + 1 : NULL;
    }
    return (float)widest * units_scale(face, size);
}

static void draw_glyph(const canvas *target, const glyph *letter, int x, int y, canvas_color color)
{
    const canvas_box clip = canvas_bounds(target);
    if (!letter->coverage) return;
    x += letter->x, y += letter->y;
    const int left = x < clip.left ? clip.left - x : 0, top = y < clip.top ? clip.top - y : 0;
    const int right = clip.right - x < letter->width ? clip.right - x : letter->width;
    const int bottom = clip.bottom - y < letter->height ? clip.bottom - y : letter->height;
    if (left < right && top < bottom)
        canvas_mark(target, (float)(x + left), (float)(y + top), (float)(x + right), (float)(y + bottom));
    for (int row = top; row < bottom; row++) {
        const unsigned char *coverage = letter->coverage + (size_t)row * (size_t)letter->width;
        uint8_t *pixel = target->pixels + 4 * ((size_t)(y + row) * (size_t)target->width + (size_t)(x + left));
        for (int column = left; column < right; column++, pixel += 4) {
            uint32_t alpha = (coverage[column] * color.a + 127u) / 255;
            if (alpha == 0) continue;
            pixel[0] = (uint8_t)((pixel[0] * (255 - alpha) + color.r * alpha + 127) / 255);
            pixel[1] = (uint8_t)((pixel[1] * (255 - alpha) + color.g * alpha + 127) / 255);
            pixel[2] = (uint8_t)((pixel[2] * (255 - alpha) + color.b * alpha + 127) / 255);
        }
    }
}

static void draw_line(const canvas *target, font *face, const char *text, const char *end, float x, float y,
                      const text_style *style)
{
    int pixels = (int)(style->size * target->unit + 0.5f);
    pixels = pixels < 1 ? 1 : pixels > LARGEST_PIXELS ? LARGEST_PIXELS : pixels;
    float scale = units_scale(face, style->size) * target->unit;
    float pen = target->origin_x + x * target->unit,
          base = target->origin_y + y * target->unit + (float)face->file.ascent * scale;
    int line = line_advance(face, text, end);
    if (style->align != TEXT_LEFT) pen -= (float)line * scale * (style->align == TEXT_CENTER ? 0.5f : 1.0f);
    /* Reject far coordinates and NaN before converting to int. */
    if (!(fabsf(pen) < 1e6f) || !(fabsf(base) < 1e6f)) return;
    int shadow = pixels / 16 > 1 ? pixels / 16 : 1;
    canvas_color dark = {0, 0, 0, (uint8_t)(style->color.a * 5 / 8)};
    for (int pass = style->shadow ? 0 : 1; pass < 2; pass++) {
        const char *at = text;
        int walked = 0;
        uint32_t code = utf8_next(&at);
        while (code && code != '\n' && at <= end && !canvas_stops(target)) {
            uint32_t next = utf8_next(&at);
            int offset = pass == 0 ? shadow : 0;
            draw_glyph(target, find_glyph(face, code, pixels), (int)floorf(pen + (float)walked * scale + 0.5f) + offset,
                       (int)floorf(base + 0.5f) + offset, pass == 0 ? dark : style->color);
            walked += font_advance(face, code, next);
            code = next;
        }
    }
}

void text_draw(const canvas *target, font *face, const char *text, float x, float y, const text_style *style)
{
    if (!(style->size > 0) || !isfinite(style->size)) return;
    for (const char *line = text; line; y += text_line_height(style->size)) {
        const char *end = strchr(line, '\n');
        draw_line(target, face, line, end ? end : line + strlen(line), x, y, style);
        line = end ? end + 1 : NULL;
    }
}

/* The end of the longest prefix of `text` that fits, at a blank if possible; at least one character. */
static const char *break_line(const font *face, const char *text, float width, float scale)
{
    const char *at = text, *here = text, *blank = NULL;
    bool after_word = false;
    int walked = 0;
    uint32_t code = utf8_next(&at);
    for (; code && code != '\n'; here = at, code = utf8_next(&at)) {
        const char *ahead = at;
        walked += font_advance(face, code, utf8_next(&ahead));
        if (code == ' ' && after_word) blank = here;
        after_word = code != ' ';
        if (after_word && here > text && (float)walked * scale > width) return blank ? blank : here;
    }
    return here;
}

float text_draw_wrapped(const canvas *target, font *face, const char *text, float x, float y, float width,
                        const text_style *style)
{
    float scale = units_scale(face, style->size), top = y;
    while (*text && !(target && canvas_stops(target))) {
        const char *end = break_line(face, text, width, scale);
        if (target) draw_line(target, face, text, end, x, y, style);
        y += text_line_height(style->size);
        text = end + strspn(end, " ");
        if (*text == '\n') text++;
    }
    return y - top;
}
