/* What a line of a .scene file says, and how daft_check_file looks on while files are read.
 * Public headers: none */
#ifndef DAFT_SCENE_FILE_H
#define DAFT_SCENE_FILE_H

#include "scene/scene.h"

typedef enum daft_scene_item_kind {
    DAFT_ITEM_CAMERA,
    DAFT_ITEM_SKYBOX,
    DAFT_ITEM_LIGHT,
    DAFT_ITEM_AMBIENT,
    DAFT_ITEM_SPHERE,
    DAFT_ITEM_MESH,
    DAFT_ITEM_REFUSED /* what it names cannot be loaded; only where a watch lets the load go on */
} daft_scene_item_kind;

typedef struct daft_scene_item {
    daft_scene_item_kind kind;
    const char *source; /* the .scene file */
    int line, column;   /* of the path, if there is one; else of the keyword */
    const char *path;   /* joined to the source's folder */
    union {
        daft_camera camera;
        daft_light_def light;
        daft_vec3 ambient;
        daft_entity_def entity;
    };
} daft_scene_item;

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
