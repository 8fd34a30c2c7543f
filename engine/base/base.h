/* base: errors as values, memory, files, the parallel scheduler, the clock, hashes: what every room uses.
 * Public headers: base.h budget.h files.h writer.h parallel.h
 * Promises: no global state; every allocation uses the caller's allocator; the results of a parallel loop do not depend
 * on the number of workers, as long as a task writes only to what its index owns. */
#ifndef DAFT_BASE_H
#define DAFT_BASE_H

#include "base/parallel.h"
#include "daft.h"

/* Every definition struct carries this; one that did not come from its daft_default_…() maker is rejected. */
#define DAFT_COOKIE 0xDAF7C0DEu

#define DAFT_COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

static inline int daft_min_i(int a, int b) { return a < b ? a : b; }
static inline int daft_max_i(int a, int b) { return a > b ? a : b; }
static inline uint32_t daft_min_u(uint32_t a, uint32_t b) { return a < b ? a : b; }
static inline uint32_t daft_max_u(uint32_t a, uint32_t b) { return a > b ? a : b; }

/* ---- errors (error.c) ---- */

/* Both fill *error (if it is not NULL) and return false, so that `return daft_fail(...)` reads well. */
bool daft_fail(daft_error *error, daft_status code, const char *format, ...) __attribute__((format(printf, 3, 4)));
bool daft_fail_at(daft_error *error, daft_status code, const char *file, int line, int column, const char *format, ...)
    __attribute__((format(printf, 6, 7)));
/* "out of memory for WHAT". */
bool daft_fail_memory(daft_error *error, const char *what);
/* Sets *error to DAFT_OK. */
void daft_error_clear(daft_error *error);

/* Where warnings go. A zero value drops them. */
typedef struct daft_log {
    daft_warning_callback *warn;
    void *user;
    int *running; /* counts the engine's callbacks that run now; NULL: nobody asks */
    bool checks;  /* what is left out on purpose is told, too */
} daft_log;

void daft_warn_at(const daft_log *log, daft_status code, const char *file, int line, int column, const char *format,
                  ...) __attribute__((format(printf, 6, 7)));

/* ---- memory (memory.c) ---- */

daft_allocator daft_malloc_allocator(void);
/* 64-byte aligned (one cache line, one AVX-512 register); NULL when size overflows or memory is out. */
void *daft_alloc(const daft_allocator *allocator, size_t count, size_t size);
void *daft_alloc_zero(const daft_allocator *allocator, size_t count, size_t size);
void daft_release(const daft_allocator *allocator, void *pointer);
/* Makes room for `needed` elements of `size` bytes in *array, doubling. False and unchanged when memory is out. */
bool daft_grow(const daft_allocator *allocator, void *array_pointer, size_t *capacity, size_t needed, size_t used,
               size_t size);
/* A copy of a string; NULL when memory is out. */
char *daft_copy_string(const daft_allocator *allocator, const char *text);

/* Bump allocation in blocks that are kept across resets: a settled frame allocates nothing. */
typedef struct daft_arena_block daft_arena_block;
typedef struct daft_arena {
    const daft_allocator *allocator;
    daft_arena_block *first, *current;
    size_t bytes; /* handed out since the last reset */
} daft_arena;

void daft_arena_init(daft_arena *arena, const daft_allocator *allocator);
void *daft_arena_alloc(daft_arena *arena, size_t count, size_t size); /* 64-byte aligned, NULL when memory is out */
void daft_arena_reset(daft_arena *arena);
void daft_arena_free(daft_arena *arena);

/* ---- clock (clock.c) ---- */

double daft_clock_ms(void); /* monotonic, milliseconds */
/* A counter for short spans, cheaper to read than the clock, against which its unit is calibrated. Processors may
 * differ by some ticks. */
uint64_t daft_clock_ticks(void);

#endif
