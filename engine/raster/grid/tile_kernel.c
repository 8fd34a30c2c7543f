/* Visibility of one tile: draws the tile's instances front to back. The farthest nearest-hit depth of each 4 × 4 pixels
 * (a hierarchical z-buffer of one level) culls whole instances and nodes behind it. */
#include "raster/grid/grid.h"

static void draw_instance(daft_tile_job *j, const daft_view_instance *view, daft_queue *queue)
{
    const daft_tile *t = j->tile;
    const int scale = j->scale;
    int x0 = daft_max_i(view->x0 * scale - t->x, 0), x1 = daft_min_i((view->x1 + 1) * scale - 1 - t->x, t->width - 1);
    int y0 = daft_max_i(view->y0 * scale - t->y, 0), y1 = daft_min_i((view->y1 + 1) * scale - 1 - t->y, t->height - 1);
    if (x0 > x1 || y0 > y1) return;
    float nearest = view->near_z > 0 ? 1 / view->near_z * (1 + 0x1p-20f) : INFINITY;
    if (DAFT_KERNEL(daft_pixels_hidden)(j, x0, x1, y0, y1, nearest)) return;
    if (view->mesh) {
        DAFT_KERNEL(daft_mesh_draw)(j, view, queue);
        return;
    }
    DAFT_KERNEL(daft_sphere_draw)(j, view, x0, x1, y0, y1);
    j->counters->spheres++;
}

enum { DIGIT_BITS = 8, DIGITS = 32 / DIGIT_BITS, DIGIT_VALUES = 1 << DIGIT_BITS, FEW = 32 };

static void sort_few(uint64_t *keys, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        uint64_t key = keys[i];
        uint32_t at = i;
        for (; at && keys[at - 1] > key; at--) keys[at] = keys[at - 1];
        keys[at] = key;
    }
}

/* Sorts by the upper 32 bits, rising, from the lowest digit on; the order of equals does not matter. `keys` has room
 * for as many again. */
static void sort_keys(uint64_t *keys, uint32_t count)
{
    if (count <= FEW) {
        sort_few(keys, count);
        return;
    }
    uint32_t place[DIGITS][DIGIT_VALUES] = {{0}};
    for (uint32_t i = 0; i < count; i++)
        for (int d = 0; d < DIGITS; d++) place[d][keys[i] >> (32 + DIGIT_BITS * d) & (DIGIT_VALUES - 1)]++;
    uint64_t *from = keys, *to = keys + count;
    for (int d = 0; d < DIGITS; d++) {
        uint32_t sum = 0;
        for (int v = 0; v < DIGIT_VALUES; v++) {
            uint32_t some = place[d][v];
            place[d][v] = sum, sum += some;
        }
        for (uint32_t i = 0; i < count; i++)
            to[place[d][from[i] >> (32 + DIGIT_BITS * d) & (DIGIT_VALUES - 1)]++] = from[i];
        uint64_t *swap = from;
        from = to, to = swap;
    }
}

/* The tile's instances by distance, then by number, into own->order. */
static uint32_t front_to_back(const daft_raster *raster, uint32_t tile, daft_bins *own)
{
    uint64_t *keys = own->order;
    uint32_t count = 0;
    if (own->ordered_tile == tile) return own->ordered;
    for (int worker = 0; worker < raster->workers; worker++) {
        const daft_bins *bins = &raster->bins[worker];
        const daft_bin_list *list = &bins->tiles[tile];
        for (uint32_t i = 0, block = list->first; i < list->count; i++) {
            keys[count++] = bins->blocks[block].items[i % DAFT_BIN_ITEMS];
            if (i % DAFT_BIN_ITEMS == DAFT_BIN_ITEMS - 1) block = bins->blocks[block].next;
        }
    }
    sort_keys(keys, count);
    own->ordered_tile = tile, own->ordered = count;
    return count;
}

static void clear_cells(daft_tile_job *j, bool stale)
{
    for (int y = 0; y < DAFT_CELLS_X; y++)
        for (int x = 0; x < DAFT_CELLS_X; x++) j->farthest[y][x] = -INFINITY;
    memset(j->stale, stale ? 0xff : 0, sizeof j->stale);
}

/* Bit x of those of a row's eight fours of pixels in which one is set. */
static uint8_t fours(uint32_t bits)
{
    bits |= bits >> 1;
    bits = (bits | bits >> 2) & 0x11111111;
    bits = (bits | bits >> 3) & 0x03030303;
    bits = (bits | bits >> 6) & 0x000f000f;
    return (uint8_t)(bits | bits >> 12);
}

static void note_windows(daft_tile_job *j, const daft_tile_part *part)
{
    uint32_t all = 0xff;
    j->sparse = false;
    if (!part) return;
    memset(j->asked, 0, sizeof j->asked);
    for (int y = 0; y < DAFT_TILE; y++) {
        uint32_t bits = 0;
        for (int row = y; row < daft_min_i(y + DAFT_WINDOW_H, DAFT_TILE); row++) bits |= part->asked[row];
        j->asked[y] = fours(bits), all &= j->asked[y];
    }
    j->sparse = all != 0xff;
}

static void clear_pixels(daft_tile_job *j, const daft_tile_part *part)
{
    daft_tile *t = j->tile;
    const uint32_t columns = t->width == DAFT_TILE ? UINT32_MAX : (1u << t->width) - 1;
    note_windows(j, part);
    const vf far = vf_set(-INFINITY), near = vf_set(INFINITY);
    clear_cells(j, part || t->width < DAFT_TILE || t->height < DAFT_TILE);
    for (int i = 0; i < DAFT_TILE_ROOM; i += DAFT_VL) {
        const int x = i % DAFT_TILE_STRIDE, y = i / DAFT_TILE_STRIDE;
        const uint32_t asked = y < t->height ? columns & (part ? part->asked[y] : UINT32_MAX) : 0;
        vf w = vf_if_then_else(vm_from_bits((vbits)(asked >> x) & DAFT_ALL_LANES), far, near);
        vf_store(&j->w_low[i], w), vf_store(&j->w_high[i], w);
        vi_store(&t->instance[i], vi_set(-1)), vi_store(&t->triangle[i], vi_set(0));
    }
}

static void job_begin(daft_tile_job *j, const daft_raster *raster, const daft_tile_part *part, daft_bins *counters,
                      daft_tile *tile)
{
    j->raster = raster, j->scale = part ? part->scale : 1, j->pencil = daft_part_pencil(&raster->pencil, part),
    j->counters = counters, j->tile = tile;
    const float turn = j->pencil.turn;
    j->spread = 1.5f * turn, j->slack = DAFT_SCREEN_SLACK + j->spread;
    daft_vec3 first = daft_pencil_ray(&j->pencil, tile->x, tile->y);
    j->left = first.x + j->spread, j->top = first.y + j->spread; /* tiles begin at multiples of four */
    j->last_x = (float)(tile->width - 1), j->last_y = (float)(tile->height - 1);
    j->max_dx = fmaxf(fabsf(j->left), fabsf(j->left + j->last_x + 3)) + j->spread;
    j->max_dy = fmaxf(fabsf(j->top), fabsf(j->top - j->last_y - 3)) + j->spread;
    if (raster->passes_holes) j->holes = daft_hole_view_of(raster, part, tile);
    j->exact = raster->pencil.intersection == DAFT_INTERSECT_EXACT;
    j->clips = raster->clip.some;
    const vf middle = vf_set(1.5f), by = vf_set(turn);
    vf_store(j->down, vf_row() - (vf_column() - middle) * by);
    for (int y = 0; y < (turn != 0 ? 4 : 1); y++) {
        const vf row = vf_convert_to((vi_set(y) + (vi_iota() >> 2)) & vi_set(3));
        for (int x = 0; x < DAFT_TILE; x += DAFT_WINDOW_W)
            vf_store(j->dx[y][x / DAFT_WINDOW_W], vf_set(j->left + (float)x) + vf_column() + (row - middle) * by);
    }
    j->rows = turn != 0 ? 3 : 0;
}

enum { AHEAD = 8 }; /* instances in a tile stand anywhere in memory */

static void draw_tile(const daft_raster *raster, uint32_t tile, uint32_t worker, const daft_tile_part *part,
                      daft_tile *out)
{
    daft_grid_scratch *scratch = (daft_grid_scratch *)raster->scratch + worker;
    daft_tile_job *j = &scratch->job;
    daft_queue *queue = &scratch->queue;
    daft_bins *bins = &raster->bins[worker];
    daft_tile_place(raster, tile, part, out);
    job_begin(j, raster, part, bins, out);
    uint32_t count = front_to_back(raster, tile, bins);
    queue->count = queue->small.count = queue->hits.count = queue->hits.doubted_count = 0;
    clear_pixels(j, part);
    for (uint32_t i = 0; i < count; i++) {
        const char *ahead = (const char *)&raster->visible[(uint32_t)bins->order[daft_min_u(i + AHEAD, count - 1)]];
        __builtin_prefetch(ahead), __builtin_prefetch(ahead + sizeof(daft_view_instance) - 1);
        draw_instance(j, &raster->visible[(uint32_t)bins->order[i]], queue);
    }
    while (queue->count) DAFT_KERNEL(daft_queue_draw)(j, queue);
}

/* The whole picture counts as one tile. */
static void find_boxes(const daft_raster *raster, uint32_t instance, daft_screen_box *out)
{
    daft_tile_job *j = &((daft_grid_scratch *)raster->scratch)->job;
    daft_tile picture = {.width = raster->pencil.width, .height = raster->pencil.height};
    const daft_bvh *bvh = raster->instances[instance].bvh;
    job_begin(j, raster, NULL, &raster->bins[0], &picture);
    for (size_t i = 0; i < bvh->block_count; i++)
        DAFT_KERNEL(daft_block_boxes)(j, &raster->visible[instance], &bvh->blocks[i], out);
}

const daft_raster_kernels DAFT_KERNEL(daft_raster) = {.scratch_size = sizeof(daft_grid_scratch),
                                                      .tile = draw_tile,
                                                      .instances = DAFT_KERNEL(daft_instances_project),
                                                      .lanes = DAFT_VL,
                                                      .boxes = find_boxes};
