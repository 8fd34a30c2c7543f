/* sim: the tree of bounds against a search of all of them, while leaves come, go, move and are laid out anew; and the
 * sort of the active list against the obvious one. */
#include "fixtures.h"

#include "sim/world.h"
#include "sim/contact/contact.h"

enum { PARTS = 300 };

typedef struct forest {
    daft_sim_tree tree;
    daft_sim_bounds bounds[PARTS];
    uint32_t leaf[PARTS]; /* DAFT_SIM_NONE: not in the tree */
    bool found[PARTS];
} forest;

static daft_sim_bounds random_bounds(void)
{
    double x = (double)random_float(-10, 10), y = (double)random_float(-10, 10), z = (double)random_float(-2, 2);
    double size = (double)random_float(0, 2);
    return (daft_sim_bounds){daft_dv3(x, y, z), daft_dv3(x + size, y + 0.5 * size, z + size)};
}

static void visit(void *context, uint32_t part)
{
    forest *f = context;
    assert_true(part < PARTS && f->leaf[part] != DAFT_SIM_NONE);
    assert_false(f->found[part]); /* once */
    f->found[part] = true;
}

static void check_query(forest *f, const daft_sim_bounds *bounds)
{
    memset(f->found, 0, sizeof f->found);
    daft_sim_tree_query(&f->tree, bounds, visit, f);
    for (uint32_t i = 0; i < PARTS; i++) {
        bool meets = f->leaf[i] != DAFT_SIM_NONE && f->bounds[i].low.x <= bounds->high.x &&
                     bounds->low.x <= f->bounds[i].high.x && f->bounds[i].low.y <= bounds->high.y &&
                     bounds->low.y <= f->bounds[i].high.y && f->bounds[i].low.z <= bounds->high.z &&
                     bounds->low.z <= f->bounds[i].high.z;
        assert_int_equal(f->found[i], meets);
    }
}

static void change_leaf(forest *f, uint32_t part)
{
    daft_allocator allocator = daft_malloc_allocator();
    if (f->leaf[part] != DAFT_SIM_NONE) daft_sim_tree_remove(&f->tree, f->leaf[part]);
    f->leaf[part] = DAFT_SIM_NONE;
    if (random_bits() % 5 == 0) return;
    f->bounds[part] = random_bounds();
    if (random_bits() % 4 == 0) f->bounds[part] = f->bounds[random_bits() % PARTS]; /* the same spot as another */
    assert_true(daft_sim_tree_reserve(&f->tree, &allocator, 1));
    f->leaf[part] = daft_sim_tree_insert(&f->tree, &f->bounds[part], part);
}

/* To bounds nearby, or anywhere; what the tree does not take where it stands is entered anew. */
static void move_leaves(forest *f)
{
    bool taken[PARTS] = {false};
    for (uint32_t i = 0; i < PARTS; i++) {
        if (f->leaf[i] == DAFT_SIM_NONE || random_bits() % 3) continue;
        daft_dvec3 by = daft_dv3((double)random_float(-1, 1), (double)random_float(-1, 1), (double)random_float(-1, 1));
        f->bounds[i] = (daft_sim_bounds){daft_dadd(f->bounds[i].low, by), daft_dadd(f->bounds[i].high, by)};
        if (random_bits() % 8 == 0) f->bounds[i] = random_bounds();
        taken[i] = !daft_sim_tree_move(&f->tree, f->leaf[i], &f->bounds[i]);
    }
    daft_sim_tree_fit(&f->tree);
    for (uint32_t i = 0; i < PARTS; i++) {
        if (!taken[i]) continue;
        daft_sim_tree_remove(&f->tree, f->leaf[i]);
        f->leaf[i] = daft_sim_tree_insert(&f->tree, &f->bounds[i], i);
    }
}

static void a_tree_finds_what_a_search_of_all_finds(void **unused)
{
    (void)unused;
    fixture_seed(811);
    daft_allocator allocator = daft_malloc_allocator();
    forest f = {0};
    daft_sim_tree_init(&f.tree);
    for (uint32_t i = 0; i < PARTS; i++) f.leaf[i] = DAFT_SIM_NONE, f.bounds[i] = random_bounds();
    int laid_out = 0;
    for (int round = 0; round < 200; round++) {
        for (int k = 0; k < 40; k++) change_leaf(&f, random_bits() % (round < 20 ? 20 : PARTS));
        if (round % 3) move_leaves(&f);
        daft_sim_tree_tidy(&f.tree);
        laid_out += f.tree.entered == 0;
        for (int k = 0; k < 10; k++) {
            daft_sim_bounds b = random_bounds();
            check_query(&f, &b);
        }
    }
    assert_true(laid_out > 10);
    for (uint32_t i = 0; i < PARTS; i++)
        if (f.leaf[i] != DAFT_SIM_NONE) assert_int_equal(f.tree.nodes[f.leaf[i]].part, i);
    daft_release(&allocator, f.tree.nodes);
    daft_release(&allocator, f.tree.keys);
}

/* ---- the active list ---- */

enum { MOST = 500 };

static void sort_slowly(daft_sim_active *items, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        daft_sim_active moved = items[i];
        size_t k = i;
        for (; k > 0 && items[k - 1].key > moved.key; k--) items[k] = items[k - 1];
        items[k] = moved;
    }
}

static void the_active_list_is_sorted_and_equal_keys_keep_their_order(void **unused)
{
    (void)unused;
    fixture_seed(812);
    daft_sim_active items[MOST], expected[MOST], scratch[MOST];
    for (int round = 0; round < 400; round++) {
        size_t count = random_bits() % MOST;
        uint32_t step = 1 + random_bits() % 40; /* long runs in order, with breaks between them */
        for (size_t i = 0; i < count; i++) {
            uint64_t key =
                round % 2 ? random_bits() % 50 : i % step + (random_bits() % 9 == 0 ? random_bits() % 60 : 0);
            expected[i] = items[i] = (daft_sim_active){.key = key, .pair = (uint32_t)i};
        }
        daft_sim_active_sort(items, count, scratch);
        sort_slowly(expected, count);
        for (size_t i = 0; i < count; i++) {
            assert_true(items[i].key == expected[i].key);
            assert_int_equal(items[i].pair, expected[i].pair);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tree_finds_what_a_search_of_all_finds),
        cmocka_unit_test(the_active_list_is_sorted_and_equal_keys_keep_their_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
