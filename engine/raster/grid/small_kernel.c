/* Triangles of a pixel's size or less, as dense meshes have them, in two steps. First, triangles are moved to camera
 * space and projected; those whose screen box holds no pixel's ray are dropped, the rest compacted. Second, of these,
 * small ones (boxes of at most two pixels a side) are tested at once at each of their up to four pixels; larger ones
 * are queued for set-up (setup_kernel.c). Lanes are triangles. No branch depends on a triangle, since most would be
 * mispredicted, and each step runs over many registers before the next, so that the processor can overlap them.
 *
 * Error bounds. Corners in the picture, relative to a pixel: u = 2^-24; the scale focal/z rounds once, its product with
 * x once, the difference with the tile's place once more, so that x is off by less than 2u·R with R = the largest x or
 * y of a ray in the tile plus two tiles plus twice the triangle's extent (its width and height together). An edge
 * function about a pixel within its box, e0 = x1·y2 - y1·x2 and so on, is then off by less than D = 5u·R·extent:
 * 4u·R·extent from corners, 3u of each product from its own roundings. Where rays lie beside their pixels' places, up
 * to twice as far beside the box, twice that on either side is added to the extent in D. Beyond D the sign is sure. The
 * three make up twice the area, so that its sign is sure beyond 4D; where it is not, some edge function is within 2D of
 * 0.
 *
 * Depth: the pixel is the mean of the corners, weighted by the edge functions, and so is 1/z. With weights that are off
 * by D, and their sum by as much again, the mean is off by less than 4D·(the largest 1/z - the least)/sum, and by 16u
 * of the largest from roundings. */
#include "math/simd/ops.h"
#include "raster/grid/grid.h"

/* The pixels within low..high and the slack, or but for a part in 2^12 there; none: end is below first, which is no
 * larger than `most`. */
DAFT_INLINE void pixel_range(vf low, vf high, float last, float max, float widen, vi *first, vi *end)
{
    vf slack = vf_set(widen), up = vf_set(1 - 0x1p-12f - widen);
    *first = vi_convert_to(vf_min(vf_max(low + up, vf_set(0)), vf_set(max)));
    *end = vi_convert_to(vf_min(high + slack, vf_set(last)));
}

DAFT_INLINE void edges_at(const vf a[3], const vf b[3], vf e[3])
{
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        e[k] = a[i] * b[j] - b[i] * a[j];
    }
}

/* An instance as a tile sees it: copied, since what is stored might be in its place as far as a compiler knows. */
typedef struct lens {
    daft_affine map;
    float focal, left, top, last_x, last_y, side, reach, slack;
    bool closely; /* no triangle counts as small */
    bool clips;
    float clip[4];
} lens;

DAFT_INLINE lens lens_of(const daft_tile_job *job, const daft_view_instance *view)
{
    bool closely = job->pencil.intersection == DAFT_INTERSECT_WATERTIGHT;
    lens v = {view->to_view, job->pencil.focal,    job->left,  job->top, job->last_x, job->last_y,
              job->side,     daft_tile_reach(job), job->slack, closely,  job->clips,  {0}};
    if (v.clips) memcpy(v.clip, job->clip, sizeof v.clip);
    return v;
}

/* D of the above, times a power of two; reach: a lens's. */
DAFT_INLINE vf doubt_of(float reach, vf extent, float times)
{
    return vf_set(times * 5 * UNIT) * (vf_set(reach) + (extent + extent)) * (extent + vf_set(0x1p-4f));
}

/* A point in the picture: the focal length over z, and x and y in pixels of the tile. */
typedef struct spot {
    vf x, y, scale;
} spot;

DAFT_INLINE spot spot_of(const lens *v, const vf3 *p)
{
    vf scale = vf_set(v->focal) / p->z;
    return (spot){p->x * scale - vf_set(v->left), vf_set(v->top) - p->y * scale, scale};
}

/* Pixels of the tile, inclusive. */
typedef struct box {
    vi x0, x1, y0, y1;
} box;

DAFT_INLINE vi box_bytes(const box *b) { return b->x0 | b->x1 << 8 | b->y0 << 16 | b->y1 << 24; }

/* The lanes of triangles that may be seen; of all of them the pixels, and which are small. */
DAFT_INLINE vbits may_be_seen(const lens *v, const spot at[3], const vf3 *corner, box *b, vbits *little)
{
    vf zero = vf_set(0), x[3], y[3];
    for (int k = 0; k < 3; k++) x[k] = at[k].x, y[k] = at[k].y;
    vf low_x = vf_min(vf_min(x[0], x[1]), x[2]), high_x = vf_max(vf_max(x[0], x[1]), x[2]);
    vf low_y = vf_min(vf_min(y[0], y[1]), y[2]), high_y = vf_max(vf_max(y[0], y[1]), y[2]);
    *little = v->closely ? 0 : DAFT_ALL_LANES;
    /* A triangle through the camera's plane may reach anywhere. */
    vf min = vf_min(vf_min(corner[0].z, corner[1].z), corner[2].z),
       max = vf_max(vf_max(corner[0].z, corner[1].z), corner[2].z);
    vm front = vf_lt(zero, min);
    low_x = vf_if_then_else(front, low_x, zero), high_x = vf_if_then_else(front, high_x, vf_set(v->side));
    low_y = vf_if_then_else(front, low_y, zero), high_y = vf_if_then_else(front, high_y, vf_set(v->side));
    vbits out = ~vbits_from_mask(vf_lt(zero, max));
    *little &= vbits_from_mask(front);
    pixel_range(low_x, high_x, v->last_x, 2 * v->side, v->slack, &b->x0, &b->x1);
    pixel_range(low_y, high_y, v->last_y, 2 * v->side, v->slack, &b->y0, &b->y1);
    *little &= vbits_from_mask(vi_lt((b->x1 - b->x0) | (b->y1 - b->y0), vi_set(2)));
    return DAFT_ALL_LANES & ~(out | vbits_from_mask(vi_lt(b->x1, b->x0)) | vbits_from_mask(vi_lt(b->y1, b->y0)));
}

/* Small triangles go side by side. */
DAFT_INLINE uint32_t add_small(daft_small *out, uint32_t n, const spot at[3], vi triangle, vbits lanes)
{
    for (int k = 0; k < 3; k++) {
        vf_compress_store(&out->x[k][n], lanes, at[k].x);
        vf_compress_store(&out->y[k][n], lanes, at[k].y);
        vf_compress_store(&out->scale[k][n], lanes, at[k].scale);
    }
    vi_compress_store(&out->triangle[n], lanes, triangle);
    return n + (uint32_t)__builtin_popcount(lanes);
}

/* And others wait to be set up. */
DAFT_INLINE void add_large(daft_queue *out, const vf3 corner[3], vi pixels, uint32_t instance, vi triangle, vbits lanes)
{
    vf min = vf_min(vf_min(corner[0].z, corner[1].z), corner[2].z);
    vf nearest = vf_if_then_else(vf_lt(vf_set(0), min), vf_set(1 + 4 * UNIT) / min, vf_set(INFINITY));
    queue_add(out, corner, pixels, nearest, instance, triangle, lanes);
}

void DAFT_KERNEL(daft_blocks_project)(const daft_tile_job *job, const daft_view_instance *view, const uint32_t *blocks,
                                      uint32_t count, daft_queue *out)
{
    const lens v = lens_of(job, view);
    uint32_t tested = 0, n = out->small.count;
    for (uint32_t i = 0; i < count; i += DAFT_BATCH_BLOCKS) {
        const daft_block *all[DAFT_BATCH_BLOCKS];
        uint32_t some = daft_min_u(count - i, DAFT_BATCH_BLOCKS);
        blocks_at(view, &blocks[i], some, all);
        vi triangle = blocks_triangles(all);
        box pixels;
        vf3 corner[3];
        spot at[3];
        for (int k = 0; k < 3; k++) {
            corner[k] = blocks_corner(&v.map, all, k);
            at[k] = spot_of(&v, &corner[k]);
        }
        vbits there = ~vbits_from_mask(vi_eq(triangle, vi_set((int32_t)DAFT_NO_TRIANGLE))) &
                      vbits_first_n((int)(some * DAFT_BLOCK)),
              little;
        vbits lanes = there & may_be_seen(&v, at, corner, &pixels, &little);
        if (v.clips) lanes &= ~clipped(v.clip, corner);
        n = add_small(&out->small, n, at, triangle, lanes & little);
        if (lanes & ~little) add_large(out, corner, box_bytes(&pixels), view->index, triangle, lanes & ~little);
        tested += (uint32_t)__builtin_popcount(there);
    }
    out->small.count = n;
    job->counters->tested += tested;
}

/* ---- pixels ---- */

/* Small triangles: x and y of corners less those of the first column and row; the sign that makes edge functions
 * positive inside; w = base + (e1·slope1 + e2·slope2). */
typedef struct small {
    vf x[3], y[3], doubt;
    vi sign;
    vf base, slope[2];
    vf min, max, error; /* of w; only where floats are to be sure */
} small;

enum { PIXELS = 4, BATCHES = 16 /* registers */ };

/* Registers of triangles: of each of their first pixel, its right neighbour and the two below, which of them cover it,
 * or may, and w. */
typedef struct coverage {
    _Alignas(4 * DAFT_VL) float low[BATCHES][PIXELS][DAFT_VL], high[BATCHES][PIXELS][DAFT_VL];
    int32_t place[BATCHES][DAFT_VL];
    vbits lanes[BATCHES][PIXELS], unsure[BATCHES][PIXELS];
} coverage;

/* Where a pixel's ray lies from the place of the first one, y downwards; x0 and y0: that one's column and row. */
DAFT_INLINE void ray_from_first(bool turned, float turn, int pixel, vi x0, vi y0, vf *x, vf *y)
{
    const int right = pixel & 1, below = pixel >> 1;
    *x = vf_set((float)right), *y = vf_set((float)below);
    if (!turned) return;
    const vi four = vi_set(3);
    const vf middle = vf_set(1.5f), by = vf_set(turn);
    *x += (vf_convert_to((y0 + vi_set(below)) & four) - middle) * by;
    *y -= (vf_convert_to((x0 + vi_set(right)) & four) - middle) * by;
}

DAFT_INLINE void cover_pixel(bool exact, const small *s, vf x, vf y, int pixel, vbits lanes, coverage *c, uint32_t i)
{
    vf e[3], a[3], b[3];
    for (int k = 0; k < 3; k++) a[k] = s->x[k] - x, b[k] = vf_xor(s->y[k] - y, s->sign);
    edges_at(a, b, e);
    vf inner = vf_min(vf_min(e[0], e[1]), e[2]), w = s->base + (e[1] * s->slope[0] + e[2] * s->slope[1]), low = w;
    if (exact) {
        lanes &= vbits_from_mask(vf_le(vf_set(-2.25f) * s->doubt, inner));
        vm sure = vf_le(s->doubt, inner);
        low = vf_if_then_else(sure, w - s->error, s->min);
        vf_store(c->high[i][pixel], vf_if_then_else(sure, w + s->error, s->max));
        c->unsure[i][pixel] = lanes & ~vbits_from_mask(sure);
    } else
        lanes &= vbits_from_mask(vf_le(vf_set(0), inner));
    vf_store(c->low[i][pixel], low);
    c->lanes[i][pixel] = lanes;
}

DAFT_INLINE void small_setup(const daft_tile_job *job, bool exact, const vf x[3], const vf y[3], const vf scale[3],
                             vi x0, vi y0, small *s)
{
    vf px = vf_convert_to(x0), py = vf_convert_to(y0), e[3], over_focal = vf_set(1 / job->pencil.focal);
    for (int k = 0; k < 3; k++) s->x[k] = x[k] - px, s->y[k] = y[k] - py;
    edges_at(s->x, s->y, e);
    vf area = e[0] + e[1] + e[2];
    s->sign = (vi)area & vi_set(INT32_MIN);
    vf inverse = over_focal / vf_abs(area);
    s->base = scale[0] * over_focal, s->slope[0] = (scale[1] - scale[0]) * inverse,
    s->slope[1] = (scale[2] - scale[0]) * inverse;
    if (!exact) return;
    vf extent = vf_max(vf_max(x[0], x[1]), x[2]) - vf_min(vf_min(x[0], x[1]), x[2]);
    extent += vf_max(vf_max(y[0], y[1]), y[2]) - vf_min(vf_min(y[0], y[1]), y[2]);
    vf min = vf_min(vf_min(scale[0], scale[1]), scale[2]), max = vf_max(vf_max(scale[0], scale[1]), scale[2]);
    s->doubt = doubt_of(daft_tile_reach(job), extent + vf_set(4.25f * job->spread), 1);
    s->error = vf_set(4) * s->doubt * (max - min) * inverse + vf_set(16 * UNIT) * max * over_focal;
    s->min = min * over_focal * vf_set(1 - 16 * UNIT), s->max = max * over_focal * vf_set(1 + 16 * UNIT);
}

/* Register i: the triangles from one on. */
DAFT_INLINE void cover(const daft_tile_job *job, bool exact, bool turned, const daft_small *from, uint32_t at,
                       coverage *c, uint32_t i)
{
    const int stride = turned ? DAFT_FINE_SIDE : DAFT_TILE_STRIDE;
    vf x[3], y[3], scale[3];
    box b;
    small s;
    for (int k = 0; k < 3; k++)
        x[k] = vf_load(&from->x[k][at]), y[k] = vf_load(&from->y[k][at]), scale[k] = vf_load(&from->scale[k][at]);
    pixel_range(vf_min(vf_min(x[0], x[1]), x[2]), vf_max(vf_max(x[0], x[1]), x[2]), job->last_x, job->last_x,
                job->slack, &b.x0, &b.x1);
    pixel_range(vf_min(vf_min(y[0], y[1]), y[2]), vf_max(vf_max(y[0], y[1]), y[2]), job->last_y, job->last_y,
                job->slack, &b.y0, &b.y1);
    vbits lanes = vbits_first_n((int)(from->count - at)), right = vbits_from_mask(vi_lt(b.x0, b.x1)),
          below = vbits_from_mask(vi_lt(b.y0, b.y1));
    small_setup(job, exact, x, y, scale, b.x0, b.y0, &s);
    if (!exact) lanes &= vbits_from_mask(vf_lt(vf_abs(s.slope[0]) + vf_abs(s.slope[1]), vf_set(INFINITY)));
    vi_store(c->place[i], b.y0 * vi_set(stride) + b.x0 + ((vi_iota() + vi_set((int32_t)at)) << DAFT_HIT_TRIANGLE));
    const vbits of[PIXELS] = {lanes, lanes & right, lanes & below, lanes & right & below};
    for (int pixel = 0; pixel < PIXELS; pixel++) {
        vf dx, dy;
        ray_from_first(turned, job->pencil.turn, pixel, b.x0, b.y0, &dx, &dy);
        cover_pixel(exact, &s, dx, dy, pixel, of[pixel], c, i);
    }
}

/* The numbers of their corners are on their way from memory from now on. */
static __attribute__((noinline)) void add_doubted(const daft_small *from, const int32_t *place, vbits lanes,
                                                  daft_hits *out)
{
    for (; lanes && out->doubted_count < DAFT_DOUBTED; lanes &= lanes - 1) {
        uint32_t number = (uint32_t)place[__builtin_ctz(lanes)] >> DAFT_HIT_TRIANGLE;
        __builtin_prefetch(&from->view->mesh->indices[3 * (size_t)from->triangle[number]]);
        out->doubted[out->doubted_count++] = number;
    }
}

DAFT_INLINE uint32_t add_hits(bool exact, bool turned, const coverage *c, uint32_t i, int pixel, uint32_t n,
                              daft_hits *out)
{
    const int stride = turned ? DAFT_FINE_SIDE : DAFT_TILE_STRIDE;
    vbits lanes = c->lanes[i][pixel];
    vi place = vi_load(c->place[i]) + vi_set((pixel >> 1) * stride + (pixel & 1));
    if (exact) {
        place |= vi_if_then_else(vm_from_bits(c->unsure[i][pixel]), vi_set(DAFT_HIT_UNSURE), vi_set(0));
        vf_compress_store(&out->high[n], lanes, vf_load(c->high[i][pixel]));
    }
    vi_compress_store(&out->place[n], lanes, place);
    vf_compress_store(&out->low[n], lanes, vf_load(c->low[i][pixel]));
    return n + (uint32_t)__builtin_popcount(lanes);
}

DAFT_INLINE void find_hits(const daft_tile_job *job, bool exact, bool turned, const daft_small *from, daft_hits *out)
{
    coverage c;
    uint32_t n = out->count;
    for (uint32_t first = 0; first < from->count; first += BATCHES * DAFT_VL) {
        uint32_t count = daft_min_u((from->count - first + DAFT_VL - 1) / DAFT_VL, BATCHES);
        for (uint32_t i = 0; i < count; i++) cover(job, exact, turned, from, first + i * DAFT_VL, &c, i);
        for (uint32_t i = 0; i < count; i++) {
            for (int pixel = 0; pixel < PIXELS; pixel++) n = add_hits(exact, turned, &c, i, pixel, n, out);
            vbits unsure = exact ? c.unsure[i][0] | c.unsure[i][1] | c.unsure[i][2] | c.unsure[i][3] : 0;
            if (unsure) add_doubted(from, c.place[i], unsure, out);
        }
    }
    out->count = n;
}

void DAFT_KERNEL(daft_small_hits)(const daft_tile_job *job, const daft_small *from, daft_hits *out)
{
    job->counters->binned += from->count;
    const bool turned = job->pencil.turn != 0;
    if (job->exact && !turned)
        find_hits(job, true, false, from, out);
    else if (job->exact)
        find_hits(job, true, true, from, out);
    else if (!turned)
        find_hits(job, false, false, from, out);
    else
        find_hits(job, false, true, from, out);
}
