/* Points that balls inside a mesh hide from a lamp (accel/inner.h): what lies behind one in the lamp's picture is dark, and no
 * triangle is looked at. A ball stays one in light space, where it is moved by an even scale, and shrinks to one where it is not; what
 * coordinates there are off by is taken off its radius. The ray to (u, v, 1) passes the centre, z·(u0, v0, 1), at the distance
 *     |(u, v, 1) × z·(u0, v0, 1)| / |(u, v, 1)|,
 * and with du = u - u0, dv = v - v0 the square of the product is z²·(du² + dv² + (du·v0 - dv·u0)²): nothing cancels. */
#include "accel/inner.h"
#include "render/shadow.h"

enum { BALLS = DAFT_INNER_BALLS };

/* A mesh's balls in a lamp's picture. */
typedef struct discs {
    _Alignas(64) float u[BALLS], v[BALLS]; /* of the centres */
    float slope_u[BALLS], slope_v[BALLS];  /* the same; of a sun's, 0 */
    float share[BALLS];                    /* (radius / z)², z as above or, of a sun's, 1; negative: of no use */
    float far[BALLS];                      /* no point of the ball is deeper */
    float low_u[BALLS], high_u[BALLS], low_v[BALLS], high_v[BALLS];
    uint32_t cap_bits[BALLS];              /* of the caps that may stand between the ball and the lamp */
    node_boxes caps;
} discs;

/* No more than the map to frame space makes of any length 1: one over the root of the largest sum of a row of the other map's
 * m·mᵀ, which for even scales and such along the mesh's own axes is exact. */
static float least_scale(const daft_instance *s)
{
    const float *m = s->to_object.m;
    float most = 0;
    for (int i = 0; i < 3; i++) {
        float sum = 0;
        for (int j = 0; j < 3; j++)
            sum += fabsf(m[3 * i] * m[3 * j] + m[3 * i + 1] * m[3 * j + 1] + m[3 * i + 2] * m[3 * j + 2]);
        most = fmaxf(most, sum);
    }
    return (1 - 0x1p-18f) / sqrtf(most);
}

/* In the mesh's own space a place is off by some 2^-22 of what its sums are of. */
static bool lamp_is_outside(const caster *c)
{
    const daft_instance *s = c->instance;
    const daft_vec3 lamp = c->lamp->position;
    float sum = 0;
    if (c->lamp->sun) return true;
    for (int k = 0; k < 3; k++) {
        const float *m = &s->to_object.m[3 * k];
        sum += fabsf(m[0] * lamp.x) + fabsf(m[1] * lamp.y) + fabsf(m[2] * lamp.z) + fabsf(s->to_object.t[k]);
    }
    return daft_inner_is_outside(s->mesh, daft_to_double(daft_affine_point(&s->to_object, lamp)), (double)(sum * 0x1p-18f));
}

/* DAFT_VL balls from i on. In light space points, corners and the lamp are off by less than 2^-20 of the magnitudes there, and points in
 * the picture by no more than its slack. */
DAFT_INLINE void discs_place(const light *l, const picture_map *map, const daft_inner *inner, float scale, int i, discs *out)
{
    const float *m = map->map.m, *t = map->map.t;
    const vf one = vf_set(1), zero = vf_set(0), inf = vf_set(INFINITY);
    vf x = vf_load(&inner->centre[0][i]), y = vf_load(&inner->centre[1][i]), z = vf_load(&inner->centre[2][i]), at[3];
    for (int k = 0; k < 3; k++)
        at[k] = vf_set(m[3 * k]) * x + vf_set(m[3 * k + 1]) * y + vf_set(m[3 * k + 2]) * z + vf_set(t[k]);
    vf pad = (vf_abs(at[0]) + vf_abs(at[1]) + vf_abs(at[2]) + vf_set(l->size + map->still)) * vf_set(0x1p-18f);
    vf radius = vf_load(&inner->radius[i]) * vf_set(scale), far = at[2] + radius + pad, slant = one, away = one;
    vm use = vf_lt(zero, radius);
    if (!l->sun) {
        away = at[2] + vf_set(l->away);
        use = vm_and(use, vf_lt(radius + pad, away));
        vf inverse = one / away;
        at[0] = at[0] * inverse, at[1] = at[1] * inverse;
        slant = vf_sqrt(one + at[0] * at[0] + at[1] * at[1]);
    }
    radius = radius - pad - vf_set(l->slack_u + l->slack_v) * away * slant;
    use = vm_and(use, vf_lt(zero, radius));
    vf part = radius / away, reach = l->sun ? part : part * slant / (one - part);
    reach = vf_if_then_else(vf_lt(part, one), reach, inf);
    vf_store(&out->u[i], at[0]), vf_store(&out->v[i], at[1]);
    vf_store(&out->slope_u[i], l->sun ? zero : at[0]), vf_store(&out->slope_v[i], l->sun ? zero : at[1]);
    vf_store(&out->share[i], vf_if_then_else(use, part * part * vf_set(1 - 0x1p-16f), -one));
    vf_store(&out->far[i], vf_if_then_else(use, far, inf));
    vf_store(&out->low_u[i], vf_if_then_else(use, at[0] - reach, inf)), vf_store(&out->high_u[i], at[0] + reach);
    vf_store(&out->low_v[i], at[1] - reach), vf_store(&out->high_v[i], at[1] + reach);
}

static void discs_setup(const caster *c, discs *out)
{
    const daft_inner *inner = c->instance->bvh->inner;
    const daft_affine map = DAFT_KERNEL(daft_light_compose)(&c->light->map, &c->instance->to_frame, c->light->origin);
    const picture_map to_light = picture_map_make(&map);
    float scale = least_scale(c->instance);
    for (int i = 0; i < BALLS; i += DAFT_VL) discs_place(c->light, &to_light, inner, scale, i, out);
    memset(out->cap_bits, 0, sizeof out->cap_bits);
    if (!inner->cap_count) return;
    uint32_t caps = DAFT_KERNEL(daft_node_project)(c->light, &to_light, &inner->caps, &out->caps);
    for (; caps; caps &= caps - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(caps);
        for (int i = 0; i < BALLS; i++) out->cap_bits[i] |= (uint32_t)!(out->caps.near[k] >= out->far[i]) << k;
    }
}

/* The balls that a block may lie behind. */
DAFT_INLINE uint32_t discs_before(const discs *d, const shadow_points *p, uint32_t b)
{
    uint32_t all = 0;
    for (int i = 0; i < BALLS; i += DAFT_VL) {
        vm u = vm_and(vf_le(vf_load(&d->low_u[i]), vf_set(p->high_u[b])), vf_le(vf_set(p->low_u[b]), vf_load(&d->high_u[i])));
        vm v = vm_and(vf_le(vf_load(&d->low_v[i]), vf_set(p->high_v[b])), vf_le(vf_set(p->low_v[b]), vf_load(&d->high_v[i])));
        all |= vbits_from_mask(vm_and(vm_and(u, v), vf_le(vf_load(&d->far[i]), vf_set(p->far[b])))) << i;
    }
    return all;
}

/* The bits of the DAFT_VL points from `at` on that lie behind a ball. */
DAFT_INLINE vbits points_stopped(const discs *d, int i, bool sun, const shadow_points *p, uint32_t at)
{
    vf u = vf_load(&p->u[at]), v = vf_load(&p->v[at]), one = vf_set(1);
    vf du = u - vf_set(d->u[i]), dv = v - vf_set(d->v[i]), across = du * vf_set(d->slope_v[i]) - dv * vf_set(d->slope_u[i]);
    vf square = sun ? one : one + u * u + v * v;
    vm in = vf_lt(du * du + dv * dv + across * across, square * vf_set(d->share[i]));
    return vbits_from_mask(vm_and(in, vf_le(vf_set(d->far[i]), vf_load(&p->depth[at]))));
}

static uint32_t under_caps(const discs *d, uint32_t caps, const shadow_points *p, uint32_t b)
{
    uint32_t under = 0;
    for (; caps; caps &= caps - 1) {
        picture_box box = node_child(&d->caps, __builtin_ctz(caps));
        box.near = -INFINITY;
        under |= points_behind(&box, p, b);
    }
    return under;
}

static void darken(const caster *c, uint32_t b, uint32_t dark)
{
    shadow_points *p = c->points;
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
        uint32_t at = b * SHADOW_BLOCK + k;
        vbits some = dark >> k & DAFT_ALL_LANES;
        if (c->convex) some &= ~lie_on(c, DAFT_NO_TRIANGLE, at);
        vf_store(&p->depth[at], vf_if_then_else(vm_from_bits(some), vf_set(-INFINITY), vf_load(&p->depth[at])));
    }
    block_darkened(p, b);
}

/* A ball's picture is convex: it holds all points between corners that it holds. */
bool DAFT_KERNEL(daft_inner_hides)(const caster *c)
{
    const light *l = c->light;
    const float u[4] = {l->low_u, l->high_u, l->low_u, l->high_u}, v[4] = {l->low_v, l->low_v, l->high_v, l->high_v};
    const vf one = vf_set(1);
    discs d;
    if (!lamp_is_outside(c)) return false;
    discs_setup(c, &d);
    for (int i = 0; i < BALLS; i += DAFT_VL) {
        vbits in = vbits_from_mask(vf_le(vf_load(&d.far[i]), vf_set(l->near))) & vbits_from_mask(vi_eq(vi_load(&d.cap_bits[i]), vi_set(0)));
        for (int k = 0; k < 4 && in; k++) {
            vf du = vf_set(u[k]) - vf_load(&d.u[i]), dv = vf_set(v[k]) - vf_load(&d.v[i]);
            vf across = du * vf_load(&d.slope_v[i]) - dv * vf_load(&d.slope_u[i]);
            vf square = l->sun ? one : one + vf_set(u[k]) * vf_set(u[k]) + vf_set(v[k]) * vf_set(v[k]);
            in &= vbits_from_mask(vf_lt(du * du + dv * dv + across * across, square * vf_load(&d.share[i])));
        }
        if (in) return true;
    }
    return false;
}

void DAFT_KERNEL(daft_inner_shadow)(const caster *c, const block_points *points, uint32_t count)
{
    discs d;
    if (!lamp_is_outside(c)) return;
    discs_setup(c, &d);
    for (uint32_t n = 0; n < count; n++) {
        uint32_t b = points[n].block, dark = 0;
        for (uint32_t balls = discs_before(&d, c->points, b); balls; balls &= balls - 1) {
            int i = __builtin_ctz(balls);
            uint32_t stopped = 0;
            for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL)
                if (points[n].points >> k & DAFT_ALL_LANES) stopped |= points_stopped(&d, i, c->light->sun, c->points, b * SHADOW_BLOCK + k) << k;
            stopped &= points[n].points;
            if (stopped && d.cap_bits[i]) stopped &= ~under_caps(&d, d.cap_bits[i], c->points, b);
            dark |= stopped;
        }
        if (dark) darken(c, b, dark);
    }
}
