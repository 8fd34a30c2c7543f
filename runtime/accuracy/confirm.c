/* Timing again what a budget buys, just before it is recommended.
 *
 * Of many settings with noisy times the choice falls on those that seem faster than they are, and by the end of a sweep
 * the machine may be slower than at its beginning. So the chosen setting and its neighbours on the front take turns
 * once more, and what was chosen wrongly gives way to the next, until the choice is one that was timed just now. */
#include "accuracy/sweep.h"

#include "common/util.h"

#include <math.h>

enum { GROUP = 3, ROUNDS = 9, LEAST_ROUNDS = 3 };

/* Parts of the sweep's time that the rounds of one group may take, and all of them but the last choices. */
static const double GROUP_SHARE = 0.03, ALL_SHARE = 0.12;

typedef struct confirmation {
    sweep_result *sweep;
    daft_image *image;
    daft_camera camera; /* moves by the smallest number there is: see draw_timed() of sweep.c */
    uint64_t began_ns;
} confirmation;

static double seconds_since(uint64_t began_ns) { return (double)(clock_now_ns() - began_ns) / 1e9; }

/* Whether the least of rounds takes longer than a group may: such a setting is timed once, and alone. */
static bool is_slow(const sweep_result *s, const sweep_point *p)
{
    return LEAST_ROUNDS * p->ms / 1e3 > GROUP_SHARE * s->def.seconds;
}

/* The setting of the front that is next in time to a point, among those that are not timed yet; -1: none. */
static int find_neighbour(const sweep_result *s, int of, bool dearer)
{
    int next = -1;
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *p = &s->points[i];
        const double apart = dearer ? p->ms - s->points[of].ms : s->points[of].ms - p->ms;
        if (!p->on_front || p->again_ms > 0 || apart <= 0 || is_slow(s, p)) continue;
        if (next < 0 || apart < fabs(s->points[next].ms - s->points[of].ms)) next = (int)i;
    }
    return next;
}

static int find_fastest(const sweep_result *s)
{
    size_t fastest = 0;
    for (size_t i = 1; i < s->count; i++)
        if (s->points[i].ms < s->points[fastest].ms) fastest = i;
    return (int)fastest;
}

static bool draw(confirmation *c, const sweep_point *p, double *ms, daft_error *error)
{
    const sweep_result *s = c->sweep;
    daft_view view = s->def.view;
    c->camera.position.x = nextafter(c->camera.position.x, INFINITY);
    view.camera = c->camera, view.quality = p->quality;
    const uint64_t began = clock_now_ns();
    if (!daft_render(s->def.scene, &view, c->image, error)) return false;
    *ms = (double)(clock_now_ns() - began) / 1e6;
    return true;
}

/* A game stands at its last moment, where its times are others than on average: what counts is how much slower it is
 * now than when that moment was measured. */
static void take(const sweep_result *s, sweep_point *p, double *times, int rounds)
{
    double spread;
    const double now = sweep_median(times, rounds, &spread), then = p->at[s->moments - 1].ms;
    const double factor = s->def.moments && then > 0 ? p->ms / then : 1;
    p->again_ms = factor * now, p->again_spread = factor * spread;
}

/* One picture of each that does not count, then rounds in turns. */
static bool time_group(confirmation *c, const int *group, int count, int most, daft_error *error)
{
    sweep_result *s = c->sweep;
    double times[GROUP][ROUNDS], ignored;
    int rounds = 0;
    for (int k = 0; k < count; k++)
        if (!draw(c, &s->points[group[k]], &ignored, error)) return false;
    const uint64_t began = clock_now_ns();
    const int least = is_slow(s, &s->points[group[0]]) ? 1 : LEAST_ROUNDS;
    while (rounds < most && (rounds < least || seconds_since(began) < GROUP_SHARE * s->def.seconds)) {
        for (int k = 0; k < count; k++)
            if (!draw(c, &s->points[group[k]], &times[k][rounds], error)) return false;
        rounds++;
    }
    for (int k = 0; k < count; k++) take(s, &s->points[group[k]], times[k], rounds);
    return true;
}

/* Each round of the loop times a setting more, so that it ends. When the time is over, only what is chosen is timed,
 * and no more than it must be: a choice that was not timed again would be one of those that seem too fast. */
static bool confirm(confirmation *c, double budget_ms, daft_error *error)
{
    sweep_result *s = c->sweep;
    for (;;) {
        const int chosen = sweep_choose(s, budget_ms), best = chosen < 0 ? find_fastest(s) : chosen;
        if (s->points[best].again_ms > 0) return true;
        const bool late = seconds_since(c->began_ns) > ALL_SHARE * s->def.seconds || is_slow(s, &s->points[best]);
        int group[GROUP] = {best}, count = 1;
        for (int dearer = 0; dearer < 2 && !late; dearer++) {
            const int next = find_neighbour(s, best, dearer);
            if (next >= 0) group[count++] = next;
        }
        if (!time_group(c, group, count, late ? LEAST_ROUNDS : ROUNDS, error)) return false;
    }
}

bool sweep_confirm(sweep_result *self, double budget_ms, daft_error *error)
{
    for (size_t i = 0; i < self->count; i++) self->points[i].again_ms = self->points[i].again_spread = 0;
    if (self->moved_on) return true;
    confirmation c = {.sweep = self, .camera = self->def.view.camera, .began_ns = clock_now_ns()};
    if (self->def.moments) c.camera = daft_scene_camera(self->def.scene, 1);
    c.image = daft_image_create(self->def.engine, self->def.width, self->def.height, error);
    const bool good = c.image && confirm(&c, budget_ms, error);
    daft_image_destroy(c.image);
    return good;
}
