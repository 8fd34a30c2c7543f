/* Options, and sampling in turns. */
#include "bench.h"

#include "math/simd/dispatch.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_ROUNDS = 101 };

/* ---- sampling ---- */

static bool contains(const char *text, const char *pattern)
{
    for (; *text; text++) {
        size_t i = 0;
        while (pattern[i] && tolower((unsigned char)text[i]) == tolower((unsigned char)pattern[i])) i++;
        if (!pattern[i]) return true;
    }
    return !*pattern;
}

bool bench_wants(bench *self, const char *scene, const char *what)
{
    char name[128];
    snprintf(name, sizeof name, "%s %s", scene, what);
    if (self->only && !contains(name, self->only)) return false;
    if (!self->list) return true;
    printf("%s\n", name);
    return false;
}

int bench_thread_counts(const bench *self, int out[2])
{
    int all = daft_processor_count();
    out[0] = self->threads ? self->threads : 1;
    out[1] = all;
    return self->threads || all == 1 ? 1 : 2;
}

double bench_clock_ms(int threads)
{
    struct timespec spent;
    if (threads > 1 || clock_gettime(CLOCK_THREAD_CPUTIME_ID, &spent) != 0) return daft_clock_ms();
    return (double)spent.tv_sec * 1e3 + (double)spent.tv_nsec * 1e-6;
}

void bench_note(bench *self, bool fatal, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "daft bench: ");
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "\n");
    va_end(arguments);
    self->failed |= fatal;
}

/* Enough samples: as many as --rounds says; else nine, and more until a third of a second has passed, because short
 * samples are noisy (one second for rows that compare two of ours, where percents matter). After three samples, five
 * seconds are always enough. */
static bool enough(const bench *self, const bench_subject *subject, int count, double ms)
{
    if (count >= 3 && ms > 5e3) return true;
    if (self->rounds) return count >= self->rounds;
    return count >= MAX_ROUNDS || (count >= 9 && ms > (subject->own_peer ? 1000 : 333));
}

static double better(const bench_row *row, double a, double b)
{
    return bench_smaller_is_better(row) == (a < b) ? a : b;
}

/* One warm-up round, then rounds of ours and the peer's in turns. A first round longer than two seconds counts. False:
 * a sample failed. */
static bool sample(const bench *self, const bench_subject *subject, bool peer, bench_row *row)
{
    double start = daft_clock_ms();
    int count = 0;
    for (bool warm = self->rounds == 1; !enough(self, subject, count, daft_clock_ms() - start);) {
        double a = subject->ours(subject->context), b = peer ? subject->peer(subject->context) : 0;
        if (a < 0 || b < 0) return false;
        bool cold = !warm && daft_clock_ms() - start < 2e3;
        warm = true;
        if (cold) continue;
        row->ours = count ? better(row, a, row->ours) : a;
        row->peer = count ? better(row, b, row->peer) : b;
        count++;
    }
    if (!peer) row->peer = -1;
    return true;
}

bool bench_add(bench *self, const bench_row *row)
{
    if (!daft_grow(&self->allocator, &self->rows, &self->capacity, self->count + 1, self->count, sizeof *self->rows)) {
        bench_note(self, true, "out of memory");
        return false;
    }
    self->rows[self->count++] = *row;
    bench_tell(row);
    return true;
}

const bench_row *bench_measure(bench *self, const bench_subject *subject)
{
    bool peers = self->peers || subject->own_peer;
    bench_row row = {
        .unit = subject->unit, .isa = subject->isa, .threads = subject->threads, .budget = subject->budget};
    row.peer_name = peers ? subject->peer_name : NULL;
    bench_label(subject->scene, row.scene, sizeof row.scene);
    snprintf(row.what, sizeof row.what, "%s", subject->what);
    fprintf(stderr, "%s %s, %d thread%s\n", row.scene, row.what, row.threads, row.threads == 1 ? "" : "s");
    if (!sample(self, subject, peers && subject->peer, &row)) {
        bench_note(self, true, "%s %s failed", row.scene, row.what);
        return NULL;
    }
    if (subject->describe) subject->describe(subject->context, row.counters, sizeof row.counters);
    return bench_add(self, &row) ? &self->rows[self->count - 1] : NULL;
}

void bench_measure_twice(bench *self, const bench_subject *subject, const char *what, bench_budget budget)
{
    const bench_row *measured = bench_measure(self, subject);
    if (!measured) return;
    bench_row row = *measured;
    snprintf(row.what, sizeof row.what, "%s", what);
    row.peer = -1, row.peer_name = NULL, row.budget = budget;
    bench_add(self, &row);
}

/* ---- command line ---- */

static const char USAGE[] =
    "usage: daft bench [--peers] [--only PATTERN] [--json FILE] [options]\n"
    "\n"
    "Measures speed and prints a table: the best of several rounds, and what was counted beside it. Rows with a\n"
    "budget show its floor, its aim, and how much of the aim is reached; the rows under their floor are listed below.\n"
    "\n"
    "The first rows are users' frames: each game of games/ with its demo, each scene of assets/scenes, at 1280x720.\n"
    "\n"
    "How cost grows is followed further with --only growth (to 10 million triangles, 100,000 instances, 64 lights and\n"
    "3840x2160) than in a run of everything. visibility-accuracy says what a right pixel costs,\n"
    "sim-accuracy what a right motion costs; with --only, at every rate.\n"
    "\n"
    "  --peers         run other libraries on the same work, in turns with ours (ratio > 1: ours is better)\n"
    "  --only PATTERN  only benchmarks with PATTERN in their name\n"
    "  --json FILE     write the results as JSON, too\n"
    "  --tables DIR    measure nothing; fill the tables of the manual's pages in DIR from the files of --from\n"
    "  --from FILE     JSON of an earlier run; may be given 32 times, for one run each\n"
    "  --csv FILE      of visibility-accuracy or sim-accuracy, as --only says: write its points as CSV, too\n"
    "  --svg FILE      of the same: plot error against milliseconds\n"
    "  --threads N     measure with N threads (default: with one, and with all)\n"
    "  --isa X         plain, sse2, avx2 or avx512 (default: the best there is)\n"
    "  --rounds N      samples to take the best of (default: 9, and more of short ones)\n"
    "  --list          print the names of the benchmarks\n"
    "  --help          this text\n"
    "\n"
    "Meshes that are not part of DAFT are read from the folder ../shared/data beside the checkout, or from "
    "$DAFT_DATA;\n"
    "where one is missing, a generated mesh of its size stands in, and the row says so.\n";

static int refuse(const char *message, const char *detail)
{
    fprintf(stderr, "daft bench: %s '%s'\nTry 'daft bench --help'.\n", message, detail);
    return 2;
}

static bool parse_count(const char *text, int high, int *out)
{
    char *end;
    long value = strtol(text, &end, 10);
    if (end == text || *end || value < 1 || value > high) return false;
    *out = (int)value;
    return true;
}

/* Takes "--name VALUE" and "--name=VALUE"; *value is NULL when the argument is not `name`. 0 or an exit status. */
static int take_value(const char *name, int argc, char **argv, int *index, const char **value)
{
    size_t length = strlen(name);
    *value = NULL;
    if (strncmp(argv[*index], name, length) != 0) return 0;
    if (argv[*index][length] == '=') *value = argv[*index] + length + 1;
    if (argv[*index][length] != 0) return 0;
    if (*index + 1 >= argc) return refuse("a value is missing after", name);
    *value = argv[++*index];
    return 0;
}

static int add_source(bench *self, const char *file)
{
    for (size_t i = 0; i < DAFT_COUNT_OF(self->from); i++)
        if (!self->from[i]) return self->from[i] = file, 0;
    return refuse("too many files for --from at", file);
}

static int take_argument(bench *self, int argc, char **argv, int *index)
{
    const char *value, *argument = argv[*index];
    if (strcmp(argument, "--peers") == 0) return self->peers = true, 0;
    if (strcmp(argument, "--list") == 0) return self->list = true, 0;
    int status = take_value("--only", argc, argv, index, &value);
    if (status || value) return self->only = value, status;
    status = take_value("--json", argc, argv, index, &value);
    if (status || value) return self->json = value, status;
    status = take_value("--tables", argc, argv, index, &value);
    if (status || value) return self->tables = value, status;
    status = take_value("--from", argc, argv, index, &value);
    if (status || value) return status ? status : add_source(self, value);
    status = take_value("--csv", argc, argv, index, &value);
    if (status || value) return self->csv = value, status;
    status = take_value("--svg", argc, argv, index, &value);
    if (status || value) return self->svg = value, status;
    status = take_value("--isa", argc, argv, index, &value);
    if (status || value) return self->isa = value, status;
    status = take_value("--threads", argc, argv, index, &value);
    if (status || value)
        return !status && !parse_count(value, 64, &self->threads) ? refuse("--threads: 1 to 64 expected, got", value)
                                                                  : status;
    status = take_value("--rounds", argc, argv, index, &value);
    if (status || value)
        return !status && !parse_count(value, MAX_ROUNDS, &self->rounds)
                   ? refuse("--rounds: 1 to 101 expected, got", value)
                   : status;
    return refuse("there is no option", argument);
}

/* The processor's name as Linux tells it. */
static void name_machine(char *out, size_t size)
{
    char line[256];
    FILE *file = fopen("/proc/cpuinfo", "r");
    snprintf(out, size, "unknown processor");
    while (file && fgets(line, sizeof line, file)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon) continue;
        colon[strcspn(colon, "\n")] = 0;
        snprintf(out, size, "%s", colon + 2);
        break;
    }
    if (file) fclose(file);
}

/* What stands beside the figures: the command without its outputs, the machine, the day. */
static void describe_run(bench *self, int argc, char **argv)
{
    size_t used = (size_t)snprintf(self->command, sizeof self->command, "daft bench");
    for (int i = 1; i < argc && used < sizeof self->command; i++) {
        bool output = strncmp(argv[i], "--json", 6) == 0 || strncmp(argv[i], "--csv", 5) == 0 ||
                      strncmp(argv[i], "--svg", 5) == 0;
        if (output && !strchr(argv[i], '=')) i++;
        if (output) continue;
        const char *quote = strchr(argv[i], ' ') ? "'" : "";
        used += (size_t)snprintf(self->command + used, sizeof self->command - used, " %s%s%s", quote, argv[i], quote);
    }
    name_machine(self->machine, sizeof self->machine);
    time_t now = time(NULL);
    struct tm day;
    if (gmtime_r(&now, &day)) strftime(self->date, sizeof self->date, "%Y-%m-%d", &day);
}

int main(int argc, char **argv)
{
    bench self = {.allocator = daft_malloc_allocator()};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) return fputs(USAGE, stdout), 0;
        int status = take_argument(&self, argc, argv, &i);
        if (status) return status;
    }
    int isa;
    switch (daft_isa_find(self.isa, &isa)) {
    case DAFT_ISA_READY: break;
    case DAFT_ISA_UNKNOWN: return refuse("--isa: plain, sse2, avx2 or avx512 expected, got", self.isa);
    case DAFT_ISA_NOT_BUILT: return refuse("this build has no kernels for", self.isa);
    case DAFT_ISA_UNSUPPORTED: return refuse("this processor does not have", self.isa);
    }
    self.isa = daft_isa_name(isa);

    describe_run(&self, argc, argv);
    if (self.tables) return bench_write_tables(&self) ? 0 : 1;

    bench_games(&self);
    bench_shown_scenes(&self);
    bench_start_up(&self);
    bench_scripts(&self);
    bench_frames(&self);
    bench_visibility(&self);
    bench_shadow(&self);
    bench_rays(&self);
    bench_load(&self);
    bench_trees(&self);
    bench_sim_shapes(&self);
    bench_sim(&self);
    bench_denoise(&self);
    bench_edges(&self);
    bench_budgets(&self);
    bench_growth(&self);
    bench_accuracy(&self);
    bench_sim_accuracy(&self);
    bench_robust(&self);
    if (!self.list && self.count > 0) bench_print(&self);
    if (!self.list && self.count == 0 && !self.failed)
        bench_note(&self, true, "no benchmark has '%s' in its name; --list names them all", self.only ? self.only : "");
    if (self.json && !self.list && !bench_write_json(&self)) bench_note(&self, true, "cannot write %s", self.json);
    daft_release(&self.allocator, self.rows);
    if (fflush(stdout) != 0 || ferror(stdout)) bench_note(&self, true, "standard output cannot be written");
    return self.failed ? 1 : 0;
}
