/* Contours to borders: iterated snap rounding on the grid, then winding numbers.
 *
 * Edges that cross are cut at the grid's point nearest to where they do. That bends them a little, so pieces may cross
 * anew; rounds go on until none does (Hobby, "Practical segment intersection with finite precision output", 1999,
 * bounds the bend; here a limit of rounds, edges and tests bounds the time). What contours enclose changes by half a
 * cell at most. */
#include "geometry/outline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 64 };

typedef struct cut {
    uint32_t edge;
    bool rises; /* the edge's b is above its a */
    daft_grid_point at;
} cut;

typedef struct cut_list {
    cut *items;
    size_t count, capacity;
} cut_list;

void daft_outline_free(const daft_allocator *allocator, daft_outline *outline)
{
    void *gone[] = {outline->edges, outline->ends, outline->points, outline->triangles};
    for (size_t i = 0; i < DAFT_COUNT_OF(gone); i++) daft_release(allocator, gone[i]);
    *outline = (daft_outline){0};
}

bool daft_outline_spend(daft_outline *outline, size_t tests, daft_error *error)
{
    if (tests > outline->work)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "the contours are too many, or too entangled, to be made solid");
    outline->work -= tests;
    return true;
}

static bool add_edge(const daft_allocator *allocator, daft_outline *outline, daft_grid_point a, daft_grid_point b,
                     int32_t winding, daft_error *error)
{
    if (daft_grid_order(a, b) == 0) return true;
    if (!daft_grow(allocator, &outline->edges, &outline->edge_capacity, outline->edge_count + 1, outline->edge_count,
                   sizeof *outline->edges))
        return daft_fail_memory(error, "an outline");
    const bool forward = daft_grid_order(a, b) < 0;
    outline->edges[outline->edge_count++] =
        forward ? (daft_grid_edge){a, b, winding} : (daft_grid_edge){b, a, -winding};
    return true;
}

bool daft_outline_add(const daft_allocator *allocator, daft_outline *outline, const daft_grid_point *points,
                      uint32_t count, daft_error *error)
{
    for (uint32_t i = 0; i < count; i++)
        if (!add_edge(allocator, outline, points[i], points[i + 1 < count ? i + 1 : 0], 1, error)) return false;
    return true;
}

/* ---- cuts ---- */

static int by_ends(const void *left, const void *right)
{
    const daft_grid_edge *a = left, *b = right;
    const int order = daft_grid_order(a->a, b->a);
    return order ? order : daft_grid_order(a->b, b->b);
}

/* Sorts by ends; edges in the same place become one, and none where their windings cancel. */
static void merge_edges(daft_outline *outline)
{
    daft_grid_edge *e = outline->edges;
    size_t kept = 0;
    if (outline->edge_count == 0) return;
    qsort(e, outline->edge_count, sizeof *e, by_ends);
    for (size_t i = 0; i < outline->edge_count;) {
        daft_grid_edge merged = e[i];
        for (i++; i < outline->edge_count && by_ends(&e[i], &merged) == 0; i++) merged.winding += e[i].winding;
        if (merged.winding != 0) e[kept++] = merged;
    }
    outline->edge_count = kept;
}

static bool add_cut(const daft_allocator *allocator, cut_list *cuts, const daft_grid_edge *edges, uint32_t edge,
                    daft_grid_point at, daft_error *error)
{
    const daft_grid_edge *e = &edges[edge];
    if (daft_grid_order(e->a, at) == 0 || daft_grid_order(e->b, at) == 0) return true;
    if (!daft_grow(allocator, &cuts->items, &cuts->capacity, cuts->count + 1, cuts->count, sizeof *cuts->items))
        return daft_fail_memory(error, "an outline's crossings");
    cuts->items[cuts->count++] = (cut){edge, e->b.y > e->a.y, at};
    return true;
}

static int32_t nearest(double value) { return (int32_t)floor(value + 0.5); }

static bool opposite(int64_t a, int64_t b) { return (a < 0 && b > 0) || (a > 0 && b < 0); }

/* Cuts two edges where an end of one lies on the other, or where they cross. */
static bool cut_pair(const daft_allocator *allocator, cut_list *cuts, const daft_grid_edge *edges, uint32_t i,
                     uint32_t j, daft_error *error)
{
    const daft_grid_edge *e = &edges[i], *f = &edges[j];
    const int64_t fa = daft_grid_side(e->a, e->b, f->a), fb = daft_grid_side(e->a, e->b, f->b);
    if ((fa > 0 && fb > 0) || (fa < 0 && fb < 0)) return true;
    const int64_t ea = daft_grid_side(f->a, f->b, e->a), eb = daft_grid_side(f->a, f->b, e->b);
    bool done = true;
    if (fa == 0 && daft_grid_between(e->a, e->b, f->a)) done = done && add_cut(allocator, cuts, edges, i, f->a, error);
    if (fb == 0 && daft_grid_between(e->a, e->b, f->b)) done = done && add_cut(allocator, cuts, edges, i, f->b, error);
    if (ea == 0 && daft_grid_between(f->a, f->b, e->a)) done = done && add_cut(allocator, cuts, edges, j, e->a, error);
    if (eb == 0 && daft_grid_between(f->a, f->b, e->b)) done = done && add_cut(allocator, cuts, edges, j, e->b, error);
    if (!done || !opposite(fa, fb) || !opposite(ea, eb)) return done;
    const double t = (double)ea / (double)(ea - eb);
    const daft_grid_point at = {nearest(e->a.x + (e->b.x - e->a.x) * t), nearest(e->a.y + (e->b.y - e->a.y) * t)};
    return add_cut(allocator, cuts, edges, i, at, error) && add_cut(allocator, cuts, edges, j, at, error);
}

static bool find_cuts(const daft_allocator *allocator, daft_outline *outline, cut_list *cuts, size_t limit,
                      daft_error *error)
{
    const daft_grid_edge *e = outline->edges;
    for (uint32_t i = 0; i < outline->edge_count; i++) {
        const int32_t low = daft_min_i(e[i].a.y, e[i].b.y), high = daft_max_i(e[i].a.y, e[i].b.y);
        uint32_t j = i + 1;
        for (; j < outline->edge_count && e[j].a.x <= e[i].b.x; j++) {
            if (daft_min_i(e[j].a.y, e[j].b.y) > high || daft_max_i(e[j].a.y, e[j].b.y) < low) continue;
            if (!cut_pair(allocator, cuts, e, i, j, error)) return false;
            if (cuts->count > limit) return daft_outline_spend(outline, SIZE_MAX, error);
        }
        if (!daft_outline_spend(outline, j - i, error)) return false;
    }
    return true;
}

/* By edge, along it. */
static int by_place(const void *left, const void *right)
{
    const cut *a = left, *b = right;
    if (a->edge != b->edge) return a->edge < b->edge ? -1 : 1;
    if (a->at.x != b->at.x) return a->at.x < b->at.x ? -1 : 1;
    const int order = (a->at.y > b->at.y) - (a->at.y < b->at.y);
    return a->rises ? order : -order;
}

static bool apply_cuts(const daft_allocator *allocator, daft_outline *outline, cut_list *cuts, daft_error *error)
{
    qsort(cuts->items, cuts->count, sizeof *cuts->items, by_place);
    for (size_t i = 0; i < cuts->count;) {
        const uint32_t number = cuts->items[i].edge;
        const daft_grid_edge whole = outline->edges[number];
        daft_grid_point from = whole.a;
        for (; i < cuts->count && cuts->items[i].edge == number; i++) {
            if (!add_edge(allocator, outline, from, cuts->items[i].at, whole.winding, error)) return false;
            from = cuts->items[i].at;
        }
        if (!add_edge(allocator, outline, from, whole.b, whole.winding, error)) return false;
        outline->edges[number].winding = 0; /* merge_edges drops it */
    }
    return true;
}

static bool cut_edges(const daft_allocator *allocator, daft_outline *outline, size_t limit, daft_error *error)
{
    cut_list cuts = {0};
    bool done = true;
    for (int round = 0;; round++) {
        merge_edges(outline);
        cuts.count = 0;
        done = (round < ROUNDS && outline->edge_count <= limit) || daft_outline_spend(outline, SIZE_MAX, error);
        done = done && find_cuts(allocator, outline, &cuts, limit, error);
        if (!done || cuts.count == 0) break;
        done = apply_cuts(allocator, outline, &cuts, error);
        if (!done) break;
    }
    daft_release(allocator, cuts.items);
    return done;
}

/* ---- windings ---- */

/* The winding number beside the middle of edge `i`: above it, or right of it where it is upright. Edges do not cross,
 * so a ray from the middle, in coordinates twice as fine, meets the others away from it. */
static int32_t winding_beside(const daft_outline *outline, size_t i)
{
    const daft_grid_edge *e = outline->edges;
    const daft_grid_point middle = {e[i].a.x + e[i].b.x, e[i].a.y + e[i].b.y};
    const bool upright = e[i].a.x == e[i].b.x;
    int32_t winding = 0;
    for (size_t j = 0; j < outline->edge_count; j++) {
        if (j == i) continue;
        const daft_grid_point a = {2 * e[j].a.x, 2 * e[j].a.y}, b = {2 * e[j].b.x, 2 * e[j].b.y};
        const int64_t side = daft_grid_side(a, b, middle); /* above zero: the middle is above, or left of what rises */
        if (!upright && a.x > middle.x) break;
        if (!upright && middle.x < b.x && side < 0) winding -= e[j].winding;
        if (upright && a.y <= middle.y && middle.y < b.y && side > 0) winding += e[j].winding;
        if (upright && b.y <= middle.y && middle.y < a.y && side < 0) winding -= e[j].winding;
    }
    return winding;
}

static bool keep_borders(daft_outline *outline, const daft_allocator *allocator, daft_error *error)
{
    /* The inside of each, before any is moved: 1 above or right, 2 below or left. */
    uint8_t *sides = daft_alloc(allocator, outline->edge_count + 1, 1);
    bool done = sides || daft_fail_memory(error, "an outline");
    for (size_t i = 0; done && i < outline->edge_count; i++) {
        const daft_grid_edge *e = &outline->edges[i];
        const int32_t beside = winding_beside(outline, i);
        /* What runs to the right has its left above it; what runs up has its right beside it. */
        const int32_t across = beside + (e->a.x == e->b.x ? e->winding : -e->winding);
        sides[i] = (uint8_t)((beside != 0 ? 1 : 0) | (across != 0 ? 2 : 0));
        done = daft_outline_spend(outline, outline->edge_count, error);
    }
    size_t kept = 0;
    for (size_t i = 0; done && i < outline->edge_count; i++) {
        const daft_grid_edge e = outline->edges[i];
        const bool forward = (sides[i] == 1) != (e.a.x == e.b.x);
        if (sides[i] != 1 && sides[i] != 2) continue;
        outline->edges[kept++] = forward ? e : (daft_grid_edge){e.b, e.a, e.winding};
    }
    outline->edge_count = kept;
    daft_release(allocator, sides);
    return done;
}

bool daft_outline_resolve(const daft_allocator *allocator, daft_outline *outline, size_t limit, daft_error *error)
{
    return cut_edges(allocator, outline, limit, error) && keep_borders(outline, allocator, error);
}
