/* Resolving a tile. The triangles binned into it are set up DAFT_VL at a time, then each is tested against the rays of the
 * rows its box covers, DAFT_VL rays at a time.
 *
 * Edge functions. The plane of the origin and an edge a, b has the normal n = (a - b) × (a + b) = 2·a × b; exchanging a and
 * b negates each bit, so neighbours see the same number. e = n·d is positive on the inner side after all three are turned
 * by the sign of det(a, b, c). With u = 2^-24: a - b and a + b round once, each product once, their difference once, so a
 * component of n is off by at most 4u·M with M = |x|·|y'| + |y|·|x'| of its two products; the three products with d and two
 * sums add 3u·|n|·|d|. Together |error(e)| <= 7u·(Mx·|dx| + My·|dy| + Mz·|dz|) to first order; the bound takes 8u, which
 * covers its own roundings, and adds TINY for underflow. An e that is NaN or infinite is never "sure".
 *
 * Depth. z = Σ e·z / Σ e with negative e as 0, so it lies within the corners' z; off by at most 6·bound·range / Σ e (each e
 * is off by at most bound) plus rounding, 2^-20 of the largest |z|. */
#include "math/exact.h"
#include "math/isa.h"
#include "math/simd.h"
#include "raster/kernels.h"

void DAFT_KERNEL(daft_bin)(const daft_raster *raster, uint32_t work, uint32_t worker);

#define UNIT 0x1p-24f
#define TINY 1e-36f
#define DEPTH_ROUNDING 0x1p-20f

enum { RECORD_WORDS = sizeof(daft_record) / sizeof(float) };

/* Up to DAFT_VL triangles, set up. Edge k is opposite corner k. */
typedef struct batch {
    float nx[3][DAFT_VL], ny[3][DAFT_VL], nz[3][DAFT_VL]; /* nz times the focal length */
    float bound[DAFT_VL], z[3][DAFT_VL], slack[DAFT_VL], rounding[DAFT_VL], z_min[DAFT_VL];
    const daft_record *record[DAFT_VL];
    vbits live;
    bool exact;
} batch;

typedef struct job {
    const daft_raster *raster;
    daft_bins *counters;
    daft_tile *tile;
    float left, top;      /* ray of the tile's first pixel */
    float max_dx, max_dy; /* of any ray in the tile */
    float farthest;       /* no pixel of the tile sees further; +inf while one sees nothing */
    bool stale;           /* farthest may have come nearer */
} job;

/* ---- single lanes that floats could not decide ---- */

static daft_vec3 lane_ray(const job *j, int at)
{
    return daft_pencil_ray(&j->raster->pencil, j->tile->x + at % DAFT_TILE_STRIDE, j->tile->y + at / DAFT_TILE_STRIDE);
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

static void lane_write(daft_tile *tile, int at, const daft_record *r, float low, float high)
{
    tile->z_low[at] = low;
    tile->z_high[at] = high;
    tile->instance[at] = r->instance;
    tile->triangle[at] = r->triangle == DAFT_SPHERE ? 0 : r->triangle;
}

/* The depths are too close for floats: compare the true ones, then the numbers. */
static void lane_compare(job *j, int at, const daft_record *r, float low, float high)
{
    daft_tile *tile = j->tile;
    daft_vec3 ray = lane_ray(j, at);
    uint32_t triangle = r->triangle == DAFT_SPHERE ? 0 : r->triangle;
    const daft_seen *seen = &j->raster->seen[j->raster->seen_of[tile->instance[at]]];
    double mine = record_depth(r, ray), other = daft_seen_depth(seen, tile->triangle[at], ray);
    j->counters->exact_depths++;
    bool wins = mine < other || (mine == other && (r->instance < tile->instance[at] ||
                                                   (r->instance == tile->instance[at] && triangle < tile->triangle[at])));
    if (wins) lane_write(tile, at, r, low, high);
}

/* A hit with its depth interval: nearer, farther, or to be looked at closely. */
static void lane_offer(job *j, int at, const daft_record *r, float low, float high)
{
    daft_tile *tile = j->tile;
    if (!(low <= high)) low = -INFINITY, high = INFINITY; /* an overflow: nothing is known */
    if (tile->instance[at] == DAFT_NOTHING || high < tile->z_low[at])
        lane_write(tile, at, r, low, high);
    else if (!(low > tile->z_high[at]))
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
    return vf_set(8 * UNIT) * (e->mx * dx + e->my * dy + e->mz * dz) + vf_set(TINY);
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
DAFT_INLINE vbits beyond_tile(const job *j, const vf3 n[3], vf bound)
{
    vf x0 = vf_set(j->left), x1 = vf_set(j->left + DAFT_TILE - 1), y0 = vf_set(j->top - DAFT_TILE + 1), y1 = vf_set(j->top);
    vm out = vm_from_bits(0);
    for (int k = 0; k < 3; k++) {
        vf most = vf_max(n[k].x * x0, n[k].x * x1) + (vf_max(n[k].y * y0, n[k].y * y1) + n[k].z);
        out = vm_or(out, vf_lt(most, -bound));
    }
    return vm_bits(out);
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
    vf bound = vf_max(edge_bound(&e[0], dx, dy, dz), vf_max(edge_bound(&e[1], dx, dy, dz), edge_bound(&e[2], dx, dy, dz)));
    vf3 n[3];
    for (int k = 0; k < 3; k++) {
        n[k] = (vf3){vf_xor_sign(e[k].n.x, sign), vf_xor_sign(e[k].n.y, sign), vf_xor_sign(e[k].n.z, sign) * dz};
        vf_store(b->nx[k], n[k].x), vf_store(b->ny[k], n[k].y), vf_store(b->nz[k], n[k].z);
        vf_store(b->z[k], corner[k].z);
    }
    vf low = vf_min(corner[0].z, vf_min(corner[1].z, corner[2].z)), high = vf_max(corner[0].z, vf_max(corner[1].z, corner[2].z));
    vf largest = vf_max(vf_abs(low), vf_abs(high));
    vf_store(b->bound, bound);
    vf_store(b->slack, vf_set(6) * bound * (high - low));
    vf_store(b->rounding, largest * vf_set(DEPTH_ROUNDING) + vf_set(TINY));
    vf_store(b->z_min, low);
    b->live = (live & ~beyond_tile(j, n, bound)) | spheres;
}

/* ---- rows ---- */

typedef struct rect {
    int x0, x1, y0, y1; /* within the tile, inclusive */
} rect;

DAFT_INLINE rect record_rect(const job *j, const daft_record *r)
{
    const daft_tile *t = j->tile;
    return (rect){daft_max_i(r->x0 - t->x, 0), daft_min_i(r->x1 - t->x, t->width - 1), daft_max_i(r->y0 - t->y, 0),
                  daft_min_i(r->y1 - t->y, t->height - 1)};
}

/* Offers `hits` lanes with depth intervals to the tile: decided in lanes where the intervals are apart. */
DAFT_INLINE void offer(job *j, int at, const daft_record *r, vbits hits, vbits unsure, vf low, vf high)
{
    daft_tile *tile = j->tile;
    vf old_low = vf_load(&tile->z_low[at]), old_high = vf_load(&tile->z_high[at]);
    vbits nearer = vm_bits(vf_lt(high, old_low)), farther = vm_bits(vf_lt(old_high, low));
    unsure &= ~farther;
    vbits close = hits & ~nearer & ~farther;
    vbits take = hits & nearer & ~unsure;
    if (take) {
        vm m = vm_from_bits(take);
        vi instance = vi_set((int32_t)r->instance), triangle = vi_set((int32_t)(r->triangle == DAFT_SPHERE ? 0 : r->triangle));
        vf_store(&tile->z_low[at], vf_select(m, low, old_low));
        vf_store(&tile->z_high[at], vf_select(m, high, old_high));
        vi_store(&tile->instance[at], vi_select(m, instance, vi_load(&tile->instance[at])));
        vi_store(&tile->triangle[at], vi_select(m, triangle, vi_load(&tile->triangle[at])));
        j->stale = true;
    }
    vbits look = (close | unsure) & hits;
    while (look) {
        int i = __builtin_ctz(look);
        look &= look - 1;
        if ((unsure >> i & 1) && (r->triangle == DAFT_SPHERE ? isinf(record_depth(r, lane_ray(j, at + i)))
                                                              : !lane_inside(j, at + i, r)))
            continue;
        lane_offer(j, at + i, r, low[i], high[i]);
        j->stale = true;
    }
}

/* exact: as the head of this file says. Otherwise the floats' word is taken: inside is e >= 0, and depths have no error. */
DAFT_INLINE void triangle_rows(job *j, const batch *b, int i, bool exact)
{
    const daft_record *r = b->record[i];
    rect box = record_rect(j, r);
    vf nx0 = vf_set(b->nx[0][i]), nx1 = vf_set(b->nx[1][i]), nx2 = vf_set(b->nx[2][i]);
    vf z0 = vf_set(b->z[0][i]), z1 = vf_set(b->z[1][i]), z2 = vf_set(b->z[2][i]);
    vf bound = vf_set(b->bound[i]), slack = vf_set(b->slack[i]), rounding = vf_set(b->rounding[i]), zero = vf_set(0);
    vf z_min = vf_set(b->z_min[i]);
    for (int y = box.y0; y <= box.y1; y++) {
        float dy = j->top - (float)y;
        vf row0 = vf_set(b->ny[0][i] * dy + b->nz[0][i]), row1 = vf_set(b->ny[1][i] * dy + b->nz[1][i]),
           row2 = vf_set(b->ny[2][i] * dy + b->nz[2][i]);
        for (int x = box.x0; x <= box.x1; x += DAFT_VL) {
            vf dx = vf_set(j->left + (float)x) + vf_iota();
            vf e0 = nx0 * dx + row0, e1 = nx1 * dx + row1, e2 = nx2 * dx + row2;
            vf least = vf_min(vf_min(e0, e1), e2); /* NaN in e0 or e1 falls through to e2's test or below */
            vbits lanes = vbits_first(box.x1 - x + 1);
            if (!exact) {
                vbits inside = lanes & vm_bits(vf_le(zero, least));
                if (!inside) continue;
                vf depth = vf_max((e0 * z0 + e1 * z1 + e2 * z2) / (e0 + e1 + e2), z_min);
                offer(j, y * DAFT_TILE_STRIDE + x, r, inside, 0, depth, depth);
                continue;
            }
            vf sum = e0 + e1 + e2;
            vbits out = vm_bits(vf_lt(least, -bound)), whole = vm_bits(vf_lt(vf_abs(sum), vf_set(INFINITY)));
            vbits hits = lanes & ~(out & whole);
            if (!hits) continue;
            vbits unsure = hits & ~(vm_bits(vf_lt(bound, least)) & whole);
            e0 = vf_max(e0, zero), e1 = vf_max(e1, zero), e2 = vf_max(e2, zero);
            vf inverse = vf_set(1) / (e0 + e1 + e2);
            vf z = (e0 * z0 + e1 * z1 + e2 * z2) * inverse, error = slack * inverse + rounding;
            /* where nothing can be said, the interval is everything: NaN compares as neither nearer nor farther */
            offer(j, y * DAFT_TILE_STRIDE + x, r, hits, unsure, z - error, z + error);
        }
    }
}

/* |error(discriminant)| <= 32u·(|c| + r)², from a projection that is off by a few u·|c| and is squared. Its root is then off
 * by less than 2·error / max(root, sqrt(error)). */
static void sphere_rows(job *j, const daft_record *r)
{
    rect box = record_rect(j, r);
    float cx = r->corner[0], cy = r->corner[1], cz = r->corner[2], radius = r->corner[3], f = j->raster->pencil.focal;
    float reach = sqrtf(cx * cx + cy * cy + cz * cz) + radius, limit = 32 * UNIT * reach * reach + TINY;
    vf vx = vf_set(cx), vy = vf_set(cy), vz = vf_set(cz), vfocal = vf_set(f), doubt = vf_set(limit), one = vf_set(1);
    vf r2 = vf_set(radius * radius), root_doubt = vf_set(sqrtf(limit)), rounding = vf_set(reach * 4 * DEPTH_ROUNDING);
    for (int y = box.y0; y <= box.y1; y++) {
        vf dy = vf_set(j->top - (float)y);
        for (int x = box.x0; x <= box.x1; x += DAFT_VL) {
            vf dx = vf_set(j->left + (float)x) + vf_iota();
            vf inverse = one / (dx * dx + dy * dy + vfocal * vfocal), along = (dx * vx + dy * vy + vfocal * vz) * inverse;
            vf ax = vx - dx * along, ay = vy - dy * along, az = vz - vfocal * along;
            vf disc = r2 - (ax * ax + ay * ay + az * az);
            vbits lanes = vbits_first(box.x1 - x + 1) & ~vm_bits(vf_lt(disc, -doubt));
            if (!lanes) continue;
            vbits unsure = lanes & ~vm_bits(vf_lt(doubt, disc));
            vf chord = vf_sqrt(vf_max(disc, vf_set(0))), half = chord * vf_sqrt(inverse);
            vf error = vf_set(2) * doubt / vf_max(chord, root_doubt) + rounding;
            vf near = (along - half) * vfocal, far = (along + half) * vfocal;
            vbits ahead = vm_bits(vf_lt(error, near)), behind = vm_bits(vf_lt(near, -error));
            vbits inside = vm_bits(vf_lt(error, far)) & behind;
            unsure |= lanes & ~ahead & ~inside;
            lanes &= ~(behind & vm_bits(vf_lt(far, -error)));
            vf z = vf_select(vm_from_bits(ahead), near, far);
            vm known = vm_from_bits(ahead | inside);
            vf low = vf_select(known, z - error, vf_min(near, far) - error), high = vf_select(known, z + error, far + error);
            offer(j, y * DAFT_TILE_STRIDE + x, r, lanes, unsure & lanes, low, high);
        }
    }
}

/* ---- the tile ---- */

static float find_farthest(const daft_tile *tile)
{
    vf most = vf_set(-INFINITY);
    for (int y = 0; y < tile->height; y++) {
        for (int x = 0; x < tile->width; x += DAFT_VL) {
            vf z = vf_load(&tile->z_high[y * DAFT_TILE_STRIDE + x]);
            vm lanes = vm_from_bits(vbits_first(tile->width - x));
            most = vf_max(most, vf_select(lanes, z, vf_set(-INFINITY)));
        }
    }
    return vf_reduce_max(most);
}

static void batch_draw(job *j, const batch *b)
{
    for (vbits live = b->live; live; live &= live - 1) {
        int i = __builtin_ctz(live);
        if (b->record[i]->triangle == DAFT_SPHERE)
            sphere_rows(j, b->record[i]);
        else if (!(b->z_min[i] > j->farthest))
            b->exact ? triangle_rows(j, b, i, true) : triangle_rows(j, b, i, false);
    }
    if (!j->stale) return;
    j->farthest = find_farthest(j->tile);
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

static void resolve_tile(const daft_raster *raster, uint32_t tile, uint32_t worker, daft_tile *out)
{
    daft_tile_clear(raster, tile, out);
    daft_vec3 first = daft_pencil_ray(&raster->pencil, out->x, out->y);
    job j = {.raster = raster,
             .counters = &raster->bins[worker],
             .tile = out,
             .left = first.x,
             .top = first.y,
             .max_dx = fmaxf(fabsf(first.x), fabsf(first.x + DAFT_TILE)),
             .max_dy = fmaxf(fabsf(first.y), fabsf(first.y - DAFT_TILE)),
             .farthest = INFINITY};
    for (int i = 0; i < raster->workers; i++) draw_list(&j, &raster->bins[i], raster->bins[i].tiles[tile]);
}

const daft_raster_kernels DAFT_KERNEL(daft_raster) = {DAFT_KERNEL(daft_bin), resolve_tile};
