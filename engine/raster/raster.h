/* A grid of pixels against the snapshot's instances, and the kernels of each instruction set. See view.h.
 *
 * Passes: daft_raster_begin; daft_raster_bin (once for each work item, in parallel) puts the instances that may be
 * visible into tiles by their projected bounds; a kernel's `tile` (once for each tile, in parallel) walks the trees of
 * its instances front to back, by the screen boxes of their nodes: what lies beside the tile, between the rays of its
 * pixels or behind what they see already is left out by whole subtrees. What is left is set up some triangles at a
 * time, and rays decide. */
#ifndef DAFT_RASTER_H
#define DAFT_RASTER_H

#include "base/base.h"
#include "image/image.h"
#include "raster/view.h"

#define DAFT_NOTHING UINT32_MAX /* instance of a pixel that sees the sky */

/* An instance in view space. */
typedef struct daft_view_instance {
    const daft_instance *instance; /* NULL: none of it can be seen */
    const daft_trimesh *mesh;      /* the instance's, at hand: instances in a tile stand anywhere in memory */
    const daft_bvh *bvh;
    uint32_t index; /* in the snapshot */
    daft_affine to_view;
    float near_z;       /* of its bounds in view space */
    int x0, x1, y0, y1; /* pixels its bounds may cover, inclusive */
    bool dense; /* a mesh with a triangle or more to six pixels of them; to four around the camera, where most is
                   elsewhere */
} daft_view_instance;

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
    uint32_t ordered_tile, ordered; /* whose they are, and how many: its parts need not sort them again */
    /* Instances in the picture; nodes and triangles whose boxes were tested (a triangle once for each tile); triangles
     * set up; spheres in tiles; decisions that floats could not make. */
    uint64_t visible, nodes, tested, binned, spheres, exact_edges, exact_depths;
    bool out_of_memory;
} daft_bins;

/* Visibility of one tile. Row r starts at r·DAFT_TILE_STRIDE. */
typedef struct daft_tile {
    int x, y, width, height; /* in the picture */
    _Alignas(64) uint32_t instance[DAFT_TILE_ROOM];
    _Alignas(64) uint32_t triangle[DAFT_TILE_ROOM];
} daft_tile;

/* Some of a tile's pixels, by other rays than the pencil's. Those that are not asked for see nothing. */
typedef struct daft_tile_part {
    float shift_x, shift_y;    /* of the rays from the pixels' middles, as those of daft_pencil */
    uint32_t asked[DAFT_TILE]; /* bit x of row y */
} daft_tile_part;
_Static_assert(DAFT_TILE == 32, "a row of a tile is one word of bits");

/* Some of a tile's pixels by sixteen rays each, those of a picture four times as wide and high, turned by
 * DAFT_FINE_TURN (daft_pencil.turn). Ray x + 4·y of pixel p stands at 16·p + x + 4·y. Rays that are not asked for see
 * nothing where others of their pixel are asked for, and have no value elsewhere. */
enum { DAFT_FINE = 4, DAFT_FINE_RAYS = DAFT_FINE * DAFT_FINE, DAFT_FINE_SIDE = DAFT_FINE * DAFT_TILE };
#define DAFT_FINE_TURN 0.25f
typedef struct daft_fine_tile {
    uint32_t pixels[DAFT_TILE];            /* bit x of row y: some ray of the pixel is asked for, */
    uint16_t asked[DAFT_TILE * DAFT_TILE]; /* and then which, by pixels: DAFT_TILE·y + x */
    _Alignas(64) uint32_t instance[DAFT_FINE_RAYS * DAFT_TILE * DAFT_TILE];
    _Alignas(64) uint32_t triangle[DAFT_FINE_RAYS * DAFT_TILE * DAFT_TILE];
} daft_fine_tile;

/* A plane in view space that the pencil looks through, and before which everything is that it may see: normal · p >
 * away. A triangle is left out where all of it clearly lies behind that; one of the owner, the instance that holds the
 * plane, also where it lies in it, by the roundings of its corners. */
typedef struct daft_clip {
    bool some; /* false: all is seen */
    daft_vec3 normal;
    float away;
    uint32_t owner; /* among the raster's instances; DAFT_NOTHING: none */
} daft_clip;

typedef struct daft_raster {
    const daft_allocator *allocator;
    daft_pencil pencil;
    daft_clip clip; /* none, unless it is set after daft_raster_begin */
    /* Texels that a pixel's filter reads are as many each way, and what alpha leaves nothing of is looked through:
     * places of masks that are sure to be holes are passed over. False, unless it is set after daft_raster_begin. */
    bool passes_holes;
    /* Where that is true, and pixels filter between two levels and take all or nothing of a mask: what cells do not
     * tell is read from these textures. NULL, unless it is set after daft_raster_begin: cells alone tell. */
    const daft_texture_data *textures;
    const daft_instance *instances;
    uint32_t instance_count;
    int tiles_x, tiles_y, workers;
    daft_view_instance *visible; /* one for each instance, filled by daft_raster_bin */
    size_t visible_capacity;
    uint32_t work_count;
    daft_bins *bins; /* one for each worker */
    void *scratch;   /* the kernels', kernels->scratch_size for each worker */
    const struct daft_raster_kernels *kernels;
} daft_raster;

bool daft_raster_init(daft_raster *raster, const daft_allocator *allocator, int workers, int isa, daft_error *error);
void daft_raster_free(daft_raster *raster);
size_t daft_raster_bytes(const daft_raster *raster);
bool daft_raster_begin(daft_raster *raster, const daft_pencil *pencil, const daft_instance *instances, uint32_t count,
                       daft_error *error);

void daft_raster_bin(daft_raster *raster, uint32_t work, uint32_t worker);

/* Pixels that a triangle's projected bounds may cover, inclusive; x0 > x1: none. */
typedef struct daft_screen_box {
    int16_t x0, x1, y0, y1;
} daft_screen_box;

typedef struct daft_raster_kernels {
    size_t scratch_size; /* of a worker */
    /* `part`: NULL for the tile itself, by the pencil's own rays. */
    void (*tile)(const daft_raster *raster, uint32_t tile, uint32_t worker, const daft_tile_part *part, daft_tile *out);
    /* scaled coordinates of pixels are below 2^15 */
    void (*fine)(const daft_raster *raster, uint32_t tile, uint32_t worker, daft_fine_tile *out);
    /* Fills raster->visible for `lanes` instances from one on, all of meshes with triangles, as daft_raster_bin does
     * one by one. */
    void (*instances)(const daft_raster *raster, uint32_t first);
    uint32_t lanes;
    /* The candidate boxes of a mesh's triangles, by their numbers, within the picture. */
    void (*boxes)(const daft_raster *raster, uint32_t instance, daft_screen_box *out);
} daft_raster_kernels;

const daft_raster_kernels *daft_raster_kernels_for(int isa);

/* What shadow rays meet on their way through surfaces with alpha, as far as it is sure: points by their numbers. */
enum { DAFT_MET_SURFACES = 6 };
typedef struct daft_filtered {
    uint32_t under[DAFT_SAMPLES_WORDS]; /* points whose ray met the bounds of something: all others meet nothing */
    uint32_t open[DAFT_SAMPLES_WORDS];  /* those of them whose own ray must tell */
    uint8_t count[DAFT_SAMPLES_ROOM];   /* hits on even surfaces (daft_mask.even), and their materials: */
    uint32_t material[DAFT_MET_SURFACES][DAFT_SAMPLES_ROOM];
} daft_filtered;

/* Points against one light. */
typedef struct daft_sample_kernels {
    size_t scratch_size; /* of a worker, at a multiple of 64 bytes */
    /* Clears the bits of the points that the instance hides from the light or, with DAFT_NOTHING, that any of
     * DAFT_INSTANCE_CASTS_SHADOW does. Gives the number of points that were tested: whose ray met its bounds, where the
     * shaft of all points is not known to be clear. */
    uint32_t (*shadows)(const daft_samples *points, const daft_apex *light, const daft_tlas *tlas, uint32_t instance,
                        uint32_t bits[DAFT_SAMPLES_WORDS], void *scratch);
    /* The instances of DAFT_INSTANCE_TINTS_SHADOW whose bounds some point's ray meets; their number, or UINT32_MAX
     * where there may be more or the light is among the points. */
    uint32_t (*tints)(const daft_samples *points, const daft_apex *light, const daft_tlas *tlas,
                      const uint32_t bits[DAFT_SAMPLES_WORDS], uint32_t out[DAFT_MAX_OCCLUDERS], void *scratch);
    /* Clears the bits of the points that opaque places of DAFT_INSTANCE_FILTERS_SHADOW surely hide from the light; the
     * result, in the scratch, says what is left to do for the others. Gives the number of points under something. */
    uint32_t (*filters)(const daft_samples *points, const daft_apex *light, const daft_tlas *tlas,
                        uint32_t bits[DAFT_SAMPLES_WORDS], const daft_filtered **out, void *scratch);
} daft_sample_kernels;

const daft_sample_kernels *daft_sample_kernels_for(int isa);

/* The slow, obvious twin: every ray alone through the two trees, in scalar double, the same predicates at the leaves.
 */
void daft_reference_tile(const daft_raster *raster, const daft_tlas *tlas, uint32_t tile, const daft_tile_part *part,
                         daft_tile *out);
void daft_reference_fine(const daft_raster *raster, const daft_tlas *tlas, uint32_t tile, daft_fine_tile *out);

/* ---- shared by the two paths ---- */

void daft_view_corners(const daft_view_instance *view, uint32_t triangle, daft_vec3 corner[3]);
/* The exact depth of something that the ray is known to hit. */
double daft_view_depth(const daft_view_instance *view, uint32_t triangle, daft_vec3 ray);
/* Fills the view of one instance. False: none of it can be seen. */
bool daft_view_instance_make(const daft_pencil *p, const daft_instance *instance, uint32_t index,
                             daft_view_instance *out);
/* Of a mesh whose pixels and near_z are known. */
static inline bool daft_view_dense(const daft_view_instance *view)
{
    int64_t triangles = view->mesh->triangle_count,
            pixels = (int64_t)(view->x1 - view->x0 + 1) * (view->y1 - view->y0 + 1);
    return (view->near_z > 0 ? 6 : 4) * triangles >= pixels;
}
/* The pencil of a part's rays; the raster's own for NULL. */
static inline daft_pencil daft_part_pencil(const daft_pencil *p, const daft_tile_part *part)
{
    daft_pencil own = *p;
    if (part) own.shift_x = part->shift_x, own.shift_y = part->shift_y;
    return own;
}
/* Of a picture `scale` times as wide and high, by the middles of its pixels; and that of a fine tile's rays. */
static inline daft_pencil daft_scaled_pencil(const daft_pencil *p, int scale)
{
    daft_pencil own = *p;
    own.width *= scale, own.height *= scale, own.focal *= (float)scale;
    own.shift_x = own.shift_y = 0;
    return own;
}
static inline daft_pencil daft_fine_pencil(const daft_pencil *p)
{
    daft_pencil own = daft_scaled_pencil(p, DAFT_FINE);
    own.turn = DAFT_FINE_TURN;
    return own;
}
/* Sets the place and size of a tile. */
void daft_tile_place(const daft_raster *raster, uint32_t tile, daft_tile *out);

#endif
