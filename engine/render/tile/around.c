/* A tile's pixels with those around it, and a tile at work in a pass over a picture that is drawn. */
#include "render/tile/tile.h"

#include <string.h>

/* A copy, for a tile at the border of the picture or the band: beyond the picture or
 * the apron its last pixels again. */
static void gather(const daft_frame *frame, const daft_tile *tile, uint32_t around[2][DAFT_TILE + 2][DAFT_TILE + 2])
{
    const daft_snapshot *s = frame->snapshot;
    const int last_x = s->width - 1, last_y = daft_min_i(s->height, s->first_row + s->row_count + DAFT_TILE) - 1;
    const int first = tile->x > 0 ? -1 : 0, end = daft_min_i(DAFT_TILE + 1, last_x + 1 - tile->x);
    for (int y = -1; y <= DAFT_TILE; y++) {
        const int row = daft_min_i(daft_max_i(tile->y + y, 0), last_y), x = tile->x + first;
        const void *from[2] = {daft_frame_row(frame, row) + 4 * (size_t)x, daft_frame_ids(frame, row) + x};
        for (int k = 0; k < 2; k++) {
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
    if (t->x > 0 && t->x + DAFT_TILE < s->width && t->y > s->first_row &&
        t->y + DAFT_TILE < s->first_row + s->row_count)
        return (daft_neighbours){daft_frame_row(j->frame, t->y) + 4 * (size_t)t->x,
                                 daft_frame_ids(j->frame, t->y) + t->x, s->width, s->width};
    gather(j->frame, t, around);
    return (daft_neighbours){(const uint8_t *)&around[0][1][1], &around[1][1][1], DAFT_TILE + 2, DAFT_TILE + 2};
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
    daft_tile_place(&j.r->raster, j.number, NULL, &j.s->tile);
    return j;
}

/* Four samples after the other share a block of points, by which lights are looked up. */
static uint32_t place_in_batch(uint32_t i)
{
    const uint32_t block = i / 16, row = i / 4 % 4, blocks = DAFT_TILE / 4;
    return (block / blocks * 4 + row) * DAFT_TILE + block % blocks * 4 + i % 4;
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
    fresh->pixel[i] = place_in_batch(i), s->wanted[fresh->pixel[i]] = wanted;
}

void daft_fresh_shade(tile_job *j, const daft_pencil *pencil)
{
    if (!j->s->fresh.count) return;
    daft_tile_surfaces(j, pencil, &j->s->fresh);
    daft_tile_shade(j);
}
