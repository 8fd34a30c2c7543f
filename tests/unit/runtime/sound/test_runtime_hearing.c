/* runtime: sound by whole runs of the program: what is heard is the same every time, and changes nothing of the game.
 */
#include "runtime_program.h"

#include "daft.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <sys/stat.h>
#include <unistd.h>

static char output[OUTPUT_SIZE], other[OUTPUT_SIZE], folder[64];
static daft_error error;

static int begin(void **unused)
{
    (void)unused;
    snprintf(folder, sizeof folder, "/tmp/daft-heard-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int end(void **unused)
{
    (void)unused;
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

static void write_game(const char *text)
{
    char path[128];
    snprintf(path, sizeof path, "%s/game", folder);
    mkdir(path, 0777);
    snprintf(path, sizeof path, "%s/game/main.lua", folder);
    if (!daft_write_file(path, text, strlen(text), &error)) fail_msg("%s", error.message);
}

static int play(const char *more) { return run_daft(output, "play %s/game --headless %s", folder, more); }

static uint8_t *read_wav(const char *name, size_t *size)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    uint8_t *bytes = daft_read_file(NULL, path, size, &error);
    if (!bytes) fail_msg("%s", error.message);
    return bytes;
}

static void the_demo_sounds_the_same_each_time(void **unused)
{
    (void)unused;
    static const char line[] = "play marble --headless --replay games/marble/demo.rec --hash --size 64x36";
    assert_status(run_daft(other, "%s", line), 0, other);
    size_t sizes[2];
    uint8_t *heard[2];
    for (int i = 0; i < 2; i++) {
        char name[16];
        snprintf(name, sizeof name, "%d.wav", i);
        assert_status(run_daft(output, "%s --sound %s/%s --threads %d", line, folder, name, 1 + i), 0, output);
        assert_string_equal(output, other); /* states and pictures do not know who listens */
        heard[i] = read_wav(name, &sizes[i]);
    }
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(heard[0], heard[1], sizes[0]);
    assert_true(sizes[0] > 44 + 18 * 48000 * 4);
    double power = 0;
    for (size_t i = 44; i + 1 < sizes[0]; i += 2) {
        const int16_t sample = (int16_t)(heard[0][i] | heard[0][i + 1] << 8);
        power += (double)sample * sample / (double)(sizes[0] / 2);
    }
    assert_true(power > 500.0 * 500 && power < 12000.0 * 12000);
    free(heard[0]), free(heard[1]);
}

static void scripts_play_stop_and_move_voices(void **unused)
{
    (void)unused;
    write_game("local s, v, w, ball\n"
               "function daft.load()\n"
               "  s = daft.sound { pitch = 220, hold = 0.4, decay = 0.1 }\n"
               "  assert(math.abs(s:seconds() - 0.505) < 1e-3)\n"
               "  ball = daft.entity { sphere = 0.5, position = { 4, 0, 0 } }\n"
               "  v = s:play { at = ball, near = 2, far = 30, group = 'fx', volume = 0.5, pitch = 2, pan = -1 }\n"
               "  w = s:play { loop = true, fade = 0.5 }\n"
               "  assert(v:playing() and w:playing() and v ~= w and tostring(v) == 'voice 1')\n"
               "  assert(daft.volume('fx') == 1 and daft.volume('fx', 0.5) == 0.5 and daft.volume('all') == 1)\n"
               "  daft.music(daft.sound { notes = 'c4 - g4 -' }, { volume = 0.5, fade = 0.1 })\n"
               "end\n"
               "function daft.update()\n"
               "  local t = daft.tick()\n"
               "  if t == 5 then v:volume(1) v:pitch(1.5) v:pan(1) v:at { 0, 1, 2 } v:at(ball) end\n"
               "  if t == 14 then assert(v:playing()) end\n"
               "  if t == 40 then assert(not v:playing() and w:playing()) v:volume(2) v:stop() w:stop(0.1) end\n"
               "  if t == 50 then assert(not w:playing()) end\n"
               "  if t == 60 then daft.music() print('all well') end\n"
               "end\n");
    assert_status(play("--ticks 80"), 0, output);
    assert_says(output, "all well");
}

static void mistakes_are_named(void **unused)
{
    (void)unused;
    static const struct {
        const char *code, *message;
    } wrong[] = {
        {"daft.sound('no.wav')", "there is no file 'no.wav'"},
        {"daft.sound('main.lua')", "main.lua: this is no WAV, OGG, FLAC or MP3 file"},
        {"daft.sound { pich = 3 }", "there is no 'pich': did you mean 'pitch'?"},
        {"daft.sound { pitch = 1 }", "pitch is 1; it must be between 10 and 20000 Hz"},
        {"daft.sound { wave = 'sinus' }", "wave: \"sine\", \"triangle\""},
        {"daft.sound { notes = 'c4 q' }", "notes: 'q' is no note"},
        {"daft.sound { notes = 7 }", "notes: string expected"},
        {"daft.sound()", "sound: file or table expected, got nothing"},
        {"daft.sound {}:play { volume = 5 }", "volume is 5; it must be between 0 and 4"},
        {"daft.sound {}:play { near = 10, far = 5 }", "far: more than near, 10, expected"},
        {"daft.sound {}:play { at = 'here' }", "at: "},
        {"daft.sound {}:play { lop = true }", "did you mean 'loop'?"},
        {"daft.sound {}:play():pitch(100)", "pitch: 0.0625 to 16 expected, got 100"},
        {"daft.sound {}:plai()", "did you mean 'play'?"},
        {"daft.music(3)", "sound: sound expected, got the number 3"},
        {"daft.volume('a', -1)", "volume: 0 to 4 expected, got -1"},
        {"for i = 1, 20 do daft.volume('g' .. i) end", "group: at most 16 groups"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        char text[256];
        snprintf(text, sizeof text, "function daft.load() %s end", wrong[i].code);
        write_game(text);
        assert_status(play("--ticks 2"), 1, output);
        assert_says(output, wrong[i].message);
    }
    write_game("local s = daft.sound {}\nfunction daft.draw() s:play() end");
    assert_status(play("--ticks 2 --every-frame"), 1, output);
    assert_says(output, "main.lua:2: sound:play: not within daft.draw");
}

/* ---- what editors are told ---- */

/* A value of the field: its default where that is told, else one of its type. */
static void value_of(const char *type, const char *doc, char out[64])
{
    const char *end = strstr(doc, " unless given"), *begin = end;
    while (begin && begin > doc && strncmp(begin - 2, "; ", 2) != 0) begin--;
    if (end)
        snprintf(out, 64, "%.*s", (int)(end - begin), begin);
    else
        snprintf(out, 64, "%s",
                 strncmp(type, "number", 6) == 0         ? "1"
                 : strncmp(type, "string", 6) == 0       ? "'a4'"
                 : strncmp(type, "daft.vector", 11) == 0 ? "{ 0, 0, 0 }"
                                                         : "'#fff'");
}

/* The fields of a class in scripts/daft.d.lua, one "name = value" after another; how many there are. */
static int options_of(const char *file, const char *name, char out[2048])
{
    char head[96];
    snprintf(head, sizeof head, "---@class daft.%s.options\n", name);
    const char *at = strstr(file, head);
    int count = 0;
    size_t used = 0;
    if (!at) fail_msg("there is no %s", head);
    for (at += strlen(head); strncmp(at, "---@field ", 10) == 0; at = strchr(at, '\n') + 1) {
        char field[32], type[64], doc[400], value[64];
        assert_int_equal(sscanf(at, "---@field %31[a-z_]? %63s %399[^\n]", field, type, doc), 3);
        assert_string_not_equal(type, "table");
        value_of(type, doc, value);
        used += (size_t)snprintf(out + used, 2048 - used, "%s = %s, ", field, value);
        count++;
    }
    return count;
}

/* All that the classes name is taken, as what it is without; what they do not name is refused. */
static void options_are_those_that_editors_are_told(void **unused)
{
    (void)unused;
    static const struct {
        const char *name, *before, *after;
        int count;
    } CASES[] = {{"sound", "daft.sound {", "}", 13},
                 {"sound.play", "daft.sound {}:play {", "}", 9},
                 {"particles", "daft.particles {", "}", 14}};
    size_t size;
    char *file = daft_read_file(NULL, DAFT_ROOT "/scripts/daft.d.lua", &size, &error);
    assert_non_null(file);
    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
        static char options[2048], text[4096];
        assert_int_equal(options_of(file, CASES[i].name, options), CASES[i].count);
        for (int wrong = 0; wrong < 2; wrong++) {
            snprintf(text, sizeof text, "function daft.load() %s %s %s %s end", CASES[i].before, options,
                     wrong ? "none = 1" : "", CASES[i].after);
            write_game(text);
            assert_status(play("--ticks 2"), wrong, output);
            if (wrong) assert_says(output, "there is no 'none'");
        }
    }
    assert_non_null(strstr(file, "---@param file string|daft.sound.options\n"));
    assert_non_null(strstr(file, "---@param options? daft.sound.play.options\n"));
    assert_non_null(strstr(file, "---@param options daft.particles.options\n"));
    free(file);
}

/* A sound a tick, held by nothing: neither memory nor the number of voices grows. */
static void sounds_that_nothing_holds_are_let_go(void **unused)
{
    (void)unused;
    write_game("function daft.update()\n"
               "  daft.sound { pitch = 100, hold = 0.9 }:play { loop = true, volume = 0.01 }\n"
               "  if daft.tick() == 2999 then print('went on') end\n"
               "end\n");
    assert_status(play("--ticks 3000 --memory-limit 60MB"), 0, output);
    assert_says(output, "went on");
    write_game("local all = {}\n"
               "function daft.update() all[#all + 1] = daft.sound { pitch = 100 + 0.01 * #all, hold = 9 } end\n");
    assert_status(play("--ticks 3000 --memory-limit 60MB"), 1, output);
    assert_says(output, "out of memory for a sound of 9.3 s");
}

static void sounds_are_written_whole_or_not_at_all(void **unused)
{
    (void)unused;
    write_game("function daft.update() if daft.tick() == 5 then error('stop') end end");
    char more[160];
    snprintf(more, sizeof more, "--ticks 10 --sound %s/none/a.wav", folder);
    assert_status(play(more), 1, output);
    assert_says(output, "none");
    snprintf(more, sizeof more, "--ticks 10 --sound %s/a.wav", folder); /* up to the error: that is what was heard */
    assert_status(play(more), 1, output);
    size_t size;
    free(read_wav("a.wav", &size));
    assert_int_equal(size, 44 + 5 * 800 * 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_demo_sounds_the_same_each_time, begin, end),
        cmocka_unit_test_setup_teardown(scripts_play_stop_and_move_voices, begin, end),
        cmocka_unit_test_setup_teardown(mistakes_are_named, begin, end),
        cmocka_unit_test_setup_teardown(options_are_those_that_editors_are_told, begin, end),
        cmocka_unit_test_setup_teardown(sounds_that_nothing_holds_are_let_go, begin, end),
        cmocka_unit_test_setup_teardown(sounds_are_written_whole_or_not_at_all, begin, end)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
