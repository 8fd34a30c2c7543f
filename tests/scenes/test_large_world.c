/* Large worlds: the same scene, moved up to 10⁹ m from the origin or scaled by 10⁻⁴ to 10⁴, gives the same picture: at
 * most one pixel in 10⁵ differs by more than one step. Ray queries give the same answers, and what stands still does
 * not jitter when the camera creeps, wherever in the world that is. */
#include "hard_scenes.h"

enum { WIDTH = 800, HEIGHT = 500 };

/* Where the scene's origin lies in the world, and how long its metre is there. */
typedef struct place {
    daft_dvec3 offset;
    double scale;
} place;

static daft_dvec3 at(const place *w, double x, double y, double z)
{
    return daft_dadd(w->offset, daft_dscale(daft_dv3(x, y, z), w->scale));
}

static daft_vec3 sized(const place *w, double x, double y, double z)
{
    return daft_to_float(daft_dscale(daft_dv3(x, y, z), w->scale));
}

/* The directions of the moves: along the ground, away from every axis. */
static place moved(double metres) { return (place){{metres, -0.37 * metres, 0.81 * metres}, 1}; }

static void turned_column(stage *s, const place *w)
{
    daft_error error = {0};
    daft_mesh column = daft_mesh_load(s->scene, DAFT_ROOT "/assets/meshes/column.obj", &error);
    daft_mesh cup = daft_mesh_load(s->scene, DAFT_ROOT "/assets/meshes/cup.obj", &error);
    if (!column.id || !cup.id) fail_msg("%s", error.message);
    daft_quat turn = daft_quat_normalize((daft_quat){0.31f, 0.4f, -0.2f, 0.8f});
    add(s, instance(column, at(w, 5.3, 0.2, -1.7), (float)(0.83 * w->scale), turn, (daft_material){0}));
    add(s, instance(cup, at(w, 3.1, 0.03, 1.4), (float)(1.7 * w->scale), (daft_quat){0, 0.38f, 0, 0.92f},
                    (daft_material){0}));
}

/* A ball that turns the picture over, a pane that is seen straight through, and a turned block of coloured glass. */
static void glasses(stage *s, const place *w)
{
    daft_material_def clear = daft_default_material_def(), pane, block;
    clear.transmission = 1;
    pane = block = clear;
    pane.refractive_index = 1, pane.transmission_tint = daft_v3(0.7f, 0.8f, 1);
    block.refractive_index = 1.33f, block.transmission_tint = daft_v3(0.9f, 0.6f, 0.5f);
    add(s, sphere(at(w, 2.1, 0.52, -0.6), (float)(0.5 * w->scale), daft_material_create(s->scene, &clear, NULL)));
    add(s, box(at(w, 3.4, 0.9, 1.1), sized(w, 0.05, 1.2, 1.6), daft_material_create(s->scene, &pane, NULL)));
    daft_entity_def turned =
        box(at(w, 1.9, 0.5, 0.9), sized(w, 0.4, 0.7, 0.5), daft_material_create(s->scene, &block, NULL));
    turned.rotation = daft_quat_normalize((daft_quat){0.2f, 0.3f, -0.1f, 0.9f});
    add(s, turned);
}

/* Like a game's: a floor, boxes, balls, turned meshes, a mirror wall and a chrome ball, glass, a sun and a light that
 * cast shadows. */
static void fill(stage *s, const place *w)
{
    daft_error error = {0};
    daft_material_def checker = daft_default_material_def();
    checker.diffuse_map = daft_texture_load(s->scene, DAFT_ROOT "/assets/textures/checker.png", &error);
    checker.map_scale = (daft_vec2){6, 3};
    daft_material white = matte(s, daft_v3(0.8f, 0.8f, 0.75f), 0), red = matte(s, daft_v3(0.7f, 0.1f, 0.1f), 0);
    daft_material mirror = matte(s, daft_v3(0.1f, 0.1f, 0.12f), 0.8f),
                  map = daft_material_create(s->scene, &checker, &error);
    if (!map.id) fail_msg("%s", error.message);
    add(s, box(at(w, 4, -0.3, 0), sized(w, 24, 0.6, 24), white));
    daft_entity_def wall = box(at(w, 9.1, 1.4, 0.3), sized(w, 0.2, 3.1, 6), mirror);
    wall.rotation = (daft_quat){0, 0.1f, 0, 0.99f};
    add(s, wall);
    for (int i = 0; i < 12; i++)
        add(s, box(at(w, 2.7 + 0.61 * i, 0.25 + 0.1 * (i % 3), -3.3 + 0.47 * ((7 * i) % 12)),
                   sized(w, 0.4, 0.5 + 0.2 * (i % 3), 0.45), i % 2 ? white : red));
    for (int i = 0; i < 9; i++)
        add(s, sphere(at(w, 2.2 + 0.7 * i, 0.33, 2.9 - 0.63 * ((4 * i) % 9)), (float)(0.33 * w->scale),
                      i % 4 == 1 ? mirror : map));
    turned_column(s, w);
    glasses(s, w);
    sun(s, daft_v3(0.4f, -1, 0.27f), 0.7f);
    source(s, at(w, 4.2, 2.7, 0.4), 0.5f);
    daft_scene_set_sky_gradient(s->scene, daft_v3(0.2f, 0.4f, 0.8f), daft_v3(0.8f, 0.9f, 1));
    s->view.camera.position = at(w, -1.3, 1.9, 0.7);
    s->view.camera.pitch = 0.19f, s->view.camera.yaw = -0.04f, s->view.camera.fov = 1.3f;
}

static stage *scene_at(const place *w)
{
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    fill(s, w);
    return s;
}

static void compare(const picture *home, const place *w, bool reference, const char *what)
{
    stage *s = scene_at(w);
    s->view.quality.tree = reference ? DAFT_TREE_BVH : DAFT_TREE_RASTER;
    draw(s);
    int wrong = far_apart(home, s), others = others_seen(home, s);
    print_message("%s%s: %d pixels of %d differ by more than a step, %d see something else\n", what,
                  reference ? ", reference path" : "", wrong, s->pixels, others);
    if (wrong * 100000 > s->pixels) fail_msg("%s: %d pixels of %d differ", what, wrong, s->pixels);
    stage_drop(s);
}

static picture home_picture(void)
{
    place home = moved(0);
    stage *s = scene_at(&home);
    draw(s);
    picture p = picture_take(s);
    stage_drop(s);
    return p;
}

static void far_from_the_origin(void **unused)
{
    (void)unused;
    picture home = home_picture();
    place here = moved(0);
    stage *s = scene_at(&here);
    s->view.camera.position.z += 0.001;
    draw(s);
    assert_true(far_apart(&home, s) > 500 && others_seen(&home, s) > 100); /* the comparison sees a millimetre */
    stage_drop(s);
    const double metres[] = {10, 1e5, 1e7, 1e9};
    for (size_t i = 0; i < DAFT_COUNT_OF(metres); i++) {
        char what[64];
        snprintf(what, sizeof what, "moved by %g m", metres[i]);
        place w = moved(metres[i]);
        compare(&home, &w, false, what);
        if (i == DAFT_COUNT_OF(metres) - 1) compare(&home, &w, true, what);
    }
    picture_drop(&home);
}

static void at_every_scale(void **unused)
{
    (void)unused;
    picture home = home_picture();
    const double scales[] = {1e-4, 1e-2, 1e2, 1e4};
    for (size_t i = 0; i < DAFT_COUNT_OF(scales); i++) {
        char what[64];
        snprintf(what, sizeof what, "scaled by %g", scales[i]);
        place w = {{0, 0, 0}, scales[i]};
        compare(&home, &w, false, what);
    }
    picture_drop(&home);
}

/* ---- rays ---- */

typedef struct answer {
    uint32_t entity, triangle;
    double distance; /* in the scene's own metres */
    daft_dvec3 position;
    daft_vec3 normal;
} answer;

enum { RAYS = 4000 };

static void ask(const place *w, answer *out)
{
    stage *s = stage_make(16, 16, NULL, 1);
    fill(s, w);
    uint64_t state = 99;
    for (int i = 0; i < RAYS; i++) {
        float d[3];
        for (int k = 0; k < 3; k++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            d[k] = (float)(state >> 40) * 0x1p-23f - 1;
        }
        daft_error error;
        daft_ray_hit hit = {0};
        daft_dvec3 origin = at(w, 4 + 3 * (double)d[1], 1.3 + 0.5 * (double)d[2], 2.5 * (double)d[0]);
        bool found =
            daft_scene_cast_ray(s->scene, origin, daft_v3(d[0], d[1], d[2]), INFINITY, (daft_entity){0}, &hit, &error);
        assert_int_equal(error.code, DAFT_OK);
        out[i] = (answer){found ? hit.entity.id : 0, hit.triangle, (double)hit.distance / w->scale,
                          daft_dscale(daft_dsub(hit.position, w->offset), 1 / w->scale), hit.normal};
    }
    stage_drop(s);
}

/* The same thing is hit, as near as the doubles there are apart: about 1e-7 m where the world is 10⁹ m wide. */
static void compare_rays(const answer *home, const place *w, const char *what)
{
    answer *there = malloc(RAYS * sizeof *there);
    ask(w, there);
    double far = fabs(w->offset.x) / w->scale * 0x1p-51, worst = 0;
    int others = 0, hits = 0;
    for (int i = 0; i < RAYS; i++) {
        bool same = home[i].entity == there[i].entity && home[i].triangle == there[i].triangle;
        others += !same, hits += home[i].entity != 0;
        if (!same || !home[i].entity) continue;
        daft_dvec3 d = daft_dsub(home[i].position, there[i].position);
        double error = sqrt(daft_ddot(d, d));
        worst = error > worst ? error : worst;
        assert_true(daft_dot(home[i].normal, there[i].normal) > 0.99999f);
        assert_true(fabs(home[i].distance - there[i].distance) <= error + 10 * far + 1e-6 * home[i].distance);
    }
    print_message("%s: %d hits of %d rays, %d differ, the others by at most %.2g m\n", what, hits, RAYS, others, worst);
    assert_true(hits > RAYS / 2);
    assert_true(others * 1000 <= RAYS);
    assert_true(worst <= 1e-4 + 100 * far);
    free(there);
}

static void rays_far_and_scaled(void **unused)
{
    (void)unused;
    answer *home = malloc(RAYS * sizeof *home);
    place w = moved(0);
    ask(&w, home);
    const double metres[] = {10, 1e5, 1e7, 1e9}, scales[] = {1e-4, 1e-2, 1e2, 1e4};
    for (int i = 0; i < 4; i++) {
        char what[64];
        w = moved(metres[i]);
        snprintf(what, sizeof what, "moved by %g m", metres[i]);
        compare_rays(home, &w, what);
        w = (place){{0, 0, 0}, scales[i]};
        snprintf(what, sizeof what, "scaled by %g", scales[i]);
        compare_rays(home, &w, what);
    }
    free(home);
}

/* ---- no jitter ---- */

/* A post whose side lies across the way of the camera, which creeps 1 mm a frame: the side's column follows the true
 * one, found in double from the places as they are rounded at that offset, to a hundredth of a pixel. */
static void creep(double metres)
{
    enum { W = 512, H = 32, STEPS = 40 };
    stage *s = stage_make(W, H, NULL, 1);
    place w = moved(metres);
    daft_entity post = add(s, box(at(&w, 3, 0, 0.731), daft_v3(0.5f, 4, 0.5f), matte(s, daft_v3(1, 1, 1), 0)));
    s->view.camera.fov = 1;
    double f = W / 2.0 / daft_tan(0.5);
    for (int i = 0; i < STEPS; i++) {
        s->view.camera.position = at(&w, 0, 0, 0.001 * i);
        draw(s);
        /* the side at z - 0.25 is seen; its far edge, at x + 0.25, is the post's outline */
        daft_dvec3 centre = at(&w, 3, 0, 0.731), eye = s->view.camera.position;
        double column = W / 2.0 + f * (centre.z - 0.25 - eye.z) / (centre.x + 0.25 - eye.x);
        for (int y = 0; y < H; y++) {
            int x = 0;
            while (x < W && s->entity[y * W + x].id != post.id) x++;
            double off = x + 0.5 - column; /* the first centre at or right of the side */
            if (off < -0.01 || off > 1.01) fail_msg("%g m away, step %d: column %d, not %.3f", metres, i, x, column);
        }
    }
    stage_drop(s);
}

static void nothing_jitters(void **unused)
{
    (void)unused;
    for (double metres = 1; metres < 2e8; metres *= 10) creep(metres);
    creep(0);
}

/* The whole scene, the camera creeping: each picture is the one that the same step gives at home. */
static void steps_look_the_same_everywhere(void **unused)
{
    (void)unused;
    const double metres[] = {1e3, 1e6, 1e8};
    place home = moved(0);
    for (size_t k = 0; k < DAFT_COUNT_OF(metres); k++) {
        place there = moved(metres[k]);
        stage *a = scene_at(&home), *b = scene_at(&there);
        int wrong = 0, others = 0, pixels = 0;
        for (int i = 1; i <= 5; i++) {
            a->view.camera.position = at(&home, -1.3 + 0.001 * i, 1.9, 0.7);
            b->view.camera.position = at(&there, -1.3 + 0.001 * i, 1.9, 0.7);
            draw(a);
            draw(b);
            picture p = picture_take(a);
            wrong += far_apart(&p, b), others += others_seen(&p, b), pixels += a->pixels;
            picture_drop(&p);
        }
        print_message("%g m away: %d of %d pixels differ by more than a step, %d see something else\n", metres[k],
                      wrong, pixels, others);
        assert_true(wrong * 100000 <= pixels);
        stage_drop(a);
        stage_drop(b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(far_from_the_origin),
        cmocka_unit_test(at_every_scale),
        cmocka_unit_test(rays_far_and_scaled),
        cmocka_unit_test(nothing_jitters),
        cmocka_unit_test(steps_look_the_same_everywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
