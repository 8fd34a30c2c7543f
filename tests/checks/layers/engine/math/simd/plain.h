/* How. */
#include <emmintrin.h>
typedef __m128 native;
