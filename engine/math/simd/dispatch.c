/* The instruction sets of the build and of the processor. */
#include "math/simd/dispatch.h"

#include <string.h>

enum { KNOWN = 4 };
static const char *const NAMES[KNOWN] = {"plain", "sse2", "avx2", "avx512"};

/* By number in this build: its place in NAMES. */
static const int BUILT[DAFT_ISA_COUNT] = {
#ifdef DAFT_BUILDS_plain
    0,
#endif
#ifdef DAFT_BUILDS_sse2
    1,
#endif
#ifdef DAFT_BUILDS_avx2
    2,
#endif
#ifdef DAFT_BUILDS_avx512
    3,
#endif
};

/* The place in NAMES of the widest that the processor has. */
static int processor_best(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_cpu_init();
    /* The wider kernels use both; every processor with AVX2 that was ever built has them, machines that imitate one may
     * not. */
    if (!__builtin_cpu_supports("bmi") || !__builtin_cpu_supports("bmi2")) return 1;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
        return 3;
    return __builtin_cpu_supports("avx2") ? 2 : 1;
#else
    return 0;
#endif
}

int daft_isa_best(void)
{
    int isa = DAFT_ISA_COUNT - 1, has = processor_best();
    while (isa > 0 && BUILT[isa] > has) isa--;
    return isa;
}

const char *daft_isa_name(int isa) { return isa >= 0 && isa < DAFT_ISA_COUNT ? NAMES[BUILT[isa]] : "unknown"; }
const char *daft_isa_names(void) { return "plain, sse2, avx2, avx512"; }

daft_isa_status daft_isa_find(const char *name, int *isa)
{
    int known = 0, built = 0;
    *isa = daft_isa_best();
    if (!name) return DAFT_ISA_READY;
    while (known < KNOWN && strcmp(name, NAMES[known]) != 0) known++;
    if (known == KNOWN) return DAFT_ISA_UNKNOWN;
    while (built < DAFT_ISA_COUNT && BUILT[built] != known) built++;
    if (built == DAFT_ISA_COUNT) return DAFT_ISA_NOT_BUILT;
    if (built > *isa) return DAFT_ISA_UNSUPPORTED;
    *isa = built;
    return DAFT_ISA_READY;
}
