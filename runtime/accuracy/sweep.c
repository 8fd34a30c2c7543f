/* Drawing, timing and comparing the settings of a sweep. */
#include "accuracy/sweep.h"

#include "common/progress.h"
#include "common/util.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GRID = 54, GRID_QUICK = 12, LEAST_ROUNDS = 2, GOOD_ROUNDS = 5, MOST_FACTOR = 4 };

/* Parts of the time: what the reference may take; until when there may be new cells of the grid, and more than
 * good rounds; what the rounds of one setting may take, and what one picture of it. */
static const double REFERENCE_SHARE = 0.3, COMPARE_SHARE = 0.55, TIME_SHARE = 0.85, POINT_SHARE = 0.04,
                    SLOWEST_SHARE = 0.06;

static double seconds_since(uint64_t began_ns) { return (double)(clock_now_ns() - began_ns) / 1e9; }

static size_t bytes_of(const sweep_result *s) { return 4 * (size_t)s->def.width * (size_t)s->def.height; }

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

/* Bilinear between the centres of the drawn pixels, of the encoded bytes, as a window shows a smaller picture. */
static void enlarge(daft_image *from, uint8_t *to, int width, int height)
{
    int w = daft_image_width(from), h = daft_image_height(from);
    const uint8_t *pixels = daft_image_pixels(from);
    for (int i = 0; i < width * height; i++) {
        double x = fmax((i % width + 0.5) * w / width - 0.5, 0), y = fmax((i / width + 0.5) * h / height - 0.5, 0);
        int x0 = (int)x, y0 = (int)y, x1 = x0 + 1 < w ? x0 + 1 : x0, y1 = y0 + 1 < h ? y0 + 1 : y0;
        double fx = x - x0, fy = y - y0;
        for (int c = 0; c < 4; c++) {
            double top = pixels[4 * (y0 * w + x0) + c] * (1 - fx) + pixels[4 * (y0 * w + x1) + c] * fx;
            double low = pixels[4 * (y1 * w + x0) + c] * (1 - fx) + pixels[4 * (y1 * w + x1) + c] * fx;
            to[4 * i + c] = (uint8_t)(top * (1 - fy) + low * fy + 0.5);
        }
    }
}

int sweep_side(int side, double scale)
{
    int drawn = (int)(side * scale + 0.5);
    return drawn < 1 ? 1 : drawn;
}

/* The picture of a size, kept: memory that is new to the process would be part of the time. */
static daft_image *target_of(sweep_result *s, int width, int height, daft_error *error)
{
    daft_image **target = NULL;
    for (size_t i = 0; i < COUNT_OF(s->targets); i++) {
        target = &s->targets[i];
        if (!*target) return *target = daft_image_create(s->def.engine, width, height, error);
        if (daft_image_width(*target) == width && daft_image_height(*target) == height) return *target;
    }
    daft_image_destroy(*target); /* more sizes than places: the last one is shared */
    return *target = daft_image_create(s->def.engine, width, height, error);
}

static bool keep_picture(const sweep_result *s, sweep_point *p, daft_image *image, daft_error *error)
{
    p->pixels = malloc(bytes_of(s));
    if (!p->pixels) return fail(error, DAFT_ERROR_MEMORY, "out of memory for pictures");
    enlarge(image, p->pixels, s->def.width, s->def.height);
    return true;
}

/* Draws once: the first time for the picture, later for the time. Timed pictures are each seen from another point, the
 * next number from the camera's, so that they do not reuse what only a standing camera lets them keep. */
static bool draw(sweep_result *s, sweep_point *p, daft_error *error)
{
    int width = sweep_side(s->def.width, p->set.scale), height = sweep_side(s->def.height, p->set.scale);
    daft_image *image = target_of(s, width, height, error);
    daft_view view = p->set.view;
    if (!image) return false;
    if (p->pixels) view.camera.position.x = s->seen_from = nextafter(s->seen_from, INFINITY);
    uint64_t began = clock_now_ns();
    if (!daft_render(s->def.scene, &view, image, error)) return false;
    double ms = (double)(clock_now_ns() - began) / 1e6;
    if (!p->pixels) return keep_picture(s, p, image, error);
    if (p->rounds < SWEEP_ROUNDS) p->times[p->rounds++] = ms;
    return true;
}

/* ---- the reference ----------------------------------------------------------------------------------------------- */

typedef struct reference_sum {
    double *light; /* 3 a pixel */
    double weight;
} reference_sum;

/* The values of quality reference, by rasterization: the same picture as its camera rays one by one, in a fraction of
 * the time. That it is the same is what the settings `quality reference` and `reference=1` show. */
static daft_view reference_view(const sweep_result *s)
{
    daft_view view = s->def.view;
    view.quality = DAFT_QUALITY_GAME;
    view.samples = 16, view.mirror_depth = 10, view.refraction_depth = 24, view.min_weight = 1.0f / 4096,
    view.shadows = 1;
    return view;
}

/* The mean of factor × factor pixels of 16 samples each, in linear light. */
static bool add_half(sweep_result *s, int factor, reference_sum *sum, uint8_t *half, daft_error *error)
{
    daft_view view = reference_view(s);
    daft_image *image = daft_image_create(s->def.engine, s->def.width * factor, s->def.height * factor, error);
    if (!image || !daft_render(s->def.scene, &view, image, error)) {
        daft_image_destroy(image);
        return false;
    }
    double linear[256], area = factor * factor;
    for (int i = 0; i < 256; i++) linear[i] = metrics_to_linear((uint8_t)i);
    const uint8_t *pixels = daft_image_pixels(image);
    for (int i = 0; i < s->def.width * s->def.height; i++) {
        double light[3] = {0};
        int left = i % s->def.width * factor, top = i / s->def.width * factor;
        for (int k = 0; k < factor * factor; k++) {
            const uint8_t *p = pixels + 4 * ((size_t)(top + k / factor) * (size_t)(s->def.width * factor) +
                                             (size_t)(left + k % factor));
            for (int c = 0; c < 3; c++) light[c] += linear[p[c]];
        }
        for (int c = 0; c < 3; c++) {
            half[4 * i + c] = metrics_to_srgb(light[c] / area);
            sum->light[3 * i + c] += light[c];
        }
        half[4 * i + 3] = 255;
    }
    sum->weight += area;
    daft_image_destroy(image);
    return true;
}

static void finish_reference(sweep_result *s, const reference_sum *sum)
{
    for (int i = 0; i < s->def.width * s->def.height; i++) {
        for (int c = 0; c < 3; c++) s->reference[4 * i + c] = metrics_to_srgb(sum->light[3 * i + c] / sum->weight);
        s->reference[4 * i + 3] = 255;
    }
}

static bool draw_once(sweep_result *s, const daft_view *view, double *seconds, daft_error *error)
{
    daft_image *image = target_of(s, s->def.width, s->def.height, error);
    uint64_t began = clock_now_ns();
    if (!image || !daft_render(s->def.scene, view, image, error)) return false;
    *seconds = seconds_since(began);
    return true;
}

/* The halves have f × f and (f+1) × (f+1) times as many pixels, so that they share no sample position. f is the largest
 * that there is time for, by what a picture of one time as many takes. */
static bool choose_factor(sweep_result *s, int *factor, daft_error *error)
{
    daft_view view = reference_view(s);
    double once, limit = REFERENCE_SHARE * s->def.seconds;
    if (!draw_once(s, &view, &once, error)) return false;
    *factor = 1;
    while (*factor < MOST_FACTOR && once * ((*factor + 1) * (*factor + 1) + (*factor + 2) * (*factor + 2)) < limit)
        ++*factor;
    return true;
}

static bool make_reference(sweep_result *s, daft_error *error)
{
    size_t bytes = bytes_of(s);
    int factor;
    if (!choose_factor(s, &factor, error)) return false;
    reference_sum sum = {.light = calloc(bytes / 4 * 3, sizeof *sum.light)};
    s->halves[0] = malloc(bytes), s->halves[1] = malloc(bytes);
    s->reference = malloc(bytes);
    bool good = (sum.light && s->halves[0] && s->halves[1] && s->reference) ||
                fail(error, DAFT_ERROR_MEMORY, "out of memory for the reference");
    for (int k = 0; good && k < 2; k++) {
        s->reference_samples[k] = 16 * (factor + k) * (factor + k);
        good = add_half(s, factor + k, &sum, s->halves[k], error);
    }
    if (good) finish_reference(s, &sum);
    good = good && metrics_compare(s->halves[0], s->halves[1], s->def.width, s->def.height, NULL, &s->floor, error);
    free(sum.light);
    return good;
}

/* ---- settings ---------------------------------------------------------------------------------------------------- */

static sweep_point *add_point(sweep_result *s, const char *name, const char *setting, const knob_set *set)
{
    if (s->count == SWEEP_POINTS) return NULL;
    sweep_point *p = &s->points[s->count++];
    *p = (sweep_point){.knob = name, .set = *set, .same_as = -1, .beaten_by = -1};
    snprintf(p->setting, sizeof p->setting, "%s", setting);
    return p;
}

static knob_set preset_of(const sweep_result *s) { return (knob_set){.view = s->def.view, .scale = 1}; }

/* Pictures by camera rays one by one can take minutes where there is much to hit: the setting is left out then. */
static bool too_slow(sweep_result *s, double once)
{
    bool slow = once > SLOWEST_SHARE * s->def.seconds;
    s->dropped += slow;
    return slow;
}

static void add_qualities(sweep_result *s)
{
    for (int q = DAFT_QUALITY_DRAFT; q <= DAFT_QUALITY_REFERENCE; q++) {
        if (q == DAFT_QUALITY_REFERENCE && too_slow(s, 16 * s->ray_seconds)) continue;
        knob_set set = preset_of(s);
        if (set.view.quality == (daft_quality)q) s->preset = s->count;
        set.view.quality = (daft_quality)q;
        add_point(s, "quality", daft_quality_name((daft_quality)q), &set);
    }
}

static void add_singles(sweep_result *s)
{
    for (size_t k = 0; k < KNOBS; k++) {
        const knob_row *knob = knob_at(k);
        for (size_t i = 0; i < knob->count; i++) {
            knob_set set = preset_of(s);
            char text[KNOB_TEXT];
            if (knob_is_by_rays(k, knob->values[i]) && too_slow(s, s->ray_seconds)) continue;
            knob_apply(&set, k, knob->values[i]);
            add_point(s, knob->name, knob_print(text, k, knob->values[i]), &set);
        }
    }
}

/* How far the settings of a knob are apart, in FLIP. */
static double effect_of(const sweep_result *s, size_t k)
{
    double low = INFINITY, high = 0;
    for (size_t i = 0; i < s->count; i++) {
        if (s->points[i].knob != knob_at(k)->name) continue;
        low = fmin(low, s->points[i].errors.flip), high = fmax(high, s->points[i].errors.flip);
    }
    return high - low;
}

/* Which knobs are part of the grid: those with the largest effects, as long as the grid is small enough. */
static size_t choose_grid(const sweep_result *s, size_t chosen[KNOBS])
{
    size_t count = 0, cells = 1, limit = s->def.quick ? GRID_QUICK : GRID;
    bool used[KNOBS] = {false};
    for (;;) {
        size_t best = KNOBS;
        for (size_t k = 0; k < KNOBS; k++) {
            bool fits = !used[k] && cells * knob_at(k)->count <= limit && effect_of(s, k) > 0;
            if (fits && (best == KNOBS || effect_of(s, k) > effect_of(s, best))) best = k;
        }
        if (best == KNOBS) return count;
        used[best] = true;
        cells *= knob_at(best)->count;
        chosen[count++] = best;
    }
}

static void add_cell(sweep_result *s, const size_t *chosen, size_t count, size_t cell)
{
    knob_set set = preset_of(s);
    char setting[SETTING_TEXT] = "";
    for (size_t i = 0; i < count; i++) {
        const knob_row *knob = knob_at(chosen[i]);
        double value = knob->values[cell % knob->count];
        char text[KNOB_TEXT];
        cell /= knob->count;
        knob_apply(&set, chosen[i], value);
        size_t used = strlen(setting);
        snprintf(setting + used, sizeof setting - used, "%s%s", i ? "," : "", knob_print(text, chosen[i], value));
    }
    add_point(s, "all", setting, &set);
}

static void add_grid(sweep_result *s)
{
    size_t chosen[KNOBS], cells = 1, count = choose_grid(s, chosen);
    if (count < 2) return; /* the singles are the grid */
    for (size_t i = 0; i < count; i++) cells *= knob_at(chosen[i])->count;
    for (size_t cell = 0; cell < cells; cell++) add_cell(s, chosen, count, cell);
}

/* ---- measuring --------------------------------------------------------------------------------------------------- */

static void show(const sweep_result *s, progress_bar *bar)
{
    progress_show(bar, fmin(seconds_since(s->began_ns) / s->def.seconds, 1));
}

/* Many settings draw the picture of another: its errors are known. */
static const sweep_point *find_twin(const sweep_result *s, const sweep_point *p)
{
    for (const sweep_point *q = s->points; q < p; q++)
        if (q->picture == p->picture) return q;
    return NULL;
}

static bool compare_one(const sweep_result *s, sweep_point *p, daft_error *error)
{
    int width = s->def.width, height = s->def.height;
    p->picture = daft_hash(p->pixels, bytes_of(s), 0);
    const sweep_point *twin = find_twin(s, p);
    if (twin) {
        p->errors = twin->errors;
        memcpy(p->half_flip, twin->half_flip, sizeof p->half_flip);
        return true;
    }
    return metrics_compare(p->pixels, s->reference, width, height, NULL, &p->errors, error) &&
           metrics_mean_flip(p->pixels, s->halves[0], width, height, &p->half_flip[0], error) &&
           metrics_mean_flip(p->pixels, s->halves[1], width, height, &p->half_flip[1], error);
}

/* Draws the points from `first` on for the first time, and compares them with the reference. */
static bool compare(sweep_result *s, size_t first, progress_bar *bar, daft_error *error)
{
    for (size_t i = first; i < s->count; i++) {
        sweep_point *p = &s->points[i];
        show(s, bar);
        if (!draw(s, p, error) || !compare_one(s, p, error)) return false;
        /* Cells of the grid that no time is left for are dropped; single knobs never. */
        if (first > 0 && seconds_since(s->began_ns) > COMPARE_SHARE * s->def.seconds) {
            s->dropped += s->count - (i + 1);
            s->count = i + 1;
        }
    }
    return true;
}

/* Whether there is time for one more of a point: twice always, since one time has no spread; slow ones may take their
 * share and no more. */
static bool may_time(const sweep_result *s, const sweep_point *p)
{
    double used = seconds_since(s->began_ns) / s->def.seconds, taken = 0;
    for (int i = 0; i < p->rounds; i++) taken += p->times[i] / 1e3;
    if (p->rounds < LEAST_ROUNDS) return true;
    return taken < POINT_SHARE * s->def.seconds && used < (p->rounds < GOOD_ROUNDS ? 1 : TIME_SHARE);
}

static bool time_all(sweep_result *s, progress_bar *bar, daft_error *error)
{
    for (int round = 0; round < SWEEP_ROUNDS; round++) {
        for (size_t i = 0; i < s->count; i++) {
            show(s, bar);
            if (may_time(s, &s->points[i]) && !draw(s, &s->points[i], error)) return false;
        }
    }
    return true;
}

static bool run(sweep_result *s, progress_bar *bar, daft_error *error)
{
    daft_view by_rays = s->def.view;
    by_rays.reference = true;
    if (!draw_once(s, &by_rays, &s->ray_seconds, error) || !make_reference(s, error)) return false;
    add_qualities(s);
    add_singles(s);
    if (!compare(s, 0, bar, error)) return false;
    size_t singles = s->count;
    add_grid(s);
    if (!compare(s, singles, bar, error) || !time_all(s, bar, error)) return false;
    sweep_judge(s);
    return true;
}

bool sweep_run(sweep_result *self, const sweep_def *def, daft_error *error)
{
    progress_bar bar;
    *self = (sweep_result){.def = *def, .seen_from = def->view.camera.position.x, .began_ns = clock_now_ns()};
    self->points = calloc(SWEEP_POINTS, sizeof *self->points);
    progress_begin(&bar, "measuring");
    bool good =
        self->points ? run(self, &bar, error) : fail(error, DAFT_ERROR_MEMORY, "out of memory for the settings");
    progress_end(&bar);
    if (!good) sweep_free(self);
    return good;
}

void sweep_free(sweep_result *self)
{
    for (size_t i = 0; i < self->count; i++) free(self->points[i].pixels);
    for (size_t i = 0; i < COUNT_OF(self->targets); i++) daft_image_destroy(self->targets[i]);
    free(self->points);
    free(self->reference);
    free(self->halves[0]);
    free(self->halves[1]);
}
