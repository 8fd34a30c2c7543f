/* Degenerate input through daft.h: a thing of every bad kind stands beside sound ones, and the sound ones are drawn,
 * hit and moved to the bit as if it were not there; nothing that is not a number comes out; each warning comes once. */
#include "degenerate.h"

/* ---- entities that are not to be seen ---- */

static const daft_dvec3 BESIDE = {6, 0.5, 0}; /* in plain sight, between the mirror and the ball */

static void flat_x(stage *s)
{
    daft_entity_def def = box(BESIDE, daft_v3(1, 1, 1));
    def.scale = daft_v3(0, 1, 1);
    add(s, def);
}
static void flat_all(stage *s)
{
    daft_entity_def def = sphere(BESIDE, 1);
    def.scale = daft_v3(0, 0, 0);
    add(s, def);
}
static void child_of_nothing(stage *s)
{
    daft_entity_def parent = daft_default_entity_def(), child = sphere(daft_dv3(0, 0, 0), 1);
    parent.position = BESIDE, parent.scale = daft_v3(0, 0, 0);
    child.parent = add(s, parent);
    add(s, child);
}
static void scale_denormal(stage *s)
{
    daft_entity_def def = box(BESIDE, daft_v3(1, 1, 1));
    def.scale = daft_v3(1e-42f, 1e-42f, 1e-42f);
    add(s, def);
}
static void scale_tiny(stage *s)
{
    daft_entity_def def = box(BESIDE, daft_v3(1, 1, 1));
    def.scale = daft_v3(1e-30f, 1e-30f, 1e-30f);
    add(s, def);
}
static void radius_tiny(stage *s) { add(s, sphere(BESIDE, 1e-30f)); }
static void radius_denormal(stage *s) { add(s, sphere(BESIDE, FLT_TRUE_MIN)); }
static void box_tiny(stage *s) { add(s, box(BESIDE, daft_v3(1e-30f, 1e-30f, 1e-30f))); }
static void box_denormal(stage *s) { add(s, box(BESIDE, daft_v3(1e-44f, 1e-44f, 1e-44f))); }
static void box_thread(stage *s) /* between the pixels' middles and their corners: rays straight ahead would hit it */
{
    add(s, box(daft_dv3(BESIDE.x, BESIDE.y, 0.01), daft_v3(1e-30f, 3, 1e-30f)));
}
static void far_behind(stage *s) { add(s, sphere(daft_dv3(-1e30, 0, 0), 1)); }
static void beyond_floats(stage *s) { add(s, sphere(daft_dv3(-1e300, 1e300, 0), 1)); }
static void empty_mesh(stage *s) { add(s, thing(mesh_of(s, NULL, 0, NULL, 0), BESIDE)); }

static void repeated_corners(stage *s)
{
    const daft_vec3 p[] = {{0, 0, 0}, {1, 0, 0}};
    const uint32_t index[] = {0, 0, 0, 0, 1, 1, 1, 0, 1};
    add(s, thing(mesh_of(s, p, 2, index, 3), BESIDE));
}
static void no_area(stage *s)
{
    const daft_vec3 p[] = {{0, 0, 0}, {0.5f, 0.5f, 0.5f}, {1, 1, 1}, {0, 0, 0}, {-1, 0, 0}, {1, 0, 0}};
    const uint32_t index[] = {0, 1, 2, 2, 1, 0, 0, 3, 2, 0, 4, 5, 3, 4, 5};
    add(s, thing(mesh_of(s, p, 6, index, 5), BESIDE));
}
static void all_in_one_place(stage *s)
{
    const daft_vec3 p[] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    const uint32_t index[] = {0, 1, 2, 2, 1, 0};
    add(s, thing(mesh_of(s, p, 3, index, 2), BESIDE));
}
static void not_numbers(stage *s)
{
    const daft_vec3 p[] = {{0, 0, 0}, {1, NAN, 0}, {0, 1, INFINITY}, {-INFINITY, 0, 0}, {0, 1, 0}};
    const uint32_t index[] = {0, 1, 4, 0, 2, 4, 3, 0, 4, 1, 2, 3};
    add(s, thing(mesh_of(s, p, 5, index, 4), BESIDE));
}
static void tiny_mesh(stage *s)
{
    const daft_vec3 p[] = {{0, 0, 0}, {1e-30f, 0, 0}, {0, 1e-30f, 0}, {0, 0, 1e-30f}};
    const uint32_t index[] = {0, 1, 2, 0, 1, 3, 1, 2, 3, 0, 2, 3};
    add(s, thing(mesh_of(s, p, 4, index, 4), BESIDE));
}
static void denormal_mesh(stage *s)
{
    const daft_vec3 p[] = {{0, 0, 0}, {1e-44f, 0, 0}, {0, 1e-44f, 0}, {0, 0, 1e-44f}};
    const uint32_t index[] = {0, 1, 2, 0, 1, 3, 1, 2, 3, 0, 2, 3};
    add(s, thing(mesh_of(s, p, 4, index, 4), BESIDE));
}
static void huge_mesh_behind(stage *s)
{
    const daft_vec3 p[] = {{-1e30f, 0, 0}, {-1e30f, 1e30f, 0}, {-1e30f, 0, 1e30f}};
    const uint32_t index[] = {0, 1, 2};
    daft_entity_def def = thing(mesh_of(s, p, 3, index, 1), daft_dv3(0, 0, 0));
    def.casts_shadow = false;
    add(s, def);
}
static void largest_mesh_behind(stage *s)
{
    const daft_vec3 p[] = {{-FLT_MAX, 0, 0}, {-FLT_MAX, FLT_MAX, 0}, {-FLT_MAX, 0, -FLT_MAX}, {-1, 0, FLT_MAX}};
    const uint32_t index[] = {0, 1, 2, 0, 2, 3};
    daft_entity_def def = thing(mesh_of(s, p, 4, index, 2), daft_dv3(-1, 0, 0));
    def.casts_shadow = false;
    add(s, def);
}
/* Brings each kind to both ends of one mesh: the bounds span sixty orders of magnitude. */
static void tiny_and_huge_behind(stage *s)
{
    const daft_vec3 p[] = {{-1, 0, 0}, {-1, 1e-30f, 0}, {-1, 0, 1e-30f}, {-1e30f, 0, 0}, {-1e30f, 1e30f, 1}};
    const uint32_t index[] = {0, 1, 2, 0, 3, 4};
    daft_entity_def def = thing(mesh_of(s, p, 5, index, 2), daft_dv3(-1, 0, 0));
    def.casts_shadow = false;
    add(s, def);
}
static void hidden(stage *s)
{
    daft_entity_def def = box(BESIDE, daft_v3(1, 1, 1));
    def.visible = false, def.scale = daft_v3(0, 1e30f, 1e-30f);
    add(s, def);
}
static void black_light_at_the_camera(stage *s) { light(s, DAFT_LIGHT_POINT, daft_dv3(0, 0, 0), daft_v3(0, 0, 0), 0); }
static void light_beyond_floats(stage *s) { light(s, DAFT_LIGHT_POINT, daft_dv3(1e300, 0, 0), daft_v3(0, 0, 0), 1); }

static const struct {
    const char *name;
    void (*add)(stage *s);
    bool warns; /* once; the others may, if the engine says that it does not draw them */
} UNSEEN[] = {
    {"scale 0 in x", flat_x, true},
    {"scale 0", flat_all, true},
    {"parent of scale 0", child_of_nothing, true},
    {"scale 1e-42", scale_denormal, true},
    {"scale 1e-30", scale_tiny, false},
    {"radius 1e-30", radius_tiny, false},
    {"smallest radius", radius_denormal, false},
    {"box of 1e-30", box_tiny, false},
    {"box of 1e-44", box_denormal, false},
    {"box as a thread", box_thread, false},
    {"sphere at -1e30", far_behind, false},
    {"sphere at 1e300", beyond_floats, true},
    {"empty mesh", empty_mesh, false},
    {"repeated corners", repeated_corners, true},
    {"no area", no_area, false},
    {"corners in one place", all_in_one_place, false},
    {"NaN and infinity", not_numbers, true},
    {"mesh of 1e-30", tiny_mesh, false},
    {"mesh of 1e-44", denormal_mesh, false},
    {"mesh of 1e30", huge_mesh_behind, false},
    {"mesh of FLT_MAX", largest_mesh_behind, false},
    {"mesh of 1e-30 and 1e30", tiny_and_huge_behind, false},
    {"hidden", hidden, false},
    {"black light at the camera", black_light_at_the_camera, false},
    {"light at 1e300", light_beyond_floats, false},
};
enum { UNSEEN_COUNT = sizeof UNSEEN / sizeof UNSEEN[0] };

static void what_is_not_seen_changes_no_pixel(void **unused)
{
    (void)unused;
    stage *sound = stage_make();
    picture *expected[QUALITY_COUNT];
    for (int q = 0; q < QUALITY_COUNT; q++) expected[q] = draw(sound, QUALITIES[q]);
    assert_picture_sound("the sound scene", expected[1]);
    for (size_t i = 0; i < UNSEEN_COUNT; i++) {
        stage *s = stage_make();
        UNSEEN[i].add(s);
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *p = draw(s, QUALITIES[q]);
            assert_picture_sound(UNSEEN[i].name, p);
            assert_same(UNSEEN[i].name, expected[q], p);
            free(p);
        }
        if (s->warnings > 1 || (UNSEEN[i].warns && s->warnings == 0))
            fail_msg("%s: %d warnings, the last: %s", UNSEEN[i].name, s->warnings, s->last_warning.message);
        stage_drop(s);
    }
    for (int q = 0; q < QUALITY_COUNT; q++) free(expected[q]);
    stage_drop(sound);
}

static void all_of_it_together_changes_no_pixel(void **unused)
{
    (void)unused;
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        stage *sound = stage_make_on(daft_isa_name(isa)), *s = stage_make_on(daft_isa_name(isa));
        for (size_t i = 0; i < UNSEEN_COUNT; i++) UNSEEN[i].add(s);
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *expected = draw(sound, QUALITIES[q]), *p = draw(s, QUALITIES[q]);
            assert_same(daft_isa_name(isa), expected, p);
            free(expected);
            free(p);
        }
        stage_drop(s);
        stage_drop(sound);
    }
}

/* ---- ray queries and simulation ---- */

static daft_vec3 direction_of(int i)
{
    return daft_v3((float)(i % 7) - 2, (float)(i % 11) - 5, (float)(i % 13) - 6.5f);
}

static void rays_and_steps_go_on(void **unused)
{
    (void)unused;
    for (size_t i = 0; i < UNSEEN_COUNT; i++) {
        stage *sound = stage_make(), *s = stage_make();
        UNSEEN[i].add(s);
        daft_error error;
        for (int k = 0; k < 200; k++) {
            daft_ray_hit a = {0}, b = {0};
            daft_dvec3 from = daft_dv3(0, 0.01 * k, 0.02);
            bool hit = daft_scene_cast_ray(sound->scene, from, direction_of(k), 100, (daft_entity){0}, &a, &error);
            bool also = daft_scene_cast_ray(s->scene, from, direction_of(k), 100, (daft_entity){0}, &b, &error);
            assert_int_equal(error.code, DAFT_OK);
            if (hit != also || (hit && (a.entity.id != b.entity.id || fabsf(a.distance - b.distance) > 1e-5f)))
                fail_msg("%s: ray %d hits 0x%x at %g, and should 0x%x at %g", UNSEEN[i].name, k, b.entity.id,
                         (double)b.distance, a.entity.id, (double)a.distance);
        }
        for (int tick = 0; tick < 90; tick++) {
            daft_scene_begin_tick(sound->scene);
            daft_scene_begin_tick(s->scene);
            assert_true(daft_scene_step(sound->scene, 1.0f / 60, &error));
            assert_true(daft_scene_step(s->scene, 1.0f / 60, &error));
        }
        daft_transform a, b;
        assert_true(daft_entity_get_transform(sound->scene, sound->falling, &a, &error));
        assert_true(daft_entity_get_transform(s->scene, s->falling, &b, &error));
        assert_memory_equal(&a, &b, sizeof a);
        assert_true(a.position.y < 1); /* it did fall */
        stage_drop(s);
        stage_drop(sound);
    }
}

/* Bodies of sizes that no one means, far from the sound one. */
static void odd_bodies_leave_others_alone(void **unused)
{
    (void)unused;
    const float sizes[] = {1e-30f, 1e-10f, 1e10f};
    stage *sound = stage_make();
    daft_error error;
    for (int tick = 0; tick < 60; tick++) {
        daft_scene_begin_tick(sound->scene);
        assert_true(daft_scene_step(sound->scene, 1.0f / 60, &error));
    }
    daft_transform expected, got;
    assert_true(daft_entity_get_transform(sound->scene, sound->falling, &expected, &error));
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        stage *s = stage_make();
        daft_entity_def ball = sphere(daft_dv3(1e5, 1e11, 0), sizes[i]),
                        flat = box(daft_dv3(1e5, -1e11, 0), daft_v3(1, 1, 1));
        ball.body = DAFT_BODY_DYNAMIC;
        flat.body = DAFT_BODY_STATIC, flat.size = daft_v3(sizes[i], 1, sizes[i]);
        bool balls = daft_entity_create(s->scene, &ball, &error).id != 0; /* or a message */
        if (!balls) assert_true(error.code == DAFT_ERROR_ARGUMENT && error.message[0]);
        if (!daft_entity_create(s->scene, &flat, &error).id) assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
        for (int tick = 0; tick < 60; tick++) {
            daft_scene_begin_tick(s->scene);
            assert_true(daft_scene_step(s->scene, 1.0f / 60, &error));
        }
        assert_true(daft_entity_get_transform(s->scene, s->falling, &got, &error));
        assert_memory_equal(&expected, &got, sizeof got);
        stage_drop(s);
    }
    stage_drop(sound);
}

static void radii_and_sizes_of_nothing_are_refused(void **unused)
{
    (void)unused;
    stage *s = stage_make();
    const float bad[] = {0, -0.0f, -1, NAN, INFINITY, -INFINITY};
    daft_error error;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        daft_entity_def ball = sphere(BESIDE, bad[i]), block = box(BESIDE, daft_v3(1, bad[i], 1));
        uint32_t count = daft_entity_count(s->scene);
        assert_int_equal(daft_entity_create(s->scene, &ball, &error).id, 0);
        assert_non_null(strstr(error.message, "radius"));
        assert_int_equal(daft_entity_create(s->scene, &block, &error).id, 0);
        assert_non_null(strstr(error.message, "size.y"));
        assert_int_equal(daft_entity_count(s->scene), count);
    }
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_not_seen_changes_no_pixel),
        cmocka_unit_test(all_of_it_together_changes_no_pixel),
        cmocka_unit_test(rays_and_steps_go_on),
        cmocka_unit_test(odd_bodies_leave_others_alone),
        cmocka_unit_test(radii_and_sizes_of_nothing_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
