/* Our camera rays, as render.c and accuracy.c measure them: the pencil's three passes around a scene's instances, and
 * the slow twin that is the oracle. Only this file and shadow.c include raster/. */
#include "harness/scenes.h"

#include "accel/accel.h"
#include "math/simd/dispatch.h"
#include "raster/raster.h"

#include <string.h>

struct bench_camera {
    daft_allocator allocator;
    const bench_scene *scene;
    int isa;
    daft_raster raster;
    const daft_raster_kernels *kernels;
    const daft_accel_kernels *accel;
    daft_instance *instances;
    daft_tile *tiles; /* one for each worker */
    uint64_t hits[64];
    daft_kdtree *kdtree[2]; /* of the scene's meshes, once they are asked for */
    uint64_t *seen;         /* where what each pixel sees is asked for */
    const daft_tlas *tlas;
};

static void bin_task(void *context, uint32_t index, uint32_t worker)
{
    bench_camera *camera = context;
    daft_raster_bin(&camera->raster, index, worker);
}

static void keep_tile(bench_camera *camera, const daft_tile *tile, uint32_t worker)
{
    uint32_t hits = 0;
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) hits += tile->instance[y * DAFT_TILE_STRIDE + x] != DAFT_NOTHING;
    camera->hits[worker] += hits;
    for (int y = 0; camera->seen && y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) {
            uint64_t instance = tile->instance[y * DAFT_TILE_STRIDE + x];
            uint32_t triangle = tile->triangle[y * DAFT_TILE_STRIDE + x];
            size_t at = (size_t)(tile->y + y) * (size_t)camera->scene->view.width + (size_t)(tile->x + x);
            camera->seen[at] = instance == DAFT_NOTHING ? BENCH_NOTHING : instance << 32 | triangle;
        }
}

static void tile_task(void *context, uint32_t index, uint32_t worker)
{
    bench_camera *camera = context;
    daft_tile *tile = &camera->tiles[worker];
    if (camera->tlas)
        daft_reference_tile(&camera->raster, camera->tlas, index, NULL, tile);
    else
        camera->kernels->tile(&camera->raster, index, worker, NULL, tile);
    keep_tile(camera, tile, worker);
}

static bool begin(bench_camera *camera, daft_intersection intersection)
{
    const bench_view *view = &camera->scene->view;
    memset(camera->hits, 0, sizeof camera->hits);
    daft_pencil pencil = {.right = view->right,
                          .up = view->up,
                          .forward = view->forward,
                          .focal = view->focal,
                          .width = view->width,
                          .height = view->height,
                          .intersection = intersection};
    if (!daft_raster_begin(&camera->raster, &pencil, camera->instances, camera->scene->instance_count, NULL))
        return false;
    daft_parallel_for(camera->raster.workers, camera->raster.work_count, bin_task, camera);
    return true;
}

double bench_camera_ms(bench_camera *camera, daft_intersection intersection)
{
    double start = bench_clock_ms(camera->raster.workers);
    if (!begin(camera, intersection)) return -1;
    daft_raster *raster = &camera->raster;
    daft_parallel_for(raster->workers, (uint32_t)(raster->tiles_x * raster->tiles_y), tile_task, camera);
    return bench_clock_ms(camera->raster.workers) - start;
}

double bench_camera_see(bench_camera *camera, daft_intersection intersection, uint64_t *seen)
{
    camera->seen = seen;
    double ms = bench_camera_ms(camera, intersection);
    camera->seen = NULL;
    return ms;
}

double bench_camera_oracle(bench_camera *camera, uint64_t *seen)
{
    daft_arena arena;
    daft_arena_init(&arena, &camera->allocator);
    double start = bench_clock_ms(camera->raster.workers);
    camera->tlas = daft_tlas_build(&arena, camera->instances, camera->scene->instance_count, NULL);
    bool good = camera->tlas && begin(camera, DAFT_INTERSECT_EXACT);
    camera->seen = seen;
    uint32_t tiles = good ? (uint32_t)(camera->raster.tiles_x * camera->raster.tiles_y) : 0;
    daft_parallel_for(camera->raster.workers, tiles, tile_task, camera);
    double ms = bench_clock_ms(camera->raster.workers) - start;
    camera->seen = NULL;
    camera->tlas = NULL;
    daft_arena_free(&arena);
    return good ? ms : -1;
}

static void trace_row(void *context, uint32_t row, uint32_t worker)
{
    bench_camera *camera = context;
    const bench_view *view = &camera->scene->view;
    uint64_t *seen = camera->seen + (size_t)row * (size_t)view->width;
    (void)worker;
    for (int x = 0; x < view->width; x++) {
        float dx = (float)x + 0.5f - (float)view->width * 0.5f, dy = (float)view->height * 0.5f - (float)row - 0.5f;
        daft_ray ray = {.tmax = INFINITY};
        ray.direction = daft_add(daft_add(daft_scale(view->right, dx), daft_scale(view->up, dy)),
                                 daft_scale(view->forward, view->focal));
        daft_hit hit;
        bool met = camera->accel->closest(camera->tlas, &ray, UINT32_MAX, &hit);
        bool sphere = met && !camera->instances[hit.instance].mesh;
        seen[x] = met ? (uint64_t)hit.instance << 32 | (sphere ? 0 : hit.triangle) : BENCH_NOTHING;
    }
}

/* Instances of meshes get, or lose, their kd-trees. */
static bool choose_trees(bench_camera *camera, bool kdtree)
{
    const bench_scene *scene = camera->scene;
    for (int i = 0; kdtree && i < scene->mesh_count; i++) {
        if (!camera->kdtree[i])
            camera->kdtree[i] = daft_kdtree_build(&camera->allocator, &scene->mesh[i], daft_processor_count(), NULL);
        if (!camera->kdtree[i]) return false;
    }
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        int mesh = scene->instances[i].mesh;
        camera->instances[i].kdtree = kdtree && mesh != BENCH_SPHERE ? camera->kdtree[mesh] : NULL;
    }
    return true;
}

double bench_camera_trees(bench_camera *camera, bool kdtree, daft_intersection intersection, uint64_t *seen)
{
    if (!choose_trees(camera, kdtree)) return -1;
    daft_arena arena;
    daft_arena_init(&arena, &camera->allocator);
    double start = bench_clock_ms(camera->raster.workers);
    const daft_tlas_def def = {intersection, camera->raster.workers, camera->isa};
    camera->tlas = daft_tlas_build_for(&arena, camera->instances, camera->scene->instance_count, &def, NULL);
    bool good = camera->tlas != NULL;
    camera->seen = seen;
    if (good) daft_parallel_for(camera->raster.workers, (uint32_t)camera->scene->view.height, trace_row, camera);
    double ms = bench_clock_ms(camera->raster.workers) - start;
    camera->seen = NULL;
    camera->tlas = NULL;
    daft_arena_free(&arena);
    return good ? ms : -1;
}

bench_camera_counts bench_camera_counted(const bench_camera *camera)
{
    bench_camera_counts counts = {0};
    for (size_t i = 0; i < DAFT_COUNT_OF(camera->hits); i++) counts.hits += camera->hits[i];
    for (int i = 0; i < camera->raster.workers; i++) {
        counts.triangles_tested += camera->raster.bins[i].tested;
        counts.exact_edges += camera->raster.bins[i].exact_edges;
    }
    return counts;
}

bench_camera *bench_camera_create(bench *self, const bench_scene *scene, int threads)
{
    int isa;
    daft_isa_parse(self->isa, &isa);
    bench_camera *camera = daft_alloc_zero(&self->allocator, 1, sizeof *camera);
    if (!camera) return NULL;
    camera->allocator = self->allocator;
    camera->scene = scene;
    camera->isa = isa;
    camera->accel = daft_accel_kernels_for(isa);
    camera->kernels = daft_raster_kernels_for(isa);
    camera->tiles = daft_alloc(&self->allocator, (size_t)threads, sizeof *camera->tiles);
    camera->instances = daft_alloc(&self->allocator, scene->instance_count, sizeof *camera->instances);
    if (!camera->tiles || !camera->instances ||
        !daft_raster_init(&camera->raster, &camera->allocator, threads, isa, NULL)) {
        bench_camera_destroy(camera);
        return NULL;
    }
    for (uint32_t i = 0; i < scene->instance_count; i++) camera->instances[i] = bench_engine_instance(scene, i);
    return camera;
}

void bench_camera_destroy(bench_camera *camera)
{
    if (!camera) return;
    daft_allocator allocator = camera->allocator;
    for (int i = 0; i < 2; i++)
        if (camera->kdtree[i]) daft_kdtree_free(camera->kdtree[i]);
    daft_raster_free(&camera->raster);
    daft_release(&allocator, camera->tiles);
    daft_release(&allocator, camera->instances);
    daft_release(&allocator, camera);
}
