/* A tree's leaves by eights, for pencils that see all of a mesh in few pixels: there, three flat lists are quicker to look
 * through than a tree's levels one after the other. Groups of sixteen clusters, clusters of up to eight leaves that follow each
 * other in depth-first order, leaves' blocks: each has a ball around it, and how it looks away (sides.h). */
#ifndef DAFT_CLUSTERS_H
#define DAFT_CLUSTERS_H

#include "accel/balls.h"

enum { DAFT_CLUSTER_LEAVES = 8, DAFT_CLUSTER_GROUP = 16 };

/* look and spread as in daft_cones; leaf as a node's child, DAFT_CHILD_NONE beyond the last. */
typedef struct daft_cluster {
    daft_ball ball[DAFT_CLUSTER_LEAVES];
    uint32_t look[DAFT_CLUSTER_LEAVES];
    float spread[DAFT_CLUSTER_LEAVES];
    uint32_t leaf[DAFT_CLUSTER_LEAVES];
} daft_cluster;

/* Of clusters, or of groups; room for DAFT_CLUSTER_GROUP more, that sixteen may be read anywhere. */
typedef struct daft_outlines {
    uint32_t count;
    daft_ball *balls;
    uint32_t *looks;
    float *spreads;
    uint32_t *first; /* the first block of each, and of one more */
} daft_outlines;

typedef struct daft_clusters {
    daft_cluster *items;
    daft_outlines all, groups; /* of each cluster; of each DAFT_CLUSTER_GROUP of them */
} daft_clusters;

/* Leaves and balls; looks are left to daft_cones_fill. False: memory is out. */
bool daft_clusters_make(const daft_bvh *bvh, const daft_balls *balls, daft_clusters *out);
void daft_clusters_free(const daft_allocator *allocator, daft_clusters *clusters);
size_t daft_clusters_bytes(const daft_clusters *clusters);

#endif
