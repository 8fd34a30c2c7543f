/* What a step tells: contacts and events. */
#ifndef DAFT_SIM_EVENTS_H
#define DAFT_SIM_EVENTS_H

#include "sim/world.h"

/* ---- events.c ---- */

void daft_sim_event_end(daft_world *world, const daft_sim_pair *pair); /* it is about to go */
void daft_sim_event_joint(daft_world *world, daft_sim_event_kind kind, uint32_t joint_index, float value);
void daft_sim_event_sleep(daft_world *world, daft_sim_event_kind kind, uint32_t body);
/* A removed body's contacts leave the report. */
void daft_sim_report_forget(daft_world *world, uint32_t handle);
bool daft_sim_report_reserve(daft_world *world);
/* Before touches or poses of the last step are changed. */
void daft_sim_report_fill(daft_world *world);
/* Contacts and events of the step just made. */
void daft_sim_report(daft_world *world);
void daft_sim_events_deliver(daft_world *world);

#endif
