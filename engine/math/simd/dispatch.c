#include "math/simd/dispatch.h"

#include <stddef.h>
#include <string.h>

static const char *const NAMES[DAFT_ISA_COUNT] = {"sse2", "avx2", "avx512"};

int daft_isa_best(void)
{
#ifdef DAFT_HAVE_X86
    __builtin_cpu_init();
    /* The wider kernels use both; every processor with AVX2 that was ever built has them, machines that imitate one may not. */
    if (!__builtin_cpu_supports("bmi") || !__builtin_cpu_supports("bmi2")) return DAFT_ISA_SSE2;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
        return DAFT_ISA_AVX512;
    if (__builtin_cpu_supports("avx2")) return DAFT_ISA_AVX2;
#endif
    return DAFT_ISA_SSE2;
}

const char *daft_isa_name(int isa) { return isa >= 0 && isa < DAFT_ISA_COUNT ? NAMES[isa] : "unknown"; }

bool daft_isa_parse(const char *name, int *out)
{
    *out = daft_isa_best();
    if (!name) return true;
    for (int i = 0; i < DAFT_ISA_COUNT; i++) {
        if (strcmp(name, NAMES[i]) != 0) continue;
        bool has = i <= *out;
        *out = i;
        return has;
    }
    *out = -1;
    return false;
}
