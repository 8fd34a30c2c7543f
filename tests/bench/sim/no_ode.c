/* Where ODE is not installed. */
#include "sim_scenes.h"

const sim_engine *bench_find_ode(void) { return NULL; }
