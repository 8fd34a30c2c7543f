/* Camera rays a second, and whole frames: a mesh of 1 m on a ground plane, seen from 2.2 m, and so close that it fills the
 * picture. Camera rays are timed on the wall clock around the pencil's three passes, as Embree's are around its packets. */
#include "bench.h"

#include "math/isa.h"
#include "raster/raster.h"

#include <stdio.h>
#include <string.h>

enum { WIDTH = 1280, HEIGHT = 720 };
static const float FIELD_OF_VIEW = 1.0471976f; /* 60 degrees across */
static const daft_vec3 GROUND[4] = {{-BENCH_GROUND, 0, -BENCH_GROUND},
                                    {-BENCH_GROUND, 0, BENCH_GROUND},
                                    {BENCH_GROUND, 0, BENCH_GROUND},
                                    {BENCH_GROUND, 0, -BENCH_GROUND}};
static const uint32_t GROUND_INDICES[6] = {0, 1, 2, 0, 2, 3};

typedef struct distance {
    const char *name;
    float metres; /* from the middle of the mesh */
} distance;
static const distance DISTANCES[] = {{"far", 2.2f}, {"close up", 0.7f}};

static daft_mesh_def ground_def(void)
{
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = GROUND, def.vertex_count = 4;
    def.indices = GROUND_INDICES, def.triangle_count = 2;
    return def;
}

/* From in front, to the side and above. */
static daft_vec3 eye_of(const daft_trimesh *mesh, float metres, daft_vec3 *at)
{
    *at = daft_scale(daft_add(mesh->low, mesh->high), 0.5f);
    return daft_add(*at, daft_scale(daft_normalize(daft_v3(0.45f, 0.3f, 0.84f)), metres));
}

static bench_view view_of(const daft_trimesh *mesh, float metres)
{
    daft_vec3 at;
    bench_view view = {.width = WIDTH, .height = HEIGHT, .from = eye_of(mesh, metres, &at)};
    view.forward = daft_normalize(daft_sub(at, view.from));
    view.right = daft_normalize(daft_cross(view.forward, daft_v3(0, 1, 0)));
    view.up = daft_cross(view.right, view.forward);
    view.focal = (float)WIDTH / 2 / tanf(FIELD_OF_VIEW / 2);
    return view;
}

/* ---- camera rays ---- */

typedef struct camera_job {
    const bench_view *view;
    daft_raster raster;
    const daft_raster_kernels *kernels;
    daft_instance instances[2]; /* frame space: the origin is at the camera */
    daft_tile *tiles;           /* one for each worker */
    uint64_t hits[64], peer_hits;
    daft_intersection other; /* what the exact test is compared with */
    uint32_t *seen;          /* which triangle each pixel sees, where it is asked for */
    const bench_embree_api *api;
    bench_embree *embree;
} camera_job;

static void bin_task(void *context, uint32_t index, uint32_t worker)
{
    camera_job *job = context;
    job->kernels->bin(&job->raster, index, worker);
}

static void tile_task(void *context, uint32_t index, uint32_t worker)
{
    camera_job *job = context;
    daft_tile *tile = &job->tiles[worker];
    job->kernels->tile(&job->raster, index, worker, tile);
    uint64_t hits = 0;
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) {
            uint32_t instance = tile->instance[y * DAFT_TILE_STRIDE + x], triangle = tile->triangle[y * DAFT_TILE_STRIDE + x];
            hits += instance != DAFT_NOTHING;
            if (job->seen) job->seen[(tile->y + y) * WIDTH + tile->x + x] = instance == DAFT_NOTHING ? instance : 2 * triangle + instance;
        }
    job->hits[worker] += hits;
}

static double mrays(double ms) { return WIDTH * HEIGHT / ms / 1e3; }

static double camera_rays(camera_job *job, daft_intersection intersection)
{
    const bench_view *view = job->view;
    memset(job->hits, 0, sizeof job->hits);
    double start = daft_clock_ms();
    daft_pencil pencil = {.right = view->right, .up = view->up, .forward = view->forward,
                          .focal = view->focal, .width = view->width, .height = view->height, .intersection = intersection};
    if (!daft_raster_begin(&job->raster, &pencil, job->instances, 2, NULL)) return -1;
    daft_parallel_for(job->raster.workers, (uint32_t)job->raster.work_count, bin_task, job);
    daft_parallel_for(job->raster.workers, (uint32_t)(job->raster.tiles_x * job->raster.tiles_y), tile_task, job);
    return mrays(daft_clock_ms() - start);
}

static double camera_ours(void *context) { return camera_rays(context, DAFT_INTERSECT_EXACT); }

static double camera_other(void *context)
{
    camera_job *job = context;
    return camera_rays(job, job->other);
}

static double camera_peer(void *context)
{
    camera_job *job = context;
    return mrays(job->api->camera_ms(job->embree, job->view, &job->peer_hits));
}

static void camera_describe(void *context, char *out, size_t size)
{
    camera_job *job = context;
    uint64_t hits = 0, tested = 0, exact = 0;
    for (size_t i = 0; i < DAFT_COUNT_OF(job->hits); i++) hits += job->hits[i];
    for (int i = 0; i < job->raster.workers; i++)
        tested += job->raster.bins[i].tested, exact += job->raster.bins[i].exact_edges;
    int used = snprintf(out, size, "%.1f%% hit, %llu triangles tested, %llu exact edges", (double)hits * 100 / (WIDTH * HEIGHT),
                        (unsigned long long)tested, (unsigned long long)exact);
    if (job->embree && used > 0 && (size_t)used < size)
        snprintf(out + used, size - (size_t)used, ", peer %+lld hits", (long long)(job->peer_hits - hits));
}

/* What the other way gets wrong, against the exact one. */
static void other_describe(void *context, char *out, size_t size)
{
    camera_job *job = context;
    const daft_allocator allocator = daft_malloc_allocator();
    uint32_t *ids[2] = {daft_alloc(&allocator, WIDTH * HEIGHT, 4), daft_alloc(&allocator, WIDTH * HEIGHT, 4)};
    uint32_t wrong = 0, holes = 0;
    for (int i = 0; i < 2 && ids[0] && ids[1]; i++) {
        job->seen = ids[i];
        camera_rays(job, i ? job->other : DAFT_INTERSECT_EXACT);
    }
    for (int i = 0; ids[0] && ids[1] && i < WIDTH * HEIGHT; i++) {
        wrong += ids[0][i] != ids[1][i];
        holes += ids[0][i] != DAFT_NOTHING && ids[1][i] == DAFT_NOTHING;
    }
    job->seen = NULL;
    snprintf(out, size, "%s: %u pixels wrong, %u of them holes", daft_intersection_name(job->other), wrong, holes);
    daft_release(&allocator, ids[0]);
    daft_release(&allocator, ids[1]);
}

static daft_instance instance_of(const daft_trimesh *mesh, const daft_bvh *bvh, daft_vec3 eye)
{
    static const uint32_t material = 0;
    daft_instance instance = {.mesh = mesh, .bvh = bvh, .materials = &material};
    instance.to_frame = (daft_affine){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-eye.x, -eye.y, -eye.z}};
    instance.to_object = (daft_affine){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {eye.x, eye.y, eye.z}};
    daft_instance_bound(&instance);
    return instance;
}

/* The price of exactness: a ratio of 0.95 says that the exact test runs at 95 % of the other's speed. */
static void measure_intersections(bench *self, const char *scene, camera_job *job)
{
    static const char *const WHAT[] = {[DAFT_INTERSECT_WATERTIGHT] = "intersection, exact to watertight",
                                       [DAFT_INTERSECT_FAST] = "intersection, exact to fast"};
    for (daft_intersection other = DAFT_INTERSECT_WATERTIGHT; other <= DAFT_INTERSECT_FAST; other++) {
        if (!bench_wants(self, scene, WHAT[other])) continue;
        job->other = other;
        bench_subject subject = {.scene = scene, .what = WHAT[other], .unit = "Mray/s", .isa = self->isa,
                                 .threads = job->raster.workers, .ours = camera_ours, .peer = camera_other, .context = job,
                                 .peer_name = daft_intersection_name(other), .describe = other_describe};
        bench_measure(self, &subject);
    }
}

static void measure_camera(bench *self, const char *scene, const bench_view *view, const daft_trimesh *mesh[2],
                           const daft_bvh *bvh[2], int threads)
{
    const bench_embree_api *api = self->peers ? bench_find_embree() : NULL;
    int isa;
    daft_isa_parse(self->isa, &isa);
    camera_job job = {.view = view, .kernels = daft_raster_kernels_for(isa), .api = api};
    for (int i = 0; i < 2; i++) job.instances[i] = instance_of(mesh[i], bvh[i], view->from);
    job.tiles = daft_alloc(&self->allocator, (size_t)threads, sizeof *job.tiles);
    if (!job.tiles || !daft_raster_init(&job.raster, &self->allocator, threads, NULL)) {
        bench_note(self, true, "out of memory");
    } else {
        if (api) job.embree = api->create(mesh[0], true, threads);
        bench_subject subject = {.scene = scene, .what = "camera rays", .unit = "Mray/s", .isa = self->isa,
                                 .threads = threads, .ours = camera_ours, .peer = job.embree ? camera_peer : NULL,
                                 .context = &job, .peer_name = api ? api->name : "Embree", .describe = camera_describe};
        if (bench_wants(self, scene, "camera rays")) bench_measure(self, &subject);
        measure_intersections(self, scene, &job);
        if (api) api->destroy(job.embree);
    }
    daft_raster_free(&job.raster);
    daft_release(&self->allocator, job.tiles);
}

/* ---- whole frames, through the public API ---- */

typedef struct frame_job {
    daft_scene *scene;
    daft_image *image;
    daft_view view;
} frame_job;

static double frame_ours(void *context)
{
    frame_job *job = context;
    double start = daft_clock_ms();
    if (!daft_render(job->scene, &job->view, job->image, NULL)) return -1;
    return daft_clock_ms() - start;
}

static void frame_describe(void *context, char *out, size_t size)
{
    frame_job *job = context;
    const daft_counters *c = daft_scene_counters(job->scene);
    snprintf(out, size, "%llu shadow rays, visibility %.2f, shadow %.2f, lighting %.2f ms",
             (unsigned long long)c->shadow_rays, c->effects[DAFT_EFFECT_VISIBILITY].ms, c->effects[DAFT_EFFECT_SHADOW].ms,
             c->effects[DAFT_EFFECT_LIGHTING].ms);
}

static bool add_mesh(daft_scene *scene, const daft_mesh_def *def, daft_error *error)
{
    daft_entity_def entity = daft_default_entity_def();
    entity.shape = DAFT_SHAPE_MESH;
    entity.mesh = daft_mesh_create(scene, def, error);
    return entity.mesh.id && daft_entity_create(scene, &entity, error).id;
}

/* A sun, and a point light to the side of the camera. */
static bool fill_scene(bench *self, daft_scene *scene, const daft_trimesh *mesh, daft_error *error)
{
    daft_mesh_def ground = ground_def(), def = daft_default_mesh_def();
    daft_vec3 *positions = bench_positions(self, mesh);
    if (!positions) return false;
    def.positions = positions, def.vertex_count = mesh->vertex_count;
    def.indices = mesh->indices, def.triangle_count = mesh->triangle_count;
    bool filled = add_mesh(scene, &def, error) && add_mesh(scene, &ground, error);
    daft_release(&self->allocator, positions);
    daft_light_def sun = daft_default_light_def(), point = sun;
    sun.kind = DAFT_LIGHT_SUN, sun.direction = daft_v3(-0.5f, -1, -0.3f), sun.color = daft_v3(0.6f, 0.6f, 0.5f);
    point.position = daft_dv3(-1.5, 2, 1.5), point.color = daft_v3(0.4f, 0.4f, 0.5f);
    return filled && daft_light_create(scene, &sun, error).id && daft_light_create(scene, &point, error).id;
}

static void measure_frame(bench *self, const char *scene, const daft_trimesh *mesh, float metres, int threads)
{
    daft_error error = {0};
    char text[1200];
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads, def.isa = self->isa;
    daft_engine *engine = daft_engine_create(&def, &error);
    frame_job job = {.view = daft_default_view()};
    if (engine) job.scene = daft_scene_create(engine, &error);
    if (job.scene) job.image = daft_image_create(engine, WIDTH, HEIGHT, &error);
    daft_vec3 at, from = eye_of(mesh, metres, &at);
    job.view.camera = daft_camera_look_at(daft_to_double(from), daft_to_double(at), FIELD_OF_VIEW);
    if (job.image && fill_scene(self, job.scene, mesh, &error)) {
        bench_subject subject = {.scene = scene, .what = "frame, sun and point light", .unit = "ms", .isa = self->isa,
                                 .threads = threads, .ours = frame_ours, .context = &job, .describe = frame_describe};
        bench_measure(self, &subject);
    } else {
        bench_note(self, true, "%s: %s", scene, daft_error_text(&error, text, sizeof text));
    }
    daft_image_destroy(job.image);
    if (job.scene) daft_scene_destroy(job.scene);
    daft_engine_destroy(engine);
}

/* ---- all of them ---- */

static void measure_model(bench *self, const bench_model *model, const bool wanted[2][2])
{
    daft_trimesh mesh, ground;
    daft_mesh_def def = ground_def();
    daft_log log = {0};
    if (!bench_model_load(self, model, &mesh)) return;
    if (!daft_trimesh_from_arrays(&self->allocator, &def, &log, &ground, NULL)) {
        daft_trimesh_free(&self->allocator, &mesh);
        return;
    }
    int threads[2], all = daft_processor_count(), count = bench_thread_counts(self, threads);
    daft_bvh *bvh[2] = {daft_bvh_build_mesh(&self->allocator, &mesh, all, NULL),
                        daft_bvh_build_mesh(&self->allocator, &ground, all, NULL)};
    for (size_t d = 0; d < 2 && bvh[0] && bvh[1]; d++) {
        char scene[64];
        snprintf(scene, sizeof scene, "%s, %s", model->name, DISTANCES[d].name);
        bench_view view = view_of(&mesh, DISTANCES[d].metres);
        for (int t = 0; t < count; t++) {
            if (wanted[d][0])
                measure_camera(self, scene, &view, (const daft_trimesh *[]){&mesh, &ground},
                               (const daft_bvh *[]){bvh[0], bvh[1]}, threads[t]);
            if (wanted[d][1]) measure_frame(self, scene, &mesh, DISTANCES[d].metres, threads[t]);
        }
    }
    for (int i = 0; i < 2; i++)
        if (bvh[i]) daft_bvh_free(bvh[i]);
    daft_trimesh_free(&self->allocator, &mesh);
    daft_trimesh_free(&self->allocator, &ground);
}

void bench_render(bench *self)
{
    for (size_t i = 0; i < BENCH_MODEL_COUNT; i++) {
        bool wanted[2][2], any = false;
        for (size_t d = 0; d < 2; d++) {
            char scene[64];
            snprintf(scene, sizeof scene, "%s, %s", BENCH_MODELS[i].name, DISTANCES[d].name);
            wanted[d][0] = bench_wants(self, scene, "camera rays") || bench_wants(self, scene, "intersection, exact to watertight") ||
                           bench_wants(self, scene, "intersection, exact to fast");
            wanted[d][1] = bench_wants(self, scene, "frame, sun and point light");
            any |= wanted[d][0] || wanted[d][1];
        }
        if (any) measure_model(self, &BENCH_MODELS[i], wanted);
    }
}
