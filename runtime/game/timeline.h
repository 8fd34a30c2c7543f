/* timeline: goes back and forth in a game's time. Nobody pays for it before it is asked for: then the game is played
 * again from its start, by the trail of its input, in a heap of its own (game/heap.h), of which an image is kept for
 * each second; from then on any tick is an image that is put back and the ticks from there on, done again.
 *
 * Promises: at each tick the game has the state that it had then, bit for bit. Where it goes on from an earlier tick,
 * its trail, its recording and what it has kept are as they were then. */
#ifndef RUNTIME_GAME_TIMELINE_H
#define RUNTIME_GAME_TIMELINE_H

#include "game/heap.h"
#include "game/relive.h"

/* Ticks from one image to the next, and what all of them may take: older ones go first, but for one in so many. */
enum { TIMELINE_STEP = 60, TIMELINE_BYTES = 400 << 20 };

typedef struct moment moment;

typedef struct timeline {
    daft_engine *engine;
    heap *memory;
    game_state *play; /* in that memory */
    trail *past;
    game_def live; /* while time is held: as the game runs on */
    saves *kept;   /* while time is held: what the game has kept */
    bool held;
    uint64_t spent_ns;       /* by ticks since the last image, while it catches up */
    uint64_t first, present; /* ticks that there are; present: while it is held */
    moment **moments;        /* ascending */
    size_t count, capacity;
    font **fonts; /* that scripts have opened */
    size_t font_count, font_capacity;
} timeline;

/* Begins a game of this definition again in `fresh`, to get where it was after `present` ticks. Its source
 * must outlive it. NULL: see the error. */
timeline *timeline_open(const game_def *live, uint64_t present, game_state *fresh, trail *past, daft_error *error);
/* Plays until it is there, or until `until_ns` by clock_now_ns. True: it is there. A failed game stays where it is. */
bool timeline_catch_up(timeline *self, uint64_t until_ns);
/* The game that caught up takes the place of `old`, which is closed. Time is held. */
bool timeline_take_over(timeline *self, game_state *old, daft_error *error);
/* Closes the game, if it is open. Pictures' histories must be gone. NULL is fine. */
void timeline_close(timeline *self);

/* After a tick that was played: now and then there is an image of it. */
void timeline_keep(timeline *self);
/* Another game, in the same memory, has taken its place: what was before is unknown. */
void timeline_forget(timeline *self, game_state *play);

/* Time stands still, so that it may be gone through. */
bool timeline_hold(timeline *self, daft_error *error);
/* Whether the state after `tick` ticks can be reached from an image. */
bool timeline_reaches(const timeline *self, uint64_t tick);
/* The game as it was after `tick` ticks, at most `present`. False: it has failed on the way. */
bool timeline_go(timeline *self, uint64_t tick, daft_error *error);
/* The game runs on, from where it is: what was later is gone. */
bool timeline_release(timeline *self, daft_error *error);

#endif
