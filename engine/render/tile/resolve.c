/* From the light of a tile's pixels to bytes. */
#include "render/tile/tile.h"

#include <string.h>

static float clamp_unit(float x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

/* A row as it is shown. Tone comes before anything that averages samples, so that edges between light and dark are as
 * smooth as others. */
typedef struct shown_row {
    float r[DAFT_TILE + 16], g[DAFT_TILE + 16], b[DAFT_TILE + 16];
} shown_row;

static void show_row(const tile_job *j, const daft_lanes3 *color, int row, shown_row *out)
{
    const int at = row * DAFT_TILE;
    j->r->shade->tone(&j->snapshot->tone, (const float *const[3]){&color->x[at], &color->y[at], &color->z[at]},
                      (uint32_t)j->s->tile.width, (float *const[3]){out->r, out->g, out->b});
}

/* Samples are clamped to what a display shows before they are averaged: one very bright sample must not win an edge. */
static void add_sample(const tile_job *j, int row)
{
    const daft_tile *tile = &j->s->tile;
    shown_row shown;
    const int first = row * DAFT_TILE;
    const float *color[3] = {&j->color->x[first], &j->color->y[first], &j->color->z[first]};
    if (daft_tone_changes(&j->snapshot->tone)) {
        show_row(j, j->color, row, &shown);
        color[0] = shown.r, color[1] = shown.g, color[2] = shown.b;
    }
    float *sum = j->r->sum + 3 * ((size_t)(tile->y + row) * (size_t)j->snapshot->width + (size_t)tile->x);
    for (int x = 0; x < tile->width; x++) {
        for (int k = 0; k < 3; k++) sum[3 * x + k] = (j->frame->sample ? sum[3 * x + k] : 0) + clamp_unit(color[k][x]);
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
    return j->s->points.count == 0 && j->snapshot->sky.kind == DAFT_SKY_COLOR && !(j->snapshot->sky.sun_chord2 > 0) &&
           !j->frame->plan.fog && j->snapshot->quality.samples == 1;
}

void daft_tile_fill_plain(tile_job *j)
{
    const daft_tile *tile = &j->s->tile;
    daft_lanes3 *color = &j->s->sky_color;
    uint8_t rgba[4];
    j->r->shade->sky(&j->snapshot->sky, &j->s->sky.direction, 1, color);
    daft_lanes3 *shown = &j->s->sum;
    j->r->shade->tone(&j->snapshot->tone, (const float *const[3]){color->x, color->y, color->z}, 1,
                      (float *const[3]){shown->x, shown->y, shown->z});
    if (!daft_tone_changes(&j->snapshot->tone)) shown = color;
    j->r->shade->encode(shown->x, shown->y, shown->z, 1, rgba);
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

/* `toned`: it is as it is shown already. */
static void encode(const tile_job *j, const daft_lanes3 *color, int row, bool toned)
{
    const daft_tile *tile = &j->s->tile;
    const int at = row * DAFT_TILE;
    uint8_t *to = daft_frame_row(j->frame, tile->y + row) + 4 * (size_t)tile->x;
    if (toned || !daft_tone_changes(&j->snapshot->tone)) {
        j->r->shade->encode(&color->x[at], &color->y[at], &color->z[at], (uint32_t)tile->width, to);
        return;
    }
    shown_row shown;
    show_row(j, color, row, &shown);
    j->r->shade->encode(shown.r, shown.g, shown.b, (uint32_t)tile->width, to);
}

void daft_tile_show(tile_job *j)
{
    daft_tile_aov_color(j);
    for (int row = 0; row < j->s->tile.height; row++) encode(j, j->color, row, false);
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
        encode(j, color, row, snapshot->quality.samples > 1);
    }
    ran(j, DAFT_EFFECT_RESOLVE);
    book(j, DAFT_EFFECT_RESOLVE);
}
