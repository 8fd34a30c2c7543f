/* assimp: the library's functions, found at run time, and the parts of the import. */
#ifndef DAFT_FOREIGN_ASSIMP_H
#define DAFT_FOREIGN_ASSIMP_H

#include "geometry/foreign/foreign.h"
#include "geometry/foreign/gltf.h"
#include "geometry/rig.h"

#include <assimp/camera.h>
#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/light.h>
#include <assimp/material.h>
#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/texture.h>

#include <string.h>

/* Names as in the library. */
typedef struct daft_assimp {
    void *library;
    __typeof__(&aiImportFileExWithProperties) import;
    __typeof__(&aiReleaseImport) release;
    __typeof__(&aiGetErrorString) error;
    __typeof__(&aiGetMaterialColor) color;
    __typeof__(&aiGetMaterialFloatArray) numbers;
    __typeof__(&aiGetMaterialString) string;
    __typeof__(&aiGetMaterialTexture) texture;
} daft_assimp;

typedef struct daft_foreign {
    const daft_allocator *allocator;
    const daft_files *files;
    const char *path;
    const daft_log *log;
    const daft_assimp *assimp;
    const struct aiScene *scene;
    daft_error *error;
    const char *format; /* as daft_foreign_format says */
    const void *bytes;  /* of the file */
    size_t size;
} daft_foreign;

static inline bool daft_foreign_is_gltf(const daft_foreign *from)
{
    return strcmp(from->format, "gltf") == 0 || strcmp(from->format, "glb") == 0;
}

/* ---- the hierarchy: nodes.c ---- */

typedef struct daft_foreign_node {
    const struct aiNode *node;
    uint32_t parent;       /* stands before it; DAFT_RIG_NONE: none */
    double own[12], m[12]; /* to the parent's axes, to the scene's: three rows */
} daft_foreign_node;

typedef struct daft_foreign_nodes {
    daft_foreign_node *items;
    uint32_t count;
    uint32_t *by_name, mask; /* the first of each name */
} daft_foreign_nodes;

bool daft_foreign_nodes_list(const daft_foreign *from, daft_foreign_nodes *out);
void daft_foreign_nodes_free(const daft_foreign *from, daft_foreign_nodes *nodes);
/* DAFT_RIG_NONE: no node has that name. */
uint32_t daft_foreign_nodes_find(const daft_foreign_nodes *nodes, const char *name);
/* False: some number of it is not finite, and `m` is the identity. */
bool daft_foreign_matrix(const struct aiMatrix4x4 *a, double m[12]);
double daft_foreign_determinant(const double m[12]);
daft_vec3 daft_foreign_move(const double m[12], struct aiVector3D v, double w);

/* ---- from a hierarchy to one mesh: mesh.c ---- */

/* What carries a vertex, where clips move the model. */
typedef struct daft_foreign_binding {
    int32_t joint[DAFT_RIG_WEIGHTS];
    float weight[DAFT_RIG_WEIGHTS];
    const struct aiMesh *shaped; /* it has morph targets; or NULL */
    uint32_t vertex;             /* of that */
    bool turned;                 /* its triangles were, since its node mirrors them */
} daft_foreign_binding;

typedef struct daft_flattener {
    const daft_foreign *from;
    daft_trimesh mesh;
    daft_foreign_nodes nodes;
    daft_gltf gltf;
    daft_vec3 *positions; /* of all vertices, before those in one place become one */
    uint32_t count;
    uint32_t *number; /* of each of these its number afterwards */
    bool bare;        /* some mesh has no normals */
    bool linear_colors;
    double *blended; /* 12 for each vertex of a skin */
    daft_rig *rig;   /* NULL: no clip moves anything, and vertices are where they are at rest; else in their own axes */
    size_t joint_capacity, target_capacity;
    daft_foreign_binding *bindings; /* of each vertex, before */
    uint32_t bad_weights;
} daft_flattener;

/* All of the scene's triangles, and what moves them. */
bool daft_foreign_mesh(const daft_foreign *from, daft_obj *out);

/* ---- what moves it: rig.c ---- */

/* Makes f->rig where some clip moves some node or target. */
bool daft_foreign_rig_begin(daft_flattener *f);
/* Binds the vertices from f->count on, of the mesh at the node. */
bool daft_foreign_rig_bind(daft_flattener *f, const struct aiMesh *mesh, uint32_t node);
/* Whether two vertices in one place stay together, whatever moves them. */
bool daft_foreign_rig_alike(const daft_flattener *f, uint32_t a, uint32_t b);
/* Once vertices and normals are there: fills the rig, and poses the mesh as it stands at rest. */
bool daft_foreign_rig_end(daft_flattener *f);

/* scenery.c: the cameras and lights. */
bool daft_foreign_scenery(const daft_flattener *f, daft_obj *out);

/* clips.c: fills the clips. */
bool daft_foreign_clips(daft_flattener *f);

/* material.c: one for each material of the scene. */
bool daft_foreign_materials(const daft_foreign *from, daft_mtl_list *out);

#endif
