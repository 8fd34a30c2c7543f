/* Triangles that may hide points from a light, DAFT_VL at a time: moved to view space, their boxes in the picture, the
 * planes of their edges and their own. See mesh_kernel.c for the test. */
#ifndef DAFT_OCCLUDER_H
#define DAFT_OCCLUDER_H

#include "raster/samples/samples.h"

/* A mesh on its way through its tree. */
typedef struct mesh_occluder {
    occluder c;
    float size;              /* of the map's translation: what corners may lose beside their own coordinates */
    bool before;             /* all of the mesh lies well before the light: */
    float off_uv, off_depth; /* then places in the picture, and depths, are off by less than this */
    picture_map map;         /* object space to view space */
    daft_affine back;        /* and the way back, to where they stand */
    float pad[3];            /* there: what boxes must be larger by, along each axis, for points' rays to meet them */
} mesh_occluder;

void DAFT_KERNEL(daft_mesh_occluder_make)(const occluder *c, mesh_occluder *out);
/* Puts the points to depth -inf that triangles of the mesh hide. Points go there one by one, so this is for few. */
void DAFT_KERNEL(daft_few_shadow)(const mesh_occluder *m, const block_points *points, uint32_t count);
/* Points that a triangle with alpha may hide, by their bits in `side`, `e` being their rays' edges: those that it
 * surely hides go to depth -inf. Gives whether there are any. */
typedef struct triangle_edges triangle_edges;
typedef struct lanes lanes;
bool DAFT_KERNEL(daft_filter_points)(const mesh_occluder *m, const lanes *t, int lane, const triangle_edges *e,
                                     vbits side, uint32_t first);
/* Whether the triangle, closed, stands between the point and the light, by frame space's own numbers. */
bool DAFT_KERNEL(daft_stands_between)(const occluder *c, const daft_block *block, int lane, uint32_t point);

/* Leaf blocks, waiting to be tested against the points behind their leaf's box: blocks of them, or few one by one. */
typedef struct leaf {
    const daft_block *block;
    block_set behind;
} leaf;

/* What comes from far is on its way before it is needed. */
DAFT_INLINE void fetch_lines(const void *from, size_t size)
{
    for (size_t line = 0; line < size; line += 64) __builtin_prefetch((const char *)from + line);
}

DAFT_INLINE void fetch_leaf(const daft_bvh *bvh, uint32_t child)
{
    fetch_lines(&bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2], ((child & 3) + 1) * sizeof *bvh->blocks);
}

DAFT_INLINE uint32_t list_leaf(const daft_bvh *bvh, uint32_t child, const block_set *behind, leaf *list, uint32_t count)
{
    const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    for (uint32_t k = 0; k <= (child & 3); k++) list[count++] = (leaf){&block[k], *behind};
    return count;
}

DAFT_INLINE void fetch_node(const daft_bvh *bvh, uint32_t child)
{
    fetch_lines(&bvh->nodes.items[child], sizeof(daft_node));
}

/* The blocks of leaves in a register. */
DAFT_INLINE void blocks_of(const leaf *const *leaves, const daft_block *out[DAFT_BATCH_BLOCKS])
{
    for (int i = 0; i < DAFT_BATCH_BLOCKS; i++) out[i] = leaves[i]->block;
}

/* One over a direction along an axis: finite, so that products with it are numbers. */
DAFT_INLINE vf inverse_of(vf direction) { return vf_max(vf_min(vf_set(1) / direction, vf_set(1e30f)), vf_set(-1e30f)); }

/* Triangles set up: edges' planes, corners' depths, their boxes in the picture, and their own planes: the light is on
 * the side where a point's product with `plane` is less than `surface`. */
struct lanes {
    float nx[3][DAFT_VL], ny[3][DAFT_VL], nz[3][DAFT_VL], depth[3][DAFT_VL];
    float plane[3][DAFT_VL], surface[DAFT_VL];
    float bound[DAFT_VL], wide[DAFT_VL], slack[DAFT_VL], rounding[DAFT_VL];
    float turned[DAFT_VL]; /* six times the volume to the light, of either sign; 0: not surely either */
    float apart[DAFT_VL];  /* edges further off than this are so to rays in other spaces, too */
    float low_u[DAFT_VL], high_u[DAFT_VL], low_v[DAFT_VL], high_v[DAFT_VL], near[DAFT_VL];
    uint32_t triangle[DAFT_VL];
};

/* A triangle's edges at some points' rays. */
struct triangle_edges {
    vf e0, e1, e2, min, max;
};

DAFT_INLINE view_corners corners_move(const mesh_occluder *c, const leaf *const *leaves)
{
    const daft_block *blocks[DAFT_BATCH_BLOCKS];
    blocks_of(leaves, blocks);
    return blocks_move(&c->c.view->pencil, false, &c->map.map, blocks);
}

/* The triangles that lie on the outer side of x = limit·z (axis 0) or y = limit·z (axis 1), `side` being -1 or 1, and
 * whose corners are off by `off`. This says something, too, of those that reach beside or behind the light. */
DAFT_INLINE vm corners_beyond(const view_corners *t, int axis, float limit, float side, vf off)
{
    vf min = vf_set(INFINITY), slope = vf_set(limit);
    for (int k = 0; k < 3; k++) min = vf_min(((axis ? t->p[k].y : t->p[k].x) - slope * t->p[k].z) * vf_set(side), min);
    return vf_lt(off * vf_set(1 + fabsf(limit)), min);
}

DAFT_INLINE vm corners_outside(const light_view *l, const view_corners *t, vf off)
{
    return vm_or(vm_or(corners_beyond(t, 0, l->high_u + l->slack_u, 1, off),
                       corners_beyond(t, 0, l->low_u - l->slack_u, -1, off)),
                 vm_or(corners_beyond(t, 1, l->high_v + l->slack_v, 1, off),
                       corners_beyond(t, 1, l->low_v - l->slack_v, -1, off)));
}

/* 1/z to 2^-21: boxes are wider than that, and nothing else comes of it. */
DAFT_INLINE vf box_reciprocal(vf z)
{
    vf rough = vf_approximate_reciprocal(z);
    return rough * (vf_set(2) - z * rough);
}

/* How much larger than their corners say triangles' boxes are in the picture; and those that reach beside or behind the
 * light, which are before all of it. */
typedef struct box_error {
    vf uv, depth;
    vm whole;
} box_error;

/* Of meshes that are near the light: from the corners themselves. */
DAFT_INLINE box_error near_apex_error(const mesh_occluder *c, const view_corners *t, vf near, vf reach)
{
    const light_view *l = c->c.view;
    vf size = vf_set(c->size), unit = vf_set(0x1p-20f); /* corners are off by a few 2^-24 of it */
    for (int k = 0; k < 3; k++) size = vf_max(vf_abs(t->p[k].x) + vf_abs(t->p[k].y) + vf_abs(t->depth[k]), size);
    box_error out = {.depth = size * unit, .whole = vm_from_bits(0)};
    out.uv = out.depth;
    if (l->pencil.parallel) return out;
    out.uv = (size / (near - vf_set(-l->pencil.away)) + reach) * unit;
    out.whole = vf_le(near - out.depth, vf_set(-l->pencil.away + l->pencil.away * 0x1p-20f));
    return out;
}

DAFT_INLINE vf most_reach(vf low_u, vf high_u, vf low_v, vf high_v)
{
    return vf_max(vf_max(vf_abs(low_u), vf_abs(high_u)), vf_max(vf_abs(low_v), vf_abs(high_v)));
}

/* Sets the triangles' boxes. */
DAFT_INLINE void lanes_place(const mesh_occluder *c, const view_corners *t, lanes *out)
{
    const light_view *l = c->c.view;
    view_extent e = extent_empty();
    for (int k = 0; k < 3; k++) extent_add(&e, &t->p[k], l->pencil.parallel ? vf_set(1) : box_reciprocal(t->p[k].z));
    vf inf = vf_set(INFINITY), lu = e.low_x, hu = e.high_x, lv = e.low_y, hv = e.high_y, near = nearest_depth(t);
    box_error error = {vf_set(c->off_uv), vf_set(c->off_depth), vm_from_bits(0)};
    if (!c->before) error = near_apex_error(c, t, near, most_reach(lu, hu, lv, hv));
    vf off_u = error.uv + vf_set(l->slack_u), off_v = error.uv + vf_set(l->slack_v);
    lu = lu - off_u, hu = hu + off_u, lv = lv - off_v, hv = hv + off_v;
    if (!c->before) {
        lu = vf_if_then_else(error.whole, -inf, lu), hu = vf_if_then_else(error.whole, inf, hu);
        lv = vf_if_then_else(error.whole, -inf, lv), hv = vf_if_then_else(error.whole, inf, hv);
    }
    near = near - error.depth - vf_set((fabsf(l->near) + fabsf(l->far)) * 0x1p-20f);
    vf_store(out->low_u, lu), vf_store(out->high_u, hu), vf_store(out->low_v, lv), vf_store(out->high_v, hv);
    vf_store(out->near, near);
}

/* The bits of the triangles that may meet the points' extent. */
static inline vbits lanes_met(const mesh_occluder *c, const view_corners *t, const lanes *at)
{
    const light_view *l = c->c.view;
    vf lu = vf_load(at->low_u), hu = vf_load(at->high_u), lv = vf_load(at->low_v), hv = vf_load(at->high_v);
    vm in = vm_and(vm_and(vf_le(vf_set(l->low_u), hu), vf_le(lu, vf_set(l->high_u))),
                   vm_and(vf_le(vf_set(l->low_v), hv), vf_le(lv, vf_set(l->high_v))));
    in = vm_and(in, vf_le(vf_load(at->near), vf_set(l->far)));
    if (l->pencil.parallel) return vbits_from_mask(in);
    const vf near = nearest_depth(t), far = farthest_depth(t), end = vf_set(l->end - l->pencil.away * 0x1p-20f);
    if (c->before) return vbits_from_mask(vm_and(in, vf_lt(end, far + vf_set(c->off_depth))));
    box_error error = near_apex_error(c, t, near, vf_set(0));
    in = vm_and(in, vf_lt(end, far + error.depth));
    vm whole = vm_and(in, error.whole);
    if (!vbits_from_mask(whole)) return vbits_from_mask(in);
    return vbits_from_mask(
        vm_and(in, vm_not(vm_and(whole, corners_outside(l, t, error.depth + vf_set(l->pencil.away * 0x1p-20f))))));
}

/* Sets the triangles' numbers; gives the bits of those that are there, `count` blocks being real. */
DAFT_INLINE vbits lanes_name(const leaf *const *leaves, uint32_t count, lanes *out)
{
    const daft_block *blocks[DAFT_BATCH_BLOCKS];
    blocks_of(leaves, blocks);
    vi triangle = blocks_triangles(blocks);
    vi_store(out->triangle, triangle);
    return vbits_first_n((int)daft_min_u(count, DAFT_VL / DAFT_BLOCK) * DAFT_BLOCK) &
           ~vbits_from_mask(vi_eq(triangle, vi_set((int32_t)DAFT_NO_TRIANGLE)));
}

DAFT_INLINE vf reach_of(vf3 a) { return vf_abs(a.x) + vf_abs(a.y) + vf_abs(a.z); }

/* The triangles' planes in view space, for passing over points that are surely before them. With u = 2^-24: points and
 * corners are off by 8u of `size`, and the plane through corners that are off is so, too; the product of edges is off
 * by 10u·|e|·|f|. Where the light is within that of the plane, nothing is sure. */
static inline void lanes_planes(const light_view *l, const view_corners *t, vf size, lanes *out)
{
    vf3 a = {t->p[0].x, t->p[0].y, t->depth[0]};
    vf3 e = {t->p[1].x - a.x, t->p[1].y - a.y, t->depth[1] - a.z},
        f = {t->p[2].x - a.x, t->p[2].y - a.y, t->depth[2] - a.z};
    const vf3 n = plane_of(e, f).n;
    vf edges = reach_of(e) + reach_of(f), across = reach_of(n), at = vf3_dot(n, a),
       wrong = edges * edges * vf_set(16 * UNIT);
    vf light = l->pencil.parallel ? n.z : at + n.z * vf_set(l->pencil.away), off = wrong,
       far = size + vf_set(l->pencil.away);
    if (!l->pencil.parallel) off = off * far + across * far * vf_set(32 * UNIT);
    vm sure = vf_lt(off, vf_abs(light));
    vi sign = (vi)light & vi_set((int32_t)0x80000000);
    vf_store(out->plane[0], vf_xor(n.x, sign)), vf_store(out->plane[1], vf_xor(n.y, sign));
    vf_store(out->plane[2], vf_xor(n.z, sign));
    vf surface = vf_xor(at, sign) - (across * size * vf_set(32 * UNIT) + wrong * edges);
    vf_store(out->turned, vf_if_then_else(sure, light, vf_set(0)));
    vf_store(out->surface, vf_if_then_else(sure, surface, vf_set(-INFINITY)));
}

/* `planes`: the triangles' own are asked for as well. */
DAFT_INLINE void lanes_setup(const mesh_occluder *c, const view_corners *t, bool planes, lanes *out)
{
    const light_view *l = c->c.view;
    vf bound = vf_set(0), across = vf_set(0), along = vf_set(0), size = vf_set(c->size);
    vf dx = vf_set(l->max_x), dy = vf_set(l->max_y), dz = vf_set(l->max_z);
    for (int k = 0; k < 3; k++) {
        const plane e = edge_plane(t, k, l->pencil.parallel);
        vf m = plane_size(&e, dx, dy, dz);
        vf_store(out->nx[k], e.n.x), vf_store(out->ny[k], e.n.y), vf_store(out->nz[k], e.n.z);
        vf_store(out->depth[k], t->depth[k]);
        bound = vf_max(bound, m), across = vf_max(across, vf_abs(e.n.x) + vf_abs(e.n.y)),
        along = vf_max(along, vf_abs(e.n.z));
        size = vf_max(size, vf_abs(t->p[k].x) + vf_abs(t->p[k].y) + vf_abs(t->depth[k]));
    }
    bound = bound * vf_set(10 * UNIT) + vf_set(TINY); /* of which 2: z is rounded where the light's distance is added */
    /* Points and corners are rounded themselves. Neighbours agree on how, so this matters only for not passing over
     * what look_closely would find to stand between. */
    size = size + vf_set(l->size);
    if (planes) lanes_planes(l, t, size, out);
    vf wide = across * size;
    if (!l->pencil.parallel) wide = wide + along * (size + vf_set(2 * l->max_z));
    wide = bound + wide * vf_set(8 * UNIT);
    vf_store(out->bound, bound);
    vf_store(out->wide, wide);
    vf_store(out->apart, vf_set(2) * wide + across * vf_set(l->reach * 16 * UNIT));
    vf_store(out->slack, vf_set(6) * wide * (farthest_depth(t) - nearest_depth(t)));
    vf_store(out->rounding, size * vf_set(0x1p-20f));
}

#endif
