/* Textures: an image and its mip chain. Every texel of every level is the mean of the light that falls on its area of
 * the full image, rounded once: the chain is carried in float, never through the bytes of the level before. */
#include "image/color.h"
#include "image/decode.h"
#include "image/image.h"

#include <string.h>

/* Along one axis a texel covers source/target >= 2 (or, at the end, 1) texels of the level before: two of them where
 * that is even, else three, the outer ones in part. */
typedef struct taps {
    int first, count;
    float weight[3];
} taps;

static taps taps_of(int target_index, int target, int source)
{
    if (source == target) return (taps){target_index, 1, {1, 0, 0}};
    if (source == 2 * target) return (taps){2 * target_index, 2, {0.5f, 0.5f, 0}};
    float whole = (float)source;
    return (taps){2 * target_index,
                  3,
                  {(float)(target - target_index) / whole, (float)target / whole, (float)(target_index + 1) / whole}};
}

typedef struct plane {
    int width, height;
    float *texels; /* 4 floats each: linear light and alpha */
} plane;

static void halve(const plane *from, const plane *to)
{
    for (int y = 0; y < to->height; y++) {
        taps rows = taps_of(y, to->height, from->height);
        for (int x = 0; x < to->width; x++) {
            taps columns = taps_of(x, to->width, from->width);
            float sum[4] = {0, 0, 0, 0};
            for (int j = 0; j < rows.count; j++)
                for (int i = 0; i < columns.count; i++) {
                    size_t at = (size_t)(rows.first + j) * (size_t)from->width + (size_t)(columns.first + i);
                    float weight = rows.weight[j] * columns.weight[i];
                    for (size_t c = 0; c < 4; c++) sum[c] += weight * from->texels[4 * at + c];
                }
            memcpy(to->texels + 4 * ((size_t)y * (size_t)to->width + (size_t)x), sum, sizeof sum);
        }
    }
}

static void decode_row(const daft_srgb_table *table, const uint8_t *rgba, float *light, int width)
{
    for (size_t i = 0; i < 4 * (size_t)width; i++)
        light[i] = (i & 3) == 3 ? (float)rgba[i] * (1.0f / 255) : table->linear[rgba[i]];
}

/* The first halving reads bytes, two or three rows at a time, so that the full image never exists in floats. */
static void halve_bytes(const daft_srgb_table *table, const daft_texture_data *texture, const plane *to, float *rows)
{
    int width = texture->width[0];
    for (int y = 0; y < to->height; y++) {
        taps down = taps_of(y, to->height, texture->height[0]);
        for (int j = 0; j < down.count; j++) {
            size_t row = (size_t)(down.first + j) * (size_t)width;
            float *light = rows + 4 * (size_t)width * (size_t)(j + 1);
            decode_row(table, texture->texels[0] + 4 * row, light, width);
        }
        for (size_t i = 0; i < 4 * (size_t)width; i++) {
            rows[i] = 0;
            for (int j = 0; j < down.count; j++)
                rows[i] += down.weight[j] * rows[i + 4 * (size_t)width * (size_t)(j + 1)];
        }
        halve(&(plane){width, 1, rows}, &(plane){to->width, 1, to->texels + 4 * (size_t)y * (size_t)to->width});
    }
}

static void encode(const daft_srgb_table *table, const plane *from, uint8_t *rgba)
{
    size_t count = 4 * (size_t)from->width * (size_t)from->height;
    for (size_t i = 0; i < count; i++)
        rgba[i] = (i & 3) == 3 ? (uint8_t)(from->texels[i] * 255 + 0.5f) : daft_srgb_byte(table, from->texels[i]);
}

/* Sizes of all levels, and the bytes they take together. */
static size_t lay_out(daft_texture_data *texture, int width, int height)
{
    size_t bytes = 0;
    for (;;) {
        int level = texture->levels++;
        texture->width[level] = width;
        texture->height[level] = height;
        bytes += 4 * (size_t)width * (size_t)height;
        if (width == 1 && height == 1) return bytes;
        width = daft_max_i(1, width / 2);
        height = daft_max_i(1, height / 2);
    }
}

/* Fills levels 1 and up. The two planes hold levels turn by turn: the second is never larger than the first. */
static bool fill_levels(const daft_allocator *allocator, daft_texture_data *texture)
{
    if (texture->levels == 1) return true;
    size_t texels = (size_t)texture->width[1] * (size_t)texture->height[1];
    float *planes[2] = {daft_alloc(allocator, 4 * texels, sizeof(float)),
                        daft_alloc(allocator, 4 * texels, sizeof(float))};
    float *rows = daft_alloc(allocator, 4 * 4 * (size_t)texture->width[0], sizeof(float));
    bool done = planes[0] && planes[1] && rows;
    if (done) {
        daft_srgb_table table;
        daft_srgb_table_make(&table);
        for (int level = 1; level < texture->levels; level++) {
            plane to = {texture->width[level], texture->height[level], planes[level & 1]};
            plane from = {texture->width[level - 1], texture->height[level - 1], planes[(level - 1) & 1]};
            if (level == 1)
                halve_bytes(&table, texture, &to, rows);
            else
                halve(&from, &to);
            encode(&table, &to, texture->texels[level]);
        }
    }
    daft_release(allocator, planes[0]);
    daft_release(allocator, planes[1]);
    daft_release(allocator, rows);
    return done;
}

bool daft_texture_build(const daft_allocator *allocator, const uint8_t *rgba, int width, int height,
                        daft_texture_data *out, daft_error *error)
{
    if (width < 1 || height < 1 || width > DAFT_MAX_IMAGE_SIDE || height > DAFT_MAX_IMAGE_SIDE)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a texture of %d by %d pixels; 1 to %d a side are possible", width,
                         height, DAFT_MAX_IMAGE_SIDE);
    daft_texture_data texture = {0};
    size_t bytes = lay_out(&texture, width, height);
    texture.texels[0] = daft_alloc(allocator, bytes, 1);
    if (!texture.texels[0]) return daft_fail_memory(error, "a texture");
    memcpy(texture.texels[0], rgba, 4 * (size_t)width * (size_t)height);
    for (int level = 1; level < texture.levels; level++)
        texture.texels[level] =
            texture.texels[level - 1] + 4 * (size_t)texture.width[level - 1] * (size_t)texture.height[level - 1];
    if (!fill_levels(allocator, &texture)) {
        daft_texture_free(allocator, &texture);
        return daft_fail_memory(error, "a texture's mip levels");
    }
    *out = texture;
    return true;
}

bool daft_texture_read(const daft_allocator *allocator, const char *path, daft_texture_data *out, daft_error *error)
{
    daft_image image;
    if (!daft_image_read(allocator, path, &image, error)) return false;
    bool done = daft_texture_build(allocator, image.pixels, image.width, image.height, out, error);
    daft_image_free(&image);
    return done;
}

bool daft_texture_missing(const daft_allocator *allocator, daft_texture_data *out, daft_error *error)
{
    enum { SIDE = 64, SQUARE = 8 };
    uint8_t rgba[4 * SIDE * SIDE];
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            uint8_t *texel = rgba + 4 * (y * SIDE + x);
            uint8_t bright = (x / SQUARE + y / SQUARE) & 1 ? 0 : 255;
            texel[0] = texel[2] = bright;
            texel[1] = 0;
            texel[3] = 255;
        }
    if (!daft_texture_build(allocator, rgba, SIDE, SIDE, out, error)) return false;
    out->missing = true;
    return true;
}

void daft_texture_free(const daft_allocator *allocator, daft_texture_data *texture)
{
    daft_release(allocator, texture->texels[0]);
    *texture = (daft_texture_data){0};
}
