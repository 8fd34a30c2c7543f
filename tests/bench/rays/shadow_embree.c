/* Shadow rays through Embree: packets of 16, marked coherent except for scenes of instances (embree.c). */
#include "harness/embree.h"
#include "shadow.h"

#ifdef DAFT_EMBREE
enum { CHUNK = 4096 }; /* rays in a task */

typedef struct ray_job {
    const bench_embree *self;
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
    size_t first = (size_t)chunk * CHUNK, end = first + CHUNK < job->from->count ? first + CHUNK : job->from->count;
    uint64_t dark = 0;
    for (size_t at = first; at < end; at += 16) {
        set_rays(job, at, valid, &packet);
        bench_embree_occluded(job->self, !job->self->instanced, valid, &packet);
        for (int i = 0; i < 16; i++) dark += valid[i] && packet.tfar[i] < 0;
    }
    job->dark[worker] += dark;
}

static double occluded_ms(bench_embree *self, const shadow_origins *from, const daft_light_source *light,
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

static const shadow_embree_api API = {"Embree " RTC_VERSION_STRING, bench_embree_placed, bench_embree_close,
                                      occluded_ms};

const shadow_embree_api *shadow_find_embree(void) { return &API; }
#else
const shadow_embree_api *shadow_find_embree(void) { return NULL; }
#endif
