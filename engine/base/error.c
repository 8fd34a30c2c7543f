/* Errors as values: a code, a position in a file, and one line of English. */
#include "base/base.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void fill(daft_error *error, daft_status code, const char *file, int line, int column, const char *format,
                 va_list arguments)
{
    error->code = code;
    error->line = line;
    error->column = column;
    snprintf(error->file, sizeof error->file, "%s", file ? file : "");
    vsnprintf(error->message, sizeof error->message, format, arguments);
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
    if (error) memset(error, 0, sizeof *error);
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
    if (!buffer || size == 0) return buffer;
    if (!error)
        buffer[0] = 0;
    else if (error->file[0] == 0)
        snprintf(buffer, size, "%s", error->message);
    else if (error->line == 0)
        snprintf(buffer, size, "%s: %s", error->file, error->message);
    else if (error->column == 0)
        snprintf(buffer, size, "%s:%d: %s", error->file, error->line, error->message);
    else
        snprintf(buffer, size, "%s:%d:%d: %s", error->file, error->line, error->column, error->message);
    return buffer;
}
