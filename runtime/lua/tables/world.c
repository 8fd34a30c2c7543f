/* Rays, gravity, time, random numbers, and the life of the game. */
#include "lua/api.h"

#include "common/util.h"

#include <float.h>
#include <math.h>

/* ---- rays ---- */

static int push_hit(lua_State *L, const daft_ray_hit *hit)
{
    lua_createtable(L, 0, 6);
    api_push_entity(L, hit->entity.id);
    lua_setfield(L, -2, "entity");
    lua_pushnumber(L, (double)hit->distance);
    lua_setfield(L, -2, "distance");
    api_push_vec3(L, hit->position.x, hit->position.y, hit->position.z);
    lua_setfield(L, -2, "position");
    api_push_vec3(L, (double)hit->normal.x, (double)hit->normal.y, (double)hit->normal.z);
    lua_setfield(L, -2, "normal");
    lua_pushinteger(L, (lua_Integer)hit->triangle + 1);
    lua_setfield(L, -2, "triangle");
    return 1;
}

static int raycast(lua_State *L, host *h)
{
    daft_dvec3 from = api_place(L, h, 1, "from");
    daft_vec3 direction = api_vec3(L, h, 2, "direction");
    if (direction.x == 0 && direction.y == 0 && direction.z == 0) api_error(L, h, "direction: it has no length");
    float far_limit = FLT_MAX;
    if (!lua_isnoneornil(L, 3)) far_limit = api_float(L, h, 3, "max_distance");
    if (!(far_limit > 0)) api_wrong(L, h, 3, "max_distance", "number above 0");
    daft_entity ignore = {0};
    if (!lua_isnoneornil(L, 4)) ignore = api_entity_at(L, h, 4, "ignore");
    daft_ray_hit hit;
    daft_error error = {0};
    if (daft_scene_cast_ray(h->def.scene, from, direction, far_limit, ignore, &hit, &error)) return push_hit(L, &hit);
    if (error.code != DAFT_OK) api_engine_error(L, h, &error);
    lua_pushnil(L);
    return 1;
}

/* ---- time and chance ---- */

static int gravity(lua_State *L, host *h)
{
    daft_scene_set_gravity(h->def.scene, api_triple(L, h, 1, "gravity"));
    return 0;
}

static int time_now(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)h->tick / 60.0);
    return 1;
}

static int tick(lua_State *L, host *h)
{
    lua_pushinteger(L, (lua_Integer)h->tick);
    return 1;
}

/* 0 .. span, each equally likely: values of the smallest mask that holds the span, until one fits. */
static uint64_t pick(random_state *state, uint64_t span)
{
    uint64_t mask = span;
    for (int shift = 1; shift < 64; shift *= 2) mask |= mask >> shift;
    uint64_t value;
    do value = random_next(state) & mask;
    while (value > span);
    return value;
}

static int random_number(lua_State *L, host *h)
{
    random_state *state = h->picture ? &h->draw_random : &h->random;
    int count = lua_gettop(L);
    if (count == 0) {
        lua_pushnumber(L, (double)(random_next(state) >> 11) * 0x1p-53);
        return 1;
    }
    lua_Integer low = count > 1 ? api_whole(L, h, 1, "low") : 1, high = api_whole(L, h, count > 1 ? 2 : 1, "high");
    if (low > high)
        api_error(L, h, "high: a number of %lld or more expected, got %lld", (long long)low, (long long)high);
    lua_pushinteger(L, (lua_Integer)((uint64_t)low + pick(state, (uint64_t)high - (uint64_t)low)));
    return 1;
}

static int random_reseed(lua_State *L, host *h)
{
    random_seed(&h->random, lua_isnone(L, 1) ? h->def.seed : (uint64_t)api_whole(L, h, 1, "seed"));
    return 0;
}

/* ---- life ---- */

static int quit(lua_State *L, host *h)
{
    (void)L;
    h->quit = true;
    return 0;
}

static int restart(lua_State *L, host *h)
{
    (void)L;
    h->restart = true;
    return 0;
}

static int load_scene(lua_State *L, host *h)
{
    const char *name = api_text(L, h, 1, "file");
    char path[PATH_SIZE];
    daft_error error;
    if (!host_find_file(h, name, path, sizeof path, &error)) api_engine_error(L, h, &error);
    if (!daft_scene_load(h->def.scene, path, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int quality(lua_State *L, host *h)
{
    static const char *const NAMES[] = {"target_ms"};
    api_fields(L, h, 1, NULL, NAMES, COUNT_OF(NAMES));
    if (!api_field(L, 1, "target_ms")) return 0;
    const double ms = api_number(L, h, -1, "target_ms");
    if (ms != 0 && !(ms >= 1 && ms <= 1000)) api_wrong(L, h, -1, "target_ms", "number from 1 to 1000, or 0");
    h->target_ms = ms;
    return 0;
}

static const api_function FUNCTIONS[] = {
    {"raycast", "(from, direction [, max_distance [, ignore]]) -> hit or nil",
     "The nearest visible entity along a ray: {entity =, distance =, position =, normal =, triangle =}.\n"
     "from may be an entity; ignore is one that the ray passes through.",
     raycast, 0},
    {"gravity", "(x, y, z)", "In m/s²; 0, -9.81, 0 unless set.", gravity, API_CHANGES},
    {"time", "() -> seconds", "Of the game: ticks / 60.", time_now, 0},
    {"tick", "() -> number", "Updates since the game began.", tick, 0},
    {"random", "([m [, n]]) -> number",
     "0 <= x < 1; or a whole number from 1 to m, or from m to n. The same in every run with the same seed;\n"
     "math.random is the same function. Within daft.draw it draws from a sequence of its own.",
     random_number, 0},
    {"randomseed", "([seed])", "Starts the sequence again; math.randomseed is the same function.", random_reseed,
     API_CHANGES},
    {"scene", "(\"file.scene\")", "Adds what a scene file describes.", load_scene, API_CHANGES},
    {"quality", "{target_ms =}",
     "Asks for frames that take at most so many milliseconds, by pictures that are less exact where they\n"
     "must be; 0: whatever they take. What the player asked for goes first. Nothing else changes.",
     quality, 0},
    {"restart", "()", "Starts the game afresh after this tick.", restart, API_CHANGES},
    {"quit", "()", "Ends the game after this tick.", quit, API_CHANGES},
};

const api_area api_world = {"World", FUNCTIONS, COUNT_OF(FUNCTIONS)};
