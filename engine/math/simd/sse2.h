/* The operations of ops.h on x86-64's baseline, SSE2: four lanes; and those of four lanes and of bytes for all x86
 * targets. Gathers, look-ups, compression, blocks and rows are plain.h's. */
#ifndef DAFT_SSE2_H
#define DAFT_SSE2_H

#include <immintrin.h>

#define DAFT_NATIVE_4
DAFT_INLINE v4 v4_min(v4 a, v4 b) { return (v4)_mm_min_ps((__m128)a, (__m128)b); }
DAFT_INLINE v4 v4_max(v4 a, v4 b) { return (v4)_mm_max_ps((__m128)a, (__m128)b); }
DAFT_INLINE v4 v4_sqrt(v4 a) { return (v4)_mm_sqrt_ps((__m128)a); }
DAFT_INLINE v4i v4i_convert_to(v4 a) { return (v4i)_mm_cvttps_epi32((__m128)a); }
DAFT_INLINE uint32_t v4_bits_from_mask(v4i m) { return (uint32_t)_mm_movemask_ps((__m128)m); }
DAFT_INLINE v4 v4_promote(const uint8_t p[4])
{
    int32_t bytes;
    memcpy(&bytes, p, 4);
    const __m128i zero = _mm_setzero_si128(), words = _mm_unpacklo_epi8(_mm_cvtsi32_si128(bytes), zero);
    return (v4)_mm_cvtepi32_ps(_mm_unpacklo_epi16(words, zero));
}
DAFT_INLINE void v4_demote(v4 a, uint8_t p[4])
{ /* beyond INT32_MAX a conversion gives INT32_MIN: so the bounds come first; max(NaN, 0) is 0 */
    const __m128 real = _mm_min_ps(_mm_max_ps((__m128)a, _mm_setzero_ps()), _mm_set1_ps(255));
    const __m128i words = _mm_packs_epi32(_mm_cvttps_epi32(real), _mm_setzero_si128());
    const int32_t bytes = _mm_cvtsi128_si32(_mm_packus_epi16(words, words));
    memcpy(p, &bytes, 4);
}
DAFT_INLINE void v4_transpose3(v4 a, v4 b, v4 c, v4 *x, v4 *y, v4 *z)
{
    __m128 low = _mm_unpacklo_ps((__m128)a, (__m128)b), high = _mm_unpackhi_ps((__m128)a, (__m128)b);
    *x = (v4)_mm_movelh_ps(low, (__m128)c);
    *y = (v4)_mm_shuffle_ps(low, (__m128)c, _MM_SHUFFLE(1, 1, 3, 2));
    *z = (v4)_mm_shuffle_ps(high, (__m128)c, _MM_SHUFFLE(2, 2, 1, 0));
}
/* Two words at a, then two at b. */
DAFT_INLINE __m128 v4_load_pairs(const int32_t *a, const int32_t *b)
{
    double low, high;
    memcpy(&low, a, 8), memcpy(&high, b, 8);
    return _mm_castpd_ps(_mm_setr_pd(low, high));
}

#define DAFT_NATIVE_BYTES
DAFT_INLINE uint32_t vu8_nondigits_16(const char *p)
{ /* '0' to '9' become 118 to 127, the largest of signed bytes */
    __m128i moved = _mm_add_epi8(_mm_loadu_si128((const __m128i *)(const void *)p), _mm_set1_epi8(127 - '9'));
    return (uint32_t)_mm_movemask_epi8(_mm_cmplt_epi8(moved, _mm_set1_epi8(118)));
}

#if DAFT_VL == 4

DAFT_INLINE uint64_t vu8_test_bit(const uint8_t bytes[64], uint32_t count, int k)
{
    const __m128i up = _mm_cvtsi32_si128(7 - k); /* bit k to the sign bit, which movemask takes */
    uint64_t bits = 0;
    for (uint32_t i = 0; i < count; i += 16) {
        __m128i some = _mm_loadu_si128((const __m128i *)(const void *)(bytes + i));
        bits |= (uint64_t)(uint32_t)_mm_movemask_epi8(_mm_sll_epi16(some, up)) << i;
    }
    return bits;
}

#define DAFT_NATIVE_ARITHMETIC
DAFT_INLINE vbits vbits_from_mask(vm m) { return (vbits)_mm_movemask_ps((__m128)m); }
DAFT_INLINE vf vf_min(vf a, vf b) { return (vf)_mm_min_ps((__m128)a, (__m128)b); }
DAFT_INLINE vf vf_max(vf a, vf b) { return (vf)_mm_max_ps((__m128)a, (__m128)b); }
DAFT_INLINE vf vf_sqrt(vf a) { return (vf)_mm_sqrt_ps((__m128)a); }
DAFT_INLINE float vf_reduce_min(vf a)
{
    __m128 b = _mm_min_ps((__m128)a, _mm_movehl_ps((__m128)a, (__m128)a));
    return _mm_cvtss_f32(_mm_min_ss(b, _mm_shuffle_ps(b, b, 1))) + 0;
}
DAFT_INLINE vi vi_convert_to(vf a) { return (vi)_mm_cvttps_epi32((__m128)a); }
DAFT_INLINE vf vf_convert_to(vi a) { return (vf)_mm_cvtepi32_ps((__m128i)a); }
DAFT_INLINE vf vf_approximate_reciprocal(vf a) { return (vf)_mm_rcp_ps((__m128)a); }

#define DAFT_NATIVE_DOUBLE
DAFT_INLINE vd vd_promote_half(vf a, int half)
{
    return (vd)_mm_cvtps_pd(half ? _mm_movehl_ps((__m128)a, (__m128)a) : (__m128)a);
}
DAFT_INLINE vf vf_demote2(vd low, vd high)
{
    return (vf)_mm_movelh_ps(_mm_cvtpd_ps((__m128d)low), _mm_cvtpd_ps((__m128d)high));
}
DAFT_INLINE vd vd_sqrt(vd a) { return (vd)_mm_sqrt_pd((__m128d)a); }
DAFT_INLINE vd vd_max(vd a, vd b) { return (vd)_mm_max_pd((__m128d)a, (__m128d)b); }

#define DAFT_NATIVE_TRANSPOSE
DAFT_INLINE void vf_transpose4(vf r[4])
{
    __m128 low01 = _mm_unpacklo_ps((__m128)r[0], (__m128)r[1]), high01 = _mm_unpackhi_ps((__m128)r[0], (__m128)r[1]);
    __m128 low23 = _mm_unpacklo_ps((__m128)r[2], (__m128)r[3]), high23 = _mm_unpackhi_ps((__m128)r[2], (__m128)r[3]);
    r[0] = (vf)_mm_shuffle_ps(low01, low23, 0x44), r[1] = (vf)_mm_shuffle_ps(low01, low23, 0xee);
    r[2] = (vf)_mm_shuffle_ps(high01, high23, 0x44), r[3] = (vf)_mm_shuffle_ps(high01, high23, 0xee);
}

/* Eight lanes in two registers */
#define DAFT_NATIVE_8
typedef union v8_halves {
    v8 whole;
    __m128 half[2];
} v8_halves;
DAFT_INLINE v8 v8_min(v8 a, v8 b)
{
    v8_halves x = {a}, y = {b}, r;
    r.half[0] = _mm_min_ps(x.half[0], y.half[0]), r.half[1] = _mm_min_ps(x.half[1], y.half[1]);
    return r.whole;
}
DAFT_INLINE v8 v8_max(v8 a, v8 b)
{
    v8_halves x = {a}, y = {b}, r;
    r.half[0] = _mm_max_ps(x.half[0], y.half[0]), r.half[1] = _mm_max_ps(x.half[1], y.half[1]);
    return r.whole;
}
DAFT_INLINE uint32_t v8_le_bits(v8 a, v8 b)
{
    v8_halves x = {a}, y = {b};
    return (uint32_t)(_mm_movemask_ps(_mm_cmple_ps(x.half[0], y.half[0])) |
                      _mm_movemask_ps(_mm_cmple_ps(x.half[1], y.half[1])) << 4);
}

#endif

#endif
