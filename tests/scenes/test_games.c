/* The games of games/: their recorded demos win, the same game comes out for any number of threads and any instruction
 * set, and a bot wins every level of the toppler. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include <cmocka.h>

/* What the program prints when it plays with these arguments, or NULL when it refuses; freed by the caller. */
static char *play(const char *format, ...) __attribute__((format(printf, 1, 2)));
static char *play(const char *format, ...)
{
    char command[2048];
    int start = snprintf(command, sizeof command, "'%s' play --headless --hash ", DAFT_PROGRAM);
    va_list list;
    va_start(list, format);
    vsnprintf(command + start, sizeof command - (size_t)start, format, list);
    va_end(list);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    size_t used = 0, capacity = 1 << 16;
    char *text = calloc(1, capacity);
    assert_non_null(text);
    while (used < capacity - 1) {
        size_t got = fread(text + used, 1, capacity - 1 - used, pipe);
        if (got == 0) break;
        used += got;
    }
    int status = pclose(pipe);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return text;
    print_message("%s\n%s", command, text);
    free(text);
    return NULL;
}

static char *play_demo(const char *game, const char *options)
{
    return play("'%s/games/%s' --replay '%s/games/%s/demo.rec' %s", DAFT_ROOT, game, DAFT_ROOT, game, options);
}

/* It says "marble: won in 20.9 s, 6 of 8 gems". */
static void assert_marble_won(const char *text)
{
    const char *won = strstr(text, "marble: won in ");
    assert_non_null(won);
    double seconds;
    int taken, all;
    assert_int_equal(sscanf(won, "marble: won in %lf s, %d of %d gems", &seconds, &taken, &all), 3);
    assert_true(seconds > 5 && seconds < 60);
    assert_true(taken > 0 && taken <= all);
}

/* The toppler says "toppler: level 2 won with 1 of 3 shots, 1580 points, 3 stars". */
static void assert_level_won(const char *text, int level)
{
    char line[64];
    snprintf(line, sizeof line, "toppler: level %d won with ", level);
    const char *won = strstr(text, line);
    if (!won) fail_msg("level %d is not won:\n%s", level, text);
    int shots, all, points, stars;
    assert_int_equal(sscanf(won + strlen(line), "%d of %d shots, %d points, %d stars", &shots, &all, &points, &stars),
                     4);
    assert_true(shots >= 1 && shots <= all && stars >= 1 && stars <= 3);
    assert_true(points >= 250 + 500 * (all - shots));
}

static void assert_toppler_won(const char *text)
{
    assert_level_won(text, 2);
    assert_level_won(text, 10);
}

/* What a copy of the toppler prints that `change`, a shell command in its folder, has altered. */
static char *play_changed_toppler(const char *change, int ticks)
{
    char folder[] = "/tmp/daft_test_XXXXXX", command[1024];
    assert_non_null(mkdtemp(folder));
    snprintf(command, sizeof command, "cp -r '%s/games/toppler' '%s' && cd '%s/toppler' && %s", DAFT_ROOT, folder,
             folder, change);
    assert_int_equal(system(command), 0);
    char *text = play("'%s/toppler' --ticks %d", folder, ticks);
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    assert_int_equal(system(command), 0);
    assert_non_null(text);
    return text;
}

/* From the first start on: each level opens the next. */
static void toppler_can_be_won(void **state)
{
    (void)state;
    char *text = play_changed_toppler("sed -i.old 's/^local playing = false/local playing = true/' bot.lua", 10800);
    for (int level = 1; level <= 10; level++) assert_level_won(text, level);
    free(text);
}

static void toppler_stands_by_itself(void **state)
{
    (void)state;
    char *text = play_changed_toppler("cat '" DAFT_ROOT "/tests/scenes/toppler/stands.lua' >>main.lua", 6600);
    const char *last = strstr(text, "level 10 stands: ");
    assert_non_null(last);
    assert_in_range(atoi(last + strlen("level 10 stands: ")), 490, 500);
    free(text);
}

/* Its own tests, as its author runs them. */
static void toppler_passes_its_tests(void **state)
{
    (void)state;
    assert_int_equal(system("'" DAFT_PROGRAM "' test-game '" DAFT_ROOT "/games/toppler' >/dev/null"), 0);
}

static void toppler_takes_a_gamepad(void **state)
{
    (void)state;
    char *text = play_changed_toppler("cat '" DAFT_ROOT "/tests/scenes/toppler/pad.lua' >>main.lua", 300);
    assert_non_null(strstr(text, "the gamepad plays"));
    free(text);
}

static void assert_same_everywhere(const char *game, void (*assert_won)(const char *text))
{
    static const char *const options[] = {"--threads 2", "--threads 2 --isa " DAFT_NARROWEST_ISA,
                                          "--threads 1 --isa avx2", "--threads 2 --isa avx512"};
    char *first = play_demo(game, "--threads 1");
    assert_non_null(first);
    assert_non_null(strstr(first, "tick 600 state 0x"));
    assert_won(first);
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        char *other = play_demo(game, options[i]);
        if (!other && strstr(options[i], "avx")) {
            print_message("skipped: %s\n", options[i]);
            continue;
        }
        assert_non_null(other);
        assert_string_equal(other, first);
        free(other);
    }
    free(first);
}

static void marble_demo_wins_everywhere_alike(void **state)
{
    (void)state;
    assert_same_everywhere("marble", assert_marble_won);
}

static void toppler_demo_wins_everywhere_alike(void **state)
{
    (void)state;
    assert_same_everywhere("toppler", assert_toppler_won);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(marble_demo_wins_everywhere_alike),
                                       cmocka_unit_test(toppler_demo_wins_everywhere_alike),
                                       cmocka_unit_test(toppler_can_be_won),
                                       cmocka_unit_test(toppler_stands_by_itself),
                                       cmocka_unit_test(toppler_takes_a_gamepad),
                                       cmocka_unit_test(toppler_passes_its_tests)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
