/* raster/grid: a tile's pixels against triangles and spheres, for the nearest hit of each ray.
 *
 *     tile_kernel.c       instances of the tile, front to back, into its pixels; the kernel table
 *     instances_kernel.c  instances to screen boxes, a register of them at a time
 *     nodes_kernel.c      an instance's tree against the tile, by screen boxes of nodes, down to blocks of triangles
 *     setup_kernel.c      blocks to planes of edges and of inverse depth
 *     coverage_kernel.c   set-up triangles to pixels: large ones by windows, slivers by rows; spheres; depth intervals
 *     fine_kernel.c       the same with sixteen rays a pixel, for those that ask for them
 *     small_kernel.c      triangles of two pixels a side in dense meshes, without planes
 *     hidden.h            whether pixels see something nearer already
 *     sphere.h            rays against a sphere, for both
 *     decide_kernel.c     rays one by one, where floats do not decide
 *
 * A stage reads the job and what the stage before wrote, and writes its own batch: blocks, daft_small, daft_queue,
 * daft_pencil_batch, daft_hits. All of them lie in one daft_grid_scratch for each worker.
 *
 * Public headers: grid.h */
#ifndef DAFT_GRID_H
#define DAFT_GRID_H

#include "math/simd/dispatch.h"
#include "raster/raster.h"

DAFT_KERNEL_DECLARE(daft_raster_kernels, daft_raster);

#ifdef DAFT_ISA
#include "raster/masks.h"
#include "raster/triangles.h"

enum {
    DAFT_WINDOW_W = 4, /* pixels of a SIMD register */
    DAFT_WINDOW_H = DAFT_VL / DAFT_WINDOW_W,
    DAFT_CELL = 4, /* pixels a side of the parts of a tile for which the farthest is kept */
    DAFT_CELLS_X = DAFT_TILE / DAFT_CELL
};

/* A pixel's place is its row · DAFT_TILE_STRIDE + its column. w is the inverse depth; w_low..w_high holds that of what
 * the pixel sees. Pixels that are not asked for or lie beyond the picture count as infinitely near: nothing is offered
 * to them in vain, nor do they look far.
 *
 * Of a fine tile, screen boxes are in rays, and w_low is the least of the rays that a pixel asks for: what is hidden
 * from it is hidden from all of them. Each ray's own interval stands in daft_fine_depths. */
typedef struct daft_tile_job {
    const daft_raster *raster;
    daft_pencil pencil; /* of the rays */
    daft_bins *counters;
    daft_tile *tile; /* one of both */
    daft_fine_tile *fine;
    struct daft_fine_depths *fine_depths;
    int x, y, width, height; /* of the first ray in the pencil's picture, and rays of the tile that are within that */
    int scale, scale_bits;   /* rays of a pixel's side, and as a power of two; */
    float side;              /* of the tile's */
    float left, top;         /* the first ray, before it is turned */
    float last_x, last_y;    /* the last column and row of rays in the picture */
    float max_dx, max_dy;    /* of any ray in the tile */
    float spread, slack;     /* how far the pencil turns rays; this and DAFT_SCREEN_SLACK */
    bool exact;
    daft_hole_view holes; /* where the raster passes holes */
    bool clips;           /* the raster has a plane: */
    float clip[4];        /* its normal, and how far along it what is seen of the running instance begins */
    _Alignas(64) float dx[DAFT_TILE / DAFT_WINDOW_W][DAFT_VL];       /* of the rays of windows, by columns */
    _Alignas(64) float across[DAFT_FINE_RAYS], down[DAFT_FINE_RAYS]; /* of a fine pixel's rays, from the first one */
    /* Every pixel's w in the cell is at least this; stale, by rows of cells: some pixel has come nearer since it was
     * found. */
    _Alignas(64) float farthest[DAFT_CELLS_X][DAFT_CELLS_X];
    uint32_t stale[DAFT_CELLS_X + 1]; /* one more for windows that begin in the last row */
    bool sparse;                      /* some windows hold no pixel that is asked for: */
    uint8_t asked[2 * DAFT_TILE];     /* bit x of windows that do, 4·x columns from the left, by their first rows */
    _Alignas(64) float w_low[DAFT_TILE_ROOM];
    _Alignas(64) float w_high[DAFT_TILE_ROOM];
} daft_tile_job;

/* Of what the rays of a fine tile see; of those that are not asked for in a pixel that is, infinite. */
typedef struct daft_fine_depths {
    _Alignas(64) float low[DAFT_FINE_RAYS * DAFT_TILE * DAFT_TILE];
    _Alignas(64) float high[DAFT_FINE_RAYS * DAFT_TILE * DAFT_TILE];
} daft_fine_depths;

/* Triangles whose screen boxes hold some ray of the tile, waiting until there are enough to be set up. DAFT_LEAVES_ROOM
 * leaves may be added at a time. */
enum { DAFT_LEAVES = 64, DAFT_LEAVES_ROOM = DAFT_LEAVES + DAFT_VL };
enum { DAFT_QUEUE_ROOM = DAFT_LEAVES_ROOM * DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK + 3 * DAFT_VL };
/* Small triangles of one instance in the picture whose boxes hold rays; scale: the focal length over z. */
typedef struct daft_small {
    uint32_t count;
    const daft_view_instance *view;
    float x[3][DAFT_QUEUE_ROOM], y[3][DAFT_QUEUE_ROOM], scale[3][DAFT_QUEUE_ROOM];
    uint32_t triangle[DAFT_QUEUE_ROOM];
} daft_small;

/* Pixels whose rays such triangles meet, or, where it says so, may meet; above the place is the triangle's number among
 * those projected. Of those that may, some are named once more: what decides them is fetched before it is asked for. */
enum {
    DAFT_HITS_ROOM = 4 * DAFT_LEAVES_ROOM * DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK + DAFT_VL,
    DAFT_HIT_TRIANGLE = 16,
    DAFT_DOUBTED = 32
};
#define DAFT_HIT_UNSURE 0x8000u
typedef struct daft_hits {
    uint32_t count, doubted_count, doubted[DAFT_DOUBTED];
    uint32_t place[DAFT_HITS_ROOM];
    float low[DAFT_HITS_ROOM], high[DAFT_HITS_ROOM]; /* of w; in inexact modes, low alone counts */
} daft_hits;

typedef struct daft_queue {
    uint32_t count;
    float corner[9][DAFT_QUEUE_ROOM]; /* x, y, z of corner 0, then of 1 and 2, in camera space */
    float nearest[DAFT_QUEUE_ROOM];   /* the largest w; infinite where a corner is not in front */
    uint32_t pixels[DAFT_QUEUE_ROOM]; /* rays of the tile: x0 | x1 << 8 | y0 << 16 | y1 << 24 */
    uint32_t instance[DAFT_QUEUE_ROOM], triangle[DAFT_QUEUE_ROOM];
    daft_small small; /* these and hits are of the instances at work: they do not wait for others */
    daft_hits hits;
} daft_queue;

/* A worker's: nothing of it outlives a tile. */
typedef struct daft_grid_scratch {
    daft_tile_job job;
    daft_queue queue;
    daft_fine_depths fine;
} daft_grid_scratch;

/* Up to DAFT_VL triangles, set up. Edge k is opposite corner k. */
typedef struct daft_pencil_batch {
    vbits live;                                           /* lanes that may be hit */
    float nx[3][DAFT_VL], ny[3][DAFT_VL], nz[3][DAFT_VL]; /* over the bound of e; nz times the focal length */
    float wx[DAFT_VL], wy[DAFT_VL], wz[DAFT_VL];          /* w = wx·dx + wy·dy + wz */
    float error[DAFT_VL], w_cap[DAFT_VL];
    int32_t x0[DAFT_VL], x1[DAFT_VL], y0[DAFT_VL], y1[DAFT_VL]; /* rays of the tile */
    uint32_t instance[DAFT_VL], triangle[DAFT_VL];
} daft_pencil_batch;

/* small_kernel.c: blocks of one instance, by number. Those whose boxes are of two pixels a side at most are projected,
 * others wait. */
void DAFT_KERNEL(daft_blocks_project)(const daft_tile_job *job, const daft_view_instance *view, const uint32_t *blocks,
                                      uint32_t count, daft_queue *out);
/* No less than the R of small_kernel.c, but for twice a triangle's extent. */
DAFT_INLINE float daft_tile_reach(const daft_tile_job *job)
{
    return (job->max_dx > job->max_dy ? job->max_dx : job->max_dy) + 2 * job->side;
}
/* The pixels of those projected. */
void DAFT_KERNEL(daft_small_hits)(const daft_tile_job *job, const daft_small *from, daft_hits *out);
/* setup_kernel.c: 1 to DAFT_BATCH_BLOCKS blocks. True: many or large ones of them may be seen and make a batch. False:
 * few, and those wait. */
bool DAFT_KERNEL(daft_blocks_setup)(const daft_tile_job *job, const daft_view_instance *view, const uint32_t *blocks,
                                    uint32_t count, daft_queue *queue, daft_pencil_batch *batch);
/* A batch from the last of those waiting. False: nothing of them is to be drawn. */
bool DAFT_KERNEL(daft_queue_setup)(const daft_tile_job *job, daft_queue *from, daft_pencil_batch *batch);
/* The candidate boxes of one block's triangles, by the triangles' numbers. */
void DAFT_KERNEL(daft_block_boxes)(const daft_tile_job *job, const daft_view_instance *view, const daft_block *block,
                                   daft_screen_box *out);
/* instances_kernel.c: daft_raster_kernels.instances. */
void DAFT_KERNEL(daft_instances_project)(const daft_raster *raster, uint32_t first);
/* nodes_kernel.c: what of a mesh is in the tile, and not hidden; some small triangles of it may be left waiting. */
void DAFT_KERNEL(daft_mesh_draw)(daft_tile_job *job, const daft_view_instance *view, daft_queue *queue);
void DAFT_KERNEL(daft_queue_draw)(daft_tile_job *job, daft_queue *queue);
/* Whether the pixels x0..x1, y0..y1 of the tile all see something whose w is above `nearest`. */
bool DAFT_KERNEL(daft_pixels_hidden)(daft_tile_job *job, int x0, int x1, int y0, int y1, float nearest);
/* What is drawn: a triangle or a sphere. */
typedef struct daft_primitive {
    const daft_view_instance *view;
    uint32_t triangle; /* 0 for a sphere */
    daft_holes *holes; /* NULL: none. They are set up by the first window that asks */
} daft_primitive;
/* decide_kernel.c: a ray that meets it, or may where that is not sure, with the interval of its w. */
void DAFT_KERNEL(daft_ray_decide)(daft_tile_job *job, int at, const daft_primitive *t, bool sure, float low,
                                  float high);
/* Whether ray (x, y) of the tile is in a hole of a triangle. */
bool DAFT_KERNEL(daft_ray_in_hole)(const daft_tile_job *job, int x, int y, const daft_view_instance *view,
                                   uint32_t triangle);
/* Of the lanes `hits` of a window of rays from (x, y) on, those that are. */
vbits DAFT_KERNEL(daft_hits_in_holes)(daft_tile_job *job, const daft_primitive *t, int x, int y, vbits hits);
/* coverage_kernel.c: draws these, and none of them are left. */
void DAFT_KERNEL(daft_hits_draw)(daft_tile_job *job, daft_small *from, daft_hits *hits);
void DAFT_KERNEL(daft_batch_draw)(daft_tile_job *job, const daft_pencil_batch *batch);
/* The rays x0..x1, y0..y1 of the tile against a sphere. */
void DAFT_KERNEL(daft_sphere_draw)(daft_tile_job *job, const daft_view_instance *view, int x0, int x1, int y0, int y1);
/* fine_kernel.c: the same of fine tiles. */
void DAFT_KERNEL(daft_fine_begin)(daft_tile_job *job);
void DAFT_KERNEL(daft_fine_hits_draw)(daft_tile_job *job, daft_small *from, daft_hits *hits);
void DAFT_KERNEL(daft_fine_batch_draw)(daft_tile_job *job, const daft_pencil_batch *batch);
void DAFT_KERNEL(daft_fine_sphere_draw)(daft_tile_job *job, const daft_view_instance *view, int x0, int x1, int y0,
                                        int y1);

/* holes_kernel.c. Of a window's lanes `hits`, those that are in a hole. */
vbits DAFT_KERNEL(daft_holes_pass)(const daft_holes *h, int x, int y, vbits hits);

/* The lanes that the plane leaves out; a NaN stays in. */
DAFT_INLINE vbits clipped(const float clip[4], const vf3 corner[3])
{
    const vf x = vf_set(clip[0]), y = vf_set(clip[1]), z = vf_set(clip[2]), end = vf_set(clip[3]);
    vm out = vf_le(x * corner[0].x + y * corner[0].y + z * corner[0].z, end);
    for (int k = 1; k < 3; k++) out = vm_and(out, vf_le(x * corner[k].x + y * corner[k].y + z * corner[k].z, end));
    return vbits_from_mask(out);
}

/* Blocks by number; nothing is computed from what is not there. */
DAFT_INLINE void blocks_at(const daft_view_instance *view, const uint32_t *blocks, uint32_t count,
                           const daft_block *out[DAFT_BATCH_BLOCKS])
{
    for (uint32_t i = 0; i < DAFT_BATCH_BLOCKS; i++) out[i] = &view->bvh->blocks[blocks[i < count ? i : 0]];
}

DAFT_INLINE bool asks_holes(const daft_tile_job *j, const daft_view_instance *view)
{
    return j->raster->passes_holes && view->instance->masks;
}

/* Adds those of `some`. */
DAFT_INLINE void queue_add(daft_queue *out, const vf3 corner[3], vi pixels, vf nearest, uint32_t instance, vi triangle,
                           vbits some)
{
    uint32_t at = out->count;
    for (int k = 0; k < 3; k++) {
        vf_compress_store(&out->corner[3 * k][at], some, corner[k].x);
        vf_compress_store(&out->corner[3 * k + 1][at], some, corner[k].y);
        vf_compress_store(&out->corner[3 * k + 2][at], some, corner[k].z);
    }
    vi_compress_store(&out->pixels[at], some, pixels);
    vf_compress_store(&out->nearest[at], some, nearest);
    vi_compress_store(&out->triangle[at], some, triangle);
    vi_store(&out->instance[at], vi_set((int32_t)instance));
    out->count += (uint32_t)__builtin_popcount(some);
}

/* A screen box is widened by this many pixels: over the error of three roundings of coordinates up to 2^14. */
#define DAFT_SCREEN_SLACK 0.004f
#endif

#endif
