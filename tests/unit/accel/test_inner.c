/* Balls inside meshes, whatever the mesh: none comes near a triangle, and no ray leaves one without crossing a triangle or a
 * cap's box, by brute force and exact predicates; shadows are, bit for bit, those without them and without free ways (accel/open.h). */
#include "fixtures.h"
#include "mesh_points.h"
#include "meter.h"

#include "accel/inner.h"
#include "accel/open.h"
#include "geometry/trimesh.h"
#include "math/exact.h"
#include "render/internal.h"

/* ---- shapes ---- */

typedef struct sheet {
    daft_vec3 *positions;
    uint32_t *indices;
    uint32_t vertices, triangles;
} sheet;

static sheet sheet_make(uint32_t vertices, uint32_t triangles)
{
    return (sheet){malloc(vertices * sizeof(daft_vec3)), malloc(3 * (size_t)triangles * sizeof(uint32_t)), 0, 0};
}

static fixture_mesh sheet_finish(sheet *s)
{
    fixture_mesh out = mesh_make(s->positions, s->vertices, s->indices, s->triangles);
    free(s->positions), free(s->indices);
    return out;
}

/* Appends a mesh, moved, scaled, and turned inside out. */
static void sheet_add(sheet *s, const fixture_mesh *from, float scale, daft_vec3 by, bool inside_out)
{
    const daft_trimesh *mesh = &from->mesh;
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++)
        s->indices[3 * s->triangles + i] = s->vertices + mesh->indices[inside_out ? i / 3 * 3 + 2 - i % 3 : i];
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        s->positions[s->vertices++] = daft_add(daft_scale(daft_trimesh_position(mesh, i), scale), by);
    s->triangles += mesh->triangle_count;
}

/* Takes away the triangles whose first corner is within the radius of a place. */
static void sheet_cut(sheet *s, daft_vec3 place, float radius)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s->triangles; i++) {
        daft_vec3 d = daft_sub(s->positions[s->indices[3 * i]], place);
        if (daft_dot(d, d) < radius * radius) continue;
        memmove(&s->indices[3 * kept++], &s->indices[3 * i], 3 * sizeof *s->indices);
    }
    s->triangles = kept;
}

/* A strip around a circle, closed with `twists` half twists, of no thickness. */
static fixture_mesh strip(uint32_t columns, uint32_t twists)
{
    sheet s = sheet_make(2 * columns, 2 * columns);
    for (uint32_t j = 0; j < columns; j++) {
        double a = 2 * DAFT_PI * j / columns, tilt = DAFT_PI * twists * j / columns;
        for (int side = -1; side <= 1; side += 2) {
            double r = 1 + 0.3 * side * daft_cos(tilt);
            s.positions[s.vertices++] = daft_v3((float)(r * daft_cos(a)), (float)(0.3 * side * daft_sin(tilt)), (float)(r * daft_sin(a)));
        }
        bool over = j + 1 == columns && twists % 2;
        uint32_t b = 2 * j, c = 2 * ((j + 1) % columns) + over, d = 2 * ((j + 1) % columns) + !over;
        const uint32_t two[6] = {b, b + 1, d, b, d, c};
        memcpy(s.indices + 3 * s.triangles, two, sizeof two);
        s.triangles += 2;
    }
    return sheet_finish(&s);
}

enum { SHAPES = 10 };

/* Of about a unit's radius. */
static fixture_mesh shape_make(int kind)
{
    fixture_mesh ball = mesh_ball(14, 1, kind == 1 ? 0.25f : 0.02f), out;
    const daft_vec3 none = {0, 0, 0};
    sheet s = sheet_make(2 * ball.mesh.vertex_count, 2 * ball.mesh.triangle_count);
    if (kind == 7 || kind == 8) {
        mesh_drop(&ball), free(s.positions), free(s.indices);
        return kind == 7 ? strip(40, 1) : mesh_soup(400, 1, 0.3f);
    }
    sheet_add(&s, &ball, 1, none, kind == 2);
    if (kind == 3) sheet_cut(&s, daft_v3(0, -1, 0), 0.4f);                                              /* one hole */
    if (kind == 4) sheet_cut(&s, daft_v3(0.5f, 0.7f, 0.4f), 0.3f), sheet_cut(&s, daft_v3(0, -1, 0), 0.9f); /* two */
    if (kind == 5) sheet_add(&s, &ball, 0.5f, daft_v3(0.2f, 0, 0), true);                               /* hollow */
    if (kind == 6) sheet_add(&s, &ball, 0.8f, daft_v3(0.9f, 0.3f, 0), random_bits() & 1);               /* two that cross */
    if (kind == 9) sheet_add(&s, &ball, 1, none, true);                                                 /* both ways: no inside */
    out = sheet_finish(&s);
    mesh_drop(&ball);
    return out;
}

/* ---- what the header promises ---- */

/* Whether the ray meets a cap's box, or comes near it. */
static bool meets_cap(const daft_inner *inner, daft_vec3 from, daft_vec3 way)
{
    for (uint32_t i = 0; i < inner->cap_count; i++) {
        double near = 0, far = INFINITY;
        for (int k = 0; k < 3; k++) {
            double low = (double)inner->caps.bounds[k][i] - 1e-4, high = (double)inner->caps.bounds[3 + k][i] + 1e-4;
            double a = (low - (double)(&from.x)[k]) / (double)(&way.x)[k], b = (high - (double)(&from.x)[k]) / (double)(&way.x)[k];
            near = fmax(near, fmin(a, b)), far = fmin(far, fmax(a, b));
        }
        if (near <= far) return true;
    }
    return false;
}

/* Whether the ray, in front of its start, goes through a triangle; it starts at none. */
static bool is_stopped(const daft_trimesh *mesh, daft_vec3 from, daft_vec3 way)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        daft_vec3 c[3];
        corners_of(mesh, i, c);
        if (!daft_line_hits(from, c[0], c[1], c[2], way)) continue;
        daft_dvec3 a = daft_to_double(c[0]), n = daft_dcross(daft_dsub(daft_to_double(c[1]), a), daft_dsub(daft_to_double(c[2]), a));
        if (daft_ddot(n, daft_dsub(a, daft_to_double(from))) / daft_ddot(n, daft_to_double(way)) > 0) return true;
    }
    return false;
}

/* No corner, and no point on a triangle, is as near as the radius. */
static void keeps_clear(const daft_trimesh *mesh, daft_vec3 centre, float radius)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        daft_vec3 c[3];
        corners_of(mesh, i, c);
        for (int at = 0; at < 12; at++) {
            float v = at < 3 ? (float)(at == 1) : random_float(0, 1), w = at < 3 ? (float)(at == 2) : random_float(0, 1 - v);
            daft_vec3 p = daft_add(c[0], daft_add(daft_scale(daft_sub(c[1], c[0]), v), daft_scale(daft_sub(c[2], c[0]), w)));
            assert_true(daft_length(daft_sub(p, centre)) > radius);
        }
    }
}

static int check_balls(const fixture_mesh *m, int rays)
{
    const daft_inner *inner = m->bvh->inner;
    int asked = 0;
    assert_true(inner->count > 0 && inner->count <= DAFT_INNER_BALLS);
    for (uint32_t i = 0; i < inner->count; i++) {
        daft_vec3 centre = {inner->centre[0][i], inner->centre[1][i], inner->centre[2][i]};
        assert_true(inner->radius[i] > 0);
        keeps_clear(&m->mesh, centre, inner->radius[i]);
        for (int k = 0; k < rays; k++) {
            daft_vec3 from = daft_add(centre, daft_scale(random_unit(), inner->radius[i] * random_float(0, 0.9999f))), way = random_unit();
            if (meets_cap(inner, from, way)) continue;
            assert_true(is_stopped(&m->mesh, from, way));
            asked++;
        }
    }
    for (uint32_t i = inner->count; i < DAFT_INNER_BALLS; i++) assert_true(inner->radius[i] < 0);
    return asked;
}

/* Which shapes have an inside is known; where it is found, it is one. */
static void inside_of_shapes(void **unused)
{
    (void)unused;
    fixture_seed(201);
    static const int balls[SHAPES] = {1, 1, 1, 1, 1, 1, 1, 0, 0, 0};
    int asked = 0;
    for (int round = 0; round < 3 * SHAPES; round++) {
        fixture_mesh m = shape_make(round % SHAPES);
        bool found = daft_bvh_find_inner(m.bvh, &m.mesh);
        assert_int_equal(found, m.bvh->inner != NULL);
        assert_int_equal(found, balls[round % SHAPES]);
        if (found) {
            uint32_t holes = round % SHAPES == 3 ? 1 : round % SHAPES == 4 ? 2 : 0;
            assert_int_equal(m.bvh->inner->cap_count, holes);
            asked += check_balls(&m, 40);
            size_t with = daft_bvh_bytes(m.bvh), size = sizeof *m.bvh->inner;
            const daft_bvh_def def = {.threads = 1};
            daft_bvh_update(m.bvh, &m.mesh, &def);
            assert_null(m.bvh->inner);
            assert_true(daft_bvh_bytes(m.bvh) + size <= with);
        }
        mesh_drop(&m);
    }
    print_message("%d rays\n", asked);
    assert_true(asked > 5000);
}

/* A ball fills most of a ball, and its hole is under the one cap; with too many holes nothing is said. */
static void covers_much(void **unused)
{
    (void)unused;
    fixture_seed(202);
    fixture_mesh m = mesh_ball(30, 1, 0);
    assert_true(daft_bvh_find_inner(m.bvh, &m.mesh));
    assert_true(m.bvh->inner->radius[0] > 0.98f);
    sheet s = sheet_make(m.mesh.vertex_count, m.mesh.triangle_count);
    sheet_add(&s, &m, 1, daft_v3(0, 0, 0), false);
    for (int i = 0; i < DAFT_INNER_CAPS + 1; i++) {
        double a = 2 * DAFT_PI * i / (DAFT_INNER_CAPS + 1);
        sheet_cut(&s, daft_v3((float)daft_cos(a), 0, (float)daft_sin(a)), 0.1f);
    }
    fixture_mesh holes = sheet_finish(&s);
    assert_false(daft_bvh_find_inner(holes.bvh, &holes.mesh));
    mesh_drop(&m), mesh_drop(&holes);
}

/* Flat, thin, tiny, huge, far from where floats are fine: an answer soon, and no ball that is not inside. */
static void odd_sizes(void **unused)
{
    (void)unused;
    fixture_seed(203);
    static const struct {
        daft_vec3 scale, by;
    } CASES[] = {{{1, 1, 0}, {0, 0, 0}},         {{1, 1e-4f, 1}, {0, 0, 0}},       {{1e-20f, 1e-20f, 1e-20f}, {0, 0, 0}},
                 {{1e15f, 1e15f, 1e15f}, {0, 0, 0}}, {{1, 1, 1}, {1e6f, -1e6f, 1e6f}}, {{1, 1, 1}, {3e4f, 0, 0}},
                 {{0, 0, 0}, {1, 2, 3}},         {{1e-6f, 100, 1e-6f}, {0, 0, 0}}};
    for (size_t i = 0; i < DAFT_COUNT_OF(CASES); i++) {
        fixture_mesh ball = mesh_ball(16, 1, 0.05f);
        sheet s = sheet_make(ball.mesh.vertex_count, ball.mesh.triangle_count);
        sheet_add(&s, &ball, 1, daft_v3(0, 0, 0), false);
        for (uint32_t k = 0; k < s.vertices; k++) s.positions[k] = daft_add(daft_mul(s.positions[k], CASES[i].scale), CASES[i].by);
        fixture_mesh m = sheet_finish(&s);
        if (daft_bvh_find_inner(m.bvh, &m.mesh)) check_balls(&m, 20);
        mesh_drop(&m), mesh_drop(&ball);
    }
}

static void without_memory(void **unused)
{
    (void)unused;
    fixture_seed(204);
    for (int kind = 0; kind <= 3; kind += 3) {
        fixture_mesh m = shape_make(kind);
        int fail_at = 0;
        for (;; fail_at++) {
            meter memory = {fail_at, 0};
            m.bvh->allocator = (daft_allocator){&memory, meter_allocate, meter_release};
            bool found = daft_bvh_find_inner(m.bvh, &m.mesh);
            assert_int_equal(found, m.bvh->inner != NULL);
            assert_int_equal(memory.held, found);
            m.bvh->allocator = daft_malloc_allocator();
            if (found) break;
        }
        assert_true(fail_at > 6);
        mesh_drop(&m);
    }
}

/* ---- shadows ---- */

DAFT_KERNEL_DECLARE(daft_render_kernels, daft_render);
static const daft_render_kernels *kernels(int isa)
{
    static const daft_render_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_render);
    return TABLE[isa];
}

enum { THINGS = 24 };

typedef struct stage {
    fixture_mesh shape[SHAPES];
    daft_inner *inner[SHAPES]; /* kept while the shapes go without, */
    daft_open *open[SHAPES];   /* like their free ways */
    daft_instance things[THINGS];
    daft_allocator allocator;
    daft_arena arena;
    const daft_tlas *tlas;
} stage;

/* Around `at`: even scales and others, mirrored ones, meshes that are said to be convex. */
static void stage_make(stage *s, uint32_t count, daft_vec3 at)
{
    for (int i = 0; i < SHAPES; i++) {
        s->shape[i] = shape_make(i);
        daft_bvh_find_inner(s->shape[i].bvh, &s->shape[i].mesh);
        daft_bvh_find_open(s->shape[i].bvh, &s->shape[i].mesh, UINT32_MAX, 1);
        s->inner[i] = s->shape[i].bvh->inner, s->open[i] = s->shape[i].bvh->open;
    }
    for (uint32_t i = 0; i < count; i++) {
        float size = random_float(0.4f, 1.5f);
        daft_vec3 scale = i % 3 ? daft_v3(size, size, size) : daft_v3(size, -random_float(0.2f, 1) * size, 1.3f * size);
        daft_vec3 place = daft_add(at, random_vec3(-4, 4));
        s->things[i] = instance_make(&s->shape[random_bits() % SHAPES], affine_make(random_rotation(), scale, place));
        if (i % 11 == 5) s->things[i].flags |= DAFT_INSTANCE_CONVEX;
    }
    s->allocator = daft_malloc_allocator();
    daft_arena_init(&s->arena, &s->allocator);
    s->tlas = daft_tlas_build(&s->arena, s->things, count, NULL);
    assert_non_null(s->tlas);
}

static void stage_drop(stage *s)
{
    daft_arena_free(&s->arena);
    for (int i = 0; i < SHAPES; i++) mesh_drop(&s->shape[i]);
}

static void stage_inner(stage *s, bool with)
{
    for (int i = 0; i < SHAPES; i++) s->shape[i].bvh->inner = with ? s->inner[i] : NULL, s->shape[i].bvh->open = with ? s->open[i] : NULL;
}

/* Points on a thing, just over its triangles, or in a patch anywhere around. */
static void fill_points(const stage *s, uint32_t count, daft_vec3 at, daft_batch *b)
{
    uint32_t number = random_bits() % count;
    const daft_instance *thing = &s->things[number];
    daft_vec3 place = daft_add(at, random_vec3(-4, 4)), u = random_vec3(-2, 2), v = random_vec3(-2, 2);
    bool on = random_bits() & 1;
    b->count = 600 + random_bits() % 400;
    for (uint32_t i = 0; i < b->count; i++) {
        daft_vec3 p = daft_add(place, daft_add(daft_scale(u, random_float(-1, 1)), daft_scale(v, random_float(-1, 1)))), up = {0, 1, 0};
        uint32_t triangle = random_bits() % thing->mesh->triangle_count;
        if (on) {
            daft_vec3 c[3];
            corners_of(thing->mesh, triangle, c);
            for (int k = 0; k < 3; k++) c[k] = daft_affine_point(&thing->to_frame, c[k]);
            float x = random_float(0, 1), y = random_float(0, 1 - x);
            up = daft_normalize(daft_cross(daft_sub(c[1], c[0]), daft_sub(c[2], c[0])));
            if (i % 3 == 0) up = daft_neg(up);
            p = daft_add(c[0], daft_add(daft_scale(daft_sub(c[1], c[0]), x), daft_scale(daft_sub(c[2], c[0]), y)));
            p = daft_add(p, daft_scale(up, 1e-4f));
        }
        b->lifted.x[i] = p.x, b->lifted.y[i] = p.y, b->lifted.z[i] = p.z;
        b->outward.x[i] = up.x, b->outward.y[i] = up.y, b->outward.z[i] = up.z;
        b->instance[i] = on ? number : UINT32_MAX, b->triangle[i] = triangle, b->pixel[i] = i;
    }
}

/* Suns; lamps far off, anywhere, among the points, within things, and just over their surface. */
static daft_lamp random_lamp(const stage *s, uint32_t count, daft_vec3 at, int kind)
{
    daft_lamp lamp = {.sun = kind == 0, .casts_shadow = true, .to_light = random_unit()};
    const daft_instance *thing = &s->things[random_bits() % count];
    daft_vec3 corner[3];
    lamp.position = daft_add(at, daft_scale(random_unit(), kind == 1 ? 1e4f : random_float(0, 15)));
    if (kind == 3) lamp.position = daft_affine_point(&thing->to_frame, daft_scale(random_unit(), random_float(0, 0.9f)));
    if (kind == 4) {
        corners_of(thing->mesh, random_bits() % thing->mesh->triangle_count, corner);
        lamp.position = daft_affine_point(&thing->to_frame, daft_scale(corner[0], random_float(0.999f, 1.001f)));
    }
    return lamp;
}

static void compare(stage *s, const daft_batch *b, const daft_lamp *lamp, int *dark)
{
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        uint32_t bits[2][DAFT_BATCH_WORDS] = {{0}}, under[2];
        for (int with = 0; with < 2; with++) {
            for (uint32_t i = 0; i < b->count; i++) bits[with][i / 32] |= (uint32_t)1 << (i % 32);
            stage_inner(s, with);
            under[with] = kernels(isa)->shadows(b, lamp, s->tlas, DAFT_NOTHING, bits[with]);
        }
        assert_int_equal(under[0], under[1]);
        assert_memory_equal(bits[0], bits[1], sizeof bits[0]);
        for (uint32_t i = 0; i < b->count && !isa; i++) *dark += !(bits[0][i / 32] >> (i % 32) & 1);
    }
    stage_inner(s, true);
}

static void run(uint32_t count, float far)
{
    daft_batch *b = calloc(1, sizeof *b);
    int dark = 0, pencils = 0;
    for (int round = 0; round < 12; round++) {
        stage s;
        daft_vec3 at = daft_scale(random_unit(), far);
        stage_make(&s, count, at);
        for (int i = 0; i < 20; i++, pencils++) {
            fill_points(&s, count, at, b);
            const daft_lamp lamp = random_lamp(&s, count, at, i % 5);
            compare(&s, b, &lamp, &dark);
        }
        stage_drop(&s);
    }
    print_message("%d pencils, %d points dark\n", pencils, dark);
    assert_true(dark > 5000);
    free(b);
}

static void shadows_of_few(void **unused) { (void)unused, fixture_seed(205), run(4, 0); }
static void shadows_of_many(void **unused) { (void)unused, fixture_seed(206), run(THINGS, 0); }
static void shadows_far_off(void **unused) { (void)unused, fixture_seed(207), run(6, 3e4f); }

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inside_of_shapes), cmocka_unit_test(covers_much), cmocka_unit_test(odd_sizes),
        cmocka_unit_test(without_memory), cmocka_unit_test(shadows_of_few), cmocka_unit_test(shadows_of_many),
        cmocka_unit_test(shadows_far_off),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
