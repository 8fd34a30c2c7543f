/* raster/samples: the points of a tile that ask for one light, against what may hide it. The shadow rays share the
 * light, so seen from there they are a pencil, and the points are its picture.
 *
 *     occlusion_kernel.c  the order of work: which instances may stand between, then each of them; the kernel table
 *     shaft_kernel.c      occluders against all of the points at once: nothing stands between, or one triangle hides
 * all blocks_kernel.c     points into blocks of 16 neighbours, whose boxes in the picture are what occluders are looked
 *                         up in
 *     nodes_kernel.c      boxes of a tree's nodes, seen from the light
 *     mesh_kernel.c       a mesh's tree down to the triangles before lit blocks, and these against the blocks: lanes
 *                         are points
 *     few_kernel.c        the same for a mesh over few points: each a ray in the mesh's own space, lanes are nodes and
 *                         triangles
 *     map_kernel.c        a mesh's map to view space and back, with its errors
 *     setup.h             triangles moved, their boxes, planes of edges, their own planes
 *     sphere_kernel.c     spheres
 *     filter_kernel.c     triangles with alpha: what of them is known before blocks
 *
 * Public headers: samples.h */
#ifndef DAFT_SAMPLES_H
#define DAFT_SAMPLES_H

#include "math/simd/dispatch.h"
#include "raster/raster.h"
#include "raster/boxes.h"

enum {
    SHADOW_BLOCK = 16,                                /* points in a block, whatever the instruction set */
    SHADOW_TILE_BLOCKS = DAFT_SAMPLES / SHADOW_BLOCK, /* squares of 4 by 4 pixels in a tile */
    SHADOW_BLOCKS = 2 * SHADOW_TILE_BLOCKS,           /* each square begins a block, and so does what is left of them */
    SHADOW_LANES = SHADOW_BLOCKS * SHADOW_BLOCK,
    SHADOW_GROUP = 16, /* blocks that are looked at together, whatever the instruction set */
    SHADOW_FEW = 16    /* up to so many are looked at one by one */
};

/* A light's view of some points. The pencil's origin is in their middle, so coordinates are as precise as the points
 * are however far the light is; x and y are across the light, the depth d along it. A point's ray is (x, y, d + away)
 * or, of a parallel pencil, (x, y, 1). u = x/z and v = y/z are the picture's coordinates. */
typedef struct light_view {
    daft_pencil pencil;
    float low_u, low_v, high_u, high_v; /* of the points */
    float slack_u, slack_v;             /* over the rounding of projected coordinates */
    float near, far;                    /* depths of the points */
    float max_x, max_y, max_z;          /* magnitudes of the rays' components */
    float size;                         /* largest |x|, |y| and |d|, added up */
    float reach;                        /* no less than |x| + |y| + |z| of any point, in frame space */
    const daft_apex *light;
    float end; /* no point's ray goes on beyond this depth */
} light_view;

/* A box in a light's picture, from a depth on. */
typedef struct picture_box {
    float low_u, high_u, low_v, high_v, near;
} picture_box;

/* Points in blocks of neighbours, which a triangle is tested against together; each block's box in the picture, and
 * each group's. */
typedef struct shadow_points {
    float min_end;        /* of `end` below */
    uint32_t count, live; /* blocks, and those with a lit point; the boxes of the others are empty */
    uint32_t used[SHADOW_BLOCKS], under[SHADOW_BLOCKS]; /* bits: of points; of those that lie behind some instance's box
                                                         */
    uint32_t on[SHADOW_BLOCKS], sole[SHADOW_BLOCKS]; /* the instance and the own triangle of all of a block's points; or
                                                      * DAFT_NOTHING, DAFT_NO_TRIANGLE */
    _Alignas(64) float low_u[SHADOW_BLOCKS], high_u[SHADOW_BLOCKS], low_v[SHADOW_BLOCKS], high_v[SHADOW_BLOCKS];
    _Alignas(64) float far[SHADOW_BLOCKS];
    _Alignas(64) float u[SHADOW_LANES], v[SHADOW_LANES];
    _Alignas(64) float x[SHADOW_LANES], y[SHADOW_LANES], z[SHADOW_LANES];
    _Alignas(64) float depth[SHADOW_LANES]; /* -inf: in shadow, or no point */
    _Alignas(64) float end[SHADOW_LANES];   /* the depth at which the ray ends before the light */
    _Alignas(64) uint32_t source[SHADOW_LANES], instance[SHADOW_LANES];
    _Alignas(64) uint32_t own[SHADOW_LANES]; /* the triangle that the point lies on and that cannot shadow it, or
                                              * DAFT_NO_TRIANGLE */
} shadow_points;

/* A map to view space, the same for boxes of nodes, and what bounds the rounding of what it moves: the sum of its
 * translation's magnitudes, and that with the largest that the rest of the map adds. */
typedef struct picture_map {
    daft_affine map;
    node_map nodes;
    float still, size;
} picture_map;

/* `max`: of the coordinates that are moved, by axes. */
DAFT_INLINE picture_map picture_map_make(const light_view *l, const daft_affine *map, const float max[3])
{
    picture_map out = {.map = *map, .still = fabsf(map->t[0]) + fabsf(map->t[1]) + fabsf(map->t[2])};
    out.size = out.still;
    for (int j = 0; j < 3; j++) out.size += (fabsf(map->m[j]) + fabsf(map->m[3 + j]) + fabsf(map->m[6 + j])) * max[j];
    const float pad = (out.size + fabsf(l->near) + fabsf(l->far)) * 0x1p-20f;
    node_map_make(&out.nodes, map->m, map->t, (const float[3]){pad, pad, pad});
    return out;
}

/* Frame space to view space, for a tree with this root. */
DAFT_INLINE picture_map view_map_of(const light_view *l, const daft_node *root)
{
    const daft_affine same = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}}, map = daft_pencil_map(&l->pencil, &same);
    float max[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < DAFT_WIDTH; i++) max[k] = fmaxf(max[k], fmaxf(-root->bounds[k][i], root->bounds[3 + k][i]));
    return picture_map_make(l, &map, max);
}

/* Boxes of a node's children; room for a register. */
enum { NODE_LANES = DAFT_VL > DAFT_WIDTH ? DAFT_VL : DAFT_WIDTH };
typedef struct node_boxes {
    float low_u[NODE_LANES], high_u[NODE_LANES], low_v[NODE_LANES], high_v[NODE_LANES], near[NODE_LANES];
} node_boxes;

DAFT_INLINE picture_box node_child(const node_boxes *b, int i)
{
    return (picture_box){b->low_u[i], b->high_u[i], b->low_v[i], b->high_v[i], b->near[i]};
}

/* A set of blocks, by bits; the groups are its 16-bit parts. */
typedef struct block_set {
    uint64_t bits[SHADOW_BLOCKS / 64];
} block_set;

DAFT_INLINE bool set_is_empty(const block_set *s) { return (s->bits[0] | s->bits[1]) == 0; }
DAFT_INLINE uint32_t set_count(const block_set *s)
{
    return (uint32_t)(__builtin_popcountll(s->bits[0]) + __builtin_popcountll(s->bits[1]));
}

/* Some of a block's points, by bits. */
typedef struct block_points {
    uint32_t block, points;
} block_points;

/* Which blocks of a group lie, in part, behind the box. */
DAFT_INLINE uint32_t blocks_behind(const picture_box *box, const shadow_points *p, uint32_t group)
{
    uint32_t in = 0;
    for (uint32_t k = 0; k < SHADOW_GROUP; k += DAFT_VL) {
        uint32_t b = group * SHADOW_GROUP + k;
        vm u = vm_and(vf_le(vf_set(box->low_u), vf_load(&p->high_u[b])),
                      vf_le(vf_load(&p->low_u[b]), vf_set(box->high_u)));
        vm v = vm_and(vf_le(vf_set(box->low_v), vf_load(&p->high_v[b])),
                      vf_le(vf_load(&p->low_v[b]), vf_set(box->high_v)));
        in |= vbits_from_mask(vm_and(vm_and(u, v), vf_le(vf_set(box->near), vf_load(&p->far[b])))) << k;
    }
    return in;
}

/* The bits of the block's lit points that lie behind the box. */
DAFT_INLINE uint32_t points_behind(const picture_box *box, const shadow_points *p, uint32_t b)
{
    uint32_t all = 0;
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
        uint32_t at = b * SHADOW_BLOCK + k;
        vf u = vf_load(&p->u[at]), v = vf_load(&p->v[at]);
        vm in = vm_and(vm_and(vf_le(vf_set(box->low_u), u), vf_le(u, vf_set(box->high_u))),
                       vm_and(vf_le(vf_set(box->low_v), v), vf_le(v, vf_set(box->high_v))));
        all |= vbits_from_mask(vm_and(in, vf_le(vf_set(box->near), vf_load(&p->depth[at])))) << k;
    }
    return all;
}

DAFT_INLINE uint32_t lit_points(const shadow_points *p, uint32_t b)
{
    uint32_t lit = 0;
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL)
        lit |= vbits_from_mask(vf_lt(vf_set(-INFINITY), vf_load(&p->depth[b * SHADOW_BLOCK + k]))) << k;
    return lit;
}

/* Which of a node's children lie, in part, before the block. */
DAFT_INLINE uint32_t children_before(const node_boxes *n, const shadow_points *p, uint32_t b)
{
    return v8_le_bits(v8_load(n->low_u), v8_set(p->high_u[b])) & v8_le_bits(v8_set(p->low_u[b]), v8_load(n->high_u)) &
           v8_le_bits(v8_load(n->low_v), v8_set(p->high_v[b])) & v8_le_bits(v8_set(p->low_v[b]), v8_load(n->high_v)) &
           v8_le_bits(v8_load(n->near), v8_set(p->far[b]));
}

/* The blocks of `in`, bits of a group, that have a lit point behind the box, as far as that is quickly known. */
DAFT_INLINE uint32_t group_narrow(const picture_box *box, const shadow_points *p, uint32_t group, uint32_t in)
{
    in &= blocks_behind(box, p, group);
    if (__builtin_popcount(in) > SHADOW_GROUP / 4) return in;
    for (uint32_t each = in; each; each &= each - 1)
        if (!points_behind(box, p, group * SHADOW_GROUP + (uint32_t)__builtin_ctz(each))) in &= ~(each & -each);
    return in;
}

DAFT_INLINE bool blocks_narrow(const picture_box *box, const shadow_points *p, const block_set *from, block_set *to)
{
    *to = (block_set){{0}};
    for (uint32_t group = 0; group * SHADOW_GROUP < p->count; group++) {
        uint32_t word = group / 4, shift = group % 4 * SHADOW_GROUP, in = from->bits[word] >> shift & 0xffff;
        if (in) to->bits[word] |= (uint64_t)group_narrow(box, p, group, in) << shift;
    }
    return !set_is_empty(to);
}

/* Of many blocks: each child is met by a group's at once, and their points are not asked. */
DAFT_INLINE void children_narrow_many(const node_boxes *n, uint32_t children, const shadow_points *p,
                                      const block_set *from, block_set to[DAFT_WIDTH])
{
    for (uint32_t group = 0; group * SHADOW_GROUP < p->count; group++) {
        uint32_t word = group / 4, shift = group % 4 * SHADOW_GROUP, in = from->bits[word] >> shift & 0xffff;
        if (!in) continue;
        for (uint32_t left = children; left; left &= left - 1) {
            int i = __builtin_ctz(left);
            picture_box box = node_child(n, i);
            to[i].bits[word] |= (uint64_t)(blocks_behind(&box, p, group) & in) << shift;
        }
    }
}

/* Of few: each block is met by all children; then the points of those that met are asked, pair by pair. No branch hangs
 * on what comes out. */
DAFT_INLINE void children_narrow_few(const node_boxes *n, uint32_t children, const shadow_points *p,
                                     const block_set *from, block_set to[DAFT_WIDTH])
{
    uint32_t pair[SHADOW_FEW * DAFT_WIDTH + DAFT_WIDTH], pairs = 0;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(from->bits); word++)
        for (uint64_t left = from->bits[word]; left; left &= left - 1) {
            uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left), met = children_before(n, p, b) & children;
            pairs += v8i_store_set_bits(&pair[pairs], met, (int32_t)(b * DAFT_WIDTH));
        }
    for (uint32_t k = 0; k < pairs; k++) {
        uint32_t b = pair[k] / DAFT_WIDTH, i = pair[k] % DAFT_WIDTH;
        picture_box box = node_child(n, (int)i);
        to[i].bits[b / 64] |= (uint64_t)(points_behind(&box, p, b) != 0) << (b % 64);
    }
}

/* The same for those children of a node whose bits are in `children`; gives the bits of those that have any. */
DAFT_INLINE uint32_t children_narrow(const node_boxes *n, uint32_t children, const shadow_points *p,
                                     const block_set *from, block_set to[DAFT_WIDTH])
{
    uint32_t any = 0;
    for (int i = 0; i < DAFT_WIDTH; i++) to[i] = (block_set){{0}};
    if (set_count(from) <= SHADOW_FEW)
        children_narrow_few(n, children, p, from, to);
    else
        children_narrow_many(n, children, p, from, to);
    for (int i = 0; i < DAFT_WIDTH; i++) any |= (uint32_t)!set_is_empty(&to[i]) << i;
    return any;
}

/* A mesh of no thickness: none of its triangles hides those of its points from a light that face it. */
DAFT_INLINE bool is_flat(const daft_instance *s)
{
    if (!s->mesh) return false;
    daft_vec3 size = daft_sub(s->mesh->high, s->mesh->low);
    return size.x == 0 || size.y == 0 || size.z == 0;
}

/* Points are moved by differences, so that far from the frame's origin as much of their precision is left as they have.
 */
DAFT_INLINE vf3 to_view_space(const daft_pencil *view, vf3 p)
{
    vf3 d = {p.x - vf_set(view->origin.x), p.y - vf_set(view->origin.y), p.z - vf_set(view->origin.z)};
    const daft_vec3 r = view->right, u = view->up, f = view->forward;
    return (vf3){vf_set(r.x) * d.x + vf_set(r.y) * d.y + vf_set(r.z) * d.z,
                 vf_set(u.x) * d.x + vf_set(u.y) * d.y + vf_set(u.z) * d.z,
                 vf_set(f.x) * d.x + vf_set(f.y) * d.y + vf_set(f.z) * d.z};
}

/* Where in the picture a point of view space is, and the z of its ray. */
typedef struct picture_place {
    vf u, v, z;
} picture_place;

DAFT_INLINE picture_place picture_of(const light_view *l, vf3 p)
{
    if (l->pencil.parallel) return (picture_place){p.x, p.y, vf_set(1)};
    vf z = p.z + vf_set(l->pencil.away), inverse = vf_set(1) / z;
    return (picture_place){p.x * inverse, p.y * inverse, z};
}

/* ---- what blocks_kernel.c works with ---- */

/* Where each block's points are among the samples. */
typedef struct places {
    uint32_t count;
    bool rows;                    /* four and four of a block's places follow each other */
    uint32_t used[SHADOW_BLOCKS]; /* bits */
    uint32_t at[SHADOW_LANES];
} places;

/* The kept points, one after the other. */
typedef struct kept_points {
    uint32_t count;
    uint32_t index[DAFT_SAMPLES_ROOM + DAFT_VL], square[DAFT_SAMPLES_ROOM + DAFT_VL];
} kept_points;

enum { PLACE_BITS = 11 }; /* of a point's place among the samples */
_Static_assert(DAFT_SAMPLES_ROOM < 1 << PLACE_BITS, "");

/* Points of squares across a silhouette: Morton code of their place in the picture, 8 bits an axis, above their place
 * in the batch. */
typedef struct strays {
    uint32_t count, jump; /* bits of the code that differ across more than two usual blocks */
    float max;            /* larger blocks are taken apart */
    float low_u, low_v, scale;
    uint32_t key[DAFT_SAMPLES_ROOM];
    uint32_t free_count, free[SHADOW_BLOCKS]; /* blocks that were taken apart */
} strays;

typedef struct block_scratch {
    places places;
    kept_points kept;
    strays strays;
} block_scratch;

/* Puts the points whose bits are in `kept` into blocks. `own`: the triangle that a point lies on and that cannot shadow
 * it, or DAFT_NO_TRIANGLE. `stray`: squares that many times larger than usual are taken apart. */
void DAFT_KERNEL(daft_shadow_blocks)(const light_view *l, const daft_samples *samples, const uint32_t *own,
                                     const uint32_t *kept, float stray, block_scratch *scratch, shadow_points *to);

/* Takes away the bits of the points that went dark. */
void DAFT_KERNEL(daft_shadow_dark)(const shadow_points *p, uint32_t *bits);

/* Projects the children through the map; gives the bits of those that meet the points' extent. */
uint32_t DAFT_KERNEL(daft_node_project)(const light_view *l, const picture_map *map, const daft_node *node,
                                        node_boxes *out);

/* A instance that may hide points from a light. */
typedef struct occluder {
    const light_view *view;
    const daft_apex *light;
    const daft_samples *samples;
    const daft_instance *instance;
    uint32_t number; /* of the instance */
    bool convex, flat;
    shadow_points *points;
    daft_filtered *filtered; /* NULL: it is opaque; else it has alpha, and what is not sure goes there */
} occluder;

/* The lanes whose point lies on this very triangle, or on this convex instance. */
DAFT_INLINE vbits lie_on(const occluder *c, uint32_t triangle, uint32_t first)
{
    vm on = vi_eq(vi_load(&c->points->instance[first]), vi_set((int32_t)c->number));
    if (c->convex) return vbits_from_mask(on);
    vi own = vi_load(&c->points->own[first]);
    if (c->flat) return vbits_from_mask(on) & ~vbits_from_mask(vi_eq(own, vi_set((int32_t)DAFT_NO_TRIANGLE)));
    return vbits_from_mask(on) & vbits_from_mask(vi_eq(own, vi_set((int32_t)triangle)));
}

/* From a point to the light, in double; to an infinite apex one length of its direction away, and counts from there on.
 */
typedef struct shadow_ray {
    daft_dvec3 from, direction;
    double end; /* in lengths of the direction */
} shadow_ray;

/* Where a ray comes into a box, in lengths of its direction; 1: nowhere before. */
DAFT_INLINE double box_enter(const daft_slanted_box *box, daft_dvec3 from, daft_dvec3 direction)
{
    double first = 0, last = 1;
    from = daft_dsub(from, daft_to_double(box->middle));
    for (int k = 0; k < 3; k++) {
        const daft_dvec3 axis = daft_to_double(box->axes[k]);
        const double at = daft_ddot(axis, from), by = daft_ddot(axis, direction);
        if (fabs(at) > 1 && at * by >= 0) return 1;
        if (by == 0) continue;
        const double a = (-1 - at) / by, b = (1 - at) / by;
        first = fmax(first, fmin(a, b)), last = fmin(last, fmax(a, b));
    }
    return first <= last ? first : 1;
}

DAFT_INLINE shadow_ray shadow_ray_of(const daft_samples *p, const daft_apex *light, uint32_t i)
{
    daft_dvec3 from = daft_to_double(daft_v3(p->origin.x[i], p->origin.y[i], p->origin.z[i])),
               to = daft_to_double(light->at);
    if (light->infinite) return (shadow_ray){from, to, INFINITY};
    to = daft_dsub(to, from);
    const double around = light->around > 0 ? (double)light->around / sqrt(daft_ddot(to, to)) : 0;
    const double end = 1 - fmax(around, (double)light->before);
    return (shadow_ray){from, to, light->box ? fmin(end, box_enter(light->box, from, to)) : end};
}

DAFT_INLINE bool on_shadow_ray(const shadow_ray *w, double t) { return t > 0 && t < w->end; }

/* Takes the block out of what is looked at when its last point has gone dark. */
DAFT_INLINE void block_darkened(shadow_points *p, uint32_t b)
{
    vf max = vf_set(-INFINITY);
    for (uint32_t i = 0; i < SHADOW_BLOCK; i += DAFT_VL) max = vf_max(max, vf_load(&p->depth[b * SHADOW_BLOCK + i]));
    if (vbits_from_mask(vf_lt(vf_set(-INFINITY), max)) || p->low_u[b] > p->high_u[b]) return;
    p->low_u[b] = INFINITY, p->high_u[b] = -INFINITY;
    p->live--;
}

/* The point's own ray must tell what it meets. */
DAFT_INLINE void leave_open(const occluder *c, uint32_t source)
{
    c->filtered->open[source / 32] |= (uint32_t)1 << (source % 32);
}

/* Puts the points that the instance hides from the light to depth -inf; only those of the blocks behind its bounds. */
void DAFT_KERNEL(daft_mesh_shadow)(const occluder *c, const block_set *behind);
/* The same, by these blocks of its triangles alone: no other hides any. */
void DAFT_KERNEL(daft_mesh_shadow_by)(const occluder *c, const block_set *behind, const daft_block *const *blocks,
                                      uint32_t count);
/* Marks the lit points of blocks behind the instance's box whose rays to the light meet the bounds of its mesh, and
 * gives those that it may shadow: not its own that cannot be. Gives the number of blocks that have any. */
uint32_t DAFT_KERNEL(daft_mesh_candidates)(const occluder *c, const picture_box *box, const block_set *behind,
                                           block_points *out);
/* daft_mesh_shadow, of these points. */
void DAFT_KERNEL(daft_mesh_shadow_of)(const occluder *c, const block_points *points, uint32_t count);
/* Makes the box as small as a sphere's is. */
void DAFT_KERNEL(daft_sphere_occluder_box)(const light_view *l, const daft_instance *s, picture_box *box);
void DAFT_KERNEL(daft_sphere_occluder_shadow)(const occluder *c, const block_set *behind);

#endif
