/* Triangles clipped to the cells of the kd-tree. */
#ifndef DAFT_CLIP_H
#define DAFT_CLIP_H

#include "geometry/mesh.h"

/* A triangle, and bounds of the part of it that is meant. */
typedef struct daft_part {
    float low[3];
    uint32_t triangle;
    float high[3];
} daft_part;

/* Of a whole triangle. */
daft_part daft_part_of(const daft_trimesh *mesh, uint32_t triangle);
/* Bounds of what of it lies on one side of a plane, rounded outward and no larger than they were; the plane cuts the
 * bounds. */
void daft_part_clip(const daft_trimesh *mesh, daft_part *part, int axis, float at, bool below);

#endif
