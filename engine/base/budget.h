/* base/budget: one limit for all bytes of an engine, and of the program that shares it.
 *
 * A budget wraps the caller's allocator: each block has a header with its size in front, so that taking and giving back
 * are counted exactly, the headers included. What a program holds by other means, such as its scripts, is taken with
 * daft_budget_take. Any thread may call anything here but daft_budget_close.
 *
 * Promises: `used` never exceeds the limit; a block that would is refused (NULL), as if memory were out; a budget lives
 * until it is closed and all of its blocks are released, so an image may outlive its engine. */
#ifndef DAFT_BASE_BUDGET_H
#define DAFT_BASE_BUDGET_H

#include "base/base.h"

typedef struct daft_budget daft_budget;

/* limit: bytes; 0: none. NULL when memory is out. */
daft_budget *daft_budget_open(const daft_allocator *from, uint64_t limit);
void daft_budget_close(daft_budget *budget); /* NULL is fine */
daft_allocator daft_budget_allocator(daft_budget *budget);

bool daft_budget_take(daft_budget *budget, uint64_t bytes); /* false: over the limit, nothing is taken */
void daft_budget_give(daft_budget *budget, uint64_t bytes);
daft_memory daft_budget_memory(const daft_budget *budget);
/* Whether a call of the caller's allocator runs now, on any thread. */
bool daft_budget_is_calling(const daft_budget *budget);

/* Whether so many bytes more fit into the budget behind the allocator; another allocator has no limit. Where not, the
 * message names the file, `what` (such as "a texture of 3 by 4 pixels"), the bytes needed and the limit. */
bool daft_budget_allows(const daft_allocator *allocator, uint64_t bytes, const char *path, const char *what,
                        daft_error *error);

#endif
