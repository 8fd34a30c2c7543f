/* statement: a line of Lua that somebody types while a game runs. It is part of the game: the same line before the same
 * tick does the same everywhere, so that recordings hold it.
 *
 * A line is an expression, whose values are described, or statements. Its names are the game's own: first the local
 * variables that the game's callbacks use, then globals, then locals of the functions that these call; a new name makes
 * a global. entity_31 is the entity with the number 31.
 *
 * Promises: an error is an answer, and the game goes on; a line that goes on for longer than STATEMENT_STEPS
 * instructions is stopped at the same one everywhere. Describing values and completing names call nothing of the
 * script; completing allocates nothing in Lua and changes nothing. */
#ifndef RUNTIME_LUA_STATEMENT_H
#define RUNTIME_LUA_STATEMENT_H

#include "lua/host.h"

enum {
    STATEMENT_SIZE = 1024,
    STATEMENT_ANSWER = 4096,
    STATEMENT_STEPS = 20000000, /* of Lua: about a fifth of a second */
    COMPLETIONS = 96,
    COMPLETION_SIZE = 48
};

typedef enum statement_end {
    STATEMENT_DONE,
    STATEMENT_FAILED, /* the answer is the message */
    STATEMENT_STOPPED /* by the watchdog's clock, or since somebody wants to leave: so is the game; see host.failure */
} statement_end;

/* The answer may be empty, or several lines. */
statement_end host_run_statement(host *state, const char *text, char answer[STATEMENT_ANSWER]);

typedef struct completions {
    char names[COMPLETIONS][COMPLETION_SIZE]; /* in the order of their bytes */
    size_t count, total;                      /* kept; there are */
    size_t typed;                             /* bytes of the name that stand already */
    char common[COMPLETION_SIZE];             /* what all of them begin with */
} completions;

/* Names that the last name of the text, "a.b:c", may become. */
void host_complete(host *state, const char *text, completions *out);

/* What the script calls an entity, and its tags with ", " between them; empty where there are none. Allocates nothing
 * in Lua either. */
enum { ENTITY_TEXT = 128 };
void host_entity_texts(host *state, uint32_t id, char name[ENTITY_TEXT], char tags[ENTITY_TEXT]);

#endif
