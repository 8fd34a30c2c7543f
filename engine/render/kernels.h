/* The kernels of each instruction set; frame.c picks. */
#ifndef DAFT_RENDER_KERNELS_H
#define DAFT_RENDER_KERNELS_H

#include "math/simd/dispatch.h"
#include "raster/raster.h"
#include "render/media.h"
#include "render/render.h"

/* How far off a surface rays start. In units of u = 2^-24 and of S = |x| + |y| + |z| of the point plus that of the
 * instance's translation: the point's error is 6 (height, normal, their quotient with the ray, and the product),
 * corners moved by to_frame in another order 4, and the transform into object space 6 (a rounded map, three products,
 * three sums). Sixteen covers their sum. */
#define DAFT_SPAWN_ERROR (16 * 0x1p-24f)

_Static_assert((int)DAFT_BATCH == (int)DAFT_SAMPLES && (int)DAFT_BATCH_ROOM >= (int)DAFT_SAMPLES_ROOM,
               "a batch is a set of samples");

/* A batch's points as they ask for a light. */
static inline daft_samples daft_samples_of(const daft_batch *b)
{
    return (daft_samples){.count = b->count,
                          .origin = {b->shadow_origin.x, b->shadow_origin.y, b->shadow_origin.z},
                          .outward = {b->outward.x, b->outward.y, b->outward.z},
                          .instance = b->instance,
                          .triangle = b->triangle,
                          .pixel = b->pixel};
}

/* Rays to a sphere that glows end before it, which is a little larger here, by more than roundings of its place; and
 * before a rectangle, where something that glows may lie. */
#define DAFT_BEFORE_RECTANGLE 0.001f
static inline float daft_sphere_end(const daft_light_source *light)
{
    const daft_vec3 p = light->position;
    return 1.001f * light->radius + 0x1p-20f * (fabsf(p.x) + fabsf(p.y) + fabsf(p.z));
}

static inline daft_apex daft_apex_of(const daft_light_source *light)
{
    return (daft_apex){.infinite = light->sun,
                       .at = light->sun ? light->to_light : light->position,
                       .around = light->area == DAFT_AREA_SPHERE ? daft_sphere_end(light) : 0,
                       .before = light->area == DAFT_AREA_RECTANGLE ? DAFT_BEFORE_RECTANGLE : 0,
                       .box = light->bounded ? &light->bounds : NULL};
}

/* Rays, side by side, with where they came from. */
typedef struct daft_ray_batch {
    uint32_t count;
    daft_lanes3 origin, direction; /* directions are unit */
    daft_lanes3 weight;
    float distance[DAFT_BATCH_ROOM];
    uint32_t pixel[DAFT_BATCH_ROOM];
    daft_media *media; /* that they are in; NULL: no material in the frame calls for it */
} daft_ray_batch;

/* The different facets (triangles or spheres) that a batch's rays meet. Rows are the kernels' own: see
 * render/points/surface.h. */
enum { DAFT_FACET_FLOATS = 48 };
typedef struct daft_facets {
    uint32_t count;
    uint32_t traits, last_material; /* of their materials: all traits; the one that was looked at last */
    bool one_material;
    bool colors, tangents;         /* of the frame: some mesh has colours, some material a map of normals */
    bool fades;                    /* some mesh has alpha, and some material shows it */
    int32_t slot[DAFT_BATCH_ROOM]; /* what each point lies on */
    uint32_t instance[DAFT_BATCH_ROOM], triangle[DAFT_BATCH_ROOM];
    _Alignas(64) float row[DAFT_BATCH_ROOM][DAFT_FACET_FLOATS];
} daft_facets;

/* What is seen, and what a frame asks of points beside what their materials call for. */
typedef struct daft_surfaces_def {
    const daft_snapshot *snapshot;
    const daft_pencil *pencil;
    bool shadows; /* some light may cast them */
    bool distance;
} daft_surfaces_def;

/* What points may still send on: rays that are mirrored as a material or Fresnel's equations ask; and which rays, by
 * their fraction of the pixel, do not count any more. Of rough surfaces, ray number `ray` of `rays`; the later ones are
 * theirs alone. */
typedef struct daft_spawning {
    bool mirrors, refracts;
    float min;
    bool rough; /* false: all are smooth */
    uint32_t ray, rays;
    uint32_t column, row, round, salt; /* of the tile's first pixel in the picture; see daft_dice_throw */
    const uint32_t *place;             /* of each of the batch's pixels in the tile; NULL: these are places */
    const daft_vec2 *turns;            /* unit vectors all round */
} daft_spawning;

/* Above a surface's own colour, of the surfaces that pixels see: the first of these, from the last one on, that it is.
 * What mirrors little and has a texture is textured. */
enum { DAFT_OWN_MATTE, DAFT_OWN_TEXTURED, DAFT_OWN_MIRRORS, DAFT_OWN_PASSES /* light */, DAFT_OWN_KINDS };
/* A tile's pixels, RGBA, and what they see, and those around it: pixel (x, y) of the tile, -1 to DAFT_TILE, is at
 * 4·(y · stride + x) bytes, its id at y · id_stride + x. */
typedef struct daft_neighbours {
    const uint8_t *pixel;
    const uint32_t *id;
    const uint32_t *own; /* the surfaces' own colours as bytes of sRGB, where ids are; NULL: not known */
    ptrdiff_t stride, id_stride;
} daft_neighbours;

/* What pixels see is told apart by some bits of the instance and, below, of the triangle. */
enum { DAFT_ID_INSTANCE = 16 };
#define DAFT_ID_SKY (UINT32_MAX << DAFT_ID_INSTANCE)
static inline uint32_t daft_pixel_id(uint32_t instance, uint32_t triangle)
{
    return instance << DAFT_ID_INSTANCE | (triangle & ((1u << DAFT_ID_INSTANCE) - 1));
}

/* Pixels of a tile that disagree with one beside, above or below them, bit x of row y: with one that sees another
 * triangle, instance, or the sky; with one that sees the same triangle or sphere in another light; some do with both.
 * And by how much. */
typedef struct daft_edges {
    uint32_t outline[DAFT_TILE], inner[DAFT_TILE], strong[DAFT_TILE], stark[DAFT_TILE];
    bool sky; /* no pixel of the tile sees anything else */
} daft_edges;
/* Corners of a tile's pixels, bit x of row y: the upper left one of pixel (x, y) and, where pixels are mixed with their
 * corners, one more of each row and row. */
typedef struct daft_corners {
    uint64_t asked[DAFT_TILE + 1];
} daft_corners;
/* A corner's colour, RGBA; in place of A, bit 24 + i where pixel i of the four around it (upper left, upper right,
 * lower left, lower right) sees the same, and has its own colour there. */
enum { DAFT_CORNER_SAME = 24 };
/* Pixels that corners change: each one's place in the tile, its word, and those of its corners in the same order. */
typedef struct daft_mixed {
    uint32_t count;
    uint32_t place[DAFT_BATCH_ROOM], word[5][DAFT_BATCH_ROOM];
} daft_mixed;

/* By more than so many steps of a colour's byte, up to 8191, pixels differ: if they see different instances, different
 * triangles of one, or the same; for those of one kind, and for the rest as if they were matte. And above which they
 * differ by much, and by very much: no less. */
typedef struct daft_contrast_limits {
    int outline, crease, inner;
} daft_contrast_limits;
typedef struct daft_contrast {
    daft_contrast_limits of[DAFT_OWN_KINDS];
    int strong, stark;
} daft_contrast;
/* For daft_quality.edge_contrast. Beyond 255 no two bytes differ by as much. */
static inline daft_contrast daft_scaled_contrast(const daft_contrast *usual, float scale)
{
    daft_contrast out;
    const int *from = &usual->of[0].outline;
    int *to = &out.of[0].outline;
    for (size_t i = 0; i < sizeof out / sizeof *to; i++)
        to[i] = from[i] > 255 ? from[i] : daft_max_i((int)((float)from[i] * scale + 0.5f), 1);
    return out;
}

/* Planes of a picture, to be filtered: a float for each pixel, from row to row `stride` of them; sixteen columns on
 * either side, and sixteen more on the right, may be read. */
typedef struct daft_filter {
    ptrdiff_t stride;
    int height, step;           /* rows; pixels to the neighbours of a pass */
    float left, top, focal;     /* the ray of the first pixel, in view space */
    float *normal[3], *inverse; /* view space; of the depth: 0 where there is nothing to filter */
    float *reach;               /* pixels that the filter may reach; NULL: it filters fractions of light, anywhere */
    float *from[3], *from_variance, *to[3], *to_variance;
} daft_filter;

/* What was found of a grid of pixels, one in every 2 x 2 with (x, y) in the first of them, is enlarged to all:
 * from.from, on the planes of from.normal and from.inverse, to to.to. */
typedef struct daft_enlarging {
    daft_filter to, from;
    int x, y;
} daft_enlarging;

/* What pixels of a grid found of a kind of sampled light, to be joined with the picture before: `past` is read and
 * written, and so are the ratio and, where not NULL, its variance. */
typedef struct daft_reusing {
    const daft_snapshot *snapshot;
    daft_past *past;
    daft_filter grid;            /* the ray of the first pixel, and the stride of planes */
    int first_row;               /* of the past, that planes begin with */
    bool remembers;              /* there is a picture before */
    const float *inverse, *seen; /* of the depth; the instance */
    const float *shown;          /* the inverse depth of what is shown: farther than a surface that mirrors; 0: the sky;
                                    NULL: the surface's own */
    float *ratio[3], *variance;
} daft_reusing;

/* What single rays of a pencil see, and the number under which their light is wanted. */
typedef struct daft_seen_list {
    uint32_t count;
    float x[DAFT_BATCH], y[DAFT_BATCH]; /* the ray is (x, y, focal) in view space */
    uint32_t instance[DAFT_BATCH], triangle[DAFT_BATCH], pixel[DAFT_BATCH];
} daft_seen_list;

/* Part of a tile, as refined: each of its pixels has a grid of so many rays a side, turned so that each lies in a row
 * and a column of its own (daft_fine_tile). */
enum { DAFT_EDGE_SCALE = DAFT_FINE, DAFT_EDGE_RAYS = DAFT_FINE_RAYS };
#define DAFT_EDGE_TURN DAFT_FINE_TURN
/* The order in which a pixel's rays, x + 4·y, are shaded, where not all are: in pairs that lie opposite each other, so
 * that any even number of them has its middle where the pixel has its own. (By Bayer's order eight of sixteen lay to
 * one side: the squared error of glass was a sixth more.) Two on a diagonal, a rotated grid of four, eight round the
 * middle, which the pixel's first sample has. */
static const int32_t DAFT_EDGE_ORDER[DAFT_EDGE_RAYS] = {1, 14, 7, 8, 2, 13, 4, 11, 0, 15, 3, 12, 5, 10, 6, 9};
/* The first so many of that order, as bits. */
static const uint16_t DAFT_EDGE_FIRST[DAFT_EDGE_RAYS + 1] = {0,      0x0002, 0x4002, 0x4082, 0x4182, 0x4186,
                                                             0x6186, 0x6196, 0x6996, 0x6997, 0xe997, 0xe99f,
                                                             0xf99f, 0xf9bf, 0xfdbf, 0xfdff, 0xffff};
/* How many are shaded of a pixel without an outline, by what it saw first and how much changes there. A texture is
 * filtered over the whole pixel already. What lets light through sends on several rays where a mirror sends one. */
static const uint8_t DAFT_EDGE_INNER[DAFT_OWN_KINDS][3] = {[DAFT_OWN_MATTE] = {4, 8, 16},
                                                           [DAFT_OWN_TEXTURED] = {4, 4, 6},
                                                           [DAFT_OWN_MIRRORS] = {4, 8, 12},
                                                           [DAFT_OWN_PASSES] = {2, 4, 8}};
typedef struct daft_edge_part {
    const daft_fine_tile *rays; /* what those of the tile see */
    float x, y;                 /* where the tile's first one goes, before it is turned */
    int left, top;              /* the part's first pixel in the tile */
    const daft_edges *edges;
    const daft_neighbours *first; /* the first samples of the tile's pixels, and of those around it */
} daft_edge_part;
/* What a pixel's first sample saw: a DAFT_OWN_... */
static inline uint32_t daft_first_kind(const daft_neighbours *first, int x, int y)
{
    const ptrdiff_t at = y * first->id_stride + x;
    return first->own && first->id[at] != DAFT_ID_SKY ? first->own[at] >> 24 : DAFT_OWN_MATTE;
}

/* How much changes at a pixel. */
static inline int daft_edge_level(const daft_edges *edges, int x, int y)
{
    return (int)(edges->strong[y] >> x & 1) + (int)(edges->stark[y] >> x & 1);
}

/* The rays that are shaded; by their own places in a batch, those of their pixels in the tile; in the list's order, for
 * how many rays each speaks; and, by the pixels' places, for how many their first samples do. */
typedef struct daft_edge_rays {
    daft_seen_list *list;
    uint32_t *wanted;
    float *share, *own;
} daft_edge_rays;

/* The place in a batch of a list's sample i: four after the other share a block of points, by which lights are looked
 * up. */
static inline uint32_t daft_place_in_batch(uint32_t i)
{
    const uint32_t block = i / 16, row = i / 4 % 4, blocks = DAFT_TILE / 4;
    return (block / blocks * 4 + row) * DAFT_TILE + block % blocks * 4 + i % 4;
}

/* Lights with a size that may reach a batch's points, and what each would send to those that cast rays if nothing were
 * in its way. Of each colour a light is drawn by how much it would bring. */
enum { DAFT_CANDIDATES = 64 };
typedef struct daft_candidates {
    uint32_t lights, points;
    uint32_t light[DAFT_CANDIDATES]; /* of the snapshot */
    uint32_t point[DAFT_BATCH_ROOM]; /* of the batch: those that cast rays, in the order of the arrays below */
    float turn[DAFT_BATCH_ROOM];     /* where the even row of a point's draws begins: 0..1, a multiple of 2^-12 */
    float reached[DAFT_BATCH_ROOM];  /* how many of the lights reach it */
    daft_lanes3 sum, per_sum, upto;  /* of all lights; draws over that; of the lights that are done */
    daft_lanes3 from[DAFT_CANDIDATES];
} daft_candidates;

/* A light is asked by `rays` rays of each point. Where more than `all` lights reach a point, those of `draws` draws
 * are: in each colour, an even row over the lights, laid out by what they bring. */
typedef struct daft_drawing {
    int rays, all, draws;
} daft_drawing;

/* Each ray to a rectangle goes to one of so many places. */
enum { DAFT_PLACES = 4 };

/* Rays to a rectangle that shines. */
typedef struct daft_area_rays {
    const daft_batch *points;
    const daft_light_source *light;
    uint32_t column, row, step, round, salt; /* the tile's first pixel in the picture; see daft_dice_throw */
    const uint32_t *place;                   /* of each of the batch's pixels in the tile; NULL: these are places */
} daft_area_rays;

/* The points that ask a light, by how many rays, and what arrives of the whole if nothing is in the way of these. */
typedef struct daft_asking {
    uint32_t count;
    uint32_t point[DAFT_BATCH_ROOM];
    int32_t rays[DAFT_BATCH_ROOM];
    daft_lanes3 light;
} daft_asking;

typedef struct daft_render_kernels {
    /* Turns a tile's visible surfaces into points of weight 1, filling only the fields that the definition asks for.
     * The other pixels become sky rays, with directions where the sky has more than one colour or there is fog. */
    void (*surfaces)(const daft_surfaces_def *def, const daft_tile *tile, daft_facets *facets, daft_batch *points,
                     daft_ray_batch *sky);
    /* The same for rays in a list. */
    void (*listed_surfaces)(const daft_surfaces_def *def, const daft_seen_list *list, daft_facets *facets,
                            daft_batch *points, daft_ray_batch *sky);
    /* Appends the points where the rays first.. hit, all of them set, and the misses to `sky`, without their origins;
     * NULL: these are left out. */
    void (*hit_points)(const daft_snapshot *snapshot, const daft_ray_batch *rays, uint32_t first, const daft_hit *hits,
                       uint32_t count, daft_facets *facets, daft_batch *points, daft_ray_batch *sky);
    /* The rays that points send on, up to one of each point in each list: mirrored, refracted, and straight through
     * what is not there or blends. `refracted` and `straight` may be NULL: then nothing is seen that lets light
     * through, or it is not followed any more; and they may be one list, where no material both blends and transmits.
     * All are overwritten. */
    void (*spawn)(const daft_snapshot *snapshot, const daft_batch *points, const daft_spawning *allowed,
                  daft_ray_batch *mirrored, daft_ray_batch *refracted, daft_ray_batch *straight);
    /* The ids of a tile's pixels, rows `stride` apart. */
    void (*ids)(const daft_tile *tile, uint32_t *ids, size_t stride);
    void (*contrast)(const daft_neighbours *neighbours, const daft_contrast *limit, daft_edges *out);
    /* Adds the rays to be shaded of pixels of a part's row, bit x of column x, as long as there is room. Gives the
     * pixels that are left. */
    uint32_t (*take_edges)(const daft_edge_part *part, int y, uint32_t pixels, daft_edge_rays *out);
    /* The light of a list's samples in its order; and this, limited to 0..1, times the shares onto the pixels' sums;
     * `light` is overwritten. */
    void (*gather_light)(const daft_lanes3 *light, const daft_seen_list *list, daft_lanes3 *out);
    void (*add_light)(const daft_edge_rays *rays, daft_lanes3 *light, daft_lanes3 *sum);
    /* The corners of which two of the four pixels around, side by side, disagree and see different things. */
    void (*corners)(const daft_neighbours *neighbours, const daft_contrast *limit, uint32_t out[DAFT_TILE]);
    /* The words of the corners that a tile's rays were asked for, rows `stride` apart, room for whole rows; bits of
     * those that see what none of their pixels does. */
    void (*match_corners)(const daft_neighbours *neighbours, const daft_tile *tile, const uint32_t asked[DAFT_TILE],
                          uint32_t *words, size_t stride, uint32_t fresh[DAFT_TILE]);
    /* `words` as above; rgba: the tile's pixels, rows `pixel_stride` pixels apart. */
    void (*mix_corners)(const daft_tile *tile, const daft_corners *corners, const uint32_t *words, size_t stride,
                        const uint8_t *rgba, size_t pixel_stride, daft_mixed *out);
    /* Of the pixels x.., y..: the squares of their noise, into to_variance; from these from_variance, in which the
     * inverse of the number of rays is; and one pass of the filter. */
    void (*filter_noise)(const daft_filter *filter, int x, int y, int width, int height);
    void (*filter_spread)(const daft_filter *filter, int x, int y, int width, int height);
    void (*filter_pass)(const daft_filter *filter, int x, int y, int width, int height);
    /* The pixels x.., y.. of the grid. */
    void (*reuse)(const daft_reusing *reusing, int x, int y, int width, int height);
    /* The pixels x.., y.. of those that are enlarged to. */
    void (*enlarge)(const daft_enlarging *enlarging, int x, int y, int width, int height);
    /* What the points' light is more than `before` moves to `whole`; of the points of the bits also, side by side, to
     * `from`. */
    void (*take_light)(daft_batch *points, const daft_lanes3 *before, const uint32_t bits[DAFT_BATCH_WORDS],
                       daft_lanes3 *whole, daft_lanes3 *from);
    /* Before the first light is drawn; then of the lights in their order: which points ask it. */
    void (*sum_candidates)(daft_candidates *all, const daft_drawing *how);
    void (*draw_light)(daft_candidates *all, const daft_drawing *how, uint32_t light, daft_asking *out);
    /* Moves the bits of points that do not see the middle of an area that lights, from before it and above their
     * horizon, to `aside`; gives whether there are any. */
    bool (*skip_middle)(const daft_batch *points, const daft_light_source *light, uint32_t bits[DAFT_BATCH_WORDS],
                        uint32_t aside[DAFT_BATCH_WORDS]);
    /* Ray number[i] of rays[i] of point[i], for `count` of them, and its weight; 0: there is none. Writes whole
     * registers; `out` is 16-byte aligned. */
    void (*rectangle_rays)(const daft_area_rays *def, const uint32_t *point, const int32_t *number, const int32_t *rays,
                           uint32_t count, daft_ray *out, float *weight);
} daft_render_kernels;

DAFT_KERNEL_DECLARE(daft_render_kernels, daft_render);

#ifdef DAFT_ISA
void DAFT_KERNEL(daft_surfaces)(const daft_surfaces_def *def, const daft_tile *tile, daft_facets *facets,
                                daft_batch *points, daft_ray_batch *sky);
void DAFT_KERNEL(daft_listed_surfaces)(const daft_surfaces_def *def, const daft_seen_list *list, daft_facets *facets,
                                       daft_batch *points, daft_ray_batch *sky);
void DAFT_KERNEL(daft_hit_points)(const daft_snapshot *snapshot, const daft_ray_batch *rays, uint32_t first,
                                  const daft_hit *hits, uint32_t count, daft_facets *facets, daft_batch *points,
                                  daft_ray_batch *sky);
void DAFT_KERNEL(daft_tile_ids)(const daft_tile *tile, uint32_t *ids, size_t stride);
void DAFT_KERNEL(daft_find_contrast)(const daft_neighbours *neighbours, const daft_contrast *limit, daft_edges *out);
uint32_t DAFT_KERNEL(daft_take_edges)(const daft_edge_part *part, int y, uint32_t pixels, daft_edge_rays *out);
void DAFT_KERNEL(daft_gather_light)(const daft_lanes3 *light, const daft_seen_list *list, daft_lanes3 *out);
void DAFT_KERNEL(daft_add_light)(const daft_edge_rays *rays, daft_lanes3 *light, daft_lanes3 *sum);
void DAFT_KERNEL(daft_filter_noise)(const daft_filter *f, int x0, int y0, int width, int height);
void DAFT_KERNEL(daft_filter_spread)(const daft_filter *f, int x0, int y0, int width, int height);
void DAFT_KERNEL(daft_filter_pass)(const daft_filter *f, int x0, int y0, int width, int height);
void DAFT_KERNEL(daft_reuse)(const daft_reusing *r, int x0, int y0, int width, int height);
void DAFT_KERNEL(daft_enlarge)(const daft_enlarging *e, int x0, int y0, int width, int height);
void DAFT_KERNEL(daft_take_light)(daft_batch *points, const daft_lanes3 *before, const uint32_t bits[DAFT_BATCH_WORDS],
                                  daft_lanes3 *whole, daft_lanes3 *from);
void DAFT_KERNEL(daft_sum_candidates)(daft_candidates *all, const daft_drawing *how);
void DAFT_KERNEL(daft_draw_light)(daft_candidates *all, const daft_drawing *how, uint32_t light, daft_asking *out);
bool DAFT_KERNEL(daft_skip_middle)(const daft_batch *points, const daft_light_source *light,
                                   uint32_t bits[DAFT_BATCH_WORDS], uint32_t aside[DAFT_BATCH_WORDS]);
void DAFT_KERNEL(daft_rectangle_rays)(const daft_area_rays *def, const uint32_t *point, const int32_t *number,
                                      const int32_t *rays, uint32_t count, daft_ray *out, float *weight);
void DAFT_KERNEL(daft_find_corners)(const daft_neighbours *neighbours, const daft_contrast *limit,
                                    uint32_t out[DAFT_TILE]);
void DAFT_KERNEL(daft_match_corners)(const daft_neighbours *neighbours, const daft_tile *tile,
                                     const uint32_t asked[DAFT_TILE], uint32_t *words, size_t stride,
                                     uint32_t fresh[DAFT_TILE]);
void DAFT_KERNEL(daft_mix_corners)(const daft_tile *tile, const daft_corners *corners, const uint32_t *words,
                                   size_t stride, const uint8_t *rgba, size_t pixel_stride, daft_mixed *out);
#endif

#endif
