/* The world itself: settings, lists, and small things that the rest of the room shares. What a caller passes is
 * checked in this file, body.c and joint.c, so that the step may rely on finite numbers within the bounds of
 * world.h. */
#include "sim/solve/solver.h"
#include "sim/broad/broad.h"
#include "sim/contact/contact.h"
#include "sim/sleep.h"

daft_world *daft_world_create(const daft_allocator *allocator, daft_error *error)
{
    daft_world *world = daft_alloc_zero(allocator, 1, sizeof *world);
    if (!world) {
        daft_fail_memory(error, "a simulation world");
        return NULL;
    }
    world->allocator = *allocator;
    world->gravity = daft_v3(0, -9.81f, 0);
    world->substeps = DAFT_SIM_SUBSTEPS;
    world->workers = 1;
    world->isa = daft_isa_best();
    world->sleeping = true;
    world->changes = 1;
    world->sorted = true;
    world->free_body = world->free_part = world->free_pair = world->free_joint = DAFT_SIM_NONE;
    for (size_t i = 0; i < DAFT_COUNT_OF(world->trees); i++) daft_sim_tree_init(&world->trees[i]);
    return world;
}

void daft_world_destroy(daft_world *world)
{
    if (!world) return;
    daft_allocator allocator = world->allocator;
    daft_sim_solver_destroy(world);
    for (uint32_t i = 0; i < world->pair_count; i++) daft_release(&allocator, world->pairs[i].more);
    void *arrays[] = {world->bodies,
                      world->parts,
                      world->pairs,
                      world->joints,
                      world->awake.items,
                      world->movers.items,
                      world->moved.items,
                      world->active.items,
                      world->scratch.sorting.items,
                      world->fat,
                      world->tight,
                      world->outlines,
                      world->box_frames,
                      world->slots,
                      world->scratch.astray.items,
                      world->groups,
                      world->group_boxes,
                      world->scratch.group_keys,
                      world->scratch.ordered,
                      world->scratch.left,
                      world->scratch.ghosts.items,
                      world->scratch.island_parents,
                      world->material_pairs,
                      world->report,
                      world->events.items,
                      world->pending.items,
                      world->scratch.candidates};
    for (size_t i = 0; i < DAFT_COUNT_OF(arrays); i++) daft_release(&allocator, arrays[i]);
    for (size_t i = 0; i < DAFT_COUNT_OF(world->trees); i++) {
        daft_release(&allocator, world->trees[i].nodes);
        daft_release(&allocator, world->trees[i].keys);
    }
    daft_release(&allocator, world);
}

/* ---- settings ---- */

void daft_world_set_gravity(daft_world *world, daft_vec3 gravity)
{
    if (!daft_finite3(gravity)) return;
    gravity = daft_sim_clamp(gravity, DAFT_SIM_MAX_ACCELERATION);
    daft_vec3 change = daft_sub(gravity, world->gravity);
    world->gravity = gravity;
    if (!daft_sim_is_zero(change)) daft_sim_wake_all(world);
}

void daft_world_set_substeps(daft_world *world, int substeps)
{
    if (substeps >= 1 && substeps <= DAFT_SIM_MAX_SUBSTEPS) world->substeps = substeps;
}

void daft_world_set_workers(daft_world *world, int workers, int isa)
{
    if (workers >= 1 && workers <= 64) world->workers = workers;
    if (isa >= 0 && isa <= daft_isa_best()) world->isa = isa;
}

void daft_world_set_sleeping(daft_world *world, bool allowed)
{
    world->sleeping = allowed;
    if (!allowed) daft_sim_wake_all(world);
}

daft_sim_times daft_world_times(const daft_world *world) { return world->times; }

daft_sim_counters daft_world_counters(const daft_world *world)
{
    daft_sim_counters counters = world->counters;
    counters.bodies = world->live_bodies;
    counters.awake = (uint32_t)world->awake.count;
    counters.joints = world->live_joints;
    return counters;
}

/* ---- pairs of materials ---- */

static bool in_range(float x, float most) { return x >= 0 && x <= most; }

bool daft_world_set_pair(daft_world *world, uint32_t a, uint32_t b, const daft_sim_material_pair *pair,
                         daft_error *error)
{
    if (a >= DAFT_SIM_MATERIAL_KINDS || b >= DAFT_SIM_MATERIAL_KINDS)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "material kinds %u and %u must be below %d", a, b,
                         DAFT_SIM_MATERIAL_KINDS);
    if (pair && !(in_range(pair->friction, 1e6f) && in_range(pair->static_friction, 1e6f) &&
                  in_range(pair->restitution, 1) && in_range(pair->rolling_resistance, 1e6f)))
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "materials %u and %u: friction and rolling resistance must be 0 to 1e6, restitution 0 to 1", a,
                         b);
    if (!world->material_pairs) {
        size_t count = (size_t)DAFT_SIM_MATERIAL_KINDS * DAFT_SIM_MATERIAL_KINDS;
        world->material_pairs = daft_alloc(&world->allocator, count, sizeof *world->material_pairs);
        if (!world->material_pairs) return daft_fail_memory(error, "pairs of materials");
        for (size_t i = 0; i < count; i++) world->material_pairs[i] = (daft_sim_material_pair){.friction = -1};
    }
    daft_sim_material_pair value = pair ? *pair : (daft_sim_material_pair){.friction = -1};
    world->material_pairs[a * DAFT_SIM_MATERIAL_KINDS + b] = world->material_pairs[b * DAFT_SIM_MATERIAL_KINDS + a] =
        value;
    for (uint32_t i = 0; i < world->pair_count; i++)
        if (world->pairs[i].part_a != DAFT_SIM_NONE) daft_sim_pair_materials(world, &world->pairs[i]);
    return true;
}

/* ---- small things ---- */

/* NaN fails the first comparison and becomes -limit. */
static float clamp(float x, float limit) { return x >= -limit ? (x <= limit ? x : limit) : -limit; }

daft_vec3 daft_sim_clamp_far(daft_vec3 v, float limit)
{
    v = daft_v3(clamp(v.x, limit), clamp(v.y, limit), clamp(v.z, limit));
    float length = daft_length(v);
    return length > limit ? daft_scale(v, limit / length) : v;
}

daft_quat daft_sim_turn(daft_quat q, daft_vec3 angular, float h)
{
    /* q + (half, 0)·q, normalised, turns by 2·atan(|half|); x + x³/3 begins the series of the tangent. */
    daft_vec3 half = daft_scale(angular, 0.5f * h);
    half = daft_scale(half, 1 + daft_dot(half, half) * (1.0f / 3));
    daft_quat spin = daft_quat_mul((daft_quat){half.x, half.y, half.z, 0}, q);
    return daft_quat_normalize((daft_quat){q.x + spin.x, q.y + spin.y, q.z + spin.z, q.w + spin.w});
}

daft_rigid daft_sim_part_frame(const daft_sim_body *body, const daft_sim_part *part)
{
    return part->posed ? daft_rigid_mul(&body->frame, &part->pose) : body->frame;
}

bool daft_sim_list_reserve(daft_world *world, daft_sim_list *list, size_t needed)
{
    return daft_grow(&world->allocator, &list->items, &list->capacity, needed, list->count, sizeof *list->items);
}

void daft_sim_list_add(daft_world *world, daft_sim_list *list, uint32_t body_index)
{
    world->bodies[body_index].list_slot = (uint32_t)list->count;
    world->newcomers = true;
    list->items[list->count++] = body_index;
}

void daft_sim_list_remove(daft_world *world, daft_sim_list *list, uint32_t body_index)
{
    uint32_t slot = world->bodies[body_index].list_slot, last = list->items[--list->count];
    list->items[slot] = last;
    world->bodies[last].list_slot = slot;
    world->bodies[body_index].list_slot = DAFT_SIM_NONE;
    for (uint32_t i = world->bodies[body_index].first_part; i != DAFT_SIM_NONE; i = world->parts[i].next)
        daft_sim_group_leave(world, i);
}
