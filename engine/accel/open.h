/* Where the rays off a mesh's own triangles are free: for each triangle a cone of directions that leave its front side and meet no
 * other triangle of the mesh, wherever on it they start.
 *
 * What may start there. A point that is seen on the front side (the side of its normals, where the mesh has such), as render/ lifts
 * such points: off the plane by an error, towards the viewer by the same, and up to the tangent planes at the corners. The error is
 * 16·2^-24 of what there is in coordinates, and covers what a place is off by; so a point stands over the triangle's plane and beside its
 * edges by no more than 1.4 errors, nearly all of that along the way that sees it. `margin` bounds what it may be beside them.
 *
 * What follows. A triangle that is nowhere above the plane is not met by a ray upwards. One that shares an edge or a corner, and rises
 * by less than STEEPEST (open.c), lies behind a plane through what is shared, before which all such points stand: seen at an angle at
 * which they would not, they are hidden by it. Others are kept away from by more than the margin. */
#ifndef DAFT_OPEN_H
#define DAFT_OPEN_H

#include "accel/bvh.h"

/* cone[triangle]: the axis in three bytes, signed, from the lowest on; above them the least product of the axis and a direction of length
 * 1 that is in the cone, 1 to 127. Axis 0: there is none. */
typedef struct daft_open {
    uint32_t *cone;
    uint32_t count, found; /* triangles; those up to `found` were looked at, the others have no cone */
    const daft_vec3 *normals; /* the mesh's, as they were */
    float margin;
} daft_open;

void daft_open_drop(daft_bvh *bvh);
size_t daft_open_bytes(const daft_bvh *bvh);

#endif
