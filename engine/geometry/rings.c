/* Borders to rings, and rings to triangles.
 *
 * Each ring is followed with the inside on its left. Holes are joined to what is around them by a bridge, a line there
 * and back, from their leftmost corner to the nearest one further left that it sees; so holes are done from the left
 * (Eberly, "Triangulation by ear clipping"). Whether one corner sees another is decided exactly. */
#include "geometry/outline.h"
#include "geometry/polygon.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const uint32_t NONE = UINT32_MAX;

/* A corner of a ring; corners in one place are several nodes where bridges end or rings touch. */
typedef struct ring_node {
    uint32_t point;
    uint32_t next, previous;
    uint32_t ring;
} ring_node;

typedef struct ring {
    uint32_t first;    /* one of its nodes */
    uint32_t leftmost; /* node; the lowest where there are several places */
    int64_t area;      /* twice; below zero: a hole */
    bool joined;       /* to another, which has its nodes */
} ring;

typedef struct rings {
    const daft_allocator *allocator;
    daft_outline *outline;
    ring_node *nodes; /* the borders' first corners, in the order of borders; then those that bridges add */
    uint32_t node_count;
    ring *items;
    uint32_t count;
    daft_polygon polygon;
} rings;

static daft_grid_point place(const rings *r, uint32_t node) { return r->outline->points[r->nodes[node].point]; }

/* ---- corners ---- */

static int by_start(const void *left, const void *right)
{
    const daft_grid_edge *a = left, *b = right;
    const int order = daft_grid_order(a->a, b->a);
    return order ? order : daft_grid_order(a->b, b->b);
}

/* Every corner is where a border begins. */
static void number_points(daft_outline *outline)
{
    outline->point_count = 0;
    for (size_t i = 0; i < outline->edge_count; i++) {
        const daft_grid_point p = outline->edges[i].a;
        if (i == 0 || daft_grid_order(outline->edges[i - 1].a, p) != 0) outline->points[outline->point_count++] = p;
        outline->ends[2 * i] = outline->point_count - 1;
    }
}

/* The first border that does not begin before `p`. */
static size_t first_from(const daft_outline *outline, daft_grid_point p)
{
    size_t low = 0, high = outline->edge_count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (daft_grid_order(outline->edges[middle].a, p) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* ---- rings ---- */

/* Turning clockwise from the direction `r`: which comes first, a half turn at a time; 3: `d` is `r` itself. */
static int half_turn(daft_grid_point at, daft_grid_point r, daft_grid_point d)
{
    const int64_t side = daft_grid_side(at, r, d);
    if (side < 0) return 0;
    if (side > 0) return 2;
    return daft_grid_between(r, d, at) ? 1 : 3;
}

static bool turns_less(daft_grid_point at, daft_grid_point r, daft_grid_point a, daft_grid_point b)
{
    const int half_a = half_turn(at, r, a), half_b = half_turn(at, r, b);
    return half_a != half_b ? half_a < half_b : daft_grid_side(at, a, b) < 0;
}

/* The border that goes on from border `i` around the same inside: the first one clockwise of where it came from. */
static size_t following(const daft_outline *outline, size_t i)
{
    const daft_grid_edge *e = outline->edges;
    const daft_grid_point at = e[i].b, back = e[i].a;
    size_t best = first_from(outline, at);
    for (size_t j = best + 1; j < outline->edge_count && daft_grid_order(e[j].a, at) == 0; j++)
        if (turns_less(at, back, e[j].b, e[best].b)) best = j;
    return best;
}

static void follow_ring(rings *r, uint32_t start)
{
    ring *made = &r->items[r->count];
    *made = (ring){.first = start, .leftmost = start};
    const daft_grid_point origin = place(r, start);
    uint32_t i = start;
    do {
        const uint32_t next = r->nodes[i].next;
        r->nodes[i].ring = r->count;
        made->area += daft_grid_side(origin, place(r, i), place(r, next));
        if (daft_grid_order(place(r, i), place(r, made->leftmost)) < 0) made->leftmost = i;
        i = next;
    } while (i != start);
    r->count++;
}

static void find_rings(rings *r)
{
    daft_outline *o = r->outline;
    r->node_count = (uint32_t)o->edge_count;
    for (uint32_t i = 0; i < r->node_count; i++) {
        const uint32_t next = (uint32_t)following(o, i);
        o->ends[2 * i + 1] = o->ends[2 * next];
        r->nodes[i].point = o->ends[2 * i], r->nodes[i].ring = NONE;
        r->nodes[i].next = next, r->nodes[next].previous = i;
    }
    for (uint32_t i = 0; i < r->node_count; i++)
        if (r->nodes[i].ring == NONE) follow_ring(r, i);
}

/* Borders, and their ends, in the order of the rings. */
static bool order_borders(rings *r, daft_error *error)
{
    daft_outline *o = r->outline;
    daft_grid_edge *edges = daft_alloc(r->allocator, o->edge_count, sizeof *edges);
    uint32_t *ends = daft_alloc(r->allocator, 2 * o->edge_count, sizeof *ends);
    if (!edges || !ends) {
        daft_release(r->allocator, edges);
        daft_release(r->allocator, ends);
        return daft_fail_memory(error, "an outline's rings");
    }
    size_t count = 0;
    for (uint32_t k = 0; k < r->count; k++) {
        uint32_t i = r->items[k].first;
        do {
            edges[count] = o->edges[i];
            memcpy(ends + 2 * count, o->ends + 2 * (size_t)i, 2 * sizeof *ends);
            count++;
            i = r->nodes[i].next;
        } while (i != r->items[k].first);
    }
    daft_release(r->allocator, o->edges);
    daft_release(r->allocator, o->ends);
    o->edges = edges, o->ends = ends, o->edge_capacity = o->edge_count;
    return true;
}

/* ---- bridges ---- */

/* Whether the direction to `p` leads into the inside at the node. */
static bool leads_inside(const rings *r, uint32_t node, daft_grid_point p)
{
    const daft_grid_point at = place(r, node), next = place(r, r->nodes[node].next),
                          previous = place(r, r->nodes[node].previous);
    const int64_t turn = daft_grid_side(at, next, previous), a = daft_grid_side(at, next, p),
                  b = daft_grid_side(at, p, previous);
    if (turn > 0) return a > 0 && b > 0;
    if (turn < 0) return a > 0 || b > 0;
    if (daft_grid_between(next, previous, at)) return a > 0;
    return a != 0 || daft_grid_between(next, p, at); /* the tip of a bridge: all around it is inside */
}

/* Whether nothing is on the line between two corners. */
static bool is_clear(const rings *r, daft_grid_point from, daft_grid_point to)
{
    for (uint32_t i = 0; i < r->node_count; i++) {
        const daft_grid_point a = place(r, i), b = place(r, r->nodes[i].next);
        const int64_t sa = daft_grid_side(from, to, a), sb = daft_grid_side(from, to, b);
        if (sa == 0 && daft_grid_between(from, to, a)) return false;
        if (!((sa < 0 && sb > 0) || (sa > 0 && sb < 0))) continue;
        const int64_t sf = daft_grid_side(a, b, from), st = daft_grid_side(a, b, to);
        if ((sf < 0 && st > 0) || (sf > 0 && st < 0)) return false;
    }
    return true;
}

static double distance2(daft_grid_point a, daft_grid_point b)
{
    const double x = (double)b.x - a.x, y = (double)b.y - a.y;
    return x * x + y * y;
}

/* The node of the ring in the place of `node` that looks towards `p`, or NONE. */
static uint32_t looking_at(const rings *r, uint32_t node, daft_grid_point p)
{
    uint32_t i = node;
    do {
        if (r->nodes[i].point == r->nodes[node].point && leads_inside(r, i, p)) return i;
        i = r->nodes[i].next;
    } while (i != node);
    return NONE;
}

/* The nearest node on the left of a hole's leftmost place that this sees, in another ring; *from is the hole's. */
static bool find_bridge(const rings *r, uint32_t leftmost, uint32_t *from, uint32_t *to, daft_error *error)
{
    const daft_grid_point p = place(r, leftmost);
    double best = INFINITY;
    *to = NONE;
    for (uint32_t i = 0; i < r->node_count; i++) {
        const daft_grid_point q = place(r, i);
        const double far = distance2(p, q);
        if (r->nodes[i].ring == r->nodes[leftmost].ring || daft_grid_order(q, p) >= 0 || !(far < best)) continue;
        if (!leads_inside(r, i, p)) continue;
        const uint32_t node = looking_at(r, leftmost, q);
        if (node == NONE) continue;
        if (!daft_outline_spend(r->outline, r->node_count, error)) return false;
        if (is_clear(r, p, q)) *from = node, *to = i, best = far;
    }
    return *to != NONE || daft_outline_spend(r->outline, SIZE_MAX, error);
}

/* From node v there to t, around t's ring, and back. */
static void join(rings *r, uint32_t t, uint32_t v)
{
    const uint32_t t2 = r->node_count++, v2 = r->node_count++, before = r->nodes[t].previous, after = r->nodes[v].next;
    const uint32_t joined = r->nodes[t].ring, into = r->nodes[v].ring;
    uint32_t i = t;
    do {
        r->nodes[i].ring = into;
        i = r->nodes[i].next;
    } while (i != t);
    r->nodes[t2] = (ring_node){r->nodes[t].point, v2, before, into};
    r->nodes[v2] = (ring_node){r->nodes[v].point, after, t2, into};
    r->nodes[before].next = t2, r->nodes[after].previous = v2;
    r->nodes[v].next = t, r->nodes[t].previous = v;
    r->items[joined].joined = true;
}

typedef struct hole_key {
    daft_grid_point leftmost;
    uint32_t ring;
} hole_key;

static int by_leftmost(const void *left, const void *right)
{
    const hole_key *a = left, *b = right;
    const int order = daft_grid_order(a->leftmost, b->leftmost);
    return order ? order : a->ring < b->ring ? -1 : 1;
}

static bool join_holes(rings *r, daft_error *error)
{
    hole_key *holes = daft_alloc(r->allocator, r->count + 1, sizeof *holes);
    size_t count = 0;
    bool done = holes || daft_fail_memory(error, "an outline's holes");
    for (uint32_t k = 0; done && k < r->count; k++)
        if (r->items[k].area < 0) holes[count++] = (hole_key){place(r, r->items[k].leftmost), k};
    if (count > 1) qsort(holes, count, sizeof *holes, by_leftmost);
    for (size_t k = 0; done && k < count; k++) {
        uint32_t from = NONE, to = NONE;
        done = find_bridge(r, r->items[holes[k].ring].leftmost, &from, &to, error);
        if (done) join(r, from, to);
    }
    daft_release(r->allocator, holes);
    return done;
}

/* ---- triangles ---- */

static bool keep_triangles(rings *r, const uint32_t *nodes, uint32_t count, daft_error *error)
{
    daft_outline *o = r->outline;
    const size_t fresh = count - 2;
    if (!daft_grow(r->allocator, &o->triangles, &o->triangle_capacity, o->triangle_count + fresh, o->triangle_count,
                   3 * sizeof *o->triangles))
        return daft_fail_memory(error, "an outline's triangles");
    for (size_t i = 0; i < fresh; i++) {
        uint32_t *out = o->triangles + 3 * o->triangle_count;
        for (size_t k = 0; k < 3; k++) out[k] = r->nodes[nodes[r->polygon.triangles[3 * i + k]]].point;
        /* There and back along a bridge, perhaps. */
        if (out[0] != out[1] && out[1] != out[2] && out[2] != out[0]) o->triangle_count++;
    }
    return true;
}

static bool cut_ring(rings *r, const ring *item, uint32_t *nodes, daft_error *error)
{
    uint32_t count = 0, i = item->first;
    do {
        nodes[count++] = i;
        i = r->nodes[i].next;
    } while (i != item->first);
    if (!daft_polygon_reserve(r->allocator, &r->polygon, count)) return daft_fail_memory(error, "an outline's polygon");
    const daft_grid_point origin = place(r, nodes[0]);
    for (uint32_t k = 0; k < count; k++) {
        const daft_grid_point p = place(r, nodes[k]);
        r->polygon.points[k] = (daft_dvec3){(double)p.x - origin.x, (double)p.y - origin.y, 0};
    }
    daft_polygon_triangulate(&r->polygon, count);
    return keep_triangles(r, nodes, count, error);
}

static bool make_rings(rings *r, daft_error *error)
{
    daft_outline *o = r->outline;
    const size_t count = o->edge_count;
    o->points = daft_alloc(r->allocator, count, sizeof *o->points);
    o->ends = daft_alloc(r->allocator, 2 * count, sizeof *o->ends);
    r->nodes = daft_alloc(r->allocator, 3 * count, sizeof *r->nodes); /* two more for each ring: fewer than borders */
    r->items = daft_alloc(r->allocator, count, sizeof *r->items);
    uint32_t *nodes = daft_alloc(r->allocator, 3 * count, sizeof *nodes);
    bool done =
        (o->points && o->ends && r->nodes && r->items && nodes) || daft_fail_memory(error, "an outline's rings");
    if (done) {
        qsort(o->edges, count, sizeof *o->edges, by_start);
        number_points(o);
        find_rings(r);
        done = order_borders(r, error) && join_holes(r, error);
    }
    for (uint32_t k = 0; done && k < r->count; k++)
        if (!r->items[k].joined) done = cut_ring(r, &r->items[k], nodes, error);
    daft_release(r->allocator, nodes);
    return done;
}

bool daft_outline_triangulate(const daft_allocator *allocator, daft_outline *outline, daft_error *error)
{
    if (outline->edge_count == 0) return true;
    if (outline->edge_count > UINT32_MAX / 4) return daft_fail_memory(error, "an outline");
    rings r = {.allocator = allocator, .outline = outline};
    const bool done = make_rings(&r, error);
    daft_polygon_free(allocator, &r.polygon);
    daft_release(allocator, r.nodes);
    daft_release(allocator, r.items);
    return done;
}
