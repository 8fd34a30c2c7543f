/* Visibility of one tile: draws the tile's instances front to back. The farthest nearest-hit depth of each 4 × 4 pixels
 * (a hierarchical z-buffer of one level) culls whole instances and nodes behind it. */
#include "raster/grid/grid.h"

static void draw_instance(daft_tile_job *j, const daft_view_instance *view, daft_queue *queue)
{
    const int scale = j->scale;
    int x0 = daft_max_i(view->x0 * scale - j->x, 0), x1 = daft_min_i((view->x1 + 1) * scale - 1 - j->x, j->width - 1);
    int y0 = daft_max_i(view->y0 * scale - j->y, 0), y1 = daft_min_i((view->y1 + 1) * scale - 1 - j->y, j->height - 1);
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

/* pixels: NULL for all. */
static void note_windows(daft_tile_job *j, const uint32_t pixels[DAFT_TILE])
{
    uint32_t all = 0xff;
    j->sparse = false;
    if (!pixels) return;
    memset(j->asked, 0, sizeof j->asked);
    for (int y = 0; y < DAFT_TILE; y++) {
        uint32_t bits = 0;
        for (int row = y; row < daft_min_i(y + DAFT_WINDOW_H, DAFT_TILE); row++) bits |= pixels[row];
        j->asked[y] = fours(bits), all &= j->asked[y];
    }
    j->sparse = all != 0xff;
}

/* pixels: NULL for all of a tile `width` wide and `height` high. */
static void clear_pixels(daft_tile_job *j, const uint32_t pixels[DAFT_TILE], int width, int height)
{
    const uint32_t columns = width == DAFT_TILE ? UINT32_MAX : (1u << width) - 1;
    const vf far = vf_set(-INFINITY), near = vf_set(INFINITY);
    note_windows(j, pixels);
    clear_cells(j, pixels || width < DAFT_TILE || height < DAFT_TILE);
    for (int i = 0; i < DAFT_TILE_ROOM; i += DAFT_VL) {
        const int x = i % DAFT_TILE_STRIDE, y = i / DAFT_TILE_STRIDE;
        const uint32_t asked = y < height ? columns & (pixels ? pixels[y] : UINT32_MAX) : 0;
        vf_store(&j->w_low[i], vf_if_then_else(vm_from_bits((vbits)(asked >> x) & DAFT_ALL_LANES), far, near));
    }
}

static void clear_tile(daft_tile_job *j, const daft_tile_part *part)
{
    daft_tile *t = j->tile;
    clear_pixels(j, part ? part->asked : NULL, t->width, t->height);
    memcpy(j->w_high, j->w_low, sizeof j->w_high);
    for (int i = 0; i < DAFT_TILE_ROOM; i += DAFT_VL)
        vi_store(&t->instance[i], vi_set(-1)), vi_store(&t->triangle[i], vi_set(0));
}

static void clear_fine(daft_tile_job *j)
{
    clear_pixels(j, j->fine->pixels, (j->width + DAFT_FINE - 1) / DAFT_FINE, (j->height + DAFT_FINE - 1) / DAFT_FINE);
    DAFT_KERNEL(daft_fine_begin)(j);
}

/* After the job's place, size, scale and pencil. */
static void job_begin(daft_tile_job *j, const daft_raster *raster, daft_bins *counters)
{
    j->raster = raster, j->counters = counters;
    const float turn = j->pencil.turn;
    j->side = (float)(j->scale * DAFT_TILE), j->scale_bits = __builtin_ctz((uint32_t)j->scale);
    j->spread = 1.5f * turn, j->slack = DAFT_SCREEN_SLACK + j->spread;
    daft_vec3 first = daft_pencil_ray(&j->pencil, j->x, j->y);
    j->left = first.x + j->spread, j->top = first.y + j->spread; /* tiles begin at multiples of four */
    j->last_x = (float)(j->width - 1), j->last_y = (float)(j->height - 1);
    j->max_dx = fmaxf(fabsf(j->left), fabsf(j->left + j->last_x + 3)) + j->spread;
    j->max_dy = fmaxf(fabsf(j->top), fabsf(j->top - j->last_y - 3)) + j->spread;
    if (raster->passes_holes) j->holes = daft_hole_view_of(raster, &j->pencil, j->x, j->y, j->scale * DAFT_TILE);
    j->exact = raster->pencil.intersection == DAFT_INTERSECT_EXACT;
    j->clips = raster->clip.some;
}

static void tile_begin(daft_tile_job *j, const daft_raster *raster, const daft_tile_part *part, daft_bins *counters,
                       daft_tile *tile)
{
    j->tile = tile, j->fine = NULL;
    j->pencil = daft_part_pencil(&raster->pencil, part), j->scale = 1;
    j->x = tile->x, j->y = tile->y, j->width = tile->width, j->height = tile->height;
    job_begin(j, raster, counters);
    for (int x = 0; x < DAFT_TILE; x += DAFT_WINDOW_W)
        vf_store(j->dx[x / DAFT_WINDOW_W], vf_set(j->left + (float)x) + vf_column());
}

static void fine_begin(daft_tile_job *j, const daft_raster *raster, uint32_t tile, daft_bins *counters,
                       daft_fine_tile *fine, daft_fine_depths *depths)
{
    j->tile = NULL, j->fine = fine, j->fine_depths = depths;
    j->pencil = daft_fine_pencil(&raster->pencil), j->scale = DAFT_FINE;
    j->x = (int)(tile % (uint32_t)raster->tiles_x) * DAFT_FINE_SIDE;
    j->y = (int)(tile / (uint32_t)raster->tiles_x) * DAFT_FINE_SIDE;
    j->width = daft_min_i(DAFT_FINE_SIDE, j->pencil.width - j->x);
    j->height = daft_min_i(DAFT_FINE_SIDE, j->pencil.height - j->y);
    job_begin(j, raster, counters);
    for (int i = 0; i < DAFT_FINE_RAYS; i++) {
        const int x = i % DAFT_FINE, y = i / DAFT_FINE;
        j->across[i] = (float)x + DAFT_FINE_TURN * daft_pencil_turned(y);
        j->down[i] = (float)y - DAFT_FINE_TURN * daft_pencil_turned(x);
    }
}

enum { AHEAD = 8 }; /* instances in a tile stand anywhere in memory */

/* After the job has begun and its pixels are cleared. */
static void draw(daft_tile_job *j, uint32_t tile, daft_queue *queue)
{
    const daft_raster *raster = j->raster;
    daft_bins *bins = j->counters;
    const uint32_t count = front_to_back(raster, tile, bins);
    queue->count = queue->small.count = queue->hits.count = queue->hits.doubted_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        const char *ahead = (const char *)&raster->visible[(uint32_t)bins->order[daft_min_u(i + AHEAD, count - 1)]];
        __builtin_prefetch(ahead), __builtin_prefetch(ahead + sizeof(daft_view_instance) - 1);
        draw_instance(j, &raster->visible[(uint32_t)bins->order[i]], queue);
    }
    while (queue->count) DAFT_KERNEL(daft_queue_draw)(j, queue);
}

static void draw_tile(const daft_raster *raster, uint32_t tile, uint32_t worker, const daft_tile_part *part,
                      daft_tile *out)
{
    daft_grid_scratch *scratch = (daft_grid_scratch *)raster->scratch + worker;
    daft_tile_place(raster, tile, out);
    tile_begin(&scratch->job, raster, part, &raster->bins[worker], out);
    clear_tile(&scratch->job, part);
    draw(&scratch->job, tile, &scratch->queue);
}

static void draw_fine(const daft_raster *raster, uint32_t tile, uint32_t worker, daft_fine_tile *out)
{
    daft_grid_scratch *scratch = (daft_grid_scratch *)raster->scratch + worker;
    fine_begin(&scratch->job, raster, tile, &raster->bins[worker], out, &scratch->fine);
    clear_fine(&scratch->job);
    draw(&scratch->job, tile, &scratch->queue);
}

/* The whole picture counts as one tile. */
static void find_boxes(const daft_raster *raster, uint32_t instance, daft_screen_box *out)
{
    daft_tile_job *j = &((daft_grid_scratch *)raster->scratch)->job;
    daft_tile picture = {.width = raster->pencil.width, .height = raster->pencil.height};
    const daft_bvh *bvh = raster->instances[instance].bvh;
    tile_begin(j, raster, NULL, &raster->bins[0], &picture);
    for (size_t i = 0; i < bvh->block_count; i++)
        DAFT_KERNEL(daft_block_boxes)(j, &raster->visible[instance], &bvh->blocks[i], out);
}

const daft_raster_kernels DAFT_KERNEL(daft_raster) = {.scratch_size = sizeof(daft_grid_scratch),
                                                      .tile = draw_tile,
                                                      .fine = draw_fine,
                                                      .instances = DAFT_KERNEL(daft_instances_project),
                                                      .lanes = DAFT_VL,
                                                      .boxes = find_boxes};
