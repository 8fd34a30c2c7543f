/* Touches: near pairs of parts, made when their bounds over a step first meet, gone when they do not in a step in which
 * one of them is active. They hang on both bodies as lists, and, while a side is active, in the listing that a step walks,
 * which is in the order of keys. */
#include "sim/world.h"

#include <stdlib.h>
#include <string.h>

/* ---- touches ---- */

bool daft_sim_pairs_reserve(daft_world *world, size_t more)
{
    size_t slots = (size_t)world->touch_count + more;
    return slots < INT32_MAX &&
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

void daft_sim_touch_enter(daft_world *world, uint32_t index)
{
    daft_sim_touch *touch = &world->touches[index];
    touch->listed = false;
    touch->owned_by_a = false;
    if (is_dynamic(world, touch->part_a) && is_dynamic(world, touch->part_b)) {
        touch->owned_by_a = owns(world, touch->part_a, touch->part_b);
        world->parts[touch->owned_by_a ? touch->part_a : touch->part_b].owned++;
    }
    if (touch->known || touch->patch_count > 0) daft_sim_touch_materials(world, touch); /* of a world that was loaded */
    link_edge(world, index, 0);
    link_edge(world, index, 1);
    world->live_touches++;
    if (daft_sim_is_active(&world->bodies[touch->body_a]) || daft_sim_is_active(&world->bodies[touch->body_b]))
        list_touch(world, index);
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

enum {
    FEW = 32,
    DIGIT = 8,     /* bits */
    BUCKETS = 64,  /* at most */
    BUCKET = 512,  /* near pairs, about */
    SLICES = 16,   /* of near pairs as they were found, at most; */
    SIDE_BY_SIDE = 4, /* of which so many are gone through in turns: pairs found one after another go to one bucket, and would wait
                         for each other there */
    PARALLEL_NEAR = 2048
};

/* Near pairs are ordered and compared with the listing in buckets, side by side: the pairs of so many parts a, whose indices
 * follow each other. */
typedef struct near_pairs {
    daft_world *world;
    uint32_t bits, low; /* of an index; of those, below the bucket's */
    uint32_t count;     /* of buckets */
    bool wide;
    size_t slice;       /* near pairs in each */
    struct bucket {
        uint32_t first, count;        /* of near pairs */
        size_t listed, listed_count;  /* of the listing */
        uint32_t kept, lost, fresh;   /* of the listing, of the listing, of near pairs: from where they begin */
        size_t merged;                /* where its part of the new listing begins; */
        size_t entered, entered_end;  /* of the fresh ones, what is to be in it */
    } buckets[BUCKETS];
    uint32_t next[SLICES][BUCKETS]; /* of each slice, how many go into a bucket; then where the next one goes */
} near_pairs;

static void sort_few(uint64_t *keys, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        uint64_t key = keys[i];
        size_t k = i;
        for (; k > 0 && keys[k - 1] > key; k--) keys[k] = keys[k - 1];
        keys[k] = key;
    }
}

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

/* Of those from `from` on, the first whose key is not smaller. */
static size_t first_from(const daft_sim_listing *listing, size_t from, uint64_t key)
{
    size_t end = listing->count;
    while (from < end) {
        size_t middle = from + (end - from) / 2;
        if (listing->items[middle].key >= key)
            end = middle;
        else
            from = middle + 1;
    }
    return from;
}

/* The i-th pair of every slice; the last slice may be shorter. */
static size_t in_slice(const near_pairs *n, uint32_t slice, size_t i) { return n->slice * slice + i; }

static void count_slices(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    near_pairs *n = context;
    const uint64_t *keys = n->world->candidates;
    uint32_t shift = 32 + n->low, first = index * SIDE_BY_SIDE;
    memset(n->next[first], 0, SIDE_BY_SIDE * sizeof *n->next);
    for (size_t i = 0; i < n->slice; i++)
        for (uint32_t slice = first; slice < first + SIDE_BY_SIDE; slice++) {
            size_t at = in_slice(n, slice, i);
            if (at < n->world->candidate_count) n->next[slice][keys[at] >> shift]++;
        }
}

static void scatter_slices(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    near_pairs *n = context;
    const uint64_t *keys = n->world->candidates;
    uint32_t shift = 32 + n->low, first = index * SIDE_BY_SIDE;
    for (size_t i = 0; i < n->slice; i++)
        for (uint32_t slice = first; slice < first + SIDE_BY_SIDE; slice++) {
            size_t at = in_slice(n, slice, i);
            if (at < n->world->candidate_count) n->world->ordered[n->next[slice][keys[at] >> shift]++] = keys[at];
        }
}

/* Puts near pairs into buckets, which stand in `ordered`. */
static void part_near(near_pairs *n)
{
    const daft_world *world = n->world;
    uint32_t sum = 0;
    size_t listed = 0;
    daft_sim_for(world, n->wide, SLICES / SIDE_BY_SIDE, count_slices, n);
    for (uint32_t i = 0; i < n->count; i++) {
        uint64_t after = (uint64_t)(i + 1) << (32 + n->low);
        size_t end = i + 1 < n->count ? first_from(&world->listed, listed, after) : world->listed.count;
        n->buckets[i] = (struct bucket){.first = sum, .listed = listed, .listed_count = end - listed};
        for (uint32_t slice = 0; slice < SLICES; slice++) {
            uint32_t here = n->next[slice][i];
            n->next[slice][i] = sum;
            sum += here;
        }
        n->buckets[i].count = sum - n->buckets[i].first;
        listed = end;
    }
    daft_sim_for(world, n->wide, SLICES / SIDE_BY_SIDE, scatter_slices, n);
}

/* What is listed and near is kept, at the bucket's begin; what is not goes to `merged`. Near pairs that are not listed are left
 * in `candidates`, at the bucket's begin. */
static void compare_near(near_pairs *n, struct bucket *bucket, const uint64_t *near)
{
    const daft_world *world = n->world;
    daft_sim_listed *listed = world->listed.items, *lost = world->merged.items;
    uint64_t *fresh = world->candidates;
    size_t k = 0, count = bucket->count, from = bucket->listed, first = bucket->first;
    for (size_t i = 0; i < bucket->listed_count; i++) {
        daft_sim_listed entry = listed[from + i];
        for (; k < count && near[k] < entry.key; k++) fresh[first + bucket->fresh++] = near[k];
        if (k < count && near[k] == entry.key) {
            listed[from + bucket->kept++] = entry;
            k++;
        } else {
            lost[from + bucket->lost++] = entry;
        }
    }
    for (; k < count; k++) fresh[first + bucket->fresh++] = near[k];
}

static void order_bucket(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    near_pairs *n = context;
    struct bucket *bucket = &n->buckets[index];
    if (bucket->count == 0) { /* there may be no memory to point to */
        compare_near(n, bucket, NULL);
        return;
    }
    uint64_t *keys = n->world->ordered + bucket->first, *other = n->world->candidates + bucket->first;
    if (bucket->count <= FEW) {
        sort_few(keys, bucket->count);
    } else {
        uint64_t *by_b = sort_by_bits(keys, other, bucket->count, 0, n->bits);
        keys = sort_by_bits(by_b, by_b == keys ? other : keys, bucket->count, 32, n->low);
    }
    compare_near(n, bucket, keys);
}

/* A touch of two that rest is no longer listed, and stays. */
static void lose(daft_world *world, const daft_sim_listed *entry)
{
    if (world->slots[entry->key >> 32] != DAFT_SIM_NONE || world->slots[(uint32_t)entry->key] != DAFT_SIM_NONE)
        daft_sim_touch_remove(world, entry->touch);
    else
        world->touches[entry->touch].listed = false;
}

/* Where it hangs in lists is on its way. */
DAFT_SIM_FETCH fetch_edges(const daft_world *world, uint32_t index)
{
    const daft_sim_touch *touch = &world->touches[index];
    for (int side = 0; side < 2; side++) {
        if (touch->next[side] != DAFT_SIM_NONE) __builtin_prefetch(world->touches[touch->next[side] >> 1].previous, 1);
        if (touch->previous[side] != DAFT_SIM_NONE) __builtin_prefetch(world->touches[touch->previous[side] >> 1].next, 1);
    }
}

enum { AHEAD = 4 };

/* What was lost goes, in the order of keys. */
static void lose_all(const near_pairs *n)
{
    daft_world *world = n->world;
    for (uint32_t i = 0; i < n->count; i++) {
        const struct bucket *b = &n->buckets[i];
        for (uint32_t k = 0; k < b->lost; k++) {
            const daft_sim_listed *entry = &world->merged.items[b->listed + k];
            if (k + 2 * AHEAD < b->lost) {
                __builtin_prefetch(&world->touches[entry[2 * AHEAD].touch], 1);
                __builtin_prefetch(world->touches[entry[2 * AHEAD].touch].next);
            }
            if (k + AHEAD < b->lost) fetch_edges(world, entry[AHEAD].touch);
            lose(world, entry);
        }
    }
}

/* Fresh pairs of all buckets stand in a row. */
static void gather_fresh(const near_pairs *n)
{
    daft_world *world = n->world;
    size_t fresh = 0;
    for (uint32_t i = 0; i < n->count; i++) {
        const struct bucket *b = &n->buckets[i];
        if (b->fresh > 0) memmove(world->candidates + fresh, world->candidates + b->first, b->fresh * sizeof *world->candidates);
        fresh += b->fresh;
    }
    world->candidate_count = fresh;
}

/* So does what is kept of the listing. */
static void gather_kept(const near_pairs *n)
{
    daft_sim_listing *listed = &n->world->listed;
    size_t kept = 0;
    for (uint32_t i = 0; i < n->count; i++) {
        const struct bucket *b = &n->buckets[i];
        if (b->kept > 0 && kept != b->listed) memmove(listed->items + kept, listed->items + b->listed, b->kept * sizeof *listed->items);
        kept += b->kept;
    }
    listed->count = kept;
}

/* What is listed and not near goes; of what is near and not listed the keys are left in candidates, in order. What is kept of the
 * listing stands in its buckets. */
static bool compare_all(daft_world *world, near_pairs *n)
{
    size_t count = world->candidate_count;
    if (!daft_grow(&world->allocator, &world->ordered, &world->ordered_capacity, count, 0, sizeof *world->ordered) ||
        !daft_grow(&world->allocator, &world->merged.items, &world->merged.capacity, world->listed.count, 0,
                   sizeof *world->merged.items))
        return false;
    uint32_t halvings = 0;
    n->world = world, n->wide = count >= PARALLEL_NEAR, n->slice = (count + SLICES - 1) / SLICES, n->bits = 1, n->count = 1;
    while (n->bits < 32 && world->part_count >> n->bits) n->bits++;
    for (; halvings < n->bits && n->count < BUCKETS && n->count * BUCKET < count; halvings++) n->count *= 2;
    n->low = n->bits - halvings;
    part_near(n);
    daft_sim_for(world, n->wide, n->count, order_bucket, n);
    lose_all(n);
    gather_fresh(n);
    return true;
}

/* What stands in a body that sleeps wakes it. */
static void wake_inside(daft_world *world, const daft_sim_touch *touch)
{
    const daft_sim_body *a = &world->bodies[touch->body_a];
    if (touch->sensor || !a->asleep || !daft_sim_overlap(&world->tight[touch->part_a], &world->tight[touch->part_b]))
        return;
    if (world->bodies[touch->body_b].kind != DAFT_BODY_DYNAMIC) daft_sim_wake(world, touch->body_a);
}

/* What a new touch is made from is on its way, */
DAFT_SIM_FETCH fetch_parts(const daft_world *world, uint64_t key)
{
    __builtin_prefetch(&world->parts[key >> 32], 1);
    __builtin_prefetch(&world->parts[(uint32_t)key], 1);
}

/* then the bodies, */
DAFT_SIM_FETCH fetch_bodies(const daft_world *world, uint64_t key)
{
    __builtin_prefetch(&world->bodies[world->parts[key >> 32].body], 1);
    __builtin_prefetch(&world->bodies[world->parts[(uint32_t)key].body], 1);
}

/* and their lists, which it joins. */
DAFT_SIM_FETCH fetch_lists(const daft_world *world, uint64_t key)
{
    const uint32_t parts[2] = {(uint32_t)(key >> 32), (uint32_t)key};
    for (int i = 0; i < 2; i++) {
        uint32_t first = world->bodies[world->parts[parts[i]].body].first_touch;
        if (first != DAFT_SIM_NONE) __builtin_prefetch(world->touches[first >> 1].previous, 1);
    }
}

/* The slot of the next one. */
DAFT_SIM_FETCH fetch_free(const daft_world *world)
{
    if (world->free_touch == DAFT_SIM_NONE) return;
    const char *touch = (const char *)&world->touches[world->free_touch];
    for (size_t at = 0; at < sizeof(daft_sim_touch); at += 64) __builtin_prefetch(touch + at, 1);
}

static bool is_owner_full(const daft_world *world, uint32_t a, uint32_t b)
{
    return is_dynamic(world, a) && is_dynamic(world, b) &&
           world->parts[owns(world, a, b) ? a : b].owned >= DAFT_SIM_MAX_PARTNERS;
}

/* Touches of near pairs that have none, but for those that a joint bars: they are remembered while they are near. */
static void make_touches(daft_world *world)
{
    size_t barred = 0, at = 0;
    for (size_t i = 0; i < world->candidate_count; i++) {
        uint64_t key = world->candidates[i];
        uint32_t a = (uint32_t)(key >> 32), b = (uint32_t)key;
        while (at < world->barred_count && world->barred[at] < key) at++;
        if (at < world->barred_count && world->barred[at] == key) {
            world->fresh_barred[barred++] = key;
            continue;
        }
        if (i + 3 * AHEAD < world->candidate_count) fetch_parts(world, world->candidates[i + 3 * AHEAD]);
        if (i + 2 * AHEAD < world->candidate_count) fetch_bodies(world, world->candidates[i + 2 * AHEAD]);
        if (i + AHEAD < world->candidate_count) fetch_lists(world, world->candidates[i + AHEAD]);
        if (!daft_sim_may_meet(world, a, b)) {
            world->fresh_barred[barred++] = key;
            continue;
        }
        if (is_owner_full(world, a, b)) continue;
        uint32_t touch = insert(world, a, b);
        fetch_free(world);
        wake_inside(world, &world->touches[touch]);
    }
    uint64_t *swap = world->barred;
    size_t capacity = world->barred_capacity;
    world->barred = world->fresh_barred, world->barred_capacity = world->fresh_barred_capacity;
    world->fresh_barred = swap, world->fresh_barred_capacity = capacity;
    world->barred_count = barred;
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

/* A list without items may have no memory to point to. */
static void append(daft_sim_listing *to, const daft_sim_listed *items, size_t first, size_t count)
{
    if (count > 0) memcpy(to->items + to->count, items + first, count * sizeof *items);
    to->count += count;
}

bool daft_sim_listing_update(daft_world *world)
{
    daft_sim_listing *old = &world->listed, *fresh = &world->fresh_listed, *merged = &world->merged;
    if (fresh->count == 0) return true;
    if (!daft_grow(&world->allocator, &merged->items, &merged->capacity, old->count + fresh->count, 0,
                   sizeof *merged->items))
        return false;
    daft_sim_listed_sort(fresh->items, fresh->count, merged->items);
    size_t from = 0;
    merged->count = 0;
    for (size_t k = 0; k < fresh->count; k++) {
        size_t to = first_from(old, from, fresh->items[k].key + 1);
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

/* ---- both ---- */

/* What is kept of a bucket, and what is fresh of it, go to the new listing. */
static void merge_bucket(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const near_pairs *n = context;
    const struct bucket *b = &n->buckets[index];
    const daft_world *world = n->world;
    const daft_sim_listing kept = {.items = world->listed.items, .count = b->listed + b->kept};
    daft_sim_listing to = {.items = world->merged.items, .count = b->merged};
    size_t from = b->listed;
    for (size_t k = b->entered; k < b->entered_end; k++) {
        size_t end = first_from(&kept, from, world->fresh_listed.items[k].key);
        append(&to, kept.items, from, end - from);
        append(&to, world->fresh_listed.items, k, 1);
        from = end;
    }
    append(&to, kept.items, from, kept.count - from);
}

/* There is room for as many touches as there are. */
static void merge_all(near_pairs *n)
{
    daft_world *world = n->world;
    size_t entered = 0, count = 0, lost = 0;
    for (uint32_t i = 0; i < n->count; i++) lost += n->buckets[i].lost;
    if (lost + world->fresh_listed.count == 0) return;
    for (uint32_t i = 0; i < n->count; i++) {
        struct bucket *b = &n->buckets[i];
        uint64_t after = (uint64_t)(i + 1) << (32 + n->low);
        b->merged = count, b->entered = entered;
        entered = i + 1 < n->count ? first_from(&world->fresh_listed, entered, after) : world->fresh_listed.count;
        b->entered_end = entered;
        count += b->kept + (entered - b->entered);
    }
    daft_sim_for(world, n->wide, n->count, merge_bucket, n);
    daft_sim_listing swap = world->listed;
    world->listed = world->merged, world->listed.count = count;
    world->merged = swap;
    world->fresh_listed.count = 0;
}

bool daft_sim_pairs_find(daft_world *world)
{
    near_pairs n;
    if (!daft_sim_listing_update(world) || !daft_sim_groups_search(world) || !compare_all(world, &n)) return false;
    if (!daft_sim_pairs_reserve(world, world->candidate_count) ||
        !daft_grow(&world->allocator, &world->fresh_barred, &world->fresh_barred_capacity, world->candidate_count, 0,
                   sizeof *world->fresh_barred)) {
        gather_kept(&n);
        return false;
    }
    make_touches(world);
    forget_moved(world);
    size_t fresh = world->fresh_listed.count;
    if (fresh == 0 || run_end(world->fresh_listed.items, 0, fresh) == fresh) {
        merge_all(&n);
        return true;
    }
    gather_kept(&n); /* some woke, whose touches are listed in another order */
    return daft_sim_listing_update(world);
}
