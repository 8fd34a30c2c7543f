/* geometry: triangle meshes and where they come from: OBJ/MTL files, arrays, boxes.
 * Promises: a mesh that stands has only finite positions, indices in range and no triangle with two equal corners;
 * triangles that share an edge in the file share its two vertex numbers here, whatever their normals and uvs do.
 *
 * Public headers: mesh.h planes.h rig.h. Inner headers: trimesh.h polygon.h outline.h.
 * formats/ reads OBJ and MTL files, foreign/ others; analysis/ computes smooth normals and finds problems; rig/ moves
 * vertices by skeletons. */
#ifndef DAFT_GEOMETRY_H
#define DAFT_GEOMETRY_H

#include "base/base.h"
#include "base/files.h"
#include "math/vec.h"

/* Triangle indices into the three attribute arrays are kept apart, so that a seam in the uvs is no seam in the surface.
 * Vertices: x, y, z arrays, each padded with zeros to a multiple of 16 so that kernels may read whole lanes. */
typedef struct daft_trimesh {
    uint32_t vertex_count, triangle_count, normal_count, uv_count, color_count, slot_count;
    float *x, *y, *z;
    uint32_t *indices;        /* 3·triangle_count, into x, y, z */
    daft_vec3 *normals;       /* unit length */
    uint32_t *normal_indices; /* 3·triangle_count; NULL: same as indices */
    daft_vec2 *uvs;           /* NULL: no texture coordinates (then uv_count is 0) */
    uint32_t *uv_indices;     /* 3·triangle_count, DAFT_NO_UV for a corner without; NULL: same as indices */
    daft_vec3 *colors;        /* color_count, linear, 0..1; NULL: none */
    uint32_t *color_indices;  /* 3·triangle_count; NULL: same as indices */
    float *alphas;            /* one a colour, 0..1: how much of the surface is there; NULL: all of it */
    uint16_t *slots;          /* a triangle's material slot; NULL: all 0 */
    uint32_t left_out;        /* triangles of the source that are not here */
    daft_vec3 low, high;      /* bounds; low > high when there is no triangle */
} daft_trimesh;

#define DAFT_NO_UV UINT32_MAX

void daft_trimesh_free(const daft_allocator *allocator, daft_trimesh *mesh);
size_t daft_trimesh_bytes(const daft_trimesh *mesh);
/* All of it, in memory of its own. */
bool daft_trimesh_copy(const daft_allocator *allocator, const daft_trimesh *mesh, daft_trimesh *out, daft_error *error);

/* Copies arrays in (a triangle with an index out of range is an error; one with a non-finite or repeated corner is
 * dropped with a warning). Without normals, smooth ones are computed across edges flatter than 40 degrees. */
bool daft_trimesh_from_arrays(const daft_allocator *allocator, const daft_mesh_def *def, const daft_log *log,
                              daft_trimesh *out, daft_error *error);

/* The same triangles with their vertices moved: vertex_count positions, all finite, and as many normals or NULL, for
 * smooth ones as above. On failure the mesh is as it was. */
bool daft_trimesh_deform(const daft_allocator *allocator, daft_trimesh *mesh, const daft_vec3 *positions,
                         const daft_vec3 *normals, daft_error *error);

/* A box around the origin with the given full edge lengths. Flat normals; each side's uvs are metres from its lower
 * left corner, so textures keep their size. 8 vertices, 12 triangles. */
bool daft_trimesh_box(const daft_allocator *allocator, daft_vec3 size, daft_trimesh *out, daft_error *error);

/* What daft_mesh_extrude says. */
bool daft_trimesh_extrude(const daft_allocator *allocator, const daft_extrude_def *def, daft_trimesh *out,
                          daft_error *error);

/* Fills normals and normal_indices: at each corner the angle-weighted mean of the faces around the vertex that meet
 * this one across edges flatter than `crease` radians. Each vertex has a normal under its own number, others of the
 * same vertex follow behind; where no vertex has others, normal_indices is NULL. */
bool daft_trimesh_smooth(const daft_allocator *allocator, daft_trimesh *mesh, float crease, daft_error *error);

/* ---- OBJ and MTL ---- */

/* The maps of a material beside map_Kd. */
typedef enum daft_mtl_use {
    DAFT_MTL_AMBIENT,
    DAFT_MTL_SPECULAR,
    DAFT_MTL_EMISSION,
    DAFT_MTL_SHININESS,
    DAFT_MTL_ALPHA,
    DAFT_MTL_BUMP,
    DAFT_MTL_NORMAL,
    DAFT_MTL_ROUGHNESS,
    DAFT_MTL_METALLIC,
    DAFT_MTL_REFLECTION, /* refl -type sphere */
    DAFT_MTL_OCCLUSION,  /* map_AO */
    DAFT_MTL_CUBE,       /* refl -type cube_right, and five more: left top bottom front back; all or none */
    DAFT_MTL_CUBE_END = DAFT_MTL_CUBE + 5,
    DAFT_MTL_MAPS,
    DAFT_MTL_DIFFUSE = DAFT_MTL_MAPS /* the material's own */
} daft_mtl_use;

/* What a map's options make of its bytes: -imfchan's letter (0: none), -mm's base and gain, -texres (0: any). */
typedef struct daft_mtl_change {
    char channel;
    float base, gain;
    int most;
} daft_mtl_change;

typedef struct daft_mtl_map {
    char path[1024]; /* as opened, empty: none */
    uint8_t *bytes;  /* of a picture that the model holds itself; NULL: it is a file. The list's */
    size_t size;
    int line, column; /* where the file names it */
    daft_mtl_change change;
} daft_mtl_map;

typedef struct daft_mtl_maps {
    daft_mtl_map map[DAFT_MTL_MAPS];
} daft_mtl_maps;

typedef struct daft_mtl {
    char name[256];
    daft_vec3 ambient, diffuse, specular, emission; /* Ka Kd Ks Ke */
    float shininess, index, opacity, roughness;     /* Ns Ni d Pr */
    float metallic;                                 /* Pm */
    bool physical;                                  /* it has Pm, or a map of Pr or Pm */
    bool has_roughness;
    uint32_t alpha_mode; /* a daft_alpha_mode, of maps */
    bool fades;          /* it is on vertices with alpha, which alpha_mode is of, too */
    float alpha_cutoff;
    float bump, normal;      /* what slopes are multiplied by: -bm of bump, of norm */
    float occlusion;         /* the strength of its map, which MTL says by -mm: 0..1 */
    daft_vec2 scale, offset; /* -s -o, of all maps */
    uint32_t wrap;           /* -clamp: a daft_wrap */
    daft_mtl_maps *maps;     /* NULL: none beside map_Kd. The list's */
    daft_mtl_change diffuse_change;
    daft_vec3 filter;    /* Tf: 0..1 each */
    bool has_filter;     /* the file names it */
    float tint_distance; /* tint_distance: metres in which light takes on the filter; 0: at each surface */
    int priority;        /* medium_priority: 0..255 */
    int illum;
    char diffuse_map[1024]; /* path as opened (folder of the MTL joined), empty: none */
    uint8_t *map_bytes;     /* of a picture that the model holds itself; NULL: it is a file. The list's */
    size_t map_size;
    int diffuse_map_line, diffuse_map_column; /* where the file names it, for warnings */
    char file[1024];                          /* the MTL file it came from, for warnings; empty: none */
} daft_mtl;

typedef struct daft_mtl_list {
    daft_mtl *items;
    size_t count, capacity;
} daft_mtl_list;

/* Appends the materials of a file, which is one of `files`; NULL: of the disk. On failure the list is as it was. */
bool daft_mtl_load(const daft_allocator *allocator, const daft_files *files, const char *path, const daft_log *log,
                   daft_mtl_list *list, daft_error *error);
/* The same from memory; `path` names the source in messages and is what maps are beside. `text` ends with a zero byte.
 */
bool daft_mtl_parse(const daft_allocator *allocator, const daft_files *files, const char *path, const char *text,
                    size_t size, const daft_log *log, daft_mtl_list *list, daft_error *error);
void daft_mtl_list_free(const daft_allocator *allocator, daft_mtl_list *list);
/* Another of the same, with maps of its own. False: memory is out. */
bool daft_mtl_copy(const daft_allocator *allocator, const daft_mtl *from, daft_mtl *out);
/* A map to fill, or NULL: memory is out. */
daft_mtl_map *daft_mtl_map_at(const daft_allocator *allocator, daft_mtl *mtl, daft_mtl_use use);
void daft_mtl_drop(const daft_allocator *allocator, daft_mtl *mtl);
/* The default material: Kd 0.8, no map, illum 2. */
daft_mtl daft_mtl_default(void);

/* Where a file has a camera, in the mesh's axes: forward and up of any length but zero, at any angle but none. */
typedef struct daft_obj_camera {
    char name[128];
    daft_dvec3 position;
    daft_vec3 forward, up;
    float fov; /* as daft_mesh_camera says */
} daft_obj_camera;

/* And a light: what daft_light_def says of these. */
typedef struct daft_obj_light {
    char name[128];
    daft_light_kind kind;
    daft_dvec3 position;
    daft_vec3 direction, color;
    float inner_angle, outer_angle, range;
    bool inverse_square;
} daft_obj_light;

typedef struct daft_scenery {
    daft_obj_camera *cameras;
    daft_obj_light *lights;
    uint32_t camera_count, light_count;
} daft_scenery;

void daft_scenery_free(const daft_allocator *allocator, daft_scenery *scenery);

typedef struct daft_obj {
    daft_trimesh mesh;
    daft_mtl_list slots;  /* slot i of the mesh has the material slots.items[i] */
    struct daft_rig *rig; /* what its clips move (rig.h); NULL: it has none */
    daft_scenery scenery;
    uint32_t *groups; /* smoothing group of each triangle, for daft_obj_smooth; NULL: none, or no longer needed */
} daft_obj;

/* daft_obj_load of a text that has been read, which it releases. */
bool daft_obj_take(const daft_allocator *allocator, const daft_files *files, const char *path, char *text, size_t size,
                   const daft_log *log, daft_obj *out, daft_error *error);
bool daft_obj_load(const daft_allocator *allocator, const daft_files *files, const char *path, const daft_log *log,
                   daft_obj *out, daft_error *error);
/* The same from memory; `path` names the source in messages and is where mtllib looks. `text` ends with a zero byte. */
bool daft_obj_parse(const daft_allocator *allocator, const daft_files *files, const char *path, const char *text,
                    size_t size, const daft_log *log, daft_obj *out, daft_error *error);
void daft_obj_free(const daft_allocator *allocator, daft_obj *obj);

/* daft_obj_load in two steps. The first leaves mesh.normals NULL where no corner has a normal in the file: enough to
 * collide with. The second computes those, which takes as long as the first or twice that; where there are normals it
 * does nothing. On failure the mesh is as it was. */
bool daft_obj_load_triangles(const daft_allocator *allocator, const daft_files *files, const char *path,
                             const daft_log *log, daft_obj *out, daft_error *error);
bool daft_obj_smooth(const daft_allocator *allocator, daft_obj *obj, daft_error *error);

/* ---- any format (foreign/) ---- */

/* A mesh file of any format, by what is in it: OBJ, or one that Assimp reads. DAFT_ERROR_UNSUPPORTED:
 * this build or system has no Assimp. */
bool daft_model_load(const daft_allocator *allocator, const daft_files *files, const char *path, const daft_log *log,
                     daft_obj *out, daft_error *error);

/* ---- what is odd: mesh_check.c, obj_check.c ---- */

typedef enum daft_flaw {
    DAFT_FLAW_NO_AREA,
    DAFT_FLAW_DUPLICATE,
    DAFT_FLAW_OPEN,
    DAFT_FLAW_NON_MANIFOLD,
    DAFT_FLAW_TURNED,
    DAFT_FLAW_COUNT
} daft_flaw;

/* Called once for each triangle without area, each duplicate, and each odd edge (with a triangle that has it). */
typedef void daft_flaw_callback(void *user, daft_flaw flaw, uint32_t triangle);

/* Time and memory are linear in the size of the mesh. `found` may be NULL. */
bool daft_trimesh_check(const daft_allocator *allocator, const daft_trimesh *mesh, daft_flaw_callback *found,
                        void *user, daft_mesh_report *report, daft_error *error);

/* Where problems of a file go. */
typedef struct daft_problems {
    daft_problem_callback *found;
    void *user;
} daft_problems;

void daft_problem_at(const daft_problems *problems, daft_severity severity, daft_status code, const char *file,
                     int line, int column, const char *format, ...) __attribute__((format(printf, 7, 8)));

/* daft_obj_load that also tells what is odd about the file. What loading itself warns of goes to `log`. */
bool daft_obj_check(const daft_allocator *allocator, const daft_files *files, const char *path, const daft_log *log,
                    const daft_problems *problems, daft_obj *out, daft_error *error);

#endif
