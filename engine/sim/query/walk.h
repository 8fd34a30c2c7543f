/* Walks through the broad phase for queries and characters. No other room includes this. */
#ifndef DAFT_SIM_WALK_H
#define DAFT_SIM_WALK_H

#include "sim/world.h"
#include "sim/query/query.h"

/* A box of half extents `reach`, its centre going from origin by motion. `end`: the fraction of the motion up to which
 * anything matters; visitors lower it, and a negative one ends the walk. */
typedef struct daft_sim_path {
    daft_dvec3 origin, motion, reach;
    double end;
} daft_sim_path;

/* Visits all parts that pass the filter and whose bounds the box meets before path->end, and perhaps more, in an
 * order that the visitor must not depend on. */
void daft_sim_walk(daft_world *world, daft_sim_path *path, const daft_sim_filter *filter, daft_sim_visit *visit,
                   void *context);
/* The box around a shape in a frame, which moves so. */
daft_sim_path daft_sim_path_of(const daft_sim_shape *shape, const daft_rigid *frame, daft_dvec3 motion);
/* The number of a part among those of its body. */
uint32_t daft_sim_part_ordinal(const daft_world *world, uint32_t part);

#endif
