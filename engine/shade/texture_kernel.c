/* Texture sampling: trilinear unless another filter is asked for, in linear light. The mip level is the log2 of the
 * footprint's side in texels (Williams, "Pyramidal Parametrics", 1983). What is read of one texture is collected first
 * (texture_taps.h): of DAFT_VL points for maps, of a batch's points for their colours.
 *
 * Anisotropic filters take the mean of trilinear samples along the footprint's major axis, at the level of the minor
 * one (McCormack, Perry, Farkas, Jouppi, "Feline: Fast Elliptical Lines for Anisotropic Texture Mapping", SIGGRAPH
 * 1999; weights are equal here, as a pixel's are, which is what EXT_texture_filter_anisotropic does, too).
 *
 * Close up, where a pixel has the size of a texel or less, one sample in its middle is not its mean: between texels
 * colours bend, and slopes of heights jump. There the same number of samples is spread over the pixel. */
#include "shade/batch_lanes.h"
#include "shade/texture_taps.h"

/* along_kernel.c compiles this file again, for anisotropic filters alone: they share all of it, and the others do not
 * pay for them with one instruction. */
#ifndef TEXTURES_ALONG
#define TEXTURES_ALONG false
#define TEXTURES(name) DAFT_KERNEL(name)
#endif

enum { MOST_TAPS = TEXTURES_ALONG ? 16 : 1 }; /* of a point, of one level */
_Static_assert(2 * MOST_TAPS * DAFT_VL <= TAP_BLOCK, "a list has room for all taps of DAFT_VL points");

DAFT_INLINE uint32_t most_taps(daft_texture_filter filter)
{
    return !TEXTURES_ALONG ? 1 : filter == DAFT_TEXTURE_ANISOTROPIC4 ? 4 : 16;
}

DAFT_INLINE bool is_flat(daft_texture_filter filter)
{
    return filter == DAFT_TEXTURE_BILINEAR || filter == DAFT_TEXTURE_NEAREST;
}

/* The level that a point's taps are of, and the weight of taps of the next one. */
typedef struct tap_levels {
    vi fine;
    vf blend; /* 0: one level serves */
} tap_levels;

/* Two levels blend in the middle half of the interval between them; in the outer quarters one level serves, which
 * halves the fetches and is not seen. */
DAFT_INLINE tap_levels choose_levels(const daft_texture_data *t, vf side, daft_texture_filter filter)
{
    const vf zero = vf_set(0), one = vf_set(1);
    vf level = vf_log2(vf_max(side, vf_set(1e-20f)));
    level = vf_min(vf_max(level, zero), vf_set(is_flat(filter) ? 0 : (float)(t->levels - 1)));
    if (filter == DAFT_TEXTURE_MIPMAP) level = vf_floor(level + vf_set(0.5f));
    vi fine = vi_convert_to(level);
    vf blend = (level - vf_convert_to(fine)) * vf_set(2) - vf_set(0.5f);
    vm next = vf_le(one, blend);
    return (tap_levels){vi_if_then_else(next, fine + vi_set(1), fine),
                        vf_if_then_else(next, zero, vf_max(blend, zero))};
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
    bool edges, spread;
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
        at.spread = f->spread;
        at.first_u = vf_load(&f->first_u[i]) * su, at.first_v = vf_load(&f->first_v[i]) * sv;
        at.second_u = vf_load(&f->second_u[i]) * su, at.second_v = vf_load(&f->second_v[i]) * sv;
    }
    return at;
}

/* ---- along the footprint ---- */

/* Of a pixel's side, what a level is chosen by: texels between which colours are interpolated weigh over twice their
 * own side. 0.77 has about the least error against 208 samples of each pixel in five scenes of assets/scenes; 1 and 0.5
 * have up to 4 % more. */
#define SHARP 0.77f

/* Sides, in texels, of pixels that are close up. Of smaller ones any point is the mean. */
#define CLOSE_LEAST 0.25f
#define CLOSE_MOST  1.5f

enum { SPREAD = 4 }; /* samples of a pixel that is close up, by a rotated grid */
static const float SPREAD_AT[SPREAD][2] = {{-0.125f, -0.375f}, {0.375f, -0.125f}, {0.125f, 0.375f}, {-0.375f, 0.125f}};

/* The major axis in units of u and v, how many samples lie along it, each one's weight, and the side in texels by which
 * their level is chosen; or those that are close up. */
typedef struct texture_line {
    vf u, v, count, share, side;
    vm close;
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
    const vf most = vf_set((float)most_taps(filter));
    const vf ratio = vf_min(vf_max(major / vf_max(minor, one), one), most);
    const vm flat = vf_lt(apart, zero); /* the eigenvector by the row that is not near zero */
    const vf x = vf_if_then_else(flat, xy, root + apart), y = vf_if_then_else(flat, root - apart, xy);
    const vf scale = major / vf_sqrt(vf_max(x * x + y * y, least));
    texture_line line = {.u = x * scale * vf_set(1.0f / (float)t->width[0])};
    line.v = y * scale * vf_set(1.0f / (float)t->height[0]);
    line.count = vf_floor(ratio + vf_set(0.875f)), line.share = one / line.count;
    line.side = vf_max(minor, major * line.share);
    line.close = vm_and(vm_and(vf_lt(vf_set(CLOSE_LEAST), line.side), vf_lt(line.side, vf_set(CLOSE_MOST))),
                        vf_lt(line.count, vf_set(2)));
    line.side *= vf_set(SHARP);
    return line;
}

/* Each of the samples close up stands for half the pixel's side. `some`: the lanes that may be. */
DAFT_INLINE void come_close(texture_line *line, vbits some)
{
    line->close = vm_and(line->close, vm_from_bits(some));
    line->count = vf_if_then_else(line->close, vf_set(SPREAD), line->count);
    line->share = vf_if_then_else(line->close, vf_set(1.0f / SPREAD), line->share);
    line->side = vf_if_then_else(line->close, vf_set(0.5f) * line->side, line->side);
}

/* Where sample k is, in units of u and v from the middle. */
DAFT_INLINE void sample_at(const texture_lanes *at, const texture_line *line, int k, vf *u, vf *v)
{
    const vf along = (vf_set((float)k) + vf_set(0.5f)) * line->share - vf_set(0.5f);
    *u = line->u * along, *v = line->v * along;
    if (k >= SPREAD || !vbits_from_mask(line->close)) return;
    const vf x = vf_set(SPREAD_AT[k][0]), y = vf_set(SPREAD_AT[k][1]);
    *u = vf_if_then_else(line->close, at->first_u * x + at->second_u * y, *u);
    *v = vf_if_then_else(line->close, at->first_v * x + at->second_v * y, *v);
}

/* The side, in texels, by which one sample's level is chosen. */
DAFT_INLINE vf side_of(const texture_lanes *at, const daft_texture_data *t, daft_texture_filter filter)
{
    if (TEXTURES_ALONG) return line_of(at, t, filter).side;
    return at->footprint * vf_set(sqrtf((float)t->width[0] * (float)t->height[0]));
}

/* ---- points ---- */

/* The taps of DAFT_VL points in a list: for each place along the footprint the lanes that have it, of their level and
 * of the next one. */
typedef struct tap_sums {
    vf fine, coarse; /* weights of each of a point's taps */
    uint32_t first, count;
    vbits of_fine[MOST_TAPS], of_coarse[MOST_TAPS];
} tap_sums;

DAFT_INLINE void add_place(tap_list *list, tap_sums *sums, const texture_lanes *at, vi level, vbits fine, vbits coarse)
{
    sums->of_fine[sums->count] = fine, sums->of_coarse[sums->count++] = coarse;
    add_taps(list, at->u, at->v, level, at->inside, at->edges, fine);
    if (coarse) add_taps(list, at->u, at->v, level + vi_set(1), at->inside, at->edges, coarse);
}

/* One place, in the middle. */
DAFT_INLINE void add_one(const daft_texture_data *t, const texture_lanes *at, daft_texture_filter filter, vbits some,
                         tap_list *list, tap_sums *sums)
{
    const tap_levels levels = choose_levels(t, side_of(at, t, filter), filter);
    add_place(list, sums, at, levels.fine, some, some & vbits_from_mask(vf_lt(vf_set(0), levels.blend)));
    sums->fine = vf_set(1) - levels.blend, sums->coarse = levels.blend;
}

DAFT_INLINE void add_along(const daft_texture_data *t, const texture_lanes *at, daft_texture_filter filter, vbits some,
                           tap_list *list, tap_sums *sums)
{
    texture_line line = line_of(at, t, filter);
    come_close(&line, at->spread ? some : 0);
    const tap_levels levels = choose_levels(t, line.side, filter);
    const vbits both = vbits_from_mask(vf_lt(vf_set(0), levels.blend));
    for (int k = 0; some; k++) {
        texture_lanes tap = *at;
        vf u, v;
        sample_at(at, &line, k, &u, &v);
        tap.free_u += u, tap.free_v += v;
        put_inside(&tap);
        add_place(list, sums, &tap, levels.fine, some, some & both);
        some &= vbits_from_mask(vf_lt(vf_set((float)k + 1.5f), line.count));
    }
    sums->fine = (vf_set(1) - levels.blend) * line.share, sums->coarse = levels.blend * line.share;
}

/* Adds the taps of the lanes in `some`, which all have this texture. */
DAFT_INLINE void add_points(const daft_texture_data *t, const texture_lanes *at, daft_texture_filter filter, vbits some,
                            tap_list *list, tap_sums *sums)
{
    sums->first = list->count, sums->count = 0;
    (TEXTURES_ALONG ? add_along : add_one)(t, at, filter, some, list, sums);
}

/* The mean of the points' taps. */
DAFT_INLINE vf sum_taps(const tap_sums *sums, const float *color, float unit)
{
    const float *from = color + sums->first;
    vf fine = vf_set(0), coarse = vf_set(0);
    for (uint32_t k = 0; k < sums->count; k++) {
        fine += vf_load_expand(from, sums->of_fine[k]), from += __builtin_popcount(sums->of_fine[k]);
        if (!sums->of_coarse[k]) continue;
        coarse += vf_load_expand(from, sums->of_coarse[k]), from += __builtin_popcount(sums->of_coarse[k]);
    }
    return (fine * sums->fine + coarse * sums->coarse) * vf_set(unit);
}

#define UNIT (1.0f / 65535) /* of colours in a list: 65535 of them are 1 */

DAFT_INLINE vf3 sum_colors(const tap_list *list, const tap_sums *sums, float unit)
{
    return (vf3){sum_taps(sums, list->word[0], unit), sum_taps(sums, list->word[1], unit),
                 sum_taps(sums, list->word[2], unit)};
}

DAFT_INLINE vf3 choose_colors(vm mask, vf3 a, vf3 b)
{
    return (vf3){vf_if_then_else(mask, a.x, b.x), vf_if_then_else(mask, a.y, b.y), vf_if_then_else(mask, a.z, b.z)};
}

/* What DAFT_VL points have of their textures; of those without one *out stays as it is. */
DAFT_INLINE void sample_lanes(const texture_lanes *at, vi texture, vbits left, const daft_texture_data *textures,
                              daft_texture_filter filter, bool linear, vf3 *color, vf *alpha)
{
    const texture_use use = {.linear = linear, .nearest = filter == DAFT_TEXTURE_NEAREST, .edges = at->edges};
    const float unit = linear ? 1 : UNIT;
    tap_list list;
    while (left) {
        const int32_t number = texture[__builtin_ctz(left)];
        const daft_texture_data *t = &textures[number];
        const vbits same = left & vbits_from_mask(vi_eq(texture, vi_set(number)));
        const vm mask = vm_from_bits(same);
        texture_levels levels;
        tap_sums sums;
        list.count = 0;
        list_levels(t, &levels);
        add_points(t, at, filter, same, &list, &sums);
        read_taps(&list, &levels, use);
        *color = choose_colors(mask, sum_colors(&list, &sums, unit), *color);
        if (linear) *alpha = vf_if_then_else(mask, sum_taps(&sums, list.word[3], unit), *alpha);
        left &= ~same;
    }
}

DAFT_INLINE vbits with_texture(const daft_batch *batch, vi texture, uint32_t i)
{
    return vbits_first_n((int)daft_min_u(batch->count - i, DAFT_VL)) &
           ~vbits_from_mask(vi_eq(texture, vi_set((int32_t)DAFT_NO_TEXTURE)));
}

/* ---- a batch's colours ---- */

enum { BLOCKS = 16 }; /* of DAFT_VL points whose taps are in the list at once */

/* One texture of a batch at work. */
typedef struct texture_job {
    daft_batch *batch;
    const daft_texture_data *texture;
    texture_levels levels;
    texture_use use;
    uint32_t count; /* blocks that wait for their colours */
    uint32_t at[BLOCKS];
    vbits lanes[BLOCKS];
    tap_sums sums[BLOCKS];
    tap_list list;
} texture_job;

static void finish_blocks(texture_job *job)
{
    daft_lanes3 *albedo = &job->batch->albedo;
    const bool colors = job->batch->traits & DAFT_TRAIT_COLORS;
    read_taps(&job->list, &job->levels, job->use);
    for (uint32_t k = 0; k < job->count; k++) {
        const vf3 found = sum_colors(&job->list, &job->sums[k], UNIT), own = lanes_load(albedo, job->at[k]);
        const vf3 color = colors ? (vf3){found.x * own.x, found.y * own.y, found.z * own.z} : found;
        lanes_store(albedo, job->at[k], choose_colors(vm_from_bits(job->lanes[k]), color, own));
    }
    job->count = 0, job->list.count = 0;
}

/* Points i.. of the batch, those in `lanes`. */
DAFT_INLINE void add_block(texture_job *job, const daft_surface *materials, daft_texture_filter filter, uint32_t i,
                           vbits lanes)
{
    const material_reader m = read_some_materials(job->batch, materials, i, lanes);
    const texture_lanes at = lanes_of(job->batch, &m, i);
    const uint32_t most = 2 * DAFT_VL * most_taps(filter);
    if (job->count == BLOCKS || job->list.count + most > TAPS || at.edges != job->use.edges) finish_blocks(job);
    job->use.edges = at.edges;
    job->at[job->count] = i, job->lanes[job->count] = lanes;
    add_points(job->texture, &at, filter, lanes, &job->list, &job->sums[job->count++]);
}

/* Which texture each point has, and white for all unless they have colours of their own. The first point with a
 * texture, or the batch's count. */
DAFT_INLINE uint32_t list_textures(daft_batch *batch, const daft_surface *materials, int32_t *texture)
{
    const vf one = vf_set(1);
    uint32_t first = batch->count;
    for (uint32_t i = 0; i < batch->count; i += DAFT_VL) {
        const material_reader m = read_materials(batch, materials, i);
        const vi of = (vi)MATERIAL_WORD(&m, texture);
        const vbits some = with_texture(batch, of, i);
        vi_store(&texture[i], vi_if_then_else(vm_from_bits(some), of, vi_set((int32_t)DAFT_NO_TEXTURE)));
        if (some && first == batch->count) first = i + (uint32_t)__builtin_ctz(some);
        if (!(batch->traits & DAFT_TRAIT_COLORS)) lanes_store(&batch->albedo, i, (vf3){one, one, one});
    }
    return first;
}

bool TEXTURES(daft_albedo)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                           daft_texture_filter filter)
{
    if (!TEXTURES_ALONG && daft_filter_is_anisotropic(filter))
        return DAFT_KERNEL(daft_albedo_along)(batch, materials, textures, filter);
    int32_t texture[DAFT_BATCH_ROOM];
    texture_job job;
    uint32_t first = list_textures(batch, materials, texture);
    const bool any = first < batch->count;
    job.batch = batch, job.count = 0, job.list.count = 0;
    job.use = (texture_use){.nearest = filter == DAFT_TEXTURE_NEAREST};
    while (first < batch->count) {
        const vi number = vi_set(texture[first]), none = vi_set((int32_t)DAFT_NO_TEXTURE);
        uint32_t next = batch->count;
        job.texture = &textures[texture[first]];
        list_levels(job.texture, &job.levels);
        for (uint32_t i = first / DAFT_VL * DAFT_VL; i < batch->count; i += DAFT_VL) {
            const vi of = vi_load(&texture[i]), left = vi_if_then_else(vi_eq(of, number), none, of);
            const vbits same = vbits_from_mask(vi_eq(of, number)), others = vbits_from_mask(vm_not(vi_eq(left, none)));
            if (same) vi_store(&texture[i], left), add_block(&job, materials, filter, i, same);
            if (others && next == batch->count) next = i + (uint32_t)__builtin_ctz(others);
        }
        finish_blocks(&job);
        first = next;
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
