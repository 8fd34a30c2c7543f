/* Any bytes as an image file, read in the three ways the engine reads one. Large pictures are left out, since they take
 * the fuzzer's time and nothing else. */
#include "fuzz.h"

#include "image/decode.h"
#include "image/image.h"

#include <math.h>

enum { MOST_PIXELS = 1 << 16 };

static void check_picture(const daft_allocator *allocator, const char *path)
{
    daft_image image = {0};
    daft_error error = {0};
    bool good = daft_image_read(allocator, NULL, path, &image, &error);
    fuzz_check_error(good, &error);
    if (!good) return;
    FUZZ_CHECK(image.width > 0 && image.height > 0 && image.pixels);
    unsigned sum = 0;
    for (size_t i = 0; i < 4 * (size_t)image.width * (size_t)image.height; i++) sum += image.pixels[i];
    FUZZ_CHECK(sum != 1); /* so that every byte is read */
    daft_image_free(&image);
}

static void check_texture(const daft_allocator *allocator, const char *path)
{
    daft_texture_data texture = {0};
    daft_error error = {0};
    bool good = daft_texture_read(allocator, NULL, path, &texture, &error);
    fuzz_check_error(good, &error);
    if (!good) return;
    FUZZ_CHECK(texture.levels > 0 && texture.levels <= DAFT_MAX_MIPS && !texture.missing);
    FUZZ_CHECK(texture.width[texture.levels - 1] == 1 && texture.height[texture.levels - 1] == 1);
    daft_texture_free(allocator, &texture);
}

static void check_sky(const daft_allocator *allocator, const char *path)
{
    daft_sky_image sky = {0};
    daft_error error = {0};
    bool good = daft_sky_read(allocator, NULL, path, &sky, &error);
    fuzz_check_error(good, &error);
    if (!good) return;
    for (size_t i = 0; i < 3 * (size_t)sky.width * (size_t)sky.height; i++)
        FUZZ_CHECK(isfinite(sky.texels[i]) && sky.texels[i] >= 0);
    daft_sky_free(allocator, &sky);
}

int image_input(const uint8_t *data, size_t size)
{
    int width, height;
    daft_allocator allocator = daft_malloc_allocator();
    if (size > 0 && daft_decode_size(&allocator, "", data, size, &width, &height, NULL) && width * height > MOST_PIXELS)
        return 0;
    const char *path = fuzz_write("input.image", data, size);
    check_picture(&allocator, path);
    check_texture(&allocator, path);
    check_sky(&allocator, path);
    return 0;
}
