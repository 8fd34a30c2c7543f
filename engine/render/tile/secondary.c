/* Secondary rays of a tile: spawned by its points, traced through the BVH in streams or known by planar mirrors. */
#include "render/tile/tile.h"

#include <string.h>

enum { STREAM = 256 }; /* rays that are asked together */
_Static_assert((int)DAFT_TILE == (int)DAFT_STRIP_ROW, "places of pixels are those of a tile");

/* What the rays first.. of a batch hit; gives how many they are. `shown`: bits of the planar mirrors that know it of
 * theirs. */
static uint32_t trace_some(const tile_job *j, const daft_ray_batch *rays, uint32_t first, uint32_t shown,
                           daft_hit hits[STREAM])
{
    uint16_t others[STREAM];
    const uint32_t count = daft_min_u(STREAM, rays->count - first);
    const daft_lanes3 *o = &rays->origin, *d = &rays->direction;
    uint32_t asked = count;
    daft_ray_arrays arrays = {.origin = {o->x + first, o->y + first, o->z + first},
                              .direction = {d->x + first, d->y + first, d->z + first},
                              .place = &rays->pixel[first]};
    if (shown) {
        asked = daft_mirrors_hits(j->frame, shown, j->worker, j->s->seen_by, rays, first, count, hits, others);
        arrays.numbers = others;
    }
    j->r->accel->closest_arrays(j->frame->tlas, &arrays, asked, hits);
    return count;
}

static void append3(daft_lanes3 *to, uint32_t at, const daft_lanes3 *from, uint32_t count)
{
    memcpy(&to->x[at], from->x, count * sizeof(float)), memcpy(&to->y[at], from->y, count * sizeof(float));
    memcpy(&to->z[at], from->z, count * sizeof(float));
}

/* Deep down each batch would halve again and again: what is past its critical angle here, the rest there. */
daft_ray_batch *daft_tile_join(const tile_job *j, int depth)
{
    const daft_plan *plan = &j->frame->plan;
    if (!plan->refracts || depth >= plan->through_depth) return NULL;
    daft_ray_batch *to = &j->s->refracted[depth * plan->through_lists], *from = &j->s->rays;
    const uint32_t at = to->count, count = from->count;
    if (!at || !count || at + count > DAFT_BATCH) return NULL;
    append3(&to->origin, at, &from->origin, count);
    append3(&to->direction, at, &from->direction, count);
    append3(&to->weight, at, &from->weight, count);
    memcpy(&to->distance[at], from->distance, count * sizeof *from->distance);
    memcpy(&to->pixel[at], from->pixel, count * sizeof *from->pixel);
    if (to->media) memcpy(&to->media[at], from->media, count * sizeof *from->media);
    to->count += count, from->count = 0;
    return to;
}

void daft_tile_trace(tile_job *j, daft_ray_batch *rays, uint32_t mirrored, uint32_t shown, daft_batch *next)
{
    daft_scratch *s = j->s;
    daft_hit hits[STREAM];
    next->count = next->traits = 0, next->one_material = false;
    s->sky.count = 0;
    for (uint32_t first = 0, count; first < rays->count; first += count) {
        count = trace_some(j, rays, first, shown, hits);
        if (rays->media) daft_media_absorb(j, rays, first, hits, count);
        if (j->frame->plan.fog) daft_fog_rays(j, rays, first, hits, count);
        if (j->s->gloss && j->s->gloss->asks) daft_gloss_meet(j, rays, first, hits, count);
        j->r->kernels->hit_points(j->snapshot, rays, first, hits, count, &s->facets, next, &s->sky);
    }
    s->rays_cast[DAFT_EFFECT_REFLECTION] += mirrored;
    s->rays_cast[DAFT_EFFECT_REFRACTION] += rays->count - mirrored;
    daft_cost_add(j, rays->pixel, rays->count);
    if (mirrored) ran(j, DAFT_EFFECT_REFLECTION);
    if (mirrored < rays->count) ran(j, DAFT_EFFECT_REFRACTION);
    book_both(j, DAFT_EFFECT_REFLECTION, DAFT_EFFECT_REFRACTION, mirrored, rays->count);
}

/* Adds the sky along rays that meet nothing. */
void daft_tile_add_sky(tile_job *j, const daft_ray_batch *rays)
{
    if (rays->count == 0) return;
    daft_scratch *s = j->s;
    j->r->shade->sky(&j->snapshot->sky, &rays->direction, rays->count, &s->sky_color);
    j->r->shade->scatter_add(&s->color, rays->pixel, rays->count, &rays->weight, &s->sky_color);
    ran(j, DAFT_EFFECT_SKY);
    book(j, DAFT_EFFECT_SKY);
}

static bool is_black(daft_vec3 c) { return !(c.x > 0 || c.y > 0 || c.z > 0); }

/* What is shown where rays are not followed any more: the sky's mean colour. In rooms under a black sky it is the
 * ambient light, which stands for all that is around. */
static void add_mean(tile_job *j, const daft_ray_batch *rays)
{
    daft_lanes3 *color = &j->s->color;
    const daft_vec3 mean = j->snapshot->sky.mean, end = is_black(mean) ? j->snapshot->ambient.color : mean;
    for (uint32_t i = 0; i < rays->count; i++) {
        const uint32_t pixel = rays->pixel[i];
        color->x[pixel] += rays->weight.x[i] * end.x, color->y[pixel] += rays->weight.y[i] * end.y;
        color->z[pixel] += rays->weight.z[i] * end.z;
    }
}

static void end_in(tile_job *j, daft_ray_batch *rays, bool sky)
{
    if (sky)
        daft_tile_add_sky(j, rays);
    else
        add_mean(j, rays);
    rays->count = 0;
}

/* Where a quality follows no mirrored rays at all, mirrors show the sky as if nothing stood before it, and so does what
 * transmits where no refracted rays are followed. Mirrors in mirrors end in the mean colour. */
static void end_rays(tile_job *j, const daft_batch *points, const daft_spawning *last, int depth)
{
    daft_spawning all = *last;
    daft_scratch *s = j->s;
    const daft_quality *q = &j->snapshot->quality;
    const bool sky = depth == 0 && !is_black(j->snapshot->sky.mean);
    all.mirrors = !last->mirrors && (j->frame->plan.reflects || q->mirror_depth == 0);
    all.refracts = depth == 0 && q->refraction_depth == 0;
    if (!all.mirrors && !all.refracts) return;
    all.rough = false;
    s->sky.count = 0;
    j->r->kernels->spawn(j->snapshot, points, &all, &s->rays, all.refracts ? &s->sky : NULL, NULL);
    end_in(j, &s->rays, sky && q->mirror_depth == 0);
    end_in(j, &s->sky, sky);
}

void daft_tile_spawn(tile_job *j, const daft_batch *points, int depth, uint32_t ray, uint32_t rays)
{
    const daft_plan *plan = &j->frame->plan;
    const uint32_t columns = daft_tile_columns(j->snapshot);
    const daft_spawning allowed = {.mirrors = plan->reflects && depth < plan->quality->mirror_depth,
                                   .refracts = depth < plan->quality->refraction_depth,
                                   .min = plan->quality->min_weight,
                                   .rough = plan->glossy,
                                   .ray = depth ? 0 : ray,
                                   .rays = depth ? 1 : rays,
                                   .column = j->number % columns * DAFT_TILE,
                                   .row = j->number / columns * DAFT_TILE,
                                   .round = (uint32_t)j->frame->sample + j->snapshot->seed,
                                   .salt = 977u * (uint32_t)(depth + 1) + (depth ? 131u * ray : 0),
                                   .place = j->refines ? j->s->wanted : NULL,
                                   .turns = j->r->turns};
    const bool refracts = plan->refracts && depth < plan->through_depth;
    daft_ray_batch *waiting = refracts ? &j->s->refracted[depth * plan->through_lists] : NULL;
    daft_ray_batch *straight = refracts ? waiting + plan->through_lists - 1 : NULL;
    j->s->rays.count = 0;
    if (!(points->traits & DAFT_TRAIT_SENDS)) return;
    if (allowed.ray == 0) end_rays(j, points, &allowed, depth);
    if (allowed.mirrors || refracts)
        j->r->kernels->spawn(j->snapshot, points, &allowed, &j->s->rays, waiting, straight);
}

daft_ray_batch *daft_tile_waiting(const tile_job *j, int *depth)
{
    const daft_plan *plan = &j->frame->plan;
    if (!plan->refracts) return NULL;
    int list = (daft_min_i(*depth, plan->through_depth - 1) + 1) * plan->through_lists - 1;
    while (list >= 0 && j->s->refracted[list].count == 0) list--;
    if (list < 0) return NULL;
    *depth = list / plan->through_lists;
    return &j->s->refracted[list];
}
