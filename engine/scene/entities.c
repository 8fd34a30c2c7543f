/* Entities: made, moved, destroyed. The hierarchy is kept as index links: parent, first child, siblings; what changes
 * them later is in hierarchy.c. */
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>

daft_entity_def daft_default_entity_def(void)
{
    daft_entity_def def;
    daft_struct_default(DAFT_STRUCT_ENTITY_DEF, &def);
    return def;
}

daft_entity_item *daft_entity_find(const daft_scene *scene, daft_entity entity, daft_error *error)
{
    if (!daft_check_pointer(error, "scene", scene)) return NULL;
    uint32_t index = daft_slots_find(&scene->entity_slots, entity.id);
    if (index != DAFT_NONE) return &scene->entities[index];
    if (entity.id == 0)
        daft_fail(error, DAFT_ERROR_HANDLE, "the entity is none (0)");
    else
        daft_fail(error, DAFT_ERROR_HANDLE, "entity 0x%x is stale: it was destroyed, or is not one of this scene",
                  entity.id);
    return NULL;
}

daft_entity_item *daft_entity_change(const daft_scene *scene, daft_entity entity, daft_error *error)
{
    return daft_scene_ready(scene, error) ? daft_entity_find(scene, entity, error) : NULL;
}

uint32_t daft_scene_entities(const daft_scene *scene, daft_entity *out, uint32_t capacity)
{
    uint32_t count = 0;
    for (uint32_t i = 0; scene && i < scene->entity_slots.count; i++) {
        if (!scene->entity_slots.items[i].live) continue;
        if (out && count < capacity) out[count].id = daft_slots_handle(&scene->entity_slots, i);
        count++;
    }
    return count;
}

bool daft_entity_get(daft_scene *scene, daft_entity entity, daft_entity_def *out, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = daft_entity_find(scene, entity, error);
    if (!item || !daft_check_pointer(error, "out", out)) return false;
    *out = item->def;
    out->position = item->now.position, out->rotation = item->now.rotation, out->scale = item->now.scale;
    out->parent = daft_entity_get_parent(scene, entity);
    return true;
}

/* ---- checks ---- */

bool daft_transform_check(const daft_transform *transform, daft_error *error)
{
    return daft_check_finite_position(error, "position", transform->position) &&
           daft_check_rotation(error, "rotation", transform->rotation) &&
           daft_check_finite3(error, "scale", transform->scale);
}

static bool parent_check(const daft_scene *scene, const daft_entity_def *def, daft_error *error)
{
    if (def->parent.id && daft_slots_find(&scene->entity_slots, def->parent.id) == DAFT_NONE)
        return daft_fail(error, DAFT_ERROR_HANDLE,
                         "the parent, entity 0x%x, is stale: it was destroyed, or is not one of this scene",
                         def->parent.id);
    if (def->shape != DAFT_SHAPE_SPHERE) return true;
    if (!daft_scale_is_uniform(def->scale))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "scale is %g, %g, %g; a sphere's must be equal in all three axes",
                         (double)def->scale.x, (double)def->scale.y, (double)def->scale.z);
    uint32_t index = def->parent.id ? daft_slots_find(&scene->entity_slots, def->parent.id) : DAFT_NONE;
    for (; index != DAFT_NONE; index = scene->entities[index].parent) {
        daft_vec3 scale = scene->entities[index].now.scale;
        if (!daft_scale_is_uniform(scale))
            return daft_fail(error, DAFT_ERROR_ARGUMENT,
                             "an ancestor's scale is %g, %g, %g; above a sphere it must be equal in all three axes",
                             (double)scale.x, (double)scale.y, (double)scale.z);
    }
    return true;
}

bool daft_entity_check(daft_scene *scene, const daft_entity_def *def, daft_error *error)
{
    if (!daft_check_pointer(error, "def", def) || !daft_struct_check(DAFT_STRUCT_ENTITY_DEF, def, error)) return false;
    return (def->shape != DAFT_SHAPE_MESH || daft_mesh_find(scene, def->mesh, error)) &&
           (def->material.id == 0 || daft_material_check(scene, def->material, error)) &&
           parent_check(scene, def, error) && daft_body_check(def, error);
}

/* ---- birth ---- */

bool daft_entities_reserve(daft_scene *scene, uint32_t more, daft_error *error)
{
    uint32_t needed = daft_slots_needed(&scene->entity_slots, more);
    if (needed > DAFT_MAX_SLOTS)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a scene holds at most %d entities", DAFT_MAX_SLOTS);
    return (daft_slots_reserve(&scene->entity_slots, scene->allocator, more) &&
            daft_grow(scene->allocator, &scene->entities, &scene->entity_capacity, needed, scene->entity_slots.count,
                      sizeof *scene->entities) &&
            daft_grow(scene->allocator, &scene->moving, &scene->moving_capacity, needed, scene->moving_count,
                      sizeof *scene->moving)) ||
           daft_fail_memory(error, "the list of entities");
}

void daft_entity_link(daft_scene *scene, uint32_t parent, uint32_t child)
{
    daft_entity_item *above = &scene->entities[parent], *item = &scene->entities[child];
    item->parent = parent;
    item->next = above->first_child;
    if (item->next != DAFT_NONE) scene->entities[item->next].previous = child;
    above->first_child = child;
}

/* Keeps a quaternion that is unit within rounding as it came, so that get and set in turn change nothing. */
static daft_quat unit(daft_quat q)
{
    float square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    if (fabsf(square - 1) < 1e-6f) return q;
    double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = (double)q.w;
    double s = 1 / sqrt(x * x + y * y + z * z + w * w);
    return (daft_quat){(float)(x * s), (float)(y * s), (float)(z * s), (float)(w * s)};
}

daft_entity daft_entity_insert(daft_scene *scene, const daft_entity_def *def, uint32_t box, const daft_made_body *body)
{
    daft_entity entity = {daft_slots_add(&scene->entity_slots)};
    uint32_t index = daft_handle_index(entity.id);
    daft_entity_item *item = &scene->entities[index];
    *item = (daft_entity_item){.def = *def, .box = box};
    item->def.colliders = NULL, item->def.collider_count = 0; /* the caller's */
    if (body) item->body = body->body, item->geometries = body->geometries, item->geometry_count = body->geometry_count;
    item->parent = item->first_child = item->next = item->previous = DAFT_NONE;
    item->now = (daft_transform){.position = def->position, .rotation = unit(def->rotation), .scale = def->scale};
    item->before = item->now;
    item->moved_tick = scene->tick;
    scene->glowing += def->lights;
    if (def->parent.id) daft_entity_link(scene, daft_slots_find(&scene->entity_slots, def->parent.id), index);
    if (daft_body_moves(def->body)) {
        item->moving_slot = scene->moving_count;
        scene->moving[scene->moving_count++] = index;
    }
    daft_scene_touch(scene);
    return entity;
}

/* The handle that the next daft_slots_add will give: bodies carry it. Room was reserved. */
static uint32_t next_handle(const daft_slots *slots)
{
    return slots->first_free != DAFT_NONE ? daft_slots_handle(slots, slots->first_free)
                                          : (1u << DAFT_INDEX_BITS | slots->count);
}

daft_entity daft_entity_create(daft_scene *scene, const daft_entity_def *def, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_entity_check(scene, def, error) ||
        !daft_entities_reserve(scene, 1, error))
        return (daft_entity){0};
    uint32_t box = DAFT_NONE;
    daft_made_body body;
    if (def->shape == DAFT_SHAPE_BOX) {
        box = daft_box_acquire(scene, def->size, error);
        if (box == DAFT_NONE) return (daft_entity){0};
    }
    daft_entity_def unit_def = *def;
    unit_def.rotation = unit(def->rotation);
    if (!daft_body_create(scene, &unit_def, next_handle(&scene->entity_slots), &body, error)) {
        if (box != DAFT_NONE) daft_box_drop(scene, box);
        return (daft_entity){0};
    }
    return daft_entity_insert(scene, &unit_def, box, &body);
}

/* ---- death ---- */

void daft_entity_unlink(daft_scene *scene, const daft_entity_item *item)
{
    if (item->next != DAFT_NONE) scene->entities[item->next].previous = item->previous;
    if (item->previous != DAFT_NONE)
        scene->entities[item->previous].next = item->next;
    else if (item->parent != DAFT_NONE)
        scene->entities[item->parent].first_child = item->next;
}

static void remove_leaf(daft_scene *scene, uint32_t index)
{
    daft_entity_item *item = &scene->entities[index];
    daft_entity_unlink(scene, item);
    daft_body_destroy(scene, index);
    if (item->box != DAFT_NONE) daft_box_drop(scene, item->box);
    daft_animated_free(scene, item->animated);
    item->animated = NULL;
    scene->glowing -= item->def.lights;
    daft_slots_remove(&scene->entity_slots, index);
}

bool daft_entity_destroy(daft_scene *scene, daft_entity entity, daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *root = daft_entity_change(scene, entity, error);
    if (!root) return false;
    uint32_t top = daft_handle_index(entity.id), at = top;
    for (;;) {
        while (scene->entities[at].first_child != DAFT_NONE) at = scene->entities[at].first_child;
        uint32_t up = scene->entities[at].parent;
        remove_leaf(scene, at);
        if (at == top) break;
        at = up;
    }
    daft_scene_touch(scene);
    return true;
}

bool daft_entity_is_valid(const daft_scene *scene, daft_entity entity)
{
    return scene && daft_slots_find(&scene->entity_slots, entity.id) != DAFT_NONE;
}

uint32_t daft_entity_count(const daft_scene *scene) { return scene ? scene->entity_slots.live : 0; }

/* ---- changes ---- */

bool daft_entity_get_transform(daft_scene *scene, daft_entity entity, daft_transform *out, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = daft_entity_find(scene, entity, error);
    if (!item || !daft_check_pointer(error, "out", out)) return false;
    *out = item->now;
    return true;
}

/* The next entity of a subtree in depth-first order, or DAFT_NONE. */
uint32_t daft_subtree_next(const daft_scene *scene, uint32_t root, uint32_t at)
{
    const daft_entity_item *items = scene->entities;
    if (items[at].first_child != DAFT_NONE) return items[at].first_child;
    while (at != root && items[at].next == DAFT_NONE) at = items[at].parent;
    return at == root ? DAFT_NONE : items[at].next;
}

static bool scale_check(const daft_scene *scene, uint32_t root, const daft_entity_def *def, daft_vec3 scale,
                        daft_error *error)
{
    daft_vec3 made = scene->entities[root].now.scale;
    if (def->body != DAFT_BODY_NONE && (scale.x != made.x || scale.y != made.y || scale.z != made.z))
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "scale is %g, %g, %g; a body keeps that which it was made with, %g, %g, %g", (double)scale.x,
                         (double)scale.y, (double)scale.z, (double)made.x, (double)made.y, (double)made.z);
    if (daft_scale_is_uniform(scale)) return true;
    for (uint32_t at = root; at != DAFT_NONE; at = daft_subtree_next(scene, root, at))
        if (scene->entities[at].def.shape == DAFT_SHAPE_SPHERE)
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "scale is %g, %g, %g; %s must be equal in all three axes",
                             (double)scale.x, (double)scale.y, (double)scale.z,
                             at == root ? "a sphere's" : "above a sphere it");
    return true;
}

/* Before `now` becomes that of this tick. */
static void keep_before(daft_scene *scene, daft_entity_item *item)
{
    if (item->moved_tick != scene->tick) item->before = item->now;
    item->moved_tick = scene->moved_tick = scene->tick;
}

/* After `now` has changed. */
static void finish_move(daft_scene *scene, daft_entity_item *item, bool teleport)
{
    if (teleport) item->before = item->now;
    if (item->body) daft_world_set_pose(scene->world, item->body, item->now.position, item->now.rotation, teleport);
    daft_scene_touch(scene);
}

bool daft_entity_set_position(daft_scene *scene, daft_entity entity, daft_dvec3 position, bool teleport,
                              daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item || !daft_check_finite_position(error, "position", position) ||
        (item->body && !daft_body_check_position(position, error)))
        return false;
    keep_before(scene, item);
    item->now.position = position;
    finish_move(scene, item, teleport);
    return true;
}

bool daft_entity_set_transform(daft_scene *scene, daft_entity entity, const daft_transform *transform, bool teleport,
                               daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item || !daft_check_pointer(error, "transform", transform) || !daft_transform_check(transform, error) ||
        !scale_check(scene, daft_handle_index(entity.id), &item->def, transform->scale, error) ||
        (item->body && !daft_body_check_position(transform->position, error)))
        return false;
    keep_before(scene, item);
    item->now = *transform;
    item->now.rotation = unit(transform->rotation);
    finish_move(scene, item, teleport);
    return true;
}

bool daft_entity_set_material(daft_scene *scene, daft_entity entity, daft_material material, daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item || (material.id != 0 && !daft_material_check(scene, material, error))) return false;
    if (item->def.material.id != material.id) daft_scene_touch(scene);
    item->def.material = material;
    return true;
}

bool daft_entity_set_visible(daft_scene *scene, daft_entity entity, bool visible, daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item) return false;
    if (item->def.visible != visible) daft_scene_touch(scene);
    item->def.visible = visible;
    return true;
}
