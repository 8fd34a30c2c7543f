/* Joints: making, querying and destroying them. What they do to bodies is in joint_kernel.c. */
#include "sim/world.h"
#include "sim/broad/broad.h"
#include "sim/contact/contact.h"
#include "sim/events.h"
#include "sim/joint/joint.h"

#include "math/trig.h"

daft_sim_joint_def daft_default_sim_joint_def(void)
{
    return (daft_sim_joint_def){
        .kind = DAFT_JOINT_BALL, .axis = {0, 1, 0}, .hertz = 2, .damping = 0.7f, .collide = false};
}

/* ---- checks ---- */

#define MOST 1e30f

static bool check_numbers(const daft_sim_joint_def *d, daft_error *error)
{
    const struct {
        const char *name;
        float value, low, high;
    } all[] = {{"lower", d->lower, -1e7f, 1e7f},
               {"upper", d->upper, -1e7f, 1e7f},
               {"motor speed", d->motor_speed, -1e6f, 1e6f},
               {"motor force", d->motor_force, 0, MOST},
               {"hertz", d->hertz, 0, 1e6f},
               {"damping", d->damping, 0, 1e6f},
               {"length", d->length, 0, 1e7f},
               {"break force", d->break_force, 0, MOST},
               {"break torque", d->break_torque, 0, MOST}};
    for (size_t i = 0; i < DAFT_COUNT_OF(all); i++)
        if (!(all[i].value >= all[i].low && all[i].value <= all[i].high))
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: %s %g is not within %g to %g", all[i].name,
                             (double)all[i].value, (double)all[i].low, (double)all[i].high);
    if (d->limit && d->lower > d->upper)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: lower %g is above upper %g", (double)d->lower,
                         (double)d->upper);
    return true;
}

static bool far(daft_dvec3 p)
{
    return !(fabs(p.x) <= DAFT_SIM_MAX_DISTANCE && fabs(p.y) <= DAFT_SIM_MAX_DISTANCE &&
             fabs(p.z) <= DAFT_SIM_MAX_DISTANCE);
}

static bool check_places(const daft_sim_joint_def *d, daft_error *error)
{
    if (far(d->anchor) || far(d->anchor_b))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: an anchor is not finite, or too far away");
    float length = daft_length(d->axis);
    if (d->kind == DAFT_JOINT_HINGE || d->kind == DAFT_JOINT_SLIDER || (d->kind == DAFT_JOINT_BALL && d->limit))
        if (!(length > 1e-6f && length < 1e15f))
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: its axis (%g, %g, %g) has no direction",
                             (double)d->axis.x, (double)d->axis.y, (double)d->axis.z);
    return true;
}

static bool check_def(const daft_world *world, const daft_sim_joint_def *d, daft_error *error)
{
    if (d->kind < DAFT_JOINT_BALL || d->kind > DAFT_JOINT_DRAG)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: %d is no kind of joint", (int)d->kind);
    const daft_sim_body *a = daft_sim_find(world, d->body_a), *b = daft_sim_find(world, d->body_b);
    if ((d->body_a && !a) || !b)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: there is no body %u",
                         d->body_a && !a ? d->body_a : d->body_b);
    if (a == b) return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: both its bodies are body %u", d->body_a);
    if (d->kind == DAFT_JOINT_DRAG && a)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: a drag's body_a must be 0, the world");
    if (!(a && a->kind == DAFT_BODY_DYNAMIC) && b->kind != DAFT_BODY_DYNAMIC)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "joint: one of its bodies must be dynamic");
    return check_places(d, error) && check_numbers(d, error);
}

/* ---- making ---- */

/* A rotation that takes x to the axis. */
static daft_quat frame_along(daft_vec3 axis)
{
    axis = daft_normalize(axis);
    if (axis.x < -0.9999f) return (daft_quat){0, 0, 1, 0};
    return daft_quat_normalize((daft_quat){0, -axis.z, axis.y, 1 + axis.x});
}

static daft_quat conjugate(daft_quat q) { return (daft_quat){-q.x, -q.y, -q.z, q.w}; }

static void link_joint(daft_world *world, uint32_t index, int side)
{
    daft_sim_joint *joint = &world->joints[index];
    joint->next[side] = joint->previous[side] = DAFT_SIM_NONE;
    if (joint->body[side] == DAFT_SIM_NONE) return;
    daft_sim_body *body = &world->bodies[joint->body[side]];
    uint32_t edge = index << 1 | (uint32_t)side, first = body->first_joint;
    joint->next[side] = first;
    if (first != DAFT_SIM_NONE) world->joints[first >> 1].previous[first & 1] = edge;
    body->first_joint = edge;
}

static void unlink_joint(daft_world *world, uint32_t index, int side)
{
    daft_sim_joint *joint = &world->joints[index];
    if (joint->body[side] == DAFT_SIM_NONE) return;
    uint32_t next = joint->next[side], previous = joint->previous[side];
    if (next != DAFT_SIM_NONE) world->joints[next >> 1].previous[next & 1] = previous;
    if (previous != DAFT_SIM_NONE)
        world->joints[previous >> 1].next[previous & 1] = next;
    else
        world->bodies[joint->body[side]].first_joint = next;
}

/* The bodies that joints keep one from touching: pairs are asked for them all the time, and most are made one after
 * another. */
static void set_joined(daft_world *world, uint32_t index)
{
    if (index == DAFT_SIM_NONE) return;
    daft_sim_body *body = &world->bodies[index];
    body->joined = 0;
    body->joined_far = false;
    for (uint32_t e = body->first_joint; e != DAFT_SIM_NONE; e = world->joints[e >> 1].next[e & 1]) {
        const daft_sim_joint *joint = &world->joints[e >> 1];
        uint32_t other = joint->body[(e & 1) ^ 1], places = other > index ? other - index : index - other;
        if (joint->collide || other == DAFT_SIM_NONE) continue;
        if (places > DAFT_SIM_JOINED_PLACES)
            body->joined_far = true;
        else if (other > index)
            body->joined |= (uint64_t)1 << (places - 1);
    }
    daft_sim_groups_joined(world, index);
}

void daft_sim_joint_link(daft_world *world, uint32_t joint_index)
{
    link_joint(world, joint_index, 0);
    link_joint(world, joint_index, 1);
    for (int side = 0; side < 2; side++) set_joined(world, world->joints[joint_index].body[side]);
}

static bool reserve_joints(daft_world *world, size_t more)
{
    size_t needed = (size_t)world->joint_count + more;
    return needed < INT32_MAX && daft_grow(&world->allocator, &world->joints, &world->joint_capacity, needed,
                                           world->joint_count, sizeof *world->joints);
}

/* Room was reserved. */
static uint32_t insert_joint(daft_world *world, const daft_sim_joint *joint)
{
    uint32_t index = world->free_joint;
    if (index == DAFT_SIM_NONE)
        index = world->joint_count++;
    else
        world->free_joint = world->joints[index].next[0];
    world->joints[index] = *joint;
    daft_sim_joint_link(world, index);
    world->live_joints++;
    return index;
}

static void place_side(const daft_world *world, daft_sim_joint *joint, int side, uint32_t handle, daft_dvec3 anchor,
                       daft_quat frame)
{
    joint->body[side] = handle ? handle - 1 : DAFT_SIM_NONE;
    joint->frame[side] = frame;
    if (!handle) {
        joint->fixed = anchor;
        return;
    }
    const daft_sim_body *body = &world->bodies[handle - 1];
    daft_quat back = conjugate(body->rotation);
    joint->frame[side] = daft_quat_normalize(daft_quat_mul(back, frame));
    joint->anchor[side] = daft_quat_rotate(back, daft_to_float(daft_dsub(anchor, body->centre)));
}

static void forget_pairs(daft_world *world, const daft_sim_joint *joint)
{
    if (joint->collide || joint->body[0] == DAFT_SIM_NONE) return;
    daft_sim_report_fill(world);
    bool any = true;
    while (any) {
        any = false;
        for (uint32_t e = world->bodies[joint->body[0]].first_pair; e != DAFT_SIM_NONE && !any;
             e = world->pairs[e >> 1].next[e & 1]) {
            const daft_sim_pair *pair = &world->pairs[e >> 1];
            uint32_t other = e & 1 ? pair->body_a : pair->body_b;
            if (other != joint->body[1] || pair->sensor) continue;
            daft_sim_pair_drop(world, e >> 1);
            any = true;
        }
    }
}

uint32_t daft_world_add_joint(daft_world *world, const daft_sim_joint_def *d, daft_error *error)
{
    if (!check_def(world, d, error)) return 0;
    if (!reserve_joints(world, 1)) {
        daft_fail_memory(error, "a joint");
        return 0;
    }
    daft_sim_joint joint = {.kind = d->kind,
                            .limit = d->limit,
                            .motor = d->motor,
                            .spring = d->spring || d->kind == DAFT_JOINT_DRAG,
                            .collide = d->collide,
                            .lower = d->lower,
                            .upper = d->upper,
                            .motor_speed = d->motor_speed,
                            .motor_force = d->motor_force,
                            .hertz = d->hertz,
                            .damping = d->damping,
                            .length = d->length,
                            .break_force = d->break_force,
                            .break_torque = d->break_torque,
                            .user = d->user};
    bool two = d->kind == DAFT_JOINT_DISTANCE, drag = d->kind == DAFT_JOINT_DRAG;
    bool directed = d->kind == DAFT_JOINT_HINGE || d->kind == DAFT_JOINT_SLIDER || d->kind == DAFT_JOINT_BALL;
    daft_quat frame = directed && daft_length(d->axis) > 1e-6f ? frame_along(d->axis) : daft_quat_identity();
    place_side(world, &joint, 0, d->body_a, drag ? d->anchor_b : d->anchor, frame);
    place_side(world, &joint, 1, d->body_b, two ? d->anchor_b : d->anchor, frame);
    daft_dvec3 apart = daft_dsub(d->anchor_b, d->anchor);
    if (two && joint.length == 0) joint.length = (float)sqrt(daft_ddot(apart, apart));
    uint32_t index = insert_joint(world, &joint);
    forget_pairs(world, &joint);
    for (int side = 0; side < 2; side++)
        if (joint.body[side] != DAFT_SIM_NONE && world->bodies[joint.body[side]].kind == DAFT_BODY_DYNAMIC)
            daft_sim_body_activate(world, joint.body[side]);
    return index + 1;
}

/* ---- taking away ---- */

static void wake_ends(daft_world *world, const daft_sim_joint *joint)
{
    for (int side = 0; side < 2; side++)
        if (joint->body[side] != DAFT_SIM_NONE && world->bodies[joint->body[side]].kind == DAFT_BODY_DYNAMIC)
            daft_sim_body_activate(world, joint->body[side]);
}

void daft_sim_joint_remove(daft_world *world, uint32_t joint_index, bool event)
{
    daft_sim_joint *joint = &world->joints[joint_index];
    if (event) daft_sim_event_joint(world, DAFT_SIM_JOINT_GONE, joint_index, 0);
    wake_ends(world, joint);
    unlink_joint(world, joint_index, 0);
    unlink_joint(world, joint_index, 1);
    for (int side = 0; side < 2; side++) set_joined(world, joint->body[side]);
    joint->kind = 0;
    joint->next[0] = world->free_joint;
    world->free_joint = joint_index;
    world->live_joints--;
}

static daft_sim_joint *find_joint(const daft_world *world, uint32_t handle)
{
    if (handle == 0 || handle > world->joint_count || world->joints[handle - 1].kind == 0) return NULL;
    return &world->joints[handle - 1];
}

void daft_world_remove_joint(daft_world *world, uint32_t handle)
{
    if (find_joint(world, handle)) daft_sim_joint_remove(world, handle - 1, false);
}

void daft_sim_joints_break(daft_world *world)
{
    for (uint32_t index = 0; world->live_joints > 0 && index < world->joint_count; index++) {
        const daft_sim_joint *j = &world->joints[index];
        if (j->kind == 0) continue;
        bool force = j->break_force > 0 && j->force > j->break_force;
        bool torque = j->break_torque > 0 && j->torque > j->break_torque;
        if (!force && !torque) continue;
        daft_sim_event_joint(world, DAFT_SIM_JOINT_BREAK, index, force ? j->force : j->torque);
        daft_sim_joint_remove(world, index, false);
    }
}

/* ---- asking and setting ---- */

/* Within ±pi. */
static float hinge_angle(const daft_quat frame[2])
{
    daft_quat a = frame[0], d = daft_quat_mul((daft_quat){-a.x, -a.y, -a.z, a.w}, frame[1]);
    double sign = d.w < 0 ? -1 : 1;
    return (float)(2 * daft_atan2(sign * (double)d.x, sign * (double)d.w));
}

/* Angle, displacement or length now; its anchors in the world. */
static float value_of(const daft_world *world, const daft_sim_joint *j, daft_dvec3 at[2])
{
    daft_quat frame[2];
    for (int i = 0; i < 2; i++) {
        frame[i] = j->frame[i];
        at[i] = j->fixed;
        if (j->body[i] == DAFT_SIM_NONE) continue;
        const daft_sim_body *body = &world->bodies[j->body[i]];
        at[i] = daft_dadd(body->centre, daft_to_double(daft_quat_rotate(body->rotation, j->anchor[i])));
        frame[i] = daft_quat_mul(body->rotation, j->frame[i]);
    }
    daft_vec3 offset = daft_to_float(daft_dsub(at[1], at[0])), axis = daft_quat_rotate(frame[0], daft_v3(1, 0, 0));
    if (j->kind == DAFT_JOINT_HINGE) return hinge_angle(frame);
    if (j->kind == DAFT_JOINT_SLIDER) return daft_dot(offset, axis);
    if (j->kind != DAFT_JOINT_BALL) return daft_length(offset);
    daft_vec3 other = daft_quat_rotate(frame[1], daft_v3(1, 0, 0));
    return (float)daft_atan2((double)daft_length(daft_cross(axis, other)), (double)daft_dot(axis, other));
}

bool daft_world_get_joint(const daft_world *world, uint32_t handle, daft_sim_joint_state *out)
{
    *out = (daft_sim_joint_state){0};
    const daft_sim_joint *j = find_joint(world, handle);
    if (!j) return false;
    daft_dvec3 at[2];
    out->value = value_of(world, j, at);
    out->anchor_a = at[0], out->anchor_b = at[1];
    out->kind = j->kind;
    out->user = j->user;
    out->body_a = j->body[0] + 1, out->body_b = j->body[1] + 1; /* none is the largest number: + 1 is 0 */
    out->force = j->force, out->torque = j->torque;
    daft_vec3 v[2], w[2], axis = daft_v3(0, 0, 0);
    for (int i = 0; i < 2; i++) {
        v[i] = w[i] = daft_v3(0, 0, 0);
        daft_quat frame = j->frame[i];
        if (j->body[i] != DAFT_SIM_NONE) {
            const daft_sim_body *body = &world->bodies[j->body[i]];
            daft_vec3 arm = daft_to_float(daft_dsub(at[1], body->centre));
            v[i] = daft_add(body->linear, daft_cross(body->angular, arm));
            w[i] = body->angular;
            frame = daft_quat_mul(body->rotation, frame);
        }
        if (i == 0) axis = daft_quat_rotate(frame, daft_v3(1, 0, 0));
    }
    if (j->kind == DAFT_JOINT_HINGE) out->speed = daft_dot(daft_sub(w[1], w[0]), axis);
    if (j->kind == DAFT_JOINT_SLIDER) out->speed = daft_dot(daft_sub(v[1], v[0]), axis);
    return true;
}

void daft_world_set_joint_motor(daft_world *world, uint32_t handle, bool on, float speed, float force)
{
    daft_sim_joint *j = find_joint(world, handle);
    if (!j || !(fabsf(speed) <= 1e6f) || !(force >= 0 && force <= MOST)) return;
    if (j->motor == on && j->motor_speed == speed && j->motor_force == force) return;
    j->motor = on, j->motor_speed = speed, j->motor_force = force;
    if (!on) j->motor_impulse = 0;
    if (!on && j->kind == DAFT_JOINT_BALL) j->angular_impulse = daft_v3(0, 0, 0);
    wake_ends(world, j);
}

void daft_world_set_joint_limit(daft_world *world, uint32_t handle, bool on, float lower, float upper)
{
    daft_sim_joint *j = find_joint(world, handle);
    if (!j || !(lower <= upper && lower >= -1e7f && upper <= 1e7f)) return;
    j->limit = on, j->lower = lower, j->upper = upper;
    j->lower_impulse = j->upper_impulse = 0;
    wake_ends(world, j);
}

void daft_world_set_joint_spring(daft_world *world, uint32_t handle, bool on, float hertz, float damping)
{
    daft_sim_joint *j = find_joint(world, handle);
    if (!j || !(hertz >= 0 && hertz <= 1e6f) || !(damping >= 0 && damping <= 1e6f)) return;
    j->spring = on || j->kind == DAFT_JOINT_DRAG, j->hertz = hertz, j->damping = damping;
    j->spring_impulse = 0;
    wake_ends(world, j);
}

void daft_world_set_joint_target(daft_world *world, uint32_t handle, daft_dvec3 target)
{
    daft_sim_joint *j = find_joint(world, handle);
    if (!j || j->kind != DAFT_JOINT_DRAG || far(target)) return;
    j->fixed = target;
    wake_ends(world, j);
}
