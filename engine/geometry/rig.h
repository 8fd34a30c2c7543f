/* Rigs: what moves the vertices of a model that has clips. A hierarchy of nodes; joints, which carry vertices by up to
 * four weights (linear blend skinning); morph targets, which move vertices before that; and clips, keys of the nodes'
 * transforms and of the targets' weights. A part that hangs on a node without a skin has one joint, the node itself.
 *
 * Poses are computed in double and rounded once to a matrix for each joint; the vertices are moved by these in lanes
 * (rig/skin_kernel.c), with the same bits on every instruction set. */
#ifndef DAFT_RIG_H
#define DAFT_RIG_H

#include "geometry/mesh.h"

enum { DAFT_RIG_WEIGHTS = 4, DAFT_RIG_BLOCK = 16, DAFT_RIG_LAYERS = 4 };
#define DAFT_RIG_NONE UINT32_MAX

/* A transform taken apart: scale first, then rotation, then position. The rotation is unit. */
typedef struct daft_rig_parts {
    double position[3], rotation[4], scale[3];
} daft_rig_parts;

typedef struct daft_rig_node {
    uint32_t parent;      /* stands before it; DAFT_RIG_NONE: none */
    double rest[12];      /* to the parent's axes: three rows */
    daft_rig_parts parts; /* of rest; what is skewed is lost in them */
} daft_rig_node;

typedef struct daft_rig_joint {
    uint32_t node;
    double offset[12]; /* from the vertices' axes to the node's */
} daft_rig_joint;

/* Vertices, or normals, with what carries them. All arrays are padded with zeros to a multiple of DAFT_RIG_BLOCK. */
typedef struct daft_rig_points {
    uint32_t count;
    float *x, *y, *z;
    int32_t *joints[DAFT_RIG_WEIGHTS];
    float *weights[DAFT_RIG_WEIGHTS]; /* 0 or more; of a point they sum to 1 */
    uint8_t *most;                    /* of each block: how many weights its points use at most */
} daft_rig_points;

/* What a target adds to a point at a weight of 1. */
typedef struct daft_rig_shift {
    uint32_t point;
    daft_vec3 by;
} daft_rig_shift;

typedef struct daft_rig_target {
    float rest; /* weight where no clip says another */
    daft_rig_shift *vertices, *normals;
    uint32_t vertex_count, normal_count;
} daft_rig_target;

typedef enum daft_rig_channel {
    DAFT_RIG_POSITION,
    DAFT_RIG_ROTATION,
    DAFT_RIG_SCALE,
    DAFT_RIG_WEIGHT
} daft_rig_channel;

/* Between two keys. */
typedef enum daft_rig_between {
    DAFT_RIG_LINEAR, /* rotations: on the shorter arc */
    DAFT_RIG_STEP,   /* as at the key before */
    DAFT_RIG_CUBIC   /* Hermite's spline of values and tangents; rotations are made unit afterwards, as glTF says */
} daft_rig_between;

/* Keys of one channel, constant before the first and after the last. */
typedef struct daft_rig_track {
    daft_rig_channel channel;
    daft_rig_between between;
    uint32_t of;     /* the node; of a weight: the target */
    uint32_t count;  /* at least 1 */
    float *times;    /* seconds, ascending, 0 or more */
    float *values;   /* daft_rig_width(channel) for each key; rotations x, y, z, w, unit */
    float *tangents; /* cubic: two of each key, of arriving at it and of leaving it, in a second; else NULL */
} daft_rig_track;

typedef struct daft_rig_clip {
    char *name;
    double duration; /* seconds */
    daft_rig_track *tracks;
    uint32_t track_count;
    daft_vec3 low, high; /* all that the model reaches in it */
} daft_rig_clip;

typedef struct daft_rig {
    daft_rig_node *nodes;
    daft_rig_joint *joints;
    daft_rig_target *targets;
    daft_rig_clip *clips;
    uint32_t node_count, joint_count, target_count, clip_count;
    daft_rig_points vertices, normals; /* in the order of the mesh's */
} daft_rig;

/* A clip at a time, and how much of it there is over the layers before: 0..1. The first one's weight counts as 1. */
typedef struct daft_rig_layer {
    uint32_t clip;
    double time; /* seconds, 0 to the clip's duration */
    double weight;
} daft_rig_layer;

/* a·b, of matrices of three rows whose fourth is 0, 0, 0, 1. */
void daft_rig_multiply(const double a[12], const double b[12], double out[12]);
/* Of the cubic between keys k and k + 1, component i: the two inner control points of its Bezier form, in whose hull
 * with the two values it lies. */
void daft_rig_controls(const daft_rig_track *track, uint32_t k, uint32_t i, double out[2]);
/* NULL is fine. */
void daft_rig_free(const daft_allocator *allocator, daft_rig *rig);
size_t daft_rig_bytes(const daft_rig *rig);
static inline uint32_t daft_rig_width(daft_rig_channel channel)
{
    return channel == DAFT_RIG_ROTATION ? 4 : channel == DAFT_RIG_WEIGHT ? 1 : 3;
}
/* Arrays for `count` points, zero. False: memory is out; what there is, is still the rig's to free. */
bool daft_rig_points_make(const daft_allocator *allocator, daft_rig_points *points, uint32_t count);
/* Fills `most`. */
void daft_rig_points_measure(daft_rig_points *points);
/* Fills the bounds of all clips, once the rest of the rig is there: they hold at every time of a clip, not only at
 * keys. */
bool daft_rig_bound(const daft_allocator *allocator, daft_rig *rig, daft_error *error);

/* What poses of one model are computed in. */
typedef struct daft_rig_space daft_rig_space;
daft_rig_space *daft_rig_space_make(const daft_allocator *allocator, const daft_rig *rig, daft_error *error);
void daft_rig_space_free(daft_rig_space *space); /* NULL is fine */

/* The pose of the layers, none of them: at rest. */
void daft_rig_pose(const daft_rig *rig, const daft_rig_layer *layers, uint32_t count, daft_rig_space *space);
/* A joint's matrix in the pose that was computed last. */
const double *daft_rig_joint_matrix(const daft_rig_space *space, uint32_t joint);
/* Moves x, y, z and normals of the mesh, which has as many as the rig, to the pose that was computed last, and sets its
 * bounds. */
void daft_rig_skin(const daft_rig *rig, daft_rig_space *space, int isa, daft_trimesh *mesh);

#endif
