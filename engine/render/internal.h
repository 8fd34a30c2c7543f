/* What the files of render/ share: the plan of a frame and a worker's scratch. */
#ifndef DAFT_RENDER_INTERNAL_H
#define DAFT_RENDER_INTERNAL_H

#include "geometry/planes.h"
#include "render/dice.h"
#include "render/kernels.h"

#include <stdatomic.h>

/* What a frame may need at all, before anything is known to be visible. */
typedef struct daft_plan {
    const daft_quality *quality;
    bool shadows, may_reflect;                   /* some light casts them onto something; some material mirrors */
    bool denoise;                                /* what they sample is filtered */
    bool soft, occlusion;                        /* some of these shadows are soft; ambient light is occluded */
    bool samples_light;                          /* either */
    bool fog;                                    /* between what is seen and the eye */
    bool glossy;                                 /* some material that mirrors or transmits is rough */
    bool colors, varies, tangents, blends;       /* of what is in the frame: see DAFT_TRAIT_… */
    bool fades;                                  /* the same of vertices' alpha, where something blends */
    int through_depth;                           /* surfaces that a path which passes through some may meet */
    int through_lists;                           /* of rays that wait, for each: see daft_scratch.refracted */
    bool tints, may_refract;                     /* some of these shadows let light through; some material transmits */
    bool filters;                                /* some of what keeps light away has alpha */
    bool media, absorbs;                         /* some material has a priority or absorbs; or the latter alone */
    bool reflects, refracts;                     /* of the running sample: what is seen may send such rays on */
    const char *why[DAFT_EFFECT_COUNT];          /* what calls for the effect, or why nothing can */
    const char *why_not_seen[DAFT_EFFECT_COUNT]; /* the reason if no tile runs it after all */
} daft_plan;

/* Pixels that planes hold values of: all of the picture, or one of every step x step, those of column x and row y
 * among them. Rows are `stride` floats apart; a tile has tile x tile of them. */
typedef struct daft_grid {
    float *planes;
    size_t plane_size;
    ptrdiff_t stride;
    uint32_t first_tile; /* of the picture, that they begin with */
    int rows, tile, step, x, y;
} daft_grid;

static inline bool daft_grid_has(const daft_grid *g, uint32_t x, uint32_t y)
{
    const uint32_t within = (uint32_t)g->step - 1; /* steps are powers of two */
    return ((x & within) == (uint32_t)g->x) & ((y & within) == (uint32_t)g->y);
}

/* Light of points that is sampled (tile/soft.c). */
typedef struct daft_sampled_light {
    bool some;                            /* of the batch, so that what follows counts: */
    bool tile_some;                       /* of the tile: */
    daft_lanes3 whole, arrived;           /* what would arrive if nothing were in its way; what does */
    daft_lanes3 tile_whole, tile_arrived; /* the same of the tile's pixels, while they are to be filtered */
    daft_lanes3 before;                   /* the points' light without it, */
    bool kept;                            /* as long as nothing else lights them */
    uint32_t chosen[DAFT_BATCH_WORDS];    /* the batch's points that cast rays to the lights below */
    daft_candidates candidates;           /* lights with a size that are still to be asked */
    bool recalls;                         /* the batch's points of these bits have the fraction of a pixel like them */
    uint32_t recalled[DAFT_BATCH_WORDS];
    daft_lanes3 fraction;
    float open[DAFT_BATCH_ROOM];
} daft_sampled_light;

/* What pixels see by rough surfaces, while it is to be filtered (tile/gloss.c). */
typedef struct daft_gloss {
    bool some, asks;                  /* of the tile's pixels see one; the running rays are those that these send */
    uint32_t rough[DAFT_BATCH_WORDS]; /* bits of these pixels; of more samples, of those with recalled light */
    float alpha[DAFT_BATCH_ROOM], distance[DAFT_BATCH_ROOM]; /* of their surface */
    union {
        daft_lanes3 sharp;    /* their light without it */
        daft_lanes3 recalled; /* of more samples, which come later: the filtered light, for rays of weight 1 */
    };
    daft_lanes3 weight;             /* of the rays that they sent on */
    float inverse[DAFT_BATCH_ROOM]; /* the sum of 1 / how far these rays went, */
    float rays[DAFT_BATCH_ROOM];    /* and how many they were */
} daft_gloss;

/* A worker's own: no lock, no allocation in a settled frame. */
typedef struct daft_scratch {
    daft_tile tile;
    daft_facets facets;
    daft_batch points, next;
    daft_ray_batch rays, sky;
    daft_lanes3 sky_color, far_fog; /* far_fog: of rays that meet nothing */
    daft_lanes3 color;              /* of the tile's pixels: row · DAFT_TILE + column */
    uint32_t candidates[DAFT_MAX_OCCLUDERS];
    uint32_t lit[DAFT_SAMPLES_WORDS], under[DAFT_SAMPLES_WORDS];
    daft_sampled_light *sampled; /* NULL: the frame has none */
    daft_gloss *gloss;           /* NULL: the frame has none, or does not filter it */
    daft_batch *third;           /* NULL: no surface sends more than one ray on */
    daft_lanes3 *passed;         /* of the running light's light; NULL until some shadow lets light through */
    /* Waiting, of each depth: what is refracted and what goes straight on, in a list each where one point may send
     * both, else in one. NULL until something is seen that light may pass. */
    daft_ray_batch *refracted;
    uint8_t seen_by[DAFT_BATCH_ROOM];                 /* where there are planar mirrors: see daft_mirrors_follow */
    uint32_t around[3][DAFT_TILE + 2][DAFT_TILE + 2]; /* a tile at the picture's border: its pixels, ids, own colours */
    daft_mixed mixed;                                 /* the tile's pixels that their corners change */
    daft_fine_tile fine;                              /* what the rays of pixels at edges see (tile/edges.c) */
    daft_lanes3 sum;              /* of the tile's pixels that get more samples: their linear light, */
    float own[DAFT_BATCH];        /* and for how many rays their first samples speak */
    daft_seen_list fresh;         /* samples that are to be shaded, */
    uint32_t wanted[DAFT_BATCH];  /* by their own places, those of their pixels in the tile, */
    float share[DAFT_BATCH_ROOM]; /* and, in their order, for how many rays they speak */
    uint64_t ticks[DAFT_EFFECT_COUNT];
    uint32_t tiles[DAFT_EFFECT_COUNT];
    uint64_t rays_cast[DAFT_EFFECT_COUNT];
    uint64_t shadow_points;
    daft_pierced_leaf last_stop;      /* of the rays through surfaces with alpha in this pass over the tile */
    uint64_t alpha_rays, alpha_reads; /* rays through surfaces with alpha, and texels that these read */
} daft_scratch;

/* The planes of a mesh where its materials mirror smoothly. */
typedef struct daft_mirror_mesh {
    const daft_trimesh *mesh;
    uint64_t shape, slots; /* the instance's; a hash of which slots mirror so */
    uint32_t triangles;    /* of the mesh, which may be gone */
    uint32_t idle;         /* samples of pictures since it was last asked for */
    daft_mesh_planes planes;
} daft_mirror_mesh;

/* A plane of some instance that mirrors, as the camera sees it or another mirror shows it, and the camera mirrored in
 * all of them. */
enum { DAFT_MAX_MIRRORS = 16, DAFT_SEEN_BY_CAMERA = 254, DAFT_SEEN_BY_RAYS = 255 };
typedef struct daft_mirror {
    uint8_t parent; /* the mirror that shows it, or DAFT_SEEN_BY_CAMERA */
    int depth;      /* 1: the camera sees it */
    uint32_t instance, plane;
    const uint8_t *planes; /* of the mesh's triangles */
    daft_dvec3 normal;     /* unit, towards the parent's eye */
    double offset;         /* normal · p + offset: how far before the plane p lies */
    double away;           /* of the parent's eye from the plane, and of its own eye behind it */
    daft_dvec3 eye;        /* the parent's, mirrored, in frame space */
    int x0, x1, y0, y1;    /* pixels that the plane's bounds may cover, inclusive */
    daft_pencil pencil;
    daft_raster raster;
    daft_instance *instances; /* those that reach before the plane, with the mirrored eye as origin */
    uint32_t *numbers;        /* in the snapshot */
    size_t instance_capacity, number_capacity;
    uint32_t count;
} daft_mirror;

struct daft_renderer {
    daft_allocator allocator;
    int threads, isa;
    const daft_accel_kernels *accel;
    const daft_raster_kernels *raster_kernels;
    const daft_sample_kernels *sample_kernels;
    const daft_shade_kernels *shade;
    const daft_render_kernels *kernels;
    daft_raster raster;
    daft_arena arena; /* the tree over instances, kept as long as these are the same: */
    const daft_tlas *tlas;
    uint64_t revision;
    daft_intersection intersection;
    daft_scratch *scratch;                /* one for each worker */
    uint8_t *sample_scratch;              /* the workers', sample_kernels->scratch_size each */
    daft_vec2 turns[1 << DAFT_TURN_BITS]; /* unit vectors all round */
    daft_sampled_light *sampled;          /* the workers' */
    size_t sampled_capacity;
    daft_gloss *gloss; /* the workers' */
    size_t gloss_capacity;
    daft_batch *third; /* the workers' */
    size_t third_capacity;
    daft_varying *varying; /* the workers', of three batches each */
    size_t varying_capacity;
    daft_footprints *footprints; /* the same */
    size_t footprint_capacity;
    daft_lanes3 *passed; /* the workers' */
    size_t passed_capacity;
    daft_ray_batch *refracted; /* the workers' */
    size_t refracted_capacity;
    daft_crossings *crossings; /* the workers', of three batches each, where rays carry media */
    daft_media *media;         /* the workers', of each of their lists of rays */
    size_t crossing_capacity, media_capacity;
    daft_mirror mirrors[DAFT_MAX_MIRRORS];
    daft_mirror_mesh *mirror_meshes; /* those asked for of late */
    size_t mirror_mesh_count, mirror_mesh_capacity;
    bool *mirror_slots; /* of the mesh that is looked at: which mirror smoothly */
    size_t mirror_slot_capacity;
    daft_tile *mirrored; /* the workers', for each mirror */
    size_t mirrored_capacity;
    float *sum; /* linear light of all samples so far: 3·width·height; NULL until more than one is asked for */
    size_t sum_capacity;
    /* Where some pixels get more samples, else NULL; rows are those of the band and of the tiles above and below it: */
    daft_edges *edges; /* of each tile */
    uint32_t *ids;     /* daft_pixel_id of each pixel */
    uint32_t *own;     /* RGBA of what textures give its surface, all bits without one; unless corners are asked for */
    uint8_t *apron;    /* the pixels above and below the band */
    uint8_t *smooth;   /* the band's pixels with more samples, tile by tile, until all are drawn */
    uint32_t *corners; /* words of the band's corners (daft_mixed); daft_edges.outline says which there are */
    struct daft_meter_picture *meter; /* meter.c; NULL until light is metered */
    /* denoise.c: planes of the frame's tiles, and what of these is to be filtered (DAFT_NOISY_…) */
    float *planes;
    uint8_t *noisy;
    daft_grid grid, light_grid;                         /* of the picture before */
    size_t plane_capacity, plane_count, noisy_capacity; /* plane_count: of `grid` */
    size_t edge_capacity, id_capacity, own_capacity, apron_capacity, smooth_capacity, corner_capacity;
};

/* One sample of one frame, as its tiles see it. */
typedef struct daft_frame {
    daft_renderer *renderer;
    const daft_snapshot *snapshot;
    const daft_frame_target *target;
    daft_plan plan;
    daft_pencil pencil;
    const daft_tlas *tlas; /* NULL: nothing asks for rays */
    int sample;
    bool media;                      /* rays carry what they are in */
    daft_media eye;                  /* what the camera is in */
    int mirror_count;                /* planar ones, whose rays form pencils: those of a parent follow it */
    uint32_t first_tile, tile_count; /* of the running pass */
    uint32_t band_tile;              /* the first one that is wanted */
    uint32_t tiles_in_all;           /* of all passes */
    /* Pixels that get more samples have them in their corners (1) or on a grid of so many rows and columns; 0: none do.
     */
    int edge_scale;
    daft_texture_filter texture_filter; /* of the running pass */
    bool keeps_own;                     /* what textures give pixels, since more samples do not serve that */
    daft_grid grid, light_grid;         /* of what is filtered: all pixels, and those whose sampled light is found */
    int filter_pass, filtered;          /* the running pass; DAFT_NOISY_… */
    uint32_t corner_tiles;              /* those of the band and of the row below, whose corners it shares */
    /* Where the picture before is kept: what it says of each tile; the tiles that are drawn, and those of them that are
     * mixed with their corners. NULL: nothing is kept; all are. */
    daft_kept *kept;
    const uint32_t *tiles, *mixed;
    uint32_t listed, mixed_count;
    atomic_uint tiles_done;
    atomic_bool cancelled;
} daft_frame;

/* What of a tile is to be filtered. */
enum { DAFT_NOISY_LIGHT = 1, DAFT_NOISY_GLOSS = 2 };
/* denoise.c: once the first tile of the frame's first pass is known; and when all tiles of it are drawn. */
bool daft_denoise_prepare(daft_frame *frame, daft_error *error);
bool daft_denoise(daft_frame *frame, daft_error *error);
size_t daft_denoise_bytes(const daft_renderer *r);
/* meter.c: makes tone.ev what the picture calls for, by a small one of the same view; counts its time. */
bool daft_meter(daft_renderer *renderer, daft_snapshot *snapshot, double *ms, daft_error *error);
/* plan.c */
daft_plan daft_plan_make(const daft_snapshot *snapshot);
/* Whether what the pencil may see (the instances in its bins) mirrors; and whether it transmits, or shows in a mirror
 * what may. */
void daft_plan_narrow(daft_plan *plan, const daft_snapshot *snapshot, const daft_raster *raster);
/* tile/media.c. Whether the camera may be in something that transmits; its media, and memory for those of rays. */
bool daft_media_near_eye(const daft_snapshot *snapshot);
bool daft_media_prepare(daft_frame *frame, daft_error *error);
size_t daft_media_bytes(const daft_renderer *renderer);
/* mirror.c. Finds the planar mirrors that are worth a pass of their own, also those seen in others, and puts what they
 * may show into tiles. */
bool daft_mirrors_prepare(daft_frame *frame, daft_error *error);
void daft_mirrors_free(daft_renderer *renderer);
size_t daft_mirrors_bytes(const daft_renderer *renderer);
/* `by`: by which mirror each of the tile's pixels sees the points, DAFT_SEEN_BY_CAMERA or DAFT_SEEN_BY_RAYS; becomes
 * the same of what the points mirror. */
void daft_mirrors_follow(const daft_frame *frame, const daft_batch *points, uint8_t *by);
/* Draws the views of those mirrors by which enough of the tile's rays see; returns these mirrors as bits. */
uint32_t daft_mirrors_tile(const daft_frame *frame, uint32_t number, uint32_t worker, const uint8_t *by,
                           const daft_ray_batch *rays);
/* The hits of the rays first.. from the mirrors' views, as `closest` would give them, without the normal. Into `others`
 * those of the rays, counted from the first, that no view decides and that must be cast; gives how many. */
uint32_t daft_mirrors_hits(const daft_frame *frame, uint32_t shown, uint32_t worker, const uint8_t *by,
                           const daft_ray_batch *rays, uint32_t first, uint32_t count, daft_hit *hits,
                           uint16_t *others);
/* A row of the picture, or of the apron. */
static inline uint8_t *daft_frame_row(const daft_frame *frame, int y)
{
    const daft_snapshot *s = frame->snapshot;
    const size_t stride = 4 * (size_t)s->width;
    const int end = s->first_row + s->row_count;
    if (y < s->first_row) return frame->renderer->apron + (size_t)(y + DAFT_TILE - s->first_row) * stride;
    if (y >= end) return frame->renderer->apron + (size_t)(DAFT_TILE + y - end) * stride;
    return frame->target->pixels + (size_t)y * stride;
}
/* tile/tile.c: a daft_task */
void daft_render_tile(void *context, uint32_t index, uint32_t worker);
/* What the pixels of a row see, by daft_pixel_id. */
static inline uint32_t *daft_frame_ids(const daft_frame *frame, int y)
{
    const daft_snapshot *s = frame->snapshot;
    return frame->renderer->ids + (size_t)(y + DAFT_TILE - s->first_row) * (size_t)s->width;
}
static inline uint32_t *daft_frame_own(const daft_frame *frame, int y)
{
    return frame->renderer->own + (daft_frame_ids(frame, y) - frame->renderer->ids);
}
static inline uint32_t daft_tile_columns(const daft_snapshot *s)
{
    return (uint32_t)((s->width + DAFT_TILE - 1) / DAFT_TILE);
}
/* tile/corners.c: tasks. The first draws corners, for so many words; the second mixes pixels with them. */
size_t daft_corner_words(const daft_frame *frame);
void daft_corners_tile(void *context, uint32_t task, uint32_t worker);
void daft_mix_tile(void *context, uint32_t task, uint32_t worker);
/* tile/edges.c: tasks. The first draws what gets more samples, the second, when all tiles are done, shows it. */
void daft_refine_tile(void *context, uint32_t index, uint32_t worker);
void daft_show_edges(void *context, uint32_t index, uint32_t worker);

#endif
