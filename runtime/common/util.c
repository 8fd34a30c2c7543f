/* Errors, near misses of names, paths, files, time. */
#include "common/util.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <time.h>

static void fill(daft_error *error, daft_status code, const char *file, int line, int column, const char *format,
                 va_list arguments)
{
    error->code = code;
    error->line = line;
    error->column = column;
    snprintf(error->file, sizeof error->file, "%s", file ? file : "");
    vsnprintf(error->message, sizeof error->message, format, arguments);
}

bool fail(daft_error *error, daft_status code, const char *format, ...)
{
    if (!error) return false;
    va_list arguments;
    va_start(arguments, format);
    fill(error, code, NULL, 0, 0, format, arguments);
    va_end(arguments);
    return false;
}

bool fail_at(daft_error *error, const char *file, int line, int column, const char *format, ...)
{
    if (!error) return false;
    va_list arguments;
    va_start(arguments, format);
    fill(error, line > 0 ? DAFT_ERROR_SYNTAX : DAFT_ERROR_IO, file, line, column, format, arguments);
    va_end(arguments);
    return false;
}

int report(const daft_error *error)
{
    char text[1200];
    fprintf(stderr, "daft: %s\n", daft_error_text(error, text, sizeof text));
    return STATUS_BAD_INPUT;
}

/* Optimal string alignment distance: insertions, deletions, substitutions, transpositions. LIMIT for words over 63
 * letters. */
static size_t edit_distance(const char *a, const char *b)
{
    enum { LIMIT = 64 };
    size_t n = strlen(a), m = strlen(b);
    if (n >= LIMIT || m >= LIMIT) return LIMIT;
    size_t rows[3][LIMIT];
    size_t *before = rows[0], *last = rows[1], *row = rows[2];
    for (size_t j = 0; j <= m; j++) before[j] = last[j] = j;
    for (size_t i = 1; i <= n; i++) {
        row[0] = i;
        for (size_t j = 1; j <= m; j++) {
            size_t best = last[j - 1] + (a[i - 1] != b[j - 1]);
            if (last[j] + 1 < best) best = last[j] + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped && before[j - 2] + 1 < best) best = before[j - 2] + 1;
            row[j] = best;
        }
        size_t *free_row = before;
        before = last, last = row, row = free_row;
    }
    return last[m];
}

const char *nearest_name(const char *word, const char *const *names, size_t count)
{
    size_t length = strlen(word), limit = length < 4 ? 1 : length < 8 ? 2 : 3, best = limit + 1;
    const char *found = NULL;
    for (size_t i = 0; i < count; i++) {
        size_t distance = edit_distance(word, names[i]);
        bool prefix = length >= 3 && strncmp(word, names[i], length) == 0;
        if (prefix && distance > limit) distance = limit;
        if (distance < best) best = distance, found = names[i];
    }
    return found;
}

const char *did_you_mean(char out[HINT_SIZE], const char *prefix, const char *word, const char *const *names,
                         size_t count)
{
    const char *near = nearest_name(word, names, count);
    out[0] = 0;
    if (near) snprintf(out, HINT_SIZE, ": did you mean '%s%s'?", prefix, near);
    return out;
}

bool path_join(char *out, size_t size, const char *folder, const char *name)
{
    size_t length = strlen(folder);
    const char *slash = length == 0 || folder[length - 1] == '/' ? "" : "/";
    int written = name[0] == '/' ? snprintf(out, size, "%s", name) : snprintf(out, size, "%s%s%s", folder, slash, name);
    return written >= 0 && (size_t)written < size;
}

bool path_is_folder(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

bool path_is_file(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && !S_ISDIR(info.st_mode);
}

void path_base_name(const char *path, char *out, size_t size)
{
    size_t end = strlen(path);
    while (end > 1 && path[end - 1] == '/') end--;
    size_t begin = end;
    while (begin > 0 && path[begin - 1] != '/') begin--;
    snprintf(out, size, "%.*s", (int)(end - begin), path + begin);
}

bool has_extension(const char *path, const char *extension)
{
    size_t n = strlen(path), m = strlen(extension);
    return n > m && strcasecmp(path + n - m, extension) == 0;
}

bool draft_open(draft_file *out, daft_error *error)
{
    *out = (draft_file){0};
    out->file = open_memstream(&out->bytes, &out->size);
    return out->file || fail(error, DAFT_ERROR_MEMORY, "out of memory for a file's text");
}

bool draft_commit(draft_file *out, const char *path, daft_error *error)
{
    bool good = !ferror(out->file);
    if (fclose(out->file) != 0) good = false;
    if (!out->bytes) good = false; /* glibc's fclose fits the bytes to their size, and says nothing where that fails */
    good = good ? daft_write_file(path, out->bytes, out->size, error)
                : fail_at(error, path, 0, 0, "out of memory for the file's text");
    free(out->bytes);
    *out = (draft_file){0};
    return good;
}

void *memory_take(const daft_allocator *memory, size_t size)
{
    return memory && memory->allocate ? memory->allocate(memory->user, size, 16) : malloc(size);
}

void memory_release(const daft_allocator *memory, void *pointer)
{
    if (pointer && memory && memory->release)
        memory->release(memory->user, pointer);
    else
        free(pointer);
}

uint64_t clock_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

uint32_t utf8_next(const char **text)
{
    const unsigned char *at = (const unsigned char *)*text;
    if (*at == 0) return 0;
    int extra = *at < 0x80 ? 0 : (*at & 0xE0) == 0xC0 ? 1 : (*at & 0xF0) == 0xE0 ? 2 : (*at & 0xF8) == 0xF0 ? 3 : -1;
    uint32_t code = extra <= 0 ? *at : *at & (0x3Fu >> extra);
    for (int i = 1; i <= extra; i++) {
        if ((at[i] & 0xC0) != 0x80)
            extra = -1;
        else
            code = code << 6 | (at[i] & 0x3F);
    }
    static const uint32_t SMALLEST[] = {0, 0x80, 0x800, 0x10000}; /* of that many bytes: longer forms are none */
    if (extra >= 0 && (code < SMALLEST[extra] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000))) extra = -1;
    *text += extra < 0 ? 1 : extra + 1;
    return extra < 0 ? 0xFFFD : code;
}

void utf8_put(uint32_t code, char out[5])
{
    const int extra = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static const uint8_t FIRST[] = {0, 0xC0, 0xE0, 0xF0};
    out[0] = (char)(FIRST[extra] | code >> (6 * extra));
    for (int i = 1; i <= extra; i++) out[i] = (char)(0x80 | (code >> (6 * (extra - i)) & 0x3F));
    out[extra + 1] = 0;
}
