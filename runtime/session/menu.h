/* menu: the list of games in a window, over a small scene. Arrow keys, Return and the mouse choose. */
#ifndef RUNTIME_SESSION_MENU_H
#define RUNTIME_SESSION_MENU_H

#include "session/session.h"

typedef enum menu_end {
    MENU_CHOSEN,
    MENU_LEFT, /* Esc, or the window was closed */
    MENU_FAILED
} menu_end;

/* *chosen: the game selected at first; on return, the chosen game. */
menu_end menu_show(const session_def *def, const game_info *games, size_t count, size_t *chosen, daft_error *error);

#endif
