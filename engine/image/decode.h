/* Decoding image files: the only user of stb_image. */
#ifndef DAFT_DECODE_H
#define DAFT_DECODE_H

#include "image/image.h"

enum { DAFT_MAX_IMAGE_SIDE = 16384 };

/* Exactly one of the two is set: 4 bytes a pixel, or 3 floats of linear light a pixel for an HDR file. */
typedef struct daft_decoded {
    int width, height;
    uint8_t *bytes;
    float *floats;
} daft_decoded;

/* The file's bytes, the pixels, and what the decoder needs in between come from the caller's allocator. Where that has
 * a limit, the size in the file's header is held against it before anything is decoded. Who takes `bytes` or `floats`
 * over releases them with daft_stb_release. */
/* From memory; `path` names it in messages. */
bool daft_decode_bytes(const daft_allocator *allocator, const void *bytes, size_t size, const char *path,
                       daft_decoded *out, daft_error *error);
bool daft_decode_file(const daft_allocator *allocator, const daft_files *files, const char *path, daft_decoded *out,
                      daft_error *error);
/* The size in a file's header, where it is one that is decoded. */
bool daft_decode_size(const daft_allocator *allocator, const char *path, const void *bytes, size_t size, int *width,
                      int *height, daft_error *error);
void daft_decoded_free(const daft_allocator *allocator, daft_decoded *decoded);

#endif
