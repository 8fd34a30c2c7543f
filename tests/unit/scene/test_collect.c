/* scene: assets that nothing holds are freed when the program asks, and no others; their handles are stale for ever. */
#include "base/files.h"
#include "support_content.h"

#include "scene/scene.h"

static daft_engine *engine;
static daft_scene *scene;

static int make_scene(void **unused)
{
    (void)unused;
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    engine = daft_engine_create(&def, NULL);
    scene = daft_scene_create(engine, NULL);
    return engine && scene ? 0 : -1;
}

static int destroy_scene(void **unused)
{
    (void)unused;
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    return 0;
}

static daft_mesh new_mesh(float height)
{
    const daft_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, height, 0}, {0, 0, 1}};
    const uint32_t indices[] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 0, 2, 3};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions, def.vertex_count = 4, def.indices = indices, def.triangle_count = 4;
    daft_mesh mesh = daft_mesh_create(scene, &def, NULL);
    assert_true(mesh.id);
    return mesh;
}

static daft_material new_material(const char *texture)
{
    daft_material_def def = daft_default_material_def();
    daft_error error;
    if (texture) def.diffuse_map = daft_texture_load(scene, texture, &error);
    daft_material material = daft_material_create(scene, &def, NULL);
    assert_true(material.id);
    if (texture) assert_true(daft_texture_release(scene, def.diffuse_map, &error));
    return material;
}

static daft_entity new_entity(daft_mesh mesh, daft_material material, daft_body_kind body)
{
    daft_entity_def def = daft_default_entity_def();
    daft_error error;
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.material = material, def.body = body;
    daft_entity entity = daft_entity_create(scene, &def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    return entity;
}

static bool mesh_is_there(daft_mesh mesh)
{
    daft_mesh_info info;
    return daft_mesh_get_info(scene, mesh, &info, NULL);
}

static bool material_is_there(daft_material material)
{
    daft_material_def def;
    return daft_material_get(scene, material, &def, NULL);
}

static void what_is_held_or_used_stays(void **unused)
{
    (void)unused;
    daft_mesh mesh = new_mesh(1), held = new_mesh(2);
    daft_material material = new_material(DAFT_ROOT "/assets/textures/checker.png");
    daft_entity entity = new_entity(mesh, material, DAFT_BODY_NONE);
    assert_int_equal(daft_scene_collect(scene), 0);
    assert_true(daft_mesh_release(scene, mesh, NULL) && daft_material_release(scene, material, NULL));
    assert_int_equal(daft_scene_collect(scene), 0); /* the entity uses both, and the material the texture */
    assert_true(daft_entity_destroy(scene, entity, NULL));
    assert_int_equal(daft_scene_collect(scene), 3);
    assert_false(mesh_is_there(mesh) || material_is_there(material));
    assert_true(mesh_is_there(held));
    assert_int_equal(scene->assets.texture_slots.live, 0);
    assert_true(material_is_there((daft_material){1}));
}

static void bodies_use_meshes(void **unused)
{
    (void)unused;
    daft_mesh mesh = new_mesh(1);
    daft_collider collider = daft_default_collider();
    collider.kind = DAFT_COLLIDER_MESH, collider.mesh = mesh;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_NONE, def.body = DAFT_BODY_STATIC, def.colliders = &collider, def.collider_count = 1;
    daft_error error;
    daft_entity entity = daft_entity_create(scene, &def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    assert_true(daft_mesh_release(scene, mesh, NULL));
    assert_int_equal(daft_scene_collect(scene), 0);
    assert_true(daft_scene_step(scene, 1.0f / 60, &error));
    assert_true(daft_entity_destroy(scene, entity, NULL));
    assert_int_equal(daft_scene_collect(scene), 1);
}

static void handles_are_stale_for_ever(void **unused)
{
    (void)unused;
    daft_error error;
    daft_mesh first = new_mesh(1);
    assert_true(daft_mesh_release(scene, first, &error));
    assert_false(daft_mesh_release(scene, first, &error));
    assert_contains(error.message, "released as often as it was given");
    assert_int_equal(daft_scene_collect(scene), 1);
    for (int i = 0; i < 5000; i++) {
        daft_mesh mesh = new_mesh(1);
        assert_true(mesh.id != first.id && !mesh_is_there(first));
        assert_true(daft_mesh_release(scene, mesh, NULL));
        daft_scene_collect(scene);
    }
    assert_false(daft_mesh_release(scene, first, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    assert_false(daft_mesh_release(scene, (daft_mesh){0}, &error) ||
                 daft_texture_release(scene, (daft_texture){UINT32_MAX}, &error) ||
                 daft_material_release(scene, (daft_material){1}, &error));
    assert_int_equal(daft_scene_collect(NULL), 0);
}

static void files_are_loaded_again(void **unused)
{
    (void)unused;
    daft_error error;
    const char *obj = DAFT_ROOT "/assets/meshes/cup.obj", *mtl = DAFT_ROOT "/assets/meshes/meshes.mtl#gold";
    for (int i = 0; i < 3; i++) {
        daft_mesh mesh = daft_mesh_load(scene, obj, &error), again = daft_mesh_load(scene, obj, &error);
        daft_material gold = daft_material_load(scene, mtl, &error), same = daft_material_load(scene, mtl, &error);
        assert_true(mesh.id && mesh.id == again.id && gold.id && gold.id == same.id);
        assert_true(daft_mesh_release(scene, mesh, &error) && daft_material_release(scene, gold, &error));
        assert_int_equal(daft_scene_collect(scene), 0); /* held once more */
        assert_true(daft_mesh_release(scene, mesh, &error) && daft_material_release(scene, gold, &error));
        assert_true(daft_scene_collect(scene) > 2); /* with the materials of the mesh */
        assert_int_equal(scene->assets.material_slots.live, 1);
    }
    assert_true(daft_scene_load(scene, DAFT_ROOT "/assets/scenes/hello.scene", &error));
    assert_int_equal(daft_scene_collect(scene), 0);
    assert_false(daft_scene_load(scene, DAFT_ROOT "/README.md", &error));
    assert_int_equal(daft_scene_collect(scene), 0);
}

/* The picture of a frame that was taken before its assets went. */
static void frames_keep_what_they_read(void **unused)
{
    (void)unused;
    daft_error error;
    daft_image *image = daft_image_create(engine, 64, 48, &error), *later = daft_image_create(engine, 64, 48, &error);
    daft_mesh mesh = new_mesh(1);
    daft_material material = new_material(DAFT_ROOT "/assets/textures/brick.png");
    daft_entity entity = new_entity(mesh, material, DAFT_BODY_NONE);
    assert_true(daft_mesh_release(scene, mesh, NULL) && daft_material_release(scene, material, NULL));
    daft_view view = daft_default_view();
    view.camera.position = (daft_dvec3){-3, 0.3, 0.3};
    assert_true(daft_render(scene, &view, image, &error));
    daft_renderer *renderer = daft_renderer_create(scene->allocator, 1, engine->isa, &error);
    daft_scene_frame *frame = daft_frame_take(scene, &view, 64, 48, &error);
    assert_true(renderer && frame);
    assert_true(daft_entity_destroy(scene, entity, &error));
    assert_int_equal(daft_scene_collect(scene), 3);
    const daft_frame_target target = {.pixels = daft_image_pixels(later)};
    assert_true(daft_frame_draw(frame, renderer, &target, &error));
    daft_frame_release(scene, frame);
    assert_memory_equal(daft_image_pixels(later), daft_image_pixels(image), 64 * 48 * 4);
    assert_true(daft_render(scene, &view, later, &error));
    daft_renderer_destroy(renderer);
    daft_image_destroy(image);
    daft_image_destroy(later);
}

static void memory_stays_flat(void **unused)
{
    (void)unused;
    uint64_t after_some = 0;
    for (int tick = 0; tick < 10000; tick++) {
        daft_mesh mesh = new_mesh((float)(tick + 1));
        daft_material material = new_material(NULL);
        daft_entity entity = new_entity(mesh, material, DAFT_BODY_NONE);
        assert_true(daft_mesh_release(scene, mesh, NULL) && daft_material_release(scene, material, NULL));
        assert_true(daft_entity_destroy(scene, entity, NULL));
        if (tick % 100 == 0) assert_true(daft_scene_collect(scene) > 0);
        if (tick == 500) after_some = daft_engine_memory(engine).used;
    }
    daft_scene_collect(scene);
    assert_true(daft_engine_memory(engine).peak < after_some + 1000000);
}

static uint64_t draw(daft_scene *what)
{
    daft_error error;
    daft_image *image = daft_image_create(engine, 64, 36, &error);
    daft_view view = daft_default_view();
    view.camera.position = (daft_dvec3){-3, 0, 0};
    if (!daft_render(what, &view, image, &error)) fail_msg("%s", error.message);
    const uint64_t hash = daft_hash(daft_image_pixels(image), 4 * 64 * 36, 0);
    daft_image_destroy(image);
    return hash;
}

static void fill(daft_scene *what, const char *picture)
{
    daft_error error;
    daft_entity_def def = daft_default_entity_def();
    daft_material_def look = daft_default_material_def();
    look.diffuse = look.ambient = (daft_vec3){1, 1, 1};
    look.diffuse_map = daft_texture_load(what, picture, &error);
    def.shape = DAFT_SHAPE_BOX, def.size = (daft_vec3){1, 1, 1};
    def.material = daft_material_create(what, &look, &error);
    if (!look.diffuse_map.id || !daft_entity_create(what, &def, &error).id) fail_msg("%s", error.message);
    if (!daft_scene_set_sky_image(what, picture, &error)) fail_msg("%s", error.message);
    daft_scene_set_ambient(what, (daft_vec3){1, 1, 1});
}

/* Two scenes of an engine read a picture once; it stays while one of them does. */
static void scenes_share_pictures(void **unused)
{
    (void)unused;
    daft_error error;
    daft_image *picture = daft_image_create(engine, 512, 256, &error);
    for (uint32_t i = 0; i < 4u * 512 * 256; i++)
        daft_image_pixels(picture)[i] = (uint8_t)(i % 4 == 3 ? 255 : i * i % 251);
    assert_true(daft_image_write(picture, test_path("shared.png"), &error));
    daft_image_destroy(picture);
    const uint64_t empty = daft_engine_memory(engine).used;
    fill(scene, test_path("shared.png"));
    const uint64_t one = daft_engine_memory(engine).used - empty, hash = draw(scene);
    daft_scene *other = daft_scene_create(engine, &error);
    const uint64_t before = daft_engine_memory(engine).used;
    fill(other, test_path("shared.png"));
    const uint64_t two = daft_engine_memory(engine).used - before;
    assert_true(one > 2000000); /* 0.7 MB of texels, 1.6 MB of sky */
    if (two > 100000) fail_msg("%llu bytes", (unsigned long long)two);
    assert_true(draw(other) == hash);
    daft_scene_destroy(scene);
    scene = other;
    assert_true(draw(other) == hash);
    /* What is saved under the same name is another picture. */
    picture = daft_image_create(engine, 512, 256, &error);
    assert_true(daft_image_write(picture, test_path("shared.png"), &error));
    daft_image_destroy(picture);
    daft_scene *third = daft_scene_create(engine, &error);
    fill(third, test_path("shared.png"));
    assert_true(draw(third) != hash);
    assert_true(draw(other) == hash);
    daft_scene_destroy(third);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, make_scene, destroy_scene)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(what_is_held_or_used_stays), TEST(bodies_use_meshes),          TEST(handles_are_stale_for_ever),
        TEST(files_are_loaded_again),     TEST(frames_keep_what_they_read), TEST(memory_stays_flat),
        TEST(scenes_share_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
