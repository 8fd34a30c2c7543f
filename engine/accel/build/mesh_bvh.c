/* The bottom level: a tree over a mesh's triangles, their corners copied into blocks. */
#include "accel/build/build.h"

#include <string.h>

static void prim_fill(const daft_trimesh *mesh, uint32_t triangle, daft_build_prim *prim)
{
    const uint32_t *corner = &mesh->indices[3 * (size_t)triangle];
    const float *axes[3] = {mesh->x, mesh->y, mesh->z};
    for (int k = 0; k < 3; k++) {
        float a = axes[k][corner[0]], b = axes[k][corner[1]], c = axes[k][corner[2]];
        float low = a < b ? a : b, high = a < b ? b : a;
        prim->low[k] = c < low ? c : low;
        prim->high[k] = -(c > high ? c : high);
    }
    prim->id = triangle;
    prim->weight = 1;
}

enum { FILL_CHUNK = 16384, TOO_FEW = 16384 }; /* fewer triangles are not worth waking others for */

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

/* ---- out ---- */

void daft_block_fill(const daft_trimesh *mesh, daft_block *block)
{
    const uint32_t *corner = NULL;
    for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
        if (block->triangle[i] != DAFT_NO_TRIANGLE) corner = &mesh->indices[3 * (size_t)block->triangle[i]];
        for (int k = 0; k < 3; k++) {
            uint32_t vertex = corner[k];
            block->corner[k][0][i] = mesh->x[vertex];
            block->corner[k][1][i] = mesh->y[vertex];
            block->corner[k][2][i] = mesh->z[vertex];
        }
    }
}

static bool write_tree(daft_build *build, const daft_trimesh *mesh, daft_bvh *bvh)
{
    const daft_allocator *a = &bvh->allocator;
    bvh->nodes.items = daft_alloc(a, build->node_count, sizeof(daft_node));
    bvh->blocks = daft_alloc(a, build->block_count, sizeof(daft_block));
    if (!bvh->nodes.items || !bvh->blocks) return false;
    bvh->nodes.count = bvh->nodes.capacity = build->node_count;
    bvh->block_count = build->block_count;
    daft_build_write(build, &(daft_build_out){bvh->nodes.items, bvh->blocks, mesh});
    return true;
}

typedef struct mesh_job {
    const daft_trimesh *mesh;
    daft_bvh *bvh;
    const daft_bvh_def *def;
    bool done;
} mesh_job;

static bool build_nodes(daft_build *build, const daft_trimesh *mesh)
{
    build->prims = daft_alloc(build->allocator, build->count, sizeof *build->prims);
    if (!build->prims) return false;
    fill_job fill = {mesh, build->prims};
    daft_region_for(build->region, (build->count + FILL_CHUNK - 1) / FILL_CHUNK, fill_chunk, &fill);
    bool done = daft_build_run(build);
    daft_release(build->allocator, build->prims);
    daft_release(build->allocator, build->other); /* what is written has no need of them */
    build->prims = build->other = NULL;
    return done;
}

static void build_mesh(void *context, daft_region *region)
{
    mesh_job *job = context;
    daft_build build = {.allocator = &job->bvh->allocator,
                        .region = region,
                        .threads = job->def->threads,
                        .isa = job->def->isa,
                        .rule = {.leaf_size = DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK, .block_size = DAFT_BLOCK},
                        .count = job->mesh->triangle_count};
    job->done = build_nodes(&build, job->mesh) && write_tree(&build, job->mesh, job->bvh);
    daft_build_free(&build);
}

static void tree_release(daft_bvh *bvh)
{
    daft_release(&bvh->allocator, bvh->nodes.items);
    daft_release(&bvh->allocator, bvh->blocks);
    bvh->nodes = (daft_node_list){0}, bvh->blocks = NULL, bvh->block_count = 0;
}

static bool build_tree(mesh_job *job)
{
    if (job->mesh->triangle_count == 0) return true;
    daft_parallel_region(job->mesh->triangle_count < TOO_FEW ? 1 : job->def->threads, build_mesh, job);
    return job->done;
}

daft_bvh *daft_bvh_build(const daft_allocator *allocator, const daft_trimesh *mesh, const daft_bvh_def *def,
                         daft_error *error)
{
    daft_bvh *bvh = daft_alloc_zero(allocator, 1, sizeof *bvh);
    mesh_job job = {.mesh = mesh, .bvh = bvh, .def = def};
    if (bvh) {
        bvh->allocator = *allocator;
        bvh->cost = -1;
        daft_bvh_measure(bvh, mesh);
        if (build_tree(&job)) return bvh;
    }
    daft_bvh_free(bvh);
    daft_fail_memory(error, "the BVH of a mesh");
    return NULL;
}

daft_bvh *daft_bvh_build_mesh(const daft_allocator *allocator, const daft_trimesh *mesh, int threads, daft_error *error)
{
    return daft_bvh_build(allocator, mesh, &(daft_bvh_def){.threads = threads, .isa = daft_isa_best()}, error);
}

void daft_bvh_free(daft_bvh *bvh)
{
    if (!bvh) return;
    daft_allocator allocator = bvh->allocator;
    tree_release(bvh);
    daft_release(&allocator, bvh);
}

size_t daft_bvh_bytes(const daft_bvh *bvh)
{
    return sizeof *bvh + bvh->nodes.capacity * sizeof(daft_node) + bvh->block_count * sizeof(daft_block);
}
