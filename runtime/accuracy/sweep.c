/* Drawing, timing and comparing the settings of a sweep. */
#include "accuracy/sweep.h"

#include "common/progress.h"
#include "common/quality.h"
#include "common/util.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GRID = 54, GRID_QUICK = 12, LEAST_ROUNDS = 2, GOOD_ROUNDS = 5, MOST_FACTOR = 4, TRIES = 3 };

/* Parts of a moment's time: what the reference may take; until when there may be new cells of the grid, new settings of
 * single knobs, and more than good rounds; what the rounds of one setting may take, and what one picture of it. What is
 * not timed once by LAST_SHARE is left out, so that a machine that becomes slow makes the report shorter and no later.
 */
static const double REFERENCE_SHARE = 0.3, COMPARE_SHARE = 0.55, SINGLES_SHARE = 0.75, TIME_SHARE = 0.85,
                    LAST_SHARE = 1.05, POINT_SHARE = 0.04, FEW_SHARE = 0.4, SLOWEST_SHARE = 0.06;

/* What is known of the moment at work. */
typedef struct sweep_work {
    int moment;
    bool shown;     /* the moment that the report shows */
    bool late;      /* there is no time left for this moment: it does not count */
    daft_view view; /* of the preset, now */
    double seconds; /* that the moment may take */
    uint64_t all_ns, began_ns;
    daft_image *image;
    daft_history *history;
    flip_picture *reference, *halves[2];
    float *change, *reference_change; /* FLIP of each pixel from the tick before; NULL: a scene */
    double seen_from;                 /* x of the last timed picture's camera, metres */
    progress_bar bar;
} sweep_work;

static double seconds_since(uint64_t began_ns) { return (double)(clock_now_ns() - began_ns) / 1e9; }

/* The part of the moment's time that is over. */
static double used(const sweep_result *s) { return seconds_since(s->work->began_ns) / s->work->seconds; }

static size_t bytes_of(const sweep_result *s) { return 4 * (size_t)s->def.width * (size_t)s->def.height; }

static bool is_game(const sweep_result *s) { return s->def.moments > 0; }

static flip_picture *prepare(const sweep_result *s, const uint8_t *pixels, daft_error *error)
{
    return flip_prepare(pixels, s->def.width, s->def.height, METRICS_PPD, error);
}

/* What the sweep's user holds fast. */
static daft_quality fix(const sweep_result *s, daft_quality quality)
{
    daft_error ignored;
    if (s->def.fixed) quality_parse(s->def.fixed, &quality, &ignored);
    return quality;
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

static daft_view view_of(const sweep_result *s, const daft_quality *quality)
{
    daft_view view = s->work->view;
    view.quality = *quality;
    return view;
}

/* Draws the picture of a point. */
static bool draw(sweep_result *s, const sweep_point *p, daft_error *error)
{
    const daft_view view = view_of(s, &p->quality);
    return daft_render(s->def.scene, &view, s->work->image, error);
}

/* Draws it for the time alone. Each such picture is seen from another point, the next number from the camera's, so that
 * they do not reuse what only a standing camera lets them keep. */
static daft_view moved_view(sweep_result *s, const sweep_point *p)
{
    daft_view view = view_of(s, &p->quality);
    view.camera.position.x = s->work->seen_from = nextafter(s->work->seen_from, INFINITY);
    return view;
}

static bool draw_timed(sweep_result *s, sweep_point *p, daft_error *error)
{
    const daft_view view = moved_view(s, p);
    sweep_measure *m = &p->at[s->work->moment];
    const uint64_t began = clock_now_ns();
    if (!daft_render(s->def.scene, &view, s->work->image, error)) return false;
    if (m->rounds < SWEEP_ROUNDS) m->times[m->rounds++] = (double)(clock_now_ns() - began) / 1e6;
    return true;
}

static bool draw_once(sweep_result *s, const daft_view *view, double *seconds, daft_error *error)
{
    const uint64_t began = clock_now_ns();
    if (!daft_render(s->def.scene, view, s->work->image, error)) return false;
    *seconds = seconds_since(began);
    return true;
}

/* FLIP of each pixel between the picture of the tick before and that of this one, as a game draws them. */
static bool find_change(sweep_result *s, const daft_quality *quality, float *map, daft_error *error)
{
    flip_picture *two[2] = {NULL, NULL};
    bool good = true;
    daft_history_forget(s->work->history);
    for (int k = 0; good && k < 2; k++) {
        daft_view view = view_of(s, quality);
        view.alpha = (float)k, view.camera = daft_scene_camera(s->def.scene, (float)k);
        view.history = s->work->history;
        good = daft_render(s->def.scene, &view, s->work->image, error) &&
               (two[k] = prepare(s, daft_image_pixels(s->work->image), error)) != NULL;
    }
    if (good) flip_compare(two[0], two[1], map);
    flip_free(two[0]);
    flip_free(two[1]);
    return good;
}

/* ---- the reference ----------------------------------------------------------------------------------------------- */

typedef struct reference_sum {
    double *light; /* 3 a pixel */
    double weight;
} reference_sum;

/* The values of quality reference, by rasterization: the same picture as its camera rays one by one, in a fraction of
 * the time. That it is the same is what the settings `quality reference` and `tree=bvh` show. A picture of many samples
 * a pixel needs a few rays for each of them where one of 16 needs many: time goes to more samples instead, which serve
 * edges as well. */
static daft_quality reference_quality(const sweep_result *s)
{
    daft_quality quality = daft_preset_quality(DAFT_PRESET_REFERENCE);
    quality.tree = DAFT_TREE_RASTER;
    quality.shadow_samples /= 4, quality.occlusion_samples /= 4, quality.glossy_samples /= 4;
    return fix(s, quality);
}

/* The mean of factor × factor pixels of 16 samples each, in linear light. */
static bool add_half(sweep_result *s, int factor, reference_sum *sum, uint8_t *half, daft_error *error)
{
    const daft_quality quality = reference_quality(s);
    const daft_view view = view_of(s, &quality);
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

static void finish_reference(const sweep_result *s, const reference_sum *sum, uint8_t *out)
{
    for (int i = 0; i < s->def.width * s->def.height; i++) {
        for (int c = 0; c < 3; c++) out[4 * i + c] = metrics_to_srgb(sum->light[3 * i + c] / sum->weight);
        out[4 * i + 3] = 255;
    }
}

/* The halves have f × f and (f+1) × (f+1) times as many pixels, so that they share no sample position. f is the largest
 * that there is time for, by what the slower of two pictures of one time as many takes. */
static bool choose_factor(sweep_result *s, int *factor, daft_error *error)
{
    const daft_quality quality = reference_quality(s);
    const daft_view view = view_of(s, &quality);
    double once, again, limit = REFERENCE_SHARE * s->work->seconds;
    if (!draw_once(s, &view, &once, error) || !draw_once(s, &view, &again, error)) return false;
    once = fmax(once, again);
    *factor = 1;
    while (*factor < MOST_FACTOR && once * ((*factor + 1) * (*factor + 1) + (*factor + 2) * (*factor + 2)) < limit)
        ++*factor;
    return true;
}

static void add_floor(sweep_result *s, const picture_errors *now)
{
    picture_errors *all = &s->floor;
    const double before = s->work->moment, after = before + 1;
    all->rmse = sqrt((all->rmse * all->rmse * before + now->rmse * now->rmse) / after);
    all->psnr = metrics_psnr(all->rmse);
    all->ssim = (all->ssim * before + now->ssim) / after, all->flip = (all->flip * before + now->flip) / after;
    all->worst = fmax(all->worst, now->worst);
}

static bool keep_reference(sweep_result *s, const uint8_t *whole, uint8_t *const halves[2], daft_error *error)
{
    sweep_work *w = s->work;
    picture_errors floor;
    if (!metrics_compare(halves[0], halves[1], s->def.width, s->def.height, NULL, &floor, error)) return false;
    add_floor(s, &floor);
    if (w->shown) memcpy(s->reference, whole, bytes_of(s));
    w->reference = prepare(s, whole, error);
    for (int k = 0; k < 2 && w->reference; k++) w->halves[k] = prepare(s, halves[k], error);
    const daft_quality quality = reference_quality(s);
    return w->reference && w->halves[0] && w->halves[1] &&
           (!is_game(s) || find_change(s, &quality, w->reference_change, error));
}

static bool make_reference(sweep_result *s, uint8_t *whole, daft_error *error)
{
    const size_t bytes = bytes_of(s);
    int factor;
    if (!choose_factor(s, &factor, error)) return false;
    reference_sum sum = {.light = calloc(bytes / 4 * 3, sizeof *sum.light)};
    uint8_t *halves[2] = {malloc(bytes), malloc(bytes)};
    bool good =
        (sum.light && halves[0] && halves[1]) || fail(error, DAFT_ERROR_MEMORY, "out of memory for the reference");
    for (int k = 0; good && k < 2; k++) {
        const int samples = 16 * (factor + k) * (factor + k);
        if (s->work->moment == 0 || samples < s->reference_samples[k]) s->reference_samples[k] = samples;
        good = add_half(s, factor + k, &sum, halves[k], error);
    }
    if (good) finish_reference(s, &sum, whole);
    good = good && keep_reference(s, whole, halves, error);
    free(sum.light);
    free(halves[0]);
    free(halves[1]);
    return good;
}

static void drop_reference(sweep_work *w)
{
    flip_free(w->reference);
    flip_free(w->halves[0]);
    flip_free(w->halves[1]);
    w->reference = w->halves[0] = w->halves[1] = NULL;
}

/* ---- settings ---------------------------------------------------------------------------------------------------- */

static sweep_point *add_point(sweep_result *s, const char *name, const char *setting, const daft_quality *quality)
{
    if (s->count == SWEEP_POINTS) return NULL;
    sweep_point *p = &s->points[s->count++];
    *p = (sweep_point){.knob = name, .quality = *quality, .same_as = -1, .beaten_by = -1};
    snprintf(p->setting, sizeof p->setting, "%s", setting);
    return p;
}

static daft_quality preset_of(const sweep_result *s) { return fix(s, daft_preset_quality(s->def.preset)); }

/* Pictures by camera rays one by one can take minutes where there is much to hit: the setting is left out then. */
static bool too_slow(sweep_result *s, double once)
{
    const bool slow = once > SLOWEST_SHARE * s->work->seconds;
    s->dropped += slow;
    return slow;
}

static void add_qualities(sweep_result *s)
{
    for (int i = DAFT_PRESET_DRAFT; i <= DAFT_PRESET_REFERENCE; i++) {
        const daft_preset preset = (daft_preset)i;
        const daft_quality quality = fix(s, daft_preset_quality(preset));
        if (preset == s->def.preset)
            s->preset = s->count;
        else if (s->def.knob)
            continue;
        else if (quality.tree != DAFT_TREE_RASTER && too_slow(s, quality.samples * s->ray_seconds))
            continue;
        add_point(s, "quality", daft_preset_name(preset), &quality);
    }
}

static bool add_knob(sweep_result *s, const knob_row *knob, daft_error *error)
{
    for (size_t i = 0; i < knob_count(knob); i++) {
        daft_quality quality = preset_of(s);
        if (knob_is_by_rays(knob->settings[i]) && too_slow(s, quality.samples * s->ray_seconds)) continue;
        if (!quality_parse(knob->settings[i], &quality, error)) return false;
        const daft_quality fixed = fix(s, quality);
        if (quality_equal(&quality, &fixed)) add_point(s, knob->name, knob->settings[i], &quality);
    }
    return true;
}

static bool add_singles(sweep_result *s, daft_error *error)
{
    if (s->def.knob) return add_knob(s, s->def.knob, error);
    for (size_t k = 0; k < KNOBS; k++)
        if (!add_knob(s, knob_at(k), error)) return false;
    return true;
}

/* How far the settings of a knob are apart, in FLIP. */
static double effect_of(const sweep_result *s, size_t k)
{
    double low = INFINITY, high = 0;
    for (size_t i = 0; i < s->count; i++) {
        if (s->points[i].knob != knob_at(k)->name) continue;
        const double flip = s->points[i].at[0].errors.flip;
        low = fmin(low, flip), high = fmax(high, flip);
    }
    return high - low;
}

/* Which knobs are part of the grid: those with the largest effects, as long as the grid is small enough. */
static size_t choose_grid(const sweep_result *s, size_t chosen[KNOBS])
{
    size_t count = 0, cells = 1, limit = s->def.quick ? GRID_QUICK : GRID;
    bool taken[KNOBS] = {false};
    for (;;) {
        size_t best = KNOBS;
        for (size_t k = 0; k < KNOBS; k++) {
            bool fits = !taken[k] && cells * knob_count(knob_at(k)) <= limit && effect_of(s, k) > 0;
            if (fits && (best == KNOBS || effect_of(s, k) > effect_of(s, best))) best = k;
        }
        if (best == KNOBS) return count;
        taken[best] = true;
        cells *= knob_count(knob_at(best));
        chosen[count++] = best;
    }
}

static bool add_cell(sweep_result *s, const size_t *chosen, size_t count, size_t cell, daft_error *error)
{
    daft_quality quality = preset_of(s);
    char setting[SETTING_TEXT] = "";
    for (size_t i = 0; i < count; i++) {
        const knob_row *knob = knob_at(chosen[i]);
        const char *text = knob->settings[cell % knob_count(knob)];
        cell /= knob_count(knob);
        const size_t length = strlen(setting);
        snprintf(setting + length, sizeof setting - length, "%s%s", i ? "," : "", text);
    }
    return quality_parse(setting, &quality, error) && add_point(s, "all", setting, &quality);
}

static bool add_grid(sweep_result *s, daft_error *error)
{
    size_t chosen[KNOBS], cells = 1, count = choose_grid(s, chosen);
    if (count < 2) return true; /* the singles are the grid */
    for (size_t i = 0; i < count; i++) cells *= knob_count(knob_at(chosen[i]));
    for (size_t cell = 0; cell < cells && s->count < SWEEP_POINTS; cell++)
        if (!add_cell(s, chosen, count, cell, error)) return false;
    return true;
}

/* ---- measuring --------------------------------------------------------------------------------------------------- */

static void show(sweep_result *s)
{
    progress_show(&s->work->bar, fmin(seconds_since(s->work->all_ns) / s->def.seconds, 1));
}

/* Many settings draw the picture of another: its errors are known. What is temporal is only where that is so always. */
static const sweep_measure *find_twin(const sweep_result *s, const sweep_point *p, uint64_t picture)
{
    for (const sweep_point *q = s->points; q < p; q++)
        if (q->at[s->work->moment].picture == picture) return &q->at[s->work->moment];
    return NULL;
}

static double mean_difference(const float *a, const float *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) sum += fabs((double)a[i] - (double)b[i]);
    return sum / (double)count;
}

static bool compare_picture(sweep_result *s, const uint8_t *pixels, const uint8_t *reference, sweep_measure *m,
                            daft_error *error)
{
    const int width = s->def.width, height = s->def.height;
    flip_picture *seen = prepare(s, pixels, error);
    if (!seen) return false;
    m->errors.rmse = metrics_rmse(pixels, reference, width, height);
    m->errors.psnr = metrics_psnr(m->errors.rmse);
    m->errors.flip = flip_compare(seen, s->work->reference, s->work->change);
    m->errors.worst = metrics_worst_tile(s->work->change, width, height);
    for (int k = 0; k < 2; k++) m->half_flip[k] = flip_compare(seen, s->work->halves[k], NULL);
    flip_free(seen);
    return metrics_ssim(pixels, reference, width, height, &m->errors.ssim, error);
}

static bool compare_one(sweep_result *s, sweep_point *p, const uint8_t *reference, daft_error *error)
{
    sweep_measure *m = &p->at[s->work->moment];
    if (!draw(s, p, error)) return false;
    const uint8_t *pixels = daft_image_pixels(s->work->image);
    const uint64_t picture = daft_hash(pixels, bytes_of(s), 0);
    const sweep_measure *twin = find_twin(s, p, picture);
    if (s->work->shown) {
        p->pixels = malloc(bytes_of(s));
        if (!p->pixels) return fail(error, DAFT_ERROR_MEMORY, "out of memory for pictures");
        memcpy(p->pixels, pixels, bytes_of(s));
    }
    if (twin) {
        *m = *twin;
        m->rounds = 0;
        return true;
    }
    m->picture = picture;
    if (!compare_picture(s, pixels, reference, m, error)) return false;
    if (!is_game(s)) return true;
    if (!find_change(s, &p->quality, s->work->change, error)) return false;
    m->temporal = mean_difference(s->work->change, s->work->reference_change, bytes_of(s) / 4);
    return true;
}

/* Settings up to this one are measured however long they take: the preset, and all that the user named. */
static size_t last_needed(const sweep_result *s)
{
    const bool own = s->def.knob && !knob_named(s->def.knob->name);
    return own ? s->count - 1 : s->preset;
}

/* Leaves out the settings from one on. At moments after the first all or none must be there: the moment is left out. */
static void leave_out(sweep_result *s, size_t from)
{
    if (from == s->count) return;
    s->work->late = s->work->moment > 0;
    if (s->work->late) return;
    s->dropped += s->count - from;
    for (size_t i = from; i < s->count; i++) free(s->points[i].pixels);
    s->count = from;
}

/* Draws the points from `first` on for the first time, and compares them with the reference. */
static bool compare(sweep_result *s, size_t first, const uint8_t *reference, daft_error *error)
{
    for (size_t i = first; i < s->count; i++) {
        show(s);
        if (!compare_one(s, &s->points[i], reference, error)) return false;
        if (i >= last_needed(s) && used(s) > (first > 0 ? COMPARE_SHARE : SINGLES_SHARE)) leave_out(s, i + 1);
        if (s->work->late) return true;
    }
    return true;
}

/* Whether there is time for one more of a point: slow ones may take their share and no more. */
static bool may_time(const sweep_result *s, const sweep_point *p)
{
    const sweep_measure *m = &p->at[s->work->moment];
    double taken = 0;
    for (int i = 0; i < m->rounds; i++) taken += m->times[i] / 1e3;
    if (m->rounds == 0) return true;
    if (m->rounds < LEAST_ROUNDS) return used(s) < 1;
    /* Few settings may take more than a small part each. */
    const double share = fmax(POINT_SHARE, FEW_SHARE / (double)s->count);
    return taken < share * s->work->seconds && used(s) < (m->rounds < GOOD_ROUNDS ? 1 : TIME_SHARE);
}

static bool time_all(sweep_result *s, daft_error *error)
{
    for (int round = 0; round < SWEEP_ROUNDS; round++) {
        for (size_t i = 0; i < s->count && !s->work->late; i++) {
            show(s);
            if (may_time(s, &s->points[i]) && !draw_timed(s, &s->points[i], error)) return false;
            if (round == 0 && i >= last_needed(s) && used(s) > LAST_SHARE) leave_out(s, i + 1);
        }
    }
    return true;
}

/* Of the fastest of some pictures: a machine at work makes any of them slow. */
static bool count_effects(sweep_result *s, const sweep_point *p, daft_error *error)
{
    const uint64_t began = clock_now_ns();
    for (int i = 0; i < GOOD_ROUNDS; i++) {
        const daft_view view = moved_view(s, p);
        if (!daft_render(s->def.scene, &view, s->work->image, error)) return false;
        const daft_counters *now = daft_scene_counters(s->def.scene);
        if (i == 0 || now->frame_ms < s->counters.frame_ms) s->counters = *now;
        if (seconds_since(began) > SLOWEST_SHARE * s->work->seconds) break;
    }
    return true;
}

/* What the report shows of one moment alone: the plan of the preset, and wrong pixels. */
static bool look_closely(sweep_result *s, daft_error *error)
{
    static const char *const SETTINGS[SWEEP_WRONG] = {"visibility=fast", "visibility=watertight"};
    if (!count_effects(s, &s->points[s->preset], error)) return false;
    for (int k = 0; k < SWEEP_WRONG; k++) {
        sweep_wrong *wrong = &s->wrong[k];
        daft_quality quality = preset_of(s);
        *wrong = (sweep_wrong){SETTINGS[k], 0, malloc(bytes_of(s) / 4)};
        if (!wrong->mask) return fail(error, DAFT_ERROR_MEMORY, "out of memory for wrong pixels");
        if (!quality_parse(SETTINGS[k], &quality, error)) return false;
        const daft_view view = view_of(s, &quality);
        if (!wrong_find(s->def.engine, s->def.scene, &view, s->def.width, s->def.height, wrong->mask, &wrong->count,
                        error))
            return false;
    }
    return true;
}

/* ---- moments ----------------------------------------------------------------------------------------------------- */

static bool find_points(sweep_result *s, const uint8_t *reference, daft_error *error)
{
    daft_view by_rays = s->work->view;
    by_rays.quality.tree = DAFT_TREE_BVH, by_rays.quality.samples = 1;
    s->ray_seconds = INFINITY;
    for (int i = 0; i < TRIES; i++) { /* the least: a machine at work makes any of them slow */
        double once;
        if (!draw_once(s, &by_rays, &once, error)) return false;
        s->ray_seconds = fmin(s->ray_seconds, once);
        if (s->ray_seconds > SLOWEST_SHARE * s->work->seconds) break;
    }
    add_qualities(s);
    if (!add_singles(s, error) || !compare(s, 0, reference, error)) return false;
    const size_t singles = s->count;
    return s->def.knob || (add_grid(s, error) && compare(s, singles, reference, error));
}

static bool measure_moment(sweep_result *s, daft_error *error)
{
    sweep_work *w = s->work;
    w->view = s->def.view;
    if (is_game(s)) w->view.camera = daft_scene_camera(s->def.scene, 1);
    w->view.quality = preset_of(s);
    w->shown = w->moment == 0; /* the one that is never late */
    w->began_ns = clock_now_ns(), w->seen_from = w->view.camera.position.x;
    uint8_t *reference = malloc(bytes_of(s));
    bool good = reference || fail(error, DAFT_ERROR_MEMORY, "out of memory for the reference");
    good = good && make_reference(s, reference, error) &&
           (w->moment == 0 ? find_points(s, reference, error) : compare(s, 0, reference, error)) &&
           time_all(s, error) && (!w->shown || w->late || look_closely(s, error));
    free(reference);
    drop_reference(w);
    return good;
}

static bool run(sweep_result *s, daft_error *error)
{
    const int wanted = is_game(s) ? s->def.moments : 1;
    s->work->seconds = s->def.seconds / wanted;
    for (s->work->moment = 0; s->work->moment < wanted; s->work->moment++) {
        show(s);
        if (is_game(s) && !s->def.next(s->def.user, error)) return false;
        if (!measure_moment(s, error)) return false;
        if (s->work->late) {
            s->moved_on = true;
            break;
        }
        s->moments++;
    }
    sweep_judge(s);
    return true;
}

static bool begin(sweep_result *s, daft_error *error)
{
    sweep_work *w = s->work;
    const size_t pixels = bytes_of(s) / 4;
    s->points = calloc(SWEEP_POINTS, sizeof *s->points);
    s->reference = malloc(bytes_of(s));
    w->change = malloc(pixels * sizeof *w->change), w->reference_change = malloc(pixels * sizeof *w->change);
    if (!s->points || !s->reference || !w->change || !w->reference_change)
        return fail(error, DAFT_ERROR_MEMORY, "out of memory for the settings");
    w->image = daft_image_create(s->def.engine, s->def.width, s->def.height, error);
    w->history = w->image ? daft_history_create(s->def.engine, error) : NULL;
    return w->history != NULL;
}

bool sweep_run(sweep_result *self, const sweep_def *def, daft_error *error)
{
    sweep_work work = {.all_ns = clock_now_ns()};
    *self = (sweep_result){.def = *def, .work = &work};
    progress_begin(&work.bar, "measuring");
    const bool good = begin(self, error) && run(self, error);
    progress_end(&work.bar);
    daft_image_destroy(work.image);
    daft_history_destroy(work.history);
    free(work.change);
    free(work.reference_change);
    self->work = NULL;
    if (!good) sweep_free(self);
    return good;
}

void sweep_free(sweep_result *self)
{
    for (size_t i = 0; i < self->count; i++) free(self->points[i].pixels);
    for (size_t i = 0; i < SWEEP_WRONG; i++) free(self->wrong[i].mask);
    free(self->points);
    free(self->reference);
}
