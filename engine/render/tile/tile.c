/* A tile from visibility to bytes. Points are shaded in batches: first what the pixels see, then what mirrors see in
 * it, and so on; each batch runs only the effects that its own points call for. Where a batch sends on both mirrored
 * and refracted rays, these become one batch, if that has room; else the refracted ones wait until the mirrored ones
 * have been followed to their end. */
#include "render/tile/tile.h"

#include <math.h>
#include <string.h>

void daft_tile_see(tile_job *j, daft_tile *out)
{
    daft_scratch *s = j->s;
    s->last_stop.instance = DAFT_NO_LEAF;
    if (j->snapshot->quality.tree != DAFT_TREE_RASTER)
        daft_reference_tile(&j->r->raster, j->frame->tlas, j->number, j->part, out);
    else
        j->r->raster_kernels->tile(&j->r->raster, j->number, j->worker, j->part, out);
    uint64_t rays = j->part ? 0 : (uint64_t)(out->width * out->height);
    for (int y = 0; j->part && y < DAFT_TILE; y++) rays += (uint64_t)__builtin_popcount(j->part->asked[y]);
    s->rays_cast[j->part ? DAFT_EFFECT_ANTIALIASING : DAFT_EFFECT_VISIBILITY] += rays;
    ran(j, DAFT_EFFECT_VISIBILITY);
    book(j, DAFT_EFFECT_VISIBILITY);
}

void daft_tile_see_fine(tile_job *j, daft_fine_tile *out)
{
    daft_scratch *s = j->s;
    s->last_stop.instance = DAFT_NO_LEAF;
    if (j->snapshot->quality.tree != DAFT_TREE_RASTER)
        daft_reference_fine(&j->r->raster, j->frame->tlas, j->number, out);
    else
        j->r->raster_kernels->fine(&j->r->raster, j->number, j->worker, out);
    for (int y = 0; y < DAFT_TILE; y++)
        for (uint32_t left = out->pixels[y]; left; left &= left - 1) {
            const uint32_t pixel = (uint32_t)(y * DAFT_TILE + __builtin_ctz(left)),
                           rays = (uint32_t)__builtin_popcount(out->asked[pixel]);
            s->rays_cast[DAFT_EFFECT_ANTIALIASING] += rays;
            daft_cost_ask(j, pixel, rays);
        }
    ran(j, DAFT_EFFECT_VISIBILITY);
    book(j, DAFT_EFFECT_VISIBILITY);
}

void daft_tile_surfaces(tile_job *j, const daft_pencil *pencil, const daft_seen_list *list)
{
    const daft_frame *frame = j->frame;
    daft_scratch *s = j->s;
    const daft_surfaces_def def = {.snapshot = frame->snapshot,
                                   .pencil = pencil,
                                   .shadows = frame->plan.shadows || frame->plan.occlusion,
                                   .distance = frame->target->aov.depth || frame->target->aov.motion ||
                                               frame->plan.denoise || frame->plan.fog || frame->media};
    if (list)
        j->r->kernels->listed_surfaces(&def, list, &s->facets, &s->points, &s->sky);
    else
        j->r->kernels->surfaces(&def, &s->tile, &s->facets, &s->points, &s->sky);
    if (s->points.count) ran(j, DAFT_EFFECT_SURFACE);
}

static bool is_soft(const tile_job *j, const daft_light_source *light)
{
    return j->frame->plan.soft && light->casts_shadow && (light->area || light->radius > 0);
}

/* Where a batch's points are: a box, and the ball around it. */
typedef struct surroundings {
    daft_vec3 low, high, middle;
    float radius;
} surroundings;

static surroundings where(const tile_job *j, const daft_batch *points)
{
    surroundings w;
    j->r->shade->extent(&points->point, points->count, &w.low, &w.high);
    const daft_vec3 half = daft_scale(daft_sub(w.high, w.low), 0.5f);
    w.middle = daft_add(w.low, half);
    w.radius = sqrtf(daft_dot(half, half));
    return w;
}

static float beyond(float x, float low, float high) { return x < low ? low - x : x > high ? x - high : 0; }

/* Whether some corner of the box may lie on the side to which a rectangle shines. */
static bool is_before(const daft_light_source *light, const surroundings *w)
{
    const daft_vec3 d = light->to_light, p = light->position;
    const daft_vec3 near =
        daft_v3(d.x > 0 ? w->low.x : w->high.x, d.y > 0 ? w->low.y : w->high.y, d.z > 0 ? w->low.z : w->high.z);
    return !(daft_dot(daft_sub(near, p), d) > 1e-6f * (fabsf(p.x) + fabsf(p.y) + fabsf(p.z)));
}

/* False: its range ends, its cone passes or it shines away, before all of the points; by more than roundings. */
static bool may_reach(const daft_light_source *light, const surroundings *w)
{
    const daft_vec3 p = light->position;
    if (light->range > 0) {
        const float x = beyond(p.x, w->low.x, w->high.x), y = beyond(p.y, w->low.y, w->high.y),
                    z = beyond(p.z, w->low.z, w->high.z);
        if (x * x + y * y + z * z > light->range * light->range * 1.0001f) return false;
    }
    if (light->area == DAFT_AREA_RECTANGLE && !is_before(light, w)) return false;
    if (!light->spot || light->cone_cosine <= 0.01f) return true;
    const daft_vec3 to = daft_sub(w->middle, p);
    const float along = -daft_dot(to, light->to_light), length2 = daft_dot(to, to);
    const float across = sqrtf(fmaxf(length2 - along * along, 0)), cosine = light->cone_cosine,
                sine = sqrtf(fmaxf(1 - cosine * cosine, 0));
    const float slack = w->radius * 1.001f + 1e-3f * sqrtf(length2);
    return !(across * cosine - along * sine > slack); /* a NaN may reach */
}

/* A batch's points that glow, as bits, once they are looked for. */
typedef struct glowing {
    bool known;
    uint32_t bits[DAFT_BATCH_WORDS];
} glowing;

static void find_glowing(const tile_job *j, const daft_batch *points, glowing *g)
{
    memset(g->bits, 0, sizeof g->bits);
    for (uint32_t i = 0; i < points->count; i++) {
        const daft_vec3 e = j->snapshot->materials[points->material[i]].emission;
        if (e.x > 0 || e.y > 0 || e.z > 0) g->bits[i / 32] |= 1u << (i % 32);
    }
    g->known = true;
}

/* What glows does not light itself: the stand-in of its shape would, where it lies within. False: no point is left. */
static bool skip_own(const tile_job *j, const daft_batch *points, const daft_light_source *light, glowing *g)
{
    uint32_t *lit = j->s->lit, some = 0;
    if (!g->known) find_glowing(j, points, g);
    for (uint32_t k = 0; k < DAFT_BATCH_WORDS; k++) {
        for (uint32_t left = g->bits[k] & lit[k]; left; left &= left - 1) {
            const uint32_t bit = left & (0 - left), i = 32 * k + (uint32_t)__builtin_ctz(left);
            if (j->snapshot->instances[points->instance[i]].entity == light->entity) lit[k] &= ~bit;
        }
        some |= lit[k];
    }
    return some;
}

/* Pixels a side of what a sample stands for, of which a mask covers a part; 0 where nothing is antialiased. */
static float sample_side(const daft_quality *quality)
{
    if (quality->samples > 1) return 1 / sqrtf((float)quality->samples);
    return quality->edge_samples > 0 ? 1 : 0;
}

/* What the points, `depth` surfaces away, have of their textures and maps. */
static void read_maps(tile_job *j, daft_batch *points, int depth)
{
    const daft_snapshot *snapshot = j->snapshot;
    const daft_plan *plan = &j->frame->plan;
    const bool textured = points->traits & (DAFT_TRAIT_TEXTURE | DAFT_TRAIT_MAPS);
    const daft_vary_def def = {.mirrors = plan->reflects && depth < plan->quality->mirror_depth,
                               .lets_through = plan->refracts && depth < plan->through_depth,
                               .sample_side = sample_side(plan->quality)};
    if (points->traits & DAFT_TRAIT_TEXTURE)
        j->r->shade->albedo(points, snapshot->materials, snapshot->textures, j->frame->texture_filter);
    if (points->traits & DAFT_TRAIT_VARIES)
        j->r->shade->vary(points, snapshot->materials, snapshot->textures, j->frame->texture_filter, &def);
    if (textured) ran(j, DAFT_EFFECT_TEXTURE);
    book(j, textured ? DAFT_EFFECT_TEXTURE : DAFT_EFFECT_SURFACE);
}

/* Whether to look first which points send on some of a light: what does nearly always sends rays on. */
static bool asks_shadows(const tile_job *j, const daft_batch *points, const daft_light_source *light)
{
    return points->traits & DAFT_TRAIT_SENDS && light->casts_shadow && j->frame->plan.shadows && !light->area;
}

/* Points `depth` surfaces away: those of 0 are seen by pixels themselves, and their sampled light may be filtered. */
static void light_points(tile_job *j, daft_batch *points, int depth)
{
    const daft_snapshot *snapshot = j->snapshot;
    const bool seen = depth == 0;
    const daft_ambient *first = &snapshot->ambient;
    if (j->s->sampled) {
        j->s->sampled->some = j->s->sampled->kept = false, j->s->sampled->candidates.lights = 0;
        j->s->sampled->recalls = j->refines && j->frame->plan.denoise;
        if (j->s->sampled->recalls) daft_denoise_recall(j, points, seen);
    }
    if (points->traits & (DAFT_TRAIT_TEXTURE | DAFT_TRAIT_VARIES)) read_maps(j, points, depth);
    if (j->frame->plan.occlusion && points->count) daft_tile_occlusion(j, points), first = NULL;
    const surroundings around = where(j, points);
    if (j->frame->media) daft_media_begin(j, points, depth);
    daft_redraw_points(j, points, seen);
    glowing glow;
    glow.known = false;
    for (uint32_t i = 0; i < snapshot->light_count; i++) {
        const daft_light_source *light = &snapshot->lights[i];
        if (!may_reach(light, &around)) continue;
        if (j->r->shade->facing(points, light, j->s->lit) == 0) continue;
        if (light->bounded && !skip_own(j, points, light, &glow)) continue;
        daft_tile_skip_holes(points, j->s->lit);
        if (asks_shadows(j, points, light) && !j->r->shade->skip_dark(points, snapshot->materials, light, j->s->lit))
            continue;
        ran(j, DAFT_EFFECT_LIGHTING);
        book(j, DAFT_EFFECT_LIGHTING);
        const bool soft = is_soft(j, light);
        if (j->frame->plan.shadows && light->casts_shadow && !soft) daft_tile_shadows(j, points, light);
        const daft_lanes3 *passed =
            j->frame->plan.tints && light->casts_shadow ? daft_tile_tints(j, points, light) : NULL;
        if (j->frame->plan.filters && light->casts_shadow && !soft)
            passed = daft_tile_filters(j, points, light, passed);
        if (j->s->sampled && (!soft || first)) j->s->sampled->kept = false;
        if (soft && first) j->r->shade->ambient(points, snapshot->materials, first);
        if (soft)
            daft_tile_soft_light(j, points, i, passed);
        else
            j->r->shade->direct_light(points, snapshot->materials, light, j->s->lit, passed, first);
        first = NULL;
    }
    if (j->s->sampled) daft_tile_ask_lights(j, points);
    if (first) j->r->shade->ambient(points, snapshot->materials, first);
    if (j->frame->media) daft_media_end(j, points, depth);
    if (seen && j->frame->plan.fog) daft_fog_points(j, points);
    const bool sampled = j->s->sampled && j->s->sampled->some, filtered = j->frame->plan.denoise && !j->refines;
    if (sampled && filtered) daft_denoise_take(j, points, seen);
    if (sampled && !filtered) daft_tile_add_sampled(j->s->sampled, points);
    book(j, DAFT_EFFECT_LIGHTING);
}

/* What the pixels see without anything that is sent on. A tile full of surfaces has its points in the pixels' order,
 * and their light is the picture. */
static void shade_visible(tile_job *j)
{
    daft_scratch *s = j->s;
    const daft_shade_kernels *kernels = j->r->shade;
    daft_batch *points = &s->points;
    const daft_ray_batch *sky = &s->sky;
    if (points->count) light_points(j, points, 0);
    daft_tile_aov_albedo(j);
    if (j->frame->keeps_own && !j->refines) daft_tile_keep_own(j);
    if (!j->refines && sky->count == 0 && s->tile.width == DAFT_TILE && !(points->traits & DAFT_TRAIT_SENDS)) {
        j->color = &points->light;
        return;
    }
    j->color = &s->color;
    if (points->count) kernels->scatter(&s->color, points->pixel, points->count, &points->light);
    book(j, DAFT_EFFECT_LIGHTING);
    if (sky->count == 0) return;
    kernels->sky(&j->snapshot->sky, &sky->direction, sky->count, &s->sky_color);
    if (j->frame->plan.fog) daft_fog_sky(j);
    kernels->scatter(&s->color, sky->pixel, sky->count, &s->sky_color);
    ran(j, DAFT_EFFECT_SKY);
    book(j, DAFT_EFFECT_SKY);
}

/* By which mirrors pixels see what their points mirror; gives those whose views are drawn, as bits. */
static uint32_t look_through(const tile_job *j, const daft_batch *points, const daft_ray_batch *sent)
{
    daft_scratch *s = j->s;
    if (!j->frame->mirror_count || j->refines) return 0;
    daft_mirrors_follow(j->frame, points, s->seen_by);
    return daft_mirrors_tile(j->frame, j->number, j->worker, s->seen_by, sent);
}

static void look_by_rays(const tile_job *j, const daft_ray_batch *sent)
{
    if (!j->frame->mirror_count || j->refines) return;
    for (uint32_t i = 0; i < sent->count; i++) j->s->seen_by[sent->pixel[i]] = DAFT_SEEN_BY_RAYS;
}

/* The first rays of rough surfaces: recorded for the filter, or, once it has run, replaced by what it found. */
static void separate_gloss(const tile_job *j)
{
    daft_scratch *s = j->s;
    const int lists = j->frame->plan.refracts ? j->frame->plan.through_lists : 0;
    for (int i = -1; i < lists; i++) {
        daft_ray_batch *rays = i < 0 ? &s->rays : &s->refracted[i];
        if (j->refines)
            daft_gloss_replace(j, rays);
        else
            daft_gloss_send(j, rays);
    }
}

/* What the pixels' points send on, to its end; of rough ones ray number `ray` of `rays`. */
static void follow(tile_job *j, uint32_t ray, uint32_t rays)
{
    daft_scratch *s = j->s;
    daft_batch *points = &s->points, *next = &s->next, *other = rays > 1 ? s->third : &s->points;
    daft_gloss *gloss = j->refines ? NULL : s->gloss;
    if (j->frame->mirror_count) memset(s->seen_by, DAFT_SEEN_BY_CAMERA, sizeof s->seen_by);
    for (int depth = 0;; depth++) {
        if (depth && points->count) {
            light_points(j, points, depth);
            j->r->shade->scatter_add(&s->color, points->pixel, points->count, &points->weight, &points->light);
        }
        daft_tile_spawn(j, points, depth, ray, rays);
        if (depth == 0 && s->gloss && s->gloss->some) separate_gloss(j);
        const uint32_t mirrored = s->rays.count;
        uint32_t shown = 0;
        daft_ray_batch *sent = mirrored ? &s->rays : daft_tile_waiting(j, &depth);
        if (!sent) return;
        if (mirrored) shown = look_through(j, points, sent);
        daft_ray_batch *both = mirrored && !shown ? daft_tile_join(j, depth) : NULL;
        if (both) sent = both;
        if (sent != &s->rays) look_by_rays(j, sent);
        if (gloss) gloss->asks = gloss->some && depth == 0;
        daft_redraw_rays(j, sent, depth);
        daft_tile_trace(j, sent, mirrored, shown, next);
        if (gloss) gloss->asks = false;
        if (sent != &s->rays) sent->count = 0;
        daft_tile_add_sky(j, &s->sky);
        daft_batch *done = points == &s->points ? other : points;
        points = next, next = done;
    }
}

void daft_tile_shade(tile_job *j)
{
    const daft_batch *points = &j->s->points;
    const bool rough = points->traits & DAFT_TRAIT_ROUGH && j->frame->plan.glossy;
    const uint32_t rays = rough ? (uint32_t)j->snapshot->quality.glossy_samples : 1;
    shade_visible(j);
    if (j->s->gloss && j->refines)
        daft_gloss_recall(j, points);
    else if (j->s->gloss && rough)
        daft_gloss_begin(j, points);
    for (uint32_t ray = 0; ray < rays; ray++) follow(j, ray, rays);
}

/* For the comparison of neighbours, once all tiles are drawn. */
static void keep_seen(const tile_job *j)
{
    const daft_tile *tile = &j->s->tile;
    const bool above = tile->y < j->snapshot->first_row,
               below = tile->y >= j->snapshot->first_row + j->snapshot->row_count;
    j->r->kernels->ids(tile, daft_frame_ids(j->frame, tile->y) + tile->x, (size_t)j->snapshot->width);
    if (!above && !below) j->r->edges[j->number - j->frame->band_tile].sky = j->s->points.count == 0;
}

/* The calling thread's tiles tell the user how far the picture is. */
void daft_tile_report(daft_frame *frame, uint32_t worker)
{
    uint32_t done = atomic_fetch_add(&frame->tiles_done, 1) + 1;
    if (worker != 0 || !frame->target->progress) return;
    if (!frame->target->progress(frame->target->progress_user, (float)done / (float)frame->tiles_in_all))
        atomic_store(&frame->cancelled, true);
}

void daft_render_tile(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    if (atomic_load_explicit(&frame->cancelled, memory_order_relaxed)) return;
    tile_job j = {.frame = frame,
                  .r = frame->renderer,
                  .snapshot = frame->snapshot,
                  .s = &frame->renderer->scratch[worker],
                  .number = frame->tiles ? frame->tiles[index] : frame->first_tile + index,
                  .worker = worker,
                  .since = daft_clock_ticks()};
    daft_redraw_tile(&j);
    if (frame->plan.denoise) daft_denoise_begin(&j);
    if (j.s->gloss) j.s->gloss->some = j.s->gloss->asks = false;
    daft_tile_see(&j, &j.s->tile);
    daft_tile_surfaces(&j, &frame->pencil, NULL);
    if (frame->sample == 0) daft_tile_aov(&j);
    daft_cost_see(&j);
    if (frame->plan.denoise) daft_denoise_see(&j);
    if (frame->edge_scale) keep_seen(&j);
    book(&j, DAFT_EFFECT_SURFACE);
    if (daft_tile_is_plain(&j)) {
        daft_tile_fill_plain(&j);
    } else {
        daft_tile_shade(&j);
        if (!frame->plan.denoise || !daft_denoise_keep(&j)) daft_tile_resolve(&j);
    }
    daft_tile_report(frame, worker);
}
