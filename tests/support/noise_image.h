/* Pictures for tests whose content does not matter, as long as it differs everywhere. */
#ifndef NOISE_IMAGE_H
#define NOISE_IMAGE_H

#include "image/image.h"
#include "support_content.h"

/* Random colours, opaque, from `allocator`; to be freed by daft_image_free(). */
static inline daft_image noise_image(const daft_allocator *allocator, int width, int height)
{
    daft_image image = {.allocator = *allocator,
                        .width = width,
                        .height = height,
                        .pixels = daft_alloc(allocator, (size_t)(width * height), 4)};
    for (int i = 0; i < 4 * width * height; i++) image.pixels[i] = (i & 3) == 3 ? 255 : (uint8_t)random_below(256);
    return image;
}

#endif
