#include "accel/accel.h"
#include "image/image.h"
#include "raster/raster.h" /* expect: shade/ and raster/ are siblings */
