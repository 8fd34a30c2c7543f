/* Temporal reuse: what the picture before found of sampled light is carried along (Schied and others, "Spatiotemporal
 * Variance-Guided Filtering", HPG 2017, section 4.1). Each pixel looks where the picture before saw its point: among
 * the four pixels around that place those count that saw the same instance as far away. Their mean becomes part of the
 * pixel's own, the more the longer it has been gathered; a point that was hidden or out of the picture begins anew. */
#include "render/denoise.h"

#include <string.h>

bool daft_past_prepare(daft_past *past, const daft_allocator *allocator, const daft_snapshot *s, const daft_grid *grid,
                       daft_error *error)
{
    const int width = (int)daft_tile_columns(s) * grid->tile,
              height = (s->height + DAFT_TILE - 1) / DAFT_TILE * grid->tile, step = grid->step;
    const size_t floats = DAFT_PAST_PLANES * (size_t)width * (size_t)height;
    if (past->width != width || past->height != height || past->step != step) past->some = false;
    past->width = width, past->height = height, past->step = step;
    past->x[!past->now] = grid->x, past->y[!past->now] = grid->y;
    for (int i = 0; i < 2; i++)
        if (!daft_grow(allocator, &past->planes[i], &past->capacity[i], floats,
                       past->some && i == past->now ? floats : 0, sizeof *past->planes[i]))
            return daft_fail_memory(error, "the picture before");
    return true;
}

void daft_past_clear(daft_past *past, int x, int y, int side)
{
    const size_t size = (size_t)past->width * (size_t)past->height;
    float *first = past->planes[!past->now] + (size_t)y * (size_t)past->width + (size_t)x;
    for (size_t plane = 0; plane < DAFT_PAST_PLANES; plane++) /* what weighs nothing is a number, too */
        for (int row = 0; row < side; row++)
            memset(first + plane * size + (size_t)row * (size_t)past->width, 0, (size_t)side * sizeof *first);
}

void daft_past_turn(daft_past *past) { past->now = !past->now, past->some = true; }

void daft_past_free(daft_past *past, const daft_allocator *allocator)
{
    for (int i = 0; i < 2; i++) daft_release(allocator, past->planes[i]);
    *past = (daft_past){0};
}
