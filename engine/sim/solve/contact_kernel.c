/* Contact constraints in lanes. A block's contacts share no moving body, so its lanes are independent, and every lane
 * computes exactly what any other width would.
 *
 * The contact is that of Catto's Solver2D carried to three dimensions: a spring (rate, soft_mass, soft_impulse) pushes
 * overlap apart, what is not touching yet may close its gap within the substep and no more, and a pass without springs
 * takes out the speed they gave. A point's separation follows the movement of both bodies to first order. The contact
 * point of a round shape stays below its centre while the shape rolls, so there it does not turn with the body.
 *
 * A lane is a contact: up to four points of one pair of bodies. Prepare runs once a step. Then each substep, as
 * add_substep() in substeps.c orders it: warm start (the last impulses again), solve with springs, bodies move
 * (motion_kernel.c), refresh where bodies turned far, relax without springs. After the last one, bounce and finish. */
#include "sim/solve/lanes.h"

/* ---- preparation ---- */

typedef struct sides {
    vf inv_mass_a, inv_mass_b;
    vf inertia_a[6], inertia_b[6];
    vf3 normal, apart;
} sides;

/* Pushes of a unit impulse, by its arms; gives the inverse of the effective mass. */
DAFT_INLINE vf respond(const sides *s, vf3 aa, vf3 ab, daft_sim_lanes *push_a, daft_sim_lanes *push_b, int lane)
{
    vf3 pa = symmetric(s->inertia_a, aa), pb = symmetric(s->inertia_b, ab);
    store3(push_a, lane, pa);
    store3(push_b, lane, pb);
    return s->inv_mass_a + s->inv_mass_b + vf3_dot(aa, pa) + vf3_dot(ab, pb);
}

/* Arms too, of an impulse along `along` at anchor ra. */
DAFT_INLINE vf prepare_row(const sides *s, vf3 ra, vf3 along, daft_sim_lanes *arm_a, daft_sim_lanes *arm_b,
                           daft_sim_lanes *push_a, daft_sim_lanes *push_b, int lane)
{
    vf3 aa = vf3_cross(ra, along), ab = vf3_cross(vf3_add(ra, s->apart), along);
    store3(arm_a, lane, aa);
    store3(arm_b, lane, ab);
    return respond(s, aa, ab, push_a, push_b, lane);
}

/* Speed at which the point's surfaces meet: now, and what gravity and forces add until then. */
DAFT_INLINE vf meeting_speed(const daft_sim_block_point *p, const body *a, const body *b, vf3 normal, vf acceleration,
                             int lane)
{
    vf zero = vf_set(0);
    vf speed = vf3_dot(normal, vf3_sub(b->v, a->v)) + vf3_dot(load3(p->arm_b, lane), b->w) -
               vf3_dot(load3(p->arm_a, lane), a->w);
    vf separation = vf_min(vf_load(p->separation + lane), vf_set(1e9f));
    vf square = speed * speed - vf_set(2) * acceleration * separation;
    vf meets = vf_sqrt(vf_max(square, zero));
    return vf_if_then_else(vf_lt(speed, zero), meets, zero);
}

DAFT_INLINE void respond_friction(daft_sim_block *block, const sides *s, int lane)
{
    vf k11 = respond(s, load3(block->arm_a[0], lane), load3(block->arm_b[0], lane), block->push_a[0], block->push_b[0],
                     lane);
    vf k22 = respond(s, load3(block->arm_a[1], lane), load3(block->arm_b[1], lane), block->push_a[1], block->push_b[1],
                     lane);
    vf k12 = vf3_dot(load3(block->arm_a[0], lane), load3(block->push_a[1], lane)) +
             vf3_dot(load3(block->arm_b[0], lane), load3(block->push_b[1], lane));
    vf scale = inverse(k11 * k22 - k12 * k12);
    vf_store(block->tangent_mass[0] + lane, k22 * scale);
    vf_store(block->tangent_mass[1] + lane, -k12 * scale);
    vf_store(block->tangent_mass[2] + lane, k11 * scale);
    vf3 twist_a = symmetric(s->inertia_a, s->normal), twist_b = symmetric(s->inertia_b, s->normal);
    store3(block->twist_a, lane, twist_a);
    store3(block->twist_b, lane, twist_b);
    vf_store(block->twist_mass + lane, inverse(vf3_dot(s->normal, twist_a) + vf3_dot(s->normal, twist_b)));
}

DAFT_INLINE void prepare_friction(daft_sim_block *block, const sides *s, vf3 middle, int lane)
{
    vf3 t = load3(block->tangent, lane), u = vf3_cross(s->normal, t), other = vf3_add(middle, s->apart);
    store3(block->arm_a[0], lane, vf3_cross(middle, t));
    store3(block->arm_b[0], lane, vf3_cross(other, t));
    store3(block->arm_a[1], lane, vf3_cross(middle, u));
    store3(block->arm_b[1], lane, vf3_cross(other, u));
    respond_friction(block, s, lane);
}

DAFT_INLINE void prepare_bend(daft_sim_block *block, vf3 middle, vf3 apart, vf3 n, int lane)
{
    vf3 t = load3(block->tangent, lane), other = vf3_add(middle, apart);
    vf3 along[2] = {t, vf3_cross(n, t)};
    for (int k = 0; k < 2; k++) {
        vf_store(block->bend_a[k] + lane, vf_load(block->bend_a[k] + lane) * vf3_dot(along[k], middle));
        vf_store(block->bend_b[k] + lane, vf_load(block->bend_b[k] + lane) * vf3_dot(along[k], other));
    }
}

DAFT_INLINE void prepare_rolling(daft_sim_block *block, const sides *s, int lane)
{
    vf trace = vf_set(0);
    for (int k = 0; k < 6; k++) {
        vf_store(block->inertia_a[k] + lane, s->inertia_a[k]);
        vf_store(block->inertia_b[k] + lane, s->inertia_b[k]);
        if (k == 0 || k == 3 || k == 5) trace = vf_max(trace, s->inertia_a[k] + s->inertia_b[k]);
    }
    vf_store(block->rolling_mass + lane, inverse(trace)); /* about the axis that yields most: never too much */
}

DAFT_INLINE sides load_sides(const daft_sim_solver_bodies *rows, daft_sim_block *block, int lane)
{
    sides s = {.normal = load3(block->normal, lane), .apart = load3(block->apart, lane)};
    vf row[8];
    vf_gather_rows8(rows->mass, block->a + lane, row);
    s.inv_mass_a = row[0];
    for (int k = 0; k < 6; k++) s.inertia_a[k] = row[k + 1];
    vf_gather_rows8(rows->mass, block->b + lane, row);
    s.inv_mass_b = row[0];
    for (int k = 0; k < 6; k++) s.inertia_b[k] = row[k + 1];
    vf_store(block->inv_mass_a + lane, s.inv_mass_a);
    vf_store(block->inv_mass_b + lane, s.inv_mass_b);
    return s;
}

DAFT_INLINE void prepare_lanes(const daft_sim_solver_bodies *rows, daft_sim_block *block, int lane)
{
    const int32_t *ia = block->a + lane, *ib = block->b + lane;
    body a = load_body(rows->velocity, ia), b = load_body(rows->velocity, ib);
    body gain_a = load_body(rows->gain, ia), gain_b = load_body(rows->gain, ib);
    sides s = load_sides(rows, block, lane);

    vf acceleration = vf3_dot(s.normal, vf3_sub(gain_b.v, gain_a.v));
    vf zero = vf_set(0), one = vf_set(1), count = zero;
    vf3 middle = {zero, zero, zero}, anchor[DAFT_MANIFOLD_POINTS];
    for (int i = 0; i < block->points; i++) {
        daft_sim_block_point *p = &block->point[i];
        anchor[i] = load3(p->arm_a, lane);
        vm there = vf_lt(vf_load(p->separation + lane), vf_set(1e19f));
        vf weight = vf_if_then_else(there, one, zero);
        count = count + weight;
        middle = vf3_add(middle, vf3_scale(anchor[i], weight));
        vf k = prepare_row(&s, anchor[i], s.normal, p->arm_a, p->arm_b, p->push_a, p->push_b, lane);
        vf_store(p->mass + lane, inverse(k));
        vf_store(p->approach + lane,
                 vf_if_then_else(there, meeting_speed(p, &a, &b, s.normal, acceleration, lane), zero));
    }
    middle = vf3_scale(middle, inverse(count));
    if (block->shares) {
        vm below = vf_lt(zero, vf_load(block->shared + lane));
        vf3 foot = vf3_scale(s.normal, vf3_dot(s.normal, middle));
        middle = (vf3){vf_if_then_else(below, foot.x, middle.x), vf_if_then_else(below, foot.y, middle.y),
                       vf_if_then_else(below, foot.z, middle.z)};
    }
    if (block->turns) prepare_bend(block, middle, s.apart, s.normal, lane);
    for (int i = 0; i < block->points; i++) {
        vf3 d = vf3_sub(anchor[i], middle);
        vf_store(block->point[i].lever + lane, vf_sqrt(vf3_dot(d, d)));
    }
    prepare_friction(block, &s, middle, lane);
    if (block->rolls) prepare_rolling(block, &s, lane);
}

static void prepare(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) prepare_lanes(rows, &blocks[i], lane);
}

/* ---- bodies that turned far within the step, whose inertia is another ---- */

DAFT_INLINE void refresh_lanes(const daft_sim_solver_bodies *rows, daft_sim_block *block, int lane)
{
    sides s = load_sides(rows, block, lane);
    for (int i = 0; i < block->points; i++) {
        daft_sim_block_point *p = &block->point[i];
        vf k = respond(&s, load3(p->arm_a, lane), load3(p->arm_b, lane), p->push_a, p->push_b, lane);
        vf_store(p->mass + lane, inverse(k));
    }
    respond_friction(block, &s, lane);
    if (block->rolls) prepare_rolling(block, &s, lane);
}

static bool has_turned(const daft_sim_solver_bodies *rows, const daft_sim_block *block)
{
    for (int lane = 0; lane < block->lanes; lane++)
        if (rows->turn[(size_t)block->a[lane] * DAFT_SIM_ROW + 7] > 1 ||
            rows->turn[(size_t)block->b[lane] * DAFT_SIM_ROW + 7] > 1)
            return true;
    return false;
}

static void refresh(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; has_turned(rows, &blocks[i]) && lane < blocks[i].lanes; lane += DAFT_VL)
            refresh_lanes(rows, &blocks[i], lane);
}

/* ---- impulses ---- */

typedef struct masses {
    vf a, b;
} masses;

/* impulse along `along`, whose arms were prepared */
DAFT_INLINE void push(body *a, body *b, masses m, vf3 along, const daft_sim_lanes *push_a, const daft_sim_lanes *push_b,
                      vf impulse, int lane)
{
    a->v = vf3_sub(a->v, vf3_scale(along, m.a * impulse));
    a->w = vf3_sub(a->w, vf3_scale(load3(push_a, lane), impulse));
    b->v = vf3_add(b->v, vf3_scale(along, m.b * impulse));
    b->w = vf3_add(b->w, vf3_scale(load3(push_b, lane), impulse));
}

DAFT_INLINE void spin(const daft_sim_block *block, body *a, body *b, vf3 impulse, int lane)
{
    vf inertia_a[6], inertia_b[6];
    for (int k = 0; k < 6; k++) {
        inertia_a[k] = vf_load(block->inertia_a[k] + lane);
        inertia_b[k] = vf_load(block->inertia_b[k] + lane);
    }
    a->w = vf3_sub(a->w, symmetric(inertia_a, impulse));
    b->w = vf3_add(b->w, symmetric(inertia_b, impulse));
}

DAFT_INLINE vf row_speed(const body *a, const body *b, vf3 along, const daft_sim_lanes *arm_a,
                         const daft_sim_lanes *arm_b, int lane)
{
    return vf3_dot(along, vf3_sub(b->v, a->v)) + vf3_dot(load3(arm_b, lane), b->w) - vf3_dot(load3(arm_a, lane), a->w);
}
DAFT_INLINE void twist(const daft_sim_block *block, body *a, body *b, vf impulse, int lane)
{
    a->w = vf3_sub(a->w, vf3_scale(load3(block->twist_a, lane), impulse));
    b->w = vf3_add(b->w, vf3_scale(load3(block->twist_b, lane), impulse));
}

/* Bodies of a block's lanes. */
typedef struct both {
    body a, b;
} both;

DAFT_INLINE both load_both(const float *rows, const daft_sim_block *block, int lane)
{
    return (both){load_body(rows, block->a + lane), load_body(rows, block->b + lane)};
}
DAFT_INLINE void store_both(float *rows, const daft_sim_block *block, const both *all, int lane)
{
    store_body(rows, block->a + lane, &all->a, block->writes_a >> lane);
    store_body(rows, block->b + lane, &all->b, block->writes_b >> lane);
}

DAFT_INLINE bool any(vf a) { return vbits_from_mask(vf_lt(vf_set(0), vf_abs(a))) != 0; }

DAFT_INLINE void warm_start_lanes(const daft_sim_solver_bodies *rows, daft_sim_block *block, int lane)
{
    both all = load_both(rows->velocity, block, lane);
    body *a = &all.a, *b = &all.b;
    masses m = {vf_load(block->inv_mass_a + lane), vf_load(block->inv_mass_b + lane)};
    vf3 n = load3(block->normal, lane), t = load3(block->tangent, lane), u = vf3_cross(n, t);
    for (int i = 0; i < block->points; i++) {
        const daft_sim_block_point *p = &block->point[i];
        push(a, b, m, n, p->push_a, p->push_b, vf_load(p->impulse + lane), lane);
    }
    push(a, b, m, t, block->push_a[0], block->push_b[0], vf_load(block->tangent_impulse[0] + lane), lane);
    push(a, b, m, u, block->push_a[1], block->push_b[1], vf_load(block->tangent_impulse[1] + lane), lane);
    vf turning = vf_load(block->twist_impulse + lane);
    if (any(turning)) twist(block, a, b, turning, lane);
    if (block->rolls) spin(block, a, b, load3(block->rolling_impulse, lane), lane);
    store_both(rows->velocity, block, &all, lane);
}

static void warm_start(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count)
{
    for (daft_sim_block *block = blocks; block < blocks + count; block++)
        for (int lane = 0; lane < block->lanes; lane += DAFT_VL) warm_start_lanes(rows, block, lane);
}

typedef struct spring {
    vf rate, mass, impulse, push_speed, inv_h;
    float h;
    bool on;
} spring;

typedef struct drag {
    vf t, u;
} drag;

/* What turning about the normal does in the directions of friction, by what it does at arms along these. */
DAFT_INLINE drag bent(const daft_sim_block *block, vf a, vf b, int lane)
{
    return (drag){a * vf_load(block->bend_a[0] + lane) - b * vf_load(block->bend_b[0] + lane),
                  a * vf_load(block->bend_a[1] + lane) - b * vf_load(block->bend_b[1] + lane)};
}

/* How far b's surface moved along a's in the step, beyond what moving surfaces carry it, in the directions of friction.
 * What turns about the normal moves along a circle: the second order of that is what a turntable's passenger would
 * creep by. */
DAFT_INLINE drag dragged(const daft_sim_block *block, const body *turn_a, const body *turn_b, vf3 n, vf3 t, vf3 u,
                         float elapsed, int lane)
{
    drag d = {row_speed(turn_a, turn_b, t, block->arm_a[0], block->arm_b[0], lane),
              row_speed(turn_a, turn_b, u, block->arm_a[1], block->arm_b[1], lane)};
    d.t = d.t - vf_load(block->surface_velocity[0] + lane) * vf_set(elapsed);
    d.u = d.u - vf_load(block->surface_velocity[1] + lane) * vf_set(elapsed);
    if (!block->turns) return d;
    vf a = vf3_dot(n, turn_a->w), b = vf3_dot(n, turn_b->w), half = vf_set(0.5f);
    drag more = bent(block, half * a * a, half * b * b, lane);
    d.t = d.t + more.t, d.u = d.u + more.u;
    return d;
}

/* w² t of small angles w t; fading, since what spins fast is beyond this. */
#define SMALL_TURN 0.25f
DAFT_INLINE vf turned_share(vf w, vf t)
{
    vf angle = w * t, fraction = angle * vf_set(1 / SMALL_TURN);
    return w * angle * vf_max(vf_set(1) - fraction * fraction, vf_set(0));
}

/* What turns about the normal has turned its arm since the step began, and its surface's velocity with it: by so much,
 * b's less a's, after `elapsed`. */
DAFT_INLINE drag turned_velocity(const daft_sim_block *block, const body *a, const body *b, vf3 n, float elapsed,
                                 int lane)
{
    vf t = vf_set(elapsed);
    return bent(block, turned_share(vf3_dot(n, a->w), t), turned_share(vf3_dot(n, b->w), t), lane);
}

/* Coulomb's cone: the friction impulse opposes sliding and is at most friction times the normal impulse. What sticks is
 * drawn back to where it stuck; what slides sticks anew where it is. */
DAFT_INLINE void solve_friction(daft_sim_block *block, body *a, body *b, masses m, vf3 n, vf normal_sum,
                                const body *turn_a, const body *turn_b, const spring *s, float elapsed, int lane)
{
    float middle = s->on ? 0.5f * s->h : 0; /* springs aim at the mean velocity of the substep */
    vf3 t = load3(block->tangent, lane), u = vf3_cross(n, t);
    vf vt = row_speed(a, b, t, block->arm_a[0], block->arm_b[0], lane) - vf_load(block->surface_velocity[0] + lane);
    vf vu = row_speed(a, b, u, block->arm_a[1], block->arm_b[1], lane) - vf_load(block->surface_velocity[1] + lane);
    drag displacement = dragged(block, turn_a, turn_b, n, t, u, elapsed, lane);
    if (block->turns) {
        drag bend = turned_velocity(block, a, b, n, elapsed + middle, lane);
        vt = vt + bend.t, vu = vu + bend.u;
    }
    vf slip_t = vf_load(block->slip[0] + lane), slip_u = vf_load(block->slip[1] + lane);
    if (s->on) {
        vt = vt + vf_max(vf_min(s->rate * (slip_t + displacement.t), -s->push_speed), s->push_speed);
        vu = vu + vf_max(vf_min(s->rate * (slip_u + displacement.u), -s->push_speed), s->push_speed);
    }
    vf soft_mass = s->on ? s->mass : vf_set(1), soft_impulse = s->on ? s->impulse : vf_set(0);
    vf m11 = vf_load(block->tangent_mass[0] + lane), m12 = vf_load(block->tangent_mass[1] + lane);
    vf m22 = vf_load(block->tangent_mass[2] + lane);
    vf old_t = vf_load(block->tangent_impulse[0] + lane), old_u = vf_load(block->tangent_impulse[1] + lane);
    vf new_t = old_t - soft_mass * (m11 * vt + m12 * vu) - soft_impulse * old_t;
    vf new_u = old_u - soft_mass * (m12 * vt + m22 * vu) - soft_impulse * old_u;
    vf scale = shorten(new_t * new_t + new_u * new_u, vf_load(block->friction + lane) * normal_sum);
    new_t = new_t * scale, new_u = new_u * scale;
    vf_store(block->tangent_impulse[0] + lane, new_t);
    vf_store(block->tangent_impulse[1] + lane, new_u);
    if (!s->on) {
        vm slides = vf_lt(scale, vf_set(1));
        vf_store(block->slip[0] + lane, vf_if_then_else(slides, -displacement.t, slip_t));
        vf_store(block->slip[1] + lane, vf_if_then_else(slides, -displacement.u, slip_u));
    }
    push(a, b, m, t, block->push_a[0], block->push_b[0], new_t - old_t, lane);
    push(a, b, m, u, block->push_a[1], block->push_b[1], new_u - old_u, lane);
}

/* Friction about the normal: points off the middle hold by their levers. */
DAFT_INLINE void solve_twist(daft_sim_block *block, body *a, body *b, vf3 n, vf lever_sum, const body *turn_a,
                             const body *turn_b, const spring *s, int lane)
{
    vf speed = vf3_dot(n, vf3_sub(b->w, a->w)), angle = vf3_dot(n, vf3_sub(turn_b->w, turn_a->w));
    vf slip = vf_load(block->twist_slip + lane);
    if (s->on) speed = speed + s->rate * (slip + angle);
    vf limit = vf_load(block->friction + lane) * lever_sum, old = vf_load(block->twist_impulse + lane);
    vf soft_mass = s->on ? s->mass : vf_set(1), soft_impulse = s->on ? s->impulse : vf_set(0);
    vf free = old - soft_mass * vf_load(block->twist_mass + lane) * speed - soft_impulse * old,
       wanted = vf_min(vf_max(free, -limit), limit);
    vf_store(block->twist_impulse + lane, wanted);
    if (!s->on) vf_store(block->twist_slip + lane, vf_if_then_else(vf_lt(vf_abs(free), limit), slip, -angle));
    twist(block, a, b, wanted - old, lane);
}

DAFT_INLINE void solve_rolling(daft_sim_block *block, body *a, body *b, vf normal_sum, int lane)
{
    vf3 old = load3(block->rolling_impulse, lane);
    vf3 wanted = vf3_sub(old, vf3_scale(vf3_sub(b->w, a->w), vf_load(block->rolling_mass + lane)));
    wanted = vf3_scale(wanted, shorten(vf3_dot(wanted, wanted), vf_load(block->rolling + lane) * normal_sum));
    store3(block->rolling_impulse, lane, wanted);
    spin(block, a, b, vf3_sub(wanted, old), lane);
}

/* What a point's constraint asks for in this pass; the same in all its sweeps. */
typedef struct demand {
    vf bias, mass, soft_impulse;
    vf most; /* impulse */
} demand;

DAFT_INLINE demand point_demand(const daft_sim_block_point *p, vf moved, const body *turn_a, const body *turn_b,
                                const spring *s, int lane)
{
    vf zero = vf_set(0), mass = vf_load(p->mass + lane);
    vf separation = vf_load(p->separation + lane) + moved;
    separation = separation + vf3_dot(load3(p->arm_b, lane), turn_b->w);
    separation = separation - vf3_dot(load3(p->arm_a, lane), turn_a->w);
    vm open = vf_lt(zero, separation);
    vf no_limit = vf_set(3e38f);
    demand d = {vf_if_then_else(open, separation * s->inv_h, zero), mass, zero, no_limit};
    if (!s->on) { /* what did not meet in this substep may do so in the next, which sees to that itself */
        vm met = vf_lt(zero, vf_load(p->impulse + lane));
        d.most = vf_if_then_else(vm_and(open, vm_not(met)), zero, no_limit);
        return d;
    }
    d.bias = vf_if_then_else(open, d.bias, vf_max(separation * s->rate, s->push_speed));
    d.mass = vf_if_then_else(open, mass, mass * s->mass);
    d.soft_impulse = vf_if_then_else(open, zero, s->impulse);
    return d;
}

DAFT_INLINE void solve_point(daft_sim_block_point *p, body *a, body *b, masses m, vf3 n, const demand *d, vm solved,
                             int lane)
{
    vf speed = row_speed(a, b, n, p->arm_a, p->arm_b, lane), old = vf_load(p->impulse + lane);
    vf wanted = old - d->mass * (speed + d->bias) - d->soft_impulse * old;
    wanted = vf_if_then_else(solved, vf_min(vf_max(wanted, vf_set(0)), d->most), old);
    vf_store(p->impulse + lane, wanted);
    push(a, b, m, n, p->push_a, p->push_b, wanted - old, lane);
}

/* The points of a manifold share both bodies: going over them to and fro while these are at hand makes a tilting box
 * find its balance, for little more than the time of going once. A point that is alone in its manifold is gone over
 * once, whatever stands beside it in the block. */
enum { SWEEPS = 2 };

typedef struct sums {
    vf impulse, levers;
} sums;

DAFT_INLINE sums solve_points(daft_sim_block *block, body *a, body *b, masses m, vf3 n, const body *turn_a,
                              const body *turn_b, const spring *s, int lane)
{
    vf moved = vf3_dot(n, vf3_sub(turn_b->v, turn_a->v));
    demand demands[DAFT_MANIFOLD_POINTS];
    int last = block->points - 1;
    vf none = vf_set(0);
    vm solved = vf_le(none, none);
    for (int i = 0; i <= last; i++) demands[i] = point_demand(&block->point[i], moved, turn_a, turn_b, s, lane);
    for (int sweep = 0; sweep < (last ? SWEEPS : 1); sweep++) {
        for (int i = 0; i <= last; i++) {
            int at = (sweep + !s->on) & 1 ? last - i : i;
            solve_point(&block->point[at], a, b, m, n, &demands[at], solved, lane);
        }
        if (last) solved = vf_lt(vf_load(block->point[1].separation + lane), vf_set(1e19f));
    }
    sums sum = {vf_set(0), vf_set(0)};
    for (int i = 0; i <= last; i++) {
        daft_sim_block_point *p = &block->point[i];
        vf impulse = vf_load(p->impulse + lane);
        sum.impulse = sum.impulse + impulse;
        sum.levers = sum.levers + impulse * vf_load(p->lever + lane);
        if (!s->on) vf_store(p->total + lane, vf_load(p->total + lane) + impulse); /* ends a substep */
    }
    return sum;
}

DAFT_INLINE void solve_lanes(const daft_sim_solver_bodies *rows, daft_sim_block *block, const daft_sim_substep *substep,
                             bool biased, int lane)
{
    both all = load_both(rows->velocity, block, lane), turns = load_both(rows->moved, block, lane);
    body *a = &all.a, *b = &all.b, *turn_a = &turns.a, *turn_b = &turns.b;
    masses m = {vf_load(block->inv_mass_a + lane), vf_load(block->inv_mass_b + lane)};
    vf3 n = load3(block->normal, lane);
    spring s = {.rate = vf_load(block->rate + lane),
                .mass = vf_load(block->soft_mass + lane),
                .impulse = vf_load(block->soft_impulse + lane),
                .push_speed = vf_set(-substep->push_speed),
                .inv_h = vf_set(substep->inv_h),
                .h = substep->h,
                .on = biased};
    sums sum = solve_points(block, a, b, m, n, turn_a, turn_b, &s, lane);
    solve_twist(block, a, b, n, sum.levers, turn_a, turn_b, &s, lane);
    solve_friction(block, a, b, m, n, sum.impulse, turn_a, turn_b, &s, substep->elapsed, lane);
    if (block->rolls) solve_rolling(block, a, b, sum.impulse, lane);
    store_both(rows->velocity, block, &all, lane);
}

static void solve(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count,
                  const daft_sim_substep *substep, bool biased)
{
    for (daft_sim_block *block = blocks; block < blocks + count; block++)
        for (int lane = 0; lane < block->lanes; lane += DAFT_VL) solve_lanes(rows, block, substep, biased, lane);
}

/* ---- bounces: after the substeps, with the speed at which the surfaces truly met ---- */

#define BOUNCE_SPEED 1.0f /* m/s; slower contacts do not bounce */

/* The bounce's impulse adds to the step's, and gives friction its share; it is not kept for the next step's start. */
DAFT_INLINE void bounce_lanes(const daft_sim_solver_bodies *rows, daft_sim_block *block, float elapsed, int lane)
{
    const int32_t *ia = block->a + lane, *ib = block->b + lane;
    body a = load_body(rows->velocity, ia), b = load_body(rows->velocity, ib);
    body turn_a = load_body(rows->moved, ia), turn_b = load_body(rows->moved, ib);
    masses m = {vf_load(block->inv_mass_a + lane), vf_load(block->inv_mass_b + lane)};
    vf3 n = load3(block->normal, lane);
    vf zero = vf_set(0), restitution = vf_load(block->restitution + lane), sum = zero;
    for (int i = 0; i < block->points; i++) {
        daft_sim_block_point *p = &block->point[i];
        vf approach = vf_load(p->approach + lane), total = vf_load(p->total + lane);
        vm bounces = vm_and(vf_lt(vf_set(BOUNCE_SPEED), approach), vf_lt(zero, total));
        bounces = vm_and(bounces, vf_lt(zero, restitution));
        vf speed = row_speed(&a, &b, n, p->arm_a, p->arm_b, lane);
        vf impulse = -vf_load(p->mass + lane) * (speed - restitution * approach);
        impulse = vf_if_then_else(bounces, vf_max(impulse, zero), zero);
        push(&a, &b, m, n, p->push_a, p->push_b, impulse, lane);
        vf_store(p->total + lane, total + impulse);
        vf kept = vf_if_then_else(vf_lt(zero, impulse), zero, vf_load(p->impulse + lane));
        vf_store(p->impulse + lane, kept);
        sum = sum + impulse;
    }
    /* Only what bounced is rubbed, too: the others keep what they have, whatever stands beside them. */
    vm bounced = vf_lt(zero, sum);
    vf kept[2], slip[2];
    for (int k = 0; k < 2; k++) {
        kept[k] = vf_if_then_else(bounced, zero, vf_load(block->tangent_impulse[k] + lane));
        slip[k] = vf_load(block->slip[k] + lane);
        vf_store(block->tangent_impulse[k] + lane, zero);
    }
    const spring rigid = {.on = false};
    solve_friction(block, &a, &b, m, n, sum, &turn_a, &turn_b, &rigid, elapsed, lane);
    for (int k = 0; k < 2; k++) {
        vf_store(block->tangent_impulse[k] + lane, kept[k]);
        vf_store(block->slip[k] + lane, vf_if_then_else(bounced, vf_load(block->slip[k] + lane), slip[k]));
    }
    store_body(rows->velocity, ia, &a, block->writes_a >> lane);
    store_body(rows->velocity, ib, &b, block->writes_b >> lane);
}

static void bounce(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count,
                   const daft_sim_substep *end)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; blocks[i].bounces && lane < blocks[i].lanes; lane += DAFT_VL)
            bounce_lanes(rows, &blocks[i], end->elapsed, lane);
}

/* ---- the end: what was dragged in this step adds to what was before, and turns with the surfaces ---- */

DAFT_INLINE void finish_lanes(const daft_sim_solver_bodies *rows, daft_sim_block *block, float elapsed, int lane)
{
    body a = load_body(rows->moved, block->a + lane), b = load_body(rows->moved, block->b + lane);
    vf3 n = load3(block->normal, lane), t = load3(block->tangent, lane), u = vf3_cross(n, t);
    drag displacement = dragged(block, &a, &b, n, t, u, elapsed, lane);
    vf slip_t = vf_load(block->slip[0] + lane) + displacement.t,
       slip_u = vf_load(block->slip[1] + lane) + displacement.u;
    vf twist_a = vf3_dot(n, a.w), twist_b = vf3_dot(n, b.w), half = vf_set(0.25f) * (twist_a + twist_b);
    /* Half the tangent's angle to its rotation: (1 - q², 2q) / (1 + q²). */
    vf square = half * half, scale = vf_set(1) / (vf_set(1) + square);
    vf c = (vf_set(1) - square) * scale, s = (half + half) * scale;
    vf push_t = vf_load(block->tangent_impulse[0] + lane), push_u = vf_load(block->tangent_impulse[1] + lane);
    vf_store(block->slip[0] + lane, c * slip_t - s * slip_u);
    vf_store(block->slip[1] + lane, s * slip_t + c * slip_u);
    vf_store(block->tangent_impulse[0] + lane, c * push_t - s * push_u);
    vf_store(block->tangent_impulse[1] + lane, s * push_t + c * push_u);
    vf_store(block->twist_slip + lane, vf_load(block->twist_slip + lane) + (twist_b - twist_a));
}

static void finish(const daft_sim_solver_bodies *rows, daft_sim_block *blocks, uint32_t count,
                   const daft_sim_substep *end)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < blocks[i].lanes; lane += DAFT_VL) finish_lanes(rows, &blocks[i], end->elapsed, lane);
}

const daft_sim_contact_kernels DAFT_KERNEL(daft_sim_contact) = {prepare, refresh, warm_start, solve, bounce, finish};
