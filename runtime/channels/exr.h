/* One EXR file of several channels, through OpenEXR's C library. */
#ifndef RUNTIME_CHANNELS_EXR_H
#define RUNTIME_CHANNELS_EXR_H

#include "daft.h"

/* A channel of a picture: floats or unsigned numbers of 32 bits, so many bytes from a pixel to the next, rows packed.
 */
typedef struct exr_channel {
    const char *name;
    const void *first;
    int step;
    bool is_float;
} exr_channel;

/* Channels in the order of their names. */
bool exr_write(const char *path, const exr_channel *channels, int count, int width, int height, daft_error *error);

#endif
