/* failure: what an author wants to know about a script that has stopped: the message, the source around the line that
 * failed, the stack, and what the local variables held. Promises: describing calls nothing of the script, and shows no
 * address. */
#ifndef RUNTIME_LUA_FAILURE_H
#define RUNTIME_LUA_FAILURE_H

#include "daft.h"

#include <lua.h>

enum { FAILURE_MESSAGE = 1024, FAILURE_TRACE = 4096, FAILURE_SOURCE = 1024, FAILURE_VALUES = 3072 };

/* Texts of lines that '\n' separates; each empty where there is nothing to tell. */
typedef struct failure {
    char message[FAILURE_MESSAGE];
    char trace[FAILURE_TRACE];
    char source[FAILURE_SOURCE]; /* lines around, each with its number; the one that failed begins with '>' */
    char values[FAILURE_VALUES]; /* a heading, then a tab, NAME = VALUE */
    char file[256];              /* of the line that failed, as daft_files finds it; or empty */
    int line;
} failure;

void failure_clear(failure *self);
/* Of the level that the message names, else of the first that is a script's, from `level` on. Keeps what is there
 * already: the innermost coroutine comes first. */
void failure_take_values(failure *self, lua_State *L, int level, const char *message);
/* By the "FILE:LINE:" at the beginning of the message. */
void failure_find_source(failure *self, const daft_files *files);
/* All of it, for a terminal or the clipboard: at most size - 1 bytes. Returns `out`. */
const char *failure_text(const failure *self, char *out, size_t size);
enum { FAILURE_TEXT = FAILURE_MESSAGE + FAILURE_TRACE + FAILURE_SOURCE + FAILURE_VALUES + 64 };

/* Appends what a value is, on one line, to a text of `size` bytes. */
void failure_describe(lua_State *L, int index, char *out, size_t size);

#endif
