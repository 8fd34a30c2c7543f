/* daft.h as its users see it: nothing else of the engine is included here. Engines, images, a small program from end to
 * end, what a view may ask for, and the same program with every allocation failing in turn. */
#include "daft.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* ---- engines ---- */

static void engines_check_their_definition(void **state)
{
    (void)state;
    daft_error error;
    daft_engine_def def = {0};
    assert_null(daft_engine_create(&def, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "daft_default_engine_def()"));
    assert_null(daft_engine_create(NULL, &error));
    def = daft_default_engine_def();
    def.isa = "mmx";
    assert_null(daft_engine_create(&def, &error));
    assert_string_equal(error.message, "unknown instruction set 'mmx'; known are plain, sse2, avx2, avx512");
    def = daft_default_engine_def();
    def.allocator.release = (void (*)(void *, void *))1;
    assert_null(daft_engine_create(&def, &error));
    assert_non_null(strstr(error.message, "allocator.allocate is NULL"));
    const int threads[][2] = {{1, 1}, {3, 3}, {1000, 64}, {-5, 1}};
    for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
        def = daft_default_engine_def();
        def.threads = threads[i][0];
        def.isa = DAFT_NARROWEST_ISA;
        daft_engine *engine = daft_engine_create(&def, &error);
        assert_non_null(engine);
        assert_int_equal(daft_engine_threads(engine), threads[i][1]);
        assert_string_equal(daft_engine_isa(engine), DAFT_NARROWEST_ISA);
        daft_engine_destroy(engine);
    }
    def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    assert_true(daft_engine_threads(engine) >= 1);
    daft_engine_destroy(engine);
    daft_engine_destroy(NULL);
}

static void count_warning(void *user, const daft_error *warning)
{
    (void)warning;
    ++*(int *)user;
}

static void an_engine_outlives_its_scenes(void **state)
{
    (void)state;
    int warnings = 0;
    daft_engine_def def = daft_default_engine_def();
    def.warn = count_warning;
    def.warn_user = &warnings;
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_scene *scene = daft_scene_create(engine, NULL);
    daft_engine_destroy(engine); /* too early: refused with a warning */
    assert_int_equal(warnings, 1);
    assert_int_equal(daft_entity_count(scene), 0);
    daft_scene_destroy(scene);
    daft_scene_destroy(NULL);
    daft_engine_destroy(engine);
}

/* ---- images ---- */

static void images_have_bounds(void **state)
{
    (void)state;
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_image *image = daft_image_create(engine, 3, 2, &error);
    assert_non_null(image);
    assert_int_equal(daft_image_width(image), 3);
    assert_int_equal(daft_image_height(image), 2);
    for (int i = 0; i < 24; i++) assert_int_equal(daft_image_pixels(image)[i], 0);
    daft_image_destroy(image);
    const int bad[][2] = {{0, 1}, {1, 0}, {-1, 5}, {16385, 1}, {1, 1 << 30}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_null(daft_image_create(engine, bad[i][0], bad[i][1], &error));
        assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
        assert_non_null(strstr(error.message, "1 to 16384 pixels"));
    }
    daft_engine_destroy(engine);
}

static void images_survive_a_file(void **state)
{
    (void)state;
    daft_error error;
    char path[] = "/tmp/daft-api-XXXXXX.png";
    int file = mkstemps(path, 4);
    assert_true(file >= 0);
    close(file);
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_image *image = daft_image_create(engine, 5, 3, &error);
    for (int i = 0; i < 60; i++) daft_image_pixels(image)[i] = (uint8_t)(i % 4 == 3 ? 255 : i * 4);
    assert_true(daft_image_write(image, path, &error));
    daft_image *back = daft_image_load(engine, path, &error);
    assert_non_null(back);
    assert_int_equal(daft_image_width(back), 5);
    assert_memory_equal(daft_image_pixels(back), daft_image_pixels(image), 60);
    daft_image_destroy(back);
    unlink(path);
    assert_null(daft_image_load(engine, path, &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_string_equal(error.file, path);
    assert_null(daft_image_load(engine, "/tmp", &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    daft_image_destroy(image);
    daft_engine_destroy(engine);
}

/* ---- a small program ---- */

typedef struct program {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_entity box, ball;
    daft_entity seen[32 * 32];
    float depth[32 * 32];
} program;

static bool build(program *p, daft_error *error)
{
    p->scene = daft_scene_create(p->engine, error);
    if (!p->scene) return false;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX;
    def.position = (daft_dvec3){5, -1.5, 0};
    def.size = (daft_vec3){8, 1, 8};
    def.body = DAFT_BODY_STATIC;
    p->box = daft_entity_create(p->scene, &def, error);
    if (!p->box.id) return false;
    daft_material_def chrome = daft_default_material_def();
    chrome.mirror = 0.5f, chrome.transmission = 0.4f; /* so that all kinds of rays are cast */
    def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE;
    def.radius = 1;
    def.position = (daft_dvec3){5, 0, 0};
    def.body = DAFT_BODY_DYNAMIC;
    def.material = daft_material_create(p->scene, &chrome, error);
    if (!def.material.id) return false;
    p->ball = daft_entity_create(p->scene, &def, error);
    daft_light_def light = daft_default_light_def();
    light.position = (daft_dvec3){0, 5, 2};
    return p->ball.id && daft_light_create(p->scene, &light, error).id;
}

static bool run(program *p, const daft_engine_def *def, daft_error *error)
{
    p->engine = daft_engine_create(def, error);
    if (!p->engine || !build(p, error)) return false;
    daft_scene_begin_tick(p->scene);
    if (!daft_scene_step(p->scene, 1.0f / 60, error)) return false;
    daft_ray_hit hit;
    bool found =
        daft_scene_cast_ray(p->scene, (daft_dvec3){0, 0, 0}, (daft_vec3){1, 0, 0}, 10, (daft_entity){0}, &hit, error);
    if (!found) return false;
    p->image = daft_image_create(p->engine, 32, 32, error);
    daft_view view = daft_default_view();
    view.aov.entity = p->seen;
    view.aov.depth = p->depth;
    return p->image && daft_render(p->scene, &view, p->image, error);
}

static void finish(program *p)
{
    daft_image_destroy(p->image);
    daft_scene_destroy(p->scene);
    daft_engine_destroy(p->engine);
}

static void a_small_program_draws(void **state)
{
    (void)state;
    program p = {0};
    daft_error error;
    char text[1100];
    daft_engine_def def = daft_default_engine_def();
    def.threads = 2;
    if (!run(&p, &def, &error)) fail_msg("%s", daft_error_text(&error, text, sizeof text));
    size_t middle = 16 * 32 + 16, floor = 25 * 32 + 16, sky = 2 * 32 + 16;
    assert_int_equal(p.seen[middle].id, p.ball.id);
    assert_int_equal(p.seen[floor].id, p.box.id);
    assert_int_equal(p.seen[sky].id, 0);
    assert_true(fabsf(p.depth[middle] - 4) < 0.05f);
    assert_true(isinf(p.depth[sky]));
    assert_int_equal(daft_image_pixels(p.image)[4 * middle + 3], 255);
    const daft_counters *counters = daft_scene_counters(p.scene);
    assert_int_equal(counters->threads, 2);
    assert_string_equal(counters->isa, daft_engine_isa(p.engine));
    assert_true(counters->width == 32 && counters->height == 32);
    assert_true(counters->camera_rays >= 32 * 32 && counters->query_rays == 1 && counters->mesh_builds == 1);
    assert_true(counters->shadow_rays > 0);
    finish(&p);
}

static void the_same_everywhere(void **state)
{
    (void)state;
    uint64_t want_picture = 0, want_state = 0;
    const struct {
        int threads;
        const char *isa;
    } cases[] = {{1, DAFT_NARROWEST_ISA}, {2, DAFT_NARROWEST_ISA}, {7, "avx2"}, {2, "avx512"}, {1, NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        program p = {0};
        daft_error error;
        daft_engine_def def = daft_default_engine_def();
        def.threads = cases[i].threads;
        def.isa = cases[i].isa;
        if (!run(&p, &def, &error)) {
            assert_int_equal(error.code, DAFT_ERROR_UNSUPPORTED); /* a processor without it */
            continue;
        }
        uint64_t picture = daft_hash(daft_image_pixels(p.image), 32 * 32 * 4, 0), now = daft_scene_hash(p.scene);
        if (i == 0) want_picture = picture, want_state = now;
        assert_true(picture == want_picture && now == want_state);
        finish(&p);
    }
}

static void views_are_checked(void **state)
{
    (void)state;
    program p = {0};
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    assert_true(run(&p, &def, &error));
    daft_view bad[8];
    const char *says[] = {"daft_default_view()", "camera.fov", "camera.yaw",       "camera.position.y", "alpha",
                          "samples is 2",        "tree is 9",  "camera.fov is 3.2"};
    for (size_t i = 0; i < 8; i++) bad[i] = daft_default_view();
    bad[0].cookie = 0;
    bad[1].camera.fov = NAN;
    bad[2].camera.yaw = INFINITY;
    bad[3].camera.position.y = NAN;
    bad[4].alpha = NAN;
    bad[5].quality.samples = 2;
    bad[6].quality.tree = (daft_tree)9;
    bad[7].camera.fov = 3.2f;
    for (size_t i = 0; i < 8; i++) {
        assert_false(daft_render(p.scene, &bad[i], p.image, &error));
        assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
        if (!strstr(error.message, says[i])) fail_msg("%s: %s", says[i], error.message);
    }
    daft_view view = daft_default_view();
    assert_false(daft_render(p.scene, &view, NULL, &error));
    assert_string_equal(error.message, "target is NULL");
    assert_false(daft_render(NULL, &view, p.image, &error));
    assert_false(daft_render(p.scene, NULL, p.image, &error));
    finish(&p);
}

static bool stop_at_once(void *user, float done)
{
    assert_true(done >= 0 && done <= 1);
    ++*(int *)user;
    return false;
}

static void a_picture_can_be_stopped(void **state)
{
    (void)state;
    program p = {0};
    daft_error error;
    int calls = 0;
    daft_engine_def def = daft_default_engine_def();
    assert_true(run(&p, &def, &error));
    daft_view view = daft_default_view();
    view.progress = stop_at_once;
    view.progress_user = &calls;
    view.aov.entity = p.seen;
    memset(p.seen, 0x77, sizeof p.seen);
    assert_false(daft_render(p.scene, &view, p.image, &error));
    assert_int_equal(error.code, DAFT_ERROR_CANCELLED);
    assert_true(calls >= 1);
    for (int i = 0; i < 32 * 32; i++) assert_int_equal(p.seen[i].id, 0); /* no half answers */
    view.progress = NULL;
    assert_true(daft_render(p.scene, &view, p.image, &error));
    finish(&p);
}

/* ---- memory ---- */

/* Worker threads allocate, too. */
typedef struct meter {
    atomic_long live, calls;
    long fail_at;
} meter;

static void *metered_allocate(void *user, size_t size, size_t alignment)
{
    meter *m = user;
    if (++m->calls == m->fail_at) return NULL;
    void *memory = aligned_alloc(alignment, (size + alignment - 1) & ~(alignment - 1));
    m->live += memory != NULL;
    return memory;
}

static void metered_release(void *user, void *pointer)
{
    meter *m = user;
    m->live -= pointer != NULL;
    free(pointer);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    for (long n = 1;; n++) {
        meter m = {0, 0, n};
        program p = {0};
        daft_error error;
        daft_engine_def def = daft_default_engine_def();
        def.threads = 1;
        def.allocator = (daft_allocator){.user = &m, .allocate = metered_allocate, .release = metered_release};
        bool done = run(&p, &def, &error);
        finish(&p);
        assert_int_equal(m.live, 0);
        if (m.calls < n) {
            assert_true(done);
            print_message("%ld allocations\n", n - 1);
            assert_true(n > 10);
            break;
        }
        /* the call may go on without what it wanted, but then it succeeds; if it fails, it says why */
        if (!done && error.code != DAFT_ERROR_MEMORY)
            fail_msg("allocation %ld: %d %s", n, (int)error.code, error.message);
    }
}

/* A settled scene's second picture takes nothing from the allocator, nor do its ticks and its rays. With one worker:
 * how many share the work is settled at once, how they share it only when each has had its largest share. */
static void a_settled_frame_allocates_nothing(void **state)
{
    (void)state;
    meter m = {0, 0, 0};
    program p = {0};
    daft_error error;
    daft_ray_hit hit;
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    def.allocator = (daft_allocator){.user = &m, .allocate = metered_allocate, .release = metered_release};
    assert_true(run(&p, &def, &error));
    daft_view view = daft_default_view();
    for (int frame = 0; frame < 5; frame++) {
        long before = m.calls;
        daft_scene_begin_tick(p.scene);
        assert_true(daft_scene_step(p.scene, 1.0f / 60, &error));
        daft_scene_cast_ray(p.scene, (daft_dvec3){0, 0, 0}, (daft_vec3){1, 0, 0}, 10, (daft_entity){0}, &hit, &error);
        assert_true(daft_render(p.scene, &view, p.image, &error));
        if (frame >= 2) assert_int_equal(m.calls, before);
    }
    finish(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(engines_check_their_definition),
        cmocka_unit_test(an_engine_outlives_its_scenes),
        cmocka_unit_test(images_have_bounds),
        cmocka_unit_test(images_survive_a_file),
        cmocka_unit_test(a_small_program_draws),
        cmocka_unit_test(the_same_everywhere),
        cmocka_unit_test(views_are_checked),
        cmocka_unit_test(a_picture_can_be_stopped),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(a_settled_frame_allocates_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
