/* Actions, and the player's own keys for them. */
#include "platform/actions.h"

#include <stdio.h>
#include <string.h>

_Static_assert((int)INPUT_KEYS < (int)KEY_MAP_NONE, "a key fits into a byte");

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

void key_map_reset(key_map *map)
{
    for (int key = 0; key < INPUT_KEYS; key++) map->to[key] = (uint8_t)key;
}

void key_map_set(key_map *map, int key, int pressed)
{
    for (int i = 0; i < INPUT_KEYS; i++)
        if (map->to[i] == key) map->to[i] = KEY_MAP_NONE;
    map->to[pressed] = (uint8_t)key;
}

int key_map_shown(const key_map *map, int key)
{
    for (int i = 0; i < INPUT_KEYS; i++)
        if (map->to[i] == key) return i;
    return -1;
}

/* Pairs "pressed TAB key" where a key is not itself, each ended by a TAB. */
void key_map_write(const key_map *map, char text[KEY_MAP_TEXT])
{
    size_t used = 0;
    text[0] = 0;
    for (int i = 0; i < INPUT_KEYS && input_key_name(i); i++) {
        const char *key = map->to[i] == KEY_MAP_NONE ? "" : input_key_name(map->to[i]);
        if (map->to[i] == i) continue;
        const int more = snprintf(text + used, KEY_MAP_TEXT - used, "%s\t%s\t", input_key_name(i), key);
        if (more < 0 || used + (size_t)more >= KEY_MAP_TEXT) {
            text[used] = 0;
            return;
        }
        used += (size_t)more;
    }
}

/* The key whose name ends at the next TAB; -1: none; -2: no name of a key. */
static int take_name(const char **text)
{
    char name[64];
    const size_t length = strcspn(*text, "\t");
    if ((*text)[length] != '\t' || length >= sizeof name) return -2;
    memcpy(name, *text, length);
    name[length] = 0;
    *text += length + 1;
    const int key = input_key_find(name);
    return length == 0 ? -1 : key < 0 ? -2 : key;
}

void key_map_read(key_map *map, const char *text)
{
    key_map_reset(map);
    while (*text) {
        const int pressed = take_name(&text), key = pressed >= 0 ? take_name(&text) : -2;
        if (pressed < 0 || key == -2) {
            key_map_reset(map);
            return;
        }
        map->to[pressed] = key < 0 ? KEY_MAP_NONE : (uint8_t)key;
    }
}
