/* Files of models in a folder of their own, drawn as a small picture: a square of glTF with any material, and what a
 * pixel should be in linear light. */
#ifndef TESTS_MODEL_FIXTURE_H
#define TESTS_MODEL_FIXTURE_H

#include "scene_fixture.h"

#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SIDE = 64, TEXELS = 4 };

static char folder[64];

static inline int open_folder(void **state)
{
    snprintf(folder, sizeof folder, "/tmp/daft-maps-XXXXXX");
    return mkdtemp(folder) ? set_up(state) : -1;
}

static inline int close_folder(void **state)
{
    char command[100];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return tear_down(state) | system(command);
}

static inline const char *put(const char *name, const void *bytes, size_t size)
{
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_true(daft_write_file(path, bytes, size, NULL));
    return path;
}

static const char *put_text(const char *name, const char *text) { return put(name, text, strlen(text)); }

/* B, G, R, A, the top row first. */
static inline const char *put_picture(const char *name, int width, int height, const uint8_t *bytes)
{
    static uint8_t tga[18 + 4 * 64 * 32];
    const uint8_t header[18] = {[2] = 2, [12] = (uint8_t)width, [14] = (uint8_t)height, [16] = 32, [17] = 0x28};
    memcpy(tga, header, sizeof header);
    const size_t size = 4 * (size_t)width * (size_t)height;
    memcpy(tga + 18, bytes, size);
    return put(name, tga, 18 + size);
}

/* From (0, 0, 2) along -z: at z = 0, pixel x is at 4 (x + 0.5) / SIDE - 2 to the right. */
static inline void draw(fixture *f, daft_texture_filter filter, int mirror_depth, uint8_t *out)
{
    daft_view view = daft_default_view();
    daft_error error;
    daft_image *image = daft_image_create(f->engine, SIDE, SIDE, NULL);
    view.camera = daft_camera_look_at(daft_dv3(0, 0, 2), daft_dv3(0, 0, 0), (float)(DAFT_PI / 2));
    view.quality.texture_filter = filter, view.quality.edge_samples = 0, view.quality.mirror_depth = mirror_depth;
    if (!daft_render(f->scene, &view, image, &error)) fail_msg("%s", error.message);
    memcpy(out, daft_image_pixels(image), 4 * SIDE * SIDE);
    daft_image_destroy(image);
}

static double place_of(int pixel) { return 4 * (pixel + 0.5) / SIDE - 2; }

static inline daft_entity show(daft_scene *scene, daft_mesh mesh, daft_material material)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.material = material;
    const daft_entity entity = daft_entity_create(scene, &def, NULL);
    assert_true(entity.id != 0);
    return entity;
}

/* A square from -1 to 1 in x and y that faces +z, the picture's left edge at x = -1. */
static const char *const SQUARE =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2},\"indices\":3,"
    "\"material\":0}]}],\"materials\":[{%s}],\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"map.tga\"}],"
    "\"buffers\":[{\"byteLength\":140,\"uri\":\"square.bin\"}],\"bufferViews\":["
    "{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":48},"
    "{\"buffer\":0,\"byteOffset\":96,\"byteLength\":32},{\"buffer\":0,\"byteOffset\":128,\"byteLength\":12}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":4,\"min\":[-1,-1,0],"
    "\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":4},"
    "{\"bufferView\":2,\"componentType\":5126,\"type\":\"VEC2\",\"count\":4},"
    "{\"bufferView\":3,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":6}]}";

static inline void put_square(void)
{
    static const float numbers[32] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 1, 0,
                                      0,  1,  0, 0, 1,  0, 0, 1, 0, 1,  1, 1, 1, 0, 0, 0};
    static const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    uint8_t bytes[140];
    memcpy(bytes, numbers, 128), memcpy(bytes + 128, indices, 12);
    put("square.bin", bytes, sizeof bytes);
}

/* A new scene with the model alone. Skips where this build or system has no Assimp. */
static inline daft_mesh load_alone(fixture *f, const char *name, const char *text)
{
    daft_error error;
    daft_scene_destroy(f->scene);
    f->scene = daft_scene_create(f->engine, NULL);
    const daft_mesh mesh = daft_mesh_load(f->scene, put_text(name, text), &error);
    if (!mesh.id && error.code == DAFT_ERROR_UNSUPPORTED) skip();
    if (!mesh.id) fail_msg("%s", error.message);
    return mesh;
}

static inline daft_mesh load_square(fixture *f, const char *material)
{
    static int count;
    char text[4000], name[32];
    snprintf(text, sizeof text, SQUARE, material), snprintf(name, sizeof name, "square%d.gltf", count++);
    return load_alone(f, name, text);
}

static inline void add_sun(fixture *f)
{
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = daft_v3(0.3f, -0.2f, -1), sun.color = daft_v3(0.6f, 0.5f, 0.4f);
    assert_true(daft_light_create(f->scene, &sun, NULL).id != 0);
}

static inline double linear_of(double byte)
{
    const double c = byte / 255;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static inline double byte_of(double linear)
{
    const double c = fmin(linear, 1);
    return 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055);
}

static inline void compare_pixel(const uint8_t *seen, int x, int y, const double linear[3], double most)
{
    const uint8_t *got = seen + 4 * (y * SIDE + x);
    for (int k = 0; k < 3; k++)
        if (fabs(got[k] - byte_of(linear[k])) > most)
            fail_msg("pixel %d, %d, channel %d: %d, not %.2f", x, y, k, got[k], byte_of(linear[k]));
}

#define WITH_FOLDER(name) cmocka_unit_test_setup_teardown(name, open_folder, close_folder)

#endif
