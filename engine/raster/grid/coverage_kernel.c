/* Coverage and depth test: which pixels' rays hit a set-up triangle or sphere, and whether it is the nearest hit. One
 * SIMD register is a window of pixels, four wide and DAFT_VL / 4 high. A window begins at a multiple of four in its row
 * and anywhere in its column, so a small triangle needs one or two.
 *
 * e is an edge's function divided by the bound of its rounding error (setup_kernel.c). A lane is inside where e > 1 for
 * all three edges, outside where e < -1 for one; between, the exact predicates decide. w = 1/z is the inverse depth.
 * Each pixel keeps an interval that holds the w of its nearest hit so far: only where intervals overlap are depths
 * compared exactly. */
#include "raster/grid/sphere.h"

/* ---- windows ---- */

DAFT_INLINE vf window_load(const float *p) { return vf_load_blocks(p, DAFT_TILE_STRIDE); }
DAFT_INLINE void window_store(float *p, vf v) { vf_store_blocks(p, DAFT_TILE_STRIDE, v); }
DAFT_INLINE void window_put(void *p, vm m, uint32_t value)
{
    window_store(p, vf_if_then_else(m, (vf)vi_set((int32_t)value), window_load(p)));
}

/* The pixels of a window at a place have come nearer. */
DAFT_INLINE void mark_stale(daft_tile_job *j, uint32_t at)
{
    uint32_t cell = 1u << at % DAFT_TILE_STRIDE / DAFT_CELL, y = at / DAFT_TILE_STRIDE;
    j->stale[y / DAFT_CELL] |= cell;
    if (DAFT_WINDOW_H > 1) j->stale[(y + DAFT_WINDOW_H - 1) / DAFT_CELL] |= cell;
}

static int lane_place(int at, int lane) { return at + lane / DAFT_WINDOW_W * DAFT_TILE_STRIDE + lane % DAFT_WINDOW_W; }

/* The lanes that floats leave open: one by one. */
static __attribute__((noinline)) void look_closely(daft_tile_job *j, uint32_t at, const daft_primitive *t, vbits look,
                                                   vbits unsure, const float *low, const float *high)
{
    for (; look; look &= look - 1) {
        int i = __builtin_ctz(look);
        DAFT_KERNEL(daft_ray_decide)(j, lane_place((int)at, i), t, !(unsure >> i & 1), low[i], high[i]);
    }
}

/* Offers lanes with intervals of w to a window: decided in lanes where the intervals are apart. One branch: whether
 * there is anything to do is hard to predict, the rest is not. */
DAFT_INLINE void offer(daft_tile_job *j, uint32_t at, const daft_primitive *t, vbits hits, vbits unsure, vf low,
                       vf high)
{
    vf old_low = window_load(&j->w_low[at]);
    hits &= ~vbits_from_mask(vf_lt(high, old_low));
    if (!hits) return;
    vf old_high = window_load(&j->w_high[at]);
    vbits take = hits & vbits_from_mask(vf_lt(old_high, low)) & ~unsure, look = hits & ~take;
    vm m = vm_from_bits(take);
    mark_stale(j, at);
    window_store(&j->w_low[at], vf_if_then_else(m, low, old_low));
    window_store(&j->w_high[at], vf_if_then_else(m, high, old_high));
    window_put(&j->tile->instance[at], m, t->view->index);
    window_put(&j->tile->triangle[at], m, t->triangle);
    if (__builtin_expect(look != 0, 0)) {
        float lows[DAFT_VL], highs[DAFT_VL];
        vf_store(lows, low), vf_store(highs, high);
        look_closely(j, at, t, look, unsure, lows, highs);
    }
}

/* ---- triangles ---- */

/* A triangle's planes in all lanes. Inside is e >= outer, and sure beyond `sure`. */
typedef struct planes {
    vf nx[3], ny[3], nz[3], wx, wy, wz, cap, error, outer, sure;
} planes;

DAFT_INLINE planes planes_of(const daft_tile_job *j, const daft_pencil_batch *b, int i)
{
    planes p = {.wx = vf_set(b->wx[i]),
                .wy = vf_set(b->wy[i]),
                .wz = vf_set(b->wz[i]),
                .cap = vf_set(b->w_cap[i]),
                .error = vf_set(b->error[i])};
    for (int k = 0; k < 3; k++)
        p.nx[k] = vf_set(b->nx[k][i]), p.ny[k] = vf_set(b->ny[k][i]), p.nz[k] = vf_set(b->nz[k][i]);
    p.outer = vf_set(j->exact ? -1.0f : 0.0f), p.sure = vf_set(j->exact ? 1 : -INFINITY);
    return p;
}

/* The part of e and w that a window's rows have in common. */
typedef struct window_rows {
    vf e[3], w;
} window_rows;

DAFT_INLINE window_rows rows_of(const daft_tile_job *j, const planes *p, int y)
{
    vf dy = vf_set(j->top - (float)y) - vf_row();
    return (window_rows){{p->ny[0] * dy + p->nz[0], p->ny[1] * dy + p->nz[1], p->ny[2] * dy + p->nz[2]},
                         p->wy * dy + p->wz};
}

DAFT_INLINE void draw_window(daft_tile_job *j, const planes *p, const window_rows *r, int x, int y,
                             const daft_primitive *t)
{
    vf dx = vf_load(j->dx[x / DAFT_WINDOW_W]);
    vf min = vf_min(vf_min(p->nx[0] * dx + r->e[0], p->nx[1] * dx + r->e[1]), p->nx[2] * dx + r->e[2]);
    vbits hits = vbits_from_mask(vf_le(p->outer, min));
    vf w = vf_min(p->wx * dx + r->w, p->cap);
    if (t->holes)
        hits &= ~DAFT_KERNEL(daft_hits_in_holes)(
            j, t, x, y, hits & ~vbits_from_mask(vf_lt(w + p->error, window_load(&j->w_low[y * DAFT_TILE_STRIDE + x]))));
    offer(j, (uint32_t)(y * DAFT_TILE_STRIDE + x), t, hits, hits & ~vbits_from_mask(vf_lt(p->sure, min)), w - p->error,
          w + p->error);
}

/* ---- large triangles: a window of pixels at a time ---- */

/* Windows of a tile in rows of COLUMNS, from row y0 of the tile on: bits of those that no edge has wholly on its outer
 * side, by each edge function at the window's middle and what it may grow by from there. Products and sums are off by
 * less than 3u of what it is made of, here and at the window's rays. */
enum { FIND_FROM = 8 }; /* pixels a side of boxes in which windows are searched for: of a long triangle they are few */
enum { COLUMNS = DAFT_TILE / DAFT_WINDOW_W, WINDOW_WORDS = COLUMNS * DAFT_TILE / DAFT_WINDOW_H / 64 };
_Static_assert(COLUMNS == 8 && WINDOW_WORDS >= 1, "a row of windows is a byte of a word");

static void find_windows(const daft_tile_job *j, const daft_pencil_batch *b, int i, uint32_t count,
                         uint64_t bits[WINDOW_WORDS])
{
    vf nx[3], ny[3], max[3], outer = vf_set(j->exact ? -1.0f : 0.0f);
    const float half_w = (DAFT_WINDOW_W - 1) * 0.5f, half_h = (DAFT_WINDOW_H - 1) * 0.5f;
    for (int k = 0; k < 3; k++) {
        float x = fabsf(b->nx[k][i]), y = fabsf(b->ny[k][i]), z = b->nz[k][i];
        nx[k] = vf_set(b->nx[k][i]), ny[k] = vf_set(b->ny[k][i]);
        max[k] = vf_set(z + x * half_w + y * half_h + 8 * UNIT * (x * j->max_dx + y * j->max_dy + fabsf(z)));
    }
    for (int k = 0; k < WINDOW_WORDS; k++) bits[k] = 0;
    for (uint32_t q = 0; q < count; q += DAFT_VL) {
        vi window = vi_iota() + vi_set((int32_t)q);
        vf dx = vf_set(j->left + half_w) + vf_convert_to(window & vi_set(COLUMNS - 1)) * vf_set(DAFT_WINDOW_W);
        vf dy = vf_set(j->top - (float)b->y0[i] - half_h) -
                vf_convert_to(window >> __builtin_ctz(COLUMNS)) * vf_set(DAFT_WINDOW_H);
        vf min = vf_set(INFINITY);
        for (int k = 0; k < 3; k++) min = vf_min(nx[k] * dx + ny[k] * dy + max[k], min);
        bits[q / 64] |= (uint64_t)vbits_from_mask(vf_le(outer, min)) << (q & 63);
    }
}

/* The same bits of the eight rows of windows from row y of the tile on that hold rays which were asked for. */
DAFT_INLINE uint64_t asked_windows(const daft_tile_job *j, int y)
{
    uint64_t bits = 0;
    for (int k = 0; k < 8; k++) bits |= (uint64_t)j->asked[(y + k * DAFT_WINDOW_H) & (2 * DAFT_TILE - 1)] << 8 * k;
    return bits;
}

/* Large boxes: long thin triangles are in few of their windows, which are found first. */
static void draw_found(daft_tile_job *j, const daft_pencil_batch *b, int i, const daft_primitive *t)
{
    planes p = planes_of(j, b, i);
    uint32_t columns = (2u << b->x1[i] / DAFT_WINDOW_W) - (1u << b->x0[i] / DAFT_WINDOW_W);
    uint32_t count = COLUMNS * (uint32_t)((b->y1[i] - b->y0[i]) / DAFT_WINDOW_H + 1);
    uint64_t found[WINDOW_WORDS];
    find_windows(j, b, i, count, found);
    for (uint32_t first = 0; first < count; first += 64) {
        uint64_t left = found[first / 64] & columns * 0x0101010101010101u; /* the columns, in each row */
        if (count - first < 64) left &= ((uint64_t)1 << (count - first)) - 1;
        if (j->sparse) left &= asked_windows(j, b->y0[i] + (int)(first / COLUMNS) * DAFT_WINDOW_H);
        for (; left; left &= left - 1) {
            uint32_t q = first + (uint32_t)__builtin_ctzll(left);
            int y = b->y0[i] + (int)(q / COLUMNS) * DAFT_WINDOW_H;
            window_rows r = rows_of(j, &p, y);
            draw_window(j, &p, &r, (int)(q % COLUMNS) * DAFT_WINDOW_W, y, t);
        }
    }
}

static void draw_all_windows(daft_tile_job *j, const daft_pencil_batch *b, int i, const daft_primitive *t)
{
    planes p = planes_of(j, b, i);
    int x0 = b->x0[i] & -DAFT_WINDOW_W, x1 = b->x1[i], y1 = b->y1[i];
    for (int y = b->y0[i]; y <= y1; y += DAFT_WINDOW_H) {
        const uint32_t asked = j->sparse ? j->asked[y] : UINT32_MAX;
        window_rows r = rows_of(j, &p, y);
        for (int x = x0; x <= x1; x += DAFT_WINDOW_W)
            if (asked >> x / DAFT_WINDOW_W & 1) draw_window(j, &p, &r, x, y, t);
    }
}

static void draw_large(daft_tile_job *j, const daft_pencil_batch *b, int i)
{
    daft_holes holes;
    daft_primitive t = {&j->raster->visible[b->instance[i]], b->triangle[i], NULL};
    if (asks_holes(j, t.view)) {
        holes.known = holes.none = false;
        t.holes = &holes;
    }
    if (b->x1[i] - b->x0[i] >= FIND_FROM && b->y1[i] - b->y0[i] >= FIND_FROM)
        draw_found(j, b, i, &t);
    else
        draw_all_windows(j, b, i, &t);
}

/* So many pixels of thin triangles are looked at together; one triangle adds a tile's at most. */
enum { THIN_MANY = 256, THIN_ROOM = THIN_MANY + DAFT_TILE * DAFT_TILE + DAFT_VL };

/* Lanes that meet the rays of pixels of their own. */
typedef struct hit_list {
    uint32_t count;
    uint32_t hit[THIN_ROOM]; /* the pixel's place | lane << HIT_LANE, and UNSURE */
    float w[THIN_ROOM];      /* off by the lane's error */
} hit_list;

enum { HIT_LANE = 16 };
#define UNSURE ((int32_t)0x80000000)

DAFT_INLINE void add_hits(hit_list *h, vbits lanes, vi places, vi lane, vm sure, vf w)
{
    vi hit = places | lane << HIT_LANE | vi_if_then_else(sure, vi_set(0), vi_set(UNSURE));
    vi_compress_store(&h->hit[h->count], lanes, hit);
    vf_compress_store(&h->w[h->count], lanes, w);
    h->count += (uint32_t)__builtin_popcount(lanes);
}

DAFT_INLINE bool in_hole(const daft_tile_job *j, int at, const daft_view_instance *view, uint32_t triangle)
{
    return DAFT_KERNEL(daft_ray_in_hole)(j, at % DAFT_TILE_STRIDE, at / DAFT_TILE_STRIDE, view, triangle);
}

/* One after the other, since several may be of one pixel. */
static void offer_hits(daft_tile_job *j, const daft_pencil_batch *b, hit_list *h)
{
    for (uint32_t k = 0; k < h->count; k++) {
        uint32_t hit = h->hit[k], i = hit >> HIT_LANE & (DAFT_VL - 1);
        int at = (int)(hit & ((1u << HIT_LANE) - 1));
        bool sure = !(hit & (uint32_t)UNSURE);
        float low = h->w[k] - b->error[i], high = h->w[k] + b->error[i];
        if (high < j->w_low[at]) continue;
        const daft_view_instance *view = &j->raster->visible[b->instance[i]];
        if (asks_holes(j, view) && in_hole(j, at, view, b->triangle[i])) continue;
        j->stale[at / DAFT_TILE_STRIDE / DAFT_CELL] |= 1u << at % DAFT_TILE_STRIDE / DAFT_CELL;
        if (__builtin_expect(sure && low > j->w_high[at], 1)) {
            j->w_low[at] = low, j->w_high[at] = high;
            j->tile->instance[at] = b->instance[i], j->tile->triangle[at] = b->triangle[i];
            continue;
        }
        const daft_primitive t = {view, b->triangle[i], NULL};
        DAFT_KERNEL(daft_ray_decide)(j, at, &t, sure, low, high);
    }
}

/* Of lanes that are live: the others' places may be anywhere. */
DAFT_INLINE void boxes_of(const daft_pencil_batch *b, vi *x0, vi *y0, vi *wide, vi *high)
{
    vm live = vm_from_bits(b->live);
    vi zero = vi_set(0);
    *x0 = vi_if_then_else(live, vi_load(b->x0), zero), *wide = vi_if_then_else(live, vi_load(b->x1), zero) - *x0;
    *y0 = vi_if_then_else(live, vi_load(b->y0), zero), *high = vi_if_then_else(live, vi_load(b->y1), zero) - *y0;
}

/* ---- thin triangles ---- */

/* Long triangles, less than a pixel wide, cover a pixel in every few rows. Their pixels are found by rows along the
 * longer side of their box, `u` and `v` from its first pixel: in row u they are from the largest of low + slope·u to
 * the least of high + slope·u, a bound for each edge; rows side by side in lanes.
 *
 * With S, the sum of what e is made of in the tile, e is computed with an error of less than 3u·S at any pixel, and
 * known as well at the first one; so 8u·S are taken off what a hit needs. Bounds of parts that are less than 2^14 in
 * sum round by less than 2^-8 of a pixel; others bound nothing. */
typedef struct spans {
    float low[3][DAFT_VL], high[3][DAFT_VL], slope[3][DAFT_VL]; /* low: such that rounding down finds the first pixel */
    float last[DAFT_VL];                                        /* v of the box's last pixels */
    int32_t last_row[DAFT_VL];
    int32_t place[DAFT_VL], row_step[DAFT_VL], step[DAFT_VL]; /* of the box's first pixel; to the next row; to the next
                                                                 of a row */
} spans;

#define SPAN_SLACK 0x1p-7f
#define SPAN_PARTS 0x1p14f
/* Triangles longer than THIN_LONG pixels and thinner than THIN_WIDTH in the middle, where a batch may have THIN_LEAST.
 */
#define THIN_WIDTH 0.75f
enum { THIN_LONG = 8, THIN_LEAST = DAFT_VL / 2 };

/* Gives the lanes that are thin, of `some`. */
static vbits spans_setup(const daft_tile_job *j, const daft_pencil_batch *b, vbits some, spans *s)
{
    vi x0, y0, wide, high, stride = vi_set(DAFT_TILE_STRIDE), one = vi_set(1), length = vi_set(THIN_LONG);
    boxes_of(b, &x0, &y0, &wide, &high);
    some &= vbits_from_mask(vm_or(vi_lt(length, wide), vi_lt(length, high)));
    if (__builtin_popcount(some) < THIN_LEAST) return 0;
    vm flat = vi_lt(high, wide);
    vi last_row = vi_if_then_else(flat, wide, high);
    vf last = vf_convert_to(vi_if_then_else(flat, high, wide)), middle = vf_convert_to(last_row) * vf_set(0.5f),
       from = vf_set(1 - SPAN_SLACK), to = last;
    vf dx = vf_set(j->left) + vf_convert_to(x0), dy = vf_set(j->top) - vf_convert_to(y0),
       outer = vf_set(j->exact ? -1.0f : 0.0f);
    for (int k = 0; k < 3; k++) {
        vf nx = vf_load(b->nx[k]), ny = vf_load(b->ny[k]), nz = vf_load(b->nz[k]);
        vf size = vf_abs(nx) * vf_set(j->max_dx) + vf_abs(ny) * vf_set(j->max_dy) + vf_abs(nz);
        vf across = vf_if_then_else(flat, -ny, nx), inverse = vf_set(1) / across;
        vf at = (outer - vf_set(8 * UNIT) * size - (nx * dx + (ny * dy + nz))) * inverse,
           slope = vf_if_then_else(flat, -nx, ny) * inverse;
        vm known = vf_lt(vf_abs(at) + vf_abs(slope) * vf_set(DAFT_TILE), vf_set(SPAN_PARTS)),
           below = vf_lt(vf_set(0), across);
        vf min = vf_if_then_else(vm_and(known, below), at + vf_set(1 - 2 * SPAN_SLACK), vf_set(-INFINITY));
        vf max = vf_if_then_else(vm_and(known, vm_not(below)), at + vf_set(SPAN_SLACK), vf_set(INFINITY));
        slope = vf_if_then_else(known, slope, vf_set(0));
        from = vf_max(from, min + slope * middle), to = vf_min(to, max + slope * middle);
        vf_store(s->low[k], min), vf_store(s->high[k], max), vf_store(s->slope[k], slope);
    }
    vi_store(s->last_row, last_row), vf_store(s->last, last);
    vi_store(s->place, y0 * stride + x0), vi_store(s->row_step, vi_if_then_else(flat, one, stride)),
        vi_store(s->step, vi_if_then_else(flat, stride, one));
    return some & vbits_from_mask(vf_lt(to, from + vf_set(THIN_WIDTH - 1)));
}

/* The pixels that lane i may cover: place | i << 16. Gives how many. */
DAFT_INLINE uint32_t spans_list(const spans *s, int i, uint32_t *list)
{
    vi first = vi_iota() * vi_set(s->row_step[i]) + vi_set(s->place[i] | i << 16), step = vi_set(s->step[i]);
    uint32_t count = 0;
    for (int row = 0; row <= s->last_row[i]; row += DAFT_VL) {
        vf u = vf_convert_to(vi_iota() + vi_set(row)), low = vf_set(1 - SPAN_SLACK), high = vf_set(s->last[i]);
        for (int k = 0; k < 3; k++) {
            vf more = vf_set(s->slope[k][i]) * u;
            low = vf_max(vf_set(s->low[k][i]) + more, low), high = vf_min(vf_set(s->high[k][i]) + more, high);
        }
        vi v = vi_convert_to(low), at = first + v * step;
        vf column = vf_convert_to(v);
        vbits lanes = vbits_first_n(s->last_row[i] + 1 - row) & vbits_from_mask(vf_le(column, high));
        for (; lanes; lanes &= vbits_from_mask(vf_le(column, high))) {
            vi_compress_store(&list[count], lanes, at);
            count += (uint32_t)__builtin_popcount(lanes);
            column += vf_set(1), at += step;
        }
        first += vi_set(DAFT_VL * s->row_step[i]);
    }
    return count;
}

/* The rays of such pixels, each against its own triangle. */
static void draw_listed(daft_tile_job *j, const daft_pencil_batch *b, const uint32_t *list, uint32_t count)
{
    vf outer = vf_set(j->exact ? -1.0f : 0.0f), sure = vf_set(j->exact ? 1 : -INFINITY);
    hit_list hits;
    hits.count = 0;
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vbits lanes = vbits_first_n((int)(count - i));
        vi listed = vi_if_then_else(vm_from_bits(lanes), vi_load(&list[i]), vi_set(0));
        vi lane = listed >> 16, place = listed & vi_set(0xffff), y = place >> __builtin_ctz(DAFT_TILE_STRIDE);
        vi x = place & vi_set(DAFT_TILE_STRIDE - 1);
        vf dx = vf_set(j->left) + vf_convert_to(x), dy = vf_set(j->top) - vf_convert_to(y), min = vf_set(INFINITY);
        for (int k = 0; k < 3; k++)
            min = vf_min(vf_table_lookup(b->nx[k], lane) * dx +
                             (vf_table_lookup(b->ny[k], lane) * dy + vf_table_lookup(b->nz[k], lane)),
                         min);
        vf w = vf_table_lookup(b->wx, lane) * dx + (vf_table_lookup(b->wy, lane) * dy + vf_table_lookup(b->wz, lane));
        vf error = j->exact ? vf_table_lookup(b->error, lane) : vf_set(0);
        w = vf_min(w, vf_table_lookup(b->w_cap, lane));
        lanes &=
            vbits_from_mask(vf_le(outer, min)) & ~vbits_from_mask(vf_lt(w + error, vf_gather_index(j->w_low, place)));
        add_hits(&hits, lanes, place, lane, vf_lt(sure, min), w);
    }
    offer_hits(j, b, &hits);
}

/* Gives those that were. */
static vbits draw_thin(daft_tile_job *j, const daft_pencil_batch *b, vbits some)
{
    spans s;
    uint32_t list[THIN_ROOM], count = 0;
    some = spans_setup(j, b, some, &s);
    for (vbits left = some; left; left &= left - 1) {
        count += spans_list(&s, __builtin_ctz(left), &list[count]);
        if (count < THIN_MANY) continue;
        draw_listed(j, b, list, count);
        count = 0;
    }
    if (count) draw_listed(j, b, list, count);
    return some;
}

static void fetch_doubted(const daft_small *from, daft_hits *h)
{
    for (uint32_t i = 0; i < h->doubted_count; i++) {
        const daft_trimesh *mesh = from->view->mesh;
        const uint32_t *corner = &mesh->indices[3 * (size_t)from->triangle[h->doubted[i]]];
        for (int k = 0; k < 3; k++)
            __builtin_prefetch(&mesh->x[corner[k]]), __builtin_prefetch(&mesh->y[corner[k]]),
                __builtin_prefetch(&mesh->z[corner[k]]);
    }
    h->doubted_count = 0;
}

DAFT_INLINE void hits_draw_as(daft_tile_job *j, bool exact, const daft_small *from, const daft_hits *h)
{
    uint32_t *instance = j->tile->instance, *triangle = j->tile->triangle;
    const bool holes = h->count && asks_holes(j, from->view);
    for (uint32_t k = 0, count = h->count; k < count; k++) {
        uint32_t hit = h->place[k], at = hit & (DAFT_HIT_UNSURE - 1), number = hit >> DAFT_HIT_TRIANGLE;
        float low = h->low[k], high = exact ? h->high[k] : low;
        if (high < j->w_low[at]) continue;
        const daft_view_instance *view = from->view;
        if (holes && in_hole(j, (int)at, view, from->triangle[number])) continue;
        bool sure = !exact || !(hit & DAFT_HIT_UNSURE);
        j->stale[at / DAFT_TILE_STRIDE / DAFT_CELL] |= 1u << at % DAFT_TILE_STRIDE / DAFT_CELL;
        if (__builtin_expect(sure && low > j->w_high[at], 1)) {
            j->w_low[at] = low, j->w_high[at] = high;
            instance[at] = view->index, triangle[at] = from->triangle[number];
            continue;
        }
        const daft_primitive t = {view, from->triangle[number], NULL};
        DAFT_KERNEL(daft_ray_decide)(j, (int)at, &t, sure, low, high);
    }
}

void DAFT_KERNEL(daft_hits_draw)(daft_tile_job *j, daft_small *from, daft_hits *h)
{
    fetch_doubted(from, h);
    if (j->fine) {
        DAFT_KERNEL(daft_fine_hits_draw)(j, from, h);
    } else if (j->exact) {
        hits_draw_as(j, true, from, h);
    } else {
        hits_draw_as(j, false, from, h);
    }
    h->count = from->count = 0;
}

void DAFT_KERNEL(daft_batch_draw)(daft_tile_job *j, const daft_pencil_batch *b)
{
    vbits live = b->live;
    if (j->fine) {
        DAFT_KERNEL(daft_fine_batch_draw)(j, b);
        return;
    }
    for (live &= ~draw_thin(j, b, live); live; live &= live - 1) draw_large(j, b, __builtin_ctz(live));
}

/* ---- spheres ---- */

void DAFT_KERNEL(daft_sphere_draw)(daft_tile_job *j, const daft_view_instance *view, int x0, int x1, int y0, int y1)
{
    if (j->fine) {
        DAFT_KERNEL(daft_fine_sphere_draw)(j, view, x0, x1, y0, y1);
        return;
    }
    const daft_primitive t = {view, 0, NULL};
    const sphere s = sphere_of(j, view);
    x0 &= -DAFT_WINDOW_W;
    for (int y = y0; y <= y1; y += DAFT_WINDOW_H)
        for (int x = x0; x <= x1; x += DAFT_WINDOW_W) {
            const sphere_hits h =
                sphere_meet(&s, vf_load(j->dx[x / DAFT_WINDOW_W]), vf_set(j->top - (float)y) - vf_row());
            if (h.lanes) offer(j, (uint32_t)(y * DAFT_TILE_STRIDE + x), &t, h.lanes, h.unsure, h.low, h.high);
        }
}
