/* Which triangles of a mesh meet at its edges, and whether they close it. */
#ifndef DAFT_ADJACENCY_H
#define DAFT_ADJACENCY_H

#include "geometry/mesh.h"

#define DAFT_ACROSS_NONE UINT32_MAX       /* of a triangle with two corners in one place */
#define DAFT_ACROSS_MANY (UINT32_MAX - 1) /* not one triangle that runs along the edge the other way, but none or more */

typedef struct daft_adjacency {
    uint32_t *place;  /* of each vertex: the first vertex in its place */
    uint32_t *across; /* 3·triangle_count: what lies across the edge from each corner to the next: a triangle, or as above */
    bool closed;      /* every edge is run along as often one way as the other: the mesh is the boundary of something */
} daft_adjacency;

/* O(n log n) in time whatever the mesh, and linear in memory. False: memory is out, and there is nothing to free. */
bool daft_adjacency_make(const daft_allocator *allocator, const daft_trimesh *mesh, daft_adjacency *out);
void daft_adjacency_free(const daft_allocator *allocator, daft_adjacency *adjacency);

#endif
