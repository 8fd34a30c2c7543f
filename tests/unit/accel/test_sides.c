/* One-sided triangles: no ray from outside a mesh meets the back of one first, by brute force over all triangles, with the
 * corners as they are and as moving them rounds them; and what a node's cone says of its triangles holds for each. */
#include "fixtures.h"

#include "accel/sides.h"
#include "geometry/adjacency.h"
#include "geometry/trimesh.h"
#include "math/exact.h"
#include "raster/raster.h"

/* ---- shapes ---- */

typedef struct sheet {
    daft_vec3 *positions;
    uint32_t *indices;
    uint32_t vertices, triangles;
} sheet;

static sheet sheet_make(uint32_t vertices, uint32_t triangles)
{
    return (sheet){malloc(vertices * sizeof(daft_vec3)), malloc(3 * triangles * sizeof(uint32_t)), 0, 0};
}

static fixture_mesh sheet_finish(sheet *s)
{
    fixture_mesh out = mesh_make(s->positions, s->vertices, s->indices, s->triangles);
    free(s->positions), free(s->indices);
    return out;
}

/* Appends a mesh, moved, scaled, and turned inside out. */
static void sheet_add(sheet *s, const daft_trimesh *mesh, float scale, daft_vec3 by, bool inside_out)
{
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++)
        s->indices[3 * s->triangles + i] = s->vertices + mesh->indices[inside_out ? i / 3 * 3 + 2 - i % 3 : i];
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        s->positions[s->vertices++] = daft_add(daft_scale(daft_v3(mesh->x[i], mesh->y[i], mesh->z[i]), scale), by);
    s->triangles += mesh->triangle_count;
}

/* A second copy of what is there, as above. */
static fixture_mesh twice(const fixture_mesh *m, float scale, daft_vec3 by, bool inside_out)
{
    sheet s = sheet_make(2 * m->mesh.vertex_count, 2 * m->mesh.triangle_count);
    sheet_add(&s, &m->mesh, 1, daft_v3(0, 0, 0), false);
    sheet_add(&s, &m->mesh, scale, by, inside_out);
    return sheet_finish(&s);
}

/* A tube of radius `tube` around a circle of radius 1, outwards: over 1, it crosses itself. */
static fixture_mesh mesh_torus(uint32_t rows, uint32_t columns, float tube)
{
    sheet s = sheet_make(rows * columns, 2 * rows * columns);
    for (uint32_t i = 0; i < rows; i++)
        for (uint32_t j = 0; j < columns; j++) {
            double a = 2 * DAFT_PI * i / rows, b = 2 * DAFT_PI * j / columns, r = 1 + (double)tube * daft_cos(a);
            s.positions[s.vertices++] = daft_v3((float)(r * daft_cos(b)), (float)((double)tube * daft_sin(a)), (float)(r * daft_sin(b)));
            uint32_t k = (i + 1) % rows * columns, l = (j + 1) % columns;
            const uint32_t quad[6] = {i * columns + j, k + j, k + l, i * columns + j, k + l, i * columns + l};
            memcpy(s.indices + 3 * s.triangles, quad, sizeof quad);
            s.triangles += 2;
        }
    return sheet_finish(&s);
}

/* An eight on end: a prism whose outline crosses itself, so that one half is inside out. */
static fixture_mesh mesh_eight(uint32_t columns)
{
    sheet s = sheet_make(2 * columns + 2, 4 * columns);
    for (uint32_t j = 0; j < columns; j++) {
        double a = 2 * DAFT_PI * (j + 0.5) / columns;
        for (int side = 0; side < 2; side++)
            s.positions[s.vertices++] = daft_v3((float)daft_sin(a), side ? 0.5f : -0.5f, (float)(daft_sin(a) * daft_cos(a)));
        uint32_t b = 2 * j, c = 2 * ((j + 1) % columns), low = 2 * columns, high = low + 1;
        const uint32_t four[12] = {b, b + 1, c + 1, b, c + 1, c, low, b, c, high, c + 1, b + 1};
        memcpy(s.indices + 3 * s.triangles, four, sizeof four);
        s.triangles += 4;
    }
    s.positions[s.vertices++] = daft_v3(0.1f, -0.5f, 0), s.positions[s.vertices++] = daft_v3(0.1f, 0.5f, 0);
    return sheet_finish(&s);
}

static fixture_mesh without_triangle(const fixture_mesh *m, uint32_t gone)
{
    sheet s = sheet_make(m->mesh.vertex_count, m->mesh.triangle_count);
    sheet_add(&s, &m->mesh, 1, daft_v3(0, 0, 0), false);
    memmove(s.indices + 3 * gone, s.indices + 3 * --s.triangles, 3 * sizeof *s.indices);
    return sheet_finish(&s);
}

static fixture_mesh copy_of(const fixture_mesh *m, bool inside_out)
{
    sheet s = sheet_make(m->mesh.vertex_count, m->mesh.triangle_count);
    sheet_add(&s, &m->mesh, 1, daft_v3(0, 0, 0), inside_out);
    return sheet_finish(&s);
}

/* ---- brute force ---- */

static uint32_t one_sided_of(fixture_mesh *m)
{
    return daft_bvh_find_sides(m->bvh, &m->mesh, 1) ? m->bvh->sides->count : 0;
}

typedef struct first_hit {
    uint32_t triangle; /* DAFT_NO_TRIANGLE: none */
    int sign;          /* of its corners' determinant */
} first_hit;

static daft_vec3 corner_at(const daft_trimesh *mesh, const daft_affine *map, uint32_t triangle, uint32_t k)
{
    uint32_t v = mesh->indices[3 * triangle + k];
    return daft_affine_point(map, daft_v3(mesh->x[v], mesh->y[v], mesh->z[v]));
}

/* The first triangle that the ray d from the origin meets; `fronts`: of those seen from their front and of two sides. */
static first_hit first_of(const fixture_mesh *m, const daft_affine *map, daft_vec3 d, int front)
{
    first_hit first = {DAFT_NO_TRIANGLE, 0};
    double nearest = INFINITY;
    for (uint32_t i = 0; i < m->mesh.triangle_count; i++) {
        daft_vec3 a = corner_at(&m->mesh, map, i, 0), b = corner_at(&m->mesh, map, i, 1), c = corner_at(&m->mesh, map, i, 2);
        if (!daft_pencil_hits(a, b, c, d)) continue;
        double z = daft_pencil_depth(a, b, c, d);
        int sign = daft_det_sign(a, b, c);
        if (!(z > 0) || z >= nearest || (front && sign != front && daft_is_one_sided(m->bvh->sides, i))) continue;
        nearest = z, first = (first_hit){i, sign};
    }
    return first;
}

static daft_vec3 random_unit(void)
{
    daft_vec3 v;
    do v = random_vec3(-1, 1);
    while (daft_dot(v, v) > 1 || daft_dot(v, v) < 0.01f);
    return daft_normalize(v);
}

/* Puts the mesh before the origin, somewhere along +z, its camera outside or, seldom, inside. */
static daft_affine random_map(float far)
{
    daft_vec3 scale = daft_v3(random_float(0.3f, 3), random_float(0.3f, 3), random_float(0.3f, 3));
    if (random_bits() & 1) scale.x = -scale.x;
    float distance = random_float(1, far);
    return affine_make(random_rotation(), scale, daft_v3(random_float(-1, 1), random_float(-1, 1), distance));
}

/* Rays towards the mesh from outside; gives how many met it. */
static uint32_t check_rays(const fixture_mesh *m, uint32_t rays, const char *name)
{
    uint32_t met = 0;
    for (uint32_t i = 0; i < rays; i++) {
        daft_affine map = random_map(i % 3 ? 8 : 3000);
        daft_outlook outlook;
        int front;
        if (!daft_outlook_from(m->bvh, &m->mesh, &map, &outlook, &front)) continue;
        daft_vec3 to = corner_at(&m->mesh, &map, random_bits() % m->mesh.triangle_count, random_bits() % 3);
        float aside = random_bits() % 4 ? 0.1f : 0.001f;
        daft_vec3 d = daft_add(to, random_vec3(-aside, aside));
        if (!(d.z > 0)) continue;
        first_hit first = first_of(m, &map, d, 0), other = first_of(m, &map, d, front);
        if (first.triangle != other.triangle)
            fail_msg("%s: the ray (%a, %a, %a), number %u, first meets the back of triangle %u, then %u", name, (double)d.x, (double)d.y,
                     (double)d.z, i, first.triangle, other.triangle);
        met += first.triangle != DAFT_NO_TRIANGLE;
    }
    return met;
}

static void check_shape(fixture_mesh *m, uint32_t least, uint32_t most, const char *name)
{
    uint32_t count = one_sided_of(m);
    if (count < least || count > most)
        fail_msg("%s: %u of %u triangles are one-sided; %u to %u should be", name, count, m->mesh.triangle_count, least, most);
    if (count) assert_true(check_rays(m, 1500, name) > 500);
}

static void closed_shapes(void **unused)
{
    (void)unused;
    fixture_seed(31);
    daft_allocator allocator = daft_malloc_allocator();
    daft_error error = {0};
    fixture_mesh box, ball = mesh_ball(9, 1, 0.1f), torus = mesh_torus(12, 24, 0.4f);
    assert_true(daft_trimesh_box(&allocator, daft_v3(1, 2, 3), &box.mesh, &error));
    box.bvh = daft_bvh_build_mesh(&allocator, &box.mesh, 1, &error);
    check_shape(&box, 12, 12, "box");
    check_shape(&ball, ball.mesh.triangle_count, ball.mesh.triangle_count, "ball");
    check_shape(&torus, torus.mesh.triangle_count, torus.mesh.triangle_count, "torus");
    fixture_mesh turned = copy_of(&ball, true);
    check_shape(&turned, 0, 0, "ball inside out"); /* its backs are what is seen */
    mesh_drop(&box), mesh_drop(&ball), mesh_drop(&torus), mesh_drop(&turned);
}

static void shapes_of_two(void **unused)
{
    (void)unused;
    fixture_seed(32);
    fixture_mesh ball = mesh_ball(8, 1, 0.05f);
    uint32_t n = ball.mesh.triangle_count;
    const struct {
        const char *name;
        float scale;
        daft_vec3 by;
        bool inside_out;
        uint32_t least, most;
    } cases[] = {{"one in the other", 0.5f, {0, 0, 0}, false, 2 * n, 2 * n},
                 {"a hollow", 0.5f, {0, 0, 0}, true, 2 * n, 2 * n},
                 {"side by side", 1, {3, 0, 0}, false, 2 * n, 2 * n},
                 {"side by side, one inside out", 1, {3, 0, 0}, true, n, n},
                 {"through each other", 1, {0.7f, 0.1f, 0}, false, n, 2 * n - 40},
                 {"through each other, one inside out", 1, {0.7f, 0.1f, 0}, true, n / 4, n + n / 2},
                 {"the same again", 1, {0, 0, 0}, false, 0, 0},
                 {"the same again, inside out", 1, {0, 0, 0}, true, 0, 0},
                 {"a hair's breadth off", 1, {1e-6f, 0, 0}, false, 0, n}};
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        fixture_mesh both = twice(&ball, cases[i].scale, cases[i].by, cases[i].inside_out);
        check_shape(&both, cases[i].least, cases[i].most, cases[i].name);
        mesh_drop(&both);
    }
    mesh_drop(&ball);
}

static void crossing_shapes(void **unused)
{
    (void)unused;
    fixture_seed(33);
    fixture_mesh spindle = mesh_torus(24, 32, 1.6f), eight = mesh_eight(40);
    uint32_t n = spindle.mesh.triangle_count;
    check_shape(&spindle, n / 2, n - 1, "spindle torus");
    check_shape(&eight, 1, eight.mesh.triangle_count - 40, "eight");
    mesh_drop(&spindle), mesh_drop(&eight);
    for (int round = 0; round < 6; round++) { /* bumps so high that the surface folds over itself */
        fixture_mesh wild = mesh_ball(10, 1, 0.9f);
        uint32_t count = one_sided_of(&wild);
        if (count) check_rays(&wild, 600, "wild ball");
        mesh_drop(&wild);
    }
}

static void odd_shapes(void **unused)
{
    (void)unused;
    fixture_seed(34);
    fixture_mesh ball = mesh_ball(8, 1, 0), holed = without_triangle(&ball, 17), soup = mesh_soup(200, 1, 0.5f);
    check_shape(&holed, 0, 0, "a hole");
    check_shape(&soup, 0, 0, "soup");
    /* Each triangle stands alone, with corners of its own: places make it whole. */
    sheet s = sheet_make(3 * ball.mesh.triangle_count + 3, 4 * ball.mesh.triangle_count);
    for (uint32_t i = 0; i < 3 * ball.mesh.triangle_count; i++) {
        uint32_t v = ball.mesh.indices[i];
        s.indices[i] = i;
        s.positions[s.vertices++] = daft_v3(ball.mesh.x[v], ball.mesh.y[v], ball.mesh.z[v]);
    }
    s.triangles = ball.mesh.triangle_count;
    /* and one whose corners are in two places: no ray meets it */
    const uint32_t none[3] = {s.indices[0], s.indices[1], s.vertices};
    s.positions[s.vertices++] = s.positions[none[0]];
    memcpy(s.indices + 3 * s.triangles++, none, sizeof none);
    fixture_mesh apart = sheet_finish(&s);
    check_shape(&apart, ball.mesh.triangle_count + 1, ball.mesh.triangle_count + 1, "triangles with corners of their own");
    mesh_drop(&ball), mesh_drop(&holed), mesh_drop(&soup), mesh_drop(&apart);
}

/* ---- cones ---- */

static uint32_t check_below(const fixture_mesh *m, const daft_affine *map, uint32_t child, int front)
{
    uint32_t count = 0;
    if (!(child & DAFT_CHILD_LEAF)) {
        for (int i = 0; i < DAFT_WIDTH; i++)
            if (m->bvh->nodes.items[child].child[i] != DAFT_CHILD_NONE)
                count += check_below(m, map, m->bvh->nodes.items[child].child[i], front);
        return count;
    }
    for (uint32_t i = 0; i < ((child & 3) + 1) * DAFT_BLOCK; i++) {
        uint32_t triangle = m->bvh->blocks[((child & ~DAFT_CHILD_LEAF) >> 2) + i / DAFT_BLOCK].triangle[i % DAFT_BLOCK];
        if (triangle == DAFT_NO_TRIANGLE) continue;
        count++;
        assert_true(daft_is_one_sided(m->bvh->sides, triangle));
        assert_int_equal(daft_det_sign(corner_at(&m->mesh, map, triangle, 0), corner_at(&m->mesh, map, triangle, 1),
                                       corner_at(&m->mesh, map, triangle, 2)), -front);
    }
    return count;
}

/* Gives how many triangles are left out, each as often as it or a child says so. */
static uint32_t check_cones(const fixture_mesh *m, float far)
{
    uint32_t count = 0;
    daft_affine map = random_map(far);
    daft_outlook outlook;
    int front;
    if (!daft_outlook_from(m->bvh, &m->mesh, &map, &outlook, &front)) return 0;
    daft_glance glance = daft_glance_of(m->bvh->sides, &outlook);
    for (size_t n = 0; n < m->bvh->nodes.count; n++) {
        uint32_t away = daft_cones_away(&m->bvh->sides->cones[n], &glance);
        for (int i = 0; i < DAFT_WIDTH; i++)
            if (away >> i & 1) count += check_below(m, &map, m->bvh->nodes.items[n].child[i], front);
    }
    return count;
}

static uint32_t check_sun(const fixture_mesh *m)
{
    uint32_t count = 0;
    daft_vec3 direction = daft_scale(random_unit(), random_float(0.01f, 100));
    daft_outlook outlook = daft_outlook_along(daft_to_double(direction), 0);
    const daft_trimesh *mesh = &m->mesh;
    daft_glance glance = daft_glance_of(m->bvh->sides, &outlook);
    for (size_t b = 0; b < m->bvh->nodes.count; b++) {
        uint32_t away = daft_cones_away(&m->bvh->sides->cones[b], &glance);
        for (int i = 0; i < DAFT_WIDTH; i++) {
            uint32_t child = m->bvh->nodes.items[b].child[i];
            if (!(away >> i & 1) || !(child & DAFT_CHILD_LEAF)) continue;
            uint32_t block = (child & ~DAFT_CHILD_LEAF) >> 2, triangle = m->bvh->blocks[block].triangle[0];
            const uint32_t *v = &mesh->indices[3 * triangle];
            daft_dvec3 p[3];
            for (int k = 0; k < 3; k++) p[k] = daft_dv3((double)mesh->x[v[k]], (double)mesh->y[v[k]], (double)mesh->z[v[k]]);
            daft_dvec3 normal = daft_dcross(daft_dsub(p[1], p[0]), daft_dsub(p[2], p[0]));
            assert_true(daft_ddot(normal, daft_to_double(direction)) < 0);
            count++;
        }
    }
    return count;
}

static void cones(void **unused)
{
    (void)unused;
    fixture_seed(35);
    fixture_mesh shapes[4] = {mesh_ball(40, 1, 0.01f), mesh_ball(12, 1, 0.2f), mesh_torus(40, 90, 0.3f), mesh_torus(24, 32, 1.6f)};
    uint64_t near = 0, far = 0, sun = 0;
    for (int s = 0; s < 4; s++) {
        assert_true(one_sided_of(&shapes[s]) > 0);
        for (int round = 0; round < 200; round++) {
            near += check_cones(&shapes[s], 6), far += check_cones(&shapes[s], 20000), sun += check_sun(&shapes[s]);
        }
        mesh_drop(&shapes[s]);
    }
    print_message("%llu triangles left out near by, %llu far off, leaves that look away from suns: %llu\n", (unsigned long long)near,
                  (unsigned long long)far, (unsigned long long)sun);
    assert_true(near > 1000000 && far > 100000 && sun > 10000);
}

/* ---- pictures ---- */

enum { WIDTH = 90, HEIGHT = 70 };

typedef struct picture {
    uint32_t instance[WIDTH * HEIGHT], triangle[WIDTH * HEIGHT];
} picture;

/* isa < 0: the reference path. */
static void see(const daft_instance *instances, uint32_t count, int isa, picture *out)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_raster raster;
    daft_error error = {0};
    daft_arena arena;
    daft_arena_init(&arena, &allocator);
    const daft_pencil pencil = {.right = {1, 0, 0}, .up = {0, 1, 0}, .forward = {0, 0, -1}, .focal = 40, .width = WIDTH, .height = HEIGHT};
    assert_true(daft_raster_init(&raster, &allocator, 1, daft_isa_best(), &error) && daft_raster_begin(&raster, &pencil, instances, count, &error));
    const daft_tlas *tlas = daft_tlas_build(&arena, instances, count, &error);
    daft_tile *tile = malloc(sizeof *tile);
    for (uint32_t i = 0; i < raster.work_count; i++) daft_raster_bin(&raster, i, 0);
    for (uint32_t i = 0; i < (uint32_t)(raster.tiles_x * raster.tiles_y); i++) {
        if (isa >= 0)
            daft_raster_kernels_for(isa)->tile(&raster, i, 0, tile);
        else
            daft_reference_tile(&raster, tlas, i, tile);
        for (int at = 0; at < tile->width * tile->height; at++) {
            int x = at % tile->width, y = at / tile->width, to = (tile->y + y) * WIDTH + tile->x + x;
            out->instance[to] = tile->instance[y * DAFT_TILE_STRIDE + x], out->triangle[to] = tile->triangle[y * DAFT_TILE_STRIDE + x];
        }
    }
    free(tile);
    daft_raster_free(&raster);
    daft_arena_free(&arena);
}

/* Things around the camera, some of them turned over by a mirroring map, some that hold the camera. */
static uint32_t place_all(const fixture_mesh *shapes, int shape_count, daft_instance *out, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        daft_vec3 scale = daft_v3(random_float(0.5f, 2), random_float(0.5f, 2), i % 3 ? 1 : -1);
        daft_vec3 at = i == 0 ? daft_v3(0.2f, 0.1f, -0.3f) : daft_v3(random_float(-6, 6), random_float(-5, 5), random_float(-12, 1));
        out[i] = instance_make(&shapes[(int)i % shape_count], affine_make(random_rotation(), scale, at));
    }
    return count;
}

/* The same picture whether or not sides are known, in either path and on every instruction set. */
static void pictures(void **unused)
{
    (void)unused;
    fixture_seed(42);
    enum { THINGS = 24 };
    daft_instance things[THINGS];
    static picture plain, reference, pencil;
    fixture_mesh shapes[4] = {mesh_ball(30, 1, 0.01f), mesh_ball(8, 1, 0.5f), mesh_torus(24, 32, 1.6f), mesh_torus(12, 30, 0.4f)};
    for (int round = 0; round < 6; round++) {
        for (int s = 0; s < 4; s++) {
            daft_bvh_free(shapes[s].bvh);
            daft_allocator allocator = daft_malloc_allocator();
            shapes[s].bvh = daft_bvh_build_mesh(&allocator, &shapes[s].mesh, 1, NULL);
        }
        uint32_t count = place_all(shapes, 4, things, THINGS);
        see(things, count, -1, &plain);
        for (int s = 0; s < 4; s++) assert_true(one_sided_of(&shapes[s]) > 0);
        see(things, count, -1, &reference);
        assert_memory_equal(&plain, &reference, sizeof plain);
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            see(things, count, isa, &pencil);
            assert_memory_equal(&pencil, &reference, sizeof pencil);
        }
    }
    for (int s = 0; s < 4; s++) mesh_drop(&shapes[s]);
}

/* ---- the whole ---- */

static void same_for_all_threads(void **unused)
{
    (void)unused;
    fixture_seed(36);
    fixture_mesh ball = mesh_ball(60, 1, 0.01f), one = twice(&ball, 1, daft_v3(0.8f, 0.2f, 0), false), three = copy_of(&one, false);
    assert_true(daft_bvh_find_sides(one.bvh, &one.mesh, 1) && daft_bvh_find_sides(three.bvh, &three.mesh, 3));
    const daft_sides *a = one.bvh->sides, *b = three.bvh->sides;
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->triangles, b->triangles, (one.mesh.triangle_count + 31) / 32 * sizeof(uint32_t));
    assert_memory_equal(a->blocks, b->blocks, one.bvh->block_count);
    assert_int_equal(a->patches.level[0].count, b->patches.level[0].count);
    assert_memory_equal(a->patches.items, b->patches.items, a->patches.level[0].count * sizeof *a->patches.items);
    assert_memory_equal(a->cones, b->cones, one.bvh->nodes.count * sizeof(daft_cones));
    mesh_drop(&ball), mesh_drop(&one), mesh_drop(&three);
}

static void gone_when_moved(void **unused)
{
    (void)unused;
    fixture_seed(38);
    fixture_mesh ball = mesh_ball(12, 1, 0);
    size_t before = daft_bvh_bytes(ball.bvh);
    assert_true(one_sided_of(&ball) > 0 && daft_bvh_bytes(ball.bvh) > before);
    for (uint32_t i = 0; i < ball.mesh.vertex_count; i++) ball.mesh.y[i] += ball.mesh.x[i];
    daft_bvh_update(ball.bvh, &ball.mesh, &(daft_bvh_def){.threads = 1});
    assert_null(ball.bvh->sides);
    assert_true(daft_bvh_bytes(ball.bvh) == before && one_sided_of(&ball) == ball.mesh.triangle_count);
    mesh_drop(&ball);
}

typedef struct counted {
    long live, calls, fail_at;
} counted;

static void *counted_allocate(void *user, size_t size, size_t alignment)
{
    counted *c = user;
    if (c->calls++ == c->fail_at) return NULL;
    daft_allocator plain = daft_malloc_allocator();
    c->live++;
    return plain.allocate(plain.user, size, alignment);
}

static void counted_release(void *user, void *pointer)
{
    daft_allocator plain = daft_malloc_allocator();
    if (pointer) ((counted *)user)->live--;
    plain.release(plain.user, pointer);
}

static void without_memory(void **unused)
{
    (void)unused;
    fixture_seed(39);
    fixture_mesh ball = mesh_ball(12, 1, 0);
    counted memory = {.fail_at = -1};
    ball.bvh->allocator = (daft_allocator){&memory, counted_allocate, counted_release};
    for (long fail_at = 0;; fail_at++) {
        memory.calls = 0, memory.fail_at = fail_at;
        bool found = daft_bvh_find_sides(ball.bvh, &ball.mesh, 1);
        assert_int_equal(found, ball.bvh->sides != NULL);
        if (found) break;
        assert_int_equal(memory.live, 0);
    }
    assert_true(memory.calls > 10);
    ball.bvh->allocator = daft_malloc_allocator();
    mesh_drop(&ball);
}

/* Crowded, touching and turned over: done soon, whatever it says. */
static void hostile(void **unused)
{
    (void)unused;
    fixture_seed(40);
    enum { MANY = 20000 };
    for (int kind = 0; kind < 3; kind++) {
        sheet s = sheet_make(4 * MANY, 4 * MANY);
        for (uint32_t i = 0; i < MANY; i++) {
            float size = kind == 2 ? 1 + (float)i * 0x1p-14f : 1;
            const daft_vec3 p[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
            static const uint32_t faces[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, flat[6] = {0, 1, 2, 0, 2, 1};
            uint32_t base = s.vertices, corners = kind == 0 ? 6 : 12;
            for (int k = 0; k < 4; k++) s.positions[s.vertices++] = daft_scale(daft_add(p[k], daft_v3(-0.25f, -0.25f, -0.25f)), size);
            for (uint32_t k = 0; k < corners; k++) s.indices[3 * s.triangles + k] = base + (kind == 0 ? flat[k] : faces[k]);
            s.triangles += corners / 3;
        }
        fixture_mesh mesh = sheet_finish(&s);
        uint32_t count = one_sided_of(&mesh);
        if (kind < 2) assert_int_equal(count, 0);
        mesh_drop(&mesh);
    }
}

static void fan_around_an_edge(void **unused)
{
    (void)unused;
    enum { MANY = 3000 };
    sheet s = sheet_make(MANY + 2, 2 * MANY); /* a cone with a flat bottom: two vertices with very many triangles */
    s.positions[s.vertices++] = daft_v3(0, 1, 0), s.positions[s.vertices++] = daft_v3(0, 0, 0);
    for (uint32_t i = 0; i < MANY; i++) {
        double a = 2 * DAFT_PI * i / MANY;
        uint32_t next = 2 + (i + 1) % MANY;
        s.positions[s.vertices++] = daft_v3((float)daft_cos(a), 0, (float)daft_sin(a));
        const uint32_t two[6] = {0, next, 2 + i, 1, 2 + i, next};
        memcpy(s.indices + 3 * s.triangles, two, sizeof two);
        s.triangles += 2;
    }
    fixture_mesh cone = sheet_finish(&s);
    daft_allocator allocator = daft_malloc_allocator();
    daft_adjacency adjacency;
    assert_true(daft_adjacency_make(&allocator, &cone.mesh, &adjacency));
    assert_true(adjacency.closed);
    for (uint32_t i = 0; i < 3 * cone.mesh.triangle_count; i++) assert_true(adjacency.across[i] < cone.mesh.triangle_count);
    daft_adjacency_free(&allocator, &adjacency);
    one_sided_of(&cone);
    mesh_drop(&cone);
}

/* The scanned meshes that most scenes are made of here. */
static void models(void **unused)
{
    (void)unused;
    fixture_seed(41);
    daft_allocator allocator = daft_malloc_allocator();
    const char *folder = getenv("DAFT_DATA");
    char path[1024];
    snprintf(path, sizeof path, "%s/models/cow.obj", folder ? folder : DAFT_ROOT "/../shared/data");
    daft_obj obj;
    if (!daft_obj_load(&allocator, path, NULL, &obj, NULL)) skip();
    fixture_mesh cow = {obj.mesh, daft_bvh_build_mesh(&allocator, &obj.mesh, 1, NULL)};
    check_shape(&cow, cow.mesh.triangle_count * 95 / 100, cow.mesh.triangle_count, "cow");
    for (int round = 0; round < 50; round++) check_cones(&cow, 10), check_cones(&cow, 1000);
    daft_bvh_free(cow.bvh);
    daft_obj_free(&allocator, &obj);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_shapes), cmocka_unit_test(shapes_of_two), cmocka_unit_test(crossing_shapes), cmocka_unit_test(odd_shapes),
        cmocka_unit_test(cones), cmocka_unit_test(pictures), cmocka_unit_test(same_for_all_threads),
        cmocka_unit_test(gone_when_moved), cmocka_unit_test(without_memory), cmocka_unit_test(hostile),
        cmocka_unit_test(fan_around_an_edge), cmocka_unit_test(models),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
