/* What manifolds found anew have of those of the step before: impulses, friction, and where they are going. */
#ifndef DAFT_SIM_INHERIT_H
#define DAFT_SIM_INHERIT_H

#include "sim/world.h"

/* By how much of their last way contacts are put ahead, see persistence.c. */
float daft_sim_lead(const daft_world *world, const daft_sim_touch *touch, float dt);

/* Patches of a touch, from those it had, of which there are at most DAFT_SIM_MAX_PATCHES. */
void daft_sim_inherit(daft_sim_patch *fresh, uint32_t count, const daft_sim_patch *old, uint32_t old_count, float lead);

/* The same for a touch's own patch, which is set in place, point by point: what it had. */
typedef struct daft_sim_kept {
    daft_vec3 normal;
    float lead;
    uint32_t ids[DAFT_MANIFOLD_POINTS], count;
    uint32_t left; /* bits of its points that carried something and are not there any more, as far as is known */
    float impulses[DAFT_MANIFOLD_POINTS];
    daft_vec3 anchors[DAFT_MANIFOLD_POINTS];
} daft_sim_kept;

void daft_sim_kept_set(daft_sim_kept *out, const daft_sim_patch *patch, uint32_t count, float lead);
void daft_sim_kept_put(daft_sim_kept *old, daft_sim_patch *patch, daft_sim_patch_point point);
/* Points are in; the normal they were reached along is not asked for any more. */
void daft_sim_kept_end(const daft_sim_kept *old, daft_sim_patch *patch);

#endif
