/* Rows `denoise, NAME`: the scenes of assets/scenes with lights that have a size, ambient occlusion and, where they
 * have them, rough surfaces, at 1280x720, by so many rays a point, with and without denoising: the time of a frame, and
 * how far the picture is from one of 128 rays, by FLIP and by the root of the mean square in linear light. With one
 * sample a pixel edges do not count; rows of four samples are compared with sixteen of 4 rays. Rows `after 8 pictures`
 * draw the last of eight along which the camera moves, and reuse what those before it found.
 *
 * Scenes whose lights are points get sizes when they are read: suns a disc of 1.5 degrees, others a radius of 15 cm;
 * but for `studio`, in which rough surfaces alone are sampled. */
#include "harness/bench.h"

#include "accuracy/metrics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 1280, HEIGHT = 720, RUNS = 2, TRUTH_RAYS = 32, TRUTH_PICTURES = 4, MOVES = 8 };

/* ---- scenes ---- */

static bool begins(const char *line, const char *word)
{
    size_t length = strlen(word);
    return strncmp(line, word, length) == 0 && line[length] == ' ';
}

/* The line as it is wanted; what its item already says of sizes stays. */
static void put_line(FILE *out, const char *line, size_t length)
{
    const bool sized = memmem(line, length, "radius=", 7) || memmem(line, length, "disc=", 5);
    const char *more = "";
    if ((begins(line, "light") || begins(line, "spot")) && !sized) more = " radius=0.15";
    if (begins(line, "sun") && !sized) more = " disc=1.5";
    int spaces = 0;
    for (size_t i = 1; i < length; i++) spaces += line[i] == ' ' && line[i - 1] != ' ';
    if (begins(line, "ambient") && spaces == 3) more = " 1.5";
    fprintf(out, "%.*s%s\n", (int)length, line, more);
}

static char *soften(const char *text, size_t *size)
{
    char *out = NULL;
    FILE *file = open_memstream(&out, size);
    if (!file) return NULL;
    for (const char *line = text; *line; line += strcspn(line, "\n"), line += *line == '\n')
        put_line(file, line, strcspn(line, "\n"));
    fclose(file);
    return out;
}

/* A daft_read_callback of the project's folder. */
static int64_t read_file(void *user, const char *path, void *bytes, uint64_t capacity, daft_error *error)
{
    char full[1024];
    size_t size;
    (void)user;
    snprintf(full, sizeof full, "%s/%s", DAFT_ROOT, path);
    char *text = daft_read_file(NULL, full, &size, error);
    if (!text) return -1;
    const char *dot = strrchr(path, '.');
    const bool scene = dot && strcmp(dot, ".scene") == 0 && !strstr(path, "studio");
    char *soft = scene ? soften(text, &size) : text;
    if (soft && size <= capacity) memcpy(bytes, soft, size);
    if (soft != text) free(soft);
    free(text);
    return soft ? (int64_t)size : -1;
}

/* ---- pictures ---- */

typedef struct soft_show {
    daft_files *files;
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    uint8_t *truth;
} soft_show;

static void ignore(void *user, const daft_error *warning) { (void)user, (void)warning; }

static bool open_show(bench *self, const char *name, int threads, soft_show *s, daft_error *error)
{
    static const char folder[] = "/daft";
    char path[256];
    daft_root root = {.folder = folder, .read = read_file};
    daft_files_def files = daft_default_files_def();
    daft_engine_def def = daft_default_engine_def();
    files.roots = &root, files.root_count = 1;
    def.threads = threads, def.isa = self->isa, def.warn = ignore;
    *s = (soft_show){.view = daft_default_view()};
    s->view.quality.edge_samples = 0;
    if (!(s->files = daft_files_create(&files, error)) || !(s->engine = daft_engine_create(&def, error)) ||
        !daft_engine_set_files(s->engine, s->files, error) || !(s->scene = daft_scene_create(s->engine, error)))
        return false;
    snprintf(path, sizeof path, "%s/assets/scenes/%s.scene", folder, name);
    if (!daft_scene_load(s->scene, path, error)) return false;
    s->image = daft_image_create(s->engine, WIDTH, HEIGHT, error);
    s->truth = malloc(4 * WIDTH * HEIGHT);
    s->view.camera = daft_scene_camera(s->scene, 1);
    return s->image && s->truth;
}

static void close_show(soft_show *s)
{
    free(s->truth);
    daft_image_destroy(s->image);
    if (s->scene) daft_scene_destroy(s->scene);
    if (s->engine) daft_engine_destroy(s->engine);
    daft_files_destroy(s->files);
}

/* One row's settings. */
typedef struct setting {
    int rays, samples;
    bool denoise, half, moves;
} setting;

/* Milliseconds; negative on failure. */
static double draw_once(soft_show *s, int threads, daft_error *error)
{
    double start = bench_clock_ms(threads);
    if (!daft_render(s->scene, &s->view, s->image, error)) return -1;
    return bench_clock_ms(threads) - start;
}

/* The last of some pictures, where a camera arrives that goes sideways by 1 cm and turns by 0.003 each. */
static double draw_moving(soft_show *s, int threads, daft_error *error)
{
    const daft_camera end = s->view.camera;
    double ms = -1;
    if (!(s->view.history = daft_history_create(s->engine, error))) return -1;
    for (int k = MOVES - 1; k >= 0; k--) {
        s->view.camera = end;
        s->view.camera.yaw += 0.003f * (float)k;
        s->view.camera.position.x += 0.01 * k * daft_sin((double)end.yaw);
        s->view.camera.position.z -= 0.01 * k * daft_cos((double)end.yaw);
        if ((ms = draw_once(s, threads, error)) < 0) break;
    }
    daft_history_destroy(s->view.history);
    s->view.history = NULL, s->view.camera = end;
    return ms;
}

/* Milliseconds, the best of some; negative on failure. */
static double draw(soft_show *s, const setting *how, int runs, int threads, daft_error *error)
{
    double best = -1;
    s->view.quality.shadow_samples = s->view.quality.occlusion_samples = s->view.quality.glossy_samples = how->rays;
    s->view.quality.denoise = how->denoise, s->view.quality.half_light = how->half;
    s->view.quality.samples = how->samples;
    for (int i = 0; i < runs; i++) {
        double ms = how->moves ? draw_moving(s, threads, error) : draw_once(s, threads, error);
        if (ms < 0) return -1;
        if (best < 0 || ms < best) best = ms;
    }
    return best;
}

/* The mean of some pictures of 32 rays with different ones, by a history that counts them. */
static bool find_truth(soft_show *s, int threads, daft_error *error)
{
    static const setting MANY = {.rays = TRUTH_RAYS, .samples = 1};
    const size_t bytes = 4 * WIDTH * HEIGHT;
    double *sum = calloc(bytes, sizeof *sum);
    bool good = sum && (s->view.history = daft_history_create(s->engine, error));
    for (int k = 0; good && k < TRUTH_PICTURES; k++) {
        good = draw(s, &MANY, 1, threads, error) >= 0;
        const uint8_t *rgba = daft_image_pixels(s->image);
        for (size_t i = 0; good && i < bytes; i++) sum[i] += metrics_to_linear(rgba[i]) / TRUTH_PICTURES;
    }
    for (size_t i = 0; good && i < bytes; i++) s->truth[i] = metrics_to_srgb(sum[i]);
    daft_history_destroy(s->view.history);
    s->view.history = NULL;
    free(sum);
    return good;
}

/* The truth for more than one sample. */
static bool find_smooth_truth(soft_show *s, int threads, daft_error *error)
{
    static const setting MANY = {.rays = 4, .samples = 16};
    if (draw(s, &MANY, 1, threads, error) < 0) return false;
    memcpy(s->truth, daft_image_pixels(s->image), 4 * WIDTH * HEIGHT);
    return true;
}

static bool measure(bench *self, soft_show *s, const char *name, const setting *how, int threads, daft_error *error)
{
    bench_row row = {.unit = "ms", .isa = self->isa, .threads = threads, .peer = -1};
    picture_errors e;
    row.ours = draw(s, how, RUNS, threads, error);
    if (row.ours < 0 || !metrics_compare(daft_image_pixels(s->image), s->truth, WIDTH, HEIGHT, NULL, &e, error))
        return false;
    snprintf(row.scene, sizeof row.scene, "%s", name);
    snprintf(row.what, sizeof row.what, "%s%d ray%s%s%s%s", how->samples > 1 ? "4 samples, " : "", how->rays,
             how->rays == 1 ? "" : "s", how->denoise ? ", denoised" : "", how->half ? ", half light" : "",
             how->moves ? ", after 8 pictures" : "");
    const daft_effect *effects = daft_scene_counters(s->scene)->effects;
    snprintf(row.counters, sizeof row.counters,
             "FLIP %.4f, RMSE %.4f; ms: shadow %.1f occlusion %.1f reflection %.1f denoise %.1f", e.flip, e.rmse,
             effects[DAFT_EFFECT_SHADOW].ms, effects[DAFT_EFFECT_OCCLUSION].ms, effects[DAFT_EFFECT_REFLECTION].ms,
             effects[DAFT_EFFECT_DENOISE].ms);
    return bench_add(self, &row);
}

void bench_denoise(bench *self)
{
    static const char *const NAMES[] = {"lamps", "studio", "hello", "temple", "islands", "forest", "hall", "town"};
    static const setting SETTINGS[] = {{.rays = 1, .samples = 1},
                                       {.rays = 1, .samples = 1, .denoise = true},
                                       {.rays = 1, .samples = 1, .denoise = true, .half = true},
                                       {.rays = 1, .samples = 1, .denoise = true, .moves = true},
                                       {.rays = 1, .samples = 1, .denoise = true, .half = true, .moves = true},
                                       {.rays = 2, .samples = 1},
                                       {.rays = 4, .samples = 1},
                                       {.rays = 4, .samples = 1, .denoise = true},
                                       {.rays = 8, .samples = 1},
                                       {.rays = 16, .samples = 1},
                                       {.rays = 1, .samples = 4},
                                       {.rays = 1, .samples = 4, .denoise = true}};
    int counts[2], count = bench_thread_counts(self, counts);
    for (size_t i = 0; i < DAFT_COUNT_OF(NAMES); i++) {
        char name[64], text[1200];
        snprintf(name, sizeof name, "denoise, %s", NAMES[i]);
        for (int t = 0; t < count && bench_wants(self, name, "rays"); t++) {
            soft_show s;
            daft_error error = {0};
            fprintf(stderr, "%s, %d thread%s\n", name, counts[t], counts[t] == 1 ? "" : "s");
            bool good = open_show(self, NAMES[i], counts[t], &s, &error) && find_truth(&s, counts[t], &error);
            for (size_t k = 0; good && k < DAFT_COUNT_OF(SETTINGS); k++) {
                const bool smooth = SETTINGS[k].samples > 1 && SETTINGS[k - 1].samples == 1;
                good = (!smooth || find_smooth_truth(&s, counts[t], &error)) &&
                       measure(self, &s, name, &SETTINGS[k], counts[t], &error);
            }
            if (!good) bench_note(self, true, "%s: %s", name, daft_error_text(&error, text, sizeof text));
            close_show(&s);
        }
    }
}
