/* fingerprint: a few bits of what an entity is, to tell which one is the first to differ where two games that should be
 * the same are not. */
#ifndef RUNTIME_GAME_FINGERPRINT_H
#define RUNTIME_GAME_FINGERPRINT_H

#include "daft.h"

/* Scenes of more entities are not looked at beyond these, and not in every tick. */
enum { FINGERPRINT_ENTITIES = 2000 };

/* A byte each: position, rotation, velocities, all the rest. */
uint32_t fingerprint(daft_scene *scene, daft_entity entity);
/* "position and velocity": what differs between two of them. */
const char *fingerprint_name(uint32_t differs, char *buffer, size_t size);

#endif
