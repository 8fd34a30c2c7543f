/* assimp: the library's functions, found at run time, and the parts of the import. */
#ifndef DAFT_FOREIGN_ASSIMP_H
#define DAFT_FOREIGN_ASSIMP_H

#include "geometry/foreign/foreign.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/texture.h>

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
} daft_foreign;

/* mesh.c: all of the scene's triangles. */
bool daft_foreign_mesh(const daft_foreign *from, daft_trimesh *out);
/* material.c: one for each material of the scene. */
bool daft_foreign_materials(const daft_foreign *from, daft_mtl_list *out);

#endif
