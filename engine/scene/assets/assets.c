/* Meshes and textures: loading, caches by path, boxes shared by size, and taking back what a failed load added,
 * freeing. */
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>

uint64_t daft_path_hash(const char *path) { return daft_hash(path, strlen(path), 0); }

bool daft_assets_init(daft_scene *scene, daft_error *error)
{
    daft_assets *assets = &scene->assets;
    daft_slots_init(&assets->box_slots);
    daft_slots_init(&assets->mesh_slots);
    daft_slots_init(&assets->texture_slots);
    daft_slots_init(&assets->material_slots);
    daft_material_def def = daft_default_material_def();
    return daft_material_create(scene, &def, error).id != 0;
}

/* The mesh of a file, of arrays, or a box's, which is the first member of its item. */
static void mesh_free(const daft_scene *scene, daft_mesh_item *item)
{
    if (item->bvh) daft_bvh_free(item->bvh);
    daft_kdtree_free(item->kdtree);
    daft_trimesh_free(scene->allocator, &item->mesh);
    daft_rig_free(scene->allocator, item->rig);
    daft_scenery_free(scene->allocator, &item->scenery);
    daft_opacity_free(scene, item);
    daft_glow_free(scene, &item->glow);
    daft_release(scene->allocator, item->materials);
    daft_release(scene->allocator, item->path);
    daft_release(scene->allocator, item);
}

static void free_retired_mesh(const daft_scene *scene, daft_retired *item) { mesh_free(scene, (daft_mesh_item *)item); }

/* Frames may still read it. */
void daft_mesh_drop(daft_scene *scene, uint32_t index)
{
    daft_assets *assets = &scene->assets;
    daft_mesh_item *item = assets->meshes[index];
    if (item->path) daft_map_remove(&assets->mesh_map, item->hash, index);
    assets->meshes[index] = NULL;
    daft_slots_remove(&assets->mesh_slots, index);
    daft_retire(scene, &item->retired, free_retired_mesh);
}

/* The key is gone, the slot is free; the texels are still to be freed. */
static void texture_forget(daft_scene *scene, uint32_t index)
{
    daft_assets *assets = &scene->assets;
    daft_texture_key *key = &assets->texture_keys[index];
    daft_map_remove(&assets->texture_map, key->hash, index);
    daft_release(scene->allocator, key->path);
    key->path = NULL;
    assets->textures[index] = (daft_texture_data){0};
    daft_slots_remove(&assets->texture_slots, index);
}

daft_assets_mark daft_assets_remember(const daft_scene *scene) { return (daft_assets_mark){scene->assets.serial}; }

static bool is_newer(const daft_slots *slots, const daft_asset_state *states, uint32_t index, daft_assets_mark mark)
{
    return slots->items[index].live && states[index].serial > mark.serial;
}

void daft_assets_roll_back(daft_scene *scene, daft_assets_mark mark)
{
    daft_assets *assets = &scene->assets;
    for (uint32_t i = assets->mesh_slots.count; i-- > 0;)
        if (is_newer(&assets->mesh_slots, assets->mesh_states, i, mark)) daft_mesh_drop(scene, i);
    for (uint32_t i = assets->material_slots.count; i-- > 0;)
        if (is_newer(&assets->material_slots, assets->material_states, i, mark)) daft_material_free(scene, i);
    for (uint32_t i = assets->texture_slots.count; i-- > 0;) {
        if (!is_newer(&assets->texture_slots, assets->texture_states, i, mark)) continue;
        daft_texture_data data = assets->textures[i]; /* in no frame yet */
        texture_forget(scene, i);
        daft_texture_free(scene->allocator, &data);
    }
}

void daft_assets_free(daft_scene *scene)
{
    daft_assets *assets = &scene->assets;
    const daft_allocator *allocator = scene->allocator;
    daft_assets_roll_back(scene, (daft_assets_mark){0});
    for (uint32_t i = 0; i < assets->box_slots.count; i++) {
        if (!assets->box_slots.items[i].live) continue;
        mesh_free(scene, &assets->boxes[i]->shape);
    }
    daft_slots *slots[] = {&assets->box_slots, &assets->mesh_slots, &assets->texture_slots, &assets->material_slots};
    for (size_t i = 0; i < DAFT_COUNT_OF(slots); i++) daft_slots_free(slots[i], allocator);
    daft_map_free(&assets->mesh_map, allocator);
    daft_map_free(&assets->texture_map, allocator);
    daft_map_free(&assets->material_map, allocator);
    daft_map_free(&assets->box_map, allocator);
    void *arrays[] = {assets->meshes,         assets->textures,        assets->texture_keys,  assets->materials,
                      assets->surfaces,       assets->material_keys,   assets->boxes,         assets->mesh_states,
                      assets->texture_states, assets->material_states, assets->material_names};
    for (size_t i = 0; i < DAFT_COUNT_OF(arrays); i++) daft_release(allocator, arrays[i]);
}

/* ---- meshes ---- */

static daft_bvh_def mesh_tree(const daft_scene *scene)
{
    const daft_engine *engine = scene->engine;
    return (daft_bvh_def){.threads = engine->threads, .isa = engine->isa};
}

bool daft_mesh_need_kdtree(daft_scene *scene, daft_mesh_item *item, daft_error *error)
{
    if (!item->kdtree) item->kdtree = daft_kdtree_build(scene->allocator, &item->mesh, scene->engine->threads, error);
    return item->kdtree != NULL;
}

/* Builds what a mesh needs beside its triangles. On failure the item is still to be freed. */
static bool mesh_finish(daft_scene *scene, daft_mesh_item *item, daft_error *error)
{
    item->revision = ++scene->engine->revision;
    uint32_t slots = item->mesh.slot_count ? item->mesh.slot_count : 1;
    item->materials = daft_alloc_zero(scene->allocator, slots, sizeof *item->materials);
    if (!item->materials) return daft_fail_memory(error, "a mesh's materials");
    const daft_bvh_def def = mesh_tree(scene);
    item->bvh = daft_bvh_build(scene->allocator, &item->mesh, &def, error);
    if (!item->bvh) return false;
    scene->counters.mesh_builds++;
    return scene->engine->accel != DAFT_ACCEL_KDTREE || daft_mesh_need_kdtree(scene, item, error);
}

static bool mesh_reserve(daft_scene *scene, daft_error *error)
{
    daft_assets *assets = &scene->assets;
    return (daft_asset_reserve(scene, &assets->mesh_slots, &assets->mesh_states, &assets->mesh_state_capacity) &&
            daft_grow(scene->allocator, &assets->meshes, &assets->mesh_capacity,
                      daft_slots_needed(&assets->mesh_slots, 1), assets->mesh_slots.count, sizeof *assets->meshes) &&
            daft_map_reserve(&assets->mesh_map, scene->allocator, 1)) ||
           daft_fail_memory(error, "the list of meshes");
}

/* Reads an OBJ into a fresh item; its materials are created. */
static bool mesh_read(daft_scene *scene, const char *path, daft_mesh_item *item, daft_error *error)
{
    item->path = daft_copy_string(scene->allocator, path);
    if (!item->path) return daft_fail_memory(error, "a path");
    item->hash = daft_path_hash(path);
    daft_obj obj = {0};
    if (!daft_model_load(scene->allocator, scene->engine->files, path, &scene->engine->log, &obj, error)) return false;
    item->mesh = obj.mesh, item->rig = obj.rig, item->scenery = obj.scenery; /* from here on the item owns them */
    memset(&obj.mesh, 0, sizeof obj.mesh), obj.rig = NULL, obj.scenery = (daft_scenery){0};
    bool done = daft_scene_note_file(scene, path, error) && mesh_finish(scene, item, error);
    for (size_t i = 0; done && i < obj.slots.count && i < item->mesh.slot_count; i++) {
        daft_material material = daft_material_from_mtl(scene, &obj.slots.items[i], error);
        done = material.id != 0;
        if (!done) break;
        item->materials[i] = daft_asset_index(material.id);
        daft_material_release(scene, material, NULL); /* the mesh uses it */
    }
    daft_obj_free(scene->allocator, &obj);
    return done;
}

/* Counts as one hold more. */
static uint32_t mesh_cached(const daft_scene *scene, const char *path, uint64_t hash)
{
    const daft_assets *assets = &scene->assets;
    for (uint32_t cursor = 0, i; (i = daft_map_next(&assets->mesh_map, hash, &cursor)) != DAFT_NONE;) {
        if (strcmp(assets->meshes[i]->path, path) != 0) continue;
        assets->mesh_states[i].holds++;
        return daft_asset_id(&assets->mesh_slots, i);
    }
    return 0;
}

static daft_mesh mesh_add(daft_scene *scene, daft_mesh_item *item)
{
    daft_assets *assets = &scene->assets;
    daft_mesh mesh = {daft_asset_add(scene, &assets->mesh_slots, assets->mesh_states)};
    uint32_t index = daft_asset_index(mesh.id);
    if (item->path) daft_map_add(&assets->mesh_map, item->hash, index);
    assets->meshes[index] = item;
    if (item->mesh.alphas) daft_materials_fade(scene);
    return mesh;
}

daft_mesh daft_mesh_load(daft_scene *scene, const char *path, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "path", path)) return (daft_mesh){0};
    uint32_t cached = mesh_cached(scene, path, daft_path_hash(path));
    if (cached || !mesh_reserve(scene, error)) return (daft_mesh){cached};
    daft_mesh_item *item = daft_alloc_zero(scene->allocator, 1, sizeof *item);
    if (!item) {
        daft_fail_memory(error, "a mesh");
        return (daft_mesh){0};
    }
    daft_assets_mark mark = daft_assets_remember(scene);
    if (mesh_read(scene, path, item, error)) return mesh_add(scene, item);
    mesh_free(scene, item);
    daft_assets_roll_back(scene, mark);
    return (daft_mesh){0};
}

daft_mesh_def daft_default_mesh_def(void) { return (daft_mesh_def){.cookie = DAFT_COOKIE}; }

static bool mesh_def_check(const daft_mesh_def *def, daft_error *error)
{
    return daft_check_pointer(error, "def", def) && daft_check_cookie(error, def->cookie, "daft_default_mesh_def") &&
           (def->vertex_count == 0 || daft_check_pointer(error, "positions", def->positions)) &&
           (def->triangle_count == 0 || daft_check_pointer(error, "indices", def->indices));
}

daft_mesh daft_mesh_create(daft_scene *scene, const daft_mesh_def *def, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !mesh_def_check(def, error) || !mesh_reserve(scene, error))
        return (daft_mesh){0};
    daft_mesh_item *item = daft_alloc_zero(scene->allocator, 1, sizeof *item);
    if (!item) {
        daft_fail_memory(error, "a mesh");
        return (daft_mesh){0};
    }
    if (daft_trimesh_from_arrays(scene->allocator, def, &scene->engine->log, &item->mesh, error) &&
        mesh_finish(scene, item, error))
        return mesh_add(scene, item);
    mesh_free(scene, item);
    return (daft_mesh){0};
}

daft_extrude_def daft_default_extrude_def(void) { return (daft_extrude_def){.cookie = DAFT_COOKIE, .depth = 1}; }

static bool extrude_def_check(const daft_extrude_def *def, daft_error *error)
{
    return daft_check_pointer(error, "def", def) && daft_check_cookie(error, def->cookie, "daft_default_extrude_def") &&
           daft_check_pointer(error, "points", def->points) && daft_check_pointer(error, "counts", def->counts);
}

daft_mesh daft_mesh_extrude(daft_scene *scene, const daft_extrude_def *def, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !extrude_def_check(def, error) || !mesh_reserve(scene, error))
        return (daft_mesh){0};
    daft_mesh_item *item = daft_alloc_zero(scene->allocator, 1, sizeof *item);
    if (!item) {
        daft_fail_memory(error, "a mesh");
        return (daft_mesh){0};
    }
    if (daft_trimesh_extrude(scene->allocator, def, &item->mesh, error) && mesh_finish(scene, item, error))
        return mesh_add(scene, item);
    mesh_free(scene, item);
    return (daft_mesh){0};
}

daft_mesh_item *daft_mesh_find(const daft_scene *scene, daft_mesh mesh, daft_error *error)
{
    uint32_t index = daft_asset_find(&scene->assets.mesh_slots, mesh.id);
    if (index != DAFT_NONE) return scene->assets.meshes[index];
    daft_fail(error, DAFT_ERROR_HANDLE, mesh.id ? "mesh %u is not one of this scene" : "the mesh is none (0)", mesh.id);
    return NULL;
}

/* A frame may be reading the mesh: another with the same contents takes its place. NULL: memory is out. */
static daft_mesh_item *mesh_replace(daft_scene *scene, daft_mesh mesh, daft_error *error)
{
    daft_mesh_item **place = &scene->assets.meshes[daft_asset_index(mesh.id)], *old = *place;
    daft_mesh_item *item = daft_alloc_zero(scene->allocator, 1, sizeof *item);
    if (!item || !daft_trimesh_copy(scene->allocator, &old->mesh, &item->mesh, error)) {
        daft_release(scene->allocator, item);
        daft_fail_memory(error, "a mesh");
        return NULL;
    }
    if (!mesh_finish(scene, item, error)) {
        mesh_free(scene, item);
        return NULL;
    }
    memcpy(item->materials, old->materials, daft_max_u(old->mesh.slot_count, 1) * sizeof *item->materials);
    item->path = old->path, item->hash = old->hash, item->scenery = old->scenery;
    old->path = NULL, old->scenery = (daft_scenery){0};
    item->opacity = old->opacity, old->opacity = NULL;
    *place = item;
    daft_retire(scene, &old->retired, free_retired_mesh);
    return item;
}

bool daft_mesh_set_positions(daft_scene *scene, daft_mesh mesh, const daft_vec3 *positions, const daft_vec3 *normals,
                             uint32_t count, daft_error *error)
{
    daft_error_clear(error);
    daft_mesh_item *item = daft_scene_ready(scene, error) ? daft_mesh_find(scene, mesh, error) : NULL;
    if (!item || !daft_check_pointer(error, "positions", positions)) return false;
    if (count != item->mesh.vertex_count)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "%u positions for a mesh of %u vertices", count,
                         item->mesh.vertex_count);
    if (item->rig) return daft_fail(error, DAFT_ERROR_ARGUMENT, "the mesh has clips: these move it");
    if (daft_geometry_uses_mesh(scene, mesh))
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "the mesh's triangles are what a body is made of: they do not move");
    if (daft_frame_is_taken(scene)) item = mesh_replace(scene, mesh, error);
    if (!item || !daft_trimesh_deform(scene->allocator, &item->mesh, positions, normals, error)) return false;
    daft_glow_free(scene, &item->glow);
    const daft_bvh_def def = mesh_tree(scene);
    if (daft_bvh_update(item->bvh, &item->mesh, &def)) scene->counters.mesh_builds++;
    daft_kdtree_free(item->kdtree);
    item->kdtree = NULL;
    if (scene->engine->accel == DAFT_ACCEL_KDTREE)
        daft_mesh_need_kdtree(scene, item, NULL); /* without memory for one, rays go through the BVH, to the same hits
                                                   */
    scene->counters.mesh_refits++;
    daft_scene_touch(scene);
    return true;
}

bool daft_mesh_get_info(daft_scene *scene, daft_mesh mesh, daft_mesh_info *info, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "info", info)) return false;
    const daft_mesh_item *item = daft_mesh_find(scene, mesh, error);
    if (!item) return false;
    *info = (daft_mesh_info){.vertex_count = item->mesh.vertex_count,
                             .triangle_count = item->mesh.triangle_count,
                             .material_count = item->mesh.slot_count ? item->mesh.slot_count : 1,
                             .low = item->mesh.low,
                             .high = item->mesh.high,
                             .bytes = daft_trimesh_bytes(&item->mesh) + daft_bvh_bytes(item->bvh) +
                                      (item->kdtree ? daft_kdtree_bytes(item->kdtree) : 0) +
                                      (item->rig ? daft_rig_bytes(item->rig) : 0) + daft_opacity_bytes(item),
                             .clip_count = item->rig ? item->rig->clip_count : 0,
                             .camera_count = item->scenery.camera_count,
                             .light_count = item->scenery.light_count};
    return true;
}

/* ---- boxes ---- */

static uint64_t size_hash(daft_vec3 size)
{
    float components[3] = {size.x, size.y, size.z};
    return daft_hash(components, sizeof components, 0);
}

static bool box_reserve(daft_scene *scene)
{
    daft_assets *assets = &scene->assets;
    return daft_slots_reserve(&assets->box_slots, scene->allocator, 1) &&
           daft_map_reserve(&assets->box_map, scene->allocator, 1) &&
           daft_grow(scene->allocator, &assets->boxes, &assets->box_capacity, daft_slots_needed(&assets->box_slots, 1),
                     assets->box_slots.count, sizeof *assets->boxes);
}

uint32_t daft_box_acquire(daft_scene *scene, daft_vec3 size, daft_error *error)
{
    daft_assets *assets = &scene->assets;
    uint64_t hash = size_hash(size);
    for (uint32_t cursor = 0, i; (i = daft_map_next(&assets->box_map, hash, &cursor)) != DAFT_NONE;) {
        daft_box_item *box = assets->boxes[i];
        if (box->size.x != size.x || box->size.y != size.y || box->size.z != size.z) continue;
        box->users++;
        return i;
    }
    daft_box_item *box = box_reserve(scene) ? daft_alloc_zero(scene->allocator, 1, sizeof *box) : NULL;
    if (!box) {
        daft_fail_memory(error, "a box");
        return DAFT_NONE;
    }
    *box = (daft_box_item){.size = size, .users = 1};
    if (daft_trimesh_box(scene->allocator, size, &box->shape.mesh, error) && mesh_finish(scene, &box->shape, error)) {
        uint32_t index = daft_handle_index(daft_slots_add(&assets->box_slots));
        assets->boxes[index] = box;
        daft_map_add(&assets->box_map, hash, index);
        return index;
    }
    mesh_free(scene, &box->shape);
    return DAFT_NONE;
}

void daft_box_drop(daft_scene *scene, uint32_t box_index)
{
    daft_assets *assets = &scene->assets;
    daft_box_item *box = assets->boxes[box_index];
    if (--box->users > 0) return;
    daft_map_remove(&assets->box_map, size_hash(box->size), box_index);
    daft_slots_remove(&assets->box_slots, box_index);
    daft_retire(scene, &box->shape.retired, free_retired_mesh);
}

/* ---- textures ---- */

static bool texture_reserve(daft_scene *scene, daft_error *error)
{
    daft_assets *assets = &scene->assets;
    size_t count = assets->texture_slots.count, needed = daft_slots_needed(&assets->texture_slots, 1);
    return (daft_asset_reserve(scene, &assets->texture_slots, &assets->texture_states,
                               &assets->texture_state_capacity) &&
            daft_grow(scene->allocator, &assets->textures, &assets->texture_capacity, needed, count,
                      sizeof *assets->textures) &&
            daft_grow(scene->allocator, &assets->texture_keys, &assets->texture_key_capacity, needed, count,
                      sizeof *assets->texture_keys) &&
            daft_map_reserve(&assets->texture_map, scene->allocator, 1)) ||
           daft_fail_memory(error, "the list of textures");
}

static uint32_t texture_cached(const daft_scene *scene, const char *path, uint64_t hash)
{
    const daft_assets *assets = &scene->assets;
    for (uint32_t cursor = 0, i; (i = daft_map_next(&assets->texture_map, hash, &cursor)) != DAFT_NONE;)
        if (strcmp(assets->texture_keys[i].path, path) == 0) return daft_asset_id(&assets->texture_slots, i);
    return 0;
}

static bool is_same_change(const daft_texture_change *a, const daft_texture_change *b)
{
    return a->channel == b->channel && a->base == b->base && a->gain == b->gain && a->most == b->most;
}

/* The texture of the same file by another name: through links, other folders, another spelling. Files are few, and
 * reading one takes far longer than to look at all of them. */
static uint32_t texture_of_file(const daft_scene *scene, const daft_file_id *file, const daft_texture_change *change)
{
    const daft_assets *assets = &scene->assets;
    for (uint32_t i = 0; file->number && i < assets->texture_slots.count; i++) {
        const daft_texture_key *key = &assets->texture_keys[i];
        if (assets->texture_slots.items[i].live && daft_file_id_equal(&key->file, file) &&
            is_same_change(&key->change, change))
            return daft_asset_id(&assets->texture_slots, i);
    }
    return 0;
}

/* Takes the data, also on failure. */
static daft_texture texture_add(daft_scene *scene, const char *name, const char *path, const daft_texture_key *key,
                                daft_texture_data *data, daft_error *error)
{
    daft_assets *assets = &scene->assets;
    const bool room = texture_reserve(scene, error) && daft_scene_note_file(scene, path, error);
    char *copy = room ? daft_copy_string(scene->allocator, name) : NULL;
    if (!copy) {
        daft_fail_memory(error, "a texture's path");
        daft_texture_free(scene->allocator, data);
        return (daft_texture){0};
    }
    uint64_t hash = daft_path_hash(name);
    daft_texture texture = {daft_asset_add(scene, &assets->texture_slots, assets->texture_states)};
    uint32_t index = daft_asset_index(texture.id);
    assets->textures[index] = *data;
    scene->looks = assets->textures[index].revision = ++scene->engine->revision;
    assets->texture_keys[index] = *key;
    assets->texture_keys[index].path = copy, assets->texture_keys[index].hash = hash;
    daft_map_add(&assets->texture_map, hash, index);
    return texture;
}

static void free_retired_texture(const daft_scene *scene, daft_retired *item)
{
    daft_texture_free(scene->allocator, &((daft_texture_item *)item)->data);
    daft_release(scene->allocator, item);
}

bool daft_texture_drop(daft_scene *scene, uint32_t index)
{
    daft_texture_item *old = daft_alloc_zero(scene->allocator, 1, sizeof *old);
    if (!old) return false;
    old->data = scene->assets.textures[index];
    daft_opacity_forget(scene, old->data.revision);
    scene->looks = ++scene->engine->revision;
    texture_forget(scene, index);
    daft_retire(scene, &old->retired, free_retired_texture);
    return true;
}

/* Takes the data, also on failure. */
static daft_texture replace_texture(daft_scene *scene, uint32_t texture, daft_texture_data *data, daft_error *error)
{
    daft_texture_item *old = daft_alloc_zero(scene->allocator, 1, sizeof *old);
    if (!old) {
        daft_fail_memory(error, "a texture");
        daft_texture_free(scene->allocator, data);
        return (daft_texture){0};
    }
    daft_texture_data *place = &scene->assets.textures[daft_asset_index(texture)];
    old->data = *place;
    daft_opacity_forget(scene, old->data.revision);
    *place = *data;
    scene->looks = place->revision = ++scene->engine->revision;
    daft_material_refresh(scene, texture);
    daft_scene_touch(scene);
    daft_retire(scene, &old->retired, free_retired_texture);
    return (daft_texture){texture};
}

static bool read_texture(const daft_scene *scene, const char *path, const daft_texture_change *change,
                         daft_texture_data *out, daft_error *error)
{
    daft_image_file file = {.path = path};
    char *bytes = daft_file_read(scene->allocator, scene->engine->files, path, &file.size, error);
    file.bytes = bytes;
    const bool done = bytes && daft_texture_share(&scene->engine->images, scene->allocator, &file, change, out, error);
    daft_release(scene->allocator, bytes);
    return done;
}

/* Fills the key, and gives the texture that there is of its file, or 0. */
static uint32_t texture_shared(daft_scene *scene, const char *path, daft_texture_key *key)
{
    if (!daft_file_identify(scene->engine->files, path, &key->file)) {
        key->file = (daft_file_id){0};
        return 0;
    }
    uint32_t texture = texture_of_file(scene, &key->file, &key->change);
    return texture && daft_scene_note_file(scene, path, NULL) ? texture : 0;
}

static daft_texture texture_hold(daft_scene *scene, uint32_t texture)
{
    scene->assets.texture_states[daft_asset_index(texture)].holds++;
    return (daft_texture){texture};
}

daft_texture daft_texture_load(daft_scene *scene, const char *path, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "path", path)) return (daft_texture){0};
    uint32_t cached = texture_cached(scene, path, daft_path_hash(path));
    bool missing = cached && scene->assets.textures[daft_asset_index(cached)].missing;
    daft_texture_key key = {0};
    if (!cached || missing) {
        const uint32_t shared = texture_shared(scene, path, &key);
        if (shared && !missing) return texture_hold(scene, shared);
        daft_texture_data data = {0};
        if (!read_texture(scene, path, NULL, &data, error)) return (daft_texture){0};
        if (!cached) return texture_add(scene, path, path, &key, &data, error);
        /* a material has asked for it before it was there: the checker gives way */
        if (!replace_texture(scene, cached, &data, error).id) return (daft_texture){0};
        scene->assets.texture_keys[daft_asset_index(cached)].file = key.file;
    }
    return texture_hold(scene, cached);
}

/* A map of a material: what it is, and its name in the cache, where a changed image has another than its file. */
typedef struct map_source {
    const char *path;
    const uint8_t *bytes;
    size_t size;
    int line, column;
    daft_texture_change change;
    char key[1100];
} map_source;

static daft_texture_change change_of(const daft_mtl_change *c)
{
    return (daft_texture_change){c->channel, c->base, c->gain, c->most};
}

static void find_map(const daft_mtl *mtl, daft_mtl_use use, map_source *out)
{
    if (use == DAFT_MTL_DIFFUSE) {
        *out = (map_source){.path = mtl->diffuse_map, .bytes = mtl->map_bytes, .size = mtl->map_size};
        out->line = mtl->diffuse_map_line, out->column = mtl->diffuse_map_column,
        out->change = change_of(&mtl->diffuse_change);
    } else {
        const daft_mtl_map *map = &mtl->maps->map[use];
        *out = (map_source){.path = map->path, .bytes = map->bytes, .size = map->size};
        out->line = map->line, out->column = map->column, out->change = change_of(&map->change);
    }
    const daft_texture_change *c = &out->change;
    if (daft_texture_is_changed(c))
        snprintf(out->key, sizeof out->key, "%.1000s|%c %g %g %d", out->path, c->channel ? c->channel : '-',
                 (double)c->base, (double)c->gain, c->most);
    else
        snprintf(out->key, sizeof out->key, "%.1023s", out->path);
}

static bool read_map(const daft_scene *scene, const map_source *map, daft_texture_data *out, daft_error *why)
{
    const daft_image_file held = {map->path, map->bytes, map->size};
    if (map->bytes) return daft_texture_share(&scene->engine->images, scene->allocator, &held, NULL, out, why);
    return read_texture(scene, map->path, daft_texture_is_changed(&map->change) ? &map->change : NULL, out, why);
}

daft_texture daft_texture_of_map(daft_scene *scene, const daft_mtl *mtl, daft_mtl_use use, daft_error *error)
{
    map_source map;
    find_map(mtl, use, &map);
    daft_texture_key key = {0};
    if (daft_texture_is_changed(&map.change)) key.change = map.change;
    uint32_t cached = texture_cached(scene, map.key, daft_path_hash(map.key));
    if (!cached && !map.bytes) cached = texture_shared(scene, map.path, &key);
    if (cached) return texture_hold(scene, cached);
    daft_texture_data data = {0};
    daft_error why = {0};
    if (read_map(scene, &map, &data, &why)) return texture_add(scene, map.key, map.path, &key, &data, error);
    if (why.code == DAFT_ERROR_MEMORY) {
        if (error) *error = why;
        return (daft_texture){0};
    }
    if (!daft_texture_missing(scene->allocator, &data, error)) return (daft_texture){0};
    key.file = (daft_file_id){0};
    daft_texture texture = texture_add(scene, map.key, map.path, &key, &data, error);
    if (texture.id)
        daft_warn_at(&scene->engine->log, why.code, mtl->file, map.line, map.column,
                     "a checker stands in for the texture %s: %s", map.path, why.message);
    return texture;
}

const daft_mtl_map *daft_cube_maps(const daft_mtl *mtl, const daft_error *why, const char *paths[6])
{
    const daft_mtl_map *at = &mtl->maps->map[DAFT_MTL_CUBE], *bad = at;
    for (int i = 0; i < 6; i++) {
        paths[i] = at[i].path;
        if (why && strcmp(why->file, paths[i]) == 0) bad = &at[i];
    }
    return bad;
}

bool daft_texture_of_cube_map(daft_scene *scene, const daft_mtl *mtl, daft_texture *out, daft_error *error)
{
    const char *paths[6];
    const daft_mtl_map *first = daft_cube_maps(mtl, NULL, paths);
    const daft_texture_change change = change_of(&first->change);
    uint64_t hash = daft_hash(&change.channel, 1, 0);
    const float numbers[] = {change.base, change.gain, (float)change.most};
    hash = daft_hash(numbers, sizeof numbers, hash);
    for (int i = 0; i < 6; i++) hash = daft_hash(paths[i], strlen(paths[i]) + 1, hash);
    char name[1100];
    snprintf(name, sizeof name, "%.1023s|cube %016llx", paths[0], (unsigned long long)hash);
    const uint32_t cached = texture_cached(scene, name, daft_path_hash(name));
    *out = cached ? texture_hold(scene, cached) : (daft_texture){0};
    if (cached) return true;

    daft_sky_image cube;
    daft_texture_data data = {0};
    daft_texture_key key = {0};
    daft_error why = {0};
    bool done = daft_sky_images_read(scene->engine, paths, 6, &cube, &why);
    if (done) {
        done = daft_texture_of_cube(scene->allocator, &cube, &change, &data, &why);
        daft_sky_free(scene->allocator, &cube);
    }
    if (done) {
        *out = texture_add(scene, name, paths[0], &key, &data, error);
        return out->id && daft_sky_note_files(scene, paths, 6, error);
    }
    if (why.code == DAFT_ERROR_MEMORY) {
        if (error) *error = why;
        return false;
    }
    const daft_mtl_map *bad = daft_cube_maps(mtl, &why, paths);
    daft_warn_at(&scene->engine->log, why.code, mtl->file, bad->line, bad->column,
                 "the cube that is mirrored is left out: %s: %s", bad->path, why.message);
    return true;
}

bool daft_texture_check(const daft_scene *scene, daft_texture texture, daft_error *error)
{
    return texture.id == 0 || daft_asset_find(&scene->assets.texture_slots, texture.id) != DAFT_NONE ||
           daft_fail(error, DAFT_ERROR_HANDLE, "texture %u is not one of this scene", texture.id);
}
