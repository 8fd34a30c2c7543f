/* math: the deterministic functions against libm, over their whole range. Prints the worst error it saw. */
#include "math/trig.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

static uint64_t state = 88172645463325252u;
static double uniform(double low, double high)
{
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return low + (high - low) * (double)(state >> 11) * 0x1p-53;
}

static void trigonometry(void **unused)
{
    (void)unused;
    double worst = 0;
    for (int i = 0; i < 200000; i++) {
        double x = uniform(-100, 100), y = uniform(-1e6, 1e6), s = uniform(-1, 1), a = uniform(-3, 3);
        worst = fmax(worst, fabs(daft_sin(x) - sin(x)));
        worst = fmax(worst, fabs(daft_cos(x) - cos(x)));
        worst = fmax(worst, fabs(daft_cos(y) - cos(y)));
        worst = fmax(worst, fabs(daft_asin(s) - asin(s)));
        worst = fmax(worst, fabs(daft_acos(s) - acos(s)));
        worst = fmax(worst, fabs(daft_atan2(s, a) - atan2(s, a)));
    }
    print_message("worst absolute error %.3g\n", worst);
    assert_true(worst < 1e-15);
    assert_true(daft_atan2(0, 0) == 0);
    assert_true(isnan(daft_sin(INFINITY)) && isnan(daft_cos(NAN)));
}

static void powers(void **unused)
{
    (void)unused;
    double worst = 0;
    for (int i = 0; i < 200000; i++) {
        double x = uniform(-1000, 1000), b = uniform(1e-6, 10), e = uniform(-20, 20);
        worst = fmax(worst, fabs(daft_exp2(x) / exp2(x) - 1));
        worst = fmax(worst, fabs(daft_log2(b) - log2(b)) / (1 + fabs(log2(b))));
        worst = fmax(worst, fabs(daft_pow(b, e) / pow(b, e) - 1));
    }
    print_message("worst relative error %.3g\n", worst);
    assert_true(worst < 5e-14);
    assert_true(daft_exp2(0) == 1 && daft_exp2(10) == 1024 && daft_log2(8) == 3 && daft_pow(0, 2) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(trigonometry), cmocka_unit_test(powers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
