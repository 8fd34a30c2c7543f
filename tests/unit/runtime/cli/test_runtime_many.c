/* How several processes share a job: every piece once, whatever their speeds, and nobody waits for long. */
#include "many/share.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fixtures.h"

enum { MOST = 12, PIECES = 1000 };

typedef struct worker {
    int pieces[SHARE_AHEAD], count; /* before it */
    int slow, rest;                 /* ticks for a piece, and of the running one */
    uint64_t last;
    bool any;
} worker;

typedef struct job {
    share share;
    worker worker[MOST];
    int keeper[PIECES]; /* of each group */
    uint8_t given[PIECES];
    uint64_t end; /* pieces that exist */
} job;

static void give(job *j)
{
    share_work work;
    while (share_give(&j->share, &work)) {
        worker *w = &j->worker[work.process];
        uint64_t group = work.piece / j->share.def.group;
        assert_int_equal(j->given[work.piece]++, 0);
        assert_true(w->count < SHARE_AHEAD);
        if (j->share.def.ascending && w->any) assert_true(work.piece > w->last);
        if (j->keeper[group] < 0) j->keeper[group] = work.keeper;
        assert_int_equal(j->keeper[group], work.keeper);
        assert_true(j->share.group[group].waiting <= share_window(j->share.def.processes));
        w->pieces[w->count++] = (int)work.piece, w->last = work.piece, w->any = true;
    }
}

static void work_for_a_tick(job *j, int process)
{
    worker *w = &j->worker[process];
    if (w->count == 0 || --w->rest > 0) return;
    uint64_t piece = (uint64_t)w->pieces[0];
    memmove(w->pieces, w->pieces + 1, (size_t)--w->count * sizeof *w->pieces);
    w->rest = w->slow;
    if (piece >= j->end) {
        share_none(&j->share, process, piece);
        return;
    }
    share_made(&j->share, process);
    share_taken(&j->share, piece);
}

/* Ticks until all is done. */
static long run(job *j)
{
    long ticks = 0;
    for (give(j); !share_finished(&j->share); ticks++) {
        assert_true(ticks < 1000000);
        for (int i = 0; i < j->share.def.processes; i++) work_for_a_tick(j, i);
        give(j);
    }
    return ticks;
}

static job *job_make(const share_def *def)
{
    job *j = calloc(1, sizeof *j);
    assert_non_null(j);
    assert_true(share_open(&j->share, def));
    for (int i = 0; i < PIECES; i++) j->keeper[i] = -1;
    for (int i = 0; i < def->processes; i++) j->worker[i].slow = j->worker[i].rest = 1;
    j->end = def->count;
    return j;
}

static void job_free(job *j)
{
    share_close(&j->share);
    free(j);
}

static void each_piece_is_made_once(void **unused)
{
    (void)unused;
    fixture_seed(7);
    for (int round = 0; round < 500; round++) {
        share_def def = {.count = random_bits() % PIECES,
                         .group = 1 + random_bits() % 150,
                         .processes = 1 + (int)(random_bits() % MOST),
                         .ascending = random_bits() % 2};
        job *j = job_make(&def);
        uint64_t skipped = 0;
        for (int i = 0; i < def.processes; i++) j->worker[i].slow = j->worker[i].rest = 1 + (int)(random_bits() % 9);
        for (uint64_t i = random_bits() % 2 * def.count; i < def.count; i += 1 + random_bits() % 3)
            share_skip(&j->share, i), j->given[i] = 1, skipped++;
        if (skipped == 0 && random_bits() % 3 == 0 && def.count > 0) j->end = random_bits() % def.count;
        run(j);
        for (uint64_t i = 0; i < j->end; i++) assert_int_equal(j->given[i], 1);
        job_free(j);
    }
}

/* Eight processes, one of which takes eight times as long, make as much as 7 1/8 of the fast ones. */
static void slow_ones_hold_nobody_up(void **unused)
{
    (void)unused;
    for (int group = 1; group <= 120; group += 119) {
        job *j = job_make(&(share_def){.count = 960, .group = (uint64_t)group, .processes = 8});
        j->worker[3].slow = j->worker[3].rest = 8;
        assert_in_range(run(j), 960 / 7.125, 960 / 7.125 * 1.15);
        job_free(j);
    }
}

/* One group, whose keeper gets all pieces: raw frames are printed by process 0. */
static void one_group_is_kept_by_the_first(void **unused)
{
    (void)unused;
    job *j = job_make(&(share_def){.count = 300, .group = 300, .processes = 5, .ascending = true});
    run(j);
    assert_int_equal(j->keeper[0], 0);
    job_free(j);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_piece_is_made_once),
        cmocka_unit_test(slow_ones_hold_nobody_up),
        cmocka_unit_test(one_group_is_kept_by_the_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
