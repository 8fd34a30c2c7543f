/* The frame that the boxes of a mesh's tree stand in, where the mesh's own fits its triangles badly (turn.c says when one is
 * taken). A point p of the mesh is seen there at m·(p - centre). Triangles stay as they are given and hits are decided by
 * them, so a hit does not depend on the frame, bit for bit: boxes only say where to look, and are never too small. */
#ifndef DAFT_TURN_H
#define DAFT_TURN_H

#include "geometry/mesh.h"
#include "math/vec.h"

typedef struct daft_turn {
    float m[9];      /* rows of length 1: no magnitude in it is over 1 */
    float centre[3]; /* of the mesh's box when the frame was found */
    float reach;     /* |x| + |y| + |z| of p - centre is no more for any vertex */
} daft_turn;

/* A frame in which the triangles' boxes are much smaller. False: there is none, a few of the triangles say; the best there is
 * is in out->m then. Depends on the mesh alone. */
bool daft_turn_find(const daft_trimesh *mesh, daft_turn *out);
/* The same for the boxes of nodes, by some of those of the tree as it is, which is not turned. out->m: one frame to try. */
struct daft_bvh;
bool daft_turn_find_grouped(const struct daft_bvh *bvh, const daft_trimesh *mesh, daft_turn *out);
/* The vertices have moved: what they reach now. False: so far, or so little, that the frame must be given up. */
bool daft_turn_fit(daft_turn *turn, const daft_trimesh *mesh);

/* A vertex, off by no more than 4·2^-24 of the reach on each axis: a difference, a product and two sums round, and no magnitude
 * in m is over 1. */
static inline daft_vec3 daft_turn_corner(const daft_turn *turn, daft_vec3 p)
{
    const float *m = turn->m, *c = turn->centre;
    daft_vec3 d = daft_v3(p.x - c[0], p.y - c[1], p.z - c[2]);
    return daft_v3(m[0] * d.x + m[1] * d.y + m[2] * d.z, m[3] * d.x + m[4] * d.y + m[5] * d.z, m[6] * d.x + m[7] * d.y + m[8] * d.z);
}

/* What boxes are grown by on each side, so that they hold the exact places of the corners: twice the error above. */
static inline float daft_turn_slack(const daft_turn *turn) { return turn->reach * 0x1p-21f; }

/* In double, off by a few 2^-53: a point, a direction, how far a box reaches with half these sides; and a point back. */
daft_dvec3 daft_turn_point(const daft_turn *turn, daft_dvec3 p);
daft_dvec3 daft_turn_vector(const daft_turn *turn, daft_dvec3 d);
daft_dvec3 daft_turn_reach(const daft_turn *turn, daft_dvec3 half);
daft_dvec3 daft_turn_back(const daft_turn *turn, daft_dvec3 q);
/* A box of the mesh's space to one that holds it. */
void daft_turn_box(const daft_turn *turn, daft_vec3 *low, daft_vec3 *high);

/* From the boxes' frame to where `map` takes the mesh's own. Each number is rounded once from double. */
daft_affine daft_turn_map(const daft_turn *turn, const daft_affine *map);

#endif
