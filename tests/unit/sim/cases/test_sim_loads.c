/* sim, cases of the table with loads and joints: heavy cylinders on light cubes, a bridge of planks, a door, ragdolls
 * on a mesh; and how a cylinder made of a hull rolls. */
#include "sim_cases.h"

/* ---- cylinders ---- */

/* 60 kg on a cube of 1 kg, and a thousand times a cube's mass: it is not pressed through the floor, and nothing jumps.
 */
static void a_cylinder_does_not_crush_a_cube(void **unused)
{
    (void)unused;
    daft_hull *hull = cylinder(0.3, 0.5);
    static const double loads[] = {60, 1000};
    for (int n = 0; n < 2; n++) {
        uint64_t hashes[VARIANTS];
        for (int k = 0; k < VARIANTS; k++) {
            if (!is_played(k)) continue;
            const variant *v = &VARIANT[k];
            daft_world *world = variant_world(v);
            daft_world_set_sleeping(world, false);
            put(world, v, box(daft_v3(10, 1, 10), 0, -1, 0));
            one_shape cube = dynamic_box(daft_v3(0.25f, 0.25f, 0.25f), 0.02, 0.25, 0.01), load = sphere(1, 0, 1, 0);
            cube.density = 8, load.part.shape = daft_shape_hull(hull);
            daft_mass mass;
            assert_true(daft_shape_mass(&load.part.shape, 1, &mass));
            load.density = (float)(loads[n] / mass.mass);
            uint32_t low = put(world, v, cube), top = put(world, v, load);
            double least = 1, jump = 0, sank = 0;
            for (int i = 0; i < 600; i++) {
                steps(world, 1);
                double y = place_of(world, v, low).y, above = place_of(world, v, top).y;
                least = fmin(least, y - 0.25), jump = fmax(jump, fmax(y - 0.25, above - 1)),
                sank = fmax(sank, 1 - above);
            }
            print_message("%g kg on 1, %s: cube %g mm into the floor, jumps %g mm, load sank %g mm, tilt %g degrees\n",
                          loads[n], v->name, -1e3 * least, 1e3 * jump, 1e3 * sank, tilt_of(world, top) * 180 / DAFT_PI);
            assert_true(least > -0.01 && jump < 0.05 && sank < 0.05);
            hashes[k] = end_of(world);
        }
        assert_workers_agree(hashes);
    }
    daft_hull_free(hull);
}

/* A prism's edges brake it: so a wheel made of a hull falls behind 2/3 g sin s on a slope, by a third with 32 sides. A
 * cylinder, the last here, does not. */
static void a_hull_is_no_wheel(void **unused)
{
    (void)unused;
    static const int sides[] = {8, 16, 32, 0};
    for (int n = 0; n < 4; n++) {
        daft_hull *hull = n == 3 ? cylinder(0.25, 0.3) : prism(0.25, 0.3, sides[n]);
        double angle = 0.3, s = daft_sin(angle), c = daft_cos(angle), r = 0.25;
        daft_world *world = new_world();
        one_shape slope = box(daft_v3(100, 1, 5), 0, 0, 0), roll = sphere(1, (1 + r) * s, (1 + r) * c, 0);
        slope.rotation = turned(0, 0, 1, -angle);
        roll.part.shape = daft_shape_hull(hull);
        roll.rotation = daft_quat_mul(slope.rotation, turned(1, 0, 0, DAFT_PI / 2));
        add(world, slope);
        uint32_t id = add(world, roll);
        steps(world, 120);
        double got = speed_of(state_of(world, id)) / 2, wanted = 2.0 / 3 * G * s;
        print_message("%d sides: %g m/s2, %g of 2/3 g sin s\n", sides[n], got, got / wanted);
        assert_true(n == 3 ? fabs(got - wanted) < 0.01 * wanted : got > 0 && got < wanted);
        daft_world_destroy(world);
        daft_hull_free(hull);
    }
}

/* ---- a bridge, a door ---- */

static uint32_t hinge(daft_world *world, uint32_t a, uint32_t b, daft_dvec3 at, daft_vec3 axis)
{
    daft_sim_joint_def def = daft_default_sim_joint_def();
    daft_error error = {0};
    def.kind = DAFT_JOINT_HINGE, def.body_a = a, def.body_b = b, def.anchor = at, def.axis = axis;
    uint32_t joint = daft_world_add_joint(world, &def, &error);
    if (!joint) fail_msg("%s", error.message);
    return joint;
}

static double open_by(const daft_world *world, uint32_t joint)
{
    daft_sim_joint_state s;
    assert_true(daft_world_get_joint(world, joint, &s));
    return distance_of(s.anchor_a, s.anchor_b);
}

/* Thirty planks of 58 kg, straight between two banks, and ten crates on it. Once it has sagged, after 10 s, or 20 where
 * crates are twice as heavy as planks, no hinge is open by a centimetre. */
static void bridge_carries(float density, int ticks)
{
    uint64_t hashes[VARIANTS];
    for (int k = 0; k < VARIANTS; k++) {
        if (!is_played(k)) continue;
        const variant *v = &VARIANT[k];
        daft_world *world = variant_world(v);
        uint32_t joints[31], last = 0, crates[10];
        for (int i = 0; i < 30; i++) {
            one_shape plank = dynamic_box(daft_v3(0.24f, 0.05f, 1), 0.5 * i - 7.25, 10, 0);
            plank.density = 600;
            uint32_t id = put(world, v, plank);
            joints[i] = hinge(world, last, id, variant_at(v, daft_dv3(0.5 * i - 7.5, 10, 0)), daft_v3(0, 0, 1));
            last = id;
        }
        joints[30] = hinge(world, 0, last, variant_at(v, daft_dv3(7.5, 10, 0)), daft_v3(0, 0, 1));
        for (int i = 0; i < 10; i++) {
            one_shape crate = dynamic_box(daft_v3(0.25f, 0.25f, 0.25f), 1.2 * i - 5.4, 10.6, 0.2 * (i % 3) - 0.2);
            crate.density = density;
            crates[i] = put(world, v, crate);
        }
        double most = 0, late = 0, lowest = 10;
        for (int i = 0; i < ticks; i++) {
            steps(world, 1);
            for (int j = 0; j < 31; j++) most = fmax(most, open_by(world, joints[j]));
            if (i >= ticks - 120)
                for (int j = 0; j < 31; j++) late = fmax(late, open_by(world, joints[j]));
        }
        for (int i = 0; i < 10; i++) lowest = fmin(lowest, place_of(world, v, crates[i]).y);
        print_message("crates of %g kg, %s: hinges open by %g mm at most, %g mm at the end, lowest crate at %g m\n",
                      (double)density / 8, v->name, 1e3 * most, 1e3 * late, lowest);
        assert_true(late < 0.01 && most < 0.03 && lowest > 7);
        hashes[k] = daft_world_hash(world, 0);
        daft_world_destroy(world);
    }
    assert_workers_agree(hashes);
}

static void a_bridge_carries_crates(void **unused)
{
    (void)unused;
    bridge_carries(400, 600);
    bridge_carries(1000, 1200);
}

/* A door of 40 kg that a motor drives to its stop and a ball hits there: less than a degree past its limits, less than
 * a centimetre open. */
static uint64_t door(const variant *v)
{
    daft_world *world = variant_world(v);
    daft_world_set_sleeping(world, false);
    one_shape leaf = dynamic_box(daft_v3(0.5f, 1, 0.04f), 0.5, 1.1, 0);
    leaf.density = 250;
    uint32_t door = put(world, v, leaf), ball = 0;
    uint32_t joint = hinge(world, 0, door, variant_at(v, daft_dv3(0, 1.1, 0)), variant_spin(v, daft_v3(0, 1, 0)));
    daft_world_set_joint_limit(world, joint, true, -1.5f, 1);
    daft_world_set_joint_motor(world, joint, true, 2, 100);
    double beyond = -1, open = 0;
    for (int i = 0; i < 480; i++) {
        if (i == 120) daft_world_set_joint_motor(world, joint, true, -2, 100);
        if (i == 300) {
            daft_sim_state s = state_in(world, v, door);
            ball = put(world, v, sphere(0.1, s.position.x + 1, 1.1, s.position.z - 3));
            launch(world, v, ball, daft_v3(-2, 1, 10), daft_v3(0, 0, 0));
        }
        steps(world, 1);
        daft_sim_joint_state s;
        assert_true(daft_world_get_joint(world, joint, &s));
        beyond = fmax(beyond, fmax(-1.5 - (double)s.value, (double)s.value - 1)),
        open = fmax(open, open_by(world, joint));
        if (i == 119) assert_near((double)s.value, 1, 0.02);
        if (i == 299) assert_near((double)s.value, -1.5, 0.02);
    }
    print_message("%g degrees past its limits, open by %g mm\n", beyond * 180 / DAFT_PI, 1e3 * open);
    assert_true(beyond < DAFT_PI / 180 && open < 0.01);
    return end_of(world);
}

static void a_door_keeps_to_its_limits(void **unused)
{
    (void)unused;
    play_variants(door);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cylinder_does_not_crush_a_cube),
        cmocka_unit_test(a_hull_is_no_wheel),
        cmocka_unit_test(a_bridge_carries_crates),
        cmocka_unit_test(a_door_keeps_to_its_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
