/* The top level: a tree over instances, built anew each frame into the frame's arena. */
#include "accel/build/build.h"

enum { TOO_FEW = 20000 }; /* fewer instances are not worth waking others for */

/* The builder takes memory from an allocator; this one hands out the arena's and never takes it back. */
static void *arena_allocate(void *user, size_t size, size_t alignment)
{
    (void)alignment;
    return daft_arena_alloc(user, size, 1);
}
static void arena_release(void *user, void *pointer) { (void)user, (void)pointer; }

static bool hittable(const daft_instance *instance)
{
    if (instance->mesh && instance->mesh->triangle_count == 0) return false;
    return daft_finite3(instance->low) && daft_finite3(instance->high);
}

typedef struct nodes_job {
    daft_arena *arena;
    daft_build_prim *prims;
    uint32_t count;
    const daft_tlas_def *def;
    daft_node_list *out;
    bool done;
} nodes_job;

static void build_nodes(void *context, daft_region *region)
{
    nodes_job *job = context;
    daft_allocator allocator = {job->arena, arena_allocate, arena_release};
    daft_build build = {.allocator = &allocator,
                        .region = region,
                        .threads = job->def->threads,
                        .isa = job->def->isa,
                        .rule = {.leaf_size = 1, .block_size = 1},
                        .prims = job->prims,
                        .count = job->count,
                        .fixed = true};
    if (!daft_build_run(&build)) return;
    job->out->items = daft_arena_alloc(job->arena, build.node_count, sizeof(daft_node));
    if (!job->out->items) return;
    job->out->count = job->out->capacity = build.node_count;
    daft_build_write(&build, &(daft_build_out){.nodes = job->out->items});
    job->done = true;
}

/* Whether its bounds are those of its sphere, so that they say where it is, and not so far that squares overflow. */
static bool is_bounded_sphere(const daft_instance *instance)
{
    if (instance->mesh || !(instance->radius > 0)) return false;
    daft_instance bounded = *instance;
    daft_instance_bound(&bounded);
    for (int k = 0; k < 3; k++) {
        float low = daft_v3_at(instance->low, k), high = daft_v3_at(instance->high, k);
        if (daft_v3_at(bounded.low, k) != low || daft_v3_at(bounded.high, k) != high || low < -DAFT_SPHERE_FAR ||
            high > DAFT_SPHERE_FAR)
            return false;
    }
    return true;
}

/* round: by instance; looked up there, for instances are far apart and in another order. */
static void mark_spheres(daft_tlas *tlas, const bool *round)
{
    for (size_t i = 0; i < tlas->nodes.count; i++) {
        daft_node *node = &tlas->nodes.items[i];
        for (uint32_t k = 0; k < DAFT_WIDTH; k++) {
            uint32_t child = node->child[k];
            if (child == DAFT_CHILD_NONE || !(child & DAFT_CHILD_LEAF)) continue;
            node->spheres |= (uint32_t)round[child & ~DAFT_CHILD_LEAF] << k;
        }
    }
}

const daft_tlas *daft_tlas_build(daft_arena *arena, const daft_instance *instances, uint32_t count, daft_error *error)
{
    return daft_tlas_build_for(arena, instances, count, &(daft_tlas_def){DAFT_INTERSECT_EXACT, 1, daft_isa_best()},
                               error);
}

const daft_tlas *daft_tlas_build_for(daft_arena *arena, const daft_instance *instances, uint32_t count,
                                     const daft_tlas_def *def, daft_error *error)
{
    daft_tlas *tlas = daft_arena_alloc(arena, 1, sizeof *tlas);
    daft_build_prim *prims = daft_arena_alloc(arena, count, sizeof *prims);
    bool *round = daft_arena_alloc(arena, count, sizeof *round), any_round = false;
    if (!tlas || !prims || !round) {
        daft_fail_memory(error, "the tree over instances");
        return NULL;
    }
    uint32_t used = 0;
    for (uint32_t i = 0; i < count; i++) {
        round[i] = is_bounded_sphere(&instances[i]), any_round |= round[i];
        if (!hittable(&instances[i])) continue;
        const daft_vec3 l = instances[i].low, h = instances[i].high;
        prims[used++] = (daft_build_prim){{l.x, l.y, l.z}, i, {-h.x, -h.y, -h.z}, 1};
    }
    *tlas = (daft_tlas){.instances = instances, .instance_count = count, .intersection = def->intersection};
    nodes_job job = {arena, prims, used, def, &tlas->nodes, used == 0};
    if (used > 0) daft_parallel_region(used < TOO_FEW ? 1 : def->threads, build_nodes, &job);
    if (job.done && any_round) mark_spheres(tlas, round);
    if (job.done) return tlas;
    daft_fail_memory(error, "the tree over instances");
    return NULL;
}
