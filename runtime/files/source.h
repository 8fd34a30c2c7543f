/* source: where the files of one game come from: its folder, or the pack that it is; then assets/, then scripts/; and
 * from nowhere else. Promises: whatever names a game uses, and whatever links lie in its folder, nothing beside these
 * is read; a packed game stays as it was opened, whatever becomes of its file. */
#ifndef RUNTIME_FILES_SOURCE_H
#define RUNTIME_FILES_SOURCE_H

#include "files/home.h"
#include "files/pack.h"

typedef struct game_source {
    daft_files *files;      /* all three */
    daft_files *own;        /* the game's alone */
    char hash[SHA256_TEXT]; /* of the pack; empty: a folder */
    pack *packed;           /* or NULL */
    void *bytes;            /* of the pack */
} game_source;

/* On failure nothing is left open. */
bool source_open(game_source *out, const home *where, const game_info *game, daft_error *error);
/* The game's own files only. */
bool source_open_alone(game_source *out, const game_info *game, daft_error *error);
void source_close(game_source *source);

#endif
