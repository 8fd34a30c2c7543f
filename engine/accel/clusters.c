/* Clusters (clusters.h): from the root on, neighbouring children of a node come together while they have no more than eight
 * leaves in all. What has more is taken apart. */
#include "accel/clusters.h"

enum { LEAF_STEPS = 16, CLUSTER_STEPS = 16, GROUP_STEPS = 8 };

/* A node's child and what is below it. */
typedef struct part {
    uint32_t child, first_block, leaves;
} part;

typedef struct cluster_job {
    const daft_bvh *bvh;
    uint32_t *leaves, *first_block; /* below each node */
    daft_clusters *out;
    uint32_t count, filled; /* clusters; of the last one */
} cluster_job;

static part part_of(const cluster_job *j, uint32_t child)
{
    if (child & DAFT_CHILD_LEAF) return (part){child, (child & ~DAFT_CHILD_LEAF) >> 2, 1};
    return (part){child, j->first_block[child], j->leaves[child]};
}

/* A node's children in the order of their blocks. */
static int parts_of(const cluster_job *j, uint32_t node, part parts[DAFT_WIDTH])
{
    int count = 0;
    for (int i = 0; i < DAFT_WIDTH; i++) {
        uint32_t child = j->bvh->nodes.items[node].child[i];
        if (child == DAFT_CHILD_NONE) continue;
        part added = part_of(j, child);
        int at = count++;
        for (; at && parts[at - 1].first_block > added.first_block; at--) parts[at] = parts[at - 1];
        parts[at] = added;
    }
    return count;
}

static void count_leaves(cluster_job *j)
{
    for (size_t n = j->bvh->nodes.count; n-- > 0;) {
        part parts[DAFT_WIDTH];
        int count = parts_of(j, (uint32_t)n, parts);
        j->leaves[n] = 0, j->first_block[n] = count ? parts[0].first_block : 0;
        for (int i = 0; i < count; i++) j->leaves[n] += parts[i].leaves;
    }
}

/* Where there is no room yet, clusters are only counted. */
static void add_leaf(cluster_job *j, uint32_t leaf)
{
    uint32_t at = j->filled++ ? j->count - 1 : j->count++;
    if (!j->out->items) return;
    daft_cluster *cluster = &j->out->items[at];
    cluster->leaf[j->filled - 1] = leaf;
    if (j->filled > 1) return;
    for (int i = 1; i < DAFT_CLUSTER_LEAVES; i++) cluster->leaf[i] = DAFT_CHILD_NONE;
    j->out->all.first[at] = (leaf & ~DAFT_CHILD_LEAF) >> 2;
}

/* Children go onto the stack, the last one first, so leaves come in the order of their blocks. */
static void fill_clusters(cluster_job *j)
{
    uint32_t stack[DAFT_STACK];
    int top = 0;
    j->count = j->filled = 0;
    stack[top++] = 0;
    while (top) {
        uint32_t child = stack[--top];
        part parts[DAFT_WIDTH], whole = part_of(j, child);
        if (j->filled + whole.leaves > DAFT_CLUSTER_LEAVES) j->filled = 0;
        if (child & DAFT_CHILD_LEAF) {
            add_leaf(j, child);
            continue;
        }
        for (int i = parts_of(j, child, parts); i-- > 0;) stack[top++] = parts[i].child;
    }
}

static bool outlines_make(const daft_allocator *a, uint32_t count, daft_outlines *out)
{
    size_t room = (size_t)count + DAFT_CLUSTER_GROUP;
    out->count = count;
    out->balls = daft_alloc_zero(a, room, sizeof *out->balls);
    out->looks = daft_alloc_zero(a, room, sizeof *out->looks);
    out->spreads = daft_alloc_zero(a, room, sizeof *out->spreads);
    out->first = daft_alloc(a, (size_t)count + 1, sizeof *out->first);
    return out->balls && out->looks && out->spreads && out->first;
}

static bool make_room(const daft_allocator *a, uint32_t count, daft_clusters *out)
{
    out->items = daft_alloc_zero(a, count, sizeof *out->items);
    return out->items && outlines_make(a, count, &out->all) &&
           outlines_make(a, (count + DAFT_CLUSTER_GROUP - 1) / DAFT_CLUSTER_GROUP, &out->groups);
}

static void fill_balls(const daft_bvh *bvh, const daft_balls *balls, daft_clusters *c)
{
    for (uint32_t i = 0; i < c->all.count; i++) {
        daft_cluster *to = &c->items[i];
        uint32_t first = c->all.first[i];
        daft_ball_around(balls, &bvh->blocks[first], c->all.first[i + 1] - first, CLUSTER_STEPS, &c->all.balls[i]);
        for (int k = 0; k < DAFT_CLUSTER_LEAVES; k++) {
            to->ball[k] = (daft_ball){{0, 0, 0}, 0};
            if (to->leaf[k] == DAFT_CHILD_NONE) continue;
            daft_ball_around(balls, &bvh->blocks[(to->leaf[k] & ~DAFT_CHILD_LEAF) >> 2], (to->leaf[k] & 3) + 1, LEAF_STEPS, &to->ball[k]);
        }
    }
    for (uint32_t i = 0; i < c->groups.count; i++) {
        uint32_t first = c->groups.first[i];
        daft_ball_around(balls, &bvh->blocks[first], c->groups.first[i + 1] - first, GROUP_STEPS, &c->groups.balls[i]);
    }
}

bool daft_clusters_make(const daft_bvh *bvh, const daft_balls *balls, daft_clusters *out)
{
    const daft_allocator *a = &bvh->allocator;
    cluster_job job = {.bvh = bvh, .out = out};
    *out = (daft_clusters){0};
    job.leaves = daft_alloc(a, bvh->nodes.count, sizeof *job.leaves);
    job.first_block = daft_alloc(a, bvh->nodes.count, sizeof *job.first_block);
    bool done = job.leaves && job.first_block;
    if (done) {
        count_leaves(&job);
        fill_clusters(&job);
        done = make_room(a, job.count, out);
    }
    if (done) {
        fill_clusters(&job);
        out->all.first[out->all.count] = (uint32_t)bvh->block_count;
        for (uint32_t i = 0; i <= out->groups.count; i++)
            out->groups.first[i] = out->all.first[daft_min_u(i * DAFT_CLUSTER_GROUP, out->all.count)];
        fill_balls(bvh, balls, out);
    }
    daft_release(a, job.leaves);
    daft_release(a, job.first_block);
    if (!done) daft_clusters_free(a, out);
    return done;
}

static void outlines_free(const daft_allocator *a, daft_outlines *o)
{
    daft_release(a, o->balls);
    daft_release(a, o->looks);
    daft_release(a, o->spreads);
    daft_release(a, o->first);
}

void daft_clusters_free(const daft_allocator *allocator, daft_clusters *c)
{
    daft_release(allocator, c->items);
    outlines_free(allocator, &c->all);
    outlines_free(allocator, &c->groups);
    *c = (daft_clusters){0};
}

size_t daft_clusters_bytes(const daft_clusters *c)
{
    size_t outlines = (size_t)c->all.count + c->groups.count, room = outlines + 2 * DAFT_CLUSTER_GROUP;
    return c->all.count * sizeof *c->items + (outlines + 2) * sizeof *c->all.first +
           room * (sizeof *c->all.balls + sizeof *c->all.looks + sizeof *c->all.spreads);
}
