/* Prints the problems that daft check finds, as text and as JSON. */
#include "cli/check/check.h"

#include "common/json.h"
#include "common/util.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static const char *const SEVERITIES[] = {
    [DAFT_SEVERITY_NOTE] = "note", [DAFT_SEVERITY_WARNING] = "warning", [DAFT_SEVERITY_ERROR] = "error"};

/* Meshes that share a material file report its problems repeatedly; each is printed once. When memory runs out, a
 * problem may be printed again. */
static bool is_new(checker *c, uint64_t hash)
{
    for (size_t i = 0; i < c->printed_count; i++)
        if (c->printed[i] == hash) return false;
    if (c->printed_count == c->printed_capacity) {
        size_t more = c->printed_capacity ? 2 * c->printed_capacity : 64;
        uint64_t *grown = realloc(c->printed, more * sizeof *grown);
        if (!grown) return true;
        c->printed = grown;
        c->printed_capacity = more;
    }
    c->printed[c->printed_count++] = hash;
    return true;
}

static void put_json(const checker *c, const char *severity, const daft_error *problem)
{
    FILE *out = c->json.file;
    fprintf(out, "%s\n  {\"file\": ", c->printed_count > 1 ? "," : "");
    json_put_text(out, problem->file);
    fprintf(out, ", \"line\": %d, \"column\": %d, \"severity\": \"%s\", \"text\": ", problem->line, problem->column,
            severity);
    json_put_text(out, problem->message);
    fputc('}', out);
}

/* "a/b/../c" becomes "a/c", so that a file has one name however it was reached. */
static void shorten(char *path)
{
    for (char *up = strstr(path, "/../"); up;) {
        char *begin = up;
        while (begin > path && begin[-1] != '/') begin--;
        bool named = begin < up && strncmp(begin, "../", 3) != 0 && strncmp(begin, "./", 2) != 0;
        if (named) memmove(begin, up + 4, strlen(up + 4) + 1);
        up = strstr(named ? path : up + 1, "/../");
    }
}

void check_problem(void *user, daft_severity severity, const daft_error *problem)
{
    checker *c = user;
    daft_error full = *problem;
    if (!full.file[0]) snprintf(full.file, sizeof full.file, "%s", c->path);
    shorten(full.file);
    char place[600], line[1200];
    snprintf(place, sizeof place, "%s", full.file);
    size_t used = strlen(place);
    if (full.line > 0) used += (size_t)snprintf(place + used, sizeof place - used, ":%d", full.line);
    if (full.line > 0 && full.column > 0) snprintf(place + used, sizeof place - used, ":%d", full.column);
    snprintf(line, sizeof line, "%s: %s: %s", place, SEVERITIES[severity], full.message);
    if (!is_new(c, daft_hash(line, strlen(line), 0))) return;
    puts(line);
    if (c->json.file) put_json(c, SEVERITIES[severity], &full);
    c->errors += severity == DAFT_SEVERITY_ERROR;
    c->warnings += severity == DAFT_SEVERITY_WARNING;
    c->notes += severity == DAFT_SEVERITY_NOTE;
}

void check_warning(void *user, const daft_error *warning) { check_problem(user, DAFT_SEVERITY_WARNING, warning); }

void check_add(checker *c, daft_severity severity, const char *file, int line, int column, const char *format, ...)
{
    daft_error problem = {.line = line, .column = column};
    snprintf(problem.file, sizeof problem.file, "%s", file);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(problem.message, sizeof problem.message, format, arguments);
    va_end(arguments);
    check_problem(c, severity, &problem);
}

bool check_json_open(checker *c, daft_error *error)
{
    if (!draft_open(&c->json, error)) return false;
    fputc('[', c->json.file);
    return true;
}

bool check_json_close(checker *c, const char *path, daft_error *error)
{
    if (!c->json.file) return true;
    fputs("\n]\n", c->json.file);
    return draft_commit(&c->json, path, error);
}
