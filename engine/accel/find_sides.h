/* What the files that find one-sided triangles share. sides.c has the whole, contact.c what comes too near, winding.c the rest of
 * the decision, cones.c what is made of it. */
#ifndef DAFT_FIND_SIDES_H
#define DAFT_FIND_SIDES_H

#include "accel/sides.h"
#include "geometry/adjacency.h"

enum { DAFT_SIDES_OPEN = 0, DAFT_SIDES_DOUBLE = 1, DAFT_SIDES_TOUCHED = 2 };

typedef struct daft_side_search {
    const daft_allocator *allocator;
    const daft_trimesh *mesh;
    const daft_bvh *bvh;
    daft_adjacency adjacency;
    double pad;      /* corners may be this far from where they are */
    uint8_t *marks;  /* of each triangle: OPEN, nothing is against it yet; DOUBLE, for how edges are; TOUCHED */
} daft_side_search;

/* How far the mesh's corners may be from where they are, without a change of what was found inside it or of its sides. */
double daft_sides_pad(const daft_trimesh *mesh);
/* Marks the triangles that others come within the pad of, or neighbours are folded on. */
void daft_sides_mark_contacts(daft_side_search *search, int threads);
/* Sets the bits of the one-sided triangles among those that are not marked. False: memory is out. */
bool daft_sides_wind(const daft_side_search *search, uint32_t *one_sided);
/* Fills cones, and the looks of patches and of what is made of them, from the blocks' and patches' bits and the balls. False: memory is out. */
bool daft_cones_fill(const daft_bvh *bvh, daft_sides *sides);

void daft_sides_drop(daft_bvh *bvh);
size_t daft_sides_bytes(const daft_bvh *bvh);

static inline daft_dvec3 daft_corner_of(const daft_trimesh *mesh, uint32_t triangle, uint32_t k)
{
    uint32_t vertex = mesh->indices[3 * (size_t)triangle + k];
    return daft_dv3((double)mesh->x[vertex], (double)mesh->y[vertex], (double)mesh->z[vertex]);
}

#endif
