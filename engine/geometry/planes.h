/* The planes of a mesh: flat parts of it, of two triangles or of thousands (analysis/planes.c). */
#ifndef DAFT_GEOMETRY_PLANES_H
#define DAFT_GEOMETRY_PLANES_H

#include "geometry/mesh.h"

enum { DAFT_MESH_PLANES = 8, DAFT_NO_PLANE = 255 };

/* A plane that some triangles lie in, and their bounds. */
typedef struct daft_mesh_plane {
    daft_dvec3 normal; /* unit, of either side */
    double offset;     /* normal · p of its points */
    daft_vec3 low, high;
} daft_mesh_plane;

typedef struct daft_mesh_planes {
    uint32_t count;
    daft_mesh_plane planes[DAFT_MESH_PLANES]; /* by their first triangles */
    uint8_t *of;                              /* each triangle's, or DAFT_NO_PLANE; NULL: there are none */
} daft_mesh_planes;

/* The planes of largest area among the triangles of the wanted slots whose normals are those of the plane. False:
 * memory is out. */
bool daft_trimesh_planes(const daft_allocator *allocator, const daft_trimesh *mesh, const bool *wanted,
                         daft_mesh_planes *out);
void daft_mesh_planes_free(const daft_allocator *allocator, daft_mesh_planes *planes);

#endif
