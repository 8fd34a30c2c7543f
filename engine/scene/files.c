/* The files that a scene has read, for programs that load it again when one of them changes. */
#include "scene/scene.h"

#include <string.h>

bool daft_scene_note_file(daft_scene *scene, const char *path, daft_error *error)
{
    const uint64_t hash = daft_path_hash(path);
    for (uint32_t i = 0; i < scene->file_count; i++)
        if (scene->files[i].hash == hash && strcmp(scene->files[i].path, path) == 0) return true;
    if (!daft_grow(scene->allocator, &scene->files, &scene->file_capacity, scene->file_count + 1, scene->file_count,
                   sizeof *scene->files))
        return daft_fail_memory(error, "the list of files");
    char *copy = daft_copy_string(scene->allocator, path);
    if (!copy) return daft_fail_memory(error, "the list of files");
    scene->files[scene->file_count++] = (daft_asset_key){copy, hash};
    return true;
}

void daft_scene_files_free(daft_scene *scene)
{
    for (uint32_t i = 0; i < scene->file_count; i++) daft_release(scene->allocator, scene->files[i].path);
    daft_release(scene->allocator, scene->files);
}

uint32_t daft_scene_file_count(const daft_scene *scene) { return scene ? scene->file_count : 0; }

const char *daft_scene_get_file(const daft_scene *scene, uint32_t index)
{
    return scene && index < scene->file_count ? scene->files[index].path : NULL;
}
