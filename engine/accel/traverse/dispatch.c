#include "accel/accel.h"
#include "accel/traverse/traverse.h"

const daft_accel_kernels *daft_accel_kernels_for(int isa)
{
    static const daft_accel_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_accel);
    return TABLE[isa];
}
