/* Functions whose results are state or pixels: libm's differ between systems, these do not. Each states its bound,
 * found by comparing with double-precision libm over the whole range (tests/unit/math/test_math.c). */
#ifndef DAFT_TRIG_H
#define DAFT_TRIG_H

/* Radians of any size up to 1e6; absolute error below 1e-15. NaN for non-finite. */
double daft_sin(double x);
double daft_cos(double x);
double daft_tan(double x);
/* Absolute error below 1e-15. daft_atan2(0, 0) is 0. */
double daft_atan2(double y, double x);
double daft_asin(double x); /* clamps x to -1..1 */
double daft_acos(double x);
/* Relative error below 5e-14 for results in the normal range. daft_log2 of 0 or less is -infinity. */
double daft_exp2(double x);
double daft_log2(double x);
double daft_pow(double base, double exponent); /* base >= 0 */

#endif
