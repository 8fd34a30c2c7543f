/* The parts of sandbox_open (api.h). Each puts its functions into the libraries that are there already. */
#ifndef RUNTIME_LUA_SANDBOX_H
#define RUNTIME_LUA_SANDBOX_H

#include <lauxlib.h>

/* pcall, xpcall, coroutine.resume, wrap and close that the watchdog's error passes through (protect.c). */
void protect_open(lua_State *L, lua_CFunction traceback);
/* pairs, and table.sort, insert, remove and move that can be stopped (lists.c). */
void lists_open(lua_State *L);
/* tostring, print and string.format without addresses (texts.c). */
void texts_open(lua_State *L);

#endif
