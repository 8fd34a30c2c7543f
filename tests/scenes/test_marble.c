/* games/marble: its recorded demo wins, and the same game comes out for any number of threads and any instruction set.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include <cmocka.h>

/* What the program prints when it plays the demo with these options, or NULL when it refuses; freed by the caller. */
static char *play(const char *options)
{
    char command[2048];
    snprintf(command, sizeof command,
             "'%s' play '%s/games/marble' --headless --replay '%s/games/marble/demo.rec' --hash %s", DAFT_PROGRAM,
             DAFT_ROOT, DAFT_ROOT, options);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    size_t used = 0, capacity = 1 << 16;
    char *text = calloc(1, capacity);
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

static void demo_wins(void **state)
{
    (void)state;
    char *text = play("--threads 1");
    assert_non_null(text);
    const char *won = strstr(text, "marble: won in ");
    assert_non_null(won);
    double seconds;
    int taken, all;
    assert_int_equal(sscanf(won, "marble: won in %lf s, %d of %d gems", &seconds, &taken, &all), 3);
    assert_true(seconds > 5 && seconds < 60);
    assert_true(taken > 0 && taken <= all);
    assert_non_null(strstr(text, "tick 600 state 0x"));
    free(text);
}

static void same_game_everywhere(void **state)
{
    (void)state;
    static const char *const options[] = {"--threads 2", "--threads 2 --isa " DAFT_NARROWEST_ISA,
                                          "--threads 1 --isa avx2", "--threads 2 --isa avx512"};
    char *first = play("--threads 1");
    assert_non_null(first);
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        char *other = play(options[i]);
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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(demo_wins), cmocka_unit_test(same_game_everywhere)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
