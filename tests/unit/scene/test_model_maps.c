/* Maps of model files as they are drawn: what lies beyond a texture's edges, holes where alpha is below glTF's cutoff,
 * roughness, metal, emission and occlusion from images, and materials of OBJ files from the asset roots. Each picture
 * is compared with what is drawn without a map, or with the texel that a formula names. */
#include "model_fixture.h"

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
        WITH_FOLDER(a_reflection_map_is_mirrored_as_a_sky),
        WITH_FOLDER(a_cube_is_mirrored_as_a_sky),
        WITH_FOLDER(mtllib_is_beside_the_file_and_then_in_the_roots),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
