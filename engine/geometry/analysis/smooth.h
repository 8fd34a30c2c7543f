/* geometry/analysis: smooth normals, and what is odd about a mesh. Public headers: none; geometry/mesh.h has the
 * functions.
 *
 * What smooth normals share with their kernel, which looks at triangles in the order in which they come. */
#ifndef DAFT_SMOOTH_H
#define DAFT_SMOOTH_H

#include "geometry/trimesh.h"
#include "math/simd/dispatch.h"

/* Of each triangle, in arrays of their own: later passes read mostly the normals. */
typedef struct daft_smooth_faces {
    daft_vec3 *normals; /* unit length, zero without area */
    float *angles;      /* at the three corners, radians */
} daft_smooth_faces;

/* Sums over the corners at a vertex, by the order of the corners. */
typedef struct daft_smooth_sum {
    double weighted[3]; /* normals by their angles */
    uint64_t links;     /* hashes of the next vertices less those of the previous: 0 where each is both as often */
    float plain[3];     /* normals */
    float count;        /* exact up to 2^24 */
} daft_smooth_sum;

/* Filled only where some vertex is listed. Corners by vertex: those of vertex v stand at corners[first[v] .. first[v +
 * 1] - 1], in the order of the triangles. */
typedef struct daft_smooth_lists {
    uint8_t *listed;   /* 0: the vertex has none here, since all its corners are one set */
    uint32_t *first;   /* vertex_count + 1 */
    uint32_t *corners; /* DAFT_SMOOTH_AHEAD more than there are, all some corner */
} daft_smooth_lists;

/* Around a vertex of up to so many corners they are looked at side by side; so far behind them the list is read. */
enum { DAFT_SMOOTH_RING = 8, DAFT_SMOOTH_AHEAD = 40 };

typedef struct daft_smooth_kernels {
    /* Fills faces and adds each to the sums, which were zero, of its three vertices. */
    void (*add_faces)(const daft_trimesh *mesh, daft_smooth_faces faces, daft_smooth_sum *sums);
    /* Of the vertices first to end - 1, unlists each whose few corners are passed by going once around, from triangle
     * to triangle, with at most one edge between that is a crease: no flatter than the angle of `cosine`, or between
     * different groups or of group 0 (groups may be NULL). */
    void (*unlist_rings)(const daft_trimesh *mesh, const daft_vec3 *normals, const uint32_t *groups, float cosine,
                         const daft_smooth_lists *lists, uint32_t first, uint32_t end);
    /* The directions of weighted sums; some unit vector for those that have none. */
    void (*normalize)(const daft_smooth_sum *sums, size_t count, daft_vec3 *out);
} daft_smooth_kernels;

const daft_smooth_kernels *daft_smooth_kernels_for(int isa);

DAFT_KERNEL_DECLARE(daft_smooth_kernels, daft_smooth);

#endif
