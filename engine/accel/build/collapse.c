/* Collapses the binary tree into nodes of eight: chooses which ranges become nodes and which leaves, at minimal cost to
 * a ray for this binary tree (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
 * Wide BVHs", 2017, section 3.1). From the leaves up, each fork gets the cost of the cheapest forest of at most 1, 2, …
 * 7 trees over its range; a node is made of such forests of its two sides. A cost is a surface times a constant for
 * nodes, leaves or blocks.
 *
 * The forks of a task are weighed by who built them, those over cells when all tasks are done, as if a task's first
 * fork stood where the task does. A task then knows its trees: up to seven, whose parent is a node of the top's. */
#include "accel/build/build.h"

#include <float.h>
#include <string.h>

#define LITTLE     1e-6f  /* of the longest side: boxes without area are told apart by their length */
#define LEAST_AREA 1e-30f /* sums of so many neither under- nor overflow */
#define MOST_AREA  1e25f

enum { TREES = DAFT_WIDTH - 1 }; /* that one part of a node has at most */

/* ---- costs ---- */

/* Half the surface. */
static float fork_area(const daft_build_fork *fork)
{
    float e[3], longest = 0;
    for (int k = 0; k < 3; k++) {
        e[k] = -(fork->low[k] + fork->high[k]);
        longest = e[k] > longest ? e[k] : longest;
    }
    for (int k = 0; k < 3; k++) e[k] += longest * LITTLE;
    float area = e[0] * (e[1] + e[2]) + e[1] * e[2];
    if (!(area <= MOST_AREA)) return MOST_AREA;
    return area >= LEAST_AREA ? area : LEAST_AREA;
}

static uint32_t blocks_of(const daft_build_rule *rule, uint32_t count)
{
    return (count + rule->block_size - 1) / rule->block_size;
}

static int lowest_bits(float cost)
{
    uint32_t bits;
    memcpy(&bits, &cost, sizeof bits);
    return bits & 7;
}

/* Lane i: what i + 1 trees cost, some of the left part and the others of the right; the lowest bits say how many are
 * left. Sums of what costs too much may become NaN by these; v8_min gives its second argument then. */
static v8 best_forests(const daft_build_fork *left, const daft_build_fork *right)
{
    float behind[2 * DAFT_WIDTH]; /* right's costs, with lanes before them that cost too much */
    v8 best = v8_set(FLT_MAX);
    v8_store(behind, best);
    memcpy(behind + DAFT_WIDTH, right->cost, sizeof right->cost);
    behind[2 * DAFT_WIDTH - 1] = FLT_MAX;
    for (int k = 1; k <= TREES; k++) {
        v8i sum = (v8i)(v8_set(left->cost[k - 1]) + v8_load(behind + DAFT_WIDTH - k));
        best = v8_min((v8)((sum & ~(v8i){7, 7, 7, 7, 7, 7, 7, 7}) | (v8i){k, k, k, k, k, k, k, k}), best);
    }
    return best;
}

static void fork_weigh(const daft_build_rule *rule, daft_build_fork *fork)
{
    float area = fork_area(fork), least = FLT_MAX, cost[DAFT_WIDTH];
    if (fork->count <= rule->leaf_size)
        least = area * (DAFT_LEAF_COST + DAFT_BLOCK_COST * (float)blocks_of(rule, fork->count));
    fork->left = 0;
    if (fork->bundle) { /* a node over all, or each a tree: what leaves cost is the same in both */
        for (int i = 0; i < TREES; i++) fork->cost[i] = i + 1 < fork->count ? area * DAFT_NODE_COST : 0;
        fork->left = 1;
        return;
    }
    if (fork->right == 0) {
        for (int i = 0; i < TREES; i++) fork->cost[i] = least;
        return;
    }
    v8_store(cost, best_forests(fork + 1, fork + fork->right));
    float node = cost[TREES] + area * DAFT_NODE_COST;
    if (node < least) least = node, fork->left = (uint8_t)lowest_bits(cost[TREES]);
    for (int i = 0; i < TREES; i++) {
        if (i > 0) least = cost[i] < least ? cost[i] : least;
        fork->cost[i] = least;
    }
}

void daft_build_weigh(const daft_build_rule *rule, daft_build_fork *forks, size_t count)
{
    for (size_t i = count; i-- > 0;) fork_weigh(rule, &forks[i]);
}

/* ---- trees of a forest, from left to right ---- */

typedef struct forest {
    const daft_build_fork *trees[DAFT_WIDTH];
    int count;
} forest;

static void forest_add_bundle(forest *to, const daft_build_fork *fork)
{
    for (uint32_t i = 1; i <= fork->count; i++) to->trees[to->count++] = fork + i;
}

/* How many trees the cheapest forest of at most so many has. */
static int trees_of(const daft_build_fork *fork, int most)
{
    while (most > 1 && !(fork->cost[most - 1] < fork->cost[most - 2])) most--;
    return most;
}

static void forest_add(forest *to, const daft_build_fork *fork, int most)
{
    most = trees_of(fork, most);
    if (most == 1) {
        to->trees[to->count++] = fork;
    } else if (fork->bundle) {
        forest_add_bundle(to, fork);
    } else {
        int left = lowest_bits(fork->cost[most - 1]);
        forest_add(to, fork + 1, left);
        forest_add(to, fork + fork->right, most - left);
    }
}

/* The children of a node over a fork; over one that is a leaf, that leaf. */
static forest children(const daft_build_fork *fork)
{
    forest out = {.count = 0};
    if (fork->left == 0) return (forest){{fork}, 1};
    if (fork->bundle) {
        forest_add_bundle(&out, fork);
    } else {
        forest_add(&out, fork + 1, fork->left);
        forest_add(&out, fork + fork->right, DAFT_WIDTH - fork->left);
    }
    return out;
}

static void node_fill(daft_node *node, const forest *from, const uint32_t *codes)
{
    node->spheres = 0;
    memset(node->unused, 0, sizeof node->unused);
    for (int i = 0; i < DAFT_WIDTH; i++) {
        bool there = i < from->count;
        node->child[i] = there ? codes[i] : DAFT_CHILD_NONE;
        for (int k = 0; k < 3; k++) {
            node->bounds[k][i] = there ? from->trees[i]->low[k] : INFINITY;
            node->bounds[k + 3][i] = there ? -from->trees[i]->high[k] : -INFINITY;
        }
    }
}

/* ---- the top ---- */

/* Forks over cells, as if what their tasks hold were their own. */
static void weigh_top(daft_build *build)
{
    for (size_t i = build->top.count; i-- > 0;) {
        daft_build_fork *fork = &build->top.forks[i];
        if (fork->right != 0)
            fork_weigh(&build->rule, fork);
        else
            memcpy(fork->cost, build->tasks[fork->first].forks->cost, sizeof fork->cost);
    }
}

typedef struct top_forest {
    forest of;
    uint32_t codes[DAFT_WIDTH]; /* LEAF | eight times the task | which of its trees; 0: one of the top's own */
} top_forest;

static void top_add(daft_build *build, top_forest *to, const daft_build_fork *fork, int most)
{
    if (fork->right == 0) {
        daft_build_task *task = &build->tasks[fork->first];
        forest trees = {.count = 0};
        forest_add(&trees, task->forks, most);
        task->tree_count = trees.count;
        for (int i = 0; i < trees.count; i++) {
            task->trees[i] = to->of.trees[to->of.count] = trees.trees[i];
            to->codes[to->of.count++] = DAFT_CHILD_LEAF | fork->first * DAFT_WIDTH | (uint32_t)i;
        }
        return;
    }
    most = trees_of(fork, most);
    if (most == 1) {
        to->of.trees[to->of.count] = fork, to->codes[to->of.count++] = 0;
        return;
    }
    int left = lowest_bits(fork->cost[most - 1]);
    top_add(build, to, fork + 1, left);
    top_add(build, to, fork + fork->right, most - left);
}

/* A fork over cells that is parted; DAFT_CHILD_NONE: memory is out. */
static uint32_t top_node(daft_build *build, const daft_build_fork *fork)
{
    daft_node_list *nodes = &build->top_nodes;
    if (!daft_grow(build->allocator, &nodes->items, &nodes->capacity, nodes->count + 1, nodes->count,
                   sizeof(daft_node)))
        return DAFT_CHILD_NONE;
    uint32_t self = (uint32_t)nodes->count++;
    top_forest under = {.of.count = 0};
    top_add(build, &under, fork + 1, fork->left);
    top_add(build, &under, fork + fork->right, DAFT_WIDTH - fork->left);
    for (int i = 0; i < under.of.count; i++) {
        if (under.codes[i] == 0) under.codes[i] = top_node(build, under.of.trees[i]);
        if (under.codes[i] == DAFT_CHILD_NONE) return DAFT_CHILD_NONE;
    }
    node_fill(&nodes->items[self], &under.of, under.codes);
    return self;
}

/* ---- tasks ---- */

/* The whole's root is a node, even over a single leaf. */
static bool is_root(const daft_build *build, const daft_build_fork *tree)
{
    return build->top_nodes.count == 0 && tree == build->tasks[0].trees[0];
}

static void tally(const daft_build *build, daft_build_task *task, const daft_build_fork *tree, bool root)
{
    if (tree->left == 0 && !root) {
        task->block_count += blocks_of(&build->rule, tree->count);
        return;
    }
    task->node_count++;
    forest under = children(tree);
    for (int i = 0; i < under.count; i++) tally(build, task, under.trees[i], false);
}

static void tally_task(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const daft_build *build = context;
    daft_build_task *task = &build->tasks[index];
    task->node_count = task->block_count = 0;
    for (int i = 0; i < task->tree_count; i++) tally(build, task, task->trees[i], is_root(build, task->trees[i]));
}

bool daft_build_collapse(daft_build *build)
{
    for (size_t i = 0; i < build->task_count; i++)
        if (!build->tasks[i].forks) return false;
    if (build->task_count == 1) {
        build->tasks[0].trees[0] = build->tasks[0].forks, build->tasks[0].tree_count = 1;
    } else {
        weigh_top(build);
        if (top_node(build, build->top.forks) == DAFT_CHILD_NONE) return false;
    }
    daft_region_for(build->region, (uint32_t)build->task_count, tally_task, build);
    build->node_count = build->top_nodes.count, build->block_count = 0;
    for (size_t i = 0; i < build->task_count; i++) {
        daft_build_task *task = &build->tasks[i];
        task->node_base = build->node_count, task->block_base = build->block_count;
        build->node_count += task->node_count, build->block_count += task->block_count;
    }
    return true;
}

/* ---- writing ---- */

typedef struct writer {
    const daft_build *build;
    const daft_build_out *out;
    size_t node, block; /* the next */
} writer;

static uint32_t leaf_write(writer *w, const daft_build_fork *leaf)
{
    if (w->build->rule.block_size == 1) return DAFT_CHILD_LEAF | leaf->first;
    const uint32_t *numbers = w->build->numbers + leaf->first;
    uint32_t first = (uint32_t)w->block, blocks = blocks_of(&w->build->rule, leaf->count);
    for (uint32_t i = 0; i < blocks * DAFT_BLOCK; i++)
        w->out->blocks[first + i / DAFT_BLOCK].triangle[i % DAFT_BLOCK] =
            i < leaf->count ? numbers[i] : DAFT_NO_TRIANGLE;
    for (uint32_t i = 0; i < blocks; i++) daft_block_fill(w->out->mesh, &w->out->blocks[first + i]);
    w->block += blocks;
    return DAFT_CHILD_LEAF | first << 2 | (blocks - 1);
}

static uint32_t tree_write(writer *w, const daft_build_fork *tree, bool root)
{
    if (tree->left == 0 && !root) return leaf_write(w, tree);
    uint32_t codes[DAFT_WIDTH], self = (uint32_t)w->node++;
    forest under = children(tree);
    for (int i = 0; i < under.count; i++) codes[i] = tree_write(w, under.trees[i], false);
    node_fill(&w->out->nodes[self], &under, codes);
    return self;
}

typedef struct write_job {
    const daft_build *build;
    const daft_build_out *out;
} write_job;

static void write_task(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const write_job *job = context;
    daft_build_task *task = &job->build->tasks[index];
    writer w = {job->build, job->out, task->node_base, task->block_base};
    for (int i = 0; i < task->tree_count; i++)
        task->codes[i] = tree_write(&w, task->trees[i], is_root(w.build, task->trees[i]));
}

void daft_build_write(daft_build *build, const daft_build_out *out)
{
    write_job job = {build, out};
    daft_region_for(build->region, (uint32_t)build->task_count, write_task, &job);
    for (size_t i = 0; i < build->top_nodes.count; i++) {
        out->nodes[i] = build->top_nodes.items[i];
        for (int k = 0; k < DAFT_WIDTH; k++) {
            uint32_t code = out->nodes[i].child[k];
            if (!(code & DAFT_CHILD_LEAF) || code == DAFT_CHILD_NONE) continue;
            code &= ~DAFT_CHILD_LEAF;
            out->nodes[i].child[k] = build->tasks[code / DAFT_WIDTH].codes[code % DAFT_WIDTH];
        }
    }
}
