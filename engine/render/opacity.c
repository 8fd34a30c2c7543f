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

static byte_range triangle_range(const pyramid *p, const daft_surface *m, const daft_vec2 uv[3])
{
    const byte_range anything = {0, 255};
    float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    byte_range r = NOTHING;
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
    for (int i = 0; i < 4; i++) {
        const int a = i & 1, b = i >> 1;
        if (x.to[a] >= x.from[a] && y.to[b] >= y.from[b])
            include(&r, rectangle_range(p, x.from[a], x.to[a], y.from[b], y.to[b]));
    }
    return r;
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
