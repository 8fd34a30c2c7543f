/* listing: what the compiler of Lua 5.4 made of a script, read from its bytecode (lua_dump): which globals it reads and
 * sets, which fields of globals, which methods it calls, and which fields the tables have that it hands to functions,
 * each with its line. The compiler has resolved all scopes, so a local is never taken for a global; code that never
 * runs is listed too. Of other versions of Lua nothing is listed. */
#ifndef RUNTIME_CLI_CHECK_LISTING_H
#define RUNTIME_CLI_CHECK_LISTING_H

#include <lua.h>
#include <stdbool.h>

typedef enum listing_kind {
    LISTING_READ,   /* a global, or a field of one: "print", "daft.light.sun" */
    LISTING_SET,    /* the same, assigned */
    LISTING_METHOD, /* x:NAME(…) */
    LISTING_FIELD,  /* any other field that is assigned: x.NAME = …, {NAME = …} */
    LISTING_OPTION  /* a field of the table in GLOBAL{…}: path is the function, name the field */
} listing_kind;

typedef void listing_callback(void *user, listing_kind kind, const char *path, const char *name, int line);

/* The compiled script is on top of L, which stays there. False: out of memory, or not a version that can be read. */
bool listing_read(lua_State *L, listing_callback *found, void *user);

#endif
