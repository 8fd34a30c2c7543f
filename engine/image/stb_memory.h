/* Memory for stb_image and stb_image_write, which know no allocator of their caller's and, the latter, do not look
 * whether memory is out. A call runs under daft_stb_run: what it allocates comes from the given allocator and counts
 * towards its limit; where there is no more, the call ends at once (longjmp within daft_stb_run, across stb's frames
 * and the callback's alone); and whatever it leaves behind is released. */
#ifndef DAFT_STB_MEMORY_H
#define DAFT_STB_MEMORY_H

#include "base/base.h"

typedef void daft_stb_call(void *context);

/* Runs call(context). False: memory was out. *kept (which the call sets; kept may be NULL) stays allocated where the
 * result is true, and is NULL where it is false. The call holds nothing but stb's memory. */
bool daft_stb_run(const daft_allocator *allocator, daft_stb_call *call, void *context, void **kept);
/* Releases what was kept. NULL is fine. */
void daft_stb_release(const daft_allocator *allocator, void *kept);

/* For stb's macros. Never NULL. */
void *daft_stb_malloc(size_t size);
void *daft_stb_realloc(void *pointer, size_t size);
void daft_stb_free(void *pointer);

#endif
