/* sim: rigid bodies and contacts. Knows shapes, not entities.
 * Promises: the same calls give the same bits on every machine; no NaN ever enters the state; a world without dynamic
 * bodies costs nothing. Dynamic bodies are spheres; static and kinematic ones are spheres and oriented boxes.
 * Fast spheres do not pass through what stands still, and seams between boxes whose faces lie in one plane are not felt.
 * Definitions: sizes 1e-4 to 1e7 m, masses 1e-15 to 1e24 kg, within 1e12 m of the origin, friction and rolling
 * resistance 0 to 1e6, restitution 0 to 1; others are refused. Velocities are clamped to 1e4 m/s and 1e6 rad/s. A call
 * that takes a body which is not there, or a number which is not finite, does nothing. */
#ifndef DAFT_SIM_H
#define DAFT_SIM_H

#include "base/base.h"
#include "math/vec.h"

typedef struct daft_world daft_world;

typedef struct daft_sim_body_def {
    daft_body_kind kind;
    daft_shape shape;      /* sphere or box */
    float radius;          /* sphere */
    daft_vec3 half_extent; /* box */
    daft_dvec3 position;
    daft_quat rotation;
    float density, friction, restitution, rolling_resistance;
    uint32_t user; /* handed back in contacts */
} daft_sim_body_def;

typedef struct daft_sim_state {
    daft_dvec3 position;
    daft_quat rotation;
    daft_vec3 linear, angular; /* m/s, rad/s, world axes */
} daft_sim_state;

typedef struct daft_sim_contact {
    uint32_t user_a, user_b;
    daft_dvec3 point;
    daft_vec3 normal; /* from a to b */
    float impulse;    /* kg·m/s over the step */
} daft_sim_contact;

daft_world *daft_world_create(const daft_allocator *allocator, daft_error *error);
void daft_world_destroy(daft_world *world);
void daft_world_set_gravity(daft_world *world, daft_vec3 gravity);

/* A body is index + 1, reused after removal; 0 means failure. */
uint32_t daft_world_add(daft_world *world, const daft_sim_body_def *def, daft_error *error);
void daft_world_remove(daft_world *world, uint32_t body);
/* For a kinematic body, the change of pose since the last step becomes its velocity in the next, in which it arrives
 * there; then it stands still. Any other body, and one that teleports, is there at once and keeps its velocity. */
void daft_world_set_pose(daft_world *world, uint32_t body, daft_dvec3 position, daft_quat rotation, bool teleport);
/* A kinematic body keeps moving so; a static one does not take it. */
void daft_world_set_velocity(daft_world *world, uint32_t body, daft_vec3 linear, daft_vec3 angular);
void daft_world_get(const daft_world *world, uint32_t body, daft_sim_state *out);
void daft_world_apply_force(daft_world *world, uint32_t body, daft_vec3 force); /* N, over the next step */
void daft_world_apply_impulse(daft_world *world, uint32_t body, daft_vec3 impulse);

/* Advances dt seconds, 0 to 1, in substeps; 0 does nothing. On failure no body has moved. */
bool daft_world_step(daft_world *world, float dt, daft_error *error);
/* Pairs that touched in the last step, one contact each, a before b by index: first those between dynamic bodies, then
 * the others, each in the order of indices. A removed body's are gone. The array stands until the next step or removal.
 */
uint32_t daft_world_contacts(const daft_world *world, const daft_sim_contact **out);
/* Bodies in index order: position, rotation, velocities. */
uint64_t daft_world_hash(const daft_world *world, uint64_t seed);

#endif
