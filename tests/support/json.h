/* A checker of JSON's grammar, no more: json_value gives what follows the value at c, or NULL where it is not one. */
#ifndef TEST_JSON_H
#define TEST_JSON_H

#include <stdlib.h>
#include <string.h>

static inline const char *json_blanks(const char *c) { return c + strspn(c, " \t\r\n"); }
static const char *json_value(const char *c);

static inline const char *json_string(const char *c)
{
    if (*c++ != '"') return NULL;
    for (; *c && *c != '"'; c++) {
        if ((unsigned char)*c < 0x20) return NULL;
        if (*c == '\\' && !strchr("\"\\/bfnrtu", *++c)) return NULL;
    }
    return *c == '"' ? c + 1 : NULL;
}

/* The inside of an object (named) or a list. */
static inline const char *json_items(const char *c, char end, int named)
{
    c = json_blanks(c + 1);
    if (*c == end) return c + 1;
    for (;;) {
        if (named) {
            c = json_string(json_blanks(c));
            if (!c || *(c = json_blanks(c)) != ':') return NULL;
            c++;
        }
        c = json_value(json_blanks(c));
        if (!c) return NULL;
        c = json_blanks(c);
        if (*c == end) return c + 1;
        if (*c++ != ',') return NULL;
    }
}

static const char *json_value(const char *c)
{
    if (*c == '{') return json_items(c, '}', 1);
    if (*c == '[') return json_items(c, ']', 0);
    if (*c == '"') return json_string(c);
    if (strncmp(c, "true", 4) == 0 || strncmp(c, "null", 4) == 0) return c + 4;
    if (strncmp(c, "false", 5) == 0) return c + 5;
    char *end;
    if (!strchr("-0123456789", *c)) return NULL; /* NaN and infinity are not JSON */
    strtod(c, &end);
    return end > c ? end : NULL;
}

#endif
