/* Where joints are in this substep: arms, directions, and what bodies answer to impulses along them. */
#ifndef DAFT_SIM_JOINT_PLACE_H
#define DAFT_SIM_JOINT_PLACE_H

#include "sim/joint/joint_lanes.h"

/* Hinges and cones turn in it, others move. */
DAFT_INLINE bool is_angular(const joint_block *block)
{
    return block->kind == DAFT_JOINT_HINGE || block->kind == DAFT_JOINT_BALL;
}

/* How bodies have turned and gone since the step began. */
typedef struct place_now {
    quat turn;
    vf3 displacement;
} place_now;

DAFT_INLINE place_now load_place(const daft_sim_solver_bodies *rows, const int32_t *index)
{
    vf row[8];
    vf_gather_rows8(rows->turn, index, row);
    return (place_now){{row[0], row[1], row[2], row[3]}, {row[4], row[5], row[6]}};
}

/* Where the anchors are now. */
DAFT_INLINE void place_arms(joint_block *block, const place_now now[2], int lane)
{
    vf3 moved[2];
    for (int i = 0; i < 2; i++) {
        joint_side *side = &block->side[i];
        vf3 arm0 = load3(side->arm0, lane), arm = rotate(now[i].turn, arm0);
        moved[i] = vf3_add(now[i].displacement, vf3_sub(arm, arm0));
        store3(side->arm, lane, arm);
    }
    store3(block->offset, lane, vf3_add(vf3_sub(load3(block->offset0, lane), moved[0]), moved[1]));
}

/* Of the relative velocity at the anchors to impulses there. */
DAFT_INLINE void place_points(pass *p)
{
    vf mass = p->inv_mass[0] + p->inv_mass[1], m[6] = {mass, zero(), zero(), mass, zero(), mass};
    for (int i = 0; i < 2; i++) {
        /* r × an axis is (0, z, -y), (-z, 0, x), (y, -x, 0); x, y, z: the inverse inertia times these. */
        vf3 r = p->arm[i];
        const vf *t = p->inertia[i];
        vf3 x = {zero(), t[3] * r.z - t[4] * r.y, t[4] * r.z - t[5] * r.y};
        vf3 y = {t[2] * r.x - t[0] * r.z, t[4] * r.x - t[1] * r.z, t[5] * r.x - t[2] * r.z};
        vf3 z = {t[0] * r.y - t[1] * r.x, t[1] * r.y - t[3] * r.x, t[2] * r.y - t[4] * r.x};
        m[0] = m[0] + (r.z * x.y - r.y * x.z), m[1] = m[1] + (r.z * y.y - r.y * y.z);
        m[2] = m[2] + (r.z * z.y - r.y * z.z), m[3] = m[3] + (r.x * y.z - r.z * y.x);
        m[4] = m[4] + (r.x * z.z - r.z * z.x), m[5] = m[5] + (r.y * z.x - r.x * z.y);
    }
    factorise(m, mass, p->block->point, p->lane);
}
DAFT_INLINE void place_turn(pass *p)
{
    vf m[6];
    for (int k = 0; k < 6; k++) m[k] = p->inertia[0][k] + p->inertia[1][k];
    factorise(m, zero(), p->block->turn, p->lane);
}

/* The rotation from frame a to frame b, as a vector in the world; half-angle form, exact at 0. */
DAFT_INLINE vf3 turn_error(const quat frame[2])
{
    quat d = quat_mul(frame[1], conjugate(frame[0]));
    vf twice = vf_if_then_else(vf_lt(d.w, zero()), vf_set(-2), vf_set(2));
    return vf3_scale((vf3){d.x, d.y, d.z}, twice);
}
/* Within ±pi. */
DAFT_INLINE vf hinge_angle(const quat frame[2])
{
    quat d = quat_mul(conjugate(frame[0]), frame[1]);
    vf sign = vf_if_then_else(vf_lt(d.w, zero()), vf_set(-1), vf_set(1));
    return vf_set(2) * vf_atan2(sign * d.x, sign * d.w);
}

DAFT_INLINE void store_perpendiculars(joint_block *block, vf3 n, int lane)
{
    vm steep = vf_lt(vf_abs(n.x), vf_set(0.6f)); /* the axis crossed: x, else y */
    vf3 u = vf3_select(steep, (vf3){zero(), n.z, -n.y}, (vf3){-n.z, zero(), n.x});
    u = vf3_scale(u, inverse(length_of(u)));
    store3(block->pair[0], lane, u);
    store3(block->pair[1], lane, vf3_cross(n, u));
}
DAFT_INLINE void place_axes(pass *p, vf3 axis, vf3 other)
{
    joint_block *block = p->block;
    store_perpendiculars(block, axis, p->lane);
    store3(block->error, p->lane, vf3_cross(axis, other));
    vf3 d0 = load3(block->pair[0], p->lane), d1 = load3(block->pair[1], p->lane);
    vf3 r0 = vf3_add(symmetric(p->inertia[0], d0), symmetric(p->inertia[1], d0));
    vf3 r1 = vf3_add(symmetric(p->inertia[0], d1), symmetric(p->inertia[1], d1));
    factorise2(vf3_dot(d0, r0), vf3_dot(d1, r0), vf3_dot(d1, r1), block->pair_mass, p->lane);
}
DAFT_INLINE void place_line(pass *p, vf3 axis)
{
    joint_block *block = p->block;
    store_perpendiculars(block, axis, p->lane);
    vf3 d0 = load3(block->pair[0], p->lane), d1 = load3(block->pair[1], p->lane);
    vf mass = p->inv_mass[0] + p->inv_mass[1], m11 = mass, m12 = zero(), m22 = mass;
    for (int i = 0; i < 2; i++) {
        vf3 c0 = vf3_cross(p->arm[i], d0), c1 = vf3_cross(p->arm[i], d1);
        vf3 s0 = symmetric(p->inertia[i], c0), s1 = symmetric(p->inertia[i], c1);
        m11 = m11 + vf3_dot(c0, s0), m12 = m12 + vf3_dot(c1, s0), m22 = m22 + vf3_dot(c1, s1);
    }
    factorise2(m11, m12, m22, block->pair_mass, p->lane);
}

DAFT_INLINE void place_free(pass *p, vf3 along, vf value)
{
    joint_block *block = p->block;
    bool angular = is_angular(block);
    vf response = angular ? zero() : p->inv_mass[0] + p->inv_mass[1];
    for (int i = 0; i < 2; i++) {
        vf3 arm = angular ? along : vf3_cross(p->arm[i], along), pushed = symmetric(p->inertia[i], arm);
        store3(block->free_arm[i], p->lane, arm);
        store3(block->free_push[i], p->lane, pushed);
        response = response + vf3_dot(arm, pushed);
    }
    store3(block->along, p->lane, along);
    vf_store(block->free_mass + p->lane, inverse(response));
    vf_store(block->value + p->lane, value);
}

/* Whether the limit is that of an angle of bodies whose anchors are rigidly together. */
DAFT_INLINE bool holds_limit(const joint_block *block)
{
    return block->limit && (block->kind == DAFT_JOINT_HINGE || (block->kind == DAFT_JOINT_BALL && !block->spring));
}

/* A twist at the limit draws the anchors apart, and what holds them together twists back: solved in turns, a bob on a
 * long arm, whose own inertia is a fiftieth of what it is about the joint, would sink into its limit and be thrown back
 * by it. So both are solved at once: with c the anchors' speed by a unit twist and K their response, the impulse -K⁻¹c
 * goes with it, and what the twist then does to the angle is less by c·K⁻¹c. */
DAFT_INLINE void place_limit(pass *p)
{
    joint_block *block = p->block;
    vf3 along = load3(block->along, p->lane), a = load3(block->free_push[0], p->lane),
        b = load3(block->free_push[1], p->lane);
    vf3 c = vf3_add(vf3_cross(a, p->arm[0]), vf3_cross(b, p->arm[1])), hold = solve3(block->point, p->lane, c);
    vf response = vf3_dot(along, vf3_add(a, b)), left = response - vf3_dot(c, hold);
    store3(block->limit_hold, p->lane, (vf3){-hold.x, -hold.y, -hold.z});
    vf_store(block->limit_mass + p->lane, inverse(vf_max(left, vf_set(1e-4f) * response)));
}

/* The cone about axis a that axis b stays in. */
DAFT_INLINE void place_cone(pass *p, vf3 axis, vf3 other)
{
    vf3 normal = vf3_cross(axis, other);
    vf sine = length_of(normal);
    vm leans = vf_lt(vf_set(1e-6f), sine); /* else there is no direction */
    vf3 along = vf3_scale(normal, vf_if_then_else(leans, vf_set(1) / vf_if_then_else(leans, sine, vf_set(1)), zero()));
    place_free(p, along, vf_atan2(sine, vf3_dot(axis, other)));
}
DAFT_INLINE void place_distance(pass *p)
{
    vf3 offset = load3(p->block->offset, p->lane), up = {zero(), vf_set(1), zero()};
    vf length = length_of(offset);
    vm apart = vf_lt(vf_set(1e-9f), length);
    vf3 along = vf3_select(apart, vf3_scale(offset, vf_set(1) / vf_if_then_else(apart, length, vf_set(1))), up);
    place_free(p, along, length);
}

/* Whether it matters how its bodies are turned against each other. */
DAFT_INLINE bool has_frames(const joint_block *block)
{
    return block->kind == DAFT_JOINT_HINGE || block->kind == DAFT_JOINT_SLIDER || block->kind == DAFT_JOINT_FIXED ||
           (block->kind == DAFT_JOINT_BALL && block->limit);
}

DAFT_INLINE void load_frames(const daft_sim_joint_block *block, const quat turn[2], int lane, quat frame[2])
{
    for (int i = 0; i < 2; i++) frame[i] = quat_mul(turn[i], load4(block->side[i].frame0, lane));
}

/* A slider's line turns with a, so impulses across it act on a at b's anchor. */
DAFT_INLINE void lengthen_arm(pass *p)
{
    if (p->block->kind == DAFT_JOINT_SLIDER) p->arm[0] = vf3_add(p->arm[0], load3(p->block->offset, p->lane));
}

/* What follows from where arms and frames are now, and from the inertia of the bodies as they have turned. */
DAFT_INLINE void place_directions(pass *p, const quat turn[2])
{
    joint_block *block = p->block;
    quat frame[2] = {0};
    if (has_frames(block)) load_frames(block, turn, p->lane, frame);
    vf3 axis = first_axis(frame[0]);
    bool turns = block->kind == DAFT_JOINT_FIXED || block->kind == DAFT_JOINT_SLIDER;
    bool brakes = block->kind == DAFT_JOINT_BALL && block->motor;
    if (turns || brakes) place_turn(p);
    if (turns) store3(block->error, p->lane, turn_error(frame));
    if (block->kind == DAFT_JOINT_DISTANCE) place_distance(p);
    if (block->kind == DAFT_JOINT_SLIDER) {
        place_free(p, axis, vf3_dot(load3(block->offset, p->lane), axis));
        place_line(p, axis);
        return;
    }
    if (block->kind == DAFT_JOINT_HINGE) {
        place_free(p, axis, block->limit || block->spring ? hinge_angle(frame) : zero());
        place_axes(p, axis, first_axis(frame[1]));
    }
    if (block->kind == DAFT_JOINT_BALL && block->limit) place_cone(p, axis, first_axis(frame[1]));
    if (block->kind != DAFT_JOINT_DISTANCE) place_points(p);
    if (holds_limit(block)) place_limit(p);
}

DAFT_INLINE void refresh_masses(const daft_sim_solver_bodies *rows, joint_block *block, int lane)
{
    for (int i = 0; i < 2; i++) {
        vf row[8];
        vf_gather_rows8(rows->mass, block->side[i].row + lane, row);
        vf_store(block->side[i].inv_mass + lane, row[0]);
        for (int k = 0; k < 6; k++) vf_store(block->side[i].inertia[k] + lane, row[k + 1]);
    }
}

#endif
