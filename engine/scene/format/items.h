/* The items of .scene files: what each is called, which fields its values fill in what order, and how a line of one is
 * read. */
#ifndef DAFT_SCENE_ITEMS_H
#define DAFT_SCENE_ITEMS_H

#include "scene/format/text.h"
#include "scene/scene.h"

typedef enum daft_scene_item_kind {
    DAFT_ITEM_CAMERA,
    DAFT_ITEM_PATH, /* a checkpoint: time and camera */
    DAFT_ITEM_SKYBOX,
    DAFT_ITEM_LIGHT,
    DAFT_ITEM_AMBIENT,
    DAFT_ITEM_AMBIENT_SKY,
    DAFT_ITEM_EXPOSURE,
    DAFT_ITEM_FOG,
    DAFT_ITEM_SKY, /* of one colour, or from zenith to horizon */
    DAFT_ITEM_QUALITY,
    DAFT_ITEM_SPHERE,
    DAFT_ITEM_MESH,
    DAFT_ITEM_MATERIAL,
    DAFT_ITEM_INCLUDE,
    DAFT_ITEM_REFUSED /* what it names cannot be loaded; only where a watch lets the load go on */
} daft_scene_item_kind;

/* An image that a material names, loaded once all lines are read. */
typedef struct daft_scene_map {
    const daft_field *field; /* of daft_material_def */
    const char *path;        /* joined to the source's folder */
    int line, column;
    struct daft_scene_map *next;
} daft_scene_map;

typedef struct daft_scene_item {
    daft_scene_item_kind kind;
    const char *source; /* the .scene file */
    int line, column;   /* of the path, if there is one; else of the keyword */
    double time;        /* of a checkpoint, seconds */
    const char *path;   /* joined to the source's folder; or NULL */
    const char *name;   /* of an entity; or NULL */
    const char *clip;   /* of a mesh, that it plays; or NULL */
    int clip_column;
    bool lights, cameras; /* of a mesh: those of its file are the scene's, too */
    const char *material; /* a material's own name; of a mesh or sphere, what it may have named; or NULL */
    int material_column;
    daft_material made;      /* of a material, once it is loaded */
    bool used;               /* a material, by some entity */
    daft_scene_map *maps;    /* of a material */
    daft_animated *animated; /* made of it while loading, until the entity has it */
    union {
        daft_camera camera;
        daft_light_def light;
        daft_quality quality;
        struct {
            daft_vec3 ambient;
            float occlusion, strength; /* of the sky's light, which is that of DAFT_ITEM_AMBIENT_SKY */
        };
        daft_exposure exposure;
        const char *faces[5]; /* the other images of a skybox of six; NULL: it is of one */
        daft_entity_def entity;
        daft_material_def def;
        daft_fog fog;
        struct {
            daft_vec3 zenith, horizon;
        };
    };
} daft_scene_item;

/* Reads the line's item with its values and options, up to the end of the line, or of the one with the } that closes a
 * block. Paths are kept in the arena. */
bool daft_scene_item_read(daft_scene_text *text, daft_arena *arena, daft_scene_item *out);

/* The form of the item of this index, "camera x y z [pitch yaw [fov]]", in `buffer`; NULL beyond the last. */
const char *daft_scene_item_form(size_t index, char *buffer, size_t size);

#endif
