/* common: what every room of the program uses.
 * Public headers: util.h stats.h json.h progress.h stop.h showcase.h quality.h trace.h
 * util.h has errors in the engine's form, near misses of names, paths and time; stats.h times and counters of frames;
 * json.h JSON files; progress.h a progress bar; showcase.h a mesh without a scene; quality.h the knobs of pictures;
 * stop.h the end of the program before its time; trace.h what took how long. Promises: nothing here keeps state, but
 * for stop.h. */
#ifndef RUNTIME_COMMON_UTIL_H
#define RUNTIME_COMMON_UTIL_H

#include "daft.h"

#include <stdio.h>

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

/* The name nearest to `word` by edit distance, or NULL when none is near enough to be a typing error. */
const char *nearest_name(const char *word, const char *const *names, size_t count);
enum { HINT_SIZE = 96 };
/* Fills `out` with ": did you mean 'PREFIXname'?" for the nearest name, or with nothing. Returns `out`. */
const char *did_you_mean(char out[HINT_SIZE], const char *prefix, const char *word, const char *const *names,
                         size_t count);

/* False when the result does not fit. */
bool path_join(char *out, size_t size, const char *folder, const char *name);
bool path_is_folder(const char *path);
bool path_is_file(const char *path);
/* The last part of a path, without slashes at its end. */
void path_base_name(const char *path, char *out, size_t size);
bool has_extension(const char *path, const char *extension);

/* A file in the making: what is printed to `file` stays in memory until draft_commit writes all of it or nothing. */
typedef struct draft_file {
    FILE *file;
    char *bytes;
    size_t size;
} draft_file;
bool draft_open(draft_file *out, daft_error *error);
/* Writes the file (daft_write_file) and frees the memory, also where it fails. */
bool draft_commit(draft_file *out, const char *path, daft_error *error);

/* From an allocator, aligned to 16 bytes; NULL, or one that is all zero: malloc. */
void *memory_take(const daft_allocator *memory, size_t size);
void memory_release(const daft_allocator *memory, void *pointer); /* NULL is fine */

uint64_t clock_now_ns(void); /* monotonic */

/* The next code point of UTF-8, or 0 at the end. Each invalid byte gives U+FFFD. */
uint32_t utf8_next(const char **text);
/* A code point of at most 0x10FFFF as UTF-8. */
void utf8_put(uint32_t code, char out[5]);

#endif
