/* sim/query: what a ray, a moving shape, a volume or a point meets in a world. Asks the broad phase's trees, then each
 * shape in its own frame in double, so answers are as good 1e7 m from the origin as at it. Meshes are asked through the
 * same tree of triangles that the renderer draws and casts rays by.
 *
 * Public headers: query.h walk.h
 *
 * Answers depend on where bodies are now, never on the trees' shape: of equal ones the lower body counts, then the
 * lower shape. Asking changes nothing in the state and allocates nothing. Numbers that are not finite or beyond
 * DAFT_SIM_MAX_QUERY, and rays without direction, meet nothing. */
#ifndef DAFT_SIM_QUERY_H
#define DAFT_SIM_QUERY_H

#include "sim/sim.h"

#define DAFT_SIM_MAX_QUERY 1e13 /* m, of positions and motions along each axis */

/* Which shapes are asked. As between two shapes, each side's layers must have a bit of the other's mask. */
typedef struct daft_sim_filter {
    uint32_t layers, mask;
    uint32_t kinds;  /* bits 1 << DAFT_BODY_STATIC, 1 << DAFT_BODY_KINEMATIC, 1 << DAFT_BODY_DYNAMIC */
    uint32_t ignore; /* a body; 0: none */
    bool sensors;    /* whether sensors are met as well */
} daft_sim_filter;

daft_sim_filter daft_default_sim_filter(void); /* everything but sensors */

typedef struct daft_sim_hit {
    uint32_t body, user;
    uint32_t shape; /* of the body, in the order of its definition */
    uint32_t shape_user;
    uint32_t child, triangle; /* of a compound, else 0; of a mesh or field, else DAFT_NO_FEATURE */
    daft_dvec3 point;         /* on the body */
    daft_vec3 normal;         /* unit, of the surface, towards what met it */
    double fraction;          /* casts: of the motion, 0 to 1 */
    double distance;          /* casts: metres along the motion; closest: from the point */
    bool inside;              /* it starts inside, or overlaps at the start; then fraction 0 and the normal is against
                               * the motion, zero where there is none */
} daft_sim_hit;

/* From origin to origin + motion. The nearest hit; `hit` may be NULL. */
bool daft_world_cast_ray(daft_world *world, daft_dvec3 origin, daft_dvec3 motion, const daft_sim_filter *filter,
                         daft_sim_hit *hit);
/* Whether anything is in the way: the same as above, sooner answered. */
bool daft_world_is_blocked(daft_world *world, daft_dvec3 origin, daft_dvec3 motion, const daft_sim_filter *filter);
/* The first hit on each shape, the nearest `capacity` of them in order. Gives how many there are in all. */
uint32_t daft_world_cast_ray_all(daft_world *world, daft_dvec3 origin, daft_dvec3 motion, const daft_sim_filter *filter,
                                 daft_sim_hit *hits, uint32_t capacity);
/* A sphere, capsule, box, hull, or compound of these, moves without turning. Without motion: whether it overlaps. */
bool daft_world_cast_shape(daft_world *world, const daft_sim_shape *shape, daft_dvec3 position, daft_quat rotation,
                           daft_dvec3 motion, const daft_sim_filter *filter, daft_sim_hit *hit);
/* All shapes that one of the kinds above overlaps, ordered by body and shape; points and normals are not set. The first
 * `capacity`; gives how many there are. */
uint32_t daft_world_overlap(daft_world *world, const daft_sim_shape *shape, daft_dvec3 position, daft_quat rotation,
                            const daft_sim_filter *filter, daft_sim_hit *hits, uint32_t capacity);
/* The point of all bodies that is closest to one, no farther than `limit` metres. Inside of a solid shape it is the
 * point itself. */
bool daft_world_closest(daft_world *world, daft_dvec3 point, double limit, const daft_sim_filter *filter,
                        daft_sim_hit *hit);

#endif
