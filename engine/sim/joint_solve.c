/* Joints as constraints, solved one after the other. Their frames are turned with the bodies in every substep, so that
 * what they hold together stays together while it turns.
 *
 * A pass with springs (biased) draws errors out and aims at the end of the substep: a point on an arm that turns is
 * carried along a circle, whose second-order term h/2·w×(w×r) is part of what it aims at. The pass without springs
 * then takes the velocity back onto what the joint allows where the bodies now are. Together they are close to the
 * RATTLE scheme (Andersen 1983), which is symplectic: a pendulum keeps its energy. */
#include "sim/solver.h"

#include "math/real.h"

/* Rigid joints are springs as stiff as the substeps allow. */
#define JOINT_HERTZ_SHARE 0.35f /* of the substeps' rate */
#define JOINT_DAMPING     5.0f

typedef struct softness {
    float rate, mass, impulse;
} softness;

typedef struct symmetric {
    float xx, xy, xz, yy, yz, zz;
} symmetric;

typedef struct solve_context {
    daft_sim_joint *joint;
    const daft_sim_joint_row *row;
    symmetric inertia[2]; /* inverse, world axes */
    float *va, *vb;       /* velocity rows */
    daft_vec3 arm[2];
    daft_quat frame[2];
    daft_vec3 offset; /* from anchor a to anchor b */
    daft_vec3 axis;   /* of a */
    float h, inv_h;
    bool biased;
    softness stiff; /* of what is rigid */
} solve_context;

static softness make_soft(float hertz, float damping, float h)
{
    float omega = 2 * (float)DAFT_PI * hertz;
    if (omega == 0) return (softness){0, 0, 1};
    float a1 = 2 * damping + h * omega, a2 = h * omega * a1, a3 = 1 / (1 + a2);
    return (softness){omega / a1, a2 * a3, a3};
}

/* ---- rows of bodies ---- */

static daft_vec3 row3(const float *row, int at) { return daft_v3(row[at], row[at + 1], row[at + 2]); }
static void add3(float *row, int at, daft_vec3 v) { row[at] += v.x, row[at + 1] += v.y, row[at + 2] += v.z; }

static daft_vec3 times(const symmetric *m, daft_vec3 v)
{
    return daft_v3(m->xx * v.x + m->xy * v.y + m->xz * v.z, m->xy * v.x + m->yy * v.y + m->yz * v.z,
                   m->xz * v.x + m->yz * v.y + m->zz * v.z);
}

static daft_vec3 relative_velocity(const solve_context *c)
{
    daft_vec3 a = daft_add(row3(c->va, 0), daft_cross(row3(c->va, 3), c->arm[0]));
    daft_vec3 b = daft_add(row3(c->vb, 0), daft_cross(row3(c->vb, 3), c->arm[1]));
    return daft_sub(b, a);
}
static daft_vec3 relative_spin(const solve_context *c) { return daft_sub(row3(c->vb, 3), row3(c->va, 3)); }

/* An impulse on b, its reverse on a. Rows of what does not yield stay as they are: their inverse masses are 0. */
static void push(const solve_context *c, daft_vec3 impulse)
{
    const daft_sim_joint_row *r = c->row;
    if (r->inv_mass[0] > 0) {
        add3(c->va, 0, daft_scale(impulse, -r->inv_mass[0]));
        add3(c->va, 3, daft_neg(times(&c->inertia[0], daft_cross(c->arm[0], impulse))));
    }
    if (r->inv_mass[1] > 0) {
        add3(c->vb, 0, daft_scale(impulse, r->inv_mass[1]));
        add3(c->vb, 3, times(&c->inertia[1], daft_cross(c->arm[1], impulse)));
    }
}
static void twist(const solve_context *c, daft_vec3 impulse)
{
    if (c->row->inv_mass[0] > 0) add3(c->va, 3, daft_neg(times(&c->inertia[0], impulse)));
    if (c->row->inv_mass[1] > 0) add3(c->vb, 3, times(&c->inertia[1], impulse));
}

/* ---- small systems, in double: masses differ by many orders ---- */

/* A symmetric, positive matrix, given by its columns, as what solving with it needs. */
static daft_sim_cofactors cofactors_of(daft_vec3 a, daft_vec3 b, daft_vec3 c)
{
    daft_dvec3 x = daft_to_double(a), y = daft_to_double(b), z = daft_to_double(c);
    daft_sim_cofactors k = {daft_dcross(y, z), daft_dcross(z, x), daft_dcross(x, y), 0};
    k.det = daft_ddot(x, k.yz);
    return k;
}

/* K·x = b; 0 where K is singular. */
static daft_vec3 solve3(const daft_sim_cofactors *k, daft_vec3 b)
{
    daft_dvec3 f = daft_to_double(b);
    if (!(k->det > 0)) return daft_v3(0, 0, 0);
    return daft_v3((float)(daft_ddot(f, k->yz) / k->det), (float)(daft_ddot(f, k->zx) / k->det),
                   (float)(daft_ddot(f, k->xy) / k->det));
}

static void solve2(double k11, double k12, double k22, const float b[2], float out[2])
{
    double det = k11 * k22 - k12 * k12;
    out[0] = det > 0 ? (float)((k22 * (double)b[0] - k12 * (double)b[1]) / det) : 0;
    out[1] = det > 0 ? (float)((k11 * (double)b[1] - k12 * (double)b[0]) / det) : 0;
}

/* Response of the relative velocity at the anchors to an impulse along `along`. */
static daft_vec3 point_response(const solve_context *c, daft_vec3 along)
{
    const daft_sim_joint_row *r = c->row;
    daft_vec3 a = daft_cross(times(&c->inertia[0], daft_cross(c->arm[0], along)), c->arm[0]);
    daft_vec3 b = daft_cross(times(&c->inertia[1], daft_cross(c->arm[1], along)), c->arm[1]);
    return daft_add(daft_scale(along, r->inv_mass[0] + r->inv_mass[1]), daft_add(a, b));
}
static daft_vec3 spin_response(const solve_context *c, daft_vec3 along)
{
    return daft_add(times(&c->inertia[0], along), times(&c->inertia[1], along));
}

static const daft_vec3 UNIT[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

static daft_sim_cofactors point_cofactors(const solve_context *c)
{
    return cofactors_of(point_response(c, UNIT[0]), point_response(c, UNIT[1]), point_response(c, UNIT[2]));
}

static void perpendicular(daft_vec3 n, daft_vec3 out[2])
{
    daft_vec3 axis = fabsf(n.x) < 0.6f ? daft_v3(1, 0, 0) : daft_v3(0, 1, 0);
    out[0] = daft_normalize(daft_cross(n, axis));
    out[1] = daft_cross(n, out[0]);
}

/* ---- constraints ---- */

/* The change of a vector impulse: -K⁻¹(speed + bias), softened. */
static daft_vec3 soft_change(const daft_sim_cofactors *k, daft_vec3 speed, daft_vec3 error, daft_vec3 impulse,
                             const solve_context *c, softness s)
{
    if (!c->biased) s = (softness){0, 1, 0};
    daft_vec3 wanted = solve3(k, daft_add(speed, daft_scale(error, s.rate)));
    return daft_sub(daft_scale(wanted, -s.mass), daft_scale(impulse, s.impulse));
}

/* What a point's mean velocity on its arm over a substep differs by from w×arm: the arm turns by the Cayley map of
 * h·w, which with u = h/2·w takes it to arm + 2/(1 + u²)·(u×arm + u×(u×arm)). */
static daft_vec3 bend(daft_vec3 w, daft_vec3 arm, float h)
{
    daft_vec3 straight = daft_cross(w, arm);
    float square = 0.25f * h * h * daft_dot(w, w);
    daft_vec3 inward = daft_scale(daft_cross(w, straight), 0.5f * h);
    return daft_scale(daft_sub(inward, daft_scale(straight, square)), 1 / (1 + square));
}

static daft_vec3 aimed_velocity(const solve_context *c)
{
    daft_vec3 v = relative_velocity(c);
    if (!c->biased) return v;
    v = daft_add(v, bend(c->row->spin[1], c->arm[1], c->h));
    return daft_sub(v, bend(c->row->spin[0], c->arm[0], c->h));
}

/* The anchors stay together. */
static void solve_points(const solve_context *c, softness s, float most)
{
    daft_vec3 old = c->joint->linear_impulse;
    daft_vec3 wanted = daft_add(old, soft_change(&c->row->response, aimed_velocity(c), c->offset, old, c, s));
    float length = daft_length(wanted);
    if (length > most) wanted = daft_scale(wanted, most / length);
    c->joint->linear_impulse = wanted;
    push(c, daft_sub(wanted, old));
}

/* The anchors stay together but along the axis. */
static void solve_line(const solve_context *c, softness s)
{
    daft_vec3 p[2], response[2];
    perpendicular(c->axis, p);
    /* The line turns with a, so its impulse acts on a at b's anchor. */
    solve_context at = *c;
    at.arm[0] = daft_add(c->arm[0], c->offset);
    for (int i = 0; i < 2; i++) response[i] = point_response(&at, p[i]);
    daft_vec3 v = aimed_velocity(&at), old = c->joint->linear_impulse;
    if (!c->biased) s = (softness){0, 1, 0};
    float b[2], x[2];
    for (int i = 0; i < 2; i++) b[i] = daft_dot(v, p[i]) + s.rate * daft_dot(c->offset, p[i]);
    solve2((double)daft_dot(response[0], p[0]), (double)daft_dot(response[0], p[1]),
           (double)daft_dot(response[1], p[1]), b, x);
    daft_vec3 wanted = daft_v3(0, 0, 0);
    for (int i = 0; i < 2; i++) {
        float impulse = daft_dot(old, p[i]);
        wanted = daft_add(wanted, daft_scale(p[i], impulse - s.mass * x[i] - s.impulse * impulse));
    }
    c->joint->linear_impulse = wanted;
    push(&at, daft_sub(wanted, old));
}

/* The rotation from frame a to frame b, as a vector in the world; half-angle form, exact at 0. */
static daft_vec3 turn_error(const solve_context *c)
{
    daft_quat a = c->frame[0], d = daft_quat_mul(c->frame[1], (daft_quat){-a.x, -a.y, -a.z, a.w});
    return daft_scale(daft_v3(d.x, d.y, d.z), d.w < 0 ? -2.0f : 2.0f);
}

/* Friction in a ball joint: it brakes the turning of b against a by up to the motor's torque. */
static void solve_brake(const solve_context *c)
{
    daft_sim_cofactors k = cofactors_of(spin_response(c, UNIT[0]), spin_response(c, UNIT[1]), spin_response(c, UNIT[2]));
    daft_vec3 old = c->joint->angular_impulse, wanted = daft_sub(old, solve3(&k, relative_spin(c)));
    float most = c->joint->motor_force * c->h, length = daft_length(wanted);
    if (length > most) wanted = daft_scale(wanted, most / length);
    c->joint->angular_impulse = wanted;
    twist(c, daft_sub(wanted, old));
}

static void solve_turn(const solve_context *c, softness s)
{
    daft_sim_cofactors k = cofactors_of(spin_response(c, UNIT[0]), spin_response(c, UNIT[1]), spin_response(c, UNIT[2]));
    daft_vec3 old = c->joint->angular_impulse;
    daft_vec3 change = soft_change(&k, relative_spin(c), turn_error(c), old, c, s);
    c->joint->angular_impulse = daft_add(old, change);
    twist(c, change);
}

/* The axes stay together. */
static void solve_axes(const solve_context *c, softness s)
{
    daft_vec3 p[2], response[2], axis_b = daft_quat_rotate(c->frame[1], UNIT[0]);
    perpendicular(c->axis, p);
    for (int i = 0; i < 2; i++) response[i] = spin_response(c, p[i]);
    daft_vec3 w = relative_spin(c), error = daft_cross(c->axis, axis_b), old = c->joint->angular_impulse;
    if (!c->biased) s = (softness){0, 1, 0};
    float b[2], x[2];
    for (int i = 0; i < 2; i++) b[i] = daft_dot(w, p[i]) + s.rate * daft_dot(error, p[i]);
    solve2((double)daft_dot(response[0], p[0]), (double)daft_dot(response[0], p[1]),
           (double)daft_dot(response[1], p[1]), b, x);
    daft_vec3 wanted = daft_v3(0, 0, 0);
    for (int i = 0; i < 2; i++) {
        float impulse = daft_dot(old, p[i]);
        wanted = daft_add(wanted, daft_scale(p[i], impulse - s.mass * x[i] - s.impulse * impulse));
    }
    c->joint->angular_impulse = wanted;
    twist(c, daft_sub(wanted, old));
}

/* One number: a row along an axis, linear (at the anchors) or angular. */
typedef struct scalar {
    daft_vec3 along;
    bool angular;
    float inverse; /* of the effective mass */
} scalar;

static scalar make_scalar(const solve_context *c, daft_vec3 along, bool angular)
{
    daft_vec3 response = angular ? spin_response(c, along) : point_response(c, along);
    return (scalar){along, angular, daft_dot(response, along)};
}
static float scalar_speed(const solve_context *c, const scalar *s)
{
    return daft_dot(s->angular ? relative_spin(c) : relative_velocity(c), s->along);
}
static void apply_scalar(const solve_context *c, const scalar *s, float impulse)
{
    if (s->angular)
        twist(c, daft_scale(s->along, impulse));
    else
        push(c, daft_scale(s->along, impulse));
}

static void solve_scalar(const solve_context *c, const scalar *s, float bias, softness soft, float *impulse, float low,
                         float high)
{
    float mass = s->inverse > 0 ? 1 / s->inverse : 0, old = *impulse;
    float wanted = old - mass * soft.mass * (scalar_speed(c, s) + bias) - soft.impulse * old;
    *impulse = wanted < low ? low : wanted > high ? high : wanted;
    apply_scalar(c, s, *impulse - old);
}

#define NO_LIMIT 3e38f

/* value >= lower, pushed by positive impulses; sign -1: value <= upper. */
static void solve_limit(const solve_context *c, const scalar *s, float room, float sign, float *impulse)
{
    scalar side = *s;
    side.along = daft_scale(s->along, sign);
    softness soft = {0, 1, 0};
    float bias = 0;
    if (room > 0) {
        bias = room * c->inv_h;
    } else if (c->biased) {
        soft = c->stiff;
        bias = room * soft.rate;
    }
    solve_scalar(c, &side, bias, soft, impulse, 0, NO_LIMIT);
}

/* The angle that differs from another by no more than half a turn. */
static float nearest_turn(float angle, float from)
{
    const float turn = (float)(2 * DAFT_PI);
    return angle - from > 0.5f * turn ? angle - turn : angle - from < -0.5f * turn ? angle + turn : angle;
}

/* The spring, the motor and the limits of one free direction. */
static void solve_free(const solve_context *c, const scalar *s, float value)
{
    daft_sim_joint *j = c->joint;
    if (j->spring && c->biased) {
        softness soft = make_soft(j->hertz, j->damping, c->h);
        solve_scalar(c, s, value * soft.rate, soft, &j->spring_impulse, -NO_LIMIT, NO_LIMIT);
    }
    if (j->motor) {
        float most = j->motor_force * c->h;
        solve_scalar(c, s, -j->motor_speed, (softness){0, 1, 0}, &j->motor_impulse, -most, most);
    }
    if (!j->limit) return;
    if (s->angular) value = nearest_turn(value, 0.5f * (j->lower + j->upper)); /* beyond a limit is not beyond the other */
    solve_limit(c, s, value - j->lower, 1, &j->lower_impulse);
    solve_limit(c, s, j->upper - value, -1, &j->upper_impulse);
}

/* Within ±pi. */
static float hinge_angle(const daft_quat frame[2])
{
    daft_quat a = frame[0], d = daft_quat_mul((daft_quat){-a.x, -a.y, -a.z, a.w}, frame[1]);
    double sign = d.w < 0 ? -1 : 1;
    return (float)(2 * daft_atan2(sign * (double)d.x, sign * (double)d.w));
}

/* The angle between the axes, at most `upper`. */
static void solve_cone(const solve_context *c, bool warm)
{
    daft_vec3 axis_b = daft_quat_rotate(c->frame[1], UNIT[0]), normal = daft_cross(c->axis, axis_b);
    float sine = daft_length(normal);
    if (!(sine > 1e-6f)) return;
    float angle = (float)daft_atan2((double)sine, (double)daft_dot(c->axis, axis_b));
    scalar s = make_scalar(c, daft_scale(normal, 1 / sine), true);
    if (warm) {
        apply_scalar(c, &s, -c->joint->upper_impulse);
        return;
    }
    solve_limit(c, &s, c->joint->upper - angle, -1, &c->joint->upper_impulse);
}

static void solve_distance(const solve_context *c, bool warm)
{
    daft_sim_joint *j = c->joint;
    float length = daft_length(c->offset);
    daft_vec3 d = length > 1e-9f ? daft_scale(c->offset, 1 / length) : UNIT[1];
    scalar s = make_scalar(c, d, false);
    if (warm) {
        apply_scalar(c, &s, j->spring_impulse + j->lower_impulse - j->upper_impulse);
        return;
    }
    if (j->spring) {
        softness soft = make_soft(j->hertz, j->damping, c->h);
        if (c->biased)
            solve_scalar(c, &s, (length - j->length) * soft.rate, soft, &j->spring_impulse, -NO_LIMIT, NO_LIMIT);
    } else if (!j->limit) {
        softness soft = c->biased ? c->stiff : (softness){0, 1, 0};
        float speed = daft_dot(aimed_velocity(c), d) - scalar_speed(c, &s); /* the bend of the arms, and */
        daft_vec3 v = relative_velocity(c);                                 /* of the rod itself */
        float across = daft_dot(v, v) - daft_dot(v, d) * daft_dot(v, d);
        if (c->biased && length > 1e-9f) speed += 0.5f * c->h * across / length;
        solve_scalar(c, &s, (length - j->length) * soft.rate + speed, soft, &j->spring_impulse, -NO_LIMIT, NO_LIMIT);
    }
    if (!j->limit) return;
    solve_limit(c, &s, length - j->lower, 1, &j->lower_impulse);
    solve_limit(c, &s, j->upper - length, -1, &j->upper_impulse);
}

/* ---- the passes ---- */

static daft_quat turn_of(const daft_sim_rows *rows, const daft_sim_joint_row *row, int side)
{
    const float *t = rows->turn + (size_t)row->row[side] * DAFT_SIM_ROW;
    return (daft_quat){t[0], t[1], t[2], t[3]};
}

/* Where the anchors are now. */
static void place_anchors(const daft_sim_rows *rows, daft_sim_joint_row *row)
{
    row->offset = row->offset0;
    for (int i = 0; i < 2; i++) {
        row->arm[i] = daft_quat_rotate(turn_of(rows, row, i), row->arm0[i]);
        const float *way = rows->moved + (size_t)row->row[i] * DAFT_SIM_ROW;
        daft_vec3 moved = daft_add(row3(way, 0), daft_sub(row->arm[i], row->arm0[i]));
        row->offset = i == 0 ? daft_sub(row->offset, moved) : daft_add(row->offset, moved);
    }
}

static solve_context make_context(daft_world *world, const daft_sim_joint_row *row, const daft_sim_substep *substep,
                                  bool biased)
{
    const daft_sim_rows *rows = &world->solver->rows;
    solve_context c = {.joint = &world->joints[row->joint],
                       .row = row,
                       .h = substep->h,
                       .inv_h = substep->inv_h,
                       .arm = {row->arm[0], row->arm[1]},
                       .frame = {row->frame[0], row->frame[1]},
                       .offset = row->offset,
                       .axis = row->axis,
                       .biased = biased};
    size_t a = (size_t)row->row[0] * DAFT_SIM_ROW, b = (size_t)row->row[1] * DAFT_SIM_ROW;
    const size_t at[2] = {a, b};
    c.va = rows->velocity + a, c.vb = rows->velocity + b;
    for (int i = 0; i < 2; i++) {
        const float *m = rows->mass + at[i] + 1;
        if (row->inv_mass[i] > 0) c.inertia[i] = (symmetric){m[0], m[1], m[2], m[3], m[4], m[5]};
    }
    c.stiff = make_soft(JOINT_HERTZ_SHARE * substep->inv_h, JOINT_DAMPING, substep->h);
    if (!(row->inv_mass[0] > 0 && row->inv_mass[1] > 0)) c.stiff.mass = 1, c.stiff.impulse = 0;
    return c;
}

/* Anchors and frames where they are now, and what follows from them, for all passes until bodies move again. */
static void place_joint(daft_world *world, daft_sim_joint_row *row)
{
    const daft_sim_rows *rows = &world->solver->rows;
    daft_joint_kind kind = world->joints[row->joint].kind;
    place_anchors(rows, row);
    for (int i = 0; i < 2; i++) row->frame[i] = daft_quat_mul(turn_of(rows, row, i), row->frame0[i]);
    row->axis = daft_quat_rotate(row->frame[0], UNIT[0]);
    if (kind == DAFT_JOINT_HINGE) row->angle = hinge_angle(row->frame);
    if (kind == DAFT_JOINT_SLIDER || kind == DAFT_JOINT_DISTANCE) return;
    const daft_sim_substep unused = {.h = 1, .inv_h = 1};
    solve_context c = make_context(world, row, &unused, false);
    row->response = point_cofactors(&c);
}

static void solve_slider(const solve_context *c, bool warm)
{
    daft_sim_joint *j = c->joint;
    solve_context at = *c;
    at.arm[0] = daft_add(c->arm[0], c->offset);
    scalar s = make_scalar(&at, c->axis, false);
    if (warm) {
        apply_scalar(&at, &s, j->spring_impulse + j->motor_impulse + j->lower_impulse - j->upper_impulse);
        push(&at, j->linear_impulse);
        twist(&at, j->angular_impulse);
        return;
    }
    solve_free(&at, &s, daft_dot(c->offset, c->axis));
    solve_turn(c, c->stiff);
    solve_line(c, c->stiff);
}

/* What the joint carries turns with the bodies: an impulse along a rod stays along it. Left as it was, it would twist a
 * light bob about its own centre. */
static void carry(solve_context *c)
{
    daft_vec3 w = daft_v3(0, 0, 0);
    float yielding = 0;
    if (c->row->inv_mass[0] > 0) w = row3(c->va, 3), yielding++;
    if (c->row->inv_mass[1] > 0) w = daft_add(w, row3(c->vb, 3)), yielding++;
    if (daft_sim_is_zero(w)) return;
    daft_quat turn = daft_sim_turn(daft_quat_identity(), w, 0.5f * c->h / yielding);
    c->joint->linear_impulse = daft_quat_rotate(turn, c->joint->linear_impulse);
    c->joint->angular_impulse = daft_quat_rotate(turn, c->joint->angular_impulse);
}

/* The angular velocity a body will have in this substep, when forces have acted: as much more as in the last one, unless
 * that was a jolt. */
static daft_vec3 expected_spin(daft_vec3 *last, daft_vec3 now)
{
    daft_vec3 change = daft_sub(now, *last);
    *last = now;
    return daft_dot(change, change) < 0.01f * daft_dot(now, now) ? daft_add(now, change) : now;
}

void daft_sim_joint_warm_start(daft_world *world, daft_sim_joint_row *row, const daft_sim_substep *substep)
{
    solve_context c = make_context(world, row, substep, true);
    const daft_sim_joint *j = c.joint;
    for (int i = 0; i < 2; i++) row->spin[i] = expected_spin(&c.joint->spin[i], row3(i ? c.vb : c.va, 3));
    carry(&c);
    if (j->kind == DAFT_JOINT_DISTANCE) {
        solve_distance(&c, true);
    } else if (j->kind == DAFT_JOINT_SLIDER) {
        solve_slider(&c, true);
    } else {
        push(&c, j->linear_impulse);
        twist(&c, j->angular_impulse);
        if (j->kind == DAFT_JOINT_BALL && j->limit) solve_cone(&c, true);
        if (j->kind == DAFT_JOINT_HINGE)
            twist(&c, daft_scale(c.axis, j->spring_impulse + j->motor_impulse + j->lower_impulse - j->upper_impulse));
    }
}

static void add_sums(const solve_context *c, daft_sim_joint_row *row)
{
    const daft_sim_joint *j = c->joint;
    float along = j->spring_impulse + j->motor_impulse + j->lower_impulse - j->upper_impulse;
    row->linear_sum = daft_add(row->linear_sum, j->linear_impulse);
    row->angular_sum = daft_add(row->angular_sum, j->angular_impulse);
    if (j->kind == DAFT_JOINT_HINGE) row->angular_sum = daft_add(row->angular_sum, daft_scale(c->axis, along));
    if (j->kind == DAFT_JOINT_SLIDER) row->linear_sum = daft_add(row->linear_sum, daft_scale(c->axis, along));
    if (j->kind == DAFT_JOINT_DISTANCE)
        row->linear_sum = daft_add(row->linear_sum, daft_scale(daft_normalize(c->offset), along));
}

void daft_sim_joint_solve(daft_world *world, daft_sim_joint_row *row, const daft_sim_substep *substep, bool biased)
{
    if (!biased) place_joint(world, row);
    solve_context c = make_context(world, row, substep, biased);
    daft_sim_joint *j = c.joint;
    softness soft = j->spring ? make_soft(j->hertz, j->damping, c.h) : c.stiff;
    bool rigid = !j->spring; /* a soft joint is not relaxed */
    switch (j->kind) {
    case DAFT_JOINT_BALL:
        if (j->motor) solve_brake(&c);
        if (j->limit) solve_cone(&c, false);
        if (rigid || biased) solve_points(&c, soft, NO_LIMIT);
        break;
    case DAFT_JOINT_HINGE: {
        scalar s = make_scalar(&c, c.axis, true);
        solve_free(&c, &s, row->angle);
        solve_axes(&c, c.stiff);
        solve_points(&c, c.stiff, NO_LIMIT);
        break;
    }
    case DAFT_JOINT_SLIDER: solve_slider(&c, false); break;
    case DAFT_JOINT_DISTANCE: solve_distance(&c, false); break;
    case DAFT_JOINT_FIXED:
        if (rigid || biased) {
            solve_turn(&c, soft);
            solve_points(&c, soft, NO_LIMIT);
        }
        break;
    case DAFT_JOINT_DRAG:
        if (biased) solve_points(&c, soft, j->motor_force > 0 ? j->motor_force * c.h : NO_LIMIT);
        break;
    }
    if (!biased) add_sums(&c, row);
}

/* ---- what opened ---- */

/* Where a blow moves the anchors apart by more, in metres, the bodies are put back, without a change of velocity. What was
 * apart before the step is left to springs: joints that cannot all be held would toss their bodies about. */
#define MOST_OPEN 0.003f

static void shift(const solve_context *c, const daft_sim_rows *rows, int side, daft_vec3 impulse)
{
    if (!(c->row->inv_mass[side] > 0)) return;
    size_t at = (size_t)c->row->row[side] * DAFT_SIM_ROW;
    float *moved = rows->moved + at, *t = rows->turn + at;
    daft_vec3 angle = times(&c->inertia[side], daft_cross(c->arm[side], impulse));
    daft_quat turn = daft_sim_turn((daft_quat){t[0], t[1], t[2], t[3]}, angle, 1);
    add3(moved, 0, daft_scale(impulse, c->row->inv_mass[side]));
    add3(moved, 3, angle);
    t[0] = turn.x, t[1] = turn.y, t[2] = turn.z, t[3] = turn.w;
}

void daft_sim_joint_close(daft_world *world, daft_sim_joint_row *row, const daft_sim_substep *substep)
{
    const daft_sim_joint *j = &world->joints[row->joint];
    if (j->spring || (j->kind != DAFT_JOINT_BALL && j->kind != DAFT_JOINT_HINGE && j->kind != DAFT_JOINT_FIXED)) return;
    place_anchors(&world->solver->rows, row);
    float open = daft_length(row->offset), most = MOST_OPEN + daft_length(row->offset0);
    if (!(open > most)) return;
    solve_context c = make_context(world, row, substep, true);
    daft_sim_cofactors k = point_cofactors(&c);
    daft_vec3 impulse = solve3(&k, daft_scale(c.offset, (open - most) / open));
    shift(&c, &world->solver->rows, 0, impulse);
    shift(&c, &world->solver->rows, 1, daft_neg(impulse));
}

/* ---- before and after ---- */

/* What it keeps from a substep of another length. */
static void scale_impulses(daft_sim_joint *j, float longer)
{
    j->linear_impulse = daft_scale(j->linear_impulse, longer);
    j->angular_impulse = daft_scale(j->angular_impulse, longer);
    j->motor_impulse *= longer, j->lower_impulse *= longer, j->upper_impulse *= longer, j->spring_impulse *= longer;
}

void daft_sim_joint_begin(daft_world *world, daft_sim_joint_row *row)
{
    daft_sim_joint *j = &world->joints[row->joint];
    float before = 0;
    daft_dvec3 at[2];
    for (int i = 0; i < 2; i++) {
        row->inv_mass[i] = 0;
        row->arm0[i] = daft_v3(0, 0, 0);
        row->frame0[i] = j->frame[i];
        at[i] = j->fixed;
        if (j->body[i] == DAFT_SIM_NONE) continue;
        const daft_sim_body *body = &world->bodies[j->body[i]];
        row->arm0[i] = daft_quat_rotate(body->rotation, j->anchor[i]);
        row->frame0[i] = daft_quat_mul(body->rotation, j->frame[i]);
        at[i] = daft_dadd(body->centre, daft_to_double(row->arm0[i]));
        if (row->row[i] <= world->solver->mover_count) continue;
        before = body->h;
        row->inv_mass[i] = body->inv_mass;
    }
    if (before > 0 && before != world->solver->h) scale_impulses(j, world->solver->h / before);
    row->offset0 = daft_to_float(daft_dsub(at[1], at[0]));
    row->linear_sum = row->angular_sum = daft_v3(0, 0, 0);
    place_joint(world, row);
}

void daft_sim_joint_end(daft_world *world, daft_sim_joint_row *row, float dt)
{
    daft_sim_joint *j = &world->joints[row->joint];
    j->force = daft_length(row->linear_sum) / dt;
    j->torque = daft_length(row->angular_sum) / dt;
}

float daft_sim_joint_value(const daft_world *world, const daft_sim_joint *j, daft_dvec3 at[2])
{
    daft_quat frame[2];
    for (int i = 0; i < 2; i++) {
        frame[i] = j->frame[i];
        at[i] = j->fixed;
        if (j->body[i] == DAFT_SIM_NONE) continue;
        const daft_sim_body *body = &world->bodies[j->body[i]];
        at[i] = daft_dadd(body->centre, daft_to_double(daft_quat_rotate(body->rotation, j->anchor[i])));
        frame[i] = daft_quat_mul(body->rotation, j->frame[i]);
    }
    daft_vec3 offset = daft_to_float(daft_dsub(at[1], at[0])), axis = daft_quat_rotate(frame[0], UNIT[0]);
    if (j->kind == DAFT_JOINT_HINGE) return hinge_angle(frame);
    if (j->kind == DAFT_JOINT_SLIDER) return daft_dot(offset, axis);
    if (j->kind != DAFT_JOINT_BALL) return daft_length(offset);
    daft_vec3 other = daft_quat_rotate(frame[1], UNIT[0]);
    return (float)daft_atan2((double)daft_length(daft_cross(axis, other)), (double)daft_dot(axis, other));
}
