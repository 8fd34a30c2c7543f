/* Channels of the tile's pixels beside their bytes. */
#include "render/tile/tile.h"

#include <math.h>

/* The tile's corner in the picture; s->tile may be a part of it. */
static size_t left_of(const tile_job *j) { return j->number % daft_tile_columns(j->snapshot) * DAFT_TILE; }
static size_t top_of(const tile_job *j) { return j->number / daft_tile_columns(j->snapshot) * DAFT_TILE; }

static size_t tile_pixel(const tile_job *j, uint32_t number)
{
    const size_t x = left_of(j) + number % DAFT_TILE, y = top_of(j) + number / DAFT_TILE;
    return y * (size_t)j->snapshot->width + x;
}

/* Of tiles above and below the band nothing is told. */
static bool in_band(const tile_job *j)
{
    const daft_snapshot *s = j->snapshot;
    const size_t top = top_of(j), first = (size_t)s->first_row;
    return top >= first && top < first + (size_t)s->row_count;
}

/* What a pixel sees of what is a distance along its ray, or of the sky's direction, and what the picture before saw of
 * it. The same sums for both, so that what has not moved has not moved by a bit. */
static daft_vec2 motion_of(const tile_job *j, uint32_t number, uint32_t instance, float distance)
{
    const daft_snapshot *s = j->snapshot;
    const daft_tile *tile = &j->s->tile;
    const daft_vec3 ray =
        daft_pencil_ray(&j->frame->pencil, tile->x + (int)(number % DAFT_TILE), tile->y + (int)(number / DAFT_TILE));
    const bool sky = instance == DAFT_NOTHING;
    const float length = sky ? 1 : distance / sqrtf(daft_dot(ray, ray));
    daft_vec3 p =
        daft_add(daft_add(daft_scale(s->right, ray.x), daft_scale(s->up, ray.y)), daft_scale(s->forward, ray.z));
    p = daft_scale(p, length);
    const daft_affine *map = &s->before[sky ? s->instance_count : instance];
    const daft_affine now = {
        .m = {s->right.x, s->right.y, s->right.z, s->up.x, s->up.y, s->up.z, s->forward.x, s->forward.y, s->forward.z}};
    const daft_vec3 here = daft_affine_point(&now, p), then = daft_affine_point(map, p);
    if (!(then.z > 0) || !(here.z > 0)) return (daft_vec2){0, 0};
    const float x = here.x / here.z * s->focal - then.x / then.z * s->before_focal,
                y = then.y / then.z * s->before_focal - here.y / here.z * s->focal;
    return isfinite(x) && isfinite(y) ? (daft_vec2){x, y} : (daft_vec2){0, 0};
}

void daft_tile_aov(tile_job *j)
{
    const daft_frame_aov *aov = &j->frame->target->aov;
    const daft_scratch *s = j->s;
    const bool moves = aov->motion && j->snapshot->before;
    const bool any = aov->depth || aov->normal || aov->instance || aov->triangle || aov->albedo || aov->motion;
    if (!any || !in_band(j)) return;
    for (uint32_t i = 0; i < s->sky.count; i++) {
        size_t at = tile_pixel(j, s->sky.pixel[i]);
        if (aov->depth) aov->depth[at] = INFINITY;
        if (aov->normal) aov->normal[at] = daft_v3(0, 0, 0);
        if (aov->instance) aov->instance[at] = DAFT_NOTHING;
        if (aov->triangle) aov->triangle[at] = 0;
        if (aov->albedo) aov->albedo[at] = daft_v3(0, 0, 0);
        if (aov->motion) aov->motion[at] = moves ? motion_of(j, s->sky.pixel[i], DAFT_NOTHING, 0) : (daft_vec2){0, 0};
    }
    for (uint32_t i = 0; i < s->points.count; i++) {
        uint32_t number = s->points.pixel[i];
        uint32_t place = number / DAFT_TILE * DAFT_TILE_STRIDE + number % DAFT_TILE;
        size_t at = tile_pixel(j, number);
        if (aov->depth) aov->depth[at] = s->points.distance[i];
        if (aov->normal) aov->normal[at] = daft_v3(s->points.normal.x[i], s->points.normal.y[i], s->points.normal.z[i]);
        if (aov->instance) aov->instance[at] = s->tile.instance[place];
        if (aov->triangle) aov->triangle[at] = s->tile.triangle[place];
        if (aov->motion)
            aov->motion[at] =
                moves ? motion_of(j, number, s->points.instance[i], s->points.distance[i]) : (daft_vec2){0, 0};
    }
}

void daft_tile_aov_albedo(const tile_job *j)
{
    const daft_frame_aov *aov = &j->frame->target->aov;
    const daft_batch *b = &j->s->points;
    if (!aov->albedo || j->refines || j->frame->sample > 0 || !in_band(j)) return;
    for (uint32_t i = 0; i < b->count; i++) {
        daft_vec3 own = j->snapshot->materials[b->material[i]].diffuse;
        if (b->traits & (DAFT_TRAIT_TEXTURE | DAFT_TRAIT_COLORS))
            own = daft_v3(own.x * b->albedo.x[i], own.y * b->albedo.y[i], own.z * b->albedo.z[i]);
        aov->albedo[tile_pixel(j, b->pixel[i])] = own;
    }
}

void daft_tile_aov_color(const tile_job *j)
{
    daft_vec3 *out = j->frame->target->aov.color;
    const daft_tile *tile = &j->s->tile;
    const bool all = j->frame->plan.denoise; /* the samples' light comes together */
    const float weight = all ? 1 : 1 / (float)j->snapshot->quality.samples;
    if (!out || !in_band(j)) return;
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) {
            const uint32_t number = (uint32_t)(y * DAFT_TILE + x);
            daft_vec3 *at = &out[tile_pixel(j, number)];
            const daft_vec3 light =
                daft_scale(daft_v3(j->color->x[number], j->color->y[number], j->color->z[number]), weight);
            *at = j->frame->sample && !all ? daft_add(*at, light) : light;
        }
}

/* ---- cost ---- */

void daft_cost_add(const tile_job *j, const uint32_t *pixels, uint32_t count)
{
    uint32_t *cost = j->frame->target->aov.cost;
    if (!cost || !in_band(j)) return;
    for (uint32_t i = 0; i < count; i++) cost[tile_pixel(j, j->refines ? j->s->wanted[pixels[i]] : pixels[i])]++;
}

void daft_cost_add_some(const tile_job *j, const uint32_t *pixels, const uint32_t *bits, uint32_t count)
{
    if (!j->frame->target->aov.cost) return;
    for (uint32_t i = 0; i < count; i++)
        if (bits[i / 32] >> (i % 32) & 1) daft_cost_add(j, &pixels[i], 1);
}

void daft_cost_see(const tile_job *j)
{
    uint32_t *cost = j->frame->target->aov.cost;
    const daft_tile *tile = &j->s->tile;
    if (!cost || j->refines || !in_band(j)) return;
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) {
            uint32_t *at = &cost[tile_pixel(j, (uint32_t)(y * DAFT_TILE + x))];
            *at = (j->frame->sample ? *at : 0) + 1;
        }
}

void daft_cost_ask(const tile_job *j, uint32_t pixel, uint32_t rays)
{
    uint32_t *cost = j->frame->target->aov.cost;
    if (cost && in_band(j)) cost[tile_pixel(j, pixel)] += rays;
}
