/* The inside of sim: the world's records, for all of the room's inner rooms.
 *
 * Data. A world is arrays of records under indices:
 *   body    what it is, where, how fast; its parts, pairs and joints hang on it as lists of indices
 *   part    one shape of a body: a leaf in the tree of the body's kind, in bounds that are wider than it (fat)
 *   pair    two parts whose bounds over the step meet, with the manifolds they have and the impulses these
 *           carry over to the next step. Part a's body is dynamic, except in pairs of sensors; normals point from
 *           a to b.
 *   joint   two bodies, a frame in each, and the impulses it carries over
 *
 * A body is active if it is dynamic and awake, or kinematic and moves. Only what is active is in a list that a step
 * walks: `awake`, `movers`, and the active list, of pairs that have an active side, in the order of their keys. A body
 * that sleeps is on a ring with those that fell asleep with it, and is woken with them.
 *
 * A step (step.c): bounds and near pairs (broad.c, groups.c, pairs.c) -> manifolds (contacts.c) -> islands that are met
 * wake (sleep.c) -> colours (colour.c) -> substeps (substeps.c, contact_kernel.c, joint_kernel.c, motion_kernel.c,
 * angular.c) -> sweeps (sweep.c), poses -> events (events.c) -> islands fall asleep (sleep.c).
 *
 * Everything a step computes is a function of bodies, pairs and joints under their indices: never of the tree's
 * shape, the order of lists, addresses, threads or time. So state can be saved as these records (state.c). */
#ifndef DAFT_SIM_WORLD_H
#define DAFT_SIM_WORLD_H

#include "sim/broad/tree.h"
#include "sim/collide/manifold.h"
#include "sim/collide/manifold_round.h"
#include "sim/sim.h"

#include <stddef.h>

enum {
    DAFT_SIM_SUBSTEPS = 4,
    DAFT_SIM_MAX_SUBSTEPS = 16,
    /* Pairs between dynamic parts that one part may own; the smaller one does, the one of lower index where they are
     * equal. Twelve equal spheres can touch one, so only overlap meets this bound; it keeps thousands of bodies in one
     * spot from making millions of pairs. */
    DAFT_SIM_MAX_PARTNERS = 32,
    DAFT_SIM_JOINED_PLACES = 64, /* bits of a body's `joined` */
    DAFT_SIM_MAX_MANIFOLDS = 24  /* of one pair, with a mesh, field or compound */
};

/* Bounds that keep every float of the solver finite. Velocities beyond are clamped, definitions beyond refused. */
#define DAFT_SIM_MAX_SPEED         1e4f /* m/s */
#define DAFT_SIM_MAX_ANGULAR_SPEED 1e6f /* rad/s */
#define DAFT_SIM_MAX_ACCELERATION  1e9f /* m/s² */
#define DAFT_SIM_MAX_DISTANCE      1e12 /* m from the origin */
#define DAFT_SIM_MIN_MASS          1e-15
#define DAFT_SIM_MAX_MASS          1e24
#define DAFT_SIM_MAX_DT            1.0f
#define DAFT_SIM_FINEST            1e6f /* substeps a second that are asked for */

/* Points up to this far apart, as a fraction of the smaller part's reach, get a contact even where nothing moves:
 * another contact may push one into the other. Never more than the second, in metres. */
#define DAFT_SIM_MARGIN     0.02f
#define DAFT_SIM_MAX_MARGIN 0.02f

/* ---- records ---- */

typedef struct daft_sim_list {
    uint32_t *items;
    size_t count, capacity;
} daft_sim_list;

typedef struct daft_sim_part {
    /* What contacts and new pairs look at first: */
    _Alignas(64) daft_sim_shape shape;
    float reach; /* no point is farther from the part's origin */
    bool round;  /* sphere or capsule */
    bool posed;  /* pose is not the identity */
    bool sensor;
    bool dynamic;  /* its body is */
    uint32_t body; /* DAFT_SIM_NONE: a free slot */
    uint32_t layers, mask;
    uint32_t owned;      /* pairs counted against DAFT_SIM_MAX_PARTNERS */
    uint32_t moved_slot; /* in the list of those that were placed since the last step */
    uint32_t next;       /* part of the body, in the order of its definition; the next free slot */

    daft_rigid pose; /* in the body */
    daft_vec3 place; /* the same as it was given, */
    daft_quat turn;
    daft_sim_material material;
    float density;
    uint32_t user, geometry_id;
    uint32_t leaf;
    daft_vec3 middle; /* in the part: of a ball within it, */
    float inner;      /* its radius; 0: a surface */
    float roll;       /* radius that rolling resistance counts with */
} daft_sim_part;

/* What a step asks for at the same time lies together, in cache lines of 64 bytes; what it hardly asks for comes last.
 */
typedef struct daft_sim_body {
    _Alignas(64) daft_body_kind kind; /* DAFT_BODY_NONE: a free slot */
    bool bullet, may_sleep;
    bool asleep;        /* dynamic */
    bool round;         /* all three moments are equal */
    uint32_t list_slot; /* in awake or movers, or DAFT_SIM_NONE */
    uint32_t state;     /* in this step's solver; 0: does not move */
    daft_vec3 linear, angular;
    float extent; /* no point is farther from the centre of mass */
    float inv_mass;
    uint32_t first_part, first_pair; /* pair: index · 2 + side */
    float rest;                      /* seconds it has hardly moved */
    float h;                         /* s: of the last substep it took, to which impulses belong; 0: none yet */

    daft_dvec3 centre;    /* of mass */
    float substep_demand; /* substeps a second that what it carries asks for (substep_rate.c) */
    float inner;          /* least of its parts': a move up to this is not swept */
    daft_quat rotation;
    float gravity_scale;
    uint32_t locks;

    daft_rigid frame;        /* position and rotation */
    daft_vec3 force, torque; /* over the next step */
    float linear_damping, angular_damping;

    daft_dvec3 position;
    daft_vec3 moments; /* principal, kg·m² */
    daft_quat axes;    /* principal axes, in the body */
    daft_vec3 local_centre;

    uint32_t user;
    uint32_t first_joint; /* index · 2 + side */
    uint64_t joined;      /* bit k: a joint keeps it from touching the body k + 1 places after it (joint.c) */
    float wanted_mass;    /* as defined; 0: from densities */
    float mass;
    daft_dvec3 target_position; /* kinematic bodies with has_target: the pose at the end of the next step */
    daft_quat target_rotation;
    bool has_target;
    bool follows;         /* the velocity came from a target, so it ends with the step */
    bool ball;            /* a part is a sphere */
    bool joined_far;      /* a joint keeps it from touching a body more than 64 places from it */
    uint32_t fixed_pairs; /* scratch of ghost.c: pairs with what does not yield */
    uint32_t next_free;
    uint32_t ring;          /* asleep: the next body that fell asleep with it */
    daft_vec3 gone, turned; /* lately (sleep.c), if `rest` is not 0 */
} daft_sim_body;

typedef struct daft_sim_manifold_point {
    daft_vec3 anchor; /* from a's centre of mass, world axes */
    float separation;
    uint32_t id;
    float impulse; /* of the last substep; the next step starts with it */
} daft_sim_manifold_point;

typedef struct daft_sim_manifold {
    uint32_t count;
    daft_vec3 normal;
    daft_sim_manifold_point points[DAFT_MANIFOLD_POINTS];
    daft_vec3 friction_impulse, rolling_impulse; /* world axes */
    float twist_impulse;
    /* How far b's surface was dragged along a's since it last slid, and turned about the normal: what sticks is drawn
     * back by it, so that a stack does not creep. */
    daft_vec3 slip;
    float twist_slip;
    float load;          /* N, along the normal, lately (substep_rate.c) */
    float total_impulse; /* normal, summed over the step */
    float speed;         /* with which they met, 0 or more */
    daft_shape_part part_a, part_b;
    daft_vec3 shift; /* of a against b until they meet, if they are apart still */
    bool shared; /* with others of one floor that a stands on: they do not yield, and are of one height and friction */
} daft_sim_manifold;

typedef struct daft_sim_pair {
    uint32_t part_a, part_b; /* part_a == DAFT_SIM_NONE: a free slot */
    uint32_t body_a, body_b;
    bool sensor;
    bool active;
    bool owned_by_a;
    bool touching;         /* as events tell it */
    bool materials_cached; /* what follows from the parts' materials: found when it first has manifolds */
    bool surface_moves;    /* a side is a surface with a velocity of its own */
    uint32_t manifold_count;
    daft_pair_cache cache;
    uint32_t next[2], previous[2]; /* in the lists of body a and b; next[0] of free slots: the next one */
    float friction, static_friction, restitution, rolling; /* rolling in metres */
    daft_sim_manifold own;
    daft_sim_manifold *more; /* DAFT_SIM_MAX_MANIFOLDS of them where a part is not convex */
} daft_sim_pair;

/* In eights of floats, which lanes take and give back at once. */
typedef struct daft_sim_joint {
    _Alignas(32) daft_joint_kind kind; /* 0: a free slot */
    uint32_t body[2];                  /* DAFT_SIM_NONE: the world */
    bool limit, motor, spring, collide;
    float break_force, break_torque;
    float force, torque; /* of the last step */

    daft_dvec3 fixed; /* the anchor in the world, or the drag's target */
    uint32_t next[2];

    daft_quat frame[2]; /* x: the axis; in the body */

    daft_vec3 anchor[2]; /* in the body, from its centre of mass; the world: unused */
    float lower, upper;

    /* of the last substep: linear, angular, and along the axis: low, high, motor, spring */
    daft_vec3 linear_impulse, angular_impulse;
    float lower_impulse, upper_impulse;

    daft_vec3 spin[2]; /* angular velocities as the last substep began */
    float motor_impulse, spring_impulse;

    float motor_speed, motor_force, hertz, damping, length;
    uint32_t user, previous[2];
} daft_sim_joint;

/* An entry of the active list: a pair that has an active side, and what the whole step asks of it, so that its record
 * is left alone. */
typedef struct daft_sim_active {
    uint64_t key; /* part a, then part b */
    uint32_t pair, body_a, body_b;
    uint16_t points;
    uint8_t manifolds, flags;
} daft_sim_active;

enum {
    DAFT_SIM_OVERLAPS = 1, /* it has manifolds, or is touching as events tell it; none of the others without this one */
    DAFT_SIM_FIXED = 2,    /* it has manifolds, and b does not yield */
    DAFT_SIM_JOINS = 4,    /* it has manifolds, and both yield */
    DAFT_SIM_DEEP = 8,     /* a overlaps by so much that it is no load which presses them together (substep_rate.c) */
    DAFT_SIM_DEPENETRATES = 16, /* they were made so, or were too fast: they are to part slowly (colour.c) */
    DAFT_SIM_STIFF = 32,        /* at rest, and carries many times the lighter's weight (substep_rate.c) */
    DAFT_SIM_CHANGED = 64,      /* it began or ended in this step (events.c) */
    DAFT_SIM_REPORTED = 128     /* it is among the contacts that the step tells (events.c) */
};

typedef struct daft_sim_active_list {
    daft_sim_active *items;
    size_t count, capacity;
} daft_sim_active_list;

typedef struct daft_sim_event_list {
    daft_sim_event *items;
    size_t count, capacity;
} daft_sim_event_list;

typedef struct daft_sim_solver daft_sim_solver; /* solver.h: scratch of a step */

/* What a step may forget: no result depends on what this holds as a step begins. */
typedef struct daft_sim_step_scratch {
    daft_region *region; /* during a step that is worth several workers */
    daft_sim_solver *solver;
    bool *left; /* broad.c: of bodies that are awake, which have left their fat bounds */
    size_t left_capacity;
    daft_sim_list astray;     /* broad.c: parts that are to enter their tree anew */
    daft_sim_key *group_keys; /* groups.c: of putting them together */
    size_t group_key_capacity;
    uint64_t *candidates, *ordered; /* keys of near pairs; of ordering them */
    size_t candidate_count, candidate_capacity, ordered_capacity;
    daft_sim_active_list sorting; /* of the active list: room for twice as many */
    daft_sim_list ghosts;         /* ghost.c: bodies that overlap what does not yield */
    uint32_t *island_parents;     /* sleep.c: of each body that is awake, its parent in the union-find */
    size_t island_capacity;
} daft_sim_step_scratch;

struct daft_world {
    /* ---- options ---- */
    daft_allocator allocator;
    int workers, isa;

    /* ---- state: what is saved; hashed are the bodies' poses and velocities ---- */
    daft_vec3 gravity;
    int substeps;
    bool sleeping;
    daft_sim_material_pair *material_pairs; /* DAFT_SIM_MATERIAL_KINDS²; friction < 0: none. NULL: none at all */
    daft_sim_body *bodies;
    size_t body_capacity;
    uint32_t body_count, free_body, live_bodies; /* count: high-water mark */
    daft_sim_part *parts;
    size_t part_capacity;
    uint32_t part_count, free_part;
    daft_sim_bounds *fat;   /* of each part: as it stands in the tree */
    daft_sim_bounds *tight; /* where it may be during this step, and the margin; of what stands still: where it is */
    size_t fat_capacity, tight_capacity;
    daft_sim_pair *pairs;
    size_t pair_capacity;
    uint32_t pair_count, free_pair, live_pairs;
    daft_sim_joint *joints;
    size_t joint_capacity;
    uint32_t joint_count, free_joint, live_joints;
    daft_sim_list awake;  /* dynamic bodies */
    daft_sim_list movers; /* kinematic bodies with a target or a velocity */
    daft_sim_list moved;  /* parts that were placed since the last step */

    /* ---- what follows from the state, kept up with it, made anew when a world is loaded ---- */
    uint32_t asleep_count;       /* bodies */
    daft_sim_active_list active; /* in the order of keys, if it is `sorted` */
    bool sorted;
    bool unallocated;                           /* some active pair needs room for manifolds */
    daft_sim_tree trees[DAFT_BODY_DYNAMIC + 1]; /* one for each kind */
    uint64_t changes;                           /* counts steps and changes of the trees, from 1 on */
    uint64_t settled_at;                        /* of which the trees have all parts where they are (broad.c) */
    daft_outline *outlines;                     /* of each part, as the step begins; */
    daft_rigid *box_frames;                     /* of boxes only (outline.c) */
    size_t outline_capacity, box_frame_capacity;
    uint32_t *slots; /* of each part: its place in the groups, or DAFT_SIM_NONE */
    size_t slots_capacity;
    /* Parts of what is active, or was placed since the last step, in groups (groups.h). */
    struct daft_sim_group *groups;
    struct daft_sim_boxes *group_boxes; /* their bounds, side by side */
    size_t group_capacity, group_box_capacity;
    daft_dvec3 group_origin;      /* their floats are from here */
    uint32_t slot_count, grouped; /* slots up to the last one taken; parts in them */
    uint32_t slots_late;          /* taken since they were put together */
    bool newcomers;               /* some may not be in their group yet */
    double group_size; /* the sum of their sizes, when they were put together; 0: unknown; -1: they have grown too much
                        */

    /* ---- what the last step, and calls since, tell ---- */
    daft_sim_contact *report; /* first the contacts of what sleeps, made anew when some fell asleep or woke */
    size_t report_count, report_capacity, report_asleep;
    bool sleep_changed;
    bool untold; /* the other contacts of the last step are flagged in the active list, and not in the report yet */
    daft_sim_event_list events, pending; /* of the last step; of calls since */
    bool lost_event;                     /* memory was out: the next step says so */
    daft_sim_counters counters;
    daft_sim_times times;

    daft_sim_step_scratch scratch;
};

/* ---- small things ---- */

static inline const daft_sim_body *daft_sim_find(const daft_world *world, uint32_t body)
{
    if (body == 0 || body > world->body_count) return NULL;
    const daft_sim_body *found = &world->bodies[body - 1];
    return found->kind == DAFT_BODY_NONE ? NULL : found;
}
static inline bool daft_sim_is_active(const daft_sim_body *body) { return body->list_slot != DAFT_SIM_NONE; }
static inline daft_sim_manifold *daft_sim_manifolds(daft_sim_pair *pair)
{
    return pair->more ? pair->more : &pair->own;
}
/* Pairs of what is not convex have many manifolds; this one has no room for them yet. */
static inline bool daft_sim_is_unallocated(const daft_world *world, const daft_sim_pair *pair)
{
    return !pair->more && !pair->sensor &&
           !(daft_shape_is_convex(&world->parts[pair->part_a].shape) &&
             daft_shape_is_convex(&world->parts[pair->part_b].shape));
}
static inline uint64_t daft_sim_pair_key(const daft_sim_pair *pair)
{
    return (uint64_t)pair->part_a << 32 | pair->part_b;
}
static inline daft_dvec3 daft_sim_dmin(daft_dvec3 a, daft_dvec3 b)
{
    return daft_dv3(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}
static inline daft_dvec3 daft_sim_dmax(daft_dvec3 a, daft_dvec3 b)
{
    return daft_dv3(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}
static inline float daft_sim_min(float a, float b) { return a < b ? a : b; }
static inline float daft_sim_max(float a, float b) { return a > b ? a : b; }
static inline bool daft_sim_is_zero(daft_vec3 v) { return v.x == 0 && v.y == 0 && v.z == 0; }

/* A vector without what the body's locks forbid: of its position, or of its rotation. Bodies that are not dynamic take
 * no notice. */
static inline daft_vec3 daft_sim_unlocked(const daft_sim_body *body, daft_vec3 v, uint32_t lock_x)
{
    uint32_t locks = body->kind == DAFT_BODY_DYNAMIC ? body->locks / lock_x : 0;
    return daft_v3(locks & 1 ? 0 : v.x, locks & 2 ? 0 : v.y, locks & 4 ? 0 : v.z);
}

/* A vector no longer than `limit`; NaN components become -limit first. */
daft_vec3 daft_sim_clamp_far(daft_vec3 v, float limit);
static inline daft_vec3 daft_sim_clamp(daft_vec3 v, float limit)
{
    return daft_dot(v, v) < 0.25f * limit * limit ? v : daft_sim_clamp_far(v, limit); /* most are far from it */
}
/* q turned by angular·h. The angle is right to the fifth order of |angular|·h. */
daft_quat daft_sim_turn(daft_quat q, daft_vec3 angular, float h);
/* The frame of a part in the world. */
daft_rigid daft_sim_part_frame(const daft_sim_body *body, const daft_sim_part *part);

bool daft_sim_list_reserve(daft_world *world, daft_sim_list *list, size_t needed);
void daft_sim_list_add(daft_world *world, daft_sim_list *list, uint32_t body_index);    /* room was reserved */
void daft_sim_list_remove(daft_world *world, daft_sim_list *list, uint32_t body_index); /* of bodies, by list_slot */

/* ---- step.c ---- */

/* A loop of the step, on all its workers if that is `wide` enough to be worth it. */
void daft_sim_for(const daft_world *world, bool wide, uint32_t tasks, daft_task *task, void *context);

/* ---- substeps.c ---- */

/* Moves what is active over dt and leaves the impulses in manifolds and joints. False when memory is out. */
bool daft_sim_solve(daft_world *world, float dt);
bool daft_sim_solver_create(daft_world *world);
void daft_sim_solver_destroy(daft_world *world);

/* ---- sweep.c ---- */

struct daft_sim_target; /* solve/solver.h */
/* Finds where a row's body stops on its path. */
void daft_sim_sweep(const daft_world *world, uint32_t row, struct daft_sim_target *targets);
/* Then, of all: what joints hold to bodies that were stopped waits for them. */
void daft_sim_sweep_joined(daft_world *world);

/* ---- body.c, mass of bodies ---- */

bool daft_sim_shape_check(const daft_sim_shape_def *def, daft_body_kind kind, daft_error *error);
/* A part as it is before it enters a tree. */
void daft_sim_part_fill(daft_sim_part *part, const daft_sim_shape_def *def, uint32_t body);

/* Mass, centre and inertia from the parts. False with a message: no mass, or out of range. */
bool daft_sim_body_weigh(const daft_world *world, daft_sim_body *body, daft_error *error);
/* Sets pose and what follows from it. */
void daft_sim_body_place(daft_sim_body *body, daft_dvec3 position, daft_quat rotation);
/* The inverse of its inertia in world axes, turned as `frame` says: xx, xy, xz, yy, yz, zz. Zero for what is not
 * dynamic, or locked. */
void daft_sim_body_inverse_inertia(const daft_sim_body *body, const daft_rigid *frame, float out[6]);
/* A kinematic body moves from now on; a dynamic one with its island is awake. Neither fails: room was reserved. */
void daft_sim_body_activate(daft_world *world, uint32_t index);

#endif
