/* Distance of two convex cores, in double: what distance.c and cast.c are built on. */
#ifndef DAFT_SIM_GJK_H
#define DAFT_SIM_GJK_H

#include "sim/shape/triangles.h"

/* A convex core in its own frame: the corners of a box, or a list of points; and a rounding. */
typedef struct daft_proxy {
    bool is_box;
    daft_vec3 half;
    const daft_vec3 *points; /* of a hull; NULL: own */
    uint32_t count;
    daft_vec3 own[3]; /* a point, a segment, a triangle */
    double radius;
} daft_proxy;

daft_proxy daft_proxy_of(const daft_sim_shape *convex);
daft_proxy daft_proxy_triangle(const daft_vec3 corners[3]);

typedef struct daft_gjk {
    double distance;       /* of the cores; 0: they overlap */
    daft_dvec3 on_a, on_b; /* on the cores, a's frame */
    daft_dvec3 normal;     /* unit, from a to b; undefined where the distance is 0 */
} daft_gjk;

/* b_in_a: b's frame in a's. False, early, where the cores are farther apart than `limit`. */
bool daft_gjk_distance(const daft_proxy *a, const daft_proxy *b, const daft_rigid *b_in_a, double limit, daft_gjk *out);

#endif
