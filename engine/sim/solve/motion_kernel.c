/* Bodies in lanes, by rows that follow each other: what they gain of velocity, and where they go with it, in a substep.
 */
#include "sim/solve/lanes.h"

/* Rows that follow each other, side by side, counted from the first; where fewer are left than there are lanes, the
 * others are the first again. */
typedef struct row_lanes {
    size_t base; /* floats before the first row */
    const int32_t *index;
    vbits used;
} row_lanes;

static const int32_t IN_ORDER[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

DAFT_INLINE row_lanes rows_left(uint32_t first, uint32_t count, int32_t index[DAFT_VL])
{
    for (uint32_t i = 0; i < DAFT_VL; i++) index[i] = (int32_t)(i < count ? i : 0);
    return (row_lanes){(size_t)first * DAFT_SIM_ROW, index, vbits_first_n((int)count)};
}
DAFT_INLINE row_lanes rows_side_by_side(uint32_t first)
{
    return (row_lanes){(size_t)first * DAFT_SIM_ROW, IN_ORDER, DAFT_ALL_LANES};
}
DAFT_INLINE body load_row(const float *rows, const row_lanes *at) { return load_body(rows + at->base, at->index); }
DAFT_INLINE void store_row(float *rows, const row_lanes *at, const body *b)
{
    store_body(rows + at->base, at->index, b, at->used);
}

/* No longer than `most`; what is not finite becomes 0. Hardly any is that fast. */
DAFT_INLINE vf3 limit(vf3 v, vf most)
{
    vf square = vf3_dot(v, v), one = vf_set(1), zero = vf_set(0);
    vm within = vf_le(square, most * most), finite = vf_le(square, vf_set(3e38f));
    if (vbits_from_mask(within) == DAFT_ALL_LANES) return v;
    vf root = vf_sqrt(vf_if_then_else(finite, square, one));
    vf factor = vf_if_then_else(within, one, vf_if_then_else(finite, most / vf_if_then_else(within, one, root), zero));
    return vf3_select(vf_lt(zero, factor), vf3_scale(v, factor), (vf3){zero, zero, zero});
}

DAFT_INLINE void limit_body(body *b) { b->v = limit(b->v, b->rest[0]), b->w = limit(b->w, b->rest[1]); }

DAFT_INLINE void gain_lanes(const daft_sim_solver_bodies *rows, row_lanes at, vf h)
{
    body b = load_row(rows->velocity, &at), more = load_row(rows->gain, &at);
    vf left = load_row(rows->mass, &at).rest[1];
    b.v = vf3_add(vf3_scale(b.v, more.rest[1]), vf3_scale(more.v, h));
    b.w = vf3_add(vf3_scale(b.w, left), vf3_scale(more.w, h));
    limit_body(&b);
    store_row(rows->velocity, &at, &b);
}

static void gain(const daft_sim_solver_bodies *rows, uint32_t first, uint32_t count, float h)
{
    int32_t index[DAFT_VL];
    for (; count >= DAFT_VL; first += DAFT_VL, count -= DAFT_VL) gain_lanes(rows, rows_side_by_side(first), vf_set(h));
    if (count > 0) gain_lanes(rows, rows_left(first, count, index), vf_set(h));
}

/* q + (h/2 ω, 0)·q, normalised: the Cayley map, which turns by 2·atan(h|ω|/2). */
DAFT_INLINE void turn_lanes(vf q[4], vf3 w, vf h)
{
    vf half = vf_set(0.5f) * h, x = half * w.x, y = half * w.y, z = half * w.z, zero = vf_set(0);
    vf nx = q[0] + (x * q[3] + y * q[2] - z * q[1]), ny = q[1] + (y * q[3] + z * q[0] - x * q[2]);
    vf nz = q[2] + (z * q[3] + x * q[1] - y * q[0]), nw = q[3] - (x * q[0] + y * q[1] + z * q[2]);
    vf scale = vf_set(1) / vf_sqrt(nx * nx + ny * ny + nz * nz + nw * nw);
    vm still = vm_and(vm_and(vf_le(vf_abs(w.x), zero), vf_le(vf_abs(w.y), zero)), vf_le(vf_abs(w.z), zero));
    q[0] = vf_if_then_else(still, q[0], nx * scale), q[1] = vf_if_then_else(still, q[1], ny * scale);
    q[2] = vf_if_then_else(still, q[2], nz * scale), q[3] = vf_if_then_else(still, q[3], nw * scale);
}

DAFT_INLINE void move_lanes(const daft_sim_solver_bodies *rows, row_lanes at, vf h)
{
    body b = load_row(rows->velocity, &at), moved = load_row(rows->moved, &at);
    body more = load_row(rows->gain, &at);
    vf q[8], behind = vf_set(0.5f) * h * more.rest[0];
    vf_gather_rows8(rows->turn + at.base, at.index, q);
    limit_body(&b);
    moved.v = vf3_add(moved.v, vf3_scale(vf3_sub(b.v, vf3_scale(more.v, behind)), h));
    moved.w = vf3_add(moved.w, vf3_scale(b.w, h));
    turn_lanes(q, b.w, h);
    q[4] = moved.v.x, q[5] = moved.v.y, q[6] = moved.v.z;
    store_row(rows->velocity, &at, &b);
    store_row(rows->moved, &at, &moved);
    vf_scatter_rows8(rows->turn + at.base, at.index, q, at.used);
}

static void move(const daft_sim_solver_bodies *rows, uint32_t first, uint32_t count, float h)
{
    int32_t index[DAFT_VL];
    for (; count >= DAFT_VL; first += DAFT_VL, count -= DAFT_VL) move_lanes(rows, rows_side_by_side(first), vf_set(h));
    if (count > 0) move_lanes(rows, rows_left(first, count, index), vf_set(h));
}

DAFT_INLINE vbits far_lanes(const daft_sim_solver_bodies *rows, row_lanes at, float most)
{
    vf turn[8], one = vf_set(1), two = vf_set(2), zero = vf_set(0);
    vf3 w = load_row(rows->velocity, &at).w;
    vf_gather_rows8(rows->turn + at.base, at.index, turn);
    vbits watched = vbits_from_mask(vf_lt(zero, turn[7])), was = vbits_from_mask(vf_lt(one, turn[7])) & at.used;
    vbits far = vbits_from_mask(vf_lt(vf_set(most * most), vf3_dot(w, w))) & watched & at.used;
    if (far != was) {
        turn[7] = vf_if_then_else(vm_from_bits(far), two, vf_min(turn[7], one));
        vf_scatter_rows8(rows->turn + at.base, at.index, turn, far ^ was);
    }
    return far;
}

static uint32_t find_far(const daft_sim_solver_bodies *rows, uint32_t first, uint32_t count, float most)
{
    int32_t index[DAFT_VL];
    uint32_t far = 0, at = 0;
    for (; count - at >= DAFT_VL; at += DAFT_VL) far |= far_lanes(rows, rows_side_by_side(first + at), most) << at;
    if (count > at) far |= far_lanes(rows, rows_left(first + at, count - at, index), most) << at;
    return far;
}

const daft_sim_motion_kernels DAFT_KERNEL(daft_sim_motion) = {gain, move, find_far};
