/* Rays side by side against a sphere, for the kernels of windows and of fine tiles. */
#ifndef DAFT_SPHERE_H
#define DAFT_SPHERE_H

#include "raster/grid/grid.h"

#define SPHERE_ROUNDING 0x1p-18f

/* |error(discriminant)| <= 32u·(|c| + r)², from a projection that is off by a few u·|c| and is squared. Its root is
 * then off by less than 2·error / max(root, sqrt(error)); z by that and a few u of the sphere's reach. */
typedef struct sphere {
    vf x, y, z, focal, r2, doubt, root_doubt, rounding;
} sphere;

DAFT_INLINE sphere sphere_of(const daft_tile_job *j, const daft_view_instance *view)
{
    const float *c = view->to_view.t, radius = view->instance->radius;
    const float reach = sqrtf(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) + radius,
                limit = 32 * UNIT * reach * reach + TINY;
    return (sphere){vf_set(c[0]),
                    vf_set(c[1]),
                    vf_set(c[2]),
                    vf_set(j->pencil.focal),
                    vf_set(radius * radius),
                    vf_set(limit),
                    vf_set(sqrtf(limit)),
                    vf_set(reach * SPHERE_ROUNDING)};
}

/* Lanes that may meet it, of which some are not sure to; and intervals of w. */
typedef struct sphere_hits {
    vbits lanes, unsure;
    vf low, high;
} sphere_hits;

DAFT_INLINE sphere_hits sphere_meet(const sphere *s, vf dx, vf dy)
{
    const vf one = vf_set(1), inf = vf_set(INFINITY), tiny = vf_set(TINY);
    vf inverse = one / (dx * dx + dy * dy + s->focal * s->focal),
       along = (dx * s->x + dy * s->y + s->focal * s->z) * inverse;
    vf ax = s->x - dx * along, ay = s->y - dy * along, az = s->z - s->focal * along;
    vf disc = s->r2 - (ax * ax + ay * ay + az * az);
    sphere_hits h = {.lanes = DAFT_ALL_LANES & ~vbits_from_mask(vf_lt(disc, -s->doubt))};
    if (!h.lanes) return h;
    h.unsure = h.lanes & ~vbits_from_mask(vf_lt(s->doubt, disc));
    vf chord = vf_sqrt(vf_max(disc, vf_set(0))), half = chord * vf_sqrt(inverse);
    vf error = vf_set(2) * s->doubt / vf_max(chord, s->root_doubt) + s->rounding;
    vf near = (along - half) * s->focal, far = (along + half) * s->focal;
    vbits ahead = vbits_from_mask(vf_lt(error, near)), behind = vbits_from_mask(vf_lt(near, -error));
    vbits inside = vbits_from_mask(vf_lt(error, far)) & behind;
    h.unsure |= h.lanes & ~ahead & ~inside;
    h.lanes &= ~(behind & vbits_from_mask(vf_lt(far, -error)));
    h.unsure &= h.lanes;
    vf z = vf_if_then_else(vm_from_bits(ahead), near, far), low = z - error, high = z + error;
    vm known = vm_from_bits(ahead | inside); /* then both are positive */
    h.low = vf_if_then_else(known, vf_set(1 - 4 * UNIT) / vf_max(high, tiny), -inf);
    h.high = vf_if_then_else(known, vf_set(1 + 4 * UNIT) / vf_max(low, tiny), inf);
    return h;
}

#endif
