/* Lights that are areas, in closed form: a rectangle that shines to one side, and a sphere. Their colour is their
 * radiance, and what a white surface sends on of it is their form factor, 0 to 1.
 *
 * Rectangle: Lambert's sum over the edges of what of it lies above the horizon (Arvo, "Analytic Methods for Simulated
 * Light Transport", 1995, section 4.2). Sphere: Lagarde and de Rousiers, "Moving Frostbite to PBR", SIGGRAPH 2014,
 * listing 7. Both are exact, but for roundings: 1e-6 beside, of a rectangle, 1e-6 times its distance over its sides.
 *
 * Highlights: the lobe around the mirrored view is taken for a cosine lobe whose directions are stretched (Heitz and
 * others, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines", SIGGRAPH 2016; here without their
 * tables: Phong's lobe by the height of its peak, GGX's by its width at normal view). They are off by a seventh to a
 * third of what integration gives (tests/unit/render/test_area.c). */
#include "shade/kernels.h"
#include "shade/batch_lanes.h"

DAFT_INLINE vf3 spread(daft_vec3 a) { return (vf3){vf_set(a.x), vf_set(a.y), vf_set(a.z)}; }
DAFT_INLINE vf3 sum_of(vf3 a, vf3 b) { return (vf3){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE vf3 difference(vf3 a, vf3 b) { return (vf3){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE vf3 scaled(vf3 a, vf s) { return (vf3){a.x * s, a.y * s, a.z * s}; }
DAFT_INLINE vf3 cross(vf3 a, vf3 b)
{
    return (vf3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DAFT_INLINE vf3 either(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_if_then_else(m, a.x, b.x), vf_if_then_else(m, a.y, b.y), vf_if_then_else(m, a.z, b.z)};
}

/* The angle that an edge spans, times the cosine between `n` and the normal of its plane through the origin. `c`: the
 * product of its ends, as the product of one end and the edge, so that far edges keep their digits. One
 * division serves both the angle, by the length of c and the product of the ends, and the cosine. */
DAFT_INLINE vf edge_part(vf3 a, vf3 b, vf3 c, vf3 n)
{
    const vf zero = vf_set(0), tiny = vf_set(1e-30f), x = vf3_dot(a, b), ax = vf_abs(x);
    const vf y = vf_max(vf_sqrt(vf3_dot(c, c)), tiny), large = vf_max(ax, y), small = vf_min(ax, y);
    const vm upper = vf_lt(large * vf_set(0.414213562f), small); /* above tan(pi/8): turned by pi/4 */
    const vf over = vf_if_then_else(upper, small - large, small), under = vf_if_then_else(upper, small + large, large);
    const vf both = vf_set(1) / (under * y), r = over * y * both, r2 = r * r;
    vf s = vf_set(8.05374449538e-2f); /* the arc tangent up to tan(pi/8): Moshier, Cephes, atanf() */
    s = s * r2 - vf_set(1.38776856032e-1f);
    s = s * r2 + vf_set(1.99777106478e-1f);
    s = s * r2 - vf_set(3.33329491539e-1f);
    vf angle = r + r * r2 * s;
    angle = angle + vf_if_then_else(upper, vf_set(0.785398163f), zero);
    angle = vf_if_then_else(vf_lt(ax, y), vf_set(1.57079633f) - angle, angle);
    angle = vf_if_then_else(vf_lt(x, zero), vf_set(3.14159265f) - angle, angle);
    return angle * (vf3_dot(n, c) * under * both);
}

/* Lambert's sum where no corner is below the horizon: that below, bit for bit. */
DAFT_INLINE vf all_above(const vf3 corners[4], const vf3 edges[4], vf3 n)
{
    vf sum = vf_set(0);
#pragma GCC unroll 4 /* so that the edges' long chains overlap */
    for (int k = 0; k < 4; k++) {
        const vf3 a = corners[k], b = corners[(k + 1) % 4];
        sum = sum + edge_part(a, b, cross(a, edges[k]), n);
    }
    return vf_clamp01(sum * vf_set(0.159154943f)); /* 1 / 2pi */
}

/* The form factor of the parallelogram corner, corner + u, corner + u + v, corner + v, for a surface at the origin with
 * normal n; u × v points away from it. Edges end at the horizon, along which one more joins where the polygon dips
 * below it to where it comes up. */
DAFT_INLINE vf parallelogram(vf3 corner, vf3 u, vf3 v, vf3 n)
{
    const vf zero = vf_set(0), one = vf_set(1);
    const vf3 corners[4] = {corner, sum_of(corner, u), sum_of(sum_of(corner, u), v), sum_of(corner, v)},
              edges[4] = {u, v, scaled(u, -one), scaled(v, -one)};
    vf height[4];
    for (int k = 0; k < 4; k++) height[k] = vf3_dot(n, corners[k]);
    const vf lowest = vf_min(vf_min(height[0], height[1]), vf_min(height[2], height[3])),
             highest = vf_max(vf_max(height[0], height[1]), vf_max(height[2], height[3]));
    if (!vbits_from_mask(vf_lt(zero, highest))) return zero;
    if (vbits_from_mask(vf_lt(zero, lowest)) == DAFT_ALL_LANES) return all_above(corners, edges, n);
    vf3 down = {zero, zero, zero}, up = down;
    vf sum = zero;
    for (int k = 0; k < 4; k++) {
        const vf3 a = corners[k], b = corners[(k + 1) % 4], e = edges[k];
        const vf from = height[k], to = height[(k + 1) % 4], fall = from - to;
        const vm starts = vf_lt(zero, from), ends = vf_lt(zero, to);
        const vf t = vf_clamp01(from / vf_if_then_else(vm_and(starts, ends), one, fall)); /* where it crosses */
        const vf3 crossing = sum_of(a, scaled(e, t));
        const vf part = vf_if_then_else(starts, vf_if_then_else(ends, one, t), one - t);
        const vf3 first = either(starts, a, crossing), last = either(ends, b, crossing);
        const vf one_part = edge_part(first, last, cross(first, scaled(e, part)), n);
        sum = sum + vf_if_then_else(vm_or(starts, ends), one_part, zero);
        down = either(vm_and(starts, vm_not(ends)), crossing, down);
        up = either(vm_and(vm_not(starts), ends), crossing, up);
    }
    sum = sum + vf_atan2(vf3_dot(n, cross(down, up)), vf3_dot(down, up));
    return vf_clamp01(sum * vf_set(0.159154943f)); /* 1 / 2pi */
}

/* Of the rectangle as seen from the points. */
DAFT_INLINE vf3 corner_from(const daft_light_source *source, vf3 p)
{
    const daft_vec3 half = daft_scale(daft_add(source->edges[0], source->edges[1]), 0.5f);
    return difference(spread(daft_sub(source->position, half)), p);
}

/* `c`: the cosine to the middle, h2: the square of the distance in radii. */
DAFT_INLINE vf sphere_form(vf c, vf h2)
{
    const vf zero = vf_set(0), one = vf_set(1), pi = vf_set(3.14159265f), h = vf_sqrt(h2);
    const vf x = vf_sqrt(vf_max(h2 - one, vf_set(1e-12f))),
             sine = vf_sqrt(vf_max((one - c) * (one + c), vf_set(1e-12f)));
    const vf y = vf_max(vf_min(-x * c / sine, one), -one), s = sine * vf_sqrt((one - y) * (one + y));
    const vf cut = ((c * vf_atan2(vf_sqrt((one - y) * (one + y)), y) - x * s) / h2 + vf_atan2(s, x)) / pi;
    const vf form = vf_if_then_else(vf_lt(one, c * h), c / h2, vf_max(cut, zero));
    return vf_if_then_else(vm_and(vf_lt(one, h2), vf_lt(-one, c * h * vf_set(1.0001f))), form, zero);
}

void DAFT_KERNEL(daft_area_form)(const daft_batch *batch, uint32_t i, const daft_light_source *source, vf *form)
{
    const vf3 p = lanes_load(&batch->point, i), n = lanes_load(&batch->normal, i);
    const vf3 to = difference(spread(source->position), p);
    const vf length2 = vf3_dot(to, to), tiny = vf_set(1e-30f);
    if (source->area == DAFT_AREA_SPHERE) {
        const vf c = vf3_dot(n, to) / vf_sqrt(vf_max(length2, tiny)), radius = vf_set(source->radius);
        *form = sphere_form(c, length2 / (radius * radius));
        return;
    }
    const vm before = vf_lt(vf_set(0), vf3_dot(spread(source->to_light), to));
    if (!vbits_from_mask(before)) {
        *form = vf_set(0);
        return;
    }
    const vf all = parallelogram(corner_from(source, p), spread(source->edges[0]), spread(source->edges[1]), n);
    *form = vf_if_then_else(before, all, vf_set(0));
}

/* Two axes across a unit vector, as daft_axes_across() makes them. */
DAFT_INLINE void axes_across(vf3 n, vf3 *a, vf3 *b)
{
    const vf one = vf_set(1), sign = vf_if_then_else(vf_lt(n.z, vf_set(0)), -one, one);
    const vf p = -one / (sign + n.z), q = n.x * n.y * p;
    *a = (vf3){one + sign * n.x * n.x * p, sign * q, -sign * n.x};
    *b = (vf3){q, sign + n.y * n.y * p, -n.y};
}

/* The sphere as a disc of the plane that lies across the lobe's axis at distance 1, in that plane's stretched measure
 * (the form factor between an element and a disc that is parallel to it: Howell, "A Catalog of Radiation Heat Transfer
 * Configuration Factors", B-13). */
DAFT_INLINE vf sphere_gleam(const daft_light_source *source, vf3 to, vf3 axis, vf width2)
{
    const vf zero = vf_set(0), one = vf_set(1), tiny = vf_set(1e-12f), radius = vf_set(source->radius);
    const vf length2 = vf_max(vf3_dot(to, to), tiny), sine2 = vf_min(radius * radius / length2, vf_set(0.9999f));
    const vf sine = vf_sqrt(sine2), c = vf3_dot(axis, to) / vf_sqrt(length2), level = vf_max(c, vf_max(sine, tiny));
    const vf tangent2 = sine2 / (one - sine2), off2 = vf_max(one - level * level, zero) / (level * level * width2);
    const vf r2 = tangent2 / (level * level * level * width2), d = one + off2 - r2, s = vf_sqrt(d * d + vf_set(4) * r2);
    const vf z = one + off2 + r2, form = r2 * vf_max(s + z - vf_set(2) * off2, zero) / (s * (s + z));
    return form * vf_clamp01((c + sine) / (vf_set(2) * sine));
}

void DAFT_KERNEL(daft_area_gleam)(const daft_batch *batch, uint32_t i, const daft_light_source *source,
                                  const vf *width2, vf *form)
{
    const vf3 p = lanes_load(&batch->point, i), n = lanes_load(&batch->normal, i), view = lanes_load(&batch->view, i);
    const vf3 axis = difference(scaled(n, vf_set(2) * vf3_dot(n, view)), view);
    if (source->area == DAFT_AREA_SPHERE) {
        *form = sphere_gleam(source, difference(spread(source->position), p), axis, *width2);
        return;
    }
    const vf3 corner = corner_from(source, p), u = spread(source->edges[0]), v = spread(source->edges[1]);
    const vf narrow = vf_set(1) / vf_sqrt(*width2), zero = vf_set(0);
    vf3 a, b;
    axes_across(axis, &a, &b);
    a = scaled(a, narrow), b = scaled(b, narrow);
    *form = parallelogram((vf3){vf3_dot(a, corner), vf3_dot(b, corner), vf3_dot(axis, corner)},
                          (vf3){vf3_dot(a, u), vf3_dot(b, u), vf3_dot(axis, u)},
                          (vf3){vf3_dot(a, v), vf3_dot(b, v), vf3_dot(axis, v)}, (vf3){zero, zero, vf_set(1)});
}
