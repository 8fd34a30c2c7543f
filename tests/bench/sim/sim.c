/* The group sim: milliseconds a step beside ODE on the same scenes, how deep bodies overlap and how far joints open in
 * the same steps, how far a stack drifts, and what idle worlds cost. */
#include "sim_scenes.h"

#include "math/trig.h"

#include <stdio.h>
#include <string.h>

/* ---- a run of one scene by one engine ---- */

typedef struct side {
    const sim_engine *engine;
    int threads;
    double ms; /* a step */
    sim_faults faults;
    void *kept; /* a world that was settled already */
} side;

typedef struct job {
    bench *self;
    const sim_scene *scene;
    side sides[2]; /* ours, and what it is beside */
    int settle, steps, looks, clock_threads;
} job;

static bool run_steps(const side *s, void *world, int steps)
{
    for (int i = 0; i < steps; i++)
        if (!s->engine->step(world)) return false;
    return true;
}

/* Steps, timed in `looks` parts. Between the parts, outside the time, poses are measured. */
static bool timed_steps(job *j, side *s, void *world)
{
    double ms = 0;
    int parts = j->looks ? j->looks : 1;
    s->faults = (sim_faults){0};
    for (int part = 0; part < parts; part++) {
        double start = bench_clock_ms(j->clock_threads);
        if (!run_steps(s, world, j->steps / parts)) return false;
        ms += bench_clock_ms(j->clock_threads) - start;
        if (j->looks && !bench_sim_look(j->self, j->scene, s->engine, world, &s->faults)) return false;
    }
    s->ms = ms / (j->steps / parts * parts);
    return true;
}

static double sample(job *j, side *s)
{
    void *world = s->kept ? s->kept : s->engine->create(j->self, j->scene, s->threads);
    if (!world) return -1;
    bool good = s->kept || run_steps(s, world, j->settle);
    good = good && timed_steps(j, s, world);
    s->kept = j->settle ? world : NULL;
    if (!s->kept) s->engine->destroy(world);
    return good ? s->ms : -1;
}

static double sample_ours(void *context) { return sample(context, &((job *)context)->sides[0]); }
static double sample_peer(void *context) { return sample(context, &((job *)context)->sides[1]); }

/* Two of ours, step by step in turns, so that changes of the processor's clock and of the distance between virtual
 * processors meet both. */
static double sample_in_turns(void *context)
{
    job *j = context;
    void *worlds[2];
    double ms[2] = {0, 0};
    bool good = true;
    for (int s = 0; s < 2; s++) {
        worlds[s] = j->sides[s].engine->create(j->self, j->scene, j->sides[s].threads);
        good = good && worlds[s];
    }
    for (int i = 0; good && i < 2 * j->steps; i++) {
        double start = bench_clock_ms(j->clock_threads);
        good = j->sides[i % 2].engine->step(worlds[i % 2]);
        ms[i % 2] += bench_clock_ms(j->clock_threads) - start;
    }
    for (int s = 0; s < 2; s++) {
        if (worlds[s]) j->sides[s].engine->destroy(worlds[s]);
        j->sides[s].ms = ms[s] / j->steps;
    }
    return good ? j->sides[0].ms : -1;
}
static double sample_other(void *context)
{
    return ((const job *)context)->sides[1].ms;
} /* taken with the first one's */

static job make_job(bench *self, const sim_scene *scene, int steps, int looks)
{
    job j = {.self = self, .scene = scene, .steps = steps, .looks = looks, .clock_threads = 1};
    j.sides[0] = (side){.engine = bench_sim_ours(), .threads = 1};
    j.sides[1] = (side){.engine = bench_find_ode(), .threads = 1};
    return j;
}

static void describe(void *context, char *out, size_t size)
{
    const job *j = context;
    snprintf(out, size, "%u bodies, %u joints, mean of %d steps", j->scene->body_count, j->scene->joint_count,
             j->steps);
}

static bench_subject subject_of(job *j, const char *scene, const char *what, bench_budget budget)
{
    return (bench_subject){.scene = scene,
                           .what = what,
                           .unit = "ms",
                           .isa = j->self->isa,
                           .threads = 1,
                           .ours = sample_ours,
                           .peer = j->sides[1].engine ? sample_peer : NULL,
                           .context = j,
                           .peer_name = "ODE QuickStep",
                           .describe = describe,
                           .budget = budget};
}

/* ---- rows of faults ---- */

static double mean_depth(const sim_faults *f) { return f->points ? f->depth_sum / (double)f->points : 0; }

static void add_fault_row(const job *j, const char *scene, const char *what, double ours, double peer,
                          const char *counters, bench_budget budget)
{
    bool peers = j->self->peers;
    bench_row row = {.unit = "mm", .isa = j->self->isa, .threads = 1, .ours = ours * 1e3, .peer = -1, .budget = budget};
    snprintf(row.scene, sizeof row.scene, "%s", scene);
    snprintf(row.what, sizeof row.what, "%s", what);
    snprintf(row.counters, sizeof row.counters, "%s", counters);
    row.peer_name = peers ? "ODE QuickStep" : NULL;
    if (peers && j->sides[1].engine) row.peer = peer * 1e3;
    bench_add(j->self, &row);
}

/* Rows of time, then of faults in the same steps: overlap must not exceed the peer's, on average and at worst. */
static void with_faults(bench *self, job *j, const char *scene, const char *what, bench_budget budget)
{
    bench_subject subject = subject_of(j, scene, what, budget);
    if (!bench_measure(self, &subject)) return;
    const sim_faults *ours = &j->sides[0].faults, *peer = &j->sides[1].faults;
    const bench_budget no_worse = {1, 0, false};
    char counters[128], name[64];
    snprintf(counters, sizeof counters, "%llu points overlap%s", (unsigned long long)ours->points,
             j->scene->joint_count ? "; of bodies that no joint connects" : "");
    snprintf(name, sizeof name, "%s, overlap, mean", what);
    add_fault_row(j, scene, name, mean_depth(ours), mean_depth(peer), counters, no_worse);
    snprintf(name, sizeof name, "%s, overlap, most", what);
    add_fault_row(j, scene, name, ours->deepest, peer->deepest, "", no_worse);
    snprintf(name, sizeof name, "%s, joints apart, most", what);
    if (j->scene->joint_count) add_fault_row(j, scene, name, ours->widest, peer->widest, "", no_worse);
}

/* ---- piles ---- */

static void thousand_boxes(bench *self)
{
    const char *scene = "sim, 1,000 boxes", *what = "falling into a pile";
    sim_scene boxes;
    if (!bench_wants(self, scene, what)) return;
    if (bench_sim_heap(self, 10, 10, 10, &boxes)) {
        job j = make_job(self, &boxes, 300, 5);
        with_faults(self, &j, scene, what, (bench_budget){3.5, 0, false});
    }
    bench_sim_scene_free(self, &boxes);
}

static void five_thousand_boxes(bench *self)
{
    const char *scene = "sim, 5,000 boxes", *what = "falling into a pile", *both = "two threads to one";
    bool alone = bench_wants(self, scene, what), threads = bench_wants(self, scene, both);
    sim_scene boxes;
    if (!alone && !threads) return;
    if (bench_sim_heap(self, 25, 20, 10, &boxes)) {
        job j = make_job(self, &boxes, 150, 2);
        if (alone) with_faults(self, &j, scene, what, (bench_budget){3.5, 0, false});
        j.looks = 0, j.clock_threads = 2;
        j.sides[0].threads = 2;
        j.sides[1] = (side){.engine = bench_sim_ours(), .threads = 1};
        bench_subject subject = subject_of(&j, scene, both, (bench_budget){1.5, 0, false});
        subject.threads = 2, subject.ours = sample_in_turns, subject.peer = sample_other;
        subject.peer_name = "one thread", subject.own_peer = true;
        if (threads) bench_measure(self, &subject);
    }
    bench_sim_scene_free(self, &boxes);
}

static void ragdolls(bench *self)
{
    const char *scene = "sim, 200 ragdolls", *what = "falling into a pile";
    sim_scene dolls;
    if (!bench_wants(self, scene, what)) return;
    if (bench_sim_ragdolls(self, 200, &dolls)) {
        job j = make_job(self, &dolls, 180, 3);
        with_faults(self, &j, scene, what, (bench_budget){3.5, 0, false});
    }
    bench_sim_scene_free(self, &dolls);
}

static void sleepers(bench *self)
{
    const char *scene = "sim, 10,000 asleep", *what = "and one awake";
    sim_scene boxes;
    if (!bench_wants(self, scene, what)) return;
    if (bench_sim_sleepers(self, 10000, &boxes)) {
        job j = make_job(self, &boxes, 300, 0);
        j.settle = 120;
        bench_subject subject = subject_of(&j, scene, what, (bench_budget){0.05, 0, true});
        bench_measure(self, &subject);
        for (int s = 0; s < 2; s++)
            if (j.sides[s].kept) j.sides[s].engine->destroy(j.sides[s].kept);
    }
    bench_sim_scene_free(self, &boxes);
}

/* ---- stacks ---- */

/* The maximum sideways distance of the top box over a minute, or its whole distance once it fell; and how far it sank.
 * False on failure. */
static bool watch_top(bench *self, const sim_scene *stack, const sim_engine *engine, double *drift, double *sunk)
{
    uint32_t top = stack->body_count - 1;
    void *world = engine->create(self, stack, 1);
    bool good = world != NULL;
    *drift = *sunk = 0;
    for (int i = 0; i < 60 * BENCH_SIM_HZ && good; i++) {
        good = engine->step(world);
        daft_dvec3 off = daft_dsub(engine->pose(world, top).p, stack->bodies[top].position);
        *sunk = fmax(*sunk, -off.y);
        if (*sunk < 1) off.y = 0;
        *drift = fmax(*drift, sqrt(daft_ddot(off, off)));
    }
    if (world) engine->destroy(world);
    return good;
}

static void one_stack(bench *self, uint32_t boxes, bool sleeping, bench_budget budget)
{
    const char *what = sleeping ? "the top's drift in a minute" : "the top's drift in a minute, sleep off";
    char scene[48], counters[128];
    double ours, peer = 0, sunk, peer_sunk = 0;
    sim_scene stack;
    snprintf(scene, sizeof scene, "sim, stack of %u", boxes);
    if (!bench_wants(self, scene, what)) return;
    bool good = bench_sim_stack(self, boxes, &stack);
    job j = make_job(self, &stack, 0, 0);
    stack.sleeping = sleeping;
    good = good && watch_top(self, &stack, j.sides[0].engine, &ours, &sunk);
    if (good && self->peers && j.sides[1].engine) good = watch_top(self, &stack, j.sides[1].engine, &peer, &peer_sunk);
    if (good) {
        snprintf(counters, sizeof counters, "it sank %.1f mm%s", sunk * 1e3, sunk > 1 ? ": it fell" : "");
        if (self->peers && j.sides[1].engine)
            snprintf(counters + strlen(counters), sizeof counters - strlen(counters), "; the peer's %.1f mm%s",
                     peer_sunk * 1e3, peer_sunk > 1 ? ": it fell" : "");
        add_fault_row(&j, scene, what, ours, peer, counters, budget);
    } else {
        bench_note(self, true, "%s failed", scene);
    }
    bench_sim_scene_free(self, &stack);
}

/* ---- nothing to do ---- */

typedef struct idle {
    bench *self;
    daft_world *world;
} idle;

static double idle_ms(void *context)
{
    enum { STEPS = 1000 };
    const idle *self = context;
    double start = bench_clock_ms(1);
    for (int i = 0; i < STEPS; i++)
        if (!daft_world_step(self->world, 1.0f / BENCH_SIM_HZ, NULL)) return -1;
    return (bench_clock_ms(1) - start) / STEPS;
}

static void idle_describe(void *context, char *out, size_t size)
{
    const idle *self = context;
    daft_sim_counters c = daft_world_counters(self->world);
    snprintf(out, size, "%u bodies, %u awake, %u pairs, %u contacts, %u rows, %u substeps, %u sweeps", c.bodies,
             c.awake, c.pairs, c.contacts, c.rows, c.substeps, c.sweeps);
}

static bool add_boxes(daft_world *world, daft_body_kind kind, int count, double y)
{
    daft_sim_shape_def shape = daft_default_sim_shape_def();
    daft_shape_box(daft_v3(0.6f, 0.5f, 0.6f), &shape.shape, NULL);
    daft_sim_body_def def = daft_default_sim_body_def();
    def.kind = kind, def.shapes = &shape, def.shape_count = 1;
    bool good = true;
    for (int i = 0; good && i < count; i++) {
        def.position = daft_dv3(i % 32, y, i / 32);
        good = daft_world_add(world, &def, NULL) != 0;
    }
    return good;
}

static void nothing_to_do(bench *self, const char *what, int statics, int kinematics)
{
    if (!bench_wants(self, "sim, nothing moves", what)) return;
    idle empty = {self, daft_world_create(&self->allocator, NULL)};
    bool good = empty.world && add_boxes(empty.world, DAFT_BODY_STATIC, statics, 0) &&
                add_boxes(empty.world, DAFT_BODY_KINEMATIC, kinematics, 1.5) &&
                daft_world_step(empty.world, 1.0f / BENCH_SIM_HZ, NULL);
    bench_subject subject = {.scene = "sim, nothing moves",
                             .what = what,
                             .unit = "ms",
                             .isa = self->isa,
                             .threads = 1,
                             .ours = idle_ms,
                             .context = &empty,
                             .describe = idle_describe,
                             .budget = {0.001, 0, true}};
    if (good)
        bench_measure(self, &subject);
    else
        bench_note(self, true, "sim, nothing moves %s failed", what);
    if (empty.world) daft_world_destroy(empty.world);
}

void bench_sim(bench *self)
{
    thousand_boxes(self);
    five_thousand_boxes(self);
    ragdolls(self);
    sleepers(self);
    one_stack(self, 20, true, (bench_budget){2, 0, true});
    one_stack(self, 50, true, (bench_budget){20, 0, true});
    one_stack(self, 20, false, (bench_budget){2, 0, true});
    one_stack(self, 50, false, (bench_budget){20, 0, true});
    nothing_to_do(self, "an empty world", 0, 0);
    nothing_to_do(self, "10,000 static bodies", 10000, 0);
    nothing_to_do(self, "1,000 kinematic bodies over 1,000 static", 1000, 1000);
}
