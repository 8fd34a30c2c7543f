/* Fog on the way of camera rays and of those that surfaces send on. A ray's weight loses what the fog takes, so that
 * whatever comes along it later is dimmed by all of the way. */
#include "render/tile/tile.h"

#include <math.h>

enum { STREAM = 256 }; /* rays that are traced together */

static void dim(daft_lanes3 *light, const float *through, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        light->x[i] *= through[i], light->y[i] *= through[i], light->z[i] *= through[i];
}

static void blend(daft_lanes3 *light, const float *through, const daft_lanes3 *own, uint32_t count)
{
    dim(light, through, count);
    for (uint32_t i = 0; i < count; i++) light->x[i] += own->x[i], light->y[i] += own->y[i], light->z[i] += own->z[i];
}

void daft_fog_points(tile_job *j, daft_batch *points)
{
    daft_sampled_light *sampled = j->s->sampled;
    daft_lanes3 *own = &j->s->sky_color;
    float through[DAFT_BATCH_ROOM];
    book(j, DAFT_EFFECT_LIGHTING);
    j->r->shade->fog(&j->snapshot->air, NULL, &points->point, points->distance, 0, points->count, through, own);
    blend(&points->light, through, own, points->count);
    dim(&points->weight, through, points->count);
    if (sampled && sampled->some) {
        dim(&sampled->whole, through, points->count);
        dim(&sampled->arrived, through, points->count);
    }
    ran(j, DAFT_EFFECT_FOG);
    book(j, DAFT_EFFECT_FOG);
}

void daft_fog_sky(tile_job *j)
{
    const daft_ray_batch *sky = &j->s->sky;
    float through[DAFT_BATCH_ROOM];
    daft_lanes3 own;
    book(j, DAFT_EFFECT_SKY);
    j->r->shade->fog(&j->snapshot->air, NULL, &sky->direction, NULL, 0, sky->count, through, &own);
    blend(&j->s->sky_color, through, &own, sky->count);
    ran(j, DAFT_EFFECT_FOG);
    book(j, DAFT_EFFECT_FOG);
}

/* Where a ray meets nothing its way has no end. */
void daft_fog_rays(tile_job *j, daft_ray_batch *rays, uint32_t first, const daft_hit *hits, uint32_t count)
{
    daft_lanes3 *own = &j->s->sky_color, *color = &j->s->color;
    float through[DAFT_BATCH_ROOM], length[STREAM + 16], endless[DAFT_BATCH_ROOM];
    bool any = false;
    for (uint32_t i = 0; i < count; i++) {
        const bool sky = hits[i].instance == UINT32_MAX;
        length[i] = sky ? 0 : hits[i].t, any |= sky;
    }
    for (uint32_t i = count; i < count + 16; i++) length[i] = 0;
    if (any) {
        j->r->shade->fog(&j->snapshot->air, &rays->origin, &rays->direction, NULL, first, count, endless,
                         &j->s->far_fog);
    }
    j->r->shade->fog(&j->snapshot->air, &rays->origin, &rays->direction, length, first, count, through, own);
    for (uint32_t i = 0; i < count; i++) {
        const bool sky = hits[i].instance == UINT32_MAX;
        const daft_lanes3 *from = sky ? &j->s->far_fog : own;
        const uint32_t pixel = rays->pixel[first + i], at = first + i;
        color->x[pixel] += rays->weight.x[at] * from->x[i], color->y[pixel] += rays->weight.y[at] * from->y[i];
        color->z[pixel] += rays->weight.z[at] * from->z[i];
        const float left = sky ? endless[i] : through[i];
        rays->weight.x[at] *= left, rays->weight.y[at] *= left, rays->weight.z[at] *= left;
    }
    ran(j, DAFT_EFFECT_FOG);
    book(j, DAFT_EFFECT_FOG);
}
