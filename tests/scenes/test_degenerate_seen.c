/* Degenerate entities that are seen: they spoil nothing that stands before them, bad triangles leave the rest of their
 * mesh alone, and what is mirrored is lit as its mirror image. */
#include "degenerate.h"

/* ---- entities that are seen, and must not spoil what stands before them ---- */

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
        free(draw(s, DAFT_PRESET_DRAFT));
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
        pictures[with] = draw(s, DAFT_PRESET_HIGH);
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

/* ---- mirrored entities ---- */

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
        picture *p = draw(s, DAFT_PRESET_GAME);
        size_t middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
        assert_true(p->normal[middle].x < -0.999f);
        assert_true(p->pixels[4 * middle] > 150);
        free(p);
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_seen_spoils_nothing_before_it),
        cmocka_unit_test(bad_triangles_leave_their_mesh_alone),
        cmocka_unit_test(a_seam_of_slivers_is_closed),
        cmocka_unit_test(mirrored_things_are_lit_as_their_mirror_image),
        cmocka_unit_test(normals_face_the_viewer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
