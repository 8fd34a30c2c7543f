#include "cost/cost.h"
#include "raster/raster.h"
#include "scene/scene.h" /* expect: render/ is below scene/ */
#include "sim/sim.h" /* expect: render/ and sim/ are siblings */
