/* Meshes from arrays, boxes, and smooth normals against a slow, obvious twin. */
#include "geometry/mesh.h"
#include "geometry/analysis/smooth.h"
#include "math/trig.h"
#include "support_content.h"

static counting memory;
static memo warnings;

static void free_mesh(daft_trimesh *mesh)
{
    daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
    daft_trimesh_free(&allocator, mesh);
    assert_int_equal(memory.live, 0);
}

static daft_trimesh from_arrays(const daft_mesh_def *def)
{
    daft_allocator allocator = counting_allocator(&memory);
    daft_log log = memo_log(&warnings);
    daft_trimesh mesh;
    daft_error error;
    if (!daft_trimesh_from_arrays(&allocator, def, &log, &mesh, &error)) fail_msg("%s", error.message);
    return mesh;
}

static daft_vec3 normal_at(const daft_trimesh *mesh, uint32_t corner)
{
    return mesh->normals[mesh->normal_indices ? mesh->normal_indices[corner] : mesh->indices[corner]];
}

static void arrays_are_copied(void **unused)
{
    (void)unused;
    daft_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {9, 9, 9}, {0, 1, 0}};
    daft_vec3 normals[] = {{0, 0, 2}, {0, 0, 0}, {0, NAN, 0}, {1, 0, 0}, {3, 0, 4}};
    daft_vec2 uvs[] = {{0, 0}, {1, 0}, {1, INFINITY}, {0, 0}, {0, 1}};
    uint32_t indices[] = {0, 1, 2, 0, 2, 4, 1, 1, 2};
    daft_mesh_def def = {DAFT_COOKIE, positions, normals, uvs, 5, indices, 3, NULL, NULL};
    daft_trimesh mesh = from_arrays(&def);
    assert_true(mesh.vertex_count == 5 && mesh.triangle_count == 2 && mesh.normal_count == 5 && mesh.uv_count == 5);
    assert_memory_equal(mesh.indices, indices, 6 * sizeof(uint32_t));
    assert_true(!mesh.normal_indices && !mesh.uv_indices && !mesh.slots);
    assert_true(mesh.normals[0].z == 1 && mesh.normals[1].z == 1 && mesh.normals[2].z == 1 && mesh.normals[4].z == .8f);
    assert_true(mesh.uvs[2].x == 0 && mesh.uvs[4].y == 1);
    assert_true(mesh.low.x == 0 && mesh.high.x == 1 && mesh.high.z == 0); /* the unused vertex is outside */
    assert_int_equal(warnings.count, 2);
    assert_true(memo_has(&warnings, "1 of 3 triangles are left out"));
    for (int i = 5; i < 16; i++) assert_true(mesh.x[i] == 0 && mesh.y[i] == 0 && mesh.z[i] == 0);
    assert_int_equal(daft_trimesh_bytes(&mesh), 3 * 16 * 4 + 6 * 4 + 5 * 12 + 5 * 8);
    free_mesh(&mesh);
    positions[2].y = NAN;
    mesh = from_arrays(&def);
    assert_int_equal(mesh.triangle_count, 0);
    assert_true(mesh.low.x > mesh.high.x && mesh.y[2] == 0);
    free_mesh(&mesh);
}

static void wrong_arrays_are_refused(void **unused)
{
    (void)unused;
    daft_vec3 positions[3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    uint32_t indices[6] = {0, 1, 2, 0, 1, 3};
    daft_mesh_def def = {DAFT_COOKIE, positions, NULL, NULL, 3, indices, 2, NULL, NULL};
    daft_allocator allocator = counting_allocator(&memory);
    daft_trimesh mesh;
    daft_error error;
    assert_false(daft_trimesh_from_arrays(&allocator, &def, NULL, &mesh, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_string_equal(error.message, "triangle 1 uses vertex 3, but there are 3 vertices");
    def.positions = NULL;
    assert_false(daft_trimesh_from_arrays(&allocator, &def, NULL, &mesh, &error));
    def.positions = positions, def.indices = NULL;
    assert_false(daft_trimesh_from_arrays(&allocator, &def, NULL, &mesh, &error));
    def.indices = indices, def.triangle_count = UINT32_MAX / 2;
    assert_false(daft_trimesh_from_arrays(&allocator, &def, NULL, &mesh, &error));
    assert_int_equal(memory.live, 0);
    def = (daft_mesh_def){.cookie = DAFT_COOKIE};
    mesh = from_arrays(&def);
    assert_true(mesh.triangle_count == 0 && mesh.vertex_count == 0);
    free_mesh(&mesh);
}

static daft_dvec3 position(const daft_trimesh *mesh, uint32_t corner)
{
    return daft_to_double(daft_trimesh_position(mesh, mesh->indices[corner]));
}

/* Every side: outward, counter-clockwise, uvs in metres, u to the right and v up as seen from outside. */
static void a_box_is_right_on_every_side(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_trimesh mesh;
    assert_true(daft_trimesh_box(&allocator, daft_v3(2, 3, 5), &mesh, NULL));
    assert_true(mesh.vertex_count == 8 && mesh.triangle_count == 12 && mesh.normal_count == 6 && mesh.uv_count == 24);
    assert_true(mesh.low.x == -1 && mesh.low.y == -1.5f && mesh.high.z == 2.5f);
    double total = 0;
    for (uint32_t t = 0; t < 12; t++) {
        daft_dvec3 p[3], gradient_u, gradient_v;
        daft_vec2 uv[3];
        for (uint32_t k = 0; k < 3; k++)
            p[k] = position(&mesh, 3 * t + k), uv[k] = mesh.uvs[mesh.uv_indices[3 * t + k]];
        daft_dvec3 e = daft_dsub(p[1], p[0]), f = daft_dsub(p[2], p[0]), twice = daft_dcross(e, f);
        daft_dvec3 outward = daft_to_double(normal_at(&mesh, 3 * t));
        total += sqrt(daft_ddot(twice, twice)) / 2;
        assert_true(daft_ddot(twice, outward) > 0 && daft_ddot(p[0], outward) > 0);
        /* the directions in space along which u and v grow by 1 */
        double a = (double)(uv[1].x - uv[0].x), b = (double)(uv[1].y - uv[0].y), c = (double)(uv[2].x - uv[0].x),
               d = (double)(uv[2].y - uv[0].y), det = a * d - b * c;
        gradient_u = daft_dscale(daft_dsub(daft_dscale(e, d), daft_dscale(f, b)), 1 / det);
        gradient_v = daft_dscale(daft_dsub(daft_dscale(f, a), daft_dscale(e, c)), 1 / det);
        assert_true(fabs(daft_ddot(gradient_u, gradient_u) - 1) < 1e-12 &&
                    fabs(daft_ddot(gradient_v, gradient_v) - 1) < 1e-12);
        daft_dvec3 cross = daft_dcross(gradient_u, gradient_v);
        assert_true(fabs(daft_ddot(cross, outward) - 1) < 1e-12); /* not mirrored */
        if (outward.y == 0) assert_true(gradient_v.y == 1);
        for (int k = 0; k < 3; k++) assert_true(uv[k].x >= 0 && uv[k].y >= 0);
    }
    assert_true(fabs(total - 2 * (6 + 10 + 15)) < 1e-12);
    free_mesh(&mesh);
    daft_error error;
    assert_false(daft_trimesh_box(&allocator, daft_v3(1, 0, 1), &mesh, &error));
    assert_false(daft_trimesh_box(&allocator, daft_v3(1, NAN, 1), &mesh, &error));
    assert_false(daft_trimesh_box(&allocator, daft_v3(1, INFINITY, 1), &mesh, &error));
    assert_int_equal(memory.live, 0);
}

/* ---- smooth normals ---- */

static daft_dvec3 unit_normal(const daft_trimesh *mesh, uint32_t t)
{
    return daft_to_double(daft_trimesh_face_normal(mesh, t));
}

static double angle_at(const daft_trimesh *mesh, uint32_t corner)
{
    uint32_t base = corner - corner % 3;
    daft_dvec3 p = position(mesh, corner), e = daft_dsub(position(mesh, base + (corner + 1) % 3), p);
    daft_dvec3 f = daft_dsub(position(mesh, base + (corner + 2) % 3), p), c = daft_dcross(e, f);
    return atan2(sqrt(daft_ddot(c, c)), daft_ddot(e, f));
}

/* Whether two triangles at a vertex share a second vertex. */
static bool share_edge(const daft_trimesh *mesh, uint32_t a, uint32_t b)
{
    int common = 0;
    for (uint32_t i = 0; i < 3; i++)
        for (uint32_t j = 0; j < 3; j++) common += mesh->indices[3 * a + i] == mesh->indices[3 * b + j];
    return common >= 2;
}

/* The slow twin: from every corner, spread over flat edges until nothing is added. */
static daft_dvec3 expected_normal(const daft_trimesh *mesh, uint32_t corner, double crease)
{
    uint32_t around[4096], count = 0;
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++)
        if (mesh->indices[i] == mesh->indices[corner]) around[count++] = i;
    static bool in[4096];
    for (uint32_t i = 0; i < count; i++) in[i] = around[i] == corner;
    for (bool grown = true; grown;) {
        grown = false;
        for (uint32_t i = 0; i < count; i++)
            for (uint32_t j = 0; j < count; j++) {
                uint32_t a = around[i] / 3, b = around[j] / 3;
                if (!in[i] || in[j] || !share_edge(mesh, a, b)) continue;
                if (daft_ddot(unit_normal(mesh, a), unit_normal(mesh, b)) <= cos(crease)) continue;
                in[j] = grown = true;
            }
    }
    daft_dvec3 sum = {0, 0, 0};
    for (uint32_t i = 0; i < count; i++)
        if (in[i]) sum = daft_dadd(sum, daft_dscale(unit_normal(mesh, around[i] / 3), angle_at(mesh, around[i])));
    return daft_unit(sum);
}

static void check_against_twin(const daft_trimesh *mesh, double crease, uint32_t step)
{
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i += step) {
        daft_dvec3 difference = daft_dsub(expected_normal(mesh, i, crease), daft_to_double(normal_at(mesh, i)));
        if (daft_ddot(difference, difference) > 1e-10)
            fail_msg("corner %u: off by %g", i, sqrt(daft_ddot(difference, difference)));
    }
}

enum { GRID = 24 };

/* A bumpy sheet: inner vertices have closed fans, those at the rim open ones; some edges are creases. */
static daft_trimesh make_sheet(float bump)
{
    static daft_vec3 positions[GRID * GRID];
    static uint32_t indices[6 * GRID * GRID];
    uint32_t count = 0;
    for (uint32_t i = 0; i < GRID * GRID; i++)
        positions[i] = daft_v3((float)(i % GRID), (float)random_below(1000) / 1000 * bump, (float)(i / GRID));
    for (uint32_t y = 0; y + 1 < GRID; y++)
        for (uint32_t x = 0; x + 1 < GRID; x++) {
            uint32_t a = y * GRID + x, b = a + 1, c = a + GRID, d = c + 1;
            bool turn = random_below(2);
            const uint32_t two[6] = {a, c, turn ? b : d, turn ? c : a, d, b};
            memcpy(indices + count, two, sizeof two);
            count += 6;
        }
    daft_mesh_def def = {DAFT_COOKIE, positions, NULL, NULL, GRID * GRID, indices, count / 3, NULL, NULL};
    return from_arrays(&def);
}

static void smooth_normals_agree_with_the_twin(void **unused)
{
    (void)unused;
    print_message("seed %llu\n", (unsigned long long)random_state);
    static const float bumps[] = {0, 0.3f, 1, 3};
    for (size_t i = 0; i < DAFT_COUNT_OF(bumps); i++) {
        daft_trimesh mesh = make_sheet(bumps[i]);
        check_against_twin(&mesh, (double)DAFT_SMOOTH_CREASE, 1);
        if (bumps[i] == 0) assert_null(mesh.normal_indices); /* one normal a vertex */
        daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
        assert_true(daft_trimesh_smooth(&allocator, &mesh, 1.2f, NULL));
        check_against_twin(&mesh, 1.2, 1);
        assert_true(daft_trimesh_smooth(&allocator, &mesh, 0, NULL));
        for (uint32_t k = 0; k < 3 * mesh.triangle_count; k++) {
            daft_vec3 face = daft_trimesh_face_normal(&mesh, k / 3);
            assert_true(daft_dot(face, normal_at(&mesh, k)) > 0.999999f);
        }
        free_mesh(&mesh);
    }
}

/* Fresh memory holds one number everywhere. */
static void *filled_allocate(void *user, size_t size, size_t alignment)
{
    (void)alignment;
    uint32_t *words = malloc(size + sizeof *words);
    for (size_t i = 0; words && i <= size / sizeof *words; i++) words[i] = *(const uint32_t *)user;
    return words;
}

static void filled_release(void *user, void *pointer)
{
    (void)user;
    free(pointer);
}

/* So smooth that no vertex needs its corners listed. */
static daft_trimesh make_torus(void)
{
    enum { AROUND = 64 };
    static daft_vec3 positions[AROUND * AROUND];
    static uint32_t indices[6 * AROUND * AROUND];
    for (uint32_t i = 0; i < AROUND * AROUND; i++) {
        double a = 2 * DAFT_PI * (i % AROUND) / AROUND, b = 2 * DAFT_PI * (double)(i / AROUND) / AROUND,
               r = 3 + daft_cos(b);
        positions[i] = daft_v3((float)(r * daft_cos(a)), (float)daft_sin(b), (float)(r * daft_sin(a)));
        uint32_t right = i / AROUND * AROUND + (i + 1) % AROUND, up = (i + AROUND) % (AROUND * AROUND);
        uint32_t far = (right + AROUND) % (AROUND * AROUND);
        const uint32_t two[6] = {i, up, right, right, up, far};
        memcpy(indices + 6 * i, two, sizeof two);
    }
    daft_mesh_def def = {DAFT_COOKIE, positions, NULL, NULL, AROUND * AROUND, indices, 2 * AROUND * AROUND, NULL, NULL};
    return from_arrays(&def);
}

/* Normals are the same whatever fresh memory holds: of a torus, where no vertex has its corners listed, and of
 * sheets, where some or all have. */
static void fresh_memory_does_not_matter(void **unused)
{
    (void)unused;
    static const float bumps[] = {0, 0.05f, 3}; /* 0: the torus */
    for (size_t i = 0; i < DAFT_COUNT_OF(bumps); i++) {
        daft_trimesh mesh = i ? make_sheet(bumps[i]) : make_torus(), again = mesh;
        for (uint32_t word = 0; word < 10; word++) {
            uint32_t fill = word < 9 ? word : UINT32_MAX;
            daft_allocator allocator = {&fill, filled_allocate, filled_release};
            again.normals = NULL, again.normal_indices = NULL, again.normal_count = 0;
            assert_true(daft_trimesh_smooth(&allocator, &again, DAFT_SMOOTH_CREASE, NULL));
            if (word == 0) {
                daft_allocator counted = {&memory, counting_allocate, counting_release};
                assert_true(daft_trimesh_smooth(&counted, &mesh, DAFT_SMOOTH_CREASE, NULL));
            }
            assert_int_equal(again.normal_count, mesh.normal_count);
            assert_memory_equal(again.normals, mesh.normals, mesh.normal_count * sizeof *mesh.normals);
            assert_int_equal(!again.normal_indices, !mesh.normal_indices);
            free(again.normals);
            free(again.normal_indices);
        }
        free_mesh(&mesh);
    }
}

/* A cone of many triangles around one tip, with sharp folds at random places; a bow tie; an edge of three triangles. */
static void unusual_fans(void **unused)
{
    (void)unused;
    print_message("seed %llu\n", (unsigned long long)random_state);
    enum { FAN = 600 };
    static daft_vec3 positions[FAN + 1];
    static uint32_t indices[3 * FAN];
    static const uint32_t counts[] = {3, 5, 8, 9, 16, 17, 40, FAN};
    for (size_t k = 0; k < DAFT_COUNT_OF(counts); k++)
        for (int repeat = 0; repeat < (counts[k] < 50 ? 40 : 1); repeat++) {
            uint32_t count = counts[k];
            positions[0] = daft_v3(0, 1, 0);
            for (uint32_t i = 0; i < count; i++) {
                double angle = 2 * DAFT_PI * i / count, radius = 1 + random_below(4) * (random_below(4) == 0);
                positions[i + 1] =
                    daft_v3((float)(cos(angle) * radius), (float)random_below(2) / 4, (float)(-sin(angle) * radius));
                const uint32_t triangle[3] = {0, i + 1, (i + 1) % count + 1};
                memcpy(indices + 3 * i, triangle, sizeof triangle);
            }
            daft_mesh_def def = {DAFT_COOKIE, positions, NULL, NULL, count + 1, indices, count, NULL, NULL};
            daft_trimesh mesh = from_arrays(&def);
            check_against_twin(&mesh, (double)DAFT_SMOOTH_CREASE, count < 50 ? 1 : 97);
            free_mesh(&mesh);
        }
    daft_vec3 tie[] = {{0, 0, 0}, {1, 0, 0}, {1, 0, -1}, {-1, .1f, 0}, {-1, 0, 1}, {0, 1, 0}};
    uint32_t bow[] = {0, 1, 2, 0, 3, 4}, book[] = {0, 1, 2, 1, 0, 4, 0, 1, 5};
    daft_mesh_def def = {DAFT_COOKIE, tie, NULL, NULL, 6, bow, 2, NULL, NULL};
    daft_trimesh mesh = from_arrays(&def);
    check_against_twin(&mesh, (double)DAFT_SMOOTH_CREASE, 1);
    assert_int_equal(mesh.normal_count, 7); /* one of each vertex, used or not, and a second where the fans meet */
    free_mesh(&mesh);
    def.indices = book, def.triangle_count = 3;
    mesh = from_arrays(&def);
    check_against_twin(&mesh, (double)DAFT_SMOOTH_CREASE, 1);
    free_mesh(&mesh);
}

/* Flat cones of a and b sides with one tip: two sets, although all faces look the same way. */
static void check_nested_cones(uint32_t a, uint32_t b)
{
    daft_vec3 positions[32] = {{0, 1, 0}};
    uint32_t indices[96], count = 0;
    for (uint32_t ring = 0; ring < 2; ring++) {
        uint32_t sides = ring ? b : a, first = ring ? a + 1 : 1;
        for (uint32_t i = 0; i < sides; i++) {
            double angle = 2 * DAFT_PI * (i + 0.3 * ring) / sides, radius = 1 + ring;
            positions[first + i] =
                daft_v3((float)(cos(angle) * radius), 0.97f - 0.04f * (float)ring, (float)(-sin(angle) * radius));
            const uint32_t triangle[3] = {0, first + i, first + (i + 1) % sides};
            memcpy(indices + count, triangle, sizeof triangle);
            count += 3;
        }
    }
    positions[1].y -= 0.05f; /* not symmetric: the sets' normals differ */
    daft_mesh_def def = {DAFT_COOKIE, positions, NULL, NULL, a + b + 1, indices, count / 3, NULL, NULL};
    daft_trimesh mesh = from_arrays(&def);
    check_against_twin(&mesh, (double)DAFT_SMOOTH_CREASE, 1);
    assert_int_equal(mesh.normal_count, a + b + 2);
    free_mesh(&mesh);
}

/* What only touches at a vertex is not joined there, even where it lies in one plane. */
static void touching_is_not_joining(void **unused)
{
    (void)unused;
    for (uint32_t a = 3; a < 8; a++)
        for (uint32_t b = 3; b < 8; b++) check_nested_cones(a, b);
    daft_trimesh sheet = make_sheet(0.2f), board = sheet;
    uint32_t indices[6 * GRID * GRID], kept = 0;
    for (uint32_t i = 0; i < sheet.triangle_count; i++) { /* the black squares of a chessboard, two triangles each */
        uint32_t cell = i / 2;
        if ((cell % (GRID - 1) + cell / (GRID - 1)) % 2 == 0) continue;
        memcpy(indices + 3 * kept++, sheet.indices + 3 * i, 3 * sizeof *indices);
    }
    board.indices = indices, board.triangle_count = kept;
    board.normals = NULL, board.normal_indices = NULL;
    daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
    assert_true(daft_trimesh_smooth(&allocator, &board, DAFT_SMOOTH_CREASE, NULL));
    check_against_twin(&board, (double)DAFT_SMOOTH_CREASE, 1);
    daft_release(&allocator, board.normals);
    daft_release(&allocator, board.normal_indices);
    free_mesh(&sheet);
}

typedef struct smoothed {
    daft_smooth_sum sums[GRID * GRID];
    daft_vec3 normals[2 * GRID * GRID], directions[GRID * GRID];
    float angles[6 * GRID * GRID];
} smoothed;

static void smooth_with(int isa, const daft_trimesh *mesh, smoothed *out)
{
    memset(out, 0, sizeof *out);
    const daft_smooth_kernels *kernels = daft_smooth_kernels_for(isa);
    kernels->add_faces(mesh, (daft_smooth_faces){out->normals, out->angles}, out->sums);
    kernels->normalize(out->sums, mesh->vertex_count, out->directions);
}

static void every_instruction_set_gives_the_same_normals(void **unused)
{
    (void)unused;
    print_message("seed %llu\n", (unsigned long long)random_state);
    static smoothed first, other;
    for (int repeat = 0; repeat < 4; repeat++) {
        daft_trimesh mesh = make_sheet((float)repeat / 2);
        mesh.triangle_count -= random_below(40);                                          /* lanes left over */
        for (int i = 0; i < 20; i++) mesh.x[random_below(mesh.vertex_count)] = mesh.y[0]; /* slivers */
        smooth_with(0, &mesh, &first);
        for (int isa = 1; isa <= daft_isa_best(); isa++) {
            smooth_with(isa, &mesh, &other);
            if (memcmp(&first, &other, sizeof first) != 0) fail_msg("%s differs", daft_isa_name(isa));
        }
        free_mesh(&mesh);
    }
}

static void every_instruction_set_finds_the_same_rings(void **unused)
{
    (void)unused;
    enum { FAN = 9 };
    for (uint32_t repeat = 0; repeat < 3000; repeat++) {
        uint32_t count = 1 + random_below(FAN), indices[3 * FAN], groups[FAN], corners[FAN + DAFT_SMOOTH_AHEAD] = {0};
        uint32_t first[FAN + 3] = {0}, splits = random_below(3);
        daft_vec3 normals[FAN];
        for (uint32_t i = 0; i < count; i++) { /* a fan around vertex 0, or several, or what is none */
            uint32_t next = (i + 1) % count;
            if (splits && random_below(6) == 0) next = random_below(count);
            const uint32_t triangle[3] = {0, i + 1, next + 1};
            for (uint32_t k = 0; k < 3; k++) indices[3 * i + k] = triangle[(k + repeat % 3) % 3];
            corners[i] = 3 * i + (3 - repeat % 3) % 3;
            groups[i] = random_below(12) > 0;
            normals[i] = daft_v3(random_below(10) == 0 ? 1 : 0, 1, 0);
        }
        for (uint32_t i = 1; i < FAN + 3; i++) first[i] = count;
        daft_trimesh mesh = {.vertex_count = count + 1, .triangle_count = count, .indices = indices};
        uint8_t listed[2][FAN + 2];
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            uint8_t *mine = listed[isa != 0];
            memset(mine, 1, FAN + 2);
            daft_smooth_lists lists = {mine, first, corners};
            daft_smooth_kernels_for(isa)->unlist_rings(&mesh, normals, repeat % 2 ? groups : NULL, 0.9f, &lists, 0, 1);
            assert_int_equal(mine[0], listed[0][0]);
        }
        /* The walk, one triangle after the other. */
        uint32_t at = 0, passed = 0, creases = 0;
        do {
            uint32_t to = count, hits = 0, previous = indices[3 * at + (corners[at] % 3 + 2) % 3];
            for (uint32_t j = 0; j < count; j++)
                if (indices[3 * j + (corners[j] % 3 + 1) % 3] == previous) to = j, hits++;
            if (hits != 1) break;
            bool same_group = !(repeat % 2) || (groups[at] == groups[to] && groups[at]);
            creases += !(daft_dot(normals[at], normals[to]) > 0.9f && same_group);
            at = to;
        } while (++passed < count && at != 0);
        bool ring = passed == count && at == 0 && creases <= 1 && count <= DAFT_SMOOTH_RING;
        assert_int_equal(listed[0][0], !ring);
    }
}

static void bounds_are_those_of_the_triangles(void **unused)
{
    (void)unused;
    daft_vec3 positions[] = {{1, 2, 3}, {4, 2, 3}, {1, 5, -2}, {100, 3, 0}, {2, -50, 1}, {2, 3, 0}};
    uint32_t indices[] = {0, 1, 2, 5, 2, 1};
    daft_mesh_def def = {DAFT_COOKIE, positions, NULL, NULL, 6, indices, 2, NULL, NULL};
    daft_trimesh mesh = from_arrays(&def);
    assert_true(mesh.low.x == 1 && mesh.low.y == 2 && mesh.low.z == -2);
    assert_true(mesh.high.x == 4 && mesh.high.y == 5 && mesh.high.z == 3);
    free_mesh(&mesh);
    for (int repeat = 0; repeat < 200; repeat++) {
        uint32_t count = 3 + random_below(30), used[90], corners = 3 * (1 + random_below(29));
        daft_vec3 points[33], low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
        for (uint32_t i = 0; i < count; i++)
            points[i] = daft_v3((float)random_below(9) - 4, -(float)random_below(5), (float)random_below(100));
        for (uint32_t i = 0; i < corners; i++) used[i] = (i % 3 + random_below(count / 3) * 3) % count;
        def.positions = points, def.vertex_count = count, def.indices = used, def.triangle_count = corners / 3;
        mesh = from_arrays(&def);
        for (uint32_t i = 0; i < 3 * mesh.triangle_count; i++) {
            low = daft_min3(low, points[mesh.indices[i]]);
            high = daft_max3(high, points[mesh.indices[i]]);
        }
        assert_memory_equal(&mesh.low, &low, sizeof low);
        assert_memory_equal(&mesh.high, &high, sizeof high);
        free_mesh(&mesh);
    }
}

static void normals_do_not_depend_on_scale(void **unused)
{
    (void)unused;
    daft_trimesh mesh = make_sheet(1);
    counting keep = memory;
    for (int power = -20; power <= 20; power += 8) {
        daft_trimesh scaled = mesh;
        scaled.normals = NULL, scaled.normal_indices = NULL;
        float x[GRID * GRID], y[GRID * GRID], z[GRID * GRID];
        for (int i = 0; i < GRID * GRID; i++)
            x[i] = ldexpf(mesh.x[i], power), y[i] = ldexpf(mesh.y[i], power), z[i] = ldexpf(mesh.z[i], power);
        scaled.x = x, scaled.y = y, scaled.z = z;
        daft_allocator allocator = counting_allocator(&memory);
        assert_true(daft_trimesh_smooth(&allocator, &scaled, DAFT_SMOOTH_CREASE, NULL));
        assert_int_equal(scaled.normal_count, mesh.normal_count);
        assert_memory_equal(scaled.normals, mesh.normals, mesh.normal_count * sizeof(daft_vec3));
        daft_release(&allocator, scaled.normals);
        daft_release(&allocator, scaled.normal_indices);
    }
    memory = keep;
    free_mesh(&mesh);
}

static void slivers_get_some_unit_normal(void **unused)
{
    (void)unused;
    daft_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 0}, {1, 1, 0}};
    uint32_t indices[] = {0, 1, 2, 0, 3, 1, 1, 2, 4};
    daft_mesh_def def = {DAFT_COOKIE, positions, NULL, NULL, 5, indices, 3, NULL, NULL};
    daft_trimesh mesh = from_arrays(&def);
    assert_int_equal(mesh.triangle_count, 3);
    for (uint32_t i = 0; i < mesh.normal_count; i++) assert_true(fabsf(daft_length(mesh.normals[i]) - 1) < 1e-6f);
    assert_true(normal_at(&mesh, 8).z == 1);
    free_mesh(&mesh);
}

static void memory_may_run_out_anywhere(void **unused)
{
    (void)unused;
    daft_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
              normals[4] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    daft_vec2 uvs[4] = {{0, 0}};
    uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    for (int kind = 0; kind < 3; kind++)
        for (long fail_at = 0;; fail_at++) {
            daft_allocator allocator = counting_allocator(&memory);
            memory.fail_at = fail_at;
            daft_mesh_def def = {DAFT_COOKIE, positions, kind == 1 ? normals : NULL, uvs, 4, indices, 2, NULL, NULL};
            daft_trimesh mesh;
            daft_error error;
            bool made = kind == 2 ? daft_trimesh_box(&allocator, daft_v3(1, 1, 1), &mesh, &error)
                                  : daft_trimesh_from_arrays(&allocator, &def, NULL, &mesh, &error);
            if (made) daft_trimesh_free(&allocator, &mesh);
            assert_int_equal(memory.live, 0);
            if (!made) assert_int_equal(error.code, DAFT_ERROR_MEMORY);
            if (memory.calls <= fail_at) break;
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_are_copied),
        cmocka_unit_test(wrong_arrays_are_refused),
        cmocka_unit_test(a_box_is_right_on_every_side),
        cmocka_unit_test(touching_is_not_joining),
        cmocka_unit_test(every_instruction_set_gives_the_same_normals),
        cmocka_unit_test(every_instruction_set_finds_the_same_rings),
        cmocka_unit_test(bounds_are_those_of_the_triangles),
        cmocka_unit_test(smooth_normals_agree_with_the_twin),
        cmocka_unit_test(fresh_memory_does_not_matter),
        cmocka_unit_test(unusual_fans),
        cmocka_unit_test(normals_do_not_depend_on_scale),
        cmocka_unit_test(slivers_get_some_unit_normal),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
