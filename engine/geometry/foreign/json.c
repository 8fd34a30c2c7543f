/* Walking through a JSON text. Without recursion, since a file may nest as deep as it likes. */
#include "geometry/foreign/json.h"

#include "geometry/formats/text.h"

#include <math.h>

static const daft_json NOTHING = {NULL, NULL};

static const char *skip_space(const char *p, const char *end)
{
    while (p < end && (daft_is_blank(*p) || daft_is_break(*p))) p++;
    return p;
}

/* From its opening quote to behind its closing one. */
static const char *skip_string(const char *p, const char *end)
{
    for (p++; p < end && *p != '"'; p++)
        if (*p == '\\' && p + 1 < end) p++;
    return p < end ? p + 1 : end;
}

static const char *skip_value(const char *p, const char *end)
{
    size_t depth = 0;
    while (p < end) {
        const char c = *p;
        if (depth == 0 && (c == ',' || c == '}' || c == ']' || daft_is_blank(c) || daft_is_break(c))) return p;
        p = c == '"' ? skip_string(p, end) : p + 1;
        if (c == '{' || c == '[') depth++;
        if (c == '}' || c == ']') depth--;
        if (depth == 0 && (c == '"' || c == '}' || c == ']')) return p;
    }
    return end;
}

daft_json daft_json_open(const char *text, size_t size)
{
    return (daft_json){skip_space(text, text + size), text + size};
}

const char *daft_json_behind(daft_json value) { return value.at ? skip_value(value.at, value.end) : value.end; }

static bool begins_with(daft_json value, char c) { return value.at && value.at < value.end && *value.at == c; }

daft_json daft_json_member(daft_json object, const char *name)
{
    const char *end = object.end;
    if (!begins_with(object, '{')) return NOTHING;
    for (const char *p = skip_space(object.at + 1, end); p < end && *p == '"'; p = skip_space(p + 1, end)) {
        const char *key = p + 1;
        p = skip_string(p, end);
        const bool found = (size_t)(p - key) == strlen(name) + 1 && memcmp(key, name, strlen(name)) == 0;
        p = skip_space(p, end);
        if (p == end || *p != ':') break;
        p = skip_space(p + 1, end);
        if (found) return (daft_json){p, end};
        p = skip_space(skip_value(p, end), end);
        if (p == end || *p != ',') break;
    }
    return NOTHING;
}

daft_json daft_json_first(daft_json array)
{
    if (!begins_with(array, '[')) return NOTHING;
    const char *p = skip_space(array.at + 1, array.end);
    return p == array.end || *p == ']' ? NOTHING : (daft_json){p, array.end};
}

daft_json daft_json_next(daft_json item)
{
    if (!item.at) return NOTHING;
    const char *p = skip_space(skip_value(item.at, item.end), item.end);
    if (p == item.end || *p != ',') return NOTHING;
    p = skip_space(p + 1, item.end);
    return p == item.end ? NOTHING : (daft_json){p, item.end};
}

double daft_json_number(daft_json value, double other)
{
    double number;
    const char *p = value.at;
    return p && p < value.end && daft_scan_number(&p, value.end, &number) && isfinite(number) ? number : other;
}

uint32_t daft_json_index(daft_json value)
{
    const double number = daft_json_number(value, -1);
    return number >= 0 && number < UINT32_MAX && number == floor(number) ? (uint32_t)number : UINT32_MAX;
}

bool daft_json_is(daft_json value, const char *text)
{
    const size_t length = strlen(text);
    return begins_with(value, '"') && (size_t)(value.end - value.at) >= length + 2 &&
           memcmp(value.at + 1, text, length) == 0 && value.at[length + 1] == '"';
}

/* ---- strings ---- */

/* Four hexadecimal digits; 0 where they are none. */
static uint32_t read_hex(const char *p, const char *end)
{
    uint32_t code = 0;
    for (int i = 0; i < 4; i++, p++) {
        const char c = p < end ? *p : 0;
        const int digit = c >= '0' && c <= '9'                 ? c - '0'
                          : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10
                                                               : -1;
        if (digit < 0) return 0;
        code = code << 4 | (uint32_t)digit;
    }
    return code;
}

/* A code point as UTF-8. Returns how many bytes. */
static size_t encode(uint32_t code, char out[4])
{
    if (code < 0x80) return out[0] = (char)code, 1;
    const size_t more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static const uint8_t FIRST[] = {0, 0xc0, 0xe0, 0xf0};
    out[0] = (char)(FIRST[more] | code >> 6 * more);
    for (size_t i = 1; i <= more; i++) out[i] = (char)(0x80 | (code >> 6 * (more - i) & 0x3f));
    return more + 1;
}

/* What stands behind a backslash; moves the cursor behind it. */
static size_t read_escape(const char **cursor, const char *end, char out[4])
{
    static const char NAMES[] = "bfnrt", BYTES[] = "\b\f\n\r\t";
    const char *p = *cursor, *named = p < end && *p ? strchr(NAMES, *p) : NULL;
    *cursor = p + 1;
    if (p < end && *p == 'u') {
        uint32_t code = read_hex(p + 1, end);
        *cursor = end - p < 5 ? end : p + 5;
        if (code >= 0xd800 && code < 0xdc00 && end - p >= 11 && p[5] == '\\' && p[6] == 'u') {
            const uint32_t low = read_hex(p + 7, end);
            code = 0x10000 + ((code - 0xd800) << 10) + (low & 0x3ff), *cursor = p + 11;
        }
        return encode(code ? code : '?', out);
    }
    out[0] = named ? BYTES[named - NAMES] : p < end ? *p : '?';
    return 1;
}

void daft_json_string(daft_json value, char *out, size_t size)
{
    size_t used = 0;
    const char *p = begins_with(value, '"') ? value.at + 1 : value.end, *end = value.end;
    while (p < end && *p != '"') {
        char bytes[4] = {*p++};
        const size_t count = bytes[0] == '\\' ? read_escape(&p, end, bytes) : 1;
        if (used + count >= size) break;
        memcpy(out + used, bytes, count), used += count;
    }
    out[used] = 0;
}
