/* Surfaces: points, normals and shadow origins of a tile's pixels against each pixel's ray tested alone with what it
 * sees, in double; of rays that were followed, the same; and every instruction set gives the same bits. */
#include "fixtures.h"

#include "render/internal.h"

DAFT_KERNEL_DECLARE(daft_render_kernels, daft_render);
static const daft_render_kernels *kernels(int isa)
{
    static const daft_render_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_render);
    return TABLE[isa];
}

enum { WIDTH = 150, HEIGHT = 90, INSTANCES = 24 };

typedef struct stage {
    fixture_mesh soup, ball;
    daft_instance instances[INSTANCES];
    daft_surface materials[3];
    daft_snapshot snapshot;
    daft_pencil pencil;
    daft_allocator allocator;
    daft_raster raster;
    daft_tile tile;
    daft_facets facets;
    daft_batch points[DAFT_ISA_COUNT];
    daft_ray_batch sky, rays;
} stage;

/* Matte; glossy, which asks for the direction to the viewer; mirroring, which asks for all that rays need. */
static const uint32_t MATERIALS[3] = {0, 1, 2};

static stage *stage_make(uint32_t kinds)
{
    stage *s = aligned_alloc(64, (sizeof *s + 63) / 64 * 64);
    memset(s, 0, sizeof *s);
    s->soup = mesh_soup(300, 2, 0.5f);
    s->ball = mesh_ball(12, 1, 0.05f);
    for (uint32_t i = 0; i < INSTANCES; i++) {
        daft_vec3 at = daft_v3(random_float(4, 12), random_float(-4, 4), random_float(-5, 5)),
                  scale = daft_v3(1, i % 5 ? 1 : -1.4f, 1);
        daft_instance *t = &s->instances[i];
        *t = i % 4 == 0 ? sphere_make(at, random_float(0.2f, 1.2f))
                        : instance_make(i % 4 == 1 ? &s->soup : &s->ball, affine_make(random_rotation(), scale, at));
        t->materials = &MATERIALS[i % kinds];
    }
    for (int i = 0; i < 3; i++) s->materials[i] = (daft_surface){.index = 1, .texture = DAFT_NO_TEXTURE};
    s->materials[1].specular = daft_v3(0.5f, 0.5f, 0.5f), s->materials[2].mirror = daft_v3(0.5f, 0, 0);
    daft_vec3 forward = daft_normalize(daft_v3(1, 0.1f, -0.05f)),
              right = daft_normalize(daft_cross(forward, daft_v3(0, 1, 0)));
    s->pencil = (daft_pencil){.right = right,
                              .up = daft_cross(right, forward),
                              .forward = forward,
                              .focal = 90,
                              .width = WIDTH,
                              .height = HEIGHT,
                              .shift_x = 0.125f,
                              .shift_y = -0.375f};
    s->snapshot = (daft_snapshot){.width = WIDTH,
                                  .height = HEIGHT,
                                  .focal = 90,
                                  .instances = s->instances,
                                  .instance_count = INSTANCES,
                                  .materials = s->materials,
                                  .material_count = 3};
    s->allocator = daft_malloc_allocator();
    assert_true(daft_raster_init(&s->raster, &s->allocator, 1, daft_isa_best(), NULL));
    assert_true(daft_raster_begin(&s->raster, &s->pencil, s->instances, INSTANCES, NULL));
    for (uint32_t i = 0; i < s->raster.work_count; i++) daft_raster_bin(&s->raster, i, 0);
    return s;
}

static void stage_drop(stage *s)
{
    daft_raster_free(&s->raster);
    mesh_drop(&s->soup);
    mesh_drop(&s->ball);
    free(s);
}

/* ---- the twin ---- */

typedef struct surface_hit {
    daft_dvec3 point, normal, outward, shadow_origin;
} surface_hit;

static daft_dvec3 unit(daft_dvec3 a) { return daft_dscale(a, 1 / sqrt(daft_ddot(a, a))); }
static daft_dvec3 frame_point(const daft_instance *t, daft_vec3 p)
{
    return daft_to_double(daft_affine_point(&t->to_frame, p));
}

static surface_hit hit_triangle(const daft_instance *t, uint32_t triangle, daft_dvec3 o, daft_dvec3 d)
{
    const daft_trimesh *m = t->mesh;
    const uint32_t *at = &m->indices[3 * triangle],
                   *normals = m->normal_indices ? &m->normal_indices[3 * triangle] : at;
    daft_dvec3 c[3], n[3], e[3], mean = {0, 0, 0}, sum = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        c[k] = frame_point(t, daft_v3(m->x[at[k]], m->y[at[k]], m->z[at[k]]));
        n[k] = unit(daft_to_double(daft_affine_transposed(&t->to_object, m->normals[normals[k]])));
        sum = daft_dadd(sum, n[k]);
    }
    surface_hit out;
    out.outward = unit(daft_dcross(daft_dsub(c[1], c[0]), daft_dsub(c[2], c[0])));
    if (daft_ddot(sum, out.outward) < 0) out.outward = daft_dscale(out.outward, -1);
    double height = daft_ddot(out.outward, daft_dsub(c[0], o));
    if (height > 0) {
        out.outward = daft_dscale(out.outward, -1), height = -height;
        for (int k = 0; k < 3; k++) n[k] = daft_dscale(n[k], -1);
    }
    out.point = daft_dadd(o, daft_dscale(d, height / daft_ddot(out.outward, d)));
    double w[3], all = 0;
    for (int k = 0; k < 3; k++) {
        e[k] = daft_dcross(daft_dsub(c[(k + 1) % 3], out.point), daft_dsub(c[(k + 2) % 3], out.point));
        w[k] = fabs(daft_ddot(e[k], out.outward)), all += w[k];
    }
    out.shadow_origin = out.point;
    for (int k = 0; k < 3; k++) {
        double below = fmin(daft_ddot(daft_dsub(out.point, c[k]), n[k]), 0);
        mean = daft_dadd(mean, daft_dscale(n[k], w[k] / all));
        out.shadow_origin = daft_dsub(out.shadow_origin, daft_dscale(n[k], below * w[k] / all));
    }
    out.normal = unit(mean);
    return out;
}

static surface_hit hit_sphere(const daft_instance *t, daft_dvec3 o, daft_dvec3 d)
{
    daft_dvec3 c = daft_dv3((double)t->to_frame.t[0], (double)t->to_frame.t[1], (double)t->to_frame.t[2]),
               to = daft_dsub(c, o);
    double along = daft_ddot(to, d), r = (double)t->radius,
           half = sqrt(fmax(r * r - daft_ddot(to, to) + along * along, 0));
    surface_hit out;
    out.point = daft_dadd(o, daft_dscale(d, along > half ? along - half : along + half));
    out.normal = out.outward = daft_dscale(unit(daft_dsub(out.point, c)), along > half ? 1 : -1);
    out.shadow_origin = out.point;
    return out;
}

static double apart(const daft_lanes3 *a, uint32_t i, daft_dvec3 b)
{
    daft_dvec3 d = daft_dsub(daft_dv3((double)a->x[i], (double)a->y[i], (double)a->z[i]), b);
    return sqrt(daft_ddot(d, d));
}

static daft_vec3 lane(const daft_lanes3 *a, uint32_t i) { return daft_v3(a->x[i], a->y[i], a->z[i]); }

/* Rays along a surface say little of where they meet it. */
static bool compare(const stage *s, const daft_batch *b, uint32_t i, daft_dvec3 o, daft_dvec3 d)
{
    const daft_instance *t = &s->instances[b->instance[i]];
    surface_hit m = t->mesh ? hit_triangle(t, b->triangle[i], o, d) : hit_sphere(t, o, d);
    if (fabs(daft_ddot(m.outward, d)) < 0.05) return false;
    assert_true(apart(&b->point, i, m.point) < 2e-4);
    assert_true(apart(&b->outward, i, m.outward) < (t->mesh ? 1e-5 : 1e-3));
    if (fabs(daft_ddot(m.normal, m.outward)) > 0.2) assert_true(apart(&b->normal, i, m.normal) < 2e-3);
    assert_true(apart(&b->shadow_origin, i, m.shadow_origin) < 2e-3);
    assert_int_equal(b->material[i], t->materials[0]);
    const bool inner = daft_seen_from_inside(t, b->triangle[i], lane(&b->point, i), lane(&b->outward, i));
    if (b->traits & DAFT_TRAIT_SENDS) assert_int_equal(b->inner[i], inner);
    return true;
}

/* ---- pixels ---- */

static void same_lanes(const daft_lanes3 *a, const daft_lanes3 *b, uint32_t count)
{
    assert_memory_equal(a->x, b->x, count * sizeof(float));
    assert_memory_equal(a->y, b->y, count * sizeof(float));
    assert_memory_equal(a->z, b->z, count * sizeof(float));
}

static void same_bits(const daft_batch *a, const daft_batch *b, uint32_t traits)
{
    assert_true(a->count == b->count && a->traits == b->traits && a->one_material == b->one_material);
    same_lanes(&a->point, &b->point, a->count);
    same_lanes(&a->normal, &b->normal, a->count);
    same_lanes(&a->outward, &b->outward, a->count);
    same_lanes(&a->shadow_origin, &b->shadow_origin, a->count);
    if (traits) same_lanes(&a->view, &b->view, a->count);
    if (traits & DAFT_TRAIT_SENDS) {
        same_lanes(&a->weight, &b->weight, a->count);
        assert_memory_equal(a->inner, b->inner, a->count * sizeof a->inner[0]);
    }
    assert_memory_equal(a->pixel, b->pixel, a->count * sizeof a->pixel[0]);
    assert_memory_equal(a->material, b->material, a->count * sizeof a->material[0]);
}

static uint32_t check_tile(stage *s, uint32_t number)
{
    const daft_surfaces_def def = {&s->snapshot, &s->pencil, true, true};
    uint32_t looked = 0;
    daft_raster_kernels_for(0)->tile(&s->raster, number, 0, NULL, &s->tile);
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        kernels(isa)->surfaces(&def, &s->tile, &s->facets, &s->points[isa], &s->sky);
        same_bits(&s->points[isa], &s->points[0], s->points[0].traits);
    }
    const daft_batch *b = &s->points[0];
    assert_int_equal(b->count + s->sky.count, s->tile.width * s->tile.height);
    for (uint32_t i = 0; i < b->count; i++) {
        uint32_t place = b->pixel[i];
        assert_true(b->instance[i] == s->tile.instance[place] && b->triangle[i] == s->tile.triangle[place]);
        daft_vec3 r =
            daft_pencil_ray(&s->pencil, s->tile.x + (int)place % DAFT_TILE, s->tile.y + (int)place / DAFT_TILE);
        daft_vec3 d = daft_add(daft_add(daft_scale(s->pencil.right, r.x), daft_scale(s->pencil.up, r.y)),
                               daft_scale(s->pencil.forward, r.z));
        looked += compare(s, b, i, daft_dv3(0, 0, 0), unit(daft_to_double(d)));
    }
    for (uint32_t i = 0; i < s->sky.count; i++) assert_int_equal(s->tile.instance[s->sky.pixel[i]], DAFT_NOTHING);
    return looked;
}

static void pixels_meet_what_they_see(void **unused)
{
    (void)unused;
    fixture_seed(71);
    uint32_t looked = 0;
    for (uint32_t round = 0; round < 6; round++) {
        stage *s = stage_make(round % 3 + 1);
        for (int i = 0; i < s->raster.tiles_x * s->raster.tiles_y; i++) looked += check_tile(s, (uint32_t)i);
        stage_drop(s);
    }
    assert_true(looked > 20000);
}

/* A tile that sees one thing everywhere, but for one pixel where `but_one`. */
static void see_one(stage *s, uint32_t instance, uint32_t triangle, bool but_one)
{
    const daft_instance *t = &s->instances[instance];
    for (int i = 0; i < DAFT_TILE_ROOM; i++)
        s->tile.instance[i] = instance, s->tile.triangle[i] = t->mesh ? triangle : 0;
    if (but_one)
        s->tile.instance[random_bits() % (DAFT_TILE * DAFT_TILE)] =
            random_bits() % 2 ? DAFT_NOTHING : (instance + 1) % INSTANCES;
}

/* Tiles that one flat facet fills have the bits that they have when more is asked for. */
static void filled_tiles(void **unused)
{
    (void)unused;
    fixture_seed(73);
    const int heights[2] = {DAFT_TILE, 8};
    stage *s = stage_make(1);
    daft_batch *alone = aligned_alloc(64, (sizeof *alone + 63) / 64 * 64);
    memset(alone, 0, sizeof *alone);
    s->materials[1].specular = daft_v3(0, 0, 0);
    for (int round = 0; round < 400; round++) {
        const daft_surfaces_def def = {&s->snapshot, &s->pencil, true, false},
                                other = {&s->snapshot, &s->pencil, true, true};
        uint32_t instance = random_bits() % 6, triangle = random_bits() % 2;
        s->instances[5].materials = &MATERIALS[random_bits() % 2];
        s->instances[1].to_frame.t[0] = random_bits() % 4 ? s->instances[1].to_frame.t[0] : random_float(4, 12);
        s->tile.x = 32 * (int)(random_bits() % 4), s->tile.y = 32 * (int)(random_bits() % 2), s->tile.width = DAFT_TILE;
        s->tile.height = heights[random_bits() % 2];
        see_one(s, instance, triangle, random_bits() % 4 == 0);
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            kernels(isa)->surfaces(&def, &s->tile, &s->facets, &s->points[isa], &s->sky);
            kernels(isa)->surfaces(&other, &s->tile, &s->facets, alone, &s->sky);
            same_bits(&s->points[isa], alone, 0);
            assert_memory_equal(s->points[isa].instance, alone->instance, alone->count * sizeof(uint32_t));
            assert_memory_equal(s->points[isa].triangle, alone->triangle, alone->count * sizeof(uint32_t));
        }
    }
    free(alone);
    stage_drop(s);
}

/* ---- rays ---- */

static void rays_meet_what_they_hit(void **unused)
{
    (void)unused;
    fixture_seed(72);
    stage *s = stage_make(3);
    daft_arena arena;
    daft_arena_init(&arena, &s->allocator);
    const daft_tlas *tlas = daft_tlas_build(&arena, s->instances, INSTANCES, NULL);
    assert_non_null(tlas);
    enum { RAYS = 200 };
    daft_hit hits[RAYS];
    uint32_t looked = 0;
    for (int round = 0; round < 20; round++) {
        for (uint32_t i = 0; i < RAYS; i++) {
            daft_vec3 o = random_vec3(-3, 3),
                      d = daft_normalize(daft_v3(1, random_float(-0.7f, 0.7f), random_float(-0.7f, 0.7f)));
            daft_ray ray = {.origin = o, .direction = d, .tmax = INFINITY};
            s->rays.origin.x[i] = o.x, s->rays.origin.y[i] = o.y, s->rays.origin.z[i] = o.z;
            s->rays.direction.x[i] = d.x, s->rays.direction.y[i] = d.y, s->rays.direction.z[i] = d.z;
            s->rays.pixel[i] = i, s->rays.distance[i] = 1;
            daft_accel_kernels_for(0)->closest(tlas, &ray, UINT32_MAX, &hits[i]);
        }
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            s->points[isa].count = s->points[isa].traits = s->sky.count = 0;
            kernels(isa)->hit_points(&s->snapshot, &s->rays, 0, hits, RAYS, &s->facets, &s->points[isa], &s->sky);
            same_bits(&s->points[isa], &s->points[0], DAFT_TRAIT_SENDS);
            assert_int_equal(s->points[isa].count + s->sky.count, RAYS);
        }
        const daft_batch *b = &s->points[0];
        for (uint32_t i = 0; i < b->count; i++) {
            uint32_t ray = b->pixel[i];
            assert_int_equal(b->instance[i], hits[ray].instance);
            assert_true(b->distance[i] == 1 + hits[ray].t);
            daft_dvec3 o =
                daft_dv3((double)s->rays.origin.x[ray], (double)s->rays.origin.y[ray], (double)s->rays.origin.z[ray]);
            daft_dvec3 d = daft_dv3((double)s->rays.direction.x[ray], (double)s->rays.direction.y[ray],
                                    (double)s->rays.direction.z[ray]);
            looked += compare(s, b, i, o, d);
        }
    }
    assert_true(looked > 1000);
    daft_arena_free(&arena);
    stage_drop(s);
}

/* A mesh without normals has its outer side where its corners run counter-clockwise, in its own space. */
static void sides_without_normals(void **unused)
{
    (void)unused;
    fixture_seed(74);
    stage *s = stage_make(3);
    const daft_surfaces_def def = {&s->snapshot, &s->pencil, true, true};
    uint32_t inner = 0, looked = 0;
    for (uint32_t i = 0; i < 3; i++) s->materials[i].mirror = daft_v3(1, 1, 1);
    daft_vec3 *const kept[2] = {s->soup.mesh.normals, s->ball.mesh.normals};
    s->soup.mesh.normals = NULL, s->ball.mesh.normals = NULL;
    for (int tile = 0; tile < s->raster.tiles_x * s->raster.tiles_y; tile++) {
        daft_raster_kernels_for(0)->tile(&s->raster, (uint32_t)tile, 0, NULL, &s->tile);
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            const daft_batch *b = &s->points[isa];
            kernels(isa)->surfaces(&def, &s->tile, &s->facets, &s->points[isa], &s->sky);
            for (uint32_t i = 0; i < b->count; i++) {
                const daft_instance *t = &s->instances[b->instance[i]];
                assert_int_equal(b->inner[i],
                                 daft_seen_from_inside(t, b->triangle[i], lane(&b->point, i), lane(&b->outward, i)));
                inner += b->inner[i], looked++;
            }
        }
    }
    assert_true(inner > 1000 && looked - inner > 1000);
    s->soup.mesh.normals = kept[0], s->ball.mesh.normals = kept[1];
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(pixels_meet_what_they_see), cmocka_unit_test(filled_tiles),
                                       cmocka_unit_test(rays_meet_what_they_hit),
                                       cmocka_unit_test(sides_without_normals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
