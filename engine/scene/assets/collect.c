/* What holds assets, and freeing those that nothing holds.
 *
 * A handle that was given out counts as one hold, until it is released. Beyond holds an asset lives by its users:
 * entities and bodies use meshes and materials, meshes use materials, materials use textures. Users are not counted,
 * but looked up when the program asks to collect: a mark over entities and assets, then a sweep. */
#include "scene/scene.h"

enum { FIRST = 1 << DAFT_INDEX_BITS }; /* the handle of slot 0 in its first generation, whose id is 1 */

uint32_t daft_asset_find(const daft_slots *slots, uint32_t id)
{
    return id ? daft_slots_find(slots, id - 1 + FIRST) : DAFT_NONE;
}

uint32_t daft_asset_id(const daft_slots *slots, uint32_t index) { return daft_slots_handle(slots, index) - FIRST + 1; }

bool daft_asset_reserve(daft_scene *scene, daft_slots *slots, daft_asset_state **states, size_t *capacity)
{
    return daft_slots_reserve(slots, scene->allocator, 1) &&
           daft_grow(scene->allocator, states, capacity, daft_slots_needed(slots, 1), slots->count, sizeof **states);
}

uint32_t daft_asset_add(daft_scene *scene, daft_slots *slots, daft_asset_state *states)
{
    uint32_t id = daft_slots_add(slots) - FIRST + 1;
    states[daft_asset_index(id)] = (daft_asset_state){.serial = ++scene->assets.serial, .holds = 1};
    return id;
}

/* ---- holds ---- */

static bool release(const daft_slots *slots, daft_asset_state *states, uint32_t id, const char *what, daft_error *error)
{
    uint32_t index = daft_asset_find(slots, id);
    if (index == DAFT_NONE)
        return daft_fail(error, DAFT_ERROR_HANDLE, id ? "%s %u is not one of this scene" : "the %s is none (%u)", what,
                         id);
    if (states[index].holds == 0)
        return daft_fail(error, DAFT_ERROR_HANDLE, "%s %u has been released as often as it was given", what, id);
    states[index].holds--;
    return true;
}

bool daft_mesh_release(daft_scene *scene, daft_mesh mesh, daft_error *error)
{
    daft_error_clear(error);
    return daft_scene_ready(scene, error) &&
           release(&scene->assets.mesh_slots, scene->assets.mesh_states, mesh.id, "mesh", error);
}

bool daft_texture_release(daft_scene *scene, daft_texture texture, daft_error *error)
{
    daft_error_clear(error);
    return daft_scene_ready(scene, error) &&
           release(&scene->assets.texture_slots, scene->assets.texture_states, texture.id, "texture", error);
}

bool daft_material_release(daft_scene *scene, daft_material material, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error)) return false;
    if (material.id == 1) return daft_fail(error, DAFT_ERROR_HANDLE, "material 1 is the scene's own");
    return release(&scene->assets.material_slots, scene->assets.material_states, material.id, "material", error);
}

/* ---- mark ---- */

static void mark(const daft_slots *slots, daft_asset_state *states, uint32_t id)
{
    uint32_t index = daft_asset_find(slots, id);
    if (index != DAFT_NONE) states[index].used = true;
}

static void mark_held(const daft_slots *slots, daft_asset_state *states)
{
    for (uint32_t i = 0; i < slots->count; i++) states[i].used = states[i].holds > 0;
}

static void mark_from_entities(daft_scene *scene)
{
    daft_assets *assets = &scene->assets;
    for (uint32_t i = 0; i < scene->entity_slots.count; i++) {
        if (!scene->entity_slots.items[i].live) continue;
        const daft_entity_def *def = &scene->entities[i].def;
        mark(&assets->mesh_slots, assets->mesh_states, def->mesh.id);
        mark(&assets->material_slots, assets->material_states, def->material.id);
    }
    for (uint32_t i = 0; i < scene->geometry_count; i++)
        if (scene->geometries[i]) mark(&assets->mesh_slots, assets->mesh_states, scene->geometries[i]->mesh);
}

/* From meshes to materials, from those to textures. */
static void mark_onwards(daft_assets *assets)
{
    for (uint32_t i = 0; i < assets->mesh_slots.count; i++) {
        const daft_mesh_item *item = assets->meshes[i];
        if (!item || !assets->mesh_states[i].used) continue;
        for (uint32_t k = 0; k < daft_max_u(item->mesh.slot_count, 1); k++)
            assets->material_states[item->materials[k]].used = true;
    }
    for (uint32_t i = 0; i < assets->material_slots.count; i++) {
        daft_texture textures[DAFT_MATERIAL_TEXTURES];
        if (!assets->material_slots.items[i].live || !assets->material_states[i].used) continue;
        daft_material_textures(&assets->materials[i], textures);
        for (int k = 0; k < DAFT_MATERIAL_TEXTURES; k++)
            mark(&assets->texture_slots, assets->texture_states, textures[k].id);
    }
}

/* ---- sweep ---- */

static bool is_free(const daft_slots *slots, const daft_asset_state *states, uint32_t index)
{
    return slots->items[index].live && !states[index].used;
}

uint32_t daft_scene_collect(daft_scene *scene)
{
    if (!daft_scene_ready_or_warn(scene, "nothing is freed")) return 0;
    daft_assets *assets = &scene->assets;
    mark_held(&assets->mesh_slots, assets->mesh_states);
    mark_held(&assets->texture_slots, assets->texture_states);
    mark_held(&assets->material_slots, assets->material_states);
    mark_from_entities(scene);
    mark_onwards(assets);
    uint32_t freed = 0;
    for (uint32_t i = 0; i < assets->mesh_slots.count; i++)
        if (is_free(&assets->mesh_slots, assets->mesh_states, i)) daft_mesh_drop(scene, i), freed++;
    for (uint32_t i = 0; i < assets->material_slots.count; i++)
        if (is_free(&assets->material_slots, assets->material_states, i)) daft_material_free(scene, i), freed++;
    for (uint32_t i = 0; i < assets->texture_slots.count; i++)
        if (is_free(&assets->texture_slots, assets->texture_states, i)) freed += daft_texture_drop(scene, i);
    return freed;
}
