/* profile: which lines of a game's scripts take the time.
 *
 * A thread wakes about once in a millisecond, at uneven intervals, so that it keeps no step with the game. Where Lua
 * runs it signals the game's thread, whose handler asks Lua for a hook before its next instruction; the hook notes the
 * line, with the time since the thread woke last, and takes itself away. So a call of the engine counts for the line
 * that makes it, and a step of Lua's garbage collector for the line that happened to begin it.
 *
 * Promises: while it is off a call into the game costs one comparison, and while it is on a signal for each millisecond
 * of Lua. It allocates nothing in Lua, changes nothing there, and leaves hooks of others (the watchdog's, a limit of
 * instructions) alone: what a game does is the same with it. Under such a limit nothing is noted. */
#ifndef RUNTIME_LUA_PROFILE_H
#define RUNTIME_LUA_PROFILE_H

#include "daft.h"

#include <lua.h>
#include <pthread.h>
#include <stdatomic.h>

enum { PROFILE_LINES = 4096, PROFILE_FILE = 64, PROFILE_FUNCTION = 32 };

typedef struct profile_line {
    char file[PROFILE_FILE];         /* as in messages: "marble/main.lua" */
    char function[PROFILE_FUNCTION]; /* that it was met in first; or empty */
    int line;                        /* 0: the place is free */
    uint32_t samples;
    uint64_t ns, recent_ns; /* all; less and less of what is long ago */
} profile_line;

typedef struct profile {
    profile_line *lines; /* PROFILE_LINES of them, by a hash; NULL: it was never on */
    size_t count;
    uint64_t samples, ns, recent_ns; /* of all lines, also such as found no place */
    uint64_t call_ns, began_ns;      /* within calls, by the clock; when the one that runs began */
    bool on;
    atomic_bool ends;
    pthread_t thread, watched;
    _Atomic uint64_t pending_ns;         /* told by signals, and not yet by the hook */
    lua_State *_Atomic *_Atomic running; /* of the host that runs; NULL: none does */
} profile;

/* Of the calling thread's games, from now on. False: out of memory, or of threads. */
bool profile_start(profile *self, daft_error *error);
/* What has been noted stays. */
void profile_stop(profile *self);
void profile_free(profile *self);

/* Around each call into a game. `running`: where it is told which state or coroutine runs. */
void profile_enter(profile *self, lua_State *_Atomic *running);
void profile_leave(profile *self);

/* The lines that took most, the most first; returns how many. `recent`: of the last few seconds. */
size_t profile_top(const profile *self, bool recent, profile_line *out, size_t most);
/* A second has passed. */
void profile_fade(profile *self);

#endif
