/* Joints as constraints, in lanes. Their frames are turned with the bodies in every substep, so that what they hold
 * together stays together while it turns; what follows from where they are is computed once a substep.
 *
 * A pass with springs (biased) draws errors out and aims at the end of the substep: a point on an arm that turns is
 * carried along a circle, whose second-order term h/2·w×(w×r) is part of what it aims at. The pass without springs
 * then takes the velocity back onto what the joint allows where the bodies now are. Together they are close to the
 * RATTLE scheme (Andersen 1983), which is symplectic: a pendulum keeps its energy. */
#include "sim/joint/joint_place.h"
#include "sim/joint/joint_records.h"

/* Rigid joints are springs as stiff as the substeps allow. */
#define JOINT_HERTZ_FRACTION 0.35f /* of the substeps' rate */
#define JOINT_DAMPING        5.0f
#define NO_LIMIT             3e38f
#define MAX_IMPULSE          1e37f /* what is beyond is forgotten, and so is what is not finite */

/* Where a blow moves the anchors apart by more than they were, in metres, the bodies are put back, without a change of
 * velocity. What was apart before the step is left to springs: joints that cannot all be held would toss their bodies
 * about. */
#define MAX_OPEN 0.003f

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

DAFT_INLINE vf free_speed(const pass *p)
{
    const joint_block *block = p->block;
    vf speed =
        vf3_dot(load3(block->free_arm[1], p->lane), p->b.w) - vf3_dot(load3(block->free_arm[0], p->lane), p->a.w);
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

DAFT_INLINE void push_limit(pass *p, vf impulse)
{
    joint_block *block = p->block;
    push_free(p, impulse);
    if (!holds_limit(block)) return;
    vf3 hold = vf3_scale(load3(block->limit_hold, p->lane), impulse);
    store3(block->linear, p->lane, vf3_add(load3(block->linear, p->lane), hold));
    push(p, hold);
}

DAFT_INLINE vf wanted_free(vf mass, vf wrong, softness s, vf old, vf low, vf high)
{
    return vf_min(vf_max(old - mass * s.mass * wrong - s.impulse * old, low), high);
}
DAFT_INLINE void solve_free(pass *p, vf bias, softness s, float *impulse, vf low, vf high)
{
    vf old = vf_load(impulse), mass = vf_load(p->block->free_mass + p->lane);
    vf wanted = wanted_free(mass, free_speed(p) + bias, s, old, low, high);
    vf_store(impulse, wanted);
    push_free(p, wanted - old);
}

/* What is within a limit may reach it in this substep and no more. Mostly it does not, in any lane. `speed`: in the
 * free direction, before and after. */
DAFT_INLINE void solve_limit(pass *p, float sign, vf room, float *impulse, vf *speed)
{
    softness s = stiff(p);
    vm within = vf_lt(zero(), room);
    s.mass = vf_if_then_else(within, vf_set(1), s.mass), s.impulse = vf_if_then_else(within, zero(), s.impulse);
    vf bias = vf_if_then_else(within, room * p->inv_h, room * s.rate), old = vf_load(impulse);
    vf mass = vf_load((holds_limit(p->block) ? p->block->limit_mass : p->block->free_mass) + p->lane);
    vf wanted = wanted_free(mass, *speed * vf_set(sign) + bias, s, old, zero(), vf_set(NO_LIMIT));
    if (!vbits_from_mask(vm_or(vf_lt(zero(), wanted), vf_lt(zero(), vf_abs(old))))) return;
    vf_store(impulse, wanted);
    push_limit(p, (wanted - old) * vf_set(sign));
    *speed = free_speed(p);
}

DAFT_INLINE void solve_limits(pass *p, vf value)
{
    joint_block *block = p->block;
    vf lower = vf_load(block->lower + p->lane), upper = vf_load(block->upper + p->lane);
    if (block->kind == DAFT_JOINT_HINGE) { /* beyond a limit is not beyond the other */
        vf turn = vf_set((float)(2 * DAFT_PI)), half = vf_set((float)DAFT_PI),
           d = value - vf_set(0.5f) * (lower + upper);
        value = vf_if_then_else(vf_lt(half, d), value - turn, vf_if_then_else(vf_lt(d, -half), value + turn, value));
    }
    vf speed = free_speed(p);
    if (block->kind != DAFT_JOINT_BALL) solve_limit(p, 1, value - lower, block->lower_impulse + p->lane, &speed);
    solve_limit(p, -1, upper - value, block->upper_impulse + p->lane, &speed);
}

/* The spring, the motor and the limits of a hinge or slider. */
DAFT_INLINE void solve_drive(pass *p)
{
    joint_block *block = p->block;
    vf value = vf_load(block->value + p->lane), no_limit = vf_set(NO_LIMIT);
    if (block->spring && p->biased) {
        softness s = load_soft(&block->soft, p->lane);
        solve_free(p, value * s.rate, s, block->spring_impulse + p->lane, -no_limit, no_limit);
    }
    if (block->motor) {
        vf most = vf_load(block->motor_force + p->lane) * p->h;
        const softness rigid = {zero(), vf_set(1), zero()};
        solve_free(p, -vf_load(block->motor_speed + p->lane), rigid, block->motor_impulse + p->lane, -most, most);
    }
    if (block->limit) solve_limits(p, value);
}

/* A rod: what its bodies' arms and it itself bend by is second order, as it is for points. */
DAFT_INLINE vf rod_bend(const pass *p, vf length)
{
    vf3 d = load3(p->block->along, p->lane), v = relative_velocity(p);
    vf along = vf3_dot(v, d), across = vf3_dot(v, v) - along * along;
    vf turning = vf_if_then_else(vf_lt(vf_set(1e-9f), length), vf_set(0.5f) * p->h * across / length, zero());
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
        if (p->biased) solve_free(p, error * s.rate, s, impulse, -no_limit, no_limit);
    } else if (!block->limit) {
        softness s = stiff(p);
        vf bias = p->biased ? error * s.rate + rod_bend(p, value) : zero();
        solve_free(p, bias, s, impulse, -no_limit, no_limit);
    }
    if (block->limit) solve_limits(p, value);
}

/* ---- the passes ---- */

/* Whether it holds how bodies are turned besides their anchors. */
DAFT_INLINE bool turns_with(const joint_block *block)
{
    return block->kind == DAFT_JOINT_HINGE || block->kind == DAFT_JOINT_SLIDER || block->kind == DAFT_JOINT_FIXED;
}

/* Whether the body's inertia about its anchor is many times its own. What holds it turned and what holds its anchor are
 * solved in turns, and each undoes much of what the other did: they have to give a little then. A ball of 0.2 m, hinged
 * to the world 1 m away, was thrown about at 50 m/s when they did not. */
#define LONG_ARM 16.0f
DAFT_INLINE vm is_long(const pass *p, int i)
{
    vf trace = p->inertia[i][0] + p->inertia[i][3] + p->inertia[i][5];
    return vf_lt(vf_set(3 * LONG_ARM) * p->inv_mass[i], vf3_dot(p->arm[i], p->arm[i]) * trace);
}

/* Everything as the step begins. */
DAFT_INLINE void prepare_lanes(const daft_sim_solver_bodies *rows, joint_block *block, const daft_sim_substep *substep,
                               int lane)
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
    vf_store(block->most_open + lane, vf_set(MAX_OPEN) + vf_load(block->most_open + lane) * length_of(offset));
    vf h = vf_set(substep->h);
    softness s = make_soft(vf_set(JOINT_HERTZ_FRACTION * substep->inv_h), vf_set(JOINT_DAMPING), h);
    pass p = {.block = block, .lane = lane};
    load_masses(&p);
    vm gives = vm_and(vf_lt(zero(), p.inv_mass[0]), vf_lt(zero(), p.inv_mass[1]));
    if (turns_with(block)) gives = vm_or(gives, vm_or(is_long(&p, 0), is_long(&p, 1)));
    s.mass = vf_if_then_else(gives, s.mass, vf_set(1)), s.impulse = vf_if_then_else(gives, s.impulse, zero());
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

/* The angular velocity a body will have in this substep, when forces have acted: as much more as in the last one,
 * unless that was a jolt. */
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
    x = vf_if_then_else(vf_lt(vf_abs(x), vf_set(MAX_IMPULSE)), x, zero());
    vf_store(impulse, x);
    return x;
}
DAFT_INLINE vf3 bounded3(daft_sim_lanes *impulse, int lane)
{
    return (vf3){bounded(impulse[0] + lane), bounded(impulse[1] + lane), bounded(impulse[2] + lane)};
}

/* What the joint carries turns with the bodies: an impulse along a rod stays along it. Left as it was, it would twist a
 * light bob about its own centre. angular: NULL where it twists nothing. */
DAFT_INLINE void carry(pass *p, vf3 *linear, vf3 *angular)
{
    vm yields_a = vf_lt(zero(), p->inv_mass[0]), yields_b = vf_lt(zero(), p->inv_mass[1]);
    vf3 w = vf3_add(vf3_select(yields_a, p->a.w, none()), vf3_select(yields_b, p->b.w, none()));
    vf fraction = vf_if_then_else(vm_and(yields_a, yields_b), vf_set(0.25f), vf_set(0.5f));
    const quat unturned = {zero(), zero(), zero(), vf_set(1)};
    quat turn = turned(unturned, vf3_scale(w, fraction * p->h));
    *linear = rotate(turn, *linear);
    if (angular) *angular = rotate(turn, *angular);
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

/* Whether it holds how bodies are turned, not only where. */
DAFT_INLINE bool twists(const joint_block *block)
{
    return block->kind == DAFT_JOINT_HINGE || block->kind == DAFT_JOINT_SLIDER || block->kind == DAFT_JOINT_FIXED ||
           (block->kind == DAFT_JOINT_BALL && block->motor);
}

DAFT_INLINE void warm_start_lanes(const daft_sim_solver_bodies *rows, joint_block *block,
                                  const daft_sim_substep *substep, int lane)
{
    pass p = begin_pass(rows, block, lane, substep, true);
    lengthen_arm(&p);
    vf3 w[2] = {p.a.w, p.b.w}, bent[2];
    for (int i = 0; i < 2; i++) bent[i] = bend(expected_spin(&block->side[i], w[i], lane), p.arm[i], p.h);
    store3(block->bend, lane, vf3_sub(bent[1], bent[0]));
    bool two = twists(block);
    vf3 linear = bounded3(block->linear, lane), angular = two ? bounded3(block->angular, lane) : none();
    carry(&p, &linear, two ? &angular : NULL);
    store3(block->linear, lane, linear);
    if (two) store3(block->angular, lane, angular);
    if (has_free(block)) push_free(&p, free_impulse(block, lane));
    if (block->kind == DAFT_JOINT_BALL && block->limit) push_free(&p, -bounded(block->upper_impulse + lane));
    push(&p, linear);
    if (two) twist(&p, angular);
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
        vf most = vf_if_then_else(vf_lt(zero(), force), force * p->h, vf_set(NO_LIMIT));
        if (p->biased) solve_points(p, whole(p), &most);
        break;
    }
    }
}

DAFT_INLINE void add_sums(joint_block *block, int lane)
{
    vf3 linear = load3(block->linear, lane), angular = twists(block) ? load3(block->angular, lane) : none();
    if (has_free(block)) {
        vf3 along = vf3_scale(load3(block->along, lane), free_impulse(block, lane));
        if (block->kind == DAFT_JOINT_HINGE) angular = vf3_add(angular, along);
        if (block->kind != DAFT_JOINT_HINGE) linear = vf3_add(linear, along);
    }
    store3(block->linear_sum, lane, vf3_add(load3(block->linear_sum, lane), linear));
    if (twists(block)) store3(block->angular_sum, lane, vf3_add(load3(block->angular_sum, lane), angular));
}

DAFT_INLINE void relax_lanes(const daft_sim_solver_bodies *rows, joint_block *block, const daft_sim_substep *substep,
                             bool place, bool turned_far, int lane)
{
    place_now now[2] = {0};
    for (int i = 0; (place || has_frames(block)) && i < 2; i++) now[i] = load_place(rows, block->side[i].row + lane);
    if (place) place_arms(block, now, lane);
    if (turned_far) refresh_masses(rows, block, lane);
    pass p = begin_pass(rows, block, lane, substep, false), at = p;
    lengthen_arm(&at);
    place_directions(&at, (quat[2]){now[0].turn, now[1].turn});
    solve_all(&p);
    end_pass(rows, &p);
    add_sums(block, lane);
}

/* ---- what opened ---- */

DAFT_INLINE void shift(const daft_sim_solver_bodies *rows, const pass *p, const quat *turn, int i, vf3 impulse,
                       vbits open)
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
    vf_gather_rows8(rows->turn, index, row);
    row[0] = q.x, row[1] = q.y, row[2] = q.z, row[3] = q.w;
    row[4] = moved.v.x, row[5] = moved.v.y, row[6] = moved.v.z;
    vf_scatter_rows8(rows->turn, index, row, side->writes >> p->lane & open);
}

DAFT_INLINE bool close_lanes(const daft_sim_solver_bodies *rows, joint_block *block, int lane)
{
    const place_now now[2] = {load_place(rows, block->side[0].row + lane), load_place(rows, block->side[1].row + lane)};
    place_arms(block, now, lane);
    if (block->spring || block->kind == DAFT_JOINT_SLIDER || block->kind == DAFT_JOINT_DISTANCE) return false;
    vf3 offset = load3(block->offset, lane);
    vf apart = length_of(offset), most = vf_load(block->most_open + lane);
    vm opened = vf_lt(most, apart);
    vbits open = vbits_from_mask(opened);
    if (!open) return false;
    pass p = {.block = block, .lane = lane};
    load_masses(&p);
    place_points(&p);
    vf excess = vf_if_then_else(opened, (apart - most) / vf_if_then_else(opened, apart, vf_set(1)), zero());
    vf3 impulse = solve3(block->point, lane, vf3_scale(offset, excess));
    shift(rows, &p, &now[0].turn, 0, impulse, open);
    shift(rows, &p, &now[1].turn, 1, vf3_neg(impulse), open);
    return true;
}

/* ---- blocks ---- */

static void fill(const daft_sim_joint_source *from, joint_block *block)
{
    for (int lane = 0; lane < block->lanes; lane += DAFT_VL) fill_lanes(from, block, lane);
}
static void store(const daft_sim_joint_source *to, const joint_block *block, float dt)
{
    for (int lane = 0; lane < block->lanes; lane += DAFT_VL) store_lanes(to, block, dt, lane);
}
static void prepare(const daft_sim_solver_bodies *rows, joint_block *blocks, uint32_t count,
                    const daft_sim_substep *substep)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) prepare_lanes(rows, &blocks[i], substep, lane);
}
static void warm_start(const daft_sim_solver_bodies *rows, joint_block *blocks, uint32_t count,
                       const daft_sim_substep *substep)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) warm_start_lanes(rows, &blocks[i], substep, lane);
}
static void solve(const daft_sim_solver_bodies *rows, joint_block *blocks, uint32_t count,
                  const daft_sim_substep *substep)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) {
            pass p = begin_pass(rows, &blocks[i], lane, substep, true);
            solve_all(&p);
            end_pass(rows, &p);
        }
}
static bool close(const daft_sim_solver_bodies *rows, joint_block *blocks, uint32_t count)
{
    bool moved = false;
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) moved |= close_lanes(rows, &blocks[i], lane);
    return moved;
}
static void relax(const daft_sim_solver_bodies *rows, joint_block *blocks, uint32_t count,
                  const daft_sim_substep *substep, bool place, bool turned_far)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL)
            relax_lanes(rows, &blocks[i], substep, place, turned_far, lane);
}

const daft_sim_joint_kernels DAFT_KERNEL(daft_sim_joint) = {fill, store, prepare, warm_start, solve, close, relax};
