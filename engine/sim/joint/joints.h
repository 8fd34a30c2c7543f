/* Joints in lanes: blocks of 16 side by side, of one kind and with the same parts (limit, motor, spring), so that no
 * lane asks what it is. Like contacts, those of one block share no body that yields. */
#ifndef DAFT_SIM_JOINTS_H
#define DAFT_SIM_JOINTS_H

#include "sim/solve/solver.h"

/* What a spring does in a substep: the fraction of an error to undo per second, of a change to make, and of an impulse
 * to forget. */
typedef struct daft_sim_softness {
    daft_sim_lanes rate, mass, impulse;
} daft_sim_softness;

typedef struct daft_sim_joint_side {
    int32_t row[DAFT_SIM_LANES];         /* 0: does not move */
    uint32_t writes;                     /* bits: lanes whose body yields */
    daft_sim_lanes inv_mass, inertia[6]; /* inverse, world axes */
    daft_sim_lanes rotation[4];          /* of the body as the step begins; prepare's only */
    daft_sim_lanes arm0[3];              /* anchor from the centre as the step begins; before prepare: in the body */
    daft_sim_lanes frame0[4];            /* the frame as the step begins; before prepare: in the body */
    daft_sim_lanes arm[3];               /* now */
    daft_sim_lanes spin[3];              /* angular velocity as the last substep began */
} daft_sim_joint_side;

/* Directions are found anew once a substep, when bodies have moved, with all that follows from them. */
struct daft_sim_joint_block {
    daft_joint_kind kind;
    bool limit, motor, spring; /* of all lanes */
    int32_t lanes;             /* in use */
    daft_sim_joint_side side[2];
    daft_sim_lanes offset0[3], offset[3]; /* from anchor a to anchor b; before prepare: from centre a to centre b */
    daft_sim_lanes most_open; /* what is farther apart is put back; before prepare: the fraction of offset0 that it may
                                 be */
    daft_sim_softness stiff, soft; /* of what is rigid; of the spring */
    daft_sim_lanes bend[3];        /* arms turn within a substep: their anchors' mean velocity, less that now */
    daft_sim_lanes point[6];       /* L·D·Lᵀ of the anchors' response to impulses there, D inverted */
    daft_sim_lanes turn[6];        /* of the response of the turning to twists */
    daft_sim_lanes pair[2][3], pair_mass[3]; /* two directions; L·D·Lᵀ of the response along them */
    daft_sim_lanes error[3];                 /* angle from frame a to frame b */
    /* The free direction: hinge, cone: angular; slider, distance: linear, with the arms' cross products. */
    daft_sim_lanes along[3], free_arm[2][3], free_push[2][3], free_mass, value;
    daft_sim_lanes limit_mass, limit_hold[3]; /* of an angle's limit: with the anchors held together, and the impulse
                                                 that holds them */
    daft_sim_lanes lower, upper, motor_speed, motor_force, hertz, damping, length;
    /* Impulses of the last substep. */
    daft_sim_lanes linear[3], angular[3];
    daft_sim_lanes motor_impulse, lower_impulse, upper_impulse, spring_impulse;
    daft_sim_lanes linear_sum[3], angular_sum[3]; /* over the step */
    /* Numbers that a block has no part for are left as they were. */
};

/* Where a block's lanes come from. */
typedef struct daft_sim_joint_source {
    daft_sim_joint *joints;
    const daft_sim_body *bodies;
    uint32_t joint[DAFT_SIM_LANES];   /* of lanes that are not in use: any */
    uint32_t body[2][DAFT_SIM_LANES]; /* any where the side is the world, and where the lane is not in use */
    uint32_t world[2];                /* bits: sides that are the world */
    daft_sim_lanes longer;            /* times the substep that the impulses are of, is this one */
} daft_sim_joint_source;

struct daft_sim_joint_kernels {
    /* Joints to lanes: all but offsets and rows. */
    void (*fill)(const daft_sim_joint_source *from, daft_sim_joint_block *block);
    /* What they keep of it, after a step of dt. */
    void (*store)(const daft_sim_joint_source *to, const daft_sim_joint_block *block, float dt);
    void (*prepare)(const daft_sim_solver_bodies *rows, daft_sim_joint_block *blocks, uint32_t count,
                    const daft_sim_substep *substep);
    void (*warm_start)(const daft_sim_solver_bodies *rows, daft_sim_joint_block *blocks, uint32_t count,
                       const daft_sim_substep *substep);
    /* With springs, which aim at the end of the substep. */
    void (*solve)(const daft_sim_solver_bodies *rows, daft_sim_joint_block *blocks, uint32_t count,
                  const daft_sim_substep *substep);
    /* Bodies have moved: places arms. True if anchors came apart so far that bodies were put back, which moves the arms
     * of others. */
    bool (*close)(const daft_sim_solver_bodies *rows, daft_sim_joint_block *blocks, uint32_t count);
    /* Directions anew; arms too if some are not where `close` left them, and masses if some body turned far; then a
     * pass without springs. */
    void (*relax)(const daft_sim_solver_bodies *rows, daft_sim_joint_block *blocks, uint32_t count,
                  const daft_sim_substep *substep, bool place, bool turned_far);
};

DAFT_KERNEL_DECLARE(daft_sim_joint_kernels, daft_sim_joint);

/* Colours for the joints of the islands that are being solved; most: gives how many of each class. False when memory is
 * out. */
bool daft_sim_joints_colour(daft_world *world, uint32_t most[DAFT_SIM_CLASSES]);
/* Blocks from these constraints. False when memory is out. */
bool daft_sim_joints_place(daft_world *world, const uint32_t most[2]);
/* Fills block `index` from joints, and puts back what they keep. */
void daft_sim_joint_block_fill(daft_world *world, uint32_t index);
void daft_sim_joint_block_store(daft_world *world, uint32_t index, float dt);

#endif
