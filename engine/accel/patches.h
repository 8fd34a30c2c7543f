/* A mesh as patches of up to sixteen neighbouring triangles with up to sixteen corners among them, for pencils that see all of it
 * in few pixels: a patch's corners are moved and projected once for all of its triangles, in one register where it is that
 * wide. Three flat lists lead to them, which there are quicker to look through than a tree's levels: balls around patches, clusters
 * of sixteen patches, groups of sixteen clusters, and how each of these looks away (sides.h). */
#ifndef DAFT_PATCHES_H
#define DAFT_PATCHES_H

#include "accel/bvh.h"

enum { DAFT_PATCH = 16, DAFT_PATCH_LEVELS = 3 };

/* corner: x, y and z of each, unused ones like the first. at: which of them are triangle i's corner k. Bits of triangles that
 * are there, and of those that are one-sided; numbers of those that are not there are DAFT_NO_TRIANGLE. Five lines of a cache. */
typedef struct daft_patch {
    float corner[3][DAFT_PATCH];
    uint8_t at[3][DAFT_PATCH];
    uint32_t triangle[DAFT_PATCH];
    uint16_t there, one_sided;
    uint32_t none[3];
} daft_patch;

/* In units from the mesh's low corner. It holds all corners of what it is around. */
typedef struct daft_ball {
    uint16_t centre[3], radius;
} daft_ball;

/* Of patches, clusters or groups: item i of one level is items 16·i and so on of the one below. look and spread as in daft_cones.
 * Room for sixteen more, that so many may be read anywhere. */
typedef struct daft_outlines {
    uint32_t count;
    daft_ball *balls;
    uint32_t *looks;
    float *spreads;
} daft_outlines;

/* An ellipsoid around each patch, about the middle of its ball: x within it has x·M⁻¹·x <= 1, with M in units squared. M's xx, yy, zz,
 * xy, xz and yz, by patches, with the same room. */
enum { DAFT_SHAPE = 6 };

typedef struct daft_patches {
    daft_vec3 low;
    float unit;
    daft_patch *items;
    float *shape[DAFT_SHAPE];
    daft_outlines level[DAFT_PATCH_LEVELS]; /* 0: of each patch */
} daft_patches;

struct daft_adjacency;
/* one_sided: a bit for each triangle, 32 in a word. Looks are left to daft_cones_fill. False: memory is out. */
bool daft_patches_make(const daft_bvh *bvh, const daft_trimesh *mesh, const struct daft_adjacency *adjacency, const uint32_t *one_sided, daft_patches *out);
void daft_patches_free(const daft_allocator *allocator, daft_patches *patches);
size_t daft_patches_bytes(const daft_patches *patches);

#endif
