/* An allocator that fails once and counts what is held: that memory may run out at any moment, and nothing leaks. */
#ifndef DAFT_TEST_METER_H
#define DAFT_TEST_METER_H

#include "base/base.h"

#include <stdlib.h>

typedef struct meter {
    _Atomic int left; /* allocations until one fails */
    _Atomic int held;
} meter;

static inline void *meter_allocate(void *user, size_t size, size_t alignment)
{
    meter *m = user;
    if (m->left-- == 0) return NULL;
    m->held++;
    return aligned_alloc(alignment, (size + alignment - 1) & ~(alignment - 1));
}

static inline void meter_release(void *user, void *pointer)
{
    if (pointer) ((meter *)user)->held--;
    free(pointer);
}

#endif
