/* Where to step, and what a step costs. */
#include "game/governor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BUDGET   0.95 /* of the target: what is left is for showing the picture */
#define ROOM     0.85 /* of the target, that a dearer rung must be expected to keep */
#define CHANGE   1000.0
#define HOLD     2000.0
#define HOLD_MAX 32000.0
#define OUTLIER  1.6 /* times the median: such a frame is slow for another reason than its picture */

enum {
    FULL = 6,
    SOON = 12, /* frames by which a jump of the load is told from a slow frame */
    LEARN = 15 /* frames after which a change is understood */
};

static const governor_rung RUNGS[GOVERNOR_RUNGS] = {
    {"half size, plain", 0.5, 0, 1, false}, {"half size", 0.5, 4, 2, true},
    {"60 % size", 0.6, 4, 2, true},         {"70 % size", 0.7, 4, 2, true},
    {"80 % size", 0.8, 4, 2, true},         {"90 % size", 0.9, 4, 2, true},
    [FULL] = {"full size", 1, 4, 2, true},  {"full size, all edges smooth", 1, 16, 3, true},
};

/* What frames took on such rungs in this project's own games and scenes, in the mean. */
static const double USUAL[GOVERNOR_RUNGS] = {0.22, 0.32, 0.43, 0.55, 0.69, 0.84, 1, 1.5};

const governor_rung *governor_rung_at(int rung) { return &RUNGS[rung]; }

int governor_full(void) { return FULL; }

/* Costs rise from rung to rung, by something. */
static void keep_order(double *cost)
{
    for (int i = FULL - 1; i >= 0; i--) cost[i] = fmin(fmax(cost[i], 0.02), cost[i + 1] * 0.98);
    for (int i = FULL + 1; i < GOVERNOR_RUNGS; i++) cost[i] = fmin(fmax(cost[i], cost[i - 1] * 1.02), 20);
}

void governor_begin(governor *g, double target_ms, const double *costs)
{
    *g = (governor){.target_ms = target_ms, .rung = FULL, .hold_ms = HOLD, .before = FULL, .why = "the quality itself"};
    for (int i = 0; i < GOVERNOR_RUNGS; i++) g->cost[i] = costs && costs[i] > 0 && costs[i] < 20 ? costs[i] : USUAL[i];
    g->cost[FULL] = 1;
    keep_order(g->cost);
    g->since_ms = CHANGE;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A quantile of the last `count` frames, but for those that are slow for another reason than their picture: these a
 * worse picture would not cure. */
static double quantile(const governor *g, uint64_t count, double q)
{
    double sorted[GOVERNOR_FRAMES];
    if (count > GOVERNOR_FRAMES) count = GOVERNOR_FRAMES;
    if (count > g->frames) count = g->frames;
    if (count == 0) return 0;
    for (uint64_t i = 0; i < count; i++) sorted[i] = g->recent[(g->frames - 1 - i) % GOVERNOR_FRAMES];
    qsort(sorted, count, sizeof *sorted, compare);
    const double most = OUTLIER * sorted[(count - 1) / 2];
    while (sorted[count - 1] > most) count--;
    return sorted[(uint64_t)(q * (double)(count - 1) + 0.5)];
}

double governor_slow_ms(const governor *g) { return quantile(g, GOVERNOR_FRAMES, 0.95); }

static bool step_to(governor *g, int rung, const char *why)
{
    g->before = g->rung, g->before_ms = quantile(g, SOON, 0.5);
    g->rung = rung, g->why = why;
    g->frames = 0, g->since_ms = 0, g->changes++;
    return true;
}

/* What a frame that took `ms` here would take there. */
static double expected(const governor *g, double ms, int rung) { return ms * g->cost[rung] / g->cost[g->rung]; }

/* The dearest rung below that is expected to keep the time. */
static int rung_for(const governor *g, double ms)
{
    int rung = g->rung - 1;
    while (rung > 0 && expected(g, ms, rung) > BUDGET * g->target_ms) rung--;
    return rung;
}

/* Some time after a change it is known what it did. A step down often follows a jump of the load, which may go on: what
 * it tells counts half. */
static void learn(governor *g)
{
    if (!(g->before_ms > 0) || g->frames < LEARN) return;
    const double now = quantile(g, LEARN, 0.5), was = g->cost[g->rung] / g->cost[g->before];
    const double found = fmin(fmax(now / g->before_ms, was / 2), was * 2);
    const bool below = g->rung < g->before;
    const double factor = below ? sqrt(found / was) : found / was;
    /* The rungs on the far side move with it: what was learned of one step tells of the next ones. */
    for (int i = 0; i < GOVERNOR_RUNGS; i++)
        if (below ? i <= g->rung : i >= g->rung) g->cost[i] *= factor;
    const double full = g->cost[FULL];
    for (int i = 0; i < GOVERNOR_RUNGS; i++) g->cost[i] /= full;
    keep_order(g->cost);
    g->before_ms = 0;
}

static bool step_down(governor *g)
{
    if (g->rung == 0 || g->since_ms < CHANGE) return false;
    const double soon = quantile(g, SOON, 0.5), slow = governor_slow_ms(g), budget = BUDGET * g->target_ms;
    const bool loaded = g->frames >= SOON && soon > budget;
    const bool often = g->frames >= GOVERNOR_FRAMES && slow > g->target_ms;
    if (!loaded && !often) return false;
    /* A rung that was climbed to in vain is not tried again so soon. */
    if (g->rung > g->before && g->since_ms < 10 * CHANGE) g->hold_ms = fmin(2 * g->hold_ms, HOLD_MAX);
    return step_to(g, rung_for(g, loaded ? soon * 1.12 : slow),
                   loaded ? "frames took longer than asked" : "one frame in twenty took longer than asked");
}

static bool step_up(governor *g)
{
    if (g->rung == GOVERNOR_RUNGS - 1 || g->since_ms < g->hold_ms || g->frames < GOVERNOR_FRAMES) return false;
    if (expected(g, governor_slow_ms(g), g->rung + 1) > ROOM * g->target_ms) return false;
    return step_to(g, g->rung + 1, "there is time for a better picture");
}

bool governor_frame(governor *g, double work_ms, double turn_ms)
{
    if (!(work_ms >= 0) || !(turn_ms >= 0)) return false;
    g->recent[g->frames++ % GOVERNOR_FRAMES] = work_ms;
    g->since_ms += turn_ms;
    if (g->since_ms > 30 * CHANGE) g->hold_ms = HOLD;
    learn(g);
    return step_down(g) || step_up(g);
}

void governor_apply(const governor *g, daft_view *view)
{
    if (!g) return;
    const governor_rung *rung = &RUNGS[g->rung];
    daft_quality *q = &view->quality;
    if (g->rung > FULL) {
        if (q->samples == 1 && q->edge_samples < rung->edge_samples) q->edge_samples = rung->edge_samples;
        if (q->mirror_depth < rung->mirror_depth) q->mirror_depth = rung->mirror_depth;
    }
    if (g->rung >= FULL) return;
    if (q->edge_samples > rung->edge_samples) q->edge_samples = rung->edge_samples;
    if (q->mirror_depth > rung->mirror_depth) q->mirror_depth = rung->mirror_depth;
    if (!rung->sampled) q->shadow_samples = q->occlusion_samples = q->glossy_samples = 0;
}
