/* Scans against single rays: the same hits, bit for bit, for any number of threads; what moving sensors, errors and
 * panes of glass do. */
#include "scene_fixture.h"

#include <stdlib.h>

static daft_material material_of(daft_scene *scene, float grey, float transmission)
{
    daft_material_def def = daft_default_material_def();
    def.diffuse = daft_v3(grey, grey, grey);
    def.transmission = transmission;
    return daft_material_create(scene, &def, NULL);
}

static daft_entity make_box(daft_scene *scene, daft_dvec3 at, daft_vec3 size, daft_material material)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX;
    def.position = at, def.size = size, def.material = material;
    daft_entity made = daft_entity_create(scene, &def, NULL);
    assert_true(made.id != 0);
    return made;
}

/* Boxes, balls and a mesh all round, turned and stretched, at an offset from the origin. */
static void furnish(fixture *f, double offset)
{
    daft_entity_def def = daft_default_entity_def();
    daft_error error;
    def.mesh = daft_mesh_load(f->scene, DAFT_ROOT "/assets/meshes/cup.obj", &error);
    if (!def.mesh.id) fail_msg("%s", error.message);
    for (int i = 0; i < 40; i++) {
        def.shape = i % 4 == 0 ? DAFT_SHAPE_MESH : i % 4 == 1 ? DAFT_SHAPE_SPHERE : DAFT_SHAPE_BOX;
        def.position = daft_dv3(offset + uniform(-20, 20), uniform(-6, 6), uniform(-20, 20));
        def.rotation = (daft_quat){uniform_f(-1, 1), uniform_f(-1, 1), uniform_f(-1, 1), uniform_f(-1, 1)};
        def.scale = daft_v3(uniform_f(1, 3), uniform_f(1, 3), uniform_f(1, 3));
        if (def.shape == DAFT_SHAPE_SPHERE) def.scale.y = def.scale.z = def.scale.x;
        if (!daft_entity_create(f->scene, &def, &error).id) fail_msg("%s", error.message);
    }
}

static daft_scan_return *scan(daft_scene *scene, const daft_scan_def *def, daft_scan_return **last)
{
    daft_error error;
    daft_scan_return *first = calloc(daft_scan_size(def) + 1, sizeof *first);
    if (last) *last = calloc(daft_scan_size(def) + 1, sizeof **last);
    if (!daft_scan(scene, def, first, last ? *last : NULL, &error)) fail_msg("%s", error.message);
    return first;
}

/* Each return is what one ray finds. `slack`: of the ranges, metres. */
static uint32_t assert_same_as_rays(daft_scene *scene, const daft_scan_def *def, float slack)
{
    daft_scan_return *got = scan(scene, def, NULL);
    uint32_t hits = 0, others = 0;
    for (uint32_t i = 0; i < daft_scan_size(def); i++) {
        daft_dvec3 origin;
        daft_vec3 way;
        daft_error error;
        daft_ray_hit hit;
        assert_true(daft_scan_ray(def, i, &origin, &way, NULL, &error));
        bool met = daft_scene_cast_ray(scene, origin, way, def->max_range, def->ignore, &hit, &error);
        if (met && hit.distance < def->min_range) met = false;
        hits += met;
        const bool same = met ? fabsf(got[i].range - hit.distance) <= slack && got[i].entity.id == hit.entity.id &&
                                    got[i].triangle == hit.triangle
                              : got[i].range == 0 && got[i].entity.id == 0;
        others += !same;
        if (!same && slack == 0)
            fail_msg("ray %u: %.9g m, alone %.9g m", i, (double)got[i].range, (double)hit.distance);
    }
    free(got);
    if (others > hits / 100) fail_msg("%u of %u returns are others", others, hits); /* along edges */
    return hits;
}

static void returns_are_those_of_single_rays(void **state)
{
    fixture *f = *state;
    random_state = 71;
    print_message("seed %llu\n", (unsigned long long)random_state);
    for (int i = 0; i < 2; i++) {
        const double offset = i * 3e6;
        furnish(f, offset);
        daft_scan_def def = daft_default_scan_def();
        def.position = daft_dv3(offset, 0.5, 0), def.rows = 17, def.columns = 131, def.max_range = 18;
        assert_true(assert_same_as_rays(f->scene, &def, 0) > 100);
        def.pattern = DAFT_SCAN_GRID;
        def.rotation = (daft_quat){0.2f, 0.9f, -0.1f, 1};
        assert_true(assert_same_as_rays(f->scene, &def, 0) > 100);
        def.min_range = 8;
        assert_same_as_rays(f->scene, &def, 0);
        daft_vec3 list[1500];
        for (int k = 0; k < 1500; k++) list[k] = daft_v3(uniform_f(-9, 9), uniform_f(-4, 4), uniform_f(0.1, 9));
        def.pattern = DAFT_SCAN_RAYS, def.rays = list, def.ray_count = 1500;
        assert_int_equal(daft_scan_size(&def), 1500);
        assert_true(assert_same_as_rays(f->scene, &def, 0) > 20);
    }
}

static void a_moving_sensor_sees_from_where_it_is(void **state)
{
    fixture *f = *state;
    daft_error error;
    random_state = 5;
    furnish(f, 0);
    const daft_vec3 ahead[3] = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
    const daft_scan_pattern patterns[] = {DAFT_SCAN_SPINNING, DAFT_SCAN_GRID, DAFT_SCAN_RAYS};
    for (int i = 0; i < 3; i++) {
        daft_scan_def def = daft_default_scan_def();
        def.pattern = patterns[i], def.rows = 32, def.columns = 64, def.rays = ahead, def.ray_count = 3;
        def.velocity = daft_v3(20, 1, -10), def.spin = daft_v3(0, 3, 1), def.duration = 0.2f;
        assert_same_as_rays(f->scene, &def, 1e-4f);
    }
    /* Half a turn to the right in the time of three rays: forward, 60 degrees, 120 degrees. */
    daft_scan_def def = daft_default_scan_def();
    def.pattern = DAFT_SCAN_RAYS, def.rays = ahead, def.ray_count = 3, def.duration = 1;
    def.spin = daft_v3(0, -3.14159265f, 0), def.velocity = daft_v3(3, 0, 0);
    for (uint32_t i = 0; i < 3; i++) {
        daft_dvec3 origin;
        daft_vec3 way;
        double seconds;
        assert_true(daft_scan_ray(&def, i, &origin, &way, &seconds, &error));
        const double angle = 1.04719755 * i;
        assert_true(fabs(seconds - i / 3.0) < 1e-12 && fabs(origin.x - i) < 1e-9);
        assert_true(fabs((double)way.x - cos(angle)) < 1e-6 && fabs((double)way.z - sin(angle)) < 1e-6);
    }
}

static void threads_change_nothing(void **state)
{
    fixture *f = *state;
    daft_scan_return *got[3];
    daft_scan_def def = daft_default_scan_def();
    def.rows = 31, def.columns = 200, def.range_noise = 0.05f, def.drop_out = 0.1f, def.seed = 99;
    const int threads[] = {1, 2, 7};
    for (int i = 0; i < 3; i++) {
        daft_engine_def wanted = daft_default_engine_def();
        wanted.threads = threads[i];
        daft_engine *engine = daft_engine_create(&wanted, NULL);
        fixture own = {.engine = engine, .scene = daft_scene_create(engine, NULL)};
        random_state = 8;
        furnish(&own, 0);
        got[i] = scan(own.scene, &def, NULL);
        daft_scene_destroy(own.scene);
        daft_engine_destroy(engine);
        assert_memory_equal(got[0], got[i], daft_scan_size(&def) * sizeof *got[0]);
    }
    for (int i = 0; i < 3; i++) free(got[i]);
    (void)f;
}

/* A wall 5 m ahead, seen through a pane at 2 m. */
static void glass_is_the_first_return_and_the_wall_the_last(void **state)
{
    fixture *f = *state;
    daft_scan_return *last;
    const daft_vec3 ahead[2] = {{1, 0, 0}, {1, 1, 0}};
    daft_entity wall = make_box(f->scene, daft_dv3(5.5, 0, 0), daft_v3(1, 20, 20), material_of(f->scene, 0.5f, 0));
    daft_entity pane =
        make_box(f->scene, daft_dv3(2.005, 0, 0), daft_v3(0.01f, 1, 1), material_of(f->scene, 0.2f, 0.5f));
    daft_scan_def def = daft_default_scan_def();
    def.pattern = DAFT_SCAN_RAYS, def.rays = ahead, def.ray_count = 2;
    daft_scan_return *first = scan(f->scene, &def, &last);
    assert_true(first[0].entity.id == pane.id && fabsf(first[0].range - 2) < 1e-5f);
    assert_true(last[0].entity.id == wall.id && fabsf(last[0].range - 5) < 1e-5f);
    assert_true(fabsf(first[0].intensity - 0.1f) < 1e-5f); /* what the pane scatters: 0.2 times what does not pass */
    assert_true(fabsf(last[0].intensity - 0.5f / 16) < 1e-4f); /* in and out of the pane, there and back */
    assert_true(first[1].entity.id == wall.id && fabsf(first[1].range - 5 * sqrtf(2)) < 1e-4f);
    assert_true(fabsf(first[1].intensity - 0.5f / sqrtf(2)) < 1e-4f); /* met at 45 degrees */
    assert_memory_equal(&first[1], &last[1], sizeof *first);
    free(first), free(last);
    def.ignore = pane;
    first = scan(f->scene, &def, NULL);
    assert_int_equal(first[0].entity.id, wall.id);
    free(first);
}

static daft_material liquid(daft_scene *scene, daft_vec3 tint, float distance, int priority)
{
    daft_material_def def = daft_default_material_def();
    def.transmission = 1, def.transmission_tint = tint, def.tint_distance = distance, def.medium_priority = priority;
    return daft_material_create(scene, &def, NULL);
}

static double luminance(const double c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

/* What bodies take of the light by the length of the way within, there and back (Beer's law); where two overlap, the
 * one of the higher priority alone; panes with a tint at each surface. */
static void bodies_absorb_by_length(void **state)
{
    fixture *f = *state;
    static const daft_vec3 RED = {0.9f, 0.3f, 0.2f}, BLUE = {0.2f, 0.6f, 0.95f}, GREEN = {0.4f, 0.8f, 0.5f};
    const daft_vec3 ways[3] = {{1, 0, 0}, {0, 0, 1}, {-1, 0, 0}};
    const daft_material white = material_of(f->scene, 1, 0);
    make_box(f->scene, daft_dv3(6.5, 0, 0), daft_v3(1, 9, 9), white);
    make_box(f->scene, daft_dv3(0, 0, 6.5), daft_v3(9, 9, 1), white);
    make_box(f->scene, daft_dv3(-6.5, 0, 0), daft_v3(1, 9, 9), white);
    make_box(f->scene, daft_dv3(3, 0, 0), daft_v3(2, 1, 1), liquid(f->scene, RED, 1.5f, 1));  /* from 2 to 4 */
    make_box(f->scene, daft_dv3(4, 0, 0), daft_v3(2, 1, 1), liquid(f->scene, BLUE, 2.5f, 2)); /* from 3 to 5 */
    make_box(f->scene, daft_dv3(0, 0, 3.5), daft_v3(1, 1, 3), liquid(f->scene, RED, 1.5f, 0));
    make_box(f->scene, daft_dv3(-3, 0, 0), daft_v3(0.01f, 1, 1), liquid(f->scene, GREEN, 0, 0));
    daft_scan_def def = daft_default_scan_def();
    daft_scan_return *last;
    def.pattern = DAFT_SCAN_RAYS, def.rays = ways, def.ray_count = 3;
    daft_scan_return *first = scan(f->scene, &def, &last);
    double want[3][3];
    for (int k = 0; k < 3; k++) {
        const double red = (double)daft_v3_at(RED, k), blue = (double)daft_v3_at(BLUE, k);
        want[0][k] = pow(red, 2 * 1 / 1.5) * pow(blue, 2 * 2 / 2.5), want[1][k] = pow(red, 2 * 3 / 1.5);
        want[2][k] = pow((double)daft_v3_at(GREEN, k), 4);
    }
    for (int i = 0; i < 3; i++) {
        assert_true(fabsf(last[i].range - 6) < 1e-5f && first[i].range < 4);
        if (fabs((double)last[i].intensity - luminance(want[i])) > 1e-5)
            fail_msg("ray %d: %g, not %g", i, (double)last[i].intensity, luminance(want[i]));
    }
    free(first), free(last);
}

static void errors_are_as_large_as_asked_for_and_seeded(void **state)
{
    fixture *f = *state;
    make_sphere(f->scene, 0, 0, 0, 10, (daft_entity){0}); /* seen from its centre */
    daft_scan_def def = daft_default_scan_def();
    def.rows = 64, def.columns = 512, def.range_noise = 0.02f, def.drop_out = 0.25f, def.seed = 3;
    const uint32_t rays = daft_scan_size(&def);
    daft_scan_return *a = scan(f->scene, &def, NULL), *b = scan(f->scene, &def, NULL);
    assert_memory_equal(a, b, rays * sizeof *a);
    free(b);
    double sum = 0, squares = 0, count = 0;
    for (uint32_t i = 0; i < rays; i++) {
        const double off = (double)a[i].range - 10;
        if (a[i].range > 0) sum += off, squares += off * off, count++;
    }
    assert_true(fabs(count / rays - 0.75) < 0.01);
    assert_true(fabs(sum / count) < 5e-4 && fabs(sqrt(squares / count) - 0.02) < 5e-4);
    def.seed = 4;
    b = scan(f->scene, &def, NULL);
    assert_memory_not_equal(a, b, rays * sizeof *a);
    free(a), free(b);
}

static void bad_definitions_are_refused(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_scan_return returns[4];
    daft_scan_def def = daft_default_scan_def(), bad = def;
    bad.rows = 0;
    assert_false(daft_scan(f->scene, &bad, returns, NULL, &error) || daft_scan_size(&bad));
    assert_non_null(strstr(error.message, "rows"));
    bad = def, bad.rows = 4096, bad.columns = 65536 + 1;
    assert_false(daft_scan(f->scene, &bad, returns, NULL, &error));
    bad = def, bad.min_range = 200;
    assert_false(daft_scan(f->scene, &bad, returns, NULL, &error));
    assert_non_null(strstr(error.message, "max_range"));
    bad = def, bad.pattern = DAFT_SCAN_RAYS, bad.ray_count = 4;
    assert_false(daft_scan(f->scene, &bad, returns, NULL, &error));
    const daft_vec3 list[2] = {{0, 0, 1}, {0, 0, 0}};
    bad.rays = list, bad.ray_count = 2;
    assert_false(daft_scan(f->scene, &bad, returns, NULL, &error));
    bad = def, bad.ignore.id = 77;
    assert_false(daft_scan(f->scene, &bad, returns, NULL, &error));
    assert_false(daft_scan_ray(&def, daft_scan_size(&def), NULL, NULL, NULL, &error));
    bad = def, bad.rows = bad.columns = 2; /* an empty scene sends nothing back */
    memset(returns, 0x55, sizeof returns);
    assert_true(daft_scan(f->scene, &bad, returns, NULL, &error));
    for (int i = 0; i < 4; i++) assert_true(returns[i].range == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(returns_are_those_of_single_rays, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_moving_sensor_sees_from_where_it_is, set_up, tear_down),
        cmocka_unit_test_setup_teardown(threads_change_nothing, set_up, tear_down),
        cmocka_unit_test_setup_teardown(glass_is_the_first_return_and_the_wall_the_last, set_up, tear_down),
        cmocka_unit_test_setup_teardown(bodies_absorb_by_length, set_up, tear_down),
        cmocka_unit_test_setup_teardown(errors_are_as_large_as_asked_for_and_seeded, set_up, tear_down),
        cmocka_unit_test_setup_teardown(bad_definitions_are_refused, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
