/* The functions of texture_kernel.c for anisotropic filters. */
#define TEXTURES_ALONG true
#define TEXTURES(name) DAFT_KERNEL(name##_along)
#include "shade/texture_kernel.c" /* NOLINT(bugprone-suspicious-include): one source, compiled twice */
