/* raster: the pencil. Which thing does each of a camera's rays hit first?
 * Promises: every pixel is decided by a ray test with the exact predicates of math/exact.h, floats where their error bound
 * allows; the answer is the nearest hit by daft_pencil_depth, ties to the lower (instance, triangle), and so the same as
 * the reference path's (daft_reference_tile), whatever the instruction set, threads or order of work.
 *
 * Camera space: x right, y up, z forward. The ray of pixel (x, y) is d = (x + 0.5 - width/2 + shift_x,
 * height/2 - y - 0.5 + shift_y, focal): halves and thirty-seconds, exact in floats.
 *
 * Passes: daft_raster_begin; daft_raster_bin (once for each work item, in parallel) puts the instances that may be seen into
 * tiles by their projected bounds; a kernel's `tile` (once for each tile, in parallel) walks the trees of its instances front
 * to back, by the screen boxes of their nodes: what lies beside the tile, between the rays of its pixels or behind what
 * they see already is left out by whole subtrees. What is left is set up some triangles at a time, and rays decide. */
#ifndef DAFT_RASTER_H
#define DAFT_RASTER_H

#include "accel/bvh.h"
#include "base/base.h"

enum {
    DAFT_TILE = 32, /* pixels a side */
    DAFT_TILE_STRIDE = DAFT_TILE,
    DAFT_TILE_ROWS = DAFT_TILE + 8, /* room for eight rows from the last one on */
    DAFT_TILE_ROOM = DAFT_TILE_ROWS * DAFT_TILE_STRIDE
};

#define DAFT_NOTHING UINT32_MAX /* instance of a pixel that sees the sky */

typedef struct daft_pencil {
    daft_vec3 right, up, forward; /* camera axes in frame space */
    float focal;
    int width, height;
    daft_intersection intersection;
    float shift_x, shift_y; /* of the sample, in pixels, multiples of 1/32 within -0.5..0.5 */
} daft_pencil;

/* An instance as the camera sees it. */
typedef struct daft_seen {
    const daft_instance *instance; /* NULL: none of it can be seen */
    const daft_trimesh *mesh;      /* the instance's, at hand: instances in a tile stand anywhere in memory */
    const daft_bvh *bvh;
    uint32_t index; /* in the snapshot */
    daft_affine to_camera;
    float near_z;       /* of its bounds in camera space */
    int x0, x1, y0, y1; /* pixels its bounds may cover, inclusive */
    bool dense;         /* a mesh with a triangle or more to six pixels of them; to four around the camera, where most is elsewhere */
} daft_seen;

/* Instances in a tile, in the order in which they sort: the bits of near_z << 32 | number. */
enum { DAFT_BIN_ITEMS = 15 };
typedef struct daft_bin_block {
    uint32_t next;
    uint64_t items[DAFT_BIN_ITEMS];
} daft_bin_block;

typedef struct daft_bin_list {
    uint32_t first, last, count;
} daft_bin_list;

/* What one worker found: no locks, since each worker fills its own and a tile reads them all. */
typedef struct daft_bins {
    daft_bin_block *blocks;
    size_t block_count, block_capacity;
    daft_bin_list *tiles; /* one for each tile */
    size_t tile_capacity;
    uint64_t *order; /* a tile's instances, front to back; and room to sort them */
    size_t order_capacity;
    /* Instances in the picture; nodes and triangles whose boxes were tested (a triangle once for each tile); triangles set
     * up; spheres in tiles; decisions that floats could not make. */
    uint64_t seen, nodes, tested, binned, spheres, exact_edges, exact_depths;
    bool out_of_memory;
} daft_bins;

/* Visibility of one tile. Row r starts at r·DAFT_TILE_STRIDE. */
typedef struct daft_tile {
    int x, y, width, height; /* in the picture */
    _Alignas(64) uint32_t instance[DAFT_TILE_ROOM];
    _Alignas(64) uint32_t triangle[DAFT_TILE_ROOM];
} daft_tile;

typedef struct daft_raster {
    const daft_allocator *allocator;
    daft_pencil pencil;
    const daft_instance *instances;
    uint32_t instance_count;
    int tiles_x, tiles_y, workers;
    daft_seen *seen; /* one for each instance, filled by daft_raster_bin */
    size_t seen_capacity;
    uint32_t work_count;
    daft_bins *bins; /* one for each worker */
    const struct daft_raster_kernels *kernels; /* for daft_raster_bin */
} daft_raster;

bool daft_raster_init(daft_raster *raster, const daft_allocator *allocator, int workers, int isa, daft_error *error);
void daft_raster_free(daft_raster *raster);
bool daft_raster_begin(daft_raster *raster, const daft_pencil *pencil, const daft_instance *instances, uint32_t count,
                       daft_error *error);

void daft_raster_bin(daft_raster *raster, uint32_t work, uint32_t worker);

/* Pixels that a triangle's projected bounds may cover, inclusive; x0 > x1: none. */
typedef struct daft_screen_box {
    int16_t x0, x1, y0, y1;
} daft_screen_box;

typedef struct daft_raster_kernels {
    void (*tile)(const daft_raster *raster, uint32_t tile, uint32_t worker, daft_tile *out);
    /* Fills raster->seen for `lanes` instances from one on, all of meshes with triangles, as daft_raster_bin does one by one. */
    void (*seen)(const daft_raster *raster, uint32_t first);
    uint32_t lanes;
    /* The candidate boxes of a mesh's triangles, by their numbers, within the picture. */
    void (*boxes)(const daft_raster *raster, uint32_t instance, daft_screen_box *out);
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
/* Where the pixel is, not a whole number, that looks straight ahead: column and row. */
static inline double daft_pencil_middle_x(const daft_pencil *p) { return (double)p->width * 0.5 - 0.5 - (double)p->shift_x; }
static inline double daft_pencil_middle_y(const daft_pencil *p) { return (double)p->height * 0.5 - 0.5 + (double)p->shift_y; }
/* Of a mesh whose pixels and near_z are known. */
static inline bool daft_seen_dense(const daft_seen *seen)
{
    int64_t triangles = seen->mesh->triangle_count, pixels = (int64_t)(seen->x1 - seen->x0 + 1) * (seen->y1 - seen->y0 + 1);
    return (seen->near_z > 0 ? 6 : 4) * triangles >= pixels;
}
/* Sets the tile's place and size. */
void daft_tile_place(const daft_raster *raster, uint32_t tile, daft_tile *out);

#endif
