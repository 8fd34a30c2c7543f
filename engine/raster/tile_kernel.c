/* Resolving a tile. The triangles binned into it are set up DAFT_VL at a time, then each is tested against the rays of the
 * blocks its box touches: a block is 4 pixels wide and DAFT_VL / 4 high, one SIMD register, and stays together in memory.
 *
 * Edge functions. The plane of the origin and an edge a, b has the normal n = (a - b) × (a + b) = 2·a × b; exchanging a and
 * b negates each bit, so neighbours see the same number. e = n·d is positive on the inner side after all three are turned
 * by the sign of det(a, b, c). With u = 2^-24: a - b and a + b round once, each product once, their difference once, so a
 * component of n is off by at most 4u·M with M = |x|·|y'| + |y|·|x'| of its two products; the three products with d and two
 * sums add 3u·|n|·|d|. Together |error(e)| <= 7u·(Mx·|dx| + My·|dy| + Mz·|dz|) to first order. n is then divided by
 * that bound, which adds one more u, so that e is sure beyond 1 whatever the size of its edge; the bound takes 9u, which
 * covers its own roundings, and adds TINY for underflow. An e that is NaN or infinite is never "sure".
 *
 * Depth. The inverse depth w = 1/z is linear over the picture: with the triangle's normal N = (b - a) × (c - a) and
 * D = N·a, w·focal = N·d / D. N is off by 4u·M as above, N·d by 3u more, D by 3u·Σ M·|a| and the quotients by 2u each; so
 * |error(w)| <= 9u·(Σ M·|d| + w·Σ M·|a|) / |D|, taken with 12u at the largest w of the triangle in the tile. Where that is
 * more than 2^-16 of w itself (a floor under the camera, an edge-on sliver) N and D are taken in double, and what is left
 * is the rounding of w's own three terms. Pixels keep the interval of their nearest w: those that are apart need no
 * closer look. */
#include "math/exact.h"
#include "math/isa.h"
#include "math/simd.h"
#include "raster/kernels.h"

void DAFT_KERNEL(daft_bin)(const daft_raster *raster, uint32_t work, uint32_t worker);

#define UNIT 0x1p-24f
#define TINY 1e-36f
#define SPHERE_ROUNDING 0x1p-18f

enum {
    RECORD_WORDS = sizeof(daft_record) / sizeof(float),
    BLOCK_W = 4,
    BLOCK_H = DAFT_VL / BLOCK_W,
    BLOCKS_X = DAFT_TILE / BLOCK_W,
    BLOCKS_Y = DAFT_TILE / BLOCK_H,
    PIXELS = DAFT_TILE * DAFT_TILE
};

/* Up to DAFT_VL triangles, set up. Edge k is opposite corner k. */
typedef struct batch {
    float nx[3][DAFT_VL], ny[3][DAFT_VL], nz[3][DAFT_VL]; /* over the bound of e; nz times the focal length */
    float wx[DAFT_VL], wy[DAFT_VL], wz[DAFT_VL];          /* w = wx·dx + wy·dy + wz */
    float error[DAFT_VL], w_max[DAFT_VL];
    const daft_record *record[DAFT_VL];
    vbits live;
    bool exact;
} batch;

/* Pixels in blocks; pixel i % DAFT_VL of block i / DAFT_VL. */
typedef struct job {
    const daft_raster *raster;
    daft_bins *counters;
    daft_tile *tile;
    float left, top;      /* ray of the tile's first pixel */
    float max_dx, max_dy; /* of any ray in the tile */
    float farthest;       /* every pixel's w is at least this */
    bool stale;           /* farthest may have come nearer */
    _Alignas(64) float w_low[PIXELS];
    _Alignas(64) float w_high[PIXELS];
    _Alignas(64) uint32_t instance[PIXELS];
    _Alignas(64) uint32_t triangle[PIXELS];
} job;

static int pixel_x(int at) { return at / DAFT_VL % BLOCKS_X * BLOCK_W + at % BLOCK_W; }
static int pixel_y(int at) { return at / DAFT_VL / BLOCKS_X * BLOCK_H + at % DAFT_VL / BLOCK_W; }

/* ---- single lanes that floats could not decide ---- */

static daft_vec3 lane_ray(const job *j, int at)
{
    return daft_pencil_ray(&j->raster->pencil, j->tile->x + pixel_x(at), j->tile->y + pixel_y(at));
}

static daft_vec3 record_corner(const daft_record *r, int k)
{
    return daft_v3(r->corner[3 * k], r->corner[3 * k + 1], r->corner[3 * k + 2]);
}

static double record_depth(const daft_record *r, daft_vec3 ray)
{
    if (r->triangle != DAFT_SPHERE) return daft_pencil_depth(record_corner(r, 0), record_corner(r, 1), record_corner(r, 2), ray);
    double t;
    return daft_pencil_sphere(record_corner(r, 0), r->corner[3], ray, &t) ? t * (double)ray.z : INFINITY;
}

static uint32_t record_triangle(const daft_record *r) { return r->triangle == DAFT_SPHERE ? 0 : r->triangle; }

static void lane_write(job *j, int at, const daft_record *r, float low, float high)
{
    j->w_low[at] = low;
    j->w_high[at] = high;
    j->instance[at] = r->instance;
    j->triangle[at] = record_triangle(r);
}

/* The depths are too close for floats: compare the true ones, then the numbers. */
static void lane_compare(job *j, int at, const daft_record *r, float low, float high)
{
    daft_vec3 ray = lane_ray(j, at);
    uint32_t triangle = record_triangle(r);
    const daft_seen *seen = &j->raster->seen[j->raster->seen_of[j->instance[at]]];
    double mine = record_depth(r, ray), other = daft_seen_depth(seen, j->triangle[at], ray);
    j->counters->exact_depths++;
    bool wins = mine < other || (mine == other && (r->instance < j->instance[at] ||
                                                   (r->instance == j->instance[at] && triangle < j->triangle[at])));
    if (wins) lane_write(j, at, r, low, high);
}

/* A hit with the interval of its w: nearer, farther, or to be looked at closely. */
static void lane_offer(job *j, int at, const daft_record *r, float low, float high)
{
    if (!(low <= high)) low = -INFINITY, high = INFINITY; /* an overflow: nothing is known */
    if (j->instance[at] == DAFT_NOTHING || low > j->w_high[at])
        lane_write(j, at, r, low, high);
    else if (!(high < j->w_low[at]))
        lane_compare(j, at, r, low, high);
}

static bool lane_inside(job *j, int at, const daft_record *r)
{
    j->counters->exact_edges++;
    return daft_pencil_hits(record_corner(r, 0), record_corner(r, 1), record_corner(r, 2), lane_ray(j, at));
}

/* ---- triangle set-up ---- */

typedef struct edge {
    vf3 n;
    vf mx, my, mz; /* the M of the bound */
} edge;

DAFT_INLINE edge edge_setup(vf3 a, vf3 b)
{
    vf3 e = {a.x - b.x, a.y - b.y, a.z - b.z}, s = {a.x + b.x, a.y + b.y, a.z + b.z};
    vf yz = e.y * s.z, zy = e.z * s.y, zx = e.z * s.x, xz = e.x * s.z, xy = e.x * s.y, yx = e.y * s.x;
    return (edge){{yz - zy, zx - xz, xy - yx}, vf_abs(yz) + vf_abs(zy), vf_abs(zx) + vf_abs(xz), vf_abs(xy) + vf_abs(yx)};
}

/* The plane as the corners come: its bits are not those that the neighbour sees. */
DAFT_INLINE edge edge_setup_fast(vf3 a, vf3 b)
{
    vf zero = vf_set(0);
    return (edge){{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}, zero, zero, zero};
}

DAFT_INLINE vf edge_bound(const edge *e, vf dx, vf dy, vf dz)
{
    return vf_set(9 * UNIT) * (e->mx * dx + e->my * dy + e->mz * dz) + vf_set(TINY);
}

/* Sign bits that turn the edges so that inside is positive; lanes seen edge-on drop out of *live. */
static vi facing(const batch *b, const edge *e, const vf3 corner[3], vbits *live)
{
    const vf3 c = corner[2];
    vf det = vf3_dot(e[2].n, c);
    vf bound = edge_bound(&e[2], vf_abs(c.x), vf_abs(c.y), vf_abs(c.z));
    vbits sure = vm_bits(vf_lt(bound, vf_abs(det)));
    vi sign = (vi)det & vi_set(INT32_MIN);
    vbits unsure = b->exact ? *live & ~sure : 0;
    while (unsure) {
        int i = __builtin_ctz(unsure);
        unsure &= unsure - 1;
        const daft_record *r = b->record[i];
        int exact = daft_det_sign(record_corner(r, 0), record_corner(r, 1), record_corner(r, 2));
        if (exact == 0) *live &= ~((vbits)1 << i);
        sign[i] = exact < 0 ? INT32_MIN : 0;
    }
    return sign;
}

/* Lanes of which some edge has the whole tile on its outer side. */
DAFT_INLINE vbits beyond_tile(const job *j, const vf3 n[3])
{
    vf x0 = vf_set(j->left), x1 = vf_set(j->left + DAFT_TILE - 1), y0 = vf_set(j->top - DAFT_TILE + 1), y1 = vf_set(j->top);
    vm out = vm_from_bits(0);
    for (int k = 0; k < 3; k++) {
        vf most = vf_max(n[k].x * x0, n[k].x * x1) + (vf_max(n[k].y * y0, n[k].y * y1) + n[k].z);
        out = vm_or(out, vf_lt(most, vf_set(-1)));
    }
    return vm_bits(out);
}

/* One triangle's plane of w in double, and its error bound. */
static void depth_setup_double(const job *j, batch *b, int i)
{
    const daft_record *r = b->record[i];
    double f = (double)j->raster->pencil.focal, dx = (double)j->max_dx, dy = (double)j->max_dy;
    daft_dvec3 a = daft_to_double(record_corner(r, 0)), p = daft_dsub(daft_to_double(record_corner(r, 1)), a),
               q = daft_dsub(daft_to_double(record_corner(r, 2)), a), n = daft_dcross(p, q);
    double inverse = 1 / (daft_ddot(n, a) * f);
    double m[3] = {fabs(p.y * q.z) + fabs(p.z * q.y), fabs(p.z * q.x) + fabs(p.x * q.z), fabs(p.x * q.y) + fabs(p.y * q.x)};
    double w = (fabs(n.x) * dx + fabs(n.y) * dy + fabs(n.z) * f) * fabs(inverse);
    double rays = m[0] * dx + m[1] * dy + m[2] * f, corners = (m[0] * fabs(a.x) + m[1] * fabs(a.y) + m[2] * fabs(a.z)) * f;
    b->wx[i] = (float)(n.x * inverse), b->wy[i] = (float)(n.y * inverse), b->wz[i] = (float)(n.z * inverse * f);
    b->error[i] = (float)(w * (4 * (double)UNIT) + (rays + corners * w) * fabs(inverse) * 0x1p-48) + TINY;
}

/* The plane of w, its error bound and its largest value. */
static void depth_setup(const job *j, batch *b, const vf3 corner[3], vbits live)
{
    vf3 a = corner[0];
    vf3 p = {corner[1].x - a.x, corner[1].y - a.y, corner[1].z - a.z}, q = {corner[2].x - a.x, corner[2].y - a.y, corner[2].z - a.z};
    vf yz = p.y * q.z, zy = p.z * q.y, zx = p.z * q.x, xz = p.x * q.z, xy = p.x * q.y, yx = p.y * q.x;
    vf3 n = {yz - zy, zx - xz, xy - yx};
    vf3 m = {vf_abs(yz) + vf_abs(zy), vf_abs(zx) + vf_abs(xz), vf_abs(xy) + vf_abs(yx)};
    vf dx = vf_set(j->max_dx), dy = vf_set(j->max_dy), focal = vf_set(j->raster->pencil.focal);
    vf inverse = vf_set(1) / (vf3_dot(n, a) * focal), scale = vf_abs(inverse);
    vf least = vf_min(corner[0].z, vf_min(corner[1].z, corner[2].z));
    vf w_max = vf_select(vf_lt(vf_set(0), least), vf_set(1 + 4 * UNIT) / least, vf_set(INFINITY));
    vf w = vf_min((vf_abs(n.x) * dx + vf_abs(n.y) * dy + vf_abs(n.z) * focal) * scale, w_max);
    vf rays = m.x * dx + m.y * dy + m.z * focal;
    vf corners = (m.x * vf_abs(a.x) + m.y * vf_abs(a.y) + m.z * vf_abs(a.z)) * focal;
    vf error = vf_set(12 * UNIT) * (rays + corners * w) * scale + vf_set(TINY);
    vf_store(b->wx, n.x * inverse), vf_store(b->wy, n.y * inverse), vf_store(b->wz, n.z * inverse * focal);
    vf_store(b->error, error);
    vf_store(b->w_max, w_max);
    for (vbits coarse = live & ~vm_bits(vf_lt(error, w * vf_set(0x1p-16f))); coarse; coarse &= coarse - 1)
        depth_setup_double(j, b, __builtin_ctz(coarse));
}

static void batch_setup(const job *j, batch *b, const float *base, vi offset, int count)
{
    vf3 corner[3];
    edge e[3];
    for (int k = 0; k < 3; k++) {
        corner[k].x = vf_gather(base, offset + vi_set(3 * k));
        corner[k].y = vf_gather(base, offset + vi_set(3 * k + 1));
        corner[k].z = vf_gather(base, offset + vi_set(3 * k + 2));
    }
    bool fast = j->raster->pencil.intersection == DAFT_INTERSECT_FAST;
    b->exact = j->raster->pencil.intersection == DAFT_INTERSECT_EXACT;
    for (int k = 0; k < 3; k++)
        e[k] = fast ? edge_setup_fast(corner[(k + 1) % 3], corner[(k + 2) % 3])
                    : edge_setup(corner[(k + 1) % 3], corner[(k + 2) % 3]);
    vbits live = vbits_first(count), spheres = 0;
    for (int i = 0; i < count; i++) spheres |= (vbits)(b->record[i]->triangle == DAFT_SPHERE) << i;
    live &= ~spheres;
    vi sign = facing(b, e, corner, &live);
    vf dx = vf_set(j->max_dx), dy = vf_set(j->max_dy), dz = vf_set(j->raster->pencil.focal);
    vf3 n[3];
    for (int k = 0; k < 3; k++) {
        vf scale = vf_xor_sign(b->exact ? vf_set(1) / edge_bound(&e[k], dx, dy, dz) : vf_set(1), sign);
        n[k] = (vf3){e[k].n.x * scale, e[k].n.y * scale, e[k].n.z * scale * dz};
        vf_store(b->nx[k], n[k].x), vf_store(b->ny[k], n[k].y), vf_store(b->nz[k], n[k].z);
    }
    live &= ~beyond_tile(j, n);
    depth_setup(j, b, corner, live);
    b->live = live | spheres;
}

/* ---- blocks ---- */

typedef struct rect {
    int x0, x1, y0, y1; /* blocks, inclusive */
} rect;

DAFT_INLINE rect record_rect(const job *j, const daft_record *r)
{
    const daft_tile *t = j->tile;
    return (rect){daft_max_i(r->x0 - t->x, 0) / BLOCK_W, daft_min_i(r->x1 - t->x, t->width - 1) / BLOCK_W,
                  daft_max_i(r->y0 - t->y, 0) / BLOCK_H, daft_min_i(r->y1 - t->y, t->height - 1) / BLOCK_H};
}

DAFT_INLINE vf block_dx(const job *j, int x) { return vf_set(j->left + (float)(x * BLOCK_W)) + vf_column(); }
DAFT_INLINE vf block_dy(const job *j, int y) { return vf_set(j->top - (float)(y * BLOCK_H)) - vf_row(); }

/* Offers lanes with intervals of w to a block: decided in lanes where the intervals are apart. */
DAFT_INLINE void offer(job *j, int at, const daft_record *r, vbits hits, vbits unsure, vf low, vf high)
{
    vf old_low = vf_load(&j->w_low[at]), old_high = vf_load(&j->w_high[at]);
    vbits nearer = vm_bits(vf_lt(old_high, low)), farther = vm_bits(vf_lt(high, old_low));
    unsure &= ~farther;
    vbits take = hits & nearer & ~unsure;
    if (take) {
        vm m = vm_from_bits(take);
        vi instance = vi_set((int32_t)r->instance), triangle = vi_set((int32_t)record_triangle(r));
        vf_store(&j->w_low[at], vf_select(m, low, old_low));
        vf_store(&j->w_high[at], vf_select(m, high, old_high));
        vi_store(&j->instance[at], vi_select(m, instance, vi_load(&j->instance[at])));
        vi_store(&j->triangle[at], vi_select(m, triangle, vi_load(&j->triangle[at])));
        j->stale = true;
    }
    for (vbits look = hits & (unsure | ~(nearer | farther)); look; look &= look - 1) {
        int i = __builtin_ctz(look);
        if ((unsure >> i & 1) && (r->triangle == DAFT_SPHERE ? isinf(record_depth(r, lane_ray(j, at + i)))
                                                              : !lane_inside(j, at + i, r)))
            continue;
        lane_offer(j, at + i, r, low[i], high[i]);
        j->stale = true;
    }
}

/* exact: as the head of this file says. Otherwise the floats' word is taken: inside is e >= 0, and depths have no error. */
DAFT_INLINE void triangle_blocks(job *j, const batch *b, int i, bool exact)
{
    const daft_record *r = b->record[i];
    rect box = record_rect(j, r);
    vf nx0 = vf_set(b->nx[0][i]), nx1 = vf_set(b->nx[1][i]), nx2 = vf_set(b->nx[2][i]), wx = vf_set(b->wx[i]);
    vf one = vf_set(1), error = vf_set(b->error[i]), zero = vf_set(0), w_max = vf_set(b->w_max[i]);
    for (int y = box.y0; y <= box.y1; y++) {
        vf dy = block_dy(j, y), w_row = vf_set(b->wy[i]) * dy + vf_set(b->wz[i]);
        vf row0 = vf_set(b->ny[0][i]) * dy + vf_set(b->nz[0][i]), row1 = vf_set(b->ny[1][i]) * dy + vf_set(b->nz[1][i]),
           row2 = vf_set(b->ny[2][i]) * dy + vf_set(b->nz[2][i]);
        for (int x = box.x0; x <= box.x1; x++) {
            vf dx = block_dx(j, x);
            vf e0 = nx0 * dx + row0, e1 = nx1 * dx + row1, e2 = nx2 * dx + row2;
            vf least = vf_min(vf_min(e0, e1), e2), w = wx * dx + w_row;
            int at = (y * BLOCKS_X + x) * DAFT_VL;
            if (!exact) {
                vbits inside = vm_bits(vf_le(zero, least));
                w = vf_min(w, w_max);
                if (inside) offer(j, at, r, inside, 0, w, w);
                continue;
            }
            /* a NaN, from an overflow, may hide in the minimum: then nothing is sure, nor outside */
            vbits whole = vm_bits(vf_lt(vf_abs(e0 + e1 + e2), vf_set(INFINITY)));
            vbits hits = DAFT_ALL_LANES & ~(vm_bits(vf_lt(least, -one)) & whole);
            if (!hits) continue;
            vbits unsure = hits & ~(vm_bits(vf_lt(one, least)) & whole);
            offer(j, at, r, hits, unsure, w - error, w + error);
        }
    }
}

/* |error(discriminant)| <= 32u·(|c| + r)², from a projection that is off by a few u·|c| and is squared. Its root is then off
 * by less than 2·error / max(root, sqrt(error)); z by that and a few u of the sphere's reach. */
static void sphere_blocks(job *j, const daft_record *r)
{
    rect box = record_rect(j, r);
    float cx = r->corner[0], cy = r->corner[1], cz = r->corner[2], radius = r->corner[3], f = j->raster->pencil.focal;
    float reach = sqrtf(cx * cx + cy * cy + cz * cz) + radius, limit = 32 * UNIT * reach * reach + TINY;
    vf vx = vf_set(cx), vy = vf_set(cy), vz = vf_set(cz), vfocal = vf_set(f), doubt = vf_set(limit), one = vf_set(1);
    vf r2 = vf_set(radius * radius), root_doubt = vf_set(sqrtf(limit)), rounding = vf_set(reach * SPHERE_ROUNDING);
    vf inf = vf_set(INFINITY), tiny = vf_set(TINY);
    for (int y = box.y0; y <= box.y1; y++) {
        vf dy = block_dy(j, y);
        for (int x = box.x0; x <= box.x1; x++) {
            vf dx = block_dx(j, x);
            vf inverse = one / (dx * dx + dy * dy + vfocal * vfocal), along = (dx * vx + dy * vy + vfocal * vz) * inverse;
            vf ax = vx - dx * along, ay = vy - dy * along, az = vz - vfocal * along;
            vf disc = r2 - (ax * ax + ay * ay + az * az);
            vbits lanes = DAFT_ALL_LANES & ~vm_bits(vf_lt(disc, -doubt));
            if (!lanes) continue;
            vbits unsure = lanes & ~vm_bits(vf_lt(doubt, disc));
            vf chord = vf_sqrt(vf_max(disc, vf_set(0))), half = chord * vf_sqrt(inverse);
            vf error = vf_set(2) * doubt / vf_max(chord, root_doubt) + rounding;
            vf near = (along - half) * vfocal, far = (along + half) * vfocal;
            vbits ahead = vm_bits(vf_lt(error, near)), behind = vm_bits(vf_lt(near, -error));
            vbits inside = vm_bits(vf_lt(error, far)) & behind;
            unsure |= lanes & ~ahead & ~inside;
            lanes &= ~(behind & vm_bits(vf_lt(far, -error)));
            vf z = vf_select(vm_from_bits(ahead), near, far), low = z - error, high = z + error;
            vm known = vm_from_bits(ahead | inside); /* then both are positive */
            vf w_low = vf_select(known, vf_set(1 - 4 * UNIT) / vf_max(high, tiny), -inf);
            vf w_high = vf_select(known, vf_set(1 + 4 * UNIT) / vf_max(low, tiny), inf);
            offer(j, (y * BLOCKS_X + x) * DAFT_VL, r, lanes, unsure & lanes, w_low, w_high);
        }
    }
}

/* ---- the tile ---- */

static float find_farthest(const job *j)
{
    vf least = vf_set(INFINITY);
    for (int i = 0; i < PIXELS; i += DAFT_VL) least = vf_min(least, vf_load(&j->w_low[i]));
    return vf_reduce_min(least);
}

static void batch_draw(job *j, const batch *b)
{
    for (vbits live = b->live; live; live &= live - 1) {
        int i = __builtin_ctz(live);
        if (b->record[i]->triangle == DAFT_SPHERE)
            sphere_blocks(j, b->record[i]);
        else if (!(b->w_max[i] < j->farthest))
            b->exact ? triangle_blocks(j, b, i, true) : triangle_blocks(j, b, i, false);
    }
    if (!j->stale) return;
    j->farthest = find_farthest(j);
    j->stale = false;
}

static void draw_list(job *j, const daft_bins *bins, daft_bin_list list)
{
    uint32_t block = list.first, done = 0;
    uint32_t index[DAFT_VL];
    while (done < list.count) {
        batch b;
        int count = 0;
        int32_t offset[DAFT_VL] = {0};
        for (; count < DAFT_VL && done < list.count; count++, done++) {
            index[count] = bins->blocks[block].items[done % DAFT_BIN_ITEMS];
            if (done % DAFT_BIN_ITEMS == DAFT_BIN_ITEMS - 1) block = bins->blocks[block].next;
            b.record[count] = &bins->records[index[count]];
        }
        uint32_t low = index[0]; /* records of one list have rising numbers: offsets from the first stay small */
        for (int i = 0; i < count; i++) offset[i] = (int32_t)((index[i] - low) * RECORD_WORDS);
        batch_setup(j, &b, bins->records[low].corner, vi_load(offset), count);
        batch_draw(j, &b);
    }
}

/* Pixels beyond the picture count as infinitely near: nothing is offered to them in vain, nor do they look far. */
static void clear_pixels(job *j)
{
    bool whole = j->tile->width == DAFT_TILE && j->tile->height == DAFT_TILE;
    for (int i = 0; i < PIXELS; i += DAFT_VL) {
        vf_store(&j->w_low[i], vf_set(-INFINITY)), vf_store(&j->w_high[i], vf_set(-INFINITY));
        vi_store(&j->instance[i], vi_set(-1)), vi_store(&j->triangle[i], vi_set(0));
    }
    for (int i = 0; !whole && i < PIXELS; i++)
        if (pixel_x(i) >= j->tile->width || pixel_y(i) >= j->tile->height) j->w_low[i] = j->w_high[i] = INFINITY;
}

static void write_rows(const job *j, daft_tile *out)
{
    for (int block = 0; block < BLOCKS_X * BLOCKS_Y; block++)
        for (int row = 0; row < BLOCK_H; row++) {
            int from = block * DAFT_VL + row * BLOCK_W;
            int to = (block / BLOCKS_X * BLOCK_H + row) * DAFT_TILE_STRIDE + block % BLOCKS_X * BLOCK_W;
            memcpy(&out->instance[to], &j->instance[from], BLOCK_W * sizeof out->instance[0]);
            memcpy(&out->triangle[to], &j->triangle[from], BLOCK_W * sizeof out->triangle[0]);
        }
}

static void resolve_tile(const daft_raster *raster, uint32_t tile, uint32_t worker, daft_tile *out)
{
    daft_tile_place(raster, tile, out);
    daft_vec3 first = daft_pencil_ray(&raster->pencil, out->x, out->y);
    job j;
    j.raster = raster, j.counters = &raster->bins[worker], j.tile = out;
    j.left = first.x, j.top = first.y;
    j.max_dx = fmaxf(fabsf(first.x), fabsf(first.x + DAFT_TILE));
    j.max_dy = fmaxf(fabsf(first.y), fabsf(first.y - DAFT_TILE));
    j.farthest = -INFINITY, j.stale = false;
    clear_pixels(&j);
    for (int i = 0; i < raster->workers; i++) draw_list(&j, &raster->bins[i], raster->bins[i].tiles[tile]);
    write_rows(&j, out);
}

const daft_raster_kernels DAFT_KERNEL(daft_raster) = {DAFT_KERNEL(daft_bin), resolve_tile};
