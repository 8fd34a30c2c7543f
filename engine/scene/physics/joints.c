/* Joints between entities' bodies: handles here, the rest in sim/, whose joints carry the handle. */
#include "scene/scene.h"

daft_joint_def daft_default_joint_def(void)
{
    daft_joint_def def;
    daft_struct_default(DAFT_STRUCT_JOINT_DEF, &def);
    return def;
}

static uint32_t joint_find(const daft_scene *scene, daft_joint joint, daft_error *error)
{
    if (!daft_check_pointer(error, "scene", scene)) return DAFT_NONE;
    uint32_t index = daft_slots_find(&scene->joint_slots, joint.id);
    if (index != DAFT_NONE) return index;
    if (joint.id == 0)
        daft_fail(error, DAFT_ERROR_HANDLE, "the joint is none (0)");
    else
        daft_fail(error, DAFT_ERROR_HANDLE, "joint 0x%x is stale: it was destroyed, broke or went with a body",
                  joint.id);
    return DAFT_NONE;
}

static uint32_t joint_change(const daft_scene *scene, daft_joint joint, daft_error *error)
{
    return daft_scene_ready(scene, error) ? joint_find(scene, joint, error) : DAFT_NONE;
}

/* 0, with a message, where the entity has no body. */
static uint32_t body_of(daft_scene *scene, daft_entity entity, const char *name, daft_error *error)
{
    const daft_entity_item *item = daft_entity_find(scene, entity, error);
    if (item && !item->body) daft_fail(error, DAFT_ERROR_ARGUMENT, "%s: the entity has no body", name);
    return item ? item->body : 0;
}

static bool joints_reserve(daft_scene *scene, daft_error *error)
{
    uint32_t needed = daft_slots_needed(&scene->joint_slots, 1);
    if (needed > DAFT_MAX_SLOTS)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a scene holds at most %d joints", DAFT_MAX_SLOTS);
    return (daft_slots_reserve(&scene->joint_slots, scene->allocator, 1) &&
            daft_grow(scene->allocator, &scene->joints, &scene->joint_capacity, needed, scene->joint_slots.count,
                      sizeof *scene->joints)) ||
           daft_fail_memory(error, "the list of joints");
}

daft_joint daft_joint_create(daft_scene *scene, const daft_joint_def *def, daft_error *error)
{
    const daft_joint none = {0};
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "def", def) ||
        !daft_struct_check(DAFT_STRUCT_JOINT_DEF, def, error) || !joints_reserve(scene, error))
        return none;
    daft_sim_joint_def sim = daft_default_sim_joint_def();
    sim.kind = def->kind;
    if (def->a.id && !(sim.body_a = body_of(scene, def->a, "a", error))) return none;
    if (!(sim.body_b = body_of(scene, def->b, "b", error))) return none;
    sim.anchor = def->anchor, sim.anchor_b = def->anchor_b, sim.axis = def->axis;
    sim.limit = def->limit, sim.lower = def->lower, sim.upper = def->upper;
    sim.motor = def->motor, sim.motor_speed = def->motor_speed, sim.motor_force = def->motor_force;
    sim.spring = def->spring, sim.hertz = def->hertz, sim.damping = def->damping, sim.length = def->length;
    sim.break_force = def->break_force, sim.break_torque = def->break_torque, sim.collide = def->collide;
    daft_joint joint = {daft_slots_add(&scene->joint_slots)};
    sim.user = joint.id;
    uint32_t index = daft_handle_index(joint.id), made = daft_world_add_joint(scene->world, &sim, error);
    if (!made) {
        daft_slots_remove(&scene->joint_slots, index);
        return none;
    }
    scene->joints[index] = (daft_joint_item){def->a, def->b, made};
    return joint;
}

bool daft_joint_destroy(daft_scene *scene, daft_joint joint, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = joint_change(scene, joint, error);
    if (index == DAFT_NONE) return false;
    daft_world_remove_joint(scene->world, scene->joints[index].joint);
    daft_slots_remove(&scene->joint_slots, index);
    return true;
}

bool daft_joint_is_valid(const daft_scene *scene, daft_joint joint)
{
    return scene && daft_slots_find(&scene->joint_slots, joint.id) != DAFT_NONE;
}

bool daft_joint_get(daft_scene *scene, daft_joint joint, daft_joint_state *out, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = joint_find(scene, joint, error);
    if (index == DAFT_NONE || !daft_check_pointer(error, "out", out)) return false;
    daft_sim_joint_state s;
    const daft_joint_item *item = &scene->joints[index];
    if (!daft_world_get_joint(scene->world, item->joint, &s))
        return daft_fail(error, DAFT_ERROR_HANDLE, "the joint is gone");
    *out = (daft_joint_state){.kind = s.kind,
                              .a = item->a,
                              .b = item->b,
                              .anchor_a = s.anchor_a,
                              .anchor_b = s.anchor_b,
                              .value = s.value,
                              .speed = s.speed,
                              .force = s.force,
                              .torque = s.torque};
    return true;
}

bool daft_joint_set_motor(daft_scene *scene, daft_joint joint, bool on, float speed, float force, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = joint_change(scene, joint, error);
    if (index == DAFT_NONE || !daft_check_finite(error, "speed", (double)speed) ||
        !daft_check_range(error, "force", (double)force, 0, DAFT_ANY_FLOAT, "finite and 0 or more"))
        return false;
    daft_world_set_joint_motor(scene->world, scene->joints[index].joint, on, speed, force);
    return true;
}

bool daft_joint_set_limit(daft_scene *scene, daft_joint joint, bool on, float lower, float upper, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = joint_change(scene, joint, error);
    if (index == DAFT_NONE || !daft_check_finite(error, "lower", (double)lower) ||
        !daft_check_range(error, "upper", (double)upper, (double)lower, DAFT_ANY_FLOAT, "finite and not below lower"))
        return false;
    daft_world_set_joint_limit(scene->world, scene->joints[index].joint, on, lower, upper);
    return true;
}

bool daft_joint_set_spring(daft_scene *scene, daft_joint joint, bool on, float hertz, float damping, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = joint_change(scene, joint, error);
    if (index == DAFT_NONE ||
        !daft_check_range(error, "hertz", (double)hertz, 0, DAFT_ANY_FLOAT, "finite and 0 or more") ||
        !daft_check_range(error, "damping", (double)damping, 0, DAFT_ANY_FLOAT, "finite and 0 or more"))
        return false;
    daft_world_set_joint_spring(scene->world, scene->joints[index].joint, on, hertz, damping);
    return true;
}

bool daft_joint_set_target(daft_scene *scene, daft_joint joint, daft_dvec3 target, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = joint_change(scene, joint, error);
    if (index == DAFT_NONE || !daft_body_check_position(target, error)) return false;
    daft_world_set_joint_target(scene->world, scene->joints[index].joint, target);
    return true;
}

/* ---- what goes by itself ---- */

void daft_joints_forget(daft_scene *scene, daft_entity entity)
{
    for (uint32_t i = 0; scene->joint_slots.live && i < scene->joint_slots.count; i++) {
        const daft_joint_item *item = &scene->joints[i];
        if (scene->joint_slots.items[i].live && (item->a.id == entity.id || item->b.id == entity.id))
            daft_slots_remove(&scene->joint_slots, i);
    }
}

void daft_joints_sweep(daft_scene *scene)
{
    const daft_sim_event *events;
    uint32_t count = scene->joint_slots.live ? daft_world_events(scene->world, &events) : 0;
    for (uint32_t i = 0; i < count; i++) {
        if (events[i].kind != DAFT_SIM_JOINT_BREAK && events[i].kind != DAFT_SIM_JOINT_GONE) continue;
        uint32_t index = daft_slots_find(&scene->joint_slots, events[i].joint_user);
        if (index != DAFT_NONE) daft_slots_remove(&scene->joint_slots, index);
    }
}
