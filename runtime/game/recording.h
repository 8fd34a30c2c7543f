/* recording: the input of a game, tick by tick, as a text file that replays it.
 *
 *     daft-recording 1          the format's version
 *     game marble
 *     rate 60                   ticks a second
 *     seed 1                    seed of the random numbers
 *     12 +right                 at the start of tick 12 (counted from 0) the key goes down
 *     40 -right                 … and up
 *     41 mouse 640.5 360        the mouse, in HUD units from the top left
 *     41 motion -3 0.5          the grabbed mouse, in HUD units right and down
 *     41 wheel 0 1              notches, right and up positive
 *     end 600                   ticks in all; the last line
 *
 * Ticks ascend; blank lines and lines that start with # are ignored.
 * Promises: a recording reads back bit for bit; a bad file fails with file:line:column. */
#ifndef RUNTIME_GAME_RECORDING_H
#define RUNTIME_GAME_RECORDING_H

#include "daft.h"
#include "platform/input.h"

typedef struct recording_item {
    uint64_t tick;
    input_event event;
} recording_item;

typedef struct recording {
    char game[128];
    uint64_t seed;
    uint64_t end; /* ticks */
    recording_item *items;
    size_t count;
    size_t next; /* the first item not yet played */
} recording;

bool recording_load(recording *out, const char *path, daft_error *error);
void recording_free(recording *record);
/* Applies the events of this tick; call it with ascending ticks. */
void recording_play(recording *record, uint64_t tick, input *state);

/* Writes events while the game runs, so that a failed game leaves its recording. */
typedef struct recorder recorder;
recorder *recorder_open(const char *path, const char *game, uint64_t seed, daft_error *error);
void recorder_add(recorder *writer, uint64_t tick, const input_event *event);
/* Ends the file at `end` ticks and closes it. NULL is fine. False when a write failed. */
bool recorder_close(recorder *writer, uint64_t end, daft_error *error);

#endif
