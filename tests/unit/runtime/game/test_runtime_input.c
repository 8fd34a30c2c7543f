/* runtime: input between ticks, and recordings: what is written reads back the same, and bad files say where. */
#include "platform/input.h"
#include "game/recording.h"
#include "platform/actions.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

static uint64_t state;
static uint64_t next(uint64_t below)
{
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return (state >> 20) % below;
}

static const char *temporary(void)
{
    static char path[64];
    snprintf(path, sizeof path, "/tmp/daft-recording-%d.rec", (int)getpid());
    return path;
}

static int key(const char *name)
{
    int found = input_key_find(name);
    assert_true(found >= 0);
    return found;
}

/* ---- input ---- */

static void a_tap_between_two_ticks_is_seen(void **unused)
{
    (void)unused;
    input keys = {0};
    int space = key("space");
    input_push(&keys, &(input_event){.kind = INPUT_KEY, .key = space, .down = true});
    input_push(&keys, &(input_event){.kind = INPUT_KEY, .key = space, .down = false});
    input_begin_tick(&keys);
    input_apply_queue(&keys);
    assert_true(keys.pressed[space] && keys.released[space] && !keys.down[space]);
    assert_int_equal(keys.applied_count, 2);
    input_begin_tick(&keys);
    input_apply_queue(&keys);
    assert_false(keys.pressed[space] || keys.released[space]);
}

static void repeats_and_nonsense_change_nothing(void **unused)
{
    (void)unused;
    input keys = {0};
    const input_event events[] = {
        {.kind = INPUT_KEY, .key = 3, .down = true},    {.kind = INPUT_KEY, .key = 3, .down = true},
        {.kind = INPUT_KEY, .key = -1, .down = true},   {.kind = INPUT_KEY, .key = 100000, .down = true},
        {.kind = INPUT_MOVE, .x = 0.0f / 0.0f, .y = 1}, {.kind = INPUT_WHEEL, .x = 0, .y = 0}};
    input_begin_tick(&keys);
    for (size_t i = 0; i < 6; i++) input_apply(&keys, &events[i]);
    assert_int_equal(keys.applied_count, 1);
    assert_true(keys.mouse_x == 0);
}

static void losing_the_focus_releases_what_is_held(void **unused)
{
    (void)unused;
    input keys = {0};
    input_begin_tick(&keys);
    input_apply(&keys, &(input_event){.kind = INPUT_KEY, .key = key("left"), .down = true});
    input_push(&keys, &(input_event){.kind = INPUT_KEY, .key = key("up"), .down = true});
    for (int i = 0; i < 1000; i++) /* a full queue must not leave a key stuck */
        input_push(&keys, &(input_event){.kind = INPUT_WHEEL, .y = 1});
    input_push_release_all(&keys);
    input_begin_tick(&keys);
    input_apply_queue(&keys);
    for (int i = 0; i < INPUT_KEYS; i++) assert_false(keys.down[i]);
    assert_true(keys.released[key("left")]);
}

static void every_key_name_finds_its_key(void **unused)
{
    (void)unused;
    size_t count;
    const char *const *names = input_key_names(&count);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(input_key_find(names[i]), (int)i);
        assert_string_equal(input_key_name((int)i), names[i]);
    }
    assert_int_equal(input_key_find("Left"), -1);
    assert_null(input_key_name((int)count));
    assert_null(input_key_name(-1));
}

/* ---- recordings ---- */

static void what_is_recorded_reads_back_to_the_bit(void **unused)
{
    (void)unused;
    state = 0x2545F4914F6CDD1Du;
    print_message("seed %#llx\n", (unsigned long long)state);
    enum { EVENTS = 3000 };
    static recording_item items[EVENTS];
    size_t keys;
    input_key_names(&keys);
    daft_error error;
    recorder *writer =
        recorder_open(temporary(), &(recording_head){.game = "some game", .seed = 1234567890123u}, &error);
    assert_non_null(writer);
    uint64_t tick = 0;
    for (int i = 0; i < EVENTS; i++) {
        tick += next(3);
        input_event event = {.kind = (input_kind)next(6)};
        if (event.kind == INPUT_KEY)
            event.key = (int)next(keys), event.down = next(2);
        else if (event.kind == INPUT_STICK)
            event.key = (int)next(INPUT_STICKS), event.x = (float)next(1u << 30) * 0x1p-29f - 1;
        else if (event.kind == INPUT_WIDTH)
            event.x = 1 + (float)next(1u << 30) * 1e-5f;
        else
            event.x = (float)next(1u << 30) / 12345.0f - 3000, event.y = -(float)next(1u << 30) * 1e-20f;
        items[i] = (recording_item){tick, event};
        recorder_tick(writer, tick, &event, 1);
    }
    recorder_tick(writer, tick + 9, NULL, 0);
    assert_true(recorder_finish(writer, &error));
    recorder_free(writer);
    recording record;
    assert_true(recording_load(&record, NULL, temporary(), &error));
    assert_string_equal(record.game, "some game");
    assert_int_equal(record.seed, 1234567890123u);
    assert_int_equal(record.end, tick + 10);
    assert_int_equal(record.count, EVENTS);
    for (int i = 0; i < EVENTS; i++) {
        const input_event *a = &items[i].event, *b = &record.items[i].event;
        assert_int_equal(items[i].tick, record.items[i].tick);
        assert_true(a->kind == b->kind && a->key == b->key && a->down == b->down && a->x == b->x && a->y == b->y);
    }
    recording_free(&record);
    unlink(temporary());
}

static void playing_gives_each_tick_its_events(void **unused)
{
    (void)unused;
    FILE *file = fopen(temporary(), "w");
    fputs("daft-recording 1\n\n# a comment\ngame x\nrate 60\n0 +left\n3 -left\n3 +left shift\n7 mouse 1.5 2\n7 motion "
          "3 4\n7 motion 1 0\n8 width 960\nend 9\n",
          file);
    fclose(file);
    daft_error error;
    recording record;
    assert_true(recording_load(&record, NULL, temporary(), &error));
    assert_int_equal(record.seed, 1);
    input keys = {0};
    for (uint64_t tick = 0; tick < record.end; tick++) {
        input_begin_tick(&keys);
        recording_play(&record, tick, &keys);
        assert_int_equal(keys.down[key("left")], tick < 3);
        assert_int_equal(keys.pressed[key("left shift")], tick == 3);
        assert_true(keys.mouse_x == (tick >= 7 ? 1.5f : 0));
        assert_true(keys.motion_x == (tick == 7 ? 4 : 0));
        assert_true(keys.width == (tick >= 8 ? 960 : 0));
    }
    recording_free(&record);
    unlink(temporary());
}

/* A killed game's recording ends anywhere; it plays up to its last whole second. */
static void a_cut_recording_plays_to_its_last_second(void **unused)
{
    (void)unused;
    static const char text[] =
        "daft-recording 2\ngame x\n5 +left\ntick 60\n70 -left\n90 +up\ntick 120\n130 +down\n131 mouse 1.5";
    for (size_t size = strlen("daft-recording 2\ngame x\n5 +left\ntick 60\n"); size < sizeof text; size++) {
        FILE *file = fopen(temporary(), "w");
        fwrite(text, 1, size, file);
        fclose(file);
        daft_error error;
        recording record;
        assert_true(recording_load(&record, NULL, temporary(), &error));
        bool two = size >= (size_t)(strstr(text, "130") - text);
        assert_true(record.cut);
        assert_int_equal(record.end, two ? 120 : 60);
        assert_int_equal(record.count, two ? 3 : 1);
        recording_free(&record);
    }
    unlink(temporary());
}

static bool record_ten_ticks(const char *path, const char *game)
{
    daft_error error;
    recorder *writer = recorder_open(path, &(recording_head){.game = game, .seed = 1}, &error);
    assert_non_null(writer);
    recorder_tick(writer, 9, NULL, 0);
    bool good = recorder_finish(writer, &error);
    recorder_free(writer);
    return good;
}

/* The old recording stays until the new one is whole, and what a killed game left is kept. */
static void a_killed_game_loses_no_recording(void **unused)
{
    (void)unused;
    char path[64], part[128], old[140];
    daft_error error;
    snprintf(path, sizeof path, "%s", temporary());
    snprintf(part, sizeof part, "%s.part", path);
    snprintf(old, sizeof old, "%s-old", part);
    const input_event event = {.kind = INPUT_KEY, .key = key("left"), .down = true};
    assert_true(record_ten_ticks(path, "first"));
    pid_t child = fork();
    if (child == 0) {
        recorder *writer = recorder_open(path, &(recording_head){.game = "second", .seed = 1}, &error);
        for (uint64_t tick = 0; tick < 100; tick++) recorder_tick(writer, tick, &event, tick == 3);
        raise(SIGKILL);
    }
    waitpid(child, NULL, 0);
    recording record;
    assert_true(recording_load(&record, NULL, path, &error));
    assert_string_equal(record.game, "first");
    recording_free(&record);
    assert_true(record_ten_ticks(path, "third"));
    assert_true(recording_load(&record, NULL, old, &error));
    assert_string_equal(record.game, "second");
    assert_true(record.cut && record.end == 60 && record.count == 1);
    recording_free(&record);
    assert_int_equal(access(part, F_OK), -1);
    recorder *busy = recorder_open(path, &(recording_head){.game = "fourth", .seed = 1}, &error);
    assert_non_null(busy);
    assert_null(recorder_open(path, &(recording_head){.game = "fifth", .seed = 1}, &error));
    assert_non_null(strstr(error.message, "another game"));
    assert_true(recorder_finish(busy, &error));
    recorder_free(busy);
    unlink(path);
    unlink(old);
}

static void letters_and_widths_are_recorded(void **unused)
{
    (void)unused;
    daft_error error;
    const input_event events[] = {
        {.kind = INPUT_TEXT, .key = 0xe4}, {.kind = INPUT_TEXT, .key = 0x1f600}, {.kind = INPUT_WIDTH, .x = 960.1f}};
    recorder *writer = recorder_open(temporary(), &(recording_head){.game = "some game", .seed = 1}, &error);
    assert_non_null(writer);
    recorder_tick(writer, 0, events, 3);
    assert_true(recorder_finish(writer, &error));
    recorder_free(writer);
    recording record;
    assert_true(recording_load(&record, NULL, temporary(), &error));
    assert_int_equal(record.count, 3);
    for (int i = 0; i < 3; i++) assert_int_equal(record.items[i].event.kind, events[i].kind);
    assert_true(record.items[1].event.key == 0x1f600 && record.items[2].event.x == 960.1f);
    input keys = {0};
    recording_play(&record, 0, &keys);
    assert_true(keys.width == 960.1f && keys.applied_count == 3);
    input_apply(&keys, &(input_event){.kind = INPUT_TEXT, .key = 0xd800});
    input_apply(&keys, &(input_event){.kind = INPUT_WIDTH, .x = 960.1f});
    assert_int_equal(keys.applied_count, 3); /* no letter; nothing new */
    recording_free(&record);
}

static void actions_sum_their_inputs(void **unused)
{
    (void)unused;
    static actions all;
    static input keys;
    action_input in;
    assert_true(action_input_parse("-", &in) && !in.stick && in.sign == 1); /* the key */
    assert_false(action_input_parse("--left x", &in));
    action *walk = actions_set(&all, "walk");
    const char *const inputs[] = {"d", "-a", "left x", "+right y"};
    for (int i = 0; i < 4; i++) assert_true(action_input_parse(inputs[i], &walk->inputs[walk->count++]));
    assert_true(actions_find(&all, "walk") == walk && !actions_find(&all, "run"));
    input_begin_tick(&keys);
    input_apply(&keys, &(input_event){.kind = INPUT_KEY, .key = key("a"), .down = true});
    assert_true(action_value(walk, &keys) == -1 && action_pressed(walk, &keys));
    input_begin_tick(&keys);
    input_apply(&keys, &(input_event){.kind = INPUT_STICK, .key = input_stick_find("left x"), .x = 0.25f});
    assert_true(action_value(walk, &keys) == -0.75f && action_down(walk, &keys) && !action_pressed(walk, &keys));
    input_begin_tick(&keys);
    input_apply(&keys, &(input_event){.kind = INPUT_KEY, .key = key("a"), .down = false});
    assert_true(action_value(walk, &keys) == 0.25f && action_released(walk, &keys) && !action_down(walk, &keys));
    input_begin_tick(&keys);
    input_apply(&keys, &(input_event){.kind = INPUT_STICK, .key = input_stick_find("right y"), .x = -1});
    assert_true(action_value(walk, &keys) == 0.25f); /* the other half */
    input_apply(&keys, &(input_event){.kind = INPUT_STICK, .key = input_stick_find("right y"), .x = 1});
    assert_true(action_value(walk, &keys) == 1 && action_pressed(walk, &keys));
    char name[16];
    for (int i = 1; i < ACTIONS; i++) assert_non_null(actions_set(&all, (snprintf(name, sizeof name, "a%d", i), name)));
    assert_null(actions_set(&all, "one more"));
    assert_ptr_equal(actions_set(&all, "walk"), walk);
}

static void keys_of_the_player_stand_for_keys_of_the_game(void **unused)
{
    (void)unused;
    key_map map, again;
    char text[KEY_MAP_TEXT];
    key_map_reset(&map);
    key_map_set(&map, key("space"), key("j"));
    assert_true(map.to[key("j")] == key("space") && map.to[key("space")] == KEY_MAP_NONE &&
                map.to[key("a")] == key("a"));
    assert_int_equal(key_map_shown(&map, key("space")), key("j"));
    assert_int_equal(key_map_shown(&map, key("j")), -1);
    key_map_set(&map, key("left"), key(","));
    key_map_write(&map, text);
    assert_null(strchr(text, '\n'));
    key_map_read(&again, text);
    assert_memory_equal(&map, &again, sizeof map);
    /* Every key another one still fits; what is no map changes nothing. */
    for (int i = 0; input_key_name(i); i++) map.to[i] = (uint8_t)(i ? i - 1 : KEY_MAP_NONE);
    for (int i = INPUT_KEYS; i < KEY_MAP_INPUTS; i++) map.to[i] = (uint8_t)(KEY_MAP_INPUTS - 1 - (i - INPUT_KEYS));
    key_map_write(&map, text);
    key_map_read(&again, text);
    assert_memory_equal(&map, &again, sizeof map);
    static const char *const bad[] = {"x", "space\t", "space\tnokey\t", "\tspace\t", "no\ta\t", "left x\ta\t"};
    key_map_reset(&map);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        key_map_read(&again, bad[i]);
        assert_memory_equal(&map, &again, sizeof map);
    }
}

static key_map chosen;
static held_inputs held;

/* What the game hears when the player moves a stick or a key, as text. */
static const char *heard(const char *moved, float x)
{
    static char text[96];
    const int stick = input_stick_find(moved);
    const input_event event = stick >= 0 ? (input_event){.kind = INPUT_STICK, .key = stick, .x = x}
                                         : (input_event){.kind = INPUT_KEY, .key = key(moved), .down = x != 0};
    input_event out[KEY_MAP_EVENTS];
    size_t count, used = 0;
    const char *const *sticks = input_stick_names(&count);
    const int events = key_map_translate(&chosen, &held, &event, out);
    text[0] = 0;
    for (int i = 0; i < events; i++)
        used += (size_t)(out[i].kind == INPUT_STICK
                             ? snprintf(text + used, sizeof text - used, "%s %g;", sticks[out[i].key], (double)out[i].x)
                             : snprintf(text + used, sizeof text - used, "%c%s;", out[i].down ? '+' : '-',
                                        input_key_name(out[i].key)));
    return text;
}

static void sticks_of_the_player_stand_for_what_the_game_asks(void **unused)
{
    (void)unused;
    const int left_x = input_stick_find("left x"), right_y = input_stick_find("right y"),
              trigger = input_stick_find("right trigger");
    key_map_reset(&chosen);
    assert_string_equal(heard("left x", 0.3f), "left x 0.3;");
    assert_string_equal(heard("left x", -1), "left x -1;");
    assert_string_equal(heard("left x", NAN), "");
    assert_string_equal(heard("left x", 0), "left x 0;");
    /* A trigger for a key, with some play between down and up. */
    key_map_set(&chosen, key("space"), key_map_half(trigger, false));
    assert_string_equal(heard("right trigger", 0.45f), "");
    assert_string_equal(heard("right trigger", 0.5f), "+space;");
    assert_string_equal(heard("right trigger", 0.45f), "");
    assert_string_equal(heard("right trigger", 0.4f), "-space;");
    assert_string_equal(heard("space", 1), "");
    /* A stick upside down for another. */
    key_map_set_stick(&chosen, left_x, key_map_half(right_y, true));
    assert_string_equal(heard("right y", 0.25f), "left x -0.25;");
    assert_string_equal(heard("right y", -1), "left x 1;");
    assert_string_equal(heard("left x", 1), "");
    /* A key for a half beside the other half, and the two halves of one stick for two keys. */
    key_map_reset(&chosen);
    held = (held_inputs){.stick = {0}};
    key_map_set(&chosen, key_map_half(left_x, true), key("q"));
    assert_string_equal(heard("q", 1), "left x -1;");
    assert_string_equal(heard("left x", 0.75f), "left x -0.25;");
    assert_string_equal(heard("q", 0), "left x 0.75;");
    key_map_set(&chosen, key("a"), key_map_half(right_y, true));
    key_map_set(&chosen, key("b"), key_map_half(right_y, false));
    assert_string_equal(heard("right y", 1), "+b;");
    assert_string_equal(heard("right y", -1), "-b;+a;");
    char text[KEY_MAP_NAME];
    assert_string_equal(key_map_label(NULL, key_map_shown(&chosen, key("a")), false, text), "right stick up");
    assert_string_equal(key_map_name(key_map_shown(&chosen, key("a")), text), "-right y");
    assert_string_equal(key_map_label(NULL, key_map_half(left_x, true), true, text), "left stick → ←");
    /* Whichever way inputs stand for others, all that is let go leaves everything at rest. */
    key_map_reset(&chosen);
    held = (held_inputs){.stick = {0}};
    float sticks[INPUT_STICKS] = {0};
    bool down[INPUT_KEYS] = {false};
    uint32_t number = 5;
    for (int i = 0; i < KEY_MAP_INPUTS; i++) {
        number = number * 1664525u + 1013904223u;
        const int asked = (int)((number >> 8) % KEY_MAP_INPUTS);
        if (asked < INPUT_KEYS && !input_key_name(asked)) continue;
        if (i < INPUT_KEYS && !input_key_name(i)) continue;
        key_map_set(&chosen, asked, i);
    }
    for (int i = 0; i < 20000; i++) {
        number = number * 1664525u + 1013904223u;
        const bool stick = (number >> 8) % 2, rest = i >= 18000;
        const int which = (int)((number >> 9) % (stick ? INPUT_STICKS : (unsigned)key("start again")));
        const float x = rest ? 0 : (float)((int)(number >> 12) % 201 - 100) / 100;
        const input_event event = {
            .kind = stick ? INPUT_STICK : INPUT_KEY, .key = which, .down = !rest && x > 0, .x = x};
        input_event out[KEY_MAP_EVENTS];
        const int count = key_map_translate(&chosen, &held, &event, out);
        for (int k = 0; k < count; k++)
            if (out[k].kind == INPUT_STICK) {
                assert_true(out[k].x >= -1 && out[k].x <= 1);
                sticks[out[k].key] = out[k].x;
            } else {
                down[out[k].key] = out[k].down;
            }
    }
    for (int i = 0; i < INPUT_STICKS; i++) assert_true(sticks[i] == 0);
    for (int i = 0; i < INPUT_KEYS; i++) assert_false(down[i]);
}

/* The tick that was given this input did not come to its end: its replay gets there too. */
static void a_recording_holds_the_tick_that_failed(void **unused)
{
    (void)unused;
    daft_error error;
    const input_event event = {.kind = INPUT_KEY, .key = key("left"), .down = true};
    recorder *writer = recorder_open(temporary(), &(recording_head){.game = "some game", .seed = 1}, &error);
    assert_non_null(writer);
    for (uint64_t tick = 0; tick < 8; tick++) recorder_tick(writer, tick, &event, tick == 7);
    assert_true(recorder_finish(writer, &error));
    recorder_tick(writer, 8, &event, 1); /* too late: the file is in place */
    assert_true(recorder_finish(writer, &error));
    recorder_free(writer);
    recording record;
    assert_true(recording_load(&record, NULL, temporary(), &error));
    assert_true(!record.cut && record.end == 8 && record.count == 1 && record.items[0].tick == 7);
    recording_free(&record);
}

static void bad_files_say_where(void **unused)
{
    (void)unused;
    static const struct {
        const char *text;
        int line, column;
        const char *message;
    } bad[] = {
        {"", 1, 1, "not a recording"},
        {"daft-recording 7\nend 1\n", 1, 16, "not a recording of this version"},
        {"daft-recording 6\nscript\nend 1\n", 2, 7, "the name of a script"},
        {"daft-recording 6\nscript tween 12\nend 1\n", 2, 14, "a SHA-256 expected"},
        {"daft-recording 3\nsaved ../x {}\nend 1\n", 2, 7, "the name of what a game saved"},
        {"daft-recording 3\nsaved\nend 1\n", 2, 6, "the name of what a game saved"},
        {"daft-recording 2\ntick 60\ntick 59\nend 60\n", 3, 8, "must not go back"},
        {"daft-recording 2\n60 +left\ntick 60\nend 90\n", 3, 8, "must not go back"},
        {"daft-recording 2\ntick 60\nend 59\n", 3, 7, "before its last tick"},
        {"daft-recording 1\n", 3, 1, "'end' line is missing"},
        {"daft-recording 1\ngame\nend 1\n", 2, 5, "a game's name"},
        {"daft-recording 1\nrate 30\nend 1\n", 2, 8, "60 ticks"},
        {"daft-recording 1\nseed x\nend 1\n", 2, 6, "whole number"},
        {"daft-recording 1\n5 +left\n4 -left\nend 9\n", 3, 3, "must not go back"},
        {"daft-recording 1\n5 +lefft\nend 9\n", 2, 4, "did you mean 'left'?"},
        {"daft-recording 1\n5 left\nend 9\n", 2, 3, "+key, -key, mouse, motion, wheel, stick, width, text or lua"},
        {"daft-recording 4\n5 text d800\nend 9\n", 2, 8, "the code point of a letter"},
        {"daft-recording 4\n5 text 7\nend 9\n", 2, 8, "the code point of a letter"},
        {"daft-recording 1\n5 mouse 1\nend 9\n", 2, 10, "a number expected"},
        {"daft-recording 1\n5 mouse 1 nan\nend 9\n", 2, 11, "a number expected"},
        {"daft-recording 1\n5 width wide\nend 9\n", 2, 9, "a number expected"},
        {"daft-recording 1\n5 wheel 1 2 3\nend 9\n", 2, 13, "unexpected text '3'"},
        {"daft-recording 1\nmove\nend 9\n", 2, 1, "a tick"},
        {"daft-recording 1\n99999999999999999999 +left\nend 9\n", 2, 1, "a tick"},
        {"daft-recording 1\n5 +left\nend 5\n", 3, 6, "before its last event"},
        {"daft-recording 1\nend 5\n6 +left\n", 3, 1, "after the 'end' line"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        FILE *file = fopen(temporary(), "w");
        fputs(bad[i].text, file);
        fclose(file);
        daft_error error = {0};
        recording record;
        assert_false(recording_load(&record, NULL, temporary(), &error));
        if (!strstr(error.message, bad[i].message)) fail_msg("case %zu: '%s'", i, error.message);
        if (error.line != bad[i].line || error.column != bad[i].column)
            fail_msg("case %zu: %d:%d, not %d:%d", i, error.line, error.column, bad[i].line, bad[i].column);
        assert_string_equal(error.file, temporary());
    }
    unlink(temporary());
    daft_error error = {0};
    recording record;
    assert_false(recording_load(&record, NULL, "/nowhere/at/all.rec", &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_false(recording_load(&record, NULL, "/tmp", &error));
    assert_non_null(strstr(error.message, "directory"));
    assert_null(recorder_open("/nowhere/at/all.rec", &(recording_head){.game = "x", .seed = 1}, &error));
}

/* Any bytes are refused or read, and never do harm. */
static void random_bytes_do_no_harm(void **unused)
{
    (void)unused;
    state = 0xD1B54A32D192ED03u;
    print_message("seed %#llx\n", (unsigned long long)state);
    static const char *const words[] = {
        "daft-recording", " ",     "1",      "\n",    "game", "rate", "60", "seed", "end", "+",    "-",
        "left",           "mouse", "motion", "wheel", "1e30", "nan",  "-5", "#",    "\t",  "\xff", "999999999999999"};
    for (int i = 0; i < 500; i++) {
        FILE *file = fopen(temporary(), "w");
        if (next(4)) fputs("daft-recording 1\n", file);
        for (uint64_t n = next(60); n > 0; n--) fputs(words[next(sizeof words / sizeof words[0])], file);
        if (next(8) == 0) fputc(0, file);
        fclose(file);
        daft_error error;
        recording record;
        if (recording_load(&record, NULL, temporary(), &error)) recording_free(&record);
    }
    unlink(temporary());
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_tap_between_two_ticks_is_seen),
                                       cmocka_unit_test(repeats_and_nonsense_change_nothing),
                                       cmocka_unit_test(losing_the_focus_releases_what_is_held),
                                       cmocka_unit_test(every_key_name_finds_its_key),
                                       cmocka_unit_test(what_is_recorded_reads_back_to_the_bit),
                                       cmocka_unit_test(playing_gives_each_tick_its_events),
                                       cmocka_unit_test(a_cut_recording_plays_to_its_last_second),
                                       cmocka_unit_test(a_killed_game_loses_no_recording),
                                       cmocka_unit_test(letters_and_widths_are_recorded),
                                       cmocka_unit_test(actions_sum_their_inputs),
                                       cmocka_unit_test(keys_of_the_player_stand_for_keys_of_the_game),
                                       cmocka_unit_test(sticks_of_the_player_stand_for_what_the_game_asks),
                                       cmocka_unit_test(a_recording_holds_the_tick_that_failed),
                                       cmocka_unit_test(bad_files_say_where),
                                       cmocka_unit_test(random_bytes_do_no_harm)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
