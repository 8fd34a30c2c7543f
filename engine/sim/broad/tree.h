/* A height-balanced tree of bounds, one for each kind of body: what rests is found in it, and what queries ask for. */
#ifndef DAFT_SIM_TREE_H
#define DAFT_SIM_TREE_H

#include "sim/shape/shape.h"

#define DAFT_SIM_NONE UINT32_MAX /* no index */

typedef daft_daabb daft_sim_bounds;

static inline bool daft_sim_overlap(const daft_sim_bounds *a, const daft_sim_bounds *b)
{
    /* Without branches: which of the six fails first is anyone's guess. */
    return (a->low.x <= b->high.x) & (b->low.x <= a->high.x) & (a->low.y <= b->high.y) & (b->low.y <= a->high.y) &
           (a->low.z <= b->high.z) & (b->low.z <= a->high.z);
}

/* A height-balanced tree of bounds; leaves are parts, entered and removed one at a time, moved where they stand, and
 * all laid out anew from time to time. */
typedef struct daft_sim_node { /* a cache line */
    _Alignas(64) daft_sim_bounds bounds;
    uint32_t parent; /* the next free node, where this one is free */
    union {
        uint32_t child[2];
        uint32_t part; /* of a leaf */
    };
    int16_t height; /* 0: a leaf; -1: free */
    bool stale;     /* an inner node: something below it was moved since its bounds were found */
} daft_sim_node;

/* Of a leaf: the middle of its bounds, twice as far. What it is rounded to changes the tree's shape only. */
typedef struct daft_sim_key {
    float middle[3];
    uint32_t leaf;
} daft_sim_key;

typedef struct daft_sim_tree {
    daft_sim_node *nodes;
    size_t capacity, used; /* used: high-water mark */
    uint32_t root, free_list, leaf_count;
    uint32_t entered;   /* leaves, and moved, since it was last laid out */
    daft_sim_key *keys; /* scratch of laying out */
    size_t key_capacity;
} daft_sim_tree;

typedef void daft_sim_visit(void *context, uint32_t part);

void daft_sim_tree_init(daft_sim_tree *tree);
/* Room for `more` leaves; inserts right after cannot fail. */
bool daft_sim_tree_reserve(daft_sim_tree *tree, const daft_allocator *allocator, uint32_t more);
uint32_t daft_sim_tree_insert(daft_sim_tree *tree, const daft_sim_bounds *bounds, uint32_t part);
void daft_sim_tree_remove(daft_sim_tree *tree, uint32_t leaf);
/* Gives a leaf other bounds, where it stands. False, and nothing is done: they are too far from what stands beside it,
 * and it is to be removed and inserted. After all moves, and before anything else, the tree is fitted to them. */
bool daft_sim_tree_move(daft_sim_tree *tree, uint32_t leaf, const daft_sim_bounds *bounds);
void daft_sim_tree_fit(daft_sim_tree *tree);
/* Lays the tree out anew if enough of its leaves were entered or moved one at a time since it last was: what grew so is
 * searched twice as long. */
void daft_sim_tree_tidy(daft_sim_tree *tree);
/* Orders keys along the axis on which their middles are spread most: none of the first `wanted` is beyond any other. */
void daft_sim_keys_part(daft_sim_key *keys, uint32_t count, uint32_t wanted);
/* Calls visit for every leaf that overlaps, in an order that callers must not depend on. */
void daft_sim_tree_query(const daft_sim_tree *tree, const daft_sim_bounds *bounds, daft_sim_visit *visit,
                         void *context);

#endif
