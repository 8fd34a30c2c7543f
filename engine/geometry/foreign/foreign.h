/* foreign: glTF, FBX, PLY, STL, COLLADA and the rest through Assimp, which is looked for when the first such file is
 * loaded: programs that load none pay nothing for it. Public headers: none. Inner headers: foreign.h
 * assimp.h gltf.h json.h
 * A file becomes one mesh: the hierarchy is flattened, skins are in the pose of the file, lights and cameras stand
 * beside it, where they are at rest. Vertices in one place become one, so that triangles that share an edge share its
 * vertices. */
#ifndef DAFT_FOREIGN_H
#define DAFT_FOREIGN_H

#include "geometry/mesh.h"

/* The extension under which Assimp knows what the bytes are, or NULL: not a format of its, or OBJ, which is ours. The
 * name counts only where the bytes do not tell. */
const char *daft_foreign_format(const char *path, const void *bytes, size_t size);
/* Other files that it names are read from `files`. DAFT_ERROR_UNSUPPORTED: Assimp is not installed. */
bool daft_foreign_parse(const daft_allocator *allocator, const daft_files *files, const char *path, const void *bytes,
                        size_t size, const daft_log *log, daft_obj *out, daft_error *error);

#endif
