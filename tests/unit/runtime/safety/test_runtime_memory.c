/* runtime: what a game may hold: scripts, meshes, textures and pictures together, by --memory-limit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "runtime_program.h"

static char output[OUTPUT_SIZE];

static void scripts_have_a_limit(void **unused)
{
    (void)unused;
    int status = run_daft(output, "play tests/games/hungry --headless --ticks 600 --memory-limit 40MB");
    assert_status(status, 1, output);
    assert_says(output, "caught\tnot enough memory");
    assert_says(output, "daft.update: not enough memory: of the 40.0 MB that the game may hold");
    assert_says(output, "--memory-limit");
}

static void a_gigabyte_where_nobody_says_otherwise(void **unused)
{
    (void)unused;
    int status = run_daft(output, "play tests/games/hungry --headless --ticks 100000");
    assert_status(status, 1, output);
    assert_says(output, "of the 1000.0 MB that the game may hold");
}

static void what_the_engine_holds_counts(void **unused)
{
    (void)unused;
    int status = run_daft(output, "render assets/scenes/hello.scene -o /dev/null/x.png --memory-limit 8MB");
    assert_status(status, 1, output);
    assert_says(output, "of memory; the limit is 8 MB");
}

static void stats_tell_it(void **unused)
{
    (void)unused;
    int status = run_daft(output, "play marble --headless --ticks 30 --memory-limit 500MB --stats -");
    assert_status(status, 0, output);
    assert_says(output, "\"memory\": {\"used\": ");
    assert_says(output, "\"limit\": 500000000}");
    assert_says(output, "\"simulation\": {\"bodies\": ");
    assert_says(output, "\"substeps\": 4,");
}

static void sizes_are_parsed(void **unused)
{
    (void)unused;
    static const char *const wrong[] = {"0", "-1", "1", "10kB", "1TB", "MB", "1.5.5GB", "nan", "inf", "1e300", "1 GB"};
    static const char *const right[] = {"70000000", "70000kB", "0.7GB", "70mb", "70000000B"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        int status = run_daft(output, "play marble --headless --ticks 1 --memory-limit '%s'", wrong[i]);
        assert_status(status, 2, output);
        assert_says(output, "such as 500000, 64MB or 1.5GB");
    }
    for (size_t i = 0; i < sizeof right / sizeof right[0]; i++) {
        int status = run_daft(output, "play marble --headless --ticks 1 --memory-limit %s", right[i]);
        assert_status(status, 0, output);
    }
}

static double used_after(int ticks)
{
    int status = run_daft(output, "play tests/games/wasteful --headless --ticks %d --threads 1 --stats -", ticks);
    assert_status(status, 0, output);
    const char *used = strstr(output, "\"used\": ");
    assert_non_null(used);
    return atof(used + 8);
}

/* A new colour, material, mesh and textured material with each of 10,000 ticks. */
static void what_a_game_lets_go_of_is_freed(void **unused)
{
    (void)unused;
    double some = used_after(1000), many = used_after(10000);
    if (!(many < 1.1 * some)) fail_msg("%.0f bytes after 1,000 ticks, %.0f after 10,000", some, many);
}

/* What is given back in numbers, or in tables that the game gives again. */
static void a_steady_game_makes_no_garbage(void **unused)
{
    (void)unused;
    int status = run_daft(output, "play tests/games/steady --headless --ticks 400");
    assert_status(status, 0, output);
    assert_says(output, "garbage: 0 bytes a tick");
}

/* When Lua collects, and how many pictures are drawn, makes no difference. */
static void freeing_is_the_same_in_every_run(void **unused)
{
    (void)unused;
    static char again[OUTPUT_SIZE];
    const char *play = "play tests/games/wasteful --headless --ticks 600 --hash";
    int status = run_daft(output, "%s", play);
    assert_status(status, 0, output);
    status = run_daft(again, "%s --every-frame --threads 3", play);
    assert_status(status, 0, again);
    assert_string_equal(output, again);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scripts_have_a_limit),
        cmocka_unit_test(a_gigabyte_where_nobody_says_otherwise),
        cmocka_unit_test(what_the_engine_holds_counts),
        cmocka_unit_test(stats_tell_it),
        cmocka_unit_test(sizes_are_parsed),
        cmocka_unit_test(what_a_game_lets_go_of_is_freed),
        cmocka_unit_test(a_steady_game_makes_no_garbage),
        cmocka_unit_test(freeing_is_the_same_in_every_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
