/* Shadows of surfaces with alpha: against the same shape cut as geometry, and against closed forms; classes and masks
 * change no byte. test_opacity_classes.c has what these say. */
#include "fixtures.h"

#include "daft.h"
#include "picture_stage.h"
#include "render/render.h"
#include "scene/scene.h"
#include "support_content.h"

#include <math.h>

enum { WIDTH = 160, HEIGHT = 120, TEXELS = 32, PIXELS = WIDTH * HEIGHT };

/* From above onto a white ground; what hangs over it, from y = 2 on, is not in the picture. */
static stage stage_with(const daft_engine_def *def)
{
    stage s = stage_open(def, WIDTH, HEIGHT);
    s.view.camera = daft_camera_look_at(daft_dv3(-3, 1.9, 0), daft_dv3(0, 0, 0), 1.2f);
    s.view.quality.edge_samples = 0;
    daft_material_def white = daft_default_material_def();
    white.diffuse = white.ambient = daft_v3(1, 1, 1), white.specular = daft_v3(0, 0, 0);
    daft_entity_def ground = daft_default_entity_def();
    ground.shape = DAFT_SHAPE_BOX, ground.size = daft_v3(12, 1, 12), ground.position = daft_dv3(0, -0.5, 0);
    ground.material = daft_material_create(s.scene, &white, NULL);
    assert_true(daft_entity_create(s.scene, &ground, NULL).id);
    daft_scene_set_ambient(s.scene, daft_v3(0.1f, 0.1f, 0.1f));
    return s;
}

static stage stage_new(void)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    return stage_with(&def);
}

/* ---- a leaf: a fat F of whole texels ---- */

static bool in_leaf(int x, int y) /* y from the top */
{
    return (x >= 6 && x < 13 && y >= 3 && y < 29) || (x >= 13 && x < 27 && y >= 3 && y < 10) ||
           (x >= 13 && x < 22 && y >= 14 && y < 20);
}

typedef enum leaf_texture { LEAF, WHITE, HALF } leaf_texture;

static daft_texture texture_of(const stage *s, leaf_texture kind, int salt)
{
    static uint8_t tga[18 + 4 * TEXELS * TEXELS];
    char name[32];
    memset(tga, 255, sizeof tga), memset(tga, 0, 18);
    tga[2] = 2, tga[12] = tga[14] = TEXELS, tga[16] = 32, tga[17] = 0x28;
    for (int i = 0; i < TEXELS * TEXELS; i++) {
        const int there = in_leaf(i % TEXELS, i / TEXELS);
        tga[18 + 4 * i + 3] = kind == WHITE ? 255 : kind == HALF ? (there ? 128 : 64) : there ? 255 : 0;
    }
    snprintf(name, sizeof name, "leaf%d_%d.tga", (int)kind, salt);
    const daft_texture texture = daft_texture_load(s->scene, write_test_file(name, tga, sizeof tga), NULL);
    assert_true(texture.id);
    return texture;
}

/* The part of a square from (-1, -1) to (1, 1) in its plane, in texels of the picture on it. */
static daft_mesh square(const stage *s, const int (*parts)[4], uint32_t count)
{
    daft_vec3 p[12];
    daft_vec2 uv[12];
    uint32_t index[18];
    for (uint32_t k = 0; k < count; k++)
        for (uint32_t i = 0; i < 4; i++) {
            const float u = (float)parts[k][i == 1 || i == 2 ? 2 : 0] / TEXELS,
                        v = 1 - (float)parts[k][i > 1 ? 1 : 3] / TEXELS;
            p[4 * k + i] = daft_v3(2 * v - 1, 0, 2 * u - 1), uv[4 * k + i] = (daft_vec2){u, v};
        }
    for (uint32_t k = 0; k < 6 * count; k++) index[k] = 4 * (k / 6) + (const uint32_t[]){0, 1, 2, 0, 2, 3}[k % 6];
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.uvs = uv, def.vertex_count = 4 * count, def.indices = index, def.triangle_count = 2 * count;
    const daft_mesh mesh = daft_mesh_create(s->scene, &def, NULL);
    assert_true(mesh.id);
    return mesh;
}

static const int WHOLE[1][4] = {{0, 0, TEXELS, TEXELS}};
static const int CUT[3][4] = {{6, 3, 13, 29}, {13, 3, 27, 10}, {13, 14, 22, 20}};

static void hang(const stage *s, daft_mesh mesh, const daft_material_def *look, double height)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.position = daft_dv3(0.25, height, 0.1);
    def.material = daft_material_create(s->scene, look, NULL);
    assert_true(def.material.id && daft_entity_create(s->scene, &def, NULL).id);
}

static void shine(const stage *s, daft_light_kind kind)
{
    daft_light_def def = daft_default_light_def();
    def.kind = kind, def.position = daft_dv3(0.6, 6, 0.4), def.direction = daft_v3(-0.05f, -1, -0.1f);
    if (kind == DAFT_LIGHT_SPOT) def.direction = daft_v3(-0.1f, -1, 0);
    if (kind == DAFT_LIGHT_RECTANGLE) def.color = daft_v3(20, 20, 20);
    assert_true(daft_light_create(s->scene, &def, NULL).id);
}

/* Where on the card the shadow ray of a pixel passes, in texels. False: the pixel shows no ground. */
static bool place_on_card(const stage *s, daft_light_kind kind, int pixel, double *x, double *y)
{
    daft_dvec3 at, way;
    const daft_camera *camera = &s->view.camera;
    const double right = (pixel % WIDTH + 0.5 - WIDTH / 2.0) / (WIDTH / 2.0) * tan((double)camera->fov / 2),
                 up = (HEIGHT / 2.0 - pixel / WIDTH - 0.5) / (WIDTH / 2.0) * tan((double)camera->fov / 2);
    const double pitch = (double)camera->pitch; /* it looks along +X, and down */
    way = daft_dv3(cos(pitch) + up * sin(pitch), -sin(pitch) + up * cos(pitch), right);
    if (!(way.y < 0)) return false;
    at = daft_dadd(daft_dv3(-3, 1.9, 0), daft_dscale(way, 1.9 / -way.y));
    if (fabs(at.x) > 5.9 || fabs(at.z) > 5.9) return false;
    const daft_dvec3 to = kind == DAFT_LIGHT_SUN ? daft_dv3(0.05, 1, 0.1) : daft_dsub(daft_dv3(0.6, 6, 0.4), at);
    at = daft_dadd(at, daft_dscale(to, 2 / to.y));
    *x = (at.z - 0.1 + 1) / 2 * TEXELS, *y = (1 - (at.x - 0.25 + 1) / 2) * TEXELS;
    return true;
}

/* Whether the leaf is the same all over a texel around the place. */
static bool far_from_outline(double x, double y)
{
    const bool here = in_leaf((int)floor(x), (int)floor(y));
    for (int k = 0; k < 9; k++)
        if (in_leaf((int)floor(x + k % 3 - 1), (int)floor(y + k / 3 - 1)) != here) return false;
    return true;
}

static void leaves_shade_as_cut_geometry(void **unused)
{
    (void)unused;
    static uint8_t masked[4 * PIXELS], cut[4 * PIXELS];
    static const daft_light_kind KINDS[] = {DAFT_LIGHT_SUN, DAFT_LIGHT_POINT, DAFT_LIGHT_SPOT, DAFT_LIGHT_RECTANGLE};
    for (size_t k = 0; k < DAFT_COUNT_OF(KINDS); k++) {
        int dark = 0, differ = 0;
        for (int shape = 0; shape < 2; shape++) {
            stage s = stage_new();
            daft_material_def look = daft_default_material_def();
            if (!shape)
                look.diffuse_map = texture_of(&s, LEAF, 0), look.alpha_mode = DAFT_ALPHA_MASK,
                look.map_wrap = DAFT_WRAP_CLAMP;
            hang(&s, shape ? square(&s, CUT, 3) : square(&s, WHOLE, 1), &look, 2);
            shine(&s, KINDS[k]);
            s.view.quality.shadow_samples = 0;
            const daft_counters *c = draw(&s, shape ? cut : masked);
            assert_true(shape ? c->alpha_rays == 0 && c->alpha_reads == 0
                              : c->alpha_rays > 500 && c->alpha_reads > 500);
            for (int i = 0; shape && i < PIXELS; i++) {
                double x, y;
                const bool differs = memcmp(&masked[4 * i], &cut[4 * i], 4) != 0;
                if (!place_on_card(&s, KINDS[k], i, &x, &y)) continue;
                dark += cut[4 * i] < 128;
                differ += differs;
                if (differs && far_from_outline(x, y)) fail_msg("light %d, pixel %d at texel %g, %g", (int)k, i, x, y);
                if (KINDS[k] >= DAFT_LIGHT_SPOT) continue; /* it is dark elsewhere, too */
                if (far_from_outline(x, y)) assert_true((cut[4 * i] < 128) == in_leaf((int)floor(x), (int)floor(y)));
            }
            stage_free(&s);
        }
        print_message("light %d: %d pixels in shadow, %d at the outline differ\n", (int)k, dark, differ);
        assert_true(dark > 500 && differ < dark / 10);
    }
}

/* With all texels opaque a mask casts the shadow of no mask, and nobody looks at its alpha. */
static void a_mask_without_holes_is_none(void **unused)
{
    (void)unused;
    static uint8_t all[4][4 * PIXELS];
    for (int k = 0; k < 4; k++) {
        stage s = stage_new();
        daft_material_def look = daft_default_material_def();
        look.diffuse_map = texture_of(&s, WHITE, 0);
        look.alpha_mode = k == 1   ? DAFT_ALPHA_MASK
                          : k == 2 ? DAFT_ALPHA_BLEND
                          : k == 3 ? DAFT_ALPHA_MASK
                                   : DAFT_ALPHA_OPAQUE;
        if (k == 3) look.alpha_map = texture_of(&s, WHITE, 1); /* whose green it is */
        hang(&s, square(&s, WHOLE, 1), &look, 2);
        hang(&s, square(&s, CUT, 3), &look, 0.3);
        shine(&s, DAFT_LIGHT_POINT);
        const daft_counters *c = draw(&s, all[k]);
        assert_true(c->alpha_rays == 0 && c->alpha_reads == 0 && c->shadow_rays > 1000);
        assert_memory_equal(all[k], all[0], sizeof all[0]);
        stage_free(&s);
    }
}

static float linear_at(const uint8_t *rgba, int x, int y, int channel)
{
    return daft_srgb_to_linear((float)rgba[4 * (y * WIDTH + x) + channel] / 255);
}

/* Light through two layers, of which each covers a part and lets some colour through what it covers: once for each. */
static void layers_let_light_through(void **unused)
{
    (void)unused;
    static uint8_t open[4 * PIXELS], covered[4 * PIXELS];
    for (int soft = 0; soft < 2; soft++) {
        for (int k = 0; k < 2; k++) {
            stage s = stage_new();
            daft_material_def look = daft_default_material_def();
            look.alpha_mode = DAFT_ALPHA_BLEND, look.opacity = 0.25f;
            if (!soft)
                look.transmission = 0.5f, look.transmission_tint = daft_v3(1, 0.5f, 0), look.refractive_index = 1;
            if (k) hang(&s, square(&s, WHOLE, 1), &look, 2), hang(&s, square(&s, WHOLE, 1), &look, 2.2);
            daft_light_def sun = daft_default_light_def();
            sun.kind = DAFT_LIGHT_SUN, sun.direction = daft_v3(0.01f, -1, 0.02f), sun.color = daft_v3(0.8f, 0.8f, 0.8f);
            sun.radius = soft ? 0.02f : 0;
            assert_true(daft_light_create(s.scene, &sun, NULL).id);
            const daft_counters *c = draw(&s, k ? covered : open);
            assert_true(k ? c->alpha_rays > 0 && c->alpha_reads == 0 : c->alpha_rays == 0);
            stage_free(&s);
        }
        for (int channel = 0; channel < 3; channel++) {
            const float passes = soft ? 0.75f : 0.75f + 0.25f * 0.5f * (1 - 0.5f * (float)channel);
            const int x = WIDTH / 2, y = HEIGHT / 2;
            const float lit = linear_at(open, x, y, channel) - 0.1f, left = linear_at(covered, x, y, channel) - 0.1f;
            assert_true(lit > 0.5f && fabsf(left - lit * passes * passes) < 0.01f);
        }
    }
}

/* The whole card, with alphas at its corners in place of the picture's. */
static daft_mesh fading_card(const stage *s, const float alphas[4])
{
    static const daft_vec3 p[4] = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
    static const daft_vec2 uv[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.uvs = uv, def.alphas = alphas, def.vertex_count = 4;
    def.indices = index, def.triangle_count = 2;
    const daft_mesh mesh = daft_mesh_create(s->scene, &def, NULL);
    assert_true(mesh.id);
    return mesh;
}

/* A picture whose alpha grows from 0 at its left edge to 1 at its right one. */
static daft_texture ramp(const stage *s)
{
    enum { STEPS = 256 };
    static uint8_t tga[18 + 4 * STEPS];
    memset(tga, 255, sizeof tga), memset(tga, 0, 18);
    tga[2] = 2, tga[13] = 1, tga[14] = 1, tga[16] = 32, tga[17] = 0x28;
    for (int i = 0; i < STEPS; i++) tga[18 + 4 * i + 3] = (uint8_t)i;
    const daft_texture texture = daft_texture_load(s->scene, write_test_file("ramp.tga", tga, sizeof tga), NULL);
    assert_true(texture.id);
    return texture;
}

/* What fades by its vertices casts the shadow of what fades by a picture; all vertices alike, that of a material of
 * this opacity, byte for byte. Nothing and all of it are told by classes: no ray reads alpha. */
static void vertices_fade_as_pictures_do(void **unused)
{
    (void)unused;
    static uint8_t own[4 * PIXELS], other[4 * PIXELS], none[4 * PIXELS];
    static const float ALPHAS[][4] = {{0, 1, 1, 0}, {0.25f, 0.25f, 0.25f, 0.25f}, {1, 1, 1, 1}, {0, 0, 0, 0}};
    for (uint32_t mode = DAFT_ALPHA_OPAQUE; mode <= DAFT_ALPHA_BLEND; mode++)
        for (int k = 0; k < 4; k++) {
            uint64_t rays = 0;
            int worst = 0, shaded = 0;
            for (int by = 0; by < 3; by++) { /* the vertices; the material; without the card */
                stage s = stage_new();
                daft_material_def look = daft_default_material_def();
                look.alpha_mode = mode;
                if (by == 1 && k == 0) look.diffuse_map = ramp(&s), look.map_wrap = DAFT_WRAP_CLAMP;
                if (by == 1 && k > 0 && mode != DAFT_ALPHA_OPAQUE) look.opacity = ALPHAS[k][0];
                if (by < 2) hang(&s, fading_card(&s, by ? NULL : ALPHAS[k]), &look, 2);
                shine(&s, DAFT_LIGHT_SUN);
                const daft_counters *c = draw(&s, by == 0 ? own : by == 1 ? other : none);
                if (by == 0) rays = c->alpha_rays;
                stage_free(&s);
            }
            for (int i = 0; i < 4 * PIXELS; i++) {
                worst = daft_max_i(worst, abs(own[i] - other[i]));
                shaded += i % 4 == 0 && own[i] + 4 < none[i];
            }
            if (k) assert_int_equal(worst, 0);
            if (mode == DAFT_ALPHA_MASK && k == 0) { /* but for one column of texels along the cut */
                int wrong = 0;
                for (int i = 0; i < PIXELS; i++) wrong += own[4 * i] != other[4 * i];
                assert_true(wrong < PIXELS / 200);
            } else {
                assert_true(worst <= 2);
            }
            const bool whole = mode == DAFT_ALPHA_OPAQUE || k == 2,
                       gone = !whole && (k == 3 || (mode == DAFT_ALPHA_MASK && k == 1));
            assert_true(gone ? shaded == 0 : shaded > PIXELS / 20);
            assert_int_equal(rays > 0, !whole && !gone);
        }
}

/* ---- determinism ---- */

/* Leaves at random among other things, under a sharp sun and a soft lamp, with ambient occlusion. */
static void fill(stage *s)
{
    const daft_mesh mesh = square(s, WHOLE, 1), rest = square(s, CUT, 3);
    const daft_texture leaf = texture_of(s, LEAF, 0), half = texture_of(s, HALF, 0);
    for (int i = 0; i < 30; i++) {
        daft_material_def look = daft_default_material_def();
        look.diffuse = look.ambient = random_vec3(0.2f, 1);
        look.diffuse_map = i % 3 ? leaf : half, look.alpha_mode = i % 3 ? DAFT_ALPHA_MASK : DAFT_ALPHA_BLEND;
        daft_entity_def def = daft_default_entity_def();
        def.shape = i % 7 == 6 ? DAFT_SHAPE_SPHERE : DAFT_SHAPE_MESH, def.radius = 0.5f, def.mesh = i % 5 ? mesh : rest;
        def.position =
            daft_dv3((double)random_float(-2, 2), (double)random_float(0.2f, 3), (double)random_float(-2, 2));
        def.rotation = random_rotation(), def.scale = daft_v3(0.6f, 0.6f, 0.6f);
        def.material = daft_material_create(s->scene, &look, NULL);
        assert_true(daft_entity_create(s->scene, &def, NULL).id);
    }
    shine(s, DAFT_LIGHT_SUN);
    daft_light_def lamp = daft_default_light_def();
    lamp.kind = DAFT_LIGHT_POINT, lamp.position = daft_dv3(-2, 4, 3), lamp.radius = 0.3f;
    assert_true(daft_light_create(s->scene, &lamp, NULL).id);
    daft_scene_set_ambient_occlusion(s->scene, 1);
}

/* Each surface of the pane covers half, and of that half of the light passes: 3/4 come through it, 9/16 through both.
 * Each sends on two rays, more of them than a batch has points. */
static void what_blends_may_transmit(void **unused)
{
    (void)unused;
    static uint8_t picture[4 * PIXELS];
    stage s = stage_new();
    daft_material_def m = daft_default_material_def();
    m.diffuse = m.ambient = m.specular = daft_v3(0, 0, 0);
    m.alpha_mode = DAFT_ALPHA_BLEND, m.opacity = 0.5f;
    m.transmission = 1, m.transmission_tint = daft_v3(0.5f, 0.5f, 0.5f), m.refractive_index = 1;
    daft_entity_def pane = daft_default_entity_def();
    pane.shape = DAFT_SHAPE_BOX, pane.size = daft_v3(0.02f, 4, 4), pane.position = daft_dv3(-2.5, 2.05, 0);
    pane.material = daft_material_create(s.scene, &m, NULL);
    assert_true(daft_entity_create(s.scene, &pane, NULL).id);
    daft_scene_set_ambient(s.scene, daft_v3(1, 1, 1));
    const daft_counters *c = draw(&s, picture);
    assert_true(c->refraction_rays > 3 * PIXELS);
    for (int x = 0; x < WIDTH; x++) {
        const int byte = picture[4 * ((HEIGHT - 20) * WIDTH + x)];
        if (abs(byte - 198) > 1) fail_msg("column %d: %d", x, byte);
    }
    stage_free(&s);
}

static void the_same_bytes_everywhere(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {NULL, "plain", "sse2", "avx2", "avx512"};
    static uint8_t first[4 * PIXELS], now[4 * PIXELS];
    int compared = 0;
    for (int k = 0; k < 5; k++)
        for (int way = 0; way < 3; way++) { /* sets of triangles decide the same, however they are looked up */
            daft_engine_def def = daft_default_engine_def();
            def.threads = 1 + k, def.isa = NAMES[k], def.accel = way == 1 ? DAFT_ACCEL_KDTREE : DAFT_ACCEL_BVH;
            daft_engine *engine = daft_engine_create(&def, NULL);
            if (!engine) continue; /* this processor lacks it */
            daft_engine_destroy(engine);
            stage s = stage_with(&def);
            fixture_seed(91);
            fill(&s);
            const daft_counters *c = draw(&s, now);
            assert_true(c->alpha_rays > 1000 && c->alpha_reads > 1000);
            if (compared++) assert_memory_equal(first, now, sizeof now);
            memcpy(first, now, sizeof now);
            stage_free(&s);
        }
    assert_true(compared >= 6);
}

/* All cells are mixed, and nobody reads the texture to find holes. */
static void forget_masks(daft_opacity_set *set)
{
    for (uint32_t i = 0; i < set->slots; i++) {
        daft_mask *m = &set->masks[i];
        m->cutoff = 0;
        const size_t words = ((size_t)m->columns * (size_t)m->rows + DAFT_MASK_CELLS - 1) / DAFT_MASK_CELLS;
        if (m->cells) memset((void *)(uintptr_t)m->cells, 0, words * sizeof *m->cells);
    }
}

/* The leaf again, eight times as fine. */
static daft_texture fine_leaf(const stage *s)
{
    enum { FINE = 8 * TEXELS };
    static uint8_t tga[18 + 4 * FINE * FINE];
    memset(tga, 255, sizeof tga), memset(tga, 0, 18);
    tga[2] = 2, tga[13] = tga[15] = FINE / 256, tga[16] = 32, tga[17] = 0x28;
    for (int i = 0; i < FINE * FINE; i++) tga[18 + 4 * i + 3] = in_leaf(i % FINE / 8, i / FINE / 8) ? 255 : 0;
    const daft_texture texture = daft_texture_load(s->scene, write_test_file("fine.tga", tga, sizeof tga), NULL);
    assert_true(texture.id);
    return texture;
}

/* A wood of cards with leaves, some under others. */
static void plant(const stage *s)
{
    const daft_texture leaf = fine_leaf(s);
    const daft_mesh mesh = square(s, WHOLE, 1);
    for (int i = 0; i < 60; i++) {
        daft_material_def look = daft_default_material_def();
        look.diffuse = look.ambient = random_vec3(0.2f, 1);
        look.diffuse_map = leaf, look.alpha_mode = DAFT_ALPHA_MASK, look.map_wrap = DAFT_WRAP_CLAMP;
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.rotation = random_rotation();
        def.position =
            daft_dv3((double)random_float(-1.5f, 2), (double)random_float(0.2f, 2), (double)random_float(-2, 2));
        def.scale = daft_v3(0.7f, 0.7f, 0.7f), def.material = daft_material_create(s->scene, &look, NULL);
        assert_true(daft_entity_create(s->scene, &def, NULL).id);
    }
}

/* What masks know of shadows spares rays, and changes no byte; what they know of holes before the camera spares paths,
 * and pixels see the same: but for those where an edge lies that a path of several rays meets a rounding beside. */
static void masks_spare_rays_alone(void **unused)
{
    (void)unused;
    static uint8_t with[4 * PIXELS], without[4 * PIXELS];
    static const daft_light_kind KINDS[] = {DAFT_LIGHT_SUN, DAFT_LIGHT_POINT, DAFT_LIGHT_SPOT};
    for (int k = 0; k < 6; k++) {
        const bool anisotropic = k >= 3; /* no hole is passed over: shadows are all that is spared */
        uint64_t reads[2], paths[2];
        int differ = 0;
        for (int known = 0; known < 2; known++) {
            stage s = stage_new();
            fixture_seed(97 + (uint64_t)k);
            plant(&s);
            shine(&s, KINDS[k % 3]);
            if (anisotropic) s.view.quality.texture_filter = DAFT_TEXTURE_ANISOTROPIC4;
            draw(&s, with); /* makes the masks */
            for (uint32_t i = 0; i < s.scene->assets.mesh_slots.count; i++)
                for (daft_opacity_set *o = s.scene->assets.meshes[i] ? s.scene->assets.meshes[i]->opacity : NULL; o;
                     o = o->next)
                    if (!known) forget_masks(o);
            daft_scene_set_ambient(s.scene, daft_v3(0.2f, 0.2f, 0.2f));
            const daft_counters *c = draw(&s, known ? with : without);
            reads[known] = c->alpha_reads, paths[known] = c->refraction_rays;
            stage_free(&s);
        }
        for (int i = 0; i < PIXELS; i++)
            for (int c = 0; c < 3; c++)
                if (abs(with[4 * i + c] - without[4 * i + c]) > 1) {
                    differ++;
                    break;
                }
        print_message("light %d: reads %llu, %llu; paths %llu, %llu; %d pixels differ\n", k,
                      (unsigned long long)reads[0], (unsigned long long)reads[1], (unsigned long long)paths[0],
                      (unsigned long long)paths[1], differ);
        assert_true(reads[1] > 0 && reads[1] < reads[0] / 2);
        if (anisotropic) {
            assert_memory_equal(with, without, sizeof with);
        } else {
            assert_true(paths[1] < paths[0] * 3 / 4 && differ <= PIXELS / 1000);
        }
    }
}

/* Holes too: by windows, thin and small triangles, and rays one by one. */
static void holes_are_the_same_everywhere(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {NULL, "plain", "sse2", "avx2", "avx512"};
    static uint8_t first[4 * PIXELS], now[4 * PIXELS];
    for (uint64_t seed = 100; seed < 106; seed++) {
        int compared = 0;
        for (int k = 0; k < 10; k++) {
            daft_engine_def def = daft_default_engine_def();
            def.threads = 1 + k % 3, def.isa = NAMES[k / 2], def.accel = k % 2 ? DAFT_ACCEL_KDTREE : DAFT_ACCEL_BVH;
            daft_engine *engine = daft_engine_create(&def, NULL);
            if (!engine) continue; /* this processor lacks it */
            daft_engine_destroy(engine);
            stage s = stage_with(&def);
            fixture_seed(seed);
            plant(&s);
            shine(&s, DAFT_LIGHT_SUN);
            s.view.quality.edge_samples = seed % 2 ? 4 : 0;
            draw(&s, now);
            if (compared++) assert_memory_equal(first, now, sizeof now);
            memcpy(first, now, sizeof now);
            stage_free(&s);
        }
        assert_true(compared >= 4);
    }
}

/* What a triangle's class says is what the texture says: without classes the picture is the same. */
static void classes_spare_reads_alone(void **unused)
{
    (void)unused;
    static uint8_t with[4 * PIXELS], without[4 * PIXELS];
    enum { SIDE = 16 };
    uint64_t reads[2];
    for (int k = 0; k < 2; k++) {
        stage s = stage_new();
        daft_vec3 p[SIDE * SIDE];
        daft_vec2 uv[SIDE * SIDE];
        uint32_t index[6 * SIDE * SIDE], n = 0;
        for (uint32_t i = 0; i < SIDE * SIDE; i++) {
            const float u = (float)(i % SIDE) / (SIDE - 1), v = (float)(i / SIDE) / (SIDE - 1);
            p[i] = daft_v3(2 * v - 1, 0, 2 * u - 1), uv[i] = (daft_vec2){u, v};
            if (i % SIDE == SIDE - 1 || i / SIDE == SIDE - 1) continue;
            for (int c = 0; c < 6; c++) index[n++] = i + (const uint32_t[]){0, 1, SIDE + 1, 0, SIDE + 1, SIDE}[c];
        }
        daft_mesh_def def = daft_default_mesh_def();
        def.positions = p, def.uvs = uv, def.vertex_count = SIDE * SIDE, def.indices = index,
        def.triangle_count = n / 3;
        const daft_mesh mesh = daft_mesh_create(s.scene, &def, NULL);
        daft_material_def look = daft_default_material_def();
        look.diffuse_map = texture_of(&s, LEAF, 0), look.alpha_mode = DAFT_ALPHA_MASK, look.map_wrap = DAFT_WRAP_CLAMP;
        hang(&s, mesh, &look, 2);
        shine(&s, DAFT_LIGHT_POINT);
        draw(&s, with); /* makes the classes */
        daft_opacity_set *set = s.scene->assets.meshes[daft_asset_index(mesh.id)]->opacity;
        assert_true(set && !set->next && set->flags == DAFT_INSTANCE_FILTERS_SHADOW);
        if (k) memset(set->classes, DAFT_OPACITY_MIXED, n / 3), forget_masks(set);
        reads[k] = draw(&s, k ? without : with)->alpha_reads;
        stage_free(&s);
    }
    print_message("texture reads: %llu with classes, %llu without\n", (unsigned long long)reads[0],
                  (unsigned long long)reads[1]);
    assert_memory_equal(with, without, sizeof with);
    assert_true(reads[0] > 0 && reads[0] < reads[1] / 2);
}

/* Another texture, another cutoff, another scale: other classes, and old ones go. */
static void classes_follow_materials(void **unused)
{
    (void)unused;
    static const int STEM[1][4] = {{8, 6, 11, 18}}; /* all of it in the leaf, until the texture is moved */
    static uint8_t now[4 * PIXELS], fresh[4 * PIXELS];
    stage s = stage_new();
    daft_material_def look = daft_default_material_def();
    look.diffuse_map = texture_of(&s, HALF, 0), look.alpha_mode = DAFT_ALPHA_MASK;
    const daft_mesh mesh = square(&s, STEM, 1);
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.position = daft_dv3(0.25, 2, 0.1);
    def.material = daft_material_create(s.scene, &look, NULL);
    assert_true(daft_entity_create(s.scene, &def, NULL).id);
    shine(&s, DAFT_LIGHT_SUN);
    for (int i = 0; i < 40; i++) {
        look.map_offset = (daft_vec2){(float)(i / 6) / 10, 0},
        look.alpha_cutoff = 0.1f + 0.3f * (float)(i % 3); /* opaque, mixed, clear */
        look.alpha_mode = i % 13 == 12 ? DAFT_ALPHA_BLEND : DAFT_ALPHA_MASK;
        assert_true(daft_material_set(s.scene, def.material, &look, NULL));
        draw(&s, now);
        stage other = stage_new();
        daft_material_def same = look;
        same.diffuse_map = texture_of(&other, HALF, 0);
        hang(&other, square(&other, STEM, 1), &same, 2);
        shine(&other, DAFT_LIGHT_SUN);
        draw(&other, fresh);
        stage_free(&other);
        assert_memory_equal(now, fresh, sizeof now);
        int sets = 0;
        for (const daft_opacity_set *o = s.scene->assets.meshes[daft_asset_index(mesh.id)]->opacity; o; o = o->next)
            sets++;
        assert_true(sets >= 1 && sets <= 9);
    }
    /* the texture goes, and with it what was made of it */
    const daft_texture texture = look.diffuse_map;
    daft_mesh_info before, after;
    assert_true(daft_mesh_get_info(s.scene, mesh, &before, NULL));
    look.diffuse_map = (daft_texture){0};
    assert_true(daft_material_set(s.scene, def.material, &look, NULL) && daft_texture_release(s.scene, texture, NULL));
    assert_int_equal(daft_scene_collect(s.scene), 1);
    assert_true(daft_mesh_get_info(s.scene, mesh, &after, NULL));
    assert_null(s.scene->assets.meshes[daft_asset_index(mesh.id)]->opacity);
    assert_true(after.bytes < before.bytes);
    draw(&s, now);
    stage_free(&s);
}

/* A leaf that moves, or whose cutoff does, changes its shadow in a kept picture as in a full one. */
static void kept_pictures_follow_leaves(void **unused)
{
    (void)unused;
    static uint8_t full[4 * PIXELS], kept[4 * PIXELS];
    fixture_seed(94);
    stage s = stage_new();
    daft_material_def look = daft_default_material_def();
    look.diffuse_map = texture_of(&s, LEAF, 0), look.alpha_mode = DAFT_ALPHA_MASK;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = square(&s, WHOLE, 1), def.position = daft_dv3(0.25, 2, 0.1);
    def.material = daft_material_create(s.scene, &look, NULL), def.scale = daft_v3(0.3f, 1, 0.3f);
    const daft_entity leaf = daft_entity_create(s.scene, &def, NULL);
    shine(&s, DAFT_LIGHT_SUN);
    daft_history *history = daft_history_create(s.engine, NULL);
    int partly = 0;
    for (int i = 0; i < 40; i++) {
        const daft_transform place = {.position = daft_dv3((double)random_float(-1, 1), 2, (double)random_float(-1, 1)),
                                      .rotation = daft_quat_identity(),
                                      .scale = def.scale};
        if (i % 3) assert_true(daft_entity_set_transform(s.scene, leaf, &place, true, NULL));
        if (i % 4 == 3) look.alpha_cutoff = random_float(0.05f, 0.95f);
        assert_true(daft_material_set(s.scene, def.material, &look, NULL));
        s.view.history = history;
        const uint64_t tiles = draw(&s, kept)->tiles_drawn;
        s.view.history = NULL;
        partly += tiles < draw(&s, full)->tiles_drawn;
        assert_memory_equal(kept, full, sizeof full);
    }
    assert_true(partly > 20);
    daft_history_destroy(history);
    stage_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(leaves_shade_as_cut_geometry),  cmocka_unit_test(a_mask_without_holes_is_none),
        cmocka_unit_test(layers_let_light_through),      cmocka_unit_test(vertices_fade_as_pictures_do),
        cmocka_unit_test(what_blends_may_transmit),      cmocka_unit_test(the_same_bytes_everywhere),
        cmocka_unit_test(classes_spare_reads_alone),     cmocka_unit_test(masks_spare_rays_alone),
        cmocka_unit_test(holes_are_the_same_everywhere), cmocka_unit_test(classes_follow_materials),
        cmocka_unit_test(kept_pictures_follow_leaves),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
