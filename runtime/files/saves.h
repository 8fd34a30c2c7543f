/* saves: what a game keeps from one start to the next, by names, each a line of text. In a folder they are files that
 * take each other's place whole or not at all; without one they live as long as the store. Promises: a name is read
 * from its file once, so that what the game is given can be recorded; a file that cannot be read is not lost when the
 * game saves anew: it becomes FILE.broken. */
#ifndef RUNTIME_FILES_SAVES_H
#define RUNTIME_FILES_SAVES_H

#include "daft.h"

enum { SAVES_NAME = 64, SAVES_COUNT = 64, SAVES_SIZE = 1 << 20 }; /* characters; names of a game; bytes of each */

typedef struct saves saves;

typedef struct saves_def {
    const char *folder; /* NULL: nothing outlasts the store */
    const char *game;
    /* What a name holds when it is first asked for; text NULL: nothing. May be NULL. */
    void (*told)(void *user, const char *name, const char *text);
    void *user;
} saves_def;

/* Copies the definition. NULL when out of memory. */
saves *saves_open(const saves_def *def, daft_error *error);
/* One of the same values without a folder. */
saves *saves_copy(const saves *from, daft_error *error);
/* Another just like it, but without a folder, and telling nobody; and back: `store` holds what `from` does, while its
 * files stay as they are until the game saves anew. */
saves *saves_clone(const saves *from, daft_error *error);
bool saves_take(saves *store, const saves *from, daft_error *error);
void saves_close(saves *store); /* NULL is fine */
/* Letters, digits, '_' and '-', SAVES_NAME at most. */
bool saves_is_name(const char *name);
/* The name holds the text, whatever its file says; text NULL: nothing. */
bool saves_expect(saves *store, const char *name, const char *text, daft_error *error);
/* The text belongs to the store, until the name is put anew; NULL: nothing. False: the file cannot be read. */
bool saves_get(saves *store, const char *name, const char **text, daft_error *error);
/* One line, without '\n' in it. False: it cannot be written, and the file is as it was. */
bool saves_put(saves *store, const char *name, const char *text, daft_error *error);
/* The name's text is nothing that the game can use: its file is to be kept beside the next one. */
void saves_mark_broken(saves *store, const char *name);

#endif
