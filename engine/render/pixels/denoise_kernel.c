/* The filter of sampled light: an edge-avoiding à-trous wavelet transform (Dammertz, Sewtz, Hanika, Lensch, HPG 2010)
 * guided by the variance of what it filters (Schied and others, "Spatiotemporal Variance-Guided Filtering", HPG 2017).
 * A pass weighs each pixel with the eight around it, `step` pixels away; passes with steps of 1, 2, 4 and 8 together
 * reach 15 pixels.
 *
 * A neighbour counts as far as it lies on the pixel's own plane, faces the same way, and has about the same light, by
 * the measure of the noise. Of a plane the inverse depth is linear in the picture; its slope follows from the normal.
 *
 * What was filtered at half the resolution is enlarged by the same measure of planes (joint bilateral upsampling: Kopf,
 * Cohen, Lischinski, Uyttendaele, ACM Transactions on Graphics 26(3), 2007).
 */
#include "math/simd/ops.h"
#include "render/kernels.h"

/* How far from the plane a neighbour may lie, in steps between pixels: towards the camera, and along the plane. What
 * bends, and leaves of a tree, are still filtered with each other: of 0.1, 0.25, ... 4 the error falls up to 2 in
 * foliage and on statues (leaves at 640x360: RMSE 0.063 to 0.044), and rises nowhere. */
#define OFF_PLANE   2.0f
#define ALONG_PLANE 0.25f
/* How much light may differ: so many times the variance, and a part of the whole squared. */
#define OFF_NOISE 24.0f
#define OFF_LIGHT 1e-4f

typedef struct plane {
    vf3 normal;
    vf inverse, right, down; /* of depth; its change from a pixel to the next */
    vf slack;                /* over how far a neighbour may lie beside it */
} plane;

DAFT_INLINE vf3 load_three(float *const p[3], ptrdiff_t at)
{
    return (vf3){vf_load(p[0] + at), vf_load(p[1] + at), vf_load(p[2] + at)};
}

DAFT_INLINE plane plane_at(const daft_filter *f, int x, int y, ptrdiff_t at)
{
    plane p = {.normal = load_three(f->normal, at), .inverse = vf_load(f->inverse + at)};
    const vf3 ray = {vf_set(f->left + (float)x) + vf_convert_to(vi_iota()), vf_set(f->top - (float)y),
                     vf_set(f->focal)};
    const vf facing = vf3_dot(p.normal, ray), tiny = vf_set(1e-6f * f->focal);
    /* The plane's inverse depth along a ray is normal·ray / (focal · distance of the plane). */
    const vf scale = p.inverse / vf_if_then_else(vf_lt(vf_abs(facing), tiny),
                                                 vf_if_then_else(vf_lt(facing, vf_set(0)), -tiny, tiny), facing);
    p.right = p.normal.x * scale, p.down = -p.normal.y * scale;
    const vf reach = vf_set(ALONG_PLANE * (float)f->step);
    p.slack = vf_set(1) /
              (vf_set(OFF_PLANE * (float)f->step / f->focal) * p.inverse + (vf_abs(p.right) + vf_abs(p.down)) * reach);
    return p;
}

DAFT_INLINE vf square(vf x) { return x * x; }

DAFT_INLINE vf luminance(vf3 c) { return (c.x + c.y + c.z) * vf_set(1.0f / 3); }

DAFT_INLINE vf sixteenth_power(vf x)
{
    const vf x2 = x * x, x4 = x2 * x2, x8 = x4 * x4;
    return x8 * x8;
}

/* How much the pixel (dx, dy) away belongs to the plane; 0 where nothing was sampled. */
DAFT_INLINE vf on_plane(const daft_filter *f, const plane *p, int dx, int dy, ptrdiff_t at)
{
    const vf one = vf_set(1), zero = vf_set(0);
    const vf there = vf_load(f->inverse + at);
    const vf off = (there - p->inverse - p->right * vf_set((float)dx) - p->down * vf_set((float)dy)) * p->slack;
    const vf facing = vf_max(vf3_dot(p->normal, load_three(f->normal, at)), zero),
             same = f->reach ? sixteenth_power(facing) : square(facing);
    return vf_if_then_else(vf_lt(zero, there), vf_max(one - off * off, zero) * same, zero);
}

/* What a neighbour has; the pixel's own where it lies on another plane. */
DAFT_INLINE vf light_beside(const daft_filter *f, const plane *p, vf own, int dx, int dy, ptrdiff_t at)
{
    const vm same = vf_lt(vf_set(0.25f), on_plane(f, p, dx, dy, at));
    return vf_if_then_else(same, luminance(load_three(f->from, at)), own);
}

/* The square of the noise in nine pixels: the difference of two Laplacians, in which light that changes evenly, and
 * straight edges of shadows, cancel out (Immerkær, "Fast Noise Variance Estimation", CVIU 64(2), 1996). */
DAFT_INLINE void noise(const daft_filter *f, int x, int y, ptrdiff_t at)
{
    const plane p = plane_at(f, x, y, at);
    const vf own = luminance(load_three(f->from, at));
    vf sum = own * vf_set(4);
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            if (!dx && !dy) continue;
            const bool inside = y + dy >= 0 && y + dy < f->height;
            const vf light = inside ? light_beside(f, &p, own, dx, dy, at + dy * f->stride + dx) : own;
            sum += light * vf_set(dx && dy ? 1 : -2);
        }
    vf_store(f->to_variance + at,
             vf_if_then_else(vf_lt(vf_set(0), p.inverse), sum * sum * vf_set(1.0f / 36), vf_set(0)));
}

void DAFT_KERNEL(daft_filter_noise)(const daft_filter *f, int x0, int y0, int width, int height)
{
    for (int y = y0; y < y0 + height; y++)
        for (int x = x0; x < x0 + width; x += DAFT_VL) noise(f, x, y, y * f->stride + x);
}

/* The variance of a pixel's light: the mean noise of its neighbours, but no more than that of so many rays that arrive
 * or do not (the inverse of their number stands where the variance will); what mirrored rays bring has no such bound.
 */
DAFT_INLINE void spread(const daft_filter *f, int x, int y, ptrdiff_t at)
{
    const plane p = plane_at(f, x, y, at);
    vf sum = vf_set(0), mean = sum, weights = sum;
    for (int dy = -1; dy <= 1; dy++) {
        if (y + dy < 0 || y + dy >= f->height) continue;
        for (int dx = -1; dx <= 1; dx++) {
            const ptrdiff_t there = at + dy * f->stride + dx;
            const vf weight = dx || dy ? on_plane(f, &p, dx, dy, there) : vf_set(1);
            sum += weight * vf_load(f->to_variance + there), weights += weight;
            mean += weight * luminance(load_three(f->from, there));
        }
    }
    mean = mean / weights;
    const vm known = vf_lt(vf_set(0), p.inverse);
    vf variance = sum / weights;
    if (!f->reach) variance = vf_min(variance, vf_max(mean - mean * mean, vf_set(0)) * vf_load(f->from_variance + at));
    vf_store(f->from_variance + at, vf_if_then_else(known, variance, vf_set(0)));
}

void DAFT_KERNEL(daft_filter_spread)(const daft_filter *f, int x0, int y0, int width, int height)
{
    for (int y = y0; y < y0 + height; y++)
        for (int x = x0; x < x0 + width; x += DAFT_VL) spread(f, x, y, y * f->stride + x);
}

/* The mean of a pixel and those beside it on its plane. The first pass measures by it, as far as noise may be what sets
 * the pixel apart, or a single ray that was stopped would keep to itself. */
DAFT_INLINE vf mean_light(const daft_filter *f, const plane *p, vf own, int y, ptrdiff_t at)
{
    vf sum = own, weights = vf_set(1);
    for (int dy = -1; dy <= 1; dy++) {
        if (y + dy < 0 || y + dy >= f->height) continue;
        for (int dx = -1; dx <= 1; dx++) {
            if (!dx && !dy) continue;
            const ptrdiff_t there = at + dy * f->stride + dx;
            const vf weight = on_plane(f, p, dx, dy, there);
            sum += weight * luminance(load_three(f->from, there)), weights += weight;
        }
    }
    return sum / weights;
}

/* Of pixels whose neighbours are all out of reach. */
DAFT_INLINE void keep_own(const daft_filter *f, vf3 own, vm known, ptrdiff_t at)
{
    vf_store(f->to[0] + at, own.x), vf_store(f->to[1] + at, own.y), vf_store(f->to[2] + at, own.z);
    vf_store(f->to_variance + at, vf_if_then_else(known, vf_load(f->from_variance + at), vf_set(0)));
}

DAFT_INLINE void filter(const daft_filter *f, int x, int y, ptrdiff_t at)
{
    static const float KERNEL[3] = {0.25f, 0.5f, 0.25f};
    const vf3 own = load_three(f->from, at);
    const vm known = vf_lt(vf_set(0), vf_load(f->inverse + at)); /* else numbers stay finite */
    const vf per_reach = f->reach ? vf_set((float)f->step) / vf_max(vf_load(f->reach + at), vf_set(1e-3f)) : vf_set(0);
    const vf within = vf_clamp01(vf_set(2) - per_reach);
    if (!vbits_from_mask(vm_and(known, vf_lt(vf_set(0), within)))) {
        keep_own(f, own, known, at);
        return;
    }
    const plane p = plane_at(f, x, y, at);
    const vf mine = luminance(own), limit = vf_load(f->from_variance + at) * vf_set(OFF_NOISE) + vf_set(OFF_LIGHT);
    vf light = mine;
    if (f->step == 1 && !f->reach) {
        const vf off = mean_light(f, &p, mine, y, at) - mine;
        light += off * square(limit / (limit + off * off));
    }
    const vf middle = vf_set(0.25f);
    vf3 sum = {own.x * middle, own.y * middle, own.z * middle};
    vf variance = vf_load(f->from_variance + at) * middle * middle, weights = middle;
    for (int v = -1; v <= 1; v++) {
        const int dy = v * f->step;
        if (y + dy < 0 || y + dy >= f->height) continue;
        for (int u = -1; u <= 1; u++) {
            if (!u && !v) continue;
            const int dx = u * f->step;
            const ptrdiff_t there = at + dy * f->stride + dx;
            const vf3 other = load_three(f->from, there);
            const vf gap = luminance(other) - light;
            const vf weight = vf_set(KERNEL[u + 1] * KERNEL[v + 1]) * on_plane(f, &p, dx, dy, there) *
                              square(limit / (limit + gap * gap)) * within;
            sum.x += other.x * weight, sum.y += other.y * weight, sum.z += other.z * weight;
            variance += vf_load(f->from_variance + there) * weight * weight, weights += weight;
        }
    }
    const vf scale = vf_set(1) / weights;
    vf_store(f->to[0] + at, vf_if_then_else(known, sum.x * scale, own.x));
    vf_store(f->to[1] + at, vf_if_then_else(known, sum.y * scale, own.y));
    vf_store(f->to[2] + at, vf_if_then_else(known, sum.z * scale, own.z));
    vf_store(f->to_variance + at, vf_if_then_else(known, variance * scale * scale, vf_set(0)));
}

void DAFT_KERNEL(daft_filter_pass)(const daft_filter *f, int x0, int y0, int width, int height)
{
    for (int y = y0; y < y0 + height; y++)
        for (int x = x0; x < x0 + width; x += DAFT_VL) filter(f, x, y, y * f->stride + x);
}

/* How much what lies on no pixel's plane counts where none on it is near. */
#define BESIDE_PLANE 1e-3f

/* Of the coarse pixel at `index` of a row, `row` floats from the first: what it has, as far as it lies on the plane. */
DAFT_INLINE void enlarge_from(const daft_enlarging *e, const plane *p, vi index, ptrdiff_t row, vf dx, vf dy, vf weight,
                              vf3 *sum, vf *weights)
{
    const daft_filter *f = &e->from;
    const vf one = vf_set(1), zero = vf_set(0), there = vf_gather_index(f->inverse + row, index);
    const vf off = (there - p->inverse - p->right * dx - p->down * dy) * p->slack, off2 = off * off;
    const vf3 normal = {vf_gather_index(f->normal[0] + row, index), vf_gather_index(f->normal[1] + row, index),
                        vf_gather_index(f->normal[2] + row, index)};
    const vf same = sixteenth_power(vf_max(vf3_dot(p->normal, normal), zero));
    const vf fits = vf_max(one - off2, zero) * same + vf_set(BESIDE_PLANE) / (one + off2);
    const vf share = vf_if_then_else(vf_lt(zero, there), weight * fits, zero);
    sum->x += share * vf_gather_index(f->from[0] + row, index);
    sum->y += share * vf_gather_index(f->from[1] + row, index);
    sum->z += share * vf_gather_index(f->from[2] + row, index);
    *weights += share;
}

/* Pixels lie on a coarse one, or between two or four; between rows and columns all around count alike. */
DAFT_INLINE void enlarge(const daft_enlarging *e, int x, int y)
{
    const ptrdiff_t at = y * e->to.stride + x;
    if (!vbits_from_mask(vf_lt(vf_set(0), vf_load(e->to.inverse + at)))) { /* by the first sample nothing is seen */
        for (int c = 0; c < 3; c++) vf_store(e->to.to[c] + at, vf_set(1));
        return;
    }
    const plane p = plane_at(&e->to, x, y, at);
    const vi column = vi_set(x - e->x) + vi_iota(), left = column >> 1;
    const vf aside = vf_convert_to(column & vi_set(1));
    const int down = (y - e->y) & 1, above = (y - e->y) >> 1;
    vf3 sum = {vf_set(0), vf_set(0), vf_set(0)};
    vf weights = vf_set(0);
    for (int k = 0; k <= down; k++) {
        if (above + k < 0 || above + k >= e->from.height) continue;
        const ptrdiff_t row = (above + k) * e->from.stride;
        const vf dy = vf_set((float)(2 * k - down)), half = vf_set(0.5f) * aside;
        enlarge_from(e, &p, left, row, -aside, dy, vf_set(1) - half, &sum, &weights);
        enlarge_from(e, &p, left + vi_set(1), row, aside, dy, half, &sum, &weights);
    }
    const vm some = vf_lt(vf_set(0), weights);
    const vf scale = vf_set(1) / vf_if_then_else(some, weights, vf_set(1));
    vf_store(e->to.to[0] + at, vf_if_then_else(some, sum.x * scale, vf_set(1)));
    vf_store(e->to.to[1] + at, vf_if_then_else(some, sum.y * scale, vf_set(1)));
    vf_store(e->to.to[2] + at, vf_if_then_else(some, sum.z * scale, vf_set(1)));
}

void DAFT_KERNEL(daft_enlarge)(const daft_enlarging *e, int x0, int y0, int width, int height)
{
    for (int y = y0; y < y0 + height; y++)
        for (int x = x0; x < x0 + width; x += DAFT_VL) enlarge(e, x, y);
}
