/* Joints as constraints, in lanes. Their frames are turned with the bodies in every substep, so that what they hold
 * together stays together while it turns; what follows from where they are is computed once a substep.
 *
 * A pass with springs (biased) draws errors out and aims at the end of the substep: a point on an arm that turns is
 * carried along a circle, whose second-order term h/2·w×(w×r) is part of what it aims at. The pass without springs
 * then takes the velocity back onto what the joint allows where the bodies now are. Together they are close to the
 * RATTLE scheme (Andersen 1983), which is symplectic: a pendulum keeps its energy.
 *
 * The matrices are symmetric and positive, so L·D·Lᵀ without pivoting is stable in float, however far masses differ. */
#include "math/simd_real.h"
#include "sim/joints.h"
#include "sim/lanes.h"

#include "math/vec.h"

/* Rigid joints are springs as stiff as the substeps allow. */
#define JOINT_HERTZ_SHARE 0.35f /* of the substeps' rate */
#define JOINT_DAMPING     5.0f
#define NO_LIMIT          3e38f
#define MOST_IMPULSE      1e37f /* what is beyond is forgotten, and so is what is not finite */

typedef daft_sim_joint_block joint_block;
typedef daft_sim_joint_side joint_side;

typedef struct quat {
    vf x, y, z, w;
} quat;

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
DAFT_INLINE vf3 vf3_select(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_select(m, a.x, b.x), vf_select(m, a.y, b.y), vf_select(m, a.z, b.z)};
}
DAFT_INLINE vf length_of(vf3 v) { return vf_sqrt(vf3_dot(v, v)); }

DAFT_INLINE quat load4(const daft_sim_lanes *p, int lane)
{
    return (quat){vf_load(p[0] + lane), vf_load(p[1] + lane), vf_load(p[2] + lane), vf_load(p[3] + lane)};
}
DAFT_INLINE quat quat_mul(quat a, quat b)
{
    return (quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                  a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
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
    return (softness){vf_select(some, omega / vf_select(some, a1, one), zero()), vf_select(some, a2 * a3, zero()), a3};
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
DAFT_INLINE softness whole(const pass *p)
{
    return p->block->spring ? load_soft(&p->block->soft, p->lane) : stiff(p);
}

/* ---- small systems ---- */

/* Of a symmetric, positive matrix, in the order of `symmetric`: l21, l31, l32 and the inverse of D, whose elements are not
 * below `least`. What rounding leaves of one that should be larger would make an impulse without bound. */
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
DAFT_INLINE pass begin_pass(const daft_sim_rows *rows, joint_block *block, int lane, const daft_sim_substep *substep,
                            bool biased)
{
    pass p = {.block = block, .lane = lane, .h = vf_set(substep->h), .inv_h = vf_set(substep->inv_h), .biased = biased};
    load_masses(&p);
    p.a = load_body(rows->velocity, block->side[0].row + lane);
    p.b = load_body(rows->velocity, block->side[1].row + lane);
    return p;
}
DAFT_INLINE void end_pass(const daft_sim_rows *rows, const pass *p)
{
    const joint_side *side = p->block->side;
    store_body(rows->velocity, side[0].row + p->lane, &p->a, side[0].writes >> p->lane);
    store_body(rows->velocity, side[1].row + p->lane, &p->b, side[1].writes >> p->lane);
}

/* ---- constraints ---- */

/* The anchors stay together, by an impulse of at most `most`. */
DAFT_INLINE void solve_points(pass *p, softness s, const vf *most)
{
    joint_block *block = p->block;
    vf3 old = load3(block->linear, p->lane);
    vf3 wrong = vf3_add(aimed_velocity(p), vf3_scale(load3(block->offset, p->lane), s.rate));
    vf3 change = vf3_scale(solve3(block->point, p->lane, wrong), -s.mass);
    vf3 wanted = vf3_add(old, vf3_sub(change, vf3_scale(old, s.impulse)));
    if (most) wanted = vf3_scale(wanted, shorten(vf3_dot(wanted, wanted), *most));
    store3(block->linear, p->lane, wanted);
    push(p, vf3_sub(wanted, old));
}

/* The impulse along the block's two directions that undoes an error of speed there. */
DAFT_INLINE vf3 solve_pair(const pass *p, vf3 speed, vf3 error, vf3 old, softness s)
{
    const joint_block *block = p->block;
    vf3 d0 = load3(block->pair[0], p->lane), d1 = load3(block->pair[1], p->lane);
    vf3 wrong = vf3_add(speed, vf3_scale(error, s.rate));
    vf l = vf_load(block->pair_mass[0] + p->lane), keeps = vf_set(1) - s.impulse;
    vf b0 = vf3_dot(wrong, d0), b1 = vf3_dot(wrong, d1) - l * b0;
    vf x1 = b1 * vf_load(block->pair_mass[2] + p->lane), x0 = b0 * vf_load(block->pair_mass[1] + p->lane) - l * x1;
    return vf3_add(vf3_scale(d0, vf3_dot(old, d0) * keeps - s.mass * x0),
                   vf3_scale(d1, vf3_dot(old, d1) * keeps - s.mass * x1));
}

/* The axes of a hinge stay together. */
DAFT_INLINE void solve_axes(pass *p)
{
    vf3 old = load3(p->block->angular, p->lane), error = load3(p->block->error, p->lane);
    vf3 wanted = solve_pair(p, relative_spin(p), error, old, stiff(p));
    store3(p->block->angular, p->lane, wanted);
    twist(p, vf3_sub(wanted, old));
}

/* The anchors of a slider stay together but along its axis. */
DAFT_INLINE void solve_line(pass *p)
{
    vf3 old = load3(p->block->linear, p->lane), offset = load3(p->block->offset, p->lane);
    vf3 wanted = solve_pair(p, aimed_velocity(p), offset, old, stiff(p));
    store3(p->block->linear, p->lane, wanted);
    push(p, vf3_sub(wanted, old));
}

DAFT_INLINE void solve_turn(pass *p, softness s)
{
    joint_block *block = p->block;
    vf3 old = load3(block->angular, p->lane);
    vf3 wrong = vf3_add(relative_spin(p), vf3_scale(load3(block->error, p->lane), s.rate));
    vf3 change = vf3_sub(vf3_scale(solve3(block->turn, p->lane, wrong), -s.mass), vf3_scale(old, s.impulse));
    store3(block->angular, p->lane, vf3_add(old, change));
    twist(p, change);
}

/* Friction in a ball joint: it brakes the turning of b against a by up to the motor's torque. */
DAFT_INLINE void solve_brake(pass *p)
{
    joint_block *block = p->block;
    vf3 old = load3(block->angular, p->lane), wanted = vf3_sub(old, solve3(block->turn, p->lane, relative_spin(p)));
    wanted = vf3_scale(wanted, shorten(vf3_dot(wanted, wanted), vf_load(block->motor_force + p->lane) * p->h));
    store3(block->angular, p->lane, wanted);
    twist(p, vf3_sub(wanted, old));
}

/* ---- the free direction ---- */

/* Hinges and cones turn in it, others move. */
DAFT_INLINE bool is_angular(const joint_block *block)
{
    return block->kind == DAFT_JOINT_HINGE || block->kind == DAFT_JOINT_BALL;
}

DAFT_INLINE vf free_speed(const pass *p)
{
    const joint_block *block = p->block;
    vf speed = vf3_dot(load3(block->free_arm[1], p->lane), p->b.w) - vf3_dot(load3(block->free_arm[0], p->lane), p->a.w);
    if (is_angular(block)) return speed;
    return speed + vf3_dot(load3(block->along, p->lane), vf3_sub(p->b.v, p->a.v));
}
DAFT_INLINE void push_free(pass *p, vf impulse)
{
    const joint_block *block = p->block;
    p->a.w = vf3_sub(p->a.w, vf3_scale(load3(block->free_push[0], p->lane), impulse));
    p->b.w = vf3_add(p->b.w, vf3_scale(load3(block->free_push[1], p->lane), impulse));
    if (is_angular(block)) return;
    vf3 along = load3(block->along, p->lane);
    p->a.v = vf3_sub(p->a.v, vf3_scale(along, p->inv_mass[0] * impulse));
    p->b.v = vf3_add(p->b.v, vf3_scale(along, p->inv_mass[1] * impulse));
}

/* sign -1: of the speed the other way. */
DAFT_INLINE void solve_free(pass *p, float sign, vf bias, softness s, float *impulse, vf low, vf high)
{
    vf old = vf_load(impulse), mass = vf_load(p->block->free_mass + p->lane);
    vf wanted = old - mass * s.mass * (free_speed(p) * vf_set(sign) + bias) - s.impulse * old;
    wanted = vf_min(vf_max(wanted, low), high);
    vf_store(impulse, wanted);
    push_free(p, (wanted - old) * vf_set(sign));
}

/* What is within a limit may reach it in this substep and no more. */
DAFT_INLINE void solve_limit(pass *p, float sign, vf room, float *impulse)
{
    softness s = stiff(p);
    vm within = vf_lt(zero(), room);
    s.mass = vf_select(within, vf_set(1), s.mass), s.impulse = vf_select(within, zero(), s.impulse);
    vf bias = vf_select(within, room * p->inv_h, room * s.rate);
    solve_free(p, sign, bias, s, impulse, zero(), vf_set(NO_LIMIT));
}

DAFT_INLINE void solve_limits(pass *p, vf value)
{
    joint_block *block = p->block;
    vf lower = vf_load(block->lower + p->lane), upper = vf_load(block->upper + p->lane);
    if (block->kind == DAFT_JOINT_HINGE) { /* beyond a limit is not beyond the other */
        vf turn = vf_set((float)(2 * DAFT_PI)), half = vf_set((float)DAFT_PI), d = value - vf_set(0.5f) * (lower + upper);
        value = vf_select(vf_lt(half, d), value - turn, vf_select(vf_lt(d, -half), value + turn, value));
    }
    if (block->kind != DAFT_JOINT_BALL) solve_limit(p, 1, value - lower, block->lower_impulse + p->lane);
    solve_limit(p, -1, upper - value, block->upper_impulse + p->lane);
}

/* The spring, the motor and the limits of a hinge or slider. */
DAFT_INLINE void solve_drive(pass *p)
{
    joint_block *block = p->block;
    vf value = vf_load(block->value + p->lane), no_limit = vf_set(NO_LIMIT);
    if (block->spring && p->biased) {
        softness s = load_soft(&block->soft, p->lane);
        solve_free(p, 1, value * s.rate, s, block->spring_impulse + p->lane, -no_limit, no_limit);
    }
    if (block->motor) {
        vf most = vf_load(block->motor_force + p->lane) * p->h;
        const softness rigid = {zero(), vf_set(1), zero()};
        solve_free(p, 1, -vf_load(block->motor_speed + p->lane), rigid, block->motor_impulse + p->lane, -most, most);
    }
    if (block->limit) solve_limits(p, value);
}

/* A rod: what its bodies' arms and it itself bend by is second order, as it is for points. */
DAFT_INLINE vf rod_bend(const pass *p, vf length)
{
    vf3 d = load3(p->block->along, p->lane), v = relative_velocity(p);
    vf along = vf3_dot(v, d), across = vf3_dot(v, v) - along * along;
    vf turning = vf_select(vf_lt(vf_set(1e-9f), length), vf_set(0.5f) * p->h * across / length, zero());
    return vf3_dot(load3(p->block->bend, p->lane), d) + turning;
}

DAFT_INLINE void solve_distance(pass *p)
{
    joint_block *block = p->block;
    vf value = vf_load(block->value + p->lane), error = value - vf_load(block->length + p->lane);
    vf no_limit = vf_set(NO_LIMIT);
    float *impulse = block->spring_impulse + p->lane;
    if (block->spring) {
        softness s = load_soft(&block->soft, p->lane);
        if (p->biased) solve_free(p, 1, error * s.rate, s, impulse, -no_limit, no_limit);
    } else if (!block->limit) {
        softness s = stiff(p);
        vf bias = p->biased ? error * s.rate + rod_bend(p, value) : zero();
        solve_free(p, 1, bias, s, impulse, -no_limit, no_limit);
    }
    if (block->limit) solve_limits(p, value);
}

/* ---- where joints are ---- */

DAFT_INLINE quat load_turn(const daft_sim_rows *rows, const int32_t *index)
{
    vf row[8];
    vf_load_rows8(rows->turn, index, row);
    return (quat){row[0], row[1], row[2], row[3]};
}

/* Where the anchors are now. */
DAFT_INLINE void place_arms(const daft_sim_rows *rows, joint_block *block, const quat turn[2], int lane)
{
    vf3 moved[2];
    for (int i = 0; i < 2; i++) {
        joint_side *side = &block->side[i];
        vf3 arm0 = load3(side->arm0, lane), arm = rotate(turn[i], arm0);
        moved[i] = vf3_add(load_body(rows->moved, side->row + lane).v, vf3_sub(arm, arm0));
        store3(side->arm, lane, arm);
    }
    store3(block->offset, lane, vf3_add(vf3_sub(load3(block->offset0, lane), moved[0]), moved[1]));
}

/* Of the relative velocity at the anchors to impulses there. */
DAFT_INLINE void place_points(pass *p)
{
    vf mass = p->inv_mass[0] + p->inv_mass[1], m[6] = {mass, zero(), zero(), mass, zero(), mass};
    for (int i = 0; i < 2; i++) {
        vf3 r = p->arm[i], x = {zero(), r.z, -r.y}, y = {-r.z, zero(), r.x}, z = {r.y, -r.x, zero()}; /* r × an axis */
        vf3 sx = symmetric(p->inertia[i], x), sy = symmetric(p->inertia[i], y), sz = symmetric(p->inertia[i], z);
        m[0] = m[0] + vf3_dot(x, sx), m[1] = m[1] + vf3_dot(x, sy), m[2] = m[2] + vf3_dot(x, sz);
        m[3] = m[3] + vf3_dot(y, sy), m[4] = m[4] + vf3_dot(y, sz), m[5] = m[5] + vf3_dot(z, sz);
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
    vf twice = vf_select(vf_lt(d.w, zero()), vf_set(-2), vf_set(2));
    return vf3_scale((vf3){d.x, d.y, d.z}, twice);
}
/* Within ±pi. */
DAFT_INLINE vf hinge_angle(const quat frame[2])
{
    quat d = quat_mul(conjugate(frame[0]), frame[1]);
    vf sign = vf_select(vf_lt(d.w, zero()), vf_set(-1), vf_set(1));
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

/* The cone about axis a that axis b stays in. */
DAFT_INLINE void place_cone(pass *p, vf3 axis, vf3 other)
{
    vf3 normal = vf3_cross(axis, other);
    vf sine = length_of(normal);
    vm leans = vf_lt(vf_set(1e-6f), sine); /* else there is no direction */
    vf3 along = vf3_scale(normal, vf_select(leans, vf_set(1) / vf_select(leans, sine, vf_set(1)), zero()));
    place_free(p, along, vf_atan2(sine, vf3_dot(axis, other)));
}
DAFT_INLINE void place_distance(pass *p)
{
    vf3 offset = load3(p->block->offset, p->lane), up = {zero(), vf_set(1), zero()};
    vf length = length_of(offset);
    vm apart = vf_lt(vf_set(1e-9f), length);
    vf3 along = vf3_select(apart, vf3_scale(offset, vf_set(1) / vf_select(apart, length, vf_set(1))), up);
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
}

DAFT_INLINE void refresh_masses(const daft_sim_rows *rows, joint_block *block, int lane)
{
    for (int i = 0; i < 2; i++) {
        vf row[8];
        vf_load_rows8(rows->mass, block->side[i].row + lane, row);
        vf_store(block->side[i].inv_mass + lane, row[0]);
        for (int k = 0; k < 6; k++) vf_store(block->side[i].inertia[k] + lane, row[k + 1]);
    }
}

/* ---- the passes ---- */

/* Everything as the step begins. */
DAFT_INLINE void prepare_lanes(const daft_sim_rows *rows, joint_block *block, const daft_sim_substep *substep, int lane)
{
    refresh_masses(rows, block, lane);
    vf3 arm[2];
    for (int i = 0; i < 2; i++) {
        joint_side *side = &block->side[i];
        quat q = load4(side->rotation, lane), f = quat_mul(q, load4(side->frame0, lane));
        const vf frame[4] = {f.x, f.y, f.z, f.w};
        arm[i] = rotate(q, load3(side->arm0, lane));
        store3(side->arm0, lane, arm[i]);
        store3(side->arm, lane, arm[i]);
        for (int k = 0; k < 4; k++) vf_store(side->frame0[k] + lane, frame[k]);
    }
    vf3 offset = vf3_add(load3(block->offset0, lane), vf3_sub(arm[1], arm[0]));
    store3(block->offset0, lane, offset);
    store3(block->offset, lane, offset);
    vf h = vf_set(substep->h);
    softness s = make_soft(vf_set(JOINT_HERTZ_SHARE * substep->inv_h), vf_set(JOINT_DAMPING), h);
    pass p = {.block = block, .lane = lane};
    load_masses(&p);
    vm both = vm_and(vf_lt(zero(), p.inv_mass[0]), vf_lt(zero(), p.inv_mass[1]));
    s.mass = vf_select(both, s.mass, vf_set(1)), s.impulse = vf_select(both, s.impulse, zero());
    store_soft(&block->stiff, lane, s);
    if (block->spring)
        store_soft(&block->soft, lane, make_soft(vf_load(block->hertz + lane), vf_load(block->damping + lane), h));
    const quat unturned = {zero(), zero(), zero(), vf_set(1)}, turn[2] = {unturned, unturned};
    lengthen_arm(&p);
    place_directions(&p, turn);
}

/* What a point's mean velocity on its arm over a substep differs by from w×arm: the arm turns by the Cayley map of
 * h·w, which with u = h/2·w takes it to arm + 2/(1 + u²)·(u×arm + u×(u×arm)). */
DAFT_INLINE vf3 bend(vf3 w, vf3 arm, vf h)
{
    vf3 straight = vf3_cross(w, arm);
    vf square = vf_set(0.25f) * h * h * vf3_dot(w, w);
    vf3 inward = vf3_scale(vf3_cross(w, straight), vf_set(0.5f) * h);
    return vf3_scale(vf3_sub(inward, vf3_scale(straight, square)), vf_set(1) / (vf_set(1) + square));
}

/* The angular velocity a body will have in this substep, when forces have acted: as much more as in the last one, unless
 * that was a jolt. */
DAFT_INLINE vf3 expected_spin(joint_side *side, vf3 now, int lane)
{
    vf3 change = vf3_sub(now, load3(side->spin, lane));
    store3(side->spin, lane, now);
    vm smooth = vf_lt(vf3_dot(change, change), vf_set(0.01f) * vf3_dot(now, now));
    return vf3_select(smooth, vf3_add(now, change), now);
}

/* A rod without a limit is kept at its length by the spring's impulse, too. */
DAFT_INLINE bool springs(const joint_block *block)
{
    return block->spring || (block->kind == DAFT_JOINT_DISTANCE && !block->limit);
}

/* What is not finite, or nearly, becomes 0. */
DAFT_INLINE vf bounded(float *impulse)
{
    vf x = vf_load(impulse);
    x = vf_select(vf_lt(vf_abs(x), vf_set(MOST_IMPULSE)), x, zero());
    vf_store(impulse, x);
    return x;
}
DAFT_INLINE vf3 bounded3(daft_sim_lanes *impulse, int lane)
{
    return (vf3){bounded(impulse[0] + lane), bounded(impulse[1] + lane), bounded(impulse[2] + lane)};
}

/* What the joint carries turns with the bodies: an impulse along a rod stays along it. Left as it was, it would twist a
 * light bob about its own centre. */
DAFT_INLINE void carry(pass *p, vf3 *linear, vf3 *angular)
{
    vm yields_a = vf_lt(zero(), p->inv_mass[0]), yields_b = vf_lt(zero(), p->inv_mass[1]);
    vf3 w = vf3_add(vf3_select(yields_a, p->a.w, none()), vf3_select(yields_b, p->b.w, none()));
    vf share = vf_select(vm_and(yields_a, yields_b), vf_set(0.25f), vf_set(0.5f));
    const quat unturned = {zero(), zero(), zero(), vf_set(1)};
    quat turn = turned(unturned, vf3_scale(w, share * p->h));
    *linear = rotate(turn, *linear), *angular = rotate(turn, *angular);
}

/* What it carries along the free direction. */
DAFT_INLINE vf free_impulse(joint_block *block, int lane)
{
    vf sum = zero();
    if (springs(block)) sum = sum + bounded(block->spring_impulse + lane);
    if (block->motor) sum = sum + bounded(block->motor_impulse + lane);
    if (block->limit) sum = sum + bounded(block->lower_impulse + lane) - bounded(block->upper_impulse + lane);
    return sum;
}

DAFT_INLINE bool has_free(const joint_block *block)
{
    return block->kind == DAFT_JOINT_HINGE || block->kind == DAFT_JOINT_SLIDER || block->kind == DAFT_JOINT_DISTANCE;
}

DAFT_INLINE void warm_start_lanes(const daft_sim_rows *rows, joint_block *block, const daft_sim_substep *substep, int lane)
{
    pass p = begin_pass(rows, block, lane, substep, true);
    lengthen_arm(&p);
    vf3 w[2] = {p.a.w, p.b.w}, bent[2];
    for (int i = 0; i < 2; i++) bent[i] = bend(expected_spin(&block->side[i], w[i], lane), p.arm[i], p.h);
    store3(block->bend, lane, vf3_sub(bent[1], bent[0]));
    vf3 linear = bounded3(block->linear, lane), angular = bounded3(block->angular, lane);
    carry(&p, &linear, &angular);
    store3(block->linear, lane, linear);
    store3(block->angular, lane, angular);
    if (has_free(block)) push_free(&p, free_impulse(block, lane));
    if (block->kind == DAFT_JOINT_BALL && block->limit) push_free(&p, -bounded(block->upper_impulse + lane));
    push(&p, linear);
    twist(&p, angular);
    end_pass(rows, &p);
}

/* The order matters: what comes last holds best. A joint that is soft as a whole is not relaxed. */
DAFT_INLINE void solve_all(pass *p)
{
    joint_block *block = p->block;
    bool acts = p->biased || !block->spring;
    lengthen_arm(p);
    switch (block->kind) {
    case DAFT_JOINT_BALL:
        if (block->motor) solve_brake(p);
        if (block->limit) solve_limits(p, vf_load(block->value + p->lane));
        if (acts) solve_points(p, whole(p), NULL);
        break;
    case DAFT_JOINT_HINGE:
        solve_drive(p);
        solve_axes(p);
        solve_points(p, stiff(p), NULL);
        break;
    case DAFT_JOINT_SLIDER:
        solve_drive(p);
        solve_turn(p, stiff(p));
        solve_line(p);
        break;
    case DAFT_JOINT_DISTANCE: solve_distance(p); break;
    case DAFT_JOINT_FIXED:
        if (acts) solve_turn(p, whole(p));
        if (acts) solve_points(p, whole(p), NULL);
        break;
    case DAFT_JOINT_DRAG: {
        vf force = vf_load(block->motor_force + p->lane);
        vf most = vf_select(vf_lt(zero(), force), force * p->h, vf_set(NO_LIMIT));
        if (p->biased) solve_points(p, whole(p), &most);
        break;
    }
    }
}

DAFT_INLINE void add_sums(joint_block *block, int lane)
{
    vf3 linear = load3(block->linear, lane), angular = load3(block->angular, lane);
    if (has_free(block)) {
        vf3 along = vf3_scale(load3(block->along, lane), free_impulse(block, lane));
        if (block->kind == DAFT_JOINT_HINGE) angular = vf3_add(angular, along);
        if (block->kind != DAFT_JOINT_HINGE) linear = vf3_add(linear, along);
    }
    store3(block->linear_sum, lane, vf3_add(load3(block->linear_sum, lane), linear));
    store3(block->angular_sum, lane, vf3_add(load3(block->angular_sum, lane), angular));
}

DAFT_INLINE void relax_lanes(const daft_sim_rows *rows, joint_block *block, const daft_sim_substep *substep, bool place,
                             bool turned_far, int lane)
{
    quat turn[2] = {0};
    for (int i = 0; (place || has_frames(block)) && i < 2; i++) turn[i] = load_turn(rows, block->side[i].row + lane);
    if (place) place_arms(rows, block, turn, lane);
    if (turned_far) refresh_masses(rows, block, lane);
    pass p = begin_pass(rows, block, lane, substep, false), at = p;
    lengthen_arm(&at);
    place_directions(&at, turn);
    solve_all(&p);
    end_pass(rows, &p);
    add_sums(block, lane);
}

/* ---- what opened ---- */

/* Where a blow moves the anchors apart by more, in metres, the bodies are put back, without a change of velocity. What was
 * apart before the step is left to springs: joints that cannot all be held would toss their bodies about. */
#define MOST_OPEN 0.003f

DAFT_INLINE void shift(const daft_sim_rows *rows, const pass *p, const quat *turn, int i, vf3 impulse, vbits open)
{
    const joint_side *side = &p->block->side[i];
    const int32_t *index = side->row + p->lane;
    body moved = load_body(rows->moved, index);
    vf3 angle = symmetric(p->inertia[i], vf3_cross(p->arm[i], impulse));
    moved.v = vf3_add(moved.v, vf3_scale(impulse, p->inv_mass[i]));
    moved.w = vf3_add(moved.w, angle);
    store_body(rows->moved, index, &moved, side->writes >> p->lane & open);
    quat q = turned(*turn, angle);
    vf row[8];
    vf_load_rows8(rows->turn, index, row);
    row[0] = q.x, row[1] = q.y, row[2] = q.z, row[3] = q.w;
    vf_store_rows8(rows->turn, index, row, side->writes >> p->lane & open);
}

DAFT_INLINE bool close_lanes(const daft_sim_rows *rows, joint_block *block, int lane)
{
    const quat turn[2] = {load_turn(rows, block->side[0].row + lane), load_turn(rows, block->side[1].row + lane)};
    place_arms(rows, block, turn, lane);
    if (block->spring || block->kind == DAFT_JOINT_SLIDER || block->kind == DAFT_JOINT_DISTANCE) return false;
    vf3 offset = load3(block->offset, lane);
    vf apart = length_of(offset), most = vf_set(MOST_OPEN) + length_of(load3(block->offset0, lane));
    vm opened = vf_lt(most, apart);
    vbits open = vm_bits(opened);
    if (!open) return false;
    pass p = {.block = block, .lane = lane};
    load_masses(&p);
    place_points(&p);
    vf excess = vf_select(opened, (apart - most) / vf_select(opened, apart, vf_set(1)), zero());
    vf3 impulse = solve3(block->point, lane, vf3_scale(offset, excess));
    shift(rows, &p, &turn[0], 0, impulse, open);
    shift(rows, &p, &turn[1], 1, vf3_neg(impulse), open);
    return true;
}

/* ---- blocks ---- */

static void prepare(const daft_sim_rows *rows, joint_block *blocks, uint32_t count, const daft_sim_substep *substep)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) prepare_lanes(rows, &blocks[i], substep, lane);
}
static void warm_start(const daft_sim_rows *rows, joint_block *blocks, uint32_t count, const daft_sim_substep *substep)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) warm_start_lanes(rows, &blocks[i], substep, lane);
}
static void solve(const daft_sim_rows *rows, joint_block *blocks, uint32_t count, const daft_sim_substep *substep)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) {
            pass p = begin_pass(rows, &blocks[i], lane, substep, true);
            solve_all(&p);
            end_pass(rows, &p);
        }
}
static bool close(const daft_sim_rows *rows, joint_block *blocks, uint32_t count)
{
    bool moved = false;
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) moved |= close_lanes(rows, &blocks[i], lane);
    return moved;
}
static void relax(const daft_sim_rows *rows, joint_block *blocks, uint32_t count, const daft_sim_substep *substep, bool place,
                  bool turned_far)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL)
            relax_lanes(rows, &blocks[i], substep, place, turned_far, lane);
}

const daft_sim_joint_kernels DAFT_KERNEL(daft_sim_joint) = {prepare, warm_start, solve, close, relax};
