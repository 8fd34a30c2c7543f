#include "accel/accel.h"
#include "scene/scene.h" /* expect: sim/ is below scene/ */
#include "render/../render/render.h" /* expect: sim/ and render/ are siblings */
