/* Textures: an image and its mip chain. Every texel of every level is the mean of the light that falls on its area of
 * the full image, rounded once: the chain is carried in float, never through the bytes of the level before. */
#include "image/color.h"
#include "image/decode.h"
#include "image/image.h"
#include "image/shared.h"
#include "image/stb_memory.h"

#include <string.h>

enum { MOST_AROUND = 8192 }; /* texels of a row: 170 MB with all levels */

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

/* A level in the making: its last three rows, which is as far as a row of the next level reaches, in floats (linear
 * light and alpha, 4 a texel). The whole chain is made row by row, so that no level ever exists in floats as a whole.
 */
enum { ROWS = 3 };
typedef struct stage {
    int width, height, made; /* made: rows so far */
    float *rows;             /* ROWS of them; row y is the one numbered y % ROWS */
} stage;

static float *row_of(const stage *s, int y) { return s->rows + (size_t)(y % ROWS) * 4 * (size_t)s->width; }

static void decode_row(const daft_srgb_table *table, const uint8_t *rgba, float *light, int width)
{
    for (size_t i = 0; i < 4 * (size_t)width; i++)
        light[i] = (i & 3) == 3 ? (float)rgba[i] * (1.0f / 255) : table->linear[rgba[i]];
}

static void encode_row(const daft_srgb_table *table, const float *light, uint8_t *rgba, int width)
{
    for (size_t i = 0; i < 4 * (size_t)width; i++)
        rgba[i] = (i & 3) == 3 ? (uint8_t)(light[i] * 255 + 0.5f) : daft_srgb_byte(table, light[i]);
}

/* Weighs rows[j] by down.weight[j] and, along each, the texels of `from` columns that make one of `to`. */
static void halve(float *const *rows, taps down, int from, float *out, int to)
{
    for (int x = 0; x < to; x++) {
        taps across = taps_of(x, to, from);
        float sum[4] = {0, 0, 0, 0};
        for (int j = 0; j < down.count; j++)
            for (int i = 0; i < across.count; i++) {
                const float *texel = rows[j] + 4 * (size_t)(across.first + i);
                float weight = down.weight[j] * across.weight[i];
                for (size_t c = 0; c < 4; c++) sum[c] += weight * texel[c];
            }
        memcpy(out + 4 * (size_t)x, sum, sizeof sum);
    }
}

/* The first halving adds whole rows first, which vectorizes: it does three quarters of the work. */
static void add_rows(float *const *rows, taps down, int width, float *out)
{
    for (size_t i = 0; i < 4 * (size_t)width; i++) {
        out[i] = 0;
        for (int j = 0; j < down.count; j++) out[i] += down.weight[j] * rows[j][i];
    }
}

typedef struct chain {
    const daft_srgb_table *table;
    daft_texture_data *texture;
    stage stages[DAFT_MAX_MIPS];
    float *sum; /* of rows of level 0 */
} chain;

/* Makes the next row of a level, after those that it needs of the level below. The recursion is as deep as there are
 * levels. */
static void make_row(chain *c, int level)
{
    stage *s = &c->stages[level];
    int y = s->made++;
    uint8_t *texels = c->texture->texels[level] + 4 * (size_t)y * (size_t)s->width;
    if (level == 0) {
        decode_row(c->table, texels, row_of(s, y), s->width);
        return;
    }
    stage *below = s - 1;
    taps down = taps_of(y, s->height, below->height);
    float *rows[ROWS];
    while (below->made < down.first + down.count) make_row(c, level - 1);
    for (int j = 0; j < down.count; j++) rows[j] = row_of(below, down.first + j);
    if (level == 1) {
        add_rows(rows, down, below->width, c->sum);
        halve(&c->sum, (taps){0, 1, {1, 0, 0}}, below->width, row_of(s, y), s->width);
    } else {
        halve(rows, down, below->width, row_of(s, y), s->width);
    }
    encode_row(c->table, row_of(s, y), texels, s->width);
}

/* Sizes of all levels; returns the bytes that those above level 0 take together. */
static size_t lay_out(daft_texture_data *texture, int width, int height)
{
    size_t bytes = 0;
    for (;;) {
        int level = texture->levels++;
        texture->width[level] = width;
        texture->height[level] = height;
        if (level > 0) bytes += 4 * (size_t)width * (size_t)height;
        if (width == 1 && height == 1) return bytes;
        width = daft_max_i(1, width / 2);
        height = daft_max_i(1, height / 2);
    }
}

/* Fills levels 1 and up. The last level's row is made after all others. */
static bool fill_levels(const daft_allocator *allocator, daft_texture_data *texture)
{
    size_t floats = 4 * (size_t)texture->width[0];
    for (int level = 0; level < texture->levels; level++) floats += ROWS * 4 * (size_t)texture->width[level];
    float *rows = daft_alloc(allocator, floats, sizeof(float));
    if (!rows) return false;
    daft_srgb_table table;
    daft_srgb_table_make(&table);
    chain c = {.table = &table, .texture = texture, .sum = rows};
    float *at = rows + 4 * (size_t)texture->width[0];
    for (int level = 0; level < texture->levels; level++) {
        c.stages[level] = (stage){texture->width[level], texture->height[level], 0, at};
        at += ROWS * 4 * (size_t)texture->width[level];
    }
    make_row(&c, texture->levels - 1);
    daft_release(allocator, rows);
    return true;
}

/* Makes the levels above level 0, which belongs to the texture from now on, also on failure. */
static bool add_levels(const daft_allocator *allocator, daft_texture_data *texture, int width, int height,
                       daft_error *error)
{
    const size_t texels = (size_t)width * (size_t)height;
    for (size_t i = 0; i < texels && !texture->has_alpha; i++)
        texture->has_alpha = texture->texels[0][4 * i + 3] != 255;
    size_t bytes = lay_out(texture, width, height);
    if (texture->levels == 1) return true;
    texture->texels[1] = daft_alloc(allocator, bytes, 1);
    for (int level = 2; texture->texels[1] && level < texture->levels; level++)
        texture->texels[level] =
            texture->texels[level - 1] + 4 * (size_t)texture->width[level - 1] * (size_t)texture->height[level - 1];
    if (texture->texels[1] && fill_levels(allocator, texture)) return true;
    daft_texture_free(allocator, texture);
    return daft_fail_memory(error, "a texture's mip levels");
}

bool daft_texture_build(const daft_allocator *allocator, const uint8_t *rgba, int width, int height,
                        daft_texture_data *out, daft_error *error)
{
    if (width < 1 || height < 1 || width > DAFT_MAX_IMAGE_SIDE || height > DAFT_MAX_IMAGE_SIDE)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a texture of %d by %d pixels; 1 to %d a side are possible", width,
                         height, DAFT_MAX_IMAGE_SIDE);
    size_t bytes = 4 * (size_t)width * (size_t)height;
    daft_texture_data texture = {.texels = {daft_alloc(allocator, bytes, 1)}};
    if (!texture.texels[0]) return daft_fail_memory(error, "a texture");
    memcpy(texture.texels[0], rgba, bytes);
    if (!add_levels(allocator, &texture, width, height, error)) return false;
    *out = texture;
    return true;
}

/* Takes over the picture. */
static bool texture_of(const daft_allocator *allocator, const daft_image *image, daft_texture_data *out,
                       daft_error *error)
{
    daft_texture_data texture = {.texels = {image->pixels}, .from_stb = image->from_stb};
    if (!add_levels(allocator, &texture, image->width, image->height, error)) return false;
    *out = texture;
    return true;
}

bool daft_texture_read(const daft_allocator *allocator, const daft_files *files, const char *path,
                       daft_texture_data *out, daft_error *error)
{
    daft_image image;
    return daft_image_read(allocator, files, path, &image, error) && texture_of(allocator, &image, out, error);
}

static uint8_t changed_byte(const daft_texture_change *c, int value)
{
    const float out = c->gain != 0 ? (c->base * 255 + c->gain * (float)value) : (float)value;
    return (uint8_t)(out > 0 ? out < 255 ? out + 0.5f : 255 : 0);
}

/* Luminance by ITU-R BT.709, of the bytes as they are. */
static int channel_of(char channel, const uint8_t *t)
{
    switch (channel) {
    case 'r': return t[0];
    case 'g': return t[1];
    case 'b': return t[2];
    case 'm': return t[3];
    default: return (int)(0.2126f * (float)t[0] + 0.7152f * (float)t[1] + 0.0722f * (float)t[2] + 0.5f);
    }
}

static void change_texels(uint8_t *texels, size_t count, const daft_texture_change *c)
{
    for (size_t i = 0; i < count; i++) {
        uint8_t *t = &texels[4 * i];
        if (c->channel) t[0] = t[1] = t[2] = (uint8_t)channel_of(c->channel, t), t[3] = 255;
        for (int k = 0; k < 3; k++) t[k] = changed_byte(c, t[k]);
    }
}

/* The first level that is small enough becomes the texture. */
static bool limit_side(const daft_allocator *allocator, int most, daft_texture_data *texture, daft_error *error)
{
    int level = 0;
    while (level + 1 < texture->levels && daft_max_i(texture->width[level], texture->height[level]) > most) level++;
    if (level == 0) return true;
    daft_texture_data small;
    const bool done = daft_texture_build(allocator, texture->texels[level], texture->width[level],
                                         texture->height[level], &small, error);
    daft_texture_free(allocator, texture);
    if (done) *texture = small;
    return done;
}

bool daft_texture_decode(const daft_allocator *allocator, const daft_image_file *file,
                         const daft_texture_change *change, daft_texture_data *out, daft_error *error)
{
    daft_image image;
    if (!daft_image_decode(allocator, file->bytes, file->size, file->path, &image, error)) return false;
    if (change) change_texels(image.pixels, (size_t)image.width * (size_t)image.height, change);
    return texture_of(allocator, &image, out, error) &&
           (!change || change->most == 0 || limit_side(allocator, change->most, out, error));
}

bool daft_texture_of_cube(const daft_allocator *allocator, const daft_sky_image *cube,
                          const daft_texture_change *change, daft_texture_data *out, daft_error *error)
{
    const int width = daft_min_i(4 * (cube->width - 2), MOST_AROUND), height = width / 2;
    const size_t count = (size_t)width * (size_t)height;
    uint8_t *texels = daft_alloc(allocator, 4 * count, 1);
    if (!texels) return daft_fail_memory(error, "a cube's image");
    daft_cube_unroll(cube, width, height, texels);
    change_texels(texels, count, change);
    const bool done = daft_texture_build(allocator, texels, width, height, out, error);
    daft_release(allocator, texels);
    return done && (change->most == 0 || limit_side(allocator, change->most, out, error));
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

size_t daft_texture_bytes(const daft_texture_data *texture)
{
    size_t bytes = 0;
    for (int level = 0; level < texture->levels; level++)
        bytes += 4 * (size_t)texture->width[level] * (size_t)texture->height[level];
    return bytes;
}

void daft_texture_free(const daft_allocator *allocator, daft_texture_data *texture)
{
    if (texture->shared)
        daft_shared_image_release(allocator, texture->shared), texture->texels[1] = NULL;
    else if (texture->from_stb)
        daft_stb_release(allocator, texture->texels[0]);
    else
        daft_release(allocator, texture->texels[0]);
    daft_release(allocator, texture->texels[1]);
    *texture = (daft_texture_data){0};
}
