/* daft_llvmpipe: the frames of a row `scene frame` or `game frame` as OpenGL draws them. Prints their times as JSON. */
#include "llvmpipe/peer.h"

#include "files/home.h"
#include "frames/sway.h"
#include "game/game.h"
#include "scene/scene.h"

#include <GL/osmesa.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const char USAGE[] =
    "usage: daft_llvmpipe scene FILE | game NAME [options]\n"
    "\n"
    "Draws with OpenGL 3.3 on Mesa's llvmpipe what daft_bench draws with DAFT, and prints how long frames took as\n"
    "JSON: the camera of a scene sways for 120 frames; a game plays its demo, without texts.\n"
    "\n"
    "  --threads N      so many (1)\n"
    "  --antialiased    four samples a pixel\n"
    "  --all-shadows    of lamps, too, by depth cubes and maps of cones; and trilinear textures\n"
    "  --size WxH       of the picture (1280x720)\n"
    "  --picture FILE   write the scene's first picture, of the camera at rest, instead\n";

typedef struct options {
    const char *scene, *game, *picture;
    int threads, width, height;
    bool antialiased, all_shadows;
} options;

static bool parse(int argc, char **argv, options *o)
{
    *o = (options){.threads = 1, .width = SWAY_WIDTH, .height = SWAY_HEIGHT};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(argv[i], "--antialiased") == 0) {
            o->antialiased = true;
            continue;
        }
        if (strcmp(argv[i], "--all-shadows") == 0) {
            o->all_shadows = true;
            continue;
        }
        if (!value) return false;
        i++;
        if (strcmp(argv[i - 1], "scene") == 0)
            o->scene = value;
        else if (strcmp(argv[i - 1], "game") == 0)
            o->game = value;
        else if (strcmp(argv[i - 1], "--picture") == 0)
            o->picture = value;
        else if (strcmp(argv[i - 1], "--threads") == 0)
            o->threads = atoi(value);
        else if (strcmp(argv[i - 1], "--size") == 0) {
            if (sscanf(value, "%dx%d", &o->width, &o->height) != 2) return false;
        } else
            return false;
    }
    return !o->scene != !o->game && o->threads >= 1 && o->threads <= 64 && o->width >= 1 && o->width <= 8192 &&
           o->height >= 1 && o->height <= 8192;
}

static bool report_error(const daft_error *error)
{
    char text[1200];
    fprintf(stderr, "daft_llvmpipe: %s\n", daft_error_text(error, text, sizeof text));
    return false;
}

/* One thread: its own processor time, as daft_bench counts ours. */
static double clock_ms(int threads)
{
    struct timespec t;
    clock_gettime(threads > 1 ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* Milliseconds of the scene as it is, without what the engine does for the snapshot; negative: failed. */
static double draw(peer *p, const options *o, daft_scene *scene, const daft_view *view)
{
    daft_error error;
    daft_scene_frame *frame = daft_frame_take(scene, view, o->width, o->height, &error);
    if (!frame) {
        report_error(&error);
        return -1;
    }
    const double start = clock_ms(o->threads);
    const bool good = peer_draw(p, &frame->snapshot);
    const double ms = clock_ms(o->threads) - start;
    daft_frame_release(scene, frame);
    if (!good) fprintf(stderr, "daft_llvmpipe: a frame failed\n");
    return good ? ms : -1;
}

static bool print_times(double *ms, int count)
{
    const double median = sway_median(ms, count);
    printf("{\"frame_ms\": {\"median\": %.4f, \"p95\": %.4f, \"frames\": %d}, \"renderer\": \"%s\"}\n", median,
           sway_p95(ms, count), count, (const char *)glGetString(GL_RENDERER));
    return true;
}

static bool write_picture(peer *p, const options *o, daft_engine *engine)
{
    daft_error error;
    daft_image *image = daft_image_create(engine, o->width, o->height, &error);
    if (image) peer_read(p, daft_image_pixels(image));
    const bool good = image && daft_image_write(image, o->picture, &error);
    daft_image_destroy(image);
    return good || report_error(&error);
}

static bool run_scene(peer *p, const options *o, daft_engine *engine, daft_scene *scene)
{
    daft_error error;
    if (!daft_scene_load(scene, o->scene, &error)) return report_error(&error);
    daft_view view = daft_default_view();
    const daft_camera camera = daft_scene_camera(scene, 1);
    double ms[SWAY_FRAMES];
    view.camera = camera;
    if (draw(p, o, scene, &view) < 0) return false;
    if (o->picture) return write_picture(p, o, engine);
    for (int i = 0; i < SWAY_FRAMES; i++) {
        view.camera = sway(&camera, i);
        if ((ms[i] = draw(p, o, scene, &view)) < 0) return false;
    }
    return print_times(ms, SWAY_FRAMES);
}

/* The demo to its end. The picture, where one is asked for, is the last. */
static bool play_demo(peer *p, const options *o, daft_engine *engine, game_state *game)
{
    size_t capacity = 0;
    int count = 0;
    double *ms = NULL;
    const daft_allocator allocator = daft_malloc_allocator();
    bool good = true;
    while (good && game_is_replaying(game)) {
        daft_view view = daft_default_view();
        good = game_tick(game) && daft_grow(&allocator, &ms, &capacity, (size_t)count + 1, (size_t)count, sizeof *ms);
        if (!good) break;
        view.camera = daft_scene_camera(game->scene, 1);
        ms[count] = draw(p, o, game->scene, &view);
        good = ms[count++] >= 0;
    }
    if (good && o->picture) good = write_picture(p, o, engine);
    if (good && !o->picture && count) good = print_times(ms, count);
    daft_release(&allocator, ms);
    return good && count;
}

static bool run_game(peer *p, const options *o, daft_engine *engine)
{
    daft_error error;
    home where = {.games = DAFT_ROOT "/games", .assets = DAFT_ROOT "/assets", .scripts = DAFT_ROOT "/scripts"};
    char demo[512];
    game_info info;
    recording record;
    game_state game;
    snprintf(demo, sizeof demo, "%s/games/%s/demo.rec", DAFT_ROOT, o->game);
    if (!home_find_game(&where, o->game, &info, &error)) return report_error(&error);
    if (!recording_load(&record, NULL, demo, &error)) return report_error(&error);
    const char *const letters = DAFT_ROOT "/assets/fonts/daft.ttf";
    font *face = font_open(NULL, NULL, letters, letters, &error);
    const game_def def = {.where = &where,
                          .info = &info,
                          .engine = engine,
                          .face = face,
                          .quality.preset = DAFT_PRESET_GAME,
                          .seed = record.seed,
                          .replay = &record};
    bool good = face && game_open(&game, &def, &error);
    if (good) {
        good = play_demo(p, o, engine, &game);
        if (game.failed) fprintf(stderr, "daft_llvmpipe: %s\n", game.scripts.failure.message);
        game_close(&game);
    } else {
        report_error(&error);
    }
    font_close(face);
    recording_free(&record);
    return good;
}

int main(int argc, char **argv)
{
    options o;
    if (argc == 2 && strcmp(argv[1], "--help") == 0) return fputs(USAGE, stdout), 0;
    if (!parse(argc, argv, &o)) return fputs(USAGE, stderr), 2;
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    def.threads = o.threads;
    daft_engine *engine = daft_engine_create(&def, &error);
    if (!engine) return report_error(&error), 1;
    peer *p = peer_create(&(peer_def){o.width, o.height, o.threads, o.antialiased, o.all_shadows});
    daft_scene *scene = p && o.scene ? daft_scene_create(engine, &error) : NULL;
    const bool good = p && (o.scene ? scene && run_scene(p, &o, engine, scene) : run_game(p, &o, engine));
    if (scene) daft_scene_destroy(scene);
    peer_destroy(p);
    daft_engine_destroy(engine);
    return good && fflush(stdout) == 0 ? 0 : 1;
}
