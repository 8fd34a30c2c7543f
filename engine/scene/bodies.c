/* Entities in the simulation: sim/ knows shapes and numbers, here they meet. A body carries its entity's handle. */
#include "scene/scene.h"

static const char *const KINDS[] = {"none", "static", "kinematic", "dynamic"};

static bool material_check(const daft_entity_def *def, daft_error *error)
{
    return daft_check_range(error, "density", (double)def->density, DAFT_ABOVE_ZERO, DAFT_ANY_FLOAT,
                            "finite and above 0") &&
           daft_check_range(error, "friction", (double)def->friction, 0, DAFT_ANY_FLOAT, "finite and 0 or more") &&
           daft_check_range(error, "restitution", (double)def->restitution, 0, 1, "between 0 and 1") &&
           daft_check_range(error, "rolling_resistance", (double)def->rolling_resistance, 0, DAFT_ANY_FLOAT,
                            "finite and 0 or more");
}

bool daft_body_check(const daft_entity_def *def, daft_error *error)
{
    if (!material_check(def, error)) return false;
    if (def->body == DAFT_BODY_NONE) return true;
    if ((unsigned)def->body > DAFT_BODY_DYNAMIC)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body is %d; it must be none, static, kinematic or dynamic",
                         (int)def->body);
    const char *kind = KINDS[def->body];
    if (def->shape != DAFT_SHAPE_SPHERE && def->shape != DAFT_SHAPE_BOX)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body is %s but the shape is %s; a body must be a sphere or a box",
                         kind, def->shape == DAFT_SHAPE_MESH ? "a mesh" : "none");
    if (def->parent.id)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body is %s but the entity has a parent; a body must have none",
                         kind);
    if (!daft_body_check_position(def->position, error)) return false;
    if (def->scale.x != 1 || def->scale.y != 1 || def->scale.z != 1)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "scale is %g, %g, %g; a body's must be 1, 1, 1: size it by its %s",
                         (double)def->scale.x, (double)def->scale.y, (double)def->scale.z,
                         def->shape == DAFT_SHAPE_SPHERE ? "radius" : "size");
    return true;
}

bool daft_body_moves(daft_body_kind kind) { return kind == DAFT_BODY_DYNAMIC || kind == DAFT_BODY_KINEMATIC; }

/* Beyond 1e12 m even doubles are coarser than 0.1 mm, and sim/ takes no such body. */
bool daft_body_check_position(daft_dvec3 position, daft_error *error)
{
    const char *allowed = "between -1e12 and 1e12 metres for a body";
    return daft_check_range(error, "position.x", position.x, -1e12, 1e12, allowed) &&
           daft_check_range(error, "position.y", position.y, -1e12, 1e12, allowed) &&
           daft_check_range(error, "position.z", position.z, -1e12, 1e12, allowed);
}

static bool shape_of(const daft_entity_def *def, daft_sim_shape *out, daft_error *error)
{
    if (def->shape == DAFT_SHAPE_SPHERE) return daft_shape_sphere(def->radius, out, error);
    return daft_shape_box(daft_scale(def->size, 0.5f), out, error);
}

bool daft_scene_need_world(daft_scene *scene, daft_error *error)
{
    if (scene->world) return true;
    scene->world = daft_world_create(scene->allocator, error);
    if (!scene->world) return false;
    daft_world_set_gravity(scene->world, scene->gravity);
    daft_world_set_workers(scene->world, scene->engine->threads, scene->engine->isa);
    return true;
}

bool daft_body_create(daft_scene *scene, const daft_entity_def *def, uint32_t entity, uint32_t *body, daft_error *error)
{
    *body = 0;
    if (def->body == DAFT_BODY_NONE) return true;
    if (!daft_scene_need_world(scene, error)) return false;
    daft_sim_shape_def shape = daft_default_sim_shape_def();
    if (!shape_of(def, &shape.shape, error)) return false;
    shape.density = def->density;
    shape.material.friction = def->friction;
    shape.material.restitution = def->restitution;
    shape.material.rolling_resistance = def->rolling_resistance;
    daft_sim_body_def sim = daft_default_sim_body_def();
    sim.kind = def->body;
    sim.position = def->position;
    sim.rotation = def->rotation;
    sim.shapes = &shape;
    sim.shape_count = 1;
    sim.user = entity;
    *body = daft_world_add(scene->world, &sim, error);
    return *body != 0;
}

void daft_body_destroy(daft_scene *scene, daft_entity_item *item)
{
    if (!item->body) return;
    daft_world_remove(scene->world, item->body);
    if (!daft_body_moves(item->def.body)) return;
    uint32_t moved = scene->moving[--scene->moving_count];
    scene->moving[item->moving_slot] = moved;
    scene->entities[moved].moving_slot = item->moving_slot;
}

/* ---- velocities, forces ---- */

/* Finds an entity whose body is of `least` kind or of one that obeys more: static, kinematic, dynamic. */
static daft_entity_item *body_find(daft_scene *scene, daft_entity entity, daft_body_kind least, daft_error *error)
{
    daft_entity_item *item = daft_entity_find(scene, entity, error);
    if (!item || (item->body && item->def.body >= least)) return item;
    if (!item->body)
        daft_fail(error, DAFT_ERROR_ARGUMENT, "the entity has no body");
    else
        daft_fail(error, DAFT_ERROR_ARGUMENT, "the entity's body is %s; it must be %s", KINDS[item->def.body],
                  least == DAFT_BODY_DYNAMIC ? "dynamic" : "dynamic or kinematic");
    return NULL;
}

bool daft_entity_get_velocity(daft_scene *scene, daft_entity entity, daft_vec3 *linear, daft_vec3 *angular,
                              daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_find(scene, entity, DAFT_BODY_STATIC, error);
    if (!item) return false;
    daft_sim_state state;
    daft_world_get(scene->world, item->body, &state);
    if (linear) *linear = state.linear;
    if (angular) *angular = state.angular;
    return true;
}

bool daft_entity_set_velocity(daft_scene *scene, daft_entity entity, daft_vec3 linear, daft_vec3 angular,
                              daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_find(scene, entity, DAFT_BODY_KINEMATIC, error);
    if (!item || !daft_check_finite3(error, "linear", linear) || !daft_check_finite3(error, "angular", angular))
        return false;
    daft_world_set_velocity(scene->world, item->body, linear, angular);
    return true;
}

bool daft_entity_apply_force(daft_scene *scene, daft_entity entity, daft_vec3 force, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_find(scene, entity, DAFT_BODY_DYNAMIC, error);
    if (!item || !daft_check_finite3(error, "force", force)) return false;
    daft_world_apply_force(scene->world, item->body, force);
    return true;
}

bool daft_entity_apply_impulse(daft_scene *scene, daft_entity entity, daft_vec3 impulse, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_find(scene, entity, DAFT_BODY_DYNAMIC, error);
    if (!item || !daft_check_finite3(error, "impulse", impulse)) return false;
    daft_world_apply_impulse(scene->world, item->body, impulse);
    return true;
}

/* ---- time ---- */

void daft_scene_set_gravity(daft_scene *scene, daft_vec3 gravity)
{
    daft_error error;
    if (!daft_check_finite3(&error, "gravity", gravity)) {
        daft_warn_at(&scene->engine->log, error.code, NULL, 0, 0, "gravity is left as it was: %s", error.message);
        return;
    }
    scene->gravity = gravity;
    if (scene->world) daft_world_set_gravity(scene->world, gravity);
}

/* Poses of the last tick are kept lazily: the first change of an entity in a tick remembers the pose before it. */
void daft_scene_begin_tick(daft_scene *scene)
{
    scene->tick++;
    scene->camera_before = scene->camera;
}

static bool same_pose(const daft_transform *a, const daft_sim_state *b)
{
    return a->position.x == b->position.x && a->position.y == b->position.y && a->position.z == b->position.z &&
           a->rotation.x == b->rotation.x && a->rotation.y == b->rotation.y && a->rotation.z == b->rotation.z &&
           a->rotation.w == b->rotation.w;
}

static void pull_poses(daft_scene *scene)
{
    for (uint32_t i = 0; i < scene->moving_count; i++) {
        daft_entity_item *item = &scene->entities[scene->moving[i]];
        daft_sim_state state;
        daft_world_get(scene->world, item->body, &state);
        if (same_pose(&item->now, &state)) continue;
        if (item->moved_tick != scene->tick) item->before = item->now;
        item->moved_tick = scene->tick;
        item->now.position = state.position;
        item->now.rotation = state.rotation;
        scene->revision++;
    }
}

bool daft_scene_step(daft_scene *scene, float dt, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) ||
        !daft_check_range(error, "dt", (double)dt, DAFT_ABOVE_ZERO, 1, "above 0 and at most 1 (seconds)"))
        return false;
    if (!scene->world) return true;
    if (!daft_world_step(scene->world, dt, error)) return false;
    pull_poses(scene);
    return daft_characters_step(scene, dt, error);
}

/* Contacts of entities that were destroyed since the tick are left out. */
uint32_t daft_scene_contacts(const daft_scene *scene, daft_contact *out, uint32_t capacity)
{
    if (!scene->world) return 0;
    const daft_sim_contact *contacts;
    uint32_t all = daft_world_contacts(scene->world, &contacts), count = 0;
    for (uint32_t i = 0; i < all; i++) {
        const daft_sim_contact *from = &contacts[i];
        daft_entity a = {from->user_a}, b = {from->user_b};
        if (!daft_entity_is_valid(scene, a) || !daft_entity_is_valid(scene, b)) continue;
        if (out && count < capacity) out[count] = (daft_contact){a, b, from->point, from->normal, from->impulse};
        count++;
    }
    return count;
}
