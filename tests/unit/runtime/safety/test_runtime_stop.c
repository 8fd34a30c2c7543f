/* runtime: how the program ends before its time. Signals save what there is and leave nothing else behind; a game that
 * does not come back is stopped; standard output that takes nothing is told. */
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

static void make_folder(void)
{
    snprintf(folder, sizeof folder, "/tmp/daft-stop-XXXXXX");
    assert_non_null(mkdtemp(folder));
}

static void remove_folder(void)
{
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

static void wait_ms(long ms) { nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000}, NULL); }

/* A game in a folder of its own. */
static void write_game(const char *text)
{
    char path[128];
    snprintf(path, sizeof path, "%s/game", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    snprintf(path, sizeof path, "%s/game/main.lua", folder);
    daft_error error;
    assert_true(daft_write_file(path, text, strlen(text), &error));
}

/* Starts the program without a shell, since shells let what runs in the background ignore SIGINT. */
static pid_t start(char *const *words)
{
    pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0) return child;
    int nowhere = open("/dev/null", O_RDWR);
    for (int i = 0; i < 3; i++) dup2(nowhere, i);
    if (chdir(DAFT_ROOT) != 0) _exit(99);
    execv(DAFT_PROGRAM, words);
    _exit(99);
}

static char *in_folder(char *out, size_t size, const char *name)
{
    snprintf(out, size, "%s/%s", folder, name);
    return out;
}

/* How many files of the folder have names that begin so. */
static int count_files(const char *prefix)
{
    int count = 0;
    DIR *list = opendir(folder);
    assert_non_null(list);
    for (struct dirent *entry; (entry = readdir(list));) count += strncmp(entry->d_name, prefix, strlen(prefix)) == 0;
    closedir(list);
    return count;
}

/* At most a minute: a machine may be busy. */
static void wait_for_files(const char *prefix)
{
    for (int i = 0; i < 6000 && count_files(prefix) == 0; i++) wait_ms(10);
    assert_true(count_files(prefix) > 0);
}

static bool says(const char *path, const char *text)
{
    char bytes[4096];
    FILE *file = fopen(path, "r");
    if (!file) return false;
    bytes[fread(bytes, 1, sizeof bytes - 1, file)] = 0;
    fclose(file);
    return strstr(bytes, text) != NULL;
}

static void signals_save_the_recording(void **unused)
{
    (void)unused;
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t i = 0; i < 3; i++) {
        char game[128], file[128], part[160];
        make_folder();
        write_game("function daft.update()\n"
                   "    daft.input.set('left', daft.tick() % 2 == 0)\n"
                   "    if daft.tick() == 90 then while true do end end\n"
                   "end\n");
        in_folder(file, sizeof file, "played.rec");
        snprintf(part, sizeof part, "%s.part", file);
        char *words[] = {"daft",       "play",    in_folder(game, sizeof game, "game"),
                         "--headless", "--ticks", "100000",
                         "--record",   file,      "--time-limit",
                         "600",        NULL};
        pid_t child = start(words);
        for (int tries = 0; tries < 6000 && !says(part, "tick 60"); tries++) wait_ms(10);
        kill(child, numbers[i]);
        int status;
        waitpid(child, &status, 0);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == numbers[i]);
        recording record;
        daft_error error;
        assert_true(recording_load(&record, NULL, file, &error));
        assert_true(!record.cut && record.end > 60 && record.end <= 91);
        assert_true(record.count + 2 >= record.end);
        recording_free(&record);
        assert_int_equal(count_files("played.rec"), 1);
        remove_folder();
    }
}

static void signals_remove_temporary_files(void **unused)
{
    (void)unused;
    char file[128];
    make_folder();
    char *words[] = {"daft",
                     "render",
                     "assets/scenes/temple.scene",
                     "-o",
                     in_folder(file, sizeof file, "picture.png"),
                     "-q",
                     "draft",
                     "--size",
                     "6000x4000",
                     NULL};
    pid_t child = start(words);
    wait_for_files(".daft-");
    kill(child, SIGTERM);
    int status;
    waitpid(child, &status, 0);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
    assert_int_equal(count_files(".daft-"), 0);
    assert_int_equal(count_files("picture"), 0);
    remove_folder();
}

/* What was ignored when the program began stays so, as under nohup. */
static void ignored_signals_stay_ignored(void **unused)
{
    (void)unused;
    char game[128], file[128];
    make_folder();
    write_game("function daft.update() if daft.tick() == 70 then while true do end end end\n");
    in_folder(file, sizeof file, "played.rec");
    char *words[] = {"daft",       "play",    in_folder(game, sizeof game, "game"),
                     "--headless", "--ticks", "100000",
                     "--record",   file,      "--time-limit",
                     "1",          NULL};
    signal(SIGHUP, SIG_IGN);
    pid_t child = start(words);
    signal(SIGHUP, SIG_DFL);
    wait_for_files("played.rec.part");
    kill(child, SIGHUP);
    int status;
    waitpid(child, &status, 0);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1);
    remove_folder();
}

/* The recording of a game that hangs leads to the same place. */
static void what_hangs_hangs_again_in_its_replay(void **unused)
{
    (void)unused;
    make_folder();
    write_game("local pressed = false\n"
               "function daft.keypressed(key) while key == 'space' do end end\n"
               "function daft.update() if daft.tick() == 3 then daft.input.set('space', true) end end\n");
    int status = run_daft(output, "play %s/game --headless --time-limit 0.2 --record %s/played.rec", folder, folder);
    assert_status(status, 1, output);
    assert_says(output, "main.lua:2: daft.keypressed ran for 0.2 s without coming to an end");
    status = run_daft(output, "play %s/game --headless --time-limit 0.2 --replay %s/played.rec", folder, folder);
    assert_status(status, 1, output);
    assert_says(output, "main.lua:2: daft.keypressed ran for 0.2 s without coming to an end");
    remove_folder();
}

/* One operation of Lua that takes an hour, since all of these keys share a slot: only the end of the program helps. */
static void what_cannot_be_stopped_is_ended(void **unused)
{
    (void)unused;
    make_folder();
    write_game("function daft.update()\n"
               "    local t = {}\n"
               "    while daft.tick() == 5 do\n"
               "        for i = 1, 1 << 22 do t[i * ((1 << 22) - 1) * ((1 << 21) - 1) * ((1 << 20) - 1)] = i end\n"
               "    end\n"
               "end\n");
    int status = run_daft(output, "play %s/game --headless --time-limit 0.3 --record %s/played.rec", folder, folder);
    assert_status(status, 1, output);
    assert_says(output, "daft.update ran for 0.");
    char file[128];
    recording record;
    daft_error error;
    assert_true(recording_load(&record, NULL, in_folder(file, sizeof file, "played.rec"), &error));
    assert_int_equal(record.end, 6);
    recording_free(&record);
    remove_folder();
}

static void lost_output_is_told(void **unused)
{
    (void)unused;
    if (access("/dev/full", W_OK) != 0) skip();
    static const char *const commands[] = {
        "help", "help lua", "version", "play tests/games/sample --headless --ticks 60 --hash",
        "render assets/scenes/temple.scene --size 64x36 --stats - -o \"$OUT\"/a.png"};
    make_folder();
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        char command[1024];
        snprintf(command, sizeof command, "OUT=%s; cd '%s' && '%s' %s 2>&1 >/dev/full", folder, DAFT_ROOT, DAFT_PROGRAM,
                 commands[i]);
        FILE *pipe = popen(command, "r");
        assert_non_null(pipe);
        output[fread(output, 1, OUTPUT_SIZE - 1, pipe)] = 0;
        int status = pclose(pipe);
        assert_int_equal(WEXITSTATUS(status), 1);
        assert_says(output, "standard output cannot be written");
    }
    remove_folder();
}

static void the_limit_of_time_has_a_range(void **unused)
{
    (void)unused;
    static const char *const wrong[] = {"0", "0.05", "-1", "3601", "nan", "1e9", "x"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        int status = run_daft(output, "play tests/games/sample --headless --ticks 1 --time-limit %s", wrong[i]);
        assert_status(status, 2, output);
        assert_says(output, "--time-limit: a number from 0");
    }
    assert_status(run_daft(output, "play tests/games/sample --headless --ticks 1 --time-limit 3600"), 0, output);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(signals_save_the_recording),      cmocka_unit_test(signals_remove_temporary_files),
        cmocka_unit_test(ignored_signals_stay_ignored),    cmocka_unit_test(what_hangs_hangs_again_in_its_replay),
        cmocka_unit_test(what_cannot_be_stopped_is_ended), cmocka_unit_test(lost_output_is_told),
        cmocka_unit_test(the_limit_of_time_has_a_range)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
