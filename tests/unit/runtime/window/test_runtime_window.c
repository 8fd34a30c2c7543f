/* runtime: a session and the menu of games at a window: keys of the program, pictures, errors, recordings, replays. */
#include "session/costs.h"
#include "session/menu.h"
#include "runtime_program.h"
#include "scripted_session.h"

/* ---- tests ---- */

static void escape_leaves_and_the_window_closes(void **unused)
{
    (void)unused;
    const happening leave[] = {{5, "+escape", 0, 0}};
    PLAY(leave);
    assert_int_equal(play("sample"), SESSION_LEFT);
    assert_true(s.screen.hidden);
    assert_in_range(s.screen.presented, 5, 7);
    assert_string_equal(s.screen.title, "Sample - DAFT");
    tear_down();
    const happening close[] = {{5, "close", 0, 0}};
    PLAY(close);
    assert_int_equal(play("sample"), SESSION_CLOSED);
    tear_down();
}

/* Two equal pictures but for what F3 draws: pressed twice it is gone. */
static void f3_draws_the_shapes_of_bodies(void **unused)
{
    (void)unused;
    static const happening none[] = {{20, "close", 0, 0}}, once[] = {{5, "+f3", 0, 0}, {20, "close", 0, 0}},
                           twice[] = {{5, "+f3", 0, 0}, {8, "+f3", 0, 0}, {20, "close", 0, 0}};
    uint64_t hashes[3];
    const struct {
        const happening *script;
        size_t count;
    } runs[] = {{none, 1}, {once, 2}, {twice, 3}};
    for (int i = 0; i < 3; i++) {
        set_up(runs[i].script, runs[i].count);
        assert_int_equal(play("physics"), SESSION_CLOSED);
        hashes[i] = s.screen.hash;
        tear_down();
    }
    assert_true(hashes[0] != hashes[1] && hashes[0] == hashes[2]);
}

/* The panel of prices covers part of the picture while it is open, and the game goes on as without it. */
static void f2_shows_what_settings_cost(void **unused)
{
    (void)unused;
    static const happening none[] = {{60, "close", 0, 0}}, once[] = {{5, "+f2", 0, 0}, {60, "close", 0, 0}},
                           twice[] = {{5, "+f2", 0, 0}, {50, "+f2", 0, 0}, {60, "close", 0, 0}};
    uint64_t hashes[3];
    const struct {
        const happening *script;
        size_t count;
    } runs[] = {{none, 1}, {once, 2}, {twice, 3}};
    for (int i = 0; i < 3; i++) {
        set_up(runs[i].script, runs[i].count);
        assert_int_equal(play("physics"), SESSION_CLOSED);
        hashes[i] = s.screen.hash;
        tear_down();
    }
    assert_true(hashes[0] != hashes[1] && hashes[0] == hashes[2]);
}

/* What a game wishes is granted once, and again only where it wishes something else. */
static void the_window_is_as_the_game_wishes(void **unused)
{
    (void)unused;
    char icon[96];
    daft_error error;
    begin_changing("");
    snprintf(icon, sizeof icon, "%s/changing/icon.png", folder);
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    daft_image *image = daft_image_create(engine, 24, 16, &error);
    assert_true(daft_image_write(image, icon, &error));
    daft_image_destroy(image), daft_engine_destroy(engine);
    write_game("function daft.load() daft.window { title = 'Tower', width = 640, height = 360, icon = 'icon.png' } end "
               "function daft.update() if daft.tick() == 20 then daft.window { full_screen = true } end end\n");
    const happening script[] = {{40, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    assert_string_equal(s.screen.title, "Tower");
    assert_true(s.screen.wished_width == 640 && s.screen.wished_height == 360 && s.screen.icon_width == 24);
    assert_int_equal(s.screen.full, 1);
    drop_folder();
}

static void the_picture_follows_the_window(void **unused)
{
    (void)unused;
    const happening script[] = {{3, "size", 321, 123}, {6, "+escape", 0, 0}};
    PLAY(script);
    play("sample");
    assert_int_equal(s.screen.picture_width, 321);
    assert_int_equal(s.screen.picture_height, 123);
    tear_down();
    const happening huge[] = {{0, "size", 7680, 2160}, {2, "+escape", 0, 0}};
    PLAY(huge);
    play("sample");
    assert_int_equal(s.screen.picture_width, 1920);
    assert_int_equal(s.screen.picture_height, 540);
    tear_down();
    const happening half[] = {{2, "+escape", 0, 0}};
    PLAY(half);
    s.def.scale = 0.5;
    play("sample");
    assert_int_equal(s.screen.picture_width, 80);
    tear_down();
    /* Where frames must be cheap the scene gets fewer pixels, but not what is drawn over it. */
    const happening late[] = {{0, "size", 640, 360}, {60, "+escape", 0, 0}};
    PLAY(late);
    s.def.target_ms = 0.001;
    play("sample");
    assert_int_equal(s.screen.picture_width, 640);
    assert_int_equal(s.screen.picture_height, 360);
    tear_down();
}

/* A broken game shows its error and stays; R reloads it; Esc leaves as ever. */
static void a_script_error_is_shown_and_r_reloads(void **unused)
{
    (void)unused;
    const happening script[] = {{40, "+r", 0, 0}, {41, "-r", 0, 0}, {48, "+f1", 0, 0}, {80, "+escape", 0, 0}};
    PLAY(script);
    assert_int_equal(play("broken_update"), SESSION_LEFT);
    assert_true(s.screen.presented >= 80);
    assert_true(s.screen.corner[0] > 150 && s.screen.corner[0] > s.screen.corner[2] + 50); /* the error screen's red
                                                                                              edge */
    tear_down();
}

static bool file_says(const char *path, const char *wanted)
{
    char line[300] = "";
    FILE *file = fopen(path, "r");
    if (!file) return false;
    if (!fgets(line, sizeof line, file)) line[0] = 0;
    fclose(file);
    return strcmp(line, wanted) == 0;
}

/* A script in place of the editor writes what it is given. */
static editor *open_editor(const char *name, char out[120])
{
    char path[120], text[300], folder_of_games[PATH_SIZE];
    daft_error error;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    snprintf(out, 120, "%s/opened-%s", folder, name);
    const int size = snprintf(text, sizeof text, "#!/bin/sh\necho \"$@\" >%s.part\nmv %s.part %s\n", out, out, out);
    assert_true(daft_write_file(path, text, (size_t)size, &error));
    assert_int_equal(chmod(path, 0700), 0);
    snprintf(folder_of_games, sizeof folder_of_games, "%s/tests/games", DAFT_ROOT);
    setenv("VISUAL", path, 1);
    editor *opened = editor_start(folder_of_games);
    unsetenv("VISUAL");
    assert_non_null(opened);
    return opened;
}

/* C and E of the error screen. */
static void an_error_is_copied_and_opened_in_the_editor(void **unused)
{
    (void)unused;
    char opened[120], wanted[300];
    make_folder();
    const happening script[] = {{40, "+c", 0, 0}, {45, "+e", 0, 0}, {60, "+escape", 0, 0}};
    static const struct {
        const char *name, *form;
    } editors[] = {{"vi", "+5 %s/tests/games/broken_update/main.lua\n"},
                   {"code", "-g %s/tests/games/broken_update/main.lua:5\n"},
                   {"subl", "%s/tests/games/broken_update/main.lua:5\n"}};
    for (size_t i = 0; i < sizeof editors / sizeof editors[0]; i++) {
        PLAY(script);
        s.def.editor = open_editor(editors[i].name, opened);
        assert_int_equal(play("broken_update"), SESSION_LEFT);
        assert_non_null(strstr(s.screen.copied, "broken_update/main.lua:5: attempt to index a nil value"));
        assert_non_null(strstr(s.screen.copied, ">    5 |         return nothing.field\n"));
        assert_non_null(strstr(s.screen.copied, "stack traceback:\n"));
        snprintf(wanted, sizeof wanted, editors[i].form, DAFT_ROOT);
        for (int wait = 0; wait < 500 && access(opened, F_OK) != 0; wait++) usleep(10000);
        assert_true(file_says(opened, wanted));
        tear_down();
        unlink(opened);
        /* Nothing outside the folder, and no line that is none. */
        assert_true(editor_open(s.def.editor, "/etc/passwd", 1));
        snprintf(wanted, sizeof wanted, "%s/tests/games/../../README.md", DAFT_ROOT);
        assert_true(editor_open(s.def.editor, wanted, 1));
        assert_true(editor_open(s.def.editor, "tests/games/sample/main.lua", 0));
        editor_close(s.def.editor); /* which waits for it */
        assert_int_not_equal(access(opened, F_OK), 0);
    }
    drop_folder();
    unsetenv("EDITOR");
    assert_null(editor_start("/tmp"));
}

/* Pictures of a game follow each other: what the one before sampled counts in the next, in quality game. */
static void pictures_of_soft_light_get_better(void **unused)
{
    (void)unused;
    const happening script[] = {{12, "+escape", 0, 0}};
    PLAY(script);
    s.def.quality.preset = DAFT_PRESET_GAME;
    assert_int_equal(play("soft"), SESSION_LEFT);
    assert_true(s.screen.changed >= 8);
    tear_down();
    PLAY(script);
    assert_int_equal(play("soft"), SESSION_LEFT);
    assert_int_equal(s.screen.changed, 0);
    tear_down();
}

static void what_is_pressed_is_recorded_and_focus_loss_releases_it(void **unused)
{
    (void)unused;
    char path[64];
    snprintf(path, sizeof path, "/tmp/daft-window-%d.rec", (int)getpid());
    const happening script[] = {
        {5, "+left", 0, 0}, {10, "focus", 0, 0}, {20, "click", 0.5f, 0.25f}, {30, "+escape", 0, 0}};
    PLAY(script);
    s.def.record = path;
    play("sample");
    tear_down();
    static const struct {
        const char *text;
        int count;
    } wanted[] = {{"+left", 1}, {"-left", 1}, {" mouse 640 180", 1}, {"+mouse1", 1}, {"game sample", 1}, {"end ", 1}};
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) {
        int count;
        count_lines(path, wanted[i].text, &count);
        if (count != wanted[i].count) fail_msg("%d lines with '%s'", count, wanted[i].text);
    }
    unlink(path);
}

/* While a recording plays the keyboard is not heard; when it ends, it is the player's turn. */
static void a_replay_hands_control_back(void **unused)
{
    (void)unused;
    char path[64], second[72];
    snprintf(path, sizeof path, "/tmp/daft-window-%d.rec", (int)getpid());
    snprintf(second, sizeof second, "%s.2", path);
    FILE *file = fopen(path, "w");
    fputs("daft-recording 1\ngame sample\n2 +up\nend 20\n", file);
    fclose(file);
    const happening script[] = {{5, "+left", 0, 0}, {6, "-left", 0, 0}, {40, "+right", 0, 0}, {60, "+escape", 0, 0}};
    PLAY(script);
    s.def.replay = path;
    s.def.record = second;
    assert_int_equal(play("sample"), SESSION_LEFT);
    tear_down();
    static const char *const wanted[] = {"2 +up", "20 -up", "+right"};
    int count;
    for (size_t i = 0; i < 3; i++) {
        count_lines(second, wanted[i], &count);
        assert_int_equal(count, 1);
    }
    count_lines(second, "left", &count);
    assert_int_equal(count, 0);
    unlink(path);
    unlink(second);
}

static game_info games[12];

static menu_end choose(size_t count, size_t *chosen)
{
    daft_error error = {0};
    for (size_t i = 0; i < count; i++) {
        snprintf(games[i].name, sizeof games[i].name, "game%zu", i);
        snprintf(games[i].title, sizeof games[i].title, "Game number %zu", i);
        snprintf(games[i].description, sizeof games[i].description, "%0500d", 7); /* one long word */
    }
    menu_end end = menu_show(&s.def, games, count, chosen, &error);
    if (end == MENU_FAILED) fail_msg("%s", error.message);
    return end;
}

static void the_menu_goes_by_keys(void **unused)
{
    (void)unused;
    const happening script[] = {{1, "+down", 0, 0}, {2, "+down", 0, 0}, {3, "+up", 0, 0}, {4, "+return", 0, 0}};
    size_t chosen = 0;
    PLAY(script);
    assert_int_equal(choose(12, &chosen), MENU_CHOSEN);
    assert_int_equal(chosen, 1);
    tear_down();
    const happening up[] = {{1, "+up", 0, 0}, {3, "+space", 0, 0}}; /* round to the last, which scrolls */
    chosen = 0;
    PLAY(up);
    assert_int_equal(choose(12, &chosen), MENU_CHOSEN);
    assert_int_equal(chosen, 11);
    tear_down();
    const happening leave[] = {{2, "+escape", 0, 0}};
    PLAY(leave);
    assert_int_equal(choose(3, &chosen), MENU_LEFT);
    tear_down();
}

static void the_menu_goes_by_mouse(void **unused)
{
    (void)unused;
    /* The third row is at 384 to 480 of 720 units, and at 64 to 624 of 1280. */
    const happening script[] = {{1, "click", 0.9f, 0.6f}, {3, "click", 0.2f, 0.6f}};
    size_t chosen = 0;
    PLAY(script);
    assert_int_equal(choose(4, &chosen), MENU_CHOSEN);
    assert_int_equal(chosen, 2);
    tear_down();
}

static void a_menu_without_games_can_be_left(void **unused)
{
    (void)unused;
    const happening script[] = {{1, "+down", 0, 0}, {2, "+return", 0, 0}, {3, "click", 0.2f, 0.5f}, {5, "close", 0, 0}};
    size_t chosen = 0;
    PLAY(script);
    assert_int_equal(choose(0, &chosen), MENU_LEFT);
    tear_down();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(escape_leaves_and_the_window_closes),
                                       cmocka_unit_test(f3_draws_the_shapes_of_bodies),
                                       cmocka_unit_test(f2_shows_what_settings_cost),
                                       cmocka_unit_test(the_window_is_as_the_game_wishes),
                                       cmocka_unit_test(the_picture_follows_the_window),
                                       cmocka_unit_test(a_script_error_is_shown_and_r_reloads),
                                       cmocka_unit_test(an_error_is_copied_and_opened_in_the_editor),
                                       cmocka_unit_test(pictures_of_soft_light_get_better),
                                       cmocka_unit_test(what_is_pressed_is_recorded_and_focus_loss_releases_it),
                                       cmocka_unit_test(a_replay_hands_control_back),
                                       cmocka_unit_test(the_menu_goes_by_keys),
                                       cmocka_unit_test(the_menu_goes_by_mouse),
                                       cmocka_unit_test(a_menu_without_games_can_be_left)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
