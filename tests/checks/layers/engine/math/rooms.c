#include "math/vec.h"
#include "vec.h"
#include "base/base.h"
#include "image/image.h" /* expect: math/ is below image/ */
#include <math.h>
