/* Public headers: broad.h */
#include "math/simd/ops.h"
