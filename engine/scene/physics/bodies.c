/* Entities as bodies: sim/ knows bodies by number, scene/ entities by handle; a body carries its entity's handle. */
#include "scene/scene.h"

static const char *const KINDS[] = {"none", "static", "kinematic", "dynamic"};

static bool scale_check(const daft_entity_def *def, daft_error *error)
{
    bool round = def->shape == DAFT_SHAPE_SPHERE,
         unscaled = def->scale.x == 1 && def->scale.y == 1 && def->scale.z == 1;
    if (unscaled || (!round && def->shape != DAFT_SHAPE_BOX)) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "scale is %g, %g, %g; a body's must be 1, 1, 1: size it by its %s",
                     (double)def->scale.x, (double)def->scale.y, (double)def->scale.z, round ? "radius" : "size");
}

bool daft_body_check(const daft_entity_def *def, daft_error *error)
{
    if (def->body == DAFT_BODY_NONE) return true;
    const char *kind = KINDS[def->body];
    if (def->collider_count == 0 && def->shape == DAFT_SHAPE_NONE)
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "body is %s but the shape is none; a body needs a shape or a collider", kind);
    if (def->collider_count && !daft_check_pointer(error, "colliders", def->colliders)) return false;
    if (def->parent.id)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "body is %s but the entity has a parent; a body must have none",
                         kind);
    return daft_body_check_position(def->position, error) && scale_check(def, error);
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

daft_world *daft_scene_world(daft_scene *scene, daft_error *error)
{
    if (scene->world) return scene->world;
    scene->world = daft_world_create(scene->allocator, error);
    if (!scene->world) return NULL;
    daft_world_set_gravity(scene->world, scene->gravity);
    daft_world_set_workers(scene->world, scene->engine->threads, scene->engine->isa);
    return scene->world;
}

/* What is drawn, as a collider. */
static daft_collider collider_of(const daft_entity_def *def)
{
    daft_collider collider = daft_default_collider();
    collider.radius = def->radius, collider.size = def->size;
    if (def->shape == DAFT_SHAPE_BOX) collider.kind = DAFT_COLLIDER_BOX;
    if (def->shape == DAFT_SHAPE_MESH)
        collider.kind = def->body == DAFT_BODY_DYNAMIC ? DAFT_COLLIDER_HULL : DAFT_COLLIDER_MESH;
    return collider;
}

static daft_sim_shape_def shape_def(const daft_entity_def *def)
{
    daft_sim_shape_def shape = daft_default_sim_shape_def();
    shape.density = def->density;
    shape.material = (daft_sim_material){.friction = def->friction,
                                         .static_friction = def->static_friction,
                                         .restitution = def->restitution,
                                         .rolling_resistance = def->rolling_resistance,
                                         .surface_velocity = def->surface_velocity,
                                         .kind = def->surface};
    shape.layers = def->layers, shape.mask = def->mask;
    shape.sensor = def->sensor;
    return shape;
}

static daft_sim_body_def body_def(const daft_entity_def *def, uint32_t entity)
{
    daft_sim_body_def sim = daft_default_sim_body_def();
    sim.kind = def->body;
    sim.position = def->position, sim.rotation = def->rotation;
    sim.mass = def->mass;
    sim.gravity_scale = def->gravity_scale;
    sim.linear_damping = def->linear_damping, sim.angular_damping = def->angular_damping;
    sim.locks = def->locks;
    sim.bullet = def->bullet, sim.may_sleep = def->sleeps;
    sim.user = entity;
    return sim;
}

static void made_free(daft_scene *scene, const daft_made_body *made)
{
    for (uint32_t i = 0; i < made->geometry_count; i++) daft_geometry_drop(scene, made->geometries[i]);
    daft_release(scene->allocator, made->geometries);
}

/* The parts of the body; their geometries are counted in made. */
static bool make_shapes(daft_scene *scene, const daft_entity_def *def, const daft_collider *colliders, uint32_t count,
                        daft_sim_shape_def *shapes, daft_made_body *made, daft_error *error)
{
    for (uint32_t i = 0; i < count; i++) {
        shapes[i] = shape_def(def);
        if (!daft_collider_acquire(scene, &colliders[i], def, &shapes[i], error)) return false;
        made->geometries[made->geometry_count++] = shapes[i].geometry_id;
    }
    return true;
}

bool daft_body_create(daft_scene *scene, const daft_entity_def *def, uint32_t entity, daft_made_body *made,
                      daft_error *error)
{
    *made = (daft_made_body){0};
    if (def->body == DAFT_BODY_NONE) return true;
    daft_world *world = daft_scene_world(scene, error);
    if (!world) return false;
    daft_collider own = collider_of(def);
    uint32_t count = def->collider_count ? def->collider_count : 1;
    daft_sim_shape_def *shapes = daft_alloc(scene->allocator, count, sizeof *shapes);
    made->geometries = daft_alloc(scene->allocator, count, sizeof *made->geometries);
    if (!shapes || !made->geometries) {
        daft_fail_memory(error, "a body");
    } else if (make_shapes(scene, def, def->collider_count ? def->colliders : &own, count, shapes, made, error)) {
        daft_sim_body_def sim = body_def(def, entity);
        sim.shapes = shapes, sim.shape_count = count;
        made->body = daft_world_add(world, &sim, error);
    }
    daft_release(scene->allocator, shapes);
    if (made->body) return true;
    made_free(scene, made);
    return false;
}

void daft_body_destroy(daft_scene *scene, uint32_t index)
{
    daft_entity_item *item = &scene->entities[index];
    if (!item->body) return;
    daft_joints_forget(scene, (daft_entity){daft_slots_handle(&scene->entity_slots, index)});
    daft_world_remove(scene->world, item->body);
    made_free(scene, &(daft_made_body){item->body, item->geometries, item->geometry_count});
    item->geometries = NULL, item->geometry_count = 0;
    if (!daft_body_moves(item->def.body)) return;
    uint32_t moved = scene->moving[--scene->moving_count];
    scene->moving[item->moving_slot] = moved;
    scene->entities[moved].moving_slot = item->moving_slot;
}

/* ---- velocities, forces ---- */

/* Finds an entity whose body is of the kind `min` or a later one: static, kinematic, dynamic. */
static daft_entity_item *body_find(daft_scene *scene, daft_entity entity, daft_body_kind min, daft_error *error)
{
    daft_entity_item *item = daft_entity_find(scene, entity, error);
    if (!item || (item->body && item->def.body >= min)) return item;
    if (!item->body)
        daft_fail(error, DAFT_ERROR_ARGUMENT, "the entity has no body");
    else
        daft_fail(error, DAFT_ERROR_ARGUMENT, "the entity's body is %s; it must be %s", KINDS[item->def.body],
                  min == DAFT_BODY_DYNAMIC ? "dynamic" : "dynamic or kinematic");
    return NULL;
}

static daft_entity_item *body_change(daft_scene *scene, daft_entity entity, daft_body_kind min, daft_error *error)
{
    return daft_scene_ready(scene, error) ? body_find(scene, entity, min, error) : NULL;
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
    const daft_entity_item *item = body_change(scene, entity, DAFT_BODY_KINEMATIC, error);
    if (!item || !daft_check_finite3(error, "linear", linear) || !daft_check_finite3(error, "angular", angular))
        return false;
    daft_world_set_velocity(scene->world, item->body, linear, angular);
    return true;
}

bool daft_entity_apply_force(daft_scene *scene, daft_entity entity, daft_vec3 force, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_change(scene, entity, DAFT_BODY_DYNAMIC, error);
    if (!item || !daft_check_finite3(error, "force", force)) return false;
    daft_world_apply_force(scene->world, item->body, force);
    return true;
}

bool daft_entity_apply_impulse(daft_scene *scene, daft_entity entity, daft_vec3 impulse, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_change(scene, entity, DAFT_BODY_DYNAMIC, error);
    if (!item || !daft_check_finite3(error, "impulse", impulse)) return false;
    daft_world_apply_impulse(scene->world, item->body, impulse);
    return true;
}

bool daft_entity_apply_impulse_at(daft_scene *scene, daft_entity entity, daft_vec3 impulse, daft_dvec3 point,
                                  daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_change(scene, entity, DAFT_BODY_DYNAMIC, error);
    if (!item || !daft_check_finite3(error, "impulse", impulse) || !daft_check_finite_position(error, "point", point))
        return false;
    daft_world_apply_impulse_at(scene->world, item->body, impulse, point);
    return true;
}

bool daft_entity_apply_torque(daft_scene *scene, daft_entity entity, daft_vec3 torque, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_change(scene, entity, DAFT_BODY_DYNAMIC, error);
    if (!item || !daft_check_finite3(error, "torque", torque)) return false;
    daft_world_apply_torque(scene->world, item->body, torque);
    return true;
}

bool daft_entity_apply_angular_impulse(daft_scene *scene, daft_entity entity, daft_vec3 impulse, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_change(scene, entity, DAFT_BODY_DYNAMIC, error);
    if (!item || !daft_check_finite3(error, "impulse", impulse)) return false;
    daft_world_apply_angular_impulse(scene->world, item->body, impulse);
    return true;
}

bool daft_entity_get_mass(daft_scene *scene, daft_entity entity, float *kg, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_find(scene, entity, DAFT_BODY_STATIC, error);
    if (!item || !daft_check_pointer(error, "kg", kg)) return false;
    *kg = daft_world_mass(scene->world, item->body);
    return true;
}

bool daft_entity_get_awake(daft_scene *scene, daft_entity entity, bool *awake, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_find(scene, entity, DAFT_BODY_STATIC, error);
    if (!item || !daft_check_pointer(error, "awake", awake)) return false;
    *awake = daft_world_is_awake(scene->world, item->body);
    return true;
}

bool daft_entity_set_awake(daft_scene *scene, daft_entity entity, bool awake, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = body_change(scene, entity, DAFT_BODY_DYNAMIC, error);
    if (!item) return false;
    daft_world_set_awake(scene->world, item->body, awake);
    return true;
}

bool daft_entity_set_layers(daft_scene *scene, daft_entity entity, uint32_t layers, uint32_t mask, daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = body_change(scene, entity, DAFT_BODY_STATIC, error);
    if (!item) return false;
    item->def.layers = layers, item->def.mask = mask;
    daft_world_set_filter(scene->world, item->body, layers, mask);
    return true;
}

/* ---- time ---- */

void daft_scene_set_gravity(daft_scene *scene, daft_vec3 gravity)
{
    daft_error error;
    if (!daft_scene_ready_or_warn(scene, "gravity is left as it was")) return;
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
    if (!daft_scene_ready_or_warn(scene, "no tick begins")) return;
    scene->tick++;
    scene->camera_before = scene->camera;
}

static bool same_pose(const daft_transform *a, const daft_sim_state *b)
{
    return a->position.x == b->position.x && a->position.y == b->position.y && a->position.z == b->position.z &&
           a->rotation.x == b->rotation.x && a->rotation.y == b->rotation.y && a->rotation.z == b->rotation.z &&
           a->rotation.w == b->rotation.w;
}

static void pull_pose(daft_scene *scene, daft_entity_item *item, bool teleport)
{
    daft_sim_state state;
    daft_world_get(scene->world, item->body, &state);
    if (same_pose(&item->now, &state)) return;
    if (item->moved_tick != scene->tick) item->before = item->now;
    item->moved_tick = scene->moved_tick = scene->tick;
    item->now.position = state.position;
    item->now.rotation = state.rotation;
    if (teleport) item->before = item->now;
    daft_scene_touch(scene);
}

void daft_scene_pull_all_poses(daft_scene *scene)
{
    for (uint32_t i = 0; i < scene->entity_slots.count; i++)
        if (scene->entity_slots.items[i].live && scene->entities[i].body) pull_pose(scene, &scene->entities[i], true);
}

bool daft_scene_step(daft_scene *scene, float dt, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) ||
        !daft_check_range(error, "dt", (double)dt, DAFT_ABOVE_ZERO, 1, "above 0 and at most 1 (seconds)"))
        return false;
    scene->stepped += (double)dt, scene->step = (double)dt;
    daft_animations_step(scene, dt);
    if (!scene->world) return true;
    if (!daft_world_step(scene->world, dt, error)) return false;
    for (uint32_t i = 0; i < scene->moving_count; i++) pull_pose(scene, &scene->entities[scene->moving[i]], false);
    daft_joints_sweep(scene);
    return daft_characters_step(scene, dt, error);
}

static daft_contact contact_of(const daft_sim_contact *from, daft_entity a, daft_entity b)
{
    return (daft_contact){.a = a, .b = b, .point = from->point, .normal = from->normal, .impulse = from->impulse};
}

/* Contacts of entities that were destroyed since the tick are left out. */
uint32_t daft_scene_contacts(const daft_scene *scene, daft_contact *out, uint32_t capacity)
{
    if (!scene || !scene->world) return 0;
    const daft_sim_contact *contacts;
    uint32_t all = daft_world_contacts(scene->world, &contacts), count = 0;
    for (uint32_t i = 0; i < all; i++) {
        const daft_sim_contact *from = &contacts[i];
        daft_entity a = {from->user_a}, b = {from->user_b};
        if (!daft_entity_is_valid(scene, a) || !daft_entity_is_valid(scene, b)) continue;
        if (out && count < capacity) out[count] = contact_of(from, a, b);
        count++;
    }
    return count;
}

uint32_t daft_scene_events(const daft_scene *scene, daft_event *out, uint32_t capacity)
{
    _Static_assert((int)DAFT_EVENT_CONTACT_BEGIN == (int)DAFT_SIM_CONTACT_BEGIN &&
                       (int)DAFT_EVENT_WAKE == (int)DAFT_SIM_WAKE,
                   "the kinds are the same numbers");
    if (!scene || !scene->world) return 0;
    const daft_sim_event *events;
    uint32_t all = daft_world_events(scene->world, &events);
    for (uint32_t i = 0; out && i < all && i < capacity; i++) {
        const daft_sim_event *e = &events[i];
        out[i] = (daft_event){.kind = (daft_event_kind)e->kind,
                              .a = {e->user_a},
                              .b = {e->user_b},
                              .joint = {e->joint_user},
                              .point = e->point,
                              .normal = e->normal,
                              .impulse = e->impulse,
                              .speed = e->speed};
    }
    return all;
}

/* ---- the simulation as a whole ---- */

bool daft_scene_set_substeps(daft_scene *scene, int substeps, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_range(error, "substeps", substeps, 1, 16, "1 to 16"))
        return false;
    daft_world *world = daft_scene_world(scene, error);
    if (world) daft_world_set_substeps(world, substeps);
    return world != NULL;
}

void daft_scene_set_sleeping(daft_scene *scene, bool allowed)
{
    if (!daft_scene_ready_or_warn(scene, "sleeping is left as it was")) return;
    daft_world *world = daft_scene_world(scene, NULL);
    if (world) daft_world_set_sleeping(world, allowed);
}

bool daft_scene_measure_sim(daft_scene *scene, daft_sim_measure *out, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "out", out)) return false;
    *out = scene->world ? daft_world_measure(scene->world) : (daft_sim_measure){0};
    return true;
}

uint32_t daft_scene_moving(const daft_scene *scene, daft_entity *out, uint32_t capacity)
{
    if (!scene) return 0;
    for (uint32_t i = 0; out && i < scene->moving_count && i < capacity; i++)
        out[i].id = daft_slots_handle(&scene->entity_slots, scene->moving[i]);
    return scene->moving_count;
}

bool daft_scene_set_surfaces(daft_scene *scene, uint32_t kind_a, uint32_t kind_b, const daft_surfaces *together,
                             daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error)) return false;
    daft_world *world = daft_scene_world(scene, error);
    if (!world) return false;
    if (!together) return daft_world_set_pair(world, kind_a, kind_b, NULL, error);
    daft_sim_material_pair pair = {.friction = together->friction,
                                   .static_friction = together->static_friction,
                                   .restitution = together->restitution,
                                   .rolling_resistance = together->rolling_resistance};
    return daft_world_set_pair(world, kind_a, kind_b, &pair, error);
}

daft_sim_counters daft_scene_sim_counters(const daft_scene *scene)
{
    return scene && scene->world ? daft_world_counters(scene->world) : (daft_sim_counters){0};
}

daft_sim_times daft_scene_sim_times(const daft_scene *scene)
{
    return scene && scene->world ? daft_world_times(scene->world) : (daft_sim_times){0};
}

uint32_t daft_scene_body_edges(const daft_scene *scene, daft_dvec3 centre, float radius, daft_body_edge *out,
                               uint32_t capacity)
{
    if (!scene || !scene->world || !(radius > 0)) return 0;
    const uint32_t there = daft_world_edges(scene->world, centre, radius, NULL, 0);
    if (!out) capacity = 0;
    if (capacity > there) capacity = there;
    daft_sim_edge *edges = capacity ? daft_alloc(scene->allocator, capacity, sizeof *edges) : NULL;
    if (!edges) capacity = 0;
    if (capacity) daft_world_edges(scene->world, centre, radius, edges, capacity);
    for (uint32_t i = 0; i < capacity; i++)
        out[i] = (daft_body_edge){edges[i].from, edges[i].to,    {edges[i].user},
                                  edges[i].kind, edges[i].awake, edges[i].sensor};
    daft_release(scene->allocator, edges);
    return there;
}
