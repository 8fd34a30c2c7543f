/* sim/contact: contact pairs. Made for parts that come near each other, kept in one list in the order of their keys
 * while a side is active, given manifolds by collide/, which take over impulses from those of the step before.
 * Promises: the list's order, and so all results, depend on nothing but which parts are near; what lies on an inner
 * edge or wall, or is only passed, has no contact.
 *
 * Public headers: contact.h */
#ifndef DAFT_SIM_CONTACT_H
#define DAFT_SIM_CONTACT_H

#include "sim/world.h"

/* ---- pairs.c ---- */

/* Makes contact pairs of all parts that are near each other, and of no others that have an active side. False when
 * memory is out. */
bool daft_sim_pairs_find(daft_world *world);
void daft_sim_pairs_forget(daft_world *world, uint32_t body); /* the impulses they keep */
/* Between steps: it leaves the active list too. */
void daft_sim_pair_drop(daft_world *world, uint32_t pair_index);
void daft_sim_pairs_remove(daft_world *world, uint32_t body);
/* All pairs of a body go to the active list. Room was reserved. */
void daft_sim_pairs_activate(daft_world *world, uint32_t body);
/* By keys; those of equal ones keep their order. scratch: room for as many. */
void daft_sim_active_sort(daft_sim_active *items, size_t count, daft_sim_active *scratch);
/* What joined the active list since it was last sorted goes to its place. */
void daft_sim_active_update(daft_world *world);
/* What its pair's manifolds say of an entry; of all that overlap. */
void daft_sim_active_refresh(const daft_world *world, daft_sim_active *entry);
void daft_sim_active_refresh_all(daft_world *world);
/* Whether two parts may touch at all. */
bool daft_sim_may_meet(const daft_world *world, uint32_t part_a, uint32_t part_b);
/* For loading: enters a pair that stands in its slot into lists. */
void daft_sim_pair_enter(daft_world *world, uint32_t pair_index);
bool daft_sim_pairs_reserve(daft_world *world, size_t more);

/* ---- contacts.c ---- */

/* Manifolds of everything active. False when memory is out. */
bool daft_sim_contacts_update(daft_world *world, float dt);
/* From the materials of its parts. */
void daft_sim_pair_materials(const daft_world *world, daft_sim_pair *pair);
/* The path of a body's part over dt at its present velocity. */
daft_sweep daft_sim_plan(const daft_world *world, const daft_sim_body *body, const daft_sim_part *part, float dt);

/* ---- ghost.c ---- */

/* Contacts with inner edges and walls go, and those with what is only passed. False when memory is out. */
bool daft_sim_ghosts_drop(daft_world *world, float dt);

/* ---- locked_axis.c ---- */

/* Turns a manifold into what both bodies are free to do; it may have no points then. */
void daft_sim_lock_axes(const daft_world *world, const daft_sim_pair *pair, daft_sim_manifold *manifold);

#endif
