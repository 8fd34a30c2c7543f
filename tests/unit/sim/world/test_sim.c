/* sim: what a game relies on when bodies rest, roll, slide, bounce and ride. Every case asserts a number; closed forms
 * are used where physics has one. */
#include "sim_cases.h"

/* ---- at rest, free, and rolling ---- */

static void a_sphere_at_rest_stays(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add_floor(world, 10);
    uint32_t ball = add(world, sphere(0.25, 1, 0.2501, -2));
    steps(world, 60);
    daft_sim_state rest = state_of(world, ball);
    assert_near(rest.position.y, 0.25, 1e-4);
    double moved = 0, fastest = 0;
    for (int i = 0; i < 3600; i++) {
        steps(world, 1);
        daft_sim_state s = state_of(world, ball);
        daft_dvec3 d = daft_dsub(s.position, rest.position);
        moved = fmax(moved, sqrt(daft_ddot(d, d)));
        fastest = fmax(fastest, speed_of(s));
    }
    print_message("in 60 s it moved %g m, fastest %g m/s\n", moved, fastest);
    assert_true(moved < 1e-4 && fastest < 1e-3);
    daft_world_destroy(world);
}

/* The trapezoid of velocities is exact for a constant force, however long steps are. */
static uint64_t projectile(const variant *v)
{
    uint64_t hash = 0;
    daft_error error = {0};
    for (int rate = 30; rate <= 240; rate *= 2) {
        daft_world *world = variant_world(v);
        uint32_t ball = put(world, v, sphere(0.5, 0, 0, 0));
        launch(world, v, ball, daft_v3(10, 10, 0), daft_v3(0, 0, 0));
        for (int i = 0; i < 2 * rate; i++) assert_true(daft_world_step(world, 1 / (float)rate, &error));
        daft_dvec3 p = place_of(world, v, ball);
        print_message("%d Hz: %g and %g mm off\n", rate, 1e3 * (p.x - 20), 1e3 * (p.y - 20 + 2 * G));
        assert_near(p.x, 20, 1e-4);
        assert_near(p.y, 10 * 2 - G / 2 * 4, 2e-4);
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void free_flight_follows_the_parabola(void **unused)
{
    (void)unused;
    play_variants(projectile);
}

static void a_force_lasts_one_step_and_an_impulse_changes_momentum(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    uint32_t ball = add(world, sphere(0.5, 0, 0, 0));
    double mass = 1000 * 4.0 / 3 * DAFT_PI * 0.125;
    daft_world_apply_force(world, ball, daft_v3((float)(mass * 60), 0, 0));
    steps(world, 2);
    assert_near((double)state_of(world, ball).linear.x, 1, 1e-5);
    daft_world_apply_impulse(world, ball, daft_v3(0, (float)(mass * 3), 0));
    assert_near((double)state_of(world, ball).linear.y, 3, 1e-5);
    daft_world_destroy(world);
}

/* Speed after two seconds on a slope about z, from rest. */
static double speed_on_slope(const variant *v, double angle, float friction, float rolling, uint64_t *hash)
{
    daft_world *world = variant_world(v);
    one_shape slope = box(daft_v3(200, 1, 5), 0, 0, 0);
    slope.rotation = turned(0, 0, 1, -angle);
    slope.friction = friction;
    put(world, v, slope);
    double s = daft_sin(angle), c = daft_cos(angle);
    one_shape ball = sphere(0.5, 1.5 * s, 1.5 * c, 0);
    ball.friction = friction;
    ball.rolling_resistance = rolling;
    uint32_t id = put(world, v, ball);
    steps(world, 120);
    double speed = speed_of(state_in(world, v, id));
    *hash = hash_of_both(*hash, end_of(world));
    return speed;
}

static uint64_t balls_on_slopes(const variant *v)
{
    uint64_t hash = 0;
    for (double angle = 0.1; angle < 0.75; angle += 0.15) {
        double pull = G * daft_sin(angle), load = G * daft_cos(angle);
        assert_near(speed_on_slope(v, angle, 1, 0, &hash) / 2, 5.0 / 7 * pull, 0.01 * 5.0 / 7 * pull);
        assert_near(speed_on_slope(v, angle, 0, 0, &hash) / 2, pull, 0.01 * pull);
        assert_near(speed_on_slope(v, angle, 0.02f, 0, &hash) / 2, pull - 0.02 * load, 0.01 * pull);
        assert_near(speed_on_slope(v, angle, 1, 0.05f, &hash) / 2, 5.0 / 7 * (pull - 0.05 * load), 0.01 * pull);
    }
    assert_near(speed_on_slope(v, 0.09, 1, 0.1f, &hash), 0, 1e-3); /* tan 0.09 < 0.1: it stays */
    return hash;
}

static void rolling_and_sliding_down_a_slope(void **unused)
{
    (void)unused;
    play_variants(balls_on_slopes);
}

/* A sphere that may not spin freely slides: rolling resistance of 1000 makes it a puck. */
static void sliding_stops_where_friction_says(void **unused)
{
    (void)unused;
    double far_end = 0, near_end = 1e9;
    for (int heading = 0; heading < 16; heading++) {
        double angle = heading * DAFT_PI / 8, c = daft_cos(angle), s = daft_sin(angle);
        daft_world *world = new_world();
        one_shape ground = box(daft_v3(50, 1, 50), 0, -1, 0), puck = sphere(0.5, 0, 0.5, 0);
        ground.friction = puck.friction = 0.5f;
        puck.rolling_resistance = 1000;
        add(world, ground);
        uint32_t id = add(world, puck);
        daft_world_set_velocity(world, id, daft_v3((float)(5 * c), 0, (float)(5 * s)), daft_v3(0, 0, 0));
        steps(world, 180);
        daft_dvec3 p = state_of(world, id).position;
        double along = p.x * c + p.z * s, sideways = p.z * c - p.x * s;
        assert_near(along, 25 / (2 * 0.5 * G), 0.01 * 2.548);
        assert_near(sideways, 0, 1e-3);
        far_end = fmax(far_end, along), near_end = fmin(near_end, along);
        daft_world_destroy(world);
    }
    assert_true(far_end - near_end < 0.001 * far_end);
}

/* A sphere that slides without spin ends up rolling at 5/7 of its speed, whatever the friction. */
static void sliding_turns_into_rolling(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add_floor(world, 100);
    uint32_t ball = add(world, sphere(0.3, 0, 0.3, 0));
    daft_world_set_velocity(world, ball, daft_v3(7, 0, 0), daft_v3(0, 0, 0));
    steps(world, 240);
    daft_sim_state s = state_of(world, ball);
    assert_near((double)s.linear.x, 5, 0.02);
    assert_near((double)s.angular.z, -5 / 0.3, 0.1);
    daft_world_destroy(world);
}

/* ---- bounces and collisions ---- */

static uint64_t rebounds(const variant *v)
{
    uint64_t hash = 0;
    for (int i = 0; i <= 20; i++) {
        double e = 0.05 * i, height = 1 + 0.013 * i, highest = 0;
        daft_world *world = variant_world(v);
        put_floor(world, v, 10);
        one_shape ball = sphere(0.2, 0, 0.2 + height, 0);
        ball.restitution = (float)e;
        uint32_t id = put(world, v, ball);
        bool hit = false;
        for (int tick = 0; tick < 100; tick++) {
            steps(world, 1);
            daft_sim_state s = state_in(world, v, id);
            double vy = (double)s.linear.y;
            hit = hit || vy >= 0;
            if (hit) highest = fmax(highest, s.position.y - 0.2 + vy * vy / (2 * G)); /* ticks miss the top itself */
        }
        assert_true(hit);
        assert_near(highest, e * e * height, 0.01 * e * e * height + 1e-4);
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void a_ball_rebounds_to_e_squared_h(void **unused)
{
    (void)unused;
    play_variants(rebounds);
}

static uint64_t perfect_bounces(const variant *v)
{
    daft_world *world = variant_world(v);
    put_floor(world, v, 10);
    one_shape ball = sphere(0.2, 0, 1.2, 0);
    ball.restitution = 1;
    uint32_t id = put(world, v, ball);
    double before = G * 1.0, first = before;
    int bounces = 0;
    float last = 0;
    while (bounces < 50) {
        steps(world, 1);
        daft_sim_state s = state_in(world, v, id);
        if (last > 0 && s.linear.y <= 0) {
            double energy = G * (s.position.y - 0.2) + 0.5 * (double)s.linear.y * (double)s.linear.y;
            if (!(energy < before * 1.001)) fail_msg("bounce %d: %g after %g", bounces, energy, before);
            before = energy;
            bounces++;
        }
        last = s.linear.y;
    }
    print_message("after 50 bounces %.4g of the energy is left\n", before / first);
    assert_true(before > 0.9 * first && before <= first * 1.0001);
    return end_of(world);
}

static void a_perfect_bounce_gains_no_energy(void **unused)
{
    (void)unused;
    play_variants(perfect_bounces);
}

static uint64_t bounce_house(const variant *v)
{
    daft_world *world = variant_world(v);
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    add_room(world, v->origin, 5, 0.1f, 1, 0);
    uint32_t ball = put(world, v, sphere(0.2, 0.3, 0.1, -0.7));
    launch(world, v, ball, daft_v3(120, 7, 120), daft_v3(0, 0, 0));
    double start = speed_of(state_in(world, v, ball));
    for (int i = 0; i < 3600; i++) {
        steps(world, 1);
        daft_dvec3 p = state_in(world, v, ball).position;
        assert_true(fabs(p.x) < 4.9 && fabs(p.y) < 4.9 && fabs(p.z) < 4.9);
    }
    assert_near(speed_of(state_in(world, v, ball)), start, 0.005 * start);
    return end_of(world);
}

static void a_bounce_house_keeps_its_ball_and_its_energy(void **unused)
{
    (void)unused;
    play_variants(bounce_house);
}

static void two_spheres_share_momentum(void **unused)
{
    (void)unused;
    for (int i = 0; i < 5; i++) {
        double e = 0.25 * i, m1 = 1, m2 = 8; /* radii 0.5 and 1 of one density */
        daft_world *world = new_world();
        daft_world_set_gravity(world, daft_v3(0, 0, 0));
        one_shape a = sphere(0.5, -3, 0, 0), b = sphere(1, 3, 0, 0);
        a.restitution = b.restitution = (float)e;
        uint32_t one = add(world, a), two = add(world, b);
        daft_world_set_velocity(world, one, daft_v3(6, 0, 0), daft_v3(0, 0, 0));
        daft_world_set_velocity(world, two, daft_v3(-2, 0, 0), daft_v3(0, 0, 0));
        steps(world, 90);
        double v1 = (double)state_of(world, one).linear.x, v2 = (double)state_of(world, two).linear.x;
        double common = (m1 * 6 - m2 * 2) / (m1 + m2);
        assert_near(m1 * v1 + m2 * v2, m1 * 6 - m2 * 2, 1e-4);
        assert_near(v1, common - e * 8 * m2 / (m1 + m2), 0.01);
        assert_near(v2, common + e * 8 * m1 / (m1 + m2), 0.01);
        daft_world_destroy(world);
    }
}

/* ---- kinematic bodies ---- */

static void a_platform_carries_a_marble(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    one_shape platform = box(daft_v3(4, 0.25f, 4), 0, -0.25, 0);
    platform.kind = DAFT_BODY_KINEMATIC;
    platform.rolling_resistance = 0.3f;
    uint32_t floor = add(world, platform), ball = add(world, sphere(0.3, 0.5, 0.3, 0));
    daft_dvec3 p = daft_dv3(0, -0.25, 0);
    for (int i = 0; i < 180; i++) {
        p.x += 2.0 / 60, p.y += 0.5 / 60;
        daft_world_set_pose(world, floor, p, daft_quat_identity(), false);
        steps(world, 1);
    }
    daft_sim_state carried = state_of(world, ball);
    assert_near((double)carried.linear.x, 2, 1e-3);
    assert_near((double)carried.linear.y, 0.5, 2e-3);
    assert_near(carried.position.y, p.y + 0.55, 1e-3);
    assert_near(state_of(world, floor).position.x, p.x, 1e-12);
    for (int i = 0; i < 120; i++) steps(world, 1);
    assert_near(speed_of(state_of(world, ball)), 0, 1e-3);
    assert_near(speed_of(state_of(world, floor)), 0, 0);
    daft_world_destroy(world);
}

static void a_turntable_takes_its_marble_along(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    one_shape table = box(daft_v3(4, 0.5f, 4), 0, -0.5, 0);
    table.kind = DAFT_BODY_KINEMATIC;
    table.rolling_resistance = 0.5f;
    uint32_t id = add(world, table), ball = add(world, sphere(0.3, 1, 0.3, 0));
    daft_world_set_velocity(world, id, daft_v3(0, 0, 0), daft_v3(0, 1, 0));
    steps(world, 240);
    daft_sim_state s = state_of(world, ball);
    double x = s.position.x, z = s.position.z, r = sqrt(x * x + z * z);
    assert_near(r, 1, 0.12);
    assert_near((double)s.linear.x, z, 0.02 * r);
    assert_near((double)s.linear.z, -x, 0.02 * r);
    assert_near((double)s.angular.y, 1, 0.01);
    daft_world_destroy(world);
}

/* A bat that swings through more than the ball's size in a step still hits it. */
static void a_swung_bat_hits(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    one_shape bat = box(daft_v3(1, 0.2f, 0.05f), 0, 0, 0);
    bat.kind = DAFT_BODY_KINEMATIC;
    uint32_t id = add(world, bat), ball = add(world, sphere(0.1, 0.8, 0, -0.6));
    for (int i = 1; i <= 10; i++) {
        daft_world_set_pose(world, id, daft_dv3(0, 0, 0), turned(0, 1, 0, 0.33 * i), false);
        steps(world, 1);
    }
    assert_true(speed_of(state_of(world, ball)) > 5);
    daft_world_destroy(world);
}

/* ---- contacts ---- */

static void contacts_tell_who_touched_and_how_hard(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    one_shape ground = box(daft_v3(5, 1, 5), 0, -1, 0), def = sphere(0.5, 1, 0.5, 2);
    ground.user = 70, def.user = 71;
    add(world, ground);
    uint32_t ball = add(world, def);
    def.user = 72, def.position.y = 50;
    add(world, def);
    daft_world_set_sleeping(world, false);
    steps(world, 60);
    const daft_sim_contact *contacts;
    assert_int_equal(daft_world_contacts(world, &contacts), 1);
    assert_int_equal(contacts[0].user_a, 70);
    assert_int_equal(contacts[0].user_b, 71);
    assert_near((double)contacts[0].normal.y, 1, 1e-6);
    assert_near(contacts[0].point.x, 1, 1e-4);
    assert_near(contacts[0].point.y, 0, 1e-4);
    double mass = 1000 * 4.0 / 3 * DAFT_PI * 0.125;
    assert_near((double)contacts[0].impulse, mass * G / 60, 0.01 * mass * G / 60);
    daft_world_remove(world, ball);
    assert_int_equal(daft_world_contacts(world, &contacts), 0);
    daft_world_destroy(world);
}

/* Each pair once, in the order of bodies, a before b. */
static void contacts_come_in_a_fixed_order(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    daft_world_set_sleeping(world, false);
    add_tray(world, daft_dv3(0, 0, 0), 2);
    for (uint32_t i = 0; i < 20; i++) {
        one_shape ball = sphere(0.5, 0.1 * (i % 4), 1 + i, 0.1 * (i % 3));
        ball.user = 100 + i;
        add(world, ball);
    }
    steps(world, 600);
    const daft_sim_contact *contacts;
    uint32_t count = daft_world_contacts(world, &contacts), with_tray = 0, last = 0;
    assert_true(count > 20);
    for (uint32_t i = 0; i < count; i++) {
        assert_true(contacts[i].body_a < contacts[i].body_b && contacts[i].impulse >= 0);
        assert_near((double)daft_length(contacts[i].normal), 1, 1e-5);
        with_tray += contacts[i].user_a < 100;
        assert_true(contacts[i].user_b >= 100);
        uint32_t order = contacts[i].body_a * 1000 + contacts[i].body_b;
        assert_true(order > last);
        last = order;
    }
    assert_true(with_tray > 4);
    daft_world_destroy(world);
}

/* ---- what is not called for costs nothing ---- */

static int allocations;
static void *counting_allocate(void *user, size_t size, size_t alignment)
{
    (void)user;
    allocations++;
    return heap.allocate(NULL, size, alignment);
}
static void counting_release(void *user, void *pointer)
{
    (void)user;
    heap.release(NULL, pointer);
}

static void a_settled_step_allocates_nothing(void **unused)
{
    (void)unused;
    heap = daft_malloc_allocator();
    daft_allocator counting = {.user = NULL, .allocate = counting_allocate, .release = counting_release};
    daft_error error;
    daft_world *world = daft_world_create(&counting, &error);
    add_tray(world, daft_dv3(0, 0, 0), 2);
    allocations = 0;
    steps(world, 10);
    assert_int_equal(allocations, 0); /* nothing dynamic: not even the first step */
    for (int i = 0; i < 30; i++) add(world, sphere(0.3, 0.1 * (i % 4), 1 + 0.7 * i, 0.1 * (i % 3)));
    steps(world, 400);
    allocations = 0;
    steps(world, 60);
    assert_int_equal(allocations, 0);
    daft_world_destroy(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_at_rest_stays),
        cmocka_unit_test(free_flight_follows_the_parabola),
        cmocka_unit_test(a_force_lasts_one_step_and_an_impulse_changes_momentum),
        cmocka_unit_test(rolling_and_sliding_down_a_slope),
        cmocka_unit_test(sliding_stops_where_friction_says),
        cmocka_unit_test(sliding_turns_into_rolling),
        cmocka_unit_test(a_ball_rebounds_to_e_squared_h),
        cmocka_unit_test(a_perfect_bounce_gains_no_energy),
        cmocka_unit_test(a_bounce_house_keeps_its_ball_and_its_energy),
        cmocka_unit_test(two_spheres_share_momentum),
        cmocka_unit_test(a_platform_carries_a_marble),
        cmocka_unit_test(a_turntable_takes_its_marble_along),
        cmocka_unit_test(a_swung_bat_hits),
        cmocka_unit_test(contacts_tell_who_touched_and_how_hard),
        cmocka_unit_test(contacts_come_in_a_fixed_order),
        cmocka_unit_test(a_settled_step_allocates_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
