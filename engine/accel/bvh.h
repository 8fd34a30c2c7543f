/* The trees' data, for accel/ and for raster/, which culls by them.
 *
 * A node holds up to eight children as arrays, so one SIMD test answers for all. Leaves are blocks of four triangles
 * with their corners copied in, so a ray touches nothing but the tree. Blocks stand in depth-first order, and a node
 * before those below it. */
#ifndef DAFT_BVH_H
#define DAFT_BVH_H

#include "accel/accel.h"

#define DAFT_CHILD_LEAF  0x80000000u
#define DAFT_CHILD_NONE  0xffffffffu
#define DAFT_NO_TRIANGLE 0xffffffffu
#define DAFT_SPHERE_FAR  0x1p30f

enum { DAFT_WIDTH = 8, DAFT_BLOCK = 4, DAFT_MAX_LEAF_BLOCKS = 4, DAFT_STACK = 512 };

/* bounds[0..2] are the children's lows in x, y, z, bounds[3..5] their highs; an empty child has low = inf, high = -inf.
 * child: a node's number; or LEAF | block << 2 | (blocks - 1) in a mesh, LEAF | instance in a top level; or NONE.
 * spheres, in a top level: bits of the children that are spheres, with the bounds of daft_instance_bound and those no
 * further than DAFT_SPHERE_FAR. */
struct daft_node {
    float bounds[6][DAFT_WIDTH];
    uint32_t child[DAFT_WIDTH];
    uint32_t spheres, unused[DAFT_WIDTH - 1]; /* unused: 0; fills cache lines */
};

/* corner[k][axis][i]: corner k of triangle i. Unused places have the number DAFT_NO_TRIANGLE, the largest, and the
 * corners of the last triangle: a ray that hits them hits that one as well, at the same distance, and lower numbers win
 * ties. */
typedef struct daft_block {
    float corner[3][3][DAFT_BLOCK];
    uint32_t triangle[DAFT_BLOCK];
} daft_block;

typedef struct daft_node_list {
    daft_node *items; /* items[0] is the root */
    size_t count, capacity;
} daft_node_list;

struct daft_bvh {
    daft_allocator allocator;
    daft_node_list nodes; /* empty: no triangle */
    daft_block *blocks;
    size_t block_count;
    double cost;       /* of the tree as it was built (refit.c); negative: not known yet */
    float support[38]; /* of the mesh, along 26 directions (reach.h has the order) */
};

/* Computes support; again when vertices have moved. */
void daft_bvh_measure(daft_bvh *bvh, const daft_trimesh *mesh);

struct daft_tlas {
    daft_node_list nodes; /* empty: no instance */
    const daft_instance *instances;
    uint32_t instance_count;
    daft_intersection intersection;
};

#endif
