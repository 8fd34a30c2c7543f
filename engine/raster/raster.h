/* raster: the pencil. Which thing does each of a camera's rays hit first?
 * Promises: every pixel is decided by a ray test with the exact predicates of math/exact.h, floats where their error bound
 * allows; the answer is the nearest hit by daft_pencil_depth, ties to the lower (instance, triangle), and so the same as
 * the reference path's (daft_reference_tile), whatever the instruction set, threads or order of work.
 *
 * Camera space: x right, y up, z forward. The ray of pixel (x, y) is d = (x + 0.5 - width/2 + shift_x,
 * height/2 - y - 0.5 + shift_y, focal): halves and thirty-seconds, exact in floats.
 *
 * Passes: daft_raster_begin culls instances and lists clusters; daft_raster_bin (once for each work item, in parallel)
 * tests triangles' screen boxes and puts what is left into tiles; daft_raster_tile (once for each tile, in parallel) decides. */
#ifndef DAFT_RASTER_H
#define DAFT_RASTER_H

#include "accel/bvh.h"
#include "base/base.h"

enum {
    DAFT_TILE = 32,             /* pixels a side */
    DAFT_TILE_STRIDE = 32 + 16, /* a row, with room for one whole SIMD store past its end */
    DAFT_TILE_ROOM = DAFT_TILE * DAFT_TILE_STRIDE + 16
};

#define DAFT_NOTHING UINT32_MAX /* instance of a pixel that sees the sky */

typedef struct daft_pencil {
    daft_vec3 right, up, forward; /* camera axes in frame space */
    float focal;
    int width, height;
    daft_intersection intersection;
    float shift_x, shift_y; /* of the sample, in pixels, multiples of 1/32 within -0.5..0.5 */
} daft_pencil;

/* An instance that may be seen. */
typedef struct daft_seen {
    const daft_instance *instance;
    uint32_t index; /* in the snapshot */
    daft_affine to_camera;
    float near_z;           /* of its box in camera space */
    int x0, x1, y0, y1;     /* pixels its box may cover, inclusive */
} daft_seen;

typedef struct daft_work {
    uint32_t seen;
    uint32_t first, count; /* clusters; a sphere has count 0 */
} daft_work;

/* A triangle (camera-space corners) or sphere (corner[0..2] centre, corner[3] radius) that covers some pixel's ray by
 * its box. Thirteen words: kernels gather with this stride. */
typedef struct daft_record {
    float corner[9];
    uint32_t instance;
    uint32_t triangle; /* DAFT_SPHERE for a sphere */
    int16_t x0, x1, y0, y1;
} daft_record;

#define DAFT_SPHERE UINT32_MAX

enum { DAFT_BIN_ITEMS = 31 };
typedef struct daft_bin_block {
    uint32_t next;
    uint32_t items[DAFT_BIN_ITEMS];
} daft_bin_block;

typedef struct daft_bin_list {
    uint32_t first, last, count;
} daft_bin_list;

/* What one worker found: no locks, since each worker fills its own and a tile reads them all. */
typedef struct daft_bins {
    daft_record *records;
    size_t record_count, record_capacity;
    daft_bin_block *blocks;
    size_t block_count, block_capacity;
    daft_bin_list *tiles; /* one for each tile */
    size_t tile_capacity;
    uint64_t tested, binned, spheres, exact_edges, exact_depths;
    bool out_of_memory;
} daft_bins;

/* Visibility of one tile. Row r starts at r·DAFT_TILE_STRIDE. */
typedef struct daft_tile {
    int x, y, width, height; /* in the picture */
    uint32_t instance[DAFT_TILE_ROOM], triangle[DAFT_TILE_ROOM];
} daft_tile;

typedef struct daft_raster {
    const daft_allocator *allocator;
    daft_pencil pencil;
    const daft_instance *instances;
    uint32_t instance_count;
    int tiles_x, tiles_y, workers;
    daft_seen *seen;
    size_t seen_count, seen_capacity;
    uint32_t *seen_of; /* instance -> its place in seen, or DAFT_NOTHING */
    size_t seen_of_capacity;
    daft_work *work;
    size_t work_count, work_capacity;
    daft_bins *bins; /* one for each worker */
} daft_raster;

bool daft_raster_init(daft_raster *raster, const daft_allocator *allocator, int workers, daft_error *error);
void daft_raster_free(daft_raster *raster);
bool daft_raster_begin(daft_raster *raster, const daft_pencil *pencil, const daft_instance *instances, uint32_t count,
                       daft_error *error);

typedef struct daft_raster_kernels {
    void (*bin)(const daft_raster *raster, uint32_t work, uint32_t worker);
    void (*tile)(const daft_raster *raster, uint32_t tile, uint32_t worker, daft_tile *out);
} daft_raster_kernels;

const daft_raster_kernels *daft_raster_kernels_for(int isa);

/* The slow, obvious twin: every ray alone through the two trees, in scalar double, the same predicates at the leaves. */
void daft_reference_tile(const daft_raster *raster, const daft_tlas *tlas, uint32_t tile, daft_tile *out);

/* ---- shared by the two paths ---- */

static inline daft_vec3 daft_pencil_ray(const daft_pencil *p, int x, int y)
{
    return daft_v3((float)x + 0.5f - (float)p->width * 0.5f + p->shift_x,
                   (float)p->height * 0.5f - (float)y - 0.5f + p->shift_y, p->focal);
}
void daft_seen_corners(const daft_seen *seen, uint32_t triangle, daft_vec3 corner[3]);
/* The exact depth of something that the ray is known to hit. */
double daft_seen_depth(const daft_seen *seen, uint32_t triangle, daft_vec3 ray);
/* Sets the tile's place and size. */
void daft_tile_place(const daft_raster *raster, uint32_t tile, daft_tile *out);

#endif
