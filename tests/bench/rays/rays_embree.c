/* Embree's single rays and packets of 16 of the scenes of embree.c, in its default mode. */
#include "harness/embree.h"
#include "rays.h"

#ifdef DAFT_EMBREE
#include <stdlib.h>
#include <string.h>

struct rays_embree {
    bench_embree *scene;
    struct RTCRayHit *single;
    struct RTCRayHit16 *packets;
    uint32_t count;
    rays_how how;
    bool coherent;
    uint64_t hits[64]; /* one for each worker */
};

static rays_embree *create(bench_embree *scene)
{
    rays_embree *self = calloc(1, sizeof *self);
    if (self) self->scene = scene;
    return self;
}

static void unload(rays_embree *self)
{
    free(self->single);
    free(self->packets);
    self->single = NULL, self->packets = NULL, self->count = 0;
}

static void destroy(rays_embree *self)
{
    unload(self);
    free(self);
}

static void load_packet(struct RTCRayHit16 *p, const daft_ray *rays)
{
    for (int i = 0; i < 16; i++) {
        const daft_ray *r = &rays[i];
        p->ray.org_x[i] = r->origin.x, p->ray.org_y[i] = r->origin.y, p->ray.org_z[i] = r->origin.z;
        p->ray.dir_x[i] = r->direction.x, p->ray.dir_y[i] = r->direction.y, p->ray.dir_z[i] = r->direction.z;
        p->ray.tnear[i] = r->tmin, p->ray.tfar[i] = r->tmax, p->ray.time[i] = 0;
        p->ray.mask[i] = UINT32_MAX, p->ray.id[i] = 0, p->ray.flags[i] = 0;
        p->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, p->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
}

/* count: a multiple of 16. */
static bool load(rays_embree *self, const daft_ray *rays, uint32_t count)
{
    unload(self);
    self->single = aligned_alloc(64, (count * sizeof *self->single + 63) / 64 * 64);
    self->packets = aligned_alloc(64, count / 16 * sizeof *self->packets);
    if (!self->single || !self->packets) return false;
    for (uint32_t i = 0; i < count; i++) self->single[i] = bench_embree_ray(&rays[i]);
    for (uint32_t i = 0; i < count; i += 16) load_packet(&self->packets[i / 16], rays + i);
    self->count = count;
    return true;
}

static uint64_t trace_single(const rays_embree *self, uint32_t first, uint32_t end)
{
    bench_embree_context with = bench_embree_begin();
    uint64_t hits = 0;
    for (uint32_t i = first; i < end; i++) {
        struct RTCRayHit query = self->single[i];
        hits += bench_embree_single(&with, self->scene->scene, self->how == RAYS_OCCLUDED_SINGLE, &query);
    }
    return hits;
}

static uint64_t trace_packets(const rays_embree *self, uint32_t first, uint32_t end)
{
    uint64_t hits = 0;
    for (uint32_t p = first / 16; p < end / 16; p++) {
        struct RTCRayHit16 query = self->packets[p];
        bool occluded = self->how == RAYS_OCCLUDED_PACKET;
        if (occluded)
            bench_embree_occluded(self->scene, self->coherent, BENCH_EMBREE_ALL, &query.ray);
        else
            bench_embree_intersect(self->scene, self->coherent, &query);
        for (int i = 0; i < 16; i++)
            hits += occluded ? query.ray.tfar[i] < 0 : query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

static void trace_task(void *context, uint32_t index, uint32_t worker)
{
    rays_embree *self = context;
    uint32_t first = index * RAYS_TASK, end = daft_min_u(first + RAYS_TASK, self->count);
    bool packets = self->how == RAYS_CLOSEST_PACKET || self->how == RAYS_OCCLUDED_PACKET;
    self->hits[worker] += packets ? trace_packets(self, first, end) : trace_single(self, first, end);
}

static double trace_ms(rays_embree *self, rays_how how, bool coherent, uint64_t *hits)
{
    memset(self->hits, 0, sizeof self->hits);
    self->how = how, self->coherent = coherent && !self->scene->instanced; /* see embree.c */
    double start = bench_clock_ms(self->scene->threads);
    daft_parallel_for(self->scene->threads, (self->count + RAYS_TASK - 1) / RAYS_TASK, trace_task, self);
    double ms = bench_clock_ms(self->scene->threads) - start;
    *hits = 0;
    for (size_t i = 0; i < DAFT_COUNT_OF(self->hits); i++) *hits += self->hits[i];
    return ms;
}

static const rays_embree_api API = {create, destroy, load, trace_ms};

const rays_embree_api *rays_find_embree(void) { return &API; }
#else
const rays_embree_api *rays_find_embree(void) { return NULL; }
#endif
