/* Rows `game frame, NAME`: each game of games/ that has a demo.rec plays it to the end in the program itself, without a
 * window, every frame drawn; the program's own clock times each frame, HUD included. The peer, llvmpipe with one sample
 * a pixel, plays the same demo, without HUD, and without shadows of lamps or, in rows `…, all shadows`, with them. And
 * how long the program takes to start. */
#include "frames/users.h"

#include <dirent.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { MAX_ARGUMENTS = 24 };

/* Runs the program, with nothing on the terminal, to its end. Milliseconds; negative if it failed. */
static double run_program(const char *const *words, size_t count)
{
    char *arguments[MAX_ARGUMENTS + 1] = {0};
    for (size_t i = 0; i < count && i < MAX_ARGUMENTS; i++) arguments[i] = (char *)(uintptr_t)words[i];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t child;
    int status = 1;
    double start = daft_clock_ms();
    bool started = posix_spawn(&child, DAFT_PROGRAM, &actions, NULL, arguments, environ) == 0;
    if (started) waitpid(child, &status, 0);
    double ms = daft_clock_ms() - start;
    posix_spawn_file_actions_destroy(&actions);
    return started && status == 0 ? ms : -1;
}

/* ---- start-up ---- */

typedef struct start_job {
    const char *isa;
    char threads[16];
} start_job;

static double start_up(void *context)
{
    const start_job *job = context;
    const char *const words[] = {"daft",   "play",      "marble",     "--headless", "--ticks", "1",
                                 "--hash", "--threads", job->threads, "--isa",      job->isa};
    return run_program(words, DAFT_COUNT_OF(words));
}

static void start_up_describe(void *context, char *out, size_t size)
{
    (void)context;
    snprintf(out, size, "the whole process: start, load, one tick, one frame, end");
}

void bench_start_up(bench *self)
{
    int counts[2], count = bench_thread_counts(self, counts);
    if (!bench_wants(self, "marble", "start-up")) return;
    start_job job = {.isa = self->isa};
    snprintf(job.threads, sizeof job.threads, "%d", counts[count - 1]);
    bench_subject subject = {.scene = "marble",
                             .what = "start-up",
                             .unit = "ms",
                             .isa = self->isa,
                             .threads = counts[count - 1],
                             .ours = start_up,
                             .context = &job,
                             .describe = start_up_describe,
                             .budget = {200, 80, true}};
    bench_measure(self, &subject);
}

/* ---- frames ---- */

static const char *const EFFECTS[DAFT_EFFECT_COUNT] = {
    [DAFT_EFFECT_VISIBILITY] = "visibility", [DAFT_EFFECT_SURFACE] = "surface",
    [DAFT_EFFECT_TEXTURE] = "texture",       [DAFT_EFFECT_SHADOW] = "shadow",
    [DAFT_EFFECT_LIGHTING] = "lighting",     [DAFT_EFFECT_REFLECTION] = "reflection",
    [DAFT_EFFECT_REFRACTION] = "refraction", [DAFT_EFFECT_SKY] = "sky",
    [DAFT_EFFECT_RESOLVE] = "resolve"};

static void read_stats(const char *json, users_frames *out)
{
    const char *effects = strstr(json, "\"effects\"");
    users_read_times(json, out);
    for (int i = 0; i < DAFT_EFFECT_COUNT; i++) {
        char key[64];
        snprintf(key, sizeof key, "\"%s\":", EFFECTS[i]);
        const char *at = effects ? strstr(effects, key) : NULL;
        if (at) out->names[i] = EFFECTS[i], out->effects[i] = users_number(at, "mean_ms");
    }
}

/* One whole demo. */
static bool play_demo(bench *self, const char *game, int threads, users_frames *out)
{
    char demo[512], stats[256], count[16];
    const char *folder = getenv("TMPDIR");
    snprintf(demo, sizeof demo, "%s/games/%s/demo.rec", DAFT_ROOT, game);
    snprintf(stats, sizeof stats, "%s/daft_bench_%ld.json", folder ? folder : "/tmp", (long)getpid());
    snprintf(count, sizeof count, "%d", threads);
    const char *const words[] = {"daft",     "play",      game,     "--headless", "--every-frame",
                                 "--replay", demo,        "--size", "1280x720",   "--stats",
                                 stats,      "--threads", count,    "--isa",      self->isa};
    size_t size;
    bool played = run_program(words, DAFT_COUNT_OF(words)) >= 0;
    char *json = played ? daft_file_read(&self->allocator, NULL, stats, &size, NULL) : NULL;
    if (json) read_stats(json, out);
    daft_release(&self->allocator, json);
    unlink(stats);
    return json != NULL;
}

/* The best of two demos, unless --rounds says how many. */
static void measure_game(bench *self, const char *scene, const char *game, int threads, users_beside peer)
{
    users_frames best = {0};
    fprintf(stderr, "%s, %d thread%s\n", scene, threads, threads == 1 ? "" : "s");
    for (int i = 0; i < (self->rounds ? self->rounds : 2); i++) {
        users_frames f;
        if (!play_demo(self, game, threads, &f) || f.frames < 1) {
            bench_note(self, true, "%s failed", scene);
            return;
        }
        if (i == 0 || f.p95 < best.p95) best = f;
        users_peer(self, "game", game, threads, &peer);
    }
    bool two = threads == 2; /* what the budget is for */
    users_report(self, scene, threads, &best, &peer, "the whole demo", two ? 1e3 / 60 : 0, two ? 1e3 / 120 : 0);
}

static const struct {
    const char *name;
    users_beside peer;
} KINDS[] = {{"", USERS_BESIDE_PLAIN}, {", all shadows", USERS_BESIDE_ALL_SHADOWS}};

void bench_games(bench *self)
{
    struct dirent **games;
    int found = scandir(DAFT_ROOT "/games", &games, users_has_demo, alphasort), counts[2],
        count = bench_thread_counts(self, counts);
    for (int i = 0; i < found; i++) {
        for (size_t k = 0; k < DAFT_COUNT_OF(KINDS); k++) {
            char scene[64];
            snprintf(scene, sizeof scene, "game frame, %.36s%s", games[i]->d_name, KINDS[k].name);
            if (users_wants(self, scene))
                for (int t = 0; t < count; t++) measure_game(self, scene, games[i]->d_name, counts[t], KINDS[k].peer);
        }
        free(games[i]);
    }
    if (found >= 0) free(games);
}
