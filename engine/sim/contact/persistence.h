/* What manifolds found anew have of those of the step before: impulses, friction, and where they are going. */
#ifndef DAFT_SIM_PERSISTENCE_H
#define DAFT_SIM_PERSISTENCE_H

#include "sim/world.h"

/* By how much of their last displacement contacts are put ahead, see persistence.c. */
float daft_sim_extrapolation(const daft_world *world, const daft_sim_pair *pair, float dt);

/* Manifolds of a pair, from those it had, of which there are at most DAFT_SIM_MAX_MANIFOLDS. */
void daft_sim_persist(daft_sim_manifold *fresh, uint32_t count, const daft_sim_manifold *old, uint32_t old_count,
                      float lead);

/* The same for a pair's own manifold, which is set in place, point by point: what it had. */
typedef struct daft_sim_persisted {
    daft_vec3 normal;
    float lead;
    uint32_t ids[DAFT_MANIFOLD_POINTS], count;
    uint32_t left; /* bits of its points that carried something and are not there any more, as far as is known */
    float impulses[DAFT_MANIFOLD_POINTS];
    daft_vec3 anchors[DAFT_MANIFOLD_POINTS];
} daft_sim_persisted;

void daft_sim_persisted_set(daft_sim_persisted *out, const daft_sim_manifold *manifold, uint32_t count, float lead);
void daft_sim_persisted_put(daft_sim_persisted *old, daft_sim_manifold *manifold, daft_sim_manifold_point point);
/* Points are in; the normal they were reached along is not asked for any more. */
void daft_sim_persisted_end(const daft_sim_persisted *old, daft_sim_manifold *manifold);

#endif
