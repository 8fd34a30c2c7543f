#include <stdbool.h>
#include "base/base.h" /* expect: daft.h stands alone */
