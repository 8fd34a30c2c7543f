/* Box against box, side by side in lanes (manifold_box_kernel.c). */
#ifndef DAFT_SIM_MANIFOLD_BOX_H
#define DAFT_SIM_MANIFOLD_BOX_H

#include "math/simd/dispatch.h"
#include "sim/collide/manifold_parts.h"

/* A box over this many times as large as the other is cut down, to this many times. */
#define DAFT_BOX_LARGE 4.0f
/* Axes within this fraction of the smaller box's size count as equally good: the first kind, or the cached one, wins.
 */
#define DAFT_BOX_EVEN 1e-3f
/* The reference face reaches this fraction of its width farther when it clips: of boxes of one size that stand on each
 * other the corners are points, whatever the last bits say. */
#define DAFT_BOX_OVERHANG 1e-3f
/* Edges whose angle's square sine is less are parallel: a face has their axis. */
#define DAFT_BOX_PARALLEL 1e-5f
/* An edge that changes by no more along a direction, in metres, does not meet the sides across it. */
#define DAFT_BOX_FLAT 1e-30f
/* A corner of the reference this fraction of the incident face outside of it is taken for within: rather one point
 * twice than none. */
#define DAFT_BOX_SEAM 1e-5f
/* Any direction in which corners of boxes differ. */
#define DAFT_BOX_SLANT 0.37f

/* Where two faces of boxes overlap, a parallelogram (the incident one) over a rectangle, the corners of what they share
 * are among these: its corners 0 to 3, the places where its edges come in and go out of the rectangle, and the
 * rectangle's corners. Deep in each other the faces may miss each other: the corner that is farthest in, then. A
 * point's number is the lowest part of its id. */
enum { DAFT_BOX_ENTER = 4, DAFT_BOX_LEAVE = 8, DAFT_BOX_UNDER = 12, DAFT_BOX_FARTHEST = 16 };

/* Pairs side by side; what is found is along the axes that frames are in. */
typedef struct daft_box_batch {
    double a[12][DAFT_PAIR_LANES], b[12][DAFT_PAIR_LANES]; /* frames: position, rotation */
    bool posed; /* a's centre in b is given, more exact than its frame says: */
    double q[3][DAFT_PAIR_LANES];
    float half_a[3][DAFT_PAIR_LANES], half_b[3][DAFT_PAIR_LANES];
    float margin[DAFT_PAIR_LANES];
    int32_t kind[DAFT_PAIR_LANES]; /* of axis: the cached one, and what is to be cached */
    daft_found_lanes found;
} daft_box_batch;

/* Everything of a lane but the margin and the kind. */
static inline void daft_box_batch_put(daft_box_batch *batch, int lane, const daft_rigid *a, const daft_rigid *b,
                                      daft_vec3 half_a, daft_vec3 half_b)
{
    const double *const place[2] = {&a->p.x, &b->p.x};
    const float *const half[2] = {&half_a.x, &half_b.x};
    for (int k = 0; k < 3; k++) {
        batch->a[k][lane] = place[0][k], batch->b[k][lane] = place[1][k];
        batch->half_a[k][lane] = half[0][k], batch->half_b[k][lane] = half[1][k];
    }
    for (int i = 0; i < 9; i++) batch->a[3 + i][lane] = a->m[i], batch->b[3 + i][lane] = b->m[i];
}

typedef struct daft_box_kernels {
    void (*collide)(daft_box_batch *batch, int count);
} daft_box_kernels;

DAFT_KERNEL_DECLARE(daft_box_kernels, daft_box);

#endif
