/* base: the scheduler: every index once, on a worker that there is, in loops and in stages, for any number of workers.
 */
#include "fixtures.h"

#include "base/base.h"

#include <stdatomic.h>

enum { COUNT = 1000, STAGES = 40 };

static const int WORKERS[] = {0, 1, 2, 3, 7, 1000};

typedef struct job {
    int workers;
    atomic_uint done[COUNT];
    atomic_uint total, wrong;
} job;

static void mark(void *context, uint32_t index, uint32_t worker)
{
    job *j = context;
    atomic_fetch_add(&j->done[index], 1);
    atomic_fetch_add(&j->total, 1);
    if (worker >= (uint32_t)daft_max_i(1, j->workers)) atomic_fetch_add(&j->wrong, 1);
}

static void check_and_clear(job *j, uint32_t count)
{
    assert_int_equal(j->wrong, 0);
    assert_int_equal(j->total, count);
    for (uint32_t i = 0; i < COUNT; i++) {
        assert_int_equal(j->done[i], i < count);
        atomic_store(&j->done[i], 0);
    }
    atomic_store(&j->total, 0);
}

static void a_loop_does_every_index_once(void **unused)
{
    (void)unused;
    static job j;
    for (size_t w = 0; w < DAFT_COUNT_OF(WORKERS); w++)
        for (uint32_t count = 0; count <= COUNT; count += count < 9 ? 1 : 331) {
            j.workers = WORKERS[w];
            daft_parallel_for(WORKERS[w], count, mark, &j);
            check_and_clear(&j, count);
        }
}

static void many_loops(void *context, daft_region *region)
{
    job *j = context;
    assert_true(daft_region_workers(region) >= 1 && daft_region_workers(region) <= DAFT_MAX_WORKERS);
    for (uint32_t count = 0; count < 300; count += 7) {
        daft_region_for(region, count, mark, j);
        check_and_clear(j, count); /* serial: the loop is over */
    }
}

static void loops_of_a_region_follow_each_other(void **unused)
{
    (void)unused;
    static job j;
    for (size_t w = 0; w < DAFT_COUNT_OF(WORKERS); w++) {
        j.workers = WORKERS[w];
        daft_parallel_region(WORKERS[w], many_loops, &j);
    }
}

/* Every stage reads what the one before it wrote: item i of its neighbours. */
typedef struct cells {
    uint32_t values[STAGES + 1][COUNT];
} cells;

static void add_neighbours(void *context, int stage, uint32_t first, uint32_t count)
{
    cells *c = context;
    for (uint32_t i = first; i < first + count; i++)
        c->values[stage + 1][i] =
            c->values[stage][i] + 3 * c->values[stage][(i + 1) % COUNT] + c->values[stage][(i + COUNT - 7) % COUNT];
}

static void run_stages(void *context, daft_region *region)
{
    daft_stage stages[2 * STAGES];
    for (int i = 0; i < STAGES; i++) {
        stages[2 * i] = (daft_stage){add_neighbours, i, 0, 400, 1 + (uint32_t)i};
        stages[2 * i + 1] = (daft_stage){add_neighbours, i, 400, COUNT - 400, 64};
    }
    daft_region_stages(region, stages, DAFT_COUNT_OF(stages), context);
}

static void a_stage_begins_when_the_one_before_it_is_done(void **unused)
{
    (void)unused;
    static cells expected, c;
    for (uint32_t i = 0; i < COUNT; i++) expected.values[0][i] = c.values[0][i] = i * i + 1;
    for (int stage = 0; stage < STAGES; stage++) add_neighbours(&expected, stage, 0, COUNT);
    for (size_t w = 0; w < DAFT_COUNT_OF(WORKERS); w++) {
        memset(c.values[1], 0, sizeof c - sizeof c.values[0]);
        daft_parallel_region(WORKERS[w], run_stages, &c);
        assert_memory_equal(&c, &expected, sizeof c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_loop_does_every_index_once),
        cmocka_unit_test(loops_of_a_region_follow_each_other),
        cmocka_unit_test(a_stage_begins_when_the_one_before_it_is_done),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
