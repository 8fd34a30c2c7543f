/* What rough surfaces mirror and let through, where pixels see them: each sends on some rays, in directions of their
 * own, and what comes back is noisy. It is kept apart from the rest of the pixel's light, as a mean over its rays'
 * weights, so that it can be filtered; with it goes how far the rays went, by which a reflection is the sharper the
 * closer to the surface its object is. */
#include "render/tile/tile.h"

#include <string.h>

void daft_gloss_begin(const tile_job *j, const daft_batch *points)
{
    daft_gloss *g = j->s->gloss;
    memset(g->rough, 0, sizeof g->rough);
    memset(&g->weight, 0, sizeof g->weight);
    memset(g->inverse, 0, sizeof g->inverse);
    memset(g->rays, 0, sizeof g->rays);
    for (uint32_t i = 0; i < points->count; i++) {
        const uint32_t pixel = points->pixel[i];
        const float alpha = points->traits & DAFT_TRAIT_VARIES ? points->varying->alpha[i]
                                                               : j->snapshot->materials[points->material[i]].alpha;
        if (!(alpha > 0)) continue;
        g->rough[pixel / 32] |= 1u << (pixel % 32);
        g->alpha[pixel] = alpha, g->distance[pixel] = points->distance[i];
        g->some = true;
    }
    memcpy(&g->sharp, &j->s->color, sizeof g->sharp);
}

void daft_gloss_send(const tile_job *j, const daft_ray_batch *rays)
{
    daft_gloss *g = j->s->gloss;
    for (uint32_t i = 0; i < rays->count; i++) {
        const uint32_t pixel = rays->pixel[i];
        g->weight.x[pixel] += rays->weight.x[i], g->weight.y[pixel] += rays->weight.y[i];
        g->weight.z[pixel] += rays->weight.z[i];
    }
}

void daft_gloss_meet(const tile_job *j, const daft_ray_batch *rays, uint32_t first, const daft_hit *hits,
                     uint32_t count)
{
    daft_gloss *g = j->s->gloss;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t pixel = rays->pixel[first + i];
        if (hits[i].instance != UINT32_MAX && hits[i].t > 0) g->inverse[pixel] += 1 / hits[i].t;
        g->rays[pixel]++;
    }
}
