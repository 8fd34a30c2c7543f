#include "scene/fields/number.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t count_digits(const char *at, const char *end)
{
    const char *start = at;
    while (at < end && *at >= '0' && *at <= '9') at++;
    return (size_t)(at - start);
}

static bool is_number(const char *at, const char *end)
{
    if (at < end && (*at == '+' || *at == '-')) at++;
    size_t before = count_digits(at, end), after = 0;
    at += before;
    if (at < end && *at == '.') {
        after = count_digits(at + 1, end);
        at += after + 1;
    }
    if (before + after == 0) return false;
    if (at < end && (*at == 'e' || *at == 'E')) {
        at++;
        if (at < end && (*at == '+' || *at == '-')) at++;
        size_t exponent = count_digits(at, end);
        if (exponent == 0) return false;
        at += exponent;
    }
    return at == end;
}

/* strtod rounds correctly, but reads the decimal point of the host program's locale. */
static double to_double(const char *text, size_t length)
{
    char buffer[DAFT_LONGEST_NUMBER + 17];
    const char *point = memchr(text, '.', length);
    int before = (int)(point ? point - text : (ptrdiff_t)length);
    if (point)
        snprintf(buffer, sizeof buffer, "%.*s%.8s%.*s", before, text, localeconv()->decimal_point,
                 (int)length - before - 1, point + 1);
    else
        snprintf(buffer, sizeof buffer, "%.*s", before, text);
    return strtod(buffer, NULL);
}

bool daft_number_parse(const char *text, size_t length, double *out)
{
    if (length > DAFT_LONGEST_NUMBER || !is_number(text, text + length)) return false;
    *out = to_double(text, length);
    return true;
}
