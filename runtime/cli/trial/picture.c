/* Pictures that tests compare: reading, measuring, and what is left of a failure. */
#include "cli/trial/trial.h"

#include "common/util.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

typedef struct difference {
    double max, mean; /* of the channels, 0 to 1 */
    int x, y;         /* the first pixel with the largest */
} difference;

static int larger(int a, int b) { return a > b ? a : b; }

/* Both have one size. Each pixel of `map` becomes its difference, four times as bright. */
static difference measure(const uint8_t *a, const uint8_t *b, int width, int height, uint8_t *map)
{
    difference out = {0};
    int max = -1;
    uint64_t sum = 0;
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++) {
        for (size_t c = 0; c < 3; c++) {
            const int d = abs(a[4 * i + c] - b[4 * i + c]);
            sum += (uint64_t)d;
            if (d > max) max = d, out.x = (int)(i % (size_t)width), out.y = (int)(i / (size_t)width);
            map[4 * i + c] = (uint8_t)(d > 63 ? 255 : 4 * d);
        }
        map[4 * i + 3] = 255;
    }
    out.max = larger(max, 0) / 255.0;
    out.mean = (double)sum / (255.0 * 3 * (double)width * (double)height);
    return out;
}

static bool make_folder(const trials *t, const char *name, char out[PATH_SIZE])
{
    return path_join(out, PATH_SIZE, t->info.folder, name) && (mkdir(out, 0777) == 0 || path_is_folder(out));
}

/* tests/FOLDER/NAME+ENDING; the folder is made. */
static bool write_picture(const trials *t, const daft_image *image, const char *folder, const char *name,
                          const char *ending, char path[PATH_SIZE], daft_error *error)
{
    char within[PATH_SIZE], file[TRIAL_NAME + 16];
    snprintf(file, sizeof file, "%s%s", name, ending);
    if (!make_folder(t, folder, within) || !path_join(path, PATH_SIZE, within, file))
        return fail_at(error, t->info.folder, 0, 0, "the folder %s cannot be made", folder);
    return daft_image_write(image, path, error);
}

static bool keep_as_reference(trials *t, const trial_picture *wanted, char *why, size_t size)
{
    char path[PATH_SIZE], text[1100];
    daft_error error;
    if (write_picture(t, t->picture, "tests/pictures", wanted->name, ".png", path, &error)) {
        printf("      wrote %s\n", path);
        t->written++;
        return true;
    }
    snprintf(why, size, "%s", daft_error_text(&error, text, sizeof text));
    return false;
}

/* Leaves the picture, and the map of what differs unless it is NULL. Returns where the picture lies. */
static void leave(const trials *t, const trial_picture *wanted, const daft_image *map, char path[PATH_SIZE])
{
    char other[PATH_SIZE];
    daft_error error;
    if (!write_picture(t, t->picture, "tests/failed", wanted->name, ".png", path, &error) ||
        (map && !write_picture(t, map, "tests/failed", wanted->name, "-diff.png", other, &error)))
        report(&error);
}

static bool compare(trials *t, const trial_picture *wanted, daft_image *reference, char *why, size_t size)
{
    char path[PATH_SIZE] = "";
    const int width = daft_image_width(t->picture), height = daft_image_height(t->picture);
    if (daft_image_width(reference) != width || daft_image_height(reference) != height) {
        leave(t, wanted, NULL, path);
        snprintf(why, size, "the picture '%s' has %dx%d pixels, not %dx%d: see %s", wanted->name, width, height,
                 daft_image_width(reference), daft_image_height(reference), path);
        return false;
    }
    daft_error error;
    daft_image *map = daft_image_create(t->engine, width, height, &error);
    if (!map) {
        snprintf(why, size, "%s", error.message);
        return false;
    }
    const difference d =
        measure(daft_image_pixels(t->picture), daft_image_pixels(reference), width, height, daft_image_pixels(map));
    const bool good = d.max <= wanted->max && d.mean <= wanted->mean;
    if (!good) {
        leave(t, wanted, map, path);
        snprintf(
            why, size,
            "the picture '%s' differs: by %.3f at most, at %d, %d (%.3g allowed), %.4f on the mean (%.3g allowed)\n"
            "      see %s and %s-diff.png beside it",
            wanted->name, d.max, d.x, d.y, wanted->max, d.mean, wanted->mean, path, wanted->name);
    }
    daft_image_destroy(map);
    return good;
}

bool trials_compare(trials *t, const trial_picture *wanted, char *why, size_t size)
{
    char name[PATH_SIZE], path[PATH_SIZE] = "", found[PATH_SIZE];
    daft_error error;
    snprintf(name, sizeof name, "tests/pictures/%s.png", wanted->name);
    const bool there = daft_files_find(t->source.own, name, found, sizeof found);
    if (!there && t->update) return keep_as_reference(t, wanted, why, size);
    if (!there) {
        leave(t, wanted, NULL, path);
        snprintf(why, size, "there is no picture %s yet: look at %s, and keep it by --update", name, path);
        return false;
    }
    daft_image *reference = daft_image_load(t->engine, found, &error);
    if (!reference) {
        char text[1100];
        snprintf(why, size, "%s", daft_error_text(&error, text, sizeof text));
        return false;
    }
    bool good = compare(t, wanted, reference, why, size);
    daft_image_destroy(reference);
    if (good || !t->update) return good;
    why[0] = 0;
    return keep_as_reference(t, wanted, why, size);
}
