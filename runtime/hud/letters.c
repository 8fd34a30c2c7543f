/* Outlines of letters to contours of lines. */
#include "hud/letters.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a contour's lines from its curve, in heights of a capital letter; and lines for one curve, at most. */
static const float TOLERANCE = 1.0f / 400;
enum { MOST_LINES = 64 };
/* Of the line's height, where a font has no H. */
static const float USUAL_CAPITAL = 0.6f;

void letters_free(letters *l)
{
    free(l->points);
    free(l->counts);
    *l = (letters){0};
}

/* Room for one more. */
static bool grow(void *array_pointer, size_t *capacity, size_t used, size_t size)
{
    void *old;
    if (used < *capacity) return true;
    memcpy(&old, array_pointer, sizeof old);
    const size_t room = 2 * used + 256;
    void *fresh = realloc(old, room * size);
    if (!fresh) return false;
    memcpy(array_pointer, &fresh, sizeof fresh);
    *capacity = room;
    return true;
}

static bool add_point(letters *l, float x, float y)
{
    if (!grow(&l->points, &l->point_capacity, l->point_count, sizeof *l->points)) return false;
    l->points[l->point_count++] = (daft_vec2){x, y};
    l->counts[l->contour_count - 1]++;
    return true;
}

static bool begin_contour(letters *l)
{
    if (!grow(&l->counts, &l->contour_capacity, l->contour_count, sizeof *l->counts)) return false;
    l->counts[l->contour_count++] = 0;
    return true;
}

/* Lines to a curve's end. Between n of them and the curve there is |from - 2·control + end| / (4·n²) at most. */
static bool add_curve(letters *l, daft_vec2 from, daft_vec2 control, daft_vec2 end, float tolerance)
{
    const float x = from.x - 2 * control.x + end.x, y = from.y - 2 * control.y + end.y;
    const float wanted = ceilf(sqrtf(sqrtf(x * x + y * y) / (4 * tolerance)));
    const int lines = wanted > 1 ? wanted < MOST_LINES ? (int)wanted : MOST_LINES : 1;
    for (int i = 1; i <= lines; i++) {
        const float t = (float)i / (float)lines, s = 1 - t;
        if (!add_point(l, s * s * from.x + 2 * s * t * control.x + t * t * end.x,
                       s * s * from.y + 2 * s * t * control.y + t * t * end.y))
            return false;
    }
    return true;
}

typedef struct pen {
    float x, y;  /* of the letter's origin, metres */
    float scale; /* metres a font unit */
    float tolerance;
} pen;

static daft_vec2 to_metres(const pen *p, float x, float y)
{
    return (daft_vec2){p->x + x * p->scale, p->y + y * p->scale};
}

/* A contour's last point is its first one. */
static bool add_letter(letters *l, const truetype_outline *outline, const pen *p)
{
    daft_vec2 at = {0, 0};
    bool done = true;
    for (size_t i = 0; done && i < outline->count; i++) {
        const truetype_point *next = &outline->points[i];
        const daft_vec2 end = to_metres(p, next->x, next->y);
        const bool last = i + 1 == outline->count || outline->points[i + 1].step == TRUETYPE_MOVE;
        if (next->step == TRUETYPE_MOVE)
            done = begin_contour(l) && add_point(l, end.x, end.y);
        else if (next->step == TRUETYPE_CURVE)
            done = add_curve(l, at, to_metres(p, next->control_x, next->control_y), end, p->tolerance);
        else if (!last)
            done = add_point(l, end.x, end.y);
        at = end;
    }
    return done;
}

static float capital_height(font *face)
{
    const truetype_outline *outline = font_outline(face, 'H');
    float box[4] = {0};
    if (outline) truetype_bounds(outline, box);
    return box[3] > 0 ? box[3] : USUAL_CAPITAL * (float)font_height(face);
}

static bool add_line(letters *l, font *face, const char **text, pen p, text_align align)
{
    const float width = (float)font_line_advance(face, *text) * p.scale;
    if (align != TEXT_LEFT) p.x -= width * (align == TEXT_CENTER ? 0.5f : 1.0f);
    int walked = 0;
    const float left = p.x;
    uint32_t code = utf8_next(text);
    while (code && code != '\n') {
        const uint32_t next = utf8_next(text);
        const truetype_outline *outline = font_outline(face, code);
        p.x = left + (float)walked * p.scale;
        if (outline && !add_letter(l, outline, &p)) return false;
        walked += font_advance(face, code, next);
        code = next;
    }
    return true;
}

bool letters_make(letters *out, font *face, const char *text, float size, text_align align, daft_error *error)
{
    pen p = {.scale = size / capital_height(face), .tolerance = size * TOLERANCE};
    const float line = text_line_height((float)font_height(face)) * p.scale;
    *out = (letters){0};
    for (const char *at = text; (at = strchr(at, '\n')); at++) p.y += line;
    for (const char *at = text, *end; at; at = end ? end + 1 : NULL, p.y -= line) {
        end = strchr(at, '\n');
        const char *begin = at;
        if (add_line(out, face, &begin, p, align)) continue;
        letters_free(out);
        return fail(error, DAFT_ERROR_MEMORY, "out of memory for letters");
    }
    return true;
}
