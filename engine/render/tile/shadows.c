/* Light visibility of a batch: the points become samples of the light's pencil (raster/view.h), a spot's as a point
 * light's, since facing() has tested its cone; an area's as its middle's, but for those that see a part of it alone.
 * Occluders take a point's light away; what transmits takes a fraction of it.
 */
#include "render/tile/tile.h"

#include <string.h>

static void *samples_scratch(const tile_job *j)
{
    return j->r->sample_scratch + j->worker * j->r->sample_kernels->scratch_size;
}

static uint32_t cast(tile_job *j, const daft_batch *points, const daft_light_source *light, uint32_t instance,
                     uint32_t *bits)
{
    const daft_samples samples = daft_samples_of(points);
    const daft_apex apex = daft_apex_of(light);
    return j->r->sample_kernels->shadows(&samples, &apex, j->frame->tlas, instance, bits, samples_scratch(j));
}

/* Lights the points of the bits whose own ray to what they see of an area meets nothing; gives their number. */
static uint32_t ask_aside(tile_job *j, const daft_batch *points, const daft_light_source *light, const uint32_t *bits)
{
    uint32_t rays = 0;
    for (uint32_t k = 0; k < DAFT_BATCH_WORDS; k++)
        for (uint32_t left = bits[k]; left; left &= left - 1, rays++) {
            daft_ray ray;
            if (daft_tile_sharp_ray(points, 32 * k + (uint32_t)__builtin_ctz(left), light, &ray) &&
                !j->r->accel->occluded(j->frame->tlas, &ray))
                j->s->lit[k] |= left & (0 - left);
        }
    return rays;
}

void daft_tile_shadows(tile_job *j, const daft_batch *points, const daft_light_source *light)
{
    daft_scratch *s = j->s;
    uint32_t aside[DAFT_BATCH_WORDS];
    daft_cost_add_some(j, points->pixel, s->lit, points->count);
    const bool some = light->area && j->r->kernels->skip_middle(points, light, s->lit, aside);
    uint32_t rays = cast(j, points, light, DAFT_NOTHING, s->lit);
    if (some) rays += ask_aside(j, points, light, aside);
    s->rays_cast[DAFT_EFFECT_SHADOW] += rays;
    s->shadow_points += rays;
    if (rays) ran(j, DAFT_EFFECT_SHADOW);
    book(j, DAFT_EFFECT_SHADOW);
}

/* The fraction of light that an instance transmits: the mean of its materials. */
static daft_vec3 transmittance(const daft_snapshot *snapshot, const daft_instance *instance)
{
    uint32_t slots = instance->mesh && instance->mesh->slot_count ? instance->mesh->slot_count : 1;
    daft_vec3 sum = {0, 0, 0};
    for (uint32_t i = 0; i < slots; i++) sum = daft_add(sum, snapshot->materials[instance->materials[i]].transmittance);
    return daft_scale(sum, 1 / (float)slots);
}

static bool absorbs(const daft_snapshot *snapshot, const daft_instance *instance)
{
    uint32_t slots = instance->mesh && instance->mesh->slot_count ? instance->mesh->slot_count : 1;
    for (uint32_t i = 0; i < slots; i++)
        if (daft_surface_absorbs(&snapshot->materials[instance->materials[i]])) return true;
    return false;
}

/* The lit points that the instance hides from the light keep of it what the instance transmits; of its own, all.
 * `dimmed`: gets their bits where it absorbs. */
static void tint_points(tile_job *j, const daft_batch *points, const daft_light_source *light, uint32_t instance,
                        uint32_t *dimmed)
{
    daft_scratch *s = j->s;
    daft_lanes3 *passed = s->passed;
    if (light->entity && j->snapshot->instances[instance].entity == light->entity) return;
    memcpy(s->under, s->lit, sizeof s->under);
    uint32_t rays = cast(j, points, light, instance, s->under);
    s->rays_cast[DAFT_EFFECT_SHADOW] += rays;
    s->shadow_points += rays;
    if (rays) ran(j, DAFT_EFFECT_SHADOW);
    daft_vec3 fraction = transmittance(j->snapshot, &j->snapshot->instances[instance]);
    for (uint32_t i = 0; i < points->count; i++) {
        if (!((s->lit[i / 32] & ~s->under[i / 32]) >> (i % 32) & 1)) continue;
        passed->x[i] *= fraction.x, passed->y[i] *= fraction.y, passed->z[i] *= fraction.z;
    }
    if (!absorbs(j->snapshot, &j->snapshot->instances[instance])) return;
    for (uint32_t i = 0; i < DAFT_SAMPLES_WORDS; i++) dimmed[i] |= s->lit[i] & ~s->under[i];
}

const daft_lanes3 *daft_tile_tints(tile_job *j, const daft_batch *points, const daft_light_source *light)
{
    daft_scratch *s = j->s;
    const daft_samples samples = daft_samples_of(points);
    const daft_apex apex = daft_apex_of(light);
    uint32_t count =
        j->r->sample_kernels->tints(&samples, &apex, j->frame->tlas, s->lit, s->candidates, samples_scratch(j));
    uint32_t dimmed[DAFT_SAMPLES_WORDS] = {0};
    const bool within = j->frame->plan.absorbs && daft_media_hold_points(j, points, dimmed);
    if (count == 0 && !within) return NULL;
    for (uint32_t i = 0; i < points->count + 16; i++) s->passed->x[i] = s->passed->y[i] = s->passed->z[i] = 1;
    if (count != UINT32_MAX) {
        for (uint32_t i = 0; i < count; i++) tint_points(j, points, light, s->candidates[i], dimmed);
    } else {
        for (uint32_t i = 0; i < j->snapshot->instance_count; i++)
            if (j->snapshot->instances[i].flags & DAFT_INSTANCE_TINTS_SHADOW) tint_points(j, points, light, i, dimmed);
    }
    if (j->frame->plan.absorbs) daft_media_dim(j, points, light, dimmed, s->passed);
    book(j, DAFT_EFFECT_SHADOW);
    return s->passed;
}
