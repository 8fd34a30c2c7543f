/* The state of keys, mouse, wheel and gamepad. */
#include "platform/input.h"

#include <math.h>
#include <string.h>

/* Indices are never stored; recordings hold names. */
/* Gamepads' buttons stand in SDL's order. The last is INPUT_RESTART. */
/* clang-format off */
static const char *const KEYS[] = {
    "a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o", "p", "q", "r", "s", "t", "u", "v", "w",
    "x", "y", "z",
    "0", "1", "2", "3", "4", "5", "6", "7", "8", "9",
    "left", "right", "up", "down",
    "space", "return", "escape", "backspace", "tab", "delete", "insert", "home", "end", "pageup", "pagedown",
    "left shift", "right shift", "left ctrl", "right ctrl", "left alt", "right alt", "left gui", "right gui", "menu",
    "capslock", "numlock", "scrolllock", "printscreen", "pause",
    "f1", "f2", "f3", "f4", "f5", "f6", "f7", "f8", "f9", "f10", "f11", "f12", "-", "=", "[", "]", "\\", ";", "'", "`",
    ",", ".", "/",
    "keypad 0", "keypad 1", "keypad 2", "keypad 3", "keypad 4", "keypad 5", "keypad 6", "keypad 7", "keypad 8",
    "keypad 9", "keypad .", "keypad /", "keypad *", "keypad -", "keypad +", "keypad enter",
    "mouse1", "mouse2", "mouse3", "mouse4", "mouse5",
    "pad a", "pad b", "pad x", "pad y", "pad back", "pad guide", "pad start", "pad left stick", "pad right stick",
    "pad left shoulder", "pad right shoulder", "pad up", "pad down", "pad left", "pad right", "start again"};
/* clang-format on */
static const char *const STICKS[INPUT_STICKS] = {"left x",  "left y",       "right x",
                                                 "right y", "left trigger", "right trigger"};

enum { KEY_COUNT = sizeof KEYS / sizeof KEYS[0] };
_Static_assert(sizeof KEYS / sizeof KEYS[0] <= (size_t)INPUT_KEYS, "the state arrays hold every key");

int input_key_find(const char *name)
{
    for (int i = 0; i < KEY_COUNT; i++)
        if (strcmp(name, KEYS[i]) == 0) return i;
    return -1;
}

int input_letter(const input_event *event) { return event->letter > 0 ? event->letter - 1 : event->key; }

const char *input_key_name(int key) { return key >= 0 && key < KEY_COUNT ? KEYS[key] : NULL; }

const char *const *input_key_names(size_t *count)
{
    *count = KEY_COUNT;
    return KEYS;
}

int input_stick_find(const char *name)
{
    for (int i = 0; i < INPUT_STICKS; i++)
        if (strcmp(name, STICKS[i]) == 0) return i;
    return -1;
}

const char *const *input_stick_names(size_t *count)
{
    *count = INPUT_STICKS;
    return STICKS;
}

/* The queued event of the same stick that only events of sticks follow, or NULL. */
static input_event *queued_stick(input *state, int stick)
{
    for (size_t i = state->queued; i-- > 0 && state->queue[i].kind == INPUT_STICK;)
        if (state->queue[i].key == stick) return &state->queue[i];
    return NULL;
}

void input_push(input *state, const input_event *event)
{
    input_event *last = state->queued > 0 ? &state->queue[state->queued - 1] : NULL;
    input_event *same = event->kind == INPUT_STICK ? queued_stick(state, event->key) : NULL;
    if (same) {
        *same = *event;
        return;
    }
    if (last && last->kind == INPUT_MOVE && event->kind == INPUT_MOVE) {
        *last = *event;
        return;
    }
    if (last && last->kind == INPUT_MOTION && event->kind == INPUT_MOTION) {
        last->x += event->x, last->y += event->y;
        return;
    }
    if (state->queued < INPUT_QUEUE) state->queue[state->queued++] = *event;
}

void input_push_release_all(input *state)
{
    /* A full queue would lose the releases and leave keys stuck, so it is emptied first. */
    if (state->queued + KEY_COUNT + INPUT_STICKS > INPUT_QUEUE) state->queued = 0;
    bool held[INPUT_KEYS];
    memcpy(held, state->down, sizeof held);
    for (size_t i = 0; i < state->queued; i++)
        if (state->queue[i].kind == INPUT_KEY) held[state->queue[i].key] = state->queue[i].down;
    for (int key = 0; key < KEY_COUNT; key++)
        if (held[key]) input_push(state, &(input_event){.kind = INPUT_KEY, .key = key, .down = false});
    for (int i = 0; i < INPUT_STICKS; i++) input_push(state, &(input_event){.kind = INPUT_STICK, .key = i});
}

void input_begin_tick(input *state)
{
    memset(state->pressed, 0, sizeof state->pressed);
    memset(state->released, 0, sizeof state->released);
    state->wheel_x = state->wheel_y = state->motion_x = state->motion_y = 0;
    memcpy(state->stick_before, state->stick, sizeof state->stick);
    state->applied_count = 0;
}

bool input_is_text(int code)
{
    return code >= 0x20 && code != 0x7F && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF);
}

/* Changes the state; false when nothing changed. */
static bool change_state(input *state, const input_event *event)
{
    bool moves = isfinite(event->x) && isfinite(event->y) && (event->x != 0 || event->y != 0);
    switch (event->kind) {
    case INPUT_KEY:
        if (event->key < 0 || event->key >= KEY_COUNT || state->down[event->key] == event->down) return false;
        state->down[event->key] = event->down;
        (event->down ? state->pressed : state->released)[event->key] = true;
        return true;
    case INPUT_STICK:
        if (event->key < 0 || event->key >= INPUT_STICKS || !(fabsf(event->x) <= 1)) return false;
        if (state->stick[event->key] == event->x) return false;
        state->stick[event->key] = event->x;
        return true;
    case INPUT_MOVE:
        if (!isfinite(event->x) || !isfinite(event->y)) return false;
        if (event->x == state->mouse_x && event->y == state->mouse_y) return false;
        state->mouse_x = event->x, state->mouse_y = event->y;
        return true;
    case INPUT_MOTION:
        if (moves) state->motion_x += event->x, state->motion_y += event->y;
        return moves;
    case INPUT_WIDTH:
        if (!(event->x > 0) || !isfinite(event->x) || event->x == state->width) return false;
        state->width = event->x;
        return true;
    case INPUT_TEXT: return input_is_text(event->key);
    case INPUT_WHEEL:
        if (moves) state->wheel_x += event->x, state->wheel_y += event->y;
        return moves;
    }
    return false;
}

void input_apply(input *state, const input_event *event)
{
    if (state->applied_count == INPUT_QUEUE) return; /* an event that cannot be recorded must not be applied */
    if (change_state(state, event)) state->applied[state->applied_count++] = *event;
}

void input_apply_queue(input *state)
{
    for (size_t i = 0; i < state->queued; i++) input_apply(state, &state->queue[i]);
    state->queued = 0;
}

void input_drop_queue(input *state) { state->queued = 0; }
