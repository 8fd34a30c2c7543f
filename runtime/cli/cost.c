/* daft cost: what accuracy costs in a scene or a game. */
#include "cli/commands.h"

#include "accuracy/report.h"
#include "cli/cli.h"
#include "common/util.h"
#include "game/loop.h"
#include "video/film_game.h"
#include "video/film_scene.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const cli_command COMMAND = {"cost",
                                    "SCENE|GAME",
                                    "Measures what each step of quality costs and what error it removes.",
                                    "Draws one picture of the scene, or of the game in the middle of its demo, with "
                                    "every setting of each knob and with\n"
                                    "combinations of them; compares each with a reference; writes DIR/index.html, "
                                    "points.csv and report.json, and names\n"
                                    "the settings that no other beats, and the best one that keeps the budget.",
                                    1,
                                    1};

enum { DEFAULT_SECONDS = 150, QUICK_SECONDS = 22 };

typedef struct cost_options {
    const char *what, *out, *isa;
    cli_size size;
    daft_quality quality;
    double budget, at;
    long camera, threads;
    bool quick;
} cost_options;

static bool make_folder(const char *path, daft_error *error)
{
    if (mkdir(path, 0777) == 0 || (errno == EEXIST && path_is_folder(path))) return true;
    return fail(error, DAFT_ERROR_IO, "%s: the folder cannot be made: %s", path, strerror(errno));
}

/* With all that the figures depend on, the defaults too. */
static void print_command(const cost_options *o, FILE *out)
{
    fprintf(out, "daft cost %s --budget %g --size %dx%d --quality %s", o->what, o->budget, o->size.width,
            o->size.height, daft_quality_name(o->quality));
    if (o->quick) fprintf(out, " --quick");
    if (o->camera >= 0) fprintf(out, " --camera %ld", o->camera);
    if (!isnan(o->at)) fprintf(out, " --at %g", o->at);
    if (o->threads) fprintf(out, " --threads %ld", o->threads);
    if (o->isa) fprintf(out, " --isa %s", o->isa);
}

static bool write_report(const cost_options *o, const sweep_result *all, daft_error *error)
{
    draft_file command;
    if (!draft_open(&command, error)) return false;
    print_command(o, command.file);
    bool good = fclose(command.file) == 0 || fail(error, DAFT_ERROR_MEMORY, "out of memory for a report");
    report_def page = {all, o->what, command.bytes, o->out, o->budget, (int)o->threads};
    good = good && report_write(&page, error);
    if (good) report_print(&page, stdout);
    free(command.bytes);
    return good;
}

static bool measure(const cost_options *o, daft_engine *engine, daft_scene *scene, const daft_view *view,
                    daft_error *error)
{
    sweep_result all;
    sweep_def def = {.engine = engine,
                     .scene = scene,
                     .view = *view,
                     .width = o->size.width,
                     .height = o->size.height,
                     .seconds = o->quick ? QUICK_SECONDS : DEFAULT_SECONDS,
                     .quick = o->quick};
    def.view.quality = o->quality;
    if (!make_folder(o->out, error) || !sweep_run(&all, &def, error)) return false;
    bool good = write_report(o, &all, error);
    sweep_free(&all);
    return good;
}

static bool cost_of_scene(const cost_options *o, daft_engine *engine, daft_error *error)
{
    film_scene scene;
    film_scene_def def = {engine, o->what, o->camera < 0 ? 0 : o->camera, DAFT_PACE_TIMED, o->quality};
    if (!film_scene_open(&scene, &def, error)) return false;
    bool good = measure(o, engine, scene.scene, &scene.view, error);
    film_scene_close(&scene);
    return good;
}

/* Plays without drawing until `at` seconds, by default the middle of the demo, and measures there. */
static bool cost_in_game(const cost_options *o, daft_engine *engine, film_game *game, daft_error *error)
{
    double at = !isnan(o->at) ? o->at : game->has_replay ? (double)game->replay.end / LOOP_RATE / 2 : 1;
    daft_image *picture = daft_image_create(engine, o->size.width, o->size.height, error);
    if (!picture) return false;
    frame_result result = game->source.draw(&game->source, at, false, picture, error);
    daft_image_destroy(picture);
    if (result == FRAME_FAILED) return false;
    if (result == FRAME_NONE)
        return fail(error, DAFT_ERROR_ARGUMENT, "%s: the game ends before %g s: nothing to measure", o->what, at);
    daft_view view = daft_default_view();
    view.camera = daft_scene_camera(game->play.scene, 1);
    return measure(o, engine, game->play.scene, &view, error);
}

/* With the game's demo, where it has one. */
static bool cost_of_found(const cost_options *o, const game_def *play, daft_error *error)
{
    film_game game;
    char demo[PATH_SIZE];
    bool has_demo = daft_files_find(play->source->files, "demo.rec", demo, sizeof demo);
    if (!film_game_open(&game, play, has_demo ? demo : NULL, has_demo, error)) return false;
    bool good = cost_in_game(o, play->engine, &game, error);
    film_game_close(&game);
    return good;
}

static bool cost_of_game(const cost_options *o, daft_engine *engine, daft_error *error)
{
    home where;
    game_info info;
    game_source source = {0};
    if (!home_find(&where, error) || !home_find_game(&where, o->what, &info, error)) return false;
    font *face = open_font(&where, error);
    game_def play = {.where = &where,
                     .info = &info,
                     .source = &source,
                     .engine = engine,
                     .face = face,
                     .quality = DAFT_QUALITY_GAME,
                     .seed = 1};
    bool good = face && source_open(&source, &where, &info, error) && cost_of_found(o, &play, error);
    source_close(&source);
    font_close(face);
    return good;
}

static int run(const cost_options *o)
{
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    def.threads = (int)o->threads;
    def.isa = o->isa;
    daft_engine *engine = open_engine(&def);
    if (!engine) return STATUS_BAD_INPUT;
    bool good = has_extension(o->what, ".scene") ? cost_of_scene(o, engine, &error) : cost_of_game(o, engine, &error);
    daft_engine_destroy(engine);
    return good ? STATUS_DONE : report(&error);
}

int command_cost(int argc, char **argv)
{
    cost_options o = {.out = "cost", .quality = DAFT_QUALITY_GAME, .budget = 16, .at = NAN, .camera = -1};
    const cli_option options[] = {
        {"budget", 0, CLI_NUMBER, "MS", &o.budget, 0, 60000, "milliseconds that a picture may take (16)"},
        {"output", 'o', CLI_TEXT, "DIR", &o.out, 0, 0, "the folder for the report (cost)"},
        {"quick", 0, CLI_FLAG, NULL, &o.quick, 0, 0, "fewer combinations and a coarser reference, within 30 s"},
        {"size", 0, CLI_SIZE, "WxH", &o.size, 16, 1920, "size of the picture (640x360; quick: 320x180)"},
        {"quality", 'q', CLI_QUALITY, "Q", &o.quality, 0, 0,
         "the preset from which knobs differ: draft, game (default), high or reference"},
        {"camera", 0, CLI_COUNT, "N", &o.camera, 0, 1000000, "the N-th camera of the scene, counted from 0 (0)"},
        {"at", 0, CLI_NUMBER, "S", &o.at, 0, 86400, "second of the game (the middle of its demo; without one, 1)"},
        {"threads", 't', CLI_COUNT, "N", &o.threads, 0, 64,
         "worker threads; 0, the default, is one for each processor"},
        {"isa", 0, CLI_ISA, "X", &o.isa, 0, 0, "plain, sse2, avx2 or avx512; default: the best available"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    o.what = operands[0];
    if (o.size.width == 0) o.size = o.quick ? (cli_size){320, 180} : (cli_size){640, 360};
    if (!(o.budget > 0)) return cli_refuse("cost", "--budget: a number above 0 expected");
    return run(&o);
}
