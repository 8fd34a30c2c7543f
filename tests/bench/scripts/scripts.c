/* Rows `lua`: what a game's scripts pay for calls, for moving entities, for pairs in a fixed order, and what a steady
 * game leaves for the garbage collector. Each game in this folder is played by the program itself, and what is told is
 * its processor time less that of the same loop without the work. */
#include "harness/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { TURNS = 2000000, ENTITIES = 10000, TEXT = 512 };

typedef struct script_job {
    const char *game, *without; /* `without`: the same loop that does nothing */
    const char *peer;           /* another loop, against the same; or NULL */
    int ticks;
    double scale; /* of milliseconds a tick, to the row's unit */
} script_job;

static double children_ms(void)
{
    struct rusage use;
    getrusage(RUSAGE_CHILDREN, &use);
    return (double)use.ru_utime.tv_sec * 1e3 + (double)use.ru_utime.tv_usec * 1e-3;
}

/* The processor time of a whole game, with its last words in `said`; negative where it failed. */
static double play(const char *folder, const char *game, int ticks, char said[TEXT])
{
    char command[1024];
    snprintf(command, sizeof command, "exec '%s' play '%s/%s/%s' --headless --threads 1 --ticks %d", DAFT_PROGRAM,
             DAFT_ROOT, folder, game, ticks);
    const double before = children_ms();
    FILE *out = popen(command, "r");
    if (!out) return -1;
    const size_t size = fread(said, 1, TEXT - 1, out);
    said[size] = 0;
    return pclose(out) == 0 ? children_ms() - before : -1;
}

/* The best of some: what disturbs one makes it longer, and the difference of two anything. */
static double best_of(const char *game, int ticks)
{
    enum { TIMES = 5 };
    char said[TEXT];
    double best = -1;
    for (int i = 0; i < TIMES; i++) {
        const double ms = play("tests/bench/scripts", game, ticks, said);
        if (ms < 0) return -1;
        best = best < 0 || ms < best ? ms : best;
    }
    return best;
}

static double difference(const script_job *job, const char *game)
{
    const double with = best_of(game, job->ticks), without = best_of(job->without, job->ticks);
    if (with < 0 || without < 0) return -1;
    return with > without ? (with - without) / job->ticks * job->scale : 0;
}

static double ours(void *context)
{
    const script_job *job = context;
    return difference(job, job->game);
}

static double peer(void *context)
{
    const script_job *job = context;
    return difference(job, job->peer);
}

/* What tests/games/steady says of itself. */
static double garbage(void *context)
{
    (void)context;
    char said[TEXT];
    double bytes = -1;
    if (play("tests/games", "steady", 400, said) < 0 || sscanf(said, "garbage: %lf", &bytes) != 1) return -1;
    return bytes;
}

static void describe_order(void *context, char *out, size_t size)
{
    const script_job *job = context;
    const double own = difference(job, "next");
    snprintf(out, size, "Lua's own order, which hangs on addresses: %.0f ns", own);
}

void bench_scripts(bench *self)
{
    const double each = 1e6 / TURNS; /* nanoseconds a turn, of milliseconds a tick */
    script_job moved = {"move", "still", NULL, 300, 1}, method = {"method", "empty", NULL, 6, each},
               function = {"function", "empty", NULL, 6, each}, order = {"pairs", "empty", "ipairs", 6, each};
    const bench_subject subjects[] = {
        {.scene = "lua",
         .what = "10,000 entities moved",
         .unit = "ms",
         .ours = ours,
         .context = &moved,
         .budget = {2, 1, true}},
        {.scene = "lua",
         .what = "call of a method",
         .unit = "ns",
         .ours = ours,
         .context = &method,
         .budget = {100, 50, true}},
        {.scene = "lua",
         .what = "call of a function",
         .unit = "ns",
         .ours = ours,
         .context = &function,
         .budget = {40, 20, true}},
        {.scene = "lua",
         .what = "pairs of 1,000 names",
         .unit = "ns",
         .ours = ours,
         .peer = peer,
         .context = &order,
         .peer_name = "ipairs",
         .describe = describe_order,
         .own_peer = true,
         .budget = {1 / 1.5, 1, false}},
        {.scene = "lua", .what = "garbage of a steady game", .unit = "B/tick", .ours = garbage, .context = &moved}};
    for (size_t i = 0; i < DAFT_COUNT_OF(subjects); i++) {
        bench_subject subject = subjects[i];
        subject.isa = self->isa, subject.threads = 1;
        if (bench_wants(self, subject.scene, subject.what)) bench_measure(self, &subject);
    }
}
