#include "geometry/mesh.h"
#include "raster/raster.h" /* expect: accel/ is below raster/ */
#include "shade/shade.h" /* expect: accel/ is below shade/ */
