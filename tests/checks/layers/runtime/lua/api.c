#include "../loop.h"
#include "api.h"
#include "../../engine/daft.h"
#include "../../engine/sim/sim.h" /* expect: runtime/ uses nothing of engine/ but daft.h */
