/* Actions: names that a game gives to keys, buttons and sticks; and the player's own keys and sticks for them.
 * What the player moves is turned into what the game asks for before anything else hears of it, so recordings hold the
 * game's keys, and a replay is the same whatever the player has chosen. */
#ifndef RUNTIME_PLATFORM_ACTIONS_H
#define RUNTIME_PLATFORM_ACTIONS_H

#include "platform/platform.h"

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

/* ---- the player's keys ----
 * What a player moves and what a game asks for have the same numbers: keys, then the halves of sticks. A half that
 * stands for a key presses it beyond the middle of its way; a key that stands for a half pushes it to its end. */

enum {
    KEY_MAP_INPUTS = INPUT_KEYS + 2 * INPUT_STICKS,
    KEY_MAP_NONE = 255,
    KEY_MAP_TEXT = 4096,
    KEY_MAP_EVENTS = 2, /* of the game's that come of one of the player's, at most */
    KEY_MAP_NAME = 48
};

typedef struct key_map {
    uint8_t to[KEY_MAP_INPUTS]; /* the game's, or KEY_MAP_NONE */
} key_map;

/* What the player holds. */
typedef struct held_inputs {
    bool down[KEY_MAP_INPUTS]; /* of halves: those that press a key */
    float stick[INPUT_STICKS];
} held_inputs;

/* The number of a stick's half. */
int key_map_half(int stick, bool negative);
/* That of an action's input; of a whole stick its positive half. Triggers have no other. */
int key_map_of(const action_input *in);
bool key_map_is_whole(const action_input *in);
int key_map_stick(int half);

void key_map_reset(key_map *map);
/* From here on `moved` stands for the game's `asked`, and what stood for it before stands for nothing. */
void key_map_set(key_map *map, int asked, int moved);
/* The same for a whole stick: `moved` is the half that stands for the positive one. */
void key_map_set_stick(key_map *map, int stick, int moved);
/* The first that stands for the game's; -1: nothing does. */
int key_map_shown(const key_map *map, int asked);
/* The game's events that come of one of the player's; how many. */
int key_map_translate(const key_map *map, held_inputs *held, const input_event *event, input_event out[KEY_MAP_EVENTS]);
/* As daft.input.bind has it: "space", "+left x". */
const char *key_map_name(int number, char out[KEY_MAP_NAME]);
/* As players read it: what is printed on the key on their keyboard (which may be NULL), "left mouse button", "left
 * stick up"; of a `whole` stick, whose positive half `number` is, "left stick ← →". */
const char *key_map_label(platform *keyboard, int number, bool whole, char out[KEY_MAP_NAME]);
/* One line of text, and back; what cannot be read leaves every key what it is. */
void key_map_write(const key_map *map, char text[KEY_MAP_TEXT]);
void key_map_read(key_map *map, const char *text);

#endif
