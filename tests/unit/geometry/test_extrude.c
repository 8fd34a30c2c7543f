/* Solids from flat contours, against winding numbers counted directly. */
#include "geometry/mesh.h"
#include "geometry/outline.h"
#include "math/trig.h"
#include "support_content.h"

static counting memory;

static bool extrude(const daft_vec2 *points, const uint32_t *counts, uint32_t contours, float depth, daft_trimesh *mesh,
                    daft_error *error)
{
    daft_allocator allocator = counting_allocator(&memory);
    daft_extrude_def def = {DAFT_COOKIE, points, 0, counts, contours, depth};
    for (uint32_t i = 0; i < contours; i++) def.point_count += counts[i];
    return daft_trimesh_extrude(&allocator, &def, mesh, error);
}

static void free_mesh(daft_trimesh *mesh)
{
    daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
    daft_trimesh_free(&allocator, mesh);
    assert_int_equal(memory.live, 0);
}

static daft_dvec3 vertex(const daft_trimesh *mesh, uint32_t i)
{
    return (daft_dvec3){(double)mesh->x[i], (double)mesh->y[i], (double)mesh->z[i]};
}

/* By the divergence theorem. */
static double volume(const daft_trimesh *mesh)
{
    double sum = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *t = mesh->indices + 3 * (size_t)i;
        sum += daft_ddot(vertex(mesh, t[0]), daft_dcross(vertex(mesh, t[1]), vertex(mesh, t[2])));
    }
    return sum / 6;
}

/* Of the front's triangles: their area, and how many of them hold a point. */
static double front_area(const daft_trimesh *mesh)
{
    double sum = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *t = mesh->indices + 3 * (size_t)i;
        const daft_dvec3 a = vertex(mesh, t[0]), b = vertex(mesh, t[1]), c = vertex(mesh, t[2]);
        if (a.z > 0 && b.z > 0 && c.z > 0) sum += ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
    }
    return sum;
}

/* `slack`: 0 counts those that have it strictly inside, a little below zero those with it on an edge, too. */
static int fronts_at(const daft_trimesh *mesh, double x, double y, double slack)
{
    int found = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *t = mesh->indices + 3 * (size_t)i;
        bool inside = true;
        for (int k = 0; k < 3; k++) {
            const daft_dvec3 a = vertex(mesh, t[k]), b = vertex(mesh, t[(k + 1) % 3]);
            inside = inside && a.z > 0 && (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x) > slack;
        }
        found += inside;
    }
    return found;
}

/* The winding number, and how near the nearest edge is. */
static int winding(const daft_vec2 *points, const uint32_t *counts, uint32_t contours, double x, double y, double *near)
{
    int sum = 0;
    *near = INFINITY;
    for (uint32_t c = 0; c < contours; points += counts[c++])
        for (uint32_t i = 0; i < counts[c]; i++) {
            const daft_vec2 a = points[i], b = points[(i + 1) % counts[c]];
            const double ax = (double)a.x - x, ay = (double)a.y - y, bx = (double)b.x - x, by = (double)b.y - y;
            const double side = ax * by - ay * bx, dx = bx - ax, dy = by - ay, length2 = dx * dx + dy * dy;
            double t = length2 > 0 ? -(ax * dx + ay * dy) / length2 : 0;
            t = t < 0 ? 0 : t > 1 ? 1 : t;
            *near = fmin(*near, hypot(ax + t * dx, ay + t * dy));
            if (ay <= 0 && by > 0 && side > 0) sum++;
            if (ay > 0 && by <= 0 && side < 0) sum--;
        }
    return sum;
}

static uint32_t state;
static uint32_t next(void) { return (state = state * 1664525u + 1013904223u) >> 8; }

/* Closed, of the right volume, and a front triangle exactly where the winding number is not zero. */
static void check_solid(const daft_vec2 *points, const uint32_t *counts, uint32_t contours, float extent)
{
    daft_trimesh mesh;
    daft_error error;
    if (!extrude(points, counts, contours, 0.5f, &mesh, &error)) {
        assert_string_equal(error.message, "the contours enclose nothing");
        for (int i = 0; i < 100; i++) {
            double near;
            const double x = (double)extent * (next() % 4096) / 4096, y = (double)extent * (next() % 4096) / 4096;
            const int wound = winding(points, counts, contours, x, y, &near);
            if (near > 1e-5 * (double)extent) assert_int_equal(wound, 0);
        }
        assert_int_equal(memory.live, 0);
        return;
    }
    const daft_allocator plain = daft_malloc_allocator();
    daft_mesh_report report;
    assert_true(daft_trimesh_check(&plain, &mesh, NULL, NULL, &report, &error));
    assert_int_equal(report.open_edges, 0);
    assert_int_equal(report.turned_edges, 0);
    const double area = front_area(&mesh);
    assert_true(fabs(volume(&mesh) - 0.5 * area) < 1e-9 * (double)(extent * extent));
    for (int i = 0; i < 60; i++) {
        double near;
        const double x = (double)extent * (next() % 4096) / 4096, y = (double)extent * (next() % 4096) / 4096;
        const bool inside = winding(points, counts, contours, x, y, &near) != 0;
        /* Within a few cells of an edge it may be either. */
        if (near > 1e-5 * (double)extent) assert_int_equal(fronts_at(&mesh, x, y, -1e-9) > 0, inside);
        assert_true(fronts_at(&mesh, x, y, 0) <= 1);
    }
    free_mesh(&mesh);
}

/* Contours that cross, touch and repeat themselves; on a coarse grid corners fall on each other and on edges. */
static void random_contours_are_filled(void **unused)
{
    (void)unused;
    for (uint32_t seed = 0; seed < 4000; seed++) {
        daft_vec2 points[64];
        uint32_t counts[4], used = 0;
        state = seed;
        const uint32_t contours = 1 + next() % 4, cells = seed % 3 == 0 ? 5 : seed % 3 == 1 ? 16 : 100000;
        for (uint32_t c = 0; c < contours; c++) {
            counts[c] = 1 + next() % 14;
            for (uint32_t i = 0; i < counts[c]; i++)
                points[used++] = (daft_vec2){(float)(next() % cells) * 16 / (float)cells,
                                             (float)(next() % cells) * 16 / (float)cells};
        }
        check_solid(points, counts, contours, 16);
    }
}

/* A ring of many sides has the area of its polygon, smooth walls and flat lids. */
static void rings_have_their_measures(void **unused)
{
    (void)unused;
    enum { SIDES = 48 };
    daft_vec2 points[2 * SIDES];
    const uint32_t counts[2] = {SIDES, SIDES};
    for (int i = 0; i < SIDES; i++) {
        const double angle = 2 * DAFT_PI * i / SIDES;
        points[i] = (daft_vec2){(float)(2 * daft_cos(angle)), (float)(2 * daft_sin(angle))};
        points[SIDES + i] = (daft_vec2){(float)daft_cos(angle), (float)-daft_sin(angle)};
    }
    daft_trimesh mesh;
    daft_error error;
    assert_true(extrude(points, counts, 2, 1, &mesh, &error));
    assert_int_equal(mesh.vertex_count, 4 * SIDES);
    assert_int_equal(mesh.triangle_count, 2 * 2 * SIDES + 2 * 2 * SIDES); /* a hole: as many triangles as corners */
    const double wanted = 0.5 * SIDES * daft_sin(2 * DAFT_PI / SIDES) * (4 - 1);
    assert_true(fabs(volume(&mesh) - wanted) < 1e-5);
    for (uint32_t i = 0; i < 3 * mesh.triangle_count; i++) {
        const daft_vec3 n = mesh.normals[mesh.normal_indices ? mesh.normal_indices[i] : mesh.indices[i]];
        const daft_dvec3 p = vertex(&mesh, mesh.indices[i]);
        if (fabsf(n.z) > 0.5f) {
            assert_true(fabsf(n.z) == 1 && n.x == 0 && n.y == 0 && (double)n.z * p.z > 0);
        } else {
            const double radius = hypot(p.x, p.y), out = radius > 1.5 ? 1 : -1;
            assert_true(fabs((double)n.x - out * p.x / radius) < 1e-4 && fabs((double)n.y - out * p.y / radius) < 1e-4);
        }
    }
    free_mesh(&mesh);
}

/* Coordinates that are powers of two apart come back as they were. */
static void corners_keep_their_places(void **unused)
{
    (void)unused;
    const daft_vec2 points[] = {{-0.25f, 0}, {1.5f, 0}, {1.5f, 2}, {-0.25f, 2}};
    const uint32_t counts[] = {4};
    daft_trimesh mesh;
    daft_error error;
    assert_true(extrude(points, counts, 1, 0.25f, &mesh, &error));
    assert_true(mesh.low.x == -0.25f && mesh.low.y == 0 && mesh.low.z == -0.125f);
    assert_true(mesh.high.x == 1.5f && mesh.high.y == 2 && mesh.high.z == 0.125f);
    assert_int_equal(mesh.triangle_count, 12);
    assert_int_equal(mesh.vertex_count, 8);
    free_mesh(&mesh);
}

static void wrong_contours_are_refused(void **unused)
{
    (void)unused;
    const daft_vec2 points[] = {{0, 0}, {1, 0}, {1, 1}}, bad[] = {{0, 0}, {NAN, 0}, {1, 1}};
    const uint32_t counts[] = {3}, wrong[] = {4};
    daft_allocator allocator = counting_allocator(&memory);
    daft_trimesh mesh;
    daft_error error;
    daft_extrude_def def = {DAFT_COOKIE, points, 3, counts, 1, 0};
    assert_false(daft_trimesh_extrude(&allocator, &def, &mesh, &error));
    assert_string_equal(error.message, "depth is 0; it must be above 0");
    def.depth = 1, def.counts = wrong;
    assert_false(daft_trimesh_extrude(&allocator, &def, &mesh, &error));
    assert_string_equal(error.message, "the contours' counts do not add up to the 3 points");
    def.counts = counts, def.points = bad;
    assert_false(daft_trimesh_extrude(&allocator, &def, &mesh, &error));
    def.points = points, def.point_count = 65537;
    assert_false(daft_trimesh_extrude(&allocator, &def, &mesh, &error));
    def.point_count = 0, def.contour_count = 0;
    assert_false(daft_trimesh_extrude(&allocator, &def, &mesh, &error));
    assert_string_equal(error.message, "the contours enclose nothing");
    assert_int_equal(memory.live, 0);
}

/* So many lines across each other would take minutes. */
static void a_tangle_is_refused_in_time(void **unused)
{
    (void)unused;
    enum { COUNT = 20000 };
    static daft_vec2 points[COUNT];
    const uint32_t counts[] = {COUNT};
    daft_trimesh mesh;
    daft_error error;
    state = 1;
    for (int i = 0; i < COUNT; i++) points[i] = (daft_vec2){(float)(next() % 65536), (float)(next() % 65536)};
    assert_false(extrude(points, counts, 1, 1, &mesh, &error));
    assert_string_equal(error.message, "the contours are too many, or too entangled, to be made solid");
    assert_int_equal(memory.live, 0);
}

/* Whichever allocation fails, nothing is lost. */
static void memory_may_run_out(void **unused)
{
    (void)unused;
    const daft_vec2 points[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {1, 1}, {1, 3}, {3, 5}, {3, 1}};
    const uint32_t counts[] = {4, 4};
    for (int fail_at = 0;; fail_at++) {
        daft_allocator allocator = counting_allocator(&memory);
        memory.fail_at = fail_at;
        const daft_extrude_def def = {DAFT_COOKIE, points, 8, counts, 2, 1};
        daft_trimesh mesh;
        daft_error error;
        const bool done = daft_trimesh_extrude(&allocator, &def, &mesh, &error);
        if (done) {
            free_mesh(&mesh);
            assert_true(fail_at > 5);
            return;
        }
        assert_int_equal(error.code, DAFT_ERROR_MEMORY);
        assert_int_equal(memory.live, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rings_have_their_measures),   cmocka_unit_test(corners_keep_their_places),
        cmocka_unit_test(random_contours_are_filled),  cmocka_unit_test(wrong_contours_are_refused),
        cmocka_unit_test(a_tangle_is_refused_in_time), cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
