/* The kernels of each instruction set; accel.c picks. */
#ifndef DAFT_TRAVERSE_H
#define DAFT_TRAVERSE_H

#include "accel/accel.h"
#include "math/isa.h"

DAFT_KERNEL_DECLARE(daft_accel_kernels, daft_accel);

#endif
