/* sim, the hard cases: fast shots, seams, piles, deep overlap, far from the origin, bad input, and the same bits
 * always. Every case asserts a number; random cases print their seed. */
#include "sim_scene.h"

/* ---- fast bodies ---- */

static daft_vec3 random_direction(void)
{
    for (;;) {
        daft_vec3 d = daft_to_float(random_in(-1, 1));
        float length = daft_length(d);
        if (length > 0.1f && length < 1) return daft_scale(d, 1 / length);
    }
}

/* A shot from 20 m at a plate that faces it, turned in its plane; how far it got past the plate's middle. */
static double shoot(double radius, double thickness, double speed, daft_vec3 aim, double phase)
{
    daft_world *world = new_world();
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    one_shape plate = box(daft_v3((float)(thickness / 2), 5, 5), 0, 0, 0);
    plate.rotation = turned(1, 0, 0, phase * 10);
    add(world, plate);
    double back = (20 + phase) / (double)aim.x;
    uint32_t ball = add(world, sphere(radius, -back * (double)aim.x, -back * (double)aim.y, -back * (double)aim.z));
    daft_world_set_velocity(world, ball, daft_scale(aim, (float)speed), daft_v3(0, 90, 0));
    double farthest = -1e9;
    for (int i = 0; i < (int)(back / speed * 60) + 10; i++) {
        steps(world, 1);
        farthest = fmax(farthest, state_of(world, ball).position.x);
    }
    daft_world_destroy(world);
    return farthest;
}

static void no_shot_passes_a_thin_wall(void **unused)
{
    (void)unused;
    seed_random(20240611);
    double worst = -1e9;
    for (int i = 0; i < 1000; i++) {
        double farthest = shoot(0.1, 0.2, 180, daft_v3(1, 0, 0), uniform(0, 3));
        worst = fmax(worst, farthest + 0.2);
    }
    for (int i = 0; i < 1000; i++) {
        daft_vec3 aim = random_direction();
        aim = daft_normalize(daft_v3(1, 0.2f * aim.y, 0.2f * aim.z));
        worst = fmax(worst, shoot(0.005, 0.001, 1000, aim, uniform(0, 17)) + 0.0055);
    }
    print_message("deepest %g m\n", worst);
    assert_true(worst < 1e-3);
}

/* A room of thin walls with tilted plates in it: deflected shots must not leave it. */
static void no_shot_leaves_a_cluttered_room(void **unused)
{
    (void)unused;
    seed_random(77);
    for (int round = 0; round < 40; round++) {
        daft_world *world = new_world();
        add_room(world, daft_dv3(0, 0, 0), 5, 0.05f, (float)uniform(0, 1), 0.5f);
        for (int i = 0; i < 12; i++) {
            daft_dvec3 at = random_in(-4, 4), axis = random_in(-1, 1);
            one_shape plate = box(daft_v3(1.5f, 0.05f, 1.5f), at.x, at.y, at.z);
            plate.rotation = turned(axis.x, axis.y + 2, axis.z, uniform(0, 3));
            plate.restitution = (float)uniform(0, 1);
            add(world, plate);
        }
        uint32_t balls[6];
        for (int i = 0; i < 6; i++) {
            daft_dvec3 at = random_in(-4, 4);
            balls[i] = add(world, sphere(uniform(0.05, 0.3), at.x, at.y, at.z));
            daft_world_set_velocity(world, balls[i], daft_scale(random_direction(), 180), daft_v3(0, 0, 0));
        }
        for (int tick = 0; tick < 300; tick++) {
            steps(world, 1);
            for (int i = 0; i < 6; i++) {
                daft_dvec3 p = state_of(world, balls[i]).position;
                assert_true(fabs(p.x) < 5 && fabs(p.y) < 5 && fabs(p.z) < 5);
            }
        }
        daft_world_destroy(world);
    }
}

/* Speculative contacts must not stop what only passes by. */
static void a_near_miss_is_a_miss(void **unused)
{
    (void)unused;
    seed_random(7);
    for (int i = 0; i < 500; i++) {
        daft_world *world = new_world();
        daft_world_set_gravity(world, daft_v3(0, 0, 0));
        add(world, box(daft_v3(1, 1, 1), 0, 0, 0));
        daft_dvec3 off = random_in(0, 1);
        uint32_t ball = add(world, sphere(0.2, -20 + 3 * off.x, 1.206 + 0.1 * off.y, off.z - 0.5));
        daft_world_set_velocity(world, ball, daft_v3(170, 0, 0), daft_v3(0, 0, 0));
        steps(world, 20);
        daft_sim_state s = state_of(world, ball);
        assert_near((double)s.linear.x, 170, 1e-4);
        assert_near((double)s.linear.y, 0, 1e-6);
        daft_world_destroy(world);
    }
}

static void fast_spheres_hit_each_other(void **unused)
{
    (void)unused;
    seed_random(99);
    for (int i = 0; i < 300; i++) {
        daft_world *world = new_world();
        daft_world_set_gravity(world, daft_v3(0, 0, 0));
        one_shape a = sphere(0.1, -10 + uniform(0, 3), 0, 0);
        one_shape b = sphere(0.1, 10, uniform(-0.05, 0.05), 0);
        uint32_t one = add(world, a), two = add(world, b);
        daft_world_set_velocity(world, one, daft_v3(180, 0, 0), daft_v3(0, 0, 0));
        daft_world_set_velocity(world, two, daft_v3(-180, 0, 0), daft_v3(0, 0, 0));
        steps(world, 10);
        assert_true(state_of(world, one).linear.x < 100);
        assert_true(state_of(world, two).linear.x > -100);
        daft_world_destroy(world);
    }
}

/* ---- seams and edges ---- */

static daft_dvec3 rotated(daft_quat q, double x, double y, double z)
{
    double m[9];
    daft_quat_matrix(q, m);
    return daft_dv3(m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z);
}

/* `tiles`² unit boxes whose tops lie in one plane, the world's floor tilted by q. */
static daft_world *tiled_floor(int tiles, daft_quat q)
{
    daft_world *world = new_world();
    daft_world_set_gravity(world, daft_to_float(rotated(q, 0, -G, 0)));
    one_shape tile = box(daft_v3(0.5f, 0.5f, 0.5f), 0, 0, 0);
    tile.rotation = q;
    for (int x = -2; x < tiles + 2; x++)
        for (int z = -2; z < tiles + 2; z++) {
            tile.part.shape.half.y = 0.25f + 0.25f * (float)((x * 7 + z * 3) & 3);
            tile.position = rotated(q, x, -(double)tile.part.shape.half.y, z);
            add(world, tile);
        }
    return world;
}

/* Rolls a marble across `tiles` of them; the fastest it went up or down. */
static double bump_on_tiles(int tiles, daft_quat q, double radius, double speed, double heading)
{
    daft_world *world = tiled_floor(tiles, q);
    one_shape marble = sphere(radius, 0, 0, 0);
    daft_dvec3 start = random_in(0, 1);
    marble.position = rotated(q, start.x, radius, start.z);
    uint32_t ball = add(world, marble);
    daft_vec3 up = daft_to_float(rotated(q, 0, 1, 0));
    daft_vec3 v = daft_to_float(rotated(q, speed * daft_cos(heading), 0, speed * daft_sin(heading)));
    daft_world_set_velocity(world, ball, v, daft_scale(daft_cross(up, v), 1 / (float)radius));
    double worst = 0;
    for (int i = 0; i < (int)((tiles - 1) / speed * 60); i++) {
        steps(world, 1);
        daft_sim_state s = state_of(world, ball);
        worst = fmax(worst, fabs((double)daft_dot(s.linear, up)));
        assert_near(daft_ddot(s.position, rotated(q, 0, 1, 0)), radius, 1e-4);
    }
    assert_near(speed_of(state_of(world, ball)), speed, 1e-3 * speed);
    daft_world_destroy(world);
    return worst;
}

static void seams_between_boxes_are_not_felt(void **unused)
{
    (void)unused;
    seed_random(31337);
    static const double speeds[] = {1.7, 5, 9, 20, 60}, headings[] = {0, 0.3, DAFT_PI / 4, 1.2, DAFT_PI / 2};
    double worst = bump_on_tiles(100, daft_quat_identity(), 0.25, 8, 0.5);
    for (size_t s = 0; s < DAFT_COUNT_OF(speeds); s++)
        for (size_t h = 0; h < DAFT_COUNT_OF(headings); h++) {
            double radius = s & 1 ? 0.5 : 0.1;
            worst = fmax(worst, bump_on_tiles(30, daft_quat_identity(), radius, speeds[s], headings[h]));
            worst = fmax(worst, bump_on_tiles(30, turned(1, 2, 3, uniform(0, 3)), radius, speeds[s], headings[h]));
        }
    print_message("fastest up or down %g m/s\n", worst);
    assert_true(worst < 1e-3);
}

/* A marble that rests exactly on a seam, or on a corner of four boxes, stays; one that falls there does not go
 * sideways. */
static void a_seam_carries_a_marble(void **unused)
{
    (void)unused;
    daft_world *world = tiled_floor(4, daft_quat_identity());
    uint32_t on_seam = add(world, sphere(0.25, 0.5, 0.25, 1)), on_corner = add(world, sphere(0.25, 1.5, 2.5, 1.5));
    steps(world, 300);
    daft_dvec3 a = state_of(world, on_seam).position, b = state_of(world, on_corner).position;
    assert_near(a.x, 0.5, 1e-6);
    assert_near(a.y, 0.25, 1e-4);
    assert_near(a.z, 1, 1e-6);
    assert_near(b.x, 1.5, 1e-6);
    assert_near(b.y, 0.25, 1e-4);
    assert_near(b.z, 1.5, 1e-6);
    daft_world_destroy(world);
}

/* A wall of stacked boxes, hit and slid along: the wall's seams must not lift or trip the marble. */
static void seams_of_a_wall_are_not_felt(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    for (int x = 0; x < 30; x++)
        for (int y = -3; y < 4; y++) {
            one_shape brick = box(daft_v3(0.5f, 0.25f, 0.5f), x, 0.5 * y, 0);
            brick.friction = 0;
            add(world, brick);
        }
    uint32_t ball = add(world, sphere(0.4, 0, 0.13, 1.5));
    daft_world_set_velocity(world, ball, daft_v3(8, 0, -2), daft_v3(0, 0, 0));
    steps(world, 180);
    daft_sim_state s = state_of(world, ball);
    assert_near((double)s.linear.x, 8, 1e-3);
    assert_near((double)s.linear.y, 0, 1e-4);
    assert_near((double)s.linear.z, 0, 1e-3);
    assert_near(s.position.z, 0.9, 1e-3);
    daft_world_destroy(world);
}

/* A true edge is felt: a marble rolls off a table and round its edge, and a step stops it. */
static void true_edges_are_felt(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add(world, box(daft_v3(2, 1, 2), 0, -1, 0));
    add(world, box(daft_v3(0.5f, 0.2f, 2), -1.5, 0.2, 0));
    uint32_t off = add(world, sphere(0.25, 1, 0.25, 0)), against = add(world, sphere(0.25, 0, 0.25, 1));
    daft_world_set_velocity(world, off, daft_v3(1, 0, 0), daft_v3(0, 0, -4));
    daft_world_set_velocity(world, against, daft_v3(-2, 0, 0), daft_v3(0, 0, 8));
    steps(world, 120);
    assert_true(state_of(world, off).position.y < -3);
    assert_true(state_of(world, off).position.x > 2.25);
    assert_true(state_of(world, against).position.x > -0.76);
    daft_world_destroy(world);
}

/* ---- piles and hard cases ---- */

static void a_pile_stays_in_its_tray(void **unused)
{
    (void)unused;
    seed_random(5);
    daft_world *world = new_world();
    add_tray(world, daft_dv3(0, 0, 0), 1.5f);
    uint32_t first = 0, last = 0;
    for (int i = 0; i < 150; i++) {
        daft_dvec3 at = random_in(-1, 1);
        last = add(world, sphere(uniform(0.1, 0.25), at.x, 1 + 0.06 * i, at.z));
        if (!first) first = last;
    }
    steps(world, 600);
    double fastest = 0;
    for (uint32_t id = first; id <= last; id++) {
        daft_sim_state s = state_of(world, id);
        assert_true(fabs(s.position.x) < 1.45 && fabs(s.position.z) < 1.45 && s.position.y > 0.09 && s.position.y < 4);
        fastest = fmax(fastest, speed_of(s));
    }
    print_message("fastest after 10 s: %g m/s\n", fastest);
    assert_true(fastest < 0.5);
    daft_world_destroy(world);
}

static void a_straight_pillar_stands(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add_floor(world, 5);
    uint32_t top = 0;
    for (int i = 0; i < 30; i++) top = add(world, sphere(0.5, 0, 0.5 + i, 0));
    for (int i = 0; i < 300; i++) {
        steps(world, 1);
        assert_true(speed_of(state_of(world, top)) < 2);
    }
    daft_sim_state s = state_of(world, top);
    assert_near(s.position.x, 0, 1e-3);
    assert_near(s.position.z, 0, 1e-3);
    assert_near(s.position.y, 29.5, 0.3);
    daft_world_destroy(world);
}

static void deep_overlap_parts_gently(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    daft_world_set_gravity(world, daft_v3(0, 0, 0));
    uint32_t ids[9], n = 0;
    for (int x = 0; x < 2; x++)
        for (int y = 0; y < 2; y++)
            for (int z = 0; z < 2; z++) ids[n++] = add(world, sphere(0.5, 0.75 * x, 0.75 * y, 0.75 * z));
    ids[n++] = add(world, sphere(0.5, 0.375, 0.375, 0.375));
    double fastest = 0;
    for (int i = 0; i < 120; i++) {
        steps(world, 1);
        for (uint32_t k = 0; k < n; k++) fastest = fmax(fastest, speed_of(state_of(world, ids[k])));
    }
    print_message("fastest %g m/s\n", fastest);
    assert_true(fastest <= 3);
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < i; k++) {
            daft_dvec3 d = daft_dsub(state_of(world, ids[i]).position, state_of(world, ids[k]).position);
            assert_true(sqrt(daft_ddot(d, d)) > 0.99);
        }
    daft_world_destroy(world);
}

/* Spawned inside boxes that touch, one beside the other: it must come out at the top, not shuttle between them. */
static void a_sphere_inside_boxes_comes_out(void **unused)
{
    (void)unused;
    seed_random(12);
    for (int i = 0; i < 200; i++) {
        daft_world *world = new_world();
        for (int x = 0; x < 4; x++)
            for (int z = 0; z < 4; z++) add(world, box(daft_v3(0.5f, 0.5f, 0.5f), x, -0.5, z));
        daft_dvec3 at = random_in(0, 3);
        if (i % 4 == 0) at.x = 1.5; /* on a seam */
        at.y *= -0.15;
        uint32_t ball = add(world, sphere(0.2, at.x, at.y, at.z));
        double fastest = 0;
        for (int tick = 0; tick < 120; tick++) {
            steps(world, 1);
            fastest = fmax(fastest, speed_of(state_of(world, ball)));
        }
        daft_dvec3 p = state_of(world, ball).position;
        assert_near(p.y, 0.2, 1e-3);
        assert_near(p.x, at.x, 1e-3);
        assert_near(p.z, at.z, 1e-3);
        assert_true(fastest < 3);
        daft_world_destroy(world);
    }
}

static void a_heavy_sphere_on_a_light_one_stays(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add_tray(world, daft_dv3(0, 0, 0), 0.55f);
    one_shape heavy = sphere(0.5, 0, 1.5, 0);
    heavy.density = 1000 * 1000;
    uint32_t light = add(world, sphere(0.5, 0, 0.5, 0)), top = add(world, heavy);
    double lowest = 1, highest = 0, jump = 0;
    for (int i = 0; i < 1200; i++) {
        steps(world, 1);
        daft_sim_state s = state_of(world, light);
        lowest = fmin(lowest, s.position.y);
        jump = fmax(jump, s.position.y);
        highest = fmax(highest, state_of(world, top).position.y);
    }
    print_message("light one %g to %g m, heavy one up to %g, now %g\n", lowest, jump, highest,
                  state_of(world, top).position.y);
    assert_true(lowest > 0.49 && jump < 1.05 && highest < 1.6);
    assert_true(state_of(world, top).position.y > 0.49);
    daft_world_destroy(world);
}

/* Marbles into a tray, as seen from the tray. */
static void drop_at(daft_dvec3 origin, daft_dvec3 *out, int count)
{
    daft_world *world = new_world();
    add_tray(world, origin, 2);
    uint32_t first = 0;
    for (int i = 0; i < count; i++) {
        uint32_t id = add(
            world, sphere(0.25, origin.x + 0.375 * (i % 3) - 0.5, origin.y + 1 + 0.75 * i, origin.z + 0.125 * (i % 5)));
        if (!first) first = id;
    }
    steps(world, 120);
    for (int i = 0; i < count; i++) out[i] = daft_dsub(state_of(world, first + (uint32_t)i).position, origin);
    daft_world_destroy(world);
}

static void far_from_the_origin_is_the_same(void **unused)
{
    (void)unused;
    daft_dvec3 here[6], there[6];
    drop_at(daft_dv3(0, 0, 0), here, 6);
    drop_at(daft_dv3(1e7, 1e7, -1e7), there, 6);
    double worst = 0;
    for (int i = 0; i < 6; i++) {
        daft_dvec3 d = daft_dsub(here[i], there[i]);
        worst = fmax(worst, sqrt(daft_ddot(d, d)));
    }
    print_message("differs by %g m\n", worst);
    assert_true(worst <= 1e-3);
}

static void ten_thousand_in_one_spot_end(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add_floor(world, 100);
    for (int i = 0; i < 10000; i++) add(world, sphere(0.25, 0, 0.3, 0));
    steps(world, 2);
    for (uint32_t id = 2; id < 10002; id++) {
        daft_sim_state s = state_of(world, id);
        assert_true(daft_dfinite3(s.position) && speed_of(s) < 3.5);
    }
    daft_world_destroy(world);
}

/* ---- bad input ---- */

static void bad_definitions_are_refused(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    const float bad[] = {NAN, INFINITY, -INFINITY, -1, 0, 1e30f};
    daft_error error;
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++) {
        one_shape defs[9];
        for (int k = 0; k < 6; k++) defs[k] = sphere(0.5, 0, 0, 0);
        for (int k = 6; k < 9; k++) defs[k] = box(daft_v3(1, 1, 1), 0, 0, 0);
        defs[0].part.shape.radius = bad[i];
        defs[1].density = bad[i];
        defs[2].friction = bad[i] == 0 ? -1 : bad[i];
        defs[3].restitution = bad[i] == 0 ? 2 : bad[i];
        defs[4].rolling_resistance = bad[i] == 0 ? -1 : bad[i];
        defs[5].position.y = bad[i] == 0 || bad[i] == -1 ? 1e13 : (double)bad[i];
        defs[6].part.shape.half.z = bad[i];
        defs[7].rotation = (daft_quat){0, 0, 0, bad[i] == -1 ? 0 : bad[i]};
        defs[8].part.shape.type = DAFT_GEOMETRY_MESH;
        for (int k = 0; k < 9; k++) {
            memset(&error, 0, sizeof error);
            assert_int_equal(try_add(world, &defs[k], &error), 0);
            assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
            assert_true(strncmp(error.message, "body: ", 6) == 0);
        }
    }
    assert_false(daft_world_step(world, NAN, &error));
    assert_false(daft_world_step(world, -1, &error));
    assert_false(daft_world_step(world, 2, &error));
    assert_true(daft_world_step(world, 0, &error));
    daft_world_destroy(world);
}

static void bad_calls_change_nothing(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add_floor(world, 5);
    uint32_t ball = add(world, sphere(0.5, 0, 3, 0));
    steps(world, 10);
    uint64_t before = daft_world_hash(world, 0);
    daft_vec3 nan3 = daft_v3(0, NAN, 0);
    daft_world_set_gravity(world, nan3);
    daft_world_set_velocity(world, ball, nan3, nan3);
    daft_world_apply_force(world, ball, nan3);
    daft_world_apply_impulse(world, ball, daft_v3(INFINITY, 0, 0));
    daft_world_set_pose(world, ball, daft_dv3(NAN, 0, 0), daft_quat_identity(), false);
    daft_world_set_pose(world, ball, daft_dv3(0, 0, 0), (daft_quat){0, 0, 0, 0}, true);
    for (uint32_t stale = 3; stale < 6; stale++) {
        daft_world_remove(world, stale);
        daft_world_set_velocity(world, stale, daft_v3(1, 0, 0), daft_v3(0, 0, 0));
        daft_world_set_pose(world, stale, daft_dv3(0, 0, 0), daft_quat_identity(), true);
    }
    daft_world_remove(world, 0);
    assert_true(daft_world_hash(world, 0) == before);
    daft_world_destroy(world);
}

static float wild(void)
{
    static const float values[] = {0,   1,        -1,    1e-30f, 1e30f, 3e38f, -3e38f,
                                   NAN, INFINITY, 1e-4f, 1e4f,   0.5f,  1e7f,  1e-38f};
    return uniform(0, 1) < 0.5 ? (float)uniform(-5, 5) : values[(int)uniform(0, DAFT_COUNT_OF(values))];
}

static daft_vec3 wild3(void)
{
    float x = wild(), y = wild(), z = wild();
    return daft_v3(x, y, z);
}

static daft_quat wild_rotation(void)
{
    daft_vec3 v = wild3();
    return (daft_quat){v.x, v.y, v.z, wild()};
}

static one_shape wild_def(void)
{
    one_shape def = body_def(DAFT_BODY_STATIC, daft_to_double(wild3()));
    def.kind = (daft_body_kind)(int)uniform(0, 5);
    def.part.shape.type = (daft_geometry)(int)uniform(0, 6);
    def.part.shape.radius = (float)uniform(0.05, 1);
    if (uniform(0, 1) < 0.3) def.part.shape.radius = fabsf(wild());
    def.part.shape.half = daft_max3(wild3(), daft_v3(1e-4f, 1e-4f, 1e-4f));
    def.rotation = wild_rotation();
    def.density = fabsf(wild());
    def.friction = fabsf(wild());
    def.restitution = (float)uniform(0, 1);
    if (uniform(0, 1) < 0.2) def.restitution = wild();
    def.rolling_resistance = fabsf(wild());
    return def;
}

static bool finite_state(daft_sim_state s)
{
    return daft_dfinite3(s.position) && daft_finite3(s.linear) && daft_finite3(s.angular) && isfinite(s.rotation.x) &&
           isfinite(s.rotation.y) && isfinite(s.rotation.z) && isfinite(s.rotation.w);
}

static void wild_action(daft_world *world, uint32_t body)
{
    daft_vec3 a = wild3(), b = wild3();
    daft_quat q = wild_rotation();
    bool teleport = uniform(0, 1) < 0.5;
    switch ((int)uniform(0, 7)) {
    case 0: daft_world_remove(world, body); break;
    case 1: daft_world_set_velocity(world, body, a, b); break;
    case 2: daft_world_apply_force(world, body, a); break;
    case 3: daft_world_apply_impulse(world, body, a); break;
    case 4: daft_world_set_gravity(world, a); break;
    default: daft_world_set_pose(world, body, daft_to_double(a), q, teleport);
    }
}

static void nothing_makes_the_state_nan(void **unused)
{
    (void)unused;
    seed_random(424242);
    for (int round = 0; round < 60; round++) {
        daft_world *world = new_world();
        daft_error error;
        for (int tick = 0; tick < 60; tick++) {
            for (int k = 0; k < 4; k++) {
                one_shape def = uniform(0, 1) < 0.5 ? wild_def() : sphere(0.4, uniform(-1, 1), 0, 0);
                try_add(world, &def, &error);
                wild_action(world, (uint32_t)uniform(0, 60));
            }
            assert_true(daft_world_step(world, uniform(0, 1) < 0.9 ? DT : (float)uniform(1e-6, 1), &error));
            for (uint32_t id = 1; id < 300; id++) assert_true(finite_state(state_of(world, id)));
        }
        daft_world_destroy(world);
    }
}

/* An allocator that fails from its n-th call on: every call reports it, and nothing leaks or changes. */
static int calls_left;
static void *failing_allocate(void *user, size_t size, size_t alignment)
{
    (void)user;
    return calls_left-- > 0 ? heap.allocate(NULL, size, alignment) : NULL;
}
static void failing_release(void *user, void *pointer)
{
    (void)user;
    heap.release(NULL, pointer);
}

static bool run_with_failures(int calls)
{
    daft_allocator allocator = {.user = NULL, .allocate = failing_allocate, .release = failing_release};
    daft_error error;
    calls_left = calls;
    daft_world *world = daft_world_create(&allocator, &error);
    if (!world) return false;
    bool good = true;
    for (int i = 0; i < 12 && good; i++) {
        one_shape def = i % 3 ? sphere(0.5, 0, i, 0) : box(daft_v3(1, 0.1f, 1), 0, i, 0);
        if (i % 6 == 0) def.kind = DAFT_BODY_KINEMATIC;
        good = try_add(world, &def, &error) != 0;
    }
    uint64_t before = daft_world_hash(world, 0);
    if (good && !daft_world_step(world, DT, &error)) {
        good = false;
        assert_true(daft_world_hash(world, 0) == before);
    }
    if (!good) assert_int_equal(error.code, DAFT_ERROR_MEMORY);
    daft_world_destroy(world);
    return good;
}

static void running_out_of_memory_is_an_error(void **unused)
{
    (void)unused;
    heap = daft_malloc_allocator();
    int calls = 0;
    while (!run_with_failures(calls)) calls++;
    assert_true(calls > 5 && calls < 100);
}

/* ---- determinism ---- */

/* Everything at once: a pile of marbles of many sizes, tilted boxes, a moving platform, a spinning bar. */
/* Bodies far away come and go; the hash is of those that are here. */
static uint64_t run_everything(int ticks, int unrelated)
{
    daft_world *world = new_world();
    add_tray(world, daft_dv3(0, 0, 0), 4);
    random_state = 88172645463325252u;
    for (int i = 0; i < 12; i++) {
        daft_dvec3 at = random_in(-3, 3), tilt = random_in(-1, 1);
        one_shape ramp = box(daft_v3(1, 0.1f, 0.6f), at.x, 1.75 + 0.4 * at.y, at.z);
        ramp.rotation = turned(tilt.x, tilt.y, 1, 0.5 * tilt.z);
        add(world, ramp);
    }
    one_shape bar = box(daft_v3(3, 0.2f, 0.2f), 0, 0.4, 0);
    bar.kind = DAFT_BODY_KINEMATIC;
    uint32_t spinner = add(world, bar), platform = add(world, bar);
    daft_world_set_velocity(world, spinner, daft_v3(0, 0, 0), daft_v3(0, 2, 0));
    for (int i = 0; i < 60; i++) {
        daft_dvec3 at = random_in(-3, 3);
        one_shape ball = sphere(uniform(0.1, 0.4), at.x, 11.5 + 2.8 * at.y, at.z);
        ball.restitution = (float)uniform(0, 0.9);
        ball.rolling_resistance = (float)uniform(0, 0.05);
        add(world, ball);
    }
    uint32_t last = 0;
    for (int i = 0; i < unrelated; i++) last = add(world, sphere(0.5, 1000 + 10 * i, 0, 0));
    for (int i = 0; i < ticks; i++) {
        double angle = i * 0.02;
        daft_dvec3 p = daft_dv3(2 * daft_sin(angle), 1 + daft_cos(angle), 1);
        daft_world_set_pose(world, platform, p, turned(0, 1, 0, angle), false);
        if (i % 3 == 0 && unrelated-- > 0) daft_world_remove(world, last--);
        steps(world, 1);
    }
    uint64_t hash = 0;
    for (uint32_t id = 1; id <= platform + 60; id++) {
        daft_sim_state s = state_of(world, id);
        double position[] = {s.position.x, s.position.y, s.position.z};
        float rest[] = {s.rotation.x, s.rotation.y, s.rotation.z, s.rotation.w, s.linear.x,
                        s.linear.y,   s.linear.z,   s.angular.x,  s.angular.y,  s.angular.z};
        hash = daft_hash(position, sizeof position, hash);
        hash = daft_hash(rest, sizeof rest, hash);
    }
    daft_world_destroy(world);
    return hash;
}

/* The same for gcc and clang, debug and release, every machine: change it only together with the simulation. */
#define GOLDEN_HASH 0xd40421e474260324u

static void the_same_calls_give_the_same_bits(void **unused)
{
    (void)unused;
    uint64_t hash = run_everything(1000, 0);
    print_message("hash 0x%016llx\n", (unsigned long long)hash);
    assert_true(hash == run_everything(1000, 0));
    assert_true(hash == run_everything(1000, 50));
    assert_true(hash == GOLDEN_HASH);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_shot_passes_a_thin_wall),
        cmocka_unit_test(no_shot_leaves_a_cluttered_room),
        cmocka_unit_test(a_near_miss_is_a_miss),
        cmocka_unit_test(fast_spheres_hit_each_other),
        cmocka_unit_test(seams_between_boxes_are_not_felt),
        cmocka_unit_test(a_seam_carries_a_marble),
        cmocka_unit_test(seams_of_a_wall_are_not_felt),
        cmocka_unit_test(true_edges_are_felt),
        cmocka_unit_test(a_pile_stays_in_its_tray),
        cmocka_unit_test(a_straight_pillar_stands),
        cmocka_unit_test(deep_overlap_parts_gently),
        cmocka_unit_test(a_sphere_inside_boxes_comes_out),
        cmocka_unit_test(a_heavy_sphere_on_a_light_one_stays),
        cmocka_unit_test(far_from_the_origin_is_the_same),
        cmocka_unit_test(ten_thousand_in_one_spot_end),
        cmocka_unit_test(bad_definitions_are_refused),
        cmocka_unit_test(bad_calls_change_nothing),
        cmocka_unit_test(nothing_makes_the_state_nan),
        cmocka_unit_test(running_out_of_memory_is_an_error),
        cmocka_unit_test(the_same_calls_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
