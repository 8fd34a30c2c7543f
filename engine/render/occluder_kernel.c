/* The shadow pencil's occluders: an instance's tree is walked with its nodes' boxes in the lamp's picture, down to
 * those that lie before lit points; the triangles found are moved to light space and set up DAFT_VL at a time, and each
 * is tested against the blocks of points whose boxes its own meets. Blocks in which all is dark meet nothing any more.
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

enum { LIST = 64 }; /* leaf blocks before their triangles are tested */

typedef struct caster {
    const light *light;
    const daft_lamp *lamp;
    const daft_batch *batch;
    const daft_instance *instance;
    uint32_t number; /* of the instance */
    bool convex, flat;
    float size; /* of the map's translation: what corners may lose beside their own coordinates */
    shadow_points *points;
    daft_affine map; /* object space to light space */
} caster;

daft_affine DAFT_KERNEL(daft_light_compose)(const daft_affine *a, const daft_affine *b, daft_vec3 origin)
{
    daft_affine out;
    for (int i = 0; i < 3; i++) {
        const float *row = &a->m[3 * i];
        for (int j = 0; j < 3; j++)
            out.m[3 * i + j] = (float)((double)row[0] * (double)b->m[j] + (double)row[1] * (double)b->m[3 + j] +
                                       (double)row[2] * (double)b->m[6 + j]);
        out.t[i] = (float)((double)row[0] * ((double)b->t[0] - (double)origin.x) +
                           (double)row[1] * ((double)b->t[1] - (double)origin.y) +
                           (double)row[2] * ((double)b->t[2] - (double)origin.z));
    }
    return out;
}

/* ---- boxes ---- */

typedef struct v8_range {
    v8 low, high;
} v8_range;

DAFT_INLINE void take_corner(v8_range *range, v8 value)
{
    range->low = v8_min(value, range->low);
    range->high = v8_max(value, range->high);
}

DAFT_INLINE v8_range widen_range(v8_range r, v8 off, v8 turn)
{
    v8 low = v8_max(r.low, -r.low), high = v8_max(r.high, -r.high);
    return (v8_range){r.low - off - turn * low, r.high + off + turn * high};
}

typedef struct v8_box {
    v8 centre[3], half[3][3]; /* light space; half[k][j]: along light axis k, what object axis j adds */
    v8 reach, off;            /* half its extent in depth; a bound of the rounding of all this */
} v8_box;

DAFT_INLINE v8_box box_move(const daft_affine *map, const daft_node *node)
{
    v8_box box;
    v8 scale = v8_set(0.5f), size = v8_set(0);
    for (int k = 0; k < 3; k++) {
        box.centre[k] = v8_set(map->t[k]);
        size = size + v8_set(fabsf(map->t[k]));
    }
    for (int j = 0; j < 3; j++) {
        v8 low = v8_load(node->bounds[j]), high = v8_load(node->bounds[3 + j]), c = (low + high) * scale,
           h = (high - low) * scale;
        v8 most = v8_max(c, -c) + h;
        for (int k = 0; k < 3; k++) {
            float m = map->m[3 * k + j];
            box.centre[k] = box.centre[k] + v8_set(m) * c;
            box.half[k][j] = v8_set(fabsf(m)) * h;
            if (m < 0) box.half[k][j] = -box.half[k][j];
            size = size + v8_set(fabsf(m)) * most;
        }
    }
    box.reach = v8_max(box.half[2][0], -box.half[2][0]) + v8_max(box.half[2][1], -box.half[2][1]) +
                v8_max(box.half[2][2], -box.half[2][2]);
    box.off = size * v8_set(0x1p-20f);
    return box;
}

/* The corners' projections: a box before the lamp projects into their hull. */
DAFT_INLINE void box_corners(const v8_box *b, float away, v8_range *u, v8_range *v)
{
    for (int i = 0; i < 8; i++) {
        v8 p[3];
        for (int k = 0; k < 3; k++) {
            p[k] = i & 1 ? b->centre[k] + b->half[k][0] : b->centre[k] - b->half[k][0];
            p[k] = i & 2 ? p[k] + b->half[k][1] : p[k] - b->half[k][1];
            p[k] = i & 4 ? p[k] + b->half[k][2] : p[k] - b->half[k][2];
        }
        v8 inverse = v8_set(1) / (p[2] + v8_set(away));
        take_corner(u, p[0] * inverse);
        take_corner(v, p[1] * inverse);
    }
}

DAFT_INLINE v8_range box_extent(const v8_box *b, int k)
{
    v8 half = v8_max(b->half[k][0], -b->half[k][0]) + v8_max(b->half[k][1], -b->half[k][1]) +
              v8_max(b->half[k][2], -b->half[k][2]);
    return (v8_range){b->centre[k] - half, b->centre[k] + half};
}

/* Bits of the boxes that lie on the outer side of x = u·z (axis 0) or y = v·z (axis 1), `side` being -1 or 1. This says
 * something, too, of boxes that reach beside or behind the lamp. */
DAFT_INLINE uint32_t beyond_side(const v8_box *b, float away, int axis, float edge, float side)
{
    v8 slope = v8_set(edge), middle = (b->centre[axis] - slope * (b->centre[2] + v8_set(away))) * v8_set(side);
    v8 half = b->off * v8_set(1 + fabsf(edge)) + v8_set(away * fabsf(edge) * 0x1p-22f);
    for (int j = 0; j < 3; j++) {
        v8 h = b->half[axis][j] - slope * b->half[2][j];
        half = half + v8_max(h, -h);
    }
    return ~v8_le_bits(middle, half);
}

uint32_t DAFT_KERNEL(daft_node_project)(const light *l, const daft_affine *map, const daft_node *node, node_boxes *out)
{
    const v8 inf = v8_set(INFINITY), zero = v8_set(0);
    v8_box box = box_move(map, node);
    box.off = box.off + v8_set((fabsf(l->near) + fabsf(l->far)) * 0x1p-20f);
    v8 near = box.centre[2] - box.reach - box.off, far = box.centre[2] + box.reach + box.off;
    v8_range u = {inf, -inf}, v = u;
    uint32_t in = v8_le_bits(near, v8_set(l->far)), beside = 0, everywhere = 0;
    if (l->sun) {
        u = widen_range(box_extent(&box, 0), box.off, zero), v = widen_range(box_extent(&box, 1), box.off, zero);
    } else {
        const v8 lamp = v8_set(-l->away), rounding = v8_set(l->away * 0x1p-22f);
        in &= v8_le_bits(lamp, far + rounding);
        beside = v8_le_bits(near - rounding, lamp);
        everywhere = in & beside; /* it reaches beside or behind the lamp */
        if (everywhere)
            everywhere &= ~(beyond_side(&box, l->away, 0, l->high_u + l->slack_u, 1) |
                            beyond_side(&box, l->away, 0, l->low_u - l->slack_u, -1) |
                            beyond_side(&box, l->away, 1, l->high_v + l->slack_v, 1) |
                            beyond_side(&box, l->away, 1, l->low_v - l->slack_v, -1));
        box_corners(&box, l->away, &u, &v);
        v8 inverse = v8_set(1) / (near - lamp), off = box.off * inverse, turn = (box.off + rounding) * inverse;
        u = widen_range(u, off, turn), v = widen_range(v, off, turn);
    }
    uint32_t meet =
        v8_le_bits(u.low, v8_set(l->high_u + l->slack_u)) & v8_le_bits(v8_set(l->low_u - l->slack_u), u.high) &
        v8_le_bits(v.low, v8_set(l->high_v + l->slack_v)) & v8_le_bits(v8_set(l->low_v - l->slack_v), v.high);
    in &= (meet & ~beside) | everywhere;
    v8_store(out->low_u, u.low - v8_set(l->slack_u)), v8_store(out->high_u, u.high + v8_set(l->slack_u));
    v8_store(out->low_v, v.low - v8_set(l->slack_v)), v8_store(out->high_v, v.high + v8_set(l->slack_v));
    v8_store(out->near, near);
    for (; everywhere; everywhere &= everywhere - 1) {
        int i = __builtin_ctz(everywhere);
        out->low_u[i] = out->low_v[i] = -INFINITY, out->high_u[i] = out->high_v[i] = INFINITY;
    }
    return in;
}

/* ---- triangles ---- */

/* Leaf blocks, waiting to be tested against the points behind their leaf's box. */
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

/* Triangles set up: edges' planes, corners' depths, and their boxes in the picture. */
typedef struct lanes {
    float nx[3][DAFT_VL], ny[3][DAFT_VL], nz[3][DAFT_VL], depth[3][DAFT_VL];
    float bound[DAFT_VL], wide[DAFT_VL], slack[DAFT_VL], rounding[DAFT_VL];
    float low_u[DAFT_VL], high_u[DAFT_VL], low_v[DAFT_VL], high_v[DAFT_VL], near[DAFT_VL];
} lanes;

typedef struct corners {
    vf3 p[3]; /* x, y, z of the test */
    vf depth[3];
} corners;

DAFT_INLINE corners corners_move(const caster *c, const leaf *const *leaves)
{
    corners out;
    for (int k = 0; k < 3; k++) {
        vf3 p = {blocks_load(leaves, k, 0), blocks_load(leaves, k, 1), blocks_load(leaves, k, 2)};
        out.depth[k] = row(&c->map, 2, p);
        out.p[k] = (vf3){row(&c->map, 0, p), row(&c->map, 1, p),
                         c->light->sun ? vf_set(1) : out.depth[k] + vf_set(c->light->away)};
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

/* Sets the triangles' boxes, all of the picture for those that reach beside or behind the lamp; gives those that meet
 * the points' extent. */
static vbits lanes_place(const caster *c, const corners *t, lanes *out)
{
    const light *l = c->light;
    vf inf = vf_set(INFINITY), lu = inf, hu = -inf, lv = inf, hv = -inf;
    vf near = vf_min(t->depth[0], vf_min(t->depth[1], t->depth[2])),
       far = vf_max(t->depth[0], vf_max(t->depth[1], t->depth[2]));
    vf size = vf_set(c->size), lamp = vf_set(-l->away); /* corners are off by a few 2^-24 of it */
    for (int k = 0; k < 3; k++) {
        vf scale = l->sun ? vf_set(1) : vf_set(1) / t->p[k].z, u = t->p[k].x * scale, v = t->p[k].y * scale;
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

static void lanes_setup(const caster *c, const corners *t, lanes *out)
{
    const light *l = c->light;
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

/* From a point to the lamp, in double; a sun is one length of its direction away, and counts from there on. */
typedef struct way {
    daft_dvec3 from, direction;
    bool endless;
} way;

static daft_vec3 lane3(const daft_lanes3 *a, uint32_t i)
{
    return daft_v3(a->x[i], a->y[i], a->z[i]);
}

static way way_to(const daft_batch *b, const daft_lamp *lamp, uint32_t i)
{
    daft_dvec3 from = daft_to_double(lane3(&b->lifted, i));
    return (way){from, lamp->sun ? daft_to_double(lamp->to_light) : daft_dsub(daft_to_double(lamp->position), from),
                 lamp->sun};
}

static bool on_way(const way *w, double t)
{
    return t > 0 && (w->endless || t < 1);
}

/* A multiple of a × b that is negated, bit for bit, where a and b are exchanged. */
static double edge_side(daft_dvec3 a, daft_dvec3 b, daft_dvec3 d)
{
    return daft_ddot(daft_dcross(daft_dsub(a, b), daft_dadd(a, b)), d);
}

/* Whether the triangle, closed, stands between the point and the lamp, by frame space's own numbers. */
static bool stands_between(const caster *c, const daft_block *block, int lane, uint32_t point)
{
    way w = way_to(c->batch, c->lamp, point);
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
    if (along == 0 || !on_way(&w, daft_ddot(normal, q[0]) / along)) return false;
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

/* The lanes whose point lies on this very triangle, or on this convex thing. */
DAFT_INLINE vbits lie_on(const caster *c, uint32_t triangle, uint32_t first)
{
    vm on = vi_eq(vi_load(&c->points->instance[first]), vi_set((int32_t)c->number));
    if (c->convex) return vm_bits(on);
    vi own = vi_load(&c->points->own[first]);
    if (c->flat) return vm_bits(on) & ~vm_bits(vi_eq(own, vi_set((int32_t)DAFT_NO_TRIANGLE)));
    return vm_bits(on) & vm_bits(vi_eq(own, vi_set((int32_t)triangle)));
}

/* Takes the block out of what is looked at when its last point has gone dark. */
static __attribute__((noinline)) void block_darkened(shadow_points *p, uint32_t b)
{
    vf most = vf_set(-INFINITY);
    for (uint32_t i = 0; i < SHADOW_BLOCK; i += DAFT_VL) most = vf_max(most, vf_load(&p->depth[b * SHADOW_BLOCK + i]));
    if (vf_reduce_max(most) > -INFINITY || p->low_u[b] > p->high_u[b]) return;
    p->low_u[b] = INFINITY, p->high_u[b] = -INFINITY;
    p->live--;
}

/* A set-up triangle, spread over lanes. */
typedef struct spread {
    vf nx[3], ny[3], nz[3], depth[3];
    vf bound, wide, slack, rounding, behind;
} spread;

DAFT_INLINE spread lane_spread(const caster *c, const lanes *t, int i)
{
    spread s;
    for (int k = 0; k < 3; k++) {
        s.nx[k] = vf_set(t->nx[k][i]), s.ny[k] = vf_set(t->ny[k][i]), s.nz[k] = vf_set(t->nz[k][i]);
        s.depth[k] = vf_set(t->depth[k][i]);
    }
    s.bound = vf_set(t->bound[i]), s.wide = vf_set(t->wide[i]), s.slack = vf_set(t->slack[i]);
    s.rounding = vf_set(t->rounding[i]);
    s.behind = c->light->sun ? vf_set(-INFINITY)
                             : s.rounding - vf_set(c->light->away * (1 - 0x1p-20f)); /* not beyond the lamp */
    return s;
}

/* Puts the points of a block that the triangle shadows to depth -inf. An overflow gives NaN, which is in front of
 * nothing. */
DAFT_INLINE void test_block(const caster *c, const spread *t, const daft_block *block, int lane, uint32_t b)
{
    shadow_points *p = c->points;
    vbits changed = 0;
    for (uint32_t k = b * SHADOW_BLOCK; k < (b + 1) * SHADOW_BLOCK; k += DAFT_VL) {
        vf x = vf_load(&p->x[k]), y = vf_load(&p->y[k]), z = vf_load(&p->z[k]), limit = vf_load(&p->depth[k]);
        vf e0 = t->nx[0] * x + t->ny[0] * y + t->nz[0] * z, e1 = t->nx[1] * x + t->ny[1] * y + t->nz[1] * z,
           e2 = t->nx[2] * x + t->ny[2] * y + t->nz[2] * z;
        vf least = vf_min(e0, vf_min(e1, e2)), most = vf_max(e0, vf_max(e1, e2));
        vm side = vm_and(vm_or(vf_le(-t->wide, least), vf_le(most, t->wide)), vf_lt(vf_set(-INFINITY), limit));
        vbits hits = vm_bits(side);
        if (!hits) continue;
        vm sure = vm_or(vf_le(-t->bound, least), vf_le(most, t->bound));
        vf inverse = vf_set(1) / (e0 + e1 + e2),
           depth = (e0 * t->depth[0] + e1 * t->depth[1] + e2 * t->depth[2]) * inverse;
        vf error = vf_abs(t->slack * inverse) + t->rounding;
        vm dark = vm_and(vm_and(side, sure), vm_and(vf_lt(depth + error, limit), vf_lt(t->behind, depth)));
        vf_store(&p->depth[k], vf_select(dark, vf_set(-INFINITY), limit));
        vbits doubt = hits & vm_bits(vf_lt(depth - error, limit)) & ~vm_bits(dark);
        if (doubt) doubt &= ~lie_on(c, block->triangle[lane], k);
        if (doubt) look_closely(c, block, lane, k, doubt);
        changed |= vm_bits(dark) | doubt;
    }
    if (changed) block_darkened(p, b);
}

static void test_lane(const caster *c, const lanes *t, int i, const leaf *from, const block_set *behind)
{
    spread s = lane_spread(c, t, i);
    for (uint32_t word = 0; word < SHADOW_SET_WORDS; word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1)
            test_block(c, &s, from->block, i % DAFT_BLOCK, word * 64 + (uint32_t)__builtin_ctzll(left));
}

static void test_leaves(const caster *c, const leaf *const *leaves, vbits used)
{
    lanes t;
    bool ready = false;
    corners moved = corners_move(c, leaves);
    for (vbits live = lanes_place(c, &moved, &t) & used; live; live &= live - 1) {
        int i = __builtin_ctz(live);
        const leaf *from = leaves[i / DAFT_BLOCK];
        const picture_box box = {t.low_u[i], t.high_u[i], t.low_v[i], t.high_v[i], t.near[i]};
        block_set behind;
        if (!blocks_narrow(&box, c->points, &from->behind, &behind)) continue;
        if (!ready) lanes_setup(c, &moved, &t);
        ready = true;
        test_lane(c, &t, i, from, &behind);
    }
}

/* ---- trees ---- */

static void flush(const caster *c, const leaf *list, uint32_t count)
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
        test_leaves(c, leaves, used);
    }
}

typedef struct entry {
    uint32_t node;
    block_set behind;
} entry;

static void walk(const caster *c, const daft_bvh *bvh, const block_set *behind)
{
    entry stack[DAFT_STACK];
    leaf list[LIST + DAFT_MAX_LEAF_BLOCKS];
    uint32_t count = 0;
    int top = 0;
    stack[top++] = (entry){0, *behind};
    while (top > 0 && c->points->live) {
        node_boxes boxes;
        const entry at = stack[--top];
        const daft_node *node = &bvh->nodes.items[at.node];
        for (uint32_t in = DAFT_KERNEL(daft_node_project)(c->light, &c->map, node, &boxes); in; in &= in - 1) {
            int i = __builtin_ctz(in);
            uint32_t child = node->child[i];
            picture_box box = node_child(&boxes, i);
            entry next;
            if (child == DAFT_CHILD_NONE || !blocks_narrow(&box, c->points, &at.behind, &next.behind)) continue;
            if (!(child & DAFT_CHILD_LEAF)) {
                next.node = child;
                stack[top++] = next;
                continue;
            }
            const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t k = 0; k <= (child & 3); k++) list[count++] = (leaf){&block[k], next.behind};
            if (count < LIST) continue;
            flush(c, list, count);
            count = 0;
        }
    }
    flush(c, list, count);
}

/* ---- spheres ---- */

/* Whether the sphere's surface lies between the point and the lamp, in double. */
static bool ball_between(const daft_instance *s, const way *w)
{
    const float *at = s->to_frame.t;
    daft_dvec3 centre = daft_dsub(daft_dv3((double)at[0], (double)at[1], (double)at[2]), w->from);
    double dd = daft_ddot(w->direction, w->direction), along = daft_ddot(centre, w->direction) / dd,
           r = (double)s->radius;
    daft_dvec3 aside = daft_dsub(centre, daft_dscale(w->direction, along));
    double square = r * r - daft_ddot(aside, aside);
    if (!(square > 0)) return false;
    double half = sqrt(square / dd);
    return on_way(w, along - half) || on_way(w, along + half);
}

/* A sphere is a surface: with the lamp within, it is its far side that may stand between. The bound of the
 * discriminant's error is that of raster/tile_kernel.c. */
typedef struct ball {
    vf cx, cy, cz;          /* light space */
    vf square, blur, error; /* radius squared; |error(discriminant)|; of depths */
} ball;

static ball ball_setup(const caster *c)
{
    const float *at = c->map.t;
    float r = c->instance->radius, reach = fabsf(at[0]) + fabsf(at[1]) + fabsf(at[2]) + r + c->light->size;
    return (ball){
        vf_set(at[0]),           vf_set(at[1]), vf_set(at[2]), vf_set(r * r), vf_set(32 * UNIT * reach * reach),
        vf_set(reach * 0x1p-19f)};
}

static void ball_block(const caster *c, const ball *s, uint32_t b)
{
    shadow_points *p = c->points;
    bool sun = c->light->sun;
    vf zero = vf_set(0), none = vf_set(-INFINITY), lamp = vf_set(-c->light->away);
    for (uint32_t k = b * SHADOW_BLOCK; k < (b + 1) * SHADOW_BLOCK; k += DAFT_VL) {
        vf limit = vf_load(&p->depth[k]), depth = vf_max(limit, vf_set(-0x1p100f)), disc, middle, scale = vf_set(1);
        vf3 m = {s->cx - vf_load(&p->x[k]), s->cy - vf_load(&p->y[k]),
                 s->cz - depth}; /* from the point to the centre */
        if (sun) {
            disc = s->square - (m.x * m.x + m.y * m.y), middle = s->cz;
        } else {
            vf3 d = {vf_load(&p->x[k]), vf_load(&p->y[k]), vf_load(&p->z[k])};
            vf dd = vf3_dot(d, d), along = vf3_dot(m, d) / dd;
            vf3 aside = {m.x - d.x * along, m.y - d.y * along, m.z - d.z * along};
            disc = s->square - vf3_dot(aside, aside), middle = depth + along * d.z, scale = d.z / vf_sqrt(dd);
        }
        vf half = vf_sqrt(vf_max(disc, zero)) * scale, near = middle - half, far = middle + half;
        vf error = s->error + vf_set(2) * s->blur / vf_max(half, vf_sqrt(s->blur)); /* the last: of the root */
        vm met = vm_and(vf_lt(-s->blur, disc), vf_lt(none, limit));
        if (c->convex) met = vm_and(met, vm_not(vi_eq(vi_load(&p->instance[k]), vi_set((int32_t)c->number))));
        vm dark = vm_and(vm_and(met, vf_lt(s->blur, disc)), vf_lt(near + error, limit)),
           apart = vf_lt(limit + error, near);
        if (!sun) {
            error = error + vf_set(c->light->away * 0x1p-20f);
            dark = vm_and(dark, vf_lt(lamp + error, near));
            apart = vm_or(
                apart, vm_or(vf_lt(far, lamp - error), vm_and(vf_lt(near, lamp - error), vf_lt(limit + error, far))));
        }
        vf_store(&p->depth[k], vf_select(dark, none, limit));
        for (vbits doubt = vm_bits(met) & ~vm_bits(vm_or(dark, apart)); doubt; doubt &= doubt - 1) {
            uint32_t i = k + (uint32_t)__builtin_ctz(doubt);
            way w = way_to(c->batch, c->lamp, p->source[i]);
            if (ball_between(c->instance, &w)) p->depth[i] = -INFINITY;
        }
    }
    block_darkened(p, b);
}

static void test_sphere(const caster *c, const block_set *behind)
{
    const ball s = ball_setup(c);
    for (uint32_t word = 0; word < SHADOW_SET_WORDS; word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1)
            ball_block(c, &s, word * 64 + (uint32_t)__builtin_ctzll(left));
}

void DAFT_KERNEL(daft_cast_shadow)(const light *l, const daft_lamp *lamp, const daft_batch *batch,
                                   const daft_instance *instance, uint32_t number, const block_set *behind,
                                   shadow_points *points)
{
    caster c = {.light = l, .lamp = lamp, .batch = batch, .instance = instance, .number = number, .points = points};
    c.convex = instance->flags & DAFT_INSTANCE_CONVEX, c.flat = is_flat(instance);
    c.map = DAFT_KERNEL(daft_light_compose)(&l->map, &instance->to_frame, l->origin);
    c.size = fabsf(c.map.t[0]) + fabsf(c.map.t[1]) + fabsf(c.map.t[2]);
    if (instance->mesh)
        walk(&c, instance->bvh, behind);
    else
        test_sphere(&c, behind);
}
