/* The inside of hull making: a triangulated hull from points (hull_build.c), which hull.c turns into polygons. */
#ifndef DAFT_SIM_HULL_BUILD_H
#define DAFT_SIM_HULL_BUILD_H

#include "sim/shape/shape.h"

/* Counter-clockwise seen from outside; adjacent[k] is the face across the edge from vertex k to k + 1. */
typedef struct daft_hull_triangle {
    uint32_t vertex[3]; /* numbers of points */
    uint16_t adjacent[3];
} daft_hull_triangle;

typedef struct daft_hull_mesh {
    daft_hull_triangle triangles[DAFT_HULL_MAX_FACES];
    uint32_t count;
    double tolerance; /* what counts as rounding, metres */
    double deviation; /* of the point that sticks out farthest */
} daft_hull_mesh;

/* A closed triangulated convex surface of at most max_vertices points. */
bool daft_hull_build(const daft_allocator *allocator, const daft_vec3 *points, uint32_t count, uint32_t max_vertices,
                     daft_hull_mesh *out, daft_error *error);

#endif
