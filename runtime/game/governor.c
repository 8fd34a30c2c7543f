/* Where to step, and what a step costs. */
#include "game/governor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BUDGET      0.95 /* of the target: what is left is for showing the picture */
#define ROOM        0.85 /* of the target, that a dearer rung must be expected to keep */
#define CHANGE      1000.0
#define HOLD        2000.0
#define HOLD_MAX    32000.0
#define LEAST_SCALE 0.1f /* of a quality */
#define OUTLIER     1.6  /* times the median: such a frame is slow for another reason than its picture */

enum {
    FULL = 10,
    SOON = 12, /* frames by which a jump of the load is told from a slow frame */
    LEARN = 15 /* frames after which a change is understood */
};

static const governor_rung RUNGS[GOVERNOR_RUNGS] = {{"third size, plain", 0.35, 0, 1, false, false, 0},
                                                    {"half size, plain", 0.5, 0, 1, false, false, 0},
                                                    {"half size", 0.5, 4, 2, true, false, 0},
                                                    {"60 % size", 0.6, 4, 2, true, false, 0},
                                                    {"70 % size", 0.7, 4, 2, true, false, 0},
                                                    {"80 % size", 0.8, 4, 2, true, false, 0},
                                                    {"90 % size", 0.9, 4, 2, true, false, 0},
                                                    {"70 % size, hard light", 0.7, 4, 2, false, false, 0},
                                                    {"full size, hard light", 1, 4, 2, false, false, 0},
                                                    {"full size, plain edges", 1, 0, 2, true, false, 0},
                                                    [FULL] = {"full size", 1, 4, 2, true, false, 0},
                                                    {"full size, sharp textures", 1, 0, 0, true, true, 0},
                                                    {"full size, strong edges smooth", 1, 16, 3, true, true, 2},
                                                    {"full size, all edges smooth", 1, 16, 3, true, true, 1}};

/* What frames took on such rungs in this project's own games and scenes, in the mean; and whether they are climbed
 * before they have been surveyed. */
static const double USUAL[GOVERNOR_RUNGS] = {0.14, 0.22, 0.32, 0.43, 0.55, 0.69, 0.84, 0.5, 0.8, 0.9, 1, 1.2, 1.7, 2};
static const bool CLIMBED[GOVERNOR_RUNGS] = {true,  true,  true,  true, true, true, true,
                                             false, false, false, true, true, true, true};

const governor_rung *governor_rung_at(int rung) { return &RUNGS[rung]; }

int governor_full(void) { return FULL; }

/* ---- the ladder -------------------------------------------------------------------------------------------------- */

bool governor_is_surveyed(const governor *g)
{
    for (int i = 0; i < GOVERNOR_RUNGS; i++)
        if (isnan(g->known.error[i])) return false;
    return true;
}

static bool is_climbed(const governor *g, bool surveyed, int rung)
{
    const governor_costs *k = &g->known;
    if (rung == FULL) return true;
    if (!surveyed) return CLIMBED[rung];
    for (int i = 0; i < GOVERNOR_RUNGS; i++) {
        const bool as_good = k->error[i] <= k->error[rung], as_cheap = k->cost[i] <= k->cost[rung];
        const bool better = k->error[i] < k->error[rung] || k->cost[i] < k->cost[rung] || i > rung;
        if (i != rung && as_good && as_cheap && better) return false;
    }
    return true;
}

/* The rungs that are climbed, by what they cost. */
static void build_ladder(governor *g)
{
    const bool surveyed = governor_is_surveyed(g);
    g->rungs = 0;
    for (int i = 0; i < GOVERNOR_RUNGS; i++) {
        if (!is_climbed(g, surveyed, i)) continue;
        int at = g->rungs++;
        for (; at > 0 && g->known.cost[g->ladder[at - 1]] > g->known.cost[i]; at--) g->ladder[at] = g->ladder[at - 1];
        g->ladder[at] = i;
    }
}

/* Where on the ladder the rung stands, or the one below where it is none of it. */
static int place_of(const governor *g, int rung)
{
    int place = 0;
    for (int i = 0; i < g->rungs; i++) {
        if (g->ladder[i] == rung) return i;
        if (g->known.cost[g->ladder[i]] <= g->known.cost[rung]) place = i;
    }
    return place;
}

/* Costs rise from rung to rung of the ladder, by something. */
static void keep_order(governor *g)
{
    double *cost = g->known.cost;
    const int full = place_of(g, FULL), *l = g->ladder;
    for (int i = full - 1; i >= 0; i--) cost[l[i]] = fmin(fmax(cost[l[i]], 0.02), cost[l[i + 1]] * 0.98);
    for (int i = full + 1; i < g->rungs; i++) cost[l[i]] = fmin(fmax(cost[l[i]], cost[l[i - 1]] * 1.02), 20);
}

static bool is_cost(double cost) { return cost > 0 && cost < 20; }

static void take_costs(governor *g, const governor_costs *costs)
{
    for (int i = 0; i < GOVERNOR_RUNGS; i++) {
        g->known.cost[i] = costs && is_cost(costs->cost[i]) ? costs->cost[i] : USUAL[i];
        g->known.error[i] = costs && costs->error[i] >= 0 && costs->error[i] <= 1 ? costs->error[i] : (double)NAN;
    }
    g->known.cost[FULL] = 1;
    build_ladder(g);
    keep_order(g);
}

void governor_begin(governor *g, double target_ms, const governor_costs *costs)
{
    *g = (governor){.target_ms = target_ms, .rung = FULL, .hold_ms = HOLD, .before = FULL, .why = "the quality itself"};
    take_costs(g, costs);
    g->since_ms = CHANGE;
}

void governor_survey(governor *g, const governor_costs *costs) { take_costs(g, costs); }

/* ---- frames ------------------------------------------------------------------------------------------------------ */

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
static double expected(const governor *g, double ms, int rung)
{
    return ms * g->known.cost[rung] / g->known.cost[g->rung];
}

/* The dearest rung below that is expected to keep the time. */
static int rung_for(const governor *g, double ms)
{
    int place = place_of(g, g->rung) - (g->ladder[place_of(g, g->rung)] == g->rung);
    while (place > 0 && expected(g, ms, g->ladder[place]) > BUDGET * g->target_ms) place--;
    return g->ladder[place];
}

/* Some time after a change it is known what it did. A step down often follows a jump of the load, which may go on: what
 * it tells counts half. */
static void learn(governor *g)
{
    if (!(g->before_ms > 0) || g->frames < LEARN) return;
    double *cost = g->known.cost;
    const double now = quantile(g, LEARN, 0.5), here = cost[g->rung], was = here / cost[g->before];
    const double found = fmin(fmax(now / g->before_ms, was / 2), was * 2);
    const bool below = was < 1;
    const double factor = below ? sqrt(found / was) : found / was;
    /* The rungs on the far side move with it: what was learned of one step tells of the next ones. */
    for (int i = 0; i < GOVERNOR_RUNGS; i++)
        if (below ? cost[i] <= here : cost[i] >= here) cost[i] *= factor;
    const double full = cost[FULL];
    for (int i = 0; i < GOVERNOR_RUNGS; i++) cost[i] /= full;
    keep_order(g);
    g->before_ms = 0;
}

static bool step_down(governor *g)
{
    if (g->rung == g->ladder[0] || g->since_ms < CHANGE) return false;
    const double soon = quantile(g, SOON, 0.5), slow = governor_slow_ms(g), budget = BUDGET * g->target_ms;
    const bool loaded = g->frames >= SOON && soon > budget;
    const bool often = g->frames >= GOVERNOR_FRAMES && slow > g->target_ms;
    if (!loaded && !often) return false;
    /* A rung that was climbed to in vain is not tried again so soon. */
    if (g->known.cost[g->rung] > g->known.cost[g->before] && g->since_ms < 10 * CHANGE)
        g->hold_ms = fmin(2 * g->hold_ms, HOLD_MAX);
    return step_to(g, rung_for(g, loaded ? soon * 1.12 : slow),
                   loaded ? "frames took longer than asked" : "one frame in twenty took longer than asked");
}

static bool step_up(governor *g)
{
    const int next = place_of(g, g->rung) + 1;
    if (next == g->rungs || g->since_ms < g->hold_ms || g->frames < GOVERNOR_FRAMES) return false;
    if (expected(g, governor_slow_ms(g), g->ladder[next]) > ROOM * g->target_ms) return false;
    return step_to(g, g->ladder[next], "there is time for a better picture");
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

void governor_set(int rung, daft_quality *q)
{
    const governor_rung *r = &RUNGS[rung];
    q->scale = fmaxf(LEAST_SCALE, q->scale * (float)r->scale);
    if (rung > FULL) {
        if (q->samples == 1 && q->edge_samples < r->edge_samples)
            q->edge_samples = r->edge_samples, q->edge_contrast = r->edge_contrast;
        if (r->sharp && q->texture_filter == DAFT_TEXTURE_TRILINEAR) q->texture_filter = DAFT_TEXTURE_ANISOTROPIC4;
        if (q->mirror_depth < r->mirror_depth) q->mirror_depth = r->mirror_depth;
    }
    if (rung >= FULL) return; /* those after it are better */
    if (q->edge_samples > r->edge_samples) q->edge_samples = r->edge_samples;
    if (q->mirror_depth > r->mirror_depth) q->mirror_depth = r->mirror_depth;
    if (!r->sampled) q->shadow_samples = q->occlusion_samples = q->glossy_samples = 0;
}

void governor_apply(const governor *g, daft_view *view)
{
    if (g) governor_set(g->rung, &view->quality);
}
