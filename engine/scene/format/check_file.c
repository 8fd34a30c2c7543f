/* daft_check_file and daft_mesh_check: files are read as loading reads them, into a scene that is thrown away, with the
 * engine's warnings turned to whoever asked; what loading need not look at is examined here. */
#include "scene/format/check_file.h"

#include "geometry/rig.h"

#include <string.h>
#include <strings.h>

bool daft_mesh_check(daft_scene *scene, daft_mesh mesh, daft_mesh_report *report, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "report", report)) return false;
    const daft_mesh_item *item = daft_mesh_find(scene, mesh, error);
    daft_mesh_report found;
    if (!item || !daft_trimesh_check(scene->allocator, &item->mesh, NULL, NULL, &found, error)) return false;
    *report = found;
    return true;
}

/* ---- materials and pictures ---- */

static void on_warning(void *user, const daft_error *warning)
{
    const daft_problems *problems = user;
    problems->found(problems->user, DAFT_SEVERITY_WARNING, warning);
}

/* The file's own error is a problem; memory that is out is this call's. */
static bool refuse(const daft_problems *problems, const daft_error *why, daft_error *error)
{
    if (why->code == DAFT_ERROR_MEMORY) {
        if (error) *error = *why;
        return false;
    }
    problems->found(problems->user, DAFT_SEVERITY_ERROR, why);
    return true;
}

static bool map_is_repeated(const daft_mtl_list *list, size_t index)
{
    for (size_t i = 0; i < index; i++)
        if (strcmp(list->items[i].diffuse_map, list->items[index].diffuse_map) == 0) return true;
    return false;
}

static void check_map(const daft_engine *engine, const daft_problems *problems, const daft_mtl *mtl, const char *path,
                      int line, int column)
{
    daft_texture_data texture = {0};
    daft_error why = {0};
    if (daft_texture_read(&engine->allocator, engine->files, path, &texture, &why))
        daft_texture_free(&engine->allocator, &texture);
    else
        daft_problem_at(problems, DAFT_SEVERITY_WARNING, why.code, mtl->file, line, column,
                        "a checker stands in for the texture %s: %s", path, why.message);
}

static void check_cube(daft_engine *engine, const daft_problems *problems, const daft_mtl *mtl)
{
    const char *paths[6];
    daft_sky_image cube;
    daft_error why = {0};
    if (!daft_cube_maps(mtl, NULL, paths)->path[0]) return;
    if (daft_sky_images_read(engine, paths, 6, &cube, &why)) {
        daft_sky_free(&engine->allocator, &cube);
        return;
    }
    const daft_mtl_map *bad = daft_cube_maps(mtl, &why, paths);
    daft_problem_at(problems, DAFT_SEVERITY_WARNING, why.code, mtl->file, bad->line, bad->column,
                    "the cube that is mirrored is left out: %s: %s", bad->path, why.message);
}

static void check_maps(daft_engine *engine, const daft_problems *problems, const daft_mtl_list *list)
{
    for (size_t i = 0; i < list->count; i++) {
        const daft_mtl *mtl = &list->items[i];
        for (int k = 0; mtl->maps && k < DAFT_MTL_CUBE; k++) {
            const daft_mtl_map *map = &mtl->maps->map[k];
            if (map->path[0]) check_map(engine, problems, mtl, map->path, map->line, map->column);
        }
        if (mtl->maps) check_cube(engine, problems, mtl);
        if (mtl->diffuse_map[0] && !map_is_repeated(list, i))
            check_map(engine, problems, mtl, mtl->diffuse_map, mtl->diffuse_map_line, mtl->diffuse_map_column);
    }
}

/* What an MTL says of light that passes and that does not go together. */
static void check_transmission(const daft_problems *problems, const daft_mtl *mtl)
{
    daft_material_def def = daft_default_material_def();
    daft_material_transmit(mtl, &def);
    bool refracts = mtl->illum == 6 || mtl->illum == 7, glass = mtl->illum == 4 || mtl->illum == 9;
    if ((refracts || glass) && mtl->has_filter && mtl->filter.x == 0 && mtl->filter.y == 0 && mtl->filter.z == 0)
        daft_problem_at(problems, DAFT_SEVERITY_WARNING, DAFT_ERROR_ARGUMENT, mtl->file, 0, 0,
                        "the material '%s' should let light through (illum %d), but its Tf is black", mtl->name,
                        mtl->illum);
    else if (refracts && def.refractive_index == 1)
        daft_problem_at(problems, DAFT_SEVERITY_NOTE, DAFT_ERROR_ARGUMENT, mtl->file, 0, 0,
                        "the material '%s' should bend light (illum %d), but its Ni is 1", mtl->name, mtl->illum);
    else if (def.transmission == 1 && def.refractive_index == 1)
        daft_problem_at(problems, DAFT_SEVERITY_WARNING, DAFT_ERROR_ARGUMENT, mtl->file, 0, 0,
                        "the material '%s' lets all light through: nothing but its highlights is seen", mtl->name);
}

/* A refracted ray needs a closed mesh: it leaves through another surface. */
static bool check_solid(const daft_allocator *allocator, const char *path, const daft_problems *problems,
                        const daft_obj *obj, daft_error *error)
{
    bool bends = false;
    for (size_t i = 0; i < obj->slots.count; i++) {
        daft_material_def def = daft_default_material_def();
        daft_material_transmit(&obj->slots.items[i], &def);
        bends |= def.transmission > 0 && def.refractive_index != 1;
    }
    daft_mesh_report report;
    if (!bends) return true;
    if (!daft_trimesh_check(allocator, &obj->mesh, NULL, NULL, &report, error)) return false;
    if (report.open_edges)
        daft_problem_at(problems, DAFT_SEVERITY_WARNING, DAFT_ERROR_ARGUMENT, path, 0, 0,
                        "light is bent where it enters, and the mesh is not closed: some may not come out again");
    return true;
}

static bool check_obj(daft_engine *engine, const char *path, const daft_problems *problems, daft_error *error)
{
    daft_obj obj;
    daft_error why = {0};
    if (!daft_obj_check(&engine->allocator, engine->files, path, &engine->log, problems, &obj, &why))
        return refuse(problems, &why, error);
    check_maps(engine, problems, &obj.slots);
    for (size_t i = 0; i < obj.slots.count; i++) check_transmission(problems, &obj.slots.items[i]);
    bool done = check_solid(&engine->allocator, path, problems, &obj, error);
    daft_obj_free(&engine->allocator, &obj);
    return done;
}

/* What can be played, and how long it takes. */
static void tell_clips(const daft_problems *problems, const char *path, const daft_rig *rig)
{
    for (uint32_t i = 0; rig && i < rig->clip_count; i++)
        daft_problem_at(problems, DAFT_SEVERITY_NOTE, DAFT_OK, path, 0, 0, "clip '%s': %.3g s, %u channels",
                        rig->clips[i].name, rig->clips[i].duration, rig->clips[i].track_count);
}

static void tell_scenery(const daft_problems *problems, const char *path, const daft_scenery *all)
{
    static const char *const KINDS[] = {
        [DAFT_LIGHT_POINT] = "point", [DAFT_LIGHT_SUN] = "sun", [DAFT_LIGHT_SPOT] = "spot"};
    for (uint32_t i = 0; i < all->camera_count; i++)
        daft_problem_at(problems, DAFT_SEVERITY_NOTE, DAFT_OK, path, 0, 0, "camera %u: '%s'", i, all->cameras[i].name);
    for (uint32_t i = 0; i < all->light_count; i++)
        daft_problem_at(problems, DAFT_SEVERITY_NOTE, DAFT_OK, path, 0, 0, "light '%s': %s", all->lights[i].name,
                        KINDS[all->lights[i].kind]);
}

static bool check_model(daft_engine *engine, const char *path, const daft_problems *problems, daft_error *error)
{
    daft_obj model;
    daft_mesh_report report;
    daft_error why = {0};
    if (!daft_model_load(&engine->allocator, engine->files, path, &engine->log, &model, &why))
        return refuse(problems, &why, error);
    if (model.mesh.triangle_count == 0)
        daft_problem_at(problems, DAFT_SEVERITY_WARNING, DAFT_ERROR_ARGUMENT, path, 0, 0,
                        "there are no triangles to draw");
    if (model.mesh.left_out)
        daft_problem_at(problems, DAFT_SEVERITY_NOTE, DAFT_ERROR_ARGUMENT, path, 0, 0,
                        "%u triangles are left out: their corners are not three", model.mesh.left_out);
    bool done = daft_trimesh_check(&engine->allocator, &model.mesh, NULL, NULL, &report, error);
    if (done && report.open_edges)
        daft_problem_at(problems, DAFT_SEVERITY_NOTE, DAFT_ERROR_ARGUMENT, path, 0, 0,
                        "%u edges are open: the mesh is not closed", report.open_edges);
    tell_clips(problems, path, model.rig);
    tell_scenery(problems, path, &model.scenery);
    daft_obj_free(&engine->allocator, &model);
    return done;
}

static bool check_mtl(daft_engine *engine, const char *path, const daft_problems *problems, daft_error *error)
{
    daft_mtl_list list = {0};
    daft_error why = {0};
    bool read = daft_mtl_load(&engine->allocator, engine->files, path, &engine->log, &list, &why);
    for (size_t i = 0; i < list.count; i++) {
        check_transmission(problems, &list.items[i]);
        for (size_t k = 0; k < i; k++)
            if (strcmp(list.items[i].name, list.items[k].name) == 0) {
                daft_problem_at(problems, DAFT_SEVERITY_WARNING, DAFT_ERROR_SYNTAX, path, 0, 0,
                                "the material '%s' is there twice: the first counts", list.items[i].name);
                break;
            }
    }
    check_maps(engine, problems, &list);
    daft_mtl_list_free(&engine->allocator, &list); /* after a failure too: it keeps its room */
    return read || refuse(problems, &why, error);
}

static bool check_picture(daft_engine *engine, const char *path, const daft_problems *problems, daft_error *error)
{
    daft_error why = {0};
    daft_image *image = daft_image_load(engine, path, &why);
    daft_image_destroy(image);
    return image || refuse(problems, &why, error);
}

/* ---- the caller's callback ---- */

typedef struct caller {
    daft_engine *engine;
    daft_problem_callback *found;
    void *user;
} caller;

static void tell(void *user, daft_severity severity, const daft_error *problem)
{
    const caller *c = user;
    c->engine->callbacks++;
    c->found(c->user, severity, problem);
    c->engine->callbacks--;
}

/* ---- which file ---- */

static bool ends_in(const char *path, const char *extension)
{
    size_t length = strlen(path), tail = strlen(extension);
    return length > tail && strcasecmp(path + length - tail, extension) == 0;
}

static bool is_model(const char *path)
{
    static const char *const known[] = {".gltf", ".glb", ".fbx", ".dae", ".ply", ".stl", ".3ds", ".blend"};
    for (size_t i = 0; i < DAFT_COUNT_OF(known); i++)
        if (ends_in(path, known[i])) return true;
    return false;
}

bool daft_check_file(daft_engine *engine, const char *path, daft_problem_callback *found, void *user, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_engine_ready(engine, error) || !daft_check_pointer(error, "path", path)) return false;
    if (!found) return daft_fail(error, DAFT_ERROR_ARGUMENT, "found is NULL");
    daft_problems problems = {tell, &(caller){engine, found, user}};
    daft_log kept = engine->log;
    engine->log = (daft_log){.warn = on_warning, .user = &problems, .checks = true};
    bool done = (is_model(path)            ? check_model
                 : ends_in(path, ".obj")   ? check_obj
                 : ends_in(path, ".mtl")   ? check_mtl
                 : ends_in(path, ".scene") ? daft_check_scene
                                           : check_picture)(engine, path, &problems, error);
    engine->log = kept;
    return done;
}
