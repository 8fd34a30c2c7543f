/* The character: what a game relies on when it lets somebody walk about. Every tick of every test also asserts that it
 * is not inside anything that stands still. */
#include "character_fixture.h"

/* ---- the flat, gravity, jumps ---- */

static void it_stands_still(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    daft_sim_character c = walker(0, 1, 0);
    walk(world, &c, 0, 0, 60);
    assert_true(c.grounded);
    assert_near(feet(&c), 0, 0.0125);
    daft_dvec3 at = c.position;
    walk(world, &c, 0, 0, 600);
    assert_memory_equal(&at, &c.position, sizeof at);
    daft_world_destroy(world);
}

static void it_walks_as_fast_as_asked(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 3, 4, 60);
    double x = c.position.x, z = c.position.z;
    walk(world, &c, 3, 4, 60);
    assert_near(c.position.x - x, 3, 1e-3);
    assert_near(c.position.z - z, 4, 1e-3);
    walk(world, &c, 0, 0, 30);
    assert_near((double)daft_length(c.velocity), 0, 1e-6);
    daft_world_destroy(world);
}

static void it_jumps_as_high_as_it_should(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 0, 0, 5);
    double top = 0, from = feet(&c);
    go(world, &c, 0, 0, 5);
    assert_false(c.grounded);
    int ticks = 1;
    for (; !c.grounded && ticks < 200; ticks++) {
        go(world, &c, 0, 0, 5); /* asked again in the air, it does not */
        top = fmax(top, feet(&c) - from);
    }
    assert_near(top, 5 * 5 / (2 * G), 0.06);
    assert_near(ticks * (double)DT, 2 * 5 / G, 0.05);
    daft_world_destroy(world);
}

static void a_ceiling_stops_a_jump(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    put_box(world, 5, 0.01, 5, 0, 2.0, 0);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 0, 0, 5);
    go(world, &c, 0, 0, 8);
    double top = 0;
    for (int i = 0; i < 60; i++) {
        go(world, &c, 2, 0, 0);
        top = fmax(top, feet(&c));
        if (i > 5) assert_true(c.velocity.y <= 0.2f);
    }
    assert_true(top < 0.19 && top > 0.15 && c.grounded);
    daft_world_destroy(world);
}

/* ---- steps ---- */

static void stairs(daft_world *world, int count, double rise, double tread)
{
    for (int i = 0; i < count; i++) put_box(world, 20, 0.5 * rise, 3, 20 + 2 + tread * i, rise * (i + 0.5), 0);
}

static void climb(double rise, double tread, double speed, int count, double angle)
{
    daft_world *world = new_world();
    put_ground(world);
    stairs(world, count, rise, tread);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 0, 0, 5);
    double vx = speed * daft_cos(angle), vz = speed * daft_sin(angle), slowest = 1e9, top = rise * count;
    int ticks = (int)((2.5 + tread * count) / vx * 60);
    for (int i = 0; i < ticks; i++) {
        double x = c.position.x;
        go(world, &c, vx, c.position.z > centre.z + 2 ? 0 : vz, 0);
        if (i > 10) slowest = fmin(slowest, (c.position.x - x) / (double)DT / vx);
        if (!c.grounded) fail_msg("off the ground at step %g, tick %d", rise, i);
    }
    assert_near(feet(&c), top, 0.02);
    if (!(slowest > 0.5)) fail_msg("step %g tread %g speed %g: slowest %g", rise, tread, speed, slowest);
    /* And down again, without ever leaving the ground. */
    for (int i = 0; i < ticks + 30; i++) {
        go(world, &c, -vx, 0, 0);
        if (!c.grounded) fail_msg("off the ground on the way down, step %g, tick %d, feet %g", rise, i, feet(&c));
    }
    assert_near(feet(&c), 0, 0.0125);
    daft_world_destroy(world);
}

static void it_climbs_stairs_and_comes_down(void **state)
{
    (void)state;
    for (int far = 0; far < 2; far++) {
        centre = far ? daft_dv3(1e7, 1e7, -1e7) : daft_dv3(0, 0, 0);
        climb(0.05, 0.3, 4, 20, 0);
        climb(0.18, 0.28, 4, 15, 0);
        climb(0.18, 0.28, 0.5, 6, 0);
        climb(0.3, 0.3, 2, 10, 0);
        climb(0.2, 0.25, 5, 12, 0.5);
        climb(0.34, 0.5, 8, 8, 0);
    }
    centre = daft_dv3(0, 0, 0);
}

static void steps_that_are_too_high_stop_it(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    stairs(world, 3, 0.4, 0.5);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 4, 0, 200);
    assert_near(feet(&c), 0, 0.0125);
    assert_near(c.position.x, 2 - 0.3, 0.02);
    daft_world_destroy(world);
}

/* A kerb that is lower than a step and thin: over it, not through it. */
static void it_steps_over_kerbs(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    for (int i = 0; i < 4; i++) put_box(world, 0.01, 0.1 + 0.02 * i, 4, 2 + 2 * i, 0.1 + 0.02 * i, 0);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 3, 0, 300);
    assert_true(c.position.x > 10);
    daft_world_destroy(world);
}

/* ---- slopes ---- */

static void slopes_up_to_the_limit_are_walked(void **state)
{
    (void)state;
    for (int degrees = 0; degrees <= 80; degrees += 5) {
        if (degrees == 50) continue; /* the limit itself */
        double angle = degrees * DAFT_PI / 180, c0 = daft_cos(angle), s0 = daft_sin(angle);
        daft_world *world = new_world();
        put_ground(world);
        /* A ramp whose surface begins at x = 2. */
        put_turned(world, daft_v3(20, 1, 5), 2 + 20 * c0 + s0, 20 * s0 - c0, 0, turned(0, 0, 1, angle));
        daft_sim_character c = walker(0, 0, 0);
        walk(world, &c, 2, 0, 180);
        double x = c.position.x, y = feet(&c);
        if (degrees < 50) {
            assert_true(c.grounded);
            assert_near(x, 6, 0.2);
            assert_near(y, (x - 2) * s0 / c0, 0.1 + 0.3 * (1 / c0 - 1));
            walk(world, &c, 0, 0, 10);
            daft_dvec3 at = c.position;
            walk(world, &c, 0, 0, 300); /* it does not slide */
            assert_near(c.position.x, at.x, 1e-6);
            for (int i = 0; i < 100; i++) { /* nor hop on the way down */
                go(world, &c, -2, 0, 0);
                assert_true(c.grounded);
            }
        } else {
            assert_true(y < 0.3); /* no higher than where its round end leans on the ramp */
        }
        /* Put onto the ramp, it stays, or slides to its foot. */
        c = walker(2 + 5 * c0, 5 * s0 + 0.6, 0);
        walk(world, &c, 0, 0, 20);
        double height = feet(&c);
        walk(world, &c, 0, 0, 300);
        if (degrees < 50)
            assert_near(feet(&c), height, degrees == 0 ? 0.7 : 0.3);
        else
            assert_true(feet(&c) < 0.05);
        daft_world_destroy(world);
    }
}

static void steep_slopes_cannot_be_run_up(void **state)
{
    (void)state;
    for (int degrees = 55; degrees <= 80; degrees += 5) {
        double angle = degrees * DAFT_PI / 180, c0 = daft_cos(angle), s0 = daft_sin(angle);
        daft_world *world = new_world();
        put_ground(world);
        put_turned(world, daft_v3(20, 1, 5), 2 + 20 * c0 + s0, 20 * s0 - c0, 0, turned(0, 0, 1, angle));
        daft_sim_character c = walker(0, 0, 0);
        double top = 0, jump = 0;
        for (int i = 0; i < 600; i++) {
            go(world, &c, 10, 0.2, 0);
            top = fmax(top, feet(&c));
        }
        assert_true(top < 0.3);
        for (int i = 0; i < 600; i++) { /* nor by jumping against it again and again */
            go(world, &c, 5, 0, 4);
            jump = fmax(jump, feet(&c));
        }
        assert_true(jump < 4.0 * 4 / (2 * G) + 0.4);
        daft_world_destroy(world);
    }
}

/* ---- walls, corners, tunnels ---- */

static void it_slides_along_walls(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    put_box(world, 0.5, 3, 50, 2.5, 3, 0);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 3, 0, 60);
    assert_near(c.position.x, 2 - 0.3, 0.02);
    double z = c.position.z;
    walk(world, &c, 3, 3, 120);
    assert_near(c.position.z - z, 6, 0.15);
    assert_near(c.position.x, 2 - 0.3, 0.02);
    daft_world_destroy(world);
}

static void corners_hold_it_and_let_it_go(void **state)
{
    (void)state;
    for (int degrees = 10; degrees <= 170; degrees += 20) {
        double half = 0.5 * degrees * DAFT_PI / 180;
        daft_world *world = new_world();
        put_ground(world);
        for (int side = -1; side <= 1; side += 2) {
            /* A wall that runs from the corner at x = 3 back to smaller x, turned by half the angle. */
            double c0 = daft_cos(half), s0 = daft_sin(half);
            put_turned(world, daft_v3(8, 3, 0.5f), 3 - 8 * c0 + 0.5 * s0, 3, side * (8 * s0 + 0.5 * c0),
                       turned(0, 1, 0, half * side));
        }
        daft_sim_character c = walker(-6 * daft_cos(half), 0, 0);
        for (int i = 0; i < 240; i++) go(world, &c, 4, i % 7 < 3 ? 1 : -1, 0);
        daft_dvec3 at = c.position;
        walk(world, &c, 4, 0, 120);
        assert_near(c.position.x, at.x, 0.05); /* it rests there */
        walk(world, &c, -4, 0, 30);
        assert_true(c.position.x < at.x - 1); /* and comes out at once */
        daft_world_destroy(world);
    }
}

static void fast_ones_stop_at_thin_walls(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    daft_quat turn = turned(0, 1, 0, 0.3);
    double c0 = 4 * daft_cos(0.3), s0 = 4 * daft_sin(0.3);
    put_turned(world, daft_v3(0.0005f, 3, 5), c0, 3, -s0, turn);
    put_turned(world, daft_v3(0.0005f, 3, 5), -c0, 3, s0, turn);
    put_turned(world, daft_v3(5, 3, 0.0005f), s0, 3, c0, turn);
    put_turned(world, daft_v3(5, 3, 0.0005f), -s0, 3, -c0, turn);
    seed_random(5);
    for (int i = 0; i < 300; i++) {
        daft_sim_character c = walker(uniform(-1, 1), 0, uniform(-1, 1));
        c.def.acceleration = 1e6f;
        double speed = uniform(5, 3000) * (i % 2 ? 1 : -1);
        walk(world, &c, speed, 0, 5);
        assert_true(c.position.x * c.position.x + c.position.z * c.position.z < 2 * 16);
        assert_near(feet(&c), 0, 0.05);
    }
    daft_world_destroy(world);
}

static void fast_falls_stop_at_thin_floors(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_box(world, 50, 0.0005, 50, 0, 0, 0);
    for (int i = 0; i < 50; i++) {
        daft_sim_character c = walker(0, 30 + 0.37 * i, 0);
        c.velocity = daft_v3(0, -20.0f * (float)i, 0);
        walk(world, &c, 1, 0, 200);
        assert_true(c.grounded);
        assert_near(feet(&c), 0, 0.02);
    }
    daft_world_destroy(world);
}

static void low_tunnels_need_crouching(void **state)
{
    (void)state;
    daft_world *world = new_world();
    daft_error error;
    put_ground(world);
    put_box(world, 2, 0.5, 5, 4, 1.7, 0); /* 1.2 m high from x = 2 to 6 */
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 3, 0, 120);
    assert_near(c.position.x, 1.7, 0.05);
    assert_true(daft_sim_character_set_height(world, &c, 1.1f, &error));
    assert_near(feet(&c), 0, 0.0125);
    walk(world, &c, 3, 0, 40);
    assert_true(c.position.x > 3);
    assert_false(daft_sim_character_set_height(world, &c, 1.8f, &error));
    walk(world, &c, 3, 0, 90);
    assert_true(c.position.x > 6.5);
    assert_true(daft_sim_character_set_height(world, &c, 1.8f, &error));
    walk(world, &c, -3, 0, 5);
    assert_near(feet(&c), 0, 0.0125);
    daft_world_destroy(world);
}

static void it_comes_out_of_what_it_is_put_into(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    put_box(world, 1, 1, 1, 0, 1, 0);
    for (int i = 0; i < 40; i++) {
        daft_sim_character c = walker(-1.2 + 0.06 * i, 0.05 * i, 0.3);
        daft_error error;
        daft_sim_walk_wish still = {{0, 0, 0}, 0};
        for (int k = 0; k < 60; k++) assert_true(daft_sim_character_move(world, &c, &still, DT, &error));
        assert_false(is_inside(world, &c, 0.99f));
        assert_true(c.grounded && !c.crushed);
        assert_true(fabs(c.position.x) < 3 && feet(&c) < 3 && feet(&c) > -0.01);
    }
    daft_world_destroy(world);
}

/* ---- what moves ---- */

static void it_rides_platforms(void **state)
{
    (void)state;
    for (int far = 0; far < 2; far++) {
        centre = far ? daft_dv3(-1e7, 1e7, 1e7) : daft_dv3(0, 0, 0);
        daft_world *world = new_world();
        uint32_t platform = put_kinematic(world, daft_v3(2, 0.2f, 2), 0, -0.2, 0);
        daft_sim_character c = walker(0.5, 0, 0.5);
        walk(world, &c, 0, 0, 5);
        daft_dvec3 from = c.position;
        for (int i = 1; i <= 240; i++) {
            double t = i * (double)DT;
            daft_dvec3 p = daft_dv3(2 * t, 1.5 * daft_sin(t) - 0.2, t);
            daft_world_set_pose(world, platform, daft_dadd(centre, p), daft_quat_identity(), false);
            steps(world, 1);
            go(world, &c, 0, 0, 0);
            assert_true(c.grounded && c.ground == platform);
            daft_dvec3 moved = daft_dsub(c.position, from);
            assert_near(moved.x, p.x, 2e-3);
            assert_near(moved.y, p.y + 0.2, 2e-3);
            assert_near(moved.z, p.z, 2e-3);
        }
        /* A jump takes the platform's speed along. */
        go(world, &c, 0, 0, 4);
        assert_near((double)c.velocity.x, 2, 0.01);
        daft_world_destroy(world);
    }
    centre = daft_dv3(0, 0, 0);
}

static void it_turns_with_what_turns(void **state)
{
    (void)state;
    daft_world *world = new_world();
    uint32_t platform = put_kinematic(world, daft_v3(5, 0.5f, 5), 0, -0.5, 0);
    daft_sim_character c = walker(3, 0, 0);
    walk(world, &c, 0, 0, 5);
    double turn = 0;
    for (int i = 1; i <= 300; i++) {
        daft_world_set_pose(world, platform, daft_dv3(0, -0.5, 0), turned(0, 1, 0, 0.01 * i), false);
        steps(world, 1);
        go(world, &c, 0, 0, 0);
        turn += (double)c.turn;
        assert_true(c.grounded);
    }
    assert_near(turn, 3, 1e-4);
    assert_near(c.position.x, 3 * daft_cos(3), 5e-3);
    assert_near(c.position.z, -3 * daft_sin(3), 5e-3);
    daft_world_destroy(world);
}

/* A lift with a ceiling over it: it is held, not pushed through either. */
static void a_lift_carries_and_may_crush(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_box(world, 3, 0.5, 3, 0, 4.5, 0);
    uint32_t lift = put_kinematic(world, daft_v3(1.5f, 0.1f, 1.5f), 0, -0.1, 0);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 0, 0, 5);
    bool crushed = false;
    for (int i = 1; i <= 400; i++) {
        double y = i < 200 ? 0.015 * i : 3 - 0.03 * (i - 200); /* up to 3 m, where there is room for 1 m */
        daft_world_set_pose(world, lift, daft_dv3(0, y - 0.1, 0), daft_quat_identity(), false);
        steps(world, 1);
        daft_error error;
        daft_sim_walk_wish still = {{0, 0, 0}, 0};
        assert_true(daft_sim_character_move(world, &c, &still, DT, &error));
        assert_true(c.position.y < 4 && daft_dfinite3(c.position));
        crushed |= c.crushed;
        if (i < 130) assert_near(feet(&c), y, 0.02);
    }
    assert_true(crushed);
    assert_near(feet(&c), 3 - 0.03 * 200, 0.1);
    daft_world_destroy(world);
}

static void a_moving_wall_pushes_it(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    uint32_t wall = put_kinematic(world, daft_v3(0.5f, 2, 3), -2, 2.01, 0);
    daft_sim_character c = walker(0, 0, 0);
    for (int i = 1; i <= 240; i++) {
        double x = -2 + 3 * i * (double)DT;
        daft_world_set_pose(world, wall, daft_dv3(x, 2.01, 0), daft_quat_identity(), false);
        steps(world, 1);
        go(world, &c, 0, 0, 0);
        assert_true(c.position.x > x + 0.5 + 0.29);
    }
    assert_true(c.position.x > 10 && c.position.x < 11.5);
    daft_world_destroy(world);
}

static void it_pushes_what_is_not_too_heavy(void **state)
{
    (void)state;
    double way[3];
    for (int i = 0; i < 3; i++) {
        daft_world *world = new_world();
        put_ground(world);
        one_shape crate = dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 2, 0.5, 0);
        crate.density = i == 0 ? 20 : i == 1 ? 60 : 2000; /* 20, 60, 2000 kg; friction 0.6: 118, 353, 11,772 N */
        uint32_t body = add(world, crate);
        daft_sim_character c = walker(0, 0, 0);
        for (int k = 0; k < 180; k++) {
            steps(world, 1);
            go(world, &c, 2, 0, 0);
        }
        way[i] = state_of(world, body).position.x - 2;
        assert_true(c.position.x < state_of(world, body).position.x - 0.75);
        daft_world_destroy(world);
    }
    assert_true(way[0] > 2 && way[0] < 5);
    assert_true(way[1] > 0.05 && way[1] < way[0]);
    assert_near(way[2], 0, 0.01);
}

/* ---- saved, bad input ---- */

static void a_copy_goes_on_the_same_way(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    stairs(world, 8, 0.2, 0.4);
    daft_sim_character c = walker(0, 0, 0), saved;
    walk(world, &c, 3, 0.5, 70);
    memcpy(&saved, &c, sizeof c);
    walk(world, &c, 3, -0.7, 100);
    walk(world, &saved, 3, -0.7, 100);
    assert_memory_equal(&saved, &c, sizeof c);
    daft_world_destroy(world);
}

static void bad_numbers_do_nothing(void **state)
{
    (void)state;
    daft_world *world = new_world();
    put_ground(world);
    daft_sim_character c = walker(0, 0, 0), before;
    daft_error error = {0};
    const float bad[] = {NAN, INFINITY, -INFINITY};
    walk(world, &c, 1, 0, 10);
    memcpy(&before, &c, sizeof c);
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++) {
        const daft_sim_walk_wish wishes[] = {{{bad[i], 0, 0}, 0}, {{0, 0, bad[i]}, 0}, {{0, 0, 0}, bad[i]}};
        for (size_t k = 0; k < DAFT_COUNT_OF(wishes); k++) {
            assert_false(daft_sim_character_move(world, &c, &wishes[k], DT, &error));
            assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
        }
        const daft_sim_walk_wish fine = {{1, 0, 0}, 0};
        assert_false(daft_sim_character_move(world, &c, &fine, bad[i], &error));
        assert_false(daft_sim_character_teleport(&c, daft_dv3(0, (double)bad[i], 0), &error));
        assert_false(daft_sim_character_set_height(world, &c, bad[i], &error));
        daft_sim_character_def def = daft_default_sim_character_def();
        float *fields[] = {&def.radius,        &def.height,       &def.step_height,
                           &def.max_slope,     &def.acceleration, &def.air_acceleration,
                           &def.gravity_scale, &def.mass,         &def.push_force};
        for (size_t k = 0; k < DAFT_COUNT_OF(fields); k++) {
            float good = *fields[k];
            *fields[k] = bad[i];
            assert_false(daft_sim_character_init(&c, &def, &error));
            *fields[k] = good;
        }
    }
    assert_memory_equal(&before, &c, sizeof c);
    /* Finite but absurd. */
    const daft_sim_walk_wish absurd = {{3e38f, 0, -3e38f}, 3e38f};
    for (int i = 0; i < 10; i++) assert_true(daft_sim_character_move(world, &c, &absurd, 1, &error));
    assert_true(daft_dfinite3(c.position) && daft_finite3(c.velocity));
    daft_world_destroy(world);
}

/* What it stood on is removed: it falls. */
static void ground_that_goes_lets_it_fall(void **state)
{
    (void)state;
    daft_world *world = new_world();
    uint32_t floor = put_kinematic(world, daft_v3(2, 0.2f, 2), 0, -0.2, 0);
    daft_sim_character c = walker(0, 0, 0);
    walk(world, &c, 0, 0, 10);
    assert_int_equal(c.ground, floor);
    daft_world_remove(world, floor);
    walk(world, &c, 0, 0, 60);
    assert_false(c.grounded);
    assert_near(feet(&c), -0.5 * G, 0.3);
    daft_world_destroy(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_stands_still),
        cmocka_unit_test(it_walks_as_fast_as_asked),
        cmocka_unit_test(it_jumps_as_high_as_it_should),
        cmocka_unit_test(a_ceiling_stops_a_jump),
        cmocka_unit_test(it_climbs_stairs_and_comes_down),
        cmocka_unit_test(steps_that_are_too_high_stop_it),
        cmocka_unit_test(it_steps_over_kerbs),
        cmocka_unit_test(slopes_up_to_the_limit_are_walked),
        cmocka_unit_test(steep_slopes_cannot_be_run_up),
        cmocka_unit_test(it_slides_along_walls),
        cmocka_unit_test(corners_hold_it_and_let_it_go),
        cmocka_unit_test(fast_ones_stop_at_thin_walls),
        cmocka_unit_test(fast_falls_stop_at_thin_floors),
        cmocka_unit_test(low_tunnels_need_crouching),
        cmocka_unit_test(it_comes_out_of_what_it_is_put_into),
        cmocka_unit_test(it_rides_platforms),
        cmocka_unit_test(it_turns_with_what_turns),
        cmocka_unit_test(a_lift_carries_and_may_crush),
        cmocka_unit_test(a_moving_wall_pushes_it),
        cmocka_unit_test(it_pushes_what_is_not_too_heavy),
        cmocka_unit_test(a_copy_goes_on_the_same_way),
        cmocka_unit_test(bad_numbers_do_nothing),
        cmocka_unit_test(ground_that_goes_lets_it_fall),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
