/* The hash of a scene's state: field by field, since the padding of structs is not state. */
#include "scene/scene.h"

#define HASH(field) hash = daft_hash(&(field), sizeof(field), hash)

static uint64_t hash_camera(const daft_camera *camera, uint64_t hash)
{
    HASH(camera->position), HASH(camera->yaw), HASH(camera->pitch), HASH(camera->roll), HASH(camera->fov);
    return hash;
}

static uint64_t hash_entity(const daft_entity_item *item, uint64_t hash)
{
    const daft_entity_def *def = &item->def;
    uint32_t kinds[] = {(uint32_t)def->shape, (uint32_t)def->body, def->visible, def->casts_shadow,
                        def->mesh.id,         def->material.id,    def->parent.id};
    HASH(kinds), HASH(def->radius), HASH(def->size);
    HASH(item->now.position), HASH(item->now.rotation), HASH(item->now.scale);
    HASH(def->density), HASH(def->friction), HASH(def->restitution), HASH(def->rolling_resistance);
    return hash;
}

static uint64_t hash_light(const daft_light_def *def, uint64_t hash)
{
    uint32_t kinds[] = {(uint32_t)def->kind, def->casts_shadow};
    HASH(kinds), HASH(def->position), HASH(def->direction), HASH(def->color);
    if (def->kind == DAFT_LIGHT_SPOT) HASH(def->inner_angle), HASH(def->outer_angle);
    return hash;
}

uint64_t daft_scene_hash(const daft_scene *scene)
{
    uint64_t hash = hash_camera(&scene->camera, 0);
    for (uint32_t i = 0; i < scene->entity_slots.count; i++) {
        if (!scene->entity_slots.items[i].live) continue;
        uint32_t id = daft_slots_handle(&scene->entity_slots, i);
        HASH(id);
        hash = hash_entity(&scene->entities[i], hash);
    }
    for (uint32_t i = 0; i < scene->light_slots.count; i++) {
        if (!scene->light_slots.items[i].live) continue;
        uint32_t id = daft_slots_handle(&scene->light_slots, i);
        HASH(id);
        hash = hash_light(&scene->lights[i], hash);
    }
    HASH(scene->ambient), HASH(scene->gravity);
    if (scene->world) hash = daft_world_hash(scene->world, hash);
    hash = daft_characters_hash(scene, hash);
    return hash;
}
