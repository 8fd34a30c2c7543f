/* Reading a line of a .scene file. A '#' begins a comment where a word could begin, and after a number; inside a word
 * it is a character like any other, since "file.mtl#name" is a path. Columns count bytes from 1. */
#include "scene/format/text.h"

#include "scene/fields/number.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

daft_scene_text daft_scene_text_open(const char *path, const char *text, size_t size, daft_error *error)
{
    const char *start = text;
    if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) start += 3; /* UTF-8's byte order mark */
    return (daft_scene_text){
        .path = path, .end = text + size, .line_start = start, .at = start, .line = 1, .usage = "", .error = error};
}

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

static int column_of(const daft_scene_text *text, const char *at) { return (int)(at - text->line_start) + 1; }

bool daft_scene_text_ends(daft_scene_text *text)
{
    while (text->at < text->end && is_blank(*text->at)) text->at++;
    return text->at == text->end || *text->at == '\n' || *text->at == '#';
}

bool daft_scene_text_next_is(daft_scene_text *text, const char *word)
{
    const size_t length = strlen(word);
    if (daft_scene_text_ends(text) || (size_t)(text->end - text->at) < length || memcmp(text->at, word, length) != 0)
        return false;
    return text->at + length == text->end || strchr(" \t\r\n#", text->at[length]);
}

void daft_scene_text_skip_item(daft_scene_text *text)
{
    while (text->block && daft_scene_text_line(text)) {
        text->block = !daft_scene_text_next_is(text, "}");
        while (text->at < text->end && !is_blank(*text->at) && *text->at != '\n') text->at++;
    }
    text->block = false;
    const char *newline = memchr(text->at, '\n', (size_t)(text->end - text->at));
    text->at = newline ? newline : text->end;
}

bool daft_scene_text_line(daft_scene_text *text)
{
    while (daft_scene_text_ends(text)) {
        const char *newline = memchr(text->at, '\n', (size_t)(text->end - text->at));
        if (!newline) return false;
        text->at = text->line_start = newline + 1;
        text->line++;
    }
    return true;
}

bool daft_scene_text_fail(const daft_scene_text *text, int column, const char *format, ...)
{
    char message[sizeof text->error->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return daft_fail_at(text->error, DAFT_ERROR_SYNTAX, text->path, text->line, column, "%s", message);
}

daft_shown daft_token_show(daft_token token)
{
    daft_shown shown;
    enum { LONGEST = 40 };
    size_t length = token.length > LONGEST ? LONGEST : token.length;
    for (size_t i = 0; i < length; i++) shown.text[i] = (unsigned char)token.text[i] < ' ' ? '?' : token.text[i];
    strcpy(shown.text + length, token.length > LONGEST ? "..." : "");
    return shown;
}

static bool fail_missing(daft_scene_text *text, const char *what)
{
    return daft_scene_text_fail(text, column_of(text, text->at), "expected %s, but the line ends; the form is: %s",
                                what, text->usage);
}

static bool read_quoted(daft_scene_text *text, daft_token *out)
{
    const char *start = text->at + 1, *at = start;
    while (at < text->end && *at != '"' && *at != '\n') at++;
    if (at == text->end || *at == '\n')
        return daft_scene_text_fail(text, column_of(text, text->at), "the quote is not closed on its line");
    *out = (daft_token){start, (size_t)(at - start), column_of(text, text->at)};
    text->at = at + 1;
    if (text->at < text->end && !is_blank(*text->at) && *text->at != '\n')
        return daft_scene_text_fail(text, column_of(text, text->at), "expected a blank after the closing quote");
    return true;
}

bool daft_scene_text_word(daft_scene_text *text, const char *what, daft_token *out)
{
    if (daft_scene_text_ends(text)) return fail_missing(text, what);
    if (*text->at == '"') {
        if (!read_quoted(text, out)) return false;
    } else {
        const char *start = text->at;
        while (text->at < text->end && !is_blank(*text->at) && *text->at != '\n') text->at++;
        *out = (daft_token){start, (size_t)(text->at - start), column_of(text, start)};
    }
    if (out->length == 0) return daft_scene_text_fail(text, out->column, "expected %s, but it is empty", what);
    if (!memchr(out->text, 0, out->length)) return true;
    return daft_scene_text_fail(text, out->column, "%s has a zero byte in it", what);
}

/* ---- numbers ---- */

bool daft_scene_text_number(daft_scene_text *text, const char *what, double low, double high, const char *allowed,
                            double *out)
{
    if (daft_scene_text_ends(text)) return fail_missing(text, what);
    const char *start = text->at;
    while (text->at < text->end && !is_blank(*text->at) && *text->at != '\n' && *text->at != '#') text->at++;
    daft_token token = {start, (size_t)(text->at - start), column_of(text, start)};
    if (token.length > DAFT_LONGEST_NUMBER)
        return daft_scene_text_fail(text, token.column, "%s has more than %d characters", what, DAFT_LONGEST_NUMBER);
    if (!daft_number_parse(token.text, token.length, out))
        return daft_scene_text_fail(text, token.column, "expected %s (a number), '%s' came; the form is: %s", what,
                                    daft_token_show(token).text, text->usage);
    if (*out >= low && *out <= high) return true;
    return daft_scene_text_fail(text, token.column, "%s is %s; it must be %s", what, daft_token_show(token).text,
                                allowed);
}

bool daft_scene_text_finish(daft_scene_text *text)
{
    if (daft_scene_text_ends(text)) return true;
    daft_token token;
    int column = column_of(text, text->at);
    if (!daft_scene_text_word(text, "the rest of the line", &token)) return false;
    return daft_scene_text_fail(text, column, "unexpected '%s'; the form is: %s", daft_token_show(token).text,
                                text->usage);
}

/* ---- names that were meant ---- */

/* Levenshtein's distance; UINT32_MAX where one of them has more than 40 letters. */
static uint32_t distance(const char *a, const char *b)
{
    enum { LONGEST = 40 };
    uint32_t row[LONGEST + 1], n = (uint32_t)strnlen(a, LONGEST + 1), m = (uint32_t)strnlen(b, LONGEST + 1);
    if (n > LONGEST || m > LONGEST) return UINT32_MAX;
    for (uint32_t k = 0; k <= m; k++) row[k] = k;
    for (uint32_t i = 1; i <= n; i++) {
        uint32_t corner = row[0];
        row[0] = i;
        for (uint32_t k = 1; k <= m; k++) {
            uint32_t least = corner + (a[i - 1] != b[k - 1]);
            corner = row[k];
            if (row[k] + 1 < least) least = row[k] + 1;
            if (row[k - 1] + 1 < least) least = row[k - 1] + 1;
            row[k] = least;
        }
    }
    return row[m];
}

const char *daft_scene_text_nearer(const char *written, const char *name, const char *near)
{
    const uint32_t d = distance(written, name);
    if (d > (strlen(written) + 2) / 3) return near;
    return !near || d < distance(written, near) ? name : near;
}
