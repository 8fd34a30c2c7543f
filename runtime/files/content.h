/* content: what a game is known by: SHA-256 over the names and bytes of its own files, the same for its folder and its
 * pack. Recordings (.rec and what is left of them) do not count: they lie in games and are made by playing them. */
#ifndef RUNTIME_FILES_CONTENT_H
#define RUNTIME_FILES_CONTENT_H

#include "files/sha256.h"
#include "files/source.h"

/* False: a file cannot be read, or memory is out. */
bool content_hash(const game_source *source, const game_info *game, char out[SHA256_TEXT], daft_error *error);

#endif
