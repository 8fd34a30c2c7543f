/* watchdog: a thread that measures the wall clock of each call into a game, so that no game can keep the program.
 *
 * The game's thread marks what it does as sections: a callback, a step of the simulation, a picture. A section that
 * lasts longer than its limit, or during which somebody asks for the end (Esc), is stopped: the thread receives SIGURG
 * again and again, whose handler calls `interrupt`, until the section ends. One that does not end even so, within
 * WATCHDOG_PATIENCE seconds or its limit, whichever is less, ends the program (common/stop.h), which saves the
 * recording.
 *
 * Promises: a section costs two reads of the clock and no system call; the watchdog's thread sleeps for as long as
 * nothing can happen. Limits change when a game ends, never what it computes. */
#ifndef RUNTIME_LUA_WATCHDOG_H
#define RUNTIME_LUA_WATCHDOG_H

#include "daft.h"

static const double WATCHDOG_SECONDS = 5;     /* unless somebody says otherwise */
static const double WATCHDOG_PATIENCE = 0.75; /* seconds */

typedef struct watchdog watchdog;

typedef struct watchdog_def {
    double seconds; /* limit of a section; 0: WATCHDOG_SECONDS */
    /* Called in a signal handler on the game's thread, within a section that is to stop. */
    void (*interrupt)(void *user);
    /* Asked on the watchdog's thread every few frames while a section runs: 0: go on; N: stop the section, and end the
     * program with status 0 when that has not helped after N milliseconds. May be NULL. */
    int (*asked)(void *asker);
    void *user, *asker;
} watchdog_def;

typedef enum watchdog_state { WATCHDOG_IDLE, WATCHDOG_RUNNING, WATCHDOG_LATE, WATCHDOG_ASKED } watchdog_state;

/* For sections of the calling thread. NULL: no thread can be made. */
watchdog *watchdog_open(const watchdog_def *def, daft_error *error);
void watchdog_close(watchdog *dog); /* NULL is fine */

/* Sections do not nest. `name` is for messages and must stay; `factor` multiplies the limit. */
void watchdog_begin(watchdog *dog, const char *name, double factor);
/* LATE or ASKED: the section was to stop. */
watchdog_state watchdog_end(watchdog *dog);
/* From any thread: LATE or ASKED while the section is to stop. */
watchdog_state watchdog_look(const watchdog *dog);
/* The limit of the section, in seconds. */
double watchdog_limit(const watchdog *dog);

#endif
