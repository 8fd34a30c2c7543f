/* Media that are seen: light that is absorbed on its way within a body, by Beer's law and closed forms; bodies that
 * overlap and touch, by their priorities, against a tracer in double that asks the bodies themselves what is where, and
 * carries nothing along. */
#include "media_bodies.h"

#include "render/media.h"

#include <math.h>

static int encoded(double linear)
{
    double e = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (int)floor(255 * fmin(fmax(e, 0), 1) + 0.5);
}

/* ---- stacks ---- */

static void stacks_of_media(void **unused)
{
    (void)unused;
    daft_surface m[6] = {{.index = 1.1f},
                         {.index = 1.2f, .priority = 1},
                         {.index = 1.3f, .priority = 2},
                         {.index = 1.4f, .priority = 2},
                         {.index = 1.5f, .priority = 3},
                         {.index = 1.6f}};
    daft_media s = daft_no_media(), t;
    assert_int_equal(daft_media_winner(&s, m), DAFT_NO_MEDIUM);
    daft_media_pass(&s, m, 0, false);
    t = s, daft_media_pass(&t, m, 5, false); /* neither has a priority: what lies around is air */
    assert_int_equal(daft_media_winner(&t, m), 5);
    assert_true(daft_media_eta(&s, &t, m, 5, false) == 1 / 1.6f && daft_media_eta(&t, &s, m, 5, true) == 1.6f);
    daft_media_pass(&s, m, 2, false);
    assert_int_equal(daft_media_winner(&s, m), 2);
    t = s, daft_media_pass(&t, m, 3, false); /* of equals the last */
    assert_int_equal(daft_media_winner(&t, m), 3);
    assert_true(daft_media_eta(&s, &t, m, 3, false) == 1.3f / 1.4f);
    s = t, daft_media_pass(&t, m, 2, true);
    assert_true(daft_media_eta(&s, &t, m, 2, true) == 0);
    t = s, daft_media_pass(&t, m, 1, false);
    assert_true(daft_media_eta(&s, &t, m, 1, false) == 0);
    /* full: the oldest of the lowest priority goes; what is lower than all does not come in */
    daft_media_pass(&t, m, 4, false);
    const uint32_t expected[DAFT_MEDIA] = {2, 3, 1, 4};
    assert_memory_equal(t.material, expected, sizeof expected);
    daft_media_pass(&t, m, 5, false);
    daft_media_pass(&t, m, 0, true);
    assert_memory_equal(t.material, expected, sizeof expected);
    daft_media_pass(&t, m, 4, true);
    daft_media_learn(&t, 3);
    daft_media_learn(&t, 0);
    const uint32_t learned[DAFT_MEDIA] = {0, 2, 3, 1};
    assert_memory_equal(t.material, learned, sizeof learned);
}

/* ---- Beer's law ---- */

/* The light of a white sky along a pixel's ray; linear. */
static void draw_light(stage *s, daft_vec3 *light)
{
    daft_scene_set_sky_color(s->scene, WHITE);
    s->view.aov.color = light;
    draw(s);
}

/* Gives the largest relative error. */
static double beer_error(daft_vec3 light, double length, double distance)
{
    double most = 0;
    for (int k = 0; k < 3; k++) {
        const double truth = pow((double)daft_v3_at(TINT, k), length / distance);
        if (truth > 0.01) most = fmax(most, fabs((double)daft_v3_at(light, k) / truth - 1));
    }
    return most;
}

/* Slabs that bend light and such that do not, straight on and aslant; and the same seen from within. */
static void slabs_absorb_by_beer(void **unused)
{
    (void)unused;
    static daft_vec3 light[WIDTH * HEIGHT];
    const double thick[] = {0.01, 0.3, 1, 4}, distance = 0.7;
    for (int bent = 0; bent < 2; bent++)
        for (size_t k = 0; k < DAFT_COUNT_OF(thick); k++)
            for (int within = 0; within < 2; within++) {
                const double index = bent ? 1.5 : 1;
                stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
                s->view.camera.fov = 1.6f, s->view.quality = daft_preset_quality(DAFT_PRESET_DRAFT);
                add(s, box(daft_dv3(within ? thick[k] / 4 : 2 + thick[k] / 2, 0, 0), daft_v3((float)thick[k], 400, 400),
                           medium(s, index, TINT, distance, 0)));
                draw_light(s, light);
                double worst = 0;
                int looked = 0;
                for (int i = 0; i < s->pixels; i++) {
                    daft_dvec3 d = pixel_ray(s, i % WIDTH, i / WIDTH);
                    const double cosine = d.x / sqrt(daft_ddot(d, d)), sine = sqrt(1 - cosine * cosine);
                    if (within && sine * index > 0.99) continue; /* all is mirrored */
                    const double inside = within ? cosine : sqrt(1 - sine * sine / index / index);
                    const double length = thick[k] * (within ? 0.75 : 1) / inside;
                    worst = fmax(worst, beer_error(light[i], length, distance)), looked++;
                }
                assert_true(looked > s->pixels / 4);
                if (!(worst < 2e-4)) fail_msg("%g m, index %g: an error of %g", thick[k], index, worst);
                stage_drop(s);
            }
}

/* Chords of balls: 2·sqrt(r² - b²) at a distance b from the centre. Rays start a little off surfaces, along the normal:
 * the error of a length grows as one over the cosine. */
static void balls_absorb_by_their_chords(void **unused)
{
    (void)unused;
    static daft_vec3 light[WIDTH * HEIGHT];
    const double radii[] = {0.05, 1, 30};
    for (size_t k = 0; k < DAFT_COUNT_OF(radii); k++) {
        const double r = radii[k], distance = r / 2;
        const daft_dvec3 centre = daft_dv3(3 * r, 0.2 * r, -0.3 * r);
        stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
        add(s, sphere(centre, (float)r, medium(s, 1, TINT, distance, 0)));
        s->view.camera.fov = 1, s->view.quality = daft_preset_quality(DAFT_PRESET_DRAFT);
        draw_light(s, light);
        double worst = 0;
        int looked = 0;
        for (int i = 0; i < s->pixels; i++) {
            daft_dvec3 d = pixel_ray(s, i % WIDTH, i / WIDTH);
            const double along = daft_ddot(centre, d) / sqrt(daft_ddot(d, d)),
                         b2 = daft_ddot(centre, centre) - along * along;
            if (b2 > 0.999 * r * r) continue;
            worst = fmax(worst, beer_error(light[i], 2 * sqrt(r * r - b2), distance) * sqrt(1 - b2 / r / r)), looked++;
        }
        assert_true(looked > 3000);
        if (!(worst < 2e-4)) fail_msg("radius %g: an error of %g", r, worst);
        stage_drop(s);
    }
}

/* ---- a tracer in double ---- */

static const daft_vec3 ZENITH = {0.1f, 0.2f, 0.9f}, HORIZON = {0.9f, 0.8f, 0.4f};

/* As daft_scene_set_sky_gradient describes it. */
static void sky_light(daft_dvec3 d, double out[3])
{
    double y = d.y / sqrt(daft_ddot(d, d)), rise = sqrt(fabs(y)), shade = 1 + fmin(y, 0) / 3;
    for (int k = 0; k < 3; k++) {
        const double z = (double)daft_v3_at(ZENITH, k), h = (double)daft_v3_at(HORIZON, k);
        out[k] = (h + (z - h) * rise) * shade;
    }
}

static double fresnel(double cosine, double from, double to)
{
    const double sine = from / to * sqrt(fmax(0, 1 - cosine * cosine));
    if (sine >= 1) return 1;
    const double beyond = sqrt(1 - sine * sine), s = (from * cosine - to * beyond) / (from * cosine + to * beyond),
                 p = (to * cosine - from * beyond) / (to * cosine + from * beyond);
    return (s * s + p * p) / 2;
}

static void trace_light(const world *w, daft_dvec3 o, daft_dvec3 d, int depth, double out[3]);

static void divide_light(const world *w, daft_dvec3 p, daft_dvec3 d, daft_dvec3 n, double from, double to, int depth,
                         double out[3])
{
    if (daft_ddot(n, d) > 0) n = daft_dscale(n, -1);
    const double cosine = fmin(-daft_ddot(n, d), 1), eta = from / to;
    double back = fresnel(cosine, from, to), light[3];
    if (depth >= w->mirrors && back < 1) back = 0;
    if (back > 0) {
        trace_light(w, p, daft_dadd(d, daft_dscale(n, 2 * cosine)), depth + 1, light);
        for (int k = 0; k < 3; k++) out[k] += back * light[k];
    }
    if (back == 1) return;
    const double beyond = sqrt(1 - eta * eta * (1 - cosine * cosine));
    trace_light(w, p, daft_dadd(daft_dscale(d, eta), daft_dscale(n, eta * cosine - beyond)), depth + 1, light);
    for (int k = 0; k < 3; k++) out[k] += (1 - back) * light[k];
}

/* d is unit. Surfaces at one place are one; each at which a body begins or ends counts as a step, as in the engine. */
static void trace_light(const world *w, daft_dvec3 o, daft_dvec3 d, int depth, double out[3])
{
    surface list[MOST];
    int count = 0;
    double left[3] = {1, 1, 1}, before = 0;
    for (int i = 0; i < w->count; i++) body_surfaces(&w->bodies[i], o, d, list, &count);
    qsort(list, (size_t)count, sizeof *list, by_t);
    out[0] = out[1] = out[2] = 0;
    for (int i = 0, end; i < count; i = end) {
        const double t = list[i].t;
        for (end = i + 1; end < count && list[end].t - t < 1e-9; end++) continue;
        const double after = end < count ? (t + list[end].t) / 2 : t + 1;
        unsigned was, is;
        const int near = body_at(w, daft_dadd(o, daft_dscale(d, (before + t) / 2)), &was),
                  far = body_at(w, daft_dadd(o, daft_dscale(d, after)), &is);
        for (int k = 0; near >= 0 && w->bodies[near].distance > 0 && k < 3; k++)
            left[k] *= pow((double)daft_v3_at(w->bodies[near].tint, k), (t - before) / w->bodies[near].distance);
        before = t;
        if (was == is) continue;
        if (far >= 0 && w->bodies[far].priority == 0) {
            for (int k = 0; k < 3; k++) out[k] = left[k] * (double)daft_v3_at(w->bodies[far].tint, k);
            return;
        }
        if (depth >= w->surfaces) return;
        if (near != far) {
            divide_light(w, daft_dadd(o, daft_dscale(d, t)), d, list[i].normal, near < 0 ? 1 : w->bodies[near].index,
                         far < 0 ? 1 : w->bodies[far].index, depth, out);
            for (int k = 0; k < 3; k++) out[k] *= left[k];
            return;
        }
        depth++;
    }
    sky_light(d, out);
    for (int k = 0; k < 3; k++) out[k] *= left[k];
}

/* The tracer's colour of a place in the picture. False: a little aside it is another one, so rounding decides. */
static bool steady_color(const stage *s, const world *w, int x, int y, int color[3])
{
    for (int k = 0; k < 5; k++) {
        double light[3], aside[5][2] = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}};
        daft_dvec3 a = pixel_ray(s, x, y), b = pixel_ray(s, x + 1, y), c = pixel_ray(s, x, y + 1);
        daft_dvec3 d = daft_dadd(a, daft_dadd(daft_dscale(daft_dsub(b, a), 2e-3 * aside[k][0]),
                                              daft_dscale(daft_dsub(c, a), 2e-3 * aside[k][1])));
        trace_light(w, s->view.camera.position, daft_dscale(d, 1 / sqrt(daft_ddot(d, d))), 0, light);
        for (int i = 0; i < 3; i++) {
            const int value = encoded(light[i]);
            if (k == 0) color[i] = value;
            if (abs(value - color[i]) > 1) return false;
        }
    }
    return true;
}

/* ---- bodies beside the tracer ---- */

static void compare_with_tracer(const world *w, daft_preset preset, daft_camera camera, int most_wrong,
                                const char *what)
{
    world deep = *w;
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    daft_scene_set_sky_gradient(s->scene, ZENITH, HORIZON);
    s->view.quality = daft_preset_quality(preset), s->view.camera = camera;
    s->view.quality.samples = 1, s->view.quality.edge_samples = 0;
    deep.mirrors = s->view.quality.mirror_depth, deep.surfaces = s->view.quality.refraction_depth;
    add_bodies(s, w);
    draw(s);
    int looked = 0, wrong = 0;
    for (int i = 0; i < s->pixels; i++) {
        int color[3] = {0, 0, 0}, most = 0;
        const uint8_t *p = pixel(s, i % WIDTH, i / WIDTH);
        if (!steady_color(s, &deep, i % WIDTH, i / WIDTH, color)) continue;
        looked++;
        for (int k = 0; k < 3; k++) most = daft_max_i(most, abs(color[k] - p[k]));
        wrong += most > 2;
    }
    print_message("%s, %s: %d of %d pixels are not as traced in double\n", what, daft_preset_name(preset), wrong,
                  looked);
    assert_true(looked > s->pixels * 3 / 5);
    assert_true(wrong <= most_wrong);
    stage_drop(s);
}

static void compare_all(const world *w, daft_camera outside, daft_camera inside, int most_wrong, const char *what)
{
    static const daft_preset presets[] = {DAFT_PRESET_DRAFT, DAFT_PRESET_GAME, DAFT_PRESET_HIGH};
    for (size_t k = 0; k < DAFT_COUNT_OF(presets); k++) {
        compare_with_tracer(w, presets[k], outside, most_wrong, what);
        compare_with_tracer(w, presets[k], inside, most_wrong, "from within");
    }
}

static const daft_vec3 WINE = {0.7f, 0.1f, 0.2f}, CLEAR = {0.97f, 1, 0.98f}, BLUE = {0.3f, 0.5f, 0.9f};

/* Balls across each other and within each other: glass over wine over water, with a bubble of air in the glass. */
static void balls_overlap(void **unused)
{
    (void)unused;
    const body balls[] = {{BALL, {4, 0, -0.4}, {0, 0, 0}, 1, 3, 1.5, 0.5, CLEAR},
                          {BALL, {4.3, 0.1, 0.5}, {0, 0, 0}, 0.9, 2, (double)1.36f, 0.6, WINE},
                          {BALL, {4.1, -0.5, 0.1}, {0, 0, 0}, 0.8, 1, (double)1.33f, 1, BLUE},
                          {BALL, {3.9, 0.2, -0.5}, {0, 0, 0}, 0.4, 4, 1, 0, {1, 1, 1}},
                          {BALL, {4.5, 0.2, 0.7}, {0, 0, 0}, 0.2, 0, 0, 0, {0.9f, 0.9f, 0.1f}}};
    const world w = {balls, 5, 0, 0};
    daft_camera outside = daft_default_camera();
    outside.fov = 0.8f;
    const daft_camera inside = daft_camera_look_at(daft_dv3(4.5, -0.2, 0.9), daft_dv3(3.9, 0.2, -0.5), 1.2f);
    compare_all(&w, outside, inside, 4, "balls"); /* of 19,200: balls magnify that rays start off surfaces */
}

/* Wine that reaches a millimetre into its glass, which stands in water. */
static void wine_in_a_glass(void **unused)
{
    (void)unused;
    const body bodies[] = {{CUP, {3, -0.5, -0.5}, {4, 0.9, 0.5}, 0.0625, 3, 1.5, 2, CLEAR},
                           {BOX, {3.05, -0.45, -0.45}, {3.95, 0.4, 0.45}, 0, 2, (double)1.36f, 0.5, WINE},
                           {BOX, {1.5, -2, -3}, {6, -0.25, 3}, 0, 1, (double)1.33f, 1.5, BLUE},
                           {BALL, {3.6, -0.2, 0.1}, {0, 0, 0}, 0.15, 0, 0, 0, {0.9f, 0.9f, 0.1f}}};
    const world w = {bodies, 4, 0, 0};
    const daft_camera outside = daft_camera_look_at(daft_dv3(0, 1.3, 0.4), daft_dv3(3.5, 0.1, 0), 0.6f);
    const daft_camera inside = daft_camera_look_at(daft_dv3(3.2, 0.1, -0.3), daft_dv3(3.6, -0.2, 0.1), 1.3f);
    compare_all(&w, outside, inside, 0, "wine");
}

/* Faces in the very same place: layers of three liquids in a cup that they just fill. */
static void media_touch(void **unused)
{
    (void)unused;
    const body bodies[] = {
        {CUP, {3, -0.5, -0.5}, {4, 1, 0.5}, 0.125, 4, 1.5, 2, CLEAR},
        {BOX, {3.125, -0.375, -0.375}, {3.875, 0, 0.375}, 0, 3, (double)1.42f, 0.5, WINE},
        {BOX, {3.125, 0, -0.375}, {3.875, 0.5, 0.375}, 0, 2, (double)1.33f, 0.5, BLUE},
        {BOX, {3.125, 0.5, -0.375}, {3.875, 0.75, 0.375}, 0, 1, (double)1.47f, 0.3, {0.9f, 0.8f, 0.2f}}};
    const world w = {bodies, 4, 0, 0};
    const daft_camera outside = daft_camera_look_at(daft_dv3(0.3, 1.1, 0.9), daft_dv3(3.5, 0.2, 0), 0.6f);
    const daft_camera inside = daft_camera_look_at(daft_dv3(3.3, 0.3, -0.2), daft_dv3(3.7, -0.2, 0.1), 1.3f);
    compare_all(&w, outside, inside, 0, "touching");
}

/* ---- what stays as it is, and what it costs ---- */

static void dress(stage *s, int priorities, double distance, daft_vec3 tint)
{
    daft_scene_set_sky_gradient(s->scene, ZENITH, HORIZON);
    add(s, box(daft_dv3(6, -2, 0), daft_v3(20, 1, 20), matte(s, daft_v3(0.9f, 0.5f, 0.3f), 0.2f)));
    for (int k = 0; k < 4; k++) {
        const daft_material m = medium(s, 1.2 + 0.2 * k, tint, distance, priorities ? 1 + k : 0);
        const daft_dvec3 at = daft_dv3(6 + k % 2, -0.4, 1.9 * (k - 1.5));
        add(s, k % 2 ? box(at, daft_v3(0.9f, 0.8f, 1), m) : sphere(at, 0.8f, m));
    }
    sun(s, daft_v3(1, -2, 0.7f), 1);
    s->view.camera.fov = 1;
}

/* Apart from each other, bodies look the same with any priorities; a tint that is white takes nothing however far. */
static void apart_nothing_changes(void **unused)
{
    (void)unused;
    stage *plain = stage_make(WIDTH, HEIGHT, NULL, 2);
    dress(plain, 0, 0, WHITE);
    draw(plain);
    const uint64_t expected = picture_hash(plain);
    const size_t bytes = daft_scene_counters(plain->scene)->effects[DAFT_EFFECT_REFRACTION].bytes;
    for (int k = 1; k < 4; k++) {
        stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
        dress(s, k & 1, k & 2 ? 0.5 : 0, WHITE);
        draw(s);
        assert_true(picture_hash(s) == expected);
        const size_t more = daft_scene_counters(s->scene)->effects[DAFT_EFFECT_REFRACTION].bytes;
        assert_true(k & 1 ? more > bytes : more == bytes); /* rays carry media only where these can matter */
        stage_drop(s);
    }
    stage_drop(plain);
}

/* Under a white sky nothing is brighter than white. */
static void no_light_is_made(void **unused)
{
    (void)unused;
    static daft_vec3 light[WIDTH * HEIGHT];
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    add(s, sphere(daft_dv3(4, 0, -0.4), 1, medium(s, 1.5, CLEAR, 0.5, 3)));
    add(s, sphere(daft_dv3(4.3, 0.1, 0.5), 0.9f, medium(s, 2.4, WHITE, 0, 2)));
    add(s, box(daft_dv3(4.1, -0.5, 0.1), daft_v3(1, 1, 1), medium(s, 1.1, WINE, 0.5, 1)));
    s->view.quality = daft_preset_quality(DAFT_PRESET_HIGH), s->view.camera.fov = 0.8f;
    draw_light(s, light);
    float most = 0;
    for (int i = 0; i < s->pixels; i++) most = fmaxf(most, fmaxf(light[i].x, fmaxf(light[i].y, light[i].z)));
    assert_true(most <= 1.00001f);
    stage_drop(s);
}

static void the_same_however_computed(void **unused)
{
    (void)unused;
    uint64_t expected = 0;
    for (int variant = 0; variant <= daft_isa_best() + 2; variant++) {
        const bool by_isa = variant <= daft_isa_best();
        stage *s = stage_make(WIDTH, HEIGHT, by_isa ? daft_isa_name(variant) : NULL,
                              by_isa ? 1 : 3 * (variant - daft_isa_best()));
        dress(s, 1, 0.4, TINT);
        add(s, sphere(daft_dv3(6.2, 0, -1), 0.7f, medium(s, 1.7, WINE, 0.3, 9)));
        draw(s);
        const uint64_t hash = picture_hash(s);
        if (!expected) expected = hash;
        if (hash != expected) fail_msg("variant %d gives another picture", variant);
        stage_drop(s);
    }
}

/* A picture that is kept is drawn anew where a body that holds the camera goes or changes. */
static void kept_pictures_follow(void **unused)
{
    (void)unused;
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    daft_scene_set_sky_color(s->scene, WHITE);
    const daft_material_def changed = medium_def(1, daft_v3(0.2f, 0.9f, 0.4f), 3, 0);
    const daft_material m = medium(s, 1, TINT, 2, 0);
    add(s, box(daft_dv3(4, 0, 0), daft_v3(1, 1, 1), glowing(s, WHITE)));
    const daft_entity around = add(s, sphere(daft_dv3(0, 0, 0), 6, m));
    draw(s);
    assert_in_range(pixel(s, WIDTH / 2, HEIGHT / 2)[1], encoded(pow(0.2, 3.5 / 2)) - 1, encoded(pow(0.2, 3.5 / 2)) + 1);
    assert_true(daft_material_set(s->scene, m, &changed, NULL));
    draw(s);
    assert_in_range(pixel(s, WIDTH / 2, HEIGHT / 2)[1], encoded(pow(0.9, 3.5 / 3)) - 1, encoded(pow(0.9, 3.5 / 3)) + 1);
    daft_entity_destroy(s->scene, around, NULL);
    draw(s);
    assert_int_equal(pixel(s, WIDTH / 2, HEIGHT / 2)[1], 255);
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stacks_of_media),
        cmocka_unit_test(slabs_absorb_by_beer),
        cmocka_unit_test(balls_absorb_by_their_chords),
        cmocka_unit_test(balls_overlap),
        cmocka_unit_test(wine_in_a_glass),
        cmocka_unit_test(media_touch),
        cmocka_unit_test(apart_nothing_changes),
        cmocka_unit_test(no_light_is_made),
        cmocka_unit_test(the_same_however_computed),
        cmocka_unit_test(kept_pictures_follow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
