/* Enlarging in bands of rows: what resize.c plans and resize_kernel.c does. Private to image/. */
#ifndef DAFT_RESIZE_H
#define DAFT_RESIZE_H

#include "image/image.h"
#include "math/simd/dispatch.h"

enum { DAFT_RESIZE_TAPS = 4, DAFT_RESIZE_PAD = 2 /* pixels that a mixed row has beyond each of its ends */ };

/* A target's row: the source's rows about it; the middle two are those on either side. */
typedef struct daft_resize_row {
    int at[DAFT_RESIZE_TAPS];
    float weight[DAFT_RESIZE_TAPS];
} daft_resize_row;

/* Two neighbouring pixels of a target's row: the first of the source's pixels about each, counted with the pad, and the
 * weights of all, each four times, for the four channels. */
typedef struct daft_resize_pair {
    int at[2];
    float weight[DAFT_RESIZE_TAPS][8];
} daft_resize_pair;

typedef struct daft_resize {
    const daft_image *from;
    daft_image *to;
    bool wide; /* the outer two have weights, too */
    const daft_resize_row *rows;
    const daft_resize_pair *pairs; /* (to->width + 1) / 2 */
} daft_resize;

typedef struct daft_resize_kernels {
    /* The target's rows first .. end - 1. row: 4 · (from->width + 2 · DAFT_RESIZE_PAD) floats of scratch. */
    void (*enlarge)(const daft_resize *r, int first, int end, float *row);
} daft_resize_kernels;

DAFT_KERNEL_DECLARE(daft_resize_kernels, daft_resize);

#endif
