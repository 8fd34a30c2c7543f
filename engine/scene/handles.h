/* Handles and look-up: the slot map behind every 32-bit handle that can go stale, and the map behind every cache. */
#ifndef DAFT_HANDLES_H
#define DAFT_HANDLES_H

#include "base/base.h"

/* A handle is generation << 20 | index. Generations start at 1, so no handle is 0; a slot whose 4,095 generations are
 * used up is retired, so a stale handle never becomes valid again. */
enum { DAFT_INDEX_BITS = 20, DAFT_MAX_SLOTS = 1 << DAFT_INDEX_BITS, DAFT_MAX_GENERATION = 4095 };
#define DAFT_NONE UINT32_MAX

typedef struct daft_slot {
    uint32_t next_free; /* while free */
    uint16_t generation;
    bool live;
} daft_slot;

typedef struct daft_slots {
    daft_slot *items;
    size_t capacity;
    uint32_t count; /* slots ever used: indices are below it */
    uint32_t live, free_count;
    uint32_t first_free, last_free; /* a queue, so that generations are used up evenly */
} daft_slots;

void daft_slots_init(daft_slots *slots);
void daft_slots_free(daft_slots *slots, const daft_allocator *allocator);
/* Makes sure that `more` adds succeed. */
bool daft_slots_reserve(daft_slots *slots, const daft_allocator *allocator, uint32_t more);
/* The index that the n-th add from now (0: the next) would give at most; for sizing parallel arrays. */
uint32_t daft_slots_needed(const daft_slots *slots, uint32_t more);
/* Returns a new handle; room was reserved. */
uint32_t daft_slots_add(daft_slots *slots);
/* The index of a handle, or DAFT_NONE when it is null or stale. */
uint32_t daft_slots_find(const daft_slots *slots, uint32_t handle);
uint32_t daft_slots_handle(const daft_slots *slots, uint32_t index);
void daft_slots_remove(daft_slots *slots, uint32_t index);

static inline uint32_t daft_handle_index(uint32_t handle) { return handle & (DAFT_MAX_SLOTS - 1); }

/* From 64-bit hashes to values; several values may share a hash, so the caller compares what it finds. */
typedef struct daft_map_entry {
    uint64_t hash;
    uint32_t value; /* DAFT_NONE: empty, DAFT_NONE - 1: removed */
} daft_map_entry;

typedef struct daft_map {
    daft_map_entry *entries;
    uint32_t size; /* a power of two, or 0 */
    uint32_t used; /* entries that are not empty */
} daft_map;

void daft_map_free(daft_map *map, const daft_allocator *allocator);
bool daft_map_reserve(daft_map *map, const daft_allocator *allocator, uint32_t more);
void daft_map_add(daft_map *map, uint64_t hash, uint32_t value); /* room was reserved */
/* The next value with this hash, or DAFT_NONE. *cursor starts at 0. */
uint32_t daft_map_next(const daft_map *map, uint64_t hash, uint32_t *cursor);
void daft_map_remove(daft_map *map, uint64_t hash, uint32_t value);

#endif
