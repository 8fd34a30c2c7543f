/* Errors as values: a code, a position in a file, and one line of English. */
#include "base/base.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Bytes of the UTF-8 character at `text`; 0: it is none, or a control character. */
static size_t shown_length(const unsigned char *text)
{
    size_t length = text[0] < 0x80 ? 1 : text[0] >> 5 == 6 ? 2 : text[0] >> 4 == 14 ? 3 : text[0] >> 3 == 30 ? 4 : 0;
    if (length == 1) return text[0] >= 0x20 && text[0] != 0x7f;
    for (size_t i = 1; i < length; i++)
        if (text[i] >> 6 != 2) return 0;
    bool overlong = (length == 2 && text[0] < 0xc2) || (length == 3 && text[0] == 0xe0 && text[1] < 0xa0) ||
                    (length == 4 && text[0] == 0xf0 && text[1] < 0x90);
    bool control = length == 2 && text[0] == 0xc2 && text[1] < 0xa0;
    bool too_high = text[0] > 0xf4 || (length == 3 && text[0] == 0xed && text[1] > 0x9f);
    return overlong || control || too_high ? 0 : length;
}

const char *daft_escape(const char *text, char *buffer, size_t size)
{
    size_t used = 0;
    if (!buffer) size = 0;
    for (const unsigned char *at = (const unsigned char *)(text ? text : ""); size && *at;) {
        char code[8];
        size_t length = shown_length(at), taken = length ? length : 1;
        if (length)
            memcpy(code, at, length);
        else
            length = (size_t)snprintf(code, sizeof code, *at == '\n' ? "\\n" : *at == '\t' ? "\\t" : "\\x%02x", *at);
        if (used + length + 1 > size) break;
        memcpy(buffer + used, code, length);
        used += length, at += taken;
    }
    if (size) buffer[used] = 0;
    return buffer;
}

static void fill(daft_error *error, daft_status code, const char *file, int line, int column, const char *format,
                 va_list arguments)
{
    error->code = code;
    error->line = line;
    error->column = column;
    char message[sizeof error->message];
    vsnprintf(message, sizeof message, format, arguments);
    daft_escape(message, error->message, sizeof error->message);
    daft_escape(file ? file : "", error->file, sizeof error->file);
}

bool daft_fail(daft_error *error, daft_status code, const char *format, ...)
{
    if (error) {
        va_list arguments;
        va_start(arguments, format);
        fill(error, code, NULL, 0, 0, format, arguments);
        va_end(arguments);
    }
    return false;
}

bool daft_fail_at(daft_error *error, daft_status code, const char *file, int line, int column, const char *format, ...)
{
    if (error) {
        va_list arguments;
        va_start(arguments, format);
        fill(error, code, file, line, column, format, arguments);
        va_end(arguments);
    }
    return false;
}

bool daft_fail_memory(daft_error *error, const char *what)
{
    return daft_fail(error, DAFT_ERROR_MEMORY, "out of memory for %s", what);
}

void daft_error_clear(daft_error *error)
{
    if (!error) return;
    error->code = DAFT_OK;
    error->line = error->column = 0;
    error->file[0] = error->message[0] = 0;
}

void daft_warn_at(const daft_log *log, daft_status code, const char *file, int line, int column, const char *format,
                  ...)
{
    /* A warning callback that warns itself is called once more, not for ever. */
    if (!log || !log->warn || (log->running && *log->running >= 2)) return;
    daft_error warning;
    va_list arguments;
    va_start(arguments, format);
    fill(&warning, code, file, line, column, format, arguments);
    va_end(arguments);
    if (log->running) ++*log->running;
    log->warn(log->user, &warning);
    if (log->running) --*log->running;
}

const char *daft_error_text(const daft_error *error, char *buffer, size_t size)
{
    char file[sizeof error->file + 512], message[sizeof error->message + 512]; /* errors that programs filled in */
    if (!buffer || size == 0) return buffer;
    daft_escape(error ? error->file : "", file, sizeof file);
    daft_escape(error ? error->message : "", message, sizeof message);
    if (!error || error->file[0] == 0)
        snprintf(buffer, size, "%s", message);
    else if (error->line == 0)
        snprintf(buffer, size, "%s: %s", file, message);
    else if (error->column == 0)
        snprintf(buffer, size, "%s:%d: %s", file, error->line, message);
    else
        snprintf(buffer, size, "%s:%d:%d: %s", file, error->line, error->column, message);
    return buffer;
}
