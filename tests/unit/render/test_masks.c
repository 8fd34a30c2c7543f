/* Outlines of masks, drawn smooth: coverage of pixels against its closed form, near and far; leaves that get neither
 * thin nor fat with distance; the same bytes however they are drawn. */
#include "fixtures.h"

#include "daft.h"
#include "picture_stage.h"
#include "scene/scene.h"
#include "support_content.h"

#include <math.h>

enum { WIDTH = 160, HEIGHT = 128, TEXELS = 256, PIXELS = WIDTH * HEIGHT };

#define FIELD 1.0f /* radians across the picture */
#define SIDE  2.0  /* metres a side of the card */

static const daft_vec3 SKY = {0.1f, 0.3f, 0};

/* The camera looks along +X at the middle of what is put at x = 0; all light is ambient, and white. */
static stage stage_with(const daft_engine_def *def, double away)
{
    stage s = stage_open(def, WIDTH, HEIGHT);
    s.view.camera = daft_camera_look_at(daft_dv3(-away, 0, 0), daft_dv3(0, 0, 0), FIELD);
    daft_scene_set_ambient(s.scene, daft_v3(1, 1, 1));
    daft_scene_set_sky_color(s.scene, SKY);
    return s;
}

static stage stage_new(double away)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    return stage_with(&def, away);
}

/* Metres from the camera where a texel is as wide as so many pixels. */
static double distance_of(double pixels) { return SIDE / TEXELS / pixels * (WIDTH / 2) / tan((double)FIELD / 2); }

/* The red of a pixel as the part of it that the card covers. */
static double covered(const uint8_t *rgba, int x, int y)
{
    const double red = (double)daft_srgb_to_linear((float)rgba[4 * (y * WIDTH + x)] / 255), sky = (double)SKY.x;
    return (red - sky) / (1 - sky);
}

/* ---- cards ---- */

typedef double alpha_function(void *user, double x, double y); /* in texels from the upper left corner */

static daft_texture texture_of(const stage *s, const char *name, alpha_function *alpha, void *user)
{
    static uint8_t tga[18 + 4 * TEXELS * TEXELS];
    memset(tga, 255, sizeof tga), memset(tga, 0, 18);
    tga[2] = 2, tga[13] = tga[15] = TEXELS >> 8, tga[16] = 32, tga[17] = 0x28;
    for (int i = 0; i < TEXELS * TEXELS; i++) {
        const double a = alpha(user, i % TEXELS + 0.5, i / TEXELS + 0.5);
        tga[18 + 4 * i + 3] = (uint8_t)(255 * fmin(fmax(a, 0), 1) + 0.5);
    }
    const daft_texture texture = daft_texture_load(s->scene, write_test_file(name, tga, sizeof tga), NULL);
    assert_true(texture.id);
    return texture;
}

static daft_entity hang(const stage *s, daft_texture texture, float cutoff, daft_dvec3 where, daft_quat turn)
{
    const float h = (float)SIDE / 2;
    const daft_vec3 p[4] = {{0, -h, -h}, {0, -h, h}, {0, h, h}, {0, h, -h}};
    const daft_vec2 uv[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    daft_mesh_def mesh = daft_default_mesh_def();
    mesh.positions = p, mesh.uvs = uv, mesh.vertex_count = 4, mesh.indices = index, mesh.triangle_count = 2;
    daft_material_def look = daft_default_material_def();
    look.diffuse = look.ambient = daft_v3(1, 1, 1), look.specular = daft_v3(0, 0, 0);
    look.diffuse_map = texture, look.map_wrap = DAFT_WRAP_CLAMP;
    look.alpha_mode = DAFT_ALPHA_MASK, look.alpha_cutoff = cutoff;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.position = where, def.rotation = turn;
    def.mesh = daft_mesh_create(s->scene, &mesh, NULL), def.material = daft_material_create(s->scene, &look, NULL);
    const daft_entity entity = daft_entity_create(s->scene, &def, NULL);
    assert_true(entity.id);
    return entity;
}

static const daft_quat STRAIGHT = {0, 0, 0, 1};

/* ---- a straight outline ---- */

/* Alpha rises over `ramp` texels, by the distance from a line; it is 1/2 `off` texels from the middle. */
typedef struct outline {
    double x, y, off, ramp; /* x, y: unit, to where it is covered */
} outline;

static double signed_distance(const outline *o, double x, double y)
{
    return (x - TEXELS / 2.0) * o->x + (y - TEXELS / 2.0) * o->y - o->off;
}

static double ramp_alpha(void *user, double x, double y)
{
    const outline *o = user;
    return 0.5 + signed_distance(o, x, y) / o->ramp;
}

static double half_square(double a) { return a > 0 ? a * a / 2 : 0; }

/* The part of a unit square on the inner side of a line, whose distance from its middle is d. */
static double square_part(double nx, double ny, double d)
{
    const double a = fmax(fabs(nx), 1e-4), b = fmax(fabs(ny), 1e-4), sum = (a + b) / 2, apart = (a - b) / 2;
    return (half_square(d + sum) - half_square(d + apart) - half_square(d - apart) + half_square(d - sum)) / (a * b);
}

typedef struct errors {
    double most, sum, bias;
    int count;
} errors;

/* Of the pixels that the outline crosses; all others are whole or holes. */
static errors compare_outline(const uint8_t *rgba, const outline *o, float cutoff, double pixels)
{
    errors e = {0};
    const double there = ((double)cutoff - 0.5) * o->ramp, reach = TEXELS / 2.0 - 8;
    for (int i = 0; i < PIXELS; i++) {
        const double x = (i % WIDTH + 0.5 - WIDTH / 2.0) / pixels, y = (i / WIDTH + 0.5 - HEIGHT / 2.0) / pixels;
        if (fabs(x) > reach - 1 / pixels || fabs(y) > reach - 1 / pixels) continue;
        const double d = (signed_distance(o, x + TEXELS / 2.0, y + TEXELS / 2.0) - there) * pixels;
        const double part = square_part(o->x, o->y, d), error = covered(rgba, i % WIDTH, i / WIDTH) - part;
        const bool crossed = part > 1e-6 && part < 1 - 1e-6;
        e.most = fmax(e.most, fabs(error));
        if (!crossed && fabs(d) > 2) assert_true(fabs(error) < 0.01);
        if (fabs(d) < 2) e.bias += error;
        if (crossed) e.count++, e.sum += fabs(error);
    }
    return e;
}

static errors draw_outline(double pixels, double degrees, double ramp, float cutoff, bool smooth)
{
    static uint8_t rgba[4 * PIXELS];
    const double angle = degrees * 0.017453292519943295;
    outline o = {cos(angle), sin(angle), 0.37, ramp};
    stage s = stage_new(distance_of(pixels));
    if (!smooth) s.view.quality.edge_samples = 0;
    hang(&s, texture_of(&s, "outline.tga", ramp_alpha, &o), cutoff, daft_dv3(0, 0, 0), STRAIGHT);
    draw(&s, rgba);
    stage_free(&s);
    return compare_outline(rgba, &o, cutoff, pixels);
}

/* From a texel over 16 pixels to 6 texels in one: the outline is a pixel wide, and in its place. What is not smooth is
 * wrong by a fifth in each pixel. */
static void coverage_is_the_closed_form(void **unused)
{
    (void)unused;
    static const double PIXELS_A_TEXEL[] = {16, 8, 2, 1, 0.5, 1 / 6.0}, DEGREES[] = {0, 14, 45, 71, 200};
    for (size_t k = 0; k < DAFT_COUNT_OF(PIXELS_A_TEXEL); k++) {
        double sum = 0, hard_sum = 0, bias = 0, most = 0;
        int count = 0;
        for (size_t a = 0; a < DAFT_COUNT_OF(DEGREES); a++)
            for (int variant = 0; variant < 3; variant++) {
                const double ramp = variant ? 4 : 2;
                const float cutoff = variant == 2 ? 0.7f : 0.5f;
                const errors e = draw_outline(PIXELS_A_TEXEL[k], DEGREES[a], ramp, cutoff, true),
                             hard = draw_outline(PIXELS_A_TEXEL[k], DEGREES[a], ramp, cutoff, false);
                sum += e.sum, hard_sum += hard.sum, count += e.count, bias += fabs(e.bias), most = fmax(most, e.most);
            }
        print_message("%.3g pixels a texel: %d pixels, errors %.3f, %.3f at most, bias %.3f; all or none %.3f\n",
                      PIXELS_A_TEXEL[k], count, sum / count, most, bias / count, hard_sum / count);
        const bool far = PIXELS_A_TEXEL[k] < 0.5; /* means of texels, over more than a pixel */
        assert_true(count > 100 && most < (far ? 0.28 : 0.22) && bias / count < 0.03);
        assert_true(sum / count < (far ? 0.12 : 0.06) && hard_sum / count > 0.16);
    }
}

/* ---- leaves with distance ---- */

enum { PERIOD = 16 };

/* A disc of radius 5 in each square of PERIOD texels. */
static double dotted_alpha(void *user, double x, double y)
{
    (void)user;
    const double dx = fmod(x, PERIOD) - PERIOD / 2, dy = fmod(y, PERIOD) - PERIOD / 2;
    return 0.5 + (5 - sqrt(dx * dx + dy * dy)) / 2;
}

static double mean_covered(const uint8_t *rgba, int side)
{
    double sum = 0;
    for (int i = 0; i < side * side; i++)
        sum += covered(rgba, (WIDTH - side) / 2 + i % side, (HEIGHT - side) / 2 + i / side);
    return sum / (side * side);
}

/* Far away all dots lie in one pixel, and as much of it is seen through as of the card nearby. */
static void leaves_far_away_are_as_fat(void **unused)
{
    (void)unused;
    static uint8_t rgba[4 * PIXELS];
    static const double PIXELS_A_TEXEL[] = {4, 1, 0.25, 1.0 / 16};
    static const int SIDES[] = {128, 128, 48, 8};
    static const float CUTOFFS[] = {0.3f, 0.5f, 0.75f};
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 4; k++) {
            const double radius = 5 + 2 * (0.5 - (double)CUTOFFS[c]),
                         part = 3.141592653589793 * radius * radius / (PERIOD * PERIOD);
            stage s = stage_new(distance_of(PIXELS_A_TEXEL[k]));
            hang(&s, texture_of(&s, "dots.tga", dotted_alpha, NULL), CUTOFFS[c], daft_dv3(0, 0, 0), STRAIGHT);
            draw(&s, rgba);
            const double mean = mean_covered(rgba, SIDES[k]);
            print_message("cutoff %.2f, %.3g pixels a texel: %.3f for %.3f\n", (double)CUTOFFS[c], PIXELS_A_TEXEL[k],
                          mean, part);
            assert_true(fabs(mean - part) < 0.06);
            stage_free(&s);
        }
}

/* ---- more than one ---- */

/* What lies behind shows by what is left, in whatever order they were made: white over half of a pixel, twice. */
static void layers_cover_in_turn(void **unused)
{
    (void)unused;
    static uint8_t rgba[4 * PIXELS];
    outline o = {1, 0, 0, 2};
    for (int order = 0; order < 2; order++) {
        stage s = stage_new(distance_of(2));
        const daft_texture texture = texture_of(&s, "layers.tga", ramp_alpha, &o);
        for (int k = 0; k < 2; k++) /* so near to each other that the outlines are in one pixel */
            hang(&s, texture, 0.5f, daft_dv3(k == order ? 0 : 1e-3, 0, 1.0 / TEXELS / 2), STRAIGHT);
        draw(&s, rgba);
        for (int y = 2; y < HEIGHT / 2 - 2; y++) { /* below it another triangle begins */
            const double part = covered(rgba, WIDTH / 2, y);
            assert_true(fabs(part - 0.75) < 0.02);
            assert_true(covered(rgba, WIDTH / 2 - 2, y) < 0.01 && covered(rgba, WIDTH / 2 + 2, y) > 0.99);
        }
        stage_free(&s);
    }
}

/* Where nothing is antialiased a pixel is card or hole. */
static void all_or_none_without_antialiasing(void **unused)
{
    (void)unused;
    static uint8_t rgba[4 * PIXELS];
    outline o = {0.8, 0.6, 0.2, 2};
    stage s = stage_new(distance_of(2));
    s.view.quality = daft_preset_quality(DAFT_PRESET_DRAFT);
    hang(&s, texture_of(&s, "hard.tga", ramp_alpha, &o), 0.5f, daft_dv3(0, 0, 0), STRAIGHT);
    draw(&s, rgba);
    int whole = 0;
    for (int i = 0; i < PIXELS; i++) {
        const double part = covered(rgba, i % WIDTH, i / WIDTH);
        assert_true(fabs(part) < 0.01 || fabs(part - 1) < 0.01);
        whole += part > 0.5;
    }
    assert_true(whole > PIXELS / 4 && whole < 3 * PIXELS / 4);
    stage_free(&s);
}

/* ---- holes before shading ---- */

/* Spots of all sizes, down to a texel. */
static daft_texture spots(const stage *s, int width, int height)
{
    uint8_t *tga = calloc(1, 18 + 4 * (size_t)(width * height));
    float wave[6][3];
    for (int k = 0; k < 6; k++)
        wave[k][0] = random_float(-0.5f, 0.5f) / (float)(1 << k / 2), wave[k][1] = random_float(-0.5f, 0.5f),
        wave[k][2] = random_float(0, 6);
    tga[2] = 2, tga[12] = (uint8_t)width, tga[13] = (uint8_t)(width >> 8);
    tga[14] = (uint8_t)height, tga[15] = (uint8_t)(height >> 8), tga[16] = 32, tga[17] = 0x28;
    for (int i = 0; i < width * height; i++) {
        float a = 0.5f;
        for (int k = 0; k < 6; k++)
            a += 0.25f * cosf(wave[k][0] * (float)(i % width) + wave[k][1] * (float)(i / width) + wave[k][2]);
        tga[18 + 4 * i + 3] = (uint8_t)(255 * fminf(fmaxf(a, 0), 1));
    }
    const size_t size = 18 + 4 * (size_t)(width * height);
    const daft_texture texture = daft_texture_load(s->scene, write_test_file("spots.tga", tga, size), NULL);
    free(tga);
    assert_true(texture.id);
    return texture;
}

/* Cards near, far and edge-on; their textures held, repeated, mirrored, turned over and moved. */
static void hang_somewhere(const stage *s, int round)
{
    const float depth = round % 3 ? random_float(0.6f, 12) : random_float(12, 60);
    const daft_dvec3 where = {(double)depth - 4, (double)random_float(-0.2f, 0.2f) * (double)depth, 0};
    const daft_texture texture = spots(s, 1 + (int)(random_bits() % 300), 1 + (int)(random_bits() % 300));
    const daft_entity card = hang(s, texture, random_float(0.1f, 0.9f), where, random_rotation());
    daft_entity_def def;
    daft_material_def look;
    assert_true(daft_entity_get(s->scene, card, &def, NULL) && daft_material_get(s->scene, def.material, &look, NULL));
    look.map_wrap = (uint32_t)round % 3, look.opacity = round % 4 ? 1 : random_float(0.5f, 1);
    look.map_scale = (daft_vec2){random_float(-3, 3), random_float(-3, 3)};
    look.map_offset = (daft_vec2){random_float(-2, 2), random_float(-2, 2)};
    assert_true(daft_material_set(s->scene, def.material, &look, NULL));
}

/* Whether there are masks, which are told to leave the texture alone. */
static bool ask_cells_alone(const stage *s)
{
    bool some = false;
    for (uint32_t i = 0; i < s->scene->assets.mesh_slots.count; i++) {
        daft_mesh_item *item = s->scene->assets.meshes[i];
        for (daft_opacity_set *o = item ? item->opacity : NULL; o; o = o->next)
            if (o->masks) o->masks[0].cutoff = 0, some = true;
    }
    return some;
}

/* Layers are told apart before they are shaded, or after, by what `vary` reads: each pixel sees the same. */
static void holes_are_what_filters_drop(void **unused)
{
    (void)unused;
    static uint8_t passed[4 * PIXELS], shaded[4 * PIXELS];
    uint64_t before = 0, after = 0; /* paths */
    for (int round = 0; round < 60; round++) {
        uint64_t paths[2];
        bool some = false;
        for (int by_shading = 0; by_shading < 2; by_shading++) {
            stage s = stage_new(4);
            fixture_seed(150 + (uint64_t)round);
            s.view.quality.edge_samples = 0;
            hang_somewhere(&s, round);
            draw(&s, passed); /* makes the mask */
            if (by_shading) some = ask_cells_alone(&s);
            daft_scene_set_ambient(s.scene, daft_v3(0.5f, 1, 1));
            paths[by_shading] = draw(&s, by_shading ? shaded : passed)->refraction_rays;
            stage_free(&s);
        }
        if (memcmp(passed, shaded, sizeof passed) != 0) fail_msg("round %d", round);
        if (some) before += paths[0], after += paths[1];
    }
    print_message("paths: %llu, of %llu\n", (unsigned long long)before, (unsigned long long)after);
    assert_true(after > 10000 && before < after / 20);
}

/* ---- determinism ---- */

static void the_same_bytes_everywhere(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {NULL, "plain", "sse2", "avx2", "avx512"};
    static const int SAMPLES[] = {1, 1, 4};
    static uint8_t first[4 * PIXELS], now[4 * PIXELS];
    for (int quality = 0; quality < 3; quality++) {
        int compared = 0;
        for (int k = 0; k < 5; k++)
            for (int tree = 0; tree < 2; tree++) {
                daft_engine_def def = daft_default_engine_def();
                def.threads = 1 + k, def.isa = NAMES[k], def.accel = tree ? DAFT_ACCEL_KDTREE : DAFT_ACCEL_BVH;
                daft_engine *engine = daft_engine_create(&def, NULL);
                if (!engine) continue; /* this processor lacks it */
                daft_engine_destroy(engine);
                stage s = stage_with(&def, 4);
                fixture_seed(93);
                s.view.quality.samples = SAMPLES[quality], s.view.quality.edge_samples = quality == 1 ? 16 : 4;
                if (SAMPLES[quality] > 1) s.view.quality.edge_samples = 0;
                const daft_texture dots = texture_of(&s, "dots.tga", dotted_alpha, NULL);
                for (int i = 0; i < 12; i++) {
                    const daft_dvec3 where = {(double)random_float(-2, 20), (double)random_float(-1, 1),
                                              (double)random_float(-1, 1)};
                    hang(&s, dots, random_float(0.2f, 0.8f), where, random_rotation());
                }
                s.view.first_row = 0, s.view.row_count = tree ? 32 : 0;
                draw(&s, now); /* bands of 32 rows are the picture, too */
                for (int row = 32; tree && row < HEIGHT; row += 32) s.view.first_row = row, draw(&s, now);
                if (compared++) assert_memory_equal(first, now, sizeof now);
                memcpy(first, now, sizeof now);
                stage_free(&s);
            }
        assert_true(compared >= 4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coverage_is_the_closed_form), cmocka_unit_test(leaves_far_away_are_as_fat),
        cmocka_unit_test(layers_cover_in_turn),        cmocka_unit_test(all_or_none_without_antialiasing),
        cmocka_unit_test(holes_are_what_filters_drop), cmocka_unit_test(the_same_bytes_everywhere)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
