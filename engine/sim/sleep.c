/* Who sleeps. Bodies that touch or are joined are an island; one whose bodies have all hardly moved for half a
 * second falls asleep as a whole: its bodies leave the lists that a step walks and go on a ring, on which they are
 * woken together. Islands are found by union-find over the active pairs, and only in steps in which some body has been
 * at rest for long enough. Bodies of infinite mass join no islands. */
#include "sim/world.h"
#include "sim/broad/broad.h"
#include "sim/contact/contact.h"
#include "sim/events.h"
#include "sim/sleep.h"

#include <stdatomic.h>

#define REST_SPEED 0.05f /* m/s of the fastest point; slower is at rest */
#define REST_TIME  0.5f  /* s */
/* What trembles in its place is at rest, too, as limbs do that are wedged under a body whose joints press them there:
 * faster than that, but nowhere farther than this from where it lately was. */
#define TREMBLE_SPEED        0.25f
#define TREMBLE_DISPLACEMENT 0.005f /* m, of any point; */
#define TREMBLE_FRACTION     0.04f  /* and of its extent */
/* Joints that brake bring what sways to rest, but not where a heavy body stands on light limbs: those bend by some
 * millimetres, and contacts that are found once a step feed as much as the brakes take, so that a doll that stands
 * astride sways for ever. What sways no farther than so many times as far as what trembles is at rest, too, if it
 * lasts; and time counts less. */
#define SWAY_DISPLACEMENT 3.0f
#define SWAY_COUNT        0.25f

/* ---- waking ---- */

/* Lists of bodies have room for all there are. */
static void wake_one(daft_world *world, uint32_t index)
{
    daft_sim_body *body = &world->bodies[index];
    body->asleep = false;
    world->asleep_count--;
    world->sleep_changed = true;
    body->ring = index;
    body->rest = 0;
    daft_sim_list_add(world, &world->awake, index);
    daft_sim_pairs_activate(world, index);
    daft_sim_event_sleep(world, DAFT_SIM_WAKE, index);
}

void daft_sim_wake(daft_world *world, uint32_t body_index)
{
    while (world->bodies[body_index].asleep) {
        uint32_t next = world->bodies[body_index].ring;
        wake_one(world, body_index);
        body_index = next;
    }
}

static uint32_t other_body(const daft_world *world, uint32_t edge)
{
    const daft_sim_pair *pair = &world->pairs[edge >> 1];
    return edge & 1 ? pair->body_a : pair->body_b;
}

void daft_sim_wake_neighbours(daft_world *world, uint32_t body_index)
{
    const daft_sim_body *body = &world->bodies[body_index];
    for (uint32_t e = body->first_pair; e != DAFT_SIM_NONE; e = world->pairs[e >> 1].next[e & 1]) {
        const daft_sim_pair *pair = &world->pairs[e >> 1];
        if (pair->manifold_count > 0 && !pair->sensor) daft_sim_wake(world, other_body(world, e));
    }
    for (uint32_t e = body->first_joint; e != DAFT_SIM_NONE; e = world->joints[e >> 1].next[e & 1]) {
        uint32_t other = world->joints[e >> 1].body[(e & 1) ^ 1];
        if (other != DAFT_SIM_NONE) daft_sim_wake(world, other);
    }
}

void daft_sim_wake_all(daft_world *world)
{
    for (uint32_t i = 0; i < world->body_count; i++)
        if (world->bodies[i].kind == DAFT_BODY_DYNAMIC) daft_sim_wake(world, i);
}

void daft_sim_wake_touched(daft_world *world)
{
    for (size_t i = 0; i < world->active.count && world->asleep_count > 0; i++) {
        const daft_sim_active *entry = &world->active.items[i];
        if (!(entry->flags & (DAFT_SIM_FIXED | DAFT_SIM_JOINS))) continue;
        uint32_t a = entry->body_a, b = entry->body_b;
        daft_sim_wake(world, a);
        if (world->bodies[b].asleep) daft_sim_wake(world, b);
    }
}

/* ---- islands ---- */

uint32_t daft_sim_island_of(daft_world *world, uint32_t body_index)
{
    uint32_t *islands = world->scratch.island_parents;
    while (islands[body_index] != body_index) body_index = islands[body_index] = islands[islands[body_index]];
    return body_index;
}

/* The lower index is the root, so it does not depend on the order. What sleeps joins nothing. */
static void join(daft_world *world, uint32_t a, uint32_t b)
{
    uint32_t *islands = world->scratch.island_parents;
    if (world->asleep_count > 0 && (world->bodies[a].asleep || world->bodies[b].asleep)) return;
    if (islands[a] == islands[b]) return; /* most, in an island */
    a = daft_sim_island_of(world, a), b = daft_sim_island_of(world, b);
    islands[a < b ? b : a] = a < b ? a : b;
}

static bool is_dynamic(const daft_world *world, uint32_t body)
{
    return body != DAFT_SIM_NONE && world->bodies[body].kind == DAFT_BODY_DYNAMIC;
}

void daft_sim_islands_find(daft_world *world)
{
    for (size_t i = 0; i < world->awake.count; i++)
        world->scratch.island_parents[world->awake.items[i]] = world->awake.items[i];
    for (size_t i = 0; i < world->active.count; i++) {
        const daft_sim_active *entry = &world->active.items[i];
        if (entry->flags & DAFT_SIM_JOINS) join(world, entry->body_a, entry->body_b);
    }
    for (uint32_t i = 0; world->live_joints > 0 && i < world->joint_count; i++) {
        const daft_sim_joint *joint = &world->joints[i];
        if (joint->kind != 0 && is_dynamic(world, joint->body[0]) && is_dynamic(world, joint->body[1]))
            join(world, joint->body[0], joint->body[1]);
    }
}

/* ---- falling asleep ---- */

static bool moves_others(const daft_world *world, uint32_t body)
{
    return body != DAFT_SIM_NONE && world->bodies[body].kind == DAFT_BODY_KINEMATIC &&
           daft_sim_is_active(&world->bodies[body]);
}

/* What lies on something that moves does not sleep, nor what a surface with a velocity of its own drives or a motor. */
static void keep_carried_awake(daft_world *world)
{
    for (size_t i = 0; i < world->active.count; i++) {
        const daft_sim_active *entry = &world->active.items[i];
        if (!(entry->flags & (DAFT_SIM_FIXED | DAFT_SIM_JOINS))) continue;
        if (world->pairs[entry->pair].surface_moves || moves_others(world, entry->body_b))
            world->bodies[entry->body_a].rest = 0;
    }
    for (uint32_t i = 0; world->live_joints > 0 && i < world->joint_count; i++) {
        const daft_sim_joint *joint = &world->joints[i];
        if (joint->kind == 0) continue;
        for (int side = 0; side < 2; side++)
            if (moves_others(world, joint->body[side]) && joint->body[1 - side] != DAFT_SIM_NONE)
                world->bodies[joint->body[1 - side]].rest = 0;
    }
}

static bool brakes(const daft_sim_joint *joint)
{
    if (joint->spring) return false;
    return joint->kind == DAFT_JOINT_FIXED || (joint->motor && joint->motor_speed == 0 && joint->motor_force > 0);
}

/* Whether all its joints brake, and none of them hangs it on what does not move: then its island lies on something. */
static bool is_braked(const daft_world *world, const daft_sim_body *body)
{
    for (uint32_t e = body->first_joint; e != DAFT_SIM_NONE; e = world->joints[e >> 1].next[e & 1]) {
        const daft_sim_joint *joint = &world->joints[e >> 1];
        if (!brakes(joint) || !is_dynamic(world, joint->body[(e & 1) ^ 1])) return false;
    }
    return body->first_joint != DAFT_SIM_NONE;
}

/* Bound of any point's recent displacement. */
static float displacement_of(daft_sim_body *body, float dt)
{
    float kept = body->rest > 0 ? daft_sim_max(1 - dt / REST_TIME, 0) : 0; /* of half a second of it: a third */
    body->gone = daft_add(daft_scale(body->gone, kept), daft_scale(body->linear, dt));
    body->turned = daft_add(daft_scale(body->turned, kept), daft_scale(body->angular, dt));
    return daft_length(body->gone) + daft_length(body->turned) * body->extent;
}

/* What of a step's time a body was at rest in, as a fraction. */
static float resting(const daft_world *world, daft_sim_body *body, float dt)
{
    float spin = daft_sim_is_zero(body->angular) ? 0 : daft_length(body->angular) * body->extent;
    float speed = daft_length(body->linear) + spin;
    if (!body->may_sleep || !(speed < TREMBLE_SPEED)) return 0;
    float displacement = displacement_of(body, dt),
          limit = daft_sim_min(TREMBLE_DISPLACEMENT, TREMBLE_FRACTION * body->extent);
    if (displacement < limit || speed < REST_SPEED) return 1;
    return displacement < SWAY_DISPLACEMENT * limit && is_braked(world, body) ? SWAY_COUNT : 0;
}

enum { GRAIN = 64, PARALLEL_BODIES = 256 };

typedef struct job {
    daft_world *world;
    float dt;
    atomic_bool tired; /* some have been at rest for long enough */
} job;

static void rest_range(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    job *j = context;
    const daft_sim_list *awake = &j->world->awake;
    size_t first = (size_t)index * GRAIN, end = first + GRAIN;
    bool tired = false;
    for (size_t i = first; i < end && i < awake->count; i++) {
        daft_sim_body *body = &j->world->bodies[awake->items[i]];
        float fraction = resting(j->world, body, j->dt);
        body->rest = fraction > 0 ? body->rest + fraction * j->dt : 0;
        tired |= body->rest >= REST_TIME;
    }
    if (tired) atomic_store_explicit(&j->tired, true, memory_order_relaxed);
}

static bool update_rest(daft_world *world, float dt)
{
    size_t count = world->awake.count;
    job j = {world, dt, false};
    daft_sim_for(world, count >= PARALLEL_BODIES, (uint32_t)((count + GRAIN - 1) / GRAIN), rest_range, &j);
    return atomic_load_explicit(&j.tired, memory_order_relaxed);
}

/* `state` of a root: 1 while all of its island may sleep; then the body before it on the ring. */
static void mark_islands(daft_world *world, float least)
{
    for (size_t i = 0; i < world->awake.count; i++) world->bodies[world->awake.items[i]].state = 1;
    for (size_t i = 0; i < world->awake.count; i++) {
        uint32_t index = world->awake.items[i];
        const daft_sim_body *body = &world->bodies[index];
        if (body->rest < least || !body->may_sleep) world->bodies[daft_sim_island_of(world, index)].state = 0;
    }
}

static void put_to_sleep(daft_world *world, uint32_t index)
{
    daft_sim_body *body = &world->bodies[index], *root = &world->bodies[daft_sim_island_of(world, index)];
    body->asleep = true;
    world->asleep_count++;
    world->sleep_changed = true;
    body->linear = body->angular = body->force = body->torque = daft_v3(0, 0, 0);
    if (body != root) {
        body->ring = root->ring;
        root->ring = index;
    }
    daft_sim_outlines_rest(world, index);
    daft_sim_list_remove(world, &world->awake, index);
    daft_sim_broad_rest(world, index);
    daft_sim_event_sleep(world, DAFT_SIM_SLEEP, index);
}

/* Rings are made of bodies in falling order of the list; a removal fills the gap with the last. */
static void sleep_marked(daft_world *world)
{
    for (size_t i = world->awake.count; i-- > 0;) {
        uint32_t index = world->awake.items[i];
        if (world->bodies[daft_sim_island_of(world, index)].state) put_to_sleep(world, index);
    }
}

void daft_sim_sleep_update(daft_world *world, float dt)
{
    bool tired = update_rest(world, dt);
    if (!tired || !world->sleeping) return;
    keep_carried_awake(world);
    daft_sim_islands_find(world);
    mark_islands(world, REST_TIME);
    sleep_marked(world);
}

void daft_sim_sleep_island(daft_world *world, uint32_t body_index)
{
    if (!world->sleeping) return;
    daft_sim_active_refresh_all(world); /* manifolds may be gone since the step */
    daft_sim_islands_find(world);
    mark_islands(world, -1);
    uint32_t root = daft_sim_island_of(world, body_index), ready = world->bodies[root].state;
    for (size_t i = 0; i < world->awake.count; i++) world->bodies[world->awake.items[i]].state = 0;
    world->bodies[root].state = ready;
    sleep_marked(world);
}
