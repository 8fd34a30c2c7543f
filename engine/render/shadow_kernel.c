/* Shadow pencils: the rays from a tile's points to one lamp share their far end, so seen from the lamp they are a pencil, and
 * the tile is its picture. Its points are moved to light space and put into a small grid over their own extent, so the
 * grid's resolution follows their density whatever the lamp's place; the trees of the things in between are walked with
 * the pencil's sides; and each triangle found is tested, DAFT_VL points at a time, against the points of the cells that it
 * may cover.
 *
 * Light space. Point lamp: origin at the lamp, z towards the middle of the points; a point's ray is (x, y, z) and its depth
 * is z. Sun: x and y across the light, relative to the middle of the points; the ray is (x, y, 1) and the depth is measured
 * along the light. One edge test serves both: n = (a - b) × (a + b), e = n·ray, with the bound of raster/tile_kernel.c.
 *
 * A point is in shadow when no edge has it surely outside and the triangle is surely nearer to the lamp. Depths are off by
 * some 2^-18 of the way to the lamp, which is much where it is far: triangles whose depth is that close to the point's are
 * decided again, in double, from the point and the corners in frame space, where they are off only by the spawn error, and
 * the point was put off its surface by more than that. A point's own triangle is left out, unless it faces away from the
 * lamp, as the smooth inside of a vessel may. So no light leaks between triangles or through the walls of a corner, and a
 * surface does not shadow itself by rounding. */
#include "accel/bvh.h"
#include "math/simd.h"
#include "render/kernels.h"

#define UNIT 0x1p-24f
#define TINY 1e-36f

enum { GRID = 8, CELLS = GRID * GRID, BLOCK_LIST = 64, PLANES = 5 };

typedef struct light {
    bool sun;
    daft_affine map;                     /* frame space to light space */
    float low_u, low_v, high_u, high_v;  /* of the points: x, y over z */
    float cell_u, cell_v;                /* cells a unit */
    float slack_u, slack_v;              /* over the rounding of projected coordinates */
    float near, far;                     /* depths of the points */
    float max_x, max_y, max_z;           /* magnitudes of the rays' components */
} light;

typedef struct cells {
    uint32_t count;
    float x[DAFT_BATCH_ROOM], y[DAFT_BATCH_ROOM], z[DAFT_BATCH_ROOM], depth[DAFT_BATCH_ROOM]; /* -inf: in shadow */
    uint32_t source[DAFT_BATCH_ROOM];
    uint32_t instance[DAFT_BATCH_ROOM], own[DAFT_BATCH_ROOM]; /* the triangle that a point lies on and that cannot shadow
                                                               * it, or DAFT_NO_TRIANGLE */
    uint32_t start[CELLS + 1]; /* cells are rows of GRID, so a run of cells is a run of points */
} cells;

/* ---- light space ---- */

static void light_axes(daft_vec3 z, daft_vec3 *x, daft_vec3 *y)
{
    daft_vec3 least = fabsf(z.y) < 0.7f ? daft_v3(0, 1, 0) : daft_v3(1, 0, 0);
    *x = daft_normalize(daft_cross(z, least));
    *y = daft_cross(*x, z);
}

static daft_vec3 middle_of(const daft_batch *b, const uint32_t *bits)
{
    daft_vec3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < b->count; i++) {
        if (!(bits[i / 32] >> (i % 32) & 1)) continue;
        daft_vec3 p = {b->lifted.x[i], b->lifted.y[i], b->lifted.z[i]};
        low = daft_min3(low, p), high = daft_max3(high, p);
    }
    return daft_scale(daft_add(low, high), 0.5f);
}

static void light_setup(light *l, const daft_batch *b, const daft_lamp *lamp, const uint32_t *bits)
{
    daft_vec3 middle = middle_of(b, bits), x, y;
    daft_vec3 z = lamp->sun ? daft_neg(lamp->to_light) : daft_normalize(daft_sub(middle, lamp->position));
    daft_vec3 origin = lamp->sun ? middle : lamp->position;
    light_axes(z, &x, &y);
    l->sun = lamp->sun;
    l->map = (daft_affine){{x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z},
                           {-daft_dot(x, origin), -daft_dot(y, origin), -daft_dot(z, origin)}};
}

/* The points whose bits are set, in light space: moved by differences, so that far from the frame's origin as much of their
 * precision is left as they have. */
static void move_points(const light *l, const daft_batch *b, daft_vec3 origin, const uint32_t *bits, cells *out)
{
    const float *m = l->map.m;
    out->count = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        if (!(bits[i / 32] >> (i % 32) & 1)) continue;
        uint32_t at = out->count++;
        daft_vec3 p = daft_sub(daft_v3(b->lifted.x[i], b->lifted.y[i], b->lifted.z[i]), origin);
        float z = m[6] * p.x + m[7] * p.y + m[8] * p.z;
        out->x[at] = m[0] * p.x + m[1] * p.y + m[2] * p.z;
        out->y[at] = m[3] * p.x + m[4] * p.y + m[5] * p.z;
        out->z[at] = l->sun ? 1 : z;
        out->depth[at] = z;
        out->source[at] = i;
    }
}

static float widen(float low, float high) { return (high - low) * 1e-5f + (fabsf(low) + fabsf(high)) * 0x1p-20f + TINY; }

/* The extent of the points. False: some lie beside or behind the lamp, and no picture plane holds them all. */
static bool measure(light *l, const cells *c)
{
    vf lu = vf_set(INFINITY), lv = lu, ld = lu, hu = -lu, hv = -lu, hd = -lu, ax = vf_set(0), ay = ax, az = ax;
    for (uint32_t i = 0; i < c->count; i += DAFT_VL) {
        vm used = vm_from_bits(vbits_first((int)(c->count - i)));
        vf x = vf_load(&c->x[i]), y = vf_load(&c->y[i]), z = vf_load(&c->z[i]), d = vf_load(&c->depth[i]);
        vf u = x / z, v = y / z;
        lu = vf_select(used, vf_min(lu, u), lu), hu = vf_select(used, vf_max(hu, u), hu);
        lv = vf_select(used, vf_min(lv, v), lv), hv = vf_select(used, vf_max(hv, v), hv);
        ld = vf_select(used, vf_min(ld, d), ld), hd = vf_select(used, vf_max(hd, d), hd);
        ax = vf_select(used, vf_max(ax, vf_abs(x)), ax), ay = vf_select(used, vf_max(ay, vf_abs(y)), ay);
        az = vf_select(used, vf_max(az, vf_abs(z)), az);
    }
    l->low_u = vf_reduce_min(lu), l->high_u = vf_reduce_max(hu), l->low_v = vf_reduce_min(lv), l->high_v = vf_reduce_max(hv);
    l->near = vf_reduce_min(ld), l->far = vf_reduce_max(hd);
    l->max_x = vf_reduce_max(ax), l->max_y = vf_reduce_max(ay), l->max_z = vf_reduce_max(az);
    l->slack_u = widen(l->low_u, l->high_u), l->slack_v = widen(l->low_v, l->high_v);
    if (!l->sun) { /* x, y and z are off by a few 2^-24 of the largest of them */
        float off = (l->max_x + l->max_y + l->max_z) / l->near * 0x1p-21f;
        l->slack_u += off, l->slack_v += off;
    }
    l->cell_u = GRID * 0.999f / (l->high_u - l->low_u + TINY), l->cell_v = GRID * 0.999f / (l->high_v - l->low_v + TINY);
    return l->sun || (l->near > 0 && fmaxf(l->max_x, l->max_y) < 8 * l->near);
}

static daft_affine compose(const daft_affine *a, const daft_affine *b, daft_vec3 origin)
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

/* ---- which points lie under a candidate's bounds ---- */

typedef struct shade_box {
    float low[3], high[3]; /* u, v, depth */
    bool everywhere;       /* it reaches beside or behind the lamp */
} shade_box;

static shade_box project_bound(const light *l, const daft_instance *c, daft_vec3 origin)
{
    shade_box out = {.everywhere = false};
    const float lo[3] = {c->low.x - origin.x, c->low.y - origin.y, c->low.z - origin.z};
    const float hi[3] = {c->high.x - origin.x, c->high.y - origin.y, c->high.z - origin.z};
    for (int k = 0; k < 3; k++) {
        float centre = 0, half = 0;
        for (int j = 0; j < 3; j++) {
            float m = l->map.m[3 * k + j];
            centre += m * (lo[j] + hi[j]) * 0.5f;
            half += fabsf(m) * ((hi[j] - lo[j]) * 0.5f + (fabsf(lo[j]) + fabsf(hi[j])) * 0x1p-21f);
        }
        out.low[k] = centre - half, out.high[k] = centre + half;
    }
    if (l->sun) return out;
    out.everywhere = !(out.low[2] > 0);
    for (int k = 0; k < 2 && !out.everywhere; k++) {
        out.low[k] /= out.low[k] < 0 ? out.low[2] : out.high[2];
        out.high[k] /= out.high[k] < 0 ? out.high[2] : out.low[2];
    }
    return out;
}

/* Marks the points under the bound; gives whether there is one. A convex thing does not shadow its own points. */
static bool mark_under(const light *l, const daft_batch *b, const daft_instance *c, uint32_t number, daft_vec3 origin,
                       const cells *points, uint8_t *under)
{
    shade_box box = project_bound(l, c, origin);
    bool any = false, convex = c->flags & DAFT_INSTANCE_CONVEX;
    vf lu = vf_set(box.low[0] - l->slack_u), hu = vf_set(box.high[0] + l->slack_u);
    vf lv = vf_set(box.low[1] - l->slack_v), hv = vf_set(box.high[1] + l->slack_v), near = vf_set(box.low[2]);
    for (uint32_t i = 0; i < points->count; i += DAFT_VL) {
        vf z = vf_load(&points->z[i]), u = vf_load(&points->x[i]) / z, v = vf_load(&points->y[i]) / z;
        vbits in = vm_bits(vm_and(vm_and(vf_le(lu, u), vf_le(u, hu)), vm_and(vf_le(lv, v), vf_le(v, hv))));
        if (box.everywhere) in = DAFT_ALL_LANES;
        in &= vm_bits(vf_le(near, vf_load(&points->depth[i]))) & vbits_first((int)(points->count - i));
        for (; in; in &= in - 1) {
            uint32_t at = i + (uint32_t)__builtin_ctz(in);
            if (convex && b->instance[points->source[at]] == number) continue;
            under[at] = 1;
            any = true;
        }
    }
    return any;
}

/* ---- the grid ---- */

static uint32_t cell_of(const light *l, float x, float y, float z)
{
    int u = (int)((x / z - l->low_u) * l->cell_u), v = (int)((y / z - l->low_v) * l->cell_v);
    u = u < 0 ? 0 : u >= GRID ? GRID - 1 : u;
    v = v < 0 ? 0 : v >= GRID ? GRID - 1 : v;
    return (uint32_t)(v * GRID + u);
}

static daft_vec3 lane3(const daft_lanes3 *a, uint32_t i) { return daft_v3(a->x[i], a->y[i], a->z[i]); }

static uint32_t own_triangle(const daft_batch *b, const daft_lamp *lamp, uint32_t i)
{
    daft_vec3 way = lamp->sun ? lamp->to_light : daft_sub(lamp->position, lane3(&b->lifted, i));
    return daft_dot(lane3(&b->outward, i), way) > 0 ? b->triangle[i] : DAFT_NO_TRIANGLE;
}

/* Counting sort of the marked points into cells. */
static void fill_cells(const light *l, const daft_batch *b, const daft_lamp *lamp, const cells *from, const uint8_t *under,
                       cells *to)
{
    uint8_t cell[DAFT_BATCH_ROOM];
    uint32_t next[CELLS] = {0}, sum = 0;
    for (uint32_t i = 0; i < from->count; i++) {
        if (!under[i]) continue;
        cell[i] = (uint8_t)cell_of(l, from->x[i], from->y[i], from->z[i]);
        next[cell[i]]++;
    }
    for (int c = 0; c < CELLS; c++) {
        to->start[c] = sum;
        sum += next[c];
        next[c] = to->start[c];
    }
    to->start[CELLS] = to->count = sum;
    for (uint32_t i = 0; i < from->count; i++) {
        if (!under[i]) continue;
        uint32_t at = next[cell[i]]++;
        to->x[at] = from->x[i], to->y[at] = from->y[i], to->z[at] = from->z[i], to->depth[at] = from->depth[i];
        to->source[at] = from->source[i];
        to->instance[at] = b->instance[from->source[i]];
        to->own[at] = own_triangle(b, lamp, from->source[i]);
    }
}

/* ---- triangles ---- */

typedef struct caster {
    const light *light;
    const daft_lamp *lamp;
    const daft_batch *batch;
    const daft_instance *instance;
    uint32_t number; /* of the instance */
    cells *points;
    daft_affine map; /* object space to light space */
    float plane[PLANES][4];
} caster;

DAFT_INLINE vf blocks_load(const daft_block *const *b, int corner, int axis)
{
    union {
        v4 part[DAFT_VL / 4];
        vf whole;
    } lanes;
    for (int i = 0; i < DAFT_VL / 4; i++) lanes.part[i] = v4_load(b[i]->corner[corner][axis]);
    return lanes.whole;
}

DAFT_INLINE vf row(const daft_affine *a, int k, vf3 p)
{
    return ((vf_set(a->m[3 * k]) * p.x + vf_set(a->m[3 * k + 1]) * p.y) + vf_set(a->m[3 * k + 2]) * p.z) + vf_set(a->t[k]);
}

typedef struct lanes {
    float nx[3][DAFT_VL], ny[3][DAFT_VL], nz[3][DAFT_VL], depth[3][DAFT_VL];
    float bound[DAFT_VL], wide[DAFT_VL], slack[DAFT_VL], rounding[DAFT_VL];
    int32_t u0[DAFT_VL], u1[DAFT_VL], v0[DAFT_VL], v1[DAFT_VL]; /* cells, inclusive */
} lanes;

typedef struct corners {
    vf3 p[3];    /* x, y, z of the test */
    vf depth[3];
} corners;

DAFT_INLINE corners corners_move(const caster *c, const daft_block *const *blocks)
{
    corners out;
    for (int k = 0; k < 3; k++) {
        vf3 p = {blocks_load(blocks, k, 0), blocks_load(blocks, k, 1), blocks_load(blocks, k, 2)};
        out.depth[k] = row(&c->map, 2, p);
        out.p[k] = (vf3){row(&c->map, 0, p), row(&c->map, 1, p), c->light->sun ? vf_set(1) : out.depth[k]};
    }
    return out;
}

/* Cells along one axis; all of them for triangles that reach beside or behind the lamp. */
DAFT_INLINE vm cell_span(vf low, vf high, vm whole, float first, float scale, float slack, int32_t *from, int32_t *to)
{
    vf a = (low - vf_set(slack) - vf_set(first)) * vf_set(scale), b = (high + vf_set(slack) - vf_set(first)) * vf_set(scale);
    vf zero = vf_set(0), last = vf_set(GRID - 1);
    a = vf_select(whole, zero, a), b = vf_select(whole, last, b);
    vi_store(from, vi_truncate(vf_min(vf_max(a, zero), last)));
    vi_store(to, vi_truncate(vf_min(vf_max(b, zero), last)));
    return vm_and(vf_le(zero, b), vf_le(a, vf_set(GRID)));
}

static vbits lanes_place(const caster *c, const corners *t, lanes *out)
{
    const light *l = c->light;
    vf zero = vf_set(0), inf = vf_set(INFINITY), lu = inf, hu = -inf, lv = inf, hv = -inf;
    vf near = vf_min(t->depth[0], vf_min(t->depth[1], t->depth[2])), far = vf_max(t->depth[0], vf_max(t->depth[1], t->depth[2]));
    vf size = vf_set(0); /* corners are off by a few 2^-24 of it, in units of the points' coordinates */
    for (int k = 0; k < 3; k++) {
        vf u = t->p[k].x / t->p[k].z, v = t->p[k].y / t->p[k].z;
        lu = vf_min(u, lu), hu = vf_max(u, hu), lv = vf_min(v, lv), hv = vf_max(v, hv);
        size = vf_max(vf_abs(t->p[k].x) + vf_abs(t->p[k].y) + vf_abs(t->depth[k]), size);
    }
    vf wobble = (l->sun ? size : size / near) * vf_set(0x1p-20f);
    lu = lu - wobble, hu = hu + wobble, lv = lv - wobble, hv = hv + wobble;
    vm whole = l->sun ? vm_from_bits(0) : vf_le(near, zero);
    vm in = vm_and(cell_span(lu, hu, whole, l->low_u, l->cell_u, l->slack_u, out->u0, out->u1),
                   cell_span(lv, hv, whole, l->low_v, l->cell_v, l->slack_v, out->v0, out->v1));
    in = vm_and(in, vf_lt(near - size * vf_set(0x1p-20f), vf_set(l->far + fabsf(l->far) * 0x1p-20f)));
    if (!l->sun) in = vm_and(in, vf_lt(zero, far));
    return vm_bits(in);
}

static void lanes_setup(const caster *c, const corners *t, lanes *out)
{
    const light *l = c->light;
    vf bound = vf_set(0), widest = vf_set(0), size = vf_set(0), dx = vf_set(l->max_x), dy = vf_set(l->max_y), dz = vf_set(l->max_z);
    for (int k = 0; k < 3; k++) {
        vf3 a = t->p[(k + 1) % 3], b = t->p[(k + 2) % 3];
        vf3 e = {a.x - b.x, a.y - b.y, a.z - b.z}, s = {a.x + b.x, a.y + b.y, a.z + b.z};
        vf yz = e.y * s.z, zy = e.z * s.y, zx = e.z * s.x, xz = e.x * s.z, xy = e.x * s.y, yx = e.y * s.x;
        vf nx = yz - zy, ny = zx - xz, nz = xy - yx;
        vf_store(out->nx[k], nx), vf_store(out->ny[k], ny), vf_store(out->nz[k], nz);
        vf_store(out->depth[k], t->depth[k]);
        vf m = (vf_abs(yz) + vf_abs(zy)) * dx + (vf_abs(zx) + vf_abs(xz)) * dy + (vf_abs(xy) + vf_abs(yx)) * dz;
        bound = vf_max(bound, m), widest = vf_max(widest, vf_abs(nx) + vf_abs(ny) + (l->sun ? vf_set(0) : vf_abs(nz)));
        size = vf_max(size, vf_abs(t->p[k].x) + vf_abs(t->p[k].y) + vf_abs(t->depth[k]));
    }
    bound = bound * vf_set(8 * UNIT) + vf_set(TINY);
    /* Points and corners are rounded themselves. Neighbours agree on how, so this matters only for not passing over what
     * look_closely would find to stand between. */
    size = size + vf_set(l->max_x + l->max_y + (l->sun ? 0 : l->max_z));
    vf wide = bound + widest * size * vf_set(8 * UNIT);
    vf low = vf_min(t->depth[0], vf_min(t->depth[1], t->depth[2])), high = vf_max(t->depth[0], vf_max(t->depth[1], t->depth[2]));
    vf_store(out->bound, bound);
    vf_store(out->wide, wide);
    vf_store(out->slack, vf_set(6) * wide * (high - low));
    vf_store(out->rounding, (vf_max(vf_abs(low), vf_abs(high)) + vf_set(fabsf(l->near) + fabsf(l->far))) * vf_set(0x1p-20f));
}

/* From a point to the lamp, in double; a sun is one length of its direction away, and counts from there on. */
typedef struct way {
    daft_dvec3 from, direction;
    bool endless;
} way;

static way way_to(const daft_batch *b, const daft_lamp *lamp, uint32_t i)
{
    daft_dvec3 from = daft_to_double(lane3(&b->lifted, i));
    return (way){from, lamp->sun ? daft_to_double(lamp->to_light) : daft_dsub(daft_to_double(lamp->position), from), lamp->sun};
}

static bool on_way(const way *w, double t) { return t > 0 && (w->endless || t < 1); }

/* A multiple of a × b that is negated, bit for bit, where a and b are exchanged. */
static double edge_side(daft_dvec3 a, daft_dvec3 b, daft_dvec3 d) { return daft_ddot(daft_dcross(daft_dsub(a, b), daft_dadd(a, b)), d); }

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
            moved[i] = (double)m[3 * i] * v[0] + (double)m[3 * i + 1] * v[1] + (double)m[3 * i + 2] * v[2] + (double)t[i];
        q[k] = daft_dsub(daft_dv3(moved[0], moved[1], moved[2]), w.from);
    }
    daft_dvec3 normal = daft_dcross(daft_dsub(q[1], q[0]), daft_dsub(q[2], q[0]));
    double along = daft_ddot(normal, w.direction);
    if (along == 0 || !on_way(&w, daft_ddot(normal, q[0]) / along)) return false;
    double u = edge_side(q[1], q[2], w.direction), v = edge_side(q[2], q[0], w.direction), s = edge_side(q[0], q[1], w.direction);
    return (u >= 0 && v >= 0 && s >= 0) || (u <= 0 && v <= 0 && s <= 0);
}

static __attribute__((noinline)) void look_closely(const caster *c, const daft_block *block, int lane, uint32_t first, vbits doubt)
{
    cells *p = c->points;
    for (; doubt; doubt &= doubt - 1) {
        uint32_t at = first + (uint32_t)__builtin_ctz(doubt);
        if (stands_between(c, block, lane, p->source[at])) p->depth[at] = -INFINITY;
    }
}

/* The lanes whose point lies on this very triangle. */
DAFT_INLINE vbits lie_on(const caster *c, uint32_t triangle, uint32_t first)
{
    vm instance = vi_eq(vi_load(&c->points->instance[first]), vi_set((int32_t)c->number));
    return vm_bits(vm_and(instance, vi_eq(vi_load(&c->points->own[first]), vi_set((int32_t)triangle))));
}

/* Puts points first..end that the triangle shadows to depth -inf. An overflow gives NaN, which is in front of nothing. */
DAFT_INLINE void test_points(const caster *c, const lanes *t, int i, const daft_block *block, int lane, uint32_t first,
                             uint32_t end)
{
    cells *p = c->points;
    vf behind = vf_set(c->light->sun ? -INFINITY : 0); /* hits at or beyond the lamp lie there */
    vf nx0 = vf_set(t->nx[0][i]), nx1 = vf_set(t->nx[1][i]), nx2 = vf_set(t->nx[2][i]);
    vf ny0 = vf_set(t->ny[0][i]), ny1 = vf_set(t->ny[1][i]), ny2 = vf_set(t->ny[2][i]);
    vf nz0 = vf_set(t->nz[0][i]), nz1 = vf_set(t->nz[1][i]), nz2 = vf_set(t->nz[2][i]);
    vf d0 = vf_set(t->depth[0][i]), d1 = vf_set(t->depth[1][i]), d2 = vf_set(t->depth[2][i]);
    vf bound = vf_set(t->bound[i]), wide = vf_set(t->wide[i]), slack = vf_set(t->slack[i]), rounding = vf_set(t->rounding[i]);
    for (uint32_t k = first; k < end; k += DAFT_VL) {
        vf x = vf_load(&p->x[k]), y = vf_load(&p->y[k]), z = vf_load(&p->z[k]);
        vf e0 = nx0 * x + ny0 * y + nz0 * z, e1 = nx1 * x + ny1 * y + nz1 * z, e2 = nx2 * x + ny2 * y + nz2 * z;
        vf least = vf_min(e0, vf_min(e1, e2)), most = vf_max(e0, vf_max(e1, e2));
        vm side = vm_or(vf_le(-wide, least), vf_le(most, wide)), sure = vm_or(vf_le(-bound, least), vf_le(most, bound));
        vbits hits = vm_bits(side) & vbits_first((int)(end - k));
        if (!hits) continue;
        vf inverse = vf_set(1) / (e0 + e1 + e2), depth = (e0 * d0 + e1 * d1 + e2 * d2) * inverse;
        vf error = vf_abs(slack * inverse) + rounding, limit = vf_load(&p->depth[k]);
        vm dark = vm_and(vm_and(vm_from_bits(hits), sure), vm_and(vf_lt(depth + error, limit), vf_lt(behind, depth)));
        vf_store(&p->depth[k], vf_select(dark, vf_set(-INFINITY), limit));
        vbits doubt = hits & vm_bits(vf_lt(depth - error, limit)) & ~vm_bits(dark);
        if (doubt) doubt &= ~lie_on(c, block->triangle[lane], k);
        if (doubt) look_closely(c, block, lane, k, doubt);
    }
}

static void test_blocks(const caster *c, const daft_block *const *blocks, vbits used)
{
    lanes t;
    corners moved = corners_move(c, blocks);
    vbits live = lanes_place(c, &moved, &t) & used;
    if (!live) return;
    lanes_setup(c, &moved, &t);
    for (; live; live &= live - 1) {
        int i = __builtin_ctz(live);
        const daft_block *block = blocks[i / DAFT_BLOCK];
        for (int v = t.v0[i]; v <= t.v1[i]; v++) {
            uint32_t first = c->points->start[v * GRID + t.u0[i]], end = c->points->start[v * GRID + t.u1[i] + 1];
            if (first < end) test_points(c, &t, i, block, i % DAFT_BLOCK, first, end);
        }
    }
}

/* ---- trees ---- */

/* The pencil's sides and the plane behind its points, in object space: a point p is outside where n·p + o > 0. */
static void set_planes(caster *c)
{
    const light *l = c->light;
    const float u[2] = {l->low_u - l->slack_u, l->high_u + l->slack_u}, v[2] = {l->low_v - l->slack_v, l->high_v + l->slack_v};
    /* as functions of light space's x, y, depth, 1 */
    float f[PLANES][4] = {{-1, 0, 0, 0}, {1, 0, 0, 0}, {0, -1, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, -l->far}};
    int last = l->sun ? 3 : 2;
    f[0][last] = u[0], f[1][last] = -u[1], f[2][last] = v[0], f[3][last] = -v[1];
    for (int k = 0; k < PLANES; k++) {
        double o = (double)f[k][3], size = fabs(o);
        for (int j = 0; j < 3; j++) {
            double part = (double)f[k][j] * (double)c->map.t[j];
            c->plane[k][j] = f[k][0] * c->map.m[j] + f[k][1] * c->map.m[3 + j] + f[k][2] * c->map.m[6 + j];
            o += part, size += fabs(part);
        }
        c->plane[k][3] = (float)(o - size * 0x1p-20); /* what cancels in the sum leaves its rounding */
    }
}

/* Bits of the children that are not wholly outside a plane. */
DAFT_INLINE uint32_t inside_bits(const caster *c, const daft_node *node)
{
    uint32_t in = 0xff;
    v8 half = v8_set(0.5f);
    v8 cx = (v8_load(node->bounds[0]) + v8_load(node->bounds[3])) * half, hx = (v8_load(node->bounds[3]) - v8_load(node->bounds[0])) * half;
    v8 cy = (v8_load(node->bounds[1]) + v8_load(node->bounds[4])) * half, hy = (v8_load(node->bounds[4]) - v8_load(node->bounds[1])) * half;
    v8 cz = (v8_load(node->bounds[2]) + v8_load(node->bounds[5])) * half, hz = (v8_load(node->bounds[5]) - v8_load(node->bounds[2])) * half;
    for (int k = 0; k < PLANES; k++) {
        const float *n = c->plane[k];
        v8 ax = v8_set(n[0]) * cx, ay = v8_set(n[1]) * cy, az = v8_set(n[2]) * cz;
        v8 reach = v8_set(fabsf(n[0])) * hx + v8_set(fabsf(n[1])) * hy + v8_set(fabsf(n[2])) * hz;
        v8 size = v8_max(ax, -ax) + v8_max(ay, -ay) + v8_max(az, -az) + v8_set(fabsf(n[3])) + reach;
        v8 least = ax + ay + az + v8_set(n[3]) - reach;
        in &= v8_le_bits(least, size * v8_set(0x1p-20f));
    }
    return in;
}

static void flush(const caster *c, const daft_block *const *list, uint32_t count)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL / 4) {
        const daft_block *blocks[DAFT_VL / 4];
        vbits used = 0;
        for (uint32_t k = 0; k < DAFT_VL / 4; k++) {
            bool real = i + k < count;
            blocks[k] = list[real ? i + k : i];
            for (uint32_t j = 0; real && j < DAFT_BLOCK; j++)
                used |= (vbits)(blocks[k]->triangle[j] != DAFT_NO_TRIANGLE) << (k * DAFT_BLOCK + j);
        }
        test_blocks(c, blocks, used);
    }
}

static void walk(const caster *c, const daft_bvh *bvh)
{
    uint32_t stack[DAFT_STACK], count = 0;
    const daft_block *list[BLOCK_LIST + DAFT_MAX_LEAF_BLOCKS];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const daft_node *node = &bvh->nodes.items[stack[--top]];
        for (uint32_t in = inside_bits(c, node); in; in &= in - 1) {
            uint32_t child = node->child[__builtin_ctz(in)];
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF)) {
                stack[top++] = child;
                continue;
            }
            const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t k = 0; k <= (child & 3); k++) list[count++] = &block[k];
            if (count < BLOCK_LIST) continue;
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
    double dd = daft_ddot(w->direction, w->direction), along = daft_ddot(centre, w->direction) / dd, r = (double)s->radius;
    daft_dvec3 aside = daft_dsub(centre, daft_dscale(w->direction, along));
    double square = r * r - daft_ddot(aside, aside);
    if (!(square > 0)) return false;
    double half = sqrt(square / dd);
    return on_way(w, along - half) || on_way(w, along + half);
}

/* |error(discriminant)| as in raster/tile_kernel.c, of a ray from the point to the lamp. A sphere is a surface: with the
 * lamp within, it is its far side that may stand between. */
static void test_sphere(const caster *c, daft_vec3 origin)
{
    const light *l = c->light;
    const daft_instance *s = c->instance;
    cells *p = c->points;
    daft_affine at = compose(&l->map, &s->to_frame, origin);
    float r = s->radius, reach = sqrtf(at.t[0] * at.t[0] + at.t[1] * at.t[1] + at.t[2] * at.t[2]) + r;
    vf cx = vf_set(at.t[0]), cy = vf_set(at.t[1]), cz = vf_set(at.t[2]), r2 = vf_set(r * r), zero = vf_set(0), blur = vf_set(32 * UNIT * reach * reach);
    for (uint32_t k = 0; k < p->count; k += DAFT_VL) {
        vf x = vf_load(&p->x[k]), y = vf_load(&p->y[k]), z = vf_load(&p->depth[k]), limit = z, one = vf_set(1);
        vf away, disc, scale; /* the sphere's middle as seen along the ray; depths in units of the ray's */
        if (l->sun) {
            vf ax = cx - x, ay = cy - y;
            disc = r2 - (ax * ax + ay * ay), away = cz, scale = one;
        } else {
            vf dd = x * x + y * y + z * z, along = (cx * x + cy * y + cz * z) / dd;
            vf ax = cx - x * along, ay = cy - y * along, az = cz - z * along;
            disc = r2 - (ax * ax + ay * ay + az * az), away = along * z, scale = z / vf_sqrt(dd);
        }
        vf half = vf_sqrt(vf_max(disc, zero)) * scale, error = vf_set(reach * 0x1p-19f);
        vf near = away - half, far = away + half;
        error = error + vf_set(2) * blur / vf_max(half, vf_sqrt(blur)); /* of the root */
        vm met = vm_and(vf_lt(-blur, disc), vm_from_bits(vbits_first((int)(p->count - k))));
        vm dark = vm_and(vm_and(met, vf_lt(blur, disc)), vf_lt(near + error, limit)), apart = vf_lt(limit + error, near); /* beyond the point */
        if (!l->sun) {
            dark = vm_and(dark, vf_lt(error, near));
            apart = vm_or(apart, vm_or(vf_lt(far, -error), vm_and(vf_lt(near, -error), vf_lt(limit + error, far))));
        }
        vf_store(&p->depth[k], vf_select(dark, vf_set(-INFINITY), limit));
        for (vbits doubt = vm_bits(vm_and(met, vf_lt(vf_set(-INFINITY), limit))) & ~vm_bits(vm_or(dark, apart)); doubt; doubt &= doubt - 1) {
            uint32_t i = k + (uint32_t)__builtin_ctz(doubt);
            way w = way_to(c->batch, c->lamp, p->source[i]);
            if (ball_between(s, &w)) p->depth[i] = -INFINITY;
        }
    }
}

/* ---- the tile ---- */

static uint32_t take_dark(const cells *p, uint32_t *bits)
{
    for (uint32_t i = 0; i < p->count; i++)
        if (p->depth[i] == -INFINITY) bits[p->source[i] / 32] &= ~((uint32_t)1 << (p->source[i] % 32));
    return p->count;
}

uint32_t DAFT_KERNEL(daft_shadows)(const daft_batch *points, const daft_lamp *lamp, const daft_instance *instances,
                                   const uint32_t *candidates, uint32_t candidate_count, uint32_t bits[DAFT_BATCH_WORDS])
{
    light l;
    cells all, kept;
    uint8_t under[DAFT_BATCH_ROOM] = {0}, active[DAFT_MAX_CANDIDATES];
    if (candidate_count == 0) return 0;
    daft_vec3 origin = lamp->sun ? middle_of(points, bits) : lamp->position;
    light_setup(&l, points, lamp, bits);
    move_points(&l, points, origin, bits, &all);
    if (!measure(&l, &all)) return DAFT_NO_PENCIL;
    bool any = false;
    for (uint32_t i = 0; i < candidate_count; i++) {
        active[i] = mark_under(&l, points, &instances[candidates[i]], candidates[i], origin, &all, under);
        any |= active[i];
    }
    if (!any) return 0;
    fill_cells(&l, points, lamp, &all, under, &kept);
    for (uint32_t i = 0; i < candidate_count; i++) {
        const daft_instance *instance = &instances[candidates[i]];
        if (!active[i]) continue;
        caster c = {.light = &l, .lamp = lamp, .batch = points, .instance = instance, .number = candidates[i], .points = &kept};
        if (!instance->mesh) {
            test_sphere(&c, origin);
            continue;
        }
        c.map = compose(&l.map, &instance->to_frame, origin);
        set_planes(&c);
        walk(&c, instance->bvh);
    }
    return take_dark(&kept, bits);
}
