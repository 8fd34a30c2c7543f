/* Ranges of fields: what is within them, and how they are told, in the same words everywhere. */
#include "scene/fields/check.h"

#include <stdio.h>
#include <string.h>

/* ---- words ---- */

static void add(char *buffer, size_t size, const char *text)
{
    size_t used = strlen(buffer);
    if (used < size) snprintf(buffer + used, size - used, "%s", text);
}

/* "point, sun or spot" */
static void choices_text(const daft_field *field, char *buffer, size_t size)
{
    uint32_t last = field->choice_count;
    while (last > 0 && !field->choices[last - 1]) last--;
    bool first = true;
    for (uint32_t i = 0; i < last; i++) {
        if (!field->choices[i]) continue;
        if (!first) add(buffer, size, i + 1 == last ? " or " : ", ");
        add(buffer, size, field->choices[i]);
        first = false;
    }
}

static void limits_text(const daft_field *field, char *buffer, size_t size)
{
    const char *blank = field->unit ? " " : "", *unit = field->unit ? field->unit : "";
    bool above = field->min == DAFT_ABOVE_ZERO;
    if (field->min == 0 && field->max == 0)
        snprintf(buffer, size, "finite");
    else if (isinf(field->max) && above)
        snprintf(buffer, size, "finite and above 0");
    else if (isinf(field->max))
        snprintf(buffer, size, "finite and %g or more", field->min);
    else if (above)
        snprintf(buffer, size, "above 0 and at most %g%s%s", field->max, blank, unit);
    else
        snprintf(buffer, size, "between %g and %g%s%s", field->min, field->max, blank, unit);
}

/* "1, 4, 8 or 16" */
static void values_text(const daft_field *field, char *buffer, size_t size)
{
    for (uint32_t i = 0; i < field->value_count; i++) {
        char number[32];
        snprintf(number, sizeof number, "%s%g",
                 i == 0                        ? ""
                 : i + 1 == field->value_count ? " or "
                                               : ", ",
                 field->values[i]);
        add(buffer, size, number);
    }
}

const char *daft_field_range(const daft_field *field, char *buffer, size_t size)
{
    if (!buffer || size == 0) return buffer;
    buffer[0] = 0;
    if (!field) return buffer;
    if (field->type == DAFT_FIELD_CHOICE)
        choices_text(field, buffer, size);
    else if (field->type == DAFT_FIELD_BOOL)
        add(buffer, size, "true or false");
    else if (field->value_count > 0)
        values_text(field, buffer, size);
    else if (field->type < DAFT_FIELD_MESH)
        limits_text(field, buffer, size);
    return buffer;
}

/* ---- checks ---- */

static void limits_of(const daft_field *field, bool used, double *min, double *max)
{
    bool any = !used || (field->min == 0 && field->max == 0);
    double largest = field->type == DAFT_FIELD_DOUBLE || field->type == DAFT_FIELD_POSITION ? DBL_MAX : DAFT_ANY_FLOAT;
    *min = any ? -largest : field->min;
    *max = any || isinf(field->max) ? largest : field->max;
}

void daft_field_limits(const daft_field *field, double *min, double *max) { limits_of(field, true, min, max); }

static bool choice_check(const daft_field *field, uint32_t value, const char *before, daft_error *error)
{
    if (value < field->choice_count && field->choices[value]) return true;
    char range[256];
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s%s is %d; it must be %s", before, field->name, (int)value,
                     daft_field_range(field, range, sizeof range));
}

static bool fail_component(const daft_field *field, bool used, uint32_t component, double value, uint32_t count,
                           const char *before, daft_error *error)
{
    char range[256], part[3] = {'.', "xyzw"[component], 0};
    if (count == 1) part[0] = 0;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s%s%s is %g; it must be %s", before, field->name, part, value,
                     used ? daft_field_range(field, range, sizeof range) : "finite");
}

static bool is_listed(const daft_field *field, double number)
{
    for (uint32_t i = 0; i < field->value_count; i++)
        if (field->values[i] == number) return true;
    return field->value_count == 0;
}

static bool all_zero(const double *numbers, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (numbers[i] != 0) return false;
    return true;
}

/* A field that the struct's kind does not use need only be finite. */
static bool check_used(const daft_field *field, bool used, const void *value, const char *before, daft_error *error)
{
    double numbers[4];
    uint32_t count = daft_field_numbers(field, value, numbers);
    if (field->type == DAFT_FIELD_CHOICE) return choice_check(field, (uint32_t)numbers[0], before, error);
    if (field->type == DAFT_FIELD_BOOL || field->type >= DAFT_FIELD_MESH) return true;
    double min, max;
    limits_of(field, used, &min, &max);
    for (uint32_t i = 0; i < count; i++)
        if (!(numbers[i] >= min && numbers[i] <= max) || !is_listed(field, numbers[i]))
            return fail_component(field, used, i, numbers[i], count, before, error);
    if (!used || !all_zero(numbers, count)) return true;
    if (field->type == DAFT_FIELD_DIRECTION)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s%s is 0, 0, 0; it must have a length", before, field->name);
    if (field->type == DAFT_FIELD_ROTATION)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s%s is 0, 0, 0, 0; it must be a quaternion that is not zero",
                         before, field->name);
    return true;
}

bool daft_field_check(const daft_field *field, const void *value, const char *before, daft_error *error)
{
    return check_used(field, true, value, before, error);
}

bool daft_struct_check_named(daft_struct which, const void *value, const char *before, daft_error *error)
{
    const daft_field_list *list = daft_field_list_of(which);
    for (uint32_t i = 0; i < list->count; i++) {
        const daft_field *field = &list->fields[i];
        if (field->type == DAFT_FIELD_STRUCT) {
            char inner[96];
            snprintf(inner, sizeof inner, "%s%s.", before, field->name);
            if (!daft_struct_check_named(field->nested, (const char *)value + field->offset, inner, error))
                return false;
        } else if (!check_used(field, daft_field_used(list, field, value), value, before, error)) {
            return false;
        }
    }
    return true;
}

/* "daft_light_def" is made by daft_default_light_def. */
static bool cookie_check(const daft_field_list *list, const void *value, daft_error *error)
{
    uint32_t cookie;
    if (strcmp(list->fields[0].name, "cookie") != 0) return true;
    memcpy(&cookie, (const char *)value + list->fields[0].offset, sizeof cookie);
    char maker[96];
    snprintf(maker, sizeof maker, "daft_default_%s", list->name + strlen("daft_"));
    return daft_check_cookie(error, cookie, maker);
}

bool daft_struct_check(daft_struct which, const void *value, daft_error *error)
{
    daft_error_clear(error);
    const daft_field_list *list = daft_field_list_of(which);
    if (!list) return daft_fail(error, DAFT_ERROR_ARGUMENT, "there is no struct %d", (int)which);
    return daft_check_pointer(error, list->name, value) && cookie_check(list, value, error) &&
           daft_struct_check_named(which, value, "", error);
}
