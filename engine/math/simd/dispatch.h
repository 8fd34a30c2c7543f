/* Which instruction set a source is compiled for. A file named *_kernel.c is compiled once for each one of the build's
 * (CMake's DAFT_ISAS), with DAFT_ISA and DAFT_ISA_<name> set; DAFT_KERNEL(name) gives its functions names that differ.
 * The choice is made once, at start-up. It changes speed, never a result. */
#ifndef DAFT_DISPATCH_H
#define DAFT_DISPATCH_H

#include <stdbool.h>

/* Numbers of the instruction sets that this build has kernels for, from the narrowest to the widest. */
enum {
#ifdef DAFT_BUILDS_plain
    DAFT_ISA_PLAIN, /* no vector instruction asked for by name: for machines without a target of their own, and for
                       tests */
#endif
#ifdef DAFT_BUILDS_sse2
    DAFT_ISA_SSE2,
#endif
#ifdef DAFT_BUILDS_avx2
    DAFT_ISA_AVX2,
#endif
#ifdef DAFT_BUILDS_avx512
    DAFT_ISA_AVX512,
#endif
    DAFT_ISA_COUNT
};

#ifdef DAFT_ISA
#define DAFT_PASTE2(a, b) a##_##b
#define DAFT_PASTE(a, b)  DAFT_PASTE2(a, b)
#define DAFT_KERNEL(name) DAFT_PASTE(name, DAFT_ISA)
#endif

/* `name` of each of them, by its number; and the declaration of all. */
#define DAFT_KERNEL_TABLE(name)                                                                                        \
    {                                                                                                                  \
        DAFT_IF_PLAIN(name##_plain) DAFT_IF_SSE2(name##_sse2) DAFT_IF_AVX2(name##_avx2) DAFT_IF_AVX512(name##_avx512)  \
    }
#define DAFT_KERNEL_DECLARE(type, name) extern const type name##_plain, name##_sse2, name##_avx2, name##_avx512
#ifdef DAFT_BUILDS_plain
#define DAFT_IF_PLAIN(name) &name,
#else
#define DAFT_IF_PLAIN(name)
#endif
#ifdef DAFT_BUILDS_sse2
#define DAFT_IF_SSE2(name) &name,
#else
#define DAFT_IF_SSE2(name)
#endif
#ifdef DAFT_BUILDS_avx2
#define DAFT_IF_AVX2(name) &name,
#else
#define DAFT_IF_AVX2(name)
#endif
#ifdef DAFT_BUILDS_avx512
#define DAFT_IF_AVX512(name) &name,
#else
#define DAFT_IF_AVX512(name)
#endif

/* The widest that this build and this processor have: all narrower ones work, too. */
int daft_isa_best(void);
/* "unknown" of numbers that are none. */
const char *daft_isa_name(int isa);

typedef enum daft_isa_status {
    DAFT_ISA_READY,
    DAFT_ISA_UNKNOWN,     /* no instruction set's name */
    DAFT_ISA_NOT_BUILT,   /* this build has no kernels for it */
    DAFT_ISA_UNSUPPORTED, /* this processor does not have it */
} daft_isa_status;

/* The number by name: "plain", "sse2", "avx2", "avx512"; NULL gives the best. *isa is set in all cases, to the best but
 * for READY. */
daft_isa_status daft_isa_find(const char *name, int *isa);
static inline bool daft_isa_parse(const char *name, int *isa) { return daft_isa_find(name, isa) == DAFT_ISA_READY; }
/* All names, as in "plain, sse2, avx2, avx512". */
const char *daft_isa_names(void);

#endif
