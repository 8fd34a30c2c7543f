/* sim, cases of the table that move: free rotation about each axis, tops, orbits, stiff springs, a ball over beams with
 * bevelled edges, loads on what is weak, a bridge with a door, and a million steps of nothing. */
#include "sim_cases.h"

/* ---- spin ---- */

/* 0.7×0.16×1 m, turned at 5 rad/s about each of its axes, by 0.01 about the others: only that of the middle moment
 * turns over. Energy and momentum stay within 1 %. */
static uint64_t free_spins(const variant *v)
{
    uint64_t hash = 0;
    const daft_vec3 half = daft_v3(0.35f, 0.08f, 0.5f);
    const double h[3] = {0.35, 0.08, 0.5};
    double moment[3];
    for (int i = 0; i < 3; i++) moment[i] = (h[(i + 1) % 3] * h[(i + 1) % 3] + h[(i + 2) % 3] * h[(i + 2) % 3]) / 3;
    for (int axis = 0; axis < 3; axis++) {
        daft_world *world = variant_world(v);
        daft_world_set_gravity(world, daft_v3(0, 0, 0));
        uint32_t id = put(world, v, dynamic_box(half, 0, 0, 0));
        launch(world, v, id, daft_v3(0, 0, 0),
               daft_v3(axis == 0 ? 5 : 0.01f, axis == 1 ? 5 : 0.01f, axis == 2 ? 5 : 0.01f));
        double energy0 = 0, momentum0 = 0, energy_off = 0, momentum_off = 0, sign = 1;
        int flips = 0;
        for (int i = 0; i < 3600; i++) {
            daft_sim_state s = state_in(world, v, id);
            daft_rigid frame = daft_rigid_make(s.position, s.rotation);
            daft_dvec3 w = daft_rigid_to_local_vector(&frame, daft_to_double(s.angular));
            double at[3] = {w.x, w.y, w.z}, energy = 0, momentum = 0;
            for (int k = 0; k < 3; k++)
                energy += moment[k] * at[k] * at[k], momentum += moment[k] * moment[k] * at[k] * at[k];
            momentum = sqrt(momentum);
            if (i == 0) energy0 = energy, momentum0 = momentum;
            energy_off = fmax(energy_off, fabs(energy / energy0 - 1)),
            momentum_off = fmax(momentum_off, fabs(momentum / momentum0 - 1));
            if (at[axis] * sign < -2) flips++, sign = -sign;
            steps(world, 1);
        }
        print_message("axis %d: turned over %d times, energy within %g, momentum within %g\n", axis, flips, energy_off,
                      momentum_off);
        assert_true(energy_off < 0.01 && momentum_off < 0.01);
        assert_true(axis == 0 ? flips > 5 : flips == 0); /* x has the middle moment */
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void only_the_middle_axis_turns_over(void **unused)
{
    (void)unused;
    play_variants(free_spins);
}

/* A square plate 0.5 m from a ball joint, its axis level, at 100 rad/s: it goes round at m g l / (I w), and stays level
 * for a minute. */
static uint64_t tops(const variant *v)
{
    uint64_t hash = 0;
    for (int k = 0; k < 2; k++) {
        double side = k ? -1 : 1, spin = 100, arm = 0.5;
        daft_world *world = variant_world(v);
        daft_world_set_sleeping(world, false);
        one_shape disc = dynamic_box(daft_v3(0.02f, 0.25f, 0.25f), arm, 0, 0);
        uint32_t id = put(world, v, disc);
        daft_sim_joint_def def = daft_default_sim_joint_def();
        daft_error error = {0};
        def.body_b = id, def.anchor = variant_at(v, daft_dv3(0, 0, 0));
        assert_true(daft_world_add_joint(world, &def, &error));
        double inertia = 2.0 / 3 * 0.25 * 0.25, wanted = side * G * arm / (inertia * spin);
        launch(world, v, id, daft_v3(0, 0, (float)(-wanted * arm)), daft_v3((float)(side * spin), (float)wanted, 0));
        double turned_by = 0, last = 0, high = 0, stretch = 0;
        for (int i = 0; i < 3600; i++) {
            steps(world, 1);
            daft_dvec3 p = state_in(world, v, id).position;
            double angle = daft_atan2(-p.z, p.x), step = angle - last;
            turned_by += step > DAFT_PI ? step - 2 * DAFT_PI : step < -DAFT_PI ? step + 2 * DAFT_PI : step;
            last = angle;
            high = fmax(high, fabs(p.y)), stretch = fmax(stretch, fabs(sqrt(daft_ddot(p, p)) - arm));
        }
        daft_sim_state s = state_in(world, v, id);
        print_message("%g rad/s, wanted %g; %g m up or down, %g m off, spin at the end %g\n", turned_by / 60, wanted,
                      high, stretch, (double)daft_length(s.angular));
        assert_near(turned_by / 60, wanted, 0.05 * fabs(wanted));
        assert_true(high < 0.1 * arm && stretch < 1e-3);
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void a_top_precesses(void **unused)
{
    (void)unused;
    play_variants(tops);
}

/* ---- orbits and springs ---- */

/* Over orbits of eccentricity 0.5: the most that energy was off by, and how far the line that fits it best rises from
 * the first orbit to the last. */
typedef struct orbit_error {
    double most, trend;
} orbit_error;

static orbit_error orbit(const variant *v, int orbits, int steps_an_orbit, uint64_t *hash)
{
    daft_world *world = variant_world(v);
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    double near = 50, e = 0.5, a = near / (1 - e), period = steps_an_orbit / 60.0,
           mu = 4 * DAFT_PI * DAFT_PI * a * a * a / (period * period);
    uint32_t id = put(world, v, sphere(0.5, near, 0, 0));
    double mass = (double)daft_world_mass(world, id), first = -mu / (2 * a), sum = 0;
    launch(world, v, id, daft_v3(0, 0, (float)sqrt(mu * (1 + e) / near)), daft_v3(0, 0, 0));
    orbit_error out = {0, 0};
    for (int n = 0; n < orbits; n++) {
        for (int i = 0; i < steps_an_orbit; i++) {
            daft_sim_state s = state_in(world, v, id);
            double r = sqrt(daft_ddot(s.position, s.position)),
                   off = (0.5 * speed_of(s) * speed_of(s) - mu / r) / first - 1;
            out.most = fmax(out.most, fabs(off));
            sum += off * (n - 0.5 * (orbits - 1)) / steps_an_orbit;
            daft_world_apply_force(
                world, id, variant_direction(v, daft_to_float(daft_dscale(s.position, -mass * mu / (r * r * r)))));
            steps(world, 1);
        }
    }
    out.trend = sum * 12 / ((double)orbits * orbits); /* slope times their number */
    *hash = hash_of_both(*hash, end_of(world));
    return out;
}

/* The force of the game is integrated by the symplectic Euler method: an order of one, and no drift. */
static uint64_t orbits(const variant *v)
{
    uint64_t hash = 0;
    static const int counts[] = {120, 240, 480, 960};
    double before = 0;
    for (int k = 0; k < 4; k++) {
        orbit_error e = orbit(v, 100, counts[k], &hash);
        print_message("%d steps an orbit: energy within %g, trend %g, order %g\n", counts[k], e.most, e.trend,
                      k ? log2(before / e.most) : 0);
        assert_true(e.most < 13.0 / counts[k] && fabs(e.trend) < 0.02 * e.most);
        if (k > 1) assert_near(log2(before / e.most), 1, 0.2);
        before = e.most;
    }
    enum { ORBITS = SANITIZED ? 100 : 1000 };
    orbit_error e = orbit(v, ORBITS, 240, &hash);
    print_message("%d orbits: energy within %g, trend %g an orbit\n", ORBITS, e.most, e.trend / ORBITS);
    assert_true(fabs(e.trend / ORBITS) < 1e-3 * e.most && fabs(e.trend) < 0.02 * e.most);
    return hash;
}

static void an_orbit_is_as_right_as_its_steps(void **unused)
{
    (void)unused;
    play_variants(orbits);
}

/* A weight on a spring, undamped, of 10 and of 200 Hz: it never swings wider than it began. */
static uint64_t weight_on_spring(const variant *v, daft_joint_kind kind, float hertz, bool weightless)
{
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, false);
    if (weightless) daft_world_set_gravity(world, daft_v3(0, 0, 0));
    uint32_t id = put(world, v, sphere(0.1, 0, -1, 0));
    daft_sim_joint_def def = daft_default_sim_joint_def();
    daft_error error = {0};
    bool slides = kind == DAFT_JOINT_SLIDER;
    def.kind = kind, def.body_b = id, def.anchor = variant_at(v, daft_dv3(0, slides ? -1 : 0, 0)),
    def.anchor_b = variant_at(v, daft_dv3(0, -1, 0));
    def.axis = daft_v3(0, 1, 0), def.spring = true, def.hertz = hertz, def.damping = 0;
    assert_true(daft_world_add_joint(world, &def, &error));
    launch(world, v, id, daft_v3(0, 3, 0), daft_v3(0, 0, 0));
    double omega = 2 * DAFT_PI * (double)hertz, rest = weightless ? -1 : -1 - G / (omega * omega);
    double reach = hypot(3 / omega, rest + 1), widest = 0, late = 0;
    for (int i = 0; i < 6000; i++) {
        steps(world, 1);
        daft_sim_state s = state_in(world, v, id);
        assert_true(daft_dfinite3(s.position) && daft_finite3(s.linear));
        widest = fmax(widest, fabs(s.position.y - rest));
        if (i >= 5400) late = fmax(late, fabs(s.position.y - rest));
    }
    print_message("%s, %g Hz, %s: swings %g m where it should %g, at the end %g\n", slides ? "slider" : "distance",
                  (double)hertz, weightless ? "weightless" : "hanging", widest, reach, late);
    assert_true(widest < 1.1 * reach && late <= widest);
    return end_of(world);
}

static uint64_t springs(const variant *v)
{
    uint64_t hash = 0;
    for (int k = 0; k < 8; k++)
        hash = hash_of_both(
            hash, weight_on_spring(v, k & 1 ? DAFT_JOINT_SLIDER : DAFT_JOINT_DISTANCE, k & 2 ? 200 : 10, k & 4));
    return hash;
}

static void stiff_springs_stay_bounded(void **unused)
{
    (void)unused;
    play_variants(springs);
}

/* ---- over beams ---- */

/* Beams of 20 cm side by side, their upper edges bevelled by 1 cm. A ball of 0.25 m sinks into a groove by 0.2 mm at
 * most, and the far edge turns its way up by 0.04 rad: at 5 m/s it may hop 2 mm. It was 127 mm when edges ahead were
 * felt before they were met. */
static uint64_t bevelled_beams(const variant *v)
{
    uint64_t hash = 0;
    daft_vec3 p[12];
    for (int i = 0; i < 12; i++) {
        static const float xs[] = {-0.1f, 0.1f, -0.1f, 0.1f, -0.09f, 0.09f},
                           ys[] = {-0.2f, -0.2f, -0.01f, -0.01f, 0, 0};
        p[i] = daft_v3(xs[i % 6], ys[i % 6], i < 6 ? -2 : 2);
    }
    daft_allocator allocator = daft_malloc_allocator();
    daft_error error = {0};
    daft_hull *hull = daft_hull_create(&allocator, p, 12, 0, &error);
    assert_non_null(hull);
    static const double speeds[] = {2.1, 5, 9}, radii[] = {0.25, 0.5}, most[] = {0.003, 0.01, 0.02};
    for (int k = 0; k < 6; k++) {
        double speed = speeds[k / 2], r = radii[k % 2], highest = 0, lowest = 1, slowest = 99;
        daft_world *world = variant_world(v);
        for (int i = 0; i < 100; i++) {
            one_shape beam = box(daft_v3(1, 1, 1), 0.2 * i, 0, 0);
            beam.part.shape = daft_shape_hull(hull);
            put(world, v, beam);
        }
        uint32_t ball = put(world, v, sphere(r, 0.05, r, 0.1));
        launch(world, v, ball, daft_v3((float)speed, 0, 0), daft_v3(0, 0, (float)(-speed / r)));
        for (int i = 0; i < (int)(15 / speed * 60); i++) {
            steps(world, 1);
            daft_dvec3 at = place_of(world, v, ball);
            highest = fmax(highest, at.y - r), lowest = fmin(lowest, at.y - r);
            slowest = fmin(slowest, speed_of(state_of(world, ball)));
        }
        daft_dvec3 at = place_of(world, v, ball);
        print_message("%g m/s, radius %g: %g mm up, %g mm down, slowest %g m/s, %g mm aside\n", speed, r, 1e3 * highest,
                      -1e3 * lowest, slowest, 1e3 * (at.z - 0.1));
        assert_true(highest < most[k / 2] && lowest > -0.01 && slowest > 0.8 * speed && fabs(at.z - 0.1) < 0.01);
        hash = hash_of_both(hash, end_of(world));
    }
    daft_hull_free(hull);
    return hash;
}

static void a_ball_rolls_over_bevelled_beams(void **unused)
{
    (void)unused;
    play_variants(bevelled_beams);
}

/* ---- pushed by what moves ---- */

/* A slab goes up, down and aside under a capsule that lies on it; it is carried, not thrown. */
static uint64_t capsule_on_slab(const variant *v)
{
    uint64_t hash = 0;
    for (int up = 0; up < 3; up++) {
        daft_world *world = variant_world(v);
        daft_world_set_sleeping(world, false);
        one_shape slab = box(daft_v3(3, 0.25f, 3), 0, -0.25, 0);
        slab.kind = DAFT_BODY_KINEMATIC;
        uint32_t table = put(world, v, slab);
        one_shape def = sphere(0.25, 0, 0.25, 0);
        daft_error error = {0};
        assert_true(daft_shape_capsule(0.5f, 0.25f, &def.part.shape, &error));
        def.rotation = turned(0, 0, 1, DAFT_PI / 2);
        def.rolling_resistance = 0.05f;
        uint32_t capsule = put(world, v, def);
        steps(world, 60);
        double over = 0, under = 0;
        for (int i = 0; i < 600; i++) {
            double t = i / 60.0;
            daft_dvec3 at = up == 0   ? daft_dv3(0.3 * t, -0.25, 0)
                            : up == 1 ? daft_dv3(0, -0.25 + 0.3 * (1 - daft_cos(2 * t)), 0)
                                      : daft_dv3(0.2 * daft_sin(2 * t), -0.25, 0);
            daft_world_set_pose(world, table, variant_at(v, at), daft_quat_identity(), false);
            steps(world, 1);
            double height = place_of(world, v, capsule).y - place_of(world, v, table).y - 0.5;
            over = fmax(over, height), under = fmin(under, height);
        }
        print_message("way %d: %g mm up, %g mm down\n", up, 1e3 * over, 1e3 * under);
        assert_true(over < 2e-3 && under > -2e-3);
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void a_capsule_rides_what_moves(void **unused)
{
    (void)unused;
    play_variants(capsule_on_slab);
}

/* ---- what sways ---- */

/* Widest of the first five and of the last five of 30 s, radians. */
typedef struct swing {
    double early, late;
} swing;

static swing swing_of(daft_world *world, uint32_t body)
{
    swing s = {0, 0};
    for (int tick = 0; tick < 1800; tick++) {
        steps(world, 1);
        daft_quat q = state_of(world, body).rotation;
        double angle = fabs(2 * daft_atan2((double)q.z, (double)q.w));
        if (tick < 300) s.early = fmax(s.early, angle);
        if (tick >= 1500) s.late = fmax(s.late, angle);
    }
    return s;
}

/* A flat box across a ball that does not move, rolled to one side by `angle`. */
static uint32_t add_rocking_box(daft_world *world, const variant *v, double radius, double half, double angle)
{
    one_shape ball = sphere(radius, 0, 0, 0);
    ball.kind = DAFT_BODY_STATIC;
    put(world, v, ball);
    double s = daft_sin(angle), c = daft_cos(angle), up = radius + half, along = radius * angle;
    one_shape shape = dynamic_box(daft_v3(0.3f, (float)half, 0.25f), up * s - along * c, up * c + along * s, 0);
    daft_sim_shape_def part = shape.part;
    daft_sim_body_def def = daft_default_sim_body_def();
    daft_error error = {0};
    def.kind = DAFT_BODY_DYNAMIC, def.position = variant_at(v, shape.position),
    def.rotation = variant_turn(v, turned(0, 0, 1, -angle));
    def.shapes = &part, def.shape_count = 1, def.locks = DAFT_LOCK_POSITION_Z | DAFT_LOCK_X | DAFT_LOCK_Y;
    return daft_world_add(world, &def, &error);
}

/* A light ball with a heavy one low inside. */
static uint32_t add_roly_poly(daft_world *world, const variant *v, double angle)
{
    put_floor(world, v, 20);
    daft_sim_shape_def parts[2] = {sphere(0.5, 0, 0, 0).part, sphere(0.1, 0, 0, 0).part};
    daft_sim_body_def def = daft_default_sim_body_def();
    daft_error error = {0};
    parts[0].density = 100, parts[1].density = 20000, parts[1].position = daft_v3(0, -0.3f, 0);
    def.kind = DAFT_BODY_DYNAMIC, def.position = variant_at(v, daft_dv3(0, 0.5, 0)),
    def.rotation = variant_turn(v, turned(0, 0, 1, angle));
    def.shapes = parts, def.shape_count = 2;
    return daft_world_add(world, &def, &error);
}

/* Nothing but rolling takes part, so it goes on for long, but never grows. */
static uint64_t rolling_to_and_fro(const variant *v)
{
    uint64_t hash = 0;
    static const int substeps[] = {1, 2, 4, 8, 16};
    static const char *const names[] = {"roly-poly", "flat box on a ball", "thick box on a ball"};
    static const double angles[] = {0.3, 0.1, 0.28}, least[] = {0.9, 0.3, 0.9};
    for (size_t i = 0; i < DAFT_COUNT_OF(substeps); i++)
        for (int scene = 0; scene < 3; scene++) {
            daft_world *world = variant_world(v);
            daft_world_set_substeps(world, substeps[i]);
            daft_world_set_sleeping(world, false);
            double angle = angles[scene];
            uint32_t body = scene == 0   ? add_roly_poly(world, v, angle)
                            : scene == 1 ? add_rocking_box(world, v, 0.5, 0.1, angle)
                                         : add_rocking_box(world, v, 0.28, 0.2, angle);
            assert_true(body != 0);
            swing s = swing_of(world, body);
            print_message("%s, %d substeps: %g rad, %g after 25 s\n", names[scene], substeps[i], s.early, s.late);
            assert_true(s.early > 0.9 * angle && s.early < 1.3 * angle && s.late < s.early &&
                        s.late > least[scene] * s.early);
            hash = hash_of_both(hash, end_of(world));
        }
    return hash;
}

static void what_rolls_to_and_fro_gains_nothing(void **unused)
{
    (void)unused;
    play_variants(rolling_to_and_fro);
}

/* ---- a long time ---- */

static size_t allocated;
static void *counted_allocate(void *user, size_t size, size_t alignment)
{
    (void)user;
    allocated++;
    return heap.allocate(NULL, size, alignment);
}
static void counted_release(void *user, void *pointer)
{
    (void)user;
    heap.release(NULL, pointer);
}

/* Ten boxes on each other, 4.6 hours. */
static void a_million_steps_of_rest_change_nothing(void **unused)
{
    (void)unused;
    heap = daft_malloc_allocator();
    daft_allocator counted = {.user = NULL, .allocate = counted_allocate, .release = counted_release};
    daft_error error = {0};
    daft_world *world = daft_world_create(&counted, &error);
    assert_non_null(world);
    add_floor(world, 10);
    uint32_t ids[10];
    daft_dvec3 from[10];
    for (int i = 0; i < 10; i++) ids[i] = add(world, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 0.5 + i, 0));
    steps(world, 600);
    for (int i = 0; i < 10; i++) from[i] = state_of(world, ids[i]).position;
    size_t before = allocated;
    steps(world, 1000000);
    double moved = 0;
    for (int i = 0; i < 10; i++) moved = fmax(moved, distance_of(from[i], state_of(world, ids[i]).position));
    print_message("moved %g m, %zu allocations\n", moved, allocated - before);
    assert_true(moved < 1e-3 && allocated == before);
    /* Awake as well, for as long as is bearable. */
    daft_world_set_sleeping(world, false);
    steps(world, SANITIZED ? 2000 : 20000);
    before = allocated;
    for (int i = 0; i < 10; i++) moved = fmax(moved, distance_of(from[i], state_of(world, ids[i]).position));
    print_message("awake: moved %g m, %zu allocations\n", moved, allocated - before);
    assert_true(moved < 1e-3);
    daft_world_destroy(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_the_middle_axis_turns_over),     cmocka_unit_test(a_top_precesses),
        cmocka_unit_test(an_orbit_is_as_right_as_its_steps),   cmocka_unit_test(stiff_springs_stay_bounded),
        cmocka_unit_test(a_ball_rolls_over_bevelled_beams),    cmocka_unit_test(a_capsule_rides_what_moves),
        cmocka_unit_test(what_rolls_to_and_fro_gains_nothing), cmocka_unit_test(a_million_steps_of_rest_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
