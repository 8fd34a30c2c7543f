/* Anisotropic filters against the truth: textures at a flat angle, seen directly, in a planar mirror and on a ball,
 * compared with 1,024 samples of each pixel that are worked out here, in double, from the full image. */
#include "daft.h"

#include "image/image.h"
#include "math/vec.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

enum { WIDTH = 160, HEIGHT = 90, PIXELS = WIDTH * HEIGHT, GRID = 32, WALL = 8, HALF = 90, RADIUS = 4 };

typedef enum sight { FLOOR, MIRROR, BALL } sight;

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    sight what;
    daft_dvec3 forward, right, up;
    daft_texture_data texture;
    daft_vec3 color[PIXELS];
} stage;

/* ---- the scene ---- */

static void add_quad(const stage *s, const daft_vec3 corners[4], daft_material material)
{
    static const daft_vec2 uvs[4] = {{-HALF, -HALF}, {-HALF, HALF}, {HALF, HALF}, {HALF, -HALF}}; /* metres */
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    daft_mesh_def def = daft_default_mesh_def();
    daft_entity_def entity = daft_default_entity_def();
    def.positions = corners, def.uvs = uvs, def.vertex_count = 4, def.indices = indices, def.triangle_count = 2;
    entity.shape = DAFT_SHAPE_MESH, entity.mesh = daft_mesh_create(s->scene, &def, NULL), entity.material = material;
    assert_true(daft_entity_create(s->scene, &entity, NULL).id);
}

static daft_material_def plain(void)
{
    daft_material_def def = daft_default_material_def();
    def.ambient = daft_v3(1, 1, 1), def.diffuse = def.specular = daft_v3(0, 0, 0);
    return def;
}

static void add_things(stage *s, const char *path)
{
    static const daft_vec3 floor[4] = {{-HALF, 0, -HALF}, {-HALF, 0, HALF}, {HALF, 0, HALF}, {HALF, 0, -HALF}};
    static const daft_vec3 wall[4] = {{WALL, -1, -HALF}, {WALL, -1, HALF}, {WALL, HALF, HALF}, {WALL, HALF, -HALF}};
    daft_material_def look = plain(), mirror = plain();
    daft_error error;
    look.diffuse_map = daft_texture_load(s->scene, path, &error);
    if (!look.diffuse_map.id) fail_msg("%s", error.message);
    if (s->what == BALL) look.map_scale = (daft_vec2){12, 6};
    const daft_material textured = daft_material_create(s->scene, &look, NULL);
    if (s->what == BALL) {
        daft_entity_def ball = daft_default_entity_def();
        ball.shape = DAFT_SHAPE_SPHERE, ball.radius = RADIUS, ball.material = textured;
        assert_true(daft_entity_create(s->scene, &ball, NULL).id);
        return;
    }
    add_quad(s, floor, textured);
    mirror.ambient = daft_v3(0, 0, 0), mirror.mirror = 1;
    if (s->what == MIRROR) add_quad(s, wall, daft_material_create(s->scene, &mirror, NULL));
}

static stage *stage_make(sight what, const char *path)
{
    stage *s = calloc(1, sizeof *s);
    const daft_allocator allocator = daft_malloc_allocator();
    daft_engine_def def = daft_default_engine_def();
    def.threads = 2;
    s->what = what;
    s->engine = daft_engine_create(&def, NULL);
    s->scene = daft_scene_create(s->engine, NULL);
    s->image = daft_image_create(s->engine, WIDTH, HEIGHT, NULL);
    assert_true(s->scene && s->image && daft_texture_read(&allocator, NULL, path, &s->texture, NULL));
    daft_scene_set_ambient(s->scene, daft_v3(1, 1, 1));
    add_things(s, path);
    s->view = daft_default_view();
    s->view.aov.color = s->color;
    s->view.quality.edge_samples = 0;
    s->view.camera = what == BALL ? daft_camera_look_at(daft_dv3(-6, 7, 3), daft_dv3(1, 1, 0), 0.9f)
                                  : daft_camera_look_at(daft_dv3(0, 1.5, 0), daft_dv3(20, 0, 7), 1);
    const double yaw = (double)s->view.camera.yaw, pitch = (double)s->view.camera.pitch;
    s->forward = daft_dv3(cos(pitch) * cos(yaw), -sin(pitch), cos(pitch) * sin(yaw));
    s->right = daft_dv3(-sin(yaw), 0, cos(yaw)), s->up = daft_dcross(s->right, s->forward);
    return s;
}

static void stage_drop(stage *s)
{
    const daft_allocator allocator = daft_malloc_allocator();
    daft_texture_free(&allocator, &s->texture);
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
    free(s);
}

/* ---- the truth ---- */

static double between(double a, double b, double t) { return a + (b - a) * t; }

/* Linear light of a texel of the full image, which repeats, by a table. */
static double texel_at(const daft_texture_data *t, const float linear[256], int x, int y, int channel)
{
    const int w = t->width[0], h = t->height[0];
    const size_t at = (size_t)((y % h + h) % h) * (size_t)w + (size_t)((x % w + w) % w);
    return (double)linear[t->texels[0][4 * at + (size_t)channel]];
}

static void add_sample(const daft_texture_data *t, const float linear[256], double u, double v, double sum[3])
{
    const double x = (u - floor(u)) * t->width[0] - 0.5, y = (1 - (v - floor(v))) * t->height[0] - 0.5;
    const int x0 = (int)floor(x), y0 = (int)floor(y);
    for (int k = 0; k < 3; k++)
        sum[k] += between(between(texel_at(t, linear, x0, y0, k), texel_at(t, linear, x0 + 1, y0, k), x - x0),
                          between(texel_at(t, linear, x0, y0 + 1, k), texel_at(t, linear, x0 + 1, y0 + 1, k), x - x0),
                          y - y0);
}

/* Where a ray through a place of the picture meets the texture; false: elsewhere, or too far away. */
static bool uv_at(const stage *s, double column, double row, double *u, double *v)
{
    const double focal = WIDTH / 2.0 / tan((double)s->view.camera.fov / 2);
    const daft_dvec3 d = daft_dadd(
                         daft_dadd(daft_dscale(s->right, column - WIDTH / 2.0), daft_dscale(s->up, HEIGHT / 2.0 - row)),
                         daft_dscale(s->forward, focal)),
                     from = s->view.camera.position;
    if (s->what == BALL) {
        const double a = daft_ddot(d, d), b = daft_ddot(from, d), c = daft_ddot(from, from) - RADIUS * RADIUS;
        if (b * b < a * c) return false;
        const daft_dvec3 p = daft_dscale(daft_dadd(from, daft_dscale(d, (-b - sqrt(b * b - a * c)) / a)), 1.0 / RADIUS);
        *u = 12 * (0.5 + atan2(p.z, p.x) / (2 * DAFT_PI)), *v = 6 * (0.5 + asin(p.y) / DAFT_PI);
        return fabs(p.y) < 0.95;
    }
    if (d.y > -1e-3) return false;
    *u = from.x - d.x * from.y / d.y, *v = from.z - d.z * from.y / d.y;
    if (s->what == MIRROR && *u < WALL) return false; /* before the mirror is what the floor's own test sees */
    if (s->what == MIRROR) *u = 2 * WALL - *u;
    return fabs(*u) < 60 && fabs(*v) < 60;
}

/* False: part of the pixel sees something else. */
static bool truth_of(const stage *s, const float linear[256], int x, int y, double out[3])
{
    double sum[3] = {0, 0, 0}, u, v;
    for (int i = 0; i < GRID * GRID; i++) {
        if (!uv_at(s, x + (i % GRID + 0.5) / GRID, y + (i / GRID + 0.5) / GRID, &u, &v)) return false;
        add_sample(&s->texture, linear, u, v, sum);
    }
    for (int k = 0; k < 3; k++) out[k] = sum[k] / (GRID * GRID);
    return true;
}

/* The root of the mean square error of each filter's picture. */
static void measure(stage *s, const daft_texture_filter *filters, int count, double *errors)
{
    static double truth[PIXELS][3];
    float linear[256];
    uint32_t pixels = 0;
    for (int i = 0; i < 256; i++) linear[i] = daft_srgb_to_linear((float)i / 255);
    for (int at = 0; at < PIXELS; at++) {
        const bool some = truth_of(s, linear, at % WIDTH, at / WIDTH, truth[at]);
        if (!some) truth[at][0] = -1;
        pixels += some;
    }
    assert_true(pixels > PIXELS / 8);
    for (int i = 0; i < count; i++) {
        daft_error error;
        s->view.quality.texture_filter = filters[i];
        if (!daft_render(s->scene, &s->view, s->image, &error)) fail_msg("%s", error.message);
        double sum = 0;
        for (int at = 0; at < PIXELS; at++) {
            const double got[3] = {(double)s->color[at].x, (double)s->color[at].y, (double)s->color[at].z};
            for (int k = 0; k < 3 && truth[at][0] >= 0; k++) sum += (got[k] - truth[at][k]) * (got[k] - truth[at][k]);
        }
        errors[i] = sqrt(sum / (3 * pixels));
    }
}

static void errors_fall_from_trilinear_to_4_to_16(void **unused)
{
    (void)unused;
    static const daft_texture_filter filters[] = {DAFT_TEXTURE_TRILINEAR, DAFT_TEXTURE_ANISOTROPIC4,
                                                  DAFT_TEXTURE_ANISOTROPIC16};
    static const char *const names[] = {"floor", "mirror", "ball"};
    static const char *const textures[] = {DAFT_ROOT "/assets/textures/checker.png",
                                           DAFT_ROOT "/assets/textures/cobble.jpg"};
    for (int what = FLOOR; what <= BALL; what++)
        for (int i = 0; i < 2; i++) {
            double e[3];
            stage *s = stage_make((sight)what, textures[i]);
            measure(s, filters, 3, e);
            print_message("%s, texture %d: trilinear %.4f, 4 %.4f, 16 %.4f\n", names[what], i, e[0], e[1], e[2]);
            assert_true(e[1] < 0.9 * e[0] && e[2] < 0.98 * e[1]);
            stage_drop(s);
        }
}

/* Without textures the filter takes no memory, and with them the counters say what they take. */
static void bytes_are_counted(void **unused)
{
    (void)unused;
    stage *s = stage_make(FLOOR, DAFT_ROOT "/assets/textures/checker.png");
    assert_true(daft_render(s->scene, &s->view, s->image, NULL));
    const daft_effect *textures = &daft_scene_counters(s->scene)->effects[DAFT_EFFECT_TEXTURE];
    assert_true(textures->ran && textures->bytes == daft_texture_bytes(&s->texture));
    s->view.quality.texture_filter = DAFT_TEXTURE_ANISOTROPIC16;
    assert_true(daft_render(s->scene, &s->view, s->image, NULL));
    assert_true(textures->bytes > daft_texture_bytes(&s->texture));
    s->view.without = DAFT_WITHOUT_TEXTURES;
    assert_true(daft_render(s->scene, &s->view, s->image, NULL));
    assert_true(!textures->ran && textures->bytes == 0);
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(errors_fall_from_trilinear_to_4_to_16),
                                       cmocka_unit_test(bytes_are_counted)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
