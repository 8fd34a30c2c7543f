/* Instances into tiles by their projected bounds. */
#include "raster/raster.h"

#include <string.h>

enum { INSTANCES_A_WORK_ITEM = 128 };

static bool tile_add(const daft_raster *raster, daft_bins *bins, uint32_t tile, uint64_t item)
{
    daft_bin_list *list = &bins->tiles[tile];
    uint32_t place = list->count % DAFT_BIN_ITEMS;
    if (place == 0) {
        if (!daft_grow(raster->allocator, &bins->blocks, &bins->block_capacity, bins->block_count + 1,
                       bins->block_count, sizeof *bins->blocks))
            return false;
        uint32_t fresh = (uint32_t)bins->block_count++;
        if (list->count)
            bins->blocks[list->last].next = fresh;
        else
            list->first = fresh;
        list->last = fresh;
    }
    bins->blocks[list->last].items[place] = item;
    list->count++;
    return true;
}

static void add_to_tiles(const daft_raster *raster, daft_bins *bins, const daft_view_instance *view)
{
    uint32_t bits; /* of a positive float: they are in its order */
    float z = view->near_z > 0 ? view->near_z : 0;
    memcpy(&bits, &z, sizeof bits);
    for (int y = view->y0 / DAFT_TILE; y <= view->y1 / DAFT_TILE; y++)
        for (int x = view->x0 / DAFT_TILE; x <= view->x1 / DAFT_TILE; x++)
            if (!bins->out_of_memory &&
                !tile_add(raster, bins, (uint32_t)(y * raster->tiles_x + x), (uint64_t)bits << 32 | view->index))
                bins->out_of_memory = true;
}

static bool is_mesh(const daft_instance *instance) { return instance->mesh && instance->mesh->triangle_count; }

/* Fills raster->visible from one on, no further than `end`: of one instance, or of as many meshes as the kernel takes
 * at once. Gives how many. */
static uint32_t see(daft_raster *raster, uint32_t first, uint32_t end)
{
    uint32_t lanes = raster->kernels->lanes, meshes = 0;
    const daft_instance *instances = &raster->instances[first];
    for (; meshes < lanes && first + meshes < end && is_mesh(&instances[meshes]); meshes++) {
        const char *ahead = (const char *)&instances[daft_min_u(meshes + lanes, end - first - 1)];
        for (size_t line = 0; line < sizeof *instances; line += 64) __builtin_prefetch(ahead + line);
    }
    if (meshes == lanes) {
        raster->kernels->instances(raster, first);
        return lanes;
    }
    daft_view_instance *view = &raster->visible[first];
    if (!daft_view_instance_make(&raster->pencil, &raster->instances[first], first, view)) view->instance = NULL;
    return 1;
}

void daft_raster_bin(daft_raster *raster, uint32_t work, uint32_t worker)
{
    daft_bins *bins = &raster->bins[worker];
    uint32_t first = work * INSTANCES_A_WORK_ITEM,
             end = daft_min_u(raster->instance_count, first + INSTANCES_A_WORK_ITEM);
    for (uint32_t i = first; i < end;) {
        for (uint32_t next = i + see(raster, i, end); i < next; i++) {
            if (!raster->visible[i].instance) continue;
            bins->visible++;
            add_to_tiles(raster, bins, &raster->visible[i]);
        }
    }
}

static bool clear_bins(daft_raster *raster)
{
    size_t tiles = (size_t)raster->tiles_x * (size_t)raster->tiles_y;
    for (int i = 0; i < raster->workers; i++) {
        daft_bins *bins = &raster->bins[i];
        if (!daft_grow(raster->allocator, &bins->tiles, &bins->tile_capacity, tiles, 0, sizeof *bins->tiles) ||
            !daft_grow(raster->allocator, &bins->order, &bins->order_capacity, 2 * (size_t)raster->instance_count, 0,
                       sizeof *bins->order))
            return false;
        memset(bins->tiles, 0, tiles * sizeof *bins->tiles);
        bins->block_count = 0, bins->ordered_tile = UINT32_MAX;
        bins->visible = bins->nodes = bins->tested = bins->binned = bins->spheres = bins->exact_edges =
            bins->exact_depths = 0;
        bins->out_of_memory = false;
    }
    return true;
}

bool daft_raster_begin(daft_raster *raster, const daft_pencil *pencil, const daft_instance *instances, uint32_t count,
                       daft_error *error)
{
    raster->pencil = *pencil;
    raster->clip = (daft_clip){0};
    raster->passes_holes = false, raster->textures = NULL;
    raster->instances = instances;
    raster->instance_count = count;
    raster->tiles_x = (pencil->width + DAFT_TILE - 1) / DAFT_TILE;
    raster->tiles_y = (pencil->height + DAFT_TILE - 1) / DAFT_TILE;
    raster->work_count = (count + INSTANCES_A_WORK_ITEM - 1) / INSTANCES_A_WORK_ITEM;
    if (daft_grow(raster->allocator, &raster->visible, &raster->visible_capacity, count, 0, sizeof *raster->visible) &&
        clear_bins(raster))
        return true;
    return daft_fail_memory(error, "the list of visible instances");
}

void daft_tile_place(const daft_raster *raster, uint32_t tile, daft_tile *out)
{
    out->x = (int)(tile % (uint32_t)raster->tiles_x) * DAFT_TILE;
    out->y = (int)(tile / (uint32_t)raster->tiles_x) * DAFT_TILE;
    out->width = daft_min_i(DAFT_TILE, raster->pencil.width - out->x);
    out->height = daft_min_i(DAFT_TILE, raster->pencil.height - out->y);
}
