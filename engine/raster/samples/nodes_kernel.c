/* Boxes of a tree's nodes in the light's picture. The box's middle is projected, then how far the box reaches beside
 * the ray through it: as tight as the hull of its corners but for the box's depth over its distance, at a third of the
 * cost. */
#include "raster/samples/samples.h"

DAFT_INLINE v8 v8_abs(v8 a) { return (v8)((v8i)a & 0x7fffffff); }

typedef struct v8_box {
    v8 centre[3], half[3]; /* view space; half its extent along object axes */
    v8 reach, off;         /* half its extent in depth; a bound of the rounding of view space's coordinates */
} v8_box;

DAFT_INLINE v8_box box_move(const picture_map *map, const daft_node *node)
{
    v8_box box;
    v8 scale = v8_set(0.5f), size = v8_set(map->still);
    for (int k = 0; k < 3; k++) box.centre[k] = v8_set(map->map.t[k]);
    box.reach = v8_set(0);
    for (int j = 0; j < 3; j++) {
        v8 low = v8_load(node->bounds[j]), high = v8_load(node->bounds[3 + j]), c = (low + high) * scale,
           h = (high - low) * scale;
        box.half[j] = h;
        box.reach = box.reach + v8_set(fabsf(map->map.m[6 + j])) * h;
        for (int k = 0; k < 3; k++) box.centre[k] = box.centre[k] + v8_set(map->map.m[3 * k + j]) * c;
        size = size + v8_set(map->reach[j]) * (v8_abs(c) + h);
    }
    box.off = size * v8_set(0x1p-20f);
    return box;
}

/* How far the box reaches beside the rays x = slope·z (axis 0) or y = slope·z (axis 1) through its middle. */
DAFT_INLINE v8 reach_beside(const v8_box *b, const daft_affine *map, int axis, v8 slope)
{
    v8 half = v8_set(0);
    for (int j = 0; j < 3; j++)
        half = half + v8_abs(v8_set(map->m[3 * axis + j]) - slope * v8_set(map->m[6 + j])) * b->half[j];
    return half;
}

/* Bits of the boxes that lie on the outer side of x = limit·z (axis 0) or y = limit·z (axis 1), `side` being -1 or 1.
 * This says something, too, of boxes that reach beside or behind the light. */
DAFT_INLINE uint32_t beyond_side(const v8_box *b, const picture_map *map, float away, int axis, float limit, float side)
{
    v8 slope = v8_set(limit), middle = (b->centre[axis] - slope * (b->centre[2] + v8_set(away))) * v8_set(side);
    v8 half = b->off * v8_set(1 + fabsf(limit)) + v8_set(away * fabsf(limit) * 0x1p-22f);
    return ~v8_le_bits(middle, half + reach_beside(b, &map->map, axis, slope));
}

static uint32_t beyond_sides(const light_view *l, const v8_box *b, const picture_map *map)
{
    return beyond_side(b, map, l->pencil.away, 0, l->high_u + l->slack_u, 1) |
           beyond_side(b, map, l->pencil.away, 0, l->low_u - l->slack_u, -1) |
           beyond_side(b, map, l->pencil.away, 1, l->high_v + l->slack_v, 1) |
           beyond_side(b, map, l->pencil.away, 1, l->low_v - l->slack_v, -1);
}

typedef struct v8_range {
    v8 low, high;
} v8_range;

/* A point light's picture of boxes before it, along an axis across the light. `inverse`: one over the distance of the
 * box's middle, `most` over that of its near side. With u = c/z of the middle, a point that is dx and dz from there is
 * seen (dx - u·dz)/(z + dz) beside it. Coordinates are off by `off`, distances by that and `rounding`. */
DAFT_INLINE v8_range project_axis(const v8_box *b, const picture_map *map, int axis, v8 inverse, v8 max, v8 rounding)
{
    v8 middle = b->centre[axis] * inverse;
    v8 half = reach_beside(b, &map->map, axis, middle) * max;
    half = half + (b->off + (v8_abs(middle) + half) * (b->off + rounding)) * max;
    return (v8_range){middle - half, middle + half};
}

DAFT_INLINE v8_range sun_axis(const v8_box *b, const picture_map *map, int axis)
{
    v8 half = reach_beside(b, &map->map, axis, v8_set(0)) + b->off;
    return (v8_range){b->centre[axis] - half, b->centre[axis] + half};
}

uint32_t DAFT_KERNEL(daft_node_project)(const light_view *l, const picture_map *map, const daft_node *node,
                                        node_boxes *out)
{
    v8_box box = box_move(map, node);
    box.off = box.off + v8_set((fabsf(l->near) + fabsf(l->far)) * 0x1p-20f);
    v8 near = box.centre[2] - box.reach - box.off, far = box.centre[2] + box.reach + box.off;
    v8_range u, v;
    uint32_t in = v8_le_bits(near, v8_set(l->far)), beside = 0, everywhere = 0;
    if (l->pencil.parallel) {
        u = sun_axis(&box, map, 0), v = sun_axis(&box, map, 1);
    } else {
        const v8 one = v8_set(1), light = v8_set(-l->pencil.away), rounding = v8_set(l->pencil.away * 0x1p-22f);
        in &= v8_le_bits(light, far + rounding);
        beside = v8_le_bits(near - rounding, light);
        everywhere = in & beside; /* it reaches beside or behind the light */
        if (everywhere) everywhere &= ~beyond_sides(l, &box, map);
        v8 inverse = one / (box.centre[2] - light), max = one / (near - light);
        u = project_axis(&box, map, 0, inverse, max, rounding), v = project_axis(&box, map, 1, inverse, max, rounding);
    }
    u.low = u.low - v8_set(l->slack_u), u.high = u.high + v8_set(l->slack_u);
    v.low = v.low - v8_set(l->slack_v), v.high = v.high + v8_set(l->slack_v);
    uint32_t meet = v8_le_bits(u.low, v8_set(l->high_u)) & v8_le_bits(v8_set(l->low_u), u.high) &
                    v8_le_bits(v.low, v8_set(l->high_v)) & v8_le_bits(v8_set(l->low_v), v.high);
    in &= (meet & ~beside) | everywhere;
    v8_store(out->low_u, u.low), v8_store(out->high_u, u.high);
    v8_store(out->low_v, v.low), v8_store(out->high_v, v.high);
    v8_store(out->near, near);
    for (; everywhere; everywhere &= everywhere - 1) {
        int i = __builtin_ctz(everywhere);
        out->low_u[i] = out->low_v[i] = -INFINITY, out->high_u[i] = out->high_v[i] = INFINITY;
    }
    return in;
}
