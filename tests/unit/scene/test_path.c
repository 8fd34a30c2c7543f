/* scene: camera paths: through the checkpoints, smooth, without flips, at the pace that was asked for. */
#include "daft.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "math/vec.h"
#include "scene/scene.h"

#define PI 3.14159265358979

static daft_checkpoint point(double x, double y, double z, double pitch, double yaw, double time)
{
    daft_checkpoint made = {.camera = daft_default_camera(), .time = time};
    made.camera.position = daft_dv3(x, y, z);
    made.camera.pitch = (float)(pitch * PI / 180);
    made.camera.yaw = (float)(yaw * PI / 180);
    return made;
}

static daft_camera at(const daft_checkpoint *points, uint32_t count, daft_pace pace, double time)
{
    daft_camera camera;
    daft_error error;
    if (!daft_path_camera(points, count, pace, time, &camera, &error)) fail_msg("%s", error.message);
    return camera;
}

static double apart(daft_dvec3 a, daft_dvec3 b)
{
    daft_dvec3 d = daft_dsub(a, b);
    return sqrt(daft_ddot(d, d));
}

static const char *const PACES[] = {"timed", "constant", "eased"};

static void it_goes_through_its_checkpoints(void **unused)
{
    (void)unused;
    daft_checkpoint points[] = {point(0, 1, 0, 0, 0, 0), point(5, 2, 1, 10, 90, 1), point(6, 1, 9, -20, 200, 4),
                                point(-3, 4, 2, 60, 350, 4.5)};
    for (uint32_t i = 0; i < 4; i++) {
        daft_camera here = at(points, 4, DAFT_PACE_TIMED, points[i].time);
        assert_memory_equal(&here, &points[i].camera, sizeof here);
    }
    for (int pace = 0; pace < 3; pace++) {
        daft_camera first = at(points, 4, (daft_pace)pace, -5), last = at(points, 4, (daft_pace)pace, 99);
        assert_memory_equal(&first, &points[0].camera, sizeof first);
        assert_memory_equal(&last, &points[3].camera, sizeof last);
    }
}

/* The largest steps of place and axes over a path in fine steps: a flip or a jump would stand out. */
static void assert_smooth(const daft_checkpoint *points, uint32_t count, daft_pace pace)
{
    enum { STEPS = 20000 };
    daft_vec3 axes[3], before[3] = {{0}};
    daft_dvec3 place = {0};
    double whole = points[count - 1].time - points[0].time, most_turn = 0, most_way = 0;
    for (int i = 0; i <= STEPS; i++) {
        daft_camera camera = at(points, count, pace, points[0].time + whole * i / STEPS);
        daft_camera_axes(&camera, &axes[0], &axes[1], &axes[2]);
        for (int k = 0; i > 0 && k < 3; k++) {
            daft_vec3 d = daft_sub(axes[k], before[k]);
            most_turn = fmax(most_turn, sqrt((double)daft_dot(d, d)));
        }
        if (i > 0) most_way = fmax(most_way, apart(camera.position, place));
        memcpy(before, axes, sizeof axes);
        place = camera.position;
    }
    if (most_turn > 60.0 / STEPS)
        fail_msg("%s: the axes jump by %g in 1/%d of the path", PACES[pace], most_turn, STEPS);
    if (most_way > 300.0 / STEPS) fail_msg("%s: the camera jumps by %g m", PACES[pace], most_way);
}

static void it_never_flips(void **unused)
{
    (void)unused;
    /* Over the head, straight up and straight down, several turns, half turns. */
    daft_checkpoint over[] = {point(0, 0, 0, -60, 0, 0),  point(1, 0, 0, -90, 0, 1),  point(2, 0, 0, -60, 180, 2),
                              point(3, 0, 0, 60, 180, 3), point(4, 0, 0, 90, 180, 4), point(5, 0, 0, 60, 0, 5)};
    daft_checkpoint turns[] = {point(0, 0, 0, 0, 170, 0), point(4, 0, 0, 0, -170, 1), point(4, 0, 4, 0, 540, 2),
                               point(0, 9, 4, 0, -720, 3)};
    for (int pace = 0; pace < 3; pace++) {
        assert_smooth(over, 6, (daft_pace)pace);
        assert_smooth(turns, 4, (daft_pace)pace);
    }
    /* From 170 to -170 degrees it turns by 20, not by 340. */
    for (int i = 0; i <= 10; i++) {
        daft_camera camera = at(turns, 2, DAFT_PACE_TIMED, i / 10.0);
        assert_true(cos((double)camera.yaw) < -0.98);
        assert_true(fabs((double)camera.roll) < 1e-6 && fabs((double)camera.pitch) < 1e-6);
    }
}

static void paces_are_what_they_say(void **unused)
{
    (void)unused;
    enum { STEPS = 200 };
    daft_checkpoint points[] = {point(0, 0, 0, 0, 0, 0), point(1, 0, 0, 0, 0, 3), point(20, 0, 5, 0, 0, 4),
                                point(21, 9, 0, 0, 0, 10)};
    double way[STEPS], sum = 0;
    for (int i = 0; i < STEPS; i++) {
        daft_dvec3 a = at(points, 4, DAFT_PACE_CONSTANT, 10.0 * i / STEPS).position;
        daft_dvec3 b = at(points, 4, DAFT_PACE_CONSTANT, 10.0 * (i + 1) / STEPS).position;
        way[i] = apart(a, b);
        sum += way[i];
    }
    for (int i = 0; i < STEPS; i++)
        if (fabs(way[i] * STEPS / sum - 1) > 0.03) fail_msg("step %d: %g of the mean", i, way[i] * STEPS / sum);
    /* Smoothstep: a tenth of the time is 2.8 % of the way. */
    double start = apart(at(points, 4, DAFT_PACE_EASED, 1).position, points[0].camera.position);
    double end = apart(at(points, 4, DAFT_PACE_EASED, 9).position, points[3].camera.position);
    assert_true(fabs(start / sum - 0.028) < 0.002);
    assert_true(fabs(end / sum - 0.028) < 0.004);
}

static void standing_still_is_a_path(void **unused)
{
    (void)unused;
    daft_checkpoint points[] = {point(1, 2, 3, 4, 5, 0), point(1, 2, 3, 4, 5, 2), point(1, 2, 3, 4, 5, 3)};
    for (int pace = 0; pace < 3; pace++)
        for (uint32_t count = 1; count <= 3; count++)
            for (double time = -0.5; time < 4; time += 0.125) {
                daft_camera camera = at(points, count, (daft_pace)pace, time);
                assert_true(apart(camera.position, points[0].camera.position) < 1e-12);
                assert_true(fabs((double)camera.yaw - 5 * PI / 180) < 1e-6);
            }
}

static void nonsense_is_refused(void **unused)
{
    (void)unused;
    daft_checkpoint points[] = {point(0, 0, 0, 0, 0, 1), point(0, 0, 0, 0, 0, 1)};
    daft_camera camera;
    daft_error error;
    assert_false(daft_path_camera(points, 2, DAFT_PACE_TIMED, 0, &camera, &error));
    assert_non_null(strstr(error.message, "checkpoint 1"));
    assert_false(daft_path_camera(points, 0, DAFT_PACE_TIMED, 0, &camera, &error));
    assert_false(daft_path_camera(NULL, 1, DAFT_PACE_TIMED, 0, &camera, &error));
    assert_false(daft_path_camera(points, 1, DAFT_PACE_TIMED, 0, NULL, &error));
    assert_false(daft_path_camera(points, 1, DAFT_PACE_TIMED, (double)NAN, &camera, &error));
    assert_false(daft_path_camera(points, 1, (daft_pace)7, 0, &camera, &error));
    points[0].camera.fov = 9;
    assert_false(daft_path_camera(points, 1, DAFT_PACE_TIMED, 0, &camera, &error));
    points[0].camera.fov = 1, points[0].time = (double)INFINITY;
    assert_false(daft_path_camera(points, 1, DAFT_PACE_TIMED, 0, &camera, &error));
}

static bool load_text(daft_scene *scene, const char *text, daft_error *error)
{
    char path[] = "/tmp/daft-path-XXXXXX.scene";
    int file = mkstemps(path, 6);
    assert_true(file >= 0);
    assert_int_equal(write(file, text, strlen(text)), strlen(text));
    close(file);
    bool loaded = daft_scene_load(scene, path, error);
    unlink(path);
    return loaded;
}

static void scene_files_name_checkpoints(void **unused)
{
    (void)unused;
    static const struct {
        const char *text, *says;
        int line, column;
    } wrong[] = {{"path 0 1 2 3 4\n", "yaw", 1, 15},
                 {"path -1 1 2 3 4 5\n", "seconds", 1, 6},
                 {"path 1 1 2 3 4 5\npath 1 0 0 0 0 0\n", "must come after the one before it, at 1 s", 2, 1},
                 {"path 2 0 0 0 0 0 180\n", "fov", 1, 18},
                 {"path 2 0 0 0 0 0 90 7\n", "", 1, 21}};
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    assert_non_null(engine);
    daft_scene *scene = daft_scene_create(engine, &error);
    assert_non_null(scene);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_false(load_text(scene, wrong[i].text, &error));
        if (!strstr(error.message, wrong[i].says)) fail_msg("'%s': %s", wrong[i].says, error.message);
        assert_int_equal(error.line, wrong[i].line);
        assert_int_equal(error.column, wrong[i].column);
        assert_int_equal(daft_scene_path_count(scene), 0);
    }
    daft_checkpoint read;
    assert_true(load_text(scene, "path 0.5 1 2 3 10 -20\npath 2 4 5 6 0 0 60 roll=5\n", &error));
    assert_int_equal(daft_scene_path_count(scene), 2);
    assert_true(daft_scene_get_checkpoint(scene, 0, &read, &error));
    assert_true(read.time == 0.5 && read.camera.position.z == 3 && fabs((double)read.camera.yaw + PI / 9) < 1e-6);
    assert_true(daft_scene_get_checkpoint(scene, 1, &read, &error));
    assert_true(fabs((double)read.camera.fov - PI / 3) < 1e-6 && fabs((double)read.camera.roll - PI / 36) < 1e-6);
    assert_false(daft_scene_get_checkpoint(scene, 2, &read, &error));
    /* A second file goes on where the first ended. */
    assert_false(load_text(scene, "path 1 0 0 0 0 0\n", &error));
    assert_true(load_text(scene, "path 3 0 0 0 0 0\n", &error));
    assert_int_equal(daft_scene_path_count(scene), 3);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_goes_through_its_checkpoints),
        cmocka_unit_test(it_never_flips),
        cmocka_unit_test(paces_are_what_they_say),
        cmocka_unit_test(standing_still_is_a_path),
        cmocka_unit_test(nonsense_is_refused),
        cmocka_unit_test(scene_files_name_checkpoints),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
