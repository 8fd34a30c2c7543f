/* util: the small things every file of the runtime needs: errors in the engine's form, near misses of names, paths,
 * time. Promises: nothing here keeps state. */
#ifndef RUNTIME_COMMON_UTIL_H
#define RUNTIME_COMMON_UTIL_H

#include "daft.h"

enum { PATH_SIZE = 1024 };

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* Exit statuses of the program. */
enum { STATUS_DONE = 0, STATUS_BAD_INPUT = 1, STATUS_BAD_USAGE = 2 };

/* Fills *error and returns false. */
bool fail(daft_error *error, daft_status code, const char *format, ...) __attribute__((format(printf, 3, 4)));
bool fail_at(daft_error *error, const char *file, int line, int column, const char *format, ...)
    __attribute__((format(printf, 5, 6)));
/* "daft: file:line:column: message" on stderr; returns STATUS_BAD_INPUT. */
int report(const daft_error *error);

/* The name nearest to `word`, or NULL when none is near enough to be what was meant. */
const char *nearest_name(const char *word, const char *const *names, size_t count);

/* False when the result does not fit. */
bool path_join(char *out, size_t size, const char *folder, const char *name);
bool path_is_folder(const char *path);
bool path_is_file(const char *path);
/* The last part of a path, without slashes at its end. */
void path_base_name(const char *path, char *out, size_t size);
bool has_extension(const char *path, const char *extension);
/* A whole file and a zero byte after it; freed with free(). */
char *read_whole_file(const char *path, size_t *size, daft_error *error);

uint64_t clock_now_ns(void); /* monotonic */

#endif
