/* Frames: what one draws stays as it was when it was taken, while another thread changes the scene; and nothing that it
 * reads is freed or written before it is released. Meant for ThreadSanitizer and valgrind as much as for its own
 * assertions. */
#include "scene_fixture.h"

#include <pthread.h>
#include <stdlib.h>

enum { WIDTH = 160, HEIGHT = 90, DRAWS = 4, BYTES = WIDTH * HEIGHT * 4 };

/* ---- a scene with something of everything that frames read ---- */

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_renderer *renderer;
    daft_mesh mesh;
    daft_material material;
    daft_entity box, sphere, meshes[3];
    daft_light light;
} stage;

static const daft_vec3 CORNERS[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

static daft_mesh make_mesh(daft_scene *scene)
{
    static const uint32_t indices[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = CORNERS, def.vertex_count = 4, def.indices = indices, def.triangle_count = 4;
    return daft_mesh_create(scene, &def, NULL);
}

static daft_entity make(stage *s, daft_shape shape, double x, double z)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = shape, def.mesh = s->mesh, def.material = s->material;
    def.position = daft_dv3(x, 0, z);
    if (shape == DAFT_SHAPE_SPHERE) def.body = DAFT_BODY_DYNAMIC;
    daft_entity entity = daft_entity_create(s->scene, &def, NULL);
    assert_true(entity.id != 0);
    return entity;
}

static stage stage_make(daft_accel accel)
{
    stage s = {0};
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    def.accel = accel;
    assert_non_null(s.engine = daft_engine_create(&def, NULL));
    assert_non_null(s.scene = daft_scene_create(s.engine, NULL));
    assert_non_null(s.renderer = daft_renderer_create(s.scene->allocator, 1, s.engine->isa, NULL));
    daft_material_def look = daft_default_material_def();
    look.mirror = 0.3f;
    look.diffuse_map = daft_texture_load(s.scene, DAFT_ROOT "/assets/textures/checker.png", NULL);
    s.material = daft_material_create(s.scene, &look, NULL);
    assert_true(look.diffuse_map.id && s.material.id);
    assert_true(daft_scene_set_sky_image(s.scene, DAFT_ROOT "/assets/sky/day.jpg", NULL));
    s.mesh = make_mesh(s.scene);
    s.box = make(&s, DAFT_SHAPE_BOX, 4, -2);
    s.sphere = make(&s, DAFT_SHAPE_SPHERE, 4, 2);
    for (int i = 0; i < 3; i++) s.meshes[i] = make(&s, DAFT_SHAPE_MESH, 3 + i, 0.3 * i);
    daft_light_def light = daft_default_light_def();
    light.position = daft_dv3(0, 5, 1);
    s.light = daft_light_create(s.scene, &light, NULL);
    return s;
}

static void stage_end(stage *s)
{
    daft_renderer_destroy(s->renderer);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
}

/* Everything that a frame reads is changed, moved or destroyed. */
static void change_everything(stage *s, int turn)
{
    daft_error error;
    daft_vec3 moved[4];
    for (int i = 0; i < 4; i++) moved[i] = daft_scale(CORNERS[i], 1 + 0.1f * (float)(turn + 1));
    assert_true(daft_mesh_set_positions(s->scene, s->mesh, moved, NULL, 4, &error));
    daft_material_def look;
    assert_true(daft_material_get(s->scene, s->material, &look, &error));
    look.diffuse = daft_v3(0.1f * (float)turn, 0, 1), look.mirror = 0;
    assert_true(daft_material_set(s->scene, s->material, &look, &error));
    for (int i = 0; i < 40; i++) daft_material_create(s->scene, &look, NULL);  /* the table moves */
    if (turn == 0) assert_true(daft_entity_destroy(s->scene, s->box, &error)); /* the last box of its size */
    daft_transform t;
    assert_true(daft_entity_get_transform(s->scene, s->meshes[0], &t, &error));
    t.position.y += 0.5;
    assert_true(daft_entity_set_transform(s->scene, s->meshes[0], &t, true, &error));
    for (int i = 0; i < 100; i++) make(s, DAFT_SHAPE_MESH, 6, 0.1 * i);
    daft_light_def light;
    assert_true(daft_light_get(s->scene, s->light, &light, &error));
    light.color = daft_v3(1, 0, 0);
    assert_true(daft_light_set(s->scene, s->light, &light, &error));
    daft_scene_set_sky_color(s->scene, daft_v3(0, 0.2f * (float)turn, 0));
    daft_ray_hit hit;
    daft_scene_cast_ray(s->scene, daft_dv3(0, 0.2, 0), daft_v3(1, 0, 0), 100, (daft_entity){0}, &hit, NULL);
    daft_scene_begin_tick(s->scene);
    assert_true(daft_scene_step(s->scene, 1.0f / 60, &error));
}

/* ---- drawing ---- */

typedef struct drawing {
    daft_scene_frame *frame;
    daft_renderer *renderer;
    uint8_t *pixels[DRAWS];
    bool drawn;
} drawing;

static bool draw(daft_scene_frame *frame, daft_renderer *renderer, uint8_t *pixels)
{
    daft_frame_target target = {.pixels = pixels};
    return daft_frame_draw(frame, renderer, &target, NULL);
}

static void *draw_often(void *context)
{
    drawing *d = context;
    d->drawn = true;
    for (int i = 0; i < DRAWS; i++) d->drawn = draw(d->frame, d->renderer, d->pixels[i]) && d->drawn;
    return NULL;
}

static daft_view front(void)
{
    daft_view view = daft_default_view();
    view.camera = daft_camera_look_at(daft_dv3(-1, 1.5, 0), daft_dv3(4, 0, 0), 1.2f);
    return view;
}

static void a_frame_stays_as_it_was(daft_accel accel)
{
    stage s = stage_make(accel);
    const daft_view view = front();
    daft_scene_frame *frame = daft_frame_take(s.scene, &view, WIDTH, HEIGHT, NULL);
    assert_non_null(frame);
    uint8_t *before = calloc(DRAWS + 2, BYTES);
    assert_true(draw(frame, s.renderer, before));
    drawing d = {.frame = frame, .renderer = s.renderer};
    for (int i = 0; i < DRAWS; i++) d.pixels[i] = before + (size_t)(i + 1) * BYTES;
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, draw_often, &d), 0);
    for (int turn = 0; turn < 3; turn++) change_everything(&s, turn);
    pthread_join(thread, NULL);
    assert_true(d.drawn);
    for (int i = 0; i < DRAWS; i++) assert_memory_equal(d.pixels[i], before, BYTES);
    assert_non_null(s.scene->retired);
    /* what is taken now sees the scene of now, while the old one still stands */
    daft_scene_frame *next = daft_frame_take(s.scene, &view, WIDTH, HEIGHT, NULL);
    uint8_t *after = before + (size_t)(DRAWS + 1) * BYTES;
    assert_true(next && next != frame && draw(next, s.renderer, after));
    assert_memory_not_equal(after, before, BYTES);
    assert_true(draw(frame, s.renderer, after));
    assert_memory_equal(after, before, BYTES);
    daft_frame_release(s.scene, frame);
    assert_null(s.scene->retired); /* nothing was let go of since the second was taken */
    daft_frame_release(s.scene, next);
    free(before);
    stage_end(&s);
}

static void drawn_while_the_scene_changes(void **state)
{
    (void)state;
    a_frame_stays_as_it_was(DAFT_ACCEL_BVH);
}

static void drawn_through_kd_trees_while_the_scene_changes(void **state)
{
    (void)state;
    a_frame_stays_as_it_was(DAFT_ACCEL_KDTREE);
}

/* ---- when memory is out ---- */

typedef struct scarce {
    long left; /* allocations that succeed; below 0: all do */
} scarce;

static void *scarce_allocate(void *user, size_t size, size_t alignment)
{
    scarce *s = user;
    if (s->left == 0) return NULL;
    if (s->left > 0) s->left--;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void scarce_release(void *user, void *pointer)
{
    (void)user;
    free(pointer);
}

/* Wherever an allocation fails while vertices move, what could not be made is made the next time. */
static void memory_that_was_out_is_not_out_for_ever(void **state)
{
    (void)state;
    scarce s = {-1};
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1, def.accel = DAFT_ACCEL_KDTREE;
    def.allocator = (daft_allocator){&s, scarce_allocate, scarce_release};
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_scene *scene = daft_scene_create(engine, NULL);
    daft_mesh mesh = make_mesh(scene);
    daft_mesh_info whole, info;
    assert_true(daft_mesh_get_info(scene, mesh, &whole, NULL));
    bool failed = false, without = false;
    for (long n = 0; n < 60; n++) {
        daft_error error;
        s.left = n;
        bool moved = daft_mesh_set_positions(scene, mesh, CORNERS, NULL, 4, &error);
        s.left = -1;
        assert_true(moved || error.code == DAFT_ERROR_MEMORY);
        failed |= !moved;
        without |= moved && !scene->assets.meshes[mesh.id - 1]->kdtree;
        assert_true(daft_mesh_set_positions(scene, mesh, CORNERS, NULL, 4, NULL));
        assert_true(daft_mesh_get_info(scene, mesh, &info, NULL));
        assert_int_equal(info.bytes, whole.bytes);
        assert_non_null(scene->assets.meshes[mesh.id - 1]->kdtree);
    }
    assert_true(failed && without);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

/* A settled scene uses one frame, and keeps its instances. */
static void frames_are_used_again(void **state)
{
    (void)state;
    stage s = stage_make(DAFT_ACCEL_BVH);
    const daft_view view = front();
    daft_scene_frame *first = daft_frame_take(s.scene, &view, WIDTH, HEIGHT, NULL);
    uint64_t revision = first->snapshot.revision;
    daft_frame_release(s.scene, first);
    for (int i = 0; i < 3; i++) {
        daft_scene_frame *again = daft_frame_take(s.scene, &view, WIDTH, HEIGHT, NULL);
        assert_ptr_equal(again, first);
        assert_true(again->snapshot.revision == revision);
        daft_frame_release(s.scene, again);
    }
    change_everything(&s, 0);
    assert_null(s.scene->retired); /* no frame was taken: all is freed at once */
    daft_scene_frame *fresh = daft_frame_take(s.scene, &view, WIDTH, HEIGHT, NULL);
    assert_true(fresh == first && fresh->snapshot.revision != revision);
    stage_end(&s); /* also while a frame is taken */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drawn_while_the_scene_changes),
        cmocka_unit_test(drawn_through_kd_trees_while_the_scene_changes),
        cmocka_unit_test(frames_are_used_again),
        cmocka_unit_test(memory_that_was_out_is_not_out_for_ever),
    };
    (void)set_up, (void)tear_down, (void)make_sphere;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
