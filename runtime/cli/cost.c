/* daft cost: what accuracy costs in a scene or a game. */
#include "cli/commands.h"

#include "accuracy/report.h"
#include "accuracy/sim.h"
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

static const cli_command COMMAND = {
    "cost",
    "SCENE|GAME",
    "Measures what each step of quality costs and what error it removes.",
    "Draws a picture of the scene, or pictures at moments of the game's demo, with every "
    "setting of each knob and with\n"
    "combinations of them; compares each with a reference; writes DIR/index.html, "
    "points.csv and report.json, and names\n"
    "the settings that no other beats, and the best one that keeps the budget.",
    1,
    1};

/* Seconds that measuring may take; moments of a game; seconds of one without a demo. */
enum { DEFAULT_SECONDS = 150, QUICK_SECONDS = 22, QUICK_MOMENTS = 2, PLAYED_SECONDS = 4 };

typedef struct cost_options {
    const char *what, *out, *isa;
    cli_size size;
    daft_preset quality;
    double budget, at;
    long camera, threads;
    bool quick, sim, no_pictures;
    const char *knob, *knobs; /* or NULL */
    const char *settings;     /* the same */
    const knob_row *only;     /* what these two say, or NULL */
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
            o->size.height, daft_preset_name(o->quality));
    if (o->knobs) fprintf(out, " --knobs %s", o->knobs);
    if (o->sim) fprintf(out, " --sim");
    if (o->knob) fprintf(out, " --knob %s", o->knob);
    if (o->settings) fprintf(out, " --settings '%s'", o->settings);
    if (o->quick) fprintf(out, " --quick");
    if (o->no_pictures) fprintf(out, " --no-pictures");
    if (o->camera >= 0) fprintf(out, " --camera %ld", o->camera);
    if (!isnan(o->at)) fprintf(out, " --at %g", o->at);
    if (o->threads) fprintf(out, " --threads %ld", o->threads);
    if (o->isa) fprintf(out, " --isa %s", o->isa);
}

/* NULL: out of memory. The caller frees it. */
static char *make_command(const cost_options *o, daft_error *error)
{
    draft_file command;
    if (!draft_open(&command, error)) return NULL;
    print_command(o, command.file);
    if (fclose(command.file) == 0) return command.bytes;
    fail(error, DAFT_ERROR_MEMORY, "out of memory for a report");
    return NULL;
}

static bool write_report(const cost_options *o, const sweep_result *all, daft_error *error)
{
    char *command = make_command(o, error);
    if (!command) return false;
    const report_def page = {all, o->what, command, o->out, o->budget, (int)o->threads, o->no_pictures};
    const bool good = report_write(&page, error);
    if (good) report_print(&page, stdout);
    free(command);
    return good;
}

/* Where the report cannot be written, it is told before anything is measured. */
static bool try_folder(const cost_options *o, daft_error *error)
{
    char path[PATH_SIZE];
    if (!make_folder(o->out, error)) return false;
    if (!path_join(path, sizeof path, o->out, "report.json"))
        return fail(error, DAFT_ERROR_ARGUMENT, "%s: the path is too long", o->out);
    daft_writer *writer = daft_writer_begin(path, error);
    daft_writer_abandon(writer);
    return writer != NULL;
}

/* Measures a scene, or a game at its moments. */
static bool measure(const cost_options *o, const sweep_def *what, daft_error *error)
{
    sweep_result all;
    sweep_def def = *what;
    def.preset = o->quality, def.fixed = o->knobs;
    def.width = o->size.width, def.height = o->size.height;
    def.seconds = o->quick ? QUICK_SECONDS : DEFAULT_SECONDS;
    def.quick = o->quick;
    def.knob = o->only;
    if (!try_folder(o, error) || !sweep_run(&all, &def, error)) return false;
    const bool good = sweep_confirm(&all, o->budget, error) && write_report(o, &all, error);
    sweep_free(&all);
    return good;
}

static bool cost_of_scene(const cost_options *o, daft_engine *engine, daft_error *error)
{
    film_scene scene;
    film_scene_def def = {engine, o->what, o->camera < 0 ? 0 : o->camera, DAFT_PACE_TIMED, {.preset = o->quality}};
    if (!film_scene_open(&scene, &def, error)) return false;
    const bool good = measure(o, &(sweep_def){.engine = engine, .scene = scene.scene, .view = scene.view}, error);
    film_scene_close(&scene);
    return good;
}

/* ---- games ------------------------------------------------------------------------------------------------------- */

typedef struct game_moments {
    const cost_options *o;
    film_game *game;
    daft_image *picture;
    int count, now;
    double seconds[SWEEP_MOMENTS];
} game_moments;

/* Spread over the demo; without one, over the first seconds. */
static void choose_moments(game_moments *m)
{
    const double end = m->game->has_replay ? (double)m->game->replay.end / LOOP_RATE : PLAYED_SECONDS;
    m->count = !isnan(m->o->at) ? 1 : m->o->quick ? QUICK_MOMENTS : SWEEP_MOMENTS;
    for (int i = 0; i < m->count; i++)
        m->seconds[i] = !isnan(m->o->at) ? m->o->at : floor((i + 0.5) / m->count * end * LOOP_RATE) / LOOP_RATE;
}

/* Plays without drawing until the next moment. */
static bool go_on(void *user, daft_error *error)
{
    game_moments *m = user;
    const double at = m->seconds[m->now++];
    const frame_result result = m->game->source.draw(&m->game->source, at, false, m->picture, error);
    if (result == FRAME_FAILED) return false;
    return result == FRAME_DRAWN ||
           fail(error, DAFT_ERROR_ARGUMENT, "%s: the game ends before %g s: nothing to measure", m->o->what, at);
}

static bool simulate(const cost_options *o, daft_scene *scene, game_moments *m, daft_error *error)
{
    sim_result all;
    const sim_def def = {scene, m->count, go_on, m, o->quick ? QUICK_SECONDS : DEFAULT_SECONDS};
    char *command = make_command(o, error);
    bool good = command && try_folder(o, error) && sim_run(&all, &def, error);
    const sim_report_def page = {&all, o->what, command, o->out, o->budget};
    good = good && sim_write(&page, error);
    if (good) sim_print(&page, stdout);
    free(command);
    return good;
}

static bool cost_in_game(const cost_options *o, daft_engine *engine, film_game *game, daft_error *error)
{
    game_moments m = {.o = o, .game = game};
    choose_moments(&m);
    m.picture = daft_image_create(engine, o->size.width, o->size.height, error);
    if (!m.picture) return false;
    if (o->sim) {
        const bool simulated = simulate(o, game->play.scene, &m, error);
        daft_image_destroy(m.picture);
        return simulated;
    }
    const sweep_def def = {.engine = engine,
                           .scene = game->play.scene,
                           .view = daft_default_view(),
                           .moments = m.count,
                           .next = go_on,
                           .user = &m};
    const bool good = measure(o, &def, error);
    daft_image_destroy(m.picture);
    return good;
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
                     .quality.preset = DAFT_PRESET_GAME,
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

/* Cuts a copy of the text into the settings. */
static int run_own(cost_options *o)
{
    daft_error error;
    knob_row row;
    char *text = strdup(o->settings);
    const bool good = text ? knob_own(text, &row, &error) : fail(&error, DAFT_ERROR_MEMORY, "out of memory");
    o->only = &row;
    const int status = good ? run(o) : cli_refuse("cost", "--settings: %s", error.message);
    free(text);
    return status;
}

static int refuse_knob(const char *name)
{
    char known[300] = "";
    for (size_t k = 0, used = 0; k < KNOBS && used < sizeof known; k++)
        used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", k ? ", " : "", knob_at(k)->name);
    return cli_refuse("cost", "--knob: there is no '%s', but %s", name, known);
}

int command_cost(int argc, char **argv)
{
    cost_options o = {.out = "cost", .quality = DAFT_PRESET_GAME, .budget = 16, .at = NAN, .camera = -1};
    const cli_option options[] = {
        {"budget", 0, CLI_NUMBER, "MS", &o.budget, 0, 60000, "milliseconds that a picture may take (16)"},
        {"output", 'o', CLI_TEXT, "DIR", &o.out, 0, 0, "the folder for the report (cost)"},
        {"sim", 0, CLI_FLAG, NULL, &o.sim, 0, 0,
         "of the game's simulation in place of its pictures: substeps and rates against 3,840 steps a second"},
        {"quick", 0, CLI_FLAG, NULL, &o.quick, 0, 0, "fewer combinations and a coarser reference, within 30 s"},
        {"knob", 0, CLI_TEXT, "NAME", &o.knob, 0, 0,
         "this knob alone, without combinations: antialiasing, shadows, ..."},
        {"settings", 0, CLI_TEXT, "LIST", &o.settings, 0, 0,
         "these settings alone, apart by semicolons, up to ten: 'samples=8;edge_samples=16'"},
        {"no-pictures", 0, CLI_FLAG, NULL, &o.no_pictures, 0, 0, "a page of plots and tables alone, of 100 KB"},
        {"size", 0, CLI_SIZE, "WxH", &o.size, 16, 1920, "size of the picture (640x360; quick: 320x180)"},
        {"quality", 'q', CLI_QUALITY, "Q", &o.quality, 0, 0,
         "the preset from which knobs differ: draft, game (default), high or reference"},
        {"knobs", 'k', CLI_KNOBS, "LIST", &o.knobs, 0, 0,
         "values that every picture has, the reference too: occlusion_samples=0 where the game goes without"},
        {"camera", 0, CLI_COUNT, "N", &o.camera, 0, 1000000, "the N-th camera of the scene, counted from 0 (0)"},
        {"at", 0, CLI_NUMBER, "S", &o.at, 0, 86400, "one second of the game alone (moments of its demo)"},
        {"threads", 't', CLI_COUNT, "N", &o.threads, 0, 64,
         "worker threads; 0, the default, is one for each processor"},
        {"isa", 0, CLI_ISA, "X", &o.isa, 0, 0, "plain, sse2, avx2 or avx512; default: the best available"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    o.what = operands[0];
    if (o.sim && has_extension(o.what, ".scene"))
        return cli_refuse("cost", "--sim: a game expected, a scene has no bodies");
    if (o.size.width == 0) o.size = o.quick ? (cli_size){320, 180} : (cli_size){640, 360};
    if (o.knob && !knob_named(o.knob)) return refuse_knob(o.knob);
    if (o.settings && (o.knob || o.sim)) return cli_refuse("cost", "--settings: without --knob and --sim");
    if (!(o.budget > 0)) return cli_refuse("cost", "--budget: a number above 0 expected");
    o.only = o.knob ? knob_named(o.knob) : NULL;
    return o.settings ? run_own(&o) : run(&o);
}
