/* The world's bodies: slots, definitions, poses, velocities. What a caller passes is checked here, so that the step may
 * rely on finite numbers within the bounds of internal.h: a definition beyond them is refused, a call with a number
 * that is not finite or a body that is not there does nothing, a velocity beyond them is clamped. */
#include "sim/internal.h"

#include <string.h>

daft_world *daft_world_create(const daft_allocator *allocator, daft_error *error)
{
    daft_world *world = daft_alloc_zero(allocator, 1, sizeof *world);
    if (!world) {
        daft_fail_memory(error, "a simulation world");
        return NULL;
    }
    world->allocator = *allocator;
    world->gravity = daft_v3(0, -9.81f, 0);
    world->free_list = DAFT_SIM_NONE;
    for (size_t i = 0; i < DAFT_COUNT_OF(world->trees); i++) daft_sim_tree_init(&world->trees[i]);
    return world;
}

void daft_world_destroy(daft_world *world)
{
    if (!world) return;
    daft_allocator allocator = world->allocator;
    void *arrays[] = {world->bodies, world->motions,    world->dynamics.items, world->movers.items,
                      world->points, world->old_points, world->report,         world->report_keys};
    for (size_t i = 0; i < DAFT_COUNT_OF(arrays); i++) daft_release(&allocator, arrays[i]);
    for (size_t i = 0; i < DAFT_COUNT_OF(world->trees); i++) daft_release(&allocator, world->trees[i].nodes);
    daft_release(&allocator, world);
}

/* NaN fails the first comparison and becomes -limit. */
static float clamp(float x, float limit)
{
    return x >= -limit ? (x <= limit ? x : limit) : -limit;
}

daft_vec3 daft_sim_clamp(daft_vec3 v, float limit)
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

void daft_world_set_gravity(daft_world *world, daft_vec3 gravity)
{
    if (daft_finite3(gravity)) world->gravity = daft_sim_clamp(gravity, DAFT_SIM_MAX_ACCELERATION);
}

/* ---- definitions ---- */

static bool pose_is_good(daft_dvec3 p, daft_quat q)
{
    double limit = DAFT_SIM_MAX_DISTANCE;
    double norm =
        (double)q.x * (double)q.x + (double)q.y * (double)q.y + (double)q.z * (double)q.z + (double)q.w * (double)q.w;
    return fabs(p.x) <= limit && fabs(p.y) <= limit && fabs(p.z) <= limit && norm > 1e-12 && norm < 1e12;
}

static bool size_is_good(float size)
{
    return size >= DAFT_SIM_MIN_SIZE && size <= DAFT_SIM_MAX_SIZE;
}

static bool check_shape(const daft_sim_body_def *def, daft_error *error)
{
    if (def->shape == DAFT_SHAPE_SPHERE) {
        if (size_is_good(def->radius)) return true;
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: radius %g is not within %g to %g m", (double)def->radius,
                         (double)DAFT_SIM_MIN_SIZE, (double)DAFT_SIM_MAX_SIZE);
    }
    if (def->shape != DAFT_SHAPE_BOX)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: its shape must be a sphere or a box");
    if (def->kind == DAFT_BODY_DYNAMIC)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: a dynamic body must be a sphere");
    daft_vec3 h = def->half_extent;
    if (size_is_good(h.x) && size_is_good(h.y) && size_is_good(h.z)) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: half extents %g, %g, %g are not within %g to %g m", (double)h.x,
                     (double)h.y, (double)h.z, (double)DAFT_SIM_MIN_SIZE, (double)DAFT_SIM_MAX_SIZE);
}

static double sphere_mass(const daft_sim_body_def *def)
{
    double r = (double)def->radius;
    return (double)def->density * (4.0 / 3 * DAFT_PI) * r * r * r;
}

static bool check_def(const daft_sim_body_def *def, daft_error *error)
{
    if (def->kind != DAFT_BODY_STATIC && def->kind != DAFT_BODY_KINEMATIC && def->kind != DAFT_BODY_DYNAMIC)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: its kind must be static, kinematic or dynamic");
    if (!check_shape(def, error)) return false;
    if (!pose_is_good(def->position, def->rotation))
        return daft_fail(
            error, DAFT_ERROR_ARGUMENT,
            "body: position (%g, %g, %g) or rotation (%g, %g, %g, %g) is not finite, or too large, or zero",
            def->position.x, def->position.y, def->position.z, (double)def->rotation.x, (double)def->rotation.y,
            (double)def->rotation.z, (double)def->rotation.w);
    if (!(def->friction >= 0 && def->friction <= 1e6f))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: friction %g is not within 0 to 1e6", (double)def->friction);
    if (!(def->restitution >= 0 && def->restitution <= 1))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: restitution %g is not within 0 to 1",
                         (double)def->restitution);
    if (!(def->rolling_resistance >= 0 && def->rolling_resistance <= 1e6f))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: rolling resistance %g is not within 0 to 1e6",
                         (double)def->rolling_resistance);
    if (def->kind != DAFT_BODY_DYNAMIC) return true;
    double mass = sphere_mass(def);
    if (mass >= DAFT_SIM_MIN_MASS && mass <= DAFT_SIM_MAX_MASS) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: density %g gives a mass of %g kg, not within %g to %g",
                     (double)def->density, mass, DAFT_SIM_MIN_MASS, DAFT_SIM_MAX_MASS);
}

/* ---- slots and lists ---- */

static bool reserve_list(daft_world *world, daft_sim_list *list, size_t needed)
{
    return daft_grow(&world->allocator, &list->items, &list->capacity, needed, list->count, sizeof *list->items);
}

static void list_add(daft_world *world, daft_sim_list *list, uint32_t index)
{
    world->bodies[index].list_slot = (uint32_t)list->count;
    list->items[list->count++] = index;
}

static void list_remove(daft_world *world, daft_sim_list *list, uint32_t index)
{
    uint32_t slot = world->bodies[index].list_slot, last = list->items[--list->count];
    list->items[slot] = last;
    world->bodies[last].list_slot = slot;
    world->bodies[index].list_slot = DAFT_SIM_NONE;
}

static bool reserve_slot(daft_world *world)
{
    size_t count = world->body_count;
    if (world->free_list != DAFT_SIM_NONE) return true;
    return count < INT32_MAX && /* the keys of contacts leave 31 bits for the first body */
           daft_grow(&world->allocator, &world->bodies, &world->body_capacity, count + 1, count,
                     sizeof *world->bodies) &&
           daft_grow(&world->allocator, &world->motions, &world->motion_capacity, count + 1, count,
                     sizeof *world->motions);
}

/* After this, adding a body and starting to move a kinematic one cannot fail. */
static bool reserve_body(daft_world *world, daft_body_kind kind)
{
    daft_sim_tree *tree = &world->trees[kind];
    if (!reserve_slot(world) || !daft_sim_tree_reserve(tree, &world->allocator)) return false;
    if (kind == DAFT_BODY_STATIC) return true;
    daft_sim_list *list = kind == DAFT_BODY_DYNAMIC ? &world->dynamics : &world->movers;
    return reserve_list(world, list, (size_t)tree->leaf_count + 1);
}

static uint32_t take_slot(daft_world *world)
{
    uint32_t index = world->free_list;
    if (index == DAFT_SIM_NONE) return world->body_count++;
    world->free_list = world->bodies[index].next_free;
    return index;
}

static void set_pose(daft_sim_body *body, daft_dvec3 position, daft_quat rotation)
{
    body->position = position;
    body->rotation = rotation;
    daft_quat_matrix(rotation, body->basis);
}

static void fill_body(daft_sim_body *body, daft_sim_motion *motion, const daft_sim_body_def *def)
{
    *body = (daft_sim_body){.kind = def->kind,
                            .shape = def->shape,
                            .friction = def->friction,
                            .restitution = def->restitution,
                            .rolling_resistance = def->rolling_resistance,
                            .user = def->user,
                            .fresh = true,
                            .list_slot = DAFT_SIM_NONE,
                            .next_free = DAFT_SIM_NONE};
    *motion = (daft_sim_motion){.turn = daft_quat_identity()};
    if (def->shape == DAFT_SHAPE_SPHERE) {
        body->radius = body->reach = def->radius;
    } else {
        body->half_extent = def->half_extent;
        body->reach = daft_length(def->half_extent) * 1.000001f; /* rounded up */
    }
    if (def->kind == DAFT_BODY_DYNAMIC) {
        double mass = sphere_mass(def), r = (double)def->radius;
        motion->inv_mass = (float)(1 / mass);
        motion->inv_inertia = (float)(1 / (0.4 * mass * r * r));
    }
    set_pose(body, def->position, daft_quat_normalize(def->rotation));
}

uint32_t daft_world_add(daft_world *world, const daft_sim_body_def *def, daft_error *error)
{
    if (!check_def(def, error)) return 0;
    if (!reserve_body(world, def->kind)) {
        daft_fail_memory(error, "a body");
        return 0;
    }
    uint32_t index = take_slot(world);
    fill_body(&world->bodies[index], &world->motions[index], def);
    daft_sim_broad_add(world, index);
    if (def->kind == DAFT_BODY_DYNAMIC) list_add(world, &world->dynamics, index);
    return index + 1;
}

static void forget_contacts(daft_world *world, uint32_t index)
{
    size_t kept = 0;
    for (size_t i = 0; i < world->report_count; i++) {
        uint64_t key = world->report_keys[i];
        if ((uint32_t)key == index || (uint32_t)(key >> 32) == index) continue;
        world->report[kept] = world->report[i];
        world->report_keys[kept++] = key;
    }
    world->report_count = kept;
}

void daft_world_remove(daft_world *world, uint32_t handle)
{
    if (!daft_sim_find(world, handle)) return;
    uint32_t index = handle - 1;
    daft_sim_body *body = &world->bodies[index];
    if (body->list_slot != DAFT_SIM_NONE)
        list_remove(world, body->kind == DAFT_BODY_DYNAMIC ? &world->dynamics : &world->movers, index);
    daft_sim_broad_remove(world, index);
    forget_contacts(world, index);
    body->kind = DAFT_BODY_NONE;
    body->next_free = world->free_list;
    world->free_list = index;
}

/* ---- state ---- */

/* The list of movers has room for every kinematic body. */
static void start_moving(daft_world *world, uint32_t index)
{
    if (world->bodies[index].list_slot == DAFT_SIM_NONE) list_add(world, &world->movers, index);
}

void daft_world_set_pose(daft_world *world, uint32_t handle, daft_dvec3 position, daft_quat rotation, bool teleport)
{
    if (!daft_sim_find(world, handle) || !pose_is_good(position, rotation)) return;
    uint32_t index = handle - 1;
    daft_sim_body *body = &world->bodies[index];
    rotation = daft_quat_normalize(rotation);
    if (body->kind == DAFT_BODY_KINEMATIC && !teleport) {
        body->target_position = position;
        body->target_rotation = rotation;
        body->has_target = true;
        start_moving(world, index);
        return;
    }
    daft_sim_broad_remove(world, index);
    set_pose(body, position, rotation);
    daft_sim_broad_add(world, index);
    body->has_target = false;
    body->fresh = true;
}

void daft_world_set_velocity(daft_world *world, uint32_t handle, daft_vec3 linear, daft_vec3 angular)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    if (!body || body->kind == DAFT_BODY_STATIC || !daft_finite3(linear) || !daft_finite3(angular)) return;
    uint32_t index = handle - 1;
    world->motions[index].linear = daft_sim_clamp(linear, DAFT_SIM_MAX_SPEED);
    world->motions[index].angular = daft_sim_clamp(angular, DAFT_SIM_MAX_SPIN);
    if (body->kind == DAFT_BODY_DYNAMIC) return;
    world->bodies[index].follows = false;
    start_moving(world, index);
}

void daft_world_get(const daft_world *world, uint32_t handle, daft_sim_state *out)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    *out = (daft_sim_state){.rotation = daft_quat_identity()};
    if (!body) return;
    const daft_sim_motion *motion = &world->motions[handle - 1];
    *out = (daft_sim_state){body->position, body->rotation, motion->linear, motion->angular};
}

void daft_world_apply_force(daft_world *world, uint32_t handle, daft_vec3 force)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    if (!body || body->kind != DAFT_BODY_DYNAMIC) return;
    daft_vec3 sum = daft_add(body->force, force);
    if (daft_finite3(sum)) world->bodies[handle - 1].force = sum;
}

void daft_world_apply_impulse(daft_world *world, uint32_t handle, daft_vec3 impulse)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    if (!body || body->kind != DAFT_BODY_DYNAMIC || !daft_finite3(impulse)) return;
    daft_sim_motion *motion = &world->motions[handle - 1];
    daft_vec3 change = daft_sim_clamp(daft_scale(impulse, motion->inv_mass), 2 * DAFT_SIM_MAX_SPEED);
    motion->linear = daft_sim_clamp(daft_add(motion->linear, change), DAFT_SIM_MAX_SPEED);
}

uint32_t daft_world_contacts(const daft_world *world, const daft_sim_contact **out)
{
    *out = world->report;
    return (uint32_t)world->report_count;
}

uint64_t daft_world_hash(const daft_world *world, uint64_t seed)
{
    uint64_t hash = daft_hash(&world->body_count, sizeof world->body_count, seed);
    for (uint32_t i = 0; i < world->body_count; i++) {
        const daft_sim_body *body = &world->bodies[i];
        if (body->kind == DAFT_BODY_NONE) continue;
        const daft_sim_motion *m = &world->motions[i];
        double position[] = {body->position.x, body->position.y, body->position.z};
        float rest[] = {body->rotation.x, body->rotation.y, body->rotation.z, body->rotation.w, m->linear.x,
                        m->linear.y,      m->linear.z,      m->angular.x,     m->angular.y,     m->angular.z};
        hash = daft_hash(&i, sizeof i, hash);
        hash = daft_hash(position, sizeof position, hash);
        hash = daft_hash(rest, sizeof rest, hash);
    }
    return hash;
}
