/* The quality presets, and the names of qualities, intersections and accelerators. */
#include "render/render.h"

#include <string.h>

/* Half a step of 8-bit sRGB is 1/3300 of white. */
static const daft_preset PRESETS[] = {
    [DAFT_QUALITY_DRAFT] = {.name = "draft", .samples = 1, .refractions = 6, .min_weight = 1.0f / 256},
    [DAFT_QUALITY_GAME] = {.name = "game", .samples = 1, .reflections = 2, .refractions = 12, .min_weight = 1.0f / 2048, .shadows = true},
    [DAFT_QUALITY_HIGH] = {.name = "high", .samples = 4, .reflections = 6, .refractions = 16, .min_weight = 1.0f / 2048, .shadows = true},
    [DAFT_QUALITY_REFERENCE] = {.name = "reference", .samples = 16, .reflections = 10, .refractions = 24, .min_weight = 1.0f / 4096,
                                .shadows = true, .reference = true},
};

const daft_preset *daft_quality_preset(daft_quality quality)
{
    return (unsigned)quality < DAFT_COUNT_OF(PRESETS) ? &PRESETS[quality] : NULL;
}

static const char *const INTERSECTIONS[] = {
    [DAFT_INTERSECT_EXACT] = "exact", [DAFT_INTERSECT_WATERTIGHT] = "watertight", [DAFT_INTERSECT_FAST] = "fast"};

const char *daft_intersection_name(daft_intersection intersection)
{
    return (unsigned)intersection < DAFT_COUNT_OF(INTERSECTIONS) ? INTERSECTIONS[intersection] : "unknown";
}

bool daft_intersection_parse(const char *name, daft_intersection *out)
{
    for (unsigned i = 0; i < DAFT_COUNT_OF(INTERSECTIONS); i++) {
        if (strcmp(name, INTERSECTIONS[i]) != 0) continue;
        *out = (daft_intersection)i;
        return true;
    }
    return false;
}

static const char *const ACCELS[] = {"bvh", "kdtree"};

const char *daft_accel_name(daft_accel accel)
{
    return (unsigned)accel < DAFT_COUNT_OF(ACCELS) ? ACCELS[accel] : "unknown";
}

bool daft_accel_parse(const char *name, daft_accel *out)
{
    for (unsigned i = 0; i < DAFT_COUNT_OF(ACCELS); i++) {
        if (strcmp(name, ACCELS[i]) != 0) continue;
        *out = (daft_accel)i;
        return true;
    }
    return false;
}

const char *daft_quality_name(daft_quality quality)
{
    const daft_preset *preset = daft_quality_preset(quality);
    return preset ? preset->name : "unknown";
}

bool daft_quality_parse(const char *name, daft_quality *out)
{
    for (unsigned i = 0; i < DAFT_COUNT_OF(PRESETS); i++) {
        if (strcmp(name, PRESETS[i].name) != 0) continue;
        *out = (daft_quality)i;
        return true;
    }
    return false;
}
