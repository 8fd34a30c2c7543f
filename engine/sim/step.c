/* One step of the world. A world without anything active does nothing. */
#include "sim/solve/solver.h"
#include "sim/broad/broad.h"
#include "sim/contact/contact.h"
#include "sim/events.h"
#include "sim/joint/joint.h"
#include "sim/sleep.h"

#include "math/trig.h"

#include <stdatomic.h>

/* A body that moves more than this fraction of its inner radius in a step is swept. */
#define FAST_MOVE 0.5f

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

static void begin_mover(daft_sim_body *body, float dt)
{
    if (body->has_target) {
        daft_dvec3 displacement = daft_dsub(body->target_position, body->position);
        body->linear = daft_sim_clamp(daft_to_float(daft_dscale(displacement, 1 / (double)dt)), DAFT_SIM_MAX_SPEED);
        body->angular = daft_sim_clamp(turning(body->rotation, body->target_rotation, dt), DAFT_SIM_MAX_ANGULAR_SPEED);
        body->follows = true;
    } else if (body->follows) {
        body->linear = body->angular = daft_v3(0, 0, 0);
        body->follows = false;
    }
}

static void end_movers(daft_world *world, float dt)
{
    for (size_t i = world->movers.count; i-- > 0;) {
        uint32_t index = world->movers.items[i];
        daft_sim_body *body = &world->bodies[index];
        bool still = daft_sim_is_zero(body->linear) && daft_sim_is_zero(body->angular);
        if (body->has_target)
            daft_sim_body_place(body, body->target_position, body->target_rotation);
        else if (!still)
            daft_sim_body_place(body, daft_dadd(body->position, daft_dscale(daft_to_double(body->linear), (double)dt)),
                                daft_sim_turn(body->rotation, body->angular, dt));
        if (still && !body->has_target) daft_sim_list_remove(world, &world->movers, index);
        body->has_target = false;
    }
}

/* ---- dynamic bodies ---- */

static void place_centre(daft_sim_body *body, daft_dvec3 centre, daft_quat rotation)
{
    daft_dvec3 position = centre;
    if (!daft_sim_is_zero(body->local_centre)) {
        daft_rigid turned = daft_rigid_make(daft_dv3(0, 0, 0), rotation);
        position = daft_dsub(centre, daft_rigid_vector(&turned, daft_to_double(body->local_centre)));
    }
    daft_sim_body_place(body, position, rotation);
    body->centre = centre;
}

static bool out_of_world(daft_dvec3 p)
{
    double limit = DAFT_SIM_MAX_DISTANCE;
    return !(fabs(p.x) <= limit && fabs(p.y) <= limit && fabs(p.z) <= limit);
}

static daft_vec3 row3(const float *row) { return daft_v3(row[0], row[1], row[2]); }

/* Velocities, and where the body is to go; it is still where it was. */
static void take_row(daft_world *world, uint32_t row)
{
    const daft_sim_solver_bodies *rows = &world->scratch.solver->rows;
    daft_sim_body *body = &world->bodies[world->scratch.solver->row_bodies[row]];
    size_t at = (size_t)row * DAFT_SIM_ROW;
    const float *v = rows->velocity + at, *t = rows->turn + at;
    daft_vec3 linear = row3(v), angular = row3(v + 3), displacement = row3(rows->moved + at);
    daft_quat turn = {t[0], t[1], t[2], t[3]};
    daft_sim_target *target = &world->scratch.solver->targets[row];
    *target = (daft_sim_target){.centre = body->centre, .rotation = body->rotation};
    if (!daft_finite3(linear) || !daft_finite3(angular)) linear = angular = daft_v3(0, 0, 0);
    body->h = rows->moved[at + 6];
    body->substep_demand = daft_sim_substep_demand_next(world, body->substep_demand, row);
    body->linear = daft_sim_clamp(linear, v[6]);
    body->angular = daft_sim_clamp(angular, v[7]);
    body->force = body->torque = daft_v3(0, 0, 0);
    if (!daft_finite3(displacement) || !isfinite(turn.x + turn.y + turn.z + turn.w)) return;
    target->centre = daft_dadd(body->centre, daft_to_double(displacement));
    if (out_of_world(target->centre)) {
        body->linear = daft_v3(0, 0, 0);
        target->centre = body->centre;
    }
    if (turn.x != 0 || turn.y != 0 || turn.z != 0)
        target->rotation = daft_quat_normalize(daft_quat_mul(turn, body->rotation));
}

static void sweep_row(daft_world *world, uint32_t row)
{
    const daft_sim_body *body = &world->bodies[world->scratch.solver->row_bodies[row]];
    daft_sim_target *target = &world->scratch.solver->targets[row];
    target->stop = target->along = target->centre, target->stop_rotation = target->rotation,
    target->linear = body->linear, target->fraction = 1;
    const float *m = world->scratch.solver->rows.moved + (size_t)row * DAFT_SIM_ROW;
    float swing = daft_length(row3(m + 3)) * daft_sim_max(body->extent - body->inner, 0);
    if (daft_length(row3(m)) + daft_sim_min(swing, 2 * body->extent) <= FAST_MOVE * body->inner) return;
    daft_sim_sweep(world, row, world->scratch.solver->targets);
    atomic_fetch_add_explicit(&world->scratch.solver->sweeps, target->sweeps, memory_order_relaxed);
}

static void place_row(daft_world *world, uint32_t row)
{
    daft_sim_body *body = &world->bodies[world->scratch.solver->row_bodies[row]];
    const daft_sim_target *target = &world->scratch.solver->targets[row];
    body->linear = target->linear;
    place_centre(body, target->stop, target->stop_rotation);
}

enum { ROW_GRAIN = 64, PARALLEL_ROWS = 256 };

typedef struct row_job {
    daft_world *world;
    void (*run)(daft_world *world, uint32_t row);
} row_job;

static void run_rows(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const row_job *j = context;
    uint32_t first = 1 + j->world->scratch.solver->mover_count + index * ROW_GRAIN, end = first + ROW_GRAIN;
    for (uint32_t row = first; row < end && row < j->world->scratch.solver->row_count; row++) j->run(j->world, row);
}

static void for_rows(daft_world *world, void (*run)(daft_world *world, uint32_t row))
{
    uint32_t count = world->scratch.solver->row_count - (1 + world->scratch.solver->mover_count);
    daft_sim_for(world, count >= PARALLEL_ROWS, (count + ROW_GRAIN - 1) / ROW_GRAIN, run_rows, &(row_job){world, run});
}

/* All paths are swept before any body moves, so the order does not matter. */
static void end_dynamics(daft_world *world)
{
    daft_sim_solver *s = world->scratch.solver;
    atomic_store_explicit(&s->sweeps, 0, memory_order_relaxed);
    for_rows(world, take_row);
    for_rows(world, sweep_row);
    daft_sim_sweep_joined(world);
    for_rows(world, place_row);
    world->counters.sweeps = atomic_load_explicit(&s->sweeps, memory_order_relaxed);
}

/* ---- the step ---- */

static void count(daft_world *world)
{
    daft_sim_counters *c = &world->counters;
    c->pairs = (uint32_t)world->active.count;
    c->islands = world->scratch.solver->island_count;
}

static void begin_movers(daft_world *world, float dt)
{
    for (size_t i = 0; i < world->movers.count; i++) begin_mover(&world->bodies[world->movers.items[i]], dt);
}

/* Islands that sleep and are touched wake, with pairs of their own. */
static void wake_touched(daft_world *world)
{
    size_t active = world->active.count;
    daft_sim_wake_touched(world);
    if (world->active.count == active) return;
    daft_sim_active_update(world);
    daft_sim_active_refresh_all(world);
}

/* The milliseconds since the last call. */
static double lap(double *began)
{
    const double now = daft_clock_ms(), took = now - *began;
    *began = now;
    return took;
}

/* From bodies to all that is to be solved. Nothing has moved if it fails. */
static bool find_constraints(daft_world *world, float dt)
{
    double clock = daft_clock_ms();
    begin_movers(world, dt);
    if (!daft_sim_broad_update(world, dt)) return false; /* bodies -> bounds over the step */
    if (!daft_sim_pairs_find(world)) return false;       /* bounds -> pairs */
    world->times.broad = lap(&clock);
    if (!daft_sim_contacts_update(world, dt)) return false; /* pairs -> manifolds */
    if (!daft_sim_ghosts_drop(world, dt)) return false;
    wake_touched(world);
    if (!daft_sim_solver_create(world) || !daft_sim_solver_bodies_assign(world, dt))
        return false; /* pairs -> islands -> colours */
    world->times.contacts = lap(&clock);
    return daft_sim_report_reserve(world) && !world->lost_event;
}

/* What was added or teleported may wake what sleeps. */
static bool has_work(const daft_world *world)
{
    return world->awake.count + world->movers.count > 0 ||
           (world->moved.count > 0 && world->trees[DAFT_BODY_DYNAMIC].leaf_count > 0);
}

void daft_sim_for(const daft_world *world, bool wide, uint32_t tasks, daft_task *task, void *context)
{
    daft_region_for(wide ? world->scratch.region : NULL, tasks, task, context);
}

/* The stages of a step, on a region of workers. */
typedef struct work {
    daft_world *world;
    float dt;
    bool done;
} work;

static void run_step(void *context, daft_region *region)
{
    work *w = context;
    daft_world *world = w->world;
    world->scratch.region = region;
    bool found = find_constraints(world, w->dt);
    double clock = daft_clock_ms();
    w->done = found && daft_sim_solve(world, w->dt); /* constraints -> velocities, displacements, in substeps */
    world->times.solve = lap(&clock);
    if (w->done) {
        end_dynamics(world); /* displacements, cut short by sweeps -> poses */
        end_movers(world, w->dt);
        world->times.sweep = lap(&clock);
        world->changes++;
        count(world);
        daft_sim_report(world); /* pairs, poses -> contacts and events, */
        daft_sim_joints_break(world);
        daft_sim_sleep_update(world, w->dt); /* sleep */
        world->times.events = lap(&clock);
    }
    world->scratch.region = NULL;
}

enum { PARALLEL_BODIES = 128 /* workers come together once a step: for less, one is done before another has come */ };

static int workers_for(const daft_world *world)
{
    return world->awake.count + world->moved.count >= PARALLEL_BODIES ? world->workers : 1;
}

bool daft_world_step(daft_world *world, float dt, daft_error *error)
{
    if (!(dt >= 0 && dt <= DAFT_SIM_MAX_DT))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "step: %g s is not within 0 to %g s", (double)dt,
                         (double)DAFT_SIM_MAX_DT);
    if (dt < 1e-9f) return true;
    world->counters = (daft_sim_counters){0};
    world->times = (daft_sim_times){0};
    if (has_work(world)) {
        world->untold = false;
        work w = {.world = world, .dt = dt};
        daft_parallel_region(workers_for(world), run_step, &w);
        if (!w.done) {
            world->lost_event = false;
            return daft_fail_memory(error, "a step of the simulation");
        }
    }
    daft_sim_events_deliver(world);
    bool whole = !world->lost_event;
    world->lost_event = false;
    return whole || daft_fail_memory(error, "events");
}
