/* input: the state of keys, mouse, wheel and gamepad, which changes only between ticks.
 * The platform queues events; the start of a tick applies the queue. Applied events can be recorded and replayed. Mouse
 * buttons are keys named "mouse1" to "mouse5", those of gamepads "pad a", "pad start" and so on; all gamepads count as
 * one. Promises: a tick's state depends on its events alone; an event that changes nothing (a repeat) is dropped. */
#ifndef RUNTIME_PLATFORM_INPUT_H
#define RUNTIME_PLATFORM_INPUT_H

#include <stdbool.h>
#include <stddef.h>

enum { INPUT_KEYS = 128, INPUT_STICKS = 6, INPUT_QUEUE = 256 };

/* "start again": no key, but what the player chose in the pause menu. It is recorded as a key is; no handler hears of
 * it. */
#define INPUT_RESTART "start again"

/* Keys have SDL's names in lower case. Letters, digits and signs are places: "a" is the key that has an A on a US
 * keyboard, whatever is printed on it here. Unknown names give -1, unknown numbers NULL. */
int input_key_find(const char *name);
const char *input_key_name(int key);
/* All names, for hints. */
const char *const *input_key_names(size_t *count);

/* A gamepad's sticks, an axis each, and its triggers: "left x", "right trigger". */
int input_stick_find(const char *name);
const char *const *input_stick_names(size_t *count);

typedef enum input_kind {
    INPUT_KEY,
    INPUT_MOVE,
    INPUT_MOTION,
    INPUT_WHEEL,
    INPUT_STICK,
    INPUT_WIDTH,
    INPUT_TEXT
} input_kind;

typedef struct input_event {
    input_kind kind;
    int key;    /* INPUT_KEY, INPUT_STICK; INPUT_TEXT: the code point of a letter that was typed */
    bool down;  /* INPUT_KEY */
    int letter; /* INPUT_KEY: 1 more than the key whose name is printed on it; 0: the same. See input_letter */
    /* INPUT_MOVE: HUD units from the top left; INPUT_MOTION: HUD units right and down, while the mouse is grabbed;
     * INPUT_WHEEL: notches, right and up positive; INPUT_STICK: x alone, -1 to 1, right and down positive; INPUT_WIDTH:
     * x alone, HUD units that the picture is wide, since games ask where on it something is. */
    float x, y;
} input_event;

typedef struct input {
    bool down[INPUT_KEYS], pressed[INPUT_KEYS], released[INPUT_KEYS];
    float mouse_x, mouse_y, motion_x, motion_y, wheel_x, wheel_y;
    float stick[INPUT_STICKS], stick_before[INPUT_STICKS]; /* now, and as the tick began */
    float width;                                           /* of the picture, in HUD units */
    input_event queue[INPUT_QUEUE];                        /* for the next tick */
    size_t queued;
    input_event applied[INPUT_QUEUE]; /* the events that changed the state in this tick, in order */
    size_t applied_count;
} input;

/* The key by what is printed on it on this keyboard: for the program's own keys, which have their letter as a reason.
 */
int input_letter(const input_event *event);

/* A code point that can be typed: no control character, no half of a pair. */
bool input_is_text(int code);

/* Queues an event. Consecutive mouse positions and motions coalesce; a full queue drops the event. */
void input_push(input *state, const input_event *event);
/* Queues a release of every key and stick held: for a window that loses the focus. */
void input_push_release_all(input *state);
/* Starts a tick: clears pressed, released, motion and wheel. */
void input_begin_tick(input *state);
/* Applies one event to the current tick. */
void input_apply(input *state, const input_event *event);
/* Applies the queue and empties it. */
void input_apply_queue(input *state);
/* Empties the queue while a recording plays. */
void input_drop_queue(input *state);

#endif
