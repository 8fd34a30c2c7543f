/* Fills polygons: each edge adds the area that it covers to its row's pixels, signed by its direction, and the sum from
 * the left is the coverage (as font-rs does). Contours that run the same way round and overlap count once. */
#include "hud/canvas.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_EDGES = 16384 };

static const double TURN = 6.283185307179586;

typedef struct shape {
    canvas_point *points; /* pixels; each edge is a pair */
    size_t count, capacity;
    bool good;
} shape;

static void add_edge(shape *s, canvas_point a, canvas_point b)
{
    if (s->count + 2 > s->capacity) {
        const size_t more = s->capacity ? 2 * s->capacity : 128;
        canvas_point *points = more <= 2 * MOST_EDGES ? realloc(s->points, more * sizeof *points) : NULL;
        if (!points) s->good = false;
        if (!points) return;
        s->points = points, s->capacity = more;
    }
    if (!(fabsf(a.x) < 1e6f) || !(fabsf(a.y) < 1e6f) || !(fabsf(b.x) < 1e6f) || !(fabsf(b.y) < 1e6f)) s->good = false;
    s->points[s->count++] = a, s->points[s->count++] = b;
}

static void add_contour(shape *s, const canvas_point *points, size_t count)
{
    for (size_t i = 0; i < count; i++) add_edge(s, points[i], points[i + 1 < count ? i + 1 : 0]);
}

/* ---- one row ---- */

/* Of an edge within the row and between 0 and the row's width. `d`: how far it goes down. */
static void add_area(float *row, float x0, float x1, float d)
{
    const float low = fminf(x0, x1), high = fmaxf(x0, x1), first = floorf(low), last = ceilf(high);
    const int i = (int)first, end = (int)last;
    if (end <= i + 1) {
        const float middle = 0.5f * (x0 + x1) - first;
        row[i] += d * (1 - middle), row[i + 1] += d * middle;
        return;
    }
    const float s = 1 / (high - low), from = low - first, to = high - last + 1;
    const float head = 0.5f * s * (1 - from) * (1 - from), tail = 0.5f * s * to * to;
    row[i] += d * head;
    if (end == i + 2) {
        row[i + 1] += d * (1 - head - tail);
    } else {
        const float second = s * (1.5f - from);
        row[i + 1] += d * (second - head);
        for (int k = i + 2; k < end - 1; k++) row[k] += d * s;
        row[end - 1] += d * (1 - second - (float)(end - i - 3) * s - tail);
    }
    row[end] += d * tail;
}

static float at(float x0, float x1, float t) { return x0 + (x1 - x0) * t; }

/* What lies left of the row counts at its first pixel, what lies right of it not at all. */
static void add_clipped(float *row, float width, float x0, float x1, float d)
{
    if (x0 >= width && x1 >= width) return;
    if (x0 <= 0 && x1 <= 0) {
        row[0] += d;
        return;
    }
    if (fminf(x0, x1) < 0) {
        const float t = x0 / (x0 - x1);
        add_clipped(row, width, x0 < 0 ? x0 : 0, x0 < 0 ? 0 : x1, d * (x0 < 0 ? t : 1 - t));
        add_clipped(row, width, x0 < 0 ? 0 : x0, x0 < 0 ? x1 : 0, d * (x0 < 0 ? 1 - t : t));
        return;
    }
    if (fmaxf(x0, x1) > width) {
        const float t = (width - x0) / (x1 - x0);
        add_area(row, x0 < width ? x0 : width, x0 < width ? width : x1, d * (x0 < width ? t : 1 - t));
        return;
    }
    add_area(row, x0, x1, d);
}

static void add_edge_to_row(float *row, float width, canvas_point a, canvas_point b, float top)
{
    const float sign = a.y < b.y ? 1 : -1;
    const canvas_point upper = a.y < b.y ? a : b, lower = a.y < b.y ? b : a;
    const float y0 = fmaxf(upper.y, top), y1 = fminf(lower.y, top + 1);
    if (!(y1 > y0)) return;
    const float height = lower.y - upper.y;
    const float x0 = at(upper.x, lower.x, (y0 - upper.y) / height), x1 = at(upper.x, lower.x, (y1 - upper.y) / height);
    add_clipped(row, width, x0, x1, sign * (y1 - y0));
}

static void fill(const canvas *target, shape *s, canvas_color color)
{
    canvas_box clip = canvas_bounds(target);
    float top = 1e9f, bottom = -1e9f, left = 1e9f, right = -1e9f;
    for (size_t i = 0; i < s->count; i++) {
        top = fminf(top, s->points[i].y), bottom = fmaxf(bottom, s->points[i].y);
        left = fminf(left, s->points[i].x), right = fmaxf(right, s->points[i].x);
    }
    if (left > (float)clip.left) clip.left = left < (float)clip.right ? (int)left : clip.right;
    if (right < (float)clip.right) clip.right = right > (float)clip.left ? (int)ceilf(right) : clip.left;
    const int width = clip.right - clip.left;
    float *row = s->good && width > 0 && s->count > 0 ? malloc(((size_t)width + 2) * sizeof *row) : NULL;
    for (size_t i = 0; i < s->count; i++) s->points[i].x -= (float)clip.left;
    const int first = top > (float)clip.top ? (int)top : clip.top;
    for (int y = first; row && y < clip.bottom && (float)y < bottom && !canvas_stops(target); y++) {
        for (int x = 0; x < width + 2; x++) row[x] = 0;
        for (size_t i = 0; i < s->count; i += 2)
            add_edge_to_row(row, (float)width, s->points[i], s->points[i + 1], (float)y);
        float sum = 0;
        for (int x = 0; x < width; x++) {
            sum += row[x];
            const float covered = fminf(fabsf(sum), 1);
            if (covered > 1.0f / 512) canvas_blend(target, clip.left + x, y, color, covered);
        }
    }
    free(row);
    free(s->points);
}

static canvas_point to_pixels(const canvas *target, canvas_point p)
{
    return (canvas_point){p.x * target->unit + target->origin_x, p.y * target->unit + target->origin_y};
}

void canvas_polygon(const canvas *target, const canvas_point *points, size_t count, canvas_color color)
{
    shape s = {.good = true};
    for (size_t i = 0; i < count; i++)
        add_edge(&s, to_pixels(target, points[i]), to_pixels(target, points[i + 1 < count ? i + 1 : 0]));
    fill(target, &s, color);
}

/* ---- circles and lines ---- */

enum { MOST_CORNERS = 256 };

/* So many that no side is more than a tenth of a pixel inside. */
static size_t corners_of(float radius)
{
    const float wanted = 7 * sqrtf(radius) + 8;
    return wanted < MOST_CORNERS ? (size_t)wanted : MOST_CORNERS;
}

static void add_circle(shape *s, canvas_point center, float radius, bool reversed)
{
    canvas_point points[MOST_CORNERS];
    const size_t count = corners_of(radius);
    for (size_t i = 0; i < count; i++) {
        const double angle = TURN * (double)i / (double)count * (reversed ? -1 : 1);
        points[i] =
            (canvas_point){center.x + radius * (float)daft_cos(angle), center.y + radius * (float)daft_sin(angle)};
    }
    add_contour(s, points, count);
}

void canvas_circle(const canvas *target, float x, float y, float radius, float width, canvas_color color)
{
    if (!(radius > 0) || !(radius * target->unit < 1e5f)) return;
    shape s = {.good = true};
    const canvas_point center = to_pixels(target, (canvas_point){x, y});
    const float outer = (radius + width / 2) * target->unit, inner = (radius - width / 2) * target->unit;
    add_circle(&s, center, outer, false);
    if (width > 0 && inner > 0) add_circle(&s, center, inner, true);
    fill(target, &s, color);
}

/* A bar as wide as the line; it runs the way that circles do. */
static void add_bar(shape *s, canvas_point a, canvas_point b, float half)
{
    const float x = b.x - a.x, y = b.y - a.y, length = sqrtf(x * x + y * y);
    if (!(length > 0)) return;
    const float across_x = -y / length * half, across_y = x / length * half;
    const canvas_point points[] = {{a.x - across_x, a.y - across_y},
                                   {b.x - across_x, b.y - across_y},
                                   {b.x + across_x, b.y + across_y},
                                   {a.x + across_x, a.y + across_y}};
    add_contour(s, points, 4);
}

void canvas_line(const canvas *target, const canvas_point *points, size_t count, bool closed, float width,
                 canvas_color color)
{
    shape s = {.good = true};
    const float half = width / 2 * target->unit;
    if (!(half > 0) || !(half < 1e5f)) return;
    for (size_t i = 0; i < count; i++) {
        const canvas_point a = to_pixels(target, points[i]), b = to_pixels(target, points[i + 1 < count ? i + 1 : 0]);
        if (i + 1 < count || closed) add_bar(&s, a, b, half);
        const bool corner = closed || (i > 0 && i + 1 < count);
        if (corner && half > 0.6f) add_circle(&s, a, half, false);
    }
    fill(target, &s, color);
}
