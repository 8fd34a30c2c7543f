/* keys: what each key does, as a table from which --help and the keys on the screen come. */
#ifndef RUNTIME_VIEW_KEYS_H
#define RUNTIME_VIEW_KEYS_H

#include <stddef.h>

typedef enum view_act {
    VIEW_NOTHING, /* held keys and the mouse: fly.c and viewer.c ask for their state */
    VIEW_TOGGLE,  /* leaves a part of the shading out: value is its bit of view_look.without */
    VIEW_CHANNEL, /* shows a channel: value is its view_channel */
    VIEW_WIRES,
    VIEW_ORBIT,
    VIEW_FRAME_ALL,
    VIEW_CHECKPOINT, /* of the camera path: adds one, */
    VIEW_MOVE,       /* puts the one nearest to the cursor where the camera is, */
    VIEW_REMOVE,
    VIEW_SOONER, /* reaches it sooner or later, */
    VIEW_LATER,
    VIEW_SAVE, /* writes the path into the file */
    VIEW_SNAPSHOT,
    VIEW_FILM,
    VIEW_SIZE, /* of both */
    VIEW_PACE,
    VIEW_START, /* back to the file's camera */
    VIEW_RELOAD,
    VIEW_PLAN,
    VIEW_KEYS,
    VIEW_LEAVE
} view_act;

typedef struct view_key {
    const char *shown; /* as the user reads it */
    const char *does;
    const char *keys[3]; /* names of the platform's keys, or NULL */
    view_act act;
    unsigned value;
} view_key;

const view_key *view_keys(size_t *count);
/* The row of a pressed key, or NULL. */
const view_key *view_key_find(const char *name);

#endif
