/* Public headers: solve.h */
#include "sim/query/walk.h" /* expect: it is private to engine/sim/query/ */
#include "sim/sim.h"
#include "sim/world.h"
#include "sim/state.h" /* expect: it is private to engine/sim/ */
#include "sim/broad/broad.h"
