/* Which instruction set a source is compiled for. A file named *_kernel.c is compiled once for each, with DAFT_ISA set
 * by the build; DAFT_KERNEL(name) gives its functions names that differ. The choice is made once, at start-up. */
#ifndef DAFT_DISPATCH_H
#define DAFT_DISPATCH_H

enum { DAFT_ISA_SSE2 = 0, DAFT_ISA_AVX2, DAFT_ISA_AVX512, DAFT_ISA_COUNT };

#include <stdbool.h>

#ifdef DAFT_ISA
#define DAFT_PASTE2(a, b) a##_##b
#define DAFT_PASTE(a, b) DAFT_PASTE2(a, b)
#define DAFT_KERNEL(name) DAFT_PASTE(name, DAFT_ISA)
#endif

/* One pointer out of three, one for each instruction set this build has. */
#ifdef DAFT_HAVE_X86
#define DAFT_KERNEL_TABLE(name) {&DAFT_PASTE_TABLE(name, sse2), &DAFT_PASTE_TABLE(name, avx2), &DAFT_PASTE_TABLE(name, avx512)}
#define DAFT_KERNEL_DECLARE(type, name) extern const type name##_sse2, name##_avx2, name##_avx512
#else
#define DAFT_KERNEL_TABLE(name) {&DAFT_PASTE_TABLE(name, sse2), &DAFT_PASTE_TABLE(name, sse2), &DAFT_PASTE_TABLE(name, sse2)}
#define DAFT_KERNEL_DECLARE(type, name) extern const type name##_sse2
#endif
#define DAFT_PASTE_TABLE(name, isa) name##_##isa

/* The best this processor has. */
int daft_isa_best(void);
const char *daft_isa_name(int isa);
/* NULL gives the best. False: an unknown name, or one this processor does not have (out is then its number or -1). */
bool daft_isa_parse(const char *name, int *out);

#endif
