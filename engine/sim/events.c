/* What a step tells: contacts, and events in a fixed order. Calls between steps add to a list of their own, which the
 * next step delivers with its own. */
#include "sim/world.h"
#include "sim/contact/contact.h"
#include "sim/events.h"

#include <stdlib.h>
#include <string.h>

/* ---- pending events ---- */

static void add_event(daft_world *world, const daft_sim_event *event)
{
    daft_sim_event_list *list = &world->pending;
    if (!daft_grow(&world->allocator, &list->items, &list->capacity, list->count + 1, list->count,
                   sizeof *list->items)) {
        world->lost_event = true;
        return;
    }
    list->items[list->count++] = *event;
}

/* The pair as users see it: lower body first; a sensor first. */
static daft_sim_event pair_event(const daft_world *world, const daft_sim_pair *pair, daft_sim_event_kind kind,
                                 bool *swapped)
{
    bool swap = pair->sensor ? world->parts[pair->part_b].sensor : pair->body_b < pair->body_a;
    uint32_t a = swap ? pair->part_b : pair->part_a, b = swap ? pair->part_a : pair->part_b;
    uint32_t body_a = world->parts[a].body, body_b = world->parts[b].body;
    *swapped = swap;
    return (daft_sim_event){.kind = kind,
                            .body_a = body_a + 1,
                            .body_b = body_b + 1,
                            .user_a = world->bodies[body_a].user,
                            .user_b = world->bodies[body_b].user,
                            .shape_user_a = world->parts[a].user,
                            .shape_user_b = world->parts[b].user};
}

void daft_sim_event_joint(daft_world *world, daft_sim_event_kind kind, uint32_t joint_index, float value)
{
    const daft_sim_joint *joint = &world->joints[joint_index];
    daft_sim_event event = {.kind = kind,
                            .joint = joint_index + 1,
                            .joint_user = joint->user,
                            .body_a = joint->body[0] + 1,
                            .body_b = joint->body[1] + 1,
                            .impulse = value};
    if (joint->body[0] != DAFT_SIM_NONE) event.user_a = world->bodies[joint->body[0]].user;
    if (joint->body[1] != DAFT_SIM_NONE) event.user_b = world->bodies[joint->body[1]].user;
    add_event(world, &event);
}

void daft_sim_event_sleep(daft_world *world, daft_sim_event_kind kind, uint32_t body)
{
    daft_sim_event event = {.kind = kind, .body_a = body + 1, .user_a = world->bodies[body].user};
    add_event(world, &event);
}

/* ---- the report ---- */

static daft_dvec3 contact_point(const daft_world *world, const daft_sim_pair *pair, const daft_sim_manifold *manifold,
                                uint32_t point)
{
    return daft_dadd(world->bodies[pair->body_a].centre, daft_to_double(manifold->points[point].anchor));
}

static void fill_contact(const daft_world *world, daft_sim_pair *pair, daft_sim_contact *out)
{
    bool swapped;
    daft_sim_event e = pair_event(world, pair, DAFT_SIM_CONTACT_BEGIN, &swapped);
    *out = (daft_sim_contact){.body_a = e.body_a,
                              .body_b = e.body_b,
                              .user_a = e.user_a,
                              .user_b = e.user_b,
                              .shape_user_a = e.shape_user_a,
                              .shape_user_b = e.shape_user_b};
    const daft_sim_manifold *manifolds = daft_sim_manifolds(pair);
    float most = -1;
    for (uint32_t i = 0; i < pair->manifold_count; i++) {
        const daft_sim_manifold *manifold = &manifolds[i];
        out->impulse += manifold->total_impulse;
        if (manifold->total_impulse <= most) continue;
        most = manifold->total_impulse;
        uint32_t best = 0;
        for (uint32_t k = 1; k < manifold->count; k++)
            if (manifold->points[k].impulse > manifold->points[best].impulse) best = k;
        out->point = contact_point(world, pair, manifold, best);
        out->normal = swapped ? daft_neg(manifold->normal) : manifold->normal;
    }
}

/* After the step, along the normal, to first order. */
static bool is_closed(daft_sim_pair *pair, float slack)
{
    const daft_sim_manifold *manifolds = daft_sim_manifolds(pair);
    for (uint32_t i = 0; i < pair->manifold_count; i++) {
        if (manifolds[i].total_impulse > 0) return true;
        for (uint32_t k = 0; k < manifolds[i].count; k++)
            if (manifolds[i].points[k].separation <= slack) return true;
    }
    return false;
}

/* A contact ends when the parts are this far apart, so that resting on edge does not flicker. */
#define END_SLACK 1e-3f /* m */

static daft_sim_event end_event(const daft_world *world, const daft_sim_pair *pair)
{
    bool swapped;
    return pair_event(world, pair, pair->sensor ? DAFT_SIM_TRIGGER_LEAVE : DAFT_SIM_CONTACT_END, &swapped);
}

void daft_sim_event_end(daft_world *world, const daft_sim_pair *pair)
{
    daft_sim_event event = end_event(world, pair);
    add_event(world, &event);
}

static daft_sim_event change_event(const daft_world *world, daft_sim_pair *pair)
{
    if (!pair->touching) return end_event(world, pair);
    bool swapped;
    daft_sim_event event =
        pair_event(world, pair, pair->sensor ? DAFT_SIM_TRIGGER_ENTER : DAFT_SIM_CONTACT_BEGIN, &swapped);
    if (!pair->sensor) {
        daft_sim_contact contact;
        fill_contact(world, pair, &contact);
        event.point = contact.point, event.normal = contact.normal, event.impulse = contact.impulse;
        const daft_sim_manifold *manifolds = daft_sim_manifolds(pair);
        for (uint32_t i = 0; i < pair->manifold_count; i++) event.speed = daft_sim_max(event.speed, manifolds[i].speed);
    }
    return event;
}

bool daft_sim_report_reserve(daft_world *world)
{
    size_t pairs = world->live_pairs, events = world->pending.count + pairs + world->awake.count;
    events += 2 * (size_t)world->live_joints;
    /* What the sleeping ones touch is written only when that changes: it must survive the growth. */
    return daft_grow(&world->allocator, &world->report, &world->report_capacity, pairs, world->report_asleep,
                     sizeof *world->report) &&
           daft_grow(&world->allocator, &world->pending.items, &world->pending.capacity, events, world->pending.count,
                     sizeof *world->pending.items);
}

#define ORDER(x, y)                                                                                                    \
    if ((x) != (y)) return (x) < (y) ? -1 : 1

static int contact_order(const void *p, const void *q)
{
    const daft_sim_contact *a = p, *b = q;
    ORDER(a->body_a, b->body_a);
    ORDER(a->body_b, b->body_b);
    ORDER(a->shape_user_a, b->shape_user_a);
    ORDER(a->shape_user_b, b->shape_user_b);
    ORDER(a->point.x, b->point.x);
    ORDER(a->point.y, b->point.y);
    ORDER(a->point.z, b->point.z);
    return 0;
}

static int event_order(const void *p, const void *q)
{
    const daft_sim_event *a = p, *b = q;
    ORDER(a->kind, b->kind);
    ORDER(a->body_a, b->body_a);
    ORDER(a->body_b, b->body_b);
    ORDER(a->shape_user_a, b->shape_user_a);
    ORDER(a->shape_user_b, b->shape_user_b);
    ORDER(a->joint, b->joint);
    ORDER(a->point.x, b->point.x);
    ORDER(a->point.y, b->point.y);
    ORDER(a->point.z, b->point.z);
    return 0;
}

/* Their impulses are those of their last step awake. */
static void report_sleepers(daft_world *world)
{
    world->report_asleep = 0;
    for (uint32_t i = 0; i < world->pair_count; i++) {
        daft_sim_pair *pair = &world->pairs[i];
        if (pair->part_a == DAFT_SIM_NONE || pair->active || pair->sensor || !pair->touching) continue;
        fill_contact(world, pair, &world->report[world->report_asleep++]);
    }
    if (world->report_asleep > 1) qsort(world->report, world->report_asleep, sizeof *world->report, contact_order);
    world->sleep_changed = false;
}

/* Entries of what this step tells are flagged. */
static void judge(daft_world *world, daft_sim_active *entry)
{
    daft_sim_pair *pair = &world->pairs[entry->pair];
    bool was = pair->touching;
    pair->touching = pair->sensor ? pair->manifold_count > 0 : is_closed(pair, was ? END_SLACK : 0);
    if (pair->touching != was) entry->flags |= DAFT_SIM_CHANGED;
    if (pair->touching && !pair->sensor) entry->flags |= DAFT_SIM_REPORTED;
}

enum { GRAIN = 256, PARALLEL_PAIRS = 1024 };

static void judge_range(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    daft_world *world = context;
    size_t first = (size_t)index * GRAIN, end = first + GRAIN;
    if (end > world->active.count) end = world->active.count;
    for (size_t i = first; i < end; i++)
        if (world->active.items[i].flags & DAFT_SIM_OVERLAPS) judge(world, &world->active.items[i]);
}

/* Entries that are reported go to `sorting`, by bodies, the lower one first. */
static size_t order_report(daft_world *world)
{
    daft_sim_active *sorted = world->scratch.sorting.items;
    size_t count = 0;
    for (size_t i = 0; i < world->active.count; i++) {
        daft_sim_active entry = world->active.items[i];
        if (!(entry.flags & DAFT_SIM_REPORTED)) continue;
        uint64_t a = daft_min_u(entry.body_a, entry.body_b), b = daft_max_u(entry.body_a, entry.body_b);
        entry.key = a << 32 | b;
        sorted[count++] = entry;
    }
    daft_sim_active_sort(sorted, count, sorted + world->scratch.sorting.capacity / 2);
    return count;
}

/* Pairs of the same two bodies, few, by their shapes. */
static void order_same_bodies(daft_sim_contact *report, const daft_sim_active *keys, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        if (keys[i].key != keys[i - 1].key) continue;
        daft_sim_contact moved = report[i];
        size_t k = i;
        for (; k > 0 && keys[k - 1].key == keys[i].key && contact_order(&moved, &report[k - 1]) < 0; k--)
            report[k] = report[k - 1];
        report[k] = moved;
    }
}

void daft_sim_report(daft_world *world)
{
    size_t count = world->active.count;
    if (world->sleep_changed) report_sleepers(world);
    world->counters.contacts = 0;
    world->report_count = world->report_asleep;
    world->untold = true;
    daft_sim_for(world, count >= PARALLEL_PAIRS, (uint32_t)((count + GRAIN - 1) / GRAIN), judge_range, world);
    for (size_t i = 0; i < count; i++) {
        const daft_sim_active *entry = &world->active.items[i];
        world->counters.contacts += entry->manifolds > 0;
        if (entry->flags & DAFT_SIM_CHANGED)
            world->pending.items[world->pending.count++] = change_event(world, &world->pairs[entry->pair]);
    }
}

/* Contacts are told when somebody asks, or before what they are told from is changed. */
void daft_sim_report_fill(daft_world *world)
{
    if (!world->untold) return;
    world->untold = false;
    size_t count = order_report(world);
    if (count > 0) { /* else there may be no report at all */
        daft_sim_contact *report = world->report + world->report_asleep;
        for (size_t i = 0; i < count; i++)
            fill_contact(world, &world->pairs[world->scratch.sorting.items[i].pair], &report[i]);
        order_same_bodies(report, world->scratch.sorting.items, count);
    }
    world->report_count = world->report_asleep + count;
}

void daft_sim_report_forget(daft_world *world, uint32_t handle)
{
    size_t kept = 0, asleep = 0;
    for (size_t i = 0; i < world->report_count; i++)
        if (world->report[i].body_a != handle && world->report[i].body_b != handle) {
            asleep += i < world->report_asleep;
            world->report[kept++] = world->report[i];
        }
    world->report_count = kept;
    world->report_asleep = asleep;
}

/* What was pending becomes the step's events. */
void daft_sim_events_deliver(daft_world *world)
{
    daft_sim_event_list swap = world->events;
    world->events = world->pending;
    world->pending = swap;
    world->pending.count = 0;
    if (world->events.count > 1)
        qsort(world->events.items, world->events.count, sizeof *world->events.items, event_order);
}

uint32_t daft_world_contacts(daft_world *world, const daft_sim_contact **out)
{
    daft_sim_report_fill(world);
    *out = world->report;
    return (uint32_t)world->report_count;
}

uint32_t daft_world_events(const daft_world *world, const daft_sim_event **out)
{
    *out = world->events.items;
    return (uint32_t)world->events.count;
}
