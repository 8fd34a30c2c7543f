/* Which of the listed touches have met: they have patches, or are touching as events tell it. What the rest of a step
 * asks of them is put together here, in one compact list, while their records are at hand. */
#include "sim/world.h"

#include <string.h>

#define DEEP 0.1f /* of a body's extent: what overlaps by more was made so, or was too fast */

void daft_sim_met_refresh(const daft_world *world, daft_sim_met *met)
{
    daft_sim_touch *touch = &world->touches[met->touch];
    const daft_sim_patch *patches = daft_sim_patches(touch);
    *met = (daft_sim_met){met->touch, touch->body_a, touch->body_b, 0, (uint8_t)touch->patch_count, 0};
    if (touch->sensor || touch->patch_count == 0) return;
    float least = INFINITY, load = 0;
    for (uint32_t i = 0; i < touch->patch_count; i++) {
        met->points = (uint16_t)(met->points + patches[i].count);
        load = daft_sim_max(load, patches[i].load);
        for (uint32_t k = 0; k < patches[i].count; k++) least = daft_sim_min(least, patches[i].points[k].separation);
    }
    const daft_sim_body *a = &world->bodies[touch->body_a], *b = &world->bodies[touch->body_b];
    met->flags = b->kind == DAFT_BODY_DYNAMIC ? DAFT_SIM_MET_JOINS : DAFT_SIM_MET_FIXED;
    if (least < -DEEP * a->extent) met->flags |= DAFT_SIM_MET_DEEP;
    if (least < -DEEP * daft_sim_min(a->extent, b->extent)) met->flags |= DAFT_SIM_MET_PARTS;
    if (daft_sim_finer_bears(world, a, b, load)) met->flags |= DAFT_SIM_MET_FIRM;
}

/* Whether an entry is among those that have met; then it goes to `to`. */
static bool has_met(const daft_world *world, daft_sim_listed *entry, daft_sim_met *to)
{
    if (entry->state == 0) return false;
    const daft_sim_touch *touch = &world->touches[entry->touch];
    if (touch->patch_count == 0 && !touch->touching) {
        entry->state = 0;
        return false;
    }
    to->touch = entry->touch;
    daft_sim_met_refresh(world, to);
    return true;
}

bool daft_sim_met_reserve(daft_world *world, size_t ranges)
{
    daft_sim_meeting *met = &world->met;
    met->count = world->met_ranges.count = 0;
    if (!daft_grow(&world->allocator, &met->items, &met->capacity, world->listed.count, 0, sizeof *met->items) ||
        !daft_sim_list_reserve(world, &world->met_ranges, ranges))
        return false;
    world->met_ranges.count = ranges;
    return true;
}

/* What a range came to: how many have met, which stand from where its entries begin. */
void daft_sim_met_range(daft_world *world, uint32_t range, size_t first, size_t count)
{
    uint32_t met = 0, flags = 0;
    for (size_t i = first; i < first + count; i++) {
        if (!has_met(world, &world->listed.items[i], &world->met.items[first + met])) continue;
        flags |= world->met.items[first + met++].flags;
    }
    world->met_ranges.items[range] = met | (flags & DAFT_SIM_MET_FIXED ? DAFT_SIM_RANGE_FIXED : 0);
}

void daft_sim_met_gather(daft_world *world, size_t grain)
{
    daft_sim_meeting *met = &world->met;
    for (size_t i = 0; i < world->met_ranges.count; i++) {
        uint32_t count = world->met_ranges.items[i] & ~DAFT_SIM_RANGE_FIXED;
        if (met->count != i * grain) memmove(met->items + met->count, met->items + i * grain, count * sizeof *met->items);
        met->count += count;
    }
}

bool daft_sim_met_update(daft_world *world)
{
    if (!daft_sim_met_reserve(world, 1)) return false;
    daft_sim_met_range(world, 0, 0, world->listed.count);
    daft_sim_met_gather(world, world->listed.count);
    return true;
}
