/* Touches: pairs of parts whose fat bounds meet, made when a part enters the tree anew, gone when the bounds part. They
 * hang on both bodies as lists, in a hash set by their parts, and, while a side is active, in the listing that a step
 * walks, which is in the order of keys. */
#include "sim/internal.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* ---- the set ---- */

static uint64_t mixed(uint64_t x)
{
    x = (x ^ x >> 33) * 0xff51afd7ed558ccdu;
    x = (x ^ x >> 33) * 0xc4ceb9fe1a85ec53u;
    return x ^ x >> 33;
}

static uint64_t key_of(uint32_t part_a, uint32_t part_b) { return (uint64_t)part_a << 32 | part_b; }

/* The pair in either order has one key in the set. */
static uint64_t set_key(uint32_t part_a, uint32_t part_b)
{
    return part_a < part_b ? key_of(part_a, part_b) : key_of(part_b, part_a);
}
static uint64_t set_key_of(const daft_sim_touch *touch) { return set_key(touch->part_a, touch->part_b); }

static size_t home(const daft_world *world, uint64_t key) { return mixed(key) & (world->pair_slot_count - 1); }

#define NO_PAIR UINT64_MAX

/* Where the pair is, or the empty slot where it belongs. There is always an empty one. */
static size_t find_slot(const daft_world *world, uint64_t key)
{
    size_t at = home(world, key), mask = world->pair_slot_count - 1;
    while (world->pair_keys[at] != NO_PAIR && world->pair_keys[at] != key) at = (at + 1) & mask;
    return at;
}

static bool exists(const daft_world *world, uint32_t part_a, uint32_t part_b)
{
    return world->pair_slot_count > 0 && world->pair_keys[find_slot(world, set_key(part_a, part_b))] != NO_PAIR;
}

static bool grow_set(daft_world *world, size_t count)
{
    size_t wanted = 64;
    while (wanted < 2 * count) wanted *= 2;
    if (wanted <= world->pair_slot_count) return true;
    uint64_t *keys = daft_alloc(&world->allocator, wanted, sizeof *keys);
    if (!keys) return false;
    daft_release(&world->allocator, world->pair_keys);
    world->pair_keys = keys;
    world->pair_slot_count = wanted;
    memset(keys, 0xff, wanted * sizeof *keys);
    for (uint32_t i = 0; i < world->touch_count; i++)
        if (world->touches[i].part_a != DAFT_SIM_NONE) {
            uint64_t key = set_key_of(&world->touches[i]);
            keys[find_slot(world, key)] = key;
        }
    return true;
}

/* What follows moves up, so that no search meets a gap. */
static void take_from_set(daft_world *world, const daft_sim_touch *touch)
{
    size_t mask = world->pair_slot_count - 1, gap = find_slot(world, set_key_of(touch)), at = gap;
    for (;;) {
        at = (at + 1) & mask;
        uint64_t next = world->pair_keys[at];
        if (next == NO_PAIR) break;
        size_t wanted = home(world, next);
        if (((at - wanted) & mask) < ((at - gap) & mask)) continue;
        world->pair_keys[gap] = next;
        gap = at;
    }
    world->pair_keys[gap] = NO_PAIR;
}

/* ---- touches ---- */

bool daft_sim_pairs_reserve(daft_world *world, size_t more)
{
    size_t needed = (size_t)world->live_touches + more, slots = (size_t)world->touch_count + more;
    return slots < INT32_MAX && grow_set(world, needed) &&
           daft_grow(&world->allocator, &world->touches, &world->touch_capacity, slots, world->touch_count,
                     sizeof *world->touches) &&
           daft_grow(&world->allocator, &world->fresh_listed.items, &world->fresh_listed.capacity,
                     world->touch_capacity, world->fresh_listed.count, sizeof *world->fresh_listed.items) &&
           daft_grow(&world->allocator, &world->merged.items, &world->merged.capacity, world->touch_capacity, 0,
                     sizeof *world->merged.items);
}

static void link_edge(daft_world *world, uint32_t index, int side)
{
    daft_sim_touch *touch = &world->touches[index];
    daft_sim_body *body = &world->bodies[side ? touch->body_b : touch->body_a];
    uint32_t edge = index << 1 | (uint32_t)side, first = body->first_touch;
    touch->next[side] = first;
    touch->previous[side] = DAFT_SIM_NONE;
    if (first != DAFT_SIM_NONE) world->touches[first >> 1].previous[first & 1] = edge;
    body->first_touch = edge;
}

static void unlink_edge(daft_world *world, uint32_t index, int side)
{
    daft_sim_touch *touch = &world->touches[index];
    daft_sim_body *body = &world->bodies[side ? touch->body_b : touch->body_a];
    uint32_t next = touch->next[side], previous = touch->previous[side];
    if (next != DAFT_SIM_NONE) world->touches[next >> 1].previous[next & 1] = previous;
    if (previous != DAFT_SIM_NONE)
        world->touches[previous >> 1].next[previous & 1] = next;
    else
        body->first_touch = next;
}

static void list_touch(daft_world *world, uint32_t index)
{
    daft_sim_touch *touch = &world->touches[index];
    if (touch->listed) return;
    touch->listed = true;
    world->bare |= daft_sim_is_bare(world, touch);
    uint32_t state = touch->patch_count > 0 || touch->touching ? DAFT_SIM_LISTED_MET : 0;
    world->fresh_listed.items[world->fresh_listed.count++] = (daft_sim_listed){daft_sim_touch_key(touch), index, state};
}

static bool is_dynamic(const daft_world *world, uint32_t part) { return world->parts[part].dynamic; }

/* Whether part a owns the touch of two dynamic parts. */
static bool owns(const daft_world *world, uint32_t a, uint32_t b)
{
    float mine = world->parts[a].reach, theirs = world->parts[b].reach;
    return mine < theirs || (mine == theirs && a < b);
}

bool daft_sim_touch_enter(daft_world *world, uint32_t index)
{
    daft_sim_touch *touch = &world->touches[index];
    if (exists(world, touch->part_a, touch->part_b)) return false;
    touch->listed = false;
    touch->owned_by_a = false;
    if (is_dynamic(world, touch->part_a) && is_dynamic(world, touch->part_b)) {
        touch->owned_by_a = owns(world, touch->part_a, touch->part_b);
        world->parts[touch->owned_by_a ? touch->part_a : touch->part_b].owned++;
    }
    daft_sim_touch_materials(world, touch);
    uint64_t key = set_key_of(touch);
    world->pair_keys[find_slot(world, key)] = key;
    link_edge(world, index, 0);
    link_edge(world, index, 1);
    world->live_touches++;
    if (daft_sim_is_active(&world->bodies[touch->body_a]) || daft_sim_is_active(&world->bodies[touch->body_b]))
        list_touch(world, index);
    return true;
}

static uint32_t insert(daft_world *world, uint32_t part_a, uint32_t part_b)
{
    uint32_t index = world->free_touch;
    if (index == DAFT_SIM_NONE)
        index = world->touch_count++;
    else
        world->free_touch = world->touches[index].next[0];
    daft_sim_touch *touch = &world->touches[index];
    *touch = (daft_sim_touch){.part_a = part_a,
                              .part_b = part_b,
                              .body_a = world->parts[part_a].body,
                              .body_b = world->parts[part_b].body};
    touch->sensor = world->parts[part_a].sensor || world->parts[part_b].sensor;
    daft_sim_touch_enter(world, index);
    return index;
}

/* Its place in the listing is cleared when that is next updated. */
void daft_sim_touch_remove(daft_world *world, uint32_t index)
{
    daft_sim_touch *touch = &world->touches[index];
    if (touch->touching) daft_sim_event_end(world, touch);
    if (is_dynamic(world, touch->part_a) && is_dynamic(world, touch->part_b))
        world->parts[touch->owned_by_a ? touch->part_a : touch->part_b].owned--;
    take_from_set(world, touch);
    unlink_edge(world, index, 0);
    unlink_edge(world, index, 1);
    daft_release(&world->allocator, touch->more);
    touch->more = NULL;
    touch->part_a = touch->part_b = DAFT_SIM_NONE;
    touch->next[0] = world->free_touch;
    world->free_touch = index;
    world->live_touches--;
}

/* Entries of touches that are gone go too: their slots may be taken again before the listing is next updated. */
static void forget_entries(daft_sim_listing *listing, const daft_world *world)
{
    size_t kept = 0;
    for (size_t i = 0; i < listing->count; i++)
        if (world->touches[listing->items[i].touch].part_a != DAFT_SIM_NONE) listing->items[kept++] = listing->items[i];
    listing->count = kept;
}

void daft_sim_touch_drop(daft_world *world, uint32_t index)
{
    daft_sim_touch_remove(world, index);
    forget_entries(&world->listed, world);
    forget_entries(&world->fresh_listed, world);
}

void daft_sim_touches_remove(daft_world *world, uint32_t body)
{
    bool listed = false;
    for (uint32_t edge = world->bodies[body].first_touch, next; edge != DAFT_SIM_NONE; edge = next) {
        next = world->touches[edge >> 1].next[edge & 1];
        listed |= world->touches[edge >> 1].listed;
        daft_sim_touch_remove(world, edge >> 1);
    }
    if (!listed) return;
    forget_entries(&world->listed, world);
    forget_entries(&world->fresh_listed, world);
}

void daft_sim_touches_list(daft_world *world, uint32_t body)
{
    for (uint32_t edge = world->bodies[body].first_touch; edge != DAFT_SIM_NONE;
         edge = world->touches[edge >> 1].next[edge & 1])
        list_touch(world, edge >> 1);
}

void daft_sim_touches_forget(daft_world *world, uint32_t body)
{
    for (uint32_t edge = world->bodies[body].first_touch; edge != DAFT_SIM_NONE;
         edge = world->touches[edge >> 1].next[edge & 1])
        world->touches[edge >> 1].patch_count = 0, world->touches[edge >> 1].cache.clearance = 0;
}

/* ---- new pairs ---- */

bool daft_sim_may_meet(const daft_world *world, uint32_t a, uint32_t b)
{
    const daft_sim_part *x = &world->parts[a], *y = &world->parts[b];
    if (x->body == y->body || !(x->layers & y->mask) || !(y->layers & x->mask)) return false;
    daft_body_kind kind_x = world->bodies[x->body].kind, kind_y = world->bodies[y->body].kind;
    if (x->sensor || y->sensor) return !(x->sensor && y->sensor) && (kind_x != DAFT_BODY_STATIC || kind_y != DAFT_BODY_STATIC);
    if (kind_x != DAFT_BODY_DYNAMIC && kind_y != DAFT_BODY_DYNAMIC) return false;
    return !daft_sim_joined(world, x->body, y->body);
}

/* Keys of touches to be made, in any order; of more than there is room for, only how many. */
typedef struct candidates {
    const daft_world *world;
    uint64_t *keys;
    unsigned capacity;
    atomic_uint count;
} candidates;

enum { HITS = 64 };

typedef struct search {
    const daft_world *world;
    candidates *found;
    uint32_t part;
    uint32_t hits[HITS]; /* parts whose fat bounds meet its, to be looked at together: their records are on their way */
    uint32_t hit_count;
    uint32_t partners[DAFT_SIM_MAX_PARTNERS]; /* that this part will own: those of lowest index */
    uint32_t partner_count;
} search;

static void add_candidate(search *s, uint32_t other)
{
    const daft_world *world = s->world;
    /* A dynamic one first, the sensor first, else the lower index. */
    uint32_t a = s->part, b = other;
    bool dynamic_a = is_dynamic(world, a), dynamic_b = is_dynamic(world, b);
    bool sensor = world->parts[a].sensor || world->parts[b].sensor;
    bool swap = sensor ? world->parts[b].sensor : dynamic_a == dynamic_b ? b < a : dynamic_b;
    unsigned at = atomic_fetch_add_explicit(&s->found->count, 1, memory_order_relaxed);
    if (at < s->found->capacity) s->found->keys[at] = swap ? key_of(b, a) : key_of(a, b);
}

/* Of parts whose fat bounds meet. */
static bool is_new(const search *s, uint32_t other)
{
    const daft_world *world = s->world;
    return other != s->part && !exists(world, s->part, other) && daft_sim_may_meet(world, s->part, other);
}

/* Keeps the partners of lowest index. */
static void keep_partner(search *s, uint32_t other)
{
    bool full = s->partner_count == DAFT_SIM_MAX_PARTNERS;
    if (full && other > s->partners[DAFT_SIM_MAX_PARTNERS - 1]) return;
    uint32_t i = full ? DAFT_SIM_MAX_PARTNERS - 1 : s->partner_count++;
    for (; i > 0 && other < s->partners[i - 1]; i--) s->partners[i] = s->partners[i - 1];
    s->partners[i] = other;
}

/* A pair of two dynamic parts is found by the one that will own it, if that moved. */
static void judge(search *s, uint32_t other)
{
    const daft_world *world = s->world;
    const daft_sim_part *mine = &world->parts[s->part], *theirs = &world->parts[other];
    if (!mine->dynamic || !theirs->dynamic) {
        if (is_new(s, other)) add_candidate(s, other);
    } else if (owns(world, s->part, other)) {
        if (s->partner_count == DAFT_SIM_MAX_PARTNERS && other > s->partners[DAFT_SIM_MAX_PARTNERS - 1]) return;
        if (is_new(s, other)) keep_partner(s, other);
    } else if (theirs->moved_slot == DAFT_SIM_NONE && theirs->owned < DAFT_SIM_MAX_PARTNERS && is_new(s, other)) {
        add_candidate(s, other);
    }
}

static void judge_hits(search *s)
{
    for (uint32_t i = 0; i < s->hit_count; i++) judge(s, s->hits[i]);
    s->hit_count = 0;
}

static void visit(void *context, uint32_t other)
{
    search *s = context;
    const daft_world *world = s->world;
    if (other == s->part) return;
    __builtin_prefetch(&world->parts[other]);
    if (world->pair_slot_count > 0) __builtin_prefetch(&world->pair_keys[home(world, set_key(s->part, other))]);
    s->hits[s->hit_count++] = other;
    if (s->hit_count == HITS) judge_hits(s);
}

/* Thousands of bodies in one spot would each visit all the others to find as many partners as it may have. They were
 * most likely made one after the other: if enough of the parts that follow are partners, they are taken, and none is
 * searched for. Elsewhere the parts that follow miss at once. */
static bool crowded(search *s)
{
    const daft_world *world = s->world;
    if (world->moved.count < world->trees[DAFT_BODY_DYNAMIC].leaf_count) return false;
    uint32_t misses = 0;
    for (uint32_t i = s->part + 1; i < world->part_count && misses < 8 + 4 * s->partner_count; i++) {
        if (world->parts[i].body != DAFT_SIM_NONE && is_dynamic(world, i) && owns(world, s->part, i) &&
            daft_sim_overlap(&world->fat[i], &world->fat[s->part]) && is_new(s, i))
            s->partners[s->partner_count++] = i;
        else
            misses++;
        if (s->partner_count == DAFT_SIM_MAX_PARTNERS) return true;
    }
    s->partner_count = 0;
    return false;
}

static void search_part(const daft_world *world, uint32_t part, candidates *found)
{
    search s = {.world = world, .found = found, .part = part};
    const daft_sim_bounds *fat = &world->fat[part];
    daft_body_kind kind = world->bodies[world->parts[part].body].kind;
    bool full = world->parts[part].owned >= DAFT_SIM_MAX_PARTNERS;
    daft_sim_tree_query(&world->trees[DAFT_BODY_KINEMATIC], fat, visit, &s);
    if (kind != DAFT_BODY_STATIC) daft_sim_tree_query(&world->trees[DAFT_BODY_STATIC], fat, visit, &s);
    judge_hits(&s);
    if (kind != DAFT_BODY_DYNAMIC || (!full && !crowded(&s)))
        daft_sim_tree_query(&world->trees[DAFT_BODY_DYNAMIC], fat, visit, &s);
    judge_hits(&s);
    for (uint32_t i = 0; i < s.partner_count; i++) add_candidate(&s, s.partners[i]);
}

enum { GRAIN = 16, PARALLEL_PARTS = 128 };

static void search_range(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    candidates *found = context;
    const daft_sim_list *moved = &found->world->moved;
    size_t first = (size_t)index * GRAIN, end = first + GRAIN;
    if (end > moved->count) end = moved->count;
    for (size_t i = first; i < end; i++) search_part(found->world, moved->items[i], found);
}

/* Nothing is changed while parts are searched around; where room was short, all are searched again with enough. */
static bool find_candidates(daft_world *world)
{
    uint32_t tasks = (uint32_t)((world->moved.count + GRAIN - 1) / GRAIN);
    for (size_t needed = 4 * world->moved.count;;) {
        if (!daft_grow(&world->allocator, &world->candidates, &world->candidate_capacity, needed, 0,
                       sizeof *world->candidates))
            return false;
        candidates found = {world, world->candidates, (unsigned)world->candidate_capacity, 0};
        daft_sim_for(world, world->moved.count >= PARALLEL_PARTS, tasks, search_range, &found);
        needed = world->candidate_count = atomic_load_explicit(&found.count, memory_order_relaxed);
        if (needed <= world->candidate_capacity) return true;
    }
}

static int by_value(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* What stands in a body that sleeps wakes it. */
static void wake_inside(daft_world *world, const daft_sim_touch *touch)
{
    const daft_sim_body *a = &world->bodies[touch->body_a];
    if (touch->sensor || !a->asleep || !daft_sim_overlap(&world->tight[touch->part_a], &world->tight[touch->part_b]))
        return;
    if (world->bodies[touch->body_b].kind != DAFT_BODY_DYNAMIC) daft_sim_wake(world, touch->body_a);
}

enum { AHEAD = 4, FAR_AHEAD = 16 };

/* What a new touch is made from is on its way. */
static void fetch_pair(const daft_world *world, uint64_t key)
{
    const uint32_t parts[2] = {(uint32_t)(key >> 32), (uint32_t)key};
    for (int i = 0; i < 2; i++) {
        __builtin_prefetch(&world->parts[parts[i]]);
        __builtin_prefetch(&world->parts[parts[i]].material);
    }
    __builtin_prefetch(&world->pair_keys[home(world, set_key(parts[0], parts[1]))]);
}

static void insert_candidates(daft_world *world)
{
    if (world->candidate_count > 1)
        qsort(world->candidates, world->candidate_count, sizeof *world->candidates, by_value);
    uint64_t last = UINT64_MAX;
    for (size_t i = 0; i < world->candidate_count; i++) {
        uint64_t key = world->candidates[i];
        uint32_t a = (uint32_t)(key >> 32), b = (uint32_t)key;
        if (i + AHEAD < world->candidate_count) fetch_pair(world, world->candidates[i + AHEAD]);
        if (key == last || exists(world, a, b)) continue;
        last = key;
        if (is_dynamic(world, a) && is_dynamic(world, b) &&
            world->parts[owns(world, a, b) ? a : b].owned >= DAFT_SIM_MAX_PARTNERS)
            continue;
        uint32_t touch = insert(world, a, b);
        wake_inside(world, &world->touches[touch]);
    }
}

bool daft_sim_pairs_find(daft_world *world)
{
    if (!find_candidates(world) || !daft_sim_pairs_reserve(world, world->candidate_count)) return false;
    insert_candidates(world);
    for (size_t i = 0; i < world->moved.count; i++) world->parts[world->moved.items[i]].moved_slot = DAFT_SIM_NONE;
    world->moved.count = 0;
    return true;
}

/* ---- the listing ---- */

/* The end of the ordered run that begins at `from`. */
static size_t run_end(const daft_sim_listed *items, size_t from, size_t count)
{
    size_t end = from + 1;
    while (end < count && items[end - 1].key <= items[end].key) end++;
    return end;
}

static void merge_runs(const daft_sim_listed *from, size_t middle, size_t end, daft_sim_listed *to)
{
    for (size_t i = 0, k = middle; i < middle || k < end;)
        *to++ = k == end || (i < middle && from[i].key <= from[k].key) ? from[i++] : from[k++];
}

/* Runs that are in order already are merged two by two until one is left. */
void daft_sim_listed_sort(daft_sim_listed *items, size_t count, daft_sim_listed *scratch)
{
    daft_sim_listed *from = items, *to = scratch;
    for (size_t runs = 2; runs > 1;) {
        runs = 0;
        if (count == 0 || run_end(from, 0, count) == count) break;
        for (size_t at = 0; at < count; runs++) {
            size_t middle = run_end(from, at, count), end = middle < count ? run_end(from, middle, count) : count;
            merge_runs(from + at, middle - at, end - at, to + at);
            at = end;
        }
        daft_sim_listed *swap = from;
        from = to, to = swap;
    }
    if (from != items) memcpy(items, from, count * sizeof *items);
}

static bool has_active_side(const daft_world *world, const daft_sim_touch *touch)
{
    return daft_sim_is_active(&world->bodies[touch->body_a]) || daft_sim_is_active(&world->bodies[touch->body_b]);
}

/* Takes out what came apart, and, where some body came to rest, what has no active side. */
static void thin_out(daft_world *world)
{
    daft_sim_listing *listed = &world->listed;
    size_t kept = 0;
    for (size_t i = 0; i < listed->count; i++) {
        const daft_sim_listed *entry = &listed->items[i];
        if (i + FAR_AHEAD < listed->count && entry[FAR_AHEAD].state & DAFT_SIM_LISTED_APART)
            __builtin_prefetch(&world->touches[entry[FAR_AHEAD].touch]);
        if (entry->state & DAFT_SIM_LISTED_APART) {
            daft_sim_touch_remove(world, entry->touch);
            continue;
        }
        if (world->some_idle) {
            daft_sim_touch *touch = &world->touches[entry->touch];
            touch->listed = has_active_side(world, touch);
            if (!touch->listed) continue;
        }
        listed->items[kept++] = *entry;
    }
    listed->count = kept;
    world->some_apart = world->some_idle = false;
}

/* Of those from `from` on, the first whose key is larger. */
static size_t first_after(const daft_sim_listing *listing, size_t from, uint64_t key)
{
    size_t end = listing->count;
    while (from < end) {
        size_t middle = from + (end - from) / 2;
        if (listing->items[middle].key > key)
            end = middle;
        else
            from = middle + 1;
    }
    return from;
}

/* A list without items may have no memory to point to. */
static void append(daft_sim_listing *to, const daft_sim_listed *items, size_t first, size_t count)
{
    if (count > 0) memcpy(to->items + to->count, items + first, count * sizeof *items);
    to->count += count;
}

bool daft_sim_listing_update(daft_world *world)
{
    daft_sim_listing *old = &world->listed, *fresh = &world->fresh_listed, *merged = &world->merged;
    if (world->some_apart || world->some_idle) thin_out(world);
    if (fresh->count == 0) return true;
    if (!daft_grow(&world->allocator, &merged->items, &merged->capacity, old->count + fresh->count, 0,
                   sizeof *merged->items))
        return false;
    daft_sim_listed_sort(fresh->items, fresh->count, merged->items);
    size_t from = 0;
    merged->count = 0;
    for (size_t k = 0; k < fresh->count; k++) {
        size_t to = first_after(old, from, fresh->items[k].key);
        append(merged, old->items, from, to - from);
        append(merged, fresh->items, k, 1);
        from = to;
    }
    append(merged, old->items, from, old->count - from);
    fresh->count = 0;
    daft_sim_listing swap = *old;
    *old = *merged;
    *merged = swap;
    return true;
}
