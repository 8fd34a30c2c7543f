/* Elementary functions over lanes, for colours and texture coordinates: about 22 bits good, and the same bits in every
 * width. tests/unit/math/test_simd.c measures the errors stated here. */
#ifndef DAFT_ELEMENTARY_H
#define DAFT_ELEMENTARY_H

#include "math/simd/ops.h"

/* x > 0 and normal; absolute error below 3e-7 · max(1, |log2 x|). */
DAFT_INLINE vf vf_log2(vf x)
{
    vi bits = (vi)x, shifted = bits - vi_set(0x3f3504f3); /* sqrt(1/2): the mantissa ends in sqrt(1/2)..sqrt(2) */
    vi exponent = shifted >> 23;
    vf m = (vf)(bits - (exponent << 23));
    vf one = vf_set(1), z = (m - one) / (m + one), z2 = z * z;
    vf s = vf_set(1.0f / 9);
    s = s * z2 + vf_set(1.0f / 7);
    s = s * z2 + vf_set(1.0f / 5);
    s = s * z2 + vf_set(1.0f / 3);
    return vf_convert_to(exponent) + (z + z * z2 * s) * vf_set(2.88539008f);
}

/* x clamped to -126..126; relative error below 3e-7. */
DAFT_INLINE vf vf_exp2(vf x)
{
    x = vf_min(vf_max(x, vf_set(-126)), vf_set(126));
    vf whole = vf_floor(x + vf_set(0.5f)), r = (x - whole) * vf_set(0.693147181f), one = vf_set(1);
    vf s = one + r * vf_set(1.0f / 7);
    s = one + r * vf_set(1.0f / 6) * s;
    s = one + r * vf_set(1.0f / 5) * s;
    s = one + r * vf_set(1.0f / 4) * s;
    s = one + r * vf_set(1.0f / 3) * s;
    s = one + r * vf_set(1.0f / 2) * s;
    s = one + r * s;
    return (vf)((vi)s + (vi_convert_to(whole) << 23));
}

/* base in 0..1, exponent >= 0. */
DAFT_INLINE vf vf_pow(vf base, vf exponent)
{
    vf power = vf_exp2(exponent * vf_log2(vf_max(base, vf_set(1e-30f))));
    return vf_if_then_else(vf_lt(vf_set(0), base), power,
                           vf_if_then_else(vf_lt(vf_set(0), exponent), vf_set(0), vf_set(1)));
}

/* Absolute error below 5e-7; 0 for (0, 0). */
DAFT_INLINE vf vf_atan2(vf y, vf x)
{
    vf ax = vf_abs(x), ay = vf_abs(y), zero = vf_set(0);
    vf large = vf_max(ax, ay), small = vf_min(ax, ay);
    vf a = vf_if_then_else(vf_lt(zero, large), small / large, zero);
    vm upper = vf_lt(vf_set(0.414213562f), a); /* above tan(pi/8): turn by pi/4 */
    vf r = vf_if_then_else(upper, (a - vf_set(1)) / (a + vf_set(1)), a), r2 = r * r;
    vf s = vf_set(-1.0f / 15);
    s = s * r2 + vf_set(1.0f / 13);
    s = s * r2 - vf_set(1.0f / 11);
    s = s * r2 + vf_set(1.0f / 9);
    s = s * r2 - vf_set(1.0f / 7);
    s = s * r2 + vf_set(1.0f / 5);
    s = s * r2 - vf_set(1.0f / 3);
    vf angle = r + r * r2 * s;
    angle = angle + vf_if_then_else(upper, vf_set(0.785398163f), zero);
    angle = vf_if_then_else(vf_lt(ax, ay), vf_set(1.57079633f) - angle, angle);
    angle = vf_if_then_else(vf_lt(x, zero), vf_set(3.14159265f) - angle, angle);
    return vf_if_then_else(vf_lt(y, zero), -angle, angle);
}

/* x clamped to -1..1; absolute error below 1e-6. */
DAFT_INLINE vf vf_asin(vf x)
{
    x = vf_min(vf_max(x, vf_set(-1)), vf_set(1));
    return vf_atan2(x, vf_sqrt((vf_set(1) - x) * (vf_set(1) + x)));
}

#endif
