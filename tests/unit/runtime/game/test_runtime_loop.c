/* runtime: the game loop's arithmetic: how many updates at any frame rate, after stalls, and for how long. */
#include "game/loop.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t state = 0x9e3779b97f4a7c15u;
static uint64_t next(uint64_t below)
{
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return state % below;
}

/* N seconds are 60·N updates at any frame rate that keeps up, and never more than one update late. */
static void keeps_pace_at_any_frame_rate(void **unused)
{
    (void)unused;
    for (uint64_t rate = 13; rate <= 1000; rate++) {
        loop clock = {0};
        uint64_t total = 0, updates = 0;
        for (uint64_t frame = 1; frame <= rate * 20; frame++) {
            uint64_t until = frame * 1000000000u / rate;
            updates += (uint64_t)loop_advance(&clock, until - total);
            total = until;
            assert_int_equal(updates, total * 60 / 1000000000u);
        }
        assert_int_equal(clock.dropped, 0);
    }
}

static void random_frames_lose_nothing(void **unused)
{
    (void)unused;
    print_message("seed %#llx\n", (unsigned long long)state);
    loop clock = {0};
    uint64_t total = 0, updates = 0;
    for (int i = 0; i < 1000000; i++) {
        uint64_t elapsed = next(83333333); /* below five updates */
        total += elapsed;
        updates += (uint64_t)loop_advance(&clock, elapsed);
        float alpha = loop_alpha(&clock);
        assert_true(alpha >= 0 && alpha < 1);
    }
    assert_int_equal(updates, (uint64_t)((unsigned __int128)total * 60 / 1000000000u));
}

/* After a stall five updates run, the rest are dropped, and the pace goes on as before. */
static void a_stall_slows_down_and_does_not_spiral(void **unused)
{
    (void)unused;
    loop clock = {0};
    assert_int_equal(loop_advance(&clock, 2000000000u), LOOP_MAX_UPDATES);
    assert_int_equal(clock.dropped, 120 - LOOP_MAX_UPDATES);
    assert_int_equal(loop_advance(&clock, 0), 0);
    int updates = 0;
    for (int i = 0; i < 60; i++) updates += loop_advance(&clock, 16666667);
    assert_int_equal(updates, 60);
    /* A machine that takes 200 ms a frame plays at five updates a frame, for ever. */
    for (int i = 0; i < 1000; i++) assert_int_equal(loop_advance(&clock, 200000000), LOOP_MAX_UPDATES);
    /* A clock that jumps by centuries does no harm. */
    assert_int_equal(loop_advance(&clock, UINT64_MAX), LOOP_MAX_UPDATES);
    assert_true(loop_alpha(&clock) < 1);
}

static void alpha_is_how_far_the_next_update_is(void **unused)
{
    (void)unused;
    loop clock = {0};
    assert_true(loop_alpha(&clock) == 0);
    assert_int_equal(loop_advance(&clock, 8333333), 0);
    assert_true(loop_alpha(&clock) > 0.4999f && loop_alpha(&clock) < 0.5001f);
    assert_int_equal(loop_advance(&clock, 8333333), 0);
    assert_true(loop_alpha(&clock) > 0.9999f && loop_alpha(&clock) < 1);
    assert_int_equal(loop_advance(&clock, 1), 1);
    assert_true(loop_alpha(&clock) < 1e-6f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(keeps_pace_at_any_frame_rate),
                                       cmocka_unit_test(random_frames_lose_nothing),
                                       cmocka_unit_test(a_stall_slows_down_and_does_not_spiral),
                                       cmocka_unit_test(alpha_is_how_far_the_next_update_is)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
