/* runtime: playing games without a window: the Lua API by games that check it from inside, script errors, recordings,
 * the same hashes on any number of threads, and the demo where there is no display. */
#include "cli/commands.h"
#include "game/game.h"
#include "files/home.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <unistd.h>

#include "runtime_program.h"

static char output[OUTPUT_SIZE], again[OUTPUT_SIZE];

/* ---- games that check the API from inside: a failed assertion is exit status 1 ---- */

static void play_through(const char *game, int ticks)
{
    int status = run_daft(output, "play tests/games/%s --headless --hash --ticks %d --time-limit 600", game, ticks);
    if (status != 0) fail_msg("%s: exit status %d\n%s", game, status, output);
}

static void the_api_does_what_it_says(void **unused) { (void)unused, play_through("api", 61); }
static void bodies_do_what_the_manual_says(void **unused) { (void)unused, play_through("physics", 241); }
static void the_sandbox_holds(void **unused) { (void)unused, play_through("sandbox", 1); }
static void tasks_wait_for_their_ticks(void **unused)
{
    (void)unused;
    play_through("tasks", 100);
    assert_says(output, "tick 31 "); /* daft.quit ended it there */
}
static void the_world_does_what_it_says(void **unused) { (void)unused, play_through("world", 13); }
static void time_goes_slowly_and_stands_still(void **unused) { (void)unused, play_through("slow", 150); }
static void the_library_works(void **unused) { (void)unused, play_through("library", 210); }
static void actions_are_keys_and_sticks(void **unused) { (void)unused, play_through("actions", 60); }
static void menus_go_by_keys(void **unused)
{
    (void)unused;
    play_through("menus", 100);
    assert_says(output, "tick 81 "); /* daft.quit ended it there */
}
static void nonsense_never_crashes(void **unused) { (void)unused, play_through("nonsense", 10); }

static void the_games_of_the_design_and_of_the_house_play(void **unused)
{
    (void)unused;
    play_through("sample", 180);
    assert_says(output, "tick 60 state 0x");
    assert_says(output, "tick 180 state 0x");
    int status = run_daft(output, "play marble --headless --ticks 60");
    assert_status(status, 0, output);
}

static void restarting_starts_afresh(void **unused)
{
    (void)unused;
    play_through("restart", 100);
    char *first = strstr(output, "first\t"), *second = strstr(output, "second\t");
    assert_non_null(first);
    assert_non_null(second);
    assert_int_equal(atoi(first + 6), atoi(second + 7));
    assert_says(output, "tick 43 "); /* daft.quit ended it there */
}

/* ---- errors ---- */

static void script_errors_are_status_1_with_place_and_trace(void **unused)
{
    (void)unused;
    static const struct {
        const char *game, *says, *trace;
    } broken[] = {
        {"broken_syntax", "broken_syntax/main.lua:3: unexpected symbol near '='", ""},
        {"broken_load", "broken_load/main.lua:2: daft.entity: position: {x, y, z} expected, got the string 'here'",
         "broken_load/main.lua:5: in function 'daft.load'"},
        {"broken_update", "broken_update/main.lua:5: attempt to index a nil value", "in function 'daft.update'"},
        {"broken_draw", "broken_draw/main.lua:3: daft.text: x: number expected", "in function 'daft.draw'"},
        {"broken_task", "broken_task/main.lua:4: attempt to index a nil value (local 'nothing')",
         "broken_task/main.lua:4: in upvalue 'inner'"},
        {"broken_key", "broken_key/main.lua:4: pressed space", "in function 'daft.keypressed'"},
    };
    for (size_t i = 0; i < sizeof broken / sizeof broken[0]; i++) {
        int status = run_daft(output, "play tests/games/%s --headless --hash", broken[i].game);
        assert_status(status, 1, output);
        assert_says(output, broken[i].says);
        assert_says(output, broken[i].trace);
    }
    int status = run_daft(output, "play tests/games/broken_update --headless --hash");
    assert_status(status, 1, output);
    assert_null(strstr(output, "tick ")); /* a game that failed has no hash */
}

/* A run without a window draws its last picture, whatever else it is for. */
static void a_broken_draw_fails_without_a_window(void **unused)
{
    (void)unused;
    int status = run_daft(output, "play tests/games/broken_draw --headless --ticks 7");
    assert_status(status, 1, output);
    assert_says(output, "broken_draw/main.lua:3: daft.text");
}

static void errors_show_the_source_and_the_values(void **unused)
{
    (void)unused;
    int status = run_daft(output, "play tests/games/broken_values --headless");
    assert_status(status, 1, output);
    static const char *const wanted[] = {
        "broken_values/main.lua:9: attempt to perform arithmetic on a nil value (field 'speed')\n",
        "     8 |     crate.name = \"crate\"\n>    9 |     local y = player.speed * factor\n    10 |     return y\n",
        "\nstack traceback:\n\tbroken_values/main.lua:9: in upvalue 'inner'\n",
        "values in 'inner' (broken_values/main.lua:9):\n\tfactor = 2.5\n\tlist = {1, \"two\", {3}, deep = {a = {…}}, "
        "…}\n",
        "\ttext = \"line\\n\"\n", /* as it would be written */
        "\tcrate = entity ",
        " \"crate\"\n",
        "\tplayer = {hp = 3, name = \"Eve\"}\n"};
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) assert_says(output, wanted[i]);
    assert_null(strstr(output, "0x"));
    status = run_daft(output, "play tests/games/broken_task --headless");
    assert_status(status, 1, output);
    assert_says(output, ">    4 |     return nothing.field\n");
    assert_says(output, "values in 'inner' (broken_task/main.lua:4):\n\tnothing = nil\n");
}

typedef struct stage {
    home where;
    game_info info;
    daft_engine *engine;
    font *face;
    atomic_bool gives_up;
} stage;

static void set_up(stage *s, const char *game)
{
    char path[PATH_SIZE];
    daft_error error;
    *s = (stage){0};
    snprintf(path, sizeof path, "%s/tests/games/%s", DAFT_ROOT, game);
    assert_true(home_find(&s->where, &error));
    assert_true(home_find_game(&s->where, path, &s->info, &error));
    daft_engine_def def = daft_default_engine_def();
    assert_non_null(s->engine = daft_engine_create(&def, &error));
    assert_non_null(s->face = open_font(&s->where, &error));
}

static void tear_down(stage *s)
{
    font_close(s->face);
    daft_engine_destroy(s->engine);
}

/* Ten seconds are enough for a script to be stopped in. */
static int give_up(void *user) { return atomic_load(&((stage *)user)->gives_up) ? 10000 : 0; }

/* A script that never ends, and catches every error, is stopped when the user asks for it. */
static void an_endless_script_can_be_stopped(void **unused)
{
    (void)unused;
    stage s;
    set_up(&s, "endless");
    game_state play;
    game_def def = {.where = &s.where,
                    .info = &s.info,
                    .engine = s.engine,
                    .face = s.face,
                    .quality.preset = DAFT_PRESET_DRAFT,
                    .asked = give_up,
                    .user = &s};
    daft_error error;
    assert_true(game_open(&play, &def, &error));
    atomic_store(&s.gives_up, true);
    assert_false(game_tick(&play));
    assert_true(play.failed && play.scripts.asked);
    assert_says(play.scripts.failure.message, "daft.update was stopped");
    game_close(&play);
    tear_down(&s);
}

/* What is shown after an error can be reloaded any number of times. */
static void a_broken_game_reloads(void **unused)
{
    (void)unused;
    stage s;
    set_up(&s, "broken_update");
    game_state play;
    game_def def = {
        .where = &s.where, .info = &s.info, .engine = s.engine, .face = s.face, .quality.preset = DAFT_PRESET_DRAFT};
    daft_error error;
    assert_true(game_open(&play, &def, &error));
    daft_image *picture = daft_image_create(s.engine, 64, 36, &error);
    for (int round = 0; round < 3; round++) {
        for (int tick = 0; tick < 9; tick++) assert_true(game_tick(&play));
        assert_true(game_draw(&play, picture, 0.5f));
        assert_false(game_tick(&play));
        assert_false(game_tick(&play));
        assert_false(game_draw(&play, picture, 0.5f));
        assert_true(play.failed);
        assert_true(game_reload(&play, &error));
        assert_false(play.failed);
    }
    daft_image_destroy(picture);
    game_close(&play);
    tear_down(&s);
}

/* ---- determinism ---- */

static void hashes_do_not_depend_on_threads_or_instruction_set(void **unused)
{
    (void)unused;
    static const char *const ways[] = {"--threads 2", "--threads 5", "--isa " DAFT_NARROWEST_ISA};
    int status = run_daft(again, "play tests/games/bot --headless --hash --ticks 150 --threads 1");
    assert_status(status, 0, again);
    assert_says(again, "tick 150 state 0x");
    for (size_t i = 0; i < 3; i++) {
        status = run_daft(output, "play tests/games/bot --headless --hash --ticks 150 %s", ways[i]);
        assert_status(status, 0, output);
        assert_string_equal(output, again);
    }
    /* Drawing every frame, or none, does not change the game. */
    status = run_daft(output, "play tests/games/bot --headless --hash --ticks 150 --every-frame");
    assert_status(status, 0, output);
    assert_string_equal(output, again);
    /* Another seed is another game. */
    status = run_daft(output, "play tests/games/bot --headless --hash --ticks 150 --seed 2");
    assert_status(status, 0, output);
    assert_true(strcmp(output, again) != 0);
}

static void a_recording_plays_the_same_game(void **unused)
{
    (void)unused;
    char file[64];
    snprintf(file, sizeof file, "/tmp/daft-bot-%d.rec", (int)getpid());
    int status = run_daft(again, "play tests/games/bot --headless --hash --ticks 200 --seed 7 --record %s", file);
    assert_status(status, 0, again);
    /* The seed comes from the recording, and so does the end. */
    status = run_daft(output, "play tests/games/bot --headless --hash --replay %s", file);
    assert_status(status, 0, output);
    assert_string_equal(output, again);
    /* A recording of a replay is the recording. */
    status = run_daft(output, "play tests/games/bot --headless --replay %s --record %s.2", file, file);
    assert_status(status, 0, output);
    char command[256];
    snprintf(command, sizeof command, "cmp %s %s.2", file, file);
    assert_int_equal(system(command), 0);
    status = run_daft(output, "play tests/games/sample --headless --replay %s", file);
    assert_status(status, 1, output);
    assert_says(output, "a recording of the game 'bot', not of 'sample'");
    unlink(file);
    snprintf(command, sizeof command, "%s.2", file);
    unlink(command);
}

static void write_text(const char *path, const char *text)
{
    daft_error error;
    if (!daft_write_file(path, text, strlen(text), &error)) fail_msg("%s", error.message);
}

/* Two balls; in tick 91 of the changed game the second is pushed. Its folder keeps its name, which a recording holds.
 */
static void write_balls(const char *folder, const char *change)
{
    char path[96], text[600];
    snprintf(path, sizeof path, "%s/main.lua", folder);
    snprintf(
        text, sizeof text,
        "local balls, n = {}, 0\nfor i = 1, 2 do\n  balls[i] = daft.entity { sphere = 0.5, position = {3 * i, 50, 0}, "
        "body = \"dynamic\" }\nend\nfunction daft.update()\n  n = n + 1\n  %s\nend\n",
        change);
    write_text(path, text);
}

static void a_changed_game_is_told_and_where_it_parts(void **unused)
{
    (void)unused;
    char folder[] = "/tmp/daft-parts-XXXXXX", command[128];
    assert_non_null(mkdtemp(folder));
    write_balls(folder, "");
    assert_status(run_daft(output, "play %s --headless --ticks 200 --record %s/a.rec", folder, folder), 0, output);
    /* The recording lies in the game's folder and is no part of the game. */
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec --strict", folder, folder), 0, output);
    assert_string_equal(output, "");
    assert_status(
        run_daft(output, "play %s --headless --replay %s/a.rec --strict --memory-limit 900MB", folder, folder), 1,
        output);
    assert_says(output, "recorded with --memory-limit 1000000000, not 900000000");
    /* Other bytes, the same game. */
    write_balls(folder, "-- nothing");
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec", folder, folder), 0, output);
    assert_says(output, "recorded with another version of the game, SHA-256");
    assert_null(strstr(output, "parts in"));
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec --strict", folder, folder), 1, output);
    /* Another game. */
    write_balls(folder, "if n == 91 then balls[2]:push(1, 0, 0) end");
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec", folder, folder), 0, output);
    assert_says(output, "it parts in tick 91; after tick 120 entity 0x");
    assert_says(output, "differs in position, velocity");
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

/* A random number more is in no entity. Strict replays need states. */
static void strict_replays_compare_states(void **unused)
{
    (void)unused;
    char folder[] = "/tmp/daft-parts-XXXXXX", command[128], path[64];
    assert_non_null(mkdtemp(folder));
    write_balls(folder, "local r = math.random()");
    assert_status(run_daft(output, "play %s --headless --ticks 130 --record %s/a.rec", folder, folder), 0, output);
    snprintf(command, sizeof command, "sed -i '/^content/d' %s/a.rec", folder);
    assert_int_equal(system(command), 0);
    write_balls(folder, "local r = math.random(); if n == 125 then math.random() end");
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec --strict", folder, folder), 1, output);
    assert_says(output, "it parts in tick 125");
    snprintf(path, sizeof path, "%s/b.rec", folder);
    write_text(path, "daft-recording 4\nend 9\n");
    assert_status(run_daft(output, "play %s --headless --replay %s", folder, path), 0, output);
    assert_status(run_daft(output, "play %s --headless --replay %s --strict", folder, path), 1, output);
    assert_says(output, "it holds no states to compare with");
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

/* What a game requires of scripts/ is known by its hash, what is in its own folder by the game's. */
static void changed_scripts_are_told(void **unused)
{
    (void)unused;
    char folder[] = "/tmp/daft-parts-XXXXXX", command[256], path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/mine.lua", folder);
    write_text(path, "return {}\n");
    write_balls(
        folder,
        "if n == 20 then require 'tween' require 'mine' require 'tween' end if n == 40 then daft.restart() end");
    assert_status(run_daft(output, "play %s --headless --ticks 100 --record %s/a.rec", folder, folder), 0, output);
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec --strict", folder, folder), 0, output);
    snprintf(command, sizeof command,
             "test \"$(grep ^script %s/a.rec)\" = \"script tween $(sha256sum < '%s/scripts/tween.lua' | head -c 64)\"",
             folder, DAFT_ROOT);
    assert_int_equal(system(command), 0);
    snprintf(command, sizeof command, "sed -i 's/^script tween ....../script tween 123abc/' %s/a.rec", folder);
    assert_int_equal(system(command), 0);
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec", folder, folder), 0, output);
    assert_says(output, "it was recorded with another version of scripts/tween.lua: it may play differently");
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec --strict", folder, folder), 1, output);
    assert_says(output, "it was recorded with another version of scripts/tween.lua");
    snprintf(command, sizeof command, "sed -i 's/^script tween .*/script tween 12/' %s/a.rec", folder);
    assert_int_equal(system(command), 0);
    assert_status(run_daft(output, "play %s --headless --replay %s/a.rec", folder, folder), 1, output);
    assert_says(output, "a SHA-256 expected");
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

static void replays_go_at_any_speed(void **unused)
{
    (void)unused;
    char file[64];
    snprintf(file, sizeof file, "/tmp/daft-speed-%d.rec", (int)getpid());
    assert_status(run_daft(again, "play tests/games/bot --headless --hash --ticks 60 --record %s", file), 0, again);
    const uint64_t began = clock_now_ns();
    assert_status(run_daft(output, "play tests/games/bot --headless --hash --replay %s --speed 2", file), 0, output);
    assert_true(clock_now_ns() - began > 400000000u); /* half a second of the game's second, less what rounds */
    assert_string_equal(output, again);
    assert_status(run_daft(output, "play tests/games/bot --headless --hash --replay %s --speed max", file), 0, output);
    assert_string_equal(output, again);
    assert_status(run_daft(output, "play tests/games/bot --headless --replay %s --speed 0", file), 2, output);
    assert_status(run_daft(output, "play tests/games/bot --headless --speed 2"), 2, output);
    assert_says(output, "--replay FILE is missing");
    unlink(file);
}

/* ---- no display ---- */

static void without_a_display_the_demo_plays_and_leaves_a_picture(void **unused)
{
    (void)unused;
    char folder[] = "/tmp/daft-demo-XXXXXX", command[1024], picture[64];
    assert_non_null(mkdtemp(folder));
    snprintf(command, sizeof command,
             "cd %s && env -u DISPLAY -u WAYLAND_DISPLAY -u SDL_VIDEODRIVER '%s' play '%s/tests/games/sample' 2>&1",
             folder, DAFT_PROGRAM, DAFT_ROOT);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    output[fread(output, 1, OUTPUT_SIZE - 1, pipe)] = 0;
    int status = pclose(pipe);
    assert_status(status, 0, output);
    assert_says(output, "there is no display");
    assert_says(output, "wrote daft-demo.png");
    snprintf(picture, sizeof picture, "%s/daft-demo.png", folder);
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_image *image = daft_image_load(engine, picture, NULL);
    assert_non_null(image);
    assert_int_equal(daft_image_width(image), 1280);
    assert_int_equal(daft_image_height(image), 720);
    daft_image_destroy(image);
    daft_engine_destroy(engine);
    unlink(picture);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_api_does_what_it_says),
                                       cmocka_unit_test(bodies_do_what_the_manual_says),
                                       cmocka_unit_test(the_sandbox_holds),
                                       cmocka_unit_test(the_world_does_what_it_says),
                                       cmocka_unit_test(time_goes_slowly_and_stands_still),
                                       cmocka_unit_test(the_library_works),
                                       cmocka_unit_test(actions_are_keys_and_sticks),
                                       cmocka_unit_test(menus_go_by_keys),
                                       cmocka_unit_test(tasks_wait_for_their_ticks),
                                       cmocka_unit_test(nonsense_never_crashes),
                                       cmocka_unit_test(the_games_of_the_design_and_of_the_house_play),
                                       cmocka_unit_test(restarting_starts_afresh),
                                       cmocka_unit_test(script_errors_are_status_1_with_place_and_trace),
                                       cmocka_unit_test(a_broken_draw_fails_without_a_window),
                                       cmocka_unit_test(errors_show_the_source_and_the_values),
                                       cmocka_unit_test(an_endless_script_can_be_stopped),
                                       cmocka_unit_test(a_broken_game_reloads),
                                       cmocka_unit_test(hashes_do_not_depend_on_threads_or_instruction_set),
                                       cmocka_unit_test(a_recording_plays_the_same_game),
                                       cmocka_unit_test(a_changed_game_is_told_and_where_it_parts),
                                       cmocka_unit_test(strict_replays_compare_states),
                                       cmocka_unit_test(changed_scripts_are_told),
                                       cmocka_unit_test(replays_go_at_any_speed),
                                       cmocka_unit_test(without_a_display_the_demo_plays_and_leaves_a_picture)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
