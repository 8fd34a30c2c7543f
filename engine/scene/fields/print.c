/* Fields as text: printing and parsing. Numbers have a decimal point whatever the program's locale says. */
#include "scene/fields/check.h"
#include "scene/fields/number.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- printing ---- */

/* Six digits, or as many as give the same float or double again. */
static void print_number(double number, bool single, char *out, size_t size)
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(out, size, "%.*g", digits, number);
        double back = strtod(out, NULL);
        if (single ? (float)back == (float)number : back == number) break;
    }
    for (char *c = out; *c; c++)
        if (*c == ',') *c = '.'; /* a locale's decimal comma */
}

static const char *choice_name(const daft_field *field, uint32_t value)
{
    return value < field->choice_count && field->choices[value] ? field->choices[value] : "unknown";
}

const char *daft_field_print(const daft_field *field, const void *value, char *buffer, size_t size)
{
    double numbers[4];
    if (!buffer || size == 0) return buffer;
    buffer[0] = 0;
    if (!field || !value) return buffer;
    uint32_t count = daft_field_numbers(field, value, numbers);
    if (field->type == DAFT_FIELD_BOOL || field->type == DAFT_FIELD_CHOICE) {
        const char *name = field->type == DAFT_FIELD_BOOL ? (numbers[0] != 0 ? "true" : "false")
                                                          : choice_name(field, (uint32_t)numbers[0]);
        snprintf(buffer, size, "%s", name);
    } else if (field->type >= DAFT_FIELD_MESH && field->type <= DAFT_FIELD_ENTITY && numbers[0] == 0) {
        snprintf(buffer, size, "none");
    } else if (field->type == DAFT_FIELD_TEXT) {
        const char *text;
        memcpy(&text, (const char *)value + field->offset, sizeof text);
        snprintf(buffer, size, "%s", text ? text : "none");
    }
    if (buffer[0]) return buffer;
    bool whole = field->type == DAFT_FIELD_INT || field->type == DAFT_FIELD_UINT || field->type == DAFT_FIELD_UINT64;
    bool single = !whole && field->size / (count ? count : 1) == sizeof(float);
    for (uint32_t i = 0; i < count; i++) {
        char number[40];
        size_t used = strlen(buffer);
        print_number(numbers[i], single, number, sizeof number);
        snprintf(buffer + used, size - used, "%s%s", i ? ", " : "", number);
    }
    return buffer;
}

/* ---- parsing ---- */

static bool fail_form(const daft_field *field, const char *text, daft_error *error)
{
    char range[256];
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s is '%.40s'; it must be %s", field->name, text,
                     daft_field_range(field, range, sizeof range));
}

static bool parse_bool(const daft_field *field, const char *text, double *out, daft_error *error)
{
    static const char *const NAMES[] = {"false", "true", "off", "on", "no", "yes", "0", "1"};
    for (size_t i = 0; i < DAFT_COUNT_OF(NAMES); i++) {
        if (strcmp(text, NAMES[i]) != 0) continue;
        *out = (double)(i % 2);
        return true;
    }
    return fail_form(field, text, error);
}

static bool parse_choice(const daft_field *field, const char *text, double *out, daft_error *error)
{
    for (uint32_t i = 0; i < field->choice_count; i++) {
        if (!field->choices[i] || strcmp(text, field->choices[i]) != 0) continue;
        *out = i;
        return true;
    }
    return fail_form(field, text, error);
}

static bool parse_numbers(const daft_field *field, const char *text, uint32_t count, double *out, daft_error *error)
{
    const char *at = text;
    for (uint32_t i = 0; i < count; i++) {
        size_t length = strcspn(at, ",");
        const char *first = at + strspn(at, " ");
        size_t inner = length - (size_t)(first - at);
        while (inner > 0 && first[inner - 1] == ' ') inner--;
        bool last = i + 1 == count;
        if (!daft_number_parse(first, inner, &out[i]) || (at[length] == 0) != last)
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s is '%.40s'; %s", field->name, text,
                             count == 1 ? "it must be a number" : "it must be numbers with commas between them");
        at += length + 1;
    }
    return true;
}

static bool fits_type(const daft_field *field, const double *numbers, uint32_t count, daft_error *error)
{
    bool whole = field->type == DAFT_FIELD_INT || field->type == DAFT_FIELD_UINT || field->type == DAFT_FIELD_UINT64;
    double low = field->type == DAFT_FIELD_INT ? -2147483648.0 : 0;
    double high = field->type == DAFT_FIELD_INT ? 2147483647.0 : field->type == DAFT_FIELD_UINT ? 4294967295.0 : 0x1p53;
    for (uint32_t i = 0; whole && i < count; i++)
        if (!(numbers[i] >= low && numbers[i] <= high) || numbers[i] != floor(numbers[i]))
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s is %g; it must be a whole number between %g and %g",
                             field->name, numbers[i], low, high);
    return true;
}

bool daft_field_parse(const daft_field *field, const char *text, void *value, daft_error *error)
{
    double numbers[4] = {0};
    daft_error_clear(error);
    if (!daft_check_pointer(error, "field", field) || !daft_check_pointer(error, "text", text) ||
        !daft_check_pointer(error, "value", value))
        return false;
    if (field->type >= DAFT_FIELD_MESH)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s cannot be set from text", field->name);
    uint32_t count = daft_field_numbers(field, value, numbers);
    bool parsed = field->type == DAFT_FIELD_BOOL     ? parse_bool(field, text, numbers, error)
                  : field->type == DAFT_FIELD_CHOICE ? parse_choice(field, text, numbers, error)
                                                     : parse_numbers(field, text, count, numbers, error);
    if (!parsed || !fits_type(field, numbers, count, error)) return false;
    char tried[4 * sizeof(double)]; /* of one field */
    daft_field moved = *field;
    moved.offset = 0;
    daft_field_set_numbers(&moved, tried, numbers);
    if (!daft_field_check(&moved, tried, "", error)) return false;
    daft_field_set_numbers(field, value, numbers);
    return true;
}
