/* Shadows of media: what light is left behind bodies that absorb, by closed forms and beside a march in double from
 * surface to surface that asks the bodies themselves what is where. */
#include "media_bodies.h"

#include "render/media.h"

static double fraction(daft_vec3 tint, int k, double lengths) { return pow((double)daft_v3_at(tint, k), lengths); }

static void assert_near(float value, double truth)
{
    if (!(fabs((double)value - truth) < 2e-3)) fail_msg("%g, not %g", (double)value, truth);
}

/* Straight under bodies in the sun's or a lamp's light: what all of the way within leaves. */
static void shadows_absorb(void **unused)
{
    (void)unused;
    static daft_vec3 light[WIDTH * HEIGHT];
    for (int by_lamp = 0; by_lamp < 2; by_lamp++) {
        stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
        daft_scene_set_ambient(s->scene, BLACK), daft_scene_set_sky_color(s->scene, BLACK);
        add(s, box(daft_dv3(0, -0.5, 0), daft_v3(40, 1, 40), matte(s, WHITE, 0)));
        if (by_lamp)
            source(s, daft_dv3(0, 9, 0), 1);
        else
            sun(s, daft_v3(0, -1, 0), 1);
        s->view.camera = daft_camera_look_at(daft_dv3(-6, 1.5, 0), daft_dv3(0, 0, 0), 0.05f);
        s->view.aov.color = light;
        const daft_vec3 *middle = &light[HEIGHT / 2 * WIDTH + WIDTH / 2];
        daft_entity ball = add(s, sphere(daft_dv3(0, 4, 0), 0.5f, medium(s, 1.5, TINT, 0.8, 0)));
        draw(s);
        for (int k = 0; k < 3; k++) assert_near(daft_v3_at(*middle, k), fraction(TINT, k, 1 / 0.8));
        /* of two that overlap by 0.5 the higher one counts there, with its other colour */
        const daft_vec3 other = {0.9f, 0.7f, 0.3f};
        assert_true(daft_entity_set_material(s->scene, ball, medium(s, 1.5, TINT, 0.8, 1), NULL));
        add(s, box(daft_dv3(0, 4.5, 0), daft_v3(2, 1, 2), medium(s, 1.5, other, 0.8, 2)));
        draw(s);
        for (int k = 0; k < 3; k++)
            assert_near(daft_v3_at(*middle, k), fraction(TINT, k, 0.5 / 0.8) * fraction(other, k, 1 / 0.8));
        stage_drop(s);
    }
}

static uint64_t random_state;

/* 0..1 */
static double random_number(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 40) * 0x1p-24;
}

/* Multiples of an eighth, so that many faces lie in the same place; nothing below y = 1. */
static double random_eighth(double low, double high) { return low + floor(random_number() * (high - low) * 8) / 8; }

static body random_body(int priority)
{
    const daft_dvec3 low = {random_eighth(-2, 1), random_eighth(1, 3), random_eighth(-2, 1)};
    const daft_dvec3 size = {random_eighth(0.5, 2), random_eighth(0.5, 2), random_eighth(0.5, 2)};
    const double shares[3] = {random_number(), random_number(), random_number()};
    body out = {.kind = (kind)(random_number() * 3),
                .low = low,
                .high = daft_dadd(low, size),
                .wall = 0.125,
                .priority = priority,
                .index = 1 + random_number(),
                .distance = 0.5 + random_number(),
                .tint = daft_to_float(daft_dv3(0.1 + 0.9 * shares[0], 0.1 + 0.9 * shares[1], 0.1 + 0.9 * shares[2]))};
    if (out.kind == BALL) out.wall = 0.2 + random_number(), out.low.y += 1;
    return out;
}

/* What is left of light on its way from p along d, `length` metres long: piece by piece, by asking what is there.
 * False: more bodies overlap than a ray remembers. */
static bool light_left(const world *w, daft_dvec3 p, daft_dvec3 d, double length, double left[3])
{
    surface list[MOST];
    int count = 0;
    double from = 0;
    unsigned mask = 0;
    for (int i = 0; i < w->count; i++) body_surfaces(&w->bodies[i], p, d, list, &count);
    qsort(list, (size_t)count, sizeof *list, by_t);
    left[0] = left[1] = left[2] = 1;
    for (int i = 0; i <= count; i++) {
        const double until = fmin(i < count ? list[i].t : length, length);
        const int at = until > from ? body_at(w, daft_dadd(p, daft_dscale(d, (from + until) / 2)), &mask) : -1;
        for (int k = 0; k < 3 && at >= 0; k++)
            left[k] *= fraction(w->bodies[at].tint, k, (until - from) / w->bodies[at].distance);
        if (__builtin_popcount(mask) > DAFT_MEDIA) return false;
        from = fmax(from, until);
    }
    return true;
}

/* The light of a floor under bodies that overlap, fill and touch each other, from a lamp, which may be in one, or the
 * sun: the same by every instruction set and any number of threads. */
static void draw_floor(const world *w, bool by_lamp, daft_dvec3 lamp, int variant, daft_vec3 *light, stage **out)
{
    const bool by_isa = variant <= daft_isa_best();
    stage *s =
        stage_make(WIDTH, HEIGHT, by_isa ? daft_isa_name(variant) : NULL, by_isa ? 1 : 2 * (variant - daft_isa_best()));
    daft_scene_set_ambient(s->scene, BLACK), daft_scene_set_sky_color(s->scene, BLACK);
    add(s, box(daft_dv3(0, -0.5, 0), daft_v3(40, 1, 40), matte(s, WHITE, 0)));
    add_bodies(s, w);
    if (by_lamp)
        source(s, lamp, 1);
    else
        sun(s, daft_to_float(daft_dscale(lamp, -1)), 1);
    s->view.camera = daft_camera_look_at(daft_dv3(-4, 0.9, 0), daft_dv3(-1, 0, 0), 1);
    s->view.aov.color = light;
    draw(s);
    *out = s;
}

static bool light_at(const world *w, daft_dvec3 p, bool by_lamp, daft_dvec3 lamp, double light[3])
{
    const daft_dvec3 to = by_lamp ? daft_dsub(lamp, p) : lamp;
    const double length = sqrt(daft_ddot(to, to));
    if (!light_left(w, p, daft_dscale(to, 1 / length), by_lamp ? length : 100, light)) return false;
    for (int k = 0; k < 3; k++) light[k] *= to.y / length;
    return true;
}

/* False: a little aside it is another, as at the rim of a ball, so rounding decides. */
static bool steady_light(const world *w, daft_dvec3 p, bool by_lamp, daft_dvec3 lamp, double light[3])
{
    if (!light_at(w, p, by_lamp, lamp, light)) return false;
    for (int i = 0; i < 4; i++) {
        double aside[3];
        const double by = i & 1 ? 1e-5 : -1e-5;
        if (!light_at(w, daft_dadd(p, i < 2 ? daft_dv3(by, 0, 0) : daft_dv3(0, 0, by)), by_lamp, lamp, aside))
            return false;
        for (int k = 0; k < 3; k++)
            if (fabs(aside[k] - light[k]) > 2e-4) return false;
    }
    return true;
}

static void compare_floor(const stage *s, const world *w, bool by_lamp, daft_dvec3 lamp, const daft_vec3 *light)
{
    int looked = 0;
    for (int i = 0; i < s->pixels; i++) {
        const daft_dvec3 ray = pixel_ray(s, i % WIDTH, i / WIDTH), eye = s->view.camera.position;
        double truth[3];
        if (!(ray.y < -0.1 * sqrt(daft_ddot(ray, ray)))) continue;
        if (!steady_light(w, daft_dadd(eye, daft_dscale(ray, eye.y / -ray.y)), by_lamp, lamp, truth)) continue;
        looked++;
        for (int k = 0; k < 3; k++)
            if (!(fabs((double)daft_v3_at(light[i], k) - truth[k]) < 1e-3))
                fail_msg("pixel %d, %d: %g, not %g", i % WIDTH, i / WIDTH, (double)daft_v3_at(light[i], k), truth[k]);
    }
    assert_true(looked > s->pixels / 2);
}

static void shadows_of_many(void **unused)
{
    (void)unused;
    static daft_vec3 light[WIDTH * HEIGHT], other[WIDTH * HEIGHT];
    const char *seed = getenv("DAFT_SEED");
    random_state = seed ? strtoull(seed, NULL, 0) : 18;
    print_message("seed %llu\n", (unsigned long long)random_state);
    for (int round = 0; round < 8; round++) {
        body bodies[7];
        const world w = {bodies, 4 + round % 4, 0, 0};
        for (int i = 0; i < w.count; i++) bodies[i] = random_body(1 + (i + round) % w.count);
        const bool by_lamp = round % 2;
        const daft_dvec3 lamp = {random_number(), by_lamp ? 2.5 + 2 * random_number() : 2, random_number()};
        stage *s;
        draw_floor(&w, by_lamp, lamp, 0, light, &s);
        compare_floor(s, &w, by_lamp, lamp, light);
        stage_drop(s);
        for (int variant = 1; variant <= daft_isa_best() + 2; variant++) {
            draw_floor(&w, by_lamp, lamp, variant, other, &s);
            assert_memory_equal(light, other, sizeof light);
            stage_drop(s);
        }
    }
}

/* On the ground of a lake: what the sun's way down leaves, and the way up to the camera under water. */
static void lake(void **unused)
{
    (void)unused;
    static daft_vec3 light[WIDTH * HEIGHT];
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    daft_scene_set_ambient(s->scene, BLACK), daft_scene_set_sky_color(s->scene, BLACK);
    add(s, box(daft_dv3(0, -3, 0), daft_v3(100, 6, 100), medium(s, (double)1.33f, TINT, 4, 0)));
    add(s, box(daft_dv3(0, -5.5, 0), daft_v3(90, 1, 90), matte(s, WHITE, 0)));
    sun(s, daft_v3(0, -1, 0), 1);
    s->view.camera = daft_camera_look_at(daft_dv3(0.5, -2, 0), daft_dv3(0, -5, 0), 0.6f), s->view.aov.color = light;
    draw(s);
    const double down = 5, up = sqrt(9.25);
    const daft_vec3 middle = light[HEIGHT / 2 * WIDTH + WIDTH / 2];
    for (int k = 0; k < 3; k++) assert_near(daft_v3_at(middle, k), fraction(TINT, k, (down + up) / 4));
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shadows_absorb),
        cmocka_unit_test(shadows_of_many),
        cmocka_unit_test(lake),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
