/* Image files to pixels, through stb_image. The decoder reads from memory by callbacks, for one reason: stb_image fills
 * what a cut-off file lacks with zeros and calls it a picture. The callbacks notice that it asked for a byte after the
 * last one, and that makes the file a truncated one. */
#include "image/decode.h"

#include "base/budget.h"
#include "image/stb_memory.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

static void *decode_malloc(size_t size);

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_MALLOC  decode_malloc
#define STBI_REALLOC daft_stb_realloc
#define STBI_FREE    daft_stb_free
#define STBI_FAILURE_USERMSG
#define STBI_MAX_DIMENSIONS 16384
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_TGA
#define STBI_ONLY_BMP
#define STBI_ONLY_GIF
#define STBI_ONLY_PSD
#define STBI_ONLY_HDR
#pragma GCC diagnostic ignored "-Wunused-function" /* reported at the end of the file, so it is not popped */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
/* A PNG whose first IDAT is empty: stb_image adds 0 to a null pointer and copies nothing there. */
static inline void *copy_some(void *to, const void *from, size_t count) { return count ? memcpy(to, from, count) : to; }
#define memcpy copy_some
#ifdef __clang__
#pragma clang attribute push(__attribute__((no_sanitize("pointer-overflow"))), apply_to = function)
#endif
#include <stb_image.h>
#ifdef __clang__
#pragma clang attribute pop
#endif
#undef memcpy
#pragma GCC diagnostic pop

/* The state of its JPEG decoder stb_image 2.27 leaves as it was allocated, and decodes by Huffman tables that a damaged
 * file never defined. Here an undefined table has no codes: none is found, and the file is refused. */
static void *decode_malloc(size_t size)
{
    void *memory = daft_stb_malloc(size);
    if (!memory || size != sizeof(stbi__jpeg)) return memory;
    stbi__jpeg *jpeg = memset(memory, 0, size);
    for (int i = 0; i < 8; i++) {
        stbi__huffman *table = i < 4 ? &jpeg->huff_dc[i] : &jpeg->huff_ac[i - 4];
        memset(table->fast, 255, sizeof table->fast);
        table->maxcode[17] = UINT_MAX; /* ends the search for a code that is too long */
    }
    return memory;
}

typedef struct source {
    const char *bytes;
    size_t size, position;
    bool starved; /* a byte after the last was asked for */
} source;

static int source_read(void *user, char *data, int size)
{
    source *from = user;
    size_t wanted = (size_t)size, left = from->size - from->position;
    if (left == 0 && wanted > 0) from->starved = true;
    if (wanted > left) wanted = left;
    memcpy(data, from->bytes + from->position, wanted);
    from->position += wanted;
    return (int)wanted;
}

static void source_skip(void *user, int count)
{
    source *from = user;
    if (count < 0) {
        size_t back = (size_t) - (int64_t)count;
        from->position -= back < from->position ? back : from->position;
        return;
    }
    size_t left = from->size - from->position;
    from->position += (size_t)count < left ? (size_t)count : left;
}

static int source_at_end(void *user)
{
    const source *from = user;
    return from->position >= from->size;
}

static const stbi_io_callbacks source_callbacks = {source_read, source_skip, source_at_end};

static bool fail_decoding(const char *path, daft_error *error)
{
    const char *reason = stbi_failure_reason();
    return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "cannot decode the image: %s",
                        reason ? reason : "unknown reason");
}

/* ---- JPEG ---- */

/* The tables of a DHT segment of `length` bytes, of the `left` bytes of the file: a class, 16 counts of codes, and a
 * symbol for each code. Symbols are bytes, so that there are at most 256; stb_image (until 2.28) trusts the counts,
 * also those beyond the segment's end, and writes behind its array. */
static bool are_huffman_tables_good(const uint8_t *at, size_t length, size_t left)
{
    for (;;) {
        size_t codes = 0;
        for (size_t i = 1; i <= 16 && i < left; i++) codes += at[i];
        if (codes > 256) return false;
        size_t used = 17 + codes;
        if (used >= length || used >= left) return true;
        at += used;
        length -= used;
        left -= used;
    }
}

/* Goes through the segments of a JPEG file as stb_image does: anything up to 0xff is skipped between them (and is the
 * picture after SOS), and each but the bare markers has its length in front. */
static bool is_jpeg_safe(const uint8_t *bytes, size_t size)
{
    size_t at = 0;
    while (at < size && bytes[at] == 0xff) at++;
    if (at == 0 || at == size || bytes[at++] != 0xd8) return true; /* no JPEG */
    while (at + 4 <= size) {
        uint8_t marker = bytes[at + 1];
        if (bytes[at] != 0xff || marker == 0xff || marker == 0) {
            at += bytes[at] == 0xff && marker == 0 ? 2 : 1;
            continue;
        }
        at += 2;
        if (marker == 0xd9) return true;
        if (marker >= 0xd0 && marker <= 0xd8) continue;
        size_t length = (size_t)bytes[at] << 8 | bytes[at + 1];
        if (length < 2) return true; /* an error to stb_image too */
        if (length > 2 && marker == 0xc4 && !are_huffman_tables_good(bytes + at + 2, length - 2, size - at - 2))
            return false;
        at += length; /* may lead beyond the end, which ends the loop */
    }
    return true;
}

/* ---- HDR ---- */

static size_t skip_line(const uint8_t *bytes, size_t size, size_t at)
{
    while (at < size && bytes[at] != '\n') at++;
    return at < size ? at + 1 : size;
}

/* One channel of a run-length encoded row. False where the file ends before it does. */
static bool skip_hdr_channel(const uint8_t *bytes, size_t size, size_t *at, int width)
{
    for (int x = 0; x < width;) {
        if (*at >= size) return false;
        int count = bytes[(*at)++], pixels = count > 128 ? count - 128 : count;
        *at += count > 128 ? 1 : (size_t)count; /* one value for all, or one for each */
        x += pixels;
    }
    return *at <= size;
}

/* Where the file ends within a row, stb_image (20220908) reads runs of length 0 for ever. */
static bool is_hdr_complete(const uint8_t *bytes, size_t size, int width, int height)
{
    if (width < 8 || width >= 32768) return true; /* stored as it is */
    size_t at = 0;
    while (at < size && bytes[at] != '\n' && bytes[at] != 0) at = skip_line(bytes, size, at);
    at = skip_line(bytes, size, skip_line(bytes, size, at)); /* the empty line, and the one with the size */
    for (int y = 0; y < height; y++) {
        if (size - at < 4) return false;
        if (bytes[at] != 2 || bytes[at + 1] != 2 || bytes[at + 2] & 0x80) return true; /* nor is this encoded */
        at += 4;
        for (int channel = 0; channel < 4; channel++)
            if (!skip_hdr_channel(bytes, size, &at, width)) return false;
    }
    return true;
}

/* ---- the header ---- */

/* No format packs more pixels into a byte: 1-bit PNG comes nearest, with 1032 times 8. A header that says more is a
 * lie which would cost gigabytes. */
enum { PIXELS_PER_BYTE = 16384 };

typedef struct decoding {
    source from;
    bool is_hdr, is_known; /* is_known: the header is one of a format that is read */
    int width, height;
    void *pixels;
} decoding;

static void decode_header(void *context)
{
    decoding *d = context;
    int channels;
    d->is_known = stbi_info_from_callbacks(&source_callbacks, &d->from, &d->width, &d->height, &channels);
}

bool daft_decode_size(const daft_allocator *allocator, const char *path, const void *bytes, size_t size, int *width,
                      int *height, daft_error *error)
{
    decoding d = {.from = {bytes, size, 0, false}};
    if (!is_jpeg_safe(bytes, size))
        return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "cannot decode the image: bad Huffman table");
    if (!daft_stb_run(allocator, decode_header, &d, NULL))
        return daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for the header of an image");
    if (!d.is_known) return fail_decoding(path, error);
    int w = d.width, h = d.height;
    if (w <= 0 || h <= 0)
        return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "the image has no pixels (%d by %d)", w, h);
    if (w > DAFT_MAX_IMAGE_SIDE || h > DAFT_MAX_IMAGE_SIDE)
        return daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0,
                            "the image is %d by %d pixels; %d a side is the most", w, h, DAFT_MAX_IMAGE_SIDE);
    if ((uint64_t)w * (uint64_t)h / PIXELS_PER_BYTE > size)
        return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "a file of %zu bytes cannot hold %d by %d pixels",
                            size, w, h);
    *width = w, *height = h;
    return true;
}

static void decode_pixels(void *context)
{
    decoding *d = context;
    int channels;
    if (d->is_hdr)
        d->pixels = stbi_loadf_from_callbacks(&source_callbacks, &d->from, &d->width, &d->height, &channels, 3);
    else
        d->pixels = stbi_load_from_callbacks(&source_callbacks, &d->from, &d->width, &d->height, &channels, 4);
}

/* What stb_image holds at once for so many pixels: of 8-bit files what the file packs and the result, 4 bytes a pixel
 * each; of HDR files the result. */
static bool can_afford(const daft_allocator *allocator, const char *path, int width, int height, bool is_hdr,
                       daft_error *error)
{
    char what[64];
    snprintf(what, sizeof what, "an image of %d by %d pixels", width, height);
    return daft_budget_allows(allocator, (uint64_t)width * (uint64_t)height * (is_hdr ? 12 : 8), path, what, error);
}

static bool decode(const daft_allocator *allocator, const char *bytes, size_t size, const char *path, daft_decoded *out,
                   daft_error *error)
{
    int width, height;
    if (!daft_decode_size(allocator, path, bytes, size, &width, &height, error)) return false;
    decoding d = {.from = {bytes, size, 0, false}};
    d.is_hdr = stbi_is_hdr_from_memory((const uint8_t *)bytes, (int)size);
    if (d.is_hdr && !is_hdr_complete((const uint8_t *)bytes, size, width, height))
        return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "the image is truncated");
    if (!can_afford(allocator, path, width, height, d.is_hdr, error)) return false;
    if (!daft_stb_run(allocator, decode_pixels, &d, &d.pixels))
        return daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for an image of %d by %d pixels",
                            width, height);
    if (d.from.starved || !d.pixels) {
        daft_stb_release(allocator, d.pixels);
        if (d.from.starved) return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "the image is truncated");
        return fail_decoding(path, error);
    }
    *out = (daft_decoded){d.width, d.height, d.is_hdr ? NULL : d.pixels, d.is_hdr ? d.pixels : NULL};
    return true;
}

bool daft_decode_bytes(const daft_allocator *allocator, const void *bytes, size_t size, const char *path,
                       daft_decoded *out, daft_error *error)
{
    *out = (daft_decoded){0};
    if (size == 0) return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "the file is empty, not an image");
    if (size > INT_MAX)
        return daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0, "image files over 2 GiB are not read");
    return decode(allocator, bytes, size, path, out, error);
}

bool daft_decode_file(const daft_allocator *allocator, const daft_files *files, const char *path, daft_decoded *out,
                      daft_error *error)
{
    *out = (daft_decoded){0};
    size_t size;
    char *bytes = daft_file_read(allocator, files, path, &size, error);
    bool done = bytes && daft_decode_bytes(allocator, bytes, size, path, out, error);
    daft_release(allocator, bytes);
    return done;
}

void daft_decoded_free(const daft_allocator *allocator, daft_decoded *decoded)
{
    daft_stb_release(allocator, decoded->bytes);
    daft_stb_release(allocator, decoded->floats);
    *decoded = (daft_decoded){0};
}
