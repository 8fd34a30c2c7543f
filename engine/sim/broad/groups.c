/* Groups of what moves, and near pairs of parts: those whose bounds over the step meet, of which one at least moves or
 * was placed since the last step. Parts are put together by halving them along the widest axis, again and again; those
 * that join later stand at the end, and where too many did, or groups have grown, all are put together anew.
 *
 * Where there are so many that each part has dozens, as of thousands of bodies in one spot, all is searched again: a
 * pair is then found by the smaller of the two, which keeps those of lowest index, and no more than may be its own.
 * What rests is asked for in the trees, by a group's bounds. */
#include "sim/broad/groups.h"
#include "sim/broad/broad.h"

#include <float.h>
#include <stdatomic.h>
#include <string.h>

static const daft_sim_group_kernels *kernels_of(const daft_world *world)
{
    static const daft_sim_group_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_sim_group);
    return TABLE[world->isa];
}

/* ---- bounds ---- */

/* Rounding to float, and a little more. */
#define OUTWARDS 0x1p-22f
#define LEAST    0x1p-100f

static float below(double x)
{
    float f = (float)x;
    return f - (fabsf(f) * OUTWARDS + LEAST);
}
static float above(double x) { return -below(-x); }

/* Bounds as groups have them. */
static void group_box(const daft_world *world, const daft_sim_bounds *bounds, float low[3], float high[3])
{
    daft_dvec3 a = daft_dsub(bounds->low, world->group_origin), b = daft_dsub(bounds->high, world->group_origin);
    low[0] = below(a.x), low[1] = below(a.y), low[2] = below(a.z);
    high[0] = above(b.x), high[1] = above(b.y), high[2] = above(b.z);
}

static daft_sim_bounds group_bounds(const daft_world *world, const daft_sim_group *group)
{
    const float *a = group->low, *b = group->high;
    daft_dvec3 o = world->group_origin;
    daft_dvec3 low = daft_dv3((double)below((double)a[0]), (double)below((double)a[1]), (double)below((double)a[2]));
    daft_dvec3 high = daft_dv3((double)above((double)b[0]), (double)above((double)b[1]), (double)above((double)b[2]));
    return (daft_sim_bounds){daft_dadd(o, low), daft_dadd(o, high)};
}

static void clear_lane(daft_sim_group *group, uint32_t lane)
{
    for (int axis = 0; axis < 3; axis++)
        group->boxes.low[axis][lane] = INFINITY, group->boxes.high[axis][lane] = -INFINITY;
    group->part[lane] = DAFT_SIM_NONE;
    group->used &= ~(1u << lane);
}

/* ---- who is in which ---- */

static uint32_t class_of(const daft_world *world, const daft_sim_part *part)
{
    daft_body_kind kind = world->bodies[part->body].kind;
    uint32_t class = part->sensor ? DAFT_SIM_SENSES : 0;
    return class | (kind == DAFT_BODY_STATIC ? DAFT_SIM_STANDS : kind == DAFT_BODY_DYNAMIC ? DAFT_SIM_YIELDS : 0);
}

static void take_slot(daft_world *world, uint32_t slot, uint32_t index)
{
    daft_sim_group *group = &world->groups[slot / DAFT_SIM_GROUP];
    uint32_t lane = slot % DAFT_SIM_GROUP;
    const daft_sim_part *part = &world->parts[index];
    uint32_t class = class_of(world, part);
    if (lane == 0) {
        *group = (daft_sim_group){0};
        for (uint32_t i = 0; i < DAFT_SIM_GROUP; i++) clear_lane(group, i);
    }
    group->part[lane] = index, group->body[lane] = part->body;
    group->layers[lane] = part->layers, group->mask[lane] = part->mask, group->class[lane] = class;
    group->reach[lane] = class & DAFT_SIM_YIELDS ? part->reach : class == DAFT_SIM_STANDS ? INFINITY : FLT_MAX;
    group->joined[lane] = world->bodies[part->body].joined;
    group->used |= 1u << lane;
    world->slots[index] = slot;
}

void daft_sim_groups_joined(daft_world *world, uint32_t body)
{
    for (uint32_t p = world->bodies[body].first_part; p != DAFT_SIM_NONE; p = world->parts[p].next) {
        uint32_t slot = world->slots[p];
        if (slot != DAFT_SIM_NONE)
            world->groups[slot / DAFT_SIM_GROUP].joined[slot % DAFT_SIM_GROUP] = world->bodies[body].joined;
    }
}

void daft_sim_group_leave(daft_world *world, uint32_t part)
{
    uint32_t slot = world->slots[part];
    if (slot == DAFT_SIM_NONE) return;
    clear_lane(&world->groups[slot / DAFT_SIM_GROUP], slot % DAFT_SIM_GROUP);
    world->slots[part] = DAFT_SIM_NONE;
    if (--world->grouped == 0) world->slot_count = world->slots_late = 0;
}

typedef void part_visit(daft_world *world, uint32_t part, size_t *count);

static void count_new(daft_world *world, uint32_t part, size_t *count)
{
    *count += world->slots[part] == DAFT_SIM_NONE;
}

static void join(daft_world *world, uint32_t part, size_t *count)
{
    (void)count;
    if (world->slots[part] != DAFT_SIM_NONE) return;
    take_slot(world, world->slot_count++, part);
    world->grouped++, world->slots_late++;
}

static void for_parts(daft_world *world, part_visit *visit, size_t *count)
{
    const daft_sim_list *lists[2] = {&world->awake, &world->movers};
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < lists[k]->count; i++)
            for (uint32_t p = world->bodies[lists[k]->items[i]].first_part; p != DAFT_SIM_NONE;
                 p = world->parts[p].next)
                visit(world, p, count);
    for (size_t i = 0; i < world->moved.count; i++) visit(world, world->moved.items[i], count);
}

static size_t groups_of(size_t slots) { return (slots + DAFT_SIM_GROUP - 1) / DAFT_SIM_GROUP; }

bool daft_sim_groups_join(daft_world *world)
{
    const daft_allocator *a = &world->allocator;
    size_t more = 0, used = groups_of(world->slot_count);
    if (!world->newcomers) return true;
    for_parts(world, count_new, &more);
    size_t slots = world->slot_count + more, groups = groups_of(slots);
    if (!daft_grow(a, &world->groups, &world->group_capacity, groups, used, sizeof *world->groups) ||
        !daft_grow(a, &world->group_boxes, &world->group_box_capacity, groups_of(groups), 0,
                   sizeof *world->group_boxes) ||
        !daft_grow(a, &world->scratch.group_keys, &world->scratch.group_key_capacity, slots, 0,
                   sizeof *world->scratch.group_keys))
        return false;
    for_parts(world, join, NULL);
    world->newcomers = false;
    return true;
}

/* ---- putting them together ---- */

/* Halves, on whole groups, all the way down. */
static void halve(daft_sim_key *keys, uint32_t count)
{
    while (count > DAFT_SIM_GROUP) {
        uint32_t half = (uint32_t)groups_of(count) / 2 * DAFT_SIM_GROUP;
        daft_sim_keys_part(keys, count, half);
        halve(keys, half);
        keys += half, count -= half;
    }
}

static void put_together(daft_world *world)
{
    uint32_t count = 0;
    for (uint32_t slot = 0; slot < world->slot_count; slot++) {
        uint32_t part = world->groups[slot / DAFT_SIM_GROUP].part[slot % DAFT_SIM_GROUP];
        if (part == DAFT_SIM_NONE) continue;
        const daft_sim_bounds *b = &world->tight[part];
        if (count == 0) world->group_origin = b->low;
        daft_dvec3 m = daft_dsub(daft_dadd(b->low, b->high), daft_dscale(world->group_origin, 2));
        world->scratch.group_keys[count++] = (daft_sim_key){{(float)m.x, (float)m.y, (float)m.z}, part};
    }
    halve(world->scratch.group_keys, count);
    for (uint32_t i = 0; i < count; i++) take_slot(world, i, world->scratch.group_keys[i].leaf);
    world->slot_count = count;
    world->slots_late = 0;
    world->group_size = 0;
}

static void fit_group(const daft_world *world, daft_sim_group *group)
{
    float *low = group->low, *high = group->high;
    for (int axis = 0; axis < 3; axis++) low[axis] = INFINITY, high[axis] = -INFINITY;
    for (uint32_t lanes = group->used; lanes; lanes &= lanes - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(lanes);
        float a[3], b[3];
        group_box(world, &world->tight[group->part[lane]], a, b);
        for (int axis = 0; axis < 3; axis++) {
            group->boxes.low[axis][lane] = a[axis], group->boxes.high[axis][lane] = b[axis];
            low[axis] = daft_sim_min(low[axis], a[axis]), high[axis] = daft_sim_max(high[axis], b[axis]);
        }
    }
}

enum { FIT_GRAIN = 8, SEARCH_GRAIN = 4, PARALLEL_GROUPS = 16 };

static void fit_range(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    daft_world *world = context;
    uint32_t first = index * FIT_GRAIN, end = daft_min_u(first + FIT_GRAIN, (uint32_t)groups_of(world->slot_count));
    for (uint32_t i = first; i < end; i++) fit_group(world, &world->groups[i]);
}

static void for_groups(daft_world *world, uint32_t grain, daft_task *task, void *context)
{
    uint32_t count = (uint32_t)groups_of(world->slot_count);
    daft_sim_for(world, count >= PARALLEL_GROUPS, (count + grain - 1) / grain, task, context);
}

/* How large groups may become, as a fraction of what they were when they were put together, and how many slots in them
 * may be taken late, or be empty. */
#define GROWN 1.25
#define LATE  4

/* The bounds of groups side by side. Gives the sum of their sizes. */
static double fit_boxes(daft_world *world)
{
    double size = 0;
    uint32_t count = (uint32_t)groups_of(world->slot_count), lanes = (uint32_t)groups_of(count) * DAFT_SIM_GROUP;
    for (uint32_t i = 0; i < lanes; i++) {
        daft_sim_boxes *boxes = &world->group_boxes[i / DAFT_SIM_GROUP];
        const daft_sim_group *group = i < count ? &world->groups[i] : NULL;
        for (int axis = 0; axis < 3; axis++) {
            boxes->low[axis][i % DAFT_SIM_GROUP] = group ? group->low[axis] : INFINITY;
            boxes->high[axis][i % DAFT_SIM_GROUP] = group ? group->high[axis] : -INFINITY;
            if (group && group->used) size += (double)group->high[axis] - (double)group->low[axis];
        }
    }
    return size;
}

void daft_sim_groups_fit(daft_world *world)
{
    if (world->grouped == 0) return;
    if (LATE * (world->slot_count - world->grouped) > world->slot_count ||
        LATE * world->slots_late > world->slot_count || world->group_size < 0)
        put_together(world);
    for_groups(world, FIT_GRAIN, fit_range, world);
    double size = fit_boxes(world);
    if (world->group_size == 0) world->group_size = size;
    if (size > GROWN * world->group_size) world->group_size = -1; /* the next time */
}

/* ---- near pairs ---- */

enum { BATCH = 2 * DAFT_SIM_GROUP * DAFT_SIM_GROUP };

/* Near pairs of a part, on average, from which on they are found by size. */
#define CROWDED 64

typedef struct found_pairs {
    daft_world *world;
    size_t most; /* no more than so many are wanted */
    bool by_size;
    atomic_size_t count; /* perhaps more than there is room for */
} found_pairs;

typedef struct search {
    const daft_world *world;
    found_pairs *found;
    const daft_sim_group *group;
    uint64_t batch[BATCH];
    uint32_t batched;
    uint32_t partner_counts[DAFT_SIM_GROUP];
    uint32_t partners[DAFT_SIM_GROUP][DAFT_SIM_MAX_PARTNERS]; /* that a row's part will own: those of lowest index */
} search;

static void hand_over(search *s)
{
    daft_world *world = s->found->world;
    size_t at = atomic_fetch_add_explicit(&s->found->count, s->batched, memory_order_relaxed);
    if (s->batched && at + s->batched <= world->scratch.candidate_capacity)
        memcpy(world->scratch.candidates + at, s->batch, s->batched * sizeof *s->batch);
    s->batched = 0;
}

/* A dynamic one first, the sensor first, else the lower index. */
static uint64_t key_of(uint32_t a, uint32_t class_a, uint32_t b, uint32_t class_b)
{
    bool yields_a = class_a & DAFT_SIM_YIELDS, yields_b = class_b & DAFT_SIM_YIELDS;
    bool sensor = (class_a | class_b) & DAFT_SIM_SENSES, senses_b = class_b & DAFT_SIM_SENSES;
    bool swap = sensor ? senses_b : yields_a == yields_b ? b < a : yields_b;
    uint64_t first = swap ? b : a, second = swap ? a : b;
    return first << 32 | second;
}

static void add_pair(search *s, uint32_t a, uint32_t class_a, uint32_t b, uint32_t class_b)
{
    s->batch[s->batched++] = key_of(a, class_a, b, class_b);
    if (s->batched == BATCH) hand_over(s);
}

/* In any order; where there are too many, in place of the one of highest index. */
static void keep_partner(search *s, uint32_t row, uint32_t other)
{
    uint32_t *partners = s->partners[row], most = 0;
    if (s->partner_counts[row] < DAFT_SIM_MAX_PARTNERS) {
        partners[s->partner_counts[row]++] = other;
        return;
    }
    for (uint32_t i = 1; i < DAFT_SIM_MAX_PARTNERS; i++)
        if (partners[i] > partners[most]) most = i;
    if (other < partners[most]) partners[most] = other;
}

/* What daft_sim_may_meet says, but for joints of bodies that are far from each other in their list. */
static bool may_meet(uint32_t class_a, uint32_t class_b)
{
    uint32_t any = class_a | class_b, both = class_a & class_b;
    return any & DAFT_SIM_SENSES ? !(both & (DAFT_SIM_SENSES | DAFT_SIM_STANDS)) : any & DAFT_SIM_YIELDS;
}

/* Without branches, as in daft_sim_overlap. */
static bool is_pair(const search *s, const daft_sim_group *other, uint32_t row, uint32_t lane)
{
    const daft_sim_group *g = s->group;
    const daft_sim_bounds *tight = s->world->tight;
    uint32_t a = g->body[row], b = other->body[lane], places = (a < b ? b - a : a - b) - 1;
    uint64_t joined = a < b ? g->joined[row] : other->joined[lane];
    bool senses = (g->class[row] | other->class[lane]) & DAFT_SIM_SENSES, meet = a != b;
    meet &= senses | (places >= DAFT_SIM_JOINED_PLACES) | !(joined >> (places & (DAFT_SIM_JOINED_PLACES - 1)) & 1);
    meet &= (g->layers[row] & other->mask[lane]) != 0;
    meet &= (other->layers[lane] & g->mask[row]) != 0;
    meet &= may_meet(g->class[row], other -> class[lane]);
    return meet & daft_sim_overlap(&tight[g->part[row]], &tight[other->part[lane]]);
}

static void take_hits(search *s, const daft_sim_group *other, const uint32_t *crossings, uint32_t count)
{
    const daft_sim_group *g = s->group;
    uint32_t batched = s->batched;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t row = crossings[i] / DAFT_SIM_GROUP, lane = crossings[i] % DAFT_SIM_GROUP;
        s->batch[batched] = key_of(g->part[row], g->class[row], other -> part[lane], other -> class[lane]);
        batched += is_pair(s, other, row, lane);
    }
    s->batched = batched;
}

static void take_hits_by_size(search *s, const daft_sim_group *other, const uint32_t *crossings, uint32_t count)
{
    const daft_sim_group *g = s->group;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t row = crossings[i] / DAFT_SIM_GROUP, lane = crossings[i] % DAFT_SIM_GROUP;
        if (!is_pair(s, other, row, lane)) continue;
        if (g->class[row] & other -> class[lane] & DAFT_SIM_YIELDS)
            keep_partner(s, row, other->part[lane]);
        else
            add_pair(s, g->part[row], g->class[row], other -> part[lane], other -> class[lane]);
    }
}

/* What rests and is in no group. */
static void visit_resting(void *context, uint32_t index)
{
    search *s = context;
    const daft_world *world = s->world;
    const daft_sim_group *g = s->group;
    if (world->slots[index] != DAFT_SIM_NONE) return;
    const daft_sim_part *part = &world->parts[index];
    float low[3], high[3];
    group_box(world, &world->tight[index], low, high);
    uint32_t rows = kernels_of(world)->meets(&g->boxes, low, high), class = class_of(world, part);
    for (; rows; rows &= rows - 1) {
        uint32_t row = (uint32_t)__builtin_ctz(rows);
        if (g->body[row] != part->body && g->layers[row] & part->mask && part->layers & g->mask[row] &&
            may_meet(g->class[row], class) && daft_sim_overlap(&world->tight[g->part[row]], &world->tight[index]))
            add_pair(s, g->part[row], g->class[row], index, class);
    }
}

static void search_among(search *s, uint32_t index, uint32_t other)
{
    uint32_t crossings[DAFT_SIM_CROSSINGS];
    if (!s->found->by_size && other < index) return; /* found from there */
    const daft_sim_group *group = &s->world->groups[other];
    uint32_t count = kernels_of(s->world)->cross(s->group, group, s->found->by_size, crossings);
    if (s->batched + count >= BATCH) hand_over(s);
    (s->found->by_size ? take_hits_by_size : take_hits)(s, group, crossings, count);
}

static void search_moving(search *s, uint32_t index)
{
    const daft_world *world = s->world;
    const daft_sim_group_kernels *kernels = kernels_of(world);
    uint32_t block = s->found->by_size ? 0 : index / DAFT_SIM_GROUP,
             blocks = (uint32_t)groups_of(groups_of(world->slot_count));
    for (; block < blocks && atomic_load_explicit(&s->found->count, memory_order_relaxed) <= s->found->most; block++)
        for (uint32_t near = kernels->meets(&world->group_boxes[block], s->group->low, s->group->high); near;
             near &= near - 1)
            search_among(s, index, block * DAFT_SIM_GROUP + (uint32_t)__builtin_ctz(near));
    for (uint32_t row = 0; row < DAFT_SIM_GROUP && s->found->by_size; row++) {
        for (uint32_t i = 0; i < s->partner_counts[row]; i++)
            add_pair(s, s->group->part[row], DAFT_SIM_YIELDS, s->partners[row][i], DAFT_SIM_YIELDS);
        s->partner_counts[row] = 0;
    }
}

static void search_group(search *s, uint32_t index)
{
    const daft_world *world = s->world;
    s->group = &world->groups[index];
    if (s->group->used == 0) return;
    daft_sim_bounds bounds = group_bounds(world, s->group);
    search_moving(s, index);
    daft_sim_tree_query(&world->trees[DAFT_BODY_STATIC], &bounds, visit_resting, s);
    daft_sim_tree_query(&world->trees[DAFT_BODY_KINEMATIC], &bounds, visit_resting, s);
    if (world->asleep_count > 0) daft_sim_tree_query(&world->trees[DAFT_BODY_DYNAMIC], &bounds, visit_resting, s);
}

static void search_range(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    found_pairs *found = context;
    search s;
    s.world = found->world, s.found = found, s.batched = 0;
    memset(s.partner_counts, 0, sizeof s.partner_counts);
    uint32_t first = index * SEARCH_GRAIN;
    uint32_t end = daft_min_u(first + SEARCH_GRAIN, (uint32_t)groups_of(found->world->slot_count));
    for (uint32_t i = first; i < end; i++) search_group(&s, i);
    hand_over(&s);
}

/* Where room was short, all is searched again with enough. */
static bool search_all(daft_world *world, bool by_size, size_t most)
{
    for (size_t needed = 8 * (size_t)world->grouped;;) {
        if (!daft_grow(&world->allocator, &world->scratch.candidates, &world->scratch.candidate_capacity, needed, 0,
                       sizeof *world->scratch.candidates))
            return false;
        found_pairs found = {world, most, by_size, 0};
        for_groups(world, SEARCH_GRAIN, search_range, &found);
        needed = world->scratch.candidate_count = atomic_load_explicit(&found.count, memory_order_relaxed);
        if (needed <= world->scratch.candidate_capacity || needed > most) return true;
    }
}

bool daft_sim_groups_search(daft_world *world)
{
    size_t most = CROWDED * (size_t)world->grouped;
    return search_all(world, false, most) &&
           (world->scratch.candidate_count <= most || search_all(world, true, SIZE_MAX));
}
