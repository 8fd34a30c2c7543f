/* Skies: equirectangular images in linear light. HDR files hold linear light; 8-bit files are decoded by the sRGB
 * curve. */
#include "image/color.h"
#include "image/decode.h"
#include "image/image.h"
#include "image/stb_memory.h"

bool daft_sky_read(const daft_allocator *allocator, const daft_files *files, const char *path, daft_sky_image *out,
                   daft_error *error)
{
    daft_decoded decoded;
    if (!daft_decode_file(allocator, files, path, &decoded, error)) return false;
    if (decoded.floats) {
        *out = (daft_sky_image){decoded.width, decoded.height, decoded.floats, true};
        return true;
    }
    size_t pixels = (size_t)decoded.width * (size_t)decoded.height;
    float *texels = daft_alloc(allocator, 3 * pixels, sizeof(float));
    if (texels) {
        daft_srgb_table table;
        daft_srgb_table_make(&table);
        for (size_t i = 0; i < pixels; i++)
            for (size_t c = 0; c < 3; c++) texels[3 * i + c] = table.linear[decoded.bytes[4 * i + c]];
        *out = (daft_sky_image){decoded.width, decoded.height, texels, false};
    }
    daft_decoded_free(allocator, &decoded);
    return texels || daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for the sky");
}

void daft_sky_free(const daft_allocator *allocator, daft_sky_image *sky)
{
    if (sky->from_stb)
        daft_stb_release(allocator, sky->texels);
    else
        daft_release(allocator, sky->texels);
    *sky = (daft_sky_image){0};
}
