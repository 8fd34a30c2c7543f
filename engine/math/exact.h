/* Exact predicates and the depth that both visibility paths agree on.
 *
 * A pencil's rays start at the origin: a ray d meets triangle (a, b, c) where d = λa·a + λb·b + λc·c with all λ > 0,
 * and the λ have the signs of det(b, c, d), det(c, a, d), det(a, b, d), each over det(a, b, c). The kernels decide
 * these signs in floats where a bound on the error allows it and come here where it does not. */
#ifndef DAFT_EXACT_H
#define DAFT_EXACT_H

#include "math/vec.h"

/* The sign (-1, 0, 1) of det(a, b, c) = c·(a×b), exactly, for finite floats. Shewchuk, "Adaptive Precision
 * Floating-Point Arithmetic and Fast Robust Geometric Predicates" (1997): double with an error bound, then an exact
 * expansion. */
int daft_det_sign(daft_vec3 a, daft_vec3 b, daft_vec3 c);

/* The side of the plane through the origin, a and b on which the ray d lies. A ray exactly in the plane is moved by
 * (ε, ε², ε³), ε -> 0, so that of the triangles around an edge or a vertex exactly one is hit (Edelsbrunner and Mücke,
 * "Simulation of Simplicity", 1990). 0 only where a and b are parallel. daft_ray_side(b, a, d) = -daft_ray_side(a, b,
 * d). */
int daft_ray_side(daft_vec3 a, daft_vec3 b, daft_vec3 d);

/* Whether the line through o along d hits the triangle, in front of o or behind, exactly: all points as given, a - o
 * not rounded. Lines exactly through an edge are moved as above, so crossings of a closed mesh are even in number. */
bool daft_line_hits(daft_vec3 o, daft_vec3 a, daft_vec3 b, daft_vec3 c, daft_vec3 d);

/* The same for the closed triangle: a line exactly through an edge or a vertex touches all triangles there, and so also
 * one whose edge belongs to no other. What a line hits it touches. */
bool daft_line_touches(daft_vec3 o, daft_vec3 a, daft_vec3 b, daft_vec3 c, daft_vec3 d);

/* Whether the ray d from the origin hits the triangle, decided by the two predicates above. Edge-on triangles are
 * missed. */
bool daft_pencil_hits(daft_vec3 a, daft_vec3 b, daft_vec3 c, daft_vec3 d);

/* The weights of the corners at the point where a ray that hits meets the triangle, in double: the three determinants
 * over their sum; negative ones, which are rounding errors, count as 0. They are 0 or more and add up to 1. */
void daft_pencil_weights(daft_dvec3 a, daft_dvec3 b, daft_dvec3 c, daft_vec3 d, double weight[3]);

/* The z of that point: always within the corners' range of z. */
double daft_pencil_depth(daft_vec3 a, daft_vec3 b, daft_vec3 c, daft_vec3 d);

/* A ray from the origin against a sphere: false for a miss; else *t in units of d, of the nearest hit in front. The
 * discriminant is r² - |centre - projection|², which does not cancel (Haines et al., "Precision Improvements for
 * Ray/Sphere Intersection", Ray Tracing Gems 2019, chapter 7). */
bool daft_pencil_sphere(daft_vec3 centre, float radius, daft_vec3 d, double *t);

#endif
