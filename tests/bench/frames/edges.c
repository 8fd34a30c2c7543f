/* Rows `antialiasing, NAME`: each scene of assets/scenes, and each game at four moments of its demo, at 1280x720: a
 * picture of one sample a pixel and sixteen where it changes from one pixel to the next, beside one of eight samples
 * everywhere: milliseconds, and how far both are from the reference, as `daft cost --knob antialiasing` measures them,
 * in turns. What is sampled otherwise is held fast, since eight samples a pixel ask a lamp or the sky eight times as
 * well, which is another knob's matter, as is the filter of textures.
 *
 * Rows `pan, NAME`: each scene at 640x360 by a camera that turns by 0.4 of a pixel from one frame to the next, 120
 * frames long: how much more, or less, the picture changes from frame to frame than the reference's, 16 samples
 * everywhere: the mean over pixels and frames of |FLIP of two frames - FLIP of the reference's|, which is what
 * shimmers. Beside it stands that of eight samples everywhere. */
#include "frames/users.h"

#include "accuracy/metrics.h"

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
    char key[96];
    snprintf(key, sizeof key, "antialiasing,\"%s\",", setting);
    const char *at = strstr(csv, key);
    return at && sscanf(at + strlen(key), "%lf,%lf,%lf,%lf,%lf,%lf", &out->ms, &spread, &out->rmse, &psnr, &ssim,
                        &out->flip) == 6;
}

#define FIXED                                                                                                          \
    "shadow_samples=0,occlusion_samples=0,glossy_samples=0,denoise=off,mirror_depth=2,refraction_depth=12,"            \
    "min_weight=1/2048,texture_filter=trilinear"

static char *run_cost(bench *self, const char *what, int threads)
{
    char command[1400], folder[64] = "/tmp/daft-edges-XXXXXX", path[128];
    size_t size;
    if (!mkdtemp(folder)) return NULL;
    snprintf(command, sizeof command,
             "cd '%s' && '%s' cost '%s' --knob antialiasing --knobs " FIXED
             " --size 1280x720 --no-pictures --threads %d --isa %s -o %s >/dev/null 2>&1",
             DAFT_ROOT, DAFT_PROGRAM, what, threads, self->isa, folder);
    const bool good = system(command) == 0;
    snprintf(path, sizeof path, "%s/points.csv", folder);
    char *csv = good ? daft_file_read(&self->allocator, NULL, path, &size, NULL) : NULL;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    if (system(command) != 0) bench_note(self, false, "%s is left", folder);
    return csv;
}

static void measure_picture(bench *self, const char *name, const char *what, int threads)
{
    bench_row row = {
        .unit = "ms", .isa = self->isa, .threads = threads, .peer_name = "8 samples", .budget = {.floor = 1 / 0.35}};
    edge_point ours, peer;
    fprintf(stderr, "%s, %d thread%s\n", name, threads, threads == 1 ? "" : "s");
    char *csv = run_cost(self, what, threads);
    if (!csv || !find_point(csv, "samples=1,edge_samples=16", &ours) ||
        !find_point(csv, "samples=8,edge_samples=0", &peer)) {
        bench_note(self, true, "%s failed", name);
    } else {
        snprintf(row.scene, sizeof row.scene, "%s", name);
        snprintf(row.what, sizeof row.what, "16 at edges");
        row.ours = ours.ms, row.peer = peer.ms;
        snprintf(row.counters, sizeof row.counters, "RMSE %.4f, of 8 everywhere %.4f; FLIP %.4f, %.4f", ours.rmse,
                 peer.rmse, ours.flip, peer.flip);
        bench_add(self, &row);
    }
    daft_release(&self->allocator, csv);
}

/* ---- a pan ------------------------------------------------------------------------------------------------------- */

enum { WIDTH = 640, HEIGHT = 360, FRAMES = 120, KINDS = 5 /* the last is the reference */ };

typedef struct pan_show {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    flip_picture *before[KINDS];
    float *change[KINDS]; /* of each pixel, from the frame before */
    double flicker[KINDS];
} pan_show;

static void ignore(void *user, const daft_error *warning) { (void)user, (void)warning; }

static bool open_pan(bench *self, const char *path, int threads, pan_show *p, daft_error *error)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads, def.isa = self->isa, def.warn = ignore;
    *p = (pan_show){.view = daft_default_view()};
    p->engine = daft_engine_create(&def, error);
    if (p->engine) p->scene = daft_scene_create(p->engine, error);
    if (p->scene && daft_scene_load(p->scene, path, error))
        p->image = daft_image_create(p->engine, WIDTH, HEIGHT, error);
    if (p->image) p->view.camera = daft_scene_camera(p->scene, 1);
    bool good = p->image != NULL;
    for (int k = 0; k < KINDS; k++)
        good = good && (p->change[k] = malloc((size_t)WIDTH * HEIGHT * sizeof *p->change[k])) != NULL;
    return good;
}

static void close_pan(pan_show *p)
{
    for (int k = 0; k < KINDS; k++) flip_free(p->before[k]), free(p->change[k]);
    daft_image_destroy(p->image);
    if (p->scene) daft_scene_destroy(p->scene);
    if (p->engine) daft_engine_destroy(p->engine);
}

/* Draws the frame in one way, and finds out how it has changed. */
static bool pan_one(pan_show *p, int kind, int frame, daft_error *error)
{
    static const struct {
        int samples, edges;
    } KINDS_OF[KINDS] = {{1, 0}, {1, 4}, {1, 16}, {8, 0}, {16, 0}};
    daft_view view = p->view;
    view.quality.samples = KINDS_OF[kind].samples, view.quality.edge_samples = KINDS_OF[kind].edges;
    view.camera.yaw += 0.4f * view.camera.fov / WIDTH * (float)frame;
    if (!daft_render(p->scene, &view, p->image, error)) return false;
    flip_picture *now = flip_prepare(daft_image_pixels(p->image), WIDTH, HEIGHT, METRICS_PPD, error);
    if (now && p->before[kind]) flip_compare(p->before[kind], now, p->change[kind]);
    flip_free(p->before[kind]);
    p->before[kind] = now;
    return now != NULL;
}

static void add_flicker(pan_show *p)
{
    for (int k = 0; k + 1 < KINDS; k++) {
        double sum = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) sum += fabs((double)p->change[k][i] - (double)p->change[KINDS - 1][i]);
        p->flicker[k] += sum / (WIDTH * HEIGHT) / (FRAMES - 1);
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
    snprintf(row.counters, sizeof row.counters, "one sample %.4f; 4 at edges, as game draws it, %.4f", p.flicker[0],
             p.flicker[1]);
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
