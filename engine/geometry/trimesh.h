/* Parts of making a mesh that its sources share. */
#ifndef DAFT_TRIMESH_H
#define DAFT_TRIMESH_H

#include "geometry/mesh.h"

/* Across edges flatter than this, normals are smooth unless the source says otherwise: 40 degrees. */
#define DAFT_SMOOTH_CREASE (40.0f * (float)(DAFT_PI / 180))

/* Fills x, y, z and vertex_count. A non-finite position becomes zero: no triangle may use it. */
bool daft_trimesh_set_positions(const daft_allocator *allocator, daft_trimesh *mesh, const daft_vec3 *positions,
                                uint32_t count, daft_error *error);
/* The bounds of the triangles' corners. */
void daft_trimesh_set_bounds(daft_trimesh *mesh);
/* Unit normal of a triangle, computed in double; zero where it has no area. */
daft_vec3 daft_trimesh_face_normal(const daft_trimesh *mesh, uint32_t triangle);
/* daft_trimesh_smooth with a group for each triangle (NULL: all alike). Edges between different groups are creases, so
 * are all edges of group 0. */
bool daft_trimesh_smooth_groups(const daft_allocator *allocator, daft_trimesh *mesh, float crease,
                                const uint32_t *groups, daft_error *error);

/* The linear value, 0..1, of a vertex's colour in sRGB (IEC 61966-2-1), as pictures are. */
float daft_trimesh_color(double encoded);
/* A vertex's alpha, 0..1; 1 where it is no number. */
float daft_trimesh_alpha(float alpha);

static inline daft_vec3 daft_trimesh_position(const daft_trimesh *mesh, uint32_t vertex)
{
    return daft_v3(mesh->x[vertex], mesh->y[vertex], mesh->z[vertex]);
}

static inline daft_dvec3 daft_unit(daft_dvec3 v)
{
    double length = sqrt(daft_ddot(v, v));
    return length > 0 ? daft_dscale(v, 1 / length) : v;
}

#endif
