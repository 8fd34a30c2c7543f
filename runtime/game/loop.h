/* loop: the arithmetic of the game loop, without a clock, a window or a game: time that passed goes in, the number of
 * updates to run and the blend between the last two for drawing come out.
 *
 * Updates are 1/60 s each. A frame runs at most LOOP_MAX_UPDATES; what is late beyond that is dropped, so that a slow
 * machine plays slower instead of falling ever further behind.
 * Promises: exact: N seconds in pieces of any length give 60·N updates, for ever; nothing is rounded. */
#ifndef RUNTIME_GAME_LOOP_H
#define RUNTIME_GAME_LOOP_H

#include <stdint.h>

enum { LOOP_RATE = 60, LOOP_MAX_UPDATES = 5 };

typedef struct loop {
    uint64_t owed;    /* time not yet played, in units of 1/60 ns, so that one update is 10^9 of them */
    uint64_t dropped; /* updates given up because the machine was too slow */
} loop;

/* Adds the time that passed since the last call; returns the updates to run now, 0..LOOP_MAX_UPDATES. */
int loop_advance(loop *state, uint64_t elapsed_ns);
/* How far drawing is between the last two updates, 0 <= alpha < 1. */
float loop_alpha(const loop *state);

#endif
