/* The kd-tree: space cut in two by planes, a triangle in every cell that it reaches. For accel/ and raster/. */
#ifndef DAFT_KDTREE_H
#define DAFT_KDTREE_H

#include "accel/accel.h"
#include "math/simd/dispatch.h"
#include "math/simd/ops.h"

#include <string.h>

enum { DAFT_KD_LEAF = 3, DAFT_KD_DEPTH = 60 };

/* code: pair << 2 | axis, the pair of children standing side by side, the one below the plane first; or first << 2 |
 * LEAF, where the leaf's triangles begin among `items`; `split` then holds how many they are. */
typedef struct daft_kd_node {
    union {
        float split;
        uint32_t count;
    };
    uint32_t code;
} daft_kd_node;

struct daft_kdtree {
    daft_allocator allocator;
    daft_kd_node *nodes; /* nodes[0] is the root; none: no triangle */
    size_t node_count;
    uint32_t *items; /* numbers of triangles */
    size_t item_count;
    v4 *corners; /* three a triangle */
    uint32_t triangle_count;
    daft_vec3 low, high;
};

#ifdef DAFT_ISA
/* As closest and occluded of one mesh, in its space; hit->t limits the search and hit->triangle breaks ties. */
struct daft_nearest;
void DAFT_KERNEL(daft_kd_closest)(const daft_kdtree *tree, daft_vec3 o, daft_vec3 d, float tmin, daft_intersection how,
                                  struct daft_nearest *hit);
bool DAFT_KERNEL(daft_kd_occluded)(const daft_kdtree *tree, daft_vec3 o, daft_vec3 d, float tmin, float tmax,
                                   daft_intersection how);
#endif

#endif
