/* Coverage and depth test of a fine tile: sixteen rays to each pixel that asks. Most of a tile's pixels do not, so what
 * a triangle may cover is looked for by pixels first, a register of them at a time: by each edge function at the
 * pixel's middle and what it may grow by from there, and by the largest w there against what all of the pixel's rays
 * see already. The rays of pixels that are left are tested as those of windows are (coverage_kernel.c); what they see
 * stands side by side. */
#include "raster/grid/sphere.h"

enum { WIDTH = DAFT_FINE * DAFT_WINDOW_W }; /* rays of a window of pixels */
#define HALF (0.5f * (DAFT_FINE - 1))

void DAFT_KERNEL(daft_fine_begin)(daft_tile_job *j)
{
    daft_fine_tile *f = j->fine;
    for (int y = 0; y < DAFT_TILE; y++)
        for (uint32_t left = f->pixels[y]; left; left &= left - 1) {
            const uint32_t pixel = (uint32_t)(y * DAFT_TILE + __builtin_ctz(left)), asked = f->asked[pixel];
            for (uint32_t k = 0; k < DAFT_FINE_RAYS; k += DAFT_VL) {
                const uint32_t at = DAFT_FINE_RAYS * pixel + k;
                const vf w =
                    vf_if_then_else(vm_from_bits(asked >> k & DAFT_ALL_LANES), vf_set(-INFINITY), vf_set(INFINITY));
                vf_store(&j->fine_depths->low[at], w), vf_store(&j->fine_depths->high[at], w);
                vi_store(&f->instance[at], vi_set(-1)), vi_store(&f->triangle[at], vi_set(0));
            }
        }
}

/* ---- a pixel's rays ---- */

/* What all of the pixel's rays see is no farther than this. */
DAFT_INLINE float least_of(const daft_tile_job *j, int pixel)
{
    const float *low = &j->fine_depths->low[DAFT_FINE_RAYS * pixel];
    vf min = vf_load(low);
    for (int k = DAFT_VL; k < DAFT_FINE_RAYS; k += DAFT_VL) min = vf_min(min, vf_load(&low[k]));
    return vf_reduce_min(min);
}

/* Some of the pixel's rays see something nearer; its cell of pixels will be looked at again. */
DAFT_INLINE void renew(daft_tile_job *j, int x, int y)
{
    j->w_low[y * DAFT_TILE + x] = least_of(j, y * DAFT_TILE + x);
    j->stale[y / DAFT_CELL] |= 1u << x / DAFT_CELL;
}

static __attribute__((noinline)) void look_closely(daft_tile_job *j, int at, const daft_primitive *t, vbits look,
                                                   vbits unsure, vf low, vf high)
{
    float lows[DAFT_VL], highs[DAFT_VL];
    vf_store(lows, low), vf_store(highs, high);
    for (; look; look &= look - 1) {
        const int i = __builtin_ctz(look);
        DAFT_KERNEL(daft_ray_decide)(j, at + i, t, !(unsure >> i & 1), lows[i], highs[i]);
    }
}

/* Offers lanes with intervals of w to rays side by side. True: some were nearer, or might have been. */
DAFT_INLINE bool offer(daft_tile_job *j, int at, const daft_primitive *t, vbits hits, vbits unsure, vf low, vf high)
{
    float *own_low = &j->fine_depths->low[at], *own_high = &j->fine_depths->high[at];
    const vf old_low = vf_load(own_low), old_high = vf_load(own_high);
    hits &= ~vbits_from_mask(vf_lt(high, old_low));
    if (!hits) return false;
    const vbits take = hits & vbits_from_mask(vf_lt(old_high, low)) & ~unsure;
    const vm m = vm_from_bits(take);
    uint32_t *instance = &j->fine->instance[at], *triangle = &j->fine->triangle[at];
    vf_store(own_low, vf_if_then_else(m, low, old_low)), vf_store(own_high, vf_if_then_else(m, high, old_high));
    vi_store(instance, vi_if_then_else(m, vi_set((int32_t)t->view->index), vi_load(instance)));
    vi_store(triangle, vi_if_then_else(m, vi_set((int32_t)t->triangle), vi_load(triangle)));
    if (__builtin_expect(hits != take, 0)) look_closely(j, at, t, hits & ~take, unsure, low, high);
    return true;
}

/* ---- triangles ---- */

/* Of a pixel's middle, what triangles' edge functions and w are at most at any of its rays: nz and wz with what they
 * may grow by from there, to the outermost rays along the axes of their grid, which is turned. Products and sums are
 * off by less than 3u of what they are made of, here and at the rays. */
typedef struct bounds {
    float e[3][DAFT_VL], w[DAFT_VL];
} bounds;

DAFT_INLINE vf grown(const daft_tile_job *j, const float *nx, const float *ny, const float *nz)
{
    const vf x = vf_load(nx), y = vf_load(ny), z = vf_load(nz), turn = vf_set(DAFT_FINE_TURN);
    return z + (vf_abs(x + turn * y) + vf_abs(y - turn * x)) * vf_set(HALF) +
           vf_set(12 * UNIT) * (vf_abs(x) * vf_set(j->max_dx) + vf_abs(y) * vf_set(j->max_dy) + vf_abs(z));
}

static void bounds_of(const daft_tile_job *j, const daft_pencil_batch *b, bounds *out)
{
    for (int k = 0; k < 3; k++) vf_store(out->e[k], grown(j, b->nx[k], b->ny[k], b->nz[k]));
    vf_store(out->w, grown(j, b->wx, b->wy, b->wz) + vf_load(b->error));
}

/* A triangle's planes in all lanes, as those of coverage_kernel.c, and its bounds. */
typedef struct planes {
    vf nx[3], ny[3], nz[3], wx, wy, wz, cap, error, outer, sure;
    vf most[3], w_most, w_cap;
} planes;

DAFT_INLINE planes planes_of(const daft_tile_job *j, const daft_pencil_batch *b, const bounds *most, int i)
{
    planes p = {.wx = vf_set(b->wx[i]),
                .wy = vf_set(b->wy[i]),
                .wz = vf_set(b->wz[i]),
                .cap = vf_set(b->w_cap[i]),
                .error = vf_set(b->error[i])};
    for (int k = 0; k < 3; k++) {
        p.nx[k] = vf_set(b->nx[k][i]), p.ny[k] = vf_set(b->ny[k][i]), p.nz[k] = vf_set(b->nz[k][i]);
        p.most[k] = vf_set(most->e[k][i]);
    }
    p.outer = vf_set(j->exact ? -1.0f : 0.0f), p.sure = vf_set(j->exact ? 1 : -INFINITY);
    p.w_most = vf_set(most->w[i]), p.w_cap = p.cap + p.error;
    return p;
}

/* Pixels of a window that ask, and of which some ray may meet the triangle before what it sees; a NaN leaves one in. */
DAFT_INLINE vbits pixels_met(const daft_tile_job *j, const planes *p, int x, int y, vf low)
{
    const vf four = vf_set(DAFT_FINE);
    const vf dx = vf_set(j->left + HALF + (float)(DAFT_FINE * x)) + four * vf_column(),
             dy = vf_set(j->top - HALF - (float)(DAFT_FINE * y)) - four * vf_row();
    vf min = vf_set(INFINITY);
    for (int k = 0; k < 3; k++) min = vf_min(p->nx[k] * dx + (p->ny[k] * dy + p->most[k]), min);
    const vf w = vf_min(p->wx * dx + (p->wy * dy + p->w_most), p->w_cap);
    return vbits_from_mask(vm_and(vf_le(p->outer, min), vf_lt(low, vf_set(INFINITY)))) &
           ~vbits_from_mask(vf_lt(w, low));
}

/* True: some of its rays see something nearer. */
DAFT_INLINE bool draw_pixel(daft_tile_job *j, const planes *p, const daft_primitive *t, int x, int y)
{
    bool nearer = false;
    for (int k = 0; k < DAFT_FINE_RAYS; k += DAFT_VL) {
        const int at = DAFT_FINE_RAYS * (y * DAFT_TILE + x) + k;
        const vf dx = vf_set(j->left + (float)(DAFT_FINE * x)) + vf_load(&j->across[k]),
                 dy = vf_set(j->top - (float)(DAFT_FINE * y)) - vf_load(&j->down[k]);
        vf min = vf_set(INFINITY);
        for (int e = 0; e < 3; e++) min = vf_min(p->nx[e] * dx + (p->ny[e] * dy + p->nz[e]), min);
        vbits hits = vbits_from_mask(vf_le(p->outer, min));
        const vf w = vf_min(p->wx * dx + (p->wy * dy + p->wz), p->cap);
        if (t->holes) {
            hits &= ~vbits_from_mask(vf_lt(w + p->error, vf_load(&j->fine_depths->low[at])));
            hits &= ~DAFT_KERNEL(daft_hits_in_holes)(j, t, DAFT_FINE * x, DAFT_FINE * y + k / DAFT_FINE, hits);
        }
        nearer |= offer(j, at, t, hits, hits & ~vbits_from_mask(vf_lt(p->sure, min)), w - p->error, w + p->error);
    }
    return nearer;
}

/* A window of pixels. What they see is stored as it is loaded: one by one, the next load would wait for them. */
DAFT_INLINE void draw_window(daft_tile_job *j, const planes *p, const daft_primitive *t, int x, int y)
{
    float *w_low = &j->w_low[y * DAFT_TILE_STRIDE + x];
    vf low = vf_load_blocks(w_low, DAFT_TILE_STRIDE);
    bool nearer = false;
    for (vbits left = pixels_met(j, p, x, y, low); left; left &= left - 1) {
        const int i = __builtin_ctz(left), px = x + i % DAFT_WINDOW_W, py = y + i / DAFT_WINDOW_W;
        if (!draw_pixel(j, p, t, px, py)) continue;
        low = vf_if_then_else(vm_from_bits(left & (0 - left)), vf_set(least_of(j, py * DAFT_TILE + px)), low);
        nearer = true;
    }
    if (!nearer) return;
    vf_store_blocks(w_low, DAFT_TILE_STRIDE, low);
    j->stale[y / DAFT_CELL] |= 1u << x / DAFT_CELL;
    if (DAFT_WINDOW_H > 1) j->stale[(y + DAFT_WINDOW_H - 1) / DAFT_CELL] |= 1u << x / DAFT_CELL;
}

static void draw_triangle(daft_tile_job *j, const daft_pencil_batch *b, const bounds *most, int i)
{
    daft_holes holes;
    daft_primitive t = {&j->raster->visible[b->instance[i]], b->triangle[i], NULL};
    if (asks_holes(j, t.view)) {
        holes.known = holes.none = false;
        t.holes = &holes;
    }
    const planes p = planes_of(j, b, most, i);
    const int y1 = b->y1[i] / DAFT_FINE;
    const uint32_t columns = (2u << b->x1[i] / WIDTH) - (1u << b->x0[i] / WIDTH);
    for (int y = b->y0[i] / DAFT_FINE; y <= y1; y += DAFT_WINDOW_H)
        for (uint32_t windows = j->asked[y] & columns; windows; windows &= windows - 1)
            draw_window(j, &p, &t, __builtin_ctz(windows) * DAFT_WINDOW_W, y);
}

void DAFT_KERNEL(daft_fine_batch_draw)(daft_tile_job *j, const daft_pencil_batch *b)
{
    bounds most;
    bounds_of(j, b, &most);
    for (vbits live = b->live; live; live &= live - 1) draw_triangle(j, b, &most, __builtin_ctz(live));
}

/* ---- small triangles ---- */

void DAFT_KERNEL(daft_fine_hits_draw)(daft_tile_job *j, daft_small *from, daft_hits *h)
{
    const bool holes = h->count && asks_holes(j, from->view);
    for (uint32_t k = 0; k < h->count; k++) {
        const uint32_t hit = h->place[k], place = hit & (DAFT_HIT_UNSURE - 1);
        const int column = (int)(place % DAFT_FINE_SIDE), row = (int)(place / DAFT_FINE_SIDE), x = column / DAFT_FINE,
                  y = row / DAFT_FINE, pixel = y * DAFT_TILE + x,
                  at = DAFT_FINE_RAYS * pixel + row % DAFT_FINE * DAFT_FINE + column % DAFT_FINE;
        const float low = h->low[k], high = j->exact ? h->high[k] : low;
        if (!(j->w_low[pixel] < INFINITY) || high < j->fine_depths->low[at]) continue;
        const daft_primitive t = {from->view, from->triangle[hit >> DAFT_HIT_TRIANGLE], NULL};
        if (holes && DAFT_KERNEL(daft_ray_in_hole)(j, column, row, t.view, t.triangle)) continue;
        DAFT_KERNEL(daft_ray_decide)(j, at, &t, !j->exact || !(hit & DAFT_HIT_UNSURE), low, high);
        renew(j, x, y);
    }
    h->count = h->doubted_count = from->count = 0;
}

/* ---- spheres ---- */

void DAFT_KERNEL(daft_fine_sphere_draw)(daft_tile_job *j, const daft_view_instance *view, int x0, int x1, int y0,
                                        int y1)
{
    const daft_primitive t = {view, 0, NULL};
    const sphere s = sphere_of(j, view);
    const uint32_t columns = (2u << x1 / DAFT_FINE) - (1u << x0 / DAFT_FINE);
    for (int y = y0 / DAFT_FINE; y <= y1 / DAFT_FINE; y++)
        for (uint32_t left = j->fine->pixels[y] & columns; left; left &= left - 1) {
            const int x = __builtin_ctz(left);
            bool nearer = false;
            for (int k = 0; k < DAFT_FINE_RAYS; k += DAFT_VL) {
                const sphere_hits h = sphere_meet(&s, vf_set(j->left + (float)(DAFT_FINE * x)) + vf_load(&j->across[k]),
                                                  vf_set(j->top - (float)(DAFT_FINE * y)) - vf_load(&j->down[k]));
                if (h.lanes)
                    nearer |= offer(j, DAFT_FINE_RAYS * (y * DAFT_TILE + x) + k, &t, h.lanes, h.unsure, h.low, h.high);
            }
            if (nearer) renew(j, x, y);
        }
}
