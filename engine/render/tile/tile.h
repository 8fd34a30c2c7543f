/* A tile at work, and its stages in their order. Each reads what the one before it wrote into the worker's scratch.
 * Public headers: none */
#ifndef DAFT_RENDER_TILE_TILE_H
#define DAFT_RENDER_TILE_TILE_H

#include "render/internal.h"

typedef struct tile_job {
    const daft_frame *frame;
    const daft_renderer *r;
    const daft_snapshot *snapshot;
    daft_scratch *s;
    uint32_t number, worker;    /* of the tile */
    bool refines;               /* more samples of some pixels; all that it takes is booked on these */
    const daft_tile_part *part; /* of the tile that these are in */
    const daft_lanes3 *color;   /* of the tile's pixels, in the end */
    uint64_t since;             /* when the running effect began */
    bool ran[DAFT_EFFECT_COUNT];
} tile_job;

/* Books the time since the last call on an effect. */
static inline void book(tile_job *j, daft_effect_kind effect)
{
    if (j->refines) effect = DAFT_EFFECT_ANTIALIASING;
    uint64_t now = daft_clock_ticks();
    if (now > j->since) j->s->ticks[effect] += now - j->since;
    j->since = now;
}

/* The same for two that ran together: `part` of `all` is the first one's. */
static inline void book_both(tile_job *j, daft_effect_kind first, daft_effect_kind second, uint32_t part, uint32_t all)
{
    const uint64_t before = j->s->ticks[second], taken = j->refines ? 0 : part;
    book(j, second);
    const uint64_t moved = all ? (j->s->ticks[second] - before) * taken / all : 0;
    j->s->ticks[second] -= moved, j->s->ticks[first] += moved;
}

static inline void ran(tile_job *j, daft_effect_kind effect)
{
    if (j->refines) effect = DAFT_EFFECT_ANTIALIASING;
    if (!j->ran[effect]) j->s->tiles[effect]++;
    j->ran[effect] = true;
}

/* tile.c: what the pixels see; their points, or those of a list, by rays of the pencil; and their light, in j->color.
 */
void daft_tile_see(tile_job *j, daft_tile *out);
/* The rays that `out` asks for. */
void daft_tile_see_fine(tile_job *j, daft_fine_tile *out);
void daft_tile_surfaces(tile_job *j, const daft_pencil *pencil, const daft_seen_list *list);
void daft_tile_shade(tile_job *j);
/* Tells the user how far the picture is, and whether to go on. */
void daft_tile_report(daft_frame *frame, uint32_t worker);
/* shadows.c: takes away the bits s->lit of the points that are hidden from the light. */
void daft_tile_shadows(tile_job *j, const daft_batch *points, const daft_light_source *light);
/* soft.c: light that is sampled, in s->sampled: the ambient light, as far as points see their surroundings, after which
 * points have the light of their own; lights that have a size, for the points of s->lit, which are asked for all at
 * once; and all of what arrives, to the points' own light. */
void daft_tile_occlusion(tile_job *j, daft_batch *points);
void daft_tile_soft_light(tile_job *j, daft_batch *points, uint32_t number, const daft_lanes3 *passed);
void daft_tile_ask_lights(tile_job *j, const daft_batch *points);
void daft_tile_add_sampled(const daft_sampled_light *sampled, daft_batch *points);
/* And where shadows are sharp: the ray from a point to the light, of an area to its middle or, where that is not before
 * the point, to what little is. False: there is none. */
bool daft_tile_sharp_ray(const daft_batch *points, uint32_t i, const daft_light_source *light, daft_ray *ray);
/* denoise.c: of a tile nothing is sampled yet; what its pixels see; the sampled light of a batch, which pixels see
 * themselves or on a way of some weight; and the light of the rest. False: there is nothing to wait for. */
void daft_denoise_begin(const tile_job *j);
void daft_denoise_see(const tile_job *j);
void daft_denoise_take(const tile_job *j, daft_batch *points, bool seen);
bool daft_denoise_keep(const tile_job *j);
/* Of more samples of some pixels, once the picture is filtered: what pixels like them found, into s->sampled; of
 * points that mirrors and glass show, what the pixel itself did. */
void daft_denoise_recall(const tile_job *j, const daft_batch *points, bool seen);
/* The same for what a rough point shows: the light along rays of weight 1. False: no pixel around is like it. */
bool daft_denoise_recall_gloss(const tile_job *j, const daft_batch *points, uint32_t i, float light[3]);
/* gloss.c: what rough surfaces send on, of a tile whose pixels see some: their light so far is all that is sharp; the
 * rays that these pixels have sent; and what the rays met. Only where the frame filters it (s->gloss). */
void daft_gloss_begin(const tile_job *j, const daft_batch *points);
void daft_gloss_send(const tile_job *j, const daft_ray_batch *rays);
void daft_gloss_meet(const tile_job *j, const daft_ray_batch *rays, uint32_t first, const daft_hit *hits,
                     uint32_t count);
/* While edges get more samples: looks up the filtered light of pixels like the batch's rough points; replaces the first
 * rays of those that have some. */
void daft_gloss_recall(const tile_job *j, const daft_batch *points);
void daft_gloss_replace(const tile_job *j, daft_ray_batch *rays);
static inline bool daft_gloss_is_rough(const daft_gloss *gloss, uint32_t pixel)
{
    return gloss && gloss->some && gloss->rough[pixel / 32] >> (pixel % 32) & 1;
}
/* reach.c: what a tile tells of itself, so that the next picture knows what may change it: that it is drawn anew;
 * where points are that are lit, which pixels see themselves or others do; the rays that points so many surfaces away
 * send on.
 */
void daft_redraw_tile(const tile_job *j);
void daft_redraw_points(const tile_job *j, const daft_batch *points, bool seen);
void daft_redraw_rays(const tile_job *j, const daft_ray_batch *rays, int depth);
/* The fraction of the light that arrives through what transmits, once for each instance in between, however thick.
 * NULL: nothing is in between. */
const daft_lanes3 *daft_tile_tints(tile_job *j, const daft_batch *points, const daft_light_source *light);
/* opacity.c: of surfaces with alpha. The fraction of light that comes through them along a ray from point i. The same
 * for points of s->lit and one light: those that get none lose their bits; `passed`: the fraction of those that get
 * some, as daft_tile_tints gave it, or NULL. Only where the plan has some. And takes the bits of points at which
 * nothing is there. */
daft_vec3 daft_tile_filtered(tile_job *j, const daft_batch *points, uint32_t i, const daft_ray *ray);
const daft_lanes3 *daft_tile_filters(tile_job *j, const daft_batch *points, const daft_light_source *light,
                                     const daft_lanes3 *passed);
void daft_tile_skip_holes(const daft_batch *points, uint32_t *bits);
/* secondary.c: the rays that points `depth` surfaces away send on, into s->rays, and the lists of s->refracted for this
 * depth where some let light through; of rough ones that pixels see number `ray` of `rays`. */
void daft_tile_spawn(tile_job *j, const daft_batch *points, int depth, uint32_t ray, uint32_t rays);
/* Appends the mirrored rays to the refracted ones that wait at this depth, if there are some and these have room, and
 * gives those; else NULL. */
daft_ray_batch *daft_tile_join(const tile_job *j, int depth);
/* Traces rays, `mirrored` of them mirrored and the rest refracted, of which fog takes weight: hits become the batch
 * `next`, misses see s->sky. `shown`: bits of the planar mirrors that know their rays' hits. */
void daft_tile_trace(tile_job *j, daft_ray_batch *rays, uint32_t mirrored, uint32_t shown, daft_batch *next);
/* Adds the sky along rays that meet nothing. */
void daft_tile_add_sky(tile_job *j, const daft_ray_batch *rays);
/* The deepest of the refracted rays that wait for points at `depth` or less to be done, whose depth this becomes.
 * Deeper ones have been followed, so the lists of each depth are room enough. NULL: none. */
daft_ray_batch *daft_tile_waiting(const tile_job *j, int *depth);
/* media.c: of points so many surfaces away, before their light is known: the media they are seen from; and after it:
 * what they cross, and the loss on the way from the camera. Of traced rays first..: what media take from their weight
 * up to their hits. Only where rays carry media (frame->media). */
void daft_media_begin(const tile_job *j, daft_batch *points, int depth);
void daft_media_end(const tile_job *j, daft_batch *points, int depth);
void daft_media_absorb(const tile_job *j, daft_ray_batch *rays, uint32_t first, const daft_hit *hits, uint32_t count);
/* Adds the bits of points that lie in what absorbs; false: none does. What the media on the way to a light take, of the
 * points of s->lit and of `bits`. */
bool daft_media_hold_points(const tile_job *j, const daft_batch *points, uint32_t *bits);
void daft_media_dim(const tile_job *j, const daft_batch *points, const daft_light_source *light, const uint32_t *bits,
                    daft_lanes3 *passed);
/* fog.c: on the way from the camera to a batch's points, whose weight becomes what comes through; to the sky, whose
 * light is in s->sky_color; and along traced rays first.. to their hits. Only where the frame has some. */
void daft_fog_points(tile_job *j, daft_batch *points);
void daft_fog_sky(tile_job *j);
void daft_fog_rays(tile_job *j, daft_ray_batch *rays, uint32_t first, const daft_hit *hits, uint32_t count);
/* resolve.c: j->color into the picture's bytes, over all samples; or as it is. */
void daft_tile_resolve(tile_job *j);
void daft_tile_show(tile_job *j);
/* The bytes of a tile that sees nothing but a sky of one colour. */
bool daft_tile_is_plain(const tile_job *j);
void daft_tile_fill_plain(tile_job *j);
/* around.c: a tile of a picture that is drawn; its pixels and those around it; and single samples of it that are to be
 * shaded: the ray at a place in the tile, and the number under which its light is wanted. Their light is in j->color,
 * at s->fresh.pixel. */
tile_job daft_tile_again(daft_frame *frame, uint32_t index, uint32_t worker);
daft_neighbours daft_tile_neighbours(const tile_job *j);
/* Keeps what textures give the points that pixels see, once they are read. */
void daft_tile_keep_own(tile_job *j);
void daft_fresh_add(tile_job *j, const daft_pencil *pencil, const daft_tile *tile, uint32_t place, uint32_t wanted);
void daft_fresh_shade(tile_job *j, const daft_pencil *pencil);
/* aov.c: what the caller asked for beside the picture's bytes: of the first sample what is seen and, once textures are
 * read, its own colour; the light of each sample. */
void daft_tile_aov(tile_job *j);
void daft_tile_aov_albedo(const tile_job *j);
void daft_tile_aov_color(const tile_job *j);
/* Rays that are cast, counted for the pixel that they serve: one for each of a batch's points, for those of which a bit
 * is set; the camera's; some for a pixel by its place in the tile. */
void daft_cost_add(const tile_job *j, const uint32_t *pixels, uint32_t count);
void daft_cost_add_some(const tile_job *j, const uint32_t *pixels, const uint32_t *bits, uint32_t count);
void daft_cost_see(const tile_job *j);
void daft_cost_ask(const tile_job *j, uint32_t pixel, uint32_t rays);

#endif
