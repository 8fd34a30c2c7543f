#include "query.h" /* expect: no cycles between files */
