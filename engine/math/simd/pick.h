/* Lanes picked by numbers that are kept as bytes, from tables that stand in registers; from rows anywhere in memory; bits of bytes; and
 * words, two to a lane. */
#ifndef DAFT_PICK_H
#define DAFT_PICK_H


/* out[k]: float `at` + k of each lane's row. */
DAFT_INLINE void vf_gather_rows4(const float *const row[DAFT_VL], int at, vf out[4])
{
#ifdef DAFT_HAVE_X86
    for (int i = 0; i < 4; i++) {
        const float *from[DAFT_VL / 4];
        for (int k = 0; k < DAFT_VL / 4; k++) from[k] = row[4 * k + i] + at;
        out[i] = vf_gather_blocks(from);
    }
    vf_transpose4(out);
#else
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < DAFT_VL; i++) out[k][i] = row[i][at + k];
#endif
}

/* DAFT_VL bytes, 0 to 255. */
DAFT_INLINE vi vi_load_u8(const uint8_t *p)
{
#if defined(DAFT_ISA_avx512)
    return (vi)_mm512_cvtepu8_epi32(_mm_loadu_si128((const __m128i_u *)(const void *)p));
#elif defined(DAFT_ISA_avx2)
    return (vi)_mm256_cvtepu8_epi32(_mm_loadu_si64(p));
#else
    return (vi){p[0], p[1], p[2], p[3]};
#endif
}

/* table[which[i]] of a table in memory; bytes of 0 to 15. */
DAFT_INLINE vf vf_table_lookup16_u8(const float table[16], const uint8_t *which)
{
#if DAFT_VL > 4
    return vf_table_lookup16(table, vi_load_u8(which));
#else
    return (vf){table[which[0]], table[which[1]], table[which[2]], table[which[3]]};
#endif
}

/* The larger of each. */
DAFT_INLINE vi vi_max(vi a, vi b)
{
#if defined(DAFT_ISA_avx512)
    return (vi)_mm512_max_epi32((__m512i)a, (__m512i)b);
#elif defined(DAFT_ISA_avx2)
    return (vi)_mm256_max_epi32((__m256i)a, (__m256i)b);
#else
    return vi_if_then_else(vi_lt(a, b), b, a);
#endif
}

/* Words of sixteen bits; the operators do the rest. */
typedef int16_t vw __attribute__((vector_size(DAFT_VL * 4)));
DAFT_INLINE vw vw_set(int low, int high) { return (vw)vi_set((low & 0xffff) | (int32_t)((uint32_t)high << 16)); }
DAFT_INLINE vw vw_min(vw a, vw b)
{
#if defined(DAFT_ISA_avx512)
    return (vw)_mm512_min_epi16((__m512i)a, (__m512i)b);
#elif defined(DAFT_ISA_avx2)
    return (vw)_mm256_min_epi16((__m256i)a, (__m256i)b);
#elif defined(DAFT_HAVE_X86)
    return (vw)_mm_min_epi16((__m128i)a, (__m128i)b);
#else
    vw less = (vw)(a < b);
    return (less & a) | (~less & b);
#endif
}
DAFT_INLINE vw vw_max(vw a, vw b)
{
#if defined(DAFT_ISA_avx512)
    return (vw)_mm512_max_epi16((__m512i)a, (__m512i)b);
#elif defined(DAFT_ISA_avx2)
    return (vw)_mm256_max_epi16((__m256i)a, (__m256i)b);
#elif defined(DAFT_HAVE_X86)
    return (vw)_mm_max_epi16((__m128i)a, (__m128i)b);
#else
    vw less = (vw)(a < b);
    return (less & b) | (~less & a);
#endif
}

/* Bit k of each of bytes 0 to 63, in their order. `count`: further bytes are 0. */
DAFT_INLINE uint64_t vu8_test_bit(const uint8_t bytes[64], uint32_t count, int k)
{
#if defined(DAFT_ISA_avx512)
    (void)count;
    return _mm512_test_epi8_mask(_mm512_loadu_si512(bytes), _mm512_set1_epi8((char)(1 << k)));
#elif defined(DAFT_ISA_avx2)
    const __m128i up = _mm_cvtsi32_si128(7 - k);
    uint64_t bits = 0;
    for (uint32_t i = 0; i < count; i += 32) {
        __m256i some = _mm256_loadu_si256((const __m256i *)(const void *)(bytes + i));
        bits |= (uint64_t)(uint32_t)_mm256_movemask_epi8(_mm256_sll_epi16(some, up)) << i;
    }
    return bits;
#elif defined(DAFT_ISA_sse2)
    const __m128i up = _mm_cvtsi32_si128(7 - k);
    uint64_t bits = 0;
    for (uint32_t i = 0; i < count; i += 16) {
        __m128i some = _mm_loadu_si128((const __m128i *)(const void *)(bytes + i));
        bits |= (uint64_t)(uint32_t)_mm_movemask_epi8(_mm_sll_epi16(some, up)) << i;
    }
    return bits;
#else
    uint64_t bits = 0;
    for (uint32_t i = 0; i < count; i++) bits |= (uint64_t)(bytes[i] >> k & 1) << i;
    return bits;
#endif
}

#endif
