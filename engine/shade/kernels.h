/* The kernels of each instruction set; shade.c picks. */
#ifndef DAFT_SHADE_KERNELS_H
#define DAFT_SHADE_KERNELS_H

#include "math/simd/dispatch.h"
#include "shade/shade.h"

DAFT_KERNEL_DECLARE(daft_shade_kernels, daft_shade);

#endif
