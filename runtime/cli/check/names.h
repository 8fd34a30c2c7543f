/* names: the globals, the fields of `daft` and the methods that all scripts of a game use, put together, and those that
 * nothing has. Code that has not run is seen like any other. */
#ifndef RUNTIME_CLI_CHECK_NAMES_H
#define RUNTIME_CLI_CHECK_NAMES_H

#include "cli/check/check.h"

#include <lua.h>

typedef struct names names;

names *names_create(void); /* NULL: out of memory */
void names_destroy(names *all);
/* The compiled script is on top of L. Of those that are `ours`, the library's, only what they set counts. */
void names_take(names *all, lua_State *L, const char *path, bool ours);
/* The globals that there are once the game runs. */
void names_take_globals(names *all, lua_State *L);
void names_report(const names *all, checker *c);

#endif
