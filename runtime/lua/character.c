/* daft.character: a capsule that walks about. */
#include "lua/body.h"

#include "common/util.h"

static const char *const FIELDS[] = {"position",     "entity",           "radius",  "height", "step",  "slope",
                                     "acceleration", "air_acceleration", "gravity", "mass",   "force", "layer",
                                     "hits"};

static void read_sizes(lua_State *L, host *h, daft_character_def *def)
{
    struct {
        const char *name;
        float *value;
    } numbers[] = {{"radius", &def->radius},
                   {"height", &def->height},
                   {"step", &def->step_height},
                   {"slope", &def->max_slope},
                   {"acceleration", &def->acceleration},
                   {"air_acceleration", &def->air_acceleration},
                   {"gravity", &def->gravity_scale},
                   {"mass", &def->mass},
                   {"force", &def->push_force}};
    for (size_t i = 0; i < COUNT_OF(numbers); i++)
        if (api_field(L, 1, numbers[i].name)) *numbers[i].value = api_float(L, h, -1, numbers[i].name);
}

static int create(lua_State *L, host *h)
{
    api_fields(L, h, 1, NULL, FIELDS, COUNT_OF(FIELDS));
    luaL_checkstack(L, COUNT_OF(FIELDS) + 8, NULL);
    daft_character_def def = daft_default_character_def();
    if (api_field(L, 1, "entity")) {
        def.entity = api_entity_at(L, h, -1, "entity");
        def.position = api_place(L, h, -1, "entity");
    }
    if (api_field(L, 1, "position")) def.position = api_place(L, h, -1, "position");
    if (api_field(L, 1, "layer")) def.layers = api_layers(L, h, -1, "layer");
    if (api_field(L, 1, "hits")) def.mask = api_layers(L, h, -1, "hits");
    read_sizes(L, h, &def);
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
    {"character", "{position =, entity =, radius =, height =, ...} -> character",
     "A capsule that walks, climbs steps and slopes, slides along walls, rides, jumps, and pushes bodies.\n"
     "Also: step, slope (radians), acceleration, air_acceleration, gravity (a factor), mass, force, layer, hits. "
     "entity follows it.",
     create, API_CHANGES},
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
