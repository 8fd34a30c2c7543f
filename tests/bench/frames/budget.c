/* Rows `budget, NAME`: each scene of assets/scenes: whether what `daft cost --quick` recommends for a budget is kept by
 * the frame that follows. One sweep finds the front; then ten trials, two of each of five budgets from the cheapest to
 * the dearest setting of the front: the recommendation, as daft cost gives it, and a few frames by it, each in full.
 * Ours is how many trials in ten have a median of these frames of at most the budget and a tenth. Beside it stand the
 * worst of the medians and how many first frames kept it: one frame alone tells of the machine's other programs, too.
 * Wall time, as people meet it. */
#include "frames/users.h"

#include "accuracy/sweep.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BUDGETS = 5, TRIALS = 10, FRAMES = 5, RAISES = 12, SECONDS = 22, WIDTH = 320, HEIGHT = 180 };

static const double TOLERANCE = 1.1;

typedef struct outcome {
    int trials, kept, first_kept;
    double worst; /* median frame over budget */
} outcome;

/* The least and the most that a budget may be so that it buys something of the front. */
static void find_range(const sweep_result *s, double *low, double *high)
{
    *low = INFINITY, *high = 0;
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *p = &s->points[i];
        if (!p->on_front) continue;
        *low = fmin(*low, TOLERANCE * (p->ms + p->spread)), *high = fmax(*high, p->ms + p->spread);
    }
    *high = fmax(*low, *high);
}

static bool draw_frames(users_show *show, const daft_quality *quality, double ms[FRAMES], daft_error *error)
{
    daft_view view = show->view;
    view.quality = *quality, view.full = true;
    for (int i = 0; i < FRAMES; i++) {
        const double start = daft_clock_ms();
        if (!daft_render(show->scene, &view, show->image, error)) return false;
        ms[i] = daft_clock_ms() - start;
    }
    return true;
}

/* What the budget buys; one that buys nothing any more, since the machine has become slower, is raised by tenths. */
static bool recommend(sweep_result *s, double *budget, int *chosen, daft_error *error)
{
    *chosen = -1;
    for (int i = 0; i < RAISES && *chosen < 0; i++) {
        if (i > 0) *budget *= 1.1;
        if (!sweep_confirm(s, *budget, error)) return false;
        *chosen = sweep_choose(s, *budget);
    }
    return true;
}

/* Says what a miss was: the promise, what it was made from, and the frames. */
static void tell_miss(bench *self, const sweep_point *p, double budget, const double ms[FRAMES])
{
    bench_note(self, false,
               "%.2f ms missed: %.2f to %.2f ms by %s %s; timed at %.2f +- %.2f ms in the sweep, %.2f +- %.2f again",
               budget, ms[0], ms[FRAMES - 1], p->knob, p->setting, p->ms, p->spread, p->again_ms, p->again_spread);
}

static bool try_budget(bench *self, users_show *show, sweep_result *s, double budget, outcome *out, daft_error *error)
{
    double ms[FRAMES], spread;
    int chosen;
    if (!recommend(s, &budget, &chosen, error)) return false;
    if (chosen < 0) return true; /* no promise, no trial */
    if (!draw_frames(show, &s->points[chosen].quality, ms, error)) return false;
    out->trials++, out->first_kept += ms[0] <= TOLERANCE * budget;
    const double over = sweep_median(ms, FRAMES, &spread) / budget;
    if (over > TOLERANCE) tell_miss(self, &s->points[chosen], budget, ms);
    out->kept += over <= TOLERANCE, out->worst = fmax(out->worst, over);
    return true;
}

static bool try_all(bench *self, const char *path, int threads, outcome *out, double range[2], daft_error *error)
{
    users_show show;
    sweep_result sweep = {0};
    bool good = users_open(self, path, threads, WIDTH, HEIGHT, &show, error);
    const sweep_def def = {.engine = show.engine,
                           .scene = show.scene,
                           .view = show.view,
                           .preset = DAFT_PRESET_GAME,
                           .width = WIDTH,
                           .height = HEIGHT,
                           .seconds = SECONDS,
                           .quick = true};
    const bool swept = good && sweep_run(&sweep, &def, error);
    good = swept;
    if (good) find_range(&sweep, &range[0], &range[1]);
    for (int i = 0; good && i < TRIALS; i++) {
        const double budget = range[0] * pow(range[1] / range[0], (double)(i % BUDGETS) / (BUDGETS - 1));
        good = try_budget(self, &show, &sweep, budget, out, error);
    }
    if (swept) sweep_free(&sweep);
    users_close(&show);
    return good;
}

static void measure(bench *self, const char *name, const char *path, int threads)
{
    daft_error error = {0};
    char text[1200];
    outcome o = {0};
    double range[2];
    bench_row row = {.unit = "of 10",
                     .isa = self->isa,
                     .threads = threads,
                     .peer = -1,
                     .budget = {.floor = 9, .aim = 10, .of_value = true}};
    fprintf(stderr, "%s, %d thread%s\n", name, threads, threads == 1 ? "" : "s");
    if (!try_all(self, path, threads, &o, range, &error)) {
        bench_note(self, true, "%s: %s", name, daft_error_text(&error, text, sizeof text));
        return;
    }
    if (o.trials == 0) {
        bench_note(self, true, "%s: nothing was recommended", name);
        return;
    }
    snprintf(row.scene, sizeof row.scene, "%s", name);
    snprintf(row.what, sizeof row.what, "budgets kept");
    row.ours = 10.0 * o.kept / o.trials;
    snprintf(row.counters, sizeof row.counters,
             "%d of %d kept, worst %+.0f %%; by the first frame alone %d; %.2f to %.2f ms", o.kept, o.trials,
             100 * (o.worst - 1), o.first_kept, range[0], range[1]);
    bench_add(self, &row);
}

void bench_budgets(bench *self)
{
    struct dirent **found;
    int counts[2], threads = bench_thread_counts(self, counts);
    const int count = scandir(DAFT_ROOT "/assets/scenes", &found, users_is_scene, alphasort);
    for (int i = 0; i < count; i++) {
        char name[64], path[512];
        snprintf(path, sizeof path, "%s/assets/scenes/%.200s", DAFT_ROOT, found[i]->d_name);
        snprintf(name, sizeof name, "budget, %.*s", (int)strcspn(found[i]->d_name, "."), found[i]->d_name);
        if (bench_wants(self, name, "budgets kept")) measure(self, name, path, counts[threads - 1]);
        free(found[i]);
    }
    if (count >= 0) free(found);
}
