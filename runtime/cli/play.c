/* daft play: runs a game in a window, the menu of games, or a game without a window. */
#include "cli/commands.h"

#include "cli/cli.h"
#include "game/loop.h"
#include "session/menu.h"
#include "session/session.h"
#include "session/costs.h"
#include "platform/seal.h"
#include "common/util.h"
#include "platform/audio.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const cli_command COMMAND = {
    "play",
    "[GAME]",
    "Plays a game: a folder with a main.lua, a packed game (.daft), or the name of one in games/. Without GAME, shows "
    "a menu.",
    "Keys: Esc opens a menu, F1 shows the time of each effect and of the last frames, F2 what other settings would "
    "cost, F3 the shapes and contacts of "
    "bodies, F4 the fields of an entity, F5 and F6 go back and forward in time, the key left of 1 opens a console for "
    "Lua, F11 or Alt+Enter toggles full "
    "screen, F12 writes a picture.\n"
    "Without a display it plays the game's recorded demo (marble's when GAME is missing) and writes daft-demo.png.",
    0,
    1};

static const char DEFAULT_GAME[] = "marble", DEMO_PICTURE[] = "daft-demo.png";
enum { DEMO_TICKS = 600 };

typedef struct play_options {
    bool headless, hash, every_frame, mute;
    long ticks, threads, shot_tick, seed;
    cli_size size;
    double scale, seconds;
    quality_wish quality;
    double target_ms;
    const char *saves;
    char kept[PATH_SIZE];  /* the folder of what games keep; empty: none */
    char costs[PATH_SIZE]; /* the folder that remembers what pictures cost; empty: none */
    uint64_t memory;
    bool strict;
    const char *speed_text;
    double speed; /* 0: not said */
    const char *sandbox, *record, *replay, *isa, *shot, *stats, *profile, *sound, *trace, *game;
} play_options;

typedef struct player {
    play_options options;
    home where;
    daft_engine *engine;
    font *face;
    platform *screen;
    game_info game; /* unless there is the menu */
    game_source source;
    bool speaks; /* through a loudspeaker */
    editor *editor;
} player;

static session_def base_session(const player *p)
{
    const play_options *o = &p->options;
    return (session_def){.screen = p->screen,
                         .engine = p->engine,
                         .where = &p->where,
                         .source = p->source.files ? &p->source : NULL,
                         .face = p->face,
                         .quality = o->quality,
                         .scale = o->scale,
                         .target_ms = o->target_ms >= 0                       ? o->target_ms
                                      : o->quality.preset == QUALITY_OF_SCENE ? -1
                                                                              : 0,
                         .saves = o->kept[0] ? o->kept : NULL,
                         .costs = o->costs[0] ? o->costs : NULL,
                         .pauses = !p->screen->headless,
                         .watches = !p->screen->headless,
                         .settings = o->kept[0] ? o->kept : NULL,
                         .editor = p->editor,
                         .fixed_size = p->screen->headless,
                         .seed = (uint64_t)o->seed,
                         .ticks = (uint64_t)o->ticks,
                         .hash = o->hash,
                         .every_frame = o->every_frame,
                         .record = o->record,
                         .replay = o->replay,
                         .strict = o->strict,
                         .speed = o->speed,
                         .shot = o->shot,
                         .shot_tick = (uint64_t)o->shot_tick,
                         .stats = o->stats,
                         .profile = o->profile,
                         .sound = o->sound,
                         .trace = o->trace,
                         .speaks = p->speaks,
                         .seconds = o->seconds};
}

static int finish(session_end end, const daft_error *error)
{
    if (end != SESSION_FAILED) return STATUS_DONE;
    return error->code == DAFT_OK ? STATUS_BAD_INPUT : report(error);
}

static bool find_game(player *p)
{
    daft_error error;
    if (p->source.files) return true;
    if (home_find_game(&p->where, p->options.game ? p->options.game : DEFAULT_GAME, &p->game, &error) &&
        source_open(&p->source, &p->where, &p->game, &error)) {
        char name[PATH_SIZE];
        if (p->game.packed)
            fprintf(stderr, "%s: SHA-256 %s\n", daft_escape(p->game.folder, name, sizeof name), p->source.hash);
        return true;
    }
    report(&error);
    return false;
}

static bool open_null(player *p, int width, int height)
{
    daft_error error;
    if (p->options.size.width) width = p->options.size.width, height = p->options.size.height;
    p->screen = platform_open_null(width, height, LOOP_RATE, &error);
    if (!p->screen) report(&error);
    return p->screen != NULL;
}

/* The folder that a file is written to; NULL: none. */
static const char *folder_of(const char *path, char out[PATH_SIZE])
{
    if (!path || strcmp(path, "-") == 0) return NULL;
    const char *slash = strrchr(path, '/');
    snprintf(out, PATH_SIZE, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
    return out;
}

/* Before the game's first line runs, once the window is open. In a window F12 writes pictures to the current folder. */
static bool seal(const player *p, const session_def *session)
{
    const play_options *o = &p->options;
    char folders[6][PATH_SIZE], libraries[PATH_SIZE + 8];
    daft_error error;
    if (strcmp(o->sandbox, "off") == 0) return true;
    snprintf(libraries, sizeof libraries, "%s/../lib", p->where.scripts); /* of a game that is a program of its own */
    seal_def def = {.readable = {p->source.files ? p->game.folder : p->where.games, p->where.assets, p->where.scripts,
                                 libraries, session->replay, session->costs, session->saves},
                    .writable = {folder_of(session->record, folders[0]), folder_of(session->shot, folders[1]),
                                 folder_of(session->stats, folders[2]), folder_of(session->sound, folders[3]),
                                 folder_of(session->trace, folders[4]), folder_of(session->profile, folders[5]),
                                 p->screen->headless ? NULL : ".", session->costs, session->saves},
                    .window = !p->screen->headless};
    if (seal_process(&def, &error)) return true;
    report(&error);
    if (strcmp(o->sandbox, "on") == 0) return false;
    fprintf(stderr, "daft: going on without that part of the sandbox\n");
    return true;
}

/* False, with a message, where the sandbox is asked for and the system lacks a part of it. */
static bool can_seal(const play_options *o)
{
    seal_ability has = seal_look();
    if (strcmp(o->sandbox, "on") != 0 || (has.landlock && has.seccomp && !has.obstacle)) return true;
    fprintf(stderr, "daft: --sandbox on: %s\n",
            has.obstacle   ? has.obstacle
            : has.landlock ? "this system has no seccomp"
                           : "this system has no Landlock");
    return false;
}

static int play_headless(player *p)
{
    daft_error error;
    if (!find_game(p) || !open_null(p, 320, 180)) return STATUS_BAD_INPUT;
    session_def def = base_session(p);
    if (!def.ticks && !def.replay) def.ticks = DEMO_TICKS;
    if (!seal(p, &def)) return STATUS_BAD_INPUT;
    return finish(session_play(&def, &p->game, &error), &error);
}

/* Ten seconds, or the whole recording when it is shorter. */
static bool demo_ticks(const daft_files *files, const char *replay, uint64_t *ticks, daft_error *error)
{
    *ticks = DEMO_TICKS;
    if (!replay) return true;
    recording record;
    if (!recording_load(&record, files, replay, error)) return false;
    if (record.end > 0 && record.end < DEMO_TICKS) *ticks = record.end;
    recording_free(&record);
    return true;
}

/* Without a display: plays the game's recorded demo and writes its last picture. */
static int play_demo(player *p, const char *why)
{
    daft_error error;
    if (!find_game(p) || !open_null(p, 1280, 720)) return STATUS_BAD_INPUT;
    session_def def = base_session(p);
    char demo[PATH_SIZE + 16];
    def.replay_inside = !def.replay && daft_files_find(p->source.files, "demo.rec", demo, sizeof demo);
    if (def.replay_inside) def.replay = demo;
    fprintf(stderr, "daft: there is no display (%s): playing %s of %s without a window.\n", why,
            def.replay ? "the recorded demo" : "ten seconds", p->game.title);
    if (!def.ticks && !demo_ticks(def.replay_inside ? p->source.files : NULL, def.replay, &def.ticks, &error))
        return report(&error);
    def.progress = true;
    if (!def.hash && !def.every_frame)
        def.quality.preset = p->options.quality.preset == QUALITY_OF_SCENE ? DAFT_PRESET_HIGH /* only one frame is drawn
                                                                                               */
                                                                           : p->options.quality.preset;
    if (!def.shot) def.shot = DEMO_PICTURE, def.shot_tick = 0;
    if (!seal(p, &def)) return STATUS_BAD_INPUT;
    uint64_t began = clock_now_ns();
    session_end end = session_play(&def, &p->game, &error);
    if (end == SESSION_FAILED) return finish(end, &error);
    fprintf(stderr, "daft: played %.0f seconds of game in %.1f s and wrote %s.\n", (double)def.ticks / 60,
            (double)(clock_now_ns() - began) / 1e9, def.shot);
    return STATUS_DONE;
}

static int play_menu(player *p)
{
    size_t count, chosen = 0;
    game_info *games = home_list_games(&p->where, &count);
    session_def def = base_session(p);
    def.stays = true;
    int status = seal(p, &def) ? STATUS_DONE : STATUS_BAD_INPUT;
    while (status == STATUS_DONE) {
        daft_error error;
        menu_end picked = menu_show(&def, games, count, &chosen, &error);
        if (picked == MENU_FAILED) status = report(&error);
        if (picked != MENU_CHOSEN) break;
        session_end end = session_play(&def, &games[chosen], &error);
        if (end == SESSION_FAILED) status = finish(end, &error);
        if (end == SESSION_FAILED || end == SESSION_CLOSED) break;
    }
    free(games);
    return status;
}

static int play(player *p)
{
    daft_error error;
    if (!home_find(&p->where, &error)) return report(&error);
    if (p->options.game && !find_game(p)) return STATUS_BAD_INPUT; /* report it before a window opens */
    p->face = open_font(&p->where, &error);
    if (!p->face) return report(&error);
    daft_engine_def def = daft_default_engine_def();
    def.threads = (int)p->options.threads;
    def.isa = p->options.isa;
    def.memory_limit = p->options.memory;
    p->engine = open_engine(&def);
    if (!p->engine) return STATUS_BAD_INPUT;
    if (p->options.headless) return play_headless(p);
    if (!p->game.packed) p->editor = editor_start(p->options.game ? p->game.folder : p->where.games);
    cli_size size = p->options.size.width ? p->options.size : (cli_size){1280, 720};
    p->screen = platform_open_sdl("DAFT", size.width, size.height, &error);
    if (!p->screen) return play_demo(p, error.message);
    p->speaks = !p->options.mute && audio_open(&error);
    if (!p->options.saves && !home_user_folder("XDG_DATA_HOME", ".local/share", p->options.kept, PATH_SIZE))
        p->options.kept[0] = 0;
    if (!costs_folder(p->options.costs, sizeof p->options.costs)) p->options.costs[0] = 0;
    if (!p->options.game) return play_menu(p);
    session_def session = base_session(p);
    if (!seal(p, &session)) return STATUS_BAD_INPUT;
    return finish(session_play(&session, &p->game, &error), &error);
}

static bool read_speed(const char *text, double *out)
{
    char *end;
    *out = strcmp(text, "max") == 0 ? INFINITY : strtod(text, &end);
    return isinf(*out) ? strcmp(text, "max") == 0 : end != text && !*end && *out >= 0.01 && *out <= 1000;
}

/* CLI_READY: they are read. */
static cli_outcome read_options(play_options *o, int argc, char **argv)
{
    const cli_option options[] = {
        {"headless", 0, CLI_FLAG, NULL, &o->headless, 0, 0,
         "run without a window, as fast as possible, for tests and servers"},
        {"ticks", 0, CLI_COUNT, "N", &o->ticks, 1, 1000000000,
         "end after N updates of 1/60 s (headless: 600, or the replay's)"},
        {"record", 0, CLI_TEXT, "FILE", &o->record, 0, 0, "record the input to FILE"},
        {"replay", 0, CLI_TEXT, "FILE", &o->replay, 0, 0,
         "play the recording FILE; a window then continues with live input"},
        {"strict", 0, CLI_FLAG, NULL, &o->strict, 0, 0,
         "with --replay: fail where the game has changed, or does not do what was recorded"},
        {"speed", 0, CLI_TEXT, "N", &o->speed_text, 0, 0,
         "with --replay: how fast, 0.01 to 1000, or max (1; headless: max)"},
        {"hash", 0, CLI_FLAG, NULL, &o->hash, 0, 0,
         "print 'tick N state 0x... frame 0x...' every 60 ticks and at the end"},
        {"size", 0, CLI_SIZE, "WxH", &o->size, 16, 8192,
         "size of the window (1280x720); headless: of the picture (320x180)"},
        {"scale", 0, CLI_NUMBER, "F", &o->scale, 0, 4, "resolution of the picture relative to the window (1)"},
        {"target-ms", 0, CLI_NUMBER, "MS", &o->target_ms, 0, 1000,
         "in a window: what a frame may take, by less exact pictures where it must be; 0: any (what the game asks for, "
         "or "
         "16.7; with --quality: any)"},
        {"quality", 'q', CLI_QUALITY, "Q", &o->quality.preset, 0, 0,
         "draft, game, high or reference (what the game asks for, or game)"},
        {"knobs", 'k', CLI_KNOBS, "LIST", &o->quality.knobs, 0, 0,
         "replace single values of the quality: samples=4,shadows=0"},
        {"threads", 't', CLI_COUNT, "N", &o->threads, 0, 64,
         "worker threads; 0, the default, is one for each processor"},
        {"isa", 0, CLI_ISA, "X", &o->isa, 0, 0, "plain, sse2, avx2 or avx512; default: the best available"},
        {"memory-limit", 0, CLI_BYTES, "BYTES", &o->memory, 1000000, 0,
         "what the game may hold, scripts, meshes and pictures together: 500MB, 2GB (1GB)"},
        {"time-limit", 0, CLI_NUMBER, "SECONDS", &o->seconds, 0, 3600,
         "how long one call into the game may take, 0.1 to 3600 (5)"},
        {"saves", 0, CLI_TEXT, "FOLDER", &o->saves, 0, 0,
         "where the game keeps what it saves (a window: your data folder; headless: nothing is kept)"},
        {"seed", 0, CLI_COUNT, "N", &o->seed, 0, 1000000000, "seed of the random numbers (1); a replay uses its own"},
        {"sandbox", 0, CLI_TEXT, "MODE", &o->sandbox, 0, 0,
         "auto (what the system has), on (all of it, or an error), off, or status"},
        {"shot", 0, CLI_TEXT, "FILE", &o->shot, 0, 0, "write a picture (.png, .ppm) at the end"},
        {"shot-tick", 0, CLI_COUNT, "N", &o->shot_tick, 1, 1000000000, "write that picture after update N instead"},
        {"sound", 0, CLI_TEXT, "FILE", &o->sound, 0, 0, "write what sounds to FILE.wav, also without a loudspeaker"},
        {"mute", 0, CLI_FLAG, NULL, &o->mute, 0, 0, "leave the loudspeaker alone"},
        {"stats", 0, CLI_TEXT, "FILE", &o->stats, 0, 0, "write frame times and counters as JSON; - is stdout"},
        {"trace", 0, CLI_TEXT, "FILE", &o->trace, 0, 0,
         "write what took how long, for chrome://tracing or ui.perfetto.dev: FILE.json"},
        {"profile", 0, CLI_TEXT, "FILE", &o->profile, 0, 0,
         "write which lines of the scripts took the time, as a table; - is stdout"},
        {"every-frame", 0, CLI_FLAG, NULL, &o->every_frame, 0, 0, "draw every frame when headless too, for --stats"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    const cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome == CLI_READY && count > 0) o->game = operands[0];
    return outcome;
}

/* STATUS_DONE: they go together. */
static int check_options(play_options *o)
{
    static const char *const SANDBOXES[] = {"auto", "on", "off", "status"};
    bool known = false;
    for (size_t i = 0; i < COUNT_OF(SANDBOXES); i++) known |= strcmp(o->sandbox, SANDBOXES[i]) == 0;
    if (!known) return cli_refuse("play", "--sandbox: auto, on, off or status expected");
    if (o->shot_tick && !o->shot) return cli_refuse("play", "--shot-tick: --shot FILE is missing");
    if (o->saves && !path_is_folder(o->saves)) return cli_refuse("play", "--saves: an existing folder expected");
    if (o->saves && (size_t)snprintf(o->kept, sizeof o->kept, "%s", o->saves) >= sizeof o->kept)
        return cli_refuse("play", "--saves: the path is too long");
    if (!(o->scale > 0)) return cli_refuse("play", "--scale: a number above 0 expected");
    if (!(o->seconds >= 0.1)) return cli_refuse("play", "--time-limit: a number from 0.1 to 3600 expected");
    if (o->strict && !o->replay) return cli_refuse("play", "--strict: --replay FILE is missing");
    if (o->speed_text && !o->replay) return cli_refuse("play", "--speed: --replay FILE is missing");
    if (o->speed_text && !read_speed(o->speed_text, &o->speed))
        return cli_refuse("play", "--speed: a number from 0.01 to 1000, or max, expected");
    return STATUS_DONE;
}

static void close_player(player *p)
{
    audio_close();
    if (p->screen) p->screen->close(p->screen);
    font_close(p->face);
    daft_engine_destroy(p->engine);
    source_close(&p->source);
    editor_close(p->editor);
}

int command_play(int argc, char **argv)
{
    player p = {.options = {.sandbox = "auto",
                            .scale = 1,
                            .memory = HOST_MEMORY,
                            .seconds = WATCHDOG_SECONDS,
                            .quality.preset = QUALITY_OF_SCENE,
                            .target_ms = -1,
                            .seed = 1}};
    const cli_outcome outcome = read_options(&p.options, argc, argv);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    int status = check_options(&p.options);
    if (status != STATUS_DONE) return status;
    if (strcmp(p.options.sandbox, "status") == 0) {
        seal_print_status();
        return STATUS_DONE;
    }
    if (!can_seal(&p.options)) return STATUS_BAD_INPUT;
    status = play(&p);
    close_player(&p);
    return status;
}
