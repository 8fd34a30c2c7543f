/* Texture sampling: repeating, trilinear unless a cheaper filter is asked for, in linear light. The mip level is the
 * log2 of the footprint's side in texels (Williams, "Pyramidal Parametrics", 1983). Lanes are points: those of one
 * texture that need one level of it are sampled together, and neighbours mostly do. */
#include "shade/batch_lanes.h"

#include "shade/srgb_table.h"

/* Points of one texture, whose two levels are `fine` and `fine` + 1, the latter with the weight `blend`. */
typedef struct texture_points {
    vf u, v; /* 0..1 */
    vi fine;
    vf blend; /* 0: one level serves */
    vf3 color;
} texture_points;

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
DAFT_INLINE texture_taps texture_place(const texture_points *p, int width, int height, vm some)
{
    const vf half = vf_set(0.5f), one = vf_set(1), zero = vf_set(0);
    vf x = vf_if_then_else(some, p->u * vf_set((float)width) - half, zero),
       y = vf_if_then_else(some, (one - p->v) * vf_set((float)height) - half, zero);
    vi x0 = vi_convert_to(x + one) - vi_set(1), y0 = vi_convert_to(y + one) - vi_set(1); /* floors: both are > -1 */
    vi left = wrap_above(x0, width), right = wrap_below(x0 + vi_set(1), width),
       above = wrap_above(y0, height) * vi_set(width), below = wrap_below(y0 + vi_set(1), height) * vi_set(width);
    return (texture_taps){above + left,  above + right,         below + left,
                          below + right, x - vf_convert_to(x0), y - vf_convert_to(y0)};
}

DAFT_INLINE vf decode(vi texel, int channel) { return vf_table_lookup256(SRGB_TO_LINEAR, texel >> (8 * channel)); }

/* The nearest of two texels has all the weight. */
DAFT_INLINE vf step_at_half(vf a) { return vf_if_then_else(vf_lt(a, vf_set(0.5f)), vf_set(0), vf_set(1)); }

/* Adds one level to the colour of the lanes in `some`. */
static void add_level(const daft_texture_data *t, int level, vm some, vf weight, bool nearest, texture_points *p)
{
    texture_taps at = texture_place(p, t->width[level], t->height[level], some);
    if (nearest) at.across = step_at_half(at.across), at.down = step_at_half(at.down);
    const uint8_t *texels = t->texels[level];
    const vi a = vi_gather_index(texels, at.above_left), b = vi_gather_index(texels, at.above_right),
             c = vi_gather_index(texels, at.below_left), d = vi_gather_index(texels, at.below_right);
    vf sum[3] = {p->color.x, p->color.y, p->color.z};
    weight = vf_if_then_else(some, weight, vf_set(0));
    for (int k = 0; k < 3; k++) {
        vf left = decode(a, k), low = decode(c, k);
        vf top = left + (decode(b, k) - left) * at.across, bottom = low + (decode(d, k) - low) * at.across;
        sum[k] = sum[k] + weight * (top + (bottom - top) * at.down);
    }
    p->color = (vf3){sum[0], sum[1], sum[2]};
}

/* Two levels blend in the middle half of the interval between them; in the outer quarters one level serves, which
 * halves the fetches and is not seen. */
DAFT_INLINE void choose_levels(const daft_texture_data *t, vf level, daft_texture_filter filter, texture_points *p)
{
    const vf zero = vf_set(0), one = vf_set(1);
    level = vf_min(vf_max(level, zero), vf_set(filter >= DAFT_TEXTURE_BILINEAR ? 0 : (float)(t->levels - 1)));
    if (filter == DAFT_TEXTURE_MIPMAP) level = vf_floor(level + vf_set(0.5f));
    vi fine = vi_convert_to(level);
    vf blend = (level - vf_convert_to(fine)) * vf_set(2) - vf_set(0.5f);
    vm next = vf_le(one, blend);
    p->fine = vi_if_then_else(next, fine + vi_set(1), fine);
    p->blend = vf_if_then_else(next, zero, vf_max(blend, zero));
}

/* The colour of the lanes in `some`, which all have this texture. */
DAFT_INLINE void sample(const daft_texture_data *t, vf level, daft_texture_filter filter, vbits some, texture_points *p)
{
    const vf zero = vf_set(0);
    choose_levels(t, level, filter, p);
    vbits fine = some, coarse = some & vbits_from_mask(vf_lt(zero, p->blend));
    while (fine | coarse) {
        const int lane = __builtin_ctz(fine | coarse), now = p->fine[lane] + (fine >> lane & 1 ? 0 : 1);
        const vbits in_fine = fine & vbits_from_mask(vi_eq(p->fine, vi_set(now))),
                    in_coarse = coarse & vbits_from_mask(vi_eq(p->fine, vi_set(now - 1)));
        const vf weight = vf_if_then_else(vm_from_bits(in_fine), vf_set(1) - p->blend, p->blend);
        add_level(t, now, vm_from_bits(in_fine | in_coarse), weight, filter == DAFT_TEXTURE_NEAREST, p);
        fine &= ~in_fine, coarse &= ~in_coarse;
    }
}

DAFT_INLINE vf fraction(vf a)
{
    vf bounded = vf_if_then_else(vf_lt(vf_abs(a), vf_set(8388608.0f)), a, vf_set(0)); /* beyond 2^23 there is no
                                                                                         fraction */
    return bounded - vf_floor(bounded);
}

/* False: no point has a texture. */
static bool sample_lanes(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                         daft_texture_filter filter, uint32_t i)
{
    const material_reader m = read_materials(batch, materials, i);
    const vi texture = (vi)MATERIAL_WORD(&m, texture);
    vbits left = vbits_first_n((int)daft_min_u(batch->count - i, DAFT_VL)) &
                 ~vbits_from_mask(vi_eq(texture, vi_set((int32_t)DAFT_NO_TEXTURE)));
    if (!left) return false;
    const vf su = MATERIAL_WORD(&m, map_scale.x), sv = MATERIAL_WORD(&m, map_scale.y);
    const vf scale = vf_load(&batch->footprint[i]) * vf_sqrt(vf_abs(su * sv));
    vf3 albedo = {vf_set(1), vf_set(1), vf_set(1)};
    while (left) {
        const int32_t number = texture[__builtin_ctz(left)];
        const daft_texture_data *t = &textures[number];
        const vbits same = left & vbits_from_mask(vi_eq(texture, vi_set(number)));
        const vf size = vf_set(sqrtf((float)t->width[0] * (float)t->height[0])); /* its side in texels */
        texture_points p = {.u = fraction(vf_load(&batch->u[i]) * su), .v = fraction(vf_load(&batch->v[i]) * sv)};
        p.color = (vf3){vf_set(0), vf_set(0), vf_set(0)};
        sample(t, vf_log2(vf_max(scale * size, vf_set(1e-20f))), filter, same, &p);
        const vm mask = vm_from_bits(same);
        albedo = (vf3){vf_if_then_else(mask, p.color.x, albedo.x), vf_if_then_else(mask, p.color.y, albedo.y),
                       vf_if_then_else(mask, p.color.z, albedo.z)};
        left &= ~same;
    }
    lanes_store(&batch->albedo, i, albedo);
    return true;
}

bool DAFT_KERNEL(daft_albedo)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                              daft_texture_filter filter)
{
    bool any = false;
    vf one = vf_set(1);
    for (uint32_t i = 0; i < batch->count; i += DAFT_VL) {
        if (sample_lanes(batch, materials, textures, filter, i))
            any = true;
        else
            lanes_store(&batch->albedo, i, (vf3){one, one, one});
    }
    return any;
}
