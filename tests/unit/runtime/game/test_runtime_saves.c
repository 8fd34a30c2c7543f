/* runtime: what games keep from one start to the next: daft.save and daft.load_saved, by whole runs of the program. */
#include "files/saves.h"
#include "game/recording.h"
#include "runtime_program.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static char output[OUTPUT_SIZE], folder[64];

static void write_text(const char *path, const char *text)
{
    daft_error error;
    if (!daft_write_file(path, text, strlen(text), &error)) fail_msg("%s", error.message);
}

/* A game in a folder of its own, and one for what it keeps. */
static int begin(const char *game)
{
    char path[128];
    snprintf(folder, sizeof folder, "/tmp/daft-saves-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/game", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    snprintf(path, sizeof path, "%s/kept", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    snprintf(path, sizeof path, "%s/game/main.lua", folder);
    write_text(path, game);
    return 0;
}

static void end(void)
{
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

static int play(const char *more)
{
    return run_daft(output, "play %s/game --headless --ticks 3 --saves %s/kept %s", folder, folder, more);
}

static const char counting[] =
    "local v\n"
    "function daft.load()\n"
    "  v = daft.load_saved('scores') or { runs = 0, names = { 'Ada', 'B\\n\"\\\\' }, best = 1.0 }\n"
    "  v.runs = v.runs + 1\n"
    "  v.best = v.best / 3\n"
    "  assert(math.type(v.best) == 'float' and math.type(v.runs) == 'integer')\n"
    "  assert(v.names[1] == 'Ada' and v.names[2] == 'B\\n\"\\\\')\n"
    "  daft.save('scores', v)\n"
    "  assert(daft.load_saved('scores').runs == v.runs and daft.load_saved('scores') ~= v)\n"
    "  print('runs ' .. v.runs)\n"
    "end\n";

static void values_outlast_the_game(void **unused)
{
    (void)unused;
    begin(counting);
    for (int i = 1; i <= 3; i++) {
        char wanted[32];
        snprintf(wanted, sizeof wanted, "runs %d\n", i);
        assert_status(play(""), 0, output);
        assert_says(output, wanted);
    }
    /* Without a folder, and so in tests, a game begins with nothing. */
    assert_status(run_daft(output, "play %s/game --headless --ticks 3", folder), 0, output);
    assert_says(output, "runs 1\n");
    assert_status(run_daft(output, "play %s/game --headless --saves %s/nowhere", folder, folder), 2, output);
    end();
}

static void all_values_come_back(void **unused)
{
    (void)unused;
    begin("local values = { 0, -1, math.maxinteger, math.mininteger, 0.1, 1e300, -5e-324, 2.0, -0.0, true, false, '',\n"
          "  ('\\0\\1\\127\\255\"\\\\]=},\\r\\n'):rep(50), {}, { [0] = 1, [-7] = { a = { b = {} } }, ['1'] = 2, [1] = "
          "3 } }\n"
          "local function same(a, b)\n"
          "  if type(a) ~= 'table' then return a == b and math.type(a) == math.type(b) end\n"
          "  for k, v in pairs(a) do if not same(v, b[k]) then return false end end\n"
          "  for k in pairs(b) do if a[k] == nil then return false end end\n"
          "  return true\n"
          "end\n"
          "local found = daft.load_saved('all')\n"
          "if found then assert(same(found, values) and same(values, found)) print('the same') end\n"
          "daft.save('all', values)\n"
          "daft.save('gone', 5) daft.save('gone', nil) assert(daft.load_saved('gone') == nil)\n");
    assert_status(play(""), 0, output);
    assert_status(play(""), 0, output);
    assert_says(output, "the same\n");
    end();
}

/* A replay is given what its recording was, whatever is kept now, and writes nothing. */
static void replays_repeat_what_was_loaded(void **unused)
{
    (void)unused;
    char more[256];
    begin(counting);
    assert_status(play(""), 0, output);
    snprintf(more, sizeof more, "--record %s/two.rec", folder);
    assert_status(play(more), 0, output);
    assert_says(output, "runs 2\n");
    assert_status(play(""), 0, output);
    snprintf(more, sizeof more, "--replay %s/two.rec --record %s/again.rec", folder, folder);
    assert_status(play(more), 0, output);
    assert_says(output, "runs 2\n");
    snprintf(more, sizeof more, "--replay %s/again.rec", folder);
    assert_status(play(more), 0, output);
    assert_says(output, "runs 2\n");
    assert_status(play(""), 0, output);
    assert_says(output, "runs 4\n");
    char path[128];
    snprintf(path, sizeof path, "%s/bad.rec", folder);
    write_text(path, "daft-recording 3\ngame game\nsaved ../x {}\nend 3\n");
    snprintf(more, sizeof more, "--replay %s", path);
    assert_status(play(more), 1, output);
    assert_says(output, "bad.rec:3:7: the name of what a game saved expected");
    end();
}

static void what_cannot_be_saved_is_an_error(void **unused)
{
    (void)unused;
    static const struct {
        const char *line, *says;
    } CASES[] = {{"daft.save('a/b', 1)", "name: string of up to 64 letters"},
                 {"daft.save('', 1)", "name: string of up to 64 letters"},
                 {"daft.save('x\\0y', 1)", "name: string of up to 64 letters"},
                 {"daft.save(('x'):rep(65), 1)", "name: string of up to 64 letters"},
                 {"daft.load_saved({})", "name: string of up to 64 letters"},
                 {"daft.save('x', print)", "a function cannot be saved"},
                 {"daft.save('x', { { daft.entity { sphere = 1 } } })", "a userdata cannot be saved"},
                 {"daft.save('x', 0/0)", "not finite"},
                 {"daft.save('x', { [1.5] = 1 })", "keys must be strings or whole numbers"},
                 {"local t = {} t.t = t daft.save('x', t)", "nest deeper than 32, or hold themselves"},
                 {"daft.save('x', ('y'):rep(2000000))", "takes more than 1048576 bytes"},
                 {"local t = {} for i = 1, 200000 do t[i] = i end daft.save('x', t)", "takes more than 1048576 bytes"},
                 {"for i = 1, 65 do daft.save('x' .. i, i) end", "at most 64 saves"}};
    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
        char game[300];
        snprintf(game, sizeof game, "function daft.load()\n%s\nend\n", CASES[i].line);
        begin(game);
        assert_status(play(""), 1, output);
        assert_says(output, CASES[i].says);
        end();
    }
    begin("function daft.draw() daft.save('x', 1) end\n");
    assert_status(play("--hash"), 1, output);
    assert_says(output, "save");
    end();
}

/* What is not what a game saved is told to the game, and kept beside the next save. */
static void broken_files_are_kept(void **unused)
{
    (void)unused;
    static const char *const BROKEN[] = {"",
                                         "daft-save 1",
                                         "daft-save 1\n",
                                         "daft-save 1\n{[\"runs\"]=1",
                                         "daft-save 1\n{[\"runs\"]=1}\nmore\n",
                                         "daft-save 2\n{}\n",
                                         "daft-save 1\n{\"runs\"=1}\n",
                                         "daft-save 1\nprint(1)\n",
                                         "daft-save 1\n{[1]=nan}\n",
                                         "daft-save 1\n{[1]=1e999}\n",
                                         "daft-save 1\n\"\\q\"\n",
                                         "daft-save 1\n{[.5]=1}\n",
                                         "daft-save 1\n1 \n"};
    for (size_t i = 0; i < sizeof BROKEN / sizeof BROKEN[0]; i++) {
        char path[128], aside[128];
        begin("local v, why = daft.load_saved('s')\n"
              "assert(v == nil and why, 'not told')\n"
              "print(why)\n"
              "daft.save('s', { runs = 7 })\n"
              "assert(daft.load_saved('s').runs == 7)\n");
        snprintf(path, sizeof path, "%s/kept/game.s.save", folder);
        snprintf(aside, sizeof aside, "%s/kept/game.s.save.broken", folder);
        write_text(path, BROKEN[i]);
        assert_status(play(""), 0, output);
        size_t size;
        daft_error error;
        char *old = daft_read_file(NULL, aside, &size, &error), *now = daft_read_file(NULL, path, &size, &error);
        assert_string_equal(old, BROKEN[i]);
        assert_string_equal(now, "daft-save 1\n{[\"runs\"]=7}\n");
        free(old), free(now);
        end();
    }
}

/* Saves of random changes load, or say why not; never anything else. */
static void changed_files_do_no_harm(void **unused)
{
    (void)unused;
    char path[128];
    uint32_t state = (uint32_t)time(NULL);
    print_message("seed %u\n", state);
    begin("for i = 1, 60 do\n"
          "  local v, why = daft.load_saved('s' .. i)\n"
          "  assert((v == nil) == (type(why) == 'string') or v == nil)\n"
          "  daft.save('copy', v)\n"
          "end\n");
    static const char good[] = "daft-save 1\n{[-3]=true,[\"best\"]=0.25,[\"deep\"]={[1]={}},[\"n\"]=\"a\\x0a\\\"b\"}\n";
    for (int round = 0; round < 5; round++) {
        for (int i = 1; i <= 60; i++) {
            char text[sizeof good];
            memcpy(text, good, sizeof good);
            for (int k = 0; k <= i % 3; k++) {
                state = state * 1664525u + 1013904223u;
                text[12 + state / 65536 % (sizeof good - 14)] = "{}[]\"\\=,.x0e-nt"[state / 7 % 15];
            }
            snprintf(path, sizeof path, "%s/kept/game.s%d.save", folder, i);
            write_text(path, text);
        }
        assert_status(play(""), 0, output);
    }
    end();
}

static void sleep_ms(long ms) { nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000}, NULL); }

/* How long it took until there was such a file, in steps of 5 ms. */
static long wait_for_file(const char *path)
{
    long ms = 0;
    for (; ms < 60000 && access(path, F_OK) != 0; ms += 5) sleep_ms(5);
    return ms;
}

/* A game that is killed at any moment leaves the value before or the one after. Moments begin while it starts: how long
 * that takes the first run tells. */
static void a_kill_loses_nothing(void **unused)
{
    (void)unused;
    char path[160], game[128], kept[128];
    begin("local n = (daft.load_saved('n') or { n = 0 }).n\n"
          "function daft.update()\n"
          "  for i = 1, 20 do n = n + 1 daft.save('n', { n = n, fill = ('x'):rep(5000), last = n }) end\n"
          "end\n");
    snprintf(path, sizeof path, "%s/kept/game.n.save", folder);
    snprintf(game, sizeof game, "%s/game", folder), snprintf(kept, sizeof kept, "%s/kept", folder);
    uint32_t state = (uint32_t)time(NULL);
    long long before = 0;
    long start = 0;
    print_message("seed %u\n", state);
    for (int i = 0; i < 40; i++) {
        char *const words[] = {"daft", "play", game, "--headless", "--ticks", "1000000", "--saves", kept, NULL};
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            int nowhere = open("/dev/null", O_RDWR);
            for (int k = 0; k < 3; k++) dup2(nowhere, k);
            execv(DAFT_PROGRAM, words);
            _exit(99);
        }
        state = state * 1664525u + 1013904223u;
        if (i == 0) start = wait_for_file(path);
        sleep_ms((i > 0 ? start * 3 / 4 : 0) + (long)(state / 65536 % 60));
        kill(child, SIGKILL);
        waitpid(child, NULL, 0);
        size_t size;
        daft_error error;
        char *text = daft_read_file(NULL, path, &size, &error);
        if (!text) continue; /* not one save yet */
        long long n = 0;
        const char *last = strstr(text, "[\"last\"]=");
        assert_non_null(last);
        assert_int_equal(sscanf(last, "[\"last\"]=%lld", &n), 1);
        assert_true(n >= before && text[size - 1] == '\n' && text[size - 2] == '}');
        before = n;
        free(text);
    }
    assert_true(before > 0);
    end();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_outlast_the_game),        cmocka_unit_test(all_values_come_back),
        cmocka_unit_test(replays_repeat_what_was_loaded), cmocka_unit_test(what_cannot_be_saved_is_an_error),
        cmocka_unit_test(broken_files_are_kept),          cmocka_unit_test(changed_files_do_no_harm),
        cmocka_unit_test(a_kill_loses_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
