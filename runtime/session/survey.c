/* A survey of the governor's rungs: what each takes on this machine in this game, and how far its pictures are from
 * better ones. Each measure draws one more picture, which nobody sees, where a frame has time for it or while the game
 * pauses; so the survey takes some ten seconds of play. Its figures are kept with the costs (costs.c). */
#include "session/state.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Frames between two measures; of the target, what a frame with a measure may take. */
enum { REST = 6, TILE = 32 };
static const double ROOM = 0.9;

static bool is_done(const rung_survey *v) { return v->next >= GOVERNOR_RUNGS * SURVEY_ROUNDS; }

/* Better than all rungs in whatever they leave out. Several samples of every pixel would blur textures, and count sharp
 * ones as errors. */
static daft_quality reference_of(const daft_quality *own)
{
    daft_quality q = *own;
    q.scale = 1;
    if (q.samples == 1) q.edge_samples = 16, q.edge_contrast = 0.5f;
    if (q.texture_filter == DAFT_TEXTURE_TRILINEAR) q.texture_filter = DAFT_TEXTURE_ANISOTROPIC16;
    if (q.shadow_samples < 4) q.shadow_samples *= 4;
    if (q.occlusion_samples < 4) q.occlusion_samples *= 4;
    if (q.glossy_samples < 4) q.glossy_samples *= 4;
    q.mirror_depth = q.mirror_depth < 4 ? 4 : q.mirror_depth;
    return q;
}

static bool fit(session *s, daft_image **image, daft_error *error)
{
    const int width = daft_image_width(s->picture), height = daft_image_height(s->picture);
    if (*image && daft_image_width(*image) == width && daft_image_height(*image) == height) return true;
    daft_image_destroy(*image);
    *image = daft_image_create(s->def->engine, width, height, error);
    return *image != NULL;
}

/* Draws the rung's picture as a whole, and a row of tiles of the reference. */
static bool measure(void *user, daft_scene *scene, const daft_view *view, daft_error *error)
{
    session *s = user;
    rung_survey *v = &s->survey;
    const int rung = v->next % GOVERNOR_RUNGS, round = v->next / GOVERNOR_RUNGS;
    const int rows = (daft_image_height(v->whole) + TILE - 1) / TILE, row = probe_row_of((uint32_t)round, rows);
    const daft_quality own = quality_choose(&s->play->def.quality, scene);
    daft_view seen = *view;
    seen.history = NULL, seen.full = true, seen.quality = reference_of(&own);
    seen.first_row = TILE * row, seen.row_count = row + 1 < rows ? TILE : 0;
    if (!daft_render(scene, &seen, v->reference, error)) return false; /* it also finds out what has moved */
    seen.first_row = seen.row_count = 0, seen.quality = own;
    governor_set(rung, &seen.quality);
    const uint64_t began = clock_now_ns();
    if (!daft_render(scene, &seen, v->whole, error)) return false;
    v->ms[rung][round] = (double)(clock_now_ns() - began) / 1e6;
    return probe_compare(v->whole, v->reference, TILE * row, (uint32_t)round, &v->error[rung][round], error);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *values)
{
    double sorted[SURVEY_ROUNDS];
    memcpy(sorted, values, sizeof sorted);
    qsort(sorted, SURVEY_ROUNDS, sizeof *sorted, compare);
    return sorted[SURVEY_ROUNDS / 2];
}

static double mean(const double *values)
{
    double sum = 0;
    for (int i = 0; i < SURVEY_ROUNDS; i++) sum += values[i] / SURVEY_ROUNDS;
    return sum;
}

static void finish(session *s)
{
    const rung_survey *v = &s->survey;
    const double full = median(v->ms[governor_full()]);
    governor_costs found;
    for (int i = 0; i < GOVERNOR_RUNGS; i++)
        found.cost[i] = median(v->ms[i]) / full, found.error[i] = mean(v->error[i]);
    governor_survey(&s->pace, &found);
    daft_image_destroy(s->survey.whole);
    daft_image_destroy(s->survey.reference);
    s->survey.whole = s->survey.reference = NULL;
}

/* What the measure takes beyond the frame: the rung's picture, and a row of tiles of the reference. */
static bool has_time(const session *s)
{
    const governor *g = &s->pace;
    const double frame = governor_slow_ms(g), rung = g->known.cost[s->survey.next % GOVERNOR_RUNGS];
    return g->frames > 0 && frame * (1 + rung / g->known.cost[g->rung] + 0.25) < ROOM * g->target_ms;
}

void session_survey(session *s, float alpha)
{
    rung_survey *v = &s->survey;
    const bool calm = s->pause.open;
    if (!s->governs || s->priced || s->play->failed || !s->picture || is_done(v)) return;
    if (governor_is_surveyed(&s->pace) || (!calm && (++v->wait < REST || !has_time(s)))) return;
    daft_error error;
    v->wait = 0;
    if (!fit(s, &v->whole, &error) || !fit(s, &v->reference, &error) ||
        !game_show(s->play, alpha, measure, s, &error)) {
        v->next = GOVERNOR_RUNGS * SURVEY_ROUNDS; /* the usual ladder will do */
        return;
    }
    v->next++;
    if (is_done(v)) finish(s);
}
