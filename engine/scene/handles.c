/* The slot map and the hash map.
 *
 * Slot map: an array of slots, each live, free (in the queue) or retired; the data lives in the caller's parallel
 * arrays. Hash map: open addressing with linear probing, at most half full, removed entries stay as gravestones until
 * the next growth. */
#include "scene/handles.h"

#include <string.h>

void daft_slots_init(daft_slots *slots)
{
    memset(slots, 0, sizeof *slots);
    slots->first_free = slots->last_free = DAFT_NONE;
}

void daft_slots_free(daft_slots *slots, const daft_allocator *allocator)
{
    daft_release(allocator, slots->items);
    daft_slots_init(slots);
}

uint32_t daft_slots_needed(const daft_slots *slots, uint32_t more)
{
    return slots->count + (more > slots->free_count ? more - slots->free_count : 0);
}

bool daft_slots_reserve(daft_slots *slots, const daft_allocator *allocator, uint32_t more)
{
    uint32_t needed = daft_slots_needed(slots, more);
    if (needed > DAFT_MAX_SLOTS) return false;
    return daft_grow(allocator, &slots->items, &slots->capacity, needed, slots->count, sizeof *slots->items);
}

uint32_t daft_slots_add(daft_slots *slots)
{
    uint32_t index = slots->first_free;
    if (index != DAFT_NONE) {
        slots->first_free = slots->items[index].next_free;
        if (slots->first_free == DAFT_NONE) slots->last_free = DAFT_NONE;
        slots->free_count--;
    } else {
        index = slots->count++;
        slots->items[index].generation = 1;
    }
    slots->items[index].live = true;
    slots->live++;
    return daft_slots_handle(slots, index);
}

uint32_t daft_slots_find(const daft_slots *slots, uint32_t handle)
{
    uint32_t index = daft_handle_index(handle);
    if (index >= slots->count || !slots->items[index].live) return DAFT_NONE;
    return slots->items[index].generation == handle >> DAFT_INDEX_BITS ? index : DAFT_NONE;
}

uint32_t daft_slots_handle(const daft_slots *slots, uint32_t index)
{
    return (uint32_t)slots->items[index].generation << DAFT_INDEX_BITS | index;
}

void daft_slots_remove(daft_slots *slots, uint32_t index)
{
    daft_slot *slot = &slots->items[index];
    slot->live = false;
    slots->live--;
    if (slot->generation == DAFT_MAX_GENERATION) return; /* retired */
    slot->generation++;
    slot->next_free = DAFT_NONE;
    if (slots->last_free != DAFT_NONE)
        slots->items[slots->last_free].next_free = index;
    else
        slots->first_free = index;
    slots->last_free = index;
    slots->free_count++;
}

/* ---- map ---- */

enum { REMOVED = -2 }; /* DAFT_NONE - 1 as a signed number */

void daft_map_free(daft_map *map, const daft_allocator *allocator)
{
    daft_release(allocator, map->entries);
    *map = (daft_map){0};
}

void daft_map_add(daft_map *map, uint64_t hash, uint32_t value)
{
    uint32_t mask = map->size - 1;
    uint32_t at = (uint32_t)(hash ^ hash >> 32) & mask;
    while (map->entries[at].value != DAFT_NONE) at = (at + 1) & mask;
    map->entries[at] = (daft_map_entry){hash, value};
    map->used++;
}

bool daft_map_reserve(daft_map *map, const daft_allocator *allocator, uint32_t more)
{
    if (2 * (map->used + more) <= map->size) return true;
    uint32_t size = 16;
    while (size < 2 * (map->used + more)) size *= 2;
    daft_map grown = {daft_alloc(allocator, size, sizeof *grown.entries), size, 0};
    if (!grown.entries) return false;
    for (uint32_t i = 0; i < size; i++) grown.entries[i] = (daft_map_entry){0, DAFT_NONE};
    for (uint32_t i = 0; i < map->size; i++)
        if (map->entries[i].value < (uint32_t)REMOVED)
            daft_map_add(&grown, map->entries[i].hash, map->entries[i].value);
    daft_map_free(map, allocator);
    *map = grown;
    return true;
}

uint32_t daft_map_next(const daft_map *map, uint64_t hash, uint32_t *cursor)
{
    if (map->size == 0) return DAFT_NONE;
    uint32_t mask = map->size - 1;
    for (;;) {
        const daft_map_entry *entry = &map->entries[((uint32_t)(hash ^ hash >> 32) + *cursor) & mask];
        if (entry->value == DAFT_NONE) return DAFT_NONE;
        ++*cursor;
        if (entry->hash == hash && entry->value != (uint32_t)REMOVED) return entry->value;
    }
}

void daft_map_remove(daft_map *map, uint64_t hash, uint32_t value)
{
    if (map->size == 0) return;
    uint32_t mask = map->size - 1;
    for (uint32_t at = (uint32_t)(hash ^ hash >> 32) & mask; map->entries[at].value != DAFT_NONE;
         at = (at + 1) & mask) {
        if (map->entries[at].hash != hash || map->entries[at].value != value) continue;
        map->entries[at].value = (uint32_t)REMOVED;
        return;
    }
}
