/* points: batches of points where rays meet surfaces, and the rays that go on from there. This header: what the kernel
 * sources share, facets that a batch's rays meet, set up. Public headers: none */
#ifndef DAFT_SURFACE_H
#define DAFT_SURFACE_H

#include "math/simd/ops.h"
#include "render/kernels.h"

/* Floats of a row of daft_facets: a triangle's, in frame space, normals unit and on the viewer's side. edge k: the
 * plane of the eye and the edge opposite corner k; a camera ray's product with it, among the three, is the corner's
 * weight. */
enum {
    FACET_OUTWARD = 0, /* the plane's normal, unit, on the viewer's side */
    FACET_HEIGHT = 3,  /* of the plane over the rays' origin, against `outward`: 0 or less */
    FACET_LEAST = 4,   /* a ray's t lies between: the corners' range along it */
    FACET_MOST = 5,
    FACET_SIZE = 6, /* sum of the instance's translation, for the spawn error; a sphere's radius on top */
    FACET_WORD = 7, /* an integer: the material and FACET_... bits */
    FACET_EDGE = 8,
    FACET_NORMAL = 17,
    FACET_CORNER = 26,
    FACET_DENSITY = 35, /* units of uv a metre */
    FACET_UV = 36,
    FACET_COLOR = 42, /* of each corner, a word: see facet_color */
    FACET_ALPHA = 45, /* of each corner, where some mesh of the frame has any */
    /* Where rays begin anywhere, a row has what all of them share: `outward` on the side of the normals, or 0 on a
     * triangle without area; FACET_INNER where the outer side is the other one; and corners in place of what hangs on
     * the origin. */
    FACET_FIRST = 3,  /* corner 0 */
    FACET_OTHERS = 8, /* corners 1 and 2 */
    /* a sphere's */
    SPHERE_CENTRE = 0,
    SPHERE_RADIUS = 3,
    SPHERE_TURN = 8 /* the linear part of the map to object space */
};

#define FACET_SMOOTH     ((int32_t)0x80000000) /* its normals differ: the sign bit */
#define FACET_SPHERE     ((int32_t)0x40000000)
#define FACET_COLORED    ((int32_t)0x20000000) /* its corners have colours */
#define FACET_INNER      ((int32_t)0x10000000) /* a triangle whose inner side the rays see */
#define FACET_MATERIAL   0x0fffffff
#define FACET_COLOR_MOST 1023.0f /* a word has the square roots of red, green and blue, ten bits each */

DAFT_INLINE vf3 set3(daft_vec3 a) { return (vf3){vf_set(a.x), vf_set(a.y), vf_set(a.z)}; }
DAFT_INLINE vf3 add3(vf3 a, vf3 b) { return (vf3){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE vf3 sub3(vf3 a, vf3 b) { return (vf3){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE vf3 flipped3(vf3 a) { return (vf3){-a.x, -a.y, -a.z}; }
DAFT_INLINE vf3 scale3(vf3 a, vf s) { return (vf3){a.x * s, a.y * s, a.z * s}; }
DAFT_INLINE vf3 cross3(vf3 a, vf3 b)
{
    return (vf3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DAFT_INLINE vf3 select3(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_if_then_else(m, a.x, b.x), vf_if_then_else(m, a.y, b.y), vf_if_then_else(m, a.z, b.z)};
}
/* Zero stays zero. */
DAFT_INLINE vf3 unit3(vf3 a)
{
    vf length2 = vf3_dot(a, a);
    return scale3(a, vf_if_then_else(vf_lt(vf_set(0), length2), vf_set(1) / vf_sqrt(length2), vf_set(0)));
}
DAFT_INLINE vf3 load3(const daft_lanes3 *a, uint32_t at)
{
    return (vf3){vf_load(&a->x[at]), vf_load(&a->y[at]), vf_load(&a->z[at])};
}
DAFT_INLINE void store3(daft_lanes3 *out, uint32_t at, vf3 v)
{
    vf_store(&out->x[at], v.x), vf_store(&out->y[at], v.y), vf_store(&out->z[at], v.z);
}

DAFT_INLINE vf3 flip3(vf3 a, vm m)
{
    vi sign = vi_if_then_else(m, vi_set((int32_t)0x80000000), vi_set(0));
    return (vf3){vf_xor(a.x, sign), vf_xor(a.y, sign), vf_xor(a.z, sign)};
}

DAFT_INLINE void compress3(daft_lanes3 *out, uint32_t at, vbits lanes, vf3 v)
{
    vf_compress_store(&out->x[at], lanes, v.x), vf_compress_store(&out->y[at], lanes, v.y);
    vf_compress_store(&out->z[at], lanes, v.z);
}

/* ---- planes ---- */

typedef struct vd3 {
    vd x, y, z;
} vd3;
DAFT_INLINE vd vd3_dot(vd3 a, vd3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
DAFT_INLINE vd3 half3(vf3 a, int half)
{
    return (vd3){vd_promote_half(a.x, half), vd_promote_half(a.y, half), vd_promote_half(a.z, half)};
}
DAFT_INLINE vd3 vd3_sub(vd3 a, vd3 b) { return (vd3){a.x - b.x, a.y - b.y, a.z - b.z}; }
/* Of a plane through `corner` over the rays' origin. */
DAFT_INLINE vf plane_height(vf3 outward, vf3 corner, vf3 origin)
{
    vd height[2];
    for (int half = 0; half < 2; half++)
        height[half] = vd3_dot(half3(outward, half), vd3_sub(half3(corner, half), half3(origin, half)));
    return vf_demote2(height[0], height[1]);
}
/* The corners' range of t of rays along `unit`. */
DAFT_INLINE void corner_range(const vf3 corner[3], vf3 origin, vf3 unit, vf *min, vf *max)
{
    *min = vf_set(INFINITY), *max = vf_set(-INFINITY);
    for (int k = 0; k < 3; k++) {
        vf along = vf3_dot(sub3(corner[k], origin), unit);
        *min = vf_min(along, *min), *max = vf_max(along, *max);
    }
}

/* ---- lists of facets ---- */

enum { FINDER = 256 };

/* A cache from instance and triangle to facet, by hash: a triangle of several windows is set up once. */
typedef struct finder {
    const daft_snapshot *snapshot;
    daft_facets *facets;
    uint16_t slot[FINDER];
} finder;

/* Instances may stand anywhere in memory, too; numbers of corners are what is read first of a triangle. */
DAFT_INLINE void prefetch_facet(const daft_instance *s, uint32_t triangle)
{
    __builtin_prefetch(&s->to_object), __builtin_prefetch(&s->materials);
    if (!s->mesh) return;
    __builtin_prefetch(&s->mesh->indices[3 * (size_t)triangle]);
    if (s->mesh->normal_indices) __builtin_prefetch(&s->mesh->normal_indices[3 * (size_t)triangle]);
}

/* No branch hangs on whether the facet is a new one, which would be guessed wrong every other time. */
DAFT_INLINE int32_t find_slot(finder *f, uint32_t instance, uint32_t triangle)
{
    daft_facets *list = f->facets;
    uint32_t hash = (triangle * 0x9e3779b1u + instance * 0x85ebca6bu) >> 24, slot = f->slot[hash], fresh = list->count;
    bool known = (slot < fresh) & (list->instance[slot] == instance) & (list->triangle[slot] == triangle);
    list->instance[fresh] = instance, list->triangle[fresh] = triangle;
    list->count = fresh + !known;
    slot = known ? slot : fresh;
    f->slot[hash] = (uint16_t)slot;
    prefetch_facet(&f->snapshot->instances[instance], triangle);
    return (int32_t)slot;
}

/* Rays that meet a group's facets. `unit` is the vector along which t counts: t = 1 is as far as it is long. */
typedef struct facet_rays {
    vf3 origin, direction, unit;
} facet_rays;

/* Lists what a tile's pixels see: their points and their rays to the sky by number of pixel, in `facets` each facet
 * once, and in its slots each point's facet. */
void DAFT_KERNEL(daft_tile_facets)(const daft_snapshot *snapshot, const daft_tile *tile, daft_facets *facets,
                                   daft_batch *points, daft_ray_batch *sky);

/* The same of a list of samples; where their rays go is in u and v, or in the directions' x and y. */
void DAFT_KERNEL(daft_list_facets)(const daft_snapshot *snapshot, const daft_seen_list *list, daft_facets *facets,
                                   daft_batch *points, daft_ray_batch *sky);

/* Sets up the facets first..first + count of the list, at most DAFT_VL; adds to the list's traits. `rays` NULL: they
 * begin anywhere. */
void DAFT_KERNEL(daft_facets_setup)(const daft_snapshot *snapshot, daft_facets *facets, uint32_t first, uint32_t count,
                                    const facet_rays *rays);

/* The corners of the up to DAFT_VL facets from `first` on, which are anywhere, are on their way from memory before they
 * are set up. */
void DAFT_KERNEL(daft_facets_fetch)(const daft_snapshot *snapshot, const daft_facets *facets, uint32_t first);

#endif
