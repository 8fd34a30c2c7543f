/* The list of SIMD operations: all that the *_kernel.c sources ask of a machine. How each target does them stands in
 * sse2.h, avx2.h, avx512.h and plain.h; a port to another machine is one more such file (plain.h fills in what it
 * leaves out).
 *
 * Types. The number of lanes is the target's, unless the name has a number:
 *   vf vi vm    DAFT_VL lanes of float, of int32_t, and a mask of them: 4 (plain, SSE2), 8 (AVX2) or 16 (AVX-512)
 *   vbits       a mask as an integer: bit i is lane i
 *   vd vl       half as many lanes of double, and of int64_t: a mask of a vd has all bits of a lane, or none
 *   v8 v8i      eight lanes of float, of int32_t: the children of a node
 *   v4 v4i      four lanes of float, of int32_t: the triangles of a leaf; x, y, z of a point
 *   vu8         not a type: the operation works on bytes in memory
 *
 * Names are Highway's (github.com/google/highway, g3doc/quick_reference.md) in our spelling: IfThenElse of vf is
 * vf_if_then_else. The prefix is the type of the result, or of the operand where the result is a plain value or
 * nothing. A block is four neighbouring lanes, 16 bytes; a row is eight floats in memory, a member of each to a lane.
 *
 * Arithmetic (+ - * / & | ^ ~ << >>, and on vd, v8, v4 comparisons, too) is written with the operators of GCC's vector
 * extensions. Nothing is fused and no subnormal flushed: each lane computes exactly what scalar code would, so that
 * every width gives the same bits. Only vf_approximate_reciprocal differs between targets: no result may depend on it.
 * Any address will do for loads and stores, unless said otherwise. tests/unit/math/test_simd.c holds each operation of
 * each target against a scalar twin, bit for bit. Public headers: ops.h elementary.h dispatch.h */
#ifndef DAFT_OPS_H
#define DAFT_OPS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

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
typedef double vd __attribute__((vector_size(DAFT_VL * 4)));
typedef int64_t vl __attribute__((vector_size(DAFT_VL * 4)));
typedef float v8 __attribute__((vector_size(32)));
typedef int32_t v8i __attribute__((vector_size(32)));
typedef float v4 __attribute__((vector_size(16)));
typedef int32_t v4i __attribute__((vector_size(16)));
typedef uint32_t vbits;
#ifdef DAFT_ISA_avx512
typedef uint16_t vm; /* bits */
#else
typedef vi vm; /* all bits of a lane, or none */
#endif

#define DAFT_ALL_LANES ((vbits)((1u << DAFT_VL) - 1))

typedef struct vf3 {
    vf x, y, z;
} vf3;

/* ---- memory, the same for all targets ---- */

typedef float vf_unaligned __attribute__((vector_size(DAFT_VL * 4), aligned(4), may_alias));
typedef int32_t vi_unaligned __attribute__((vector_size(DAFT_VL * 4), aligned(4), may_alias));
typedef float v8_unaligned __attribute__((vector_size(32), aligned(4), may_alias));
typedef float v4_unaligned __attribute__((vector_size(16), aligned(4), may_alias));
typedef double vd_unaligned __attribute__((vector_size(DAFT_VL * 4), aligned(8), may_alias));

/* LoadU, StoreU */
DAFT_INLINE vf vf_load(const float *p) { return *(const vf_unaligned *)p; }
DAFT_INLINE void vf_store(float *p, vf v) { *(vf_unaligned *)p = v; }
DAFT_INLINE vi vi_load(const void *p) { return *(const vi_unaligned *)p; }
DAFT_INLINE void vi_store(void *p, vi v) { *(vi_unaligned *)p = v; }
DAFT_INLINE vd vd_load(const double *p) { return *(const vd_unaligned *)p; }
DAFT_INLINE void vd_store(double *p, vd v) { *(vd_unaligned *)p = v; }
DAFT_INLINE v8 v8_load(const float *p) { return *(const v8_unaligned *)p; }
DAFT_INLINE void v8_store(float *p, v8 v) { *(v8_unaligned *)p = v; }
DAFT_INLINE v4 v4_load(const float *p) { return *(const v4_unaligned *)p; }
DAFT_INLINE void v4_store(float *p, v4 v) { *(v4_unaligned *)p = v; }

/* Iota: 0, 1, 2, … */
DAFT_INLINE vi vi_iota(void)
{
#if DAFT_VL == 16
    return (vi){0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
#elif DAFT_VL == 8
    return (vi){0, 1, 2, 3, 4, 5, 6, 7};
#else
    return (vi){0, 1, 2, 3};
#endif
}

/* ---- the list: what a target does. Lanes are written a[i]; each operation is done to all lanes. ---- */

/* Constants */
DAFT_INLINE vf vf_set(float s); /* Set: s in all lanes */
DAFT_INLINE vi vi_set(int32_t s);

/* Masks */
DAFT_INLINE vm vf_lt(vf a, vf b); /* Lt: a < b; false where one is NaN; -0 is not less than +0 */
DAFT_INLINE vm vf_le(vf a, vf b); /* Le: a <= b; false where one is NaN */
DAFT_INLINE vm vi_eq(vi a, vi b); /* Eq: a == b */
DAFT_INLINE vm vi_lt(vi a, vi b); /* Lt: a < b, signed */
DAFT_INLINE vm vm_and(vm a, vm b);
DAFT_INLINE vm vm_or(vm a, vm b);
DAFT_INLINE vm vm_not(vm a);
DAFT_INLINE vbits vbits_from_mask(vm m);          /* BitsFromMask */
DAFT_INLINE vm vm_from_bits(vbits b);             /* MaskFromBits: bits from DAFT_VL on are ignored */
DAFT_INLINE vf vf_if_then_else(vm m, vf a, vf b); /* IfThenElse: m ? a : b, any bits */
DAFT_INLINE vi vi_if_then_else(vm m, vi a, vi b);

/* Arithmetic */
DAFT_INLINE vf vf_min(vf a, vf b);     /* Min: a < b ? a : b, so b where one is NaN or both are zeros */
DAFT_INLINE vf vf_max(vf a, vf b);     /* Max: a > b ? a : b, so b where one is NaN or both are zeros */
DAFT_INLINE vf vf_sqrt(vf a);          /* Sqrt: correctly rounded; NaN below zero, -0 of -0 */
DAFT_INLINE float vf_reduce_min(vf a); /* ReduceMin: the least lane; none is NaN; a zero comes out as +0 */
DAFT_INLINE vi vi_convert_to(vf a); /* ConvertTo: towards zero; INT32_MIN for NaN and what is not in -2^31 .. 2^31 - 1
                                     */
DAFT_INLINE vf vf_convert_to(vi a); /* ConvertTo: rounded to nearest, ties to even */
DAFT_INLINE vf vf_approximate_reciprocal(vf a); /* ApproximateReciprocal: 1/a within 2^-11 of it, where both are normal
                                                 */

/* Double lanes */
DAFT_INLINE vd vd_promote_half(vf a, int half); /* PromoteLowerTo (half 0), PromoteUpperTo (half 1) */
DAFT_INLINE vf vf_demote2(vd low, vd high);     /* DemoteTo of both, combined; rounded to nearest, ties to even */
DAFT_INLINE vd vd_sqrt(vd a);                   /* Sqrt: correctly rounded; NaN below zero */
DAFT_INLINE vd vd_max(vd a, vd b);              /* Max: a > b ? a : b, so b where one is NaN or both are zeros */

/* Lanes from memory, by number */
DAFT_INLINE vf vf_gather_index(const float *base, vi index); /* GatherIndex: base[index[i]] */
DAFT_INLINE vi vi_gather_index(const void *base, vi index);
/* The same of two neighbours, by numbers in memory: *first has base[index[i]], *second base[index[i] + 1]. */
DAFT_INLINE void vi_gather_pairs(const void *base, const int32_t *index, vi *first, vi *second);
DAFT_INLINE vf vf_table_lookup(const float table[DAFT_VL], vi index); /* TableLookupLanes: table[index[i] & (DAFT_VL -
                                                                         1)] */
DAFT_INLINE vf vf_table_lookup16(const float table[16], vi index);    /* the same of sixteen: table[index[i] & 15] */
DAFT_INLINE vf vf_table_lookup32(const float table[32], vi index);    /* of 32: table[index[i] & 31] */
/* The three lower bytes of two words: first[k][i] = table[words[0][i] >> 8·k & 255], second[k][i] the same of words[1].
 * table[256] is read, but counts for nothing. */
DAFT_INLINE void vf_table_lookup_bytes(const uint16_t table[257], const vi words[2], vf first[3], vf second[3]);
DAFT_INLINE void vf_compress_store(float *out, vbits lanes, vf v); /* CompressStore: the lanes of a mask side by side;
                                                                    * further floats up to out[DAFT_VL - 1] may be
                                                                    * overwritten. No bit beyond DAFT_ALL_LANES is set.
                                                                    */
/* LoadExpand: floats side by side into the lanes of a mask, 0 into the others; floats up to p[DAFT_VL - 1] are read. */
DAFT_INLINE vf vf_load_expand(const float *p, vbits lanes);

/* Blocks of four lanes */
DAFT_INLINE vf vf_gather_blocks(const float *const from[DAFT_VL / 4]);  /* block k from from[k] on */
DAFT_INLINE void vf_scatter_blocks(float *const to[DAFT_VL / 4], vf v); /* block k to to[k]; 16-byte aligned */
DAFT_INLINE void vf_store_blocks(float *p, int stride, vf v);           /* block k to p + k·stride */
DAFT_INLINE void vf_transpose4(vf r[4]); /* in each block, r as a 4×4 matrix: lane j of r[i] and lane i of r[j] change
                                            places */

/* Rows of eight floats: 32 bytes at base + 8·row[i], 16-byte aligned */
DAFT_INLINE void vf_gather_rows8(const float *base, const int32_t *row, vf out[8]); /* out[k][i] = base[8·row[i] + k] */
/* base[8·row[i] + k] = in[k][i] for the lanes of the mask; their rows differ. */
DAFT_INLINE void vf_scatter_rows8(float *base, const int32_t *row, const vf in[8], vbits lanes);
/* Eights at p, p + at[0], p + at[1], p + at[2], as many as there are blocks in a vf: low has each one's first block,
 * high its second. */
DAFT_INLINE void vf_load_block_pairs_at(const float *p, const size_t at[3], vf *low, vf *high);
/* DAFT_VL 16: the eight floats at `first`, then those at `second`. Narrower: floats part·DAFT_VL and on of those at
 * `first`. */
DAFT_INLINE vf vf_load_eights(const float *first, const float *second, int part);
enum { DAFT_EIGHTS = DAFT_VL > 8 ? DAFT_VL / 8 : 1, DAFT_EIGHT_PARTS = DAFT_VL < 8 ? 8 / DAFT_VL : 1 };

/* Eight lanes */
DAFT_INLINE v8 v8_min(v8 a, v8 b);                      /* as vf_min */
DAFT_INLINE v8 v8_max(v8 a, v8 b);                      /* as vf_max */
DAFT_INLINE uint32_t v8_le_bits(v8 a, v8 b);            /* BitsFromMask(Le): bit i is a[i] <= b[i] */
DAFT_INLINE v4 v8_lower_half(v8 a);                     /* LowerHalf: lanes 0 to 3 */
DAFT_INLINE v4 v8_upper_half(v8 a);                     /* UpperHalf: lanes 4 to 7 */
DAFT_INLINE v8 v8_combine(v4 high, v4 low);             /* Combine: low in lanes 0 to 3, high in 4 to 7 */
DAFT_INLINE v8 v8_promote(const uint8_t p[8]);          /* as v4_promote */
DAFT_INLINE void v8_demote(v8 a, uint8_t p[8]);         /* as v4_demote */
DAFT_INLINE v8i v8i_table_lookup(v8i table, v8i index); /* TableLookupLanes: table[index[i]]; indices of 0 to 7 */
/* CompressStore of first, first + 1, … by the bits set: the numbers of these bits, ascending; up to eight are written.
 * Gives how many bits. */
DAFT_INLINE uint32_t v8i_store_set_bits(uint32_t *out, uint32_t bits, int32_t first);

/* Four lanes */
DAFT_INLINE v4 v4_min(v4 a, v4 b);             /* as vf_min */
DAFT_INLINE v4 v4_max(v4 a, v4 b);             /* as vf_max */
DAFT_INLINE v4 v4_sqrt(v4 a);                  /* as vf_sqrt */
DAFT_INLINE v4i v4i_convert_to(v4 a);          /* as vi_convert_to */
DAFT_INLINE uint32_t v4_bits_from_mask(v4i m); /* BitsFromMask: of lanes' sign bits */
DAFT_INLINE v4 v4_promote(const uint8_t p[4]); /* PromoteTo: of bytes in memory */
/* DemoteTo bytes in memory: towards zero, what is below 0 becomes 0 and what is above 255 becomes 255; NaN becomes 0.
 */
DAFT_INLINE void v4_demote(v4 a, uint8_t p[4]);
/* x has lanes 0 of a, b, c; y lanes 1; z lanes 2. Their lanes 3 mean nothing. */
DAFT_INLINE void v4_transpose3(v4 a, v4 b, v4 c, v4 *x, v4 *y, v4 *z);

/* Bytes in memory */
DAFT_INLINE uint32_t vu8_nondigits_16(const char *p); /* bit i: p[i] is not one of '0' to '9' */
/* Bit i: bit k of bytes[i], for the first `count` of 64; further bytes are 0. */
DAFT_INLINE uint64_t vu8_test_bit(const uint8_t bytes[64], uint32_t count, int k);

#if defined(DAFT_ISA_avx512)
#include "math/simd/avx512.h"
#elif defined(DAFT_ISA_avx2)
#include "math/simd/avx2.h"
#elif defined(DAFT_ISA_sse2) || (defined(DAFT_BUILDS_sse2) && !defined(DAFT_ISA_plain)) /* sources that are no         \
                                                                                           kernels, too */
#include "math/simd/sse2.h"
#endif
#include "math/simd/plain.h" /* what the target left out */

/* ---- the same for all targets: what follows from the list and the operators ---- */

DAFT_INLINE vd vd_set(double s) { return s - (vd){0}; } /* not +, which makes -0 a +0 */

/* Lanes as blocks one below the other: the lane's column, 0 to 3, and its row. */
DAFT_INLINE vf vf_column(void) { return vf_convert_to(vi_iota() & vi_set(3)); }
DAFT_INLINE vf vf_row(void) { return vf_convert_to(vi_iota() >> 2); }

/* FirstN: the mask of lanes i < n; n may be over DAFT_VL. */
DAFT_INLINE vbits vbits_first_n(int n) { return n >= DAFT_VL ? DAFT_ALL_LANES : (vbits)((1u << n) - 1); }

DAFT_INLINE vf vf_abs(vf a) { return (vf)((vi)a & vi_set(0x7fffffff)); }
/* The bits of a and b; with b a sign bit, a with its sign flipped there. */
DAFT_INLINE vf vf_xor(vf a, vi b) { return (vf)((vi)a ^ b); }
/* max(|a|, |b|), |b| where a is NaN or b is. */
DAFT_INLINE vf vf_max_abs(vf a, vf b) { return vf_max(vf_abs(a), vf_abs(b)); }
/* Clamp to 0 .. 1; 0 of NaN. */
DAFT_INLINE vf vf_clamp01(vf a) { return vf_min(vf_max(a, vf_set(0)), vf_set(1)); }
/* Floor, for |a| < 2^31; +0 of -0. */
DAFT_INLINE vf vf_floor(vf a)
{
    vf whole = vf_convert_to(vi_convert_to(a));
    return vf_if_then_else(vf_lt(a, whole), whole - vf_set(1), whole);
}
/* ReduceMax: the largest lane; none is NaN; a zero comes out as +0. */
DAFT_INLINE float vf_reduce_max(vf a) { return 0 - vf_reduce_min(-a); }
DAFT_INLINE void vi_compress_store(void *out, vbits lanes, vi v) { vf_compress_store(out, lanes, (vf)v); }
DAFT_INLINE vf vf3_dot(vf3 a, vf3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

DAFT_INLINE vd vd_if_then_else(vl m, vd a, vd b) { return (vd)((m & (vl)a) | (~m & (vl)b)); }
DAFT_INLINE vd vd_abs(vd a) { return (vd)((vl)a & ((vl){0} + INT64_MAX)); }
/* 1 where a > 0, else 0. */
DAFT_INLINE vd vd_step(vd a)
{
    const vd none = {0};
    return (vd)((vl)(a > none) & (vl)(none + 1));
}

/* Blocks at p, p + stride and so on. */
DAFT_INLINE vf vf_load_blocks(const float *p, int stride)
{
    const float *from[DAFT_VL / 4];
    for (int i = 0; i < DAFT_VL / 4; i++) from[i] = p + i * stride;
    return vf_gather_blocks(from);
}
/* Blocks at p, p + at[0], p + at[1], p + at[2], as many as there are in a vf. */
DAFT_INLINE vf vf_load_blocks_at(const float *p, const size_t at[3])
{
    const float *from[DAFT_VL / 4];
    for (int i = 0; i < DAFT_VL / 4; i++) from[i] = i ? p + at[i - 1] : p;
    return vf_gather_blocks(from);
}
/* out[k][i] = row[i][at + k]. */
DAFT_INLINE void vf_gather_rows4(const float *const row[DAFT_VL], int at, vf out[4])
{
    for (int i = 0; i < 4; i++) {
        const float *from[DAFT_VL / 4];
        for (int k = 0; k < DAFT_VL / 4; k++) from[k] = row[4 * k + i] + at;
        out[i] = vf_gather_blocks(from);
    }
    vf_transpose4(out);
}
/* StoreInterleaved, of eight: base[i·stride + k] = in[k][i]. base and stride are multiples of 16 bytes. */
DAFT_INLINE void vf_store_interleaved8(float *base, int stride, const vf in[8])
{
    for (int half = 0; half < 2; half++) {
        vf r[4] = {in[4 * half], in[4 * half + 1], in[4 * half + 2], in[4 * half + 3]};
        vf_transpose4(r);
        for (int k = 0; k < 4; k++) vf_store_blocks(base + k * stride + 4 * half, 4 * stride, r[k]);
    }
}

DAFT_INLINE v8 v8_set(float s) { return (v8){s, s, s, s, s, s, s, s}; }
DAFT_INLINE uint32_t v8_eq_bits(v8 a, v8 b) { return v8_le_bits(a, b) & v8_le_bits(b, a); }
/* BitsFromMask, of a comparison's lanes: all bits or none. */
DAFT_INLINE uint32_t v8_bits_from_mask(v8i mask) { return v8_le_bits((v8)(mask & 0x3f800000), v8_set(0)) ^ 0xff; }

DAFT_INLINE v4 v4_set(float s) { return (v4){s, s, s, s}; }
DAFT_INLINE v4 v4_if_then_else(v4i m, v4 a, v4 b) { return (v4)((m & (v4i)a) | (~m & (v4i)b)); }
DAFT_INLINE v4 v4_abs(v4 a) { return (v4)((v4i)a & (v4i){0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff}); }
/* The least lane of a, of b, of c, of d; none is NaN. Of zeros of both signs either may come out. */
DAFT_INLINE v4 v4_reduce_min4(vf a, vf b, vf c, vf d)
{
    vf r[4] = {a, b, c, d};
    vf_transpose4(r);
    float least[DAFT_VL] __attribute__((aligned(4 * DAFT_VL)));
    vf_store(least, vf_min(vf_min(r[0], r[1]), vf_min(r[2], r[3])));
    v4 all = v4_load(least);
    for (int i = 4; i < DAFT_VL; i += 4) all = v4_min(all, v4_load(least + i));
    return all;
}

DAFT_INLINE uint32_t vu8_nondigits_32(const char *p) { return vu8_nondigits_16(p) | vu8_nondigits_16(p + 16) << 16; }
DAFT_INLINE uint64_t vu8_nondigits_64(const char *p)
{
    return vu8_nondigits_32(p) | (uint64_t)vu8_nondigits_32(p + 32) << 32;
}

#endif
