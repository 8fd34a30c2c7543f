/* Reads TrueType files after the OpenType specification 1.9: cmap formats 0, 4, 6 and 12, glyf, head, hhea, hmtx, kern,
 * loca, maxp. Only the rasterizer is stb_truetype's: its parser trusts the file. */
#include "hud/truetype.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Its assertions are of rounding at the edges of a picture; it writes nothing outside all the same. */
#define STBTT_assert(condition) ((void)0)
#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#include <stb_truetype.h>

/* Points of all glyphs together: a font of 65,535 characters has half as many. */
static const uint64_t MOST_POINTS = 16000000;

/* ---- bounded reads, big-endian ---- */

static bool has(truetype_table t, size_t at, size_t size) { return at <= t.size && size <= t.size - at; }
static uint32_t u8(truetype_table t, size_t at) { return has(t, at, 1) ? t.at[at] : 0; }
static uint32_t u16(truetype_table t, size_t at) { return has(t, at, 2) ? (uint32_t)t.at[at] << 8 | t.at[at + 1] : 0; }
static int i16(truetype_table t, size_t at) { return (int16_t)u16(t, at); }
static uint32_t u32(truetype_table t, size_t at) { return u16(t, at) << 16 | u16(t, at + 2); }

/* What lies outside is cut off. */
static truetype_table part_of(truetype_table t, size_t at, size_t size)
{
    if (at > t.size) return (truetype_table){t.at, 0};
    return (truetype_table){t.at + at, size < t.size - at ? size : t.size - at};
}

/* ---- characters ---- */

/* The first of the segments, 2 bytes each from `at` on, that ends at `code` or after it. */
static uint32_t find_segment(truetype_table t, size_t at, uint32_t count, uint32_t code)
{
    uint32_t low = 0, high = count;
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        if (u16(t, at + 2 * (size_t)middle) < code)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static uint32_t find_by_segments(truetype_table t, uint32_t code)
{
    const uint32_t count = u16(t, 6) / 2;
    const size_t ends = 14, starts = ends + 2 * (size_t)count + 2, deltas = starts + 2 * (size_t)count;
    const size_t offsets = deltas + 2 * (size_t)count;
    if (code > 0xFFFF) return 0;
    const uint32_t i = find_segment(t, ends, count, code);
    const size_t place = 2 * (size_t)i;
    if (i == count || u16(t, starts + place) > code) return 0;
    const uint32_t delta = u16(t, deltas + place), offset = u16(t, offsets + place);
    if (offset == 0) return (code + delta) & 0xFFFF;
    const uint32_t glyph = u16(t, offsets + place + offset + 2 * (size_t)(code - u16(t, starts + place)));
    return glyph ? (glyph + delta) & 0xFFFF : 0;
}

static uint32_t find_by_groups(truetype_table t, uint32_t code)
{
    uint32_t low = 0, high = u32(t, 12);
    if (high > t.size / 12) high = (uint32_t)(t.size / 12);
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        const size_t group = 16 + 12 * (size_t)middle;
        if (code < u32(t, group))
            high = middle;
        else if (code > u32(t, group + 4))
            low = middle + 1;
        else
            return u32(t, group + 8) + (code - u32(t, group));
    }
    return 0;
}

uint32_t truetype_find(const truetype *face, uint32_t code)
{
    const truetype_table t = face->cmap;
    uint32_t glyph = 0;
    switch (face->cmap_format) {
    case 0: glyph = code < 256 ? u8(t, 6 + code) : 0; break;
    case 4: glyph = find_by_segments(t, code); break;
    case 6: glyph = code >= u16(t, 6) && code - u16(t, 6) < u16(t, 8) ? u16(t, 10 + 2 * (code - u16(t, 6))) : 0; break;
    case 12: glyph = find_by_groups(t, code); break;
    default: break;
    }
    return glyph < face->glyphs ? glyph : 0;
}

/* How much of Unicode a subtable tells, by its platform and encoding; 0: none of it. */
static int worth(uint32_t platform, uint32_t encoding)
{
    if (platform == 3 && encoding == 10) return 4;
    if (platform == 0 && (encoding == 4 || encoding == 6)) return 3;
    if (platform == 3 && encoding == 1) return 2;
    return platform == 0 && encoding < 4;
}

static bool choose_cmap(truetype *face, truetype_table cmap)
{
    int best = 0;
    for (uint32_t i = 0; i < u16(cmap, 2); i++) {
        const size_t record = 4 + 8 * (size_t)i;
        const int value = worth(u16(cmap, record), u16(cmap, record + 2));
        const truetype_table t = part_of(cmap, u32(cmap, record + 4), SIZE_MAX);
        const uint32_t format = u16(t, 0);
        const bool known = t.size > 6 && (format == 0 || format == 4 || format == 6 || format == 12);
        if (!known || value <= best) continue;
        best = value;
        face->cmap = t, face->cmap_format = format;
    }
    return best > 0;
}

/* ---- widths ---- */

int truetype_advance(const truetype *face, uint32_t glyph)
{
    const int width = i16(face->hmtx, 4 * (size_t)(glyph < face->widths ? glyph : face->widths - 1));
    return width > 0 || glyph > 0 ? width : face->units / 2;
}

int truetype_kerning(const truetype *face, uint32_t left, uint32_t right)
{
    const uint32_t wanted = left << 16 | right;
    size_t low = 0, high = face->pairs.size / 6;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        const uint32_t pair = u32(face->pairs, 6 * middle);
        if (pair == wanted) return i16(face->pairs, 6 * middle + 4);
        if (pair < wanted)
            low = middle + 1;
        else
            high = middle;
    }
    return 0;
}

/* The first subtable of horizontal pairs. */
static void choose_pairs(truetype *face, truetype_table kern)
{
    const bool good = u16(kern, 0) == 0 && u16(kern, 2) > 0 && (u16(kern, 8) & 0xFF07) == 1;
    if (good) face->pairs = part_of(kern, 18, 6 * (size_t)u16(kern, 10));
}

/* ---- outlines ---- */

/* From a part's coordinates to the glyph's. */
typedef struct placing {
    float xx, xy, yx, yy, x, y;
} placing;

static bool add_point(truetype_outline *out, truetype_point point)
{
    if (out->count == TRUETYPE_POINTS) return false;
    out->points[out->count++] = point;
    return true;
}

static truetype_raw between(truetype_raw a, truetype_raw b)
{
    return (truetype_raw){(a.x + b.x) / 2, (a.y + b.y) / 2, true};
}

/* Two points off the curve that follow each other have one on it between them. */
static bool add_contour(truetype_outline *out, const truetype_raw *points, size_t count)
{
    truetype_raw first = points[0];
    if (!first.on) first = points[count - 1].on ? points[count - 1] : between(points[count - 1], first);
    if (!add_point(out, (truetype_point){TRUETYPE_MOVE, first.x, first.y, 0, 0})) return false;
    for (size_t i = points[0].on ? 1 : 0; i < count; i++) {
        const truetype_raw p = points[i], next = i + 1 < count ? points[i + 1] : first;
        const truetype_raw end = next.on ? next : between(p, next);
        const truetype_point line = {TRUETYPE_LINE, p.x, p.y, 0, 0}, curve = {TRUETYPE_CURVE, end.x, end.y, p.x, p.y};
        if (!add_point(out, p.on ? line : curve)) return false;
        if (!p.on && next.on) i++; /* the curve has reached it */
    }
    return add_point(out, (truetype_point){TRUETYPE_LINE, first.x, first.y, 0, 0});
}

/* One coordinate of every point; -1: the glyph ends before. */
static long read_coordinates(truetype_table t, size_t at, const uint8_t *flags, size_t count, int short_bit,
                             int same_bit, int16_t *out)
{
    int value = 0;
    for (size_t i = 0; i < count; i++) {
        const bool is_short = flags[i] & short_bit, same = flags[i] & same_bit;
        const size_t size = is_short ? 1 : same ? 0 : 2;
        if (!has(t, at, size)) return -1;
        if (is_short)
            value += same ? (int)u8(t, at) : -(int)u8(t, at);
        else if (!same)
            value += i16(t, at);
        out[i] = (int16_t)value;
        at += size;
    }
    return (long)at;
}

/* A byte for each point; -1: the glyph ends before. */
static long read_flags(truetype_table t, size_t at, size_t count, uint8_t *out)
{
    for (size_t i = 0; i < count;) {
        if (!has(t, at, 1)) return -1;
        const uint8_t flags = (uint8_t)u8(t, at++);
        size_t times = 1;
        if (flags & 8) {
            if (!has(t, at, 1)) return -1;
            times += u8(t, at++);
        }
        for (; times > 0 && i < count; times--) out[i++] = flags;
    }
    return (long)at;
}

static bool read_simple(truetype_table t, int contours, const placing *to, truetype_outline *out)
{
    truetype_raw *points = out->raw;
    uint8_t *flags = out->flags;
    int16_t *x = out->raw_x, *y = out->raw_y;
    const size_t ends = 10, after = ends + 2 * (size_t)contours;
    if (!has(t, after, 2)) return false;
    const size_t count = u16(t, after - 2) + (size_t)1;
    if (count > TRUETYPE_POINTS) return false;
    long at = (long)(after + 2 + u16(t, after));
    if ((at = read_flags(t, (size_t)at, count, flags)) < 0) return false;
    if ((at = read_coordinates(t, (size_t)at, flags, count, 2, 16, x)) < 0) return false;
    if (read_coordinates(t, (size_t)at, flags, count, 4, 32, y) < 0) return false;
    for (size_t i = 0; i < count; i++)
        points[i] =
            (truetype_raw){to->xx * x[i] + to->yx * y[i] + to->x, to->xy * x[i] + to->yy * y[i] + to->y, flags[i] & 1};
    size_t first = 0;
    for (int i = 0; i < contours; i++) {
        const size_t next = u16(t, ends + 2 * (size_t)i) + (size_t)1;
        if (next < first || next > count) return false;
        if (next > first && !add_contour(out, points + first, next - first)) return false;
        first = next;
    }
    return true;
}

static float fixed(truetype_table t, size_t at) { return (float)i16(t, at) / 16384; }

static placing within(const placing *outer, const placing *inner)
{
    return (placing){
        outer->xx * inner->xx + outer->yx * inner->xy,          outer->xy * inner->xx + outer->yy * inner->xy,
        outer->xx * inner->yx + outer->yx * inner->yy,          outer->xy * inner->yx + outer->yy * inner->yy,
        outer->xx * inner->x + outer->yx * inner->y + outer->x, outer->xy * inner->x + outer->yy * inner->y + outer->y};
}

/* Reads where a part stands; returns the bytes it takes. */
static size_t read_placing(truetype_table t, size_t at, uint32_t flags, placing *out)
{
    size_t size = 4;
    *out = (placing){1, 0, 0, 1, 0, 0};
    const bool words = flags & 1, offsets = flags & 2; /* otherwise points that are to meet: they stay where they are */
    if (offsets)
        out->x = words ? (float)i16(t, at + 4) : (float)(int8_t)u8(t, at + 4),
        out->y = words ? (float)i16(t, at + 6) : (float)(int8_t)u8(t, at + 5);
    size += words ? 4 : 2;
    if (flags & 0x8) {
        out->xx = out->yy = fixed(t, at + size), size += 2;
    } else if (flags & 0x40) {
        out->xx = fixed(t, at + size), out->yy = fixed(t, at + size + 2), size += 4;
    } else if (flags & 0x80) {
        out->xx = fixed(t, at + size), out->xy = fixed(t, at + size + 2);
        out->yx = fixed(t, at + size + 4), out->yy = fixed(t, at + size + 6), size += 8;
    }
    return size;
}

static bool read_glyph(const truetype *face, uint32_t glyph, const placing *to, int depth, truetype_outline *out);

static bool read_composite(const truetype *face, truetype_table t, const placing *to, int depth, truetype_outline *out)
{
    enum { MORE = 0x20 };
    uint32_t flags = MORE;
    for (size_t at = 10; flags & MORE;) {
        if (!has(t, at, 6)) return false;
        flags = u16(t, at);
        placing part;
        const uint32_t glyph = u16(t, at + 2);
        const size_t size = read_placing(t, at, flags, &part);
        if (!has(t, at, size)) return false;
        part = within(to, &part);
        if (!read_glyph(face, glyph, &part, depth + 1, out)) return false;
        at += size;
    }
    return true;
}

static truetype_table glyph_bytes(const truetype *face, uint32_t glyph, bool *good)
{
    const size_t unit = face->long_loca ? 4 : 2, place = unit * (size_t)glyph;
    const uint32_t begin = face->long_loca ? u32(face->loca, place) : 2 * u16(face->loca, place);
    const uint32_t end = face->long_loca ? u32(face->loca, place + 4) : 2 * u16(face->loca, place + 2);
    *good = begin <= end && has(face->glyf, begin, end - begin);
    return *good ? part_of(face->glyf, begin, end - begin) : face->glyf;
}

static bool read_glyph(const truetype *face, uint32_t glyph, const placing *to, int depth, truetype_outline *out)
{
    bool good;
    if (glyph >= face->glyphs || depth > TRUETYPE_DEPTH || ++out->parts > TRUETYPE_PARTS) return false;
    const truetype_table t = glyph_bytes(face, glyph, &good);
    if (!good || t.size == 0) return good;
    if (t.size < 10) return false;
    const int contours = i16(t, 0);
    if (contours == 0) return true;
    return contours > 0 ? read_simple(t, contours, to, out) : read_composite(face, t, to, depth, out);
}

/* For fonts without a glyph for what is missing. */
static void add_box(const truetype *face, truetype_outline *out)
{
    const float u = (float)face->units;
    for (int inner = 0; inner < 2; inner++) {
        const float inset = inner ? u * 0.06f : 0, left = u * 0.06f + inset, right = u * 0.44f - inset;
        const float low = inset, high = u * 0.7f - inset;
        /* The inner one runs the other way round. */
        const float xs[] = {left, inner ? right : left, right, inner ? left : right, left};
        const float ys[] = {low, inner ? low : high, high, inner ? high : low, low};
        for (int i = 0; i < 5; i++) add_point(out, (truetype_point){i ? TRUETYPE_LINE : 0, xs[i], ys[i], 0, 0});
    }
}

bool truetype_read(const truetype *face, uint32_t glyph, truetype_outline *out)
{
    const placing here = {1, 0, 0, 1, 0, 0};
    out->count = 0, out->parts = 0;
    if (!read_glyph(face, glyph, &here, 0, out)) return false;
    if (glyph == 0 && out->count == 0) add_box(face, out);
    return true;
}

void truetype_bounds(const truetype_outline *outline, float box[4])
{
    for (int i = 0; i < 4; i++) box[i] = 0;
    for (size_t i = 0; i < outline->count; i++) {
        const truetype_point *p = &outline->points[i];
        const bool curve = p->step == TRUETYPE_CURVE;
        const float x = curve ? p->control_x : p->x, y = curve ? p->control_y : p->y;
        box[0] = i ? fminf(box[0], fminf(p->x, x)) : fminf(p->x, x);
        box[1] = i ? fminf(box[1], fminf(p->y, y)) : fminf(p->y, y);
        box[2] = i ? fmaxf(box[2], fmaxf(p->x, x)) : fmaxf(p->x, x);
        box[3] = i ? fmaxf(box[3], fmaxf(p->y, y)) : fmaxf(p->y, y);
    }
}

/* ---- drawing ---- */

/* stb_truetype's points are 16 bits wide. */
static short narrow(float value) { return (short)(value > -32768 ? value < 32767 ? value : 32767 : -32768); }

void truetype_draw(const truetype_outline *outline, float scale, int x, int y, int width, int height,
                   unsigned char *coverage)
{
    static const unsigned char TYPES[] = {STBTT_vmove, STBTT_vline, STBTT_vcurve};
    stbtt_vertex *vertices = calloc(outline->count + 1, sizeof *vertices);
    if (!vertices) return;
    for (size_t i = 0; i < outline->count; i++) {
        const truetype_point *p = &outline->points[i];
        vertices[i] = (stbtt_vertex){.x = narrow(p->x),
                                     .y = narrow(p->y),
                                     .cx = narrow(p->control_x),
                                     .cy = narrow(p->control_y),
                                     .type = TYPES[p->step]};
    }
    stbtt__bitmap picture = {width, height, width, coverage};
    stbtt_Rasterize(&picture, 0.35f, vertices, (int)outline->count, scale, scale, 0, 0, x, y, 1, NULL);
    free(vertices);
}

/* ---- opening ---- */

static truetype_table find_table(truetype_table file, size_t font, const char *tag)
{
    for (uint32_t i = 0; i < u16(file, font + 4); i++) {
        const size_t record = font + 12 + 16 * (size_t)i;
        if (!has(file, record, 16) || memcmp(file.at + record, tag, 4) != 0) continue;
        const uint32_t at = u32(file, record + 8), size = u32(file, record + 12);
        return has(file, at, size) ? part_of(file, at, size) : (truetype_table){file.at, 0};
    }
    return (truetype_table){file.at, 0};
}

/* Where the font begins in the file, the first of a collection; SIZE_MAX: it is none. */
static size_t find_font(truetype_table file)
{
    const bool collection = has(file, 0, 16) && memcmp(file.at, "ttcf", 4) == 0;
    const size_t at = collection ? u32(file, 12) : 0;
    if (!has(file, at, 12)) return SIZE_MAX;
    const uint32_t version = u32(file, at);
    return version == 0x00010000 || version == 0x74727565 || version == 0x4F54544F ? at : SIZE_MAX;
}

static bool check_glyphs(const truetype *face, const char *name, daft_error *error)
{
    truetype_outline *outline = malloc(sizeof *outline);
    if (!outline) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a font");
    uint64_t points = 0;
    uint32_t glyph = 0;
    for (; glyph < face->glyphs && points < MOST_POINTS; glyph++) {
        if (!truetype_read(face, glyph, outline)) break;
        points += outline->count + (uint64_t)outline->parts;
    }
    free(outline);
    if (points >= MOST_POINTS) return fail_at(error, name, 0, 0, "the font's outlines have too many points");
    return glyph == face->glyphs || fail_at(error, name, 0, 0, "damaged: the outline of glyph %u is not whole", glyph);
}

bool truetype_open(truetype *out, const void *bytes, size_t size, const char *name, daft_error *error)
{
    const truetype_table file = {bytes, size};
    *out = (truetype){.file = file, .pairs = {bytes, 0}};
    const size_t font = find_font(file);
    if (font == SIZE_MAX) return fail_at(error, name, 0, 0, "not a TrueType font");
    const truetype_table head = find_table(file, font, "head"), hhea = find_table(file, font, "hhea"),
                         maxp = find_table(file, font, "maxp"), cmap = find_table(file, font, "cmap");
    out->glyf = find_table(file, font, "glyf"), out->loca = find_table(file, font, "loca");
    out->hmtx = find_table(file, font, "hmtx");
    if (out->glyf.size == 0 && find_table(file, font, "CFF ").size > 0)
        return fail_at(error, name, 0, 0, "a font with PostScript outlines: TrueType ones expected");
    out->units = (int)u16(head, 18), out->long_loca = u16(head, 50) != 0;
    out->ascent = i16(hhea, 4), out->descent = i16(hhea, 6);
    out->glyphs = u16(maxp, 4), out->widths = u16(hhea, 34);
    const size_t places = (out->long_loca ? 4 : 2) * ((size_t)out->glyphs + 1);
    const bool whole = head.size >= 54 && hhea.size >= 36 && out->glyphs > 0 && out->loca.size >= places &&
                       out->widths > 0 && out->hmtx.size >= 4 * (size_t)out->widths;
    if (!whole) return fail_at(error, name, 0, 0, "damaged: a table that a TrueType font needs is missing or cut off");
    const int height = out->ascent - out->descent;
    if (out->units < 16 || out->units > 16384 || height < out->units / 4 || height > 8 * out->units)
        return fail_at(error, name, 0, 0, "damaged: %d units to the em, lines of %d", out->units, height);
    if (!choose_cmap(out, cmap)) return fail_at(error, name, 0, 0, "the font has no table of Unicode characters");
    choose_pairs(out, find_table(file, font, "kern"));
    return check_glyphs(out, name, error);
}
