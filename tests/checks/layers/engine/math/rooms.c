#include "math/vec.h"
#include "vec.h"
#include "base/base.h"
#include "image/image.h" /* expect: math/ is below image/ */
#include <math.h>
#include <immintrin.h> /* expect: instruction sets are math/simd/'s */
#ifdef DAFT_ISA_avx2 /* expect: instruction sets are math/simd/'s */
__m256 wide; /* expect: instruction sets are math/simd/'s */
#endif
static int four(float *p) { return _mm_loadu_ps(p)[0] > 0; } /* expect: instruction sets are math/simd/'s */
static void wait(void) { __builtin_ia32_pause(); } /* expect: instruction sets are math/simd/'s */
int isas[DAFT_ISA_COUNT]; /* in a comment: _mm_loadu_ps(p) */
