/* Triangles of dense meshes in two steps. First they are moved to camera space and projected; one is dropped when its screen box
 * holds no pixel's ray, or when it is seen from a back that does not count. What is left stands side by side. Second, of these,
 * small ones (with boxes of two pixels a side at most) are decided at once, at each of their up to four pixels, and others wait
 * to be set up. Neither step has a branch that depends on triangles: a wrong guess would wait for the end of a long step.
 *
 * Corners in the picture, relative to a pixel: u = 2^-24; the scale focal/z rounds once, its product with x once, the
 * difference with the tile's place once more, so that x is off by less than 2u·R with R = the largest x or y of a ray in the
 * tile, 64 and twice the triangle's extent (its width and height together) in sum. An edge function about a pixel within its
 * box, e0 = x1·y2 - y1·x2 and so on, is then off by less than D = 5u·R·extent: 4u·R·extent from corners, 3u of each product from
 * its own roundings. Beyond D the sign is sure. The three make up twice the area, so that its sign is sure beyond 4D;
 * where it is not, some edge function is within 2D of 0.
 *
 * Depth: the pixel is the mean of the corners, weighted by the edge functions, and so is 1/z. With weights that are off by D, and
 * their sum by as much again, the mean is off by less than 4D·(the largest 1/z - the least)/sum, and by 16u of the largest from
 * roundings. */
#include "raster/blocks.h"

/* The pixels within low..high and the slack, or but for a part in 2^8 there; none: end is below first. */
DAFT_INLINE void pixel_range(vf low, vf high, float last, vi *first, vi *end)
{
    vf slack = vf_set(DAFT_SCREEN_SLACK), up = vf_set(1 - 0x1p-8f - DAFT_SCREEN_SLACK);
    *first = vi_truncate(vf_min(vf_max(low + up, vf_set(0)), vf_set(2 * DAFT_TILE)));
    *end = vi_truncate(vf_min(high + slack, vf_set(last)));
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
    float focal, left, top, last_x, last_y, reach;
    int front;
} lens;

DAFT_INLINE lens lens_of(const daft_tile_job *job, const daft_seen *seen)
{
    float reach = fmaxf(job->max_dx, job->max_dy) + 2 * DAFT_TILE;
    return (lens){seen->to_camera, job->raster->pencil.focal, job->left, job->top, job->last_x, job->last_y, reach, seen->front};
}

/* D of the above. */
DAFT_INLINE vf doubt_of(const lens *v, vf extent)
{
    return vf_set(5 * UNIT) * (vf_set(v->reach) + (extent + extent)) * (extent + vf_set(0x1p-4f));
}

/* The lanes of triangles that may be seen; and of all of them corners, numbers and pixels. `ahead`: all corners are in front of the
 * camera. */
DAFT_INLINE vbits project(const lens *v, const daft_block **blocks, vbits one_sided, bool ahead, vf3 corner[3], vi *pixels)
{
    vf zero = vf_set(0), focal = vf_set(v->focal), inf = vf_set(INFINITY), least = inf, most = -inf, x[3], y[3];
    for (int k = 0; k < 3; k++) {
        vf3 p = {blocks_load(blocks, k, 0), blocks_load(blocks, k, 1), blocks_load(blocks, k, 2)};
        corner[k] = move(&v->map, p);
        vf scale = focal / corner[k].z;
        x[k] = corner[k].x * scale - vf_set(v->left), y[k] = vf_set(v->top) - corner[k].y * scale;
        if (!ahead) least = vf_min(corner[k].z, least), most = vf_max(corner[k].z, most);
    }
    vf low_x = vf_min(vf_min(x[0], x[1]), x[2]), high_x = vf_max(vf_max(x[0], x[1]), x[2]);
    vf low_y = vf_min(vf_min(y[0], y[1]), y[2]), high_y = vf_max(vf_max(y[0], y[1]), y[2]);
    vf area = (x[2] - x[0]) * (y[1] - y[0]) - (x[1] - x[0]) * (y[2] - y[0]); /* positive where det(corners) is: y points down */
    vf doubt = vf_set(-4) * doubt_of(v, (high_x - low_x) + (high_y - low_y));
    vbits out = one_sided & vm_bits(vf_lt(v->front < 0 ? -area : area, doubt));
    vi x0, x1, y0, y1;
    if (!ahead) { /* a triangle through the camera's plane may reach anywhere */
        vm front = vf_lt(zero, least);
        low_x = vf_select(front, low_x, zero), high_x = vf_select(front, high_x, vf_set(DAFT_TILE));
        low_y = vf_select(front, low_y, zero), high_y = vf_select(front, high_y, vf_set(DAFT_TILE));
        out = (out & vm_bits(front)) | ~vm_bits(vf_lt(zero, most));
    }
    pixel_range(low_x, high_x, v->last_x, &x0, &x1);
    pixel_range(low_y, high_y, v->last_y, &y0, &y1);
    vi flags = vi_set((int32_t)(DAFT_WAITS_ONE_SIDED | (v->front < 0 ? DAFT_WAITS_TURNED : 0)));
    *pixels = x0 | x1 << 8 | y0 << 16 | y1 << 24 | vi_select(vm_from_bits(one_sided), flags, vi_set(0));
    return DAFT_ALL_LANES & ~(out | vm_bits(vi_lt(x1, x0)) | vm_bits(vi_lt(y1, y0)));
}

DAFT_INLINE void project_all(const daft_tile_job *job, const daft_seen *seen, const uint32_t *blocks, uint32_t count, bool ahead, daft_projected *out)
{
    const lens v = lens_of(job, seen);
    uint32_t at = out->count;
    uint64_t tested = 0;
    for (uint32_t i = 0; i < count; i += DAFT_BATCH_BLOCKS) {
        const daft_block *all[DAFT_BATCH_BLOCKS];
        uint32_t some = daft_min_u(count - i, DAFT_BATCH_BLOCKS);
        blocks_at(seen, &blocks[i], some, all);
        vi triangle = blocks_triangles(all), pixels;
        vf3 corner[3];
        vbits there = ~vm_bits(vi_eq(triangle, vi_set((int32_t)DAFT_NO_TRIANGLE))) & vbits_first((int)(some * DAFT_BLOCK));
        vbits lanes = there & project(&v, all, v.front ? blocks_sides(seen, &blocks[i], some) : 0, ahead, corner, &pixels);
        for (int k = 0; k < 3; k++) {
            vf_compress(&out->corner[3 * k][at], lanes, corner[k].x);
            vf_compress(&out->corner[3 * k + 1][at], lanes, corner[k].y);
            vf_compress(&out->corner[3 * k + 2][at], lanes, corner[k].z);
        }
        vi_compress(&out->pixels[at], lanes, pixels);
        vi_compress(&out->triangle[at], lanes, triangle);
        at += (uint32_t)__builtin_popcount(lanes), tested += (uint64_t)__builtin_popcount(there);
    }
    out->count = at;
    job->counters->tested += tested;
}

void DAFT_KERNEL(daft_blocks_project)(const daft_tile_job *job, const daft_seen *seen, bool ahead, const uint32_t *blocks, uint32_t count,
                                      daft_projected *out)
{
    if (ahead)
        project_all(job, seen, blocks, count, true, out);
    else
        project_all(job, seen, blocks, count, false, out);
}

/* ---- pixels ---- */

/* Small triangles: a and b are x and y of corners less those of the first column and row, and of the next ones, y with the
 * sign that makes edge functions positive inside; w = base + (e1·slope1 + e2·slope2). */
typedef struct small {
    vf a[2][3], b[2][3], doubt;
    vf base, slope[2];
    vf least, most, error; /* of w; only where floats are to be sure */
    vi place, triangle;
} small;

/* Adds the lanes that cover the pixel `right` and `below` of their first one. */
DAFT_INLINE void add_hits(const daft_tile_job *job, const small *s, int right, int below, vbits lanes, daft_hits *out)
{
    vf e[3];
    edges_at(s->a[right], s->b[below], e);
    vf inner = vf_min(vf_min(e[0], e[1]), e[2]), w = s->base + (e[1] * s->slope[0] + e[2] * s->slope[1]), low = w, high = w;
    vi place = s->place + vi_set(below * DAFT_TILE_STRIDE + right);
    if (job->exact) {
        lanes &= vm_bits(vf_le(vf_set(-2.25f) * s->doubt, inner));
        vm sure = vf_le(s->doubt, inner);
        low = vf_select(sure, w - s->error, s->least), high = vf_select(sure, w + s->error, s->most);
        place = vi_select(sure, place, place | vi_set(DAFT_HIT_UNSURE));
        vf_compress(&out->high[out->count], lanes, high);
    } else
        lanes &= vm_bits(vf_le(vf_set(0), inner));
    vi_compress(&out->place[out->count], lanes, place);
    vi_compress(&out->triangle[out->count], lanes, s->triangle);
    vf_compress(&out->low[out->count], lanes, low);
    out->count += (uint32_t)__builtin_popcount(lanes);
}

DAFT_INLINE void small_setup(const daft_tile_job *job, const daft_seen *seen, const vf x[3], const vf y[3], const vf scale[3], vi x0, vi y0, small *s)
{
    const lens v = lens_of(job, seen);
    vf px = vf_from_int(x0), py = vf_from_int(y0), one = vf_set(1), e[3], over_focal = vf_set(1 / job->raster->pencil.focal);
    for (int k = 0; k < 3; k++) s->a[0][k] = x[k] - px, s->b[0][k] = y[k] - py;
    edges_at(s->a[0], s->b[0], e);
    vf area = e[0] + e[1] + e[2];
    vi sign = (vi)area & vi_set(INT32_MIN);
    for (int k = 0; k < 3; k++) {
        s->a[1][k] = s->a[0][k] - one, s->b[1][k] = vf_xor_sign(s->b[0][k] - one, sign);
        s->b[0][k] = vf_xor_sign(s->b[0][k], sign);
    }
    vf inverse = over_focal / vf_abs(area);
    s->base = scale[0] * over_focal, s->slope[0] = (scale[1] - scale[0]) * inverse, s->slope[1] = (scale[2] - scale[0]) * inverse;
    s->place = y0 * DAFT_TILE_STRIDE + x0;
    if (!job->exact) return;
    vf extent = vf_max(vf_max(x[0], x[1]), x[2]) - vf_min(vf_min(x[0], x[1]), x[2]);
    extent += vf_max(vf_max(y[0], y[1]), y[2]) - vf_min(vf_min(y[0], y[1]), y[2]);
    vf least = vf_min(vf_min(scale[0], scale[1]), scale[2]), most = vf_max(vf_max(scale[0], scale[1]), scale[2]);
    s->doubt = doubt_of(&v, extent);
    s->error = vf_set(4) * s->doubt * (most - least) * inverse + vf_set(16 * UNIT) * most * over_focal;
    s->least = least * over_focal * vf_set(1 - 16 * UNIT), s->most = most * over_focal * vf_set(1 + 16 * UNIT);
}

void DAFT_KERNEL(daft_projected_take)(const daft_tile_job *job, const daft_seen *seen, daft_projected *from, daft_waiting *waiting)
{
    uint32_t count = daft_min_u(from->count, DAFT_VL), at = from->count - count;
    vf focal = vf_set(job->raster->pencil.focal), left = vf_set(job->left), top = vf_set(job->top), zero = vf_set(0);
    vf x[3], y[3], scale[3];
    vf3 corner[3];
    small s;
    for (int k = 0; k < 3; k++) {
        corner[k] = (vf3){vf_load(&from->corner[3 * k][at]), vf_load(&from->corner[3 * k + 1][at]), vf_load(&from->corner[3 * k + 2][at])};
        scale[k] = focal / corner[k].z;
        x[k] = corner[k].x * scale[k] - left, y[k] = top - corner[k].y * scale[k];
    }
    vi pixels = vi_load(&from->pixels[at]), byte = vi_set(DAFT_TILE - 1), x0 = pixels & byte, y0 = pixels >> 16 & byte;
    vi wide = (pixels >> 8 & byte) - x0, tall = (pixels >> 24 & byte) - y0;
    s.triangle = vi_load(&from->triangle[at]);
    small_setup(job, seen, x, y, scale, x0, y0, &s);
    vf least = vf_min(vf_min(corner[0].z, corner[1].z), corner[2].z);
    vm front = vf_lt(zero, least);
    vbits all = vbits_first((int)count), little = all & vm_bits(front) & vm_bits(vi_lt(wide | tall, vi_set(2)));
    if (job->raster->pencil.intersection == DAFT_INTERSECT_WATERTIGHT) little = 0;
    vf nearest = vf_select(front, vf_set(1 + 4 * UNIT) / least, vf_set(INFINITY));
    job->counters->binned += (uint64_t)__builtin_popcount(little);
    waiting_add(waiting, corner, pixels, nearest, seen->index, s.triangle, all & ~little);
    vbits right = vm_bits(vi_lt(vi_set(0), wide)), below = vm_bits(vi_lt(vi_set(0), tall));
    if (!job->exact) little &= vm_bits(vf_lt(vf_abs(s.slope[0]) + vf_abs(s.slope[1]), vf_set(INFINITY)));
    add_hits(job, &s, 0, 0, little, &waiting->hits);
    add_hits(job, &s, 1, 0, little & right, &waiting->hits);
    add_hits(job, &s, 0, 1, little & below, &waiting->hits);
    add_hits(job, &s, 1, 1, little & right & below, &waiting->hits);
    from->count = at;
}
