/* Which of many lights a point asks, in lanes. What each light would send to a batch's points if nothing were in its
 * way is laid end to end, a row for each point and colour; draws fall into it at even distances (systematic
 * resampling), the same for all colours, so that lights of like colour are asked by the same ray. A light gets as many
 * draws as it has of the row, rounded down or up, and in the mean exactly. */
#include "math/simd/ops.h"
#include "render/dice.h"
#include "render/kernels.h"

typedef uint32_t vu __attribute__((vector_size(DAFT_VL * 4)));

DAFT_INLINE vf3 load3(const daft_lanes3 *a, uint32_t i)
{
    return (vf3){vf_load(&a->x[i]), vf_load(&a->y[i]), vf_load(&a->z[i])};
}
DAFT_INLINE void store3(daft_lanes3 *a, uint32_t i, vf3 v)
{
    vf_store(&a->x[i], v.x), vf_store(&a->y[i], v.y), vf_store(&a->z[i], v.z);
}
DAFT_INLINE vf3 plus(vf3 a, vf3 b) { return (vf3){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE vm is_some(vf3 a) { return vf_lt(vf_set(0), vf_max(vf_max(a.x, a.y), a.z)); }

void DAFT_KERNEL(daft_take_light)(daft_batch *points, const daft_lanes3 *before, const uint32_t bits[DAFT_BATCH_WORDS],
                                  daft_lanes3 *whole, daft_lanes3 *from)
{
    uint32_t at = 0;
    for (uint32_t i = 0; i < points->count; i += DAFT_VL) {
        const vbits some = bits[i / 32] >> (i % 32) & DAFT_ALL_LANES;
        const vf3 light = load3(&points->light, i), own = load3(before, i);
        const vf3 more = {light.x - own.x, light.y - own.y, light.z - own.z};
        store3(whole, i, plus(load3(whole, i), more));
        store3(&points->light, i, own);
        if (!some) continue;
        vf_compress_store(&from->x[at], some, more.x);
        vf_compress_store(&from->y[at], some, more.y);
        vf_compress_store(&from->z[at], some, more.z);
        at += (uint32_t)__builtin_popcount(some);
    }
}

DAFT_INLINE vf over(float draws, vf sum)
{
    const vm some = vf_lt(vf_set(0), sum);
    return vf_if_then_else(some, vf_set(draws) / vf_if_then_else(some, sum, vf_set(1)), vf_set(0));
}

void DAFT_KERNEL(daft_sum_candidates)(daft_candidates *all, const daft_drawing *how)
{
    const vf zero = vf_set(0), one = vf_set(1);
    const float draws = (float)how->draws;
    for (uint32_t i = 0; i < all->points; i += DAFT_VL) {
        vf3 sum = {zero, zero, zero};
        vf reached = zero;
        for (uint32_t k = 0; k < all->lights; k++) {
            const vf3 light = load3(&all->from[k], i);
            sum = plus(sum, light), reached = reached + vf_if_then_else(is_some(light), one, zero);
        }
        store3(&all->sum, i, sum);
        store3(&all->per_sum, i, (vf3){over(draws, sum.x), over(draws, sum.y), over(draws, sum.z)});
        store3(&all->upto, i, (vf3){zero, zero, zero});
        vf_store(&all->reached[i], reached);
    }
}

/* How many draws fall into the row up to `to` of `sum`; all of them at its end, whatever was rounded. */
DAFT_INLINE vf draws_upto(vf to, vf sum, vf per_sum, vf draws, vf turn)
{
    const vf at = vf_min(vf_if_then_else(vf_lt(to, sum), to * per_sum, draws), draws) + turn;
    return vf_convert_to(vi_convert_to(at)); /* not below 0 */
}

DAFT_INLINE vf draws_within(vf from, vf to, vf sum, vf per_sum, vf draws, vf turn)
{
    return draws_upto(to, sum, per_sum, draws, turn) - draws_upto(from, sum, per_sum, draws, turn);
}

void DAFT_KERNEL(daft_draw_light)(daft_candidates *all, const daft_drawing *how, uint32_t light, daft_asking *out)
{
    const vf draws = vf_set((float)how->draws), share = vf_set(1 / (float)how->draws), most = vf_set((float)how->rays);
    out->count = 0;
    for (uint32_t i = 0; i < all->points; i += DAFT_VL) {
        const vf3 own = load3(&all->from[light], i), sum = load3(&all->sum, i), per = load3(&all->per_sum, i);
        const vf3 from = load3(&all->upto, i), to = plus(from, own);
        const vf turn = vf_load(&all->turn[i]);
        const vm few = vf_le(vf_load(&all->reached[i]), vf_set((float)how->all));
        store3(&all->upto, i, to);
        const vf3 n = {draws_within(from.x, to.x, sum.x, per.x, draws, turn),
                       draws_within(from.y, to.y, sum.y, per.y, draws, turn),
                       draws_within(from.z, to.z, sum.z, per.z, draws, turn)};
        const vf rays = vf_if_then_else(few, most, vf_min(vf_max(vf_max(n.x, n.y), n.z), most));
        const vm asked = vm_and(is_some(own), vf_lt(vf_set(0), rays));
        const vbits bits = vbits_from_mask(asked) & vbits_first_n((int)(all->points - i));
        if (!bits) continue;
        const uint32_t at = out->count;
        vi_compress_store(&out->point[at], bits, vi_load(&all->point[i]));
        vi_compress_store(&out->rays[at], bits, vi_convert_to(rays));
        vf_compress_store(&out->light.x[at], bits, vf_if_then_else(few, own.x, n.x * share * sum.x));
        vf_compress_store(&out->light.y[at], bits, vf_if_then_else(few, own.y, n.y * share * sum.y));
        vf_compress_store(&out->light.z[at], bits, vf_if_then_else(few, own.z, n.z * share * sum.z));
        out->count += (uint32_t)__builtin_popcount(bits);
    }
}

/* ---- rays to rectangles: tile/soft.c's area_ray(), bit for bit ---- */

DAFT_INLINE vf3 gather3(const daft_lanes3 *a, vi i)
{
    return (vf3){vf_gather_index(a->x, i), vf_gather_index(a->y, i), vf_gather_index(a->z, i)};
}
DAFT_INLINE vf3 spread(daft_vec3 a) { return (vf3){vf_set(a.x), vf_set(a.y), vf_set(a.z)}; }
DAFT_INLINE vf3 minus(vf3 a, vf3 b) { return (vf3){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE vf3 scaled(daft_vec3 a, vf s) { return (vf3){vf_set(a.x) * s, vf_set(a.y) * s, vf_set(a.z) * s}; }
DAFT_INLINE vf3 either(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_if_then_else(m, a.x, b.x), vf_if_then_else(m, a.y, b.y), vf_if_then_else(m, a.z, b.z)};
}
/* A fraction of 2^32 as one of 1. */
DAFT_INLINE vf part_of(vu x) { return vf_convert_to((vi)(x >> 8)) * vf_set(0x1p-24f); }

/* The points' dice, and which of how many rays. */
typedef struct thrown {
    vu turn, radius, number;
    vf rays;
} thrown;

DAFT_INLINE thrown throw_dice(const daft_area_rays *def, vi point, vi number, vi rays)
{
    const daft_dice first = daft_dice_throw(0, 0, def->round, def->salt);
    const int shift = __builtin_ctz(def->step);
    vi place = vi_gather_index(def->points->pixel, point);
    if (def->place) place = vi_gather_index(def->place, place);
    const vu x = ((vu)(place & vi_set(DAFT_TILE - 1)) + def->column) >> shift,
             y = ((vu)(place >> __builtin_ctz(DAFT_TILE)) + def->row) >> shift;
    return (thrown){.turn = x * DAFT_R2_X + y * DAFT_R2_Y + first.turn,
                    .radius = x * DAFT_R2_Y + y * DAFT_R2_X + first.radius,
                    .number = (vu)number,
                    .rays = vf_convert_to(rays)};
}

/* The way to a place of the rectangle, in parts of its sides, and how much of its light at the point comes from there.
 */
DAFT_INLINE vf to_place(const daft_light_source *light, vf3 from, vf3 n, vf u, vf v, vf3 *to)
{
    const vf half = vf_set(0.5f), zero = vf_set(0);
    const vf3 place = plus(scaled(light->edges[0], u - half), scaled(light->edges[1], v - half));
    *to = plus(minus(spread(light->position), from), place);
    const vf length2 = vf3_dot(*to, *to), there = vf3_dot(*to, spread(light->to_light)), here = vf3_dot(*to, n);
    const vm some = vm_and(vf_lt(zero, there), vf_lt(zero, here));
    return vf_if_then_else(some, there * here / (length2 * length2), zero);
}

DAFT_INLINE vf draw_place(const daft_light_source *light, vf3 from, vf3 n, const thrown *d, vf3 *to)
{
    vf sum = vf_set(0), upto[DAFT_PLACES];
    vf3 all[DAFT_PLACES];
    for (uint32_t p = 0; p < DAFT_PLACES; p++) {
        const vu k = d->number * DAFT_PLACES + p;
        const vf u = part_of(d->turn + k * DAFT_GOLDEN),
                 v = (vf_convert_to((vi)k) + part_of(d->radius)) / (d->rays * vf_set(DAFT_PLACES));
        sum = sum + to_place(light, from, n, u, v, &all[p]);
        upto[p] = sum;
    }
    const vu x = d->turn + 2891336453u * d->radius + d->number * DAFT_R2_X,
             mixed = ((x >> ((x >> 28) + 4)) ^ x) * 277803737u;
    const vf at = part_of(mixed >> 22 ^ mixed) * sum;
    *to = all[DAFT_PLACES - 1];
    for (int p = DAFT_PLACES - 2; p >= 0; p--) *to = either(vf_lt(at, upto[p]), all[p], *to);
    return sum;
}

/* Where rays come to the bounds of what glows; else `last`. */
DAFT_INLINE vf bounds_at(const daft_light_source *light, vf3 origin, vf3 to, vf last)
{
    const vf zero = vf_set(0), one = vf_set(1), end = last;
    const vf3 from = minus(origin, spread(light->bounds.middle));
    vf first = zero;
    vm beside = vf_lt(one, zero);
    for (int k = 0; k < 3; k++) {
        const vf3 axis = spread(light->bounds.axes[k]);
        const vf at = vf3_dot(axis, from), by = vf3_dot(axis, to);
        beside = vm_or(beside, vm_and(vf_lt(one, vf_abs(at)), vf_le(zero, at * by)));
        const vm along = vm_and(vf_le(zero, by), vf_le(by, zero));
        const vf a = (-one - at) / by, b = (one - at) / by;
        first = vf_if_then_else(along, first, vf_max(first, vf_min(a, b)));
        last = vf_if_then_else(along, last, vf_min(last, vf_max(a, b)));
    }
    return vf_if_then_else(vm_and(vm_not(beside), vf_le(first, last)), first, end);
}

bool DAFT_KERNEL(daft_skip_middle)(const daft_batch *points, const daft_light_source *light,
                                   uint32_t bits[DAFT_BATCH_WORDS], uint32_t aside[DAFT_BATCH_WORDS])
{
    const daft_vec3 at = light->position, back = light->to_light;
    const bool ball = light->area == DAFT_AREA_SPHERE;
    const vf zero = vf_set(0), r2 = vf_set(light->radius * light->radius);
    uint32_t some = 0;
    memset(aside, 0, DAFT_BATCH_WORDS * sizeof aside[0]);
    for (uint32_t i = 0; i < points->count; i += DAFT_VL) {
        const vbits in = bits[i / 32] >> (i % 32) & DAFT_ALL_LANES;
        if (!in) continue;
        const vf3 to = {vf_set(at.x) - vf_load(&points->shadow_origin.x[i]),
                        vf_set(at.y) - vf_load(&points->shadow_origin.y[i]),
                        vf_set(at.z) - vf_load(&points->shadow_origin.z[i])};
        const vf3 n = {vf_load(&points->normal.x[i]), vf_load(&points->normal.y[i]), vf_load(&points->normal.z[i])};
        const vm before = ball ? vf_lt(r2, vf3_dot(to, to))
                               : vf_lt(zero, vf3_dot(to, (vf3){vf_set(back.x), vf_set(back.y), vf_set(back.z)}));
        const vbits out = in & ~vbits_from_mask(vm_and(before, vf_lt(zero, vf3_dot(to, n))));
        aside[i / 32] |= out << (i % 32), bits[i / 32] &= ~(out << (i % 32)), some |= out;
    }
    return some != 0;
}

void DAFT_KERNEL(daft_rectangle_rays)(const daft_area_rays *def, const uint32_t *point, const int32_t *number,
                                      const int32_t *rays, uint32_t count, daft_ray *out, float *weight)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        const vm used = vm_from_bits(vbits_first_n((int)(count - i)));
        const vi at = vi_if_then_else(used, vi_load(&point[i]), vi_set(0)),
                 of = vi_if_then_else(used, vi_load(&rays[i]), vi_set(1));
        const vf3 from = gather3(&def->points->shadow_origin, at), n = gather3(&def->points->normal, at);
        const thrown d = throw_dice(def, at, vi_load(&number[i]), of);
        vf3 to;
        const vf sum = draw_place(def->light, from, n, &d, &to);
        vf last = vf_set(1 - DAFT_BEFORE_RECTANGLE);
        if (def->light->bounded) last = bounds_at(def->light, from, to, last);
        const vf fields[8] = {from.x, from.y, from.z, vf_set(0), to.x, to.y, to.z, last};
        vf_store_interleaved8(&out[i].origin.x, 8, fields);
        vf_store(&weight[i], sum);
    }
}
