/* Rows `scene frame, NAME`: each scene of assets/scenes in quality `game`, through daft.h alone: with one sample a
 * pixel; as it is, with antialiasing; and doing no more than the peer does: light is not sampled, and mirrors and glass
 * show the sky. The first camera sways for 120 frames (sway.h), so that each is drawn in
 * full. What the engine keeps from frame to frame stays kept, as for a user. The row also reports the time of a frame
 * in which nothing moves. The peer is llvmpipe, with one sample a pixel and with four. */
#include "frames/users.h"

#include "frames/sway.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct show {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    int threads;
} show;

static void ignore(void *user, const daft_error *warning) { (void)user, (void)warning; }

typedef enum show_kind { SHOW_PLAIN, SHOW_ANTIALIASED, SHOW_EQUAL_WORK, SHOW_KINDS } show_kind;
static const char *const KINDS[SHOW_KINDS] = {"", ", antialiased", ", equal work"};

static daft_quality quality_of(show_kind kind)
{
    daft_quality q = daft_preset_quality(DAFT_PRESET_GAME);
    if (kind != SHOW_ANTIALIASED) q.edge_samples = 0;
    if (kind == SHOW_EQUAL_WORK) sway_equal_work(&q);
    return q;
}

static bool open_show(bench *self, const char *path, int threads, show_kind kind, show *s, daft_error *error)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads, def.isa = self->isa, def.warn = ignore;
    *s = (show){.view = daft_default_view(), .threads = threads};
    s->view.quality = quality_of(kind);
    s->engine = daft_engine_create(&def, error);
    if (s->engine) s->scene = daft_scene_create(s->engine, error);
    if (s->scene && daft_scene_load(s->scene, path, error))
        s->image = daft_image_create(s->engine, SWAY_WIDTH, SWAY_HEIGHT, error);
    if (s->image) s->view.camera = daft_scene_camera(s->scene, 1);
    return s->image != NULL;
}

static void close_show(show *s)
{
    daft_image_destroy(s->image);
    if (s->scene) daft_scene_destroy(s->scene);
    if (s->engine) daft_engine_destroy(s->engine);
}

/* Milliseconds; negative on failure. */
static double draw(show *s, const daft_camera *camera)
{
    daft_view view = s->view;
    view.camera = *camera;
    double start = bench_clock_ms(s->threads);
    if (!daft_render(s->scene, &view, s->image, NULL)) return -1;
    return bench_clock_ms(s->threads) - start;
}

/* The sway once: fills `out`. */
static bool show_all(show *s, users_frames *out)
{
    double ms[SWAY_FRAMES];
    *out = (users_frames){.frames = SWAY_FRAMES};
    for (int i = 0; i < SWAY_FRAMES; i++) {
        daft_camera camera = sway(&s->view.camera, i);
        if ((ms[i] = draw(s, &camera)) < 0) return false;
        const daft_effect *effects = daft_scene_counters(s->scene)->effects;
        for (int k = 0; k < DAFT_EFFECT_COUNT; k++)
            out->names[k] = effects[k].name, out->effects[k] += effects[k].ms / SWAY_FRAMES;
    }
    out->median = sway_median(ms, SWAY_FRAMES), out->p95 = sway_p95(ms, SWAY_FRAMES);
    return true;
}

static void measure_scene(bench *self, const char *row, const char *path, int threads, show_kind kind)
{
    show s;
    daft_error error = {0};
    char text[1200], note[64];
    users_frames best = {0}, peer = {0};
    fprintf(stderr, "%s, %d thread%s\n", row, threads, threads == 1 ? "" : "s");
    bool good = open_show(self, path, threads, kind, &s, &error) && draw(&s, &s.view.camera) >= 0;
    for (int i = 0; good && i < (self->rounds ? self->rounds : 2); i++) {
        users_frames f;
        good = show_all(&s, &f);
        if (i == 0 || f.median < best.median) best = f;
        users_peer(self, "scene", path, threads, kind == SHOW_ANTIALIASED, &peer);
    }
    if (good) {
        draw(&s, &s.view.camera);
        snprintf(note, sizeof note, "a still one %.2f ms", draw(&s, &s.view.camera));
        users_report(self, row, threads, &best, &peer, note, 0, 0);
    } else {
        bench_note(self, true, "%s: %s", row, daft_error_text(&error, text, sizeof text));
    }
    close_show(&s);
}

void bench_shown_scenes(bench *self)
{
    struct dirent **files;
    int found = scandir(DAFT_ROOT "/assets/scenes", &files, users_is_scene, alphasort), counts[2];
    int count = bench_thread_counts(self, counts);
    for (int i = 0; i < found; i++) {
        char row[80], path[512];
        snprintf(path, sizeof path, "%s/assets/scenes/%.200s", DAFT_ROOT, files[i]->d_name);
        for (show_kind kind = 0; kind < SHOW_KINDS; kind++) {
            snprintf(row, sizeof row, "scene frame, %.*s%s", (int)(strlen(files[i]->d_name) - 6), files[i]->d_name,
                     KINDS[kind]);
            if (users_wants(self, row))
                for (int t = 0; t < count; t++) measure_scene(self, row, path, counts[t], kind);
        }
        free(files[i]);
    }
    if (found >= 0) free(files);
}
