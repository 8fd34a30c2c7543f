/* blur: the mean of several pictures in linear light, for motion blur. */
#ifndef RUNTIME_VIDEO_BLUR_H
#define RUNTIME_VIDEO_BLUR_H

#include "daft.h"

typedef struct blur {
    float *sum;       /* three a pixel, linear light */
    size_t pixels;    /* of a picture */
    int count;        /* pictures so far */
    float light[256]; /* of an sRGB byte */
    float edge[256];  /* the light above which the next byte is nearer */
} blur;

bool blur_open(blur *out, size_t pixels, daft_error *error);
void blur_close(blur *self);
/* Adds a picture, RGBA. */
void blur_add(blur *self, const uint8_t *pixels);
/* The mean of the pictures since the last call, opaque. */
void blur_take(blur *self, uint8_t *pixels);

#endif
