/* Picks the kernels of an instruction set. */
#include "shade/kernels.h"

const daft_shade_kernels *daft_shade_kernels_for(int isa)
{
    static const daft_shade_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_shade);
    return TABLE[isa];
}
