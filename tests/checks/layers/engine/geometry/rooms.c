#include "math/vec.h"
#include "../image/image.h" /* expect: geometry/ and image/ are siblings */
#include "accel/accel.h" /* expect: geometry/ is below accel/ */
