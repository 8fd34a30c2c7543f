/* Text in JSON files, and a reader of objects (RFC 8259, without what no file of DAFT has: lists of anything but
 * numbers). */
#include "common/json.h"

#include "common/util.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- writing ---- */

void json_put_text(FILE *out, const char *text)
{
    fputc('"', out);
    for (const unsigned char *c = (const unsigned char *)(text ? text : ""); *c; c++) {
        if (*c == '"' || *c == '\\')
            fprintf(out, "\\%c", *c);
        else if (*c < 0x20 || *c == 0x7F)
            fprintf(out, "\\u%04x", *c);
        else
            fputc(*c, out);
    }
    fputc('"', out);
}

static bool is_written(const daft_field *field)
{
    switch (field->type) {
    case DAFT_FIELD_MESH:
    case DAFT_FIELD_TEXTURE:
    case DAFT_FIELD_MATERIAL:
    case DAFT_FIELD_ENTITY:
    case DAFT_FIELD_TEXT:
    case DAFT_FIELD_OTHER: return false;
    default: return true;
    }
}

static void put_value(FILE *out, const daft_field *field, const void *value)
{
    char text[200];
    daft_field_print(field, value, text, sizeof text);
    if (field->type == DAFT_FIELD_CHOICE)
        json_put_text(out, text);
    else
        fprintf(out, strchr(text, ',') ? "[%s]" : "%s", text);
}

void json_put_struct(FILE *out, daft_struct which, const void *value, int indent)
{
    uint32_t count;
    const daft_field *fields = daft_fields(which, &count);
    const char *between = "";
    fputc('{', out);
    for (uint32_t i = 0; i < count; i++) {
        if (!is_written(&fields[i])) continue;
        fprintf(out, "%s\n%*s", between, indent + 2, "");
        json_put_text(out, fields[i].name);
        fputs(": ", out);
        if (fields[i].type == DAFT_FIELD_STRUCT)
            json_put_struct(out, fields[i].nested, (const char *)value + fields[i].offset, indent + 2);
        else
            put_value(out, &fields[i], value);
        between = ",";
    }
    fprintf(out, "\n%*s}", indent, "");
}

/* ---- reading ---- */

void json_open(json_reader *out, const char *file, const char *text, daft_error *error)
{
    *out = (json_reader){.file = file, .text = text, .at = text, .error = error};
}

bool json_fail(json_reader *in, const char *format, ...)
{
    char message[300];
    int line = 1, column = 1;
    va_list list;
    if (in->failed) return false;
    in->failed = true;
    for (const char *c = in->text; c < in->at; c++) {
        column = *c == '\n' ? 1 : column + 1;
        line += *c == '\n';
    }
    va_start(list, format);
    vsnprintf(message, sizeof message, format, list);
    va_end(list);
    return fail_at(in->error, in->file, line, column, "%s", message);
}

static char next(json_reader *in)
{
    if (in->failed) return 0;
    in->at += strspn(in->at, " \t\r\n");
    return *in->at;
}

static bool take(json_reader *in, char wanted)
{
    if (next(in) != wanted) return json_fail(in, "'%c' expected", wanted);
    in->at++;
    return true;
}

bool json_begin(json_reader *in)
{
    in->fresh = true;
    return take(in, '{');
}

bool json_end(json_reader *in) { return !next(in) ? !in->failed : json_fail(in, "the end of the file expected"); }

/* \u and four digits, as UTF-8; the halves of a pair of surrogates become a byte sequence each, as they stand. */
static bool take_code(json_reader *in, char *out, size_t *length)
{
    char digits[5] = {0};
    for (int i = 0; i < 4; i++) {
        digits[i] = *in->at;
        if (!*in->at || !strchr("0123456789abcdefABCDEF", *in->at))
            return json_fail(in, "four hexadecimal digits expected");
        in->at++;
    }
    unsigned long code = strtoul(digits, NULL, 16);
    if (code == 0) return json_fail(in, "a zero character cannot be part of a text");
    if (code < 0x80) {
        out[(*length)++] = (char)code;
    } else if (code < 0x800) {
        out[(*length)++] = (char)(0xC0 | code >> 6);
        out[(*length)++] = (char)(0x80 | (code & 0x3F));
    } else {
        out[(*length)++] = (char)(0xE0 | code >> 12);
        out[(*length)++] = (char)(0x80 | (code >> 6 & 0x3F));
        out[(*length)++] = (char)(0x80 | (code & 0x3F));
    }
    return true;
}

static bool take_escape(json_reader *in, char *out, size_t *length)
{
    static const char MARKS[] = "\"\\/bfnrt", VALUES[] = "\"\\/\b\f\n\r\t";
    const char *mark = *in->at ? strchr(MARKS, *in->at) : NULL;
    if (mark) {
        in->at++;
        out[(*length)++] = VALUES[mark - MARKS];
        return true;
    }
    if (*in->at != 'u') return json_fail(in, "unknown escape in a text");
    in->at++;
    return take_code(in, out, length);
}

bool json_get_text(json_reader *in, char *out, size_t size)
{
    size_t length = 0;
    out[0] = 0;
    if (!take(in, '"')) return false;
    while (*in->at != '"') {
        char bytes[4];
        size_t count = 0;
        if ((unsigned char)*in->at < 0x20) return json_fail(in, "a text that does not end in its line");
        if (*in->at == '\\') {
            in->at++;
            if (!take_escape(in, bytes, &count)) return false;
        } else {
            bytes[count++] = *in->at++;
        }
        if (length + count >= size) return json_fail(in, "a text that is too long");
        memcpy(out + length, bytes, count);
        out[length += count] = 0;
    }
    in->at++;
    return true;
}

bool json_key(json_reader *in, char *key, size_t size)
{
    char c = next(in);
    if (c == '}') {
        in->at++;
        return in->fresh = false;
    }
    if (!in->fresh && !take(in, ',')) return false;
    in->fresh = false;
    next(in);
    in->key = in->at;
    return json_get_text(in, key, size) && take(in, ':');
}

bool json_unknown(json_reader *in, const char *key)
{
    in->at = in->key;
    return json_fail(in, "unknown name '%s'", key);
}

/* A number, or true or false, as it stands. */
static bool take_word(json_reader *in, char *out, size_t size)
{
    next(in);
    size_t length = in->failed ? 0 : strspn(in->at, "+-.0123456789abcdefghijklmnopqrstuvwxyzE");
    if (length == 0 || length >= size) return json_fail(in, "a value expected");
    memcpy(out, in->at, length);
    out[length] = 0;
    in->at += length;
    return true;
}

bool json_get_number(json_reader *in, double *out)
{
    char word[64];
    const char *begin = in->at;
    if (!take_word(in, word, sizeof word)) return false;
    /* As the library reads numbers, whatever the locale. */
    const daft_field number = {.name = "number", .type = DAFT_FIELD_DOUBLE, .size = sizeof *out};
    daft_error error;
    if (daft_field_parse(&number, word, out, &error)) return true;
    in->at = begin;
    return json_fail(in, "a number expected, got %.40s", word);
}

/* As daft_field_parse wants it: components with commas between. */
static bool take_list(json_reader *in, char *out, size_t size)
{
    size_t used = 0;
    if (!take(in, '[')) return false;
    do {
        if (used > 0) out[used++] = ',';
        if (!take_word(in, out + used, size - used)) return false;
        used += strlen(out + used);
        if (used + 2 > size) return json_fail(in, "a list that is too long");
    } while (next(in) == ',' && take(in, ','));
    return take(in, ']');
}

static bool get_field(json_reader *in, const daft_field *field, void *value)
{
    char text[200];
    char c = next(in);
    const char *begin = in->at;
    daft_error error;
    if (field->type == DAFT_FIELD_STRUCT) return json_get_struct(in, field->nested, (char *)value + field->offset);
    bool good = c == '"'   ? json_get_text(in, text, sizeof text)
                : c == '[' ? take_list(in, text, sizeof text)
                           : take_word(in, text, sizeof text);
    if (!good || daft_field_parse(field, text, value, &error)) return good;
    in->at = begin;
    return json_fail(in, "%s", error.message);
}

bool json_get_struct(json_reader *in, daft_struct which, void *value)
{
    char key[64];
    if (!json_begin(in)) return false;
    while (json_key(in, key, sizeof key)) {
        const daft_field *field = daft_field_find(which, key);
        if (!field || !is_written(field)) return json_unknown(in, key);
        if (!get_field(in, field, value)) return false;
    }
    return !in->failed;
}
