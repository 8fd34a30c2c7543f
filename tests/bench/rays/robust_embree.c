/* Embree's single rays, in its default mode and in its robust mode, at its medium build quality. */
#include "robust.h"

#ifdef DAFT_EMBREE
#if DAFT_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <stdlib.h>
#include <string.h>

typedef struct embree {
    RTCDevice device;
    bool robust;
} embree;

static RTCScene scene_of(const embree *self, RTCGeometry geometry)
{
    RTCScene scene = rtcNewScene(self->device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(scene, self->robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
}

static void *mesh_scene(void *context, const daft_trimesh *mesh)
{
    const embree *self = context;
    RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                               3 * sizeof(float), mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        positions[3 * i] = mesh->x[i], positions[3 * i + 1] = mesh->y[i], positions[3 * i + 2] = mesh->z[i];
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                                            mesh->triangle_count);
    memcpy(indices, mesh->indices, (size_t)mesh->triangle_count * 3 * sizeof(uint32_t));
    return scene_of(self, geometry);
}

static void *sphere_scene(void *context, daft_vec3 centre, float radius)
{
    const embree *self = context;
    RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    float *at = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), 1);
    at[0] = centre.x, at[1] = centre.y, at[2] = centre.z, at[3] = radius;
    return scene_of(self, geometry);
}

static void drop(void *scene) { rtcReleaseScene(scene); }

static bool closest(void *scene, const daft_ray *ray, float *t)
{
    struct RTCRayHit query = {0};
    query.ray.org_x = ray->origin.x, query.ray.org_y = ray->origin.y, query.ray.org_z = ray->origin.z;
    query.ray.dir_x = ray->direction.x, query.ray.dir_y = ray->direction.y, query.ray.dir_z = ray->direction.z;
    query.ray.tnear = ray->tmin, query.ray.tfar = ray->tmax, query.ray.mask = UINT32_MAX;
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if DAFT_EMBREE == 4
    rtcIntersect1(scene, &query, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &query);
#endif
    *t = query.ray.tfar;
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

static void close_device(void *context)
{
    embree *self = context;
    rtcReleaseDevice(self->device);
    free(self);
}

bool robust_open_embree(bool robust, robust_tracer *out)
{
    embree *self = calloc(1, sizeof *self);
    if (self) self->device = rtcNewDevice("threads=1"), self->robust = robust;
    if (!self || !self->device) return free(self), false;
    *out = (robust_tracer){.self = self,
                           .mesh = mesh_scene,
                           .sphere = sphere_scene,
                           .drop = drop,
                           .closest = closest,
                           .close = close_device};
    out->name = robust ? "Embree " RTC_VERSION_STRING " robust" : "Embree " RTC_VERSION_STRING " fast";
    return true;
}
#else
bool robust_open_embree(bool robust, robust_tracer *out)
{
    (void)robust, (void)out;
    return false;
}
#endif
