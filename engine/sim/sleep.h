/* Islands, and who sleeps. */
#ifndef DAFT_SIM_SLEEP_H
#define DAFT_SIM_SLEEP_H

#include "sim/world.h"

/* ---- sleep.c ---- */

void daft_sim_wake(daft_world *world, uint32_t body_index);
/* Wakes what touches a body, and what is joined to it. */
void daft_sim_wake_neighbours(daft_world *world, uint32_t body_index);
void daft_sim_wake_all(daft_world *world);
/* Islands asleep that something active touches. */
void daft_sim_wake_touched(daft_world *world);
/* Rest times, islands, and who falls asleep. */
void daft_sim_sleep_update(daft_world *world, float dt);
/* Islands of bodies that are awake, and the body that stands for the one that a body belongs to. */
void daft_sim_islands_find(daft_world *world);
uint32_t daft_sim_island_of(daft_world *world, uint32_t body_index);
/* Puts a body's island to sleep, if all of it may. */
void daft_sim_sleep_island(daft_world *world, uint32_t body_index);

#endif
