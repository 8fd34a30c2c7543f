/* daft.input: keys, mouse, wheel and gamepad of this tick. Mouse buttons are also keys, named "mouse1" to "mouse5". */
#include "lua/api.h"

#include "common/util.h"

#include <stdio.h>

static int push_state(lua_State *L, host *h, const bool *states)
{
    lua_pushboolean(L, states[api_key(L, h, 1, "key")]);
    return 1;
}

static int down(lua_State *L, host *h) { return push_state(L, h, h->def.keys->down); }
static int pressed(lua_State *L, host *h) { return push_state(L, h, h->def.keys->pressed); }
static int released(lua_State *L, host *h) { return push_state(L, h, h->def.keys->released); }

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
     "Keys have SDL's names in lower case: \"a\", \"left\", \"space\", \"return\", \"left shift\", \"f1\", \"mouse1\".",
     down, 0},
    {"input.pressed", "(key) -> boolean", "It went down in this tick.", pressed, 0},
    {"input.released", "(key) -> boolean", "It went up in this tick.", released, 0},
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
