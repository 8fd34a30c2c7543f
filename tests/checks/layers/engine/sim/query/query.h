/* Public headers: query.h */
#include "sim/query/walk.h"
