/* Contours that may cross each other to borders and triangles. Exact: corners lie on a grid of whole numbers, on which
 * every test of sides is done without rounding. */
#ifndef DAFT_OUTLINE_H
#define DAFT_OUTLINE_H

#include "base/base.h"

/* Coordinates of the grid are at most this, either way: products of two differences then fit a double. */
enum { DAFT_GRID_LIMIT = 1 << 22 };

typedef struct daft_grid_point {
    int32_t x, y;
} daft_grid_point;

/* A line between two corners. While contours are cut up: `a` comes before `b` by x, then y, and `winding` counts the
 * contours that run from a to b, less those that run back. As a border: the inside is on the left of a to b. */
typedef struct daft_grid_edge {
    daft_grid_point a, b;
    int32_t winding;
} daft_grid_edge;

typedef struct daft_outline {
    daft_grid_edge *edges; /* what contours were cut into; then the borders, ring by ring */
    size_t edge_count, edge_capacity;
    uint32_t *ends; /* two a border: the numbers of its corners */
    daft_grid_point *points;
    uint32_t point_count; /* corners, each place once */
    uint32_t *triangles;  /* three corners each, counter-clockwise */
    size_t triangle_count, triangle_capacity;
    uint64_t work; /* tests of two edges that are left */
} daft_outline;

/* Tests of two edges that one outline may take, about a second: a thousand letters take a hundredth of it. */
#define DAFT_OUTLINE_WORK (UINT64_C(1) << 28)

void daft_outline_free(const daft_allocator *allocator, daft_outline *outline);
/* Adds the contour's edges; it closes itself. */
bool daft_outline_add(const daft_allocator *allocator, daft_outline *outline, const daft_grid_point *points,
                      uint32_t count, daft_error *error);
/* Cuts the edges where they cross, leaves those with the inside on one side alone, and turns them round as borders. At
 * most `limit` edges. */
bool daft_outline_resolve(const daft_allocator *allocator, daft_outline *outline, size_t limit, daft_error *error);
/* Orders the borders ring by ring, and fills the points, the borders' ends and the triangles (rings.c). */
bool daft_outline_triangulate(const daft_allocator *allocator, daft_outline *outline, daft_error *error);

static inline int daft_grid_order(daft_grid_point a, daft_grid_point b)
{
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    return (a.y > b.y) - (a.y < b.y);
}

/* Twice the area of a, b, c: above zero where c is on the left of a to b. */
static inline int64_t daft_grid_side(daft_grid_point a, daft_grid_point b, daft_grid_point c)
{
    return (int64_t)(b.x - a.x) * (c.y - a.y) - (int64_t)(b.y - a.y) * (c.x - a.x);
}

/* Of a point on the line: whether it is between the ends. */
static inline bool daft_grid_between(daft_grid_point a, daft_grid_point b, daft_grid_point p)
{
    return daft_grid_order(a, p) * daft_grid_order(p, b) > 0;
}

/* Takes `tests` from what is left to do; false where that is used up. */
bool daft_outline_spend(daft_outline *outline, size_t tests, daft_error *error);

#endif
