/* How well the simulation holds: energy, overlaps, gaps in joints. Read from the state, never part of a step. */
#include "sim/world.h"

static daft_quat conjugate(daft_quat q) { return (daft_quat){-q.x, -q.y, -q.z, q.w}; }

/* Kinetic, and potential in the world's gravity. */
static double energy_of(const daft_world *world, const daft_sim_body *body)
{
    const daft_quat principal = daft_quat_mul(body->rotation, body->axes);
    const daft_dvec3 v = daft_to_double(body->linear), g = daft_to_double(world->gravity);
    const daft_dvec3 w = daft_to_double(daft_quat_rotate(conjugate(principal), body->angular));
    const double turning =
        w.x * w.x * (double)body->moments.x + w.y * w.y * (double)body->moments.y + w.z * w.z * (double)body->moments.z;
    return (double)body->mass * (daft_ddot(v, v) / 2 - daft_ddot(g, body->centre) * (double)body->gravity_scale) +
           turning / 2;
}

static double deepest_of(const daft_sim_pair *pair)
{
    double deepest = 0;
    const daft_sim_manifold *manifolds = pair->more ? pair->more : &pair->own;
    for (uint32_t m = 0; m < pair->manifold_count; m++)
        for (uint32_t i = 0; i < manifolds[m].count; i++)
            if (-(double)manifolds[m].points[i].separation > deepest)
                deepest = -(double)manifolds[m].points[i].separation;
    return deepest;
}

/* How far what a joint keeps together is apart. */
static double gap_of(const daft_world *world, uint32_t index)
{
    const daft_sim_joint *j = &world->joints[index];
    daft_sim_joint_state state;
    if (j->kind == DAFT_JOINT_DRAG || (j->spring && j->kind != DAFT_JOINT_HINGE) || j->kind == DAFT_JOINT_SLIDER ||
        (j->kind == DAFT_JOINT_DISTANCE && j->limit) || !daft_world_get_joint(world, index + 1, &state))
        return 0;
    const daft_dvec3 apart = daft_dsub(state.anchor_a, state.anchor_b);
    const double length = sqrt(daft_ddot(apart, apart));
    return j->kind == DAFT_JOINT_DISTANCE ? fabs(length - (double)j->length) : length;
}

daft_sim_measure daft_world_measure(const daft_world *world)
{
    daft_sim_measure m = {0};
    for (uint32_t i = 0; i < world->body_count; i++)
        if (world->bodies[i].kind == DAFT_BODY_DYNAMIC) m.energy += energy_of(world, &world->bodies[i]);
    for (uint32_t i = 0; i < world->pair_count; i++) {
        const daft_sim_pair *pair = &world->pairs[i];
        if (pair->part_a != DAFT_SIM_NONE && !pair->sensor) m.penetration = fmax(m.penetration, deepest_of(pair));
    }
    for (uint32_t i = 0; i < world->joint_count; i++)
        if (world->joints[i].kind) m.joint_gap = fmax(m.joint_gap, gap_of(world, i));
    return m;
}
