/* sim: what stands, stands; what swings or spins keeps its energy. Every case asserts a number. */
#include "sim_cases.h"

/* What is asked of stacks is asked wholly in one place, far away, and mirrored; with two and four workers a few seconds
 * of each are played. */
enum { HEARD = SANITIZED ? 60 : 300 }; /* ticks */

static uint32_t add_stack(daft_world *world, const variant *v, int count)
{
    uint32_t top = 0;
    for (int i = 0; i < count; i++) top = put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 0.5 + i, 0));
    return top;
}

/* How far a body gets from where it is now. */
static double most_drift(daft_world *world, const variant *v, uint32_t id, int count, uint64_t *hash)
{
    daft_dvec3 start = place_of(world, v, id);
    double worst = 0;
    for (int i = 0; i < count && !heard(world, v, i, HEARD, hash); i++) {
        steps(world, 1);
        worst = fmax(worst, distance_of(place_of(world, v, id), start));
    }
    return worst;
}

/* ---- standing ---- */

static uint64_t box_at_rest(const variant *v)
{
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, false);
    put_floor(world, v, 10);
    uint32_t id = put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0.3, 0.5001, -0.2));
    steps(world, 60);
    daft_dvec3 rest = place_of(world, v, id);
    double moved = 0, fastest = 0;
    for (int i = 0; i < 3600; i++) {
        steps(world, 1);
        moved = fmax(moved, distance_of(place_of(world, v, id), rest));
        fastest = fmax(fastest, speed_of(state_of(world, id)));
    }
    print_message("in 60 s it moved %g m, fastest %g m/s\n", moved, fastest);
    assert_true(moved < 1e-4 && fastest < 1e-3 && rest.y > 0.49);
    return end_of(world);
}

static void a_box_at_rest_stays(void **unused)
{
    (void)unused;
    play_variants(box_at_rest);
}

/* Asleep it could not fall: so also with sleep off. */
static uint64_t stack_stands(const variant *v, int boxes, int seconds, bool sleeping, double most)
{
    uint64_t hash = 0;
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, sleeping);
    put_floor(world, v, 10);
    uint32_t top = add_stack(world, v, boxes);
    double worst = most_drift(world, v, top, 60 * seconds, &hash), speed = speed_of(state_of(world, top));
    print_message("%d boxes, %d s, sleep %s: top at most %g mm from where it was put, at the end %g m/s\n", boxes,
                  seconds, sleeping ? "on" : "off", 1000 * worst, speed);
    assert_true(worst < most && (v->workers > 1 || speed < 0.001));
    assert_true(v->workers > 1 || daft_world_is_awake(world, top) != sleeping);
    daft_world_destroy(world);
    return hash;
}

static uint64_t twenty_boxes(const variant *v)
{
    uint64_t asleep = stack_stands(v, 20, 600, true, 0.002);
    return hash_of_both(asleep, stack_stands(v, 20, 600, false, 0.002));
}
static void twenty_boxes_stand_ten_minutes(void **unused)
{
    (void)unused;
    play_variants(twenty_boxes);
}

static uint64_t fifty_boxes(const variant *v)
{
    uint64_t asleep = stack_stands(v, 50, 60, true, 0.02);
    return hash_of_both(asleep, stack_stands(v, 50, 60, false, 0.02));
}
static void fifty_boxes_stand_a_minute(void **unused)
{
    (void)unused;
    play_variants(fifty_boxes);
}

static uint64_t pyramid_of_thirty_rows(const variant *v)
{
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, false);
    put_floor(world, v, 40);
    uint32_t ids[465], n = 0;
    for (int row = 0; row < 30; row++)
        for (int i = 0; i < 30 - row; i++)
            ids[n++] = put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 1.05 * (i + 0.5 * row - 15), 0.5 + row, 0));
    steps(world, 300);
    double slid = 0, sank = 0, fastest = 0;
    n = 0;
    for (int row = 0; row < 30; row++)
        for (int i = 0; i < 30 - row; i++) {
            daft_sim_state s = state_in(world, v, ids[n++]);
            slid = fmax(slid, hypot(s.position.x - 1.05 * (i + 0.5 * row - 15), s.position.z));
            sank = fmax(sank, 0.5 + row - s.position.y);
            fastest = fmax(fastest, speed_of(s));
        }
    print_message("slid at most %g mm, sank %g mm, fastest %g m/s\n", 1000 * slid, 1000 * sank, fastest);
    assert_true(slid < 0.005 && sank < 0.005 && fastest < 0.001);
    return end_of(world);
}

static void a_pyramid_of_thirty_rows_stands(void **unused)
{
    (void)unused;
    play_variants(pyramid_of_thirty_rows);
}

static uint64_t heavy_on_light(const variant *v)
{
    uint64_t hash = 0;
    const float ratios[] = {100, 1000};
    const double most[] = {0.001, 0.005}; /* m */
    for (int k = 0; k < 2; k++) {
        daft_world *world = variant_world(v);
        daft_world_set_sleeping(world, false);
        put_floor(world, v, 10);
        one_shape top = dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 1.5, 0);
        top.density = 1000 * ratios[k];
        uint32_t light = add_stack(world, v, 1), heavy = put(world, v, top);
        double lowest = 1, highest = 0, sank = 0;
        for (int i = 0; i < 1200; i++) {
            steps(world, 1);
            lowest = fmin(lowest, place_of(world, v, light).y);
            highest = fmax(highest, place_of(world, v, light).y);
            sank = fmax(sank, 1.5 - place_of(world, v, heavy).y);
        }
        print_message("%g:1: light one %g to %g m, heavy one sank %g m\n", (double)ratios[k], lowest, highest, sank);
        assert_true(lowest > 0.49 && highest < 0.51 && sank < most[k]);
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void heavy_on_light_holds(void **unused)
{
    (void)unused;
    play_variants(heavy_on_light);
}

/* Two boxes of a ton, and a thousand tons on them. */
static uint64_t thousand_tons(const variant *v)
{
    uint64_t hash = 0;
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, false);
    put_floor(world, v, 10);
    add_stack(world, v, 2);
    one_shape top = dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 2.5, 0);
    top.density = 1e6f;
    uint32_t heavy = put(world, v, top);
    double worst = most_drift(world, v, heavy, 3600, &hash), speed = speed_of(state_of(world, heavy));
    print_message("moved at most %g mm in a minute, at the end %g m/s\n", 1000 * worst, speed);
    assert_true(worst < 0.015 && (v->workers > 1 || speed < 0.001));
    daft_world_destroy(world);
    return hash;
}

static void a_thousand_times_heavier_stands_on_two(void **unused)
{
    (void)unused;
    play_variants(thousand_tons);
}

/* Contacts that carried much are pressed in by it; that must go with the load, without a throw. */
static uint64_t lost_load(const variant *v)
{
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, false);
    put_floor(world, v, 10);
    uint32_t ids[20];
    for (int i = 0; i < 20; i++) ids[i] = put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 0.5 + i, 0));
    steps(world, 60);
    for (int i = 2; i < 20; i++) daft_world_remove(world, ids[i]);
    double highest = 0;
    for (int i = 0; i < 120; i++) {
        steps(world, 1);
        highest = fmax(highest, place_of(world, v, ids[1]).y - 1.5);
    }
    daft_sim_state s = state_in(world, v, ids[1]);
    print_message("rose by %g mm, ends %g mm high\n", 1000 * highest, 1000 * (s.position.y - 1.5));
    assert_true(highest < 0.01 && fabs(s.position.y - 1.5) < 0.001 && speed_of(s) < 1e-3);
    return end_of(world);
}

static void what_loses_its_load_settles(void **unused)
{
    (void)unused;
    play_variants(lost_load);
}

/* In a floor of 500 boxes that all touch, in finer substeps it would be too much work: the column's contacts are made
 * firm. */
static uint64_t stack_in_a_heap(const variant *v)
{
    uint64_t hash = 0;
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, false);
    put_floor(world, v, 40);
    uint32_t top = add_stack(world, v, 20);
    for (int i = 0; i < 23 * 23; i++)
        if (i != 11 * 23 + 11) put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), i / 23 - 11, 0.5, i % 23 - 11));
    double aside = 0, fastest = 0;
    for (int i = 0; i < 3600 && !heard(world, v, i, HEARD, &hash); i++) {
        steps(world, 1);
        daft_sim_state s = state_in(world, v, top);
        aside = fmax(aside, hypot(s.position.x, s.position.z));
        if (i > 1800) fastest = fmax(fastest, speed_of(s));
    }
    daft_sim_counters counters = daft_world_counters(world);
    double sank = 19.5 - place_of(world, v, top).y;
    print_message("top of 20 among %u boxes, a minute: %g mm aside, sank %g mm, %u substeps, fastest %g m/s\n",
                  counters.bodies, 1000 * aside, 1000 * sank, counters.substeps, fastest);
    assert_true(counters.substeps == 4 && aside < 0.01 && sank < 0.03 && fastest < 0.005);
    daft_world_destroy(world);
    return hash;
}

static void a_stack_in_a_heap_stands(void **unused)
{
    (void)unused;
    play_variants(stack_in_a_heap);
}

/* A chain of 20 links of 1 kg, a ball of 100 kg or a ton at its end, swung from the side. */
static uint64_t ball_on_a_chain(const variant *v)
{
    uint64_t hash = 0;
    const int counts[] = {4, 8, 16, 4};
    const double most[] = {0.05, 0.02, 0.01, 0.03};
    const float densities[] = {23.873f, 23.873f, 23.873f, 238.73f};
    for (int k = 0; k < 4; k++) {
        daft_world *world = variant_world(v);
        daft_world_set_substeps(world, counts[k]);
        uint32_t last = 0, joints = 0;
        daft_error error = {0};
        for (int i = 0; i < 21; i++) {
            one_shape link = i < 20 ? dynamic_box(daft_v3(0.5f, 0.1f, 0.1f), 0.5 + i, 0, 0) : sphere(1, 21, 0, 0);
            link.density = i < 20 ? 25 : densities[k];
            uint32_t body = put(world, v, link);
            daft_sim_joint_def def = daft_default_sim_joint_def();
            def.body_a = last, def.body_b = body, def.anchor = variant_at(v, daft_dv3(i, 0, 0));
            joints = daft_world_add_joint(world, &def, &error);
            assert_true(joints);
            last = body;
        }
        double stretch = 0;
        for (int i = 0; i < 600; i++) {
            steps(world, 1);
            for (uint32_t j = 1; j <= joints; j++) {
                daft_sim_joint_state s;
                assert_true(daft_world_get_joint(world, j, &s));
                daft_dvec3 d = daft_dsub(s.anchor_b, s.anchor_a);
                stretch = fmax(stretch, sqrt(daft_ddot(d, d)));
            }
        }
        print_message("%g kg, %d substeps: a joint opened by at most %g m\n", (double)daft_world_mass(world, last),
                      counts[k], stretch);
        assert_true(stretch < most[k]);
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void a_heavy_ball_on_a_chain_does_not_stretch_it(void **unused)
{
    (void)unused;
    play_variants(ball_on_a_chain);
}

/* ---- spinning and swinging ---- */

/* Moments of inertia as 1 : 2 : 3 and a spin about the middle one: it turns over again and again. */
static uint64_t spinning_handle(const variant *v)
{
    daft_world *world = variant_world(v);
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    one_shape def = dynamic_box(daft_v3((float)sqrt(2.0), 1, 0.001f), 0, 0, 0);
    uint32_t id = put(world, v, def);
    launch(world, v, id, daft_v3(0, 0, 0), daft_v3(5, 0.01f, 0)); /* moments 1, 2, 3 along x, y, z */
    launch(world, v, id, daft_v3(0, 0, 0), daft_v3(0.01f, 5, 0));
    double first = 0, worst = 0, turned_over = 0, sign = 1;
    for (int i = 0; i < 3600; i++) {
        daft_sim_state s = state_in(world, v, id);
        daft_rigid frame = daft_rigid_make(s.position, s.rotation);
        daft_dvec3 w = daft_rigid_to_local_vector(&frame, daft_to_double(s.angular));
        double energy = w.x * w.x + 2 * w.y * w.y + 3 * w.z * w.z;
        if (i == 0) first = energy;
        worst = fmax(worst, fabs(energy / first - 1));
        if (w.y * sign < -2) turned_over++, sign = -sign;
        steps(world, 1);
    }
    print_message("turned over %g times, energy within %g\n", turned_over, worst);
    assert_true(turned_over == 11 && worst < 1e-3);
    return end_of(world);
}

static void a_spinning_handle_flips_for_ever(void **unused)
{
    (void)unused;
    play_variants(spinning_handle);
}

/* A ball of 1 cm on an arm of 1 m, let go from the horizontal. */
typedef struct swings {
    double worst, trend; /* most that its energy was off, of m g L; how far the line that fits that best rises from
                            first to last */
    double stretch, period;
} swings;

static swings swing_for(const variant *v, int substeps, int ticks, uint64_t *hash)
{
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, false);
    daft_world_set_substeps(world, substeps);
    daft_error error = {0};
    uint32_t bob = put(world, v, sphere(0.01, 1, 0, 0));
    daft_sim_joint_def def = daft_default_sim_joint_def();
    def.body_b = bob, def.anchor = variant_at(v, daft_dv3(0, 0, 0));
    assert_true(daft_world_add_joint(world, &def, &error));
    swings out = {0};
    double last = 1, first_pass = 0, last_pass = 0;
    int passes = 0;
    for (int i = 0; i < ticks; i++) {
        steps(world, 1);
        daft_sim_state s = state_in(world, v, bob);
        double off = (0.5 * speed_of(s) * speed_of(s) + G * s.position.y) / G;
        out.worst = fmax(out.worst, fabs(off));
        out.trend += 12 * off * (i - 0.5 * ticks) / ((double)ticks * ticks);
        out.stretch = fmax(out.stretch, fabs(hypot(s.position.x, s.position.y) - 1));
        if ((last > 0) != (s.position.x > 0) && passes++ < 201) {
            double when = (i - s.position.x / (s.position.x - last)) / 60;
            if (passes == 1) first_pass = when;
            if (passes == 201) last_pass = when;
        }
        last = s.position.x;
    }
    out.period = (last_pass - first_pass) / 100;
    *hash = hash_of_both(*hash, end_of(world));
    return out;
}

/* A thousand periods: what it gains in each is less than a thousandth of what its energy goes to and fro by. */
static uint64_t pendulum(const variant *v)
{
    enum { PERIODS = SANITIZED ? 110 : 1000, TICKS = SANITIZED ? 15628 : 142072 };
    uint64_t hash = 0;
    swings s = swing_for(v, 4, TICKS, &hash);
    print_message("energy within %g, trend %g, stretch %g m, period %g s\n", s.worst, s.trend, s.stretch, s.period);
    assert_true(s.worst < 0.01 && fabs(s.trend / PERIODS) < 1e-3 * s.worst && fabs(s.trend) < 0.1 * s.worst &&
                s.stretch < 1e-4);
    assert_near(s.period, 2.3678, 0.001 * 2.3678);
    return hash;
}

static void a_pendulum_keeps_its_energy(void **unused)
{
    (void)unused;
    play_variants(pendulum);
}

/* Twice the substeps, half the error of its energy: an order of one. */
static uint64_t finer_pendulums(const variant *v)
{
    uint64_t hash = 0;
    double before = 0;
    for (int substeps = 2; substeps <= 16; substeps *= 2) {
        swings s = swing_for(v, substeps, 1421, &hash);
        print_message("%d substeps: energy within %g, order %g\n", substeps, s.worst,
                      before > 0 ? log2(before / s.worst) : 0);
        if (before > 0) assert_near(log2(before / s.worst), 1, 0.2);
        before = s.worst;
    }
    return hash;
}

static void a_pendulum_is_as_right_as_its_substeps(void **unused)
{
    (void)unused;
    play_variants(finer_pendulums);
}

/* A planet drawn to the sun by a force the game gives in every step. */
static uint64_t circular_orbit(const variant *v)
{
    enum { TICKS = SANITIZED ? 10000 : 100000 };
    daft_world *world = variant_world(v);
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    uint32_t id = put(world, v, sphere(0.5, 100, 0, 0));
    double mass = (double)daft_world_mass(world, id), mu = 1e4, first = 0, worst = 0, late = 0;
    launch(world, v, id, daft_v3(0, 0, 8.0f), daft_v3(0, 0, 0));
    for (int i = 0; i < TICKS; i++) {
        daft_sim_state s = state_in(world, v, id);
        double r = sqrt(daft_ddot(s.position, s.position)), energy = 0.5 * speed_of(s) * speed_of(s) - mu / r;
        if (i == 0) first = energy;
        worst = fmax(worst, fabs(energy / first - 1));
        if (i > TICKS / 10 * 9) late = fmax(late, fabs(energy / first - 1));
        daft_world_apply_force(world, id,
                               variant_direction(v, daft_to_float(daft_dscale(s.position, -mass * mu / (r * r * r)))));
        steps(world, 1);
    }
    print_message("energy within %g, in the last tenth %g\n", worst, late);
    assert_true(worst < 0.01 && late < 0.01);
    return end_of(world);
}

static void an_orbit_keeps_its_energy(void **unused)
{
    (void)unused;
    play_variants(circular_orbit);
}

/* ---- surfaces ---- */

static uint64_t boxes_on_slopes(const variant *v)
{
    uint64_t hash = 0;
    for (float friction = 0.2f; friction < 0.9f; friction += 0.2f)
        for (int k = 0; k < 2; k++) {
            double angle = daft_atan2((k ? 1.1 : 0.9) * (double)friction, 1);
            double s = daft_sin(angle), c = daft_cos(angle);
            daft_world *world = variant_world(v);
            daft_world_set_sleeping(world, false);
            one_shape slope = box(daft_v3(200, 1, 5), 0, 0, 0),
                      def = dynamic_box(daft_v3(0.5f, 0.2f, 0.5f), 1.2 * s, 1.2 * c, 0);
            slope.rotation = def.rotation = turned(0, 0, 1, -angle);
            slope.friction = def.friction = friction;
            put(world, v, slope);
            uint32_t id = put(world, v, def);
            steps(world, 60);
            daft_dvec3 from = place_of(world, v, id);
            double v0 = speed_of(state_of(world, id));
            steps(world, k ? 120 : 600);
            if (k)
                assert_near((speed_of(state_of(world, id)) - v0) / 2, G * (s - (double)friction * c), 0.02 * G * s);
            else
                assert_true(distance_of(place_of(world, v, id), from) < 1e-3);
            hash = hash_of_both(hash, end_of(world));
        }
    return hash;
}

static void a_box_on_a_slope_obeys_friction(void **unused)
{
    (void)unused;
    play_variants(boxes_on_slopes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_at_rest_stays),
        cmocka_unit_test(twenty_boxes_stand_ten_minutes),
        cmocka_unit_test(fifty_boxes_stand_a_minute),
        cmocka_unit_test(a_pyramid_of_thirty_rows_stands),
        cmocka_unit_test(heavy_on_light_holds),
        cmocka_unit_test(a_thousand_times_heavier_stands_on_two),
        cmocka_unit_test(what_loses_its_load_settles),
        cmocka_unit_test(a_stack_in_a_heap_stands),
        cmocka_unit_test(a_heavy_ball_on_a_chain_does_not_stretch_it),
        cmocka_unit_test(a_spinning_handle_flips_for_ever),
        cmocka_unit_test(a_pendulum_keeps_its_energy),
        cmocka_unit_test(a_pendulum_is_as_right_as_its_substeps),
        cmocka_unit_test(an_orbit_keeps_its_energy),
        cmocka_unit_test(a_box_on_a_slope_obeys_friction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
