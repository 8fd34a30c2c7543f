/* -ffp-contract=off holds: no compiler turns a·b + c into one fused operation behind our back, not even where the
 * instruction is there. (A fused multiply-add rounds once instead of twice; its last bit differs, and with it every
 * promise about shared edges and replays.) The command lines themselves are checked by check_flags.sh. */
#include "fused.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* (1 + e)² - (1 + 2e) with e = 2^-12: the square is 1 + 2e + e², which rounds to 1 + 2e in a float (and 2^-27 the same
 * in a double). Rounded twice the answer is 0, fused it is e². */
static void float_sum_is_not_fused(void **unused)
{
    (void)unused;
    volatile float x = 1 + 0x1p-12f, c = -(1 + 0x1p-11f);
    assert_true(multiply_add_float(x, x, c) == 0);
}

static void double_sum_is_not_fused(void **unused)
{
    (void)unused;
    volatile double x = 1 + 0x1p-27, c = -(1 + 0x1p-26);
    assert_true(multiply_add_double(x, x, c) == 0);
}

static void the_check_can_tell(void **unused)
{
    (void)unused;
    volatile float x = 1 + 0x1p-12f, c = -(1 + 0x1p-11f);
    assert_true(fused_float(x, x, c) == 0x1p-24f);
}

int main(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("fma")) {
        print_message("[  SKIPPED ] 3 test(s): this processor has no fused multiply-add\n");
        return 77;
    }
#endif
    const struct CMUnitTest tests[] = {cmocka_unit_test(float_sum_is_not_fused),
                                       cmocka_unit_test(double_sum_is_not_fused), cmocka_unit_test(the_check_can_tell)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
