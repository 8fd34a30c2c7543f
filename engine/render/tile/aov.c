/* Depth, normals and ids of the tile's pixels. */
#include "render/tile/tile.h"

static size_t tile_pixel(const tile_job *j, uint32_t number)
{
    const daft_tile *tile = &j->s->tile;
    size_t x = number % DAFT_TILE, y = number / DAFT_TILE;
    return ((size_t)tile->y + y) * (size_t)j->snapshot->width + (size_t)tile->x + x;
}

void daft_tile_aov(tile_job *j)
{
    const daft_frame_aov *aov = &j->frame->target->aov;
    const daft_scratch *s = j->s;
    if (!aov->depth && !aov->normal && !aov->instance && !aov->triangle) return;
    if (s->tile.y < j->snapshot->first_row || s->tile.y >= j->snapshot->first_row + j->snapshot->row_count) return;
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
        if (aov->depth) aov->depth[at] = s->points.distance[i];
        if (aov->normal) aov->normal[at] = daft_v3(s->points.normal.x[i], s->points.normal.y[i], s->points.normal.z[i]);
        if (aov->instance) aov->instance[at] = s->tile.instance[place];
        if (aov->triangle) aov->triangle[at] = s->tile.triangle[place];
    }
}
