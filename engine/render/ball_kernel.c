/* The shadow pencil's spheres: blocks of points behind a sphere's bounds, against the sphere. What is within the error of
 * its edge or its depth is decided again in double. */
#include "render/shadow.h"

#define UNIT 0x1p-24f

/* Whether the sphere's surface lies between the point and the lamp, in double. */
static bool ball_between(const daft_instance *s, const sight *w)
{
    const float *at = s->to_frame.t;
    daft_dvec3 centre = daft_dsub(daft_dv3((double)at[0], (double)at[1], (double)at[2]), w->from);
    double dd = daft_ddot(w->direction, w->direction), along = daft_ddot(centre, w->direction) / dd,
           r = (double)s->radius;
    daft_dvec3 aside = daft_dsub(centre, daft_dscale(w->direction, along));
    double square = r * r - daft_ddot(aside, aside);
    if (!(square > 0)) return false;
    double half = sqrt(square / dd);
    return on_sight(w, along - half) || on_sight(w, along + half);
}

/* A sphere is a surface: with the lamp within, it is its far side that may stand between. The bound of the
 * discriminant's error is that of raster/tile_kernel.c. */
typedef struct ball {
    vf cx, cy, cz;          /* light space */
    vf square, blur, error; /* radius squared; |error(discriminant)|; of depths */
} ball;

static void centre_move(const light *l, const daft_instance *s, float at[3])
{
    const float *t = s->to_frame.t;
    for (int i = 0; i < 3; i++) {
        const float *row = &l->map.m[3 * i];
        at[i] = (float)((double)row[0] * ((double)t[0] - (double)l->origin.x) +
                        (double)row[1] * ((double)t[1] - (double)l->origin.y) +
                        (double)row[2] * ((double)t[2] - (double)l->origin.z));
    }
}

/* The slopes of the two tangents from the lamp to a circle of radius r around (x, z), 0 < r < z, in the order of their
 * size (Mara and McGuire, "2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere", 2013), no closer than they
 * are when x and r are off by off_x and z by off_z. */
static void tangents(float x, float z, float r, float off_x, float off_z, float *low, float *high)
{
    float inverse = 1 / ((z - r) * (z + r)), root = r * sqrtf(fmaxf(x * x + (z - r) * (z + r), 0)), near = 1 / (z - r);
    float error = (fabsf(x) * z + root) * inverse * 0x1p-20f + (off_x + (fabsf(x) + r) * near * off_z) * near;
    *low = fmaxf(*low, (x * z - root) * inverse - error), *high = fminf(*high, (x * z + root) * inverse + error);
}

void DAFT_KERNEL(daft_ball_box)(const light *l, const daft_instance *s, picture_box *box)
{
    float at[3], r = s->radius;
    centre_move(l, s, at);
    float size = fabsf(at[0]) + fabsf(at[1]) + fabsf(at[2]) + r + l->size, off = size * 0x1p-20f, z = at[2] + l->away;
    if (l->sun) {
        box->low_u = fmaxf(box->low_u, at[0] - r - off), box->high_u = fminf(box->high_u, at[0] + r + off);
        box->low_v = fmaxf(box->low_v, at[1] - r - off), box->high_v = fminf(box->high_v, at[1] + r + off);
    } else if (r > 0 && z - r > off + l->away * 0x1p-10f) {
        tangents(at[0], z, r, off, off + l->away * 0x1p-22f, &box->low_u, &box->high_u);
        tangents(at[1], z, r, off, off + l->away * 0x1p-22f, &box->low_v, &box->high_v);
    }
}

static ball ball_setup(const caster *c)
{
    const light *l = c->light;
    float at[3], r = c->instance->radius;
    centre_move(l, c->instance, at);
    float reach = fabsf(at[0]) + fabsf(at[1]) + fabsf(at[2]) + r + l->size;
    return (ball){
        vf_set(at[0]),           vf_set(at[1]), vf_set(at[2]), vf_set(r * r), vf_set(32 * UNIT * reach * reach),
        vf_set(reach * 0x1p-19f)};
}

static void ball_block(const caster *c, const ball *s, uint32_t b)
{
    shadow_points *p = c->points;
    bool sun = c->light->sun;
    vf zero = vf_set(0), none = vf_set(-INFINITY), lamp = vf_set(-c->light->away);
    for (uint32_t k = b * SHADOW_BLOCK; k < (b + 1) * SHADOW_BLOCK; k += DAFT_VL) {
        vf limit = vf_load(&p->depth[k]), depth = vf_max(limit, vf_set(-0x1p100f)), disc, middle, scale = vf_set(1);
        vf3 m = {s->cx - vf_load(&p->x[k]), s->cy - vf_load(&p->y[k]),
                 s->cz - depth}; /* from the point to the centre */
        if (sun) {
            disc = s->square - (m.x * m.x + m.y * m.y), middle = s->cz;
        } else {
            vf3 d = {vf_load(&p->x[k]), vf_load(&p->y[k]), vf_load(&p->z[k])};
            vf dd = vf3_dot(d, d), along = vf3_dot(m, d) / dd;
            vf3 aside = {m.x - d.x * along, m.y - d.y * along, m.z - d.z * along};
            disc = s->square - vf3_dot(aside, aside), middle = depth + along * d.z, scale = d.z / vf_sqrt(dd);
        }
        vm met = vm_and(vf_lt(-s->blur, disc), vf_lt(none, limit));
        if (c->convex) met = vm_and(met, vm_not(vi_eq(vi_load(&p->instance[k]), vi_set((int32_t)c->number))));
        if (!vbits_from_mask(met)) continue;
        vf half = vf_sqrt(vf_max(disc, zero)) * scale, near = middle - half, far = middle + half;
        vf error = s->error + vf_set(2) * s->blur / vf_max(half, vf_sqrt(s->blur)); /* the last: of the root */
        vm dark = vm_and(vm_and(met, vf_lt(s->blur, disc)), vf_lt(near + error, limit)),
           apart = vf_lt(limit + error, near);
        if (!sun) {
            error = error + vf_set(c->light->away * 0x1p-20f);
            dark = vm_and(dark, vf_lt(lamp + error, near));
            apart = vm_or(
                apart, vm_or(vf_lt(far, lamp - error), vm_and(vf_lt(near, lamp - error), vf_lt(limit + error, far))));
        }
        vf_store(&p->depth[k], vf_if_then_else(dark, none, limit));
        for (vbits doubt = vbits_from_mask(met) & ~vbits_from_mask(vm_or(dark, apart)); doubt; doubt &= doubt - 1) {
            uint32_t i = k + (uint32_t)__builtin_ctz(doubt);
            sight w = sight_of(c->batch, c->lamp, p->source[i]);
            if (ball_between(c->instance, &w)) p->depth[i] = -INFINITY;
        }
    }
    block_darkened(p, b);
}

void DAFT_KERNEL(daft_ball_shadow)(const caster *c, const block_set *behind)
{
    const ball s = ball_setup(c);
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1)
            ball_block(c, &s, word * 64 + (uint32_t)__builtin_ctzll(left));
}
