/* expect: engine/ has no room called attic */
#include "daft.h"
