/* render: what a picture tells of each pixel beside its colour. Depth, normals and ids are compared with the slow path
 * in test_render. */
#include "daft.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 200, HEIGHT = 136, PIXELS = WIDTH * HEIGHT };

typedef struct channels {
    float depth[PIXELS];
    daft_vec3 color[PIXELS], albedo[PIXELS];
    daft_vec2 motion[PIXELS];
    uint32_t cost[PIXELS];
    daft_entity entity[PIXELS];
} channels;

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    channels out;
} stage;

static stage *stage_make(const char *file)
{
    stage *s = calloc(1, sizeof *s);
    assert_non_null(s);
    daft_engine_def def = daft_default_engine_def();
    daft_error error = {0};
    char path[512];
    def.threads = 2;
    assert_non_null(s->engine = daft_engine_create(&def, &error));
    assert_non_null(s->scene = daft_scene_create(s->engine, &error));
    assert_non_null(s->image = daft_image_create(s->engine, WIDTH, HEIGHT, &error));
    s->view = daft_default_view();
    channels *o = &s->out;
    s->view.aov = (daft_aov){.depth = o->depth,
                             .entity = o->entity,
                             .color = o->color,
                             .albedo = o->albedo,
                             .motion = o->motion,
                             .cost = o->cost};
    if (!file) return s;
    snprintf(path, sizeof path, "%s/assets/scenes/%s", DAFT_ROOT, file);
    if (!daft_scene_load(s->scene, path, &error)) fail_msg("%s", error.message);
    assert_true(daft_scene_get_camera(s->scene, 0, &s->view.camera, &error));
    return s;
}

static void stage_drop(stage *s)
{
    daft_history_destroy(s->view.history);
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
    free(s);
}

static const uint8_t *draw(stage *s)
{
    daft_error error = {0};
    if (!daft_render(s->scene, &s->view, s->image, &error)) fail_msg("%s", error.message);
    return daft_image_pixels(s->image);
}

static int encoded(float light)
{
    const double x = fmin(1, fmax(0, (double)light));
    return (int)(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055) + 0.5);
}

static void assert_is_picture(const daft_vec3 *light, const uint8_t *rgba)
{
    for (int i = 0; i < PIXELS; i++) {
        const float own[3] = {light[i].x, light[i].y, light[i].z};
        for (int c = 0; c < 3; c++)
            if (abs(encoded(own[c]) - rgba[4 * i + c]) > 1)
                fail_msg("pixel %d: %d is not %d", i, encoded(own[c]), rgba[4 * i + c]);
    }
}

/* The sky too, in tiles that see nothing else; and where there are mirrors. */
static void color_is_the_picture_before_it_is_bytes(void **unused)
{
    (void)unused;
    const char *files[] = {"hello.scene", "temple.scene", NULL};
    for (int i = 0; i < 3; i++) {
        stage *s = stage_make(files[i]);
        s->view.quality.edge_samples = 0;
        assert_is_picture(s->out.color, draw(s));
        stage_drop(s);
    }
    /* the mean of samples, where none is brighter than a picture can show */
    stage *s = stage_make("islands.scene");
    s->view.quality.samples = 4, s->view.quality.edge_samples = 0, s->view.without = DAFT_WITHOUT_SHADING;
    assert_is_picture(s->out.color, draw(s));
    stage_drop(s);
}

/* A surface in its own colour is what a picture without shading shows. */
static void albedo_is_the_picture_without_light(void **unused)
{
    (void)unused;
    stage *s = stage_make("temple.scene"), *plain = stage_make("temple.scene");
    plain->view.without = DAFT_WITHOUT_SHADING, plain->view.quality.edge_samples = s->view.quality.edge_samples = 0;
    const uint8_t *rgba = draw(plain);
    int colors = 0;
    draw(s);
    for (int i = 0; i < PIXELS; i++) {
        const float own[3] = {s->out.albedo[i].x, s->out.albedo[i].y, s->out.albedo[i].z};
        const bool sky = s->out.entity[i].id == 0;
        for (int c = 0; c < 3; c++) assert_true(sky ? own[c] == 0 : abs(encoded(own[c]) - rgba[4 * i + c]) <= 1);
        colors += !sky && own[0] != own[2];
    }
    assert_true(colors > PIXELS / 10);
    stage_drop(s);
    stage_drop(plain);
}

/* Every ray that the counters know is some pixel's. */
static void cost_is_all_rays(void **unused)
{
    (void)unused;
    const char *files[] = {"hello.scene", "glass.scene"};
    const int edges[] = {0, 4, 16};
    for (int i = 0; i < 6; i++) {
        stage *s = stage_make(files[i / 3]);
        s->view.quality.edge_samples = edges[i % 3], s->view.quality.shadows = 0;
        draw(s);
        const daft_counters *c = daft_scene_counters(s->scene);
        uint64_t sum = 0;
        for (int k = 0; k < PIXELS; k++) sum += s->out.cost[k];
        assert_int_equal(sum, c->camera_rays + c->reflection_rays + c->refraction_rays);
        assert_true(sum > PIXELS);
        s->view.quality.shadows = 1, s->view.quality.edge_samples = 0;
        draw(s);
        uint64_t more = 0;
        for (int k = 0; k < PIXELS; k++) more += s->out.cost[k];
        assert_true(more > sum || edges[i % 3]);
        stage_drop(s);
    }
}

/* ---- motion ---- */

/* The pixel where a camera sees a point; false: behind it. In double, by the angles alone. */
static bool project(const daft_camera *camera, daft_dvec3 point, double *x, double *y)
{
    const double cy = cos(camera->yaw), sy = sin(camera->yaw), cp = cos(camera->pitch), sp = sin(camera->pitch);
    const double f[3] = {cp * cy, -sp, cp * sy}, r[3] = {-sy, 0, cy},
                 u[3] = {r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2], r[0] * f[1] - r[1] * f[0]};
    const double d[3] = {point.x - camera->position.x, point.y - camera->position.y, point.z - camera->position.z};
    double along = 0, across = 0, above = 0, focal = WIDTH / 2.0 / tan((double)camera->fov / 2);
    for (int k = 0; k < 3; k++) along += d[k] * f[k], across += d[k] * r[k], above += d[k] * u[k];
    *x = WIDTH / 2.0 + across / along * focal, *y = HEIGHT / 2.0 - above / along * focal;
    return along > 0;
}

static daft_dvec3 point_of(const daft_camera *c, int pixel, double depth)
{
    const double cy = cos(c->yaw), sy = sin(c->yaw), cp = cos(c->pitch), sp = sin(c->pitch);
    const double f[3] = {cp * cy, -sp, cp * sy}, r[3] = {-sy, 0, cy},
                 u[3] = {r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2], r[0] * f[1] - r[1] * f[0]};
    const double x = pixel % WIDTH + 0.5 - WIDTH / 2.0, y = HEIGHT / 2.0 - pixel / WIDTH - 0.5,
                 z = WIDTH / 2.0 / tan((double)c->fov / 2), length = sqrt(x * x + y * y + z * z);
    double p[3];
    for (int k = 0; k < 3; k++) p[k] = (r[k] * x + u[k] * y + f[k] * z) / length * depth;
    return (daft_dvec3){c->position.x + p[0], c->position.y + p[1], c->position.z + p[2]};
}

static void remember(stage *s)
{
    daft_error error = {0};
    assert_non_null(s->view.history = daft_history_create(s->engine, &error));
    draw(s);
    for (int i = 0; i < PIXELS; i++) assert_true(s->out.motion[i].x == 0 && s->out.motion[i].y == 0);
}

static void what_stands_still_moves_with_the_camera(void **unused)
{
    (void)unused;
    stage *s = stage_make("temple.scene");
    remember(s);
    draw(s);
    for (int i = 0; i < PIXELS; i++) assert_true(s->out.motion[i].x == 0 && s->out.motion[i].y == 0);
    const daft_camera before = s->view.camera;
    daft_camera *now = &s->view.camera;
    now->position.x += 0.3, now->position.y += 0.1, now->position.z -= 0.2, now->yaw += 0.02f, now->pitch -= 0.01f;
    now->fov *= 0.97f;
    draw(s);
    double worst = 0, most = 0;
    for (int i = 0; i < PIXELS; i++) {
        double x, y;
        const double depth = (double)s->out.depth[i];
        daft_dvec3 point = point_of(now, i, isinf(depth) ? 1 : depth);
        if (isinf(depth)) /* a direction: it has no parallax */
            point.x += before.position.x - now->position.x, point.y += before.position.y - now->position.y,
                point.z += before.position.z - now->position.z;
        assert_true(project(&before, point, &x, &y));
        const double dx = i % WIDTH + 0.5 - x, dy = i / WIDTH + 0.5 - y;
        worst = fmax(worst, hypot(dx - (double)s->out.motion[i].x, dy - (double)s->out.motion[i].y));
        most = fmax(most, hypot(dx, dy));
    }
    print_message("up to %.1f pixels, off by %.5f at most\n", most, worst);
    assert_true(most > 5 && worst < 0.01);
    daft_history_forget(s->view.history);
    now->yaw += 0.1f;
    draw(s);
    for (int i = 0; i < PIXELS; i++) assert_true(s->out.motion[i].x == 0 && s->out.motion[i].y == 0);
    stage_drop(s);
}

/* A ball that is moved, among others that come and go. */
static void what_moves_tells_how_far(void **unused)
{
    (void)unused;
    stage *s = stage_make(NULL);
    daft_error error = {0};
    daft_entity_def ball = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE, ball.radius = 0.5f;
    daft_entity balls[3];
    for (int i = 0; i < 3; i++) {
        ball.position = (daft_dvec3){5, 0, 2 * (i - 1)};
        balls[i] = daft_entity_create(s->scene, &ball, &error);
    }
    remember(s);
    daft_entity_destroy(s->scene, balls[0], NULL);
    ball.position = (daft_dvec3){5, 1.4, 0};
    const daft_entity fresh = daft_entity_create(s->scene, &ball, &error);
    const daft_transform to = {.position = {4, 0.5, 0.2}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    assert_true(daft_entity_set_transform(s->scene, balls[1], &to, true, &error));
    draw(s);
    int moved = 0, others = 0, new_ones = 0;
    for (int i = 0; i < PIXELS; i++) {
        const double mx = (double)s->out.motion[i].x, my = (double)s->out.motion[i].y;
        if (s->out.entity[i].id != balls[1].id) {
            assert_true(mx == 0 && my == 0);
            others += s->out.entity[i].id == balls[2].id, new_ones += s->out.entity[i].id == fresh.id;
            continue;
        }
        double x, y;
        daft_dvec3 point = point_of(&s->view.camera, i, (double)s->out.depth[i]);
        point.x += 1, point.y -= 0.5, point.z -= 0.2;
        assert_true(project(&s->view.camera, point, &x, &y));
        assert_true(hypot(i % WIDTH + 0.5 - x - mx, i / WIDTH + 0.5 - y - my) < 0.01);
        moved++;
    }
    assert_true(moved > 100 && others > 100 && new_ones > 100);
    stage_drop(s);
}

static void bands_are_the_whole(void **unused)
{
    (void)unused;
    stage *whole = stage_make("islands.scene"), *s = stage_make("islands.scene");
    stage *both[2] = {whole, s};
    for (int i = 0; i < 2; i++) remember(both[i]), both[i]->view.camera.yaw += 0.05f;
    draw(whole);
    for (int row = 0; row < HEIGHT; row += 32) {
        s->view.first_row = row, s->view.row_count = row + 32 < HEIGHT ? 32 : 0;
        draw(s);
    }
    assert_memory_equal(whole->out.depth, s->out.depth, sizeof s->out.depth);
    assert_memory_equal(whole->out.color, s->out.color, sizeof s->out.color);
    assert_memory_equal(whole->out.albedo, s->out.albedo, sizeof s->out.albedo);
    assert_memory_equal(whole->out.motion, s->out.motion, sizeof s->out.motion);
    assert_memory_equal(whole->out.cost, s->out.cost, sizeof s->out.cost);
    stage_drop(whole);
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(color_is_the_picture_before_it_is_bytes),
                                       cmocka_unit_test(albedo_is_the_picture_without_light),
                                       cmocka_unit_test(cost_is_all_rays),
                                       cmocka_unit_test(what_stands_still_moves_with_the_camera),
                                       cmocka_unit_test(what_moves_tells_how_far),
                                       cmocka_unit_test(bands_are_the_whole)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
