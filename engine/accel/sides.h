/* Which triangles are only ever seen from their front, and which parts of a tree look away from where they are seen.
 *
 * A ray that starts outside a closed mesh (where its winding number is 0) and meets a triangle first, from its back, comes from a
 * place with winding number 0 behind that triangle. Where the winding number behind a triangle is another, that cannot be:
 * the triangle is one-sided. sides.c and winding.c find these, cones.c which nodes' triangles all look away.
 *
 * Who may pass over what looks away: a pencil whose origin is outside the mesh and whose rays ask for the nearest hit, or
 * for any hit on the way from the origin. daft_outlook_from says whether it is. A one-sided triangle that the origin sees
 * from its back then need not be tested, in as far as some other triangle, met before, is tested. */
#ifndef DAFT_SIDES_H
#define DAFT_SIDES_H

#include "accel/patches.h"

/* How a triangle looks: its unit normal, times 127, in signed bytes from the lowest on, and last, rounded down, 127 times the least
 * normal·(p - middle) of its points over the mesh's radius; 0, 0, 0, -128 where it is of two sides or too thin. It
 * is one-sided and looks away from an outlook if, in floats, with its glance (daft_glance, below)
 *     n[0]·x + n[1]·y + n[2]·z + margin < n[3]·step
 * Bytes of a normal are off by a half each, so that normal·v is off by less than 0.87·|v|/127. Corners that are off by
 * `blur`, in a triangle of longest edge L and least height h, turn L·h times its normal by 2·blur·2L + 4·blur² at most and
 * move it by blur; with blur <= L/2 and h < 1.8·reach both are within reach·8·blur/h, and beyond L/2 that is too much for any
 * to look away. The test's own rounding is below 2^-18 of the reach.
 *
 * What is kept is the same of many: of a node's children here, of patches, clusters and groups there (patches.h). All triangles
 * of one are one-sided and look away from an outlook if
 *     n[0]·x + n[1]·y + n[2]·z + margin + spread·reach < n[3]·step
 * With the triangles' unit normals within an angle s of the unit axis a, p any point on a triangle and v from some point o to
 * the origin, normal·(origin - p) <= cos(s)·(a·v) + sin(s)·|v| - normal·(p - o): n is cos(s)·a, spread 127·sin(s), and the
 * last byte of axis·o + the least normal·(p - o). A line of a cache for each node. */
typedef struct daft_cones {
    uint32_t look[DAFT_WIDTH];
    float spread[DAFT_WIDTH];
} daft_cones;

/* 27 bytes for each triangle, of which patches are 23. */
typedef struct daft_sides {
    uint32_t triangle_count, count; /* of the mesh's; of one-sided ones */
    daft_dvec3 middle;              /* of the mesh's bounds: outlooks and offsets count from here */
    uint8_t *blocks;     /* of each block, bits 0 to 3: its triangles that are one-sided, unused places like the last used */
    uint32_t *triangles; /* the same by triangle, 32 in a word */
    daft_cones *cones;   /* of each node */
    daft_patches patches;
    float radius;        /* no less than from the middle to any point of the mesh */
    float thinness;      /* one over a least height: thinner triangles count as too thin for looks */
} daft_sides;

/* From where a mesh is looked at, in the mesh's own space: a point less sides.middle, w = 1; or the direction towards a
 * light at infinity, w = 0. */
typedef struct daft_outlook {
    float x, y, z, w;
    float reach; /* no less than the distance to any point of the mesh; or the direction's length */
    float blur;  /* no less than any corner is moved by rounding, in the mesh's space */
} daft_outlook;

/* An outlook on a mesh that has sides. `blur` as above, finite. False: the point is not surely outside the mesh. */
bool daft_outlook_at(const daft_bvh *bvh, const daft_trimesh *mesh, daft_dvec3 point, double blur, daft_outlook *out);
/* From infinitely far: always outside. */
daft_outlook daft_outlook_along(daft_dvec3 direction, double blur);
/* From the origin of the space that `map` leads to, where corners are what daft_affine_point gives. *front: the sign of
 * det(a, b, c) of the moved corners of a triangle that is seen from its front. False, and *front is 0: not surely outside, or
 * the map is singular. */
bool daft_outlook_from(const daft_bvh *bvh, const daft_trimesh *mesh, const daft_affine *map, daft_outlook *out, int *front);

/* An outlook as looks are held against it. */
typedef struct daft_glance {
    float x, y, z, step, margin, reach;
} daft_glance;

static inline daft_glance daft_glance_of(const daft_sides *sides, const daft_outlook *o)
{
    float margin = o->reach * (0.875f + 127 * (0x1p-18f + 8 * sides->thinness * o->blur));
    return (daft_glance){o->x, o->y, o->z, sides->radius * o->w, margin, o->reach};
}

/* Whether what has this look and spread looks away. The kernels compute the same in lanes. */
static inline bool daft_looks_away(uint32_t look, float spread, const daft_glance *g)
{
    float x = (float)(int8_t)look, y = (float)(int8_t)(look >> 8), z = (float)(int8_t)(look >> 16), k = (float)(int8_t)(look >> 24);
    return x * g->x + y * g->y + z * g->z + g->margin + spread * g->reach < k * g->step;
}

/* Bits of the children that look away. */
static inline uint32_t daft_cones_away(const daft_cones *c, const daft_glance *g)
{
    uint32_t away = 0;
    for (uint32_t i = 0; i < DAFT_WIDTH; i++) away |= (uint32_t)daft_looks_away(c->look[i], c->spread[i], g) << i;
    return away;
}

static inline bool daft_is_one_sided(const daft_sides *sides, uint32_t triangle)
{
    return sides->triangles[triangle / 32] >> (triangle % 32) & 1;
}

#endif
