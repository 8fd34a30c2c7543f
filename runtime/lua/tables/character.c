/* daft.character: a capsule that walks about. */
#include "lua/tables/body.h"
#include "lua/fields.h"

#include "common/util.h"

static void read_layer(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((daft_character_def *)out)->layers = api_layers(L, h, -1, "layer");
}

static void read_hits(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((daft_character_def *)out)->mask = api_layers(L, h, -1, "hits");
}

/* It is where its entity is. */
static void at_entity(lua_State *L, host *h, int table, void *out)
{
    if (api_has_field(L, table, "position") || !api_field(L, table, "entity")) return;
    ((daft_character_def *)out)->position = api_place(L, h, -1, "entity");
    lua_pop(L, 1);
}

static const api_special SPECIALS[] = {{.name = "position",
                                        .value = "{x, y, z} or entity",
                                        .doc = "Of the capsule's centre; where entity is unless given"},
                                       {.name = "entity", .after = at_entity},
                                       {.name = "layer", .read = read_layer, .value = "name or names"},
                                       {.name = "hits", .read = read_hits, .value = "name or names"}};

const api_form api_character_form = {"character", "daft.character", DAFT_STRUCT_CHARACTER_DEF,
                                     -1,          SPECIALS,         COUNT_OF(SPECIALS)};

static int create(lua_State *L, host *h)
{
    daft_character_def def = daft_default_character_def();
    api_read_struct(L, h, 1, NULL, &api_character_form, &def);
    daft_error error;
    daft_character character = daft_character_create(h->def.scene, &def, &error);
    if (character.id == 0) api_engine_error(L, h, &error);
    api_new_handle(L, API_CHARACTER, character.id);
    return 1;
}

static daft_character self(lua_State *L, host *h)
{
    return (daft_character){api_check_handle(L, h, 1, API_CHARACTER, "character")->id};
}

static daft_character_state state_of(lua_State *L, host *h)
{
    daft_character_state state;
    daft_error error;
    if (!daft_character_get(h->def.scene, self(L, h), &state, &error)) api_engine_error(L, h, &error);
    return state;
}

static int done(lua_State *L, host *h, bool success, const daft_error *error)
{
    if (!success) api_engine_error(L, h, error);
    return 0;
}

static int walk(lua_State *L, host *h)
{
    daft_error error;
    daft_vec3 velocity = {api_float(L, h, 2, "x"), 0, api_float(L, h, 3, "z")};
    return done(L, h, daft_character_walk(h->def.scene, self(L, h), velocity, &error), &error);
}

static int jump(lua_State *L, host *h)
{
    daft_error error;
    return done(L, h, daft_character_jump(h->def.scene, self(L, h), api_float(L, h, 2, "speed"), &error), &error);
}

static int position(lua_State *L, host *h)
{
    daft_error error;
    if (!lua_isnone(L, 2)) {
        if (h->picture) api_error(L, h, "not within daft.draw: drawing must not change the game");
        return done(L, h, daft_character_teleport(h->def.scene, self(L, h), api_place(L, h, 2, "position"), &error),
                    &error);
    }
    daft_character_state s = state_of(L, h);
    return api_push_numbers(L, s.position.x, s.position.y, s.position.z);
}

static int velocity(lua_State *L, host *h)
{
    daft_character_state s = state_of(L, h);
    return api_push_numbers(L, (double)s.velocity.x, (double)s.velocity.y, (double)s.velocity.z);
}

static int ground(lua_State *L, host *h)
{
    daft_character_state s = state_of(L, h);
    api_push_entity(L, s.grounded ? s.ground.id : 0);
    lua_pushstring(L, s.crushed ? "crushed" : s.grounded ? "ground" : s.sliding ? "slope" : "air");
    return 2;
}

static int turn(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)state_of(L, h).turn);
    return 1;
}

static int height(lua_State *L, host *h)
{
    daft_error error;
    if (lua_isnone(L, 2)) {
        lua_pushnumber(L, (double)state_of(L, h).height);
        return 1;
    }
    if (h->picture) api_error(L, h, "not within daft.draw: drawing must not change the game");
    bool fits = daft_character_set_height(h->def.scene, self(L, h), api_float(L, h, 2, "height"), &error);
    if (!fits && error.code != DAFT_OK) api_engine_error(L, h, &error);
    lua_pushboolean(L, fits);
    return 1;
}

static int destroy(lua_State *L, host *h)
{
    daft_error error;
    return done(L, h, daft_character_destroy(h->def.scene, self(L, h), &error), &error);
}

static int valid(lua_State *L, host *h)
{
    lua_pushboolean(L, daft_character_is_valid(h->def.scene, self(L, h)));
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"character", "{...} -> character",
     "A capsule that walks, climbs steps and slopes, slides along walls, rides, jumps, and pushes bodies.", create,
     API_CHANGES},
    {"character:walk", "(x, z)", "Walks so from now on, in m/s.", walk, API_CHANGES},
    {"character:jump", "(speed)", "Upwards in m/s, if it stands in this tick.", jump, API_CHANGES},
    {"character:position", "([x, y, z]) -> x, y, z", "Of its middle; with arguments, it is there at once.", position,
     0},
    {"character:velocity", "() -> x, y, z", "In m/s.", velocity, 0},
    {"character:ground", "() -> entity or nil, \"ground\", \"slope\", \"air\" or \"crushed\"",
     "What it stands on, and how: on ground, down a slope that is too steep, in the air, or held with too little room.",
     ground, 0},
    {"character:turn", "() -> radians", "By which what it stands on turned it in the last tick.", turn, 0},
    {"character:height", "([metres]) -> metres or boolean",
     "With an argument it crouches or rises, and says whether there was room.", height, 0},
    {"character:destroy", "()", "Takes it out of the game; its entity stays.", destroy, API_CHANGES},
    {"character:valid", "() -> boolean", "False once it has been destroyed.", valid, 0},
};

const api_area api_character = {"Characters", FUNCTIONS, COUNT_OF(FUNCTIONS)};
