/* Boxes of BVH nodes as the light sees them: eight at a time against the extent of the lit points. Comparisons are
 * written so that a NaN, from an overflow, keeps a box. */
#include "raster/samples/samples.h"

DAFT_INLINE vbits outside(vf_range a, float low, float high)
{
    return vbits_from_mask(vf_lt(a.high, vf_set(low))) | vbits_from_mask(vf_lt(vf_set(high), a.low));
}

/* An axis across the light: its picture of boxes, and the lanes of those beside the points' extent low..high. Boxes
 * that reach beside or behind a point light may be anywhere in its picture. */
DAFT_INLINE vbits picture_axis(vf_range at, const node_depths *z, float low, float high, float slack, vf_range *out)
{
    vbits beside = node_beside(at, z, fminf(low - slack, 0), fmaxf(high + slack, 0));
    vf_range over = node_slopes(at, z);
    out->low = vf_if_then_else(z->front, over.low - vf_set(slack), vf_set(-INFINITY));
    out->high = vf_if_then_else(z->front, over.high + vf_set(slack), vf_set(INFINITY));
    return beside | outside(*out, low, high);
}

DAFT_INLINE vbits sun_axis(vf_range at, float low, float high, float slack, vf_range *out)
{
    *out = (vf_range){at.low - vf_set(slack), at.high + vf_set(slack)};
    return outside(*out, low, high);
}

/* The boxes of DAFT_VL nodes across the light, and the lanes of those that no point lies behind. */
DAFT_INLINE vbits picture_boxes(const light_view *l, const node_map *map, const node_pair *n, vf_range depth,
                                vf_range *u, vf_range *v)
{
    const float away = l->pencil.away, rounding = away * 0x1p-22f;
    const vf_range x = node_axis(map, 0, n), y = node_axis(map, 1, n);
    vbits beyond = vbits_from_mask(vf_lt(vf_set(l->far), depth.low));
    if (l->pencil.parallel)
        return beyond | sun_axis(x, l->low_u, l->high_u, l->slack_u, u) |
               sun_axis(y, l->low_v, l->high_v, l->slack_v, v);
    const node_depths z = node_depths_of(depth.low + vf_set(away - rounding), depth.high + vf_set(away + rounding));
    return beyond | vbits_from_mask(vf_lt(z.far, vf_set(fmaxf(l->end + away * (1 - 0x1p-20f), 0)))) |
           picture_axis(x, &z, l->low_u, l->high_u, l->slack_u, u) |
           picture_axis(y, &z, l->low_v, l->high_v, l->slack_v, v);
}

uint32_t DAFT_KERNEL(daft_node_project)(const light_view *l, const picture_map *map, const daft_node *node,
                                        node_boxes *out)
{
    uint32_t in = 0;
    for (int part = 0; part < DAFT_EIGHT_PARTS; part++) {
        const node_pair same = {node, node, part};
        const vf_range depth = node_axis(&map->nodes, 2, &same);
        const int at = part * DAFT_VL;
        vf_range u, v;
        vbits none = picture_boxes(l, &map->nodes, &same, depth, &u, &v);
        vf_store(&out->low_u[at], u.low), vf_store(&out->high_u[at], u.high);
        vf_store(&out->low_v[at], v.low), vf_store(&out->high_v[at], v.high);
        vf_store(&out->near[at], depth.low);
        in |= (uint32_t)(~none & DAFT_ALL_LANES) << at;
    }
    return in & v8_le_bits(v8_load(node->bounds[0]), v8_load(node->bounds[3])); /* not of empty children */
}
