/* heap: the memory of one game, in one range of addresses, whose content can be kept as an image and put back: then
 * everything in it is as it was, at the same addresses: Lua's state, the scene, the simulation.
 *
 * Promises: images share the pages that are equal in them. Memory from it may be taken and released from any thread;
 * images are kept and put back while no other thread uses it, and nobody else may hold a pointer into memory that was
 * taken after the image was kept. */
#ifndef RUNTIME_GAME_HEAP_H
#define RUNTIME_GAME_HEAP_H

#include "daft.h"

typedef struct heap heap;
typedef struct heap_image heap_image;

/* Addresses for `most` bytes; memory is taken as it is used. NULL: there are not so many, or memory is out. */
heap *heap_open(uint64_t most, daft_error *error);
void heap_close(heap *self); /* its images must be gone; NULL is fine */
/* Valid until heap_close. */
const daft_allocator *heap_allocator(const heap *self);
uint64_t heap_used(const heap *self);        /* bytes of addresses that have been in use at one time */
uint64_t heap_image_bytes(const heap *self); /* of all images */

/* NULL: memory is out. */
heap_image *heap_keep(heap *self);
void heap_put_back(heap *self, const heap_image *image);
void heap_image_free(heap *self, heap_image *image); /* NULL is fine */
/* The memory is much like this image, which makes the next one cheaper: the one that was kept or put back last, unless
 * it is gone. */
void heap_liken(heap *self, const heap_image *image);

#endif
