/* Each operation of math/simd/ops.h on arrays; compiled once for each target. */
#include "simd_ops.h"

#include "math/simd/dispatch.h"
#include "math/simd/elementary.h"

#define OP(name) static void name##_op(const simd_in *in, simd_out *out)
#define A        vf_load(in->a)
#define B        vf_load(in->b)
#define I        vi_load(in->i)
#define J        vi_load(in->j)

static vm mask_of(const simd_in *in) { return vi_eq(vi_load(in->m), vi_set(-1)); }

OP(vf_load) { vf_store(out->f, vf_load(in->a + 1 - DAFT_VL / 16)); }
OP(vi_load) { vi_store(out->i, I); }
OP(vd_load) { vd_store(out->d, vd_load(in->d + 1)); }
OP(v8_load) { v8_store(out->f, v8_load(in->a + 3)); }
OP(v4_load) { v4_store(out->f, v4_load(in->a + 3)); }
OP(vi_iota) { (void)in, vi_store(out->i, vi_iota()); }
OP(vf_set) { vf_store(out->f, vf_set(in->real[0][0])); }
OP(vi_set) { vi_store(out->i, vi_set(in->i[0])); }
OP(vd_set) { vd_store(out->d, vd_set(in->d[0])); }
OP(v8_set) { v8_store(out->f, v8_set(in->a[0])); }
OP(v4_set) { v4_store(out->f, v4_set(in->a[0])); }

OP(vf_lt) { out->u[0] = vbits_from_mask(vf_lt(A, B)); }
OP(vf_le) { out->u[0] = vbits_from_mask(vf_le(A, B)); }
OP(vi_eq) { out->u[0] = vbits_from_mask(vi_eq(I, J)); }
OP(vi_lt) { out->u[0] = vbits_from_mask(vi_lt(I, J)); }
OP(vm_and) { out->u[0] = vbits_from_mask(vm_and(mask_of(in), vm_from_bits(in->bits))); }
OP(vm_or) { out->u[0] = vbits_from_mask(vm_or(mask_of(in), vm_from_bits(in->bits))); }
OP(vm_not) { out->u[0] = vbits_from_mask(vm_not(mask_of(in))); }
OP(vm_from_bits) { out->u[0] = vbits_from_mask(vm_from_bits(in->bits)); }
OP(vbits_first_n) { out->u[0] = vbits_first_n(in->n); }
OP(vf_if_then_else) { vf_store(out->f, vf_if_then_else(mask_of(in), A, B)); }
OP(vi_if_then_else) { vi_store(out->i, vi_if_then_else(mask_of(in), I, J)); }
OP(vd_if_then_else)
{
    vd_store(out->d, vd_if_then_else((vl)(vd_load(in->d) < vd_load(in->e)), vd_load(in->d), vd_load(in->e)));
}
OP(v4_if_then_else)
{
    v4_store(out->f, v4_if_then_else((v4i)v4_load((const float *)in->m), v4_load(in->a), v4_load(in->b)));
}

OP(vf_min) { vf_store(out->f, vf_min(A, B)); }
OP(vf_max) { vf_store(out->f, vf_max(A, B)); }
OP(vf_max_abs) { vf_store(out->f, vf_max_abs(A, B)); }
OP(vf_sqrt) { vf_store(out->f, vf_sqrt(A)); }
OP(vf_abs) { vf_store(out->f, vf_abs(A)); }
OP(vf_xor) { vf_store(out->f, vf_xor(A, I)); }
OP(vf_clamp01) { vf_store(out->f, vf_clamp01(A)); }
OP(vf_floor) { vf_store(out->f, vf_floor(vf_if_then_else(vf_lt(vf_abs(A), vf_set(0x1p31f)), A, vf_set(0.5f)))); }
OP(vf_reduce_min) { out->f[0] = vf_reduce_min(vf_load(in->real[0])); }
OP(vf_reduce_max) { out->f[0] = vf_reduce_max(vf_load(in->real[0])); }
OP(vi_convert_to) { vi_store(out->i, vi_convert_to(A)); }
OP(vf_convert_to) { vf_store(out->f, vf_convert_to(I)); }
OP(vf_column) { (void)in, vf_store(out->f, vf_column()); }
OP(vf_row) { (void)in, vf_store(out->f, vf_row()); }
OP(vf3_dot)
{
    vf3 a = {A, vf_load(in->real[0]), vf_load(in->real[1])}, b = {B, vf_load(in->real[2]), vf_load(in->real[3])};
    vf_store(out->f, vf3_dot(a, b));
}

OP(vd_promote_half)
{
    vd_store(out->d, vd_promote_half(A, 0));
    vd_store(out->d + DAFT_VL / 2, vd_promote_half(A, 1));
}
OP(vf_demote2) { vf_store(out->f, vf_demote2(vd_load(in->d), vd_load(in->e))); }
OP(vd_sqrt) { vd_store(out->d, vd_sqrt(vd_load(in->d))); }
OP(vd_max) { vd_store(out->d, vd_max(vd_load(in->d), vd_load(in->e))); }
OP(vd_abs) { vd_store(out->d, vd_abs(vd_load(in->d))); }
OP(vd_step) { vd_store(out->d, vd_step(vd_load(in->d))); }

OP(vf_gather_index) { vf_store(out->f, vf_gather_index(in->rows[0], I & vi_set(127))); }
OP(vi_gather_index) { vi_store(out->i, vi_gather_index(in->rows[0], I & vi_set(127))); }
OP(vf_table_lookup) { vf_store(out->f, vf_table_lookup(in->a, I)); }
OP(vf_table_lookup16) { vf_store(out->f, vf_table_lookup16(in->a, I)); }
OP(vf_table_lookup32) { vf_store(out->f, vf_table_lookup32(in->table, I)); }
OP(vi_gather_pairs)
{
    int32_t index[DAFT_VL];
    vi first, second;
    vi_store(index, I & vi_set(127));
    vi_gather_pairs(in->rows[0], index, &first, &second);
    vi_store(out->i, first), vi_store(out->i + DAFT_VL, second);
}
OP(vf_table_lookup_bytes)
{
    vf first[3], second[3];
    vf_table_lookup_bytes(in->words, (const vi[2]){I, J}, first, second);
    for (int k = 0; k < 3; k++) {
        vf_store(out->f + k * DAFT_VL, first[k]);
        vf_store(out->f + (3 + k) * DAFT_VL, second[k]);
    }
}
OP(vf_load_expand) { vf_store(out->f, vf_load_expand(in->a, in->bits & DAFT_ALL_LANES)); }
OP(vf_compress_store)
{
    float all[2 * DAFT_VL];
    vbits lanes = in->bits & DAFT_ALL_LANES;
    vf_store(all + DAFT_VL, vf_load(in->b));
    vf_compress_store(all, lanes, A);
    memcpy(out->f, all, (size_t)__builtin_popcount(lanes) * 4);
    memcpy(out->f + 32, all + DAFT_VL, DAFT_VL * 4);
}
OP(vi_compress_store)
{
    int32_t all[DAFT_VL];
    vbits lanes = in->bits & DAFT_ALL_LANES;
    vi_compress_store(all, lanes, I);
    memcpy(out->i, all, (size_t)__builtin_popcount(lanes) * 4);
}

OP(vf_gather_blocks)
{
    const float *from[DAFT_VL / 4];
    for (int k = 0; k < DAFT_VL / 4; k++) from[k] = &in->rows[in->row[k]][1];
    vf_store(out->f, vf_gather_blocks(from));
}
OP(vf_scatter_blocks)
{
    float *to[DAFT_VL / 4];
    for (int k = 0; k < DAFT_VL / 4; k++) to[k] = &out->f[8 * in->row[k] + 4];
    vf_scatter_blocks(to, A);
}
OP(vf_load_blocks) { vf_store(out->f, vf_load_blocks(in->rows[0] + 3, in->n)); }
OP(vf_store_blocks) { vf_store_blocks(out->f + 3, 4 + in->n, A); }
OP(vf_load_blocks_at) { vf_store(out->f, vf_load_blocks_at(in->rows[1], in->at)); }
OP(vf_load_block_pairs_at)
{
    vf low, high;
    vf_load_block_pairs_at(in->rows[1], in->at, &low, &high);
    vf_store(out->f, low), vf_store(out->f + DAFT_VL, high);
}
OP(vf_load_eights)
{
    for (int part = 0; part < DAFT_EIGHT_PARTS; part++)
        vf_store(out->f + part * DAFT_VL, vf_load_eights(in->rows[in->row[0]], in->rows[in->row[1]], part));
}
OP(vf_transpose4)
{
    vf r[4];
    for (int k = 0; k < 4; k++) r[k] = vf_load(in->real[k]);
    vf_transpose4(r);
    for (int k = 0; k < 4; k++) vf_store(out->f + k * DAFT_VL, r[k]);
}
OP(vf_gather_rows4)
{
    const float *from[DAFT_VL];
    vf v[4];
    for (int k = 0; k < DAFT_VL; k++) from[k] = in->rows[in->row[k]];
    vf_gather_rows4(from, 3, v);
    for (int k = 0; k < 4; k++) vf_store(out->f + k * DAFT_VL, v[k]);
}
OP(vf_gather_rows8)
{
    vf v[8];
    vf_gather_rows8(in->rows[0], in->row, v);
    for (int k = 0; k < 8; k++) vf_store(out->f + k * DAFT_VL, v[k]);
}
OP(vf_scatter_rows8)
{
    vf v[8];
    for (int k = 0; k < 8; k++) v[k] = k < 4 ? vf_load(in->real[k]) : -vf_load(in->real[k - 4]);
    vf_scatter_rows8(out->f, in->row, v, in->n % 3 ? in->bits : DAFT_ALL_LANES);
}
OP(vf_store_interleaved8)
{
    vf v[8];
    for (int k = 0; k < 8; k++) v[k] = k < 4 ? vf_load(in->real[k]) : -vf_load(in->real[k - 4]);
    vf_store_interleaved8(out->f, DAFT_VL == 16 ? 8 : 12, v);
}

OP(v8_min) { v8_store(out->f, v8_min(v8_load(in->a), v8_load(in->b))); }
OP(v8_max) { v8_store(out->f, v8_max(v8_load(in->a), v8_load(in->b))); }
OP(v8_le_bits) { out->u[0] = v8_le_bits(v8_load(in->a), v8_load(in->b)); }
OP(v8_eq_bits) { out->u[0] = v8_eq_bits(v8_load(in->a), v8_load(in->b)); }
OP(v8_bits_from_mask) { out->u[0] = v8_bits_from_mask((v8i)v8_load((const float *)in->m)); }
OP(v8_lower_half) { v4_store(out->f, v8_lower_half(v8_load(in->a))); }
OP(v8_upper_half) { v4_store(out->f, v8_upper_half(v8_load(in->a))); }
OP(v8_combine) { v8_store(out->f, v8_combine(v4_load(in->a), v4_load(in->b))); }
OP(v8i_table_lookup)
{
    v8i index = (v8i)v8_load((const float *)in->i) & 7;
    v8_store(out->f, (v8)v8i_table_lookup((v8i)v8_load(in->a), index));
}
OP(v8i_store_set_bits)
{
    uint32_t list[8];
    out->u[0] = v8i_store_set_bits(list, in->bits & 0xff, in->i[0] >> 8);
    memcpy(out->u + 1, list, 4 * out->u[0]);
}

OP(v4_min) { v4_store(out->f, v4_min(v4_load(in->a), v4_load(in->b))); }
OP(v4_max) { v4_store(out->f, v4_max(v4_load(in->a), v4_load(in->b))); }
OP(v4_sqrt) { v4_store(out->f, v4_sqrt(v4_load(in->a))); }
OP(v4_abs) { v4_store(out->f, v4_abs(v4_load(in->a))); }
OP(v4i_convert_to) { v4_store(out->f, (v4)v4i_convert_to(v4_load(in->a))); }
OP(v4_promote) { v4_store(out->f, v4_promote(in->bytes)); }
OP(v8_promote) { v8_store(out->f, v8_promote(in->bytes)); }
OP(v8_demote)
{
    uint8_t bytes[8];
    v8_demote(v8_load(in->a), bytes);
    memcpy(out->u, bytes, 8);
}
OP(v4_demote)
{
    uint8_t bytes[4];
    v4_demote(v4_load(in->a), bytes);
    memcpy(out->u, bytes, 4);
}
OP(v4_bits_from_mask) { out->u[0] = v4_bits_from_mask((v4i)v4_load((const float *)in->m)); }
OP(v4_transpose3)
{
    v4 v[3];
    v4_transpose3(v4_load(in->a), v4_load(in->b), v4_load(in->real[0]), &v[0], &v[1], &v[2]);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) out->f[3 * k + i] = v[k][i];
}
OP(v4_reduce_min4)
{
    v4 least = v4_reduce_min4(vf_load(in->real[0]), vf_load(in->real[1]), vf_load(in->real[2]), vf_load(in->real[3]));
    v4_store(out->f, least + v4_set(0)); /* a zero of either sign */
}
OP(vu8_nondigits_16) { out->u[0] = vu8_nondigits_16(in->text + 1); }
OP(vu8_nondigits_32) { out->u[0] = vu8_nondigits_32(in->text + 1); }
OP(vu8_nondigits_64) { out->q[0] = vu8_nondigits_64(in->text); }
OP(vu8_test_bit)
{
    uint8_t some[64] = {0};
    uint32_t count = 3 * (uint32_t)in->n;
    memcpy(some, in->bytes, count);
    out->q[0] = vu8_test_bit(some, count, in->n % 8);
}

OP(approximate_reciprocal) { vf_store(out->f, vf_approximate_reciprocal(vf_load(in->normal))); }

#define FOR_16 for (int i = 0; i < 16; i += DAFT_VL)
static void log2_16(const float *x, float *out) { FOR_16 vf_store(out + i, vf_log2(vf_load(x + i))); }
static void exp2_16(const float *x, float *out) { FOR_16 vf_store(out + i, vf_exp2(vf_load(x + i))); }
static void asin_16(const float *x, float *out) { FOR_16 vf_store(out + i, vf_asin(vf_load(x + i))); }
static void pow_16(const float *x, const float *y, float *out)
{
    FOR_16 vf_store(out + i, vf_pow(vf_load(x + i), vf_load(y + i)));
}
static void atan2_16(const float *y, const float *x, float *out)
{
    FOR_16 vf_store(out + i, vf_atan2(vf_load(y + i), vf_load(x + i)));
}

#define NAME2(isa)        #isa
#define NAME(isa)         NAME2(isa)
#define ENTRY(name, kind) name##_op,
const simd_target DAFT_KERNEL(simd_target) = {
    .name = NAME(DAFT_ISA),
    .lanes = DAFT_VL,
    .op = {SIMD_OPS(ENTRY)},
    .approximate_reciprocal = approximate_reciprocal_op,
    .log2 = log2_16,
    .exp2 = exp2_16,
    .asin = asin_16,
    .pow = pow_16,
    .atan2 = atan2_16,
};
