/* runtime: which lines of Lua take the time, and that looking at them changes nothing. */
#include "cli/cli.h"
#include "cli/commands.h"
#include "common/util.h"
#include "game/game.h"
#include "runtime_program.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <unistd.h>

/* Line 4 runs for the most part; line 8 calls the engine, which takes the time. */
static const char GAME[] =
    "local x, all = 0, {}\n"
    "local function hot()\n"
    "  for i = 1, 300000 do\n"
    "    x = x + (i % 7) * 3 - (i % 5) * x * 1e-9 + (i % 3)\n"
    "  end\n"
    "end\n"
    "local function engine()\n"
    "  for i = 1, 30 do daft.noise(i, x, 1, 2) table.sort(all, function(a, b) return a < b end) end\n"
    "end\n"
    "function daft.load()\n"
    "  daft.entity { sphere = 1, body = 'dynamic' }\n"
    "end\n"
    "function daft.update(dt)\n"
    "  hot()\n"
    "  engine()\n"
    "  all[#all % 5 + 1] = x\n"
    "end\n";

static char folder[64];
static char output[OUTPUT_SIZE], other[OUTPUT_SIZE];

static int set_up(void **unused)
{
    (void)unused;
    char path[96];
    daft_error error;
    snprintf(folder, sizeof folder, "/tmp/daft-profile-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/main.lua", folder);
    return daft_write_file(path, GAME, sizeof GAME - 1, &error) ? 0 : -1;
}

static int tear_down(void **unused)
{
    (void)unused;
    char command[96];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

static void the_hot_line_comes_first_and_the_game_is_the_same(void **unused)
{
    (void)unused;
    assert_status(run_daft(output, "play %s --headless --ticks 60 --hash", folder), 0, output);
    assert_status(run_daft(other, "play %s --headless --ticks 60 --hash --profile %s/table.txt", folder, folder), 0,
                  other);
    assert_string_equal(output, other);
    char command[96];
    snprintf(command, sizeof command, "cat %s/table.txt", folder);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    output[fread(output, 1, sizeof output - 1, pipe)] = 0;
    pclose(pipe);
    assert_says(output, "Lua ran for ");
    const char *first = strstr(output, "line\n");
    assert_non_null(first);
    assert_true(atof(first + 5) > 50);
    const char *end = strchr(first + 5, '\n');
    assert_non_null(end);
    const char *place = strstr(first, "main.lua:4 "), *source = strstr(first, "x = x + (i % 7) * 3");
    assert_true(place && place < end && source && source < end);
    double sum = 0;
    for (const char *line = first + 5; *line; line = strchr(line, '\n') + 1) sum += atof(line);
    assert_true(sum > 98 && sum < 102);
}

static void on_standard_output_too(void **unused)
{
    (void)unused;
    assert_status(run_daft(output, "play %s --headless --ticks 5 --profile -", folder), 0, output);
    assert_says(output, "main.lua:4 ");
    assert_status(run_daft(output, "play %s --headless --ticks 5 --profile /nowhere/x", folder), 1, output);
    assert_says(output, "/nowhere/x");
}

/* The watchdog's hook goes first. */
static void what_runs_too_long_is_stopped(void **unused)
{
    (void)unused;
    assert_status(run_daft(output, "play tests/games/endless --headless --time-limit 0.5 --profile -"), 1, output);
    assert_says(output, "ran for 0.5 s without coming to an end");
}

static char answer[256];

static void keep_answer(void *user, const char *line, const char *text, bool good)
{
    (void)user, (void)line, (void)good;
    snprintf(answer, sizeof answer, "%s", text);
}

/* A limit of instructions strikes where it does without the profile, and the rest is noted. */
static void limits_strike_alike(void **unused)
{
    (void)unused;
    char counts[2][64];
    home where;
    game_info info;
    daft_error error;
    daft_engine_def engine_def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&engine_def, &error);
    assert_non_null(engine);
    assert_true(home_find(&where, &error) && home_find_game(&where, folder, &info, &error));
    for (int i = 0; i < 2; i++) {
        static game_state game;
        profile looks = {0};
        if (i == 1) assert_true(profile_start(&looks, &error));
        const game_def def = {.where = &where,
                              .info = &info,
                              .engine = engine,
                              .seed = 1,
                              .seconds = 120,
                              .answered = keep_answer,
                              .profile = &looks};
        assert_true(game_open(&game, &def, &error));
        assert_true(game_run_line(&game, "n = 0 while true do n = n + 1 end") && game_tick(&game));
        assert_string_equal(answer, "console:1: the line ran too long");
        for (int k = 0; k < 30; k++) assert_true(game_tick(&game));
        assert_true(game_run_line(&game, "n") && game_tick(&game));
        snprintf(counts[i], sizeof counts[i], "%.60s", answer);
        assert_int_equal(looks.samples > 0, i == 1);
        assert_true(looks.ns <= 2 * looks.call_ns);
        game_close(&game);
        profile_free(&looks);
    }
    assert_string_equal(counts[0], counts[1]);
    daft_engine_destroy(engine);
}

/* Compared with sorting them all. */
static void the_first_lines_are_the_largest(void **unused)
{
    (void)unused;
    enum { LINES = 500, MOST = 7 };
    profile looks = {.lines = calloc(PROFILE_LINES, sizeof *looks.lines)};
    profile_line top[MOST];
    uint32_t random = 3;
    assert_non_null(looks.lines);
    for (int i = 0; i < LINES; i++) {
        random = random * 1664525u + 1013904223u;
        profile_line *line = &looks.lines[(size_t)i * 8];
        line->line = i + 1, line->ns = random >> 20, line->recent_ns = random >> 24;
        snprintf(line->file, sizeof line->file, "a.lua");
    }
    for (int recent = 0; recent < 2; recent++) {
        assert_int_equal(profile_top(&looks, recent, top, MOST), MOST);
        for (int k = 0; k < MOST; k++) {
            const uint64_t ns = recent ? top[k].recent_ns : top[k].ns;
            int before = 0; /* lines that come before it */
            for (int i = 0; i < LINES; i++) {
                const profile_line *line = &looks.lines[(size_t)i * 8];
                const uint64_t other_ns = recent ? line->recent_ns : line->ns;
                before += other_ns > ns || (other_ns == ns && line->line < top[k].line);
            }
            assert_int_equal(before, k);
        }
    }
    profile_fade(&looks);
    assert_true(profile_top(&looks, true, top, 1) == 1 && top[0].recent_ns < 256 * 3 / 4);
    profile_free(&looks);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_hot_line_comes_first_and_the_game_is_the_same), cmocka_unit_test(on_standard_output_too),
        cmocka_unit_test(what_runs_too_long_is_stopped), cmocka_unit_test(limits_strike_alike),
        cmocka_unit_test(the_first_lines_are_the_largest)};
    return cmocka_run_group_tests_name("runtime profile", tests, set_up, tear_down);
}
