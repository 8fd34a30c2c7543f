/* Rays that share no origin, a second: from what the camera sees, bounced at random (diffuse), mirrored, and towards
 * the light; one by one, sixteen together, and as a stream. */
#include "rays.h"

#include "math/simd/dispatch.h"
#include "math/trig.h"

#include <stdio.h>
#include <string.h>

enum { WIDTH = 640, HEIGHT = 360 };

typedef enum rays_aim { AIM_DIFFUSE, AIM_MIRROR, AIM_LIGHT, AIM_COUNT } rays_aim;

static const struct {
    const char *what;
    rays_how how;
    rays_aim aim;
    bench_budget budget;
} ROWS[] = {
    {"rays, single, diffuse", RAYS_CLOSEST_SINGLE, AIM_DIFFUSE, {.floor = 0.9}},
    {"rays, stream, diffuse", RAYS_CLOSEST_STREAM, AIM_DIFFUSE, {0, 0, false}},
    {"rays, single, mirror", RAYS_CLOSEST_SINGLE, AIM_MIRROR, {0, 0, false}},
    {"rays, packet, mirror", RAYS_CLOSEST_PACKET, AIM_MIRROR, {.floor = 0.9}},
    {"rays, stream, mirror", RAYS_CLOSEST_STREAM, AIM_MIRROR, {0, 0, false}},
    {"occlusion, single", RAYS_OCCLUDED_SINGLE, AIM_DIFFUSE, {.floor = 0.9}},
    {"occlusion, packet", RAYS_OCCLUDED_PACKET, AIM_LIGHT, {0, 0, false}},
};

typedef struct rays_job {
    const bench_scene *scene;
    daft_arena arena;
    daft_instance *instances; /* frame space: the origin is at the camera */
    const daft_tlas *tlas;
    const daft_accel_kernels *kernels;
    rays_how how;
    int threads;
    uint32_t count; /* a multiple of 16 */
    daft_ray *rays;
    daft_ray_packet *packets;
    daft_hit *stream_hits;
    uint64_t hits[64]; /* one for each worker */
    const bench_embree_api *scene_api;
    const rays_embree_api *api;
    rays_embree *embree;
    uint64_t peer_hits;
} rays_job;

/* ---- the rays ---- */

static float random_unit(uint32_t *state)
{
    *state = *state * 747796405u + 2891336453u;
    uint32_t x = (*state >> ((*state >> 28) + 4) ^ *state) * 277803737u;
    return (float)((x >> 22 ^ x) >> 8) * 0x1p-24f;
}

static daft_vec3 random_direction(uint32_t *state)
{
    double y = 2 * (double)random_unit(state) - 1, around = 2 * DAFT_PI * (double)random_unit(state),
           r = sqrt(1 - y * y);
    return daft_v3((float)(r * daft_cos(around)), (float)y, (float)(r * daft_sin(around)));
}

static daft_vec3 smooth_normal(const daft_instance *instance, const daft_hit *hit)
{
    const daft_trimesh *mesh = instance->mesh;
    if (!mesh) return daft_normalize(hit->normal);
    const uint32_t *index = (mesh->normal_indices ? mesh->normal_indices : mesh->indices) + 3 * (size_t)hit->triangle;
    daft_vec3 n = daft_scale(mesh->normals[index[0]], 1 - hit->u - hit->v);
    n = daft_add(n, daft_add(daft_scale(mesh->normals[index[1]], hit->u), daft_scale(mesh->normals[index[2]], hit->v)));
    return daft_normalize(daft_affine_transposed(&instance->to_object, n));
}

/* From the point a camera's ray hit. */
static daft_ray spawn(const daft_instance *instance, const daft_ray *camera, const daft_hit *hit, rays_aim aim,
                      daft_vec3 light, uint32_t *state)
{
    daft_vec3 flat = daft_normalize(hit->normal);
    if (daft_dot(flat, camera->direction) > 0) flat = daft_neg(flat);
    daft_vec3 point = daft_add(camera->origin, daft_scale(camera->direction, hit->t));
    daft_ray ray = {.origin = daft_add(point, daft_scale(flat, 1e-4f)), .tmax = INFINITY};
    if (aim == AIM_LIGHT) {
        ray.direction = daft_sub(light, ray.origin), ray.tmax = 1;
    } else if (aim == AIM_DIFFUSE) {
        ray.direction = daft_normalize(daft_add(flat, daft_scale(random_direction(state), 0.999f)));
    } else {
        daft_vec3 n = smooth_normal(instance, hit), d = camera->direction;
        ray.direction = daft_sub(d, daft_scale(n, 2 * daft_dot(n, d)));
        if (daft_dot(ray.direction, flat) < 0) ray.direction = daft_sub(d, daft_scale(flat, 2 * daft_dot(flat, d)));
        ray.direction = daft_normalize(ray.direction);
    }
    return ray;
}

/* Pixel number i, in blocks of four by four. */
static daft_ray camera_ray(const bench_view *view, uint32_t i)
{
    uint32_t block = i / 16, x = block % (WIDTH / 4) * 4 + i % 4, y = block / (WIDTH / 4) * 4 + i / 4 % 4;
    float scale = (float)view->width / WIDTH, px = ((float)x + 0.5f) * scale - (float)view->width * 0.5f,
          py = (float)view->height * 0.5f - ((float)y + 0.5f) * scale;
    daft_vec3 d = daft_add(daft_scale(view->right, px),
                           daft_add(daft_scale(view->up, py), daft_scale(view->forward, view->focal)));
    return (daft_ray){.direction = daft_normalize(d), .tmax = INFINITY};
}

/* False: the peer is out of memory. */
static bool fill_rays(rays_job *job, rays_aim aim)
{
    uint32_t count = 0, state = 1;
    daft_vec3 eye = job->scene->view.from, light = daft_sub(job->scene->light, eye);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        daft_ray camera = camera_ray(&job->scene->view, i);
        daft_hit hit;
        if (!job->kernels->closest(job->tlas, &camera, UINT32_MAX, &hit)) continue;
        job->rays[count++] = spawn(&job->instances[hit.instance], &camera, &hit, aim, light, &state);
    }
    job->count = count / DAFT_PACKET * DAFT_PACKET;
    for (uint32_t i = 0; i < job->count; i++) daft_ray_packet_set(&job->packets[i / 16], i % 16, &job->rays[i]);
    if (!job->embree) return true;
    for (uint32_t i = 0; i < job->count; i++) job->rays[i].origin = daft_add(job->rays[i].origin, eye);
    bool loaded = job->api->load(job->embree, job->rays, job->count);
    for (uint32_t i = 0; i < job->count; i++) job->rays[i].origin = daft_sub(job->rays[i].origin, eye);
    return loaded;
}

/* ---- ours ---- */

static uint32_t count_bits(uint32_t bits) { return (uint32_t)__builtin_popcount(bits); }

static uint64_t trace_range(const rays_job *job, uint32_t first, uint32_t end)
{
    uint64_t hits = 0;
    daft_hit hit[DAFT_PACKET];
    for (uint32_t i = first; i < end && job->how == RAYS_CLOSEST_SINGLE; i++)
        hits += job->kernels->closest(job->tlas, &job->rays[i], UINT32_MAX, hit);
    for (uint32_t i = first; i < end && job->how == RAYS_OCCLUDED_SINGLE; i++)
        hits += job->kernels->occluded(job->tlas, &job->rays[i]);
    for (uint32_t i = first; i < end && job->how == RAYS_CLOSEST_PACKET; i += DAFT_PACKET)
        hits += count_bits(job->kernels->closest_packet(job->tlas, &job->packets[i / 16], 0xffff, UINT32_MAX, hit));
    for (uint32_t i = first; i < end && job->how == RAYS_OCCLUDED_PACKET; i += DAFT_PACKET)
        hits += count_bits(job->kernels->occluded_packet(job->tlas, &job->packets[i / 16], 0xffff));
    if (job->how == RAYS_CLOSEST_STREAM) {
        job->kernels->closest_stream(job->tlas, job->rays + first, end - first, UINT32_MAX, job->stream_hits + first);
        for (uint32_t i = first; i < end; i++) hits += job->stream_hits[i].instance != UINT32_MAX;
    }
    return hits;
}

static void trace_task(void *context, uint32_t index, uint32_t worker)
{
    rays_job *job = context;
    uint32_t first = index * RAYS_TASK;
    job->hits[worker] += trace_range(job, first, daft_min_u(first + RAYS_TASK, job->count));
}

static double mrays(const rays_job *job, double ms) { return (double)job->count / ms / 1e3; }

static double rays_ours(void *context)
{
    rays_job *job = context;
    memset(job->hits, 0, sizeof job->hits);
    double start = bench_clock_ms(job->threads);
    daft_parallel_for(job->threads, (job->count + RAYS_TASK - 1) / RAYS_TASK, trace_task, job);
    return mrays(job, bench_clock_ms(job->threads) - start);
}

/* Packets: the faster of its two modes, for coherent rays and for others. It has no streams: single rays. */
static double rays_peer(void *context)
{
    rays_job *job = context;
    bool packet = job->how == RAYS_CLOSEST_PACKET || job->how == RAYS_OCCLUDED_PACKET;
    rays_how how = job->how == RAYS_CLOSEST_STREAM ? RAYS_CLOSEST_SINGLE : job->how;
    double ms = job->api->trace_ms(job->embree, how, false, &job->peer_hits);
    if (packet) ms = fmin(ms, job->api->trace_ms(job->embree, how, true, &job->peer_hits));
    return mrays(job, ms);
}

static void rays_describe(void *context, char *out, size_t size)
{
    rays_job *job = context;
    uint64_t hits = 0;
    for (size_t i = 0; i < DAFT_COUNT_OF(job->hits); i++) hits += job->hits[i];
    int used = snprintf(out, size, "%u rays, %.1f%% hit", job->count, (double)hits * 100 / fmax(1, job->count));
    if (job->embree && used > 0 && (size_t)used < size)
        snprintf(out + used, size - (size_t)used, ", peer %+lld hits", (long long)(job->peer_hits - hits));
}

/* ---- all of them ---- */

static void measure_rows(bench *self, rays_job *job)
{
    for (rays_aim aim = 0; aim < AIM_COUNT; aim++) {
        bool filled = false;
        for (size_t i = 0; i < DAFT_COUNT_OF(ROWS); i++) {
            if (ROWS[i].aim != aim || !bench_wants(self, job->scene->name, ROWS[i].what)) continue;
            if (!filled && !fill_rays(job, aim)) {
                bench_note(self, true, "out of memory");
                return;
            }
            filled = true;
            job->how = ROWS[i].how;
            bench_subject subject = {.scene = job->scene->name,
                                     .what = ROWS[i].what,
                                     .unit = "Mray/s",
                                     .isa = self->isa,
                                     .threads = job->threads,
                                     .ours = rays_ours,
                                     .peer = job->embree ? rays_peer : NULL,
                                     .context = job,
                                     .peer_name = job->scene_api ? job->scene_api->name : "Embree",
                                     .describe = rays_describe,
                                     .budget = ROWS[i].budget};
            bench_measure(self, &subject);
        }
    }
}

static bool job_begin(bench *self, const bench_scene *scene, rays_job *job)
{
    const uint32_t most = WIDTH * HEIGHT;
    int isa;
    daft_isa_parse(self->isa, &isa);
    *job = (rays_job){.scene = scene, .kernels = daft_accel_kernels_for(isa)};
    daft_arena_init(&job->arena, &self->allocator);
    job->rays = daft_arena_alloc(&job->arena, most, sizeof *job->rays);
    job->packets = daft_arena_alloc(&job->arena, most / DAFT_PACKET, sizeof *job->packets);
    job->stream_hits = daft_arena_alloc(&job->arena, most, sizeof *job->stream_hits);
    job->instances = daft_arena_alloc(&job->arena, scene->instance_count, sizeof *job->instances);
    for (uint32_t i = 0; job->instances && i < scene->instance_count; i++)
        job->instances[i] = bench_engine_instance(scene, i);
    if (job->instances) job->tlas = daft_tlas_build(&job->arena, job->instances, scene->instance_count, NULL);
    return job->rays && job->packets && job->stream_hits && job->tlas;
}

static void measure_threads(bench *self, rays_job *job, int threads)
{
    bench_embree *scene = NULL;
    job->threads = threads;
    job->embree = NULL;
    if (self->peers) job->scene_api = bench_find_embree(), job->api = rays_find_embree();
    if (job->scene_api) scene = job->scene_api->create_scene(job->scene, threads);
    if (scene) job->embree = job->api->create(scene);
    measure_rows(self, job);
    if (job->embree) job->api->destroy(job->embree);
    if (scene) job->scene_api->destroy(scene);
}

/* Rays of a mesh hardly change with the distance that the camera sees it from: one is enough. */
static bool is_another_distance(const char *scene) { return strstr(scene, ", close up") || strstr(scene, ", far"); }

void bench_rays(bench *self)
{
    int threads[2], count = bench_thread_counts(self, threads);
    for (size_t i = 0; i < bench_scene_count(); i++) {
        bool wanted = false;
        if (is_another_distance(bench_scene_name(i))) continue;
        for (size_t k = 0; k < DAFT_COUNT_OF(ROWS); k++) wanted |= bench_wants(self, bench_scene_name(i), ROWS[k].what);
        bench_scene scene;
        rays_job job;
        if (!wanted || !bench_scene_make(self, i, &scene)) continue;
        if (!job_begin(self, &scene, &job)) bench_note(self, true, "out of memory"), count = 0;
        for (int t = 0; t < count; t++) measure_threads(self, &job, threads[t]);
        daft_arena_free(&job.arena);
        bench_scene_free(self, &scene);
    }
}
