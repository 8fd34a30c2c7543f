/* Building meshes for assets/meshes: faces with corners, written as OBJ. Y up, metres, counter-clockwise from outside.
 */
#ifndef DAFT_GENERATE_MESH_H
#define DAFT_GENERATE_MESH_H

#include "generate.h"

typedef struct vec {
    double x, y, z;
} vec;

static inline vec v3(double x, double y, double z) { return (vec){x, y, z}; }
vec add(vec a, vec b);
vec sub(vec a, vec b);
vec times(vec a, double s);
vec cross(vec a, vec b);
double dot(vec a, vec b);
double length(vec a);
vec normal_of(vec a);

enum { MAX_CORNERS = 65536, MAX_FACES = 16384 };

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
    const char *library;       /* the .mtl file beside the mesh; NULL: meshes.mtl */
    const char *materials[16]; /* names in it */
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
/* The same with a texture, one repeat in `tile` metres along the two axes that each triangle faces least, and with
 * normals between the triangle's (soft 0) and the sphere's (soft 1). */
void add_soft_blob(mesh *m, vec center, vec radius, int level, double rough, int seed, double tile, double soft);
/* A random point on the unit sphere. */
vec random_direction(int i, int seed);
/* A tube along points, with radii; open at both ends; the texture goes around once and repeats every `tile` metres. */
void add_tube(mesh *m, const vec *points, const double *radii, int count, int sides, double tile);
/* A textured quadrilateral with a flat normal: corners counter-clockwise from the lower left, u to the right, v up. */
void add_panel(mesh *m, const vec points[4], double u0, double v0, double u1, double v1);
/* A box from `low` to `high` without its bottom; the texture repeats every `tile` metres. */
void add_box(mesh *m, vec low, vec high, double tile);

/* The same with its bottom. */
void add_block(mesh *m, vec low, vec high, double tile);
/* A quadrilateral turned to face `eye`; its texture repeats u times from the first point to the second, v times from
 * there to the third; none where u is 0. */
void add_facing(mesh *m, const vec points[4], vec eye, double u, double v);

/* A surface over u, v in 0..1, smooth, u to the right and v up seen from outside; closed where opposite edges meet. */
typedef vec surface(double u, double v);
void add_surface(mesh *m, surface *at, int across, int up);

/* One mesh of a list, and what fills it. */
typedef struct mesh_recipe {
    const char *path;
    void (*make)(mesh *);
} mesh_recipe;

/* Makes and writes them all, with the materials of `library`. */
bool write_meshes(const char *root, const mesh_recipe *list, size_t count, const char *library);
/* Writes a text, such as a material library. */
bool write_text(const char *root, const char *path, const char *text);
bool write_mesh(const char *root, const char *path, const mesh *m);

#endif
