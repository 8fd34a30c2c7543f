#include "image/image.h"
#include <stb_image.h>
#include "geometry/mesh.h" /* expect: image/ and geometry/ are siblings */
