/* Measures of settings, one a frame. */
#include "accuracy/probe.h"

#include "accuracy/metrics.h"
#include "common/quality.h"
#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TILE = 32 };

void probe_begin(probe *self, daft_engine *engine) { *self = (probe){.engine = engine}; }

void probe_end(probe *self)
{
    daft_image_destroy(self->now);
    daft_image_destroy(self->other);
    self->now = self->other = NULL;
}

/* ---- one measure ------------------------------------------------------------------------------------------------- */

/* A golden-ratio sequence: however many places were taken, they are spread evenly. */
int probe_row_of(uint32_t turn, int rows)
{
    const double at = (turn + 1) * 0.6180339887498949;
    return (int)((at - floor(at)) * rows);
}

static bool draw(daft_scene *scene, const daft_view *view, daft_image *to, double *ms, daft_error *error)
{
    const uint64_t began = clock_now_ns();
    if (!daft_render(scene, view, to, error)) return false;
    *ms = (double)(clock_now_ns() - began) / 1e6;
    return true;
}

/* The window's pixels, one row after the other. */
static void copy_window(const daft_image *from, int left, int top, int width, int height, uint8_t *out)
{
    const uint8_t *pixels = daft_image_pixels((daft_image *)(uintptr_t)from);
    const size_t stride = 4 * (size_t)daft_image_width(from);
    for (int y = 0; y < height; y++)
        memcpy(out + 4 * (size_t)width * (size_t)y, pixels + stride * (size_t)(top + y) + 4 * (size_t)left,
               4 * (size_t)width);
}

bool probe_compare(const daft_image *a, const daft_image *b, int top, uint32_t turn, double *change, daft_error *error)
{
    uint8_t pixels[2][4 * PROBE_WIDTH * PROBE_HEIGHT];
    const int whole = daft_image_width(a), rest = daft_image_height(a) - top;
    const int width = whole < PROBE_WIDTH ? whole : PROBE_WIDTH, height = rest < PROBE_HEIGHT ? rest : PROBE_HEIGHT;
    const int left = probe_row_of(7 * turn + 3, whole - width + 1);
    copy_window(a, left, top, width, height, pixels[0]);
    copy_window(b, left, top, width, height, pixels[1]);
    *change = 0;
    if (memcmp(pixels[0], pixels[1], 4 * (size_t)width * (size_t)height) == 0) return true;
    flip_picture *one = flip_prepare(pixels[0], width, height, METRICS_PPD, error);
    flip_picture *two = one ? flip_prepare(pixels[1], width, height, METRICS_PPD, error) : NULL;
    if (two) *change = flip_compare(one, two, NULL);
    flip_free(one);
    flip_free(two);
    return two != NULL;
}

/* Draws both pictures in the order that the turn says: the second one is at an advantage. */
static bool measure(const probe *self, daft_scene *scene, const daft_view *view, const daft_quality *other,
                    uint32_t turn, double *ms, double *change, daft_error *error)
{
    daft_view views[2] = {*view, *view}, first;
    double taken[2], ignored;
    views[0].history = NULL, views[0].full = true;
    views[1] = first = views[0];
    views[1].quality = *other;
    /* The first picture of a frame also finds out what has moved: it does not count. */
    first.quality.scale = 0.1f;
    if (!draw(scene, &first, self->now, &ignored, error)) return false;
    for (uint32_t i = 0; i < 2; i++) {
        const uint32_t which = (i + turn) % 2;
        if (!draw(scene, &views[which], which ? self->other : self->now, &taken[which], error)) return false;
    }
    *ms = taken[1] - taken[0];
    const int rows = (daft_image_height(self->now) + TILE - 1) / TILE;
    return probe_compare(self->now, self->other, TILE * probe_row_of(turn, rows), turn, change, error);
}

/* ---- in turns ---------------------------------------------------------------------------------------------------- */

/* Fills in a knob's row: which of its settings is at hand, and those beside it. */
static bool fill_row(const daft_quality *quality, const knob_row *knob, probe_row *out, daft_error *error)
{
    *out = (probe_row){.knob = knob};
    const size_t count = knob_count(knob);
    for (size_t i = 0; i < count; i++) {
        daft_quality same = *quality;
        if (!quality_parse(knob->settings[i], &same, error)) return false;
        if (!quality_equal(&same, quality)) continue;
        out->now = knob->settings[i];
        out->cheaper.setting = i > 0 ? knob->settings[i - 1] : NULL;
        out->better.setting = i + 1 < count ? knob->settings[i + 1] : NULL;
    }
    return true;
}

static bool fit(daft_engine *engine, daft_image **image, int width, int height, daft_error *error)
{
    if (*image && daft_image_width(*image) == width && daft_image_height(*image) == height) return true;
    daft_image_destroy(*image);
    *image = daft_image_create(engine, width, height, error);
    return *image != NULL;
}

static bool begin_anew(probe *self, const daft_quality *quality, daft_error *error)
{
    self->quality = *quality;
    for (size_t k = 0; k < KNOBS; k++)
        if (!fill_row(quality, knob_at(k), &self->rows[k], error)) return false;
    return true;
}

/* The next setting that there is; a picture by camera rays one by one could take minutes. */
static probe_figure *next_figure(probe *self)
{
    for (size_t tried = 0; tried < 2 * KNOBS; tried++) {
        const uint32_t at = self->turn++ % (2 * KNOBS);
        probe_row *row = &self->rows[at / 2];
        probe_figure *figure = at % 2 ? &row->better : &row->cheaper;
        if (figure->setting && !knob_is_by_rays(figure->setting)) return figure;
    }
    return NULL;
}

bool probe_step(probe *self, daft_scene *scene, const daft_view *view, int width, int height, daft_error *error)
{
    const bool same = self->now && quality_equal(&view->quality, &self->quality) &&
                      daft_image_width(self->now) == width && daft_image_height(self->now) == height;
    if (!fit(self->engine, &self->now, width, height, error) || !fit(self->engine, &self->other, width, height, error))
        return false;
    if (!same && !begin_anew(self, &view->quality, error)) return false;
    probe_figure *figure = next_figure(self);
    daft_quality other = view->quality;
    double ms, change;
    if (!figure) return true;
    if (!quality_parse(figure->setting, &other, error) ||
        !measure(self, scene, view, &other, figure->count, &ms, &change, error))
        return false;
    const uint32_t slot = figure->count++ % PROBE_MEASURES;
    figure->ms[slot] = (float)ms, figure->change[slot] = (float)change;
    return true;
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

bool probe_sum(const probe_figure *figure, double *ms, double *uncertain, double *change)
{
    const uint32_t count = figure->count < PROBE_MEASURES ? figure->count : PROBE_MEASURES;
    if (count == 0) return false;
    float sorted[PROBE_MEASURES];
    memcpy(sorted, figure->ms, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_floats);
    const uint32_t from = count / 4, to = count - from;
    double sum = 0, squares = 0;
    for (uint32_t i = from; i < to; i++) sum += (double)sorted[i];
    *ms = sum / (to - from);
    for (uint32_t i = from; i < to; i++) squares += ((double)sorted[i] - *ms) * ((double)sorted[i] - *ms);
    *uncertain = sqrt(squares / (to - from)) / sqrt((double)(to - from));
    *change = 0;
    for (uint32_t i = 0; i < count; i++) *change += (double)figure->change[i] / count;
    return true;
}
