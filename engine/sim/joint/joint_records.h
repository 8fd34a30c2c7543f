/* Joints' records into the lanes of a block, and back: eight floats of each record at once. */
#ifndef DAFT_SIM_JOINT_RECORDS_H
#define DAFT_SIM_JOINT_RECORDS_H

#include "sim/joint/joint_lanes.h"

#include <float.h>
#include <stddef.h>

/* In rows of eight floats. */
enum { JOINT_ROWS = sizeof(daft_sim_joint) / 32, BODY_ROWS = sizeof(daft_sim_body) / 32 };
_Static_assert(sizeof(daft_sim_joint) % 32 == 0 && sizeof(daft_sim_body) % 32 == 0, "records are whole rows");
_Static_assert(offsetof(daft_sim_body, rotation) % 16 == 0, "lanes load it");

#define JOINT_ROW(joints, field)                                                                                       \
    ((const float *)(const void *)((const char *)(joints) + offsetof(daft_sim_joint, field)))

typedef struct places {
    int32_t row[DAFT_VL];
    vm used;
} places;

DAFT_INLINE places places_of(const uint32_t index[DAFT_SIM_LANES], int32_t rows, int lanes, int lane)
{
    places out;
    vi_store(out.row, vi_load(index + lane) * vi_set(rows));
    out.used = vm_from_bits(vbits_first_n(lanes - lane));
    return out;
}
/* Zero in lanes that are not in use. */
DAFT_INLINE void load_eight(const float *base, const places *at, vf out[8])
{
    vf_gather_rows8(base, at->row, out);
    for (int k = 0; k < 8; k++) out[k] = vf_if_then_else(at->used, out[k], zero());
}
DAFT_INLINE void put3(daft_sim_lanes *to, int lane, const vf v[3]) { store3(to, lane, (vf3){v[0], v[1], v[2]}); }
DAFT_INLINE void put4(daft_sim_lanes *to, int lane, const vf v[4])
{
    for (int k = 0; k < 4; k++) vf_store(to[k] + lane, v[k]);
}

/* How each side's body is turned; the world is not, and its anchor is its own centre. */
DAFT_INLINE void fill_sides(const daft_sim_joint_source *from, joint_block *block, const places *at, int lane)
{
    vf row[8];
    load_eight(JOINT_ROW(from->joints, frame), at, row);
    put4(block->side[0].frame0, lane, row), put4(block->side[1].frame0, lane, row + 4);
    vf anchor[8];
    load_eight(JOINT_ROW(from->joints, anchor), at, anchor);
    vf_store(block->lower + lane, anchor[6]);
    vf_store(block->upper + lane, anchor[7]);
    for (int i = 0; i < 2; i++) {
        places turned_by = places_of(from->body[i], BODY_ROWS, block->lanes, lane);
        vm world = vm_from_bits(from->world[i] >> lane & DAFT_ALL_LANES);
        load_eight(&from->bodies->rotation.x, &turned_by, row);
        for (int k = 0; k < 4; k++) row[k] = vf_if_then_else(world, vf_set(k == 3), row[k]);
        put4(block->side[i].rotation, lane, row);
        for (int k = 0; k < 3; k++) anchor[3 * i + k] = vf_if_then_else(world, zero(), anchor[3 * i + k]);
        put3(block->side[i].arm0, lane, anchor + 3 * i);
    }
}

DAFT_INLINE void fill_impulses(const daft_sim_joint_source *from, joint_block *block, const places *at, int lane)
{
    vf row[8], longer = vf_load(from->longer + lane);
    load_eight(JOINT_ROW(from->joints, linear_impulse), at, row);
    for (int k = 0; k < 8; k++) row[k] = row[k] * longer;
    put3(block->linear, lane, row), put3(block->angular, lane, row + 3);
    vf_store(block->lower_impulse + lane, row[6]);
    vf_store(block->upper_impulse + lane, row[7]);
    load_eight(JOINT_ROW(from->joints, spin), at, row);
    put3(block->side[0].spin, lane, row), put3(block->side[1].spin, lane, row + 3);
    vf_store(block->motor_impulse + lane, row[6] * longer);
    vf_store(block->spring_impulse + lane, row[7] * longer);
    store3(block->linear_sum, lane, none());
    store3(block->angular_sum, lane, none());
}

DAFT_INLINE void fill_lanes(const daft_sim_joint_source *from, joint_block *block, int lane)
{
    places at = places_of(from->joint, JOINT_ROWS, block->lanes, lane);
    fill_sides(from, block, &at, lane);
    fill_impulses(from, block, &at, lane);
    if (!block->motor && !block->spring && block->kind != DAFT_JOINT_DISTANCE) return;
    vf row[8];
    load_eight(JOINT_ROW(from->joints, motor_speed), &at, row);
    vf_store(block->motor_speed + lane, row[0]);
    vf_store(block->motor_force + lane, row[1]);
    vf_store(block->hertz + lane, row[2]);
    vf_store(block->damping + lane, row[3]);
    vf_store(block->length + lane, row[4]);
}

/* ---- and back ---- */

DAFT_INLINE vf finite1(vf x) { return vf_if_then_else(vf_le(vf_abs(x), vf_set(FLT_MAX)), x, zero()); }
/* All zero if one is not finite. */
DAFT_INLINE void get3(const daft_sim_lanes *from, int lane, vf out[3])
{
    vf most = vf_set(FLT_MAX);
    vm good = vf_le(zero(), zero());
    for (int k = 0; k < 3; k++) {
        out[k] = vf_load(from[k] + lane);
        good = vm_and(good, vf_le(vf_abs(out[k]), most));
    }
    for (int k = 0; k < 3; k++) out[k] = vf_if_then_else(good, out[k], zero());
}

DAFT_INLINE void store_lanes(const daft_sim_joint_source *to, const joint_block *block, float dt, int lane)
{
    places at = places_of(to->joint, JOINT_ROWS, block->lanes, lane);
    vbits used = vbits_from_mask(at.used);
    vf row[8];
    get3(block->linear, lane, row), get3(block->angular, lane, row + 3);
    row[6] = finite1(vf_load(block->lower_impulse + lane)), row[7] = finite1(vf_load(block->upper_impulse + lane));
    vf_scatter_rows8(&to->joints->linear_impulse.x, at.row, row, used);
    get3(block->side[0].spin, lane, row), get3(block->side[1].spin, lane, row + 3);
    row[6] = finite1(vf_load(block->motor_impulse + lane)), row[7] = finite1(vf_load(block->spring_impulse + lane));
    vf_scatter_rows8(&to->joints->spin[0].x, at.row, row, used);
    float force[DAFT_VL], torque[DAFT_VL];
    vf_store(force, finite1(length_of(load3(block->linear_sum, lane)) / vf_set(dt)));
    vf_store(torque, finite1(length_of(load3(block->angular_sum, lane)) / vf_set(dt)));
    for (int i = 0; i < DAFT_VL && lane + i < block->lanes; i++) {
        daft_sim_joint *joint = &to->joints[to->joint[lane + i]];
        joint->force = force[i], joint->torque = torque[i];
    }
}

#endif
