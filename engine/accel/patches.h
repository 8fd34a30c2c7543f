/* A mesh as patches of up to sixteen neighbouring triangles with up to sixteen corners among them, for pencils that see all of it
 * in few pixels: a patch's corners are moved and projected once for all of its triangles, in one register where it is that
 * wide. Three flat lists lead to them, which there are quicker to look through than a tree's levels: balls around patches, clusters
 * of sixteen patches, groups of sixteen clusters, and how each of these looks away (sides.h). */
#ifndef DAFT_PATCHES_H
#define DAFT_PATCHES_H

#include "accel/bvh.h"

enum { DAFT_PATCH = 16, DAFT_PATCH_LEVELS = 3 };

/* corner: x, y and z of each, unused ones like the first. at: which of them are triangle i's corner k. Bits of triangles that
 * are there, and of those that are one-sided; numbers of those that are not there are DAFT_NO_TRIANGLE. edge: no less than the longest of
 * its triangles' edges. Five lines of a cache. */
typedef struct daft_patch {
    float corner[3][DAFT_PATCH];
    uint8_t at[3][DAFT_PATCH];
    uint16_t there, one_sided;
    float edge;
    uint32_t none[2];
    uint32_t triangle[DAFT_PATCH]; /* last: many are left out before their numbers are read */
} daft_patch;

/* Sixteen items of a level, side by side: all that one of the level above consists of. ball: the centre's x, y and z, then the radius, whole
 * numbers of units from the mesh's low corner; it holds all corners of what it is around. look, spread: as in daft_cones, the bytes as
 * floats. What is unpacked is read without a step between. */
typedef struct daft_outlines {
    float ball[4][DAFT_PATCH], look[4][DAFT_PATCH], spread[DAFT_PATCH];
} daft_outlines;

/* Of patches, clusters or groups: items 16·i and so on of one level are what item i of the one above consists of. */
typedef struct daft_outline_level {
    uint32_t count;
    daft_outlines *items; /* by sixteen */
} daft_outline_level;

/* An ellipsoid around each of sixteen patches, about the middle of its ball: x within it has x·M⁻¹·x <= 1, with M in units squared. M's xx,
 * yy, zz, xy, xz and yz. */
enum { DAFT_SHAPE = 6 };
typedef struct daft_shapes {
    float m[DAFT_SHAPE][DAFT_PATCH];
} daft_shapes;

typedef struct daft_patches {
    daft_vec3 low;
    float unit;
    float edge, radius; /* the largest of a patch, and, in units, of a patch's ball */
    daft_patch *items;
    daft_shapes *shapes;                         /* by sixteen */
    daft_outline_level level[DAFT_PATCH_LEVELS]; /* 0: of each patch */
} daft_patches;

/* The middle of item i's ball, in units. */
static inline daft_dvec3 daft_outline_middle(const daft_outline_level *level, uint32_t i)
{
    const daft_outlines *o = &level->items[i / DAFT_PATCH];
    uint32_t lane = i % DAFT_PATCH;
    return daft_dv3((double)o->ball[0][lane], (double)o->ball[1][lane], (double)o->ball[2][lane]);
}

struct daft_adjacency;
/* one_sided: a bit for each triangle, 32 in a word. Looks are left to daft_cones_fill. False: memory is out. */
bool daft_patches_make(const daft_bvh *bvh, const daft_trimesh *mesh, const struct daft_adjacency *adjacency, const uint32_t *one_sided, daft_patches *out);
void daft_patches_free(const daft_allocator *allocator, daft_patches *patches);
size_t daft_patches_bytes(const daft_patches *patches);

#endif
