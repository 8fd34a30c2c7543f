/* The kernels of each instruction set; frame.c picks. */
#ifndef DAFT_RENDER_KERNELS_H
#define DAFT_RENDER_KERNELS_H

#include "math/simd/dispatch.h"
#include "raster/raster.h"
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

static inline daft_apex daft_apex_of(const daft_light_source *light)
{
    return (daft_apex){.infinite = light->sun, .at = light->sun ? light->to_light : light->position};
}

/* Rays, side by side, with where they came from. */
typedef struct daft_ray_batch {
    uint32_t count;
    daft_lanes3 origin, direction; /* directions are unit */
    daft_lanes3 weight;
    float distance[DAFT_BATCH_ROOM];
    uint32_t pixel[DAFT_BATCH_ROOM];
} daft_ray_batch;

/* The different facets (triangles or spheres) that a batch's rays meet. Rows are the kernels' own: see
 * render/surface.h. */
enum { DAFT_FACET_FLOATS = 48 };
typedef struct daft_facets {
    uint32_t count;
    uint32_t traits, last_material; /* of their materials: all traits; the one that was looked at last */
    bool one_material;
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
 * their fraction of the pixel, do not count any more. */
typedef struct daft_spawning {
    bool mirrors;
    float min;
} daft_spawning;

typedef struct daft_render_kernels {
    /* Turns a tile's visible surfaces into points of weight 1, filling only the fields that the definition asks for.
     * The other pixels become sky rays, with directions where the sky has more than one colour. */
    void (*surfaces)(const daft_surfaces_def *def, const daft_tile *tile, daft_facets *facets, daft_batch *points,
                     daft_ray_batch *sky);
    /* Appends the points where the rays first.. hit, all of them set; misses are left out. */
    void (*hit_points)(const daft_snapshot *snapshot, const daft_ray_batch *rays, uint32_t first, const daft_hit *hits,
                       uint32_t count, daft_facets *facets, daft_batch *points);
    /* The rays that points send on. `refracted` may be NULL: then nothing is seen that transmits, or it is not followed
     * any more. Both are overwritten. */
    void (*spawn)(const daft_snapshot *snapshot, const daft_batch *points, const daft_spawning *allowed,
                  daft_ray_batch *mirrored, daft_ray_batch *refracted);
} daft_render_kernels;

DAFT_KERNEL_DECLARE(daft_render_kernels, daft_render);

#ifdef DAFT_ISA
void DAFT_KERNEL(daft_surfaces)(const daft_surfaces_def *def, const daft_tile *tile, daft_facets *facets,
                                daft_batch *points, daft_ray_batch *sky);
void DAFT_KERNEL(daft_hit_points)(const daft_snapshot *snapshot, const daft_ray_batch *rays, uint32_t first,
                                  const daft_hit *hits, uint32_t count, daft_facets *facets, daft_batch *points);
#endif

#endif
