/* What pictures of a game cost on this machine, remembered from one session to the next: a small file for each game in
 * a folder of the user's cache. Where it cannot be read or written, nothing is remembered. */
#ifndef RUNTIME_SESSION_COSTS_H
#define RUNTIME_SESSION_COSTS_H

#include "game/governor.h"

/* The user's folder for it, made where it is missing; false: there is none. */
bool costs_folder(char *out, size_t size);
/* `folder` may be NULL. False: nothing is known. */
bool costs_load(const char *folder, const char *game, governor_costs *out);
void costs_save(const char *folder, const char *game, const governor_costs *costs);

#endif
