/* Rows `budget, NAME`: each scene of assets/scenes: `daft cost --quick` is asked for the best setting that keeps a
 * budget of milliseconds, and pictures by that setting are drawn by `daft render` right after. Ours is their median,
 * which is to be within the budget and a tenth of it. A budget that no setting keeps is left out, with a note. */
#include "harness/bench.h"

#include "frames/users.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FRAMES = 15 };

/* The options that the report recommends: "For 16 ms: OPTIONS (9.45 ms …". False: nothing keeps the budget. */
static bool ask(const char *path, double budget, int threads, const char *isa, char *options, size_t size)
{
    char command[1400], line[1200];
    bool found = false;
    snprintf(command, sizeof command,
             "'%s' cost '%s' --quick --no-pictures --budget %g --threads %d --isa %s -o /tmp/daft-budget-%ld "
             "2>/dev/null",
             DAFT_PROGRAM, path, budget, threads, isa, (long)getpid());
    FILE *pipe = popen(command, "r");
    while (pipe && fgets(line, sizeof line, pipe)) {
        const char *from = strncmp(line, "For ", 4) == 0 ? strstr(line, ": --") : NULL;
        char *to = strstr(line, " (");
        if (!from || !to) continue;
        *to = 0;
        snprintf(options, size, "%s", from + 2);
        found = true;
    }
    return pipe && pclose(pipe) == 0 && found;
}

/* The median of some pictures; negative on failure. */
static double draw(bench *self, const char *path, const char *options, int threads)
{
    char command[2400], stats[64];
    size_t size;
    users_frames frames = {0};
    snprintf(stats, sizeof stats, "/tmp/daft-budget-%ld.json", (long)getpid());
    snprintf(command, sizeof command,
             "'%s' render '%s' %s --threads %d --isa %s --repeat %d --stats %s -o /tmp/daft-budget-%ld.png 2>/dev/null",
             DAFT_PROGRAM, path, options, threads, self->isa, FRAMES, stats, (long)getpid());
    char *json = system(command) == 0 ? daft_file_read(&self->allocator, NULL, stats, &size, NULL) : NULL;
    if (json) users_read_times(json, &frames);
    daft_release(&self->allocator, json);
    return frames.frames > 0 ? frames.median : -1;
}

static void measure(bench *self, const char *name, const char *path, double budget, int threads)
{
    char options[1000];
    bench_row row = {.unit = "ms",
                     .isa = self->isa,
                     .threads = threads,
                     .peer = -1,
                     .budget = {.floor = 1.1 * budget, .aim = budget, .of_value = true}};
    fprintf(stderr, "%s for %g ms, %d thread%s\n", name, budget, threads, threads == 1 ? "" : "s");
    if (!ask(path, budget, threads, self->isa, options, sizeof options)) {
        bench_note(self, false, "%s: nothing keeps %g ms", name, budget);
        return;
    }
    row.ours = draw(self, path, options, threads);
    snprintf(row.scene, sizeof row.scene, "%s", name);
    snprintf(row.what, sizeof row.what, "the setting for %g ms", budget);
    snprintf(row.counters, sizeof row.counters, "%.300s", options);
    if (row.ours < 0)
        bench_note(self, true, "%s failed", name);
    else
        bench_add(self, &row);
}

void bench_budgets(bench *self)
{
    static const double BUDGETS[] = {4, 16};
    struct dirent **found;
    int counts[2], threads = bench_thread_counts(self, counts);
    const int count = scandir(DAFT_ROOT "/assets/scenes", &found, users_is_scene, alphasort);
    for (int i = 0; i < count; i++) {
        char name[64], path[512];
        snprintf(path, sizeof path, "%s/assets/scenes/%.200s", DAFT_ROOT, found[i]->d_name);
        snprintf(name, sizeof name, "budget, %.*s", (int)strcspn(found[i]->d_name, "."), found[i]->d_name);
        for (size_t k = 0; k < DAFT_COUNT_OF(BUDGETS); k++)
            if (bench_wants(self, name, "the setting for a budget"))
                measure(self, name, path, BUDGETS[k], counts[threads - 1]);
        free(found[i]);
    }
    if (count >= 0) free(found);
}
