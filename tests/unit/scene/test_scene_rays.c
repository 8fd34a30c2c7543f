/* Ray queries against closed forms, near and far, through turned and scaled entities. */
#include "scene_fixture.h"

typedef struct pose {
    daft_dvec3 position;
    daft_quat rotation;
    double scale[3];
} pose;

static daft_quat random_quat(void)
{
    return daft_quat_normalize((daft_quat){uniform_f(-1, 1), uniform_f(-1, 1), uniform_f(-1, 1), uniform_f(-1, 1)});
}

/* v turned by q, or back, in double. */
static daft_dvec3 turn(daft_quat q, daft_dvec3 v, bool back)
{
    double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = back ? -(double)q.w : (double)q.w;
    double n = x * x + y * y + z * z + w * w;
    daft_dvec3 u = daft_dv3(x, y, z), t = daft_dscale(daft_dcross(u, v), 2 / n);
    return daft_dadd(v, daft_dadd(daft_dscale(t, w), daft_dcross(u, t)));
}

static daft_dvec3 to_local(const pose *p, daft_dvec3 v, bool point)
{
    daft_dvec3 r = turn(p->rotation, point ? daft_dsub(v, p->position) : v, true);
    return daft_dv3(r.x / p->scale[0], r.y / p->scale[1], r.z / p->scale[2]);
}

/* Distance to an axis-aligned box around the origin; negative: a miss. */
static double slab(daft_dvec3 origin, daft_dvec3 direction, daft_vec3 size)
{
    double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    double half[3] = {(double)size.x / 2, (double)size.y / 2, (double)size.z / 2}, near = -INFINITY, far = INFINITY;
    for (int i = 0; i < 3; i++) {
        double a = (-half[i] - o[i]) / d[i], b = (half[i] - o[i]) / d[i];
        near = fmax(near, fmin(a, b)), far = fmin(far, fmax(a, b));
    }
    if (near > far || far < 0) return -1;
    return near >= 0 ? near : far;
}

static daft_dvec3 near_by(daft_dvec3 center, double distance)
{
    daft_dvec3 off = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    return daft_dadd(center, daft_dscale(off, distance));
}

/* A turned and stretched box under a turned parent, rays at it and past it: `offset` moves everything along. */
static void check_boxes(fixture *f, double offset, double scale)
{
    daft_entity_def def = daft_default_entity_def();
    pose outer = {daft_dv3(offset + scale * uniform(-2, 2), scale * uniform(-2, 2), offset), random_quat(), {2, 2, 2}};
    pose inner = {daft_dv3(scale * uniform(-1, 1), scale, 0), random_quat(), {uniform(0.5, 2), uniform(0.5, 2), -1}};
    def.position = outer.position, def.rotation = outer.rotation, def.scale = daft_v3(2, 2, 2);
    daft_entity parent = daft_entity_create(f->scene, &def, NULL);
    for (int i = 0; i < 3; i++) inner.scale[i] = (double)(float)inner.scale[i];
    def.parent = parent, def.position = inner.position, def.rotation = inner.rotation;
    def.scale = daft_v3((float)inner.scale[0], (float)inner.scale[1], (float)inner.scale[2]);
    def.shape = DAFT_SHAPE_BOX;
    def.size = daft_v3(uniform_f(0.5, 2) * (float)scale, uniform_f(0.5, 2) * (float)scale, (float)scale);
    daft_entity box = daft_entity_create(f->scene, &def, NULL);
    assert_true(box.id != 0);
    daft_dvec3 center = daft_dadd(outer.position, daft_dscale(turn(outer.rotation, inner.position, false), 2));
    int hits = 0, grazes = 0; /* rays along an edge, which floats may see otherwise */
    for (int i = 0; i < 300; i++) {
        daft_dvec3 from = near_by(center, 9 * scale), to = near_by(center, 2 * scale);
        daft_vec3 direction = daft_to_float(daft_dsub(to, from));
        daft_dvec3 unit = daft_to_double(direction);
        unit = daft_dscale(unit, 1 / sqrt(daft_ddot(unit, unit)));
        daft_dvec3 o = to_local(&outer, from, true), d = to_local(&outer, unit, false);
        double want = slab(to_local(&inner, o, true), to_local(&inner, d, false), def.size);
        daft_ray_hit hit;
        daft_error error;
        if (!daft_scene_cast_ray(f->scene, from, direction, INFINITY, (daft_entity){0}, &hit, &error)) {
            assert_int_equal(error.code, DAFT_OK);
            grazes += want >= 0;
            continue;
        }
        grazes += want < 0;
        if (want < 0) continue;
        hits++;
        assert_int_equal(hit.entity.id, box.id);
        assert_true(fabs((double)hit.distance - want) <= 1e-5 * (want + scale));
        assert_true(daft_ddot(daft_to_double(hit.normal), unit) < 0);
        daft_dvec3 at = daft_dadd(from, daft_dscale(unit, want));
        daft_dvec3 off = daft_dsub(hit.position, at);
        assert_true(sqrt(daft_ddot(off, off)) <= 1e-5 * (want + scale));
    }
    if (hits <= 40 || grazes > 1) fail_msg("%d hits, %d grazes at offset %g, scale %g", hits, grazes, offset, scale);
    assert_true(daft_entity_destroy(f->scene, parent, NULL));
}

static void rays_meet_boxes(void **state)
{
    random_state = 20240611;
    print_message("seed %llu\n", (unsigned long long)random_state);
    for (int i = 0; i < 20; i++) check_boxes(*state, 0, 1);
    for (int i = 0; i < 5; i++) check_boxes(*state, 1e7, 1);
    for (int i = 0; i < 5; i++) check_boxes(*state, 0, 1e-4);
    for (int i = 0; i < 5; i++) check_boxes(*state, 0, 1e4);
}

/* Exactly the same distances 10,000 km away: the tree is rebased, the last word is in double. */
static void far_is_as_good_as_near(void **state)
{
    fixture *f = *state;
    daft_error error;
    const double far = 16777216; /* positions below are exact there and at 0 */
    for (int i = 0; i < 3; i++) {
        double x = i * far;
        make_sphere(f->scene, x + 3, 0.25, -x, 0.5f, (daft_entity){0});
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_BOX;
        def.position = daft_dv3(x, 0, -x + 3);
        assert_true(daft_entity_create(f->scene, &def, NULL).id != 0);
    }
    daft_vec3 directions[] = {{1, 0, 0}, {1, 0.125f, 0.0625f}, {0, 0, 1}, {0.0625f, 0.03125f, 1}};
    for (size_t d = 0; d < DAFT_COUNT_OF(directions); d++) {
        daft_ray_hit near;
        assert_true(
            daft_scene_cast_ray(f->scene, daft_dv3(0, 0, 0), directions[d], 10, (daft_entity){0}, &near, &error));
        for (int i = 1; i < 3; i++) {
            daft_ray_hit hit;
            daft_dvec3 from = daft_dv3(i * far, 0, -i * far);
            assert_true(daft_scene_cast_ray(f->scene, from, directions[d], 10, (daft_entity){0}, &hit, &error));
            assert_true(hit.distance == near.distance && hit.triangle == near.triangle);
            assert_true(hit.normal.x == near.normal.x && hit.normal.y == near.normal.y);
        }
    }
}

static void rays_meet_spheres(void **state)
{
    fixture *f = *state;
    daft_ray_hit hit;
    daft_error error;
    daft_entity none = {0}, small = make_sphere(f->scene, 5, 0, 0, 1, none),
                big = make_sphere(f->scene, 0, 0, 0, 100, none);
    daft_dvec3 origin = daft_dv3(0, 0, 0);
    assert_true(daft_scene_cast_ray(f->scene, origin, daft_v3(3, 0, 0), 100, none, &hit, &error));
    assert_true(hit.entity.id == small.id && fabsf(hit.distance - 4) < 1e-6f && hit.normal.x == -1);
    assert_true(fabs(hit.position.x - 4) < 1e-12);
    assert_true(daft_scene_cast_ray(f->scene, origin, daft_v3(3, 0, 0), 101, small, &hit, &error));
    assert_true(hit.entity.id == big.id && fabsf(hit.distance - 100) < 1e-5f && hit.normal.x == -1); /* from inside */
    assert_true(fabsf(hit.uv.x - 0.5f) < 1e-6f && fabsf(hit.uv.y - 0.5f) < 1e-6f);
    assert_false(daft_scene_cast_ray(f->scene, origin, daft_v3(1, 0, 0), 3.999f, none, &hit, &error));
    assert_int_equal(error.code, DAFT_OK);
    assert_true(daft_scene_cast_ray(f->scene, origin, daft_v3(1, 0, 0), 4.0f, none, &hit, &error));
    assert_true(daft_entity_set_visible(f->scene, small, false, NULL));
    assert_true(daft_scene_cast_ray(f->scene, origin, daft_v3(1, 0, 0), INFINITY, none, &hit, &error));
    assert_true(hit.entity.id == big.id);
    assert_int_equal(daft_scene_counters(f->scene)->query_rays, 5);
    assert_true(daft_entity_destroy(f->scene, small, NULL));
    assert_false(daft_scene_cast_ray(f->scene, origin, daft_v3(1, 0, 0), 1, small, &hit, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
}

static void rays_meet_meshes(void **state)
{
    fixture *f = *state;
    const daft_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
    const daft_vec2 uvs[] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const uint32_t indices[] = {0, 1, 2, 0, 3, 1};
    daft_mesh_def mesh_def = daft_default_mesh_def();
    mesh_def.positions = positions, mesh_def.uvs = uvs, mesh_def.vertex_count = 4;
    mesh_def.indices = indices, mesh_def.triangle_count = 2;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH;
    def.mesh = daft_mesh_create(f->scene, &mesh_def, NULL);
    def.scale = daft_v3(4, 4, 4);
    daft_entity entity = daft_entity_create(f->scene, &def, NULL);
    assert_true(entity.id != 0);
    daft_ray_hit hit;
    assert_true(daft_scene_cast_ray(f->scene, daft_dv3(1, 3, 2), daft_v3(0, -2, 0), 10, (daft_entity){0}, &hit, NULL));
    assert_true(hit.entity.id == entity.id && hit.triangle == 0 && hit.distance == 3 && hit.normal.y == 1);
    assert_true(fabsf(hit.uv.x - 0.25f) < 1e-6f && fabsf(hit.uv.y - 0.5f) < 1e-6f);
    assert_true(daft_scene_cast_ray(f->scene, daft_dv3(1, 1, -7), daft_v3(0, 0, 1), 10, (daft_entity){0}, &hit, NULL));
    assert_true(hit.triangle == 1 && hit.distance == 7 && hit.normal.z == -1);
    daft_mesh_info info;
    assert_true(daft_mesh_get_info(f->scene, def.mesh, &info, NULL));
    assert_true(info.triangle_count == 2 && info.vertex_count == 4 && info.material_count == 1 && info.bytes > 0);
    assert_true(info.high.x == 1 && info.low.x == 0);
}

static void moved_vertices_are_seen(void **state)
{
    fixture *f = *state;
    daft_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
    const uint32_t indices[] = {0, 1, 2};
    daft_mesh_def mesh_def = daft_default_mesh_def();
    mesh_def.positions = positions, mesh_def.vertex_count = 3;
    mesh_def.indices = indices, mesh_def.triangle_count = 1;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH;
    def.mesh = daft_mesh_create(f->scene, &mesh_def, NULL);
    assert_true(daft_entity_create(f->scene, &def, NULL).id != 0);
    const daft_vec3 normals[] = {{0, 2, 0}, {0, 2, 0}, {0, 2, 0}};
    daft_ray_hit hit;
    for (int i = 1; i <= 4; i++) {
        for (int k = 0; k < 3; k++) positions[k].y = (float)i;
        assert_true(daft_mesh_set_positions(f->scene, def.mesh, positions, i % 2 ? normals : NULL, 3, NULL));
        assert_true(
            daft_scene_cast_ray(f->scene, daft_dv3(0.2, 10, 0.2), daft_v3(0, -1, 0), 20, (daft_entity){0}, &hit, NULL));
        assert_true(hit.position.y == i);
        assert_true(daft_scene_counters(f->scene)->mesh_refits == (uint64_t)i);
    }
    assert_int_equal(daft_scene_counters(f->scene)->mesh_builds, 1);
    daft_error error;
    assert_false(daft_mesh_set_positions(f->scene, def.mesh, positions, NULL, 2, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    positions[1].x = NAN;
    assert_false(daft_mesh_set_positions(f->scene, def.mesh, positions, NULL, 3, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_false(daft_mesh_set_positions(f->scene, (daft_mesh){0}, positions, NULL, 3, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    assert_true(
        daft_scene_cast_ray(f->scene, daft_dv3(0.2, 10, 0.2), daft_v3(0, -1, 0), 20, (daft_entity){0}, &hit, NULL));
    assert_true(hit.position.y == 4); /* what failed has changed nothing */
}

/* The answer depends on the scene and the ray, not on the rays before it. */
static void queries_have_no_memory(void **state)
{
    fixture *f = *state;
    random_state = 77;
    for (int i = 0; i < 50; i++)
        make_sphere(f->scene, uniform(-5, 5), uniform(-5, 5), uniform(-5, 5), 0.4f, (daft_entity){0});
    daft_ray_hit first[64], again;
    bool found[64];
    for (int round = 0; round < 2; round++)
        for (int n = 0; n < 64; n++) {
            int i = round ? 63 - n : n;
            daft_dvec3 origin = daft_dv3(i * 37.0 - 1000, 20, i * 11.0);
            daft_vec3 direction = daft_to_float(daft_dsub(daft_dv3(i % 7 - 3, i % 5 - 2, i % 3 - 1), origin));
            memset(&again, 0, sizeof again);
            bool hit = daft_scene_cast_ray(f->scene, origin, direction, INFINITY, (daft_entity){0}, &again, NULL);
            if (round == 0) first[i] = again, found[i] = hit;
            assert_true(hit == found[i] && again.distance == first[i].distance &&
                        again.entity.id == first[i].entity.id);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(rays_meet_boxes),  TEST(far_is_as_good_as_near),  TEST(rays_meet_spheres),
        TEST(rays_meet_meshes), TEST(moved_vertices_are_seen), TEST(queries_have_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
