/* The peer of users' frames: OpenGL on llvmpipe shows the scene that the engine shows, as it is or with the knobs of
 * equal work. Edges lie a pixel elsewhere, shadows are softer: so means of 16x16 pixels are compared, and most of them
 * must agree. */
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

static daft_image *theirs(daft_engine *engine, const char *scene)
{
    char path[128], command[1024];
    daft_error error;
    snprintf(path, sizeof path, "/tmp/daft-llvmpipe-%d.png", (int)getpid());
    snprintf(command, sizeof command,
             "ASAN_OPTIONS=detect_leaks=0 '%s' scene '%s/assets/scenes/%s.scene' --size %dx%d --picture '%s'",
             DAFT_LLVMPIPE, DAFT_ROOT, scene, WIDTH, HEIGHT, path);
    const int status = system(command);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    daft_image *image = daft_image_load(engine, path, &error);
    unlink(path);
    assert_non_null(image);
    return image;
}

static daft_image *ours(daft_engine *engine, const char *name, bool equal_work)
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
    if (equal_work) sway_equal_work(&view.quality);
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
static int alike(const char *scene, bool equal_work)
{
    daft_error error;
    const daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    assert_non_null(engine);
    daft_image *a = ours(engine, scene, equal_work), *b = theirs(engine, scene);
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
    static const struct {
        const char *scene;
        bool equal_work;
        int least;
    } cases[] = {{"temple", false, 85}, {"islands", false, 85}, {"town", false, 85},
                 {"hall", false, 60}, /* lamps without shadows */
                 {"glass", true, 90},   {"studio", true, 90},   {"dusk", true, 90},
                 {"mirrors", true, 80}, {"leaves", true, 80},   {"panes", true, 70}}; /* no shadows of what is clear */
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const int found = alike(cases[i].scene, cases[i].equal_work);
        print_message("%s: %d of 100 blocks agree\n", cases[i].scene, found);
        if (found < cases[i].least) fail_msg("%s: only %d of 100 blocks agree", cases[i].scene, found);
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
static void wrong_usage_is_status_2(void **unused) { (void)unused, skip(); }
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_show_the_same),
        cmocka_unit_test(wrong_usage_is_status_2),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
