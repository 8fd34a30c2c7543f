/* A dynamic tree of bounding boxes, height-balanced like an AVL tree, so that its depth is at most 1.44·log2 of its
 * leaves even when ten thousand bodies share one spot. Inserting descends where the summed surface area grows least
 * (after Box2D's b2DynamicTree). Nodes are an array with a free list; nothing is ordered by address. */
#include "sim/world.h"

/* A tree of 2^32 leaves is at most 46 deep, and each level leaves one sibling on the stack. */
enum { STACK_DEPTH = 64 };

/* What a change counts towards laying the tree out anew. */
enum { MOVED = 1, INSERTED = 2 };

void daft_sim_tree_init(daft_sim_tree *tree)
{
    *tree = (daft_sim_tree){.root = DAFT_SIM_NONE, .free_list = DAFT_SIM_NONE};
}

bool daft_sim_tree_reserve(daft_sim_tree *tree, const daft_allocator *allocator, uint32_t more)
{
    size_t needed = 2 * ((size_t)tree->leaf_count + more); /* n leaves have n - 1 inner nodes */
    return daft_grow(allocator, &tree->nodes, &tree->capacity, needed, tree->used, sizeof *tree->nodes) &&
           daft_grow(allocator, &tree->keys, &tree->key_capacity, needed / 2, 0, sizeof *tree->keys);
}

static uint32_t take_node(daft_sim_tree *tree)
{
    uint32_t node = tree->free_list;
    if (node == DAFT_SIM_NONE) return (uint32_t)tree->used++;
    tree->free_list = tree->nodes[node].parent;
    return node;
}

static void free_node(daft_sim_tree *tree, uint32_t node)
{
    tree->nodes[node].parent = tree->free_list;
    tree->nodes[node].height = -1;
    tree->free_list = node;
}

static daft_sim_bounds joined(const daft_sim_bounds *a, const daft_sim_bounds *b)
{
    return (daft_sim_bounds){daft_sim_dmin(a->low, b->low), daft_sim_dmax(a->high, b->high)};
}

/* Half the surface area. */
static double area(const daft_sim_bounds *b)
{
    daft_dvec3 d = daft_dsub(b->high, b->low);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

static double joined_area(const daft_sim_bounds *a, const daft_sim_bounds *b)
{
    daft_sim_bounds both = joined(a, b);
    return area(&both);
}

static void refit(daft_sim_tree *tree, uint32_t index)
{
    daft_sim_node *node = &tree->nodes[index];
    const daft_sim_node *left = &tree->nodes[node->child[0]], *right = &tree->nodes[node->child[1]];
    node->bounds = joined(&left->bounds, &right->bounds);
    node->height = (int16_t)(1 + daft_max_i(left->height, right->height));
}

static void replace_child(daft_sim_tree *tree, uint32_t parent, uint32_t old, uint32_t new)
{
    tree->nodes[new].parent = parent;
    if (parent == DAFT_SIM_NONE)
        tree->root = new;
    else
        tree->nodes[parent].child[tree->nodes[parent].child[1] == old] = new;
}

/* The taller child of `index`, on `side`, takes its place; returns it. */
static uint32_t rotate(daft_sim_tree *tree, uint32_t index, int side)
{
    uint32_t up = tree->nodes[index].child[side];
    daft_sim_node *raised = &tree->nodes[up];
    int taller = tree->nodes[raised->child[1]].height > tree->nodes[raised->child[0]].height;
    uint32_t keep = raised->child[taller], give = raised->child[1 - taller];
    replace_child(tree, tree->nodes[index].parent, index, up);
    raised->child[0] = index;
    raised->child[1] = keep;
    tree->nodes[index].parent = up;
    tree->nodes[index].child[side] = give;
    tree->nodes[give].parent = index;
    refit(tree, index);
    refit(tree, up);
    return up;
}

static uint32_t balance(daft_sim_tree *tree, uint32_t index)
{
    const daft_sim_node *node = &tree->nodes[index];
    int lean = tree->nodes[node->child[1]].height - tree->nodes[node->child[0]].height;
    if (lean > 1) return rotate(tree, index, 1);
    if (lean < -1) return rotate(tree, index, 0);
    return index;
}

static void refit_upwards(daft_sim_tree *tree, uint32_t index)
{
    while (index != DAFT_SIM_NONE) {
        refit(tree, index);
        index = tree->nodes[balance(tree, index)].parent;
    }
}

/* How much the areas below `node` grow if the new leaf goes there. */
static double descend_cost(const daft_sim_tree *tree, uint32_t node, const daft_sim_bounds *bounds)
{
    const daft_sim_node *n = &tree->nodes[node];
    double grown = joined_area(&n->bounds, bounds);
    return n->height == 0 ? grown : grown - area(&n->bounds);
}

static uint32_t best_sibling(const daft_sim_tree *tree, const daft_sim_bounds *bounds)
{
    uint32_t index = tree->root;
    while (tree->nodes[index].height > 0) {
        const daft_sim_node *node = &tree->nodes[index];
        double grown = joined_area(&node->bounds, bounds);
        double here = 2 * grown, inherited = 2 * (grown - area(&node->bounds));
        double left = inherited + descend_cost(tree, node->child[0], bounds);
        double right = inherited + descend_cost(tree, node->child[1], bounds);
        if (here < left && here < right) break;
        index = node->child[right < left];
    }
    return index;
}

uint32_t daft_sim_tree_insert(daft_sim_tree *tree, const daft_sim_bounds *bounds, uint32_t part)
{
    uint32_t leaf = take_node(tree);
    tree->nodes[leaf] = (daft_sim_node){.bounds = *bounds, .parent = DAFT_SIM_NONE, .part = part};
    tree->leaf_count++;
    tree->entered += INSERTED;
    if (tree->root == DAFT_SIM_NONE) return tree->root = leaf;
    uint32_t sibling = best_sibling(tree, bounds);
    uint32_t inner = take_node(tree);
    tree->nodes[inner] = (daft_sim_node){.child = {sibling, leaf}};
    replace_child(tree, tree->nodes[sibling].parent, sibling, inner);
    tree->nodes[sibling].parent = inner;
    tree->nodes[leaf].parent = inner;
    refit_upwards(tree, inner);
    return leaf;
}

void daft_sim_tree_remove(daft_sim_tree *tree, uint32_t leaf)
{
    uint32_t parent = tree->nodes[leaf].parent;
    free_node(tree, leaf);
    tree->leaf_count--;
    if (parent == DAFT_SIM_NONE) {
        tree->root = DAFT_SIM_NONE;
        return;
    }
    const daft_sim_node *node = &tree->nodes[parent];
    uint32_t sibling = node->child[node->child[0] == leaf], above = node->parent;
    replace_child(tree, above, parent, sibling);
    free_node(tree, parent);
    refit_upwards(tree, above);
}

/* ---- moving ---- */

/* Half the surface of both together, as a fraction of the sum of theirs, up to which they go on standing side by side.
 */
#define FAR_APART 4

bool daft_sim_tree_move(daft_sim_tree *tree, uint32_t leaf, const daft_sim_bounds *bounds)
{
    daft_sim_node *nodes = tree->nodes;
    uint32_t parent = nodes[leaf].parent;
    if (parent != DAFT_SIM_NONE) {
        const daft_sim_bounds *beside = &nodes[nodes[parent].child[nodes[parent].child[0] == leaf]].bounds;
        if (joined_area(bounds, beside) > FAR_APART * (area(bounds) + area(beside))) return false;
    }
    nodes[leaf].bounds = *bounds;
    for (; parent != DAFT_SIM_NONE && !nodes[parent].stale; parent = nodes[parent].parent) nodes[parent].stale = true;
    tree->entered += MOVED;
    return true;
}

static void fit(daft_sim_tree *tree, uint32_t index)
{
    daft_sim_node *node = &tree->nodes[index];
    if (!node->stale) return;
    node->stale = false;
    fit(tree, node->child[0]);
    fit(tree, node->child[1]);
    refit(tree, index);
}

void daft_sim_tree_fit(daft_sim_tree *tree)
{
    if (tree->root != DAFT_SIM_NONE) fit(tree, tree->root);
}

/* ---- laying out anew ---- */

/* The axis along which the middles of the leaves are spread most. */
static int widest_axis(const daft_sim_key *keys, uint32_t count)
{
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = daft_sim_min(low[axis], keys[i].middle[axis]);
            high[axis] = daft_sim_max(high[axis], keys[i].middle[axis]);
        }
    int best = high[1] - low[1] > high[0] - low[0];
    return high[2] - low[2] > high[best] - low[best] ? 2 : best;
}

/* Orders leaves so that none of the first `wanted` is beyond any of the others (Hoare's selection). */
static void select_lower(daft_sim_key *keys, uint32_t count, uint32_t wanted, int axis)
{
    int64_t low = 0, high = (int64_t)count - 1;
    while (low < high) {
        float pivot = keys[(low + high) / 2].middle[axis];
        int64_t i = low, k = high;
        while (i <= k) {
            while (keys[i].middle[axis] < pivot) i++;
            while (keys[k].middle[axis] > pivot) k--;
            if (i > k) break;
            daft_sim_key swap = keys[i];
            keys[i++] = keys[k];
            keys[k--] = swap;
        }
        if ((int64_t)wanted <= k)
            high = k;
        else if ((int64_t)wanted >= i)
            low = i;
        else
            return;
    }
}

void daft_sim_keys_part(daft_sim_key *keys, uint32_t count, uint32_t wanted)
{
    select_lower(keys, count, wanted, widest_axis(keys, count));
}

/* Halves all the way down: as deep as a tree of so many leaves has to be, and no deeper. */
static uint32_t lay_out(daft_sim_tree *tree, daft_sim_key *keys, uint32_t count)
{
    if (count == 1) return keys[0].leaf;
    uint32_t half = count / 2, node = take_node(tree);
    if (count > 2) daft_sim_keys_part(keys, count, half);
    const uint32_t child[2] = {lay_out(tree, keys, half), lay_out(tree, keys + half, count - half)};
    tree->nodes[node] = (daft_sim_node){.child = {child[0], child[1]}};
    tree->nodes[child[0]].parent = tree->nodes[child[1]].parent = node;
    refit(tree, node);
    return node;
}

static daft_sim_key key_of(const daft_sim_tree *tree, uint32_t leaf)
{
    const daft_sim_bounds *b = &tree->nodes[leaf].bounds;
    return (daft_sim_key){{(float)(b->low.x + b->high.x), (float)(b->low.y + b->high.y), (float)(b->low.z + b->high.z)},
                          leaf};
}

enum { FEWEST_TO_LAY_OUT = 32, CHANGES = 1 /* of each leaf */ };

void daft_sim_tree_tidy(daft_sim_tree *tree)
{
    if (tree->entered / CHANGES < tree->leaf_count || tree->leaf_count < FEWEST_TO_LAY_OUT) return;
    uint32_t found = 0;
    tree->free_list = DAFT_SIM_NONE;
    for (uint32_t index = (uint32_t)tree->used; index-- > 0;) { /* so nodes are taken, and will stand, in their order */
        if (tree->nodes[index].height == 0)
            tree->keys[found++] = key_of(tree, index);
        else
            free_node(tree, index);
    }
    tree->root = lay_out(tree, tree->keys, found);
    tree->nodes[tree->root].parent = DAFT_SIM_NONE;
    tree->entered = 0;
}

/* ---- queries ---- */

void daft_sim_tree_query(const daft_sim_tree *tree, const daft_sim_bounds *bounds, daft_sim_visit *visit, void *context)
{
    uint32_t stack[STACK_DEPTH];
    int depth = 0;
    if (tree->root == DAFT_SIM_NONE) return;
    stack[0] = tree->root;
    depth += daft_sim_overlap(&tree->nodes[tree->root].bounds, bounds);
    while (depth > 0) {
        const daft_sim_node *node = &tree->nodes[stack[--depth]];
        if (node->height == 0) {
            visit(context, node->part);
            continue;
        }
        uint32_t left = node->child[0], right = node->child[1];
        stack[depth] = left;
        depth += daft_sim_overlap(&tree->nodes[left].bounds, bounds);
        stack[depth] = right;
        depth += daft_sim_overlap(&tree->nodes[right].bounds, bounds);
    }
}
