/* The hash of a scene's state, from the lists of fields: what a field is flagged for there decides whether it counts.
 */
#include "scene/scene.h"

#define HASH(field) hash = daft_hash(&(field), sizeof(field), hash)

/* Its transform is the one of now. */
static uint64_t hash_entity(const daft_entity_item *item, uint64_t hash)
{
    daft_entity_def def = item->def;
    def.position = item->now.position, def.rotation = item->now.rotation, def.scale = item->now.scale;
    return daft_struct_hash(DAFT_STRUCT_ENTITY_DEF, &def, hash);
}

uint64_t daft_scene_hash(const daft_scene *scene)
{
    if (!scene) return 0;
    uint64_t hash = daft_struct_hash(DAFT_STRUCT_CAMERA, &scene->camera, 0);
    for (uint32_t i = 0; i < scene->entity_slots.count; i++) {
        if (!scene->entity_slots.items[i].live) continue;
        uint32_t id = daft_slots_handle(&scene->entity_slots, i);
        HASH(id);
        hash = hash_entity(&scene->entities[i], hash);
        hash = daft_animations_hash(scene, i, hash);
    }
    for (uint32_t i = 0; i < scene->light_slots.count; i++) {
        if (!scene->light_slots.items[i].live) continue;
        uint32_t id = daft_slots_handle(&scene->light_slots, i);
        HASH(id);
        hash = daft_struct_hash(DAFT_STRUCT_LIGHT_DEF, &scene->lights[i], hash);
    }
    HASH(scene->ambient), HASH(scene->gravity);
    if (scene->world) hash = daft_world_hash(scene->world, hash);
    hash = daft_characters_hash(scene, hash);
    return hash;
}
