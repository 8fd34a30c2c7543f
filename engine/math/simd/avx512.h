/* The operations of ops.h on AVX-512 (F, DQ, VL, BW): sixteen lanes, masks of lanes as bits. */
#ifndef DAFT_AVX512_H
#define DAFT_AVX512_H

#include "math/simd/avx2.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion" /* in gcc's own macros for gathers, which -O0 shows */

#define DAFT_NATIVE_SELECT
DAFT_INLINE vf vf_set(float s) { return (vf)_mm512_set1_ps(s); }
DAFT_INLINE vi vi_set(int32_t s) { return (vi)_mm512_set1_epi32(s); }
DAFT_INLINE vf vf_if_then_else(vm m, vf a, vf b) { return (vf)_mm512_mask_blend_ps(m, (__m512)b, (__m512)a); }
DAFT_INLINE vi vi_if_then_else(vm m, vi a, vi b) { return (vi)_mm512_mask_blend_epi32(m, (__m512i)b, (__m512i)a); }

#define DAFT_NATIVE_MASKS
DAFT_INLINE vm vf_lt(vf a, vf b) { return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ); }
DAFT_INLINE vm vf_le(vf a, vf b) { return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ); }
DAFT_INLINE vm vi_eq(vi a, vi b) { return _mm512_cmpeq_epi32_mask((__m512i)a, (__m512i)b); }
DAFT_INLINE vm vi_lt(vi a, vi b) { return _mm512_cmplt_epi32_mask((__m512i)a, (__m512i)b); }
DAFT_INLINE vm vm_and(vm a, vm b) { return (vm)(a & b); }
DAFT_INLINE vm vm_or(vm a, vm b) { return (vm)(a | b); }
DAFT_INLINE vm vm_not(vm a) { return (vm)~a; }
DAFT_INLINE vm vm_from_bits(vbits b) { return (vm)b; }

#define DAFT_NATIVE_ARITHMETIC
DAFT_INLINE vbits vbits_from_mask(vm m) { return m; }
DAFT_INLINE vf vf_min(vf a, vf b) { return (vf)_mm512_min_ps((__m512)a, (__m512)b); }
DAFT_INLINE vf vf_max(vf a, vf b) { return (vf)_mm512_max_ps((__m512)a, (__m512)b); }
DAFT_INLINE vf vf_sqrt(vf a) { return (vf)_mm512_sqrt_ps((__m512)a); }
DAFT_INLINE float vf_reduce_min(vf a) { return _mm512_reduce_min_ps((__m512)a) + 0; }
DAFT_INLINE vi vi_convert_to(vf a) { return (vi)_mm512_cvttps_epi32((__m512)a); }
DAFT_INLINE vf vf_convert_to(vi a) { return (vf)_mm512_cvtepi32_ps((__m512i)a); }
DAFT_INLINE vf vf_approximate_reciprocal(vf a) { return (vf)_mm512_rcp14_ps((__m512)a); }

#define DAFT_NATIVE_DOUBLE
DAFT_INLINE vd vd_promote_half(vf a, int half)
{
    return (vd)_mm512_cvtps_pd(half ? _mm512_extractf32x8_ps((__m512)a, 1) : _mm512_castps512_ps256((__m512)a));
}
DAFT_INLINE vf vf_demote2(vd low, vd high)
{
    return (vf)_mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps((__m512d)low)), _mm512_cvtpd_ps((__m512d)high),
                                  1);
}
DAFT_INLINE vd vd_sqrt(vd a) { return (vd)_mm512_sqrt_pd((__m512d)a); }
DAFT_INLINE vd vd_max(vd a, vd b) { return (vd)_mm512_max_pd((__m512d)a, (__m512d)b); }

#define DAFT_NATIVE_GATHER
DAFT_INLINE vf vf_gather_index(const float *base, vi index) { return (vf)_mm512_i32gather_ps((__m512i)index, base, 4); }
DAFT_INLINE vi vi_gather_index(const void *base, vi index)
{
    return (vi)_mm512_i32gather_epi32((__m512i)index, base, 4);
}
/* By pairs, which halves the loads. In each block of four lanes `low` has lanes 0 and 1, `high` 2 and 3. */
DAFT_INLINE void vi_gather_pairs(const void *base, const int32_t *index, vi *first, vi *second)
{
    const int32_t *const from = base;
    __m512 low = _mm512_castps128_ps512(v4_load_pairs(from + index[0], from + index[1])),
           high = _mm512_castps128_ps512(v4_load_pairs(from + index[2], from + index[3]));
    low = _mm512_insertf32x4(low, v4_load_pairs(from + index[4], from + index[5]), 1);
    high = _mm512_insertf32x4(high, v4_load_pairs(from + index[6], from + index[7]), 1);
    low = _mm512_insertf32x4(low, v4_load_pairs(from + index[8], from + index[9]), 2);
    high = _mm512_insertf32x4(high, v4_load_pairs(from + index[10], from + index[11]), 2);
    low = _mm512_insertf32x4(low, v4_load_pairs(from + index[12], from + index[13]), 3);
    high = _mm512_insertf32x4(high, v4_load_pairs(from + index[14], from + index[15]), 3);
    *first = (vi)_mm512_shuffle_ps(low, high, 0x88), *second = (vi)_mm512_shuffle_ps(low, high, 0xdd);
}
/* Of 32 bytes, one in each 16 bits, which may have another above it. */
DAFT_INLINE __m512i v32_table_lookup256(const uint16_t table[256], __m512i index)
{
    const __mmask32 bit6 = _mm512_test_epi16_mask(index, _mm512_set1_epi16(64)),
                    bit7 = _mm512_test_epi16_mask(index, _mm512_set1_epi16(128));
    __m512i part[4];
    for (int i = 0; i < 4; i++)
        part[i] = _mm512_permutex2var_epi16(_mm512_loadu_si512(table + 64 * i), index,
                                            _mm512_loadu_si512(table + 64 * i + 32));
    return _mm512_mask_blend_epi16(bit7, _mm512_mask_blend_epi16(bit6, part[0], part[1]),
                                   _mm512_mask_blend_epi16(bit6, part[2], part[3]));
}
/* The second bytes of both words share one look-up. */
DAFT_INLINE void vf_table_lookup_bytes(const uint16_t table[257], const vi words[2], vf first[3], vf second[3])
{
    const __m512i a = (__m512i)words[0], b = (__m512i)words[1], low = _mm512_set1_epi32(0xffff);
    const __m512i outer[2] = {v32_table_lookup256(table, a), v32_table_lookup256(table, b)};
    const __m512i inner = v32_table_lookup256(
        table, _mm512_mask_blend_epi16(0xaaaaaaaa, _mm512_srli_epi32(a, 8), _mm512_slli_epi32(b, 8)));
    first[0] = vf_convert_to((vi)_mm512_and_si512(outer[0], low));
    first[1] = vf_convert_to((vi)_mm512_and_si512(inner, low));
    first[2] = vf_convert_to((vi)_mm512_srli_epi32(outer[0], 16));
    second[0] = vf_convert_to((vi)_mm512_and_si512(outer[1], low));
    second[1] = vf_convert_to((vi)_mm512_srli_epi32(inner, 16));
    second[2] = vf_convert_to((vi)_mm512_srli_epi32(outer[1], 16));
}
DAFT_INLINE vf vf_table_lookup16(const float table[16], vi index)
{
    return (vf)_mm512_permutexvar_ps((__m512i)index, _mm512_loadu_ps(table));
}
DAFT_INLINE vf vf_table_lookup(const float table[DAFT_VL], vi index) { return vf_table_lookup16(table, index); }
DAFT_INLINE vf vf_table_lookup32(const float table[32], vi index)
{
    return (vf)_mm512_permutex2var_ps(_mm512_loadu_ps(table), (__m512i)index, _mm512_loadu_ps(table + 16));
}
/* Lanes' numbers are compressed, once for all that one mask is used for: a permutation is quicker than a compression.
 */
DAFT_INLINE void vf_compress_store(float *out, vbits lanes, vf v)
{
    const __m512i number = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    _mm512_storeu_ps(out, _mm512_permutexvar_ps(_mm512_maskz_compress_epi32((__mmask16)lanes, number), (__m512)v));
}
DAFT_INLINE vf vf_load_expand(const float *p, vbits lanes)
{
    return (vf)_mm512_maskz_expand_ps((__mmask16)lanes, _mm512_loadu_ps(p));
}

#define DAFT_NATIVE_BLOCKS
DAFT_INLINE vf vf_gather_blocks(const float *const from[DAFT_VL / 4])
{
    __m512 v = _mm512_castps128_ps512(_mm_loadu_ps(from[0]));
    v = _mm512_insertf32x4(v, _mm_loadu_ps(from[1]), 1);
    v = _mm512_insertf32x4(v, _mm_loadu_ps(from[2]), 2);
    return (vf)_mm512_insertf32x4(v, _mm_loadu_ps(from[3]), 3);
}
DAFT_INLINE void vf_scatter_blocks(float *const to[DAFT_VL / 4], vf v)
{
    _mm_store_ps(to[0], _mm512_castps512_ps128((__m512)v));
    _mm_store_ps(to[1], _mm512_extractf32x4_ps((__m512)v, 1));
    _mm_store_ps(to[2], _mm512_extractf32x4_ps((__m512)v, 2));
    _mm_store_ps(to[3], _mm512_extractf32x4_ps((__m512)v, 3));
}
DAFT_INLINE void vf_store_blocks(float *p, int stride, vf v)
{
    _mm_storeu_ps(p, _mm512_castps512_ps128((__m512)v));
    _mm_storeu_ps(p + stride, _mm512_extractf32x4_ps((__m512)v, 1));
    _mm_storeu_ps(p + 2 * stride, _mm512_extractf32x4_ps((__m512)v, 2));
    _mm_storeu_ps(p + 3 * stride, _mm512_extractf32x4_ps((__m512)v, 3));
}
DAFT_INLINE __m512 vf_load_two_eights(const float *first, const float *second)
{
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(first)), _mm256_loadu_ps(second), 1);
}
DAFT_INLINE vf vf_load_eights(const float *first, const float *second, int part)
{
    (void)part;
    if (__builtin_constant_p(first == second) && first == second)
        return (vf)_mm512_broadcast_f32x8(_mm256_loadu_ps(first));
    return (vf)vf_load_two_eights(first, second);
}

#define DAFT_NATIVE_TRANSPOSE
DAFT_INLINE void vf_transpose4(vf r[4])
{
    __m512 low01 = _mm512_unpacklo_ps((__m512)r[0], (__m512)r[1]),
           high01 = _mm512_unpackhi_ps((__m512)r[0], (__m512)r[1]);
    __m512 low23 = _mm512_unpacklo_ps((__m512)r[2], (__m512)r[3]),
           high23 = _mm512_unpackhi_ps((__m512)r[2], (__m512)r[3]);
    r[0] = (vf)_mm512_shuffle_ps(low01, low23, 0x44), r[1] = (vf)_mm512_shuffle_ps(low01, low23, 0xee);
    r[2] = (vf)_mm512_shuffle_ps(high01, high23, 0x44), r[3] = (vf)_mm512_shuffle_ps(high01, high23, 0xee);
}

/* Rows as whole 32 bytes: half as many loads and stores as by blocks. */
#define DAFT_NATIVE_ROWS
DAFT_INLINE void vf_gather_rows8(const float *base, const int32_t *row, vf out[8])
{
    for (int i = 0; i < 4; i++) {
        __m512 low = vf_load_two_eights(base + 8 * row[i], base + 8 * row[4 + i]);
        __m512 high = vf_load_two_eights(base + 8 * row[8 + i], base + 8 * row[12 + i]);
        out[i] = (vf)_mm512_shuffle_f32x4(low, high, 0x88);
        out[4 + i] = (vf)_mm512_shuffle_f32x4(low, high, 0xdd);
    }
    vf_transpose4(out);
    vf_transpose4(out + 4);
}
DAFT_INLINE void vf_scatter_rows8(float *base, const int32_t *row, const vf in[8], vbits lanes)
{
    vf low[4] = {in[0], in[1], in[2], in[3]}, high[4] = {in[4], in[5], in[6], in[7]};
    float pair[8][DAFT_VL] __attribute__((aligned(64)));
    bool all = (lanes & DAFT_ALL_LANES) == DAFT_ALL_LANES;
    vf_transpose4(low);
    vf_transpose4(high);
    for (int i = 0; i < 4; i++) { /* first: rows i and 4 + i; second: rows 8 + i and 12 + i */
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
DAFT_INLINE void vf_load_block_pairs_at(const float *p, const size_t at[3], vf *low, vf *high)
{
    __m512 front = vf_load_two_eights(p, p + at[0]), back = vf_load_two_eights(p + at[1], p + at[2]);
    *low = (vf)_mm512_shuffle_f32x4(front, back, 0x88), *high = (vf)_mm512_shuffle_f32x4(front, back, 0xdd);
}

#define DAFT_NATIVE_SET_BITS
DAFT_INLINE uint32_t v8i_store_set_bits(uint32_t *out, uint32_t bits, int32_t first)
{
    const v8i number = {first, first + 1, first + 2, first + 3, first + 4, first + 5, first + 6, first + 7};
    _mm256_storeu_si256((__m256i *)out, _mm256_maskz_compress_epi32((__mmask8)bits, (__m256i)number));
    return (uint32_t)__builtin_popcount(bits);
}

DAFT_INLINE uint64_t vu8_test_bit(const uint8_t bytes[64], uint32_t count, int k)
{
    (void)count;
    return _mm512_test_epi8_mask(_mm512_loadu_si512(bytes), _mm512_set1_epi8((char)(1 << k)));
}

#pragma GCC diagnostic pop

#endif
