/* Degenerate input through daft.h: a thing of every bad kind stands beside sound ones, and the sound ones are drawn,
 * hit and moved to the bit as if it were not there; nothing that is not a number comes out; each warning comes once. */
#include "daft.h"

#include "math/isa.h"
#include "math/vec.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <float.h>

enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT };

static const daft_quality QUALITIES[] = {DAFT_QUALITY_DRAFT, DAFT_QUALITY_GAME, DAFT_QUALITY_HIGH,
                                         DAFT_QUALITY_REFERENCE};
enum { QUALITY_COUNT = 4 };

typedef struct picture {
    uint8_t pixels[4 * PIXELS];
    float depth[PIXELS];
    daft_vec3 normal[PIXELS];
    daft_entity entity[PIXELS];
    uint32_t triangle[PIXELS];
} picture;

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_entity floor, ball, chrome, block, falling;
    int warnings;
    daft_error last_warning;
} stage;

static void on_warning(void *user, const daft_error *warning)
{
    stage *s = user;
    s->warnings++;
    s->last_warning = *warning;
}

static daft_entity add(stage *s, daft_entity_def def)
{
    daft_error error = {0};
    daft_entity entity = daft_entity_create(s->scene, &def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    return entity;
}

static daft_entity_def sphere(daft_dvec3 position, float radius)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.position = position, def.radius = radius;
    return def;
}

static daft_entity_def box(daft_dvec3 position, daft_vec3 size)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.position = position, def.size = size;
    return def;
}

static daft_entity_def thing(daft_mesh mesh, daft_dvec3 position)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.position = position;
    return def;
}

static daft_mesh mesh_of(stage *s, const daft_vec3 *positions, uint32_t vertices, const uint32_t *indices,
                         uint32_t triangles)
{
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions, def.vertex_count = vertices, def.indices = indices, def.triangle_count = triangles;
    daft_error error = {0};
    daft_mesh mesh = daft_mesh_create(s->scene, &def, &error);
    if (!mesh.id) fail_msg("%s", error.message);
    return mesh;
}

static daft_light light(stage *s, daft_light_kind kind, daft_dvec3 position, daft_vec3 direction, float color)
{
    daft_light_def def = daft_default_light_def();
    def.kind = kind, def.position = position, def.direction = direction, def.color = daft_v3(color, color, color);
    daft_error error = {0};
    daft_light made = daft_light_create(s->scene, &def, &error);
    if (!made.id) fail_msg("%s", error.message);
    return made;
}

static stage *stage_bare(const char *isa)
{
    stage *s = calloc(1, sizeof *s);
    daft_error error = {0};
    daft_engine_def def = daft_default_engine_def();
    def.isa = isa, def.threads = 2, def.warn = on_warning, def.warn_user = s;
    s->engine = daft_engine_create(&def, &error);
    s->scene = s->engine ? daft_scene_create(s->engine, &error) : NULL;
    s->image = s->scene ? daft_image_create(s->engine, WIDTH, HEIGHT, &error) : NULL;
    if (!s->image) fail_msg("%s", error.message);
    return s;
}

/* A floor, a ball, a mirror that sees the whole room, a block and a ball that falls; a sun and a lamp. The camera is at
 * the origin and looks along +X. */
static stage *stage_make_on(const char *isa)
{
    stage *s = stage_bare(isa);
    daft_material_def mirror = daft_default_material_def();
    mirror.mirror = 0.8f;
    daft_entity_def chrome = sphere(daft_dv3(7, 0.3, -2), 1.2f), falling = sphere(daft_dv3(5, 2, 1), 0.3f);
    chrome.material = daft_material_create(s->scene, &mirror, NULL);
    falling.body = DAFT_BODY_DYNAMIC;
    daft_entity_def floor = box(daft_dv3(5, -2, 0), daft_v3(14, 1, 14));
    floor.body = DAFT_BODY_STATIC;
    s->floor = add(s, floor);
    s->ball = add(s, sphere(daft_dv3(5, 0, 1.5), 1));
    s->chrome = add(s, chrome);
    s->block = add(s, box(daft_dv3(8, 0, 0.5), daft_v3(1, 2, 1)));
    s->falling = add(s, falling);
    daft_scene_set_sky_gradient(s->scene, daft_v3(0.2f, 0.3f, 0.8f), daft_v3(0.8f, 0.8f, 0.9f));
    light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), daft_v3(1, -2, 0.5f), 0.6f);
    light(s, DAFT_LIGHT_POINT, daft_dv3(2, 5, -1), daft_v3(0, -1, 0), 0.3f);
    return s;
}

static stage *stage_make(void)
{
    return stage_make_on(NULL);
}

static void stage_drop(stage *s)
{
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
    free(s);
}

static picture *draw_from(stage *s, daft_quality quality, daft_camera camera)
{
    picture *p = calloc(1, sizeof *p);
    daft_view view = daft_default_view();
    view.quality = quality;
    view.samples = quality == DAFT_QUALITY_REFERENCE ? 4 : 0; /* 16 are slow, and show nothing more here */
    view.camera = camera;
    view.aov = (daft_aov){p->depth, p->normal, p->entity, p->triangle};
    daft_error error = {0};
    if (!daft_render(s->scene, &view, s->image, &error)) fail_msg("%s", error.message);
    memcpy(p->pixels, daft_image_pixels(s->image), sizeof p->pixels);
    return p;
}

static picture *draw(stage *s, daft_quality quality)
{
    return draw_from(s, quality, daft_default_camera());
}

/* Depths above zero, infinite in the sky alone; normals of length 1, zero in the sky alone. */
static void assert_sound(const char *name, const float *depth, const daft_vec3 *normal, const daft_entity *entity,
                         size_t count)
{
    for (size_t i = 0; i < count; i++) {
        daft_vec3 n = normal[i];
        bool sky = entity[i].id == 0;
        if (!(depth[i] >= 0) || (sky != (isinf(depth[i]) != 0)))
            fail_msg("%s: pixel %zu has depth %g", name, i, (double)depth[i]);
        float length = sqrtf(daft_dot(n, n));
        if (!(fabsf(length - (sky ? 0 : 1)) < 1e-4f))
            fail_msg("%s: pixel %zu has the normal %g %g %g", name, i, (double)n.x, (double)n.y, (double)n.z);
    }
}

static void assert_picture_sound(const char *name, const picture *p)
{
    assert_sound(name, p->depth, p->normal, p->entity, PIXELS);
}

static void assert_same(const char *name, const picture *a, const picture *b)
{
    for (size_t i = 0; i < PIXELS; i++)
        if (memcmp(a->pixels + 4 * i, b->pixels + 4 * i, 4) != 0 || memcmp(&a->depth[i], &b->depth[i], 4) != 0 ||
            memcmp(&a->normal[i], &b->normal[i], sizeof a->normal[i]) != 0 || a->entity[i].id != b->entity[i].id ||
            a->triangle[i] != b->triangle[i])
            fail_msg("%s: pixel %zu, %zu is another: entity 0x%x depth %g, it was 0x%x, %g", name, i % WIDTH, i / WIDTH,
                     b->entity[i].id, (double)b->depth[i], a->entity[i].id, (double)a->depth[i]);
}

/* ---- things that are not to be seen ---- */

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
static void radius_tiny(stage *s)
{
    add(s, sphere(BESIDE, 1e-30f));
}
static void radius_denormal(stage *s)
{
    add(s, sphere(BESIDE, FLT_TRUE_MIN));
}
static void box_tiny(stage *s)
{
    add(s, box(BESIDE, daft_v3(1e-30f, 1e-30f, 1e-30f)));
}
static void box_denormal(stage *s)
{
    add(s, box(BESIDE, daft_v3(1e-44f, 1e-44f, 1e-44f)));
}
static void box_thread(stage *s)
{
    add(s, box(BESIDE, daft_v3(1e-30f, 3, 1e-30f)));
}
static void far_behind(stage *s)
{
    add(s, sphere(daft_dv3(-1e30, 0, 0), 1));
}
static void beyond_floats(stage *s)
{
    add(s, sphere(daft_dv3(-1e300, 1e300, 0), 1));
}
static void empty_mesh(stage *s)
{
    add(s, thing(mesh_of(s, NULL, 0, NULL, 0), BESIDE));
}

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
static void black_light_at_the_camera(stage *s)
{
    light(s, DAFT_LIGHT_POINT, daft_dv3(0, 0, 0), daft_v3(0, 0, 0), 0);
}
static void light_beyond_floats(stage *s)
{
    light(s, DAFT_LIGHT_POINT, daft_dv3(1e300, 0, 0), daft_v3(0, 0, 0), 1);
}

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

/* ---- things that are seen, and must not spoil what stands before them ---- */

static void sliver_beside(stage *s)
{
    const daft_vec3 p[] = {{0, -1, 0}, {0, 1, 1e-7f}, {0, 1, 0}, {0, -1, 0}, {0, 1, 1e-5f}, {0, 0.5f, 0.3f}};
    const uint32_t index[] = {0, 1, 2, 3, 4, 5};
    daft_entity_def def = thing(mesh_of(s, p, 6, index, 2), daft_dv3(15, 0, 3));
    def.casts_shadow = false;
    add(s, def);
}
static void wall_of_1e30(stage *s)
{
    const daft_vec3 p[] = {{20, -1e30f, -1e30f}, {20, -1e30f, 1e30f}, {20, 1e30f, 0}};
    const uint32_t index[] = {0, 1, 2};
    daft_entity_def def = thing(mesh_of(s, p, 3, index, 1), daft_dv3(0, 0, 0));
    def.casts_shadow = false;
    add(s, def);
}
static void sphere_of_1e30(stage *s)
{
    daft_entity_def def = sphere(daft_dv3(0, 0, 0), 1e30f);
    def.casts_shadow = false;
    add(s, def);
}
static void box_of_1e18(stage *s)
{
    daft_entity_def def = box(daft_dv3(0, 0, 0), daft_v3(1e18f, 1e18f, 1e18f));
    def.casts_shadow = false;
    add(s, def);
}
static void box_of_1e30(stage *s)
{
    daft_entity_def def = box(daft_dv3(0, 0, 0), daft_v3(1e30f, 1e30f, 1e30f));
    def.casts_shadow = false;
    add(s, def);
}
static void scale_of_1e30(stage *s)
{
    daft_entity_def def = box(daft_dv3(0, 0, 0), daft_v3(1, 1, 1));
    def.scale = daft_v3(1e30f, 1e30f, 1e30f), def.casts_shadow = false;
    add(s, def);
}
static void scales_apart(stage *s)
{
    daft_entity_def def = box(daft_dv3(15, 0, 0), daft_v3(1, 1, 1));
    def.scale = daft_v3(1e-20f, 1e15f, 1e15f), def.casts_shadow = false;
    add(s, def);
}
static void twice_the_same(stage *s)
{
    const daft_vec3 p[] = {{0, -2, -2}, {0, -2, 2}, {0, 3, 0}};
    const uint32_t index[] = {0, 1, 2, 0, 1, 2, 1, 2, 0, 2, 1, 0};
    daft_entity_def def = thing(mesh_of(s, p, 3, index, 4), daft_dv3(14, 0, 3));
    def.casts_shadow = false;
    add(s, def);
    add(s, def);
}
static void bad_normals_and_uvs(stage *s)
{
    const daft_vec3 p[] = {{0, -2, -2}, {0, -2, 2}, {0, 3, 0}};
    const daft_vec3 n[] = {{0, 0, 0}, {NAN, 0, 0}, {1e38f, 1e38f, 1e38f}};
    const daft_vec2 uv[] = {{NAN, 0}, {1e30f, -1e30f}, {0, INFINITY}};
    const uint32_t index[] = {0, 1, 2};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.normals = n, def.uvs = uv, def.vertex_count = 3, def.indices = index, def.triangle_count = 1;
    daft_error error;
    daft_mesh mesh = daft_mesh_create(s->scene, &def, &error);
    if (!mesh.id) fail_msg("%s", error.message);
    daft_entity_def entity = thing(mesh, daft_dv3(14, 0, 3));
    daft_material_def material = daft_default_material_def();
    char path[512];
    snprintf(path, sizeof path, "%s/assets/textures/checker.png", DAFT_ROOT);
    material.diffuse_map = daft_texture_load(s->scene, path, NULL);
    assert_true(material.diffuse_map.id);
    material.map_scale = (daft_vec2){1e30f, 1e-30f};
    entity.material = daft_material_create(s->scene, &material, NULL);
    entity.casts_shadow = false;
    add(s, entity);
}

static const struct {
    const char *name;
    void (*add)(stage *s);
} SEEN[] = {
    {"slivers", sliver_beside},     {"wall of 1e30", wall_of_1e30},     {"sphere of 1e30", sphere_of_1e30},
    {"box of 1e18", box_of_1e18},   {"box of 1e30", box_of_1e30},       {"box scaled by 1e30", scale_of_1e30},
    {"scales apart", scales_apart}, {"twice the same", twice_the_same}, {"normals and uvs", bad_normals_and_uvs}};
enum { SEEN_COUNT = sizeof SEEN / sizeof SEEN[0] };

/* Whether one sound matte thing fills the pixel and those around it. */
static bool is_inside(const stage *s, const picture *p, int x, int y)
{
    uint32_t id = p->entity[y * WIDTH + x].id;
    if (id != s->ball.id && id != s->block.id && id != s->floor.id) return false;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            int u = x + dx, v = y + dy;
            if (u < 0 || v < 0 || u >= WIDTH || v >= HEIGHT) return false;
            if (p->entity[v * WIDTH + u].id != id) return false;
        }
    return true;
}

static void what_is_seen_spoils_nothing_before_it(void **unused)
{
    (void)unused;
    stage *sound = stage_make();
    picture *expected[QUALITY_COUNT];
    for (int q = 0; q < QUALITY_COUNT; q++) expected[q] = draw(sound, QUALITIES[q]);
    for (size_t i = 0; i < SEEN_COUNT; i++) {
        stage *s = stage_make();
        SEEN[i].add(s);
        free(draw(s, DAFT_QUALITY_DRAFT));
        int warnings = s->warnings;
        assert_true(warnings <= 3);
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *p = draw(s, QUALITIES[q]);
            assert_picture_sound(SEEN[i].name, p);
            int compared = 0;
            for (int y = 0; y < HEIGHT; y++)
                for (int x = 0; x < WIDTH; x++) {
                    size_t at = (size_t)(y * WIDTH + x);
                    if (!is_inside(s, expected[q], x, y)) continue;
                    compared++;
                    if (memcmp(expected[q]->pixels + 4 * at, p->pixels + 4 * at, 4) != 0 ||
                        expected[q]->depth[at] != p->depth[at])
                        fail_msg("%s: quality %d, pixel %d, %d: entity 0x%x depth %g, it was 0x%x, %g", SEEN[i].name, q,
                                 x, y, p->entity[at].id, (double)p->depth[at], expected[q]->entity[at].id,
                                 (double)expected[q]->depth[at]);
                }
            assert_true(compared > PIXELS / 4);
            free(p);
        }
        assert_int_equal(s->warnings, warnings);
        stage_drop(s);
    }
    for (int q = 0; q < QUALITY_COUNT; q++) free(expected[q]);
    stage_drop(sound);
}

/* ---- bad triangles in a sound mesh ---- */

enum { RINGS = 8, COLUMNS = 12, BALL_VERTICES = RINGS * COLUMNS, BALL_TRIANGLES = 2 * (RINGS - 1) * COLUMNS };

/* A barrel, open above and below, and room behind it for as many bad triangles. */
static uint32_t make_barrel(daft_vec3 *p, uint32_t *index)
{
    for (uint32_t ring = 0; ring < RINGS; ring++)
        for (uint32_t column = 0; column < COLUMNS; column++) {
            double turn = 2 * 3.14159265358979 * column / COLUMNS, height = (double)ring / (RINGS - 1) * 2 - 1;
            double radius = 1.2 - 0.5 * height * height;
            p[ring * COLUMNS + column] =
                daft_v3((float)(radius * daft_cos(turn)), (float)height, (float)(radius * daft_sin(turn)));
        }
    uint32_t n = 0;
    for (uint32_t ring = 0; ring + 1 < RINGS; ring++)
        for (uint32_t column = 0; column < COLUMNS; column++) {
            uint32_t next = (column + 1) % COLUMNS, a = ring * COLUMNS + column, b = ring * COLUMNS + next;
            const uint32_t two[6] = {a, a + COLUMNS, b + COLUMNS, a, b + COLUMNS, b};
            memcpy(index + 3 * n, two, sizeof two);
            n += 2;
        }
    return n;
}

static daft_mesh_def barrel_def(const daft_vec3 *p, uint32_t vertices, const uint32_t *index, uint32_t triangles)
{
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.vertex_count = vertices, def.indices = index, def.triangle_count = triangles;
    return def;
}

/* Appended to a mesh: repeated and non-finite corners, three corners on a line, three in one place. Shape, normals and
 * light are as before. */
static void bad_triangles_leave_their_mesh_alone(void **unused)
{
    (void)unused;
    daft_vec3 p[BALL_VERTICES + 8];
    uint32_t index[3 * BALL_TRIANGLES + 3 * 64], sound_count = make_barrel(p, index), count = sound_count;
    assert_int_equal(sound_count, BALL_TRIANGLES);
    uint32_t extra = BALL_VERTICES;
    p[extra] = daft_v3(NAN, 0, 0);
    p[extra + 1] = p[extra + 2] = p[3 * COLUMNS];
    for (uint32_t i = 0; i < 12; i++) {
        uint32_t v = 2 * COLUMNS + i, below = v - COLUMNS;
        const uint32_t bad[] = {v, v, below, v, below, extra, extra + 1, extra + 2, 3 * COLUMNS, v, below, v};
        memcpy(index + 3 * count, bad, sizeof bad);
        count += 4;
    }
    picture *pictures[2];
    for (int with = 0; with < 2; with++) {
        stage *s = stage_bare(NULL);
        daft_error error;
        daft_mesh_def def = barrel_def(p, BALL_VERTICES + 3, index, with ? count : sound_count);
        daft_mesh mesh = daft_mesh_create(s->scene, &def, &error);
        if (!mesh.id) fail_msg("%s", error.message);
        daft_mesh_report report;
        assert_true(daft_mesh_check(s->scene, mesh, &report, &error));
        assert_int_equal(report.left_out, with ? 36 : 0);
        assert_int_equal(report.without_area, with ? 12 : 0);
        assert_int_equal(s->warnings, with);
        add(s, thing(mesh, daft_dv3(3.5, 0, 0)));
        light(s, DAFT_LIGHT_POINT, daft_dv3(1, 2, -1), daft_v3(0, 0, 0), 0.6f);
        pictures[with] = draw(s, DAFT_QUALITY_HIGH);
        assert_picture_sound("barrel", pictures[with]);
        stage_drop(s);
    }
    assert_same("bad triangles", pictures[0], pictures[1]);
    free(pictures[0]);
    free(pictures[1]);
}

/* Triangles without area between two sound ones, as cutting a polygon roughly leaves them: nothing shows through. */
static void a_seam_of_slivers_is_closed(void **unused)
{
    (void)unused;
    enum { STEPS = 40 };
    daft_vec3 p[4 + STEPS];
    uint32_t index[6 * (STEPS + 1)], n = 0;
    p[0] = daft_v3(0, -9, -9), p[1] = daft_v3(0, -9, 9), p[2] = daft_v3(0, 9, 9), p[3] = daft_v3(0, 9, -9);
    /* points along the diagonal from 0 to 2: one side uses them, the other does not, and slivers lie between */
    uint32_t before = 0;
    for (uint32_t i = 0; i < STEPS; i++) {
        float t = -9 + 18 * (float)(i + 1) / (STEPS + 1);
        p[4 + i] = daft_v3(0, t, t);
        const uint32_t two[6] = {before, 4 + i, 1, before, 2, 4 + i};
        memcpy(index + n, two, sizeof two);
        n += 6;
        before = 4 + i;
    }
    const uint32_t rest[6] = {before, 2, 1, 0, 3, 2};
    memcpy(index + n, rest, sizeof rest);
    n += 6;
    stage *s = stage_bare(NULL);
    daft_entity_def wall = thing(mesh_of(s, p, 4 + STEPS, index, n / 3), daft_dv3(4, 0, 0));
    daft_material_def matte = daft_default_material_def();
    matte.specular = daft_v3(0, 0, 0);
    wall.material = daft_material_create(s->scene, &matte, NULL);
    s->ball = add(s, wall);
    light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), daft_v3(1, 0, 0), 0.5f);
    for (int q = 0; q < QUALITY_COUNT; q++) {
        picture *pic = draw(s, QUALITIES[q]);
        assert_picture_sound("slivers", pic);
        for (size_t i = 0; i < PIXELS; i++) {
            assert_int_equal(pic->entity[i].id, s->ball.id);
            if (pic->pixels[4 * i] != pic->pixels[0])
                fail_msg("quality %d: pixel %zu is %d, not %d", q, i, pic->pixels[4 * i], pic->pixels[0]);
        }
        free(pic);
    }
    stage_drop(s);
}

/* ---- mirrored things ---- */

/* An outward tetrahedron without a symmetry. */
static daft_mesh lopsided(stage *s)
{
    const daft_vec3 p[] = {{-0.7f, -0.8f, -1}, {0.9f, -0.6f, 0.2f}, {-0.2f, -0.9f, 1.1f}, {0.1f, 1.2f, 0.3f}};
    const uint32_t index[] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
    return mesh_of(s, p, 4, index, 4);
}

static stage *mirror_stage(daft_vec3 scale, daft_quat rotation)
{
    stage *s = stage_bare(NULL);
    daft_entity_def def = thing(lopsided(s), daft_dv3(4, 0, 0));
    def.scale = scale, def.rotation = rotation;
    s->ball = add(s, def);
    light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), daft_v3(1, -0.8f, 0), 0.7f);
    return s;
}

/* With the light in the plane of symmetry, a thing mirrored left to right gives the picture mirrored left to right. */
static void mirrored_things_are_lit_as_their_mirror_image(void **unused)
{
    (void)unused;
    const struct {
        daft_vec3 scale, mirrored;
        daft_quat rotation, turned; /* about X and Y: mirroring z turns them round */
    } cases[] = {
        {{1, 1, 1}, {1, 1, -1}, {0, 0, 0, 1}, {0, 0, 0, 1}},
        {{1.5f, 0.7f, 1}, {1.5f, 0.7f, -1}, {0, 0, 0, 1}, {0, 0, 0, 1}},
        {{-1, 1, 1}, {-1, 1, -1}, {0, 0, 0, 1}, {0, 0, 0, 1}},
        {{-1, -1, -1}, {-1, -1, 1}, {0, 0, 0, 1}, {0, 0, 0, 1}},
        {{1, -2, 0.5f}, {1, -2, -0.5f}, {0.3f, 0.4f, 0, 0.8660254f}, {-0.3f, -0.4f, 0, 0.8660254f}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int q = 0; q < 2; q++) { /* more samples than one are not placed symmetrically */
            stage *plain = mirror_stage(cases[i].scale, cases[i].rotation);
            stage *turned = mirror_stage(cases[i].mirrored, cases[i].turned);
            picture *a = draw(plain, QUALITIES[q]), *b = draw(turned, QUALITIES[q]);
            assert_picture_sound("mirrored", b);
            int different = 0, covered = 0, lit = 0;
            for (int y = 0; y < HEIGHT; y++)
                for (int x = 0; x < WIDTH; x++) {
                    int here = y * WIDTH + x, there = y * WIDTH + WIDTH - 1 - x;
                    covered += a->entity[here].id != 0;
                    lit += a->entity[here].id != 0 && a->pixels[4 * here] > 150;
                    daft_vec3 m = a->normal[here], n = b->normal[there];
                    bool same = abs(a->pixels[4 * here] - b->pixels[4 * there]) <= 1 &&
                                daft_length(daft_sub(daft_v3(m.x, m.y, -m.z), n)) < 1e-3f;
                    different += !same;
                }
            assert_true(covered > PIXELS / 40 && lit > covered / 8);
            if (different > PIXELS / 500)
                fail_msg("case %zu, quality %d: %d of %d pixels are no mirror image", i, q, different, covered);
            free(a);
            free(b);
            stage_drop(plain);
            stage_drop(turned);
        }
    }
}

/* A normal that points away from the camera on a face that is seen would be dark in any light from here. */
static void normals_face_the_viewer(void **unused)
{
    (void)unused;
    const daft_vec3 scales[] = {{1, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {-1, -1, -1}, {1e-3f, -1, 1}};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        stage *s = stage_bare(NULL);
        daft_entity_def def = box(daft_dv3(4, 0, 0), daft_v3(1, 1, 1));
        def.scale = scales[i];
        add(s, def);
        light(s, DAFT_LIGHT_POINT, daft_dv3(0, 0, 0), daft_v3(0, -1, 0), 0.5f);
        picture *p = draw(s, DAFT_QUALITY_GAME);
        size_t middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
        assert_true(p->normal[middle].x < -0.999f);
        assert_true(p->pixels[4 * middle] > 150);
        free(p);
        stage_drop(s);
    }
}

/* ---- cameras and pictures ---- */

static void sizes_and_angles_at_their_ends(void **unused)
{
    (void)unused;
    const struct {
        int width, height;
        float fov;
    } cases[] = {{1, 1, 1.5f},      {1, 5000, 1.5f},   {5000, 1, 1.5f},    {1, 5000, 3.14f}, {5000, 1, 3.14f},
                 {64, 64, 1e-6f},   {64, 64, 3.1415f}, {1, 1, 1e-6f},      {1, 1, 3.1415f},  {3, 2, 1e-3f},
                 {16384, 2, 1e-6f}, {2, 16384, 1e-6f}, {2, 16384, 3.1415f}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        stage *s = stage_make();
        size_t count = (size_t)cases[i].width * (size_t)cases[i].height;
        float *depth = calloc(count, sizeof *depth);
        daft_vec3 *normal = calloc(count, sizeof *normal);
        daft_entity *entity = calloc(count, sizeof *entity);
        daft_error error;
        daft_image *image = daft_image_create(s->engine, cases[i].width, cases[i].height, &error);
        daft_view view = daft_default_view();
        view.camera = daft_camera_look_at(daft_dv3(0, 0, 0), daft_dv3(5, 0, 1.5), cases[i].fov);
        view.aov = (daft_aov){depth, normal, entity, NULL};
        for (int q = 0; q < QUALITY_COUNT; q++) {
            view.quality = QUALITIES[q];
            if (!daft_render(s->scene, &view, image, &error)) fail_msg("%s", error.message);
            char name[64];
            snprintf(name, sizeof name, "%d x %d, %g radians", cases[i].width, cases[i].height, (double)cases[i].fov);
            assert_sound(name, depth, normal, entity, count);
            size_t middle = (size_t)(cases[i].height / 2) * (size_t)cases[i].width + (size_t)(cases[i].width / 2);
            if (cases[i].fov < 0.01f && entity[middle].id != s->ball.id) fail_msg("%s: the ball is not there", name);
        }
        daft_image_destroy(image);
        free(depth);
        free(normal);
        free(entity);
        stage_drop(s);
    }
}

static void cameras_in_odd_places(void **unused)
{
    (void)unused;
    const daft_dvec3 places[] = {{5, 0, 1.5},   /* the centre of a ball */
                                 {4, 0, 1.5},   /* on its surface */
                                 {8, 0, 0.5},   /* in a block */
                                 {7.5, 0, 0.5}, /* on its side */
                                 {7.5, 1, 0},   /* on its corner */
                                 {5, -1.5, 0},  /* on the floor */
                                 {1e15, 0, 0},  {-1e300, 1e300, 0}, {1e-300, 0, 0}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        stage *s = stage_make();
        daft_camera camera = daft_default_camera();
        camera.position = places[i];
        for (int turn = 0; turn < 4; turn++) {
            camera.yaw = (float)turn * 1.5707963f;
            camera.pitch = turn == 3 ? 1.5707963f : 0;
            for (int q = 1; q < QUALITY_COUNT; q += 2) {
                char name[64];
                snprintf(name, sizeof name, "camera %zu, turn %d, quality %d", i, turn, q);
                picture *p = draw_from(s, QUALITIES[q], camera);
                assert_picture_sound(name, p);
                free(p);
            }
        }
        stage_drop(s);
    }
}

/* ---- lights ---- */

static void lights_in_odd_places(void **unused)
{
    (void)unused;
    const daft_dvec3 places[] = {{0, 0, 0}, /* the camera */
                                 {5, 0, 1.5},  {4, 0, 1.5},  {8, 0, 0.5},  {7.5, 0, 0.5}, {7.5, 1, 0},
                                 {5, -1.5, 0}, {1e30, 0, 0}, {0, 1e38, 0}, {1e-40, 0, 0}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        stage *s = stage_make();
        light(s, DAFT_LIGHT_POINT, places[i], daft_v3(0, 0, 0), 0.5f);
        stage *without = stage_make();
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *p = draw(s, QUALITIES[q]), *dark = draw(without, QUALITIES[q]);
            assert_picture_sound("light", p);
            for (size_t k = 0; k < PIXELS; k++) /* light adds: what is not a number would be black */
                for (size_t c = 0; c < 3; c++)
                    if (p->pixels[4 * k + c] < dark->pixels[4 * k + c])
                        fail_msg("light %zu, quality %d: pixel %zu is darker than without", i, q, k);
            free(p);
            free(dark);
        }
        stage_drop(s);
        stage_drop(without);
    }
}

/* A sun along a wall gives it nothing; one of any length that a float has gives the same. */
static void suns_at_their_ends(void **unused)
{
    (void)unused;
    const struct {
        daft_vec3 direction;
        bool lit;
    } suns[] = {{{0, -1, 0}, false},     {{0, 0, 1}, false},      {{0, -1e-30f, 0}, false}, {{-1, 0, 0}, false},
                {{1, 0, 0}, true},       {{1e30f, 0, 0}, true},   {{1e-40f, 0, 0}, true},   {{FLT_MAX, 0, 0}, true},
                {{1e-7f, -1, 0}, false}, {{-1e-7f, -1, 0}, false}};
    for (size_t i = 0; i < sizeof suns / sizeof suns[0]; i++) {
        stage *s = stage_bare(NULL);
        add(s, box(daft_dv3(5, 0, 0), daft_v3(1, 100, 100)));
        light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), suns[i].direction, 1);
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *p = draw(s, QUALITIES[q]);
            assert_picture_sound("sun", p);
            for (size_t k = 0; k < PIXELS; k++) {
                int value = p->pixels[4 * k]; /* ambient: 0.8 times 0.2, sRGB 111 */
                if (suns[i].lit ? value < 200 : abs(value - 111) > 1)
                    fail_msg("sun %zu, quality %d: pixel %zu is %d", i, q, k, value);
            }
            free(p);
        }
        stage_drop(s);
    }
}

static void colors_beyond_all_bounds_are_white(void **unused)
{
    (void)unused;
    const float colors[] = {1e10f, 1e30f, FLT_MAX};
    for (size_t i = 0; i < sizeof colors / sizeof colors[0]; i++) {
        float c = colors[i];
        daft_material_def bright = daft_default_material_def();
        bright.diffuse = bright.specular = bright.emission = bright.ambient = bright.mirror_tint = daft_v3(c, c, c);
        bright.mirror = 0.5f;
        stage *s = stage_make();
        daft_material material = daft_material_create(s->scene, &bright, NULL);
        assert_true(material.id);
        assert_true(daft_entity_set_material(s->scene, s->ball, material, NULL));
        daft_scene_set_ambient(s->scene, daft_v3(c, c, c));
        light(s, DAFT_LIGHT_POINT, daft_dv3(0, 3, 0), daft_v3(0, 0, 0), c);
        light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), daft_v3(1, -1, 0), c);
        daft_scene_set_sky_color(s->scene, daft_v3(c, c, c));
        for (int q = 0; q < QUALITY_COUNT; q++) {
            picture *p = draw(s, QUALITIES[q]);
            assert_picture_sound("color", p);
            for (size_t k = 0; k < PIXELS; k++)
                if (p->pixels[4 * k] != 255 || p->pixels[4 * k + 1] != 255 || p->pixels[4 * k + 2] != 255)
                    fail_msg("color %g, quality %d: pixel %zu of entity 0x%x is %d %d %d", (double)c, q, k,
                             p->entity[k].id, p->pixels[4 * k], p->pixels[4 * k + 1], p->pixels[4 * k + 2]);
            free(p);
        }
        stage_drop(s);
    }
}

/* ---- bad numbers in the definitions themselves ---- */

static void a_light_without_numbers_is_refused(void **unused)
{
    (void)unused;
    stage *s = stage_make();
    daft_error error;
    daft_light_def def = daft_default_light_def();
    def.color.y = NAN;
    assert_int_equal(daft_light_create(s->scene, &def, &error).id, 0);
    assert_non_null(strstr(error.message, "color.y"));
    def = daft_default_light_def();
    def.kind = DAFT_LIGHT_SUN, def.direction = daft_v3(0, 0, 0);
    assert_int_equal(daft_light_create(s->scene, &def, &error).id, 0);
    assert_non_null(strstr(error.message, "direction"));
    daft_view view = daft_default_view();
    view.camera.position.x = NAN;
    assert_false(daft_render(s->scene, &view, s->image, &error));
    assert_non_null(strstr(error.message, "position"));
    view = daft_default_view();
    view.camera.fov = 0;
    assert_false(daft_render(s->scene, &view, s->image, &error));
    view.camera.fov = 3.1416f;
    assert_false(daft_render(s->scene, &view, s->image, &error));
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
        cmocka_unit_test(what_is_seen_spoils_nothing_before_it),
        cmocka_unit_test(bad_triangles_leave_their_mesh_alone),
        cmocka_unit_test(a_seam_of_slivers_is_closed),
        cmocka_unit_test(mirrored_things_are_lit_as_their_mirror_image),
        cmocka_unit_test(normals_face_the_viewer),
        cmocka_unit_test(sizes_and_angles_at_their_ends),
        cmocka_unit_test(cameras_in_odd_places),
        cmocka_unit_test(lights_in_odd_places),
        cmocka_unit_test(suns_at_their_ends),
        cmocka_unit_test(colors_beyond_all_bounds_are_white),
        cmocka_unit_test(a_light_without_numbers_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
