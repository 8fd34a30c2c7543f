/* accel/build: builds and refits the BVH of a mesh and of instances, and the kd-tree. Public headers: none.
 *
 * This header is the builder of both levels of BVH: build.c has the threads, build_kernel.c the loops over boxes,
 * collapse.c what comes after them.
 *
 * Ranges of primitives (`prims`) are split in two, recursively. The nodes of this binary tree are called forks, to tell
 * them from the nodes of eight that they become. A large set is first sorted into the cells of a grid by the middles of
 * its boxes. A cell is then a box with a weight, and the top of the tree is built over cells by the code that builds
 * over boxes; what is below a few cells is a task. When all ranges are split, the forks are collapsed into nodes of
 * eight and leaves, across the borders of tasks. Tasks are found by one thread and depend on the set alone, and a task
 * owns what it writes, so the tree is the same for any number of threads. */
#ifndef DAFT_BUILD_H
#define DAFT_BUILD_H

#include "accel/bvh.h"
#include "math/simd/dispatch.h"
#include "math/simd/ops.h"

/* Highs are negated, so that one minimum over eight lanes is the union of two boxes. */
typedef struct daft_build_prim {
    float low[3];
    uint32_t id;
    float high[3];
    uint32_t weight; /* 1, or a cell's triangles */
} daft_build_prim;

/* Prims in a row. Lanes 0 to 2 of the boxes are lows, 4 to 6 negated highs, 3 and 7 mean nothing; middles are doubled.
 */
typedef struct daft_build_range {
    v8 box, middles;
    uint32_t first, count, weight;
    uint8_t side; /* which of the two buffers */
    uint8_t depth;
} daft_build_range;

typedef struct daft_build_rule {
    uint32_t leaf_size;  /* weights up to this may become leaves; at least block_size */
    uint32_t block_size; /* weight that costs as much as one; 1: each leaf is one prim, and its code the prim's number
                          */
} daft_build_rule;

/* What a ray pays for a node that it enters, for a leaf, and for each block of that: measured. The blocks of a leaf go
 * through the filter together, as many as there are lanes for, so the first costs most. */
#define DAFT_NODE_COST  1.0f
#define DAFT_LEAF_COST  1.5f
#define DAFT_BLOCK_COST 0.15f

/* A range that was split in two, or that is not split further: a node of the binary tree. */
typedef struct daft_build_fork { /* a line of a cache */
    float low[3];
    uint32_t right; /* how much further in its list the right part stands; the left one is next. 0: not split */
    float high[3];  /* negated */
    uint32_t first; /* of its numbers; where leaves are prims, the prim; over cells, where it is not split, its task */
    /* What the cheapest forest of at most i + 1 trees costs, nodes or leaves that together hold the range (collapse.c).
     * Where it is less than that of one tree fewer, its lowest three bits say how many of the trees are of the left
     * part. */
    float cost[DAFT_WIDTH - 1];
    uint16_t count; /* of prims, or the largest there is, where they are more; those of a bundle are the forks that
                       follow */
    uint8_t left;   /* how many of the eight children of a node over the range are of the left part; 0: it is a leaf */
    uint8_t bundle; /* prims that are leaves each, and not split further */
} daft_build_fork;

static inline uint16_t daft_build_few(size_t count) { return count < UINT16_MAX ? (uint16_t)count : UINT16_MAX; }

/* Where forks go, in depth-first order: into chunks, of which each task has a part of one. */
typedef struct daft_build_sink {
    daft_build_fork *forks; /* the chunk that is being filled: there is room for all that is to come of a task */
    size_t count, capacity;
    daft_build_fork **chunks;
    size_t chunk_count, chunk_capacity;
} daft_build_sink;

/* A part of the tree that is built by itself: its forks, the nodes and leaves above which no node is its own, and where
 * what it holds lies in the whole. */
typedef struct daft_build_task {
    daft_build_range range;
    const daft_build_fork *forks; /* NULL: memory was out */
    const daft_build_fork *trees[DAFT_WIDTH];
    uint32_t codes[DAFT_WIDTH];
    int tree_count;
    size_t node_base, node_count, block_base, block_count;
} daft_build_task;

typedef struct daft_build_branch {
    const daft_build_rule *rule;
    daft_build_prim *prims[2];
    daft_build_sink *sink;
    uint32_t *numbers;               /* where a range's go: at its first */
    const daft_allocator *allocator; /* of the list of tasks */
    daft_build_task *tasks;          /* where `defer` */
    size_t task_count, task_capacity;
    bool defer; /* over cells: small ranges become tasks */
} daft_build_branch;

/* Middles to cells: (middle - low)·scale, in 0..side on each axis. */
typedef struct daft_build_grid {
    v4 low, scale;
    uint32_t side;
} daft_build_grid;

typedef struct daft_build_kernels {
    /* Fills box, middles and weight of a range from its prims. */
    void (*measure)(const daft_build_prim *prims, daft_build_range *range);
    /* Splits a range as far as it is worth it, or down to tasks. False: memory is out. */
    bool (*branch)(daft_build_branch *branch, const daft_build_range *range);
    void (*count)(const daft_build_grid *grid, const daft_build_prim *prims, uint32_t count, uint32_t *counts);
    /* Copies prims to where `next` of their cell says. */
    void (*scatter)(const daft_build_grid *grid, const daft_build_prim *prims, uint32_t count, uint32_t *next,
                    daft_build_prim *out);
} daft_build_kernels;

DAFT_KERNEL_DECLARE(daft_build_kernels, daft_build);

typedef struct daft_build {
    const daft_allocator *allocator; /* scratch; an arena's hook for the top level */
    daft_region *region;
    int threads, isa; /* threads: the region's */
    daft_build_rule rule;
    daft_build_prim *prims; /* reordered */
    uint32_t count;         /* at least 1 */
    bool fixed;             /* sinks have room for all from the start, so that nothing is allocated while threads run */
    /* what comes out */
    size_t node_count, block_count;
    /* within */
    const daft_build_kernels *kernels;
    daft_build_sink top;    /* over cells, where there is more than one task */
    daft_build_sink *sinks; /* each worker's, or each task's */
    size_t sink_count;
    daft_build_task *tasks;
    size_t task_count;
    daft_node_list top_nodes; /* a child's code: a node, or LEAF | eight times a task | which of its trees */
    daft_build_prim *other;   /* as many as prims */
    uint32_t *numbers;        /* of prims, in the order of leaves; NULL where these are prims */
    daft_build_prim *cells;
    uint32_t *cell_first; /* by a cell's id: where its prims begin; one more than there are cells */
    uint32_t cell_count;
} daft_build;

/* Where a tree is written. blocks: NULL where leaves are prims. */
typedef struct daft_build_out {
    daft_node *nodes;
    daft_block *blocks;
    const daft_trimesh *mesh;
} daft_build_out;

/* False when memory is out; daft_build_free is to be called in either case. */
bool daft_build_run(daft_build *build);
/* The tree, node_count and block_count of it. */
void daft_build_write(daft_build *build, const daft_build_out *out);
void daft_build_free(daft_build *build);

/* collapse.c: which forks of a finished list become nodes; then that of the whole, and where each task's part of it
 * lies. False: memory is out. */
void daft_build_weigh(const daft_build_rule *rule, daft_build_fork *forks, size_t count);
bool daft_build_collapse(daft_build *build);

/* Corners of a block whose triangles are known (mesh_bvh.c). */
void daft_block_fill(const daft_trimesh *mesh, daft_block *block);

#endif
