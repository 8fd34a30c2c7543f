/* Balls inside a mesh, and what they say of rays without a look at triangles.
 *
 * What is taken for the inside. The edges of a mesh that are not run along as often one way as the other, each counted as often as
 * it lacks, form closed curves. Those that hang together are put under a cap: the cone over all of them from some point of their
 * box. Mesh and caps together are closed whatever the mesh is, so each point off them has a winding number; one where it is not 0
 * is inside. Each ball here holds points of one such number only, and keeps clear of the boxes of all caps.
 *
 * What follows. The winding number changes along a ray only where it crosses a triangle or a cap. So a ray crosses some
 * triangle between a point in a ball and a point outside of the mesh's bounds, unless it meets a cap's box between these
 * two. That holds for all exact tests and for all that never let a ray through an edge of two triangles:
 * - a shadow ray whose way to the lamp goes through a ball, and through no cap's box from there on, is stopped, where the
 *   lamp is outside of the bounds (daft_inner_is_outside);
 * - a ray from outside of the bounds that goes through a ball, and through no cap's box before, has its first hit before
 *   it leaves the ball.
 * Balls keep a 2^-18th of the mesh's size off all triangles, over what rounding moves corners by. Who moves rays into the mesh's space, or
 * corners out of it, with errors of their own shrinks the balls, grows the caps' boxes and the bounds by them. */
#ifndef DAFT_INNER_H
#define DAFT_INNER_H

#include "accel/bvh.h"

enum { DAFT_INNER_BALLS = 16, DAFT_INNER_CAPS = DAFT_WIDTH };

/* In the mesh's own space. Unused balls have the radius -inf, unused caps an empty box; caps stand as children of a node do. */
typedef struct daft_inner {
    uint32_t count, cap_count;
    _Alignas(64) float centre[3][DAFT_INNER_BALLS];
    float radius[DAFT_INNER_BALLS];
    daft_node caps;
} daft_inner;

/* Whether the point is outside of the mesh's bounds, grown by `pad`. */
static inline bool daft_inner_is_outside(const daft_trimesh *mesh, daft_dvec3 point, double pad)
{
    const double p[3] = {point.x, point.y, point.z};
    bool outside = false;
    for (int k = 0; k < 3; k++)
        outside = outside || p[k] < (double)(&mesh->low.x)[k] - pad || p[k] > (double)(&mesh->high.x)[k] + pad;
    return outside;
}

#endif
