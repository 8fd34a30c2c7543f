/* A tile from visibility to bytes. Points are shaded in batches: first what the pixels see, then what mirrors see in it,
 * and so on; each batch runs only the effects that its own points call for. Where a batch sends on both mirrored and
 * refracted rays, the refracted ones wait until the mirrored ones have been followed to their end. */
#include "render/internal.h"

#include <string.h>

typedef struct job {
    const daft_frame *frame;
    const daft_renderer *r;
    const daft_snapshot *snapshot;
    daft_scratch *s;
    uint32_t number, worker;      /* of the tile */
    const daft_lanes3 *color;     /* of the tile's pixels, in the end */
    uint64_t since;               /* when the running effect began */
    bool ran[DAFT_EFFECT_COUNT];
} job;

/* Books the time since the last call on an effect. */
static void book(job *j, daft_effect_kind effect)
{
    uint64_t now = daft_clock_ticks();
    if (now > j->since) j->s->ticks[effect] += now - j->since;
    j->since = now;
}

static void ran(job *j, daft_effect_kind effect)
{
    if (!j->ran[effect]) j->s->tiles[effect]++;
    j->ran[effect] = true;
}

static void see(job *j, uint32_t tile, uint32_t worker)
{
    const daft_frame *frame = j->frame;
    if (j->snapshot->reference)
        daft_reference_tile(&j->r->raster, frame->tlas, tile, &j->s->tile);
    else
        j->r->raster_kernels->tile(&j->r->raster, tile, worker, &j->s->tile);
    ran(j, DAFT_EFFECT_VISIBILITY);
    j->s->rays_cast[DAFT_EFFECT_VISIBILITY] += (uint64_t)(j->s->tile.width * j->s->tile.height);
    book(j, DAFT_EFFECT_VISIBILITY);
}

static void cast_shadows(job *j, const daft_batch *points, const daft_lamp *lamp)
{
    daft_scratch *s = j->s;
    uint32_t rays = j->r->kernels->shadows(points, lamp, j->frame->tlas, DAFT_NOTHING, s->lit);
    s->rays_cast[DAFT_EFFECT_SHADOW] += rays;
    s->shadow_points += rays;
    if (rays) ran(j, DAFT_EFFECT_SHADOW);
    book(j, DAFT_EFFECT_SHADOW);
}

/* How much of a lamp's light comes through a thing: the mean of its materials. */
static daft_vec3 through(const daft_snapshot *snapshot, const daft_instance *instance)
{
    uint32_t slots = instance->mesh && instance->mesh->slot_count ? instance->mesh->slot_count : 1;
    daft_vec3 sum = {0, 0, 0};
    for (uint32_t i = 0; i < slots; i++) sum = daft_add(sum, snapshot->materials[instance->materials[i]].through);
    return daft_scale(sum, 1 / (float)slots);
}

/* The lit points that the thing hides from the lamp keep of its light what comes through. */
static void tint_points(job *j, const daft_batch *points, const daft_lamp *lamp, uint32_t instance)
{
    daft_scratch *s = j->s;
    daft_lanes3 *passed = s->passed;
    memcpy(s->under, s->lit, sizeof s->under);
    uint32_t rays = j->r->kernels->shadows(points, lamp, j->frame->tlas, instance, s->under);
    s->rays_cast[DAFT_EFFECT_SHADOW] += rays;
    s->shadow_points += rays;
    if (rays) ran(j, DAFT_EFFECT_SHADOW);
    daft_vec3 share = through(j->snapshot, &j->snapshot->instances[instance]);
    for (uint32_t i = 0; i < points->count; i++) {
        if (!((s->lit[i / 32] & ~s->under[i / 32]) >> (i % 32) & 1)) continue;
        passed->x[i] *= share.x, passed->y[i] *= share.y, passed->z[i] *= share.z;
    }
}

/* The share of the lamp's light that comes through what transmits, once for each thing on the way, however thick. NULL:
 * nothing is in the way. */
static const daft_lanes3 *tint_light(job *j, const daft_batch *points, const daft_lamp *lamp)
{
    daft_scratch *s = j->s;
    uint32_t count = j->r->kernels->tints(points, lamp, j->frame->tlas, s->lit, s->candidates);
    if (count == 0) return NULL;
    for (uint32_t i = 0; i < points->count + 16; i++) s->passed->x[i] = s->passed->y[i] = s->passed->z[i] = 1;
    if (count != UINT32_MAX) {
        for (uint32_t i = 0; i < count; i++) tint_points(j, points, lamp, s->candidates[i]);
    } else {
        for (uint32_t i = 0; i < j->snapshot->instance_count; i++)
            if (j->snapshot->instances[i].flags & DAFT_INSTANCE_TINTS_SHADOW) tint_points(j, points, lamp, i);
    }
    book(j, DAFT_EFFECT_SHADOW);
    return s->passed;
}

static void light_points(job *j, daft_batch *points)
{
    const daft_snapshot *snapshot = j->snapshot;
    const daft_vec3 *first = &snapshot->ambient;
    if (points->traits & DAFT_TRAIT_TEXTURE) {
        j->r->shade->albedo(points, snapshot->materials, snapshot->textures);
        ran(j, DAFT_EFFECT_TEXTURE);
        book(j, DAFT_EFFECT_TEXTURE);
    }
    for (uint32_t i = 0; i < snapshot->lamp_count; i++) {
        const daft_lamp *lamp = &snapshot->lamps[i];
        if (j->r->shade->facing(points, lamp, j->s->lit) == 0) continue;
        ran(j, DAFT_EFFECT_LIGHTING);
        book(j, DAFT_EFFECT_LIGHTING);
        if (j->frame->plan.shadows && lamp->casts_shadow) cast_shadows(j, points, lamp);
        const daft_lanes3 *passed = j->frame->plan.tints && lamp->casts_shadow ? tint_light(j, points, lamp) : NULL;
        j->r->shade->lamp(points, snapshot->materials, lamp, j->s->lit, passed, first);
        first = NULL;
    }
    if (first) j->r->shade->ambient(points, snapshot->materials, *first);
    book(j, DAFT_EFFECT_LIGHTING);
}

/* Adds the sky along rays that were followed. */
static void add_sky(job *j, const daft_ray_batch *rays)
{
    if (rays->count == 0) return;
    daft_scratch *s = j->s;
    j->r->shade->sky(&j->snapshot->sky, &rays->direction, rays->count, &s->sky_color);
    j->r->shade->add(&s->color, rays->pixel, rays->count, &rays->weight, &s->sky_color);
    ran(j, DAFT_EFFECT_SKY);
    book(j, DAFT_EFFECT_SKY);
}

enum { STREAM = 256 }; /* rays that are asked together */

static daft_ray ray_of(const daft_ray_batch *rays, uint32_t i)
{
    return (daft_ray){.origin = {rays->origin.x[i], rays->origin.y[i], rays->origin.z[i]},
                      .direction = {rays->direction.x[i], rays->direction.y[i], rays->direction.z[i]},
                      .tmax = INFINITY};
}

/* What the rays first.. of a batch hit; gives how many they are. `shown`: bits of the flat mirrors that know it of theirs. */
static uint32_t trace_some(const job *j, const daft_ray_batch *rays, uint32_t first, uint32_t shown, daft_hit hits[STREAM])
{
    daft_ray stream[STREAM];
    daft_hit found[STREAM];
    uint32_t place[STREAM], count = daft_min_u(STREAM, rays->count - first), asked = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (shown && daft_mirrors_hit(j->frame, shown, j->worker, &j->s->tile, rays, first + i, &hits[i])) continue;
        place[asked] = i;
        stream[asked++] = ray_of(rays, first + i);
    }
    j->r->accel->closest_stream(j->frame->tlas, stream, asked, UINT32_MAX, found);
    for (uint32_t i = 0; i < asked; i++) hits[place[i]] = found[i];
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

/* Hits become the next batch; misses see the sky. */
static void trace(job *j, const daft_ray_batch *rays, daft_effect_kind effect, uint32_t shown, daft_batch *next)
{
    daft_scratch *s = j->s;
    daft_hit hits[STREAM];
    next->count = next->traits = 0, next->one_material = false;
    s->sky.count = 0;
    for (uint32_t first = 0, count; first < rays->count; first += count) {
        count = trace_some(j, rays, first, shown, hits);
        for (uint32_t i = 0; i < count; i++)
            if (hits[i].instance == UINT32_MAX) see_sky(&s->sky, rays, first + i);
        j->r->kernels->hit_points(j->snapshot, rays, first, hits, count, &s->facets, next);
    }
    s->rays_cast[effect] += rays->count;
    ran(j, effect);
    book(j, effect);
}

/* The rays that points `depth` surfaces away send on: s->rays, and s->refracted[depth] where some of them transmit. */
static void spawn(job *j, const daft_batch *points, int depth)
{
    const daft_plan *plan = &j->frame->plan;
    daft_spawning allowed = {plan->reflects && depth < plan->preset->reflections, plan->preset->least_weight};
    bool through = j->frame->plan.refracts && depth < plan->preset->refractions;
    j->s->rays.count = 0;
    if (!(points->traits & DAFT_TRAIT_SENDS)) return;
    if (allowed.mirrors || through)
        j->r->kernels->spawn(j->snapshot, points, &allowed, &j->s->rays, through ? &j->s->refracted[depth] : NULL);
}

/* The deepest of the refracted rays that wait for points at `depth` or less to be done. Deeper ones have been followed, so
 * one batch for each depth is room enough. -1: none. */
static int deepest_waiting(const job *j, int depth)
{
    if (!j->frame->plan.refracts) return -1;
    depth = daft_min_i(depth, j->frame->plan.preset->refractions - 1);
    while (depth >= 0 && j->s->refracted[depth].count == 0) depth--;
    return depth;
}

/* What the pixels see without anything that is sent on. A tile full of surfaces has its points in the pixels' order, and
 * their light is the picture. */
static void shade_seen(job *j)
{
    daft_scratch *s = j->s;
    const daft_shade_kernels *kernels = j->r->shade;
    daft_batch *points = &s->points;
    const daft_ray_batch *sky = &s->sky;
    if (points->count) light_points(j, points);
    if (sky->count == 0 && s->tile.width == DAFT_TILE && !(points->traits & DAFT_TRAIT_SENDS)) {
        j->color = &points->light;
        return;
    }
    j->color = &s->color;
    if (points->count) kernels->put(&s->color, points->pixel, points->count, &points->light);
    book(j, DAFT_EFFECT_LIGHTING);
    if (sky->count == 0) return;
    kernels->sky(&j->snapshot->sky, &sky->direction, sky->count, &s->sky_color);
    kernels->put(&s->color, sky->pixel, sky->count, &s->sky_color);
    ran(j, DAFT_EFFECT_SKY);
    book(j, DAFT_EFFECT_SKY);
}

static void shade(job *j)
{
    daft_scratch *s = j->s;
    daft_batch *points = &s->points, *next = &s->next;
    shade_seen(j);
    for (int depth = 0;; depth++) {
        if (depth && points->count) {
            light_points(j, points);
            j->r->shade->add(&s->color, points->pixel, points->count, &points->weight, &points->light);
        }
        spawn(j, points, depth);
        if (s->rays.count) {
            uint32_t shown = depth == 0 ? daft_mirrors_tile(j->frame, j->number, j->worker, &s->tile, &s->rays) : 0;
            trace(j, &s->rays, DAFT_EFFECT_REFLECTION, shown, next);
        } else {
            depth = deepest_waiting(j, depth);
            if (depth < 0) return;
            trace(j, &s->refracted[depth], DAFT_EFFECT_REFRACTION, 0, next);
            s->refracted[depth].count = 0;
        }
        add_sky(j, &s->sky);
        daft_batch *done = points;
        points = next, next = done;
    }
}

/* ---- out ---- */

static float clamp_unit(float x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

/* Samples are clamped to what a display shows before they are averaged: one very bright sample must not win an edge. */
static void add_sample(const job *j, int row)
{
    const daft_tile *tile = &j->s->tile;
    const daft_lanes3 *color = j->color;
    float *sum = j->r->sum + 3 * ((size_t)(tile->y + row) * (size_t)j->snapshot->width + (size_t)tile->x);
    for (int x = 0; x < tile->width; x++) {
        int at = row * DAFT_TILE + x;
        const float sample[3] = {color->x[at], color->y[at], color->z[at]};
        for (int k = 0; k < 3; k++) sum[3 * x + k] = (j->frame->sample ? sum[3 * x + k] : 0) + clamp_unit(sample[k]);
    }
}

static void mean_row(const job *j, int row, float share)
{
    const daft_tile *tile = &j->s->tile;
    daft_lanes3 *color = &j->s->color;
    const float *sum = j->r->sum + 3 * ((size_t)(tile->y + row) * (size_t)j->snapshot->width + (size_t)tile->x);
    for (int x = 0; x < tile->width; x++) {
        int at = row * DAFT_TILE + x;
        color->x[at] = sum[3 * x] * share, color->y[at] = sum[3 * x + 1] * share, color->z[at] = sum[3 * x + 2] * share;
    }
}

/* A tile that sees nothing but a sky of one colour. */
static bool is_plain(const job *j)
{
    return j->s->points.count == 0 && j->snapshot->sky.kind == DAFT_SKY_COLOR && j->snapshot->samples == 1;
}

static void fill_plain(job *j)
{
    const daft_tile *tile = &j->s->tile;
    daft_lanes3 *color = &j->s->sky_color;
    uint8_t rgba[4];
    j->r->shade->sky(&j->snapshot->sky, &j->s->sky.direction, 1, color);
    j->r->shade->encode(color->x, color->y, color->z, 1, rgba);
    for (int row = 0; row < tile->height; row++) {
        size_t pixel = (size_t)(tile->y + row) * (size_t)j->snapshot->width + (size_t)tile->x;
        uint8_t *to = j->frame->target->pixels + 4 * pixel;
        for (int x = 0; x < tile->width; x++) memcpy(to + 4 * x, rgba, sizeof rgba);
    }
    ran(j, DAFT_EFFECT_SKY);
    ran(j, DAFT_EFFECT_RESOLVE);
    book(j, DAFT_EFFECT_SKY);
}

static void resolve(job *j)
{
    const daft_snapshot *snapshot = j->snapshot;
    const daft_tile *tile = &j->s->tile;
    bool last = j->frame->sample == snapshot->samples - 1;
    const daft_lanes3 *color = snapshot->samples > 1 ? &j->s->color : j->color;
    for (int row = 0; row < tile->height; row++) {
        if (snapshot->samples > 1) add_sample(j, row);
        if (!last) continue;
        if (snapshot->samples > 1) mean_row(j, row, 1 / (float)snapshot->samples);
        int at = row * DAFT_TILE;
        size_t pixel = (size_t)(tile->y + row) * (size_t)snapshot->width + (size_t)tile->x;
        j->r->shade->encode(&color->x[at], &color->y[at], &color->z[at], (uint32_t)tile->width,
                            j->frame->target->pixels + 4 * pixel);
    }
    ran(j, DAFT_EFFECT_RESOLVE);
    book(j, DAFT_EFFECT_RESOLVE);
}

static size_t tile_pixel(const job *j, uint32_t number)
{
    const daft_tile *tile = &j->s->tile;
    size_t x = number % DAFT_TILE, y = number / DAFT_TILE;
    return ((size_t)tile->y + y) * (size_t)j->snapshot->width + (size_t)tile->x + x;
}

static void write_aov(job *j)
{
    const daft_frame_aov *aov = &j->frame->target->aov;
    const daft_scratch *s = j->s;
    if (!aov->depth && !aov->normal && !aov->instance && !aov->triangle) return;
    for (uint32_t i = 0; i < s->sky.count; i++) {
        size_t at = tile_pixel(j, s->sky.pixel[i]);
        if (aov->depth) aov->depth[at] = INFINITY;
        if (aov->normal) aov->normal[at] = daft_v3(0, 0, 0);
        if (aov->instance) aov->instance[at] = DAFT_NOTHING;
        if (aov->triangle) aov->triangle[at] = 0;
    }
    for (uint32_t i = 0; i < s->points.count; i++) {
        uint32_t number = s->points.pixel[i];
        uint32_t place = number / DAFT_TILE * DAFT_TILE_STRIDE + number % DAFT_TILE;
        size_t at = tile_pixel(j, number);
        if (aov->depth) aov->depth[at] = s->points.reach[i];
        if (aov->normal) aov->normal[at] = daft_v3(s->points.normal.x[i], s->points.normal.y[i], s->points.normal.z[i]);
        if (aov->instance) aov->instance[at] = s->tile.instance[place];
        if (aov->triangle) aov->triangle[at] = s->tile.triangle[place];
    }
}

/* The calling thread's tiles tell the user how far the picture is. */
static void report(daft_frame *frame, uint32_t worker)
{
    uint32_t done = atomic_fetch_add(&frame->tiles_done, 1) + 1;
    if (worker != 0 || !frame->target->progress) return;
    float total = (float)frame->tile_count * (float)frame->snapshot->samples;
    if (!frame->target->progress(frame->target->progress_user, (float)done / total)) atomic_store(&frame->cancelled, true);
}

void daft_render_tile(void *context, uint32_t tile, uint32_t worker)
{
    daft_frame *frame = context;
    if (atomic_load_explicit(&frame->cancelled, memory_order_relaxed)) return;
    job j = {frame, frame->renderer, frame->snapshot, &frame->renderer->scratch[worker], tile, worker, NULL, daft_clock_ticks(), {false}};
    const daft_surfaces_def def = {frame->snapshot, &frame->pencil, frame->plan.shadows, frame->target->aov.depth != NULL};
    see(&j, tile, worker);
    j.r->kernels->surfaces(&def, &j.s->tile, &j.s->facets, &j.s->points, &j.s->sky);
    if (j.s->points.count) ran(&j, DAFT_EFFECT_SURFACE);
    if (frame->sample == 0) write_aov(&j);
    book(&j, DAFT_EFFECT_SURFACE);
    if (is_plain(&j)) {
        fill_plain(&j);
    } else {
        shade(&j);
        resolve(&j);
    }
    report(frame, worker);
}
