/* Meshes as occluders: the tree is walked with the boxes of its nodes in the light's picture (nodes_kernel.c), down to
 * those that lie before lit points; the triangles found are moved to view space and set up DAFT_VL at a time. Each
 * block of points whose box meets some of them is tested against these: lanes are points. Blocks in which all points
 * are dark are skipped from then on. Of a mesh that few points' rays come near, few_kernel.c takes these one by one:
 * lanes are triangles. This chooses which triangles are tested; it never changes what hides a point.
 *
 * A point is in shadow when no edge has it surely outside and the triangle is surely nearer to the light. Depths are
 * off by some 2^-18 of the distance to the light, which is much where it is far. Triangles whose depth is that close to
 * the point's are decided again, in double, from the point and the corners in frame space, where they are off only by
 * the spawn error, and the point was put off its surface by more than that. A point's own triangle is left out, unless
 * it faces away from the light, as the smooth inside of a vessel may; so are all triangles of a convex or a flat
 * instance for its own points. So no light leaks between triangles or through the walls of a corner, and a surface does
 * not shadow itself by rounding. */
#include "raster/samples/setup.h"

enum {
    LIST = 64,        /* leaf blocks before their triangles are tested */
    FEW_OF_MESH = 512 /* so many points whose rays meet the mesh's bounds go on one by one: where triangles are so much
                       * smaller than their distances, boxes of 16 say little */
};

/* A multiple of a × b that is negated, bit for bit, where a and b are exchanged. */
static double edge_side(daft_dvec3 a, daft_dvec3 b, daft_dvec3 d)
{
    return daft_ddot(daft_dcross(daft_dsub(a, b), daft_dadd(a, b)), d);
}

bool DAFT_KERNEL(daft_stands_between)(const occluder *c, const daft_block *block, int lane, uint32_t point)
{
    shadow_ray w = shadow_ray_of(c->samples, c->light, point);
    const float *m = c->instance->to_frame.m, *t = c->instance->to_frame.t;
    daft_dvec3 q[3];
    for (int k = 0; k < 3; k++) {
        double v[3], moved[3];
        for (int i = 0; i < 3; i++) v[i] = (double)block->corner[k][i][lane];
        for (int i = 0; i < 3; i++)
            moved[i] =
                (double)m[3 * i] * v[0] + (double)m[3 * i + 1] * v[1] + (double)m[3 * i + 2] * v[2] + (double)t[i];
        q[k] = daft_dsub(daft_dv3(moved[0], moved[1], moved[2]), w.from);
    }
    daft_dvec3 normal = daft_dcross(daft_dsub(q[1], q[0]), daft_dsub(q[2], q[0]));
    double along = daft_ddot(normal, w.direction);
    if (along == 0 || !on_shadow_ray(&w, daft_ddot(normal, q[0]) / along)) return false;
    double u = edge_side(q[1], q[2], w.direction), v = edge_side(q[2], q[0], w.direction),
           s = edge_side(q[0], q[1], w.direction);
    return (u >= 0 && v >= 0 && s >= 0) || (u <= 0 && v <= 0 && s <= 0);
}

static __attribute__((noinline)) void look_closely(const occluder *c, const daft_block *block, int lane, uint32_t first,
                                                   vbits doubt)
{
    shadow_points *p = c->points;
    for (; doubt; doubt &= doubt - 1) {
        uint32_t at = first + (uint32_t)__builtin_ctz(doubt);
        if (DAFT_KERNEL(daft_stands_between)(c, block, lane, p->source[at])) p->depth[at] = -INFINITY;
    }
}

/* The triangles that a block may lie behind. */
DAFT_INLINE vbits triangles_before(const lanes *t, const shadow_points *p, uint32_t b)
{
    vm u = vm_and(vf_le(vf_load(t->low_u), vf_set(p->high_u[b])), vf_le(vf_set(p->low_u[b]), vf_load(t->high_u)));
    vm v = vm_and(vf_le(vf_load(t->low_v), vf_set(p->high_v[b])), vf_le(vf_set(p->low_v[b]), vf_load(t->high_v)));
    return vbits_from_mask(vm_and(vm_and(u, v), vf_le(vf_load(t->near), vf_set(p->far[b]))));
}

DAFT_INLINE vf edge_at(const lanes *t, int k, int i, vf3 d)
{
    return vf_set(t->nx[k][i]) * d.x + vf_set(t->ny[k][i]) * d.y + vf_set(t->nz[k][i]) * d.z;
}

/* DAFT_VL points of a block: their rays, depths, and places in the picture. */
typedef struct some_points {
    vf3 ray;
    vf depth, u, v;
} some_points;

DAFT_INLINE some_points points_load(const shadow_points *p, uint32_t first)
{
    return (some_points){{vf_load(&p->x[first]), vf_load(&p->y[first]), vf_load(&p->z[first])},
                         vf_load(&p->depth[first]),
                         vf_load(&p->u[first]),
                         vf_load(&p->v[first])};
}

/* Those in a triangle's box: past the end of a sharp corner they may be close to both of its edges. */
DAFT_INLINE vm points_within(const lanes *t, int i, const some_points *p)
{
    return vm_and(vm_and(vf_le(vf_set(t->low_u[i]), p->u), vf_le(p->u, vf_set(t->high_u[i]))),
                  vm_and(vf_le(vf_set(t->low_v[i]), p->v), vf_le(p->v, vf_set(t->high_v[i]))));
}

/* Those that are not surely on the light's side of its plane: most of what a surface's own triangles meet is. */
DAFT_INLINE vm points_beyond(const lanes *t, int i, const some_points *p)
{
    vf at = vf_set(t->plane[0][i]) * p->ray.x + vf_set(t->plane[1][i]) * p->ray.y + vf_set(t->plane[2][i]) * p->depth;
    return vf_le(vf_set(t->surface[i]), at);
}

/* Of points that the triangle may hide, puts those that it does to depth -inf; gives whether there are any. An overflow
 * gives NaN, which is in front of nothing. */
static bool hide_points(const mesh_occluder *m, const lanes *t, int i, const daft_block *block, const triangle_edges *e,
                        vm side, uint32_t first)
{
    const occluder *c = &m->c;
    shadow_points *p = c->points;
    uint32_t triangle = block->triangle[i % DAFT_BLOCK];
    bool apart = c->convex || c->flat;
    if (!apart) side = vm_and(side, vm_not(vm_from_bits(lie_on(c, triangle, first))));
    if (!vbits_from_mask(side)) return false;
    vf limit = vf_load(&p->depth[first]), bound = vf_set(t->bound[i]), rounding = vf_set(t->rounding[i]);
    vm sure = vm_or(vf_le(-bound, e->min), vf_le(e->max, bound));
    vf inverse = vf_set(1) / (e->e0 + e->e1 + e->e2);
    vf depth =
        (e->e0 * vf_set(t->depth[0][i]) + e->e1 * vf_set(t->depth[1][i]) + e->e2 * vf_set(t->depth[2][i])) * inverse;
    vf error = vf_abs(vf_set(t->slack[i]) * inverse) + rounding;
    vf behind = rounding + vf_set(c->view->pencil.away * 0x1p-20f) + vf_load(&p->end[first]);
    vm dark = vm_and(vm_and(side, sure), vm_and(vf_lt(depth + error, limit), vf_lt(behind, depth)));
    vf_store(&p->depth[first], vf_if_then_else(dark, vf_set(-INFINITY), limit));
    vm past = vf_lt(depth + error, vf_load(&p->end[first]) - vf_set(c->view->pencil.away * 0x1p-20f));
    vbits doubt = vbits_from_mask(vm_and(side, vf_lt(depth - error, limit))) & ~vbits_from_mask(vm_or(dark, past));
    if (doubt && apart) doubt &= ~lie_on(c, triangle, first);
    if (doubt) look_closely(c, block, i % DAFT_BLOCK, first, doubt);
    return (vbits_from_mask(dark) | doubt) != 0;
}

/* Blocks and triangles that a point of the one may be hidden by: block · DAFT_VL + lane, and from PAIR_POINTS on bits
 * of the points. What is left of them after each test goes on to the next, so that no branch depends on one. */
enum { PAIR_POINTS = 16 };
typedef struct pairs {
    uint32_t count, pair[SHADOW_BLOCKS * DAFT_VL + DAFT_VL];
} pairs;

/* The lanes with this triangle. */
DAFT_INLINE vbits lanes_of(const lanes *t, uint32_t triangle)
{
    return vbits_from_mask(vi_eq(vi_load(t->triangle), vi_set((int32_t)triangle)));
}

static void pairs_begin(const occluder *c, const lanes *t, vbits live, const block_set *behind, pairs *out)
{
    const shadow_points *p = c->points;
    out->count = 0;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1) {
            uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left);
            vbits own = lanes_of(t, p->on[b] == c->number ? p->sole[b] : DAFT_NO_TRIANGLE);
            vbits triangles = triangles_before(t, p, b) & live & ~own;
            vi_compress_store(&out->pair[out->count], triangles, vi_iota() + vi_set((int32_t)(b * DAFT_VL)));
            out->count += (uint32_t)__builtin_popcount(triangles);
        }
}

/* Leaves the points that are lit, in the triangle's box and not surely before its plane. */
static void pairs_in_box(const lanes *t, const shadow_points *p, pairs *list)
{
    uint32_t kept = 0;
    for (uint32_t n = 0; n < list->count; n++) {
        uint32_t pair = list->pair[n], b = pair / DAFT_VL, points = 0;
        int i = (int)(pair % DAFT_VL);
        for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
            const some_points some = points_load(p, b * SHADOW_BLOCK + k);
            vm in = vm_and(points_within(t, i, &some), vf_lt(vf_set(-INFINITY), some.depth));
            points |= vbits_from_mask(vm_and(in, points_beyond(t, i, &some))) << k;
        }
        list->pair[kept] = pair | points << PAIR_POINTS;
        kept += points != 0;
    }
    list->count = kept;
}

DAFT_INLINE triangle_edges edges_of(const lanes *t, int i, const some_points *p)
{
    triangle_edges e = {.e0 = edge_at(t, 0, i, p->ray), .e1 = edge_at(t, 1, i, p->ray), .e2 = edge_at(t, 2, i, p->ray)};
    e.min = vf_min(e.e0, vf_min(e.e1, e.e2)), e.max = vf_max(e.e0, vf_max(e.e1, e.e2));
    return e;
}

/* Leaves the points that no edge has surely outside. */
static void pairs_in_edges(const lanes *t, const shadow_points *p, pairs *list)
{
    uint32_t kept = 0;
    for (uint32_t n = 0; n < list->count; n++) {
        uint32_t pair = list->pair[n] & 0xffff, b = pair / DAFT_VL, points = 0;
        int i = (int)(pair % DAFT_VL);
        vf wide = vf_set(t->wide[i]);
        for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
            const some_points some = points_load(p, b * SHADOW_BLOCK + k);
            const triangle_edges e = edges_of(t, i, &some);
            points |= vbits_from_mask(vm_or(vf_le(-wide, e.min), vf_le(e.max, wide))) << k;
        }
        points &= list->pair[n] >> PAIR_POINTS;
        list->pair[kept] = pair | points << PAIR_POINTS;
        kept += points != 0;
    }
    list->count = kept;
}

static void pairs_hide(const mesh_occluder *m, const lanes *t, const leaf *const *leaves, const pairs *list)
{
    shadow_points *p = m->c.points;
    for (uint32_t n = 0; n < list->count; n++) {
        uint32_t pair = list->pair[n] & 0xffff, b = pair / DAFT_VL, points = list->pair[n] >> PAIR_POINTS;
        int i = (int)(pair % DAFT_VL);
        bool changed = false;
        for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
            vm side = vm_from_bits(points >> k & DAFT_ALL_LANES);
            const some_points some = points_load(p, b * SHADOW_BLOCK + k);
            const triangle_edges e = edges_of(t, i, &some);
            if (m->c.filtered)
                changed |= DAFT_KERNEL(daft_filter_points)(m, t, i, &e, vbits_from_mask(side), b * SHADOW_BLOCK + k);
            else
                changed |= hide_points(m, t, i, leaves[i / DAFT_BLOCK]->block, &e, side, b * SHADOW_BLOCK + k);
        }
        if (changed) block_darkened(p, b);
    }
}

/* Those of the triangles that let everything through. */
static vbits clear_lanes(const daft_instance *s, const lanes *t, vbits live)
{
    vbits clear = 0;
    for (vbits left = s->opacity ? live : 0; left; left &= left - 1)
        if (s->opacity[t->triangle[__builtin_ctz(left)]] == DAFT_OPACITY_CLEAR) clear |= left & -left;
    return clear;
}

/* `count` of the leaves' blocks are real. */
static void test_leaves(const mesh_occluder *m, const leaf *const *leaves, uint32_t count)
{
    lanes t;
    pairs list;
    view_corners moved = corners_move(m, leaves);
    block_set behind = {{0}};
    lanes_place(m, &moved, &t);
    vbits live = lanes_name(leaves, count, &t) & lanes_met(m, &moved, &t);
    if (live && m->c.filtered) live &= ~clear_lanes(m->c.instance, &t, live);
    if (!live) return;
    for (uint32_t k = 0; k < DAFT_VL / 4; k++)
        for (uint32_t word = 0; word < DAFT_COUNT_OF(behind.bits); word++)
            behind.bits[word] |= leaves[k]->behind.bits[word];
    pairs_begin(&m->c, &t, live, &behind, &list);
    if (!list.count) return;
    lanes_setup(m, &moved, true, &t);
    pairs_in_box(&t, m->c.points, &list);
    pairs_in_edges(&t, m->c.points, &list);
    pairs_hide(m, &t, leaves, &list);
}

/* ---- trees ---- */

static void flush(const mesh_occluder *c, const leaf *list, uint32_t count)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL / 4) {
        const leaf *leaves[DAFT_VL / 4];
        for (uint32_t k = 0; k < DAFT_VL / 4; k++) leaves[k] = &list[i + k < count ? i + k : i];
        test_leaves(c, leaves, count - i);
    }
}

typedef struct entry {
    uint32_t node;
    block_set behind;
} entry;

static void walk(const mesh_occluder *m, const block_set *behind)
{
    const occluder *c = &m->c;
    const daft_bvh *bvh = c->instance->bvh;
    entry stack[DAFT_STACK];
    leaf list[LIST + DAFT_MAX_LEAF_BLOCKS];
    uint32_t count = 0;
    int top = 0;
    stack[top++] = (entry){0, *behind};
    while (top > 0 && c->points->live) {
        node_boxes boxes;
        block_set next[DAFT_WIDTH];
        const entry at = stack[--top];
        const daft_node *node = &bvh->nodes.items[at.node];
        uint32_t in = DAFT_KERNEL(daft_node_project)(c->view, &m->map, node, &boxes);
        if (in) in = children_narrow(&boxes, in, c->points, &at.behind, next);
        for (; in; in &= in - 1) {
            int i = __builtin_ctz(in);
            uint32_t child = node->child[i];
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF)) {
                fetch_node(bvh, child);
                stack[top++] = (entry){child, next[i]};
                continue;
            }
            fetch_leaf(bvh, child); /* it waits in a list: time enough */
            count = list_leaf(bvh, child, &next[i], list, count);
            if (count < LIST) continue;
            flush(m, list, count);
            count = 0;
        }
    }
    flush(m, list, count);
}

void DAFT_KERNEL(daft_mesh_shadow)(const occluder *c, const block_set *behind)
{
    mesh_occluder m;
    DAFT_KERNEL(daft_mesh_occluder_make)(c, &m);
    walk(&m, behind);
}

void DAFT_KERNEL(daft_mesh_shadow_by)(const occluder *c, const block_set *behind, const daft_block *const *blocks,
                                      uint32_t count)
{
    mesh_occluder m;
    leaf list[LIST];
    DAFT_KERNEL(daft_mesh_occluder_make)(c, &m);
    for (uint32_t i = 0; i < count; i += LIST) {
        const uint32_t some = daft_min_u(count - i, LIST);
        for (uint32_t k = 0; k < some; k++) list[k] = (leaf){blocks[i + k], *behind};
        flush(&m, list, some);
    }
}

void DAFT_KERNEL(daft_mesh_shadow_of)(const occluder *c, const block_points *points, uint32_t count)
{
    mesh_occluder m;
    block_set behind = {{0}};
    uint32_t all = 0;
    for (uint32_t i = 0; i < count; i++) all += (uint32_t)__builtin_popcount(points[i].points);
    DAFT_KERNEL(daft_mesh_occluder_make)(c, &m);
    if (all <= FEW_OF_MESH && !c->filtered) {
        DAFT_KERNEL(daft_few_shadow)(&m, points, count);
        return;
    }
    for (uint32_t i = 0; i < count; i++) behind.bits[points[i].block / 64] |= (uint64_t)1 << (points[i].block % 64);
    walk(&m, &behind);
}
