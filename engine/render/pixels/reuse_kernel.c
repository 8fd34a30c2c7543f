/* Temporal reuse in lanes; see reuse.c. Where pixels side by side see different instances, each of these is asked for
 * its motion once. */
#include "math/simd/ops.h"
#include "render/kernels.h"

/* How far the inverse depth of the picture before may be off, as a part of it; and where a mirrored image moves along a
 * surface, too. */
#define SAME_PLACE   0.03f
#define SAME_SURFACE 0.1f

DAFT_INLINE vf3 vf3_scaled(daft_vec3 a, vf s) { return (vf3){vf_set(a.x) * s, vf_set(a.y) * s, vf_set(a.z) * s}; }

DAFT_INLINE vf3 vf3_sum(vf3 a, vf3 b) { return (vf3){a.x + b.x, a.y + b.y, a.z + b.z}; }

/* What the pixels of a grid see at the inverse of a depth, in frame space; at 0 a direction. */
DAFT_INLINE vf3 seen_at(const daft_reusing *r, int x, int y, vf inverse)
{
    const daft_snapshot *s = r->snapshot;
    const daft_filter *g = &r->grid;
    const vf one = vf_set(1),
             depth = one / (vf_if_then_else(vf_lt(vf_set(0), inverse), inverse, one) * vf_set(g->focal));
    const vf right = vf_set(g->left + (float)x) + vf_convert_to(vi_iota()), up = vf_set(g->top - (float)y);
    return vf3_sum(vf3_sum(vf3_scaled(s->right, right * depth), vf3_scaled(s->up, up * depth)),
                   vf3_scaled(s->forward, vf_set(g->focal) * depth));
}

/* Where the picture before saw it: column, row, and the inverse of the depth. */
typedef struct place {
    vf x, y, inverse;
    vm known; /* it lay before the camera and in the picture */
} place;

DAFT_INLINE vf moved(const daft_affine *a, int row, vf3 p, vf point)
{
    const float *m = &a->m[3 * row];
    return ((vf_set(m[0]) * p.x + vf_set(m[1]) * p.y) + vf_set(m[2]) * p.z) + vf_set(a->t[row]) * point;
}

DAFT_INLINE place place_before(const daft_snapshot *s, const daft_affine *before, vf3 p, vf inverse)
{
    const vf zero = vf_set(0), one = vf_set(1), point = vf_if_then_else(vf_lt(zero, inverse), one, zero);
    const vf depth = moved(before, 2, p, point), focal = vf_set(s->before_focal);
    const float half_width = (float)s->width * 0.5f - 0.5f, half_height = (float)s->height * 0.5f - 0.5f;
    place out = {.inverse = one / depth};
    out.x = moved(before, 0, p, point) * out.inverse * focal + vf_set(half_width);
    out.y = vf_set(half_height) - moved(before, 1, p, point) * out.inverse * focal;
    const vm across = vm_and(vf_lt(vf_set(-1), out.x), vf_lt(out.x, vf_set((float)s->width))),
             down = vm_and(vf_lt(vf_set(-1), out.y), vf_lt(out.y, vf_set((float)s->height)));
    out.known = vm_and(vf_lt(zero, depth), vm_and(across, down));
    return out;
}

DAFT_INLINE place chosen_place(vm m, place a, place b)
{
    return (place){vf_if_then_else(m, a.x, b.x), vf_if_then_else(m, a.y, b.y), vf_if_then_else(m, a.inverse, b.inverse),
                   vm_or(vm_and(m, a.known), vm_and(vm_not(m), b.known))};
}

/* A row's pixels that saw something, and where the picture before showed the same. */
typedef struct row_seen {
    vf inverse, shown; /* of the surface; of what it shows */
    vi instance, entity;
    place before;
} row_seen;

/* With the inverse depth of the surface that shows it. */
DAFT_INLINE place place_shown(const daft_reusing *r, const row_seen *seen, int x, int y, uint32_t instance)
{
    const daft_affine *before = &r->snapshot->before[instance];
    const place surface = place_before(r->snapshot, before, seen_at(r, x, y, seen->inverse), seen->inverse);
    if (!r->shown) return surface;
    place shown = place_before(r->snapshot, before, seen_at(r, x, y, seen->shown), seen->shown);
    shown.inverse = surface.inverse, shown.known = vm_and(shown.known, surface.known);
    const vm same = vm_and(vf_le(seen->shown, seen->inverse), vf_le(seen->inverse, seen->shown));
    return chosen_place(same, surface, shown);
}

DAFT_INLINE row_seen look(const daft_reusing *r, int x, int y, ptrdiff_t at)
{
    const vf inverse = vf_load(r->inverse + at), zero = vf_set(0);
    row_seen seen = {.inverse = inverse,
                     .shown = r->shown ? vf_load(r->shown + at) : inverse,
                     .instance = vi_load(r->seen + at),
                     .entity = vi_set(0),
                     .before = {.x = zero, .y = zero, .inverse = zero, .known = vf_lt(zero, zero)}};
    vbits left = vbits_from_mask(vf_lt(zero, inverse));
    while (left) {
        const uint32_t instance = (uint32_t)seen.instance[__builtin_ctz(left)];
        const vm same = vm_and(vi_eq(seen.instance, vi_set((int32_t)instance)), vm_from_bits(left));
        left &= ~vbits_from_mask(same);
        seen.entity = vi_if_then_else(same, vi_set((int32_t)r->snapshot->instances[instance].entity), seen.entity);
        if (r->remembers) seen.before = chosen_place(same, place_shown(r, &seen, x, y, instance), seen.before);
    }
    return seen;
}

typedef struct gathered {
    vf3 ratio;
    vf length, weight;
} gathered;

DAFT_INLINE const float *old_plane(const daft_past *p, int number)
{
    return p->planes[p->now] + (size_t)number * (size_t)p->width * (size_t)p->height;
}

/* Adds one of the four pixels around: (x, y) with its weight. */
DAFT_INLINE void gather_one(const daft_past *past, const row_seen *seen, vf slack, vi x, vi y, vf weight, gathered *out)
{
    const vi none = vi_set(-1);
    const vm across = vm_and(vi_lt(none, x), vi_lt(x, vi_set(past->width))),
             down = vm_and(vi_lt(none, y), vi_lt(y, vi_set(past->height)));
    const vm inside = vm_and(vm_and(across, down), seen->before.known);
    const vi at = vi_if_then_else(inside, y * vi_set(past->width) + x, vi_set(0));
    const vm own = vi_eq(vi_gather_index(old_plane(past, DAFT_PAST_ENTITY), at), seen->entity);
    const vf off = vf_abs(vf_gather_index(old_plane(past, DAFT_PAST_INVERSE), at) - seen->before.inverse);
    const vm same = vm_and(vm_and(inside, own), vf_lt(off, slack * seen->before.inverse));
    const vf share = vf_if_then_else(same, weight, vf_set(0));
    out->ratio.x += vf_gather_index(old_plane(past, 0), at) * share;
    out->ratio.y += vf_gather_index(old_plane(past, 1), at) * share;
    out->ratio.z += vf_gather_index(old_plane(past, 2), at) * share;
    out->length += vf_gather_index(old_plane(past, DAFT_PAST_LENGTH), at) * share;
    out->weight += share;
}

/* The sum of the four pixels around, of those that saw the same. */
DAFT_INLINE gathered gather(const daft_past *past, const row_seen *seen)
{
    const vf zero = vf_set(0), one = vf_set(1), per_step = vf_set(1 / (float)past->step);
    const place *p = &seen->before;
    const vf column = vf_if_then_else(p->known, (p->x - vf_set((float)past->x[past->now])) * per_step, zero),
             row = vf_if_then_else(p->known, (p->y - vf_set((float)past->y[past->now])) * per_step, zero);
    const vf left = vf_floor(column), top = vf_floor(row), fx = column - left, fy = row - top;
    const vi x = vi_convert_to(left), y = vi_convert_to(top), next = vi_set(1);
    const vm still = vm_and(vf_le(seen->shown, seen->inverse), vf_le(seen->inverse, seen->shown));
    const vf slack = vf_if_then_else(still, vf_set(SAME_PLACE), vf_set(SAME_SURFACE));
    gathered out = {{zero, zero, zero}, zero, zero};
    gather_one(past, seen, slack, x, y, (one - fx) * (one - fy), &out);
    gather_one(past, seen, slack, x + next, y, fx * (one - fy), &out);
    gather_one(past, seen, slack, x, y + next, (one - fx) * fy, &out);
    gather_one(past, seen, slack, x + next, y + next, fx * fy, &out);
    return out;
}

DAFT_INLINE void reuse(const daft_reusing *r, int x, int y)
{
    daft_past *past = r->past;
    const ptrdiff_t at = y * r->grid.stride + x;
    const vf zero = vf_set(0), one = vf_set(1);
    const row_seen seen = look(r, x, y, at);
    const vm known = vf_lt(zero, seen.inverse);
    vf3 ratio = {vf_load(r->ratio[0] + at), vf_load(r->ratio[1] + at), vf_load(r->ratio[2] + at)};
    vf length = one;
    if (r->remembers && vbits_from_mask(seen.before.known)) {
        const gathered old = gather(past, &seen);
        const vm some = vf_lt(vf_set(0.01f), old.weight);
        const vf scale = one / vf_if_then_else(some, old.weight, one);
        const vf longer = vf_min(old.length * scale + one, vf_set((float)DAFT_LONGEST_PAST)), share = one / longer;
        const vf3 mean = {old.ratio.x * scale, old.ratio.y * scale, old.ratio.z * scale};
        length = vf_if_then_else(some, longer, one);
        ratio.x = vf_if_then_else(some, mean.x + (ratio.x - mean.x) * share, ratio.x);
        ratio.y = vf_if_then_else(some, mean.y + (ratio.y - mean.y) * share, ratio.y);
        ratio.z = vf_if_then_else(some, mean.z + (ratio.z - mean.z) * share, ratio.z);
        vf_store(r->ratio[0] + at, ratio.x), vf_store(r->ratio[1] + at, ratio.y), vf_store(r->ratio[2] + at, ratio.z);
    }
    if (r->variance) vf_store(r->variance + at, vf_load(r->variance + at) / (length * length));
    const size_t size = (size_t)past->width * (size_t)past->height;
    float *now = past->planes[!past->now] + (size_t)(y + r->first_row) * (size_t)past->width + x;
    vf_store(now, ratio.x), vf_store(now + size, ratio.y), vf_store(now + 2 * size, ratio.z);
    vf_store(now + DAFT_PAST_INVERSE * size, seen.inverse), vf_store(now + DAFT_PAST_LENGTH * size, length);
    vi_store(now + DAFT_PAST_ENTITY * size, vi_if_then_else(known, seen.entity, vi_set(0)));
}

void DAFT_KERNEL(daft_reuse)(const daft_reusing *r, int x0, int y0, int width, int height)
{
    for (int y = y0; y < y0 + height; y++)
        for (int x = x0; x < x0 + width; x += DAFT_VL) reuse(r, x, y);
}
