/* Deterministic elementary functions in double: argument reduction, then a Taylor or Chebyshev-like series long enough
 * that the truncation error is below the rounding error. Only +, -, *, /, sqrt and exact bit operations are used, so
 * IEEE 754 fixes every bit. */
#include "math/trig.h"

#include "daft.h" /* exports them */

#include <math.h>
#include <stdint.h>
#include <string.h>

/* pi/2 in three parts of 33 bits, so that k·part is exact for |k| < 2^20 (Cody and Waite). */
static const double HALF_PI_1 = 0x1.921fb544p+0, HALF_PI_2 = 0x1.0b4611a6p-34, HALF_PI_3 = 0x1.3198a2e037073p-69;
static const double TWO_OVER_PI = 0x1.45f306dc9c883p-1;

/* Taylor series on |x| <= pi/4: the first term left out is below 2^-58. */
static double sin_series(double x)
{
    double x2 = x * x;
    double s = -1.0 / 1307674368000.0;
    s = s * x2 + 1.0 / 6227020800.0;
    s = s * x2 - 1.0 / 39916800.0;
    s = s * x2 + 1.0 / 362880.0;
    s = s * x2 - 1.0 / 5040.0;
    s = s * x2 + 1.0 / 120.0;
    s = s * x2 - 1.0 / 6.0;
    return x + x * x2 * s;
}

static double cos_series(double x)
{
    double x2 = x * x;
    double c = 1.0 / 20922789888000.0;
    c = c * x2 - 1.0 / 87178291200.0;
    c = c * x2 + 1.0 / 479001600.0;
    c = c * x2 - 1.0 / 3628800.0;
    c = c * x2 + 1.0 / 40320.0;
    c = c * x2 - 1.0 / 720.0;
    c = c * x2 + 1.0 / 24.0;
    return 1 - 0.5 * x2 + x2 * x2 * c;
}

/* sin(x + quarter·pi/2) */
static double sin_quarter(double x, int quarter)
{
    if (!(fabs(x) <= 1e6)) return NAN;
    double k = floor(x * TWO_OVER_PI + 0.5);
    double r = ((x - k * HALF_PI_1) - k * HALF_PI_2) - k * HALF_PI_3;
    int turn = (int)((int64_t)k + quarter) & 3;
    double value = turn & 1 ? cos_series(r) : sin_series(r);
    return turn & 2 ? -value : value;
}

double daft_sin(double x) { return sin_quarter(x, 0); }
double daft_cos(double x) { return sin_quarter(x, 1); }
double daft_tan(double x) { return daft_sin(x) / daft_cos(x); }

/* atan on 0..1: reduced by atan(x) = 2·atan(x / (1 + sqrt(1 + x²))) twice, to |x| <= tan(pi/16), then Taylor. */
static double atan_unit(double x)
{
    x = x / (1 + sqrt(1 + x * x));
    x = x / (1 + sqrt(1 + x * x));
    double x2 = x * x, s = 0;
    for (int n = 23; n >= 3; n -= 2) s = x2 * ((n & 2 ? -1.0 : 1.0) / n + s);
    return 4 * (x + x * s);
}

double daft_atan2(double y, double x)
{
    double ax = fabs(x), ay = fabs(y);
    if (ax == 0 && ay == 0) return 0;
    double angle;
    if (isinf(ax) && isinf(ay))
        angle = 0x1.921fb54442d18p-1;
    else
        angle = ay <= ax ? atan_unit(ay / ax) : 0x1.921fb54442d18p+0 - atan_unit(ax / ay);
    if (x < 0) angle = 0x1.921fb54442d18p+1 - angle;
    return y < 0 ? -angle : angle;
}

double daft_asin(double x)
{
    if (x >= 1) return 0x1.921fb54442d18p+0;
    if (x <= -1) return -0x1.921fb54442d18p+0;
    return daft_atan2(x, sqrt((1 - x) * (1 + x)));
}

double daft_acos(double x)
{
    if (x >= 1) return 0;
    if (x <= -1) return 0x1.921fb54442d18p+1;
    return daft_atan2(sqrt((1 - x) * (1 + x)), x);
}

double daft_exp2(double x)
{
    if (isnan(x)) return x;
    if (x >= 1024) return INFINITY;
    if (x < -1022) return 0;
    double whole = floor(x + 0.5);
    double r = (x - whole) * 0x1.62e42fefa39efp-1; /* ln 2 */
    double s = 1;
    for (int n = 15; n >= 1; n--) s = 1 + s * r / n;
    uint64_t bits;
    memcpy(&bits, &s, sizeof bits);
    bits += (uint64_t)((int64_t)whole * ((int64_t)1 << 52));
    memcpy(&s, &bits, sizeof s);
    return s;
}

double daft_log2(double x)
{
    if (isnan(x)) return x;
    if (x <= 0) return -INFINITY;
    if (isinf(x)) return x;
    int exponent;
    double m = frexp(x, &exponent); /* 0.5 <= m < 1, exact */
    if (m < 0x1.6a09e667f3bcdp-1) m *= 2, exponent--;
    double z = (m - 1) / (m + 1), z2 = z * z, s = 0; /* |z| < 0.1716: atanh series */
    for (int n = 23; n >= 3; n -= 2) s = z2 * (1.0 / n + s);
    return exponent + 2 * (z + z * s) * 0x1.71547652b82fep+0;
}

double daft_pow(double base, double exponent)
{
    if (exponent == 0) return 1;
    if (base <= 0) return 0;
    return daft_exp2(exponent * daft_log2(base));
}
