/* Reading knobs by the fields of daft_quality, and joining what several places say about them. */
#include "common/quality.h"

#include "common/util.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_KNOBS = 32, NUMBER_TEXT = 40 };

static bool fail_unknown(const char *name, daft_error *error)
{
    const char *names[MAX_KNOBS];
    char hint[HINT_SIZE];
    uint32_t count;
    const daft_field *fields = daft_fields(DAFT_STRUCT_QUALITY, &count);
    for (uint32_t i = 0; i < count; i++) names[i] = fields[i].name;
    return fail(error, DAFT_ERROR_ARGUMENT, "there is no knob '%s'%s", name,
                did_you_mean(hint, "", name, names, count));
}

/* "1/64" becomes "0.015625"; other texts stay as they are. */
static const char *divide(const char *text, char out[NUMBER_TEXT])
{
    char *end, *last;
    const double above = strtod(text, &end);
    if (end == text || *end != '/') return text;
    const double below = strtod(end + 1, &last);
    if (last == end + 1 || *last || !(below > 0)) return text;
    snprintf(out, NUMBER_TEXT, "%.17g", above / below);
    return out;
}

static bool apply_word(char *word, daft_quality *quality, daft_error *error)
{
    char *value = strchr(word, '='), number[NUMBER_TEXT], range[128];
    if (!value) return fail(error, DAFT_ERROR_ARGUMENT, "knob '%s': NAME=VALUE expected", word);
    *value++ = 0;
    const daft_field *field = daft_field_find(DAFT_STRUCT_QUALITY, word);
    if (!field) return fail_unknown(word, error);
    if (daft_field_parse(field, divide(value, number), quality, error)) return true;
    return fail(error, DAFT_ERROR_ARGUMENT, "knob %s: '%s' is none of its values (%s)", word, value,
                daft_field_range(field, range, sizeof range));
}

bool quality_parse(const char *list, daft_quality *quality, daft_error *error)
{
    char *copy = strdup(list), *rest = NULL;
    if (!copy) return fail(error, DAFT_ERROR_MEMORY, "out of memory");
    daft_quality chosen = *quality;
    bool good = true;
    for (char *word = strtok_r(copy, ",", &rest); good && word; word = strtok_r(NULL, ",", &rest))
        good = apply_word(word, &chosen, error);
    free(copy);
    if (good) *quality = chosen;
    return good;
}

bool quality_equal(const daft_quality *a, const daft_quality *b)
{
    uint8_t bytes[2][sizeof *a];
    const size_t size = daft_struct_pack(DAFT_STRUCT_QUALITY, a, bytes[0], sizeof bytes[0]);
    daft_struct_pack(DAFT_STRUCT_QUALITY, b, bytes[1], sizeof bytes[1]);
    return memcmp(bytes[0], bytes[1], size) == 0;
}

daft_quality quality_choose(const quality_wish *wish, const daft_scene *scene)
{
    daft_quality quality =
        wish->preset == QUALITY_OF_SCENE ? daft_scene_quality(scene) : daft_preset_quality(wish->preset);
    daft_error ignored;
    if (wish->knobs) quality_parse(wish->knobs, &quality, &ignored);
    return quality;
}
