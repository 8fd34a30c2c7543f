/* The bottom level: a tree over a mesh's triangles, their corners copied into blocks, and the clusters of the pencil. */
#include "accel/bvh.h"

#include <float.h>
#include <string.h>

typedef struct mesh_build {
    daft_bvh *bvh;
    const daft_trimesh *mesh;
    bool inside; /* a cluster is open */
    uint32_t open_count;
} mesh_build;

static void prim_fill(const daft_trimesh *mesh, uint32_t triangle, daft_build_prim *prim)
{
    const uint32_t *corner = &mesh->indices[3 * (size_t)triangle];
    const float *axes[3] = {mesh->x, mesh->y, mesh->z};
    for (int k = 0; k < 3; k++) {
        float a = axes[k][corner[0]], b = axes[k][corner[1]], c = axes[k][corner[2]];
        float low = a < b ? a : b, high = a < b ? b : a;
        prim->low[k] = c < low ? c : low;
        prim->high[k] = c > high ? c : high;
    }
    prim->id = triangle;
    prim->pad = 0;
}

static bool cluster_open(mesh_build *build, const float box[6])
{
    daft_bvh *bvh = build->bvh;
    if (!daft_grow(&bvh->allocator, &bvh->clusters, &bvh->cluster_capacity, bvh->cluster_count + 1, bvh->cluster_count,
                   sizeof(daft_cluster)))
        return false;
    bvh->clusters[bvh->cluster_count++] = (daft_cluster){.low = daft_v3(box[0], box[1], box[2]),
                                                         .high = daft_v3(box[3], box[4], box[5]),
                                                         .first_block = (uint32_t)bvh->block_count};
    return true;
}

static void cluster_close(mesh_build *build)
{
    daft_cluster *cluster = &build->bvh->clusters[build->bvh->cluster_count - 1];
    cluster->block_count = (uint32_t)build->bvh->block_count - cluster->first_block;
}

static bool mesh_enter(void *context, uint32_t count, const float box[6])
{
    mesh_build *build = context;
    if (build->inside || count > DAFT_CLUSTER) return true;
    build->inside = true;
    build->open_count = count;
    return cluster_open(build, box);
}

static void mesh_leave(void *context, uint32_t count)
{
    mesh_build *build = context;
    if (!build->inside || count != build->open_count) return; /* nodes inside the cluster hold fewer triangles */
    build->inside = false;
    cluster_close(build);
}

static void block_fill(const daft_trimesh *mesh, const daft_build_prim *prims, uint32_t count, daft_block *block)
{
    for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
        uint32_t triangle = prims[i < count ? i : count - 1].id;
        block->triangle[i] = i < count ? triangle : DAFT_NO_TRIANGLE;
        for (int k = 0; k < 3; k++) {
            uint32_t vertex = mesh->indices[3 * (size_t)triangle + (size_t)k];
            block->corner[k][0][i] = mesh->x[vertex];
            block->corner[k][1][i] = mesh->y[vertex];
            block->corner[k][2][i] = mesh->z[vertex];
        }
    }
}

static uint32_t mesh_leaf(void *context, const daft_build_prim *prims, uint32_t count)
{
    mesh_build *build = context;
    daft_bvh *bvh = build->bvh;
    uint32_t blocks = (count + DAFT_BLOCK - 1) / DAFT_BLOCK, first = (uint32_t)bvh->block_count;
    if (!daft_grow(&bvh->allocator, &bvh->blocks, &bvh->block_capacity, bvh->block_count + blocks, bvh->block_count,
                   sizeof(daft_block)))
        return DAFT_CHILD_NONE;
    bool alone = !build->inside; /* a leaf right below a range that is too large for a cluster */
    if (alone) {
        float box[6] = {FLT_MAX, FLT_MAX, FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};
        for (uint32_t i = 0; i < count; i++)
            for (int k = 0; k < 3; k++) {
                if (prims[i].low[k] < box[k]) box[k] = prims[i].low[k];
                if (prims[i].high[k] > box[k + 3]) box[k + 3] = prims[i].high[k];
            }
        if (!cluster_open(build, box)) return DAFT_CHILD_NONE;
    }
    for (uint32_t b = 0; b < blocks; b++)
        block_fill(build->mesh, prims + b * DAFT_BLOCK, count - b * DAFT_BLOCK, &bvh->blocks[bvh->block_count++]);
    if (alone) cluster_close(build);
    return DAFT_CHILD_LEAF | first << 2 | (blocks - 1);
}

/* Arrays grow by doubling; a mesh lives long, so what it does not use is given back. Without memory for it nothing changes. */
static void trim(const daft_allocator *allocator, void *array_pointer, size_t *capacity, size_t count, size_t size)
{
    void *array, *exact = count && count < *capacity ? daft_alloc(allocator, count, size) : NULL;
    if (!exact) return;
    memcpy(&array, array_pointer, sizeof array);
    memcpy(exact, array, count * size);
    daft_release(allocator, array);
    memcpy(array_pointer, &exact, sizeof exact);
    *capacity = count;
}

static void trim_tree(daft_bvh *bvh)
{
    const daft_allocator *a = &bvh->allocator;
    trim(a, &bvh->nodes.items, &bvh->nodes.capacity, bvh->nodes.count, sizeof(daft_node));
    trim(a, &bvh->blocks, &bvh->block_capacity, bvh->block_count, sizeof(daft_block));
    trim(a, &bvh->clusters, &bvh->cluster_capacity, bvh->cluster_count, sizeof(daft_cluster));
}

enum { FILL_CHUNK = 16384 };

typedef struct fill_job {
    const daft_trimesh *mesh;
    daft_build_prim *prims;
} fill_job;

static void fill_chunk(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const fill_job *job = context;
    uint32_t first = index * FILL_CHUNK, end = daft_min_u(first + FILL_CHUNK, job->mesh->triangle_count);
    for (uint32_t i = first; i < end; i++) prim_fill(job->mesh, i, &job->prims[i]);
}

daft_bvh *daft_bvh_build_mesh(const daft_allocator *allocator, const daft_trimesh *mesh, int threads, daft_error *error)
{
    daft_bvh *bvh = daft_alloc_zero(allocator, 1, sizeof *bvh);
    daft_build_prim *prims = daft_alloc(allocator, mesh->triangle_count, sizeof *prims);
    bool built = false;
    if (bvh && prims) {
        bvh->allocator = *allocator;
        fill_job job = {mesh, prims};
        daft_parallel_for(threads, (mesh->triangle_count + FILL_CHUNK - 1) / FILL_CHUNK, fill_chunk, &job);
        mesh_build build = {.bvh = bvh, .mesh = mesh};
        daft_builder builder = {.allocator = allocator,
                                .prims = prims,
                                .nodes = &bvh->nodes,
                                .leaf_size = DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK,
                                .block_size = DAFT_BLOCK,
                                .context = &build,
                                .leaf = mesh_leaf,
                                .enter = mesh_enter,
                                .leave = mesh_leave};
        built = daft_build_tree(&builder, mesh->triangle_count);
    }
    daft_release(allocator, prims);
    if (built) {
        trim_tree(bvh);
        return bvh;
    }
    if (bvh) bvh->allocator = *allocator, daft_bvh_free(bvh);
    daft_fail_memory(error, "the BVH of a mesh");
    return NULL;
}

void daft_bvh_free(daft_bvh *bvh)
{
    if (!bvh) return;
    daft_allocator allocator = bvh->allocator;
    daft_release(&allocator, bvh->nodes.items);
    daft_release(&allocator, bvh->blocks);
    daft_release(&allocator, bvh->clusters);
    daft_release(&allocator, bvh);
}

size_t daft_bvh_bytes(const daft_bvh *bvh)
{
    return sizeof *bvh + bvh->nodes.capacity * sizeof(daft_node) + bvh->block_capacity * sizeof(daft_block) +
           bvh->cluster_capacity * sizeof(daft_cluster);
}
