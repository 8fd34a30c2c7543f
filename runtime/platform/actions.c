/* Actions, and the player's own keys for them. */
#include "platform/actions.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

_Static_assert((int)KEY_MAP_INPUTS < (int)KEY_MAP_NONE, "a number fits into a byte");

enum { FIRST_TRIGGER = 4 }; /* of the sticks: these have one half */
/* Of a half that presses a key: where it does, and where it lets go again. */
static const float PRESSES = 0.5f, LETS_GO = 0.4f;

bool action_input_parse(const char *text, action_input *out)
{
    const bool sign = (text[0] == '+' || text[0] == '-') && text[1];
    const char *name = sign ? text + 1 : text;
    *out = (action_input){.index = input_key_find(name), .sign = sign && text[0] == '-' ? -1 : 1};
    if (out->index >= 0) return true;
    *out = (action_input){.stick = true, .index = input_stick_find(name), .sign = !sign ? 0 : text[0] == '-' ? -1 : 1};
    return out->index >= 0;
}

const action *actions_find(const actions *all, const char *name)
{
    for (int i = 0; i < all->count; i++)
        if (strcmp(all->list[i].name, name) == 0) return &all->list[i];
    return NULL;
}

action *actions_set(actions *all, const char *name)
{
    int i = 0;
    while (i < all->count && strcmp(all->list[i].name, name) != 0) i++;
    if (strlen(name) >= ACTION_NAME || i == ACTIONS) return NULL;
    if (i == all->count) all->count++;
    all->list[i] = (action){.count = 0};
    snprintf(all->list[i].name, ACTION_NAME, "%s", name);
    return &all->list[i];
}

static float value_of(const action_input *in, const input *state, const float *sticks)
{
    if (!in->stick) return state->down[in->index] ? (float)in->sign : 0;
    const float value = sticks[in->index];
    if (in->sign == 0) return value;
    return (float)in->sign * value > 0 ? (float)in->sign * value : 0;
}

float action_value(const action *a, const input *state)
{
    float sum = 0;
    for (int i = 0; i < a->count; i++) sum += value_of(&a->inputs[i], state, state->stick);
    return sum > 1 ? 1 : sum < -1 ? -1 : sum;
}

static bool is_down(const action_input *in, const input *state, const float *sticks)
{
    const float value = value_of(in, state, sticks);
    return value >= 0.5f || value <= -0.5f;
}

bool action_down(const action *a, const input *state)
{
    for (int i = 0; i < a->count; i++)
        if (is_down(&a->inputs[i], state, state->stick)) return true;
    return false;
}

/* Whether one of its inputs has gone down, or up, in this tick. */
static bool changed(const action *a, const input *state, const bool *keys, bool down)
{
    for (int i = 0; i < a->count; i++) {
        const action_input *in = &a->inputs[i];
        if (!in->stick && keys[in->index]) return true;
        if (in->stick && is_down(in, state, state->stick) == down && is_down(in, state, state->stick_before) != down)
            return true;
    }
    return false;
}

bool action_pressed(const action *a, const input *state) { return changed(a, state, state->pressed, true); }
bool action_released(const action *a, const input *state) { return changed(a, state, state->released, false); }

/* ---- the player's keys ---- */

int key_map_half(int stick, bool negative) { return INPUT_KEYS + 2 * stick + negative; }

int key_map_of(const action_input *in) { return in->stick ? key_map_half(in->index, in->sign < 0) : in->index; }

bool key_map_is_whole(const action_input *in) { return in->stick && in->sign == 0 && in->index < FIRST_TRIGGER; }

int key_map_stick(int half) { return (half - INPUT_KEYS) / 2; }

static bool is_half(int number) { return number >= INPUT_KEYS && number < KEY_MAP_INPUTS; }
static bool is_negative(int half) { return (half - INPUT_KEYS) % 2 != 0; }
/* The same stick's other half. */
static int other_half(int half) { return key_map_half(key_map_stick(half), !is_negative(half)); }

void key_map_reset(key_map *map)
{
    for (int i = 0; i < KEY_MAP_INPUTS; i++) map->to[i] = (uint8_t)i;
}

static void forget(key_map *map, int asked)
{
    for (int i = 0; i < KEY_MAP_INPUTS; i++)
        if (map->to[i] == asked) map->to[i] = KEY_MAP_NONE;
}

void key_map_set(key_map *map, int asked, int moved)
{
    forget(map, asked);
    map->to[moved] = (uint8_t)asked;
}

void key_map_set_stick(key_map *map, int stick, int moved)
{
    const int asked = key_map_half(stick, false);
    forget(map, asked);
    forget(map, other_half(asked));
    map->to[moved] = (uint8_t)asked, map->to[other_half(moved)] = (uint8_t)other_half(asked);
}

int key_map_shown(const key_map *map, int asked)
{
    for (int i = 0; i < KEY_MAP_INPUTS; i++)
        if (map->to[i] == asked) return i;
    return -1;
}

/* ---- translating ---- */

static float pushed(const held_inputs *held, int half)
{
    const float value = is_negative(half) ? -held->stick[key_map_stick(half)] : held->stick[key_map_stick(half)];
    return value > 0 ? value : 0;
}

/* Of what stands for the game's half, all together. */
static float amount(const key_map *map, const held_inputs *held, int half)
{
    float sum = 0;
    for (int i = 0; i < KEY_MAP_INPUTS; i++)
        if (map->to[i] == half) sum += is_half(i) ? pushed(held, i) : held->down[i] ? 1.0f : 0.0f;
    return sum < 1 ? sum : 1;
}

static input_event stick_event(const key_map *map, const held_inputs *held, int stick)
{
    const float right = amount(map, held, key_map_half(stick, false)),
                left = amount(map, held, key_map_half(stick, true));
    return (input_event){.kind = INPUT_STICK, .key = stick, .x = right - left};
}

/* What comes of the half's new place. */
static int translate_half(const key_map *map, held_inputs *held, int half, input_event *out)
{
    const int asked = map->to[half];
    if (asked == KEY_MAP_NONE) return 0;
    if (is_half(asked)) {
        *out = stick_event(map, held, key_map_stick(asked));
        return 1;
    }
    const float value = pushed(held, half);
    const bool down = held->down[half] ? value > LETS_GO : value >= PRESSES;
    if (down == held->down[half]) return 0;
    held->down[half] = down;
    *out = (input_event){.kind = INPUT_KEY, .key = asked, .down = down};
    return 1;
}

int key_map_translate(const key_map *map, held_inputs *held, const input_event *event, input_event out[KEY_MAP_EVENTS])
{
    out[0] = *event;
    if (event->kind == INPUT_STICK) {
        if (event->key < 0 || event->key >= INPUT_STICKS || !(event->x >= -1 && event->x <= 1)) return 0;
        held->stick[event->key] = event->x;
        const int right = key_map_half(event->key, false), left = other_half(right);
        int count = translate_half(map, held, right, out);
        const bool same = count > 0 && is_half(map->to[right]) && is_half(map->to[left]) &&
                          key_map_stick(map->to[right]) == key_map_stick(map->to[left]);
        return same || event->key >= FIRST_TRIGGER ? count : count + translate_half(map, held, left, out + count);
    }
    if (event->kind != INPUT_KEY) return 1;
    const int asked = map->to[event->key];
    held->down[event->key] = event->down;
    if (asked == KEY_MAP_NONE) return 0;
    if (is_half(asked))
        out[0] = stick_event(map, held, key_map_stick(asked));
    else
        out[0].key = asked;
    return 1;
}

/* ---- as text ---- */

const char *key_map_name(int number, char out[KEY_MAP_NAME])
{
    size_t count;
    const char *const *sticks = input_stick_names(&count);
    if (is_half(number))
        snprintf(out, KEY_MAP_NAME, "%c%s", is_negative(number) ? '-' : '+', sticks[key_map_stick(number)]);
    else
        snprintf(out, KEY_MAP_NAME, "%s", input_key_name(number) ? input_key_name(number) : "");
    return out;
}

/* Without a keyboard as a US one has it. */
static void label_key(platform *keyboard, const char *key, char out[KEY_MAP_NAME])
{
    static const char *const BUTTONS[] = {"left", "middle", "right"};
    const bool pad = strncmp(key, "pad ", 4) == 0, mouse = strncmp(key, "mouse", 5) == 0;
    if (mouse && key[5] >= '1' && key[5] <= '3')
        snprintf(out, KEY_MAP_NAME, "%s mouse button", BUTTONS[key[5] - '1']);
    else if (mouse || pad || !keyboard || !keyboard->key_label ||
             !keyboard->key_label(keyboard, key, out, KEY_MAP_NAME)) {
        snprintf(out, KEY_MAP_NAME, "%s", key);
        for (size_t i = 0; out[i] && !mouse && !pad; i++)
            if (i == 0 || out[i - 1] == ' ') out[i] = (char)toupper((unsigned char)out[i]);
    }
}

const char *key_map_label(platform *keyboard, int number, bool whole, char out[KEY_MAP_NAME])
{
    static const char *const HALVES[] = {"right", "left", "down", "up"}, *const WHOLES[] = {"← →", "→ ←", "↑ ↓", "↓ ↑"};
    size_t count;
    const char *const *sticks = input_stick_names(&count);
    const int stick = key_map_stick(number), way = 2 * (stick % 2) + is_negative(number);
    if (!is_half(number))
        label_key(keyboard, input_key_name(number) ? input_key_name(number) : "", out);
    else if (stick >= FIRST_TRIGGER)
        snprintf(out, KEY_MAP_NAME, "%s", sticks[stick]);
    else
        snprintf(out, KEY_MAP_NAME, "%s stick %s", stick < 2 ? "left" : "right", (whole ? WHOLES : HALVES)[way]);
    return out;
}

/* Pairs "moved TAB asked" where one does not stand for itself, each ended by a TAB. */
void key_map_write(const key_map *map, char text[KEY_MAP_TEXT])
{
    char moved[KEY_MAP_NAME], asked[KEY_MAP_NAME];
    size_t used = 0;
    text[0] = 0;
    for (int i = 0; i < KEY_MAP_INPUTS; i++) {
        if (map->to[i] == i || !key_map_name(i, moved)[0]) continue;
        if (map->to[i] == KEY_MAP_NONE)
            asked[0] = 0;
        else
            key_map_name(map->to[i], asked);
        const int more = snprintf(text + used, KEY_MAP_TEXT - used, "%s\t%s\t", moved, asked);
        if (more < 0 || used + (size_t)more >= KEY_MAP_TEXT) {
            text[used] = 0;
            return;
        }
        used += (size_t)more;
    }
}

/* What is named up to the next TAB; -1: nothing; -2: there is no such key or half of a stick. */
static int take_name(const char **text)
{
    char name[64];
    action_input in;
    const size_t length = strcspn(*text, "\t");
    if ((*text)[length] != '\t' || length >= sizeof name) return -2;
    memcpy(name, *text, length);
    name[length] = 0;
    *text += length + 1;
    if (length == 0) return -1;
    const int key = input_key_find(name);
    if (key >= 0) return key;
    return action_input_parse(name, &in) && in.stick && in.sign != 0 ? key_map_of(&in) : -2;
}

void key_map_read(key_map *map, const char *text)
{
    key_map_reset(map);
    while (*text) {
        const int moved = take_name(&text), asked = moved >= 0 ? take_name(&text) : -2;
        if (moved < 0 || asked == -2) {
            key_map_reset(map);
            return;
        }
        map->to[moved] = asked < 0 ? KEY_MAP_NONE : (uint8_t)asked;
    }
}
