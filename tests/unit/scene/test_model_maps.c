/* Maps of model files as they are drawn: what lies beyond a texture's edges, holes where alpha is below glTF's cutoff,
 * roughness, metal, emission and occlusion from images, colours of vertices, and materials of OBJ files from the asset
 * roots. Each picture is compared with what is drawn without a map, or with the texel that a formula names. */
#include "scene_fixture.h"

#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SIDE = 64, TEXELS = 4 };

static char folder[64];

static int open_folder(void **state)
{
    snprintf(folder, sizeof folder, "/tmp/daft-maps-XXXXXX");
    return mkdtemp(folder) ? set_up(state) : -1;
}

static int close_folder(void **state)
{
    char command[100];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return tear_down(state) | system(command);
}

static const char *put(const char *name, const void *bytes, size_t size)
{
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_true(daft_write_file(path, bytes, size, NULL));
    return path;
}

static const char *put_text(const char *name, const char *text) { return put(name, text, strlen(text)); }

/* B, G, R, A, the top row first. */
static const char *put_picture(const char *name, int width, int height, const uint8_t *bytes)
{
    static uint8_t tga[18 + 4 * 64 * 32];
    const uint8_t header[18] = {[2] = 2, [12] = (uint8_t)width, [14] = (uint8_t)height, [16] = 32, [17] = 0x28};
    memcpy(tga, header, sizeof header);
    const size_t size = 4 * (size_t)width * (size_t)height;
    memcpy(tga + 18, bytes, size);
    return put(name, tga, 18 + size);
}

/* From (0, 0, 2) along -z: at z = 0, pixel x is at 4 (x + 0.5) / SIDE - 2 to the right. */
static void draw(fixture *f, daft_texture_filter filter, int mirror_depth, uint8_t *out)
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

static daft_entity show(daft_scene *scene, daft_mesh mesh, daft_material material)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.material = material;
    const daft_entity entity = daft_entity_create(scene, &def, NULL);
    assert_true(entity.id != 0);
    return entity;
}

/* ---- beyond the edges ---- */

/* The texel of 0..TEXELS - 1 that a coordinate means. */
static int wrapped(daft_wrap wrap, double u)
{
    if (wrap == DAFT_WRAP_CLAMP) return u < 0 ? 0 : u >= 1 ? TEXELS - 1 : (int)(u * TEXELS);
    const double tile = floor(u), part = u - tile;
    const bool back = wrap == DAFT_WRAP_MIRROR && fmod(fabs(tile), 2) == 1;
    return (int)((back ? 1 - part : part) * TEXELS);
}

static void what_lies_beyond_edges_is_drawn(void **state)
{
    fixture *f = *state;
    const daft_vec3 positions[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    const daft_vec2 uvs[4] = {{-1.5f, -1.5f}, {2.5f, -1.5f}, {2.5f, 2.5f}, {-1.5f, 2.5f}};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    uint8_t texels[4 * TEXELS * TEXELS], seen[4 * SIDE * SIDE];
    for (int i = 0; i < TEXELS * TEXELS; i++) /* bytes that survive sRGB and back */
        texels[4 * i] = (uint8_t)(16 * i), texels[4 * i + 1] = (uint8_t)(255 - 16 * i), texels[4 * i + 2] = 90,
                   texels[4 * i + 3] = 255;
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions, def.uvs = uvs, def.vertex_count = 4, def.indices = indices, def.triangle_count = 2;
    const daft_mesh mesh = daft_mesh_create(f->scene, &def, NULL);
    daft_material_def look = daft_default_material_def();
    look.diffuse = look.ambient = daft_v3(1, 1, 1), look.specular = daft_v3(0, 0, 0);
    look.diffuse_map = daft_texture_load(f->scene, put_picture("texels.tga", TEXELS, TEXELS, texels), NULL);
    assert_true(look.diffuse_map.id != 0);
    const daft_material material = daft_material_create(f->scene, &look, NULL);
    show(f->scene, mesh, material);
    daft_scene_set_ambient(f->scene, daft_v3(1, 1, 1));
    for (uint32_t wrap = DAFT_WRAP_REPEAT; wrap <= DAFT_WRAP_MIRROR; wrap++) {
        int compared = 0;
        look.map_wrap = wrap;
        assert_true(daft_material_set(f->scene, material, &look, NULL));
        draw(f, DAFT_TEXTURE_NEAREST, 0, seen);
        for (int y = SIDE / 4; y < 3 * SIDE / 4; y++)
            for (int x = SIDE / 4; x < 3 * SIDE / 4; x++) {
                const double u = 2 * place_of(x) + 0.5, v = 0.5 - 2 * place_of(y);
                const int column = wrapped(wrap, u), row = TEXELS - 1 - wrapped(wrap, v);
                const uint8_t *got = seen + 4 * (y * SIDE + x), *texel = texels + 4 * (row * TEXELS + column);
                if (abs(got[0] - texel[2]) > 1 || abs(got[1] - texel[1]) > 1 || abs(got[2] - texel[0]) > 1)
                    fail_msg("wrap %u at %g, %g: %d %d %d, not texel %d, %d", wrap, u, v, got[0], got[1], got[2],
                             column, row);
                compared++;
            }
        assert_int_equal(compared, SIDE * SIDE / 4);
    }
}

/* ---- glTF ---- */

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

static void put_square(void)
{
    static const float numbers[32] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 1, 0,
                                      0,  1,  0, 0, 1,  0, 0, 1, 0, 1,  1, 1, 1, 0, 0, 0};
    static const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    uint8_t bytes[140];
    memcpy(bytes, numbers, 128), memcpy(bytes + 128, indices, 12);
    put("square.bin", bytes, sizeof bytes);
}

/* A new scene with the model alone. Skips where this build or system has no Assimp. */
static daft_mesh load_alone(fixture *f, const char *name, const char *text)
{
    daft_error error;
    daft_scene_destroy(f->scene);
    f->scene = daft_scene_create(f->engine, NULL);
    const daft_mesh mesh = daft_mesh_load(f->scene, put_text(name, text), &error);
    if (!mesh.id && error.code == DAFT_ERROR_UNSUPPORTED) skip();
    if (!mesh.id) fail_msg("%s", error.message);
    return mesh;
}

static daft_mesh load_square(fixture *f, const char *material)
{
    static int count;
    char text[4000], name[32];
    snprintf(text, sizeof text, SQUARE, material), snprintf(name, sizeof name, "square%d.gltf", count++);
    return load_alone(f, name, text);
}

static void add_sun(fixture *f)
{
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = daft_v3(0.3f, -0.2f, -1), sun.color = daft_v3(0.6f, 0.5f, 0.4f);
    assert_true(daft_light_create(f->scene, &sun, NULL).id != 0);
}

/* The picture of a square of this material under a sun and a blue sky. */
static void draw_square(fixture *f, const char *material, uint8_t *out)
{
    show(f->scene, load_square(f, material), (daft_material){0});
    add_sun(f);
    daft_scene_set_sky_color(f->scene, daft_v3(0.1f, 0.3f, 0.8f));
    draw(f, DAFT_TEXTURE_NEAREST, 0, out);
    assert_int_equal(f->warnings, 0);
}

static void alpha_below_the_cutoff_is_a_hole(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *cutoff;
        double value;
    } cases[] = {{"", 0.5}, {",\"alphaCutoff\":0.25", 0.25}, {",\"alphaCutoff\":0.8", 0.8}};
    static const uint8_t alphas[4 * TEXELS] = {0, 0, 255, 0, 0, 0, 255, 85, 0, 0, 255, 170, 0, 0, 255, 255};
    uint8_t seen[4 * SIDE * SIDE];
    put_square(), put_picture("map.tga", TEXELS, 1, alphas);
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        char material[300];
        snprintf(material, sizeof material,
                 "\"alphaMode\":\"MASK\"%s,\"pbrMetallicRoughness\":{\"metallicFactor\":0,"
                 "\"baseColorTexture\":{\"index\":0}}",
                 cases[i].cutoff);
        draw_square(f, material, seen);
        for (int x = 0; x < SIDE; x++) {
            const double u = (place_of(x) + 1) / 2;
            const bool there = u > 0 && u < 1 && alphas[4 * (int)(u * TEXELS) + 3] / 255.0 >= cases[i].value;
            const uint8_t *got = seen + 4 * (SIDE / 2 * SIDE + x); /* the surface is red, the sky blue */
            if ((got[0] > got[2]) != there) fail_msg("cutoff %g at %g: %d, %d", cases[i].value, u, got[0], got[2]);
        }
    }
}

/* The left half of a picture is that of one material, the right half that of another. */
static void compare_halves(const uint8_t *seen, const uint8_t *left, const uint8_t *right)
{
    int different = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const uint8_t *want = (i % SIDE < SIDE / 2 ? left : right) + 4 * i;
        if (memcmp(seen + 4 * i, want, 4) != 0)
            fail_msg("pixel %d, %d: %d %d %d, not %d %d %d", i % SIDE, i / SIDE, seen[4 * i], seen[4 * i + 1],
                     seen[4 * i + 2], want[0], want[1], want[2]);
        different += memcmp(left + 4 * i, right + 4 * i, 4) != 0;
    }
    assert_true(different > SIDE * SIDE / 8); /* else nothing is compared */
}

static void roughness_and_metal_come_from_one_image(void **state)
{
    fixture *f = *state;
    /* left: roughness 1, no metal; right: roughness 51/255, metal */
    static const uint8_t halves[4 * 2] = {0, 255, 7, 255, 255, 51, 7, 255};
    uint8_t seen[4 * SIDE * SIDE], left[4 * SIDE * SIDE], right[4 * SIDE * SIDE];
    put_square(), put_picture("map.tga", 2, 1, halves);
#define BASE "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.9,0.3,0.1,1],"
    draw_square(f, BASE "\"metallicRoughnessTexture\":{\"index\":0}}", seen);
    draw_square(f, BASE "\"metallicFactor\":0,\"roughnessFactor\":1}", left);
    draw_square(f, BASE "\"metallicFactor\":1,\"roughnessFactor\":0.2}", right);
    compare_halves(seen, left, right);
}

static void emission_comes_from_its_image(void **state)
{
    fixture *f = *state;
    static const uint8_t halves[4 * 2] = {0, 0, 0, 255, 255, 255, 255, 255};
    uint8_t seen[4 * SIDE * SIDE], left[4 * SIDE * SIDE], right[4 * SIDE * SIDE];
    put_square(), put_picture("map.tga", 2, 1, halves);
#define DULL BASE "\"metallicFactor\":0,\"roughnessFactor\":1}"
    draw_square(f, "\"emissiveFactor\":[0,0.5,0.25],\"emissiveTexture\":{\"index\":0}," DULL, seen);
    draw_square(f, DULL, left);
    draw_square(f, "\"emissiveFactor\":[0,0.5,0.25]," DULL, right);
    compare_halves(seen, left, right);
}

static double linear_of(double byte)
{
    const double c = byte / 255;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static double byte_of(double linear)
{
    const double c = fmin(linear, 1);
    return 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055);
}

static void compare_pixel(const uint8_t *seen, int x, int y, const double linear[3], double most)
{
    const uint8_t *got = seen + 4 * (y * SIDE + x);
    for (int k = 0; k < 3; k++)
        if (fabs(got[k] - byte_of(linear[k])) > most)
            fail_msg("pixel %d, %d, channel %d: %d, not %.2f", x, y, k, got[k], byte_of(linear[k]));
}

/* ---- occlusion ---- */

typedef enum lit_by { BY_AMBIENT, BY_SKY, BY_SUN, BY_BOTH } lit_by;

static void light_by(fixture *f, lit_by by)
{
    daft_scene_set_ambient(f->scene, by == BY_SUN ? daft_v3(0, 0, 0) : daft_v3(0.5f, 0.5f, 0.5f));
    daft_scene_set_sky_color(f->scene, daft_v3(0.25f, 0.5f, 0.75f));
    if (by == BY_SKY) daft_scene_set_ambient_sky(f->scene, 1);
    if (by == BY_SUN || by == BY_BOTH) add_sun(f);
}

/* What this material is under these lights. */
static void draw_lit(fixture *f, const char *material, lit_by by, uint8_t *out)
{
    show(f->scene, load_square(f, material), (daft_material){0});
    light_by(f, by);
    draw(f, DAFT_TEXTURE_NEAREST, 0, out);
    assert_int_equal(f->warnings, 0);
}

static const uint8_t REDS[TEXELS] = {0, 85, 170, 255};

static void put_occlusion(void)
{
    uint8_t texels[4 * TEXELS]; /* blue and green say the opposite */
    for (int i = 0; i < TEXELS; i++) {
        texels[4 * i] = texels[4 * i + 1] = (uint8_t)(255 - REDS[i]);
        texels[4 * i + 2] = REDS[i], texels[4 * i + 3] = 255;
    }
    put_picture("map.tga", TEXELS, 1, texels);
}

#define WHITE "\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":1}"

/* The middle of the picture `seen`: ambient light times what the map leaves, and the sun as in the picture `sun`. */
static void compare_occluded(const uint8_t *seen, const uint8_t *sun, lit_by by, double strength)
{
    static const double AMBIENT[2][3] = {{0.5, 0.5, 0.5}, {0.25, 0.5, 0.75}};
    for (int y = SIDE / 4; y < 3 * SIDE / 4; y++)
        for (int x = SIDE / 4; x < 3 * SIDE / 4; x++) {
            const double left = 1 + strength * (REDS[(int)((place_of(x) + 1) / 2 * TEXELS)] / 255.0 - 1);
            double want[3];
            for (int k = 0; k < 3; k++) {
                const double own = linear_of(sun[4 * (y * SIDE + x) + k]);
                want[k] = by == BY_SUN ? own : AMBIENT[by == BY_SKY][k] * left + (by == BY_BOTH ? own : 0);
            }
            compare_pixel(seen, x, y, want, by == BY_SUN ? 0.01 : 1);
        }
}

/* White dielectrics send on all of the light from everywhere, whatever facets reflect of it: the picture is the map. */
static void occlusion_dims_ambient_light_alone(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *text;
        double value;
    } strengths[] = {{"", 1}, {",\"strength\":0.6", 0.6}, {",\"strength\":0", 0}};
    uint8_t seen[4 * SIDE * SIDE], sun[4 * SIDE * SIDE];
    put_square(), put_occlusion();
    draw_lit(f, WHITE, BY_SUN, sun);
    for (size_t s = 0; s < DAFT_COUNT_OF(strengths); s++) {
        char material[300];
        snprintf(material, sizeof material, "\"occlusionTexture\":{\"index\":0%s}," WHITE, strengths[s].text);
        for (lit_by by = BY_AMBIENT; by <= BY_BOTH; by++) {
            draw_lit(f, material, by, seen);
            const uint32_t traits = f->scene->assets.surfaces[1].traits; /* without this one no code of it runs */
            assert_int_equal((traits & DAFT_TRAIT_OCCLUSION) != 0, strengths[s].value > 0);
            compare_occluded(seen, sun, by, strengths[s].value);
        }
    }
}

/* The square in Phong's white, with lines of MTL. */
static void draw_phong(fixture *f, const char *name, const char *more, lit_by by, uint8_t *out)
{
    char text[200];
    daft_error error;
    const daft_mesh mesh = load_square(f, WHITE);
    snprintf(text, sizeof text, "newmtl m\nKd 1 1 1\nKa 1 1 1\nKs 0 0 0\n%s", more);
    const daft_material material = daft_material_load(f->scene, put_text(name, text), &error);
    if (!material.id) fail_msg("%s", error.message);
    show(f->scene, mesh, material);
    light_by(f, by);
    draw(f, DAFT_TEXTURE_NEAREST, 0, out);
    assert_int_equal(f->warnings, 0);
}

/* Phong's materials have it from MTL, where -mm says the strength: base + gain · red. */
static void occlusion_of_mtl_files(void **state)
{
    fixture *f = *state;
    uint8_t seen[4 * SIDE * SIDE], sun[4 * SIDE * SIDE];
    put_square(), put_occlusion();
    draw_phong(f, "without.mtl", "", BY_SUN, sun);
    for (lit_by by = BY_AMBIENT; by <= BY_BOTH; by++) {
        draw_phong(f, "with.mtl", "map_AO -mm 0.4 0.6 map.tga\n", by, seen);
        compare_occluded(seen, sun, by, 0.6);
    }
}

static void occlusion_by_other_coordinates_is_told(void **state)
{
    fixture *f = *state;
    put_square(), put_occlusion();
    load_square(f, "\"name\":\"stone\",\"occlusionTexture\":{\"index\":0,\"texCoord\":1}," WHITE);
    assert_int_equal(f->warnings, 1);
    assert_non_null(strstr(f->last_warning.message, "'stone'"));
    assert_int_equal(f->scene->assets.surfaces[1].traits & DAFT_TRAIT_OCCLUSION, 0);
}

/* ---- normals ---- */

/* One texel that leans to the right: the slope of what it is of. */
static double put_leaning(void)
{
    static const uint8_t texel[4] = {204, 128, 230, 255};
    put_picture("map.tga", 1, 1, texel);
    return (2 * 230 / 255.0 - 1) / (2 * 204 / 255.0 - 1);
}

/* -bm of `norm` multiplies slopes: against the cosine to the sun. What no material may have is the most it may. */
static void slopes_of_mtl_files(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *text;
        double value;
    } cases[] = {{"norm map.tga\n", 1}, {"norm -bm 0.5 map.tga\n", 0.5}, {"norm -bm -0.4 map.tga\n", -0.4}};
    uint8_t seen[4 * SIDE * SIDE], flat[4 * SIDE * SIDE];
    put_square();
    const double slope = put_leaning();
    draw_phong(f, "without.mtl", "", BY_SUN, flat);
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        draw_phong(f, "with.mtl", cases[i].text, BY_SUN, seen);
        const double x = slope * cases[i].value, part = (1 - 0.3 * x) / sqrt(1 + x * x); /* the sun's way: see add_sun
                                                                                          */
        double want[3];
        const int middle = SIDE / 2;
        for (int k = 0; k < 3; k++) want[k] = linear_of(flat[4 * (middle * SIDE + middle) + k]) * part;
        compare_pixel(seen, middle, middle, want, 1.5);
    }
    draw_phong(f, "with.mtl", "norm -bm 1e6 map.tga\nbump -bm -1e9 map.tga\n", BY_SUN, seen);
    for (uint32_t i = 1; i < f->scene->assets.material_slots.count; i++) {
        const daft_material_def *def = &f->scene->assets.materials[i];
        if (def->bump_map.id) assert_true(def->normal_strength == 100 && def->bump_strength == -1000);
    }
}

/* glTF's normalTexture.scale is the material's normal_strength. */
static void slopes_of_gltf_files(void **state)
{
    fixture *f = *state;
    uint8_t seen[4 * SIDE * SIDE], other[4 * SIDE * SIDE], plain[4 * SIDE * SIDE];
    put_square(), put_leaning();
    draw_square(f, "\"normalTexture\":{\"index\":0}," WHITE, plain);
    assert_true(f->scene->assets.materials[1].normal_strength == 1);
    draw_square(f, "\"normalTexture\":{\"index\":0,\"scale\":0.25}," WHITE, seen);
    assert_true(f->scene->assets.materials[1].normal_strength == 0.25f);
    draw_square(f, "\"normalTexture\":{\"index\":0}," WHITE, other);
    const daft_material material = {daft_asset_id(&f->scene->assets.material_slots, 1)};
    daft_material_def def;
    assert_true(daft_material_get(f->scene, material, &def, NULL));
    def.normal_strength = 0.25f;
    assert_true(daft_material_set(f->scene, material, &def, NULL));
    draw(f, DAFT_TEXTURE_NEAREST, 0, other);
    assert_memory_equal(seen, other, sizeof seen);
    assert_true(memcmp(seen, plain, sizeof seen) != 0);
}

/* ---- colours of vertices ---- */

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

/* ---- refl ---- */

/* A ball of a material of paint.mtl, which is lit by nothing. */
static void draw_ball(fixture *f, const char *more, const char *sky, uint8_t *out)
{
    char text[300];
    daft_error error;
    daft_scene_destroy(f->scene);
    f->scene = daft_scene_create(f->engine, NULL);
    snprintf(text, sizeof text, "newmtl m\nKd 0 0 0\nKs 1 0.5 0.25\nillum 3\n%s", more);
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 0.8f;
    def.material = daft_material_load(f->scene, put_text("paint.mtl", text), &error);
    if (!def.material.id) fail_msg("%s", error.message);
    assert_true(daft_entity_create(f->scene, &def, NULL).id != 0);
    daft_scene_set_ambient(f->scene, daft_v3(0, 0, 0));
    daft_scene_set_sky_color(f->scene, daft_v3(0, 0, 0));
    if (sky) assert_true(daft_scene_set_sky_image(f->scene, sky, NULL));
    draw(f, DAFT_TEXTURE_BILINEAR, 2, out);
}

/* A reflection map is as if the sky were that image, where nothing else stands around; and no ray is cast for it. */
static void a_reflection_map_is_mirrored_as_a_sky(void **state)
{
    fixture *f = *state;
    static uint8_t texels[4 * 64 * 32], by_map[4 * SIDE * SIDE], by_sky[4 * SIDE * SIDE];
    for (int y = 0; y < 32; y++)
        for (int x = 0; x < 64; x++) {
            uint8_t *t = texels + 4 * (64 * y + x);
            const bool pole = y < 2 || y > 29; /* one grey, since a sky ends at its poles and a texture goes round */
            t[0] = (uint8_t)(pole ? 90 : 40 + 3 * abs(32 - x)), t[1] = (uint8_t)(pole ? 90 : 7 * y);
            t[2] = pole ? 90 : 200, t[3] = 255;
        }
    char sky[200];
    snprintf(sky, sizeof sky, "%s", put_picture("around.tga", 64, 32, texels));
    draw_ball(f, "refl -type sphere around.tga\n", NULL, by_map);
    assert_int_equal(daft_scene_counters(f->scene)->reflection_rays, 0);
    draw_ball(f, "", sky, by_sky);
    assert_true(daft_scene_counters(f->scene)->reflection_rays > 0);
    int bright = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double x = i % SIDE + 0.5 - SIDE / 2, y = i / SIDE + 0.5 - SIDE / 2; /* its outline: 14 pixels away */
        if (x * x + y * y > 12.5 * 12.5) continue;
        for (int k = 0; k < 3; k++)
            if (abs(by_map[4 * i + k] - by_sky[4 * i + k]) > 2)
                fail_msg("pixel %d, %d: %d, by the sky %d", i % SIDE, i / SIDE, by_map[4 * i + k], by_sky[4 * i + k]);
        bright += by_map[4 * i] > 60;
    }
    assert_true(bright > 400);
    draw_ball(f, "illum 2\nrefl around.tga\n", NULL, by_map); /* which does not mirror */
    assert_int_equal(by_map[4 * (SIDE / 2 * SIDE + SIDE / 2)], 0);
    assert_int_equal(f->warnings, 0);
}

/* Six images of one colour each: each is seen where a sky of the six would be mirrored. */
static void a_cube_is_mirrored_as_a_sky(void **state)
{
    fixture *f = *state;
    static const char *const NAMES[6] = {"right", "left", "top", "bottom", "front", "back"};
    static uint8_t by_map[4 * SIDE * SIDE], by_sky[4 * SIDE * SIDE], texels[4 * 16 * 16];
    char skies[6][200], text[300] = "";
    const char *paths[6];
    for (int i = 0; i < 6; i++) {
        char name[20];
        for (int k = 0; k < 16 * 16; k++) {
            const int bits = i + 1;
            texels[4 * k] = bits & 1 ? 255 : 80, texels[4 * k + 1] = bits & 2 ? 255 : 80;
            texels[4 * k + 2] = bits & 4 ? 255 : 80, texels[4 * k + 3] = 255;
        }
        snprintf(name, sizeof name, "%s.tga", NAMES[i]);
        snprintf(skies[i], sizeof skies[i], "%s", put_picture(name, 16, 16, texels));
        paths[i] = skies[i];
        snprintf(text + strlen(text), sizeof text - strlen(text), "refl -type cube_%s %s\n", NAMES[i], name);
    }
    draw_ball(f, text, NULL, by_map);
    assert_int_equal(daft_scene_counters(f->scene)->reflection_rays, 0);
    assert_int_equal(f->warnings, 0);
    draw_ball(f, "", NULL, by_sky);
    assert_true(daft_scene_set_sky_cube(f->scene, paths, NULL));
    draw(f, DAFT_TEXTURE_BILINEAR, 2, by_sky);
    int same = 0, other = 0, seen[8] = {0};
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double x = i % SIDE + 0.5 - SIDE / 2, y = i / SIDE + 0.5 - SIDE / 2;
        if (x * x + y * y > 12.5 * 12.5) continue;
        bool inside = true, near = true; /* of one image: all around it is the same */
        for (int k = 0; k < 3; k++) {
            const uint8_t *at = &by_sky[4 * i + k];
            inside = inside && at[4] == *at && at[-4] == *at && at[4 * SIDE] == *at && at[-4 * SIDE] == *at;
            near = near && abs(by_map[4 * i + k] - *at) <= 4; /* a corner is a texel away */
        }
        if (!inside) continue;
        same += near, other += !near;
        /* Ks 1 0.5 0.25: the bits of the colour are those above the half */
        seen[(by_map[4 * i] > 200 ? 4 : 0) + (by_map[4 * i + 1] > 120 ? 2 : 0) + (by_map[4 * i + 2] > 90 ? 1 : 0)]++;
    }
    print_message("%d pixels the same, %d others\n", same, other);
    for (int i = 0; i < 6; i++) print_message("%s: %d pixels\n", NAMES[i], seen[i + 1]);
    assert_true(same > 250 && other == 0);
    for (int i = 0; i < 4; i++) assert_true(seen[i + 1] > 5); /* the front is behind the ball */
    assert_true(seen[6] > 20);
    put_text("top.tga", "no image");
    draw_ball(f, text, NULL, by_map); /* goes without: rays find the dark */
    assert_true(f->warnings == 1);
    assert_int_equal(by_map[4 * (SIDE / 2 * SIDE + SIDE / 2)], 0);
}

/* ---- mtllib ---- */

static void make_folder(const char *name)
{
    char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(mkdir(path, 0700), 0);
}

/* The colour of the material that the triangles of an OBJ file in the first root have. */
static daft_vec3 color_of(fixture *f, const char *name)
{
    daft_error error;
    daft_scene *scene = daft_scene_create(f->engine, NULL);
    const daft_mesh mesh = daft_mesh_load(scene, name, &error);
    daft_material_def look;
    if (!mesh.id) fail_msg("%s", error.message);
    const uint32_t index = daft_mesh_find(scene, mesh, NULL)->materials[0];
    assert_true(daft_material_get(scene, (daft_material){index + 1}, &look, NULL));
    daft_scene_destroy(scene);
    return look.diffuse;
}

static void mtllib_is_beside_the_file_and_then_in_the_roots(void **state)
{
    fixture *f = *state;
    static const char *const TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    char text[200], paths[2][100];
    make_folder("game"), make_folder("game/meshes"), make_folder("shared"), make_folder("shared/paints");
    put_text("game/meshes/own.mtl", "newmtl m\nKd 1 0 0\n");
    put_text("shared/own.mtl", "newmtl m\nKd 0 1 0\n");
    put_text("shared/paints/other.mtl", "newmtl m\nKd 0 0 1\n");
    snprintf(text, sizeof text, "mtllib own.mtl\n%s", TRIANGLE), put_text("game/meshes/own.obj", text);
    snprintf(text, sizeof text, "mtllib paints/other.mtl\n%s", TRIANGLE), put_text("game/meshes/other.obj", text);
    snprintf(text, sizeof text, "mtllib none.mtl\n%s", TRIANGLE), put_text("game/meshes/none.obj", text);
    for (int i = 0; i < 2; i++) snprintf(paths[i], sizeof paths[i], "%s/%s", folder, i ? "shared" : "game");
    const daft_root roots[2] = {{.folder = paths[0]}, {.folder = paths[1]}};
    daft_files_def def = daft_default_files_def();
    def.roots = roots, def.root_count = 2;
    daft_files *files = daft_files_create(&def, NULL);
    assert_true(files && daft_engine_set_files(f->engine, files, NULL));
    assert_true(color_of(f, "meshes/own.obj").x == 1);
    assert_true(color_of(f, "meshes/other.obj").z == 1);
    assert_int_equal(f->warnings, 0);
    color_of(f, "meshes/none.obj");
    assert_true(f->warnings > 0);
    assert_true(daft_engine_set_files(f->engine, NULL, NULL));
    daft_files_destroy(files);
}

int main(void)
{
    if (!READS_BY_LIBRARY) return 77;
#define WITH_FOLDER(name) cmocka_unit_test_setup_teardown(name, open_folder, close_folder)
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(what_lies_beyond_edges_is_drawn),
        WITH_FOLDER(alpha_below_the_cutoff_is_a_hole),
        WITH_FOLDER(roughness_and_metal_come_from_one_image),
        WITH_FOLDER(emission_comes_from_its_image),
        WITH_FOLDER(occlusion_dims_ambient_light_alone),
        WITH_FOLDER(occlusion_of_mtl_files),
        WITH_FOLDER(occlusion_by_other_coordinates_is_told),
        WITH_FOLDER(slopes_of_mtl_files),
        WITH_FOLDER(slopes_of_gltf_files),
        WITH_FOLDER(colors_of_vertices_multiply_the_base_color),
        WITH_FOLDER(alpha_of_vertices_blends_and_masks),
        WITH_FOLDER(white_vertices_cost_nothing),
        WITH_FOLDER(colors_of_other_formats_are_srgb),
        WITH_FOLDER(alpha_of_obj_files),
        WITH_FOLDER(materials_fade_when_meshes_come),
        WITH_FOLDER(a_reflection_map_is_mirrored_as_a_sky),
        WITH_FOLDER(a_cube_is_mirrored_as_a_sky),
        WITH_FOLDER(mtllib_is_beside_the_file_and_then_in_the_roots),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
