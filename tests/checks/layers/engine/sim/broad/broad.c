#include "sim/solve/solve.h" /* expect: no cycles between rooms */
