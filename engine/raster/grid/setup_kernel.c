/* Triangles set up for a tile, DAFT_VL at a time: moved to camera space, projected, dropped when their screen box holds
 * no pixel's ray or an edge has all of it on its outer side; then the planes of their edges and of their inverse depth.
 *
 * Edge functions e = n·d (triangles.h) are positive on the inner side after all three are turned by the sign of det(a,
 * b, c). n is divided by the bound of its error, which adds one more u, so that e is sure beyond 1 whatever the size of
 * its edge; the bound takes 9u, which covers its own roundings and that its reciprocal is rough, and adds TINY for
 * underflow. Where the numbers overflow, n becomes 0 and nothing is sure.
 *
 * Depth. The inverse depth w = 1/z is linear over the picture: with the triangle's normal N, the product of two sides,
 * and D = N·a, w·focal = N·d / D. N is off by 4u·M as above, N·d by 3u more, D by 3u·Σ M·|a| and the quotients by 2u
 * each; so |error(w)| <= 9u·(Σ M·|d| + w·Σ M·|a|) / |D|, taken with 12u at the largest w of the triangle in the tile.
 * Where that is more than 2^-12 of w itself (a floor under the camera) N and D are taken in double, and what is left is
 * the rounding of w's own three terms. The sides are the shorter two: of a sliver's longer two M is as much larger than
 * N as it is longer than wide. */
#include "math/exact.h"
#include "raster/grid/grid.h"

/* ---- projection ---- */

/* Triangles in the tile: their box is that of the pixels whose rays may meet them. */
typedef struct lanes {
    view_corners corners;
    vf x0, x1, y0, y1; /* whole numbers within the tile */
    vf nearest;        /* the largest w; infinite where a corner is not in front */
    vbits some;
} lanes;

/* The whole numbers within low..high, clamped to 0..last. */
DAFT_INLINE vm pixel_span(vf low, vf high, float last, float slack, vf *first, vf *end)
{
    vf zero = vf_set(0), one = vf_set(1);
    vf a = vf_max(low - vf_set(slack), zero), b = vf_min(high + vf_set(slack), vf_set(last));
    vf floor_a = vf_convert_to(vi_convert_to(a)); /* a >= 0; NaN was turned to 0 by vf_max */
    *first = floor_a + vf_if_then_else(vf_lt(floor_a, a), one, zero);
    *end = vf_convert_to(vi_convert_to(b));
    return vm_and(vf_le(zero, b), vf_le(*first, *end));
}

DAFT_INLINE void project(const daft_tile_job *job, const daft_view_instance *view, const daft_block *const *blocks,
                         lanes *l)
{
    vf zero = vf_set(0), focal = vf_set(job->pencil.focal);
    vf left = vf_set(job->left), top = vf_set(job->top);
    l->corners = blocks_move(&job->pencil, true, &view->to_view, blocks);
    view_extent e = extent_empty();
    for (int k = 0; k < 3; k++) extent_add(&e, &l->corners.p[k], focal / l->corners.p[k].z);
    /* A triangle through the camera's plane may reach anywhere. */
    const vf near = nearest_depth(&l->corners);
    vm front = vf_lt(zero, near), some = vf_lt(zero, farthest_depth(&l->corners));
    vf x0 = vf_if_then_else(front, e.low_x - left, zero),
       x1 = vf_if_then_else(front, e.high_x - left, vf_set(job->last_x));
    vf y0 = vf_if_then_else(front, top - e.high_y, zero),
       y1 = vf_if_then_else(front, top - e.low_y, vf_set(job->last_y));
    some = vm_and(some, pixel_span(x0, x1, job->last_x, job->slack, &l->x0, &l->x1));
    some = vm_and(some, pixel_span(y0, y1, job->last_y, job->slack, &l->y0, &l->y1));
    l->nearest = vf_if_then_else(front, vf_set(1 + 4 * UNIT) / near, vf_set(INFINITY));
    l->some = vbits_from_mask(some);
    if (job->clips) l->some &= ~clipped(job->clip, l->corners.p);
}

void DAFT_KERNEL(daft_block_boxes)(const daft_tile_job *job, const daft_view_instance *view, const daft_block *block,
                                   daft_screen_box *out)
{
    const daft_block *blocks[DAFT_BATCH_BLOCKS];
    lanes l;
    for (uint32_t i = 0; i < DAFT_BATCH_BLOCKS; i++) blocks[i] = block;
    project(job, view, blocks, &l);
    for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
        daft_screen_box box = {(int16_t)l.x0[i], (int16_t)l.x1[i], (int16_t)l.y0[i], (int16_t)l.y1[i]};
        if (block->triangle[i] == DAFT_NO_TRIANGLE) continue;
        out[block->triangle[i]] = l.some >> i & 1 ? box : (daft_screen_box){1, 0, 1, 0};
    }
}

/* ---- edges ---- */

DAFT_INLINE vf edge_bound(const plane *e, vf dx, vf dy, vf dz)
{
    return vf_set(9 * UNIT) * plane_size(e, dx, dy, dz) + vf_set(TINY);
}

/* What daft_view_corners gives, without a way to the mesh. */
static void lane_corners(const lanes *l, int i, daft_vec3 corner[3])
{
    for (int k = 0; k < 3; k++) corner[k] = daft_v3(l->corners.p[k].x[i], l->corners.p[k].y[i], l->corners.p[k].z[i]);
}

/* Sign bits that turn the edges so that inside is positive; lanes seen edge-on drop out of *live. */
DAFT_INLINE vi facing(bool exact, const plane *e, const lanes *l, vbits *live)
{
    const vf3 *c = &l->corners.p[2];
    vf det = vf3_dot(e[2].n, *c);
    vf bound = edge_bound(&e[2], vf_abs(c->x), vf_abs(c->y), vf_abs(c->z));
    vbits unsure = exact ? *live & ~vbits_from_mask(vf_lt(bound, vf_abs(det))) : 0;
    vi sign = (vi)det & vi_set(INT32_MIN);
    for (; unsure; unsure &= unsure - 1) {
        int i = __builtin_ctz(unsure);
        daft_vec3 corner[3];
        lane_corners(l, i, corner);
        int known = daft_det_sign(corner[0], corner[1], corner[2]);
        if (known == 0) *live &= ~((vbits)1 << i);
        sign[i] = known < 0 ? INT32_MIN : 0;
    }
    return sign;
}

/* The three planes, turned inwards and scaled; lanes with all of their box on the outer side of one drop out of *live.
 * Rounding keeps order, and rays' e are computed by the same operations: of those in the box none is less than the
 * least found here. */
DAFT_INLINE void edges_setup(const daft_tile_job *job, bool exact, daft_pencil_batch *b, const lanes *l, vbits *live)
{
    plane e[3];
    for (int k = 0; k < 3; k++) e[k] = edge_plane(&l->corners, k, false);
    vi sign = facing(exact, e, l, live);
    vf dx = vf_set(job->max_dx), dy = vf_set(job->max_dy), dz = vf_set(job->pencil.focal), inf = vf_set(INFINITY);
    const float spread = job->spread;
    vf x0 = vf_set(job->left - spread) + l->x0, x1 = vf_set(job->left + spread) + l->x1,
       y0 = vf_set(job->top - spread) - l->y1, y1 = vf_set(job->top + spread) - l->y0;
    vf outer = vf_set(exact ? -1.0f : 0.0f), hopeless = vf_set(exact ? 0.0f : -1.0f), zero = vf_set(0);
    vbits out = 0;
    for (int k = 0; k < 3; k++) {
        vf scale = vf_xor(exact ? vf_approximate_reciprocal(edge_bound(&e[k], dx, dy, dz)) : vf_set(1), sign);
        vf3 n = {e[k].n.x * scale, e[k].n.y * scale, e[k].n.z * scale * dz};
        vm whole = vf_lt(vf_abs(n.x) * dx + vf_abs(n.y) * dy + vf_abs(n.z), inf);
        n = (vf3){vf_if_then_else(whole, n.x, zero), vf_if_then_else(whole, n.y, zero),
                  vf_if_then_else(whole, n.z, hopeless)};
        vf xa = n.x * x0, xb = n.x * x1, ya = n.y * y0 + n.z, yb = n.y * y1 + n.z;
        out |= vbits_from_mask(vf_lt(vf_max(xa, xb) + vf_max(ya, yb), outer));
        vf_store(b->nx[k], n.x), vf_store(b->ny[k], n.y), vf_store(b->nz[k], n.z);
    }
    *live &= ~out;
}

/* ---- depth ---- */

/* Where floats do not decide, depths are compared as daft_pencil_depth gives them: a mean of the corners' z, off by
 * some 2^-51 of the largest. Intervals of w hold these depths too, or what is decided here would not agree with it. */
#define COMPARED 0x1p-48f

/* One triangle's plane of w in double, and its error bound. */
static void depth_setup_double(const daft_tile_job *job, daft_pencil_batch *b, const lanes *l, int i)
{
    daft_vec3 corner[3];
    lane_corners(l, i, corner);
    double f = (double)job->pencil.focal, dx = (double)job->max_dx, dy = (double)job->max_dy;
    daft_dvec3 a = daft_to_double(corner[0]), p = daft_dsub(daft_to_double(corner[1]), a),
               q = daft_dsub(daft_to_double(corner[2]), a), n = daft_dcross(p, q);
    double inverse = 1 / (daft_ddot(n, a) * f);
    double m[3] = {fabs(p.y * q.z) + fabs(p.z * q.y), fabs(p.z * q.x) + fabs(p.x * q.z),
                   fabs(p.x * q.y) + fabs(p.y * q.x)};
    double w = (fabs(n.x) * dx + fabs(n.y) * dy + fabs(n.z) * f) * fabs(inverse);
    double rays = m[0] * dx + m[1] * dy + m[2] * f,
           corners = (m[0] * fabs(a.x) + m[1] * fabs(a.y) + m[2] * fabs(a.z)) * f;
    b->wx[i] = (float)(n.x * inverse), b->wy[i] = (float)(n.y * inverse), b->wz[i] = (float)(n.z * inverse * f);
    double far = fmax(fabs(a.z), fmax(fabs((double)corner[1].z), fabs((double)corner[2].z)));
    b->error[i] = (float)(w * (4 * (double)UNIT) + (rays + corners * w) * fabs(inverse) * 0x1p-48 +
                          w * w * far * (double)COMPARED) +
                  TINY;
    if (b->error[i] < INFINITY) return;
    b->wx[i] = b->wy[i] = b->wz[i] = 0; /* nothing is known */
    b->error[i] = INFINITY;
}

/* From corner k + 2 to corner k + 1, as for edges. */
DAFT_INLINE vf3 side(const lanes *l, int k)
{
    vf3 a = l->corners.p[(k + 1) % 3], b = l->corners.p[(k + 2) % 3];
    return (vf3){a.x - b.x, a.y - b.y, a.z - b.z};
}

DAFT_INLINE vf3 vf3_select(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_if_then_else(m, a.x, b.x), vf_if_then_else(m, a.y, b.y), vf_if_then_else(m, a.z, b.z)};
}

/* Instead of sides 1 and 2, all but the longest one: side 1 × side 2 = side 2 × side 0 = side 0 × side 1. */
DAFT_INLINE void shorter_sides(const lanes *l, vf3 *p, vf3 *q)
{
    vf3 r = side(l, 0), back = {-r.x, -r.y, -r.z};
    vf r2 = vf3_dot(r, r), p2 = vf3_dot(*p, *p), q2 = vf3_dot(*q, *q);
    vm p_longest = vf_lt(vf_max(q2, r2), p2), q_longest = vf_lt(vf_max(p2, r2), q2);
    *p = vf3_select(p_longest, back, *p), *q = vf3_select(q_longest, r, *q);
}

/* The plane of w and its error bound. */
DAFT_INLINE void depth_setup(const daft_tile_job *job, bool exact, daft_pencil_batch *b, const lanes *l, vbits live)
{
    vf3 a = l->corners.p[0], p = side(l, 1), q = side(l, 2);
    if (exact) shorter_sides(l, &p, &q);
    const plane own = plane_of(p, q);
    const vf3 n = own.n, m = own.m;
    vf dx = vf_set(job->max_dx), dy = vf_set(job->max_dy), focal = vf_set(job->pencil.focal);
    vf inverse = vf_set(1) / (vf3_dot(n, a) * focal), scale = vf_abs(inverse);
    vf_store(b->wx, n.x * inverse), vf_store(b->wy, n.y * inverse), vf_store(b->wz, n.z * inverse * focal);
    vf_store(b->w_cap, exact ? vf_set(INFINITY) : l->nearest);
    vf_store(b->error, vf_set(0));
    if (!exact) return;
    vf w = vf_min((vf_abs(n.x) * dx + vf_abs(n.y) * dy + vf_abs(n.z) * focal) * scale, l->nearest);
    vf rays = plane_size(&own, dx, dy, focal);
    vf corners = (m.x * vf_abs(a.x) + m.y * vf_abs(a.y) + m.z * vf_abs(a.z)) * focal;
    vf far = vf_max(vf_abs(a.z), vf_max(vf_abs(l->corners.p[1].z), vf_abs(l->corners.p[2].z)));
    vf error = vf_set(12 * UNIT) * (rays + corners * w) * scale + w * w * far * vf_set(COMPARED) + vf_set(TINY);
    vf_store(b->error, error);
    for (vbits coarse = live & ~vbits_from_mask(vf_lt(error, w * vf_set(0x1p-12f))); coarse; coarse &= coarse - 1)
        depth_setup_double(job, b, l, __builtin_ctz(coarse));
}

/* ---- batches ---- */

DAFT_INLINE bool set_up_as(const daft_tile_job *job, bool exact, const lanes *l, vbits live, daft_pencil_batch *batch)
{
    edges_setup(job, exact, batch, l, &live);
    if (!live) return false;
    depth_setup(job, exact, batch, l, live);
    vi_store(batch->x0, vi_convert_to(l->x0)), vi_store(batch->x1, vi_convert_to(l->x1));
    vi_store(batch->y0, vi_convert_to(l->y0)), vi_store(batch->y1, vi_convert_to(l->y1));
    batch->live = live;
    job->counters->binned += (uint64_t)__builtin_popcount(live);
    return true;
}

/* Compiled once for each: the bounds take as many registers as the rest. */
DAFT_INLINE bool set_up(const daft_tile_job *job, const lanes *l, vbits live, daft_pencil_batch *batch)
{
    return job->exact ? set_up_as(job, true, l, live, batch) : set_up_as(job, false, l, live, batch);
}

DAFT_INLINE vi box_pixels(const lanes *l)
{
    return vi_convert_to(l->x0) | vi_convert_to(l->x1) << 8 | vi_convert_to(l->y0) << 16 | vi_convert_to(l->y1) << 24;
}

static __attribute__((noinline)) void keep_few(daft_queue *out, const lanes *l, vbits some, uint32_t instance,
                                               vi triangle)
{
    queue_add(out, l->corners.p, box_pixels(l), l->nearest, instance, triangle, some);
}

/* Lanes that cover little: what is behind them waits for nobody. */
DAFT_INLINE vbits small(const lanes *l)
{
    vf two = vf_set(2);
    return vbits_from_mask(vm_and(vf_le(l->x1 - l->x0, two), vf_le(l->y1 - l->y0, two)));
}

bool DAFT_KERNEL(daft_blocks_setup)(const daft_tile_job *job, const daft_view_instance *view, const uint32_t *blocks,
                                    uint32_t count, daft_queue *queue, daft_pencil_batch *batch)
{
    lanes l;
    vi triangle;
    const daft_block *all[DAFT_BATCH_BLOCKS];
    blocks_at(view, blocks, count, all);
    triangle = blocks_triangles(all);
    vbits used =
        ~vbits_from_mask(vi_eq(triangle, vi_set((int32_t)DAFT_NO_TRIANGLE))) & vbits_first_n((int)(count * DAFT_BLOCK));
    project(job, view, all, &l);
    job->counters->tested += (uint64_t)__builtin_popcount(used);
    used &= l.some;
    if (!used) return false;
    if (__builtin_popcount(used) <= DAFT_VL / 2 && !(used & ~small(&l))) {
        keep_few(queue, &l, used, view->index, triangle);
        return false;
    }
    vi_store(batch->instance, vi_set((int32_t)view->index));
    vi_store(batch->triangle, triangle);
    return set_up(job, &l, used, batch);
}

bool DAFT_KERNEL(daft_queue_setup)(const daft_tile_job *job, daft_queue *from, daft_pencil_batch *batch)
{
    lanes l;
    uint32_t count = daft_min_u(from->count, DAFT_VL), at = from->count - count;
    for (int k = 0; k < 3; k++)
        l.corners.p[k] = (vf3){vf_load(&from->corner[3 * k][at]), vf_load(&from->corner[3 * k + 1][at]),
                               vf_load(&from->corner[3 * k + 2][at])},
        l.corners.depth[k] = l.corners.p[k].z;
    vi pixels = vi_load(&from->pixels[at]), byte = vi_set(255);
    l.x0 = vf_convert_to(pixels & byte), l.x1 = vf_convert_to(pixels >> 8 & byte);
    l.y0 = vf_convert_to(pixels >> 16 & byte), l.y1 = vf_convert_to(pixels >> 24 & byte);
    l.nearest = vf_load(&from->nearest[at]);
    vi_store(batch->instance, vi_load(&from->instance[at]));
    vi_store(batch->triangle, vi_load(&from->triangle[at]));
    from->count = at;
    return set_up(job, &l, vbits_first_n((int)count), batch);
}
