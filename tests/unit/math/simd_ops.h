/* The operations of math/simd/ops.h as functions on arrays, one table for each target, for test_simd.c to hold against
 * scalar twins. */
#ifndef SIMD_OPS_H
#define SIMD_OPS_H

#include <stddef.h>
#include <stdint.h>

enum { SIMD_ROWS = 20 }; /* of eight floats */

/* What operations read. Lanes beyond the target's are there, too, and not looked at. */
typedef struct simd_in {
    int lanes;                   /* the target's, for the twins */
    float a[16], b[16];          /* any bits: numbers of all sizes, zeros, infinities, NaN */
    float real[4][16];           /* no NaN */
    float normal[16];            /* positive and normal, and so are their reciprocals */
    int32_t i[16], j[16], m[16]; /* m: 0 or -1 */
    double d[16], e[16];         /* any bits */
    float table[256];            /* any bits */
    uint16_t words[257];
    uint8_t bytes[64];
    char text[64];
    uint32_t bits; /* any */
    int n;         /* 0 to 20 */
    float rows[SIMD_ROWS][8] __attribute__((aligned(64)));
    int32_t row[16]; /* different ones */
    size_t at[3];    /* offsets of floats in rows: multiples of 4 that leave room for eight */
} simd_in;

/* What they write; filled before, so that what they must not touch is seen. */
typedef union simd_out {
    float f[8 * SIMD_ROWS];
    int32_t i[8 * SIMD_ROWS];
    uint32_t u[8 * SIMD_ROWS];
    double d[4 * SIMD_ROWS];
    uint64_t q[4 * SIMD_ROWS];
} __attribute__((aligned(64))) simd_out;

/* clang-format off */
/* X(name, kind): kind is 'b' where all bits agree, 'f' and 'd' where one NaN of floats or doubles is as good as another. */
#define SIMD_OPS(X)                                                                                                            \
    X(vf_load, 'b') X(vi_load, 'b') X(vd_load, 'b') X(v8_load, 'b') X(v4_load, 'b') X(vi_iota, 'b')                            \
    X(vf_set, 'b') X(vi_set, 'b') X(vd_set, 'd') X(v8_set, 'b') X(v4_set, 'b')                                  \
    X(vf_lt, 'b') X(vf_le, 'b') X(vi_eq, 'b') X(vi_lt, 'b') X(vm_and, 'b') X(vm_or, 'b') X(vm_not, 'b') X(vm_from_bits, 'b')   \
    X(vbits_first_n, 'b') X(vf_if_then_else, 'b') X(vi_if_then_else, 'b') X(vd_if_then_else, 'b') X(v4_if_then_else, 'b')     \
    X(vf_min, 'b') X(vf_max, 'b') X(vf_max_abs, 'b') X(vf_sqrt, 'f') X(vf_abs, 'b') X(vf_xor, 'b')             \
    X(vf_clamp01, 'b') X(vf_floor, 'b') X(vf_reduce_min, 'b') X(vf_reduce_max, 'b') X(vi_convert_to, 'b') X(vf_convert_to, 'b') \
    X(vf_column, 'b') X(vf_row, 'b') X(vf3_dot, 'f')                                                                           \
    X(vd_promote_half, 'd') X(vf_demote2, 'f') X(vd_sqrt, 'd') X(vd_max, 'b') X(vd_abs, 'b') X(vd_step, 'b')                   \
                                                                                                 \
    X(vf_gather_index, 'b') X(vi_gather_index, 'b') X(vf_table_lookup, 'b') X(vf_table_lookup16, 'b') X(vf_table_lookup32, 'b')       \
    X(vi_gather_pairs, 'b') X(vf_table_lookup_bytes, 'b') X(vf_load_expand, 'b')                                             \
    X(vf_compress_store, 'b') X(vi_compress_store, 'b')                                           \
    X(vf_gather_blocks, 'b') X(vf_scatter_blocks, 'b') X(vf_load_blocks, 'b') X(vf_store_blocks, 'b') X(vf_load_blocks_at, 'b') \
    X(vf_load_block_pairs_at, 'b') X(vf_load_eights, 'b') X(vf_transpose4, 'b') X(vf_gather_rows4, 'b') X(vf_gather_rows8, 'b') \
    X(vf_scatter_rows8, 'b') X(vf_store_interleaved8, 'b')                                                                     \
    X(v8_min, 'b') X(v8_max, 'b') X(v8_le_bits, 'b') X(v8_eq_bits, 'b') X(v8_bits_from_mask, 'b') X(v8_lower_half, 'b')        \
    X(v8_upper_half, 'b') X(v8_combine, 'b') X(v8i_table_lookup, 'b') X(v8i_store_set_bits, 'b')                               \
    X(v4_min, 'b') X(v4_max, 'b') X(v4_sqrt, 'f') X(v4_abs, 'b') X(v4i_convert_to, 'b') X(v4_bits_from_mask, 'b')              \
    X(v4_transpose3, 'b') X(v4_reduce_min4, 'b') X(vu8_nondigits_16, 'b') X(vu8_nondigits_32, 'b') X(vu8_nondigits_64, 'b')    \
    X(v4_promote, 'b') X(v4_demote, 'b') X(v8_promote, 'b') X(v8_demote, 'b') X(vu8_test_bit, 'b')
/* clang-format on */

#define SIMD_ENUM(name, kind) SIMD_##name,
enum { SIMD_OPS(SIMD_ENUM) SIMD_COUNT };

typedef void simd_op(const simd_in *in, simd_out *out);

typedef struct simd_target {
    const char *name;
    int lanes;
    simd_op *op[SIMD_COUNT];
    simd_op *approximate_reciprocal; /* of in->normal */
    /* Elementary functions of 16 numbers. */
    void (*log2)(const float *x, float *out), (*exp2)(const float *x, float *out), (*asin)(const float *x, float *out);
    void (*pow)(const float *x, const float *y, float *out), (*atan2)(const float *y, const float *x, float *out);
} simd_target;

extern const simd_target simd_target_plain, simd_target_sse2, simd_target_avx2, simd_target_avx512;

#endif
