/* Embree on the same work: medium build quality, coherent packets of 16 rays, the same threads. */
#include "bench.h"

#ifdef DAFT_EMBREE
#if DAFT_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct bench_embree {
    RTCDevice device;
    RTCScene scene;
    const daft_trimesh *mesh;
    bool ground;
    int threads;
};

static void add_mesh(bench_embree *self)
{
    const daft_trimesh *mesh = self->mesh;
    RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                               mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        positions[3 * i] = mesh->x[i];
        positions[3 * i + 1] = mesh->y[i];
        positions[3 * i + 2] = mesh->z[i];
    }
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                                            mesh->triangle_count);
    memcpy(indices, mesh->indices, (size_t)mesh->triangle_count * 3 * sizeof(uint32_t));
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(self->scene, geometry);
    rtcReleaseGeometry(geometry);
}

static void add_ground(bench_embree *self)
{
    static const float corners[12] = {-BENCH_GROUND, 0, -BENCH_GROUND, -BENCH_GROUND, 0, BENCH_GROUND,
                                      BENCH_GROUND,  0, BENCH_GROUND,  BENCH_GROUND,  0, -BENCH_GROUND};
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4), corners,
           sizeof corners);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), 2),
           triangles, sizeof triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(self->scene, geometry);
    rtcReleaseGeometry(geometry);
}

static void make_scene(bench_embree *self)
{
    self->scene = rtcNewScene(self->device);
    rtcSetSceneBuildQuality(self->scene, RTC_BUILD_QUALITY_MEDIUM);
    add_mesh(self);
    if (self->ground) add_ground(self);
}

static bench_embree *create(const daft_trimesh *mesh, bool ground, int threads)
{
    char options[64];
    snprintf(options, sizeof options, "threads=%d", threads);
    bench_embree *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->device = rtcNewDevice(options);
    if (!self->device) return free(self), NULL;
    self->mesh = mesh;
    self->ground = ground;
    self->threads = threads;
    make_scene(self);
    rtcCommitScene(self->scene);
    return self;
}

static void destroy(bench_embree *self)
{
    if (!self) return;
    rtcReleaseScene(self->scene);
    rtcReleaseDevice(self->device);
    free(self);
}

static double build_ms(bench_embree *self)
{
    rtcReleaseScene(self->scene);
    make_scene(self);
    double start = daft_clock_ms();
    rtcCommitScene(self->scene);
    return daft_clock_ms() - start;
}

/* A task is a row of tiles of 4 by 4 rays. */
typedef struct camera_job {
    const bench_embree *self;
    const bench_view *view;
    uint64_t hits[64]; /* one for each worker */
} camera_job;

static void set_rays(const bench_view *view, int x0, int y0, struct RTCRayHit16 *packet)
{
    for (int i = 0; i < 16; i++) {
        float x = (float)(x0 + i % 4) + 0.5f - (float)view->width * 0.5f;
        float y = (float)view->height * 0.5f - (float)(y0 + i / 4) - 0.5f;
        daft_vec3 d = daft_add(daft_add(daft_scale(view->right, x), daft_scale(view->up, y)),
                               daft_scale(view->forward, view->focal));
        packet->ray.org_x[i] = view->from.x, packet->ray.org_y[i] = view->from.y, packet->ray.org_z[i] = view->from.z;
        packet->ray.dir_x[i] = d.x, packet->ray.dir_y[i] = d.y, packet->ray.dir_z[i] = d.z;
        packet->ray.tnear[i] = 0, packet->ray.tfar[i] = INFINITY, packet->ray.time[i] = 0;
        packet->ray.mask[i] = UINT32_MAX, packet->ray.id[i] = 0, packet->ray.flags[i] = 0;
        packet->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, packet->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
}

static void trace_row(void *context, uint32_t row, uint32_t worker)
{
    camera_job *job = context;
    static const int valid[16] __attribute__((aligned(64))) = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                               -1, -1, -1, -1, -1, -1, -1, -1};
    struct RTCRayHit16 packet __attribute__((aligned(64)));
#if DAFT_EMBREE == 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
#else
    struct RTCIntersectContext arguments;
    rtcInitIntersectContext(&arguments);
    arguments.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
#endif
    uint64_t hits = 0;
    for (int x = 0; x < job->view->width; x += 4) {
        set_rays(job->view, x, (int)row * 4, &packet);
#if DAFT_EMBREE == 4
        rtcIntersect16(valid, job->self->scene, &packet, &arguments);
#else
        rtcIntersect16(valid, job->self->scene, &arguments, &packet);
#endif
        for (int i = 0; i < 16; i++) hits += packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    }
    job->hits[worker] += hits;
}

/* Width and height: multiples of four. */
static double camera_ms(bench_embree *self, const bench_view *view, uint64_t *hits)
{
    camera_job job = {.self = self, .view = view};
    double start = daft_clock_ms();
    daft_parallel_for(self->threads, (uint32_t)view->height / 4, trace_row, &job);
    double ms = daft_clock_ms() - start;
    *hits = 0;
    for (size_t i = 0; i < DAFT_COUNT_OF(job.hits); i++) *hits += job.hits[i];
    return ms;
}

static const bench_embree_api API = {"Embree " RTC_VERSION_STRING, create, destroy, build_ms, camera_ms};

const bench_embree_api *bench_find_embree(void) { return &API; }
#else
const bench_embree_api *bench_find_embree(void) { return NULL; }
#endif
