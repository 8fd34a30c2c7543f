/* What glows of a mesh, summed up (glow_sum.c), for the lights that stand in for it (glow.c). */
#ifndef DAFT_SCENE_GLOW_H
#define DAFT_SCENE_GLOW_H

#include "scene/scene.h"

enum { DAFT_GLOW_SLANTS = 12 };

/* Of the triangles of some slots: what faces 2·axis (up) and 2·axis + 1 (down), along axes of their own and in square
 * metres; and the sums of their areas and of their normals' sizes times these by how they are slanted, of which the
 * surface of the mesh is made when it is stretched. Places are along the axes, from the mesh's origin. */
struct daft_glow {
    daft_glow *next;
    uint64_t slots;     /* which: a hash */
    daft_dvec3 axes[3]; /* unit, at right angles, right-handed, in the mesh's space */
    double area, facing[6], slanted[DAFT_GLOW_SLANTS];
    daft_dvec3 slants[DAFT_GLOW_SLANTS];
    daft_dvec3 middle, middles[6]; /* middles of triangles, times these areas */
    daft_dvec3 low, high;          /* bounds; low > high where there is no triangle */
    double areas[];                /* of each slot */
};

/* `glows`: whether each slot of the mesh, of one at least, does. NULL: memory is out. The caller's. */
daft_glow *daft_glow_sum(const daft_allocator *allocator, const daft_trimesh *mesh, const bool *glows);

#endif
