/* One step of the world: plans, contacts, solver, poses, report. A world without a dynamic body only moves its
 * kinematic bodies, and a world in which none of those move does nothing. */
#include "sim/internal.h"

#include "math/real.h"

/* A body that moved this much, and this much off its plan, in radii, is swept along its true path. The core that is
 * swept, as a share of the radius, is smaller than the sphere so that what it rolls on does not stop it. */
#define FAST_MOVE  0.5f
#define OFF_PLAN   0.25f
#define SWEPT_CORE 0.5

/* ---- kinematic bodies ---- */

/* The angular velocity that turns `from` into `to` within dt, the shorter way round. */
static daft_vec3 turning(daft_quat from, daft_quat to, float dt)
{
    daft_quat d = daft_quat_mul(to, (daft_quat){-from.x, -from.y, -from.z, from.w});
    double sign = d.w < 0 ? -1 : 1;
    double x = (double)d.x, y = (double)d.y, z = (double)d.z, sine = sqrt(x * x + y * y + z * z);
    if (sine < 1e-7) return daft_v3(0, 0, 0); /* what two rounded quaternions of one pose differ by */
    double scale = sign * 2 * daft_atan2(sine, fabs((double)d.w)) / (sine * (double)dt);
    return daft_v3((float)(x * scale), (float)(y * scale), (float)(z * scale));
}

static bool at_rest(const daft_sim_motion *m)
{
    return m->linear.x == 0 && m->linear.y == 0 && m->linear.z == 0 && m->angular.x == 0 && m->angular.y == 0 &&
           m->angular.z == 0;
}

static void begin_mover(daft_sim_body *body, daft_sim_motion *m, float dt)
{
    if (body->has_target) {
        daft_dvec3 way = daft_dsub(body->target_position, body->position);
        m->linear = daft_sim_clamp(daft_to_float(daft_dscale(way, 1 / (double)dt)), DAFT_SIM_MAX_SPEED);
        m->angular = daft_sim_clamp(turning(body->rotation, body->target_rotation, dt), DAFT_SIM_MAX_SPIN);
        body->follows = true;
    } else if (body->follows) {
        m->linear = m->angular = daft_v3(0, 0, 0);
        body->follows = false;
    }
    m->delta = daft_v3(0, 0, 0);
    m->turn = daft_quat_identity();
    m->planned = daft_scale(m->linear, dt);
}

static void set_pose(daft_sim_body *body, daft_dvec3 position, daft_quat rotation)
{
    body->position = position;
    body->rotation = rotation;
    if (body->shape == DAFT_SHAPE_BOX) daft_quat_matrix(rotation, body->basis);
}

static void end_movers(daft_world *world, float dt)
{
    size_t kept = 0;
    for (size_t i = 0; i < world->movers.count; i++) {
        uint32_t index = world->movers.items[i];
        daft_sim_body *body = &world->bodies[index];
        daft_sim_motion *m = &world->motions[index];
        if (body->has_target)
            set_pose(body, body->target_position, body->target_rotation);
        else if (!at_rest(m))
            set_pose(body, daft_dadd(body->position, daft_dscale(daft_to_double(m->linear), (double)dt)),
                     daft_sim_turn(body->rotation, m->angular, dt));
        body->has_target = false;
        m->planned = daft_v3(0, 0, 0);
        body->list_slot = at_rest(m) ? DAFT_SIM_NONE : (uint32_t)kept;
        if (body->list_slot != DAFT_SIM_NONE) world->movers.items[kept++] = index;
    }
    world->movers.count = kept;
}

/* ---- dynamic bodies ---- */

static void begin_dynamic(const daft_world *world, const daft_sim_body *body, daft_sim_motion *m, float dt)
{
    daft_vec3 acceleration = daft_add(world->gravity, daft_scale(body->force, m->inv_mass));
    m->acceleration = daft_sim_clamp(acceleration, DAFT_SIM_MAX_ACCELERATION);
    daft_vec3 mean = daft_add(m->linear, daft_scale(m->acceleration, 0.5f * dt));
    m->planned = daft_scale(daft_sim_clamp(mean, DAFT_SIM_MAX_SPEED), dt);
    m->delta = daft_v3(0, 0, 0);
    m->turn = daft_quat_identity();
}

typedef struct sweep {
    const daft_world *world;
    const daft_sim_body *body;
    daft_dvec3 way;
    double share; /* of the way that is free */
} sweep;

static void visit_sweep(void *context, uint32_t index)
{
    sweep *s = context;
    daft_sim_touch touch;
    double core = SWEPT_CORE * (double)s->body->radius;
    if (daft_sim_touch_sphere(&s->world->bodies[index], s->body->position, core, s->way, 0, &touch) && touch.time > 0 &&
        touch.time < s->share)
        s->share = touch.time;
}

/* Contacts cover what a body meets on its plan. One that was deflected at speed may meet something else: it stops
 * there, and the next step finds the contact. */
static daft_dvec3 free_way(const daft_world *world, uint32_t index)
{
    const daft_sim_body *body = &world->bodies[index];
    const daft_sim_motion *m = &world->motions[index];
    daft_dvec3 way = daft_to_double(m->delta);
    if (daft_length(m->delta) <= FAST_MOVE * body->radius ||
        daft_length(daft_sub(m->delta, m->planned)) <= OFF_PLAN * body->radius)
        return way;
    daft_sim_bounds bounds = daft_sim_shape_bounds(body);
    bounds.low = daft_dadd(bounds.low, daft_sim_dmin(way, daft_dv3(0, 0, 0)));
    bounds.high = daft_dadd(bounds.high, daft_sim_dmax(way, daft_dv3(0, 0, 0)));
    sweep s = {world, body, way, 1};
    daft_sim_tree_query(&world->trees[DAFT_BODY_STATIC], &bounds, visit_sweep, &s);
    return daft_dscale(way, s.share);
}

static void end_dynamics(daft_world *world)
{
    for (size_t i = 0; i < world->dynamics.count; i++) {
        uint32_t index = world->dynamics.items[i];
        daft_sim_body *body = &world->bodies[index];
        daft_sim_motion *m = &world->motions[index];
        m->linear = daft_sim_clamp(m->linear, DAFT_SIM_MAX_SPEED);
        m->angular = daft_sim_clamp(m->angular, DAFT_SIM_MAX_SPIN);
        set_pose(body, daft_dadd(body->position, free_way(world, index)),
                 daft_quat_normalize(daft_quat_mul(m->turn, body->rotation)));
        body->force = daft_v3(0, 0, 0);
    }
}

/* ---- report ---- */

static bool reserve_report(daft_world *world)
{
    return daft_grow(&world->allocator, &world->report, &world->report_capacity, world->point_count, 0,
                     sizeof *world->report) &&
           daft_grow(&world->allocator, &world->report_keys, &world->report_key_capacity, world->point_count, 0,
                     sizeof *world->report_keys);
}

/* Where the contact is after the step: on the sphere's surface. */
static daft_dvec3 contact_point(const daft_world *world, const daft_sim_point *p)
{
    bool a_is_sphere = world->bodies[p->a].kind == DAFT_BODY_DYNAMIC;
    const daft_sim_body *sphere = &world->bodies[a_is_sphere ? p->a : p->b];
    return daft_dadd(sphere->position, daft_to_double(a_is_sphere ? p->anchor_a : p->anchor_b));
}

/* A pair is reported if it pressed on each other in the step, or touches at its end. */
static void fill_report(daft_world *world)
{
    world->report_count = 0;
    for (size_t i = 0; i < world->point_count; i++) {
        const daft_sim_point *p = &world->points[i];
        const daft_sim_motion *a = &world->motions[p->a], *b = &world->motions[p->b];
        world->bodies[p->a].fresh = world->bodies[p->b].fresh = false;
        if (!(p->total_impulse > 0) && daft_sim_separation(p, a, b) > 0) continue;
        world->report_keys[world->report_count] = (uint64_t)p->a << 32 | p->b;
        world->report[world->report_count++] = (daft_sim_contact){world->bodies[p->a].user, world->bodies[p->b].user,
                                                                  contact_point(world, p), p->normal, p->total_impulse};
    }
}

static void keep_points(daft_world *world)
{
    daft_sim_point *points = world->old_points;
    size_t capacity = world->old_capacity;
    world->old_points = world->points;
    world->old_capacity = world->point_capacity;
    world->old_count = world->point_count;
    world->points = points;
    world->point_capacity = capacity;
    world->point_count = 0;
}

bool daft_world_step(daft_world *world, float dt, daft_error *error)
{
    if (!(dt >= 0 && dt <= DAFT_SIM_MAX_DT))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "step: %g s is not within 0 to %g s", (double)dt,
                         (double)DAFT_SIM_MAX_DT);
    if (dt < 1e-9f) return true;
    for (size_t i = 0; i < world->movers.count; i++) {
        uint32_t index = world->movers.items[i];
        begin_mover(&world->bodies[index], &world->motions[index], dt);
    }
    for (size_t i = 0; i < world->dynamics.count; i++) {
        uint32_t index = world->dynamics.items[i];
        begin_dynamic(world, &world->bodies[index], &world->motions[index], dt);
    }
    daft_sim_broad_update(world, dt);
    if (!daft_sim_find_contacts(world, dt) || !reserve_report(world)) return daft_fail_memory(error, "contacts");
    daft_sim_solve(world, dt);
    end_dynamics(world);
    end_movers(world, dt);
    fill_report(world);
    keep_points(world);
    return true;
}
