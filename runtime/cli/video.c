/* daft video: films a scene or a game. */
#include "cli/commands.h"

#include "cli/cli.h"
#include "common/util.h"
#include "game/loop.h"
#include "video/soundtrack.h"
#include "video/film_game.h"
#include "video/film_scene.h"
#include "video/video.h"

#include <ftw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const cli_command COMMAND = {
    "video",
    "SCENE|GAME",
    "Films a game as a recording replays it, or a scene along its camera path.",
    "The name after -o chooses the format: FILE.mp4 (H.264), FILE.webm (VP9), FILE.gif, NAME%05d.png (numbered\n"
    "pictures), or - for raw RGBA frames on standard output. A game without --replay plays its demo. A call that was\n"
    "interrupted goes on where it stopped when it is repeated; until then what is done lies in FILE.parts.",
    1,
    1};

enum { STILL_SECONDS = 5, GAME_SECONDS = 10, DEFAULT_CRF = 18, GIF_FPS = 25, FPS = 60 };

typedef struct video_options {
    const char *what, *out, *replay, *isa;
    cli_size size;
    quality_wish quality;
    double fps, from, to, seconds;
    long blur, crf, camera, threads, seed;
    const char *pace_name;
    daft_pace pace;
} video_options;

/* What a film depends on, as far as it can be told without playing: name, size and time of each file of the game. The
 * sum does not depend on the order in which the folder lists them. */
static uint64_t folder_sum;

static int add_file(const char *path, const struct stat *status, int type, struct FTW *where)
{
    (void)where;
    uint64_t numbers[3] = {(uint64_t)status->st_size, (uint64_t)status->st_mtim.tv_sec,
                           (uint64_t)status->st_mtim.tv_nsec};
    if (type == FTW_F) folder_sum += daft_hash(numbers, sizeof numbers, daft_hash(path, strlen(path), 0));
    return 0;
}

static uint64_t hash_content(const char *path)
{
    enum { DESCRIPTORS = 16 };
    folder_sum = 0;
    nftw(path, add_file, DESCRIPTORS, FTW_PHYS);
    return folder_sum;
}

static uint64_t hash_settings(const video_options *o, const char *replay, const char *path)
{
    long numbers[4] = {(long)o->quality.preset, o->camera, o->seed, (long)o->pace};
    uint64_t hash = daft_hash(numbers, sizeof numbers, hash_content(path));
    if (o->quality.knobs) hash = daft_hash(o->quality.knobs, strlen(o->quality.knobs), hash);
    return replay ? hash ^ hash_content(replay) : hash;
}

static bool write_film(video_def *def, frame_source *source, daft_error *error)
{
    uint64_t began = clock_now_ns();
    if (!video_make(def, source, error)) return false;
    if (def->format != VIDEO_RAW)
        fprintf(stderr, "daft: wrote %s: %g s at %dx%d in %.1f s\n", def->out,
                (double)video_frames(def) * 1000 / def->rate, def->width, def->height,
                (double)(clock_now_ns() - began) / 1e9);
    return true;
}

static bool film_a_scene(const video_options *o, video_def *def, daft_error *error)
{
    film_scene scene;
    film_scene_def wanted = {def->engine, o->what, o->camera, o->pace, o->quality};
    def->content = hash_settings(o, NULL, o->what);
    if (!film_scene_open(&scene, &wanted, error)) return false;
    if (isnan(def->to)) def->to = scene.count > 0 ? scene.seconds : def->from + STILL_SECONDS;
    bool good = write_film(def, &scene.source, error);
    film_scene_close(&scene);
    return good;
}

/* The recording to play: the one that was named, else the game's demo, else none. */
static const char *choose_replay(const video_options *o, const game_source *source, char demo[PATH_SIZE + 16])
{
    if (o->replay) return o->replay;
    return daft_files_find(source->files, "demo.rec", demo, PATH_SIZE + 16) ? demo : NULL;
}

/* ---- sound ---- */

typedef struct listener {
    soundtrack *to;
    double from; /* seconds */
    uint64_t tick;
    bool good;
    daft_error *error;
} listener;

static void hear(void *user, const int16_t *frames)
{
    listener *l = user;
    if (l->good && (double)l->tick++ >= floor(l->from * LOOP_RATE + 1e-6))
        l->good = soundtrack_add(l->to, frames, SOUND_TICK, l->error);
}

/* The whole game once more, without pictures, which takes little. What fails here fails again where it is drawn. */
static bool play_for_sound(const video_def *def, const game_def *play, const char *replay, bool inside, listener *l,
                           daft_error *error)
{
    film_game game;
    game_def heard = *play;
    heard.heard = hear, heard.user = l;
    if (!film_game_open(&game, &heard, replay, inside, error)) return false;
    const double last = !isnan(def->to) ? def->to : replay ? (double)game.replay.end / LOOP_RATE : GAME_SECONDS;
    while (l->good && !game.play.over && (double)game.play.ticks < last * LOOP_RATE && game_tick(&game.play)) {
        if (game.has_replay && game.play.ticks >= game.replay.end) break;
    }
    film_game_close(&game);
    return l->good && soundtrack_finish(l->to, error);
}

/* NULL: the film is silent, and why is said. */
static soundtrack *hear_game(const video_def *def, const game_def *play, const char *replay, bool inside)
{
    daft_error error = {0};
    if (def->format != VIDEO_MP4 && def->format != VIDEO_WEBM) return NULL;
    listener l = {.to = soundtrack_open(def->format, &error), .from = def->from, .good = true, .error = &error};
    if (l.to && play_for_sound(def, play, replay, inside, &l, &error)) return l.to;
    if (!l.to) fprintf(stderr, "daft: the film is silent: %s\n", error.message);
    soundtrack_close(l.to);
    return NULL;
}

static bool film_found(const video_options *o, video_def *def, const game_def *play, daft_error *error)
{
    film_game game;
    char demo[PATH_SIZE + 16];
    const char *replay = choose_replay(o, play->source, demo);
    def->content = hash_settings(o, replay, play->info->folder);
    soundtrack *heard = hear_game(def, play, replay, replay == demo);
    def->sound = heard;
    if (!film_game_open(&game, play, replay, replay == demo, error)) {
        soundtrack_close(heard);
        return false;
    }
    if (isnan(def->to)) def->to = replay ? (double)game.replay.end / LOOP_RATE : GAME_SECONDS;
    bool good = write_film(def, &game.source, error);
    film_game_close(&game);
    soundtrack_close(heard);
    return good;
}

static bool film_a_game(const video_options *o, video_def *def, daft_error *error)
{
    home where;
    game_info info;
    game_source source = {0};
    if (!home_find(&where, error) || !home_find_game(&where, o->what, &info, error)) return false;
    font *face = open_font(&where, error);
    game_def play = {.where = &where,
                     .info = &info,
                     .source = &source,
                     .engine = def->engine,
                     .face = face,
                     .quality = o->quality,
                     .seed = (uint64_t)o->seed,
                     .seconds = o->seconds};
    bool good = face && source_open(&source, &where, &info, error) && film_found(o, def, &play, error);
    source_close(&source);
    font_close(face);
    return good;
}

static bool film_it(const video_options *o, video_def *def, daft_error *error)
{
    daft_engine_def wanted = daft_default_engine_def();
    wanted.threads = o->threads || !def->all ? (int)o->threads : many_threads(def->all);
    wanted.isa = o->isa;
    if (!video_check(def, error)) return false;
    def->engine = try_engine(&wanted, error);
    if (!def->engine) return false;
    bool good = has_extension(o->what, ".scene") ? film_a_scene(o, def, error) : film_a_game(o, def, error);
    daft_engine_destroy(def->engine);
    return good;
}

static int run(const video_options *o, video_def *def)
{
    daft_error error;
    if (many_started() && !(def->all = many_join(&error))) return report(&error);
    bool good = film_it(o, def, &error);
    if (!good && def->all) many_drop_out(def->all, &error);
    int status = good ? STATUS_DONE : report(&error);
    many_leave(def->all);
    return status;
}

static bool parse_pace(const char *name, daft_pace *out)
{
    static const char *const names[] = {"timed", "constant", "eased"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        if (strcmp(name, names[i]) != 0) continue;
        *out = (daft_pace)i;
        return true;
    }
    return false;
}

int command_video(int argc, char **argv)
{
    many_hush();
    video_options o = {.size = {1280, 720},
                       .quality.preset = DAFT_PRESET_HIGH,
                       .fps = NAN,
                       .to = NAN,
                       .blur = 1,
                       .crf = DEFAULT_CRF,
                       .camera = -1,
                       .seed = 1,
                       .seconds = WATCHDOG_SECONDS};
    const cli_option options[] = {
        {"output", 'o', CLI_TEXT, "FILE", &o.out, 0, 0, "the film to write (required)"},
        {"replay", 0, CLI_TEXT, "FILE", &o.replay, 0, 0, "the recording that the game plays (its demo)"},
        {"fps", 0, CLI_NUMBER, "N", &o.fps, 1, 240, "frames a second (60; GIF: 25)"},
        {"size", 0, CLI_SIZE, "WxH", &o.size, 16, 8192, "size of the picture (1280x720)"},
        {"quality", 'q', CLI_QUALITY, "Q", &o.quality.preset, 0, 0, "draft, game, high (default) or reference"},
        {"knobs", 'k', CLI_KNOBS, "LIST", &o.quality.knobs, 0, 0,
         "replace single values of the quality: samples=4,shadows=0"},
        {"from", 0, CLI_NUMBER, "S", &o.from, 0, 86400, "begin at second S of the game or scene (0)"},
        {"to", 0, CLI_NUMBER, "S", &o.to, 0, 86400,
         "end at second S (the end of the recording or the path; without one, 10 of a game, 5 of a scene)"},
        {"motion-blur", 0, CLI_COUNT, "N", &o.blur, 1, 64,
         "each frame is the mean of N pictures over half of its time (1: none)"},
        {"crf", 0, CLI_COUNT, "N", &o.crf, 0, 51, "how much H.264 and VP9 may lose: 0 nothing, 51 most (18)"},
        {"camera", 0, CLI_COUNT, "N", &o.camera, 0, 1000000,
         "the N-th camera of the scene, counted from 0, instead of its path"},
        {"pace", 0, CLI_TEXT, "HOW", &o.pace_name, 0, 0,
         "along a path: timed (default), constant speed, or eased: slow at both ends"},
        {"seed", 0, CLI_COUNT, "N", &o.seed, 0, 1000000000, "seed of the random numbers (1); a recording uses its own"},
        {"time-limit", 0, CLI_NUMBER, "SECONDS", &o.seconds, 0, 3600,
         "how long one call into the game may take, 0.1 to 3600 (5)"},
        {"threads", 't', CLI_COUNT, "N", &o.threads, 0, 64,
         "worker threads; 0, the default, is one for each processor"},
        {"isa", 0, CLI_ISA, "X", &o.isa, 0, 0, "plain, sse2, avx2 or avx512; default: the best available"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    o.what = operands[0];
    if (!o.out) return cli_refuse("video", "-o FILE is missing");
    if (!(o.seconds >= 0.1)) return cli_refuse("video", "--time-limit: a number from 0.1 to 3600 expected");
    video_def def = {.out = o.out,
                     .width = o.size.width,
                     .height = o.size.height,
                     .from = o.from,
                     .to = o.to,
                     .crf = (int)o.crf,
                     .blur = (int)o.blur,
                     .progress = true};
    daft_error error;
    if (o.pace_name && !parse_pace(o.pace_name, &o.pace))
        return cli_refuse("video", "--pace: one of timed, constant, eased expected, got '%s'", o.pace_name);
    if (!video_choose_format(o.out, &def.format, &error)) return cli_refuse("video", "%s", error.message);
    if (isnan(o.fps)) o.fps = def.format == VIDEO_GIF ? GIF_FPS : FPS;
    def.rate = (int)lround(o.fps * 1000);
    if (!isnan(o.to) && !(o.to > o.from))
        return cli_refuse("video", "--to: a second after --from (%g) expected", o.from);
    if (o.replay && has_extension(o.what, ".scene")) return cli_refuse("video", "--replay: a scene has no recording");
    return run(&o, &def);
}
