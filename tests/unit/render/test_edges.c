/* render: more samples where pixels differ from their neighbours. That the fast and the slow path, all instruction sets
 * and numbers of threads give the same bytes, test_render shows with the same quality. */
#include "daft.h"
#include "picture_stage.h"
#include "render/kernels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 200, HEIGHT = 136, PIXELS = WIDTH * HEIGHT };

/* The scene of a file, or an empty one, and its first camera. */
static void stage_make(stage *s, const char *file)
{
    daft_engine_def def = daft_default_engine_def();
    daft_error error = {0};
    char path[512];
    def.threads = 2;
    *s = stage_open(&def, WIDTH, HEIGHT);
    if (!file) return;
    snprintf(path, sizeof path, "%s/assets/scenes/%s", DAFT_ROOT, file);
    if (!daft_scene_load(s->scene, path, &error)) fail_msg("%s", error.message);
    assert_true(daft_scene_get_camera(s->scene, 0, &s->view.camera, &error));
}

static double linear(uint8_t byte)
{
    double x = byte / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

/* Root of the mean square of the difference, in linear light. */
static double distance(const uint8_t *a, const uint8_t *b)
{
    double sum = 0;
    for (int i = 0; i < 4 * PIXELS; i++) {
        double gap = linear(a[i]) - linear(b[i]);
        if (i % 4 != 3) sum += gap * gap;
    }
    return sqrt(sum / (3 * PIXELS));
}

/* Against 16 samples of all pixels. What lies behind glass differs everywhere, and is shaded by four. */
static void come_close_to_many_samples(void **unused)
{
    (void)unused;
    static uint8_t truth[4 * PIXELS], none[4 * PIXELS], four[4 * PIXELS], sixteen[4 * PIXELS];
    const char *scenes[] = {"hello.scene", "islands.scene", "glass.scene", "hall.scene"};
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++) {
        stage s;
        stage_make(&s, scenes[i]);
        s.view.quality.samples = 16, s.view.quality.edge_samples = 0, draw(&s, truth);
        s.view.quality.samples = 1, draw(&s, none);
        s.view.quality.edge_samples = 4, draw(&s, four);
        s.view.quality.edge_samples = 16, draw(&s, sixteen);
        double before = distance(none, truth), after[2] = {distance(four, truth), distance(sixteen, truth)};
        print_message("%s: error %.4f, 4: %.4f, 16: %.4f\n", scenes[i], before, after[0], after[1]);
        assert_true(after[0] < before && after[1] < 0.75 * before);
        stage_free(&s);
    }
}

enum { FINER = 4 };

/* The linear light of the pixels, each of 64 samples that read textures as the samples of a finer picture do. */
static void find_truth(const char *scene, float *truth)
{
    stage s;
    stage_make(&s, scene);
    daft_error error = {0};
    daft_image_destroy(s.image);
    s.image = daft_image_create(s.engine, FINER * WIDTH, FINER * HEIGHT, &error);
    s.view.quality = daft_preset_quality(DAFT_PRESET_HIGH);
    s.view.quality.edge_samples = 0, s.view.quality.samples = 4;
    if (!s.image || !daft_render(s.scene, &s.view, s.image, &error)) fail_msg("%s", error.message);
    const uint8_t *rgba = daft_image_pixels(s.image);
    memset(truth, 0, 3 * PIXELS * sizeof *truth);
    for (int y = 0; y < FINER * HEIGHT; y++)
        for (int x = 0; x < FINER * WIDTH; x++)
            for (int c = 0; c < 3; c++)
                truth[3 * (y / FINER * WIDTH + x / FINER) + c] +=
                    (float)linear(rgba[4 * (y * FINER * WIDTH + x) + c]) / (FINER * FINER);
    stage_free(&s);
}

static double distance_from(const uint8_t *rgba, const float *truth)
{
    double sum = 0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        const double gap = linear(rgba[i / 3 * 4 + i % 3]) - (double)truth[i];
        sum += gap * gap;
    }
    return sqrt(sum / (3 * PIXELS));
}

/* Quality high is closer to the truth than four samples of each pixel, of which it was made once, and than game. */
static void high_beats_four_samples(void **unused)
{
    (void)unused;
    static float truth[3 * PIXELS];
    static uint8_t game[4 * PIXELS], high[4 * PIXELS], four[4 * PIXELS];
    const char *scenes[] = {"hello.scene", "islands.scene", "glass.scene", "temple.scene", "hall.scene"};
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++) {
        stage s;
        find_truth(scenes[i], truth);
        stage_make(&s, scenes[i]);
        s.view.quality = daft_preset_quality(DAFT_PRESET_GAME), draw(&s, game);
        s.view.quality = daft_preset_quality(DAFT_PRESET_HIGH), draw(&s, high);
        s.view.quality.edge_samples = 0, s.view.quality.samples = 4, draw(&s, four);
        const double off[3] = {distance_from(high, truth), distance_from(four, truth), distance_from(game, truth)};
        print_message("%s: high %.4f, four samples %.4f, game %.4f\n", scenes[i], off[0], off[1], off[2]);
        assert_true(off[0] < off[1] && off[0] < 0.6 * off[2]);
        stage_free(&s);
    }
}

/* Each row and column of eight holds one of eight samples: nearer to sixteen than four are. */
static void more_samples_come_closer(void **unused)
{
    (void)unused;
    static uint8_t pictures[4][4 * PIXELS];
    const int counts[4] = {16, 1, 4, 8};
    stage s;
    stage_make(&s, "islands.scene");
    s.view.quality.edge_samples = 0;
    for (int i = 0; i < 4; i++) s.view.quality.samples = counts[i], draw(&s, pictures[i]);
    double before = 1;
    for (int i = 1; i < 4; i++) {
        const double now = distance(pictures[i], pictures[0]);
        print_message("%d samples: error %.4f\n", counts[i], now);
        assert_true(now < 0.7 * before);
        before = now;
    }
    stage_free(&s);
}

/* A disc's border: of each pixel, its fraction that the disc covers. */
static void an_outline_is_its_coverage(void **unused)
{
    (void)unused;
    static uint8_t rgba[4 * PIXELS];
    stage s;
    stage_make(&s, NULL);
    daft_scene_set_ambient(s.scene, (daft_vec3){1, 1, 1});
    daft_scene_set_sky_color(s.scene, (daft_vec3){0, 0, 0});
    daft_material_def white = daft_default_material_def();
    white.ambient = (daft_vec3){1, 1, 1}, white.diffuse = white.specular = (daft_vec3){0, 0, 0};
    daft_entity_def ball = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE, ball.radius = 1, ball.position = (daft_dvec3){3, 0, 0};
    ball.material = daft_material_create(s.scene, &white, NULL);
    assert_true(daft_entity_create(s.scene, &ball, NULL).id);
    const double radius = WIDTH / 2.0 / sqrt(8);
    for (int samples = 4; samples <= 16; samples *= 4) {
        s.view.quality.edge_samples = samples;
        draw(&s, rgba);
        double worst = 0;
        int between = 0;
        for (int i = 0; i < PIXELS; i++) {
            int inside = 0;
            for (int k = 0; k < 4096; k++) {
                double x = i % WIDTH + (k % 64 + 0.5) / 64 - WIDTH / 2.0,
                       y = i / WIDTH + (k / 64 + 0.5) / 64 - HEIGHT / 2.0;
                inside += x * x + y * y < radius * radius;
            }
            double light = linear(rgba[4 * i]);
            worst = fmax(worst, fabs(light - inside / 4096.0));
            between += rgba[4 * i] > 0 && rgba[4 * i] < 255;
        }
        print_message("%d samples: off by %.3f at most, %d pixels between\n", samples, worst, between);
        assert_true(between > 150 && worst < (samples == 4 ? 0.4 : 0.12));
    }
    stage_free(&s);
}

/* Where some of a pixel's rays are shaded for all, these lie round its middle: else what bends light or mirrors would
 * seem to be moved by a part of a pixel. */
static void few_samples_lie_round_the_middle(void **unused)
{
    (void)unused;
    uint32_t taken = 0;
    int x = 0, y = 0;
    for (int i = 0; i < DAFT_EDGE_RAYS; i++) {
        taken |= 1u << DAFT_EDGE_ORDER[i];
        x += DAFT_EDGE_ORDER[i] % 4, y += DAFT_EDGE_ORDER[i] / 4;
        if (i % 2) assert_true(2 * x == 3 * (i + 1) && 2 * y == 3 * (i + 1));
        assert_int_equal(taken, DAFT_EDGE_FIRST[i + 1]);
    }
}

/* Along rows and columns, where regular samples do worst: sixteen steps. */
static void straight_edges_have_sixteen_steps(void **unused)
{
    (void)unused;
    static uint8_t rgba[4 * PIXELS];
    stage s;
    daft_error error = {0};
    stage_make(&s, NULL);
    daft_scene_set_ambient(s.scene, (daft_vec3){1, 1, 1});
    daft_scene_set_sky_color(s.scene, (daft_vec3){0, 0, 0});
    s.view.quality.edge_samples = 16;
    daft_material_def white = daft_default_material_def();
    white.ambient = (daft_vec3){1, 1, 1}, white.diffuse = white.specular = (daft_vec3){0, 0, 0};
    daft_entity_def box = daft_default_entity_def();
    box.shape = DAFT_SHAPE_BOX, box.material = daft_material_create(s.scene, &white, NULL);
    double worst = 0;
    for (int k = 0; k < 32; k++) {
        const double part = (k + 0.5) / 32, half = (30 + part) / (WIDTH / 4.0); /* its face is 2 m away */
        box.size = (daft_vec3){1, (float)(2 * half), (float)(2 * half)};
        box.position = (daft_dvec3){2.5, 0, 0};
        const daft_entity made = daft_entity_create(s.scene, &box, &error);
        if (!made.id) fail_msg("%s", error.message);
        draw(&s, rgba);
        const int right = 4 * (HEIGHT / 2 * WIDTH + WIDTH / 2 + 30),
                  below = 4 * ((HEIGHT / 2 + 30) * WIDTH + WIDTH / 2);
        worst = fmax(worst, fmax(fabs(linear(rgba[right]) - part), fabs(linear(rgba[below]) - part)));
        assert_true(daft_entity_destroy(s.scene, made, &error));
    }
    print_message("straight edges: off by %.4f at most\n", worst);
    assert_true(worst < 1.0 / 32 + 1.0 / 128); /* half a step, and that of a byte */
    stage_free(&s);
}

/* Pixels like their neighbours keep their bytes, where textures have the filter already that 16 brings along; where
 * there are no others, nothing runs. */
static void nothing_else_changes(void **unused)
{
    (void)unused;
    static uint8_t without[4 * PIXELS], with[4 * PIXELS];
    stage s;
    stage_make(&s, "hello.scene");
    s.view.quality.texture_filter = DAFT_TEXTURE_ANISOTROPIC4;
    s.view.quality.edge_samples = 0, draw(&s, without);
    assert_false(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_ANTIALIASING].ran);
    assert_int_equal(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_ANTIALIASING].bytes, 0);
    s.view.quality.edge_samples = 16, draw(&s, with);
    assert_true(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_ANTIALIASING].rays > 1000);
    int changed = 0;
    for (int y = 1; y < HEIGHT - 1; y++)
        for (int x = 1; x < WIDTH - 1; x++) {
            const int at = 4 * (y * WIDTH + x), other[4] = {at - 4, at + 4, at - 4 * WIDTH, at + 4 * WIDTH};
            int most = 0;
            for (int k = 0; k < 4; k++)
                for (int c = 0; c < 3; c++) most = (int)fmax(most, abs(without[at + c] - without[other[k] + c]));
            bool same = memcmp(&without[at], &with[at], 4) == 0;
            if (most <= 12 && !same) fail_msg("(%d, %d) changed, %d from its neighbours", x, y, most);
            changed += !same;
        }
    assert_true(changed > 500);
    s.view.quality.edge_samples = 4, draw(&s, with);
    changed = 0;
    for (int i = 0; i < PIXELS; i++) {
        for (int c = 0; c < 3; c++) /* half of a pixel is its own middle */
            assert_true(fabs(linear(with[4 * i + c]) - 0.5 * linear(without[4 * i + c])) < 0.5 + 1.0 / 128);
        changed += memcmp(&without[4 * i], &with[4 * i], 4) != 0;
    }
    assert_true(changed > 300);
    stage_free(&s);
    stage_make(&s, NULL);
    draw(&s, NULL);
    assert_false(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_ANTIALIASING].ran);
    assert_int_equal(daft_scene_counters(s.scene)->effects[DAFT_EFFECT_ANTIALIASING].rays, 0);
    stage_free(&s);
}

static void add_ball(stage *s, daft_dvec3 at, float radius, const daft_material_def *look)
{
    daft_entity_def ball = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE, ball.radius = radius, ball.position = at;
    ball.material = daft_material_create(s->scene, look, NULL);
    assert_true(daft_entity_create(s->scene, &ball, NULL).id);
}

/* Pixels well within a ball for which more than one ray from the camera or to the sun was cast. */
static int pixels_with_more(stage *s, const uint32_t *cost, const daft_entity *entity)
{
    int count = 0;
    draw(s, NULL);
    const uint32_t ball = entity[PIXELS / 2 + WIDTH / 2].id;
    for (int y = 1; y < HEIGHT - 1; y++)
        for (int x = 1; x < WIDTH - 1; x++) {
            const int at = y * WIDTH + x;
            count += entity[at].id == ball && entity[at - 1].id == ball && entity[at + 1].id == ball &&
                     entity[at - WIDTH].id == ball && entity[at + WIDTH].id == ball && cost[at] > 2;
        }
    return count;
}

/* A filtered texture gets no more samples, however much it varies, but the edge of a shadow on it does; and so does a
 * texture that no filter smooths. */
static void textures_are_no_edges(void **unused)
{
    (void)unused;
    static uint32_t cost[PIXELS];
    static daft_entity entity[PIXELS];
    stage s;
    daft_error error = {0};
    stage_make(&s, NULL);
    daft_material_def look = daft_default_material_def();
    look.ambient = (daft_vec3){0.3f, 0.3f, 0.3f}, look.diffuse = (daft_vec3){0.7f, 0.7f, 0.7f};
    look.specular = (daft_vec3){0, 0, 0};
    look.diffuse_map = daft_texture_load(s.scene, DAFT_ROOT "/assets/textures/checker.png", &error);
    if (!look.diffuse_map.id) fail_msg("%s", error.message);
    daft_scene_set_ambient(s.scene, (daft_vec3){1, 1, 1});
    add_ball(&s, (daft_dvec3){3, 0, 0}, 1, &look);
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = (daft_vec3){0.7f, 0, -0.7f}, sun.casts_shadow = true;
    sun.color = (daft_vec3){1, 1, 1};
    assert_true(daft_light_create(s.scene, &sun, NULL).id);
    s.view.quality.edge_samples = 16, s.view.aov.cost = cost, s.view.aov.entity = entity;
    const int lit = pixels_with_more(&s, cost, entity);
    s.view.quality.texture_filter = DAFT_TEXTURE_NEAREST;
    const int rough = pixels_with_more(&s, cost, entity);
    s.view.quality.texture_filter = DAFT_TEXTURE_TRILINEAR;
    add_ball(&s, (daft_dvec3){1.46, 0, 1.54}, 0.15f, &look);
    const int shadowed = pixels_with_more(&s, cost, entity);
    print_message("pixels with more samples: %d, without a filter %d, at a shadow %d\n", lit, rough, shadowed);
    assert_true(lit < 10 && rough > 200 && shadowed > lit + 10);
    stage_free(&s);
}

/* The mean of 4 × 4 pixels for each, of sixteen samples: they see finer levels of the textures. */
static void draw_large(const stage *from, uint8_t rgba[4 * PIXELS])
{
    enum { FACTOR = 4 };
    daft_error error = {0};
    stage s = *from;
    s.image = daft_image_create(s.engine, WIDTH * FACTOR, HEIGHT * FACTOR, &error);
    s.view.quality = daft_preset_quality(DAFT_PRESET_REFERENCE);
    s.view.quality.tree = DAFT_TREE_RASTER, s.view.quality.shadow_samples = s.view.quality.glossy_samples = 0;
    s.view.quality.occlusion_samples = 0;
    draw(&s, NULL);
    const uint8_t *large = daft_image_pixels(s.image);
    for (int i = 0; i < PIXELS; i++)
        for (int c = 0; c < 4; c++) {
            double sum = 0;
            for (int k = 0; k < FACTOR * FACTOR; k++) {
                const int x = i % WIDTH * FACTOR + k % FACTOR, y = i / WIDTH * FACTOR + k / FACTOR;
                sum += linear(large[4 * (y * WIDTH * FACTOR + x) + c]);
            }
            sum /= FACTOR * FACTOR;
            const double byte = sum <= 0.0031308 ? sum * 12.92 : 1.055 * pow(sum, 1 / 2.4) - 0.055;
            rgba[4 * i + c] = (uint8_t)(byte * 255 + 0.5);
        }
    daft_image_destroy(s.image);
}

/* A ball of so many triangles that a pixel sees dozens, each lit as its own normal says. */
static daft_mesh bristling_ball(stage *s)
{
    enum { ROWS = 900, COLUMNS = 1200, VERTICES = 3 * 2 * ROWS * COLUMNS };
    daft_mesh_def def = daft_default_mesh_def();
    daft_vec3 *positions = malloc(VERTICES * sizeof *positions);
    uint32_t *indices = malloc(VERTICES * sizeof *indices), state = 7, count = 0;
    for (int i = 0; i < ROWS * COLUMNS; i++) {
        daft_vec3 corners[4];
        for (int k = 0; k < 4; k++) {
            const double rise = ((double)(i / COLUMNS + (k >> 1)) / ROWS - 0.5) * 3,
                         turn = (double)(i % COLUMNS + (k & 1)) / COLUMNS * 6.283185307179586;
            const double out = 1 + ((state = state * 1664525u + 1013904223u) >> 8) * (0.01 / (1 << 24));
            corners[k] = daft_v3((float)(out * cos(rise) * cos(turn)), (float)(out * sin(rise)),
                                 (float)(out * cos(rise) * sin(turn)));
        }
        const int order[6] = {0, 2, 1, 1, 2, 3};
        for (int k = 0; k < 6; k++, count++) positions[count] = corners[order[k]], indices[count] = count;
    }
    def.positions = positions, def.vertex_count = count, def.indices = indices, def.triangle_count = count / 3;
    const daft_mesh mesh = daft_mesh_create(s->scene, &def, NULL);
    free(positions), free(indices);
    assert_true(mesh.id);
    return mesh;
}

/* Dozens of triangles of one thing in a pixel: its rays see the same thing, but not the same. */
static void many_triangles_get_many_samples(void **unused)
{
    (void)unused;
    static uint8_t truth[4 * PIXELS], none[4 * PIXELS], edges[4 * PIXELS];
    stage s;
    stage_make(&s, NULL);
    daft_entity_def ball = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_MESH, ball.mesh = bristling_ball(&s), ball.position = (daft_dvec3){3, 0, 0};
    assert_true(daft_entity_create(s.scene, &ball, NULL).id);
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = (daft_vec3){0.7f, -0.2f, -0.7f}, sun.color = (daft_vec3){1, 1, 1};
    assert_true(daft_light_create(s.scene, &sun, NULL).id);
    s.view.quality.samples = 16, s.view.quality.edge_samples = 0, draw(&s, truth);
    s.view.quality.samples = 1, draw(&s, none);
    s.view.quality.edge_samples = 16, draw(&s, edges);
    const double before = distance(none, truth), after = distance(edges, truth);
    print_message("many triangles: error %.4f, 16 at edges %.4f\n", before, after);
    assert_true(after < 0.45 * before);
    stage_free(&s);
}

static int pixels_with_fresh_rays(stage *s, uint32_t cost[PIXELS], const uint32_t without[PIXELS])
{
    int count = 0;
    s->view.aov.cost = cost, draw(s, NULL);
    for (int i = 0; i < PIXELS; i++) count += without && cost[i] > without[i];
    return count;
}

/* The less contrast is enough, the more pixels get samples, corners as well as sixteen, and the smaller the error. */
static void less_contrast_finds_fainter_edges(void **unused)
{
    (void)unused;
    static uint8_t truth[4 * PIXELS], rgba[4 * PIXELS];
    static uint32_t without[PIXELS], cost[PIXELS];
    static const float contrasts[] = {4, 2, 1, 0.5f, 0.25f};
    stage s;
    stage_make(&s, "hello.scene");
    s.view.quality.samples = 16, s.view.quality.edge_samples = 0, draw(&s, truth);
    s.view.quality.samples = 1, s.view.quality.texture_filter = DAFT_TEXTURE_ANISOTROPIC4;
    pixels_with_fresh_rays(&s, without, NULL);
    for (int samples = 4; samples <= 16; samples *= 4) {
        double error = 1, first = 0;
        for (int i = 0, before = 0; i < 5; i++) {
            s.view.quality.edge_samples = samples, s.view.quality.edge_contrast = contrasts[i];
            const int count = pixels_with_fresh_rays(&s, cost, without);
            draw(&s, rgba);
            const double now = distance(rgba, truth);
            print_message("%d, contrast %g: %d pixels, error %.4f\n", samples, (double)contrasts[i], count, now);
            assert_true(count > before && now < 1.01 * error);
            before = count, error = now;
            if (i == 0) first = now;
        }
        assert_true(error < 0.95 * first);
    }
    stage_free(&s);
}

/* Of all pixels: textures at flat angles are as sharp as many samples make them. */
static void textures_are_sharp(void **unused)
{
    (void)unused;
    static uint8_t truth[4 * PIXELS], eight[4 * PIXELS], edges[4 * PIXELS];
    stage s;
    stage_make(&s, "hall.scene");
    s.view.quality.shadow_samples = s.view.quality.occlusion_samples = s.view.quality.glossy_samples = 0;
    draw_large(&s, truth);
    s.view.quality.edge_samples = 0, s.view.quality.samples = 8, draw(&s, eight);
    s.view.quality.samples = 1, s.view.quality.edge_samples = 16, draw(&s, edges);
    print_message("hall: 8 samples %.4f, 16 at edges %.4f\n", distance(eight, truth), distance(edges, truth));
    assert_true(distance(edges, truth) < distance(eight, truth));
    stage_free(&s);
}

static void bands_are_the_picture(void **unused)
{
    (void)unused;
    static uint8_t whole[4 * PIXELS];
    stage s;
    stage_make(&s, "temple.scene");
    for (int samples = 4; samples <= 16; samples *= 4) {
        s.view.quality.edge_samples = samples, s.view.first_row = s.view.row_count = 0;
        draw(&s, whole);
        memset(daft_image_pixels(s.image), 7, 4 * PIXELS);
        for (int row = 0; row < HEIGHT; row += 32) {
            s.view.first_row = row, s.view.row_count = row + 32 < HEIGHT ? 32 : 0;
            draw(&s, NULL);
        }
        assert_memory_equal(whole, daft_image_pixels(s.image), sizeof whole);
    }
    stage_free(&s);
}

static bool stop(void *user, float done)
{
    int *calls = user;
    ++*calls;
    assert_true(done > 0 && done <= 1);
    return done < 0.9f;
}

/* The work at edges counts in the progress, and can be stopped. */
static void stops_in_between(void **unused)
{
    (void)unused;
    stage s;
    daft_error error = {0};
    int calls = 0;
    stage_make(&s, "temple.scene");
    s.view.progress = stop, s.view.progress_user = &calls;
    assert_false(daft_render(s.scene, &s.view, s.image, &error));
    assert_int_equal(error.code, DAFT_ERROR_CANCELLED);
    assert_true(calls > 5);
    s.view.quality.edge_samples = 5;
    assert_false(daft_render(s.scene, &s.view, s.image, &error));
    assert_string_equal(error.message, "quality.edge_samples is 5; it must be 0, 4 or 16");
    s.view.quality.edge_samples = 4, s.view.quality.edge_contrast = 0;
    assert_false(daft_render(s.scene, &s.view, s.image, &error));
    assert_string_equal(error.message, "quality.edge_contrast is 0; it must be between 0.25 and 4");
    stage_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(come_close_to_many_samples),
                                       cmocka_unit_test(high_beats_four_samples),
                                       cmocka_unit_test(more_samples_come_closer),
                                       cmocka_unit_test(an_outline_is_its_coverage),
                                       cmocka_unit_test(few_samples_lie_round_the_middle),
                                       cmocka_unit_test(straight_edges_have_sixteen_steps),
                                       cmocka_unit_test(nothing_else_changes),
                                       cmocka_unit_test(textures_are_no_edges),
                                       cmocka_unit_test(many_triangles_get_many_samples),
                                       cmocka_unit_test(less_contrast_finds_fainter_edges),
                                       cmocka_unit_test(textures_are_sharp),
                                       cmocka_unit_test(bands_are_the_picture),
                                       cmocka_unit_test(stops_in_between)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
