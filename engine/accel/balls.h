/* A ball around each block of triangles, or around more, which a pencil holds against its rays before it fetches the block. */
#ifndef DAFT_BALLS_H
#define DAFT_BALLS_H

#include "accel/bvh.h"

/* In units from the mesh's low corner: eight bytes, so that a leaf's are half a line of a cache. It holds the corners of the
 * block's triangles. */
typedef struct daft_ball {
    uint16_t centre[3], radius;
} daft_ball;

typedef struct daft_balls {
    daft_vec3 low;
    float unit;
    daft_ball *items; /* of each block, and DAFT_MAX_LEAF_BLOCKS more, that a leaf's may be read four at a time */
} daft_balls;

/* False: memory is out. */
bool daft_balls_make(const daft_bvh *bvh, const daft_trimesh *mesh, daft_balls *out);
/* The ball around some blocks, one after the other; the more steps (1 to 32), the smaller. */
void daft_ball_around(const daft_balls *balls, const daft_block *blocks, uint32_t count, int steps, daft_ball *out);
/* Puts the triangles of each leaf into blocks by where they are and look, for small balls that look one way. */
void daft_blocks_regroup(daft_bvh *bvh);

#endif
