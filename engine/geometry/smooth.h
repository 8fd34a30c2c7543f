/* What smooth normals share with their kernel, which looks at triangles in the order in which they come. */
#ifndef DAFT_SMOOTH_H
#define DAFT_SMOOTH_H

#include "geometry/trimesh.h"
#include "math/isa.h"

typedef struct daft_smooth_face {
    daft_vec3 normal; /* unit length, zero without area */
    float angles[3];  /* at the corners, radians */
} daft_smooth_face;

/* Sums over the corners at a vertex, by the order of the corners. */
typedef struct daft_smooth_sum {
    double weighted[3]; /* normals by their angles */
    uint64_t links;     /* hashes of the next vertices less those of the previous: 0 where each is both as often */
    float plain[3];     /* normals */
    float count;        /* exact up to 2^24 */
} daft_smooth_sum;

typedef struct daft_smooth_kernels {
    /* Fills a face for each triangle and adds it to the sums, which were zero, of its three vertices. */
    void (*add_faces)(const daft_trimesh *mesh, daft_smooth_face *faces, daft_smooth_sum *sums);
} daft_smooth_kernels;

DAFT_KERNEL_DECLARE(daft_smooth_kernels, daft_smooth);

#endif
