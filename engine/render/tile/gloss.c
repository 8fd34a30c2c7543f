/* What rough surfaces mirror and let through, where pixels see them: each sends on some rays, in directions of their
 * own, and what comes back is noisy. It is kept apart from the rest of the pixel's light, as a mean over its rays'
 * weights, so that it can be filtered; with it goes how far the rays went, by which a reflection is the sharper the
 * closer to the surface its object is. When edges get more samples, it is
 * filtered. These samples trace no rough rays, which would bring the noise back. They take the filtered mean, times the
 * weight of the rays they would have sent. */
#include "render/tile/tile.h"

#include <string.h>

/* The slope of a point's facets; 0: it is smooth. */
static float alpha_of(const tile_job *j, const daft_batch *points, uint32_t i)
{
    if (points->traits & DAFT_TRAIT_VARIES) return points->varying->alpha[i];
    return j->snapshot->materials[points->material[i]].alpha;
}

void daft_gloss_begin(const tile_job *j, const daft_batch *points)
{
    daft_gloss *g = j->s->gloss;
    memset(g->rough, 0, sizeof g->rough);
    memset(&g->weight, 0, sizeof g->weight);
    memset(g->inverse, 0, sizeof g->inverse);
    memset(g->rays, 0, sizeof g->rays);
    for (uint32_t i = 0; i < points->count; i++) {
        const uint32_t pixel = points->pixel[i];
        const float alpha = alpha_of(j, points, i);
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

/* ---- more samples of some pixels ---- */

void daft_gloss_recall(const tile_job *j, const daft_batch *points)
{
    daft_gloss *g = j->s->gloss;
    memset(g->rough, 0, sizeof g->rough);
    g->some = false;
    if (!(points->traits & DAFT_TRAIT_ROUGH)) return;
    for (uint32_t i = 0; i < points->count; i++) {
        const uint32_t pixel = points->pixel[i];
        float light[3];
        if (!(alpha_of(j, points, i) > 0) || !daft_denoise_recall_gloss(j, points, i, light)) continue;
        g->rough[pixel / 32] |= 1u << (pixel % 32);
        g->recalled.x[pixel] = light[0], g->recalled.y[pixel] = light[1], g->recalled.z[pixel] = light[2];
        g->some = true;
    }
}

static void move3(daft_lanes3 *v, uint32_t to, uint32_t from)
{
    v->x[to] = v->x[from], v->y[to] = v->y[from], v->z[to] = v->z[from];
}

static void move_ray(daft_ray_batch *rays, uint32_t to, uint32_t from)
{
    if (to == from) return;
    move3(&rays->origin, to, from), move3(&rays->direction, to, from), move3(&rays->weight, to, from);
    rays->distance[to] = rays->distance[from], rays->pixel[to] = rays->pixel[from];
    if (rays->media) rays->media[to] = rays->media[from];
}

void daft_gloss_replace(const tile_job *j, daft_ray_batch *rays)
{
    const daft_gloss *g = j->s->gloss;
    daft_lanes3 *color = &j->s->color;
    uint32_t left = 0;
    for (uint32_t i = 0; i < rays->count; i++) {
        const uint32_t pixel = rays->pixel[i];
        if (!daft_gloss_is_rough(g, pixel)) {
            move_ray(rays, left++, i);
            continue;
        }
        color->x[pixel] += rays->weight.x[i] * g->recalled.x[pixel];
        color->y[pixel] += rays->weight.y[i] * g->recalled.y[pixel];
        color->z[pixel] += rays->weight.z[i] * g->recalled.z[pixel];
    }
    rays->count = left;
}
