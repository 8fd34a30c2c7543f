/* Closed meshes and hard rays from inside them: for the property tests, and for the benchmark that gives the same rays
 * to other libraries. Everything follows from the random state that is passed in. */
#ifndef DAFT_CLOSED_SHAPES_H
#define DAFT_CLOSED_SHAPES_H

#include "geometry/mesh.h"

typedef struct closed_shape {
    char name[48];
    daft_trimesh mesh;
} closed_shape;

/* Random numbers: a state is good for a sequence of its own, whatever its bits. */
uint64_t hard_state(uint64_t seed, uint64_t stream);
uint32_t hard_bits(uint64_t *state);
float hard_float(uint64_t *state, float low, float high);
daft_vec3 hard_vec3(uint64_t *state, float low, float high);

/* Generated: bumpy balls, boxes on an integer grid, tori, cones of many triangles around one vertex, needles a million
 * times as long as wide, slabs as thin. False when memory is out. */
enum { CLOSED_KINDS = 8 };
bool closed_shape_make(const daft_allocator *allocator, int kind, uint64_t *state, closed_shape *out);

/* OBJ files of tests/data/cases, and models of the optional folder ../shared/data beside the checkout; DAFT_CASES and
 * DAFT_DATA name other folders. False: there is no such file, or it is not closed. */
enum { CLOSED_FILES = 15 };
bool closed_shape_load(const daft_allocator *allocator, int file, closed_shape *out);
void closed_shape_free(const daft_allocator *allocator, closed_shape *shape);

/* The folder of the hard cases, without a slash at its end. */
const char *hard_cases_folder(void);

/* Every edge, by the places of its ends, belongs to an even number of triangles: then each line crosses the surface an
 * even number of times, and a ray from inside an odd number. */
bool closed_mesh(const daft_allocator *allocator, const daft_trimesh *mesh);

daft_vec3 mesh_vertex(const daft_trimesh *mesh, uint32_t vertex);
daft_vec3 mesh_corner(const daft_trimesh *mesh, uint32_t triangle, uint32_t corner);

/* How often the ray crosses a closed surface, by the exact predicates; -1 where it starts on the surface, or so close
 * that double cannot tell on which side. */
int exact_crossings(const daft_trimesh *mesh, daft_vec3 origin, daft_vec3 direction);

/* A point inside, by the parity of exact crossings: anywhere, on a coarse grid, or as close to the surface as floats
 * get. False when it did not find one. */
bool point_inside(const daft_trimesh *mesh, uint64_t *state, daft_vec3 *out);

/* A direction from the origin to a vertex or to a point of an edge, or a few units in the last place beside it, across
 * an axis, along an axis or a diagonal, or anywhere; of many lengths. */
daft_vec3 hard_target(const daft_trimesh *mesh, uint64_t *state, daft_vec3 origin);

#endif
