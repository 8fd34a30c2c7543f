/* Colours of vertices in model files as they are drawn: base colours and opacity, in every form that glTF has, and in
 * other formats. Each picture is compared with the colour that a formula names. */
#include "model_fixture.h"

enum { QUADS = 2, CORNERS = 4 * QUADS };

/* Two squares side by side, whose colours do not meet: at the left the one from -1 to 0. */
static const char *const TWO_SQUARES =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1%s},\"indices\":2,\"material\":0}]}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[%s,1]}%s}],"
    "\"buffers\":[{\"byteLength\":344,\"uri\":\"squares.bin\"}],\"bufferViews\":["
    "{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":96},"
    "{\"buffer\":0,\"byteOffset\":192,\"byteLength\":24},"
    "{\"buffer\":0,\"byteOffset\":216,\"byteLength\":128,\"byteStride\":%zu}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":8,\"min\":[-1,-1,0],"
    "\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":8},"
    "{\"bufferView\":2,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":12},"
    "{\"bufferView\":3,\"componentType\":%d,\"type\":\"%s\",\"count\":8%s}]}";

/* By square, at its lower and its upper edge; linear, and of a whole number of 255ths. */
static const int COLORS[QUADS][2][3] = {{{51, 0, 0}, {255, 0, 0}}, {{0, 51, 204}, {0, 255, 102}}};
static const int ALPHAS[QUADS][2] = {{0, 255}, {204, 51}};
static const float SQUARE_X[2] = {0, 1}, SQUARE_Y[4] = {-1, -1, 1, 1};

static bool is_right(int corner) { return corner % 4 == 1 || corner % 4 == 2; }
static bool is_upper(int corner) { return corner % 4 >= 2; }

typedef struct color_format {
    int component; /* glTF's number of it */
    const char *type;
    size_t size;      /* of one color, with what follows up to the next */
    const char *mode; /* what of the material says so; NULL: all of it is there, and all vertices have alpha 1 */
} color_format;

static void put_color(const color_format *format, const int color[3], int alpha, uint8_t *out)
{
    for (int k = 0; k < 4; k++) {
        const int value = k < 3 ? color[k] : format->mode ? alpha : 255;
        const float number = (float)value / 255;
        const uint16_t word = (uint16_t)(257 * value);
        if (k == 3 && strcmp(format->type, "VEC3") == 0) break;
        if (format->component == 5126) memcpy(out + 4 * k, &number, 4);
        if (format->component == 5123) memcpy(out + 2 * k, &word, 2);
        if (format->component == 5121) out[k] = (uint8_t)value;
    }
}

static void put_squares(const color_format *format)
{
    static const uint16_t order[6] = {0, 1, 2, 0, 2, 3};
    uint8_t bytes[344] = {0};
    for (int i = 0; i < CORNERS; i++) {
        const float p[3] = {SQUARE_X[is_right(i)] - (i < 4), SQUARE_Y[i % 4], 0}, n[3] = {0, 0, 1};
        memcpy(bytes + 12 * i, p, 12), memcpy(bytes + 96 + 12 * i, n, 12);
        put_color(format, COLORS[i / 4][is_upper(i)], ALPHAS[i / 4][is_upper(i)],
                  bytes + 216 + format->size * (size_t)i);
    }
    for (int i = 0; i < 6 * QUADS; i++) {
        const uint16_t index = (uint16_t)(4 * (i / 6) + order[i % 6]);
        memcpy(bytes + 192 + 2 * i, &index, 2);
    }
    put("squares.bin", bytes, sizeof bytes);
}

static daft_mesh load_squares(fixture *f, const color_format *format, const char *attribute, const char *base)
{
    static int count;
    char text[4000], name[32];
    snprintf(text, sizeof text, TWO_SQUARES, attribute, base, format->mode ? format->mode : "", format->size,
             format->component, format->type, format->component == 5126 ? "" : ",\"normalized\":true");
    snprintf(name, sizeof name, "squares%d.gltf", count++);
    put_squares(format);
    return load_alone(f, name, text);
}

static void draw_squares(fixture *f, const color_format *format, const char *attribute, const char *base, uint8_t *out)
{
    show(f->scene, load_squares(f, format, attribute, base), (daft_material){0});
    daft_scene_set_ambient(f->scene, daft_v3(0.9f, 0.9f, 0.9f));
    daft_scene_set_sky_color(f->scene, daft_v3(0.1f, 0.3f, 0.8f));
    draw(f, DAFT_TEXTURE_BILINEAR, 0, out);
    assert_int_equal(f->warnings, 0);
}

/* COLOR_0, linear between corners, times the base colour. Light is linear in that: between the pictures of black and
 * white. No colour crosses the edge between the squares, and yet that is one edge of the mesh. */
static void colors_of_vertices_multiply_the_base_color(void **state)
{
    fixture *f = *state;
    static const color_format formats[] = {{5126, "VEC3", 12, NULL}, {5126, "VEC4", 16, NULL}, {5121, "VEC4", 4, NULL},
                                           {5121, "VEC3", 4, NULL},  {5123, "VEC4", 8, NULL},  {5123, "VEC3", 8, NULL}};
    static const double FACTOR[3] = {0.5, 0.8, 1};
    static const char COLOR[] = ",\"COLOR_0\":3";
    uint8_t seen[4 * SIDE * SIDE], black[4 * SIDE * SIDE], white[4 * SIDE * SIDE];
    draw_squares(f, &formats[0], "", "0,0,0", black);
    draw_squares(f, &formats[0], "", "1,1,1", white);
    for (size_t i = 0; i < DAFT_COUNT_OF(formats); i++) {
        draw_squares(f, &formats[i], COLOR, "0.5,0.8,1", seen);
        for (int y = SIDE / 4; y < 3 * SIDE / 4; y++)
            for (int x = SIDE / 4; x < 3 * SIDE / 4; x++) {
                const double up = (1 - place_of(y)) / 2;
                const int(*edge)[3] = COLORS[x >= SIDE / 2];
                double want[3];
                for (int k = 0; k < 3; k++) {
                    const double own = (edge[0][k] + (edge[1][k] - edge[0][k]) * up) / 255,
                                 from = linear_of(black[4 * (y * SIDE + x) + k]),
                                 to = linear_of(white[4 * (y * SIDE + x) + k]);
                    want[k] = from + (to - from) * FACTOR[k] * own;
                }
                compare_pixel(seen, x, y, want, 1.5);
            }
        const daft_trimesh *m = &f->scene->assets.meshes[0]->mesh;
        assert_true(m->vertex_count == 6 && m->colors && m->color_count == CORNERS);
    }
}

/* glTF 2.0, 3.7.2.1 and 3.9.4: COLOR_0's alpha times the base colour's is what alphaMode asks. */
static void alpha_of_vertices_blends_and_masks(void **state)
{
    fixture *f = *state;
    static const char *const MODES[3] = {",\"alphaMode\":\"BLEND\"", ",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5",
                                         ",\"alphaMode\":\"OPAQUE\""};
    static const color_format plain = {5126, "VEC4", 16, NULL};
    static const double SKY[3] = {0.1, 0.3, 0.8};
    static const char COLOR[] = ",\"COLOR_0\":3";
    uint8_t seen[4 * SIDE * SIDE], whole[4 * SIDE * SIDE];
    draw_squares(f, &plain, COLOR, "1,1,1", whole);
    for (int i = 0; i < 9; i++) {
        const color_format format = {(const int[]){5126, 5121, 5123}[i % 3], "VEC4", (const size_t[]){16, 4, 8}[i % 3],
                                     MODES[i / 3]};
        draw_squares(f, &format, COLOR, "1,1,1", seen);
        for (int y = SIDE / 4; y < 3 * SIDE / 4; y++)
            for (int x = SIDE / 4; x < 3 * SIDE / 4; x++) {
                const double up = (1 - place_of(y)) / 2;
                const int *edge = ALPHAS[x >= SIDE / 2];
                double a = (edge[0] + (edge[1] - edge[0]) * up) / 255, want[3];
                if (i / 3 == 1) a = a >= 0.5;
                if (i / 3 == 2) a = 1;
                for (int k = 0; k < 3; k++) want[k] = linear_of(whole[4 * (y * SIDE + x) + k]) * a + SKY[k] * (1 - a);
                compare_pixel(seen, x, y, want, 1.5);
            }
        const daft_trimesh *m = &f->scene->assets.meshes[0]->mesh;
        assert_true(m->vertex_count == 6 && m->colors && m->alphas);
    }
}

/* White vertices and none are the same: no point of the mesh has a colour of its own. */
static void white_vertices_cost_nothing(void **state)
{
    fixture *f = *state;
    static const color_format plain = {5126, "VEC3", 12, NULL};
    load_squares(f, &plain, "", "1,1,1");
    assert_null(f->scene->assets.meshes[0]->mesh.colors);
    load_alone(f, "white.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
               "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
               "property list uchar int vertex_indices\nend_header\n"
               "-1 -1 0 255 255 255\n1 -1 0 255 255 255\n0 1 0 255 255 255\n3 0 1 2\n");
    assert_null(f->scene->assets.meshes[0]->mesh.colors);
    assert_null(f->scene->assets.meshes[0]->mesh.color_indices);
}

/* Other formats have sRGB: what is seen are the file's bytes. */
static void colors_of_other_formats_are_srgb(void **state)
{
    fixture *f = *state;
    uint8_t seen[4 * SIDE * SIDE];
    const daft_mesh mesh =
        load_alone(f, "color.ply",
                   "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                   "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
                   "property list uchar int vertex_indices\nend_header\n"
                   "-1 -1 0 200 100 25\n1 -1 0 200 100 25\n0 1 0 200 100 25\n3 0 1 2\n");
    daft_material_def look = daft_default_material_def();
    look.diffuse = look.ambient = daft_v3(1, 1, 1), look.specular = daft_v3(0, 0, 0);
    show(f->scene, mesh, daft_material_create(f->scene, &look, NULL));
    daft_scene_set_ambient(f->scene, daft_v3(1, 1, 1));
    draw(f, DAFT_TEXTURE_BILINEAR, 0, seen);
    compare_pixel(seen, SIDE / 2, SIDE / 2, (double[3]){linear_of(200), linear_of(100), linear_of(25)}, 1);
}

/* OBJ has a colour and an alpha behind the place. Its own materials are opaque; others may blend. */
static void alpha_of_obj_files(void **state)
{
    fixture *f = *state;
    uint8_t seen[4 * SIDE * SIDE];
    const daft_mesh mesh = load_alone(f, "fading.obj",
                                      "v -1 -1 0 1 1 1 0.25\nv 1 -1 0 1 1 1 0.25\nv 1 1 0 1 1 1 0.25\n"
                                      "v -1 1 0 1 1 1 0.25\nv 0 0 5\nv 0 0 6 1 0 0\nf 1 2 3\nf 1 3 4\n");
    const daft_trimesh *m = &f->scene->assets.meshes[0]->mesh;
    assert_true(m->color_count == 6 && m->alphas && m->alphas[0] == 0.25f && m->alphas[4] == 1 && m->alphas[5] == 1);
    daft_material_def look = daft_default_material_def();
    look.diffuse = look.ambient = daft_v3(1, 1, 1), look.specular = daft_v3(0, 0, 0);
    daft_scene_set_ambient(f->scene, daft_v3(1, 1, 1)), daft_scene_set_sky_color(f->scene, daft_v3(0, 0, 0));
    const daft_entity entity = show(f->scene, mesh, daft_material_create(f->scene, &look, NULL));
    draw(f, DAFT_TEXTURE_BILINEAR, 0, seen);
    compare_pixel(seen, SIDE / 2, SIDE / 2, (double[3]){1, 1, 1}, 1);
    look.alpha_mode = DAFT_ALPHA_BLEND, look.opacity = 0.5f;
    assert_true(daft_entity_destroy(f->scene, entity, NULL));
    show(f->scene, mesh, daft_material_create(f->scene, &look, NULL));
    draw(f, DAFT_TEXTURE_BILINEAR, 0, seen);
    compare_pixel(seen, SIDE / 2, SIDE / 2, (double[3]){0.125, 0.125, 0.125}, 1);
}

/* A material that blends by nothing blends as soon as some mesh has vertices that fade. */
static void materials_fade_when_meshes_come(void **state)
{
    fixture *f = *state;
    daft_material_def look = daft_default_material_def();
    look.alpha_mode = DAFT_ALPHA_BLEND;
    const daft_material material = daft_material_create(f->scene, &look, NULL);
    const uint32_t *traits = &f->scene->assets.surfaces[daft_asset_index(material.id)].traits;
    assert_int_equal(*traits & DAFT_TRAIT_BLEND, 0);
    const daft_vec3 positions[3] = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    const float alphas[3] = {1, 2, NAN};
    const uint32_t indices[3] = {0, 1, 2};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions, def.alphas = alphas, def.vertex_count = 3;
    def.indices = indices, def.triangle_count = 1;
    assert_true(daft_mesh_create(f->scene, &def, NULL).id);
    assert_int_equal(f->scene->assets.surfaces[daft_asset_index(material.id)].traits & DAFT_TRAIT_BLEND,
                     DAFT_TRAIT_BLEND);
    for (int i = 0; i < 3; i++) assert_true(f->scene->assets.meshes[0]->mesh.alphas[i] == 1);
}

int main(void)
{
    if (!READS_BY_LIBRARY) return 77;
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(colors_of_vertices_multiply_the_base_color),
        WITH_FOLDER(alpha_of_vertices_blends_and_masks),
        WITH_FOLDER(white_vertices_cost_nothing),
        WITH_FOLDER(colors_of_other_formats_are_srgb),
        WITH_FOLDER(alpha_of_obj_files),
        WITH_FOLDER(materials_fade_when_meshes_come),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
