/* Secondary rays of a tile: spawned by its points, traced through the BVH in streams or known by planar mirrors. */
#include "render/tile/tile.h"

enum { STREAM = 256 }; /* rays that are asked together */

/* Member by member: a ray made of parts elsewhere and copied here waits until its parts are stored. */
static void put_ray(daft_ray *out, const daft_ray_batch *rays, uint32_t i)
{
    out->origin.x = rays->origin.x[i], out->origin.y = rays->origin.y[i], out->origin.z = rays->origin.z[i];
    out->tmin = 0;
    out->direction.x = rays->direction.x[i], out->direction.y = rays->direction.y[i];
    out->direction.z = rays->direction.z[i];
    out->tmax = INFINITY;
}

/* What the rays first.. of a batch hit; gives how many they are. `shown`: bits of the planar mirrors that know it of
 * theirs. */
static uint32_t trace_some(const tile_job *j, const daft_ray_batch *rays, uint32_t first, uint32_t shown,
                           daft_hit hits[STREAM])
{
    daft_ray stream[STREAM];
    daft_hit found[STREAM];
    uint32_t place[STREAM], count = daft_min_u(STREAM, rays->count - first), asked = count;
    if (shown) asked = daft_mirrors_hits(j->frame, shown, j->worker, j->s->seen_by, rays, first, count, hits, place);
    for (uint32_t i = 0; i < asked; i++) put_ray(&stream[i], rays, first + (shown ? place[i] : i));
    j->r->accel->closest_stream(j->frame->tlas, stream, asked, UINT32_MAX, shown ? found : hits);
    for (uint32_t i = 0; shown && i < asked; i++) hits[place[i]] = found[i];
    return count;
}

static void see_sky(daft_ray_batch *sky, const daft_ray_batch *rays, uint32_t i)
{
    uint32_t at = sky->count++;
    sky->direction.x[at] = rays->direction.x[i], sky->direction.y[at] = rays->direction.y[i];
    sky->direction.z[at] = rays->direction.z[i];
    sky->weight.x[at] = rays->weight.x[i], sky->weight.y[at] = rays->weight.y[i], sky->weight.z[at] = rays->weight.z[i];
    sky->pixel[at] = rays->pixel[i];
}

void daft_tile_trace(tile_job *j, daft_ray_batch *rays, daft_effect_kind effect, uint32_t shown, daft_batch *next)
{
    daft_scratch *s = j->s;
    daft_hit hits[STREAM];
    next->count = next->traits = 0, next->one_material = false;
    s->sky.count = 0;
    for (uint32_t first = 0, count; first < rays->count; first += count) {
        count = trace_some(j, rays, first, shown, hits);
        if (rays->media) daft_media_absorb(j, rays, first, hits, count);
        if (j->frame->plan.fog) daft_fog_rays(j, rays, first, hits, count);
        for (uint32_t i = 0; i < count; i++)
            if (hits[i].instance == UINT32_MAX) see_sky(&s->sky, rays, first + i);
        if (j->s->gloss && j->s->gloss->asks) daft_gloss_meet(j, rays, first, hits, count);
        j->r->kernels->hit_points(j->snapshot, rays, first, hits, count, &s->facets, next);
    }
    s->rays_cast[effect] += rays->count;
    daft_cost_add(j, rays->pixel, rays->count);
    ran(j, effect);
    book(j, effect);
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
    all.rough = false, all.blends = false;
    s->sky.count = 0;
    j->r->kernels->spawn(j->snapshot, points, &all, &s->rays, all.refracts ? &s->sky : NULL);
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
                                   .blends = true,
                                   .ray = depth ? 0 : ray,
                                   .rays = depth ? 1 : rays,
                                   .column = j->number % columns * DAFT_TILE,
                                   .row = j->number / columns * DAFT_TILE,
                                   .round = (uint32_t)j->frame->sample + j->snapshot->seed,
                                   .salt = 977u * (uint32_t)(depth + 1) + (depth ? 131u * ray : 0),
                                   .place = j->refines ? j->s->wanted : NULL,
                                   .turns = j->r->turns};
    bool refracts = j->frame->plan.refracts && depth < plan->through_depth;
    j->s->rays.count = 0;
    if (!(points->traits & DAFT_TRAIT_SENDS)) return;
    if (allowed.ray == 0) end_rays(j, points, &allowed, depth);
    if (allowed.mirrors || refracts)
        j->r->kernels->spawn(j->snapshot, points, &allowed, &j->s->rays, refracts ? &j->s->refracted[depth] : NULL);
}

int daft_tile_deepest_waiting(const tile_job *j, int depth)
{
    if (!j->frame->plan.refracts) return -1;
    depth = daft_min_i(depth, j->frame->plan.through_depth - 1);
    while (depth >= 0 && j->s->refracted[depth].count == 0) depth--;
    return depth;
}
