/* The builder of both levels, for accel/ alone: build.c has the threads, build_kernel.c the loops over boxes.
 *
 * A large set is first sorted into the cells of a grid by the middles of its boxes. A cell is then a box with a weight, and
 * the top of the tree is built over cells by the code that builds over boxes; what is below a few cells is a task. Tasks
 * are found by one thread and depend on the set alone, and a task owns what it writes, so the tree is the same for any
 * number of threads. */
#ifndef DAFT_BUILD_H
#define DAFT_BUILD_H

#include "accel/bvh.h"
#include "math/isa.h"
#include "math/simd.h"

/* Highs are negated, so that one minimum over eight lanes is the union of two boxes. */
typedef struct daft_build_prim {
    float low[3];
    uint32_t id;
    float high[3];
    uint32_t weight; /* 1, or a cell's triangles */
} daft_build_prim;

/* Prims in a row. Lanes 0 to 2 of the boxes are lows, 4 to 6 negated highs, 3 and 7 mean nothing; middles are doubled. */
typedef struct daft_build_range {
    v8 box, middles;
    uint32_t first, count, weight;
    uint8_t side; /* which of the two buffers */
    uint8_t depth;
    bool leaf; /* not to be split further */
    float area; /* half the surface, for parts of a node; by weight where ranges are only halved */
} daft_build_range;

typedef struct daft_build_rule {
    uint32_t leaf_size;  /* weights up to this may become leaves */
    uint32_t block_size; /* weight that costs as much as one; 1: each leaf is one prim, and its code the prim's number */
} daft_build_rule;

/* Where finished parts of a tree go. Blocks hold numbers of triangles; their corners are filled in later. */
typedef struct daft_build_sink {
    const daft_allocator *allocator; /* NULL: nodes.items has room for all */
    daft_node_list nodes;
    uint32_t (*blocks)[DAFT_BLOCK];
    size_t block_count, block_capacity;
} daft_build_sink;

/* A part of the tree that is built by itself, and where it lies: in its sink, and at last in the whole. */
typedef struct daft_build_task {
    daft_build_range range;
    daft_build_sink *sink;
    uint32_t code; /* of its root: a node of the sink's, a leaf's, or DAFT_CHILD_NONE when memory was out */
    size_t node_first, node_count, block_first, block_count;
    size_t node_base, block_base;
} daft_build_task;

typedef struct daft_build_branch {
    const daft_build_rule *rule;
    daft_build_prim *prims[2];
    daft_build_sink *sink;
    const daft_allocator *allocator; /* of the list of tasks */
    daft_build_task *tasks;          /* where `defer` */
    size_t task_count, task_capacity;
    bool defer; /* over cells: small ranges become tasks, and a child's code is LEAF | task */
} daft_build_branch;

/* Middles to cells: (middle - low)·scale, in 0..side on each axis. */
typedef struct daft_build_grid {
    v4 low, scale;
    uint32_t side;
} daft_build_grid;

typedef struct daft_build_kernels {
    /* Fills box, middles and weight of a range from its prims. */
    void (*measure)(const daft_build_prim *prims, daft_build_range *range);
    /* Splits a range down to leaves, or to tasks; gives its code. A root is a node, even over a single leaf. */
    uint32_t (*branch)(daft_build_branch *branch, const daft_build_range *range, bool root);
    void (*count)(const daft_build_grid *grid, const daft_build_prim *prims, uint32_t count, uint32_t *counts);
    /* Copies prims to where `next` of their cell says. */
    void (*scatter)(const daft_build_grid *grid, const daft_build_prim *prims, uint32_t count, uint32_t *next,
                    daft_build_prim *out);
} daft_build_kernels;

DAFT_KERNEL_DECLARE(daft_build_kernels, daft_build);

typedef struct daft_build {
    const daft_allocator *allocator; /* scratch; an arena's hook for the top level */
    daft_team *team;
    int threads, isa; /* threads: the team's */
    daft_build_rule rule;
    daft_build_prim *prims; /* reordered */
    uint32_t count;         /* at least 1 */
    bool fixed;             /* sinks have room for all from the start, so that nothing is allocated while threads run */
    /* what comes out */
    daft_build_sink top;
    daft_build_sink *sinks; /* each worker's, or each task's */
    size_t sink_count;
    daft_build_task *tasks;
    size_t task_count;
    size_t node_count, block_count; /* of the whole */
    /* within */
    const daft_build_kernels *kernels;
    daft_build_prim *other; /* as many as prims */
    daft_build_prim *cells;
    uint32_t *cell_first; /* by a cell's id: where its prims begin; one more than there are cells */
    uint32_t cell_count;
} daft_build;

/* False when memory is out; daft_build_free is to be called in either case. */
bool daft_build_run(daft_build *build);
/* The same with spatial splits (spatial.c), from the mesh itself; prims are not used. */
bool daft_build_spatial(daft_build *build, const daft_trimesh *mesh);
/* Where each task's part lies in the whole, once all tasks are done. False: some task's memory was out. */
bool daft_build_place(daft_build *build);
/* Writes the nodes of the whole, node_count of them; `write` is told of each task then, on some worker, to copy the rest. */
void daft_build_write(daft_build *build, daft_node *nodes, void (*write)(void *context, const daft_build_task *task),
                      void *context);
void daft_build_free(daft_build *build);

/* Corners of a block whose triangles are known (mesh_bvh.c). */
void daft_block_fill(const daft_trimesh *mesh, daft_block *block);

#endif
