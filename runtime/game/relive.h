/* A changed game takes the place of the one that runs: what the player did since the start is done again with the new
 * code, as fast as it goes, so that the game stands where it stood. Where both have daft.reload, the new one is given
 * what the old one keeps instead, and nothing is done again. */
#ifndef RUNTIME_GAME_RELIVE_H
#define RUNTIME_GAME_RELIVE_H

#include "game/game.h"

enum { TRAIL_EVENTS = 1 << 20, TRAIL_SECONDS = 2 };

/* What happened since the game last began: a recording in memory. */
typedef struct trail {
    recording made; /* `end` is not kept up */
    uint64_t first; /* the tick before which it began, */
    input keys;     /* what was held then, */
    saves *kept;    /* and what the game had kept; NULL: nothing is known */
    char *handed;   /* what it was given for daft.reload; or NULL */
    size_t capacity, saved_capacity;
    bool lost; /* there was too much of it, or no memory */
} trail;

void trail_add(trail *self, uint64_t tick, const input_event *events, size_t count);
void trail_line(trail *self, uint64_t tick, const char *text);
/* What the game was given of what it had kept. */
void trail_saved(trail *self, const char *name, const char *text);
/* The game begins again before this tick. */
void trail_restart(trail *self, uint64_t tick, const input *keys, const saves *kept);
void trail_free(trail *self);
/* What is done next, of what is done again, is tick `tick`. */
void trail_seek(trail *self, uint64_t tick);
/* From tick `tick` on nothing has happened yet. */
void trail_cut(trail *self, uint64_t tick);
/* What the game had kept when it began, and was given since, without a folder. NULL: memory is out. */
saves *trail_saves(const trail *self, const char *game, daft_error *error);

typedef enum relive_end {
    RELIVE_DONE,   /* `fresh` stands where `old` does, and `old` is closed */
    RELIVE_HANDED, /* likewise, by daft.reload: no input leads there */
    RELIVE_FAILED, /* the new code fails: `message` says how, and `old` goes on */
    RELIVE_LONG    /* it takes too long: `old` goes on */
} relive_end;

/* `fresh` is empty, or left by an earlier call. */
relive_end relive(game_state *old, game_state *fresh, trail *from, char message[HOST_MESSAGE], daft_error *error);

#endif
