/* With corners c and edges' planes n_k = c_k+1 x c_k+2, a ray d meets a triangle with weights n_k . d over their sum
 * s = N . d, at a depth z = N . c_0 · focal / s. A pixel's patch on the surface is z² · |d|² / (focal⁴ · cosine) large,
 * with cosine = |s| / (|N| · |d|), and of T texels for each unit of area it has as many times more (the square of
 * surface_kernel.c's footprint). So a hole's largest pixel is a least s. */
#include "raster/holes.h"

#include <math.h>
#include <string.h>

/* Only levels from a quarter of one to the next on blend (texture_kernel.c), so a pixel reads no coarser one than its
 * own where it is 2^(1/4) as large, less a little for rounding: in s, its (-2/3)rd power. */
#define WIDER 0.91

/* Coordinates are off by a few 2^-24 of theirs, beside what weights are off by. */
daft_mask_triangle daft_mask_triangle_of(const daft_mask *m, const daft_trimesh *mesh, uint32_t triangle)
{
    const uint32_t *corner = &(mesh->uv_indices ? mesh->uv_indices : mesh->indices)[3 * (size_t)triangle];
    const float tiny = 1e-30f;
    float u[3], v[3];
    for (int k = 0; k < 3; k++) {
        const daft_vec2 at = mesh->uvs && corner[k] != DAFT_NO_UV ? mesh->uvs[corner[k]] : (daft_vec2){0, 0};
        u[k] = at.x * m->scale_u + m->offset_u, v[k] = 1 - (at.y * m->scale_v + m->offset_v);
    }
    daft_mask_triangle t = {
        .mask = m, .u = u[0], .v = v[0], .u1 = u[1] - u[0], .v1 = v[1] - v[0], .u2 = u[2] - u[0], .v2 = v[2] - v[0]};
    const float wide = fabsf(t.u1) + fabsf(t.u2), high = fabsf(t.v1) + fabsf(t.v2);
    t.left_u = m->slack_u - (1 + fabsf(m->offset_u) + fabsf(u[0]) + wide) * 0x1p-20f;
    t.left_v = m->slack_v - (1 + fabsf(m->offset_v) + fabsf(v[0]) + high) * 0x1p-20f;
    t.most = fminf(t.left_u / fmaxf(wide, tiny), t.left_v / fmaxf(high, tiny));
    return t;
}

daft_hole_view daft_hole_view_of(const daft_raster *raster, const daft_pencil *pencil, int x, int y, int side)
{
    daft_pencil straight = *pencil;
    straight.turn = 0;
    const float end = (float)side;
    const daft_vec3 first = daft_pencil_ray(&straight, x, y);
    const float across = fmaxf(fabsf(first.x), fabsf(first.x + end)) / pencil->focal,
                down = fmaxf(fabsf(first.y), fabsf(first.y - end)) / pencil->focal;
    return (daft_hole_view){.left = first.x,
                            .top = first.y,
                            .focal = pencil->focal,
                            .turn = pencil->turn,
                            .own = raster->pencil.focal,
                            .side = end,
                            .slant = sqrtf(1 + across * across + down * down),
                            .textures = raster->textures};
}

/* A product with rays. Gives what its sums are off by. */
static float place(const daft_hole_view *j, daft_dvec3 n, float out[3])
{
    out[0] = (float)(n.x * (double)j->left + n.y * (double)j->top + n.z * (double)j->focal);
    out[1] = (float)n.x, out[2] = (float)-n.y;
    return (fabsf(out[0]) + j->side * (fabsf(out[1]) + fabsf(out[2]))) * 0x1p-22f;
}

static daft_dvec3 weighted(const daft_dvec3 n[3], double a, double b, double c)
{
    return daft_dadd(daft_dadd(daft_dscale(n[0], a), daft_dscale(n[1], b)), daft_dscale(n[2], c));
}

/* How many texels a pixel's patch holds, but for what hangs on its ray. `depth`: N . c_0. */
static double patch_of(const daft_hole_view *j, const daft_mask_triangle *t, double depth)
{
    const double texels = fabs((double)t->u1 * (double)t->v2 - (double)t->u2 * (double)t->v1) * (double)t->mask->width *
                          (double)t->mask->height;
    return texels * depth * depth / ((double)j->own * (double)j->own);
}

static void limit_sizes(const daft_hole_view *j, double patch, daft_holes *out)
{
    const double least = cbrt(patch) * (double)j->slant * (double)j->focal;
    double most = 2;
    for (int k = 0; k < 1 << DAFT_MASK_BITS; k++) out->least_s[k] = INFINITY;
    for (int k = 1; k <= DAFT_MASK_HOLES; k++, most *= 2)
        out->least_s[DAFT_OPACITY_CLEAR + k] = (float)(least / cbrt(most * most) * WIDER);
}

static void set_texture(const daft_hole_view *j, double patch, double normal, daft_holes *out)
{
    const daft_mask *m = out->on.mask;
    out->texture = m->cutoff > 0 && j->textures ? &j->textures[m->map] : NULL;
    if (!out->texture) return;
    out->area = (float)patch, out->grazing = DAFT_HOLE_GRAZING * (float)normal;
    out->left = j->left, out->top = j->top, out->focal2 = j->focal * j->focal;
}

/* Whether the triangle is so long and wide in pixels that it is worth asking. One that reaches behind the camera is. */
static bool is_large(const daft_hole_view *j, const daft_vec3 c[3])
{
    const double focal = (double)j->focal;
    double x[3], y[3];
    for (int k = 0; k < 3; k++) {
        if (!(c[k].z > 0)) return true;
        x[k] = (double)c[k].x * focal / (double)c[k].z, y[k] = (double)c[k].y * focal / (double)c[k].z;
    }
    const double wide = fmax(x[0], fmax(x[1], x[2])) - fmin(x[0], fmin(x[1], x[2])),
                 high = fmax(y[0], fmax(y[1], y[2])) - fmin(y[0], fmin(y[1], y[2])), length = fmax(wide, high),
                 area = fabs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])) / 2;
    return length >= 4 && area >= length;
}

bool daft_holes_make(const daft_hole_view *j, const daft_view_instance *view, uint32_t triangle, daft_holes *out)
{
    const daft_instance *s = view->instance;
    const daft_mask *mask = daft_mask_of(s, triangle);
    daft_vec3 at[3];
    daft_dvec3 c[3], n[3];
    if (!mask || !mask->cells || (s->opacity && s->opacity[triangle] == DAFT_OPACITY_OPAQUE)) return false;
    daft_view_corners(view, triangle, at);
    if (!is_large(j, at)) return false;
    for (int k = 0; k < 3; k++) c[k] = daft_to_double(at[k]);
    for (int k = 0; k < 3; k++) n[k] = daft_dcross(c[(k + 1) % 3], c[(k + 2) % 3]);
    const daft_dvec3 sum = weighted(n, 1, 1, 1);
    out->on = daft_mask_triangle_of(mask, s->mesh, triangle);
    const daft_mask_triangle *t = &out->on;
    const double u = (double)t->u, v = (double)t->v;
    out->turn = j->turn;
    out->off_s = place(j, sum, out->s);
    out->off_u = place(j, weighted(n, u, u + (double)t->u1, u + (double)t->u2), out->u);
    out->off_v = place(j, weighted(n, v, v + (double)t->v1, v + (double)t->v2), out->v);
    const double patch = patch_of(j, t, daft_ddot(sum, c[0]));
    limit_sizes(j, patch, out);
    set_texture(j, patch, sqrt(daft_ddot(sum, sum)), out);
    return true;
}

/* ---- pixels one by one, as raster/grid/holes_kernel.c has them ---- */

/* vf_log2 */
static float log2_of(float x)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    const int32_t exponent = (bits - 0x3f3504f3) >> 23, mantissa = bits - (int32_t)((uint32_t)exponent << 23);
    float m;
    memcpy(&m, &mantissa, sizeof m);
    const float z = (m - 1) / (m + 1), z2 = z * z;
    float s = 1.0f / 9;
    s = s * z2 + 1.0f / 7;
    s = s * z2 + 1.0f / 5;
    s = s * z2 + 1.0f / 3;
    return (float)exponent + (z + z * z2 * s) * 2.88539008f;
}

typedef struct taps {
    int first, second;
    float weight;
} taps;

static taps taps_at(float place, int size, bool edges)
{
    const float last = (float)size - (edges ? 1.0f : 0.5f),
                x = fminf(fmaxf(place * (float)size - 0.5f, edges ? 0 : -0.5f), last);
    const int below = (int)(x + 1) - 1;
    return (taps){below < 0 ? size - 1 : below, below + 1 < size ? below + 1 : 0, x - (float)below};
}

static float byte_at(const daft_holes *h, int level, int row, int column)
{
    const size_t texel = (size_t)row * (size_t)h->texture->width[level] + (size_t)column;
    return (float)h->texture->texels[level][4 * texel + h->on.mask->channel] * (1.0f / 255);
}

static float level_alpha(const daft_holes *h, int level, float u, float v)
{
    const bool edges = h->on.mask->wrap != DAFT_WRAP_REPEAT;
    const taps x = taps_at(u, h->texture->width[level], edges), y = taps_at(v, h->texture->height[level], edges);
    const float a = byte_at(h, level, y.first, x.first), b = byte_at(h, level, y.first, x.second),
                c = byte_at(h, level, y.second, x.first), d = byte_at(h, level, y.second, x.second);
    const float top = a + (b - a) * x.weight, bottom = c + (d - c) * x.weight;
    return top + (bottom - top) * y.weight;
}

static float filtered_alpha(const daft_holes *h, float u, float v, float area)
{
    const float level = fminf(fmaxf(log2_of(fmaxf(area, 1e-30f)) * 0.5f, 0), (float)(h->texture->levels - 1));
    int fine = (int)level;
    float blend = (level - (float)fine) * 2 - 0.5f;
    if (blend >= 1) fine++, blend = 0;
    u = daft_mask_wrapped(u, h->on.mask->wrap), v = daft_mask_wrapped(v, h->on.mask->wrap);
    const float found = level_alpha(h, fine, u, v);
    return blend > 0 ? found * (1 - blend) + level_alpha(h, fine + 1, u, v) * blend : found;
}

typedef struct meeting {
    float column, row, size, u, v, off_u, off_v;
} meeting;

static bool reads_hole(const daft_holes *h, const meeting *m, uint32_t cell)
{
    const float dx = h->left + m->column, dy = h->top - m->row, length2 = dx * dx + dy * dy + h->focal2,
                steep = fmaxf(m->size / sqrtf(length2), h->grazing),
                area = h->area * length2 / (m->size * m->size * steep);
    if (cell == DAFT_OPACITY_OPAQUE && area <= DAFT_HOLE_FINEST) return false;
    const float off = m->off_u * h->on.mask->width + m->off_v * h->on.mask->height;
    return filtered_alpha(h, m->u, m->v, area) + (off + DAFT_HOLE_MARGIN) < h->on.mask->cutoff;
}

static float value_at(const float f[3], float column, float row) { return f[0] + (f[1] * column + f[2] * row); }

bool daft_in_hole(const daft_holes *h, int column, int row)
{
    meeting m = {.column = (float)column + h->turn * daft_pencil_turned(row),
                 .row = (float)row - h->turn * daft_pencil_turned(column)};
    const float s = value_at(h->s, m.column, m.row), inverse = 1 / s;
    m.size = fabsf(s);
    m.u = value_at(h->u, m.column, m.row) * inverse, m.v = value_at(h->v, m.column, m.row) * inverse;
    const float off_u = h->off_u + fabsf(m.u) * h->off_s, off_v = h->off_v + fabsf(m.v) * h->off_s;
    if (!(off_u <= h->on.left_u * m.size && off_v <= h->on.left_v * m.size)) return false;
    const uint32_t cell = daft_mask_cell(h->on.mask, m.u, m.v);
    if (h->least_s[cell] <= m.size) return true;
    if (!h->texture) return false;
    m.off_u = off_u / m.size + (h->on.mask->slack_u - h->on.left_u);
    m.off_v = off_v / m.size + (h->on.mask->slack_v - h->on.left_v);
    return reads_hole(h, &m, cell);
}
