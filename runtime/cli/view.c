/* daft view: a window to look at a scene, a mesh or a picture. */
#include "cli/commands.h"

#include "cli/cli.h"
#include "common/quality.h"
#include "common/util.h"
#include "view/view.h"

#include <stdio.h>

typedef struct view_options {
    const char *path, *isa;
    cli_size size, snapshot;
    quality_wish quality;
    long threads, camera;
    uint64_t memory;
} view_options;

static bool look(const view_options *o, font *face, daft_engine *engine, daft_error *error)
{
    platform *screen = platform_open_sdl("DAFT", o->size.width, o->size.height, error);
    if (!screen) {
        char why[sizeof error->message];
        snprintf(why, sizeof why, "%s", error->message);
        return fail(error, DAFT_ERROR_UNSUPPORTED,
                    "there is no display (%.300s); 'daft render' draws a scene or mesh into a file", why);
    }
    view_def def = {.screen = screen,
                    .engine = engine,
                    .face = face,
                    .path = o->path,
                    .camera = o->camera,
                    .quality = o->quality,
                    .snapshot_width = o->snapshot.width,
                    .snapshot_height = o->snapshot.height};
    bool good = view_run(&def, error);
    screen->close(screen);
    return good;
}

static bool run(const view_options *o, daft_error *error)
{
    home where;
    daft_engine_def def = daft_default_engine_def();
    def.threads = (int)o->threads;
    def.isa = o->isa;
    def.memory_limit = o->memory;
    if (!home_find(&where, error)) return false;
    font *face = open_font(&where, error);
    daft_engine *engine = face ? try_engine(&def, error) : NULL;
    bool good = engine && look(o, face, engine, error);
    daft_engine_destroy(engine);
    font_close(face);
    return good;
}

int command_view(int argc, char **argv)
{
    char keys[3000];
    const cli_command command = {
        "view",
        "SCENE|MESH|IMAGE",
        "Shows a .scene file, a mesh (.obj, .gltf, .fbx, ...) or a picture in a window, to fly through and to look at.",
        view_keys_text(keys, sizeof keys),
        1,
        1};
    view_options o = {.size = {1280, 720}, .quality.preset = QUALITY_OF_SCENE, .camera = -1};
    const cli_option options[] = {
        {"size", 0, CLI_SIZE, "WxH", &o.size, 180, 8192, "size of the window (1280x720)"},
        {"quality", 'q', CLI_QUALITY, "Q", &o.quality.preset, 0, 0,
         "of the picture while the camera moves: draft, game, high or reference (what the scene asks for, or game)"},
        {"knobs", 'k', CLI_KNOBS, "LIST", &o.quality.knobs, 0, 0,
         "replace single values of that quality: samples=4,shadows=0"},
        {"camera", 0, CLI_COUNT, "N", &o.camera, 0, 1000000,
         "begin at the N-th camera of the file, counted from 0 (0)"},
        {"snapshot", 0, CLI_SIZE, "WxH", &o.snapshot, 16, 16384, "size of snapshots and films (the window's)"},
        {"threads", 't', CLI_COUNT, "N", &o.threads, 0, 64,
         "worker threads; 0, the default, is one for each processor"},
        {"isa", 0, CLI_ISA, "X", &o.isa, 0, 0, "plain, sse2, avx2 or avx512; default: the best available"},
        {"memory-limit", 0, CLI_BYTES, "BYTES", &o.memory, 1000000, 0,
         "what the scene and its pictures may hold: 500MB, 2GB (no limit)"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    daft_error error;
    cli_outcome outcome = cli_parse(&command, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    o.path = operands[0];
    return run(&o, &error) ? STATUS_DONE : report(&error);
}
