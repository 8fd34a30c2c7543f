/* Antialiasing by corners. A pixel's middle has been drawn; its four corners are further samples, and each belongs to
 * four pixels, so that they cost one ray to a pixel at most: the quincunx pattern, half the weight in the middle and an
 * eighth in each corner (it has this name since the GeForce3 had it, NVIDIA 2001). An edge between two pixels' middles
 * crosses their common corners, so only corners are asked around which two pixels differ and see different things.
 *
 * Their rays ask what they see. What one of the four pixels sees as well has that pixel's colour; what none of them
 * does is shaded. So most corners cost a coverage test and nothing else. Three passes, each over all tiles: what
 * corners see and their colours; then pixels are mixed with them. No pass reads what another tile writes in it. */
#include "render/tile/tile.h"

#include <string.h>

/* Steps of a byte between neighbours. Textures are filtered already, so that a surface may vary by more. */
static const daft_contrast LIMIT = {.of = {[DAFT_OWN_MATTE] = {.outline = 24, .crease = 48, .inner = 8191}}};

/* Of whole tiles, and one more for the last tile's right corners. */
static size_t word_stride(const daft_frame *frame)
{
    return (size_t)(daft_tile_columns(frame->snapshot) + 1) * DAFT_TILE;
}

size_t daft_corner_words(const daft_frame *frame)
{
    const size_t rows = frame->tile_count / daft_tile_columns(frame->snapshot) * DAFT_TILE + 1;
    return rows * word_stride(frame);
}

static uint32_t *words_of(const tile_job *j, uint32_t index)
{
    const uint32_t columns = daft_tile_columns(j->snapshot);
    return j->r->corners + index / columns * DAFT_TILE * word_stride(j->frame) + index % columns * DAFT_TILE;
}

/* Below the band only the first row counts. */
static bool find_corners(const tile_job *j, uint32_t index, const daft_neighbours *around, uint32_t asked[DAFT_TILE])
{
    const daft_tile *tile = &j->s->tile;
    const uint32_t columns = tile->width == DAFT_TILE ? UINT32_MAX : (1u << tile->width) - 1;
    const int rows = index < j->frame->tile_count ? tile->height : 1;
    uint32_t any = 0;
    const daft_contrast limit = daft_scaled_contrast(&LIMIT, j->snapshot->quality.edge_contrast);
    j->r->kernels->corners(around, &limit, asked);
    for (int y = 0; y < DAFT_TILE; y++) any |= asked[y] &= y < rows ? columns : 0;
    return any != 0;
}

static void shade_fresh(tile_job *j, const daft_pencil *pencil, const uint32_t fresh[DAFT_TILE], uint32_t *words)
{
    daft_scratch *s = j->s;
    uint32_t bytes[DAFT_BATCH];
    s->fresh.count = 0;
    for (int y = 0; y < DAFT_TILE; y++)
        for (uint32_t left = fresh[y]; left; left &= left - 1) {
            const uint32_t place = (uint32_t)(y * DAFT_TILE_STRIDE + __builtin_ctz(left));
            daft_fresh_add(j, pencil, &j->s->tile, place, place);
        }
    daft_fresh_shade(j, pencil);
    for (uint32_t i = 0; i < s->fresh.count; i++) {
        const uint32_t from = s->fresh.pixel[i];
        s->sum.x[i] = j->color->x[from], s->sum.y[i] = j->color->y[from], s->sum.z[i] = j->color->z[from];
    }
    if (daft_tone_changes(&j->snapshot->tone))
        j->r->shade->tone(&j->snapshot->tone, (const float *const[3]){s->sum.x, s->sum.y, s->sum.z}, s->fresh.count,
                          (float *const[3]){s->sum.x, s->sum.y, s->sum.z});
    j->r->shade->encode(s->sum.x, s->sum.y, s->sum.z, s->fresh.count, (uint8_t *)bytes);
    for (uint32_t i = 0; i < s->fresh.count; i++) {
        const uint32_t place = s->wanted[s->fresh.pixel[i]];
        words[place / DAFT_TILE_STRIDE * word_stride(j->frame) + place % DAFT_TILE_STRIDE] = bytes[i] & 0xffffff;
    }
}

void daft_corners_tile(void *context, uint32_t task, uint32_t worker)
{
    daft_frame *frame = context;
    if (atomic_load_explicit(&frame->cancelled, memory_order_relaxed)) return;
    const uint32_t index = frame->tiles ? frame->tiles[task] : task;
    tile_job j = daft_tile_again(frame, index, worker);
    daft_redraw_tile(&j);
    const daft_neighbours around = daft_tile_neighbours(&j);
    daft_tile_part part = {.shift_x = -0.5f, .shift_y = 0.5f}; /* upper left corners */
    uint32_t fresh[DAFT_TILE], *words = words_of(&j, index);
    if (find_corners(&j, index, &around, part.asked)) {
        const daft_pencil pencil = daft_part_pencil(&frame->pencil, &part);
        j.part = &part;
        daft_tile_see(&j, &j.s->tile);
        j.r->kernels->match_corners(&around, &j.s->tile, part.asked, words, word_stride(frame), fresh);
        shade_fresh(&j, &pencil, fresh, words);
        for (int y = 0; y < DAFT_TILE; y++)
            for (uint32_t left = part.asked[y]; left; left &= left - 1)
                daft_cost_ask(&j, (uint32_t)(y * DAFT_TILE + __builtin_ctz(left)), 1);
    }
    memcpy(j.r->edges[index].outline, part.asked, sizeof part.asked);
    book(&j, DAFT_EFFECT_ANTIALIASING);
    if (index < frame->tile_count) daft_tile_report(frame, worker);
}

/* The corners of a tile's pixels: its own, and the first ones of the tiles beside and below. */
static bool corners_of(const tile_job *j, uint32_t index, daft_corners *out)
{
    const uint32_t columns = daft_tile_columns(j->snapshot), count = j->frame->corner_tiles;
    const daft_edges *own = &j->r->edges[index], *below = &own[columns];
    const bool right = index % columns + 1 < columns, lower = index + columns < count;
    uint64_t any = 0;
    for (int y = 0; y < DAFT_TILE; y++)
        any |= out->asked[y] = own->outline[y] | (right ? (uint64_t)(own[1].outline[y] & 1) << DAFT_TILE : 0);
    out->asked[DAFT_TILE] = lower ? below->outline[0] : 0;
    if (lower && right) out->asked[DAFT_TILE] |= (uint64_t)(below[1].outline[0] & 1) << DAFT_TILE;
    return (any | out->asked[DAFT_TILE]) != 0;
}

void daft_mix_tile(void *context, uint32_t task, uint32_t worker)
{
    daft_frame *frame = context;
    const uint32_t index = frame->tiles ? frame->mixed[task] : task;
    tile_job j = daft_tile_again(frame, index, worker);
    daft_scratch *s = j.s;
    daft_mixed *mixed = &s->mixed;
    daft_corners corners;
    uint32_t bytes[DAFT_BATCH];
    if (corners_of(&j, index, &corners)) {
        const size_t width = (size_t)j.snapshot->width;
        uint8_t *pixels = frame->target->pixels + 4 * ((size_t)s->tile.y * width + (size_t)s->tile.x);
        daft_lanes3 *sum = &s->sum, *one = &s->color;
        j.r->kernels->mix_corners(&s->tile, &corners, words_of(&j, index), word_stride(frame), pixels, width, mixed);
        for (int k = 0; k < 5; k++) {
            const float weight = k ? 0.125f : 0.5f;
            j.r->shade->decode((const uint8_t *)mixed->word[k], mixed->count, one->x, one->y, one->z);
            for (uint32_t i = 0; i < mixed->count; i++) {
                sum->x[i] = (k ? sum->x[i] : 0) + one->x[i] * weight;
                sum->y[i] = (k ? sum->y[i] : 0) + one->y[i] * weight;
                sum->z[i] = (k ? sum->z[i] : 0) + one->z[i] * weight;
            }
        }
        j.r->shade->encode(sum->x, sum->y, sum->z, mixed->count, (uint8_t *)bytes);
        for (uint32_t i = 0; i < mixed->count; i++)
            memcpy(pixels + 4 * (mixed->place[i] / DAFT_TILE * width + mixed->place[i] % DAFT_TILE), &bytes[i], 4);
        if (mixed->count) ran(&j, DAFT_EFFECT_ANTIALIASING);
    }
    book(&j, DAFT_EFFECT_ANTIALIASING);
}
