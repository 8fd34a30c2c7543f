/* Only what changed is drawn, and nobody can tell: after any change the picture has the bytes of a full one. Changes
 * are random; a second picture without a history is the truth. */
#include "fixtures.h"

#include "daft.h"

enum { WIDTH = 240, HEIGHT = 176, TILES = 8 * 6, THINGS = 12, LAMPS = 2, MATERIALS = 5 };

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *kept, *full;
    daft_view view;
    daft_entity things[THINGS];
    daft_material materials[MATERIALS];
    daft_light lamps[LAMPS];
} stage;

static void check(bool good, const daft_error *error)
{
    if (!good) fail_msg("%s", error->message);
}

static void add_floor(stage *s)
{
    daft_error error = {0};
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = daft_v3(14, 1, 14), def.position = daft_dv3(0, -0.5, 0);
    check(daft_entity_create(s->scene, &def, &error).id, &error);
}

static void add_lamps(stage *s)
{
    daft_error error = {0};
    daft_light_def def = daft_default_light_def();
    def.kind = DAFT_LIGHT_SUN, def.direction = daft_v3(0.4f, -1, 0.3f), def.color = daft_v3(0.6f, 0.6f, 0.5f);
    check(daft_light_create(s->scene, &def, &error).id, &error);
    for (int i = 0; i < LAMPS; i++) {
        def = daft_default_light_def();
        def.kind = DAFT_LIGHT_POINT, def.position = daft_dv3(3.0 - 6 * i, 2, 3.0 * i - 2), def.range = 4;
        check((s->lamps[i] = daft_light_create(s->scene, &def, &error)).id, &error);
    }
}

static daft_material_def random_material(bool mirrors)
{
    daft_material_def def = daft_default_material_def();
    def.diffuse = random_vec3(0.1f, 1);
    if (mirrors && random_bits() % 3 == 0) def.mirror = random_float(0.2f, 0.9f);
    return def;
}

static void add_things(stage *s, bool mirrors)
{
    daft_error error = {0};
    for (int i = 0; i < MATERIALS; i++) {
        daft_material_def def = random_material(mirrors);
        if (mirrors && i == 1) def.mirror = 0.6f;
        if (mirrors && i == 2) def.transmission = 0.8f;
        check((s->materials[i] = daft_material_create(s->scene, &def, &error)).id, &error);
    }
    for (int i = 0; i < THINGS; i++) {
        daft_entity_def def = daft_default_entity_def();
        def.shape = i % 2 ? DAFT_SHAPE_SPHERE : DAFT_SHAPE_BOX, def.radius = random_float(0.2f, 0.8f);
        def.size = random_vec3(0.3f, 1.5f), def.material = s->materials[i % MATERIALS];
        def.position =
            daft_dv3((double)random_float(-4, 4), (double)random_float(0.3f, 2), (double)random_float(-4, 4));
        check((s->things[i] = daft_entity_create(s->scene, &def, &error)).id, &error);
    }
}

static stage *stage_make(int threads, bool mirrors)
{
    stage *s = calloc(1, sizeof *s);
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads;
    s->engine = daft_engine_create(&def, NULL);
    s->scene = daft_scene_create(s->engine, NULL);
    s->kept = daft_image_create(s->engine, WIDTH, HEIGHT, NULL);
    s->full = daft_image_create(s->engine, WIDTH, HEIGHT, NULL);
    s->view = daft_default_view();
    s->view.camera = daft_camera_look_at(daft_dv3(-8, 4, 2), daft_dv3(0, 0.5, 0), 1.1f);
    s->view.history = daft_history_create(s->engine, NULL);
    assert_true(s->scene && s->kept && s->full && s->view.history);
    daft_scene_set_sky_gradient(s->scene, daft_v3(0.2f, 0.4f, 0.9f), daft_v3(0.8f, 0.9f, 1));
    add_floor(s), add_lamps(s), add_things(s, mirrors);
    return s;
}

static void stage_drop(stage *s)
{
    daft_history_destroy(s->view.history);
    daft_image_destroy(s->kept);
    daft_image_destroy(s->full);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
    free(s);
}

static const daft_counters *draw(stage *s)
{
    daft_error error = {0};
    memset(daft_image_pixels(s->kept), 0x55, (size_t)WIDTH * HEIGHT * 4); /* a game has drawn over it */
    check(daft_render(s->scene, &s->view, s->kept, &error), &error);
    return daft_scene_counters(s->scene);
}

/* The number of tiles that were drawn, once the picture is found to be that of a full frame. */
static uint64_t draw_both(stage *s, const char *what, int step)
{
    daft_error error = {0};
    const uint64_t drawn = draw(s)->tiles_drawn;
    daft_view fresh = s->view;
    fresh.history = NULL;
    check(daft_render(s->scene, &fresh, s->full, &error), &error);
    assert_int_equal(daft_scene_counters(s->scene)->tiles_drawn, TILES);
    const uint8_t *kept = daft_image_pixels(s->kept), *full = daft_image_pixels(s->full);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        if (memcmp(kept + 4 * i, full + 4 * i, 4) != 0)
            fail_msg("%s, step %d: pixel %d %d has not been drawn (%d tiles were)", what, step, i % WIDTH, i / WIDTH,
                     (int)drawn);
    return drawn;
}

/* ---- changes ---- */

static void move(stage *s, daft_entity thing)
{
    daft_transform at;
    assert_true(daft_entity_get_transform(s->scene, thing, &at, NULL));
    const daft_vec3 by = random_vec3(-0.5f, 0.5f);
    at.position = daft_dadd(at.position, daft_to_double(by));
    if (at.position.y < 0.2) at.position.y = 0.2;
    if (fabs(at.position.x) > 5 || fabs(at.position.z) > 5) at.position = daft_dv3(0.1, 1.1, 0.2);
    assert_true(daft_entity_set_transform(s->scene, thing, &at, true, NULL));
}

static void move_lamp(stage *s, daft_light lamp)
{
    daft_light_def def;
    assert_true(daft_light_get(s->scene, lamp, &def, NULL));
    def.position.x += (double)random_float(-0.5f, 0.5f), def.color = random_vec3(0, 1);
    assert_true(daft_light_set(s->scene, lamp, &def, NULL));
}

static const char *change(stage *s, bool mirrors)
{
    const daft_entity thing = s->things[random_bits() % THINGS];
    daft_material_def material;
    switch (random_bits() % 8) {
    case 0: return "nothing";
    case 1: return daft_entity_set_visible(s->scene, thing, random_bits() % 2, NULL), "one comes or goes";
    case 2: return move_lamp(s, s->lamps[random_bits() % LAMPS]), "a lamp changes";
    case 3:
        material = random_material(mirrors);
        return daft_material_set(s->scene, s->materials[random_bits() % MATERIALS], &material, NULL),
               "a material changes";
    case 4:
        daft_entity_set_material(s->scene, thing, s->materials[random_bits() % MATERIALS], NULL);
        return "one looks different";
    case 5: move(s, thing);
    /* fall through */
    default: move(s, s->things[random_bits() % THINGS]); return "one moves";
    }
}

static void change_at_random(int threads, bool mirrors, int antialiasing, int steps)
{
    stage *s = stage_make(threads, mirrors);
    uint64_t drawn = 0;
    s->view.quality.edge_samples = antialiasing;
    draw_both(s, "the first picture", 0);
    for (int i = 0; i < steps; i++) drawn += draw_both(s, change(s, mirrors), i);
    print_message("%.0f %% of the tiles\n", 100.0 * (double)drawn / ((double)TILES * steps));
    assert_true(drawn > 0 && drawn < (uint64_t)TILES * (uint64_t)steps);
    stage_drop(s);
}

static void a_changed_picture_has_the_bytes_of_a_full_one(void **state)
{
    (void)state;
    change_at_random(1, false, 0, 700);
    change_at_random(2, false, 4, 700);
}

static void so_has_one_with_mirrors_and_glass(void **state)
{
    (void)state;
    change_at_random(1, true, 0, 400);
    change_at_random(2, true, 4, 400);
}

static void nothing_changed_nothing_drawn(void **state)
{
    (void)state;
    stage *s = stage_make(2, true);
    assert_int_equal(draw(s)->tiles_drawn, TILES);
    const daft_counters *c = draw(s);
    assert_int_equal(c->tiles_drawn, 0);
    assert_int_equal(c->camera_rays + c->shadow_rays + c->reflection_rays + c->refraction_rays, 0);
    for (int i = 0; i < DAFT_EFFECT_COUNT; i++) {
        assert_false(c->effects[i].ran);
        assert_int_equal(c->effects[i].rays, 0);
    }
    assert_int_equal(draw_both(s, "again", 0), 0);
    stage_drop(s);
}

static void a_small_thing_costs_little(void **state)
{
    (void)state;
    stage *s = stage_make(2, false);
    daft_transform at = {.position = {4.5, 0.2, 4.5}, .rotation = {0, 0, 0, 1}, .scale = {0.3f, 0.3f, 0.3f}};
    check(daft_entity_set_transform(s->scene, s->things[1], &at, true, NULL), &(daft_error){0});
    draw_both(s, "the first picture", 0);
    at.position.x -= 0.1;
    check(daft_entity_set_transform(s->scene, s->things[1], &at, true, NULL), &(daft_error){0});
    const uint64_t drawn = draw_both(s, "a small thing moves", 1);
    assert_in_range(drawn, 1, TILES / 2);
    stage_drop(s);
}

static void a_camera_that_moves_draws_in_full(void **state)
{
    (void)state;
    stage *s = stage_make(2, false);
    draw(s);
    for (int i = 0; i < 3; i++) {
        s->view.camera.yaw += 0.01f;
        assert_int_equal(draw_both(s, "the camera turns", i), TILES);
    }
    draw(s); /* the first from where it stands now is kept */
    assert_int_equal(draw_both(s, "the camera stands", 0), 0);
    s->view.quality.texture_filter = DAFT_TEXTURE_NEAREST;
    assert_int_equal(draw_both(s, "another filter", 0), TILES);
    s->view.quality.samples = 4;
    assert_int_equal(draw_both(s, "more samples", 0), TILES);
    daft_scene_set_ambient(s->scene, daft_v3(0.1f, 0.2f, 0.3f));
    assert_int_equal(draw_both(s, "another ambient light", 0), TILES);
    daft_history_forget(s->view.history);
    assert_int_equal(draw_both(s, "forgotten", 0), TILES);
    stage_drop(s);
}

/* Sampled light is averaged over pictures, and kept once that is done. */
static void sampled_light_settles(void **state)
{
    (void)state;
    stage *s = stage_make(2, false);
    daft_scene_set_ambient_occlusion(s->scene, 1);
    int pictures = 0;
    while (draw(s)->tiles_drawn) assert_in_range(++pictures, 1, 30);
    assert_in_range(pictures, 16, 20);
    move(s, s->things[0]);
    assert_int_equal(draw(s)->tiles_drawn, TILES);
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_changed_nothing_drawn),
        cmocka_unit_test(a_small_thing_costs_little),
        cmocka_unit_test(a_camera_that_moves_draws_in_full),
        cmocka_unit_test(sampled_light_settles),
        cmocka_unit_test(a_changed_picture_has_the_bytes_of_a_full_one),
        cmocka_unit_test(so_has_one_with_mirrors_and_glass),
    };
    fixture_seed(20261124);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
