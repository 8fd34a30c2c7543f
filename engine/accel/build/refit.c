/* Refit: fits the boxes of a tree to triangles that have moved, from the leaves up. The splits stay, so the tree gets
 * worse as triangles leave their places; when the surface-area cost has grown to WORSE times that of the build, the
 * tree is rebuilt (Lauterbach, Yoon, Tuft, Manocha, "RT-DEFORM: Interactive Ray Tracing of Dynamic Scenes using BVHs",
 * 2006). */
#include "accel/build/build.h"

#include <float.h>
#include <string.h>

enum { NODES_A_TASK = 256, BLOCKS_A_TASK = 1024, TOO_FEW_BLOCKS = 1024 };
#define WORSE 1.4 /* theirs */

typedef struct refit_job {
    daft_bvh *bvh;
    const daft_trimesh *mesh;
} refit_job;

typedef struct block_box {
    v4 low[3], high[3]; /* lanes: triangles */
} block_box;

static block_box block_box_empty(void)
{
    v4 far = v4_set(FLT_MAX);
    return (block_box){{far, far, far}, {-far, -far, -far}};
}

static void add_block(block_box *box, const daft_block *block)
{
    for (int corner = 0; corner < 3; corner++)
        for (int k = 0; k < 3; k++) {
            v4 p = v4_load(block->corner[corner][k]);
            box->low[k] = v4_min(box->low[k], p);
            box->high[k] = v4_max(box->high[k], p);
        }
}

static float least(v4 a) { return fminf(fminf(a[0], a[1]), fminf(a[2], a[3])); }
static float most(v4 a) { return fmaxf(fmaxf(a[0], a[1]), fmaxf(a[2], a[3])); }

static void move_blocks(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const refit_job *job = context;
    size_t end = daft_min_u((index + 1) * BLOCKS_A_TASK, (uint32_t)job->bvh->block_count);
    for (size_t b = (size_t)index * BLOCKS_A_TASK; b < end; b++) daft_block_fill(job->mesh, &job->bvh->blocks[b]);
}

/* The boxes of children that are leaves. */
static void fit_leaves(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const refit_job *job = context;
    const daft_bvh *bvh = job->bvh;
    size_t end = daft_min_u((index + 1) * NODES_A_TASK, (uint32_t)bvh->nodes.count);
    for (size_t n = (size_t)index * NODES_A_TASK; n < end; n++) {
        daft_node *node = &bvh->nodes.items[n];
        for (int i = 0; i < DAFT_WIDTH; i++) {
            uint32_t child = node->child[i];
            if (child == DAFT_CHILD_NONE || !(child & DAFT_CHILD_LEAF)) continue;
            block_box box = block_box_empty();
            const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t k = 0; k <= (child & 3); k++) add_block(&box, &block[k]);
            for (int k = 0; k < 3; k++)
                node->bounds[k][i] = least(box.low[k]), node->bounds[k + 3][i] = most(box.high[k]);
        }
    }
}

/* The boxes of children that are nodes; these stand behind their parents. */
static void fit_nodes(daft_bvh *bvh)
{
    for (size_t n = bvh->nodes.count; n-- > 0;) {
        daft_node *node = &bvh->nodes.items[n];
        for (int i = 0; i < DAFT_WIDTH; i++) {
            if (node->child[i] & DAFT_CHILD_LEAF) continue; /* NONE, too */
            const daft_node *below = &bvh->nodes.items[node->child[i]];
            for (int k = 0; k < 3; k++) {
                const float *low = below->bounds[k], *high = below->bounds[k + 3];
                node->bounds[k][i] = least(v4_min(v4_load(low), v4_load(low + 4)));
                node->bounds[k + 3][i] = most(v4_max(v4_load(high), v4_load(high + 4)));
            }
        }
    }
}

/* What a ray through the root's box costs, in tests of blocks; a node's test counts as one. */
static double tree_cost(const daft_bvh *bvh)
{
    double sum = 0, low[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    for (size_t n = 0; n < bvh->nodes.count; n++) {
        const daft_node *node = &bvh->nodes.items[n];
        for (int i = 0; i < DAFT_WIDTH; i++) {
            uint32_t child = node->child[i];
            if (child == DAFT_CHILD_NONE) continue;
            double side[3];
            for (int k = 0; k < 3; k++) {
                double l = (double)node->bounds[k][i], h = (double)node->bounds[k + 3][i];
                side[k] = h - l;
                if (n == 0) low[k] = fmin(low[k], l), high[k] = fmax(high[k], h);
            }
            double area = side[0] * (side[1] + side[2]) + side[1] * side[2];
            sum += area * (child & DAFT_CHILD_LEAF ? (double)(child & 3) + 1 : 1);
        }
    }
    double x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2], root = x * (y + z) + y * z;
    return root > 0 ? sum / root : 0;
}

/* Takes what another tree of the same mesh holds. */
static void replace(daft_bvh *bvh, daft_bvh *fresh)
{
    daft_bvh old = *bvh;
    *bvh = *fresh;
    *fresh = old;
    daft_bvh_free(fresh);
}

daft_bvh *daft_bvh_copy(const daft_allocator *allocator, const daft_bvh *bvh)
{
    daft_bvh *copy = daft_alloc_zero(allocator, 1, sizeof *copy);
    if (!copy) return NULL;
    *copy = *bvh;
    copy->allocator = *allocator;
    copy->nodes = (daft_node_list){.count = bvh->nodes.count, .capacity = bvh->nodes.count};
    copy->nodes.items = daft_alloc(allocator, bvh->nodes.count + 1, sizeof *copy->nodes.items);
    copy->blocks = daft_alloc(allocator, bvh->block_count + 1, sizeof *copy->blocks);
    if (!copy->nodes.items || !copy->blocks) {
        daft_bvh_free(copy);
        return NULL;
    }
    memcpy(copy->nodes.items, bvh->nodes.items, bvh->nodes.count * sizeof *copy->nodes.items);
    memcpy(copy->blocks, bvh->blocks, bvh->block_count * sizeof *copy->blocks);
    return copy;
}

bool daft_bvh_update(daft_bvh *bvh, const daft_trimesh *mesh, const daft_bvh_def *def)
{
    if (bvh->nodes.count == 0) return false;
    if (bvh->cost < 0) bvh->cost = tree_cost(bvh);
    refit_job job = {bvh, mesh};
    int threads = bvh->block_count < TOO_FEW_BLOCKS ? 1 : def->threads;
    daft_parallel_for(threads, (uint32_t)((bvh->block_count + BLOCKS_A_TASK - 1) / BLOCKS_A_TASK), move_blocks, &job);
    daft_parallel_for(threads, (uint32_t)((bvh->nodes.count + NODES_A_TASK - 1) / NODES_A_TASK), fit_leaves, &job);
    fit_nodes(bvh);
    daft_bvh_measure(bvh, mesh);
    if (!(tree_cost(bvh) > WORSE * bvh->cost)) return false;
    daft_bvh *fresh = daft_bvh_build(&bvh->allocator, mesh, def, NULL);
    if (!fresh) return false;
    replace(bvh, fresh);
    return true;
}
