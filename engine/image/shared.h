/* What texture.c and sky.c know of shared images. */
#ifndef DAFT_SHARED_H
#define DAFT_SHARED_H

#include "image/image.h"

/* Another holder of what is shared has gone; the last one frees it. */
void daft_shared_image_release(const daft_allocator *allocator, daft_shared_image *shared);

#endif
