/* sim: the pairs that a step looks at against a search of all parts: what moves, rests, sleeps, only senses, is of
 * another layer or joined; while bodies come, go, are placed elsewhere and fall asleep; and many of them in one spot.
 */
#include "sim_scene.h"

#include "math/simd/dispatch.h"
#include "sim/world.h"
#include "sim/broad/broad.h"
#include "sim/contact/contact.h"

enum { BODIES = 160, MOST = 6000 };

static one_shape random_body(void)
{
    double kind = uniform(0, 1), size = uniform(0.1, 0.5);
    daft_dvec3 at = random_in(-3, 3);
    one_shape def =
        uniform(0, 1) < 0.5 ? sphere(size, at.x, at.y, at.z) : box(daft_v3(0.2f, 0.3f, (float)size), at.x, at.y, at.z);
    def.kind = kind < 0.15 ? DAFT_BODY_STATIC : kind < 0.3 ? DAFT_BODY_KINEMATIC : DAFT_BODY_DYNAMIC;
    def.part.sensor = uniform(0, 1) < 0.1;
    def.part.layers = uniform(0, 1) < 0.8 ? 1 : 2, def.part.mask = uniform(0, 1) < 0.8 ? 3 : 1;
    return def;
}

static uint32_t add_random(daft_world *world)
{
    one_shape def = random_body();
    if (def.part.sensor && def.kind == DAFT_BODY_DYNAMIC) def.kind = DAFT_BODY_KINEMATIC; /* it has no mass */
    uint32_t id = add(world, def);
    daft_dvec3 v = random_in(-4, 4), w = random_in(-6, 6);
    if (uniform(0, 1) < 0.7) daft_world_set_velocity(world, id, daft_to_float(v), daft_to_float(w));
    return id;
}

static bool is_active(const daft_world *world, uint32_t part)
{
    return daft_sim_is_active(&world->bodies[world->parts[part].body]);
}

/* As pairs are kept: a dynamic one first, the sensor first, else the lower index. */
static uint64_t key_of(const daft_world *world, uint32_t a, uint32_t b)
{
    const daft_sim_part *x = &world->parts[a], *y = &world->parts[b];
    bool swap = x->sensor || y->sensor ? y->sensor : x->dynamic == y->dynamic ? b < a : y->dynamic;
    return swap ? (uint64_t)b << 32 | a : (uint64_t)a << 32 | b;
}

/* What the next step will look at. */
static size_t search_all(const daft_world *world, uint64_t *keys)
{
    size_t count = 0;
    for (uint32_t a = 0; a < world->part_count; a++)
        for (uint32_t b = a + 1; b < world->part_count; b++) {
            if (world->parts[a].body == DAFT_SIM_NONE || world->parts[b].body == DAFT_SIM_NONE) continue;
            if (!is_active(world, a) && !is_active(world, b)) continue;
            if (!daft_sim_overlap(&world->tight[a], &world->tight[b]) || !daft_sim_may_meet(world, a, b)) continue;
            assert_true(count < MOST);
            keys[count++] = key_of(world, a, b);
        }
    return count;
}

static int by_value(const void *p, const void *q)
{
    uint64_t a = *(const uint64_t *)p, b = *(const uint64_t *)q;
    return (a > b) - (a < b);
}

static void check_pairs(const daft_world *world)
{
    static uint64_t keys[MOST];
    size_t count = search_all(world, keys), listed = 0;
    qsort(keys, count, sizeof *keys, by_value);
    for (size_t i = 0; i < world->active.count; i++) {
        uint64_t key = world->active.items[i].key;
        if (!is_active(world, (uint32_t)(key >> 32)) && !is_active(world, (uint32_t)key)) continue;
        assert_true(listed < count && keys[listed] == key);
        assert_true(daft_sim_pair_key(&world->pairs[world->active.items[i].pair]) == key);
        listed++;
    }
    assert_int_equal(listed, count);
}

static void change_some(daft_world *world, uint32_t *ids)
{
    for (int k = 0; k < 4; k++) {
        uint32_t i = (uint32_t)uniform(0, BODIES);
        double what = uniform(0, 1);
        daft_dvec3 at = random_in(-3, 3);
        if (what < 0.3) {
            daft_world_remove(world, ids[i]);
            ids[i] = add_random(world);
        } else if (what < 0.5) {
            daft_world_set_pose(world, ids[i], at, daft_quat_identity(), uniform(0, 1) < 0.5);
        } else if (what < 0.7) {
            daft_world_set_filter(world, ids[i], 1, uniform(0, 1) < 0.5 ? 1 : 3);
        } else if (what < 0.9) {
            daft_world_set_awake(world, ids[i], uniform(0, 1) < 0.3);
        } else {
            daft_sim_joint_def joint = daft_default_sim_joint_def();
            joint.body_a = ids[i], joint.body_b = ids[(i + (i % 3 ? 1 : 90)) % BODIES], joint.anchor = at;
            uint32_t made = daft_world_add_joint(world, &joint, NULL);
            if (made && uniform(0, 1) < 0.7) daft_world_remove_joint(world, made);
        }
    }
}

/* Without the rest of the step, so that all stays as the pairs were found in. False: some were woken by that, which the
 * next step looks at. */
static bool find_pairs(daft_world *world)
{
    uint32_t asleep = world->asleep_count;
    assert_true(daft_sim_broad_update(world, DT) && daft_sim_pairs_find(world));
    return world->asleep_count == asleep;
}

static void pairs_are_those_that_a_search_of_all_finds(void **unused)
{
    (void)unused;
    seed_random(4713);
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        daft_world *world = new_world();
        uint32_t ids[BODIES];
        daft_world_set_workers(world, 1 + isa, isa);
        daft_world_set_gravity(world, daft_v3(0, -1, 0));
        for (int i = 0; i < BODIES; i++) ids[i] = add_random(world);
        size_t most = 0, asleep = 0;
        int checked = 0;
        for (int step = 0; step < 60; step++) {
            change_some(world, ids);
            if (find_pairs(world)) {
                check_pairs(world);
                checked++;
            }
            if (world->active.count > most) most = world->active.count;
            if (world->asleep_count > asleep) asleep = world->asleep_count;
            assert_true(daft_world_step(world, DT, NULL));
        }
        print_message("at most %zu pairs and %zu asleep; %d steps checked\n", most, asleep, checked);
        assert_true(most > 120 && asleep > 5 && checked > 40);
        daft_world_destroy(world);
    }
}

/* Far from the origin floats are coarse, and must not lose a pair. */
static void none_is_lost_far_away(void **unused)
{
    (void)unused;
    seed_random(4712);
    const double far[] = {1e3, 1e7, 1e11};
    for (size_t k = 0; k < DAFT_COUNT_OF(far); k++) {
        daft_world *world = new_world();
        for (int i = 0; i < BODIES; i++) {
            daft_dvec3 at = random_in(-2, 2);
            add(world, sphere(0.3, (i % 2 ? far[k] : 0) + at.x, at.y - (i % 3 ? far[k] : 0), at.z));
        }
        for (int step = 0; step < 5; step++) {
            find_pairs(world);
            check_pairs(world);
            assert_true(world->active.count > 20);
            assert_true(daft_world_step(world, DT, NULL));
        }
        daft_world_destroy(world);
    }
}

/* Of 700 spheres in one spot none owns more pairs than it may, and which it owns depends on nothing but the state. */
static void a_crowd_has_bounded_pairs(void **unused)
{
    (void)unused;
    uint64_t hashes[2 * DAFT_ISA_COUNT];
    int runs = 0;
    for (int isa = 0; isa <= daft_isa_best(); isa++)
        for (int workers = 1; workers <= 3; workers += 2) {
            daft_world *world = new_world();
            daft_world_set_workers(world, workers, isa);
            for (int i = 0; i < 700; i++) add(world, sphere(i % 5 ? 0.5 : 0.4, 0, 1, 0));
            uint64_t hash = 0;
            for (int step = 0; step < 3; step++) {
                assert_true(daft_world_step(world, DT, NULL));
                assert_true(world->active.count > 10000 && world->active.count <= 700 * DAFT_SIM_MAX_PARTNERS);
                for (size_t i = 0; i < world->active.count; i++)
                    hash = daft_hash(&world->active.items[i].key, sizeof(uint64_t), hash);
            }
            for (uint32_t i = 0; i < world->part_count; i++)
                assert_true(world->parts[i].owned <= DAFT_SIM_MAX_PARTNERS);
            hashes[runs++] = daft_world_hash(world, hash);
            assert_true(hashes[runs - 1] == hashes[0]);
            daft_world_destroy(world);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_are_those_that_a_search_of_all_finds),
        cmocka_unit_test(none_is_lost_far_away),
        cmocka_unit_test(a_crowd_has_bounded_pairs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
