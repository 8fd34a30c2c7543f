/* The solver: substeps of soft contact constraints, each followed by a relaxation ("soft step", Catto, "Solver2D",
 * 2024; Macklin et al., "Small Steps in Physics Simulation", 2019). In a substep: forces change velocities, the
 * impulses of the last substep are applied, constraints are solved with a spring that pushes overlap apart, bodies
 * move, and constraints are solved again without the spring, which takes out the speed it gave. Bounces come last, at
 * the speed with which the surfaces truly met.
 *
 * A light body between a heavy one and the floor is where such solvers fail: an impulse that is right for the light one
 * hardly slows the heavy one. So a contact between yielding bodies is solved together with the contact that holds each
 * of them up: eliminating that one (the Schur complement) leaves the body's inverse mass without its part along the
 * support. The light body then weighs, downwards, as much as the floor. */
#include "sim/internal.h"

#include <stdlib.h>

/* The spring of a contact: at most CONTACT_HERTZ and a quarter of the substeps' rate, heavily overdamped. Against what
 * does not yield, overlap is undone twice as fast and the impulse is rigid. PUSH_SPEED bounds how fast overlap is
 * undone, so that deep overlap does not explode. */
#define CONTACT_HERTZ   30.0f
#define CONTACT_DAMPING 10.0f
#define PUSH_SPEED      3.0f
#define BOUNCE_SPEED    1.0f /* m/s; slower contacts do not bounce */
/* How much of a body's give towards its support is eliminated. All of it would leave a body between two supports with
 * no give at all, and an impulse without bound. */
#define SUPPORT 0.999f

/* Shares of a rigid constraint's impulse and of the accumulated one, and speed per metre of overlap. */
typedef struct softness {
    float rate, mass, impulse;
} softness;

typedef struct substep {
    float h, inv_h;
    softness yielding, fixed;
    bool biased; /* springs act */
} substep;

static softness make_soft(float hertz, float damping, float h)
{
    float omega = 2 * (float)DAFT_PI * hertz;
    float a1 = 2 * damping + h * omega, a2 = h * omega * a1, a3 = 1 / (1 + a2);
    return (softness){omega / a1, a2 * a3, a3};
}

float daft_sim_separation(const daft_sim_point *p, const daft_sim_motion *a, const daft_sim_motion *b)
{
    daft_vec3 d = daft_sub(b->delta, a->delta);
    if (p->turns) {
        daft_vec3 turned_a = daft_sub(daft_quat_rotate(a->turn, p->core_a), p->core_a);
        daft_vec3 turned_b = daft_sub(daft_quat_rotate(b->turn, p->core_b), p->core_b);
        d = daft_add(d, daft_sub(turned_b, turned_a));
    }
    return p->separation + daft_dot(d, p->normal);
}

static daft_vec3 relative_velocity(const daft_sim_point *p, const daft_sim_motion *a, const daft_sim_motion *b)
{
    daft_vec3 va = daft_add(a->linear, daft_cross(a->angular, p->anchor_a));
    daft_vec3 vb = daft_add(b->linear, daft_cross(b->angular, p->anchor_b));
    return daft_sub(vb, va);
}

static void apply(const daft_sim_point *p, daft_sim_motion *a, daft_sim_motion *b, daft_vec3 impulse)
{
    a->linear = daft_sub(a->linear, daft_scale(impulse, a->inv_mass));
    a->angular = daft_sub(a->angular, daft_scale(daft_cross(p->anchor_a, impulse), a->inv_inertia));
    b->linear = daft_add(b->linear, daft_scale(impulse, b->inv_mass));
    b->angular = daft_add(b->angular, daft_scale(daft_cross(p->anchor_b, impulse), b->inv_inertia));
}

static void apply_torque(daft_sim_motion *a, daft_sim_motion *b, daft_vec3 impulse)
{
    a->angular = daft_sub(a->angular, daft_scale(impulse, a->inv_inertia));
    b->angular = daft_add(b->angular, daft_scale(impulse, b->inv_inertia));
}

static daft_vec3 limited(daft_vec3 v, float limit)
{
    float length = daft_length(v);
    return length > limit ? daft_scale(v, limit / length) : v;
}

/* Coulomb's cone: the friction impulse opposes sliding and is at most friction times the normal impulse. */
static void solve_friction(daft_sim_point *p, daft_sim_motion *a, daft_sim_motion *b)
{
    daft_vec3 v = relative_velocity(p, a, b);
    v = daft_sub(v, daft_scale(p->normal, daft_dot(v, p->normal)));
    daft_vec3 wanted = daft_sub(p->friction_impulse, daft_scale(v, p->tangent_mass));
    wanted = limited(wanted, p->friction * p->normal_impulse);
    daft_vec3 change = daft_sub(wanted, p->friction_impulse);
    p->friction_impulse = wanted;
    apply(p, a, b, change);
}

static void solve_rolling(daft_sim_point *p, daft_sim_motion *a, daft_sim_motion *b)
{
    daft_vec3 spin = daft_sub(b->angular, a->angular);
    daft_vec3 wanted = daft_sub(p->rolling_impulse, daft_scale(spin, p->rolling_mass));
    wanted = limited(wanted, p->rolling * p->normal_impulse);
    apply_torque(a, b, daft_sub(wanted, p->rolling_impulse));
    p->rolling_impulse = wanted;
}

static void solve_normal(daft_sim_point *p, daft_sim_motion *a, daft_sim_motion *b, const substep *s)
{
    float separation = daft_sim_separation(p, a, b), bias = 0;
    softness soft = {0, 1, 0};
    if (separation > 0) {
        bias = separation * s->inv_h; /* they may close the gap within the substep and no more */
    } else if (s->biased) {
        soft = p->fixed ? s->fixed : s->yielding;
        bias = separation * soft.rate > -PUSH_SPEED ? separation * soft.rate : -PUSH_SPEED;
    }
    float speed = daft_dot(relative_velocity(p, a, b), p->normal);
    float wanted = p->normal_impulse - p->held_mass * soft.mass * (speed + bias) - soft.impulse * p->normal_impulse;
    if (!(wanted > 0)) wanted = 0;
    apply(p, a, b, daft_scale(p->normal, wanted - p->normal_impulse));
    p->normal_impulse = wanted;
}

static void solve_points(daft_world *world, const substep *s)
{
    for (size_t i = 0; i < world->point_count; i++) {
        daft_sim_point *p = &world->points[i];
        daft_sim_motion *a = &world->motions[p->a], *b = &world->motions[p->b];
        solve_normal(p, a, b, s);
        solve_friction(p, a, b);
        if (p->rolling > 0) solve_rolling(p, a, b);
    }
}

static void warm_start(daft_world *world)
{
    for (size_t i = 0; i < world->point_count; i++) {
        const daft_sim_point *p = &world->points[i];
        daft_sim_motion *a = &world->motions[p->a], *b = &world->motions[p->b];
        apply(p, a, b, daft_add(daft_scale(p->normal, p->normal_impulse), p->friction_impulse));
        apply_torque(a, b, p->rolling_impulse);
    }
}

static void note_support(daft_sim_motion *m, daft_vec3 push, float impulse)
{
    if (impulse <= m->support_impulse) return;
    m->support_impulse = impulse;
    m->support = push;
}

/* The inverse mass of a body pushed along a unit vector, with its support. */
static float held_inverse_mass(const daft_sim_motion *m, daft_vec3 along)
{
    float against = m->support_impulse > 0 ? -daft_dot(along, m->support) : 0;
    return against > 0 ? m->inv_mass * (1 - SUPPORT * against * against) : m->inv_mass;
}

static void find_supports(daft_world *world)
{
    for (size_t i = 0; i < world->dynamics.count; i++) world->motions[world->dynamics.items[i]].support_impulse = 0;
    for (size_t i = 0; i < world->point_count; i++) {
        const daft_sim_point *p = &world->points[i];
        daft_sim_motion *a = &world->motions[p->a], *b = &world->motions[p->b];
        if (!p->fixed) continue;
        if (a->inv_mass > 0)
            note_support(a, daft_neg(p->normal), p->normal_impulse);
        else
            note_support(b, p->normal, p->normal_impulse);
    }
    for (size_t i = 0; i < world->point_count && !world->points[i].fixed; i++) {
        daft_sim_point *p = &world->points[i];
        p->held_mass = 1 / (held_inverse_mass(&world->motions[p->a], daft_neg(p->normal)) +
                            held_inverse_mass(&world->motions[p->b], p->normal));
    }
}

static void integrate_velocities(daft_world *world, float h)
{
    for (size_t i = 0; i < world->dynamics.count; i++) {
        daft_sim_motion *m = &world->motions[world->dynamics.items[i]];
        daft_vec3 before = m->linear;
        m->linear = daft_sim_clamp(daft_add(before, daft_scale(m->acceleration, h)), DAFT_SIM_MAX_SPEED);
        m->angular = daft_sim_clamp(m->angular, DAFT_SIM_MAX_SPIN);
        m->gain = daft_sub(m->linear, before);
        m->pushed = false;
    }
}

static void mark_pushed(daft_world *world)
{
    for (size_t i = 0; i < world->point_count; i++) {
        const daft_sim_point *p = &world->points[i];
        if (p->normal_impulse > 0) world->motions[p->a].pushed = world->motions[p->b].pushed = true;
    }
}

/* A body that nothing pushes moves by the mean of its velocities before and after: exact for a constant force. */
static void move(daft_sim_motion *m, float h)
{
    daft_vec3 mean = m->pushed ? m->linear : daft_sub(m->linear, daft_scale(m->gain, 0.5f));
    m->delta = daft_add(m->delta, daft_scale(mean, h));
    if (m->angular.x != 0 || m->angular.y != 0 || m->angular.z != 0) m->turn = daft_sim_turn(m->turn, m->angular, h);
}

static void integrate_poses(daft_world *world, float h)
{
    for (size_t i = 0; i < world->dynamics.count; i++) move(&world->motions[world->dynamics.items[i]], h);
    for (size_t i = 0; i < world->movers.count; i++) move(&world->motions[world->movers.items[i]], h);
}

/* The bounce's impulse adds to the step's, and gives friction its share; it is not kept for the next step's start. */
static void bounce(daft_sim_point *p, daft_sim_motion *a, daft_sim_motion *b)
{
    float speed = daft_dot(relative_velocity(p, a, b), p->normal);
    float impulse = -p->normal_mass * (speed - p->restitution * p->approach);
    if (!(impulse > 0)) return;
    apply(p, a, b, daft_scale(p->normal, impulse));
    p->total_impulse += impulse;
    p->normal_impulse = impulse;
    p->friction_impulse = daft_v3(0, 0, 0);
    solve_friction(p, a, b);
    p->normal_impulse = 0;
    p->friction_impulse = p->rolling_impulse = daft_v3(0, 0, 0);
}

static void bounce_points(daft_world *world)
{
    for (size_t i = 0; i < world->point_count; i++) {
        daft_sim_point *p = &world->points[i];
        if (p->restitution > 0 && p->approach > BOUNCE_SPEED && p->total_impulse > 0)
            bounce(p, &world->motions[p->a], &world->motions[p->b]);
    }
}

void daft_sim_solve(daft_world *world, float dt)
{
    substep s = {.h = dt / DAFT_SIM_SUBSTEPS, .inv_h = DAFT_SIM_SUBSTEPS / dt};
    float hertz = 0.25f * s.inv_h < CONTACT_HERTZ ? 0.25f * s.inv_h : CONTACT_HERTZ;
    s.yielding = make_soft(hertz, CONTACT_DAMPING, s.h);
    s.fixed = (softness){make_soft(2 * hertz, CONTACT_DAMPING, s.h).rate, 1, 0};
    for (int i = 0; i < DAFT_SIM_SUBSTEPS; i++) {
        integrate_velocities(world, s.h);
        warm_start(world);
        find_supports(world);
        s.biased = true;
        solve_points(world, &s);
        mark_pushed(world);
        integrate_poses(world, s.h);
        s.biased = false;
        solve_points(world, &s);
        for (size_t p = 0; p < world->point_count; p++)
            world->points[p].total_impulse += world->points[p].normal_impulse;
    }
    bounce_points(world);
}
