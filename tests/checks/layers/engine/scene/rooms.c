#include "render/render.h"
#include "sim/sim.h"
#include "base/base.h"
#include "../attic/attic.h" /* expect: engine/ has no room called attic */
#include "sim/query/query.h"
#include "sim/world.h" /* expect: it is private to sim/ */
#include "sim/solve/solve.h" /* expect: it is private to sim/ */
#include "math/simd/ops.h"
#include "math/simd/plain.h" /* expect: it is private to math/ */
