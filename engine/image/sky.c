/* Skies: equirectangular images in linear light. HDR files hold linear light; 8-bit files are decoded by the sRGB
 * curve. */
#include "image/color.h"
#include "image/decode.h"
#include "image/image.h"
#include "image/shared.h"
#include "image/stb_memory.h"
#include "math/trig.h"

/* Takes over what was decoded. */
static bool sky_of(const daft_allocator *allocator, daft_decoded *decoded, const char *path, daft_sky_image *out,
                   daft_error *error)
{
    if (decoded->floats) {
        *out = (daft_sky_image){
            .width = decoded->width, .height = decoded->height, .texels = decoded->floats, .from_stb = true};
        return true;
    }
    size_t pixels = (size_t)decoded->width * (size_t)decoded->height;
    float *texels = daft_alloc(allocator, 3 * pixels, sizeof(float));
    if (texels) {
        daft_srgb_table table;
        daft_srgb_table_make(&table);
        for (size_t i = 0; i < pixels; i++)
            for (size_t c = 0; c < 3; c++) texels[3 * i + c] = table.linear[decoded->bytes[4 * i + c]];
        *out = (daft_sky_image){.width = decoded->width, .height = decoded->height, .texels = texels};
    }
    daft_decoded_free(allocator, decoded);
    return texels || daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for the sky");
}

bool daft_sky_read(const daft_allocator *allocator, const daft_files *files, const char *path, daft_sky_image *out,
                   daft_error *error)
{
    daft_decoded decoded;
    return daft_decode_file(allocator, files, path, &decoded, error) && sky_of(allocator, &decoded, path, out, error);
}

bool daft_sky_decode(const daft_allocator *allocator, const daft_image_file *file, daft_sky_image *out,
                     daft_error *error)
{
    daft_decoded decoded;
    return daft_decode_bytes(allocator, file->bytes, file->size, file->path, &decoded, error) &&
           sky_of(allocator, &decoded, file->path, out, error);
}

void daft_sky_free(const daft_allocator *allocator, daft_sky_image *sky)
{
    if (sky->shared)
        daft_shared_image_release(allocator, sky->shared);
    else if (sky->from_stb)
        daft_stb_release(allocator, sky->texels);
    else
        daft_release(allocator, sky->texels);
    *sky = (daft_sky_image){0};
}

daft_vec3 daft_sky_mean(const daft_sky_image *sky)
{
    const int step = sky->height > 512 && !sky->from_stb ? sky->height / 256 : 1; /* from_stb: may hold a sun */
    double sum[3] = {0}, whole = 0;
    for (int y = 0; y < sky->height; y += step) {
        const double weight = daft_cos(DAFT_PI * ((y + 0.5) / sky->height - 0.5)); /* of the row's solid angle */
        for (int x = 0; x < sky->width; x += step) {
            const float *texel = sky->texels + 3 * ((size_t)y * (size_t)sky->width + (size_t)x);
            for (int c = 0; c < 3; c++) sum[c] += weight * (double)texel[c];
            whole += weight;
        }
    }
    return (daft_vec3){(float)(sum[0] / whole), (float)(sum[1] / whole), (float)(sum[2] / whole)};
}
