/* Continuous collision, the last word. Contacts cover what a body meets on the way it is going as the step begins; one
 * that was deflected at speed may meet something else. So what moved far for its size is swept from where it was to
 * where the solver put it, and stops at the first thing it would have passed; the next step finds the contact there,
 * with the speed as it was. What is swept is the core, a ball half as wide as the largest one in the shape, so that what
 * a body rolls on does not stop it. */
#include "sim/solver.h"

/* Bodies stop this far from what they hit, as a share of the inner radius, but no farther than MAX_GAP; and the share of
 * that which does not matter. */
#define TARGET    0.04
#define MAX_GAP   0.005 /* m */
#define TOLERANCE 0.25
#define CORE      0.5f

typedef struct sweep {
    const daft_world *world;
    const daft_sim_target *targets; /* of rows */
    uint32_t part;
    daft_sweep core;
    daft_sim_shape ball;
    double target, share;
    uint32_t count; /* times of impact searched for */
} sweep;

/* The way of a frame that stands at `pose` in a body. The body's centre goes straight. */
static daft_sweep way_of(const daft_sim_body *body, const daft_rigid *pose, daft_quat turn, daft_dvec3 to,
                         daft_quat rotation)
{
    daft_dvec3 centre = daft_rigid_to_local(pose, daft_to_double(body->local_centre));
    return (daft_sweep){.from = body->centre,
                        .to = to,
                        .rotation_from = daft_quat_normalize(daft_quat_mul(body->rotation, turn)),
                        .rotation_to = daft_quat_normalize(daft_quat_mul(rotation, turn)),
                        .centre = daft_to_float(centre)};
}

static daft_sweep way_of_other(const sweep *s, const daft_sim_part *part)
{
    const daft_sim_body *body = &s->world->bodies[part->body];
    daft_dvec3 to = body->centre;
    daft_quat rotation = body->rotation;
    if (body->kind == DAFT_BODY_DYNAMIC && daft_sim_is_active(body)) {
        to = s->targets[body->state].centre;
        rotation = s->targets[body->state].rotation;
    }
    return way_of(body, &part->pose, part->turn, to, rotation);
}

static bool is_hit(daft_impact_kind kind) { return kind == DAFT_IMPACT_HIT || kind == DAFT_IMPACT_GAVE_UP; }

static void visit(void *context, uint32_t other)
{
    sweep *s = context;
    const daft_sim_part *part = &s->world->parts[s->part], *hit = &s->world->parts[other];
    if (hit->sensor || !daft_sim_may_meet(s->world, s->part, other)) return;
    daft_sweep its = way_of_other(s, hit);
    daft_impact impact;
    if (!(part->inner > 0)) return;
    s->count++;
    daft_impact_kind kind =
        daft_shape_impact(&s->ball, &s->core, &hit->shape, &its, s->target, TOLERANCE * s->target, &impact);
    if (is_hit(kind) && impact.t < s->share) s->share = impact.t;
}

/* All that a body passes through; what turns stays within its extent from the centre. */
static daft_sim_bounds way_bounds(const daft_sim_body *body, daft_dvec3 to)
{
    double r = (double)body->extent;
    daft_dvec3 d = daft_dv3(r, r, r);
    return (daft_sim_bounds){daft_dsub(daft_sim_dmin(body->centre, to), d),
                             daft_dadd(daft_sim_dmax(body->centre, to), d)};
}

static void sweep_part(sweep *s, uint32_t index, const daft_sim_target *target)
{
    const daft_world *world = s->world;
    const daft_sim_part *part = &world->parts[index];
    const daft_sim_body *body = &world->bodies[part->body];
    daft_rigid core = part->pose;
    s->part = index;
    core.p = daft_rigid_point(&part->pose, daft_to_double(part->middle));
    s->core = way_of(body, &core, part->turn, target->centre, target->rotation);
    s->ball = (daft_sim_shape){.type = DAFT_GEOMETRY_SPHERE, .radius = CORE * part->inner};
    s->target = TARGET * (double)(part->inner > 0 ? part->inner : part->reach);
    if (s->target > MAX_GAP) s->target = MAX_GAP;
    daft_sim_bounds bounds = way_bounds(body, target->centre);
    daft_sim_tree_query(&world->trees[DAFT_BODY_STATIC], &bounds, visit, s);
    daft_sim_tree_query(&world->trees[DAFT_BODY_KINEMATIC], &bounds, visit, s);
    if (body->bullet) daft_sim_tree_query(&world->trees[DAFT_BODY_DYNAMIC], &bounds, visit, s);
}

double daft_sim_sweep(const daft_world *world, uint32_t row, const daft_sim_target *targets, uint32_t *count)
{
    uint32_t index = world->solver->row_bodies[row];
    const daft_sim_body *body = &world->bodies[index];
    sweep s = {.world = world, .targets = targets, .share = 1};
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = world->parts[i].next)
        if (!world->parts[i].sensor && daft_shape_has_mass(&world->parts[i].shape))
            sweep_part(&s, i, &targets[row]);
    *count = s.count;
    return s.share;
}
