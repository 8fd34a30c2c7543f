/* The operations of ops.h on AVX2: eight lanes; and those of v8 for AVX-512, too. Masks of lanes and rows of eight are
 * plain.h's. */
#ifndef DAFT_AVX2_H
#define DAFT_AVX2_H

#include "math/simd/sse2.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion" /* in gcc's own macros for gathers, which -O0 shows */

#define DAFT_NATIVE_8
DAFT_INLINE v8 v8_min(v8 a, v8 b) { return (v8)_mm256_min_ps((__m256)a, (__m256)b); }
DAFT_INLINE v8 v8_max(v8 a, v8 b) { return (v8)_mm256_max_ps((__m256)a, (__m256)b); }
DAFT_INLINE uint32_t v8_le_bits(v8 a, v8 b)
{
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_LE_OQ));
}

#define DAFT_NATIVE_8_BYTES
DAFT_INLINE v8 v8_promote(const uint8_t p[8])
{
    return (v8)_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)p)));
}
DAFT_INLINE void v8_demote(v8 a, uint8_t p[8])
{ /* as v4_demote; packing goes by halves */
    const __m256 real = _mm256_min_ps(_mm256_max_ps((__m256)a, _mm256_setzero_ps()), _mm256_set1_ps(255));
    const __m256i whole = _mm256_cvttps_epi32(real);
    const __m128i words = _mm_packs_epi32(_mm256_castsi256_si128(whole), _mm256_extracti128_si256(whole, 1));
    _mm_storel_epi64((__m128i *)(void *)p, _mm_packus_epi16(words, words));
}

#define DAFT_NATIVE_8_LANES
DAFT_INLINE v4 v8_lower_half(v8 a) { return (v4)_mm256_castps256_ps128((__m256)a); }
DAFT_INLINE v4 v8_upper_half(v8 a) { return (v4)_mm256_extractf128_ps((__m256)a, 1); }
DAFT_INLINE v8 v8_combine(v4 high, v4 low) { return (v8)_mm256_set_m128((__m128)high, (__m128)low); }
DAFT_INLINE v8i v8i_table_lookup(v8i table, v8i index)
{
    return (v8i)_mm256_permutevar8x32_epi32((__m256i)table, (__m256i)index);
}

#if DAFT_VL == 8

#define DAFT_NATIVE_SELECT
DAFT_INLINE vf vf_set(float s) { return (vf)_mm256_set1_ps(s); }
DAFT_INLINE vi vi_set(int32_t s) { return (vi)_mm256_set1_epi32(s); }
DAFT_INLINE vf vf_if_then_else(vm m, vf a, vf b) { return (vf)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)m); }
DAFT_INLINE vi vi_if_then_else(vm m, vi a, vi b) { return (vi)_mm256_blendv_epi8((__m256i)b, (__m256i)a, (__m256i)m); }

#define DAFT_NATIVE_ARITHMETIC
DAFT_INLINE vbits vbits_from_mask(vm m) { return (vbits)_mm256_movemask_ps((__m256)m); }
DAFT_INLINE vf vf_min(vf a, vf b) { return (vf)_mm256_min_ps((__m256)a, (__m256)b); }
DAFT_INLINE vf vf_max(vf a, vf b) { return (vf)_mm256_max_ps((__m256)a, (__m256)b); }
DAFT_INLINE vf vf_sqrt(vf a) { return (vf)_mm256_sqrt_ps((__m256)a); }
DAFT_INLINE float vf_reduce_min(vf a)
{
    __m128 b = _mm_min_ps(_mm256_castps256_ps128((__m256)a), _mm256_extractf128_ps((__m256)a, 1));
    b = _mm_min_ps(b, _mm_movehl_ps(b, b));
    return _mm_cvtss_f32(_mm_min_ss(b, _mm_movehdup_ps(b))) + 0;
}
DAFT_INLINE vi vi_convert_to(vf a) { return (vi)_mm256_cvttps_epi32((__m256)a); }
DAFT_INLINE vf vf_convert_to(vi a) { return (vf)_mm256_cvtepi32_ps((__m256i)a); }
DAFT_INLINE vf vf_approximate_reciprocal(vf a) { return (vf)_mm256_rcp_ps((__m256)a); }

#define DAFT_NATIVE_DOUBLE
DAFT_INLINE vd vd_promote_half(vf a, int half)
{
    return (vd)_mm256_cvtps_pd(half ? _mm256_extractf128_ps((__m256)a, 1) : _mm256_castps256_ps128((__m256)a));
}
DAFT_INLINE vf vf_demote2(vd low, vd high)
{
    return (vf)_mm256_set_m128(_mm256_cvtpd_ps((__m256d)high), _mm256_cvtpd_ps((__m256d)low));
}
DAFT_INLINE vd vd_sqrt(vd a) { return (vd)_mm256_sqrt_pd((__m256d)a); }
DAFT_INLINE vd vd_max(vd a, vd b) { return (vd)_mm256_max_pd((__m256d)a, (__m256d)b); }

#define DAFT_NATIVE_GATHER
DAFT_INLINE vf vf_gather_index(const float *base, vi index) { return (vf)_mm256_i32gather_ps(base, (__m256i)index, 4); }
DAFT_INLINE vi vi_gather_index(const void *base, vi index)
{
    return (vi)_mm256_i32gather_epi32((const int *)base, (__m256i)index, 4);
}
/* By pairs, which halves the loads. In each block of four lanes `low` has lanes 0 and 1, `high` 2 and 3. */
DAFT_INLINE void vi_gather_pairs(const void *base, const int32_t *index, vi *first, vi *second)
{
    const int32_t *const from = base;
    const __m256 low = _mm256_set_m128(v4_load_pairs(from + index[4], from + index[5]),
                                       v4_load_pairs(from + index[0], from + index[1]));
    const __m256 high = _mm256_set_m128(v4_load_pairs(from + index[6], from + index[7]),
                                        v4_load_pairs(from + index[2], from + index[3]));
    *first = (vi)_mm256_shuffle_ps(low, high, 0x88), *second = (vi)_mm256_shuffle_ps(low, high, 0xdd);
}
DAFT_INLINE void vf_table_lookup_bytes(const uint16_t table[257], const vi words[2], vf first[3], vf second[3])
{
    const vi byte = vi_set(255), half = vi_set(0xffff);
    for (int k = 0; k < 3; k++) {
        const __m256i a = (__m256i)(words[0] >> 8 * k & byte), b = (__m256i)(words[1] >> 8 * k & byte);
        first[k] = vf_convert_to((vi)_mm256_i32gather_epi32((const int *)(const void *)table, a, 2) & half);
        second[k] = vf_convert_to((vi)_mm256_i32gather_epi32((const int *)(const void *)table, b, 2) & half);
    }
}
DAFT_INLINE vf vf_table_lookup(const float table[DAFT_VL], vi index)
{
    return (vf)_mm256_permutevar8x32_ps(_mm256_loadu_ps(table), (__m256i)index);
}
DAFT_INLINE vf vf_table_lookup16(const float table[16], vi index)
{
    __m256 low = _mm256_permutevar8x32_ps(_mm256_loadu_ps(table), (__m256i)index);
    __m256 high = _mm256_permutevar8x32_ps(_mm256_loadu_ps(table + 8), (__m256i)index);
    return (vf)_mm256_blendv_ps(low, high, (__m256)(index << 28)); /* by bit 3, as the sign */
}
DAFT_INLINE vf vf_table_lookup32(const float table[32], vi index)
{
    __m256 low = (__m256)vf_table_lookup16(table, index), high = (__m256)vf_table_lookup16(table + 16, index);
    return (vf)_mm256_blendv_ps(low, high, (__m256)(index << 27)); /* by bit 4, as the sign */
}

/* clang-format off */
/* For each mask of eight lanes, the numbers of those in it, a byte each. */
#define DAFT_PLACE(m, i) ((m) >> (i) & 1 ? (uint64_t)(i) << 8 * __builtin_popcount((m) & ((1u << (i)) - 1)) : 0)
#define DAFT_PLACES(m) \
    (DAFT_PLACE(m, 1) | DAFT_PLACE(m, 2) | DAFT_PLACE(m, 3) | DAFT_PLACE(m, 4) | DAFT_PLACE(m, 5) | DAFT_PLACE(m, 6) | DAFT_PLACE(m, 7))
#define DAFT_PLACES4(m)  DAFT_PLACES(m), DAFT_PLACES((m) + 1), DAFT_PLACES((m) + 2), DAFT_PLACES((m) + 3)
#define DAFT_PLACES16(m) DAFT_PLACES4(m), DAFT_PLACES4((m) + 4), DAFT_PLACES4((m) + 8), DAFT_PLACES4((m) + 12)
#define DAFT_PLACES64(m) DAFT_PLACES16(m), DAFT_PLACES16((m) + 16), DAFT_PLACES16((m) + 32), DAFT_PLACES16((m) + 48)
static const uint64_t DAFT_LANES_SIDE_BY_SIDE[256] __attribute__((unused)) = {DAFT_PLACES64(0u), DAFT_PLACES64(64u),
                                                                              DAFT_PLACES64(128u), DAFT_PLACES64(192u)};
/* clang-format on */
#undef DAFT_PLACES64
#undef DAFT_PLACES16
#undef DAFT_PLACES4
#undef DAFT_PLACES
#undef DAFT_PLACE
DAFT_INLINE void vf_compress_store(float *out, vbits lanes, vf v)
{
    __m256i from = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)DAFT_LANES_SIDE_BY_SIDE[lanes]));
    _mm256_storeu_ps(out, _mm256_permutevar8x32_ps((__m256)v, from));
}
/* The rank of each lane of the mask: how many of the mask are up to it, less one. */
DAFT_INLINE vf vf_load_expand(const float *p, vbits lanes)
{
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128), one = _mm256_set1_epi32(1);
    const __m256i mask = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)lanes), bit), bit);
    __m256i rank = _mm256_and_si256(mask, one);
    rank = _mm256_add_epi32(rank, _mm256_slli_si256(rank, 4));
    rank = _mm256_add_epi32(rank, _mm256_slli_si256(rank, 8));
    const __m256i low = _mm256_set1_epi32(__builtin_popcount(lanes & 15));
    rank = _mm256_sub_epi32(_mm256_add_epi32(rank, _mm256_blend_epi32(_mm256_setzero_si256(), low, 0xf0)), one);
    return (vf)_mm256_and_ps((__m256)mask, _mm256_permutevar8x32_ps(_mm256_loadu_ps(p), rank));
}

#define DAFT_NATIVE_BLOCKS
DAFT_INLINE vf vf_gather_blocks(const float *const from[DAFT_VL / 4])
{
    return (vf)_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(from[0])), _mm_loadu_ps(from[1]), 1);
}
DAFT_INLINE void vf_scatter_blocks(float *const to[DAFT_VL / 4], vf v)
{
    _mm_store_ps(to[0], _mm256_castps256_ps128((__m256)v));
    _mm_store_ps(to[1], _mm256_extractf128_ps((__m256)v, 1));
}
DAFT_INLINE void vf_store_blocks(float *p, int stride, vf v)
{
    _mm_storeu_ps(p, _mm256_castps256_ps128((__m256)v));
    _mm_storeu_ps(p + stride, _mm256_extractf128_ps((__m256)v, 1));
}
DAFT_INLINE vf vf_load_eights(const float *first, const float *second, int part)
{
    (void)second, (void)part;
    return (vf)_mm256_loadu_ps(first);
}

#define DAFT_NATIVE_TRANSPOSE
DAFT_INLINE void vf_transpose4(vf r[4])
{
    __m256 low01 = _mm256_unpacklo_ps((__m256)r[0], (__m256)r[1]),
           high01 = _mm256_unpackhi_ps((__m256)r[0], (__m256)r[1]);
    __m256 low23 = _mm256_unpacklo_ps((__m256)r[2], (__m256)r[3]),
           high23 = _mm256_unpackhi_ps((__m256)r[2], (__m256)r[3]);
    r[0] = (vf)_mm256_shuffle_ps(low01, low23, 0x44), r[1] = (vf)_mm256_shuffle_ps(low01, low23, 0xee);
    r[2] = (vf)_mm256_shuffle_ps(high01, high23, 0x44), r[3] = (vf)_mm256_shuffle_ps(high01, high23, 0xee);
}

DAFT_INLINE uint64_t vu8_test_bit(const uint8_t bytes[64], uint32_t count, int k)
{
    const __m128i up = _mm_cvtsi32_si128(7 - k); /* bit k to the sign bit, which movemask takes */
    uint64_t bits = 0;
    for (uint32_t i = 0; i < count; i += 32) {
        __m256i some = _mm256_loadu_si256((const __m256i *)(const void *)(bytes + i));
        bits |= (uint64_t)(uint32_t)_mm256_movemask_epi8(_mm256_sll_epi16(some, up)) << i;
    }
    return bits;
}

#endif

#pragma GCC diagnostic pop

#endif
