/* The shadow pencil's occluders: an instance's tree is walked with its nodes' boxes in the lamp's picture
 * (picture_kernel.c), down to those that lie before lit points; the triangles found are moved to light space and set up
 * DAFT_VL at a time. Each block of points whose box meets some of them is tested against these: lanes are points. Blocks in
 * which all is dark meet nothing any more. Where few points are left behind a node, they leave their blocks and go on by
 * themselves, each against all set-up triangles at once: lanes are triangles. Both ways compute the same.
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
#include "render/shadow.h"

#define UNIT 0x1p-24f
#define TINY 1e-36f

enum {
    LIST = 64,     /* leaf blocks before their triangles are tested */
    FEW_LEAVES = 24 /* the same in leaves, of few points */
};

/* A mesh on its way through its tree. */
typedef struct mesh_caster {
    caster c;
    float size; /* of the map's translation: what corners may lose beside their own coordinates */
    picture_map map; /* object space to light space */
} mesh_caster;

/* ---- triangles ---- */

/* Leaf blocks, waiting to be tested against the points behind their leaf's box: blocks of them, or few by themselves. */
typedef struct leaf {
    const daft_block *block;
    block_set behind;
} leaf;

DAFT_INLINE vf blocks_load(const leaf *const *leaves, int corner, int axis)
{
    const float *from[DAFT_VL / 4];
    for (int i = 0; i < DAFT_VL / 4; i++) from[i] = leaves[i]->block->corner[corner][axis];
    return vf_load_fours(from);
}

DAFT_INLINE vf row(const daft_affine *a, int k, vf3 p)
{
    return ((vf_set(a->m[3 * k]) * p.x + vf_set(a->m[3 * k + 1]) * p.y) + vf_set(a->m[3 * k + 2]) * p.z) +
           vf_set(a->t[k]);
}

/* Triangles set up: edges' planes, corners' depths, their boxes in the picture, and their own planes: the lamp is on the
 * side where a point's product with `plane` is less than `surface`. */
typedef struct lanes {
    float nx[3][DAFT_VL], ny[3][DAFT_VL], nz[3][DAFT_VL], depth[3][DAFT_VL];
    float plane[3][DAFT_VL], surface[DAFT_VL];
    float bound[DAFT_VL], wide[DAFT_VL], slack[DAFT_VL], rounding[DAFT_VL];
    float low_u[DAFT_VL], high_u[DAFT_VL], low_v[DAFT_VL], high_v[DAFT_VL], near[DAFT_VL];
    uint32_t triangle[DAFT_VL];
} lanes;

typedef struct corners {
    vf3 p[3]; /* x, y, z of the test */
    vf depth[3];
} corners;

DAFT_INLINE corners corners_move(const mesh_caster *c, const leaf *const *leaves)
{
    corners out;
    for (int k = 0; k < 3; k++) {
        vf3 p = {blocks_load(leaves, k, 0), blocks_load(leaves, k, 1), blocks_load(leaves, k, 2)};
        out.depth[k] = row(&c->map.map, 2, p);
        out.p[k] = (vf3){row(&c->map.map, 0, p), row(&c->map.map, 1, p),
                         c->c.light->sun ? vf_set(1) : out.depth[k] + vf_set(c->c.light->away)};
    }
    return out;
}

/* As beyond_side, of triangles whose corners are off by `off`. */
DAFT_INLINE vm corners_beyond(const corners *t, int axis, float edge, float side, vf off)
{
    vf least = vf_set(INFINITY), slope = vf_set(edge);
    for (int k = 0; k < 3; k++)
        least = vf_min(((axis ? t->p[k].y : t->p[k].x) - slope * t->p[k].z) * vf_set(side), least);
    return vf_lt(off * vf_set(1 + fabsf(edge)), least);
}

DAFT_INLINE vm corners_outside(const light *l, const corners *t, vf off)
{
    return vm_or(vm_or(corners_beyond(t, 0, l->high_u + l->slack_u, 1, off),
                       corners_beyond(t, 0, l->low_u - l->slack_u, -1, off)),
                 vm_or(corners_beyond(t, 1, l->high_v + l->slack_v, 1, off),
                       corners_beyond(t, 1, l->low_v - l->slack_v, -1, off)));
}

/* 1/z to 2^-21: boxes are wider than that, and nothing else comes of it. */
DAFT_INLINE vf box_reciprocal(vf z)
{
    vf rough = vf_rough_reciprocal(z);
    return rough * (vf_set(2) - z * rough);
}

/* Sets the triangles' boxes, all of the picture for those that reach beside or behind the lamp; gives those that meet
 * the points' extent. */
static vbits lanes_place(const mesh_caster *c, const corners *t, lanes *out)
{
    const light *l = c->c.light;
    vf inf = vf_set(INFINITY), lu = inf, hu = -inf, lv = inf, hv = -inf;
    vf near = vf_min(t->depth[0], vf_min(t->depth[1], t->depth[2])),
       far = vf_max(t->depth[0], vf_max(t->depth[1], t->depth[2]));
    vf size = vf_set(c->size), lamp = vf_set(-l->away); /* corners are off by a few 2^-24 of it */
    for (int k = 0; k < 3; k++) {
        vf scale = l->sun ? vf_set(1) : box_reciprocal(t->p[k].z), u = t->p[k].x * scale, v = t->p[k].y * scale;
        lu = vf_min(u, lu), hu = vf_max(u, hu), lv = vf_min(v, lv), hv = vf_max(v, hv);
        size = vf_max(vf_abs(t->p[k].x) + vf_abs(t->p[k].y) + vf_abs(t->depth[k]), size);
    }
    vf wobble =
        l->sun ? size : size / (near - lamp) + vf_max(vf_max(vf_abs(lu), vf_abs(hu)), vf_max(vf_abs(lv), vf_abs(hv)));
    wobble = wobble * vf_set(0x1p-20f);
    vf off_u = wobble + vf_set(l->slack_u), off_v = wobble + vf_set(l->slack_v);
    vm whole = l->sun ? vm_from_bits(0) : vf_le(near - size * vf_set(0x1p-20f), lamp + vf_set(l->away * 0x1p-20f));
    lu = vf_select(whole, -inf, lu - off_u), hu = vf_select(whole, inf, hu + off_u);
    lv = vf_select(whole, -inf, lv - off_v), hv = vf_select(whole, inf, hv + off_v);
    near = near - size * vf_set(0x1p-20f) - vf_set((fabsf(l->near) + fabsf(l->far)) * 0x1p-20f);
    vm in = vm_and(vm_and(vf_le(vf_set(l->low_u), hu), vf_le(lu, vf_set(l->high_u))),
                   vm_and(vf_le(vf_set(l->low_v), hv), vf_le(lv, vf_set(l->high_v))));
    in = vm_and(in, vf_le(near, vf_set(l->far)));
    if (!l->sun) in = vm_and(in, vf_lt(lamp, far + size * vf_set(0x1p-20f)));
    if (vm_bits(vm_and(in, whole)))
        in = vm_and(in, vm_not(vm_and(whole, corners_outside(l, t, (size + vf_set(l->away)) * vf_set(0x1p-20f)))));
    vf_store(out->low_u, lu), vf_store(out->high_u, hu), vf_store(out->low_v, lv), vf_store(out->high_v, hv);
    vf_store(out->near, near);
    return vm_bits(in);
}

DAFT_INLINE void lanes_name(const leaf *const *leaves, lanes *out)
{
    const float *from[DAFT_VL / 4];
    for (int i = 0; i < DAFT_VL / 4; i++) from[i] = (const float *)leaves[i]->block->triangle;
    vf_store((float *)out->triangle, vf_load_fours(from));
}

DAFT_INLINE vf reach_of(vf3 a) { return vf_abs(a.x) + vf_abs(a.y) + vf_abs(a.z); }

/* The triangles' planes in light space, for passing over points that are surely before them. With u = 2^-24: points and
 * corners are off by 8u of `size`, and the plane through corners that are off is so, too; the product of edges is off by
 * 10u·|e|·|f|. Where the lamp is within that of the plane, nothing is sure. */
static void lanes_planes(const light *l, const corners *t, vf size, lanes *out)
{
    vf3 a = {t->p[0].x, t->p[0].y, t->depth[0]};
    vf3 e = {t->p[1].x - a.x, t->p[1].y - a.y, t->depth[1] - a.z}, f = {t->p[2].x - a.x, t->p[2].y - a.y, t->depth[2] - a.z};
    vf3 n = {e.y * f.z - e.z * f.y, e.z * f.x - e.x * f.z, e.x * f.y - e.y * f.x};
    vf edges = reach_of(e) + reach_of(f), across = reach_of(n), at = vf3_dot(n, a), wrong = edges * edges * vf_set(16 * UNIT);
    vf lamp = l->sun ? n.z : at + n.z * vf_set(l->away), off = wrong, far = size + vf_set(l->away);
    if (!l->sun) off = off * far + across * far * vf_set(32 * UNIT);
    vm sure = vf_lt(off, vf_abs(lamp));
    vi sign = (vi)lamp & vi_set((int32_t)0x80000000);
    vf_store(out->plane[0], vf_xor_sign(n.x, sign)), vf_store(out->plane[1], vf_xor_sign(n.y, sign));
    vf_store(out->plane[2], vf_xor_sign(n.z, sign));
    vf surface = vf_xor_sign(at, sign) - (across * size * vf_set(32 * UNIT) + wrong * edges);
    vf_store(out->surface, vf_select(sure, surface, vf_set(-INFINITY)));
}

/* `planes`: the triangles' own are asked for as well. */
DAFT_INLINE void lanes_setup(const mesh_caster *c, const corners *t, bool planes, lanes *out)
{
    const light *l = c->c.light;
    vf bound = vf_set(0), across = vf_set(0), along = vf_set(0), size = vf_set(c->size);
    vf dx = vf_set(l->max_x), dy = vf_set(l->max_y), dz = vf_set(l->max_z);
    for (int k = 0; k < 3; k++) {
        vf3 a = t->p[(k + 1) % 3], b = t->p[(k + 2) % 3];
        vf ez = l->sun ? vf_set(0) : t->depth[(k + 1) % 3] - t->depth[(k + 2) % 3];
        vf3 e = {a.x - b.x, a.y - b.y, ez}, s = {a.x + b.x, a.y + b.y, a.z + b.z};
        vf yz = e.y * s.z, zy = e.z * s.y, zx = e.z * s.x, xz = e.x * s.z, xy = e.x * s.y, yx = e.y * s.x;
        vf nx = yz - zy, ny = zx - xz, nz = xy - yx;
        vf_store(out->nx[k], nx), vf_store(out->ny[k], ny), vf_store(out->nz[k], nz);
        vf_store(out->depth[k], t->depth[k]);
        vf m = (vf_abs(yz) + vf_abs(zy)) * dx + (vf_abs(zx) + vf_abs(xz)) * dy + (vf_abs(xy) + vf_abs(yx)) * dz;
        bound = vf_max(bound, m), across = vf_max(across, vf_abs(nx) + vf_abs(ny)), along = vf_max(along, vf_abs(nz));
        size = vf_max(size, vf_abs(t->p[k].x) + vf_abs(t->p[k].y) + vf_abs(t->depth[k]));
    }
    bound = bound * vf_set(10 * UNIT) + vf_set(TINY); /* of which 2: z is rounded where the lamp's distance is added */
    /* Points and corners are rounded themselves. Neighbours agree on how, so this matters only for not passing over
     * what look_closely would find to stand between. */
    size = size + vf_set(l->size);
    if (planes) lanes_planes(l, t, size, out);
    vf wide = across * size;
    if (!l->sun) wide = wide + along * (size + vf_set(2 * l->max_z));
    wide = bound + wide * vf_set(8 * UNIT);
    vf low = vf_min(t->depth[0], vf_min(t->depth[1], t->depth[2])),
       high = vf_max(t->depth[0], vf_max(t->depth[1], t->depth[2]));
    vf_store(out->bound, bound);
    vf_store(out->wide, wide);
    vf_store(out->slack, vf_set(6) * wide * (high - low));
    vf_store(out->rounding, size * vf_set(0x1p-20f));
}

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

enum { FEW_POINTS = 24 }; /* where triangles are so much smaller than their distances that boxes of 16 say little */

/* Points by themselves, not in blocks; sets of them are bits. */
typedef struct few_points {
    uint32_t count;
    uint32_t live; /* those that are still lit */
    _Alignas(64) float u[FEW_POINTS + DAFT_VL], v[FEW_POINTS + DAFT_VL], depth[FEW_POINTS + DAFT_VL];
    uint32_t at[FEW_POINTS + DAFT_VL]; /* among the blocks' */
} few_points;

/* The lit points behind the box, of which it is known that they are few. */
static void few_take(const shadow_points *p, const picture_box *box, const block_set *from, few_points *out)
{
    uint32_t count = 0;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(from->bits); word++)
        for (uint64_t left = from->bits[word]; left; left &= left - 1) {
            uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left), in = points_behind(box, p, b);
            for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
                uint32_t at = b * SHADOW_BLOCK + k, some = in >> k & DAFT_ALL_LANES;
                vf_compress(&out->u[count], some, vf_load(&p->u[at])), vf_compress(&out->v[count], some, vf_load(&p->v[at]));
                vf_compress(&out->depth[count], some, vf_load(&p->depth[at]));
                vi_compress(&out->at[count], some, vi_iota() + vi_set((int32_t)at));
                count += (uint32_t)__builtin_popcount(some);
            }
        }
    out->count = count, out->live = (uint32_t)(((uint64_t)1 << count) - 1);
}

/* Those of `from` that lie behind the box. */
DAFT_INLINE uint32_t few_behind(const picture_box *box, const few_points *f, uint32_t from)
{
    uint32_t all = 0;
    for (uint32_t k = 0; k < f->count; k += DAFT_VL) {
        vf u = vf_load(&f->u[k]), v = vf_load(&f->v[k]);
        vm in = vm_and(vm_and(vf_le(vf_set(box->low_u), u), vf_le(u, vf_set(box->high_u))),
                       vm_and(vf_le(vf_set(box->low_v), v), vf_le(v, vf_set(box->high_v))));
        all |= vm_bits(vm_and(in, vf_le(vf_set(box->near), vf_load(&f->depth[k])))) << k;
    }
    return all & from;
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

/* A node's children that some of the points lie behind: nodes go on the stack, leaves to the list. No branch hangs on which. */
DAFT_INLINE void few_children(const mesh_caster *m, const few_entry *at, const few_points *f, few_entry *stack, int *top,
                              few_entry *leaves, uint32_t *leaf_count)
{
    node_boxes boxes;
    const daft_node *node = &m->c.instance->bvh->nodes.items[at->node];
    uint32_t child[DAFT_WIDTH], in = DAFT_KERNEL(daft_node_project)(m->c.light, &m->map, node, &boxes);
    uint32_t met = v8i_list(child, in, 0), from = at->behind & f->live;
    for (uint32_t k = 0; k < met; k++) {
        const picture_box box = node_child(&boxes, (int)child[k]);
        const few_entry next = {node->child[child[k]], few_behind(&box, f, from)};
        bool some = (next.behind != 0) & (next.node != DAFT_CHILD_NONE), ends = next.node >> 31;
        stack[*top] = next, leaves[*leaf_count] = next;
        *top += some & !ends, *leaf_count += some & ends;
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
    few_take(m->c.points, &at->box, &at->behind, &few);
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
        uint32_t in = DAFT_KERNEL(daft_node_project)(c->light, &m->map, node, &boxes);
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

void DAFT_KERNEL(daft_mesh_shadow)(const caster *c, const picture_box *box, const block_set *behind)
{
    mesh_caster m = {.c = *c};
    const daft_affine map = DAFT_KERNEL(daft_light_compose)(&c->light->map, &c->instance->to_frame, c->light->origin);
    m.map = picture_map_make(&map), m.size = m.map.still;
    walk(&m, box, behind);
}
