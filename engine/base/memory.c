/* Memory: the caller's allocator, growing arrays, and arenas that keep their blocks across resets. */
#include "base/base.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { ALIGNMENT = 64, BLOCK_BYTES = 1 << 20, HUGE_PAGE = 1 << 21 };

/* Large blocks are aligned to huge pages and request them: the first touch of a 4 KB page costs about a microsecond, as
 * much as loading takes to fill it. The part behind the last whole huge page uses small ones. */
static void *allocate_large(size_t size)
{
    void *memory;
    if (posix_memalign(&memory, HUGE_PAGE, size) != 0) return NULL;
#ifdef MADV_HUGEPAGE
    madvise(memory, size - size % HUGE_PAGE, MADV_HUGEPAGE); /* a hint: its result does not matter */
#endif
    return memory;
}

static void *malloc_allocate(void *user, size_t size, size_t alignment)
{
    (void)user;
    size_t rounded = (size + alignment - 1) & ~(alignment - 1);
    if (rounded < size) return NULL;
    return rounded < HUGE_PAGE ? aligned_alloc(alignment, rounded) : allocate_large(rounded);
}

static void malloc_release(void *user, void *pointer)
{
    (void)user;
    free(pointer);
}

daft_allocator daft_malloc_allocator(void) { return (daft_allocator){NULL, malloc_allocate, malloc_release}; }

void *daft_alloc(const daft_allocator *allocator, size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX - (size_t)ALIGNMENT) return NULL;
    return allocator->allocate(allocator->user, bytes ? bytes : 1, ALIGNMENT);
}

void *daft_alloc_zero(const daft_allocator *allocator, size_t count, size_t size)
{
    void *memory = daft_alloc(allocator, count, size);
    if (memory) memset(memory, 0, count * size);
    return memory;
}

void daft_release(const daft_allocator *allocator, void *pointer)
{
    if (pointer) allocator->release(allocator->user, pointer);
}

bool daft_grow(const daft_allocator *allocator, void *array_pointer, size_t *capacity, size_t needed, size_t used,
               size_t size)
{
    if (needed <= *capacity) return true;
    size_t wanted = *capacity < 8 ? 8 : *capacity * 2;
    if (wanted < needed) wanted = needed;
    void *grown = daft_alloc(allocator, wanted, size);
    if (!grown) return false;
    void *old;
    memcpy(&old, array_pointer, sizeof old);
    if (used) memcpy(grown, old, used * size);
    daft_release(allocator, old);
    memcpy(array_pointer, &grown, sizeof grown);
    *capacity = wanted;
    return true;
}

char *daft_copy_string(const daft_allocator *allocator, const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = daft_alloc(allocator, size, 1);
    if (copy) memcpy(copy, text, size);
    return copy;
}

/* A block is this header, padded to the alignment, then `size` bytes. */
struct daft_arena_block {
    daft_arena_block *next;
    size_t size, used;
};

void daft_arena_init(daft_arena *arena, const daft_allocator *allocator)
{
    *arena = (daft_arena){allocator, NULL, NULL, 0};
}

static void *block_take(daft_arena_block *block, size_t bytes)
{
    if (!block || block->size - block->used < bytes) return NULL;
    char *memory = (char *)block + ALIGNMENT + block->used;
    block->used += bytes;
    return memory;
}

static daft_arena_block *block_add(daft_arena *arena, size_t bytes)
{
    size_t size = bytes > BLOCK_BYTES ? bytes : BLOCK_BYTES;
    daft_arena_block *block = daft_alloc(arena->allocator, 1, size + ALIGNMENT);
    if (!block) return NULL;
    *block = (daft_arena_block){NULL, size, 0};
    if (arena->current) {
        block->next = arena->current->next;
        arena->current->next = block;
    } else {
        arena->first = block;
    }
    return block;
}

void *daft_arena_alloc(daft_arena *arena, size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX - (size_t)(4 * ALIGNMENT)) return NULL;
    bytes = (bytes + ALIGNMENT - 1) & ~(size_t)(ALIGNMENT - 1);
    arena->bytes += bytes;
    for (;;) {
        void *memory = block_take(arena->current, bytes);
        if (memory) return memory;
        daft_arena_block *next = arena->current ? arena->current->next : arena->first;
        if (!next) next = block_add(arena, bytes);
        if (!next) return NULL;
        arena->current = next;
    }
}

void daft_arena_reset(daft_arena *arena)
{
    for (daft_arena_block *block = arena->first; block; block = block->next) block->used = 0;
    arena->current = arena->first;
    arena->bytes = 0;
}

void daft_arena_free(daft_arena *arena)
{
    for (daft_arena_block *block = arena->first; block;) {
        daft_arena_block *next = block->next;
        daft_release(arena->allocator, block);
        block = next;
    }
    daft_arena_init(arena, arena->allocator);
}
