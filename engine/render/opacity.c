/* Opacity classes of triangles: whether the alpha of a mesh's material is the same wherever a triangle is, so that rays
 * need not read the texture there (Gruen, Benthin, Woop, "Sub-triangle opacity masks for faster ray tracing of
 * transparent objects", 2020, whose classes these are, of whole triangles).
 *
 * A triangle's texels lie in the rectangle around its corners' texture coordinates. Their least and largest bytes come
 * from a pyramid over the texture: cells of 4 by 4 texels, then of twice as many each way. A rectangle asks the finest
 * level on which it is at most ASKED cells wide and high, so an answer takes bounded time; cells that stick out make it
 * more cautious, never wrong. Vertices' alpha is least and largest at corners. */
#include "render/render.h"

#include <math.h>
#include <string.h>

enum { CELL = 4, ASKED = 16, LEVELS = 15 };

typedef struct byte_range {
    uint8_t min, max;
} byte_range;

typedef struct pyramid {
    const daft_texture_data *texture;
    uint32_t channel;
    int levels, width[LEVELS], height[LEVELS];
    byte_range *cells[LEVELS]; /* all in one allocation */
} pyramid;

static void include(byte_range *r, byte_range more)
{
    if (more.min < r->min) r->min = more.min;
    if (more.max > r->max) r->max = more.max;
}

static const byte_range NOTHING = {255, 0};

static byte_range texels_range(const pyramid *p, int x0, int x1, int y0, int y1)
{
    const daft_texture_data *t = p->texture;
    byte_range r = NOTHING;
    for (int y = y0; y <= y1; y++) {
        const uint8_t *row = t->texels[0] + 4 * (size_t)y * (size_t)t->width[0] + p->channel;
        for (int x = x0; x <= x1; x++) include(&r, (byte_range){row[4 * x], row[4 * x]});
    }
    return r;
}

static byte_range cells_range(const pyramid *p, int level, int x0, int x1, int y0, int y1)
{
    byte_range r = NOTHING;
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++) include(&r, p->cells[level][(size_t)y * (size_t)p->width[level] + (size_t)x]);
    return r;
}

static void fill(pyramid *p, int level)
{
    const int w = level ? p->width[level - 1] : p->texture->width[0],
              h = level ? p->height[level - 1] : p->texture->height[0], side = level ? 2 : CELL;
    byte_range *out = p->cells[level];
    for (int y = 0; y < p->height[level]; y++)
        for (int x = 0; x < p->width[level]; x++) {
            const int x1 = daft_min_i((x + 1) * side, w) - 1, y1 = daft_min_i((y + 1) * side, h) - 1;
            *out++ = level ? cells_range(p, level - 1, x * side, x1, y * side, y1)
                           : texels_range(p, x * side, x1, y * side, y1);
        }
}

static bool pyramid_make(const daft_allocator *allocator, const daft_texture_data *t, uint32_t channel, pyramid *p)
{
    size_t count = 0, first[LEVELS];
    int w = (t->width[0] + CELL - 1) / CELL, h = (t->height[0] + CELL - 1) / CELL;
    *p = (pyramid){.texture = t, .channel = channel};
    for (;; w = (w + 1) / 2, h = (h + 1) / 2) {
        p->width[p->levels] = w, p->height[p->levels] = h, first[p->levels++] = count;
        count += (size_t)w * (size_t)h;
        if (w == 1 && h == 1) break;
    }
    byte_range *all = daft_alloc(allocator, count, sizeof *all);
    for (int level = 0; all && level < p->levels; level++) {
        p->cells[level] = all + first[level];
        fill(p, level);
    }
    return all != NULL;
}

static byte_range rectangle_range(const pyramid *p, int x0, int x1, int y0, int y1)
{
    int level = -1;
    for (; x1 - x0 >= ASKED || y1 - y0 >= ASKED; level++) {
        const int side = level < 0 ? CELL : 2;
        x0 /= side, x1 /= side, y0 /= side, y1 /= side;
    }
    return level < 0 ? texels_range(p, x0, x1, y0, y1) : cells_range(p, level, x0, x1, y0, y1);
}

/* Texels of an axis, inclusive; the second span where the first wraps around, else empty. */
typedef struct spans {
    int from[2], to[2];
} spans;

/* What a filter may read between two coordinates, rounding and all: a pixel's coordinates are off by a few 2^-24 of the
 * corners'. */
static spans spans_between(float low, float high, int size, uint32_t wrap)
{
    const spans all = {{0, 0}, {size - 1, -1}};
    const double n = size, error = (fabs((double)low) + fabs((double)high) + 1) * n * 0x1p-20 + 0.01;
    double from = (double)low, to = (double)high;
    if (wrap == DAFT_WRAP_MIRROR) {
        const double cycle = floor(from);
        if (to > cycle + 1 || fabs(cycle) > 1e6) return all;
        const bool back = fmod(cycle, 2) != 0;
        from -= cycle, to -= cycle;
        if (back) {
            const double other = 1 - from;
            from = 1 - to, to = other;
        }
    }
    from = floor(from * n - 0.5 - error), to = floor(to * n - 0.5 + error) + 1;
    if (wrap != DAFT_WRAP_REPEAT) {
        const double last = n - 1;
        return (spans){{(int)fmin(fmax(from, 0), last), 0}, {(int)fmin(fmax(to, 0), last), -1}};
    }
    if (!(to - from < n - 1)) return all;
    const double cycle = floor(from / n) * n;
    from -= cycle, to -= cycle;
    if (to < n) return (spans){{(int)from, 0}, {(int)to, -1}};
    return (spans){{(int)from, 0}, {size - 1, (int)(to - n)}};
}

/* Of the texels of all spans. */
static byte_range spans_range(const pyramid *p, const spans *x, const spans *y)
{
    byte_range r = NOTHING;
    for (int i = 0; i < 4; i++) {
        const int a = i & 1, b = i >> 1;
        if (x->to[a] >= x->from[a] && y->to[b] >= y->from[b])
            include(&r, rectangle_range(p, x->from[a], x->to[a], y->from[b], y->to[b]));
    }
    return r;
}

static byte_range triangle_range(const pyramid *p, const daft_surface *m, const daft_vec2 uv[3])
{
    const byte_range anything = {0, 255};
    float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++) {
        /* rows count from the top: 1 - v, which wraps as v does */
        const float at[2] = {uv[k].x * m->map_scale.x + m->map_offset.x,
                             1 - (uv[k].y * m->map_scale.y + m->map_offset.y)};
        for (int i = 0; i < 2; i++) {
            if (!(fabsf(at[i]) < 0x1p20f)) return anything;
            low[i] = fminf(low[i], at[i]), high[i] = fmaxf(high[i], at[i]);
        }
    }
    const spans x = spans_between(low[0], high[0], p->texture->width[0], m->wrap),
                y = spans_between(low[1], high[1], p->texture->height[0], m->wrap);
    return spans_range(p, &x, &y);
}

/* Least and largest alpha of a triangle's vertices. */
typedef struct alpha_range {
    float min, max;
} alpha_range;

/* Filters round: what comes within `close` of a limit may be on either side, unless all texels are the same end. */
static uint8_t class_of(const daft_surface *m, byte_range r, alpha_range own)
{
    const daft_vec3 passes = m->transmittance;
    const bool stops = !(passes.x > 0 || passes.y > 0 || passes.z > 0);
    const float close = 1e-5f, least = (float)r.min / 255 * m->opacity * own.min,
                most = (float)r.max / 255 * m->opacity * own.max;
    const bool whole = r.min == 255 && own.min >= 1, nothing = r.max == 0 || own.max <= 0;
    bool full, none;
    if (m->cutoff > 0) {
        full = least >= m->cutoff + close || (whole && m->opacity >= m->cutoff);
        none = nothing || most < m->cutoff - close;
    } else {
        full = whole && m->opacity >= 1, none = nothing || m->opacity <= 0;
    }
    if (none) return DAFT_OPACITY_CLEAR;
    return full && stops ? DAFT_OPACITY_OPAQUE : DAFT_OPACITY_MIXED;
}

static void corners_uv(const daft_trimesh *mesh, uint32_t triangle, daft_vec2 uv[3])
{
    const uint32_t *corner = &(mesh->uv_indices ? mesh->uv_indices : mesh->indices)[3 * (size_t)triangle];
    for (int k = 0; k < 3; k++) uv[k] = mesh->uvs && corner[k] != DAFT_NO_UV ? mesh->uvs[corner[k]] : (daft_vec2){0, 0};
}

static alpha_range corners_alpha(const daft_trimesh *mesh, uint32_t triangle)
{
    const uint32_t *corner = &(mesh->color_indices ? mesh->color_indices : mesh->indices)[3 * (size_t)triangle];
    const float a = mesh->alphas[corner[0]], b = mesh->alphas[corner[1]], c = mesh->alphas[corner[2]];
    return (alpha_range){fminf(a, fminf(b, c)), fmaxf(a, fmaxf(b, c))};
}

/* The triangles of one slot. */
static bool classify(const daft_allocator *allocator, const daft_trimesh *mesh, uint32_t slot, const daft_surface *m,
                     const daft_texture_data *textures, uint8_t *out)
{
    const uint32_t map = m->maps[DAFT_MAP_ALPHA];
    const bool blends = daft_surface_blends(m), reads = blends && map != DAFT_NO_TEXTURE,
               fades = blends && mesh->alphas;
    const byte_range full = {255, 255};
    const uint8_t alike = class_of(m, full, (alpha_range){1, 1}); /* without a texture */
    pyramid p = {0};
    if (reads && !pyramid_make(allocator, &textures[map], m->alpha_channel, &p)) return false;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        daft_vec2 uv[3];
        if ((mesh->slots ? mesh->slots[i] : 0) != slot) continue;
        if (reads) corners_uv(mesh, i, uv);
        out[i] = reads || fades ? class_of(m, reads ? triangle_range(&p, m, uv) : full,
                                           fades ? corners_alpha(mesh, i) : (alpha_range){1, 1})
                                : alike;
    }
    if (reads) daft_release(allocator, p.cells[0]);
    return true;
}

bool daft_opacity_classify(const daft_allocator *allocator, const daft_trimesh *mesh, const daft_surface *surfaces,
                           const uint32_t *materials, const daft_texture_data *textures, uint8_t *out)
{
    for (uint32_t slot = 0; slot < daft_max_u(mesh->slot_count, 1); slot++)
        if (!classify(allocator, mesh, slot, &surfaces[materials[slot]], textures, out)) return false;
    return true;
}

/* ---- masks ---- */

#define MASK_SLACK 0.4f                                                      /* texels */
enum { FARTHEST = 255 };                                                     /* cells */
enum { LEAST_CELLS = 256 * 256, MOST_CELLS = 1024 * 1024, CELLS_EACH = 16 }; /* the last: of each triangle */

/* Texels of a cell's side: one, or as many more as keep the cells few enough. */
static int side_of_cells(const daft_texture_data *t, uint32_t triangles)
{
    const size_t least = LEAST_CELLS, most = MOST_CELLS, wanted = CELLS_EACH * (size_t)triangles,
                 limit = wanted < least  ? least
                         : wanted > most ? most
                                         : wanted;
    int side = 1;
    while ((((size_t)t->width[0] - 1) / (size_t)side + 1) * (((size_t)t->height[0] - 1) / (size_t)side + 1) > limit)
        side *= 2;
    return side;
}

static size_t words_of(const daft_mask *m)
{
    return ((size_t)m->columns * (size_t)m->rows + DAFT_MASK_CELLS - 1) / DAFT_MASK_CELLS;
}

/* What filters may read for any place in a cell of so many texels, and in so many texels around it. */
static spans spans_of_cell(int cell, int side, int size, float around, uint32_t wrap)
{
    const float n = (float)size;
    float low = ((float)(cell * side) - around) / n, high = ((float)((cell + 1) * side) + around) / n;
    if (wrap != DAFT_WRAP_REPEAT) low = fmaxf(low, 0), high = fminf(high, 1);
    return spans_between(low, high, size, wrap);
}

typedef struct mask_job {
    const pyramid *p;
    const daft_surface *surface;
    int side;
} mask_job;

static byte_range cell_range(const mask_job *j, int column, int row)
{
    const daft_texture_data *t = j->p->texture;
    const spans x = spans_of_cell(column, j->side, t->width[0], MASK_SLACK, j->surface->wrap),
                y = spans_of_cell(row, j->side, t->height[0], MASK_SLACK, j->surface->wrap);
    return spans_range(j->p, &x, &y);
}

/* How many cells away the nearest is in which alpha is not 0 everywhere, the larger of columns and rows; 0: this one.
 */
typedef struct distances {
    int columns, rows;
    bool repeats;
    uint8_t *cells;
} distances;

static int distance_at(const distances *d, int column, int row)
{
    if (d->repeats) column = (column + d->columns) % d->columns, row = (row + d->rows) % d->rows;
    const bool within = column >= 0 && column < d->columns && row >= 0 && row < d->rows;
    return within ? d->cells[(size_t)row * (size_t)d->columns + (size_t)column] : FARTHEST;
}

/* From the neighbours that a pass has been at: `by` 1 downwards, -1 upwards. */
static void pass_distances(const distances *d, int by)
{
    for (int i = 0; i < d->rows; i++) {
        const int row = by > 0 ? i : d->rows - 1 - i;
        for (int k = 0; k < d->columns; k++) {
            const int column = by > 0 ? k : d->columns - 1 - k;
            uint8_t *own = &d->cells[(size_t)row * (size_t)d->columns + (size_t)column];
            int least = distance_at(d, column - by, row);
            for (int across = -1; across <= 1; across++)
                least = daft_min_i(least, distance_at(d, column + across, row - by));
            *own = (uint8_t)daft_min_i(*own, daft_min_i(least + 1, FARTHEST));
        }
    }
}

/* Filters of a pixel with 2^k texels a side read level k at most, there a texel and a half around it, or two and a half
 * where a level is not half the one before. The last cells of a texture that repeats may be narrower than others. */
static uint32_t hole_of(const mask_job *j, int distance)
{
    const daft_texture_data *t = j->p->texture;
    const int width = t->width[0], height = t->height[0], narrow = width % j->side || height % j->side;
    const float reach = width & (width - 1) || height & (height - 1) ? 2.5f : 1.5f;
    uint32_t hole = 0;
    for (float texels = 2; hole < DAFT_MASK_HOLES; hole++, texels *= 2)
        if (distance <= (int)ceilf((MASK_SLACK + texels * reach) / (float)j->side) + narrow) break;
    return hole;
}

static void fill_cells(const mask_job *j, const distances *d, uint32_t *cells)
{
    const byte_range all = {0, 255};
    size_t at = 0;
    for (int row = 0; row < d->rows; row++)
        for (int column = 0; column < d->columns; column++, at++) {
            const byte_range r = j->surface->opacity > 0 ? cell_range(j, column, row) : all;
            d->cells[at] = r.max ? 0 : FARTHEST;
            cells[at / DAFT_MASK_CELLS] |= (uint32_t)class_of(j->surface, r, (alpha_range){1, 1})
                                           << DAFT_MASK_BITS * (at % DAFT_MASK_CELLS);
        }
    for (int pass = 0; pass < (d->repeats ? 4 : 2); pass++) pass_distances(d, pass % 2 ? -1 : 1);
    for (size_t i = 0; i < at; i++)
        cells[i / DAFT_MASK_CELLS] += hole_of(j, d->cells[i]) << DAFT_MASK_BITS * (i % DAFT_MASK_CELLS);
}

static bool mask_make(const daft_allocator *allocator, const daft_trimesh *mesh, const daft_surface *m,
                      const daft_texture_data *textures, daft_mask *out)
{
    const uint32_t map = m->maps[DAFT_MAP_ALPHA];
    pyramid p;
    *out = (daft_mask){0};
    if (!daft_surface_blends(m) || mesh->alphas) return true;
    out->even = map == DAFT_NO_TEXTURE;
    if (out->even) return true;
    const daft_texture_data *t = &textures[map];
    const int side = side_of_cells(t, mesh->triangle_count);
    *out = (daft_mask){.columns = (t->width[0] - 1) / side + 1,
                       .rows = (t->height[0] - 1) / side + 1,
                       .across = (float)t->width[0] / (float)side,
                       .down = (float)t->height[0] / (float)side,
                       .width = (float)t->width[0],
                       .height = (float)t->height[0],
                       .slack_u = MASK_SLACK / (float)t->width[0],
                       .slack_v = MASK_SLACK / (float)t->height[0],
                       .scale_u = m->map_scale.x,
                       .scale_v = m->map_scale.y,
                       .offset_u = m->map_offset.x,
                       .offset_v = m->map_offset.y,
                       .wrap = m->wrap,
                       .map = map,
                       .channel = m->alpha_channel};
    if (m->cutoff > 0 && m->opacity > 0) out->cutoff = m->cutoff / m->opacity;
    const distances d = {out->columns, out->rows, m->wrap == DAFT_WRAP_REPEAT,
                         daft_alloc(allocator, (size_t)out->columns * (size_t)out->rows, 1)};
    uint32_t *cells = daft_alloc_zero(allocator, words_of(out), sizeof *cells);
    const bool made = cells && d.cells && pyramid_make(allocator, t, m->alpha_channel, &p);
    if (made) {
        fill_cells(&(mask_job){&p, m, side}, &d, cells);
        daft_release(allocator, p.cells[0]);
    } else {
        daft_release(allocator, cells);
    }
    daft_release(allocator, d.cells);
    if (!made) return false;
    out->cells = cells;
    return true;
}

bool daft_masks_make(const daft_allocator *allocator, const daft_trimesh *mesh, const daft_surface *surfaces,
                     const uint32_t *materials, const daft_texture_data *textures, daft_mask *out)
{
    for (uint32_t slot = 0; slot < daft_max_u(mesh->slot_count, 1); slot++) {
        if (mask_make(allocator, mesh, &surfaces[materials[slot]], textures, &out[slot])) continue;
        daft_masks_free(allocator, out, slot);
        return false;
    }
    return true;
}

void daft_masks_free(const daft_allocator *allocator, daft_mask *masks, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) daft_release(allocator, (void *)(uintptr_t)masks[i].cells);
}

size_t daft_masks_bytes(const daft_mask *masks, uint32_t count)
{
    size_t bytes = count * sizeof *masks;
    for (uint32_t i = 0; i < count; i++) bytes += masks[i].cells ? words_of(&masks[i]) * sizeof *masks[i].cells : 0;
    return bytes;
}
