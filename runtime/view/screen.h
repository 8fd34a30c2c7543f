/* screen: what stands over the picture: the file's name, the state of the switches, what the cursor has hit, messages,
 * how fine the picture is, and the keys. */
#ifndef RUNTIME_VIEW_SCREEN_H
#define RUNTIME_VIEW_SCREEN_H

#include "hud/canvas.h"

/* Texts may be empty. */
typedef struct screen_state {
    const char *title;      /* the file, its size */
    const char *switches;   /* what is left out, the channel */
    const char *corner;     /* how fine the picture is */
    const char *found;      /* what lies under the cursor, lines */
    const char *notice;     /* the last message */
    bool bad;               /* the message is an error */
    bool keys;              /* all keys are shown */
    const char *work;       /* what is being made, */
    float done;             /* and how far it is, 0..1 */
    float cross_x, cross_y; /* of what was clicked, as fractions of the picture; below 0: nothing */
} screen_state;

/* A small camera with a text beside it; x, y: fractions of the picture. */
void screen_camera(const canvas *target, font *face, float x, float y, const char *text);
void screen_draw(const canvas *target, font *face, const screen_state *state);

#endif
