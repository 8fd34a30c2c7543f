/* Building meshes for assets/meshes: faces with corners, written as OBJ. Y up, metres, counter-clockwise from outside.
 */
#ifndef DAFT_GENERATE_MESH_H
#define DAFT_GENERATE_MESH_H

#include "generate.h"

typedef struct vec {
    double x, y, z;
} vec;

static inline vec v3(double x, double y, double z)
{
    return (vec){x, y, z};
}
vec add(vec a, vec b);
vec sub(vec a, vec b);
vec times(vec a, double s);
vec cross(vec a, vec b);
double length(vec a);
vec normal_of(vec a);

enum { MAX_CORNERS = 8192, MAX_FACES = 2048 };

typedef struct corner {
    vec at, normal;
    double u, v;
} corner;

typedef struct face {
    int first, count; /* corners */
    int material;     /* index of the mesh's `materials` */
    bool textured;
} face;

typedef struct mesh {
    corner corners[MAX_CORNERS];
    face faces[MAX_FACES];
    int corner_count, face_count;
    const char *materials[8]; /* names in meshes.mtl */
    int material_count;
    int material; /* of the faces added next */
    vec move;     /* added to every point */
} mesh;

/* The material that the next faces have. */
void use_material(mesh *m, const char *name);
void add_face(mesh *m, const corner *corners, int count, bool textured);
/* A face with its own flat normal. */
void add_flat(mesh *m, const vec *points, int count);
/* A profile of (radius, height) pairs turned about the Y axis. Smooth normals along the profile, except at points given
 * twice, which make an edge. With `repeat` > 0 the texture goes that often around. */
void add_lathe(mesh *m, const double (*profile)[2], int count, int sides, double repeat);
/* A ring about the Z axis, or the part of it between two angles. */
void add_torus(mesh *m, vec center, double major, double minor, int around, int across, double from, double to);
/* A sphere of 20·4^level flat triangles, each vertex moved outwards by `rough` times noise. */
void add_blob(mesh *m, vec center, vec radius, int level, double rough, int seed);

bool write_mesh(const char *root, const char *path, const mesh *m);

#endif
