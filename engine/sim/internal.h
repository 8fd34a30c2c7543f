/* The inside of sim: bodies, the bounding-volume tree, contacts and the solver. No other room includes this.
 *
 * A step runs: tree bounds (broad.c) -> touching pairs (contacts.c, geometry from collide.c) -> substeps (solver.c) ->
 * poses, continuous check, report (step.c). Everything a step computes is a function of the bodies' state and of the
 * impulses kept from the step before: never of the tree's shape, of addresses or of time.
 *
 * A body is two records under one index: `daft_sim_body`, what it is and where, and `daft_sim_motion`, the little that
 * the solver touches in every substep. */
#ifndef DAFT_SIM_INTERNAL_H
#define DAFT_SIM_INTERNAL_H

#include "sim/sim.h"

#define DAFT_SIM_NONE UINT32_MAX

enum {
    DAFT_SIM_SUBSTEPS = 4,
    DAFT_SIM_MAX_FIXED_CONTACTS = 64, /* of one sphere with bodies that do not yield: the nearest ones */
    /* Pairs that count for the smaller sphere. Twelve equal spheres can touch one, so only overlap meets this bound; it
     * keeps thousands of bodies in one spot from making millions of contacts. */
    DAFT_SIM_MAX_PARTNERS = 32
};

/* Bounds that keep every float of the solver finite. Velocities beyond are clamped, definitions beyond refused. */
#define DAFT_SIM_MAX_SPEED        1e4f /* m/s */
#define DAFT_SIM_MAX_SPIN         1e6f /* rad/s */
#define DAFT_SIM_MAX_ACCELERATION 1e9f /* m/s² */
#define DAFT_SIM_MAX_DISTANCE     1e12 /* m from the origin */
#define DAFT_SIM_MIN_SIZE         1e-4f
#define DAFT_SIM_MAX_SIZE         1e7f
#define DAFT_SIM_MIN_MASS         1e-15
#define DAFT_SIM_MAX_MASS         1e24
#define DAFT_SIM_MAX_DT           1.0f

typedef struct daft_sim_bounds {
    daft_dvec3 low, high;
} daft_sim_bounds;

static inline bool daft_sim_overlap(const daft_sim_bounds *a, const daft_sim_bounds *b)
{
    return a->low.x <= b->high.x && b->low.x <= a->high.x && a->low.y <= b->high.y && b->low.y <= a->high.y &&
           a->low.z <= b->high.z && b->low.z <= a->high.z;
}

/* ---- the tree (tree.c) ---- */

/* A height-balanced tree of bounds; leaves are bodies, entered and removed one at a time. */
typedef struct daft_sim_node {
    daft_sim_bounds bounds;
    uint32_t parent; /* the next free node, where this one is free */
    uint32_t child[2];
    uint32_t body; /* DAFT_SIM_NONE: an inner node */
    int height;    /* 0: a leaf */
} daft_sim_node;

typedef struct daft_sim_tree {
    daft_sim_node *nodes;
    size_t capacity, used; /* used: high-water mark */
    uint32_t root, free_list, leaf_count;
} daft_sim_tree;

typedef void daft_sim_visit(void *context, uint32_t body);

void daft_sim_tree_init(daft_sim_tree *tree);
/* Room for one more leaf; an insert right after cannot fail. */
bool daft_sim_tree_reserve(daft_sim_tree *tree, const daft_allocator *allocator);
uint32_t daft_sim_tree_insert(daft_sim_tree *tree, const daft_sim_bounds *bounds, uint32_t body);
void daft_sim_tree_remove(daft_sim_tree *tree, uint32_t leaf);
/* Calls visit for every leaf that overlaps, in an order that callers must not depend on. */
void daft_sim_tree_query(const daft_sim_tree *tree, const daft_sim_bounds *bounds, daft_sim_visit *visit,
                         void *context);

/* ---- bodies ---- */

typedef struct daft_sim_body {
    daft_body_kind kind; /* DAFT_BODY_NONE: a free slot */
    daft_shape shape;
    float radius; /* spheres */
    daft_vec3 half_extent;
    float reach; /* no point of the shape is farther from its centre */
    float friction, restitution, rolling_resistance;
    uint32_t user;

    daft_dvec3 position;
    daft_quat rotation;
    double basis[9]; /* the rotation's matrix; boxes only */
    daft_vec3 force; /* over the next step */

    daft_dvec3 target_position; /* kinematic bodies with has_target: the pose at the end of the next step */
    daft_quat target_rotation;
    bool has_target;
    bool follows; /* the velocity came from a target, so it ends with the step */
    bool fresh;   /* new or teleported: impulses kept from the last step mean nothing */

    daft_sim_bounds bounds; /* where the body will be during this step */
    uint32_t leaf;          /* in the tree of its kind */
    uint32_t list_slot;     /* in the list of its kind: dynamics or movers; or DAFT_SIM_NONE */
    uint32_t next_free;
} daft_sim_body;

/* Static and kinematic bodies have zero inverse mass and inertia, so impulses leave them alone without a branch.
 * A sphere's inertia is the same about every axis: one number. */
typedef struct daft_sim_motion {
    daft_vec3 linear, angular; /* m/s, rad/s, world axes */
    daft_vec3 delta;           /* movement since the step began; a float, so precision does not fade far out */
    daft_quat turn;            /* rotation since the step began */
    daft_vec3 planned;         /* the movement of this step, if nothing is hit */
    daft_vec3 acceleration;    /* from gravity and forces, over this step */
    daft_vec3 gain;            /* of linear velocity from them, in this substep */
    float inv_mass, inv_inertia;
    bool pushed; /* a contact acted in this substep */
    /* The hardest of the contacts with bodies that do not yield: its impulse in the last substep, and which way it
     * pushes. */
    float support_impulse;
    daft_vec3 support;
} daft_sim_motion;

/* ---- contacts ---- */

/* Where a sphere touches another body, or will within the step. */
typedef struct daft_sim_touch {
    daft_dvec3 centre; /* of the sphere as it touches: where it is now, or on its way */
    daft_dvec3 point;  /* on the other body's surface */
    daft_vec3 normal;  /* from the other body to the sphere */
    double time;       /* 0: now; else the share of the step after which they meet */
    double separation; /* now, along the normal */
} daft_sim_touch;

typedef struct daft_sim_point {
    uint64_t key;     /* contacts are in the order of keys: yielding pairs first, then by a and b */
    uint32_t a, b;    /* body indices, a < b */
    daft_vec3 normal; /* from a to b */
    /* From a body's centre. The core turns with the body and the rounding around it does not, so a rolling sphere
     * (core: its centre) keeps its separation. Impulses act at the anchor. */
    daft_vec3 core_a, core_b, anchor_a, anchor_b;
    float separation; /* as the step began */
    float friction, restitution;
    float rolling; /* metres: torque at most this times the normal force */
    float normal_mass, tangent_mass, rolling_mass;
    float held_mass; /* along the normal, with what supports the two bodies */
    float approach;  /* speed at which they meet, along the normal; m/s, 0 or more */
    bool turns;      /* a core moves by turning */
    bool fixed;      /* one of the two does not yield */
    /* Of the last substep; the next one starts with them. */
    float normal_impulse;
    daft_vec3 friction_impulse, rolling_impulse;
    float total_impulse; /* normal, summed over the step */
} daft_sim_point;

typedef struct daft_sim_list {
    uint32_t *items;
    size_t count, capacity;
} daft_sim_list;

struct daft_world {
    daft_allocator allocator;
    daft_vec3 gravity;

    daft_sim_body *bodies;
    daft_sim_motion *motions;
    size_t body_capacity, motion_capacity;
    uint32_t body_count; /* high-water mark */
    uint32_t free_list;
    daft_sim_list dynamics; /* in no particular order */
    daft_sim_list movers;   /* kinematic bodies with a target or a velocity, in no particular order */

    daft_sim_tree trees[DAFT_BODY_DYNAMIC + 1]; /* one for each kind; of what can move, in fattened bounds */

    daft_sim_point *points, *old_points; /* of this step and of the last */
    size_t point_count, point_capacity, old_count, old_capacity;

    daft_sim_contact *report;
    uint64_t *report_keys; /* a << 32 | b, to take out the contacts of a removed body */
    size_t report_count, report_capacity, report_key_capacity;
};

static inline const daft_sim_body *daft_sim_find(const daft_world *world, uint32_t body)
{
    if (body == 0 || body > world->body_count) return NULL;
    const daft_sim_body *found = &world->bodies[body - 1];
    return found->kind == DAFT_BODY_NONE ? NULL : found;
}

static inline daft_dvec3 daft_sim_dmin(daft_dvec3 a, daft_dvec3 b)
{
    return daft_dv3(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}
static inline daft_dvec3 daft_sim_dmax(daft_dvec3 a, daft_dvec3 b)
{
    return daft_dv3(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}

/* A vector no longer than `limit`; NaN components become -limit first. */
daft_vec3 daft_sim_clamp(daft_vec3 v, float limit);
/* q turned by angular·h. The angle is right to the fifth order of |angular|·h. */
daft_quat daft_sim_turn(daft_quat q, daft_vec3 angular, float h);

/* ---- collide.c ---- */

/* Signed distance of p from the surface of a body's shape, negative inside; the surface's nearest point and the outward
 * normal there. */
double daft_sim_distance(const daft_sim_body *body, daft_dvec3 p, daft_dvec3 *point, daft_dvec3 *normal);
/* The ways out for a point inside a shape, by the number of the face; false when there are no more. */
bool daft_sim_exit(const daft_sim_body *body, daft_dvec3 p, int face, daft_dvec3 *point, daft_dvec3 *normal,
                   double *distance);
/* How a sphere that moves by `motion` relative to `other` touches it: now, if no farther than margin, or on its way. */
bool daft_sim_touch_sphere(const daft_sim_body *other, daft_dvec3 centre, double radius, daft_dvec3 motion,
                           double margin, daft_sim_touch *touch);

/* ---- broad.c ---- */

/* Bounds of a body's shape where it stands. */
daft_sim_bounds daft_sim_shape_bounds(const daft_sim_body *body);
/* Enters a body into its tree, for which there is room. */
void daft_sim_broad_add(daft_world *world, uint32_t index);
void daft_sim_broad_remove(daft_world *world, uint32_t index);
/* Bounds over the coming step of everything that moves. */
void daft_sim_broad_update(daft_world *world, float dt);

/* ---- contacts.c ---- */

/* Fills world->points for the coming step. False when memory is out; the bodies are then as they were. */
bool daft_sim_find_contacts(daft_world *world, float dt);

/* ---- solver.c ---- */

/* Moves velocities, deltas and turns over dt, and leaves the impulses in world->points. */
void daft_sim_solve(daft_world *world, float dt);
/* Separation now, with the movement since the step began. */
float daft_sim_separation(const daft_sim_point *point, const daft_sim_motion *a, const daft_sim_motion *b);

#endif
