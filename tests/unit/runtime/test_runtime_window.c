/* runtime: a session and the menu on a platform made for tests: keys and clicks come from a list, a frame is 1/60 s. */
#include "cli/commands.h"
#include "common/util.h"
#include "game/loop.h"
#include "session/costs.h"
#include "session/menu.h"
#include "session/session.h"
#include "runtime_program.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <sys/stat.h>
#include <unistd.h>

/* ---- the platform: what happens in which frame ---- */

typedef struct happening {
    uint64_t frame;
    const char *key; /* "+left", "-left", "~left x" to x, "focus", "close", "click" at x, y, "size" x by y, "text " and
                        a letter, or "write " and a script */
    float x, y;
} happening;

typedef struct script_platform {
    platform face;
    const happening *script;
    size_t count, next;
    uint64_t frame, presented, changed, hash;
    int width, height;
    bool hidden;
    bool click; /* the press that follows the move of a click */
    int picture_width, picture_height;
    uint8_t corner[4]; /* of the last picture */
    char title[200];
    int wished_width, wished_height, full, icon_width; /* as the game asked; full: -1 until it does */
    char copied[FAILURE_TEXT];                         /* to the clipboard */
    bool real;                                         /* time passes, and files are saved in it */
    int saved;                                         /* of SAVED: the file that is to be seen */
    uint64_t saved_frame, saved_ns, upper;             /* when; the upper half of the last picture */
} script_platform;

static char folder[64], recorded[96]; /* of games that tests write */

/* The game in folder/changing. A file system's times may be coarse: each has another size. */
static void write_game(const char *text)
{
    static int times;
    char path[96], padded[2048];
    daft_error error;
    snprintf(path, sizeof path, "%s/changing/main.lua", folder);
    const int size = snprintf(padded, sizeof padded, "%s\n--%*s\n", text, 1 + times++ % 50, "");
    if (!daft_write_file(path, padded, (size_t)size, &error)) fail_msg("%s", error.message);
}

/* What a game is made of, and how it is after it was saved anew. */
enum { SAVED_FILES = 5 };
static const char *const SAVED[SAVED_FILES] = {"main.lua", "level.scene", "shape.obj", "paint.png", "tone.wav"};
static double saved_ms[SAVED_FILES];
static uint64_t saved_frames[SAVED_FILES];

static void save_file(const char *name, bool anew);

/* One file after another, half a second after the last one was seen. */
static void save_and_wait(script_platform *p, uint64_t upper)
{
    const uint64_t now = clock_now_ns();
    if (p->saved_ns && upper != p->upper) {
        saved_ms[p->saved] = (double)(now - p->saved_ns) / 1e6, saved_frames[p->saved] = p->frame - p->saved_frame;
        p->saved++, p->saved_ns = 0, p->saved_frame = p->frame;
    } else if (!p->saved_ns && p->saved < SAVED_FILES && p->frame > p->saved_frame + 30) {
        save_file(SAVED[p->saved], true);
        p->saved_ns = clock_now_ns(), p->saved_frame = p->frame;
    }
    p->upper = upper;
}

static void close_script(platform *self) { (void)self; }

static bool poll_script(platform *self, platform_event *out)
{
    script_platform *p = (script_platform *)self;
    *out = (platform_event){.kind = PLATFORM_INPUT};
    if (p->click) {
        p->click = false;
        out->input = (input_event){.kind = INPUT_KEY, .key = input_key_find("mouse1"), .down = true};
        return true;
    }
    out->kind = p->real && p->saved == SAVED_FILES ? PLATFORM_CLOSE : PLATFORM_INPUT;
    if (out->kind == PLATFORM_CLOSE) return p->saved++, true;
    if (p->next == p->count || p->script[p->next].frame > p->frame) return false;
    const happening *now = &p->script[p->next++];
    if (strncmp(now->key, "write ", 6) == 0) {
        write_game(now->key + 6);
        return poll_script(self, out);
    }
    if (strcmp(now->key, "close") == 0) {
        out->kind = PLATFORM_CLOSE;
    } else if (strcmp(now->key, "focus") == 0) {
        out->kind = PLATFORM_FOCUS_LOST;
    } else if (strcmp(now->key, "click") == 0) {
        out->input = (input_event){.kind = INPUT_MOVE, .x = now->x, .y = now->y};
        p->click = true;
    } else if (strncmp(now->key, "text ", 5) == 0) {
        const char *letter = now->key + 5;
        out->input = (input_event){.kind = INPUT_TEXT, .key = (int)utf8_next(&letter)};
    } else if (now->key[0] == '~') {
        out->input = (input_event){.kind = INPUT_STICK, .key = input_stick_find(now->key + 1), .x = now->x};
        assert_true(out->input.key >= 0);
    } else if (strcmp(now->key, "size") == 0) {
        p->width = (int)now->x, p->height = (int)now->y;
        return poll_script(self, out);
    } else {
        int key = input_key_find(now->key + 1);
        assert_true(key >= 0);
        out->input = (input_event){.kind = INPUT_KEY, .key = key, .down = now->key[0] == '+'};
    }
    return true;
}

static void size_script(platform *self, int *width, int *height)
{
    *width = ((script_platform *)self)->width, *height = ((script_platform *)self)->height;
}

static bool wants_frame_script(platform *self)
{
    (void)self;
    return true;
}

static bool present_script(platform *self, const daft_image *picture, daft_error *error)
{
    (void)error;
    script_platform *p = (script_platform *)self;
    const size_t bytes = 4 * (size_t)daft_image_width(picture) * (size_t)daft_image_height(picture);
    const uint64_t hash = daft_hash(daft_image_pixels((daft_image *)(uintptr_t)picture), bytes, 0);
    p->changed += p->presented > 0 && hash != p->hash;
    p->hash = hash, p->presented++;
    if (p->real) save_and_wait(p, daft_hash(daft_image_pixels((daft_image *)(uintptr_t)picture), bytes / 2, 0));
    p->picture_width = daft_image_width(picture), p->picture_height = daft_image_height(picture);
    memcpy(p->corner, daft_image_pixels((daft_image *)(uintptr_t)picture), 4);
    return true;
}

static void end_frame_script(platform *self)
{
    /* A script without an end is a bug of the test. */
    assert_true(((script_platform *)self)->frame++ < 2000);
    if (((script_platform *)self)->real) usleep(1000000 / LOOP_RATE);
}

static uint64_t now_script(platform *self)
{
    if (((script_platform *)self)->real) return clock_now_ns();
    return (((script_platform *)self)->frame * 1000000000u + LOOP_RATE - 1) / LOOP_RATE;
}

static void set_title_script(platform *self, const char *title)
{
    snprintf(((script_platform *)self)->title, sizeof((script_platform *)self)->title, "%s", title);
}

static void set_size_script(platform *self, int width, int height)
{
    script_platform *p = (script_platform *)self;
    p->wished_width = width, p->wished_height = height;
}

/* A French keyboard, as far as it matters. */
static bool key_label_script(platform *self, const char *key, char *out, size_t size)
{
    static const char *const PAIRS[] = {"aQ", "qA", "wZ", "zW", ";M", "m,"};
    (void)self;
    for (size_t i = 0; i < COUNT_OF(PAIRS); i++)
        if (key[0] == PAIRS[i][0] && !key[1]) return snprintf(out, size, "%s", PAIRS[i] + 1) > 0;
    return false;
}

static bool full_screen_script(platform *self, int wish)
{
    script_platform *p = (script_platform *)self;
    if (wish >= 0) p->full = wish;
    return p->full == 1;
}

static void set_icon_script(platform *self, daft_image *icon)
{
    ((script_platform *)self)->icon_width = daft_image_width(icon);
}

static void grab_script(platform *self, bool grab) { (void)self, (void)grab; }
static bool copy_script(platform *self, const char *text)
{
    snprintf(((script_platform *)self)->copied, FAILURE_TEXT, "%s", text);
    return true;
}
static void hide_script(platform *self) { ((script_platform *)self)->hidden = true; }

/* ---- the stage ---- */

typedef struct stage {
    home where;
    daft_engine *engine;
    font *face;
    script_platform screen;
    session_def def;
} stage;

static stage s;

static void set_up(const happening *script, size_t count)
{
    daft_error error;
    memset(&s, 0, sizeof s);
    assert_true(home_find(&s.where, &error));
    assert_non_null(s.face = open_font(&s.where, &error));
    daft_engine_def engine = daft_default_engine_def();
    assert_non_null(s.engine = daft_engine_create(&engine, &error));
    s.screen = (script_platform){.face = {.close = close_script,
                                          .poll = poll_script,
                                          .get_size = size_script,
                                          .wants_frame = wants_frame_script,
                                          .present = present_script,
                                          .end_frame = end_frame_script,
                                          .now_ns = now_script,
                                          .set_title = set_title_script,
                                          .set_size = set_size_script,
                                          .full_screen = full_screen_script,
                                          .set_icon = set_icon_script,
                                          .key_label = key_label_script,
                                          .copy = copy_script,
                                          .grab_mouse = grab_script,
                                          .hide = hide_script},
                                 .script = script,
                                 .count = count,
                                 .width = 160,
                                 .height = 90};
    s.def = (session_def){.screen = &s.screen.face,
                          .engine = s.engine,
                          .where = &s.where,
                          .face = s.face,
                          .quality.preset = DAFT_PRESET_DRAFT,
                          .scale = 1,
                          .seed = 1};
}

static void tear_down(void)
{
    font_close(s.face);
    daft_engine_destroy(s.engine);
}

static session_end play(const char *game)
{
    char path[PATH_SIZE];
    game_info info;
    daft_error error = {0};
    snprintf(path, sizeof path, "%s/tests/games/%s", DAFT_ROOT, game);
    assert_true(home_find_game(&s.where, path, &info, &error));
    session_end end = session_play(&s.def, &info, &error);
    if (end == SESSION_FAILED) fail_msg("%s", error.message);
    return end;
}

#define PLAY(script) set_up(script, sizeof script / sizeof script[0])

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

static void count_lines(const char *path, const char *wanted, int *count)
{
    char line[128];
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    for (*count = 0; fgets(line, sizeof line, file);)
        if (strstr(line, wanted)) ++*count;
    fclose(file);
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

/* ---- the pause menu ---- */

static void make_folder(void)
{
    snprintf(folder, sizeof folder, "/tmp/daft-pause-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(recorded, sizeof recorded, "%s/a.rec", folder);
}

static void drop_folder(void)
{
    char command[96];
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

static session_end play_and_pause(void)
{
    s.def.pauses = true, s.def.record = recorded, s.def.settings = folder;
    session_end end = play("sample");
    tear_down();
    return end;
}

static int ticks_recorded(void)
{
    char line[128];
    int end = -1;
    FILE *file = fopen(recorded, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) sscanf(line, "end %d", &end);
    fclose(file);
    return end;
}

static void escape_pauses_and_the_game_stands_still(void **unused)
{
    (void)unused;
    int count;
    make_folder();
    /* Held when the menu opens: let go. In the menu the game hears nothing. */
    const happening script[] = {{5, "+left", 0, 0},   {10, "+escape", 0, 0}, {11, "-escape", 0, 0},
                                {40, "+right", 0, 0}, {60, "+escape", 0, 0}, {70, "+escape", 0, 0},
                                {80, "+up", 0, 0},    {81, "+return", 0, 0}};
    PLAY(script);
    assert_int_equal(play_and_pause(), SESSION_LEFT);
    assert_in_range(ticks_recorded(), 18, 22);
    assert_true(s.screen.hidden);
    count_lines(recorded, "-left", &count);
    assert_int_equal(count, 1);
    count_lines(recorded, "right", &count);
    assert_int_equal(count, 0);
    count_lines(recorded, "escape", &count);
    assert_int_equal(count, 0);
    const happening close[] = {{5, "+pad start", 0, 0}, {20, "close", 0, 0}};
    PLAY(close);
    assert_int_equal(play_and_pause(), SESSION_CLOSED);
    drop_folder();
}

static void the_pause_menu_shows_itself_and_goes_by_mouse(void **unused)
{
    (void)unused;
    make_folder();
    /* Nothing changes but by the menu: opened, the last row chosen by the mouse, and left by a click on it. */
    const happening script[] = {{5, "+escape", 0, 0}, {30, "click", 0.5f, 0.761f}};
    PLAY(script);
    assert_int_equal(play_and_pause(), SESSION_LEFT);
    const uint64_t with = s.screen.changed;
    assert_true(with >= 1);
    const happening miss[] = {{5, "+escape", 0, 0},
                              {30, "click", 0.1f, 0.761f},
                              {40, "click", 0.5f, 0.3f},
                              {60, "close", 0, 0}}; /* beside the rows; then "Continue" */
    PLAY(miss);
    assert_int_equal(play_and_pause(), SESSION_CLOSED);
    assert_in_range(ticks_recorded(), 20, 28);
    drop_folder();
}

/* In a few seconds of play, or behind the menu, all rungs of the governor are measured; the figures are kept. */
static void the_rungs_are_surveyed(void **unused)
{
    (void)unused;
    const happening plays[] = {{900, "close", 0, 0}}, pauses[] = {{5, "+escape", 0, 0}, {120, "close", 0, 0}};
    for (int i = 0; i < 2; i++) {
        make_folder();
        if (i)
            PLAY(pauses);
        else
            PLAY(plays);
        s.def.pauses = true, s.def.settings = folder, s.def.costs = folder, s.def.target_ms = 400;
        governor_costs known;
        assert_false(costs_load(folder, "physics", &known));
        assert_int_equal(play("physics"), SESSION_CLOSED);
        tear_down();
        assert_true(costs_load(folder, "physics", &known));
        for (int k = 0; k < GOVERNOR_RUNGS; k++) assert_true(known.cost[k] > 0 && known.error[k] >= 0);
        /* Half of the pixels, without smooth edges, are farther from the reference than all of them. */
        assert_true(known.error[0] > known.error[governor_full()]);
        drop_folder();
    }
}

static void settings_last(void **unused)
{
    (void)unused;
    char path[96];
    int count;
    make_folder();
    snprintf(path, sizeof path, "%s/DAFT.settings.save", folder);
    const happening script[] = {{2, "+escape", 0, 0}, {3, "+down", 0, 0},   {3, "+left", 0, 0},  {3, "+left", 0, 0},
                                {4, "+down", 0, 0},   {5, "+right", 0, 0},  {6, "+right", 0, 0}, {7, "+down", 0, 0},
                                {8, "+left", 0, 0},   {9, "+escape", 0, 0}, {12, "close", 0, 0}};
    PLAY(script);
    play_and_pause();
    count_lines(path, "pace 2 volume 7 full_screen 0 picture 3", &count);
    assert_int_equal(count, 1);
    const happening again[] = {
        {2, "+escape", 0, 0}, {3, "+down", 0, 0}, {4, "+down", 0, 0}, {5, "+left", 0, 0}, {12, "close", 0, 0}};
    PLAY(again);
    play_and_pause();
    count_lines(path, "pace 1 volume 7 full_screen 0 picture 3", &count);
    assert_int_equal(count, 1);
    /* A file of before pictures had a row. */
    static const char old[] = "daft-save 1\npace 2 volume 6 full_screen 0\n";
    daft_error error;
    assert_true(daft_write_file(path, old, sizeof old - 1, &error));
    PLAY(again);
    play_and_pause();
    count_lines(path, "pace 1 volume 6 full_screen 0 picture 0", &count);
    assert_int_equal(count, 1);
    /* What cannot be read is as if it had not been there. */
    static const char wrong[] = "daft-save 1\npace 99 volume 7 full_screen 0\n";
    assert_true(daft_write_file(path, wrong, sizeof wrong - 1, &error));
    PLAY(again);
    play_and_pause();
    count_lines(path, "pace 4 volume 8 full_screen 0 picture 0", &count);
    assert_int_equal(count, 1);
    drop_folder();
}

/* The player's quality is what pictures have, from the next one on; where the program was started with one, from the
 * player's first change on. */
static void the_player_chooses_the_picture(void **unused)
{
    (void)unused;
    uint64_t seen[3];
    make_folder();
    for (int i = 0; i < 3; i++) {
        const happening high[] = {{2, "+escape", 0, 0}, {3, "+down", 0, 0},   {3, "+right", 0, 0}, {4, "+right", 0, 0},
                                  {5, "+right", 0, 0},  {6, "+escape", 0, 0}, {20, "close", 0, 0}};
        const happening none[] = {{2, "+escape", 0, 0}, {6, "+escape", 0, 0}, {20, "close", 0, 0}};
        if (i == 0)
            PLAY(none);
        else if (i == 1)
            PLAY(high);
        else
            PLAY(none); /* it lasts */
        s.def.quality.preset = QUALITY_OF_SCENE, s.def.target_ms = 0;
        play_and_pause();
        seen[i] = s.screen.hash;
    }
    assert_true(seen[1] != seen[0] && seen[2] == seen[1]);
    drop_folder();
}

/* The game binds "jump" to Space; the player wants J for it, which the recording knows nothing of. */
static void other_keys_are_chosen_in_the_menu(void **unused)
{
    (void)unused;
    int count;
    make_folder();
    const happening script[] = {{3, "text a", 0, 0},   {4, "+escape", 0, 0}, {5, "+down", 0, 0},
                                {5, "+down", 0, 0},    {6, "+down", 0, 0},   {7, "+down", 0, 0},
                                {8, "+down", 0, 0},    {9, "+return", 0, 0}, {10, "+return", 0, 0},
                                {11, "+f1", 0, 0},     {12, "+j", 0, 0},     {13, "+escape", 0, 0},
                                {14, "+escape", 0, 0}, {20, "+j", 0, 0},     {22, "-j", 0, 0},
                                {24, "+space", 0, 0},  {26, "-space", 0, 0}, {30, "text \xc3\xa4", 0, 0},
                                {40, "close", 0, 0}};
    PLAY(script);
    s.def.pauses = true, s.def.record = recorded, s.def.settings = folder;
    assert_int_equal(play("actions"), SESSION_CLOSED);
    tear_down();
    count_lines(recorded, "+space", &count);
    assert_int_equal(count, 1);
    count_lines(recorded, "+j", &count);
    assert_int_equal(count, 0);
    count_lines(recorded, "text 00e4", &count);
    assert_int_equal(count, 1);
    /* It lasts; and all is as at first again by the last row but one. */
    const happening again[] = {
        {10, "+j", 0, 0},      {12, "-j", 0, 0},      {14, "+escape", 0, 0}, {15, "+down", 0, 0},
        {15, "+down", 0, 0},   {16, "+down", 0, 0},   {17, "+down", 0, 0},   {18, "+down", 0, 0},
        {19, "+return", 0, 0}, {20, "+up", 0, 0},     {21, "+up", 0, 0},     {22, "+return", 0, 0},
        {23, "+escape", 0, 0}, {24, "+escape", 0, 0}, {30, "+j", 0, 0},      {40, "close", 0, 0}};
    PLAY(again);
    s.def.pauses = true, s.def.record = recorded, s.def.settings = folder;
    assert_int_equal(play("actions"), SESSION_CLOSED);
    tear_down();
    count_lines(recorded, "+space", &count);
    assert_int_equal(count, 1);
    count_lines(recorded, "+j", &count);
    assert_int_equal(count, 1);
    drop_folder();
}

/* "jump" by the left trigger, and "walk" by the right stick, the other way round: the recording has what the game asked
 * for, and its replay does the same. */
static void sticks_are_chosen_in_the_menu(void **unused)
{
    (void)unused;
    static char output[OUTPUT_SIZE];
    int count;
    make_folder();
    const happening script[] = {{4, "+escape", 0, 0},
                                {5, "+down", 0, 0},
                                {5, "+down", 0, 0},
                                {6, "+down", 0, 0},
                                {7, "+down", 0, 0},
                                {8, "+down", 0, 0},
                                {9, "+return", 0, 0},
                                {10, "+return", 0, 0},
                                {11, "~left trigger", 0.3f, 0},
                                {12, "~left trigger", 0.9f, 0},
                                {13, "~left trigger", 0, 0},
                                {14, "+up", 0, 0},
                                {14, "+up", 0, 0},
                                {15, "+up", 0, 0},
                                {16, "+return", 0, 0},
                                {17, "+x", 0, 0},
                                {18, "~right trigger", 1, 0},
                                {19, "~right x", -0.8f, 0},
                                {20, "+escape", 0, 0},
                                {21, "+escape", 0, 0},
                                {30, "~left trigger", 0.55f, 0},
                                {32, "~left trigger", 0.45f, 0},
                                {34, "~left trigger", 0.3f, 0},
                                {36, "~right x", -0.5f, 0},
                                {38, "~right x", 0.25f, 0},
                                {39, "+space", 0, 0},
                                {40, "~left x", 1, 0},
                                {50, "close", 0, 0}};
    PLAY(script);
    s.def.pauses = true, s.def.record = recorded, s.def.settings = folder;
    assert_int_equal(play("actions"), SESSION_CLOSED);
    tear_down();
    static const struct {
        const char *line;
        int count;
    } WANTED[] = {{"+space", 1},  {"-space", 1}, {"stick 0.5 left x", 1}, {"stick -0.25 left x", 1},
                  {"trigger", 0}, {"right x", 0}};
    for (size_t i = 0; i < COUNT_OF(WANTED); i++) {
        count_lines(recorded, WANTED[i].line, &count);
        if (count != WANTED[i].count) fail_msg("'%s' is recorded %d times", WANTED[i].line, count);
    }
    assert_status(run_daft(output, "play tests/games/actions --headless --hash --strict --replay %s", recorded), 0,
                  output);
    drop_folder();
}

/* It is part of the recording: the replay starts again at the same tick. */
static void starting_again_is_replayed(void **unused)
{
    (void)unused;
    static char output[OUTPUT_SIZE];
    make_folder();
    const happening script[] = {
        {30, "+escape", 0, 0}, {31, "+up", 0, 0}, {32, "+up", 0, 0}, {33, "+return", 0, 0}, {60, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_and_pause(), SESSION_CLOSED);
    int count;
    count_lines(recorded, "+start again", &count);
    assert_int_equal(count, 1);
    const int ticks = ticks_recorded();
    char before[64];
    snprintf(before, sizeof before, "tick %d state 0x", ticks);
    assert_status(run_daft(output, "play tests/games/sample --headless --hash --replay %s", recorded), 0, output);
    assert_says(output, before);
    char with[32];
    snprintf(with, sizeof with, "%.18s", strstr(output, "state ") + 6);
    assert_status(run_daft(output, "play tests/games/sample --headless --hash --ticks %d", ticks), 0, output);
    assert_true(strstr(output, with) == NULL); /* it would be elsewhere without */
    drop_folder();
}

/* ---- live reload ---- */

/* The position after some ticks of "left", and what it was when the game began. */
#define WALK(speed)                                                                                                    \
    "local x, begun = 0, daft.load_saved('begun') or 0\n"                                                              \
    "daft.save('begun', begun + 1)\n"                                                                                  \
    "function daft.update()\n"                                                                                         \
    "  if daft.input.down('left') then x = x + " speed " end\n"                                                        \
    "  daft.save('x', x .. ' after ' .. daft.tick() .. ' begun ' .. begun)\n"                                          \
    "end\n"

static void begin_changing(void)
{
    char path[96];
    make_folder();
    snprintf(path, sizeof path, "%s/changing", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    snprintf(path, sizeof path, "%s/kept", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    write_game(WALK("1"));
}

static session_end play_changing(void)
{
    static char kept[96];
    char path[96];
    game_info info;
    daft_error error = {0};
    snprintf(kept, sizeof kept, "%s/kept", folder);
    snprintf(path, sizeof path, "%s/changing", folder);
    s.def.watches = true, s.def.record = recorded, s.def.saves = kept;
    assert_true(home_find_game(&s.where, path, &info, &error));
    session_end end = session_play(&s.def, &info, &error);
    if (end == SESSION_FAILED) fail_msg("%s", error.message);
    tear_down();
    return end;
}

static void saved_x(char out[80])
{
    char path[96];
    size_t size;
    daft_error error;
    snprintf(path, sizeof path, "%s/kept/changing.x.save", folder);
    char *text = daft_read_file(NULL, path, &size, &error);
    if (!text) fail_msg("%s", error.message);
    snprintf(out, 80, "%s", strchr(text, '\n') + 1);
    free(text);
}

/* New code goes on where the old one stood, as if it had been there from the start; what it keeps, it was given once.
 */
static void saved_scripts_take_effect_while_the_game_runs(void **unused)
{
    (void)unused;
    char now[80], wanted[80];
    begin_changing();
    const happening script[] = {{5, "+left", 0, 0},
                                {15, "-left", 0, 0},
                                {40, "write " WALK("100"), 0, 0},
                                {60, "+left", 0, 0},
                                {100, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    int x, ticks, begun;
    assert_int_equal(sscanf(now, "\"%d after %d begun %d", &x, &ticks, &begun), 3);
    assert_int_equal(x, 100 * (10 + ticks + 1 - 59)); /* the key of frame 60 is there in tick 59 */
    assert_in_range(ticks, 97, 101);
    assert_int_equal(begun, 0);
    /* The recording, played by the new code alone, ends the same. */
    static char output[OUTPUT_SIZE];
    char line[256];
    snprintf(line, sizeof line, "for f in %s/kept/*; do mv $f $f.old; done", folder);
    assert_int_equal(system(line), 0);
    write_game(
        "local all = {}\n" WALK("100") "local update = daft.update\n"
                                       "function daft.update() update() all = daft.load_saved('x') print(all) end\n");
    assert_status(run_daft(output, "play %s/changing --headless --replay %s", folder, recorded), 0, output);
    snprintf(wanted, sizeof wanted, "%d after %d begun 0", x, ticks);
    assert_says(output, wanted);
    drop_folder();
}

static void wrong_scripts_leave_the_old_ones_running(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks;
    begin_changing();
    const happening script[] = {{5, "+left", 0, 0},
                                {20, "write function daft.update() this is wrong end", 0, 0},
                                {40, "write function daft.update() local none = nil; none.x = 1 end", 0, 0},
                                {60, "write " WALK("10"), 0, 0},
                                {90, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_int_equal(x, 10 * (ticks + 1 - 4));
    assert_in_range(ticks, 87, 91);
    drop_folder();
}

/* The game binds places; what it shows is what the player reads there, or has chosen instead. */
static void keys_are_told_as_the_player_reads_them(void **unused)
{
    (void)unused;
    char now[128];
    begin_changing();
    write_game("daft.input.bind('walk', 'a', 'left')\n"
               "local shown = ''\n"
               "function daft.draw()\n"
               "  shown = daft.input.label('walk') .. ' ' .. daft.input.label('w') .. ' ' .. daft.input.label('left')\n"
               "    .. ' ' .. daft.input.label('+left x')\n"
               "end\n"
               "function daft.update() daft.save('x', shown) end\n");
    const happening script[] = {{20, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_non_null(strstr(now, "Q Z Left left stick right"));
    /* "walk" by the key in the place of M. */
    const happening other[] = {{4, "+escape", 0, 0},  {5, "+up", 0, 0},     {5, "+up", 0, 0}, {6, "+up", 0, 0},
                               {7, "+return", 0, 0},  {8, "+return", 0, 0}, {9, "+;", 0, 0},  {10, "+escape", 0, 0},
                               {11, "+escape", 0, 0}, {40, "close", 0, 0}};
    PLAY(other);
    s.def.pauses = true;
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_non_null(strstr(now, "M Z Left left stick right"));
    drop_folder();
}

/* What was before the game began again is not done again. */
static void a_game_that_began_again_is_relived_from_there(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks, begun;
    begin_changing();
    /* Held all the time; again from frame 33 on. */
    const happening script[] = {
        {5, "+left", 0, 0}, {30, "+f9", 0, 0}, {60, "write " WALK("100"), 0, 0}, {90, "close", 0, 0}};
    write_game(WALK("1") "function daft.keypressed(key) if key == 'f9' then daft.restart() end end\n");
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d begun %d", &x, &ticks, &begun), 3);
    assert_int_equal(x, 100 * (ticks + 1));
    assert_in_range(ticks, 57, 62);
    assert_int_equal(begun, 1);
    drop_folder();
}

static void tap(happening *out, size_t *count, uint64_t frame, const char *down, const char *up)
{
    out[(*count)++] = (happening){frame, down, 0, 0}, out[(*count)++] = (happening){frame + 1, up, 0, 0};
}

/* ---- daft.reload ---- */

#define HANDS                                                                                                          \
    "local all, n = { turns = 0 }, %s\nfunction daft.keep() all.turns = all.turns + 1 return all end\n"                \
    "function daft.load() all.loaded = true end\nfunction daft.update() all.ticks = (all.ticks or 0) + n "             \
    "daft.save('x', all.ticks .. ' turns ' .. all.turns .. ' after ' .. daft.tick()) end\n"
#define TAKES "function daft.reload(old) assert(all.loaded and not all.ticks) all = old end\n"

static const char *hands(const char *step, const char *more)
{
    static char text[4][1024];
    static int last;
    char *out = text[last++ % 4];
    const int length = snprintf(out, 1024, "write " HANDS, step);
    snprintf(out + length, 1024 - (size_t)length, "%s", more);
    return out;
}

/* By what the old code keeps, and not by its input; the recording ends there, and is right. */
static void state_is_handed_to_new_code(void **unused)
{
    (void)unused;
    static char output[OUTPUT_SIZE];
    char now[80], line[256];
    int x, turns, ticks;
    begin_changing();
    const happening script[] = {
        {40, hands("100", TAKES), 0, 0}, {80, hands("10000", TAKES), 0, 0}, {110, "close", 0, 0}};
    write_game(hands("1", TAKES) + 6);
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d turns %d after %d", &x, &turns, &ticks), 3);
    assert_int_equal(turns, 2);
    assert_in_range(ticks, 20, 30); /* of the last code */
    assert_int_equal(x / 10000, ticks + 1);
    assert_in_range(x / 100 % 100, 38, 42);
    assert_in_range(x % 100, 40, 47);
    assert_int_equal(ticks_recorded(), x % 100);
    write_game(hands("1", TAKES) + 6);
    snprintf(line, sizeof line, "for f in %s/kept/*; do mv $f $f.old; done", folder);
    assert_int_equal(system(line), 0);
    assert_status(run_daft(output, "play %s/changing --headless --hash --replay %s", folder, recorded), 0, output);
    drop_folder();
}

/* Where nothing can be handed over the old code runs on, or the input is played again. */
static void reload_may_fail_or_be_missing(void **unused)
{
    (void)unused;
    char now[80];
    int x, turns, ticks;
    begin_changing();
    const happening wrong[] = {{30, hands("100", "function daft.reload(old) old.ticks.x = 1 end\n"), 0, 0},
                               {60, hands("100", TAKES "function daft.keep() return print end\n"), 0, 0},
                               {80, hands("5", TAKES), 0, 0}, /* refused: daft.keep fails */
                               {100, "close", 0, 0}};
    write_game(hands("1", TAKES) + 6);
    PLAY(wrong);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d turns %d after %d", &x, &turns, &ticks), 3);
    assert_int_equal(turns, 2); /* kept twice: for the code that failed, and for the next one */
    assert_int_equal(x / 100, ticks + 1);
    assert_in_range(x % 100, 60, 67);
    drop_folder();
    begin_changing();
    const happening missing[] = {{40, hands("3", ""), 0, 0}, {80, "close", 0, 0}};
    write_game(hands("1", TAKES) + 6);
    PLAY(missing);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d turns %d after %d", &x, &turns, &ticks), 3);
    assert_int_equal(x, 3 * (ticks + 1));
    assert_in_range(ticks, 77, 81);
    drop_folder();
}

/* Without daft.keep, plain global variables; and back in time to where they were handed over. */
static void globals_are_handed_to_new_code(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks;
    static const char GAME[] =
        "write count, list = count or 0, { function() end, 5, inner = { true, 1 / 0 } }\nlist.self = list\n"
        "function daft.reload(old) assert(old.list[2] == 5 and old.list.inner[1] and not old.list[1] and not old.math "
        "and "
        "not old._VERSION and not old.daft and not old.assert) count = old.count end\n"
        "function daft.update() count = count + STEP daft.save('x', count .. ' after ' .. daft.tick()) end\n";
    char second[1024];
    const char *place = strstr(GAME, "STEP");
    snprintf(second, sizeof second, "%.*s100%s", (int)(place - GAME), GAME, place + 4);
    happening script[64] = {{40, second, 0, 0}};
    size_t count = 1;
    script[count++] = (happening){70, "+f5", 0, 0}; /* back beyond the reload: it stops there */
    script[count++] = (happening){170, "-f5", 0, 0};
    tap(script, &count, 180, "+space", "-space");
    script[count++] = (happening){190, "close", 0, 0};
    begin_changing();
    char first[1024];
    snprintf(first, sizeof first, "%.*s1%s", (int)(place - GAME) - 6, GAME + 6, place + 4);
    write_game(first);
    set_up(script, count);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(x % 100, 40, 47);
    assert_int_equal(x / 100, ticks + 1);
    assert_in_range(ticks, 7, 11);
    drop_folder();
}

/* ---- how soon ---- */

static const char SCRIPT[] = "local tone = daft.sound('tone.wav')\nfunction daft.load() daft.scene('level.scene') "
                             "daft.entity { mesh = 'shape.obj', material = 'paint.png', position = {6, 0.5, 0} } end\n"
                             "function daft.draw() daft.text(('%.2f s, '):format(tone:seconds()) .. ";

static size_t put_wav(char *out, uint32_t frames)
{
    const uint32_t size = 2 * frames, head[11] = {0x46464952, 36 + size, 0x45564157, 0x20746d66, 16,  0x00010001,
                                                  48000,      96000,     0x00100002, 0x61746164, size};
    memcpy(out, head, sizeof head);
    memset(out + sizeof head, 1, size);
    return sizeof head + size;
}

static void save_file(const char *name, bool anew)
{
    static char text[1 << 16];
    char path[96];
    size_t size = 0;
    daft_error error;
    snprintf(path, sizeof path, "%s/changing/%s", folder, name);
    if (strcmp(name, "paint.png") == 0) {
        daft_image *image = daft_image_create(s.engine, anew ? 2 : 1, 1, &error);
        memset(daft_image_pixels(image), anew ? 250 : 100, anew ? 8 : 4);
        if (!daft_image_write(image, path, &error)) fail_msg("%s", error.message);
        daft_image_destroy(image);
        return;
    }
    if (strcmp(name, "main.lua") == 0)
        size = (size_t)snprintf(text, sizeof text, "%s %s, 16, 16) end\n", SCRIPT, anew ? "'anew'" : "'old'");
    else if (strcmp(name, "level.scene") == 0)
        size = (size_t)snprintf(text, sizeof text, "camera 0 1 0\nsun 1 -1 0 1 1 %s\nambient 1 1 1\n",
                                anew ? "0.25" : "1");
    else if (strcmp(name, "shape.obj") == 0)
        size = (size_t)snprintf(text, sizeof text,
                                "v 0 0 -1\nv 0 0 1\nv 0 %s 1\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 3/3 2/2 1/1\n",
                                anew ? "3.25" : "2");
    else
        size = put_wav(text, anew ? 24000 : 12000);
    if (!daft_write_file(path, text, size, &error)) fail_msg("%s", error.message);
}

/* Each kind of file, in a small game, with a clock that runs. On a machine that does nothing else it is within a
 * tenth of a second; a test on a busy one only finds what waits for ever. */
static void what_is_saved_is_soon_seen(void **unused)
{
    (void)unused;
    begin_changing();
    set_up(NULL, 0);
    for (int i = 0; i < SAVED_FILES; i++) save_file(SAVED[i], false);
    s.screen.real = true, s.screen.width = 640, s.screen.height = 360;
    assert_int_equal(play_changing(), SESSION_CLOSED);
    for (int i = 0; i < SAVED_FILES; i++) {
        printf("%-12s shows after %5.1f ms, in frame %d\n", SAVED[i], saved_ms[i], (int)saved_frames[i]);
        assert_true(saved_ms[i] > 0 && saved_ms[i] < 2000);
    }
    drop_folder();
}

/* ---- time that is held ---- */

/* Back by five, on by two, back by one and one for the first: the tick that the game goes on from; and its recording
 * plays as one straight game. */
static void f5_and_f6_go_through_time(void **unused)
{
    (void)unused;
    happening script[64];
    size_t count = 0;
    char line[256], now[80];
    static char output[OUTPUT_SIZE];
    int x, ticks;
    begin_changing();
    script[count++] = (happening){5, "+left", 0, 0};
    for (int i = 0; i < 5; i++) tap(script, &count, 60 + 4 * (uint64_t)i, "+f5", "-f5"); /* tick 60 becomes 55 */
    tap(script, &count, 90, "+f6", "-f6");
    tap(script, &count, 94, "+f6", "-f6");
    script[count++] = (happening){100, "-left", 0, 0};
    tap(script, &count, 110, "+space", "-space"); /* on from tick 57 */
    script[count++] = (happening){140, "close", 0, 0};
    set_up(script, count);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(ticks, 57 + 26, 57 + 31);
    assert_in_range(x, 57 - 6, 57 - 4); /* the key went up while time was held */
    assert_int_equal(ticks_recorded(), ticks + 1);
    snprintf(line, sizeof line, "for f in %s/kept/*; do mv $f $f.old; done", folder);
    assert_int_equal(system(line), 0);
    assert_status(run_daft(output, "play %s/changing --headless --strict --replay %s", folder, recorded), 0, output);
    drop_folder();
}

/* Live reload forgets the images of the old code's memory: the new one is played again from the start. */
static void new_code_goes_back_too(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks;
    happening script[64];
    size_t count = 0;
    begin_changing();
    script[count++] = (happening){5, "+left", 0, 0};
    tap(script, &count, 60, "+f5", "-f5");
    tap(script, &count, 70, "+space", "-space"); /* from tick 59 on */
    script[count++] = (happening){90, "write " WALK("100"), 0, 0};
    script[count++] = (happening){120, "+f5", 0, 0};
    script[count++] = (happening){300, "-f5", 0, 0};
    for (int i = 0; i < 7; i++) tap(script, &count, 310 + 3 * (uint64_t)i, "+f6", "-f6");
    tap(script, &count, 340, "+space", "-space");
    script[count++] = (happening){350, "-left", 0, 0};
    script[count++] = (happening){360, "close", 0, 0};
    set_up(script, count);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(ticks, 7 + 17, 7 + 22);
    assert_in_range(x, 100 * (2 + 8), 100 * (2 + 12)); /* of the first seven ticks the key was down in two */
    drop_folder();
}

/* Held down it goes back by as much as it was held, and no farther than the start; steps beyond the present are new
 * ticks, of what the player holds. */
static void time_that_is_held_is_scrubbed_and_stepped(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks;
    const happening back[] = {
        {5, "+left", 0, 0}, {60, "+f5", 0, 0}, {200, "-f5", 0, 0}, {210, "+space", 0, 0}, {230, "close", 0, 0}};
    begin_changing();
    PLAY(back);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(ticks, 17, 21); /* from the start on, the key held all the time */
    assert_int_equal(x, ticks + 1);
    drop_folder();
    const happening on[] = {{60, "+f6", 0, 0}, {61, "-f6", 0, 0},   {70, "+left", 0, 0},
                            {72, "+f6", 0, 0}, {73, "-f6", 0, 0},   {75, "+f6", 0, 0},
                            {76, "-f6", 0, 0}, {90, "-left", 0, 0}, {95, "close", 0, 0}};
    begin_changing();
    PLAY(on);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(ticks, 60, 62);
    assert_int_equal(x, 2);
    drop_folder();
}

/* A game that has stopped with an error goes on when its script is right. */
static void a_stopped_game_goes_on_when_it_is_right(void **unused)
{
    (void)unused;
    char now[80];
    begin_changing();
    write_game(WALK("1") "local update = daft.update\nfunction daft.update() if daft.tick() == 10 then nothing.x = 1 "
                         "end update() end\n");
    const happening script[] = {{40, "write " WALK("1"), 0, 0}, {90, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_non_null(strstr(now, "0 after 5")); /* ten ticks, and those from frame 43 on */
    drop_folder();
}

/* What a game wishes is granted once, and again only where it wishes something else. */
static void the_window_is_as_the_game_wishes(void **unused)
{
    (void)unused;
    char icon[96];
    daft_error error;
    begin_changing();
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
    const struct CMUnitTest tests[] = {cmocka_unit_test(f3_draws_the_shapes_of_bodies),
                                       cmocka_unit_test(f2_shows_what_settings_cost),
                                       cmocka_unit_test(the_rungs_are_surveyed),
                                       cmocka_unit_test(escape_leaves_and_the_window_closes),
                                       cmocka_unit_test(escape_pauses_and_the_game_stands_still),
                                       cmocka_unit_test(the_pause_menu_shows_itself_and_goes_by_mouse),
                                       cmocka_unit_test(settings_last),
                                       cmocka_unit_test(the_player_chooses_the_picture),
                                       cmocka_unit_test(starting_again_is_replayed),
                                       cmocka_unit_test(other_keys_are_chosen_in_the_menu),
                                       cmocka_unit_test(keys_are_told_as_the_player_reads_them),
                                       cmocka_unit_test(sticks_are_chosen_in_the_menu),
                                       cmocka_unit_test(saved_scripts_take_effect_while_the_game_runs),
                                       cmocka_unit_test(wrong_scripts_leave_the_old_ones_running),
                                       cmocka_unit_test(a_game_that_began_again_is_relived_from_there),
                                       cmocka_unit_test(state_is_handed_to_new_code),
                                       cmocka_unit_test(reload_may_fail_or_be_missing),
                                       cmocka_unit_test(globals_are_handed_to_new_code),
                                       cmocka_unit_test(what_is_saved_is_soon_seen),
                                       cmocka_unit_test(f5_and_f6_go_through_time),
                                       cmocka_unit_test(new_code_goes_back_too),
                                       cmocka_unit_test(time_that_is_held_is_scrubbed_and_stepped),
                                       cmocka_unit_test(a_stopped_game_goes_on_when_it_is_right),
                                       cmocka_unit_test(the_picture_follows_the_window),
                                       cmocka_unit_test(the_window_is_as_the_game_wishes),
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
