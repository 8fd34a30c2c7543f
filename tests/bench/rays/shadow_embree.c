/* Shadow rays through Embree: packets of 16, marked coherent except for scenes of instances, in which 3.13 hangs. */
#include "shadow.h"

#ifdef DAFT_EMBREE
#if DAFT_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESHES = 4, CHUNK = 4096 }; /* different meshes in a scene; rays in a task */

struct shadow_embree {
    RTCDevice device;
    RTCScene scene, parts[MESHES];
    bool coherent;
    int threads;
};

static RTCGeometry mesh_geometry(RTCDevice device, const daft_trimesh *mesh, const daft_affine *map)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *at = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                        mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        daft_vec3 p = daft_v3(mesh->x[i], mesh->y[i], mesh->z[i]);
        if (map) p = daft_affine_point(map, p);
        at[3 * i] = p.x, at[3 * i + 1] = p.y, at[3 * i + 2] = p.z;
    }
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                                   mesh->triangle_count),
           mesh->indices, (size_t)mesh->triangle_count * 3 * sizeof(uint32_t));
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
    return geometry;
}

static void attach(RTCScene scene, RTCGeometry geometry)
{
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
}

static RTCScene new_scene(RTCDevice device)
{
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    return scene;
}

static void add_instances(shadow_embree *self, const daft_instance *instances, uint32_t count)
{
    const daft_trimesh *meshes[MESHES] = {NULL};
    for (uint32_t i = 0; i < count; i++) {
        int part = 0;
        while (part < MESHES - 1 && meshes[part] && meshes[part] != instances[i].mesh) part++;
        if (!meshes[part]) {
            meshes[part] = instances[i].mesh;
            self->parts[part] = new_scene(self->device);
            attach(self->parts[part], mesh_geometry(self->device, meshes[part], NULL));
            rtcCommitScene(self->parts[part]);
        }
        const float *m = instances[i].to_frame.m, *t = instances[i].to_frame.t;
        const float rows[12] = {m[0], m[1], m[2], t[0], m[3], m[4], m[5], t[1], m[6], m[7], m[8], t[2]};
        RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, self->parts[part]);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
        attach(self->scene, geometry);
    }
}

static void destroy(shadow_embree *self)
{
    if (!self) return;
    rtcReleaseScene(self->scene);
    for (int i = 0; i < MESHES; i++)
        if (self->parts[i]) rtcReleaseScene(self->parts[i]);
    rtcReleaseDevice(self->device);
    free(self);
}

static shadow_embree *create(const daft_instance *instances, uint32_t count, bool two_level, int threads)
{
    char options[64];
    snprintf(options, sizeof options, "threads=%d", threads);
    shadow_embree *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->device = rtcNewDevice(options);
    if (!self->device) return free(self), NULL;
    self->threads = threads, self->coherent = !two_level;
    self->scene = new_scene(self->device);
    if (two_level) add_instances(self, instances, count);
    for (uint32_t i = 0; i < count && !two_level; i++)
        attach(self->scene, mesh_geometry(self->device, instances[i].mesh, &instances[i].to_frame));
    rtcCommitScene(self->scene);
    return self;
}

typedef struct ray_job {
    const shadow_embree *self;
    const shadow_origins *from;
    const daft_light_source *light;
    uint64_t dark[64]; /* one for each worker */
} ray_job;

static void set_rays(const ray_job *job, size_t first, int *valid, struct RTCRay16 *packet)
{
    const shadow_origins *from = job->from;
    const daft_light_source *light = job->light;
    for (size_t i = 0; i < 16; i++) {
        float x = from->x[first + i], y = from->y[first + i], z = from->z[first + i];
        valid[i] = first + i < from->count ? -1 : 0;
        packet->org_x[i] = x, packet->org_y[i] = y, packet->org_z[i] = z;
        packet->dir_x[i] = light->sun ? light->to_light.x : light->position.x - x;
        packet->dir_y[i] = light->sun ? light->to_light.y : light->position.y - y;
        packet->dir_z[i] = light->sun ? light->to_light.z : light->position.z - z;
        packet->tnear[i] = 0, packet->tfar[i] = light->sun ? INFINITY : 1, packet->time[i] = 0;
        packet->mask[i] = UINT32_MAX, packet->id[i] = 0, packet->flags[i] = 0;
    }
}

static void trace_chunk(void *context, uint32_t chunk, uint32_t worker)
{
    ray_job *job = context;
    int valid[16] __attribute__((aligned(64)));
    struct RTCRay16 packet __attribute__((aligned(64)));
#if DAFT_EMBREE == 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.flags = job->self->coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
#else
    struct RTCIntersectContext arguments;
    rtcInitIntersectContext(&arguments);
    arguments.flags = job->self->coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
#endif
    size_t first = (size_t)chunk * CHUNK, end = first + CHUNK < job->from->count ? first + CHUNK : job->from->count;
    uint64_t dark = 0;
    for (size_t at = first; at < end; at += 16) {
        set_rays(job, at, valid, &packet);
#if DAFT_EMBREE == 4
        rtcOccluded16(valid, job->self->scene, &packet, &arguments);
#else
        rtcOccluded16(valid, job->self->scene, &arguments, &packet);
#endif
        for (int i = 0; i < 16; i++) dark += valid[i] && packet.tfar[i] < 0;
    }
    job->dark[worker] += dark;
}

static double occluded_ms(shadow_embree *self, const shadow_origins *from, const daft_light_source *light,
                          uint64_t *dark)
{
    ray_job job = {.self = self, .from = from, .light = light};
    double start = bench_clock_ms(self->threads);
    daft_parallel_for(self->threads, (uint32_t)((from->count + CHUNK - 1) / CHUNK), trace_chunk, &job);
    double ms = bench_clock_ms(self->threads) - start;
    *dark = 0;
    for (size_t i = 0; i < DAFT_COUNT_OF(job.dark); i++) *dark += job.dark[i];
    return ms;
}

static const shadow_embree_api API = {"Embree " RTC_VERSION_STRING, create, destroy, occluded_ms};

const shadow_embree_api *shadow_find_embree(void) { return &API; }
#else
const shadow_embree_api *shadow_find_embree(void) { return NULL; }
#endif
