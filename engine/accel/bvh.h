/* The trees themselves, for accel/ and for raster/, which culls by them.
 *
 * A node holds up to eight children as arrays, so one SIMD test answers for all. Leaves are blocks of four triangles with
 * their corners copied in, so a ray touches nothing but the tree. Blocks stand in depth-first order; a cluster is a whole
 * subtree of at most DAFT_CLUSTER triangles and so a run of blocks: the pencil culls by clusters before it touches triangles. */
#ifndef DAFT_BVH_H
#define DAFT_BVH_H

#include "accel/accel.h"

#define DAFT_CHILD_LEAF 0x80000000u
#define DAFT_CHILD_NONE 0xffffffffu
#define DAFT_NO_TRIANGLE 0xffffffffu

enum { DAFT_WIDTH = 8, DAFT_BLOCK = 4, DAFT_CLUSTER = 128, DAFT_MAX_LEAF_BLOCKS = 4, DAFT_STACK = 512 };

/* bounds[0..2] are the children's lows in x, y, z, bounds[3..5] their highs; an empty child has low = inf, high = -inf.
 * child: a node's number; or LEAF | block << 2 | (blocks - 1) in a mesh, LEAF | instance in a top level; or NONE. */
struct daft_node {
    float bounds[6][DAFT_WIDTH];
    uint32_t child[DAFT_WIDTH];
};

/* corner[k][axis][i]: corner k of triangle i. Unused places have the number DAFT_NO_TRIANGLE, the largest, and the corners of
 * the last triangle: a ray that hits them hits that one as well, at the same distance, and lower numbers win ties. */
typedef struct daft_block {
    float corner[3][3][DAFT_BLOCK];
    uint32_t triangle[DAFT_BLOCK];
} daft_block;

typedef struct daft_cluster {
    daft_vec3 low, high;
    uint32_t first_block, block_count;
} daft_cluster;

typedef struct daft_node_list {
    daft_node *items; /* items[0] is the root */
    size_t count, capacity;
} daft_node_list;

struct daft_bvh {
    daft_allocator allocator;
    daft_node_list nodes; /* empty: no triangle */
    daft_block *blocks;
    size_t block_count, block_capacity;
    daft_cluster *clusters;
    size_t cluster_count, cluster_capacity;
};

struct daft_tlas {
    daft_node_list nodes; /* empty: no instance */
    const daft_instance *instances;
    uint32_t instance_count;
    daft_intersection intersection;
};

/* ---- the builder (build.c) ---- */

typedef struct daft_build_prim {
    float low[3];
    uint32_t id;
    float high[3];
    uint32_t pad;
} daft_build_prim;

typedef struct daft_builder {
    const daft_allocator *allocator;
    daft_build_prim *prims;
    daft_node_list *nodes;
    uint32_t leaf_size;  /* ranges up to this may become leaves */
    uint32_t block_size; /* items that cost as much as one */
    void *context;
    /* Writes a leaf; gives its child code or DAFT_CHILD_NONE when memory is out. */
    uint32_t (*leaf)(void *context, const daft_build_prim *prims, uint32_t count);
    /* Told of every inner node's range before its children are built and after. May be NULL. */
    bool (*enter)(void *context, uint32_t count, const float box[6]);
    void (*leave)(void *context, uint32_t count);
} daft_builder;

/* Binned SAH over prims[0..count), which are reordered. The root becomes nodes[0]. False when memory is out. */
bool daft_build_tree(daft_builder *builder, uint32_t count);

#endif
