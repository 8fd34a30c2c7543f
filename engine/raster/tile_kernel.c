/* Resolving a tile: its instances front to back; for each the tree, by the screen boxes of eight nodes at a time. A node is
 * left out when its box lies beside the tile, between the rays of its pixels, or behind what all pixels in reach of it see
 * already (the farthest w is kept for each cell of 4 × 4 pixels). Leaves' blocks of triangles are set up and drawn
 * DAFT_VL / 4 at a time. */
#include "raster/kernels.h"

/* A subtree to be looked at. */
typedef struct visit {
    uint32_t child;
    float nearest;          /* no w in it is larger */
    uint8_t x0, x1, y0, y1; /* pixels of the tile */
} visit;

/* An instance's map to the tile: x and y come out in pixels times z. */
typedef struct walk {
    daft_tile_job *job;
    daft_waiting *waiting;
    const daft_seen *seen;
    float m[9];
    float low_t[3], high_t[3];  /* the translation, less and more a pad over the error of a moved vertex */
    int low_at[9], high_at[9]; /* which of a node's bounds makes m's product least, and most */
    const daft_block *blocks[DAFT_BATCH_BLOCKS];
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

/* Four rows of eight pixels: bits of those that do not see something nearer. */
DAFT_INLINE uint32_t open_pixels(const float *w, v8 nearest)
{
    uint32_t open = v8_le_bits(v8_load(w), nearest) | v8_le_bits(v8_load(w + DAFT_TILE_STRIDE), nearest) << 8;
    w += 2 * DAFT_TILE_STRIDE;
    return open | v8_le_bits(v8_load(w), nearest) << 16 | v8_le_bits(v8_load(w + DAFT_TILE_STRIDE), nearest) << 24;
}

static bool cells_hidden(daft_tile_job *j, const visit *v)
{
    v8 nearest = v8_set(v->nearest);
    uint32_t columns = (2u << v->x1 / DAFT_CELL) - (1u << v->x0 / DAFT_CELL), last = v->y1 / DAFT_CELL;
    for (uint32_t y = v->y0 / DAFT_CELL; y <= last; y++) {
        uint32_t open = v8_le_bits(v8_load(j->farthest[y]), nearest) & columns;
        if (!open) continue;
        if (open & ~j->stale[y]) return false;
        for (uint32_t left = open; left; left &= left - 1) refresh_cell(j, (uint32_t)__builtin_ctz(left), y);
        j->stale[y] &= ~open;
        if (v8_le_bits(v8_load(j->farthest[y]), nearest) & open) return false;
    }
    return true;
}

/* Whether all pixels of a visit see something nearer: by the pixels themselves where they are few. */
DAFT_INLINE bool hidden(daft_tile_job *j, const visit *v)
{
    uint32_t width = (uint32_t)(v->x1 - v->x0), height = (uint32_t)(v->y1 - v->y0);
    if (width >= 8 || height >= 8) return cells_hidden(j, v);
    v8 nearest = v8_set(v->nearest);
    const float *w = &j->w_low[v->y0 * DAFT_TILE_STRIDE + v->x0];
    uint64_t open = open_pixels(w, nearest), columns = ((2u << width) - 1) * UINT64_C(0x0101010101010101);
    if (height >= 4) open |= (uint64_t)open_pixels(w + 4 * DAFT_TILE_STRIDE, nearest) << 32;
    return !(open & columns & UINT64_MAX >> (56 - 8 * height));
}

/* ---- a mesh ---- */

static void draw_waiting(daft_tile_job *job, daft_waiting *waiting)
{
    daft_pencil_batch batch;
    if (DAFT_KERNEL(daft_waiting_setup)(job, waiting, &batch)) DAFT_KERNEL(daft_batch_draw)(job, &batch);
}

static void draw_blocks(walk *w)
{
    daft_pencil_batch batch;
    if (!w->block_count) return;
    if (DAFT_KERNEL(daft_blocks_setup)(w->job, w->seen, w->blocks, w->block_count, w->waiting, &batch))
        DAFT_KERNEL(daft_batch_draw)(w->job, &batch);
    w->block_count = 0;
    if (w->waiting->count >= DAFT_VL) draw_waiting(w->job, w->waiting);
}

static void add_leaf(walk *w, uint32_t child)
{
    const daft_block *block = &w->seen->instance->bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    for (uint32_t count = (child & 3) + 1; count; count--) {
        w->blocks[w->block_count++] = block++;
        if (w->block_count == DAFT_BATCH_BLOCKS) draw_blocks(w);
    }
}

/* A node's children in the tile: pixels and the largest w. */
typedef struct boxes {
    v8i x0, x1, y0, y1;
    v8 nearest;
    uint32_t some;
} boxes;

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

/* Comparisons are written so that a NaN, from an overflow, leaves a box in. */
DAFT_INLINE boxes children(const walk *w, const daft_node *node)
{
    v8 low[3], high[3], zero = v8_set(0);
    for (int k = 0; k < 3; k++) axis(w, k, node, &low[k], &high[k]);
    v8i front = low[2] > zero;
    v8 inverse_near = 1 / low[2], inverse_far = 1 / high[2];
    boxes b;
    uint32_t x = box_span(low[0], high[0], high[2], inverse_near, inverse_far, front, w->job->last_x, &b.x0, &b.x1);
    uint32_t y = box_span(low[1], high[1], high[2], inverse_near, inverse_far, front, w->job->last_y, &b.y0, &b.y1);
    v8i empty = v8i_load(node->child) == (int32_t)DAFT_CHILD_NONE;
    b.some = x & y & ~v8_le_bits(high[2], zero) & ~v8i_bits(empty);
    b.nearest = pick(front, inverse_near * (1 + 0x1p-20f), v8_set(INFINITY));
    return b;
}

/* What a visit will read first: trees of large meshes do not stay in the nearer caches. */
DAFT_INLINE void prefetch(const daft_bvh *bvh, uint32_t child)
{
    const char *block = (const char *)&bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2], *node = (const char *)&bvh->nodes.items[child];
    const char *at = child & DAFT_CHILD_LEAF ? block : node;
    for (int i = 0; i < 256; i += 64) __builtin_prefetch(at + i);
}

/* Pushes the children that may be seen, the nearest last. */
static int push_children(walk *w, const daft_node *node, visit *stack, int top)
{
    boxes b = children(w, node);
    int first = top;
    w->job->counters->nodes++;
    for (uint32_t some = b.some; some; some &= some - 1) {
        int i = __builtin_ctz(some), at = top;
        visit v = {node->child[i], b.nearest[i], (uint8_t)b.x0[i], (uint8_t)b.x1[i], (uint8_t)b.y0[i], (uint8_t)b.y1[i]};
        for (; at > first && stack[at - 1].nearest > v.nearest; at--) stack[at] = stack[at - 1];
        stack[at] = v;
        top++;
        prefetch(w->seen->instance->bvh, v.child);
    }
    return top;
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

static void draw_mesh(daft_tile_job *job, const daft_seen *seen, daft_waiting *waiting)
{
    walk w;
    visit stack[DAFT_STACK];
    const daft_bvh *bvh = seen->instance->bvh;
    walk_begin(&w, job, seen, waiting);
    int top = push_children(&w, &bvh->nodes.items[0], stack, 0);
    while (top) {
        visit v = stack[--top];
        if (hidden(job, &v)) continue;
        if (v.child & DAFT_CHILD_LEAF)
            add_leaf(&w, v.child);
        else
            top = push_children(&w, &bvh->nodes.items[v.child], stack, top);
    }
    draw_blocks(&w);
}

/* ---- the tile ---- */

static void draw_instance(daft_tile_job *j, const daft_seen *seen, daft_waiting *waiting)
{
    const daft_tile *t = j->tile;
    int x0 = daft_max_i(seen->x0 - t->x, 0), x1 = daft_min_i(seen->x1 - t->x, t->width - 1);
    int y0 = daft_max_i(seen->y0 - t->y, 0), y1 = daft_min_i(seen->y1 - t->y, t->height - 1);
    visit all = {0, seen->near_z > 0 ? 1 / seen->near_z * (1 + 0x1p-20f) : INFINITY, (uint8_t)x0, (uint8_t)x1,
                 (uint8_t)y0, (uint8_t)y1};
    if (hidden(j, &all)) return;
    if (seen->instance->mesh) {
        draw_mesh(j, seen, waiting);
        return;
    }
    DAFT_KERNEL(daft_sphere_draw)(j, seen, x0, x1, y0, y1);
    j->counters->spheres++;
}

/* Sorts rising; the order of equals does not matter. Heapsort: no bad case, no memory. */
static void sort_keys(uint64_t *keys, uint32_t count)
{
    for (uint32_t start = count / 2, end = count; end > 1;) {
        if (start) {
            start--;
        } else {
            uint64_t last = keys[--end];
            keys[end] = keys[0], keys[0] = last;
        }
        uint32_t hole = start;
        uint64_t key = keys[hole];
        for (uint32_t child; (child = 2 * hole + 1) < end; hole = child) {
            if (child + 1 < end && keys[child] < keys[child + 1]) child++;
            if (keys[child] <= key) break;
            keys[hole] = keys[child];
        }
        keys[hole] = key;
    }
}

/* The tile's instances by distance, the bits of a positive float being in its order, then by number. */
static uint32_t front_to_back(const daft_raster *raster, uint32_t tile, uint64_t *keys)
{
    uint32_t count = 0;
    for (int worker = 0; worker < raster->workers; worker++) {
        const daft_bins *bins = &raster->bins[worker];
        const daft_bin_list *list = &bins->tiles[tile];
        for (uint32_t i = 0, block = list->first; i < list->count; i++) {
            uint32_t index = bins->blocks[block].items[i % DAFT_BIN_ITEMS], bits;
            float z = fmaxf(raster->seen[index].near_z, 0);
            memcpy(&bits, &z, sizeof bits);
            keys[count++] = (uint64_t)bits << 32 | index;
            if (i % DAFT_BIN_ITEMS == DAFT_BIN_ITEMS - 1) block = bins->blocks[block].next;
        }
    }
    sort_keys(keys, count);
    return count;
}

static void clear_pixels(daft_tile_job *j)
{
    daft_tile *t = j->tile;
    for (int i = 0; i < DAFT_TILE_ROOM; i += DAFT_VL) {
        float w = i < DAFT_TILE * DAFT_TILE_STRIDE ? -INFINITY : INFINITY;
        vf_store(&j->w_low[i], vf_set(w)), vf_store(&j->w_high[i], vf_set(w));
        vi_store(&t->instance[i], vi_set(-1)), vi_store(&t->triangle[i], vi_set(0));
    }
    for (int y = 0; y < DAFT_CELLS_X; y++)
        for (int x = 0; x < DAFT_CELLS_X; x++) j->farthest[y][x] = -INFINITY;
    memset(j->stale, 0, sizeof j->stale);
    if (t->width == DAFT_TILE && t->height == DAFT_TILE) return;
    for (int i = 0; i < DAFT_TILE * DAFT_TILE_STRIDE; i++)
        if (i % DAFT_TILE_STRIDE >= t->width || i / DAFT_TILE_STRIDE >= t->height) j->w_low[i] = j->w_high[i] = INFINITY;
    memset(j->stale, 0xff, sizeof j->stale);
}

static void job_begin(daft_tile_job *j, const daft_raster *raster, daft_bins *counters, daft_tile *tile)
{
    daft_vec3 first = daft_pencil_ray(&raster->pencil, tile->x, tile->y);
    j->raster = raster, j->counters = counters, j->tile = tile;
    j->left = first.x, j->top = first.y;
    j->last_x = (float)(tile->width - 1), j->last_y = (float)(tile->height - 1);
    j->max_dx = fmaxf(fabsf(first.x), fabsf(first.x + j->last_x + 3));
    j->max_dy = fmaxf(fabsf(first.y), fabsf(first.y - j->last_y - 3));
    j->exact = raster->pencil.intersection == DAFT_INTERSECT_EXACT;
    for (int x = 0; x < DAFT_TILE; x += DAFT_WINDOW_W) vf_store(j->dx[x / DAFT_WINDOW_W], vf_set(j->left + (float)x) + vf_column());
}

static void resolve_tile(const daft_raster *raster, uint32_t tile, uint32_t worker, daft_tile *out)
{
    daft_tile_job j;
    daft_bins *bins = &raster->bins[worker];
    daft_tile_place(raster, tile, out);
    job_begin(&j, raster, bins, out);
    clear_pixels(&j);
    uint32_t count = front_to_back(raster, tile, bins->order);
    daft_waiting waiting;
    waiting.count = 0;
    for (uint32_t i = 0; i < count; i++) draw_instance(&j, &raster->seen[(uint32_t)bins->order[i]], &waiting);
    while (waiting.count) draw_waiting(&j, &waiting);
}

/* The whole picture counts as one tile. */
static void find_boxes(const daft_raster *raster, uint32_t instance, daft_screen_box *out)
{
    daft_tile_job j;
    daft_tile picture = {.width = raster->pencil.width, .height = raster->pencil.height};
    const daft_bvh *bvh = raster->instances[instance].bvh;
    job_begin(&j, raster, &raster->bins[0], &picture);
    for (size_t i = 0; i < bvh->block_count; i++)
        DAFT_KERNEL(daft_block_boxes)(&j, &raster->seen[instance], &bvh->blocks[i], out);
}

const daft_raster_kernels DAFT_KERNEL(daft_raster) = {resolve_tile, find_boxes};
