/* The peer of users' frames: OpenGL on llvmpipe shows the scene that the engine shows, as it is or with the knobs of
 * equal work, with the shadows of all lights or the sun's alone. Edges lie a pixel elsewhere, shadows are softer: so
 * means of 16x16 pixels are compared, and most of them must agree. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "../../bench/frames/sway.h"
#include "daft.h"

#ifdef DAFT_LLVMPIPE
enum { WIDTH = 320, HEIGHT = 176, BLOCK = 16, NEAR = 12 };

/* What the engine draws: a frame in full; and no more than the peer. */
typedef enum work_kind { FULL, EQUAL_WORK, ALL_SHADOWS } work_kind;

static daft_image *theirs(daft_engine *engine, const char *scene, bool all_shadows)
{
    char path[128], command[1024];
    daft_error error;
    snprintf(path, sizeof path, "/tmp/daft-llvmpipe-%d.png", (int)getpid());
    snprintf(command, sizeof command,
             "ASAN_OPTIONS=detect_leaks=0 '%s' scene '%s/assets/scenes/%s.scene' --size %dx%d --picture '%s'%s",
             DAFT_LLVMPIPE, DAFT_ROOT, scene, WIDTH, HEIGHT, path, all_shadows ? " --all-shadows" : "");
    const int status = system(command);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    daft_image *image = daft_image_load(engine, path, &error);
    unlink(path);
    assert_non_null(image);
    return image;
}

static daft_image *ours(daft_engine *engine, const char *name, work_kind work)
{
    char path[512];
    daft_error error;
    daft_scene *scene = daft_scene_create(engine, &error);
    daft_image *image = daft_image_create(engine, WIDTH, HEIGHT, &error);
    snprintf(path, sizeof path, "%s/assets/scenes/%s.scene", DAFT_ROOT, name);
    assert_true(scene && image && daft_scene_load(scene, path, &error));
    daft_view view = daft_default_view();
    view.camera = daft_scene_camera(scene, 1);
    view.quality = daft_preset_quality(DAFT_PRESET_GAME);
    if (work != FULL) sway_equal_work(&view.quality, work == ALL_SHADOWS || sway_has_sun(scene, &view));
    assert_true(daft_render(scene, &view, image, &error));
    daft_scene_destroy(scene);
    return image;
}

static int mean(daft_image *image, int x, int y, int channel)
{
    const uint8_t *pixels = daft_image_pixels(image);
    int sum = 0;
    for (int row = y; row < y + BLOCK; row++)
        for (int column = x; column < x + BLOCK; column++) sum += pixels[4 * (row * WIDTH + column) + channel];
    return sum / (BLOCK * BLOCK);
}

/* How many of a hundred blocks agree within NEAR levels of 255 in every channel. */
static int alike(const char *scene, work_kind work)
{
    daft_error error;
    const daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    assert_non_null(engine);
    daft_image *a = ours(engine, scene, work), *b = theirs(engine, scene, work == ALL_SHADOWS);
    int same = 0, all = 0;
    for (int y = 0; y < HEIGHT; y += BLOCK) {
        for (int x = 0; x < WIDTH; x += BLOCK) {
            bool near = true;
            for (int k = 0; k < 3; k++) near = near && abs(mean(a, x, y, k) - mean(b, x, y, k)) <= NEAR;
            same += near, all++;
        }
    }
    daft_image_destroy(a);
    daft_image_destroy(b);
    daft_engine_destroy(engine);
    return same * 100 / all;
}

static void both_show_the_same(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {"in full", "equal work", "all shadows"};
    static const struct {
        const char *scene;
        work_kind work;
        int least;
    } cases[] = {{"temple", FULL, 85},        {"islands", FULL, 85},        {"town", FULL, 85},
                 {"glass", EQUAL_WORK, 90},   {"studio", EQUAL_WORK, 90},   {"dusk", EQUAL_WORK, 90},
                 {"leaves", EQUAL_WORK, 80},  {"panes", EQUAL_WORK, 70}, /* no shadows of what is clear */
                 {"mirrors", EQUAL_WORK, 80}, {"hall", EQUAL_WORK, 85},     {"stage", EQUAL_WORK, 95},
                 {"hall", ALL_SHADOWS, 85},   {"stage", ALL_SHADOWS, 95},   {"lamps", ALL_SHADOWS, 75},
                 {"temple", ALL_SHADOWS, 95}, {"mirrors", ALL_SHADOWS, 95}, {"gallery", ALL_SHADOWS, 85}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const int found = alike(cases[i].scene, cases[i].work);
        print_message("%s, %s: %d of 100 blocks agree\n", cases[i].scene, NAMES[cases[i].work], found);
        if (found < cases[i].least) fail_msg("%s, %s: only %d of 100", cases[i].scene, NAMES[cases[i].work], found);
    }
}

/* Levels that a pixel of the first is brighter, all channels together. */
static int brighter(daft_image *a, daft_image *b, int pixel)
{
    const uint8_t *p = daft_image_pixels(a) + 4 * pixel, *q = daft_image_pixels(b) + 4 * pixel;
    return p[0] - q[0] + p[1] - q[1] + p[2] - q[2];
}

/* Where a picture without shadows is brighter than one with them, there is a shadow: of a hundred pixels with one, in
 * how many both sides have it. Those between, which have a little, count on neither side. */
static int shadows_alike(const char *scene)
{
    daft_error error;
    const daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    assert_non_null(engine);
    daft_image *const a[2] = {ours(engine, scene, EQUAL_WORK), ours(engine, scene, ALL_SHADOWS)},
                      *const b[2] = {theirs(engine, scene, false), theirs(engine, scene, true)};
    int both = 0, some = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int here = brighter(a[0], a[1], i), there = brighter(b[0], b[1], i);
        const bool dark = here >= 2 * NEAR, darker = there >= 2 * NEAR;
        both += dark && darker, some += (dark && there < NEAR) || (darker && here < NEAR) || (dark && darker);
    }
    for (int k = 0; k < 2; k++) daft_image_destroy(a[k]), daft_image_destroy(b[k]);
    daft_engine_destroy(engine);
    assert_in_range(some, WIDTH * HEIGHT / 50, WIDTH * HEIGHT);
    return both * 100 / some;
}

/* Spots, points, soft lamps taken as points; none of these scenes has a sun. */
static void shadows_of_lamps_lie_in_the_same_places(void **unused)
{
    (void)unused;
    static const char *const scenes[] = {"stage", "hall", "lamps", "mirrors"};
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++) {
        const int found = shadows_alike(scenes[i]);
        print_message("%s: %d of 100 pixels in shadow agree\n", scenes[i], found);
        if (found < 80) fail_msg("%s: only %d of 100 pixels in shadow agree", scenes[i], found);
    }
}

static void wrong_usage_is_status_2(void **unused)
{
    (void)unused;
    const int status = system("'" DAFT_LLVMPIPE "' scene 2>/dev/null");
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 2);
}
#else
static void both_show_the_same(void **unused)
{
    (void)unused;
    print_message("no OSMesa when the build was configured\n");
    skip();
}
static void shadows_of_lamps_lie_in_the_same_places(void **unused) { (void)unused, skip(); }
static void wrong_usage_is_status_2(void **unused) { (void)unused, skip(); }
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_show_the_same),
        cmocka_unit_test(shadows_of_lamps_lie_in_the_same_places),
        cmocka_unit_test(wrong_usage_is_status_2),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
