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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_goes_through_its_checkpoints),
        cmocka_unit_test(it_never_flips),
        cmocka_unit_test(paces_are_what_they_say),
        cmocka_unit_test(standing_still_is_a_path),
        cmocka_unit_test(nonsense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
