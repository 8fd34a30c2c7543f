/* The budget of bytes: exact, never over its limit from any number of threads, alive as long as its blocks. */
#include "base/budget.h"
#include "support_content.h"

static counting memory;

static void every_byte_is_counted(void **unused)
{
    (void)unused;
    daft_allocator counted = counting_allocator(&memory);
    daft_budget *budget = daft_budget_open(&counted, 10000);
    daft_allocator allocator = daft_budget_allocator(budget);
    uint64_t own = daft_budget_memory(budget).used;
    static const size_t alignments[] = {1, 8, 16, 32, 64};
    void *blocks[DAFT_COUNT_OF(alignments)];
    for (size_t i = 0; i < DAFT_COUNT_OF(alignments); i++) {
        blocks[i] = allocator.allocate(allocator.user, 100, alignments[i]);
        assert_true((uintptr_t)blocks[i] % alignments[i] == 0);
        memset(blocks[i], (int)i, 100);
    }
    uint64_t held = daft_budget_memory(budget).used - own;
    assert_true(held >= 500 && held <= 500 + 5 * 64);
    for (size_t i = 0; i < DAFT_COUNT_OF(alignments); i++) {
        for (int k = 0; k < 100; k++) assert_int_equal(((uint8_t *)blocks[i])[k], i);
        allocator.release(allocator.user, blocks[i]);
    }
    daft_memory now = daft_budget_memory(budget);
    assert_true(now.used == own && now.peak == own + held && now.limit == 10000);
    daft_budget_close(budget);
    assert_int_equal(memory.live, 0);
}

static void the_limit_holds(void **unused)
{
    (void)unused;
    daft_allocator counted = counting_allocator(&memory);
    daft_budget *budget = daft_budget_open(&counted, 10000);
    daft_allocator allocator = daft_budget_allocator(budget);
    uint64_t own = daft_budget_memory(budget).used;
    assert_null(daft_alloc(&allocator, 10000, 1));
    assert_null(allocator.allocate(allocator.user, SIZE_MAX, 64));
    assert_null(allocator.allocate(allocator.user, SIZE_MAX - 64, 64));
    assert_true(daft_budget_take(budget, 10000 - own));
    assert_false(daft_budget_take(budget, 1));
    assert_false(daft_budget_take(budget, UINT64_MAX));
    assert_null(daft_alloc(&allocator, 1, 1));
    daft_budget_give(budget, 10000 - own);
    memory.fail_at = memory.calls; /* what the allocator below refuses is not counted */
    assert_null(daft_alloc(&allocator, 1, 1));
    assert_int_equal(daft_budget_memory(budget).used, own);
    daft_error error;
    assert_true(daft_budget_allows(&allocator, 10000 - own, "a.png", "it", &error));
    assert_false(daft_budget_allows(&allocator, 10001 - own, "a.png", "it", &error));
    assert_string_equal(error.file, "a.png");
    assert_contains(error.message, "the limit is 10 kB");
    assert_true(daft_budget_allows(&counted, UINT64_MAX, "a.png", "it", &error));
    daft_budget_close(budget);
    assert_int_equal(memory.live, 0);
}

static void a_block_may_outlive_it(void **unused)
{
    (void)unused;
    daft_allocator counted = counting_allocator(&memory);
    daft_budget *budget = daft_budget_open(&counted, 0);
    daft_allocator allocator = daft_budget_allocator(budget);
    void *first = daft_alloc(&allocator, 10, 1), *second = daft_alloc(&allocator, 10, 1);
    daft_budget_close(budget);
    daft_release(&allocator, first);
    daft_release(&allocator, second);
    assert_int_equal(memory.live, 0);
}

enum { TASKS = 64, ROUNDS = 2000 };

static void take_and_give(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const daft_allocator *allocator = context;
    for (int i = 0; i < ROUNDS; i++) {
        void *block = daft_alloc(allocator, 1 + (index * 31 + (uint32_t)i) % 1500, 1);
        daft_release(allocator, block);
    }
}

static void threads_share_it(void **unused)
{
    (void)unused;
    daft_allocator from = daft_malloc_allocator();
    daft_budget *budget = daft_budget_open(&from, 4000);
    daft_allocator allocator = daft_budget_allocator(budget);
    uint64_t own = daft_budget_memory(budget).used;
    daft_parallel_for(8, TASKS, take_and_give, &allocator);
    assert_int_equal(daft_budget_memory(budget).used, own);
    assert_true(daft_budget_memory(budget).peak <= 4000);
    daft_budget_close(budget);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_byte_is_counted),
        cmocka_unit_test(the_limit_holds),
        cmocka_unit_test(a_block_may_outlive_it),
        cmocka_unit_test(threads_share_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
