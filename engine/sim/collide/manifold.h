/* sim/collide: where two shapes touch: a normal and up to four points for every pair of convex parts, by the
 * separating-axis test and clipping (Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013; "Robust
 * Contact Creation for Physics Simulations", GDC 2015; Catto, Box2D v3). Stateless but for a small cache that the
 * caller keeps with the pair.
 *
 * Public headers: manifold.h manifold_box.h manifold_round.h
 *
 * Precision. Everything is computed in a's frame, in float, near a: pass the dynamic (or smaller) body as a. b may be a
 * box of 1,000 m or a mesh of 10 km: its faces are brought near to a in double first, so a small box on it rests
 * without noise.
 *
 * Meshes, fields and compounds give several manifolds. Contacts on inner edges of a mesh are corrected by what lies
 * across the edge, so that nothing trips over them. Across bodies the caller has to see to that (contact/ghost.c). */
#ifndef DAFT_SIM_MANIFOLD_H
#define DAFT_SIM_MANIFOLD_H

#include "sim/shape/shape.h"

/* b as seen from a, and a's origin as seen from b. */
typedef struct daft_relpose {
    float r[9];   /* row-major: b's axes are its columns, in a */
    daft_dvec3 p; /* b's origin, in a's frame */
    daft_dvec3 q; /* a's origin, in b's frame */
} daft_relpose;

daft_relpose daft_relpose_make(const daft_rigid *a, const daft_rigid *b);
daft_relpose daft_relpose_swapped(const daft_relpose *pose);

/* Points whose ids are equal in two steps are the same for warm starting. */
typedef struct daft_manifold_point {
    daft_vec3 point;  /* a's frame, midway between both surfaces */
    float separation; /* metres along the normal; negative: overlap */
    uint32_t id;      /* of the features that made it; unique within a manifold */
} daft_manifold_point;

enum { DAFT_MANIFOLD_POINTS = 4 };

typedef struct daft_manifold {
    daft_vec3 normal; /* unit, a's frame, from a to b */
    uint32_t count;   /* 1 to 4 points */
    daft_manifold_point points[DAFT_MANIFOLD_POINTS];
    daft_shape_part part_a, part_b;
} daft_manifold;

/* Zero at first; kept with the pair: which sort of axis was best, which holds among equally good ones. It only makes
 * results steadier: those with any content are right. */
typedef struct daft_pair_cache {
    uint8_t kind;
} daft_pair_cache;

/* Manifolds of all parts that are within `margin` metres of each other, at most `capacity` (the deepest where there are
 * more), in the order of part_a, part_b. Gives how many. a: convex or a compound of convex; b: anything. cache may be
 * NULL and is used by pairs of convex shapes. */
uint32_t daft_collide(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *b_in_a, float margin,
                      daft_manifold *out, uint32_t capacity, daft_pair_cache *cache);

#endif
