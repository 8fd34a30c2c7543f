/* render: fog against Bouguer's law, integrated in double along each ray, and in mirrors against an unfolded scene. */
#include "daft.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "stage.h"

static const daft_fog THIN = {{0.4f, 0.5f, 0.7f}, 0.05f, 3, 1, 0};

static void add_box(stage *s, daft_dvec3 at, daft_vec3 size, float white, float mirror)
{
    daft_error error = {0};
    daft_material_def m = daft_default_material_def();
    m.ambient = m.diffuse = (daft_vec3){white, white, white}, m.specular = (daft_vec3){0, 0, 0};
    m.mirror = mirror;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = size, def.position = at;
    def.material = daft_material_create(s->scene, &m, &error);
    if (!daft_entity_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
}

/* A floor at y = 0 and a wall, in a light from everywhere, seen along +x from 2 m above. */
static stage *floor_stage(const char *isa)
{
    stage *s = stage_make(2, isa);
    s->view.camera.position = (daft_dvec3){0, 2, 0};
    s->view.quality.edge_samples = 0;
    daft_scene_set_ambient(s->scene, (daft_vec3){1, 1, 1});
    daft_scene_set_sky_gradient(s->scene, (daft_vec3){0.1f, 0.2f, 0.9f}, (daft_vec3){0.9f, 0.8f, 0.7f});
    add_box(s, (daft_dvec3){0, -0.5, 0}, (daft_vec3){200, 1, 200}, 0.8f, 0);
    add_box(s, (daft_dvec3){14, 1.5, 3}, (daft_vec3){1, 9, 5}, 0.3f, 0);
    return s;
}

static void set_fog(stage *s, daft_fog fog)
{
    daft_error error = {0};
    if (!daft_scene_set_fog(s->scene, &fog, &error)) fail_msg("%s", error.message);
}

/* The fraction of light that comes through from `length` metres away, by the midpoint rule in double. */
static double through(const daft_fog *fog, double rise, double length)
{
    enum { STEPS = 4000 };
    const double end = isinf(length) ? 30 * (double)fog->height / fmax(rise, 1e-3) : length;
    double depth = 0;
    if (!(fog->height > 0) && isinf(length)) return 0;
    if (isinf(length) && rise <= 0) return 0;
    for (int i = 0; i < STEPS; i++) {
        const double y = 2 + rise * end * (i + 0.5) / STEPS,
                     thin = fog->height > 0 ? exp(-(y - (double)fog->base) / (double)fog->height) : 1;
        depth += (double)fog->density * thin * end / STEPS;
    }
    return exp(-depth);
}

static daft_vec3 ray_of(const stage *s, int pixel)
{
    const double x = WIDTH / 2.0 / tan((double)s->view.camera.fov / 2), y = HEIGHT / 2.0 - pixel / WIDTH - 0.5,
                 z = pixel % WIDTH + 0.5 - WIDTH / 2.0, length = sqrt(x * x + y * y + z * z);
    return (daft_vec3){(float)(x / length), (float)(y / length), (float)(z / length)};
}

static void fog_is_bouguers_law(void **unused)
{
    (void)unused;
    static daft_vec3 clear[PIXELS];
    const daft_vec3 color = {0.4f, 0.5f, 0.7f};
    const daft_fog fogs[] = {{color, 0.08f, 0, 0, 0}, THIN, {color, 0.3f, 0.5f, -0.5f, 0}, {color, 0.002f, 40, 0, 0}};
    for (size_t k = 0; k < sizeof fogs / sizeof *fogs; k++) {
        stage *s = floor_stage(NULL);
        assert_false(draw(s)->effects[DAFT_EFFECT_FOG].ran);
        memcpy(clear, s->color, sizeof clear);
        set_fog(s, fogs[k]);
        assert_true(draw(s)->effects[DAFT_EFFECT_FOG].ran);
        double worst = 0;
        int skies = 0;
        for (int i = 0; i < PIXELS; i++) {
            const daft_vec3 d = ray_of(s, i);
            if (isinf(s->depth[i]) && fabs((double)d.y) < 0.03) continue; /* too long a way for the sum */
            skies += isinf(s->depth[i]);
            const double left = through(&fogs[k], (double)d.y, (double)s->depth[i]),
                         wanted = (double)clear[i].z * left + 0.7f * (1 - left);
            worst = fmax(worst, fabs((double)s->color[i].z - wanted));
        }
        print_message("fog %zu: off by %.2g at most, %d pixels of sky\n", k, worst, skies);
        assert_true(worst < 2e-5 && skies > 1000);
        stage_drop(s);
    }
}

/* A room in a mirror, through fog, is the room as far behind it. */
static void mirrors_show_the_fog_on_all_of_the_way(void **unused)
{
    (void)unused;
    static daft_vec3 shown[PIXELS];
    for (int k = 0; k < 2; k++) {
        stage *s = stage_make(2, NULL);
        s->view.camera.position = (daft_dvec3){0, 2, 0};
        s->view.quality.edge_samples = 0;
        daft_scene_set_ambient(s->scene, (daft_vec3){1, 1, 1});
        daft_scene_set_sky_gradient(s->scene, (daft_vec3){0.1f, 0.2f, 0.9f}, (daft_vec3){0.9f, 0.8f, 0.7f});
        set_fog(s, THIN);
        if (k == 0) add_box(s, (daft_dvec3){5.5, 0, 0}, (daft_vec3){1, 400, 400}, 0, 1);
        add_box(s, (daft_dvec3){k == 0 ? -6 : 16, 1, 2}, (daft_vec3){2, 3, 4}, 0.9f, 0);
        assert_true(draw(s)->effects[DAFT_EFFECT_FOG].ran);
        if (k == 0) memcpy(shown, s->color, sizeof shown);
        if (k == 1) {
            const double gap = distance(shown, s->color);
            print_message("apart by %.2g\n", gap);
            assert_true(gap < 0.01);
        }
        stage_drop(s);
    }
}

/* Towards the sun, and nowhere else, fog glows in its colour. */
static void fog_glows_towards_the_sun(void **unused)
{
    (void)unused;
    stage *s = floor_stage(NULL);
    daft_error error = {0};
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = (daft_vec3){-1, -0.2f, 0}, sun.color = (daft_vec3){1, 0.5f, 0.1f};
    assert_true(daft_light_create(s->scene, &sun, &error).id);
    daft_fog fog = {{0.4f, 0.5f, 0.7f}, 5, 0, 0, 0.5f};
    set_fog(s, fog);
    draw(s);
    for (int i = 0; i < PIXELS; i++) {
        if (s->depth[i] < 20) continue;
        const daft_vec3 d = ray_of(s, i);
        const double cosine = fmax(0, ((double)d.x + 0.2 * (double)d.y) / sqrt(1.04)), glow = 0.5 * pow(cosine, 8);
        assert_true(fabs((double)s->color[i].x - (0.4 + 0.6 * glow)) < 1e-4);
        assert_true(fabs((double)s->color[i].z - (0.7 - 0.6 * glow)) < 1e-4);
    }
    stage_drop(s);
}

static void the_same_bytes_on_every_instruction_set(void **unused)
{
    (void)unused;
    static uint8_t first[4 * PIXELS];
    const char *const isas[] = {DAFT_NARROWEST_ISA, NULL};
    for (int k = 0; k < 2; k++) {
        stage *s = floor_stage(isas[k]);
        add_box(s, (daft_dvec3){9, 1, -3}, (daft_vec3){2, 2, 2}, 0.1f, 0.8f);
        set_fog(s, THIN);
        draw(s);
        if (k == 0) memcpy(first, daft_image_pixels(s->image), sizeof first);
        if (k == 1) assert_memory_equal(first, daft_image_pixels(s->image), sizeof first);
        stage_drop(s);
    }
}

static void scene_files_name_fog_and_sky(void **unused)
{
    (void)unused;
    char path[] = "/tmp/daft_fog_XXXXXX.scene";
    const int file = mkstemps(path, 6);
    const char text[] = "camera 0 0 0\nsky 0.1 0.2 0.9 0.9 0.8 0.7\nfog 0.4 0.5 0.7 0.05 height=3 base=1 glow=0.25\n";
    assert_true(file >= 0 && write(file, text, sizeof text - 1) == (ssize_t)(sizeof text - 1));
    close(file);
    stage *s = stage_make(1, NULL);
    daft_error error = {0};
    assert_true(daft_scene_load(s->scene, path, &error));
    unlink(path);
    daft_fog fog = daft_scene_fog(s->scene), wanted = THIN;
    wanted.glow = 0.25f;
    assert_memory_equal(&fog, &wanted, sizeof fog);
    fog.density = 0;
    set_fog(s, fog);
    draw(s);
    const double rise = sqrt(fabs((double)ray_of(s, WIDTH / 2).y));
    assert_true(fabs((double)s->color[WIDTH / 2].z - (0.7 + 0.2 * rise)) < 1e-3);
    fog.density = -1;
    assert_false(daft_scene_set_fog(s->scene, &fog, &error));
    assert_non_null(strstr(error.message, "density"));
    assert_true(daft_scene_fog(s->scene).density == 0);
    stage_drop(s);
}

/* A fog that changes is seen, though a kept picture would be the same but for it. */
static void kept_pictures_know_of_fog(void **unused)
{
    (void)unused;
    stage *s = floor_stage(NULL);
    daft_error error = {0};
    s->view.aov = (daft_aov){0};
    assert_non_null(s->view.history = daft_history_create(s->engine, &error));
    for (int i = 0; i < 3; i++) draw(s);
    assert_int_equal(draw(s)->tiles_drawn, 0);
    set_fog(s, THIN);
    assert_true(draw(s)->tiles_drawn > 0);
    draw(s);
    assert_int_equal(draw(s)->tiles_drawn, 0);
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fog_is_bouguers_law),          cmocka_unit_test(mirrors_show_the_fog_on_all_of_the_way),
        cmocka_unit_test(fog_glows_towards_the_sun),    cmocka_unit_test(the_same_bytes_on_every_instruction_set),
        cmocka_unit_test(scene_files_name_fog_and_sky), cmocka_unit_test(kept_pictures_know_of_fog),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
