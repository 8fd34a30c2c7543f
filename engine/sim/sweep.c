/* Continuous collision, the last word. Contacts cover what a body meets on its path as the step begins; one
 * that was deflected at speed may meet something else. So what moved far for its size is swept from where it was to
 * where the solver put it, and stops at the first thing it would have passed; the next step finds the contact there,
 * with the speed as it was. What is swept is the core, a ball half as wide as the largest one in the shape, so that
 * what a body rolls on does not stop it. What was pressed deeper into something than that goes along it and no deeper,
 * and loses the speed with which it would: contacts may miss what spins at hundreds of radians a second. So the middle
 * of a body that is fast enough to be swept never changes sides. */
#include "sim/solve/solver.h"
#include "sim/contact/contact.h"

#include <string.h>

/* Bodies stop this far from what they hit, as a fraction of the inner radius, but no farther than MAX_GAP; and the
 * fraction of that which does not matter. */
#define TARGET    0.04
#define MAX_GAP   0.005 /* m */
#define TOLERANCE 0.25
#define CORE      0.5f

enum { SLIDES = 4 }; /* walls in a corner; after more the body stays where it is */

typedef struct sweep {
    const daft_world *world;
    const daft_sim_target *targets; /* of rows */
    uint32_t part;
    daft_sweep core;
    daft_dvec3 middle; /* of the core as the step begins */
    daft_dvec3 to;     /* of the body's centre */
    daft_vec3 linear;  /* of the body */
    double target, fraction;
    uint32_t count;    /* times of impact searched for */
    uint32_t first;    /* part that is met first; DAFT_SIM_NONE: none */
    bool pressed;      /* it does not yield, and the body is deep in it */
    daft_dvec3 normal; /* towards it */
} sweep;

/* The path of a frame that stands at `pose` in a body. The body's centre goes straight. */
static daft_sweep path_of(const daft_sim_body *body, const daft_rigid *pose, daft_quat turn, daft_dvec3 to,
                          daft_quat rotation)
{
    daft_dvec3 centre = daft_rigid_to_local(pose, daft_to_double(body->local_centre));
    return (daft_sweep){.from = body->centre,
                        .to = to,
                        .rotation_from = daft_quat_normalize(daft_quat_mul(body->rotation, turn)),
                        .rotation_to = daft_quat_normalize(daft_quat_mul(rotation, turn)),
                        .centre = daft_to_float(centre)};
}

static daft_sweep path_of_other(const sweep *s, const daft_sim_part *part)
{
    const daft_sim_body *body = &s->world->bodies[part->body];
    daft_dvec3 to = body->centre;
    daft_quat rotation = body->rotation;
    if (body->kind == DAFT_BODY_DYNAMIC && daft_sim_is_active(body)) {
        to = s->targets[body->state].centre;
        rotation = s->targets[body->state].rotation;
    }
    return path_of(body, &part->pose, part->turn, to, rotation);
}

static bool is_hit(daft_impact_kind kind) { return kind == DAFT_IMPACT_HIT || kind == DAFT_IMPACT_GAVE_UP; }

/* Where the core would begin nearer to the other than it is to stop, it becomes smaller, and stops as near as it is. 0:
 * its middle is within the other; contacts see to it. */
static bool shrink(const sweep *s, const daft_sim_part *other, double *radius, double *target)
{
    daft_rigid frame = daft_sim_part_frame(&s->world->bodies[other->body], other);
    double near = *radius + (1 + 2 * TOLERANCE) * *target, distance;
    daft_dvec3 on;
    daft_shape_part where;
    if (!daft_shape_closest(&other->shape, daft_rigid_to_local(&frame, s->middle), near, &on, &distance, &where))
        return false;
    *radius = 0.5 * distance;
    *target = 0.49 * distance;
    return true;
}

static void visit(void *context, uint32_t other)
{
    sweep *s = context;
    const daft_sim_part *part = &s->world->parts[s->part], *hit = &s->world->parts[other];
    if (hit->sensor || !daft_sim_may_meet(s->world, s->part, other)) return;
    if (!(part->inner > 0)) return;
    double radius = (double)(CORE * part->inner), target = s->target;
    bool pressed = shrink(s, hit, &radius, &target);
    if (!(radius > 0)) return;
    daft_sweep its = path_of_other(s, hit);
    daft_sim_shape ball = {.type = DAFT_GEOMETRY_SPHERE, .radius = (float)radius};
    daft_impact impact;
    s->count++;
    daft_impact_kind kind = daft_shape_impact(&ball, &s->core, &hit->shape, &its, target, TOLERANCE * target, &impact);
    if (!is_hit(kind) || impact.t > s->fraction || (impact.t == s->fraction && other > s->first)) return;
    bool yields = s->world->bodies[hit->body].kind == DAFT_BODY_DYNAMIC;
    s->fraction = impact.t;
    s->first = other;
    s->pressed = pressed && !yields;
    s->normal = impact.normal;
}

/* The displacement and the velocity lose what leads into the wall; the displacement a millionth more, lest rounding
 * leave it some. */
static void slide(sweep *s, const daft_sim_body *body)
{
    const daft_sim_body *wall = &s->world->bodies[s->world->parts[s->first].body];
    daft_vec3 arm = daft_to_float(daft_dsub(body->centre, wall->centre)), n = daft_to_float(s->normal);
    daft_vec3 its = daft_add(wall->linear, daft_cross(wall->angular, arm));
    float speed = daft_dot(daft_sub(s->linear, its), n);
    double into = daft_ddot(daft_dsub(s->to, body->centre), s->normal);
    if (speed > 0) s->linear = daft_sub(s->linear, daft_scale(n, speed));
    if (into > 0) s->to = daft_dsub(s->to, daft_dscale(s->normal, 1.000001 * into));
}

/* All that a body passes through; what turns stays within its extent from the centre. */
static daft_sim_bounds path_bounds(const daft_sim_body *body, daft_dvec3 to)
{
    double r = (double)body->extent;
    daft_dvec3 d = daft_dv3(r, r, r);
    return (daft_sim_bounds){daft_dsub(daft_sim_dmin(body->centre, to), d),
                             daft_dadd(daft_sim_dmax(body->centre, to), d)};
}

static void note(void *context, uint32_t part)
{
    (void)part;
    *(bool *)context = true;
}

/* Whether there is anything on its path. */
static bool is_watched(const daft_world *world, const daft_sim_body *body, daft_dvec3 to)
{
    daft_sim_bounds bounds = path_bounds(body, to);
    bool any = false;
    daft_sim_tree_query(&world->trees[DAFT_BODY_STATIC], &bounds, note, &any);
    if (!any) daft_sim_tree_query(&world->trees[DAFT_BODY_KINEMATIC], &bounds, note, &any);
    return any || body->bullet;
}

static void sweep_part(sweep *s, uint32_t index, daft_quat rotation)
{
    const daft_world *world = s->world;
    const daft_sim_part *part = &world->parts[index];
    const daft_sim_body *body = &world->bodies[part->body];
    daft_rigid core = part->pose;
    s->part = index;
    core.p = daft_rigid_point(&part->pose, daft_to_double(part->middle));
    s->core = path_of(body, &core, part->turn, s->to, rotation);
    s->middle = daft_rigid_point(&body->frame, core.p);
    s->target = TARGET * (double)(part->inner > 0 ? part->inner : part->reach);
    if (s->target > MAX_GAP) s->target = MAX_GAP;
    daft_sim_bounds bounds = path_bounds(body, s->to);
    daft_sim_tree_query(&world->trees[DAFT_BODY_STATIC], &bounds, visit, s);
    daft_sim_tree_query(&world->trees[DAFT_BODY_KINEMATIC], &bounds, visit, s);
    if (body->bullet) daft_sim_tree_query(&world->trees[DAFT_BODY_DYNAMIC], &bounds, visit, s);
}

static void sweep_body(sweep *s, const daft_sim_body *body, daft_quat rotation)
{
    s->fraction = 1;
    s->first = DAFT_SIM_NONE;
    s->pressed = false;
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = s->world->parts[i].next)
        if (!s->world->parts[i].sensor && daft_shape_has_mass(&s->world->parts[i].shape)) sweep_part(s, i, rotation);
}

static void stop_at(daft_sim_target *t, const daft_sim_body *body, double fraction)
{
    t->fraction = fraction;
    t->stop = t->along;
    if (fraction == 1) return;
    t->stop = daft_dadd(body->centre, daft_dscale(daft_dsub(t->along, body->centre), fraction));
    t->stop_rotation = daft_quat_nlerp(body->rotation, t->rotation, (float)fraction);
}

static daft_dvec3 within_locks(const daft_sim_body *body, daft_dvec3 to)
{
    if (!(body->locks & DAFT_LOCK_POSITION)) return to;
    daft_vec3 displacement = daft_to_float(daft_dsub(to, body->centre));
    return daft_dadd(body->centre, daft_to_double(daft_sim_unlocked(body, displacement, DAFT_LOCK_POSITION_X)));
}

/* What is joined to a body that is made to go along a wall goes on into it: of a displacement that would open joints by
 * more than this, in metres, it goes only so far as not to. */
#define MOST_TURNED_ASIDE 0.004

static double share_with_joined(const sweep *s, const daft_sim_body *body, daft_dvec3 wanted)
{
    daft_dvec3 aside = daft_dsub(wanted, s->to);
    double far = body->first_joint == DAFT_SIM_NONE ? 0 : sqrt(daft_ddot(aside, aside));
    return far * s->fraction > MOST_TURNED_ASIDE ? MOST_TURNED_ASIDE / far : s->fraction;
}

void daft_sim_sweep(const daft_world *world, uint32_t row, daft_sim_target *targets)
{
    const daft_sim_body *body = &world->bodies[world->scratch.solver->row_bodies[row]];
    daft_sim_target *target = &targets[row];
    if (!is_watched(world, body, target->centre)) return;
    sweep s = {.world = world, .targets = targets, .to = target->centre, .linear = body->linear};
    sweep_body(&s, body, target->rotation);
    for (int i = 0; s.pressed && i < SLIDES; i++) {
        slide(&s, body);
        sweep_body(&s, body, target->rotation);
    }
    target->sweeps = s.count;
    target->linear = s.linear;
    target->along = within_locks(body, s.to);
    stop_at(target, body, share_with_joined(&s, body, target->centre));
}

/* ---- what is joined to it ---- */

/* A limb that is stopped while the rest of a doll goes on would have its joint torn open by the rest of the
 * displacement. So of two bodies in a joint neither gets much farther than the other, as a fraction of its own
 * displacement: each joint adds this.
 */
#define AHEAD_OF_JOINED (1.0 / 64)

/* Rows whose neighbours are to be looked at: a ring in which each is once at most. */
typedef struct waiting {
    uint32_t *rows;
    uint8_t *in;
    uint32_t first, count, size;
} waiting;

static void put(waiting *w, uint32_t row)
{
    if (w->in[row]) return;
    w->in[row] = 1;
    w->rows[(w->first + w->count++) % w->size] = row;
}

static uint32_t take(waiting *w)
{
    uint32_t row = w->rows[w->first];
    w->first = (w->first + 1) % w->size, w->count--;
    w->in[row] = 0;
    return row;
}

static bool hold_back(daft_sim_target *t, const daft_sim_body *body, double fraction)
{
    if (!(fraction < t->fraction)) return false;
    stop_at(t, body, fraction);
    return true;
}

static void hold_neighbours(const daft_world *world, waiting *w, uint32_t row)
{
    daft_sim_target *targets = world->scratch.solver->targets;
    double fraction = targets[row].fraction + AHEAD_OF_JOINED;
    const daft_sim_body *body = &world->bodies[world->scratch.solver->row_bodies[row]];
    for (uint32_t e = body->first_joint; e != DAFT_SIM_NONE; e = world->joints[e >> 1].next[e & 1]) {
        const daft_sim_joint *joint = &world->joints[e >> 1];
        uint32_t other = joint->body[(e & 1) ^ 1],
                 at = other == DAFT_SIM_NONE ? 0 : world->scratch.solver->row_of[other];
        if (joint->spring || at <= world->scratch.solver->mover_count) continue;
        if (hold_back(&targets[at], &world->bodies[other], fraction)) put(w, at);
    }
}

/* Each gets the least of what all that were stopped leave it, in whatever order they are looked at. */
void daft_sim_sweep_joined(daft_world *world)
{
    daft_sim_solver *s = world->scratch.solver;
    uint32_t first = 1 + s->mover_count;
    if (world->live_joints == 0 || s->row_count == first) return;
    waiting w = {.rows = s->levels, .in = s->marks, .size = s->row_count};
    memset(s->marks, 0, s->row_count);
    for (uint32_t row = first; row < s->row_count; row++)
        if (s->targets[row].fraction < 1) put(&w, row);
    while (w.count > 0) hold_neighbours(world, &w, take(&w));
}
