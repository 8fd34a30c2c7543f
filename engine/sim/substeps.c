/* The order of a step's work on constraints ("soft step", Catto, "Solver2D", 2024). In each substep: forces change
 * velocities, the impulses of the last substep are applied, joints and contacts are solved with springs that pull
 * errors out, bodies move, and joints and contacts are solved again without the springs, which takes out the speed
 * these gave. Bounces come last. */
#include "sim/joint/joints.h"

#include <stdatomic.h>

enum {
    BLOCK_GRAIN = 1,
    ROW_GRAIN = 64,
    ANGULAR_GRAIN = 2,
    PARALLEL_BLOCKS = 32, /* fewer are solved faster by one worker */
    CLOSE_PASSES = 3
};

typedef struct context {
    daft_world *world;
    daft_sim_solver *s;
    float dt;
    daft_sim_substep substep;
    atomic_int turning; /* the last substep in which some body turned far */
    atomic_int closing; /* the last pass, of all so far, in which some joint was closed */
} context;

static daft_sim_substep at_time(const context *c, float elapsed)
{
    daft_sim_substep out = c->substep;
    out.elapsed = elapsed;
    return out;
}

/* ---- stages ---- */

static void stage_fill(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    for (uint32_t i = first; i < first + count; i++) daft_sim_block_fill(c->world, i);
    c->s->contact_kernels->prepare(&c->s->rows, c->s->blocks + first, count);
}
static void stage_store(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    const daft_sim_substep end = at_time(c, c->dt);
    c->s->contact_kernels->finish(&c->s->rows, c->s->blocks + first, count, &end);
    for (uint32_t i = first; i < first + count; i++) daft_sim_block_store(c->world, i);
}
static void stage_gain(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    c->s->motion_kernels->gain(&c->s->rows, first, count, c->substep.h);
}
static void stage_move(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    c->s->motion_kernels->move(&c->s->rows, first, count, c->substep.h);
}
static void stage_turn(void *p, int substep, uint32_t first, uint32_t count)
{
    context *c = p;
    if (daft_sim_angular_refresh(c->world, first, count, c->dt))
        atomic_store_explicit(&c->turning, substep, memory_order_relaxed);
}
static void stage_refresh(void *p, int substep, uint32_t first, uint32_t count)
{
    context *c = p;
    if (atomic_load_explicit(&c->turning, memory_order_relaxed) == substep)
        c->s->contact_kernels->refresh(&c->s->rows, c->s->blocks + first, count);
}
static void stage_warm(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    c->s->contact_kernels->warm_start(&c->s->rows, c->s->blocks + first, count);
}
/* Bodies have moved in the substeps before this one; in this one too where springs are off. */
static void stage_solve(void *p, int moved, uint32_t first, uint32_t count)
{
    context *c = p;
    bool biased = !(moved & 1);
    const daft_sim_substep substep = at_time(c, (float)((moved + 1) >> 1) * c->substep.h);
    c->s->contact_kernels->solve(&c->s->rows, c->s->blocks + first, count, &substep, biased);
}
static void stage_bounce(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    const daft_sim_substep end = at_time(c, c->dt);
    c->s->contact_kernels->bounce(&c->s->rows, c->s->blocks + first, count, &end);
}
static void stage_joint_fill(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    for (uint32_t i = first; i < first + count; i++) daft_sim_joint_block_fill(c->world, i);
    c->s->joint_kernels->prepare(&c->s->rows, c->s->joint_blocks + first, count, &c->substep);
}
static void stage_joint_warm(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    c->s->joint_kernels->warm_start(&c->s->rows, c->s->joint_blocks + first, count, &c->substep);
}
static void stage_joint_solve(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    c->s->joint_kernels->solve(&c->s->rows, c->s->joint_blocks + first, count, &c->substep);
}
/* What one pass opens the next one closes, if it opens any. */
static void stage_joint_close(void *p, int pass, uint32_t first, uint32_t count)
{
    context *c = p;
    if (pass % CLOSE_PASSES > 0 && atomic_load_explicit(&c->closing, memory_order_relaxed) < pass - 1) return;
    if (c->s->joint_kernels->close(&c->s->rows, c->s->joint_blocks + first, count))
        atomic_store_explicit(&c->closing, pass, memory_order_relaxed);
}
static void stage_joint_relax(void *p, int last_pass, uint32_t first, uint32_t count)
{
    context *c = p;
    bool moved = atomic_load_explicit(&c->closing, memory_order_relaxed) > last_pass - CLOSE_PASSES;
    bool turned = atomic_load_explicit(&c->turning, memory_order_relaxed) == last_pass / CLOSE_PASSES;
    c->s->joint_kernels->relax(&c->s->rows, c->s->joint_blocks + first, count, &c->substep, moved, turned);
}
static void stage_joint_store(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    for (uint32_t i = first; i < first + count; i++) daft_sim_joint_block_store(c->world, i, c->dt);
}
enum { ANGULAR_BEFORE, ANGULAR_BETWEEN, ANGULAR_AFTER };
static void stage_angular(void *p, int when, uint32_t first, uint32_t count)
{
    context *c = p;
    daft_sim_angular *spins = c->s->angular + first;
    if (when == ANGULAR_BEFORE) c->s->angular_kernels->before(&c->s->rows, spins, count, c->substep.h);
    if (when == ANGULAR_BETWEEN) c->s->angular_kernels->between(&c->s->rows, spins, count, c->substep.h, c->dt);
    if (when == ANGULAR_AFTER) c->s->angular_kernels->after(&c->s->rows, spins, count);
}
/* What must not move along an axis was pushed by constraints as if it might: that is taken back. */
static void stage_locks(void *p, int argument, uint32_t first, uint32_t count)
{
    (void)argument;
    context *c = p;
    for (uint32_t row = first; row < first + count; row++) {
        uint32_t locks = c->world->bodies[c->s->row_bodies[row]].locks / DAFT_LOCK_POSITION_X;
        size_t at = (size_t)row * DAFT_SIM_ROW;
        const daft_sim_solver_bodies *rows = &c->s->rows;
        for (size_t k = 0; k < 3; k++)
            if (locks >> k & 1) rows->velocity[at + k] = rows->moved[at + k] = rows->turn[at + 4 + k] = 0;
    }
}

/* ---- the list ---- */

typedef void stage_run(void *context, int argument, uint32_t first, uint32_t count);

static void add(daft_sim_solver *s, stage_run *run, int argument, uint32_t first, uint32_t count, uint32_t grain)
{
    if (count > 0) s->stages[s->stage_count++] = (daft_stage){run, argument, first, count, grain};
}
static void add_contacts(daft_sim_solver *s, stage_run *run, int argument)
{
    for (uint32_t i = 0; i < s->colour_count; i++)
        add(s, run, argument, s->colours[i].first, s->colours[i].count, BLOCK_GRAIN);
}
static void add_stiff(daft_sim_solver *s, stage_run *run, int argument)
{
    for (uint32_t i = 0; i < s->colour_count; i++) {
        const daft_sim_colour *c = &s->colours[i];
        add(s, run, argument, c->first + c->count - c->stiff, c->stiff, BLOCK_GRAIN);
    }
}
static void add_joints(daft_sim_solver *s, stage_run *run, int argument)
{
    for (uint32_t i = 0; i < s->joint_colour_count; i++)
        add(s, run, argument, s->joint_colours[i].first, s->joint_colours[i].count, BLOCK_GRAIN);
}

static void add_locks(daft_sim_solver *s)
{
    if (s->locks) add(s, stage_locks, 0, s->row_first, s->row_end - s->row_first, ROW_GRAIN);
}

static void add_substep(daft_sim_solver *s, int substep)
{
    uint32_t dynamic = s->row_first, rows = s->row_end - dynamic;
    add(s, stage_gain, 0, dynamic, rows, ROW_GRAIN);
    add(s, stage_angular, ANGULAR_BEFORE, 0, s->angular_count, ANGULAR_GRAIN);
    add_joints(s, stage_joint_warm, 0);
    add_contacts(s, stage_warm, 0);
    add_joints(s, stage_joint_solve, 0);
    add_joints(s, stage_joint_solve, 0); /* long chains need it, and it costs little beside contacts */
    add_contacts(s, stage_solve, 2 * (substep - 1));
    for (int pass = 1; s->stiff && pass < DAFT_SIM_STIFF_PASSES; pass++) add_stiff(s, stage_solve, 2 * (substep - 1));
    add_locks(s);
    add(s, stage_angular, ANGULAR_BETWEEN, 0, s->angular_count, ANGULAR_GRAIN);
    add(s, stage_move, 0, 1, s->mover_count, ROW_GRAIN);
    add(s, stage_move, 0, dynamic, rows, ROW_GRAIN);
    add(s, stage_angular, ANGULAR_AFTER, 0, s->angular_count, ANGULAR_GRAIN);
    for (int pass = 0; pass < CLOSE_PASSES; pass++) add_joints(s, stage_joint_close, CLOSE_PASSES * substep + pass);
    add_locks(s);
    add(s, stage_turn, substep, dynamic, rows, ROW_GRAIN);
    add(s, stage_refresh, substep, 0, s->block_count, BLOCK_GRAIN);
    add_joints(s, stage_joint_relax, CLOSE_PASSES * substep + CLOSE_PASSES - 1);
    add_contacts(s, stage_solve, 2 * substep - 1);
    add_locks(s);
}

static size_t most_stages(const daft_sim_solver *s)
{
    size_t substep =
        14 + (2 + DAFT_SIM_STIFF_PASSES) * (size_t)s->colour_count + (4 + CLOSE_PASSES) * (size_t)s->joint_colour_count;
    return 9 + (size_t)s->substeps * substep + s->colour_count;
}

/* ---- rows ---- */

static void put(float *row, daft_vec3 a, daft_vec3 b)
{
    row[0] = a.x, row[1] = a.y, row[2] = a.z, row[3] = b.x, row[4] = b.y, row[5] = b.z, row[6] = row[7] = 0;
}

static daft_vec3 apply_inertia(const float m[6], daft_vec3 v)
{
    return daft_v3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[1] * v.x + m[3] * v.y + m[4] * v.z,
                   m[2] * v.x + m[4] * v.y + m[5] * v.z);
}

/* A body in free flight moves by the mean of its velocities under gravity, which is exact; a force that the game gives
 * acts on it at once, so that one that depends on where the body is, like an orbit's, is integrated by the symplectic
 * Euler method, whose energy does not drift. A body that something holds gets all of it evenly over the substeps. */
static void fill_row(const daft_world *world, uint32_t row, float dt)
{
    const daft_sim_solver_bodies *rows = &world->scratch.solver->rows;
    daft_sim_body *body = &world->bodies[world->scratch.solver->row_bodies[row]];
    size_t at = (size_t)row * DAFT_SIM_ROW;
    float *velocity = rows->velocity + at, *gain = rows->gain + at, *mass = rows->mass + at, *turn = rows->turn + at;
    daft_vec3 zero = daft_v3(0, 0, 0), linear = body->linear, angular = body->angular, push = zero, twist = zero;
    float h = world->scratch.solver->h;
    bool dynamic = body->kind == DAFT_BODY_DYNAMIC, constrained = world->scratch.solver->constrained[row];
    body->state = row;
    put(rows->moved + at, zero, zero);
    rows->moved[at + 6] = h;
    put(turn, zero, zero);
    turn[3] = 1, turn[7] = constrained && !body->round;
    mass[0] = (body->locks & DAFT_LOCK_POSITION) == DAFT_LOCK_POSITION ? 0 : body->inv_mass;
    daft_sim_body_inverse_inertia(body, &body->frame, mass + 1);
    if (dynamic) {
        push = daft_sim_clamp(daft_scale(body->force, body->inv_mass), DAFT_SIM_MAX_ACCELERATION);
        twist = daft_sim_clamp(apply_inertia(mass + 1, body->torque), DAFT_SIM_MAX_ACCELERATION);
        if (!constrained) {
            linear = daft_sim_clamp(daft_add(linear, daft_scale(push, dt)), DAFT_SIM_MAX_SPEED);
            angular = daft_sim_clamp(daft_add(angular, daft_scale(twist, dt)), DAFT_SIM_MAX_ANGULAR_SPEED);
            push = twist = zero;
        }
        push = daft_add(push, daft_scale(world->gravity, body->gravity_scale));
        push = daft_sim_unlocked(body, push, DAFT_LOCK_POSITION_X),
        linear = daft_sim_unlocked(body, linear, DAFT_LOCK_POSITION_X);
    }
    put(velocity, linear, angular);
    velocity[6] = DAFT_SIM_MAX_SPEED, velocity[7] = DAFT_SIM_MAX_ANGULAR_SPEED;
    const daft_sim_depenetration *most = &world->scratch.solver->depenetration[row];
    if (dynamic && most->speed > 0) {
        /* Falling stays free. */
        velocity[6] = daft_sim_max(most->speed, daft_length(daft_add(linear, daft_scale(push, dt))));
        velocity[7] = most->swing / daft_sim_max(body->extent, 1e-6f);
    }
    put(gain, push, twist);
    gain[6] = dynamic && !constrained ? 1 : 0;
    gain[7] = 1 / (1 + h * body->linear_damping);
    mass[7] = 1 / (1 + h * body->angular_damping);
}

enum { FILL_GRAIN = 64, PARALLEL_ROWS = 256, MARK_ANGULAR = 1, MARK_LOCKED = 2, MARK_OTHER = 4 };

typedef struct fill_job {
    daft_world *world;
    float dt;
} fill_job;

static void fill_range(void *p, uint32_t index, uint32_t worker)
{
    (void)worker;
    const fill_job *j = p;
    daft_sim_solver *s = j->world->scratch.solver;
    uint32_t first = s->row_first + index * FILL_GRAIN, end = daft_min_u(first + FILL_GRAIN, s->row_end);
    for (uint32_t row = first; row < end; row++) {
        fill_row(j->world, row, j->dt);
        const daft_sim_body *body = &j->world->bodies[s->row_bodies[row]];
        bool held = body->locks & DAFT_LOCK_POSITION, other = body->h > 0 && body->h != s->h;
        s->marks[row] = (uint8_t)((daft_sim_integrates_angular(j->world, row) ? MARK_ANGULAR : 0) |
                                  (held ? MARK_LOCKED : 0) | (other ? MARK_OTHER : 0));
    }
}

static void fill_rows(daft_world *world, float dt)
{
    const daft_sim_solver_bodies *rows = &world->scratch.solver->rows;
    float *zero[] = {rows->velocity, rows->moved, rows->gain, rows->turn, rows->mass};
    for (size_t i = 0; i < DAFT_COUNT_OF(zero); i++)
        for (int k = 0; k < DAFT_SIM_ROW; k++) zero[i][k] = 0;
    rows->turn[3] = 1;
    daft_sim_solver *s = world->scratch.solver;
    uint32_t count = s->row_end - s->row_first;
    s->angular_count = 0;
    s->locks = false, s->steady = true;
    for (uint32_t row = 1; row <= s->mover_count; row++) fill_row(world, row, dt);
    fill_job j = {world, dt};
    daft_sim_for(world, count >= PARALLEL_ROWS, (count + FILL_GRAIN - 1) / FILL_GRAIN, fill_range, &j);
    for (uint32_t row = s->row_first; row < s->row_end; row++) {
        if (s->marks[row] & MARK_ANGULAR) daft_sim_angular_add(world, row);
        s->locks |= (s->marks[row] & MARK_LOCKED) != 0;
        s->steady &= !(s->marks[row] & MARK_OTHER);
    }
}

/* The islands of one substep rate are the ones to be solved now: their rows, and colours for their joints. */
static bool begin_rate(daft_world *world, uint32_t rate, float dt)
{
    uint32_t most[DAFT_SIM_CLASSES] = {0, 0};
    daft_sim_solver *s = world->scratch.solver;
    s->row_first = rate ? s->rate_end[rate - 1] : 1 + s->mover_count;
    s->row_end = s->rate_end[rate];
    s->substeps = world->substeps << rate;
    s->h = dt / (float)s->substeps;
    for (uint32_t row = s->row_first; world->live_joints > 0 && row < s->row_end; row++)
        daft_sim_colours_clear(s, daft_sim_colour_place(s->row_bodies[row]));
    return daft_sim_joints_colour(world, most) && daft_sim_joints_place(world, most);
}

/* The islands of one substep rate. */
static void solve_rate(daft_world *world, float dt)
{
    daft_sim_solver *s = world->scratch.solver;
    context c = {.world = world, .s = s, .dt = dt};
    c.substep = (daft_sim_substep){.h = s->h, .inv_h = (float)s->substeps / dt, .push_speed = DAFT_SIM_PUSH_SPEED};
    s->stage_count = 0;
    add(s, stage_fill, 0, 0, s->block_count, BLOCK_GRAIN);
    add(s, stage_joint_fill, 0, 0, s->joint_block_count, BLOCK_GRAIN);
    for (int i = 1; i <= s->substeps; i++) add_substep(s, i);
    add_contacts(s, stage_bounce, 0);
    add_locks(s);
    add(s, stage_store, 0, 0, s->block_count, BLOCK_GRAIN);
    add(s, stage_joint_store, 0, 0, s->joint_block_count, BLOCK_GRAIN);
    bool large = s->block_count + s->joint_block_count >= PARALLEL_BLOCKS;
    daft_region_stages(large ? world->scratch.region : NULL, s->stages, s->stage_count, &c);
}

static void count(daft_world *world)
{
    const daft_sim_solver *s = world->scratch.solver;
    daft_sim_counters *c = &world->counters;
    c->rows += 6 * s->joint_count;
    c->colours += s->colour_count + s->joint_colour_count;
    if (s->block_count + s->joint_count > 0 && (uint32_t)s->substeps > c->substeps) c->substeps = (uint32_t)s->substeps;
}

bool daft_sim_solve(daft_world *world, float dt)
{
    daft_sim_solver *s = world->scratch.solver;
    world->counters.rows = s->contact_rows;
    for (uint32_t rate = 0; rate < DAFT_SIM_RATES; rate++) {
        if (rate > 0 && s->rate_end[rate] == s->rate_end[rate - 1]) continue;
        if (!begin_rate(world, rate, dt) || !daft_sim_contacts_place(world) ||
            !daft_grow(&world->allocator, &s->stages, &s->stage_capacity, most_stages(s), 0, sizeof *s->stages))
            return false;
        fill_rows(world, dt);
        solve_rate(world, dt);
        count(world);
    }
    return true;
}

/* ---- scratch ---- */

bool daft_sim_solver_create(daft_world *world)
{
    static const daft_sim_contact_kernels *const CONTACTS[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_sim_contact);
    static const daft_sim_motion_kernels *const MOTION[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_sim_motion);
    static const daft_sim_joint_kernels *const JOINTS[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_sim_joint);
    static const daft_sim_angular_kernels *const SPINS[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_sim_angular);
    if (!world->scratch.solver) {
        world->scratch.solver = daft_alloc_zero(&world->allocator, 1, sizeof *world->scratch.solver);
        if (!world->scratch.solver) return false;
    }
    world->scratch.solver->contact_kernels = CONTACTS[world->isa];
    world->scratch.solver->motion_kernels = MOTION[world->isa];
    world->scratch.solver->joint_kernels = JOINTS[world->isa];
    world->scratch.solver->angular_kernels = SPINS[world->isa];
    return true;
}

void daft_sim_solver_destroy(daft_world *world)
{
    daft_sim_solver *s = world->scratch.solver;
    if (!s) return;
    void *arrays[] = {s->rows.velocity, s->rows.moved,    s->rows.gain,     s->rows.turn, s->rows.mass,
                      s->row_bodies,    s->blocks,        s->colours,       s->slots,     s->joint_blocks,
                      s->joint_slots,   s->joint_bins,    s->joint_colours, s->masks,     s->levels,
                      s->constraints,   s->contacts,      s->colour_counts, s->angular,   s->targets,
                      s->constrained,   s->row_of,        s->island_of,     s->asked,     s->islands,
                      s->marks,         s->depenetration, s->stages};
    for (size_t i = 0; i < DAFT_COUNT_OF(arrays); i++) daft_release(&world->allocator, arrays[i]);
    daft_release(&world->allocator, s);
    world->scratch.solver = NULL;
}
