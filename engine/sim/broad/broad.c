/* The broad phase: which parts may meet within a step. Parts stand in the tree of their body's kind: static ones with
 * their exact bounds, the others with fat ones, wider in the direction they move, so that one which moves a little does
 * not touch the tree. What moves finds in the trees what rests; the others that move it finds in groups, by the bounds
 * that each has over the step (tight). So what is dynamic and awake is moved in its tree only when something asks for
 * it there: a query, or the sweep of a bullet. */
#include "sim/world.h"
#include "sim/broad/broad.h"

#include <stdatomic.h>

/* Fat on each side, as a fraction of the reach, and how many steps' movement is taken ahead. A leaf is entered anew
 * when the part leaves it, or has grown much smaller than it (a shot that has come to rest). */
#define FAT        0.1
#define AHEAD      6.0
#define SLIM       4.0
#define AHEAD_TIME 0.1 /* s: the same where the length of the next step is not known */

static daft_sim_bounds grown(const daft_sim_bounds *bounds, double by)
{
    daft_dvec3 d = daft_dv3(by, by, by);
    return (daft_sim_bounds){daft_dsub(bounds->low, d), daft_dadd(bounds->high, d)};
}

static daft_sim_bounds stretched(const daft_sim_bounds *bounds, daft_dvec3 by)
{
    daft_dvec3 zero = daft_dv3(0, 0, 0);
    return (daft_sim_bounds){daft_dadd(bounds->low, daft_sim_dmin(by, zero)),
                             daft_dadd(bounds->high, daft_sim_dmax(by, zero))};
}

static daft_sim_bounds part_bounds(const daft_world *world, uint32_t part_index)
{
    const daft_sim_part *part = &world->parts[part_index];
    daft_rigid frame = daft_sim_part_frame(&world->bodies[part->body], part);
    return daft_shape_bounds(&part->shape, &frame);
}

bool daft_sim_bounds_reserve(daft_world *world, size_t parts)
{
    const daft_allocator *a = &world->allocator;
    size_t used = world->part_count;
    return daft_grow(a, &world->fat, &world->fat_capacity, parts, used, sizeof *world->fat) &&
           daft_grow(a, &world->tight, &world->tight_capacity, parts, used, sizeof *world->tight) &&
           daft_grow(a, &world->slots, &world->slots_capacity, parts, used, sizeof *world->slots) &&
           daft_sim_list_reserve(world, &world->moved, parts) &&
           daft_sim_list_reserve(world, &world->scratch.astray, parts) && daft_sim_outlines_reserve(world, parts);
}

/* Bounds that the part will stay in for a while. */
static void fatten(daft_world *world, uint32_t index, const daft_sim_bounds *bounds, daft_dvec3 ahead)
{
    const daft_sim_part *part = &world->parts[index];
    daft_sim_bounds *fat = &world->fat[index];
    *fat = *bounds;
    if (world->bodies[part->body].kind == DAFT_BODY_STATIC) return;
    *fat = grown(fat, FAT * (double)part->reach);
    *fat = stretched(fat, ahead);
}

static void mark_moved(daft_world *world, uint32_t index)
{
    daft_sim_part *part = &world->parts[index];
    world->newcomers = true;
    if (part->moved_slot != DAFT_SIM_NONE) return;
    part->moved_slot = (uint32_t)world->moved.count;
    world->moved.items[world->moved.count++] = index; /* room for every part was reserved */
}

static void enter(daft_world *world, uint32_t index)
{
    daft_sim_part *part = &world->parts[index];
    daft_body_kind kind = world->bodies[part->body].kind;
    part->dynamic = kind == DAFT_BODY_DYNAMIC;
    part->leaf = daft_sim_tree_insert(&world->trees[kind], &world->fat[index], index);
}

void daft_sim_broad_add(daft_world *world, uint32_t body_index)
{
    world->changes++;
    daft_sim_outlines_rest(world, body_index);
    for (uint32_t i = world->bodies[body_index].first_part; i != DAFT_SIM_NONE; i = world->parts[i].next) {
        world->tight[i] = part_bounds(world, i);
        world->slots[i] = DAFT_SIM_NONE;
        fatten(world, i, &world->tight[i], daft_dv3(0, 0, 0));
        enter(world, i);
        mark_moved(world, i);
    }
}

void daft_sim_broad_remove(daft_world *world, uint32_t body_index)
{
    world->changes++;
    const daft_sim_body *body = &world->bodies[body_index];
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = world->parts[i].next) {
        daft_sim_tree_remove(&world->trees[body->kind], world->parts[i].leaf);
        daft_sim_group_leave(world, i);
        uint32_t slot = world->parts[i].moved_slot;
        if (slot == DAFT_SIM_NONE) continue;
        uint32_t last = world->moved.items[--world->moved.count];
        world->moved.items[slot] = last;
        world->parts[last].moved_slot = slot;
        world->parts[i].moved_slot = DAFT_SIM_NONE;
    }
}

static bool contains(const daft_sim_bounds *outer, const daft_sim_bounds *inner)
{
    return outer->low.x <= inner->low.x && outer->low.y <= inner->low.y && outer->low.z <= inner->low.z &&
           outer->high.x >= inner->high.x && outer->high.y >= inner->high.y && outer->high.z >= inner->high.z;
}

static double longest_side(const daft_sim_bounds *bounds)
{
    daft_dvec3 d = daft_dsub(bounds->high, bounds->low);
    double longest = d.x > d.y ? d.x : d.y;
    return longest > d.z ? longest : d.z;
}

static bool has_left(const daft_sim_bounds *fat, const daft_sim_bounds *now)
{
    return !contains(fat, now) || longest_side(fat) > SLIM * longest_side(now);
}

/* Of a body's centre over the coming step, if nothing stops it. */
static daft_dvec3 displacement_of(const daft_world *world, const daft_sim_body *body, float dt)
{
    daft_vec3 mean = body->linear;
    if (body->kind == DAFT_BODY_DYNAMIC) {
        daft_vec3 gain = daft_scale(body->force, body->inv_mass);
        gain =
            daft_sim_clamp(daft_add(gain, daft_scale(world->gravity, body->gravity_scale)), DAFT_SIM_MAX_ACCELERATION);
        mean = daft_add(mean, daft_scale(gain, dt));
    }
    return daft_to_double(daft_scale(daft_sim_clamp(mean, DAFT_SIM_MAX_SPEED), dt));
}

static float margin_of(const daft_sim_part *part)
{
    return daft_sim_min(DAFT_SIM_MARGIN * part->reach, DAFT_SIM_MAX_MARGIN);
}

/* The margin of contacts, the centre's displacement, and what turning adds: at most the reach from the centre, twice.
 * Gives whether the part has to enter the tree anew. */
static bool update(daft_world *world, uint32_t index, daft_dvec3 displacement, float turn, float dt)
{
    const daft_sim_part *part = &world->parts[index];
    daft_rigid frame = daft_sim_part_frame(&world->bodies[part->body], part);
    daft_sim_bounds bounds = daft_shape_bounds(&part->shape, &frame);
    daft_sim_outline_set(world, index, &frame, dt);
    float margin = margin_of(part);
    if (part->round && !part->posed && part->shape.type == DAFT_GEOMETRY_SPHERE) turn = 0;
    bounds = grown(&bounds, (double)(margin + daft_sim_min(turn, 2) * world->bodies[part->body].extent));
    world->tight[index] = stretched(&bounds, displacement);
    return has_left(&world->fat[index], &world->tight[index]);
}

static bool update_body(daft_world *world, uint32_t index, float dt)
{
    const daft_sim_body *body = &world->bodies[index];
    float turn = daft_sim_is_zero(body->angular) ? 0 : daft_length(body->angular) * dt;
    daft_dvec3 displacement = displacement_of(world, body, dt);
    bool left = false;
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = world->parts[i].next)
        left |= update(world, i, displacement, turn, dt);
    return left;
}

/* Gives a part other bounds in the tree, and moves it there, if it stays near its place. */
static void widen(daft_world *world, uint32_t index, const daft_sim_bounds *bounds, daft_dvec3 ahead)
{
    const daft_sim_part *part = &world->parts[index];
    fatten(world, index, bounds, ahead);
    if (!daft_sim_tree_move(&world->trees[world->bodies[part->body].kind], part->leaf, &world->fat[index]))
        world->scratch.astray.items[world->scratch.astray.count++] = index; /* room for every part was reserved */
}

static void widen_body(daft_world *world, uint32_t index, float dt)
{
    const daft_sim_body *body = &world->bodies[index];
    daft_dvec3 ahead = daft_dscale(displacement_of(world, body, dt), AHEAD);
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = world->parts[i].next)
        if (has_left(&world->fat[i], &world->tight[i])) widen(world, i, &world->tight[i], ahead);
}

/* Trees are fitted to what was moved; then the others enter anew. */
static void fit_trees(daft_world *world)
{
    for (size_t i = 0; i < DAFT_COUNT_OF(world->trees); i++) daft_sim_tree_fit(&world->trees[i]);
    for (size_t i = 0; i < world->scratch.astray.count; i++) {
        uint32_t index = world->scratch.astray.items[i];
        const daft_sim_part *part = &world->parts[index];
        daft_sim_tree_remove(&world->trees[world->bodies[part->body].kind], part->leaf);
        enter(world, index);
    }
    world->scratch.astray.count = 0;
    for (size_t i = 0; i < DAFT_COUNT_OF(world->trees); i++) daft_sim_tree_tidy(&world->trees[i]);
}

enum { GRAIN = 64, PARALLEL_BODIES = 256 };

typedef struct job {
    daft_world *world;
    float dt;
    atomic_bool bullets; /* some are */
} job;

static void update_range(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    job *j = context;
    daft_world *world = j->world;
    size_t first = (size_t)index * GRAIN, end = first + GRAIN;
    bool bullets = false;
    if (end > world->awake.count) end = world->awake.count;
    for (size_t i = first; i < end; i++) {
        world->scratch.left[i] = update_body(world, world->awake.items[i], j->dt);
        bullets |= world->bodies[world->awake.items[i]].bullet;
    }
    if (bullets) atomic_store_explicit(&j->bullets, true, memory_order_relaxed);
}

bool daft_sim_broad_update(daft_world *world, float dt)
{
    size_t count = world->awake.count;
    job j = {world, dt, false};
    if (!daft_sim_groups_join(world) ||
        !daft_grow(&world->allocator, &world->scratch.left, &world->scratch.left_capacity, count, 0,
                   sizeof *world->scratch.left))
        return false;
    daft_sim_for(world, count >= PARALLEL_BODIES, (uint32_t)((count + GRAIN - 1) / GRAIN), update_range, &j);
    bool bullets = atomic_load_explicit(&j.bullets, memory_order_relaxed);
    for (size_t i = 0; bullets && i < count; i++)
        if (world->scratch.left[i]) widen_body(world, world->awake.items[i], dt);
    for (size_t i = 0; i < world->movers.count; i++)
        if (update_body(world, world->movers.items[i], dt)) widen_body(world, world->movers.items[i], dt);
    fit_trees(world);
    daft_sim_groups_fit(world);
    return true;
}

/* ---- between steps ---- */

static void settle_part(daft_world *world, uint32_t index, daft_dvec3 ahead)
{
    daft_sim_bounds now = part_bounds(world, index);
    if (has_left(&world->fat[index], &now)) widen(world, index, &now, ahead);
}

void daft_sim_broad_settle(daft_world *world)
{
    const daft_sim_list *lists[2] = {&world->awake, &world->movers};
    if (world->settled_at == world->changes) return;
    for (int k = 0; k < 2; k++)
        for (size_t n = 0; n < lists[k]->count; n++) {
            const daft_sim_body *body = &world->bodies[lists[k]->items[n]];
            daft_dvec3 ahead = daft_dscale(daft_to_double(body->linear), AHEAD_TIME);
            for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = world->parts[i].next)
                settle_part(world, i, ahead);
        }
    fit_trees(world);
    world->settled_at = world->changes;
}

void daft_sim_broad_rest(daft_world *world, uint32_t body_index)
{
    const daft_sim_body *body = &world->bodies[body_index];
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = world->parts[i].next) {
        daft_sim_tree_remove(&world->trees[body->kind], world->parts[i].leaf);
        daft_sim_bounds now = part_bounds(world, i);
        world->tight[i] = grown(&now, (double)margin_of(&world->parts[i]));
        fatten(world, i, &world->tight[i], daft_dv3(0, 0, 0));
        enter(world, i);
    }
}
