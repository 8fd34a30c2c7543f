/* The kernels of each instruction set; raster.c picks. */
#ifndef DAFT_RASTER_KERNELS_H
#define DAFT_RASTER_KERNELS_H

#include "math/isa.h"
#include "raster/raster.h"

DAFT_KERNEL_DECLARE(daft_raster_kernels, daft_raster);

#endif
