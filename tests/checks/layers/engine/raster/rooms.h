#include "accel/accel.h"
#include "shade/shade.h" /* expect: raster/ and shade/ are siblings */
#include "render/render.h" /* expect: raster/ is below render/ */
