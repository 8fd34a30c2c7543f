/* daft.input: keys, mouse, wheel and gamepad of this tick. Mouse buttons are also keys, named "mouse1" to "mouse5". */
#include "lua/api.h"

#include "common/util.h"

#include <stdio.h>
#include <string.h>

/* The key that is named, or, with `what` set, the action. */
static int key_or_action(lua_State *L, host *h, const action **what)
{
    *what = lua_type(L, 1) == LUA_TSTRING ? actions_find(&h->actions, lua_tostring(L, 1)) : NULL;
    return *what ? -1 : api_key(L, h, 1, "key");
}

static int push_state(lua_State *L, host *h, const bool *states, bool (*of_action)(const action *, const input *))
{
    const action *what;
    const int key = key_or_action(L, h, &what);
    lua_pushboolean(L, what ? of_action(what, h->def.keys) : states[key]);
    return 1;
}

static int down(lua_State *L, host *h) { return push_state(L, h, h->def.keys->down, action_down); }
static int pressed(lua_State *L, host *h) { return push_state(L, h, h->def.keys->pressed, action_pressed); }
static int released(lua_State *L, host *h) { return push_state(L, h, h->def.keys->released, action_released); }

/* ---- actions ---- */

static void read_input(lua_State *L, host *h, int index, action_input *out)
{
    const char *text = api_text(L, h, index, "input");
    if (action_input_parse(text, out)) return;
    size_t keys, sticks;
    const char *const *key_names = input_key_names(&keys), *const *stick_names = input_stick_names(&sticks);
    const char *bare = text + (text[0] == '+' || text[0] == '-'), *near = nearest_name(bare, key_names, keys);
    if (!near) near = nearest_name(bare, stick_names, sticks);
    if (near) api_error(L, h, "there is no key or stick '%.40s': did you mean '%s'?", text, near);
    api_error(L, h, "there is no key or stick '%.40s': as in \"space\", \"-left\", \"left x\", \"pad a\"", text);
}

static int bind(lua_State *L, host *h)
{
    const char *name = api_text(L, h, 1, "action");
    const int count = lua_gettop(L) - 1;
    action made = {.count = count};
    if (input_key_find(name) >= 0) api_error(L, h, "'%s' is a key: an action needs a name of its own", name);
    if (!name[0] || strlen(name) >= ACTION_NAME)
        api_error(L, h, "a name of 1 to %d bytes expected, got %d", ACTION_NAME - 1, (int)strlen(name));
    if (count < 1 || count > ACTION_INPUTS)
        api_error(L, h, "1 to %d inputs expected, got %d", (int)ACTION_INPUTS, count);
    for (int i = 0; i < count; i++) read_input(L, h, 2 + i, &made.inputs[i]);
    action *place = actions_set(&h->actions, name);
    if (!place) api_error(L, h, "a game has %d actions at most", (int)ACTIONS);
    memcpy(place->inputs, made.inputs, sizeof made.inputs);
    place->count = count;
    return 0;
}

static const action *check_action(lua_State *L, host *h)
{
    const char *names[ACTIONS], *name = api_text(L, h, 1, "action");
    const action *found = actions_find(&h->actions, name);
    if (found) return found;
    for (int i = 0; i < h->actions.count; i++) names[i] = h->actions.list[i].name;
    const char *near = nearest_name(name, names, (size_t)h->actions.count);
    if (near) api_error(L, h, "there is no action '%.40s': did you mean '%s'?", name, near);
    api_error(L, h, "there is no action '%.40s': daft.input.bind makes one", name);
}

static int value_of_action(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)action_value(check_action(L, h), h->def.keys));
    return 1;
}

/* The player's for the first of the action's inputs that is a key or the half of a stick. */
static int key_of_action(lua_State *L, host *h)
{
    const action *a = check_action(L, h);
    for (int i = 0; i < a->count; i++) {
        char name[KEY_MAP_NAME];
        const int asked = key_map_of(&a->inputs[i]), shown = h->def.map ? key_map_shown(h->def.map, asked) : asked;
        if (key_map_is_whole(&a->inputs[i]) || shown < 0) continue;
        lua_pushstring(L, key_map_name(shown, name));
        return 1;
    }
    return 0;
}

static int push_label(lua_State *L, host *h, const action_input *in)
{
    char label[KEY_MAP_NAME];
    const int asked = key_map_of(in), shown = h->def.map ? key_map_shown(h->def.map, asked) : asked;
    if (shown < 0) return 0;
    lua_pushstring(L, key_map_label(h->def.keyboard, shown, key_map_is_whole(in), label));
    return 1;
}

/* Of the first of an action's inputs that the player has something for. */
static int label(lua_State *L, host *h)
{
    const action *a = lua_type(L, 1) == LUA_TSTRING ? actions_find(&h->actions, lua_tostring(L, 1)) : NULL;
    action_input in;
    if (!a) {
        read_input(L, h, 1, &in);
        return push_label(L, h, &in);
    }
    for (int i = 0; i < a->count; i++)
        if (push_label(L, h, &a->inputs[i])) return 1;
    return 0;
}

/* ---- the rest ---- */

static int text(lua_State *L, host *h)
{
    h->text = api_boolean(L, h, 1, "on");
    return 0;
}

static int rumble(lua_State *L, host *h)
{
    const double strength = api_number(L, h, 1, "strength"), seconds = api_number(L, h, 2, "seconds");
    if (strength < 0 || strength > 1) api_wrong(L, h, 1, "strength", "number from 0 to 1");
    if (!(seconds > 0) || seconds > 10) api_wrong(L, h, 2, "seconds", "number above 0, up to 10");
    h->rumble = (float)strength, h->rumble_seconds = seconds;
    return 0;
}

static int axis(lua_State *L, host *h)
{
    const input *keys = h->def.keys;
    int negative = api_key(L, h, 1, "negative"), positive = api_key(L, h, 2, "positive");
    lua_pushinteger(L, (lua_Integer)keys->down[positive] - (lua_Integer)keys->down[negative]);
    return 1;
}

static int stick(lua_State *L, host *h)
{
    size_t count;
    char hint[HINT_SIZE];
    const char *const *names = input_stick_names(&count);
    const char *name = lua_type(L, 1) == LUA_TSTRING ? lua_tostring(L, 1) : NULL;
    if (!name) api_wrong(L, h, 1, "name", "name of a stick, as \"left x\",");
    int index = input_stick_find(name);
    if (index < 0) api_error(L, h, "there is no stick '%.40s'%s", name, did_you_mean(hint, "", name, names, count));
    lua_pushnumber(L, (double)h->def.keys->stick[index]);
    return 1;
}

static int set(lua_State *L, host *h)
{
    int key = api_key(L, h, 1, "key");
    bool is_down = api_boolean(L, h, 2, "down");
    if (!h->replaying) input_push(h->def.keys, &(input_event){.kind = INPUT_KEY, .key = key, .down = is_down});
    return 0;
}

static int mouse(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)h->def.keys->mouse_x);
    lua_pushnumber(L, (double)h->def.keys->mouse_y);
    return 2;
}

static int button(lua_State *L, host *h, const bool *states)
{
    lua_Integer number = api_whole(L, h, 1, "button");
    if (number < 1 || number > 5) api_wrong(L, h, 1, "button", "number from 1 (left) to 5");
    char name[8];
    snprintf(name, sizeof name, "mouse%d", (int)number);
    lua_pushboolean(L, states[input_key_find(name)]);
    return 1;
}

static int mouse_down(lua_State *L, host *h) { return button(L, h, h->def.keys->down); }
static int mouse_pressed(lua_State *L, host *h) { return button(L, h, h->def.keys->pressed); }
static int mouse_released(lua_State *L, host *h) { return button(L, h, h->def.keys->released); }

static int wheel(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)h->def.keys->wheel_x);
    lua_pushnumber(L, (double)h->def.keys->wheel_y);
    return 2;
}

static int motion(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)h->def.keys->motion_x);
    lua_pushnumber(L, (double)h->def.keys->motion_y);
    return 2;
}

static int grab(lua_State *L, host *h)
{
    h->grab = api_boolean(L, h, 1, "grab");
    return 0;
}

static const api_function FUNCTIONS[] = {
    {"input.down", "(key) -> boolean",
     "Keys have SDL's names in lower case: \"a\", \"left\", \"space\", \"return\", \"left shift\", \"f1\", "
     "\"mouse1\".\n"
     "Letters, digits and signs are places: \"a\" is where a US keyboard has its A; daft.input.label tells what is "
     "there.",
     down, 0},
    {"input.pressed", "(key) -> boolean", "It went down in this tick.", pressed, 0},
    {"input.released", "(key) -> boolean", "It went up in this tick.", released, 0},
    {"input.bind", "(action, input, ...)",
     "Names what the player does, by up to 8 keys, buttons and sticks: daft.input.bind(\"walk\", \"right\", "
     "\"-left\",\n"
     "\"left x\"). A key counts as 1, with a minus before it as -1; of a stick, \"+left x\" is the right half. down,\n"
     "pressed and released take an action's name too. The pause menu lets players choose others.",
     bind, API_CHANGES},
    {"input.action", "(action) -> number", "The sum of its inputs, -1 to 1.", value_of_action, 0},
    {"input.key_of", "(action) -> key or nil",
     "The player's key for it, or half of a stick, \"+left x\": to be shown. It differs from player to player, so "
     "only\n"
     "within daft.draw.",
     key_of_action, API_DRAWS},
    {"input.label", "(input) -> string or nil",
     "What is printed on the player's key for an action, a key or a stick: \"Q\" for \"a\" on a French keyboard, "
     "\"left\n"
     "stick up\". nil: the player has nothing for it. Only within daft.draw.",
     label, API_DRAWS},
    {"input.text", "(on)", "daft.textinput(letter) hears of each letter that is typed, as UTF-8. It is recorded.", text,
     API_CHANGES},
    {"input.rumble", "(strength, seconds)", "Shakes the gamepads: 0 to 1, up to 10 seconds.", rumble, API_CHANGES},
    {"input.axis", "(negative, positive) -> -1, 0 or 1", "Two keys as an axis.", axis, 0},
    {"input.stick", "(name) -> number",
     "A gamepad's: \"left x\", \"left y\", \"right x\", \"right y\", -1 to 1, right and down positive; \"left "
     "trigger\",\n"
     "\"right trigger\", 0 to 1. Its buttons are keys: \"pad a\", \"pad start\", \"pad left shoulder\", \"pad up\".",
     stick, 0},
    {"input.set", "(key, down)", "Presses or releases a key from the next tick on: for bots. It is recorded.", set,
     API_CHANGES},
    {"input.mouse.down", "(button) -> boolean", "1 is left, 2 middle, 3 right.", mouse_down, 0},
    {"input.mouse.pressed", "(button) -> boolean", "It went down in this tick.", mouse_pressed, 0},
    {"input.mouse.released", "(button) -> boolean", "It went up in this tick.", mouse_released, 0},
    {"input.mouse.wheel", "() -> x, y", "Notches turned in this tick; up and right are positive.", wheel, 0},
    {"input.mouse.grab", "(on)", "Hides the mouse and keeps it in the window, to look around with its motion.", grab,
     API_CHANGES},
    {"input.mouse.motion", "() -> x, y", "HUD units it went right and down in this tick, while it is grabbed.", motion,
     0},
    {"input.mouse", "() -> x, y", "In HUD units from the top left: 0, 0 to daft.width(), daft.height().", mouse, 0},
};

const api_area api_input = {"Input", FUNCTIONS, COUNT_OF(FUNCTIONS)};
