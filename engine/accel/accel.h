/* accel: bounding volume hierarchies over triangles and over instances, and rays through them.
 * Promises: binned-SAH builds in O(n log n) with bounded depth whatever the input; traversal that never misses a box by
 * rounding; the same hit on every instruction set. Rays are moved into each object's space, never objects into the
 * world's.
 *
 * Public headers: accel.h bvh.h bound_lanes.h kdtree.h. Inner headers: ray_test.h reach.h.
 * build/ makes the trees, traverse/ takes rays through them. */
#ifndef DAFT_ACCEL_H
#define DAFT_ACCEL_H

#include "base/base.h"
#include "geometry/mesh.h"
#include "math/vec.h"

#include <math.h>

typedef struct daft_bvh daft_bvh;

typedef struct daft_bvh_def {
    int threads;
    int isa; /* of the builder's kernels; the tree is the same for any */
} daft_bvh_def;

/* Over a mesh's triangles. The mesh must outlive it. NULL when memory is out. A mesh without triangles is fine. */
daft_bvh *daft_bvh_build(const daft_allocator *allocator, const daft_trimesh *mesh, const daft_bvh_def *def,
                         daft_error *error);
/* The same with the best instruction set. */
daft_bvh *daft_bvh_build_mesh(const daft_allocator *allocator, const daft_trimesh *mesh, int threads,
                              daft_error *error);
/* The mesh's vertices have moved, its triangles are the same: refits the boxes, or rebuilds the tree where its cost has
 * grown (then true). Cannot fail: without memory the fitted tree stays. */
bool daft_bvh_update(daft_bvh *bvh, const daft_trimesh *mesh, const daft_bvh_def *def);
/* Another of the same mesh, in memory of its own. NULL: memory is out. */
daft_bvh *daft_bvh_copy(const daft_allocator *allocator, const daft_bvh *bvh);
void daft_bvh_free(daft_bvh *bvh);
size_t daft_bvh_bytes(const daft_bvh *bvh);

/* The other accelerator, for single rays alone: finds the same hits, bit for bit. The same for any number of threads.
 */
typedef struct daft_kdtree daft_kdtree;
daft_kdtree *daft_kdtree_build(const daft_allocator *allocator, const daft_trimesh *mesh, int threads,
                               daft_error *error);
void daft_kdtree_free(daft_kdtree *tree);
size_t daft_kdtree_bytes(const daft_kdtree *tree);

enum {
    DAFT_INSTANCE_CASTS_SHADOW = 1,
    DAFT_INSTANCE_CONVEX = 2,         /* no point of it that faces a light lies in its own shadow */
    DAFT_INSTANCE_TINTS_SHADOW = 4,   /* in place of CASTS_SHADOW: some of the light comes through */
    DAFT_INSTANCE_FILTERS_SHADOW = 8, /* in place of either: it has surfaces with alpha, each hit says what passes */
    DAFT_INSTANCE_TRANSMITS = 16      /* some of its materials do, whatever shadow it casts */
};

/* What is known of the alpha at any point of a triangle. */
enum { DAFT_OPACITY_MIXED, DAFT_OPACITY_OPAQUE, DAFT_OPACITY_CLEAR };

/* Where the alpha of one of a mesh's slots is known, for hits on its mixed triangles: a grid over the texture (Gruen,
 * Benthin, Woop, "Sub-triangle opacity masks for faster ray tracing of transparent objects", 2020, with the grid in the
 * texture, so that triangles share it). A cell says what all places in it and `slack_u`, `slack_v` around it have: a
 * DAFT_OPACITY_…, as rays find it, who read the finest level; and of what is clear, where alpha is 0, how large a pixel
 * may be that is sure to find 0 as well: DAFT_OPACITY_CLEAR + k stands for 2^k texels a side. */
enum { DAFT_MASK_CELLS = 8, DAFT_MASK_BITS = 32 / DAFT_MASK_CELLS, DAFT_MASK_HOLES = 5 };
typedef struct daft_mask {
    const uint32_t *cells; /* DAFT_MASK_CELLS in a word, the first in its lowest bits; rows from the top. NULL: none, */
    bool even;             /* and all hits let through the same; or nothing is known */
    int columns, rows;
    float width, height;    /* of the texture, in texels */
    float across, down;     /* and in cells: the last ones may stick out */
    float slack_u, slack_v; /* in widths and heights of the texture */
    uint32_t map, channel;  /* the texture, as materials number them, and its byte */
    float cutoff; /* 0..: of the texture's alpha, from where on there is something; 0: it blends, or all is there */
    float scale_u, scale_v, offset_u, offset_v; /* of a mesh's coordinates, whose v goes up */
    uint32_t wrap;                              /* a daft_wrap */
} daft_mask;

static inline float daft_mask_wrapped(float a, uint32_t wrap)
{
    if (wrap == DAFT_WRAP_REPEAT) return a - floorf(a);
    if (wrap == DAFT_WRAP_CLAMP) return fminf(fmaxf(a, 0), 1);
    const float twice = (a * 0.5f - floorf(a * 0.5f)) * 2;
    return fminf(twice, 2 - twice);
}

/* The cell at a place of the texture, rows from the top; raster/masks.h does the same in lanes. */
static inline uint32_t daft_mask_cell(const daft_mask *m, float u, float v)
{
    const int column = (int)fminf(fmaxf(daft_mask_wrapped(u, m->wrap) * m->across, 0), (float)(m->columns - 1)),
              row = (int)fminf(fmaxf(daft_mask_wrapped(v, m->wrap) * m->down, 0), (float)(m->rows - 1));
    const uint32_t cell = (uint32_t)(row * m->columns + column);
    return m->cells[cell / DAFT_MASK_CELLS] >> DAFT_MASK_BITS * (cell % DAFT_MASK_CELLS) & ((1u << DAFT_MASK_BITS) - 1);
}

/* What is drawn or hit: a mesh or, with mesh NULL, a sphere around to_frame's translation. */
typedef struct daft_instance {
    const daft_trimesh *mesh;
    const daft_bvh *bvh;
    const daft_kdtree *kdtree; /* NULL: single rays go through bvh */
    daft_affine to_frame;      /* object space to frame space */
    daft_affine to_object;     /* its inverse */
    float radius;              /* sphere, in frame space (scale applied) */
    daft_vec3 low, high;       /* bounds in frame space */
    const uint32_t *materials; /* material index of each of the mesh's slots; a sphere has one slot */
    uint32_t entity, order;    /* the caller's: only carried; the second grows along a list of instances */
    uint64_t shape;            /* of the mesh, its tree and its vertices: no others had or will have it */
    const uint8_t *opacity;    /* of each triangle, a DAFT_OPACITY_…; NULL: all are mixed */
    const daft_mask *masks;    /* of each slot; NULL: nothing is known of mixed triangles */
    uint32_t flags;
} daft_instance;

/* Computes low and high, from its bvh where there is one: tight also for a mesh that lies across its own axes or the
 * frame's. */
void daft_instance_bound(daft_instance *instance);

typedef struct daft_tlas_def {
    daft_intersection intersection; /* how rays meet triangles */
    int threads;
    int isa; /* as in daft_bvh_def */
} daft_tlas_def;

/* Two-level: a BVH over instances. Built anew each frame; memory from the arena. */
typedef struct daft_tlas daft_tlas;
typedef struct daft_node daft_node; /* bvh.h */
const daft_tlas *daft_tlas_build_for(daft_arena *arena, const daft_instance *instances, uint32_t count,
                                     const daft_tlas_def *def, daft_error *error);
/* The same, for exact intersection, with one thread. */
const daft_tlas *daft_tlas_build(daft_arena *arena, const daft_instance *instances, uint32_t count, daft_error *error);

typedef struct daft_ray {
    daft_vec3 origin;
    float tmin;
    daft_vec3 direction; /* any length; t is in units of it */
    float tmax;
} daft_ray;

typedef struct daft_hit {
    float t;           /* the ray's tmax when nothing was hit */
    float u, v;        /* barycentric weights of the triangle's second and third corner */
    uint32_t instance; /* UINT32_MAX: nothing */
    uint32_t triangle;
    daft_vec3 normal; /* geometric, frame space, not normalised, not turned to the ray */
} daft_hit;

/* One of all the hits of a ray. */
typedef struct daft_pierced {
    uint32_t instance, triangle; /* triangle: 0 of a sphere */
    float t, u, v;               /* as in daft_hit; u and v are 0 on a sphere */
} daft_pierced;

/* False: no more is asked. */
typedef bool daft_pierced_at(void *user, const daft_pierced *hit);

/* A leaf of an instance's tree; instance DAFT_NO_LEAF: none. */
#define DAFT_NO_LEAF UINT32_MAX
typedef struct daft_pierced_leaf {
    uint32_t instance, child;
} daft_pierced_leaf;

/* Sixteen rays side by side. */
enum { DAFT_PACKET = 16 };
typedef struct daft_ray_packet {
    float origin[3][DAFT_PACKET], direction[3][DAFT_PACKET], tmin[DAFT_PACKET], tmax[DAFT_PACKET];
} daft_ray_packet;

static inline void daft_ray_packet_set(daft_ray_packet *packet, uint32_t lane, const daft_ray *ray)
{
    packet->origin[0][lane] = ray->origin.x, packet->origin[1][lane] = ray->origin.y,
    packet->origin[2][lane] = ray->origin.z;
    packet->direction[0][lane] = ray->direction.x, packet->direction[1][lane] = ray->direction.y;
    packet->direction[2][lane] = ray->direction.z;
    packet->tmin[lane] = ray->tmin, packet->tmax[lane] = ray->tmax;
}

/* Rays in arrays, from their origins to infinity. */
typedef struct daft_ray_arrays {
    const float *origin[3], *direction[3];
    const uint32_t *place;   /* numbers of pixels, DAFT_STRIP_ROW in a row: those of a strip of columns stay together */
    const uint16_t *numbers; /* of the rays that are asked for; NULL: all */
} daft_ray_arrays;
enum { DAFT_STRIP_ROW = 32 };

/* Kernels, compiled once per instruction set and picked by daft_accel_kernels(isa). */
typedef struct daft_accel_kernels {
    /* Nearest hit in tmin <= t <= tmax. `ignore`: an instance index to pass through, or UINT32_MAX. */
    bool (*closest)(const daft_tlas *tlas, const daft_ray *ray, uint32_t ignore, daft_hit *hit);
    /* Any-hit query: whether a shadow-casting instance occludes the ray. */
    bool (*occluded)(const daft_tlas *tlas, const daft_ray *ray);
    /* Sixteen rays of about one direction: bit i of `active` asks for ray i, and hits[i] becomes, bit for bit, what
     * `closest` finds; those of the others are not touched. Gives the bits of the rays that hit. */
    uint32_t (*closest_packet)(const daft_tlas *tlas, const daft_ray_packet *rays, uint32_t active, uint32_t ignore,
                               daft_hit hits[DAFT_PACKET]);
    /* The bits of the active rays that are occluded. */
    uint32_t (*occluded_packet)(const daft_tlas *tlas, const daft_ray_packet *rays, uint32_t active);
    /* Any number of rays, best in an order in which neighbours are similar: packets are made of rays of one octant.
     * hits[i] becomes what `closest` finds for rays[i]. */
    void (*closest_stream)(const daft_tlas *tlas, const daft_ray *rays, uint32_t count, uint32_t ignore,
                           daft_hit *hits);
    /* The same for `count` rays in arrays: hits[k] becomes what `closest` finds for ray k. */
    void (*closest_arrays)(const daft_tlas *tlas, const daft_ray_arrays *rays, uint32_t count, daft_hit *hits);
    /* Sets bit i % 32 of occluded[i / 32] for the rays that are occluded and clears it for the others. */
    void (*occluded_stream)(const daft_tlas *tlas, const daft_ray *rays, uint32_t count, uint32_t *occluded);
    /* Tells of each hit in tmin <= t <= tmax with the instances that have this flag but `ignore`, once for each
     * triangle and up to twice for a sphere, in an order that hangs on the trees alone. For
     * DAFT_INSTANCE_FILTERS_SHADOW triangles of DAFT_OPACITY_CLEAR are left out. Where `at` asks for no more within a
     * leaf of a mesh, that is written to *last, which may be NULL. */
    void (*pierce)(const daft_tlas *tlas, const daft_ray *ray, uint32_t flag, uint32_t ignore, daft_pierced_at *at,
                   void *user, daft_pierced_leaf *last);
    /* Tells of the hits in one leaf alone, which `pierce` gave for these instances. True: `at` asks for no more. */
    bool (*pierce_leaf)(const daft_tlas *tlas, const daft_ray *ray, const daft_pierced_leaf *leaf, daft_pierced_at *at,
                        void *user);
    /* Bits of the node's children that the ray meets in its interval, by their bounds; never those of an empty box. */
    uint32_t (*boxes)(const daft_node *node, const daft_ray *ray);
    /* daft_instance_bound for each instance, with the same bits. */
    void (*bound)(daft_instance *instances, uint32_t count);
} daft_accel_kernels;

const daft_accel_kernels *daft_accel_kernels_for(int isa);

#endif
