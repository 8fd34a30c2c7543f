/* Spheres and capsules against each other and against boxes, side by side in lanes (manifold_round_kernel.c), by the
 * closest points of their cores. All that is asked of a part lies in its outline, in world axes, so
 * that the many pairs which do not touch cost no look at the records of parts, bodies and touches. */
#ifndef DAFT_SIM_MANIFOLD_ROUND_H
#define DAFT_SIM_MANIFOLD_ROUND_H

#include "math/simd/dispatch.h"
#include "sim/collide/manifold_parts.h"

/* Capsules whose angle's sine is less lie along each other: two points. */
#define DAFT_ROUND_PARALLEL 0.03f
/* The stretch that they share is at least this fraction of half the shorter one. */
#define DAFT_ROUND_SHARED 0.02f
/* Beyond the rim of a face by so little that it counts as over it, if part of the core is: the cosine of the direction
 * there with the face's normal. A face reaches by this fraction of the rounding farther for that. */
#define DAFT_ROUND_ALONG_FACE 0.9999f
#define DAFT_ROUND_OVERHANG   1e-3f
/* Going farther against each other than this fraction of the first part's reach is fast. */
#define DAFT_ROUND_FAST 0.5f
/* Centres nearer than this fraction of it are in one place, and no direction out is better than another. */
#define DAFT_ROUND_ONE_PLACE 0.01f
/* Cores nearer than this fraction of the roundings: rounding blurs the direction. */
#define DAFT_ROUND_NEAR 1e-3f

typedef enum daft_outline_kind { DAFT_OUTLINE_NONE, DAFT_OUTLINE_ROUND, DAFT_OUTLINE_BOX } daft_outline_kind;

typedef enum daft_outline_flag {
    DAFT_OUTLINE_WATCHED = 1, /* its body does not yield, or is a bullet: what is fast looks out for it */
    DAFT_OUTLINE_SPHERE = 2   /* spheres look out for each other, too */
} daft_outline_flag;

/* A sphere, capsule or box where it is as a step begins, and how it goes: a cache line. Lanes load the second half. */
typedef struct daft_outline {
    _Alignas(64) daft_dvec3 centre;
    float reach;   /* no point is farther from the centre */
    uint8_t kind;  /* daft_outline_kind; none: other shapes, and what is not to be asked in lanes */
    bool centred;  /* its centre is its body's centre of mass */
    uint8_t flags; /* bits of daft_outline_flag */
    uint8_t unused;
    daft_vec3 half; /* half of a capsule's core, world axes; 0, of spheres; half edges of a box */
    daft_vec3 move; /* of the body's centre within the step, as fast as it goes now */
    float swing;    /* what the body's turning adds to that, at most */
    float radius;   /* 0, of boxes */
} daft_outline;

enum { DAFT_ROUND_POINTS = 2 };

typedef enum daft_round_state {
    DAFT_ROUND_APART, /* by more than the margin and what they may go within the step */
    DAFT_ROUND_MET,
    DAFT_ROUND_ASK /* one at a time, that is: fast and looking out, deep in each other */
} daft_round_state;

typedef float daft_round_lanes[DAFT_PAIR_LANES] __attribute__((aligned(64)));

typedef struct daft_round_batch {
    int32_t a[DAFT_PAIR_LANES], b[DAFT_PAIR_LANES]; /* outlines; with a box: the round one, the box */
    daft_round_lanes toward[3];                     /* from the centre of the first part to that of the second */
    daft_round_lanes reach, margin;                 /* of the first part; of both */
    daft_round_lanes watched;                       /* 1 where they look out for each other then, else 0 */
    /* With a box: the round one's centre beyond its high and low faces; its axes; 1 where it is the first part, else
     * -1. */
    daft_round_lanes high[3], low[3], turn[9], first;
    int32_t state[DAFT_PAIR_LANES]; /* daft_round_state */
    daft_found_lanes found;         /* along the world's axes, where met: one point or two */
} daft_round_batch;

typedef struct daft_round_kernels {
    void (*rounds)(const daft_outline *outlines, daft_round_batch *batch, int count);
    void (*boxes)(const daft_outline *outlines, daft_round_batch *batch, int count);
} daft_round_kernels;

DAFT_KERNEL_DECLARE(daft_round_kernels, daft_round);

/* Everything of a lane. */
static inline void daft_round_batch_put(daft_round_batch *batch, int lane, const daft_outline *all, uint32_t a,
                                        uint32_t b, float margin)
{
    daft_vec3 toward = daft_to_float(daft_dsub(all[b].centre, all[a].centre));
    for (int k = 0; k < 3; k++) batch->toward[k][lane] = daft_v3_at(toward, k);
    batch->a[lane] = (int32_t)a, batch->b[lane] = (int32_t)b;
    batch->margin[lane] = margin, batch->reach[lane] = all[a].reach;
    bool spheres = all[a].flags & all[b].flags & DAFT_OUTLINE_SPHERE;
    batch->watched[lane] = spheres || (all[a].flags | all[b].flags) & DAFT_OUTLINE_WATCHED ? 1.0f : 0.0f;
}

/* After that, where one is a box. centre: of the round one, in the box; m: the box's rotation. */
static inline void daft_round_batch_put_box(daft_round_batch *batch, int lane, const daft_outline *all,
                                            daft_dvec3 centre, const double m[9], bool box_first)
{
    if (box_first) {
        int32_t box = batch->a[lane];
        batch->a[lane] = batch->b[lane], batch->b[lane] = box;
    }
    const double c[3] = {centre.x, centre.y, centre.z};
    for (int k = 0; k < 3; k++) {
        double h = (double)daft_v3_at(all[batch->b[lane]].half, k);
        batch->high[k][lane] = (float)(c[k] - h), batch->low[k][lane] = (float)(-c[k] - h);
    }
    for (int i = 0; i < 9; i++) batch->turn[i][lane] = (float)m[i];
    batch->first[lane] = box_first ? 1.0f : -1.0f;
}

#endif
