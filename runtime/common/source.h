/* source: where the files of one game come from: its folder, then assets/, then scripts/, and from nowhere else.
 * Promises: whatever names a game uses, and whatever links lie in its folder, nothing beside these is read. */
#ifndef RUNTIME_COMMON_SOURCE_H
#define RUNTIME_COMMON_SOURCE_H

#include "common/home.h"

typedef struct game_source {
    daft_files *files;
} game_source;

/* On failure nothing is left open. */
bool source_open(game_source *out, const home *where, const game_info *game, daft_error *error);
void source_close(game_source *source);

#endif
