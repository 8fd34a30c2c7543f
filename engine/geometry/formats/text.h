/* Reading line-based text formats: blanks, tokens, numbers; messages that say line and column.
 *
 * The text ends with a zero byte at `end`; zero bytes before that are ordinary (wrong) characters. A line ends with LF,
 * CR or CRLF. A backslash before a line end joins the two lines and counts as a blank. Lines are counted only when a
 * message needs them, so reading pays nothing for good messages. */
#ifndef DAFT_TEXT_H
#define DAFT_TEXT_H

#include "base/base.h"

#include <string.h>

/* At most this many warnings of a file are told one by one. */
enum { DAFT_TEXT_WARNINGS = 10, DAFT_TEXT_KEYWORDS = 32 };

typedef struct daft_text {
    const char *path;        /* in messages */
    const char *begin, *end; /* after a byte order mark; *end == 0 */
    const daft_log *log;
    unsigned warnings; /* so far, told or not */
    unsigned keyword_count;
    struct {
        const char *at;
        size_t length;
    } keywords[DAFT_TEXT_KEYWORDS]; /* warned of once */
} daft_text;

/* A token as it may stand in a message: cut to 40 bytes, `?` for what is no printable UTF-8. */
typedef struct daft_quoted {
    char text[48];
} daft_quoted;

daft_text daft_text_open(const char *path, const char *bytes, size_t size, const daft_log *log);
/* 1-based line and column (in bytes) of `at`. */
void daft_text_place(const daft_text *text, const char *at, int *line, int *column);
/* Fills *error with DAFT_ERROR_SYNTAX at the place of `at`; returns false. */
bool daft_text_fail(const daft_text *text, const char *at, daft_error *error, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* Fails where the text is UTF-16: it has a mark of that, or zeros between its characters. */
bool daft_text_check_encoding(const daft_text *text, daft_error *error);
void daft_text_warn(daft_text *text, const char *at, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Whether the next warning is told, and not only counted. */
bool daft_text_is_told(const daft_text *text);
/* The warning for a line that cannot be read; `why` need only be filled where it is told. */
void daft_text_lose(daft_text *text, const daft_error *why);
/* A warning for a keyword or option that nothing is known of, once for each. */
void daft_text_warn_unknown(daft_text *text, const char *at, size_t length, const char *what);
/* The same for one that is known. */
void daft_text_warn_not_drawn(daft_text *text, const char *at, size_t length);
/* Tells how many warnings were swallowed. For files that were read to the end. */
void daft_text_close(daft_text *text);
daft_quoted daft_text_quote(const char *at, size_t length);
/* Fails with "'x' is not a number", or with "missing" where the line ends. */
bool daft_text_fail_number(const daft_text *text, const char *at, const char *keyword, daft_error *error);

static inline bool daft_is_blank(char c) { return c == ' ' || c == '\t'; }
static inline bool daft_is_break(char c) { return c == '\n' || c == '\r'; }

static inline const char *daft_skip_blanks(const char *p)
{
    for (;;) {
        while (daft_is_blank(*p)) p++;
        if (*p != '\\' || !daft_is_break(p[1])) return p;
        p += p[1] == '\r' && p[2] == '\n' ? 3 : 2;
    }
}

/* At the end of the statement: of its line, of the text, or at a comment (`p` stands where a token may start). */
static inline bool daft_at_end(const daft_text *text, const char *p)
{
    return daft_is_break(*p) || *p == '#' || p == text->end;
}

/* A token may end here. */
static inline bool daft_token_ends(const daft_text *text, const char *p)
{
    return daft_is_blank(*p) || daft_is_break(*p) || p == text->end || (*p == '\\' && daft_is_break(p[1]));
}

static inline const char *daft_skip_token(const daft_text *text, const char *p)
{
    while (!daft_token_ends(text, p)) p++;
    return p;
}

/* To the line end, which is left. */
static inline const char *daft_skip_comment(const daft_text *text, const char *p)
{
    while (!daft_is_break(*p) && p != text->end) p++;
    return p;
}

/* The same over joined lines. */
const char *daft_skip_statement(const daft_text *text, const char *p);
/* The rest of the line without blanks around it: first byte and length. A comment sign is part of it. */
const char *daft_rest_of_line(const daft_text *text, const char *p, size_t *length);

static inline bool daft_word_is(const char *at, size_t length, const char *word)
{
    return strlen(word) == length && memcmp(at, word, length) == 0;
}

/* ---- numbers ---- */

extern const double daft_powers_of_ten[23]; /* 10^0 to 10^22, each exact in double */

/* Eight digits, 0 to 9 a byte, the first in the lowest byte: summed in pairs, fours and eights. */
static inline uint64_t daft_sum_eight(uint64_t eight)
{
    eight = eight * 10 + (eight >> 8);
    return ((eight & 0x000000FF000000FFu) * 0x000F424000000064u +
            ((eight >> 16) & 0x000000FF000000FFu) * 0x0000271000000001u) >>
           32;
}

/* Reads decimal digits onto *value; returns where they end. Eight at a time where eight bytes are left: the bytes that
 * are no digits are found by their high bits and shifted out. */
static inline const char *daft_scan_digits(const char *p, const char *end, uint64_t *value)
{
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    static const uint64_t powers[8] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000};
    while (end - p >= 8) {
        uint64_t eight;
        memcpy(&eight, p, 8);
        eight ^= 0x3030303030303030u; /* digits become 0 to 9 */
        uint64_t others = ((eight + 0x7676767676767676u) | eight) & 0x8080808080808080u;
        unsigned count = others ? (unsigned)__builtin_ctzll(others) >> 3 : 8;
        unsigned shift = (8 - count) * 4; /* in two halves, since a shift by 64 is undefined */
        eight = eight << shift << shift;
        eight = daft_sum_eight(eight);
        if (count < 8) {
            *value = *value * powers[count] + eight;
            return p + count;
        }
        *value = *value * 100000000 + eight;
        p += 8;
    }
#endif
    for (; p < end && (unsigned)(*p - '0') < 10; p++) *value = *value * 10 + (unsigned)(*p - '0');
    return p;
}

/* Everything the fast path leaves: exponents, more than 15 digits, nan, inf (also as MSVC prints them: 1.#QNAN). */
bool daft_scan_number_slow(const char **cursor, const char *end, double *out);

/* Reads a number at *cursor and moves it on; false where there is none. Independent of the locale. Up to 15 digits
 * without exponent are correctly rounded: the digits and the power of ten are exact, and there is one division. Longer
 * ones have a relative error below 4e-15. Too large ones are infinite, too small ones zero. */
static inline bool daft_scan_number(const char **cursor, const char *end, double *out)
{
    const char *p = *cursor;
    bool negative = *p == '-';
    p += negative || *p == '+';
    uint64_t digits = 0;
    const char *start = p;
    p = daft_scan_digits(p, end, &digits);
    ptrdiff_t count = p - start, decimals = 0;
    if (*p == '.') {
        start = p + 1;
        p = daft_scan_digits(start, end, &digits);
        decimals = p - start;
        count += decimals;
    }
    if (count < 1 || count > 15 || (*p | 32) == 'e' || *p == '#') return daft_scan_number_slow(cursor, end, out);
    double value = (double)(int64_t)digits / daft_powers_of_ten[decimals];
    *out = negative ? -value : value;
    *cursor = p;
    return true;
}

/* Reads an integer; those of more than 15 digits saturate. */
static inline bool daft_scan_integer(const char **cursor, const char *end, int64_t *out)
{
    const char *p = *cursor;
    bool negative = *p == '-';
    p += negative || *p == '+';
    uint64_t digits = 0;
    const char *start = p;
    p = daft_scan_digits(p, end, &digits);
    if (p == start) return false;
    int64_t value = p - start > 15 ? 1000000000000000 : (int64_t)digits;
    *out = negative ? -value : value;
    *cursor = p;
    return true;
}

#endif
