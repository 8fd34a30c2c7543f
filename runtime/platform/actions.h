/* Actions: names that a game gives to keys, buttons and sticks; and the player's own keys for them.
 * A player's key is turned into the game's before anything else hears of it, so recordings hold the game's keys, and a
 * replay is the same whatever the player has chosen. */
#ifndef RUNTIME_PLATFORM_ACTIONS_H
#define RUNTIME_PLATFORM_ACTIONS_H

#include "platform/input.h"

#include <stdint.h>

enum { ACTIONS = 32, ACTION_INPUTS = 8, ACTION_NAME = 32 };

/* A key, "space"; one that counts as -1, "-left"; a stick, "left x", or a half of it, "+left x". */
typedef struct action_input {
    bool stick;
    int index; /* of the key or the stick */
    int sign;  /* of a key: what it gives; of a stick: 0, the whole, or the half that counts, as above 0 */
} action_input;

typedef struct action {
    char name[ACTION_NAME];
    action_input inputs[ACTION_INPUTS];
    int count;
} action;

typedef struct actions {
    action list[ACTIONS];
    int count;
} actions;

/* False: there is no such key or stick. */
bool action_input_parse(const char *text, action_input *out);
/* NULL: there is none. */
const action *actions_find(const actions *all, const char *name);
/* The action of this name, emptied, or a new one. NULL: the name is too long, or there are ACTIONS. */
action *actions_set(actions *all, const char *name);

/* The sum of its inputs, -1 to 1. */
float action_value(const action *a, const input *state);
/* A stick counts as down from half way on. */
bool action_down(const action *a, const input *state);
bool action_pressed(const action *a, const input *state);
bool action_released(const action *a, const input *state);

/* ---- the player's keys ---- */

typedef struct key_map {
    uint8_t to[INPUT_KEYS]; /* the game's key, or KEY_MAP_NONE */
} key_map;

enum { KEY_MAP_NONE = 255, KEY_MAP_TEXT = 4096 };

void key_map_reset(key_map *map);
/* From here on `pressed` stands for the game's `key`, and what stood for it before stands for nothing. */
void key_map_set(key_map *map, int key, int pressed);
/* The first that stands for the game's key; -1: nothing does. */
int key_map_shown(const key_map *map, int key);
/* One line of text, and back; what cannot be read leaves every key what it is. */
void key_map_write(const key_map *map, char text[KEY_MAP_TEXT]);
void key_map_read(key_map *map, const char *text);

#endif
