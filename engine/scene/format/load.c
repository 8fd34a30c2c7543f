/* Loading .scene files: every line becomes an item of a list (items.c), then all files are loaded that the items name,
 * then room is made for everything, and only then, when nothing can fail any more, the scene changes. */
#include "scene/format/load.h"

#include <string.h>

enum { MAX_INCLUDES = 16 };

typedef daft_scene_item item;

/* A file that is being read, and the one that includes it. */
typedef struct source {
    const char *path;
    daft_file_id id;
    const struct source *parent;
    int depth;
} source;

typedef struct loader {
    daft_scene *scene;
    daft_arena arena; /* paths */
    item *items;
    size_t count, capacity;
    daft_map materials;            /* from hashes of names to items */
    daft_sky_item *sky;            /* the last one named, or NULL */
    const daft_scene_watch *watch; /* or NULL */
    daft_error error;
} loader;

static bool read_file(loader *load, const char *path, const source *parent);

/* ---- files ---- */

/* An error about a file as a whole is told where the .scene file names it; one with a line of its own stays. */
static bool fail_inside(loader *load, const item *named)
{
    daft_error inner = load->error;
    if (inner.code == DAFT_ERROR_MEMORY || inner.line > 0) return false;
    return daft_fail_at(&load->error, inner.code, named->source, named->line, named->column, "%s%s%s", inner.file,
                        inner.file[0] ? ": " : "", inner.message);
}

/* Whether a watch takes the error, so that the load goes on. Memory that is out ends it. */
static bool goes_on(loader *load)
{
    if (!load->watch || load->error.code == DAFT_ERROR_MEMORY) return false;
    load->watch->refused(load->watch->user, &load->error);
    return true;
}

static bool read_include(loader *load, const daft_scene_text *text, const source *from, const item *named)
{
    if (from->depth == MAX_INCLUDES)
        return daft_scene_text_fail(text, named->column, "includes are more than %d deep", MAX_INCLUDES);
    daft_file_id id;
    bool exists = daft_file_identify(load->scene->engine->files, named->path, &id);
    for (const source *above = from; exists && above; above = above->parent)
        if (above->id.device == id.device && above->id.number == id.number)
            return daft_scene_text_fail(text, named->column, "%.300s includes itself", named->path);
    return read_file(load, named->path, from) || fail_inside(load, named);
}

static bool keep_item(loader *load, const item *made)
{
    if (!daft_grow(load->scene->allocator, &load->items, &load->capacity, load->count + 1, load->count, sizeof *made))
        return daft_fail_memory(&load->error, "a scene file");
    load->items[load->count++] = *made;
    return true;
}

static bool read_line(loader *load, daft_scene_text *text, const source *from)
{
    item made;
    if (!daft_scene_item_read(text, &load->arena, &made)) return false;
    return made.kind == DAFT_ITEM_INCLUDE ? read_include(load, text, from, &made) : keep_item(load, &made);
}

static bool read_lines(loader *load, daft_scene_text *text, const source *from)
{
    bool any = false;
    while (daft_scene_text_line(text)) {
        if (!read_line(load, text, from)) {
            if (!goes_on(load)) return false;
            daft_scene_text_skip_item(text);
        }
        any = true;
    }
    return any || daft_fail_at(&load->error, DAFT_ERROR_SYNTAX, from->path, text->line, 1,
                               "no item in the file; expected at least one, as in: camera 0 0 0");
}

static bool read_file(loader *load, const char *path, const source *parent)
{
    const daft_allocator *allocator = load->scene->allocator;
    source self = {.path = path, .parent = parent, .depth = parent ? parent->depth + 1 : 0};
    daft_file_identify(load->scene->engine->files, path, &self.id);
    size_t size;
    char *bytes = daft_file_read(allocator, load->scene->engine->files, path, &size, &load->error);
    if (!bytes) return false;
    daft_scene_text text = daft_scene_text_open(path, bytes, size, &load->error);
    bool done = daft_scene_note_file(load->scene, path, &load->error) && read_lines(load, &text, &self);
    daft_release(allocator, bytes);
    return done;
}

/* ---- assets, then the scene itself ---- */

static bool load_sky(loader *load, const item *named)
{
    const char *const paths[6] = {named->path,     named->faces[0], named->faces[1],
                                  named->faces[2], named->faces[3], named->faces[4]};
    const int count = paths[1] ? 6 : 1;
    daft_sky_item *sky = daft_sky_item_read(load->scene, paths, count, &load->error);
    if (!sky) return false;
    daft_sky_item_free(load->scene, load->sky);
    load->sky = sky;
    return daft_sky_note_files(load->scene, paths, count, &load->error);
}

/* Checkpoints ascend, also after those that the scene already has. */
static bool check_checkpoint(loader *load, const item *named)
{
    const daft_scene *scene = load->scene;
    double before = scene->path_count > 0 ? scene->path[scene->path_count - 1].time : -1;
    for (const item *at = load->items; at < named; at++)
        if (at->kind == DAFT_ITEM_PATH) before = at->time;
    if (!(named->time > before))
        return daft_fail(&load->error, DAFT_ERROR_SYNTAX,
                         "the checkpoint at %g s must come after the one before it, at %g s", named->time, before);
    return daft_check_camera(&load->error, "path", &named->camera);
}

/* The animation that the mesh's entity gets when all is loaded. */
static bool load_clip(loader *load, item *named)
{
    daft_scene *scene = load->scene;
    daft_play_def def = daft_default_play_def();
    daft_error why;
    if (!named->clip) return true;
    if (!daft_mesh_find_clip(scene, named->entity.mesh, named->clip, &def.clip, &why))
        return daft_fail_at(&load->error, DAFT_ERROR_SYNTAX, named->source, named->line, named->clip_column, "%s",
                            why.message);
    const daft_mesh_item *mesh = scene->assets.meshes[daft_asset_index(named->entity.mesh.id)];
    named->animated = daft_animated_make(scene, mesh, &def, &load->error);
    return named->animated != NULL;
}

/* ---- materials by name ---- */

static item *find_material(const loader *load, const char *name)
{
    uint32_t cursor = 0, at;
    const uint64_t hash = daft_hash(name, strlen(name), 0);
    while ((at = daft_map_next(&load->materials, hash, &cursor)) != DAFT_NONE)
        if (strcmp(load->items[at].material, name) == 0) return &load->items[at];
    return NULL;
}

static bool load_images(loader *load, item *made)
{
    for (const daft_scene_map *map = made->maps; map; map = map->next) {
        daft_texture *texture = (daft_texture *)(void *)((char *)&made->def + map->field->offset);
        *texture = daft_texture_load(load->scene, map->path, &load->error);
        if (texture->id) continue;
        made->line = map->line, made->column = map->column;
        return false;
    }
    return true;
}

static void release_images(loader *load, item *made)
{
    for (const daft_scene_map *map = made->maps; map; map = map->next) {
        daft_texture *texture = (daft_texture *)(void *)((char *)&made->def + map->field->offset);
        if (texture->id) daft_texture_release(load->scene, *texture, NULL); /* the material uses it */
    }
}

/* Makes it, and leaves its handle to be found by its name. */
static bool make_material(loader *load, item *made)
{
    daft_assets *assets = &load->scene->assets;
    const item *before = find_material(load, made->material);
    if (before)
        return daft_fail_at(&load->error, DAFT_ERROR_SYNTAX, made->source, made->line, made->material_column,
                            "there is a material '%.80s' already: %.300s:%d", made->material, before->source,
                            before->line);
    char *name = daft_copy_string(load->scene->allocator, made->material);
    if (!name) return daft_fail_memory(&load->error, "the name of a material");
    if (load_images(load, made)) made->made = daft_material_create(load->scene, &made->def, &load->error);
    release_images(load, made);
    if (!made->made.id) return daft_release(load->scene->allocator, name), false;
    assets->material_names[daft_asset_index(made->made.id)] = name;
    daft_material_release(load->scene, made->made, NULL); /* entities use it */
    daft_map_add(&load->materials, daft_hash(name, strlen(name), 0), (uint32_t)(made - load->items));
    return true;
}

static bool fail_material(loader *load, const item *named)
{
    const char *near = NULL;
    for (size_t i = 0; i < load->count; i++)
        if (load->items[i].kind == DAFT_ITEM_MATERIAL)
            near = daft_scene_text_nearer(named->material, load->items[i].material, near);
    return daft_fail_at(&load->error, DAFT_ERROR_SYNTAX, named->source, named->line, named->material_column,
                        near ? "there is no material '%.80s': did you mean '%.80s'?" : "there is no material '%.80s'",
                        named->material, near);
}

static bool use_material(const loader *load, item *named)
{
    item *made = named->material ? find_material(load, named->material) : NULL;
    if (!made) return false;
    made->used = true;
    named->entity.material = made->made;
    return true;
}

/* A sphere's path is a material's name where there is one. */
static bool load_sphere(loader *load, item *named)
{
    daft_entity_def *entity = &named->entity;
    if (!use_material(load, named)) {
        entity->material = daft_material_load(load->scene, named->path, &load->error);
        if (!entity->material.id) return false;
        daft_material_release(load->scene, entity->material, NULL); /* the entity uses it */
    }
    return daft_entity_check(load->scene, entity, &load->error);
}

static bool load_mesh(loader *load, item *named)
{
    daft_scene *scene = load->scene;
    daft_entity_def *entity = &named->entity;
    if (named->material && !use_material(load, named)) return fail_material(load, named);
    entity->mesh = daft_mesh_load(scene, named->path, &load->error);
    if (!entity->mesh.id) return false;
    daft_mesh_release(scene, entity->mesh, NULL);
    return daft_entity_check(scene, entity, &load->error) && load_clip(load, named);
}

static bool load_asset(loader *load, item *named)
{
    switch (named->kind) {
    case DAFT_ITEM_SKYBOX: return load_sky(load, named);
    case DAFT_ITEM_MATERIAL: return make_material(load, named);
    case DAFT_ITEM_SPHERE: return load_sphere(load, named);
    case DAFT_ITEM_MESH: return load_mesh(load, named);
    case DAFT_ITEM_LIGHT: return daft_light_check(&named->light, &load->error);
    case DAFT_ITEM_CAMERA: return daft_check_camera(&load->error, "camera", &named->camera);
    case DAFT_ITEM_PATH: return check_checkpoint(load, named);
    case DAFT_ITEM_AMBIENT:
    case DAFT_ITEM_AMBIENT_SKY:
    case DAFT_ITEM_EXPOSURE:
    case DAFT_ITEM_FOG:
    case DAFT_ITEM_SKY:
    case DAFT_ITEM_QUALITY:
    case DAFT_ITEM_INCLUDE:
    case DAFT_ITEM_REFUSED: break;
    }
    return true;
}

/* What the file of a mesh has that its line asks for; NULL: nothing. */
static const daft_scenery *scenery_of(const daft_scene *scene, const item *made)
{
    if (made->kind != DAFT_ITEM_MESH || !(made->lights || made->cameras)) return NULL;
    return &scene->assets.meshes[daft_asset_index(made->entity.mesh.id)]->scenery;
}

/* Last of all, since it changes what lies behind the scene's names. */
static bool reserve_names(loader *load)
{
    const char **names = daft_arena_alloc(&load->arena, load->count, sizeof *names);
    uint32_t count = 0;
    if (!names) return daft_fail_memory(&load->error, "a scene file's names");
    for (size_t i = 0; i < load->count; i++)
        if (load->items[i].name && load->items[i].kind != DAFT_ITEM_REFUSED) names[count++] = load->items[i].name;
    return daft_names_reserve(load->scene, names, count, &load->error);
}

static bool reserve(loader *load)
{
    uint32_t cameras = 0, checkpoints = 0, lights = 0, entities = 0;
    for (size_t i = 0; i < load->count; i++) {
        cameras += load->items[i].kind == DAFT_ITEM_CAMERA;
        checkpoints += load->items[i].kind == DAFT_ITEM_PATH;
        lights += load->items[i].kind == DAFT_ITEM_LIGHT;
        entities += load->items[i].kind == DAFT_ITEM_SPHERE || load->items[i].kind == DAFT_ITEM_MESH;
        const daft_scenery *own = scenery_of(load->scene, &load->items[i]);
        if (own && load->items[i].cameras) cameras += own->camera_count;
        if (own && load->items[i].lights) lights += own->light_count;
    }
    return daft_cameras_reserve(load->scene, cameras, &load->error) &&
           daft_path_reserve(load->scene, checkpoints, &load->error) &&
           daft_lights_reserve(load->scene, lights, &load->error) &&
           daft_entities_reserve(load->scene, entities, &load->error) && reserve_names(load);
}

static void insert_entity(daft_scene *scene, item *made)
{
    const daft_entity entity = daft_entity_insert(scene, &made->entity, DAFT_NONE, NULL);
    if (made->name) daft_name_insert(scene, entity);
    if (made->animated) daft_animated_attach(scene, daft_handle_index(entity.id), made->animated);
    made->animated = NULL;
}

static void insert_scenery(daft_scene *scene, const item *made)
{
    const daft_scenery *own = scenery_of(scene, made);
    const daft_transform transform = {made->entity.position, made->entity.rotation, made->entity.scale};
    const daft_daffine at = daft_daffine_from(&transform);
    for (uint32_t i = 0; own && made->cameras && i < own->camera_count; i++) {
        const daft_camera camera = daft_scenery_camera(&own->cameras[i], &at);
        daft_camera_insert(scene, &camera);
    }
    for (uint32_t i = 0; own && made->lights && i < own->light_count; i++) {
        const daft_light_def light = daft_scenery_light(&own->lights[i], &at);
        daft_light_insert(scene, &light);
    }
}

static void set_sky_light(daft_scene *scene, float strength, float occlusion)
{
    scene->ambient_sky = strength, scene->occlusion = occlusion;
}

/* Cannot fail. */
static void commit(loader *load)
{
    daft_scene *scene = load->scene;
    for (size_t i = 0; i < load->count; i++) {
        item *made = &load->items[i];
        switch (made->kind) {
        case DAFT_ITEM_CAMERA: daft_camera_insert(scene, &made->camera); break;
        case DAFT_ITEM_PATH: daft_path_insert(scene, &(daft_checkpoint){made->camera, made->time}); break;
        case DAFT_ITEM_LIGHT: daft_light_insert(scene, &made->light); break;
        case DAFT_ITEM_AMBIENT:
            scene->ambient = made->ambient;
            set_sky_light(scene, 0, made->occlusion);
            break;
        case DAFT_ITEM_AMBIENT_SKY: set_sky_light(scene, made->strength, made->occlusion); break;
        case DAFT_ITEM_EXPOSURE: scene->exposure = made->exposure; break;
        case DAFT_ITEM_FOG: scene->fog = made->fog; break;
        case DAFT_ITEM_SKY: daft_scene_set_sky_gradient(scene, made->zenith, made->horizon); break;
        case DAFT_ITEM_QUALITY: scene->quality = made->quality; break;
        case DAFT_ITEM_SPHERE:
        case DAFT_ITEM_MESH:
            insert_scenery(scene, made);
            insert_entity(scene, made);
            break;
        case DAFT_ITEM_SKYBOX:
        case DAFT_ITEM_MATERIAL:
        case DAFT_ITEM_INCLUDE:
        case DAFT_ITEM_REFUSED: break;
        }
    }
    if (load->sky) daft_sky_adopt(scene, load->sky);
    load->sky = NULL;
}

/* Those of all items that are materials, or of all that are not: materials come first, wherever they stand. */
static bool load_assets(loader *load, bool materials)
{
    for (size_t i = 0; i < load->count; i++) {
        if ((load->items[i].kind == DAFT_ITEM_MATERIAL) != materials) continue;
        if (load_asset(load, &load->items[i])) continue;
        fail_inside(load, &load->items[i]);
        if (!goes_on(load)) return false;
        load->items[i].kind = DAFT_ITEM_REFUSED;
    }
    return true;
}

static bool load_all(loader *load, const char *path)
{
    if (!read_file(load, path, NULL)) return false;
    if (load->count > UINT32_MAX / 4 ||
        !daft_map_reserve(&load->materials, load->scene->allocator, (uint32_t)load->count))
        return daft_fail_memory(&load->error, "a scene file's materials");
    return load_assets(load, true) && load_assets(load, false) && reserve(load);
}

bool daft_scene_load(daft_scene *scene, const char *path, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "path", path)) return false;
    return daft_scene_load_watched(scene, path, NULL, error);
}

bool daft_scene_load_watched(daft_scene *scene, const char *path, const daft_scene_watch *watch, daft_error *error)
{
    loader load = {.scene = scene, .watch = watch};
    daft_arena_init(&load.arena, scene->allocator);
    daft_assets_mark mark = daft_assets_remember(scene);
    bool done = load_all(&load, path);
    if (done)
        commit(&load);
    else
        daft_assets_roll_back(scene, mark);
    if (done && watch) watch->loaded(watch->user, load.items, load.count);
    daft_sky_item_free(scene, load.sky);
    for (size_t i = 0; i < load.count; i++) daft_animated_free(scene, load.items[i].animated);
    daft_release(scene->allocator, load.items);
    daft_map_free(&load.materials, scene->allocator);
    daft_arena_free(&load.arena);
    if (!done && error) *error = load.error;
    return done;
}
