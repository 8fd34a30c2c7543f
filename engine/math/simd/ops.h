/* SIMD lanes for the *_kernel.c sources. Three widths:
 *   vf / vi / vm   the widest the instruction set has: DAFT_VL lanes (4 SSE2 and plain, 8 AVX2, 16 AVX-512);
 *   v8             always 8 lanes, for 8-wide tree nodes;     v4   always 4, for leaves of triangles.
 * Arithmetic is written with the operators of GCC's vector extensions; what they do not have (comparison to a mask, select,
 * square root, gather) is here, with a plain twin for machines without intrinsics. No fused operations: every lane
 * computes exactly what the scalar code would, so all widths give the same bits. */
#ifndef DAFT_OPS_H
#define DAFT_OPS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#ifdef DAFT_HAVE_X86
#include <immintrin.h>
#endif

#if defined(DAFT_ISA_avx512)
#define DAFT_VL 16
#elif defined(DAFT_ISA_avx2)
#define DAFT_VL 8
#else
#define DAFT_VL 4
#endif

#define DAFT_INLINE static inline __attribute__((always_inline, unused))

typedef float vf __attribute__((vector_size(DAFT_VL * 4)));
typedef int32_t vi __attribute__((vector_size(DAFT_VL * 4)));
typedef float vf_unaligned __attribute__((vector_size(DAFT_VL * 4), aligned(4), may_alias));
typedef int32_t vi_unaligned __attribute__((vector_size(DAFT_VL * 4), aligned(4), may_alias));

/* A mask of lanes, as bits: bit i is lane i. Cheap on AVX-512, one movemask elsewhere. */
typedef uint32_t vbits;
#define DAFT_ALL_LANES ((vbits)((1u << DAFT_VL) - 1))

DAFT_INLINE vf vf_load(const float *p) { return *(const vf_unaligned *)p; }
DAFT_INLINE void vf_store(float *p, vf v) { *(vf_unaligned *)p = v; }
DAFT_INLINE vi vi_load(const void *p) { return *(const vi_unaligned *)p; }
DAFT_INLINE void vi_store(void *p, vi v) { *(vi_unaligned *)p = v; }

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion" /* in gcc's own macros for gathers, which -O0 shows */

#if defined(DAFT_ISA_avx512)
typedef __mmask16 vm;
DAFT_INLINE vf vf_set(float s) { return (vf)_mm512_set1_ps(s); }
DAFT_INLINE vi vi_set(int32_t s) { return (vi)_mm512_set1_epi32(s); }
DAFT_INLINE vm vf_lt(vf a, vf b) { return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ); }
DAFT_INLINE vm vf_le(vf a, vf b) { return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ); }
DAFT_INLINE vm vi_eq(vi a, vi b) { return _mm512_cmpeq_epi32_mask((__m512i)a, (__m512i)b); }
DAFT_INLINE vm vi_lt(vi a, vi b) { return _mm512_cmplt_epi32_mask((__m512i)a, (__m512i)b); }
DAFT_INLINE vm vm_and(vm a, vm b) { return (vm)(a & b); }
DAFT_INLINE vm vm_or(vm a, vm b) { return (vm)(a | b); }
DAFT_INLINE vm vm_not(vm a) { return (vm)~a; }
DAFT_INLINE vbits vbits_from_mask(vm m) { return m; }
DAFT_INLINE vm vm_from_bits(vbits b) { return (vm)b; }
DAFT_INLINE vf vf_if_then_else(vm m, vf a, vf b) { return (vf)_mm512_mask_blend_ps(m, (__m512)b, (__m512)a); }
DAFT_INLINE vi vi_if_then_else(vm m, vi a, vi b) { return (vi)_mm512_mask_blend_epi32(m, (__m512i)b, (__m512i)a); }
DAFT_INLINE vf vf_min(vf a, vf b) { return (vf)_mm512_min_ps((__m512)a, (__m512)b); }
DAFT_INLINE vf vf_max(vf a, vf b) { return (vf)_mm512_max_ps((__m512)a, (__m512)b); }
DAFT_INLINE vf vf_sqrt(vf a) { return (vf)_mm512_sqrt_ps((__m512)a); }
DAFT_INLINE vf vf_gather_index(const float *base, vi index) { return (vf)_mm512_i32gather_ps((__m512i)index, base, 4); }
DAFT_INLINE vi vi_gather_index(const void *base, vi index) { return (vi)_mm512_i32gather_epi32((__m512i)index, base, 4); }
DAFT_INLINE vi vi_convert_to(vf a) { return (vi)_mm512_cvttps_epi32((__m512)a); }
DAFT_INLINE vf vf_convert_to(vi a) { return (vf)_mm512_cvtepi32_ps((__m512i)a); }
DAFT_INLINE vf vf_iota(void) { return (vf){0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}; }
#else
typedef vi vm; /* all ones or all zeros in a lane */
DAFT_INLINE vm vf_lt(vf a, vf b) { return (vm)(a < b); }
DAFT_INLINE vm vf_le(vf a, vf b) { return (vm)(a <= b); }
DAFT_INLINE vm vi_eq(vi a, vi b) { return (vm)(a == b); }
DAFT_INLINE vm vi_lt(vi a, vi b) { return (vm)(a < b); }
DAFT_INLINE vm vm_and(vm a, vm b) { return a & b; }
DAFT_INLINE vm vm_or(vm a, vm b) { return a | b; }
DAFT_INLINE vm vm_not(vm a) { return ~a; }
#if defined(DAFT_ISA_avx2)
DAFT_INLINE vf vf_set(float s) { return (vf)_mm256_set1_ps(s); }
DAFT_INLINE vi vi_set(int32_t s) { return (vi)_mm256_set1_epi32(s); }
DAFT_INLINE vbits vbits_from_mask(vm m) { return (vbits)_mm256_movemask_ps((__m256)m); }
DAFT_INLINE vf vf_if_then_else(vm m, vf a, vf b) { return (vf)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)m); }
DAFT_INLINE vi vi_if_then_else(vm m, vi a, vi b) { return (vi)_mm256_blendv_epi8((__m256i)b, (__m256i)a, (__m256i)m); }
DAFT_INLINE vf vf_min(vf a, vf b) { return (vf)_mm256_min_ps((__m256)a, (__m256)b); }
DAFT_INLINE vf vf_max(vf a, vf b) { return (vf)_mm256_max_ps((__m256)a, (__m256)b); }
DAFT_INLINE vf vf_sqrt(vf a) { return (vf)_mm256_sqrt_ps((__m256)a); }
DAFT_INLINE vf vf_gather_index(const float *base, vi index) { return (vf)_mm256_i32gather_ps(base, (__m256i)index, 4); }
DAFT_INLINE vi vi_gather_index(const void *base, vi index) { return (vi)_mm256_i32gather_epi32((const int *)base, (__m256i)index, 4); }
DAFT_INLINE vi vi_convert_to(vf a) { return (vi)_mm256_cvttps_epi32((__m256)a); }
DAFT_INLINE vf vf_convert_to(vi a) { return (vf)_mm256_cvtepi32_ps((__m256i)a); }
DAFT_INLINE vf vf_iota(void) { return (vf){0, 1, 2, 3, 4, 5, 6, 7}; }
#else
DAFT_INLINE vf vf_set(float s) { return (vf){s, s, s, s}; }
DAFT_INLINE vi vi_set(int32_t s) { return (vi){s, s, s, s}; }
DAFT_INLINE vf vf_if_then_else(vm m, vf a, vf b) { return (vf)((m & (vi)a) | (~m & (vi)b)); }
DAFT_INLINE vi vi_if_then_else(vm m, vi a, vi b) { return (m & a) | (~m & b); }
DAFT_INLINE vf vf_iota(void) { return (vf){0, 1, 2, 3}; }
#ifdef DAFT_HAVE_X86
DAFT_INLINE vbits vbits_from_mask(vm m) { return (vbits)_mm_movemask_ps((__m128)m); }
DAFT_INLINE vf vf_min(vf a, vf b) { return (vf)_mm_min_ps((__m128)a, (__m128)b); }
DAFT_INLINE vf vf_max(vf a, vf b) { return (vf)_mm_max_ps((__m128)a, (__m128)b); }
DAFT_INLINE vf vf_sqrt(vf a) { return (vf)_mm_sqrt_ps((__m128)a); }
DAFT_INLINE vi vi_convert_to(vf a) { return (vi)_mm_cvttps_epi32((__m128)a); }
DAFT_INLINE vf vf_convert_to(vi a) { return (vf)_mm_cvtepi32_ps((__m128i)a); }
#else
DAFT_INLINE vbits vbits_from_mask(vm m) { return (vbits)((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8)); }
DAFT_INLINE vf vf_min(vf a, vf b) { return vf_if_then_else(vf_lt(a, b), a, b); }
DAFT_INLINE vf vf_max(vf a, vf b) { return vf_if_then_else(vf_lt(b, a), a, b); }
DAFT_INLINE vf vf_sqrt(vf a) { return (vf){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])}; }
DAFT_INLINE vi vi_convert_to(vf a) { return __builtin_convertvector(a, vi); }
DAFT_INLINE vf vf_convert_to(vi a) { return __builtin_convertvector(a, vf); }
#endif
DAFT_INLINE vf vf_gather_index(const float *base, vi i) { return (vf){base[i[0]], base[i[1]], base[i[2]], base[i[3]]}; }
DAFT_INLINE vi vi_gather_index(const void *p, vi i)
{
    const int32_t *base = p;
    return (vi){base[i[0]], base[i[1]], base[i[2]], base[i[3]]};
}
#endif
DAFT_INLINE vi vi_iota(void);
DAFT_INLINE vm vm_from_bits(vbits b)
{
    vi lane = vi_set(1) << vi_iota();
    return (vm)((vi_set((int32_t)b) & lane) == lane);
}
#endif

#pragma GCC diagnostic pop

DAFT_INLINE vi vi_iota(void) { return vi_convert_to(vf_iota()); }
/* Lanes as a block four wide: the lane's column and row. */
DAFT_INLINE vf vf_column(void) { return vf_convert_to(vi_iota() & vi_set(3)); }
DAFT_INLINE vf vf_row(void) { return vf_convert_to(vi_iota() >> 2); }
DAFT_INLINE vf vf_abs(vf a) { return (vf)((vi)a & vi_set(0x7fffffff)); }
/* The larger of the magnitudes; not of NaN. */
DAFT_INLINE vf vf_max_abs(vf a, vf b)
{
#if defined(DAFT_ISA_avx512)
    return (vf)_mm512_range_ps((__m512)a, (__m512)b, 0xb); /* of absolute values, without a sign */
#else
    return vf_max(vf_abs(a), vf_abs(b));
#endif
}
/* a with its sign flipped where the sign bit of s is set */
DAFT_INLINE vf vf_xor(vf a, vi sign) { return (vf)((vi)a ^ sign); }
DAFT_INLINE vf vf_clamp01(vf a) { return vf_min(vf_max(a, vf_set(0)), vf_set(1)); }
/* Largest whole number not above a, for |a| < 2^31. */
DAFT_INLINE vf vf_floor(vf a)
{
    vf whole = vf_convert_to(vi_convert_to(a));
    return vf_if_then_else(vf_lt(a, whole), whole - vf_set(1), whole);
}
/* The lanes of a mask that i < count; count may be over DAFT_VL. */
DAFT_INLINE vbits vbits_first_n(int count) { return count >= DAFT_VL ? DAFT_ALL_LANES : (vbits)((1u << count) - 1); }
/* 1/a but for a part in 2^11, another one on each machine: only for what no result depends on. */
DAFT_INLINE vf vf_approximate_reciprocal(vf a)
{
#if defined(DAFT_ISA_avx512)
    return (vf)_mm512_rcp14_ps((__m512)a);
#elif defined(DAFT_ISA_avx2)
    return (vf)_mm256_rcp_ps((__m256)a);
#elif defined(DAFT_HAVE_X86)
    return (vf)_mm_rcp_ps((__m128)a);
#else
    return 1 / a;
#endif
}
/* The root of a > 0 but for a part in 2^11, another one on each machine; of 0, less and infinity it may be NaN. */
DAFT_INLINE vf vf_approximate_sqrt(vf a)
{
#if defined(DAFT_ISA_avx512)
    return a * (vf)_mm512_rsqrt14_ps((__m512)a);
#elif defined(DAFT_ISA_avx2)
    return a * (vf)_mm256_rsqrt_ps((__m256)a);
#elif defined(DAFT_HAVE_X86)
    return a * (vf)_mm_rsqrt_ps((__m128)a);
#else
    return vf_sqrt(a);
#endif
}
/* DAFT_VL / 4 rows of four floats side by side, from where each begins. */
DAFT_INLINE vf vf_gather_blocks(const float *const row[DAFT_VL / 4])
{
#if defined(DAFT_ISA_avx512)
    __m512 v = _mm512_castps128_ps512(_mm_loadu_ps(row[0]));
    v = _mm512_insertf32x4(v, _mm_loadu_ps(row[1]), 1);
    v = _mm512_insertf32x4(v, _mm_loadu_ps(row[2]), 2);
    return (vf)_mm512_insertf32x4(v, _mm_loadu_ps(row[3]), 3);
#elif defined(DAFT_ISA_avx2)
    return (vf)_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(row[0])), _mm_loadu_ps(row[1]), 1);
#else
    return vf_load(row[0]);
#endif
}
/* Eight floats from each of two places where a register has room for them; from the first, its part of them where not. */
enum { DAFT_EIGHTS = DAFT_VL > 8 ? DAFT_VL / 8 : 1, DAFT_EIGHT_PARTS = DAFT_VL < 8 ? 8 / DAFT_VL : 1 };
DAFT_INLINE vf vf_load_eights(const float *first, const float *second, int part)
{
#if defined(DAFT_ISA_avx512)
    (void)part;
    if (__builtin_constant_p(first == second) && first == second) return (vf)_mm512_broadcast_f32x8(_mm256_loadu_ps(first));
    return (vf)_mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(first)), _mm256_loadu_ps(second), 1);
#else
    (void)second;
    return vf_load(first + part * DAFT_VL);
#endif
}
/* A window of such rows, `stride` floats apart. */
DAFT_INLINE vf vf_load_blocks(const float *p, int stride)
{
    const float *row[DAFT_VL / 4];
    for (int i = 0; i < DAFT_VL / 4; i++) row[i] = p + i * stride;
    return vf_gather_blocks(row);
}
DAFT_INLINE void vf_store_blocks(float *p, int stride, vf v)
{
#if defined(DAFT_ISA_avx512)
    _mm_storeu_ps(p, _mm512_castps512_ps128((__m512)v));
    _mm_storeu_ps(p + stride, _mm512_extractf32x4_ps((__m512)v, 1));
    _mm_storeu_ps(p + 2 * stride, _mm512_extractf32x4_ps((__m512)v, 2));
    _mm_storeu_ps(p + 3 * stride, _mm512_extractf32x4_ps((__m512)v, 3));
#elif defined(DAFT_ISA_avx2)
    _mm_storeu_ps(p, _mm256_castps256_ps128((__m256)v));
    _mm_storeu_ps(p + stride, _mm256_extractf128_ps((__m256)v, 1));
#else
    (void)stride;
    vf_store(p, v);
#endif
}

/* table[index & 15] */
DAFT_INLINE vf vf_table_lookup16(const float table[16], vi index)
{
#if defined(DAFT_ISA_avx512)
    return (vf)_mm512_permutexvar_ps((__m512i)index, (__m512)vf_load(table));
#elif defined(DAFT_ISA_avx2)
    vf low = (vf)_mm256_permutevar8x32_ps((__m256)vf_load(table), (__m256i)index);
    vf high = (vf)_mm256_permutevar8x32_ps((__m256)vf_load(table + 8), (__m256i)index);
    return (vf)_mm256_blendv_ps((__m256)low, (__m256)high, (__m256)(index << 28)); /* by the lanes' sign bits */
#else
    return vf_gather_index(table, index & vi_set(15));
#endif
}

/* table[index & (DAFT_VL - 1)] */
DAFT_INLINE vf vf_table_lookup(const float table[DAFT_VL], vi index)
{
#if defined(DAFT_ISA_avx512)
    return vf_table_lookup16(table, index);
#elif defined(DAFT_ISA_avx2)
    return (vf)_mm256_permutevar8x32_ps((__m256)vf_load(table), (__m256i)index);
#else
    return vf_gather_index(table, index & vi_set(DAFT_VL - 1));
#endif
}

#if defined(DAFT_ISA_avx2)
/* For each mask of eight lanes, the numbers of those in it, a byte each. */
#define DAFT_PLACE(m, i) ((m) >> (i) & 1 ? (uint64_t)(i) << 8 * __builtin_popcount((m) & ((1u << (i)) - 1)) : 0)
#define DAFT_PLACES(m) \
    (DAFT_PLACE(m, 1) | DAFT_PLACE(m, 2) | DAFT_PLACE(m, 3) | DAFT_PLACE(m, 4) | DAFT_PLACE(m, 5) | DAFT_PLACE(m, 6) | DAFT_PLACE(m, 7))
#define DAFT_PLACES4(m) DAFT_PLACES(m), DAFT_PLACES((m) + 1), DAFT_PLACES((m) + 2), DAFT_PLACES((m) + 3)
#define DAFT_PLACES16(m) DAFT_PLACES4(m), DAFT_PLACES4((m) + 4), DAFT_PLACES4((m) + 8), DAFT_PLACES4((m) + 12)
#define DAFT_PLACES64(m) DAFT_PLACES16(m), DAFT_PLACES16((m) + 16), DAFT_PLACES16((m) + 32), DAFT_PLACES16((m) + 48)
static const uint64_t DAFT_LANES_SIDE_BY_SIDE[256] __attribute__((unused)) = {DAFT_PLACES64(0u), DAFT_PLACES64(64u),
                                                                              DAFT_PLACES64(128u), DAFT_PLACES64(192u)};
#endif
/* The lanes of a mask, side by side; up to DAFT_VL numbers from `out` on may be written. */
DAFT_INLINE void vf_compress_store(float *out, vbits lanes, vf v)
{
#if defined(DAFT_ISA_avx512)
    /* Lanes' numbers are compressed, once for all that one mask is used for: a permutation is quicker than a compression. */
    vf_store(out, (vf)_mm512_permutexvar_ps(_mm512_maskz_compress_epi32((__mmask16)lanes, (__m512i)vi_iota()), (__m512)v));
#elif defined(DAFT_ISA_avx2)
    __m256i from = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)DAFT_LANES_SIDE_BY_SIDE[lanes]));
    vf_store(out, (vf)_mm256_permutevar8x32_ps((__m256)v, from));
#else /* without a branch, which would often be guessed wrong */
    float all[DAFT_VL];
    vf_store(all, v);
    for (int i = 0; i < DAFT_VL; i++) *out = all[i], out += lanes >> i & 1;
#endif
}
DAFT_INLINE void vi_compress_store(void *out, vbits lanes, vi v) { vf_compress_store(out, lanes, (vf)v); }
/* The least lane, and the largest; no lane is NaN. Of zeros of both signs either may come out. */
DAFT_INLINE float vf_reduce_min(vf a)
{
#if defined(DAFT_ISA_avx512)
    return _mm512_reduce_min_ps((__m512)a);
#elif defined(DAFT_ISA_avx2)
    __m128 b = _mm_min_ps(_mm256_castps256_ps128((__m256)a), _mm256_extractf128_ps((__m256)a, 1));
    b = _mm_min_ps(b, _mm_movehl_ps(b, b));
    return _mm_cvtss_f32(_mm_min_ss(b, _mm_movehdup_ps(b)));
#else
    float lane[DAFT_VL];
    vf_store(lane, a);
    for (int half = DAFT_VL / 2; half; half /= 2)
        for (int i = 0; i < half; i++) lane[i] = lane[i + half] < lane[i] ? lane[i + half] : lane[i];
    return lane[0];
#endif
}
DAFT_INLINE float vf_reduce_max(vf a) { return -vf_reduce_min(-a); }

typedef struct vf3 {
    vf x, y, z;
} vf3;
DAFT_INLINE vf vf3_dot(vf3 a, vf3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/* ---- double lanes: half as many; two make up all of a vf's ---- */

typedef double vd __attribute__((vector_size(DAFT_VL * 4)));
#if defined(DAFT_ISA_avx512)
DAFT_INLINE vd vd_promote_half(vf a, int half)
{
    return (vd)_mm512_cvtps_pd(half ? _mm512_extractf32x8_ps((__m512)a, 1) : _mm512_castps512_ps256((__m512)a));
}
DAFT_INLINE vf vf_demote2(vd low, vd high)
{
    return (vf)_mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps((__m512d)low)), _mm512_cvtpd_ps((__m512d)high), 1);
}
DAFT_INLINE vd vd_sqrt(vd a) { return (vd)_mm512_sqrt_pd((__m512d)a); }
#elif defined(DAFT_ISA_avx2)
DAFT_INLINE vd vd_promote_half(vf a, int half)
{
    return (vd)_mm256_cvtps_pd(half ? _mm256_extractf128_ps((__m256)a, 1) : _mm256_castps256_ps128((__m256)a));
}
DAFT_INLINE vf vf_demote2(vd low, vd high)
{
    return (vf)_mm256_set_m128(_mm256_cvtpd_ps((__m256d)high), _mm256_cvtpd_ps((__m256d)low));
}
DAFT_INLINE vd vd_sqrt(vd a) { return (vd)_mm256_sqrt_pd((__m256d)a); }
#elif defined(DAFT_HAVE_X86)
DAFT_INLINE vd vd_promote_half(vf a, int half) { return (vd)_mm_cvtps_pd(half ? _mm_movehl_ps((__m128)a, (__m128)a) : (__m128)a); }
DAFT_INLINE vf vf_demote2(vd low, vd high)
{
    return (vf)_mm_movelh_ps(_mm_cvtpd_ps((__m128d)low), _mm_cvtpd_ps((__m128d)high));
}
DAFT_INLINE vd vd_sqrt(vd a) { return (vd)_mm_sqrt_pd((__m128d)a); }
#else
DAFT_INLINE vd vd_promote_half(vf a, int half) { return half ? (vd){(double)a[2], (double)a[3]} : (vd){(double)a[0], (double)a[1]}; }
DAFT_INLINE vf vf_demote2(vd low, vd high) { return (vf){(float)low[0], (float)low[1], (float)high[0], (float)high[1]}; }
DAFT_INLINE vd vd_sqrt(vd a) { return (vd){sqrt(a[0]), sqrt(a[1])}; }
#endif
typedef double vd_unaligned __attribute__((vector_size(DAFT_VL * 4), aligned(8), may_alias));
DAFT_INLINE vd vd_load(const double *p) { return *(const vd_unaligned *)p; }
DAFT_INLINE vd vd_set(double s) { return (vd){0} + s; }
/* The second where they are equal or one is NaN. */
DAFT_INLINE vd vd_max(vd a, vd b)
{
#if defined(DAFT_ISA_avx512)
    return (vd)_mm512_max_pd((__m512d)a, (__m512d)b);
#elif defined(DAFT_ISA_avx2)
    return (vd)_mm256_max_pd((__m256d)a, (__m256d)b);
#elif defined(DAFT_HAVE_X86)
    return (vd)_mm_max_pd((__m128d)a, (__m128d)b);
#else
    return (vd){a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]};
#endif
}
DAFT_INLINE vd vd_abs(vd a)
{
    typedef int64_t vl __attribute__((vector_size(DAFT_VL * 4)));
    return (vd)((vl)a & ((vl){0} + INT64_MAX));
}
/* 1 where a > 0, else 0. */
DAFT_INLINE vd vd_step(vd a)
{
    typedef int64_t vl __attribute__((vector_size(DAFT_VL * 4)));
    const vd none = {0};
    return (vd)((vl)(a > none) & (vl)(none + 1));
}

/* ---- rows of eight floats, gathered into lanes and back ---- */

#ifdef DAFT_HAVE_X86
/* Transposes the 4×4 floats that stand in each 128 bits of r. */
DAFT_INLINE void vf_transpose4(vf r[4])
{
#if defined(DAFT_ISA_avx512)
#define DAFT_UNPACK(which, a, b) _mm512_unpack##which##_ps((__m512)(a), (__m512)(b))
#define DAFT_SHUFFLE(a, b, k)    (vf)_mm512_shuffle_ps(a, b, k)
    typedef __m512 wide;
#elif defined(DAFT_ISA_avx2)
#define DAFT_UNPACK(which, a, b) _mm256_unpack##which##_ps((__m256)(a), (__m256)(b))
#define DAFT_SHUFFLE(a, b, k)    (vf)_mm256_shuffle_ps(a, b, k)
    typedef __m256 wide;
#else
#define DAFT_UNPACK(which, a, b) _mm_unpack##which##_ps((__m128)(a), (__m128)(b))
#define DAFT_SHUFFLE(a, b, k)    (vf)_mm_shuffle_ps(a, b, k)
    typedef __m128 wide;
#endif
    wide low01 = DAFT_UNPACK(lo, r[0], r[1]), high01 = DAFT_UNPACK(hi, r[0], r[1]);
    wide low23 = DAFT_UNPACK(lo, r[2], r[3]), high23 = DAFT_UNPACK(hi, r[2], r[3]);
    r[0] = DAFT_SHUFFLE(low01, low23, 0x44);
    r[1] = DAFT_SHUFFLE(low01, low23, 0xee);
    r[2] = DAFT_SHUFFLE(high01, high23, 0x44);
    r[3] = DAFT_SHUFFLE(high01, high23, 0xee);
#undef DAFT_UNPACK
#undef DAFT_SHUFFLE
}
#endif

#if defined(DAFT_ISA_avx512)
/* Two rows of eight floats, as they stand in memory. */
DAFT_INLINE __m512 vf_load_eight_pair(const float *first, const float *second)
{
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(first)), _mm256_loadu_ps(second), 1);
}
#endif

/* out[k]: float k of the rows base + 8·row[lane]. Rows are 16-byte aligned. */
DAFT_INLINE void vf_gather_rows8(const float *base, const int32_t *row, vf out[8])
{
#if defined(DAFT_ISA_avx512)
    for (int i = 0; i < 4; i++) {
        __m512 low = vf_load_eight_pair(base + 8 * row[i], base + 8 * row[4 + i]);
        __m512 high = vf_load_eight_pair(base + 8 * row[8 + i], base + 8 * row[12 + i]);
        out[i] = (vf)_mm512_shuffle_f32x4(low, high, 0x88);
        out[4 + i] = (vf)_mm512_shuffle_f32x4(low, high, 0xdd);
    }
    vf_transpose4(out);
    vf_transpose4(out + 4);
#elif defined(DAFT_HAVE_X86)
    for (int half = 0; half < 2; half++) {
        for (int i = 0; i < 4; i++) {
            const float *from = base + 4 * half;
#if defined(DAFT_ISA_avx2)
            __m256 wide = _mm256_castps128_ps256(_mm_load_ps(from + 8 * row[i]));
            out[4 * half + i] = (vf)_mm256_insertf128_ps(wide, _mm_load_ps(from + 8 * row[4 + i]), 1);
#else
            out[4 * half + i] = (vf)_mm_load_ps(from + 8 * row[i]);
#endif
        }
        vf_transpose4(out + 4 * half);
    }
#else
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < DAFT_VL; i++) out[k][i] = base[8 * row[i] + k];
#endif
}

/* The way back for all lanes, to rows `stride` floats apart; their places are multiples of 16 bytes. */
DAFT_INLINE void vf_store_interleaved8(float *base, int stride, const vf in[8])
{
#ifdef DAFT_HAVE_X86
    for (int half = 0; half < 2; half++) {
        vf r[4] = {in[4 * half], in[4 * half + 1], in[4 * half + 2], in[4 * half + 3]};
        vf_transpose4(r);
        for (int k = 0; k < 4; k++) {
            float *to = base + k * stride + 4 * half;
#if defined(DAFT_ISA_avx512)
            _mm_store_ps(to, _mm512_castps512_ps128((__m512)r[k]));
            _mm_store_ps(to + 4 * stride, _mm512_extractf32x4_ps((__m512)r[k], 1));
            _mm_store_ps(to + 8 * stride, _mm512_extractf32x4_ps((__m512)r[k], 2));
            _mm_store_ps(to + 12 * stride, _mm512_extractf32x4_ps((__m512)r[k], 3));
#elif defined(DAFT_ISA_avx2)
            _mm_store_ps(to, _mm256_castps256_ps128((__m256)r[k]));
            _mm_store_ps(to + 4 * stride, _mm256_extractf128_ps((__m256)r[k], 1));
#else
            _mm_store_ps(to, (__m128)r[k]);
#endif
        }
    }
#else
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < DAFT_VL; i++) base[stride * i + k] = in[k][i];
#endif
}

#if defined(DAFT_ISA_avx512)
/* The way back, for the lanes given; their rows differ. */
DAFT_INLINE void vf_scatter_rows8(float *base, const int32_t *row, const vf in[8], vbits lanes)
{
    vf low[4] = {in[0], in[1], in[2], in[3]}, high[4] = {in[4], in[5], in[6], in[7]};
    float pair[8][DAFT_VL] __attribute__((aligned(64)));
    bool all = (lanes & DAFT_ALL_LANES) == DAFT_ALL_LANES;
    vf_transpose4(low);
    vf_transpose4(high);
    for (int i = 0; i < 4; i++) { /* the first, third, and so on, of the fours that belong to rows i, 4 + i, 8 + i, 12 + i */
        const __m512i order = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
        const __m512i then = _mm512_setr_epi32(8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
        __m512 first = _mm512_permutex2var_ps((__m512)low[i], order, (__m512)high[i]);
        __m512 second = _mm512_permutex2var_ps((__m512)low[i], then, (__m512)high[i]);
        if (all) {
            _mm256_storeu_ps(base + 8 * row[i], _mm512_castps512_ps256(first));
            _mm256_storeu_ps(base + 8 * row[4 + i], _mm512_extractf32x8_ps(first, 1));
            _mm256_storeu_ps(base + 8 * row[8 + i], _mm512_castps512_ps256(second));
            _mm256_storeu_ps(base + 8 * row[12 + i], _mm512_extractf32x8_ps(second, 1));
        } else {
            _mm512_store_ps(pair[i], first);
            _mm512_store_ps(pair[4 + i], second);
        }
    }
    for (vbits left = all ? 0 : lanes & DAFT_ALL_LANES; left; left &= left - 1) {
        int i = __builtin_ctz(left);
        _mm256_storeu_ps(base + 8 * row[i], _mm256_load_ps(&pair[(i & 3) + (i >> 3) * 4][(i & 4) * 2]));
    }
}
#else
#ifdef DAFT_HAVE_X86
/* The fours of r go to base + 8·row[0], base + 8·row[4] and so on. */
DAFT_INLINE void vf_store_fours(float *base, const int32_t *row, vf r)
{
#if defined(DAFT_ISA_avx2)
    _mm_store_ps(base + 8 * row[0], _mm256_castps256_ps128((__m256)r));
    _mm_store_ps(base + 8 * row[4], _mm256_extractf128_ps((__m256)r, 1));
#else
    _mm_store_ps(base + 8 * row[0], (__m128)r);
#endif
}
#endif

/* The way back, for the lanes given; their rows differ. */
DAFT_INLINE void vf_scatter_rows8(float *base, const int32_t *row, const vf in[8], vbits lanes)
{
    for (int half = 0; half < 2; half++) {
        float square[4][DAFT_VL] __attribute__((aligned(64)));
        vf r[4] = {in[4 * half], in[4 * half + 1], in[4 * half + 2], in[4 * half + 3]};
        float *to = base + 4 * half;
#ifdef DAFT_HAVE_X86
        vf_transpose4(r);
        if ((lanes & DAFT_ALL_LANES) == DAFT_ALL_LANES) {
            for (int k = 0; k < 4; k++) vf_store_fours(to, row + k, r[k]);
            continue;
        }
        for (int k = 0; k < 4; k++) vf_store(square[k], r[k]);
        for (int i = 0; i < DAFT_VL; i++)
            if (lanes >> i & 1) _mm_store_ps(to + 8 * row[i], _mm_load_ps(&square[i & 3][i & ~3]));
#else
        for (int k = 0; k < 4; k++) vf_store(square[k], r[k]);
        for (int i = 0; i < DAFT_VL; i++)
            for (int k = 0; k < 4; k++)
                if (lanes >> i & 1) to[8 * row[i] + k] = square[k][i];
#endif
    }
}
#endif

/* The four floats at p, then those at p + at[0] and so on, `count` fours in all, no more than DAFT_VL / 4; zero in the
 * other lanes. */
DAFT_INLINE vf vf_load_blocks_at(const float *p, const size_t at[3], int count)
{
#if defined(DAFT_ISA_avx512)
    __m512 v = _mm512_zextps128_ps512(_mm_loadu_ps(p));
    if (count > 1) v = _mm512_insertf32x4(v, _mm_loadu_ps(p + at[0]), 1);
    if (count > 2) v = _mm512_insertf32x4(v, _mm_loadu_ps(p + at[1]), 2);
    if (count > 3) v = _mm512_insertf32x4(v, _mm_loadu_ps(p + at[2]), 3);
    return (vf)v;
#elif defined(DAFT_ISA_avx2)
    __m256 v = _mm256_zextps128_ps256(_mm_loadu_ps(p));
    return (vf)(count > 1 ? _mm256_insertf128_ps(v, _mm_loadu_ps(p + at[0]), 1) : v);
#else
    (void)at, (void)count;
    return vf_load(p);
#endif
}

/* The same of eight floats from each place: the first fours in one register, the second in the other. */
DAFT_INLINE void vf_load_block_pairs_at(const float *p, const size_t at[3], vf *first, vf *second)
{
#if defined(DAFT_ISA_avx512)
    __m512 low = _mm512_castps256_ps512(_mm256_loadu_ps(p)), high = _mm512_castps256_ps512(_mm256_loadu_ps(p + at[1]));
    low = _mm512_insertf32x8(low, _mm256_loadu_ps(p + at[0]), 1), high = _mm512_insertf32x8(high, _mm256_loadu_ps(p + at[2]), 1);
    *first = (vf)_mm512_shuffle_f32x4(low, high, 0x88), *second = (vf)_mm512_shuffle_f32x4(low, high, 0xdd);
#elif defined(DAFT_ISA_avx2)
    __m256 low = _mm256_loadu_ps(p), high = _mm256_loadu_ps(p + at[0]);
    *first = (vf)_mm256_permute2f128_ps(low, high, 0x20), *second = (vf)_mm256_permute2f128_ps(low, high, 0x31);
#else
    (void)at;
    *first = vf_load(p), *second = vf_load(p + 4);
#endif
}

/* ---- 8 lanes ---- */

typedef float v8 __attribute__((vector_size(32)));
typedef int32_t v8i __attribute__((vector_size(32)));
typedef float v8_unaligned __attribute__((vector_size(32), aligned(4), may_alias));

DAFT_INLINE v8 v8_load(const float *p) { return *(const v8_unaligned *)p; }
DAFT_INLINE void v8_store(float *p, v8 v) { *(v8_unaligned *)p = v; }
#if defined(DAFT_ISA_avx2) || defined(DAFT_ISA_avx512)
DAFT_INLINE v8 v8_set(float s) { return (v8)_mm256_set1_ps(s); }
DAFT_INLINE v8 v8_min(v8 a, v8 b) { return (v8)_mm256_min_ps((__m256)a, (__m256)b); }
DAFT_INLINE v8 v8_max(v8 a, v8 b) { return (v8)_mm256_max_ps((__m256)a, (__m256)b); }
DAFT_INLINE uint32_t v8_le_bits(v8 a, v8 b)
{
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_LE_OQ));
}
#else
DAFT_INLINE v8 v8_set(float s) { return (v8){s, s, s, s, s, s, s, s}; }
#ifdef DAFT_HAVE_X86
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
#else
DAFT_INLINE v8 v8_min(v8 a, v8 b) { return (v8)(((v8i)a & (a < b)) | ((v8i)b & ~(a < b))); }
DAFT_INLINE v8 v8_max(v8 a, v8 b) { return (v8)(((v8i)a & (a > b)) | ((v8i)b & ~(a > b))); }
DAFT_INLINE uint32_t v8_le_bits(v8 a, v8 b)
{
    uint32_t bits = 0;
    for (int i = 0; i < 8; i++) bits |= (uint32_t)(a[i] <= b[i]) << i;
    return bits;
}
#endif
#endif

DAFT_INLINE uint32_t v8_eq_bits(v8 a, v8 b)
{
#if defined(DAFT_ISA_avx2) || defined(DAFT_ISA_avx512)
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_EQ_OQ));
#else
    return v8_le_bits(a, b) & v8_le_bits(b, a);
#endif
}

/* The numbers of the bits that are set, from `first` on, side by side; up to eight are written. Gives how many they are. */
DAFT_INLINE uint32_t v8i_store_set_bits(uint32_t *out, uint32_t bits, int32_t first)
{
    const v8i number = {first, first + 1, first + 2, first + 3, first + 4, first + 5, first + 6, first + 7};
#if defined(DAFT_ISA_avx512)
    _mm256_storeu_si256((__m256i *)out, _mm256_maskz_compress_epi32((__mmask8)bits, (__m256i)number));
#else
    uint32_t *to = out;
    for (uint32_t left = bits; left; left &= left - 1) *to++ = (uint32_t)number[__builtin_ctz(left)];
#endif
    return (uint32_t)__builtin_popcount(bits);
}
/* One bit for each lane of a comparison. */
DAFT_INLINE uint32_t v8_bits_from_mask(v8i mask) { return v8_le_bits((v8)(mask & 0x3f800000), v8_set(0)) ^ 0xff; }

/* ---- 4 lanes ---- */

typedef float v4 __attribute__((vector_size(16)));
typedef int32_t v4i __attribute__((vector_size(16)));

DAFT_INLINE v4 v4_set(float s) { return (v4){s, s, s, s}; }
DAFT_INLINE v4 v4_load(const float *p)
{
    v4 v;
    memcpy(&v, p, sizeof v);
    return v;
}
DAFT_INLINE v4 v4_if_then_else(v4i m, v4 a, v4 b) { return (v4)((m & (v4i)a) | (~m & (v4i)b)); }
DAFT_INLINE v4 v4_abs(v4 a) { return (v4)((v4i)a & (v4i){0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff}); }
#ifdef DAFT_HAVE_X86
DAFT_INLINE uint32_t v4_bits_from_mask(v4i m) { return (uint32_t)_mm_movemask_ps((__m128)m); }
DAFT_INLINE v4 v4_min(v4 a, v4 b) { return (v4)_mm_min_ps((__m128)a, (__m128)b); }
DAFT_INLINE v4 v4_max(v4 a, v4 b) { return (v4)_mm_max_ps((__m128)a, (__m128)b); }
DAFT_INLINE v4 v4_sqrt(v4 a) { return (v4)_mm_sqrt_ps((__m128)a); }
#else
DAFT_INLINE v4 v4_sqrt(v4 a) { return (v4){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])}; }
DAFT_INLINE v4 v4_min(v4 a, v4 b) { return v4_if_then_else(a < b, a, b); }
DAFT_INLINE v4 v4_max(v4 a, v4 b) { return v4_if_then_else(a > b, a, b); }
DAFT_INLINE uint32_t v4_bits_from_mask(v4i m) { return (uint32_t)((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8)); }
#endif

/* Lanes 0 to 2 of three vectors by lane: x has the three lanes 0. Lane 3 means nothing. */
#ifdef DAFT_HAVE_X86
DAFT_INLINE void v4_transpose3(v4 a, v4 b, v4 c, v4 *x, v4 *y, v4 *z)
{
    __m128 low = _mm_unpacklo_ps((__m128)a, (__m128)b), high = _mm_unpackhi_ps((__m128)a, (__m128)b);
    *x = (v4)_mm_movelh_ps(low, (__m128)c);
    *y = (v4)_mm_shuffle_ps(low, (__m128)c, _MM_SHUFFLE(1, 1, 3, 2));
    *z = (v4)_mm_shuffle_ps(high, (__m128)c, _MM_SHUFFLE(2, 2, 1, 0));
}
#else
DAFT_INLINE void v4_transpose3(v4 a, v4 b, v4 c, v4 *x, v4 *y, v4 *z)
{
    *x = (v4){a[0], b[0], c[0], 0}, *y = (v4){a[1], b[1], c[1], 0}, *z = (v4){a[2], b[2], c[2], 0};
}
#endif

/* The least lane of each of four, none of them NaN. */
DAFT_INLINE v4 v4_reduce_min4(vf a, vf b, vf c, vf d)
{
#ifdef DAFT_HAVE_X86
    vf r[4] = {a, b, c, d};
    vf_transpose4(r);
    vf least = vf_min(vf_min(r[0], r[1]), vf_min(r[2], r[3]));
    float each[DAFT_VL] __attribute__((aligned(4 * DAFT_VL)));
    vf_store(each, least);
    v4 all = v4_load(each);
    for (int i = 4; i < DAFT_VL; i += 4) all = v4_min(all, v4_load(each + i));
    return all;
#else
    return (v4){vf_reduce_min(a), vf_reduce_min(b), vf_reduce_min(c), vf_reduce_min(d)};
#endif
}

/* ---- eight lanes as two times four ---- */

#if defined(DAFT_ISA_avx2) || defined(DAFT_ISA_avx512)
DAFT_INLINE v4 v8_lower_half(v8 a) { return (v4)_mm256_castps256_ps128((__m256)a); }
DAFT_INLINE v4 v8_upper_half(v8 a) { return (v4)_mm256_extractf128_ps((__m256)a, 1); }
DAFT_INLINE v8 v8_combine(v4 high, v4 low) { return (v8)_mm256_set_m128((__m128)high, (__m128)low); }
#else
typedef union v8_pair {
    v8 whole;
    v4 half[2];
} v8_pair;
DAFT_INLINE v4 v8_lower_half(v8 a) { return ((v8_pair){a}).half[0]; }
DAFT_INLINE v4 v8_upper_half(v8 a) { return ((v8_pair){a}).half[1]; }
DAFT_INLINE v8 v8_combine(v4 high, v4 low) { return ((v8_pair){.half = {low, high}}).whole; }
#endif

/* ---- text ---- */

/* Bit i: p[i] is no decimal digit. Of 16, 32 and 64 bytes. */
DAFT_INLINE uint32_t vu8_nondigits_16(const char *p)
{
#ifdef DAFT_HAVE_X86 /* '0' to '9' become 118 to 127, the largest of signed bytes */
    __m128i moved = _mm_add_epi8(_mm_loadu_si128((const __m128i *)(const void *)p), _mm_set1_epi8(127 - '9'));
    return (uint32_t)_mm_movemask_epi8(_mm_cmplt_epi8(moved, _mm_set1_epi8(118)));
#else
    uint32_t bits = 0;
    for (int i = 0; i < 16; i++) bits |= (uint32_t)((unsigned)(p[i] - '0') > 9) << i;
    return bits;
#endif
}
DAFT_INLINE uint32_t vu8_nondigits_32(const char *p)
{
    return vu8_nondigits_16(p) | vu8_nondigits_16(p + 16) << 16;
}
DAFT_INLINE uint64_t vu8_nondigits_64(const char *p)
{
    return vu8_nondigits_32(p) | (uint64_t)vu8_nondigits_32(p + 32) << 32;
}

#include "math/simd/pick.h"

#endif
