/* hot: the lines of the game's scripts that take the time, under F1 and as a table (lua/profile.h). */
#ifndef RUNTIME_SESSION_HOT_H
#define RUNTIME_SESSION_HOT_H

#include "session/state.h"

/* It looks while F1 is open, or where a table is wanted. */
void hot_switch(session *s);
/* The first five of the last seconds, as a panel beside F1's. */
void hot_draw(session *s);
/* Writes the table to session_def.profile, "-" for standard output. */
bool hot_write(session *s, daft_error *error);

#endif
