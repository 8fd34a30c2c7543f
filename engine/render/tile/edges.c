/* Antialiasing where it shows. All tiles have been drawn with one sample a pixel (or as many as the preset says). Then
 * pixels that disagree with a neighbour get up to sixteen more, by the rays of four finer grids, each of two by two
 * rays a pixel and shifted against the others, so that rays lie in eight different rows and columns: an edge along
 * either axis has eight steps. (A grid of four by four would have four: Cook, "Stochastic Sampling in Computer
 * Graphics", TOG 5(1), 1986, on regular patterns.) The tile draws a quarter of each grid at a time: instances stay in
 * their bins, and rays that nobody asks for count as hidden, so that trees are walked for what is left.
 *
 * Beside an outline, where another triangle begins, all rays are asked what they see, which costs a coverage test. Of
 * those that see the same, one in three is shaded and speaks for the others; the pixel's first sample is one of them.
 * Colours of the pixels around would cost less, but are wrong where a shadow, a crease or a mirror image ends at the
 * outline. Elsewhere (a shadow's edge, a mirror image) one ray of each grid is shaded, or two where the difference is
 * large.
 *
 * Results wait in a picture of their own until no tile looks at its neighbours any more. */
#include "render/tile/tile.h"

#include <string.h>

/* Steps of a byte between neighbours. Textures are filtered already, so that a surface may vary by more. */
static const daft_contrast LIMIT = {.outline = 20, .crease = 20, .inner = 24, .strong = 40};

enum {
    GRIDS = 4,            /* of SCALE x SCALE rays a pixel each */
    SCALE = 2,            /* rays of a grid a side of a pixel */
    SPAN = DAFT_TILE / 2, /* pixels a side of a part */
    SPOKEN = 3,           /* rays that see the same, for each that is shaded */
    TRIANGLES = 6         /* that a pixel sees, above which rays go together by instances */
};
/* From the middles of the divided pixels, in their size. */
static const float SHIFT[GRIDS][2] = {{-0.375f, -0.125f}, {-0.125f, 0.375f}, {0.125f, -0.375f}, {0.375f, 0.125f}};

typedef struct refinement {
    tile_job *j;
    int left, top;          /* the part's first pixel in the tile */
    daft_neighbours around; /* the tile, in the picture with one sample a pixel */
    daft_edges edges;
    daft_tile_part part;
    daft_pencil pencil[GRIDS];
} refinement;

static void shift(daft_tile_part *part, uint32_t grid)
{
    part->shift_x = SHIFT[grid][0], part->shift_y = SHIFT[grid][1];
}

static bool bit(const uint32_t rows[DAFT_TILE], int x, int y) { return rows[y] >> x & 1; }

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
    j->r->kernels->contrast(around, &LIMIT, edges);
    for (int y = 0; y < DAFT_TILE; y++) {
        edges->outline[y] &= y < tile->height ? columns : 0;
        edges->inner[y] &= y < tile->height ? columns & ~edges->outline[y] : 0;
        any |= edges->outline[y] | edges->inner[y];
    }
    return any != 0;
}

/* ---- a part ------------------------------------------------------------------------------------------------------ */

/* Bits of the part's pixels in a row that get more samples. */
static uint32_t pixels_of(const refinement *r, int y)
{
    const uint32_t all = r->edges.outline[r->top + y] | r->edges.inner[r->top + y];
    return all >> r->left & ((1u << SPAN) - 1);
}

/* The cells of a pixel's two by two whose rays of a grid are asked for, as bits: at an outline all; else that of the
 * grid's own number, so that the four lie in different rows and columns, and where much changes that across from it. */
static uint32_t cells_of(const refinement *r, int x, int y, uint32_t grid)
{
    if (bit(r->edges.outline, r->left + x, r->top + y)) return 0xf;
    return 1u << grid | (uint32_t)bit(r->edges.strong, r->left + x, r->top + y) << (3 - grid);
}

/* Asks for the rays of one grid. */
static void ask(refinement *r, uint32_t grid)
{
    uint32_t *asked = r->part.asked;
    memset(asked, 0, sizeof r->part.asked);
    for (int y = 0; y < SPAN; y++)
        for (uint32_t left = pixels_of(r, y); left; left &= left - 1) {
            const int x = __builtin_ctz(left);
            const uint32_t cells = cells_of(r, x, y, grid);
            daft_cost_ask(r->j, (uint32_t)((r->top + y) * DAFT_TILE + r->left + x),
                          (uint32_t)__builtin_popcount(cells));
            asked[2 * y] |= (cells & 3) << (2 * x), asked[2 * y + 1] |= cells >> 2 << (2 * x);
        }
}

static float clamp_unit(float x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

/* Light that speaks for so many rays. */
static void add(daft_scratch *s, uint32_t at, float x, float y, float z, float rays)
{
    s->sum.x[at] += rays * clamp_unit(x), s->sum.y[at] += rays * clamp_unit(y), s->sum.z[at] += rays * clamp_unit(z);
}

static void shade_fresh(refinement *r)
{
    daft_scratch *s = r->j->s;
    const daft_tone *tone = &r->j->snapshot->tone;
    daft_lanes3 *shown = &s->sky_color; /* of no use any more */
    daft_fresh_shade(r->j, &r->pencil[0]);
    for (uint32_t i = 0; i < s->fresh.count; i++) {
        const uint32_t from = s->fresh.pixel[i];
        const daft_lanes3 *color = r->j->color;
        shown->x[i] = color->x[from], shown->y[i] = color->y[from], shown->z[i] = color->z[from];
    }
    if (daft_tone_changes(tone))
        r->j->r->shade->tone(tone, (const float *const[3]){shown->x, shown->y, shown->z}, s->fresh.count,
                             (float *const[3]){shown->x, shown->y, shown->z});
    for (uint32_t i = 0; i < s->fresh.count; i++) {
        const uint32_t from = s->fresh.pixel[i];
        add(s, s->wanted[from], shown->x[i], shown->y[i], shown->z[i], s->share[from]);
    }
    s->fresh.count = 0;
}

/* A ray of a part: its grid, and its place in that. */
typedef struct part_ray {
    uint32_t grid, place;
} part_ray;

/* Those of a pixel's rays that see the same. */
typedef struct group {
    uint32_t id, count;
    part_ray ray[16];
} group;

typedef struct seen_rays {
    uint32_t at, own; /* the pixel in the tile, and what its first sample saw */
    uint32_t count, id[16];
    part_ray ray[16];
} seen_rays;

static seen_rays rays_seen(const refinement *r, int x, int y)
{
    const int px = r->left + x, py = r->top + y;
    seen_rays seen = {.at = (uint32_t)(py * DAFT_TILE + px), .own = r->around.id[py * r->around.id_stride + px]};
    for (uint32_t cell = 0; cell < SCALE * SCALE; cell++)
        for (uint32_t grid = 0; grid < GRIDS; grid++) {
            const daft_tile *tile = &r->j->s->grids[grid];
            const uint32_t row = SCALE * (uint32_t)y + cell / SCALE, column = SCALE * (uint32_t)x + cell % SCALE,
                           place = row * DAFT_TILE_STRIDE + column;
            if (!(cells_of(r, x, y, grid) >> cell & 1)) continue;
            seen.ray[seen.count] = (part_ray){grid, place};
            seen.id[seen.count++] = daft_pixel_id(tile->instance[place], tile->triangle[place]);
        }
    return seen;
}

/* How many groups there are: ids are compared without their lower bits. */
static uint32_t group_rays(const seen_rays *seen, int bits, group out[16])
{
    uint32_t groups = 0;
    for (uint32_t i = 0; i < seen->count; i++) {
        const uint32_t id = seen->id[i] >> bits;
        uint32_t k = 0;
        while (k < groups && out[k].id != id) k++;
        if (k == groups) out[groups++] = (group){.id = id};
        out[k].ray[out[k].count++] = seen->ray[i];
    }
    return groups;
}

static void shade_later(refinement *r, part_ray ray, uint32_t at, float rays)
{
    daft_scratch *s = r->j->s;
    daft_fresh_add(r->j, &r->pencil[ray.grid], &s->grids[ray.grid], ray.place, at);
    s->share[s->fresh.pixel[s->fresh.count - 1]] = rays;
}

/* What the pixel's first sample saw speaks for so many rays. */
static void add_own(refinement *r, uint32_t at, float rays)
{
    const int x = (int)at % DAFT_TILE, y = (int)at / DAFT_TILE;
    float light[3];
    r->j->r->shade->decode(r->around.pixel + 4 * (y * r->around.stride + x), 1, &light[0], &light[1], &light[2]);
    add(r->j->s, at, light[0], light[1], light[2], rays);
}

/* Some of the group, spread over it. */
static void take_group(refinement *r, const group *g, uint32_t at, bool has_own)
{
    const uint32_t some = (g->count + SPOKEN - 1) / SPOKEN, fresh = some - has_own;
    const float share = (float)g->count / (float)some;
    if (has_own) add_own(r, at, share);
    for (uint32_t i = 0; i < fresh; i++) shade_later(r, g->ray[(i * g->count + g->count / 2) / fresh], at, share);
}

/* The rays of a pixel of the part. */
static void take(refinement *r, int x, int y)
{
    const seen_rays seen = rays_seen(r, x, y);
    r->j->s->taken[seen.at] += seen.count;
    if (!bit(r->edges.outline, r->left + x, r->top + y)) {
        for (uint32_t i = 0; i < seen.count; i++) shade_later(r, seen.ray[i], seen.at, 1);
        return;
    }
    group groups[16];
    int bits = 0;
    uint32_t count = group_rays(&seen, bits, groups);
    if (count > TRIANGLES) count = group_rays(&seen, bits = DAFT_ID_INSTANCE, groups);
    for (uint32_t k = 0; k < count; k++) take_group(r, &groups[k], seen.at, groups[k].id == seen.own >> bits);
}

static void refine_part(refinement *r, int number)
{
    uint32_t any = 0;
    r->part.number = number;
    r->left = number % SCALE * SPAN, r->top = number / SCALE * SPAN;
    for (int y = 0; y < SPAN; y++) any |= pixels_of(r, y);
    if (!any) return;
    r->j->part = &r->part;
    for (uint32_t grid = 0; grid < GRIDS; grid++) {
        shift(&r->part, grid);
        ask(r, grid);
        daft_tile_see(r->j, &r->j->s->grids[grid]);
    }
    for (int y = 0; y < SPAN; y++)
        for (uint32_t left = pixels_of(r, y); left; left &= left - 1) {
            if (r->j->s->fresh.count > DAFT_BATCH - 16) shade_fresh(r); /* writes nothing of what the part sees */
            take(r, __builtin_ctz(left), y);
        }
}

/* ---- a tile ------------------------------------------------------------------------------------------------------ */

/* The mean of a pixel's samples. What it had counts as one of the few that were shaded, and not at all beside an
 * outline, where the finer grid is whole. */
static void mean_of(const refinement *r, int x, int y, float light[3])
{
    const daft_scratch *s = r->j->s;
    const int at = y * DAFT_TILE + x;
    const float few = bit(r->edges.outline, x, y) ? 0 : 1, weight = 1 / ((float)s->taken[at] + few);
    const float sum[3] = {s->sum.x[at], s->sum.y[at], s->sum.z[at]};
    float own[3];
    r->j->r->shade->decode(r->around.pixel + 4 * (y * r->around.stride + x), 1, &own[0], &own[1], &own[2]);
    for (int k = 0; k < 3; k++) light[k] = (sum[k] + own[k] * few) * weight;
}

static void write_row(const refinement *r, const daft_tile *tile, int y)
{
    const tile_job *j = r->j;
    const size_t width = (size_t)j->snapshot->width, row = (size_t)(tile->y - j->snapshot->first_row + y);
    float light[3][DAFT_TILE + 16];
    uint8_t rgba[4 * DAFT_TILE], *to = j->r->smooth + 4 * (row * width + (size_t)tile->x);
    uint32_t count = 0, all = r->edges.outline[y] | r->edges.inner[y];
    for (uint32_t left = all; left; left &= left - 1, count++) {
        float one[3];
        mean_of(r, __builtin_ctz(left), y, one);
        for (int k = 0; k < 3; k++) light[k][count] = one[k];
    }
    for (int k = 0; k < 3; k++) memset(&light[k][count], 0, 16 * sizeof light[k][0]);
    j->r->shade->encode(light[0], light[1], light[2], count, rgba);
    count = 0;
    for (uint32_t left = all; left; left &= left - 1, count++)
        memcpy(to + 4 * __builtin_ctz(left), rgba + 4 * count, 4);
}

void daft_refine_tile(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    if (atomic_load_explicit(&frame->cancelled, memory_order_relaxed)) return;
    tile_job j = daft_tile_again(frame, index, worker);
    refinement r = {.j = &j, .part.scale = SCALE};
    for (uint32_t grid = 0; grid < GRIDS; grid++) {
        shift(&r.part, grid);
        r.pencil[grid] = daft_part_pencil(&frame->pencil, &r.part);
    }
    if (all_sky(&j, index)) {
        memset(&r.edges, 0, sizeof r.edges);
    } else if (find_edges(&j, &r.around, &r.edges)) {
        memset(&j.s->sum, 0, sizeof j.s->sum);
        memset(j.s->taken, 0, sizeof j.s->taken);
        j.s->fresh.count = 0;
        for (int i = 0; i < SCALE * SCALE; i++) refine_part(&r, i);
        shade_fresh(&r);
        daft_tile_place(&j.r->raster, j.number, NULL, &j.s->tile);
        for (int y = 0; y < j.s->tile.height; y++) write_row(&r, &j.s->tile, y);
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
    const size_t width = (size_t)j.snapshot->width;
    for (int y = 0; y < DAFT_TILE; y++)
        for (uint32_t left = edges->outline[y] | edges->inner[y]; left; left &= left - 1) {
            const size_t row = (size_t)(j.s->tile.y + y), x = (size_t)(j.s->tile.x + __builtin_ctz(left));
            memcpy(j.frame->target->pixels + 4 * (row * width + x),
                   j.r->smooth + 4 * ((row - (size_t)j.snapshot->first_row) * width + x), 4);
        }
    book(&j, DAFT_EFFECT_ANTIALIASING);
}
