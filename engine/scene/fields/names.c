/* The names of enums that programs ask for by name: the lists of fields have them. */
#include "scene/fields/fields.h"

#include <string.h>

static const char *choice_name(daft_struct which, const char *field, uint32_t value)
{
    const daft_field *f = daft_field_find(which, field);
    return value < f->choice_count && f->choices[value] ? f->choices[value] : "unknown";
}

static bool choice_parse(daft_struct which, const char *field, const char *name, uint32_t *out)
{
    const daft_field *f = daft_field_find(which, field);
    if (!name || !out) return false;
    for (uint32_t i = 0; i < f->choice_count; i++) {
        if (!f->choices[i] || strcmp(name, f->choices[i]) != 0) continue;
        *out = i;
        return true;
    }
    return false;
}

const char *daft_accel_name(daft_accel accel) { return choice_name(DAFT_STRUCT_ENGINE_DEF, "accel", accel); }
const char *daft_intersection_name(daft_intersection intersection)
{
    return choice_name(DAFT_STRUCT_QUALITY, "visibility", intersection);
}

bool daft_accel_parse(const char *name, daft_accel *out)
{
    return choice_parse(DAFT_STRUCT_ENGINE_DEF, "accel", name, out);
}
bool daft_intersection_parse(const char *name, daft_intersection *out)
{
    return choice_parse(DAFT_STRUCT_QUALITY, "visibility", name, out);
}

/* ---- presets, which are no field -------------------------------------------------------------------------------- */

static const char *const PRESETS[] = {"draft", "game", "high", "reference"};

const char *daft_preset_name(daft_preset preset)
{
    return (unsigned)preset < DAFT_COUNT_OF(PRESETS) ? PRESETS[preset] : "unknown";
}

bool daft_preset_parse(const char *name, daft_preset *out)
{
    for (uint32_t i = 0; name && out && i < DAFT_COUNT_OF(PRESETS); i++) {
        if (strcmp(name, PRESETS[i]) != 0) continue;
        *out = (daft_preset)i;
        return true;
    }
    return false;
}
