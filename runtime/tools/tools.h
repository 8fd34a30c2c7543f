/* tools: what a game that runs can be asked and told beside its own input: the console, the inspector, and where panels
 * go over the picture. Public headers: tools.h console.h inspector.h panels.h
 * It knows the game and the platform, and not who runs them. Promises: what changes the game goes into it as a line of
 * Lua, which recordings hold; while nothing is open, nothing is drawn. */
#ifndef RUNTIME_TOOLS_TOOLS_H
#define RUNTIME_TOOLS_TOOLS_H

#include "game/game.h"
#include "platform/platform.h"
#include "tools/console.h"
#include "tools/inspector.h"

typedef struct tools {
    console console;
    inspector inspector;
} tools;

/* What they work on now. */
typedef struct tools_scene {
    platform *screen;
    game_state *play;
    float alpha;    /* of the picture, between two ticks */
    bool paused;    /* the pause menu is open */
    bool time_held; /* the game takes no line */
} tools_scene;

void tools_free(tools *self);
/* True: the event was theirs, and the game must not hear of it. */
bool tools_take(tools *self, const tools_scene *now, const platform_event *event);
/* Once a turn, after its events. */
void tools_turn(tools *self, const tools_scene *now);
void tools_draw(tools *self, const tools_scene *now, daft_image *picture, font *face, panels *placed);
/* F4. */
void tools_toggle_inspector(tools *self, const tools_scene *now);
/* Whether the mouse is to be free. */
bool tools_want_mouse(const tools *self);

/* A piece of what the game prints. */
void tools_printed(tools *self, const char *text, size_t size);
/* What a line of Lua came to. `foreign`: nobody has typed it here, it is a recording's. */
void tools_answered(tools *self, const char *line, const char *answer, bool good, bool foreign);

#endif
