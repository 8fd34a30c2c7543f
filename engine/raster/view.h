/* raster: visibility by pencils. A pencil is a bundle of rays through one point, its apex: the camera's rays, the rays
 * towards a point light, the rays towards the sun (the apex lies infinitely far), and what a planar mirror reflects of
 * the camera's (the apex is the mirrored eye). The test of a ray d against a triangle with corners a, b, c relative to
 * the apex,
 *
 *     hit <=> (a × b)·d, (b × c)·d, (c × a)·d have one sign,
 *
 * has cross products that do not depend on the ray:
 * they are set up once for each triangle, and a ray then costs a few multiply-adds. Projected boxes of instances, nodes
 * and triangles only say where to look; every ray is decided by this test.
 *
 *     instances ──bounds.c, bins.c──▶ bins      screen boxes of instances, in tiles, front to back
 *     bins      ──grid/──▶ daft_tile            the nearest instance and triangle of each pixel: camera, planar mirror
 *     points    ──samples/──▶ bits              which points some occluder hides from a light: point, spot, sun
 *
 * Both kinds of sample sets share the pencil and its map from an instance's space (daft_pencil_map), tangents of
 * spheres, boxes of nodes (boxes.h), and the set-up of blocks of triangles in lanes (triangles.h): their corners in
 * view space, extents in the picture, and planes of edges with their error bound. They differ from there on. A grid's
 * rays are computed from their pixel, stand in windows of a register, and ask for the nearest hit, so pixels keep an
 * interval of inverse depth. A light's points are loaded, stand in blocks of neighbours, and ask for any hit nearer to
 * the light, so blocks drop out once they are dark, and depths count from the points' middle, which keeps their
 * precision for a far light; a sun has no inverse depth at all.
 *
 * Measured (AVX-512, one thread): one window test for both, which loads a grid's rays instead of computing them, takes
 * 3 to 10 % of the speed of camera rays, 9 % at a small mesh, without what a light's depths would add; so there are
 * two. Boxes of nodes are intervals in both: tighter ones, around the hull's projection, spare a grid 1 % of its
 * triangles and cost it 2 % of its speed, and cost shadow rays in a room 5 %.
 *
 * Promises: each ray is decided by the exact predicates of math/exact.h, in floats where their error bound allows; a
 * pixel's answer is the nearest hit by daft_pencil_depth, ties to the lower (instance, triangle), and so that of the
 * reference path (daft_reference_tile), whatever the instruction set, threads or order of work.
 *
 * Public headers: view.h raster.h
 * Inner headers: triangles.h boxes.h holes.h masks.h */
#ifndef DAFT_VIEW_H
#define DAFT_VIEW_H

#include "accel/bvh.h"

enum {
    DAFT_TILE = 32, /* pixels a side */
    DAFT_TILE_STRIDE = DAFT_TILE,
    DAFT_TILE_ROWS = DAFT_TILE + 8, /* room for eight rows from the last one on */
    DAFT_TILE_ROOM = DAFT_TILE_ROWS * DAFT_TILE_STRIDE
};
_Static_assert((DAFT_TILE & (DAFT_TILE - 1)) == 0, "places in a tile are split into row and column by shifts");

/* Where the rays of a light's pencil meet, in frame space: a point, or infinitely far in a unit direction. To a point
 * they may end before: nothing hides them so many metres around it, nor on that part of their way before it, nor from
 * where they come into a box, unless it is NULL. */
typedef struct daft_apex {
    bool infinite;
    daft_vec3 at;
    float around, before;
    const daft_slanted_box *box;
} daft_apex;

/* View space: x right, y up, z forward, its origin anywhere on the axis of the pencil. The apex stands at (0, 0,
 * -away); with `parallel` it is infinitely far behind. A grid of pixels has its origin in the apex: the ray of pixel
 * (x, y) is (x + 0.5 - width/2 + shift_x, height/2 - y - 0.5 + shift_y, focal), halves and thirty-seconds, exact in
 * floats; with `turn`, plus that many times (y % 4 - 1.5, x % 4 - 1.5). */
typedef struct daft_pencil {
    daft_vec3 right, up, forward; /* axes, unit, in frame space; nine floats in a row */
    daft_vec3 origin;             /* in frame space; a grid's: 0 */
    float away;
    bool parallel;
    /* of a grid */
    float focal;
    int width, height;
    daft_intersection intersection;
    float shift_x, shift_y; /* of the sample, in pixels, multiples of 1/32 within -0.5..0.5 */
    float turn;             /* 0, or 1/4: of four by four rays each lies in a row and a column of its own */
    float reach; /* how far, in pixels, rays of parts of tiles (daft_tile_part) may lie from these; 0: none are asked
                    for */
} daft_pencil;

/* The map from an instance's space to view space, in double, rounded once. */
daft_affine daft_pencil_map(const daft_pencil *p, const daft_affine *to_frame);

/* The slopes low..high of the rays that touch a sphere in the plane of z and another axis, the sphere being in front of
 * the apex: z > r (Mara and McGuire, "2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere", JCGT 2(2),
 * 2013). */
static inline void daft_sphere_slopes(double c, double z, double r, double *low, double *high)
{
    double t = sqrt(c * c + z * z - r * r);
    *low = (c * t - z * r) / (z * t + c * r);
    *high = (c * t + z * r) / (z * t - c * r);
}

static inline float daft_pencil_turned(int place) { return (float)(place & 3) - 1.5f; }
static inline daft_vec3 daft_pencil_ray(const daft_pencil *p, int x, int y)
{
    return daft_v3((float)x + 0.5f - (float)p->width * 0.5f + p->shift_x + p->turn * daft_pencil_turned(y),
                   (float)p->height * 0.5f - (float)y - 0.5f + p->shift_y + p->turn * daft_pencil_turned(x), p->focal);
}
/* The pixel, not a whole number, that looks straight ahead: column and row. */
static inline double daft_pencil_middle_x(const daft_pencil *p)
{
    return (double)p->width * 0.5 - 0.5 - (double)p->shift_x;
}
static inline double daft_pencil_middle_y(const daft_pencil *p)
{
    return (double)p->height * 0.5 - 0.5 + (double)p->shift_y;
}

/* ---- points that ask for a light ---- */

enum {
    DAFT_SAMPLES = DAFT_TILE * DAFT_TILE,       /* points in a set */
    DAFT_SAMPLES_ROOM = DAFT_SAMPLES + 16,      /* one whole SIMD register past the end */
    DAFT_SAMPLES_WORDS = DAFT_SAMPLES / 32 + 1, /* of a set of bits: point i at bit i % 32 of word i / 32 */
    DAFT_MAX_OCCLUDERS = 256
};

typedef struct daft_points3 {
    const float *x, *y, *z;
} daft_points3;

/* Points in frame space, side by side; arrays have DAFT_SAMPLES_ROOM values. */
typedef struct daft_samples {
    uint32_t count;
    daft_points3 origin;                 /* where shadow rays start */
    daft_points3 outward;                /* geometric normals, unit, towards the viewer */
    const uint32_t *instance, *triangle; /* that the points lie on */
    const uint32_t *pixel;               /* in the tile: neighbours there share a block */
} daft_samples;

#endif
