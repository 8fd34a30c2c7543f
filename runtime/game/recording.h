/* recording: the input of a game, tick by tick, as a text file that replays it.
 *
 *     daft-recording 4          the format's version (1 had no 'tick' lines, 2 no 'saved' ones, 3 no 'text', 'width')
 *     game marble
 *     rate 60                   ticks a second
 *     seed 1                    seed of the random numbers
 *     pack 9f86d0…              of a packed game: its SHA-256, 64 hexadecimal digits
 *     saved scores {[1]=9}      what daft.load_saved("scores") gave first; nothing behind the name: nothing was there
 *     12 +right                 at the start of tick 12 (counted from 0) the key goes down
 *     40 -right                 … and up
 *     41 mouse 640.5 360        the mouse, in HUD units from the top left
 *     41 motion -3 0.5          the grabbed mouse, in HUD units right and down
 *     41 wheel 0 1              notches, right and up positive
 *     43 text 00e4              a letter was typed: its code point, hexadecimal
 *     43 width 960              the picture is so wide from now on, in HUD units; before, 1280
 *     tick 60                   60 ticks have been recorded; once a second
 *     end 600                   ticks in all; the last line
 *
 * Ticks ascend; blank lines and lines that start with # are ignored.
 *
 * A recording in the making is FILE.part, and becomes FILE when the game ends; until then an older FILE stays as it
 * was. It is flushed once a second, so that of a killed game all but its last second can be replayed: `--replay
 * FILE.part`. What a killed game left is kept as FILE.part-old when the next recording begins. Promises: a recording
 * reads back bit for bit; one that was cut short plays up to its last whole second; any other bad file fails with
 * file:line:column. */
#ifndef RUNTIME_GAME_RECORDING_H
#define RUNTIME_GAME_RECORDING_H

#include "daft.h"
#include "platform/input.h"

typedef struct recording_item {
    uint64_t tick;
    input_event event;
} recording_item;

typedef struct recording_save {
    char *name, *text; /* one allocation, by `name`; text NULL: nothing */
} recording_save;

typedef struct recording {
    char game[128];
    char pack[65]; /* SHA-256 of the packed game; empty: it was none */
    uint64_t seed;
    uint64_t end; /* ticks */
    bool cut;     /* there is no 'end' line: `end` is the last tick that is known */
    recording_item *items;
    size_t count;
    size_t next; /* the first item not yet played */
    recording_save *saved;
    size_t saved_count;
} recording;

/* `files`: the game's, of which it is one; NULL: it is the user's own, anywhere. */
bool recording_load(recording *out, const daft_files *files, const char *path, daft_error *error);
void recording_free(recording *record);
/* Applies the events of this tick; call it with ascending ticks. */
void recording_play(recording *record, uint64_t tick, input *state);

/* Writes events while the game runs, so that a failed game leaves its recording. */
typedef struct recorder recorder;
/* `pack`: SHA-256 of the packed game, or empty. */
recorder *recorder_open(const char *path, const char *game, const char *pack, uint64_t seed, daft_error *error);
/* As tick `tick`, counted from 0, begins: what it is given. A game that fails in this tick fails again in its replay.
 */
void recorder_tick(recorder *writer, uint64_t tick, const input_event *events, size_t count);
/* What the game was given of what it had kept; before the tick ends. NULL is fine. */
void recorder_saved(recorder *writer, const char *name, const char *text);
/* Ends the file after the last tick that began, and puts it into place; from any thread, once: then the recorder takes
 * nothing more. NULL is fine. False where a write failed: then FILE is as it was. */
bool recorder_finish(recorder *writer, daft_error *error);
void recorder_free(recorder *writer);

#endif
