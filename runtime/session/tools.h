/* tools: the console and the inspector of a session, between the player's events and the game. */
#ifndef RUNTIME_SESSION_TOOLS_H
#define RUNTIME_SESSION_TOOLS_H

#include "session/state.h"

/* True: the event was theirs, and the game must not hear of it. */
bool tools_take(session *s, const platform_event *event);
/* Once a turn, after its events. */
void tools_turn(session *s);
void tools_draw(session *s, float alpha);
/* F4. */
void tools_toggle_inspector(session *s);
/* Whether the mouse is to be free. */
bool tools_want_mouse(const session *s);

/* For game_def. */
void tools_printed(void *user, const char *text, size_t size);
void tools_answered(void *user, const char *line, const char *answer, bool good);

#endif
