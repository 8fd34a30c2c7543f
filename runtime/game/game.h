/* game: one game being played: its scene, its scripts, its input, tick by tick. Knows no window and no clock.
 * One tick is: poses are remembered, input is applied (and recorded, or taken from a recording), daft.keypressed and
 * daft.keyreleased, daft.update(1/60), the simulation's step.
 * Promises: the same recording gives the same ticks. After a script's error the game stands still and says why until it
 * is reloaded. */
#ifndef RUNTIME_GAME_GAME_H
#define RUNTIME_GAME_GAME_H

#include "lua/host.h"
#include "game/recording.h"

typedef struct game_def {
    const home *where;
    const game_info *info;
    daft_engine *engine;
    font *face;
    daft_quality quality;
    uint64_t seed;
    recording *replay; /* or NULL; must outlive the game */
    recorder *record;  /* or NULL; must outlive the game */
    bool (*interrupted)(void *user);
    void *user;
} game_def;

typedef struct game_state {
    game_def def;
    daft_scene *scene;
    host scripts;
    input keys;
    uint64_t ticks; /* since it was opened; a restart does not set it back */
    bool failed;    /* scripts.message and scripts.trace say why */
    bool over;      /* daft.quit was called */
} game_state;

/* Runs main.lua and daft.load. False only when there is no memory; a script's error makes a game that has failed. */
bool game_open(game_state *state, const game_def *def, daft_error *error);
void game_close(game_state *state);
/* Starts afresh: for R on the error screen, and for daft.restart. */
bool game_reload(game_state *state, daft_error *error);

/* False when the game has failed, now or before. */
bool game_tick(game_state *state);
/* The picture with what daft.draw puts over it; alpha: between the last two ticks. False when the game has failed. */
bool game_draw(game_state *state, daft_image *picture, float alpha);
uint64_t game_hash(const game_state *state);
/* Whether the recording still has ticks to play. */
bool game_is_replaying(const game_state *state);

#endif
