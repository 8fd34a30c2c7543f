/* Rows `antialiasing, NAME`: each scene of assets/scenes, and each game in its demo, at 1280x720: pictures of one
 * sample a pixel and sixteen where it changes from one pixel to the next, by several contrasts, beside one of eight
 * samples everywhere: milliseconds, and how far they are from the reference, as `daft cost --settings` measures them,
 * in turns; a game at two moments. The row is of the cheapest contrast with both errors no larger than those of eight
 * samples; if none has, of the one that comes nearest. What is sampled otherwise is held fast, since eight samples a
 * pixel ask a lamp or the sky eight times as well, which is another knob's matter, as is the filter of textures.
 *
 * Rows `pan, NAME`: each scene at 320x180, or half of it where that takes long, by a camera that turns by 0.4 of a
 * pixel from one frame to the next, 120 frames long: how much more, or less, the picture changes from frame to frame
 * than the reference's, 16 samples everywhere: the mean over pixels and frames of |FLIP of two frames - FLIP of the
 * reference's|, which is what shimmers. Beside it stands that of eight samples everywhere; the same is held fast as
 * above. */
#include "frames/users.h"

#include "accuracy/metrics.h"
#include "common/quality.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- a picture --------------------------------------------------------------------------------------------------- */

typedef struct edge_point {
    double ms, rmse, flip;
} edge_point;

/* The figures of a setting in points.csv: scene,knob,"setting",ms,spread,rmse,psnr,ssim,flip,front. */
static bool find_point(const char *csv, const char *setting, edge_point *out)
{
    double spread, psnr, ssim;
    char key[128];
    snprintf(key, sizeof key, "own,\"%s\",", setting);
    const char *at = strstr(csv, key);
    return at && sscanf(at + strlen(key), "%lf,%lf,%lf,%lf,%lf,%lf", &out->ms, &spread, &out->rmse, &psnr, &ssim,
                        &out->flip) == 6;
}

#define AT_EDGES   "samples=1,edge_samples=16,edge_contrast="
#define EVERYWHERE "samples=8,edge_samples=0"
static const char *const CONTRASTS[] = {"0.25", "0.4", "0.55", "0.7", "0.8", "0.9", "1", "1.4", "1.7"};
#define FIXED                                                                                                          \
    "shadow_samples=0,occlusion_samples=0,glossy_samples=0,denoise=off,mirror_depth=2,refraction_depth=12,"            \
    "min_weight=1/2048,texture_filter=trilinear"

static char *run_cost(bench *self, const char *what, int threads)
{
    char command[2048], settings[768] = EVERYWHERE, folder[64] = "/tmp/daft-edges-XXXXXX", path[128];
    size_t size, used = strlen(settings);
    if (!mkdtemp(folder)) return NULL;
    for (size_t i = 0; i < sizeof CONTRASTS / sizeof *CONTRASTS; i++)
        used += (size_t)snprintf(settings + used, sizeof settings - used, ";" AT_EDGES "%s", CONTRASTS[i]);
    snprintf(command, sizeof command,
             "cd '%s' && '%s' cost '%s' --settings '%s' --knobs " FIXED
             " --size 1280x720 --no-pictures --threads %d --isa %s -o %s >/dev/null 2>&1",
             DAFT_ROOT, DAFT_PROGRAM, what, settings, threads, self->isa, folder);
    const bool good = system(command) == 0;
    snprintf(path, sizeof path, "%s/points.csv", folder);
    char *csv = good ? daft_file_read(&self->allocator, NULL, path, &size, NULL) : NULL;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    if (system(command) != 0) bench_note(self, false, "%s is left", folder);
    return csv;
}

/* By how much the larger of the errors is more than eight samples'; negative: none is. */
static double excess(const edge_point *p, const edge_point *peer)
{
    return fmax(p->rmse / peer->rmse, p->flip / peer->flip) - 1;
}

/* The contrast of the row; NULL: a setting is missing. */
static const char *choose_contrast(const char *csv, const edge_point *peer, edge_point *out)
{
    const char *chosen = NULL;
    for (size_t i = 0; i < sizeof CONTRASTS / sizeof *CONTRASTS; i++) {
        char setting[96];
        edge_point p;
        snprintf(setting, sizeof setting, AT_EDGES "%s", CONTRASTS[i]);
        if (!find_point(csv, setting, &p)) return NULL;
        const double more = fmax(0, excess(&p, peer)), most = chosen ? fmax(0, excess(out, peer)) : INFINITY;
        if (more < most || (more <= most && p.ms < out->ms)) *out = p, chosen = CONTRASTS[i];
    }
    return chosen;
}

static void measure_picture(bench *self, const char *name, const char *what, int threads)
{
    bench_row row = {
        .unit = "ms", .isa = self->isa, .threads = threads, .peer_name = "8 samples", .budget = {.floor = 1 / 0.35}};
    edge_point ours = {0}, peer;
    fprintf(stderr, "%s, %d thread%s\n", name, threads, threads == 1 ? "" : "s");
    char *csv = run_cost(self, what, threads);
    const char *contrast = csv && find_point(csv, EVERYWHERE, &peer) ? choose_contrast(csv, &peer, &ours) : NULL;
    if (!contrast) {
        bench_note(self, true, "%s failed", name);
    } else {
        snprintf(row.scene, sizeof row.scene, "%s", name);
        snprintf(row.what, sizeof row.what, "16 at edges");
        row.ours = ours.ms, row.peer = peer.ms;
        snprintf(row.counters, sizeof row.counters,
                 "contrast %s, %.1f %% of the time; RMSE %.4f, of 8 everywhere %.4f; FLIP %.4f, %.4f%s", contrast,
                 100 * ours.ms / peer.ms, ours.rmse, peer.rmse, ours.flip, peer.flip,
                 excess(&ours, &peer) > 0 ? "; an error is larger" : "");
        bench_add(self, &row);
    }
    daft_release(&self->allocator, csv);
}

/* ---- a pan ------------------------------------------------------------------------------------------------------- */

enum { WIDTH = 320, HEIGHT = 180, FRAMES = 120, KINDS = 5 /* the last is the reference */ };

/* A frame of the reference that takes longer: the picture is of half the size. Milliseconds. */
static const double SLOW_MS = 200;

typedef struct pan_show {
    users_show show;
    int width, height;
    flip_picture *before[KINDS];
    float *change[KINDS]; /* of each pixel, from the frame before */
    double flicker[KINDS];
} pan_show;

static daft_view view_of(const pan_show *p, int kind, int frame)
{
    static const struct {
        int samples, edges;
    } KINDS_OF[KINDS] = {{1, 0}, {1, 4}, {1, 16}, {8, 0}, {16, 0}};
    daft_view view = p->show.view;
    view.quality.samples = KINDS_OF[kind].samples, view.quality.edge_samples = KINDS_OF[kind].edges;
    view.camera.yaw += 0.4f * view.camera.fov / (float)p->width * (float)frame;
    return view;
}

/* Halves the picture where the reference would take minutes. */
static bool choose_size(pan_show *p, daft_error *error)
{
    daft_view view = view_of(p, KINDS - 1, 0);
    p->width = WIDTH, p->height = HEIGHT;
    if (users_draw(&p->show, &view, error) < 0) return false;
    view.full = true;
    const double ms = users_draw(&p->show, &view, error);
    if (ms < 0 || ms <= SLOW_MS) return ms >= 0;
    p->width /= 2, p->height /= 2;
    daft_image_destroy(p->show.image);
    p->show.image = daft_image_create(p->show.engine, p->width, p->height, error);
    return p->show.image != NULL;
}

static bool open_pan(bench *self, const char *path, int threads, pan_show *p, daft_error *error)
{
    *p = (pan_show){.width = WIDTH};
    bool good = users_open(self, path, threads, WIDTH, HEIGHT, &p->show, error) &&
                quality_parse(FIXED, &p->show.view.quality, error) && choose_size(p, error);
    for (int k = 0; k < KINDS; k++)
        good = good && (p->change[k] = malloc((size_t)WIDTH * HEIGHT * sizeof *p->change[k])) != NULL;
    return good;
}

static void close_pan(pan_show *p)
{
    for (int k = 0; k < KINDS; k++) flip_free(p->before[k]), free(p->change[k]);
    users_close(&p->show);
}

/* Draws the frame in one way, and finds out how it has changed. */
static bool pan_one(pan_show *p, int kind, int frame, daft_error *error)
{
    const daft_view view = view_of(p, kind, frame);
    if (users_draw(&p->show, &view, error) < 0) return false;
    flip_picture *now = flip_prepare(daft_image_pixels(p->show.image), p->width, p->height, METRICS_PPD, error);
    if (now && p->before[kind]) flip_compare(p->before[kind], now, p->change[kind]);
    flip_free(p->before[kind]);
    p->before[kind] = now;
    return now != NULL;
}

static void add_flicker(pan_show *p)
{
    const int pixels = p->width * p->height;
    for (int k = 0; k + 1 < KINDS; k++) {
        double sum = 0;
        for (int i = 0; i < pixels; i++) sum += fabs((double)p->change[k][i] - (double)p->change[KINDS - 1][i]);
        p->flicker[k] += sum / pixels / (FRAMES - 1);
    }
}

static void measure_pan(bench *self, const char *name, const char *path, int threads)
{
    pan_show p;
    daft_error error = {0};
    char text[1200];
    fprintf(stderr, "%s, %d thread%s\n", name, threads, threads == 1 ? "" : "s");
    bool good = open_pan(self, path, threads, &p, &error);
    for (int i = 0; good && i < FRAMES; i++) {
        for (int k = 0; good && k < KINDS; k++) good = pan_one(&p, k, i, &error);
        if (good && i > 0) add_flicker(&p);
    }
    bench_row row = {
        .unit = "FLIP", .isa = self->isa, .threads = threads, .peer_name = "8 samples", .budget = {.floor = 1}};
    snprintf(row.scene, sizeof row.scene, "%s", name);
    snprintf(row.what, sizeof row.what, "flicker, 16 at edges");
    row.ours = p.flicker[2], row.peer = p.flicker[3];
    snprintf(row.counters, sizeof row.counters, "%dx%d; one sample %.4f; 4 at edges, as game draws it, %.4f", p.width,
             p.height, p.flicker[0], p.flicker[1]);
    if (good)
        bench_add(self, &row);
    else
        bench_note(self, true, "%s: %s", name, daft_error_text(&error, text, sizeof text));
    close_pan(&p);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static void measure_all(bench *self, bool games, int threads)
{
    struct dirent **found;
    const int count = scandir(games ? DAFT_ROOT "/games" : DAFT_ROOT "/assets/scenes", &found,
                              games ? users_has_demo : users_is_scene, alphasort);
    for (int i = 0; i < count; i++) {
        char name[64], path[512];
        const char *file = found[i]->d_name;
        const int length = (int)strcspn(file, ".");
        snprintf(path, sizeof path, games ? "%.0s%.200s" : "%s/assets/scenes/%.200s", DAFT_ROOT, file);
        snprintf(name, sizeof name, "antialiasing, %.*s", length, file);
        if (bench_wants(self, name, "16 at edges")) measure_picture(self, name, path, threads);
        snprintf(name, sizeof name, "pan, %.*s", length, file);
        if (!games && bench_wants(self, name, "flicker, 16 at edges")) measure_pan(self, name, path, threads);
        free(found[i]);
    }
    if (count >= 0) free(found);
}

void bench_edges(bench *self)
{
    int counts[2], count = bench_thread_counts(self, counts);
    measure_all(self, false, counts[count - 1]);
    measure_all(self, true, counts[count - 1]);
}
