/* daft test-game: runs the tests of a game without a window. */
#include "cli/commands.h"

#include "cli/cli.h"
#include "cli/trial/trial.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const cli_command COMMAND = {"test-game",
                                    "GAME",
                                    "Runs the tests of a game: the files tests/*.lua in its folder, without a window.",
                                    "Each test has a game of its own from the beginning, and goes on beside it, tick "
                                    "by tick. Pictures are compared with\n"
                                    "those in tests/pictures/; where one differs, it and a map of what differs are "
                                    "left in tests/failed/. Exit status 1\n"
                                    "where a test fails, or where there is none.",
                                    1,
                                    1};

typedef struct name_list {
    char (*names)[256];
    size_t count, capacity;
    bool lost;
} name_list;

static void take_name(void *user, const char *name)
{
    name_list *list = user;
    if (!has_extension(name, ".lua") || strlen(name) >= sizeof *list->names || list->lost) return;
    if (list->count == list->capacity) {
        size_t more = list->capacity ? 2 * list->capacity : 16;
        void *grown = realloc(list->names, more * sizeof *list->names);
        list->lost = !grown;
        if (!grown) return;
        list->names = grown, list->capacity = more;
    }
    snprintf(list->names[list->count++], sizeof *list->names, "%s", name);
}

static int by_name(const void *a, const void *b) { return strcmp(a, b); }

static bool run_files(trials *t, const name_list *list, daft_error *error)
{
    for (size_t i = 0; i < list->count; i++)
        if (!trials_run_file(t, list->names[i], error)) return false;
    return true;
}

static int sum_up(const trials *t)
{
    if (t->lists) return STATUS_DONE;
    const size_t all = t->passed + t->failed;
    if (all == 0) {
        fprintf(stderr, "daft test-game: there is no test%s in %s/tests/*.lua\n", t->filter ? " of that name" : "",
                t->info.folder);
        return STATUS_BAD_INPUT;
    }
    printf("%s: %zu test%s, %zu failed", t->info.name, all, all == 1 ? "" : "s", t->failed);
    if (t->written) printf(", %zu picture%s written", t->written, t->written == 1 ? "" : "s");
    putchar('\n');
    return t->failed ? STATUS_BAD_INPUT : STATUS_DONE;
}

static bool open_all(trials *t, const char *game, cli_size size, long threads, daft_error *error)
{
    if (!home_find(&t->where, error) || !home_find_game(&t->where, game, &t->info, error) ||
        !source_open(&t->source, &t->where, &t->info, error) || !(t->face = open_font(&t->where, error)))
        return false;
    daft_engine_def def = daft_default_engine_def();
    def.threads = (int)threads;
    def.memory_limit = HOST_MEMORY;
    t->engine = try_engine(&def, error);
    if (t->engine) t->picture = daft_image_create(t->engine, size.width, size.height, error);
    return t->picture != NULL;
}

static int test_game(trials *t, const char *game, cli_size size, long threads)
{
    daft_error error;
    name_list list = {0};
    bool good = open_all(t, game, size, threads, &error);
    if (good) daft_files_list(t->source.own, "tests", take_name, &list);
    if (good && list.count > 1) qsort(list.names, list.count, sizeof *list.names, by_name);
    if (good && list.lost) good = fail(&error, DAFT_ERROR_MEMORY, "out of memory for the names of tests");
    good = good && run_files(t, &list, &error);
    free(list.names);
    return good ? sum_up(t) : report(&error);
}

int command_test_game(int argc, char **argv)
{
    trials t = {.quality = DAFT_PRESET_GAME};
    cli_size size = {320, 180};
    long ticks = 3600, threads = 0;
    const cli_option options[] = {
        {"filter", 0, CLI_TEXT, "TEXT", &t.filter, 0, 0, "only tests with TEXT in 'file.lua: name'"},
        {"list", 0, CLI_FLAG, NULL, &t.lists, 0, 0, "name the tests, and run none"},
        {"update", 0, CLI_FLAG, NULL, &t.update, 0, 0, "write the pictures that are not there or differ"},
        {"ticks", 0, CLI_COUNT, "N", &ticks, 1, 1000000000, "how many updates a test may take (3600)"},
        {"size", 0, CLI_SIZE, "WxH", &size, 16, 8192, "size of the pictures (320x180)"},
        {"quality", 'q', CLI_QUALITY, "Q", &t.quality, 0, 0, "of the pictures: draft, game (default), high, reference"},
        {"threads", 't', CLI_COUNT, "N", &threads, 0, 64, "worker threads; 0, the default, is one for each processor"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    t.max_ticks = (uint64_t)ticks;
    int status = test_game(&t, operands[0], size, threads);
    daft_image_destroy(t.picture);
    font_close(t.face);
    daft_engine_destroy(t.engine);
    source_close(&t.source);
    return status;
}
