/* The parts of reading text that are not hot: messages with places, numbers with exponents. */
#include "geometry/formats/text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

const double daft_powers_of_ten[23] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                       1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

daft_text daft_text_open(const char *path, const char *bytes, size_t size, const daft_log *log)
{
    bool marked = size >= 3 && memcmp(bytes, "\xEF\xBB\xBF", 3) == 0;
    return (daft_text){.path = path, .begin = bytes + (marked ? 3 : 0), .end = bytes + size, .log = log};
}

bool daft_text_check_encoding(const daft_text *text, daft_error *error)
{
    const char *b = text->begin;
    const size_t size = (size_t)(text->end - text->begin);
    const bool marked = size >= 2 && (memcmp(b, "\xFF\xFE", 2) == 0 || memcmp(b, "\xFE\xFF", 2) == 0);
    const bool wide = size >= 4 && ((b[0] && !b[1] && b[2] && !b[3]) || (!b[0] && b[1] && !b[2] && b[3]));
    return (!marked && !wide) ||
           daft_fail_at(error, DAFT_ERROR_SYNTAX, text->path, 1, 1, "this text is UTF-16: save it as UTF-8");
}

void daft_text_place(const daft_text *text, const char *at, int *line, int *column)
{
    const char *start = text->begin;
    *line = 1;
    for (const char *p = text->begin; p < at; p++) {
        if (*p != '\n' && (*p != '\r' || p[1] == '\n')) continue;
        ++*line;
        start = p + 1;
    }
    *column = at - start < INT32_MAX - 1 ? (int)(at - start) + 1 : INT32_MAX;
}

bool daft_text_fail(const daft_text *text, const char *at, daft_error *error, const char *format, ...)
{
    if (!error) return false; /* places are counted from the file's begin: time would be quadratic */
    char message[sizeof error->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    int line, column;
    daft_text_place(text, at, &line, &column);
    return daft_fail_at(error, DAFT_ERROR_SYNTAX, text->path, line, column, "%s", message);
}

void daft_text_warn(daft_text *text, const char *at, const char *format, ...)
{
    if (text->warnings++ >= DAFT_TEXT_WARNINGS || !text->log || !text->log->warn) return;
    daft_error warning;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(warning.message, sizeof warning.message, format, arguments);
    va_end(arguments);
    int line, column;
    daft_text_place(text, at, &line, &column);
    daft_warn_at(text->log, DAFT_ERROR_SYNTAX, text->path, line, column, "%s", warning.message);
}

bool daft_text_is_told(const daft_text *text) { return text->warnings < DAFT_TEXT_WARNINGS; }

void daft_text_lose(daft_text *text, const daft_error *why)
{
    if (text->warnings++ >= DAFT_TEXT_WARNINGS) return;
    daft_warn_at(text->log, why->code, why->file, why->line, why->column, "%s: the line is left out", why->message);
}

static bool is_first(daft_text *text, const char *at, size_t length)
{
    for (unsigned i = 0; i < text->keyword_count; i++)
        if (text->keywords[i].length == length && memcmp(text->keywords[i].at, at, length) == 0) return false;
    if (text->keyword_count < DAFT_TEXT_KEYWORDS) {
        text->keywords[text->keyword_count].at = at;
        text->keywords[text->keyword_count++].length = length;
    }
    return true;
}

void daft_text_warn_unknown(daft_text *text, const char *at, size_t length, const char *what)
{
    if (is_first(text, at, length))
        daft_text_warn(text, at, "unknown %s '%s' is skipped", what, daft_text_quote(at, length).text);
}

void daft_text_warn_not_drawn(daft_text *text, const char *at, size_t length)
{
    if (is_first(text, at, length))
        daft_text_warn(text, at, "'%s' is known, but not drawn", daft_text_quote(at, length).text);
}

void daft_text_close(daft_text *text)
{
    if (text->warnings <= DAFT_TEXT_WARNINGS) return;
    unsigned more = text->warnings - DAFT_TEXT_WARNINGS;
    daft_warn_at(text->log, DAFT_ERROR_SYNTAX, text->path, 0, 0, "and %u more warning%s", more, more == 1 ? "" : "s");
}

/* Bytes of the UTF-8 character at `at`; 1 for ASCII, 0 for bytes that are no character. */
static size_t character_length(const char *at, size_t left)
{
    unsigned char first = (unsigned char)at[0];
    size_t length = first < 0x80 ? 1 : first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
    for (size_t i = 1; i < length; i++)
        if (i >= left || ((unsigned char)at[i] & 0xC0) != 0x80) return 0;
    return length;
}

daft_quoted daft_text_quote(const char *at, size_t length)
{
    daft_quoted quoted;
    size_t used = 0, read = 0;
    while (read < length && used < 37) {
        size_t bytes = character_length(at + read, length - read);
        bool shown = bytes > 0 && (unsigned char)at[read] >= 32 && at[read] != 127;
        if (shown)
            memcpy(quoted.text + used, at + read, bytes);
        else
            quoted.text[used] = '?';
        used += shown ? bytes : 1;
        read += bytes ? bytes : 1;
    }
    snprintf(quoted.text + used, sizeof quoted.text - used, "%s", read < length ? "..." : "");
    return quoted;
}

bool daft_text_fail_number(const daft_text *text, const char *at, const char *keyword, daft_error *error)
{
    if (daft_at_end(text, at)) return daft_text_fail(text, at, error, "'%s' needs more numbers than this", keyword);
    size_t length = (size_t)(daft_skip_token(text, at) - at);
    return daft_text_fail(text, at, error, "'%s' is not a number", daft_text_quote(at, length).text);
}

const char *daft_skip_statement(const daft_text *text, const char *p)
{
    for (;;) {
        p = daft_skip_comment(text, p);
        if (p == text->end || p == text->begin || p[-1] != '\\') return p;
        p += p[0] == '\r' && p[1] == '\n' ? 2 : 1;
    }
}

const char *daft_rest_of_line(const daft_text *text, const char *p, size_t *length)
{
    const char *last = daft_skip_comment(text, p);
    while (p < last && daft_is_blank(*p)) p++;
    while (last > p && (daft_is_blank(last[-1]) || last[-1] == 0)) last--;
    *length = (size_t)(last - p);
    return p;
}

/* ---- numbers ---- */

/* digits·10^exponent. Each step of at most 10^22 rounds once, so a float made from the result is right but where the
 * true value lies within 4e-15 of the middle between two floats. */
static double scale_by_ten(uint64_t digits, int64_t exponent)
{
    double value = (double)digits;
    if (digits == 0 || exponent < -400) return 0;
    if (exponent > 310) return INFINITY;
    for (; exponent > 22; exponent -= 22) value *= daft_powers_of_ten[22];
    for (; exponent < -22; exponent += 22) value /= daft_powers_of_ten[22];
    return exponent >= 0 ? value * daft_powers_of_ten[exponent] : value / daft_powers_of_ten[-exponent];
}

/* Case-blind; returns the bytes matched, 0 for none. */
static size_t match(const char *p, const char *end, const char *word)
{
    size_t length = strlen(word);
    if ((size_t)(end - p) < length) return 0;
    for (size_t i = 0; i < length; i++)
        if ((p[i] | 32) != word[i]) return 0;
    return length;
}

/* nan, -nan(ind), inf, infinity; after the sign. */
static bool scan_word(const char **cursor, const char *end, double *out)
{
    const char *p = *cursor;
    size_t length = match(p, end, "nan");
    *out = length ? NAN : INFINITY;
    if (!length) length = match(p, end, "infinity");
    if (!length) length = match(p, end, "inf");
    if (!length) return false;
    p += length;
    if (*p == '(') {
        const char *q = p + 1;
        while (q < end && (((*q | 32) >= 'a' && (*q | 32) <= 'z') || (unsigned)(*q - '0') < 10 || *q == '_')) q++;
        if (*q == ')') p = q + 1;
    }
    *cursor = p;
    return true;
}

/* Digits around an optional point: up to 19 are kept, the rest only moves the exponent. */
static const char *scan_mantissa(const char *p, const char *end, uint64_t *digits, int64_t *exponent, bool *any)
{
    int kept = 0;
    bool point = false;
    *digits = 0, *exponent = 0, *any = false;
    for (; p < end; p++) {
        if (*p == '.' && !point) {
            point = true;
            continue;
        }
        unsigned digit = (unsigned)(*p - '0');
        if (digit > 9) break;
        *any = true;
        if (kept == 19) {
            *exponent += !point;
            continue;
        }
        *digits = *digits * 10 + digit;
        kept += *digits != 0; /* leading zeros do not count */
        *exponent -= point;
    }
    return p;
}

bool daft_scan_number_slow(const char **cursor, const char *end, double *out)
{
    const char *p = *cursor;
    bool negative = *p == '-';
    p += negative || *p == '+';
    uint64_t digits;
    int64_t exponent, written = 0;
    bool any;
    const char *after = scan_mantissa(p, end, &digits, &exponent, &any);
    if (!any) {
        if (!scan_word(&p, end, out)) return false;
        if (negative) *out = -*out;
        *cursor = p;
        return true;
    }
    p = after;
    if (*p == '#') { /* 1.#QNAN, 1.#IND, 1.#INF */
        do p++;
        while (p < end && (((*p | 32) >= 'a' && (*p | 32) <= 'z') || (unsigned)(*p - '0') < 10));
        *out = NAN;
        *cursor = p;
        return true;
    }
    if ((*p | 32) == 'e') {
        const char *q = p + 1;
        if (!daft_scan_integer(&q, end, &written)) return false;
        p = q;
    }
    *out = scale_by_ten(digits, exponent + written);
    if (negative) *out = -*out;
    *cursor = p;
    return true;
}
