/* Single rays among few things that are only shifted, as small scenes have. Their boxes stand in their own spaces, each in a
 * lane, so that the ray enters all spaces at once; where it meets none, which is most of a wide view, that is all there is to
 * do. A mesh is hit as daft_closest_at_large finds it, bit for bit: the ray in its space is the same. */
#include "accel/walk.h"

/* A ray that meets some box. */
typedef struct few_ray {
    slab_way way;
    slab_near near; /* where it enters each */
    float size;     /* of the direction: the sum of its magnitudes */
    uint32_t bits;  /* which boxes */
} few_ray;

typedef enum few_answer { FEW_UNUSUAL, FEW_MISSED, FEW_MET } few_answer;

typedef struct daft_few_thing few_thing;

/* UNUSUAL: the ray has some number with which it must go the long way. *out is filled for MET alone. */
DAFT_INLINE few_answer few_meet(const daft_few *few, const daft_ray *ray, few_ray *out)
{
    v4 o = v4_load((const float *)ray), d = v4_load((const float *)ray + 4), part = v4_abs(d);
    v4 inverse = v4_set(-1) / d, wide = inverse * v4_set(DAFT_WIDEN);
    float size = part[0] + part[1] + part[2]; /* lanes 3 are tmin and tmax */
    v4i usual = (v4i)(wide - wide == v4_set(0)) & (v4i)(v4_abs(o) < v4_set(DAFT_FEW_FAR));
    if ((v4_bits_from_mask(usual) & 7) != 7 || !(size > 0x1p-26f && size < 0x1p26f && ray->tmin >= 0 && ray->tmin <= ray->tmax))
        return FEW_UNUSUAL;
    slab_way way = slab_way_of(d, inverse);
    slab_origin at = {v8_set(ray->origin.x) + v8_load(few->shift[0]), v8_set(ray->origin.y) + v8_load(few->shift[1]),
                      v8_set(ray->origin.z) + v8_load(few->shift[2])};
    v8 near;
    uint32_t bits = slab_test((const char *)few->bounds, &way, &at, &at, true, v8_set(begin_of(ray->tmin, true)),
                              v8_set(limit_of(ray->tmax, true)), &near);
    if (!bits) return FEW_MISSED;
    out->way = way, out->size = size, out->bits = bits;
    v8_store((float *)out->near.at, near), out->near.at[DAFT_WIDTH] = DAFT_INFINITY_BITS;
    return FEW_MET;
}

/* Of the things in bits, 1 or more, the nearest; its bit is taken away. Whether it is one or two no branch asks; but which it is
 * is branched on, not looked up: the processor foresees a branch and begins in the mesh at once, where it would wait for the
 * boxes before it looked. */
DAFT_INLINE const few_thing *few_next(const daft_few *few, few_ray *f, float *enter)
{
    two_bits two = two_lowest(f->bits);
    const int32_t *at = f->near.at;
    uint32_t i = at[two.second] < at[two.first] ? two.second : two.first;
    for (uint32_t left = two.left & (two.left - 1); __builtin_expect(left != 0, 0); left &= left - 1) {
        uint32_t next = (uint32_t)__builtin_ctz(left);
        i = at[next] < at[i] ? next : i;
    }
    f->bits &= ~(1u << i);
    *enter = ((const float *)at)[i];
    if (i > 1) return &few->things[i];
    if (i == 1) return &few->things[1];
    const few_thing *first = &few->things[0];
    __asm__("" : "+r"(first)); /* or the compiler makes a look-up of it again */
    return first;
}

/* The ray in a thing's space, but for its origin. */
DAFT_INLINE daft_mesh_ray few_mesh_ray(const daft_ray *ray, const few_ray *f, daft_intersection how)
{
    return (daft_mesh_ray){.direction = ray->direction, .how = how, .filter = {22 * DAFT_ULP * f->size, -DAFT_TINY}};
}

DAFT_INLINE v4 few_enter(const few_thing *thing, const daft_ray *ray, daft_mesh_ray *r)
{
    v4 o = v4_load((const float *)ray) + v4_load(thing->shift); /* lane 3: tmin */
    _Static_assert(offsetof(daft_mesh_ray, tmin) == 3 * sizeof(float), "an origin and tmin in one register");
    memcpy(r, &o, sizeof o);
    return o;
}

static __attribute__((noinline)) bool few_closest(const daft_tlas *tlas, const daft_ray *ray, few_ray *f, uint32_t ignore, daft_hit *hit)
{
    daft_nearest n = {.t = ray->tmax, .instance = UINT32_MAX, .triangle = DAFT_NO_TRIANGLE};
    daft_mesh_ray r = few_mesh_ray(ray, f, tlas->intersection);
    const few_thing *won = NULL;
    while (f->bits) {
        float enter, t = n.t;
        const few_thing *thing = few_next(tlas->few, f, &enter);
        if (enter > limit_of(n.t, true)) break;
        if (thing->index == ignore) continue;
        slab_origin at = slab_origin_of(few_enter(thing, ray, &r));
        uint32_t triangle = n.triangle, mark = thing->index < n.instance ? DAFT_NO_TRIANGLE : 0; /* a tie goes to the lower instance */
        n.triangle = mark;
        mesh_walk(thing->bvh, thing->child, &f->way, &r, &at, &at, true, true, &n);
        if (n.t < t || n.triangle != mark) n.instance = thing->index, won = thing;
        else n.triangle = triangle;
    }
    *hit = (daft_hit){n.t, n.u, n.v, n.instance, n.triangle, {0, 0, 0}};
    if (!won) {
        hit->triangle = 0;
        return false;
    }
    daft_vec3 p[3], place = daft_v3(won->place[0], won->place[1], won->place[2]);
    for (int k = 0; k < 3; k++) p[k] = daft_add(daft_block_corner(n.block, k, n.place), place);
    hit->normal = daft_cross(daft_sub(p[1], p[0]), daft_sub(p[2], p[0]));
    return true;
}

bool DAFT_KERNEL(daft_closest)(const daft_tlas *tlas, const daft_ray *ray, uint32_t ignore, daft_hit *hit)
{
    few_ray f;
    few_answer answer = tlas->few ? few_meet(tlas->few, ray, &f) : FEW_UNUSUAL;
    if (answer == FEW_UNUSUAL) return DAFT_KERNEL(daft_closest_at_large)(tlas, ray, ignore, hit);
    if (answer == FEW_MET) return few_closest(tlas, ray, &f, ignore, hit);
    *hit = (daft_hit){.t = ray->tmax, .instance = UINT32_MAX};
    return false;
}

/* What is a leaf alone, as ground is, stops nearly every ray that meets its box, and is soon asked: so it comes
 * first. */
static __attribute__((noinline)) bool few_stops(const daft_tlas *tlas, const daft_ray *ray, few_ray *f)
{
    const daft_few *few = tlas->few;
    daft_mesh_ray r = few_mesh_ray(ray, f, tlas->intersection);
    r.inner = daft_inner_of(ray->tmin, ray->tmax);
    for (uint32_t leaves = f->bits & few->leaves; leaves; leaves &= leaves - 1) {
        const few_thing *thing = &few->things[__builtin_ctz(leaves)];
        few_enter(thing, ray, &r);
        daft_nearest n = {.t = ray->tmax, .triangle = DAFT_NO_TRIANGLE};
        if (DAFT_KERNEL(daft_leaf_stops)(thing->bvh->blocks, thing->child, &r, limit_of(ray->tmax, true), &n)) return true;
    }
    f->bits &= ~few->leaves;
    while (f->bits) {
        float enter;
        const few_thing *thing = few_next(few, f, &enter);
        slab_origin at = slab_origin_of(few_enter(thing, ray, &r));
        daft_nearest n = {.t = ray->tmax, .triangle = DAFT_NO_TRIANGLE};
        if (mesh_search(thing->bvh, thing->child, &f->way, &r, &at, &at, true, true, &n)) return true;
    }
    return false;
}

bool DAFT_KERNEL(daft_occluded)(const daft_tlas *tlas, const daft_ray *ray)
{
    few_ray f;
    few_answer answer = tlas->few ? few_meet(tlas->few, ray, &f) : FEW_UNUSUAL;
    if (answer == FEW_UNUSUAL) return DAFT_KERNEL(daft_occluded_at_large)(tlas, ray);
    return answer == FEW_MET && (f.bits &= tlas->few->casters) && few_stops(tlas, ray, &f);
}
