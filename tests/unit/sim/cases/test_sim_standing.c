/* sim, cases of the table that must stand: single boxes, stacks of everything, pyramids of all sizes, a tower of loose
 * blocks, heavy on light, a bridge. */
#include "sim_cases.h"

/* ---- boxes ---- */

static void a_box_falls_asleep(void **unused)
{
    (void)unused;
    uint64_t hashes[VARIANTS];
    for (int k = 0; k < VARIANTS; k++) {
        if (!is_played(k)) continue;
        const variant *v = &VARIANT[k];
        daft_world *world = variant_world(v);
        put(world, v, box(daft_v3(10, 1, 10), 0, -1, 0));
        uint32_t id = put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0.3, 0.5001, -0.2));
        double lowest = 1, fastest = 0, moved = 0;
        int asleep = 0;
        for (int i = 1; i <= 600; i++) {
            steps(world, 1);
            daft_dvec3 p = place_of(world, v, id);
            lowest = fmin(lowest, p.y);
            moved = fmax(moved, hypot(p.x - 0.3, p.z + 0.2));
            if (i > 300) fastest = fmax(fastest, speed_of(state_of(world, id)));
            if (!asleep && !daft_world_is_awake(world, id)) asleep = i;
        }
        print_message("%s: asleep after %g s, overlap %g mm, moved %g mm\n", v->name, asleep / 60.0,
                      1e3 * (0.5 - lowest), 1e3 * moved);
        assert_true(asleep > 0 && asleep < 120 && lowest > 0.49 && fastest < 1e-3 && moved < 1e-3);
        hashes[k] = daft_world_hash(world, 0);
        daft_world_destroy(world);
    }
    assert_workers_agree(hashes);
}

static void ten_boxes_rest(void **unused)
{
    (void)unused;
    uint64_t hashes[VARIANTS];
    for (int k = 0; k < VARIANTS; k++) {
        if (!is_played(k)) continue;
        const variant *v = &VARIANT[k];
        daft_world *world = variant_world(v);
        daft_world_set_sleeping(world, false);
        put(world, v, box(daft_v3(10, 1, 10), 0, -1, 0));
        uint32_t ids[10];
        for (int i = 0; i < 10; i++) ids[i] = put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 0.5 + i, 0));
        steps(world, 300);
        double speed = 0, spin = 0, aside = 0, tilt = 0;
        for (int i = 0; i < 3300 && !heard(world, v, i, 300, &hashes[k]); i++) {
            steps(world, 1);
            for (int n = 0; n < 10; n++) {
                daft_sim_state s = state_of(world, ids[n]);
                daft_dvec3 p = place_of(world, v, ids[n]);
                speed = fmax(speed, speed_of(s)), spin = fmax(spin, (double)daft_length(s.angular));
                aside = fmax(aside, hypot(p.x, p.z)), tilt = fmax(tilt, tilt_of(world, ids[n]));
            }
        }
        print_message("%s: %g m/s, %g rad/s, %g mm aside, tilt %g degrees\n", v->name, speed, spin, 1e3 * aside,
                      tilt * 180 / DAFT_PI);
        assert_true(speed < 0.01 && spin < 0.02 && aside < 0.02 && tilt < 0.5 * DAFT_PI / 180);
        daft_world_destroy(world);
    }
    assert_workers_agree(hashes);
}

/* ---- round bodies, one exactly above the other ---- */

static void stack_of(daft_sim_shape shape, int count, double height, const char *name)
{
    uint64_t hashes[VARIANTS];
    for (int k = 0; k < VARIANTS; k++) {
        if (!is_played(k)) continue;
        const variant *v = &VARIANT[k];
        daft_world *world = variant_world(v);
        daft_world_set_sleeping(world, false);
        put(world, v, box(daft_v3(10, 1, 10), 0, -1, 0));
        uint32_t ids[30];
        for (int i = 0; i < count; i++) {
            one_shape def = sphere(0.5, 0, height * (i + 0.5), 0);
            def.part.shape = shape;
            ids[i] = put(world, v, def);
        }
        double aside = 0, fastest = 0, sank = 0;
        for (int i = 0; i < 300; i++) {
            steps(world, 1);
            for (int n = 0; n < count; n++) {
                daft_dvec3 p = place_of(world, v, ids[n]);
                aside = fmax(aside, hypot(p.x, p.z)), fastest = fmax(fastest, speed_of(state_of(world, ids[n])));
                sank = fmax(sank, height * (n + 0.5) - p.y);
            }
        }
        print_message("%d %s, %s: %g mm aside, fastest %g m/s, sank %g mm\n", count, name, v->name, 1e3 * aside,
                      fastest, 1e3 * sank);
        assert_true(aside < 1e-3 && fastest < 2);
        hashes[k] = daft_world_hash(world, 0);
        daft_world_destroy(world);
    }
    assert_workers_agree(hashes);
}

static void round_stacks_stand(void **unused)
{
    (void)unused;
    daft_error error = {0};
    daft_sim_shape shape;
    assert_true(daft_shape_sphere(0.5f, &shape, &error));
    stack_of(shape, 30, 1, "balls");
    assert_true(daft_shape_capsule(0.5f, 0.25f, &shape, &error));
    stack_of(shape, 20, 1.5, "capsules");
    daft_hull *hull = cylinder(0.5, 0.5);
    stack_of(daft_shape_hull(hull), 10, 1, "cylinders");
    daft_hull_free(hull);
}

/* ---- pyramids ---- */

static int add_pyramid(daft_world *world, const variant *v, int rows, double size, daft_dvec3 *from, uint32_t *ids)
{
    int n = 0;
    put(world, v, box(daft_v3((float)(10 * size), (float)size, (float)(10 * size)), 0, -size, 0));
    float half = (float)(size / 2);
    for (int row = 0; row < rows; row++)
        for (int i = 0; i < rows - row; i++, n++) {
            from[n] = daft_dv3(1.05 * size * (i + 0.5 * row - 0.5 * (rows - 1)), size * (0.5 + row), 0);
            ids[n] = put(world, v, dynamic_box(daft_v3(half, half, half), from[n].x, from[n].y, 0));
        }
    return n;
}

/* Ten rows of boxes, of 5 cm, 1 m and 100 m: no box leaves its place by 2 % of its size, none loses its contact, and
 * what is left of motion after ten seconds is below 1e-4 J. */
static void pyramids_of_all_sizes_stand(void **unused)
{
    (void)unused;
    static const double sizes[] = {0.05, 1, 100};
    for (int j = 0; j < 3; j++) {
        uint64_t hashes[VARIANTS];
        for (int k = 0; k < VARIANTS; k++) {
            if (!is_played(k)) continue;
            const variant *v = &VARIANT[k];
            daft_world *world = variant_world(v);
            uint32_t ids[55];
            daft_dvec3 from[55];
            int n = add_pyramid(world, v, 10, sizes[j], from, ids);
            double moved = 0, energy = 0;
            for (int i = 0; i < 600; i++) {
                steps(world, 1);
                for (int b = 0; b < n; b++) moved = fmax(moved, distance_of(from[b], place_of(world, v, ids[b])));
            }
            float half = (float)(sizes[j] / 2);
            for (int b = 0; b < n; b++) energy = fmax(energy, energy_of(world, ids[b], daft_v3(half, half, half)));
            const daft_sim_contact *contacts;
            uint32_t touching = daft_world_contacts(world, &contacts);
            print_message("boxes of %g m, %s: moved %g m, %g J, %u contacts, %u awake\n", sizes[j], v->name, moved,
                          energy, touching, daft_world_counters(world).awake);
            assert_true(moved < 0.02 * sizes[j] && energy < 1e-4 && touching == 10 + 2 * 45);
            hashes[k] = daft_world_hash(world, 0);
            daft_world_destroy(world);
        }
        assert_workers_agree(hashes);
    }
}

/* The box at the top of ten rows is 100, 200, 300 times as dense. */
static uint64_t heavy_tops(const variant *v)
{
    uint64_t hash = 0;
    for (int times = 100; times <= 300; times += 100) {
        daft_world *world = variant_world(v);
        daft_world_set_sleeping(world, false);
        uint32_t ids[55];
        daft_dvec3 from[55];
        int n = add_pyramid(world, v, 10, 1, from, ids);
        daft_world_remove(world, ids[n - 1]);
        one_shape top = dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), from[n - 1].x, from[n - 1].y, 0);
        top.density *= (float)times;
        ids[n - 1] = put(world, v, top);
        double sank = 0, moved = 0;
        for (int i = 0; i < 1200; i++) {
            steps(world, 1);
            for (int b = 0; b < n; b++) {
                daft_dvec3 p = place_of(world, v, ids[b]);
                sank = fmax(sank, from[b].y - p.y), moved = fmax(moved, distance_of(from[b], p));
            }
        }
        print_message("top %d times as dense: moved %g m, sank %g m\n", times, moved, sank);
        assert_true(moved < 0.05);
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void a_heavy_top_does_not_crush_a_pyramid(void **unused)
{
    (void)unused;
    play_variants(heavy_tops);
}

/* ---- a tower of loose blocks ---- */

/* 18 layers of three, each layer across the one below. Blocks of 25 by 15 by 75 mm, and ten times that. */
static void a_tower_of_blocks_stands(void **unused)
{
    (void)unused;
    for (int large = 0; large < 2; large++) {
        uint64_t hashes[VARIANTS];
        for (int k = 0; k < VARIANTS; k++) {
            if (!is_played(k)) continue;
            const variant *v = &VARIANT[k];
            daft_world *world = variant_world(v);
            double s = large ? 10 : 1, wide = 0.025 * s, high = 0.015 * s;
            put(world, v, box(daft_v3((float)s, (float)s, (float)s), 0, -s, 0));
            uint32_t ids[54], n = 0;
            daft_dvec3 from[54];
            for (int layer = 0; layer < 18; layer++)
                for (int i = -1; i <= 1; i++, n++) {
                    from[n] = daft_dv3(layer & 1 ? 0 : i * wide, high * (layer + 0.5), layer & 1 ? i * wide : 0);
                    float across = (float)(wide / 2), along = (float)(1.5 * wide), half = (float)(high / 2);
                    daft_vec3 size = layer & 1 ? daft_v3(along, half, across) : daft_v3(across, half, along);
                    one_shape block = dynamic_box(size, from[n].x, from[n].y, from[n].z);
                    block.density = 600;
                    ids[n] = put(world, v, block);
                }
            daft_world_set_sleeping(world, false);
            double moved = 0, fastest = 0;
            for (int i = 0; i < 3600 && !heard(world, v, i, 400, &hashes[k]); i++) {
                steps(world, 1);
                for (uint32_t b = 0; b < n; b++) {
                    moved = fmax(moved, distance_of(from[b], place_of(world, v, ids[b])));
                    if (i >= 300) fastest = fmax(fastest, speed_of(state_of(world, ids[b])));
                }
            }
            print_message("blocks of %g m, %s: moved %g mm, then at most %g m/s\n", 3 * wide, v->name, 1e3 * moved,
                          fastest);
            assert_true(moved < 0.1 * high);
            daft_world_destroy(world);
        }
        assert_workers_agree(hashes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_falls_asleep),
        cmocka_unit_test(ten_boxes_rest),
        cmocka_unit_test(round_stacks_stand),
        cmocka_unit_test(pyramids_of_all_sizes_stand),
        cmocka_unit_test(a_heavy_top_does_not_crush_a_pyramid),
        cmocka_unit_test(a_tower_of_blocks_stands),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
