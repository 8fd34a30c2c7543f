/* The shadow pencil's occluders: an instance's tree is walked with its nodes' boxes in the lamp's picture
 * (picture_kernel.c), down to those that lie before lit points; the triangles found are moved to light space and set up
 * DAFT_VL at a time. Each block of points whose box meets some of them is tested against these: lanes are points. Blocks in
 * which all is dark meet nothing any more. Where few points are left behind a node, they leave their blocks and go on by
 * themselves: their ways to the lamp are turned into the thing's own space and held against nodes' boxes there, which takes
 * less for each point but more for many, and each point is tested against all set-up triangles at once: lanes are triangles.
 * Which triangles are looked at depends on that, and what hides a point does not.
 *
 * One edge test serves lamps and suns: n = (a - b) × (a + b), e = n·ray, with the bound of raster/tile_kernel.c.
 *
 * A point is in shadow when no edge has it surely outside and the triangle is surely nearer to the lamp. Depths are off
 * by some 2^-18 of the way to the lamp, which is much where it is far: triangles whose depth is that close to the
 * point's are decided again, in double, from the point and the corners in frame space, where they are off only by the
 * spawn error, and the point was put off its surface by more than that. A point's own triangle is left out, unless it
 * faces away from the lamp, as the smooth inside of a vessel may; so are all of a convex or a flat thing's for its own
 * points. So no light leaks between triangles or through the walls of a corner, and a surface does not shadow itself by
 * rounding. */
#include "render/occluder.h"

enum {
    LIST = 64,     /* leaf blocks before their triangles are tested */
    FEW_LEAVES = 24 /* the same in leaves, of few points */
};

/* A multiple of a × b that is negated, bit for bit, where a and b are exchanged. */
static double edge_side(daft_dvec3 a, daft_dvec3 b, daft_dvec3 d)
{
    return daft_ddot(daft_dcross(daft_dsub(a, b), daft_dadd(a, b)), d);
}

/* Whether the triangle, closed, stands between the point and the lamp, by frame space's own numbers. */
static bool stands_between(const caster *c, const daft_block *block, int lane, uint32_t point)
{
    sight w = sight_of(c->batch, c->lamp, point);
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
    if (along == 0 || !on_sight(&w, daft_ddot(normal, q[0]) / along)) return false;
    double u = edge_side(q[1], q[2], w.direction), v = edge_side(q[2], q[0], w.direction),
           s = edge_side(q[0], q[1], w.direction);
    return (u >= 0 && v >= 0 && s >= 0) || (u <= 0 && v <= 0 && s <= 0);
}

static __attribute__((noinline)) void look_closely(const caster *c, const daft_block *block, int lane, uint32_t first,
                                                   vbits doubt)
{
    shadow_points *p = c->points;
    for (; doubt; doubt &= doubt - 1) {
        uint32_t at = first + (uint32_t)__builtin_ctz(doubt);
        if (stands_between(c, block, lane, p->source[at])) p->depth[at] = -INFINITY;
    }
}

/* The triangles that a block may lie behind. */
DAFT_INLINE vbits triangles_before(const lanes *t, const shadow_points *p, uint32_t b)
{
    vm u = vm_and(vf_le(vf_load(t->low_u), vf_set(p->high_u[b])), vf_le(vf_set(p->low_u[b]), vf_load(t->high_u)));
    vm v = vm_and(vf_le(vf_load(t->low_v), vf_set(p->high_v[b])), vf_le(vf_set(p->low_v[b]), vf_load(t->high_v)));
    return vm_bits(vm_and(vm_and(u, v), vf_le(vf_load(t->near), vf_set(p->far[b]))));
}

/* A triangle's edges at some points' rays. */
typedef struct edges {
    vf e0, e1, e2, least, most;
} edges;

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
                         vf_load(&p->depth[first]), vf_load(&p->u[first]), vf_load(&p->v[first])};
}

/* Those in a triangle's box: past the end of a sharp corner they may be close to both of its edges. */
DAFT_INLINE vm points_within(const lanes *t, int i, const some_points *p)
{
    return vm_and(vm_and(vf_le(vf_set(t->low_u[i]), p->u), vf_le(p->u, vf_set(t->high_u[i]))),
                  vm_and(vf_le(vf_set(t->low_v[i]), p->v), vf_le(p->v, vf_set(t->high_v[i]))));
}

/* Those that are not surely on the lamp's side of its plane: most of what a surface's own triangles meet is. */
DAFT_INLINE vm points_beyond(const lanes *t, int i, const some_points *p)
{
    vf at = vf_set(t->plane[0][i]) * p->ray.x + vf_set(t->plane[1][i]) * p->ray.y + vf_set(t->plane[2][i]) * p->depth;
    return vf_le(vf_set(t->surface[i]), at);
}

/* Of points that the triangle may hide, puts those that it does to depth -inf; gives whether there are any. An overflow
 * gives NaN, which is in front of nothing. */
static bool hide_points(const mesh_caster *m, const lanes *t, int i, const daft_block *block, const edges *e, vm side,
                        uint32_t first)
{
    const caster *c = &m->c;
    shadow_points *p = c->points;
    uint32_t triangle = block->triangle[i % DAFT_BLOCK];
    bool apart = c->convex || c->flat;
    if (!apart) side = vm_and(side, vm_not(vm_from_bits(lie_on(c, triangle, first))));
    if (!vm_bits(side)) return false;
    vf limit = vf_load(&p->depth[first]), bound = vf_set(t->bound[i]), rounding = vf_set(t->rounding[i]);
    vm sure = vm_or(vf_le(-bound, e->least), vf_le(e->most, bound));
    vf inverse = vf_set(1) / (e->e0 + e->e1 + e->e2);
    vf depth = (e->e0 * vf_set(t->depth[0][i]) + e->e1 * vf_set(t->depth[1][i]) + e->e2 * vf_set(t->depth[2][i])) * inverse;
    vf error = vf_abs(vf_set(t->slack[i]) * inverse) + rounding;
    vf behind = c->light->sun ? vf_set(-INFINITY)
                              : rounding - vf_set(c->light->away * (1 - 0x1p-20f)); /* not beyond the lamp */
    vm dark = vm_and(vm_and(side, sure), vm_and(vf_lt(depth + error, limit), vf_lt(behind, depth)));
    vf_store(&p->depth[first], vf_select(dark, vf_set(-INFINITY), limit));
    vbits doubt = vm_bits(side) & vm_bits(vf_lt(depth - error, limit)) & ~vm_bits(dark);
    if (doubt && apart) doubt &= ~lie_on(c, triangle, first);
    if (doubt) look_closely(c, block, i % DAFT_BLOCK, first, doubt);
    return (vm_bits(dark) | doubt) != 0;
}

/* Blocks and triangles that a point of the one may be hidden by: block · DAFT_VL + lane, and from PAIR_POINTS on bits of the
 * points. What is left of them after each test goes on to the next, so that no branch depends on one. */
enum { PAIR_POINTS = 16 };
typedef struct pairs {
    uint32_t count, pair[SHADOW_BLOCKS * DAFT_VL + DAFT_VL];
} pairs;

/* The lanes with this triangle. */
DAFT_INLINE vbits lanes_of(const lanes *t, uint32_t triangle)
{
    return vm_bits(vi_eq(vi_load(t->triangle), vi_set((int32_t)triangle)));
}

static void pairs_begin(const caster *c, const lanes *t, vbits live, const block_set *behind, pairs *out)
{
    const shadow_points *p = c->points;
    out->count = 0;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1) {
            uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left);
            vbits own = lanes_of(t, p->on[b] == c->number ? p->sole[b] : DAFT_NO_TRIANGLE);
            vbits triangles = triangles_before(t, p, b) & live & ~own;
            vi_compress(&out->pair[out->count], triangles, vi_iota() + vi_set((int32_t)(b * DAFT_VL)));
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
            points |= vm_bits(vm_and(in, points_beyond(t, i, &some))) << k;
        }
        list->pair[kept] = pair | points << PAIR_POINTS;
        kept += points != 0;
    }
    list->count = kept;
}

DAFT_INLINE edges edges_of(const lanes *t, int i, const some_points *p)
{
    edges e = {.e0 = edge_at(t, 0, i, p->ray), .e1 = edge_at(t, 1, i, p->ray), .e2 = edge_at(t, 2, i, p->ray)};
    e.least = vf_min(e.e0, vf_min(e.e1, e.e2)), e.most = vf_max(e.e0, vf_max(e.e1, e.e2));
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
            const edges e = edges_of(t, i, &some);
            points |= vm_bits(vm_or(vf_le(-wide, e.least), vf_le(e.most, wide))) << k;
        }
        points &= list->pair[n] >> PAIR_POINTS;
        list->pair[kept] = pair | points << PAIR_POINTS;
        kept += points != 0;
    }
    list->count = kept;
}

static void pairs_hide(const mesh_caster *m, const lanes *t, const leaf *const *leaves, const pairs *list)
{
    shadow_points *p = m->c.points;
    for (uint32_t n = 0; n < list->count; n++) {
        uint32_t pair = list->pair[n] & 0xffff, b = pair / DAFT_VL, points = list->pair[n] >> PAIR_POINTS;
        int i = (int)(pair % DAFT_VL);
        bool changed = false;
        for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
            vm side = vm_from_bits(points >> k & DAFT_ALL_LANES);
            const some_points some = points_load(p, b * SHADOW_BLOCK + k);
            const edges e = edges_of(t, i, &some);
            changed |= hide_points(m, t, i, leaves[i / DAFT_BLOCK]->block, &e, side, b * SHADOW_BLOCK + k);
        }
        if (changed) block_darkened(p, b);
    }
}

static void test_leaves(const mesh_caster *m, const leaf *const *leaves, vbits used)
{
    lanes t;
    pairs list;
    corners moved = corners_move(m, leaves);
    vbits live = lanes_place(m, &moved, &t) & used;
    block_set behind = {{0}};
    if (!live) return;
    lanes_name(leaves, &t);
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

/* ---- few points ---- */

enum { FEW_POINTS = 32 }; /* where triangles are so much smaller than their distances that boxes of 16 say little */

/* Points by themselves, not in blocks; sets of them are bits. */
typedef struct few_points {
    uint32_t count;
    uint32_t live; /* those that are still lit */
    _Alignas(64) float u[FEW_POINTS + DAFT_VL], v[FEW_POINTS + DAFT_VL], depth[FEW_POINTS + DAFT_VL];
    _Alignas(64) float from[3][FEW_POINTS + DAFT_VL], inverse[3][FEW_POINTS + DAFT_VL]; /* object space: places, and one over
                                                                                       * the ways to the lamp */
    uint32_t at[FEW_POINTS + DAFT_VL]; /* among the blocks' */
} few_points;

/* Places in light space become such in object space, and their ways to the lamp are set. One over none is finite, so that products with it are numbers. */
static void few_ways(const mesh_caster *m, few_points *f)
{
    const float *b = m->back.m, *t = m->back.t, away = m->c.light->away;
    for (uint32_t i = 0; i < f->count; i += DAFT_VL) {
        vf x = vf_load(&f->from[0][i]), y = vf_load(&f->from[1][i]), z = vf_load(&f->depth[i]);
        for (int k = 0; k < 3; k++) {
            vf across = vf_set(b[3 * k]) * x + vf_set(b[3 * k + 1]) * y;
            vf way = m->c.light->sun ? vf_set(-b[3 * k + 2]) : -(across + vf_set(b[3 * k + 2]) * (z + vf_set(away)));
            vf_store(&f->from[k][i], across + vf_set(b[3 * k + 2]) * z + vf_set(t[k]));
            vf_store(&f->inverse[k][i], vf_max(vf_min(vf_set(1) / way, vf_set(1e30f)), vf_set(-1e30f)));
        }
    }
}

/* The lit points behind the box, of which it is known that they are few. */
static void few_take(const mesh_caster *m, const picture_box *box, const block_set *from, few_points *out)
{
    const shadow_points *p = m->c.points;
    uint32_t count = 0;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(from->bits); word++)
        for (uint64_t left = from->bits[word]; left; left &= left - 1) {
            uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left), in = points_behind(box, p, b);
            for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
                uint32_t at = b * SHADOW_BLOCK + k, some = in >> k & DAFT_ALL_LANES;
                vf_compress(&out->u[count], some, vf_load(&p->u[at])), vf_compress(&out->v[count], some, vf_load(&p->v[at]));
                vf_compress(&out->from[0][count], some, vf_load(&p->x[at])), vf_compress(&out->from[1][count], some, vf_load(&p->y[at]));
                vf_compress(&out->depth[count], some, vf_load(&p->depth[at]));
                vi_compress(&out->at[count], some, vi_iota() + vi_set((int32_t)at));
                count += (uint32_t)__builtin_popcount(some);
            }
        }
    out->count = count, out->live = (uint32_t)(((uint64_t)1 << count) - 1);
    few_ways(m, out);
}

/* The triangles whose box a point lies behind. */
DAFT_INLINE vbits triangles_over(const lanes *t, const few_points *f, uint32_t i)
{
    vf u = vf_set(f->u[i]), v = vf_set(f->v[i]);
    vm in = vm_and(vm_and(vf_le(vf_load(t->low_u), u), vf_le(u, vf_load(t->high_u))),
                   vm_and(vf_le(vf_load(t->low_v), v), vf_le(v, vf_load(t->high_v))));
    return vm_bits(vm_and(in, vf_le(vf_load(t->near), vf_set(f->depth[i]))));
}

DAFT_INLINE vf edges_at(const lanes *t, int k, vf3 d)
{
    return vf_load(t->nx[k]) * d.x + vf_load(t->ny[k]) * d.y + vf_load(t->nz[k]) * d.z;
}

/* Whether one of the triangles hides the point: hide_points, with triangles for lanes. */
static bool point_hidden(const mesh_caster *m, const lanes *t, const leaf *const *leaves, vbits triangles, uint32_t at)
{
    const caster *c = &m->c;
    const shadow_points *p = c->points;
    const vf3 d = {vf_set(p->x[at]), vf_set(p->y[at]), vf_set(p->z[at])};
    vf e0 = edges_at(t, 0, d), e1 = edges_at(t, 1, d), e2 = edges_at(t, 2, d);
    vf least = vf_min(e0, vf_min(e1, e2)), most = vf_max(e0, vf_max(e1, e2)), wide = vf_load(t->wide);
    vbits side = vm_bits(vm_or(vf_le(-wide, least), vf_le(most, wide))) & triangles;
    if (!side) return false;
    bool on = p->instance[at] == c->number, apart = c->convex || c->flat;
    if (on && !apart) side &= ~vm_bits(vi_eq(vi_load(t->triangle), vi_set((int32_t)p->own[at])));
    if (!side) return false;
    vf bound = vf_load(t->bound), rounding = vf_load(t->rounding), limit = vf_set(p->depth[at]);
    vm sure = vm_or(vf_le(-bound, least), vf_le(most, bound));
    vf inverse = vf_set(1) / (e0 + e1 + e2);
    vf depth = (e0 * vf_load(t->depth[0]) + e1 * vf_load(t->depth[1]) + e2 * vf_load(t->depth[2])) * inverse;
    vf error = vf_abs(vf_load(t->slack) * inverse) + rounding;
    vf behind = c->light->sun ? vf_set(-INFINITY) : rounding - vf_set(c->light->away * (1 - 0x1p-20f));
    if (vm_bits(vm_and(sure, vm_and(vf_lt(depth + error, limit), vf_lt(behind, depth)))) & side) return true;
    if (on && (c->convex || (c->flat && p->own[at] != DAFT_NO_TRIANGLE))) return false;
    for (vbits doubt = side & vm_bits(vf_lt(depth - error, limit)); doubt; doubt &= doubt - 1) {
        int i = __builtin_ctz(doubt);
        if (stands_between(c, leaves[i / DAFT_BLOCK]->block, i % DAFT_BLOCK, p->source[at])) return true;
    }
    return false;
}

static void few_darken(const mesh_caster *m, few_points *f, uint32_t i)
{
    shadow_points *p = m->c.points;
    f->live &= ~((uint32_t)1 << i);
    p->depth[f->at[i]] = -INFINITY;
    block_darkened(p, f->at[i] / SHADOW_BLOCK);
}

/* Which points lie behind which triangles' boxes is found first, so that no branch hangs on it. */
static void few_test(const mesh_caster *m, few_points *f, const leaf *const *leaves, vbits used)
{
    lanes t;
    uint32_t behind = 0, count = 0, point[FEW_POINTS + 1];
    vbits triangles[FEW_POINTS + 1];
    for (uint32_t k = 0; k < DAFT_VL / 4; k++) behind |= (uint32_t)leaves[k]->behind.bits[0];
    behind &= f->live;
    if (!behind) return;
    corners moved = corners_move(m, leaves);
    vbits live = lanes_place(m, &moved, &t) & used;
    for (; behind; behind &= behind - 1) {
        point[count] = (uint32_t)__builtin_ctz(behind);
        triangles[count] = triangles_over(&t, f, point[count]) & live;
        count += triangles[count] != 0;
    }
    if (!count) return;
    lanes_setup(m, &moved, false, &t), lanes_name(leaves, &t);
    for (uint32_t k = 0; k < count; k++)
        if (point_hidden(m, &t, leaves, triangles[k], f->at[point[k]])) few_darken(m, f, point[k]);
}

/* ---- trees ---- */

/* `few`: whose points these are by themselves, or NULL. */
static void flush(const mesh_caster *c, const leaf *list, uint32_t count, few_points *few)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL / 4) {
        const leaf *leaves[DAFT_VL / 4];
        vbits used = 0;
        for (uint32_t k = 0; k < DAFT_VL / 4; k++) {
            bool real = i + k < count;
            leaves[k] = &list[real ? i + k : i];
            for (uint32_t j = 0; real && j < DAFT_BLOCK; j++)
                used |= (vbits)(leaves[k]->block->triangle[j] != DAFT_NO_TRIANGLE) << (k * DAFT_BLOCK + j);
        }
        few ? few_test(c, few, leaves, used) : test_leaves(c, leaves, used);
    }
}

DAFT_INLINE void fetch_leaf(const daft_bvh *bvh, uint32_t child)
{
    const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    size_t size = ((child & 3) + 1) * sizeof *block;
    for (size_t line = 0; line < size; line += 64) __builtin_prefetch((const char *)block + line);
}

DAFT_INLINE uint32_t list_leaf(const daft_bvh *bvh, uint32_t child, const block_set *behind, leaf *list, uint32_t count)
{
    const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    for (uint32_t k = 0; k <= (child & 3); k++) list[count++] = (leaf){&block[k], *behind};
    return count;
}

DAFT_INLINE void fetch_node(const daft_bvh *bvh, uint32_t child)
{
    const char *node = (const char *)&bvh->nodes.items[child];
    for (size_t line = 0; line < sizeof(daft_node); line += 64) __builtin_prefetch(node + line);
}

/* `node`: a child, leaf or not, and which of the points lie behind it. */
typedef struct few_entry {
    uint32_t node, behind;
} few_entry;

static void few_flush(const mesh_caster *m, const few_entry *ends, uint32_t count, few_points *f)
{
    leaf list[(FEW_LEAVES + DAFT_WIDTH) * DAFT_MAX_LEAF_BLOCKS];
    uint32_t blocks = 0;
    for (uint32_t i = 0; i < count; i++) {
        const block_set behind = {{ends[i].behind}};
        blocks = list_leaf(m->c.instance->bvh, ends[i].node, &behind, list, blocks);
    }
    flush(m, list, blocks, f);
}

/* Bit 8·i + k becomes bit 8·k + i. */
DAFT_INLINE uint64_t transpose_bits(uint64_t x)
{
    x = (x & 0xaa55aa55aa55aa55) | (x & 0x00aa00aa00aa00aa) << 7 | (x >> 7 & 0x00aa00aa00aa00aa);
    x = (x & 0xcccc3333cccc3333) | (x & 0x0000cccc0000cccc) << 14 | (x >> 14 & 0x0000cccc0000cccc);
    return (x & 0xf0f0f0f00f0f0f0f) | (x & 0x00000000f0f0f0f0) << 28 | (x >> 28 & 0x00000000f0f0f0f0);
}

/* Which of the points' ways to the lamp meet which of a node's children: few points cost less so than boxes seen from the lamp.
 * Gives the bits of the children that some meet. */
DAFT_INLINE uint32_t children_met(const mesh_caster *m, const daft_node *node, const few_points *f, uint32_t from,
                                  uint32_t behind[DAFT_WIDTH])
{
    uint32_t any = 0, real = v8_le_bits(v8_load(node->bounds[0]), v8_load(node->bounds[3]));
    uint64_t met[FEW_POINTS / 8] = {0};
    v8 low[3], high[3];
    for (int k = 0; k < 3; k++)
        low[k] = v8_load(node->bounds[k]) - v8_set(m->pad[k]), high[k] = v8_load(node->bounds[3 + k]) + v8_set(m->pad[k]);
    for (; from; from &= from - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(from);
        v8 near = v8_set(0), far = v8_set(m->c.light->sun ? INFINITY : 1.00001f);
        for (int k = 0; k < 3; k++) {
            v8 at = v8_set(f->from[k][i]), inverse = v8_set(f->inverse[k][i]), a = (low[k] - at) * inverse, b = (high[k] - at) * inverse;
            near = v8_max(v8_min(a, b), near), far = v8_min(v8_max(a, b), far);
        }
        uint32_t in = v8_le_bits(near, far * v8_set(1 + 0x1p-20f)) & real;
        any |= in, met[i / 8] |= (uint64_t)in << (8 * (i % 8));
    }
    for (int k = 0; k < FEW_POINTS / 8; k++) met[k] = transpose_bits(met[k]);
    for (int i = 0; i < DAFT_WIDTH; i++) {
        behind[i] = 0;
        for (int k = 0; k < FEW_POINTS / 8; k++) behind[i] |= (uint32_t)(met[k] >> (8 * i) & 255) << (8 * k);
    }
    return any;
}

/* A node's children that some of the points lie behind: nodes go on the stack, leaves to the list. No branch hangs on which. */
DAFT_INLINE void few_children(const mesh_caster *m, const few_entry *at, const few_points *f, few_entry *stack, int *top,
                              few_entry *leaves, uint32_t *leaf_count)
{
    const daft_node *node = &m->c.instance->bvh->nodes.items[at->node];
    uint32_t child[DAFT_WIDTH], behind[DAFT_WIDTH];
    uint32_t met = v8i_list(child, children_met(m, node, f, at->behind & f->live, behind), 0);
    for (uint32_t k = 0; k < met; k++) {
        const few_entry next = {node->child[child[k]], behind[child[k]]};
        bool ends = next.node >> 31;
        stack[*top] = next, leaves[*leaf_count] = next;
        *top += !ends, *leaf_count += ends;
    }
}

static void few_walk(const mesh_caster *m, uint32_t root, few_points *f)
{
    const daft_bvh *bvh = m->c.instance->bvh;
    few_entry stack[DAFT_STACK], ends[FEW_LEAVES + DAFT_WIDTH];
    uint32_t end_count = 0;
    int top = 0;
    stack[top++] = (few_entry){root, f->live};
    while (top > 0) {
        const few_entry at = stack[--top];
        if (!(at.behind & f->live)) continue;
        uint32_t first = end_count;
        few_children(m, &at, f, stack, &top, ends, &end_count);
        if (top > 0) fetch_node(bvh, stack[top - 1].node);
        for (; first < end_count; first++) fetch_leaf(bvh, ends[first].node);
        if (end_count < FEW_LEAVES) continue;
        few_flush(m, ends, end_count, f);
        end_count = 0;
    }
    few_flush(m, ends, end_count, f);
}

typedef struct entry {
    uint32_t node, count; /* no fewer points than lie behind the box */
    picture_box box;
    block_set behind;
} entry;

/* Where few points are left, they go on by themselves. */
static bool go_alone(const mesh_caster *m, const entry *at)
{
    few_points few;
    if (at->count > FEW_POINTS) return false;
    few_take(m, &at->box, &at->behind, &few);
    few_walk(m, at->node, &few);
    return true;
}

/* No fewer than the lit points of the blocks that lie behind the box. */
static uint32_t count_behind(const shadow_points *p, const picture_box *box, const block_set *behind)
{
    uint32_t blocks = set_count(behind), count = 0;
    if (blocks > SHADOW_FEW) return blocks * SHADOW_BLOCK;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1)
            count += (uint32_t)__builtin_popcount(points_behind(box, p, word * 64 + (uint32_t)__builtin_ctzll(left)));
    return count;
}

static void walk(const mesh_caster *m, const picture_box *box, const block_set *behind)
{
    const caster *c = &m->c;
    const daft_bvh *bvh = c->instance->bvh;
    entry stack[DAFT_STACK];
    leaf list[LIST + DAFT_MAX_LEAF_BLOCKS];
    uint32_t count = 0;
    int top = 0;
    stack[top++] = (entry){0, count_behind(c->points, box, behind), *box, *behind};
    while (top > 0 && c->points->live) {
        node_boxes boxes;
        block_set next[DAFT_WIDTH];
        uint32_t points[DAFT_WIDTH];
        const entry at = stack[--top];
        const daft_node *node = &bvh->nodes.items[at.node];
        if (go_alone(m, &at)) continue;
        uint32_t in = DAFT_KERNEL(daft_node_project)(c->light, &m->boxes, node, &boxes);
        if (in) in = children_narrow(&boxes, in, c->points, &at.behind, next, points);
        for (; in; in &= in - 1) {
            int i = __builtin_ctz(in);
            uint32_t child = node->child[i];
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF)) {
                fetch_node(bvh, child);
                stack[top++] = (entry){child, points[i], node_child(&boxes, i), next[i]};
                continue;
            }
            fetch_leaf(bvh, child); /* it waits in a list: time enough */
            count = list_leaf(bvh, child, &next[i], list, count);
            if (count < LIST) continue;
            flush(m, list, count, NULL);
            count = 0;
        }
    }
    flush(m, list, count, NULL);
}

/* Light space to the thing's own. With u = 2^-24, s the size of what points and corners are in light space and f the largest
 * share of the way to the lamp that a box reaches: places are off by some 8u of |map|·s and of the translation, ways by that
 * and 8u of |map|·f·away; corners that a test in light space takes for met by no more than 16u of the first. Their sum is
 * below 2^-18. */
static void set_back(mesh_caster *m)
{
    const light *l = m->c.light;
    const daft_instance *s = m->c.instance;
    const float *o = s->to_object.m, *r = l->map.m, at[3] = {l->origin.x, l->origin.y, l->origin.z};
    float size = 0, share;
    for (int k = 0; k < 3; k++) size += fmaxf(fabsf((&s->low.x)[k] - at[k]), fabsf((&s->high.x)[k] - at[k]));
    size = 2 * size + l->size;
    share = fminf(2 * size / (l->near + l->away), 1);
    if (!l->sun && share > 0) size += share * l->away;
    for (int i = 0; i < 3; i++) {
        double t = (double)s->to_object.t[i];
        float reach = 0, still = fabsf(s->to_object.t[i]);
        for (int j = 0; j < 3; j++) {
            m->back.m[3 * i + j] = (float)((double)o[3 * i] * (double)r[3 * j] + (double)o[3 * i + 1] * (double)r[3 * j + 1] +
                                           (double)o[3 * i + 2] * (double)r[3 * j + 2]);
            t += (double)o[3 * i + j] * (double)at[j], still += fabsf(o[3 * i + j] * at[j]), reach += fabsf(o[3 * i + j]);
        }
        m->back.t[i] = (float)t;
        m->pad[i] = (reach * 2 * size + still) * 0x1p-18f;
    }
}

/* To a tree whose boxes are turned. Corners round by what they reach in the mesh's own space, so that counts as well; no magnitude
 * in the turn is over 1, so pads along all axes hold what places and ways are off by, and twice that what turning them adds. */
static void turn_boxes(mesh_caster *m)
{
    const daft_turn *turn = &m->c.instance->bvh->turn;
    const daft_affine own = m->back, map = daft_turn_map(turn, &m->map.map);
    const float *low = &m->c.instance->mesh->low.x, *high = &m->c.instance->mesh->high.x, pad = 2 * (m->pad[0] + m->pad[1] + m->pad[2]);
    m->boxes = picture_map_make(&map);
    m->boxes.still += m->map.still;
    for (int k = 0; k < 3; k++) {
        daft_dvec3 column = daft_turn_vector(turn, daft_dv3((double)own.m[k], (double)own.m[3 + k], (double)own.m[6 + k]));
        m->back.m[k] = (float)column.x, m->back.m[3 + k] = (float)column.y, m->back.m[6 + k] = (float)column.z;
        m->boxes.still += m->map.reach[k] * fmaxf(fabsf(low[k]), fabsf(high[k]));
        m->pad[k] = pad;
    }
    daft_dvec3 t = daft_turn_point(turn, daft_dv3((double)own.t[0], (double)own.t[1], (double)own.t[2]));
    m->back.t[0] = (float)t.x, m->back.t[1] = (float)t.y, m->back.t[2] = (float)t.z;
}

void DAFT_KERNEL(daft_mesh_shadow)(const caster *c, const picture_box *box, const block_set *behind)
{
    mesh_caster m = {.c = *c};
    const daft_affine map = DAFT_KERNEL(daft_light_compose)(&c->light->map, &c->instance->to_frame, c->light->origin);
    m.map = picture_map_make(&map), m.size = m.map.still, m.boxes = m.map;
    set_back(&m);
    if (c->instance->bvh->turned) turn_boxes(&m);
    walk(&m, box, behind);
}
