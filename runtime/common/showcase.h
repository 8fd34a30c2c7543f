/* showcase: a mesh without a scene, in front of a sky, and a camera from which all of a box is seen. */
#ifndef RUNTIME_COMMON_SHOWCASE_H
#define RUNTIME_COMMON_SHOWCASE_H

#include "daft.h"

/* Whether the name is one of a mesh: OBJ, glTF, FBX and so on. */
bool showcase_is_mesh(const char *path);
/* From the front right and above, at the distance at which the box between two corners just fits. aspect: height of the
 * picture / width. */
daft_camera showcase_camera(daft_dvec3 from, daft_dvec3 to, double aspect);
/* Loads the mesh, and adds a sky, its file's own lights, or else a sun, and its cameras, and one that sees all. */
bool showcase_mesh(daft_scene *scene, const char *path, double aspect, daft_error *error);

#endif
