/* agree: whether a replay does what its recording did. Promises: a replay that parts from its recording is told once,
 * with the first tick that differs where the recording knows its ticks, and the first entity. */
#ifndef RUNTIME_GAME_AGREE_H
#define RUNTIME_GAME_AGREE_H

#include "game/recording.h"

enum { AGREE_TEXT = 400 };

typedef struct agreement {
    size_t state;  /* the next that the recording has */
    uint64_t from; /* the first tick that differed; 0: none */
    bool told;
} agreement;

/* After `ticks` ticks, each of them; `hash`: the state's. False, once, with the message: it has parted. */
bool agree(agreement *self, const recording *record, uint64_t ticks, uint64_t hash, daft_scene *scene,
           char message[AGREE_TEXT]);

#endif
