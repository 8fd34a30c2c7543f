/* The operations of ops.h without a vector instruction asked for by name: what each of them does, in loops over lanes
 * and GCC's vector extensions, which the compiler turns into what the machine has. It is the whole of `--isa plain`, a
 * port's starting point, and what the other targets leave to it: each says in its first lines which groups it does
 * itself. */
#ifndef DAFT_PLAIN_H
#define DAFT_PLAIN_H

#define EACH_LANE for (int i = 0; i < DAFT_VL; i++)

#ifndef DAFT_NATIVE_SELECT
DAFT_INLINE vf vf_set(float s) { return s - (vf){0}; } /* not +, which makes -0 a +0 */
DAFT_INLINE vi vi_set(int32_t s) { return s + (vi){0}; }
DAFT_INLINE vf vf_if_then_else(vm m, vf a, vf b) { return (vf)((m & (vi)a) | (~m & (vi)b)); }
DAFT_INLINE vi vi_if_then_else(vm m, vi a, vi b) { return (m & a) | (~m & b); }
#endif

#ifndef DAFT_NATIVE_MASKS
DAFT_INLINE vm vf_lt(vf a, vf b) { return (vm)(a < b); }
DAFT_INLINE vm vf_le(vf a, vf b) { return (vm)(a <= b); }
DAFT_INLINE vm vi_eq(vi a, vi b) { return (vm)(a == b); }
DAFT_INLINE vm vi_lt(vi a, vi b) { return (vm)(a < b); }
DAFT_INLINE vm vm_and(vm a, vm b) { return a & b; }
DAFT_INLINE vm vm_or(vm a, vm b) { return a | b; }
DAFT_INLINE vm vm_not(vm a) { return ~a; }
DAFT_INLINE vm vm_from_bits(vbits b)
{
    vi lane = vi_set(1) << vi_iota();
    return (vm)((vi_set((int32_t)b) & lane) == lane);
}
#endif

#ifndef DAFT_NATIVE_ARITHMETIC
DAFT_INLINE vbits vbits_from_mask(vm m)
{
    vbits bits = 0;
    EACH_LANE bits |= (vbits)(m[i] & 1) << i;
    return bits;
}
DAFT_INLINE vf vf_min(vf a, vf b) { return vf_if_then_else(vf_lt(a, b), a, b); }
DAFT_INLINE vf vf_max(vf a, vf b) { return vf_if_then_else(vf_lt(b, a), a, b); }
DAFT_INLINE vf vf_sqrt(vf a)
{
    EACH_LANE a[i] = sqrtf(a[i]);
    return a;
}
DAFT_INLINE float vf_reduce_min(vf a)
{
    float lane[DAFT_VL];
    vf_store(lane, a);
    for (int half = DAFT_VL / 2; half; half /= 2)
        for (int i = 0; i < half; i++) lane[i] = lane[i + half] < lane[i] ? lane[i + half] : lane[i];
    return lane[0] + 0;
}
DAFT_INLINE vi vi_convert_to(vf a)
{
    vm fits = vm_and(vf_le(vf_set(-0x1p31f), a), vf_lt(a, vf_set(0x1p31f)));
    return vi_if_then_else(fits, __builtin_convertvector(vf_if_then_else(fits, a, vf_set(0)), vi), vi_set(INT32_MIN));
}
DAFT_INLINE vf vf_convert_to(vi a) { return __builtin_convertvector(a, vf); }
DAFT_INLINE vf vf_approximate_reciprocal(vf a) { return 1 / a; }
#endif

#ifndef DAFT_NATIVE_DOUBLE
DAFT_INLINE vd vd_promote_half(vf a, int half)
{
    vd out;
    for (int i = 0; i < DAFT_VL / 2; i++) out[i] = (double)a[half * (DAFT_VL / 2) + i];
    return out;
}
DAFT_INLINE vf vf_demote2(vd low, vd high)
{
    vf out;
    for (int i = 0; i < DAFT_VL / 2; i++) out[i] = (float)low[i], out[DAFT_VL / 2 + i] = (float)high[i];
    return out;
}
DAFT_INLINE vd vd_sqrt(vd a)
{
    for (int i = 0; i < DAFT_VL / 2; i++) a[i] = sqrt(a[i]);
    return a;
}
DAFT_INLINE vd vd_max(vd a, vd b)
{
    vl more = (vl)(a > b);
    return (vd)((more & (vl)a) | (~more & (vl)b));
}
#endif

#ifndef DAFT_NATIVE_GATHER
DAFT_INLINE vf vf_gather_index(const float *base, vi index)
{
    vf v;
    EACH_LANE v[i] = base[index[i]];
    return v;
}
DAFT_INLINE vi vi_gather_index(const void *base, vi index)
{
    vi v;
    EACH_LANE v[i] = ((const int32_t *)base)[index[i]];
    return v;
}
DAFT_INLINE void vi_gather_pairs(const void *base, const int32_t *index, vi *first, vi *second)
{
    const int32_t *const from = base;
    vi a, b;
    EACH_LANE a[i] = from[index[i]], b[i] = from[index[i] + 1];
    *first = a, *second = b;
}
DAFT_INLINE void vf_table_lookup_bytes(const uint16_t table[257], const vi words[2], vf first[3], vf second[3])
{
    for (int k = 0; k < 3; k++) {
        vf a, b;
        EACH_LANE a[i] = (float)table[words[0][i] >> 8 * k & 255], b[i] = (float)table[words[1][i] >> 8 * k & 255];
        first[k] = a, second[k] = b;
    }
}
DAFT_INLINE vf vf_table_lookup(const float table[DAFT_VL], vi index)
{
    return vf_gather_index(table, index & vi_set(DAFT_VL - 1));
}
DAFT_INLINE vf vf_table_lookup16(const float table[16], vi index) { return vf_gather_index(table, index & vi_set(15)); }
DAFT_INLINE vf vf_table_lookup32(const float table[32], vi index) { return vf_gather_index(table, index & vi_set(31)); }
/* Without a branch, which would often be guessed wrong. */
DAFT_INLINE void vf_compress_store(float *out, vbits lanes, vf v)
{
    float all[DAFT_VL];
    vf_store(all, v);
    EACH_LANE *out = all[i], out += lanes >> i & 1;
}
DAFT_INLINE vf vf_load_expand(const float *p, vbits lanes)
{
    vf v;
    EACH_LANE v[i] = lanes >> i & 1 ? *p : 0, p += lanes >> i & 1;
    return v;
}
#endif

#ifndef DAFT_NATIVE_BLOCKS
DAFT_INLINE vf vf_gather_blocks(const float *const from[DAFT_VL / 4])
{
    vf v;
    for (int k = 0; k < DAFT_VL / 4; k++) v4_store((float *)&v + 4 * k, v4_load(from[k]));
    return v;
}
DAFT_INLINE void vf_scatter_blocks(float *const to[DAFT_VL / 4], vf v)
{
    for (int k = 0; k < DAFT_VL / 4; k++) v4_store(to[k], v4_load((const float *)&v + 4 * k));
}
DAFT_INLINE void vf_store_blocks(float *p, int stride, vf v)
{
    for (int k = 0; k < DAFT_VL / 4; k++) v4_store(p + k * stride, v4_load((const float *)&v + 4 * k));
}
DAFT_INLINE vf vf_load_eights(const float *first, const float *second, int part)
{
    (void)second;
    return vf_load(first + part * DAFT_VL);
}
#endif

#ifndef DAFT_NATIVE_TRANSPOSE
DAFT_INLINE void vf_transpose4(vf r[4])
{
    const vf in[4] = {r[0], r[1], r[2], r[3]};
    for (int j = 0; j < 4; j++) EACH_LANE r[j][i] = in[i & 3][(i & ~3) + j];
}
#endif

#ifndef DAFT_NATIVE_ROWS
DAFT_INLINE void vf_gather_rows8(const float *base, const int32_t *row, vf out[8])
{
    for (int half = 0; half < 2; half++) {
        for (int i = 0; i < 4; i++) {
            const float *from[DAFT_VL / 4];
            for (int k = 0; k < DAFT_VL / 4; k++) from[k] = base + 8 * row[4 * k + i] + 4 * half;
            out[4 * half + i] = vf_gather_blocks(from);
        }
        vf_transpose4(out + 4 * half);
    }
}
DAFT_INLINE void vf_scatter_rows8(float *base, const int32_t *row, const vf in[8], vbits lanes)
{
    for (int half = 0; half < 2; half++) {
        float square[4][DAFT_VL] __attribute__((aligned(64)));
        vf r[4] = {in[4 * half], in[4 * half + 1], in[4 * half + 2], in[4 * half + 3]};
        vf_transpose4(r);
        if ((lanes & DAFT_ALL_LANES) == DAFT_ALL_LANES) {
            for (int i = 0; i < 4; i++) {
                float *to[DAFT_VL / 4];
                for (int k = 0; k < DAFT_VL / 4; k++) to[k] = base + 8 * row[4 * k + i] + 4 * half;
                vf_scatter_blocks(to, r[i]);
            }
            continue;
        }
        for (int k = 0; k < 4; k++) vf_store(square[k], r[k]);
        EACH_LANE
        if (lanes >> i & 1) v4_store(base + 8 * row[i] + 4 * half, v4_load(&square[i & 3][i & ~3]));
    }
}
DAFT_INLINE vf vf_load_blocks_at(const float *p, const size_t at[3]);
DAFT_INLINE void vf_load_block_pairs_at(const float *p, const size_t at[3], vf *low, vf *high)
{
    *low = vf_load_blocks_at(p, at), *high = vf_load_blocks_at(p + 4, at);
}
#endif

#ifndef DAFT_NATIVE_8
DAFT_INLINE v8 v8_min(v8 a, v8 b) { return (v8)(((v8i)a & (a < b)) | ((v8i)b & ~(a < b))); }
DAFT_INLINE v8 v8_max(v8 a, v8 b) { return (v8)(((v8i)a & (a > b)) | ((v8i)b & ~(a > b))); }
DAFT_INLINE uint32_t v8_le_bits(v8 a, v8 b)
{
    uint32_t bits = 0;
    for (int i = 0; i < 8; i++) bits |= (uint32_t)(a[i] <= b[i]) << i;
    return bits;
}
#endif

#ifndef DAFT_NATIVE_8_LANES
typedef union v8_pair {
    v8 whole;
    v4 half[2];
} v8_pair;
DAFT_INLINE v4 v8_lower_half(v8 a) { return ((v8_pair){a}).half[0]; }
DAFT_INLINE v4 v8_upper_half(v8 a) { return ((v8_pair){a}).half[1]; }
DAFT_INLINE v8 v8_combine(v4 high, v4 low) { return ((v8_pair){.half = {low, high}}).whole; }
DAFT_INLINE v8i v8i_table_lookup(v8i table, v8i index)
{
    v8i out;
    for (int i = 0; i < 8; i++) out[i] = table[index[i]];
    return out;
}
#endif

#ifndef DAFT_NATIVE_SET_BITS
DAFT_INLINE uint32_t v8i_store_set_bits(uint32_t *out, uint32_t bits, int32_t first)
{
    uint32_t *to = out;
    for (uint32_t left = bits; left; left &= left - 1) *to++ = (uint32_t)(first + __builtin_ctz(left));
    return (uint32_t)(to - out);
}
#endif

#ifndef DAFT_NATIVE_4
DAFT_INLINE v4 v4_sqrt(v4 a) { return (v4){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])}; }
DAFT_INLINE v4 v4_min(v4 a, v4 b) { return (v4)(((v4i)a & (a < b)) | ((v4i)b & ~(a < b))); }
DAFT_INLINE v4 v4_max(v4 a, v4 b) { return (v4)(((v4i)a & (a > b)) | ((v4i)b & ~(a > b))); }
DAFT_INLINE v4i v4i_convert_to(v4 a)
{
    v4i fits = (a >= -0x1p31f) & (a < 0x1p31f);
    return (__builtin_convertvector((v4)((v4i)a & fits), v4i) & fits) | (INT32_MIN & ~fits);
}
DAFT_INLINE uint32_t v4_bits_from_mask(v4i m)
{
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++) bits |= ((uint32_t)m[i] >> 31) << i;
    return bits;
}
DAFT_INLINE v4 v4_promote(const uint8_t p[4]) { return (v4){p[0], p[1], p[2], p[3]}; }
DAFT_INLINE void v4_demote(v4 a, uint8_t p[4])
{
    for (int i = 0; i < 4; i++) p[i] = a[i] > 0 ? a[i] < 255 ? (uint8_t)a[i] : 255 : 0;
}
DAFT_INLINE void v4_transpose3(v4 a, v4 b, v4 c, v4 *x, v4 *y, v4 *z)
{
    *x = (v4){a[0], b[0], c[0], 0}, *y = (v4){a[1], b[1], c[1], 0}, *z = (v4){a[2], b[2], c[2], 0};
}
#endif

#ifndef DAFT_NATIVE_8_BYTES
DAFT_INLINE v8 v8_promote(const uint8_t p[8]) { return v8_combine(v4_promote(p + 4), v4_promote(p)); }
DAFT_INLINE void v8_demote(v8 a, uint8_t p[8])
{
    v4_demote(v8_lower_half(a), p);
    v4_demote(v8_upper_half(a), p + 4);
}
#endif

#ifndef DAFT_NATIVE_BYTES
DAFT_INLINE uint32_t vu8_nondigits_16(const char *p)
{
    uint32_t bits = 0;
    for (int i = 0; i < 16; i++) bits |= (uint32_t)((unsigned)(p[i] - '0') > 9) << i;
    return bits;
}
DAFT_INLINE uint64_t vu8_test_bit(const uint8_t bytes[64], uint32_t count, int k)
{
    uint64_t bits = 0;
    for (uint32_t i = 0; i < count; i++) bits |= (uint64_t)(bytes[i] >> k & 1) << i;
    return bits;
}
#endif

#undef EACH_LANE

#endif
