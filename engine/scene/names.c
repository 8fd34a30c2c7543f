/* The entities that scene files name. */
#include "scene/scene.h"

#include <string.h>

static char *copy_of(const daft_allocator *allocator, const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = daft_alloc(allocator, size, 1);
    return copy ? memcpy(copy, text, size) : NULL;
}

bool daft_names_reserve(daft_scene *scene, const char *const *names, uint32_t more, daft_error *error)
{
    const size_t needed = (size_t)scene->name_count + more;
    if (!daft_grow(scene->allocator, &scene->names, &scene->name_capacity, needed, scene->name_count,
                   sizeof *scene->names))
        return daft_fail_memory(error, "the list of names");
    daft_named_entity *next = scene->names + scene->name_count;
    for (uint32_t i = 0; i < more; i++) {
        next[i] = (daft_named_entity){.name = copy_of(scene->allocator, names[i])};
        if (next[i].name) continue;
        while (i-- > 0) daft_release(scene->allocator, (char *)next[i].name);
        return daft_fail_memory(error, "the list of names");
    }
    return true;
}

void daft_name_insert(daft_scene *scene, daft_entity entity) { scene->names[scene->name_count++].entity = entity; }

void daft_names_free(daft_scene *scene)
{
    for (uint32_t i = 0; i < scene->name_count; i++) daft_release(scene->allocator, (char *)scene->names[i].name);
    daft_release(scene->allocator, scene->names);
}

uint32_t daft_scene_named_count(const daft_scene *scene) { return scene ? scene->name_count : 0; }

bool daft_scene_get_named(const daft_scene *scene, uint32_t index, daft_named_entity *out, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "out", out)) return false;
    if (index >= scene->name_count)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "name %u of %u; the first is 0", index, scene->name_count);
    *out = scene->names[index];
    return true;
}
