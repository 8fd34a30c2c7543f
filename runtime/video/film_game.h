/* film_game: the pictures of a game that plays a recording, or plays by itself. */
#ifndef RUNTIME_VIDEO_FILM_GAME_H
#define RUNTIME_VIDEO_FILM_GAME_H

#include "game/game.h"
#include "video/source.h"

typedef struct film_game {
    frame_source source;
    game_state play;
    recording replay;
    bool has_replay;
} film_game;

/* `replay`: a recording, or NULL; it must be one of this game. `inside`: it is one of the game's files. `def` without
 * its replay; the film_game must not move afterwards. On failure nothing is left open. */
bool film_game_open(film_game *self, const game_def *def, const char *replay, bool inside, daft_error *error);
void film_game_close(film_game *self);

#endif
