/* Corners of triangles and random directions, for tests by brute force. */
#ifndef MESH_POINTS_H
#define MESH_POINTS_H

#include "fixtures.h"

#include "geometry/trimesh.h"

static inline void corners_of(const daft_trimesh *mesh, uint32_t triangle, daft_vec3 c[3])
{
    for (uint32_t k = 0; k < 3; k++) c[k] = daft_trimesh_position(mesh, mesh->indices[3 * triangle + k]);
}

static inline daft_vec3 random_unit(void)
{
    daft_vec3 v;
    do v = random_vec3(-1, 1);
    while (daft_dot(v, v) > 1 || daft_dot(v, v) < 0.01f);
    return daft_normalize(v);
}

#endif
