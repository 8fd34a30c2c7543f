/* From the light of a tile's pixels to bytes. */
#include "render/tile/tile.h"

#include <string.h>

static float clamp_unit(float x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

/* Samples are clamped to what a display shows before they are averaged: one very bright sample must not win an edge. */
static void add_sample(const tile_job *j, int row)
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

static void mean_row(const tile_job *j, int row, float weight)
{
    const daft_tile *tile = &j->s->tile;
    daft_lanes3 *color = &j->s->color;
    const float *sum = j->r->sum + 3 * ((size_t)(tile->y + row) * (size_t)j->snapshot->width + (size_t)tile->x);
    for (int x = 0; x < tile->width; x++) {
        int at = row * DAFT_TILE + x;
        color->x[at] = sum[3 * x] * weight, color->y[at] = sum[3 * x + 1] * weight,
        color->z[at] = sum[3 * x + 2] * weight;
    }
}

bool daft_tile_is_plain(const tile_job *j)
{
    return j->s->points.count == 0 && j->snapshot->sky.kind == DAFT_SKY_COLOR && !j->frame->plan.fog &&
           j->snapshot->quality.samples == 1;
}

void daft_tile_fill_plain(tile_job *j)
{
    const daft_tile *tile = &j->s->tile;
    daft_lanes3 *color = &j->s->sky_color;
    uint8_t rgba[4];
    j->r->shade->sky(&j->snapshot->sky, &j->s->sky.direction, 1, color);
    j->r->shade->encode(color->x, color->y, color->z, 1, rgba);
    if (j->frame->target->aov.color) {
        for (uint32_t i = 0; i < DAFT_BATCH; i++)
            j->s->color.x[i] = color->x[0], j->s->color.y[i] = color->y[0], j->s->color.z[i] = color->z[0];
        j->color = &j->s->color;
        daft_tile_aov_color(j);
    }
    for (int row = 0; row < tile->height; row++) {
        uint8_t *to = daft_frame_row(j->frame, tile->y + row) + 4 * (size_t)tile->x;
        for (int x = 0; x < tile->width; x++) memcpy(to + 4 * x, rgba, sizeof rgba);
    }
    ran(j, DAFT_EFFECT_SKY);
    ran(j, DAFT_EFFECT_RESOLVE);
    book(j, DAFT_EFFECT_SKY);
}

static void encode(const tile_job *j, const daft_lanes3 *color, int row)
{
    const daft_tile *tile = &j->s->tile;
    const int at = row * DAFT_TILE;
    j->r->shade->encode(&color->x[at], &color->y[at], &color->z[at], (uint32_t)tile->width,
                        daft_frame_row(j->frame, tile->y + row) + 4 * (size_t)tile->x);
}

void daft_tile_show(tile_job *j)
{
    daft_tile_aov_color(j);
    for (int row = 0; row < j->s->tile.height; row++) encode(j, j->color, row);
    ran(j, DAFT_EFFECT_RESOLVE);
    book(j, DAFT_EFFECT_RESOLVE);
}

void daft_tile_resolve(tile_job *j)
{
    const daft_snapshot *snapshot = j->snapshot;
    const daft_tile *tile = &j->s->tile;
    bool last = j->frame->sample == snapshot->quality.samples - 1;
    const daft_lanes3 *color = snapshot->quality.samples > 1 ? &j->s->color : j->color;
    daft_tile_aov_color(j);
    for (int row = 0; row < tile->height; row++) {
        if (snapshot->quality.samples > 1) add_sample(j, row);
        if (!last) continue;
        if (snapshot->quality.samples > 1) mean_row(j, row, 1 / (float)snapshot->quality.samples);
        encode(j, color, row);
    }
    ran(j, DAFT_EFFECT_RESOLVE);
    book(j, DAFT_EFFECT_RESOLVE);
}
