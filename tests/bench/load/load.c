/* The work before the first frame: reading an OBJ file, building the BVH, and the memory of both. */
#include "harness/bench.h"

#include "math/simd/dispatch.h"

#include "accel/accel.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- OBJ ---- */

typedef struct obj_job {
    bench *self;
    const char *path;
    double megabytes;
    size_t triangles, peer_triangles;
    bool with_normals; /* smooth ones where the file has none; tinyobjloader makes none */
    bench_obj_loader *peer;
} obj_job;

static double obj_ours(void *context)
{
    obj_job *job = context;
    daft_obj obj;
    daft_log log = {0};
    double start = bench_clock_ms(1);
    bool loaded = job->with_normals ? daft_obj_load(&job->self->allocator, NULL, job->path, &log, &obj, NULL)
                                    : daft_obj_load_triangles(&job->self->allocator, NULL, job->path, &log, &obj, NULL);
    if (!loaded) return -1;
    double ms = bench_clock_ms(1) - start;
    job->triangles = obj.mesh.triangle_count;
    daft_obj_free(&job->self->allocator, &obj);
    return job->megabytes / ms * 1e3;
}

static double obj_peer(void *context)
{
    obj_job *job = context;
    double ms = job->peer(job->path, &job->peer_triangles);
    return ms < 0 ? -1 : job->megabytes / ms * 1e3;
}

static void obj_describe(void *context, char *out, size_t size)
{
    obj_job *job = context;
    int used = snprintf(out, size, "%.2f MB, %zu triangles", job->megabytes, job->triangles);
    if (job->peer_triangles && used > 0 && (size_t)used < size)
        snprintf(out + used, size - (size_t)used, ", peer %zu", job->peer_triangles);
}

/* The generated mesh as a file: v, vt, vn and faces that name all three. */
static bool write_obj(const daft_trimesh *mesh, const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file) return false;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        double x = (double)mesh->x[i], y = (double)mesh->y[i], z = (double)mesh->z[i];
        fprintf(file, "v %.6f %.6f %.6f\nvt %.5f %.5f\nvn %.4f %.4f %.4f\n", x, y, z, x + 0.5, z + 0.5, -y, 1 - y * y,
                y);
    }
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *v = &mesh->indices[3 * (size_t)i];
        fprintf(file, "f %u/%u/%u %u/%u/%u %u/%u/%u\n", v[0] + 1, v[0] + 1, v[0] + 1, v[1] + 1, v[1] + 1, v[1] + 1,
                v[2] + 1, v[2] + 1, v[2] + 1);
    }
    bool written = !ferror(file);
    return fclose(file) == 0 && written;
}

static bool obj_path(bench *self, const bench_model *model, char *out, size_t size, bool *temporary)
{
    *temporary = !bench_model_path(model, out, size);
    if (!*temporary) return true;
    const char *folder = getenv("TMPDIR");
    snprintf(out, size, "%s/daft_bench_%ld.obj", folder ? folder : "/tmp", (long)getpid());
    daft_trimesh mesh;
    if (!bench_model_load(self, model, &mesh)) return false;
    bool written = write_obj(&mesh, out);
    daft_trimesh_free(&self->allocator, &mesh);
    if (!written) bench_note(self, true, "cannot write %s", out);
    return written;
}

static const char TRIANGLES_ALONE[] = "OBJ load, triangles alone", WITH_NORMALS[] = "OBJ load, with normals";

static void measure_file(bench *self, const bench_model *model, const char *path, bool alone, bool with_normals)
{
    struct stat status;
    if (stat(path, &status) != 0) return;
    obj_job job = {self, path, (double)status.st_size / 1e6, 0, 0, false, self->peers ? bench_find_tinyobj() : NULL};
    bench_subject subject = {.scene = model->name,
                             .what = TRIANGLES_ALONE,
                             .unit = "MB/s",
                             .isa = self->isa,
                             .threads = 1,
                             .ours = obj_ours,
                             .peer = job.peer ? obj_peer : NULL,
                             .context = &job,
                             .peer_name = "tinyobjloader",
                             .describe = obj_describe,
                             .budget = {.floor = 4}};
    if (alone) bench_measure(self, &subject);
    job.with_normals = true;
    subject.what = WITH_NORMALS, subject.budget = (bench_budget){0};
    if (with_normals) bench_measure_twice(self, &subject, "OBJ load, throughput", (bench_budget){200, 0, true});
}

static void measure_obj(bench *self, const bench_model *model)
{
    bool alone = bench_wants(self, model->name, TRIANGLES_ALONE),
         with_normals = bench_wants(self, model->name, WITH_NORMALS);
    char path[1024];
    bool temporary;
    if ((!alone && !with_normals) || !obj_path(self, model, path, sizeof path, &temporary)) return;
    measure_file(self, model, path, alone, with_normals);
    if (temporary) unlink(path);
}

/* ---- BVH ---- */

typedef struct build_job {
    bench *self;
    const daft_trimesh *mesh;
    int threads;
    size_t bytes;
    const bench_embree_api *api;
    bench_embree *embree;
} build_job;

static double build_ours(void *context)
{
    build_job *job = context;
    const daft_bvh_def def = {.threads = job->threads, .isa = daft_isa_best()};
    double start = daft_clock_ms();
    daft_bvh *bvh = daft_bvh_build(&job->self->allocator, job->mesh, &def, NULL);
    double ms = daft_clock_ms() - start;
    if (!bvh) return -1;
    job->bytes = daft_bvh_bytes(bvh) + daft_trimesh_bytes(job->mesh);
    daft_bvh_free(bvh);
    return job->mesh->triangle_count / ms / 1e3;
}

static double build_peer(void *context)
{
    build_job *job = context;
    return job->mesh->triangle_count / job->api->build_ms(job->embree) / 1e3;
}

static void build_describe(void *context, char *out, size_t size)
{
    build_job *job = context;
    snprintf(out, size, "%u triangles, %.1f bytes each with the mesh", job->mesh->triangle_count,
             (double)job->bytes / job->mesh->triangle_count);
}

void bench_measure_build(bench *self, const char *scene, const char *what, const daft_trimesh *mesh)
{
    build_job job = {.self = self, .mesh = mesh, .api = self->peers ? bench_find_embree() : NULL};
    int threads[2], count = bench_thread_counts(self, threads);
    for (int t = 0; t < count; t++) {
        job.threads = threads[t];
        if (job.api) job.embree = job.api->create(mesh, false, threads[t]);
        bench_subject subject = {.scene = scene,
                                 .what = what,
                                 .unit = "Mtri/s",
                                 .isa = self->isa,
                                 .threads = threads[t],
                                 .ours = build_ours,
                                 .peer = job.embree ? build_peer : NULL,
                                 .context = &job,
                                 .peer_name = job.api ? job.api->name : "Embree",
                                 .describe = build_describe,
                                 .budget = {.floor = 1}};
        bench_measure(self, &subject);
        if (job.api) job.api->destroy(job.embree);
        job.embree = NULL;
    }
}

static void measure_build(bench *self, const bench_model *model)
{
    daft_trimesh mesh;
    if (!bench_model_load(self, model, &mesh)) return;
    bench_measure_build(self, model->name, "BVH build", &mesh);
    daft_trimesh_free(&self->allocator, &mesh);
}

static void measure_memory(bench *self, const bench_model *model)
{
    daft_trimesh mesh;
    if (!bench_model_load(self, model, &mesh)) return;
    daft_bvh *bvh = daft_bvh_build_mesh(&self->allocator, &mesh, 1, NULL);
    if (bvh) {
        double count = mesh.triangle_count, own = (double)daft_trimesh_bytes(&mesh), tree = (double)daft_bvh_bytes(bvh);
        bench_row row = {.what = "memory",
                         .unit = "B/tri",
                         .isa = self->isa,
                         .threads = 1,
                         .ours = (own + tree) / count,
                         .peer = -1,
                         .budget = {96, 0, true}};
        bench_label(model->name, row.scene, sizeof row.scene);
        snprintf(row.counters, sizeof row.counters, "mesh %.1f, BVH %.1f bytes a triangle", own / count, tree / count);
        bench_add(self, &row);
        daft_bvh_free(bvh);
    }
    daft_trimesh_free(&self->allocator, &mesh);
}

void bench_load(bench *self)
{
    for (size_t i = 0; i < BENCH_MODEL_COUNT; i++) measure_obj(self, &BENCH_MODELS[i]);
    for (size_t i = 0; i < BENCH_MODEL_COUNT; i++)
        if (bench_wants(self, BENCH_MODELS[i].name, "memory")) measure_memory(self, &BENCH_MODELS[i]);
    for (size_t i = 0; i < BENCH_MODEL_COUNT; i++)
        if (bench_wants(self, BENCH_MODELS[i].name, "BVH build")) measure_build(self, &BENCH_MODELS[i]);
}
