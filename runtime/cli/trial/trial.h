/* trial: the parts of `daft test-game`: the tests of a game's folder tests/, one after the other, each in a game of its
 * own; and the pictures that they compare.
 * Public headers: none */
#ifndef RUNTIME_CLI_TRIAL_TRIAL_H
#define RUNTIME_CLI_TRIAL_TRIAL_H

#include "game/game.h"
#include "lua/trial.h"

typedef struct trials {
    home where;
    game_info info;
    game_source source;
    daft_engine *engine;
    font *face;
    daft_image *picture;
    daft_preset quality;
    uint64_t max_ticks; /* that a test may take */
    const char *filter; /* part of "file: name"; NULL: all */
    bool update;        /* pictures that are not there, or differ, are written */
    bool lists;         /* names only */
    size_t passed, failed, written;
} trials;

/* ---- run.c ---- */

/* Runs the tests of one file. False: the engine failed. */
bool trials_run_file(trials *t, const char *file, daft_error *error);

/* ---- picture.c ---- */

/* Compares t->picture with the game's tests/pictures/NAME.png. Returns true where it is near enough or was written;
 * else `why` says what is wrong, and the picture and what differs in it lie in tests/failed/. */
bool trials_compare(trials *t, const trial_picture *wanted, char *why, size_t size);

#endif
