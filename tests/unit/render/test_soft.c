/* render: lights with a size, ambient occlusion, and denoising of what they sample. Against the truth in closed form,
 * by integration, or by many samples. */
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

#include "stage.h"

static void add(stage *s, daft_entity_def def, float white)
{
    daft_error error = {0};
    daft_material_def m = daft_default_material_def();
    m.ambient = m.diffuse = (daft_vec3){white, white, white}, m.specular = (daft_vec3){0, 0, 0};
    def.material = daft_material_create(s->scene, &m, &error);
    if (!daft_entity_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
}

static void add_box(stage *s, daft_dvec3 at, daft_vec3 size)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = size, def.position = at;
    add(s, def, 1);
}

static void add_light(stage *s, daft_light_kind kind, float size)
{
    daft_error error = {0};
    daft_light_def def = daft_default_light_def();
    def.kind = kind, def.position = (daft_dvec3){0, 4, 0}, def.direction = (daft_vec3){0, -1, 0};
    def.radius = kind == DAFT_LIGHT_SUN ? 0 : size, def.disc = kind == DAFT_LIGHT_SUN ? size : 0;
    assert_true(daft_light_create(s->scene, &def, &error).id);
}

/* Straight down on a floor, 8 m wide at y = 0. */
static void look_down(stage *s)
{
    s->view.camera.position = (daft_dvec3){0, 3, 0};
    s->view.camera.pitch = 1.5707963f, s->view.camera.fov = 1;
    s->view.quality.edge_samples = 0;
}

static daft_dvec3 floor_point(const stage *s, int pixel)
{
    /* Looking down with yaw 0: up in the picture is +x, right is +z. */
    const double scale = 3 / (WIDTH / 2.0 / tan((double)s->view.camera.fov / 2));
    return (daft_dvec3){(HEIGHT / 2.0 - pixel / WIDTH - 0.5) * scale, 0, (pixel % WIDTH + 0.5 - WIDTH / 2.0) * scale};
}

/* The part of a unit disc on one side of a chord, `edge` beyond its middle. */
static double open_disc(double edge)
{
    const double d = fmax(-1, fmin(1, edge));
    return 0.5 + (d * sqrt(1 - d * d) + asin(d)) / 3.14159265358979;
}

/* A screen at 3.5 m hides what is over x < 0 of the light, at 4 m. */
static void penumbras_are_the_open_part_of_the_light(void **unused)
{
    (void)unused;
    const daft_light_kind kinds[] = {DAFT_LIGHT_POINT, DAFT_LIGHT_SUN, DAFT_LIGHT_SPOT};
    for (int k = 0; k < 3; k++) {
        stage *s = stage_make(2, NULL);
        look_down(s);
        daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
        add_box(s, (daft_dvec3){0, -0.05, 0}, (daft_vec3){8, 0.1f, 8});
        add_box(s, (daft_dvec3){-20, 3.5, 0}, (daft_vec3){40, 1e-5f, 40}); /* above the camera */
        const float size = kinds[k] == DAFT_LIGHT_SUN ? 0.1f : 0.08f;
        add_light(s, kinds[k], size);
        s->view.quality.shadow_samples = 64, s->view.quality.denoise = 0;
        assert_true(draw(s)->effects[DAFT_EFFECT_SHADOW].rays > 64 * PIXELS / 2);
        double worst = 0, sum = 0;
        int soft = 0;
        for (int i = 0; i < PIXELS; i++) {
            const daft_dvec3 p = floor_point(s, i);
            const double length = sqrt(p.x * p.x + p.z * p.z + 16),
                         cosine = kinds[k] == DAFT_LIGHT_SUN ? 1 : 4 / length;
            /* The plane through the point and the screen's edge cuts the disc, which faces the point, along a chord. */
            const double norm = sqrt(12.25 + p.x * p.x), off = 0.5 * p.x / norm, along = off / length;
            const double open = kinds[k] == DAFT_LIGHT_SUN ? open_disc(p.x / (3.5 * tan(0.1)))
                                                           : open_disc(off / ((double)size * sqrt(1 - along * along)));
            double falloff = 1;
            if (kinds[k] == DAFT_LIGHT_SPOT) {
                const double outer = cos(0.5235987756), t = (4 / length - outer) / (cos(0.3926990817) - outer);
                falloff = t < 0 ? 0 : t > 1 ? 1 : t * t * (3 - 2 * t);
            }
            const double gap = fabs((double)s->color[i].x - open * cosine * falloff);
            worst = fmax(worst, gap), sum += gap;
            soft += open > 0.05 && open < 0.95 && falloff > 0;
        }
        print_message("kind %d: off by %.3f at most, %.4f in the mean, %d pixels in penumbra\n", k, worst, sum / PIXELS,
                      soft);
        assert_true(soft > 300 && worst < 0.08 && sum / PIXELS < 0.008);
        stage_drop(s);
    }
}

/* Beside a wall of height h, at distance d, far along it: rays within reach of the wall are lost. */
static void occlusion_is_the_open_part_of_the_hemisphere(void **unused)
{
    (void)unused;
    stage *s = stage_make(2, NULL);
    look_down(s);
    daft_scene_set_ambient(s->scene, (daft_vec3){1, 1, 1});
    daft_scene_set_ambient_occlusion(s->scene, 1);
    add_box(s, (daft_dvec3){0, -0.05, 0}, (daft_vec3){8, 0.1f, 8});
    add_box(s, (daft_dvec3){-4.5, 1.0, 0}, (daft_vec3){9, 2, 20}); /* its side is at x = 0 */
    s->view.quality.occlusion_samples = 64, s->view.quality.denoise = 0;
    assert_true(draw(s)->effects[DAFT_EFFECT_OCCLUSION].ran);
    double worst = 0, sum = 0;
    int count = 0;
    for (int i = 0; i < PIXELS; i++) {
        const double d = floor_point(s, i).x;
        if (!(d > 0.02) || d > 1.2) continue;
        /* Cosine-weighted directions that meet the plane x = 0 within 1 m: u = -direction.x above d. The density of u
         * is 2/pi sqrt(1 - u²) on the disc's axis. */
        const double open = d >= 1 ? 1 : 0.5 + (d * sqrt(1 - d * d) + asin(d)) / 3.14159265358979;
        const double gap = fabs((double)s->color[i].x - open);
        worst = fmax(worst, gap), sum += gap, count++;
    }
    print_message("off by %.3f at most, %.4f in the mean of %d\n", worst, sum / count, count);
    assert_true(count > 1000 && worst < 0.08 && sum / count < 0.012);
    stage_drop(s);
}

/* 64 lights of which three reach what is seen: the others cast no ray, light no tile and change no byte. */
static void lights_out_of_sight_are_not_asked(void **unused)
{
    (void)unused;
    static uint8_t few[4 * PIXELS];
    uint64_t rays = 0, kept = 0;
    uint32_t tiles = 0;
    for (int k = 0; k < 2; k++) {
        stage *s = stage_make(2, NULL);
        daft_error error = {0};
        s->view.camera.position = (daft_dvec3){0, 2, 0}, s->view.camera.pitch = 0.3f;
        s->view.quality.half_light = false;
        add_box(s, (daft_dvec3){0, -0.05, 0}, (daft_vec3){60, 0.1f, 60});
        add_box(s, (daft_dvec3){6, 0.5, 1}, (daft_vec3){1, 1, 1});
        for (int i = 0; i < 64; i++) {
            daft_light_def def = daft_default_light_def();
            def.kind = DAFT_LIGHT_SPOT, def.color = (daft_vec3){0.3f, 0.3f, 0.3f};
            def.position = i < 3 ? (daft_dvec3){6, 4, i - 1} : (daft_dvec3){-10 - i % 8, 4, i / 8 - 4};
            def.radius = i % 2 ? 0.1f : 0, def.range = i % 3 ? 0 : 9;
            if (i >= 3 && k == 0) continue;
            assert_true(daft_light_create(s->scene, &def, &error).id);
        }
        const daft_counters *c = draw(s);
        const daft_effect *shadow = &c->effects[DAFT_EFFECT_SHADOW], *light = &c->effects[DAFT_EFFECT_LIGHTING];
        if (k == 0) {
            memcpy(few, daft_image_pixels(s->image), sizeof few);
            rays = shadow->rays, kept = c->shadow_points_kept, tiles = light->tiles;
            assert_true(rays > 1000 && tiles > 5);
        } else {
            print_message("%llu shadow rays of 3 lights, %llu of 64\n", (unsigned long long)rays,
                          (unsigned long long)shadow->rays);
            assert_true(shadow->rays == rays && c->shadow_points_kept == kept && light->tiles == tiles);
            assert_memory_equal(few, daft_image_pixels(s->image), sizeof few);
        }
        stage_drop(s);
    }
}

/* Many lights of which each reaches little: the sum of what each gives, in double, at every pixel. */
static void lights_end_where_they_say(void **unused)
{
    (void)unused;
    enum { LIGHTS = 64 };
    static daft_light_def defs[LIGHTS];
    static const uint64_t seed = 20261123;
    uint64_t state = seed;
    print_message("seed %llu\n", (unsigned long long)seed);
    stage *s = stage_make(2, NULL);
    look_down(s);
    daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
    add_box(s, (daft_dvec3){0, -0.05, 0}, (daft_vec3){8, 0.1f, 8});
    for (int i = 0; i < LIGHTS; i++) {
        double r[8];
        for (int k = 0; k < 8; k++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            r[k] = (double)(state >> 40) / (1 << 24);
        }
        daft_light_def def = daft_default_light_def();
        def.kind = i % 2 ? DAFT_LIGHT_SPOT : DAFT_LIGHT_POINT, def.casts_shadow = false;
        def.position = (daft_dvec3){3 * r[0] - 1.5, 0.1 + 1.5 * r[1], 4 * r[2] - 2};
        def.direction = (daft_vec3){(float)r[3] - 0.5f, (float)(-0.2 - r[4]), (float)r[5] - 0.5f};
        def.range = i % 3 == 2 ? 0 : (float)(0.3 + r[6]);
        def.inverse_square = i % 5 == 1;
        if (def.inverse_square) def.position.y += 0.5; /* nearer, floats' rounding of places shows */
        def.outer_angle = (float)(0.1 + 1.8 * r[7] * r[7]), def.inner_angle = 0.6f * def.outer_angle;
        def.color = (daft_vec3){0.5f, 0.5f, 0.5f};
        defs[i] = def;
        assert_true(daft_light_create(s->scene, &def, NULL).id);
    }
    draw(s);
    double worst = 0, least = 1e9, most = 0;
    for (int i = 0; i < PIXELS; i++) {
        const daft_dvec3 p = floor_point(s, i);
        double sum = 0;
        for (int k = 0; k < LIGHTS; k++) {
            const daft_light_def *d = &defs[k];
            const double l[3] = {d->position.x - p.x, d->position.y, d->position.z - p.z};
            const double length = sqrt(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]);
            double light = 0.5 * l[1] / length;
            const double far = d->range > 0 ? length / (double)d->range : 0;
            light *=
                d->inverse_square ? fmax(0, 1 - pow(far, 4)) / (length * length) : pow(fmax(0, 1 - pow(far, 2)), 2);
            if (d->kind == DAFT_LIGHT_SPOT) {
                const double a[3] = {(double)d->direction.x, (double)d->direction.y, (double)d->direction.z};
                const double size = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
                const double c = -(a[0] * l[0] + a[1] * l[1] + a[2] * l[2]) / size / length,
                             outer = cos((double)d->outer_angle), inner = cos((double)d->inner_angle);
                const double t = fmax(0, fmin(1, (c - outer) / (inner - outer)));
                light *= t * t * (3 - 2 * t);
            }
            sum += light;
        }
        worst = fmax(worst, fabs(sum - (double)s->color[i].x)), least = fmin(least, sum), most = fmax(most, sum);
    }
    print_message("%.3f to %.3f, off by %.6f at most\n", least, most, worst);
    assert_true(worst < 1e-3 && most > least + 0.5);
    stage_drop(s);
}

/* What the scene does not ask for costs nothing, and changes no byte. */
static void nothing_is_sampled_that_nobody_asked_for(void **unused)
{
    (void)unused;
    for (int k = 0; k < 3; k++) {
        stage *s = stage_make(2, NULL);
        look_down(s);
        add_box(s, (daft_dvec3){0, -0.05, 0}, (daft_vec3){8, 0.1f, 8});
        add_box(s, (daft_dvec3){0, 1, 0}, (daft_vec3){1, 1, 1});
        add_light(s, DAFT_LIGHT_POINT, k == 1 ? 0.2f : 0);
        if (k == 2) daft_scene_set_ambient_occlusion(s->scene, 2);
        s->view.quality.shadow_samples = s->view.quality.occlusion_samples = k ? 0 : 8;
        const daft_counters *c = draw(s);
        assert_false(c->effects[DAFT_EFFECT_OCCLUSION].ran || c->effects[DAFT_EFFECT_DENOISE].ran);
        assert_int_equal(c->effects[DAFT_EFFECT_OCCLUSION].rays, 0);
        assert_true(c->effects[DAFT_EFFECT_SHADOW].rays <= PIXELS);
        stage_drop(s);
    }
    /* sharp shadows are those of a point: with a size and no samples, the same bytes */
    stage *a = stage_make(1, NULL), *b = stage_make(1, NULL), *both[2] = {a, b};
    for (int k = 0; k < 2; k++) {
        look_down(both[k]);
        add_box(both[k], (daft_dvec3){0, -0.05, 0}, (daft_vec3){8, 0.1f, 8});
        add_box(both[k], (daft_dvec3){0.3, 1, 0.2}, (daft_vec3){1, 1, 1});
        add_light(both[k], DAFT_LIGHT_POINT, k ? 0.3f : 0);
        both[k]->view.quality.shadow_samples = 0;
        draw(both[k]);
    }
    assert_memory_equal(daft_image_pixels(a->image), daft_image_pixels(b->image), 4 * PIXELS);
    stage_drop(a), stage_drop(b);
}

/* ---- denoising ---- */

static daft_vec3 byte_color(const stage *s, int pixel)
{
    const uint8_t *p = daft_image_pixels(s->image) + 4 * pixel;
    return (daft_vec3){(float)p[0] / 255, (float)p[1] / 255, (float)p[2] / 255};
}

static float distance2(daft_vec3 a, daft_vec3 b)
{
    const float x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
    return x * x + y * y + z * z;
}

static void furnish(stage *s)
{
    daft_error error = {0};
    if (!daft_scene_load(s->scene, DAFT_ROOT "/assets/scenes/lamps.scene", &error)) fail_msg("%s", error.message);
    assert_true(daft_scene_get_camera(s->scene, 0, &s->view.camera, &error));
}

/* A ball that passes leaves nothing in a tile that then sees the sky alone, also for the filter of tiles beside it. */
static void tiles_that_see_the_sky_are_not_filtered(void **unused)
{
    (void)unused;
    daft_error error = {0};
    stage *s = stage_make(2, NULL), *fresh = stage_make(2, NULL), *both[2] = {s, fresh};
    daft_entity ball = {0};
    for (int k = 0; k < 2; k++) {
        furnish(both[k]);
        daft_scene_set_sky_color(both[k]->scene, (daft_vec3){0.1f, 0.2f, 0.3f});
    }
    daft_entity_def def = daft_default_entity_def();
    const daft_camera *c = &s->view.camera;
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 3, def.position = c->position;
    def.position.x += 6 * cos((double)c->yaw), def.position.z += 6 * sin((double)c->yaw);
    ball = daft_entity_create(s->scene, &def, &error);
    assert_true(ball.id);
    draw(s);
    assert_true(daft_entity_destroy(s->scene, ball, &error));
    draw(s), draw(fresh);
    assert_memory_equal(daft_image_pixels(s->image), daft_image_pixels(fresh->image), 4 * PIXELS);
    stage_drop(s), stage_drop(fresh);
}

/* Far closer where rays are few, and no farther off where they are many. */
static void denoised_is_closer(void **unused)
{
    (void)unused;
    static daft_vec3 truth[PIXELS];
    stage *s = stage_make(2, NULL);
    furnish(s);
    s->view.quality.edge_samples = 0, s->view.quality.denoise = 0, s->view.quality.half_light = 0;
    s->view.quality.shadow_samples = s->view.quality.occlusion_samples = 64;
    draw(s);
    memcpy(truth, s->color, sizeof truth);
    double raw[3], filtered[3];
    for (int k = 0; k < 3; k++) {
        s->view.quality.shadow_samples = s->view.quality.occlusion_samples = 1 << 2 * k;
        s->view.quality.denoise = 0, draw(s), raw[k] = distance(s->color, truth);
        s->view.quality.denoise = 1;
        assert_true(draw(s)->effects[DAFT_EFFECT_DENOISE].ran);
        filtered[k] = distance(s->color, truth);
        print_message("%d samples: error %.4f, denoised %.4f\n", 1 << 2 * k, raw[k], filtered[k]);
    }
    assert_true(filtered[0] < 0.45 * raw[0] && filtered[1] < 0.75 * raw[1] && filtered[2] < 1.05 * raw[2]);
    stage_drop(s);
}

/* Half the resolution asks a quarter of the rays, and comes nearly as close. Without a filter it changes nothing. */
static void half_the_resolution_is_nearly_as_close(void **unused)
{
    (void)unused;
    static daft_vec3 truth[PIXELS], plain[PIXELS];
    double off[2];
    uint64_t rays[2];
    stage *s = stage_make(2, NULL);
    furnish(s);
    s->view.quality.edge_samples = 0, s->view.quality.denoise = 0;
    s->view.quality.shadow_samples = s->view.quality.occlusion_samples = 64;
    draw(s);
    memcpy(truth, s->color, sizeof truth);
    for (int half = 0; half < 2; half++) {
        s->view.quality.shadow_samples = s->view.quality.occlusion_samples = 1;
        s->view.quality.half_light = half;
        s->view.quality.denoise = 0, draw(s);
        if (half == 0) memcpy(plain, s->color, sizeof plain);
        assert_memory_equal(plain, s->color, sizeof plain);
        s->view.quality.denoise = 1;
        rays[half] = draw(s)->effects[DAFT_EFFECT_OCCLUSION].rays;
        off[half] = distance(s->color, truth);
    }
    print_message("error %.4f by %llu rays, %.4f by %llu\n", off[0], (unsigned long long)rays[0], off[1],
                  (unsigned long long)rays[1]);
    assert_true(off[1] < 1.5 * off[0] && 3 * rays[1] < rays[0]);
    stage_drop(s);
}

/* Between two long walls the floor is as dark all along them: no stripes, which even places of samples would leave at
 * half the resolution if the filter reached less far. */
static void what_is_even_stays_even(void **unused)
{
    (void)unused;
    stage *s = stage_make(2, NULL);
    look_down(s);
    daft_scene_set_ambient_occlusion(s->scene, 1.5f);
    add_box(s, (daft_dvec3){0, -0.05, 0}, (daft_vec3){40, 0.1f, 40});
    for (int k = -1; k <= 1; k += 2) add_box(s, (daft_dvec3){k, 0.5, 0}, (daft_vec3){1.2f, 1, 40});
    s->view.quality.denoise = s->view.quality.half_light = true, s->view.quality.occlusion_samples = 1;
    draw(s);
    double worst = 0;
    for (int y = HEIGHT / 2 - 16; y < HEIGHT / 2 + 16; y++) {
        double sum = 0, squares = 0;
        for (int x = 40; x < WIDTH - 40; x++) {
            const double light = (double)s->color[y * WIDTH + x].x;
            sum += light, squares += light * light;
        }
        const double mean = sum / (WIDTH - 80);
        worst = fmax(worst, sqrt(fmax(squares / (WIDTH - 80) - mean * mean, 0)) / mean);
    }
    print_message("along walls: uneven by %.4f\n", worst);
    assert_true(worst < 0.05);
    stage_drop(s);
}

/* More samples at edges take the filtered light of pixels like them: no grain, and hardly a ray more. */
static void edges_are_as_smooth_as_what_is_filtered(void **unused)
{
    (void)unused;
    static daft_vec3 truth[PIXELS];
    double off[2];
    uint64_t rays[2];
    stage *s = stage_make(2, NULL);
    furnish(s);
    s->view.quality.samples = 16, s->view.quality.edge_samples = 0, s->view.quality.denoise = 0;
    s->view.quality.shadow_samples = s->view.quality.occlusion_samples = 16;
    draw(s);
    for (int i = 0; i < PIXELS; i++) truth[i] = byte_color(s, i);
    for (int k = 0; k < 2; k++) {
        s->view.quality = daft_preset_quality(DAFT_PRESET_GAME);
        s->view.quality.edge_samples = k ? 16 : 0;
        rays[k] = draw(s)->effects[DAFT_EFFECT_OCCLUSION].rays;
        off[k] = 0;
        for (int i = 0; i < PIXELS; i++) off[k] += (double)distance2(byte_color(s, i), truth[i]);
        off[k] = sqrt(off[k] / PIXELS);
    }
    print_message("edges: error %.4f, without %.4f; %llu rays of %llu\n", off[1], off[0], (unsigned long long)rays[1],
                  (unsigned long long)rays[0]);
    assert_true(off[1] < 0.8 * off[0] && (double)rays[1] < 1.5 * (double)rays[0]);
    stage_drop(s);
}

/* What was found before is carried along with a camera that moves, and forgotten where a cut says so. */
static void pictures_that_follow_each_other_help(void **unused)
{
    (void)unused;
    for (int half = 0; half < 2; half++) {
        static daft_vec3 truth[PIXELS], last[PIXELS], single[PIXELS];
        daft_error error = {0};
        stage *s = stage_make(2, NULL);
        furnish(s);
        s->view.quality.edge_samples = 0, s->view.quality.shadow_samples = s->view.quality.occlusion_samples = 1;
        s->view.quality.half_light = half;
        assert_non_null(s->view.history = daft_history_create(s->engine, &error));
        const daft_camera from = s->view.camera;
        for (int k = 0; k < 12; k++) {
            s->view.camera = from;
            s->view.camera.yaw += 0.004f * (float)k, s->view.camera.position.z += 0.02 * k;
            draw(s);
        }
        memcpy(last, s->color, sizeof last);
        daft_history_forget(s->view.history);
        draw(s);
        memcpy(single, s->color, sizeof single);
        daft_history_destroy(s->view.history), s->view.history = NULL;
        s->view.quality.shadow_samples = s->view.quality.occlusion_samples = 64, s->view.quality.denoise = 0;
        draw(s);
        memcpy(truth, s->color, sizeof truth);
        const double with = distance(last, truth), without = distance(single, truth);
        print_message("error %.4f after twelve pictures, %.4f alone\n", with, without);
        assert_true(with < (half ? 0.95 : 0.9) * without);
        stage_drop(s);
    }
}

/* A ball that was in front leaves no trail on what it hid. */
static void what_was_hidden_begins_anew(void **unused)
{
    (void)unused;
    daft_error error = {0};
    stage *s = stage_make(2, NULL), *fresh = stage_make(2, NULL), *both[2] = {s, fresh};
    daft_entity ball[2];
    for (int k = 0; k < 2; k++) {
        look_down(both[k]);
        daft_scene_set_ambient(both[k]->scene, (daft_vec3){0, 0, 0});
        add_box(both[k], (daft_dvec3){0, -0.05, 0}, (daft_vec3){8, 0.1f, 8});
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_SPHERE, def.radius = 0.5f, def.position = (daft_dvec3){0, 1, k ? 40 : 0};
        def.casts_shadow = false;
        ball[k] = daft_entity_create(both[k]->scene, &def, &error);
        assert_true(ball[k].id);
        add_light(both[k], DAFT_LIGHT_POINT, 0.3f);
        both[k]->view.quality.shadow_samples = 4;
        assert_non_null(both[k]->view.history = daft_history_create(both[k]->engine, &error));
    }
    for (int i = 0; i < 5; i++) draw(s), draw(fresh);
    const daft_transform away = {.position = {0, 1, 40}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    assert_true(daft_entity_set_transform(s->scene, ball[0], &away, true, &error));
    draw(s), draw(fresh);
    for (int i = 0; i < PIXELS; i++) assert_true(fabs((double)s->color[i].x - (double)fresh->color[i].x) < 0.02);
    stage_drop(s), stage_drop(fresh);
}

static void *fill(void *user, size_t size, size_t alignment)
{
    size_t up = (size + alignment - 1) / alignment * alignment;
    void *memory = aligned_alloc(alignment < sizeof(void *) ? sizeof(void *) : alignment, (up + 15) / 16 * 16);
    if (memory) memset(memory, *(const int *)user, size);
    return memory;
}

static void give_back(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/* Whatever memory holds: nothing of it is read before it is written, not even to weigh it with 0, which of what is no
 * number makes none. Kinds of sampled light come and go, and sizes change. */
static void what_memory_held_is_not_seen(void **unused)
{
    (void)unused;
    enum { PICTURES = 40 };
    static uint8_t first[PICTURES][4 * PIXELS];
    for (int k = 0; k < 2; k++) {
        int byte = k ? 0xff : 0;
        daft_error error = {0};
        daft_engine_def def = daft_default_engine_def();
        def.threads = 2, def.allocator = (daft_allocator){.user = &byte, .allocate = fill, .release = give_back};
        stage *s = stage_make_with(&def);
        furnish(s);
        assert_non_null(s->view.history = daft_history_create(s->engine, &error));
        for (int i = 0; i < PICTURES; i++) {
            s->view.camera.yaw += 0.02f, s->view.camera.pitch -= 0.01f;
            s->view.quality.half_light = i % 8 < 4;
            s->view.quality.shadow_samples = i % 8 == 2 ? 0 : 1;
            draw(s);
            if (k == 0) memcpy(first[i], daft_image_pixels(s->image), sizeof first[i]);
            assert_memory_equal(first[i], daft_image_pixels(s->image), sizeof first[i]);
        }
        stage_drop(s);
    }
}

/* The same bytes for any number of threads and any instruction set, as a whole and in bands. */
static void denoised_pictures_are_the_same_everywhere(void **unused)
{
    (void)unused;
    static uint8_t first[4 * PIXELS];
    for (int isa = -1; isa < 8; isa++) {
        static const char *const NAMES[] = {"plain", "sse2", "avx2", "avx512"};
        daft_engine_def def = daft_default_engine_def();
        if (isa >= 4) break;
        def.isa = isa < 0 ? NULL : NAMES[isa];
        daft_engine *probe = daft_engine_create(&def, NULL);
        if (!probe) continue; /* this machine or build lacks it */
        daft_engine_destroy(probe);
        stage *s = stage_make(isa + 2, def.isa);
        furnish(s);
        draw(s);
        if (isa < 0) memcpy(first, daft_image_pixels(s->image), sizeof first);
        assert_memory_equal(first, daft_image_pixels(s->image), sizeof first);
        memset(daft_image_pixels(s->image), 7, 4 * PIXELS);
        for (int row = 0; row < HEIGHT; row += 32) {
            s->view.first_row = row, s->view.row_count = row + 32 < HEIGHT ? 32 : 0;
            draw(s);
        }
        assert_memory_equal(first, daft_image_pixels(s->image), sizeof first);
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(penumbras_are_the_open_part_of_the_light),
                                       cmocka_unit_test(occlusion_is_the_open_part_of_the_hemisphere),
                                       cmocka_unit_test(lights_end_where_they_say),
                                       cmocka_unit_test(lights_out_of_sight_are_not_asked),
                                       cmocka_unit_test(nothing_is_sampled_that_nobody_asked_for),
                                       cmocka_unit_test(denoised_is_closer),
                                       cmocka_unit_test(what_memory_held_is_not_seen),
                                       cmocka_unit_test(half_the_resolution_is_nearly_as_close),
                                       cmocka_unit_test(what_is_even_stays_even),
                                       cmocka_unit_test(edges_are_as_smooth_as_what_is_filtered),
                                       cmocka_unit_test(tiles_that_see_the_sky_are_not_filtered),
                                       cmocka_unit_test(pictures_that_follow_each_other_help),
                                       cmocka_unit_test(what_was_hidden_begins_anew),
                                       cmocka_unit_test(denoised_pictures_are_the_same_everywhere)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
