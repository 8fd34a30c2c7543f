/* Images in memory: reading them from any file we decode, writing PNG and PPM. */
#include "image/image.h"

#include "image/color.h"
#include "image/decode.h"
#include "image/stb_memory.h"
#include "base/writer.h"

#include <string.h>
#include <strings.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#define STBIW_MALLOC  daft_stb_malloc
#define STBIW_REALLOC daft_stb_realloc
#define STBIW_FREE    daft_stb_free
#pragma GCC diagnostic ignored "-Wunused-function" /* reported at the end of the file, so it is not popped */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#include <stb_image_write.h>
#pragma GCC diagnostic pop

/* Light over 1 is clamped: a picture of a bright sky is white there. */
static void bytes_from_light(const float *light, size_t pixels, uint8_t *rgba)
{
    daft_srgb_table table;
    daft_srgb_table_make(&table);
    for (size_t i = 0; i < pixels; i++) {
        for (int c = 0; c < 3; c++) rgba[4 * i + (size_t)c] = daft_srgb_byte(&table, light[3 * i + (size_t)c]);
        rgba[4 * i + 3] = 255;
    }
}

/* Takes over what was decoded. */
static bool image_from(const daft_allocator *allocator, daft_decoded *decoded, const char *path, daft_image *out,
                       daft_error *error)
{
    if (decoded->bytes) {
        *out = (daft_image){*allocator, decoded->width, decoded->height, decoded->bytes, .from_stb = true};
        return true;
    }
    size_t pixels = (size_t)decoded->width * (size_t)decoded->height;
    uint8_t *rgba = daft_alloc(allocator, pixels, 4);
    if (rgba) bytes_from_light(decoded->floats, pixels, rgba);
    if (rgba)
        *out =
            (daft_image){.allocator = *allocator, .width = decoded->width, .height = decoded->height, .pixels = rgba};
    daft_decoded_free(allocator, decoded);
    return rgba || daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for the image");
}

bool daft_image_read(const daft_allocator *allocator, const daft_files *files, const char *path, daft_image *out,
                     daft_error *error)
{
    daft_decoded decoded;
    return daft_decode_file(allocator, files, path, &decoded, error) &&
           image_from(allocator, &decoded, path, out, error);
}

bool daft_image_decode(const daft_allocator *allocator, const void *bytes, size_t size, const char *path,
                       daft_image *out, daft_error *error)
{
    daft_decoded decoded;
    return daft_decode_bytes(allocator, bytes, size, path, &decoded, error) &&
           image_from(allocator, &decoded, path, out, error);
}

void daft_image_free(daft_image *image)
{
    if (image->from_stb)
        daft_stb_release(&image->allocator, image->pixels);
    else
        daft_release(&image->allocator, image->pixels);
    image->pixels = NULL;
    image->width = image->height = 0;
}

void daft_image_destroy(daft_image *image)
{
    if (!image || image->drawing)
        return; /* from inside the progress callback: a leak is better than a use after free */
    daft_allocator allocator = image->allocator;
    daft_image_free(image);
    daft_release(&allocator, image);
}

int daft_image_width(const daft_image *image) { return image ? image->width : 0; }
int daft_image_height(const daft_image *image) { return image ? image->height : 0; }
uint8_t *daft_image_pixels(daft_image *image) { return image ? image->pixels : NULL; }

/* ---- writing ---- */

static void write_bytes(void *context, void *bytes, int size) { daft_writer_put(context, bytes, (size_t)size); }

static bool is_opaque(const daft_image *image)
{
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++)
        if (image->pixels[4 * i + 3] != 255) return false;
    return true;
}

/* RGB, tightly packed; NULL when memory is out. */
static uint8_t *drop_alpha(const daft_image *image)
{
    size_t pixels = (size_t)image->width * (size_t)image->height;
    uint8_t *rgb = daft_alloc(&image->allocator, pixels, 3);
    for (size_t i = 0; rgb && i < pixels; i++) memcpy(rgb + 3 * i, image->pixels + 4 * i, 3);
    return rgb;
}

typedef struct encoding {
    const daft_image *image;
    const uint8_t *pixels;
    int channels; /* 3 or 4 */
    daft_writer *to;
    bool done;
} encoding;

static void encode_png(void *context)
{
    encoding *e = context;
    int width = e->image->width, height = e->image->height;
    e->done = stbi_write_png_to_func(write_bytes, e->to, width, height, e->channels, e->pixels, e->channels * width);
}

/* Both return false without a message when memory is out; the writer remembers a write that fails. */
static bool write_png(const daft_image *image, daft_writer *to)
{
    bool opaque = is_opaque(image);
    uint8_t *rgb = opaque ? drop_alpha(image) : NULL;
    encoding e = {image, opaque ? rgb : image->pixels, opaque ? 3 : 4, to, false};
    bool done = e.pixels && daft_stb_run(&image->allocator, encode_png, &e, NULL) && e.done;
    daft_release(&image->allocator, rgb);
    return done;
}

static bool write_ppm(const daft_image *image, daft_writer *to)
{
    uint8_t *rgb = drop_alpha(image);
    if (!rgb) return false;
    size_t size = 3 * (size_t)image->width * (size_t)image->height;
    daft_writer_print(to, "P6\n%d %d\n255\n", image->width, image->height);
    daft_writer_put(to, rgb, size);
    daft_release(&image->allocator, rgb);
    return true;
}

typedef bool write_function(const daft_image *image, daft_writer *to);

static write_function *format_of(const char *path)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    if (!dot || (slash && dot < slash)) return NULL;
    if (strcasecmp(dot, ".png") == 0) return write_png;
    if (strcasecmp(dot, ".ppm") == 0) return write_ppm;
    return NULL;
}

bool daft_image_write(const daft_image *image, const char *path, daft_error *error)
{
    if (!image || !image->pixels) return daft_fail(error, DAFT_ERROR_ARGUMENT, "no image to write");
    if (!path || !path[0]) return daft_fail(error, DAFT_ERROR_ARGUMENT, "no file name to write the image to");
    write_function *write = format_of(path);
    if (!write)
        return daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0,
                            "images are written as .png or .ppm, by the extension of the name");
    daft_writer *to = daft_writer_open(&image->allocator, path, error);
    if (!to) return false;
    if (write(image, to)) return daft_writer_commit(to, error);
    daft_writer_abandon(to);
    return daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for encoding the image");
}
