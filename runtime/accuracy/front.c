/* Which settings no other beats, and which of them a budget buys. */
#include "accuracy/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare_times(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* One time alone has no spread: it may be off by a tenth, as times are where the machine does something else. */
static double spread_of(const double *sorted, int count)
{
    if (count == 1) return sorted[0] / 10;
    if (count < 4) return (sorted[count - 1] - sorted[0]) / 2;
    return (sorted[count * 3 / 4] - sorted[count / 4]) / 2;
}

static double middle_of(double *values, size_t count)
{
    qsort(values, count, sizeof *values, compare_times);
    return (values[(count - 1) / 2] + values[count / 2]) / 2;
}

/* How slow the machine was in each round, relative to its median: the median over the settings of their times in the
 * round, each relative to its own median. In a round all settings take turns, so that what slows all of them alike says
 * nothing of their order. 1 where fewer than ENOUGH settings tell. */
static void find_slowness(const sweep_result *s, int moment, double slowness[SWEEP_ROUNDS])
{
    enum { ENOUGH = 16 };
    double *relative = malloc((s->count + 1) * sizeof *relative);
    for (int round = 0; round < SWEEP_ROUNDS; round++) {
        size_t count = 0;
        for (size_t i = 0; relative && i < s->count; i++) {
            const sweep_measure *m = &s->points[i].at[moment];
            double times[SWEEP_ROUNDS];
            if (m->rounds <= round) continue;
            memcpy(times, m->times, sizeof times);
            relative[count++] = m->times[round] / middle_of(times, (size_t)m->rounds);
        }
        slowness[round] = count >= ENOUGH ? middle_of(relative, count) : 1;
    }
    free(relative);
}

double sweep_median(double *times, int count, double *spread)
{
    const double median = middle_of(times, (size_t)count);
    *spread = spread_of(times, count);
    return median;
}

static double median_of(const sweep_measure *m, const double slowness[SWEEP_ROUNDS], double *spread)
{
    double times[SWEEP_ROUNDS];
    *spread = 0;
    if (m->rounds == 0) return 0;
    for (int i = 0; i < m->rounds; i++) times[i] = m->times[i] / slowness[i];
    return sweep_median(times, m->rounds, spread);
}

/* Means over the moments; of the tiles the worst. */
static void summarise(sweep_point *p, int moments, double slowness[][SWEEP_ROUNDS])
{
    picture_errors *e = &p->errors;
    double squares = 0;
    p->ms = p->spread = p->temporal = p->half_flip[0] = p->half_flip[1] = 0, p->picture = 0;
    *e = (picture_errors){0};
    for (int i = 0; i < moments; i++) {
        sweep_measure *m = &p->at[i];
        double spread;
        m->ms = median_of(m, slowness[i], &spread);
        p->ms += m->ms / moments, p->spread += spread / moments;
        squares += m->errors.rmse * m->errors.rmse / moments;
        e->ssim += m->errors.ssim / moments, e->flip += m->errors.flip / moments;
        e->worst = fmax(e->worst, m->errors.worst);
        for (int k = 0; k < 2; k++) p->half_flip[k] += m->half_flip[k] / moments;
        p->temporal += m->temporal / moments;
        p->picture = daft_hash(&m->picture, sizeof m->picture, p->picture);
    }
    e->rmse = sqrt(squares), e->psnr = metrics_psnr(e->rmse);
}

bool sweep_equal_times(const sweep_point *a, const sweep_point *b)
{
    return fabs(a->ms - b->ms) <= a->spread + b->spread;
}

/* Closer to the reference, by both of its halves. Where they disagree, the order is noise and the errors are equal. */
static bool is_closer(const sweep_point *a, const sweep_point *b)
{
    return a->half_flip[0] < b->half_flip[0] && a->half_flip[1] < b->half_flip[1];
}

/* a is better than b on one axis and not worse on the other, beyond noise. */
static bool beats(const sweep_point *a, const sweep_point *b)
{
    bool equal_times = sweep_equal_times(a, b), faster = a->ms < b->ms && !equal_times;
    return (faster && !is_closer(b, a)) || (equal_times && is_closer(a, b));
}

/* Of settings with one picture and equal times, one speaks for all: the first in the list, since presets come first. */
static void find_same(sweep_result *s, size_t i)
{
    for (size_t k = 0; k < i && s->points[i].same_as < 0; k++) {
        const sweep_point *p = &s->points[k];
        if (p->picture == s->points[i].picture && p->same_as < 0 && sweep_equal_times(p, &s->points[i]))
            s->points[i].same_as = (int)k;
    }
}

void sweep_judge(sweep_result *s)
{
    double slowness[SWEEP_MOMENTS][SWEEP_ROUNDS];
    for (int i = 0; i < s->moments; i++) find_slowness(s, i, slowness[i]);
    for (size_t i = 0; i < s->count; i++) {
        summarise(&s->points[i], s->moments, slowness);
        s->points[i].same_as = s->points[i].beaten_by = -1;
    }
    for (size_t i = 0; i < s->count; i++) find_same(s, i);
    for (size_t i = 0; i < s->count; i++) {
        sweep_point *p = &s->points[i];
        for (size_t k = 0; k < s->count && p->beaten_by < 0; k++)
            if (s->points[k].same_as < 0 && beats(&s->points[k], p)) p->beaten_by = (int)k;
        p->on_front = p->beaten_by < 0 && p->same_as < 0;
    }
}

bool sweep_all_same(const sweep_result *s)
{
    for (size_t i = 1; i < s->count; i++)
        if (s->points[i].picture != s->points[0].picture) return false;
    return true;
}

static bool keeps(const sweep_point *p, double budget_ms)
{
    return (p->again_ms > 0 ? p->again_ms + p->again_spread : p->ms + p->spread) <= budget_ms;
}

int sweep_choose(const sweep_result *s, double budget_ms)
{
    int best = -1;
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *p = &s->points[i];
        if (p->same_as >= 0 || !keeps(p, budget_ms)) continue;
        if (best < 0 || p->errors.flip < s->points[best].errors.flip ||
            (p->errors.flip == s->points[best].errors.flip && p->ms < s->points[best].ms))
            best = (int)i;
    }
    return best;
}
