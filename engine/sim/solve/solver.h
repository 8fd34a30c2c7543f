/* sim/solve: constraints become velocities and poses ("soft step", Catto, "Solver2D", 2024).
 * Promises: the same bits for every number of lanes and workers; no velocity beyond the bounds of world.h.
 *
 * Public headers: solver.h lanes.h
 *
 * The solver's scratch: rows of numbers for the bodies that move in this step, and blocks of contact constraints, 16
 * side by side. Constraints of one block never share a moving body, nor do blocks of one colour, so lanes and threads
 * cannot change a bit. Blocks are 16 wide for every instruction set; kernels take them in runs of their own width. */
#ifndef DAFT_SIM_SOLVER_H
#define DAFT_SIM_SOLVER_H

#include "math/simd/dispatch.h"
#include "sim/world.h"

enum {
    DAFT_SIM_LANES = 16,
    DAFT_SIM_RATES = 6, /* an island takes 1, 2, 4 … times the world's substeps: the powers of two up to 32 */
    DAFT_SIM_ROW = 8    /* floats: what lanes load and transpose at once */
};

/* One float per lane, in a cache line of their own. */
typedef float daft_sim_lanes[DAFT_SIM_LANES] __attribute__((aligned(64)));

/* A normal constraint: one point of a manifold. `arm_`: anchor × normal; `push_`: that times the inverse inertia, the
 * change of angular velocity by a unit impulse. Before prepare, arm_a holds the anchor itself. */
typedef struct daft_sim_block_point {
    daft_sim_lanes arm_a[3];
    daft_sim_lanes separation; /* as the step began; huge: no such point in this lane */
    daft_sim_lanes impulse;    /* of the last substep */
    daft_sim_lanes total;      /* summed over the step */
    /* What prepare makes: */
    daft_sim_lanes arm_b[3], push_a[3], push_b[3];
    daft_sim_lanes mass;     /* effective */
    daft_sim_lanes approach; /* speed at which they meet, 0 or more */
    daft_sim_lanes lever;    /* distance from where friction acts */
} daft_sim_block_point;

/* Friction acts at the middle of a manifold's points, in two directions, and about the normal ("central friction", as
 * in Box3D): the sum of the normal impulses bounds it. */
typedef struct daft_sim_block {
    int32_t a[DAFT_SIM_LANES], b[DAFT_SIM_LANES]; /* bodies' rows; 0: does not move */
    uint32_t writes_a, writes_b;                  /* bits: lanes whose body yields */
    int32_t lanes, points;                        /* in use; most points of any lane */
    bool rolls, bounces;
    bool shares;           /* some lane's floor is shared: */
    daft_sim_lanes shared; /* 1 where b is one of several bodies of a floor: friction acts below a's centre, as on one
                            */
    daft_sim_lanes normal[3], tangent[3]; /* the other tangent: normal × tangent */
    daft_sim_lanes apart[3];              /* from b's centre to a's: b's anchors are a's plus this; prepare's only */
    daft_sim_lanes rate, soft_mass, soft_impulse; /* of the contact's spring */
    daft_sim_lanes friction;
    daft_sim_lanes tangent_impulse[2];
    daft_sim_lanes slip[2], twist_slip; /* how far what sticks was dragged along: since when, see manifolds */
    daft_sim_lanes surface_velocity[2]; /* the surfaces' speed along the tangents: a's less b's */
    bool turns; /* some lane's bodies turn about the normal; those whose do not have zeros here: */
    daft_sim_lanes bend_a[2], bend_b[2]; /* along the tangents, from the centre to where friction acts; else 1 before
                                           prepare */
    daft_sim_lanes twist_impulse;
    daft_sim_lanes restitution;
    daft_sim_lanes rolling, rolling_impulse[3];
    /* What prepare makes: */
    daft_sim_lanes inv_mass_a, inv_mass_b;
    daft_sim_lanes arm_a[2][3], arm_b[2][3], push_a[2][3], push_b[2][3]; /* of friction, each tangent */
    daft_sim_lanes tangent_mass[3];                                      /* inverse of the 2×2 matrix: 11, 12, 22 */
    daft_sim_lanes twist_a[3], twist_b[3], twist_mass;
    daft_sim_lanes rolling_mass;
    daft_sim_lanes inertia_a[6], inertia_b[6]; /* inverse; rolling's */
    daft_sim_block_point point[DAFT_MANIFOLD_POINTS];
} daft_sim_block;

/* Blocks first..first + count are one colour. */
typedef struct daft_sim_colour {
    uint32_t first, count;
    uint32_t stiff; /* of them, the last: contacts that are gone over more often (substep_rate.c) */
} daft_sim_colour;

enum { DAFT_SIM_STIFF_PASSES = 6 }; /* with springs, in a substep; others have one */

typedef struct daft_sim_substep {
    float h, inv_h;
    float push_speed;
    float elapsed; /* s since the step began, as far as bodies have moved */
} daft_sim_substep;

/* Rows of DAFT_SIM_ROW floats for each body that moves, and row 0, zero, for all that does not. */
typedef struct daft_sim_solver_bodies {
    float *velocity; /* linear, angular; 6, 7: the most that their lengths may be */
    float *moved;    /* since the step began: along, and turned as the sum of angular velocities; floats that do not
                        fade far from the origin; 6: length of a substep */
    float *gain;     /* of velocity, per second, from gravity and forces; 6: 1 for bodies in free flight; 7: share
                        of the linear velocity that damping leaves in a substep */
    float *turn;     /* rotation since the step began, a quaternion; 4 to 6: the displacement, as in `moved`; 7: 1 for
                        constrained     bodies whose moments differ, 2 if their inertia was changed in this substep */
    float *mass; /* inverse mass; inverse inertia xx, xy, xz, yy, yz, zz, as the body has turned if that is far; share
                    of the angular velocity left */
} daft_sim_solver_bodies;

/* Where the solver puts the body of a row. */
typedef struct daft_sim_target {
    daft_dvec3 centre;
    daft_quat rotation;
    daft_dvec3 along; /* where it would get, along what it is pressed into; written for its own row only, as what
                         follows: */
    daft_dvec3 stop;  /* where it gets, and how fast it is there */
    daft_quat stop_rotation;
    daft_vec3 linear;
    double fraction; /* of the path that it covers; 1: all of it */
    uint32_t sweeps;
} daft_sim_target;

/* Contacts: contact_kernel.c. */
typedef struct daft_sim_contact_kernels {
    void (*prepare)(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count);
    /* Of bodies whose inertia has changed: effective masses again. */
    void (*refresh)(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count);
    void (*warm_start)(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count);
    /* biased: springs push overlap apart; otherwise the speed that gave is taken out again. */
    void (*solve)(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count,
                  const daft_sim_substep *substep, bool biased);
    void (*bounce)(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count,
                   const daft_sim_substep *end);
    void (*finish)(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count,
                   const daft_sim_substep *end);
} daft_sim_contact_kernels;

DAFT_KERNEL_DECLARE(daft_sim_contact_kernels, daft_sim_contact);

/* Bodies, in rows first..first + count: motion_kernel.c. */
typedef struct daft_sim_motion_kernels {
    void (*gain)(const daft_sim_solver_bodies *rows, uint32_t first, uint32_t count, float h);
    void (*move)(const daft_sim_solver_bodies *rows, uint32_t first, uint32_t count, float h);
    /* Bits of those of up to 32 rows whose inertia is to be changed: they turn faster than `most`; marks them. */
    uint32_t (*find_far)(const daft_sim_solver_bodies *rows, uint32_t first, uint32_t count, float most);
} daft_sim_motion_kernels;

DAFT_KERNEL_DECLARE(daft_sim_motion_kernels, daft_sim_motion);

typedef struct daft_sim_joint_block daft_sim_joint_block; /* joints.h */
typedef struct daft_sim_joint_kernels daft_sim_joint_kernels;

/* Bodies in free rotation, side by side. */
typedef struct daft_sim_angular {
    int32_t row[DAFT_SIM_LANES];
    int32_t lanes;          /* in use */
    daft_sim_lanes axes[4]; /* principal, in the world, as the step begins: a quaternion */
    daft_sim_lanes moments[3], middle[3];
    double momentum[3][DAFT_SIM_LANES]; /* world axes */
    daft_sim_lanes jolts;               /* in this step, see angular_kernel.c */
    daft_sim_lanes jolted; /* 1 where what constraints did in this substep leaves it its angular velocity */
} daft_sim_angular;

/* before: angular velocities become those of the middle of the substep; between, after constraints acted and before
 * bodies are turned: their impulses join the momentum; after: angular velocities become what the momentum asks for. */
typedef struct daft_sim_angular_kernels {
    void (*before)(const daft_sim_solver_bodies *rows, daft_sim_angular *spins, uint32_t count, float h);
    void (*between)(const daft_sim_solver_bodies *rows, daft_sim_angular *spins, uint32_t count, float h, float dt);
    void (*after)(const daft_sim_solver_bodies *rows, daft_sim_angular *spins, uint32_t count);
} daft_sim_angular_kernels;

DAFT_KERNEL_DECLARE(daft_sim_angular_kernels, daft_sim_angular);

/* Bodies that a step moves: rows 1 to `movers` are kinematic, the others dynamic. */
struct daft_sim_solver {
    daft_sim_solver_bodies rows;
    size_t row_capacity;
    uint32_t *row_bodies; /* of each row */
    size_t row_body_capacity;
    uint32_t row_count, mover_count;
    uint32_t *row_of; /* of each body; 0: it does not move */
    size_t row_of_capacity;
    uint8_t *constrained; /* of rows that some constraint acts on: DAFT_SIM_JOINTED and DAFT_SIM_IN_CONTACT */
    size_t constrained_capacity;
    uint8_t *marks; /* colour.c's scratch */
    size_t mark_capacity;
    struct daft_sim_depenetration {
        float speed, swing; /* m/s, of the centre and of turning */
    } * depenetration; /* of rows that overlap something deeply: the most that they may have; 0, 0: no more than any
                          other */
    size_t depenetration_capacity;
    struct daft_sim_island {
        uint64_t asked; /* summed over the bodies */
        uint32_t bodies, contacts, rate;
        uint32_t before; /* substeps in the last step, the most of its bodies */
        bool deep;       /* some overlap by so much that it is no load which presses them together */
        bool joined;     /* some have joints */
        bool stiff;      /* its stiff contacts are solved as such */
        uint32_t stiff_contacts;
        float pull; /* substeps a second that its joints ask for */
        bool fast;  /* some leave, within the step, the place that their contacts were found in */
    } * islands;
    bool stiff; /* some are */
    size_t island_capacity;
    uint32_t island_count;
    uint32_t *island_of; /* of each body that is awake and dynamic */
    size_t island_of_capacity;
    _Atomic uint32_t *asked; /* of each row: substeps a second, by what it carried in this step; a float's bits */
    size_t asked_capacity;

    /* The islands that are being solved: those of one substep rate, in rows that follow each other. */
    uint32_t rate_end[DAFT_SIM_RATES]; /* of rows */
    uint32_t row_first, row_end;
    int substeps;
    float h; /* s */

    daft_sim_block *blocks;
    size_t block_capacity;
    uint32_t block_count;
    daft_sim_colour *colours;
    size_t colour_capacity;
    uint32_t colour_count;
    /* Contacts in the order of colours: where each came from. */
    struct daft_sim_slot {
        uint32_t pair, manifold, row_a, row_b;
        bool stiff; /* of all in its block */
    } * slots;
    size_t slot_capacity;

    daft_sim_joint_block *joint_blocks;
    size_t joint_block_capacity;
    uint32_t joint_count, joint_block_count;
    struct daft_sim_joint_slot { /* of each lane: */
        uint32_t joint;          /* DAFT_SIM_NONE: none */
        uint32_t row[2];
    } * joint_slots;
    size_t joint_slot_capacity;
    uint32_t *joint_bins; /* joint_blocks.c's scratch */
    size_t joint_bin_capacity;
    daft_sim_colour *joint_colours;
    size_t joint_colour_capacity;
    uint32_t joint_colour_count;

    /* colour.c's scratch */
    uint64_t *masks; /* of each body: colours taken */
    uint32_t *levels;
    size_t mask_capacity, level_capacity;
    struct daft_sim_constraint { /* joints of one substep rate */
        uint32_t joint, row_a, row_b, colour;
    } * constraints;
    size_t constraint_capacity, constraint_count;
    struct daft_sim_coloured { /* contacts of all substep rates, in the order of the active list */
        uint32_t pair, manifold, body_a, body_b, colour;
        uint8_t points;
        bool loaded, stiff; /* it carries much; it is solved as such */
        uint32_t kind; /* of contacts of as many points, which stand in a block; DAFT_SIM_NONE: of another substep rate
                        */
    } * contacts;
    size_t contact_capacity, contact_count;
    uint32_t contact_colours[2]; /* of each class */
    uint32_t contact_rows;       /* constraints of all contacts */
    bool depenetrates;           /* some bodies are to part slowly */
    uint32_t *colour_counts;
    size_t colour_count_capacity;

    daft_sim_angular *angular; /* bodies whose moments of inertia differ, and that turn */
    size_t angular_capacity;
    uint32_t angular_count; /* blocks */
    bool locks;             /* some row's body must not move along some axis */
    bool steady;            /* no body's last substep was of another length than those now */

    daft_sim_target *targets; /* of rows */
    size_t target_capacity;
    _Atomic uint32_t sweeps; /* of all, in this step */

    daft_stage *stages; /* of the islands that are being solved */
    size_t stage_capacity, stage_count;
    const daft_sim_contact_kernels *contact_kernels;
    const daft_sim_motion_kernels *motion_kernels;
    const daft_sim_joint_kernels *joint_kernels;
    const daft_sim_angular_kernels *angular_kernels;
};

enum { DAFT_SIM_JOINTED = 1 /* by a joint */, DAFT_SIM_IN_CONTACT = 2 /* has contacts */ };

/* How fast overlap is undone at most, so that deep overlap does not explode. */
#define DAFT_SIM_PUSH_SPEED 3.0f /* m/s */

typedef struct daft_sim_island daft_sim_island;
typedef struct daft_sim_slot daft_sim_slot;
typedef struct daft_sim_constraint daft_sim_constraint;
typedef struct daft_sim_coloured daft_sim_coloured;
typedef struct daft_sim_joint_slot daft_sim_joint_slot;
typedef struct daft_sim_depenetration daft_sim_depenetration;

/* ---- colour.c ---- */

enum { DAFT_SIM_CLASSES = 2 /* of constraints, 0: both bodies yield; 1: one of them */ };
/* The masks and levels of bodies, by their indices; in the place before them, always free, stands all that does not
 * yield. */
static inline size_t daft_sim_colour_place(uint32_t body) { return (size_t)body + 1; }
void daft_sim_colours_clear(daft_sim_solver *solver, size_t place);
/* The lowest colour that is free at both places, and takes it. */
uint32_t daft_sim_colour_take(daft_sim_solver *solver, size_t a, size_t b, uint32_t class);
static inline bool daft_sim_row_yields(const daft_sim_solver *solver, uint32_t row)
{
    return row > solver->mover_count;
}
/* Whether it is of an island that is being solved. */
static inline bool daft_sim_row_is_solved(const daft_sim_solver *solver, uint32_t row)
{
    return row >= solver->row_first && row < solver->row_end;
}

/* Rows for active bodies, by the substep rate of their islands. False when memory is out. */
bool daft_sim_solver_bodies_assign(daft_world *world, float dt);
/* Colours for the contacts of all islands, for which there is room. */
void daft_sim_contacts_colour(daft_world *world);
/* Blocks for those of the islands to be solved now. False when memory is out. */
bool daft_sim_contacts_place(daft_world *world);
/* Fills block `index` from manifolds, and puts the impulses back. */
void daft_sim_block_fill(daft_world *world, uint32_t index);
void daft_sim_block_store(daft_world *world, uint32_t index);

/* ---- substep_rate.c ---- */

/* Notes what a manifold carried in the step; true if that is much beside the lighter body's weight. */
bool daft_sim_substep_load(const daft_world *world, daft_sim_manifold *manifold, float inv_mass, float dt);
/* What such a contact asks for goes to the rows of its bodies: the most counts, so in any order, side by side. */
void daft_sim_substep_ask(const daft_world *world, const daft_sim_pair *pair, float load, const daft_sim_slot *slot);
/* Substeps a second that a body asks for, which asked for `now`, by what its row carried in this step. */
float daft_sim_substep_demand_next(const daft_world *world, float now, uint32_t row);
/* Finds islands and their substep rates, for which there is room, and beside them colours for contacts. False: all have
 * the world's own substep rate. */
bool daft_sim_substep_rates(daft_world *world, float dt);
/* Whether a body's contacts that carry much are solved as stiff ones in this step. */
bool daft_sim_is_stiff(const daft_world *world, uint32_t body);

float daft_sim_substep_demand_begin(void); /* of a body that was made */
/* Whether a manifold carries many times the lighter body's weight, at rest. */
bool daft_sim_load_is_heavy(const daft_world *world, const daft_sim_body *a, const daft_sim_body *b, float load);

/* ---- angular.c ---- */

/* Whether the row's body turns freely, and so that it matters; then it joins those that do. There is room. */
bool daft_sim_integrates_angular(const daft_world *world, uint32_t row);
void daft_sim_angular_add(daft_world *world, uint32_t row);
/* Turns farther than this in a substep, in radians, are beyond the midpoint rule. */
#define DAFT_SIM_WILD_TURN 0.8f
/* Gives constrained rows first..first + count the inertia of their bodies as they have turned, if they turn far; true
 * if some do. The angular velocity is the same seen from the body, so its energy is; with the old inertia the next
 * impulse could give it many times that. */
bool daft_sim_angular_refresh(const daft_world *world, uint32_t first, uint32_t count, float dt);

#endif
