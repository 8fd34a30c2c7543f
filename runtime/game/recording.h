/* recording: the input of a game, tick by tick, as a text file that replays it.
 *
 *     daft-recording 6          the format's version (1 had no 'tick' lines, 2 no 'saved' ones, 3 no 'text', 'width', 4
 *                               none of 'content', 'limits', 'state', 'entities', 5 no 'script', 'lua')
 *     game marble
 *     rate 60                   ticks a second
 *     seed 1                    seed of the random numbers
 *     pack 9f86d0…              of a packed game: its SHA-256, 64 hexadecimal digits
 *     content 60303a…           SHA-256 of the game's own files (files/content.h)
 *     limits 1000000000 5       bytes that the game may hold; seconds that one call may take
 *     script tween 1c7b4a…      SHA-256 of a module of scripts/ as it was when the game required it
 *     saved scores {[1]=9}      what daft.load_saved("scores") gave first; nothing behind the name: nothing was there
 *     12 +right                 at the start of tick 12 (counted from 0) the key goes down
 *     40 -right                 … and up
 *     41 mouse 640.5 360        the mouse, in HUD units from the top left
 *     41 motion -3 0.5          the grabbed mouse, in HUD units right and down
 *     41 wheel 0 1              notches, right and up positive
 *     43 text 00e4              a letter was typed: its code point, hexadecimal
 *     43 width 960              the picture is so wide from now on, in HUD units; before, 1280
 *     44 lua ball:push(0, 9, 0) a line of Lua that was typed (lua/statement.h), to the end of this one
 *     state 60 9a31… 01ab…      after 60 ticks: the state's hash; of the ticks since the last such line, 16 bits each
 *     entities 60 1f:a1b2c3d4   those that have changed since they were last told (game/fingerprint.h); 1f:- is gone
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

/* A module of scripts/. */
typedef struct recording_script {
    char name[64], content[65];
} recording_script;

typedef struct recording_line {
    uint64_t tick;
    char *text; /* Lua */
} recording_line;

enum { RECORDING_SECOND = 60, RECORDING_SCRIPTS = 64 }; /* ticks; modules of one game */

/* The states that a second of the game came to. */
typedef struct recording_state {
    uint64_t tick, hash; /* after so many ticks */
    uint32_t count;      /* of the ticks up to that one that are known by `ticks`, the lowest 16 bits of their hashes */
    uint16_t ticks[RECORDING_SECOND];
} recording_state;

typedef struct recording_mark {
    uint64_t tick;
    uint32_t entity, print;
    bool gone;
} recording_mark;

enum { RECORDING_MARKS = 256 }; /* entities told at once */

typedef struct recording {
    char game[128];
    char pack[65];    /* SHA-256 of the packed game; empty: it was none */
    char content[65]; /* SHA-256 of its files; empty: not known */
    uint64_t memory;  /* limits; 0: not known */
    double seconds;
    recording_state *states;
    recording_mark *marks;
    size_t state_count, state_capacity, mark_count, mark_capacity;
    uint64_t seed;
    uint64_t end; /* ticks */
    bool cut;     /* there is no 'end' line: `end` is the last tick that is known */
    recording_item *items;
    size_t count;
    size_t next; /* the first item not yet played */
    recording_line *lines;
    size_t line_count, line_capacity;
    size_t next_line; /* the first not yet run */
    recording_save *saved;
    size_t saved_count;
    recording_script *scripts;
    size_t script_count;
} recording;

/* `files`: the game's, of which it is one; NULL: it is the user's own, anywhere. */
bool recording_load(recording *out, const daft_files *files, const char *path, daft_error *error);
void recording_free(recording *record);
/* Applies the events of this tick; call it with ascending ticks. */
void recording_play(recording *record, uint64_t tick, input *state);
/* The next line of Lua of this tick; NULL: there are no more. */
const char *recording_line_at(recording *record, uint64_t tick);
/* Adds a line to a recording in memory. False: out of memory. */
bool recording_add_line(recording *record, uint64_t tick, const char *text);
/* Makes of what somebody typed a line that a recording gives back: without control characters, and without blanks
 * around it. False: nothing is left. */
bool recording_clean_line(const char *typed, char *out, size_t size);

/* Writes events while the game runs, so that a failed game leaves its recording. */
typedef struct recorder recorder;
/* What stands at the top; texts may be NULL where they are not known. */
typedef struct recording_head {
    const char *game, *pack, *content;
    uint64_t seed, memory;
    double seconds;
} recording_head;
recorder *recorder_open(const char *path, const recording_head *head, daft_error *error);
/* A module that the game has required. NULL is fine. */
void recorder_script(recorder *writer, const recording_script *script);
/* After `ticks` ticks: what the game came to. `scene` NULL: its entities are not told. */
void recorder_state(recorder *writer, uint64_t ticks, uint64_t hash, daft_scene *scene);
/* As tick `tick`, counted from 0, begins: what it is given. A game that fails in this tick fails again in its replay.
 */
void recorder_tick(recorder *writer, uint64_t tick, const input_event *events, size_t count);
/* After recorder_tick: a line of Lua that runs as this tick begins. */
void recorder_line(recorder *writer, uint64_t tick, const char *text);
/* The game goes on from the state after `ticks` ticks, whose hash this is: what was recorded of later ones is gone.
 * NULL is fine. False: the file cannot be cut. */
bool recorder_cut(recorder *writer, uint64_t ticks, uint64_t hash, daft_error *error);
/* What the game was given of what it had kept; before the tick ends. NULL is fine. */
void recorder_saved(recorder *writer, const char *name, const char *text);
/* Ends the file after the last tick that began, and puts it into place; from any thread, once: then the recorder takes
 * nothing more. NULL is fine. False where a write failed: then FILE is as it was. */
bool recorder_finish(recorder *writer, daft_error *error);
void recorder_free(recorder *writer);

#endif
