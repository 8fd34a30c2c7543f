/* Loading a .scene file, and how daft_check_file looks on meanwhile.
 * Public headers: none */
#ifndef DAFT_SCENE_FILE_H
#define DAFT_SCENE_FILE_H

#include "scene/format/items.h"

typedef struct daft_scene_watch {
    /* Told of an error in a line; the load goes on without that line. */
    void (*refused)(void *user, const daft_error *error);
    /* Told of all items once the scene has them; they are gone afterwards. */
    void (*loaded)(void *user, const daft_scene_item *items, size_t count);
    void *user;
} daft_scene_watch;

/* daft_scene_load with somebody looking on; `watch` may be NULL. */
bool daft_scene_load_watched(daft_scene *scene, const char *path, const daft_scene_watch *watch, daft_error *error);

#endif
