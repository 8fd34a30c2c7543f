/* sim/broad: which parts may meet within a step.
 * Promises: all pairs of parts whose bounds over the step overlap, of which one at least moves or was placed since the
 * last step, and no others; which trees and groups they stand in matters for time only.
 *
 * Public headers: broad.h tree.h */
#ifndef DAFT_SIM_BROAD_H
#define DAFT_SIM_BROAD_H

#include "sim/world.h"

/* ---- broad.c ---- */

/* Room for the bounds of so many parts. */
bool daft_sim_bounds_reserve(daft_world *world, size_t parts);

/* Enters the parts of a body into the tree of its kind, for which there is room, and marks them moved. */
void daft_sim_broad_add(daft_world *world, uint32_t body_index);
void daft_sim_broad_remove(daft_world *world, uint32_t body_index);
/* Bounds over the coming step of everything that moves. False when memory is out. */
bool daft_sim_broad_update(daft_world *world, float dt);
/* The trees hold all parts where they are now, for queries. */
void daft_sim_broad_settle(daft_world *world);
/* The same for a body that falls asleep. */
void daft_sim_broad_rest(daft_world *world, uint32_t body_index);

/* ---- outline.c ---- */

/* Room for the outlines of so many parts. */
bool daft_sim_outlines_reserve(daft_world *world, size_t parts);
/* Of a part, where it is, over a step of dt. */
void daft_sim_outline_set(daft_world *world, uint32_t part_index, const daft_rigid *frame, float dt);
/* Of all parts of a body that does not move. */
void daft_sim_outlines_rest(daft_world *world, uint32_t body);

/* ---- groups.c ---- */

/* What is active, or was placed, joins the groups. False when memory is out. */
bool daft_sim_groups_join(daft_world *world);
/* The bodies that joints keep one from touching have changed. */
void daft_sim_groups_joined(daft_world *world, uint32_t body);
/* A part that rests from now on, or is to be removed. */
void daft_sim_group_leave(daft_world *world, uint32_t part);
/* To the bounds over the step. */
void daft_sim_groups_fit(daft_world *world);
/* Keys of near pairs go to world->candidates, in any order. False when memory is out. */
bool daft_sim_groups_search(daft_world *world);

#endif
