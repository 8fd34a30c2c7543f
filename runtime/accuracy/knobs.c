/* The table of knobs, and reading and printing their settings. */
#include "accuracy/knobs.h"

#include "common/util.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SCALE,
    VISIBILITY,
    SAMPLES,
    EDGES,
    SHADOWS,
    SOFT,
    OCCLUSION,
    GLOSSY,
    DENOISE,
    MIRRORS,
    REFRACTION,
    WEIGHT,
    REFERENCE
};

static const knob_row TABLE[KNOBS] = {
    [SCALE] = {"scale", "sides of the drawn picture, relative to the shown one; bilinear between", {0.5, 0.75, 1}, 3},
    [VISIBILITY] = {"intersection", "how rays and triangles meet: fast, watertight or exact", {2, 1, 0}, 3},
    [SAMPLES] = {"samples", "of a pixel", {1, 4, 8, 16}, 4},
    [EDGES] = {"edge_samples",
               "more where neighbours differ: 4 at outlines, 16 at edges of shadows, too",
               {0, 4, 16},
               3},
    [SHADOWS] = {"shadows", "0: none, 1: of every light", {0, 1}, 2},
    [SOFT] = {"shadow_samples", "rays to a light that has a size; 0: sharp shadows", {0, 1, 4, 16}, 4},
    [OCCLUSION] = {"occlusion_samples", "rays around a point, where the scene has ambient occlusion", {0, 1, 4, 16}, 4},
    [GLOSSY] = {"glossy_samples", "rays that a rough surface sends on; 0: none is rough", {0, 1, 4, 16}, 4},
    [DENOISE] = {"denoise", "0: not, 1: what is sampled is filtered", {0, 1}, 2},
    [MIRRORS] = {"mirror_depth", "mirror bounces followed", {0, 1, 2, 4, 8}, 5},
    [REFRACTION] = {"refraction_depth", "surfaces that a path through transparent ones may meet", {0, 2, 6, 12, 24}, 5},
    [WEIGHT] = {"min_weight",
                "mirrored and refracted rays below it are not cast",
                {1.0 / 16, 1.0 / 64, 1.0 / 256, 1.0 / 2048},
                4},
    [REFERENCE] = {"reference", "1: camera rays alone through the BVH", {0, 1}, 2},
};

const knob_row *knob_at(size_t index) { return &TABLE[index]; }

bool knob_is_by_rays(size_t index, double value) { return index == REFERENCE && value > 0; }

void knob_apply(knob_set *set, size_t index, double value)
{
    daft_view *v = &set->view;
    switch (index) {
    case SCALE: set->scale = value; break;
    case VISIBILITY: v->intersection = (daft_intersection)value; break;
    case SAMPLES: v->samples = (int)value; break;
    case EDGES: v->edge_samples = (int)value; break;
    case SHADOWS: v->shadows = (int)value; break;
    case SOFT: v->shadow_samples = (int)value; break;
    case OCCLUSION: v->occlusion_samples = (int)value; break;
    case GLOSSY: v->glossy_samples = (int)value; break;
    case DENOISE: v->denoise = (int)value; break;
    case MIRRORS: v->mirror_depth = (int)value; break;
    case REFRACTION: v->refraction_depth = (int)value; break;
    case WEIGHT: v->min_weight = (float)value; break;
    case REFERENCE: v->reference = value > 0; break;
    default: break;
    }
}

char *knob_print(char out[KNOB_TEXT], size_t index, double value)
{
    if (index == VISIBILITY)
        snprintf(out, KNOB_TEXT, "intersection=%s", daft_intersection_name((daft_intersection)value));
    else if (index == WEIGHT && value > 0)
        snprintf(out, KNOB_TEXT, "min_weight=1/%g", round(1 / value));
    else
        snprintf(out, KNOB_TEXT, "%s=%g", TABLE[index].name, value);
    return out;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* The range of each knob; samples have their own rule in daft_render. */
static bool in_range(size_t index, double value)
{
    bool whole = value == floor(value);
    switch (index) {
    case SCALE: return value >= 0.1 && value <= 1;
    case SAMPLES: return value == 1 || value == 4 || value == 8 || value == 16;
    case EDGES: return value == 0 || value == 4 || value == 16;
    case SOFT:
    case OCCLUSION: return whole && value >= 0 && value <= 64;
    case SHADOWS:
    case DENOISE:
    case REFERENCE: return value == 0 || value == 1;
    case WEIGHT: return value >= 0 && value <= 1;
    default: return whole && value >= 0 && value <= 32;
    }
}

static bool read_value(size_t index, const char *text, double *out)
{
    daft_intersection how;
    if (index == VISIBILITY) {
        if (!daft_intersection_parse(text, &how)) return false;
        *out = how;
        return true;
    }
    char *end;
    *out = strtod(text, &end);
    if (*end == '/' && end != text) {
        char *last;
        double below = strtod(end + 1, &last);
        if (last == end + 1) return false;
        *out /= below, end = last;
    }
    return end != text && *end == 0 && in_range(index, *out);
}

static bool apply_word(char *word, knob_set *out, daft_error *error)
{
    const char *names[KNOBS];
    char *value = strchr(word, '='), hint[HINT_SIZE];
    if (!value) return fail(error, DAFT_ERROR_ARGUMENT, "knob '%s': NAME=VALUE expected", word);
    *value++ = 0;
    for (size_t i = 0; i < KNOBS; i++) {
        double number;
        names[i] = TABLE[i].name;
        if (strcmp(word, TABLE[i].name) != 0) continue;
        if (!read_value(i, value, &number))
            return fail(error, DAFT_ERROR_ARGUMENT, "knob %s: '%s' is none of its values (%s)", word, value,
                        TABLE[i].doc);
        knob_apply(out, i, number);
        return true;
    }
    return fail(error, DAFT_ERROR_ARGUMENT, "there is no knob '%s'%s", word,
                did_you_mean(hint, "", word, names, KNOBS));
}

bool knobs_parse(const char *list, knob_set *out, daft_error *error)
{
    char *copy = strdup(list), *rest = NULL;
    if (!copy) return fail(error, DAFT_ERROR_MEMORY, "out of memory");
    bool good = true;
    for (char *word = strtok_r(copy, ",", &rest); good && word; word = strtok_r(NULL, ",", &rest))
        good = apply_word(word, out, error);
    free(copy);
    return good;
}
