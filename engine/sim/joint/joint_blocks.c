/* Joints into blocks of lanes and back, see joints.h. */
#include "sim/joint/joints.h"

#include <stddef.h>
#include <string.h>

/* ---- colours ---- */

static uint32_t row_of(const daft_world *world, uint32_t body)
{
    return body == DAFT_SIM_NONE ? 0 : world->scratch.solver->row_of[body];
}

bool daft_sim_joints_colour(daft_world *world, uint32_t most[DAFT_SIM_CLASSES])
{
    daft_sim_solver *s = world->scratch.solver;
    s->constraint_count = 0;
    for (uint32_t i = 0; world->live_joints > 0 && i < world->joint_count; i++) {
        const daft_sim_joint *joint = &world->joints[i];
        if (joint->kind == 0) continue;
        uint32_t a = row_of(world, joint->body[0]), b = row_of(world, joint->body[1]);
        if (!daft_sim_row_is_solved(s, a) && !daft_sim_row_is_solved(s, b)) continue;
        if (!daft_grow(&world->allocator, &s->constraints, &s->constraint_capacity, s->constraint_count + 1,
                       s->constraint_count, sizeof *s->constraints))
            return false;
        bool yields_a = daft_sim_row_yields(s, a), yields_b = daft_sim_row_yields(s, b);
        if (yields_a) s->constrained[a] |= DAFT_SIM_JOINTED;
        if (yields_b) s->constrained[b] |= DAFT_SIM_JOINTED;
        size_t place_a = yields_a ? daft_sim_colour_place(joint->body[0]) : 0,
               place_b = yields_b ? daft_sim_colour_place(joint->body[1]) : 0;
        uint32_t class = !(yields_a && yields_b), colour = daft_sim_colour_take(s, place_a, place_b, class);
        if (colour >= most[class]) most[class] = colour + 1;
        s->constraints[s->constraint_count++] = (daft_sim_constraint){i, a, b, colour << 1 | class};
    }
    return true;
}

/* ---- blocks ---- */

enum { PARTS = 64 }; /* kinds of blocks: of joint, and which of limit, motor and spring it has */

static uint32_t parts_of(const daft_sim_joint *j)
{
    return (uint32_t)j->kind | (uint32_t)j->limit << 3 | (uint32_t)j->motor << 4 | (uint32_t)j->spring << 5;
}

static uint32_t *bin_of(const daft_world *world, const daft_sim_constraint *c, const uint32_t most[2])
{
    uint32_t colour = (c->colour >> 1) + (c->colour & 1 ? most[0] : 0);
    return &world->scratch.solver->joint_bins[colour * PARTS + parts_of(&world->joints[c->joint])];
}

/* Counts become first slots; blocks of one colour follow each other. */
static void lay_out(daft_sim_solver *s, uint32_t colours)
{
    s->joint_colour_count = s->joint_block_count = 0;
    for (uint32_t colour = 0; colour < colours; colour++) {
        uint32_t first = s->joint_block_count;
        for (uint32_t i = 0; i < PARTS; i++) {
            uint32_t *bin = &s->joint_bins[colour * PARTS + i], blocks = (*bin + DAFT_SIM_LANES - 1) / DAFT_SIM_LANES;
            *bin = s->joint_block_count * DAFT_SIM_LANES;
            s->joint_block_count += blocks;
        }
        uint32_t blocks = s->joint_block_count - first;
        if (blocks) s->joint_colours[s->joint_colour_count++] = (daft_sim_colour){first, blocks, 0};
    }
}

bool daft_sim_joints_place(daft_world *world, const uint32_t most[2])
{
    daft_sim_solver *s = world->scratch.solver;
    size_t colours = (size_t)most[0] + most[1], bins = colours * PARTS;
    s->joint_count = (uint32_t)s->constraint_count;
    if (!daft_grow(&world->allocator, &s->joint_bins, &s->joint_bin_capacity, bins, 0, sizeof *s->joint_bins) ||
        !daft_grow(&world->allocator, &s->joint_colours, &s->joint_colour_capacity, colours, 0,
                   sizeof *s->joint_colours))
        return false;
    if (bins) memset(s->joint_bins, 0, bins * sizeof *s->joint_bins);
    for (size_t i = 0; i < s->constraint_count; i++) ++*bin_of(world, &s->constraints[i], most);
    lay_out(s, (uint32_t)colours);
    size_t blocks = s->joint_block_count, slots = blocks * DAFT_SIM_LANES;
    if (!daft_grow(&world->allocator, &s->joint_blocks, &s->joint_block_capacity, blocks, 0, sizeof *s->joint_blocks) ||
        !daft_grow(&world->allocator, &s->joint_slots, &s->joint_slot_capacity, slots, 0, sizeof *s->joint_slots))
        return false;
    for (size_t i = 0; i < slots; i++) s->joint_slots[i].joint = DAFT_SIM_NONE;
    for (size_t i = 0; i < s->constraint_count; i++) {
        const daft_sim_constraint *c = &s->constraints[i];
        s->joint_slots[(*bin_of(world, c, most))++] = (daft_sim_joint_slot){c->joint, {c->row_a, c->row_b}};
    }
    return true;
}

/* ---- filling ---- */

/* How much longer the substep is than the one that the joint's impulses are of. */
static float longer_than_before(const daft_world *world, const daft_sim_joint_slot *slot)
{
    float before = 0;
    for (int i = 0; i < 2; i++)
        if (slot->row[i] > world->scratch.solver->mover_count)
            before = world->bodies[world->scratch.solver->row_bodies[slot->row[i]]].h;
    return before > 0 && before != world->scratch.solver->h ? world->scratch.solver->h / before : 1;
}

static void put3(daft_sim_lanes *to, int lane, daft_vec3 v) { to[0][lane] = v.x, to[1][lane] = v.y, to[2][lane] = v.z; }

/* Gives where the side's anchor is counted from: the centre, or in the world the anchor itself. */
static daft_dvec3 find_side(const daft_world *world, const daft_sim_joint_slot *slot, int i, int lane,
                            daft_sim_joint_source *out)
{
    const daft_sim_joint *j = &world->joints[slot->joint];
    bool none = j->body[i] == DAFT_SIM_NONE;
    out->world[i] |= (uint32_t)none << lane;
    out->body[i][lane] = none ? 0 : j->body[i];
    return none ? j->fixed : world->bodies[j->body[i]].centre;
}

/* Of how far a joint is open of something that is fast and touches, so much is left to its springs: a limb that is
 * struck again in each step would be torn off bit by bit. What is slow, or touches nothing, is stretched by what it
 * carries, and springs alone keep its energy. */
#define LEFT_OPEN 0.6f
#define FAST      4.0f /* m/s */

static bool is_struck(const daft_world *world, uint32_t row)
{
    const daft_sim_solver *s = world->scratch.solver;
    if (!(s->constrained[row] & DAFT_SIM_IN_CONTACT)) return false;
    daft_vec3 v = world->bodies[s->row_bodies[row]].linear;
    return daft_dot(v, v) > FAST * FAST;
}

static float left_open(const daft_world *world, const daft_sim_joint_slot *slot)
{
    return is_struck(world, slot->row[0]) || is_struck(world, slot->row[1]) ? LEFT_OPEN : 1;
}

static void fill_rows(const daft_world *world, daft_sim_joint_block *block, const daft_sim_joint_slot *slots,
                      daft_sim_joint_source *out)
{
    block->side[0].writes = block->side[1].writes = 0;
    for (int lane = 0; lane < block->lanes; lane++) {
        const daft_sim_joint_slot *slot = &slots[lane];
        out->joint[lane] = slot->joint;
        out->longer[lane] = world->scratch.solver->steady ? 1 : longer_than_before(world, slot);
        block->most_open[lane] = left_open(world, slot);
        daft_dvec3 from[2];
        for (int i = 0; i < 2; i++) {
            from[i] = find_side(world, slot, i, lane, out);
            block->side[i].row[lane] = (int32_t)slot->row[i];
            block->side[i].writes |= (uint32_t)(slot->row[i] > world->scratch.solver->mover_count) << lane;
        }
        put3(block->offset0, lane, daft_to_float(daft_dsub(from[1], from[0])));
    }
    for (int lane = block->lanes; lane < DAFT_SIM_LANES; lane++) {
        out->joint[lane] = out->body[0][lane] = out->body[1][lane] = 0;
        out->longer[lane] = block->most_open[lane] = 1;
        block->side[0].row[lane] = block->side[1].row[lane] = 0;
        put3(block->offset0, lane, daft_v3(0, 0, 0));
    }
}

static int lanes_of(const daft_sim_joint_slot *slots)
{
    int lanes = 0;
    while (lanes < DAFT_SIM_LANES && slots[lanes].joint != DAFT_SIM_NONE) lanes++;
    return lanes;
}

void daft_sim_joint_block_fill(daft_world *world, uint32_t index)
{
    daft_sim_solver *s = world->scratch.solver;
    daft_sim_joint_block *block = &s->joint_blocks[index];
    const daft_sim_joint_slot *slots = &s->joint_slots[(size_t)index * DAFT_SIM_LANES];
    const daft_sim_joint *first = &world->joints[slots[0].joint];
    block->kind = first->kind;
    block->limit = first->limit, block->motor = first->motor, block->spring = first->spring;
    block->lanes = lanes_of(slots);
    daft_sim_joint_source from = {.joints = world->joints, .bodies = world->bodies};
    fill_rows(world, block, slots, &from);
    s->joint_kernels->fill(&from, block);
}

void daft_sim_joint_block_store(daft_world *world, uint32_t index, float dt)
{
    daft_sim_solver *s = world->scratch.solver;
    const daft_sim_joint_block *block = &s->joint_blocks[index];
    const daft_sim_joint_slot *slots = &s->joint_slots[(size_t)index * DAFT_SIM_LANES];
    daft_sim_joint_source to = {.joints = world->joints};
    for (int lane = 0; lane < block->lanes; lane++) to.joint[lane] = slots[lane].joint;
    s->joint_kernels->store(&to, block, dt);
}
