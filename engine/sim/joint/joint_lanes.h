/* What the kernel of joints is made of: rotations, springs, small systems, and a block's lanes in one pass.
 *
 * The matrices are symmetric and positive, so L·D·Lᵀ without pivoting is stable in float, however far masses differ. */
#ifndef DAFT_SIM_JOINT_LANES_H
#define DAFT_SIM_JOINT_LANES_H

#include "math/simd/elementary.h"
#include "sim/joint/joints.h"
#include "sim/solve/lanes.h"

#include "math/vec.h"

typedef daft_sim_joint_block joint_block;
typedef daft_sim_joint_side joint_side;

typedef struct softness {
    vf rate, mass, impulse;
} softness;

/* A block's lanes from `lane` on, in one pass. */
typedef struct pass {
    joint_block *block;
    int lane;
    body a, b;
    vf inv_mass[2];
    vf inertia[2][6];
    vf3 arm[2];
    vf h, inv_h;
    bool biased;
} pass;

DAFT_INLINE vf zero(void) { return vf_set(0); }
DAFT_INLINE vf3 none(void) { return (vf3){zero(), zero(), zero()}; }
DAFT_INLINE vf3 vf3_neg(vf3 a) { return (vf3){-a.x, -a.y, -a.z}; }
DAFT_INLINE vf length_of(vf3 v) { return vf_sqrt(vf3_dot(v, v)); }

DAFT_INLINE quat load4(const daft_sim_lanes *p, int lane)
{
    return (quat){vf_load(p[0] + lane), vf_load(p[1] + lane), vf_load(p[2] + lane), vf_load(p[3] + lane)};
}
DAFT_INLINE quat conjugate(quat q) { return (quat){-q.x, -q.y, -q.z, q.w}; }
DAFT_INLINE vf3 rotate(quat q, vf3 v)
{
    vf3 u = {q.x, q.y, q.z}, t = vf3_scale(vf3_cross(u, v), vf_set(2));
    return vf3_add(v, vf3_add(vf3_scale(t, q.w), vf3_cross(u, t)));
}
/* The first axis of a frame. */
DAFT_INLINE vf3 first_axis(quat q)
{
    vf one = vf_set(1), two = vf_set(2);
    return (vf3){one - two * (q.y * q.y + q.z * q.z), two * (q.x * q.y + q.z * q.w), two * (q.x * q.z - q.y * q.w)};
}
/* q turned by `angle`, whose length is right to the fifth order, as daft_sim_turn does it. */
DAFT_INLINE quat turned(quat q, vf3 angle)
{
    vf3 half = vf3_scale(angle, vf_set(0.5f));
    half = vf3_scale(half, vf_set(1) + vf3_dot(half, half) * vf_set(1.0f / 3));
    quat by = {half.x, half.y, half.z, zero()}, spin = quat_mul(by, q);
    quat s = {q.x + spin.x, q.y + spin.y, q.z + spin.z, q.w + spin.w};
    vf scale = vf_set(1) / vf_sqrt(s.x * s.x + s.y * s.y + s.z * s.z + s.w * s.w);
    return (quat){s.x * scale, s.y * scale, s.z * scale, s.w * scale};
}

/* ---- springs ---- */

DAFT_INLINE softness make_soft(vf hertz, vf damping, vf h)
{
    vf omega = vf_set(2 * (float)DAFT_PI) * hertz, one = vf_set(1);
    vf a1 = vf_set(2) * damping + h * omega, a2 = h * omega * a1, a3 = one / (one + a2);
    vm some = vf_lt(zero(), omega);
    return (softness){vf_if_then_else(some, omega / vf_if_then_else(some, a1, one), zero()),
                      vf_if_then_else(some, a2 * a3, zero()), a3};
}
DAFT_INLINE softness load_soft(const daft_sim_softness *s, int lane)
{
    return (softness){vf_load(s->rate + lane), vf_load(s->mass + lane), vf_load(s->impulse + lane)};
}
DAFT_INLINE void store_soft(daft_sim_softness *to, int lane, softness s)
{
    vf_store(to->rate + lane, s.rate);
    vf_store(to->mass + lane, s.mass);
    vf_store(to->impulse + lane, s.impulse);
}
/* Of what is rigid in this pass. */
DAFT_INLINE softness stiff(const pass *p)
{
    if (p->biased) return load_soft(&p->block->stiff, p->lane);
    return (softness){zero(), vf_set(1), zero()};
}
/* Of a joint that gives as a whole, or is rigid. */
DAFT_INLINE softness whole(const pass *p) { return p->block->spring ? load_soft(&p->block->soft, p->lane) : stiff(p); }

/* ---- small systems ---- */

/* Of a symmetric, positive matrix, in the order of `symmetric`: l21, l31, l32 and the inverse of D, whose elements are
 * not below `least`. What rounding leaves of one that should be larger would make an impulse without bound. */
DAFT_INLINE void factorise(const vf m[6], vf least, daft_sim_lanes *out, int lane)
{
    vf floor = vf_max(least, vf_set(1e-7f) * vf_max(m[0], vf_max(m[3], m[5])));
    vf i1 = inverse(vf_max(m[0], floor)), l21 = m[1] * i1, l31 = m[2] * i1;
    vf i2 = inverse(vf_max(m[3] - l21 * m[1], floor)), e32 = m[4] - l31 * m[1], l32 = e32 * i2;
    vf i3 = inverse(vf_max(m[5] - l31 * m[2] - l32 * e32, floor));
    const vf all[6] = {l21, l31, l32, i1, i2, i3};
    for (int k = 0; k < 6; k++) vf_store(out[k] + lane, all[k]);
}
DAFT_INLINE vf3 solve3(const daft_sim_lanes *factor, int lane, vf3 b)
{
    vf l21 = vf_load(factor[0] + lane), l31 = vf_load(factor[1] + lane), l32 = vf_load(factor[2] + lane);
    vf y2 = b.y - l21 * b.x, y3 = b.z - l31 * b.x - l32 * y2;
    vf x3 = y3 * vf_load(factor[5] + lane), x2 = y2 * vf_load(factor[4] + lane) - l32 * x3;
    return (vf3){b.x * vf_load(factor[3] + lane) - l21 * x2 - l31 * x3, x2, x3};
}
DAFT_INLINE void factorise2(vf m11, vf m12, vf m22, daft_sim_lanes *out, int lane)
{
    vf floor = vf_set(1e-7f) * vf_max(m11, m22), i1 = inverse(vf_max(m11, floor)), l = m12 * i1;
    vf_store(out[0] + lane, l);
    vf_store(out[1] + lane, i1);
    vf_store(out[2] + lane, inverse(vf_max(m22 - l * m12, floor)));
}

/* ---- bodies ---- */

DAFT_INLINE vf3 relative_velocity(const pass *p)
{
    vf3 a = vf3_add(p->a.v, vf3_cross(p->a.w, p->arm[0]));
    return vf3_sub(vf3_add(p->b.v, vf3_cross(p->b.w, p->arm[1])), a);
}
DAFT_INLINE vf3 aimed_velocity(const pass *p)
{
    vf3 v = relative_velocity(p);
    return p->biased ? vf3_add(v, load3(p->block->bend, p->lane)) : v;
}
DAFT_INLINE vf3 relative_spin(const pass *p) { return vf3_sub(p->b.w, p->a.w); }

/* An impulse on b, its reverse on a. */
DAFT_INLINE void push(pass *p, vf3 impulse)
{
    p->a.v = vf3_sub(p->a.v, vf3_scale(impulse, p->inv_mass[0]));
    p->b.v = vf3_add(p->b.v, vf3_scale(impulse, p->inv_mass[1]));
    p->a.w = vf3_sub(p->a.w, symmetric(p->inertia[0], vf3_cross(p->arm[0], impulse)));
    p->b.w = vf3_add(p->b.w, symmetric(p->inertia[1], vf3_cross(p->arm[1], impulse)));
}
DAFT_INLINE void twist(pass *p, vf3 impulse)
{
    p->a.w = vf3_sub(p->a.w, symmetric(p->inertia[0], impulse));
    p->b.w = vf3_add(p->b.w, symmetric(p->inertia[1], impulse));
}

DAFT_INLINE void load_masses(pass *p)
{
    for (int i = 0; i < 2; i++) {
        const joint_side *side = &p->block->side[i];
        p->inv_mass[i] = vf_load(side->inv_mass + p->lane);
        for (int k = 0; k < 6; k++) p->inertia[i][k] = vf_load(side->inertia[k] + p->lane);
        p->arm[i] = load3(side->arm, p->lane);
    }
}
DAFT_INLINE pass begin_pass(const daft_sim_solver_bodies *rows, joint_block *block, int lane,
                            const daft_sim_substep *substep, bool biased)
{
    pass p = {.block = block, .lane = lane, .h = vf_set(substep->h), .inv_h = vf_set(substep->inv_h), .biased = biased};
    load_masses(&p);
    p.a = load_body(rows->velocity, block->side[0].row + lane);
    p.b = load_body(rows->velocity, block->side[1].row + lane);
    return p;
}
DAFT_INLINE void end_pass(const daft_sim_solver_bodies *rows, const pass *p)
{
    const joint_side *side = p->block->side;
    store_body(rows->velocity, side[0].row + p->lane, &p->a, side[0].writes >> p->lane);
    store_body(rows->velocity, side[1].row + p->lane, &p->b, side[1].writes >> p->lane);
}

#endif
