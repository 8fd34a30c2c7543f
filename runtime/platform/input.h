/* input: keys, mouse and wheel as the game sees them: a state that changes only between ticks.
 * The platform queues events as they come; at the start of a tick the queue is applied, and what was applied can be
 * recorded and played again. Mouse buttons are keys named "mouse1" to "mouse5".
 * Promises: a tick's state depends on its events alone; an event that changes nothing (a repeat) vanishes. */
#ifndef RUNTIME_PLATFORM_INPUT_H
#define RUNTIME_PLATFORM_INPUT_H

#include <stdbool.h>
#include <stddef.h>

enum { INPUT_KEYS = 128, INPUT_QUEUE = 256 };

/* SDL's key names in lower case. -1 where there is none of that name, NULL where there is none of that number. */
int input_key_find(const char *name);
const char *input_key_name(int key);
/* All names, for hints. */
const char *const *input_key_names(size_t *count);

typedef enum input_kind { INPUT_KEY, INPUT_MOVE, INPUT_MOTION, INPUT_WHEEL } input_kind;

typedef struct input_event {
    input_kind kind;
    int key;   /* INPUT_KEY */
    bool down; /* INPUT_KEY */
    /* INPUT_MOVE: HUD units from the top left; INPUT_MOTION: HUD units right and down, while the mouse is grabbed;
     * INPUT_WHEEL: notches, right and up positive. */
    float x, y;
} input_event;

typedef struct input {
    bool down[INPUT_KEYS], pressed[INPUT_KEYS], released[INPUT_KEYS];
    float mouse_x, mouse_y, motion_x, motion_y, wheel_x, wheel_y;
    input_event queue[INPUT_QUEUE]; /* for the next tick */
    size_t queued;
    input_event applied[INPUT_QUEUE]; /* what changed something in this tick, in order */
    size_t applied_count;
} input;

/* Places of the mouse and its motions coalesce; when the queue is full the event is lost. */
void input_push(input *state, const input_event *event);
/* Queues a release of every key that is down: for when the window loses the focus. */
void input_push_release_all(input *state);
/* Starts a tick: forgets what was pressed in the last one. */
void input_begin_tick(input *state);
/* Applies one event to the tick that has begun. */
void input_apply(input *state, const input_event *event);
/* Applies the queue and empties it. */
void input_apply_queue(input *state);
/* Empties the queue: for when a recording plays instead. */
void input_drop_queue(input *state);

#endif
