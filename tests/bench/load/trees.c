/* Trees: how long they take to build, to fit and to go through, for meshes of 1,000 to 10 million triangles and for up
 * to 100,000 instances; and the kd-tree beside the BVH. */
#include "harness/bench.h"

#include "math/simd/dispatch.h"
#include "math/trig.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- meshes of any size ---- */

static daft_vec3 bumpy(double u, double v)
{
    double height = 0.05 * daft_sin(40 * u) * daft_cos(33 * v) + 0.01 * daft_sin(210 * u + 90 * v);
    return daft_v3((float)(u - 0.5), (float)height, (float)(v - 0.5));
}

typedef struct tree_job {
    bench *self;
    daft_trimesh mesh;
    int threads, isa;
    daft_bvh *bvh;
    daft_kdtree *kdtree;
} tree_job;

static double mtris(const tree_job *job, double ms) { return job->mesh.triangle_count / ms / 1e3; }

static double build_bvh(void *context)
{
    tree_job *job = context;
    const daft_bvh_def def = {.threads = job->threads, .isa = job->isa};
    double start = daft_clock_ms();
    daft_bvh *bvh = daft_bvh_build(&job->self->allocator, &job->mesh, &def, NULL);
    double ms = daft_clock_ms() - start;
    if (!bvh) return -1;
    daft_bvh_free(bvh);
    return mtris(job, ms);
}

/* ---- refit ---- */

static double refit(void *context)
{
    tree_job *job = context;
    const daft_bvh_def def = {.threads = job->threads, .isa = job->isa};
    double start = daft_clock_ms();
    daft_bvh_update(job->bvh, &job->mesh, &def);
    return mtris(job, daft_clock_ms() - start);
}

static void measure_refit(bench *self, const char *scene, tree_job *job)
{
    int threads[2], count = bench_thread_counts(self, threads);
    for (int t = 0; t < count && job->bvh; t++) {
        job->threads = threads[t];
        bench_subject subject = {.scene = scene,
                                 .what = "tree: refit",
                                 .unit = "Mtri/s",
                                 .isa = self->isa,
                                 .threads = threads[t],
                                 .ours = refit,
                                 .peer = build_bvh,
                                 .context = job,
                                 .peer_name = "our build",
                                 .own_peer = true};
        bench_measure(self, &subject);
    }
}

/* ---- the kd-tree ---- */

static double build_kdtree(void *context)
{
    tree_job *job = context;
    double start = daft_clock_ms();
    daft_kdtree *tree = daft_kdtree_build(&job->self->allocator, &job->mesh, job->threads, NULL);
    double ms = daft_clock_ms() - start;
    if (!tree) return -1;
    daft_kdtree_free(tree);
    return mtris(job, ms);
}

enum { RAYS = 20000 };

typedef struct ray_job {
    const daft_accel_kernels *kernels;
    const daft_tlas *top[2]; /* through the kd-tree, through the BVH */
    daft_instance instance[2];
    daft_arena arena;
    daft_ray *rays;
    bool any;
    uint32_t hits[2];
} ray_job;

static double trace(ray_job *job, int which)
{
    double start = daft_clock_ms();
    job->hits[which] = 0;
    for (int i = 0; i < RAYS; i++) {
        daft_hit hit;
        job->hits[which] += job->any ? job->kernels->occluded(job->top[which], &job->rays[i])
                                     : job->kernels->closest(job->top[which], &job->rays[i], UINT32_MAX, &hit);
    }
    return RAYS / (daft_clock_ms() - start) / 1e3;
}

static double trace_first(void *context) { return trace(context, 0); }
static double trace_second(void *context) { return trace(context, 1); }

static void describe_rays(void *context, char *out, size_t size)
{
    const ray_job *job = context;
    snprintf(out, size, "%d rays, %u and %u hits", RAYS, job->hits[0], job->hits[1]);
}

static daft_vec3 within(uint64_t *state, daft_vec3 low, daft_vec3 high)
{
    daft_vec3 size = daft_sub(high, low);
    float x = bench_random(state), y = bench_random(state);
    return daft_v3(low.x + x * size.x, low.y + y * size.y, low.z + bench_random(state) * size.z);
}

/* From anywhere in the box, grown by half, to anywhere in it. */
static daft_ray *make_rays(bench *self, daft_vec3 low, daft_vec3 high)
{
    daft_ray *rays = daft_alloc(&self->allocator, RAYS, sizeof *rays);
    uint64_t state = 1;
    daft_vec3 grown = daft_scale(daft_sub(high, low), 0.5f);
    for (int i = 0; rays && i < RAYS; i++) {
        daft_vec3 from = within(&state, daft_sub(low, grown), daft_add(high, grown)), at = within(&state, low, high);
        rays[i] = (daft_ray){.origin = from, .direction = daft_sub(at, from), .tmax = INFINITY};
    }
    return rays;
}

static void place(ray_job *rays, const tree_job *job)
{
    const daft_affine same = {.m = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    static const uint32_t material = 0;
    for (int i = 0; i < 2; i++) {
        rays->instance[i] = (daft_instance){.mesh = &job->mesh,
                                            .bvh = job->bvh,
                                            .kdtree = i ? NULL : job->kdtree,
                                            .to_frame = same,
                                            .to_object = same,
                                            .materials = &material,
                                            .flags = DAFT_INSTANCE_CASTS_SHADOW};
        daft_instance_bound(&rays->instance[i]);
        rays->top[i] = daft_tlas_build(&rays->arena, &rays->instance[i], 1, NULL);
    }
}

static void measure_rays(bench *self, const char *scene, const tree_job *job)
{
    ray_job rays = {.kernels = daft_accel_kernels_for(job->isa),
                    .rays = make_rays(self, job->mesh.low, job->mesh.high)};
    daft_arena_init(&rays.arena, &self->allocator);
    place(&rays, job);
    for (int any = 0; any < 2 && rays.rays && rays.top[0] && rays.top[1]; any++) {
        rays.any = any;
        bench_subject subject = {.scene = scene,
                                 .what = any ? "tree: kd-tree, any hit" : "tree: kd-tree, nearest hit",
                                 .unit = "Mray/s",
                                 .isa = self->isa,
                                 .threads = 1,
                                 .ours = trace_first,
                                 .peer = trace_second,
                                 .context = &rays,
                                 .peer_name = "our BVH",
                                 .describe = describe_rays,
                                 .own_peer = true};
        bench_measure(self, &subject);
    }
    daft_release(&self->allocator, rays.rays);
    daft_arena_free(&rays.arena);
}

static void measure_kdtree(bench *self, const char *scene, tree_job *job)
{
    job->threads = 1;
    job->kdtree = daft_kdtree_build(&self->allocator, &job->mesh, daft_processor_count(), NULL);
    if (!job->kdtree || !job->bvh) return;
    bench_subject build = {.scene = scene,
                           .what = "tree: kd-tree, build",
                           .unit = "Mtri/s",
                           .isa = self->isa,
                           .threads = 1,
                           .ours = build_kdtree,
                           .peer = build_bvh,
                           .context = job,
                           .peer_name = "our BVH",
                           .own_peer = true};
    bench_measure(self, &build);
    double count = job->mesh.triangle_count;
    bench_row row = {.what = "tree: kd-tree, memory",
                     .unit = "B/tri",
                     .isa = self->isa,
                     .threads = 1,
                     .ours = (double)daft_kdtree_bytes(job->kdtree) / count,
                     .peer = (double)daft_bvh_bytes(job->bvh) / count,
                     .peer_name = "our BVH"};
    bench_label(scene, row.scene, sizeof row.scene);
    bench_add(self, &row);
    measure_rays(self, scene, job);
}

/* ---- the top level ---- */

typedef struct top_job {
    bench *self;
    daft_instance *instances;
    uint32_t count;
    daft_tlas_def def;
    daft_arena arena;
} top_job;

static double build_top(void *context)
{
    top_job *job = context;
    daft_arena_reset(&job->arena);
    double start = daft_clock_ms();
    const daft_tlas *top = daft_tlas_build_for(&job->arena, job->instances, job->count, &job->def, NULL);
    return top ? daft_clock_ms() - start : -1;
}

static void describe_top(void *context, char *out, size_t size)
{
    const top_job *job = context;
    snprintf(out, size, "%u spheres, %.1f bytes each with scratch memory", job->count,
             (double)job->arena.bytes / job->count);
}

static void measure_top(bench *self, const char *scene, uint32_t count)
{
    top_job job = {.self = self, .count = count, .def.isa = daft_isa_best()};
    daft_isa_parse(self->isa, &job.def.isa);
    job.instances = daft_alloc_zero(&self->allocator, count, sizeof *job.instances);
    daft_arena_init(&job.arena, &self->allocator);
    uint64_t state = 7;
    for (uint32_t i = 0; job.instances && i < count; i++) {
        daft_vec3 at = within(&state, daft_v3(-100, -10, -100), daft_v3(100, 10, 100));
        job.instances[i].to_frame = (daft_affine){.m = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .t = {at.x, at.y, at.z}};
        job.instances[i].radius = 0.2f + bench_random(&state);
        daft_instance_bound(&job.instances[i]);
    }
    int threads[2], ways = bench_thread_counts(self, threads);
    for (int t = 0; job.instances && t < ways; t++) {
        job.def.threads = threads[t];
        bench_subject subject = {.scene = scene,
                                 .what = "tree: top level",
                                 .unit = "ms",
                                 .isa = self->isa,
                                 .threads = threads[t],
                                 .ours = build_top,
                                 .context = &job,
                                 .describe = describe_top};
        bench_measure(self, &subject);
    }
    daft_release(&self->allocator, job.instances);
    daft_arena_free(&job.arena);
}

/* ---- all ---- */

static void job_free(tree_job *job)
{
    daft_bvh_free(job->bvh);
    daft_kdtree_free(job->kdtree);
    daft_trimesh_free(&job->self->allocator, &job->mesh);
}

static void measure_model(bench *self, const bench_model *model)
{
    tree_job job = {.self = self};
    daft_isa_parse(self->isa, &job.isa);
    if (!bench_model_load(self, model, &job.mesh)) return;
    job.bvh = bench_tree(self, &job.mesh);
    measure_refit(self, model->name, &job);
    measure_kdtree(self, model->name, &job);
    job_free(&job);
}

static void measure_generated(bench *self, const char *scene, uint32_t triangles)
{
    daft_trimesh mesh;
    uint32_t side = (uint32_t)sqrt(triangles / 2.0);
    if (!bench_grid(self, side, side, bumpy, &mesh)) {
        bench_note(self, true, "%s cannot be made", scene);
        return;
    }
    bench_measure_build(self, scene, "tree: build", &mesh);
    daft_trimesh_free(&self->allocator, &mesh);
}

void bench_trees(bench *self)
{
    static const struct {
        const char *name;
        uint32_t count;
    } grounds[] = {{"1,000 triangles", 1000},
                   {"10,000 triangles", 10000},
                   {"100,000 triangles", 100000},
                   {"1 million triangles", 1000000},
                   {"10 million triangles", 10000000}},
      tops[] = {{"1,000 instances", 1000}, {"10,000 instances", 10000}, {"100,000 instances", 100000}};
    for (size_t i = 0; i < DAFT_COUNT_OF(grounds); i++)
        if (bench_wants(self, grounds[i].name, "tree: build"))
            measure_generated(self, grounds[i].name, grounds[i].count);
    for (size_t i = 0; i < BENCH_MODEL_COUNT; i++)
        if (bench_wants(self, BENCH_MODELS[i].name, "tree: refit and kd-tree")) measure_model(self, &BENCH_MODELS[i]);
    for (size_t i = 0; i < DAFT_COUNT_OF(tops); i++)
        if (bench_wants(self, tops[i].name, "tree: top level")) measure_top(self, tops[i].name, tops[i].count);
}
