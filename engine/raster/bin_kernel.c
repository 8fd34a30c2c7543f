/* Binning: a work item's clusters against the frustum and the pixel grid, then its triangles, DAFT_VL at a time: moved to
 * camera space, projected, dropped when their screen box holds no pixel's ray, and put into the tiles the box meets. */
#include "math/isa.h"
#include "math/simd.h"
#include "raster/raster.h"

void DAFT_KERNEL(daft_bin)(const daft_raster *raster, uint32_t work, uint32_t worker);

/* A screen box is widened by this many pixels: over the error of two roundings of coordinates up to 2^13. */
#define SLACK 0.004f

typedef struct grid {
    float focal, centre_x, centre_y; /* pixel index = ±focal·x/z + centre */
    float last_x, last_y;
} grid;

DAFT_INLINE grid grid_of(const daft_pencil *p)
{
    return (grid){p->focal,
                  (float)p->width * 0.5f - 0.5f - p->shift_x,
                  (float)p->height * 0.5f - 0.5f + p->shift_y,
                  (float)(p->width - 1),
                  (float)(p->height - 1)};
}

static bool tile_add(const daft_raster *raster, daft_bins *bins, uint32_t tile, uint32_t record)
{
    daft_bin_list *list = &bins->tiles[tile];
    uint32_t place = list->count % DAFT_BIN_ITEMS;
    if (place == 0) {
        if (!daft_grow(raster->allocator, &bins->blocks, &bins->block_capacity, bins->block_count + 1, bins->block_count,
                       sizeof *bins->blocks))
            return false;
        uint32_t fresh = (uint32_t)bins->block_count++;
        if (list->count)
            bins->blocks[list->last].next = fresh;
        else
            list->first = fresh;
        list->last = fresh;
    }
    bins->blocks[list->last].items[place] = record;
    list->count++;
    return true;
}

static void record_add(const daft_raster *raster, daft_bins *bins, const daft_record *record)
{
    if (bins->out_of_memory ||
        !daft_grow(raster->allocator, &bins->records, &bins->record_capacity, bins->record_count + 1, bins->record_count,
                   sizeof *bins->records)) {
        bins->out_of_memory = true;
        return;
    }
    uint32_t index = (uint32_t)bins->record_count++;
    bins->records[index] = *record;
    for (int y = record->y0 / DAFT_TILE; y <= record->y1 / DAFT_TILE; y++)
        for (int x = record->x0 / DAFT_TILE; x <= record->x1 / DAFT_TILE; x++)
            if (!tile_add(raster, bins, (uint32_t)(y * raster->tiles_x + x), index)) bins->out_of_memory = true;
}

/* ---- clusters ---- */

typedef struct box {
    float low[3], high[3];
} box;

/* A box of object space in camera space, widened by more than the rounding of the vertices in it. */
DAFT_INLINE box moved_box(const daft_affine *map, daft_vec3 low, daft_vec3 high)
{
    box out;
    const float c[3] = {low.x * 0.5f + high.x * 0.5f, low.y * 0.5f + high.y * 0.5f, low.z * 0.5f + high.z * 0.5f};
    const float h[3] = {high.x * 0.5f - low.x * 0.5f, high.y * 0.5f - low.y * 0.5f, high.z * 0.5f - low.z * 0.5f};
    for (int k = 0; k < 3; k++) {
        const float *m = &map->m[3 * k];
        float centre = m[0] * c[0] + m[1] * c[1] + m[2] * c[2] + map->t[k];
        float half = fabsf(m[0]) * h[0] + fabsf(m[1]) * h[1] + fabsf(m[2]) * h[2];
        float size = fabsf(m[0] * c[0]) + fabsf(m[1] * c[1]) + fabsf(m[2] * c[2]) + fabsf(map->t[k]) + half;
        half += size * 0x1p-20f;
        out.low[k] = centre - half;
        out.high[k] = centre + half;
    }
    return out;
}

DAFT_INLINE bool range_empty(float low, float high, float near, float far, float focal, float centre, float last)
{
    float a = focal * (low < 0 ? low / near : low / far) + centre - SLACK;
    float b = focal * (high < 0 ? high / far : high / near) + centre + SLACK;
    if (b < 0 || a > last) return true;
    return b - a < 1 && floorf(b) < a; /* between two pixels' rays */
}

static bool cluster_seen(const grid *g, const daft_seen *seen, const daft_cluster *cluster)
{
    box b = moved_box(&seen->to_camera, cluster->low, cluster->high);
    float near = b.low[2], far = b.high[2];
    if (!(far > 0)) return far != far; /* behind; NaN from an overflow: let the triangles decide */
    if (near > 0)
        return !range_empty(b.low[0], b.high[0], near, far, g->focal, g->centre_x, g->last_x) &&
               !range_empty(-b.high[1], -b.low[1], near, far, g->focal, g->centre_y, g->last_y);
    float half_x = g->last_x * 0.5f + 2, half_y = g->last_y * 0.5f + 2;
    return !(b.low[0] * g->focal > far * half_x || -b.high[0] * g->focal > far * half_x ||
             b.low[1] * g->focal > far * half_y || -b.high[1] * g->focal > far * half_y);
}

/* ---- triangles ---- */

/* One axis of one corner of DAFT_VL / 4 blocks, side by side; the last block is repeated where there are fewer. */
DAFT_INLINE vf blocks_load(const daft_block *b, uint32_t count, int corner, int axis)
{
    union {
        v4 part[DAFT_VL / 4];
        vf whole;
    } lanes;
    for (uint32_t i = 0; i < DAFT_VL / 4; i++) lanes.part[i] = v4_load(b[i < count ? i : count - 1].corner[corner][axis]);
    return lanes.whole;
}

DAFT_INLINE vbits blocks_used(const daft_block *b, uint32_t count)
{
    vbits used = 0;
    for (uint32_t i = 0; i < DAFT_VL / 4 && i < count; i++)
        for (int k = 0; k < DAFT_BLOCK; k++) used |= (vbits)(b[i].triangle[k] != DAFT_NO_TRIANGLE) << (i * DAFT_BLOCK + (uint32_t)k);
    return used;
}

/* The same operations in the same order as daft_affine_point. */
DAFT_INLINE vf3 move(const daft_affine *a, vf3 p)
{
    const float *m = a->m, *t = a->t;
    return (vf3){((vf_set(m[0]) * p.x + vf_set(m[1]) * p.y) + vf_set(m[2]) * p.z) + vf_set(t[0]),
                 ((vf_set(m[3]) * p.x + vf_set(m[4]) * p.y) + vf_set(m[5]) * p.z) + vf_set(t[1]),
                 ((vf_set(m[6]) * p.x + vf_set(m[7]) * p.y) + vf_set(m[8]) * p.z) + vf_set(t[2])};
}

typedef struct span {
    vf first, last; /* whole numbers within the picture */
    vm some;
} span;

/* The pixel indices within low..high, clamped to 0..last. */
DAFT_INLINE span pixel_span(vf low, vf high, vf last)
{
    vf zero = vf_set(0), one = vf_set(1);
    vf a = vf_max(low - vf_set(SLACK), zero), b = vf_min(high + vf_set(SLACK), last);
    vf floor_a = vf_from_int(vi_truncate(a)); /* a >= 0; NaN was turned to 0 by vf_max */
    vf first = floor_a + vf_select(vf_lt(floor_a, a), one, zero);
    vf end = vf_from_int(vi_truncate(b));
    return (span){first, end, vm_and(vf_le(zero, b), vf_le(first, end))};
}

typedef struct lanes {
    vf3 corner[3];
    span x, y;
    vbits keep;
} lanes;

DAFT_INLINE void project(const grid *g, lanes *l)
{
    vf zero = vf_set(0), focal = vf_set(g->focal), far = vf_set(INFINITY);
    vf x0 = far, x1 = -far, y0 = far, y1 = -far;
    vm front = vf_lt(zero, l->corner[0].z), back = vf_le(l->corner[0].z, zero);
    for (int k = 0; k < 3; k++) {
        vf3 c = l->corner[k];
        vf scale = focal / c.z, x = c.x * scale + vf_set(g->centre_x), y = vf_set(g->centre_y) - c.y * scale;
        x0 = vf_min(x, x0), x1 = vf_max(x, x1), y0 = vf_min(y, y0), y1 = vf_max(y, y1);
        front = vm_and(front, vf_lt(zero, c.z));
        back = vm_and(back, vf_le(c.z, zero));
    }
    /* A triangle through the camera's plane may reach anywhere. */
    x0 = vf_select(front, x0, zero), x1 = vf_select(front, x1, vf_set(g->last_x));
    y0 = vf_select(front, y0, zero), y1 = vf_select(front, y1, vf_set(g->last_y));
    l->x = pixel_span(x0, x1, vf_set(g->last_x));
    l->y = pixel_span(y0, y1, vf_set(g->last_y));
    l->keep = vm_bits(vm_and(vm_and(l->x.some, l->y.some), vm_not(back)));
}

static void keep_lanes(const daft_raster *raster, daft_bins *bins, const lanes *l, vbits keep, const daft_block *block,
                       uint32_t instance)
{
    float corner[9][DAFT_VL], range[4][DAFT_VL];
    for (int k = 0; k < 3; k++) {
        vf_store(corner[3 * k], l->corner[k].x);
        vf_store(corner[3 * k + 1], l->corner[k].y);
        vf_store(corner[3 * k + 2], l->corner[k].z);
    }
    vf_store(range[0], l->x.first), vf_store(range[1], l->x.last);
    vf_store(range[2], l->y.first), vf_store(range[3], l->y.last);
    while (keep) {
        int i = __builtin_ctz(keep);
        keep &= keep - 1;
        daft_record record = {.instance = instance, .triangle = block[i / DAFT_BLOCK].triangle[i % DAFT_BLOCK]};
        for (int k = 0; k < 9; k++) record.corner[k] = corner[k][i];
        record.x0 = (int16_t)range[0][i], record.x1 = (int16_t)range[1][i];
        record.y0 = (int16_t)range[2][i], record.y1 = (int16_t)range[3][i];
        record_add(raster, bins, &record);
        bins->binned++;
    }
}

static void bin_blocks(const daft_raster *raster, daft_bins *bins, const grid *g, const daft_seen *seen,
                       const daft_block *block, uint32_t count)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL / 4) {
        lanes l;
        uint32_t left = count - i;
        for (int k = 0; k < 3; k++) {
            vf3 p = {blocks_load(block + i, left, k, 0), blocks_load(block + i, left, k, 1),
                     blocks_load(block + i, left, k, 2)};
            l.corner[k] = move(&seen->to_camera, p);
        }
        vbits used = blocks_used(block + i, left);
        project(g, &l);
        bins->tested += (uint64_t)__builtin_popcount(used);
        vbits keep = l.keep & used;
        if (keep) keep_lanes(raster, bins, &l, keep, block + i, seen->index);
    }
}

static void bin_sphere(const daft_raster *raster, daft_bins *bins, const daft_seen *seen)
{
    daft_record record = {.instance = seen->index, .triangle = DAFT_SPHERE};
    for (int k = 0; k < 3; k++) record.corner[k] = seen->to_camera.t[k];
    record.corner[3] = seen->instance->radius;
    record.x0 = (int16_t)seen->x0, record.x1 = (int16_t)seen->x1;
    record.y0 = (int16_t)seen->y0, record.y1 = (int16_t)seen->y1;
    record_add(raster, bins, &record);
    bins->spheres++;
}

void DAFT_KERNEL(daft_bin)(const daft_raster *raster, uint32_t work, uint32_t worker)
{
    daft_work item = raster->work[work];
    const daft_seen *seen = &raster->seen[item.seen];
    daft_bins *bins = &raster->bins[worker];
    if (!seen->instance->mesh) {
        bin_sphere(raster, bins, seen);
        return;
    }
    grid g = grid_of(&raster->pencil);
    const daft_bvh *bvh = seen->instance->bvh;
    for (uint32_t i = item.first; i < item.first + item.count; i++) {
        const daft_cluster *cluster = &bvh->clusters[i];
        if (cluster_seen(&g, seen, cluster))
            bin_blocks(raster, bins, &g, seen, bvh->blocks + cluster->first_block, cluster->block_count);
    }
}
