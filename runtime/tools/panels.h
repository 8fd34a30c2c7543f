/* panels: where the program's own panels go: where they cover least of the game's text, and not each other. */
#ifndef RUNTIME_TOOLS_PANELS_H
#define RUNTIME_TOOLS_PANELS_H

#include "hud/canvas.h"

enum { PANELS = 8 };

typedef struct panel_box {
    float x, y, width, height; /* HUD units */
} panel_box;

/* Of one picture. */
typedef struct panels {
    const canvas_marks *marks; /* where the game's text is */
    panel_box taken[PANELS];
    size_t count;
} panels;

/* Moves the origin of `over` to the place for a panel of this size, where it covers least. */
void panels_place(panels *self, canvas *over, float width, float height);

/* A panel with a place of its own, from which others keep away. */
void panels_take(panels *self, panel_box box);

#endif
