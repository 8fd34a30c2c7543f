/* sim: cylinders roll as round bodies do, on their sides and on their rims, stand on their caps, and lie in piles. */
#include "sim_cases.h"

static one_shape roller(const daft_hull *hull, double x, double y, double z)
{
    one_shape def = sphere(1, x, y, z);
    def.part.shape = daft_shape_hull(hull);
    return def;
}

/* cells² cells of 1 m, centred, cut along alternating diagonals. */
static fixture_mesh flat_grid(const variant *v, uint32_t n)
{
    uint32_t vertices = (n + 1) * (n + 1), used = 0;
    daft_vec3 *p = malloc(vertices * sizeof *p);
    uint32_t *index = malloc((size_t)n * n * 6 * sizeof *index);
    for (uint32_t i = 0; i < vertices; i++)
        p[i] = daft_v3((float)(i % (n + 1)) - 0.5f * (float)n, 0, (float)(i / (n + 1)) - 0.5f * (float)n);
    for (uint32_t row = 0; row < n; row++)
        for (uint32_t column = 0; column < n; column++) {
            uint32_t a = row * (n + 1) + column, b = a + 1, c = a + n + 1, d = c + 1;
            const uint32_t one[] = {a, c, b, b, c, d}, other[] = {a, d, b, a, c, d};
            memcpy(index + used, (row + column) % 2 ? other : one, sizeof one);
            used += 6;
        }
    fixture_mesh mesh = variant_mesh(v, p, vertices, index, used / 3);
    free(p);
    free(index);
    return mesh;
}

/* Down slopes of a box and of triangles: 2/3 g sin s within 1 %, straight, and never off the ground. */
static uint64_t cylinders_on_slopes(const variant *v)
{
    uint64_t hash = 0;
    daft_error error = {0};
    fixture_mesh grid = flat_grid(v, 40);
    heap = daft_malloc_allocator();
    daft_mesh_shape *surface = daft_mesh_shape_create(&heap, &grid.mesh, grid.bvh, true, &error);
    static const double lengths[] = {0.05, 0.3, 1};
    for (int k = 0; k < 12; k++) {
        double angle = 0.1 + 0.2 * (k % 2), s = daft_sin(angle), c = daft_cos(angle), r = 0.25;
        daft_hull *hull = cylinder(r, lengths[k / 4]);
        daft_world *world = variant_world(v);
        one_shape slope = box(daft_v3(20, 1e-3f, 5), 0, -1e-3, 0);
        if (k & 2) slope.part.shape = daft_shape_mesh(surface), slope.position.y = 0;
        slope.rotation = turned(0, 0, 1, -angle);
        put(world, v, slope);
        one_shape def = roller(hull, -10 * c + r * s, 10 * s + r * c, 0.2);
        def.rotation = daft_quat_mul(slope.rotation, turned(1, 0, 0, DAFT_PI / 2));
        uint32_t id = put(world, v, def);
        double off = 0;
        for (int i = 0; i < 120; i++) {
            steps(world, 1);
            daft_dvec3 p = state_in(world, v, id).position;
            off = fmax(off, fabs(p.x * s + p.y * c - r));
        }
        double got = speed_of(state_in(world, v, id)) / 2, wanted = 2.0 / 3 * G * s;
        print_message("%s, %g m long: %g of 2/3 g sin s, %g mm off the ground, %g mm aside\n",
                      k & 2 ? "triangles" : "box", 2 * lengths[k / 4], got / wanted, 1e3 * off,
                      1e3 * (state_in(world, v, id).position.z - 0.2));
        assert_near(got, wanted, 0.01 * wanted);
        assert_near(state_in(world, v, id).position.z, 0.2, 0.01);
        assert_true(off < 2e-3);
        hash = hash_of_both(hash, end_of(world));
        daft_hull_free(hull);
    }
    daft_mesh_shape_free(surface);
    mesh_drop(&grid);
    return hash;
}

static void it_rolls_down_a_slope(void **unused)
{
    (void)unused;
    play_variants(cylinders_on_slopes);
}

/* Rolling on the level at 5 m/s it keeps its speed, on one box and across the seams of many. */
static void it_rolls_on(void **unused)
{
    (void)unused;
    daft_hull *hull = cylinder(0.25, 0.2);
    for (int tiles = 0; tiles < 2; tiles++) {
        daft_world *world = new_world();
        for (int x = 0; x < 30 && tiles; x++)
            for (int z = -1; z <= 1; z++) add(world, box(daft_v3(0.5f, 0.5f, 0.5f), x, -0.5, z));
        if (!tiles) add(world, box(daft_v3(40, 1, 5), 0, -1, 0));
        one_shape def = roller(hull, 0, 0.25, 0.1);
        def.rotation = turned(1, 0, 0, DAFT_PI / 2);
        uint32_t id = add(world, def);
        daft_world_set_velocity(world, id, daft_v3(5, 0, 0), daft_v3(0, 0, -20));
        double bump = 0;
        for (int i = 0; i < 300; i++) {
            steps(world, 1);
            bump = fmax(bump, fabs((double)state_of(world, id).linear.y));
        }
        print_message("%s: %g m/s, %g m/s up or down\n", tiles ? "tiles" : "one box", speed_of(state_of(world, id)),
                      bump);
        assert_near(speed_of(state_of(world, id)), 5, 0.01);
        assert_true(bump < 0.01);
        daft_world_destroy(world);
    }
    daft_hull_free(hull);
}

/* A coin that leans rolls on its rim along a circle: after two seconds it has lost nothing to speak of. */
static void a_coin_rolls_on_its_rim(void **unused)
{
    (void)unused;
    daft_hull *hull = cylinder(0.25, 0.01);
    daft_world *world = new_world();
    daft_world_set_sleeping(world, false);
    add_floor(world, 20);
    one_shape def = roller(hull, 0, 0.255, 0);
    def.rotation = turned(1, 0, 0, DAFT_PI / 2 - 0.1);
    uint32_t id = add(world, def);
    daft_world_set_velocity(world, id, daft_v3(3, 0, 0), daft_v3(0, 0, -12));
    double first = 0, last = 0;
    for (int i = 0; i < 120; i++) {
        steps(world, 1);
        if (i == 10) first = speed_of(state_of(world, id));
        last = speed_of(state_of(world, id));
        assert_true(state_of(world, id).position.y > 0.15);
    }
    daft_dvec3 p = state_of(world, id).position;
    print_message("%g m/s, then %g; came to %g, %g, %g\n", first, last, p.x, p.y, p.z);
    assert_near(last, first, 0.1 * first);
    daft_world_destroy(world);
    daft_hull_free(hull);
}

/* Stood up, laid down and leaned, at rest: where it should be, asleep. */
static void it_rests(void **unused)
{
    (void)unused;
    static const double radii[] = {0.02, 0.3, 2}, halves[] = {0.05, 0.1, 1};
    for (int size = 0; size < 3; size++) {
        double r = radii[size], h = halves[size];
        daft_hull *hull = cylinder(r, h);
        for (int how = 0; how < 3; how++) {
            daft_world *world = new_world();
            add_floor(world, 40);
            one_shape def = roller(hull, 0, (how ? r : h) * 1.001 + (how == 2 ? h : 0), 0);
            if (how) def.rotation = turned(0, 0, 1, how == 2 ? DAFT_PI / 2 - 0.3 : DAFT_PI / 2);
            uint32_t id = add(world, def);
            steps(world, 1200);
            daft_dvec3 p = state_of(world, id).position;
            double tilt = tilt_of(world, id), stands = fmin(tilt, DAFT_PI - tilt) < 0.1 ? h : r;
            print_message("radius %g, %s: at %g, tilt %g, %s\n", r,
                          how == 2 ? "leaned"
                          : how    ? "laid"
                                   : "stood",
                          p.y, tilt, daft_world_is_awake(world, id) ? "awake" : "asleep");
            assert_near(p.y, stands, 1e-3 + 2e-3 * r);
            assert_true(how == 2 || (hypot(p.x, p.z) < 1e-3 && !daft_world_is_awake(world, id)));
            assert_true(speed_of(state_of(world, id)) < 0.5);
            daft_world_destroy(world);
        }
        daft_hull_free(hull);
    }
}

/* Forty of all lengths fall into a tray, onto boxes or triangles: nobody leaves it, nobody is in another, and it comes
 * to rest. */
static void a_pile_of_them_rests(void **unused)
{
    (void)unused;
    enum { COUNT = 40 };
    daft_hull *hulls[4];
    for (int i = 0; i < 4; i++) hulls[i] = cylinder(0.12 + 0.04 * i, 0.05 + 0.1 * i);
    uint64_t hashes[VARIANTS];
    for (int k = 0; k < VARIANTS; k++) {
        if (!is_played(k)) continue;
        const variant *v = &VARIANT[k];
        daft_world *world = variant_world(v);
        random_state = 88172645463325252u;
        add_tray(world, v->origin, 1.2f);
        uint32_t ids[COUNT];
        for (int i = 0; i < COUNT; i++) {
            daft_dvec3 at = random_in(-0.6, 0.6), axis = random_in(-1, 1);
            one_shape def =
                i % 5 == 4 ? dynamic_box(daft_v3(0.2f, 0.15f, 0.1f), 0, 0, 0) : roller(hulls[i % 4], 0, 0, 0);
            def.position = daft_dv3(at.x, 0.6 + 0.3 * i, at.z);
            def.rotation = turned(axis.x, axis.y + 1.5, axis.z, uniform(0, 6));
            def.rolling_resistance = 0.02f;
            ids[i] = put(world, v, def);
        }
        double fastest = 0, lowest = 1, deepest = 1;
        for (int tick = 0; tick < 900; tick++) {
            steps(world, 1);
            for (int i = 0; i < COUNT; i++) {
                daft_dvec3 p = place_of(world, v, ids[i]);
                assert_true(daft_dfinite3(p) && fabs(p.x) < 1.2 && fabs(p.z) < 1.2);
                deepest = fmin(deepest, p.y);
                if (tick >= 840) lowest = fmin(lowest, p.y), fastest = fmax(fastest, speed_of(state_of(world, ids[i])));
            }
        }
        print_message("%s: lowest %g m, at the end %g m and at most %g m/s, %u awake\n", v->name, deepest, lowest,
                      fastest, daft_world_counters(world).awake);
        assert_true(deepest > 0.02 && lowest > 0.048 && fastest < 0.1);
        hashes[k] = daft_world_hash(world, 0);
        daft_world_destroy(world);
    }
    assert_workers_agree(hashes);
    for (int i = 0; i < 4; i++) daft_hull_free(hulls[i]);
}

/* Two side by side, and one in the furrow between them, all rolling free but for chocks: they touch on their sides, at
 * a radius. */
static void logs_lie_in_a_pile(void **unused)
{
    (void)unused;
    daft_hull *hull = cylinder(0.25, 1);
    daft_world *world = new_world();
    add_floor(world, 10);
    for (int side = -1; side <= 1; side += 2) add(world, box(daft_v3(0.1f, 0.3f, 2), side * 0.61, 0.3, 0));
    uint32_t ids[3];
    for (int i = 0; i < 3; i++) {
        one_shape def =
            roller(hull, i == 2 ? 0 : 0.5 * i - 0.25, i == 2 ? 0.25 + 0.5 * sqrt(3.0) / 2 + 0.01 : 0.2501, 0.05 * i);
        def.rotation = turned(1, 0, 0, DAFT_PI / 2);
        ids[i] = add(world, def);
    }
    steps(world, 600);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < a; b++) {
            daft_dvec3 d = daft_dsub(state_of(world, ids[a]).position, state_of(world, ids[b]).position);
            print_message("%d and %d: %g m between their axes\n", a, b, hypot(d.x, d.y));
            assert_true(hypot(d.x, d.y) > 0.498 && hypot(d.x, d.y) < 0.53);
        }
    assert_int_equal(daft_world_counters(world).awake, 0);
    daft_world_destroy(world);
    daft_hull_free(hull);
}

/* At 100 to 1,000 m/s, spinning, against a plate of 1 mm: none passes. DAFT_SHOTS=1000 for as many as the table asks
 * for. */
static uint64_t cylinder_shots(const variant *v)
{
    uint64_t hash = 0;
    seed_random(77);
    const char *wanted = getenv("DAFT_SHOTS");
    daft_hull *hulls[3] = {cylinder(0.005, 0.01), cylinder(0.1, 0.2), cylinder(0.2, 0.01)};
    for (int shot = 0; shot < (wanted ? atoi(wanted) : 300); shot++) {
        daft_world *world = variant_world(v);
        daft_world_set_gravity(world, daft_v3(0, 0, 0));
        put(world, v, box(daft_v3(0.0005f, 20, 20), 0, 0, 0));
        daft_dvec3 aim = daft_dv3(1, 0, 0), axis = random_in(-1, 1), spin = random_in(-90, 90);
        aim.y = uniform(-1, 1), aim.z = uniform(-1, 1);
        double back = 3 + uniform(0, 10), speed = uniform(100, 1000) / sqrt(daft_ddot(aim, aim));
        one_shape def = roller(hulls[shot % 3], -back * aim.x, -back * aim.y, -back * aim.z);
        def.rotation = turned(axis.x, axis.y + 1.5, axis.z, uniform(0, 6));
        uint32_t id = put(world, v, def);
        launch(world, v, id, daft_to_float(daft_dscale(aim, speed)), daft_to_float(spin));
        for (int i = 0; i < (int)(back / speed * 60) + 20; i++) {
            steps(world, 1);
            daft_dvec3 p = place_of(world, v, id);
            if (fmax(fabs(p.y), fabs(p.z)) > 19) break; /* past the plate's edge */
            if (p.x >= 0) fail_msg("shot %d passed at %g m/s", shot, speed);
        }
        hash = hash_of_both(hash, end_of(world));
    }
    for (int i = 0; i < 3; i++) daft_hull_free(hulls[i]);
    return hash;
}

static void fast_ones_stop_at_thin_walls(void **unused)
{
    (void)unused;
    play_variants(cylinder_shots);
}

/* Mass and inertia are a cylinder's, and a size that is none is refused. */
static void it_weighs_what_a_cylinder_does(void **unused)
{
    (void)unused;
    daft_hull *hull = cylinder(0.3, 0.7);
    daft_sim_shape shape = daft_shape_hull(hull);
    daft_mass mass;
    assert_true(daft_shape_mass(&shape, 1000, &mass));
    double m = 1000 * DAFT_PI * 0.09 * 1.4;
    assert_near(mass.mass, m, 1e-3);
    assert_near(mass.inertia[4], m * 0.09 / 2, 1e-3);
    assert_near(mass.inertia[0], m * (0.09 / 4 + 0.49 / 3), 1e-3);
    daft_rigid pose = daft_rigid_make(daft_dv3(1, 2, 3), turned(1, 2, 3, 0.7));
    daft_daabb bounds = daft_shape_bounds(&shape, &pose);
    for (int i = 0; i < 1000; i++) {
        double angle = 2 * DAFT_PI * i / 1000;
        daft_dvec3 p =
            daft_rigid_point(&pose, daft_dv3(0.3 * daft_cos(angle), i & 1 ? 0.7 : -0.7, 0.3 * daft_sin(angle)));
        assert_true(p.x >= bounds.low.x - 1e-7 && p.y >= bounds.low.y - 1e-7 && p.z >= bounds.low.z - 1e-7);
        assert_true(p.x <= bounds.high.x + 1e-7 && p.y <= bounds.high.y + 1e-7 && p.z <= bounds.high.z + 1e-7);
    }
    daft_hull_free(hull);
    static const float bad[] = {0, -1, NAN, INFINITY, 1e30f};
    daft_error error = {0};
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++)
        for (int k = 0; k < 2; k++)
            assert_null(daft_hull_create_cylinder(&heap, k ? bad[i] : 1, k ? 1 : bad[i], &error));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_rolls_down_a_slope),        cmocka_unit_test(it_rolls_on),
        cmocka_unit_test(a_coin_rolls_on_its_rim),      cmocka_unit_test(it_rests),
        cmocka_unit_test(a_pile_of_them_rests),         cmocka_unit_test(logs_lie_in_a_pile),
        cmocka_unit_test(fast_ones_stop_at_thin_walls), cmocka_unit_test(it_weighs_what_a_cylinder_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
