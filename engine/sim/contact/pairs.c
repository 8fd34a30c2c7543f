/* Contact pairs: parts near each other, made when their bounds over a step first meet, gone when they do not in a step
 * in which one of them is active. They hang on both bodies as lists, and, while a side is active, in the active list
 * that a step walks, which is in the order of keys: the near pairs of a step, sorted too, are compared with it in one
 * pass. */
#include "sim/world.h"
#include "sim/broad/broad.h"
#include "sim/contact/contact.h"
#include "sim/events.h"
#include "sim/sleep.h"
#include "sim/solve/solver.h"

#include <stdlib.h>
#include <string.h>

/* ---- pairs ---- */

bool daft_sim_pairs_reserve(daft_world *world, size_t more)
{
    size_t slots = (size_t)world->pair_count + more;
    return slots < INT32_MAX &&
           daft_grow(&world->allocator, &world->pairs, &world->pair_capacity, slots, world->pair_count,
                     sizeof *world->pairs) &&
           daft_grow(&world->allocator, &world->active.items, &world->active.capacity, world->pair_capacity,
                     world->active.count, sizeof *world->active.items) &&
           daft_grow(&world->allocator, &world->scratch.sorting.items, &world->scratch.sorting.capacity,
                     2 * world->pair_capacity, 0, sizeof *world->scratch.sorting.items);
}

static void link_edge(daft_world *world, uint32_t index, int side)
{
    daft_sim_pair *pair = &world->pairs[index];
    daft_sim_body *body = &world->bodies[side ? pair->body_b : pair->body_a];
    uint32_t edge = index << 1 | (uint32_t)side, first = body->first_pair;
    pair->next[side] = first;
    pair->previous[side] = DAFT_SIM_NONE;
    if (first != DAFT_SIM_NONE) world->pairs[first >> 1].previous[first & 1] = edge;
    body->first_pair = edge;
}

static void unlink_edge(daft_world *world, uint32_t index, int side)
{
    daft_sim_pair *pair = &world->pairs[index];
    daft_sim_body *body = &world->bodies[side ? pair->body_b : pair->body_a];
    uint32_t next = pair->next[side], previous = pair->previous[side];
    if (next != DAFT_SIM_NONE) world->pairs[next >> 1].previous[next & 1] = previous;
    if (previous != DAFT_SIM_NONE)
        world->pairs[previous >> 1].next[previous & 1] = next;
    else
        body->first_pair = next;
}

static void activate(daft_world *world, uint32_t index)
{
    daft_sim_pair *pair = &world->pairs[index];
    if (pair->active) return;
    pair->active = true;
    world->unallocated |= daft_sim_is_unallocated(world, pair);
    daft_sim_active_list *list = &world->active;
    daft_sim_active entry = {
        .key = daft_sim_pair_key(pair), .pair = index, .body_a = pair->body_a, .body_b = pair->body_b};
    entry.flags = pair->manifold_count > 0 || pair->touching ? DAFT_SIM_OVERLAPS : 0;
    if (list->count > 0 && list->items[list->count - 1].key > entry.key) world->sorted = false;
    list->items[list->count++] = entry;
}

static bool is_dynamic(const daft_world *world, uint32_t part) { return world->parts[part].dynamic; }

/* Whether part a owns the pair of two dynamic parts. */
static bool owns(const daft_world *world, uint32_t a, uint32_t b)
{
    float mine = world->parts[a].reach, theirs = world->parts[b].reach;
    return mine < theirs || (mine == theirs && a < b);
}

void daft_sim_pair_enter(daft_world *world, uint32_t pair_index)
{
    daft_sim_pair *pair = &world->pairs[pair_index];
    pair->active = false;
    pair->owned_by_a = false;
    if (is_dynamic(world, pair->part_a) && is_dynamic(world, pair->part_b)) {
        pair->owned_by_a = owns(world, pair->part_a, pair->part_b);
        world->parts[pair->owned_by_a ? pair->part_a : pair->part_b].owned++;
    }
    if (pair->materials_cached || pair->manifold_count > 0)
        daft_sim_pair_materials(world, pair); /* of a world that was loaded */
    link_edge(world, pair_index, 0);
    link_edge(world, pair_index, 1);
    world->live_pairs++;
    if (daft_sim_is_active(&world->bodies[pair->body_a]) || daft_sim_is_active(&world->bodies[pair->body_b]))
        activate(world, pair_index);
}

static uint32_t insert(daft_world *world, uint32_t part_a, uint32_t part_b)
{
    uint32_t index = world->free_pair;
    if (index == DAFT_SIM_NONE)
        index = world->pair_count++;
    else
        world->free_pair = world->pairs[index].next[0];
    daft_sim_pair *pair = &world->pairs[index];
    *pair = (daft_sim_pair){
        .part_a = part_a, .part_b = part_b, .body_a = world->parts[part_a].body, .body_b = world->parts[part_b].body};
    pair->sensor = world->parts[part_a].sensor || world->parts[part_b].sensor;
    daft_sim_pair_enter(world, index);
    return index;
}

/* Its place in the active list is cleared by who calls. */
static void remove_pair(daft_world *world, uint32_t pair_index)
{
    daft_sim_pair *pair = &world->pairs[pair_index];
    if (pair->touching) daft_sim_event_end(world, pair);
    if (is_dynamic(world, pair->part_a) && is_dynamic(world, pair->part_b))
        world->parts[pair->owned_by_a ? pair->part_a : pair->part_b].owned--;
    unlink_edge(world, pair_index, 0);
    unlink_edge(world, pair_index, 1);
    daft_release(&world->allocator, pair->more);
    pair->more = NULL;
    pair->part_a = pair->part_b = DAFT_SIM_NONE;
    pair->next[0] = world->free_pair;
    world->free_pair = pair_index;
    world->live_pairs--;
}

/* Entries of pairs that are gone go too: their slots may be taken again. */
static void forget_entries(daft_world *world)
{
    daft_sim_active_list *list = &world->active;
    size_t kept = 0;
    for (size_t i = 0; i < list->count; i++)
        if (world->pairs[list->items[i].pair].part_a != DAFT_SIM_NONE) list->items[kept++] = list->items[i];
    list->count = kept;
}

void daft_sim_pair_drop(daft_world *world, uint32_t pair_index)
{
    remove_pair(world, pair_index);
    forget_entries(world);
}

void daft_sim_pairs_remove(daft_world *world, uint32_t body)
{
    bool active = false;
    for (uint32_t edge = world->bodies[body].first_pair, next; edge != DAFT_SIM_NONE; edge = next) {
        next = world->pairs[edge >> 1].next[edge & 1];
        active |= world->pairs[edge >> 1].active;
        remove_pair(world, edge >> 1);
    }
    if (active) forget_entries(world);
}

void daft_sim_pairs_activate(daft_world *world, uint32_t body)
{
    for (uint32_t edge = world->bodies[body].first_pair; edge != DAFT_SIM_NONE;
         edge = world->pairs[edge >> 1].next[edge & 1])
        activate(world, edge >> 1);
}

void daft_sim_pairs_forget(daft_world *world, uint32_t body)
{
    for (uint32_t edge = world->bodies[body].first_pair; edge != DAFT_SIM_NONE;
         edge = world->pairs[edge >> 1].next[edge & 1])
        world->pairs[edge >> 1].manifold_count = 0;
}

/* ---- near parts ---- */

static bool is_joined(const daft_world *world, uint32_t body_a, uint32_t body_b)
{
    uint32_t first = daft_min_u(body_a, body_b), places = daft_max_u(body_a, body_b) - first;
    if (places == 0) return false;
    if (places <= DAFT_SIM_JOINED_PLACES) return world->bodies[first].joined >> (places - 1) & 1;
    if (!world->bodies[body_a].joined_far) return false;
    for (uint32_t e = world->bodies[body_a].first_joint; e != DAFT_SIM_NONE; e = world->joints[e >> 1].next[e & 1]) {
        const daft_sim_joint *joint = &world->joints[e >> 1];
        if (!joint->collide && joint->body[(e & 1) ^ 1] == body_b) return true;
    }
    return false;
}

bool daft_sim_may_meet(const daft_world *world, uint32_t a, uint32_t b)
{
    const daft_sim_part *x = &world->parts[a], *y = &world->parts[b];
    if (x->body == y->body || !(x->layers & y->mask) || !(y->layers & x->mask)) return false;
    daft_body_kind kind_x = world->bodies[x->body].kind, kind_y = world->bodies[y->body].kind;
    if (x->sensor || y->sensor)
        return !(x->sensor && y->sensor) && (kind_x != DAFT_BODY_STATIC || kind_y != DAFT_BODY_STATIC);
    if (kind_x != DAFT_BODY_DYNAMIC && kind_y != DAFT_BODY_DYNAMIC) return false;
    return !is_joined(world, x->body, y->body);
}

enum { DIGIT = 8 /* bits */ };

/* One pass of a radix sort: by `bits` bits from `shift` on. */
static void sort_by_digit(const uint64_t *from, uint64_t *to, size_t count, uint32_t shift, uint32_t bits)
{
    uint32_t next[1 << DIGIT] = {0}, mask = (1u << bits) - 1, sum = 0;
    for (size_t i = 0; i < count; i++) next[from[i] >> shift & mask]++;
    for (uint32_t digit = 0; digit <= mask; digit++) {
        uint32_t here = next[digit];
        next[digit] = sum;
        sum += here;
    }
    for (size_t i = 0; i < count; i++) to[next[from[i] >> shift & mask]++] = from[i];
}

/* By `bits` bits from `shift` on, in as many passes as it takes; gives which of both places they are in then. */
static uint64_t *sort_by_bits(uint64_t *keys, uint64_t *other, size_t count, uint32_t shift, uint32_t bits)
{
    uint32_t passes = (bits + DIGIT - 1) / DIGIT;
    for (uint32_t pass = 0, done = 0; pass < passes; pass++) {
        uint32_t digit = (bits - done + passes - pass - 1) / (passes - pass);
        sort_by_digit(keys, other, count, shift + done, digit);
        uint64_t *swap = keys;
        keys = other, other = swap;
        done += digit;
    }
    return keys;
}

/* Keys of near pairs in order, in one of both places. */
static uint64_t *sort_near(daft_world *world)
{
    uint32_t bits = 1;
    while (bits < 32 && world->part_count >> bits) bits++;
    uint64_t *by_b =
        sort_by_bits(world->scratch.candidates, world->scratch.ordered, world->scratch.candidate_count, 0, bits);
    uint64_t *other = by_b == world->scratch.ordered ? world->scratch.candidates : world->scratch.ordered;
    return sort_by_bits(by_b, other, world->scratch.candidate_count, 32, bits);
}

/* A pair of two that rest is no longer active, and stays. */
static void lose(daft_world *world, const daft_sim_active *entry)
{
    if (world->slots[entry->key >> 32] != DAFT_SIM_NONE || world->slots[(uint32_t)entry->key] != DAFT_SIM_NONE)
        remove_pair(world, entry->pair);
    else
        world->pairs[entry->pair].active = false;
}

/* What is active and not near goes. Of what is near and not active the keys are left at the begin of `near`: gives how
 * many. */
static size_t compare(daft_world *world, uint64_t *near, size_t count)
{
    daft_sim_active_list *list = &world->active;
    size_t k = 0, fresh = 0, kept = 0;
    for (size_t i = 0; i < list->count; i++) {
        daft_sim_active entry = list->items[i];
        while (k < count && near[k] < entry.key) near[fresh++] = near[k++];
        if (k < count && near[k] == entry.key) {
            list->items[kept++] = entry;
            k++;
        } else {
            lose(world, &entry);
        }
    }
    while (k < count) near[fresh++] = near[k++];
    list->count = kept;
    return fresh;
}

/* What stands in a body that sleeps wakes it. */
static void wake_inside(daft_world *world, const daft_sim_pair *pair)
{
    const daft_sim_body *a = &world->bodies[pair->body_a];
    if (pair->sensor || !a->asleep || !daft_sim_overlap(&world->tight[pair->part_a], &world->tight[pair->part_b]))
        return;
    if (world->bodies[pair->body_b].kind != DAFT_BODY_DYNAMIC) daft_sim_wake(world, pair->body_a);
}

static bool is_owner_full(const daft_world *world, uint32_t a, uint32_t b)
{
    return is_dynamic(world, a) && is_dynamic(world, b) &&
           world->parts[owns(world, a, b) ? a : b].owned >= DAFT_SIM_MAX_PARTNERS;
}

static void make_pairs(daft_world *world, const uint64_t *near, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t a = (uint32_t)(near[i] >> 32), b = (uint32_t)near[i];
        if (!daft_sim_may_meet(world, a, b) || is_owner_full(world, a, b)) continue;
        wake_inside(world, &world->pairs[insert(world, a, b)]);
    }
}

/* What was placed and rests leaves the groups again. */
static void forget_moved(daft_world *world)
{
    for (size_t i = 0; i < world->moved.count; i++) {
        daft_sim_part *part = &world->parts[world->moved.items[i]];
        part->moved_slot = DAFT_SIM_NONE;
        if (!daft_sim_is_active(&world->bodies[part->body])) daft_sim_group_leave(world, world->moved.items[i]);
    }
    world->moved.count = 0;
}

/* ---- the active list ---- */

/* The end of the ordered run that begins at `from`. */
static size_t run_end(const daft_sim_active *items, size_t from, size_t count)
{
    size_t end = from + 1;
    while (end < count && items[end - 1].key <= items[end].key) end++;
    return end;
}

static void merge_runs(const daft_sim_active *from, size_t middle, size_t end, daft_sim_active *to)
{
    for (size_t i = 0, k = middle; i < middle || k < end;)
        *to++ = k == end || (i < middle && from[i].key <= from[k].key) ? from[i++] : from[k++];
}

/* Runs that are in order already are merged two by two until one is left. */
void daft_sim_active_sort(daft_sim_active *items, size_t count, daft_sim_active *scratch)
{
    daft_sim_active *from = items, *to = scratch;
    for (size_t runs = 2; runs > 1;) {
        runs = 0;
        if (count == 0 || run_end(from, 0, count) == count) break;
        for (size_t at = 0; at < count; runs++) {
            size_t middle = run_end(from, at, count), end = middle < count ? run_end(from, middle, count) : count;
            merge_runs(from + at, middle - at, end - at, to + at);
            at = end;
        }
        daft_sim_active *swap = from;
        from = to, to = swap;
    }
    if (from != items) memcpy(items, from, count * sizeof *items);
}

void daft_sim_active_update(daft_world *world)
{
    if (!world->sorted) daft_sim_active_sort(world->active.items, world->active.count, world->scratch.sorting.items);
    world->sorted = true;
}

#define DEEP 0.1f /* of a body's extent: what overlaps by more was made so, or was too fast */

void daft_sim_active_refresh(const daft_world *world, daft_sim_active *entry)
{
    daft_sim_pair *pair = &world->pairs[entry->pair];
    const daft_sim_manifold *manifolds = daft_sim_manifolds(pair);
    entry->manifolds = (uint8_t)pair->manifold_count, entry->points = 0;
    entry->flags = pair->manifold_count > 0 || pair->touching ? DAFT_SIM_OVERLAPS : 0;
    if (pair->sensor || pair->manifold_count == 0) return;
    float least = INFINITY, load = 0;
    for (uint32_t i = 0; i < pair->manifold_count; i++) {
        entry->points = (uint16_t)(entry->points + manifolds[i].count);
        load = daft_sim_max(load, manifolds[i].load);
        for (uint32_t k = 0; k < manifolds[i].count; k++)
            least = daft_sim_min(least, manifolds[i].points[k].separation);
    }
    const daft_sim_body *a = &world->bodies[pair->body_a], *b = &world->bodies[pair->body_b];
    entry->flags |= b->kind == DAFT_BODY_DYNAMIC ? DAFT_SIM_JOINS : DAFT_SIM_FIXED;
    if (least < -DEEP * a->extent) entry->flags |= DAFT_SIM_DEEP;
    if (least < -DEEP * daft_sim_min(a->extent, b->extent)) entry->flags |= DAFT_SIM_DEPENETRATES;
    if (daft_sim_load_is_heavy(world, a, b, load)) entry->flags |= DAFT_SIM_STIFF;
}

void daft_sim_active_refresh_all(daft_world *world)
{
    for (size_t i = 0; i < world->active.count; i++)
        if (world->active.items[i].flags) daft_sim_active_refresh(world, &world->active.items[i]);
}

/* ---- both ---- */

bool daft_sim_pairs_find(daft_world *world)
{
    daft_sim_active_update(world);
    if (!daft_sim_groups_search(world) ||
        !daft_grow(&world->allocator, &world->scratch.ordered, &world->scratch.ordered_capacity,
                   world->scratch.candidate_count, 0, sizeof *world->scratch.ordered))
        return false;
    uint64_t *near = sort_near(world);
    size_t fresh = compare(world, near, world->scratch.candidate_count);
    if (!daft_sim_pairs_reserve(world, fresh)) return false;
    make_pairs(world, near, fresh);
    forget_moved(world);
    daft_sim_active_update(world);
    return true;
}
