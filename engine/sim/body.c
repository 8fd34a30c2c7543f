/* Bodies and their parts: definitions, mass, poses, velocities. A definition beyond the bounds of world.h is
 * refused, a call with a number that is not finite or a body that is not there does nothing, a velocity beyond them is
 * clamped. */
#include "sim/world.h"
#include "sim/broad/broad.h"
#include "sim/contact/contact.h"
#include "sim/events.h"
#include "sim/joint/joint.h"
#include "sim/sleep.h"
#include "sim/solve/solver.h"

#include <string.h>

/* ---- makers ---- */

daft_sim_shape_def daft_default_sim_shape_def(void)
{
    daft_sim_shape_def def = {.rotation = {0, 0, 0, 1}, .density = 1000, .layers = 1, .mask = UINT32_MAX};
    def.shape.type = DAFT_GEOMETRY_SPHERE;
    def.shape.radius = 0.5f;
    def.material.friction = 0.6f;
    return def;
}

daft_sim_body_def daft_default_sim_body_def(void)
{
    return (daft_sim_body_def){
        .kind = DAFT_BODY_DYNAMIC, .rotation = {0, 0, 0, 1}, .gravity_scale = 1, .may_sleep = true};
}

/* ---- checks ---- */

static bool quat_is_good(daft_quat q)
{
    double norm =
        (double)q.x * (double)q.x + (double)q.y * (double)q.y + (double)q.z * (double)q.z + (double)q.w * (double)q.w;
    return norm > 1e-12 && norm < 1e12;
}

static bool pose_is_good(daft_dvec3 p, daft_quat q)
{
    double limit = DAFT_SIM_MAX_DISTANCE;
    return fabs(p.x) <= limit && fabs(p.y) <= limit && fabs(p.z) <= limit && quat_is_good(q);
}

static bool check_range(daft_error *error, const char *what, float value, float most)
{
    if (value >= 0 && value <= most) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: %s %g is not within 0 to %g", what, (double)value,
                     (double)most);
}

static bool check_material(const daft_sim_material *m, daft_error *error)
{
    if (!check_range(error, "friction", m->friction, 1e6f) ||
        !check_range(error, "static friction", m->static_friction, 1e6f) ||
        !check_range(error, "restitution", m->restitution, 1) ||
        !check_range(error, "rolling resistance", m->rolling_resistance, 1e6f))
        return false;
    if (!daft_finite3(m->surface_velocity) || daft_length(m->surface_velocity) > DAFT_SIM_MAX_SPEED)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: surface_velocity is not finite or beyond %g m/s",
                         (double)DAFT_SIM_MAX_SPEED);
    if (m->kind < DAFT_SIM_MATERIAL_KINDS) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: material kind %u is not below %d", m->kind,
                     DAFT_SIM_MATERIAL_KINDS);
}

static bool check_size(float size, const char *what, daft_error *error)
{
    if (size >= DAFT_SHAPE_MIN_SIZE && size <= DAFT_SHAPE_MAX_SIZE) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: %s %g is not within %g to %g m", what, (double)size,
                     (double)DAFT_SHAPE_MIN_SIZE, (double)DAFT_SHAPE_MAX_SIZE);
}

static bool check_geometry(const daft_sim_shape *s, daft_error *error)
{
    switch (s->type) {
    case DAFT_GEOMETRY_SPHERE: return check_size(s->radius, "radius", error);
    case DAFT_GEOMETRY_CAPSULE:
        if (s->half_height == 0) return check_size(s->radius, "radius", error);
        return check_size(s->radius, "radius", error) && check_size(s->half_height, "half height", error);
    case DAFT_GEOMETRY_BOX:
        return check_size(s->half.x, "half extent", error) && check_size(s->half.y, "half extent", error) &&
               check_size(s->half.z, "half extent", error);
    case DAFT_GEOMETRY_HULL:
    case DAFT_GEOMETRY_MESH:
    case DAFT_GEOMETRY_FIELD:
    case DAFT_GEOMETRY_COMPOUND:
        return s->hull || daft_fail(error, DAFT_ERROR_ARGUMENT, "body: its shape points to nothing");
    case DAFT_GEOMETRY_NONE: break;
    }
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: it has a shape of no known type");
}

bool daft_sim_shape_check(const daft_sim_shape_def *def, daft_body_kind kind, daft_error *error)
{
    if (!check_geometry(&def->shape, error) || !check_material(&def->material, error)) return false;
    if (!daft_finite3(def->position) || daft_length(def->position) > DAFT_SHAPE_MAX_SIZE ||
        !quat_is_good(def->rotation))
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "body: a shape's position or rotation is not finite, or too large, or zero");
    if (kind != DAFT_BODY_DYNAMIC) return true;
    if (!(def->density >= 0 && def->density <= 1e30f))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: density %g is not within 0 to 1e30", (double)def->density);
    if (def->sensor || daft_shape_has_mass(&def->shape)) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: a mesh or height field cannot be dynamic");
}

static bool check_def(const daft_sim_body_def *def, daft_error *error)
{
    if (def->kind != DAFT_BODY_STATIC && def->kind != DAFT_BODY_KINEMATIC && def->kind != DAFT_BODY_DYNAMIC)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: its kind must be static, kinematic or dynamic");
    if (def->shape_count > 0 && !def->shapes)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: it has %u shapes, but none are given", def->shape_count);
    for (uint32_t i = 0; i < def->shape_count; i++)
        if (!daft_sim_shape_check(&def->shapes[i], def->kind, error)) return false;
    if (!pose_is_good(def->position, def->rotation))
        return daft_fail(
            error, DAFT_ERROR_ARGUMENT,
            "body: position (%g, %g, %g) or rotation (%g, %g, %g, %g) is not finite, or too large, or zero",
            def->position.x, def->position.y, def->position.z, (double)def->rotation.x, (double)def->rotation.y,
            (double)def->rotation.z, (double)def->rotation.w);
    if (!daft_finite3(def->linear) || !daft_finite3(def->angular))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: its velocity is not finite");
    if (!check_range(error, "linear damping", def->linear_damping, 1e6f) ||
        !check_range(error, "angular damping", def->angular_damping, 1e6f))
        return false;
    if (fabsf(def->gravity_scale) <= 1e6f) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: gravity scale %g is not within 1e6",
                     (double)def->gravity_scale);
}

/* ---- mass ---- */

static bool total_mass(const daft_world *world, const daft_sim_body *body, daft_mass *sum, daft_error *error)
{
    bool any = false;
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = world->parts[i].next) {
        const daft_sim_part *part = &world->parts[i];
        daft_mass mass;
        if (part->sensor || !daft_shape_mass(&part->shape, (double)part->density, &mass)) continue;
        mass = daft_mass_moved(&mass, &part->pose);
        *sum = any ? daft_mass_sum(sum, &mass) : mass;
        any = true;
    }
    if (!any || !(sum->mass > 0)) {
        /* A given mass may stand in for densities of 0, but not for a shape. */
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: no shape gives it a mass above 0");
    }
    if (body->wanted_mass > 0) {
        double scale = (double)body->wanted_mass / sum->mass;
        sum->mass *= scale;
        for (int i = 0; i < 9; i++) sum->inertia[i] *= scale;
    }
    if (sum->mass >= DAFT_SIM_MIN_MASS && sum->mass <= DAFT_SIM_MAX_MASS) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: its mass is %g kg, not within %g to %g", sum->mass,
                     DAFT_SIM_MIN_MASS, DAFT_SIM_MAX_MASS);
}

static void measure(const daft_world *world, daft_sim_body *body)
{
    body->extent = 0;
    body->inner = INFINITY;
    body->ball = false;
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = world->parts[i].next) {
        const daft_sim_part *part = &world->parts[i];
        daft_dvec3 centre = daft_rigid_to_local(&part->pose, daft_to_double(body->local_centre));
        body->extent = daft_sim_max(body->extent, daft_shape_reach(&part->shape, daft_to_float(centre)));
        body->ball |= part->shape.type == DAFT_GEOMETRY_SPHERE;
        if (!part->sensor) body->inner = daft_sim_min(body->inner, part->inner);
    }
}

bool daft_sim_body_weigh(const daft_world *world, daft_sim_body *body, daft_error *error)
{
    body->mass = body->inv_mass = 0;
    body->moments = daft_v3(0, 0, 0);
    body->axes = daft_quat_identity();
    body->local_centre = daft_v3(0, 0, 0);
    if (body->kind == DAFT_BODY_DYNAMIC) {
        daft_mass sum;
        if (!total_mass(world, body, &sum, error)) return false;
        body->mass = (float)sum.mass;
        body->inv_mass = (float)(1 / sum.mass);
        body->local_centre = daft_to_float(sum.centre);
        daft_mass_principal(sum.inertia, &body->moments, &body->axes);
        daft_vec3 m = body->moments;
        float most = daft_sim_max(m.x, daft_sim_max(m.y, m.z)), least = daft_sim_min(m.x, daft_sim_min(m.y, m.z));
        if (!(least > 1e-37f && most < 1e38f))
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "body: moments of inertia %g, %g, %g are out of range",
                             (double)m.x, (double)m.y, (double)m.z);
        body->round = most - least <= 1e-5f * most;
        if (body->round) body->moments = daft_v3(most, most, most);
    }
    measure(world, body);
    return true;
}

/* The inverse of a symmetric matrix in which the locked rows and columns are left out. */
static void locked_inverse(const double m[6], uint32_t locks, float out[6])
{
    static const int OF[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    double k[9];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            k[3 * r + c] = (locks >> r & 1) || (locks >> c & 1) ? (r == c ? 1 : 0) : m[OF[3 * r + c]];
    double c00 = k[4] * k[8] - k[5] * k[7], c01 = k[2] * k[7] - k[1] * k[8], c02 = k[1] * k[5] - k[2] * k[4];
    double det = k[0] * c00 + k[3] * c01 + k[6] * c02;
    const double inverse[9] = {c00 / det,
                               c01 / det,
                               c02 / det,
                               0,
                               (k[0] * k[8] - k[2] * k[6]) / det,
                               (k[2] * k[3] - k[0] * k[5]) / det,
                               0,
                               0,
                               (k[0] * k[4] - k[1] * k[3]) / det};
    static const int AT[6] = {0, 1, 2, 4, 5, 8};
    for (int i = 0; i < 6; i++) {
        bool locked = (locks >> (AT[i] / 3) & 1) || (locks >> (AT[i] % 3) & 1);
        out[i] = locked ? 0 : (float)inverse[AT[i]];
    }
}

void daft_sim_body_inverse_inertia(const daft_sim_body *body, const daft_rigid *frame, float out[6])
{
    for (int i = 0; i < 6; i++) out[i] = 0;
    if (body->kind != DAFT_BODY_DYNAMIC) return;
    if (body->round && !body->locks) {
        out[0] = out[3] = out[5] = 1 / body->moments.x;
        return;
    }
    const double *r = frame->m;
    double turned[9], inverse[3] = {(double)body->moments.x, (double)body->moments.y, (double)body->moments.z}, full[6];
    if (body->axes.x != 0 || body->axes.y != 0 || body->axes.z != 0) {
        daft_rigid axes = daft_rigid_make(daft_dv3(0, 0, 0), body->axes), all = daft_rigid_mul(frame, &axes);
        memcpy(turned, all.m, sizeof turned);
        r = turned;
    }
    for (int k = 0; k < 3 && !body->locks; k++) inverse[k] = 1 / inverse[k];
    for (int n = 0; n < 6; n++) {
        static const int FIRST[6] = {0, 0, 0, 3, 3, 6}, SECOND[6] = {0, 3, 6, 3, 6, 6};
        const double *a = r + FIRST[n], *b = r + SECOND[n];
        full[n] = a[0] * b[0] * inverse[0] + a[1] * b[1] * inverse[1] + a[2] * b[2] * inverse[2];
    }
    if (body->locks) {
        locked_inverse(full, body->locks, out);
        return;
    }
    for (int n = 0; n < 6; n++) out[n] = (float)full[n];
}

/* ---- slots ---- */

static bool reserve(daft_world *world, const daft_sim_body_def *def)
{
    size_t bodies = world->body_count + 1, parts = (size_t)world->part_count + def->shape_count;
    const daft_allocator *a = &world->allocator;
    daft_sim_list *list = def->kind == DAFT_BODY_DYNAMIC ? &world->awake : &world->movers;
    return bodies < INT32_MAX && parts < INT32_MAX &&
           daft_grow(a, &world->bodies, &world->body_capacity, bodies, world->body_count, sizeof *world->bodies) &&
           daft_grow(a, &world->parts, &world->part_capacity, parts, world->part_count, sizeof *world->parts) &&
           daft_sim_bounds_reserve(world, parts) &&
           daft_sim_tree_reserve(&world->trees[def->kind], a, def->shape_count) &&
           daft_sim_list_reserve(world, list, bodies) &&
           daft_grow(a, &world->scratch.island_parents, &world->scratch.island_capacity, bodies, 0,
                     sizeof *world->scratch.island_parents);
}

static uint32_t take_part(daft_world *world)
{
    uint32_t index = world->free_part;
    if (index == DAFT_SIM_NONE) return world->part_count++;
    world->free_part = world->parts[index].next;
    return index;
}

void daft_sim_part_fill(daft_sim_part *part, const daft_sim_shape_def *def, uint32_t body)
{
    daft_quat rotation = daft_quat_normalize(def->rotation);
    *part = (daft_sim_part){.shape = def->shape,
                            .place = def->position,
                            .turn = rotation,
                            .material = def->material,
                            .density = def->density,
                            .layers = def->layers,
                            .mask = def->mask,
                            .user = def->user,
                            .geometry_id = def->geometry_id,
                            .sensor = def->sensor,
                            .body = body,
                            .moved_slot = DAFT_SIM_NONE,
                            .next = DAFT_SIM_NONE};
    part->pose = daft_rigid_make(daft_to_double(def->position), rotation);
    part->posed = !daft_sim_is_zero(def->position) || rotation.x != 0 || rotation.y != 0 || rotation.z != 0;
    part->reach = daft_shape_reach(&def->shape, daft_v3(0, 0, 0));
    if (def->shape.type == DAFT_GEOMETRY_HULL) part->middle = def->shape.hull->centre;
    part->inner = daft_shape_inner_radius(&def->shape, part->middle);
    part->round = def->shape.type == DAFT_GEOMETRY_SPHERE || def->shape.type == DAFT_GEOMETRY_CAPSULE;
    part->roll = part->round                           ? def->shape.radius
                 : daft_shape_is_cylinder(&def->shape) ? def->shape.hull->cylinder
                                                       : part->inner;
}

static void add_parts(daft_world *world, daft_sim_body *body, uint32_t index, const daft_sim_body_def *def)
{
    uint32_t *link = &body->first_part;
    for (uint32_t i = 0; i < def->shape_count; i++) {
        uint32_t part = take_part(world);
        daft_sim_part_fill(&world->parts[part], &def->shapes[i], index);
        *link = part;
        link = &world->parts[part].next;
    }
}

static void free_parts(daft_world *world, daft_sim_body *body)
{
    /* The last part first, so that a body made anew takes the same slots in the same order. */
    uint32_t reversed = DAFT_SIM_NONE, next;
    for (uint32_t i = body->first_part; i != DAFT_SIM_NONE; i = next) {
        next = world->parts[i].next;
        world->parts[i].next = reversed;
        reversed = i;
    }
    for (uint32_t i = reversed; i != DAFT_SIM_NONE; i = next) {
        next = world->parts[i].next;
        world->parts[i].body = DAFT_SIM_NONE;
        world->parts[i].next = world->free_part;
        world->free_part = i;
    }
    body->first_part = DAFT_SIM_NONE;
}

static void free_body(daft_world *world, uint32_t index)
{
    free_parts(world, &world->bodies[index]);
    world->bodies[index].kind = DAFT_BODY_NONE;
    world->bodies[index].next_free = world->free_body;
    world->free_body = index;
}

static uint32_t take_body(daft_world *world, const daft_sim_body_def *def)
{
    uint32_t index = world->free_body;
    if (index == DAFT_SIM_NONE)
        index = world->body_count++;
    else
        world->free_body = world->bodies[index].next_free;
    world->bodies[index] = (daft_sim_body){.kind = def->kind,
                                           .user = def->user,
                                           .locks = def->locks & (DAFT_LOCK_ROTATION | DAFT_LOCK_POSITION),
                                           .bullet = def->bullet,
                                           .may_sleep = def->may_sleep,
                                           .gravity_scale = def->gravity_scale,
                                           .linear_damping = def->linear_damping,
                                           .angular_damping = def->angular_damping,
                                           .wanted_mass = def->mass,
                                           .substep_demand = daft_sim_substep_demand_begin(),
                                           .first_part = DAFT_SIM_NONE,
                                           .first_pair = DAFT_SIM_NONE,
                                           .first_joint = DAFT_SIM_NONE,
                                           .list_slot = DAFT_SIM_NONE,
                                           .next_free = DAFT_SIM_NONE,
                                           .ring = index};
    return index;
}

uint32_t daft_world_add(daft_world *world, const daft_sim_body_def *def, daft_error *error)
{
    if (!check_def(def, error)) return 0;
    if (!(def->mass >= 0 && def->mass <= 1e30f)) {
        daft_fail(error, DAFT_ERROR_ARGUMENT, "body: mass %g is not finite or below 0", (double)def->mass);
        return 0;
    }
    if (!reserve(world, def)) {
        daft_fail_memory(error, "a body");
        return 0;
    }
    bool appended = world->free_body == DAFT_SIM_NONE;
    uint32_t index = take_body(world, def);
    daft_sim_body *body = &world->bodies[index];
    add_parts(world, body, index, def);
    if (!daft_sim_body_weigh(world, body, error)) {
        free_body(world, index);
        if (appended) world->body_count--, world->free_body = DAFT_SIM_NONE; /* the state is as it was */
        return 0;
    }
    daft_sim_body_place(body, def->position, daft_quat_normalize(def->rotation));
    world->live_bodies++;
    daft_sim_broad_add(world, index);
    if (def->kind == DAFT_BODY_DYNAMIC) daft_sim_list_add(world, &world->awake, index);
    daft_world_set_velocity(world, index + 1, def->linear, def->angular);
    return index + 1;
}

void daft_world_remove(daft_world *world, uint32_t handle)
{
    if (!daft_sim_find(world, handle)) return;
    uint32_t index = handle - 1;
    daft_sim_body *body = &world->bodies[index];
    daft_sim_report_fill(world);
    daft_sim_wake(world, index);
    daft_sim_wake_neighbours(world, index);
    while (body->first_joint != DAFT_SIM_NONE) daft_sim_joint_remove(world, body->first_joint >> 1, true);
    daft_sim_pairs_remove(world, index);
    if (body->list_slot != DAFT_SIM_NONE)
        daft_sim_list_remove(world, body->kind == DAFT_BODY_DYNAMIC ? &world->awake : &world->movers, index);
    daft_sim_broad_remove(world, index);
    daft_sim_report_forget(world, handle);
    free_body(world, index);
    world->live_bodies--;
}

/* ---- state ---- */

uint32_t daft_world_user(const daft_world *world, uint32_t handle)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    return body ? body->user : 0;
}

float daft_world_mass(const daft_world *world, uint32_t handle)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    return body ? body->mass : 0;
}

daft_dvec3 daft_world_centre(const daft_world *world, uint32_t handle)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    return body ? body->centre : daft_dv3(0, 0, 0);
}

void daft_sim_body_place(daft_sim_body *body, daft_dvec3 position, daft_quat rotation)
{
    body->position = position;
    body->rotation = rotation;
    body->frame = daft_rigid_make(position, rotation);
    body->centre = daft_sim_is_zero(body->local_centre)
                       ? position
                       : daft_rigid_point(&body->frame, daft_to_double(body->local_centre));
}

void daft_sim_body_activate(daft_world *world, uint32_t index)
{
    daft_sim_body *body = &world->bodies[index];
    if (body->kind == DAFT_BODY_DYNAMIC) {
        daft_sim_wake(world, index);
        body->rest = 0;
    } else if (body->kind == DAFT_BODY_KINEMATIC && body->list_slot == DAFT_SIM_NONE) {
        daft_sim_list_add(world, &world->movers, index);
        daft_sim_pairs_activate(world, index);
        daft_sim_wake_neighbours(world, index);
    }
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
        daft_sim_body_activate(world, index);
        return;
    }
    daft_sim_report_fill(world);
    daft_sim_wake_neighbours(world, index);
    daft_sim_broad_remove(world, index);
    daft_sim_body_place(body, position, rotation);
    daft_sim_broad_add(world, index);
    body->has_target = false;
    daft_sim_pairs_forget(world, index);
    daft_sim_pairs_activate(world, index);
    if (body->kind == DAFT_BODY_DYNAMIC) daft_sim_body_activate(world, index);
}

void daft_world_set_velocity(daft_world *world, uint32_t handle, daft_vec3 linear, daft_vec3 angular)
{
    const daft_sim_body *found = daft_sim_find(world, handle);
    if (!found || found->kind == DAFT_BODY_STATIC || !daft_finite3(linear) || !daft_finite3(angular)) return;
    daft_sim_body *body = &world->bodies[handle - 1];
    linear = daft_sim_unlocked(body, daft_sim_clamp(linear, DAFT_SIM_MAX_SPEED), DAFT_LOCK_POSITION_X);
    angular = daft_sim_unlocked(body, daft_sim_clamp(angular, DAFT_SIM_MAX_ANGULAR_SPEED), DAFT_LOCK_X);
    bool still = daft_sim_is_zero(linear) && daft_sim_is_zero(angular);
    body->linear = linear;
    body->angular = angular;
    body->follows = false;
    if (!still || body->list_slot != DAFT_SIM_NONE) daft_sim_body_activate(world, handle - 1);
}

void daft_world_get(const daft_world *world, uint32_t handle, daft_sim_state *out)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    *out = (daft_sim_state){.rotation = daft_quat_identity()};
    if (body) *out = (daft_sim_state){body->position, body->rotation, body->linear, body->angular};
}

/* A dynamic body that may be pushed, awake from now on; or NULL. */
static daft_sim_body *pushed(daft_world *world, uint32_t handle)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    if (!body || body->kind != DAFT_BODY_DYNAMIC) return NULL;
    daft_sim_body_activate(world, handle - 1);
    return &world->bodies[handle - 1];
}

static bool is_nothing(daft_vec3 v) { return daft_sim_is_zero(v) || !daft_finite3(v); }

void daft_world_apply_force(daft_world *world, uint32_t handle, daft_vec3 force)
{
    if (is_nothing(force)) return;
    daft_sim_body *body = pushed(world, handle);
    if (body && daft_finite3(daft_add(body->force, force))) body->force = daft_add(body->force, force);
}

void daft_world_apply_torque(daft_world *world, uint32_t handle, daft_vec3 torque)
{
    if (is_nothing(torque)) return;
    daft_sim_body *body = pushed(world, handle);
    if (body && daft_finite3(daft_add(body->torque, torque))) body->torque = daft_add(body->torque, torque);
}

void daft_world_apply_impulse(daft_world *world, uint32_t handle, daft_vec3 impulse)
{
    if (is_nothing(impulse)) return;
    daft_sim_body *body = pushed(world, handle);
    if (!body) return;
    daft_vec3 change = daft_sim_clamp(daft_scale(impulse, body->inv_mass), 2 * DAFT_SIM_MAX_SPEED);
    change = daft_sim_unlocked(body, change, DAFT_LOCK_POSITION_X);
    body->linear = daft_sim_clamp(daft_add(body->linear, change), DAFT_SIM_MAX_SPEED);
}

void daft_world_apply_angular_impulse(daft_world *world, uint32_t handle, daft_vec3 impulse)
{
    if (is_nothing(impulse)) return;
    daft_sim_body *body = pushed(world, handle);
    if (!body) return;
    float m[6];
    daft_sim_body_inverse_inertia(body, &body->frame, m);
    daft_vec3 change = daft_v3(m[0] * impulse.x + m[1] * impulse.y + m[2] * impulse.z,
                               m[1] * impulse.x + m[3] * impulse.y + m[4] * impulse.z,
                               m[2] * impulse.x + m[4] * impulse.y + m[5] * impulse.z);
    change = daft_sim_clamp(change, 2 * DAFT_SIM_MAX_ANGULAR_SPEED);
    body->angular = daft_sim_clamp(daft_add(body->angular, change), DAFT_SIM_MAX_ANGULAR_SPEED);
}

void daft_world_apply_impulse_at(daft_world *world, uint32_t handle, daft_vec3 impulse, daft_dvec3 point)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    if (!body || !daft_dfinite3(point) || is_nothing(impulse)) return;
    daft_vec3 arm = daft_sim_clamp(daft_to_float(daft_dsub(point, body->centre)), DAFT_SHAPE_MAX_SIZE);
    daft_world_apply_impulse(world, handle, impulse);
    daft_world_apply_angular_impulse(world, handle, daft_cross(arm, impulse));
}

/* ---- changes ---- */

void daft_world_set_awake(daft_world *world, uint32_t handle, bool awake)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    if (!body || body->kind != DAFT_BODY_DYNAMIC) return;
    if (awake)
        daft_sim_body_activate(world, handle - 1);
    else if (!body->asleep)
        daft_sim_sleep_island(world, handle - 1);
}

bool daft_world_is_awake(const daft_world *world, uint32_t handle)
{
    const daft_sim_body *body = daft_sim_find(world, handle);
    return body && daft_sim_is_active(body);
}

void daft_world_set_filter(daft_world *world, uint32_t handle, uint32_t layers, uint32_t mask)
{
    if (!daft_sim_find(world, handle)) return;
    uint32_t index = handle - 1;
    daft_sim_report_fill(world);
    daft_sim_wake_neighbours(world, index);
    daft_sim_pairs_remove(world, index);
    for (uint32_t i = world->bodies[index].first_part; i != DAFT_SIM_NONE; i = world->parts[i].next)
        world->parts[i].layers = layers, world->parts[i].mask = mask;
    daft_sim_broad_remove(world, index);
    daft_sim_broad_add(world, index);
    if (world->bodies[index].kind == DAFT_BODY_DYNAMIC) daft_sim_body_activate(world, index);
}
