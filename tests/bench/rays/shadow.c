/* Shadow rays a second. A ray is a point that a pixel sees and that faces the light; both sides get exactly the same
 * points. Ours are timed tile by tile, where the frame casts them: the sum of these times over all workers, less the
 * cost of the clock, divided by the number of workers. Embree's packets are timed as a whole, with the same points laid
 * out in blocks of 4 by 4 pixels. */
#include "shadow.h"

#include "math/simd/dispatch.h"
#include "math/trig.h"
#include "raster/raster.h"
#include "render/kernels.h"

#include <stdio.h>
#include <string.h>

enum { WIDTH = 1280, HEIGHT = 720, MESHES = 2, COWS = 1000 };
static const float FIELD_OF_VIEW = 1.0471976f; /* 60 degrees across */

typedef struct stage {
    daft_trimesh mesh[MESHES]; /* the model, and a square of ground */
    daft_bvh *bvh[MESHES];
    daft_instance instances[COWS + 1]; /* frame space: the origin is at the camera */
    uint32_t count;
    bench_view view;
    daft_light_source light;
    bool two_level;
} stage;

/* Places the camera. Call it before the first instance is added. */
static void look(stage *s, daft_vec3 from, daft_vec3 at)
{
    bench_view *v = &s->view;
    *v = (bench_view){.width = WIDTH, .height = HEIGHT, .from = from, .forward = daft_normalize(daft_sub(at, from))};
    v->right = daft_normalize(daft_cross(v->forward, daft_v3(0, 1, 0)));
    v->up = daft_cross(v->right, v->forward);
    v->focal = (float)WIDTH / 2 / tanf(FIELD_OF_VIEW / 2);
}

/* `m`: a rotation, times `scale`. */
static void add(stage *s, int mesh, const double m[9], double scale, daft_vec3 at)
{
    static const uint32_t material = 0;
    daft_instance *i = &s->instances[s->count++];
    *i = (daft_instance){
        .mesh = &s->mesh[mesh], .bvh = s->bvh[mesh], .materials = &material, .flags = DAFT_INSTANCE_CASTS_SHADOW};
    daft_vec3 t = daft_sub(at, s->view.from);
    i->to_frame = (daft_affine){.t = {t.x, t.y, t.z}};
    for (int k = 0; k < 9; k++) {
        i->to_frame.m[k] = (float)(m[k] * scale);
        i->to_object.m[k] = (float)(m[k % 3 * 3 + k / 3] / scale);
    }
    for (int k = 0; k < 3; k++)
        i->to_object.t[k] =
            -(i->to_object.m[3 * k] * t.x + i->to_object.m[3 * k + 1] * t.y + i->to_object.m[3 * k + 2] * t.z);
    daft_instance_bound(i);
}

static const double UPRIGHT[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static void light_at(stage *s, daft_vec3 at)
{
    s->light = (daft_light_source){.casts_shadow = true, .position = daft_sub(at, s->view.from), .color = {1, 1, 1}};
}

static void sun_from(stage *s, daft_vec3 to_light)
{
    s->light = (daft_light_source){
        .sun = true, .casts_shadow = true, .to_light = daft_normalize(to_light), .color = {1, 1, 1}};
}

/* The model on the ground, from in front, to the side and above. */
static void model_on_ground(stage *s, float metres)
{
    const daft_trimesh *mesh = &s->mesh[0];
    daft_vec3 at = daft_scale(daft_add(mesh->low, mesh->high), 0.5f);
    look(s, daft_add(at, daft_scale(daft_normalize(daft_v3(0.45f, 0.3f, 0.84f)), metres)), at);
    add(s, 0, UPRIGHT, 1, daft_v3(0, 0, 0));
    add(s, 1, UPRIGHT, 1, daft_v3(0, 0, 0));
}

static void point_light(stage *s, float metres) { model_on_ground(s, metres), light_at(s, daft_v3(-1.5f, 2, 1.5f)); }
static void sun(stage *s, float metres) { model_on_ground(s, metres), sun_from(s, daft_v3(0.5f, 1, 0.3f)); }
static void far_light(stage *s, float metres) { model_on_ground(s, metres), light_at(s, daft_v3(-6e3f, 8e3f, 6e3f)); }
/* A hand's breadth from the ground, before the model. */
static void low_light(stage *s, float metres) { model_on_ground(s, metres), light_at(s, daft_v3(0.5f, 0.1f, 0.9f)); }

static void thousand(stage *s, float metres)
{
    uint32_t state = 1;
    look(s, daft_v3(0.45f * metres, 0.3f * metres, 0.84f * metres), daft_v3(0, 0, 0));
    for (int i = 0; i < COWS; i++) {
        double q[4], m[9], length = 0;
        for (int k = 0; k < 4; k++) {
            state = state * 1664525 + 1013904223;
            q[k] = (double)(state >> 8) * 0x1p-23 - 1;
            length += q[k] * q[k];
        }
        for (int k = 0; k < 4; k++) q[k] /= sqrt(length);
        daft_quat_matrix((daft_quat){(float)q[0], (float)q[1], (float)q[2], (float)q[3]}, m);
        add(s, 0, m, 1,
            daft_v3((float)(i % 10) * 1.5f - 6.75f, (float)(i / 10 % 10) * 1.5f - 6.75f,
                    (float)(i / 100) * 1.5f - 6.75f));
    }
    light_at(s, daft_v3(-15, 20, 15));
    s->two_level = true;
}

/* Within a model blown up to a hall, among copies of itself, the light between them. */
static void interior(stage *s, float metres)
{
    daft_vec3 middle = daft_v3(0, 0.5f * metres, 0);
    look(s, daft_add(middle, daft_v3(-0.2f * metres, 0, 0.15f * metres)), middle);
    add(s, 0, UPRIGHT, (double)metres, daft_v3(0, 0, 0));
    for (int i = 0; i < 8; i++)
        add(s, 0, UPRIGHT, 1,
            daft_add(middle, daft_v3((float)(i % 2) * 2 - 1, (float)(i / 2 % 2) * 2 - 1.5f, (float)(i / 4) * 2 - 1)));
    light_at(s, middle);
}

typedef struct stage_kind {
    const char *name, *what;
    const char *model; /* NULL: each of FIGURES */
    void (*fill)(stage *s, float metres);
    float metres;
} stage_kind;

static const char *const FIGURES[] = {"cow", "bunny", "nefertiti"};
static const stage_kind KINDS[] = {
    {"close up", "shadows, point light", NULL, point_light, 0.7f},
    {"100 pixels tall", "shadows, point light", NULL, point_light, 11},
    {"close up", "shadows, sun", NULL, sun, 0.7f},
    {"100 pixels tall", "shadows, sun", NULL, sun, 11},
    {"light far off", "shadows, point light", "bunny", far_light, 2.2f},
    {"light near the ground", "shadows, point light", "bunny", low_light, 2.2f},
    {"thousand", "shadows, point light", "cow", thousand, 22},
    {"interior", "shadows, point light", "sphere 130k", interior, 8},
};

/* ---- ours ---- */

/* One worker's memory. */
typedef struct desk {
    daft_tile tile;
    daft_facets facets;
    daft_batch points;
    daft_ray_batch sky;
    uint32_t lit[DAFT_BATCH_WORDS];
    double ms;
    uint64_t rays, kept, dark;
} desk;

typedef struct shadow_job {
    stage *stage;
    daft_raster raster;
    daft_snapshot snapshot;
    const daft_tlas *tlas;
    const daft_raster_kernels *raster_kernels;
    const daft_render_kernels *kernels;
    const daft_sample_kernels *sample_kernels;
    const daft_shade_kernels *shade;
    desk *desks;
    uint8_t *scratch;        /* of each desk's shadows */
    shadow_origins *collect; /* receives the points, with one worker; NULL: nothing is collected */
    shadow_origins origins;
    const shadow_embree_api *api;
    bench_embree *embree;
    uint64_t peer_dark;
    double clock_cost;
    bool failed;
} shadow_job;

static uint64_t count_bits(const uint32_t *bits)
{
    uint64_t count = 0;
    for (int i = 0; i < DAFT_BATCH_WORDS; i++) count += (uint64_t)__builtin_popcount(bits[i]);
    return count;
}

static void collect_points(shadow_job *job, const desk *d)
{
    shadow_origins *to = job->collect;
    const daft_lanes3 *origin = &d->points.shadow_origin;
    for (uint32_t patch = 0; patch < 64; patch++)
        for (uint32_t i = 0; i < d->points.count; i++) {
            uint32_t pixel = d->points.pixel[i], x = pixel % DAFT_TILE, y = pixel / DAFT_TILE;
            if (y / 4 * 8 + x / 4 != patch || !(d->lit[i / 32] >> (i % 32) & 1) || to->count == to->capacity) continue;
            to->x[to->count] = origin->x[i], to->y[to->count] = origin->y[i], to->z[to->count++] = origin->z[i];
        }
}

static void bin_task(void *context, uint32_t index, uint32_t worker)
{
    shadow_job *job = context;
    daft_raster_bin(&job->raster, index, worker);
}

static void tile_task(void *context, uint32_t index, uint32_t worker)
{
    shadow_job *job = context;
    desk *d = &job->desks[worker];
    job->raster_kernels->tile(&job->raster, index, worker, NULL, &d->tile);
    const daft_surfaces_def def = {&job->snapshot, &job->raster.pencil, true, false};
    job->kernels->surfaces(&def, &d->tile, &d->facets, &d->points, &d->sky);
    uint32_t rays = job->shade->facing(&d->points, &job->stage->light, d->lit);
    if (rays == 0) return;
    if (job->collect) collect_points(job, d);
    int workers = job->raster.workers;
    const daft_sample_kernels *k = job->sample_kernels;
    double start = bench_clock_ms(workers);
    const daft_samples samples = daft_samples_of(&d->points);
    const daft_apex apex = daft_apex_of(&job->stage->light);
    d->kept += k->shadows(&samples, &apex, job->tlas, DAFT_NOTHING, d->lit, job->scratch + worker * k->scratch_size);
    d->ms += bench_clock_ms(workers) - start - job->clock_cost;
    d->rays += rays;
    d->dark += rays - count_bits(d->lit);
}

/* The cost of reading the clock: the minimum of many, so that rather too little is subtracted than too much. */
static double clock_cost(int workers)
{
    double min = INFINITY;
    for (int i = 0; i < 10000; i++) {
        double start = bench_clock_ms(workers);
        min = fmin(min, bench_clock_ms(workers) - start);
    }
    return min;
}

static bool trace(shadow_job *job)
{
    const bench_view *v = &job->stage->view;
    daft_pencil pencil = {.right = v->right,
                          .up = v->up,
                          .forward = v->forward,
                          .focal = v->focal,
                          .width = v->width,
                          .height = v->height,
                          .intersection = DAFT_INTERSECT_EXACT};
    int workers = job->raster.workers;
    for (int i = 0; i < workers; i++)
        job->desks[i].ms = 0, job->desks[i].rays = job->desks[i].kept = job->desks[i].dark = 0;
    if (!daft_raster_begin(&job->raster, &pencil, job->stage->instances, job->stage->count, NULL)) return false;
    daft_parallel_for(job->collect ? 1 : workers, job->raster.work_count, bin_task, job);
    daft_parallel_for(job->collect ? 1 : workers, (uint32_t)(job->raster.tiles_x * job->raster.tiles_y), tile_task,
                      job);
    return true;
}

static double shadow_ours(void *context)
{
    shadow_job *job = context;
    double ms = 0;
    uint64_t rays = 0;
    if (!trace(job)) return -1;
    for (int i = 0; i < job->raster.workers; i++) ms += job->desks[i].ms, rays += job->desks[i].rays;
    return (double)rays / (ms / job->raster.workers) / 1e3;
}

static double shadow_peer(void *context)
{
    shadow_job *job = context;
    double ms = job->api->occluded_ms(job->embree, &job->origins, &job->stage->light, &job->peer_dark);
    return (double)job->origins.count / ms / 1e3;
}

static void shadow_describe(void *context, char *out, size_t size)
{
    shadow_job *job = context;
    uint64_t rays = 0, kept = 0, dark = 0;
    for (int i = 0; i < job->raster.workers; i++)
        rays += job->desks[i].rays, kept += job->desks[i].kept, dark += job->desks[i].dark;
    int used = snprintf(out, size, "%llu rays, %.1f%% under a bound, %.1f%% dark", (unsigned long long)rays,
                        (double)kept * 100 / (double)rays, (double)dark * 100 / (double)rays);
    if (job->embree && used > 0 && (size_t)used < size)
        snprintf(out + used, size - (size_t)used, ", peer %+lld", (long long)(job->peer_dark - dark));
}

/* ---- both ---- */

static bool collect(bench *self, shadow_job *job)
{
    shadow_origins *o = &job->origins;
    o->capacity = WIDTH * HEIGHT;
    float **axes[3] = {&o->x, &o->y, &o->z};
    for (int k = 0; k < 3; k++)
        if (!(*axes[k] = daft_alloc_zero(&self->allocator, o->capacity + 16, sizeof(float)))) return false;
    job->collect = o;
    bool traced = trace(job);
    job->collect = NULL;
    return traced;
}

DAFT_KERNEL_DECLARE(daft_render_kernels, daft_render);

static bool open_job(bench *self, shadow_job *job, daft_arena *arena, int threads)
{
    static const daft_render_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_render);
    stage *s = job->stage;
    int isa;
    daft_isa_parse(self->isa, &isa);
    job->raster_kernels = daft_raster_kernels_for(isa), job->shade = daft_shade_kernels_for(isa),
    job->kernels = TABLE[isa], job->sample_kernels = daft_sample_kernels_for(isa);
    static const daft_surface plain = {.diffuse = {0.8f, 0.8f, 0.8f}, .texture = DAFT_NO_TEXTURE};
    job->snapshot = (daft_snapshot){.materials = &plain,
                                    .material_count = 1,
                                    .width = WIDTH,
                                    .height = HEIGHT,
                                    .right = s->view.right,
                                    .up = s->view.up,
                                    .forward = s->view.forward,
                                    .focal = s->view.focal,
                                    .instances = s->instances,
                                    .instance_count = s->count};
    job->clock_cost = clock_cost(threads);
    job->desks = daft_alloc_zero(&self->allocator, (size_t)threads, sizeof *job->desks);
    job->scratch = daft_alloc_zero(&self->allocator, (size_t)threads, job->sample_kernels->scratch_size);
    job->tlas = daft_tlas_build(arena, s->instances, s->count, NULL);
    if (!job->desks || !job->scratch || !job->tlas ||
        !daft_raster_init(&job->raster, &self->allocator, threads, isa, NULL))
        return false;
    if (!self->peers || !job->api) return true;
    job->embree = job->api->create(s->instances, s->count, s->two_level, threads);
    return collect(self, job);
}

static void close_job(bench *self, shadow_job *job)
{
    if (job->embree) job->api->destroy(job->embree);
    daft_raster_free(&job->raster);
    daft_release(&self->allocator, job->desks);
    daft_release(&self->allocator, job->scratch);
    daft_release(&self->allocator, job->origins.x);
    daft_release(&self->allocator, job->origins.y);
    daft_release(&self->allocator, job->origins.z);
}

static void measure(bench *self, stage *s, const char *scene, const char *what, int threads)
{
    shadow_job job = {.stage = s, .api = shadow_find_embree()};
    daft_arena arena;
    daft_arena_init(&arena, &self->allocator);
    bench_subject subject = {.scene = scene,
                             .what = what,
                             .unit = "Mray/s",
                             .isa = self->isa,
                             .threads = threads,
                             .ours = shadow_ours,
                             .context = &job,
                             .describe = shadow_describe,
                             .peer_name = job.api ? job.api->name : "Embree",
                             .budget = {.floor = s->two_level ? 1 : 2}};
    if (open_job(self, &job, &arena, threads)) {
        subject.peer = job.embree ? shadow_peer : NULL;
        bench_measure(self, &subject);
    } else {
        bench_note(self, true, "out of memory");
    }
    close_job(self, &job);
    daft_arena_free(&arena);
}

static bool make_meshes(bench *self, const char *model, stage *s)
{
    static const daft_vec3 corners[4] = {{-BENCH_GROUND, 0, -BENCH_GROUND},
                                         {-BENCH_GROUND, 0, BENCH_GROUND},
                                         {BENCH_GROUND, 0, BENCH_GROUND},
                                         {BENCH_GROUND, 0, -BENCH_GROUND}};
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    daft_mesh_def def = daft_default_mesh_def();
    daft_log log = {0};
    def.positions = corners, def.vertex_count = 4, def.indices = triangles, def.triangle_count = 2;
    if (!bench_model_load(self, bench_model_named(model), &s->mesh[0])) return false;
    if (!daft_trimesh_from_arrays(&self->allocator, &def, &log, &s->mesh[1], NULL)) return false;
    for (int i = 0; i < MESHES; i++) {
        s->bvh[i] = bench_tree(self, &s->mesh[i]);
        if (!s->bvh[i]) return false;
    }
    return true;
}

static void measure_stage(bench *self, const stage_kind *kind, const char *model)
{
    char scene[64];
    snprintf(scene, sizeof scene, "%s, %s", model, kind->name);
    if (!bench_wants(self, scene, kind->what)) return;
    stage *s = daft_alloc_zero(&self->allocator, 1, sizeof *s);
    if (s && make_meshes(self, model, s)) {
        kind->fill(s, kind->metres);
        int threads[2], count = bench_thread_counts(self, threads);
        for (int t = 0; t < count; t++) measure(self, s, scene, kind->what, threads[t]);
    }
    for (int i = 0; s && i < MESHES; i++) {
        if (s->bvh[i]) daft_bvh_free(s->bvh[i]);
        daft_trimesh_free(&self->allocator, &s->mesh[i]);
    }
    daft_release(&self->allocator, s);
}

void bench_shadow(bench *self)
{
    for (size_t i = 0; i < DAFT_COUNT_OF(KINDS); i++) {
        if (KINDS[i].model) measure_stage(self, &KINDS[i], KINDS[i].model);
        for (size_t f = 0; f < DAFT_COUNT_OF(FIGURES) && !KINDS[i].model; f++)
            measure_stage(self, &KINDS[i], FIGURES[f]);
    }
}
