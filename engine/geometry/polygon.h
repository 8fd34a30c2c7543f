/* Polygons to triangles. */
#ifndef DAFT_POLYGON_H
#define DAFT_POLYGON_H

#include "base/base.h"
#include "math/vec.h"

/* Scratch memory for polygons of up to `capacity` corners. */
typedef struct daft_polygon {
    uint32_t capacity;
    daft_dvec3 *points;  /* in: the corners, relative to the first so that large coordinates do not cancel */
    uint32_t *triangles; /* out: 3·(count - 2) corner numbers, with the polygon's winding */
    uint32_t *next, *previous;
    double *u, *v;    /* the corners in the polygon's plane */
    uint32_t *sorted; /* the reflex corners by u */
    uint8_t *reflex;  /* 1: no convex corner of what is left of the polygon */
} daft_polygon;

bool daft_polygon_reserve(const daft_allocator *allocator, daft_polygon *polygon, uint32_t count);
void daft_polygon_free(const daft_allocator *allocator, daft_polygon *polygon);

/* Cuts polygon->points[0 .. count-1] into count - 2 triangles: quads along the diagonal that folds no triangle over,
 * convex polygons as a fan, others by clipping ears. The signed area is kept always, the plain area where the polygon
 * does not cross itself. Time: 4,096 point tests a corner at most; returns false where that ran out and the rest was
 * cut without looking. */
bool daft_polygon_triangulate(daft_polygon *polygon, uint32_t count);

#endif
