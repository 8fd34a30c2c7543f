/* The fuzzers' seeds, and every input that has once broken something (tests/fuzz/corpus), through the same functions
 * that the fuzzers call. An input that breaks a promise aborts; the last file named is then the one. */
#include "fuzz.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

enum { LARGEST = 1 << 20 };
static uint8_t bytes[LARGEST];

static void replay(const fuzz_target *what, const char *path)
{
    print_message("%s\n", path);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    fuzz_run(what, bytes, size);
}

static int is_shown(const struct dirent *entry) { return entry->d_name[0] != '.'; }

static int replay_folder(const fuzz_target *what, const char *kind)
{
    char folder[512], path[1024];
    struct dirent **entries = NULL;
    snprintf(folder, sizeof folder, "%s/tests/fuzz/%s/%s", DAFT_ROOT, kind, what->name);
    int count = scandir(folder, &entries, is_shown, alphasort);
    for (int i = 0; i < count; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        replay(what, path);
        free(entries[i]);
    }
    free(entries);
    return count;
}

static void the_corpus_does_no_harm(void **state)
{
    const fuzz_target *what = *state;
    assert_true(replay_folder(what, "seeds") > 0);
    replay_folder(what, "corpus"); /* there is none where nothing has been found */
}

int main(void)
{
    struct CMUnitTest tests[FUZZ_TARGET_COUNT];
    for (int i = 0; i < FUZZ_TARGET_COUNT; i++)
        tests[i] =
            (struct CMUnitTest){FUZZ_TARGETS[i].name, the_corpus_does_no_harm, NULL, NULL, (void *)&FUZZ_TARGETS[i]};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
