/* A session on a platform made for tests: keys and clicks come from a list, a frame is 1/60 s; and games that tests
 * write. Comes before cmocka.h, whose `fail` is another one. */
#ifndef TEST_SCRIPTED_SESSION_H
#define TEST_SCRIPTED_SESSION_H

#include "cli/commands.h"
#include "common/util.h"
#include "game/loop.h"
#include "session/session.h"

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
    const char *what; /* "+left", "-left", "~left x" to x, "focus", "close", "console", "move" to x, y, "click" there,
                         "size" x by y, "write " and a script; or letters that are typed, after a blank */
    float x, y;
} happening;

typedef struct script_platform {
    platform face;
    const happening *script;
    size_t count, next;
    const char *letters; /* still to be typed */
    uint64_t frame, presented, changed, hash;
    int width, height;
    bool hidden;
    bool click; /* the press that follows the move of a click */
    int picture_width, picture_height;
    uint8_t corner[4]; /* of the last picture */
    char title[200];
    int wished_width, wished_height, full, icon_width;          /* as the game asked; full: -1 until it does */
    char copied[FAILURE_TEXT];                                  /* to the clipboard */
    void (*seen)(struct script_platform *self, uint64_t upper); /* of each picture, with a hash of its upper half, where
                                                                   time passes; NULL: by frames alone */
    bool closes;                                                /* the close button is pressed */
} script_platform;

static char folder[64], recorded[96]; /* of games that tests write */

/* The game in folder/changing. A file system's times may be coarse: each has another size. */
static inline void write_game(const char *text)
{
    static int times;
    char path[96], padded[2048];
    daft_error error;
    snprintf(path, sizeof path, "%s/changing/main.lua", folder);
    const int size = snprintf(padded, sizeof padded, "%s\n--%*s\n", text, 1 + times++ % 50, "");
    if (!daft_write_file(path, padded, (size_t)size, &error)) fail_msg("%s", error.message);
}

static inline void close_script(platform *self) { (void)self; }

static inline bool poll_script(platform *self, platform_event *out)
{
    script_platform *p = (script_platform *)self;
    *out = (platform_event){.kind = PLATFORM_INPUT};
    if (p->click) {
        p->click = false;
        out->input = (input_event){.kind = INPUT_KEY, .key = input_key_find("mouse1"), .down = true};
        return true;
    }
    if (p->closes) {
        p->closes = false, out->kind = PLATFORM_CLOSE;
        return true;
    }
    if (p->letters && *p->letters) {
        out->input = (input_event){.kind = INPUT_TEXT, .key = (int)utf8_next(&p->letters)};
        return true;
    }
    if (p->next == p->count || p->script[p->next].frame > p->frame) return false;
    const happening *now = &p->script[p->next++];
    if (strncmp(now->what, "write ", 6) == 0) {
        write_game(now->what + 6);
        return poll_script(self, out);
    }
    if (now->what[0] == ' ') {
        p->letters = now->what + 1;
        return poll_script(self, out);
    }
    if (strcmp(now->what, "close") == 0) {
        out->kind = PLATFORM_CLOSE;
    } else if (strcmp(now->what, "console") == 0) {
        out->kind = PLATFORM_CONSOLE;
    } else if (strcmp(now->what, "focus") == 0) {
        out->kind = PLATFORM_FOCUS_LOST;
    } else if (strcmp(now->what, "click") == 0 || strcmp(now->what, "move") == 0) {
        out->input = (input_event){.kind = INPUT_MOVE, .x = now->x, .y = now->y};
        p->click = now->what[0] == 'c';
    } else if (now->what[0] == '~') {
        out->input = (input_event){.kind = INPUT_STICK, .key = input_stick_find(now->what + 1), .x = now->x};
        assert_true(out->input.key >= 0);
    } else if (strcmp(now->what, "size") == 0) {
        p->width = (int)now->x, p->height = (int)now->y;
        return poll_script(self, out);
    } else {
        int key = input_key_find(now->what + 1);
        assert_true(key >= 0);
        out->input = (input_event){.kind = INPUT_KEY, .key = key, .down = now->what[0] == '+'};
    }
    return true;
}

static inline void size_script(platform *self, int *width, int *height)
{
    *width = ((script_platform *)self)->width, *height = ((script_platform *)self)->height;
}

static inline bool wants_frame_script(platform *self)
{
    (void)self;
    return true;
}

static inline bool present_script(platform *self, const daft_image *picture, daft_error *error)
{
    (void)error;
    script_platform *p = (script_platform *)self;
    const size_t bytes = 4 * (size_t)daft_image_width(picture) * (size_t)daft_image_height(picture);
    const uint64_t hash = daft_hash(daft_image_pixels((daft_image *)(uintptr_t)picture), bytes, 0);
    p->changed += p->presented > 0 && hash != p->hash;
    p->hash = hash, p->presented++;
    memcpy(p->corner, daft_image_pixels((daft_image *)(uintptr_t)picture), 4);
    if (p->seen) p->seen(p, daft_hash(daft_image_pixels((daft_image *)(uintptr_t)picture), bytes / 2, 0));
    p->picture_width = daft_image_width(picture), p->picture_height = daft_image_height(picture);
    return true;
}

static inline void end_frame_script(platform *self)
{
    /* A script without an end is a bug of the test. */
    assert_true(((script_platform *)self)->frame++ < 2000);
    if (((script_platform *)self)->seen) usleep(1000000 / LOOP_RATE);
}

static inline uint64_t now_script(platform *self)
{
    if (((script_platform *)self)->seen) return clock_now_ns();
    return (((script_platform *)self)->frame * 1000000000u + LOOP_RATE - 1) / LOOP_RATE;
}

static inline void set_title_script(platform *self, const char *title)
{
    snprintf(((script_platform *)self)->title, sizeof((script_platform *)self)->title, "%s", title);
}

static inline void set_size_script(platform *self, int width, int height)
{
    script_platform *p = (script_platform *)self;
    p->wished_width = width, p->wished_height = height;
}

/* A French keyboard, as far as it matters. */
static inline bool key_label_script(platform *self, const char *key, char *out, size_t size)
{
    static const char *const PAIRS[] = {"aQ", "qA", "wZ", "zW", ";M", "m,"};
    (void)self;
    for (size_t i = 0; i < COUNT_OF(PAIRS); i++)
        if (key[0] == PAIRS[i][0] && !key[1]) return snprintf(out, size, "%s", PAIRS[i] + 1) > 0;
    return false;
}

static inline bool full_screen_script(platform *self, int wish)
{
    script_platform *p = (script_platform *)self;
    if (wish >= 0) p->full = wish;
    return p->full == 1;
}

static inline void set_icon_script(platform *self, daft_image *icon)
{
    ((script_platform *)self)->icon_width = daft_image_width(icon);
}

static inline void grab_script(platform *self, bool grab) { (void)self, (void)grab; }
static inline bool copy_script(platform *self, const char *text)
{
    snprintf(((script_platform *)self)->copied, FAILURE_TEXT, "%s", text);
    return true;
}
static inline void hide_script(platform *self) { ((script_platform *)self)->hidden = true; }

/* ---- the stage ---- */

typedef struct stage {
    home where;
    daft_engine *engine;
    font *face;
    script_platform screen;
    session_def def;
    uint64_t peak; /* bytes that the engine held at most, once it is gone */
} stage;

static stage s;

static inline void begin_script(const happening *script, size_t count)
{
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

static inline void set_up(const happening *script, size_t count)
{
    daft_error error;
    memset(&s, 0, sizeof s);
    assert_true(home_find(&s.where, &error));
    assert_non_null(s.face = open_font(&s.where, &error));
    daft_engine_def engine = daft_default_engine_def();
    assert_non_null(s.engine = daft_engine_create(&engine, &error));
    begin_script(script, count);
}

static inline void tear_down(void)
{
    s.peak = daft_engine_memory(s.engine).peak;
    font_close(s.face);
    daft_engine_destroy(s.engine);
}

static inline session_end play(const char *game)
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

/* ---- games that tests write, in folder/changing ---- */

static inline void make_folder(void)
{
    snprintf(folder, sizeof folder, "/tmp/daft-pause-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(recorded, sizeof recorded, "%s/a.rec", folder);
}

static inline void drop_folder(void)
{
    char command[96];
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

static inline int ticks_recorded(void)
{
    char line[128];
    int end = -1;
    FILE *file = fopen(recorded, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) sscanf(line, "end %d", &end);
    fclose(file);
    return end;
}

static inline void begin_changing(const char *script)
{
    char path[96];
    make_folder();
    snprintf(path, sizeof path, "%s/changing", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    snprintf(path, sizeof path, "%s/kept", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    write_game(script);
}

static inline session_end play_changing(void)
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

static inline void saved_x(char out[80])
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

static inline void tap(happening *out, size_t *count, uint64_t frame, const char *down, const char *up)
{
    out[(*count)++] = (happening){frame, down, 0, 0}, out[(*count)++] = (happening){frame + 1, up, 0, 0};
}

/* How many lines of a file have the text. */
static inline void count_lines(const char *path, const char *wanted, int *count)
{
    char line[1200];
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    for (*count = 0; fgets(line, sizeof line, file);)
        if (strstr(line, wanted)) ++*count;
    fclose(file);
}

#endif
