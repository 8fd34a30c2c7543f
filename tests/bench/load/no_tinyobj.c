/* Where tinyobjloader or a C++ compiler is not installed. */
#include "harness/bench.h"

bench_obj_loader *bench_find_tinyobj(void) { return NULL; }
