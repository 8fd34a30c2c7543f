#include "render/render.h"
#include "sim/sim.h"
#include "base/base.h"
#include "../attic/attic.h" /* expect: engine/ has no room called attic */
