/* Simulating the same second with many settings. */
#include "accuracy/sim.h"

#include "common/progress.h"
#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Part of the time until when more rounds may begin. */
static const double TIME_SHARE = 0.9;
enum { LEAST_ROUNDS = 3, TICK_HZ = 60 };

static const struct {
    int substeps, rate;
} SETTINGS[SIM_SETTINGS] = {{1, 60},  {2, 60},  {4, 60},  {8, 60},  {16, 60}, {1, 120},
                            {2, 120}, {4, 120}, {1, 240}, {2, 240}, {4, 240}};

/* What a second looked like, tick by tick. */
typedef struct sim_trace {
    daft_dvec3 *positions; /* bodies a tick */
    double energy[SIM_TICKS];
    double penetration, joint_gap;
} sim_trace;

typedef struct sim_work {
    sim_result *result;
    int moment;
    daft_entity *bodies;
    uint32_t count;
    void *state; /* of all bodies as the moment begins */
    size_t size;
    sim_trace reference, now;
    uint64_t began_ns;
    progress_bar bar;
} sim_work;

static double used(const sim_work *w) { return (double)(clock_now_ns() - w->began_ns) / 1e9 / w->result->def.seconds; }

/* ---- a second ---------------------------------------------------------------------------------------------------- */

static bool note_tick(const sim_work *w, int tick, sim_trace *out, daft_error *error)
{
    daft_sim_measure m;
    for (uint32_t i = 0; i < w->count; i++) {
        daft_transform at;
        if (!daft_entity_get_world_transform(w->result->def.scene, w->bodies[i], &at, error)) return false;
        out->positions[(size_t)tick * w->count + i] = at.position;
    }
    if (!daft_scene_measure_sim(w->result->def.scene, &m, error)) return false;
    out->energy[tick] = m.energy;
    out->penetration = fmax(out->penetration, m.penetration), out->joint_gap = fmax(out->joint_gap, m.joint_gap);
    return true;
}

/* From the moment on; `out` NULL: for the time alone, in milliseconds a tick. */
static bool simulate(const sim_work *w, int substeps, int rate, sim_trace *out, double *ms, daft_error *error)
{
    daft_scene *scene = w->result->def.scene;
    uint64_t spent = 0;
    if (!daft_scene_load_bodies(scene, w->state, w->size, error) || !daft_scene_set_substeps(scene, substeps, error))
        return false;
    if (out) out->penetration = out->joint_gap = 0;
    for (int tick = 0; tick < SIM_TICKS; tick++) {
        const uint64_t began = clock_now_ns();
        for (int i = 0; i < rate / TICK_HZ; i++)
            if (!daft_scene_step(scene, 1.0f / (float)rate, error)) return false;
        spent += clock_now_ns() - began;
        if (out && !note_tick(w, tick, out, error)) return false;
    }
    *ms = (double)spent / 1e6 / SIM_TICKS;
    return true;
}

static double distance_of(const sim_work *w, const sim_trace *a, const sim_trace *b)
{
    double sum = 0;
    const size_t all = (size_t)SIM_TICKS * w->count;
    for (size_t i = 0; i < all; i++) {
        const double x = a->positions[i].x - b->positions[i].x, y = a->positions[i].y - b->positions[i].y,
                     z = a->positions[i].z - b->positions[i].z;
        sum += x * x + y * y + z * z;
    }
    return sqrt(sum / (double)all);
}

/* ---- a moment ---------------------------------------------------------------------------------------------------- */

static bool make_reference(sim_work *w, daft_error *error)
{
    sim_result *r = w->result;
    double ms;
    if (!simulate(w, 1, SIM_REFERENCE_HZ, &w->reference, &ms, error)) return false;
    r->reference_ms += ms;
    if (!simulate(w, 1, SIM_REFERENCE_HZ / 2, &w->now, &ms, error)) return false;
    r->floor += distance_of(w, &w->reference, &w->now);
    return true;
}

static bool compare_all(sim_work *w, daft_error *error)
{
    for (int k = 0; k < SIM_SETTINGS; k++) {
        sim_setting *s = &w->result->settings[k];
        double ms, energy = 0;
        if (!simulate(w, s->substeps, s->rate, &w->now, &ms, error)) return false;
        for (int i = 0; i < SIM_TICKS; i++) energy += fabs(w->now.energy[i] - w->reference.energy[i]) / SIM_TICKS;
        s->position += distance_of(w, &w->now, &w->reference), s->energy += energy;
        s->penetration = fmax(s->penetration, w->now.penetration);
        s->joint_gap = fmax(s->joint_gap, w->now.joint_gap);
        progress_show(&w->bar, fmin(used(w), 1));
    }
    return true;
}

static bool time_all(sim_work *w, daft_error *error)
{
    const double until = TIME_SHARE * (w->moment + 1) / w->result->def.moments;
    for (int round = 0; round < SIM_ROUNDS && (round < LEAST_ROUNDS || used(w) < until); round++) {
        for (int k = 0; k < SIM_SETTINGS; k++) {
            sim_setting *s = &w->result->settings[k];
            if (!simulate(w, s->substeps, s->rate, NULL, &s->times[w->result->moments][s->rounds[w->result->moments]++],
                          error))
                return false;
        }
        progress_show(&w->bar, fmin(used(w), 1));
    }
    return true;
}

static bool begin_moment(sim_work *w, daft_error *error)
{
    daft_scene *scene = w->result->def.scene;
    const size_t positions = (size_t)SIM_TICKS * w->count;
    w->size = daft_scene_save_bodies(scene, NULL, 0, error);
    if (!w->size) return false;
    w->state = malloc(w->size), w->bodies = malloc(w->count * sizeof *w->bodies);
    w->reference.positions = malloc(positions * sizeof(daft_dvec3));
    w->now.positions = malloc(positions * sizeof(daft_dvec3));
    if (!w->state || !w->bodies || !w->reference.positions || !w->now.positions)
        return fail(error, DAFT_ERROR_MEMORY, "out of memory for the simulation");
    daft_scene_moving(scene, w->bodies, w->count);
    return daft_scene_save_bodies(scene, w->state, w->size, error) == w->size;
}

static void end_moment(sim_work *w)
{
    free(w->state);
    free(w->bodies);
    free(w->reference.positions);
    free(w->now.positions);
    w->state = NULL, w->bodies = NULL, w->reference.positions = w->now.positions = NULL;
}

/* Substeps are part of the saved state: loading brings the game's own back. */
static bool measure_moment(sim_work *w, daft_error *error)
{
    sim_result *r = w->result;
    w->count = daft_scene_moving(r->def.scene, NULL, 0);
    if (w->count == 0) return true;
    if (w->count > r->bodies) r->bodies = w->count;
    const bool good = begin_moment(w, error) && make_reference(w, error) && compare_all(w, error) &&
                      time_all(w, error) && daft_scene_load_bodies(r->def.scene, w->state, w->size, error);
    end_moment(w);
    r->moments++;
    return good;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static int compare_times(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void summarise(sim_result *r)
{
    r->floor /= r->moments, r->reference_ms /= r->moments;
    for (int k = 0; k < SIM_SETTINGS; k++) {
        sim_setting *s = &r->settings[k];
        s->position /= r->moments, s->energy /= r->moments;
        for (int m = 0; m < r->moments; m++) {
            const int n = s->rounds[m];
            double *t = s->times[m];
            qsort(t, (size_t)n, sizeof *t, compare_times);
            s->ms += (t[(n - 1) / 2] + t[n / 2]) / 2 / r->moments;
            s->spread += (n < 4 ? t[n - 1] - t[0] : t[n * 3 / 4] - t[n / 4]) / 2 / r->moments;
        }
    }
}

/* Errors that differ by less than the reference's own are equal. */
static bool beats(const sim_result *r, const sim_setting *a, const sim_setting *b)
{
    const bool equal = fabs(a->ms - b->ms) <= a->spread + b->spread, faster = a->ms < b->ms && !equal;
    const bool closer = a->position < b->position - r->floor, farther = b->position < a->position - r->floor;
    return (faster && !farther) || (equal && closer);
}

static void judge(sim_result *r)
{
    for (int k = 0; k < SIM_SETTINGS; k++) {
        r->settings[k].beaten_by = -1;
        for (int i = 0; i < SIM_SETTINGS && r->settings[k].beaten_by < 0; i++)
            if (i != k && beats(r, &r->settings[i], &r->settings[k])) r->settings[k].beaten_by = i;
    }
}

static bool run(sim_work *w, daft_error *error)
{
    sim_result *r = w->result;
    for (w->moment = 0; w->moment < r->def.moments; w->moment++)
        if (!r->def.next(r->def.user, error) || !measure_moment(w, error)) return false;
    if (r->moments == 0)
        return fail(error, DAFT_ERROR_ARGUMENT, "no body moves at any of these moments: there is nothing to simulate");
    summarise(r);
    judge(r);
    return true;
}

bool sim_run(sim_result *self, const sim_def *def, daft_error *error)
{
    sim_work work = {.result = self, .began_ns = clock_now_ns()};
    *self = (sim_result){.def = *def};
    for (int k = 0; k < SIM_SETTINGS; k++) {
        sim_setting *s = &self->settings[k];
        s->substeps = SETTINGS[k].substeps, s->rate = SETTINGS[k].rate;
        snprintf(s->text, sizeof s->text, "substeps=%d,rate=%d", s->substeps, s->rate);
    }
    progress_begin(&work.bar, "simulating");
    const bool good = run(&work, error);
    progress_end(&work.bar);
    return good;
}

int sim_choose(const sim_result *self, double budget_ms)
{
    int best = -1;
    for (int k = 0; k < SIM_SETTINGS; k++) {
        const sim_setting *s = &self->settings[k];
        if (s->ms + s->spread <= budget_ms && (best < 0 || s->position < self->settings[best].position)) best = k;
    }
    return best;
}
