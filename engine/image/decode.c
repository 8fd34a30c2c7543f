/* Image files to pixels, through stb_image. The decoder reads from memory by callbacks, for one reason: stb_image fills
 * what a cut-off file lacks with zeros and calls it a picture. The callbacks notice that it asked for a byte after the
 * last one, and that makes the file a truncated one.
 *
 * stb_image holds all of a file's planes or rows beside the result. Most PNG and JPEG files are decoded here by its
 * parts, in little more than the memory of the result: PNG in place, JPEG row by row. Whatever is unusual about a file,
 * or wrong, is left to stb_image as a whole, and so are the messages; where both read a file, the bytes are equal. */
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

/* A JPEG file of one scan, of three components that are luma and chroma: two rows of MCUs are held of each. */
typedef struct jpeg_rows {
    stbi__jpeg *z;
    uint8_t *out;
    int shown; /* rows of `out` that are done */
    uint8_t *ring[3], *line[3];
    int high[3], low[3], step[3]; /* a component's two rows that the next row of `out` lies between; see load_jpeg_image
                                   */
} jpeg_rows;

/* What process_frame_header works out before it makes the planes. False: not what is read here. */
static bool plan_jpeg(stbi__jpeg *z)
{
    z->img_h_max = z->img_v_max = 1;
    if (z->progressive || z->s->img_n != 3 || z->rgb == 3) return false;
    for (int n = 0; n < 3; n++) {
        z->img_h_max = z->img_comp[n].h > z->img_h_max ? z->img_comp[n].h : z->img_h_max;
        z->img_v_max = z->img_comp[n].v > z->img_v_max ? z->img_comp[n].v : z->img_v_max;
    }
    z->img_mcu_x = ((int)z->s->img_x + 8 * z->img_h_max - 1) / (8 * z->img_h_max);
    z->img_mcu_y = ((int)z->s->img_y + 8 * z->img_v_max - 1) / (8 * z->img_v_max);
    for (int n = 0; n < 3; n++) {
        const int h = z->img_comp[n].h, v = z->img_comp[n].v;
        if (z->img_h_max % h != 0 || z->img_v_max % v != 0) return false;
        z->img_comp[n].x = ((int)z->s->img_x * h + z->img_h_max - 1) / z->img_h_max;
        z->img_comp[n].y = ((int)z->s->img_y * v + z->img_v_max - 1) / z->img_v_max;
        z->img_comp[n].w2 = z->img_mcu_x * h * 8;
    }
    return true;
}

static resample_row_func resample_of(const stbi__jpeg *z, int hs, int vs)
{
    if (hs == 1 && vs == 1) return resample_row_1;
    if (hs == 1 && vs == 2) return stbi__resample_row_v_2;
    if (hs == 2 && vs == 1) return stbi__resample_row_h_2;
    return hs == 2 && vs == 2 ? z->resample_row_hv_2_kernel : stbi__resample_row_generic;
}

static uint8_t *row_at(const jpeg_rows *r, int n, int row)
{
    const int rows = 16 * r->z->img_comp[n].v;
    return r->ring[n] + (size_t)(row % rows) * (size_t)r->z->img_comp[n].w2;
}

/* Makes the rows of the picture whose rows of all components have been decoded: those of so many rows of MCUs. */
static void show_rows(jpeg_rows *r, int mcu_rows)
{
    stbi__jpeg *z = r->z;
    const int width = (int)z->s->img_x, height = (int)z->s->img_y;
    for (; r->shown < height; r->shown++) {
        uint8_t *part[3];
        for (int n = 0; n < 3; n++)
            if (r->high[n] >= 8 * z->img_comp[n].v * mcu_rows) return;
        for (int n = 0; n < 3; n++) {
            const int hs = z->img_h_max / z->img_comp[n].h, vs = z->img_v_max / z->img_comp[n].v;
            const bool below = r->step[n] >= vs >> 1;
            uint8_t *high = row_at(r, n, r->high[n]), *low = row_at(r, n, r->low[n]);
            part[n] =
                resample_of(z, hs, vs)(r->line[n], below ? high : low, below ? low : high, (width + hs - 1) / hs, hs);
            if (++r->step[n] < vs) continue;
            r->step[n] = 0, r->low[n] = r->high[n];
            if (r->high[n] + 1 < z->img_comp[n].y) r->high[n]++;
        }
        z->YCbCr_to_RGB_kernel(r->out + 4 * (size_t)width * (size_t)r->shown, part[0], part[1], part[2], width, 4);
    }
}

/* As stbi__parse_entropy_coded_data does of a whole picture. */
static bool decode_mcu(jpeg_rows *r, int column, int row)
{
    stbi__jpeg *z = r->z;
    STBI_SIMD_ALIGN(short, data[64]);
    for (int k = 0; k < 3; k++) {
        const int n = z->order[k], ha = z->img_comp[n].ha;
        for (int y = 0; y < z->img_comp[n].v; y++)
            for (int x = 0; x < z->img_comp[n].h; x++) {
                uint8_t *out = row_at(r, n, (row * z->img_comp[n].v + y) * 8) + (column * z->img_comp[n].h + x) * 8;
                if (!stbi__jpeg_decode_block(z, data, z->huff_dc + z->img_comp[n].hd, z->huff_ac + ha, z->fast_ac[ha],
                                             n, z->dequant[z->img_comp[n].tq]))
                    return false;
                z->idct_block_kernel(out, z->img_comp[n].w2, data);
            }
    }
    if (--z->todo > 0) return true;
    if (z->code_bits < 24) stbi__grow_buffer_unsafe(z);
    if (STBI__RESTART(z->marker)) {
        stbi__jpeg_reset(z);
        return true;
    }
    return row == z->img_mcu_y - 1 && column == z->img_mcu_x - 1;
}

static bool decode_scan(jpeg_rows *r)
{
    stbi__jpeg *z = r->z;
    stbi__jpeg_reset(z);
    for (int row = 0; row < z->img_mcu_y; row++) {
        for (int column = 0; column < z->img_mcu_x; column++)
            if (!decode_mcu(r, column, row)) return false;
        show_rows(r, row + 1);
    }
    return true;
}

/* What comes before the scan, and that nothing comes after it. */
static bool begin_scan(stbi__jpeg *z)
{
    for (;;) {
        const int m = stbi__get_marker(z);
        if (stbi__SOS(m)) return stbi__process_scan_header(z) && z->scan_n == 3;
        if (stbi__EOI(m) || stbi__DNL(m) || !stbi__process_marker(z, m)) return false;
    }
}

static bool end_scan(stbi__jpeg *z)
{
    while (z->marker == STBI__MARKER_none && !stbi__at_eof(z->s))
        if (stbi__get8(z->s) == 255) z->marker = stbi__get8(z->s);
    return stbi__EOI(stbi__get_marker(z));
}

/* NULL: left to stb_image. What is allocated here goes with the session. */
static uint8_t *decode_jpeg(source from)
{
    stbi__context context;
    stbi__start_callbacks(&context, (stbi_io_callbacks *)(uintptr_t)&source_callbacks, &from);
    jpeg_rows r = {.z = stbi__malloc(sizeof(stbi__jpeg))};
    r.z->s = &context;
    stbi__setup_jpeg(r.z);
    if (!stbi__decode_jpeg_header(r.z, STBI__SCAN_header) || !plan_jpeg(r.z) || !begin_scan(r.z) ||
        (r.z->app14_color_transform == 0 && !r.z->jfif))
        return NULL;
    for (int n = 0; n < 3; n++) {
        r.ring[n] = daft_stb_malloc((size_t)(16 * r.z->img_comp[n].v) * (size_t)r.z->img_comp[n].w2 + 16);
        r.line[n] = daft_stb_malloc(context.img_x + 3);
        r.step[n] = r.z->img_v_max / r.z->img_comp[n].v >> 1;
    }
    r.out = daft_stb_malloc(4 * (size_t)context.img_x * context.img_y + 1);
    if (decode_scan(&r) && end_scan(r.z) && !from.starved) return r.out;
    daft_stb_free(r.out);
    return NULL;
}

/* ---- PNG ---- */

static uint32_t big_endian(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* A PNG file of three or four channels of eight bits, not interlaced: how many; else 0. */
static int png_channels(const uint8_t *bytes, size_t size)
{
    static const uint8_t BEGIN[16] = {137, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13, 'I', 'H', 'D', 'R'};
    if (size < 33 || memcmp(bytes, BEGIN, sizeof BEGIN) != 0 || bytes[24] != 8) return 0;
    if (bytes[26] || bytes[27] || bytes[28]) return 0;
    return bytes[25] == 2 ? 3 : bytes[25] == 6 ? 4 : 0;
}

/* Its compressed data, in one piece. */
typedef struct png_data {
    size_t at, size;
    int pieces;
} png_data;

/* Goes through the chunks. False: one of them is cut off or may change the picture. */
static bool find_png_data(const uint8_t *bytes, size_t size, png_data *out)
{
    *out = (png_data){0};
    for (size_t at = 33; size - at >= 12;) {
        const uint32_t length = big_endian(bytes + at);
        const uint8_t *type = bytes + at + 4;
        if (length > size - at - 12) return false;
        if (memcmp(type, "IEND", 4) == 0) return out->pieces > 0 && out->size <= INT_MAX;
        if (memcmp(type, "IDAT", 4) == 0) {
            if (!out->pieces++) out->at = at + 8;
            out->size += length;
        } else if (!(type[0] & 0x20) || memcmp(type, "tRNS", 4) == 0) {
            return false;
        }
        at += 12 + (size_t)length;
    }
    return false;
}

/* Moves all pieces to the first, and what ends the file behind them: it stays a file that says the same, but for sums
 * that nobody checks. Gives its size. */
static size_t join_png_data(uint8_t *bytes, const png_data *data)
{
    static const uint8_t END[12] = {0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};
    size_t to = data->at;
    for (size_t at = data->at - 8; memcmp(bytes + at + 4, "IEND", 4) != 0;) {
        const size_t length = big_endian(bytes + at), next = at + 12 + length;
        const bool piece = memcmp(bytes + at + 4, "IDAT", 4) == 0;
        if (piece) memmove(bytes + to, bytes + at + 8, length), to += length;
        at = next;
    }
    for (int k = 0; k < 4; k++) bytes[data->at - 8 + (size_t)k] = (uint8_t)(data->size >> (24 - 8 * k));
    memmove(bytes + to + 4, END, sizeof END);
    return to + 4 + sizeof END;
}

/* A row of the picture from its filtered bytes, which lie behind it and are overwritten, and the row above. The first
 * two are constants where this is inlined. */
static inline __attribute__((always_inline)) bool unfilter_as(int filter, size_t channels, const uint8_t *from,
                                                              const uint8_t *above, uint8_t *out, size_t width)
{
    int left[4] = {0}, before[4] = {0};
    for (size_t x = 0; x < width; x++, from += channels, above += 4, out += 4) {
        for (size_t k = 0; k < channels; k++) {
            const int up = above[k];
            const int guess = filter == STBI__F_sub     ? left[k]
                              : filter == STBI__F_up    ? up
                              : filter == STBI__F_avg   ? (left[k] + up) >> 1
                              : filter == STBI__F_paeth ? stbi__paeth(left[k], up, before[k])
                                                        : 0;
            left[k] = (from[k] + guess) & 255, before[k] = up;
        }
        for (size_t k = 0; k < channels; k++) out[k] = (uint8_t)left[k];
        if (channels == 3) out[3] = 255;
    }
    return true;
}

static inline __attribute__((always_inline)) bool unfilter_row(size_t channels, const uint8_t *from,
                                                               const uint8_t *above, uint8_t *out, size_t width)
{
    switch (*from) {
    case STBI__F_none: return unfilter_as(STBI__F_none, channels, from + 1, above, out, width);
    case STBI__F_sub: return unfilter_as(STBI__F_sub, channels, from + 1, above, out, width);
    case STBI__F_up: return unfilter_as(STBI__F_up, channels, from + 1, above, out, width);
    case STBI__F_avg: return unfilter_as(STBI__F_avg, channels, from + 1, above, out, width);
    case STBI__F_paeth: return unfilter_as(STBI__F_paeth, channels, from + 1, above, out, width);
    default: return false;
    }
}

/* Fills the picture from its rows, at the end of the same memory. They are read ahead of what is written: before pixel
 * i of row j, by (h - j)·(4 - n)·w - (4 - n)·i + j + 1 bytes. */
static bool unfilter(uint8_t *out, const uint8_t *rows, size_t width, size_t height, size_t channels)
{
    uint8_t *above = memset(daft_stb_malloc(4 * width), 0, 4 * width), *first = above;
    bool good = true;
    for (size_t y = 0; good && y < height; y++, above = out, out += 4 * width) {
        const uint8_t *from = rows + y * (channels * width + 1);
        good = channels == 3 ? unfilter_row(3, from, above, out, width) : unfilter_row(4, from, above, out, width);
    }
    daft_stb_free(first);
    return good;
}

/* NULL: left to stb_image. */
static uint8_t *decode_png(source *from, uint8_t *own, int width, int height)
{
    const uint8_t *bytes = (const uint8_t *)from->bytes;
    const size_t channels = (size_t)png_channels(bytes, from->size), w = (size_t)width, h = (size_t)height;
    png_data data;
    if (!channels || !find_png_data(bytes, from->size, &data) || (data.pieces > 1 && !own)) return NULL;
    if (data.pieces > 1) from->size = join_png_data(own, &data);
    const size_t packed = (channels * w + 1) * h, room = 4 * w * h + h;
    uint8_t *out = daft_stb_malloc(room), *rows = out + room - packed;
    if (packed <= INT_MAX &&
        stbi_zlib_decode_buffer((char *)rows, (int)packed, from->bytes + data.at, (int)data.size) == (int)packed &&
        unfilter(out, rows, w, h, channels))
        return out;
    daft_stb_free(out);
    return NULL;
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
    uint8_t *own;          /* the file's bytes, where they may be changed; or NULL */
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
    if (!d->is_hdr) {
        d->pixels = decode_png(&d->from, d->own, d->width, d->height);
        if (!d->pixels) d->pixels = decode_jpeg(d->from);
        if (d->pixels) return;
    }
    if (d->is_hdr)
        d->pixels = stbi_loadf_from_callbacks(&source_callbacks, &d->from, &d->width, &d->height, &channels, 3);
    else
        d->pixels = stbi_load_from_callbacks(&source_callbacks, &d->from, &d->width, &d->height, &channels, 4);
}

/* Bytes that are held at once for a pixel: of most PNG files the result; of other 8-bit files, at most, what the file
 * packs and the result, 4 bytes each; of HDR files the result. */
static uint64_t bytes_for_pixel(const char *bytes, size_t size, bool is_hdr)
{
    if (is_hdr) return 12;
    return png_channels((const uint8_t *)bytes, size) ? 4 : 8;
}

static bool can_afford(const daft_allocator *allocator, const char *path, int width, int height, uint64_t for_pixel,
                       daft_error *error)
{
    char what[64];
    snprintf(what, sizeof what, "an image of %d by %d pixels", width, height);
    return daft_budget_allows(allocator, (uint64_t)width * (uint64_t)height * for_pixel, path, what, error);
}

static bool decode(const daft_allocator *allocator, const char *bytes, size_t size, uint8_t *own, const char *path,
                   daft_decoded *out, daft_error *error)
{
    int width, height;
    if (!daft_decode_size(allocator, path, bytes, size, &width, &height, error)) return false;
    decoding d = {.from = {bytes, size, 0, false}, .own = own, .width = width, .height = height};
    d.is_hdr = stbi_is_hdr_from_memory((const uint8_t *)bytes, (int)size);
    if (d.is_hdr && !is_hdr_complete((const uint8_t *)bytes, size, width, height))
        return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "the image is truncated");
    if (!can_afford(allocator, path, width, height, bytes_for_pixel(bytes, size, d.is_hdr), error)) return false;
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

static bool decode_any(const daft_allocator *allocator, const char *bytes, size_t size, uint8_t *own, const char *path,
                       daft_decoded *out, daft_error *error)
{
    *out = (daft_decoded){0};
    if (size == 0) return daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "the file is empty, not an image");
    if (size > INT_MAX)
        return daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0, "image files over 2 GiB are not read");
    return decode(allocator, bytes, size, own, path, out, error);
}

bool daft_decode_bytes(const daft_allocator *allocator, const void *bytes, size_t size, const char *path,
                       daft_decoded *out, daft_error *error)
{
    return decode_any(allocator, bytes, size, NULL, path, out, error);
}

bool daft_decode_file(const daft_allocator *allocator, const daft_files *files, const char *path, daft_decoded *out,
                      daft_error *error)
{
    *out = (daft_decoded){0};
    size_t size;
    char *bytes = daft_file_read(allocator, files, path, &size, error);
    bool done = bytes && decode_any(allocator, bytes, size, (uint8_t *)bytes, path, out, error);
    daft_release(allocator, bytes);
    return done;
}

void daft_decoded_free(const daft_allocator *allocator, daft_decoded *decoded)
{
    daft_stb_release(allocator, decoded->bytes);
    daft_stb_release(allocator, decoded->floats);
    *decoded = (daft_decoded){0};
}
