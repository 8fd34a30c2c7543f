/* Texture sampling: trilinear unless another filter is asked for, in linear light. The mip level is the
 * log2 of the footprint's side in texels (Williams, "Pyramidal Parametrics", 1983). Lanes are points: those of one
 * texture that need one level of it are sampled together, and neighbours mostly do.
 *
 * Anisotropic filters take the mean of trilinear samples along the footprint's major axis, at the level of the minor
 * one (McCormack, Perry, Farkas, Jouppi, "Feline: Fast Elliptical Lines for Anisotropic Texture Mapping", SIGGRAPH
 * 1999; weights are equal here, as a pixel's are, which is what EXT_texture_filter_anisotropic does, too). */
#include "shade/batch_lanes.h"

#include "shade/srgb_table.h"

/* along_kernel.c compiles this file again, for anisotropic filters alone: they share all of it, and the others do not
 * pay for them with one instruction. */
#ifndef TEXTURES_ALONG
#define TEXTURES_ALONG false
#define TEXTURES(name) DAFT_KERNEL(name)
#endif

/* Points of one texture, whose two levels are `fine` and `fine` + 1, the latter with the weight `blend`. */
typedef struct texture_points {
    vf u, v; /* 0..1 */
    vi fine;
    vf blend; /* 0: one level serves */
    vf3 color;
    vf alpha;
    vm inside; /* lanes whose edges do not meet the opposite ones */
} texture_points;

/* What of the texels is asked for: sRGB colours as linear light or all bytes as they are, 0..1; constants where this is
 * inlined. */
typedef struct texture_use {
    bool linear, nearest, edges; /* edges: some lanes are `inside` */
} texture_use;

/* Offsets in texels of the four around each lane's point, and the weights between them. */
typedef struct texture_taps {
    vi above_left, above_right, below_left, below_right;
    vf across, down;
} texture_taps;

DAFT_INLINE vi wrap_above(vi i, int size) /* i < size */
{
    return vi_if_then_else(vi_lt(i, vi_set(0)), vi_set(size - 1), i);
}

DAFT_INLINE vi wrap_below(vi i, int size) /* 0 <= i <= size */
{
    return vi_if_then_else(vi_lt(i, vi_set(size)), i, vi_set(0));
}

/* Of lanes in `some`; the others' offsets are 0. The top row has v = 1. */
DAFT_INLINE texture_taps texture_place(const texture_points *p, int width, int height, vm some, bool edges)
{
    const vf half = vf_set(0.5f), one = vf_set(1), zero = vf_set(0);
    vf x = vf_if_then_else(some, p->u * vf_set((float)width) - half, zero),
       y = vf_if_then_else(some, (one - p->v) * vf_set((float)height) - half, zero);
    if (edges) {
        x = vf_if_then_else(p->inside, vf_min(vf_max(x, zero), vf_set((float)(width - 1))), x);
        y = vf_if_then_else(p->inside, vf_min(vf_max(y, zero), vf_set((float)(height - 1))), y);
    }
    vi x0 = vi_convert_to(x + one) - vi_set(1), y0 = vi_convert_to(y + one) - vi_set(1); /* floors: both are > -1 */
    vi left = wrap_above(x0, width), right = wrap_below(x0 + vi_set(1), width),
       above = wrap_above(y0, height) * vi_set(width), below = wrap_below(y0 + vi_set(1), height) * vi_set(width);
    return (texture_taps){above + left,  above + right,         below + left,
                          below + right, x - vf_convert_to(x0), y - vf_convert_to(y0)};
}

DAFT_INLINE vf decode(vi texel, int channel) { return vf_table_lookup256(SRGB_TO_LINEAR, texel >> (8 * channel)); }

/* The nearest of two texels has all the weight. */
DAFT_INLINE vf step_at_half(vf a) { return vf_if_then_else(vf_lt(a, vf_set(0.5f)), vf_set(0), vf_set(1)); }

DAFT_INLINE vf byte(vi texel, int channel)
{
    return vf_convert_to((texel >> (8 * channel)) & vi_set(255)) * vf_set(1.0f / 255);
}

DAFT_INLINE vf mix_four(vf a, vf b, vf c, vf d, const texture_taps *at)
{
    vf top = a + (b - a) * at->across, bottom = c + (d - c) * at->across;
    return top + (bottom - top) * at->down;
}

/* Adds one level to the colour of the lanes in `some`. */
DAFT_INLINE void add_level_as(const daft_texture_data *t, int level, vm some, vf weight, texture_use use,
                              texture_points *p)
{
    texture_taps at = texture_place(p, t->width[level], t->height[level], some, use.edges);
    if (use.nearest) at.across = step_at_half(at.across), at.down = step_at_half(at.down);
    const uint8_t *texels = t->texels[level];
    const vi a = vi_gather_index(texels, at.above_left), b = vi_gather_index(texels, at.above_right),
             c = vi_gather_index(texels, at.below_left), d = vi_gather_index(texels, at.below_right);
    vf sum[3] = {p->color.x, p->color.y, p->color.z};
    weight = vf_if_then_else(some, weight, vf_set(0));
    for (int k = 0; k < 3; k++) {
        if (use.linear)
            sum[k] = sum[k] + weight * mix_four(byte(a, k), byte(b, k), byte(c, k), byte(d, k), &at);
        else
            sum[k] = sum[k] + weight * mix_four(decode(a, k), decode(b, k), decode(c, k), decode(d, k), &at);
    }
    p->color = (vf3){sum[0], sum[1], sum[2]};
    if (use.linear) p->alpha += weight * mix_four(byte(a, 3), byte(b, 3), byte(c, 3), byte(d, 3), &at);
}

static void add_level(const daft_texture_data *t, int level, vm some, vf weight, texture_use use, texture_points *p)
{
    use.linear = false;
    add_level_as(t, level, some, weight, use, p);
}

static void add_linear_level(const daft_texture_data *t, int level, vm some, vf weight, texture_use use,
                             texture_points *p)
{
    use.linear = true;
    add_level_as(t, level, some, weight, use, p);
}

DAFT_INLINE bool is_flat(daft_texture_filter filter)
{
    return filter == DAFT_TEXTURE_BILINEAR || filter == DAFT_TEXTURE_NEAREST;
}

/* Two levels blend in the middle half of the interval between them; in the outer quarters one level serves, which
 * halves the fetches and is not seen. */
DAFT_INLINE void choose_levels(const daft_texture_data *t, vf level, daft_texture_filter filter, texture_points *p)
{
    const vf zero = vf_set(0), one = vf_set(1);
    level = vf_min(vf_max(level, zero), vf_set(is_flat(filter) ? 0 : (float)(t->levels - 1)));
    if (filter == DAFT_TEXTURE_MIPMAP) level = vf_floor(level + vf_set(0.5f));
    vi fine = vi_convert_to(level);
    vf blend = (level - vf_convert_to(fine)) * vf_set(2) - vf_set(0.5f);
    vm next = vf_le(one, blend);
    p->fine = vi_if_then_else(next, fine + vi_set(1), fine);
    p->blend = vf_if_then_else(next, zero, vf_max(blend, zero));
}

/* The colour of the lanes in `some`, which all have this texture. */
DAFT_INLINE void sample(const daft_texture_data *t, vf level, daft_texture_filter filter, vbits some, texture_use use,
                        texture_points *p)
{
    const vf zero = vf_set(0);
    choose_levels(t, level, filter, p);
    vbits fine = some, coarse = some & vbits_from_mask(vf_lt(zero, p->blend));
    while (fine | coarse) {
        const int lane = __builtin_ctz(fine | coarse), now = p->fine[lane] + (fine >> lane & 1 ? 0 : 1);
        const vbits in_fine = fine & vbits_from_mask(vi_eq(p->fine, vi_set(now))),
                    in_coarse = coarse & vbits_from_mask(vi_eq(p->fine, vi_set(now - 1)));
        const vf weight = vf_if_then_else(vm_from_bits(in_fine), vf_set(1) - p->blend, p->blend);
        (use.linear ? add_linear_level : add_level)(t, now, vm_from_bits(in_fine | in_coarse), weight, use, p);
        fine &= ~in_fine, coarse &= ~in_coarse;
    }
}

DAFT_INLINE vf fraction(vf a)
{
    vf bounded = vf_if_then_else(vf_lt(vf_abs(a), vf_set(8388608.0f)), a, vf_set(0)); /* beyond 2^23 there is no
                                                                                         fraction */
    return bounded - vf_floor(bounded);
}

/* Where in the picture a coordinate is, 0..1: repeated, and where `wrap` says so held at the edge or mirrored. */
DAFT_INLINE vf wrapped(vf a, vi wrap, vm inside)
{
    vf repeated = fraction(a), half = fraction(a * vf_set(0.5f)) * vf_set(2);
    vf mirrored = vf_if_then_else(vf_lt(vf_set(1), half), vf_set(2) - half, half);
    vf held = vf_if_then_else(vi_eq(wrap, vi_set(DAFT_WRAP_CLAMP)), vf_clamp01(a), mirrored);
    return vf_if_then_else(inside, held, repeated);
}

/* Texture coordinates of DAFT_VL points as their materials turn them, before they are put into the picture and then,
 * and the footprint in texels of a texture of one texel. */
typedef struct texture_lanes {
    vf free_u, free_v, u, v, footprint;
    vi wrap;
    vm inside;
    bool edges;
    vf first_u, first_v, second_u, second_v; /* of daft_footprints; for anisotropic filters alone */
} texture_lanes;

DAFT_INLINE void put_inside(texture_lanes *at)
{
    if (at->edges) {
        at->u = wrapped(at->free_u, at->wrap, at->inside), at->v = wrapped(at->free_v, at->wrap, at->inside);
    } else {
        at->u = fraction(at->free_u), at->v = fraction(at->free_v);
    }
}

DAFT_INLINE texture_lanes lanes_of(const daft_batch *batch, const material_reader *m, uint32_t i)
{
    const vf su = MATERIAL_WORD(m, map_scale.x), sv = MATERIAL_WORD(m, map_scale.y);
    texture_lanes at = {.footprint = vf_load(&batch->footprint[i]) * vf_sqrt(vf_abs(su * sv))};
    at.wrap = (vi)MATERIAL_WORD(m, wrap);
    at.free_u = vf_load(&batch->u[i]) * su + MATERIAL_WORD(m, map_offset.x);
    at.free_v = vf_load(&batch->v[i]) * sv + MATERIAL_WORD(m, map_offset.y);
    at.inside = vm_not(vi_eq(at.wrap, vi_set(DAFT_WRAP_REPEAT)));
    at.edges = vbits_from_mask(at.inside) != 0;
    put_inside(&at);
    if (TEXTURES_ALONG) {
        const daft_footprints *f = batch->footprints;
        at.first_u = vf_load(&f->first_u[i]) * su, at.first_v = vf_load(&f->first_v[i]) * sv;
        at.second_u = vf_load(&f->second_u[i]) * su, at.second_v = vf_load(&f->second_v[i]) * sv;
    }
    return at;
}

/* ---- along the footprint ---- */

/* The major axis in units of u and v, how many samples lie along it, and the side in texels of what each stands for. */
typedef struct texture_line {
    vf u, v, count, side;
} texture_line;

/* With the diameters as columns of M, in texels, the squares of the ellipse's axes are the eigenvalues of M times its
 * transpose, and their product is the square of M's determinant. Up to 1/8 more than the minor axis, and no less than a
 * texel, is left to each sample. */
DAFT_INLINE texture_line line_of(const texture_lanes *at, const daft_texture_data *t, daft_texture_filter filter)
{
    const vf width = vf_set((float)t->width[0]), height = vf_set((float)t->height[0]);
    const vf least = vf_set(1e-20f), zero = vf_set(0), one = vf_set(1), half = vf_set(0.5f);
    const vf ax = at->first_u * width, ay = at->first_v * height, bx = at->second_u * width, by = at->second_v * height;
    const vf xx = ax * ax + bx * bx, xy = ax * ay + bx * by, yy = ay * ay + by * by;
    const vf apart = (xx - yy) * half, root = vf_sqrt(apart * apart + xy * xy);
    const vf major = vf_sqrt(vf_max((xx + yy) * half + root, least)), minor = vf_abs(ax * by - ay * bx) / major;
    const vf most = vf_set(filter == DAFT_TEXTURE_ANISOTROPIC4 ? 4 : 16);
    const vf ratio = vf_min(vf_max(major / vf_max(minor, one), one), most);
    const vm flat = vf_lt(apart, zero); /* the eigenvector by the row that is not near zero */
    const vf x = vf_if_then_else(flat, xy, root + apart), y = vf_if_then_else(flat, root - apart, xy);
    const vf scale = major / vf_sqrt(vf_max(x * x + y * y, least));
    texture_line line = {.u = x * scale / width, .v = y * scale / height};
    line.count = vf_floor(ratio + vf_set(0.875f));
    line.side = vf_max(minor, major / line.count);
    return line;
}

/* The same as sample() and, in p, the same sums. */
static void sample_along(const daft_texture_data *t, const texture_lanes *at, daft_texture_filter filter, vbits some,
                         texture_use use, texture_points *p)
{
    const vf half = vf_set(0.5f), one = vf_set(1), zero = vf_set(0);
    const texture_line line = line_of(at, t, filter);
    const vf level = vf_log2(vf_max(line.side, vf_set(1e-20f))), share = one / line.count;
    vbits left = some;
    for (int k = 0; left; k++) {
        const vf along = (vf_set((float)k) + half) * share - half;
        texture_lanes tap = *at;
        tap.free_u += line.u * along, tap.free_v += line.v * along;
        put_inside(&tap);
        texture_points one_of = {.u = tap.u, .v = tap.v, .inside = at->inside};
        one_of.color = (vf3){zero, zero, zero}, one_of.alpha = zero;
        sample(t, level, filter, left, use, &one_of);
        p->color = (vf3){p->color.x + one_of.color.x * share, p->color.y + one_of.color.y * share,
                         p->color.z + one_of.color.z * share};
        p->alpha += one_of.alpha * share;
        left &= vbits_from_mask(vf_lt(vf_set((float)k + 1.5f), line.count));
    }
}

/* The side, in texels, of what one sample stands for. */
DAFT_INLINE vf side_of(const texture_lanes *at, const daft_texture_data *t, daft_texture_filter filter)
{
    if (TEXTURES_ALONG) return line_of(at, t, filter).side;
    return at->footprint * vf_set(sqrtf((float)t->width[0] * (float)t->height[0]));
}

/* What DAFT_VL points have of their textures; of those without one *out stays as it is. */
DAFT_INLINE void sample_lanes(const texture_lanes *at, vi texture, vbits left, const daft_texture_data *textures,
                              daft_texture_filter filter, bool linear, vf3 *color, vf *alpha)
{
    while (left) {
        const int32_t number = texture[__builtin_ctz(left)];
        const daft_texture_data *t = &textures[number];
        const vbits same = left & vbits_from_mask(vi_eq(texture, vi_set(number)));
        texture_points p = {.u = at->u, .v = at->v, .inside = at->inside};
        p.color = (vf3){vf_set(0), vf_set(0), vf_set(0)}, p.alpha = vf_set(0);
        const texture_use use = {.linear = linear, .nearest = filter == DAFT_TEXTURE_NEAREST, .edges = at->edges};
        if (TEXTURES_ALONG)
            sample_along(t, at, filter, same, use, &p);
        else
            sample(t, vf_log2(vf_max(side_of(at, t, filter), vf_set(1e-20f))), filter, same, use, &p);
        const vm mask = vm_from_bits(same);
        *color = (vf3){vf_if_then_else(mask, p.color.x, color->x), vf_if_then_else(mask, p.color.y, color->y),
                       vf_if_then_else(mask, p.color.z, color->z)};
        if (linear) *alpha = vf_if_then_else(mask, p.alpha, *alpha);
        left &= ~same;
    }
}

DAFT_INLINE vbits with_texture(const daft_batch *batch, vi texture, uint32_t i)
{
    return vbits_first_n((int)daft_min_u(batch->count - i, DAFT_VL)) &
           ~vbits_from_mask(vi_eq(texture, vi_set((int32_t)DAFT_NO_TEXTURE)));
}

bool TEXTURES(daft_albedo)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                           daft_texture_filter filter)
{
    if (!TEXTURES_ALONG && daft_filter_is_anisotropic(filter))
        return DAFT_KERNEL(daft_albedo_along)(batch, materials, textures, filter);
    const vf one = vf_set(1);
    const bool colors = batch->traits & DAFT_TRAIT_COLORS;
    bool any = false;
    for (uint32_t i = 0; i < batch->count; i += DAFT_VL) {
        const material_reader m = read_materials(batch, materials, i);
        const vi texture = (vi)MATERIAL_WORD(&m, texture);
        const vbits some = with_texture(batch, texture, i);
        vf3 albedo = {one, one, one};
        vf unused = one;
        if (some) {
            const texture_lanes at = lanes_of(batch, &m, i);
            sample_lanes(&at, texture, some, textures, filter, false, &albedo, &unused);
            any = true;
        }
        if (colors) {
            const vf3 own = lanes_load(&batch->albedo, i);
            albedo = (vf3){albedo.x * own.x, albedo.y * own.y, albedo.z * own.z};
        }
        lanes_store(&batch->albedo, i, albedo);
    }
    return any;
}

void TEXTURES(daft_map_color)(const daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                              daft_texture_filter filter, uint32_t map, bool linear, uint32_t i, vf3 *color, vf *alpha)
{
    if (!TEXTURES_ALONG && daft_filter_is_anisotropic(filter)) {
        DAFT_KERNEL(daft_map_color_along)(batch, materials, textures, filter, map, linear, i, color, alpha);
        return;
    }
    const material_reader m = read_materials(batch, materials, i);
    const vi texture = (vi)material_word(&m, offsetof(daft_surface, maps) / sizeof(float) + map);
    const vbits some = with_texture(batch, texture, i);
    if (!some) return;
    const texture_lanes at = lanes_of(batch, &m, i);
    if (linear)
        sample_lanes(&at, texture, some, textures, filter, true, color, alpha);
    else
        sample_lanes(&at, texture, some, textures, filter, false, color, alpha);
}

/* Heights at three places, half a texel of the level of detail apart, of which slopes are made: in texels of the full
 * image, as Blinn does in "Simulation of Wrinkled Surfaces" (SIGGRAPH 1978). */
void TEXTURES(daft_map_slopes)(const daft_batch *batch, const daft_surface *materials,
                               const daft_texture_data *textures, daft_texture_filter filter, uint32_t i, vf *along_u,
                               vf *along_v)
{
    if (!TEXTURES_ALONG && daft_filter_is_anisotropic(filter)) {
        DAFT_KERNEL(daft_map_slopes_along)(batch, materials, textures, filter, i, along_u, along_v);
        return;
    }
    const material_reader m = read_materials(batch, materials, i);
    const vi texture = (vi)MATERIAL_WORD(&m, maps[DAFT_MAP_BUMP]);
    for (vbits left = with_texture(batch, texture, i); left;) {
        const int32_t number = texture[__builtin_ctz(left)];
        const daft_texture_data *t = &textures[number];
        const vbits same = left & vbits_from_mask(vi_eq(texture, vi_set(number)));
        const vf width = vf_set((float)t->width[0]), height = vf_set((float)t->height[0]);
        texture_lanes at = lanes_of(batch, &m, i);
        vf step = is_flat(filter) ? vf_set(1) : vf_max(side_of(&at, t, filter), vf_set(1));
        vf heights[4], unused = vf_set(0);
        for (int k = 0; k < 4; k++) {
            const vf way = k & 1 ? step * vf_set(0.5f) : step * vf_set(-0.5f);
            texture_lanes near = at;
            if (k < 2) near.u = at.u + way / width, near.free_u = at.free_u + way / width;
            if (k >= 2) near.v = at.v + way / height, near.free_v = at.free_v + way / height;
            near.u = at.edges ? vf_if_then_else(at.inside, vf_clamp01(near.u), fraction(near.u)) : fraction(near.u);
            near.v = at.edges ? vf_if_then_else(at.inside, vf_clamp01(near.v), fraction(near.v)) : fraction(near.v);
            vf3 color = {vf_set(0), vf_set(0), vf_set(0)};
            sample_lanes(&near, texture, same, textures, filter, true, &color, &unused);
            heights[k] = color.y;
        }
        const vm mask = vm_from_bits(same);
        *along_u = vf_if_then_else(mask, (heights[1] - heights[0]) / step, *along_u);
        *along_v = vf_if_then_else(mask, (heights[3] - heights[2]) / step, *along_v);
        left &= ~same;
    }
}

#if !TEXTURES_ALONG /* the finest level is the same to all filters */
/* As the sky's image lies around the scene. The finest level: how fast the mirrored direction turns is not known. */
void DAFT_KERNEL(daft_map_around)(const daft_batch *batch, const daft_surface *materials,
                                  const daft_texture_data *textures, daft_texture_filter filter, uint32_t i,
                                  vf3 direction, vf3 *color)
{
    const material_reader m = read_materials(batch, materials, i);
    const vi texture = (vi)MATERIAL_WORD(&m, maps[DAFT_MAP_REFLECTION]);
    const vbits some = with_texture(batch, texture, i);
    if (!some) return;
    const vf half = vf_set(0.5f), level = vf_sqrt(direction.x * direction.x + direction.z * direction.z);
    texture_lanes at = {.footprint = vf_set(0), .inside = vm_from_bits(0)};
    at.u = fraction(half + vf_atan2(direction.z, direction.x) * vf_set(0.159154943f));
    at.v = vf_clamp01(half + vf_atan2(direction.y, level) * vf_set(0.318309886f));
    vf unused = vf_set(1);
    sample_lanes(&at, texture, some, textures, filter, false, color, &unused);
}
#endif
