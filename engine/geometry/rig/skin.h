/* geometry/rig: poses of models with clips: sampling, blending, what a clip reaches, and skinning. Public headers:
 * none; geometry/rig.h has the functions. */
#ifndef DAFT_RIG_SKIN_H
#define DAFT_RIG_SKIN_H

#include "geometry/rig.h"
#include "math/simd/dispatch.h"

/* The pose's nodes, local: parts where a layer moves the node. */
typedef struct daft_rig_local {
    daft_rig_parts parts;
    bool moved;
} daft_rig_local;

struct daft_rig_space {
    daft_allocator allocator;
    daft_rig_local *local, *layer; /* of each node; of the layer that is being added */
    double *world, *joints;        /* 12 for each node and joint */
    double *weights, *layered;     /* of each target */
    bool *touched;                 /* of each target: by the layer that is being added */
    float *matrices;               /* 12 for each joint, for the kernel */
    daft_rig_points shifted[2];    /* vertices and normals with targets added: x, y, z alone; where there are targets */
};

typedef struct daft_rig_kernels {
    /* x, y, z: the padded outputs. What is not finite becomes 0. */
    void (*vertices)(const daft_rig_points *points, const float *matrices, float *x, float *y, float *z);
    /* Unit; 0, 1, 0 where there is no direction. */
    void (*normals)(const daft_rig_points *points, const float *matrices, daft_vec3 *out);
} daft_rig_kernels;

DAFT_KERNEL_DECLARE(daft_rig_kernels, daft_rig);

#endif
