/* Groups a tile's lit points into blocks of 16, the unit that occluders are tested against: squares of 4 by 4 pixels,
 * which lie side by side on a surface and so also as the light sees them. Squares across a silhouette are far apart
 * there: blocks much larger than usual are taken apart, and their points make new blocks along a Morton curve. */
#include "raster/samples/samples.h"

typedef struct blocks_job {
    const light_view *view;
    const daft_samples *samples;
    const uint32_t *own;
} blocks_job;

_Static_assert(
    DAFT_TILE == 32,
    "a tile's row is a word of a set of bits; three bits of a square's column and row make its place on the curve");

static uint32_t square_column(uint32_t square) { return (square & 1) | (square >> 1 & 2) | (square >> 2 & 4); }

/* A batch that holds the tile's pixels one after the other needs no sorting. */
static bool is_whole_tile(const daft_samples *b)
{
    if (b->count != DAFT_TILE * DAFT_TILE) return false;
    vbits in_place = DAFT_ALL_LANES;
    for (uint32_t i = 0; i < b->count; i += DAFT_VL)
        in_place &= vbits_from_mask(vi_eq(vi_load(&b->pixel[i]), vi_set((int32_t)i) + vi_iota()));
    return in_place == DAFT_ALL_LANES;
}

static void place_whole_tile(const uint32_t *kept, places *out)
{
    const vi within = (vi_iota() & vi_set(3)) + (vi_iota() >> 2) * vi_set(DAFT_TILE);
    out->count = 0, out->rows = true;
    for (uint32_t square = 0; square < SHADOW_TILE_BLOCKS; square++) {
        uint32_t x = square_column(square) * 4, y = square_column(square >> 1) * 4, used = 0;
        for (uint32_t row = 0; row < 4; row++) used |= (kept[y + row] >> x & 15) << (4 * row);
        if (!used) continue;
        for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL)
            vi_store(&out->at[out->count * SHADOW_BLOCK + k], within + vi_set((int32_t)((y + k / 4) * DAFT_TILE + x)));
        out->used[out->count++] = used;
    }
}

/* Squares along a Morton curve: 16 in a row form a square, so groups are compact. */
DAFT_INLINE vi squares_of(vi pixel)
{
    vi x = (pixel >> 2) & vi_set(7), y = pixel >> __builtin_ctz(4 * DAFT_TILE); /* of 4 by 4 pixels */
    return (x & vi_set(1)) | (y & vi_set(1)) << 1 | (x & vi_set(2)) << 1 | (y & vi_set(2)) << 2 | (x & vi_set(4)) << 2 |
           (y & vi_set(4)) << 3;
}

static void list_kept(const daft_samples *b, const uint32_t *kept, kept_points *out)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        vbits in = kept[i / 32] >> (i % 32) & DAFT_ALL_LANES;
        vi_compress_store(&out->index[count], in, vi_iota() + vi_set((int32_t)i));
        vi_compress_store(&out->square[count], in, squares_of(vi_load(&b->pixel[i])));
        count += (uint32_t)__builtin_popcount(in);
    }
    out->count = count;
}

/* Blocks for some sets of so many points, each of which begins one: gives where each set's first point goes. */
static void blocks_for(const uint32_t *points, uint32_t sets, uint32_t *first, places *out)
{
    uint32_t blocks = 0;
    for (uint32_t i = 0; i < sets; i++) {
        first[i] = blocks * SHADOW_BLOCK;
        for (uint32_t left = points[i]; left; left -= daft_min_u(left, SHADOW_BLOCK))
            out->used[blocks++] = left >= SHADOW_BLOCK ? 0xffff : ((uint32_t)1 << left) - 1;
    }
    out->count = blocks, out->rows = false;
    memset(out->at, 0, blocks * SHADOW_BLOCK * sizeof out->at[0]);
}

/* Counting sort by square; each square begins a block. */
static void place_by_squares(const kept_points *list, places *out)
{
    uint32_t points[SHADOW_TILE_BLOCKS] = {0}, next[SHADOW_TILE_BLOCKS];
    for (uint32_t k = 0; k < list->count; k++) points[list->square[k]]++;
    blocks_for(points, SHADOW_TILE_BLOCKS, next, out);
    for (uint32_t k = 0; k < list->count; k++) out->at[next[list->square[k]]++] = list->index[k];
}

static void place_points(const daft_samples *samples, const uint32_t *kept, block_scratch *scratch)
{
    if (is_whole_tile(samples)) {
        place_whole_tile(kept, &scratch->places);
        return;
    }
    list_kept(samples, kept, &scratch->kept);
    place_by_squares(&scratch->kept, &scratch->places);
}

/* DAFT_VL values from their places, of which the first is `from`; `rows`: they are in rows of four below each other. */
DAFT_INLINE vi pick(const void *base, const uint32_t *at, const float *from, bool rows)
{
    return rows ? (vi)vf_load_blocks(from, DAFT_TILE) : vi_gather_index(base, vi_load(at));
}

DAFT_INLINE vf along(daft_vec3 axis, vf3 v)
{
    return vf_set(axis.x) * v.x + vf_set(axis.y) * v.y + vf_set(axis.z) * v.z;
}

/* box_enter in lanes. */
static vf boxes_enter(const daft_apex *light, vf3 from)
{
    const daft_slanted_box *box = light->box;
    const daft_vec3 m = box->middle, to = light->at;
    const vf one = vf_set(1), zero = vf_set(0);
    const vf3 rest = {from.x - vf_set(m.x), from.y - vf_set(m.y), from.z - vf_set(m.z)},
              way = {vf_set(to.x) - from.x, vf_set(to.y) - from.y, vf_set(to.z) - from.z};
    vf first = zero, last = one;
    vm meets = vf_le(zero, one);
    for (int k = 0; k < 3; k++) {
        const vf at = along(box->axes[k], rest), by = along(box->axes[k], way);
        meets = vm_and(meets, vm_or(vf_le(vf_abs(at), one), vf_lt(at * by, zero)));
        const vm level = vm_and(vf_le(by, zero), vf_le(zero, by));
        const vf a = (-one - at) / by, b = (one - at) / by;
        first = vf_if_then_else(level, first, vf_max(first, vf_min(a, b)));
        last = vf_if_then_else(level, last, vf_min(last, vf_max(a, b)));
    }
    return vf_if_then_else(vm_and(meets, vf_le(first, last)), first, one);
}

/* At which depths the rays of points end, from their places in frame and in view space. */
DAFT_INLINE vf ends_of(const light_view *l, vf3 from, vf3 p, vf z)
{
    const daft_apex *light = l->light;
    const vf at = vf_set(-l->pencil.away);
    if (l->pencil.parallel) return vf_set(-INFINITY);
    if (!(light->around > 0 || light->before > 0 || light->box)) return at;
    const vf way = vf_sqrt(p.x * p.x + p.y * p.y + z * z);
    vf left = vf_max(vf_set(light->before), vf_set(light->around) / way);
    if (light->box) left = vf_max(left, vf_set(1) - boxes_enter(light, from));
    return at + z * left;
}

DAFT_INLINE void fill_block(const blocks_job *c, const places *from, uint32_t b, bool rows, shadow_points *to)
{
    const light_view *l = c->view;
    const vf inf = vf_set(INFINITY);
    vf lu = inf, lv = inf, hu = -inf, hv = -inf, far = -inf, end = inf;
    uint32_t first = from->at[b * SHADOW_BLOCK + (uint32_t)__builtin_ctz(from->used[b])], one = 0;
    const vi on = vi_set((int32_t)c->samples->instance[first]), own = vi_set((int32_t)c->own[first]);
    to->used[b] = from->used[b], to->under[b] = 0;
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
        uint32_t at = b * SHADOW_BLOCK + k;
        const uint32_t *place = &from->at[at];
        vm used = vm_from_bits(from->used[b] >> k & DAFT_ALL_LANES);
        const daft_points3 *origin = &c->samples->origin;
        vf3 p = {(vf)pick(origin->x, place, (const float *)origin->x + place[0], rows),
                 (vf)pick(origin->y, place, (const float *)origin->y + place[0], rows),
                 (vf)pick(origin->z, place, (const float *)origin->z + place[0], rows)};
        const vf3 origin_of = p;
        p = to_view_space(&l->pencil, p);
        picture_place seen = picture_of(l, p);
        vf depth = vf_if_then_else(used, p.z, -inf);
        vf_store(&to->u[at], seen.u), vf_store(&to->v[at], seen.v);
        vf_store(&to->x[at], p.x), vf_store(&to->y[at], p.y), vf_store(&to->z[at], seen.z);
        const vf ends = ends_of(l, origin_of, p, seen.z);
        vf_store(&to->depth[at], depth), vf_store(&to->end[at], ends);
        end = vf_min(vf_if_then_else(used, ends, inf), end);
        vi_store(&to->source[at], vi_load(place));
        vi instance = pick(c->samples->instance, place, (const float *)c->samples->instance + place[0], rows);
        vi triangle = pick(c->own, place, (const float *)c->own + place[0], rows);
        vi_store(&to->instance[at], instance), vi_store(&to->own[at], triangle);
        one |= vbits_from_mask(vm_and(vi_eq(instance, on), vi_eq(triangle, own))) << k;
        lu = vf_min(vf_if_then_else(used, seen.u, inf), lu), hu = vf_max(vf_if_then_else(used, seen.u, -inf), hu);
        lv = vf_min(vf_if_then_else(used, seen.v, inf), lv), hv = vf_max(vf_if_then_else(used, seen.v, -inf), hv);
        far = vf_max(depth, far);
    }
    bool alike = (from->used[b] & ~one) == 0;
    to->on[b] = alike ? c->samples->instance[first] : DAFT_NOTHING,
    to->sole[b] = alike ? c->own[first] : DAFT_NO_TRIANGLE;
    const v4 box = v4_reduce_min4(lu, -hu, lv, -hv);
    to->low_u[b] = box[0], to->high_u[b] = -box[1], to->low_v[b] = box[2], to->high_v[b] = -box[3];
    to->far[b] = vf_reduce_max(far);
    to->min_end = fminf(to->min_end, vf_reduce_min(end));
}

/* ---- squares that are no neighbours to the light ---- */

static float block_size(const shadow_points *p, uint32_t b)
{
    return (p->high_u[b] - p->low_u[b]) + (p->high_v[b] - p->low_v[b]);
}

/* What the smaller blocks measure in the mean. Sums are of eight at a time on every machine. */
static float usual_size(const shadow_points *p)
{
    float size[SHADOW_BLOCKS + 8], limit = INFINITY;
    for (uint32_t b = 0; b < p->count; b++) size[b] = block_size(p, b);
    v8_store(&size[p->count], v8_set(NAN)); /* past the last: not below any limit */
    for (int pass = 0; pass < 3; pass++) {
        v8 sums = v8_set(0);
        v8i counts = {0};
        for (uint32_t b = 0; b < p->count; b += 8) {
            v8 some = v8_load(&size[b]);
            v8i usual = some <= v8_set(limit);
            sums = sums + (v8)((v8i)some & usual), counts = counts - usual;
        }
        float sum = 0;
        int32_t count = 0;
        for (int i = 0; i < 8; i++) sum += sums[i], count += counts[i];
        if (count) limit = sum / (float)count;
    }
    return limit;
}

DAFT_INLINE vi spread_bits(vi x)
{
    x = (x | x << 4) & vi_set(0x0f0f);
    x = (x | x << 2) & vi_set(0x3333);
    return (x | x << 1) & vi_set(0x5555);
}

DAFT_INLINE vi picture_cell(vf place, float low, float scale)
{
    vf at = (place - vf_set(low)) * vf_set(scale);
    return vi_convert_to(vf_min(vf_max(at, vf_set(0)), vf_set(255)));
}

static void add_strays(const shadow_points *p, uint32_t b, strays *out)
{
    uint32_t key[SHADOW_BLOCK];
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
        uint32_t at = b * SHADOW_BLOCK + k;
        vi u = picture_cell(vf_load(&p->u[at]), out->low_u, out->scale),
           v = picture_cell(vf_load(&p->v[at]), out->low_v, out->scale);
        vi_store(&key[k], (spread_bits(u) | spread_bits(v) << 1) << PLACE_BITS | vi_load(&p->source[at]));
    }
    for (uint32_t in = p->used[b]; in; in &= in - 1) out->key[out->count++] = key[__builtin_ctz(in)];
}

/* The cells' grid: as fine as 256 of them along the longer side allow. */
static void strays_setup(const shadow_points *p, float usual, strays *out)
{
    float high_u = -INFINITY, high_v = -INFINITY;
    out->count = out->free_count = 0;
    out->low_u = out->low_v = INFINITY;
    for (uint32_t b = 0; b < p->count; b++) {
        if (block_size(p, b) <= out->max) continue;
        out->low_u = fminf(out->low_u, p->low_u[b]), high_u = fmaxf(high_u, p->high_u[b]);
        out->low_v = fminf(out->low_v, p->low_v[b]), high_v = fmaxf(high_v, p->high_v[b]);
    }
    out->scale = 255.9f / fmaxf(fmaxf(high_u - out->low_u, high_v - out->low_v), TINY);
    float side = usual * out->scale; /* half a block's outline, in cells: twice its side */
    for (out->jump = 0; side >= 1 && out->jump < 16; out->jump += 2) side *= 0.5f;
    out->jump += PLACE_BITS;
}

/* Takes the blocks apart that are so many times larger than usual. */
static void take_strays(const shadow_points *p, float usual, float stray, strays *out)
{
    out->max = stray * usual;
    strays_setup(p, usual, out);
    for (uint32_t b = 0; b < p->count; b++) {
        if (block_size(p, b) <= out->max) continue;
        add_strays(p, b, out);
        out->free[out->free_count++] = b;
    }
}

/* By the upper six bits of each axis; the order within such a cell does not matter. */
static void sort_strays(strays *s)
{
    uint32_t other[DAFT_SAMPLES_ROOM], *from = s->key, *to = other;
    for (uint32_t shift = PLACE_BITS + 4; shift < PLACE_BITS + 16; shift += 6) {
        uint32_t next[64] = {0}, sum = 0;
        for (uint32_t i = 0; i < s->count; i++) next[from[i] >> shift & 63]++;
        for (uint32_t k = 0; k < 64; k++) {
            uint32_t count = next[k];
            next[k] = sum;
            sum += count;
        }
        for (uint32_t i = 0; i < s->count; i++) to[next[from[i] >> shift & 63]++] = from[i];
        uint32_t *done = from;
        from = to, to = done;
    }
}

/* Begins a block where one was taken apart, or after the last. */
static uint32_t begin_block(strays *s, places *out)
{
    uint32_t b = s->free_count ? s->free[--s->free_count] : out->count++;
    memset(&out->at[b * SHADOW_BLOCK], 0, SHADOW_BLOCK * sizeof out->at[0]);
    out->used[b] = 0;
    return b;
}

/* Blocks along the curve; a jump ends a block that is half full, as long as the others have room. */
static void place_strays(const blocks_job *c, strays *s, places *out, shadow_points *to)
{
    uint32_t used = SHADOW_BLOCK, b = 0, room = s->free_count + SHADOW_BLOCKS - out->count;
    out->rows = false;
    for (uint32_t i = 0; i < s->count; i++) {
        bool spare = room > (s->count - i) / SHADOW_BLOCK + 1;
        if (used == SHADOW_BLOCK || (spare && used >= SHADOW_BLOCK / 2 && (s->key[i] ^ s->key[i - 1]) >> s->jump)) {
            if (i) fill_block(c, out, b, false, to);
            b = begin_block(s, out);
            room--, used = 0;
        }
        out->used[b] |= (uint32_t)1 << used;
        out->at[b * SHADOW_BLOCK + used++] = s->key[i] & (((uint32_t)1 << PLACE_BITS) - 1);
    }
    fill_block(c, out, b, false, to);
}

static void empty_block(shadow_points *p, uint32_t b)
{
    p->low_u[b] = p->low_v[b] = INFINITY, p->high_u[b] = p->high_v[b] = p->far[b] = -INFINITY;
    p->used[b] = 0;
}

void DAFT_KERNEL(daft_shadow_blocks)(const light_view *l, const daft_samples *samples, const uint32_t *own,
                                     const uint32_t *kept, float stray, block_scratch *scratch, shadow_points *to)
{
    const blocks_job c = {l, samples, own};
    places *from = &scratch->places;
    strays *apart = &scratch->strays;
    place_points(samples, kept, scratch);
    to->min_end = INFINITY;
    for (uint32_t b = 0; b < from->count; b++)
        from->rows ? fill_block(&c, from, b, true, to) : fill_block(&c, from, b, false, to);
    to->count = from->count;
    take_strays(to, usual_size(to), stray, apart);
    if (apart->count) {
        sort_strays(apart);
        place_strays(&c, apart, from, to);
    }
    to->count = from->count, to->live = to->count - apart->free_count;
    for (uint32_t i = 0; i < apart->free_count; i++) empty_block(to, apart->free[i]);
    for (uint32_t b = to->count; b % SHADOW_GROUP; b++)
        empty_block(to, b); /* what is read past the end meets nothing */
}

/* ---- and out again ---- */

/* Whether a block is four rows of four pixels below each other, of which none goes on in another word of bits. */
DAFT_INLINE bool is_square(const uint32_t *source)
{
    const vi square = (vi_iota() & vi_set(3)) + (vi_iota() >> 2) * vi_set(DAFT_TILE);
    vbits in_place = DAFT_ALL_LANES;
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL)
        in_place &=
            vbits_from_mask(vi_eq(vi_load(&source[k]), square + vi_set((int32_t)(source[0] + k / 4 * DAFT_TILE))));
    return in_place == DAFT_ALL_LANES && source[0] % 4 == 0;
}

void DAFT_KERNEL(daft_shadow_dark)(const shadow_points *p, uint32_t *bits)
{
    for (uint32_t b = 0; b < p->count; b++) {
        const uint32_t *source = &p->source[b * SHADOW_BLOCK];
        uint32_t dark = p->used[b];
        for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL)
            dark &= ~(vbits_from_mask(vf_lt(vf_set(-INFINITY), vf_load(&p->depth[b * SHADOW_BLOCK + k]))) << k);
        if (dark && is_square(source)) {
            for (uint32_t row = 0; row < 4; row++)
                bits[source[0] / 32 + row] &= ~((dark >> (4 * row) & 15) << source[0] % 32);
            continue;
        }
        for (; dark; dark &= dark - 1) {
            uint32_t at = source[__builtin_ctz(dark)];
            bits[at / 32] &= ~((uint32_t)1 << (at % 32));
        }
    }
}
