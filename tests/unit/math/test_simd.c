/* Each operation of math/simd/ops.h, on each target that this processor has, against a scalar twin: bit for bit, for
 * random numbers of all sizes with zeros of both signs, denormals, infinities, NaN and the ends of the integers among
 * them. And the elementary functions: the same bits in every width, and no more than the errors that elementary.h
 * states. DAFT_SEED=N repeats a run. */
#include "simd_ops.h"

#include "math/simd/dispatch.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <math.h>

enum { ROUNDS = 20000 };

static const char *const NAMES[SIMD_COUNT] = {
#define OP_NAME(name, kind) #name,
    SIMD_OPS(OP_NAME)};
static const char KINDS[SIMD_COUNT] = {
#define OP_KIND(name, kind) kind,
    SIMD_OPS(OP_KIND)};

/* ---- the targets that this processor can run ---- */

static int targets(const simd_target *out[4])
{
    int count = 0;
    out[count++] = &simd_target_plain;
#if defined(__x86_64__)
    __builtin_cpu_init();
    out[count++] = &simd_target_sse2;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2")) out[count++] = &simd_target_avx2;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
        out[count++] = &simd_target_avx512;
#endif
    return count;
}

/* ---- input ---- */

static uint64_t random_state;

static uint64_t random64(void) /* splitmix64 */
{
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static float float_of(uint32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static float random_any(void)
{
    static const float HARD[] = {0,
                                 -0.0f,
                                 INFINITY,
                                 -INFINITY,
                                 NAN,
                                 0x1p-149f,
                                 -0x1p-149f,
                                 0x1.fffffcp-127f,
                                 0x1p-126f,
                                 0x1.fffffep127f,
                                 1,
                                 -1,
                                 0.5f,
                                 -0.5f,
                                 0x1p31f,
                                 -0x1p31f,
                                 0x1.fffffep30f,
                                 -0x1.000002p31f,
                                 0x1p32f,
                                 -0x1p63f,
                                 0x1.fffffep23f,
                                 0x1.fffffep-1f,
                                 1.5f,
                                 -2.5f};
    uint64_t r = random64();
    if (r % 4 == 0) return HARD[(r >> 8) % (sizeof HARD / sizeof *HARD)];
    if (r % 4 == 1) return (float)(int32_t)(r >> 32) * 0x1p-24f;
    if (r % 4 == 2) return (float)(int32_t)(r >> 32) * 2;
    return float_of((uint32_t)(r >> 32));
}

static float random_real(void)
{
    float f = random_any();
    return isnan(f) ? 3 : f;
}

static double random_double(void)
{
    uint64_t r = random64();
    if (r % 2) return (double)random_any();
    double d;
    r = random64();
    memcpy(&d, &r, sizeof d);
    return d;
}

static int32_t random_int(void)
{
    static const int32_t HARD[] = {0, 1, -1, INT32_MAX, INT32_MIN, INT32_MIN + 1, 1 << 24, (1 << 24) + 1};
    uint64_t r = random64();
    return r % 4 == 0 ? HARD[(r >> 8) % 8] : r % 4 == 1 ? (int32_t)(r >> 32) % 8 : (int32_t)(r >> 32);
}

static void choose_rows(simd_in *in)
{
    int32_t row[SIMD_ROWS];
    for (int i = 0; i < SIMD_ROWS; i++) row[i] = i;
    for (int i = 0; i < 16; i++) {
        int k = i + (int)(random64() % (uint64_t)(SIMD_ROWS - i));
        in->row[i] = row[k], row[k] = row[i];
    }
    for (int i = 0; i < 3; i++) in->at[i] = 4 * (size_t)(random64() % (2 * SIMD_ROWS - 4));
}

static void choose(simd_in *in)
{
    for (int i = 0; i < 16; i++) {
        in->a[i] = random_any(), in->b[i] = random64() % 8 ? random_any() : in->a[i];
        for (int k = 0; k < 4; k++) in->real[k][i] = random_real();
        in->normal[i] = float_of((uint32_t)((2 + random64() % 250) << 23 | (random64() & 0x7fffff)));
        in->i[i] = random_int(), in->j[i] = random64() % 4 ? random_int() : in->i[i],
        in->m[i] = random64() % 2 ? -1 : 0;
        in->d[i] = random_double(), in->e[i] = random64() % 8 ? random_double() : in->d[i];
    }
    for (int i = 0; i < 64; i++)
        in->bytes[i] = (uint8_t)random64(), in->text[i] = (char)(random64() % 2 ? '0' + random64() % 10 : random64());
    for (int i = 0; i < 8 * SIMD_ROWS; i++) in->rows[i / 8][i % 8] = random_any();
    for (int i = 0; i < 256; i++) in->table[i] = random_any();
    for (int i = 0; i < 257; i++) in->words[i] = (uint16_t)(i * 40503 + 77);
    in->bits = (uint32_t)random64(), in->n = (int)(random64() % 21);
    choose_rows(in);
}

/* ---- twins ---- */

#define TWIN(name) static void name##_twin(const simd_in *in, simd_out *out)
#define LANES      for (int i = 0; i < in->lanes; i++)
#define HALF       for (int i = 0; i < in->lanes / 2; i++)
#define FOUR       for (int i = 0; i < 4; i++)
#define EIGHT      for (int i = 0; i < 8; i++)
#define BITS(condition)                                                                                                \
    uint32_t bits = 0;                                                                                                 \
    LANES bits |= (uint32_t)((condition) ? 1 : 0) << i;                                                                \
    out->u[0] = bits

/* A float of the rows, counted through them. */
static float row_at(const simd_in *in, int i) { return in->rows[i / 8][i % 8]; }
static float min_of(float a, float b) { return a < b ? a : b; }
static float max_of(float a, float b) { return a > b ? a : b; }
static int32_t integer_of(float a) { return a >= -0x1p31f && a < 0x1p31f ? (int32_t)a : INT32_MIN; }

TWIN(vf_load) { LANES out->f[i] = in->a[i + 1 - in->lanes / 16]; }
TWIN(vi_load) { LANES out->i[i] = in->i[i]; }
TWIN(vd_load) { HALF out->d[i] = in->d[i + 1]; }
TWIN(v8_load) { EIGHT out->f[i] = in->a[i + 3]; }
TWIN(v4_load) { FOUR out->f[i] = in->a[i + 3]; }
TWIN(vi_iota) { LANES out->i[i] = i; }
TWIN(vf_set) { LANES out->f[i] = in->real[0][0]; }
TWIN(vi_set) { LANES out->i[i] = in->i[0]; }
TWIN(vd_set) { HALF out->d[i] = in->d[0]; }
TWIN(v8_set) { EIGHT out->f[i] = in->a[0]; }
TWIN(v4_set) { FOUR out->f[i] = in->a[0]; }

TWIN(vf_lt) { BITS(in->a[i] < in->b[i]); }
TWIN(vf_le) { BITS(in->a[i] <= in->b[i]); }
TWIN(vi_eq) { BITS(in->i[i] == in->j[i]); }
TWIN(vi_lt) { BITS(in->i[i] < in->j[i]); }
TWIN(vm_and) { BITS(in->m[i] && (in->bits >> i & 1)); }
TWIN(vm_or) { BITS(in->m[i] || (in->bits >> i & 1)); }
TWIN(vm_not) { BITS(!in->m[i]); }
TWIN(vm_from_bits) { BITS(in->bits >> i & 1); }
TWIN(vbits_first_n) { BITS(i < in->n); }
TWIN(vf_if_then_else) { LANES out->f[i] = in->m[i] ? in->a[i] : in->b[i]; }
TWIN(vi_if_then_else) { LANES out->i[i] = in->m[i] ? in->i[i] : in->j[i]; }
TWIN(vd_if_then_else) { HALF out->d[i] = in->d[i] < in->e[i] ? in->d[i] : in->e[i]; }
TWIN(v4_if_then_else) { FOUR out->f[i] = in->m[i] ? in->a[i] : in->b[i]; }

TWIN(vf_min) { LANES out->f[i] = min_of(in->a[i], in->b[i]); }
TWIN(vf_max) { LANES out->f[i] = max_of(in->a[i], in->b[i]); }
TWIN(vf_max_abs) { LANES out->f[i] = max_of(fabsf(in->a[i]), fabsf(in->b[i])); }
TWIN(vf_sqrt) { LANES out->f[i] = sqrtf(in->a[i]); }
TWIN(vf_abs) { LANES out->f[i] = fabsf(in->a[i]); }
TWIN(vf_xor)
{
    LANES
    {
        uint32_t a;
        memcpy(&a, &in->a[i], sizeof a);
        out->u[i] = a ^ (uint32_t)in->i[i];
    }
}
TWIN(vf_clamp01) { LANES out->f[i] = min_of(max_of(in->a[i], 0), 1); }
TWIN(vf_floor) { LANES out->f[i] = floorf(fabsf(in->a[i]) < 0x1p31f ? in->a[i] : 0.5f) + 0; }
TWIN(vf_reduce_min)
{
    float least = in->real[0][0];
    LANES least = fminf(least, in->real[0][i]);
    out->f[0] = least + 0;
}
TWIN(vf_reduce_max)
{
    float most = in->real[0][0];
    LANES most = fmaxf(most, in->real[0][i]);
    out->f[0] = most + 0;
}
TWIN(vi_convert_to) { LANES out->i[i] = integer_of(in->a[i]); }
TWIN(vf_convert_to) { LANES out->f[i] = (float)in->i[i]; }
TWIN(vf_column) { LANES out->f[i] = (float)(i % 4); }
TWIN(vf_row) { LANES out->f[i] = (float)(i / 4); }
TWIN(vf3_dot)
{
    LANES out->f[i] = in->a[i] * in->b[i] + in->real[0][i] * in->real[2][i] + in->real[1][i] * in->real[3][i];
}

TWIN(vd_promote_half) { LANES out->d[i] = (double)in->a[i]; }
TWIN(vf_demote2) { HALF out->f[i] = (float)in->d[i], out->f[i + in->lanes / 2] = (float)in->e[i]; }
TWIN(vd_sqrt) { HALF out->d[i] = sqrt(in->d[i]); }
TWIN(vd_max) { HALF out->d[i] = in->d[i] > in->e[i] ? in->d[i] : in->e[i]; }
TWIN(vd_abs) { HALF out->d[i] = fabs(in->d[i]); }
TWIN(vd_step) { HALF out->d[i] = in->d[i] > 0 ? 1 : 0; }

TWIN(vf_gather_index) { LANES out->f[i] = row_at(in, in->i[i] & 127); }
TWIN(vi_gather_index) { LANES out->f[i] = row_at(in, in->i[i] & 127); }
TWIN(vf_table_lookup) { LANES out->f[i] = in->a[in->i[i] & (in->lanes - 1)]; }
TWIN(vf_table_lookup16) { LANES out->f[i] = in->a[in->i[i] & 15]; }
TWIN(vf_table_lookup32) { LANES out->f[i] = in->table[in->i[i] & 31]; }
TWIN(vi_gather_pairs)
{
    LANES out->f[i] = row_at(in, in->i[i] & 127), out->f[in->lanes + i] = row_at(in, (in->i[i] & 127) + 1);
}
TWIN(vf_table_lookup_bytes)
{
    for (int k = 0; k < 3; k++)
        LANES out->f[k * in->lanes + i] = in->words[in->i[i] >> 8 * k & 255],
                                     out->f[(3 + k) * in->lanes + i] = in->words[in->j[i] >> 8 * k & 255];
}
TWIN(vf_load_expand)
{
    int count = 0;
    LANES out->f[i] = in->bits >> i & 1 ? in->a[count++] : 0;
}
TWIN(vf_compress_store)
{
    int count = 0;
    LANES if (in->bits >> i & 1) out->f[count++] = in->a[i];
    LANES out->f[32 + i] = in->b[i]; /* what lies behind is as it was */
}
TWIN(vi_compress_store)
{
    int count = 0;
    LANES if (in->bits >> i & 1) out->i[count++] = in->i[i];
}

TWIN(vf_gather_blocks) { LANES out->f[i] = (&in->rows[in->row[i / 4]][1])[i % 4]; }
TWIN(vf_scatter_blocks) { LANES out->f[8 * in->row[i / 4] + 4 + i % 4] = in->a[i]; }
TWIN(vf_load_blocks) { LANES out->f[i] = row_at(in, 3 + i / 4 * in->n + i % 4); }
TWIN(vf_store_blocks) { LANES out->f[3 + i / 4 * (4 + in->n) + i % 4] = in->a[i]; }
static const float *block(const simd_in *in, int k) { return in->rows[1] + (k ? in->at[k - 1] : 0); }
TWIN(vf_load_blocks_at) { LANES out->f[i] = block(in, i / 4)[i % 4]; }
TWIN(vf_load_block_pairs_at)
{
    LANES out->f[i] = block(in, i / 4)[i % 4], out->f[in->lanes + i] = block(in, i / 4)[4 + i % 4];
}
TWIN(vf_load_eights)
{
    for (int i = 0; i < (in->lanes > 8 ? in->lanes : 8); i++) out->f[i] = in->rows[in->row[i / 8]][i % 8];
}
TWIN(vf_transpose4)
{
    for (int k = 0; k < 4; k++) LANES out->f[k * in->lanes + i] = in->real[i % 4][(i & ~3) + k];
}
TWIN(vf_gather_rows4)
{
    for (int k = 0; k < 4; k++) LANES out->f[k * in->lanes + i] = in->rows[in->row[i]][3 + k];
}
TWIN(vf_gather_rows8)
{
    for (int k = 0; k < 8; k++) LANES out->f[k * in->lanes + i] = in->rows[in->row[i]][k];
}
static float member(const simd_in *in, int k, int i) { return k < 4 ? in->real[k][i] : -in->real[k - 4][i]; }
TWIN(vf_scatter_rows8)
{
    for (int k = 0; k < 8; k++)
        LANES if (!(in->n % 3) || (in->bits >> i & 1)) out->f[8 * in->row[i] + k] = member(in, k, i);
}
TWIN(vf_store_interleaved8)
{
    for (int k = 0; k < 8; k++) LANES out->f[i * (in->lanes == 16 ? 8 : 12) + k] = member(in, k, i);
}

TWIN(v8_min) { EIGHT out->f[i] = min_of(in->a[i], in->b[i]); }
TWIN(v8_max) { EIGHT out->f[i] = max_of(in->a[i], in->b[i]); }
static uint32_t eight_bits(const bool on[8])
{
    uint32_t bits = 0;
    EIGHT bits |= (uint32_t)on[i] << i;
    return bits;
}
TWIN(v8_le_bits)
{
    bool on[8];
    EIGHT on[i] = in->a[i] <= in->b[i];
    out->u[0] = eight_bits(on);
}
TWIN(v8_eq_bits)
{
    bool on[8];
    EIGHT on[i] = in->a[i] == in->b[i];
    out->u[0] = eight_bits(on);
}
TWIN(v8_bits_from_mask)
{
    bool on[8];
    EIGHT on[i] = in->m[i];
    out->u[0] = eight_bits(on);
}
TWIN(v8_lower_half) { FOUR out->f[i] = in->a[i]; }
TWIN(v8_upper_half) { FOUR out->f[i] = in->a[4 + i]; }
TWIN(v8_combine) { FOUR out->f[i] = in->b[i], out->f[4 + i] = in->a[i]; }
TWIN(v8i_table_lookup) { EIGHT out->f[i] = in->a[in->i[i] & 7]; }
TWIN(v8i_store_set_bits)
{
    uint32_t count = 0;
    EIGHT if (in->bits >> i & 1) out->i[1 + count++] = (in->i[0] >> 8) + i;
    out->u[0] = count;
}

TWIN(v4_min) { FOUR out->f[i] = min_of(in->a[i], in->b[i]); }
TWIN(v4_max) { FOUR out->f[i] = max_of(in->a[i], in->b[i]); }
TWIN(v4_sqrt) { FOUR out->f[i] = sqrtf(in->a[i]); }
TWIN(v4_abs) { FOUR out->f[i] = fabsf(in->a[i]); }
TWIN(v4i_convert_to) { FOUR out->i[i] = integer_of(in->a[i]); }
TWIN(v4_promote) { FOUR out->f[i] = (float)in->bytes[i]; }
static uint32_t byte_of(float a) { return a > 255 ? 255 : a > 0 ? (uint32_t)a : 0; }
TWIN(v4_demote)
{
    out->u[0] = 0;
    FOUR out->u[0] |= byte_of(in->a[i]) << 8 * i;
}
TWIN(v8_promote) { EIGHT out->f[i] = (float)in->bytes[i]; }
TWIN(v8_demote)
{
    out->u[0] = out->u[1] = 0;
    EIGHT out->u[i / 4] |= byte_of(in->a[i]) << 8 * (i % 4);
}
TWIN(v4_bits_from_mask)
{
    out->u[0] = 0;
    FOUR out->u[0] |= (uint32_t)(in->m[i] & 1) << i;
}
TWIN(v4_transpose3)
{
    for (int i = 0; i < 3; i++)
        out->f[3 * i] = in->a[i], out->f[3 * i + 1] = in->b[i], out->f[3 * i + 2] = in->real[0][i];
}
TWIN(v4_reduce_min4)
{
    for (int k = 0; k < 4; k++) {
        float least = in->real[k][0];
        LANES least = fminf(least, in->real[k][i]);
        out->f[k] = least + 0;
    }
}
static uint64_t nondigits(const char *p, int count)
{
    uint64_t bits = 0;
    for (int i = 0; i < count; i++) bits |= (uint64_t) !(p[i] >= '0' && p[i] <= '9') << i;
    return bits;
}
TWIN(vu8_nondigits_16) { out->u[0] = (uint32_t)nondigits(in->text + 1, 16); }
TWIN(vu8_nondigits_32) { out->u[0] = (uint32_t)nondigits(in->text + 1, 32); }
TWIN(vu8_nondigits_64) { out->q[0] = nondigits(in->text, 64); }
TWIN(vu8_test_bit)
{
    out->q[0] = 0;
    for (int i = 0; i < 3 * in->n; i++) out->q[0] |= (uint64_t)(in->bytes[i] >> in->n % 8 & 1) << i;
}

static simd_op *const TWINS[SIMD_COUNT] = {
#define OP_TWIN(name, kind) name##_twin,
    SIMD_OPS(OP_TWIN)};

/* ---- the comparison ---- */

static void unify_nan(char kind, simd_out *out)
{
    if (kind == 'f')
        for (int i = 0; i < 8 * SIMD_ROWS; i++)
            if (isnan(out->f[i])) out->u[i] = 0x7fc00000;
    if (kind == 'd')
        for (int i = 0; i < 4 * SIMD_ROWS; i++)
            if (isnan(out->d[i])) out->q[i] = UINT64_C(0x7ff8000000000000);
}

static void compare(const simd_target *target, int op, const simd_in *in)
{
    simd_out got, want;
    memset(&got, 0x5a, sizeof got), memset(&want, 0x5a, sizeof want);
    target->op[op](in, &got), TWINS[op](in, &want);
    unify_nan(KINDS[op], &got), unify_nan(KINDS[op], &want);
    for (int i = 0; i < 8 * SIMD_ROWS; i++)
        if (got.u[i] != want.u[i])
            fail_msg("%s on %s: word %d is 0x%08x (%g), not 0x%08x (%g)", NAMES[op], target->name, i, got.u[i],
                     (double)got.f[i], want.u[i], (double)want.f[i]);
}

static void operations_are_their_twins(void **state)
{
    (void)state;
    const simd_target *target[4];
    int count = targets(target);
    for (int round = 0; round < ROUNDS; round++) {
        simd_in in;
        choose(&in);
        for (int t = 0; t < count; t++) {
            in.lanes = target[t]->lanes;
            for (int op = 0; op < SIMD_COUNT; op++) compare(target[t], op, &in);
        }
    }
    for (int t = 0; t < count; t++)
        print_message("%s: %d operations on %d lanes\n", target[t]->name, SIMD_COUNT, target[t]->lanes);
}

static void approximate_reciprocals_keep_their_bound(void **state)
{
    (void)state;
    const simd_target *target[4];
    int count = targets(target);
    for (int round = 0; round < ROUNDS; round++) {
        simd_in in;
        choose(&in);
        for (int t = 0; t < count; t++) {
            simd_out out;
            target[t]->approximate_reciprocal(&in, &out);
            for (int i = 0; i < target[t]->lanes; i++) {
                double a = (double)in.normal[i];
                if (!(fabs((double)out.f[i] * a - 1) <= 0x1p-11))
                    fail_msg("%s: the reciprocal of %a is %a", target[t]->name, a, (double)out.f[i]);
            }
        }
    }
}

/* ---- elementary functions ---- */

typedef struct elementary {
    float log2[16], exp2[16], asin[16], pow[16], atan2[16];
} elementary;

static elementary all_of(const simd_target *t, const float x[6][16])
{
    elementary e;
    t->log2(x[0], e.log2), t->exp2(x[1], e.exp2), t->asin(x[2], e.asin);
    t->pow(x[3], x[4], e.pow), t->atan2(x[5], x[1], e.atan2);
    return e;
}

static double uniform(double low, double high) { return low + (high - low) * (double)(random64() >> 11) * 0x1p-53; }

static void within(const char *what, double x, float got, double want, double error)
{
    if (!(fabs((double)got - want) <= error))
        fail_msg("%s of %a is %.9g, not %.9g: off by %g, not %g", what, x, (double)got, want, fabs((double)got - want),
                 error);
}

static void elementary_functions_keep_their_bounds(void **state)
{
    (void)state;
    const simd_target *target[4];
    int count = targets(target);
    for (int round = 0; round < ROUNDS; round++) {
        float x[6][16];
        for (int i = 0; i < 16; i++) {
            x[0][i] = float_of((uint32_t)((1 + random64() % 254) << 23 | (random64() & 0x7fffff)));
            x[1][i] = (float)uniform(-126, 126), x[2][i] = (float)uniform(-1, 1),
            x[3][i] = random64() % 16 ? (float)uniform(0, 1) : 0;
            x[4][i] = random64() % 16 ? (float)uniform(0, 200) : 0,
            x[5][i] = random64() % 16 ? (float)uniform(-300, 300) : 0;
        }
        elementary first = all_of(target[0], x);
        for (int t = 1; t < count; t++) {
            elementary other = all_of(target[t], x);
            if (memcmp(&first, &other, sizeof first) != 0)
                fail_msg("elementary functions differ: plain and %s", target[t]->name);
        }
        for (int i = 0; i < 16; i++) {
            double l = log2((double)x[0][i]), e = exp2((double)x[1][i]);
            within("log2", (double)x[0][i], first.log2[i], l, 3e-7 * fmax(1, fabs(l)));
            within("exp2", (double)x[1][i], first.exp2[i], e, 3e-7 * e);
            within("asin", (double)x[2][i], first.asin[i], asin((double)x[2][i]), 1e-6);
            within("atan2", (double)x[5][i], first.atan2[i], atan2((double)x[5][i], (double)x[1][i]), 5e-7);
        }
    }
}

int main(void)
{
    const char *seed = getenv("DAFT_SEED");
    random_state = seed ? strtoull(seed, NULL, 0) : 20240817;
    print_message("seed %llu\n", (unsigned long long)random_state);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(operations_are_their_twins),
        cmocka_unit_test(approximate_reciprocals_keep_their_bound),
        cmocka_unit_test(elementary_functions_keep_their_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
