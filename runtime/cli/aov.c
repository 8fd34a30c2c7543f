/* Depth and normals go to PFM files, which keep every bit of a float: "Pf" or "PF", width and height, -1.0 for
 * little-endian floats, then the rows from the lowest up (Debevec's format, as OpenCV and ImageMagick read it). Numbers
 * go to PNG files of three bytes a pixel: red + 256·green + 65536·blue. */
#include "cli/aov.h"

#include "cli/cli.h"
#include "common/util.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const NAMES[AOV_COUNT] = {"depth", "normal", "id", "triangle"};
static const char *const EXTENSIONS[AOV_COUNT] = {"pfm", "pfm", "png", "png"};

/* ---- the list of channels ---- */

static bool parse_word(const char *word, size_t length, aov_set *set)
{
    char text[32], hint[HINT_SIZE];
    snprintf(text, sizeof text, "%.*s", (int)length, word);
    for (int i = 0; i < AOV_COUNT; i++) {
        if (strcmp(text, NAMES[i]) != 0) continue;
        set->wanted[i] = true;
        return true;
    }
    cli_refuse("render", "--aov: a list of depth, normal, id, triangle expected, got '%s'%s", text,
               did_you_mean(hint, "", text, NAMES, AOV_COUNT));
    return false;
}

bool aov_parse(const char *list, aov_set *set)
{
    for (const char *word = list;; word++) {
        size_t length = strcspn(word, ",");
        if (!parse_word(word, length, set)) return false;
        word += length;
        if (!*word) return true;
    }
}

bool aov_allocate(aov_set *set, int width, int height, daft_error *error)
{
    size_t pixels = (size_t)width * (size_t)height;
    set->width = width, set->height = height;
    daft_aov *a = &set->arrays;
    if (set->wanted[AOV_DEPTH]) a->depth = malloc(pixels * sizeof *a->depth);
    if (set->wanted[AOV_NORMAL]) a->normal = malloc(pixels * sizeof *a->normal);
    if (set->wanted[AOV_ID]) a->entity = malloc(pixels * sizeof *a->entity);
    if (set->wanted[AOV_TRIANGLE]) a->triangle = malloc(pixels * sizeof *a->triangle);
    const void *const arrays[AOV_COUNT] = {a->depth, a->normal, a->entity, a->triangle};
    for (int i = 0; i < AOV_COUNT; i++)
        if (set->wanted[i] && !arrays[i]) return fail(error, DAFT_ERROR_MEMORY, "out of memory for %s", NAMES[i]);
    return true;
}

void aov_free(aov_set *set)
{
    free(set->arrays.depth);
    free(set->arrays.normal);
    free(set->arrays.entity);
    free(set->arrays.triangle);
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

static void put_rows(FILE *out, const aov_set *set, int kind)
{
    fprintf(out, "%s\n%d %d\n-1.0\n", kind == AOV_NORMAL ? "PF" : "Pf", set->width, set->height);
    for (int y = set->height - 1; y >= 0; y--) {
        size_t row = (size_t)y * (size_t)set->width;
        for (size_t at = row; at < row + (size_t)set->width; at++) {
            if (kind == AOV_DEPTH) {
                put_float(out, set->arrays.depth[at]);
            } else {
                daft_vec3 n = set->arrays.normal[at];
                put_float(out, n.x), put_float(out, n.y), put_float(out, n.z);
            }
        }
    }
}

static bool write_floats(const aov_set *set, int kind, const char *path, daft_error *error)
{
    draft_file out;
    if (!draft_open(&out, error)) return false;
    put_rows(out.file, set, kind);
    return draft_commit(&out, path, error);
}

static bool write_numbers(const aov_set *set, int kind, daft_engine *engine, const char *path, daft_error *error)
{
    daft_image *image = daft_image_create(engine, set->width, set->height, error);
    if (!image) return false;
    uint8_t *pixels = daft_image_pixels(image);
    size_t count = (size_t)set->width * (size_t)set->height;
    uint32_t largest = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t number = kind == AOV_ID ? set->arrays.entity[i].id : set->arrays.triangle[i];
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

bool aov_write(const aov_set *set, daft_engine *engine, const char *image, daft_error *error)
{
    const char *dot = strrchr(image, '.');
    int stem = dot ? (int)(dot - image) : (int)strlen(image);
    for (int i = 0; i < AOV_COUNT; i++) {
        char path[PATH_SIZE];
        if (!set->wanted[i]) continue;
        int length = snprintf(path, sizeof path, "%.*s.%s.%s", stem, image, NAMES[i], EXTENSIONS[i]);
        if (length < 0 || (size_t)length >= sizeof path)
            return fail(error, DAFT_ERROR_ARGUMENT, "the name of the picture is too long");
        bool good = strcmp(EXTENSIONS[i], "pfm") == 0 ? write_floats(set, i, path, error)
                                                      : write_numbers(set, i, engine, path, error);
        if (!good) return false;
    }
    return true;
}
