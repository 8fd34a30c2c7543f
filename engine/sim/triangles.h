/* What meshes and height fields have in common: triangles with numbers, found by bounds, with what lies across their
 * edges. */
#ifndef DAFT_SIM_TRIANGLES_H
#define DAFT_SIM_TRIANGLES_H

#include "sim/manifold.h"

/* ---- triangles (triangles.c) ---- */

/* Counter-clockwise from the front. False for one that is no obstacle: a hole, or without area. */
bool daft_triangle_get(const daft_sim_shape *s, uint32_t triangle, daft_vec3 corners[3]);
/* Unit normal of the front, in double. */
daft_dvec3 daft_triangle_normal(const daft_vec3 corners[3]);
/* The triangle across the edge from corner k to k + 1, and which of its edges that is; false at borders. */
bool daft_triangle_across(const daft_sim_shape *s, uint32_t triangle, uint32_t k, uint32_t *other, uint32_t *other_k);
typedef void daft_triangle_visit(void *context, uint32_t triangle);
/* Calls visit for all triangles whose bounds overlap, and perhaps more, in an order that depends on nothing but the
 * shape. */
void daft_triangles_query(const daft_sim_shape *s, const daft_aabb *bounds, daft_triangle_visit *visit, void *context);

/* Triangles that a box of half extents `reach`, its centre going from `origin` along `direction` to t = *tmax, may
 * meet; nearer ones about first. The visitor may lower *tmax. */
void daft_triangles_sweep(const daft_sim_shape *s, daft_dvec3 origin, daft_dvec3 direction, daft_dvec3 reach,
                          const double *tmax, daft_triangle_visit *visit, void *context);

/* Whether a box moving so meets the box low..high before tmax, both grown by rounding; *enter: when. */
bool daft_sweep_meets(daft_dvec3 origin, daft_dvec3 direction, daft_dvec3 reach, daft_dvec3 low, daft_dvec3 high,
                      double tmax, double *enter);

/* ---- results of several parts ---- */

typedef struct daft_sink {
    daft_manifold *out;
    uint32_t capacity, count;
} daft_sink;

/* Adds; when full, in the place of the shallowest if that is shallower. */
void daft_sink_put(daft_sink *sink, const daft_manifold *m);

/* ---- meshes and fields (mesh_contact.c) ---- */

/* a: convex; b: mesh or field. Contacts of coplanar triangles are one manifold. */
void daft_collide_triangles(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                            daft_sink *sink);

/* ---- compounds ---- */

/* Bounds of a shape whose frame is (r, p), grown by the margin and by rounding. */
daft_aabb daft_bounds_in(const daft_sim_shape *s, const float r[9], daft_dvec3 p, float margin);
/* The next child, from node `from` on, whose bounds overlap: gives the node to go on from, or UINT32_MAX. */
uint32_t daft_compound_query(const daft_compound *c, const daft_aabb *bounds, uint32_t from, uint32_t *child);

#endif
