/* Camera rays a second: the exact test and the fast one against Embree's packets, and the cost of the exact one
 * beside our other two. Both sides are timed around all their work for a frame. */
#include "harness/scenes.h"

#include <stdio.h>
#include <string.h>

typedef struct camera_job {
    const bench_scene *scene;
    bench_camera *camera;
    uint64_t peer_hits;
    daft_intersection other; /* the test that the exact one is compared with */
    const bench_embree_api *api;
    bench_embree *embree;
} camera_job;

static double mrays(double ms) { return ms < 0 ? -1 : BENCH_WIDTH * BENCH_HEIGHT / ms / 1e3; }

static double camera_exact(void *context)
{
    camera_job *job = context;
    return mrays(bench_camera_ms(job->camera, DAFT_INTERSECT_EXACT));
}

static double camera_fast(void *context)
{
    camera_job *job = context;
    return mrays(bench_camera_ms(job->camera, DAFT_INTERSECT_FAST));
}

static double camera_other(void *context)
{
    camera_job *job = context;
    return mrays(bench_camera_ms(job->camera, job->other));
}

static double camera_peer(void *context)
{
    camera_job *job = context;
    return mrays(job->api->camera_ms(job->embree, &job->scene->view, &job->peer_hits));
}

static void camera_describe(void *context, char *out, size_t size)
{
    camera_job *job = context;
    bench_camera_counts c = bench_camera_counted(job->camera);
    int used = snprintf(out, size, "%.1f%% hit, %llu triangles tested, %llu exact edges",
                        (double)c.hits * 100 / (BENCH_WIDTH * BENCH_HEIGHT), (unsigned long long)c.triangles_tested,
                        (unsigned long long)c.exact_edges);
    if (job->embree && used > 0 && (size_t)used < size)
        snprintf(out + used, size - (size_t)used, ", peer %+lld hits", (long long)(job->peer_hits - c.hits));
}

/* The pixels in which the other test differs from the exact one. */
static void other_describe(void *context, char *out, size_t size)
{
    enum { PIXELS = BENCH_WIDTH * BENCH_HEIGHT };
    camera_job *job = context;
    const daft_allocator allocator = daft_malloc_allocator();
    uint64_t *seen = daft_alloc(&allocator, 2 * PIXELS, sizeof *seen);
    if (!seen) return;
    uint32_t wrong = 0, holes = 0;
    bench_camera_see(job->camera, DAFT_INTERSECT_EXACT, seen);
    bench_camera_see(job->camera, job->other, seen + PIXELS);
    for (int i = 0; i < PIXELS; i++) {
        wrong += seen[i] != seen[PIXELS + i];
        holes += seen[i] != BENCH_NOTHING && seen[PIXELS + i] == BENCH_NOTHING;
    }
    snprintf(out, size, "%s: %u pixels wrong, %u of them holes", daft_intersection_name(job->other), wrong, holes);
    daft_release(&allocator, seen);
}

static const char CAMERA[] = "camera rays, exact", FAST[] = "camera rays, fast";
/* A ratio of 0.95 says that the exact test runs at 95 % of the other's speed. */
static const char *const EXACT_TO[] = {[DAFT_INTERSECT_WATERTIGHT] = "intersection, exact to watertight",
                                       [DAFT_INTERSECT_FAST] = "intersection, exact to fast"};

static void measure_intersections(bench *self, camera_job *job, int threads)
{
    for (daft_intersection other = DAFT_INTERSECT_WATERTIGHT; other <= DAFT_INTERSECT_FAST; other++) {
        if (!bench_wants(self, job->scene->name, EXACT_TO[other])) continue;
        job->other = other;
        bench_subject subject = {.scene = job->scene->name,
                                 .what = EXACT_TO[other],
                                 .unit = "Mray/s",
                                 .isa = self->isa,
                                 .threads = threads,
                                 .ours = camera_exact,
                                 .peer = camera_other,
                                 .context = job,
                                 .peer_name = daft_intersection_name(other),
                                 .describe = other_describe,
                                 .own_peer = true};
        if (other == DAFT_INTERSECT_FAST) subject.budget = (bench_budget){.floor = 1 / 1.10};
        bench_measure(self, &subject);
    }
}

static void measure_scene(bench *self, const bench_scene *scene, int threads)
{
    camera_job job = {.scene = scene, .camera = bench_camera_create(self, scene, threads)};
    if (!job.camera) {
        bench_note(self, true, "out of memory");
        return;
    }
    if (self->peers) job.api = bench_find_embree();
    if (job.api) job.embree = job.api->create_scene(scene, threads);
    bench_subject subject = {.scene = scene->name,
                             .what = CAMERA,
                             .unit = "Mray/s",
                             .isa = self->isa,
                             .threads = threads,
                             .ours = camera_exact,
                             .peer = job.embree ? camera_peer : NULL,
                             .context = &job,
                             .peer_name = job.api ? job.api->name : "Embree",
                             .describe = camera_describe};
    if (bench_wants(self, scene->name, CAMERA)) bench_measure(self, &subject);
    subject.what = FAST, subject.ours = camera_fast;
    subject.budget = (bench_budget){.floor = scene->instance_count > 50000 ? 2 : 4};
    if (bench_wants(self, scene->name, FAST)) bench_measure(self, &subject);
    measure_intersections(self, &job, threads);
    if (job.api) job.api->destroy(job.embree);
    bench_camera_destroy(job.camera);
}

void bench_visibility(bench *self)
{
    const char *const what[] = {CAMERA, FAST, EXACT_TO[DAFT_INTERSECT_WATERTIGHT], EXACT_TO[DAFT_INTERSECT_FAST]};
    int threads[2], count = bench_thread_counts(self, threads);
    for (size_t i = 0; i < bench_scene_count(); i++) {
        bool wanted = false;
        for (size_t k = 0; k < DAFT_COUNT_OF(what); k++) wanted |= bench_wants(self, bench_scene_name(i), what[k]);
        bench_scene scene;
        if (!wanted || !bench_scene_make(self, i, &scene)) continue;
        for (int t = 0; t < count; t++) measure_scene(self, &scene, threads[t]);
        bench_scene_free(self, &scene);
    }
}
