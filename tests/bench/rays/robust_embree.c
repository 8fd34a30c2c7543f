/* Embree's single rays, in its default mode and in its robust mode, at its medium build quality. */
#include "harness/embree.h"
#include "robust.h"

#ifdef DAFT_EMBREE
#include <stdlib.h>

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
    return scene_of(self, bench_embree_triangles(self->device, mesh, NULL));
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
    struct RTCRayHit query = bench_embree_ray(ray);
    bench_embree_context with = bench_embree_begin();
    bool hit = bench_embree_single(&with, scene, false, &query);
    *t = query.ray.tfar;
    return hit;
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
