/* What meshes and height fields have in common: triangles with numbers, found by bounds, with what lies across their
 * edges. */
#ifndef DAFT_SIM_TRIANGLES_H
#define DAFT_SIM_TRIANGLES_H

#include "sim/shape/shape.h"

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

#endif
