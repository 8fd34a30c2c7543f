/* Materials as pictures: maps, vertex colours, opacity, physically based shading, each against something obvious;
 * media that there are none of. */
#include "scene/scene.h"
#include "support_content.h"

#include <math.h>

enum { SIDE = 64 };

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
} stage;

static stage stage_new(void)
{
    stage s;
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    s.engine = daft_engine_create(&def, NULL);
    s.scene = daft_scene_create(s.engine, NULL);
    s.image = daft_image_create(s.engine, SIDE, SIDE, NULL);
    assert_true(s.engine && s.scene && s.image);
    return s;
}

static void stage_free(stage *s)
{
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
}

static daft_view view_of(const stage *s, daft_preset preset)
{
    (void)s;
    daft_view view = daft_default_view();
    view.quality = daft_preset_quality(preset);
    view.camera.fov = (float)(DAFT_PI / 2);
    return view; /* at the origin, along +X, Y up, +Z to the right */
}

static const uint8_t *draw(stage *s, daft_preset preset)
{
    daft_error error = {0};
    daft_view view = view_of(s, preset);
    if (!daft_render(s->scene, &view, s->image, &error)) fail_msg("%s", error.message);
    return daft_image_pixels(s->image);
}

static const uint8_t *pixel(const uint8_t *rgba, int x, int y) { return rgba + 4 * (y * SIDE + x); }

/* A square of 2 m across the view at x = 2, u to the right, v up; the part of it from u = `from` on. */
static daft_mesh square(const stage *s, float from, const daft_vec3 *colors)
{
    const float z = 2 * from - 1;
    const daft_vec3 positions[4] = {{2, -1, z}, {2, -1, 1}, {2, 1, 1}, {2, 1, z}}, back = {-1, 0, 0};
    const daft_vec3 normals[4] = {back, back, back, back};
    const daft_vec2 uvs[4] = {{from, 0}, {1, 0}, {1, 1}, {from, 1}};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions, def.normals = normals, def.uvs = uvs, def.colors = colors, def.vertex_count = 4;
    def.indices = indices, def.triangle_count = 2;
    const daft_mesh mesh = daft_mesh_create(s->scene, &def, NULL);
    assert_true(mesh.id);
    return mesh;
}

static daft_entity put(const stage *s, daft_mesh mesh, const daft_material_def *look, double away)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.position = daft_dv3(away, 0, 0);
    def.material = daft_material_create(s->scene, look, NULL);
    assert_true(def.material.id);
    return daft_entity_create(s->scene, &def, NULL);
}

/* 2 by 2 texels, the right half of which is opaque. */
static daft_texture half_mask(const stage *s)
{
    static const uint8_t tga[18 + 4 * 4] = {[2] = 2, [12] = 2, [14] = 2, [16] = 32, [17] = 0x28, [18] = 255, 255,
                                            255,     0,        255,      255,       255,         255,        255,
                                            255,     255,      0,        255,       255,         255,        255};
    const char *path = write_test_file("half.tga", tga, sizeof tga);
    const daft_texture texture = daft_texture_load(s->scene, path, NULL);
    assert_true(texture.id);
    return texture;
}

static void vertex_colors(void **unused)
{
    (void)unused;
    stage s = stage_new();
    const daft_vec3 red = {1, 0, 0}, colors[4] = {red, red, red, red};
    daft_material_def look = daft_default_material_def();
    look.diffuse = look.ambient = daft_v3(1, 1, 1), look.specular = daft_v3(0, 0, 0);
    put(&s, square(&s, 0, colors), &look, 0);
    daft_scene_set_ambient(s.scene, daft_v3(1, 1, 1));
    const uint8_t *p = pixel(draw(&s, DAFT_PRESET_GAME), SIDE / 2, SIDE / 2);
    assert_true(p[0] == 255 && p[1] == 0 && p[2] == 0);
    stage_free(&s);
}

/* Holes are as if the geometry were cut there: to the camera, and in the mirror behind it. */
static void a_mask_is_cut_geometry(void **unused)
{
    (void)unused;
    uint8_t whole[4 * SIDE * SIDE];
    for (int cut = 0; cut < 2; cut++) {
        stage s = stage_new();
        daft_material_def look = daft_default_material_def();
        look.diffuse = look.ambient = daft_v3(0.5f, 0.25f, 1), look.specular = daft_v3(0, 0, 0);
        if (!cut) look.alpha_map = half_mask(&s), look.alpha_mode = DAFT_ALPHA_MASK, look.map_wrap = DAFT_WRAP_CLAMP;
        put(&s, square(&s, cut ? 0.5f : 0, NULL), &look, 0);
        daft_scene_set_ambient(s.scene, daft_v3(1, 1, 1));
        const uint8_t *rgba = draw(&s, DAFT_PRESET_DRAFT);
        if (!cut) memcpy(whole, rgba, sizeof whole);
        if (cut) assert_memory_equal(whole, rgba, sizeof whole);
        assert_true(pixel(rgba, SIDE / 2 - 4, SIDE / 2)[2] < 128 && pixel(rgba, SIDE / 2 + 4, SIDE / 2)[2] == 255);
        stage_free(&s);
    }
}

/* One layer of 0.25 over another, over the sky: in the right order however they were made. */
static void layers_blend_in_order(void **unused)
{
    (void)unused;
    for (int order = 0; order < 2; order++) {
        stage s = stage_new();
        daft_scene_set_ambient(s.scene, daft_v3(1, 1, 1));
        for (int k = 0; k < 2; k++) {
            const bool near = k == order;
            daft_material_def look = daft_default_material_def();
            look.diffuse = look.ambient = near ? daft_v3(1, 0, 0) : daft_v3(0, 1, 0), look.specular = daft_v3(0, 0, 0);
            look.alpha_mode = DAFT_ALPHA_BLEND, look.opacity = 0.25f;
            put(&s, square(&s, 0, NULL), &look, near ? 0 : 0.5);
        }
        const uint8_t *p = pixel(draw(&s, DAFT_PRESET_DRAFT), SIDE / 2, SIDE / 2);
        const float sky = daft_srgb_to_linear((float)pixel(daft_image_pixels(s.image), 0, 0)[2] / 255);
        assert_true(fabsf(daft_srgb_to_linear((float)p[0] / 255) - 0.25f - 0.5625f * sky) < 0.01f);
        assert_true(fabsf(daft_srgb_to_linear((float)p[1] / 255) - 0.1875f - 0.5625f * sky) < 0.01f);
        assert_true(fabsf(daft_srgb_to_linear((float)p[2] / 255) - 0.5625f * sky) < 0.01f);
        stage_free(&s);
    }
}

/* A white sphere under a white sky is not seen, whatever it is made of. */
static void furnace(void **unused)
{
    (void)unused;
    static const float ROUGH[] = {0, 0.3f, 0.6f, 1};
    for (int metal = 0; metal < 2; metal++)
        for (size_t k = 0; k < DAFT_COUNT_OF(ROUGH); k++) {
            stage s = stage_new();
            const daft_vec3 white = {1, 1, 1};
            daft_scene_set_ambient(s.scene, white);
            daft_scene_set_sky_color(s.scene, white);
            daft_material_def look = daft_default_material_def();
            look.shading = DAFT_SHADING_PHYSICAL, look.metallic = (float)metal, look.roughness = ROUGH[k];
            look.diffuse = look.ambient = white;
            daft_entity_def def = daft_default_entity_def();
            def.shape = DAFT_SHAPE_SPHERE, def.radius = 1, def.position = daft_dv3(2.5, 0, 0);
            def.material = daft_material_create(s.scene, &look, NULL);
            assert_true(daft_entity_create(s.scene, &def, NULL).id);
            const uint8_t *rgba = draw(&s, DAFT_PRESET_GAME);
            int least = 255;
            for (int i = 0; i < 4 * SIDE * SIDE; i++) least = daft_min_i(least, rgba[i]);
            print_message("metal %d, roughness %g: %d\n", metal, (double)ROUGH[k], least);
            assert_true(least >= 253);
            stage_free(&s);
        }
}

/* The light of a plane whose normals all lean one way is that of a plane that leans so itself. */
static void a_normal_map_is_a_turned_plane(void **unused)
{
    (void)unused;
    stage s = stage_new();
    /* slope 3/4 along u: normal (-0.6, 0, 0.8) in tangent space; BGRA */
    static const uint8_t tga[18 + 4] = {[2] = 2, [12] = 1, [14] = 1, [16] = 32, [17] = 0x28, [18] = 230, 128, 51, 255};
    const char *path = write_test_file("lean.tga", tga, sizeof tga);
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = daft_v3(1, 0, 0), sun.color = daft_v3(1, 1, 1);
    assert_true(daft_light_create(s.scene, &sun, NULL).id);
    daft_scene_set_ambient(s.scene, daft_v3(0, 0, 0));
    daft_material_def look = daft_default_material_def();
    look.diffuse = daft_v3(1, 1, 1), look.specular = daft_v3(0, 0, 0);
    look.normal_map = daft_texture_load(s.scene, path, NULL);
    put(&s, square(&s, 0, NULL), &look, 0);
    const uint8_t *p = pixel(draw(&s, DAFT_PRESET_GAME), SIDE / 2, SIDE / 2);
    assert_true(fabsf(daft_srgb_to_linear((float)p[0] / 255) - 0.8f) < 0.015f); /* the cosine to a sun straight ahead */
    stage_free(&s);
}

static void media_are_checked(void **unused)
{
    (void)unused;
    stage s = stage_new();
    static const struct {
        float distance;
        int priority;
        const char *says;
    } bad[] = {{-1, 0, "tint_distance is -1"},
               {NAN, 0, "tint_distance is"},
               {0, 256, "medium_priority is 256"},
               {0, -1, "medium_priority is -1"}};
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++) {
        daft_material_def def = daft_default_material_def();
        daft_error error = {0};
        def.tint_distance = bad[i].distance, def.medium_priority = bad[i].priority;
        assert_false(daft_material_create(s.scene, &def, &error).id);
        assert_contains(error.message, bad[i].says);
    }
    stage_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertex_colors),
        cmocka_unit_test(a_mask_is_cut_geometry),
        cmocka_unit_test(layers_blend_in_order),
        cmocka_unit_test(furnace),
        cmocka_unit_test(a_normal_map_is_a_turned_plane),
        cmocka_unit_test(media_are_checked),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
