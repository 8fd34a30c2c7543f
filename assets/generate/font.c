/* Writes assets/fonts/daft.ttf: a TrueType file with the outlines of glyphs.c. Layout after the OpenType specification
 * 1.9: tables cmap (format 4), glyf, head, hhea, hmtx, loca (long), maxp, name, OS/2, post (3: no names). */
#include "generate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double PEN = 44;  /* half the stroke width, of 1000 to the em */
static const double SCALE = 2; /* font units in a skeleton's unit: 2000 to the em */
static const int ASCENDER = 1800, DESCENDER = -500;
static const double DIGIT_ADVANCE = 590; /* all digits alike, so that clocks and scores do not shake */

enum { MAX_FILE = 1 << 19, MAX_GLYPHS = 512, TABLES = 10 };

/* A growing table; big-endian. */
typedef struct table {
    uint8_t bytes[MAX_FILE];
    size_t size;
} table;

static void put8(table *t, int v)
{
    if (t->size < MAX_FILE) t->bytes[t->size++] = (uint8_t)v;
}
static void put16(table *t, int v) { put8(t, v >> 8 & 255), put8(t, v & 255); }
static void put32(table *t, uint32_t v) { put16(t, (int)(v >> 16)), put16(t, (int)(v & 65535)); }
static void put64(table *t, uint64_t v) { put32(t, (uint32_t)(v >> 32)), put32(t, (uint32_t)v); }
static void put_text(table *t, const char *s)
{
    while (*s) put8(t, *s++);
}

typedef struct metrics {
    int advance, left;
    int x0, y0, x1, y1;
} metrics;

/* A character of the font: a glyph, perhaps of another character, and a mark. */
typedef struct character {
    uint32_t code;
    const glyph *base;
    const glyph_mark *mark;
} character;

typedef struct font {
    character characters[MAX_GLYPHS]; /* codes rise */
    int character_count;
    table tables[TABLES];
    metrics glyphs[MAX_GLYPHS]; /* 0 is .notdef */
    int count, max_points, max_contours;
    metrics box; /* around all glyphs */
} font;

/* In the order of their tags, as the directory wants it. */
enum { OS2, CMAP, GLYF, HEAD, HHEA, HMTX, LOCA, MAXP, NAME, POST };
static const char *const tags[TABLES] = {"OS/2", "cmap", "glyf", "head", "hhea",
                                         "hmtx", "loca", "maxp", "name", "post"};

/* ---- outlines ---- */

static int units(double v) { return (int)floor(v * SCALE + 0.5); }

static void ink_box(const outline *o, double *low_x, double *high_x)
{
    *low_x = 1e9, *high_x = -1e9;
    for (int i = 0; i < o->count; i++) {
        if (o->x[i] < *low_x) *low_x = o->x[i];
        if (o->x[i] > *high_x) *high_x = o->x[i];
    }
    if (o->count == 0) *low_x = *high_x = 0;
}

/* Moves the outline so that its left bearing is right and the pen's lower edge stands on the baseline. */
static metrics place(const glyph *g, outline *o)
{
    double low, high, left = g->left, advance;
    ink_box(o, &low, &high);
    if (g->code >= '0' && g->code <= '9')
        advance = DIGIT_ADVANCE, left = (advance - (high - low)) / 2;
    else
        advance = left + (high - low) + g->right;
    metrics m = {.advance = units(advance), .x0 = 32767, .y0 = 32767, .x1 = -32768, .y1 = -32768};
    for (int i = 0; i < o->count; i++) {
        o->x[i] = units(o->x[i] - low + left), o->y[i] = units(o->y[i] + PEN);
        if (o->x[i] < m.x0) m.x0 = (int)o->x[i];
        if (o->x[i] > m.x1) m.x1 = (int)o->x[i];
        if (o->y[i] < m.y0) m.y0 = (int)o->y[i];
        if (o->y[i] > m.y1) m.y1 = (int)o->y[i];
    }
    if (o->count == 0) m.x0 = m.y0 = m.x1 = m.y1 = 0;
    m.left = m.x0;
    return m;
}

/* One coordinate of every point as differences: a byte where it fits, two where not, none where it repeats. */
static void put_coordinates(table *t, const double *values, int count)
{
    int before = 0;
    for (int i = 0; i < count; i++) {
        int delta = (int)values[i] - before;
        before = (int)values[i];
        if (delta == 0) continue;
        if (abs(delta) < 256)
            put8(t, abs(delta));
        else
            put16(t, delta);
    }
}

static int coordinate_flags(int delta, int short_bit, int same_bit)
{
    if (delta == 0) return same_bit;
    if (abs(delta) >= 256) return 0;
    return short_bit | (delta > 0 ? same_bit : 0);
}

static void put_outline(table *t, const outline *o, const metrics *m)
{
    if (o->count == 0) return;
    put16(t, o->contours);
    put16(t, m->x0), put16(t, m->y0), put16(t, m->x1), put16(t, m->y1);
    for (int i = 0; i < o->contours; i++) put16(t, o->last[i]);
    put16(t, 0); /* no instructions */
    int x = 0, y = 0;
    for (int i = 0; i < o->count; i++) {
        int flags = o->on[i] ? 1 : 0;
        flags |= coordinate_flags((int)o->x[i] - x, 2, 16) | coordinate_flags((int)o->y[i] - y, 4, 32);
        if (i == 0) flags |= 64; /* contours overlap */
        put8(t, flags);
        x = (int)o->x[i], y = (int)o->y[i];
    }
    put_coordinates(t, o->x, o->count);
    put_coordinates(t, o->y, o->count);
    while (t->size % 4) put8(t, 0);
}

static void widen(font *f, const metrics *m)
{
    if (m->x0 < f->box.x0) f->box.x0 = m->x0;
    if (m->y0 < f->box.y0) f->box.y0 = m->y0;
    if (m->x1 > f->box.x1) f->box.x1 = m->x1;
    if (m->y1 > f->box.y1) f->box.y1 = m->y1;
    if (m->advance > f->box.advance) f->box.advance = m->advance;
}

/* Puts the mark over or under the middle of the base; over tall letters it stands higher. */
static bool add_mark(outline *o, const glyph_mark *added)
{
    outline above;
    double low, high, top = 0;
    if (!stroke_skeleton(added->skeleton, PEN, &above)) return false;
    if (o->count + above.count > MAX_POINTS || o->contours + above.contours > MAX_CONTOURS) return false;
    ink_box(o, &low, &high);
    for (int i = 0; i < o->count; i++)
        if (o->y[i] > top) top = o->y[i];
    const double lift = added->below || top < 500 ? 0 : top - PEN - 435;
    for (int i = 0; i < above.contours; i++) o->last[o->contours++] = o->count + above.last[i];
    for (int i = 0; i < above.count; i++, o->count++)
        o->x[o->count] = above.x[i] + (low + high) / 2, o->y[o->count] = above.y[i] + lift,
        o->on[o->count] = above.on[i];
    return true;
}

static bool add_glyph(font *f, const character *c)
{
    outline o;
    if (!stroke_skeleton(c->base->skeleton, PEN, &o) || (c->mark && !add_mark(&o, c->mark))) {
        fprintf(stderr, "glyph U+%04X: bad skeleton\n", (unsigned)c->code);
        return false;
    }
    metrics *m = &f->glyphs[f->count++];
    *m = place(c->base, &o);
    widen(f, m);
    put32(&f->tables[LOCA], (uint32_t)f->tables[GLYF].size);
    put_outline(&f->tables[GLYF], &o, m);
    put16(&f->tables[HMTX], m->advance), put16(&f->tables[HMTX], m->left);
    if (o.count > f->max_points) f->max_points = o.count;
    if (o.contours > f->max_contours) f->max_contours = o.contours;
    return true;
}

static const glyph *find_base(uint32_t code)
{
    for (int i = 0; i < font_glyph_count; i++)
        if (font_glyphs[i].code == code) return &font_glyphs[i];
    return NULL;
}

static int by_code(const void *a, const void *b)
{
    const uint32_t x = ((const character *)a)->code, y = ((const character *)b)->code;
    return x < y ? -1 : x > y;
}

static bool collect_characters(font *f)
{
    if (font_glyph_count + font_composed_count >= MAX_GLYPHS) return false;
    for (int i = 0; i < font_glyph_count; i++)
        f->characters[f->character_count++] = (character){font_glyphs[i].code, &font_glyphs[i], NULL};
    for (int i = 0; i < font_composed_count; i++) {
        const composed *c = &font_composed[i];
        f->characters[f->character_count++] =
            (character){c->code, find_base(c->base), c->mark ? &font_marks[c->mark] : NULL};
    }
    qsort(f->characters, (size_t)f->character_count, sizeof(character), by_code);
    for (int i = 0; i < f->character_count; i++) {
        const character *c = &f->characters[i];
        if (c->base && (i == 0 || c->code != c[-1].code)) continue;
        fprintf(stderr, "glyph U+%04X: twice, or without its base\n", (unsigned)c->code);
        return false;
    }
    return true;
}

static bool add_glyphs(font *f)
{
    static const glyph missing = {0, 60, 60, "M 0 0 L 0 610 L 360 610 L 360 0 Z"};
    if (!collect_characters(f) || !add_glyph(f, &(character){0, &missing, NULL})) return false;
    for (int i = 0; i < f->character_count; i++)
        if (!add_glyph(f, &f->characters[i])) return false;
    put32(&f->tables[LOCA], (uint32_t)f->tables[GLYF].size);
    return true;
}

/* ---- the small tables ---- */

/* Runs of codes that follow each other, each with its glyphs in order. Returns how many; ends[i] is the last index. */
static int find_runs(const font *f, int *starts, int *ends)
{
    int runs = 0;
    for (int i = 0; i < f->character_count; i++) {
        bool follows = i > 0 && f->characters[i].code == f->characters[i - 1].code + 1;
        if (!follows) starts[runs++] = i;
        ends[runs - 1] = i;
    }
    return runs;
}

static void put_cmap(font *f)
{
    table *t = &f->tables[CMAP];
    int starts[MAX_GLYPHS], ends[MAX_GLYPHS], runs = find_runs(f, starts, ends), segments = runs + 1, power = 1,
                                              log = 0;
    while (power * 2 <= segments) power *= 2, log++;
    put16(t, 0), put16(t, 2); /* version, two encodings that share one subtable */
    put16(t, 0), put16(t, 3), put32(t, 20);
    put16(t, 3), put16(t, 1), put32(t, 20);
    put16(t, 4), put16(t, 16 + 8 * segments), put16(t, 0);
    put16(t, segments * 2), put16(t, power * 2), put16(t, log), put16(t, (segments - power) * 2);
    for (int i = 0; i < runs; i++) put16(t, (int)f->characters[ends[i]].code);
    put16(t, 0xffff), put16(t, 0);
    for (int i = 0; i < runs; i++) put16(t, (int)f->characters[starts[i]].code);
    put16(t, 0xffff);
    for (int i = 0; i < runs; i++) put16(t, starts[i] + 1 - (int)f->characters[starts[i]].code);
    put16(t, 1);
    for (int i = 0; i < segments; i++) put16(t, 0);
}

static void put_head(font *f)
{
    table *t = &f->tables[HEAD];
    put32(t, 0x00010000), put32(t, 0x00010000);
    put32(t, 0);          /* the whole file's checksum goes here */
    put32(t, 0x5f0f3cf5); /* magic */
    put16(t, 0x000b), put16(t, (int)(1000 * SCALE));
    put64(t, 3786912000u); /* made: seconds from 1904 to 2024-01-01; a fixed date keeps the bytes fixed */
    put64(t, 3786912000u); /* and changed */
    put16(t, f->box.x0), put16(t, f->box.y0), put16(t, f->box.x1), put16(t, f->box.y1);
    put16(t, 0), put16(t, 8), put16(t, 2), put16(t, 1), put16(t, 0);
}

static void put_hhea(font *f)
{
    table *t = &f->tables[HHEA];
    int right = 32767;
    for (int i = 0; i < f->count; i++) {
        int bearing = f->glyphs[i].advance - f->glyphs[i].x1;
        if (bearing < right) right = bearing;
    }
    put32(t, 0x00010000);
    put16(t, ASCENDER), put16(t, DESCENDER), put16(t, 0);
    put16(t, f->box.advance), put16(t, f->box.x0), put16(t, right), put16(t, f->box.x1);
    put16(t, 1);
    for (int i = 0; i < 7; i++) put16(t, 0); /* caret slope and offset, reserved, metric format */
    put16(t, f->count);
}

static void put_maxp(font *f)
{
    table *t = &f->tables[MAXP];
    put32(t, 0x00010000), put16(t, f->count);
    put16(t, f->max_points), put16(t, f->max_contours), put16(t, 0), put16(t, 0);
    put16(t, 2);
    for (int i = 0; i < 8; i++) put16(t, 0);
}

static void put_os2(font *f)
{
    table *t = &f->tables[OS2];
    int mean = 0;
    for (int i = 0; i < f->count; i++) mean += f->glyphs[i].advance / f->count;
    put16(t, 4), put16(t, mean), put16(t, 500), put16(t, 5), put16(t, 0);
    static const int sub_and_superscript[] = {1300, 1200, 0, 150, 1300, 1200, 0, 700, 176, 560, 0};
    for (int i = 0; i < 11; i++) put16(t, sub_and_superscript[i]);
    static const int panose[10] = {2, 11, 5, 2, 2, 2, 2, 2, 2, 4};
    for (int i = 0; i < 10; i++) put8(t, panose[i]);
    put32(t, 0x287), put32(t, 0), put32(t, 0), put32(t, 0); /* Latin, Latin-1, Latin Extended-A, Greek, Cyrillic */
    put_text(t, "DAFT");
    put16(t, 0x40), put16(t, (int)f->characters[0].code), put16(t, (int)f->characters[f->character_count - 1].code);
    put16(t, ASCENDER), put16(t, DESCENDER), put16(t, 0), put16(t, ASCENDER), put16(t, -DESCENDER);
    put32(t, 1), put32(t, 0);
    put16(t, 1016), put16(t, 1396), put16(t, 0), put16(t, 32), put16(t, 1); /* x height, cap height */
}

static void put_name(table *t)
{
    static const struct {
        int id;
        const char *text;
    } names[] = {
        {0, "Made by daft_generate; CC0, no rights reserved"},
        {1, "DAFT"},
        {2, "Regular"},
        {3, "DAFT Regular 1.0"},
        {4, "DAFT Regular"},
        {5, "Version 1.0"},
        {6, "DAFT-Regular"},
    };
    int count = (int)(sizeof names / sizeof names[0]), offset = 0;
    put16(t, 0), put16(t, count), put16(t, 6 + 12 * count);
    for (int i = 0; i < count; i++) {
        int length = 2 * (int)strlen(names[i].text);
        put16(t, 3), put16(t, 1), put16(t, 0x409), put16(t, names[i].id), put16(t, length), put16(t, offset);
        offset += length;
    }
    for (int i = 0; i < count; i++)
        for (const char *s = names[i].text; *s; s++) put16(t, *s); /* UTF-16, big-endian */
}

static void put_post(table *t)
{
    put32(t, 0x00030000), put32(t, 0), put16(t, -220), put16(t, 100);
    for (int i = 0; i < 5; i++) put32(t, 0);
}

/* ---- the file ---- */

static uint32_t checksum(const uint8_t *bytes, size_t size)
{
    uint32_t sum = 0;
    for (size_t i = 0; i < size; i++) sum += (uint32_t)bytes[i] << (24 - 8 * (i % 4));
    return sum;
}

static void assemble(font *f, table *file)
{
    put32(file, 0x00010000), put16(file, TABLES), put16(file, 128), put16(file, 3), put16(file, TABLES * 16 - 128);
    size_t offset = 12 + 16 * TABLES, head = 0;
    for (int i = 0; i < TABLES; i++) {
        const table *t = &f->tables[i];
        put_text(file, tags[i]);
        put32(file, checksum(t->bytes, t->size)), put32(file, (uint32_t)offset), put32(file, (uint32_t)t->size);
        if (i == HEAD) head = offset;
        offset += (t->size + 3) / 4 * 4;
    }
    for (int i = 0; i < TABLES; i++) {
        for (size_t k = 0; k < f->tables[i].size; k++) put8(file, f->tables[i].bytes[k]);
        while (file->size % 4) put8(file, 0);
    }
    uint32_t adjustment = 0xb1b0afbau - checksum(file->bytes, file->size);
    for (int i = 0; i < 4; i++) file->bytes[head + 8 + (size_t)i] = (uint8_t)(adjustment >> (24 - 8 * i));
}

static bool build(font *f, table *file, const char *root)
{
    const char *path = "assets/fonts/daft.ttf";
    if (!add_glyphs(f)) return false;
    put_cmap(f);
    put_head(f), put_hhea(f), put_maxp(f), put_os2(f);
    put_name(&f->tables[NAME]), put_post(&f->tables[POST]);
    assemble(f, file);
    FILE *out = open_output(root, path);
    if (!out) return false;
    fwrite(file->bytes, 1, file->size, out);
    return close_output(out, path);
}

bool generate_font(const char *root)
{
    font *f = calloc(1, sizeof *f);
    table *file = calloc(1, sizeof *file);
    bool ok = f && file;
    if (ok)
        ok = build(f, file, root);
    else
        fprintf(stderr, "font: out of memory\n");
    free(f), free(file);
    return ok;
}
