/* trial: one test of a game, as `daft test-game` runs it: a file of the game's folder tests/ names tests by
 * daft.test(name, function); one of them is started as a task, and goes on tick by tick beside the game. An error in it
 * is the game's. */
#ifndef RUNTIME_LUA_TRIAL_H
#define RUNTIME_LUA_TRIAL_H

#include "lua/host.h"

enum { TRIAL_NAME = 120, TRIAL_PICTURES = 8 };

typedef struct trial_picture {
    char name[TRIAL_NAME];
    double max, mean; /* errors that are allowed, 0 to 1 */
} trial_picture;

typedef struct trial {
    size_t wanted;                          /* which test is to run, counted from 0; set by who runs it */
    size_t count;                           /* tests that the file has named */
    char name[TRIAL_NAME];                  /* of the wanted one; empty: there are not so many */
    bool runs;                              /* it has begun and not ended */
    trial_picture pictures[TRIAL_PICTURES]; /* to be looked at after this tick; who looks empties the list */
    size_t picture_count;
} trial;

/* Runs tests/FILE with daft.test at hand, then starts the wanted test where there is one. False: an error, as that of
 * any callback. `self` must outlive the host. */
bool trial_begin(host *state, trial *self, const char *file);
/* After each tick: whether the test still runs, in `runs`. */
void trial_look(host *state, trial *self);

#endif
