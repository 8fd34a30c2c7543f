/* sim: rigid bodies, contacts and joints. Knows shapes, not entities.
 * Promises: the same calls give the same bits on every machine, for every instruction set and number of threads; no NaN
 * ever enters the state; what rests sleeps and costs nothing, and a world in which nothing moves does nothing; fast
 * bodies do not pass through what stands still; seams between faces that lie in one plane are not felt.
 *
 * Method: substeps of soft constraints, each followed by a relaxation (Catto, "Soft Constraints", GDC 2011, and
 * "Solver2D", 2024; Macklin et al., "Small Steps in Physics Simulation", 2019), solved in colours of independent
 * constraints, in SIMD lanes.
 *
 * Public headers: sim.h shape/shape.h query/query.h character/character.h
 * Inner headers: world.h sleep.h events.h
 *
 * One step (step.c): targets and forces -> broad/ near parts -> contact/ pairs, with manifolds from collide/ -> islands
 * (sleep.c)
 * -> solve/ and joint/ constraints in colours, in substeps (substeps.c) -> sweep.c -> events.c, sleep.c. Bodies are in
 * body.c, the saved state in state.c.
 *
 * Definitions: masses 1e-15 to 1e24 kg, within 1e12 m of the origin, friction and rolling resistance 0 to 1e6,
 * restitution 0 to 1; others are refused. Velocities are clamped to 1e4 m/s and 1e6 rad/s. A call that takes a body,
 * shape or joint which is not there, or a number which is not finite, does nothing.
 *
 * Bodies, shapes and joints are named by index + 1, reused after removal; 0 is none. `user` is the caller's. */
#ifndef DAFT_SIM_H
#define DAFT_SIM_H

#include "base/base.h"
#include "math/vec.h"
#include "sim/shape/shape.h"

typedef struct daft_world daft_world;

/* ---- the world ---- */

daft_world *daft_world_create(const daft_allocator *allocator, daft_error *error);
void daft_world_destroy(daft_world *world);
void daft_world_set_gravity(daft_world *world, daft_vec3 gravity); /* m/s²; wakes everything if it changed */
/* 1 to 16, default 4. More cost more and stretch, sink and drift less. An island at rest that carries many times the
 * weight of its bodies is taken in up to 32, if that is little work and it has no joints; one whose joints hold bodies
 * of very unequal mass, too. */
void daft_world_set_substeps(daft_world *world, int substeps);
/* Workers (1 to 64, default 1) and instruction set (daft_isa_parse; default the best). Neither changes a bit. */
void daft_world_set_workers(daft_world *world, int workers, int isa);
void daft_world_set_sleeping(daft_world *world, bool allowed); /* default true */
/* measure.c: see daft.h. */
daft_sim_measure daft_world_measure(const daft_world *world);

/* ---- shapes of bodies ---- */

enum { DAFT_SIM_MATERIAL_KINDS = 64 };

typedef struct daft_sim_material {
    float friction;             /* Coulomb's coefficient of what slides; two shapes: the geometric mean */
    float static_friction;      /* of what does not slide yet; below friction: the same as friction */
    float restitution;          /* two shapes: the larger */
    float rolling_resistance;   /* fraction of the normal load times the radius that brakes rolling; two: the larger */
    daft_vec3 surface_velocity; /* m/s: the surface moves so in the body's axes, like a conveyor's; two: the difference
                                 */
    uint32_t kind;              /* below DAFT_SIM_MATERIAL_KINDS: for daft_world_set_pair */
} daft_sim_material;

typedef struct daft_sim_shape_def {
    daft_sim_shape shape; /* what it points to must outlive the body */
    daft_vec3 position;   /* in the body */
    daft_quat rotation;
    float density; /* kg/m³ */
    daft_sim_material material;
    uint32_t layers; /* bits: what it is */
    uint32_t mask;   /* bits: what it meets. Two shapes meet where each one's layers have a bit of the other's mask. */
    bool sensor;     /* meets nothing; what enters it and leaves it makes events */
    uint32_t user;
    uint32_t geometry_id; /* of a hull, mesh, field or compound: what daft_world_load is given to find it again */
} daft_sim_shape_def;

daft_sim_shape_def daft_default_sim_shape_def(void); /* a ball of 0.5 m, 1000 kg/m³, friction 0.6, every layer */

/* Where both kinds of material meet, these numbers count instead of the combined ones. Kinds may be equal. */
typedef struct daft_sim_material_pair {
    float friction, static_friction, restitution, rolling_resistance;
} daft_sim_material_pair;
/* NULL: combine again. Fails for kinds or numbers out of range, or without memory. */
bool daft_world_set_pair(daft_world *world, uint32_t kind_a, uint32_t kind_b, const daft_sim_material_pair *pair,
                         daft_error *error);

/* ---- bodies ---- */

typedef struct daft_sim_body_def {
    daft_body_kind kind;
    daft_dvec3 position;
    daft_quat rotation;
    daft_vec3 linear, angular; /* m/s, of the centre of mass; rad/s; world axes */
    const daft_sim_shape_def *shapes;
    uint32_t shape_count;
    float mass;                                           /* kg; 0: from the densities */
    float gravity_scale, linear_damping, angular_damping; /* dampings in 1/s */
    uint32_t locks;                                       /* DAFT_LOCK_… */
    bool bullet;    /* dynamic: does not pass through other dynamic bodies either */
    bool may_sleep; /* default true */
    uint32_t user;
} daft_sim_body_def;

daft_sim_body_def daft_default_sim_body_def(void); /* dynamic, at the origin, no shapes */

typedef struct daft_sim_state {
    daft_dvec3 position; /* of the body's origin */
    daft_quat rotation;
    daft_vec3 linear, angular; /* m/s, of the centre of mass; rad/s; world axes */
} daft_sim_state;

/* A dynamic body needs a shape with mass, other than a sensor. 0 on failure. */
uint32_t daft_world_add(daft_world *world, const daft_sim_body_def *def, daft_error *error);
/* Its joints go with it. */
void daft_world_remove(daft_world *world, uint32_t handle);
uint32_t daft_world_user(const daft_world *world, uint32_t handle);
/* For a kinematic body, the change of pose since the last step becomes its velocity in the next, in which it arrives
 * there; then it stands still. Any other body, and one that teleports, is there at once and keeps its velocity. */
void daft_world_set_pose(daft_world *world, uint32_t handle, daft_dvec3 position, daft_quat rotation, bool teleport);
/* A kinematic body keeps moving so; a static one does not take it. */
void daft_world_set_velocity(daft_world *world, uint32_t handle, daft_vec3 linear, daft_vec3 angular);
void daft_world_get(const daft_world *world, uint32_t handle, daft_sim_state *out);
float daft_world_mass(const daft_world *world, uint32_t handle);                      /* kg; 0: not dynamic */
daft_dvec3 daft_world_centre(const daft_world *world, uint32_t handle);               /* of mass */
void daft_world_apply_force(daft_world *world, uint32_t handle, daft_vec3 force);     /* N, over the next step */
void daft_world_apply_torque(daft_world *world, uint32_t handle, daft_vec3 torque);   /* N·m, over the next step */
void daft_world_apply_impulse(daft_world *world, uint32_t handle, daft_vec3 impulse); /* kg·m/s, at once */
void daft_world_apply_impulse_at(daft_world *world, uint32_t handle, daft_vec3 impulse, daft_dvec3 point);
void daft_world_apply_angular_impulse(daft_world *world, uint32_t handle, daft_vec3 impulse); /* kg·m²/s */
/* Waking wakes the whole island that it belongs to; so does putting to sleep, if it may. */
void daft_world_set_awake(daft_world *world, uint32_t handle, bool awake);
bool daft_world_is_awake(const daft_world *world, uint32_t body);
/* Of all shapes of the body; they may begin or end contacts in the next step. */
void daft_world_set_filter(daft_world *world, uint32_t handle, uint32_t layers, uint32_t mask);

/* ---- joints ---- */

typedef struct daft_sim_joint_def {
    daft_joint_kind kind;
    uint32_t body_a, body_b; /* body_a may be 0: the world itself (drag: always). One of them must be dynamic. */
    daft_dvec3 anchor;       /* in the world, as the bodies stand now; distance: the point on a; drag: on b */
    daft_dvec3 anchor_b;     /* distance: the point on b; drag: the target */
    daft_vec3 axis;          /* hinge, slider, and ball with a cone: in the world, any length */
    bool limit;              /* hinge, slider, distance: lower and upper count; ball: upper is the cone's half angle */
    float lower, upper;      /* from the pose of now; hinge within ±pi; distance: absolute lengths */
    bool motor;              /* hinge, slider; ball: a brake with at most motor_force N·m, friction for ragdolls */
    float motor_speed, motor_force; /* rad/s and N·m, m/s and N; b relative to a */
    bool spring;          /* distance: about `length`; hinge, slider: about 0; ball, fixed: the whole joint gives */
    float hertz, damping; /* of the spring: frequency of the two bodies at it, and damping ratio */
    float length;         /* distance: 0 takes what it is now */
    float break_force, break_torque; /* N, N·m, mean over a step; 0: never */
    bool collide;                    /* the two bodies touch each other still */
    uint32_t user;
} daft_sim_joint_def;

daft_sim_joint_def daft_default_sim_joint_def(void);

typedef struct daft_sim_joint_state {
    uint32_t body_a, body_b, user;
    daft_joint_kind kind;
    daft_dvec3 anchor_a, anchor_b; /* in the world */
    float value;                   /* hinge: angle; slider: displacement; distance: length; ball with a cone: angle */
    float speed;                   /* of value, hinge and slider */
    float force, torque;           /* N, N·m, mean over the last step */
} daft_sim_joint_state;

uint32_t daft_world_add_joint(daft_world *world, const daft_sim_joint_def *def, daft_error *error);
void daft_world_remove_joint(daft_world *world, uint32_t handle); /* makes no event */
bool daft_world_get_joint(const daft_world *world, uint32_t joint, daft_sim_joint_state *out);
void daft_world_set_joint_motor(daft_world *world, uint32_t handle, bool on, float speed, float force);
void daft_world_set_joint_limit(daft_world *world, uint32_t handle, bool on, float lower, float upper);
void daft_world_set_joint_spring(daft_world *world, uint32_t handle, bool on, float hertz, float damping);
void daft_world_set_joint_target(daft_world *world, uint32_t handle, daft_dvec3 target); /* drag */

/* ---- the step, and what came of it ---- */

/* Advances dt seconds, 0 to 1; 0 does nothing. On failure no body has moved. */
bool daft_world_step(daft_world *world, float dt, daft_error *error);

/* A pair of shapes that pressed on each other in the last step or touches after it. First those of bodies that sleep,
 * then the others; each ordered by the numbers of the bodies, then of the shapes. The array stands until the next step
 * or removal. */
typedef struct daft_sim_contact {
    uint32_t body_a, body_b; /* a < b */
    uint32_t user_a, user_b; /* of the bodies */
    uint32_t shape_user_a, shape_user_b;
    daft_dvec3 point; /* of the largest impulse */
    daft_vec3 normal; /* from a to b */
    float impulse;    /* kg·m/s along the normals, over the step */
} daft_sim_contact;
uint32_t daft_world_contacts(daft_world *world, const daft_sim_contact **out);

typedef enum daft_sim_event_kind {
    DAFT_SIM_CONTACT_BEGIN = 1, /* point, normal, impulse, speed */
    DAFT_SIM_CONTACT_END,       /* also of a body that was removed: its number and user are those it had */
    DAFT_SIM_TRIGGER_ENTER,     /* a has the sensor; by the step after that at whose end they overlap */
    DAFT_SIM_TRIGGER_LEAVE,
    DAFT_SIM_JOINT_BREAK, /* joint, user of it; impulse: the force in N or the torque in N·m that broke it */
    DAFT_SIM_JOINT_GONE,  /* it went with one of its bodies */
    DAFT_SIM_SLEEP,       /* body_a */
    DAFT_SIM_WAKE
} daft_sim_event_kind;

typedef struct daft_sim_event {
    daft_sim_event_kind kind;
    uint32_t body_a, body_b, user_a, user_b, shape_user_a, shape_user_b;
    uint32_t joint, joint_user;
    daft_dvec3 point;
    daft_vec3 normal; /* from a to b */
    float impulse;    /* kg·m/s over the step */
    float speed;      /* m/s at which they met along the normal */
} daft_sim_event;

/* What happened in the last step and by calls since the one before it: by kind, then by bodies, shapes, joints. The
 * array stands until the next step, whatever is changed meanwhile. */
uint32_t daft_world_events(const daft_world *world, const daft_sim_event **out);

/* ---- state ---- */

/* Bodies in index order: position, rotation, velocities, sleep. */
uint64_t daft_world_hash(const daft_world *world, uint64_t seed);

/* The whole state as bytes: bodies, contacts with what they keep from step to step, joints, sleep. Loaded, it goes on
 * with the same bits. The bytes are for the same build and byte order. Release with daft_release. */
bool daft_world_save(const daft_world *world, void **bytes, size_t *size, daft_error *error);
/* Hulls, meshes, fields and compounds are not in the bytes: `find` gives them by the geometry_id of their shapes; its
 * result must be of this type. It may be NULL where there are none. */
typedef bool daft_sim_find_shape(void *context, uint32_t geometry_id, daft_geometry type, daft_sim_shape *out);
/* Replaces all that is in the world. On failure (damaged bytes, memory) the world is as it was. Events are empty. */
bool daft_world_load(daft_world *world, const void *bytes, size_t size, daft_sim_find_shape *find, void *context,
                     daft_error *error);

/* Of the last step. */
daft_sim_counters daft_world_counters(const daft_world *world);
daft_sim_times daft_world_times(const daft_world *world);

/* edges.c: see daft_scene_body_edges in daft.h. */
typedef struct daft_sim_edge {
    daft_dvec3 from, to;
    uint32_t user; /* of the body */
    daft_body_kind kind;
    bool awake, sensor;
} daft_sim_edge;
uint32_t daft_world_edges(const daft_world *world, daft_dvec3 centre, float radius, daft_sim_edge *out,
                          uint32_t capacity);

#endif
