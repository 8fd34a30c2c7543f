/* daft render: renders one picture of a scene or a mesh, and prints its cost. */
#include "cli/commands.h"

#include "accuracy/sweep.h"
#include "channels/channels.h"
#include "cli/cli.h"
#include "cli/terminal.h"
#include "common/progress.h"
#include "common/quality.h"
#include "common/showcase.h"
#include "common/stats.h"
#include "common/trace.h"
#include "common/util.h"
#include "many/bands.h"
#include "job/shot.h"

#include <stdio.h>
#include <math.h>
#include <stdlib.h>

static const cli_command COMMAND = {
    "render",
    "SCENE|SNAPSHOT",
    "Renders a picture of a .scene file, of a mesh (.obj, .gltf, .fbx, ...) in front of a sky, or again what daft view "
    "took a snapshot "
    "of\n"
    "(.json): the same picture, byte for byte, unless options say otherwise.",
    "The extension of the picture chooses its format: .png, .ppm or .exr, which holds linear light and all channels "
    "that "
    "--aov names, as layers. With -o a.png, --aov writes a.depth.pfm (metres "
    "along\n"
    "the ray), a.normal.pfm (world axes), a.id.png and a.triangle.png (numbers: red + 256 green + 65536 blue).",
    1,
    1};

#define AS_IT_IS ((daft_intersection)-1)

typedef struct render_options {
    const char *scene, *out, *isa, *stats, *trace;
    tracer *spans; /* of --trace, or NULL */
    quality_wish quality;
    daft_intersection intersection; /* instead of the quality's; AS_IT_IS: none */
    daft_accel accel;
    cli_size size;
    long camera, threads, repeat;
    many *all; /* NULL: this process alone */
    uint64_t memory;
    bool camera_given, explain, term, reuse, wrong;
    terminal_kind terminal;
    const char *aov_list;
    channel_set aov;
    double at; /* seconds along the scene's path; below 0: not asked for */
    daft_engine *engine;
    daft_history *history; /* of the picture a tick before */
    const shot *again;     /* the snapshot to repeat, or NULL */
} render_options;

static bool choose_camera(const daft_scene *scene, const render_options *o, daft_camera *camera, daft_error *error)
{
    uint32_t count = daft_scene_camera_count(scene);
    if (o->camera < (long)count) {
        if (count == 0) return true;
        return daft_scene_get_camera((daft_scene *)(uintptr_t)scene, (uint32_t)o->camera, camera, error);
    }
    if (!o->camera_given && count == 0) {
        *camera = daft_default_camera();
        return true;
    }
    return fail(error, DAFT_ERROR_ARGUMENT, "--camera %ld: %s has %u camera%s, counted from 0", o->camera, o->scene,
                count, count == 1 ? "" : "s");
}

/* The camera on the scene's path, and a picture of one pixel a tick before it, so that there is motion. */
static bool go_along_path(daft_scene *scene, const render_options *o, daft_view *view, daft_error *error)
{
    const uint32_t count = daft_scene_path_count(scene);
    if (count == 0)
        return fail(error, DAFT_ERROR_ARGUMENT, "--at: %s has no path; daft view adds one (V, then C)", o->scene);
    daft_checkpoint *points = calloc(count, sizeof *points);
    if (!points) return fail(error, DAFT_ERROR_MEMORY, "out of memory for the camera path");
    bool good = true;
    for (uint32_t i = 0; good && i < count; i++) good = daft_scene_get_checkpoint(scene, i, &points[i], error);
    daft_view before = *view;
    before.quality = daft_preset_quality(DAFT_PRESET_DRAFT), before.aov = (daft_aov){0};
    daft_image *pixel = good ? daft_image_create(o->engine, 1, 1, error) : NULL;
    good = pixel &&
           daft_path_camera(points, count, DAFT_PACE_TIMED, fmax(0, o->at - 1.0 / 60), &before.camera, error) &&
           daft_render(scene, &before, pixel, error) &&
           daft_path_camera(points, count, DAFT_PACE_TIMED, o->at, &view->camera, error);
    daft_image_destroy(pixel);
    free(points);
    return good;
}

typedef struct progress_state {
    progress_bar bar;
    long frame, frames;
} progress_state;

static bool show_progress(void *user, float done)
{
    progress_state *state = user;
    progress_show(&state->bar, ((double)state->frame + (double)done) / (double)state->frames);
    return true;
}

/* The scene's, a snapshot's or a preset's, and over it what the command line says. */
static bool choose_quality(const daft_scene *scene, const render_options *o, daft_quality *out, daft_error *error)
{
    if (!o->again || o->quality.preset != QUALITY_OF_SCENE)
        *out = quality_choose(&o->quality, scene);
    else if (o->quality.knobs && !quality_parse(o->quality.knobs, out, error))
        return false;
    if (o->intersection != AS_IT_IS) out->visibility = o->intersection;
    return true;
}

/* Red dots over what the cheaper visibility gets wrong. */
static bool mark_wrong(const render_options *o, daft_scene *scene, const daft_view *view, daft_image *image,
                       daft_error *error)
{
    const int width = o->size.width, height = o->size.height;
    size_t count;
    uint8_t *mask = calloc((size_t)width, (size_t)height);
    if (!mask) return fail(error, DAFT_ERROR_MEMORY, "out of memory for wrong pixels");
    const bool good = wrong_find(o->engine, scene, view, width, height, mask, &count, error);
    if (good) wrong_paint(mask, width, height, daft_image_pixels(image));
    if (good)
        fprintf(stderr, "daft: %zu of %d pixels see another triangle than with visibility=exact\n", count,
                width * height);
    free(mask);
    return good;
}

static bool render(daft_scene *scene, const render_options *o, daft_image *image, frame_times *times, daft_error *error)
{
    daft_view view = o->again ? o->again->view : daft_default_view();
    double aspect = (double)o->size.height / (double)o->size.width;
    const uint64_t loading = trace_begin(o->spans);
    if (showcase_is_mesh(o->scene) ? !showcase_mesh(scene, o->scene, aspect, error)
                                   : !daft_scene_load(scene, o->scene, error))
        return false;
    trace_end(o->spans, "load", loading);
    if (!choose_camera(scene, o, &view.camera, error)) return false;
    if (o->again && !o->camera_given) view.camera = o->again->view.camera;
    if (!choose_quality(scene, o, &view.quality, error)) return false;
    view.aov = o->aov.arrays;
    view.history = o->history, view.full = !o->reuse;
    if (o->at >= 0 && !go_along_path(scene, o, &view, error)) return false;
    progress_state progress = {.frames = o->repeat};
    progress_begin(&progress.bar, "rendering");
    view.progress = show_progress;
    view.progress_user = &progress;
    bool good = true;
    if (o->all) {
        good = bands_render(o->all, scene, &view, image, error);
        progress_end(&progress.bar);
        return good;
    }
    for (; good && progress.frame < o->repeat; progress.frame++) {
        const uint64_t began = trace_begin(o->spans);
        good = daft_render(scene, &view, image, error);
        trace_picture(o->spans, scene, began);
        frame_times_add(times, daft_scene_counters(scene)->frame_ms, daft_scene_counters(scene));
    }
    progress_end(&progress.bar);
    return good && (!o->wrong || mark_wrong(o, scene, &view, image, error));
}

static bool write(const render_options *o, daft_engine *engine, daft_image *image, daft_scene *scene,
                  frame_times *times, daft_error *error)
{
    if (o->all && many_rank(o->all) > 0) return true;
    bool good = true;
    const uint64_t began = trace_begin(o->spans);
    if (o->out && has_extension(o->out, ".exr"))
        good = channels_write_exr(&o->aov, o->out, error);
    else if (o->out)
        good = daft_image_write(image, o->out, error) && channels_write(&o->aov, engine, o->out, error);
    trace_end(o->spans, "write", began);
    if (good && o->term)
        terminal_show(o->terminal, daft_image_pixels(image), daft_image_width(image), daft_image_height(image));
    if (good && o->explain) stats_print_plan(stdout, daft_scene_counters(scene));
    times->memory = daft_engine_memory(engine);
    good = good && trace_finish(o->spans, error);
    return good && (!o->stats || stats_write(o->stats, daft_scene_counters(scene), times, error));
}

static bool render_and_write(daft_engine *engine, render_options *o, daft_error *error)
{
    if (o->trace && !(o->spans = trace_open(o->trace, TRACE_EVENTS, error))) return false;
    frame_times times = {0};
    daft_image *image = daft_image_create(engine, o->size.width, o->size.height, error);
    daft_scene *scene = image && channels_allocate(&o->aov, o->size.width, o->size.height, error)
                            ? daft_scene_create(engine, error)
                            : NULL;
    o->engine = engine;
    o->history = scene ? daft_history_create(engine, error) : NULL;
    bool good = o->history && render(scene, o, image, &times, error) && write(o, engine, image, scene, &times, error);
    daft_scene_destroy(scene);
    daft_history_destroy(o->history);
    daft_image_destroy(image);
    channels_free(&o->aov);
    frame_times_free(&times);
    trace_free(o->spans);
    return good;
}

static bool run(const daft_engine_def *wanted, render_options *o, daft_error *error)
{
    daft_engine_def def = *wanted;
    if (o->all && def.threads == 0) def.threads = many_threads(o->all);
    daft_engine *engine = try_engine(&def, error);
    bool good = engine && render_and_write(engine, o, error);
    daft_engine_destroy(engine);
    return good;
}

/* A picture for a file has the size of a window, one for the terminal alone that of the terminal. */
static void choose_size(render_options *o)
{
    if (o->term) o->terminal = terminal_find();
    if (o->size.width > 0) return;
    o->size = o->out ? (cli_size){1280, 720} : terminal_size(o->terminal);
}

static const render_options DEFAULTS = {
    .quality.preset = QUALITY_OF_SCENE, .intersection = AS_IT_IS, .camera = -1, .repeat = 1, .at = -1};

/* Options that the command line does not name stay as they are. */
static cli_outcome parse(render_options *o, int argc, char **argv)
{
    const cli_option options[] = {
        {"output", 'o', CLI_TEXT, "IMG", &o->out, 0, 0, "the picture to write: .png, .ppm or .exr (required)"},
        {"size", 0, CLI_SIZE, "WxH", &o->size, 1, 16384, "size of the picture (1280x720)"},
        {"quality", 'q', CLI_QUALITY, "Q", &o->quality.preset, 0, 0,
         "draft, game, high or reference (what the scene asks for, or game)"},
        {"knobs", 'k', CLI_KNOBS, "LIST", &o->quality.knobs, 0, 0,
         "replace single values of the quality: samples=4,shadows=0,mirror_depth=1"},
        {"intersect", 0, CLI_INTERSECT, "HOW", &o->intersection, 0, 0,
         "the knob `visibility` by itself: exact (default), watertight or fast"},
        {"camera", 0, CLI_COUNT, "N", &o->camera, 0, 1000000, "the N-th camera of the file, counted from 0 (0)"},
        {"threads", 't', CLI_COUNT, "N", &o->threads, 0, 64,
         "worker threads; 0, the default, is one for each processor"},
        {"isa", 0, CLI_ISA, "X", &o->isa, 0, 0, "plain, sse2, avx2 or avx512; default: the best available"},
        {"accel", 0, CLI_ACCEL, "X", &o->accel, 0, 0,
         "bvh (default) or kdtree: acceleration structure of meshes; the picture is the same"},
        {"memory-limit", 0, CLI_BYTES, "BYTES", &o->memory, 1000000, 0,
         "what the scene and its picture may hold: 500MB, 2GB (no limit)"},
        {"aov", 0, CLI_TEXT, "LIST", &o->aov_list, 0, 0,
         "also write these channels of each pixel beside IMG, or into it if it is an .exr: depth, normal, id, "
         "triangle, "
         "color (linear light), albedo, motion (pixels in the tick before --at), cost (rays)"},
        {"at", 0, CLI_NUMBER, "SECONDS", &o->at, 0, 86400, "the camera on the scene's path at this time"},
        {"term", 0, CLI_FLAG, NULL, &o->term, 0, 0,
         "show the picture in this terminal, as it can: kitty's protocol, sixels, half blocks"},
        {"wrong", 0, CLI_FLAG, NULL, &o->wrong, 0, 0,
         "red dots over pixels that see another triangle than with visibility=exact; counts them"},
        {"explain", 0, CLI_FLAG, NULL, &o->explain, 0, 0,
         "print the plan: each effect, why it ran or not, rays, milliseconds"},
        {"stats", 0, CLI_TEXT, "FILE", &o->stats, 0, 0, "write times and counters as JSON; - is stdout"},
        {"trace", 0, CLI_TEXT, "FILE", &o->trace, 0, 0,
         "write what took how long, for chrome://tracing or ui.perfetto.dev: FILE.json"},
        {"repeat", 0, CLI_COUNT, "N", &o->repeat, 1, 100000, "render N times, for the times of --stats (1)"},
        {"reuse", 0, CLI_FLAG, NULL, &o->reuse, 0, 0,
         "with --repeat: draw only what has changed since the picture before"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome == CLI_READY) o->scene = operands[0];
    return outcome;
}

/* What a snapshot says, and over it what the command line says. */
static bool take_snapshot(render_options *o, shot *again, int argc, char **argv, daft_error *error)
{
    if (!shot_read(again, o->scene, error)) return false;
    *o = DEFAULTS;
    o->again = again;
    o->size = (cli_size){again->width, again->height};
    parse(o, argc, argv);
    o->scene = again->scene;
    return true;
}

int command_render(int argc, char **argv)
{
    many_hush();
    shot again;
    daft_error wrong;
    render_options o = DEFAULTS;
    cli_outcome outcome = parse(&o, argc, argv);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    if (has_extension(o.scene, ".json") && !take_snapshot(&o, &again, argc, argv, &wrong)) return report(&wrong);
    if (!o.out && !o.term) return cli_refuse("render", "-o IMG is missing, or --term");
    if (!o.out && o.aov_list) return cli_refuse("render", "--aov: the picture's name, -o IMG, is missing");
    const bool exr = o.out && has_extension(o.out, ".exr");
    if (o.out && !exr && !has_extension(o.out, ".png") && !has_extension(o.out, ".ppm"))
        return cli_refuse("render", "-o: a name that ends in .png, .ppm or .exr expected, got '%s'", o.out);
    if (!has_extension(o.scene, ".scene") && !showcase_is_mesh(o.scene) && path_is_file(o.scene))
        return cli_refuse("render", "'%s' is neither a .scene nor a mesh (.obj, .gltf, .fbx, ...)", o.scene);
    choose_size(&o);
    if (o.aov_list && !channels_parse(o.aov_list, &o.aov, &wrong)) return cli_refuse("render", "%s", wrong.message);
    if (o.aov.wanted[CHANNEL_MOTION] && o.at < 0)
        return cli_refuse("render",
                          "--aov motion: nothing moves in one picture; --at SECONDS puts it on the scene's path");
    if (o.at >= 0 && (o.camera >= 0 || o.again)) return cli_refuse("render", "--at: the camera is that of the path");
    if (exr) o.aov.wanted[CHANNEL_COLOR] = true;
    o.camera_given = o.camera >= 0;
    if (!o.camera_given) o.camera = 0;
    daft_engine_def def = daft_default_engine_def();
    def.threads = (int)o.threads;
    def.isa = o.isa;
    def.accel = o.accel;
    def.memory_limit = o.memory;
    daft_error error;
    if (many_started() && (o.stats || o.trace || o.explain || o.wrong || o.repeat > 1))
        return cli_refuse("render",
                          "--stats, --trace, --explain, --wrong and --repeat are for one process, without mpirun");
    if (many_started() && !(o.all = many_join(&error))) return report(&error);
    bool good = run(&def, &o, &error);
    if (!good && o.all) many_drop_out(o.all, &error);
    int status = good ? STATUS_DONE : report(&error);
    many_leave(o.all);
    return status;
}
