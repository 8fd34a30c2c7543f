/* The program as a user meets it: how long it takes to start, and the marble game's frames as its demo begins. */
#include "bench.h"

#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { MAX_ARGUMENTS = 24 };

typedef struct game_job {
    bench *self;
    char *arguments[MAX_ARGUMENTS + 1];
    char stats[256];
    double median, p95;
} game_job;

/* Runs the program, with nothing on the terminal, to its end. Milliseconds; negative if it failed. */
static double run_program(const game_job *job)
{
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t child;
    int status = 1;
    double start = daft_clock_ms();
    bool started = posix_spawn(&child, DAFT_PROGRAM, &actions, NULL, job->arguments, environ) == 0;
    if (started) waitpid(child, &status, 0);
    double ms = daft_clock_ms() - start;
    posix_spawn_file_actions_destroy(&actions);
    return started && status == 0 ? ms : -1;
}

static double start_up(void *context) { return run_program(context); }

/* The number after "name": in a JSON text; negative where there is none. */
static double number_after(const char *json, const char *name)
{
    char key[64];
    snprintf(key, sizeof key, "\"%s\":", name);
    const char *found = json ? strstr(json, key) : NULL;
    return found ? strtod(found + strlen(key), NULL) : -1;
}

static double frames(void *context)
{
    game_job *job = context;
    if (run_program(job) < 0) return -1;
    size_t size;
    char *json = daft_file_read(&job->self->allocator, job->stats, &size, NULL);
    const char *frame = json ? strstr(json, "\"frame_ms\"") : NULL;
    job->median = number_after(frame, "median");
    job->p95 = number_after(frame, "p95");
    daft_release(&job->self->allocator, json);
    unlink(job->stats);
    return job->median;
}

static void frames_describe(void *context, char *out, size_t size)
{
    game_job *job = context;
    snprintf(out, size, "median of the demo's first 150 frames; 95%% take less than %.2f ms", job->p95);
}

static void start_up_describe(void *context, char *out, size_t size)
{
    (void)context;
    snprintf(out, size, "the whole process: start, load, one tick, one frame, end");
}

static void set_arguments(game_job *job, const char *const *words, size_t count)
{
    for (size_t i = 0; i < count && i < MAX_ARGUMENTS; i++) job->arguments[i] = (char *)(uintptr_t)words[i];
}

void bench_game(bench *self)
{
    char threads[16];
    int counts[2], count = bench_thread_counts(self, counts);
    game_job job = {.self = self};
    if (bench_wants(self, "marble", "start-up")) {
        snprintf(threads, sizeof threads, "%d", counts[count - 1]);
        const char *const words[] = {"daft", "play", "marble", "--headless", "--ticks", "1", "--hash", "--threads", threads,
                                     "--isa", self->isa};
        set_arguments(&job, words, DAFT_COUNT_OF(words));
        bench_subject subject = {.scene = "marble", .what = "start-up", .unit = "ms", .isa = self->isa,
                                 .threads = counts[count - 1], .ours = start_up, .context = &job,
                                 .describe = start_up_describe, .budget = {200, 80, true}};
        bench_measure(self, &subject);
    }
    if (!bench_wants(self, "marble", "frame at 1280x720")) return;
    const char *folder = getenv("TMPDIR");
    snprintf(job.stats, sizeof job.stats, "%s/daft_bench_%ld.json", folder ? folder : "/tmp", (long)getpid());
    for (int t = 0; t < count; t++) {
        snprintf(threads, sizeof threads, "%d", counts[t]);
        const char *const words[] = {"daft", "play", "marble", "--headless", "--every-frame", "--replay",
                                     DAFT_ROOT "/games/marble/demo.rec", "--ticks", "150", "--size", "1280x720",
                                     "--stats", job.stats, "--threads", threads, "--isa", self->isa};
        set_arguments(&job, words, DAFT_COUNT_OF(words));
        bench_subject subject = {.scene = "marble", .what = "frame at 1280x720", .unit = "ms", .isa = self->isa,
                                 .threads = counts[t], .ours = frames, .context = &job, .describe = frames_describe,
                                 .budget = {counts[t] == 2 ? 1e3 / 60 : 0, counts[t] == 2 ? 1e3 / 120 : 0, true}};
        bench_measure(self, &subject);
    }
}
