/* editor: the user's editor ($VISUAL, else $EDITOR) at a line of a file.
 *
 * Once the window is open the program may start no others (seal.h). So a process of its own is started before; it does
 * nothing but wait for a file and a line, and opens no file outside the folder that it was given. It ends with the
 * program. */
#ifndef RUNTIME_PLATFORM_EDITOR_H
#define RUNTIME_PLATFORM_EDITOR_H

#include <stdbool.h>

typedef struct editor editor;

/* NULL: neither variable is set, or there can be no process. */
editor *editor_start(const char *folder);
/* False: the process is gone, or the path is too long. Does not wait. */
bool editor_open(editor *self, const char *file, int line);
void editor_close(editor *self); /* NULL is fine */

#endif
