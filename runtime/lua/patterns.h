/* patterns: string.find, match, gmatch and gsub of Lua 5.4 (reference manual, 6.4.1) that can be stopped.
 *
 * Lua's own matcher backtracks without asking anybody: a pattern of twenty bytes can keep it busy for years. This one
 * calls `poll` after every few thousand comparisons, and `poll` raises an error where the script is to end. Promises:
 * results and messages are those of Lua 5.4. */
#ifndef RUNTIME_LUA_PATTERNS_H
#define RUNTIME_LUA_PATTERNS_H

#include <lauxlib.h>

enum { PATTERNS_POLL_STEPS = 4096 }; /* comparisons between two polls: some microseconds; HOST_POLL_STEPS */

typedef void patterns_poll(lua_State *L);

/* Replaces the four functions in the table on top of the stack. */
void patterns_open(lua_State *L, patterns_poll *poll);

#endif
