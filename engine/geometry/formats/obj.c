/* OBJ files (Wavefront's "Object Files", appendix B1 of the Advanced Visualizer manual): polygons, materials, normals.
 *
 * What is an error (nothing is loaded; the message has line and column) and what a warning (the rest is loaded):
 *
 *   error     an empty file; a file without any OBJ statement, or in UTF-16; a file none of whose faces can be used; a
 *             material file without any MTL statement
 *   dropped   a line, with a warning: a number or a corner that is none; too few numbers. Later lines keep their
 * numbers dropped   a face, with a warning: fewer than 3 corners; a position index of 0, beyond the last or before the
 * first; a NaN or infinite position; fewer than 3 different corners absent    a uv or normal, with a warning: its index
 * beyond the array. Index 0 and an empty place mean "none" and are quiet warning   a material file that is not there, a
 * material that no file defines, an unknown statement, a file without faces
 *
 * At most ten warnings of a file are told, then how many more there were. `v` may carry w, which is not used, or a
 * colour, sRGB from 0 to 1; `o g l p vw vp mg` and display hints are skipped. `s` and `usemtl` hold until the next of
 * their kind. Faces may refer to positions that come later in the file. */
#include "geometry/formats/obj.h"

#include "geometry/rig.h"
#include "geometry/trimesh.h"

void daft_obj_source_free(daft_obj_source *source)
{
    const daft_allocator *allocator = source->allocator;
    daft_release(allocator, source->x);
    daft_release(allocator, source->y);
    daft_release(allocator, source->z);
    daft_release(allocator, source->normals);
    daft_release(allocator, source->uvs);
    daft_release(allocator, source->colors);
    daft_release(allocator, source->alphas);
    daft_release(allocator, source->corner_positions);
    daft_release(allocator, source->corner_uvs);
    daft_release(allocator, source->corner_normals);
    daft_release(allocator, source->faces);
    daft_release(allocator, source->runs);
    daft_release(allocator, source->slots);
    daft_release(allocator, source->libraries);
    daft_release(allocator, source->groups);
    daft_release(allocator, source->face_of);
}

/* All that the text is needed for. */
static bool read_text(daft_obj_source *source, daft_obj *obj, daft_error *error)
{
    bool done = daft_obj_read(source, error) && daft_obj_make_mesh(source, &obj->mesh, error) &&
                daft_obj_make_slots(source, &obj->slots, error);
    obj->mesh.slot_count = (uint32_t)obj->slots.count;
    if (done) daft_text_close(&source->text);
    return done;
}

static bool finish(daft_obj_source *source, bool done, daft_obj *obj, daft_obj *out)
{
    const daft_allocator *allocator = source->allocator;
    daft_obj_source_free(source);
    if (done)
        *out = *obj;
    else
        daft_obj_free(allocator, obj);
    return done;
}

/* Takes the groups along where normals are still to be computed. */
static bool make_normals(daft_obj_source *source, daft_obj *obj, daft_error *error)
{
    if (!daft_obj_make_normals(source, &obj->mesh, error)) return false;
    if (!obj->mesh.normals) obj->groups = source->groups, source->groups = NULL;
    return true;
}

/* Frees what was loaded where that fails. */
static bool smooth_loaded(const daft_allocator *allocator, daft_obj *obj, daft_error *error)
{
    if (daft_obj_smooth(allocator, obj, error)) return true;
    daft_obj_free(allocator, obj);
    return false;
}

bool daft_obj_parse(const daft_allocator *allocator, const daft_files *files, const char *path, const char *text,
                    size_t size, const daft_log *log, daft_obj *out, daft_error *error)
{
    daft_obj obj = {0};
    daft_obj_source source = {.text = daft_text_open(path, text, size, log), .allocator = allocator, .files = files};
    bool done = read_text(&source, &obj, error) && make_normals(&source, &obj, error);
    return finish(&source, done, &obj, out) && smooth_loaded(allocator, out, error);
}

/* Releases the text once it is no longer needed. */
static bool take_triangles(const daft_allocator *allocator, const daft_files *files, const char *path, char *text,
                           size_t size, const daft_log *log, daft_obj *out, daft_error *error)
{
    daft_obj obj = {0};
    daft_obj_source source = {.text = daft_text_open(path, text, size, log), .allocator = allocator, .files = files};
    bool done = read_text(&source, &obj, error);
    daft_release(allocator, text);
    done = done && make_normals(&source, &obj, error);
    return finish(&source, done, &obj, out);
}

bool daft_obj_load_triangles(const daft_allocator *allocator, const daft_files *files, const char *path,
                             const daft_log *log, daft_obj *out, daft_error *error)
{
    size_t size;
    char *text = daft_file_read(allocator, files, path, &size, error);
    return text && take_triangles(allocator, files, path, text, size, log, out, error);
}

bool daft_obj_take(const daft_allocator *allocator, const daft_files *files, const char *path, char *text, size_t size,
                   const daft_log *log, daft_obj *out, daft_error *error)
{
    return take_triangles(allocator, files, path, text, size, log, out, error) && smooth_loaded(allocator, out, error);
}

bool daft_obj_load(const daft_allocator *allocator, const daft_files *files, const char *path, const daft_log *log,
                   daft_obj *out, daft_error *error)
{
    return daft_obj_load_triangles(allocator, files, path, log, out, error) && smooth_loaded(allocator, out, error);
}

bool daft_obj_smooth(const daft_allocator *allocator, daft_obj *obj, daft_error *error)
{
    if (obj->mesh.normals) return true;
    daft_trimesh smooth = obj->mesh;
    if (!daft_trimesh_smooth_groups(allocator, &smooth, DAFT_SMOOTH_CREASE, obj->groups, error)) {
        daft_release(allocator, smooth.normals);
        daft_release(allocator, smooth.normal_indices);
        return false;
    }
    obj->mesh = smooth;
    daft_release(allocator, obj->groups);
    obj->groups = NULL;
    return true;
}

void daft_scenery_free(const daft_allocator *allocator, daft_scenery *scenery)
{
    daft_release(allocator, scenery->cameras), daft_release(allocator, scenery->lights);
    *scenery = (daft_scenery){0};
}

void daft_obj_free(const daft_allocator *allocator, daft_obj *obj)
{
    daft_trimesh_free(allocator, &obj->mesh);
    daft_mtl_list_free(allocator, &obj->slots);
    daft_release(allocator, obj->groups);
    daft_rig_free(allocator, obj->rig);
    daft_scenery_free(allocator, &obj->scenery);
    obj->groups = NULL, obj->rig = NULL;
}
