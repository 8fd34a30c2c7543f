/* Broad phase: which parts of a group overlap a box. A group is up to 16 neighbouring shapes with their bounds in rows
 * (groups.h); lanes are its parts. */
#include "sim/broad/groups.h"

#include "math/simd/ops.h"

DAFT_INLINE uint32_t meets(const daft_sim_boxes *boxes, const float low[3], const float high[3])
{
    uint32_t out = 0;
    for (int lane = 0; lane < DAFT_SIM_GROUP; lane += DAFT_VL) {
        vm m = vf_le(vf_set(low[0]), vf_load(boxes->high[0] + lane));
        m = vm_and(m, vf_le(vf_load(boxes->low[0] + lane), vf_set(high[0])));
        for (int axis = 1; axis < 3; axis++) {
            m = vm_and(m, vf_le(vf_set(low[axis]), vf_load(boxes->high[axis] + lane)));
            m = vm_and(m, vf_le(vf_load(boxes->low[axis] + lane), vf_set(high[axis])));
        }
        out |= (uint32_t)vbits_from_mask(m) << lane;
    }
    return out;
}

/* Of a group, those that a part of such reach finds: the larger ones, and of its own size those of higher index. */
DAFT_INLINE uint32_t found_by(const daft_sim_group *group, float reach, uint32_t part)
{
    uint32_t out = 0;
    for (int lane = 0; lane < DAFT_SIM_GROUP; lane += DAFT_VL) {
        vf mine = vf_set(reach), theirs = vf_load(group->reach + lane);
        vm later = vi_lt(vi_set((int32_t)part), vi_load(group->part + lane));
        vm m = vm_or(vf_lt(mine, theirs), vm_and(vf_le(mine, theirs), later));
        out |= (uint32_t)vbits_from_mask(m) << lane;
    }
    return out;
}

static uint32_t meets_any(const daft_sim_boxes *boxes, const float low[3], const float high[3])
{
    return meets(boxes, low, high);
}

static uint32_t cross(const daft_sim_group *group, const daft_sim_group *other, bool by_size,
                      uint32_t out[DAFT_SIM_CROSSINGS])
{
    uint32_t count = 0;
    for (uint32_t rows = meets(&group->boxes, other->low, other->high); rows; rows &= rows - 1) {
        uint32_t row = (uint32_t)__builtin_ctz(rows);
        const float low[3] = {group->boxes.low[0][row], group->boxes.low[1][row], group->boxes.low[2][row]};
        const float high[3] = {group->boxes.high[0][row], group->boxes.high[1][row], group->boxes.high[2][row]};
        uint32_t hits = meets(&other->boxes, low, high);
        if (by_size)
            hits &= found_by(other, group->reach[row], group->part[row]);
        else if (group == other)
            hits &= (uint32_t)-2 << row;
        /* Whether any are hit is anyone's guess, so it is not asked. */
        for (uint32_t half = 0; half < DAFT_SIM_GROUP; half += 8)
            count += v8i_store_set_bits(out + count, hits >> half & 0xff, (int32_t)(row * DAFT_SIM_GROUP + half));
    }
    return count;
}

const daft_sim_group_kernels DAFT_KERNEL(daft_sim_group) = {meets_any, cross};
