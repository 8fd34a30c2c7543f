/* An instance's tree against a tile, by the screen boxes of eight nodes at a time. A node is left out when its box lies beside
 * the tile, between the rays of its pixels, or behind what all pixels in reach of it see already. Leaves' blocks of triangles
 * are set up and drawn DAFT_VL / 4 at a time.
 *
 * Where triangles are large each node waits for what is in front of it, so that it may turn out to be hidden. Where there is
 * one or more to a pixel, nodes are looked at in groups, without a branch that depends on one of them: there, what a
 * processor guesses wrong costs more than the arithmetic. */
#include "raster/kernels.h"

enum {
    GROUP = 16, /* nodes */
    FRESH = GROUP * DAFT_WIDTH,
    CROWDED = 1024,               /* so many wait: no more groups; what one node leads to adds DAFT_STACK at most */
    WAITING = CROWDED + FRESH + DAFT_STACK,
    ORDERS = 16 /* distances that are told apart within a group */
};

/* A node or leaf to be looked at. */
typedef struct visit {
    uint32_t child;
    float nearest;   /* no w in it is larger */
    uint32_t pixels; /* of the tile: x0 | x1 << 8 | y0 << 16 | y1 << 24 */
} visit;

/* What a group leads to. */
typedef struct fresh {
    uint32_t count;
    uint32_t child[FRESH + DAFT_WIDTH], pixels[FRESH + DAFT_WIDTH];
    float nearest[FRESH + DAFT_WIDTH];
} fresh;

/* An instance's map to the tile: x and y come out in pixels times z. */
typedef struct walk {
    daft_tile_job *job;
    daft_waiting *waiting;
    const daft_seen *seen;
    float m[9];
    float low_t[3], high_t[3]; /* the translation, less and more a pad over the error of a moved vertex */
    int low_at[9], high_at[9]; /* which of a node's bounds makes m's product least, and most */
    const daft_block *blocks[DAFT_WALK_BLOCKS + DAFT_MAX_LEAF_BLOCKS];
    uint32_t block_count;
} walk;

/* ---- what is hidden ---- */

static void refresh_cell(daft_tile_job *j, uint32_t x, uint32_t y)
{
    const float *w = &j->w_low[y * DAFT_CELL * DAFT_TILE_STRIDE + x * DAFT_CELL];
    v4 least = v4_min(v4_min(v4_load(w), v4_load(w + DAFT_TILE_STRIDE)),
                      v4_min(v4_load(w + 2 * DAFT_TILE_STRIDE), v4_load(w + 3 * DAFT_TILE_STRIDE)));
    float a = least[0] < least[1] ? least[0] : least[1], b = least[2] < least[3] ? least[2] : least[3];
    j->farthest[y][x] = a < b ? a : b;
}

static __attribute__((noinline)) bool cells_hidden(daft_tile_job *j, uint32_t pixels, float least)
{
    uint32_t x0 = pixels & 255, x1 = pixels >> 8 & 255, y0 = pixels >> 16 & 255, last = (pixels >> 24) / DAFT_CELL;
    v8 nearest = v8_set(least);
    uint32_t columns = (2u << x1 / DAFT_CELL) - (1u << x0 / DAFT_CELL);
    for (uint32_t y = y0 / DAFT_CELL; y <= last; y++) {
        uint32_t open = v8_le_bits(v8_load(j->farthest[y]), nearest) & columns;
        if (!open) continue;
        if (open & ~j->stale[y]) return false;
        for (uint32_t left = open; left; left &= left - 1) refresh_cell(j, (uint32_t)__builtin_ctz(left), y);
        j->stale[y] &= ~open;
        if (v8_le_bits(v8_load(j->farthest[y]), nearest) & open) return false;
    }
    return true;
}

/* Where rows 1 to 7 begin, of a box whose last row is given: beyond it that row again. */
#define ROW(last, r) (uint8_t)(DAFT_TILE_STRIDE * ((r) < (last) ? (r) : (last)))
#define ROWS_TO(last) {ROW(last, 1), ROW(last, 2), ROW(last, 3), ROW(last, 4), ROW(last, 5), ROW(last, 6), ROW(last, 7)}
static const uint8_t ROWS[8][7] = {ROWS_TO(0), ROWS_TO(1), ROWS_TO(2), ROWS_TO(3), ROWS_TO(4), ROWS_TO(5), ROWS_TO(6), ROWS_TO(7)};

/* Whether all pixels of a visit see something nearer: by the pixels themselves where they are few. */
DAFT_INLINE bool hidden(daft_tile_job *j, uint32_t pixels, float nearest)
{
    uint32_t x0 = pixels & 255, width = (pixels >> 8 & 255) - x0, y0 = pixels >> 16 & 255, height = (pixels >> 24) - y0;
    if (width >= 8 || height >= 8) return cells_hidden(j, pixels, nearest);
    const float *w = &j->w_low[y0 * DAFT_TILE_STRIDE + x0];
    const uint8_t *row = ROWS[height];
    v8 least = v8_load(w);
    for (int r = 0; r < 3; r++) least = v8_min(least, v8_load(w + row[r]));
    if (height >= 4)
        for (int r = 3; r < 7; r++) least = v8_min(least, v8_load(w + row[r]));
    return !(v8_le_bits(least, v8_set(nearest)) & ((2u << width) - 1));
}

/* ---- nodes and leaves ---- */

void DAFT_KERNEL(daft_waiting_draw)(daft_tile_job *job, daft_waiting *waiting)
{
    daft_pencil_batch batch;
    if (DAFT_KERNEL(daft_waiting_setup)(job, waiting, &batch)) DAFT_KERNEL(daft_batch_draw)(job, &batch);
}

/* At once if they are large or many: they may hide others. */
static void draw_blocks(walk *w)
{
    daft_pencil_batch batch;
    if (!w->block_count) return;
    if (DAFT_KERNEL(daft_blocks_setup)(w->job, w->seen, w->blocks, w->block_count, w->waiting, &batch))
        DAFT_KERNEL(daft_batch_draw)(w->job, &batch);
    w->block_count = 0;
    while (w->waiting->count >= DAFT_VL) DAFT_KERNEL(daft_waiting_draw)(w->job, w->waiting);
}

static void gather_blocks(walk *w)
{
    for (uint32_t i = 0; i < w->block_count; i += DAFT_BATCH_BLOCKS)
        DAFT_KERNEL(daft_blocks_project)(w->job, w->seen, &w->blocks[i], daft_min_u(w->block_count - i, DAFT_BATCH_BLOCKS), w->waiting);
    w->block_count = 0;
    while (w->waiting->count >= DAFT_VL) DAFT_KERNEL(daft_waiting_draw)(w->job, w->waiting);
}

DAFT_INLINE v8 pick(v8i m, v8 a, v8 b) { return (v8)((m & (v8i)a) | (~m & (v8i)b)); }

/* One axis of eight boxes, over z: low..high before the division by z within near..far, where both are positive. Boxes that
 * reach behind the camera are out where all that is in front of it lies beside the tile. */
DAFT_INLINE uint32_t box_span(v8 low, v8 high, v8 far, v8 inverse_near, v8 inverse_far, v8i front, float last, v8i *first,
                              v8i *end)
{
    uint32_t beside = v8_lt_bits(high, far * -DAFT_SCREEN_SLACK) | v8_lt_bits(far * (last + DAFT_SCREEN_SLACK), low);
    v8 zero = v8_set(0), slack = v8_set(DAFT_SCREEN_SLACK);
    v8 a = low * pick(low < zero, inverse_near, inverse_far) - slack, b = high * pick(high < zero, inverse_far, inverse_near) + slack;
    a = v8_max(pick(front, a, zero), zero), b = v8_min(pick(front, b, v8_set(last)), v8_set(last));
    v8i whole = __builtin_convertvector(a, v8i);
    whole -= __builtin_convertvector(whole, v8) < a; /* a comparison gives -1 */
    *first = whole, *end = __builtin_convertvector(b, v8i);
    return v8_le_bits(zero, b) & v8_le_bits(__builtin_convertvector(*first, v8), b) & ~beside;
}

/* The least and the largest value of one axis over eight boxes. */
DAFT_INLINE void axis(const walk *w, int k, const daft_node *node, v8 *low, v8 *high)
{
    const float *m = &w->m[3 * k], *bounds = node->bounds[0];
    const int *a = &w->low_at[3 * k], *b = &w->high_at[3 * k];
    *low = m[0] * v8_load(bounds + a[0]) + m[1] * v8_load(bounds + a[1]) + m[2] * v8_load(bounds + a[2]) + w->low_t[k];
    *high = m[0] * v8_load(bounds + b[0]) + m[1] * v8_load(bounds + b[1]) + m[2] * v8_load(bounds + b[2]) + w->high_t[k];
}

static void walk_begin(walk *w, daft_tile_job *job, const daft_seen *seen, daft_waiting *waiting)
{
    const daft_affine *map = &seen->to_camera;
    const float *low = &seen->instance->mesh->low.x, *high = &seen->instance->mesh->high.x, focal = job->raster->pencil.focal;
    w->job = job, w->seen = seen, w->waiting = waiting, w->block_count = 0;
    float pad[3];
    for (int k = 0; k < 3; k++) {
        float size = fabsf(map->t[k]);
        for (int i = 0; i < 3; i++) size += fabsf(map->m[3 * k + i]) * fmaxf(fabsf(low[i]), fabsf(high[i]));
        pad[k] = size * 0x1p-20f;
    }
    pad[0] = pad[0] * focal + pad[2] * fabsf(job->left);
    pad[1] = pad[1] * focal + pad[2] * fabsf(job->top);
    /* column = focal·x/z - left and row = top - focal·y/z, so their multiples by z are linear in the point. */
    for (int i = 0; i < 4; i++) {
        const float x = i < 3 ? map->m[i] : map->t[0], y = i < 3 ? map->m[3 + i] : map->t[1], z = i < 3 ? map->m[6 + i] : map->t[2];
        const float row[3] = {x * focal - z * job->left, z * job->top - y * focal, z};
        for (int k = 0; k < 3; k++) {
            if (i == 3) {
                w->low_t[k] = row[k] - pad[k], w->high_t[k] = row[k] + pad[k];
                continue;
            }
            w->m[3 * k + i] = row[k];
            w->low_at[3 * k + i] = DAFT_WIDTH * (row[k] < 0 ? i + 3 : i), w->high_at[3 * k + i] = DAFT_WIDTH * (row[k] < 0 ? i : i + 3);
        }
    }
}

/* A node's children in the tile. */
typedef struct boxes {
    v8i pixels;
    v8 nearest;
    uint32_t some;
} boxes;

/* Comparisons are written so that a NaN, from an overflow, leaves a box in. */
DAFT_INLINE boxes children(const walk *w, const daft_node *node)
{
    v8 low[3], high[3], zero = v8_set(0);
    v8i x0, x1, y0, y1;
    for (int k = 0; k < 3; k++) axis(w, k, node, &low[k], &high[k]);
    v8i front = low[2] > zero, empty = v8i_load(node->child) == (int32_t)DAFT_CHILD_NONE;
    v8 inverse_near = 1 / low[2], inverse_far = 1 / high[2];
    uint32_t x = box_span(low[0], high[0], high[2], inverse_near, inverse_far, front, w->job->last_x, &x0, &x1);
    uint32_t y = box_span(low[1], high[1], high[2], inverse_near, inverse_far, front, w->job->last_y, &y0, &y1);
    return (boxes){x0 | x1 << 8 | y0 << 16 | y1 << 24, pick(front, inverse_near * (1 + 0x1p-20f), v8_set(INFINITY)),
                   x & y & ~v8_le_bits(high[2], zero) & ~v8i_bits(empty)};
}

/* What a visit will read first: trees of large meshes do not stay in the nearer caches. */
DAFT_INLINE void prefetch(const daft_bvh *bvh, uint32_t child)
{
    const char *block = (const char *)&bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2], *node = (const char *)&bvh->nodes.items[child];
    const char *at = child & DAFT_CHILD_LEAF ? block : node;
    for (int i = 0; i < 256; i += 64) __builtin_prefetch(at + i);
}

/* ---- one node after the other ---- */

/* Pushes the children that may be seen, the nearest last. */
static int push_children(walk *w, const daft_node *node, visit *stack, int top)
{
    boxes b = children(w, node);
    int first = top;
    w->job->counters->nodes++;
    for (uint32_t some = b.some; some; some &= some - 1) {
        int i = __builtin_ctz(some), at = top;
        visit v = {node->child[i], b.nearest[i], (uint32_t)b.pixels[i]};
        for (; at > first && stack[at - 1].nearest > v.nearest; at--) stack[at] = stack[at - 1];
        stack[at] = v;
        top++;
        prefetch(w->seen->instance->bvh, v.child);
    }
    return top;
}

static void add_leaf(walk *w, uint32_t child)
{
    const daft_block *block = &w->seen->instance->bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    for (uint32_t count = (child & 3) + 1; count; count--) {
        w->blocks[w->block_count++] = block++;
        if (w->block_count == DAFT_BATCH_BLOCKS) draw_blocks(w);
    }
}

static void draw_singly(walk *w)
{
    visit stack[DAFT_STACK];
    const daft_node *nodes = w->seen->instance->bvh->nodes.items;
    int top = push_children(w, &nodes[0], stack, 0);
    while (top) {
        visit v = stack[--top];
        if (hidden(w->job, v.pixels, v.nearest)) continue;
        if (v.child & DAFT_CHILD_LEAF)
            add_leaf(w, v.child);
        else
            top = push_children(w, &nodes[v.child], stack, top);
    }
    draw_blocks(w);
}

/* ---- in groups ---- */

DAFT_INLINE void add_children(const walk *w, const daft_node *node, fresh *out)
{
    boxes b = children(w, node);
    uint32_t at = out->count;
    v8_compress((float *)(void *)&out->child[at], b.some, (v8)v8i_load(node->child));
    v8_compress((float *)(void *)&out->pixels[at], b.some, (v8)b.pixels);
    v8_compress(&out->nearest[at], b.some, b.nearest);
    out->count = at + (uint32_t)__builtin_popcount(b.some);
}

/* Leaves go to their own list, the nearest first, nodes on top of the `top` that wait, the nearest last: roughly, by the
 * leading bits of their w, a positive float being in the order of its bits. Gives how many leaves. */
static uint32_t sort_out(const walk *w, const fresh *f, visit *waiting, uint32_t *top, visit *leaves)
{
    uint8_t order[FRESH];
    uint32_t from[2 * ORDERS] = {0}, least = UINT32_MAX, most = 0, leaf_count = 0;
    const uint32_t *bits = (const uint32_t *)(const void *)f->nearest;
    for (uint32_t i = 0; i < f->count; i++) least = daft_min_u(least, bits[i]), most = daft_max_u(most, bits[i]);
    uint32_t range = most - least, shift = range < ORDERS ? 0 : 28 - (uint32_t)__builtin_clz(range);
    for (uint32_t i = 0; i < f->count; i++) {
        order[i] = (uint8_t)((bits[i] - least) >> shift | (f->child[i] & DAFT_CHILD_LEAF) >> 27);
        from[order[i]]++;
    }
    for (uint32_t i = 0; i < ORDERS; i++) {
        uint32_t nodes = from[i], group = from[2 * ORDERS - 1 - i];
        from[i] = *top, *top += nodes;
        from[2 * ORDERS - 1 - i] = leaf_count, leaf_count += group;
    }
    for (uint32_t i = 0; i < f->count; i++) {
        visit *to = order[i] < ORDERS ? waiting : leaves;
        to[from[order[i]]++] = (visit){f->child[i], f->nearest[i], f->pixels[i]};
        prefetch(w->seen->instance->bvh, f->child[i]);
    }
    return leaf_count;
}

static void draw_leaves(walk *w, const visit *leaves, uint32_t count)
{
    const daft_block *blocks = w->seen->instance->bvh->blocks;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t child = leaves[i].child, some = hidden(w->job, leaves[i].pixels, leaves[i].nearest) ? 0 : (child & 3) + 1;
        const daft_block *first = &blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
        for (uint32_t k = 0; k < DAFT_MAX_LEAF_BLOCKS; k++) w->blocks[w->block_count + k] = first + k;
        w->block_count += some;
        if (w->block_count >= DAFT_WALK_BLOCKS) gather_blocks(w);
    }
}

static void draw_grouped(walk *w)
{
    visit waiting[WAITING], leaves[FRESH];
    fresh f;
    const daft_node *nodes = w->seen->instance->bvh->nodes.items;
    uint32_t top = 0, group[GROUP] = {0}, count = 1;
    for (;;) {
        f.count = 0;
        for (uint32_t i = 0; i < count; i++) add_children(w, &nodes[group[i]], &f);
        w->job->counters->nodes += count;
        uint32_t leaf_count = sort_out(w, &f, waiting, &top, leaves);
        draw_leaves(w, leaves, leaf_count);
        if (!top) break;
        count = 0;
        for (uint32_t some = top > CROWDED ? 1 : daft_min_u(top, GROUP); some; some--) {
            top--;
            group[count] = waiting[top].child;
            count += !hidden(w->job, waiting[top].pixels, waiting[top].nearest);
        }
    }
    gather_blocks(w);
}

void DAFT_KERNEL(daft_mesh_draw)(daft_tile_job *job, const daft_seen *seen, daft_waiting *waiting)
{
    walk w;
    walk_begin(&w, job, seen, waiting);
    if (seen->dense)
        draw_grouped(&w);
    else
        draw_singly(&w);
}

bool DAFT_KERNEL(daft_pixels_hidden)(daft_tile_job *job, int x0, int x1, int y0, int y1, float nearest)
{
    return hidden(job, (uint32_t)(x0 | x1 << 8 | y0 << 16) | (uint32_t)y1 << 24, nearest);
}
