/* edit: one line of text that somebody types: letters, the cursor, and keys that move and delete. Promises: the text is
 * UTF-8 that ends with a zero byte, and the cursor stands between two letters of it. */
#ifndef RUNTIME_TOOLS_EDIT_H
#define RUNTIME_TOOLS_EDIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { EDIT_SIZE = 1024 };

typedef struct line_edit {
    char text[EDIT_SIZE];
    size_t cursor; /* bytes */
} line_edit;

/* The cursor goes to the end. */
void edit_set(line_edit *self, const char *text);
/* A text without its control characters; of lines one. What does not fit is left out. */
void edit_insert(line_edit *self, const char *text);
void edit_type(line_edit *self, int code);
/* A key by its name. False: it means nothing here. */
bool edit_key(line_edit *self, const char *key, bool ctrl);

/* ---- keys that repeat while they are held, since platforms tell of the first press alone ---- */

typedef struct key_repeat {
    int key; /* that is held; below 0: none */
    uint64_t due_ns;
} key_repeat;

void repeat_key(key_repeat *self, int key, bool down, uint64_t now_ns);
/* The key that is pressed again by now; below 0: none. */
int repeat_next(key_repeat *self, uint64_t now_ns);

#endif
