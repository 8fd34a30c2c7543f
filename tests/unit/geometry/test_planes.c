/* geometry: the planes of a mesh. */
#include "geometry/planes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { VERTICES = 8192, TRIANGLES = 16384 };

/* A mesh at work: each triangle's face is written down beside it. */
typedef struct builder {
    uint32_t vertex_count, triangle_count;
    daft_vec3 positions[VERTICES];
    uint32_t indices[3 * TRIANGLES];
    int face[TRIANGLES];
    daft_quat turn;
    daft_vec3 move;
} builder;

static const daft_quat NO_TURN = {0, 0, 0, 1};

static builder *builder_make(daft_quat turn, daft_vec3 move)
{
    builder *b = calloc(1, sizeof *b);
    assert_non_null(b);
    b->turn = daft_quat_normalize(turn), b->move = move;
    return b;
}

/* A parallelogram of cells · cells · 2 triangles; its vertices are rounded once more when they are turned. */
static void add_face(builder *b, daft_vec3 at, daft_vec3 u, daft_vec3 v, uint32_t cells, int face)
{
    const uint32_t first = b->vertex_count, side = cells + 1;
    for (uint32_t i = 0; i < side * side; i++) {
        const daft_vec3 p = daft_add(at, daft_add(daft_scale(u, (float)(i % side) / (float)cells),
                                                  daft_scale(v, (float)(i / side) / (float)cells)));
        b->positions[b->vertex_count++] = daft_add(daft_quat_rotate(b->turn, p), b->move);
    }
    for (uint32_t i = 0; i < cells * cells; i++) {
        const uint32_t a = first + i / cells * side + i % cells,
                       corners[6] = {a, a + 1, a + side, a + 1, a + side + 1, a + side};
        memcpy(&b->indices[3 * b->triangle_count], corners, sizeof corners);
        b->face[b->triangle_count++] = face, b->face[b->triangle_count++] = face;
    }
}

static daft_trimesh mesh_of(const builder *b)
{
    const daft_allocator allocator = daft_malloc_allocator();
    const daft_log log = {0};
    daft_error error = {0};
    daft_mesh_def def = daft_default_mesh_def();
    daft_trimesh mesh;
    def.positions = b->positions, def.vertex_count = b->vertex_count;
    def.indices = b->indices, def.triangle_count = b->triangle_count;
    if (!daft_trimesh_from_arrays(&allocator, &def, &log, &mesh, &error)) fail_msg("%s", error.message);
    assert_int_equal(mesh.triangle_count, b->triangle_count);
    return mesh;
}

static daft_mesh_planes planes_of(const daft_trimesh *mesh, const bool *wanted)
{
    const daft_allocator allocator = daft_malloc_allocator();
    daft_mesh_planes planes;
    assert_true(daft_trimesh_planes(&allocator, mesh, wanted, &planes));
    return planes;
}

static void drop(daft_trimesh *mesh, daft_mesh_planes *planes, builder *b)
{
    const daft_allocator allocator = daft_malloc_allocator();
    daft_mesh_planes_free(&allocator, planes);
    daft_trimesh_free(&allocator, mesh);
    free(b);
}

static void add_room(builder *b, uint32_t cells)
{
    const daft_vec3 x = {6, 0, 0}, y = {0, 3, 0}, z = {0, 0, 4.5f}, o = {-3, -1.5f, -2};
    add_face(b, o, x, y, cells, 0), add_face(b, daft_add(o, z), x, y, cells, 1);
    add_face(b, o, y, z, cells, 2), add_face(b, daft_add(o, x), y, z, cells, 3);
    add_face(b, o, z, x, cells, 4), add_face(b, daft_add(o, y), z, x, cells, 5);
}

/* Each triangle's plane holds its corners to the bound, two triangles have one plane if they are of one face, and its
 * bounds hold the face. */
static void check_faces(const builder *b, const daft_trimesh *m, const daft_mesh_planes *planes)
{
    const daft_vec3 most = daft_max3(daft_neg(m->low), m->high);
    const double bound = 16 * 0x1p-24 * (double)(most.x + most.y + most.z);
    int face_of[DAFT_MESH_PLANES];
    memset(face_of, -1, sizeof face_of);
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        assert_true(planes->of[t] < planes->count);
        const daft_mesh_plane *p = &planes->planes[planes->of[t]];
        if (face_of[planes->of[t]] < 0) face_of[planes->of[t]] = b->face[t];
        assert_int_equal(face_of[planes->of[t]], b->face[t]);
        for (int k = 0; k < 3; k++) {
            const daft_vec3 c = b->positions[b->indices[3 * t + (uint32_t)k]];
            assert_true(fabs(daft_ddot(p->normal, daft_to_double(c)) - p->offset) <= bound);
            assert_true(c.x >= p->low.x && c.y >= p->low.y && c.z >= p->low.z);
            assert_true(c.x <= p->high.x && c.y <= p->high.y && c.z <= p->high.z);
        }
    }
}

/* Fine grids and coarse, anywhere and any way round. */
static void rooms_have_six(void **unused)
{
    (void)unused;
    const uint32_t cells[] = {1, 3, 32};
    const daft_quat turns[] = {NO_TURN, {0.3f, 0.1f, -0.2f, 1}, {1, 0.7f, 0.2f, 0.1f}};
    const daft_vec3 moves[] = {{0, 0, 0}, {11, -3, 20}};
    const bool wanted[1] = {true};
    for (int i = 0; i < 18; i++) {
        builder *b = builder_make(turns[i / 3 % 3], moves[i / 9]);
        add_room(b, cells[i % 3]);
        daft_trimesh mesh = mesh_of(b);
        daft_mesh_planes planes = planes_of(&mesh, wanted);
        assert_int_equal(planes.count, 6);
        check_faces(b, &mesh, &planes);
        drop(&mesh, &planes, b);
    }
}

/* Two panels over a floor: one whose height roundings may explain, one that stands off it. */
static void what_stands_off_is_another(void **unused)
{
    (void)unused;
    const bool wanted[1] = {true};
    builder *b = builder_make(NO_TURN, daft_v3(0, 0, 0));
    const float unit = 0x1p-24f * 20; /* u·S */
    add_face(b, daft_v3(-10, 0, -10), daft_v3(20, 0, 0), daft_v3(0, 0, 20), 4, 0);
    add_face(b, daft_v3(1, 4 * unit, 1), daft_v3(3, 0, 0), daft_v3(0, 0, 3), 1, 0);
    add_face(b, daft_v3(-4, 100 * unit, 1), daft_v3(3, 0, 0), daft_v3(0, 0, 3), 1, 1);
    daft_trimesh mesh = mesh_of(b);
    daft_mesh_planes planes = planes_of(&mesh, wanted);
    assert_int_equal(planes.count, 2);
    check_faces(b, &mesh, &planes);
    assert_true(fabs(planes.planes[0].normal.y) == 1 && fabs(planes.planes[0].offset) < 1e-5);
    drop(&mesh, &planes, b);
}

/* Of twelve steps the eight largest; of two slots the wanted one. */
static void the_largest_of_those_wanted(void **unused)
{
    (void)unused;
    bool wanted[2] = {true, false};
    builder *b = builder_make(NO_TURN, daft_v3(0, 0, 0));
    for (int i = 0; i < 12; i++)
        add_face(b, daft_v3(0, (float)i, (float)i), daft_v3(1 + (float)(i * 5 % 12), 0, 0), daft_v3(0, 0, 1), 2, i);
    daft_trimesh mesh = mesh_of(b);
    daft_mesh_planes planes = planes_of(&mesh, wanted);
    assert_int_equal(planes.count, DAFT_MESH_PLANES);
    for (uint32_t t = 0; t < mesh.triangle_count; t++) {
        int before = 0;
        for (int i = 0; i < b->face[t]; i++) before += i * 5 % 12 >= 4;
        assert_int_equal(planes.of[t], b->face[t] * 5 % 12 >= 4 ? before : DAFT_NO_PLANE);
    }
    const daft_allocator allocator = daft_malloc_allocator();
    daft_mesh_planes_free(&allocator, &planes);
    mesh.slots = daft_alloc_zero(&allocator, mesh.triangle_count, sizeof *mesh.slots), mesh.slot_count = 2;
    for (uint32_t t = 0; t < mesh.triangle_count; t++) mesh.slots[t] = b->face[t] != 3;
    planes = planes_of(&mesh, wanted);
    assert_int_equal(planes.count, 1);
    for (uint32_t t = 0; t < mesh.triangle_count; t++)
        assert_int_equal(planes.of[t], b->face[t] == 3 ? 0 : DAFT_NO_PLANE);
    drop(&mesh, &planes, b);
}

/* A vault of strips whose normals are smooth has none: its rays do not meet in one eye. */
static void smooth_surfaces_have_none(void **unused)
{
    (void)unused;
    const bool wanted[1] = {true};
    builder *b = builder_make(NO_TURN, daft_v3(0, 0, 0));
    for (uint32_t i = 0; i <= 64; i++)
        for (uint32_t k = 0; k < 2; k++) {
            const double angle = (double)i / 64 * DAFT_PI;
            b->positions[2 * i + k] = daft_v3(k ? 3 : -3, 2 * (float)sin(angle), 2 * (float)cos(angle));
        }
    for (uint32_t i = 0; i < 64; i++) {
        const uint32_t corners[6] = {2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 1, 2 * i + 3, 2 * i + 2};
        memcpy(&b->indices[6 * i], corners, sizeof corners);
    }
    b->vertex_count = 130, b->triangle_count = 128;
    daft_trimesh mesh = mesh_of(b);
    daft_mesh_planes planes = planes_of(&mesh, wanted);
    assert_int_equal(planes.count, 0);
    assert_null(planes.of);
    drop(&mesh, &planes, b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rooms_have_six),
        cmocka_unit_test(what_stands_off_is_another),
        cmocka_unit_test(the_largest_of_those_wanted),
        cmocka_unit_test(smooth_surfaces_have_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
