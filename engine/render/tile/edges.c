/* Antialiasing where it shows. All tiles have been drawn with one sample a pixel (or as many as the preset says). Then
 * pixels that disagree with a neighbour get up to sixteen more, by the rays of a grid four times as fine, turned by
 * atan(1/4), so that each of a pixel's rays lies in a row and a column of its own: an edge along either axis has
 * sixteen steps. (Straight, it would have four: Cook, "Stochastic Sampling in Computer Graphics", TOG 5(1), 1986, on
 * regular patterns.) A tile asks what all of them see at once: instances stay in their bins, and pixels that ask for
 * nothing count as hidden, so that trees are walked for what is left, once. Then rays are shaded by parts of the tile,
 * so that those of a batch are neighbours.
 *
 * Beside an outline, where another triangle begins, all rays are asked what they see, which costs a coverage test. Of
 * those that see the same, some are shaded and speak for the others, by what that is and how much changes; the pixel's
 * first sample is one of them. Colours of the pixels around would cost less, but are wrong where a shadow, a crease or
 * a mirror image ends at the outline. Elsewhere (a shadow's edge, a mirror image) two rays to all are shaded.
 *
 * Results wait in a picture of their own until no tile looks at its neighbours any more. */
#include "render/tile/tile.h"

#include <string.h>

/* Steps of a byte between neighbours; within a surface of its light alone, since textures are filtered already. */
static const daft_contrast LIMIT = {
    .of = {[DAFT_OWN_MATTE] = {.outline = 20, .crease = 14, .inner = 14},
           [DAFT_OWN_TEXTURED] = {.outline = 60, .crease = 60, .inner = 24}, /* textures hide faint edges */
           [DAFT_OWN_MIRRORS] = {.outline = 18, .crease = 18, .inner = 16},
           [DAFT_OWN_PASSES] = {.outline = 25, .crease = 20, .inner = 14}},
    .strong = 50,
    .stark = 125,
};

enum {
    SCALE = DAFT_EDGE_SCALE,
    SPAN = DAFT_TILE / SCALE /* pixels a side of a part */
};

typedef struct refinement {
    tile_job *j;
    daft_neighbours around; /* the tile, in the picture with one sample a pixel */
    daft_edges edges;
    daft_edge_part rays; /* and the part at work */
    daft_pencil pencil;  /* of rays two by two to a pixel: what one in four of sixteen stands for */
} refinement;

/* Whether the tile and those beside it see nothing but the sky. */
static bool all_sky(const tile_job *j, uint32_t index)
{
    const uint32_t columns = (uint32_t)j->r->raster.tiles_x, x = index % columns;
    const daft_edges *own = &j->r->edges[index];
    const bool inside = x > 0 && x + 1 < columns && index >= columns && index + columns < j->frame->tile_count;
    return inside && own->sky && own[-1].sky && own[1].sky && (own - columns)->sky && (own + columns)->sky;
}

static bool find_edges(tile_job *j, daft_neighbours *around, daft_edges *edges)
{
    const daft_tile *tile = &j->s->tile;
    const uint32_t columns = tile->width == DAFT_TILE ? UINT32_MAX : (1u << tile->width) - 1;
    uint32_t any = 0;
    *around = daft_tile_neighbours(j);
    const daft_contrast limit = daft_scaled_contrast(&LIMIT, j->snapshot->quality.edge_contrast);
    j->r->kernels->contrast(around, &limit, edges);
    for (int y = 0; y < DAFT_TILE; y++) {
        edges->outline[y] &= y < tile->height ? columns : 0;
        edges->inner[y] &= y < tile->height ? columns : 0;
        any |= edges->outline[y] | edges->inner[y];
    }
    return any != 0;
}

/* ---- a part ------------------------------------------------------------------------------------------------------ */

/* A part's pixels of a row. */
static uint32_t part_of(const refinement *r, uint32_t row) { return row >> r->rays.left & ((1u << SPAN) - 1); }

/* Those that get more samples. */
static uint32_t pixels_of(const refinement *r, int y)
{
    const int py = r->rays.top + y;
    return part_of(r, r->edges.outline[py] | r->edges.inner[py]);
}

static daft_edge_rays fresh_of(daft_scratch *s)
{
    return (daft_edge_rays){.list = &s->fresh, .wanted = s->wanted, .share = s->share, .own = s->own};
}

static void shade_fresh(refinement *r)
{
    daft_scratch *s = r->j->s;
    const daft_render_kernels *kernels = r->j->r->kernels;
    const daft_tone *tone = &r->j->snapshot->tone;
    const daft_edge_rays rays = fresh_of(s);
    daft_lanes3 *shown = &s->sky_color; /* of no use any more */
    if (!s->fresh.count) return;
    daft_fresh_shade(r->j, &r->pencil);
    kernels->gather_light(r->j->color, &s->fresh, shown);
    if (daft_tone_changes(tone))
        r->j->r->shade->tone(tone, (const float *const[3]){shown->x, shown->y, shown->z}, s->fresh.count,
                             (float *const[3]){shown->x, shown->y, shown->z});
    kernels->add_light(&rays, shown, &s->sum);
    s->fresh.count = 0;
}

static void take(refinement *r, int y)
{
    daft_edge_rays rays = fresh_of(r->j->s);
    uint32_t left = pixels_of(r, y);
    while (left) {
        left = r->j->r->kernels->take_edges(&r->rays, y, left, &rays);
        if (left) shade_fresh(r); /* writes nothing of what the part sees */
    }
}

static void refine_part(refinement *r, int number)
{
    r->rays.left = number % SCALE * SPAN, r->rays.top = number / SCALE * SPAN;
    for (int y = 0; y < SPAN; y++) take(r, y);
}

/* ---- a tile ------------------------------------------------------------------------------------------------------ */

/* All rays of pixels at an outline, some of others. */
static uint32_t rays_of(const refinement *r, int x, int y)
{
    if (r->edges.outline[y] >> x & 1) return DAFT_EDGE_FIRST[DAFT_EDGE_RAYS];
    return DAFT_EDGE_FIRST[DAFT_EDGE_INNER[daft_first_kind(&r->around, x, y)][daft_edge_level(&r->edges, x, y)]];
}

static void ask(const refinement *r, daft_fine_tile *fine)
{
    for (int y = 0; y < DAFT_TILE; y++) {
        fine->pixels[y] = r->edges.outline[y] | r->edges.inner[y];
        for (uint32_t left = fine->pixels[y]; left; left &= left - 1) {
            const int x = __builtin_ctz(left);
            fine->asked[DAFT_TILE * y + x] = (uint16_t)rays_of(r, x, y);
        }
    }
}

static void see(refinement *r)
{
    const daft_tile *tile = &r->j->s->tile;
    daft_fine_tile *fine = &r->j->s->fine;
    ask(r, fine);
    daft_tile_see_fine(r->j, fine);
    const daft_pencil pencil = daft_scaled_pencil(&r->j->frame->pencil, SCALE);
    const daft_vec3 first = daft_pencil_ray(&pencil, SCALE * tile->x, SCALE * tile->y);
    r->rays.x = first.x, r->rays.y = first.y;
}

/* The mean of a pixel's samples; `own`: the first one. That counts as one of the few that were shaded, and beside an
 * outline for those that see the same. */
static void mean_of(const refinement *r, int x, int y, const float own[3], float light[3])
{
    const daft_scratch *s = r->j->s;
    const int at = y * DAFT_TILE + x;
    const float sum[3] = {s->sum.x[at], s->sum.y[at], s->sum.z[at]};
    for (int k = 0; k < 3; k++) light[k] = (sum[k] + own[k] * s->own[at]) * (1.0f / DAFT_EDGE_RAYS);
}

/* Writes a row's pixels with more samples one after the other, and gives where the next ones go. */
static uint8_t *write_row(const refinement *r, int y, uint8_t *to)
{
    const tile_job *j = r->j;
    float light[3][DAFT_TILE + 16], own[3][DAFT_TILE + 16];
    uint8_t rgba[4 * DAFT_TILE];
    uint32_t count = 0, all = r->edges.outline[y] | r->edges.inner[y];
    if (!all) return to;
    j->r->shade->decode(r->around.pixel + 4 * y * r->around.stride, DAFT_TILE, own[0], own[1], own[2]);
    for (uint32_t left = all; left; left &= left - 1, count++) {
        const int x = __builtin_ctz(left);
        float one[3];
        mean_of(r, x, y, (const float[3]){own[0][x], own[1][x], own[2][x]}, one);
        for (int k = 0; k < 3; k++) light[k][count] = one[k];
    }
    for (int k = 0; k < 3; k++) memset(&light[k][count], 0, 16 * sizeof light[k][0]);
    j->r->shade->encode(light[0], light[1], light[2], count, rgba);
    memcpy(to, rgba, 4 * count);
    return to + 4 * count;
}

/* A tile's pixels with more samples, row by row, without those between. */
static uint8_t *pixels_of_tile(const tile_job *j, uint32_t index)
{
    return j->r->smooth + (size_t)index * (4 * DAFT_TILE * DAFT_TILE);
}

void daft_refine_tile(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    if (atomic_load_explicit(&frame->cancelled, memory_order_relaxed)) return;
    tile_job j = daft_tile_again(frame, index, worker);
    refinement r = {.j = &j, .rays.rays = &j.s->fine};
    r.pencil = daft_scaled_pencil(&frame->pencil, SCALE / 2);
    if (all_sky(&j, index)) {
        memset(&r.edges, 0, sizeof r.edges);
    } else if (find_edges(&j, &r.around, &r.edges)) {
        memset(&j.s->sum, 0, sizeof j.s->sum);
        j.s->fresh.count = 0;
        r.rays.edges = &r.edges, r.rays.first = &r.around;
        see(&r);
        for (int i = 0; i < SCALE * SCALE; i++) refine_part(&r, i);
        shade_fresh(&r);
        uint8_t *to = pixels_of_tile(&j, index);
        for (int y = 0; y < j.s->tile.height; y++) to = write_row(&r, y, to);
        ran(&j, DAFT_EFFECT_ANTIALIASING);
    }
    memcpy(j.r->edges[index].outline, r.edges.outline, sizeof r.edges.outline);
    memcpy(j.r->edges[index].inner, r.edges.inner, sizeof r.edges.inner);
    book(&j, DAFT_EFFECT_ANTIALIASING);
    daft_tile_report(frame, worker);
}

void daft_show_edges(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    tile_job j = daft_tile_again(frame, index, worker);
    const daft_edges *edges = &j.r->edges[index];
    const uint8_t *from = pixels_of_tile(&j, index);
    for (int y = 0; y < DAFT_TILE; y++) {
        uint32_t left = edges->outline[y] | edges->inner[y];
        if (!left) continue;
        uint8_t *row = daft_frame_row(frame, j.s->tile.y + y) + 4 * (size_t)j.s->tile.x;
        for (; left; left &= left - 1, from += 4) memcpy(row + 4 * __builtin_ctz(left), from, 4);
    }
    book(&j, DAFT_EFFECT_ANTIALIASING);
}
