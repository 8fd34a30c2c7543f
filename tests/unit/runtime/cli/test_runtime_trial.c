/* daft new and daft test-game: templates play and pass their own tests; what fails in a test is told. */
#include "runtime_program.h"

#include <setjmp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static char output[OUTPUT_SIZE];
static char folder[] = "/tmp/daft-trial-XXXXXX";

static const char GAME[] = "-- Shot: a ball.\n"
                           "game = { presses = 0 }\n"
                           "function daft.load()\n"
                           "  daft.light.sun { direction = {0, -1, 0} }\n"
                           "  daft.entity { sphere = 1, position = {4, 0, 0}, material = '#ff0000', name = 'ball' }\n"
                           "end\n"
                           "function daft.keypressed(key)\n"
                           "  if key == 'space' then game.presses = game.presses + 1 end\n"
                           "  if key == 'r' then daft.restart() end\n"
                           "  if key == 'q' then daft.quit() end\n"
                           "  if key == 'e' then error('the game is wrong') end\n"
                           "end\n";

static void write_text(const char *name, const char *text)
{
    char path[256];
    snprintf(path, sizeof path, "%s/shot/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static bool is_there(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/shot/%s", folder, name);
    return access(path, F_OK) == 0;
}

/* The game with one file of tests. Returns the exit status of its tests. */
static int try_tests(const char *text, const char *options)
{
    write_text("main.lua", GAME);
    write_text("tests/a.lua", text);
    return run_daft(output, "test-game %s/shot %s", folder, options);
}

static void templates_play_and_pass_their_tests(void **unused)
{
    (void)unused;
    static const char *const names[] = {"empty", "first-person", "marble", "top-down"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        assert_status(run_daft(output, "new %s/my-%s --template %s", folder, names[i], names[i]), 0, output);
        assert_says(output, "daft play");
        assert_status(run_daft(output, "test-game %s/my-%s", folder, names[i]), 0, output);
        assert_says(output, "0 failed");
        assert_status(run_daft(output, "check --strict %s/my-%s", folder, names[i]), 0, output);
    }
    assert_status(run_daft(output, "new %s/my-marble", folder), 1, output);
    assert_says(output, "the folder cannot be made: File exists");
    assert_status(run_daft(output, "new %s/other --template marbel", folder), 2, output);
    assert_says(output, "did you mean 'marble'?");
    char line[128], path[256];
    snprintf(path, sizeof path, "%s/my-marble/main.lua", folder);
    FILE *file = fopen(path, "r");
    assert_non_null(fgets(line, sizeof line, file));
    fclose(file);
    assert_string_equal(line,
                        "-- My marble: a glass ball on tracks in the sky; roll it over the gems and into the ring.\n");
}

static void each_test_has_a_game_of_its_own(void **unused)
{
    (void)unused;
    int status = try_tests(
        "local test = require 'test'\n"
        "test('one', function() test.press('space') test.equal(game.presses, 1) end)\n"
        "test('two', function() test.equal(game.presses, 0) test.press('space', 1) test.equal(game.presses, 1) "
        "end)\n",
        "");
    assert_status(status, 0, output);
    assert_says(output, "ok    a.lua: one (");
    assert_says(output, "shot: 2 tests, 0 failed");
    status = run_daft(output, "test-game %s/shot --filter two", folder);
    assert_status(status, 0, output);
    assert_says(output, "shot: 1 test, 0 failed");
    assert_status(run_daft(output, "test-game %s/shot --list", folder), 0, output);
    assert_string_equal(output, "a.lua: one\na.lua: two\n");
    assert_status(run_daft(output, "test-game %s/shot --filter three", folder), 1, output);
    assert_says(output, "there is no test of that name");
}

/* What fails, and what the report says. */
static void failures_are_told(void **unused)
{
    (void)unused;
    static const struct {
        const char *body, *said;
    } cases[] = {{"assert(false, 'not so')", "shot/tests/a.lua:2: not so"},
                 {"test.equal(1, 2)", "shot/tests/a.lua:2: 2 expected, got 1"},
                 {"test.near(1, 1.1, 0.05, 'size')", "size: 1.1 ± 0.05 expected, got 1"},
                 {"test.above(1, 2)", "more than 2 expected, got 1"},
                 {"test.below(3, 2)", "less than 2 expected, got 3"},
                 {"test.fails(function() end)", "an error expected"},
                 {"test.wait_for(function() return false end, 0.5)", "it did not happen within 0.5 s"},
                 {"test.press('e')", "the game is wrong"},
                 {"test.press('r')", "the game began anew (daft.restart)"},
                 {"test.press('q')", "the game ended (daft.quit) before the test did"},
                 {"test.press('spaec')", "did you mean 'space'?"},
                 {"test.seconds(1000)", "it did not end within 100 ticks"},
                 {"daft.test('inner', print)", "not within a test"},
                 {"test.picture('a/b')", "letters, digits"},
                 {"test.picture('a', { min = 1 })", "there is no 'min'"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[400];
        snprintf(text, sizeof text, "local test = require 'test'\ntest('t', function() %s end)\n", cases[i].body);
        assert_status(try_tests(text, "--ticks 100"), 1, output);
        assert_says(output, "FAIL  a.lua: t\n");
        assert_says(output, cases[i].said);
        assert_says(output, "1 test, 1 failed");
    }
    assert_status(try_tests("local x =\n", ""), 1, output);
    assert_says(output, "tests/a.lua:2:");
    assert_status(try_tests("local x = 1\n", ""), 1, output);
    assert_says(output, "the file has no test");
    write_text("main.lua", "daft.test('here', print)\n");
    assert_status(run_daft(output, "play %s/shot --headless --ticks 1", folder), 1, output);
    assert_says(output, "only in files of the folder tests/");
}

static void pictures_are_compared_within_what_is_allowed(void **unused)
{
    (void)unused;
    static const char LIKE[] =
        "local test = require 'test'\ntest('t', function() test.ticks(2) test.picture('p') end)\n";
    assert_status(try_tests(LIKE, ""), 1, output);
    assert_says(output, "there is no picture tests/pictures/p.png yet");
    assert_true(is_there("tests/failed/p.png"));
    assert_false(is_there("tests/failed/p-diff.png"));
    assert_status(try_tests(LIKE, "--update"), 0, output);
    assert_says(output, "1 picture written");
    assert_status(try_tests(LIKE, ""), 0, output);

    static const char *const OTHER = "local test = require 'test'\ntest('t', function()\n"
                                     "  daft.entity { sphere = 0.3, position = {2, 0.2, 0.2}, material = '#0000ff' }\n"
                                     "  test.ticks(2) test.picture('p'%s)\nend)\n";
    char text[400];
    snprintf(text, sizeof text, OTHER, "");
    assert_status(try_tests(text, ""), 1, output);
    assert_says(output, "the picture 'p' differs: by ");
    assert_says(output, "(0.25 allowed)");
    assert_true(is_there("tests/failed/p-diff.png"));
    snprintf(text, sizeof text, OTHER, ", { max = 1, mean = 1 }");
    assert_status(try_tests(text, ""), 0, output);
    snprintf(text, sizeof text, OTHER, ", { max = 1, mean = 0.0001 }");
    assert_status(try_tests(text, ""), 1, output);
    assert_says(output, "(0.0001 allowed)");
    assert_status(try_tests(text, "--update"), 0, output);
    assert_says(output, "1 picture written");
    assert_status(try_tests(text, ""), 0, output);
    assert_status(try_tests(LIKE, "--size 64x64"), 1, output);
    assert_says(output, "has 64x64 pixels, not 320x180");
}

static int make_folder(void **unused)
{
    (void)unused;
    char path[256];
    if (!mkdtemp(folder)) return -1;
    snprintf(path, sizeof path, "%s/shot", folder);
    mkdir(path, 0777);
    snprintf(path, sizeof path, "%s/shot/tests", folder);
    return mkdir(path, 0777);
}

static int remove_folder(void **unused)
{
    (void)unused;
    char command[256];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(templates_play_and_pass_their_tests), cmocka_unit_test(each_test_has_a_game_of_its_own),
        cmocka_unit_test(failures_are_told), cmocka_unit_test(pictures_are_compared_within_what_is_allowed)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
