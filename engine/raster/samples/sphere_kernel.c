/* Spheres as occluders: blocks of points behind a sphere's box, against the sphere. What lies within the error of its
 * edge or its depth is decided again in double. */
#include "raster/samples/samples.h"

#include <string.h>

/* Whether the sphere's surface lies between the point and the light, in double. */
static bool sphere_between(const daft_instance *s, const shadow_ray *w)
{
    const float *at = s->to_frame.t;
    daft_dvec3 centre = daft_dsub(daft_dv3((double)at[0], (double)at[1], (double)at[2]), w->from);
    double dd = daft_ddot(w->direction, w->direction), along = daft_ddot(centre, w->direction) / dd,
           r = (double)s->radius;
    daft_dvec3 aside = daft_dsub(centre, daft_dscale(w->direction, along));
    double square = r * r - daft_ddot(aside, aside);
    if (!(square > 0)) return false;
    double half = sqrt(square / dd);
    return on_shadow_ray(w, along - half) || on_shadow_ray(w, along + half);
}

/* A sphere is a surface: with the light within, it is its far side that may stand between. The bound of the
 * discriminant's error is that of grid/coverage_kernel.c. */
typedef struct sphere {
    vf cx, cy, cz;          /* view space */
    vf square, blur, error; /* radius squared; |error(discriminant)|; of depths */
} sphere;

/* The centre in view space. */
static void centre_move(const light_view *l, const daft_instance *s, float at[3])
{
    const daft_affine map = daft_pencil_map(&l->pencil, &s->to_frame);
    memcpy(at, map.t, sizeof map.t);
}

/* The slopes of the tangents from the light to a circle of radius r around (x, z), 0 < r < z, no closer than they are
 * when x and r are off by off_x and z by off_z. */
static void tangents(float x, float z, float r, float off_x, float off_z, float *low, float *high)
{
    double a, b;
    float near = 1 / (z - r);
    daft_sphere_slopes((double)x, (double)z, (double)r, &a, &b);
    float error = (float)(fabs(a) + fabs(b)) * 0x1p-20f + (off_x + (fabsf(x) + r) * near * off_z) * near;
    *low = fmaxf(*low, (float)a - error), *high = fminf(*high, (float)b + error);
}

void DAFT_KERNEL(daft_sphere_occluder_box)(const light_view *l, const daft_instance *s, picture_box *box)
{
    float at[3], r = s->radius;
    centre_move(l, s, at);
    float size = fabsf(at[0]) + fabsf(at[1]) + fabsf(at[2]) + r + l->size, off = size * 0x1p-20f,
          z = at[2] + l->pencil.away;
    if (l->pencil.parallel) {
        box->low_u = fmaxf(box->low_u, at[0] - r - off), box->high_u = fminf(box->high_u, at[0] + r + off);
        box->low_v = fmaxf(box->low_v, at[1] - r - off), box->high_v = fminf(box->high_v, at[1] + r + off);
    } else if (r > 0 && z - r > off + l->pencil.away * 0x1p-10f) {
        tangents(at[0], z, r, off, off + l->pencil.away * 0x1p-22f, &box->low_u, &box->high_u);
        tangents(at[1], z, r, off, off + l->pencil.away * 0x1p-22f, &box->low_v, &box->high_v);
    }
}

static sphere sphere_setup(const occluder *c)
{
    const light_view *l = c->view;
    float at[3], r = c->instance->radius;
    centre_move(l, c->instance, at);
    float reach = fabsf(at[0]) + fabsf(at[1]) + fabsf(at[2]) + r + l->size;
    return (sphere){
        vf_set(at[0]),           vf_set(at[1]), vf_set(at[2]), vf_set(r * r), vf_set(32 * UNIT * reach * reach),
        vf_set(reach * 0x1p-19f)};
}

static void sphere_block(const occluder *c, const sphere *s, uint32_t b)
{
    shadow_points *p = c->points;
    bool sun = c->view->pencil.parallel;
    vf zero = vf_set(0), none = vf_set(-INFINITY);
    for (uint32_t k = b * SHADOW_BLOCK; k < (b + 1) * SHADOW_BLOCK; k += DAFT_VL) {
        vf limit = vf_load(&p->depth[k]), depth = vf_max(limit, vf_set(-0x1p100f)), disc, middle, scale = vf_set(1);
        vf3 m = {s->cx - vf_load(&p->x[k]), s->cy - vf_load(&p->y[k]), s->cz - depth}; /* from the point to the centre
                                                                                        */
        if (sun) {
            disc = s->square - (m.x * m.x + m.y * m.y), middle = s->cz;
        } else {
            vf3 d = {vf_load(&p->x[k]), vf_load(&p->y[k]), vf_load(&p->z[k])};
            vf dd = vf3_dot(d, d), along = vf3_dot(m, d) / dd;
            vf3 aside = {m.x - d.x * along, m.y - d.y * along, m.z - d.z * along};
            disc = s->square - vf3_dot(aside, aside), middle = depth + along * d.z, scale = d.z / vf_sqrt(dd);
        }
        const vf light = vf_load(&p->end[k]);
        vm met = vm_and(vf_lt(-s->blur, disc), vf_lt(none, limit));
        if (c->convex) met = vm_and(met, vm_not(vi_eq(vi_load(&p->instance[k]), vi_set((int32_t)c->number))));
        if (!vbits_from_mask(met)) continue;
        vf half = vf_sqrt(vf_max(disc, zero)) * scale, near = middle - half, far = middle + half;
        vf error = s->error + vf_set(2) * s->blur / vf_max(half, vf_sqrt(s->blur)); /* the last: of the root */
        vm dark = vm_and(vm_and(met, vf_lt(s->blur, disc)), vf_lt(near + error, limit)),
           apart = vf_lt(limit + error, near);
        if (!sun) {
            error = error + vf_set(c->view->pencil.away * 0x1p-20f);
            dark = vm_and(dark, vf_lt(light + error, near));
            apart = vm_or(
                apart, vm_or(vf_lt(far, light - error), vm_and(vf_lt(near, light - error), vf_lt(limit + error, far))));
        }
        vf_store(&p->depth[k], vf_if_then_else(dark, none, limit));
        for (vbits doubt = vbits_from_mask(met) & ~vbits_from_mask(vm_or(dark, apart)); doubt; doubt &= doubt - 1) {
            uint32_t i = k + (uint32_t)__builtin_ctz(doubt);
            shadow_ray w = shadow_ray_of(c->samples, c->light, p->source[i]);
            if (sphere_between(c->instance, &w)) p->depth[i] = -INFINITY;
        }
    }
    block_darkened(p, b);
}

void DAFT_KERNEL(daft_sphere_occluder_shadow)(const occluder *c, const block_set *behind)
{
    const sphere s = sphere_setup(c);
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1)
            sphere_block(c, &s, word * 64 + (uint32_t)__builtin_ctzll(left));
}
