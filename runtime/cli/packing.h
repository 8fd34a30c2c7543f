/* packing: what daft pack does, in two files: pack.c and standalone.c. */
#ifndef RUNTIME_CLI_PACKING_H
#define RUNTIME_CLI_PACKING_H

#include "files/archive.h"
#include "files/source.h"

/* Puts a whole FILE.daft of a game's folder; `count`: its files. */
bool packing_put_game(const archive_def *def, const game_info *game, const game_source *source, size_t *count,
                      daft_error *error);
/* Writes the game as a program, and prints what it is and what it needs. */
bool standalone_write(const home *where, const game_info *game, const game_source *source, const char *out,
                      daft_error *error);

#endif
