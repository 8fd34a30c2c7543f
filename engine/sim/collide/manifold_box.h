/* Box against box: what the one-at-a-time code (manifold_box.c) and the one in lanes (manifold_box_kernel.c) share.
 * Both do the same in the same order, so they give the same bits. */
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

static inline float daft_box_largest(const float *h)
{
    float m = h[0] > h[1] ? h[0] : h[1];
    return h[2] > m ? h[2] : m;
}

enum { DAFT_BOX_LANES = 16 };

/* Pairs side by side, as daft_collide_boxes takes them; points and normals go to world axes. */
typedef struct daft_box_batch {
    double a[12][DAFT_BOX_LANES], b[12][DAFT_BOX_LANES]; /* frames: position, rotation */
    float half_a[3][DAFT_BOX_LANES], half_b[3][DAFT_BOX_LANES];
    float origin[3][DAFT_BOX_LANES]; /* added to points: a's origin, in world axes */
    float margin[DAFT_BOX_LANES];
    int32_t kind[DAFT_BOX_LANES]; /* of axis: the cached one, and what is to be cached */
    float clearance[DAFT_BOX_LANES];
    int32_t count[DAFT_BOX_LANES]; /* points; 0: no manifold */
    float normal[3][DAFT_BOX_LANES];
    float point[DAFT_MANIFOLD_POINTS][3][DAFT_BOX_LANES], separation[DAFT_MANIFOLD_POINTS][DAFT_BOX_LANES];
    int32_t id[DAFT_MANIFOLD_POINTS][DAFT_BOX_LANES];
} daft_box_batch;

/* Everything of a lane but the margin and the kind. */
static inline void daft_box_batch_put(daft_box_batch *batch, int lane, const daft_rigid *a, const daft_rigid *b,
                                      daft_vec3 half_a, daft_vec3 half_b, daft_vec3 origin)
{
    const double *const place[2] = {&a->p.x, &b->p.x};
    const float *const half[2] = {&half_a.x, &half_b.x};
    for (int k = 0; k < 3; k++) {
        batch->a[k][lane] = place[0][k], batch->b[k][lane] = place[1][k];
        batch->half_a[k][lane] = half[0][k], batch->half_b[k][lane] = half[1][k];
        batch->origin[k][lane] = daft_v3_at(origin, k);
    }
    for (int i = 0; i < 9; i++) batch->a[3 + i][lane] = a->m[i], batch->b[3 + i][lane] = b->m[i];
}
static inline daft_vec3 daft_box_batch_get(float lanes[3][DAFT_BOX_LANES], int lane)
{
    return daft_v3(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
}

typedef struct daft_box_kernels {
    void (*collide)(daft_box_batch *batch, int count);
} daft_box_kernels;

DAFT_KERNEL_DECLARE(daft_box_kernels, daft_box);

#endif
