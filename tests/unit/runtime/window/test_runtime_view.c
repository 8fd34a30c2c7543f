/* runtime: the window of `daft view`: how the camera moves, and what keys, drops and saved files do, on a platform made
 * for tests that presses one key a frame. */
#include "common/util.h"
#include "view/picture/draw.h"
#include "view/fly.h"
#include "job/job.h"
#include "job/shot.h"
#include "view/keys.h"
#include "view/route.h"
#include "view/view.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>
#include <unistd.h>

/* ---- the camera ---- */

static double apart(daft_dvec3 a, daft_dvec3 b)
{
    double x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
    return sqrt(x * x + y * y + z * z);
}

static flight start(void)
{
    flight f = {.camera = daft_default_camera(), .speed = 2};
    f.camera.yaw = 0.4f, f.camera.pitch = 0.2f;
    return f;
}

static void flying_goes_as_fast_as_it_says(void **unused)
{
    (void)unused;
    flight f = start();
    assert_true(fly_move(&f, &(flight_wish){.forward = 1, .factor = 1}, 0.5));
    assert_true(fabs(apart(f.camera.position, (daft_dvec3){0, 0, 0}) - 1) < 1e-9);
    assert_true(f.camera.position.x > 0 && f.camera.position.z > 0 && f.camera.position.y < 0); /* right and down */
    assert_true(fly_move(&f, &(flight_wish){.forward = -1, .factor = 4}, 0.125));
    assert_true(apart(f.camera.position, (daft_dvec3){0, 0, 0}) < 1e-9);
    assert_false(fly_move(&f, &(flight_wish){.factor = 1}, 1));
}

static void nobody_looks_over_the_top(void **unused)
{
    (void)unused;
    flight f = start();
    for (int i = 0; i < 100; i++) fly_move(&f, &(flight_wish){.yaw = 0.7, .pitch = 0.3, .factor = 1}, 0);
    assert_true(f.camera.pitch < 1.5708f && f.camera.pitch > 1.5f);
    assert_true(fabsf(f.camera.yaw) <= 3.15f);
}

static void turning_keeps_the_distance_and_the_place_in_the_picture(void **unused)
{
    (void)unused;
    flight f = start();
    f.pivot = (daft_dvec3){5, -1, 3};
    f.orbits = true;
    double before = apart(f.camera.position, f.pivot);
    for (int i = 0; i < 50; i++) fly_orbit(&f, 0.1, i % 2 ? 0.02 : -0.03);
    assert_true(fabs(apart(f.camera.position, f.pivot) - before) < 1e-5);
    for (int i = 0; i < 400; i++) fly_move(&f, &(flight_wish){.forward = 1, .factor = 1}, 0.1);
    assert_true(apart(f.camera.position, f.pivot) < 1e-3); /* near, never past it */
}

static void rays_go_through_their_pixels(void **unused)
{
    (void)unused;
    daft_camera camera = daft_camera_look_at((daft_dvec3){1, 2, 3}, (daft_dvec3){4, 1, 9}, 1);
    daft_vec3 middle = daft_camera_ray(&camera, 0.5, 0.5, 0.5), edge = daft_camera_ray(&camera, 1, 0.5, 0.5);
    double length = sqrt(46), cosine = 0;
    assert_true(fabs((double)middle.x - 3 / length) < 1e-6 && fabs((double)middle.y + 1 / length) < 1e-6);
    cosine = (double)middle.x * (double)edge.x + (double)middle.y * (double)edge.y + (double)middle.z * (double)edge.z;
    assert_true(fabs(cosine - cos(0.5)) < 1e-6);
}

/* ---- the keys ---- */

static void every_key_is_told_once(void **unused)
{
    (void)unused;
    char text[3000];
    size_t count;
    const view_key *keys = view_keys(&count);
    view_keys_text(text, sizeof text);
    for (size_t i = 0; i < count; i++) {
        if (!strstr(text, keys[i].does)) fail_msg("%s is not told", keys[i].shown);
        for (size_t k = 0; k < COUNT_OF(keys[i].keys); k++) {
            if (!keys[i].keys[k]) continue;
            if (input_key_find(keys[i].keys[k]) < 0) fail_msg("there is no key %s", keys[i].keys[k]);
            if (view_key_find(keys[i].keys[k]) != &keys[i]) fail_msg("%s means two things", keys[i].keys[k]);
        }
    }
}

/* ---- the window ---- */

typedef struct happening {
    const char *what; /* a key to be pressed, "drop", "save" (the file is written again), "wait" or "end" */
    const char *text; /* the file dropped, or what is written */
} happening;

typedef struct test_platform {
    platform face;
    const happening *script;
    uint64_t frames, waits;
    bool up; /* the release of the last key comes next */
    const char *path;
    uint8_t *last, pictures[32]; /* whether the picture changed at step i */
    size_t size, step, steps;
    char title[200];
} test_platform;

static bool poll_test(platform *self, platform_event *out)
{
    test_platform *p = (test_platform *)self;
    const happening *now = &p->script[p->step];
    *out = (platform_event){.kind = PLATFORM_INPUT};
    if (p->up) {
        p->up = false;
        out->input =
            (input_event){.kind = INPUT_KEY, .key = input_key_find(p->script[p->step - 1].what), .down = false};
        return true;
    }
    if (p->frames % 8 != 7) return false; /* seven pictures between two happenings */
    if (strcmp(now->what, "wait") == 0) {
        p->step += ++p->waits % 5 == 0;
        p->frames++;
        return false;
    }
    p->step++;
    p->frames++;
    if (strcmp(now->what, "end") == 0) {
        out->kind = PLATFORM_CLOSE;
    } else if (strcmp(now->what, "drop") == 0) {
        out->kind = PLATFORM_DROP;
        snprintf(out->path, sizeof out->path, "%s", now->text);
    } else if (strcmp(now->what, "save") == 0) {
        assert_true(daft_write_file(p->path, now->text, strlen(now->text), NULL));
        return false;
    } else {
        out->input = (input_event){.kind = INPUT_KEY, .key = input_key_find(now->what), .down = true};
        p->up = true;
    }
    return true;
}

static void size_test(platform *self, int *width, int *height) { (void)self, *width = 160, *height = 90; }
static bool wants_test(platform *self) { return self != NULL; }
static void end_test(platform *self) { ((test_platform *)self)->frames++; }
static uint64_t now_test(platform *self) { return ((test_platform *)self)->frames * 1000000000u / 30; }
static void title_test(platform *self, const char *title)
{
    snprintf(((test_platform *)self)->title, sizeof((test_platform *)self)->title, "%s", title);
}

static bool present_test(platform *self, const daft_image *picture, daft_error *error)
{
    (void)error;
    test_platform *p = (test_platform *)self;
    p->size = 4 * (size_t)daft_image_width(picture) * (size_t)daft_image_height(picture);
    if (!p->last) p->last = calloc(1, p->size);
    const uint8_t *pixels = daft_image_pixels((daft_image *)(uintptr_t)picture);
    if (p->step < COUNT_OF(p->pictures) && memcmp(p->last, pixels, p->size) != 0) p->pictures[p->step] = 1;
    memcpy(p->last, pixels, p->size);
    return true;
}

typedef struct bench {
    daft_engine *engine;
    font *face;
    char folder[64], scene[128];
} bench;

static const char *const HELLO = "camera 0 1 0\nsun 1 -2 0.5 1 1 1\nsphere 5 0 0 1 red.mtl\nsphere 6 0 2 1 red.mtl\n";

static void put(const bench *b, const char *name, const char *text)
{
    char path[200];
    snprintf(path, sizeof path, "%s/%s", b->folder, name);
    assert_true(daft_write_file(path, text, strlen(text), NULL));
}

static int set_up(void **state)
{
    static bench b;
    b = (bench){.folder = "/tmp/daft-view-XXXXXX"};
    daft_engine_def def = daft_default_engine_def();
    def.threads = 2;
    b.engine = daft_engine_create(&def, NULL);
    b.face = font_open(NULL, NULL, DAFT_ROOT "/assets/fonts/daft.ttf", "daft.ttf", NULL);
    if (!b.engine || !b.face || !mkdtemp(b.folder)) return -1;
    snprintf(b.scene, sizeof b.scene, "%s/a.scene", b.folder);
    put(&b, "a.scene", HELLO);
    put(&b, "red.mtl", "newmtl red\nKa 1 0 0\nKd 1 0 0\nKs 1 1 1\nNs 20\n");
    *state = &b;
    return 0;
}

static int tear_down(void **state)
{
    bench *b = *state;
    char command[100];
    font_close(b->face);
    daft_engine_destroy(b->engine);
    snprintf(command, sizeof command, "rm -r %s", b->folder);
    return system(command);
}

/* Plays the script; gives which of its steps changed what is shown. */
static bool play(bench *b, const char *path, const happening *script, test_platform *p, daft_error *error)
{
    *p = (test_platform){.face = {.poll = poll_test,
                                  .get_size = size_test,
                                  .wants_frame = wants_test,
                                  .present = present_test,
                                  .end_frame = end_test,
                                  .now_ns = now_test,
                                  .set_title = title_test},
                         .script = script,
                         .path = b->scene};
    view_def def = {.screen = &p->face,
                    .engine = b->engine,
                    .face = b->face,
                    .path = path,
                    .camera = -1,
                    .quality.preset = DAFT_PRESET_GAME};
    bool good = view_run(&def, error);
    free(p->last);
    return good;
}

static void every_switch_changes_the_picture(void **state)
{
    static const happening script[] = {{"i", 0}, {"i", 0},    {"r", 0},  {"t", 0}, {"y", 0}, {"k", 0},
                                       {"l", 0}, {"x", 0},    {"g", 0},  {"2", 0}, {"3", 0}, {"4", 0},
                                       {"5", 0}, {"6", 0},    {"7", 0},  {"8", 0}, {"1", 0}, {"o", 0},
                                       {"o", 0}, {"home", 0}, {"f1", 0}, {"h", 0}, {"/", 0}, {"end", 0}};
    test_platform p;
    daft_error error;
    bench *b = *state;
    assert_true(play(b, b->scene, script, &p, &error));
    for (size_t i = 1; i + 1 < COUNT_OF(script); i++)
        if (!p.pictures[i]) fail_msg("nothing has changed after %s", script[i - 1].what);
    assert_string_equal(p.title, "DAFT: a.scene");
}

/* What one picture sampled counts in the next. */
static void pictures_follow_each_other(void **state)
{
    static const char SOFT[] = "camera 0 1 0\nambient 0.3 0.3 0.3 2\nlight 3 4 1 1 1 1 radius=0.5\n"
                               "sphere 5 0 0 1 red.mtl\nsphere 6 0 2 1 red.mtl\n";
    bench *b = *state;
    daft_error error;
    put(b, "soft.scene", SOFT);
    char path[200];
    snprintf(path, sizeof path, "%s/soft.scene", b->folder);
    daft_scene *scene = daft_scene_create(b->engine, &error);
    daft_image *picture = daft_image_create(b->engine, 160, 90, &error);
    static uint8_t before[4 * 160 * 90];
    view_look look = {.camera = daft_default_camera(), .quality.preset = DAFT_PRESET_GAME};
    assert_true(scene && picture && daft_scene_load(scene, path, &error));
    look.camera = daft_scene_camera(scene, 1);
    for (int with = 0; with < 2; with++) {
        pixel_channels channels = {.history = with ? daft_history_create(b->engine, &error) : NULL};
        for (int i = 0; i < 3; i++) {
            assert_true(draw_scene(scene, &look, &channels, picture, &error));
            const bool same = memcmp(before, daft_image_pixels(picture), sizeof before) == 0;
            assert_true(i == 0 || same == !with);
            memcpy(before, daft_image_pixels(picture), sizeof before);
        }
        draw_free(&channels);
        daft_history_destroy(channels.history);
    }
    daft_image_destroy(picture);
    daft_scene_destroy(scene);
}

static void escape_leaves(void **state)
{
    static const happening script[] = {{"escape", 0}, {"end", 0}};
    test_platform p;
    daft_error error;
    assert_true(play(*state, ((bench *)*state)->scene, script, &p, &error));
    assert_int_equal(p.step, 1);
}

static void a_saved_file_is_loaded_again(void **state)
{
    static const happening script[] = {
        {"wait", 0}, {"save", "camera 0 1 0\nlight 0 3 0 1 1 1\nsphere 4 0 0 3 red.mtl\n"},
        {"wait", 0}, {"save", "camera 0 1 0\nsphere 4 0 0\n"},
        {"wait", 0}, {"end", 0}};
    test_platform p;
    daft_error error;
    bench *b = *state;
    assert_true(play(b, b->scene, script, &p, &error));
    assert_true(p.pictures[2] && p.pictures[4]); /* the other ball; the message that a value is missing */
}

/* Until a job has ended; its verdict. */
static bool wait_for(job *made, daft_error *error)
{
    while (!job_has_ended(made)) usleep(1000);
    return job_close(made, error);
}

static job_def snapshot_of(const bench *b, const char *name)
{
    job_def def = {.width = 96, .height = 64, .view = daft_default_view(), .threads = 2};
    snprintf(def.scene, sizeof def.scene, "%s", b->scene);
    snprintf(def.out, sizeof def.out, "%s/%s", b->folder, name);
    def.view.quality = daft_preset_quality(DAFT_PRESET_HIGH);
    def.view.camera = daft_camera_look_at((daft_dvec3){-1.1, 1.0 / 3, 0.7}, (daft_dvec3){5, 0, 1}, 0.9f);
    def.view.quality.shadows = 0;
    return def;
}

static void a_snapshot_can_be_repeated_exactly(void **state)
{
    bench *b = *state;
    daft_error error;
    shot again;
    char path[200];
    job_def def = snapshot_of(b, "s.png");
    job *made = job_start(&def, &error);
    assert_true(made && wait_for(made, &error));
    daft_image *picture = daft_image_load(b->engine, def.out, &error), *own;
    assert_non_null(picture);
    snprintf(path, sizeof path, "%s/s.json", b->folder);
    if (!shot_read(&again, path, &error)) fail_msg("%d:%d: %s", error.line, error.column, error.message);
    assert_true(again.width == 96 && again.height == 64 && again.view.quality.shadows == 0);
    assert_memory_equal(&again.view.camera, &def.view.camera, sizeof again.view.camera);
    daft_scene *scene = daft_scene_create(b->engine, &error);
    assert_true(daft_scene_load(scene, again.scene, &error));
    own = daft_image_create(b->engine, again.width, again.height, &error);
    assert_true(daft_render(scene, &again.view, own, &error));
    assert_memory_equal(daft_image_pixels(own), daft_image_pixels(picture), 4 * 96 * 64);
    daft_image_destroy(own), daft_image_destroy(picture);
    daft_scene_destroy(scene);
}

static void a_cancelled_snapshot_leaves_nothing(void **state)
{
    bench *b = *state;
    daft_error error;
    job_def def = snapshot_of(b, "c.png");
    def.width = def.height = 4096;
    job *made = job_start(&def, &error);
    assert_non_null(made);
    job_cancel(made);
    assert_false(wait_for(made, &error));
    assert_int_equal(error.code, DAFT_ERROR_CANCELLED);
    assert_true(access(def.out, F_OK) != 0);
    snprintf(def.scene, sizeof def.scene, "%s/nothing.scene", b->folder);
    made = job_start(&def, &error);
    assert_false(wait_for(made, &error));
    assert_non_null(strstr(error.file, "nothing.scene"));
}

/* Each mistake in a snapshot's file is told with its place. */
static void bad_snapshot_files_are_refused(void **state)
{
    static const struct {
        const char *text, *message;
        int line, column;
    } bad[] = {
        {"", "'{' expected", 1, 1},
        {"{\n \"scene\": \"a.scene\",\n \"width\": 0", "1 to 16384", 3, 12},
        {"{\"scene\": \"a.scene\", \"width\": 7, \"height\": 7, \"colour\": 1}", "unknown name 'colour'", 1, 47},
        {"{\"scene\": \"a.scene\", \"width\": 7}", "height", 1, 33},
        {"{\"width\": 7, \"height\": 7}", "scene", 1, 26},
        {"{\"scene\": \"a.sc", "does not end", 1, 16},
        {"{\"scene\": \"a.scene\" \"width\": 7}", "',' expected", 1, 21},
        {"{\"view\": {\"camera\": {\"fov\": \"wide\"}}}", "fov", 1, 29},
        {"{\"view\": {\"camera\": {\"position\": [1, 2]}}}", "position", 1, 34},
        {"{\"view\": {\"quality\": {\"samples\": 1e9}}}", "samples", 1, 34},
        {"{\"view\": {\"aov\": 1}}", "unknown name 'aov'", 1, 11},
        {"{\"scene\": \"a.scene\", \"width\": 7, \"height\": 7} x", "the end of the file", 1, 47},
    };
    bench *b = *state;
    char path[200];
    int others = 0;
    snprintf(path, sizeof path, "%s/bad.json", b->folder);
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        daft_error error = {0};
        shot out;
        put(b, "bad.json", bad[i].text);
        assert_false(shot_read(&out, path, &error));
        if (strstr(error.message, bad[i].message) && error.line == bad[i].line && error.column == bad[i].column)
            continue;
        print_message("%s: %d:%d: %s\n", bad[i].text, error.line, error.column, error.message);
        others++;
    }
    assert_int_equal(others, 0);
}

/* Snapshots that are cut off or have a byte changed are read or refused, and nothing else. */
static void damaged_snapshots_do_no_harm(void **state)
{
    bench *b = *state;
    daft_error error;
    char path[200];
    size_t size;
    shot how = {.width = 10, .height = 20, .view = daft_default_view()};
    snprintf(how.scene, sizeof how.scene, "a \"scene\"\n.scene");
    snprintf(path, sizeof path, "%s/d.json", b->folder);
    assert_true(shot_write(&how, path, &error));
    char *text = daft_read_file(NULL, path, &size, &error);
    uint64_t random = 12345;
    print_message("seed %llu\n", (unsigned long long)random);
    for (int i = 0; i < 3000; i++) {
        shot out;
        random = random * 6364136223846793005u + 1442695040888963407u;
        char *copy = strdup(text);
        copy[(random >> 33) % size] = (char)(random >> 24 & 0x7f);
        if (i % 3 == 0) copy[(random >> 45) % size] = 0;
        put(b, "d.json", copy);
        if (shot_read(&out, path, &error)) assert_true(out.width >= 1 && out.width <= 16384 && out.scene[0]);
        free(copy);
    }
    free(text);
}

/* Keys of the window: a snapshot, its size, and a film with too few checkpoints. */
static void keys_make_pictures_beside_the_window(void **state)
{
    static const happening script[] = {{"b", 0},    {"u", 0},    {"u", 0},    {"p", 0},
                                       {"wait", 0}, {"wait", 0}, {"wait", 0}, {"end", 0}};
    bench *b = *state;
    test_platform p;
    daft_error error;
    char before[1000];
    assert_non_null(getcwd(before, sizeof before));
    assert_int_equal(chdir(b->folder), 0);
    assert_true(play(b, "a.scene", script, &p, &error));
    assert_int_equal(chdir(before), 0);
    for (size_t i = 1; i < 5; i++)
        if (!p.pictures[i]) fail_msg("nothing has changed after %s", script[i - 1].what);
}

/* ---- the camera path ---- */

static daft_scene *load(bench *b, const char *path)
{
    daft_error error;
    daft_scene *scene = daft_scene_create(b->engine, &error);
    if (!daft_scene_load(scene, path, &error)) fail_msg("%d:%d: %s", error.line, error.column, error.message);
    return scene;
}

static void a_path_is_saved_into_the_scene(void **state)
{
    static const happening script[] = {{"v", 0}, {"home", 0}, {"v", 0},      {".", 0}, {"backspace", 0},
                                       {"v", 0}, {"v", 0},    {"delete", 0}, {"c", 0}, {"end", 0}};
    test_platform p;
    daft_error error;
    daft_checkpoint first, second, third;
    bench *b = *state;
    put(b, "a.scene",
        "camera 0 1 0 10 20 70\n# a remark\npath 0 9 9 9 0 0\nsphere 5 0 0 1 red.mtl\n  path 3 1 1 1 0 0");
    assert_true(play(b, b->scene, (happening[]){{"delete", 0}, {"delete", 0}, {"c", 0}, {"end", 0}}, &p, &error));
    assert_true(play(b, b->scene, script, &p, &error));
    char *text = daft_read_file(NULL, b->scene, NULL, &error);
    assert_non_null(text);
    assert_non_null(strstr(text, "camera 0 1 0 10 20 70\n# a remark\nsphere 5 0 0 1 red.mtl\npath 0 "));
    free(text);
    daft_scene *scene = load(b, b->scene);
    assert_int_equal(daft_scene_path_count(scene), 3);
    assert_true(daft_scene_get_checkpoint(scene, 0, &first, &error) &&
                daft_scene_get_checkpoint(scene, 1, &second, &error) &&
                daft_scene_get_checkpoint(scene, 2, &third, &error));
    assert_true(first.time == 0 && second.time >= 1 && third.time > second.time);
    assert_true(apart(first.camera.position, (daft_dvec3){0, 1, 0}) < 1e-12);
    assert_true(fabsf(first.camera.yaw - 0.34906585f) < 1e-6f && fabsf(first.camera.fov - 1.2217305f) < 1e-6f);
    daft_scene_destroy(scene);
}

static void a_path_that_stands_elsewhere_is_left_alone(void **state)
{
    daft_error error;
    bench *b = *state;
    route r = {0};
    put(b, "part.scene", "path 0 9 9 9 0 0\npath 1 2 9 9 0 0\n");
    put(b, "a.scene", "include part.scene\n");
    daft_scene *scene = load(b, b->scene);
    daft_camera camera = daft_default_camera();
    assert_true(route_load(&r, scene, &error) && r.count == 2 && route_add(&r, &camera, 1, &error));
    assert_false(route_save(&r, scene, b->scene, &error));
    assert_true(r.unsaved && strstr(error.message, "includes"));
    assert_false(route_save(&r, scene, DAFT_ROOT "/assets/meshes/cup.obj", &error));
    daft_scene_destroy(scene);
    route_free(&r);
}

static void times_ascend_whatever_is_done(void **unused)
{
    (void)unused;
    daft_error error;
    daft_camera camera = daft_default_camera();
    route r = {0};
    for (int i = 0; i < 5; i++) {
        camera.position.x = 10 * (i % 2);
        assert_true(route_add(&r, &camera, 2, &error));
    }
    assert_true(r.points[0].time == 0 && fabs(r.points[1].time - 5) < 1e-9);
    for (int i = 0; i < 30; i++) route_delay(&r, 2, -0.5);
    route_delay(&r, 0, 7);
    route_remove(&r, 0);
    assert_true(r.count == 4 && r.points[0].time == 0);
    for (uint32_t i = 1; i < r.count; i++) assert_true(r.points[i].time > r.points[i - 1].time);
    while (r.count > 0) route_remove(&r, r.count - 1);
    route_remove(&r, 0);
    route_free(&r);
}

static void what_is_dropped_is_opened(void **state)
{
    static const happening script[] = {{"drop", DAFT_ROOT "/assets/meshes/cup.obj"},
                                       {"drop", DAFT_ROOT "/assets/textures/checker.png"},
                                       {"home", 0},
                                       {"drop", "/nowhere/at/all.scene"},
                                       {"wait", 0},
                                       {"end", 0}};
    test_platform p;
    daft_error error;
    bench *b = *state;
    assert_true(play(b, b->scene, script, &p, &error));
    assert_true(p.pictures[1] && p.pictures[2] && p.pictures[4]);
    assert_string_equal(p.title, "DAFT: checker.png");
}

static void what_cannot_be_opened_is_told(void **state)
{
    static const happening script[] = {{"end", 0}};
    test_platform p;
    daft_error error;
    bench *b = *state;
    put(b, "bad.scene", "camera 0 0 0\nlihgt 1 2 3\n");
    char path[200];
    snprintf(path, sizeof path, "%s/bad.scene", b->folder);
    assert_false(play(b, path, script, &p, &error));
    assert_int_equal(error.line, 2);
    assert_false(play(b, DAFT_ROOT "/README.md", script, &p, &error));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flying_goes_as_fast_as_it_says),
        cmocka_unit_test(nobody_looks_over_the_top),
        cmocka_unit_test(turning_keeps_the_distance_and_the_place_in_the_picture),
        cmocka_unit_test(rays_go_through_their_pixels),
        cmocka_unit_test(every_key_is_told_once),
        cmocka_unit_test_setup_teardown(every_switch_changes_the_picture, set_up, tear_down),
        cmocka_unit_test_setup_teardown(pictures_follow_each_other, set_up, tear_down),
        cmocka_unit_test_setup_teardown(escape_leaves, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_saved_file_is_loaded_again, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_snapshot_can_be_repeated_exactly, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_cancelled_snapshot_leaves_nothing, set_up, tear_down),
        cmocka_unit_test_setup_teardown(bad_snapshot_files_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(damaged_snapshots_do_no_harm, set_up, tear_down),
        cmocka_unit_test_setup_teardown(keys_make_pictures_beside_the_window, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_path_is_saved_into_the_scene, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_path_that_stands_elsewhere_is_left_alone, set_up, tear_down),
        cmocka_unit_test(times_ascend_whatever_is_done),
        cmocka_unit_test_setup_teardown(what_is_dropped_is_opened, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_cannot_be_opened_is_told, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
