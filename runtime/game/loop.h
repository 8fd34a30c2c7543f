/* loop: the fixed time step. Elapsed time goes in; the number of updates to run, and the interpolation weight for
 * drawing, come out.
 *
 * An update is 1/60 s. A frame runs at most LOOP_MAX_UPDATES and drops the rest, so a slow machine plays slower instead
 * of falling further behind.
 * Promises: integer arithmetic: N seconds in pieces of any length give 60·N updates. */
#ifndef RUNTIME_GAME_LOOP_H
#define RUNTIME_GAME_LOOP_H

#include <stdint.h>

enum { LOOP_RATE = 60, LOOP_MAX_UPDATES = 5 };

typedef struct loop {
    uint64_t owed;    /* time not yet played, in units of 1/60 ns, so that one update is 10^9 of them */
    uint64_t dropped; /* updates dropped because the machine was too slow */
} loop;

/* Adds the time that passed since the last call; returns the updates to run now, 0..LOOP_MAX_UPDATES. */
int loop_advance(loop *state, uint64_t elapsed_ns);
/* Interpolation weight between the last two updates, 0 <= alpha < 1. */
float loop_alpha(const loop *state);

#endif
