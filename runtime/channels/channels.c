/* Depth, normals, colours and motion go to PFM files, which keep every bit of a float: "Pf" or "PF", width and height,
 * -1.0 for little-endian floats, then the rows from the lowest up (Debevec's format, as OpenCV and ImageMagick read
 * it); motion has a third value, 0. Numbers go to PNG files of three bytes a pixel: red + 256·green + 65536·blue. */
#include "channels/channels.h"

#include "channels/exr.h"
#include "common/util.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct channel_row {
    const char *name;
    size_t offset, bytes; /* of its array in daft_aov; of a pixel */
    int floats;           /* of a pixel; 0: one unsigned number */
    const char *layers[3];
} channel_row;

#define ROW(member, floats, ...)                                                                                       \
    offsetof(daft_aov, member), sizeof *((daft_aov *)NULL)->member, floats, { __VA_ARGS__ }

static const channel_row ROWS[CHANNEL_COUNT] = {
    [CHANNEL_DEPTH] = {"depth", ROW(depth, 1, "depth.Z")},
    [CHANNEL_NORMAL] = {"normal", ROW(normal, 3, "normal.X", "normal.Y", "normal.Z")},
    [CHANNEL_ID] = {"id", ROW(entity, 0, "entity.id")},
    [CHANNEL_TRIANGLE] = {"triangle", ROW(triangle, 0, "triangle.id")},
    [CHANNEL_COLOR] = {"color", ROW(color, 3, "R", "G", "B")},
    [CHANNEL_ALBEDO] = {"albedo", ROW(albedo, 3, "albedo.R", "albedo.G", "albedo.B")},
    [CHANNEL_MOTION] = {"motion", ROW(motion, 2, "motion.X", "motion.Y")},
    [CHANNEL_COST] = {"cost", ROW(cost, 0, "cost.rays")},
};

/* ---- the list of channels ---- */

static bool parse_word(const char *word, size_t length, channel_set *set, daft_error *error)
{
    char text[32], hint[HINT_SIZE];
    const char *names[CHANNEL_COUNT];
    snprintf(text, sizeof text, "%.*s", (int)length, word);
    for (int i = 0; i < CHANNEL_COUNT; i++) {
        names[i] = ROWS[i].name;
        if (strcmp(text, names[i]) != 0) continue;
        set->wanted[i] = true;
        return true;
    }
    return fail(error, DAFT_ERROR_ARGUMENT,
                "--aov: a list of depth, normal, id, triangle, color, albedo, motion, cost expected, got '%s'%s", text,
                did_you_mean(hint, "", text, names, CHANNEL_COUNT));
}

bool channels_parse(const char *list, channel_set *set, daft_error *error)
{
    for (const char *word = list;; word++) {
        size_t length = strcspn(word, ",");
        if (!parse_word(word, length, set, error)) return false;
        word += length;
        if (!*word) return true;
    }
}

/* ---- arrays ---- */

static void **member(daft_aov *arrays, channel_kind kind) { return (void **)((char *)arrays + ROWS[kind].offset); }

void *channels_array(const daft_aov *arrays, channel_kind kind, size_t *bytes)
{
    daft_aov copy = *arrays;
    *bytes = ROWS[kind].bytes;
    return *member(&copy, kind);
}

bool channels_allocate(channel_set *set, int width, int height, daft_error *error)
{
    size_t pixels = (size_t)width * (size_t)height;
    set->width = width, set->height = height;
    for (int i = 0; i < CHANNEL_COUNT; i++) {
        if (!set->wanted[i]) continue;
        void *array = calloc(pixels, ROWS[i].bytes);
        *member(&set->arrays, (channel_kind)i) = array;
        if (!array) return fail(error, DAFT_ERROR_MEMORY, "out of memory for %s", ROWS[i].name);
    }
    return true;
}

void channels_free(channel_set *set)
{
    for (int i = 0; i < CHANNEL_COUNT; i++) free(*member(&set->arrays, (channel_kind)i));
    set->arrays = (daft_aov){0};
}

/* ---- files ---- */

static void put_float(FILE *out, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const unsigned char bytes[4] = {(unsigned char)bits, (unsigned char)(bits >> 8), (unsigned char)(bits >> 16),
                                    (unsigned char)(bits >> 24)};
    fwrite(bytes, 1, sizeof bytes, out);
}

static void put_rows(FILE *out, const channel_set *set, channel_kind kind)
{
    size_t bytes, width = (size_t)set->width;
    const int floats = ROWS[kind].floats;
    const char *array = channels_array(&set->arrays, kind, &bytes);
    fprintf(out, "%s\n%d %d\n-1.0\n", floats > 1 ? "PF" : "Pf", set->width, set->height);
    for (int y = set->height - 1; y >= 0; y--)
        for (size_t at = (size_t)y * width; at < ((size_t)y + 1) * width; at++) {
            float values[3] = {0, 0, 0};
            memcpy(values, array + at * bytes, bytes);
            for (int k = 0; k < (floats > 1 ? 3 : 1); k++) put_float(out, values[k]);
        }
}

static bool write_floats(const channel_set *set, channel_kind kind, const char *path, daft_error *error)
{
    draft_file out;
    if (!draft_open(&out, error)) return false;
    put_rows(out.file, set, kind);
    return draft_commit(&out, path, error);
}

static bool write_numbers(const channel_set *set, channel_kind kind, daft_engine *engine, const char *path,
                          daft_error *error)
{
    daft_image *image = daft_image_create(engine, set->width, set->height, error);
    if (!image) return false;
    size_t bytes, count = (size_t)set->width * (size_t)set->height;
    const char *array = channels_array(&set->arrays, kind, &bytes);
    uint8_t *pixels = daft_image_pixels(image);
    uint32_t largest = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t number;
        memcpy(&number, array + i * bytes, sizeof number);
        largest = number > largest ? number : largest;
        for (size_t k = 0; k < 3; k++) pixels[4 * i + k] = (uint8_t)(number >> (8 * k));
        pixels[4 * i + 3] = 255;
    }
    bool good = largest < 1u << 24
                    ? daft_image_write(image, path, error)
                    : fail_at(error, path, 0, 0, "number %u does not fit the 24 bits of a pixel", largest);
    daft_image_destroy(image);
    return good;
}

bool channels_write(const channel_set *set, daft_engine *engine, const char *image, daft_error *error)
{
    const char *dot = strrchr(image, '.');
    int stem = dot ? (int)(dot - image) : (int)strlen(image);
    for (int i = 0; i < CHANNEL_COUNT; i++) {
        char path[PATH_SIZE];
        const bool floats = ROWS[i].floats > 0;
        if (!set->wanted[i]) continue;
        int length = snprintf(path, sizeof path, "%.*s.%s.%s", stem, image, ROWS[i].name, floats ? "pfm" : "png");
        if (length < 0 || (size_t)length >= sizeof path)
            return fail(error, DAFT_ERROR_ARGUMENT, "the name of the picture is too long");
        if (!(floats ? write_floats(set, (channel_kind)i, path, error)
                     : write_numbers(set, (channel_kind)i, engine, path, error)))
            return false;
    }
    return true;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const exr_channel *)a)->name, ((const exr_channel *)b)->name);
}

bool channels_write_exr(const channel_set *set, const char *path, daft_error *error)
{
    exr_channel all[3 * CHANNEL_COUNT];
    int count = 0;
    for (int i = 0; i < CHANNEL_COUNT; i++) {
        size_t bytes;
        const char *array = channels_array(&set->arrays, (channel_kind)i, &bytes);
        for (int k = 0; array && k < 3 && ROWS[i].layers[k]; k++)
            all[count++] = (exr_channel){ROWS[i].layers[k], array + 4 * k, (int)bytes, ROWS[i].floats > 0};
    }
    qsort(all, (size_t)count, sizeof all[0], by_name);
    return exr_write(path, all, count, set->width, set->height, error);
}
