/* The group sim-accuracy: what a right motion costs. Worlds whose motion is known (sim_truth.c) run with 1 to 16
 * substeps at 30 to 240 Hz; the error of a point, energy, joints, overlap and drift stand beside the time. As a table,
 * as CSV, and as a plot of error against time with the settings that no other beats on both. */
#include "harness/bench.h"

#include "math/simd/dispatch.h"
#include "math/trig.h"
#include "sim_truth.h"
#include "harness/svg.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RATES = 4, DEPTHS = 5, SETTINGS = RATES * DEPTHS, REFERENCE_HZ = 3840, PANELS = TRUTH_CASES + 1 };
static const int HZ[RATES] = {30, 60, 120, 240}, SUBSTEPS[DEPTHS] = {1, 2, 4, 8, 16};

/* Rows: substeps; columns: rates. */
#define ROW_OF(depth, color)                                                                                           \
    {"30 Hz, " depth, color, SVG_TRIANGLE}, {"60 Hz, " depth, color, SVG_DISC}, {"120 Hz, " depth, color, SVG_SQUARE}, \
    {                                                                                                                  \
        "240 Hz, " depth, color, SVG_DIAMOND                                                                           \
    }
static const svg_series SERIES[SETTINGS] = {ROW_OF("1 substep", "#8c6d46"), ROW_OF("2 substeps", "#d9641e"),
                                            ROW_OF("4 substeps", "#2c8a3d"), ROW_OF("8 substeps", "#1f77b4"),
                                            ROW_OF("16 substeps", "#7b4fa3")};

/* Metres; energy: its maximum change, as a fraction of the maximum kinetic energy; ms: of a simulated second. */
typedef struct outcome {
    double ms, error, energy, stretch, overlap, drift;
} outcome;

typedef struct report {
    svg_point points[PANELS * SETTINGS];
    outcome outcomes[PANELS * SETTINGS];
    const char *names[PANELS];
    size_t count, panels;
} report;

/* ---- running ---- */

static truth_run begin(bench *self, const truth_case *c, int substeps)
{
    truth_run run = {.world = daft_world_create(&self->allocator, NULL)};
    int isa;
    run.failed = !run.world || !daft_isa_parse(self->isa, &isa);
    if (run.failed) return run;
    daft_world_set_workers(run.world, 1, isa);
    daft_world_set_substeps(run.world, substeps);
    daft_world_set_sleeping(run.world, false);
    daft_world_set_gravity(run.world, daft_v3(0, -9.81f, 0));
    c->build(&run);
    return run;
}

static bool step_to_frame(truth_run *run, int hz)
{
    for (int i = 0; i < hz / TRUTH_FRAMES_HZ && !run->failed; i++)
        run->failed = !daft_world_step(run->world, 1.0f / (float)hz, NULL);
    return !run->failed;
}

/* The point's position after each 1/30 s; other errors go to `out`, unless it is NULL. */
static bool watch(bench *self, const truth_case *c, int hz, int substeps, daft_dvec3 *frames, outcome *out)
{
    truth_run run = begin(self, c, substeps);
    double start = run.failed ? 0 : truth_energy(&run), kinetic = run.failed ? 0 : truth_kinetic(&run), change = 0;
    for (int i = 0; i < c->seconds * TRUTH_FRAMES_HZ && step_to_frame(&run, hz); i++) {
        frames[i] = c->point(&run);
        if (!out) continue;
        change = fmax(change, fabs(truth_energy(&run) - start));
        kinetic = fmax(kinetic, truth_kinetic(&run));
        out->stretch = fmax(out->stretch, truth_stretch(&run));
        if (c->overlap) out->overlap = fmax(out->overlap, c->overlap(&run));
        if (c->drift) out->drift = fmax(out->drift, c->drift(&run));
    }
    if (out && c->conservative) out->energy = change / kinetic;
    if (run.world) daft_world_destroy(run.world);
    return !run.failed;
}

/* Milliseconds a simulated second, of the steps alone. */
static double time_once(bench *self, const truth_case *c, int hz, int substeps)
{
    truth_run run = begin(self, c, substeps);
    double start = bench_clock_ms(1);
    for (int i = 0; i < c->seconds * TRUTH_FRAMES_HZ && step_to_frame(&run, hz); i++) {
    }
    double ms = (bench_clock_ms(1) - start) / c->seconds;
    if (run.world) daft_world_destroy(run.world);
    return run.failed ? -1 : ms;
}

/* The root of the mean square over the last second. */
static double error_of(const truth_case *c, const daft_dvec3 *frames, const daft_dvec3 *truth)
{
    double sum = 0;
    for (int i = (c->seconds - 1) * TRUTH_FRAMES_HZ; i < c->seconds * TRUTH_FRAMES_HZ; i++) {
        daft_dvec3 off = daft_dsub(frames[i], truth[i]);
        sum += daft_ddot(off, off);
    }
    return sqrt(sum / TRUTH_FRAMES_HZ);
}

/* Without --only just the rate that games use. */
static bool is_measured(const bench *self, size_t setting) { return self->only || HZ[setting % RATES] == 60; }

static bool measure_case(bench *self, const truth_case *c, report *all)
{
    static daft_dvec3 truth[TRUTH_FRAMES], frames[TRUTH_FRAMES];
    outcome outcomes[SETTINGS] = {0};
    bool good = true;
    if (c->exact)
        c->exact(c->seconds, truth);
    else
        good = watch(self, c, REFERENCE_HZ, 4, truth, NULL);
    for (size_t s = 0; good && s < SETTINGS; s++) {
        if (!is_measured(self, s)) continue;
        good = watch(self, c, HZ[s % RATES], SUBSTEPS[s / RATES], frames, &outcomes[s]);
        outcomes[s].error = error_of(c, frames, truth);
    }
    double start = daft_clock_ms();
    int rounds = self->rounds ? self->rounds : 9;
    for (int round = 0; good && round < rounds && (round < 3 || daft_clock_ms() - start < 2e3); round++)
        for (size_t s = 0; good && s < SETTINGS; s++) {
            if (!is_measured(self, s)) continue;
            double ms = time_once(self, c, HZ[s % RATES], SUBSTEPS[s / RATES]);
            outcomes[s].ms = round == 0 || ms < outcomes[s].ms ? ms : outcomes[s].ms;
            good = ms >= 0;
        }
    for (size_t s = 0; good && s < SETTINGS; s++) {
        if (!is_measured(self, s)) continue;
        all->points[all->count] = (svg_point){all->panels, s, outcomes[s].ms, 0};
        all->outcomes[all->count++] = outcomes[s];
    }
    all->names[all->panels] = c->name;
    all->panels += good;
    return good;
}

/* One more panel: each setting's geometric means over all the worlds. An error below a micrometre counts as one. */
static void add_means(report *all)
{
    size_t each = all->count / all->panels;
    for (size_t i = 0; i < each; i++) {
        double ms = 0, error = 0;
        for (size_t p = 0; p < all->panels; p++) {
            const outcome *o = &all->outcomes[p * each + i];
            ms += log(o->ms), error += log(fmax(o->error, 1e-6));
        }
        double fraction = 1 / (double)all->panels;
        all->outcomes[all->count] = (outcome){.ms = exp(ms * fraction), .error = exp(error * fraction)};
        all->points[all->count] = (svg_point){all->panels, all->points[i].series, exp(ms * fraction), 0};
        all->count++;
    }
    all->names[all->panels++] = "all, geometric means";
}

/* ---- saying so ---- */

static svg_plot plot_of(report *all, const char *note)
{
    /* Micrometres; errors below one are drawn as zero. */
    for (size_t i = 0; i < all->count; i++) {
        double error = all->outcomes[i].error * 1e6;
        all->points[i].y = error < 1 ? 0 : error;
    }
    return (svg_plot){.title = "What a right motion costs: error of a point, and time, by rate and substeps",
                      .note = note,
                      .x_label = "milliseconds a simulated second",
                      .y_label = "micrometres",
                      .panels = all->names,
                      .panel_count = all->panels,
                      .series = SERIES,
                      .series_count = SETTINGS,
                      .points = all->points,
                      .point_count = all->count};
}

static void describe(const outcome *o, bool beaten, char *out, size_t size)
{
    int used = snprintf(out, size, "%serror %.4g mm", beaten ? "      " : "FRONT ", o->error * 1e3);
    if (o->energy > 0) used += snprintf(out + used, size - (size_t)used, ", energy %.3g%%", o->energy * 100);
    if (o->stretch > 0) used += snprintf(out + used, size - (size_t)used, ", joints %.3g mm", o->stretch * 1e3);
    if (o->overlap > 0) used += snprintf(out + used, size - (size_t)used, ", overlap %.3g mm", o->overlap * 1e3);
    if (o->drift > 0) snprintf(out + used, size - (size_t)used, ", drift %.3g mm", o->drift * 1e3);
}

static void add_rows(bench *self, const report *all, const svg_plot *plot)
{
    for (size_t i = 0; i < all->count; i++) {
        const outcome *o = &all->outcomes[i];
        bench_row row = {.unit = "ms", .isa = self->isa, .threads = 1, .ours = o->ms, .peer = -1};
        snprintf(row.scene, sizeof row.scene, "sim-accuracy, %s", all->names[all->points[i].panel]);
        snprintf(row.what, sizeof row.what, "%s", SERIES[all->points[i].series].name);
        describe(o, svg_is_beaten(plot, i), row.counters, sizeof row.counters);
        bench_add(self, &row);
    }
}

static bool write_csv(const bench *self, const report *all, const svg_plot *plot)
{
    FILE *file = fopen(self->csv, "w");
    if (!file) return false;
    fprintf(file, "scene,hz,substeps,isa,ms,error_mm,energy,joints_mm,overlap_mm,drift_mm,front\n");
    for (size_t i = 0; i < all->count; i++) {
        const outcome *o = &all->outcomes[i];
        size_t s = all->points[i].series;
        fprintf(file, "\"%s\",%d,%d,%s,%.5f,%.6f,%.3e,%.6f,%.6f,%.6f,%d\n", all->names[all->points[i].panel],
                HZ[s % RATES], SUBSTEPS[s / RATES], self->isa, o->ms, o->error * 1e3, o->energy, o->stretch * 1e3,
                o->overlap * 1e3, o->drift * 1e3, !svg_is_beaten(plot, i));
    }
    bool written = !ferror(file);
    return fclose(file) == 0 && written;
}

void bench_sim_accuracy(bench *self)
{
    char note[256];
    report *all = daft_alloc_zero(&self->allocator, 1, sizeof *all);
    if (!all) return;
    for (size_t i = 0; i < TRUTH_CASES; i++) {
        char name[64];
        snprintf(name, sizeof name, "sim-accuracy, %s", TRUTH[i].name);
        if (!bench_wants(self, name, "")) continue;
        fprintf(stderr, "%s\n", name);
        if (!measure_case(self, &TRUTH[i], all)) bench_note(self, true, "%s failed", name);
    }
    if (all->panels == TRUTH_CASES) add_means(all);
    snprintf(
        note, sizeof note,
        "Root mean square over the last second, one thread, %s, nothing sleeps. Filled and joined: the Pareto front; "
        "hollow: another setting is both faster and no less right. Below 0: less than a micrometre.",
        self->isa);
    svg_plot plot = plot_of(all, note);
    add_rows(self, all, &plot);
    if (self->csv && all->count && !write_csv(self, all, &plot)) bench_note(self, true, "cannot write %s", self->csv);
    if (self->svg && all->count && !svg_write(&plot, self->svg)) bench_note(self, true, "cannot write %s", self->svg);
    daft_release(&self->allocator, all);
}
