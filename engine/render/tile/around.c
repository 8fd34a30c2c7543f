/* A tile's pixels with those around it, and a tile at work in a pass over a picture that is drawn. */
#include "render/tile/tile.h"

#include <math.h>
#include <string.h>

/* A copy, for a tile at the border of the picture or the band: beyond the picture or
 * the apron its last pixels again. */
static void gather(const daft_frame *frame, const daft_tile *tile, uint32_t around[3][DAFT_TILE + 2][DAFT_TILE + 2])
{
    const daft_snapshot *s = frame->snapshot;
    const int last_x = s->width - 1, last_y = daft_min_i(s->height, s->first_row + s->row_count + DAFT_TILE) - 1;
    const int first = tile->x > 0 ? -1 : 0, end = daft_min_i(DAFT_TILE + 1, last_x + 1 - tile->x);
    for (int y = -1; y <= DAFT_TILE; y++) {
        const int row = daft_min_i(daft_max_i(tile->y + y, 0), last_y), x = tile->x + first;
        const bool own = frame->keeps_own;
        const void *from[3] = {daft_frame_row(frame, row) + 4 * (size_t)x, daft_frame_ids(frame, row) + x,
                               own ? daft_frame_own(frame, row) + x : NULL};
        for (int k = 0; k < 2 + own; k++) {
            uint32_t *to = around[k][y + 1];
            memcpy(&to[first + 1], from[k], 4 * (size_t)(end - first));
            if (first == 0) to[0] = to[1];
            for (int column = end; column <= DAFT_TILE; column++) to[column + 1] = to[end];
        }
    }
}

daft_neighbours daft_tile_neighbours(const tile_job *j)
{
    const daft_tile *t = &j->s->tile;
    const daft_snapshot *s = j->snapshot;
    uint32_t(*around)[DAFT_TILE + 2][DAFT_TILE + 2] = j->s->around;
    const bool own = j->frame->keeps_own;
    if (t->x > 0 && t->x + DAFT_TILE < s->width && t->y > s->first_row &&
        t->y + DAFT_TILE < s->first_row + s->row_count)
        return (daft_neighbours){daft_frame_row(j->frame, t->y) + 4 * (size_t)t->x,
                                 daft_frame_ids(j->frame, t->y) + t->x,
                                 own ? daft_frame_own(j->frame, t->y) + t->x : NULL, s->width, s->width};
    gather(j->frame, t, around);
    return (daft_neighbours){(const uint8_t *)&around[0][1][1], &around[1][1][1], own ? &around[2][1][1] : NULL,
                             DAFT_TILE + 2, DAFT_TILE + 2};
}

/* Of white light, what a surface with a texture mirrors before that shows as much as the texture does. */
#define MIRRORED 0.2f

static uint32_t kind_of(const daft_surface *s)
{
    const uint32_t traits = daft_surface_traits(s);
    const float most = fmaxf(s->mirror.x, fmaxf(s->mirror.y, s->mirror.z));
    if (s->transmission > 0) return DAFT_OWN_PASSES;
    if (traits & DAFT_TRAIT_TEXTURE) return most > MIRRORED ? DAFT_OWN_MIRRORS : DAFT_OWN_TEXTURED;
    return traits & DAFT_TRAIT_SENDS ? DAFT_OWN_MIRRORS : DAFT_OWN_MATTE;
}

/* How many points from i on are of one material, and of neighbours in a row. */
static uint32_t run_of(const daft_batch *b, uint32_t i)
{
    const uint32_t first = b->pixel[i], most = daft_min_u(b->count - i, DAFT_TILE - first % DAFT_TILE);
    uint32_t count = 1;
    while (count < most && b->pixel[i + count] == first + count && b->material[i + count] == b->material[i]) count++;
    return count;
}

void daft_tile_keep_own(tile_job *j)
{
    const daft_tile *tile = &j->s->tile;
    const daft_batch *b = &j->s->points;
    const size_t width = (size_t)j->snapshot->width;
    uint32_t *own = daft_frame_own(j->frame, tile->y) + tile->x, words[DAFT_BATCH];
    if (b->traits & DAFT_TRAIT_TEXTURE)
        j->r->shade->encode(b->albedo.x, b->albedo.y, b->albedo.z, b->count, (uint8_t *)words);
    else
        memset(words, 0xff, b->count * sizeof *words);
    for (uint32_t i = 0, count; i < b->count; i += count) {
        const uint32_t kind = kind_of(&j->snapshot->materials[b->material[i]]) << 24, pixel = b->pixel[i];
        uint32_t *to = &own[pixel / DAFT_TILE * width + pixel % DAFT_TILE];
        count = run_of(b, i);
        for (uint32_t k = 0; k < count; k++) to[k] = (words[i + k] & 0xffffff) | kind;
    }
    book(j, DAFT_EFFECT_ANTIALIASING);
}

tile_job daft_tile_again(daft_frame *frame, uint32_t index, uint32_t worker)
{
    tile_job j = {.frame = frame,
                  .r = frame->renderer,
                  .snapshot = frame->snapshot,
                  .s = &frame->renderer->scratch[worker],
                  .number = frame->first_tile + index,
                  .worker = worker,
                  .refines = true,
                  .since = daft_clock_ticks()};
    daft_tile_place(&j.r->raster, j.number, &j.s->tile);
    return j;
}

void daft_fresh_add(tile_job *j, const daft_pencil *pencil, const daft_tile *tile, uint32_t place, uint32_t wanted)
{
    daft_scratch *s = j->s;
    daft_seen_list *fresh = &s->fresh;
    const uint32_t i = fresh->count++;
    const int x = tile->x + (int)(place % DAFT_TILE_STRIDE), y = tile->y + (int)(place / DAFT_TILE_STRIDE);
    const daft_vec3 ray = daft_pencil_ray(pencil, x, y);
    fresh->x[i] = ray.x, fresh->y[i] = ray.y;
    fresh->instance[i] = tile->instance[place], fresh->triangle[i] = tile->triangle[place];
    fresh->pixel[i] = daft_place_in_batch(i), s->wanted[fresh->pixel[i]] = wanted;
}

void daft_fresh_shade(tile_job *j, const daft_pencil *pencil)
{
    if (!j->s->fresh.count) return;
    daft_tile_surfaces(j, pencil, &j->s->fresh);
    daft_tile_shade(j);
}
