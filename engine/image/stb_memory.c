/* What stb allocates, in a list: see stb_memory.h. */
#include "image/stb_memory.h"

#include <setjmp.h>
#include <string.h>

/* In front of each block; the block keeps the alignment of the allocator. */
typedef struct header {
    _Alignas(64) struct header *next;
    struct header *previous;
    size_t size; /* of the block */
} header;

typedef struct session {
    const daft_allocator *allocator;
    header blocks; /* the list's head */
    struct session *outer;
    jmp_buf out_of_memory;
} session;

/* stb hands no pointer of its caller's to its macros, so the session is found by the thread, while it lasts. */
static _Thread_local session *daft_stb_session;

static void link_block(header *block, header *head)
{
    block->next = head->next;
    block->previous = head;
    if (head->next) head->next->previous = block;
    head->next = block;
}

static void unlink_block(header *block)
{
    block->previous->next = block->next;
    if (block->next) block->next->previous = block->previous;
}

void *daft_stb_malloc(size_t size)
{
    session *now = daft_stb_session;
    header *block = size > SIZE_MAX - sizeof *block ? NULL : daft_alloc(now->allocator, 1, sizeof *block + size);
    if (!block) longjmp(now->out_of_memory, 1);
    block->size = size;
    link_block(block, &now->blocks);
    return block + 1;
}

void daft_stb_free(void *pointer)
{
    if (!pointer) return;
    header *block = (header *)pointer - 1;
    unlink_block(block);
    daft_release(daft_stb_session->allocator, block);
}

void *daft_stb_realloc(void *pointer, size_t size)
{
    void *grown = daft_stb_malloc(size);
    if (!pointer) return grown;
    size_t old = ((header *)pointer - 1)->size;
    memcpy(grown, pointer, old < size ? old : size);
    daft_stb_free(pointer);
    return grown;
}

/* The only function between setjmp and longjmp that holds anything is the call, whose blocks are in the list. */
static bool run(session *now, daft_stb_call *call, void *context)
{
    if (setjmp(now->out_of_memory) != 0) return false;
    call(context);
    return true;
}

bool daft_stb_run(const daft_allocator *allocator, daft_stb_call *call, void *context, void **kept)
{
    session now = {.allocator = allocator, .outer = daft_stb_session};
    daft_stb_session = &now;
    bool done = run(&now, call, context);
    daft_stb_session = now.outer;
    if (kept && !done) *kept = NULL;
    if (kept && *kept) unlink_block((header *)*kept - 1);
    for (header *block = now.blocks.next, *next; block; block = next) {
        next = block->next;
        daft_release(allocator, block);
    }
    return done;
}

void daft_stb_release(const daft_allocator *allocator, void *kept)
{
    if (kept) daft_release(allocator, (header *)kept - 1);
}
