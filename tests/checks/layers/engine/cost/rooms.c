#include "shade/shade.h"
#include "render/render.h" /* expect: cost/ is below render/ */
