/* Turns a glyph's skeleton into an outline, as a round pen would draw it.
 *
 * A skeleton is a list of strokes ended by ';'. y = 0 is the pen's centre on the baseline, x = 0 its leftmost centre:
 *
 *     M x y  or  L x y        goes there in a straight line (the first one of a stroke only sets the start)
 *     E cx cy rx ry a0 a1     follows an ellipse from angle a0 to a1 (degrees, counter-clockwise when a1 > a0)
 *     Z                       closes the stroke
 *     F                       closes it and fills its inside
 *     O cx cy rx ry           a whole ellipse
 *     D cx cy r               a dot of radius r
 *
 * Each side of a stroke becomes one run of points: straight offsets of lines, and for arcs quadratic curves through
 * offset points with the skeleton's tangents, which stay within 0.2 % of the radius at 30 degrees a curve. Outer
 * corners are round, inner ones are where the two offset tangents meet. */
#include "generate.h"

#include <math.h>
#include <string.h>

static const double DEGREE = 0.017453292519943295;
enum { MAX_SEGMENTS = 64 };

typedef struct point {
    double x, y;
} point;

typedef struct segment {
    bool arc;
    point from, to;
    point center;
    double rx, ry, a0, a1; /* radians */
} segment;

typedef struct stroke {
    segment items[MAX_SEGMENTS];
    int count;
    bool started, closed, filled;
    point pen;
} stroke;

static point unit(double x, double y)
{
    double length = sqrt(x * x + y * y);
    return (point){x / length, y / length};
}

static point arc_point(const segment *s, double a)
{
    return (point){s->center.x + s->rx * cos(a), s->center.y + s->ry * sin(a)};
}

static point arc_tangent(const segment *s, double a)
{
    double d = s->a1 > s->a0 ? 1 : -1;
    return unit(-d * s->rx * sin(a), d * s->ry * cos(a));
}

static point start_tangent(const segment *s)
{
    return s->arc ? arc_tangent(s, s->a0) : unit(s->to.x - s->from.x, s->to.y - s->from.y);
}

static point end_tangent(const segment *s) { return s->arc ? arc_tangent(s, s->a1) : start_tangent(s); }

static point left_of(point p, point tangent, double radius)
{
    return (point){p.x - tangent.y * radius, p.y + tangent.x * radius};
}

static void put(outline *out, point p, bool on)
{
    if (out->count >= MAX_POINTS) return;
    out->x[out->count] = p.x, out->y[out->count] = p.y, out->on[out->count] = on;
    out->count++;
}

static void end_contour(outline *out)
{
    if (out->contours < MAX_CONTOURS) out->last[out->contours++] = out->count - 1;
}

/* Where the lines p + s·t and q + s·w meet; their midpoint when they are parallel. */
static point meet(point p, point t, point q, point w)
{
    double cross = t.x * w.y - t.y * w.x;
    if (fabs(cross) < 1e-9) return (point){(p.x + q.x) / 2, (p.y + q.y) / 2};
    double s = ((q.x - p.x) * w.y - (q.y - p.y) * w.x) / cross;
    return (point){p.x + t.x * s, p.y + t.y * s};
}

/* The left side of an arc, after its first point. */
static void offset_arc(const segment *s, double radius, outline *out)
{
    int steps = (int)ceil(fabs(s->a1 - s->a0) / (30.5 * DEGREE));
    point t = arc_tangent(s, s->a0), p = left_of(arc_point(s, s->a0), t, radius);
    for (int i = 1; i <= steps; i++) {
        double a = s->a0 + (s->a1 - s->a0) * i / steps;
        point w = arc_tangent(s, a), q = left_of(arc_point(s, a), w, radius);
        put(out, meet(p, t, q, w), false);
        put(out, q, true);
        p = q, t = w;
    }
}

/* A round join or cap: from angle `from` by `turn` radians (negative is clockwise), after its first point. */
static void round_about(point center, double radius, double from, double turn, outline *out)
{
    segment s = {.arc = true, .center = center, .rx = radius, .ry = radius, .a0 = from, .a1 = from + turn};
    offset_arc(&s, 0, out);
}

/* Turns from the tangent t to w at p, on the left side. */
static void join(point p, point t, point w, double radius, outline *out)
{
    double turn = atan2(t.x * w.y - t.y * w.x, t.x * w.x + t.y * w.y);
    point a = left_of(p, t, radius), b = left_of(p, w, radius);
    if (fabs(turn) < 0.5 * DEGREE) {
        put(out, b, true);
    } else if (turn > 0) {
        put(out, meet(a, t, b, w), true);
    } else {
        put(out, a, true);
        round_about(p, radius, atan2(t.x, -t.y), turn, out);
    }
}

static void left_side(const stroke *s, double radius, outline *out)
{
    for (int i = 0; i < s->count; i++) {
        const segment *now = &s->items[i];
        if (i > 0) join(now->from, end_tangent(now - 1), start_tangent(now), radius, out);
        if (now->arc) offset_arc(now, radius, out);
    }
}

/* The open end: half a circle from the left side to the right. */
static void cap(const segment *last, double radius, outline *out)
{
    point t = end_tangent(last);
    put(out, left_of(last->to, t, radius), true);
    round_about(last->to, radius, atan2(t.x, -t.y), -180 * DEGREE, out);
}

static void reverse(const stroke *s, stroke *out)
{
    *out = *s;
    for (int i = 0; i < s->count; i++) {
        segment r = s->items[s->count - 1 - i];
        point from = r.from;
        double a0 = r.a0;
        r.from = r.to, r.to = from, r.a0 = r.a1, r.a1 = a0;
        out->items[i] = r;
    }
}

static double signed_area(const stroke *s)
{
    double area = 0;
    for (int i = 0; i < s->count; i++) {
        const segment *e = &s->items[i];
        point middle = e->arc ? arc_point(e, (e->a0 + e->a1) / 2) : e->to;
        area += e->from.x * middle.y - e->from.y * middle.x + middle.x * e->to.y - middle.y * e->to.x;
    }
    return area;
}

static void closed_side(const stroke *s, double radius, outline *out)
{
    const segment *first = &s->items[0], *last = &s->items[s->count - 1];
    join(first->from, end_tangent(last), start_tangent(first), radius, out);
    left_side(s, radius, out);
    end_contour(out);
}

static void draw(const stroke *s, double radius, outline *out)
{
    if (s->count == 0) return;
    stroke back;
    reverse(s, &back);
    if (!s->closed) {
        left_side(s, radius, out);
        cap(&s->items[s->count - 1], radius, out);
        left_side(&back, radius, out);
        cap(&back.items[s->count - 1], radius, out);
        end_contour(out);
    } else if (s->filled) {
        closed_side(signed_area(s) < 0 ? s : &back, radius, out);
    } else {
        closed_side(s, radius, out);
        closed_side(&back, radius, out);
    }
}

/* ---- reading ---- */

static void line_to(stroke *s, point p)
{
    double dx = p.x - s->pen.x, dy = p.y - s->pen.y;
    /* Ends given in whole units miss an arc's true end by less than one: close enough to be the same point. */
    if (s->started && dx * dx + dy * dy > 1.5 && s->count < MAX_SEGMENTS)
        s->items[s->count++] = (segment){.from = s->pen, .to = p};
    else if (s->started && s->count > 0)
        p = s->pen;
    s->started = true;
    s->pen = p;
}

static void arc_to(stroke *s, const double v[6])
{
    segment e = {.arc = true, .center = {v[0], v[1]}, .rx = v[2], .ry = v[3], .a0 = v[4] * DEGREE, .a1 = v[5] * DEGREE};
    e.from = arc_point(&e, e.a0), e.to = arc_point(&e, e.a1);
    line_to(s, e.from);
    if (s->count < MAX_SEGMENTS) s->items[s->count++] = e;
    s->pen = e.to;
}

static void close_stroke(stroke *s, bool fill)
{
    if (s->count > 0) line_to(s, s->items[0].from);
    s->closed = true, s->filled = fill;
}

static bool numbers(const char **text, int count, double *out)
{
    for (int i = 0; i < count; i++) {
        int used = 0;
        if (sscanf(*text, "%lf%n", &out[i], &used) != 1) return false;
        *text += used;
    }
    return true;
}

static int argument_count(char command)
{
    switch (command) {
    case 'M':
    case 'L': return 2;
    case 'D': return 3;
    case 'O': return 4;
    case 'E': return 6;
    case 'Z':
    case 'F':
    case ';': return 0;
    default: return -1;
    }
}

static void dot(const double v[3], outline *out)
{
    stroke s = {.started = false};
    arc_to(&s, (const double[]){v[0], v[1], v[2], v[2], 360, 0});
    s.closed = s.filled = true;
    draw(&s, 0, out);
}

static void obey(char command, const double v[6], stroke *s, double radius, outline *out)
{
    switch (command) {
    case 'E': arc_to(s, v); break;
    case 'Z': close_stroke(s, false); break;
    case 'F': close_stroke(s, true); break;
    case 'D': dot(v, out); break;
    case 'O':
        arc_to(s, (const double[]){v[0], v[1], v[2], v[3], 0, 360});
        s->closed = true;
        break;
    case ';':
        draw(s, radius, out);
        *s = (stroke){.started = false};
        break;
    default: line_to(s, (point){v[0], v[1]});
    }
}

bool stroke_skeleton(const char *skeleton, double radius, outline *out)
{
    out->count = out->contours = 0;
    stroke s = {.started = false};
    const char *text = skeleton;
    while (*text) {
        char command = *text++;
        if (command == ' ') continue;
        double v[6];
        int count = argument_count(command);
        if (count < 0 || !numbers(&text, count, v)) return false;
        obey(command, v, &s, radius, out);
    }
    draw(&s, radius, out);
    return out->count < MAX_POINTS && out->contours < MAX_CONTOURS;
}
