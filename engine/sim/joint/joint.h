/* sim/joint: joints between two bodies, or a body and the world: their records, and their constraints in lanes.
 *
 * Public headers: joint.h joints.h */
#ifndef DAFT_SIM_JOINT_H
#define DAFT_SIM_JOINT_H

#include "sim/world.h"

/* ---- joint.c ---- */

void daft_sim_joint_remove(daft_world *world, uint32_t joint_index, bool event);
void daft_sim_joint_link(daft_world *world, uint32_t joint_index); /* for loading */
/* Those that the last step's forces break. */
void daft_sim_joints_break(daft_world *world);

#endif
