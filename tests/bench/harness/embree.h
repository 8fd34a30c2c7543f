/* Shared by the files that call Embree. */
#ifndef DAFT_BENCH_EMBREE_H
#define DAFT_BENCH_EMBREE_H

#include "scenes.h"

#ifdef DAFT_EMBREE
#if DAFT_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

struct bench_embree {
    RTCDevice device;
    RTCScene scene;
    RTCScene meshes[2]; /* those that instances are of; NULL: none */
    const daft_trimesh *mesh;
    bool ground;
    int threads;
    bool instanced;
    uint32_t first_sphere; /* which item the first sphere is: spheres are one geometry with this number */
};

static inline struct RTCRayHit16 *bench_embree_rays(const bench_view *view, int x0, int y0, struct RTCRayHit16 *packet)
{
    for (int i = 0; i < 16; i++) {
        float x = (float)(x0 + i % 4) + 0.5f - (float)view->width * 0.5f;
        float y = (float)view->height * 0.5f - (float)(y0 + i / 4) - 0.5f;
        packet->ray.dir_x[i] = view->right.x * x + view->up.x * y + view->forward.x * view->focal;
        packet->ray.dir_y[i] = view->right.y * x + view->up.y * y + view->forward.y * view->focal;
        packet->ray.dir_z[i] = view->right.z * x + view->up.z * y + view->forward.z * view->focal;
        packet->ray.org_x[i] = view->from.x, packet->ray.org_y[i] = view->from.y, packet->ray.org_z[i] = view->from.z;
        packet->ray.tnear[i] = 0, packet->ray.tfar[i] = INFINITY, packet->ray.time[i] = 0;
        packet->ray.mask[i] = UINT32_MAX, packet->ray.id[i] = 0, packet->ray.flags[i] = 0;
        packet->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, packet->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    return packet;
}

static const int BENCH_EMBREE_ALL[16]
    __attribute__((aligned(64))) = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

static inline void bench_embree_intersect(const bench_embree *self, bool coherent, struct RTCRayHit16 *packet)
{
#if DAFT_EMBREE == 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect16(BENCH_EMBREE_ALL, self->scene, packet, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcIntersect16(BENCH_EMBREE_ALL, self->scene, &context, packet);
#endif
}

static inline void bench_embree_occluded(const bench_embree *self, bool coherent, const int *valid,
                                         struct RTCRay16 *rays)
{
#if DAFT_EMBREE == 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcOccluded16(valid, self->scene, rays, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcOccluded16(valid, self->scene, &context, rays);
#endif
}

static inline struct RTCRayHit bench_embree_ray(const daft_ray *r)
{
    struct RTCRayHit query = {0};
    query.ray.org_x = r->origin.x, query.ray.org_y = r->origin.y, query.ray.org_z = r->origin.z;
    query.ray.dir_x = r->direction.x, query.ray.dir_y = r->direction.y, query.ray.dir_z = r->direction.z;
    query.ray.tnear = r->tmin, query.ray.tfar = r->tmax, query.ray.mask = UINT32_MAX;
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return query;
}

/* What all single rays of a run share; made once, so that no ray pays for it. */
typedef struct bench_embree_context {
#if DAFT_EMBREE == 4
    struct RTCIntersectArguments *none; /* the defaults */
#else
    struct RTCIntersectContext context;
#endif
} bench_embree_context;

static inline bench_embree_context bench_embree_begin(void)
{
    bench_embree_context out = {0};
#if DAFT_EMBREE < 4
    rtcInitIntersectContext(&out.context);
#endif
    return out;
}

/* A single ray, for the nearest hit or for any. Returns whether it hit. */
static inline bool bench_embree_single(bench_embree_context *with, RTCScene scene, bool any, struct RTCRayHit *query)
{
#if DAFT_EMBREE == 4
    (void)with;
    if (any)
        rtcOccluded1(scene, &query->ray, NULL);
    else
        rtcIntersect1(scene, query, NULL);
#else
    if (any)
        rtcOccluded1(scene, &with->context, &query->ray);
    else
        rtcIntersect1(scene, &with->context, query);
#endif
    return any ? query->ray.tfar < 0 : query->hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

/* map: where the mesh is put, or NULL: as it is. */
RTCGeometry bench_embree_triangles(RTCDevice device, const daft_trimesh *mesh, const daft_affine *map);
/* Instances in frame space, of two meshes at most: baked into one scene, or one level of instances. NULL: no device. */
bench_embree *bench_embree_placed(const daft_instance *instances, uint32_t count, bool two_level, int threads);
void bench_embree_close(bench_embree *self); /* NULL is fine */

double bench_embree_frame_ms(bench_embree *self, const bench_scene *scene, uint8_t *pixels);
#endif

#endif
