/* scene: what daft.h promises, on top of the rooms below: entities, transforms, assets, cameras, lights, the .scene
 * format, ray queries. Pulls moves from sim/, fills the frame snapshot, asks render/ for pictures.
 * Promises: a call that fails changes nothing; a scene without bodies has no simulation, one that casts no rays has no
 * query structure, one that is never rendered has no renderer.
 *
 * This header is private to the room. Data: assets are append-only arrays (a handle is index + 1; a failed load cuts
 * them back to where they were), entities and lights are slot maps with parallel arrays of items.
 * Public headers: scene.h. Inner headers: glow.h */
#ifndef DAFT_SCENE_H
#define DAFT_SCENE_H

#include "accel/accel.h"
#include "base/base.h"
#include "base/budget.h"
#include "base/files.h"
#include "geometry/mesh.h"
#include "geometry/rig.h"
#include "image/image.h"
#include "math/vec.h"
#include "render/render.h"
#include "scene/fields/check.h"
#include "scene/handles.h"
#include "sim/character/character.h"

#include <stdatomic.h>

struct daft_engine {
    daft_allocator allocator; /* the budget's */
    daft_budget *budget;
    atomic_ullong reserved; /* bytes of the program's own */
    daft_log log;
    int callbacks;           /* of progress, warnings and problems that run now: all on the calling thread */
    const daft_files *files; /* what is loaded comes from here; NULL: from anywhere */
    int threads, isa;
    daft_accel accel;
    int scenes;              /* alive */
    daft_renderer *renderer; /* made by the first daft_render */
    uint64_t revision; /* counts changes of all scenes, and stamps what was made from them: no two stamps are equal */
    daft_image_cache images; /* of its scenes */
};

/* An affine map in double, for composing; rounded to daft_affine once, relative to a frame's origin. */
typedef struct daft_daffine {
    double m[9], t[3];
} daft_daffine;

/* What the scene has let go of while frames may still read it. The first member of whatever can be retired. */
typedef struct daft_retired {
    struct daft_retired *next;
    uint64_t frame; /* the last frame that may read it */
    void (*free)(const daft_scene *scene, struct daft_retired *item);
} daft_retired;

/* The opacity classes of a mesh's triangles in some materials (assets/opacity.c). */
typedef struct daft_opacity_set {
    daft_retired retired;
    struct daft_opacity_set *next;
    uint64_t key, shown; /* by a hash of the materials; scene->walk of the picture that showed it last */
    uint64_t textures;   /* of which it is made: a bit of each revision, modulo 64 */
    uint32_t flags;      /* of instances: how it casts shadows */
    uint32_t slots;      /* of the mesh: */
    daft_mask *masks;    /* behind the classes; NULL: no triangle is mixed */
    uint8_t *classes;    /* DAFT_OPACITY_…, of each triangle; behind this */
} daft_opacity_set;

typedef struct daft_glow daft_glow;

typedef struct daft_mesh_item {
    daft_retired retired;
    uint64_t revision; /* the engine's, when it was made */
    char *path;        /* NULL: not from a file */
    uint64_t hash;
    daft_trimesh mesh;
    daft_bvh *bvh;
    daft_kdtree *kdtree;       /* NULL: the engine's accelerator is the BVH, and no picture has asked for one */
    uint32_t *materials;       /* index of each slot's material */
    daft_rig *rig;             /* NULL: it has no clips */
    daft_scenery scenery;      /* of its file */
    daft_opacity_set *opacity; /* a list; NULL: no picture has shown it in a material with alpha */
    daft_glow *glow;           /* a list (glow.c); NULL: no entity has asked that it lights */
} daft_mesh_item;

/* A box's mesh, shared by the entities of the same size, gone with the last of them. */
typedef struct daft_box_item {
    daft_mesh_item shape; /* first, as it is what is retired */
    daft_vec3 size;
    uint32_t users;
} daft_box_item;

/* A texture that another has taken the place of. */
typedef struct daft_texture_item {
    daft_retired retired;
    daft_texture_data data;
} daft_texture_item;

typedef struct daft_sky_item {
    daft_retired retired;
    daft_sky_image image;
} daft_sky_item;

typedef struct daft_asset_key {
    char *path;
    uint64_t hash;
} daft_asset_key;

/* Names are many, files fewer: `file` is the one that was read, unless it was none (`number` 0: bytes of a model's
 * file, or a checker that stands in for one). */
typedef struct daft_texture_key {
    char *path;
    uint64_t hash;
    daft_file_id file;
    daft_texture_change change;
} daft_texture_key;

/* Beside each mesh, texture and material. */
typedef struct daft_asset_state {
    uint64_t serial; /* counts what was added: a failed load takes back what is newer than its beginning */
    uint32_t holds;  /* handles given out and not released */
    bool used;       /* scratch of daft_scene_collect */
} daft_asset_state;

/* Meshes, textures and materials are slots with parallel arrays; what has never been freed has index id - 1. */
typedef struct daft_assets {
    daft_slots mesh_slots, texture_slots, material_slots;
    daft_asset_state *mesh_states, *texture_states, *material_states;
    size_t mesh_state_capacity, texture_state_capacity, material_state_capacity;
    uint64_t serial;
    daft_mesh_item **meshes; /* NULL: a free slot. Pointers: a BVH keeps the address of its mesh */
    size_t mesh_capacity;
    daft_texture_data *textures;
    daft_texture_key *texture_keys;
    size_t texture_capacity, texture_key_capacity;
    daft_material_def *materials;  /* 0: the default material */
    daft_surface *surfaces;        /* the same as render/ reads them */
    daft_asset_key *material_keys; /* path NULL: not from a path */
    char **material_names;         /* of MTL files; NULL: none */
    size_t material_capacity, surface_capacity, material_key_capacity, material_name_capacity;
    daft_map mesh_map, texture_map, material_map, box_map; /* from hashes to indices */
    daft_slots box_slots;
    daft_box_item **boxes;
    size_t box_capacity;
} daft_assets;

/* A hull, triangles or a field that bodies are made of. */
typedef struct daft_geometry_item {
    daft_geometry type;
    uint32_t users;
    uint32_t mesh; /* handle; a field: 0 */
    daft_vec3 scale;
    daft_hull *hull;
    daft_mesh_shape *triangles;
    daft_height_field *field;
    daft_trimesh scaled; /* the triangles' own mesh and tree, where the scale is not 1 */
    daft_bvh *bvh;
} daft_geometry_item;

typedef struct daft_joint_item {
    daft_entity a, b;
    uint32_t joint; /* of the world */
} daft_joint_item;

/* A clip that plays, or that the pose passes over from. */
typedef struct daft_track {
    uint32_t clip;
    bool loop;
    float speed;
    double time, step;        /* seconds into it; of it, in the last tick */
    double blend, done, more; /* seconds: of passing over into it, of that behind, and of that in the last tick */
} daft_track;

/* A mesh in a pose. It shares what poses do not change with the mesh. */
typedef struct daft_posed {
    daft_retired retired;
    daft_trimesh mesh;
    daft_bvh *bvh;
    daft_rig_layer layers[DAFT_RIG_LAYERS];
    uint32_t layer_count;
    uint64_t revision;    /* of the engine, when it was posed */
    uint64_t first, last; /* lists of instances that have it, by scene.listings */
} daft_posed;

enum { DAFT_POSES = 3 }; /* two for pictures, of which one may be in the making, one for rays */

/* What an entity with a playing clip has: its tracks, the newest last, and its poses. */
typedef struct daft_animated {
    struct daft_animated *next, *previous;
    uint32_t entity; /* index */
    uint32_t track_count;
    daft_track tracks[DAFT_RIG_LAYERS];
    uint64_t stepped; /* the tick that the tracks' steps are of */
    daft_posed *posed[DAFT_POSES];
    uint32_t shown; /* of the first two: the one in the last list of instances */
    daft_rig_space *space;
    daft_glow *glow; /* as of a mesh, of the pose of this revision */
    uint64_t glow_revision;
} daft_animated;

/* What of a scene can be in a picture: five planes through the frame's origin, what is within a margin of them, and the
 * lights whose shadows fall into it. */
typedef struct daft_sight {
    daft_vec3 planes[5]; /* unit, inwards: the sides, and the camera's own plane */
    float margin;        /* metres */
    uint32_t anywhere;   /* 1: mirrored and refracted rays may go anywhere */
    uint32_t shadows;    /* 1: lights cast some */
    daft_dvec3 origin;
} daft_sight;

/* What a move reads and writes comes first: games move thousands in a tick. */
typedef struct daft_entity_item {
    daft_transform now, before;
    uint64_t moved_tick;                          /* `before` means something in this tick alone */
    uint32_t body;                                /* of the world, 0: none */
    uint32_t box;                                 /* DAFT_SHAPE_BOX: index into assets.boxes */
    uint32_t parent, first_child, next, previous; /* indices; next and previous: the parent's other children */
    daft_entity_def def;                          /* its transform is not kept up to date: `now` is */
    uint32_t *geometries;                         /* that the body is made of; NULL: none */
    uint32_t geometry_count;
    uint32_t moving_slot;    /* dynamic and kinematic bodies: index into scene.moving */
    daft_animated *animated; /* NULL: it plays no clip */
    uint32_t below;          /* scratch of daft_entity_world */
    uint64_t walk_stamp;     /* world and shown are those of this walk */
    daft_daffine world;
    bool shown; /* visible, and so is every ancestor */
    bool warned;
} daft_entity_item;

/* The two-level tree that ray queries go through, kept until the scene changes or the rays move on. */
typedef struct daft_query_cache {
    daft_arena arena;
    bool valid;
    uint64_t revision;
    double cell; /* metres: the origin is a multiple */
    daft_dvec3 origin;
    const daft_instance *instances;
    uint32_t instance_count;
    uint32_t *instance_of; /* of each entity index, or DAFT_NONE */
    const daft_tlas *tlas;
} daft_query_cache;

/* A picture in the making: the snapshot, and the memory of everything it points to but meshes, texels and sky images,
 * which are retired, never freed or changed, while a frame that may read them is taken. Taken and released on the
 * scene's thread; in between any one thread may draw it, while the scene is changed and stepped. */
typedef struct daft_scene_frame {
    struct daft_scene_frame *next;
    bool taken;
    uint64_t number; /* counts takes */
    daft_snapshot snapshot;
    daft_counters counters; /* of the drawing */
    daft_arena lights, instances;
    uint32_t without; /* what the surfaces have been stripped of */
    bool kdtrees;     /* whether the instances have them */
    /* The instances are kept for the next frame that sees the same: */
    uint64_t revision, tick; /* the scene's; revision 0: there are none */
    bool still;              /* nothing was between two ticks' poses; else it was drawn at: */
    float alpha;
    daft_dvec3 origin;
    uint64_t listing, posings; /* the scene's listings and posings when they were listed */
    uint32_t unseen;           /* animated entities that are not among them, as they were out of this sight: */
    daft_sight sight;
} daft_scene_frame;

typedef struct daft_character_item {
    daft_sim_character now;
    daft_sim_walk_wish wish;
    daft_entity entity; /* that follows it */
} daft_character_item;

struct daft_scene {
    daft_engine *engine;
    const daft_allocator *allocator; /* the engine's */
    daft_assets assets;

    daft_asset_key *files; /* read so far */
    uint32_t file_count;
    size_t file_capacity;

    daft_slots entity_slots;
    daft_entity_item *entities;
    size_t entity_capacity;
    daft_quality quality; /* that it asks for */
    daft_image *small;    /* what is drawn at a scale below 1; NULL: nothing was */
    void *scratch;        /* of enlarging it */
    size_t scratch_size;
    uint64_t tick;       /* counts begin_tick */
    uint64_t moved_tick; /* the last in which an entity moved from one pose to another; none: UINT64_MAX */
    uint64_t revision;   /* the engine's, at the last change of what a frame or a ray could see */
    uint64_t looks;      /* the engine's, at the last change of a texture or the sky's image */
    uint64_t walk;       /* the engine's, at the last walk over all world transforms */

    daft_slots light_slots;
    daft_light_def *lights;
    size_t light_capacity;
    uint32_t glowing;           /* entities with `lights` */
    daft_animated *animated;    /* all of them */
    uint64_t listings, posings; /* counts lists of instances, and changes of poses that pictures show */
    daft_vec3 ambient;
    float occlusion;      /* metres; 0: none */
    float ambient_sky;    /* the sky's light instead of that colour, so many times; 0: the colour */
    bool harmonics_known; /* of the present sky: */
    daft_vec3 harmonics[DAFT_HARMONICS];
    double stepped, step; /* seconds that were simulated; those of the last step */
    daft_exposure exposure;
    daft_fog fog;
    daft_sky sky;
    daft_sky_item *sky_item; /* NULL: no image */

    daft_camera camera, camera_before;
    daft_camera *cameras; /* those that scene files name */
    size_t camera_capacity;
    daft_checkpoint *path; /* the camera path that scene files name */
    uint32_t path_count;
    size_t path_capacity;
    uint32_t camera_count;
    daft_named_entity *names; /* the entities that scene files name */
    size_t name_capacity;
    uint32_t name_count;

    daft_world *world; /* made by the first body or character */
    daft_slots character_slots;
    daft_character_item *characters;
    size_t character_capacity;
    daft_vec3 gravity;
    daft_geometry_item **geometries; /* NULL: a free place */
    size_t geometry_capacity;
    uint32_t geometry_count;
    daft_slots joint_slots;
    daft_joint_item *joints;
    size_t joint_capacity;
    uint32_t *moving; /* indices of the entities that a step may move: those with dynamic and kinematic bodies */
    size_t moving_capacity;
    uint32_t moving_count;

    daft_scene_frame *frames; /* taken and free ones */
    uint64_t frames_taken;    /* so far */
    daft_retired *retired;
    daft_query_cache query;
    daft_counters counters;
};

/* ---- engine.c ---- */

/* What changes an engine or a scene asks first: not NULL, and not from inside one of the engine's callbacks. */
bool daft_engine_ready(const daft_engine *engine, daft_error *error);
bool daft_scene_ready(const daft_scene *scene, daft_error *error);
/* For calls that cannot fail: from inside a callback they warn and do nothing. */
bool daft_scene_ready_or_warn(const daft_scene *scene, const char *what);

/* ---- files.c ---- */

bool daft_scene_note_file(daft_scene *scene, const char *path, daft_error *error);
void daft_scene_files_free(daft_scene *scene);

/* ---- names.c ---- */

/* Copies the names behind those that the scene has, for daft_name_insert to take in the same order. */
bool daft_names_reserve(daft_scene *scene, const char *const *names, uint32_t more, daft_error *error);
void daft_name_insert(daft_scene *scene, daft_entity entity); /* the next that was reserved */
void daft_names_free(daft_scene *scene);

/* ---- assets.c ---- */

bool daft_assets_init(daft_scene *scene, daft_error *error);
void daft_assets_free(daft_scene *scene);
typedef struct daft_assets_mark {
    uint64_t serial;
} daft_assets_mark;
daft_assets_mark daft_assets_remember(const daft_scene *scene);
/* Takes back every asset that was added since. */
void daft_assets_roll_back(daft_scene *scene, daft_assets_mark mark);
daft_mesh_item *daft_mesh_find(const daft_scene *scene, daft_mesh mesh, daft_error *error);
bool daft_texture_check(const daft_scene *scene, daft_texture texture, daft_error *error);
/* The texture of an MTL's map, held once more: what cannot be read becomes a checker and one warning. 0: memory is out.
 */
daft_texture daft_texture_of_map(daft_scene *scene, const daft_mtl *mtl, daft_mtl_use use, daft_error *error);
/* The six paths of an MTL's cube; gives the side that an error is of, or the first. */
const daft_mtl_map *daft_cube_maps(const daft_mtl *mtl, const daft_error *why, const char *paths[6]);
/* The texture of these six images, as one all around. What cannot be read is a warning, and `out` none. False: memory
 * is out. */
bool daft_texture_of_cube_map(daft_scene *scene, const daft_mtl *mtl, daft_texture *out, daft_error *error);
/* The mesh of a box of this size; counts a user. DAFT_NONE: memory is out. */
uint32_t daft_box_acquire(daft_scene *scene, daft_vec3 size, daft_error *error);
void daft_box_drop(daft_scene *scene, uint32_t box_index);
uint64_t daft_path_hash(const char *path);
void daft_mesh_drop(daft_scene *scene, uint32_t index);
/* False: a frame may read it, and memory is out for keeping it until then; it stays. */
bool daft_texture_drop(daft_scene *scene, uint32_t index);

/* ---- opacity.c ---- */

/* The classes of the mesh in these materials of its slots, some of which blend. NULL: memory is out, and nothing is
 * known of any triangle. */
const daft_opacity_set *daft_opacity_find(daft_scene *scene, daft_mesh_item *item, const uint32_t *materials);
void daft_opacity_free(const daft_scene *scene, daft_mesh_item *item);
/* A texture goes: so does what was made of it. */
void daft_opacity_forget(daft_scene *scene, uint64_t revision);
size_t daft_opacity_bytes(const daft_mesh_item *item);

/* ---- collect.c ---- */

/* The index of an id that is known to be one of this scene. */
static inline uint32_t daft_asset_index(uint32_t id) { return (id - 1) & (DAFT_MAX_SLOTS - 1); }
uint32_t daft_asset_id(const daft_slots *slots, uint32_t index);
/* The index of any id, or DAFT_NONE. */
uint32_t daft_asset_find(const daft_slots *slots, uint32_t id);
/* Room for one more, in the slots and in the states beside them. */
bool daft_asset_reserve(daft_scene *scene, daft_slots *slots, daft_asset_state **states, size_t *capacity);
/* Takes a slot, held once. Returns its id. */
uint32_t daft_asset_add(daft_scene *scene, daft_slots *slots, daft_asset_state *states);

/* ---- materials.c ---- */

void daft_material_free(daft_scene *scene, uint32_t index);
/* A texture, by its handle, is another picture now. */
void daft_material_refresh(daft_scene *scene, uint32_t texture);
/* There is a mesh whose vertices have alpha: materials that mask or blend may not be opaque on it. */
void daft_materials_fade(daft_scene *scene);
enum { DAFT_MATERIAL_TEXTURES = 12 };
const daft_texture *daft_material_textures(const daft_material_def *def, daft_texture out[DAFT_MATERIAL_TEXTURES]);

bool daft_material_check(const daft_scene *scene, daft_material material, daft_error *error);
/* Fills the members of the definition that say how light passes. */
void daft_material_transmit(const daft_mtl *mtl, daft_material_def *def);
/* The material of an MTL entry. 0 on failure. */
daft_material daft_material_from_mtl(daft_scene *scene, const daft_mtl *mtl, daft_error *error);

/* The body of an entity-to-be, and what it is made of, which belongs to the entity. */
typedef struct daft_made_body {
    uint32_t body, *geometries, geometry_count;
} daft_made_body;

/* ---- entities.c ---- */

bool daft_entities_reserve(daft_scene *scene, uint32_t more, daft_error *error);
bool daft_entity_check(daft_scene *scene, const daft_entity_def *def, daft_error *error);
daft_entity_item *daft_entity_find(const daft_scene *scene, daft_entity entity, daft_error *error);
/* The same, for a call that changes it: see daft_scene_ready. */
daft_entity_item *daft_entity_change(const daft_scene *scene, daft_entity entity, daft_error *error);
/* The slot takes what was checked; room was reserved. box and body belong to the entity from now on. */
daft_entity daft_entity_insert(daft_scene *scene, const daft_entity_def *def, uint32_t box, const daft_made_body *body);

bool daft_transform_check(const daft_transform *transform, daft_error *error);
/* The parent's list of children begins with the youngest. An entity without a parent is in no list. */
void daft_entity_link(daft_scene *scene, uint32_t parent, uint32_t child);
void daft_entity_unlink(daft_scene *scene, const daft_entity_item *item);
/* The next entity of a subtree in depth-first order, or DAFT_NONE. */
uint32_t daft_subtree_next(const daft_scene *scene, uint32_t root, uint32_t at);

/* ---- pose.c ---- */

daft_daffine daft_daffine_from(const daft_transform *transform);
daft_daffine daft_daffine_compose(const daft_daffine *outer, const daft_daffine *inner);
/* False when it is singular or not finite. */
bool daft_daffine_invert(const daft_daffine *a, daft_daffine *out);
/* Fills world and shown of the entity. All calls of one walk use one alpha. */
daft_entity_item *daft_entity_world(daft_scene *scene, uint32_t index, float alpha);
/* The same of one entity alone, without a walk. False: it or what it stands on is hidden. */
bool daft_entity_place(const daft_scene *scene, uint32_t index, float alpha, daft_daffine *out);
bool daft_scale_is_uniform(daft_vec3 scale);

/* ---- colliders.c ---- */

/* The shape of a collider of an entity; counts a user of its geometry. */
bool daft_collider_acquire(daft_scene *scene, const daft_collider *collider, const daft_entity_def *def,
                           daft_sim_shape_def *out, daft_error *error);
void daft_geometry_drop(daft_scene *scene, uint32_t geometry); /* 0: nothing happens */
void daft_geometries_free(daft_scene *scene);
/* Whether some body is made of the mesh's own triangles. */
bool daft_geometry_uses_mesh(const daft_scene *scene, daft_mesh mesh);
/* A daft_sim_find_shape. */
bool daft_geometry_find(void *scene, uint32_t geometry, daft_geometry type, daft_sim_shape *out);

/* ---- bodies.c ---- */

bool daft_body_check(const daft_entity_def *def, daft_error *error);
bool daft_body_create(daft_scene *scene, const daft_entity_def *def, uint32_t entity, daft_made_body *made,
                      daft_error *error);
void daft_body_destroy(daft_scene *scene, uint32_t index);
/* The world, made when it is first asked for. NULL: memory is out. */
daft_world *daft_scene_world(daft_scene *scene, daft_error *error);
/* Puts entities where their bodies are, as if they had always been there. */
void daft_scene_pull_all_poses(daft_scene *scene);

/* ---- joints.c ---- */

void daft_joints_forget(daft_scene *scene, daft_entity entity); /* those of a body that goes */
void daft_joints_sweep(daft_scene *scene);                      /* those that went in the last step */
/* Whether a step may move such a body. */
bool daft_body_moves(daft_body_kind kind);
/* Where the simulation can hold a body. */
bool daft_body_check_position(daft_dvec3 position, daft_error *error);

/* ---- characters.c ---- */

/* After the world's step. */
bool daft_characters_step(daft_scene *scene, float dt, daft_error *error);
void daft_characters_move_entities(daft_scene *scene); /* entities go at once to the characters that they follow */
uint64_t daft_characters_hash(const daft_scene *scene, uint64_t hash);

/* ---- animation/ ---- */

/* The animation that an entity with this mesh is to get. NULL on failure. */
daft_animated *daft_animated_make(daft_scene *scene, const daft_mesh_item *mesh, const daft_play_def *def,
                                  daft_error *error);
void daft_animated_attach(daft_scene *scene, uint32_t entity, daft_animated *animated);
/* What pictures may show is retired. NULL is fine. */
void daft_animated_free(daft_scene *scene, daft_animated *animated);
void daft_animations_step(daft_scene *scene, float dt);
uint64_t daft_animations_hash(const daft_scene *scene, uint32_t entity, uint64_t hash);
/* What a mesh that plays reaches: the clips that it shows. */
void daft_animated_bounds(const daft_animated *animated, const daft_rig *rig, daft_vec3 *low, daft_vec3 *high);
/* Poses of these entities, which play, for the list of instances that scene.listings counts. */
bool daft_animated_pose(daft_scene *scene, const uint32_t *entities, uint32_t count, float alpha, bool rays,
                        daft_arena *arena, daft_error *error);
/* The pose that this list has of it. */
const daft_posed *daft_animated_shown(const daft_animated *animated, bool rays);
void daft_sight_make(const daft_scene *scene, const daft_view *view, int width, int height, daft_sight *out);
/* Whether anything of the box in the entity's axes can be in the picture, or cast a shadow into it. */
bool daft_sight_has(const daft_scene *scene, const daft_sight *sight, const daft_entity_item *item, daft_vec3 low,
                    daft_vec3 high);

/* ---- assets/scenery.c ---- */

/* A camera and a light of a mesh's file, placed. */
daft_camera daft_scenery_camera(const daft_obj_camera *camera, const daft_daffine *at);
daft_light_def daft_scenery_light(const daft_obj_light *light, const daft_daffine *at);

/* ---- glow.c ---- */

enum { DAFT_GLOW_LIGHTS = 6 };
/* What an entity with `lights` lights with, about the picture's origin. False: memory is out. */
bool daft_glow_lights(const daft_scene *scene, uint32_t index, float alpha, daft_dvec3 origin,
                      daft_light_source lights[DAFT_GLOW_LIGHTS], uint32_t *count, daft_error *error);
void daft_glow_free(const daft_scene *scene, daft_glow **list);
/* Whether a material, or without one some of the shape's own, gives off light. `shape` NULL: a sphere. */
bool daft_glow_is_some(const daft_scene *scene, daft_material material, const daft_mesh_item *shape);

/* ---- lights.c, camera.c ---- */

bool daft_lights_reserve(daft_scene *scene, uint32_t more, daft_error *error);
bool daft_light_check(const daft_light_def *def, daft_error *error);
daft_light daft_light_insert(daft_scene *scene, const daft_light_def *def); /* room was reserved */
void daft_sky_adopt(daft_scene *scene, daft_sky_item *item);                /* belongs to the scene from now on */
/* Of one image, or with `count` 6 of a cube's. */
bool daft_sky_images_read(daft_engine *engine, const char *const *paths, int count, daft_sky_image *out,
                          daft_error *error);
daft_sky_item *daft_sky_item_read(const daft_scene *scene, const char *const *paths, int count, daft_error *error);
bool daft_sky_note_files(daft_scene *scene, const char *const *paths, int count, daft_error *error);
void daft_sky_item_free(const daft_scene *scene, daft_sky_item *item); /* NULL is fine */
bool daft_path_reserve(daft_scene *scene, uint32_t more, daft_error *error);
void daft_path_insert(daft_scene *scene, const daft_checkpoint *point);
bool daft_cameras_reserve(daft_scene *scene, uint32_t more, daft_error *error);
void daft_camera_insert(daft_scene *scene, const daft_camera *camera); /* room was reserved; the first one is set */
/* Unit axes of a camera. */
void daft_camera_axes(const daft_camera *camera, daft_vec3 *right, daft_vec3 *up, daft_vec3 *forward);

/* ---- frames.c ---- */

/* Something that a frame or a ray could see has changed. */
void daft_scene_touch(daft_scene *scene);
/* A frame of the view, or NULL. */
daft_scene_frame *daft_frame_take(daft_scene *scene, const daft_view *view, int width, int height, daft_error *error);
/* Draws a taken frame; reads nothing of the scene. One frame of an engine is drawn at a time. */
bool daft_frame_draw(daft_scene_frame *frame, daft_renderer *renderer, const daft_frame_target *target,
                     daft_error *error);
/* The frame's counters become the scene's. */
void daft_frame_release(daft_scene *scene, daft_scene_frame *frame);
/* Frees the item once no frame that is taken now may read it. */
void daft_retire(daft_scene *scene, daft_retired *item, void (*free)(const daft_scene *scene, daft_retired *item));
bool daft_frame_is_taken(const daft_scene *scene);
void daft_frames_free(daft_scene *scene);

/* ---- history.c ---- */

/* Tells the frame, whose snapshot is full, where things were in the picture before, and the history that they are
 * here. NULL: no history. */
bool daft_history_take(daft_history *history, const daft_scene *scene, const daft_view *view, daft_scene_frame *frame,
                       daft_error *error);

/* ---- snapshot.c, instances.c ---- */

/* The instances of visible entities in entity order, in a frame around `origin`. Memory from the arena; textures and
 * surfaces are still the scene's. */
/* quality.c: the same as daft_render, for a scale below 1. The view has been checked. */
bool daft_render_small(daft_scene *scene, const daft_view *view, daft_image *target, daft_error *error);
void daft_scaled_free(daft_scene *scene);
/* Builds the kd-tree of a mesh that has none. */
bool daft_mesh_need_kdtree(daft_scene *scene, daft_mesh_item *item, daft_error *error);
/* Whether a picture's rays go through kd-trees. */
static inline bool daft_uses_kdtrees(const daft_scene *scene, const daft_view *view)
{
    return scene->engine->accel == DAFT_ACCEL_KDTREE || view->quality.tree == DAFT_TREE_KDTREE;
}
typedef struct daft_listing {
    daft_dvec3 origin;
    float alpha;
    const daft_sight *sight; /* of a picture; NULL: for rays, which go anywhere */
    bool kdtrees;            /* the instances have them; those that are missing are built */
    daft_arena *arena;
    daft_instance *instances; /* out */
    uint32_t count, unseen;   /* out; unseen: animated entities that are left out, as the picture cannot show them */
} daft_listing;
bool daft_snapshot_instances(daft_scene *scene, daft_listing *listing, daft_error *error);
/* Of a sphere: its scale is the same in every direction. */
float daft_world_radius(const daft_daffine *world, float radius);
/* Whether a point of the frame is one that kernels can work with. */
bool daft_fits_kernels(daft_vec3 point);
/* The mesh that an entity shows, a box's included. NULL: it shows none. */
daft_mesh_item *daft_entity_shape(const daft_scene *scene, const daft_entity_item *item);
bool daft_snapshot_fill(daft_scene *scene, const daft_view *view, int width, int height, daft_scene_frame *frame,
                        daft_error *error);

#endif
